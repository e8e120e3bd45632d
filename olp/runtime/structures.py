"""Elements of arrays, members of records and components of positions: read and written."""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import lru_cache

import numpy as np

from olp.core.units import deg, mm
from olp.ir.expressions import Expression, Item, Member, Named, PositionLiteral, Unknown, Variable
from olp.ir.points import PointKind, PointState, Sector
from olp.robots.geometry import Pose, quaternion_from_rotation
from olp.runtime.evaluate import copied, evaluate, find_slot, fitted, note_change, whole
from olp.runtime.memory import ACTIVE, Array, AssumedResult, PositionValue, Record, Value
from olp.runtime.spelling import spell
from olp.runtime.state import Machine, StatementError

_POSE, _AXES = PointKind.POSE, PointKind.JOINT  # looked up once: every component asks
_JOINT = PointState(PointKind.JOINT, "joint")
_EXTERNAL = "extax"  # the axes beside the arm as a whole
_COMPONENTS = ("x", "y", "z", "rx", "ry", "rz")
_WHOLE = Unknown("")  # an index that is left out
_SCALES = (mm, mm, mm, deg, deg, deg)
# Types that are no structure, or one whose missing members a run may not leave open.
_NUMBERS_AND_TEXTS = ("", "integer", "real", "boolean", "string", "character", "signal", "clock")
_NO_STRUCTURES = frozenset((*_NUMBERS_AND_TEXTS, "position", "joints", "tool", "frame", "speed", "zone"))
# Numbers of seven digits, as controllers compute, give Ry to 0.03 degrees there.
_SPLIT_FROM, _SPLIT = math.sin(0.03 * deg), 7.3 * deg
_TURNS = ("q1", "q2", "q3", "q4", "rotation1", "rotation2", "rotation3")


def literal_position(e: PositionLiteral) -> PositionValue:
    """A position written out; a pose stands in the frame that holds when it is moved to."""
    if e.kind == _AXES:
        return PositionValue(_JOINT, e.values, e.external)
    return PositionValue(_written_state(e.configuration, e.sectors), e.values, e.external)


@lru_cache(maxsize=4096)
def _written_state(
    configuration: tuple[int, ...], sectors: tuple[tuple[int, float, float], ...]
) -> PointState:
    """One object for all positions that are written alike, because every move asks."""
    told = tuple(Sector(*one) for one in sectors)
    return PointState(PointKind.POSE, ACTIVE, configuration=configuration, sectors=told)


def pose_value(pose: Pose) -> PositionValue:
    """A computed pose as a value, in the frame that holds when it is moved to."""
    return PositionValue(PointState(PointKind.POSE, ACTIVE), tuple(float(v) for v in pose.xyz_angles()))


def _set_by_controller(m: Machine, base: Expression) -> str:
    """The name of an array that the controller sets and no file declares, "" for another."""
    name = base.name if isinstance(base, Named) else ""
    return name if m.conventions.is_controllers(name) and find_slot(m, name) is None else ""


def read_item(m: Machine, e: Item) -> Value:
    """An element; of joint values in degrees. Raises StatementError (I223) outside of the array."""
    value = evaluate(m, e.base)
    if _set_by_controller(m, e.base):
        return value  # of an array that the controller sets, each element is what is assumed of it
    for index in _indices(m, e):
        value = _element(value, index, e)
    return value


def _element(value: Value, index: int, e: Item) -> Value:
    items: list[Value | None]
    if isinstance(value, AssumedResult):
        return value
    if isinstance(value, Array):
        items = value.items
    elif isinstance(value, PositionValue) and value.state.kind is _AXES:
        items = [v / deg for v in value.values]
    elif isinstance(value, PositionValue):
        items = [v / scale for v, scale in zip(value.values, _SCALES, strict=False)]
    elif isinstance(value, str):
        items = list(value)
    else:
        raise StatementError("I223", f"{spell(e.base)} has no elements", "name an array")
    if not 1 <= index <= len(items):
        raise StatementError(
            "I223", f"{spell(e)} is outside of the array, which has {len(items)} elements", "check the index"
        )
    found = items[index - 1]
    if found is None:
        raise StatementError("I203", f"{spell(e)} has no value yet", "give it one before it is used")
    return found


def _indices(m: Machine, e: Item) -> list[int]:
    """The indices that are there: `NAMES[2,]` is a row as a whole."""
    return [whole(m, index) for index in e.indices if type(index) is not Unknown or index != _WHOLE]


def read_member(m: Machine, e: Member) -> Value:
    """A component of a position [mm, deg], or a member of a record. Raises StatementError (I224) for another name."""
    value = evaluate(m, e.base)
    if isinstance(value, Record):
        for name, member in value.members.items():
            if name.casefold() == e.name.casefold():
                return member
        if value.partial:
            raise StatementError("I203", f"{spell(e)} has no value yet", "give it one before it is used")
    if isinstance(value, PositionValue):
        return _component(m, value, e)
    raise StatementError("I224", f"{spell(e.base)} has no member {e.name}", "check the name")


