"""From a recording to the case that the terms see: ways, speeds, the simulation's motion, each move's circumstances.

Code: N010 nothing to judge.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from olp.core.diagnostic import OlpError, error
from olp.identification.diagnosis import phrasing
from olp.identification.diagnosis.axis_rates import AxisLimits, limits_from_times, rates_of, tool_ways
from olp.identification.diagnosis.simulation_laws import (
    FEWEST,
    GOLDEN,
    NO_RAMP,
    ONE_ACCELERATION,
    SOME_ROUNDING,
    TURNS,
    SimulatedRamps,
    TurnLimits,
    as_long_as,
    averaged_at_corners,
    cornered,
    golden_section,
    inferred,
    last_digit,
    limited,
    nearer_at_corners,
    of_their_own,
    ramps_beside,
    ramps_by_corners,
    ramps_of,
    ramps_that_fit,
    told_at_corners,
    trapezoid,
    tuned,
    turning_limits,
    turning_limits_at_corners,
)
from olp.identification.recording.moves import CIRCULAR, JOINT, LINEAR, WAIT, RecordedMoves
from olp.runtime.folder import DEFAULT_ZONES
from olp.timing.accelerations import MotionLimits, constant_axes
from olp.timing.physics._case import CornerPartners, MeasuredMoves, Rivals
from olp.timing.physics._motion import Motion, MoveCorners

if TYPE_CHECKING:
    from olp.identification.recording.recording import Recording
    from olp.robots.model import Robot


Floats = NDArray[np.float64]
Mask = NDArray[np.bool_]
Rows = NDArray[np.int64]

_JOINT_RAMP = 0.3  # of a joint move's time that goes into ramps, where nothing tells speed and ramp apart
_SLOWER = 1.5  # times what a joint move takes at 100 %: it was programmed at less
_STRETCHED = 0.1  # [1] of a change of speeds: so near to its square is that of the accelerations
_FEW_ENDS, _FEW_LIKE = 3, 8  # of cycles, and corners or stops to compare them with: fewer tell nothing
_SHOWN = 8  # moves named in a note
_NEAR = 1e-4  # [m | rad] a move that starts this near to the last one's end goes on from it
_FEW = 0.5  # of the moves: fewer that cannot be judged are left out, more are judged with a note
_CUT_OFF = 6.0  # times what moves are off the simulation's law in the middle: such a one has a corner unknown
_COUNTED = 0.5  # of the moves have the number after the last one's: numbers count moves
_STRAIGHT_ON = 1e3  # times the rounding: a corner with an arc of that radius is none
_CORNERS_RIGHT = 5e-4  # [s] nearer to a simulation than that, a law of corners is its own
_NEARER = 0.25  # times what a plainer law of ramps is off: so near another one has to come
# [s] that lines are off: less is not worth a search among times in which accelerations build up, which takes 10 s.
_WORTH_A_SEARCH = 1e-3
_IN_TURN = (
    3  # times that the law of corners and limits of the tool's turn, or stops at corners, tell each other
)
_NEARER_IN_TURN = 0.7  # times what the last ones are off: less is no other law
_LEAST_BUILT = 5e-3  # [s] in which accelerations build up: less is digits
# Of the time beside the ramps that corners tell without, and steps of its search; times what they leave without: so
# near it has to come where the acceleration is not told anew.
_BUILT, _BUILT_STEPS, _NEAR_BUILT = (0.3, 1.2), 7, 0.5
_BACK = math.radians(120.0)  # a corner that turns by more turns back
_ANGLES = 24  # of such corners that are tried
_SAME_TIME = 0.1  # times a time beside the ramps: laws that differ by less are one simulation
# What the recorded durations say of the simulation.
_ONE_JERK = (
    "the simulated durations do not tell whether accelerations build up at one jerk or in one time; one jerk explains "
    "the recorded durations better, and findings are relative to that"
)
_BUILT_UP = (
    "the simulated durations do not tell a time at each stop from one in which accelerations build up; the second "
    "explains the recorded durations better, and findings are relative to that"
)
_ONE_TIME = 0.02  # of a time: times of lines and joint moves that differ by no more are one
_SPARE = 8.0  # times what its ramp takes, of a drive that the controller's shortest ramp leaves idle
_PLACES = 5  # decimals of metres in which ways are alike
_TELLING_RAMP = 0.01  # [s] digits hide what acceleration a shorter one has
_ODD_LINES = 0.1  # of the lines may have a time that the limits of slides do not tell
_ASKED_OF_SLIDES = 0.5  # [1] of the tool's acceleration, the least that a slide has
_SLIDES = ((2,), (0,), (1,), (0, 2), (1, 2), (0, 1))  # that may be weaker; often the lifting one is
_SIZES, _SIZE_STEPS = (0.2, 0.35, 0.5, 0.7, 1.4, 2.0, 2.8), 16  # [1] of a written rounding, to begin with
_STEADY = 6  # lines between stops that differ and do not turn the tool: fewer are no law
_REACHED = 1.2  # times the speed at which an acceleration that builds up is reached, as far as it is known
_FOR_EACH = 2  # joint moves for each limit of an axis: fewer leave most limits unknown


class Making(NamedTuple):
    """A case, the rows of the recording's moves that are in it, and what was assumed or left out."""

    case: MeasuredMoves
    rows: Rows
    notes: tuple[str, ...]


class MoveEnds(NamedTuple):
    """Where the moves of a recording stop exactly, each (n,)."""

    start: Mask  # begins at an exact stop
    end: Mask  # ends in one
    before: Rows  # row of the move that each goes on from, -1 for none
    twice: Mask  # rows that record the move of the row before once more
    other: MoveEnds | None = None  # where the last moves of cycles, if rounded, end otherwise; None: none is

    def rounded_from(self, blend: Floats) -> Floats:
        """(n,) [m] rounding at each move's start; `blend` (n,) [m]: at its end."""
        return np.where(self.before >= 0, blend[self.before], 0.0)


class _Pace(NamedTuple):
    """Way, speed and acceleration of moves; nan where they cannot be told."""

    way: Floats
    speed: Floats
    acceleration: Floats
    override: Floats  # [1] under which the judged simulation ran; it is in `speed`
    leading: NDArray[np.intp]  # the axis that leads a joint move, -1 in others
    axes: AxisLimits | None = None  # read off the simulated times of joint moves
    rated_ramps: tuple[
        Floats, ...
    ] = ()  # (n,) each: of joint moves by a robot's accelerations, by several laws
    guessed: Mask | None = None  # (n,) of these, speed and ramps are good for corners alone: not judged
    tool_way: Floats | None = None  # (n,) [m] of the tool, in all moves, where joint moves are rounded
    turn: Floats | None = (
        None  # (n,) [rad] by which straight and curved moves turn the tool, 0 where that is not known
    )


class JudgedTimes(NamedTuple):
    """(n,) [s] of the simulation that is judged, and of that what stops are known to cost at any speed."""

    duration: Floats
    stop: Floats
    own: bool  # olp's own prediction, which knows under which override the robot ran


def case_beside(recording: Recording, judged: JudgedTimes | None, notes: list[str]) -> Making:
    """All measured moves whose judged duration is known; adds what was assumed to `notes`. Raises OlpError N010.

    Without `judged`: all beside constant accelerations, as written or of the robot.
    """
    moves = recording.moves
    pace = _pace(recording, judged is not None and judged.own, notes)
    waiting = moves.kind == WAIT
    known = np.isfinite(pace.way) & np.isfinite(pace.speed) & (pace.way > 0)
    if pace.guessed is not None:
        known &= ~pace.guessed
    told = np.isfinite(pace.acceleration) if judged is None else np.isfinite(judged.duration)
    # The digits of a clock round less than one of them to nothing, not a motion that takes longer.
    least = np.where(known & ~waiting, pace.way / np.where(pace.speed > 0, pace.speed, np.inf), 0.0)
    timeless = (moves.duration == 0) & (least > recording.noise_floor().resolution)
    if timeless.any():
        which = ", ".join(map(str, moves.move[timeless][:_SHOWN].tolist()))
        more = ", …" if timeless.sum() > _SHOWN else ""
        notes.append(f"not judged: a duration of 0 s, which no motion takes, of move {which}{more}")
    rows = np.nonzero(moves.measured & ~timeless & told & (known | waiting))[0].astype(np.int64)
    if not len(rows):
        raise OlpError(
            error(
                "N010",
                "no move has a measured duration, a simulated one, and a length and speed to explain them by",
                file=recording.path,
                help="give duration_s, TCP points with speed_mm_s or joints with speed_pct, and sim_s or the robot",
            )
        )
    left = len(moves) - len(rows)
    if left:
        notes.append(
            f"{left} of {len(moves)} moves are not judged: no duration, simulation, length or known speed"
        )
    case = _case(recording, rows, pace, judged, notes)
    cut = _cut_off(case, moves, rows)
    if cut.any():
        which = phrasing.counted(int(cut.sum()), "move")
        notes.append(f"not judged: {which} next to one that was not recorded: its corner there is not known")
        case, rows = case.take(np.flatnonzero(~cut)), rows[~cut]
    return Making(case, rows, tuple(notes))


def _cut_off(case: MeasuredMoves, moves: RecordedMoves, rows: Rows) -> Mask:
    """(m,) Moves of the `rows` that come before or after one that nobody recorded, and are far off the simulation's law
    from stop to stop, which its other moves keep."""
    place = _executed(moves)
    gap = np.append(np.diff(place) > 1, False)
    later = moves.move[0] > 1 and np.array_equal(moves.move - moves.move[0], place)  # than the first move
    beside = (gap | np.append(later, gap[:-1]))[rows]
    off, others = np.abs(case.base.duration() - case.simulated), case.moving & ~beside
    if not beside.any() or not others.any() or beside.sum() > _FEW * len(rows):
        return np.zeros(len(rows), dtype=bool)
    far = max(_CORNERS_RIGHT, _CUT_OFF * float(np.median(off[others])))
    return np.asarray(beside & (off > far) & case.moving)


