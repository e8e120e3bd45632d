"""Gives `[...]` its meaning by the type that is asked for: positions, tools, frames, speeds, structures, arrays.

A rotation is written as a quaternion, the scalar first. It is brought to unit length, as the controller does.
"""

from __future__ import annotations

import math
import re
from dataclasses import dataclass, replace
from functools import lru_cache
from math import isfinite, pi
from typing import Final

from olp.core.units import deg, mm
from olp.ir import expressions as ex
from olp.ir.points import Sector
from olp.languages.vendors.rapid.names import RapidNames
from olp.languages.vendors.rapid.predefined_data import NOT_CONNECTED, PREDEFINED

_POSES: Final = (
    "pose-angles",
    "pose-quaternion",
    "pose-product",
    "pose-inverse",
    "pose-offset",
    "pose-relative-tool",
)
_ZERO: Final = ex.Number(0)
_XYZ: Final = ("x", "y", "z")
_ANGLES: Final = ("rx", "ry", "rz")
_NO_ANGLES: Final = (_ZERO, _ZERO, _ZERO)
_RAX: Final = 6
_QUARTER: Final = pi / 2
_MOST_QUARTERS = 12  # of a turn, more than any axis reaches
_MOST_CFX = 7
_FREE: Final = math.nan
_UNTURNED: Final = ("orient", "0,0,0,0")
_NO_TURN: Final = (1.0, 0.0, 0.0, 0.0)
_DEEPEST: Final = 8  # structures in one another
_PLAIN_ZEROS: Final[dict[str, ex.Expression]] = {"string": ex.Text(""), "bool": ex.SignalState(False)}
_TEXTS: Final = frozenset({"text-of-value", "joined-text", "part-of-text"})
UNIT_TOLERANCE: Final = 1e-3  # beyond it a quaternion is told to be none of unit length


@dataclass(frozen=True, slots=True)
class RapidAggregate:
    """`[a, b, …]` before its type is known."""

    items: tuple[ex.Expression | RapidAggregate, ...]


class ShapeError(Exception):
    """An aggregate that does not have the shape of its type."""


def quaternion_angles(w: float, x: float, y: float, z: float) -> tuple[float, float, float]:
    """rx, ry, rz [rad] with R = Rz Ry Rx of a quaternion of any length. Raises ShapeError for zeros.

    At ry = ±90 deg only rx ∓ rz is defined; rz is then 0, as in `geometry.angles_from_rotation`.
    """
    size = w * w + x * x + y * y + z * z
    if not 1e-12 < size < 1e12:
        raise ShapeError("a quaternion of zeros is no rotation")
    s = 2.0 / size
    sine = s * (w * y - x * z)
    r00, r10 = 1.0 - s * (y * y + z * z), s * (x * y + w * z)
    cosine = math.hypot(r00, r10)
    ry = math.atan2(sine, cosine)
    if cosine < 1e-12:
        return math.atan2(-s * (y * z - w * x), 1.0 - s * (x * x + z * z)), ry, 0.0
    return math.atan2(s * (y * z + w * x), 1.0 - s * (x * x + y * y)), ry, math.atan2(r10, r00)


def numbers(value: object, count: int) -> tuple[float, ...] | None:
    """The values of an aggregate of that many plain numbers, else None."""
    if not isinstance(value, RapidAggregate) or len(value.items) != count:
        return None
    found = tuple(float(item.value) for item in value.items if isinstance(item, ex.Number))
    return found if len(found) == count and all(map(math.isfinite, found)) else None


def number_text(value: float) -> str:
    """A number as it stands in native notes: 12, 0.5, 9E9."""
    if value == NOT_CONNECTED:
        return "9E9"
    return str(int(value)) if value == int(value) and abs(value) < 1e15 else repr(value)


def coerced(
    value: ex.Expression | RapidAggregate, kind: str, names: RapidNames, sizes: int = 0
) -> ex.Expression:
    """The value as one of type `kind` (lower case, "" unknown), `sizes` dimensions. Raises ShapeError.

    Data that every controller has, such as z10 and tool0, become their values.
    """
    if isinstance(value, ex.Named):
        predefined = PREDEFINED.get(value.name.lower())
        return value if predefined is None or names.knows(value.name) else predefined
    if not isinstance(value, RapidAggregate):
        return value
    if sizes > 0:
        return ex.RecordLiteral(
            "", tuple(("", coerced(item, kind, names, sizes - 1)) for item in value.items)
        )
    kind = names.resolved(kind) or _guessed(value)
    match kind:
        case "robtarget":
            return _robtarget(value, names)
        case "pose":
            return _pose(value, names)
        case "pos":
            return _pos(value)
        case "orient":
            return _orient(value, names)
        case "jointtarget":
            return _jointtarget(value, names)
    return _record(value, kind, names)


