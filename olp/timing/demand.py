"""The limit that decides the duration of each move taken alone: the tool's travel, its reorientation, or the
slowest axis.

Each move becomes one length with one speed and one acceleration: in metres of the tool's path if the tool travels,
so that moves of different kinds can be blended.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from olp.core.diagnostic import Diagnostic
from olp.core.units import deg
from olp.ir.program import Path
from olp.robots.times_to_speed import turn_limits
from olp.runtime.plan import PATHS, Moves, Plan, distinct
from olp.timing.accelerations import MotionLimits, of_axes, of_lines

if TYPE_CHECKING:
    from olp.robots.model import Robot


Floats = NDArray[np.float64]
_JOINT = PATHS.index(Path.JOINT)
_NOTHING = 1e-9  # [m] or [rad]: below this nothing moves


@dataclass(slots=True)
class Demand:
    """Requirements of each row of Moves. `metric`: the length is metres of tool path (else radians of the leading
    axis).

    `rule`: index into `names` of the limit that decides at the programmed speed. `unknown`: cannot be timed.
    `slowed`: a line or curve that an axis makes slower; `diagnostics`: findings along the paths.
    """

    length: Floats
    speed: Floats
    acceleration: Floats
    deceleration: Floats
    metric: NDArray[np.bool_]
    rule: NDArray[np.int16]
    unknown: NDArray[np.bool_]
    slowed: NDArray[np.bool_]
    names: tuple[str, ...] = ()
    diagnostics: tuple[Diagnostic, ...] = ()


def demand(plan: Plan, limits: MotionLimits) -> Demand:
    """Length, speed, acceleration and deciding limit of each row of `plan.moves`."""
    moves = plan.moves
    count = len(moves)
    names = ["", "orientation"]
    result = Demand(
        length=np.zeros(count),
        speed=np.zeros(count),
        acceleration=np.zeros(count),
        deceleration=np.zeros(count),
        metric=np.ones(count, dtype=bool),
        rule=np.zeros(count, dtype=np.int16),
        unknown=np.zeros(count, dtype=bool),
        slowed=np.zeros(count, dtype=bool),
    )
    joint = moves.path == _JOINT
    if (~joint).any():
        _travel(plan, moves, np.nonzero(~joint)[0], limits, result)
    for mechanism in distinct(moves.mechanism[joint]):
        rows = np.nonzero(joint & (moves.mechanism == mechanism))[0]
        _axes(plan, moves, rows, mechanism, limits, result, names)
    # A move to where the mechanism stands takes no time, whatever is not known about it.
    still = result.unknown & (moves.start == moves.target)
    result.unknown[still] = False
    result.length[still] = 0.0
    for values in (result.speed, result.acceleration, result.deceleration):
        values[still] = 1.0
    result.acceleration *= moves.acceleration
    result.deceleration *= moves.deceleration
    if count:
        result.diagnostics = slow_down(plan, limits, result, names)
    # A rate of turning alone, of a move that does not turn: how fast it travels only the axes say, if any are known.
    endless = np.isinf(result.speed)
    result.unknown |= endless & (result.length > _NOTHING)
    result.speed[endless] = 1.0
    result.names = tuple(names)
    return result


def _travel(plan: Plan, moves: Moves, rows: NDArray[np.intp], limits: MotionLimits, out: Demand) -> None:
    """Lines, arcs and splines: the slower of travelling and turning."""
    length, angle = moves.length[rows], np.nan_to_num(moves.angle[rows])
    speed = moves.travel[rows].copy()
    turn_limit, turn_acceleration = turn_limits(plan.robot)
    turn = np.where(np.isnan(moves.turn[rows]), turn_limit, moves.turn[rows])
    by_turn = np.isnan(speed) & ~np.isnan(moves.turn[rows])
    speed[by_turn] = np.inf
    up, down = moves.rate[rows].copy(), moves.rate[rows].copy()
    silent = np.isnan(up)
    if silent.any():
        up[silent], down[silent] = of_lines(plan, rows[silent], speed[silent], limits)
    with np.errstate(divide="ignore", invalid="ignore"):
        travel_time = _rest_to_rest(length, speed, up)
        turn_time = _rest_to_rest(angle, turn, turn_acceleration)
        turning = (angle > _NOTHING) & ((turn_time > travel_time) | by_turn | (length <= _NOTHING))
        scale = np.where(length > _NOTHING, length / angle, 1.0)
    out.metric[rows] = ~(turning & (length <= _NOTHING))
    out.length[rows] = np.where(turning & (length <= _NOTHING), angle, length)
    # Travelling and turning start and stop together: whichever takes longer, neither may exceed its own limits.
    turns = angle > _NOTHING
    able = np.where(turns, turn * scale, np.inf)
    out.speed[rows] = np.where(turns & (length <= _NOTHING), able, np.minimum(speed, able))
    for column, push in ((out.acceleration, up), (out.deceleration, down)):
        travelling = np.where(length > _NOTHING, push, np.inf)
        column[rows] = np.where(turns, np.minimum(turn_acceleration * scale, travelling), push)
    out.rule[rows] = turning
    out.unknown[rows] = np.isnan(length) | (np.isnan(out.speed[rows]) & (out.length[rows] > _NOTHING))
    if (turning & np.isnan(moves.turn[rows])).any():
        where = plan.robot.name if plan.robot else "no robot known"
        limits.report(f"the tool turns at no more than {turn_limit / deg:.0f} deg/s ({where})")


def _axes(
    plan: Plan,
    moves: Moves,
    rows: NDArray[np.intp],
    mechanism: int,
    limits: MotionLimits,
    out: Demand,
    names: list[str],
) -> None:
    """Joint moves: all axes start and stop together; the slowest decides."""
    robot = plan.robots[mechanism]
    name = plan.mechanisms[mechanism]
    if robot is None:
        # A station of unknown axes is taken as never the slowest (reported by the cell); an arm cannot be.
        out.unknown[rows] = not name.startswith(("BS", "ST"))
        return
    axes = plan.positions.axes[:, : len(robot.axes)]
    distance = np.abs(axes[moves.target[rows]] - axes[moves.start[rows]])
    fraction = fractions(moves, rows, distance, robot)
    speed = fraction[:, None] * robot.speeds
    by_axis = ~np.isnan(moves.axis_speed[rows])
    speed[by_axis] = np.minimum(moves.axis_speed[rows][by_axis, None], robot.speeds)
    up, down = of_axes(plan, robot, rows, fraction, limits)
    said = moves.rate[rows, None]
    up, down = (np.where(np.isnan(said), push, said) for push in (up, down))
    longer = limits.axis_scale if robot is plan.robot else 1.0
    up, down = np.broadcast_to(up / longer, distance.shape), np.broadcast_to(down / longer, distance.shape)
    time = _rest_to_rest(distance, speed, up, down)
    out.unknown[rows] = np.isnan(time).any(axis=1) | np.isnan(fraction)
    slowest = np.argmax(np.nan_to_num(time), axis=1)
    pick = np.arange(len(rows)), slowest
    length = np.nan_to_num(moves.length[rows])
    turned = distance[pick]
    metric = (length > _NOTHING) & (turned > _NOTHING)
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        scale = np.where(metric, length / turned, 1.0)
    out.metric[rows] = metric
    out.length[rows] = np.where(metric, length, turned)
    out.speed[rows] = speed[pick] * scale
    out.acceleration[rows], out.deceleration[rows] = up[pick] * scale, down[pick] * scale
    first = len(names)
    names.extend(
        f"axis {axis}" if name.startswith("R") else f"{name} axis {axis}" for axis in robot.axis_names
    )
    out.rule[rows] = first + slowest


def fractions(moves: Moves, rows: NDArray[np.intp], distance: Floats, robot: Robot) -> Floats:
    """Fraction of rated speed (n,): as written, or as needed for the programmed speed of the tool or of the leading
    axis.
    """
    fraction = moves.fraction[rows].copy()
    other = np.isnan(fraction)
    if not other.any():
        return fraction
    length, angle = moves.length[rows], moves.angle[rows]
    with np.errstate(divide="ignore", invalid="ignore"):
        rated = np.max(distance / robot.speeds, axis=1)
        travel = length / moves.travel[rows]
        turn = np.where(np.isnan(moves.turn[rows]), 0.0, angle / moves.turn[rows])
        by_axis = np.max(distance, axis=1) / moves.axis_speed[rows]
        wanted = np.where(np.isnan(moves.axis_speed[rows]), np.fmax(travel, turn), by_axis)
        wanted = np.where(np.isnan(moves.duration[rows]), wanted, moves.duration[rows])
        share = np.where(rated > 0, np.minimum(rated / wanted, 1.0), 1.0)
    return np.where(other, share, fraction)


def _rest_to_rest(
    distance: Floats, speed: Floats, up: Floats | float, down: Floats | float | None = None
) -> Floats:
    """Time [s] from rest to rest at constant acceleration; only used to find the slowest of several demands."""
    with np.errstate(divide="ignore", invalid="ignore"):
        # Of two rates the one that takes both their times, 2/a = 1/up + 1/down, gives the same duration.
        acceleration = up if down is None else 2.0 / (1.0 / up + 1.0 / down)
        time: Floats = np.where(
            distance * acceleration >= speed * speed,
            distance / speed + speed / acceleration,
            2.0 * np.sqrt(distance / acceleration),
        )
    return np.where(distance <= 0.0, 0.0, time)


# --- Slowing ---
# Lines, arcs and splines slow down where an axis would have to turn faster than it can.


def slow_down(plan: Plan, limits: MotionLimits, out: Demand, names: list[str]) -> tuple[Diagnostic, ...]:
    """Lower the speeds of rows that an axis limits and name that axis; diagnostics on singularities, reach and soft
    limits.

    A row keeps one speed: the mean speed of a run that slows down only where the axis needs it.
    """
    from olp.timing.retiming.along import along_path

    found = along_path(plan, out.speed, out.acceleration)
    for says in found.assumptions:
        limits.report(says)
    out.slowed = found.known & ~out.unknown & (found.paced < out.speed)
    rows = np.flatnonzero(out.slowed)
    out.speed[rows] = found.paced[rows]
    for mechanism in distinct(plan.moves.mechanism[rows]):
        robot, name = plan.robots[mechanism], plan.mechanisms[mechanism]
        assert robot is not None
        some = rows[plan.moves.mechanism[rows] == mechanism]
        out.rule[some] = len(names) + found.axis[some]
        names.extend(
            f"axis {axis}" if name.startswith("R") else f"{name} axis {axis}" for axis in robot.axis_names
        )
    return found.diagnostics
