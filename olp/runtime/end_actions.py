"""What a move does at its end: RAPID's MoveLDO, MoveJGO, MoveCAO … set an output, MoveLSync calls a routine.

At a stop point it happens there, at a fly-by point in the middle of the corner (RAPID's technical reference
manual, MoveLDO): between this move and the next one, so that it is a statement of its own right behind the move.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Final

from olp.ir.expressions import Expression, Named, Number, Signal, SignalState, Text
from olp.ir.program import Call, Move, Program, SetOutput, Statement
from olp.languages.vendor import conventions_of

_BUSES: Final = {"do": "out", "ao": "analog-out", "go": "out-group"}
_VALUES: Final = ("\\value", "\\dvalue")  # options that hold the value of a group


def with_end_actions(vendor: str, body: tuple[Statement, ...]) -> tuple[Statement, ...]:
    """A routine's statements with what moves do at their ends behind them; others are the same object."""
    if not conventions_of(vendor).actions_at_ends or not any(type(s) is Move and s.other for s in body):
        return body
    return tuple([one for s in body for one in split_at_end(s)])


def shown_at_ends(program: Program) -> Program:
    """The same of a whole program."""
    routines = [replace(r, body=with_end_actions(program.vendor, r.body)) for r in program.routines]
    return replace(program, routines=tuple(routines))


def split_at_end(s: Statement) -> tuple[Statement, ...]:
    """The move without its word, and the statement that its word stands for; any other statement alone."""
    if type(s) is not Move or not s.other:
        return (s,)
    word = s.other[0][0].casefold()
    values = [value for name, value in s.other[1:] if not name or name.casefold() in _VALUES]
    action = _action(s.line, word[5:], values) if word.startswith("move") else None
    if action is None:
        return (s,)
    kept = tuple((name, value) for name, value in s.other[1:] if name and name.casefold() not in _VALUES)
    return replace(s, other=kept), action


def _action(line: int, ending: str, values: Sequence[Expression]) -> Statement | None:
    """`ending`: what follows MoveL, MoveJ or MoveC, in lower case."""
    match values:
        case [Signal() | Named() as signal, value] if ending in _BUSES:
            if isinstance(signal, Named):
                signal = Signal(_BUSES[ending], Text(signal.name))
            on = ending == "do" and type(value) is Number and value.value in (0, 1)
            return SetOutput(line, signal, SignalState(value == Number(1)) if on else value)
        case [Text(name)] if ending == "sync":
            return Call(line, name)
    return None
