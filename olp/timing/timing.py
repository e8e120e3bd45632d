"""Times a plan with a motion model: seconds per step."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from olp.core.diagnostic import Diagnostic, OlpError, error, info, warning
from olp.core.units import deg, mm, percent
from olp.ir.program import Path
from olp.robots.controller_effects import Effects, effects_of, generation_of, settling_of
from olp.runtime.paths import circle
from olp.runtime.plan import PATHS, Assumption, BlendCode, Plan, StepKind, distinct, of_rows
from olp.timing.acceleration.law import load_law
from olp.timing.accelerations import MotionLimits, filter_time
from olp.timing.arm_prior import LineAcceleration, line_acceleration
from olp.timing.blending.law import load_law as load_corners
from olp.timing.chain import Caps, Chain, chain
from olp.timing.correction import NOTHING_LEARNT, Correction, PlanCorrection
from olp.timing.demand import Demand, demand
from olp.timing.joint_times import KNOWN_DOUBT
from olp.timing.motion._profile import Problem, Profile
from olp.timing.motion.model import MotionModel, load_model
from olp.timing.path_law import MOST_OF_A_STOP
from olp.timing.result import RowTimes, Timing

DEFAULT_MODEL = "constant"
DEFAULT_LAW = "constant"
Floats = NDArray[np.float64]


def time_plan(
    plan: Plan,
    model: str | None = None,
    acceleration: float | None = None,
    override: float | None = None,
    acceleration_law: str | None = None,
    learnt: Correction | None = None,
    **parameters: float,
) -> Timing:
    """Times every step of `plan`.

    `model`, `acceleration` [m/s²] of linear moves, the speed `override` [1] and the `acceleration_law` take
    precedence over olp.toml, and olp.toml over the robot; `parameters` go to the motion model (SI). `learnt`
    corrects straight moves and everything else that was learnt, including settling, and gives an interval; it needs
    constant acceleration (H013). Steps that cannot be timed are nan and have a diagnostic. Raises OlpError for an
    unknown model, law or parameter, and for an override that no controller has.
    """
    chosen = _model(plan, model, learnt)
    learnt = learnt or NOTHING_LEARNT
    assumed: dict[str, Assumption] = {}
    limits = _limits(plan, acceleration, acceleration_law, learnt, assumed)
    effects = effects_of(plan.settings, override)
    for says in effects.told:
        limits.report(says)
    by_axes = limits.law is None or limits.law.name == DEFAULT_LAW
    if limits.law is not None and not by_axes:
        limits.report(f"{limits.law.name} acceleration law: {limits.law.summary}")
    overrides = plan.overrides(effects.override)
    wanted = demand(_at_override(plan, overrides), limits)
    _stretch(plan, wanted, overrides)
    able = wanted.acceleration.copy(), wanted.deceleration.copy()
    correction = learnt.of_plan(plan, wanted, overrides, by_axes, limits.report)
    turning = wanted
    if len(correction.rows) and load_corners(plan.zone_law).runs_at_once:
        turning = _turning(wanted, correction.rows, *able)
    joined = correction.corners(_feasible(plan, chosen, wanted, turning, parameters))
    correction = correction.follow(wanted, joined, overrides, limits.report)
    profile = _profile(chosen, wanted, joined, parameters)
    report_inferred(plan, wanted.length > 0, limits.report)
    settling = _settling(plan, joined, limits, effects, correction)
    durations = np.where(wanted.unknown, np.nan, np.maximum(_moving(profile, joined) + settling, 0.0))
    if not np.isnan(plan.moves.duration).all():
        least = _moving(_profile(chosen, _at_limits(plan, wanted), joined, parameters), joined)
        durations = _programmed(plan.moves.duration / overrides, durations, least)
    for says in correction.doubts():
        limits.report(says)
    durations = correction.with_whole_times(durations)
    timing = _gather(plan, chosen.name, wanted, profile, durations, settling, joined, effects, correction)
    given = limits.linear_acceleration
    lines = (
        line_acceleration(plan.robot)
        if given is None
        else LineAcceleration(given, KNOWN_DOUBT, "given", True)
    )
    timing = correction.with_interval(timing, wanted, joined, (durations, settling), lines, limits.report)
    if timing.expected is not None:
        stops = _unknown_stops(plan, joined, effects, correction) & (wanted.length > 0)
        low, high = timing.expected
        count = int(stops[plan.row[plan.kind == StepKind.MOVE]].sum())
        timing = replace(timing, expected=(low, high + MOST_OF_A_STOP * count))
    problems = [*_problems(plan, wanted, durations), *_oddities(plan, wanted)]
    return replace(
        timing,
        assumptions=(*plan.assumptions, *assumed.values()),
        diagnostics=(*plan.diagnostics, *wanted.diagnostics, *problems),
    )


def _model(plan: Plan, name: str | None, learnt: Correction | None) -> MotionModel:
    """The requested motion model. Raises OlpError: H013 a model for which `learnt` does not hold."""
    if learnt is None:
        return load_model(name or str(plan.settings.get("model", DEFAULT_MODEL)))
    if name not in (None, DEFAULT_MODEL):
        says = f"a signature holds for the constant acceleration model, not for {name}"
        raise OlpError(error("H013", says, help="leave out --model, or --signature"))
    return load_model(DEFAULT_MODEL)


def _limits(
    plan: Plan,
    acceleration: float | None,
    law: str | None,
    learnt: Correction,
    assumed: dict[str, Assumption],
) -> MotionLimits:
    """Limits from the arguments, else from olp.toml. `assumed` collects the reported assumptions, each sentence
    once.
    """
    settings = plan.settings
    if acceleration is None and "accel_mm_s2" in settings:
        acceleration = float(settings["accel_mm_s2"]) * mm

    def report(says: str) -> None:
        assumed.setdefault(says, Assumption(0, says))

    return MotionLimits(
        acceleration,
        report,
        load_law(law or str(settings.get("acceleration_law", DEFAULT_LAW))),
        learnt.axis_scale,
        plan.robot if learnt.knows_joint_moves else None,
    )


def _profile(chosen: MotionModel, wanted: Demand, joined: Chain, parameters: dict[str, float]) -> Profile:
    """Speed over time of every row of Moves; rows that cannot be timed get length 0."""
    return chosen.profile(
        np.where(wanted.unknown, 0.0, _left(wanted.length - joined.trim)),
        np.where(wanted.unknown, 1.0, wanted.speed),
        np.where(wanted.unknown, 1.0, wanted.acceleration),
        np.where(wanted.unknown, 1.0, wanted.deceleration),
        joined.start_speed,
        joined.end_speed,
        **parameters,
    )


def _turning(wanted: Demand, learnt: NDArray[np.intp], up: Floats, down: Floats) -> Demand:
    """The demand at corners: the `learnt` rows use at least `up` and `down`, because a learnt acceleration includes
    the cost of stops.
    """
    faster, braking = wanted.acceleration.copy(), wanted.deceleration.copy()
    faster[learnt], braking[learnt] = np.maximum(faster, up)[learnt], np.maximum(braking, down)[learnt]
    return replace(wanted, acceleration=faster, deceleration=braking)


def _feasible(
    plan: Plan, chosen: MotionModel, wanted: Demand, turning: Demand, parameters: dict[str, float]
) -> Chain:
    """The chain, with corners so slow that `chosen` can change its speed between them: limited jerk needs longer
    distances.

    `turning`: the demand with the accelerations of corners.
    """
    joined, caps = chain(plan, turning), Caps(*np.full((2, len(plan.moves)), np.inf))
    for turn in range(_MOST_SWEEPS):
        profile = _profile(chosen, wanted, joined, parameters)
        late = profile.problem == Problem.CANNOT_REACH
        early = profile.problem == Problem.CANNOT_BRAKE
        if not (late | early).any():
            return joined
        # Backwards in time braking is gaining speed: how fast a row may begin to be able to end so.
        swapped = replace(wanted, acceleration=wanted.deceleration, deceleration=wanted.acceleration)
        back = replace(joined, start_speed=joined.end_speed, end_speed=joined.start_speed)
        backwards = _profile(chosen, swapped, back, parameters)
        keep = 1.0 if turn < _MOST_SWEEPS // 2 else 0.0
        caps.end[late] = np.minimum(caps.end, profile.end_speed * keep)[late]
        caps.start[early] = np.minimum(caps.start, backwards.end_speed * keep)[early]
        joined = chain(plan, turning, caps)
    return joined


_MOST_SWEEPS = (
    40  # one for each row that a chain of short ones brakes over; from the middle on it stops instead
)


def _programmed(told: Floats, durations: Floats, least: Floats) -> Floats:
    """Durations [s] replaced by programmed times `told`, which include the ramps; at least `least`, the arm's
    fastest.
    """
    return np.where(np.isnan(told) | np.isnan(durations), durations, np.maximum(told, least))


def _at_limits(plan: Plan, wanted: Demand) -> Demand:
    """The demand with moves of a programmed time at the highest speed that olp allows any line: their shortest
    duration.
    """
    timed = ~np.isnan(plan.moves.duration)
    return replace(wanted, speed=np.where(timed, np.maximum(wanted.speed, _FASTEST), wanted.speed))


_FASTEST = 10.0  # [m/s] no arm's tool is faster; for the least time of moves whose time is programmed


def _left(length: Floats) -> Floats:
    """Length [m] of a move between its corners; rounding errors are set to zero where two corners meet in its
    middle.
    """
    return np.where(np.abs(length) < _ROUNDING, 0.0, length)


_ROUNDING = 1e-12  # [m]


def _at_override(plan: Plan, override: Floats) -> Plan:
    """The plan with its programmed speeds scaled by the overrides (m,) [1] of its rows; VJ is limited to rated
    speed.
    """
    if np.all(override == 1.0):
        return plan
    moves = plan.moves
    fraction = np.minimum(moves.fraction * override, np.maximum(moves.fraction, 1.0))
    slowed = replace(
        moves,
        fraction=fraction,
        travel=moves.travel * override,
        turn=moves.turn * override,
        axis_speed=moves.axis_speed * override,
        duration=moves.duration / override,
    )
    return replace(plan, moves=slowed)


def _stretch(plan: Plan, wanted: Demand, overrides: Floats) -> None:
    """Scale the ramps by the controllers' overrides: a stretched time axis lowers accelerations by the square."""
    for index, robot in enumerate(plan.robots):
        known = generation_of(robot.controllers if robot is not None else ()).override_exponent
        if known is not None:
            rows = plan.moves.mechanism == index
            lowered = overrides[rows] ** known.value
            wanted.acceleration[rows] *= lowered
            wanted.deceleration[rows] *= lowered


