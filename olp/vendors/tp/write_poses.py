"""Positions that other languages compute: TP adds to components of a register, and offsets its moves by registers."""

from __future__ import annotations

from typing import Final

import numpy as np

from olp.expression import Binary, Expression, Function, Number, PositionLiteral, Store, Taught, Variable
from olp.geometry import Pose
from olp.units import deg, mm
from olp.vendors.tp.write_values import CannotSayError, Words, decimal

_POSE_AXES: Final = 6
_LENGTHS: Final = 3
_BUILDERS: Final = ("pose-angles", "pose-vector")
_DECIMALS: Final = 5
Components = tuple[Expression, ...]  # x y z [mm], W P R [deg]


class Scratch:
    """Position registers that nobody else uses, for values that TP can only build component by component."""

    def __init__(self, used: set[int], largest: int) -> None:
        self._free = [number for number in range(largest, 0, -1) if number not in used]

    def register(self, place: int = 0) -> str:
        """The highest free one, the next for `place` 1 … Raises CannotSayError when all are taken."""
        if place >= len(self._free):
            raise CannotSayError("a position that needs a register of its own: all PR are in use")
        return str(self._free[place])


def is_position(it: Expression) -> bool:
    """Whether a move can name it: taught, written out, or in a register."""
    return isinstance(it, (Taught, PositionLiteral)) or (
        isinstance(it, Variable) and it.store is Store.ROBOT and not it.local
    )


def shift_of(it: Function) -> tuple[Expression, tuple[Expression, Expression, Expression]] | None:
    """The position and x y z [mm] that are added to it along the axes of its frame; None where more happens."""
    if it.name == "pose-offset" and len(it.arguments) == 4:
        start, x, y, z = it.arguments
        return start, (x, y, z)
    if it.name == "pose-add" and len(it.arguments) == 2:
        start, by = it.arguments
        parts = components(by)
        if parts is not None and all(map(_is_zero, parts[_LENGTHS:])):
            return start, parts[:_LENGTHS]  # type: ignore[return-value]
    return None


def offset_of(it: Function) -> tuple[str, Expression, Expression] | None:
    """(Offset or Tool_Offset, the position, the offset) of a product of two poses; None where TP has neither."""
    if it.name == "pose-relative-tool" and len(it.arguments) >= 4:
        start, *by = it.arguments
        turns = by[_LENGTHS:]
        # About one axis only, or the order of the turns would be another one.
        if sum(not _is_zero(turn) for turn in turns) > 1:
            return None
        filled = (*by, *[Number(0)] * (_POSE_AXES - len(by)))
        return "Tool_Offset", start, Function("pose-angles", filled)
    if it.name != "pose-product" or len(it.arguments) != 2:
        return None
    first, second = it.arguments
    if _is_built(second) and (is_position(first) or _is_computed(first)):
        return "Tool_Offset", first, second
    if is_position(second) or _is_computed(second):
        return "Offset", second, first
    return None


def components(it: Expression) -> Components | None:
    """x y z [mm] and W P R [deg] of a pose that is put together from numbers; None for anything else."""
    if isinstance(it, PositionLiteral) and it.kind == "pose" and len(it.values) == _POSE_AXES:
        units = [mm] * _LENGTHS + [deg] * _LENGTHS
        return tuple(Number(round(v / unit, _DECIMALS)) for v, unit in zip(it.values, units, strict=True))
    if not isinstance(it, Function) or len(it.arguments) != _POSE_AXES:
        return None
    if it.name == "pose-angles":
        return it.arguments
    if it.name == "pose-vector":
        angles = _angles(it.arguments[_LENGTHS:])
        return None if angles is None else (*(scaled(one, 1000) for one in it.arguments[:_LENGTHS]), *angles)
    return None


def _angles(vector: tuple[Expression, ...]) -> tuple[Number, ...] | None:
    """W P R [deg] of a rotation vector [rad] of plain numbers."""
    values = [one.value for one in vector if isinstance(one, Number)]
    if len(values) != _LENGTHS:
        return None
    if not any(values):
        return (Number(0),) * _LENGTHS
    angle = float(np.linalg.norm(values))
    x, y, z = np.array(values) / angle
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    rotation = np.eye(3) + np.sin(angle) * cross + (1.0 - np.cos(angle)) * (cross @ cross)
    turned = Pose(np.zeros(3), rotation).xyz_angles()[_LENGTHS:]
    return tuple(Number(round(float(value) / deg, _DECIMALS)) for value in turned)


def scaled(it: Expression, factor: int) -> Expression:
    """`it` times a number, with numbers folded."""
    if isinstance(it, Number):
        value = round(it.value * factor, 9)
        return Number(int(value) if value == int(value) else value)
    if isinstance(it, Binary) and it.operator == "*":
        if isinstance(it.left, Number):
            return Binary("*", scaled(it.left, factor), it.right)
        if isinstance(it.right, Number):
            return Binary("*", it.left, scaled(it.right, factor))
    if isinstance(it, Binary) and it.operator in "+-":
        return Binary(it.operator, scaled(it.left, factor), scaled(it.right, factor))
    return Binary("*", it, Number(factor))


def component_lines(words: Words, register: str, parts: Components) -> list[str]:
    """The lines that write all components of a register."""
    return [f"PR[{register},{place}]={_assigned(words, part)}" for place, part in enumerate(parts, 1)]


def added_lines(words: Words, register: str, parts: tuple[Expression, ...]) -> list[str]:
    """The lines that add to the first components of a register."""
    return [
        f"PR[{register},{place}]=(PR[{register},{place}]+{words.expression(part, 5)})"
        for place, part in enumerate(parts, 1)
        if not _is_zero(part)
    ]


def _assigned(words: Words, part: Expression) -> str:
    if isinstance(part, Number):
        text = decimal(float(part.value))
        return f"({text})" if text[0] == "-" else text
    return words.assigned(part)


def _is_zero(it: Expression) -> bool:
    return isinstance(it, Number) and it.value == 0


def _is_built(it: Expression) -> bool:
    return isinstance(it, Function) and it.name in _BUILDERS and components(it) is not None


def _is_computed(it: Expression) -> bool:
    return isinstance(it, Function) and (shift_of(it) is not None or offset_of(it) is not None)
