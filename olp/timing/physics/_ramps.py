"""What something along the way is over the ramps of the judged simulation."""

from __future__ import annotations

import numpy as np

from olp.timing.physics._case import Floats, MeasuredMoves


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
    place = (PASSED * case.base.top()[:, None]) ** 2 / (2.0 * slow[:, None]) / way
    place = np.clip(1.0 - place if end else place, 0.0, 1.0) * (values.shape[1] - 1)
    low = np.minimum(place.astype(np.int64), values.shape[1] - 2)
    rows = np.arange(len(values))[:, None]
    return np.asarray(values[rows, low] + (place - low) * (values[rows, low + 1] - values[rows, low]))


_WEIGHTS = (1.0 - PASSED) * (2.0 / len(PASSED))


def longer(force: Floats) -> Floats:
    """(n,) by how much a ramp costs more time when only `force` (n, k) of its acceleration is there at `PASSED`.

    Its time less its way at full speed, ∫ (1 - v/V) dv / a(v), over V/2a.
    """
    return slower(1.0 / force)


def slower(over: Floats) -> Floats:
    """(n,) the same where the acceleration that is there is one over `over` (n, k)."""
    return np.asarray(over @ _WEIGHTS)