def _settling(
    plan: Plan, joined: Chain, limits: MotionLimits, effects: Effects, correction: PlanCorrection
) -> Floats:
    """Time [s] that the stop of each row of Moves takes beyond the motion."""
    settling, assumed = settling_of(effects, plan.robot)
    if assumed and (joined.exact_stop & ~correction.knows_stops).any():
        limits.report(assumed)
    # What an exact stop was measured to cost holds the filter's time, which the law has counted already.
    return correction.settled(joined.exact_stop, max(0.0, settling - filter_time(plan, limits)))


def _unknown_stops(
    plan: Plan, joined: Chain, effects: Effects, correction: PlanCorrection
) -> NDArray[np.bool_]:
    """Exact stops (k,) that count as free because their settling time is unknown."""
    value, assumed = settling_of(effects, plan.robot)
    return joined.exact_stop & ~correction.knows_stops & bool(assumed and not value)


def _gather(
    plan: Plan,
    model: str,
    wanted: Demand,
    profile: Profile,
    rows: Floats,
    settling: Floats,
    joined: Chain,
    effects: Effects,
    correction: PlanCorrection,
) -> Timing:
    """Combine rows of Moves to steps: a move lasts as long as its slowest mechanism, and is described by its
    leading one.
    """
    count = len(plan)
    is_move = plan.kind == StepKind.MOVE
    first = plan.row[is_move]
    duration, stop, kind = np.zeros(count), np.zeros(count), [""] * count
    if len(first):
        duration[is_move] = np.maximum.reduceat(rows, first)
        stop[is_move] = np.maximum.reduceat(settling, first)
    timed = ~is_move
    duration[timed] = plan.durations[plan.row[timed]]
    added = additions(plan, joined.end_speed, duration, effects, correction.measured_stops)
    moves = plan.moves

    def column(values: Floats) -> Floats:
        result = np.full(count, np.nan)
        result[is_move] = values[first]
        return result

    names = [str(path) for path in PATHS]
    steps = np.nonzero(is_move)[0].tolist()
    for step, path in zip(steps, moves.path[first].tolist(), strict=True):
        kind[step] = names[path]
    waits = (plan.kind == StepKind.WAIT)[timed].tolist()
    for step, waiting in zip(np.nonzero(timed)[0].tolist(), waits, strict=True):
        kind[step] = "wait" if waiting else "signal"
    # The tool's path in a joint move is no line, so its speed along the chord would mislead.
    travelling = wanted.metric & ~wanted.unknown & (moves.path != PATHS.index(Path.JOINT))
    metric = np.where(travelling, 1.0, np.nan)
    return Timing(
        plan=plan,
        model=model,
        rows=_row_times(plan, duration, added, wanted, profile, joined, settling),
        kind=tuple(kind),
        distance_mm=column(moves.length / mm),
        speed_mm_s=column(moves.travel / mm),
        reached_mm_s=column(profile.peak_speed * metric / mm),
        accel_mm_s2=column(wanted.acceleration * metric / mm),
        limited_by=_limited_by(plan, _rules(wanted, profile), rows),
        duration_s=duration + added.total,
        stop_s=stop,
        speed_pct=column(moves.fraction / percent),
        speed_deg_s=column(np.where(np.isnan(moves.turn), moves.axis_speed, moves.turn) / deg),
        angle_deg=column(moves.angle / deg),
        assumptions=(),
        diagnostics=(),
    )


