"""Encoder pulses to joint values and back."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from olp.core.diagnostic import OlpError, error
from olp.robots.kinematics.chain import as_joints
from olp.robots.model import Robot

Array = NDArray[np.float64]


def pulses_to_joints(robot: Robot, pulses: ArrayLike) -> Array:
    """(n, k) [rad | m] from pulses (n, k). Raises OlpError: K002 number of axes, K003 ratios not known."""
    return as_joints(robot, pulses) / _ratios(robot)


def joints_to_pulses(robot: Robot, joints: ArrayLike) -> NDArray[np.int64]:
    """(n, k) whole pulses from joints (n, k) [rad | m]. Raises OlpError: K002 number of axes, K003 ratios."""
    return np.rint(as_joints(robot, joints) * _ratios(robot)).astype(np.int64)


def _ratios(robot: Robot) -> Array:
    """(k,) [pulses/rad | pulses/m]"""
    unknown = [axis.name for axis in robot.axes if axis.pulses_per_unit is None]
    if unknown:
        raise OlpError(
            error(
                "K003",
                f"the pulses per degree of {robot.name} are not known (axes {', '.join(unknown)})",
                help="give pulses_per_deg in a robot file of your own, or import the controller's backup",
            )
        )
    return robot.pulses_per_unit
