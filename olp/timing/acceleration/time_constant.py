"""Every change of speed takes the same time, however large: an acceleration filter."""

from __future__ import annotations

from types import MappingProxyType

import numpy as np
from numpy.typing import ArrayLike, NDArray

from olp.robots.model import Robot
from olp.timing.acceleration.law import AccelerationLaw

Floats = NDArray[np.float64]

MA2010_TIME = 0.15  # [s]

# Seconds to the commanded speed, each with where it was measured.
MEASURED = MappingProxyType({"yaskawa/ma2010": MA2010_TIME})
SOURCES = MappingProxyType(
    {
        "yaskawa/ma2010": "published DX200 recordings: corner runs at 50 to 800 mm/s (0.138 s with a servo lag "
        "of 0.046 s; 0.166 s with 0.038 s describes them nearly as well) and both ends of runs at 10 mm/s"
    }
)


class TimeConstant(AccelerationLaw):
    """Commanded speed passes a moving average over the time T: a step becomes a ramp of T, so a = V/T.

    `accelerations` are those to rated speed. For moves along a path see `equivalent`.
    """

    summary = "one time for every change of speed (acceleration filter)"
    source = "published DX200 recordings of an MA2010: equal rise times at 50, 100, 200 and 400 mm/s"

    def knows(self, robot: Robot) -> bool:
        return robot.name in MEASURED

    def limits(self, robot: Robot, joints: Floats, directions: Floats) -> Floats:
        seconds = MEASURED.get(robot.name, np.nan)
        return np.broadcast_to(robot.speeds / seconds, joints.shape).copy()


def equivalent(length: ArrayLike, speed: ArrayLike, seconds: ArrayLike) -> tuple[Floats, Floats]:
    """Speed [m/s] and acceleration [m/s²] of the trapezoid that the filter makes of a move from rest to rest.

    `length` [m], programmed `speed` [m/s], time constant T of the filter `seconds` [s]. A move shorter than V T
    never reaches V: the average of a pulse of V over L/V is a trapezoid of height L/T. The move takes L/V + T in
    both cases.
    """
    way, programmed, time = (np.asarray(a, dtype=np.float64) for a in (length, speed, seconds))
    return np.minimum(programmed, way / time), programmed / time
