"""Signals with a computed number where signals have names: a variable stands for the one of that name.

Outputs and waits get the variable by an assignment before them; whatever else reads a signal calls a routine that
does both.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Final

from olp.ir.expressions import (
    CallValue,
    Compare,
    Expression,
    Function,
    Named,
    Number,
    Signal,
    SignalState,
    Text,
    Unary,
)
from olp.ir.points import PointTable
from olp.ir.program import (
    Assign,
    Begin,
    Declare,
    End,
    Parameter,
    Program,
    PulseOutput,
    ReadInput,
    Return,
    Routine,
    SetOutput,
    Statement,
    Wait,
)
from olp.ir.transformer import calls_nothing, expressions_of, mapped, sets_numbers
from olp.runtime.signals import is_number
from olp.transpile.context import Fate, TranslationContext
from olp.transpile.signals import plain_bus, stem_of

_INDEX: Final = "number"


def signal_aliases(program: Program, work: TranslationContext) -> Program:
    """Every signal with a computed number as the one whose name ends with that number."""
    if work.conventions.controller_names or not work.target_conventions.controller_names:
        return program
    own = _Aliases(work)
    routines = [own.routine(routine) for routine in program.routines]
    if not own.variables and not own.readers:
        return program
    readers = [own.reader(bus, name) for bus, name in own.readers.items()]
    declares = [Declare(0, name, f"signal {_kind(bus)}") for (bus, _), name in own.variables.items()]
    return replace(program, routines=(*routines, *readers), data=(*program.data, *declares))


def _kind(bus: str) -> str:
    """What a variable for a signal is declared as: registers are groups of outputs."""
    plain = plain_bus(bus)
    if not {"in", "out"}.isdisjoint(plain.split("-")):
        return plain
    return "out-group" if is_number(bus) else "out"


def _is_computed(e: Expression) -> bool:
    return isinstance(e, Signal) and not isinstance(e.index, (Number, Text))


@dataclass(slots=True)
class _Aliases:
    work: TranslationContext
    variables: dict[tuple[str, int], str] = field(
        default_factory=dict
    )  # (bus, which one of a statement) -> name
    readers: dict[str, str] = field(default_factory=dict)  # bus -> the routine that reads a signal of it

    def routine(self, routine: Routine) -> Routine:
        rows: list[Statement] = []
        for s in routine.body:
            if calls_nothing(s) or sets_numbers(s) or not any(map(_is_computed, expressions_of(s))):
                rows.append(s)
            else:
                rows += self._statement(s)
        return replace(routine, body=tuple(rows))

    def _statement(self, s: Statement) -> list[Statement]:
        signals = [e for e in expressions_of(s) if isinstance(e, Signal) and _is_computed(e)]
        renamed = self.work.context.mapping.signals
        if bus := next((e.bus for e in signals if any(k.startswith(f"{e.bus} ") for k in renamed)), ""):
            says = f"a signal with a computed number, beside names under [signals] for others ({bus})"
            self.work.lose(s, Fate.REFUSED, "signal", says)
            return [s]
        for e in signals:
            self.work.names[("signal", f"{e.bus} *")] = f"{stem_of(e.bus)}*"
        before: list[Statement] = []
        stand: dict[Signal, Signal] = {}
        if isinstance(s, (SetOutput, PulseOutput, ReadInput)):
            self._stand(s.signal, s.line, stand, before)
        elif isinstance(s, Wait):
            for e in dict.fromkeys(signals):
                self._stand(e, s.line, stand, before)

        def change(e: Expression) -> Expression:
            if isinstance(e, Signal) and _is_computed(e):
                return stand.get(e) or self._read(e)
            return _shorter(e, self.readers)

        return [*before, mapped(s, change)]

    def _stand(self, e: Signal, line: int, stand: dict[Signal, Signal], before: list[Statement]) -> None:
        """A variable for a signal of one statement, and what makes it stand for it."""
        if not _is_computed(e):
            return
        key = (e.bus, sum(one.bus == e.bus for one in stand) + 1)
        name = self.variables.get(key)
        if name is None:
            name = self.variables[key] = self.work.helper(f"signal_{stem_of(e.bus)}")
        stand[e] = replace(e, bus=plain_bus(e.bus), index=Named(name))
        before.append(Assign(line, Named(name), _called(e.bus, e.index)))

    def _read(self, e: Signal) -> Expression:
        name = self.readers.get(e.bus)
        if name is None:
            name = self.readers[e.bus] = self.work.helper(f"read_{stem_of(e.bus)}")
        return CallValue(name, (e.index,))

    def reader(self, bus: str, name: str) -> Routine:
        """The routine that reads a signal by its number: a state, or the number that a group carries."""
        variable = Named(self.variables.setdefault((bus, 0), self.work.helper(f"read_{stem_of(bus)}_signal")))
        signal = Signal(plain_bus(bus), variable)
        value: Expression = signal if is_number(bus) else Compare("=", signal, SignalState(True))
        body = (Begin(0), Assign(0, variable, _called(bus, Named(_INDEX))), Return(0, value), End(0))
        returns = "real" if is_number(bus) else "boolean"
        parameters = (Parameter(_INDEX, "integer"),)
        return Routine(name, 0, body, PointTable(), parameters=parameters, returns=returns, shared=False)


def _called(bus: str, number: Expression) -> Expression:
    """The name of the signal with a number."""
    return Function("joined-text", (Text(stem_of(bus)), Function("text-of-value", (number, Number(0)))))


def _shorter(e: Expression, readers: dict[str, str]) -> Expression:
    """A state that was compared with on or off: what the routine returns."""
    if not isinstance(e, Compare) or e.operator not in ("=", "<>"):
        return e
    for one, other in ((e.left, e.right), (e.right, e.left)):
        if isinstance(one, CallValue) and one.routine in readers.values() and isinstance(other, SignalState):
            return one if other.on == (e.operator == "=") else Unary("not", one)
    return e