def _limited_by(plan: Plan, rules: list[str], rows: Floats) -> tuple[str, ...]:
    """Limit of each step: that of its slowest mechanism, which is named if it is not the leading one."""
    limited = [""] * len(plan)
    steps = np.nonzero(plan.kind == StepKind.MOVE)[0].tolist()
    first = plan.row[steps].tolist()
    for step, start, stop in zip(steps, first, [*first[1:], len(rows)][: len(first)], strict=True):
        limited[step] = rules[start]
        if stop - start > 1:
            part = rows[start:stop]
            slowest = start + int(np.argmax(part))  # an unknown one counts as the slowest
            if np.isnan(part).any():
                limited[step] = ""
            elif rows[slowest] > rows[start] * (1 + 1e-9):
                mechanism = plan.mechanisms[int(plan.moves.mechanism[slowest])]
                rule = rules[slowest]  # of a station it names the station already
                limited[step] = rule if rule.startswith(mechanism) else f"{mechanism} {rule}"
    return tuple(limited)


def _row_times(
    plan: Plan,
    duration: Floats,
    added: Additions,
    wanted: Demand,
    profile: Profile,
    joined: Chain,
    settling: Floats,
) -> RowTimes:
    """Clock of each row: see RowTimes."""
    is_move = plan.kind == StepKind.MOVE
    per_step = np.diff(np.append(plan.row[is_move], len(plan.moves)))
    ends = np.cumsum(np.nan_to_num(duration + added.total))
    begins = np.concatenate(([0.0], ends))[:-1] + added.before
    step_time = np.repeat(duration[is_move], per_step)
    own, moving = _moving(profile, joined), step_time - settling
    # A programmed or learnt time may leave nothing for settling.
    moving = np.where(moving > 0, moving, step_time)
    with np.errstate(divide="ignore", invalid="ignore"):
        rate = np.where((moving > 0) & (own > 0) & np.isfinite(own), own / moving, 1.0)
    rate = np.where(np.abs(rate - 1.0) < _SAME_RATE, 1.0, rate)
    lead = np.where(joined.previous >= 0, joined.corners.lead[joined.previous], 0.0)
    start = np.repeat(begins[is_move], per_step) - lead / rate
    length = np.where(wanted.unknown, 0.0, wanted.length)
    return RowTimes(profile, start, rate, length, joined.corners, joined.previous)


