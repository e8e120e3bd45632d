"""Where a URScript program's positions and speeds stand in its text."""

from __future__ import annotations

import re
from collections.abc import Iterator

from olp.core.source import Source
from olp.ir.expressions import Expression, Named
from olp.ir.points import PointKind
from olp.ir.program import Move, Program, SetSpeed, SpeedUnit
from olp.languages.literals import Orientation, Spelling, Token, WrittenPoint, WrittenSpeed

_N = r"\s*([-+]?\d*\.?\d+(?:[Ee][-+]?\d+)?)\s*"
_SIX = ",".join([_N] * 6)
_DECLARED = re.compile(rf"\s*(?:global\s+|local\s+)?(\w+)\s*=\s*(p?)\[{_SIX}\]")
_IN_MOVE = re.compile(rf"\s*(movej|movel|movep)\s*\(\s*(?:pose\s*=\s*|q\s*=\s*)?(p?)\[{_SIX}\]")
_SPEED = re.compile(r"[(,]\s*v\s*=\s*(\d*\.?\d+)")
_ACCELERATION = re.compile(r"[(,]\s*a\s*=\s*(\d*\.?\d+)")
_TIME = re.compile(r"[(,]\s*t\s*=\s*(\d*\.?\d+)")
_CALL = re.compile(r"\s*move[jlpc]\s*\(")
SPELLING = Spelling(Orientation.VECTOR, 1.0, 1.0, 6, 9)


def points(program: Program) -> Iterator[WrittenPoint]:
    """Poses and joint positions of six numbers, given to a variable or to a move."""
    for number, line in enumerate(program.source.lines, 1):
        if "[" not in line:
            continue
        code = line.partition("#")[0]
        declared = _DECLARED.match(code)
        match = declared or _IN_MOVE.match(code)
        if match is None:
            continue
        target: Expression | None = Named(declared[1]) if declared else None
        tokens = tuple(Token(number, *match.span(group)) for group in range(3, 9))
        kind = PointKind.POSE if match[2] else PointKind.JOINT
        name = declared[1] if declared else f"line {number}"
        yield WrittenPoint(name, number, program.source, kind, tokens, SPELLING, target)


def speed(program: Program, statement: Move | SetSpeed, unit: SpeedUnit) -> WrittenSpeed | None:
    """Speed argument `v` of a move function: by its name, else the third one (fourth for movec); `t` for moves with
    a time.
    """
    code = program.source.line(statement.line).partition("#")[0]
    match = (_TIME if unit is SpeedUnit.TIME else _SPEED).search(code)
    if match is not None:
        return WrittenSpeed(statement.line, program.source, (Token(statement.line, *match.span(1)),), 6)
    call = _CALL.match(code)
    if call is None:
        return None
    arguments = _arguments(code, call.end())
    place = 3 if "movec" in call[0] or unit is SpeedUnit.TIME else 2
    if len(arguments) <= place:
        return None
    start, stop = arguments[place]
    if re.fullmatch(r"\d*\.?\d+", code[start:stop]) is None:
        return None
    return WrittenSpeed(statement.line, program.source, (Token(statement.line, start, stop),), 6)


def _arguments(code: str, start: int) -> list[tuple[int, int]]:
    """The spans of a call's arguments, without blanks."""
    found, depth, begin = [], 0, start
    for place in range(start, len(code)):
        character = code[place]
        if depth == 0 and character in ",)":
            text = code[begin:place]
            left = begin + len(text) - len(text.lstrip())
            found.append((left, left + len(text.strip())))
            begin = place + 1
            if character == ")":
                break
        depth += (character in "([") - (character in ")]")
    return found


def accelerations(source: Source, line: int) -> Iterator[Token]:
    """The argument a of a move, by its name or as the second one (movec: the third)."""
    code = source.line(line).partition("#")[0]
    named = _ACCELERATION.search(code)
    if named is not None:
        yield Token(line, *named.span(1))
        return
    call = _CALL.match(code)
    arguments = _arguments(code, call.end()) if call is not None else []
    place = 2 if call is not None and "movec" in call[0] else 1
    if len(arguments) > place and re.fullmatch(r"\d*\.?\d+", code[slice(*arguments[place])]):
        yield Token(line, *arguments[place])