def _component(m: Machine, value: PositionValue, e: Member) -> float:
    name = _name(value, e)
    if value.state.kind is _POSE and name in _COMPONENTS:
        index = _COMPONENTS.index(name)
        if index >= 3 and m.conventions.whole_turns:
            return angles_of_turn(value.values[3:6], m.made_up is not None)[index - 3] / deg
        return value.values[index] / _SCALES[index]
    if value.state.kind is _POSE and name in _TURNS:
        return _turn(value, name)
    if name[:1] == "e" and name[1:].isdigit():
        index = int(name[1:]) - 1
        return value.external[index] if index < len(value.external) else 0.0
    if value.state.kind is _AXES and name[:1] in "aj" and name[1:].isdigit():
        index = int(name[1:]) - 1
        if index < len(value.values):
            return value.values[index] / deg
    raise StatementError("I224", f"{spell(e.base)} has no component {e.name}", "check the name")


def angles_of_turn(angles: Sequence[float], compared: bool = False) -> tuple[float, float, float]:
    """Rx, Ry, Rz [rad] as a controller computes them that holds the turn `angles` (3) as one value.

    Ry is within 90 degrees. There the turn tells only Rx - Rz (at -90 Rx + Rz), and no manual says what a controller
    makes of it: where two programs are `compared`, they are 7.3 degrees from what is usual, so that it shows if
    anything hangs on them.
    """
    rx, ry, rz = angles
    if abs(math.cos(ry)) < _SPLIT_FROM:
        up = math.copysign(1.0, math.sin(ry))
        by = _SPLIT if compared else 0.0
        return rx - up * rz + by, math.asin(math.sin(ry)), up * by
    if math.cos(ry) < 0.0:
        rx, ry, rz = rx + math.pi, math.pi - ry, rz + math.pi
    return _within(rx), _within(ry), _within(rz)


def _within(angle: float) -> float:
    return angle if -math.pi < angle <= math.pi else math.remainder(angle, 2 * math.pi)


def _name(value: PositionValue, e: Member) -> str:
    """The component, lower case; of a register that holds joint values the second is axis 2."""
    name = e.name.lower()
    if value.state.kind is _AXES and isinstance(e.base, Variable) and name in _COMPONENTS:
        return f"j{_COMPONENTS.index(name) + 1}"
    return name


def _turn(value: PositionValue, name: str) -> float:
    if name[0] == "q":
        return _quaternion(value)[int(name[1]) - 1]
    return float(rotation_vector(Pose.from_xyz_angles(value.values[:6]))[int(name[-1]) - 1])


def _quaternion(value: PositionValue) -> list[float]:
    """As it was written where nothing has changed the angles since."""
    if value.written_turn[4:] == value.values[3:6]:
        return list(value.written_turn[:4])
    rotation = Pose.from_xyz_angles(value.values[:6]).rotation
    return [float(v) for v in quaternion_from_rotation(rotation[None])[0]]


def rotation_vector(pose: Pose) -> np.ndarray[tuple[int], np.dtype[np.float64]]:
    """(3,) [rad]: the axis times the angle, 0 to pi."""
    w, *v = (float(x) for x in quaternion_from_rotation(pose.rotation[None])[0])
    if w < 0:
        w, v = -w, [-x for x in v]
    sine = math.sqrt(sum(x * x for x in v))
    angle = 2.0 * math.atan2(sine, w)
    return np.array(v) * (angle / sine if sine > 0 else 2.0)


def pose_of_rotation_vector(x: float, y: float, z: float, vector: tuple[float, float, float]) -> Pose:
    """The pose at x y z [m] turned by a rotation vector [rad]."""
    from olp.robots.geometry import rotation_from_quaternion

    angle = math.sqrt(sum(v * v for v in vector))
    half = math.sin(angle / 2) / angle if angle > 0 else 0.5
    quaternion = np.array([[math.cos(angle / 2), *(v * half for v in vector)]])
    return Pose(np.array([x, y, z]), rotation_from_quaternion(quaternion)[0])


def write_item(m: Machine, target: Item, value: Value) -> None:
    """Stores an element. Raises StatementError (I223) outside of the array."""
    base = target.base
    if type(value) is float and isinstance(base, Named) and (slot := find_slot(m, base.name)) is not None:
        value = fitted(slot.type, value)
    if own := _set_by_controller(m, base):
        m.assume(f"{own} is set: nothing that is timed depends on it")
        return
    indices = _indices(m, target)
    if not indices:  # the array as a whole, `name[]` or `name[,]`
        m.operations.store(m, target.base, value)
        return
    *before, last = indices
    held = evaluate(m, target.base)
    for index in before:
        held = _element(held, index, target)
    if isinstance(held, Array):
        if not 1 <= last <= len(held.items):
            says = f"{spell(target)} is outside of the array, which has {len(held.items)} elements"
            raise StatementError("I223", says, "check the index")
        new = copied(value)
        if held.items[last - 1] != new:
            _changed(m, target.base, None if before else last)
        held.items[last - 1] = new
    elif isinstance(held, PositionValue) and not before and 1 <= last <= len(held.values):
        if not isinstance(value, (int, float)):
            raise StatementError("I204", "an element of a position holds a number", "check the value")
        scales = (deg,) * len(held.values) if held.state.kind is _AXES else _SCALES
        m.operations.store(m, target.base, _replaced(held, last - 1, value * scales[last - 1]))
    else:
        raise StatementError("I223", f"{spell(target.base)} has no such element", "name an array")