def as_simulated_otherwise(case: MeasuredMoves) -> list[tuple[MeasuredMoves, str]]:
    """The same moves beside other laws with which the simulated durations are the same, and what a note says of each:
    recorded durations tell which it is, where the robot changes what these laws differ in."""
    others = (_with_one_jerk(case), _ONE_JERK), (_with_stops_built_up(case), _BUILT_UP)
    return [(other, says) for other, says in others if other is not None]


def _with_stops_built_up(case: MeasuredMoves) -> MeasuredMoves | None:
    """The same moves, where the time at each stop is that in which accelerations build up; None where another time
    stands beside the ramps, or that is not the same simulation."""
    base, here = case.base, case.moving
    times = base.added[here]
    beside = (
        base.build.any() or base.filtered.any() or base.shortest.any() or np.isfinite(base.jerk[here]).any()
    )
    if beside or not len(times) or times.min() < _LEAST_BUILT or np.ptp(times) > 0.0:
        return None
    stop = np.where(here, base.added, 0.0)
    other = base.with_(added=base.added - stop, build=stop)
    same = np.abs(other.duration() - base.duration())[here].max() < _SAME_TIME * float(times[0])
    return replace(case, base=other, derived={}) if same else None


def _with_one_jerk(case: MeasuredMoves) -> MeasuredMoves | None:
    """The same moves, where accelerations of lines that build up in a time do so at one jerk; None where that is not
    the same simulation, as its accelerations differ, or where nothing builds up.

    The simulation leaves open how long another acceleration, which only the robot has, takes to build up.
    """
    base = case.base
    built = (base.build > 0) & ~case.joint
    ramps = np.concatenate([base.accelerate[built], base.decelerate[built]])
    if not built.any() or np.ptp(ramps) > ONE_ACCELERATION * float(ramps.max()):
        return None
    jerk = np.where(built, base.accelerate / np.where(built, base.build, 1.0), base.jerk)
    return replace(case, base=base.with_(jerk=jerk, build=np.where(built, 0.0, base.build)), derived={})


def _case(
    recording: Recording, rows: Rows, pace: _Pace, judged: JudgedTimes | None, notes: list[str]
) -> MeasuredMoves:
    moves = recording.moves
    late = np.full(len(moves), np.nan) if judged is None else moves.duration - judged.duration
    ends = _ends(moves, pace.speed, late)
    resolution = recording.settings.time_resolution
    floor = recording.noise_floor()
    blend = _blends(recording, notes)
    moving = moves.kind[rows] != WAIT
    if judged is None:
        base = _as_written(pace, rows, moving, ends, blend)
        base = _opened(base, moves, rows, ends, base.accelerate)
        corners = _corners(moves, pace, rows, ends.before, base.speed, base.accelerate)
        base, stretch = base.with_(corners=corners), 1.0
    else:
        asked = _Judged(moves, rows, pace, judged, ends, blend, floor.resolution)
        ends, made = _simulated_ends(asked)
        base, stretch = made.motion, made.stretch
        notes.extend(made.notes)
    stop_start, stop_end, before, *_ = ends
    blend_start = ends.rounded_from(blend)
    simulated = base.duration() if judged is None else judged.duration[rows]
    rates, told = rates_of(recording, rows, np.where(base.way > 0, base.way, 1.0))
    if rates is not None and rates.rated is None and pace.axes is not None:
        rated, likely = pace.axes.likely_speeds
        rates = replace(rates, rated=rated, rated_acceleration=pace.axes.accelerations)
        if likely.any():
            axes = phrasing.listed([rates.names[axis] for axis in np.flatnonzero(likely).tolist()])
            notes.append(
                f"no simulated joint move reaches the highest speed of {axes}: taken to be reached in the time that "
                "the other axes take for theirs"
            )
    notes.extend(told)
    case = MeasuredMoves(
        move=moves.move[rows],
        measured=moves.duration[rows],
        simulated=simulated,
        base=base,
        moving=moving,
        joint=moves.kind[rows] == JOINT,
        start=moves.start[rows],
        end=moves.end[rows],
        turn=_turn(moves)[rows],
        stop_start=stop_start[rows],
        stop_end=(stop_end & _is_told(moves))[rows],
        blend=blend[rows],
        blend_start=blend_start[rows],
        corner=_corner(moves)[rows],
        payload=moves.payload[rows],
        payload_inertia=moves.payload_inertia[rows],
        t_start=moves.t_start[rows],
        cycle=moves.cycle[rows],
        job=tuple(moves.job[i] for i in rows.tolist()),
        line=moves.line[rows],
        rates=rates,
        resolution=float(np.nan_to_num(resolution if resolution is not None else floor.resolution)),
        polled=floor.resolution if floor.polled else 0.0,
        covariates={name: values[rows] for name, values in moves.covariates.items()},
        repeats=recording.repeats()[rows],
        place=_executed(moves)[rows],
        sim_payload=moves.sim_payload[rows],
        sim_payload_inertia=moves.sim_payload_inertia[rows],
        override=(_whole(moves.override) / pace.override)[rows],
        stretch=stretch,
        partners=_partners(rows, before),
        began=float(np.nanmin(moves.t_start)) if np.isfinite(moves.t_start).any() else math.nan,
    )
    if pace.axes is not None and rates is not None:
        leader = np.where(case.joint, pace.axes.leading[rows], case.leads)
        case = replace(case, leader=leader, slowest=not pace.axes.together)
    return with_rivals(case, _whole(moves.acceleration_fraction)[rows])


# --- ways, speeds, accelerations --------------------------------------------------------------------------------------


def _pace(recording: Recording, own: bool, notes: list[str]) -> _Pace:
    """Straight and curved moves by their points, joint moves by the slowest axis; `own`: see JudgedTimes."""
    moves = recording.moves
    way = np.where(moves.kind == CIRCULAR, _arcs(moves), moves.chord)
    speed = moves.speed.copy()
    acceleration = moves.acceleration.copy()
    robot = recording.robot
    straight = robot.linear_acceleration if robot is not None else None
    if straight is not None:
        path = np.isin(moves.kind, (LINEAR, CIRCULAR))
        acceleration = np.where(path & ~np.isfinite(acceleration), straight, acceleration)
    joint = (moves.kind == JOINT) & moves.has_joints
    leading = np.full(len(moves), -1, dtype=np.intp)
    axes: AxisLimits | None = None
    guessed: Mask | None = None
    rated_ramps: tuple[Floats, ...] = ()
    if joint.any():
        axes = _axes_simulated(recording, joint)
        lead, axis = _leading(recording, joint, axes)
        leading = np.where(joint, axis, leading)
        way = np.where(joint, lead, way)
        rated, ramp = _joint_pace(recording, joint, lead, axis, axes, notes)
        if (found := _unsure(recording, joint, axes)) is not None:
            guessed, why = found
            notes.append(f"{why}: they are not judged; a robot model would add these limits")
            rated = np.where(guessed & axes.unknown, np.nan, rated) if axes is not None else rated
        speed = np.where(joint, rated, speed)
        acceleration = np.where(joint, ramp, acceleration)
        if robot is not None and axes is None:
            rated_ramps = _rated_ramps(recording, robot, joint, lead, ramp)
    # Speeds that simulated times tell are those under the simulation's override, whichever that is.
    shown = joint & (robot is None or len(robot.axes) != moves.joints_start.shape[1])
    override = (
        _whole(moves.override)
        if own
        else _simulated_override(moves, np.where(shown, np.nan, way), speed, leading)
    )
    speed = np.where(moves.kind == WAIT, 1.0, np.where(shown, 1.0, override) * speed)
    way = np.where(moves.kind == WAIT, 0.0, way)
    tool_way = np.where(joint, tool_ways(recording), way) if (joint & ~moves.stops).any() else None
    turn = np.where(joint, 0.0, np.nan_to_num(_turn(moves)))
    return _Pace(way, speed, acceleration, override, leading, axes, rated_ramps, guessed, tool_way, turn)


def _unsure(recording: Recording, joint: Mask, axes: AxisLimits | None) -> tuple[Mask, str] | None:
    """Joint moves (n,) whose axes' limits the simulated times do not tell, and why. Where there are few beside other
    moves, they tell nothing of the axes that lead none of them, and what slows a robot makes such axes lead."""
    moves, robot = recording.moves, recording.robot
    turned = np.nan_to_num(np.abs(moves.joints_end - moves.joints_start))[joint].max(axis=0) > _NEAR
    if robot is not None and len(robot.axes) == len(turned):
        return None
    limits = (
        np.stack([axes.speeds, axes.accelerations]) if axes is not None else np.full((2, len(turned)), np.inf)
    )
    if joint.sum() < _FOR_EACH * limits.size and not np.isfinite(limits[:, turned]).all():
        beside = _beside(moves, joint)
        if (joint | beside).sum() < _FEW * len(moves):
            more = phrasing.counted(int(beside.sum()), "move")
            with_them = f", and {more} at rounded corners beside them" if beside.any() else ""
            few = (
                f"{phrasing.counted(int(joint.sum()), 'joint move')}: too few to tell the limits of all axes that they "
                "turn"
            )
            return joint | beside, few + with_them
    if axes is None or not 0 < (alone := joint & ~axes.confirmed).sum() < _FEW * len(moves):
        return None
    tell = f"limits of axes in the simulation are told by {phrasing.counted(int(alone.sum()), 'joint move')} alone"
    return alone, f"{tell}, whose times do not tell speed and ramps apart"


def _beside(moves: RecordedMoves, joint: Mask) -> Mask:
    """The other moves (n,) that meet a joint one at a rounded corner, whose time hangs on the ramps of both."""
    unknown = np.full(len(moves), np.nan)
    start, _, before, *_ = _ends(moves, unknown, unknown)
    meets = ~start & (before >= 0) & (joint | joint[before])
    meets[before[meets]] = True
    return np.asarray(meets & ~joint)


def _axes_simulated(recording: Recording, joint: Mask) -> AxisLimits | None:
    """The axes' limits behind the simulated times of joint moves, where no robot file tells them."""
    moves, robot = recording.moves, recording.robot
    if robot is not None and len(robot.axes) == moves.joints_start.shape[1]:
        return None
    return _limits_told(moves, joint)


