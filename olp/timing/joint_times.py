"""The arm's law applied to a plan: the time of each joint move, and the speed and acceleration of a profile that
takes as long.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from olp.ir.program import Path
from olp.runtime.plan import PATHS, Plan
from olp.timing.arm_moves import JointLaw, JointMoves, JointTimes, joint_moves, total_half
from olp.timing.demand import Demand, fractions
from olp.timing.path_law import SCATTER

if TYPE_CHECKING:
    from olp.robots.model import Robot

Floats = NDArray[np.float64]
Mask = NDArray[np.bool_]
Rows = NDArray[np.intp]
_JOINT = PATHS.index(Path.JOINT)
_AT_MOST = 0.5  # of a move that is for its stop
_NORMAL = 1.96
KNOWN_DOUBT: Final = 0.25  # of the logarithm of accelerations that somebody has programmed or published
_SHOWN = 0.005  # [s] a doubt that is shown as more than nothing
_CRUISE = 0.9  # of a move faster than its rated speeds that it runs at constant speed


class TimedJoints(NamedTuple):
    """`rows` (m,) of Moves that `law` timed from rest to rest; `stop` (m,) [s]: the part of `times` that the stop
    costs.
    """

    rows: Rows
    moves: JointMoves
    times: JointTimes
    stop: Floats
    law: JointLaw


def time_joints(
    plan: Plan, wanted: Demand, law: JointLaw, overrides: Floats, payload: float | None
) -> TimedJoints:
    """Times the arm's joint moves by `law`; those that program an acceleration or a time of their own keep it.

    `overrides` (m,) [1] of the rows of Moves. `payload` [kg]: used where the plan sets none; None: unknown. Writes
    speeds and accelerations into `wanted` such that a profile of constant acceleration takes the time of the law
    without its stop.
    """
    robot, moves = plan.robot, plan.moves
    if robot is None or len(robot.axes) != len(law.timing.axes):
        return _none(law)
    mine = np.array([other is robot for other in plan.robots], dtype=bool)[moves.mechanism]
    mine &= (moves.path == _JOINT) & ~wanted.unknown & (wanted.length > 0)
    mine &= np.isnan(moves.rate) & np.isnan(moves.duration)
    rows = np.flatnonzero(mine)
    if not len(rows):
        return _none(law)
    joints = _moves(plan, robot, rows, overrides[rows], payload, law.timing.load_inertia)
    times = law.predict(joints)
    good = np.isfinite(times.duration) & (times.duration > 0)
    rows, joints = rows[good], joints.take(good)
    times = JointTimes(*(values[good] for values in times))
    stop = np.clip(law.timing.stop, 0.0, _AT_MOST * times.duration)
    _demand(wanted, rows, times.duration - stop)
    _name(wanted, rows, robot, law.timing.axis_times(joints.motions))
    return TimedJoints(rows, joints, times, stop, law)


def _none(law: JointLaw) -> TimedJoints:
    axes, nothing = np.zeros((0, len(law.timing.axes))), np.zeros(0)
    moves = joint_moves(None, axes, axes, nothing, nothing, nothing)
    return TimedJoints(np.zeros(0, dtype=np.intp), moves, JointTimes(nothing, nothing, nothing), nothing, law)


def _moves(
    plan: Plan, robot: Robot, rows: Rows, override: Floats, payload: float | None, rated: float | None
) -> JointMoves:
    """`payload` [kg]: as in `time_joints`; `rated` [kg m²]: as in `joint_moves`."""
    moves, axes = plan.moves, plan.positions.axes[:, : len(robot.axes)]
    start, end = axes[moves.start[rows]], axes[moves.target[rows]]
    fraction = fractions(moves, rows, np.abs(end - start), robot)
    fraction = np.where(np.isfinite(fraction) & (fraction > 0), fraction, 1.0)
    acceleration = np.where(moves.acceleration[rows] > 0, moves.acceleration[rows], 1.0)
    load, inertia = np.full(len(rows), np.nan if payload is None else payload), None
    if plan.conditions is not None:
        told, inertia = plan.conditions.payload[rows], plan.conditions.inertia[rows]
        load = np.where(np.isnan(told), load, told)
    return joint_moves(robot, start, end, fraction, acceleration, override, load, inertia, rated)


def _demand(wanted: Demand, rows: Rows, seconds: Floats) -> None:
    """Write the speed and acceleration of a profile that takes `seconds` from rest to rest into `wanted`."""
    length = wanted.length[rows]
    speed = np.maximum(wanted.speed[rows], length / (_CRUISE * seconds))
    cruise = length / speed
    ramp = seconds - cruise
    acceleration = np.where(ramp <= cruise, speed / ramp, 4.0 * length / seconds**2)
    wanted.speed[rows] = speed
    wanted.acceleration[rows] = acceleration
    wanted.deceleration[rows] = acceleration


def _name(wanted: Demand, rows: Rows, robot: Robot, axis_times: Floats) -> None:
    """Name the slowest axis by the law as the deciding limit."""
    places = {name: place for place, name in enumerate(wanted.names)}
    code = np.array([places.get(f"axis {axis}", -1) for axis in robot.axis_names])
    found = code[np.argmax(axis_times, axis=1)]
    wanted.rule[rows] = np.where(found >= 0, found, wanted.rule[rows])


def expected_total(
    plan: Plan, wanted: Demand, rows: Floats, total: float, timed: TimedJoints | None, line_doubt: float
) -> tuple[float, float]:
    """Ends [s] of a 95 % interval of `total` by prior knowledge of such arms.

    `rows` (k,) [s]: duration of each row of Moves; `line_doubt`: standard deviation of the logarithm of the
    acceleration of lines whose program sets none. For rows that the arm's law does not time, the time beyond length
    over speed is uncertain: with an error common to all rows, and an independent scatter of each move.
    """
    half = 0.0 if timed is None else _half(plan, timed)
    half = float(np.hypot(half, _scatter(plan, rows, timed)))
    below, above = (float(ends.sum()) for ends in _lines_doubt(plan, wanted, rows, timed, line_doubt))
    return max(total - float(np.hypot(half, below)), 0.0), total + float(np.hypot(half, above))


def _scatter(plan: Plan, rows: Floats, timed: TimedJoints | None) -> float:
    """Scatter [s] of the rows that the arm's law does not time; repeats of a move share one error."""
    moves, lasting = plan.moves, np.nan_to_num(rows)
    if timed is not None:
        lasting[timed.rows] = 0.0
    keys = np.stack([moves.start, moves.target, moves.via], axis=1)
    inverse = np.unique(keys, axis=0, return_inverse=True)[1].reshape(-1)
    return _NORMAL * SCATTER * float(np.sqrt(np.sum(np.bincount(inverse, lasting) ** 2)))


