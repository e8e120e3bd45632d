"""Joint moves as the arm's law and the learnt corrections need them, whether they come from a recording or a plan."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Final, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from olp.robots.kinematics.configuration import Sweep
from olp.robots.model import Robot
from olp.robots.times_to_speed import reach_of
from olp.timing.arm import ArmTiming, JointMotions, gradient, posture_functions

Floats = NDArray[np.float64]
Mask = NDArray[np.bool_]
Rows = NDArray[np.intp]


@dataclass(frozen=True, slots=True, eq=False)
class JointMoves:
    """n joint moves: the inputs of the law, and the joints at both ends (n, k) [rad | m]."""

    motions: JointMotions
    start: Floats
    end: Floats

    def __len__(self) -> int:
        return len(self.start)

    def at_ends(self, ramps: Floats, stop: Floats) -> JointMoves:
        """The same moves with these shares of their ramps and stops at rest, (n,) [1] each."""
        return replace(self, motions=replace(self.motions, ramps=ramps, stop=stop))

    def take(self, rows: Rows | Mask) -> JointMoves:
        return JointMoves(self.motions.take(rows), self.start[rows], self.end[rows])


class JointTimes(NamedTuple):
    """Durations of joint moves and their intervals, (n,) [s] each; nan where unknown."""

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
    rated: float | None = None,
) -> JointMoves:
    """Joint moves from the joints at both ends (n, k) [rad | m].

    `fraction`, `acceleration`, `override` (n,) [1]; `payload` (n,) [kg] and its `inertia` (n,) [kg m²]. `rated`: the
    rated load's, None for a usual one.
    """
    turned = np.abs(end - start)
    taken = Taken(*np.repeat(turned[None, :, :, None], 2, axis=0))
    if robot is not None:
        taken = taken_of_drives(robot, np.nan_to_num(start), np.nan_to_num(end), payload, inertia, rated)
    motions = JointMotions(
        turned,
        posture_functions((start + end) / 2),
        taken.arm,
        taken.load,
        np.zeros(start.shape) if robot is None else np.broadcast_to(load_balance(robot, rated), start.shape),
        fraction,
        acceleration,
        override,
        np.ones(len(start)),
        np.ones(len(start)),
    )
    return JointMoves(motions, start, end)


class JointLaw(Protocol):
    """A law that times joint moves: the prior law of an arm, or one with corrections learnt from recordings."""

    @property
    def timing(self) -> ArmTiming: ...

    @property
    def quantile(self) -> float:
        """Half-width of a 95 % interval in standard deviations."""

    def predict(self, moves: JointMoves) -> JointTimes: ...


class PriorArm(NamedTuple):
    """The law with prior knowledge only: no recorded move of the arm."""

    timing: ArmTiming
    quantile: float = 1.96

    def predict(self, moves: JointMoves) -> JointTimes:
        duration = self.timing.durations(moves.motions)
        wide = np.exp(self.quantile * self.timing.spread(moves.motions))
        return JointTimes(duration, duration / wide, duration * wide)


def total_half(law: JointLaw, moves: JointMoves, often: Floats) -> float:
    """Half-width [s] of the 95 % interval of the total time; `often` (n,): how many times each move runs.

    Errors of the law's parameters are common to all moves; the scatter of each move is independent.
    """
    timing = law.timing
    seconds = timing.durations(moves.motions) * often
    pull = seconds @ gradient(timing.mean, moves.motions)
    variance = float(pull @ timing.covariance @ pull) + float(np.sum((seconds * timing.scatter) ** 2))
    return law.quantile * float(np.sqrt(variance))


# --- Arm inertia ---
# What a move takes of each drive, over what the stretched arm with its rated load would take.
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
_NOTHING: Final = 1e-6  # of the largest inertia: of a wrist's axes the point masses say nothing
# ln of the rated load's inertia over the arm's own about a wrist's axis: the masses that Universal Robots publishes of
# the UR10e say 3.1, 5.3 and 7.7 for the fourth to the sixth.
_WRIST_BALANCE: Final = 3.0
_GRID: Final = 13
_USUAL_PAYLOAD: Final = 10.0  # [kg] where neither robot nor recording tells one


class Taken(NamedTuple):
    """Drive use at both ends of moves (n, k, 2) [rad | m], by the `arm` alone and by the `load`.

    Torque per acceleration along the move, signed in the direction in which the axis turns, divided by the largest
    inertia of the arm and of the rated load about this axis: the turn that would use as much of the drive if the
    axis moved alone with the arm stretched. Axes that turn together use more or less than each alone.
    """

    arm: Floats
    load: Floats


def rated_inertia(robot: Robot) -> float:
    """[kg m²] that a usual load of the rated mass has about its centre."""
    reach = 0.0 if robot.geometry is None else reach_of(robot.geometry)
    return (robot.payload or _USUAL_PAYLOAD) * (_GYRATION * reach) ** 2


def taken_of_drives(
    robot: Robot,
    start: Floats,
    end: Floats,
    payload: Floats | None = None,
    inertia: Floats | None = None,
    most_inertia: float | None = None,
) -> Taken:
    """Drive use of moves from `start` to `end` (n, k) [rad | m]; `payload` (n,) [kg] and its own `inertia` (n,) [kg
    m²]; `most_inertia` [kg m²] of the rated load, None for a usual one.

    A payload of None or nan stands for half of the rated one.
    """
    count, axes = start.shape
    turn = end - start
    forward = np.where(turn < 0, -1.0, 1.0)[:, :, None]
    if robot.geometry is None or axes != len(robot.axes):
        share = np.full(count, np.nan) if payload is None else payload / (robot.payload or _USUAL_PAYLOAD)
        alike = np.repeat(np.abs(turn)[:, :, None], 2, axis=2)
        return Taken(alike, _known(share)[:, None, None] * alike)
    rated = robot.payload or _USUAL_PAYLOAD
    gyration = rated_inertia(robot) if most_inertia is None else most_inertia
    mass = _known(np.full(count, np.nan) if payload is None else payload / rated)
    own = mass if inertia is None else np.where(np.isnan(inertia), mass, inertia / gyration)
    most = _most(robot)
    both = _bodies(robot, np.concatenate([start, end]), np.concatenate([turn, turn]))
    bodies = _Bodies(*(np.stack([values[:count], values[count:]], axis=2) for values in both))
    told = _told(most.arm)
    arm = np.where(told[:, None], bodies.arm / np.where(told, most.arm, 1.0)[:, None], turn[:, :, None])
    load = (rated * mass)[:, None, None] * bodies.lever + (gyration * own)[:, None, None] * bodies.spin
    return Taken(forward * arm, forward * load / (rated * most.lever + gyration)[:, None])


def _told(inertia: Floats) -> Mask:
    """Axes (k,) about which the arm's masses have a known inertia."""
    return np.asarray(inertia > _NOTHING * inertia.max(initial=0.0))


