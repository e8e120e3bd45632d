"""Joint moves as an arm's law and what is learnt beside it see them, whether they come from a recording or a
plan.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import Final, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from olp.robots.robot import Robot
from olp.robots.times_to_speed import reach_of
from olp.timing.arm import ArmTiming, JointMotions, gradient, posture_functions

Floats = NDArray[np.float64]
Mask = NDArray[np.bool_]
Rows = NDArray[np.intp]


@dataclass(frozen=True, slots=True, eq=False)
class JointMoves:
    """n joint moves: the law's view of them, and the joints at both ends (n, k) [rad | m]."""

    motions: JointMotions
    start: Floats
    end: Floats

    def __len__(self) -> int:
        return len(self.start)

    def take(self, rows: Rows | Mask) -> JointMoves:
        return JointMoves(self.motions.take(rows), self.start[rows], self.end[rows])


class JointTimes(NamedTuple):
    """(n,) [s] each; nan where nothing can be said."""

    duration: Floats
    low: Floats
    high: Floats


def joint_moves(
    robot: Robot | None,
    start: Floats,
    end: Floats,
    fraction: Floats,
    acceleration: Floats,
    override: Floats,
    payload: Floats | None = None,
    inertia: Floats | None = None,
) -> JointMoves:
    """From joints (n, k) [rad | m] at both ends; shares (n,) [1]; `payload` (n,) [kg] and its `inertia` [kg m²]."""
    middle = (start + end) / 2
    if robot is None:
        relative = np.ones((2, *start.shape))
    else:
        relative = np.stack(relative_inertia(robot, np.nan_to_num(middle), payload, inertia))
    motions = JointMotions(
        np.abs(end - start),
        posture_functions(middle),
        relative[0],
        relative[1],
        fraction,
        acceleration,
        override,
    )
    return JointMoves(motions, start, end)


class JointLaw(Protocol):
    """What times joint moves: the arm's law as it is known, or with what was learnt beside it."""

    @property
    def timing(self) -> ArmTiming: ...

    @property
    def quantile(self) -> float:
        """[spreads] of a 95 % interval."""

    def predict(self, moves: JointMoves) -> JointTimes: ...


class PriorArm(NamedTuple):
    """The law alone, with what is known of an arm without any recorded move."""

    timing: ArmTiming
    quantile: float = 1.96

    def predict(self, moves: JointMoves) -> JointTimes:
        duration = self.timing.durations(moves.motions)
        wide = np.exp(self.quantile * self.timing.spread(moves.motions))
        return JointTimes(duration, duration / wide, duration * wide)


def total_half(law: JointLaw, moves: JointMoves, often: Floats) -> float:
    """[s] half-width of the 95 % interval of a sum; `often` (n,): how many times each move runs.

    What is not known of the law's numbers is the same in all moves; the scatter of a move is its own.
    """
    timing = law.timing
    seconds = timing.durations(moves.motions) * often
    pull = seconds @ gradient(timing.mean, moves.motions)
    variance = float(pull @ timing.covariance @ pull) + float(np.sum((seconds * timing.scatter) ** 2))
    return law.quantile * float(np.sqrt(variance))


# --- Arm inertia ---
# The inertia about each axis of an arm, relative to that of the stretched arm with its rated load.
#
# From the robot file's masses where it has them. Else from a usual arm of this size: its moving mass follows
# payload and reach as those of published data sheets do, and sits where the drives of six-axis arms sit.

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