def write_member(m: Machine, target: Member, value: Value) -> None:
    """Stores a component of a position [mm, deg] or a member of a record."""
    name = target.name.lower()
    try:
        old = evaluate(m, target.base)
    except StatementError as found:
        if _is_structure(m, target.base) and found.code == "I203":
            old = Record("", {}, partial=True)
        elif name in _COMPONENTS:
            old = PositionValue(PointState(PointKind.POSE, ACTIVE), (0.0,) * 6)
        else:
            raise
    if isinstance(old, Record):
        known = next((key for key in old.members if key.casefold() == name), target.name)
        new = copied(value)
        if old.members.get(known) != new:
            _changed(m, target.base)
        old.members[known] = new
        m.operations.store(m, target.base, old)
        return
    if isinstance(old, PositionValue) and name == _EXTERNAL and isinstance(value, Record):
        axes = [float(v) for v in value.members.values() if isinstance(v, (int, float))]
        m.operations.store(m, target.base, old._replace(external=tuple(axes)))
        return
    if not isinstance(old, PositionValue) or not isinstance(value, (int, float)):
        raise StatementError("I224", f"{spell(target.base)} has no member {target.name}", "check the name")
    m.operations.store(m, target.base, _with_component(old, target, _name(old, target), float(value)))


def _is_structure(m: Machine, e: Expression) -> bool:
    """Whether a variable, or its elements, are of a type of the program's own."""
    base = e.base if isinstance(e, Item) else e
    slot = find_slot(m, base.name) if isinstance(base, Named) else None
    return slot is not None and slot.type not in _NO_STRUCTURES


def _with_component(old: PositionValue, target: Member, name: str, value: float) -> PositionValue:
    if old.state.kind is _POSE and name in _COMPONENTS:
        index = _COMPONENTS.index(name)
        return _replaced(old, index, value * _SCALES[index])
    if old.state.kind is _POSE and name in _TURNS:
        return _turned(old, name, value)
    if name[:1] == "e" and name[1:].isdigit():
        index = int(name[1:]) - 1
        external = list(old.external) + [0.0] * (index + 1 - len(old.external))
        external[index] = value
        return old._replace(external=tuple(external))
    if old.state.kind is _AXES and name[:1] in "aj" and name[1:].isdigit():
        index = int(name[1:]) - 1
        if 0 <= index < len(old.values):
            return _replaced(old, index, value * deg)
    raise StatementError("I224", f"{spell(target.base)} has no component {target.name}", "check the name")


def _turned(old: PositionValue, name: str, value: float) -> PositionValue:
    """One number of the turn changed."""
    pose = Pose.from_xyz_angles(old.values[:6])
    if name[0] == "q":
        return _with_quaternion(old, pose, int(name[1]) - 1, value)
    v = [float(x) for x in rotation_vector(pose)]
    v[int(name[-1]) - 1] = value
    x, y, z = (float(p) for p in pose.position)
    turned = pose_of_rotation_vector(x, y, z, (v[0], v[1], v[2]))
    return old._replace(values=tuple(float(x) for x in turned.xyz_angles()) + old.values[6:])


def _with_quaternion(old: PositionValue, pose: Pose, index: int, value: float) -> PositionValue:
    """The numbers stay as written, since others are to follow; the turn is that of unit length."""
    from olp.robots.geometry import rotation_from_quaternion

    q = _quaternion(old)
    q[index] = value
    size = math.sqrt(sum(v * v for v in q))
    if size > 0.0:
        pose = Pose(pose.position, rotation_from_quaternion(np.array([[v / size for v in q]]))[0])
    values = tuple(float(v) for v in pose.xyz_angles()) + old.values[6:]
    return old._replace(values=values, written_turn=(*q, *values[3:6]))


def _replaced(old: PositionValue, index: int, value: float) -> PositionValue:
    values = list(old.values)
    values[index] = value
    return PositionValue(
        old.state, tuple(values), old.external, old.written_turn
    )  # a third of _replace's time


def _changed(m: Machine, target: Expression, element: int | None = None) -> None:
    """Tells the loops that wait for it which variable has changed inside; `element`: only that one of `target`."""
    while isinstance(target, (Item, Member)):
        target, element = target.base, None
    if isinstance(target, Named):
        note_change(m, target.name, element)
