"""Runs statement after statement until the program, a limit or a loop without end stops it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, Final

from olp.core.diagnostic import OlpError, Severity
from olp.ir.expressions import (
    Binary,
    CallValue,
    Element,
    FrameRef,
    Function,
    Item,
    Member,
    Named,
    PositionLiteral,
    RecordLiteral,
    Signal,
    SystemValue,
)
from olp.ir.program import (
    Assign,
    Break,
    Call,
    Case,
    Clear,
    Continue,
    Declare,
    Default,
    DefineFrame,
    Dwell,
    Else,
    ElseIf,
    End,
    EndWhile,
    ExternalTool,
    For,
    If,
    Jump,
    Label,
    Message,
    Move,
    Next,
    ObeyFlags,
    Opaque,
    Pause,
    Process,
    PulseOutput,
    ReadInput,
    Repeat,
    Return,
    SetAcceleration,
    SetBlend,
    SetFrame,
    SetOutput,
    SetOverride,
    SetSpeed,
    SetTool,
    ShiftOff,
    ShiftOn,
    StartTask,
    Switch,
    Synchronise,
    Until,
    Update,
    Wait,
    WaitTask,
    While,
)
from olp.runtime import data, flow, modal, moves, scope, speeds, waiting
from olp.runtime.computing import call_function
from olp.runtime.elements import binary, read_element
from olp.runtime.evaluate import PLAIN
from olp.runtime.functions import frame_value
from olp.runtime.memory import Value
from olp.runtime.scope import declare_all, literal, read_name
from olp.runtime.signals import read_signal
from olp.runtime.state import OTHER_FRAME, EndedError, Machine, Operations, StatementError
from olp.runtime.structures import literal_position, read_item, read_member
from olp.runtime.system import read_system_value

# A handler gives the index of the next statement, OTHER_FRAME after a call or return, or None to go on.
# Comments, disabled statements, reference points and block ends do nothing and have none.
HANDLERS: Final[Mapping[type, Callable[[Machine, Any], int | None]]] = {
    Move: moves.move,
    SetSpeed: speeds.set_speed,
    SetAcceleration: modal.set_acceleration,
    SetBlend: modal.set_blend,
    SetTool: modal.set_tool,
    SetFrame: modal.set_frame,
    SetOverride: modal.set_override,
    ObeyFlags: modal.obey_flags,
    Declare: scope.declare,
    Assign: data.assign,
    Update: data.update,
    Clear: data.clear,
    ReadInput: data.read_input,
    DefineFrame: data.define_frame,
    ShiftOn: data.shift_on,
    ShiftOff: data.shift_off,
    ExternalTool: data.external_tool,
    Dwell: waiting.dwell,
    Wait: waiting.wait,
    Pause: waiting.pause,
    SetOutput: waiting.set_output,
    PulseOutput: waiting.pulse_output,
    Message: waiting.message,
    Process: waiting.process,
    Opaque: waiting.opaque,
    StartTask: waiting.start_task,
    WaitTask: waiting.wait_task,
    Synchronise: waiting.synchronise,
    Label: flow.label,
    Jump: flow.jump,
    If: flow.if_,
    ElseIf: flow.end_of_branch,
    Else: flow.end_of_branch,
    While: flow.while_,
    EndWhile: flow.end_while,
    Repeat: flow.repeat,
    Until: flow.until,
    Break: flow.break_,
    Continue: flow.continue_,
    For: flow.for_,
    Next: flow.next_,
    Switch: flow.switch,
    Case: flow.end_of_branch,
    Default: flow.end_of_branch,
    Call: flow.call,
    Return: flow.return_,
    End: flow.end,
}


LIMIT: Final = "I108"  # of the finding that a run was not let go on


def execute(m: Machine, max_steps: int) -> None:
    """Runs `m` to its end, at most `max_steps` statements."""
    m.left = max_steps
    while m.left and not m.ended and not m.stop_reason:
        _run_frame(m)
    if not m.left and not m.ended and not m.stop_reason:
        _report_limit(m, max_steps)


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


def _report_limit(m: Machine, max_steps: int) -> None:
    m.fault(
        StatementError(
            LIMIT,
            f"the run was stopped after {max_steps} statements, here",
            "say in olp.toml what ends the loop, or allow more with --max-steps",
            Severity.WARNING,
        )
    )
    m.stop(f"stopped after {max_steps} statements")


EVALUATORS: Final[Mapping[type, Callable[[Machine, Any], Value]]] = {
    **PLAIN,
    Element: read_element,
    Signal: read_signal,
    SystemValue: read_system_value,
    FrameRef: frame_value,
    Binary: binary,
    Function: call_function,
    Named: lambda m, e: read_name(m, e.name),
    Item: read_item,
    Member: read_member,
    PositionLiteral: lambda m, e: literal_position(e),
    RecordLiteral: literal,
    CallValue: flow.value_of_call,
}

OPERATIONS: Final = Operations(EVALUATORS, declare_all, data.store_value, run_until)
