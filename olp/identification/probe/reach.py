"""Whether straight lines between points of a box can be run: reach, soft limits, singularities, axis speeds.

Looked at along the whole line, with a margin, in one posture of the arm: in front, elbow up, wrist flipped or not.
"""

from __future__ import annotations

from collections import Counter
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from olp.core.units import deg, mm
from olp.robots.geometry import Pose
from olp.robots.kinematics import clearance, inverse, jacobian, within_limits, without_tool
from olp.robots.robot import Robot

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