def _limits_told(moves: RecordedMoves, joint: Mask) -> AxisLimits | None:
    """The axes' limits behind the simulated times of the joint moves."""
    turned = np.abs(moves.joints_end - moves.joints_start)
    if not turned.shape[1]:
        return None  # joint moves of which only the tool's points were recorded
    ramps = _whole(moves.acceleration_fraction)
    unknown = np.full(len(moves), np.nan)
    start, end, *_ = _ends(moves, unknown, unknown)
    sim = np.where(joint, moves.sim, np.nan)
    share = _whole(moves.speed_fraction) * _whole(moves.sim_override)
    return limits_from_times(turned, share, ramps, sim, start & end)


def _leading(recording: Recording, joint: Mask, axes: AxisLimits | None) -> tuple[Floats, NDArray[np.intp]]:
    """(n,) [rad] of the axis that takes longest at rated speeds, and its number."""
    moves, robot = recording.moves, recording.robot
    turned = np.abs(moves.joints_end - moves.joints_start)
    if axes is not None:
        return np.where(joint, turned[np.arange(len(turned)), axes.leading], np.nan), axes.leading
    rated = np.ones(turned.shape[1])
    if robot is not None and len(robot.axes) == turned.shape[1]:
        rated = np.where(np.isfinite(robot.speeds), robot.speeds, 1.0)
    axis = np.argmax(np.nan_to_num(turned / rated), axis=1)
    return np.where(joint, turned[np.arange(len(turned)), axis], np.nan), axis


def _simulated_override(moves: RecordedMoves, way: Floats, speed: Floats, axis: NDArray[np.intp]) -> Floats:
    """(n,) [1] under which the judged simulation ran: as written, else whichever of none and the robot's own leaves
    more nearly ramps of one acceleration per axis (`axis`: the leading one, -1 of ways of the tool)."""
    written, own = _whole(moves.sim_override), _whole(moves.override)
    told = np.isfinite(moves.sim) & np.isfinite(way) & np.isfinite(speed) & (way > 0)
    if np.isfinite(moves.sim_override).any() or not (own[told] < 1.0).any():
        return written

    def misfit(override: Floats) -> float:
        off = 0.0
        for number in np.unique(axis[told]).tolist():
            here = told & (axis == number)
            fast = (override * speed)[here]
            over = moves.sim[here] - way[here] / fast
            off += float(np.sum((over - max(float(over @ fast) / float(fast @ fast), 0.0) * fast) ** 2))
        return off

    return own if misfit(own) < misfit(written) else written


def _joint_pace(
    recording: Recording,
    joint: Mask,
    lead: Floats,
    axis: NDArray[np.intp],
    axes: AxisLimits | None,
    notes: list[str],
) -> tuple[Floats, Floats]:
    """Speed and acceleration of the leading axes: of the robot, or read off the simulated durations."""
    moves, robot = recording.moves, recording.robot
    share = np.where(np.isfinite(moves.speed_fraction), moves.speed_fraction, 1.0)
    if robot is not None and len(robot.axes) == moves.joints_start.shape[1]:
        ramp = constant_axes(robot, MotionLimits(None, lambda says: None))[axis] * np.where(
            np.isfinite(moves.acceleration_fraction), moves.acceleration_fraction, 1.0
        )
        rated = share * robot.speeds[axis]
        slower = (
            joint & ~np.isfinite(moves.speed_fraction) & (moves.sim > _SLOWER * trapezoid(lead, rated, ramp))
        )
        if slower.any():
            notes.append(
                f"no speed_pct of {phrasing.counted(int(slower.sum()), 'joint move')}: taken as 100 %, but the "
                f"simulation takes more than {_SLOWER:g} times as long; give speed_pct"
            )
        return rated, ramp
    notes.append("no robot is named: rated axis speeds are read off the simulated times of joint moves")
    if axes is not None:
        return axes.speed, axes.acceleration
    share = share * _whole(moves.sim_override)
    speed, ramp = np.full(len(moves), np.nan), np.full(len(moves), np.nan)
    unknown = np.full(len(moves), np.nan)
    start, end, *_ = _ends(moves, unknown, unknown)
    alike = np.unique(np.stack([share, start, end]), axis=1, return_inverse=True)[1].ravel()
    for number in np.unique(axis[joint]).tolist():
        here = joint & (axis == number)
        speed[here], ramp[here] = _read_off(lead[here], share[here], moves.sim[here], alike[here])
    return speed, ramp


def _rated_ramps(
    recording: Recording, robot: Robot, joint: Mask, lead: Floats, own: Floats
) -> tuple[Floats, ...]:
    """(n,) [rad/s²] of the leading axis in joint moves: as much as that axis is rated for, `own`, and as much as all
    axes that turn with it are."""
    if not np.isfinite(robot.accelerations).all():
        return ()
    moves = recording.moves
    turned = np.abs(moves.joints_end - moves.joints_start)
    with np.errstate(divide="ignore", invalid="ignore"):
        least = (robot.accelerations / turned).min(axis=1)
    together = least * lead * _whole(moves.acceleration_fraction)
    return tuple(np.where(joint, ramps, np.nan) for ramps in (own, together))


def _read_off(lead: Floats, share: Floats, sim: Floats, alike: Rows) -> tuple[Floats, Floats]:
    """Speed and acceleration from sim = lead/(p V) + p V/a, or, where that is off by more than digits and it is not,
    from sim = lead/(p V) + what moves that are `alike` (n,) in p and their ends have in common; a plain guess where the
    moves are too few or alike."""
    good = np.isfinite(sim) & (lead > 0)
    columns = np.stack([lead / share, share], axis=1)[good]
    slow, ramp, off = 0.0, 0.0, math.inf
    if len(columns) >= 4 and np.linalg.cond(columns / np.linalg.norm(columns, axis=0)) < 50:
        (slow, ramp), *_ = np.linalg.lstsq(columns, sim[good], rcond=None)
        off = (
            float(np.sqrt(np.mean((columns @ (slow, ramp) - sim[good]) ** 2)))
            if slow > 0 and ramp > 0
            else off
        )
    if off > _CORNERS_RIGHT and good.any():
        way, time = _from_the_mean(columns[:, 0], alike[good]), _from_the_mean(sim[good], alike[good])
        one = float(way @ time) / max(float(way @ way), 1e-12)
        within = float(np.sqrt(np.mean((one * way - time) ** 2)))
        if (
            len(np.unique(np.round(way, 4))) > _FOR_EACH + len(np.unique(alike[good]))
            and within < _CORNERS_RIGHT
        ):
            over = np.maximum(sim - one * lead / share, _JOINT_RAMP * one * lead / share * 1e-3)
            return share / one, share / one / over
    if math.isfinite(off):
        return share / slow, np.full(len(lead), 1.0 / (slow * ramp))
    cruise = np.maximum((1.0 - _JOINT_RAMP) * sim, 1e-6)
    speed = lead / cruise
    return speed, speed / np.maximum(_JOINT_RAMP * sim, 1e-6)


def _from_the_mean(values: Floats, alike: Rows) -> Floats:
    """(n,) from the mean of those that are `alike` (n,)."""
    labels = np.unique(alike, return_inverse=True)[1]
    return np.asarray(values - (np.bincount(labels, values) / np.bincount(labels))[labels])


def _arcs(moves: RecordedMoves) -> Floats:
    """(n,) [m] along the circle through start, via and end; nan without a middle point."""
    one, two = moves.via - moves.start, moves.end - moves.start
    a = np.linalg.norm(one, axis=1)
    b = np.linalg.norm(moves.end - moves.via, axis=1)
    chord = np.linalg.norm(two, axis=1)
    area = np.linalg.norm(np.cross(one, two), axis=1)
    with np.errstate(divide="ignore", invalid="ignore"):
        radius = a * b * chord / (2.0 * area)
        half = np.arcsin(np.clip(a / (2 * radius), -1, 1)) + np.arcsin(np.clip(b / (2 * radius), -1, 1))
        past = chord**2 < np.maximum(a, b) ** 2 - np.minimum(a, b) ** 2
    # Each leg is at most half a circle; the longer one is more than that when the chord closes behind it.
    legs = np.where(past, 2 * np.pi * radius - (a + b), 2.0 * radius * half)
    straight = ~np.isfinite(radius) | (radius > 1e4)
    return np.asarray(np.where(straight, a + b, np.where(past, a + b, legs)))


# --- the judged simulation --------------------------------------------------------------------------------------------


class _Judged(NamedTuple):
    """What is known of the simulation whose durations are judged."""

    moves: RecordedMoves
    rows: Rows  # of the moves that are in the case
    pace: _Pace  # of all moves
    times: JudgedTimes  # of all moves
    ends: MoveEnds
    blend: Floats  # (m,) [m] rounding at each move's end, of all moves
    resolution: float  # [s] of the recorder


def _simulated_ends(judged: _Judged) -> tuple[MoveEnds, _SimulatedMotion]:
    """Where moves end, and the motion behind the simulated durations. Whether the last moves of cycles go on into the
    next one, which nobody writes, and at which corners it stops, simulated durations tell, which have no scatter; else
    the ends that are judged."""
    judged, made = _with_stops_at_corners(judged)
    ends, other = judged.ends, judged.ends.other
    if judged.times.own or other is None:
        return ends, made
    differ = ((ends.start != other.start) | (ends.end != other.end))[judged.rows]
    sim = judged.times.duration[judged.rows]
    if not differ.any() or (least := made.off_in(differ, sim)) < _CORNERS_RIGHT:
        return ends, made
    rounding, tried = _with_stops_at_corners(judged._replace(ends=other))
    return (rounding.ends, tried) if tried.off_in(differ, sim) < _NEARER * least else (ends, made)


