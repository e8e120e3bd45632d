"""Runs statement after statement until the program, a limit or a loop without end stops it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from olp.interpreter import moves, waiting
from olp.interpreter.state import OTHER_FRAME, Machine, StatementError
from olp.program import (
    Dwell,
    Move,
    PulseOutput,
    SetOutput,
    SetSpeed,
)


def execute(m: Machine, max_steps: int) -> None:
    """Runs `m` to its end, at most `max_steps` statements."""
    left = max_steps
    handlers = HANDLERS
    while m.frames is not None:
        frame, body = m.frame, m.frame.job.body
        size, pc = len(body), m.frame.pc
        while pc < size and left:
            left -= 1
            statement = body[pc]
            pc += 1
            handler = handlers.get(type(statement))
            if handler is None:
                continue
            frame.pc = pc
            try:
                following = handler(m, statement)
            except StatementError as fault:
                m.fault(fault)
                continue
            if following is not None:
                if following == OTHER_FRAME:
                    break
                pc = following
        else:
            return
        if m.stop_reason:
            return


HANDLERS: Mapping[type, Any] = {
    Move: moves.move,
    SetSpeed: moves.set_speed,
    Dwell: waiting.dwell,
    SetOutput: waiting.signal_step,
    PulseOutput: waiting.signal_step,
}
