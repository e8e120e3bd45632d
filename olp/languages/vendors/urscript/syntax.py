"""URScript as it is written: what the grammar makes of a text, before names and units have a meaning.

Arithmetic with constants, factors of units and poses of numbers is done while reading.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from math import atan2, cos, hypot, sin, sqrt
from typing import Any, Final, NamedTuple

from olp.ir.expressions import Binary, Expression, Number, PositionLiteral, Unary

POSE_NUMBERS: Final = 6


class UrscriptName(NamedTuple):
    text: str


class Literal(NamedTuple):
    """A number, a text or a truth value."""

    value: int | float | str | bool


class ListOf(NamedTuple):
    items: tuple[Node, ...]


class PoseOf(NamedTuple):
    """p[…]: x y z [m] and a rotation vector [rad]."""

    items: tuple[Node, ...]


class PlainPose(NamedTuple):
    """p[…] of six numbers that are written out: a path has thousands."""

    values: tuple[float, ...]


class Subscript(NamedTuple):
    base: Node
    indices: tuple[Node, ...]


class UrscriptDot(NamedTuple):
    base: Node
    name: str


class UrscriptArgument(NamedTuple):
    """An argument; `name` empty: by its place."""

    name: str
    value: Node


class Invocation(NamedTuple):
    function: Node
    arguments: tuple[UrscriptArgument, ...]


class Running(NamedTuple):
    """`run name()`: the handle of a thread that starts."""

    call: Node


class Sign(NamedTuple):
    """`operator`: "-", "+" or "not"."""

    operator: str
    operand: Node


class UrscriptPair(NamedTuple):
    """Two operands; `operator` as URScript writes it."""

    operator: str
    left: Node
    right: Node


Node = (
    UrscriptName
    | Literal
    | ListOf
    | PoseOf
    | PlainPose
    | Subscript
    | UrscriptDot
    | Invocation
    | Running
    | Sign
    | UrscriptPair
)


class Definition(NamedTuple):
    """`kind`: def, thread or sec. `parameters`: (name, default or None)."""

    kind: str
    name: str
    parameters: tuple[tuple[str, Node | None], ...]


class Opening(NamedTuple):
    """`word`: if, elif, else or while. `rest`: the statement behind the colon. `closed`: `end` on the same line."""

    word: str
    condition: Node | None
    rest: Simple | None
    closed: bool


class Closing(NamedTuple):
    """`end`."""


class UrscriptKeyword(NamedTuple):
    """return, break, continue, join or kill, and what follows."""

    word: str
    value: Node | None


class Assignment(NamedTuple):
    """`scope`: global, local or empty. `operator`: = or += -= *= /=."""

    scope: str
    target: Node
    operator: str
    value: Node


class Evaluation(NamedTuple):
    """An expression that is a statement: a call, or a word such as halt."""

    value: Node


Simple = UrscriptKeyword | Assignment | Evaluation
Instruction = Definition | Opening | Closing | Simple


def pose_of(items: tuple[Node, ...]) -> PoseOf | PlainPose:
    """p[…] with these items."""
    numbers = [one.value for one in items if type(one) is Literal and type(one.value) in (int, float)]
    if len(items) == len(numbers) == POSE_NUMBERS:
        return PlainPose(tuple(map(float, numbers)))
    return PoseOf(items)


def walk(node: Node) -> Iterator[Node]:
    """The expression and all expressions in it, but for literals and what holds only literals."""
    pending = [node]
    while pending:
        one = pending.pop()
        kind = type(one)
        if kind is Literal or kind is PlainPose:
            continue
        if kind is PoseOf or kind is ListOf:
            items = one.items  # type: ignore[union-attr]
            pending += [item for item in items if type(item) is not Literal]
            continue
        yield one
        pending.extend(_CHILDREN[kind](one))


_CHILDREN: Mapping[type, Callable[[Any], Iterable[Node]]] = {
    UrscriptName: lambda node: (),
    Subscript: lambda node: (node.base, *node.indices),
    UrscriptDot: lambda node: (node.base,),
    Invocation: lambda node: (node.function, *(given.value for given in node.arguments)),
    Running: lambda node: (node.call,),
    Sign: lambda node: (node.operand,),
    UrscriptPair: lambda node: (node.left, node.right),
}


def expressions(instruction: Instruction) -> Iterator[Node]:
    """The expressions that stand in an instruction, from left to right."""
    match instruction:
        case Definition(_, _, parameters):
            yield from (default for _, default in parameters if default is not None)
        case Opening(_, condition, rest, _):
            if condition is not None:
                yield condition
            if rest is not None:
                yield from expressions(rest)
        case UrscriptKeyword(_, value):
            if value is not None:
                yield value
        case Assignment(_, target, _, value):
            yield target
            yield value
        case Evaluation(value):
            yield value


def simple_of(instruction: Instruction) -> Simple | None:
    """The statement without a block in an instruction, None where there is none."""
    if isinstance(instruction, Opening):
        return instruction.rest
    if isinstance(instruction, (Definition, Closing)):
        return None
    return instruction


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