def _with_stops_at_corners(judged: _Judged) -> tuple[_Judged, _SimulatedMotion]:
    """What is judged, with the stops at rounded corners that the simulated durations tell, and the motion behind
    these."""
    made = _base(judged)
    if judged.times.own:
        return judged, made
    for _ in range(_IN_TURN):  # without them, the law of the other corners tells more of them
        if (stops := _corners_not_rounded(judged, made.motion)) is None:
            break
        stopping = judged._replace(ends=stops.of(judged.ends, judged.moves))
        if (tried := _base(stopping)).everywhere >= made.everywhere:
            break
        judged, made = stopping, tried
    return judged, made


class _StopsAtCorners(NamedTuple):
    """At which rounded corners a simulation stops all the same."""

    turning: float = math.inf  # [rad] where lines turn by as much
    mixed: bool = False  # between a line and a joint move

    def of(self, ends: MoveEnds, moves: RecordedMoves) -> MoveEnds:
        """The ends with these stops."""
        here = np.flatnonzero(ends.before >= 0)
        last = ends.before[here]
        joint, line = moves.kind == JOINT, moves.kind == LINEAR
        stops = line[last] & line[here] & (np.nan_to_num(_corner(moves)[last]) >= self.turning)
        if self.mixed:
            stops |= joint[last] != joint[here]
        start, end, before = ends.start.copy(), ends.end.copy(), ends.before.copy()
        start[here[stops]], end[last[stops]], before[here[stops]] = True, True, -1
        other = None if ends.other is None else self.of(ends.other, moves)
        return ends._replace(start=start, end=end, before=before, other=other)


def _corners_not_rounded(judged: _Judged, motion: Motion) -> _StopsAtCorners | None:
    """The stops at rounded corners with which the simulation's law of corners, that of `motion`, comes nearest to its
    durations; None where it rounds all of them, or nothing tells."""
    if motion.law == "stop":
        return None
    moves, rows, sim = judged.moves, judged.rows, judged.times.duration[judged.rows]
    bends = motion.bend_end[(motion.bend_end > _BACK) & (motion.round_end > 0)]
    told = np.unique(np.round(bends, 3)) - 1e-3
    angles = [
        math.inf,
        *told[np.linspace(0, len(told) - 1, min(len(told), _ANGLES)).astype(np.intp)].tolist(),
    ]
    kinds = [_StopsAtCorners(angle, mixed) for mixed in (False, True) for angle in angles]

    def off(stops: _StopsAtCorners) -> Floats:
        ends = stops.of(judged.ends, moves)
        start, end = (
            np.where(one[rows], 0.0, rounding)
            for one, rounding in ((ends.start, motion.round_start), (ends.end, motion.round_end))
        )
        return np.asarray(np.abs(motion.with_(round_start=start, round_end=end).duration() - sim))

    rounded = off(kinds[0])
    best = min(kinds, key=lambda one: float(off(one).sum()))
    stopped = off(best)
    changed = stopped != rounded
    right = changed.any() and stopped[changed].mean() < _NEARER * rounded[changed].mean()
    return best if right else None


def _base(judged: _Judged) -> _SimulatedMotion:
    """The motion behind the simulated durations, and by what factor these are longer than what is written takes.

    A simulation that was tuned runs at a share of what is written.
    Accelerations that are not written are those that make constant acceleration take what the simulation says; when one
    acceleration does for all within the simulation's digits, it is that one. Rounded corners are passed as comes
    nearest to the simulation. Where it stops at every corner, joint moves have the lines' law if that makes the
    accelerations of each axis alike.
    """
    moves, rows, pace, times, ends, blend, _ = judged
    simulated = _SimulatedRows(
        pace.way[rows],
        pace.speed[rows],
        np.where(moves.kind[rows] != WAIT, pace.acceleration[rows], 1.0),
        times.duration[rows] - times.stop[rows],
        ends.start[rows],
        ends.end[rows],
        moves.kind[rows] != WAIT,
        moves.kind[rows] == JOINT,
        ends.end[rows],
        np.zeros(len(rows)) if pace.turn is None else pace.turn[rows],
        _headings(moves)[rows],
    )
    likely, everywhere, said = [SimulatedRamps()], False, tuple[str, ...]()
    laws = likely
    if not times.own and (slides := _slides_of(simulated)) is not None:
        simulated = simulated._replace(slow=np.where(simulated.lines, slides.slow, simulated.slow))
        likely, said = [slides.law], (slides.says,)
        laws = likely
    elif not times.own:
        likely, everywhere = _laws_of_lines(simulated, ends.rounded_from(blend)[rows], blend[rows])
        laws = [_timed(law, simulated) for law in likely]
        simulated = simulated._replace(waits=simulated.end | (everywhere & simulated.lines))
    whole = partial(_by_law, judged, simulated)
    best = whole(laws[0])
    if len(laws) > 1 and best.off > _CORNERS_RIGHT:
        other = min(map(whole, laws[1:]), key=lambda made: made.off)
        best = other if other.off < _NEARER * best.off else best
    if best.off > _CORNERS_RIGHT and not times.own and (law := _averaging(likely[0], simulated)) is not None:
        # Corners at which such a simulation stops, which its law tells, leave it far off at first.
        best = min(best, whole(law), key=lambda made: made.everywhere)
    if best.off > _CORNERS_RIGHT and not times.own:
        known = whole(SimulatedRamps(), by_corners=True)
        best = known if known.off < _NEARER * best.off else best
        if best.off > _WORTH_A_SEARCH and simulated.rounded.any():
            other = _built_up(whole, known, simulated.lines)
            best = other if other.off < _NEARER * best.off else best
    if best.everywhere > _CORNERS_RIGHT and not times.own:
        best = _turned_at_corners(whole, best, judged, simulated)
    if best.everywhere > _CORNERS_RIGHT and not times.own:
        beside = best.turning if best.turning.told else _beside_rated(simulated, pace, rows)
        laws = [law for law in beside.with_one_time() if law != best.turning]
        tried = [whole(best.straight, turning=law) for law in laws]
        # What no line between stops tells of lines, the law of the joint moves does.
        tried += [whole(law, turning=law) for law in laws if not simulated.plain.any()]
        other = min(tried, key=lambda made: made.everywhere, default=best)
        best = other if other.everywhere < _NEARER * best.everywhere else best
    if best.everywhere > _CORNERS_RIGHT and not times.own and simulated.rounded.any():
        best = _resized(judged, simulated, best)
    if everywhere and pace.axes is None and best.straight.told and simulated.joint.any():
        joint, leading = simulated.joint, pace.leading[rows]
        stopping = simulated._replace(waits=simulated.waits | joint)
        other = _by_law(judged, stopping, best.straight, turning=best.straight)
        alike, unlike = (_unlike(made.motion.accelerate[joint], leading[joint]) for made in (other, best))
        near = other.everywhere <= max(best.everywhere, _CORNERS_RIGHT)
        best = other if near and alike < _NEARER * unlike else best
    return best._replace(notes=(*best.notes, *said))


def _built_up(
    whole: Callable[..., _SimulatedMotion], known: _SimulatedMotion, lines: Mask
) -> _SimulatedMotion:
    """The motion of a simulation whose accelerations build up in a time that no lines between stops tell, as corners
    tell it; or what is `known` by corners.

    Lines that are fast enough take that time more, slower ones less; so the fast ones tell the acceleration, and then
    the time is the one that comes nearest: to tell both each time anew takes ten times as long.
    """
    added, ramps = known.motion.added[lines], known.motion.accelerate[lines]
    most = float(added.max(initial=0.0))
    if most < _LEAST_BUILT:
        return known
    above = _REACHED * max(float(added.min()), _LEAST_BUILT) * float(ramps.max())
    fast = whole(SimulatedRamps(), by_corners=True, above=above)
    law = SimulatedRamps(stronger=float(np.median(fast.motion.accelerate[lines])))
    tried = dict[float, float]()

    def off(build: float) -> float:
        if build not in tried:
            tried[build] = whole(law._replace(build=build), by_corners=True).off
        return tried[build]

    low, high = _BUILT[0] * most, _BUILT[1] * most
    if min(off(low + share * (high - low)) for share in GOLDEN) >= known.off:
        return known
    golden_section(off, low, high, _BUILT_STEPS)
    build = min(tried, key=tried.__getitem__)
    if tried[build] >= _NEAR_BUILT * known.off:
        return known
    return whole(SimulatedRamps(build=build), by_corners=True)


def _turned_at_corners(
    whole: Callable[..., _SimulatedMotion], best: _SimulatedMotion, judged: _Judged, simulated: _SimulatedRows
) -> _SimulatedMotion:
    """The motion of a simulation that limits how fast lines with rounded corners turn the tool, or the `best` without.

    Law of corners and limits hang on each other: each is told by what the other is, in turn.
    """
    turning = simulated.rounded & (simulated.turn > TURNS)
    if not turning.any():
        return best
    partners, sim = _partners(judged.rows, judged.ends.before), judged.times.duration[judged.rows]
    free = best.motion
    for _ in range(_IN_TURN):
        limits = turning_limits_at_corners(free, best.motion, partners, simulated.turn, turning, sim)
        if limits is None:
            return best
        tried = [whole(best.straight, by_corners=by, limits=limits) for by in (False, True)]
        other = min(tried, key=lambda made: made.everywhere)
        if other.everywhere >= _NEARER_IN_TURN * best.everywhere:
            return best
        best = other
    return best


def _resized(judged: _Judged, simulated: _SimulatedRows, best: _SimulatedMotion) -> _SimulatedMotion:
    """The motion of a simulation whose corners begin at a share of the rounding that is written, or the `best` where
    none comes clearly nearer."""
    tried = dict[float, _SimulatedMotion]()

    def off(log_size: float) -> float:
        if log_size not in tried:
            resized = judged._replace(blend=math.exp(log_size) * judged.blend)
            tried[log_size] = _by_law(resized, simulated, best.straight, turning=best.turning)
        return tried[log_size].everywhere

    logs = [math.log(size) for size in _SIZES]
    nearest = min(range(len(logs)), key=lambda k: off(logs[k]))
    if off(logs[nearest]) >= _NEARER_IN_TURN * best.everywhere:
        return best
    golden_section(off, logs[max(nearest - 1, 0)], logs[min(nearest + 1, len(logs) - 1)], _SIZE_STEPS)
    size = min(tried, key=off)
    if tried[size].everywhere >= _NEARER * best.everywhere:
        return best
    says = f"the simulation rounds corners by {math.exp(size):.1%} of what is written: findings are relative to that"
    return tried[size]._replace(notes=(*tried[size].notes, says))


