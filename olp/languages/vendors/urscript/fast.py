"""Plain moves and points without the grammar: a path of a CAM system has 100,000 of them.

`quick` gives exactly the instruction that the grammar gives (a test compares the two); whatever else a line holds, it
declines, and the grammar reads it.
"""

from __future__ import annotations

import re
from typing import Final

from olp.languages.vendors.urscript.syntax import (
    POSE_NUMBERS,
    Assignment,
    Evaluation,
    Instruction,
    Invocation,
    ListOf,
    Literal,
    Node,
    PlainPose,
    UrscriptArgument,
    UrscriptName,
    pose_of,
)

_NUMBER: Final = r"[-+]?(?:\d+(?:\.\d*)?|\.\d+)(?:[eE](?:-\d{1,3}|\+?\d{1,2})(?!\d))?"
_NAME: Final = r"[A-Za-z_][A-Za-z0-9_]*+"
_SOME: Final = r"[-+0-9.eE, ]++"
_PLACE: Final = rf"(?:p?\[{_SOME}\]|{_NAME})"
# What stands behind the target is examined once for each of its texts.
_MOVE: Final = re.compile(
    rf"(move[jlp]) ?\( ?(?:pose_trans\(({_PLACE}), ?({_PLACE})\)"
    rf"|get_inverse_kin\(({_PLACE}), qnear=({_PLACE})\)|({_PLACE}))( ?,[^()\[\]\"]*+)? ?\)",
    re.ASCII,
)
_POINT: Final = re.compile(rf"(?:(global|local) )?({_NAME}) ?= ?(p?\[{_SOME}\])", re.ASCII)
_ARGUMENT: Final = re.compile(rf"(?:({_NAME}) ?= ?)?(?:({_NUMBER})|({_NAME}))", re.ASCII)
_WORDS: Final = frozenset((
    "and", "or", "xor", "not", "if", "elif", "else", "while", "end", "def", "thread", "sec", "return",
    "break", "continue", "global", "local", "join", "kill", "run", "True", "False", "true", "false",
))  # fmt: skip
_HUGE = 1e100  # numbers from here on are refused by the grammar
_LONGEST = 26  # characters of a number; longer ones are examined by the reader of lines
# The nodes as their constructors make them, in half the time.
_new: Final = tuple.__new__
_TRANS: Final = UrscriptName("pose_trans")
_KIN: Final = UrscriptName("get_inverse_kin")
_MOVES: Final = {word: UrscriptName(word) for word in ("movej", "movel", "movep")}
_arguments: dict[str | None, tuple[UrscriptArgument, ...]] = {None: ()}
_MOST_CACHED = 20_000


def quick(text: str) -> Instruction | None:
    """The move or point in `text`, or None when it is not plain. A logical line without its comment."""
    if text.startswith("move"):
        found = _MOVE.fullmatch(text)
        return None if found is None else _move(found)
    if text.endswith("]"):
        found = _POINT.fullmatch(text)
        if found is not None and found[2] not in _WORDS:
            value = _place(found[3])
            if value is not None:
                return _new(Assignment, (found[1] or "", _new(UrscriptName, (found[2],)), "=", value))
    return None


def _move(found: re.Match[str]) -> Instruction | None:
    word, frame, inner, pose, near, plain, tail = found.groups()
    arguments = _arguments.get(tail)
    if arguments is None:
        arguments = _read_arguments(tail)
        if arguments is None:
            return None
    if plain is not None:
        target = _place(plain)
        if target is None:
            return None
    elif frame is not None:
        first, second = _place(frame), _place(inner)
        if first is None or second is None:
            return None
        given = (_new(UrscriptArgument, ("", first)), _new(UrscriptArgument, ("", second)))
        target = _new(Invocation, (_TRANS, given))
    else:
        first, second = _place(pose), _place(near)
        if first is None or second is None:
            return None
        target = Invocation(_KIN, (UrscriptArgument("", first), UrscriptArgument("qnear", second)))
    all_given = (_new(UrscriptArgument, ("", target)), *arguments)
    return _new(Evaluation, (_new(Invocation, (_MOVES[word], all_given)),))


def _place(text: str) -> Node | None:
    if text[-1] != "]":
        return None if text in _WORDS else _new(UrscriptName, (text,))
    pose = text[0] == "p"
    numbers = text[2 if pose else 1 : -1].split(",")
    if max(map(len, numbers)) > _LONGEST:
        return None
    try:
        if pose and len(numbers) == POSE_NUMBERS:
            values = tuple(map(float, numbers))
            if not abs(sum(values)) < _HUGE:
                return None
            if not all(values):  # -0 is a whole number, which has no sign
                values = tuple([float(_number(one)) for one in numbers])
            return _new(PlainPose, (values,))
        items = tuple([Literal(_number(one)) for one in numbers])
    except ValueError:
        return None
    if pose:
        return pose_of(items) if len(items) > 2 else None
    return ListOf(items)


def _read_arguments(tail: str) -> tuple[UrscriptArgument, ...] | None:
    found: list[UrscriptArgument] = []
    for part in tail.split(",")[1:]:
        match = _ARGUMENT.fullmatch(part.strip(" "))
        given = None if match is None else _given(match)
        if given is None:
            break
        found.append(given)
    else:
        if len(_arguments) >= _MOST_CACHED:
            _arguments.clear()
            _arguments[None] = ()
        _arguments[tail] = tuple(found)
        return tuple(found)
    return None


def _given(match: re.Match[str]) -> UrscriptArgument | None:
    name, number, value = match.groups()
    if name in _WORDS or value in _WORDS or len(number or "") > _LONGEST:
        return None
    return UrscriptArgument(
        name or "", Literal(_number(number)) if number is not None else UrscriptName(value)
    )


def _number(text: str) -> int | float:
    text = text.strip(" ")
    value = int(text) if text.lstrip("+-").isdigit() else float(text)
    if not abs(value) < _HUGE:
        raise ValueError(text)
    return value