def _record(value: RapidAggregate, kind: str, names: RapidNames) -> ex.Expression:
    members = names.members(kind)
    if members is None:
        return ex.RecordLiteral("", tuple(("", coerced(item, "", names)) for item in value.items))
    if len(members) != len(value.items):
        raise ShapeError(f"{len(value.items)} values, where {kind} has {len(members)}")
    pairs = zip(members, value.items, strict=True)
    return ex.RecordLiteral(kind, tuple((name, coerced(item, of, names)) for (name, of), item in pairs))


def _guessed(value: RapidAggregate) -> str:
    """The type by the shape alone: where an argument's type is not known."""
    lengths = tuple(len(item.items) if isinstance(item, RapidAggregate) else 0 for item in value.items)
    known: dict[tuple[int, ...], str] = {(3, 4, 4, 6): "robtarget", (3, 4): "pose", (6, 6): "jointtarget"}
    return known.get(lengths, "")


def _expect(value: RapidAggregate, count: int, what: str) -> None:
    if len(value.items) != count:
        raise ShapeError(f"{len(value.items)} values, where {what} has {count}")


def _robtarget(value: RapidAggregate, names: RapidNames) -> ex.Expression:
    _expect(value, 4, "a robtarget")
    place, turn, arm, axes = value.items
    literal = _literal_pose(place, turn, names)
    configuration, external = numbers(arm, 4), numbers(axes, 6)
    if literal is not None and configuration is not None and external is not None:
        return with_axes(literal, configuration, external)
    pose = _computed(place, turn)
    rest = [] if configuration == (0, 0, 0, 0) else [_named("conf", arm, "confdata", names)]
    if external != (NOT_CONNECTED,) * 6:
        rest.append(_named("axes", axes, "extjoint", names))
    return ex.Function(pose.name, (*pose.arguments, *rest))


def _named(
    name: str, value: ex.Expression | RapidAggregate, kind: str, names: RapidNames
) -> ex.NamedArgument:
    return ex.NamedArgument(name, coerced(value, kind, names))


def with_axes(
    pose: ex.PositionLiteral, configuration: tuple[float, ...], external: tuple[float, ...]
) -> ex.PositionLiteral:
    """The literal with what a robtarget holds besides: arm configuration and external axes [mm or deg]."""
    flags, sectors, native = arm(configuration)
    return ex.PositionLiteral(
        "pose", pose.values, connected(external), flags, (*pose.native, *native), sectors
    )


Arm = tuple[tuple[int, ...], tuple[Sector, ...], tuple[tuple[str, str], ...]]


