"""Straight moves in the robot's own axes: angles at both ends, and how fast each axis turns per metre there."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from olp.signature.moveset import MoveSet

if TYPE_CHECKING:
    from olp.robot import Robot

Floats = NDArray[np.float64]

# [m/s per rad/s] Damping of the inverse Jacobian: at a singularity the rates stay finite.
_DAMPING = 1e-2


class AxisPaths(NamedTuple):
    """All (n, k); nan where a point is out of reach or the tool's orientation is not known."""

    start: Floats  # [rad]
    end: Floats  # [rad]
    start_rate: Floats  # [rad/m]
    end_rate: Floats  # [rad/m]


def axis_paths(moves: MoveSet, robot: Robot) -> AxisPaths:
    """The arm stands in front, elbow up, wrist not flipped; the tool keeps its orientation along the line."""
    start, start_rate = _at(moves, moves.start, robot)
    end, end_rate = _at(moves, moves.end, robot)
    return AxisPaths(start, end, start_rate, end_rate)


def has_axes(robot: Robot | None) -> bool:
    """Whether the robot's kinematics are known in closed form."""
    return robot is not None and robot.geometry is not None and robot.geometry.links is not None


def _at(moves: MoveSet, places: Floats, robot: Robot) -> tuple[Floats, Floats]:
    from olp.kinematics import inverse, jacobian, without_tool

    known = np.isfinite(moves.rotation).all(axis=(1, 2))
    count, axes = len(moves), len(robot.axes)
    angles, rates = np.full((count, axes), np.nan), np.full((count, axes), np.nan)
    if not known.any():
        return angles, rates
    position, rotation = places[known], moves.rotation[known]
    if moves.tool is not None:
        position, rotation = without_tool(position, rotation, moves.tool)
    joints, reached = inverse(robot, position, rotation)
    rows = np.nonzero(known)[0][reached]
    joints = joints[reached]
    angles[rows] = joints
    matrix = jacobian(robot, joints)
    wanted = np.concatenate([moves.direction[rows], np.zeros((len(rows), 3))], axis=1)
    # The tool does not turn, so flange and tool centre point travel alike.
    turned = matrix.transpose(0, 2, 1)
    square = turned @ matrix + _DAMPING**2 * np.eye(axes)
    rates[rows] = np.linalg.solve(square, turned @ wanted[:, :, None])[:, :, 0]
    return angles, rates
