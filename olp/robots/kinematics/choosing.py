"""Of several solutions of one pose, the one nearest to where the arm stands."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from olp.robots.kinematics.configuration import wrap
from olp.robots.model import Robot

Array = NDArray[np.float64]

_TURN = 2.0 * math.pi


def closest(robot: Robot, found: Array, start: Array) -> Array:
    """The row (n, k) of `found` (n, m, k) [rad] nearest to `start` (n, k), by whole turns, too; nan where all are.

    Nearest is the smallest sum of squared angles; solutions inside the soft limits come first.
    """
    start = start[:, None, :]
    found = start + wrap(found - start)
    found = _towards(found, robot.lower, robot.upper)
    outside = (found < robot.lower - 1e-9) | (found > robot.upper + 1e-9)
    way = np.nan_to_num(np.sum((found - start) ** 2, axis=2), nan=np.inf)
    # Further than any two joint positions are apart.
    way += 1e6 * outside.any(axis=2)
    chosen: Array = found[np.arange(len(found)), way.argmin(axis=1)]
    return chosen


def _towards(joints: Array, lower: Array, upper: Array) -> Array:
    """`joints` by whole turns to inside the limits, where that can be."""
    up = _TURN * np.ceil((lower - 1e-9 - joints) / _TURN)
    raised = np.where(up > 0, joints + up, joints)
    down = _TURN * np.ceil((raised - upper - 1e-9) / _TURN)
    lowered = np.where(down > 0, raised - down, raised)
    inside: Array = np.where(lowered >= lower - 1e-9, lowered, joints)
    return inside
