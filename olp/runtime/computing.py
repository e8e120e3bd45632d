"""Functions in expressions: of numbers, texts and arrays, and of poses in millimetres and degrees."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence

import numpy as np

from olp.core.units import deg, mm
from olp.ir.expressions import Expression, Function, Named, NamedArgument, Store, Taught
from olp.ir.points import PointKind, PointState
from olp.robots.geometry import (
    Pose,
    quaternion_from_rotation,
    rotation_from_angles,
    rotation_from_quaternion,
    slerp,
)
from olp.runtime.data import FUNCTIONS
from olp.runtime.evaluate import evaluate, finite, number, round_half_away, whole
from olp.runtime.memory import Array, AssumedResult, PositionValue, Value
from olp.runtime.poses import as_position, raw_pose, with_pose
from olp.runtime.spelling import spell
from olp.runtime.state import Machine, StatementError
from olp.runtime.structures import angles_of_turn, pose_of_rotation_vector, pose_value, rotation_vector

Arguments = Sequence[Expression]
Computes = Callable[[Machine, Arguments], Value]


def _numbers(m: Machine, arguments: Arguments, count: int) -> list[float]:
    """Exactly `count` numbers. Raises StatementError (I222)."""
    if len(arguments) < count:
        raise StatementError(
            "I222", f"this needs {count} values, and {len(arguments)} are given", "write them all"
        )
    return [float(number(m, argument)) for argument in arguments[:count]]


def _plain(function: Callable[..., float], count: int = 1) -> Computes:
    """A function of numbers. Raises StatementError (I202) where it has no value."""

    def computed(m: Machine, arguments: Arguments) -> Value:
        values = _numbers(m, arguments, count)
        try:
            return finite(function(*values))
        except (ValueError, OverflowError, ZeroDivisionError):
            shown = ", ".join(f"{value:g}" for value in values)
            raise StatementError(
                "I202", f"there is no such value for {shown}", "check the operands"
            ) from None

    return computed


def _to_decimals(whole_of: Callable[[float], int]) -> Computes:
    """A function that rounds to whole numbers, or to as many decimals as a second argument says."""

    def computed(m: Machine, arguments: Arguments) -> Value:
        value = float(number(m, arguments[0]))
        digits = whole(m, arguments[1]) if len(arguments) > 1 else 0
        if digits <= 0:
            return whole_of(value)
        scale: float = 10.0 ** min(digits, 15)
        if not math.isfinite(value * scale):
            return value  # so large a number has no decimals
        return whole_of(float(f"{value * scale:.12g}")) / scale  # 0.29 is no 28.999… hundredths

    return computed


def _largest(choose: Callable[[list[float]], float]) -> Computes:
    def chosen(m: Machine, arguments: Arguments) -> Value:
        return choose([number(m, argument) for argument in arguments])

    return chosen


def _pose(m: Machine, argument: Expression) -> PositionValue:
    return as_position(evaluate(m, argument))


def _moved(value: PositionValue, pose: Pose) -> Value:
    return with_pose(value, pose)


def _offset(m: Machine, arguments: Arguments) -> Value:
    """The pose moved along the axes of its frame, with the same orientation."""
    value = _pose(m, arguments[0])
    by = np.array(_numbers(m, arguments[1:], 3)) * mm
    pose = raw_pose(value)
    return _moved(value, Pose(pose.position + by, pose.rotation))


def _relative_tool(m: Machine, arguments: Arguments) -> Value:
    """The pose moved along and turned about its own axes: about x, the new y, the new z (RAPID RelTool)."""
    value = _pose(m, arguments[0])
    x, y, z = _numbers(m, arguments[1:], 3)
    given = [float(number(m, argument)) * deg for argument in arguments[4:7]]
    rx, ry, rz = (*given, *[0.0] * (3 - len(given)))
    turn = np.eye(3)
    for axis, angle in enumerate((rx, ry, rz)):
        turn = turn @ rotation_from_angles(np.eye(3)[axis] * angle)
    return _moved(value, raw_pose(value) @ Pose(np.array([x, y, z]) * mm, turn))


def _added(m: Machine, arguments: Arguments) -> Value:
    """Positions are added, rotations are composed (URScript pose_add)."""
    value, other = _pose(m, arguments[0]), _pose(m, arguments[1])
    first, second = raw_pose(value), raw_pose(other)
    return _moved(value, Pose(first.position + second.position, first.rotation @ second.rotation))


def _subtracted(m: Machine, arguments: Arguments) -> Value:
    """The pose that pose_add adds to the second to give the first (URScript pose_sub)."""
    value, other = _pose(m, arguments[0]), _pose(m, arguments[1])
    first, second = raw_pose(value), raw_pose(other)
    return _moved(value, Pose(first.position - second.position, second.rotation.T @ first.rotation))


def _of_angles(m: Machine, arguments: Arguments) -> Value:
    values = _numbers(m, arguments, 6)
    scaled = [v * (mm if i < 3 else deg) for i, v in enumerate(values)]
    # Kept as written: a rotation matrix would give other angles of the same orientation.
    return PositionValue(pose_value(Pose.identity()).state, tuple(scaled))


def _of_quaternion(m: Machine, arguments: Arguments) -> Value:
    x, y, z, *q = _numbers(m, arguments, 7)
    size = math.sqrt(sum(v * v for v in q))
    if size == 0.0:
        raise StatementError("I202", "a quaternion of zeros is no turn", "write 1, 0, 0, 0 for none")
    if not math.isfinite(size):
        raise StatementError("I202", "the quaternion is too large for a turn", "check the operands")
    return pose_value(
        Pose(np.array([x, y, z]) * mm, rotation_from_quaternion(np.array([[v / size for v in q]]))[0])
    )


def _of_vector(m: Machine, arguments: Arguments) -> Value:
    x, y, z, rx, ry, rz = _numbers(m, arguments, 6)
    if not math.isfinite(rx * rx + ry * ry + rz * rz):
        raise StatementError("I202", "the rotation vector is too long for a turn", "check the operands")
    return pose_value(pose_of_rotation_vector(x, y, z, (rx, ry, rz)))


def _joints(m: Machine, arguments: Arguments) -> Value:
    values = [evaluate(m, a) for a in arguments if type(a) is not NamedArgument]
    if len(values) == 1 and isinstance(values[0], Array):
        values = [item for item in values[0].items if item is not None]
    angles = tuple(float(v) * deg for v in values if isinstance(v, (int, float)))
    if len(angles) != len(values) or not angles:
        raise StatementError("I201", "joint values are numbers", "write one per axis")
    return PositionValue(PointState(PointKind.JOINT, "joint"), angles)


def _systems(arguments: Arguments) -> tuple[Expression | None, Expression | None]:
    """The tool and the frame that a function names."""
    named = {a.name.casefold(): a.value for a in arguments if isinstance(a, NamedArgument)}
    return named.get("tool"), named.get("wobj")


def _forward(m: Machine, arguments: Arguments) -> Value:
    from olp.runtime.places import current, pose_at

    return pose_at(m, _pose(m, arguments[0]), *_systems(arguments)) if arguments else current(m, joints=False)


def _inverse(m: Machine, arguments: Arguments) -> Value:
    """The axes of a pose, or the pose itself where no robot is known: a joint move goes to it as well."""
    from olp.runtime.places import joints_near, joints_of

    value = _pose(m, arguments[0])
    systems = _systems(arguments)
    if len(arguments) > 1 and systems == (None, None):
        near = evaluate(m, arguments[1])
        if isinstance(near, PositionValue) and near.state.kind is PointKind.JOINT:
            try:
                return joints_near(m, value, near)
            except StatementError:
                says = "the joint values that a program gives beside a pose are taken to reach it"
                m.assume_once("nearest joints", says)
                return near
    try:
        return joints_of(m, value, None, *systems)
    except StatementError:
        return value


def _distance(m: Machine, arguments: Arguments) -> Value:
    first, second = (raw_pose(_pose(m, argument)).position for argument in arguments[:2])
    return float(np.linalg.norm(first - second)) / mm


def _current(joints: bool) -> Computes:
    def where(m: Machine, arguments: Arguments) -> Value:
        from olp.runtime.places import current

        return current(m, joints, *_systems(arguments))

    return where


def _interpolated(m: Machine, arguments: Arguments) -> Value:
    """The pose on the straight line from the first pose to the second, at a share of 0 to 1 of its length."""
    value, other = _pose(m, arguments[0]), _pose(m, arguments[1])
    share = float(number(m, arguments[2]))
    first, second = raw_pose(value), raw_pose(other)
    turns = [quaternion_from_rotation(pose.rotation[None])[0] for pose in (first, second)]
    turn = rotation_from_quaternion(slerp(turns[0][None], turns[1][None], np.array([share])))[0]
    return _moved(value, Pose(first.position + share * (second.position - first.position), turn))


def _element(m: Machine, arguments: Arguments) -> Value:
    """A number of a pose as URScript counts them from 1: metres, then the rotation vector [rad]."""
    pose = raw_pose(_pose(m, arguments[0]))
    numbers = [*pose.position.tolist(), *rotation_vector(pose).tolist()]
    index = whole(m, arguments[1])
    if not 1 <= index <= len(numbers):
        raise StatementError("I223", f"a pose has no element {index}", "write 1 .. 6")
    return float(numbers[index - 1])


def _angles_of_vector(m: Machine, arguments: Arguments) -> Value:
    """Roll, pitch and yaw [rad] of a rotation vector."""
    pose = pose_of_rotation_vector(0.0, 0.0, 0.0, _three(m, arguments[0]))
    return _list(angles_of_turn(pose.xyz_angles()[3:].tolist(), m.made_up is not None))


def _vector_of_angles(m: Machine, arguments: Arguments) -> Value:
    """The rotation vector [rad] of roll, pitch and yaw."""
    turn = rotation_from_angles(np.array(_three(m, arguments[0])))
    return _list(rotation_vector(Pose(np.zeros(3), turn)))


def _three(m: Machine, e: Expression) -> tuple[float, float, float]:
    value = evaluate(m, e)
    items = value.items if isinstance(value, Array) else []
    found = [float(v) for v in items if isinstance(v, (int, float)) and math.isfinite(v)]
    if len(found) != len(items) or len(found) != 3:
        raise StatementError("I222", "a turn has three numbers", "write a list of three")
    return found[0], found[1], found[2]


def _list(values: Iterable[float]) -> Array:
    return Array([float(v) for v in values])


def _length(m: Machine, arguments: Arguments) -> Value:
    value = evaluate(m, arguments[0])
    if isinstance(value, (Array, str)):
        return len(value.items if isinstance(value, Array) else value)
    return len(value.values) if isinstance(value, PositionValue) else 0


def _norm(m: Machine, arguments: Arguments) -> Value:
    value = evaluate(m, arguments[0])
    if isinstance(value, Array):
        return math.sqrt(sum(float(v) ** 2 for v in value.items if isinstance(v, (int, float))))
    return abs(number(m, arguments[0]))


def _given(m: Machine, arguments: Arguments) -> Value:
    from olp.runtime.evaluate import is_given

    name = arguments[0]
    return is_given(m, name.name if isinstance(name, Named) else spell(name))


_MOST_DIMENSIONS = 3  # of an array (RAPID overview)


def _size(m: Machine, arguments: Arguments) -> Value:
    """How many elements a dimension of an array has, which is counted from 1."""
    value, dimension = evaluate(m, arguments[0]), whole(m, arguments[1])
    for _ in range(dimension - 1 if dimension <= _MOST_DIMENSIONS else 0):
        value = (value.items[0] or 0) if isinstance(value, Array) and value.items else 0
    if not 1 <= dimension <= _MOST_DIMENSIONS or not isinstance(value, Array):
        says = f"{spell(arguments[0])} has no dimension {dimension}"
        raise StatementError("I223", says, "name an array and one of its dimensions")
    return len(value.items)


def _clock(m: Machine, given: Sequence[Expression]) -> Value:
    m.assume(f"the clock {spell(given[0])} is taken to stand at 0")
    return 0


def _zone_or_stop(m: Machine, arguments: Arguments) -> Value:
    """The size of a zone, 0 where a member of it says that the move stops."""
    return 0 if evaluate(m, arguments[0]) else evaluate(m, arguments[1])


_FURTHER: Mapping[str, Computes] = {
    "timer": _clock,
    "abs": _plain(abs),
    "tan": _plain(lambda x: math.tan(x * deg)),
    "asin": _plain(lambda x: math.asin(x) / deg),
    "acos": _plain(lambda x: math.acos(x) / deg),
    "atan2": _plain(lambda y, x: math.atan2(y, x) / deg, 2),
    "round": _to_decimals(round_half_away),
    "trunc": _to_decimals(int),
    "floor": _plain(lambda x: math.floor(x)),
    "ceil": _plain(lambda x: math.ceil(x)),
    "power": _plain(lambda x, y: float(x**y), 2),
    "exp": _plain(math.exp),
    "log": _plain(math.log),
    "log10": _plain(math.log10),
    "zone-or-stop": _zone_or_stop,
    "min": _largest(min),
    "max": _largest(max),
    "pose-offset": _offset,
    "pose-relative-tool": _relative_tool,
    "pose-add": _added,
    "pose-subtract": _subtracted,
    "pose-angles": _of_angles,
    "pose-quaternion": _of_quaternion,
    "pose-vector": _of_vector,
    "pose-distance": _distance,
    "joints": _joints,
    "forward": _forward,
    "inverse": _inverse,
    "given": _given,
    "size-of-array": _size,
    "pose-interpolate": _interpolated,
    "pose-element": _element,
    "length": _length,
    "get_list_length": _length,
    "norm": _norm,
    "rotvec2rpy": _angles_of_vector,
    "rpy2rotvec": _vector_of_angles,
    "get_steptime": lambda m, arguments: 0.002,  # e-Series: 500 Hz
    "taught": lambda m, arguments: evaluate(m, Taught(Store.ROBOT, whole(m, arguments[0]))),
    "current-pose": _current(joints=False),
    "current-joints": _current(joints=True),
    "NumToDnum": lambda m, arguments: number(m, arguments[0]),
    "DnumToNum": lambda m, arguments: number(m, arguments[0]),
}

_LEAST_ARGUMENTS: Mapping[str, int] = {
    "pose-add": 2,
    "pose-distance": 2,
    "pose-element": 2,
    "pose-interpolate": 3,
    "pose-product": 2,
    "pose-subtract": 2,
    "shift-between": 2,
    "part-of-text": 2,
    "position-in-text": 2,
    "match-in-text": 3,
    "find-in-text": 3,
    "same-text": 2,
    "size-of-array": 2,
    "joined-text": 0,
    "parameter": 0,
    "get_steptime": 0,
}


def call_function(m: Machine, e: Function) -> Value:
    """The function's value. Raises StatementError for one that is not known, or has too few arguments."""
    function = FUNCTIONS.get(e.name) or _FURTHER.get(e.name)
    if function is None and not m.conventions.known_functions:
        taken = 0 if m.made_up is None else m.made_up.result(e.name)
        m.assume(f"{e.name[:60]} is not known here: its value is taken as {str(taken).lower()}")
        return taken if isinstance(taken, bool) else AssumedResult(taken)
    if function is None:
        raise StatementError("I216", f"{e.name} is not known to the interpreter", "check its name")
    least = _LEAST_ARGUMENTS.get(e.name, 1)
    if len(e.arguments) < least:
        says = (
            f"this needs {least} value{'s' * (least > 1)} to compute with, and {len(e.arguments)} are given"
        )
        raise StatementError("I222", says, "name what to compute with, behind the variable of the result")
    return function(m, e.arguments)
