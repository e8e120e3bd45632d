"""Every change of speed takes the same time, however large: an acceleration filter."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from olp.robots.model import Robot
from olp.timing.acceleration.law import AccelerationLaw

Floats = NDArray[np.float64]


class TimeConstant(AccelerationLaw):
    """Commanded speed passes a moving average over the time T: a step becomes a ramp of T, so a = V/T.

    `accelerations` are those to rated speed.
    """

    summary = "one time for every change of speed (acceleration filter)"
    source = "published DX200 recordings of an MA2010: equal rise times at 50, 100, 200 and 400 mm/s"

    def knows(self, robot: Robot) -> bool:
        return robot.acceleration_filter is not None

    def limits(self, robot: Robot, joints: Floats, directions: Floats) -> Floats:
        seconds = np.nan if robot.acceleration_filter is None else robot.acceleration_filter
        return np.broadcast_to(robot.speeds / seconds, joints.shape).copy()
