"""The points of a box and the lines between them that an experiment is chosen from."""

from __future__ import annotations

from itertools import product
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from olp.core.units import mm
from olp.identification.probe.reach import FLIPPED, PLAIN, Posture, look
from olp.identification.signature.domain import spread_out

if TYPE_CHECKING:
    from olp.robots.geometry import Pose
    from olp.robots.robot import Robot

Floats = NDArray[np.float64]
Labels = NDArray[np.int64]

# Points inside the box beside its corners, and lines that the choice is made from.
_INSIDE, _MOST = 48, 600
# [m] Points are written to this; a controller shows no more.
_GRID = 0.1 * mm
_BASES = (2, 3, 5)


class CandidateLines(NamedTuple):
    """`points` (p, 3) [m]; `possible` (p, p): lines that can be run; `starts`, `ends` (n,): those to choose from."""

    points: Floats
    possible: NDArray[np.bool_]
    starts: Labels
    ends: Labels
    looked: int  # lines that were looked at
    told: str  # why some cannot be run
    posture: Posture  # the one of two that more lines can be run in


def candidates(
    robot: Robot, box: Floats, rotation: Floats, tool: Pose | None, speed: float, shortest: float
) -> CandidateLines:
    """Lines in `box` (3, 2) [m] at least `shortest` [m] long. Raises OlpError (K…)."""
    points = _points(box)
    count = len(points)
    first, second = np.triu_indices(count, 1)
    both = {
        posture: look(robot, points[first], points[second], rotation, tool, speed, posture)
        for posture in (PLAIN, FLIPPED)
    }
    posture = max(both, key=lambda one: int(both[one].possible.sum()))
    lines = both[posture]
    possible = np.zeros((count, count), dtype=bool)
    possible[first, second] = possible[second, first] = lines.possible
    usable = possible & _joined(possible)
    apart = np.linalg.norm(points[:, None] - points[None], axis=2)
    starts, ends = np.nonzero(usable & (apart >= shortest))
    if len(starts) > _MOST:
        kept = spread_out(np.concatenate([points[starts], points[ends]], axis=1), _MOST)
        starts, ends = starts[kept], ends[kept]
    return CandidateLines(
        points, possible, starts.astype(np.int64), ends.astype(np.int64), len(first), lines.told(), posture
    )


def _points(box: Floats) -> Floats:
    """(p, 3) [m] The corners of the box, and points that fill it evenly (J. H. Halton 1960)."""
    corners = np.array(list(product(*box)))
    filled = np.array([[_radical(i, base) for base in _BASES] for i in range(1, _INSIDE + 1)])
    inner = box[:, 0] + filled * (box[:, 1] - box[:, 0])
    rounded = np.round(np.concatenate([corners, inner]) / _GRID) * _GRID
    return np.unique(np.clip(rounded, box[:, 0], box[:, 1]), axis=0)


def _radical(number: int, base: int) -> float:
    result, share = 0.0, 1.0 / base
    while number:
        number, digit = divmod(number, base)
        result += digit * share
        share /= base
    return result


def _joined(possible: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """(p, p): pairs in the largest set of points that can all be reached from each other."""
    count = len(possible)
    label = np.full(count, -1)
    for seed in range(count):
        if label[seed] >= 0:
            continue
        ring = np.zeros(count, dtype=bool)
        ring[seed] = True
        while True:
            wider = ring | possible[ring].any(axis=0)
            if np.array_equal(wider, ring):
                break
            ring = wider
        label[ring] = seed
    largest = int(np.argmax(np.bincount(label))) if count else 0
    member = label == largest
    return np.asarray(member[:, None] & member[None, :])
