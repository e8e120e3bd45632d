"""Accelerations of the judged simulation that nobody wrote down: read off its durations."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Mask = NDArray[np.bool_]

_CONTROLLERS_CYCLE = 1e-6  # [s] less ramp than that is none
_ALIKE = 2e-3  # [1] durations that differ by less are the same simulation
_SIM_DIGITS = 2e-4  # [s] that simulated times may be rounded by
_LEVELS, _MANY = 4, 0.1  # accelerations of one simulation, and the share of the moves that each has at least
_MOST_ALIKE = 0.8  # of the moves have one of them
_FEW = 0.5  # of the moves: more of them are not limited, the simulation has another law


def limited(way: Floats, speed: Floats, sim: Floats, slow: Floats, plain: Mask) -> Mask:
    """(n,) moves between stops that the simulation itself made slower than their acceleration says: an axis' limit."""
    with np.errstate(invalid="ignore"):
        ramp = speed / slow
        said = np.where(way >= speed * ramp, way / speed + ramp, 2.0 * np.sqrt(way / slow))
        off = plain & (sim > said * (1.0 + _ALIKE))
    return np.asarray(off & (off.sum() < _FEW * max(int(plain.sum()), 1)), dtype=bool)


def inferred(way: Floats, speed: Floats, sim: Floats, stops: Mask, resolution: float) -> Floats:
    """(n,) [m/s²] with which a trapezoid takes the simulated time; rows with rounded ends get the others' median."""
    over = sim - way / speed
    full = over <= way / speed
    with np.errstate(divide="ignore", invalid="ignore"):
        slow = np.where(full, speed / over, 4.0 * way / sim**2)
    told = (over > _CONTROLLERS_CYCLE) & np.isfinite(slow)
    if stops.all() or _stops_everywhere(slow, over, told, stops):
        stops = np.ones_like(stops)
    good = stops & told
    if not good.any():
        return np.full(len(way), 1e3 * float(np.median(speed)))
    # Long ramps tell the acceleration best: the median weighted by their length.
    order = np.argsort(slow[good])
    weight = np.cumsum(over[good][order])
    one = float(slow[good][order][np.searchsorted(weight, 0.5 * weight[-1])])
    ramp = speed / one
    said = np.where(way >= speed * ramp, way / speed + ramp, 2.0 * np.sqrt(way / one))
    digits = max(np.nan_to_num(resolution), 1e-4)
    if np.mean(np.abs(said - sim)[stops] <= 1.01 * digits) >= 0.9:
        return np.full(len(way), one)
    return np.where(good, slow, one)


def _stops_everywhere(slow: Floats, over: Floats, told: Mask, stops: Mask) -> bool:
    """Whether moves with rounded ends, taken for moves between stops, have the same few accelerations `slow` as those
    between stops have: then the simulation knows of no rounding."""
    known, asked = told & stops, told & ~stops
    if not asked.any():
        return False
    levels = _levels(slow[known] if known.any() else slow[asked], over[known] if known.any() else over[asked])
    if not 0 < len(levels) <= _LEVELS:
        return False
    near = np.abs(slow[asked][:, None] / levels - 1.0) < _ALIKE + _SIM_DIGITS / over[asked][:, None]
    return bool(near.any(axis=1).mean() >= _MOST_ALIKE)


def _levels(slow: Floats, over: Floats) -> Floats:
    """The accelerations that nearly all of `slow` are, within the digits of simulated times; none when many."""
    left, found = np.ones(len(slow), dtype=bool), list[float]()
    while left.mean() > 1.0 - _MOST_ALIKE and len(found) < _LEVELS:
        near = np.abs(slow[:, None] / slow[left] - 1.0) < _ALIKE + _SIM_DIGITS / over[:, None]
        counts = near[left].sum(axis=0)
        if counts.max() < _MANY * len(slow):
            return np.zeros(0)
        best = slow[left][int(np.argmax(counts))]
        found.append(float(best))
        left &= np.abs(slow / best - 1.0) >= _ALIKE + _SIM_DIGITS / over
    return np.array(found) if left.mean() <= 1.0 - _MOST_ALIKE else np.zeros(0)