@lru_cache(maxsize=64)
def load_balance(robot: Robot, inertia: float | None = None) -> Floats:
    """Logarithm of the rated load's inertia at full reach over that of the stretched arm (k,); the usual value of a
    wrist where the arm's inertia is unknown. `inertia` [kg m²] of that load about its centre, None for a usual one.
    """
    if robot.geometry is None:
        return np.zeros(len(robot.axes))
    most = _most(robot)
    own = rated_inertia(robot) if inertia is None else inertia
    load = (robot.payload or _USUAL_PAYLOAD) * most.lever + own
    told = _told(most.arm)
    return np.where(told, np.log(load / np.where(told, most.arm, 1.0)), _WRIST_BALANCE)


def _known(share: Floats) -> Floats:
    return np.where(np.isnan(share), 0.5, share)


class _Bodies(NamedTuple):
    """Torques per acceleration along a move, (n, k) each: of the arm, of a load per mass, and of a load per inertia."""

    arm: Floats  # [kg m²]
    lever: Floats  # [m²]
    spin: Floats  # [1]


@lru_cache(maxsize=64)
def _most(robot: Robot) -> _Bodies:
    """Largest inertia of the arm about each axis (k,), and the largest squared lever of the load."""
    axes = len(robot.axes)
    grid = np.zeros((_GRID * _GRID, axes))
    ranges = [
        np.linspace(robot.lower[i], robot.upper[i], _GRID) if i < axes else np.zeros(_GRID) for i in (1, 2)
    ]
    second, third = np.meshgrid(*ranges)
    if axes > 2:
        grid[:, 1], grid[:, 2] = second.ravel(), third.ravel()
    alone = [_bodies(robot, grid, np.tile(unit, (len(grid), 1))) for unit in np.eye(axes)]
    return _Bodies(*(np.array([one[i][:, axis].max() for axis, one in enumerate(alone)]) for i in range(3)))


def _bodies(robot: Robot, joints: Floats, turn: Floats) -> _Bodies:
    """Torques per acceleration at the poses `joints` (n, k) of moves by `turn` (n, k)."""
    from olp.robots.kinematics.configuration import geometry_of, sweep

    geometry = geometry_of(robot)
    swept = sweep(robot, geometry, joints.T)
    reach = reach_of(geometry)
    load = swept.position + swept.columns[2] * (_LEVER * reach)
    numbers = [joint.axis for joint in geometry.joints]
    turns = [turn[:, axis] for axis in numbers]
    arm, lever, spin = (np.zeros(joints.shape) for _ in range(3))
    turning = sum((axis * by for axis, by in zip(swept.axes, turns, strict=True)), np.zeros_like(load))
    for axis, direction in zip(numbers, swept.axes, strict=True):
        spin[:, axis] = np.sum(direction * turning, axis=0)
    _add(lever, load, 1.0, swept, numbers, turns)
    if robot.dynamics is not None:
        from olp.robots.dynamics.torques import dynamic_model, mass_matrix

        arm = np.einsum("nij,nj->ni", mass_matrix(dynamic_model(robot), joints), turn)
    else:
        for point, mass, last in _points(robot, swept.origins, reach):
            _add(arm, point, mass, swept, numbers[: last + 1], turns)
    return _Bodies(arm, lever, spin)


def _add(
    torques: Floats, point: Floats, mass: float, swept: Sweep, numbers: list[int], turns: list[Floats]
) -> None:
    """Adds the torque that a point mass (3, n) needs from each of the axes `numbers` that carry it."""
    ways = []
    moved = np.zeros_like(point)
    for direction, origin, turn in zip(swept.axes, swept.origins, turns[: len(numbers)], strict=False):
        (ax, ay, az), (x, y, z) = direction, point - origin
        way = np.stack([ay * z - az * y, az * x - ax * z, ax * y - ay * x])
        ways.append(way)
        moved += way * turn
    for axis, way in zip(numbers, ways, strict=True):
        torques[:, axis] += mass * np.sum(way * moved, axis=0)


def _points(robot: Robot, origins: list[Floats], reach: float) -> list[tuple[Floats, float, int]]:
    """Point masses of the arm: position (3, n) [m], mass [kg] and the last joint that carries the mass."""
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