def _lines_doubt(
    plan: Plan, wanted: Demand, rows: Floats, timed: TimedJoints | None, line_doubt: float
) -> tuple[Floats, Floats]:
    """Uncertainty below and above (k,) [s] each of the rows that the arm's law does not time."""
    with np.errstate(divide="ignore", invalid="ignore"):
        cruise = np.nan_to_num(wanted.length / wanted.speed, posinf=0.0)
    ramps = np.nan_to_num(np.maximum(rows - cruise, 0.0), posinf=0.0)
    if timed is not None:
        ramps[timed.rows] = 0.0
    return ramp_doubt(ramps, cruise, np.where(_told(plan), KNOWN_DOUBT, line_doubt))


def _told(plan: Plan) -> Mask:
    """Rows of Moves (k,) that are joint moves, or whose acceleration or time is programmed."""
    moves = plan.moves
    return np.asarray((moves.path == _JOINT) | np.isfinite(moves.rate) | np.isfinite(moves.duration))


def ramp_doubt(ramps: Floats, cruise: Floats, doubt: Floats) -> tuple[Floats, Floats]:
    """Uncertainty below and above (n,) [s] each, at 95 %, of the time of moves beyond `cruise` [s], their length at
    full speed.

    `ramps` [s]: this time at constant acceleration; `doubt`: standard deviation of its logarithm. At a lower
    acceleration a short move no longer reaches its speed, and its time grows with the square root only.
    """
    wide = np.exp(_NORMAL * doubt)
    even = np.maximum(cruise, 1e-12)
    whole = np.where(ramps <= cruise, ramps, (ramps + even) ** 2 / (4.0 * even))  # if it reached its speed

    def at(factor: Floats) -> Floats:
        longer = whole * factor
        return np.where(longer <= even, longer, 2.0 * np.sqrt(even * longer) - even)

    return np.maximum(ramps - at(1.0 / wide), 0.0), np.maximum(at(wide) - ramps, 0.0)


def _half(plan: Plan, timed: TimedJoints) -> float:
    """Half-width [s] of the 95 % interval of the sum of the timed joint moves; repeats of a move share one error."""
    if not len(timed.rows):
        return 0.0
    moves, runs = _distinct(plan, timed)
    return total_half(timed.law, moves, runs)


def _distinct(plan: Plan, timed: TimedJoints) -> tuple[JointMoves, Floats]:
    """The moves without repeats, and how often each of them runs."""
    keys = np.stack([plan.moves.start[timed.rows], plan.moves.target[timed.rows]], axis=1)
    _, first, often = np.unique(keys, axis=0, return_index=True, return_counts=True)
    return timed.moves.take(first), often.astype(np.float64)


def line_doubt_of(
    plan: Plan, wanted: Demand, rows: Floats, timed: TimedJoints | None, line_doubt: float
) -> list[str]:
    """Sentences on the uncertainty that an unpublished acceleration of lines adds to this plan, and how to narrow
    it.
    """
    own = ~_told(plan)
    below, above = (float(ends[own].sum()) for ends in _lines_doubt(plan, wanted, rows, timed, line_doubt))
    if above < _SHOWN:
        return []
    arm = "this arm" if plan.robot is None else plan.robot.name
    return [
        f"lines and arcs: {-below:.2f} to {above:+.2f} s (95 %) by their acceleration, which is not published for "
        f"{arm}; twenty recorded moves would determine it (olp probe, olp calibrate)"
    ]


def doubt_of(plan: Plan, timed: TimedJoints) -> list[str]:
    """Sentences on the uncertainty of these moves, its main contributions, and how to narrow it."""
    if not len(timed.rows) or plan.robot is None:
        return []
    moves, half = _distinct(plan, timed)[0], _half(plan, timed)
    seconds = float(timed.times.duration.sum())
    names = [name for name, _ in timed.law.timing.doubts(moves.motions)[:2]]
    return [
        f"joint moves of {plan.robot.name}: {seconds:.2f} s ± {half:.2f} (95 %), most of it by {' and '.join(names)}, "
        "which is not published; twenty recorded moves would determine it (olp probe, olp calibrate)"
    ]
