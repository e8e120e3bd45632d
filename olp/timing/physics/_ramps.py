"""Averages over the ramps of the judged simulation of quantities that vary along the path."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from olp.core import compiled_loops
from olp.timing.physics._case import Floats, MeasuredMoves
from olp.timing.physics._motion import Motion


def ramp_weights(case: MeasuredMoves, places: int, end: int) -> Floats:
    """Weights (n, m), summing to 1, of places along the path in the ramp at the start (`end` 0) or at the end (1).

    During a ramp from rest, the time spent at a place and the speed gained there are proportional to one over the
    square root of the distance covered: places count by what they add to the speed.
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
    """Mean (n, …) over the ramp at one end of values (n, m, …) along the path."""
    weight = ramp_weights(case, values.shape[1], end)
    return np.asarray(np.einsum("nm,nm...->n...", weight, values))


# Shares of the full speed at which a ramp is looked at.
PASSED = (np.arange(10) + 0.5) / 10


def where_passed(case: MeasuredMoves, values: Floats, end: int) -> Floats:
    """Values (n, k) where the simulation's ramp at one end passes the speeds of `PASSED`, from values (n, m) along
    the path.
    """
    slow = case.base.decelerate if end else case.base.accelerate
    way = np.maximum(case.base.way, 1e-9)[:, None]
    share = (PASSED * case.base.top()[:, None]) ** 2 / (2.0 * slow[:, None]) / way
    return _at(values, 1.0 - share if end else share)


_WEIGHTS = (1.0 - PASSED) * (2.0 / len(PASSED))


def longer(force: Floats) -> Floats:
    """Factor (n,) on the time of a ramp when only the share `force` (n, k) of its acceleration is available at
    `PASSED`.

    It compares the time beyond the ramp's length at full speed, ∫ (1 - v/V) dv / a(v), with V/2a.
    """
    return slower(1.0 / force)


def slower(over: Floats) -> Floats:
    """The same factor as `longer` (n,), where the acceleration is divided by `over` (n, k)."""
    return np.asarray(over @ _WEIGHTS)


# --- Forces that change with the speed ---

_WAYS = PASSED / len(PASSED)  # that a ramp covers while it passes each of these speeds
_STEPS, _EXACT, _ROUNDED = 25, 1e-6, 1e-6  # of Newton's method at most; shares of a way that are nothing


def per_speed(case: MeasuredMoves, key: str) -> Floats:
    """Highest speed (n,) of the path, or of the fastest axis, per speed of the path; `key`: "path" or "axes"."""
    return case.once(f"fastest {key}", lambda: _fastest(case, key).max(axis=1))


def _fastest(case: MeasuredMoves, key: str) -> Floats:
    """Speed (n, m) of the path, or of the fastest axis (as a share of rated speeds, if known), per speed of the
    path, along the path.
    """
    rates = case.rates
    if key == "path" or rates is None:
        even = 1.0 / case.ratio if key == "path" else np.zeros(len(case))
        return np.repeat(even[:, None], 2, axis=1)
    rated = rates.rated if rates.rated is not None else np.ones(rates.path.shape[2])
    return np.asarray((np.abs(rates.path) / rated).max(axis=2))


def fastest_along(case: MeasuredMoves, key: str) -> Floats:
    """Speed (2, n, k) of the path, or of the fastest axis, per speed of the path, where each ramp of the simulation
    passes the speeds of `PASSED`, times these."""

    def work_out() -> Floats:
        fastest = _fastest(case, key)
        return np.stack([where_passed(case, fastest, end) for end in (0, 1)]) * PASSED

    return case.once(f"fastest {key} along", work_out)


def divided_by_speed(
    motion: Motion, shares: Floats, divided: Callable[[Floats], tuple[Floats, Floats]]
) -> Motion:
    """The motion where the acceleration of each ramp is `divided` by what its speed says.

    `shares` (2, n, k): what that hangs on, per speed of the path, where the ramps at the start and at the end pass
    the speeds of `PASSED`. `divided`: of these times a speed, the divisor and its slope by the logarithm of the speed.
    """
    top = motion.top()
    slows = np.stack([motion.accelerate, motion.decelerate])
    over, _ = divided(shares * top[:, None])
    accelerate, decelerate = slows / slower(over)
    covered = top**2 * (over @ _WAYS / slows).sum(axis=0)
    short = np.nonzero((motion.way > 0) & (covered > (1.0 + _ROUNDED) * motion.way))[0]
    if len(short):
        ways = (motion.way[short], motion.speed[short], top[short])
        accelerate[short] = decelerate[short] = _on_short_ways(
            *ways, shares[:, short], slows[:, short], divided
        )
    leaving, arriving = slows / (accelerate, decelerate)
    return motion.with_(
        accelerate=accelerate,
        decelerate=decelerate,
        leaving=motion.leaving * leaving,
        arriving=motion.arriving * arriving,
    )


