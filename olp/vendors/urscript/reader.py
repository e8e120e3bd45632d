"""A whole file."""

from __future__ import annotations

from olp.program import LineKind, Opaque, Program, Routine
from olp.points import PointTable
from olp.source import Source


def read_program(source: Source) -> Program:
    """The program in a text."""
    body = tuple(Opaque(n, line.strip()) for n, line in enumerate(source.lines, 1) if line.strip())
    routine = Routine("main", 1, body, PointTable())
    return Program("urscript", source, (routine,), line_kinds=bytes([LineKind.OPAQUE] * len(source.lines)))