def _moving(profile: Profile, joined: Chain) -> Floats:
    """Time [s] of the motion of each row of Moves: its body and its corners."""
    moving: Floats = profile.duration + joined.cornering - joined.saving
    return moving


_SAME_RATE = 1e-9  # [1] a clock that differs by less runs at one second per second


def _rules(wanted: Demand, profile: Profile) -> list[str]:
    """Limit of each row that a faster move would have to raise."""
    reached = profile.reached
    words = []
    for rule in wanted.names:
        words.append((f"{rule} acceleration".strip(), f"{rule} speed".strip()))
    # An axis that slows a line says nothing of how the tool accelerates on it.
    codes = np.where(wanted.slowed & ~reached, 0, wanted.rule)
    rows = zip(codes.tolist(), reached.tolist(), (wanted.length > 0).tolist(), strict=True)
    return [words[code][ok] if moves else "" for code, ok, moves in rows]


def _problems(plan: Plan, wanted: Demand, rows: Floats) -> list[Diagnostic]:
    """One diagnostic per file and reason why statements cannot be timed, at the first of these statements."""
    bad = np.nonzero(~np.isfinite(rows))[0]
    if not len(bad):
        return []
    from olp.runtime.plan import ROBOT_IS_ASKED_FOR

    reasons: dict[tuple[str, str], list[int]] = {}
    robot_asked_for = any(d.code in ROBOT_IS_ASKED_FOR for d in plan.diagnostics)
    for row in bad.tolist():
        if robot_asked_for and plan.robots[int(plan.moves.mechanism[row])] is None:
            continue
        reasons.setdefault(_why(plan, wanted, row), []).append(row)
    return [
        finding
        for (says, how), found in reasons.items()
        for finding in of_rows(plan, np.array(found), error, "T101", says, how)
    ]


