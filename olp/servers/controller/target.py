"""What a simulator asks the controller to reach, and whether the arm can."""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from olp.core.diagnostic import Diagnostic, OlpError, error
from olp.core.units import deg, mm
from olp.ir.program import Path
from olp.robots.geometry import Pose, compose, quaternion_from_rotation, rotation_from_quaternion, slerp
from olp.robots.kinematics.configuration import forward, with_tool, within_limits
from olp.robots.kinematics.tracking import track
from olp.runtime.paths import circle, point_on_arc

if TYPE_CHECKING:
    from olp.robots.model import Robot

Floats = NDArray[np.float64]
_FEWEST, _MOST, _SPACING = (
    48,
    4_000,
    5.0 * mm,
)  # samples along a path, to find out whether and how the arm follows
_SAME = 1e-6  # [rad or m] joints that differ by less are the same


@dataclass(frozen=True, slots=True)
class Target:
    """The next point. Give `joints` (k,) [rad or m] or `pose` [m] (in the controller's frame), not both.

    `speed`: of the tool [m/s]; of a joint move the fraction of rated speed [1]. `turn` [rad/s]: of the tool's
    orientation, instead of `speed`. `zone` [m] in which the point is rounded: 0 stops exactly there, None passes
    without a zone. `via`: what a circular move runs through. `acceleration`, `deceleration`: fraction of rated [1].
    """

    path: Path
    joints: tuple[float, ...] | None = None
    pose: Pose | None = None
    speed: float | None = None
    turn: float | None = None
    zone: float | None = 0.0
    via: Pose | None = None
    acceleration: float = 1.0
    deceleration: float = 1.0

    def problems(self, axes: int) -> list[Diagnostic]:
        """Everything that makes it unusable for an arm with so many axes."""
        says = []
        if (self.joints is None) == (self.pose is None):
            says.append("a target needs either joints or a pose")
        if self.joints is not None and len(self.joints) != axes:
            says.append(f"the arm has {axes} axes, the target has {len(self.joints)}")
        if (self.speed is None) == (self.turn is None):
            says.append("a target needs either a speed or a turning speed")
        if self.path is Path.JOINT and self.turn is not None:
            says.append("a joint move has no turning speed")
        if self.path is Path.JOINT and self.speed is not None and self.speed > 1.0:
            says.append("the speed of a joint move is a fraction of rated speed, at most 1")
        if (self.path is Path.CIRCULAR) != (self.via is not None):
            says.append("a circular target needs a via pose, and no other has one")
        for name in ("speed", "turn", "acceleration", "deceleration"):
            value = getattr(self, name)
            if value is not None and not 0 < value < math.inf:
                says.append(f"{name} has to be above zero, not {value:g}")
        if self.zone is not None and not 0 <= self.zone < math.inf:
            says.append(f"the zone has to be zero or more, not {self.zone:g}")
        if not all(np.isfinite(numbers).all() for numbers in self._numbers()):
            says.append("a target has finite numbers")
        return [error("S003", text) for text in says]

    def _numbers(self) -> list[Floats]:
        poses = [pose for pose in (self.pose, self.via) if pose is not None]
        numbers = [part for pose in poses for part in (pose.position, pose.rotation)]
        return [*numbers, np.asarray(self.joints or ())]


def reach(robot: Robot, start: Floats, target: Target, tool: Pose, frame: Pose) -> list[Floats]:
    """The joints (k,) of the via point, if there is one, and of the target, coming from `start` (k,).

    A pose is reached in the arm configuration that continues the one at the start. Raises OlpError S004 where the
    path leaves the arm's reach, S005 beyond soft limits, S006 where joints ask for another configuration.
    """
    if target.path is Path.JOINT:
        goals = [_joint_goal(robot, start, target, tool, frame)]
    else:
        goals = _path_goals(robot, start, target, tool, frame)
    for joints in goals:
        _refuse_beyond_limits(robot, joints)
    return goals


