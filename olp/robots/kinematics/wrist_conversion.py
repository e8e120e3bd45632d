"""The same place of the flange for an arm that is built otherwise: one with a spherical wrist, one without."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from olp.robots.kinematics.chain import as_joints, forward, geometry_of, sweep
from olp.robots.kinematics.configuration import within_limits
from olp.robots.kinematics.inverse import branches, closest
from olp.robots.kinematics.numeric import solve_from
from olp.robots.kinematics.offset_wrist import offset_wrist_of, solutions
from olp.robots.model import Robot

Array = NDArray[np.float64]

# [1] Sum of both links' 1 - cos, one of them by 45 deg: what differs less is a matter of nearness.
_ALIKE = 0.3
_FRONT = 4  # solutions that pass axis 1 on one side come first, then as many on the other


def same_flange(robot: Robot, other: Robot, joints: Array, start: Array) -> Array:
    """Joints (n, k) [rad] with which `other` has its flange where `robot` has it with `joints` (n, k); nan where none
    is inside the limits.

    Both are counted from their own base. Of several the one whose upper arm and forearm point most as those of
    `robot`, or almost so, and of these the one nearest to where the row before leads, the first to `start` (k,); arms
    with a spherical wrist have it before axis 1 where they can; where no such is inside the limits, any other.
    Raises OlpError: K001 no geometry, K002 number of axes.
    """
    position, rotation = forward(robot, joints)
    here = as_joints(other, start)
    found = _all_of(other, position, rotation, np.broadcast_to(here, (len(position), len(other.axes))))
    wanted = _links_of(robot, as_joints(robot, joints))
    there = np.full((len(found), len(other.axes)), np.nan)
    front = found[:, :_FRONT]
    for choice in (_most_alike(other, front, wanted), _most_alike(other, found, wanted), front, found):
        for row in np.flatnonzero(np.isnan(there).any(axis=1)).tolist():
            chosen = closest(other, choice[row : row + 1], _before(there, row, here))
            if within_limits(other, chosen).all():
                there[row] = chosen[0]
    return there


def _before(there: Array, row: int, start: Array) -> Array:
    """(1, k): the last known of the rows (n, k) before `row`, else `start`."""
    if row and not np.isnan(there[row - 1]).any():
        return there[row - 1 : row]
    known = np.flatnonzero(~np.isnan(there[:row]).any(axis=1))
    return there[known[-1] :][:1] if len(known) else start


def _most_alike(robot: Robot, found: Array, wanted: Array) -> Array:
    """`found` (n, m, k) without those whose links point less as `wanted` (n, 6) than others do."""
    each = [np.sum(_links_of(robot, found[:, i]) * wanted, axis=1) for i in range(found.shape[1])]
    likeness = np.nan_to_num(np.stack(each, axis=1), nan=-np.inf)
    best = likeness.max(axis=1, keepdims=True)
    return np.where((likeness >= best - _ALIKE)[:, :, None], found, np.nan)


def _all_of(robot: Robot, position: Array, rotation: Array, start: Array) -> Array:
    """(n, m, k) [rad]: all solutions where there is a closed form, else the one that the start leads to."""
    geometry = geometry_of(robot)
    if geometry.links is not None:
        return branches(robot, position, rotation)
    arm = offset_wrist_of(geometry)
    if arm is not None:
        return solutions(arm, position, rotation, start[:, 5])
    return solve_from(robot, position, rotation, start)[0][:, None, :]


def _links_of(robot: Robot, joints: Array) -> Array:
    """(n, 6): the directions of the upper arm, from axis 2 to 3, and of the forearm, from there to axis 5."""
    origins = sweep(robot, geometry_of(robot), joints.T).origins
    ways = [origins[2] - origins[1], origins[4] - origins[2]]
    return np.concatenate([(way / np.linalg.norm(way, axis=0)).T for way in ways], axis=1)
