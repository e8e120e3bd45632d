"""Points of a recording from its joints, and joints from its points, where the robot tells one by the other."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from olp.identification.recording.moves import RecordedMoves
    from olp.robots.geometry import Pose
    from olp.robots.model import Robot

Floats = NDArray[np.float64]


def with_points(moves: RecordedMoves, robot: Robot | None, tool: Pose | None) -> RecordedMoves:
    """Rows with joint points alone get the tool's, at the flange where no tool is told."""
    lacking = moves.has_joints & ~moves.has_points
    if not lacking.any() or not _fits(moves, robot):
        return moves
    assert robot is not None
    start, end, first, last = (
        a.copy() for a in (moves.start, moves.end, moves.start_angles, moves.end_angles)
    )
    for joints, points, angles in ((moves.joints_start, start, first), (moves.joints_end, end, last)):
        points[lacking], angles[lacking] = _pose(robot, joints[lacking], tool)
    return replace(moves, start=start, end=end, start_angles=first, end_angles=last)


def joint_ends(moves: RecordedMoves, robot: Robot | None, tool: Pose | None) -> tuple[Floats, Floats]:
    """(n, k) [rad | m] at both ends; nan where neither joints nor a reachable pose are told.

    A pose is reached as everywhere in a signature: as `configuration` says, else in front, elbow up; wrist not flipped.
    """
    if robot is None:
        return np.full((2, len(moves), 0), np.nan)[0], np.full((len(moves), 0), np.nan)
    if _fits(moves, robot):
        start, end = moves.joints_start.copy(), moves.joints_end.copy()
    else:
        start, end = (np.full((len(moves), len(robot.axes)), np.nan) for _ in range(2))
    lacking = ~(np.isfinite(start).all(axis=1) & np.isfinite(end).all(axis=1)) & moves.has_points
    lacking &= np.isfinite(moves.start_angles).all(axis=1) & np.isfinite(moves.end_angles).all(axis=1)
    if lacking.any() and robot.geometry is not None and robot.geometry.links is not None:
        flags = posture_flags(moves.texts.get("configuration", ("",) * len(moves)))[lacking]
        start[lacking] = _reach(robot, moves.start[lacking], moves.start_angles[lacking], flags, tool)
        end[lacking] = _reach(robot, moves.end[lacking], moves.end_angles[lacking], flags, tool)
    return start, end


def posture_flags(configuration: tuple[str, ...]) -> NDArray[np.int64]:
    """(n, 6) of RCONF: elbow, and front or back; 0 where a `configuration` is another word."""
    flags = np.zeros((len(configuration), 6), dtype=np.int64)
    for row, text in enumerate(configuration):
        digits = text.replace(",", "").replace(" ", "")
        if len(digits) >= 6 and set(digits) <= {"0", "1"}:
            flags[row, 1:3] = int(digits[1]), int(digits[2])
    return flags


def _fits(moves: RecordedMoves, robot: Robot | None) -> bool:
    return robot is not None and len(moves.slides) == len(robot.axes) and robot.geometry is not None


def _pose(robot: Robot, joints: Floats, tool: Pose | None) -> tuple[Floats, Floats]:
    from olp.robots.geometry import angles_from_rotation
    from olp.robots.kinematics.chain import forward, with_tool

    position, rotation = forward(robot, joints)
    if tool is not None:
        position, rotation = with_tool(position, rotation, tool)
    return position, np.asarray(angles_from_rotation(rotation))


def _reach(
    robot: Robot, points: Floats, angles: Floats, flags: NDArray[np.int64], tool: Pose | None
) -> Floats:
    from olp.robots.geometry import rotation_from_angles
    from olp.robots.kinematics.chain import without_tool
    from olp.robots.kinematics.inverse import inverse

    position, rotation = points, rotation_from_angles(angles)
    if tool is not None:
        position, rotation = without_tool(position, rotation, tool)
    joints, reached = inverse(robot, position, rotation, flags)
    joints[~reached] = np.nan
    return joints
