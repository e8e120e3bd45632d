"""Signals: what the program set itself, what olp.toml says of the rest, and what is assumed otherwise."""

from __future__ import annotations

from collections.abc import Sequence

from olp.ir.expressions import Binary, Compare, Expression, Logic, Number, Signal, SignalState, Text, Unary
from olp.runtime.assumptions import NAMED_SIGNAL, SignalKey, holds_number, signal_name
from olp.runtime.evaluate import evaluate, whole
from olp.runtime.memory import Value
from olp.runtime.state import Machine

_HALF = 8  # bits in the low and in the high half of a register
# What stops an advance run that waits for the arm; flags and registers of the program do not.
PERIPHERY = frozenset({"in", "out", "analog-in", "analog-out", "in-group", "out-group"})


def key_of(m: Machine, signal: Signal) -> SignalKey:
    if type(signal.index) is Text:
        return SignalKey(NAMED_SIGNAL, signal.index.value.casefold())
    if type(signal.index) is not Number and isinstance(called := evaluate(m, signal.index), str):
        return SignalKey(NAMED_SIGNAL, called.casefold())  # a variable that stands for a signal of that name
    return counted(m, signal.bus, whole(m, signal.index))


def counted(m: Machine, bus: str, number: int) -> SignalKey:
    """The signal of a number, where one number counts those of several buses."""
    for first, own in m.conventions.counted_signals.get(bus, ()):
        if number >= first:
            return SignalKey(own, number - first)
    return SignalKey(bus, number)


def read_signal(m: Machine, signal: Signal) -> Value:
    """The signal's value: a bool, or a number for groups and registers."""
    if signal.bus in PERIPHERY:
        m.stop_advance()
    is_number = holds_number(signal.bus)
    value = _raw(m, key_of(m, signal), is_number)
    if signal.part:
        value = value >> _HALF & 0xFF if signal.part == "high" else value & 0xFF
    return value if is_number or value not in (0, 1) else bool(value)


def _raw(m: Machine, key: SignalKey, is_number: bool) -> int:
    given = m.assumptions.inputs.get(key)
    if given is not None:
        visit = m.visits.get(key, 0)
        m.visits[key] = visit + 1
        if visit < len(given) - 1:
            m.memory.stamp += 1
            m.listed = m.memory.stamp  # the next read may differ: a loop that waits for it makes progress
        return given[min(visit, len(given) - 1)]
    m.reads += 1
    m.inputs_read[key] = m.reads
    value = m.memory.signals.get(key)
    if value is None and m.made_up is not None:
        value = m.made_up.signal(key, is_number)
        if value is not None:
            m.memory.signals[key] = m.signals_made_up[key] = value
    if value is None:
        shown = "0" if holds_number(key.bus) else "OFF"
        m.assume(f"{signal_name(key)} is taken as {shown}")
        return 0
    return value


def write_signal(m: Machine, signal: Signal, value: Value) -> None:
    """Sets an output or register."""
    number = value if isinstance(value, (int, float)) else 0
    key = key_of(m, signal)
    new = int(number)
    if signal.part:
        old = m.memory.signals.get(key, 0)
        new = (old & 0xFF) | (new & 0xFF) << _HALF if signal.part == "high" else (old & 0xFF00) | (new & 0xFF)
    if m.memory.signals.get(key) != new:
        m.memory.stamp += 1
        m.memory.changed[key] = m.memory.stamp
    m.memory.signals[key] = new


def signals_of(condition: Expression) -> list[Signal]:
    """All signals in a condition, in order of writing."""
    if isinstance(condition, Signal):
        return [condition]
    if isinstance(condition, (Compare, Binary)):
        return signals_of(condition.left) + signals_of(condition.right)
    if isinstance(condition, Unary):
        return signals_of(condition.operand)
    if isinstance(condition, Logic):
        parts = [condition.first, *(part for _, part in condition.rest)]
        return [signal for part in parts for signal in signals_of(part)]
    return []


def impose(m: Machine, condition: Expression) -> None:
    """Makes a condition `signal = value`, `signal` or `not signal` (also several joined by and) true from here on."""
    if isinstance(condition, Signal):
        condition = Compare("=", condition, SignalState(True))
    elif (
        isinstance(condition, Unary) and condition.operator == "not" and isinstance(condition.operand, Signal)
    ):
        condition = Compare("=", condition.operand, SignalState(False))
    if isinstance(condition, Logic) and all(word == "and" for word, _ in condition.rest):
        impose(m, condition.first)
        for _, part in condition.rest:
            impose(m, part)
    elif isinstance(condition, Compare) and condition.operator == "=" and isinstance(condition.left, Signal):
        value = evaluate(m, condition.right)
        if isinstance(value, (bool, int)) and key_of(m, condition.left) not in m.assumptions.inputs:
            m.memory.signals[key_of(m, condition.left)] = int(value)


def expected_wait(m: Machine, keys: Sequence[SignalKey]) -> float:
    """[s] until signals come that are waited for."""
    times = [m.assumptions.waits[key] for key in keys if key in m.assumptions.waits]
    if times:
        return max(times)
    seconds = default_wait(m)
    names = ", ".join(dict.fromkeys(signal_name(key) for key in keys))
    m.assume(f"the wait for {names} lasts {seconds:g} s")
    return seconds


def default_wait(m: Machine) -> float:
    """[s] of a wait of which olp.toml says nothing."""
    given = m.assumptions.default_wait
    return 0.0 if given is None else given


def flip(m: Machine, key: SignalKey) -> str:
    """Turns an input over, and says so."""
    new = 0 if m.memory.signals.get(key, 0) else 1
    m.memory.signals[key] = new
    shown = str(new) if holds_number(key.bus) else ("ON" if new else "OFF")
    return f"{signal_name(key)} is taken to change to {shown}"
