"""What a program asked for, in the form a log is compared with: its moves, where they end, and the way between.

Places are compared as features [m]: the flange's position and, so that a turn of the wrist counts too, its rotation
at 0.3 m per radian. They do not depend on the tool or on the branch of the inverse kinematics.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from olp.core.diagnostic import Diagnostic, OlpError, error
from olp.robots.geometry import Pose, compose, invert, rotation_from_quaternion
from olp.runtime.plan import BlendCode, StepKind

if TYPE_CHECKING:
    from olp.identification.recording.log import Log
    from olp.robots.model import Robot
    from olp.timing.result import Timing

Floats = NDArray[np.float64]
_TURN = 0.3  # [m/rad] a turn of 1 deg weighs as 5 mm of travel
_MOST_SAMPLES = 20_000
_FINEST = 1e-3  # [s]
_NOWHERE = 1e-5  # [m]


@dataclass(frozen=True, slots=True)
class Moved:
    """m executed moves that go somewhere. Times [s] are the plan's, from the program's start."""

    timing: Timing
    step: NDArray[np.intp]  # (m,) in the plan
    idle: NDArray[np.intp]  # steps of moves that go nowhere
    begin: Floats
    end: Floats
    stops: NDArray[np.bool_]  # the arm stands at the move's end: exact stop, wait, or last move
    waits: NDArray[np.bool_]  # the program waits after the move
    programmed_wait: Floats  # (m,) [s] the wait as the program gives it; inf where its length was assumed

    def __len__(self) -> int:
        return len(self.step)


@dataclass(frozen=True, slots=True)
class ProgrammedPath:
    """Where the moves go: `point` (m + 1, c) features of where they begin and end, `way` (n, c) at `time` (n,) [s]."""

    point: Floats
    time: Floats
    way: Floats


def moved(timing: Timing) -> Moved:
    """The moves of a timed plan that go somewhere."""
    plan = timing.plan
    step = np.nonzero(plan.kind == StepKind.MOVE)[0]
    rows = plan.row[step]
    goes = ~(np.maximum(np.nan_to_num(plan.moves.length[rows], nan=1.0), _turning(timing, rows)) <= _NOWHERE)
    end = timing.end_s[step]
    begin = end - np.nan_to_num(timing.duration_s[step])
    # What a move that goes nowhere ends in, the move before it ends in.
    owner = np.cumsum(goes) - 1
    own = owner >= 0
    exact = np.zeros(int(goes.sum()), dtype=bool)
    waits = np.zeros(len(exact), dtype=bool)
    wait = np.zeros(len(exact))
    if len(exact):
        np.logical_or.at(exact, owner[own], (plan.moves.blend_code[rows] == BlendCode.EXACT)[own])
        pause = _waited(timing, step)
        np.logical_or.at(waits, owner[own], (pause > 1e-9)[own])
        np.add.at(wait, owner[own], (pause + np.where(_assumed(timing, step), np.inf, 0.0))[own])
        exact[-1] = True
    return Moved(timing, step[goes], step[~goes], begin[goes], end[goes], exact | waits, waits, wait)


def _assumed(timing: Timing, step: NDArray[np.intp]) -> NDArray[np.bool_]:
    """(m,): something between each move and the next lasts as long as olp assumed, not as the program says."""
    plan = timing.plan
    lines = [assumption.line for assumption in timing.assumptions if assumption.line]
    unsure = np.isin(plan.line, lines) & (plan.kind != StepKind.MOVE)
    total = np.concatenate([[0], np.cumsum(unsure)])
    return np.asarray(total[np.append(step[1:], len(plan))] > total[step], dtype=bool)


def _turning(timing: Timing, rows: NDArray[np.int32]) -> Floats:
    """(m,) [m] the turn of the tool and the travel of the axes, weighed as features are."""
    moves, axes = timing.plan.moves, timing.plan.positions.axes
    driven = np.abs(axes[moves.target[rows]] - axes[moves.start[rows]])
    largest = np.nan_to_num(driven).max(axis=1, initial=0.0)
    weighed: Floats = _TURN * np.maximum(np.nan_to_num(moves.angle[rows]), largest)
    return weighed


def _waited(timing: Timing, step: NDArray[np.intp]) -> Floats:
    """(m,) [s] of waits and signals between each move and the next."""
    pause = np.where(timing.plan.kind == StepKind.MOVE, 0.0, np.nan_to_num(timing.duration_s))
    total = np.concatenate([[0.0], np.cumsum(pause)])
    following = np.append(step[1:], len(timing.plan))
    between: Floats = total[following] - total[step]
    return between


def way_of(moves: Moved) -> ProgrammedPath:
    """Where the moves go. Raises OlpError: D040 when no place can be known, or when the plan has no time."""
    from olp.timing.track import track

    timing = moves.timing
    plan = timing.plan
    rows = plan.row[moves.step]
    chosen = np.concatenate([plan.moves.start[rows[:1]], plan.moves.target[rows]])
    point = features_of_axes(plan.robot, plan.positions.axes[chosen], plan.path)
    followed = track(timing, max(timing.total_s / _MOST_SAMPLES, _FINEST))
    way = features_of_axes(plan.robot, followed.axes, plan.path)
    if not np.isfinite(way).all() or not np.isfinite(point).all():
        raise OlpError(no_places(plan.path))
    return ProgrammedPath(point, followed.time, way)


def tool_of(moves: Moved) -> tuple[float, ...] | None:
    """x, y, z [m], Rx, Ry, Rz [rad] of the tool on the flange, None when it is not known or changes on the way."""
    from olp.robots.kinematics.configuration import forward

    plan = moves.timing.plan
    robot, positions = plan.robot, plan.positions
    if robot is None or robot.geometry is None or positions.axes.shape[1] < len(robot.axes) or not len(moves):
        return None
    at = plan.moves.target[plan.row[moves.step]]
    back = invert(*forward(robot, positions.axes[at][:, : len(robot.axes)]))
    place, turn = compose(*back, positions.position[at], rotation_from_quaternion(positions.quaternion[at]))
    if not (np.ptp(place, axis=0) < 1e-6).all() or not (np.ptp(turn, axis=0) < 1e-6).all():
        return None
    return tuple(Pose(place[0], turn[0]).xyz_angles().tolist())


def no_places(file: str) -> Diagnostic:
    """The finding (D040) that the points of a program cannot be compared with a log."""
    return error(
        "D040",
        "where the program's points are cannot be known",
        file=file,
        help="name the robot with --robot, or say --by dwell to count the stretches between stops",
    )


def features_of_axes(robot: Robot | None, axes: Floats, file: str) -> Floats:
    """(n, 12) [m] of axes (n, k) [rad | m]; nan where an axis is. Raises OlpError (D040)."""
    from olp.robots.kinematics.configuration import forward

    if robot is None or robot.geometry is None:
        raise OlpError(no_places(file))
    width = len(robot.axes)
    if axes.shape[1] < width:
        raise OlpError(no_places(file))
    position, rotation = forward(robot, axes[:, :width])
    # The chord between two rotations in this scale is their angle (for small ones) times _TURN.
    turned = rotation.reshape(len(rotation), 9) * (_TURN / np.sqrt(2.0))
    return np.concatenate([position, turned], axis=1)


def features_of_log(robot: Robot | None, log: Log) -> Floats:
    """(n, 12) [m] of the samples. Raises OlpError (D040, D021)."""
    if robot is not None and len(log.slides) != len(robot.axes):
        says = f"the log has {len(log.slides)} axes, {robot.name} has {len(robot.axes)}"
        raise OlpError(error("D021", says, file=log.file))
    return features_of_axes(robot, log.q, log.file)
