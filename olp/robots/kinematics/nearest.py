"""The solution nearest to where the arm stands, over all branches and turns: what controllers take without flags."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from olp.robots.kinematics.chain import as_joints, geometry_of
from olp.robots.kinematics.choosing import closest
from olp.robots.kinematics.configuration import from_standard, to_standard
from olp.robots.kinematics.inverse import as_poses, branches, inverse
from olp.robots.kinematics.spherical import STRAIGHT_WRIST
from olp.robots.model import Links, Robot

Array = NDArray[np.float64]


def nearest(robot: Robot, positions: ArrayLike, rotations: ArrayLike, seed: ArrayLike) -> Array:
    """Joints (n, k) [rad | m] of flange poses (n, 3) [m], (n, 3, 3) nearest to `seed`, (k,) or (n, k).

    Nearest is the smallest sum of squared angles; solutions inside the soft limits come first. nan out of reach.
    Arms without a closed form: where Newton's steps from the seed lead.
    Raises OlpError: K001 no geometry, K002 number of axes, K005 poses of wrong shape.
    """
    position, rotation = as_poses(positions, rotations)
    links = geometry_of(robot).links
    if links is None:
        return inverse(robot, position, rotation, seed=seed)[0]
    start = np.broadcast_to(as_joints(robot, seed), (len(position), len(robot.axes)))
    return closest(robot, _held(links, branches(robot, position, rotation), start[:, None, :]), start)


def _held(links: Links, joints: Array, start: Array) -> Array:
    """Where the wrist is straight, R stays as it is in `start` and T makes up for it. `joints` (n, 8, 6)."""
    standard = to_standard(links, joints)
    straight = np.abs(np.sin(standard[..., 4])) < STRAIGHT_WRIST
    if not straight.any():
        return joints
    kept = to_standard(links, start)[..., 3]
    standard[..., 5] = np.where(straight, standard[..., 5] + standard[..., 3] - kept, standard[..., 5])
    standard[..., 3] = np.where(straight, kept, standard[..., 3])
    return from_standard(links, standard)
