"""Explains one line of a program: the phases of its motion, what limits each, and the load of every axis."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from olp.core.diagnostic import Diagnostic, OlpError, error
from olp.core.source import file_stem
from olp.core.units import deg, mm, percent
from olp.ir.program import Path
from olp.robots.controller_effects import effects_of
from olp.runtime.plan import PATHS, BlendCode, Plan, StepKind
from olp.timing.motion.model import load_model
from olp.timing.track import states, tool_speed

if TYPE_CHECKING:
    from olp.robots.model import Robot
    from olp.timing.result import Timing


Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class Phase:
    """A stretch of the segment's motion. Times [s] of the program; `speeds` [m/s] (or [rad/s] of an axis) at its ends.

    `length` [m] (or [rad]); `kind`: join, rise, cruise, fall or rest, for the picture's shading.
    """

    name: str
    kind: str
    begin: float
    end: float
    length: float
    speeds: tuple[float, float]
    limit: str


@dataclass(frozen=True, slots=True)
class AxisLoad:
    """`speed` [rad/s or m/s] over time (n,), `rated` [rad/s or m/s]; `linear`: a slide.

    `torque` [Nm or N] over time (n,), without the tool's mass, None where the robot's masses are unknown;
    `torque_limit` [Nm or N], inf where unknown.
    """

    name: str
    speed: Floats
    rated: float
    linear: bool
    torque: Floats | None = None
    torque_limit: float = float("inf")

    @property
    def share(self) -> Floats:
        """Share (n,) [1] of the rated speed."""
        return np.asarray(np.abs(self.speed) / self.rated, dtype=np.float64)

    @property
    def torque_share(self) -> Floats | None:
        """Share (n,) [1] of the torque limit, None where either is unknown."""
        if self.torque is None or not np.isfinite(self.torque_limit):
            return None
        return np.asarray(np.abs(self.torque) / self.torque_limit, dtype=np.float64)


@dataclass(frozen=True, slots=True)
class Explanation:
    """One execution of one line. `time` (n,) [s] of the program, `speed` (n,) [m/s] of the tool's point.

    `metric`: phases count in metres of the tool's path (True) or radians of the leading axis. `programmed` [m/s],
    nan for joint moves. `executions`: how often the line ran; this is the first that moves.
    """

    line: int
    statement: str
    kind: str
    begin: float
    duration: float
    executions: int
    limited_by: str
    phases: tuple[Phase, ...] = ()
    entry: str = ""
    exit: str = ""
    metric: bool = True
    programmed: float = float("nan")
    time: Floats | None = None
    speed: Floats | None = None
    axes: tuple[AxisLoad, ...] = ()
    gains: tuple[str, ...] = ()
    notes: tuple[str, ...] = ()


def as_text(told: Explanation) -> str:
    """The explanation as sentences and one table, ending in a line end."""
    rows = [f"line {told.line}: {told.statement}", f"  {_summary(told)}"]
    if told.phases:
        rows += ["", *_phase_table(told), "", f"  before: {told.entry}", f"  after:  {told.exit}"]
    busy = [axis for axis in told.axes if np.isfinite(axis.share).any()]
    if busy and told.time is not None:
        known = any(axis.torque is not None for axis in busy)
        more = "; highest torque and share of its limit, without the tool's mass" if known else ""
        rows += ["", f"  axes, highest speed and share of rated speed{more}:", *_axis_table(busy, told.time)]
    if told.gains:
        rows += ["", f"  {'; '.join(told.gains)}"]
    rows += [f"  {note}" for note in told.notes]
    return "\n".join(rows) + "\n"


def _summary(told: Explanation) -> str:
    span = (
        f"{told.duration:.3f} s, from {told.begin:.3f} to {told.begin + told.duration:.3f} s of the program"
    )
    often = f"; executed {told.executions} times, this is the first" if told.executions > 1 else ""
    limited = f", limited by {told.limited_by}" if told.limited_by else ""
    return f"{told.kind}, {span}{limited}{often}"


def _phase_table(told: Explanation) -> list[str]:
    unit, word = (mm, "mm") if told.metric else (deg, "deg")
    names = [phase.name for phase in told.phases]
    width = max(map(len, [*names, "phase"]))
    rows = [
        f"  {'phase':{width}}  {'from s':>8} {'to s':>8} {'s':>7} {word:>8}  {word + '/s':>15}  limited by"
    ]
    for phase in told.phases:
        first, last = (max(speed, 0.0) / unit for speed in phase.speeds)  # never -0.0
        speeds = f"{first:.1f} → {last:.1f}"
        rows.append(
            f"  {phase.name:{width}}  {phase.begin:8.3f} {phase.end:8.3f} {phase.end - phase.begin:7.3f} "
            f"{phase.length / unit:8.1f}  {speeds:>15}  {phase.limit}"
        )
    return rows


def _torque_words(axis: AxisLoad) -> str:
    if axis.torque is None:
        return ""
    peak, share = float(np.abs(axis.torque).max()), axis.torque_share
    limit = "" if share is None else f" {share.max() / percent:6.1f} %"
    return f"  {peak:8.1f} {'N' if axis.linear else 'Nm'}{limit}"


def _axis_table(axes: list[AxisLoad], time: Floats) -> list[str]:
    rows = []
    width = max(len(axis.name) for axis in axes)
    for axis in axes:
        share = np.nan_to_num(axis.share)
        at = int(np.argmax(share))
        unit, word = (mm, "mm/s") if axis.linear else (deg, "deg/s")
        note = "  beyond its rated speed" if share[at] > 1.0 + 1e-6 else ""
        rows.append(
            f"    {axis.name:{width}} {abs(axis.speed[at]) / unit:8.1f} {word:5} {share[at] / percent:6.1f} %"
            f"  at {time[at]:.3f} s{_torque_words(axis)}{note}"
        )
    return rows


_SAMPLES = 801  # instants of a segment
_EDGE = 3e-6  # [s]
_NOTHING = 1e-9  # [s] phases that are shorter are none
_PLACE = re.compile(r"(?:(?P<job>.+):)?(?P<line>\d{1,9})")


def explain(timing: Timing, place: str) -> Explanation:
    """Explains one execution of a line: `place` is a line of the main job ("51"), or of another one ("SEAM-ST:44").

    Raises OlpError E001 for an invalid place, E002 for a line without motion.
    """
    steps = _steps_at(timing, place)
    moving = [s for s in steps if timing.plan.kind[s] == StepKind.MOVE]
    lasting = [s for s in moving or steps if timing.duration_s[s] > 0]
    step = (lasting or moving or steps)[0]
    if timing.plan.kind[step] == StepKind.MOVE:
        _refuse_untimed(timing, step)
        return _of_move(timing, step, len(moving))
    says = f"the line takes {timing.duration_s[step]:.3f} s: nothing moves"
    return _base(timing, step, len(steps), notes=(says, *_assumed(timing, step)))


def _steps_at(timing: Timing, place: str) -> list[int]:
    match = _PLACE.fullmatch(place.strip())
    if match is None:
        says = f"{place[:60]!r} is no line"
        raise OlpError(error("E001", says, help="a line number, or JOB:LINE for a line of another job"))
    plan, line = timing.plan, int(match["line"])
    sources = _sources(plan, match["job"])
    steps = np.nonzero((plan.line == line) & np.isin(plan.source, sources))[0]
    if not len(steps):
        near = sorted(
            {int(n) for n in plan.line[np.isin(plan.source, sources)]}, key=lambda n: abs(n - line)
        )[:5]
        others = [
            file_stem(s.path) for i, s in enumerate(plan.sources) if i not in sources and _runs(plan, i, line)
        ]
        told = f"lines that do: {', '.join(map(str, sorted(near))) or 'none'}"
        told += "".join(f"; {name}:{line}" for name in others[:5])
        raise OlpError(error("E002", f"line {place} was not executed, or takes no time", help=told))
    return [int(step) for step in steps]


def _runs(plan: Plan, source: int, line: int) -> bool:
    return bool(np.any((plan.source == source) & (plan.line == line)))


def _sources(plan: Plan, job: str | None) -> list[int]:
    if job is None:
        return [0]
    names = [file_stem(source.path) for source in plan.sources]
    found = [i for i, name in enumerate(names) if file_stem(job).lower() == name.lower()]
    if not found:
        raise OlpError(
            error("E001", f"the program has no job {job[:60]!r}", help=f"it has: {', '.join(names)}")
        )
    return found


def _refuse_untimed(timing: Timing, step: int) -> None:
    if np.isfinite(timing.duration_s[step]):
        return
    line = int(timing.plan.line[step])
    errors: list[Diagnostic] = [d for d in timing.diagnostics if d.is_error]
    here = [d for d in errors if d.line == line]  # repeated troubles are told at the first line that has them
    raise OlpError(*(here or errors or [error("E002", f"line {line} cannot be timed")]))


def _base(timing: Timing, step: int, executions: int, **more: object) -> Explanation:
    plan = timing.plan
    end = float(timing.end_s[step])
    duration = float(timing.duration_s[step])
    return Explanation(
        line=int(plan.line[step]),
        statement=plan.statement(step),
        kind=timing.kind[step],
        begin=end - duration,
        duration=duration,
        executions=executions,
        limited_by=timing.limited_by[step],
        **more,  # type: ignore[arg-type]
    )


def _of_move(timing: Timing, step: int, executions: int) -> Explanation:
    plan, row = timing.plan, int(timing.plan.row[step])
    joint = plan.moves.path[row] == PATHS.index(Path.JOINT)
    metric = not joint or float(plan.moves.length[row]) > _NOTHING
    begin, end = float(timing.rows.start[row]), float(timing.end_s[step])
    phases = _phases(timing, step, row)
    last = max(end, phases[-1].end if phases else end)
    # Just inside: at the very edge the speed is that of two moves.
    instants = np.linspace(max(begin, 0.0) + _EDGE, min(last, timing.total_s) - _EDGE, _SAMPLES)
    known = not any(d.is_error for d in timing.diagnostics) and instants[-1] > instants[0]
    return _base(
        timing,
        step,
        executions,
        phases=phases,
        entry=_entry(timing, step, row),
        exit=_exit(timing, step, row),
        metric=metric,
        programmed=float(plan.moves.travel[row]),
        time=instants if known else None,
        speed=tool_speed(timing, instants) if known else None,
        axes=_loads(timing, instants) if known else (),
        gains=_gains(timing, row),
        notes=(*_held_up(timing, row), *_not_counted(timing, row), *_assumed(timing, step)),
    )


def _phases(timing: Timing, step: int, row: int) -> tuple[Phase, ...]:
    """Phases of the move in order, from the corner in which it begins to its settling."""
    clock, profile = timing.rows, timing.rows.profile.take(np.array([row]))
    corners, previous = clock.corners, int(clock.previous[row])
    start, rate = float(clock.start[row]), float(clock.rate[row])
    found, done = [], 0.0

    def add(
        name: str, kind: str, lasting: float, length: float, speeds: tuple[float, float], limit: str
    ) -> None:
        nonlocal done
        begin, done = done, done + lasting
        if lasting / rate > _NOTHING:
            found.append(Phase(name, kind, start + begin / rate, start + done / rate, length, speeds, limit))

    if previous >= 0:
        speed = float(corners.exit[previous])
        length = float(corners.after[previous])
        add("corner before", "rise", float(corners.span[previous]), length, (0.0, speed), _CORNER)
    for k, name in enumerate(profile.phases):
        speeds = float(profile.speeds[0, k]), float(profile.speeds[0, k + 1])
        kind = _kind(float(profile.accelerations[0, k]), float(profile.jerks[0, k]))
        length = float(profile.positions[0, k + 1] - profile.positions[0, k])
        add(name, kind, float(profile.durations[0, k]), length, speeds, _limit(timing, step, row, kind))
    speed = float(corners.entry[row])
    add("corner after", "fall", float(corners.span[row]), float(corners.before[row]), (speed, 0.0), _CORNER)
    last = start + done / rate
    rest = float(timing.end_s[step]) - last
    if rest > 1e-6:
        found.append(Phase("settling", "rest", last, last + rest, 0.0, (0.0, 0.0), _why_rest(timing, row)))
    return tuple(found)


_TOLD = 0.5e-3  # [s] a shorter corner reads as none
_CORNER = "the corner, which both of its lines move through"


def _kind(acceleration: float, jerk: float) -> str:
    change = acceleration if acceleration else jerk
    return "cruise" if change == 0 else "rise" if change > 0 else "fall"


def _why_rest(timing: Timing, row: int) -> str:
    moves = timing.plan.moves
    if moves.blend_code[row] == BlendCode.EXACT:
        return "the exact stop: the arm settles within its position window"
    return "the controller's own time at a stop"


def _limit(timing: Timing, step: int, row: int, kind: str) -> str:
    """The limit that keeps this phase from being shorter."""
    moves = timing.plan.moves
    rule = timing.limited_by[step]
    what = rule.removesuffix("acceleration").removesuffix("speed").strip()
    if kind == "cruise":
        return _speed_limit(timing, row, what)
    asked = timing.rows.profile.moves
    value = float((asked.acceleration if kind == "rise" else asked.deceleration)[row])
    share = float((moves.acceleration if kind == "rise" else moves.deceleration)[row])
    note = f", at {share / percent:g} % (written in the line)" if share != 1.0 else ""
    if what == "":
        return f"acceleration of the tool, {value / mm:.0f} mm/s²{note}"
    if what == "orientation":
        return f"how fast the wrist may change its turning speed{note}"
    return f"acceleration of {what}{note}"


def _speed_limit(timing: Timing, row: int, what: str) -> str:
    moves, asked = timing.plan.moves, float(timing.rows.profile.moves.speed[row])
    if what == "orientation":
        return f"turning the tool by {float(moves.angle[row]) / deg:.1f} deg: the travel waits for it"
    if what.endswith(("acceleration", "speed")) or (what and "axis" not in what):
        return what
    if what:
        fraction = float(moves.fraction[row])
        programmed = (
            f"{fraction / percent:g} % of its rated speed" if np.isfinite(fraction) else "its rated speed"
        )
        return f"speed of {what}: {programmed}"
    programmed_speed = float(moves.travel[row])
    if np.isfinite(programmed_speed) and asked < programmed_speed * (1 - 1e-9):
        return f"{asked / mm:.1f} mm/s instead of the programmed {programmed_speed / mm:.1f} mm/s"
    return f"the programmed speed, {asked / mm:.1f} mm/s"


def _neighbour(timing: Timing, step: int, way: int) -> int | None:
    """The next step before (`way` -1) or after (1) that moves."""
    plan, at = timing.plan, step + way
    while 0 <= at < len(plan):
        if plan.kind[at] == StepKind.MOVE and timing.rows.length[plan.row[at]] > 1e-9:
            return at
        at += way
    return None


def _entry(timing: Timing, step: int, row: int) -> str:
    before, speed = _neighbour(timing, step, -1), float(timing.rows.profile.speeds[row, 0])
    if before is None or speed == 0.0:
        return "begins from rest"
    line, row_before = int(timing.plan.line[before]), int(timing.rows.previous[row])
    both = float(timing.rows.corners.span[row_before]) if row_before >= 0 else 0.0
    if both > _TOLD:
        zone = float(timing.plan.moves.blend[row_before])
        size = (
            f" (zone {zone / mm:g} mm)" if timing.plan.moves.blend_code[row_before] == BlendCode.ZONE else ""
        )
        return f"begins while line {line} still runs: for {both:.3f} s both move the tool{size}"
    return f"goes on from line {line} at {_speed(timing, row, speed)}, without a stop"


def _exit(timing: Timing, step: int, row: int) -> str:
    plan, speed = timing.plan, float(timing.rows.profile.speeds[row, -1])
    after = _neighbour(timing, step, 1)
    if plan.moves.blend_code[row] == BlendCode.EXACT:
        return "stops exactly at its point (PL=0)"
    if speed == 0.0 or after is None:
        return "stops, because nothing follows that it could run into"
    line, both = int(plan.line[after]), float(timing.rows.corners.span[row])
    if both > _TOLD:
        return f"line {line} begins before this one has ended: for {both:.3f} s both move the tool"
    return f"passes its point at {_speed(timing, row, speed)} and goes on with line {line}"


def _speed(timing: Timing, row: int, speed: float) -> str:
    metric = timing.plan.moves.length[row] > _NOTHING
    return f"{speed / mm:.1f} mm/s" if metric else f"{speed / deg:.1f} deg/s"


def _loads(timing: Timing, instants: Floats) -> tuple[AxisLoad, ...]:
    robot = timing.plan.robot
    if robot is None or robot.geometry is None:
        return ()
    axes = states(timing, instants)[2][:, : len(robot.axes)]
    speeds = np.gradient(axes, instants, axis=0)
    torques, limits = _torques(robot, axes, speeds, instants)
    return tuple(
        AxisLoad(axis.name, speeds[:, i], axis.speed, axis.linear, torque, limit)
        for i, (axis, torque, limit) in enumerate(zip(robot.axes, torques, limits, strict=True))
    )


def _torques(
    robot: Robot, axes: Floats, speeds: Floats, instants: Floats
) -> tuple[list[Floats] | list[None], list[float]]:
    """Torque of each axis over time [Nm or N], and its limit."""
    count = len(robot.axes)
    if robot.dynamics is None or np.isnan(axes).any():
        return [None] * count, [float("inf")] * count
    from olp.robots.dynamics.torques import dynamic_model, inverse_dynamics

    model = dynamic_model(robot)
    torques = inverse_dynamics(model, axes, speeds, np.gradient(speeds, instants, axis=0))
    return [torques[:, i] for i in range(count)], model.torque_limits.tolist()


def _gains(timing: Timing, row: int) -> tuple[str, ...]:
    """Savings of twice the speed or twice the acceleration, all else unchanged."""
    asked, now = timing.rows.profile.moves, float(timing.rows.profile.duration[row])
    if now <= 0.0:
        return ()
    model = load_model(timing.model)
    found = []
    for words, faster, harder in (("speed", 2.0, 1.0), ("acceleration", 1.0, 2.0)):
        other = model.profile(
            asked.length[row],
            asked.speed[row] * faster,
            asked.acceleration[row] * harder,
            asked.deceleration[row] * harder,
            asked.start_speed[row],
            asked.end_speed[row],
        )
        found.append(f"twice the {words} would save {max(now - float(other.duration[0]), 0.0):.3f} s")
    return tuple(found)


def _held_up(timing: Timing, row: int) -> list[str]:
    if float(timing.rows.rate[row]) < 1.0 - 1e-9:
        return ["another mechanism of this line is slower: the arm keeps step with it"]
    return []


def _not_counted(timing: Timing, row: int) -> list[str]:
    """Effects that the controller may add at a stop but whose size is unknown."""
    if timing.rows.profile.speeds[row, 0] > 0.0 and timing.rows.profile.speeds[row, -1] > 0.0:
        return []
    says = effects_of(timing.plan.settings).not_counted
    return [says] if says else []


def _assumed(timing: Timing, step: int) -> list[str]:
    plan, line = timing.plan, int(timing.plan.line[step])
    path = plan.sources[int(plan.source[step])].path
    return [f"assumed: {a.says}" for a in timing.assumptions if a.line == line and a.file in ("", path)]