def _on_short_ways(
    way: Floats,
    speed: Floats,
    peak: Floats,
    shares: Floats,
    slows: Floats,
    divided: Callable[[Floats], tuple[Floats, Floats]],
) -> Floats:
    """Acceleration (n,) that takes the same total time where both ramps together are longer than the path.

    The less force is left, the longer the path covered at high speed: Newton's method in logarithms finds the speed at
    which both ramps cover the way (n,) [m], from the highest one without jerk on, `peak` (n,) [m/s]. `slows` (2, n):
    the whole acceleration of each ramp; `shares`, `divided`: see `divided_by_speed`.
    """
    low, high = np.zeros(len(way)), peak
    for _ in range(_STEPS):
        over, growth = divided(shares * peak[:, None])
        ramps = (over @ _WAYS / slows).sum(axis=0)
        covered = peak**2 * ramps
        off = np.log(covered / way)
        if np.abs(off).max() <= _EXACT:
            break
        slope = 2.0 + (growth @ _WAYS / slows).sum(axis=0) / ramps
        low, high = np.where(off <= 0, peak, low), np.where(off <= 0, high, peak)
        tried = peak * np.exp(-off / slope)
        tried = np.where((tried > low) & (tried < high), tried, 0.5 * (low + high))
        peak = np.where(np.abs(off) <= _EXACT, peak, tried)
    time = peak * (over.mean(axis=2) / slows).sum(axis=0)
    # What the ramps fall short of the way is passed at the speed that they reach.
    time = time + (way - covered) / np.maximum(peak, 1e-9)
    return np.asarray(
        np.where(2.0 * way <= speed * time, 4.0 * way / time**2, speed / np.maximum(time - way / speed, 1e-9))
    )


# --- Forces that change along the path ---


def pulled(motion: Motion, pull: Floats, least: float) -> Motion:
    """The motion where a `pull` (n, m) along the path, as a share of the acceleration, weakens the ramp at the
    start and strengthens the one at the end; at least the share `least` of either remains.
    """
    return forced(motion, np.maximum(1.0 - pull, least), np.maximum(1.0 + pull, least))


def forced(motion: Motion, up: Floats, down: Floats) -> Motion:
    """The motion where a share of the acceleration is available along the path (n, m), `up` of the ramp at the start
    and `down` of the one at the end.

    The peak speed of a short move, and the places where a ramp passes a speed, depend on the changed ramps: a
    second pass computes both from the result of the first.
    """
    # Both ramps in one go, one below the other: the search asks for this more often than for anything else.
    force, count = np.concatenate([up, down[:, ::-1]]), len(motion.way)
    way, slow = np.maximum(motion.way, 1e-9), np.concatenate([motion.accelerate, motion.decelerate])
    far = slow * np.concatenate([way, way])

    def changed(top: Floats) -> Floats:
        ramp = np.concatenate([top, top]) ** 2 / far
        return slow / longer(_passing(force, ramp[:, None]))

    first = changed(motion.top())
    mean = 0.5 * (1.0 / first[:count] + 1.0 / first[count:])
    both = changed(np.minimum(motion.speed, np.sqrt(way / mean)))
    return motion.with_(accelerate=both[:count], decelerate=both[count:])


def _passing(force: Floats, ramp: Floats) -> Floats:
    """Values (n, k) of `force` (n, m), given from the ramp's rest on, where the ramp passes the speeds of `PASSED`;
    `ramp` (n, 1): twice the ramp's share of the path at full force (one step of E. Picard's iteration).
    """
    if force.shape[1] > 1 and ramp.shape == (len(force), 1) and _LOOPS.worth(len(force)):
        passed = np.empty((len(force), len(PASSED)))
        _compiled_passing(np.ascontiguousarray(force), ramp.ravel(), PASSED, passed)
        return passed
    steps = ramp * (PASSED / len(PASSED)) / _at(force, 0.5 * ramp * PASSED**2)
    return _at(force, np.cumsum(steps, axis=1) - 0.5 * steps)


def _at(values: Floats, share: Floats) -> Floats:
    """Values (n, k) at shares (n, k) of the path, interpolated from values (n, m) along it."""
    rows, places = values.shape
    # In place: new arrays of many moves cost more than what is worked out in them.
    place = share * (places - 1)
    np.maximum(place, 0.0, out=place)
    np.minimum(place, places - 1, out=place)
    low = place.astype(np.int64)
    np.minimum(low, places - 2, out=low)
    place -= low
    low += np.arange(0, rows * places, places)[:, None]
    flat = values.ravel()  # taking from it is twice as fast as from rows and columns
    here = flat.take(low, mode="clip")  # they are within; to see to it takes long
    low += 1
    there = flat.take(low, mode="clip")
    there -= here
    there *= place
    there += here
    return np.asarray(there)


# --- Compiled ---
# The same as `_passing`, to the last bit: a search asks for it tens of thousands of times.

_LOOPS = compiled_loops.Loops(3e-7)  # [s] per ramp that they save, measured


def _between(force: Floats, share: float) -> float:
    """The force at a share of the path, from forces (m,) along it."""
    most = len(force) - 1
    place = share * most
    if place != place:
        return place  # nan
    place = min(max(place, 0.0), float(most))
    low = min(int(place), most - 1)
    return float((force[low + 1] - force[low]) * (place - low) + force[low])


@compiled_loops.kernel(_between)
def _compiled_passing(force: Floats, ramp: Floats, passed: Floats, result: Floats) -> None:
    squares = passed**2
    shares = passed / len(passed)
    for i in range(len(force)):
        gone = 0.0
        for k in range(len(passed)):
            step = ramp[i] * shares[k] / _between(force[i], 0.5 * ramp[i] * squares[k])
            gone += step
            result[i, k] = _between(force[i], gone - 0.5 * step)
