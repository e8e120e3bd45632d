"""Parameters that a routine hands back: by value where it never changes them, as its result where it changes one."""

from __future__ import annotations

from dataclasses import replace
from typing import Final

from olp.ir.expressions import Item, Member, Named
from olp.ir.program import Call, End, Parameter, Program, Return, Routine, StartTask, Statement
from olp.transpile.constant_folding import paired
from olp.transpile.context import TranslationContext
from olp.transpile.symbols import Symbols, symbols_of

_ROUNDS: Final = 5  # of routines that hand a parameter on


def references(program: Program, work: TranslationContext) -> Program:
    """`PROC a(PERS tooldata t)` as `PROC a(tooldata t)` where nothing assigns to t, here or in what it is handed to."""
    if work.limits.reference_parameters:
        return program
    program = _by_value(program)
    return _returned(program) if work.limits.returned_parameters else program


def _by_value(program: Program) -> Program:
    for _ in range(_ROUNDS):
        if not any(p.by_reference for r in program.routines for p in r.parameters):
            break
        symbols = symbols_of(program)
        routines = tuple(
            replace(r, parameters=tuple(_plain(r, p, symbols) for p in r.parameters))
            for r in program.routines
        )
        if all(a.parameters == b.parameters for a, b in zip(routines, program.routines, strict=True)):
            break
        program = replace(program, routines=routines)
    return program


def _plain(routine: Routine, one: Parameter, symbols: Symbols) -> Parameter:
    symbol = symbols.find(routine.name, one.name)
    changed = symbol is None or symbol.assigned
    return one if not one.by_reference or changed else replace(one, by_reference=False)


def _returned(program: Program) -> Program:
    """A routine that hands one parameter back and returns nothing returns it; its calls store it."""
    started = {s.routine.casefold() for s in program.statements() if isinstance(s, StartTask)}
    handed: dict[str, tuple[Routine, Parameter]] = {}
    for routine in program.routines:
        changed = [p for p in routine.parameters if p.by_reference]
        if len(changed) == 1 and not routine.returns and routine.name.casefold() not in started:
            handed[routine.name.casefold()] = routine, changed[0]

    def row(s: Statement) -> Statement:
        if not isinstance(s, Call) or s.result is not None or s.routine.casefold() not in handed:
            return s
        called, one = handed[s.routine.casefold()]
        given = next((e for p, e in paired(called.parameters, s.arguments) if p == one.name), None)
        return replace(s, result=given) if isinstance(given, (Named, Item, Member)) else s

    routines = []
    for routine in program.routines:
        routine = replace(routine, body=tuple(map(row, routine.body)))
        if routine.name.casefold() in handed:
            routine = _with_result(routine, handed[routine.name.casefold()][1])
        routines.append(routine)
    return replace(program, routines=tuple(routines))


def _with_result(routine: Routine, one: Parameter) -> Routine:
    value = Named(one.name)
    body: list[Statement] = [
        replace(s, value=value) if isinstance(s, Return) else s
        for s in routine.body
        if not isinstance(s, End)
    ]
    if not body or not isinstance(body[-1], Return) or body[-1].condition is not None:
        body.append(Return(routine.body[-1].line if routine.body else routine.line, value))
    parameters = tuple(replace(p, by_reference=False) if p is one else p for p in routine.parameters)
    return replace(routine, body=tuple(body), parameters=parameters, returns=one.type or "real")
