"""What something along the way is over the ramps of the judged simulation."""

from __future__ import annotations

import numpy as np

from olp.timing.physics._case import Floats, MeasuredMoves
from olp.timing.physics._motion import Motion


def ramp_weights(case: MeasuredMoves, places: int, end: int) -> Floats:
    """(n, m) weights, summing to 1, of places along the way in the ramp at the start (0) or end (1).

    While speed grows from rest, the time spent at a place is one over the square root of the way behind it, and the
    speed gained there is the same: so places count by what they add to the speed.
    """

    def work_out() -> Floats:
        share = np.linspace(0.0, 1.0, places)
        share = 1.0 - share if end else share
        slow = case.base.decelerate if end else case.base.accelerate
        ramp = np.clip(case.base.speed**2 / (2 * slow) / np.maximum(case.base.way, 1e-9), 0.02, 0.5)
        step = 0.5 / (places - 1)
        inner = np.sqrt(np.clip((share - step)[None, :], 0.0, ramp[:, None]))
        outer = np.sqrt(np.clip((share + step)[None, :], 0.0, ramp[:, None]))
        weight = outer - inner
        return np.asarray(weight / weight.sum(axis=1)[:, None])

    return case.once(f"ramp weights {places} {end}", work_out)


def over_ramp(case: MeasuredMoves, values: Floats, end: int) -> Floats:
    """(n, …) mean over the ramp of values (n, m, …) along the way."""
    weight = ramp_weights(case, values.shape[1], end)
    return np.asarray(np.einsum("nm,nm...->n...", weight, values))


# Shares of the full speed at which a ramp is looked at.
PASSED = (np.arange(10) + 0.5) / 10


def where_passed(case: MeasuredMoves, values: Floats, end: int) -> Floats:
    """(n, k) of values (n, m) along the way, where the simulation's ramp at one end passes the speeds of `PASSED`."""
    slow = case.base.decelerate if end else case.base.accelerate
    way = np.maximum(case.base.way, 1e-9)[:, None]
    share = (PASSED * case.base.top()[:, None]) ** 2 / (2.0 * slow[:, None]) / way
    return _at(values, 1.0 - share if end else share)


_WEIGHTS = (1.0 - PASSED) * (2.0 / len(PASSED))


def longer(force: Floats) -> Floats:
    """(n,) by how much a ramp costs more time when only `force` (n, k) of its acceleration is there at `PASSED`.

    Its time less its way at full speed, ∫ (1 - v/V) dv / a(v), over V/2a.
    """
    return slower(1.0 / force)


def slower(over: Floats) -> Floats:
    """(n,) the same where the acceleration that is there is one over `over` (n, k)."""
    return np.asarray(over @ _WEIGHTS)


def pulled(motion: Motion, pull: Floats, least: float) -> Motion:
    """The motion where a `pull` (n, m) along the way, as a share of the acceleration, takes from the ramp at the start
    and gives to the one at the end; `least` of either remains.

    How fast a short move gets, and where a ramp passes a speed, depend on what is left of the ramps: both are worked
    out anew from a first result.
    """
    # Both ramps in one go, one below the other: the search asks for this more often than for anything else.
    force = np.maximum(1.0 + np.concatenate([-pull, pull[:, ::-1]]), least)
    first = _with_force(motion, motion.top(), force)
    return _with_force(motion, first.top(), force)


def _with_force(motion: Motion, top: Floats, force: Floats) -> Motion:
    count = len(motion.way)
    way = np.maximum(np.concatenate([motion.way, motion.way]), 1e-9)
    slow = np.concatenate([motion.accelerate, motion.decelerate])
    ramp = np.concatenate([top, top]) ** 2 / (slow * way)
    both = slow / longer(_passing(force, ramp[:, None]))
    return motion.with_(accelerate=both[:count], decelerate=both[count:])


def _passing(force: Floats, ramp: Floats) -> Floats:
    """(n, k) of `force` (n, m) from the ramp's rest on, where it passes the speeds of `PASSED`; `ramp` (n, 1): twice
    the ramp's share of the way with the whole force (E. Picard's iteration, one step)."""
    steps = ramp * (PASSED / len(PASSED)) / _at(force, 0.5 * ramp * PASSED**2)
    return _at(force, np.cumsum(steps, axis=1) - 0.5 * steps)


def _at(values: Floats, share: Floats) -> Floats:
    """(n, k) of values (n, m) along the way, at shares (n, k) of it."""
    rows, places = values.shape
    place = np.clip(share * (places - 1), 0.0, places - 1)
    low = np.minimum(place.astype(np.int64), places - 2)
    beyond = place - low
    low += np.arange(0, rows * places, places)[:, None]
    flat = values.ravel()  # taking from it is twice as fast as from rows and columns
    here = flat.take(low)
    return np.asarray(here + beyond * (flat.take(low + 1) - here))
