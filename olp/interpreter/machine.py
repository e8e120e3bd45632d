"""Runs statement after statement until the program, a limit or a loop without end stops it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, Final

from olp.diagnostic import OlpError, Severity
from olp.interpreter import data, flow, modal, moves, scope, speeds, waiting
from olp.interpreter.state import OTHER_FRAME, EndedError, Machine, StatementError
from olp.program import (
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
            m.fault(problem)
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
