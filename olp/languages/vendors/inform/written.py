"""Where a job's positions and speeds stand in its text."""

from __future__ import annotations

import re
from collections.abc import Iterator

from olp.core.source import Source
from olp.core.units import deg, mm
from olp.ir.expressions import Expression, Number, Taught, Variable
from olp.ir.points import PointKind
from olp.ir.program import Move, Program, SetSpeed, SpeedUnit
from olp.languages.literals import Orientation, Spelling, Token, WrittenPoint, WrittenSpeed, numbers_of

_NUMBER = re.compile(r"[-+]?\d*\.?\d+|[-+]?\d+\.")
_ACCELERATION = re.compile(r"(?<![A-Z])(?:ACC|DEC)\s*=\s*(\d+(?:\.\d*)?)")
_WORDS = {SpeedUnit.FRACTION: "VJ", SpeedUnit.TRAVEL: "V", SpeedUnit.TURN: "VR"}
SPELLING = Spelling(Orientation.XYZ, mm, deg, 0, 0)  # a controller's own columns have fixed decimals


def points(program: Program) -> Iterator[WrittenPoint]:
    """Positions of the header with six numbers or more."""
    for routine in program.routines:
        for store, taught, point in routine.points:
            name, equals, _ = program.source.line(point.line).partition("=")
            kind, start = point.state.kind, len(name) + len(equals)
            found = [
                Token(point.line, *match.span())
                for match in _NUMBER.finditer(program.source.line(point.line), start)
            ]
            tokens = tuple(found[:6] if kind is PointKind.POSE else found)
            if len(tokens) >= 6:
                target: Expression = Taught(store, point.number)
                if not taught:
                    target = Variable(store, Number(point.number))
                yield WrittenPoint(name.strip(), point.line, program.source, kind, tokens, SPELLING, target)


def speed(program: Program, statement: Move | SetSpeed, unit: SpeedUnit) -> WrittenSpeed | None:
    """The number behind V=, VJ= or VR= of a line."""
    text = program.source.line(statement.line).partition("//")[0]
    match = re.search(rf"(?<![A-Z]){_WORDS.get(unit, 'V')}\s*=\s*(\d+(?:\.\d*)?)", text)
    if match is None:
        return None
    decimals = len(match[1].partition(".")[2])
    return WrittenSpeed(
        statement.line, program.source, (Token(statement.line, *match.span(1)),), decimals, fixed=True
    )


def accelerations(source: Source, line: int) -> Iterator[Token]:
    """The numbers behind ACC= and DEC=."""
    return numbers_of(_ACCELERATION, source, line, "//")