def _why(plan: Plan, wanted: Demand, row: int) -> tuple[str, str]:
    moves = plan.moves
    if not wanted.unknown[row]:
        return "this move never ends: its speed is zero", "give it a speed above zero"
    speeds = (moves.fraction, moves.travel, moves.turn, moves.axis_speed, moves.duration)
    if all(np.isnan(speed[row]) for speed in speeds):
        return (
            "the speed of this move is not known",
            "write V= or VJ=, or give the variable a value in olp.toml",
        )
    mechanism = int(moves.mechanism[row])
    if plan.robots[mechanism] is None:
        says = f"this move needs the robot's axes, and the robot of {plan.mechanisms[mechanism]} is not known"
        return says, "name it with --robot, or robot = … in olp.toml; `olp robots` lists the library"
    return "this move's start or target is not known, or cannot be reached", (
        "check the frame, the tool and the arm configuration of its points, and of the move before"
    )


# --- Inferred numbers ---
# Which numbers of the robots nobody published: a time that rests on them is one that rests on an assumption.

# Groups of a robot file's `inferred`, as its reader would say them, and what makes a time depend on them.
_OF_JOINT_MOVES = {"speed": "axis speeds", "acceleration": "axis accelerations"}
_OF_LINES = {"linear_acceleration": "acceleration of linear moves"}
_OF_CORNERS = {"blend_zones": "zones of the position levels"}


def report_inferred(plan: Plan, moving: NDArray[np.bool_], report: Callable[[str], None]) -> None:
    """Calls `report` with one sentence per robot whose inferred numbers were used; `moving` (m,): rows with motion."""
    moves = plan.moves
    joint = moves.path == PATHS.index(Path.JOINT)
    told: dict[str, dict[str, None]] = {}
    for index, robot in enumerate(plan.robots):
        if robot is None or not robot.inferred:
            continue
        mine = moving & (moves.mechanism == index)
        used = {
            **(_OF_JOINT_MOVES if (mine & joint).any() else {}),
            **(_OF_LINES if (mine & ~joint).any() else {}),
            **(_OF_CORNERS if (mine & (moves.blend_code == BlendCode.ZONE)).any() else {}),
        }
        words = told.setdefault(robot.name, {})
        words.update(dict.fromkeys(text for group, text in used.items() if group in robot.inferred))
    for name, words in told.items():
        if words:
            report(f"inferred, not published, for {name}: {', '.join(words)} (olp robots {name} -v)")


