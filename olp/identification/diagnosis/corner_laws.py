"""How the judged simulation passes rounded corners: the law, and its numbers, that come nearest to its durations.

Simulated durations have no scatter, so one law that is right fits all moves to the digits; where none does, the nearest
one only says how corners answer to other ramps.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from olp.timing.physics._motion import EACH, Motion

Floats = NDArray[np.float64]

SOME_ROUNDING = 1e-6  # [m] where a rounding is told, but not its size
_SIZED = ("braking", "share", "distance", "flight")  # laws that need the size of a rounding
_SPLITS = (1.0, 0.5, 0.0)  # of what a corner saves, to the move before it
_REACHES = (0.5, 0.45, 1 / 3, 0.25, 1.0)  # of the shorter move
_OVERLAPS = (0.05, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0, 1.25, 1.5, 2.0)
_DIGITS = 2e-4  # [s] nearer than that, a simulation stops at every corner
_BETTER = 0.9  # times what exact stops are off: less is no law of corners


def cornered(motion: Motion, sim: Floats) -> Motion:
    """`motion` with law, overlap, split and reach from the simulated durations `sim` (n,) [s]."""
    rounded = (motion.round_start > 0) | (motion.round_end > 0)
    if not rounded.any() or _off(motion, sim, rounded) < _DIGITS:
        return motion.with_(law="stop")
    best, least = motion.with_(law="stop"), _BETTER * _off(motion.with_(law="stop"), sim, rounded)
    for tried in _families(motion):
        overlap, off = _nearest(tried, sim, rounded)
        if off < least:
            best, least = tried.with_(overlap=overlap), off
    return best


def _families(motion: Motion) -> list[Motion]:
    sized = bool(motion.round_end.max() > SOME_ROUNDING)
    shared = [("full", 0.5), *((law, reach) for law in _SIZED for reach in _REACHES if sized)]
    own = [
        ("full", 0.5),
        *((law, reach) for law in ("braking", "distance", "radius") for reach in _REACHES if sized),
    ]
    return [
        *(motion.with_(law=law, split=split, reach=reach) for law, reach in shared for split in _SPLITS),
        *(motion.with_(law=law + EACH, split=0.5, reach=reach) for law, reach in own),
    ]


def _nearest(motion: Motion, sim: Floats, rounded: NDArray[np.bool_]) -> tuple[float, float]:
    """Overlap and how far [s] off it is: the best of a grid, then ever nearer around it."""
    offs = [_off(motion.with_(overlap=overlap), sim, rounded) for overlap in _OVERLAPS]
    at = int(np.argmin(offs))
    place, best = _OVERLAPS[at], offs[at]
    step = 0.5 * (_OVERLAPS[min(at + 1, len(_OVERLAPS) - 1)] - _OVERLAPS[max(at - 1, 0)])
    while step > 1e-4:
        for tried in (place - step, place + step):
            off = _off(motion.with_(overlap=tried), sim, rounded) if tried > 0 else np.inf
            if off < best:
                place, best = tried, off
                break
        else:
            step *= 0.5
    return place, best


def _off(motion: Motion, sim: Floats, rounded: NDArray[np.bool_]) -> float:
    """[s] mean distance from the simulation at rounded corners."""
    return float(np.mean(np.abs(motion.duration() - sim)[rounded]))