def _beside_rated(simulated: _SimulatedRows, pace: _Pace, rows: Rows) -> SimulatedRamps:
    """A time beside the ramps of joint moves between stops, where these have a robot's accelerations but for that."""
    plain = simulated.joint & simulated.start & simulated.end
    for ramps in pace.rated_ramps:
        over = (simulated.sim - trapezoid(simulated.way, simulated.speed, ramps[rows]))[plain]
        if len(over) and np.ptp(over) <= _CORNERS_RIGHT and over.min() > _CORNERS_RIGHT:
            return SimulatedRamps(stop=float(np.median(over)))
    return SimulatedRamps()


class _SimulatedRows(NamedTuple):
    """What the moves of a case are, each (n,), and how long they last in the simulation."""

    way: Floats  # [m | rad]
    speed: Floats  # [m/s | rad/s]
    slow: Floats  # [m/s² | rad/s²] accelerations, nan where nothing tells them
    sim: Floats  # [s] without the time at stops
    start: Mask  # from a stop
    end: Mask  # to a stop
    moving: Mask
    joint: Mask
    waits: Mask  # for what a stop takes: at exact stops, and at rounded corners of a simulation that knows of none
    turn: Floats  # [rad] by which lines turn the tool, 0 where that is not known
    heading: Floats  # (n, 3) [1] of a line's way along each axis of the frame, nan where that is not known

    @property
    def lines(self) -> Mask:
        """Moves that are no joint moves."""
        return np.asarray(self.moving & ~self.joint)

    @property
    def plain(self) -> Mask:
        """Lines between stops."""
        return np.asarray(self.start & self.end & self.lines)

    @property
    def steady(self) -> Mask:
        """Lines between stops that hardly turn the tool: others may last longer than their ways; all where few do."""
        found = self.plain & (self.turn <= TURNS)
        return found if len(np.unique(np.round(self.sim[found], 4))) >= _STEADY else self.plain

    @property
    def calm(self) -> Mask:
        """Lines between stops that ask less of the turn's speed and acceleration than half of them do: those that
        limits of the turn are likeliest to leave alone."""
        some = self.plain & (self.way > 0)
        if not some.any():
            return some
        turn = np.where(some, self.turn / np.where(some, self.way, 1.0), np.inf)  # [rad/m]
        asked = turn, self.speed * turn
        return np.asarray(some & np.all([one <= np.median(one[some]) for one in asked], axis=0))

    @property
    def beside_slides(self) -> list[Mask]:
        """Lines between stops that go along one axis of the frame, or along two, by no more than half of their way:
        those that a slide of a gantry with an acceleration of its own leaves alone, if it has half of the tool's."""
        across = np.nan_to_num(self.heading, nan=1.0) <= _ASKED_OF_SLIDES
        return [self.plain & across[:, axes].all(axis=1) for axes in _SLIDES]

    @property
    def rounded(self) -> Mask:
        """Other lines."""
        return np.asarray(self.lines & ~self.plain)


class _Slides(NamedTuple):
    """What the slides of a simulated gantry let lines have."""

    law: SimulatedRamps  # of the ramps of lines
    slow: Floats  # (n,) [m/s²] accelerations
    limits: (
        Floats  # (4,) [m/s²] of the tool, and along each axis of the frame, inf where a slide limits nothing
    )

    @property
    def says(self) -> str:
        """One sentence for the reader."""
        tool, *slides = self.limits.tolist()
        along = [
            f"{a:.3g} m/s² along {axis}" for axis, a in zip("xyz", slides, strict=True) if math.isfinite(a)
        ]
        all_ways = [f"{tool:.3g} m/s² in all directions"] if math.isfinite(tool) else []
        most = phrasing.listed([*along, *all_ways])
        return f"simulated lines accelerate by {most} at most, as on a gantry: findings are relative to that"


def _slides_of(simulated: _SimulatedRows) -> _Slides | None:
    """The law of lines whose accelerations are the least of the tool's and of what each axis of the frame lets, as
    those between stops tell; None where accelerations are written, or no slide limits any."""
    way, speed, slow, sim = simulated[:4]
    told = (
        simulated.steady & (way > 0) & np.isfinite(simulated.heading).all(axis=1) & np.isfinite(sim + speed)
    )
    if told.sum() < FEWEST or np.isfinite(slow[simulated.lines]).any():
        return None
    shares = np.column_stack([np.ones(len(way)), np.nan_to_num(simulated.heading)])
    each = np.round(np.column_stack([shares * way[:, None], speed])[told], _PLACES)
    rows = np.flatnonzero(told)[np.unique(each, axis=0, return_index=True)[1]]  # moves that are alike are one
    ones = np.ones(len(rows))
    turned = (shares * way[:, None])[rows]
    found = limits_from_times(turned, speed[rows], ones, sim[rows], ones > 0, together=True)
    if found is None or not np.isfinite(found.accelerations[1:]).any():
        return None
    law = SimulatedRamps(build=found.built, stop=found.beside, shortest=found.shortest)
    limits, here = found.accelerations.copy(), (way[rows], speed[rows], sim[rows] - law.stop)
    if not math.isfinite(limits[0]):  # too few lines have the tool's for others to confirm it
        own = law.slow(way, speed, sim - law.stop)[0]
        sure = simulated.plain & (own < speed / _TELLING_RAMP)
        limits[0] = float(own[sure].max()) if sure.any() else math.inf
    slow = (limits / np.maximum(shares, 1e-9)).min(axis=1)
    off = of_their_own(*here, slow[rows], law, last_digit(sim[rows]))
    return _Slides(law, slow, limits) if off.mean() < _ODD_LINES else None


def _laws_of_lines(
    simulated: _SimulatedRows, round_start: Floats, round_end: Floats
) -> tuple[list[SimulatedRamps], bool]:
    """What the ramps of lines may be, the likeliest first, and whether the simulation stops at every corner. Then all
    moves tell it, else those between stops, and corners, rounded by `round_start` and `round_end` (n,) [m], tell which
    it is."""
    way, speed, slow, sim = simulated[:4]
    asked = [simulated.lines, simulated.steady, simulated.calm]
    asked += simulated.beside_slides if not np.isfinite(slow[simulated.lines]).any() else []
    found = (ramps_that_fit(way, speed, slow, sim, some) for some in asked)
    everywhere, laws = next(((k == 0, some) for k, some in enumerate(found) if some), (False, []))
    if laws and laws[0].told:
        return laws, everywhere
    starts = np.where(simulated.start, 0.0, round_start)
    rounded = np.stack([starts, np.where(simulated.end, 0.0, round_end)], axis=1)
    more = ramps_by_corners(way, speed, slow, sim, simulated.plain, simulated.lines, rounded)
    return [*(laws or [SimulatedRamps()]), *more], everywhere


def _timed(law: SimulatedRamps, simulated: _SimulatedRows) -> SimulatedRamps:
    """The law of lines, or the one in which every ramp takes one time."""
    here = simulated.plain if simulated.plain.any() else simulated.lines
    way, speed, slow = simulated.way[here], simulated.speed[here], simulated.slow[here]
    return law.with_timed_ramps(way, speed, law.stronger * np.where(np.isfinite(slow), slow, 1.0))


def _averaging(law: SimulatedRamps, simulated: _SimulatedRows) -> SimulatedRamps | None:
    """The law of lines as that of a controller which averages its speeds; None where lines have ramps of their own."""
    here = simulated.plain
    if not here.any() or not simulated.rounded.any():
        return None
    way, speed, slow = simulated.way[here], simulated.speed[here], simulated.slow[here]
    return law.as_an_average(way, speed, law.stronger * np.where(np.isfinite(slow), slow, 1.0))


class _SimulatedMotion(NamedTuple):
    """The motion behind simulated durations."""

    motion: Motion
    stretch: float  # [1] durations over what is written takes
    off: float  # [s] mean distance of lines with rounded corners from the simulation
    everywhere: float  # [s] of all moves with rounded corners
    straight: SimulatedRamps  # law of lines
    turning: SimulatedRamps  # law of joint moves
    notes: tuple[str, ...]

    def off_in(self, some: Mask, sim: Floats) -> float:
        """[s] mean distance of `some` moves (n,) from the simulation, `sim` (n,) [s]."""
        return float(np.mean(np.abs(self.motion.duration() - sim)[some]))


