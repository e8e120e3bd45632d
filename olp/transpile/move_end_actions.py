"""What RAPID's MoveLDO, MoveJGO, MoveLAO and MoveLSync do at the end of the move: a statement of its own behind it."""

from __future__ import annotations

from dataclasses import replace
from typing import Final

from olp.ir.expressions import Expression, Named, Number, Signal, SignalState, Text
from olp.ir.program import Call, Move, Program, SetOutput, Statement
from olp.transpile.context import Fate, TranslationContext

_BUSES: Final = {"do": "out", "ao": "analog-out", "go": "out-group"}
_MID: Final = "at the middle of the corner: written behind the move"


def at_ends(program: Program, work: TranslationContext) -> Program:
    """Moves that set an output or call a routine at their end as moves, with that behind them."""
    if not work.conventions.actions_at_ends:
        return program
    if not any(isinstance(s, Move) and s.other for s in program.statements()):
        return program
    routines = tuple(
        replace(r, body=tuple([one for s in r.body for one in _split(s, work)])) for r in program.routines
    )
    return replace(program, routines=routines)


def _split(s: Statement, work: TranslationContext) -> list[Statement]:
    if not isinstance(s, Move) or not s.other:
        return [s]
    word, values = s.other[0][0], [value for name, value in s.other[1:] if not name]
    deed = _deed(s.line, word[5:].casefold(), values) if word.casefold().startswith("move") else None
    if deed is None:
        return [s]
    size = None if s.blend is None or s.blend.value is None else s.blend.value.literal
    if size is None or size > 0.0:
        work.lose(s, Fate.APPROXIMATED, "end", f"{word} acts {_MID}")
    kept = tuple((name, value) for name, value in s.other[1:] if name)
    return [replace(s, other=kept), deed]


def _deed(line: int, ending: str, values: list[Expression]) -> Statement | None:
    """`ending`: what follows MoveL, MoveJ or MoveC."""
    match values:
        case [Signal() | Named() as signal, value] if ending in _BUSES:
            if isinstance(signal, Named):
                signal = Signal(_BUSES[ending], Text(signal.name))
            on = ending == "do" and type(value) is Number and value.value in (0, 1)
            return SetOutput(line, signal, SignalState(value == Number(1)) if on else value)
        case [Text(name)] if ending == "sync":
            return Call(line, name)
    return None
