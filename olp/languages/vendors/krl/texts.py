"""Texts that change: StrAdd appends to an array of CHAR, SWRITE writes a number into it, StrCopy and StrClear set it.

KUKA, operating and programming instructions for system integrators, functions for string variables: `n=StrAdd(A[],B[])`
changes A[] and gives its new length; CREAD/CWRITE manual: `SWRITE(A[],STATE,OFFSET,"%.2f",X)` writes X behind the first
OFFSET characters, which from there on counts what was written. A text in KRL changes in place, so that one join is
several statements there, and each of them is an assignment of the whole text in the neutral program.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from typing import Final

from olp.ir.expressions import CallValue, Expression, Function, Item, Named, Number, SignalState, Text
from olp.ir.program import Assign, Statement

# What joins need besides the texts themselves; the names are those of no program that is known.
LENGTH, OFFSET, STATE, VALUE = "TEXT_LENGTH", "TEXT_OFFSET", "TEXT_STATE", "TEXT_VALUE"
HELPERS: Final = {LENGTH: "INT", OFFSET: "INT", STATE: "STATE_T", VALUE: "REAL"}
_CHANGES: Final = {"STRADD": 1, "STRCOPY": 1, "STRCLEAR": 0}  # further arguments
_MOST_DECIMALS: Final = 9
_SWRITE: Final = re.compile(
    r'SWRITE\s*\(\s*(\w+)\[\s*\]\s*,\s*\w+\s*,\s*(\w+)\s*,\s*"%\.(\d)f"\s*,\s*(\w+)\s*\)', re.IGNORECASE
)


def parts_of(e: Expression) -> tuple[Expression, ...]:
    """What a text is put together from, in order: itself alone where it is no join and no number."""
    if isinstance(e, Function) and e.name == "joined-text" and len(e.arguments) > 1:
        return tuple(part for one in e.arguments for part in parts_of(one))
    return (e,)


def is_put_together(e: Expression) -> bool:
    """Whether KRL needs several statements for a text."""
    parts = parts_of(e)
    return len(parts) > 1 or decimals_of(parts[0]) is not None


def decimals_of(e: Expression) -> int | None:
    """With how many decimals a number stands in a text, None where that is not said, or it is none."""
    if not isinstance(e, Function) or e.name != "text-of-value" or len(e.arguments) != 2:
        return None
    count = e.arguments[1]
    if isinstance(count, Number) and count.value in range(_MOST_DECIMALS + 1):
        return int(count.value)
    return None


def lines(target: str, e: Expression, value: Callable[[Expression], str]) -> list[str]:
    """The statements that put `e` together in the array `target` (`A[]`); `value` spells a part."""
    first, *rest = parts_of(e)
    rows: list[str] = []
    if decimals_of(first) is not None:
        rows, rest = [f'{target}=""'], [first, *rest]
    elif value(first) != target:
        rows = [f"{target}={value(first)}"]
    for part in rest:
        decimals = decimals_of(part)
        if decimals is None:
            rows.append(f"{LENGTH}=StrAdd({target},{value(part)})")
            continue
        assert isinstance(part, Function)
        rows += [
            f"{VALUE}={value(part.arguments[0])}",
            f"{OFFSET}=StrLen({target})",
            f'SWRITE({target},{STATE},{OFFSET},"%.{decimals}f",{VALUE})',
        ]
    return rows


def written(code: str, spell: Callable[[str], str]) -> tuple[Statement, ...]:
    """What a SWRITE of one number means; nothing for any other line."""
    match = _SWRITE.fullmatch(code)
    if match is None:
        return ()
    text, offset, value = (Named(spell(match[group])) for group in (1, 2, 4))
    whole = Item(text, ())
    kept = Function("part-of-text", (whole, Number(1), offset))
    number = Function("text-of-value", (value, Number(int(match[3]))))
    length = Function("length-of-text", (whole,))
    return Assign(0, whole, Function("joined-text", (kept, number))), Assign(0, offset, length)


def changed(s: Statement) -> tuple[Statement, ...]:
    """What `n=StrAdd(A[],B[])`, `b=StrCopy(A[],B[])`, `b=StrClear(A[])` mean; nothing for any other statement."""
    if not isinstance(s, Assign) or not isinstance(s.value, CallValue) or not s.value.arguments:
        return ()
    (text, *more), word = s.value.arguments, s.value.routine.upper()
    if isinstance(text, Text) or len(more) != _CHANGES.get(word, -1):
        return ()
    if word == "STRADD":
        length = Function("length-of-text", (text,))
        return Assign(s.line, text, Function("joined-text", (text, more[0]))), Assign(
            s.line, s.target, length
        )
    done = Assign(s.line, s.target, SignalState(True))
    return Assign(s.line, text, more[0] if more else Text("")), done
