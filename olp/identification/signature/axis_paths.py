"""Straight moves in the robot's own axes: angles at both ends, and how fast each axis turns per metre there."""

from __future__ import annotations

from functools import lru_cache
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from olp.identification.signature.moveset import MoveSet, posture_flags

if TYPE_CHECKING:
    from olp.robots.model import Robot

Floats = NDArray[np.float64]

# [m/s per rad/s] Damping of the inverse Jacobian: at a singularity the rates stay finite.
_DAMPING = 1e-2
_KEPT = 4  # sets of moves whose paths are remembered: several methods ask for those of the same moves


class AxisPaths(NamedTuple):
    """All (n, k); nan where a point is out of reach or the tool's orientation is not known."""

    start: Floats  # [rad]
    end: Floats  # [rad]
    start_rate: Floats  # [rad/m]
    end_rate: Floats  # [rad/m]


@lru_cache(maxsize=_KEPT)
def axis_paths(moves: MoveSet, robot: Robot) -> AxisPaths:
    """The tool keeps its orientation along the line.

    The axes are those the moves tell; else the arm stands as their `configuration` says, where it is written as the
    flags of RCONF (six digits 0 or 1), and otherwise in front, elbow up. A flipped wrist is read as one that is not:
    B turns as far the other way and all else alike, so that moves of both kinds help each other.
    """
    start, start_rate = _at(moves, moves.start, robot, 0)
    end, end_rate = _at(moves, moves.end, robot, 1)
    return AxisPaths(start, end, start_rate, end_rate)


def has_axes(robot: Robot | None) -> bool:
    """Whether the robot's kinematics are known in closed form."""
    return robot is not None and robot.geometry is not None and robot.geometry.links is not None


def _at(moves: MoveSet, places: Floats, robot: Robot, end: int) -> tuple[Floats, Floats]:
    from olp.robots.kinematics.configuration import joint_speeds

    axes = len(robot.axes)
    angles, rates = _angles(moves, places, robot, end), np.full((len(moves), axes), np.nan)
    rows = np.nonzero(np.isfinite(angles).all(axis=1))[0]
    if not len(rows):
        return angles, rates
    wanted = np.concatenate([moves.direction[rows], np.zeros((len(rows), 3))], axis=1)
    # The tool does not turn, so flange and tool centre point travel alike.
    rates[rows] = joint_speeds(robot, angles[rows], wanted, _DAMPING)
    return angles, rates


def _angles(moves: MoveSet, places: Floats, robot: Robot, end: int) -> Floats:
    """(n, k) [rad] at one end: told, or by the inverse."""
    from olp.robots.kinematics.configuration import without_tool
    from olp.robots.kinematics.inverse import inverse

    count, axes = len(moves), len(robot.axes)
    angles = np.full((count, axes), np.nan)
    if moves.joints is not None and moves.joints.shape[2] == axes:
        # A line whose other end is not told could lie in another turn of an axis.
        told = np.isfinite(moves.joints).all(axis=(1, 2))
        angles[told] = _unflipped(robot, moves.joints[told])[:, end]
    known = np.isfinite(moves.rotation).all(axis=(1, 2)) & ~np.isfinite(angles).all(axis=1)
    if not known.any():
        return angles
    position, rotation = places[known], moves.rotation[known]
    if moves.tool is not None:
        position, rotation = without_tool(position, rotation, moves.tool)
    joints, reached = inverse(robot, position, rotation, posture_flags(moves.configuration)[known])
    angles[np.nonzero(known)[0][reached]] = joints[reached]
    return angles


def _unflipped(robot: Robot, joints: Floats) -> Floats:
    """(n, 2, k) [rad] of the same poses; where B begins negative it is turned over, R and T half a turn further."""
    from olp.robots.kinematics.configuration import from_standard, links_of, to_standard

    links = links_of(robot)
    standard = to_standard(links, joints)
    bent = np.sin(standard[:, :1, 4]) < 0
    standard[..., 4] = np.where(bent, -standard[..., 4], standard[..., 4])
    for axis in (3, 5):
        standard[..., axis] += np.where(bent, np.pi, 0.0)
    return np.asarray(from_standard(links, standard))