# --- Additions ---
# What the controller adds to each step: before it begins, and after its motion has ended.

_ADDITIONS_ROUNDING = 1e-9  # of a cycle: a motion that ends this little after a cycle ended with it


class Additions(NamedTuple):
    """Controller effects added before and after each step of the plan (n,) [s]."""

    before: Floats
    after: Floats

    @property
    def total(self) -> Floats:
        return self.before + self.after


def additions(
    plan: Plan,
    end_speed: Floats,
    duration: Floats,
    effects: Effects,
    measured: NDArray[np.bool_] | None = None,
) -> Additions:
    """Times that the controller adds to each step: dispatch, servo lag, whole cycles.

    `end_speed` [m/s] per row of Moves; `duration` [s] per step, of the motion, the wait or the signal itself.
    `measured`, per row of Moves: moves whose learnt time, from stop to stop, already includes these additions.
    """
    count = len(plan)
    before, after = np.zeros(count), np.zeros(count)
    if not count or not (effects.dispatch or effects.servo_lag or effects.cycle):
        return Additions(before, after)
    is_move = plan.kind == StepKind.MOVE
    moves = is_move & (np.nan_to_num(duration) > 0)
    stops = np.zeros(count, dtype=bool)
    if is_move.any():
        stops[is_move] = np.maximum.reduceat(end_speed, plan.row[is_move]) == 0.0
    stops &= moves
    learnt = np.zeros(count, dtype=bool)
    if measured is not None and is_move.any():
        learnt[is_move] = measured[plan.row[is_move]]
    before[_standing_before(moves, stops) & ~learnt] = effects.dispatch
    after[stops & ~learnt] = effects.servo_lag
    if effects.cycle:
        whole = _to_whole_cycles(np.where(moves, np.nan_to_num(duration) + after, 0.0), stops, effects.cycle)
        after += np.where(learnt, 0.0, whole)
    return Additions(before, after)


