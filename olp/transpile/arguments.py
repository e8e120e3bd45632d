"""Arguments by name and arguments that may be left out, for languages whose calls give all of them in order."""

from __future__ import annotations

from dataclasses import replace

from olp.ir.expressions import CallValue, Expression, NamedArgument
from olp.ir.program import Call, Parameter, Program, Statement
from olp.ir.transformer import calls_nothing, mapped
from olp.transpile.constant_folding import paired
from olp.transpile.context import TranslationContext


def arguments(program: Program, work: TranslationContext) -> Program:
    """Every call with all arguments, those left out with their defaults. A switch, or one without a default, stays.

    What a routine is given and never reads is left out.
    """
    if work.conventions.surplus_arguments:
        program = _without_surplus(program, work)
    if not work.limits.ordered_arguments:
        return program
    known = {r.name.casefold(): r.parameters for r in program.routines if _is_filled(r.parameters)}
    if not any(p.optional for parameters in known.values() for p in parameters) and not _by_name(program):
        return program

    def change(e: Expression) -> Expression:
        if type(e) is CallValue and e.routine.casefold() in known:
            return replace(e, arguments=_in_order(known[e.routine.casefold()], e.arguments))
        return e

    def row(s: Statement) -> Statement:
        if calls_nothing(s):
            return s
        s = mapped(s, change)
        if isinstance(s, Call) and s.routine.casefold() in known:
            return replace(s, arguments=_in_order(known[s.routine.casefold()], s.arguments))
        return s

    routines = []
    for routine in program.routines:
        parameters = routine.parameters
        if routine.name.casefold() in known:
            parameters = tuple(replace(p, optional=False, default=None) for p in parameters)
        routines.append(replace(routine, body=tuple(map(row, routine.body)), parameters=parameters))
    return replace(program, routines=tuple(routines))


def _without_surplus(program: Program, work: TranslationContext) -> Program:
    taken = {r.name: len(r.parameters) for r in program.routines}

    def row(s: Statement) -> Statement:
        if not isinstance(s, Call) or len(s.arguments) <= taken.get(s.routine, len(s.arguments)):
            return s
        count = taken[s.routine]
        work.note_at(s, f"{s.routine} reads {count} of its {len(s.arguments)} arguments")
        return replace(s, arguments=s.arguments[:count])

    routines = tuple(replace(r, body=tuple(map(row, r.body))) for r in program.routines)
    return replace(program, routines=routines)


def _is_filled(parameters: tuple[Parameter, ...]) -> bool:
    return all(not p.switch and (not p.optional or p.default is not None) for p in parameters)


def _by_name(program: Program) -> bool:
    from olp.ir.transformer import expressions_of

    return any(
        type(e) is NamedArgument
        for s in program.statements()
        if not calls_nothing(s)
        for e in expressions_of(s)
    )


def _in_order(parameters: tuple[Parameter, ...], given: tuple[Expression, ...]) -> tuple[Expression, ...]:
    values = dict(paired(parameters, given))
    found = [values.get(p.name) or p.default for p in parameters]
    if any(value is None for value in found):
        return given
    return tuple(value for value in found if value is not None)
