"""Arithmetic that is done while reading: constants, factors of units, poses of numbers."""

from __future__ import annotations

import math
from collections.abc import Sequence
from math import atan2, cos, hypot, sin, sqrt

from olp.ir.expressions import Binary, Expression, Number, PositionLiteral, Unary
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


# --- Rotations ---
# Rotation vectors and the angles of olp, one pose at a time: plain floats, because an array call costs more.
#
# A rotation vector is the axis of the turn times its angle [rad]; the angles are rx, ry, rz [rad] with
# R = Rz(rz) Ry(ry) Rx(rx), as everywhere in olp.

Angles = tuple[float, float, float]


def angles_from_vector(x: float, y: float, z: float) -> Angles:
    """rx, ry, rz of a rotation vector; Rodrigues' formula with sines that keep their digits near no turn."""
    angle = sqrt(x * x + y * y + z * z)
    if angle < 1e-8:
        one, half = 1.0, 0.5
    else:
        one = sin(angle) / angle
        sine = sin(0.5 * angle) / angle
        half = 2.0 * sine * sine
    r00, r11 = 1.0 - half * (y * y + z * z), 1.0 - half * (x * x + z * z)
    r22 = 1.0 - half * (x * x + y * y)
    r10, r20, r21 = half * x * y + one * z, half * x * z - one * y, half * y * z + one * x
    cosine = hypot(r00, r10)
    if cosine < 1e-12:  # rx and rz turn about one axis: rz is 0
        return atan2(one * x - half * y * z, r11), atan2(-r20, cosine), 0.0
    return atan2(r21, r22), atan2(-r20, cosine), atan2(r10, r00)


def vector_from_angles(rx: float, ry: float, rz: float) -> Angles:
    """The rotation vector, 0 to pi long, of the angles: their quaternion, then twice its half angle."""
    cx, sx, cy, sy, cz, sz = (
        cos(0.5 * rx),
        sin(0.5 * rx),
        cos(0.5 * ry),
        sin(0.5 * ry),
        cos(0.5 * rz),
        sin(0.5 * rz),
    )
    w = cz * cy * cx + sz * sy * sx
    x = cz * cy * sx - sz * sy * cx
    y = cz * sy * cx + sz * cy * sx
    z = sz * cy * cx - cz * sy * sx
    if w < 0.0:
        w, x, y, z = -w, -x, -y, -z
    sine = sqrt(x * x + y * y + z * z)
    factor = 2.0 * atan2(sine, w) / sine if sine > 1e-12 else 2.0
    return x * factor, y * factor, z * factor
