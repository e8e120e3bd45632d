"""KRL's texts, which are arrays of characters, as the one value that they are elsewhere."""

from __future__ import annotations

from dataclasses import replace

from olp.ir.expressions import Expression, Item, Named, Unknown
from olp.ir.program import Declare, Program, Routine, Statement
from olp.ir.transformer import expressions_of, mapped
from olp.transpile.context import Fate, TranslationContext
from olp.transpile.occurrences import changed_rare

_WHOLE = Unknown("")  # an index that is left out


def texts(program: Program, work: TranslationContext) -> Program:
    """NAME[] is the text itself, NAMES[2,] one of several. A single character of a text is refused."""
    if not work.conventions.text_arrays:
        return program
    rows = {
        d.name.casefold(): len(d.sizes)
        for d in (*program.data, *(d for r in program.routines for d in _declared(r, work)))
        if d.type == "string" and d.sizes
    }
    routines = tuple(
        replace(
            changed_rare(r, work.look(r), lambda s: _row(s, rows, work)), data=tuple(map(_shorter, r.data))
        )
        for r in program.routines
    )
    return replace(program, routines=routines, data=tuple(map(_shorter, program.data)))


def _declared(routine: Routine, work: TranslationContext) -> list[Declare]:
    return [*(s for _, s in work.look(routine).rare if isinstance(s, Declare)), *routine.data]


def _row(s: Statement, rows: dict[str, int], work: TranslationContext) -> Statement:
    if isinstance(s, Declare):
        s = _shorter(s)
    for e in expressions_of(s) if rows else ():
        if type(e) is not Item or type(e.base) is not Named:
            continue
        if len(e.indices) == rows.get(e.base.name.casefold()) and e.indices[-1] != _WHOLE:
            work.lose(s, Fate.REFUSED, "statement", f"a single character of the text {e.base.name}")
    return mapped(s, _whole)


def _shorter(d: Declare) -> Declare:
    return replace(d, sizes=d.sizes[:-1]) if d.type == "string" and d.sizes else d


def _whole(e: Expression) -> Expression:
    if type(e) is not Item or (e.indices and e.indices[-1] != _WHOLE):
        return e
    indices = [index for index in e.indices if index != _WHOLE]
    return Item(e.base, tuple(indices)) if indices else e.base