def _by_law(
    judged: _Judged,
    simulated: _SimulatedRows,
    straight: SimulatedRamps,
    by_corners: bool = False,
    turning: SimulatedRamps | None = None,
    above: float = 0.0,
    limits: TurnLimits | None = None,
) -> _SimulatedMotion:
    """With a law of the ramps of straight moves, and one of joint moves; None: as those between stops tell it.
    `by_corners`: rounded corners tell times beside the ramps, and the accelerations that neither moves nor the law say,
    by lines that are as fast as `above` [m/s]. `limits`: of the tool's turn in lines, else those that lines between
    stops tell."""
    moves, rows, pace, times, ends, blend, _ = judged
    _, speed, _, sim, start, end, moving, joint, waits, *_ = simulated
    plain, lines = simulated.plain, simulated.lines
    unwritten = plain & ~np.isfinite(simulated.slow) & straight.told & (not times.own)
    faster, stronger, slow, notes = _as_tuned(simulated, straight, by_corners)
    stopping = joint & start & end
    if turning is None and not times.own and (pace.axes is not None or plain.sum() < FEWEST):
        stopping = joint & (start & end | (pace.axes is not None and pace.axes.tell(rows[joint])))
        turning = _ramps_of_axes(moves, rows, pace, sim, stopping)
    turning = turning or straight
    if straight.told or turning.told:
        notes.append(straight.says if straight.told else turning.says)
    speed = np.where(lines, faster * speed, speed)
    # Where a simulation is judged, its joint moves tell their own ramps; a robot file's need not be what it used.
    missing = ~np.isfinite(slow) | (joint & (pace.axes is None))
    stopped = np.where(moving & (waits | stopping), np.where(joint, turning.stop, straight.stop), 0.0)
    slow = np.where(lines, stronger * slow, slow)
    simulated = simulated._replace(speed=speed, slow=slow, sim=sim - stopped)
    limits = limits or _limits_of_the_turn(judged, simulated, straight)
    if limits is not None:
        notes.append(limits.says)
    turned = _no_faster_than_the_tool_turns(simulated, limits)
    slow = _accelerations(judged, turned, missing, unwritten, straight, turning)
    # Limits of the turn are none of corners.
    across = np.where(turned.slow < simulated.slow, simulated.slow, slow)
    simulated, speed = turned, turned.speed
    slow = _no_faster_than_the_tool_turns(simulated._replace(slow=slow), limits).slow
    slow, shortest = _least_ramps(simulated, slow, straight, turning)
    jerk = math.inf if limits is None else limits.jerk
    whole = _as_written(pace, rows, moving, ends, blend).with_(
        speed=speed,
        accelerate=slow,
        decelerate=slow,
        jerk=np.where(lines, jerk, np.inf),
        build=np.where(
            moving, np.where(joint, turning.build, 0.0 if math.isfinite(jerk) else straight.build), 0.0
        ),
        filtered=np.where(moving, np.where(joint, turning.filtered, straight.filtered), 0.0),
        shortest=shortest,
    )
    told_by_none = bool(missing[lines].all() and lines.any() and not plain.any())
    beside = np.zeros(len(rows))
    if (by_corners and simulated.rounded.any()) or told_by_none:
        fast = lines & (speed >= above)
        steady = fast & (simulated.turn <= TURNS) if limits is not None else fast
        telling = next((some for some in (steady, fast) if some.sum() >= FEWEST), lines)
        across, beside = _by_corners_of_lines(
            judged, simulated, whole, across, telling, bool(missing[lines].all())
        )
        of_lines = np.where(lines, beside, 0.0)
        simulated, stopped = simulated._replace(sim=simulated.sim - of_lines), stopped + of_lines
        slow = _no_faster_than_the_tool_turns(simulated._replace(slow=across), limits).slow
        slow, shortest = _least_ramps(simulated, slow, straight, turning)
        whole = whole.with_(accelerate=slow, decelerate=slow, shortest=shortest)
    beside = np.where(joint, beside, 0.0)
    found, more = _cornered(judged, simulated, whole, across, missing, beside, straight.averaged > 0)
    simulated, stopped = simulated._replace(sim=simulated.sim - more), stopped + more
    off = np.abs(found.duration() - simulated.sim)
    at_lines, everywhere = (
        float(np.mean(off[some])) if some.any() else 0.0
        for some in (simulated.rounded, moving & ~(start & end))
    )
    # Slower by one factor, and ramps with it: all times are longer by that factor, whatever the move.
    stretched = abs(stronger - faster**2) < _STRETCHED * abs(1.0 - faster)
    found = found.with_(added=times.stop[rows] + stopped)
    stretch = 1.0 / faster if stretched else 1.0
    return _SimulatedMotion(found, stretch, at_lines, everywhere, straight, turning, tuple(notes))


def _as_tuned(
    simulated: _SimulatedRows, straight: SimulatedRamps, by_corners: bool
) -> tuple[float, float, Floats, list[str]]:
    """Shares of the written speeds and accelerations that the simulation runs lines at, the accelerations (n,) that
    these are a share of, and what is told of them."""
    way, speed, slow, sim, *_ = simulated
    if by_corners:
        # Times that corners tell stand beside what is written: they take the place of a share of it.
        known = np.isfinite(slow) | simulated.joint | (straight.stronger == 1.0)
        return 1.0, 1.0, np.where(known, slow, straight.stronger), []
    if straight.told:
        return 1.0, straight.stronger, np.where(np.isfinite(slow) | simulated.joint, slow, 1.0), []
    shares = (tuned(way, speed, slow, sim, some) for some in (simulated.steady, simulated.calm))
    faster, stronger = next((found for found in shares if found != (1.0, 1.0)), (1.0, 1.0))
    if (faster, stronger) == (1.0, 1.0):
        return 1.0, 1.0, slow, []
    told = f"{faster:.2%} of the written speeds and {stronger:.2%} of the written accelerations"
    says = f"the simulation's straight moves run at {told}: findings are relative to that"
    return faster, stronger, slow, [says]


def _least_ramps(
    simulated: _SimulatedRows, slow: Floats, straight: SimulatedRamps, turning: SimulatedRamps
) -> tuple[Floats, Floats]:
    """(n,) accelerations and (n,) [s] that ramps take at least. Where all ramps of lines, or of joint moves, take that
    time, or accelerations `slow` (n,) would take next to none of it, nothing tells what the drives could: then that is
    the time which they take, too; but where ramps of the other kind take the same time or longer, it is the
    controller's, and the drives have some to spare."""
    shortest, kinds = np.zeros(len(slow)), ((straight, simulated.lines), (turning, simulated.joint))
    helds = [law.weakened(simulated.way, simulated.speed, slow) for law, _ in kinds]
    all_held = [bool((held < slow)[some].all()) for held, (_, some) in zip(helds, kinds, strict=True)]
    for k, (law, some) in enumerate(kinds):
        if law.averaged:
            slow = np.where(some, simulated.speed / law.averaged, slow)
            shortest = np.where(some, law.averaged, shortest)
        if not law.shortest or not some.any():
            continue
        other = kinds[1 - k][0].shortest
        spare = abs(other - law.shortest) < _ONE_TIME * law.shortest and not all_held[1 - k]
        weak = np.where(some, helds[k], slow)
        unknown = some & (all_held[k] | (weak < NO_RAMP * slow))
        slow = np.where(unknown, _SPARE * weak if spare else weak, slow)
        shortest = np.where(some, law.shortest, shortest)
    return slow, shortest


def _limits_of_the_turn(judged: _Judged, simulated: _SimulatedRows, law: SimulatedRamps) -> TurnLimits | None:
    """Limits of the tool's turn that lines between stops tell, if any do."""
    if judged.times.own or not simulated.turn.any():
        return None
    way, speed, slow, sim = simulated[:4]
    asked = simulated.plain & np.isfinite(slow)
    return turning_limits(way, speed, slow, simulated.turn, sim, asked, law)


def _no_faster_than_the_tool_turns(simulated: _SimulatedRows, limits: TurnLimits | None) -> _SimulatedRows:
    """The rows whose lines are as slow as `limits` of the tool's turn, if there are any, let them."""
    if limits is None:
        return simulated
    turns = simulated.lines & (simulated.turn > 0)
    per_turn = simulated.way / np.where(turns, simulated.turn, 1.0)
    speed, slow = (
        np.where(turns, np.minimum(own, limit * per_turn), own)
        for own, limit in zip((simulated.speed, simulated.slow), limits[:2], strict=True)
    )
    return simulated._replace(speed=speed, slow=slow)


def _accelerations(
    judged: _Judged,
    simulated: _SimulatedRows,
    missing: Mask,
    unwritten: Mask,
    straight: SimulatedRamps,
    turning: SimulatedRamps,
) -> Floats:
    """(n,) [m/s² | rad/s²] with which lines and joint moves, by the laws of their ramps, take the simulated times; the
    known ones but where these are `missing` (n,) or the simulation is slower than they are. Lines between stops whose
    accelerations are `unwritten` (n,) have the one that their law tells, or their own: slides of a gantry differ."""
    way, speed, slow, sim, start, end, _, joint, *_ = simulated
    slow, plain = slow.copy(), start & end
    read = joint & plain & (judged.pace.axes is not None)
    digit = last_digit(judged.times.duration[judged.rows])
    for kind, law, asked in ((joint, turning, read), (~joint, straight, simulated.plain)):
        here = kind & (missing | limited(way, speed, sim, slow, asked, law))
        here |= kind & unwritten & of_their_own(way, speed, sim, slow, law, digit)
        if here.any():
            leading = judged.pace.leading[judged.rows][here]
            columns = way[here], speed[here], sim[here], plain[here]
            slow[here] = inferred(*columns, judged.resolution, law, slow[here], leading)
    return slow


def _by_corners_of_lines(
    judged: _Judged, simulated: _SimulatedRows, whole: Motion, slow: Floats, telling: Mask, alone: bool
) -> tuple[Floats, Floats]:
    """Accelerations (n,) [m/s²] that rounded corners of the lines `telling` (n,) tell of all lines, and the time (n,)
    [s] that moves then take beside their ramps; `alone`: no line has a known one."""
    moves, rows, pace, _, ends, *_ = judged
    lines, start, end = simulated.lines, simulated.start, simulated.end
    ramps = np.where(lines & alone, 1.0, slow)
    alike = _opened(whole.with_(accelerate=ramps, decelerate=ramps), moves, rows, ends, ramps)
    alike = alike.with_(corners=_corners(moves, pace, rows, ends.before, whole.speed, ramps))
    alike = alike.take(np.flatnonzero(telling))
    told = told_at_corners(alike, simulated.sim[telling], start[telling], end[telling], not alone)
    return np.where(lines, told.slow * ramps, slow), np.where(simulated.moving, told.beside(start, end), 0.0)


