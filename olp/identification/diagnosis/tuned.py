"""With which share of the written speeds and accelerations the judged simulation seems to have been run.

Somebody may have tuned it: an override or another acceleration that makes totals agree is in its durations, not in the
program. Terms act on the motion that the simulation had, so that share has to be known.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Mask = NDArray[np.bool_]

_FEWEST = 8  # plain moves
_MOST = 4.0  # times faster or slower
_GRID = 161
_REFINED = 40  # halvings' worth of a golden section
_SHARES = (0.8, 0.95)  # of the moves that have to agree; few may be long enough to reach their speed
_BETTER = 0.2  # of the written values' misfit: what tuning has to leave at most
_LEAST = 2e-4  # [s] misfits below are digits


def tuned(way: Floats, speed: Floats, slow: Floats, sim: Floats, plain: Mask) -> tuple[float, float]:
    """Share of the speeds and of the accelerations `slow` (n,) [m/s²] (nan: not written) in the simulated times `sim`.

    (1, 1) where the written values do, or where no two shares do either. `plain`: straight moves between exact stops.
    """
    good = plain & np.isfinite(sim) & (way > 0) & (sim > 0) & np.isfinite(speed)
    if good.sum() < _FEWEST:
        return 1.0, 1.0
    way, speed, sim = way[good], speed[good], sim[good]
    written = bool(np.isfinite(slow[good]).all())
    slow = slow[good] if written else np.ones(int(good.sum()))
    for share in _SHARES:
        found = _tuned(way, speed, slow, sim, written, share)
        if found != (1.0, 1.0):
            return found
    return 1.0, 1.0


def _tuned(
    way: Floats, speed: Floats, slow: Floats, sim: Floats, written: bool, share: float
) -> tuple[float, float]:
    """So that a `share` of the moves agree."""

    def misfit(faster: float, stronger: float) -> float:
        return float(np.quantile(np.abs(trapezoid(way, faster * speed, stronger * slow) - sim), share))

    def stronger_of(faster: float) -> float:
        return _stronger(way, faster * speed, slow, sim)

    plainly = misfit(1.0, 1.0 if written else stronger_of(1.0))
    if plainly <= _LEAST:
        return 1.0, 1.0
    tried = list[tuple[float, float]]()
    if written:
        tried += [(1.0, stronger_of(1.0)), (_best(lambda f: misfit(f, 1.0)), 1.0)]
    both = _best(lambda f: misfit(f, stronger_of(f)))
    tried.append((both, stronger_of(both)))
    exact = [t for t in tried if misfit(*t) <= _LEAST]
    faster, stronger = exact[0] if exact else min(tried, key=lambda t: misfit(*t))
    if misfit(faster, stronger) >= _BETTER * plainly:
        return 1.0, 1.0
    return faster, stronger if written else 1.0


def trapezoid(way: Floats, speed: Floats, slow: Floats) -> Floats:
    """(n,) [s] between two stops at constant acceleration."""
    ramp = speed / slow
    return np.asarray(np.where(way >= speed * ramp, way / speed + ramp, 2.0 * np.sqrt(way / slow)))


def _stronger(way: Floats, speed: Floats, slow: Floats, sim: Floats) -> float:
    """The share of `slow` that the middle move says; long ramps tell it best."""
    over = sim - way / speed
    with np.errstate(divide="ignore", invalid="ignore"):
        own = np.where(over <= way / speed, speed / over, 4.0 * way / sim**2) / slow
    good = (over > 0) & np.isfinite(own)
    if not good.any():
        return 1.0
    order = np.argsort(own[good])
    weight = np.cumsum(over[good][order])
    return float(own[good][order][np.searchsorted(weight, 0.5 * weight[-1])])


def _best(misfit: Callable[[float], float]) -> float:
    """By a grid and a golden section about its best place, in logarithms."""
    grid = np.exp(np.linspace(-np.log(_MOST), np.log(_MOST), _GRID))
    at = int(np.argmin([misfit(f) for f in grid.tolist()]))
    low, high = grid[max(at - 1, 0)], grid[min(at + 1, _GRID - 1)]
    for _ in range(_REFINED):
        one, two = low + 0.382 * (high - low), high - 0.382 * (high - low)
        low, high = (low, two) if misfit(float(one)) < misfit(float(two)) else (one, high)
    return float(0.5 * (low + high))
