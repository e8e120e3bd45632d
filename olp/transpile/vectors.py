"""URScript's computed p[…] for languages without rotation vectors: components are assigned one by one."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from typing import Final

from olp.ir.expressions import Binary, Expression, Function, Member, Named, Number, PositionLiteral
from olp.ir.program import Assign, Call, Declare, Dwell, Message, Move, Program, Return, SetOutput, Statement
from olp.ir.transformer import calls_nothing, mapped
from olp.transpile.context import TranslationContext
from olp.transpile.symbols import Symbols, symbols_of

_TURNS: Final = ("rotation1", "rotation2", "rotation3")
_AXES: Final = ("x", "y", "z")
# Statements before which others can be put: what a loop's head computes is computed anew each time.
_SIMPLE: Final = (Assign, Move, Call, Return, SetOutput, Dwell, Message)
_ZERO: Final = PositionLiteral("pose", (0.0,) * 6)


def vectors(program: Program, work: TranslationContext) -> Program:
    """p[x, y, z, a[3], a[4], a[5]] as a copy of `a` with another place; a[3] of a constant as its number."""
    if not work.conventions.pose_lists or work.target_conventions.pose_lists:
        return program
    own = _Vectors(work, symbols_of(program))
    routines = tuple(
        replace(r, body=tuple(row for s in r.body for row in own.rows(s, r.name))) for r in program.routines
    )
    return replace(program, routines=routines, data=(*program.data, *own.declared))


@dataclass(slots=True)
class _Vectors:
    work: TranslationContext
    symbols: Symbols
    declared: list[Declare] = field(default_factory=list)

    def rows(self, s: Statement, routine: str) -> list[Statement]:
        """The statement behind those that compute its positions."""
        if calls_nothing(s):
            return [s]
        if type(s) is Declare and type(s.value) is Function and not s.shared:
            # What is computed is assigned: not every language computes where it declares.
            declared = replace(s, value=None, comment="")
            return [declared, *self.rows(Assign(s.line, Named(s.name), s.value, s.comment), routine)]
        before: list[Statement] = []

        def change(e: Expression) -> Expression:
            if type(e) is Function and e.name == "pose-vector" and isinstance(s, _SIMPLE):
                return self._copied(e, s.line, before)
            return e

        s = mapped(s, change)
        s = mapped(s, lambda e: self._component(e, routine))
        return [*[mapped(row, lambda e: self._component(e, routine)) for row in before], s]

    def _copied(self, e: Function, line: int, before: list[Statement]) -> Expression:
        turns = e.arguments[3:6]
        base = turns[0].base if type(turns[0]) is Member else None
        if base is None or turns != tuple(Member(base, name) for name in _TURNS):
            return e
        name = Named(self.work.helper("position"))
        self.declared.append(Declare(0, name.name, "position", _ZERO, shared=True))
        before.append(Assign(line, name, base))
        for axis, value in zip(_AXES, e.arguments[:3], strict=True):
            written = _in_mm(value)
            if written != Member(base, axis):
                before.append(Assign(line, Member(name, axis), written))
        return name

    def _component(self, e: Expression, routine: str) -> Expression:
        """A component of the rotation vector [rad] of a position that nothing changes."""
        if type(e) is not Member or e.name not in _TURNS:
            return e
        value = self.symbols.fixed_value(routine, e.base)
        if type(value) is not PositionLiteral or value.kind != "pose" or len(value.values) < 6:
            return e
        return Number(_rotation_vector(value.values)[_TURNS.index(e.name)])


def _in_mm(e: Expression) -> Expression:
    """A length in metres as one in millimetres, with numbers folded."""
    match e:
        case Number(value):
            return Number(float(f"{value * 1000:.12g}"))
        case Binary("*", left, Number(factor)) if abs(factor * 1000 - 1) < 1e-12:
            return left
        case Binary("+" | "-" as operator, left, right):
            return Binary(operator, _in_mm(left), _in_mm(right))
        case _:
            return Binary("*", e, Number(1000))


def _rotation_vector(values: tuple[float, ...]) -> tuple[float, ...]:
    """[rad] of a pose's angles."""
    from olp.robots.geometry import quaternion_from_rotation, rotation_from_angles

    w, x, y, z = (float(v) for v in quaternion_from_rotation(rotation_from_angles(values[3:6])))
    size = math.sqrt(x * x + y * y + z * z)
    angle = 2.0 * math.atan2(size, w)
    scale = angle / size if size > 0.0 else 0.0
    return tuple(float(f"{v * scale:.12g}") for v in (x, y, z))
