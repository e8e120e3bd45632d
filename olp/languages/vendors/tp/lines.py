"""The lines of /MN as instructions: numbers and semicolons taken off, continued lines joined, P-SPS blocks told."""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import Final, NamedTuple

NUMBERED: Final = re.compile(r"\s*(\d*)\s*:(?!:)")
_BLOCK_END = re.compile(r"\s*-{3,}\s*;?\s*")
_MOST_JOINED = 60  # lines of one instruction


class TpLine(NamedTuple):
    """One instruction. `closed`: it ended with a semicolon. `lines`: source lines that it takes."""

    number: int  # of its first source line
    text: str
    closed: bool = True
    lines: int = 1
    block_end: bool = False  # the ------ that ends a P-SPS block


def instructions(lines: tuple[str, ...], first: int, stop: int) -> Iterator[TpLine]:
    """The instructions in source lines `first` .. `stop` - 1 (from 1), blank lines left out."""
    number = first
    while number < stop:
        text = lines[number - 1]
        if not text.strip():
            number += 1
            continue
        if _BLOCK_END.fullmatch(text):
            yield TpLine(number, "", block_end=True)
            number += 1
            continue
        body = _body(text)
        if body.endswith(";"):
            yield TpLine(number, body[:-1].rstrip())
            number += 1
            continue
        line = _joined(lines, number, stop, body)
        yield line
        number += line.lines


def _body(text: str) -> str:
    """The text behind the line's number, without the blanks around it."""
    match = NUMBERED.match(text)
    return (text[match.end() :] if match else text).strip(" \t\x1a\x00")


def _joined(lines: tuple[str, ...], number: int, stop: int, body: str) -> TpLine:
    """An instruction that its first line does not close: what follows belongs to it, up to a semicolon."""
    parts, count = [body], 1
    while number + count < stop and count < _MOST_JOINED:
        text = lines[number + count - 1]
        match = NUMBERED.match(text)
        if not text.strip() or _BLOCK_END.fullmatch(text) or (match is not None and match[1]):
            break
        parts.append(_body(text))
        count += 1
        if parts[-1].endswith(";"):
            parts[-1] = parts[-1][:-1].rstrip()
            return TpLine(number, " ".join(parts).strip(), lines=count)
    if count == 1 or not body.startswith(("C ", "L ", "J ", "A ", "S ")):
        return TpLine(number, body, closed=False)
    return TpLine(number, " ".join(parts).strip(), closed=False, lines=count)