def _standing_before(moves: NDArray[np.bool_], stops: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Whether the last motion before each step ended in a stop; the first step starts at rest."""
    last = np.maximum.accumulate(np.where(moves, np.arange(len(moves)), -1))
    earlier = np.concatenate(([-1], last[:-1]))
    standing: NDArray[np.bool_] = (earlier < 0) | stops[earlier]
    return standing


def _to_whole_cycles(motion: Floats, stops: NDArray[np.bool_], cycle: float) -> Floats:
    """Time [s] that each stop waits for the end of its interpolation cycle."""
    stretch = np.concatenate(([0], np.cumsum(stops)[:-1]))
    sums = np.bincount(stretch, weights=motion)
    missing = np.ceil(sums / cycle - _ADDITIONS_ROUNDING) * cycle - sums
    result: Floats = np.where(stops, np.maximum(missing, 0.0)[stretch], 0.0)
    return result


# --- Oddities ---
# Moves that are timed, but hardly as whoever wrote them meant: told at the first of them, the others counted.


_CIRCULAR = PATHS.index(Path.CIRCULAR)
_NOTHING = 1e-9  # [m] or [rad]: below this nothing moves


def _oddities(plan: Plan, wanted: Demand) -> list[Diagnostic]:
    """T102 moves to the current position, T103 circular moves that are lines, T104 zones longer than a move."""
    return [*_nowhere(plan, wanted), *_no_circle(plan), *_long_zones(plan, wanted)]


def _nowhere(plan: Plan, wanted: Demand) -> Iterator[Diagnostic]:
    moves = plan.moves
    still = (wanted.length <= _NOTHING) & ~wanted.unknown
    still[np.unique(moves.mechanism, return_index=True)[1]] = (
        False  # of the first move nobody knows the start
    )
    first = plan.row[plan.kind == StepKind.MOVE]
    rows = first[np.logical_and.reduceat(still, first)] if len(first) else first
    says = "the arm is already at the target of this move: it takes no time"
    yield from of_rows(plan, rows, info, "T102", says, "leave it out, or correct its point")


def _no_circle(plan: Plan) -> Iterator[Diagnostic]:
    moves = plan.moves
    rows = np.flatnonzero((moves.path == _CIRCULAR) & (moves.length > _NOTHING))
    if not len(rows):
        return
    point, arcs = plan.positions.position, rows[moves.via[rows] >= 0]
    _, radius, _ = circle(*(point[at[arcs]] for at in (moves.start, moves.target, moves.via)))
    says = "the three points of this arc lie on a line, or two of them are one: it is timed as a line"
    how = "move the middle point off the line, or write a linear move"
    yield from of_rows(plan, arcs[np.isinf(radius)], warning, "T103", says, how)
    after = _following(moves.mechanism)
    on_arc = (moves.path == _CIRCULAR) & (moves.via >= 0)
    lines = rows[moves.via[rows] < 0]
    alone = lines[(after[lines] < 0) | ~on_arc[after[lines]]]
    says = "this circular move has no two others beside it to make an arc with: it is timed as a line"
    yield from of_rows(
        plan, alone, warning, "T103", says, "an arc takes three circular moves, the first to where it begins"
    )


def _long_zones(plan: Plan, wanted: Demand) -> Iterator[Diagnostic]:
    """T104 for zones longer than a whole move; a zone is cut to half of the shorter neighbour, as controllers do."""
    moves = plan.moves
    zoned = np.flatnonzero(moves.blend_code == BlendCode.ZONE)
    if not len(zoned) or load_corners(plan.zone_law).share_zones:
        return
    if load_corners(plan.zone_law).overlap_skips:
        yield from _overlapping_zones(plan, wanted)
        return
    after = _following(moves.mechanism)[zoned]
    zoned, after = zoned[after >= 0], after[after >= 0]
    travels = _travels(wanted)
    both = travels[zoned] & travels[after]
    zoned, after = zoned[both], after[both]
    shorter = np.minimum(wanted.length[zoned], wanted.length[after])
    long = moves.blend[zoned] > shorter * (1 + 1e-9)
    rows = zoned[long]
    if len(rows):
        zone, cut = moves.blend[rows[0]] / mm, shorter[long][0] / 2 / mm
        says = (
            f"the corner's zone of {zone:g} mm is longer than the shorter of its moves: {cut:.3g} mm are used"
        )
        how = "a zone ends at half of the shorter move: a smaller one that still does changes nothing"
        yield from of_rows(plan, rows, warning, "T104", says, how)


def _overlapping_zones(plan: Plan, wanted: Demand) -> Iterator[Diagnostic]:
    """T104 where two zones touch, for robots that then skip the point."""
    moves = plan.moves
    zone = np.where(moves.blend_code == BlendCode.ZONE, moves.blend, 0.0)
    after = _following(moves.mechanism)
    first = np.flatnonzero((after >= 0) & _travels(wanted)[after])
    second = after[first]
    room = wanted.length[second]
    over = zone[first] + zone[second] > room * (1 - 1e-9)
    if not over.any():
        return
    rows = np.unique(np.concatenate((first[over], second[over])))
    asked, way = (zone[first] + zone[second])[over][0] / mm, room[over][0] / mm
    says = (
        f"blends overlap here: they take {asked:.4g} mm of a path of {way:.4g} mm; the robot skips such a point "
        "and warns; timed with half of the path"
    )
    how = "make r smaller: the radii of two points together must be less than the distance between them"
    yield from of_rows(plan, rows[zone[rows] > 0], warning, "T104", says, how)


def _travels(wanted: Demand) -> NDArray[np.bool_]:
    """Rows (m,) with a known length in metres above zero."""
    travels: NDArray[np.bool_] = wanted.metric & ~wanted.unknown & (wanted.length > _NOTHING)
    return travels


def _following(mechanism: NDArray[np.int16]) -> NDArray[np.intp]:
    """The next row of the same mechanism (m,), -1 for its last row."""
    result = np.full(len(mechanism), -1, dtype=np.intp)
    for index in distinct(mechanism):
        rows = np.flatnonzero(mechanism == index)
        result[rows[:-1]] = rows[1:]
    return result
