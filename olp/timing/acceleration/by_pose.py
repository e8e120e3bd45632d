"""Acceleration that depends on the pose: inertia seen by the axis, gravity for or against it."""

from __future__ import annotations

from types import MappingProxyType
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from olp.robots.model import Links, Robot
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
        return robot.name in MEASURED and robot.geometry is not None and robot.geometry.links is not None

    def limits(self, robot: Robot, joints: Floats, directions: Floats) -> Floats:
        result = np.broadcast_to(robot.accelerations, joints.shape).copy()
        if not self.knows(robot):
            result[:, :3] = np.nan
            return result
        assert robot.geometry is not None
        assert robot.geometry.links is not None
        numbers = MEASURED[robot.name]
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


# --- Measured numbers, per robot ---
# Facts with their source. Fitted by `bench/ma2010.py`, which prints them again; tests hold them to the measured table
# they come from.


class Swing(NamedTuple):
    """Parameters of axis S. 1/a = fixed + elbow e² + forearm f², with a at most `cap`: inertia over torque, and the
    controller's own limit.

    e: horizontal distance of the elbow from axis S [m]; f: horizontal distance of the point (`ahead`, `above`) [m]
    of the forearm's frame.
    """

    fixed: float  # [s²/rad]
    elbow: float  # [s²/rad/m²]
    forearm: float  # [s²/rad/m²]
    ahead: float  # [m] along the forearm from axis U
    above: float  # [m] across it
    cap: float  # [rad/s²]


class Lean(NamedTuple):
    """Parameters of axis L. a = (1 + both ± gravity) / inertia, divided by the torque; + for leaning forward.

    inertia = fixed + cosine cos U + sine sin U [s²/rad]: axis U alone moves the forearm nearer or further.
    `gravity` and `both` are sums of parts along (sin L, cos L, cos E, sin E), with the forearm's elevation E = U -
    L: the levers of the upper arm and of the forearm, and what slows both directions alike (balancer, friction
    under load).
    """

    fixed: float
    cosine: float
    sine: float
    gravity: tuple[float, float, float, float]  # [1]
    both: tuple[float, float, float, float]  # [1]


class Lift(NamedTuple):
    """Parameters of axis U. a = high - s drop ∓ (lever - s eased) g, with the forearm's horizontal lever g = cos(E
    + offset); - for lifting.

    s = 1 / (1 + exp((start - |g|) / width)) steps to 1 where |g| passes `start`: two levels of acceleration.
    """

    offset: float  # [rad] from the forearm's axis to its centre of mass
    start: float  # [1] share of the full lever
    width: float  # [1]
    high: float  # [rad/s²]
    drop: float  # [rad/s²]
    lever: float  # [rad/s²]
    eased: float  # [rad/s²]


class ByPose(NamedTuple):
    """Parameters of the first three axes. `ranges`: lowest and highest measured acceleration [rad/s²]; they also
    bound the result outside the measured poses.
    """

    swing: Swing
    lean: Lean
    lift: Lift
    ranges: tuple[tuple[float, float], tuple[float, float], tuple[float, float]]
    source: str


MEASURED = MappingProxyType(
    {
        "yaskawa/ma2010": ByPose(
            swing=Swing(
                fixed=0.06379, elbow=0.02967, forearm=0.02152, ahead=0.91025, above=0.26087, cap=13.05
            ),
            lean=Lean(
                fixed=0.16157,
                cosine=0.01237,
                sine=0.05723,
                gravity=(0.0897, -0.01119, 0.05436, -0.01082),
                both=(0.0179, 0.21379, 0.00777, 0.15928),
            ),
            lift=Lift(
                offset=0.34476,
                start=0.70793,
                width=0.05004,
                high=10.56506,
                drop=2.23369,
                lever=0.98795,
                eased=0.59805,
            ),
            ranges=((5.87, 13.92), (3.95, 10.34), (7.38, 11.31)),
            source="published DX200 recordings of an MA2010 (axes S, L, U swung by 0.05 to 0.07 rad at full speed in "
            "202 poses, L -33 to 93 deg, U -71 to 147 deg; mean of the five largest filtered accelerations)",
        )
    }
)