def _cornered(
    judged: _Judged,
    simulated: _SimulatedRows,
    whole: Motion,
    across: Floats,
    missing: Mask,
    beside: Floats,
    averaged: bool,
) -> tuple[Motion, Floats]:
    """The motion with the law of corners that comes nearest to the simulated times, and (n,) [s] that joint moves take
    beside it. What no move between stops tells of joint moves whose accelerations are `missing` (n,), the law of the
    lines' corners does: over the rounding or its share of their way, with what lines take `beside` (n,) [s] their ramps
    or without, whichever makes the accelerations of an axis more alike."""
    moves, rows, pace, _, ends, *_ = judged
    joint, sim = simulated.joint, simulated.sim
    plain = joint & simulated.start & simulated.end
    unknown = joint & missing & ~plain.any() & (simulated.rounded.sum() >= FEWEST)
    whole = _opened(whole, moves, rows, ends, across)
    ramps = whole.lengthened().accelerate
    whole = whole.with_(corners=_corners(moves, pace, rows, ends.before, whole.speed, ramps))
    if averaged:
        return averaged_at_corners(whole, sim, ~unknown), np.zeros(len(rows))
    found, shared = cornered(whole, sim, ~unknown), _by_share_of_the_way(whole, pace, rows, ends.before)
    if shared is not None:
        found = nearer_at_corners(found, cornered(shared, sim, ~unknown), sim, ~unknown)
    if not unknown.any():
        return found, np.zeros(len(rows))
    law = {"law": found.law, "overlap": found.overlap, "split": found.split, "reach": found.reach}
    others = (one for one in (whole, shared) if one is not None and one.round_end is not found.round_end)
    laws = [found, *(one.with_(**law) for one in others)]
    times = [np.where(unknown, one, 0.0) for one in (0.0, beside)][: 2 if beside[unknown].any() else 1]
    tried = [(one, time, as_long_as(one, sim - time)) for one in laws for time in times]
    leading = pace.leading[rows]
    found, more, slow = min(tried, key=lambda one: _unlike(one[2][unknown], leading[unknown]))
    slow = np.where(unknown, slow, whole.accelerate)
    return found.with_(accelerate=slow, decelerate=slow), more


def _unlike(slow: Floats, leading: NDArray[np.intp]) -> float:
    """[1] by how much accelerations (n,) differ, in the middle, from the middle one of their axis, `leading` (n,)."""
    off = np.empty(len(slow))
    for axis in np.unique(leading).tolist():
        off[leading == axis] = np.abs(np.log(slow[leading == axis] / np.median(slow[leading == axis])))
    return float(np.median(off))


def _ramps_of_axes(moves: RecordedMoves, rows: Rows, pace: _Pace, sim: Floats, plain: Mask) -> SimulatedRamps:
    """What the simulated times of joint moves between stops, `plain` (n,), have beside the axes' constant
    accelerations: beside a share of a robot's, else of the laws with one such time the one that comes nearest."""
    joint = moves.kind == JOINT
    axes = pace.axes
    for ramps in pace.rated_ramps:
        law = ramps_of(pace.way[rows], pace.speed[rows], ramps[rows], sim, plain)
        if law is not None:
            return law
    if axes is None and plain.sum() >= FEWEST:
        axes = _limits_told(moves, joint)
    if axes is None:
        return SimulatedRamps()
    if axes.built:
        return SimulatedRamps(build=axes.built, stop=axes.beside)
    if axes.shortest:
        return SimulatedRamps(shortest=axes.shortest)
    good = plain & axes.confirmed[rows]
    if not good.any():
        return SimulatedRamps()
    way = np.abs(moves.joints_end - moves.joints_start)[rows, axes.leading[rows]][good]
    speed, slow = axes.speed[rows][good], axes.acceleration[rows][good]
    return ramps_beside(way, speed, slow, sim[good], axes.beside).with_timed_ramps(way, speed, slow)


def _as_written(pace: _Pace, rows: Rows, moving: Mask, ends: MoveEnds, blend: Floats) -> Motion:
    """The motion at the speeds and accelerations of `pace`, stopping at every corner."""
    start, end = ends.start[rows] | ~moving, ends.end[rows] | ~moving
    slow = np.where(moving, pace.acceleration[rows], 1.0)
    return Motion(
        way=np.where(moving, pace.way[rows], 0.0),
        speed=pace.speed[rows],
        accelerate=slow,
        decelerate=slow,
        jerk=np.full(len(rows), np.inf),
        round_start=np.where(start, 0.0, np.maximum(ends.rounded_from(blend)[rows], SOME_ROUNDING)),
        round_end=np.where(end, 0.0, np.maximum(blend[rows], SOME_ROUNDING)),
        least=np.zeros(len(rows)),
        added=np.zeros(len(rows)),
        rate=np.ones(len(rows)),
    )


def _corners(
    moves: RecordedMoves, pace: _Pace, rows: Rows, before: Rows, fast: Floats, slow: Floats
) -> MoveCorners:
    """What the corners of the rows, of speeds `fast` (n,) and accelerations `slow` (n,), hang on; a neighbour of
    unknown acceleration brakes as the move itself does."""
    everywhere, speeds = pace.acceleration.copy(), pace.speed.copy()
    everywhere[rows], speeds[rows] = slow, fast
    last = before[rows]
    has = (last >= 0) & np.isfinite(pace.way[last]) & np.isfinite(speeds[last]) & (pace.way[last] > 0)
    way, speed = (np.where(has, values[last], values[rows]) for values in (pace.way, speeds))
    ratio = everywhere[last] / slow
    after = np.full(len(pace.way), -1)
    after[before[before >= 0]] = np.nonzero(before >= 0)[0]
    following = after[rows]
    goes_on = (following >= 0) & np.isfinite(pace.way[following])
    next_way = np.where(goes_on, pace.way[following], np.inf)
    runs = goes_on & np.isfinite(speeds[following]) & (pace.way[following] > 0)
    next_ratio = everywhere[following] / slow
    turns = np.where(moves.kind == JOINT, 1.0, 0.0)
    return MoveCorners(
        way,
        speed,
        np.where(has & np.isfinite(ratio), ratio, 1.0),
        np.minimum(way, pace.way[rows]),
        np.minimum(pace.way[rows], next_way),
        np.where(runs, next_way, pace.way[rows]),
        np.where(runs, speeds[following], speeds[rows]),
        np.where(runs & np.isfinite(next_ratio), next_ratio, 1.0),
        turns[rows],
        turns[np.where(has, last, rows)],
        turns[np.where(runs, following, rows)],
    )


def _by_share_of_the_way(motion: Motion, pace: _Pace, rows: Rows, before: Rows) -> Motion | None:
    """The motion whose joint moves are rounded over the share of their way [rad] that the rounding [m] is of the tool's
    way; None where no joint move is rounded or nothing tells the tool's ways."""
    if pace.tool_way is None or motion.corners is None:
        return None
    tool = pace.tool_way
    with np.errstate(divide="ignore", invalid="ignore"):
        turn = np.where(motion.way > 0, motion.way / tool[rows], 1.0)
    rounded = np.maximum(motion.round_start, motion.round_end) > SOME_ROUNDING
    if not np.isfinite(turn[rounded]).all() or (np.abs(turn - 1.0)[rounded] < SOME_ROUNDING).all():
        return None
    turn = np.where(rounded, turn, 1.0)
    last, after = before[rows], np.full(len(tool), -1)
    after[before[before >= 0]] = np.nonzero(before >= 0)[0]
    shorter = (
        np.where(others >= 0, np.fmin(tool[others], tool[rows]), tool[rows]) for others in (last, after[rows])
    )
    start, end = (np.where(rounded, turn * way, np.inf) for way in shorter)
    return motion.with_(
        round_start=turn * motion.round_start,
        round_end=turn * motion.round_end,
        corners=motion.corners._replace(shorter_start=start, shorter_end=end),
    )


def _partners(rows: Rows, before: Rows) -> CornerPartners | None:
    """The moves that those of the rows meet at rounded corners; None where there are no such corners."""
    place = np.full(len(before), -1, dtype=np.int64)
    place[rows] = np.arange(len(rows))
    last = np.where(before[rows] >= 0, place[before[rows]], -1)
    return CornerPartners.of_rows(last) if (last >= 0).any() else None


# --- rivals ---
# Axes that may take over from the one that leads a joint move in the judged simulation.

_ACCELERATIONS_KNOWN = 3  # moves that an axis leads: fewer do not tell its acceleration
_IDLE = 8.0  # times what the leading axis allows: an axis that allows more takes over from none


def with_rivals(case: MeasuredMoves, ramps: Floats) -> MeasuredMoves:
    """The case with the rivals of its leading axes; `ramps` (n,) [1]: of the axes' accelerations.

    Speeds are in proportion to the rated ones; an axis has the acceleration that the simulation shows where that axis
    leads. No rival is slower than the leading axis: the simulation's durations stay what they are. Where all limits
    hold at once, none allows less speed or less acceleration.
    """
    rates, base = case.rates, case.base
    if rates is None or rates.rated is None:
        return replace(case, rivals=None)
    turned = np.abs(rates.path[:, 0])
    at, lead = np.arange(len(case)), case.leads
    mine = case.joint & case.moving & rates.known & (base.way > 0)
    strongest = np.full(len(rates.names), np.inf)
    for axis in range(len(strongest)):
        led = (base.accelerate / ramps)[mine & (lead == axis)]
        if len(led) >= _ACCELERATIONS_KNOWN:
            strongest[axis] = np.median(led)
    with np.errstate(divide="ignore", invalid="ignore"):
        # What each axis allows, as a share of what the leading one does.
        faster = (rates.rated / turned) / (rates.rated[lead] / turned[at, lead])[:, None]
        stronger = (strongest / turned) * ((ramps / base.accelerate) * turned[at, lead])[:, None]
    rival = mine[:, None] & (turned > 0) & (np.minimum(faster, stronger) < _IDLE)
    rival[at, lead] = False
    of, leader = np.nonzero(rival)
    if not len(of):
        return replace(case, rivals=None)
    faster, stronger = (np.minimum(more[of, leader], _IDLE) for more in (faster, stronger))
    if case.slowest:
        later = np.maximum(1.0, _over_the_leading(base, of, faster, stronger))
        faster, stronger = faster * later, stronger * later**2
    else:
        faster, stronger = np.maximum(faster, 1.0), np.maximum(stronger, 1.0)
    turns = turned[of, leader] / turned[of, lead[of]]  # of the rival axis per turn of the leading one
    moves = replace(case, rivals=None, partners=None).take(of)
    assert moves.rates is not None
    limits = {
        name: getattr(base, name)[of] * more * turns
        for name, more in (("speed", faster), ("accelerate", stronger), ("decelerate", stronger))
    }
    own = replace(
        moves,
        base=moves.base.with_(way=base.way[of] * turns, corners=None, law="stop", **limits),
        rates=replace(moves.rates, path=moves.rates.path / turns[:, None, None]),
        leader=leader.astype(np.int64),
    )
    return replace(case, rivals=Rivals.of_moves(own, of))