@lru_cache(maxsize=1000)
def arm(configuration: tuple[float, ...]) -> Arm:
    """Arm flags, the quarters in which axes 1, 4 and 6 stand, and what is written back, of a confdata.

    cfx of the manual's table for arms with a spherical wrist: 4 behind axis 1, 2 behind the lower arm, 1 axis 5
    negative, which turns against Yaskawa's B. () where it is of another arm.
    """
    native = (("confdata", ",".join(map(number_text, configuration))),) if any(configuration) else ()
    if any(value != round(value) or abs(value) > _MOST_QUARTERS for value in configuration):
        return (), (), native
    cf1, cf4, cf6, cfx = map(int, configuration)
    if not 0 <= cfx <= _MOST_CFX:
        return (), (), native
    turns = tuple((quarter + 2) // 4 for quarter in (cf4, cf6, cf1))
    sectors = tuple(
        Sector(axis, quarter * _QUARTER, (quarter + 1) * _QUARTER)
        for axis, quarter in ((0, cf1), (3, cf4), (5, cf6))
    )
    return (1 - cfx % 2, cfx // 2 % 2, cfx // 4, *turns), sectors, native


@lru_cache(maxsize=1000)
def confdata(configuration: tuple[int, ...], sectors: tuple[tuple[int, float, float], ...]) -> str:
    """The way back of `arm`; "" where the quarters are not known."""
    quarters = {
        axis: round(low / _QUARTER) for axis, low, high in sectors if isfinite(low) and isfinite(high)
    }
    if len(configuration) < 3 or not {0, 3, 5} <= quarters.keys():
        return ""
    noflip, lower, rear = (int(bool(flag)) for flag in configuration[:3])
    return f"{quarters[0]},{quarters[3]},{quarters[5]},{4 * rear + 2 * lower + 1 - noflip}"


def connected(values: tuple[float, ...]) -> tuple[float, ...]:
    """nan for an axis that is not connected; () when none is."""
    if all(v >= NOT_CONNECTED for v in values):
        return ()
    return tuple(_FREE if v >= NOT_CONNECTED else v for v in values)


def _pose(value: RapidAggregate, names: RapidNames) -> ex.Expression:
    _expect(value, 2, "a pose")
    place, turn = value.items
    return _literal_pose(place, turn, names) or _computed(place, turn)


def _pos(value: RapidAggregate) -> ex.Expression:
    _expect(value, 3, "a pos")
    found = numbers(value, 3)
    if found is not None:
        return ex.PositionLiteral("pose", (found[0] * mm, found[1] * mm, found[2] * mm, 0.0, 0.0, 0.0))
    return ex.Function("pose-angles", (*plain_items(value), *_NO_ANGLES))


def _orient(value: RapidAggregate, names: RapidNames | None = None) -> ex.Expression:
    _expect(value, 4, "an orient")
    found = numbers(value, 4)
    if found is not None:
        return _turned((0.0, 0.0, 0.0), found, names)
    return ex.Function("pose-quaternion", (*_NO_ANGLES, *plain_items(value)))


def is_vector(value: object) -> bool:
    """Whether it is three numbers in brackets, which among sums and products are a pos."""
    if not isinstance(value, RapidAggregate) or len(value.items) != 3:
        return False
    return not any(isinstance(item, RapidAggregate) for item in value.items)


def plain_items(value: RapidAggregate) -> tuple[ex.Expression, ...]:
    """The items of an aggregate of numbers. Raises ShapeError for one that holds another."""
    found = tuple(item for item in value.items if not isinstance(item, RapidAggregate))
    if len(found) != len(value.items):
        raise ShapeError("brackets where a number is expected")
    return found


def pose_literal(place: tuple[float, ...], turn: tuple[float, ...]) -> ex.PositionLiteral:
    """A pose from numbers [mm] and a quaternion. Raises ShapeError for a quaternion of zeros."""
    x, y, z = place
    values = (x * mm, y * mm, z * mm, *quaternion_angles(*turn))
    return ex.PositionLiteral("pose", values, (), (), (("orient", ",".join(map(number_text, turn))),))


def _literal_pose(place: object, turn: object, names: RapidNames) -> ex.PositionLiteral | None:
    xyz, quaternion = numbers(place, 3), numbers(turn, 4)
    if xyz is None or quaternion is None:
        return None
    return _turned(xyz, quaternion, names)


def _turned(
    place: tuple[float, ...], turn: tuple[float, ...], names: RapidNames | None
) -> ex.PositionLiteral:
    """A pose; with a quaternion of zeros, which a controller loads, one that turns nothing, and `names` tells it."""
    if names is None or any(turn):
        if names is not None:
            names.uneven = names.uneven or not is_unit(turn)
        return pose_literal(place, turn)
    names.unturned = True
    return replace(pose_literal(place, _NO_TURN), native=(_UNTURNED,))


def is_unturned(value: ex.Expression | None) -> bool:
    """Whether a pose was written with a quaternion of zeros."""
    return isinstance(value, ex.PositionLiteral) and _UNTURNED in value.native


def is_unit(quaternion: tuple[float, ...]) -> bool:
    """Whether a quaternion has unit length, as far as digits are written."""
    w, x, y, z = quaternion
    return abs(w * w + x * x + y * y + z * z - 1.0) < UNIT_TOLERANCE


def _computed(place: ex.Expression | RapidAggregate, turn: ex.Expression | RapidAggregate) -> ex.Function:
    """A pose some of whose numbers are computed."""
    xyz = place_parts(place)
    if isinstance(turn, RapidAggregate):
        _expect(turn, 4, "an orient")
        return ex.Function("pose-quaternion", (*xyz, *plain_items(turn)))
    return ex.Function("pose-angles", (*xyz, *turn_parts(turn)))


def place_parts(value: ex.Expression | RapidAggregate) -> tuple[ex.Expression, ...]:
    """x, y, z [mm] of a pos."""
    if isinstance(value, RapidAggregate):
        _expect(value, 3, "a pos")
        return plain_items(value)
    if isinstance(value, ex.Function) and value.name == "pose-angles" and value.arguments[3:] == _NO_ANGLES:
        return value.arguments[:3]
    if isinstance(value, ex.PositionLiteral):
        return tuple(ex.Number(v / mm) for v in value.values[:3])
    return tuple(ex.Member(value, name) for name in _XYZ)


def is_place(value: ex.Expression | RapidAggregate, names: RapidNames) -> bool:
    """Whether a value is a pos: declared as one, `p.trans`, or [x,y,z] beside one."""
    if isinstance(value, ex.Function) and value.name == "pose-angles":
        return value.arguments[3:] == _NO_ANGLES
    return not isinstance(value, RapidAggregate) and type_of(value, names) == "pos"


def is_turn(value: ex.Expression | RapidAggregate, names: RapidNames) -> bool:
    """Whether a value is an orient: declared as one, `p.rot`, OrientZYX(…), or a product of such."""
    match value:
        case ex.Function("pose-angles", arguments):
            return arguments[:3] == _NO_ANGLES != arguments[3:]
        case ex.Function("pose-product", (left, right)):
            return is_turn(left, names) and is_turn(right, names)
        case ex.PositionLiteral(native=native):
            return bool(native) and native[0][0] == "orient"
    return not isinstance(value, RapidAggregate) and type_of(value, names) == "orient"


def turned(left: ex.Expression | RapidAggregate, right: ex.Expression | RapidAggregate) -> ex.Function:
    """The product of two orients: poses at zero, one seen from the other."""
    sides = (_orient(one) if isinstance(one, RapidAggregate) else one for one in (left, right))
    return ex.Function("pose-product", tuple(sides))


def turn_parts(value: ex.Expression | RapidAggregate) -> tuple[ex.Expression, ...]:
    """rx, ry, rz [deg] of an orient."""
    if isinstance(value, RapidAggregate):
        value = _orient(value)
    if isinstance(value, ex.Function) and value.name == "pose-angles" and value.arguments[:3] == _NO_ANGLES:
        return value.arguments[3:6]
    if isinstance(value, ex.PositionLiteral):
        return tuple(ex.Number(v / deg) for v in value.values[3:6])
    return tuple(ex.Member(value, name) for name in _ANGLES)


def place_of(base: ex.Expression) -> ex.Function:
    """`p.trans`: a pose that turns nothing."""
    return ex.Function("pose-angles", (*(ex.Member(base, name) for name in _XYZ), *_NO_ANGLES))


def turn_of(base: ex.Expression) -> ex.Function:
    """`p.rot`: a pose at zero."""
    return ex.Function("pose-angles", (*_NO_ANGLES, *(ex.Member(base, name) for name in _ANGLES)))


def axes_of(base: ex.Expression, group: str) -> ex.RecordLiteral:
    """`j.robax` or `p.extax`: its values one by one."""
    if group == "robax":
        return ex.RecordLiteral(
            "robjoint", tuple((f"rax_{n}", ex.Item(base, (ex.Number(n),))) for n in range(1, _RAX + 1))
        )
    return ex.RecordLiteral(
        "extjoint", tuple((f"eax_{c}", ex.Member(base, f"e{n}")) for n, c in enumerate("abcdef", 1))
    )


def joint_parts(value: ex.Expression | RapidAggregate) -> tuple[ex.Expression, ...]:
    """The six values of a robjoint [deg]. Raises ShapeError."""
    if isinstance(value, RapidAggregate):
        _expect(value, _RAX, "a robjoint")
        return plain_items(value)
    if isinstance(value, ex.RecordLiteral):
        return tuple(item for _, item in value.members)
    return tuple(ex.Member(value, f"rax_{n}") for n in range(1, _RAX + 1))


def _jointtarget(value: RapidAggregate, names: RapidNames) -> ex.Expression:
    _expect(value, 2, "a jointtarget")
    axes, external = numbers(value.items[0], _RAX), numbers(value.items[1], _RAX)
    if axes is not None and external is not None:
        return joint_literal(axes, external)
    first, second = value.items
    parts = joint_parts(first)
    rest = () if external == (NOT_CONNECTED,) * 6 else (_named("axes", second, "extjoint", names),)
    return (
        ex.RecordLiteral("jointtarget", (("joints", ex.Function("joints", parts)), ("axes", rest[0])))
        if rest
        else (ex.Function("joints", parts))
    )


def joint_literal(axes: tuple[float, ...], external: tuple[float, ...]) -> ex.PositionLiteral:
    """Axis values [deg], external axes [mm or deg]."""
    return ex.PositionLiteral("joint", tuple(v * deg for v in axes), connected(external))


_MOST_ZEROS: Final = 2000  # elements of an array whose zeros are written out


def zero(
    kind: str, names: RapidNames, sizes: tuple[ex.Expression, ...] = (), depth: int = 0, plain: bool = False
) -> ex.Expression | None:
    """What a variable without a value holds at first, for structures; None where the type says enough.

    `plain`: also for numbers, truth values and texts.
    """
    kind = names.resolved(kind)
    if sizes:
        counts = [int(one.value) for one in sizes if isinstance(one, ex.Number)]
        one = zero(kind, names, (), depth, plain)
        if one is None or len(counts) != len(sizes) or not 0 < math.prod(counts) <= _MOST_ZEROS:
            return None
        for count in reversed(counts):
            one = ex.RecordLiteral("", (("", one),) * count)
        return one
    if kind in ("robtarget", "pose", "pos", "orient"):
        return ex.PositionLiteral("pose", (0.0,) * 6)
    if kind == "jointtarget":
        return ex.PositionLiteral("joint", (0.0,) * _RAX)
    members = names.members(kind)
    if members is None or depth > _DEEPEST:
        return _PLAIN_ZEROS.get(kind, ex.Number(0) if kind == "num" else None) if plain else None
    values = []
    for name, of in members:
        simple = _PLAIN_ZEROS.get(names.resolved(of), ex.Number(0))
        values.append((name, zero(of, names, (), depth + 1) or simple))
    return ex.RecordLiteral(kind, tuple(values))


def is_text(value: ex.Expression | RapidAggregate, names: RapidNames) -> bool:
    """Whether a value is a text, as far as the file tells."""
    match value:
        case ex.Text():
            return True
        case ex.Function(name, _):
            return name in _TEXTS
        case ex.CallValue(routine, _):
            head = names.routines.get(routine.lower())
            return head is not None and head.returns == "string"
    return isinstance(value, (ex.Named, ex.Item, ex.Member)) and type_of(value, names) == "string"


def type_of(value: ex.Expression | RapidAggregate, names: RapidNames) -> str:
    """RAPID's type of an expression, "" where the file does not tell."""
    match value:
        case ex.Named(name):
            return names.type_of(name)
        case ex.Item(base, _):
            return type_of(base, names)
        case ex.Member(base, name):
            members = names.members(type_of(base, names)) or ()
            return next(
                (names.resolved(of) for member, of in members if member.lower() == name.lower()), "num"
            )
        case ex.Text():
            return "string"
        case ex.SystemValue("current-joints"):
            return "jointtarget"
        case ex.SystemValue("current-pose"):
            return "robtarget"
        case ex.Function(name, _) if name in _POSES:
            return "robtarget"
        case ex.CallValue(routine, _):
            head = names.routines.get(routine.lower())
            return names.resolved(head.returns) if head is not None else ""
    return ""


# --- Texts ---
# RAPID's string literals: quotes and backslashes are doubled, other characters may be two hexadecimal digits.

_ESCAPE: Final = re.compile(r'""|\\\\|\\([0-9A-Fa-f]{2})')
_SPECIAL: Final = re.compile(r'["\\\x00-\x1f]')


def unquoted(literal: str) -> str:
    """The text of a literal with its quotes."""
    return _ESCAPE.sub(lambda m: chr(int(m[1], 16)) if m[1] else m[0][0], literal[1:-1])


def quoted(text: str) -> str:
    """The literal of a text."""

    def escaped(match: re.Match[str]) -> str:
        character = match[0]
        return character * 2 if character in '"\\' else f"\\{ord(character):02X}"

    return f'"{_SPECIAL.sub(escaped, text)}"'
