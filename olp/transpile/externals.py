"""External axes of positions (E1, extax): for languages where a track or a station is an arm of its own, or none."""

from __future__ import annotations

from dataclasses import replace

from olp.ir.expressions import Expression, PositionLiteral
from olp.ir.program import Move, Program, Statement
from olp.ir.transformer import calls_nothing, expressions_of, mapped
from olp.transpile.context import Fate, TranslationContext
from olp.transpile.symbols import Symbols


def externals(program: Program, work: TranslationContext) -> Program:
    """Positions without external axes. Those that stand at zero all the time are nothing; others are refused."""
    if not work.limits.no_external_axes or not any(e.external for e in work.literals(program)):
        return program
    symbols = work.symbols(program)
    routines = []
    for routine in program.routines:
        rows: list[Statement] = []
        for s in routine.body:
            if any(_stands(e, symbols, routine.name) for e in _positions(s)):
                work.lose(s, Fate.REFUSED, "external", work.limits.no_external_axes)
            rows.append(mapped(s, _without))
        data = tuple(mapped(d, _without) for d in routine.data)
        routines.append(replace(routine, body=tuple(rows), data=data))
    return replace(program, data=tuple(mapped(d, _without) for d in program.data), routines=tuple(routines))


def _positions(s: Statement) -> tuple[Expression, ...]:
    """Whatever in a statement may hold a position."""
    if calls_nothing(s):
        assert isinstance(s, Move)
        return s.targets
    return tuple(expressions_of(s))


def _stands(e: Expression, symbols: Symbols, routine: str) -> bool:
    """Whether a position has an external axis that is not at zero."""
    value = symbols.fixed_value(routine, e)
    return type(value) is PositionLiteral and any(v == v and v != 0.0 for v in value.external)


def _without(e: Expression) -> Expression:
    return replace(e, external=()) if type(e) is PositionLiteral and e.external else e
