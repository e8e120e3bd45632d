"""Whether a changed text says what was asked, as the language's own reader understands it, and nothing else.

Codes: O008 a change that would do something else, O010 a number that had to be rounded.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from olp.core.diagnostic import Diagnostic, OlpError, Span, error, info
from olp.core.units import deg, mm
from olp.ir.expressions import Named, PositionLiteral, Taught, Variable
from olp.ir.moves import Move
from olp.ir.points import PointKind
from olp.ir.program import Program
from olp.ir.statements import Assign, Declare
from olp.languages.literals import Token, WrittenPoint
from olp.robots.geometry import Pose, rotation_angle

Floats = NDArray[np.float64]

# A number with the fewest decimals that there are: one of a millimetre's, two of a degree's (ERC).
_NEAR, _TURNED = 0.06 * mm, 0.02 * deg
_TOLD = 0.005  # [1] a speed that is rounded by more is told
_LAST_NUMBER = re.compile(r"\d*\.?\d+(?=\D*\Z)")


def check_same(before: Program, after: Program, most: int) -> None:
    """Raises OlpError (O008) when more than `most` pieces, one per line, are different."""
    old, new = _facts(before), _facts(after)
    different = [key for key in old.keys() | new.keys() if old.get(key) != new.get(key)]
    known = {(one.code, one.line, one.message) for one in before.diagnostics}
    worse = [
        one for one in after.diagnostics if one.is_error and (one.code, one.line, one.message) not in known
    ]
    if len(different) > most or old.keys() != new.keys() or worse:
        raise OlpError(_something_else(before), *worse)


def check_point(program: Program, point: WrittenPoint, values: Sequence[float]) -> None:
    """Raises OlpError (O008) when the reader takes the point to be anywhere but at `values`."""
    for said in _said(program, point):
        if not _alike(point.kind, np.asarray(said[: len(values)]), np.asarray(values[: len(said)])):
            raise OlpError(_something_else(program, point.line))


def check_speed(
    program: Program, line: int, asked: float, said: float, texts: dict[Token, str]
) -> list[Diagnostic]:
    """Notes about rounding. `asked`, `said` in the unit that is written there, `said` by the reader.

    Raises OlpError (O008) when the reader takes another number for the speed than the one that was written.
    """
    match = _LAST_NUMBER.search(next(iter(texts.values()), ""))
    if match is not None and not abs(float(match[0]) - said) <= 1e-6 * abs(said):
        raise OlpError(_something_else(program, line))
    if abs(said / asked - 1.0) <= _TOLD:
        return []
    message = f"a speed of {asked:g} is written as {said:g}: there are no further decimals"
    return [info("O010", message, Span(line), file=program.path, source_line=program.source.line(line))]


def _something_else(program: Program, line: int = 0) -> Diagnostic:
    message = "the change would do something else as well: nothing was changed"
    return error("O008", message, Span(line) if line else None, file=program.path)


def _facts(program: Program) -> dict[tuple[object, ...], str]:
    """All that a program says, piece by piece."""
    facts: dict[tuple[object, ...], str] = {("data", i): repr(one) for i, one in enumerate(program.data)}
    for routine in program.routines:
        head = replace(routine, body=(), points=type(routine.points)())
        facts["routine", routine.name] = repr(head)
        for i, statement in enumerate(routine.body):
            facts["statement", routine.name, i] = repr(statement)
        for store, taught, point in routine.points:
            facts["point", routine.name, store, taught, point.number] = repr(point)
    return facts


def _said(program: Program, point: WrittenPoint) -> Iterator[tuple[float, ...]]:
    """The values of the point as the program has them; none where it is not kept as numbers."""
    target = point.target
    for routine in program.routines:
        if isinstance(target, Taught | Variable):
            for store, taught, kept in routine.points:
                if isinstance(target, Taught) == taught and kept.line == point.line and store == target.store:
                    yield kept.values
    for one in (*program.data, *(d for r in program.routines for d in r.data), *program.statements()):
        value: object = None
        if isinstance(one, Declare) and isinstance(target, Named) and one.name == target.name:
            # Lists beside the program (KRL .dat) give no line; another routine may have a variable of this name.
            value = one.value if one.line in (0, point.line) else None
        elif isinstance(one, Assign) and isinstance(target, Named) and one.target == target:
            value = one.value if one.line == point.line else None
        elif isinstance(one, Move) and target is None and one.line == point.line and one.targets:
            value = one.targets[0]
        if isinstance(value, PositionLiteral):
            yield value.values


def _alike(kind: PointKind, one: Floats, other: Floats) -> bool:
    if kind is PointKind.PULSE:
        return bool((abs(one - other) <= 0.5).all())
    if kind is PointKind.JOINT:
        return bool((abs(one - other) <= _TURNED).all())
    a, b = Pose.from_xyz_angles(one[:6]), Pose.from_xyz_angles(other[:6])
    near = float(np.linalg.norm(a.position - b.position)) <= _NEAR
    return near and float(rotation_angle(a.rotation, b.rotation)) <= _TURNED
