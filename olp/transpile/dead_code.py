"""Data that no statement uses any more and that mean nothing elsewhere: records of speeds, frames, approximations."""

from __future__ import annotations

from dataclasses import replace

from olp.ir.expressions import Named, PositionLiteral, RecordLiteral
from olp.ir.program import Declare, Program
from olp.ir.transformer import expressions_of, note_names
from olp.languages.vendor import language_of
from olp.transpile.context import Fate, TranslationContext
from olp.transpile.data_only import holds_data_only

_PLAIN = frozenset({"integer", "real", "boolean", "string", "position", "joints"})
_WRITTEN = frozenset({"speed", "zone"})
_HELD = _PLAIN | {"tool", "frame", ""}  # types that every language has in some form


def prune(program: Program, work: TranslationContext) -> Program:
    """Without the records and arrays that nothing names; plain values and points stay, used or not."""
    used: set[str] = set()
    everything = [*program.data, *(d for r in program.routines for d in r.data)]
    for s in program.statements():
        if type(s) is Declare:
            everything.append(s)
        else:
            note_names(s, used)
    by_name = {d.name: d for d in everything}
    naming = {name: d for name, d in by_name.items() if type(d.value) is not PositionLiteral}
    todo = list(used & naming.keys())
    while todo:
        declare = naming.get(todo.pop())
        if declare is None:
            continue
        inner = [e.name for e in expressions_of(declare) if type(e) is Named]
        todo += [name for name in inner if name not in used]
        used.update(inner)

    alone = holds_data_only(program)

    def kept(d: Declare) -> bool:
        if d.name in used or (alone and _is_said(d)):
            return True
        if work.source.vendor == work.target:
            return d.type in _WRITTEN  # moves name them as they are written
        return d.type in _PLAIN and type(d.value) is not RecordLiteral

    if work.source.vendor != work.target:
        _tell_gone([d for d in everything if alone and not kept(d)], work)
        _refuse(program, {d.name: d.type for d in everything if d.type not in _HELD and kept(d)}, work)
    return replace(
        program,
        data=tuple([d for d in program.data if d.name in used or kept(d)]),
        routines=tuple(
            replace(
                r,
                data=tuple(d for d in r.data if kept(d)),
                body=tuple([s for s in r.body if type(s) is not Declare or kept(s)]),
            )
            for r in program.routines
        ),
    )


def _is_said(d: Declare) -> bool:
    return type(d.value) is PositionLiteral or (bool(d.sizes) and d.type in _PLAIN)


def _tell_gone(data: list[Declare], work: TranslationContext) -> None:
    """Of a file that holds nothing else; of others' data what is used stands in the statements."""
    for d in data:
        kind = f"data of the type {d.native or d.type}" if d.native or d.type else "such data"
        says = f"{d.name} is left out: {language_of(work.target)} has no {kind}"
        work.lose(d, Fate.APPROXIMATED, "data", says)


def _refuse(program: Program, types: dict[str, str], work: TranslationContext) -> None:
    """Every statement that names data of a type that only its own language has."""
    if not types:
        return
    for s in program.statements():
        if isinstance(s, Declare):
            continue
        name = next((e.name for e in expressions_of(s) if type(e) is Named and e.name in types), None)
        if name is not None:
            work.lose(
                s,
                Fate.REFUSED,
                "data",
                f"{name} is data of the type {types[name]}, which {language_of(work.target)} does not have",
            )
