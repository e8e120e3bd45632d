"""Texts that change: StrAdd appends to an array of CHAR, SWRITE writes a number into it, StrCopy and StrClear set it.

KUKA, operating and programming instructions for system integrators, functions for string variables: `n=StrAdd(A[],B[])`
changes A[] and gives its new length, `StrFind(N,A[],B[],#CASE_SENS)` says where B[] begins in A[] from character N on,
0: nowhere; CREAD/CWRITE manual: `SWRITE(A[],STATE,OFFSET,"%.2f",X)` writes X behind the first OFFSET characters, which
from there on counts what was written, %g with six digits, %c a character. A text in KRL changes in place, so that one
join is several statements there, and each of them is an assignment of the whole text in the neutral program.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from typing import Final

from olp.ir.expressions import Binary, CallValue, Expression, Function, Item, Named, Number, SignalState, Text
from olp.ir.program import Assign, Statement

# What joins need besides the texts themselves; the names are those of no program that is known.
LENGTH, OFFSET, STATE, VALUE = "TEXT_LENGTH", "TEXT_OFFSET", "TEXT_STATE", "TEXT_VALUE"
FIRST, PLACE = "TEXT_FIRST", "TEXT_PLACE"
HELPERS: Final = {
    **dict.fromkeys((LENGTH, OFFSET, FIRST, PLACE), "INT"),
    STATE: "STATE_T",
    VALUE: "REAL",
}
_CHANGES: Final = {"STRADD": 1, "STRCOPY": 1, "STRCLEAR": 0}  # further arguments
_MOST_DECIMALS: Final = 9
_SWRITE: Final = re.compile(
    r'SWRITE\s*\(\s*(\w+)\[\s*\]\s*,\s*\w+\s*,\s*(\w+)\s*,\s*"%(?:\.(\d)f|g|c)"\s*,\s*(\w+)(?:\[\s*(\w+)\s*\])?\s*\)',
    re.IGNORECASE,
)


def parts_of(e: Expression) -> tuple[Expression, ...]:
    """What a text is put together from, in order: itself alone where it is no join and no number."""
    if isinstance(e, Function) and e.name == "joined-text" and len(e.arguments) > 1:
        return tuple(part for one in e.arguments for part in parts_of(one))
    return (e,)


def is_put_together(e: Expression) -> bool:
    """Whether KRL needs several statements for a text."""
    parts = parts_of(e)
    return len(parts) > 1 or is_written(parts[0])


def is_written(e: Expression) -> bool:
    """Whether SWRITE puts a part into a text: a number, or characters of another text."""
    if not isinstance(e, Function):
        return False
    if e.name == "part-of-text":
        return isinstance(e.arguments[0], Named)
    return e.name == "text-of-value" and (len(e.arguments) == 1 or decimals_of(e) is not None)


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
    if is_written(first):
        rows, rest = [f'{target}=""'], [first, *rest]
    elif value(first) != target:
        rows = [f"{target}={value(first)}"]
    for part in rest:
        if not isinstance(part, Function) or not is_written(part):
            rows.append(f"{LENGTH}=StrAdd({target},{value(part)})")
        elif part.name == "part-of-text":
            rows += _copied(target, part, value)
        else:
            decimals = decimals_of(part)
            rows += [
                f"{VALUE}={value(part.arguments[0])}",
                f"{OFFSET}=StrLen({target})",
                f'SWRITE({target},{STATE},{OFFSET},"%{"g" if decimals is None else f".{decimals}f"}",{VALUE})',
            ]
    return rows


def _copied(target: str, part: Function, value: Callable[[Expression], str]) -> list[str]:
    """The loop that writes some characters of a text behind another."""
    text, start, *count = part.arguments
    last = f"StrLen({value(text)})" if not count else value(_last(start, count[0]))
    rows = []
    if not isinstance(start, Number):  # a loop counts with INT, to which an assignment rounds
        rows.append(f"{FIRST}={value(start)}")
    if count and not last.isdecimal():
        rows.append(f"{LENGTH}={last}")
        last = LENGTH
    return [
        *rows,
        f"{OFFSET}=StrLen({target})",
        f"FOR {PLACE}={value(start) if isinstance(start, Number) else FIRST} TO {last}",
        f'  SWRITE({target},{STATE},{OFFSET},"%c",{value(text).removesuffix("[]")}[{PLACE}])',
        "ENDFOR",
    ]


def _last(start: Expression, count: Expression) -> Expression:
    if isinstance(start, Number) and isinstance(count, Number):
        return Number(int(start.value + count.value) - 1)
    if start == Number(1):
        return count
    if isinstance(start, Number):
        return Binary("+", count, Number(int(start.value) - 1))
    total = start if count == Number(1) else Binary("+", start, count)
    return total if count == Number(1) else Binary("-", total, Number(1))


def written(code: str, spell: Callable[[str], str]) -> tuple[Statement, ...]:
    """What a SWRITE of one number or one character means; nothing for any other line."""
    match = _SWRITE.fullmatch(code)
    if match is None:
        return ()
    text, offset, value = (Named(spell(match[group])) for group in (1, 2, 4))
    whole = Item(text, ())
    kept = Function("part-of-text", (whole, Number(1), offset))
    put = Function("text-of-value", (value,) if match[3] is None else (value, Number(int(match[3]))))
    if match[5] is not None:
        if "%c" not in code:
            return ()
        place = Number(int(match[5])) if match[5].isdecimal() else Named(spell(match[5]))
        put = Function("part-of-text", (Item(value, ()), place, Number(1)))
    length = Function("length-of-text", (whole,))
    return Assign(0, whole, Function("joined-text", (kept, put))), Assign(0, offset, length)


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
