"""Where the arm stands (CRobT, $POS_ACT, LPOS): with which tool, and seen in which frame.

KRL and FANUC mean those that hold, RAPID those of the move before or those that it names, URScript the base.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Final

from olp.ir.expressions import Expression, FrameRef, Function, NamedArgument, Number, SystemValue
from olp.ir.program import Move, Program, Routine, Statement
from olp.ir.transformer import calls_nothing, expressions_of, mapped
from olp.transpile.context import Fate, TranslationContext

HERE: Final = SystemValue("current-pose")
_UNSEEN: Final = (FrameRef("tool", Number(0)), FrameRef("base"))
_TOOL, _FRAME = "Tool", "WObj"
_HELD: Final = {"base": "the base", "move": "those of the move before"}

System = tuple[Expression | None, Expression | None]  # tool, frame


def seen_in(tool: Expression | None, frame: Expression | None) -> Function:
    """Where the arm stands with this tool, in this frame."""
    return Function(HERE.name, (NamedArgument(_TOOL, tool), NamedArgument(_FRAME, frame)))


def systems_of(e: Expression) -> System | None:
    """The tool and the frame of a reading of the position that names one of them; None for any other expression."""
    if type(e) is not Function or e.name != HERE.name:
        return None
    named = {a.name.casefold(): a.value for a in e.arguments if isinstance(a, NamedArgument)}
    return named.get(_TOOL.casefold()), named.get(_FRAME.casefold())


def here(program: Program, work: TranslationContext) -> Program:
    """Every reading of the position that names a tool or a frame as the target says it."""
    if not work.conventions.names_read_frames:
        return program
    return replace(program, routines=tuple(_routine(routine, work) for routine in program.routines))


def _routine(routine: Routine, work: TranslationContext) -> Routine:
    rows: list[Statement] = []
    last: System = _UNSEEN  # of the move before, in the order of writing
    for s in routine.body:
        rows.append(s if calls_nothing(s) else _statement(s, last, work))
        if isinstance(s, Move):
            last = (s.tool, s.frame)
    return replace(routine, body=tuple(rows))


def _statement(s: Statement, last: System, work: TranslationContext) -> Statement:
    if not any(e == HERE or systems_of(e) is not None for e in expressions_of(s)):
        return s

    def change(e: Expression) -> Expression:
        asked = (None, None) if e == HERE else systems_of(e)
        if asked is None:
            return e
        tool, frame = (own if own is not None else known for own, known in zip(asked, last, strict=True))
        read_in = work.limits.position_read_in
        held = (last[0], _UNSEEN[1]) if read_in == "base" else last
        if read_in != "named" and (tool, frame) != held:
            says = f"where the arm stands, with another tool or in another frame than {_HELD[read_in]}"
            work.lose(s, Fate.REFUSED, "position", says)
        return seen_in(tool, frame) if read_in == "named" else HERE

    return mapped(s, change)
