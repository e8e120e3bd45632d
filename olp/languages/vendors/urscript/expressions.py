"""Lowers expressions: names, elements, arithmetic and calls, metres and radians into what olp computes with.

olp's trigonometry takes degrees, its components of positions are mm and degrees: the factors are written out, so
that values stay those of URScript, and the writer takes the same factors off again.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Final

from olp.core import result_cache
from olp.core.units import deg, mm
from olp.ir import expressions as ex
from olp.languages.vendors.urscript import builtins, helpers
from olp.languages.vendors.urscript.scopes import UrscriptNames, UrscriptPart
from olp.languages.vendors.urscript.syntax import (
    Invocation,
    ListOf,
    Literal,
    Node,
    PlainPose,
    PoseOf,
    Running,
    Sign,
    Subscript,
    UrscriptArgument,
    UrscriptDot,
    UrscriptName,
    UrscriptPair,
    constants,
    fold,
    numbers,
    pose_literal,
)

_COMPARE: Final = {"==": "=", "!=": "<>", "<": "<", ">": ">", "<=": "<=", ">=": ">="}
_BINARY: Final = {"+": "+", "-": "-", "*": "*", "/": "/", "%": "mod"}
_POSE_MEMBERS: Final = ("x", "y", "z", "rotation1", "rotation2", "rotation3")
_AXES = 6


class Expressions:
    """Lowers the expressions of one part. `tell`: takes (code, message, help) of what is wrong."""

    def __init__(
        self, names: UrscriptNames, part: UrscriptPart, tell: Callable[[str, str, str], None]
    ) -> None:
        self.names = names
        self.part = part
        self.tell = tell
        self._poses = result_cache.shelf("urscript poses")

    def lower(self, node: Node, joints: bool = False) -> ex.Expression:
        """The expression; `joints`: a list of six numbers is a position of the axes."""
        return _LOWER[type(node)](self, node, joints)

    def type_of(self, node: Node) -> str:
        return self.names.infer(self.part, node)

    def number(self, node: Node) -> int | float | None:
        """The value of a constant number, None for anything else."""
        return _constant(self.lower(node))

    # --- values -----------------------------------------------------------------------------------------

    def _literal(self, node: Literal, _: bool) -> ex.Expression:
        value = node.value
        if type(value) is bool:
            return ex.SignalState(value)
        return ex.Text(value) if type(value) is str else ex.Number(value)  # type: ignore[arg-type]

    def _name(self, node: UrscriptName, _: bool) -> ex.Expression:
        return ex.Named(node.text)

    def _list(self, node: ListOf, joints: bool) -> ex.Expression:
        nested = joints and any(type(item) is ListOf for item in node.items)
        if joints and not nested and len(node.items) == _AXES:
            values = constants(node.items)
            if values is None:
                folded = [fold(self.lower(item)) for item in node.items]
                values = numbers(folded)
                if values is None:
                    return ex.Function("joints", tuple(ex.scaled(one, 1.0 / deg) for one in folded))
            return ex.PositionLiteral("joint", values)
        return ex.RecordLiteral("list", tuple(("", self.lower(item, nested)) for item in node.items))

    def plain_pose(self, node: PlainPose, _: bool = False) -> ex.Expression:
        # By identity: a line that stands where it stood is the same object.
        known = None if self._poses is None else self._poses.get(id(node))
        if known is not None and known[0] is node:
            found: ex.Expression = known[1]
            return found
        pose = _pose_of(node.values)
        if self._poses is not None:
            self._poses.put(id(node), (node, pose))
        return pose

    def _pose(self, node: PoseOf, _: bool) -> ex.Expression:
        if len(node.items) != _AXES:
            self.tell("P559", f"a pose has six numbers, this one {len(node.items)}", "p[x, y, z, rx, ry, rz]")
            return ex.Function("pose-vector", tuple(self.lower(item) for item in node.items))
        folded = [fold(self.lower(item)) for item in node.items]
        values = numbers(folded)
        if values is None:
            return ex.Function("pose-vector", tuple(folded))
        return _pose_of(values)

    def _subscript(self, node: Subscript, _: bool) -> ex.Expression:
        base = self.lower(node.base)
        kind = self.type_of(node.base)
        # Each index is lowered once: twice at each level would be without an end for lists within lists.
        indices = [self.lower(index) for index in node.indices]
        if len(indices) == 1:
            place = _constant(indices[0])
            if kind == "position":
                if type(place) is int and 0 <= place < _AXES:
                    member = ex.Member(base, _POSE_MEMBERS[place])
                    return member if place > 2 else ex.scaled(member, mm)
                return ex.Function("pose-element", (base, _from_one(indices[0])))
            item = ex.Item(base, (_from_one(indices[0]),))
            return ex.scaled(item, deg) if kind == "joints" else item
        return ex.Item(base, tuple(map(_from_one, indices)))

    def _dot(self, node: UrscriptDot, _: bool) -> ex.Expression:
        return ex.Member(self.lower(node.base), node.name)

    # --- arithmetic -------------------------------------------------------------------------------------

    def _sign(self, node: Sign, _: bool) -> ex.Expression:
        operand = self.lower(node.operand)
        if node.operator == "not":
            return ex.Unary("not", operand)
        return ex.Number(-operand.value) if type(operand) is ex.Number else ex.Unary("-", operand)

    def _pair(self, node: UrscriptPair, _: bool) -> ex.Expression:
        left, right = self.lower(node.left), self.lower(node.right)
        if node.operator == "<=" and left == ex.Named(helpers.COUNTER) and right == ex.Number(0):
            return ex.SystemValue("timed-out")
        if node.operator in _COMPARE:
            return ex.Compare(_COMPARE[node.operator], left, right)
        if node.operator in _BINARY:
            if node.operator == "+" and "string" in (self.type_of(node.left), self.type_of(node.right)):
                return ex.Function("joined-text", (left, right))
            return ex.Binary(_BINARY[node.operator], left, right)
        return ex.Logic(left, ((node.operator, right),))

    # --- calls ------------------------------------------------------------------------------------------

    def _run(self, node: Running, _: bool) -> ex.Expression:
        return ex.Function("run", (self.lower(node.call),))

    def _call(self, node: Invocation, _: bool) -> ex.Expression:
        if type(node.function) is not UrscriptName:
            return ex.Function(method_name(node.function), self.arguments(node.arguments))
        name = node.function.text
        called = self.part.find(name)
        if called is not None:
            return ex.CallValue(called.unique, self.passed(called, node.arguments))
        meaning = _CALLS.get(name)
        if meaning is not None:
            lowered = meaning(self, [given.value for given in node.arguments], node.arguments)
            if lowered is not None:
                return lowered
        if name in builtins.KNOWN:
            return ex.Function(name, self.arguments(node.arguments))
        return ex.CallValue(name, self.arguments(node.arguments))

    def arguments(self, given: tuple[UrscriptArgument, ...]) -> tuple[ex.Expression, ...]:
        """Arguments of a call whose parameters are not known."""
        return tuple(self._given(one, self.lower(one.value)) for one in given)

    def passed(self, called: UrscriptPart, given: tuple[UrscriptArgument, ...]) -> tuple[ex.Expression, ...]:
        """Arguments of a function of the file: lists that it takes for positions of the axes are such."""
        target = self.names.of(called)
        places = [name for name, _ in called.parameters]
        found = []
        for index, one in enumerate(given):
            name = one.name or (places[index] if index < len(places) else "")
            found.append(self._given(one, self.lower(one.value, name in target.joints)))
        return tuple(found)

    def _given(self, given: UrscriptArgument, value: ex.Expression) -> ex.Expression:
        return ex.NamedArgument(given.name, value) if given.name else value


def _constant(e: ex.Expression) -> int | float | None:
    """The value of a constant number, None for anything else."""
    folded = fold(e)
    return folded.value if type(folded) is ex.Number else None


def _from_one(index: ex.Expression) -> ex.Expression:
    """An index from 0 as one from 1."""
    value = _constant(index)
    if type(value) is int:
        return ex.Number(value + 1)
    if type(index) is ex.Binary and index.operator == "-" and index.right == ex.Number(1):
        return index.left
    return ex.Binary("+", index, ex.Number(1))


def _pose_of(values: tuple[float, ...]) -> ex.Expression:
    x, y, z, rx, ry, rz = values
    # A turn whose square no number holds is none, and the run says so.
    if not math.isfinite(x + y + z + rx * rx + ry * ry + rz * rz):
        return ex.Function("pose-vector", tuple(map(ex.Number, values)))
    return pose_literal(values)


_LOWER: Final[Mapping[type, Callable[..., ex.Expression]]] = {
    Literal: Expressions._literal,
    UrscriptName: Expressions._name,
    ListOf: Expressions._list,
    PoseOf: Expressions._pose,
    PlainPose: Expressions.plain_pose,
    Subscript: Expressions._subscript,
    UrscriptDot: Expressions._dot,
    Sign: Expressions._sign,
    UrscriptPair: Expressions._pair,
    Running: Expressions._run,
    Invocation: Expressions._call,
}

Meaning = Callable[[Expressions, list[Node], tuple[UrscriptArgument, ...]], ex.Expression | None]


def _plain(neutral: str) -> Meaning:
    def lower(e: Expressions, values: list[Node], _: tuple[UrscriptArgument, ...]) -> ex.Expression | None:
        return ex.Function(neutral, tuple(e.lower(value) for value in values)) if values else None

    return lower


def _from_angle(neutral: str) -> Meaning:
    def lower(e: Expressions, values: list[Node], _: tuple[UrscriptArgument, ...]) -> ex.Expression | None:
        return ex.Function(neutral, (ex.scaled(e.lower(values[0]), 1.0 / deg),)) if len(values) == 1 else None

    return lower


def _to_angle(neutral: str) -> Meaning:
    def lower(e: Expressions, values: list[Node], _: tuple[UrscriptArgument, ...]) -> ex.Expression | None:
        return (
            ex.scaled(ex.Function(neutral, tuple(e.lower(value) for value in values)), deg)
            if values
            else None
        )

    return lower


def _times(factor: float) -> Meaning:
    def lower(e: Expressions, values: list[Node], _: tuple[UrscriptArgument, ...]) -> ex.Expression | None:
        if len(values) != 1:
            return None
        operand = e.lower(values[0])
        if type(operand) is ex.Number:  # kept as it is written: 30 deg stay 30 deg
            return ex.Binary("*", operand, ex.Number(factor))
        return ex.scaled(operand, factor)

    return lower


def signal_of(e: Expressions, word: str, bus: str, number: Node) -> ex.Signal:
    """The signal that a call of `word` reads or switches: the older functions count the tool's behind the box's."""
    index = fold(e.lower(number))
    first, last, further = builtins.COUNTED_ON.get(word, (0, 0, ""))
    if not further or type(index) is not ex.Number or index.value < first:
        return ex.Signal(bus, index)
    if index.value > last:
        message = f"{word} has no signal {index.value:g}"
        e.tell("P569", message, f"0 to {first - 1} are the box's, {first} to {last} the tool's")
        return ex.Signal(bus, index)
    return ex.Signal(further, ex.Number(index.value - first))


def _signal(word: str, bus: str) -> Meaning:
    def lower(e: Expressions, values: list[Node], _: tuple[UrscriptArgument, ...]) -> ex.Expression | None:
        return signal_of(e, word, bus, values[0]) if len(values) == 1 else None

    return lower


def _system(name: str) -> Meaning:
    return lambda e, values, _: None if values else ex.SystemValue(name)


def _inverse(e: Expressions, values: list[Node], given: tuple[UrscriptArgument, ...]) -> ex.Expression | None:
    """get_inverse_kin(x, qnear, maxPositionError, maxOrientationError, tcp)."""
    if not given or given[0].name not in ("", "x"):
        return None
    found: list[ex.Expression] = [e.lower(given[0].value)]
    for index, one in enumerate(given[1:], 1):
        near = one.name == "qnear" or (not one.name and index == 1)
        value = e.lower(one.value, joints=near)
        found.append(ex.NamedArgument(one.name, value) if one.name and not near else value)
    return ex.Function("inverse", tuple(found))


def _forward(e: Expressions, values: list[Node], _: tuple[UrscriptArgument, ...]) -> ex.Expression | None:
    if not values:
        return ex.SystemValue("current-pose")
    return ex.Function("forward", (e.lower(values[0], joints=True),)) if len(values) == 1 else None


def _distance(e: Expressions, values: list[Node], _: tuple[UrscriptArgument, ...]) -> ex.Expression | None:
    if len(values) != 2:
        return None
    return ex.scaled(ex.Function("pose-distance", tuple(e.lower(value) for value in values)), mm)


def _norm(e: Expressions, values: list[Node], _: tuple[UrscriptArgument, ...]) -> ex.Expression | None:
    scalar = len(values) == 1 and e.type_of(values[0]) in ("integer", "real")
    return ex.Function("abs", (e.lower(values[0]),)) if scalar else None


def _logarithm(e: Expressions, values: list[Node], _: tuple[UrscriptArgument, ...]) -> ex.Expression | None:
    """log(base, x)."""
    if len(values) != 2:
        return None
    top = ex.Function("log", (e.lower(values[1]),))
    if e.number(values[0]) == math.e:
        return top
    return ex.Binary("/", top, ex.Function("log", (e.lower(values[0]),)))


def _part_of_text(
    e: Expressions, values: list[Node], _: tuple[UrscriptArgument, ...]
) -> ex.Expression | None:
    if len(values) not in (2, 3):
        return None
    return ex.Function(
        "part-of-text",
        (e.lower(values[0]), _from_one(e.lower(values[1])), *(e.lower(one) for one in values[2:])),
    )


def _character(e: Expressions, values: list[Node], _: tuple[UrscriptArgument, ...]) -> ex.Expression | None:
    if len(values) != 2:
        return None
    return ex.Function("part-of-text", (e.lower(values[0]), _from_one(e.lower(values[1])), ex.Number(1)))


def _find(e: Expressions, values: list[Node], _: tuple[UrscriptArgument, ...]) -> ex.Expression | None:
    if not 2 <= len(values) <= 3:
        return None
    text, wanted, *start = map(e.lower, values)
    if start:
        found = ex.Function("find-in-text", (text, _from_one(start[0]), wanted))
    else:
        found = ex.Function("position-in-text", (text, wanted))
    return ex.Binary("-", found, ex.Number(1))


def _length(e: Expressions, values: list[Node], _: tuple[UrscriptArgument, ...]) -> ex.Expression | None:
    kind = e.type_of(values[0]) if len(values) == 1 else ""
    if kind == "string":
        return ex.Function("length-of-text", (e.lower(values[0]),))
    if kind.startswith("list") or kind == "joints":
        return ex.Function("size-of-array", (e.lower(values[0]), ex.Number(1)))
    return None


def _structure(
    e: Expressions, values: list[Node], given: tuple[UrscriptArgument, ...]
) -> ex.Expression | None:
    if not given or not all(one.name for one in given):
        return None
    return ex.RecordLiteral("struct", tuple((one.name, e.lower(one.value)) for one in given))


def _helper(name: str) -> Meaning:
    def lower(e: Expressions, values: list[Node], _: tuple[UrscriptArgument, ...]) -> ex.Expression | None:
        return helpers.meaning(name, tuple(e.lower(value) for value in values)) if values else None

    return lower


_CALLS: Final[Mapping[str, Meaning]] = {
    **{word: _plain(neutral) for word, neutral in builtins.FUNCTIONS.items()},
    **{word: _from_angle(word) for word in builtins.FROM_ANGLE},
    **{word: _to_angle(word) for word in builtins.TO_ANGLE},
    **{word: _signal(word, bus) for word, bus in builtins.INPUTS.items()},
    **{word: _system("current-pose") for word in builtins.CURRENT_POSE},
    **{word: _system("current-joints") for word in builtins.CURRENT_JOINTS},
    "d2r": _times(deg),
    "r2d": _times(1.0 / deg),
    "get_inverse_kin": _inverse,
    "get_forward_kin": _forward,
    "point_dist": _distance,
    "pose_dist": _distance,
    "norm": _norm,
    "log": _logarithm,
    "str_sub": _part_of_text,
    "str_at": _character,
    "str_find": _find,
    "length": _length,
    "struct": _structure,
    **{name: _helper(name) for name in helpers.TEXTS if name not in {*builtins.INPUTS, *builtins.OUTPUTS}},
}


def method_name(node: Node) -> str:
    """`a.b` of a call of something else than a function: a method of a remote object."""
    match node:
        case UrscriptName(text):
            return text
        case UrscriptDot(base, name):
            return f"{method_name(base)}.{name}"
        case _:
            return "call"
