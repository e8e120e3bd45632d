"""Data that no statement uses any more and that mean nothing elsewhere: records of speeds, frames, approximations."""

from __future__ import annotations

import re
from collections.abc import Set
from dataclasses import replace
from pathlib import PureWindowsPath
from typing import Final

from olp.core.diagnostic import OlpError, error
from olp.ir.expressions import CallValue, Expression, Named, PositionLiteral, RecordLiteral
from olp.ir.program import Declare, Program, Return, Routine
from olp.ir.transformer import expressions_of, gather, note_names
from olp.languages.limits import limits_of
from olp.languages.vendor import language_of
from olp.transpile.context import Fate, TranslationContext
from olp.transpile.occurrences import names_of_data

_PLAIN = frozenset({"integer", "real", "boolean", "string", "position", "joints"})
_WRITTEN = frozenset({"speed", "zone"})
_HELD = _PLAIN | {"tool", "frame", "clock", ""}  # types that every language has in some form


def unnamed_speeds(program: Program, work: TranslationContext) -> Program:
    """Drops declared speeds and zones that nothing uses: CAM programs have as many as moves, and each pass reads them.

    The last one of a type stays, because it shows which members data without a value have.
    """
    speeds = [d for d in program.data if _is_speed(d)]
    if not speeds or work.source.vendor == work.target or holds_data_only(program):
        return program
    named = names_of_data([*program.data, *(d for r in program.routines for d in r.data)])
    for r in program.routines:
        named |= work.look(r).names()
        for p in r.parameters:
            note_names(p.default, named)
    last = {d.type: id(d) for d in speeds}
    gone = {id(d) for d in speeds if d.name not in named} - set(last.values())
    return replace(program, data=tuple([d for d in program.data if id(d) not in gone]))


def _is_speed(d: Declare) -> bool:
    """Whether data are the record of one speed or zone."""
    value = d.value if d.type in _WRITTEN and not d.sizes else None
    return type(value) is RecordLiteral and bool(value.members) and value.members[0][0] != ""


def drop_unused_records(program: Program, work: TranslationContext) -> Program:
    """Without the records and arrays that nothing names; plain values and points stay, used or not."""
    named: list[Expression] = []
    everything = [*program.data, *(d for r in program.routines for d in r.data)]
    looks = [work.look(r) for r in program.routines]
    for look in looks:
        for _, s in look.rare:
            if type(s) is Declare:
                everything.append(s)
                if any(type(e) is CallValue for e in expressions_of(s)):  # which may do something
                    named.append(Named(s.name))
            else:
                gather(s, named)
    used = {e.name for e in named if type(e) is Named}.union(*(look.names_in_moves() for look in looks))
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
        traps = work.limits.traps
        said = _HELD if traps is None else _HELD | {traps.data_type}
        _refuse(program, {d.name: d.type for d in everything if d.type not in said and kept(d)}, work)
        _refuse_heads(program, said | _WRITTEN, work)
    return replace(
        program,
        data=tuple([d for d in program.data if d.name in used or kept(d)]),
        routines=tuple(
            replace(
                r,
                data=tuple(d for d in r.data if kept(d)),
                body=r.body
                if all(map(kept, look.of_kind(Declare)))
                else tuple([s for s in r.body if type(s) is not Declare or kept(s)]),
            )
            for r, look in zip(program.routines, looks, strict=True)
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
    """Every statement that names data of a type that only its own language has, and their first values."""
    if not types:
        return
    for s in program.statements():
        if isinstance(s, Declare):
            if s.name in types and s.value is not None:
                work.lose(s, Fate.REFUSED, "data", _alien(s.name, types[s.name], work))
            continue
        name = next((e.name for e in expressions_of(s) if type(e) is Named and e.name in types), None)
        if name is not None:
            work.lose(s, Fate.REFUSED, "data", _alien(name, types[name], work))


def _refuse_heads(program: Program, said: Set[str], work: TranslationContext) -> None:
    """Routines that take or give back data of a type that only its own language has, or that nothing tells."""
    for r in program.routines:
        alien = next((p for p in r.parameters if not p.switch and p.type not in said), None)
        if alien is not None:
            work.lose(r.line, Fate.REFUSED, "parameter", _alien(alien.name, alien.type, work))
        elif r.returns not in said:
            work.lose(r.line, Fate.REFUSED, "result", _alien(f"what {r.name} returns", r.returns, work))
        elif not r.returns and (given := next(filter(_gives, work.look(r).of_kind(Return)), None)):
            says = f"what {r.name} returns has a type that nothing tells"
            work.lose(r.line if r.parameters else given, Fate.REFUSED, "result", says)


def _gives(s: Return) -> bool:
    return type(s.value) is RecordLiteral


def _alien(name: str, kind: str, work: TranslationContext) -> str:
    return f"{name} is data of the type {kind}, which {language_of(work.target)} does not have"


# --- Data only ---
# Files that hold data and nothing that runs: RAPID modules without a routine, KRL's lists.
#
# Codes: X014 a language that has no file for data alone.

DATA_ALONE: Final = "X014"
_NO_LETTER: Final = re.compile(r"[^A-Za-z0-9_]+")
_NAMES_OTHERS: Final = "convert the program that starts, or the folder"
_HELP: Final = "convert the program that uses it, which lies in the same folder: the data come with it"


def holds_data_only(program: Program) -> bool:
    return not any(map(_runs, program.routines))


def _runs(routine: Routine) -> bool:
    """Whether it is a routine, and no list of data that KRL's reader keeps as one."""
    return "list" not in routine.details or bool(routine.body)


def data_alone(program: Program, target: str, flat: bool = False) -> Program:
    """The data of a file that holds nothing else, under the name of that file; other programs as they are.

    Raises OlpError (X014) for a language whose data stand in programs only, for what a run shows (`flat`), and for a
    file that only names others, as a project does.
    """
    if not holds_data_only(program):
        return program
    if not any(program.declarations()) and program.vendor != target:
        message = "this file holds neither data nor anything that runs"
        raise OlpError(error(DATA_ALONE, message, file=program.path, help=_NAMES_OTHERS))
    if flat or not limits_of(target).has_data_files:
        message = (
            f"this file holds data and nothing that runs: {language_of(target)} has no file for data alone"
        )
        if flat:
            message = "this file holds data and nothing that runs"
        raise OlpError(error(DATA_ALONE, message, file=program.path, help=_HELP))
    return program if program.vendor == target else replace(program, routines=(), main=name_of(program))


def name_of(program: Program) -> str:
    """What a file of data is called: as the source's list, else as its file."""
    stem = PureWindowsPath(program.path.replace("/", "\\")).stem if program.path else ""
    return program.main or _NO_LETTER.sub("_", stem).strip("_") or "DATA"
