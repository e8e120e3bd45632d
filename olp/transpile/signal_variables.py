"""Parameters and variables that stand for a signal: they hold its number, where signals have numbers."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Final

from olp.ir import expressions as ex
from olp.ir.program import Assign, Call, Declare, Parameter, Program, Routine, Statement
from olp.ir.transformer import calls_nothing, mapped, sets_numbers
from olp.transpile.context import Fate, TranslationContext

NUMBER: Final = "signal-number"  # of a signal, which a later pass knows
_TYPE: Final = "signal"


def signal_variables(program: Program, work: TranslationContext) -> Program:
    """Parameters and variables that stand for a signal hold its number."""
    if work.target_conventions.controller_names or not work.conventions.controller_names:
        return program
    own = _Variables(work, _buses(program, work), {r.name.casefold(): r.parameters for r in program.routines})
    if not own.buses:
        return program
    return replace(
        program,
        routines=tuple(own.routine(r) for r in program.routines),
        data=tuple(own.declared(d) for d in program.data),
    )


def _buses(program: Program, work: TranslationContext) -> dict[str, str]:
    """The variables and parameters that stand for a signal, case folded -> the bus on which they are used."""
    return {
        e.index.name.casefold(): e.bus
        for r in program.routines
        for e in work.look(r).expressions
        if isinstance(e, ex.Signal) and isinstance(e.index, ex.Named)
    }


@dataclass(frozen=True, slots=True)
class _Variables:
    work: TranslationContext
    buses: Mapping[str, str]
    heads: Mapping[str, tuple[Parameter, ...]]  # of the program's routines, names case folded

    def routine(self, routine: Routine) -> Routine:
        parameters = tuple(
            replace(p, type="integer", by_reference=False, native="") if p.type == _TYPE else p
            for p in routine.parameters
        )
        body = tuple(s if calls_nothing(s) or sets_numbers(s) else self._statement(s) for s in routine.body)
        return replace(
            routine, parameters=parameters, body=body, data=tuple(self.declared(d) for d in routine.data)
        )

    def declared(self, d: Declare) -> Declare:
        if d.type != _TYPE or d.name.casefold() not in self.buses:
            return d
        return replace(d, type="integer", value=None, native="")

    def _statement(self, s: Statement) -> Statement:
        if isinstance(s, Declare):
            return self.declared(s)
        if (
            isinstance(s, Assign)
            and isinstance(s.target, ex.Named)
            and s.target.name.casefold() in self.buses
        ):
            if isinstance(s.value, ex.Text):
                bus = self.buses[s.target.name.casefold()]
                return replace(s, value=self._number(s.line, ex.Signal(bus, s.value)))
            self.work.lose(s, Fate.REFUSED, "signal", "the name of a signal that is computed")
            return s

        def change(e: ex.Expression) -> ex.Expression:
            if isinstance(e, ex.CallValue):
                return replace(e, arguments=self._handed(s.line, e.routine, e.arguments))
            return e

        s = mapped(s, change)
        if isinstance(s, Call):
            return replace(s, arguments=self._handed(s.line, s.routine, s.arguments))
        return s

    def _handed(self, line: int, name: str, given: tuple[ex.Expression, ...]) -> tuple[ex.Expression, ...]:
        """The arguments of a call, numbers in the places of signals."""
        head = self.heads.get(name.casefold(), ())
        required = iter([p for p in head if not (p.optional or p.switch)])
        named = {p.name.casefold(): p for p in head}
        found: list[ex.Expression] = []
        for one in given:
            if isinstance(one, ex.NamedArgument):
                parameter = named.get(one.name.casefold())
                if parameter is not None and parameter.type == _TYPE and isinstance(one.value, ex.Signal):
                    one = replace(one, value=self._number(line, one.value))
            else:
                parameter = next(required, None)
                if parameter is not None and parameter.type == _TYPE and isinstance(one, ex.Signal):
                    one = self._number(line, one)
            found.append(one)
        return tuple(found)

    def _number(self, line: int, signal: ex.Signal) -> ex.Expression:
        if isinstance(signal.index, (ex.Named, ex.Item)):
            return signal.index  # a variable that holds one already
        if isinstance(signal.index, ex.Text):
            wanted = self.work.context.mapping.signals.get(f"{signal.bus} {signal.index.value}", "")
            if " " in wanted and wanted.rpartition(" ")[0] != signal.bus:
                says = f"a variable that stands for the signal {signal.index.value}, which is {wanted} there"
                self.work.lose(line, Fate.REFUSED, "signal", says)
        return ex.Function(NUMBER, (signal,))
