"""Where a TP program's positions and speeds stand in its text."""

from __future__ import annotations

import re
from collections.abc import Iterator

from olp.core.source import Source
from olp.core.units import deg, mm
from olp.ir.expressions import Taught
from olp.ir.points import PointKind
from olp.ir.program import Move, Program, SetSpeed, SpeedUnit
from olp.languages.literals import Orientation, Spelling, Token, WrittenPoint, WrittenSpeed, numbers_of

_VALUE = re.compile(r"\b([XYZWPR]|J[1-6])\s*=\s*([-+]?\d*\.?\d+)")
_SPEED = re.compile(r"(?<=[\s\]])(\d*\.?\d+)\s*(?:mm/sec|cm/min|inch/min|deg/sec|msec|sec|%)")
_ACCELERATION = re.compile(r"\bACC(\d+)\b")
_POSE, _AXES = tuple("XYZWPR"), tuple(f"J{n}" for n in range(1, 7))
SPELLING = Spelling(Orientation.XYZ, mm, deg, 3, 3)


def points(program: Program) -> Iterator[WrittenPoint]:
    """The first group of the positions below /POS."""
    for routine in program.routines:
        for store, taught, point in routine.points:
            if not taught:
                continue
            tokens = _tokens(program.source, point.line)
            for kind, keys in ((PointKind.POSE, _POSE), (PointKind.JOINT, _AXES)):
                if all(key in tokens for key in keys):
                    numbers = tuple(tokens[key] for key in keys)
                    yield WrittenPoint(
                        f"P[{point.number}]",
                        point.line,
                        program.source,
                        kind,
                        numbers,
                        SPELLING,
                        Taught(store, point.number),
                    )
                    break


def _tokens(source: Source, first: int) -> dict[str, Token]:
    found: dict[str, Token] = {}
    for line in range(first, len(source.lines) + 1):
        text = source.line(line)
        if "GP2" in text:
            break
        for match in _VALUE.finditer(text):
            found.setdefault(match[1], Token(line, *match.span(2), padded=True))
        if "}" in text:
            break
    return found


def speed(program: Program, statement: Move | SetSpeed, unit: SpeedUnit) -> WrittenSpeed | None:
    """The number before mm/sec, cm/min, %, deg/sec or sec of a move."""
    match = _SPEED.search(program.source.line(statement.line))
    if match is None:
        return None
    decimals = 0 if unit is SpeedUnit.FRACTION else 1
    return WrittenSpeed(statement.line, program.source, (Token(statement.line, *match.span(1)),), decimals)


def accelerations(source: Source, line: int) -> Iterator[Token]:
    """The numbers behind ACC."""
    return numbers_of(_ACCELERATION, source, line, "!")