def _over_the_leading(base: Motion, of: NDArray[np.intp], faster: Floats, stronger: Floats) -> Floats:
    """(r,) [1] The time of an axis that allows `faster` and `stronger` times what the leading one of move `of` does,
    over the time of that one."""
    way, speed, ramp = base.way[of], base.speed[of], base.accelerate[of]
    return trapezoid(way, speed * faster, ramp * stronger) / trapezoid(way, speed, ramp)


# --- circumstances ----------------------------------------------------------------------------------------------------


def _ends(moves: RecordedMoves, speed: Floats, late: Floats) -> MoveEnds:
    """Which moves begin at, and end in, an exact stop; and the row each goes on from, -1 for none.

    A job that calls another one goes on from where the arm is: controllers round such a corner as any other. Where no
    positions show that the next job begins there, the arm is taken to stop. `late` (n,) [s]: beyond the simulation.
    """
    written = moves.stops | (moves.kind == WAIT)
    gap = np.full(len(moves), np.nan)
    for start, end in ((moves.joints_start, moves.joints_end), (moves.start, moves.end)):
        apart = np.linalg.norm(start[1:] - end[:-1], axis=1) if start.size else gap[1:]
        gap[1:] = np.where(np.isfinite(apart), apart, gap[1:])
    same_job = np.array([True, *(a == b for a, b in zip(moves.job[:-1], moves.job[1:], strict=True))])
    goes_on = (same_job | np.isfinite(gap)) & ~(np.nan_to_num(gap) > _NEAR * 10)
    goes_on[:1] = False
    again = np.concatenate([[False], moves.cycle[1:] != moves.cycle[:-1]])
    twice = _recorded_twice(moves, goes_on)
    found = [_ends_where(moves, written, goes_on & asked, twice) for asked in (~again, np.ones_like(again))]
    if not (goes_on & again & ~np.append(True, written[:-1])).any():
        return found[0]
    if _rounded_into_the_next(moves, speed, late, goes_on, again):
        found.reverse()
    return found[0]._replace(other=found[1])


def _recorded_twice(moves: RecordedMoves, goes_on: Mask) -> Mask:
    """(n,) Rows that record the move of the row before once more: same line, same points, and nothing leads back."""
    same = ~goes_on & (moves.kind != WAIT)
    same[:1] = False
    points = np.hstack([moves.start, moves.end, moves.joints_start, moves.joints_end])
    asked = moves.speed, moves.speed_fraction, moves.blend, moves.sim
    told = np.column_stack([points, moves.kind, moves.line, moves.cycle, *asked])
    same[1:] &= ((told[1:] == told[:-1]) | np.isnan(told[1:] + told[:-1])).all(axis=1)
    same[1:] &= np.array([a == b for a, b in zip(moves.job[:-1], moves.job[1:], strict=True)], dtype=bool)
    return np.asarray(same, dtype=bool)


def _ends_where(moves: RecordedMoves, written: Mask, goes_on: Mask, twice: Mask) -> MoveEnds:
    """Of moves that end in a `written` stop, or else round into the next where that `goes_on` (n,) from them; rows that
    are recorded `twice` (n,) begin as the row before does, and that ends as they do."""
    start = ~goes_on
    start[1:] |= written[:-1]
    # The last move before a jump or the file's end has nothing to round into.
    follows = np.zeros(len(moves), dtype=bool)
    follows[:-1] = goes_on[1:] & (moves.kind[1:] != WAIT)
    end, before = written | ~follows, np.where(start, -1, np.arange(len(moves)) - 1)
    again = np.flatnonzero(twice)
    for row in again:
        start[row], before[row] = start[row - 1], before[row - 1]
    for row in again[::-1]:
        end[row - 1] = end[row]
    return MoveEnds(start, end, before, twice)


def _rounded_into_the_next(
    moves: RecordedMoves, speed: Floats, late: Floats, goes_on: Mask, again: Mask
) -> bool:
    """Whether the last moves of cycles, where they are rounded, go on into the next cycle, which nobody writes: whether
    they, and those after them, are late (n,) [s] as other moves at corners are, or as those at stops.

    `goes_on`, `again` (n,): begins where the move before ended, and in another cycle. What a corner saves grows with
    the slower of the two speeds that meet there.
    """
    rounded = ~moves.stops & np.append(goes_on[1:], False) & (moves.kind != WAIT)
    ends = rounded & np.append(again[1:], False)
    slower = np.fmin(speed, np.append(speed[1:], np.nan))

    def told(corner: Mask) -> Floats:
        """(n, 7) what lateness may grow with, where moves end in a `corner` (n,)."""
        own, before = (np.stack([corner, corner * slower]), np.zeros((2, len(moves))))
        before[:, 1:] = own[:, :-1]
        return np.stack([np.ones(len(moves)), speed, moves.duration - late, *own, *before], axis=1)

    other = told(rounded & ~ends)
    known = np.isfinite(late) & np.isfinite(other).all(axis=1) & (moves.kind != WAIT)
    asked, corners = ends | np.append(False, ends[:-1]), known & rounded & ~ends
    stops = known & ~rounded & np.append(goes_on[1:], False)
    if (known & ends).sum() < _FEW_ENDS or min(corners.sum(), stops.sum()) < _FEW_LIKE:
        return False
    law = np.linalg.lstsq(other[known & ~asked], late[known & ~asked], rcond=None)[0]
    off = [np.median(np.abs(late - each @ law)[known & asked]) for each in (told(rounded), other)]
    return bool(off[0] < off[1])


def _executed(moves: RecordedMoves) -> Rows:
    """(n,) place of each move in the order of execution: a number that is left out is a move that nobody recorded,
    where numbers count the moves."""
    steps = np.diff(moves.move)
    counted = len(steps) > 0 and bool((steps > 0).all()) and float(np.mean(steps == 1)) > _COUNTED
    return np.asarray(moves.move - moves.move[0] if counted else np.arange(len(moves)), dtype=np.int64)


def _is_told(moves: RecordedMoves) -> Mask:
    """(n,) Whether the recording tells how a move ends: not of a last one that is rounded into what is not recorded."""
    told = np.ones(len(moves), dtype=bool)
    told[-1:] = moves.stops[-1:] | (moves.kind[-1:] == WAIT)
    return told


def _blends(recording: Recording, notes: list[str]) -> Floats:
    """(n,) [m] roundings; levels by the robot's zones, else by the usual ones of the maker."""
    moves, robot = recording.moves, recording.robot
    blend = np.nan_to_num(moves.blend)
    tagged = (moves.level > 0) & ~np.isfinite(np.where(moves.blend == 0, np.nan, moves.blend))
    if not tagged.any():
        return blend
    zones = robot.blend_zones if robot is not None else None
    if zones is None:
        zones = DEFAULT_ZONES
        notes.append("position levels without a robot: the zones of a Yaskawa MA2010 are assumed")
    table = np.array([0.0, *zones])
    return np.where(tagged, table[np.clip(moves.level, 0, len(table) - 1)], blend)


def _whole(override: Floats) -> Floats:
    """(n,) [1] where nothing is written, nothing is reduced."""
    return np.where(np.isfinite(override), override, 1.0)


def _turn(moves: RecordedMoves) -> Floats:
    """(n,) [rad] of the tool between start and end."""
    from olp.robots.geometry import rotation_from_angles

    angle = np.full(len(moves), np.nan)
    known = np.isfinite(moves.start_angles).all(axis=1) & np.isfinite(moves.end_angles).all(axis=1)
    if known.any():
        one = rotation_from_angles(moves.start_angles[known])
        two = rotation_from_angles(moves.end_angles[known])
        trace = np.einsum("nij,nij->n", one, two)
        angle[known] = np.arccos(np.clip((trace - 1.0) / 2.0, -1.0, 1.0))
    return angle


def _headings(moves: RecordedMoves) -> Floats:
    """(n, 3) [1] the size of each line's direction along the axes of the frame; nan of other moves, and where points
    are not known."""
    way = np.where((moves.kind == LINEAR)[:, None], np.abs(moves.end - moves.start), np.nan)
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.asarray(way / np.linalg.norm(way, axis=1)[:, None])


def _corner(moves: RecordedMoves) -> Floats:
    """(n,) [rad] by which the direction changes at a move's end; nan where the next move's is not known."""
    way = moves.end - moves.start
    with np.errstate(divide="ignore", invalid="ignore"):
        unit = way / np.linalg.norm(way, axis=1)[:, None]
    angle = np.full(len(moves), np.nan)
    angle[:-1] = np.arccos(np.clip(np.einsum("ni,ni->n", unit[:-1], unit[1:]), -1.0, 1.0))
    return angle


def _opened(motion: Motion, moves: RecordedMoves, rows: Rows, ends: MoveEnds, across: Floats) -> Motion:
    """The motion with its corners' openness: the radius of the arc that touches both moves, over the rounding, times
    the acceleration `across` (n,) the way; an arc of the rounding's own radius where one of both is no line. And by how
    much lines turn."""
    angle = _corner(moves)
    line = moves.kind == LINEAR
    both = line & np.append(line[1:], False) & np.isfinite(angle)
    open_ = np.where(both, np.minimum(1.0 / np.tan(np.clip(angle, 1e-6, np.pi) / 2.0), _STRAIGHT_ON), 1.0)
    bend = np.where(both, angle, 0.0)
    for row in np.flatnonzero(ends.twice)[::-1]:
        open_[row - 1], bend[row - 1] = open_[row], bend[row]
    last = ends.before[rows]
    at_start = np.where(last >= 0, open_[last], 1.0)
    return motion.with_(
        open_start=at_start * across,
        open_end=open_[rows] * across,
        bend_start=np.where(last >= 0, bend[last], 0.0),
        bend_end=bend[rows],
    )
