"""Acceleration that depends on the pose: inertia seen by the axis, gravity for or against it."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from olp.robots.model import Lean, Lift, Links, Robot, Swing
from olp.timing.acceleration.law import AccelerationLaw

Floats = NDArray[np.float64]


class ByPoseLaw(AccelerationLaw):
    """Axes S, L and U of a six-axis arm; the wrist's axes as in the robot file.

    A motor gives a torque, so 1/a is the inertia that the axis sees in this pose, and gravity helps one
    direction as much as it hinders the other. Which direction is which follows from gravity: the recordings do
    not state it. The load is that of the recordings (a torch or less); `accelerations` are peaks of a small
    motion.
    """

    summary = "by pose: inertia of the arm in its pose, gravity for and against"
    source = "published DX200 recordings of an MA2010: axes S, L, U swung by 0.05 to 0.07 rad in 202 poses"

    def knows(self, robot: Robot) -> bool:
        links = robot.geometry is not None and robot.geometry.links is not None
        return robot.pose_accelerations is not None and links

    def limits(self, robot: Robot, joints: Floats, directions: Floats) -> Floats:
        result = np.broadcast_to(robot.accelerations, joints.shape).copy()
        numbers = robot.pose_accelerations
        if numbers is None or robot.geometry is None or robot.geometry.links is None:
            result[:, :3] = np.nan
            return result
        lean, lift = joints[:, 1], joints[:, 2]
        columns = (
            swing_limit(numbers.swing, robot.geometry.links, lean, lift),
            lean_limit(numbers.lean, lean, lift, directions[:, 1]),
            lift_limit(numbers.lift, lean, lift, directions[:, 2]),
        )
        for axis, (column, (low, high)) in enumerate(zip(columns, numbers.ranges, strict=True)):
            result[:, axis] = np.clip(column, low, high)
        return result


def swing_limit(numbers: Swing, links: Links, lean: Floats, lift: Floats) -> Floats:
    """Acceleration limit of axis S [rad/s²], (n,), at the angles of axes L (`lean`) and U (`lift`) [rad]."""
    elevation = lift - lean
    elbow = links.a1 + links.a2 * np.sin(lean)
    forearm = elbow + numbers.ahead * np.cos(elevation) - numbers.above * np.sin(elevation)
    inverse = numbers.fixed + numbers.elbow * elbow**2 + numbers.forearm * forearm**2
    result: Floats = np.minimum(1.0 / np.maximum(inverse, 1e-3), numbers.cap)
    return result


def lean_limit(numbers: Lean, lean: Floats, lift: Floats, direction: Floats) -> Floats:
    """Acceleration limit of axis L [rad/s²], (n,), at the angles of axes L and U [rad]; `direction` +1 leans
    forward.
    """
    elevation = lift - lean
    inertia = numbers.fixed + numbers.cosine * np.cos(lift) + numbers.sine * np.sin(lift)
    parts = np.stack([np.sin(lean), np.cos(lean), np.cos(elevation), np.sin(elevation)], axis=-1)
    torque = 1.0 + parts @ np.array(numbers.both) + direction * (parts @ np.array(numbers.gravity))
    result: Floats = torque / np.maximum(inertia, 1e-3)
    return result


def lift_limit(numbers: Lift, lean: Floats, lift: Floats, direction: Floats) -> Floats:
    """Acceleration limit of axis U [rad/s²], (n,), at the angles of axes L and U [rad]; `direction` +1 lifts the
    forearm.
    """
    lever = np.cos(lift - lean + numbers.offset)
    step = 1.0 / (1.0 + np.exp((numbers.start - np.abs(lever)) / numbers.width))
    tilt = (numbers.lever - step * numbers.eased) * lever
    result: Floats = numbers.high - step * numbers.drop - direction * tilt
    return result