def _joint_goal(robot: Robot, start: Floats, target: Target, tool: Pose, frame: Pose) -> Floats:
    if target.joints is not None:
        return np.array(target.joints)
    assert target.pose is not None
    flange = frame @ target.pose @ tool.inverse()
    joints: Floats = track(robot, flange.position[None], flange.rotation[None], start)[0]
    if np.isnan(joints).any():
        raise OlpError(error("S004", f"the arm cannot reach {_told(target.pose)}", help="move the target"))
    return joints


def _path_goals(robot: Robot, start: Floats, target: Target, tool: Pose, frame: Pose) -> list[Floats]:
    first = Pose(*(part[0] for part in with_tool(*forward(robot, start[None]), tool)))
    if target.joints is not None:
        end = Pose(*(part[0] for part in with_tool(*forward(robot, np.array([target.joints])), tool)))
    else:
        assert target.pose is not None
        end = frame @ target.pose
    stops = [first, end] if target.via is None else [first, frame @ target.via, end]
    position, rotation = _samples(stops, target.path)
    back = tool.inverse()
    joints = track(robot, *compose(position, rotation, back.position, back.rotation), start)
    per_part = (len(joints) - 1) // (len(stops) - 1)
    lost = np.isnan(joints).any(axis=1)
    if lost.any():
        where = _told(Pose(position[lost.argmax()], rotation[lost.argmax()]))
        says = f"the way to the target leaves the arm's reach at {where} (base frame)"
        raise OlpError(error("S004", says, help="move the target, or go there with a joint move"))
    goals = [joints[per_part * (i + 1)] for i in range(len(stops) - 1)]
    if target.joints is not None:
        if np.abs(goals[-1] - target.joints).max() > _SAME:
            says = "the path ends at the target's pose, but in another arm configuration than its joints"
            raise OlpError(error("S006", says, help="give the pose instead, or go there with a joint move"))
        goals[-1] = np.array(target.joints)
    return goals


def _samples(stops: list[Pose], path: Path) -> tuple[Floats, Floats]:
    """Poses (n, 3), (n, 3, 3) along a line or an arc through the stops, equally many from stop to stop."""
    rough = _FEWEST
    if path is Path.CIRCULAR:
        radius = float(circle(*(stop.position[None] for stop in stops))[1][0])
        rough = int(2.0 * np.pi * radius / _SPACING) if np.isfinite(radius) else 0
    straight = max(float(np.linalg.norm(b.position - a.position)) for a, b in pairwise(stops))
    count = min(max(_FEWEST, rough, int(straight / _SPACING)), _MOST)
    share = np.arange(count + 1) / count
    positions, rotations = [], []
    for i, (a, b) in enumerate(pairwise(stops)):
        rows = [np.broadcast_to(p.position, (len(share), 3)) for p in (a, b, stops[0 if i else -1])]
        if path is Path.CIRCULAR:
            points = point_on_arc(rows[0], rows[1], rows[2], np.full(len(share), i > 0), share)
        else:
            points = rows[0] + (rows[1] - rows[0]) * share[:, None]
        turns = [quaternion_from_rotation(p.rotation) for p in (a, b)]
        first, last = (np.broadcast_to(quaternion, (len(share), 4)) for quaternion in turns)
        between = slerp(first, last, share)
        keep = slice(1 if i else 0, None)  # where two parts meet is one sample
        positions.append(points[keep])
        rotations.append(rotation_from_quaternion(between)[keep])
    return np.concatenate(positions), np.concatenate(rotations)


def _refuse_beyond_limits(robot: Robot, joints: Floats) -> None:
    inside = within_limits(robot, joints[None])[0]
    problems = []
    for axis, value, ok in zip(robot.axes, joints.tolist(), inside.tolist(), strict=True):
        if not ok:
            unit, word = (mm, "mm") if axis.linear else (deg, "deg")
            says = f"axis {axis.name} would stand at {value / unit:.2f} {word}, beyond its soft limits"
            limits = f"{axis.lower / unit:g} to {axis.upper / unit:g} {word}"
            problems.append(error("S005", says, help=limits))
    if problems:
        raise OlpError(*problems)


def _told(pose: Pose) -> str:
    x, y, z = pose.position / mm
    return f"x {x:.1f}, y {y:.1f}, z {z:.1f} mm"
