"""Interrupts: what a CONNECT and the instruction that orders it mean together, in neutral words of a process.

ABB, technical reference manual, interrupts: CONNECT names the trap of an interrupt number, ISignalDI and ISignalDO
order it by the edge of a signal, once with `\\Single`; ISleep and IWatch switch it, IDelete ends it, IDisable and
IEnable put all of them off. What orders an interrupt in another way (ITimer, IPers …) stays as it is written.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Final

from olp.ir.expressions import CallValue, Compare, Expression, Named, Number, Signal, SignalState, Text
from olp.ir.program import Process, Program, Statement
from olp.languages.vendor import BEGINS, ONCE, WATCH
from olp.languages.vendors.rapid.syntax import RapidArgument

NAME: Final = "interrupt"
_WORD, _CALLED, _TRAP, _SIGNAL, _VALUE = "word", "name", "trap", "signal", "value"
_SIGNALS: Final = {"isignaldi": "in", "isignaldo": "out"}
_SWITCHES: Final = {"idelete": "off", "isleep": "off", "iwatch": "on", "idisable": "off", "ienable": "on"}
_FIRST: Final = 21  # of the numbers that conditions get


def connected(text: str, name: str, trap: str) -> Process:
    arguments = ((_WORD, Text("connect")), (_CALLED, Text(name)), (_TRAP, Text(trap)))
    return Process(0, NAME, (("", Text(text)), *arguments))


def ordered(text: str, word: str, given: list[RapidArgument]) -> Process:
    """An instruction as it is written, with what it says as further arguments where that is known."""
    plain = (("", Text(text)),)
    values = [one.value for one in given if one.value is not None]
    options = {option.name.lower() for one in given for option in one.options}
    named = values[-1].name if values and isinstance(values[-1], Named) else ""
    more: tuple[tuple[str, Expression], ...] = ((_WORD, Text(word)), (_CALLED, Text(named)))
    if word in _SIGNALS and len(values) == 3 and isinstance(values[0], (Named, Signal)):
        index = values[0].index if isinstance(values[0], Signal) else Text(values[0].name)
        signal, value = Signal(_SIGNALS[word], index), values[1]
        if not isinstance(value, Number) or value.value not in (0, 1) or options - {"single", "singlesafe"}:
            return Process(0, NAME, plain)
        more = (*more, (_SIGNAL, signal), (_VALUE, value), (ONCE, SignalState(bool(options))))
        return Process(0, NAME, (*plain, *more))
    return Process(0, NAME, (*plain, *more) if word in _SWITCHES else plain)


@dataclass(frozen=True, slots=True)
class _Interrupt:
    number: int
    trap: str
    once: bool


def with_watches(program: Program) -> Program:
    """The program with interrupts in neutral words: those that signals order and that have one trap."""
    found = _interrupts(program)
    if not found:
        return program
    routines = []
    for r in program.routines:
        begun: set[str] = set()
        routines.append(replace(r, body=tuple([_row(s, found, begun) for s in r.body])))
    return replace(program, routines=tuple(routines))


def _interrupts(program: Program) -> dict[str, _Interrupt]:
    """By name, case folded: those that signals alone order, always with the same trap, which no other one has."""
    traps: dict[str, set[str]] = {}
    orders: dict[str, list[Mapping[str, Expression]]] = {}
    known = {r.name.casefold(): r for r in program.routines}
    for s in program.statements():
        given = dict(s.arguments) if isinstance(s, Process) and s.name == NAME else {}
        name, trap = given.get(_CALLED), given.get(_TRAP)
        if isinstance(name, Text) and isinstance(trap, Text):
            traps.setdefault(name.value.casefold(), set()).add(trap.value)
        elif isinstance(name, Text) and _SIGNAL in given:
            orders.setdefault(name.value.casefold(), []).append(given)
    used = [called.casefold() for names in traps.values() for called in names]
    found: dict[str, _Interrupt] = {}
    for key, names in traps.items():
        own = min(names)
        if (
            len(names) > 1
            or used.count(own.casefold()) > 1
            or own.casefold() not in known
            or key not in orders
        ):
            continue
        once = {given[ONCE] == SignalState(True) for given in orders[key]}
        if len(once) == 1:
            found[key] = _Interrupt(_FIRST + len(found), own, once.pop())
    return found


def _row(s: Statement, found: Mapping[str, _Interrupt], begun: set[str]) -> Statement:
    """`begun`: interrupts that the routine has connected before."""
    given = dict(s.arguments) if isinstance(s, Process) and s.name == NAME else {}
    word, name = given.get(_WORD), given.get(_CALLED)
    if not isinstance(s, Process) or not isinstance(word, Text) or not isinstance(name, Text):
        return s
    text = given[""]
    assert isinstance(text, Text)
    one = found.get(name.value.casefold())
    if word.value in ("idisable", "ienable"):
        return _switch(s, text, _SWITCHES[word.value], 0)
    if one is None:
        return replace(s, arguments=(("", text),))
    if word.value == "connect":
        begun.add(name.value.casefold())
        return replace(s, arguments=(("", text), (WATCH, Text("named"))))
    if word.value in _SWITCHES:
        how = _SWITCHES[word.value]
        if word.value == "idelete" and name.value.casefold() not in begun:
            how = "named"  # nothing is connected so far
        return _switch(s, text, how, one.number)
    signal, value = given[_SIGNAL], given[_VALUE]
    when = Compare("=", signal, SignalState(value == Number(1)))
    arguments = (
        ("", text),
        (WATCH, Text("declared")),
        ("number", Number(one.number)),
        ("when", when),
        ("call", CallValue(one.trap, ())),
        (BEGINS, SignalState(True)),
        (ONCE, SignalState(one.once)),
    )
    return replace(s, arguments=arguments)


def _switch(s: Process, text: Text, how: str, number: int) -> Process:
    return replace(s, arguments=(("", text), (WATCH, Text(how)), ("number", Number(number))))
