"""What calls of KUKA's own message library do (`MsgLib.src` of the controller's System folder), and its message window.

MsgNotify shows a message, and so does MsgLoop. MsgState shows one until Clear_KrlMsg takes its handle, a number above
zero, and returns TRUE. MsgQuit shows one and waits until the operator has acknowledged it: its loop asks
`Exists_KrlMsg`. What is assigned to $LOOP_MSG[] is shown while the program goes on. Texts may be keys of the
controller's message database; `%1` stands for the number, else the text, that is handed over.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Final

from olp.ir.expressions import (
    CallValue,
    Expression,
    Function,
    Item,
    Named,
    Number,
    SignalState,
    Text,
    Unknown,
)
from olp.ir.program import Routine
from olp.ir.statements import Assign, Call, Message, Pause, Statement, Wait
from olp.languages.vendor import ACKNOWLEDGED

_SHOWS: Final = frozenset({"msgnotify", "msgquit", "msgloop", "msgstate"})
_CLEARS: Final = "clear_krlmsg"
_WINDOW: Final = "$LOOP_MSG"
_PLACE: Final = "%1"
_OMITTED: Final = Unknown("")
_NOTHING: Final = Text(" ")  # what the window shows when its text is cleared


def without_library(
    body: Sequence[Statement], find: Callable[[str], Routine | None]
) -> tuple[Statement, ...]:
    """The statements with those of the message library as messages and pauses.

    `find`: a routine of the program by its name, None for one that is not here or is KUKA's.
    """
    return tuple([one for s in body for one in _plain(s, find)])


def _plain(s: Statement, find: Callable[[str], Routine | None]) -> tuple[Statement, ...]:
    if type(s) is Call and s.routine.casefold() in _SHOWS and s.condition is None and find(s.routine) is None:
        word = s.routine.casefold()
        handle = s.arguments[0] if word == "msgstate" and s.arguments else None
        text = _shown(s.arguments[1:] if word == "msgstate" else s.arguments)
        if text is None:
            return (s,)
        shown = Message(s.line, text, s.comment)
        if word == "msgquit":
            return (shown, Pause(s.line, spelling=ACKNOWLEDGED))
        return (shown,) if handle is None else (shown, Assign(s.line, handle, Number(1)))
    if type(s) is Assign and _takes_handle(s.value) and find(_CLEARS) is None:
        return (Message(s.line, _NOTHING, s.comment), Assign(s.line, s.target, SignalState(True)))
    if type(s) is Wait and _takes_handle(s.condition) and find(_CLEARS) is None:
        return (Message(s.line, _NOTHING, s.comment),)
    if type(s) is Assign and _is_window(s.target):
        return (Message(s.line, s.value, s.comment),)
    if type(s) is Wait and _clears(s.condition):
        return (Message(s.line, _NOTHING, s.comment),)
    return (s,)


def _shown(arguments: tuple[Expression, ...]) -> Expression | None:
    """The text with what it names filled in, None where that is not written out."""
    text, _, number, words = (*arguments, *[_OMITTED] * 4)[:4]
    if type(text) is not Text or _PLACE not in text.value:
        return None if text == _OMITTED else text
    if number == words == _OMITTED:
        return None
    before, _, behind = text.value.partition(_PLACE)
    value = words if number == _OMITTED else Function("text-of-value", (number,))
    parts = (*([Text(before)] if before else []), value, *([Text(behind)] if behind else []))
    return Function("joined-text", parts)


def _is_window(e: Expression) -> bool:
    """`$LOOP_MSG[]`"""
    return type(e) is Item and type(e.base) is Named and e.base.name.upper() == _WINDOW


def _takes_handle(e: Expression) -> bool:
    """`Clear_KrlMsg(handle)`"""
    return type(e) is CallValue and e.routine.casefold() == _CLEARS and len(e.arguments) == 1


def _clears(condition: Expression) -> bool:
    """`StrClear($LOOP_MSG[])`, which is always true."""
    return (
        isinstance(condition, CallValue)
        and condition.routine.casefold() == "strclear"
        and len(condition.arguments) == 1
        and _is_window(condition.arguments[0])
    )
