"""Whether straight lines between points of a box can be run: reach, soft limits, singularities, axis speeds.

Looked at along the whole line, with a margin, in one posture of the arm: in front, elbow up, wrist flipped or not.
"""

from __future__ import annotations

from collections import Counter
from itertools import product
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from olp.core.units import deg, mm
from olp.identification.signature.domain import spread_out
from olp.robots.geometry import Pose
from olp.robots.kinematics.configuration import clearance, jacobian, within_limits, without_tool
from olp.robots.kinematics.inverse import inverse
from olp.robots.model import Robot

Floats = NDArray[np.float64]
Bools = NDArray[np.bool_]

# The first six flags of RCONF.
Posture = tuple[int, int, int, int, int, int]
PLAIN: Posture = (0, 0, 0, 0, 0, 0)
FLIPPED: Posture = (1, 0, 0, 0, 0, 0)

# How far every place of a line stays from soft limits and singularities, and from the rated speeds.
LIMIT_MARGIN = 2.0 * deg
WRIST_MARGIN = 5.0 * deg
ELBOW_MARGIN = 5.0 * deg
SHOULDER_MARGIN = 50.0 * mm
SPEED_SHARE = 0.9
# [m] of line between two looks, and looks per line at most; the job as a whole is looked at again, more finely.
_STEP, _MOST = 0.02, 64
_CHUNK = 40_000


class ProbeLines(NamedTuple):
    """n lines. `reason` (n,): why a line cannot be run, "" when it can."""

    possible: Bools
    reason: tuple[str, ...]

    def told(self) -> str:
        """The reasons and how often each, the most frequent first."""
        count = Counter(reason for reason in self.reason if reason)
        return ", ".join(f"{reason} ({number})" for reason, number in count.most_common())


def look(
    robot: Robot,
    start: Floats,
    end: Floats,
    rotation: Floats,
    tool: Pose | None,
    speed: float,
    posture: Posture = PLAIN,
) -> ProbeLines:
    """Lines from `start` to `end` (n, 3) [m] at `speed` [m/s]; `rotation` (3, 3) of the tool. Raises OlpError (K…)."""
    longest = float(np.linalg.norm(end - start, axis=1).max(initial=0.0))
    looks = int(min(_MOST, max(3, np.ceil(longest / _STEP) + 1)))
    reasons: list[str] = []
    step = max(1, _CHUNK // looks)
    for first in range(0, len(start), step):
        part = slice(first, first + step)
        reasons += _look(robot, start[part], end[part], rotation, tool, speed, looks, posture)
    return ProbeLines(np.array([not reason for reason in reasons], dtype=bool), tuple(reasons))


def _look(
    robot: Robot,
    start: Floats,
    end: Floats,
    rotation: Floats,
    tool: Pose | None,
    speed: float,
    looks: int,
    posture: Posture,
) -> list[str]:
    share = np.linspace(0.0, 1.0, looks)[None, :, None]
    count = len(start)
    place = (start[:, None, :] + share * (end - start)[:, None, :]).reshape(-1, 3)
    turned = np.broadcast_to(rotation, (len(place), 3, 3))
    flange, turned = (place, turned) if tool is None else without_tool(place, turned, tool)
    joints, reached = inverse(robot, flange, turned, posture)
    joints = np.where(reached[:, None], joints, 0.0)
    faults: list[tuple[str, Bools]] = [("out of reach", ~reached)]
    faults += _limits(robot, joints, reached)
    near = clearance(robot, joints)
    for name, value, margin in (
        ("near the wrist's singularity", near.wrist, WRIST_MARGIN),
        ("near the stretched or folded elbow", near.elbow, ELBOW_MARGIN),
        ("near the axis of the base", near.shoulder, SHOULDER_MARGIN),
    ):
        faults.append((name, reached & ~(np.abs(value) >= margin)))
    faults += _speeds(robot, joints, reached, np.repeat(_unit(end - start), looks, axis=0), speed)
    reasons = [""] * count
    for name, bad in faults:
        for row in np.nonzero(bad.reshape(count, looks).any(axis=1))[0].tolist():
            reasons[row] = reasons[row] or name
    # Between two looks the arm may not jump to another solution.
    steps = np.abs(np.diff(joints.reshape(count, looks, -1), axis=1)).max(axis=(1, 2))
    for row in np.nonzero(steps > 0.5)[0].tolist():
        reasons[row] = reasons[row] or "the arm would change its posture"
    return reasons


def _limits(robot: Robot, joints: Floats, reached: Bools) -> list[tuple[str, Bools]]:
    inside = within_limits(robot, joints - LIMIT_MARGIN) & within_limits(robot, joints + LIMIT_MARGIN)
    names = robot.axis_names
    return [(f"axis {name} at its soft limit", reached & ~inside[:, i]) for i, name in enumerate(names)]


def _speeds(
    robot: Robot, joints: Floats, reached: Bools, direction: Floats, speed: float
) -> list[tuple[str, Bools]]:
    matrix = jacobian(robot, joints)
    matrix[~reached] = np.eye(6)
    # At a singularity, which is told apart, the rate stays finite.
    square = matrix.transpose(0, 2, 1) @ matrix + 1e-12 * np.eye(6)
    wanted = np.concatenate([direction * speed, np.zeros_like(direction)], axis=1)
    rates = np.linalg.solve(square, matrix.transpose(0, 2, 1) @ wanted[:, :, None])[:, :, 0]
    fast = np.abs(rates) > SPEED_SHARE * np.nan_to_num(robot.speeds, nan=np.inf)
    names = robot.axis_names
    return [(f"axis {name} too slow for that speed", reached & fast[:, i]) for i, name in enumerate(names)]


def _unit(ways: Floats) -> Floats:
    length = np.linalg.norm(ways, axis=1, keepdims=True)
    return np.asarray(ways / np.where(length > 0, length, 1.0))


# --- Candidates ---
# The points of a box and the lines between them that an experiment is chosen from.

Labels = NDArray[np.int64]

# Points inside the box beside its corners, and lines that the choice is made from.
_INSIDE, _CANDIDATES_MOST = 48, 600
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
    if len(starts) > _CANDIDATES_MOST:
        kept = spread_out(np.concatenate([points[starts], points[ends]], axis=1), _CANDIDATES_MOST)
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
