"""Statements that take time or set outputs: dwell, wait, pause, tasks, process instructions, messages."""

from __future__ import annotations

from olp.interpreter.evaluate import quantity
from olp.interpreter.state import Machine, StatementError
from olp.program import Dwell, PulseOutput, SetOutput


def dwell(m: Machine, s: Dwell) -> None:
    seconds = quantity(m, s.duration)
    if seconds < 0.0:
        raise StatementError("I305", f"a wait of {seconds:g} s is left out", "write a time of zero or more")
    m.recorder.wait(m.frame.job.source, s.line, seconds)


def signal_step(m: Machine, s: SetOutput | PulseOutput) -> None:
    m.recorder.signal(m.frame.job.source, s.line)
