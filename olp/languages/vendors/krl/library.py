"""What KUKA's own functions do: those of the message library (`MsgLib.src` of the System folder), and VARSTATE.

MsgNotify shows a message, and so does MsgLoop. MsgState shows one until Clear_KrlMsg takes its handle, a number above
zero, and returns TRUE. MsgQuit shows one and waits until the operator has acknowledged it: its loop asks
`Exists_KrlMsg`. What is assigned to $LOOP_MSG[] is shown while the program goes on. Texts may be keys of the
controller's message database; `%1` stands for the number, else the text, that is handed over.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from typing import Final

from olp.ir.expressions import (
    CallValue,
    Compare,
    Expression,
    Function,
    Item,
    Named,
    Number,
    SignalState,
    Text,
    Unary,
    Unknown,
)
from olp.ir.program import Program, Routine
from olp.ir.statements import Assign, Call, Message, Pause, Statement, Wait
from olp.ir.transformer import calls_nothing, expressions_of, mapped, sets_numbers
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


# --- Handed parameters ---
# `VARSTATE("P") == #INITIALIZED`: whether a routine was handed a parameter, as the calls of the program tell it.
#
# VARSTATE tells #DECLARED, #INITIALIZED or #UNKNOWN of a variable; a parameter that a call leaves out is not
# initialized until the routine sets it (KSS 8, programming instructions for system integrators, "VARSTATE()").


_ASKS: Final = "varstate"
_GIVEN: Final = "#INITIALIZED"


def with_given_parameters(program: Program) -> Program:
    """The program with what all its calls decide alike as TRUE or FALSE."""
    if not any(_is_asked(s) for s in program.statements()):
        return program
    calls: dict[str, list[tuple[Expression, ...]]] = {}
    for s in program.statements():
        for routine, arguments in _calls(s):
            calls.setdefault(routine.casefold(), []).append(arguments)
    routines = tuple(_decided(r, calls.get(r.name.casefold(), [])) for r in program.routines)
    return replace(program, routines=routines)


def _decided(routine: Routine, calls: list[tuple[Expression, ...]]) -> Routine:
    if not calls or not routine.parameters or not any(map(_is_asked, routine.body)):
        return routine
    given: dict[str, set[bool]] = {
        p.name.casefold(): {at < len(one) and type(one[at]) is not Unknown for one in calls}
        for at, p in enumerate(routine.parameters)
    }

    def change(e: Expression) -> Expression:
        if type(e) is Unary and e.operator == "not" and type(e.operand) is SignalState:
            return SignalState(not e.operand.on)
        if not (type(e) is Compare and e.operator in ("=", "<>")):
            return e
        match e.left, e.right:
            case CallValue(name, (Text(of),)), Text(state) if name.casefold() == _ASKS:
                known = given.get(of.casefold(), set())
                if state.upper() == _GIVEN and len(known) == 1:
                    return SignalState((True in known) == (e.operator == "="))
        return e

    rows: list[Statement] = []
    for s in routine.body:
        rows.append(mapped(s, change) if _is_asked(s) else s)
        if isinstance(s, Assign) and isinstance(s.target, Named) and s.target.name.casefold() in given:
            given[s.target.name.casefold()].add(True)  # from here on some way may have set it
    return replace(routine, body=tuple(rows))


def _is_asked(s: Statement) -> bool:
    return not (calls_nothing(s) or sets_numbers(s)) and any(
        type(e) is CallValue and e.routine.casefold() == _ASKS for e in expressions_of(s)
    )


def _calls(s: Statement) -> Iterator[tuple[str, tuple[Expression, ...]]]:
    if isinstance(s, Call):
        yield s.routine, s.arguments
    if not (calls_nothing(s) or sets_numbers(s)):
        for e in expressions_of(s):
            if type(e) is CallValue:
                yield e.routine, e.arguments
