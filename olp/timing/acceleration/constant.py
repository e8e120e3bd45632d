"""The same acceleration everywhere: what robot files and most simulators hold."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from olp.robots.model import Robot
from olp.timing.acceleration.law import AccelerationLaw

Floats = NDArray[np.float64]


class Constant(AccelerationLaw):
    """Each axis has one acceleration, in both directions and in all poses: that of the robot file."""

    summary = "one acceleration per axis, from the robot file"
    source = "the robot file's own source"

    def knows(self, robot: Robot) -> bool:
        return bool(np.isfinite(robot.accelerations).any())

    def limits(self, robot: Robot, joints: Floats, directions: Floats) -> Floats:
        return np.broadcast_to(robot.accelerations, joints.shape).copy()
