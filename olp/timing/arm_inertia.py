"""The inertia about each axis of an arm, relative to that of the stretched arm with its rated load.

From the robot file's masses where it has them. Else from a usual arm of this size: its moving mass follows
payload and reach as those of published data sheets do, and sits where the drives of six-axis arms sit.
"""

from __future__ import annotations

from functools import lru_cache
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from olp.robots.robot import Robot
from olp.robots.times_to_speed import reach_of

Floats = NDArray[np.float64]

# Moving mass [kg] = _MASS (payload/3 kg)^_BY_PAYLOAD (reach/0.54 m)^_BY_REACH: data sheets of KR 3 R540 (3 kg, 0.54 m,
# 26.5 kg), KR 210 R2700 (210 kg, 2.7 m, 1068 kg) and MA2010 (10 kg, 2.0 m, 280 kg), of which the base is three tenths.
_MASS: Final = 0.7 * 26.5
_BY_PAYLOAD: Final = 0.285
_BY_REACH: Final = 1.54
# Shares of the moving mass: upper arm (its middle), elbow with the drives of the wrist, forearm (its middle), wrist.
# The rest turns about the first axis at no distance worth counting. A usual arm's; the posture's weights mend the rest.
_UPPER_ARM, _ELBOW, _FOREARM, _WRIST = 0.25, 0.25, 0.2, 0.1
# Of the reach: how far in front of the flange a load sits, and the radius of gyration of the rated one.
_LEVER: Final = 0.1
_GYRATION: Final = 0.14
_GRID: Final = 13
_USUAL_PAYLOAD: Final = 10.0  # [kg] where neither robot nor recording tells one


class RelativeInertia(NamedTuple):
    """(n, k) each: `arm` alone, and `load` of the given mass; both are 1 at the most with the rated load."""

    arm: Floats
    load: Floats


def relative_inertia(
    robot: Robot, joints: Floats, payload: Floats | None = None, inertia: Floats | None = None
) -> RelativeInertia:
    """Of poses `joints` (n, k) [rad]; `payload` (n,) [kg] and its own `inertia` (n,) [kg m²].

    A payload of None or nan is half of the rated one.
    """
    count, axes = joints.shape
    if robot.geometry is None or axes != len(robot.axes):
        share = np.full(count, np.nan) if payload is None else payload / (robot.payload or _USUAL_PAYLOAD)
        return RelativeInertia(np.ones((count, axes)), np.tile(_known(share)[:, None], (1, axes)))
    rated = robot.payload or _USUAL_PAYLOAD
    gyration = rated * (_GYRATION * reach_of(robot.geometry)) ** 2
    mass = _known(np.full(count, np.nan) if payload is None else payload / rated)
    own = mass if inertia is None else np.where(np.isnan(inertia), mass, inertia / gyration)
    arm, lever = _bodies(robot, joints)
    arm_most, lever_most = _most(robot)
    with np.errstate(divide="ignore", invalid="ignore"):
        relative = np.where(arm_most > 0, arm / np.where(arm_most > 0, arm_most, 1.0), 1.0)
    full = rated * lever_most + gyration
    return RelativeInertia(relative, (mass[:, None] * rated * lever + own[:, None] * gyration) / full)


def _known(share: Floats) -> Floats:
    return np.where(np.isnan(share), 0.5, share)


@lru_cache(maxsize=64)
def _most(robot: Robot) -> tuple[Floats, Floats]:
    """(k,) the largest inertia of the arm about each axis, and the largest squared lever [m²] of the load."""
    grid = np.zeros((_GRID * _GRID, len(robot.axes)))
    ranges = [
        np.linspace(robot.lower[i], robot.upper[i], _GRID) if i < len(robot.axes) else np.zeros(_GRID)
        for i in (1, 2)
    ]
    second, third = np.meshgrid(*ranges)
    if len(robot.axes) > 2:
        grid[:, 1], grid[:, 2] = second.ravel(), third.ravel()
    arm, lever = _bodies(robot, grid)
    return arm.max(axis=0), lever.max(axis=0)


def _bodies(robot: Robot, joints: Floats) -> tuple[Floats, Floats]:
    """(n, k) [kg m²] of the arm about each axis, and the squared distance [m²] of the load from it."""
    from olp.robots.kinematics.chain import geometry_of, sweep

    geometry = geometry_of(robot)
    swept = sweep(robot, geometry, joints.T)
    origins, directions = swept.origins, swept.axes
    reach = reach_of(geometry)
    load = swept.position + swept.columns[2] * (_LEVER * reach)
    masses = _points(robot, origins, reach)
    arm, lever = np.zeros(joints.shape), np.zeros(joints.shape)
    for number, joint in enumerate(geometry.joints):
        lever[:, joint.axis] = _squared(load, origins[number], directions[number])
        for point, mass, last in masses:
            if last >= number:
                arm[:, joint.axis] += mass * _squared(point, origins[number], directions[number])
    if robot.dynamics is not None:
        from olp.robots.dynamics import dynamic_model, mass_matrix

        arm = np.diagonal(mass_matrix(dynamic_model(robot), joints), axis1=1, axis2=2).copy()
    return arm, lever


def _points(robot: Robot, origins: list[Floats], reach: float) -> list[tuple[Floats, float, int]]:
    """Point masses: place (3, n) [m], mass [kg] and the last joint that carries it."""
    if len(origins) < 5:
        return []
    mass = _MASS * ((robot.payload or _USUAL_PAYLOAD) / 3.0) ** _BY_PAYLOAD * (reach / 0.54) ** _BY_REACH
    shoulder, elbow, wrist = origins[1], origins[2], origins[4]
    return [
        ((shoulder + elbow) / 2, _UPPER_ARM * mass, 1),
        (elbow, _ELBOW * mass, 2),
        ((elbow + wrist) / 2, _FOREARM * mass, 2),
        (wrist, _WRIST * mass, 3),
    ]


def _squared(point: Floats, origin: Floats, direction: Floats) -> Floats:
    """(n,) [m²] squared distance of points from axes, (3, n) each."""
    away = point - origin
    along = np.sum(away * direction, axis=0)
    # Rounding may leave less than nothing.
    apart: Floats = np.maximum(np.sum(away**2, axis=0) - along**2, 0.0)
    return apart
