"""Arithmetic that is done while reading: constants, factors of units, poses of numbers."""

from __future__ import annotations

import math
from collections.abc import Sequence

from olp.ir.expressions import Binary, Expression, Number, PositionLiteral, Unary
from olp.languages.vendors.urscript.rotations import angles_from_vector
from olp.languages.vendors.urscript.syntax import Literal, Node

_SAME_FACTOR = 1e-12


def pose_literal(values: tuple[float, ...]) -> PositionLiteral:
    """A pose of x y z [m] and a rotation vector [rad], which is kept for writing it back."""
    x, y, z, rx, ry, rz = values
    turn = angles_from_vector(rx, ry, rz)
    return PositionLiteral("pose", (x, y, z, *turn), (), (), (("vector", f"{rx!r}, {ry!r}, {rz!r}"),))


def constants(items: tuple[Node, ...]) -> tuple[float, ...] | None:
    """The values of numbers written out, None when one is anything else."""
    values = []
    for item in items:
        if type(item) is not Literal:
            return None
        value = item.value
        if type(value) is not float:
            if type(value) is not int:
                return None
            value = float(value)
        values.append(value)
    return tuple(values)


def numbers(values: Sequence[Expression]) -> tuple[float, ...] | None:
    """The values, None when one of them is no number."""
    found = [float(one.value) for one in values if isinstance(one, Number)]
    return tuple(found) if len(found) == len(values) else None


def scaled(e: Expression, factor: float) -> Expression:
    """`e` times `factor`; a factor that is there already and undoes it is taken off instead.

    Of a number twelve digits count: else 4.5 mm grow by the last bit each time that a script is read and written.
    """
    if type(e) is Number:
        return Number(float(f"{e.value * factor:.12g}"))
    if type(e) is Binary and type(e.right) is Number and e.operator in "*/" and e.right.value:
        held = e.right.value if e.operator == "*" else 1.0 / e.right.value
        if abs(held * factor - 1.0) < _SAME_FACTOR:
            return e.left
    return Binary("*", e, Number(factor))


def fold(e: Expression) -> Expression:
    """A number where only numbers are computed with, else the expression as it is."""
    if type(e) is Unary and e.operator == "-":
        operand = fold(e.operand)
        return Number(-operand.value) if type(operand) is Number else e
    if type(e) is Binary and e.operator in "+-*/":
        left, right = fold(e.left), fold(e.right)
        if type(left) is Number and type(right) is Number:
            value = _computed(e.operator, left.value, right.value)
            return e if value is None else Number(value)
    return e


def _computed(operator: str, left: float, right: float) -> int | float | None:
    try:
        match operator:
            case "+":
                value = left + right
            case "-":
                value = left - right
            case "*":
                value = left * right
            case _:
                value = left / right
    except (ZeroDivisionError, OverflowError):
        return None
    return value if math.isfinite(value) else None
