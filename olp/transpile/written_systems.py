"""KRL writes the values of its numbered tools and frames, TOOL_DATA[n] and BASE_DATA[n], or one element of them.

A whole one is set in the target by its number. All else is refused: it is no variable like others.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any, Final

from olp.ir.expressions import (
    Expression,
    FrameRef,
    Item,
    Member,
    Named,
    Number,
    PositionLiteral,
    RecordLiteral,
)
from olp.ir.program import Assign, Move, Program, SetFrame, SetTool, Statement
from olp.ir.transformer import edited, expressions_of
from olp.transpile.constant_frames import Key
from olp.transpile.context import Fate, TranslationContext

_ARRAYS: Final = {"TOOL_DATA": "tool", "BASE_DATA": "user"}
_FIELDS: Final[dict[type, tuple[str, ...]]] = {
    Move: ("tool", "frame"),
    SetTool: ("tool",),
    SetFrame: ("frame",),
}


def written_systems(program: Program, work: TranslationContext) -> Program:
    """Those that the program sets by their numbers, with the values that $config.dat gives them before."""
    if not work.conventions.numbered_frame_values:
        return program
    assigned = [s for r in program.routines for _, s in work.look(r).rare if isinstance(s, Assign)]
    written = {key for s in assigned if (key := _set(s.target))}
    _refuse(assigned, written, work)
    if not written:
        return program
    for declare in program.data:
        kind = _ARRAYS.get(declare.name.upper())
        if kind is not None and isinstance(declare.value, RecordLiteral):
            for number, (_, value) in enumerate(declare.value.members, 1):
                if (kind, number) in written and isinstance(value, PositionLiteral):
                    work.systems[(kind, number)] = value
    routines = tuple(
        replace(r, body=tuple([_statement(s, written) for s in r.body])) for r in program.routines
    )
    return replace(program, routines=routines)


def _system(e: Expression) -> FrameRef | None:
    """A tool or frame of the arrays by its number, which may be computed."""
    if isinstance(e, FrameRef) and e.kind in _ARRAYS.values() and e.number is not None:
        return e
    if isinstance(e, Item) and isinstance(e.base, Named) and e.base.name.upper() in _ARRAYS:
        return FrameRef(_ARRAYS[e.base.name.upper()], e.indices[0])
    return None


def _set(target: Expression) -> Key | None:
    """The tool or frame that an assignment sets as a whole."""
    found = _system(target)
    if found is None or not isinstance(found.number, Number):
        return None
    return found.kind, int(found.number.value)


def _refuse(assigned: list[Assign], written: set[Key], work: TranslationContext) -> None:
    for s in assigned:
        word = ""
        target: Expression = s.target
        while isinstance(target, Member):
            target = target.base
        found = _system(target)
        if found is not None:
            word = "tool" if found.kind == "tool" else "frame"
            if target is not s.target:
                says = f"one element of a {word} that is set on its own: assign the {word} as a whole"
                work.lose(s, Fate.REFUSED, word, says)
            elif not isinstance(found.number, Number):
                says = f"which {word} it sets is computed while the program runs"
                work.lose(s, Fate.REFUSED, word, says)
        if any(_set(e) in written for e in expressions_of(s.value)):
            work.lose(s, Fate.REFUSED, word or "value", "it reads a tool or frame that the program sets")


def _statement(s: Statement, written: set[Key]) -> Statement:
    if isinstance(s, Assign) and _set(s.target) in written and (system := _system(s.target)) is not None:
        return replace(s, target=system)
    changes: dict[str, Any] = {}
    for name in _FIELDS.get(type(s), ()):
        e = getattr(s, name)
        if isinstance(e, Item) and _set(e) in written:
            changes[name] = _system(e)
    if not changes:
        return s
    return edited(s, changes) if isinstance(s, Move) else replace(s, **changes)
