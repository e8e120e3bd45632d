"""Where a RAPID module's positions and speeds stand in its text."""

from __future__ import annotations

import re
from bisect import bisect_right
from collections.abc import Iterator

from olp.core.source import Source
from olp.core.units import deg, mm
from olp.ir.expressions import Expression, Named
from olp.ir.points import PointKind
from olp.ir.program import Move, Program, SetSpeed, SpeedUnit
from olp.languages.literals import Orientation, Spelling, Token, WrittenPoint, WrittenSpeed, numbers_of
from olp.languages.vendors.rapid.predefined_data import SPEEDS

_N = r"\s*([-+]?\d*\.?\d+(?:[Ee][-+]?\d+)?)\s*"
_POSE = rf"\[\s*\[{','.join([_N] * 3)}\]\s*,\s*\[{','.join([_N] * 4)}\]\s*,"
_AXES = rf"\[\s*\[{','.join([_N] * 6)}\]\s*,"
_DECLARED = re.compile(rf"\b(robtarget|jointtarget)\s+(\w+)\s*:=\s*(?:{_POSE}|{_AXES})", re.IGNORECASE)
_IN_MOVE = re.compile(rf"\b(Move(?:J|L|AbsJ))\s+(?:{_POSE}|{_AXES})", re.IGNORECASE)
_HIDDEN = re.compile(r'"(?:[^"\n]|"")*"|![^\n]*')
_OWN_SPEED = re.compile(r"\\V\s*:=\s*(\d*\.?\d+)", re.IGNORECASE)
_NAMED_SPEED = re.compile(r",\s*(v\w+)(?=\s*(?:,|\\Z|\\V))", re.IGNORECASE)
_MOVE = re.compile(
    r"\bMove(?:[LJC]|AbsJ)\w*\s+(?=[\w\[\\])", re.IGNORECASE
)  # and no target that is called Move1
_ACCELERATION = re.compile(r"\bAccSet\s+(\d*\.?\d+)\s*,", re.IGNORECASE)
SPELLING = Spelling(Orientation.QUATERNION, mm, deg, 3, 9)
_JOINTS = Spelling(Orientation.QUATERNION, mm, deg, 3, 4)


def points(program: Program) -> Iterator[WrittenPoint]:
    """Declared robtargets and jointtargets, and those written out in MoveJ, MoveL and MoveAbsJ."""
    source = program.source
    # What strings and comments say is no program; blanks keep all places.
    text = _HIDDEN.sub(lambda m: " " * len(m[0]), "\n".join(source.lines))
    starts = [0]
    for one in source.lines:
        starts.append(starts[-1] + len(one) + 1)
    for pattern in (_DECLARED, _IN_MOVE):
        for match in pattern.finditer(text):
            line = bisect_right(starts, match.start())
            target: Expression | None = Named(match[2]) if pattern is _DECLARED else None
            yield _point(source, match, 3 if target else 2, line, target, starts)


def _point(
    source: Source, match: re.Match[str], first: int, line: int, target: Expression | None, starts: list[int]
) -> WrittenPoint:
    is_pose = match[first] is not None
    groups = range(first, first + 7) if is_pose else range(first + 7, first + 13)
    tokens = []
    for group in groups:
        start, stop = match.span(group)
        number = bisect_right(starts, start)
        tokens.append(Token(number, start - starts[number - 1], stop - starts[number - 1]))
    kind = PointKind.POSE if is_pose else PointKind.JOINT
    name = target.name if isinstance(target, Named) else f"line {line}"
    return WrittenPoint(name, line, source, kind, tuple(tokens), SPELLING if is_pose else _JOINTS, target)


def speed(program: Program, statement: Move | SetSpeed, unit: SpeedUnit) -> WrittenSpeed | None:
    r"""The number of \V, else the speed's name: another predefined one, or \V behind it."""
    text = _HIDDEN.sub(lambda m: " " * len(m[0]), program.source.line(statement.line))
    if isinstance(statement, SetSpeed) or len(_MOVE.findall(text)) != 1:
        return None
    own, named = _OWN_SPEED.search(text), _NAMED_SPEED.search(text)
    if own is not None:
        return WrittenSpeed(statement.line, program.source, (Token(statement.line, *own.span(1)),), 3)
    if named is None:
        return None
    token = Token(statement.line, *named.span(1))
    choices = {values[0]: name for name, values in SPEEDS.items() if re.fullmatch(r"v\d+", name)}
    is_predefined = named[1].lower() in SPEEDS
    return WrittenSpeed(
        statement.line,
        program.source,
        (Token(token.line, token.stop, token.stop),),
        3,
        before="\\V:=",
        named=token if is_predefined else None,
        names=choices,
    )


def accelerations(source: Source, line: int) -> Iterator[Token]:
    """The first number of AccSet."""
    return numbers_of(_ACCELERATION, source, line, "!")
