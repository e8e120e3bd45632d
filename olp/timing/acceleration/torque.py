"""Acceleration by torque limits: what is left of each drive after weight and friction, over the inertia it sees."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from olp.robots.dynamics.limits import PathTorque, acceleration_interval, move_acceleration, positive_speed
from olp.robots.dynamics.torques import (
    Mounting,
    drives_of,
    dynamic_model,
    gravity_torques,
    mass_matrix,
    same_shape,
)
from olp.robots.model import Body, Robot, Vector
from olp.timing.acceleration.constant import Constant
from olp.timing.acceleration.law import AccelerationLaw

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Torque(AccelerationLaw):
    """One axis at a time, from rest: the largest a with |M a + g + friction| within every axis' torque limit.

    The other axes have to hold still meanwhile, so their limits count too. 0 where the robot cannot hold the pose.
    For whole moves, with all axes at once and at speed, see `of_moves`; M and g are those of olp.robots.dynamics.
    """

    payload: Body | None = None  # in the flange frame
    mounting: Mounting | Vector = "floor"

    summary = "by torque limits: masses of the arm and its load, rigid bodies"
    source = "Apostolovic's thesis, equation 5.1; masses and torque limits from the robot file's own sources"

    def knows(self, robot: Robot) -> bool:
        known = robot.dynamics is not None and any(drive.limit is not None for drive in robot.dynamics.drives)
        return known and robot.geometry is not None

    def limits(self, robot: Robot, joints: Floats, directions: Floats) -> Floats:
        result = np.full_like(joints, np.nan)
        if not self.knows(robot):
            return result
        assert robot.dynamics is not None
        model = dynamic_model(robot, self.mounting)
        mass, weight = mass_matrix(model, joints, self.payload), gravity_torques(model, joints, self.payload)
        nothing, coulomb = np.zeros_like(weight), drives_of(model)[2]
        for axis, drive in enumerate(robot.dynamics.drives):
            if drive.limit is None:
                continue
            sense = directions[:, axis, None]
            friction = nothing.copy()
            friction[:, axis] = coulomb[axis] * sense[:, 0]
            torque = PathTorque(mass[:, :, axis] * sense, nothing, nothing, weight + friction)
            found = acceleration_interval(torque, 0.0, model.torque_limits)
            result[:, axis] = np.where((found.lower <= 0.0) & (found.upper > 0.0), found.upper, 0.0)
        return result


class MoveRates(NamedTuple):
    """Accelerations of joint moves relative to their length [1/s²]: multiplied by |end - start| of an axis they are
    its acceleration.
    """

    acceleration: Floats  # (n,) [1/s²] nan where nothing is known
    deceleration: Floats  # (n,) [1/s²]
    assumptions: tuple[str, ...]  # what was taken for what is not known, in words


def of_moves(
    robot: Robot,
    start: ArrayLike,
    end: ArrayLike,
    speed: ArrayLike,
    payload: Body | None = None,
    mounting: Mounting | Vector = "floor",
) -> MoveRates:
    """Acceleration and deceleration limits of n joint moves with synchronised axes; `start`, `end` (n, k) [rad |
    m], `speed` [1/s].

    They follow from the torque limits (see `olp.robots.dynamics.move_acceleration`) where the robot has masses and
    limits; otherwise from the constant accelerations of the file, which `assumptions` then states. Raises OlpError:
    K002, K007 wrong shapes, K008 a speed that is not positive.
    """
    if Torque().knows(robot):
        model = dynamic_model(robot, mounting)
        found = move_acceleration(model, start, end, speed, payload)
        return MoveRates(found.acceleration, found.deceleration, model.assumptions)
    begins, ends = same_shape(robot, start, end)
    positive_speed(speed, len(begins))
    rate, _ = Constant().along_path(robot, begins, ends - begins)
    taken = "the constant accelerations of its file are used for every pose and load"
    if not Constant().knows(robot):
        rate, taken = np.full(len(begins), np.nan), "nor are its accelerations"
    return MoveRates(rate, rate, (f"{robot.name}: masses and torque limits are not known: {taken}",))
