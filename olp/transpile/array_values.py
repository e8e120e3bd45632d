"""Arrays that are assigned as a whole, element by element where the target has no such value."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

from olp.ir.expressions import Expression, Item, Named, Number, RecordLiteral
from olp.ir.program import Assign, Program, Statement
from olp.transpile.context import TranslationContext


def array_values(program: Program, work: TranslationContext) -> Program:
    """`a := [[1,2],[3,4]]` as four assignments."""
    if work.limits.array_literals:
        return program
    if not any(_sets_array(s) for r in program.routines for _, s in work.look(r).rare):
        return program
    routines = tuple(
        replace(r, body=tuple(row for s in r.body for row in _rows(s))) for r in program.routines
    )
    return replace(program, routines=routines)


def _sets_array(s: Statement) -> bool:
    return type(s) is Assign and type(s.target) is Named and _is_array(s.value)


def _rows(s: Statement) -> tuple[Statement, ...]:
    if type(s) is not Assign or not _sets_array(s):
        return (s,)
    rows = [Assign(s.line, Item(s.target, at), value) for at, value in _elements(s.value, ())]
    return (replace(rows[0], comment=s.comment), *rows[1:]) if rows else (s,)


def _is_array(e: Expression) -> bool:
    return type(e) is RecordLiteral and bool(e.members) and not any(name for name, _ in e.members)


def _elements(
    e: Expression, before: tuple[Expression, ...]
) -> Iterator[tuple[tuple[Expression, ...], Expression]]:
    if type(e) is not RecordLiteral or not _is_array(e):
        yield before, e
        return
    for place, (_, value) in enumerate(e.members, 1):
        yield from _elements(value, (*before, Number(place)))
