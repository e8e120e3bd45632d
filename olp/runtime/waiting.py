"""Statements that take time or set outputs: dwell, wait, pause, tasks, process instructions, messages."""

from __future__ import annotations

import math

from olp.ir.expressions import Expression
from olp.ir.program import (
    Comment,
    Dwell,
    Message,
    Opaque,
    Pause,
    Process,
    PulseOutput,
    SetOutput,
    StartTask,
    Synchronise,
    Wait,
    WaitTask,
)
from olp.runtime.assumptions import SignalKey, signal_name
from olp.runtime.evaluate import evaluate, holds, quantity
from olp.runtime.flow import test
from olp.runtime.memory import Value
from olp.runtime.plan import Event
from olp.runtime.signals import PERIPHERY, impose, key_of, signals_of, write_signal
from olp.runtime.spelling import spell
from olp.runtime.state import Machine, StatementError

_LONGEST = 1e7  # [s], four months


def dwell(m: Machine, s: Dwell) -> None:
    seconds = quantity(m, s.duration)
    if not 0.0 <= seconds <= _LONGEST:
        raise StatementError(
            "I305", f"a wait of {seconds:g} s is left out", "write a time between zero and four months"
        )
    m.stop_advance()
    m.recorder.wait(m.frame.job.source, s.line, seconds)


def wait(m: Machine, s: Wait) -> None:
    """Waits for a condition: as long as olp.toml says, at most its own limit."""
    m.stop_advance()
    limit = None if s.timeout is None else quantity(m, s.timeout)
    if limit is not None and not 0.0 <= limit <= _LONGEST:
        raise StatementError(
            "I305", f"a limit of {limit:g} s is left out", "write a time between zero and four months"
        )
    seconds = _fixed(m, s.condition, limit)
    if seconds is None:
        seconds = _expected(m, s.condition)
        m.timed_out = limit is not None and seconds >= limit > 0.0
        if limit is not None and m.timed_out:
            seconds = limit
        else:
            impose(m, s.condition)
    else:
        m.timed_out = limit is not None and seconds >= limit and not test(m, s.condition)
    keys = dict.fromkeys(signal_name(key_of(m, signal)) for signal in signals_of(s.condition))
    m.recorder.wait(m.frame.job.source, s.line, seconds, Event("wait", tuple(sorted(keys)), math.nan))


def _fixed(m: Machine, condition: Expression, limit: float | None) -> float | None:
    """The duration [s] where everything in the condition is known; None where an input still has to come."""
    signals = signals_of(condition)
    if not all(_is_known(m, key_of(m, signal)) for signal in signals):
        return None
    if not holds(m, condition):
        if limit is not None:
            return limit
        m.assume(f"the wait for {spell(condition)} is taken to end although nothing here makes it true")
        return _default(m)
    # An input that olp.toml gives is on when the wait begins, unless its [waits] say how long it takes.
    times = [m.assumptions.waits[key] for s in signals if (key := key_of(m, s)) in m.assumptions.waits]
    seconds = max(times, default=0.0)
    return seconds if limit is None else min(seconds, limit)


def _is_known(m: Machine, key: SignalKey) -> bool:
    """Whether olp.toml gives the signal, or the program has set it itself."""
    return key in m.assumptions.inputs or key in m.memory.changed


def _expected(m: Machine, condition: Expression) -> float:
    """The duration [s] until the signals come."""
    keys = [key_of(m, signal) for signal in signals_of(condition)]
    times = [m.assumptions.waits[key] for key in keys if key in m.assumptions.waits]
    if times:
        return max(times)
    seconds = _default(m)
    names = ", ".join(dict.fromkeys(signal_name(key) for key in keys))
    m.assume(f"the wait for {names} is taken to last {seconds:g} s")
    return seconds


def _default(m: Machine) -> float:
    given = m.assumptions.default_wait
    return 0.0 if given is None else given


def pause(m: Machine, s: Pause) -> None:
    if s.condition is not None and not test(m, s.condition):
        return
    seconds = m.assumptions.pause
    if seconds is None:
        seconds = 0.0
        m.assume("the operator is taken to start the program again at once")
    m.stop_advance()
    m.recorder.wait(m.frame.job.source, s.line, seconds)


def set_output(m: Machine, s: SetOutput) -> None:
    if s.signal.bus in PERIPHERY:
        m.stop_advance()
    value = evaluate(m, s.value)
    write_signal(m, s.signal, value)
    event = Event("set", (signal_name(key_of(m, s.signal)),), as_number(value))
    m.recorder.signal(m.frame.job.source, s.line, event=event)


def pulse_output(m: Machine, s: PulseOutput) -> None:
    if s.condition is None or test(m, s.condition):
        m.stop_advance()
        seconds = math.nan if s.duration is None else quantity(m, s.duration)
        event = Event("pulse", (signal_name(key_of(m, s.signal)),), seconds)
        m.recorder.signal(m.frame.job.source, s.line, event=event)


def as_number(value: Value) -> float:
    """What a signal is set to; nan for what is no number."""
    return float(value) if isinstance(value, (bool, int, float)) else math.nan


def message(m: Machine, s: Message) -> None:
    m.recorder.signal(m.frame.job.source, s.line)


# Words that end the program as a whole, whoever called the routine: FANUC ABORT, RAPID EXIT, URScript halt.
_ENDINGS = frozenset({"abort", "exit", "halt"})


def process(m: Machine, s: Process) -> None:
    if s.name.lower() in _ENDINGS:
        m.recorder.signal(m.frame.job.source, s.line)
        m.stop(f"line {s.line} ends the program")
        return
    if s.name == "continue":
        m.continued = (m.frame, following(m))
        return
    seconds = m.assumptions.process.get(s.name.lower())
    if seconds is None:
        seconds = 0.0
        m.assume_once(s.name, f"{s.name} is taken to take no time and to change no variable")
    m.recorder.signal(m.frame.job.source, s.line, seconds)


def following(m: Machine) -> int:
    """The index of the next statement that does anything."""
    body, at = m.frame.job.body, m.frame.pc
    while at < len(body) and isinstance(body[at], Comment):
        at += 1
    return at


def opaque(m: Machine, s: Opaque) -> None:
    m.assume(f"this statement is not known and taken to do nothing: {s.text.strip()[:40]}")


def start_task(m: Machine, s: StartTask) -> None:
    if s.condition is None or test(m, s.condition):
        m.assume(f"{s.routine} runs in a task of its own: its moves and times are not in this plan")


def wait_task(m: Machine, s: WaitTask) -> None:
    m.assume(f"the wait for task {s.task} is taken to last 0 s")
    m.recorder.wait(m.frame.job.source, s.line, 0.0)


def synchronise(m: Machine, s: Synchronise) -> None:
    m.assume(f"the other tasks are taken to be at point {spell(s.number)} already")
    m.recorder.wait(m.frame.job.source, s.line, 0.0)
