"""Joint values as a maker's controller reads them, and the same posture in another maker's readings.

FANUC reads axis 3 against the horizontal: its reading stays when axis 2 alone turns the upper arm. Everything else here
counts joints, each against the link before; readings become joints where a program is read and where one is written.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from olp.core.diagnostic import OlpError, error
from olp.robots.kinematics.chain import as_joints
from olp.robots.kinematics.configuration import (
    TURN_AXES,
    from_standard,
    links_of,
    to_standard,
    within_limits,
    wrap,
)
from olp.robots.model import Links, Robot

Array = NDArray[np.float64]


def joints_of_readings(robot: Robot, readings: Array) -> Array:
    """Joints (n, k) [rad | m] of what the controller reads."""
    links = _coupled(robot)
    if links is None:
        return readings
    joints = readings.copy()
    joints[:, 2] += links.signs[1] * links.signs[2] * readings[:, 1]
    return joints


def readings_of_joints(robot: Robot, joints: Array) -> Array:
    """The way back of `joints_of_readings`."""
    links = _coupled(robot)
    if links is None:
        return joints
    readings = joints.copy()
    readings[:, 2] -= links.signs[1] * links.signs[2] * joints[:, 1]
    return readings


def same_posture(robot: Robot, other: Robot, joints: Array) -> Array | None:
    """Joints (n, 6) [rad] with which `other` stands as `robot` does with `joints`: link beside link, front to front.

    None where one of them is no six-axis arm with a spherical wrist. L, U and B lie within the other's range; S, R
    and T have the turns that they had, but where only other ones are within the other's limits.
    """
    one = None if robot.geometry is None else robot.geometry.links
    two = None if other.geometry is None else other.geometry.links
    if one is None or two is None:
        return None
    if (one.signs, one.zeros) == (two.signs, two.zeros):
        return joints
    found = from_standard(two, to_standard(one, joints))
    turned = wrap(found, (other.lower + other.upper) / 2.0)
    for axis in (1, 2, 4):
        found[:, axis] = turned[:, axis]
    return np.where(within_limits(other, turned) & ~within_limits(other, found), turned, found)


def turned_back(robot: Robot, other: Robot, joints: Array, found: Array) -> NDArray[np.bool_]:
    """(n,) whether `found`, which `same_posture` made of `joints`, has S, R or T whole turns elsewhere."""
    went_on = from_standard(links_of(other), to_standard(links_of(robot), joints))
    apart: Array = np.abs(found - went_on)[:, TURN_AXES]
    return np.asarray((apart > np.pi).any(axis=1))


def _coupled(robot: Robot) -> Links | None:
    links = None if robot.geometry is None else robot.geometry.links
    return links if links is not None and links.third_to_horizontal else None


# --- Pulses ---
# Encoder pulses to joint values and back.


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
