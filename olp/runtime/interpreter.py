"""Executes a program: what is written becomes what happens."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from olp.core.diagnostic import Diagnostic, OlpError, Severity, Span, error, errors, warning
from olp.ir import expressions as ex
from olp.ir import program as st
from olp.ir import terminology
from olp.languages.vendor import ENDS_PROGRAM, find_vendor, part_of, vendor_names
from olp.robots.coordinate_systems import ROBOT_GAP, Gap
from olp.robots.robot import candidates_for_pulses
from olp.runtime import data, flow, moves, poses
from olp.runtime.assumptions import Assumptions, SignalKey, load_assumptions, nearest_assumptions, signal_name
from olp.runtime.computing import call_function
from olp.runtime.data import binary, frame_value, read_element
from olp.runtime.dispatch import NoSuchRoutineError, guessed
from olp.runtime.evaluate import (
    PLAIN,
    bind_uncalled,
    declare,
    declare_all,
    evaluate,
    holds,
    literal,
    quantity,
    read_name,
)
from olp.runtime.first_move import (
    MOST_STATEMENTS,
    AskedAt,
    Given,
    MoveReachedError,
    TakenValues,
    Try,
    holds_move,
    numbers_compared,
    shown,
    spelled,
    values_that_move,
    where_told,
)
from olp.runtime.flow import test
from olp.runtime.folder import build_world
from olp.runtime.jobs import Jobs
from olp.runtime.made_up import MadeUp, UnknownThing
from olp.runtime.memory import (
    ACTIVE,
    SAVED_NUMBERS,
    SAVED_POSITIONS,
    Memory,
    PositionValue,
    SystemPosition,
    Value,
    saved_position,
)
from olp.runtime.plan import PATHS, Event, Plan, of_rows
from olp.runtime.poses import as_pose, as_pulses, frame_pose, here
from olp.runtime.recorder import NOWHERE, Recorder
from olp.runtime.signals import (
    PERIPHERY,
    default_wait,
    expected_wait,
    impose,
    key_of,
    read_signal,
    signals_of,
    write_signal,
)
from olp.runtime.spelling import spell
from olp.runtime.state import (
    OTHER_FRAME,
    STEPS,
    CallFrame,
    EndedError,
    Machine,
    Operations,
    StatementError,
    role,
)
from olp.runtime.structures import literal_position, pose_value, read_item, read_member

if TYPE_CHECKING:
    import os

    from olp.ir.program import Program
    from olp.robots.model import Robot
    from olp.runtime.plan import Plan


# --- Waiting ---
# Statements that take time or set outputs: dwell, wait, pause, tasks, process instructions, messages.

_LONGEST = 1e7  # [s], four months


def dwell(m: Machine, s: st.Dwell) -> None:
    seconds = quantity(m, s.duration)
    if not 0.0 <= seconds <= _LONGEST:
        raise StatementError(
            "I305", f"a wait of {seconds:g} s is left out", "write a time between zero and four months"
        )
    m.stop_advance()
    if not seconds:  # BREAK, waitEndMove(), WAIT SEC 0: all that it does is to end the move before
        m.recorder.end_exactly()
    m.recorder.wait(m.frame.job.source, s.line, seconds)


def wait(m: Machine, s: st.Wait) -> None:
    """Waits for a condition: as long as olp.toml says, at most its own limit."""
    m.stop_advance()
    limit = None if s.timeout is None else quantity(m, s.timeout)
    if limit is not None and not 0.0 <= limit <= _LONGEST:
        raise StatementError(
            "I305", f"a limit of {limit:g} s is left out", "write a time between zero and four months"
        )
    seconds = _fixed(m, s.condition, limit)
    if seconds is None and limit is not None and m.made_up is not None and m.made_up.polls:
        met = test(m, s.condition) or flow.ends_in_time(m, s)
        seconds = 0.0 if met else limit  # as a loop that asks would find it
        m.timed_out = seconds > 0.0
    elif seconds is None:
        seconds = expected_wait(m, [key_of(m, signal) for signal in signals_of(s.condition)])
        m.timed_out = limit is not None and seconds >= limit > 0.0
        if limit is not None and m.timed_out:
            seconds = limit
        else:
            impose(m, s.condition)
    else:
        m.timed_out = limit is not None and seconds >= limit and not test(m, s.condition)
    if _begins_an_edge(m, s):
        seconds = 0.0  # olp.toml says how long the whole line waits
    keys = dict.fromkeys(signal_name(key_of(m, signal)) for signal in signals_of(s.condition))
    m.recorder.wait(m.frame.job.source, s.line, seconds, Event("wait", tuple(sorted(keys)), math.nan))


def _begins_an_edge(m: Machine, s: st.Wait) -> bool:
    """Whether the same line waits for the same signals once more: for an edge, both of its levels are waited for."""
    body, at = m.frame.job.body, m.frame.pc
    after = body[at] if at < len(body) else None
    return (
        isinstance(after, st.Wait)
        and after.line == s.line
        and set(signals_of(after.condition)) == set(signals_of(s.condition))
    )


def _fixed(m: Machine, condition: ex.Expression, limit: float | None) -> float | None:
    """The duration [s] where everything in the condition is known; None where an input still has to come."""
    signals = signals_of(condition)
    if not all(_is_known(m, key_of(m, signal)) for signal in signals):
        return None
    if not holds(m, condition):
        if limit is not None:
            return limit
        m.assume(f"the wait for {spell(condition)} ends, although nothing here makes it true")
        return default_wait(m)
    # An input that olp.toml gives is on when the wait begins, unless its [waits] say how long it takes.
    times = [m.assumptions.waits[key] for s in signals if (key := key_of(m, s)) in m.assumptions.waits]
    seconds = max(times, default=0.0)
    return seconds if limit is None else min(seconds, limit)


def _is_known(m: Machine, key: SignalKey) -> bool:
    """Whether olp.toml gives the signal, or the program has set it itself."""
    return key in m.assumptions.inputs or key in m.memory.changed


def pause(m: Machine, s: st.Pause) -> None:
    if s.condition is not None and not test(m, s.condition):
        return
    seconds = m.assumptions.pause
    if seconds is None:
        seconds = 0.0
        m.assume("the operator restarts the program at once")
    m.recorder.end_exactly()  # no controller knows where a stopped program goes on
    m.recorder.wait(m.frame.job.source, s.line, seconds)


def set_output(m: Machine, s: st.SetOutput) -> None:
    if s.signal.bus in PERIPHERY:
        m.stop_advance()
    switch(m, s.line, s.signal, s.value)


def switch(
    m: Machine, line: int, signal: ex.Signal, value: ex.Expression, metres: float = 0.0, seconds: float = 0.0
) -> None:
    """Sets an output, so far behind where the step stands."""
    state = evaluate(m, value)
    if isinstance(state, (int, float)) and signal.bus == "out":
        state = state != 0  # any other number than 0 switches it on
    write_signal(m, signal, state)
    event = Event("set", (signal_name(key_of(m, signal)),), as_number(state), metres, seconds)
    m.recorder.signal(m.frame.job.source, line, event=event)


def act(m: Machine, s: st.Move, at_start: bool) -> None:
    """Sets the outputs that a move switches on its way, near its start or near its end."""
    for signal, value, metres, seconds, above in moves.outputs_on_the_way(m, s, at_start):
        switch(m, s.line - above, signal, value, metres, seconds)


def pulse_output(m: Machine, s: st.PulseOutput) -> None:
    if s.condition is None or test(m, s.condition):
        m.stop_advance()
        seconds = math.nan if s.duration is None else quantity(m, s.duration)
        event = Event("pulse", (signal_name(key_of(m, s.signal)),), seconds)
        m.recorder.signal(m.frame.job.source, s.line, event=event)


def as_number(value: Value) -> float:
    """What a signal is set to; nan for what is no number."""
    return float(value) if isinstance(value, (bool, int, float)) else math.nan


def message(m: Machine, s: st.Message) -> None:
    m.recorder.signal(m.frame.job.source, s.line)


def process(m: Machine, s: st.Process) -> int | None:
    if s.name.casefold() in ENDS_PROGRAM:
        m.stop(f"line {s.line} ends the program")
        return OTHER_FRAME
    if s.name == "continue":
        m.continued = (m.frame, following(m))
        return None
    if s.name.casefold() in m.conventions.standing_processes:
        m.recorder.end_exactly()
        return None
    if s.name == "stop-handler":
        return None  # it acts when the arm has been stopped
    if moves.define_trigger(m, s):
        return None
    seconds = m.assumptions.process.get(s.name.lower())
    if seconds is None and s.name == "interrupt":
        m.assume_once(s.name, f"{s.name} takes no time and changes no variable")
        return None
    if seconds is None:
        seconds = 0.0
        manner = m.conventions.manner_processes.get(s.name.casefold())
        says = f"{s.name} takes no time and changes no variable"
        m.assume_once(s.name, says if manner is None else f"{s.name}, {manner}, is not modelled")
    m.recorder.signal(m.frame.job.source, s.line, seconds)
    return None


def following(m: Machine) -> int:
    """The index of the next statement that does anything."""
    body, at = m.frame.job.body, m.frame.pc
    while at < len(body) and isinstance(body[at], st.Comment):
        at += 1
    return at


def opaque(m: Machine, s: st.Opaque) -> None:
    m.assume(f"this statement is not known and taken to do nothing: {s.text.strip()[:40]}")


def start_task(m: Machine, s: st.StartTask) -> None:
    if s.condition is None or test(m, s.condition):
        m.assume(f"{s.routine} runs in a task of its own: its moves and times are not in this plan")


def wait_task(m: Machine, s: st.WaitTask) -> None:
    m.assume(f"the wait for task {s.task} lasts 0 s")
    m.recorder.wait(m.frame.job.source, s.line, 0.0)


def synchronise(m: Machine, s: st.Synchronise) -> None:
    m.assume(f"the other tasks are taken to be at point {spell(s.number)} already")
    m.recorder.wait(m.frame.job.source, s.line, 0.0)


# --- System ---
# Values that only the controller knows: where the arm is, what a call returned.


def read_system_value(m: Machine, value: ex.SystemValue) -> Value:
    """The value; one that nobody can know is taken as 0, which is reported."""
    if value.name == "returned":
        if m.returned is None:
            m.assume("nothing was returned before: the returned value is taken as 0")
            return 0
        return m.returned
    if value.name == "position-pulse":
        return _position(m, pulses=True)
    if value.name == "position-pose":
        return _position(m, pulses=False)
    if value.name == "timed-out":
        return m.timed_out
    if value.name in ("current-pose", "current-joints"):
        from olp.runtime.places import current

        return current(m, joints=value.name == "current-joints")
    if value.name == "current-frame":
        return pose_value(frame_pose(m, ex.FrameRef(ACTIVE)))
    if value.name == "current-tool":
        return pose_value(m.world.cell.tool_pose(m.active_tool))
    told = None if m.made_up is None else m.made_up.state(value.name)
    if told is not None:
        return told
    if value.name in ("manual-reduced", "manual-full"):
        m.assume("the mode is taken to be automatic")
        return False
    if value.name == "automatic":
        modes = ("manual-reduced", "manual-full")
        return not any(read_system_value(m, ex.SystemValue(mode)) for mode in modes)
    if value.name in terminology.STATES:
        m.assume(f"{terminology.STATES[value.name]}: taken not to be so")
        return False
    if value.name == "timer":
        m.assume(f"the clock {value.index} is taken to stand at 0")
        return 0
    m.assume(f"system value {value.name} {value.index} is taken as 0")
    return 0


def _position(m: Machine, pulses: bool) -> SystemPosition:
    arm = role(m, 0, ex.Store.ROBOT)
    value = here(m, arm)
    robot = as_pulses(m, arm, value) if pulses else as_pose(m, arm, value, ex.FrameRef("base"))
    parts: list[tuple[ex.Store, PositionValue]] = [(ex.Store.ROBOT, robot)]
    for store in (ex.Store.BASE, ex.Store.STATION):
        for (_, known), mechanism in m.frame.job.roles.items():
            if known is store and m.recorder.at[mechanism] != NOWHERE:
                parts.append((store, here(m, mechanism)))
                break
    return SystemPosition(tuple(parts))


# --- Machine ---
# Runs statement after statement until the program, a limit or a loop without end stops it.

# A handler gives the index of the next statement, OTHER_FRAME after a call or return, or None to go on.
# Comments, disabled statements, reference points and block ends do nothing and have none.
HANDLERS: Final[Mapping[type, Callable[[Machine, Any], int | None]]] = {
    st.Move: moves.move,
    st.SetSpeed: poses.set_speed,
    st.SetAcceleration: poses.set_acceleration,
    st.SetBlend: poses.set_blend,
    st.SetTool: poses.set_tool,
    st.SetFrame: poses.set_frame,
    st.SetOverride: poses.set_override,
    st.ObeyFlags: poses.obey_flags,
    st.Declare: declare,
    st.Assign: data.assign,
    st.Update: data.update,
    st.Clear: data.clear,
    st.ReadInput: data.read_input,
    st.DefineFrame: data.define_frame,
    st.ShiftOn: data.shift_on,
    st.ShiftOff: data.shift_off,
    st.ExternalTool: data.external_tool,
    st.Dwell: dwell,
    st.Wait: wait,
    st.Pause: pause,
    st.SetOutput: set_output,
    st.PulseOutput: pulse_output,
    st.Message: message,
    st.Process: process,
    st.Opaque: opaque,
    st.StartTask: start_task,
    st.WaitTask: wait_task,
    st.Synchronise: synchronise,
    st.Label: flow.label,
    st.Jump: flow.jump,
    st.If: flow.if_,
    st.ElseIf: flow.end_of_branch,
    st.Else: flow.end_of_branch,
    st.While: flow.while_,
    st.EndWhile: flow.end_while,
    st.Repeat: flow.repeat,
    st.Until: flow.until,
    st.Break: flow.break_,
    st.Continue: flow.continue_,
    st.For: flow.for_,
    st.Next: flow.next_,
    st.Switch: flow.switch,
    st.Case: flow.end_of_branch,
    st.Default: flow.end_of_branch,
    st.Call: flow.call,
    st.Return: flow.return_,
    st.End: flow.end,
}


LIMIT: Final = "I108"  # of the finding that a run was not let go on


def execute(m: Machine) -> None:
    """Runs `m` to its end, or for as many statements as it is allowed."""
    while m.left and not m.ended and not m.stop_reason:
        _run_frame(m)
    if not m.left and not m.ended and not m.stop_reason:
        _report_limit(m)


def run_until(m: Machine, depth: int) -> None:
    """Runs the routine called last until no more than `depth` callers wait: a call inside an expression."""
    while m.left and len(m.frames) > depth and not m.ended and not m.stop_reason:
        _run_frame(m)


def _run_frame(m: Machine) -> None:
    """Runs the current routine until it calls, returns or stops."""
    handlers = HANDLERS
    frame = m.frame
    body, pc = frame.job.body, frame.pc
    size = len(body)
    while pc < size:
        statement = body[pc]
        pc += 1
        handler = handlers.get(type(statement))
        if handler is None:
            continue
        if not m.left:
            return
        m.left -= 1
        frame.pc = pc
        try:
            following = handler(m, statement)
        except (StatementError, OlpError, OverflowError) as problem:
            _report(m, problem)
            if m.stop_reason:
                return
            continue
        if following is not None:
            if following == OTHER_FRAME or m.stop_reason:
                return
            pc = following
    try:
        flow.leave(m)
    except (StatementError, OlpError, OverflowError) as problem:
        _report(m, problem)


def _report(m: Machine, problem: StatementError | OlpError | OverflowError) -> None:
    """Keeps what went wrong, at the line of the current statement."""
    if isinstance(problem, OverflowError):
        problem = StatementError("I202", "a number is too large to compute with", "check the operands")
    if isinstance(problem, StatementError):
        if not isinstance(problem, EndedError):
            m.fault(problem, "" if "left out" in problem.message else "the statement is left out")
        return
    for finding in problem.diagnostics:
        m.fault(StatementError(finding.code, finding.message, finding.help, finding.severity))


def _report_limit(m: Machine) -> None:
    m.fault(
        StatementError(
            LIMIT,
            f"the run was stopped after {m.allowed} statements, here",
            "say in olp.toml what ends the loop, or allow more with --max-steps",
            Severity.WARNING,
        )
    )
    m.stop(f"stopped after {m.allowed} statements")


EVALUATORS: Final[Mapping[type, Callable[[Machine, Any], Value]]] = {
    **PLAIN,
    ex.Element: read_element,
    ex.Signal: read_signal,
    ex.SystemValue: read_system_value,
    ex.FrameRef: frame_value,
    ex.Binary: binary,
    ex.Function: call_function,
    ex.Named: lambda m, e: read_name(m, e.name),
    ex.Item: read_item,
    ex.Member: read_member,
    ex.PositionLiteral: lambda m, e: literal_position(e),
    ex.RecordLiteral: literal,
    ex.CallValue: flow.value_of_call,
}

OPERATIONS: Final = Operations(EVALUATORS, declare_all, data.store_value, run_until, act)


# --- Run ---
# Sets a machine up, runs it and makes the plan.


def run(
    program: Program,
    robot: str | Robot | None = None,
    *,
    assumptions: Assumptions | None = None,
    folder: str | os.PathLike[str] | None = None,
    max_steps: int | None = None,
    cycles: int = 1,
    made_up: MadeUp | None = None,
    first_move: bool = False,
) -> Plan:
    """The plan of `program`: its first routine, run to the end.

    `robot`: library name, robot file or Robot of the first arm; else olp.toml or the controller's backup decide.
    `assumptions`: what the program cannot tell; the nearest olp.toml when None. `folder`: where called routines and
    controller files are; the program's own folder when None. `cycles`: passes of an endless main loop.
    `made_up`: values for what nothing tells, in place of zeros. `first_move`: where no move is made with these, others
    are tried.
    `max_steps`: statements after which the run is stopped (None: 200,000 in each cycle, and ten times what is read).
    Raises OlpError for a robot that does not exist; everything else is in `Plan.diagnostics`.
    """
    place = Path(folder) if folder is not None else _folder_of(program)
    if assumptions is None:
        path = nearest_assumptions(place) if place is not None else None
        assumptions = load_assumptions(path) if path is not None else Assumptions()
    limits = (cycles, max_steps)
    m = _machine(program, robot, assumptions, place, limits, made_up)
    execute(m)
    if first_move and made_up is None and not m.moves and not m.reached_move:
        again = partial(_machine, program, robot, assumptions, place)
        m = _with_first_move(m, again, limits)
    return _finish(m)


def _machine(
    program: Program,
    robot: str | Robot | None,
    assumptions: Assumptions,
    place: Path | None,
    limits: tuple[int, int | None],
    made_up: MadeUp | None,
) -> Machine:
    """What is ready to run the program. `limits`: cycles, and statements if they are bounded."""
    jobs = Jobs(program, place)
    main = jobs.main()
    if main is None:
        nothing = error(
            "I101", "the file holds no routine", file=program.path, help="give a file with a job in it"
        )
        found = errors(program.diagnostics)
        raise OlpError(*found) if found else NoSuchRoutineError(nothing)
    world = build_world(robot, assumptions, place)
    recorder = Recorder(world.cell, tuple(jobs.sources))
    cycles, most = limits
    m = Machine(
        OPERATIONS, recorder, world, Memory(), jobs, assumptions, cycles, CallFrame(main), first_job=main.key
    )
    if program.vendor in vendor_names():
        m.known_routines = part_of(program.vendor, "known_routines") or {}
        m.law = find_vendor(program.vendor).blending
        m.conventions = find_vendor(program.vendor).conventions
        world.cell.frame_files = m.conventions.frame_files
        m.case_sensitive = find_vendor(program.vendor).case_sensitive
        m.advance_stops = find_vendor(program.vendor).advance_stops
    if made_up is not None:
        m.made_up = made_up
        world.cell.made_up = made_up.pose
    if isinstance(made_up, TakenValues):
        made_up.place_now = lambda: AskedAt(m.frame.job.source, m.line)
    m.allow(STEPS * cycles if most is None else most)
    m.allows_more = most is None
    m.load(main)
    if says := guessed(program):
        m.assume(says, main.routine.line)
    set_initial_values(m)
    bind_uncalled(m, main.routine.parameters)
    return m


def _with_first_move(
    m: Machine, again: Callable[[tuple[int, int | None], MadeUp], Machine], limits: tuple[int, int | None]
) -> Machine:
    """The run of a program that has ended before its first move, with values with which it makes it.

    `m` itself, with a finding, where no such values are found or none may be taken.
    """
    main = m.jobs.main()
    bodies = [] if main is None else [main.body, *flow.called_bodies(m.jobs, main)]
    if not holds_move(bodies):
        return m

    def attempt(given: Given) -> Try:
        taken = TakenValues(given=given)
        trial = again((limits[0], MOST_STATEMENTS), taken)
        trial.seeks_move = True
        try:
            execute(trial)
        except MoveReachedError:
            return Try(True, taken.kinds, trial.allowed - trial.left)
        return Try(False, taken.kinds, trial.allowed - trial.left)

    first = attempt({})
    if not first.asked:
        return m
    strict = "first-move" in m.assumptions.strict
    given = None if strict else values_that_move(attempt, first, numbers_compared(bodies))
    if given is None:
        says = "say in olp.toml what it asks for: " + ", ".join(
            map(spelled, list(first.asked)[-_MOST_NAMED:])
        )
        found = error if strict else warning
        ends = "the run ends before the first move of the program"
        m.report(found("I118", ends, file=m.jobs.program.path, help=says))
        return m
    taken = TakenValues(given=given)
    best = again(limits, taken)
    best.unsure = True
    execute(best)
    for thing, value in given.items():
        best.report(_is_taken(best, thing, value, taken.first_asked[thing]))
    return best


def _is_taken(m: Machine, thing: UnknownThing, value: float | bool, place: AskedAt) -> Diagnostic:
    source = m.jobs.sources[place.source]
    text = source.line(place.line)
    return warning(
        "I118",
        f"{spelled(thing)} is taken as {shown(thing, value)}: else the run ends before its first move",
        Span(place.line, 1, len(text.rstrip()) + 1),
        file=source.path,
        help=where_told(thing),
        source_line=text,
    )


def _folder_of(program: Program) -> Path | None:
    if not program.path:
        return None
    path = Path(program.path)
    return path.parent if path.is_file() else None


def _finish(m: Machine) -> Plan:
    m.hand_over_assumptions()
    made_up = m.made_up
    # Poses that are made up are compared as poses, and nobody asks for the axes there.
    plan = m.recorder.finish((), m.stop_reason, branches=made_up is None or not made_up.seed)
    found = [*m.jobs.program.diagnostics, *m.jobs.found, *m.world.diagnostics]
    told = {(d.file, d.line) for d in found if d.is_error}
    broken = {file for file, _ in told}
    found += [d for d in m.diagnostics() if not _is_told(d, told, broken)]
    found += missing_robots(m, plan)
    length = len(plan)
    return replace(
        plan,
        diagnostics=tuple(dict.fromkeys(found)),
        settings=m.assumptions.motion,
        zone_law=m.law if m.law != "radius" else plan.zone_law,
        calls=tuple(
            span if span.stop > span.start or not m.frames else span._replace(stop=length) for span in m.spans
        ),
    )


def _is_told(finding: Diagnostic, told: set[tuple[str, int]], broken: set[str]) -> bool:
    """Whether the reader has said the same: of that line, or of the row that should have taught the point."""
    return (finding.file, finding.line) in told or (finding.code == "I206" and finding.file in broken)


# --- Initial values ---
# What the variables hold, and where the arms stand, when a run begins: VAR.DAT, then olp.toml, which wins.


def set_initial_values(m: Machine) -> None:
    """Fills the memory. Positions in the headers of routines, loaded before, win over VAR.DAT."""
    values = m.memory.values
    saved = m.world.backup.variables if m.world.backup is not None else None
    if saved is not None:
        for store, letters in SAVED_NUMBERS.items():
            for index, value in getattr(saved, letters).items():
                values[(store, index)] = value
        for store, letters in SAVED_POSITIONS.items():
            for index, position in getattr(saved, letters).items():
                values.setdefault((store, index), PositionValue(*saved_position(position)))
    for key, given in m.assumptions.variables.items():
        values[key] = PositionValue(*given) if isinstance(given, tuple) else given
    for name, start in m.assumptions.start.items():
        mechanism = m.add_mechanism(name)
        m.recorder.at[mechanism] = m.recorder.position(mechanism, start.state, start.values)


# --- Missing robots ---
# What to say when a plan misses a robot, or asks one for what it cannot do.


_MOST_NAMED = 6
_UNREACHED = "check the robot, the tool and the user frame that the points are written in"


def missing_robots(m: Machine, plan: Plan) -> list[Diagnostic]:
    """One finding per thing that leaves positions unknown, with what would help."""
    found = [_finding(m, gap) for gap in m.world.cell.gaps.values() if gap.unusable]
    return found + _moves_without_axes(m, plan)


def _finding(m: Machine, gap: Gap) -> Diagnostic:
    file = m.jobs.program.path
    name = gap.key.removeprefix(ROBOT_GAP)
    if name == gap.key:
        return error(
            "I002", gap.says, file=file, help="use a robot file that has it, or teach the points as poses"
        )
    return error("I001", gap.says, file=file, help=f"{_remedy(m, name)}; {_candidates(m, name)}")


def _remedy(m: Machine, name: str) -> str:
    """How to say which robot the mechanism `name` is: the command line names the first arm only."""
    first = next((one.name for one in m.world.mechanisms if one.is_robot), name)
    if name == first:
        return 'say which one it is: --robot maker/model, or robot = "maker/model" in olp.toml'
    return f'say which one it is: {name} = "maker/model" under [robots] in olp.toml'


def _candidates(m: Machine, name: str) -> str:
    """The library robots whose soft limits hold all pulses of the mechanism `name`."""
    for index, mechanism in enumerate(m.world.mechanisms):
        span = m.recorder.pulse_span(index) if mechanism.name == name else None
        if span is None:
            continue
        try:
            fits = candidates_for_pulses(*(list(map(float, edge)) for edge in span))
        except OlpError:
            return "olp robots lists them"
        names = [fit.robot.name for fit in fits]
        if not names:
            return f"no library robot with {len(span[0])} axes reaches all of the pulses"
        more = f" and {len(names) - _MOST_NAMED} more" if len(names) > _MOST_NAMED else ""
        return f"the pulses fit {', '.join(names[:_MOST_NAMED])}{more}"
    return "olp robots lists them"


def _moves_without_axes(m: Machine, plan: Plan) -> list[Diagnostic]:
    """Moves to poses out of reach; without a robot joint moves to poses, which cannot be timed."""
    moves = plan.moves
    joint = moves.path == PATHS.index(st.Path.JOINT)
    findings: list[Diagnostic] = []
    for index, mechanism in enumerate(m.world.mechanisms):
        robot = mechanism.robot
        if not mechanism.is_robot or (robot is not None and robot.geometry is None):
            continue
        if f"{ROBOT_GAP}{mechanism.name}" in m.world.cell.gaps:  # told already
            continue
        rows = np.nonzero((moves.mechanism == index) & (joint if robot is None else True))[0]
        width = len(robot.axes) if robot is not None else 6
        target = moves.target[rows]
        lost = np.isnan(plan.positions.axes[target, :width]).any(axis=1)
        lost &= ~np.isnan(plan.positions.position[target, 0])
        if robot is None:
            says = f"this joint move to a Cartesian point needs the robot {mechanism.name}"
            findings += of_rows(plan, rows[lost], error, "I003", says, _remedy(m, mechanism.name))
        else:
            says = f"{mechanism.name} does not reach the target of this move"
            findings += of_rows(plan, rows[lost], warning, "I004", says, _UNREACHED)
    return findings
