"""Statements that compute (assignments, arithmetic, frames, shifts), and the built-in functions.

Positions and their elements are computed in the controller's own whole units.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Any

from olp.core.units import deg, um
from olp.ir import expressions as ex
from olp.ir import program as st
from olp.ir.points import PointKind, PointState
from olp.robots.geometry import Pose, frame_from_points
from olp.runtime.evaluate import (
    both,
    calculate,
    check_divisor,
    evaluate,
    number,
    read_variable,
    round_half_away,
    whole,
    write_name,
    write_variable,
)
from olp.runtime.memory import ACTIVE, INTEGERS, PositionValue, SystemPosition, Value, zero
from olp.runtime.poses import (
    as_pose,
    as_position,
    as_pulses,
    frame_pose,
    frame_state,
    number_of,
    own_frame,
    pose_of,
    position_value,
    product,
    raw_pose,
    with_pose,
)
from olp.runtime.signals import read_signal, write_signal
from olp.runtime.spelling import spell
from olp.runtime.state import Machine, Shift, StatementError, role
from olp.runtime.structures import write_item, write_member

Arguments = Sequence[ex.Expression]
_MOST_DECIMALS = 1_100  # no number has more


def frame_value(m: Machine, frame: ex.FrameRef) -> Value:
    """A frame as a position in the base."""
    return with_pose(PositionValue(PointState(PointKind.POSE, "base"), ()), frame_pose(m, frame))


def set_tool(m: Machine, argument: ex.Expression, value: Value) -> None:
    """Gives a tool new data; what was recorded with the old ones keeps them."""
    tool = whole(m, argument)
    m.tool_now[tool] = number_of(m, "tool", raw_pose(as_position(value)))
    m.plain = False


def set_frame(m: Machine, frame: ex.FrameRef, pose: Pose) -> None:
    """Gives a user frame a new place; what was recorded in the old one stays where it was."""
    user = whole(m, frame.number) if frame.number is not None else 0
    m.user_now[user] = number_of(m, "user", pose)
    m.plain = False


def _position(m: Machine, e: ex.Expression) -> PositionValue:
    return as_position(evaluate(m, e))


def _square_root(m: Machine, arguments: Arguments) -> Value:
    value = number(m, arguments[0])
    if value < 0:
        raise StatementError(
            "I202", f"{value:g} has no square root", "the controller stops with an alarm here"
        )
    return math.sqrt(value)


def _angle(function: Callable[[float], float]) -> Callable[[Machine, Arguments], Value]:
    return lambda m, arguments: function(number(m, arguments[0]) * deg)


def _arc_tangent(m: Machine, arguments: Arguments) -> Value:
    return math.atan(number(m, arguments[0])) / deg


def _product(m: Machine, arguments: Arguments) -> Value:
    first, second = (_position(m, argument) for argument in arguments[:2])
    if first.state.frame == ACTIVE:  # components that the second one leaves out do not move
        second = second._replace(values=tuple(0.0 if math.isnan(v) else v for v in second.values))
    state, other = first.state, second.state
    if other.configuration and (state.configuration, state.sectors) != (other.configuration, other.sectors):
        state = replace(state, configuration=other.configuration, sectors=other.sectors)
    return product(first, second, state)


def _inverse(m: Machine, arguments: Arguments) -> Value:
    value = _position(m, arguments[0])
    return with_pose(value, raw_pose(value).inverse())


def _convert(m: Machine, arguments: Arguments) -> Value:
    """A position in another frame, or in pulses; a tool may be named for it."""
    value = evaluate(m, arguments[0])
    frames = [a for a in arguments[1:] if isinstance(a, ex.FrameRef)]
    tool = next((f for f in frames if f.kind == "tool" and f.number is not None), None)
    frame = next((f for f in frames if f is not tool), ex.FrameRef("pulse"))
    if not isinstance(value, SystemPosition):
        return _converted(m, _position(m, arguments[0]), frame, tool)
    parts = tuple(
        (store, _converted(m, part, frame, tool) if store is ex.Store.ROBOT else part)
        for store, part in value.parts
    )
    return SystemPosition(parts)


def _converted(
    m: Machine, value: PositionValue, frame: ex.FrameRef, tool: ex.FrameRef | None
) -> PositionValue:
    from olp.runtime.state import role

    mechanism = role(m, 0, ex.Store.ROBOT)
    if tool is not None and tool.number is not None:
        number_ = whole(m, tool.number)
        if value.state.kind is PointKind.POSE:
            # The flange stays where it is: seen at another tool's centre point.
            value = as_pulses(m, mechanism, value)
        value = PositionValue(replace(value.state, tool=number_), value.values)
    if frame.kind == "pulse":
        return as_pulses(m, mechanism, value)
    return as_pose(m, mechanism, value, frame)


def _tool_data(m: Machine, arguments: Arguments) -> Value:
    tool = whole(m, arguments[0])
    pose = m.world.cell.tool_pose(m.tool_now.get(tool, tool))
    state = PointState(PointKind.POSE, "tool", tool=tool)
    return with_pose(PositionValue(state, ()), pose)


def _step_position(m: Machine, arguments: Arguments) -> Value:
    """The position that the n-th move of this routine is taught at."""
    from olp.runtime.poses import position_value

    wanted = whole(m, arguments[0])
    moves = [s for s in m.frame.job.body if isinstance(s, st.Move)]
    if not 1 <= wanted <= len(moves):
        raise StatementError("I217", f"the routine has no step {wanted}", f"it has {len(moves)} moves")
    step = moves[wanted - 1]
    written = [*step.targets, *(t for part in step.parts for t in part.targets)]
    parts = [
        (p.store, position_value(m, p, p.store)) for p in written if isinstance(p, (ex.Taught, ex.Variable))
    ]
    return SystemPosition(tuple(parts))


def _shift_between(m: Machine, arguments: Arguments) -> Value:
    """The shift that takes the first position to the second, along the axes of a frame."""
    from olp.runtime.state import role

    frame = next((a for a in arguments if isinstance(a, ex.FrameRef)), ex.FrameRef("base"))
    positions = [_position(m, a) for a in arguments if not isinstance(a, ex.FrameRef)]
    if len(positions) < 2:  # two arguments may be one position and a frame
        raise StatementError("I213", "a shift needs two positions", "name the reference and the target")
    mechanism = role(m, 0, ex.Store.ROBOT)
    first, second = (pose_of(m, mechanism, p) for p in positions[:2])
    axes = first.rotation if frame.kind == "tool" else frame_pose(m, frame).rotation
    turn = axes.T @ second.rotation @ first.rotation.T @ axes
    shift = Pose(axes.T @ (second.position - first.position), turn)
    return with_pose(PositionValue(PointState(PointKind.POSE, frame.kind), ()), shift)


def _convert_shift(m: Machine, arguments: Arguments) -> Value:
    """A shift along the axes of its own frame as the same shift along the axes of another one."""
    value = _position(m, arguments[0])
    frame = next((a for a in arguments[1:] if isinstance(a, ex.FrameRef)), ex.FrameRef("base"))
    if frame.kind not in ("base", "robot", "user"):
        m.assume(f"a shift converted into the {frame.kind} frame is taken unchanged")
        return value
    shift, own, other = raw_pose(value), own_frame(m, value.state).rotation, frame_pose(m, frame).rotation
    into = other.T @ own
    state = frame_state(m, frame, value.state)
    return with_pose(value, Pose(into @ shift.position, into @ shift.rotation @ into.T), state)


def _text_value(m: Machine, arguments: Arguments) -> Value:
    text = _text(m, arguments[0]).strip()
    try:
        return float(text) if "." in text else int(text)
    except ValueError:
        raise StatementError("I204", f"the text {text[:40]!r} is not a number", "check the text") from None


def _text(m: Machine, e: ex.Expression) -> str:
    value = evaluate(m, e)
    if isinstance(value, str):
        return value
    if isinstance(value, (int, float)) and not isinstance(value, bool):
        return str(value)
    raise StatementError("I204", f"{spell(e)} is not a text", "use a string variable")


def _shown(m: Machine, arguments: Arguments) -> Value:
    """A value as a text; of a number with as many decimals as the second argument says."""
    value = evaluate(m, arguments[0])
    if isinstance(value, bool):
        return "TRUE" if value else "FALSE"
    if len(arguments) < 2:
        return f"{value:g}" if isinstance(value, float) else _text(m, arguments[0])
    if not isinstance(value, (int, float)):
        return _text(m, arguments[0])
    decimals = whole(m, arguments[1])
    if decimals > _MOST_DECIMALS:
        says = f"{decimals} decimals are more than any number has"
        raise StatementError("I202", says, f"write at most {_MOST_DECIMALS}")
    return f"{value:.{max(0, decimals)}f}"


def _code(m: Machine, arguments: Arguments) -> Value:
    text = _text(m, arguments[0])
    return ord(text[0]) & 0xFF if text else 0


def _character(m: Machine, arguments: Arguments) -> Value:
    return chr(whole(m, arguments[0]) & 0xFF)


def _part(m: Machine, arguments: Arguments) -> Value:
    start = max(1, whole(m, arguments[1])) - 1
    count = whole(m, arguments[2]) if len(arguments) > 2 else None
    text = _text(m, arguments[0])
    return text[start:] if count is None else text[start : start + max(0, count)]


def _find(m: Machine, arguments: Arguments) -> Value:
    return _text(m, arguments[0]).find(_text(m, arguments[1])) + 1


def _match(m: Machine, arguments: Arguments) -> Value:
    """Text, first character, pattern: where it stands; one more than the text is long where it does not."""
    text = _text(m, arguments[0])
    at = text.find(_text(m, arguments[2]), max(1, whole(m, arguments[1])) - 1)
    return at + 1 if at >= 0 else len(text) + 1


def _found(m: Machine, arguments: Arguments) -> Value:
    """Text, first character, pattern: where it stands; 0 where it does not."""
    return _text(m, arguments[0]).find(_text(m, arguments[2]), max(1, whole(m, arguments[1])) - 1) + 1


def _parameter(m: Machine, arguments: Arguments) -> Value:
    m.assume("a controller parameter is read: taken as 0")
    return 0


FUNCTIONS: Mapping[str, Callable[[Machine, Arguments], Value]] = {
    "sqrt": _square_root,
    "sin": _angle(math.sin),
    "cos": _angle(math.cos),
    "atan": _arc_tangent,
    "pose-product": _product,
    "pose-inverse": _inverse,
    "convert": _convert,
    "convert-shift": _convert_shift,
    "shift-between": _shift_between,
    "tool-data": _tool_data,
    "step-position": _step_position,
    "parameter": _parameter,
    "value-of-text": _text_value,
    "text-of-value": _shown,
    "code-of-character": _code,
    "character-of-code": _character,
    "part-of-text": _part,
    "length-of-text": lambda m, a: len(_text(m, a[0])),
    "joined-text": lambda m, a: "".join(_text(m, part) for part in a),
    "position-in-text": _find,
    "match-in-text": _match,
    "find-in-text": _found,
    "same-text": lambda m, a: _text(m, a[0]) == _text(m, a[1]),
}

# Every function takes one argument at least. What a controller's manual makes optional is not counted.


# Poses: micrometres and 0.0001 deg, as a published pallet job proves (300000 for 300 mm, 900000 for 90 deg).
_ANGLE = 1e-4 * deg  # [rad]
_LENGTHS = 3
_SIZE = 6
_FARTHEST = 1e12  # pulses, metres or radians
_MOST_ELEMENTS = 8
_ZERO_POSE = PositionValue(PointState(PointKind.POSE, "base"), (0.0,) * _SIZE)


def unit_of(value: PositionValue, index: int) -> float:
    """SI value of one count of element `index` (from 1)."""
    if value.state.kind is PointKind.PULSE:
        return 1.0
    if value.state.kind is PointKind.JOINT:
        return _ANGLE
    return um if index <= _LENGTHS else _ANGLE


def read_element(m: Machine, element: ex.Element) -> int:
    """One element as the controller counts it. Raises StatementError for one that does not exist."""
    variable = element.variable
    if not isinstance(variable, (ex.Taught, ex.Variable)) or variable.store not in ex.POSITION_STORES:
        raise StatementError("I209", f"{spell(variable)} is no position", "use a position variable")
    value = position_value(
        m, variable, ex.Store.ROBOT if variable.store is ex.Store.SYSTEM else variable.store
    )
    index = _index(m, element)
    if index > len(value.values) or math.isnan(value.values[index - 1]):
        return 0  # a seventh element of a six-axis arm reads as zero
    return round_half_away(value.values[index - 1] / unit_of(value, index))


def write_element(m: Machine, element: ex.Element, count: int | float) -> None:
    """Sets one element from the controller's counts."""
    variable = element.variable
    if not isinstance(variable, ex.Variable) or variable.store not in ex.POSITION_STORES:
        raise StatementError("I209", f"{spell(variable)} cannot be changed", "use a position variable")
    if variable.store is ex.Store.SYSTEM:
        variable = ex.Variable(ex.Store.ROBOT, variable.index, variable.local)
    value = held_position(m, variable)
    index = _index(m, element)
    values = list(value.values) + [0.0] * (index - len(value.values))
    values[index - 1] = count * unit_of(value, index)
    write_variable(m, variable, PositionValue(value.state, tuple(values)))


def held_position(m: Machine, variable: ex.Variable) -> PositionValue:
    """The variable's position; one that nobody set is taken as a zero pose, which is reported."""
    index = whole(m, variable.index)
    held = (m.frame.locals if variable.local else m.memory.values).get((variable.store, index))
    if held is None and m.made_up is not None and not variable.local:
        try:
            made = read_variable(m, variable.store, index, variable.local)
        except StatementError:
            made = None  # it has none there either
        if isinstance(made, PositionValue):
            return made
    if held is None:
        m.assume(f"{spell(variable)} has no value yet: taken as Cartesian, all elements 0, in the base frame")
        return _ZERO_POSE
    value = read_variable(m, variable.store, index, variable.local)
    assert isinstance(value, PositionValue)
    return value


def binary(m: Machine, e: ex.Binary) -> Value:
    """The value of an operation on numbers, texts or positions."""
    left, right = both(m, e.left, e.right)
    if isinstance(left, PositionValue) and isinstance(right, (int, float, PositionValue)):
        return combine(e.operator, left, right)
    if right == 0:
        check_divisor(m, e.operator, e.right, right)
    return calculate(e.operator, left, right)


def _index(m: Machine, element: ex.Element) -> int:
    index = whole(m, element.index)
    if not 1 <= index <= _MOST_ELEMENTS:
        raise StatementError(
            "I210", f"a position has no element {index}", "write 1 .. 6, or 7 for a seventh axis"
        )
    return index


def combine(sign: str, left: PositionValue, right: PositionValue | int | float) -> PositionValue:
    """Element by element: position + - position, position * / number. Raises StatementError."""
    if isinstance(right, PositionValue):
        if sign not in "+-" or left.state.kind is not right.state.kind:
            raise StatementError(
                "I211",
                "only two positions of the same kind can be added or subtracted",
                "convert one of them first",
            )
        width = max(len(left.values), len(right.values))
        factor = 1.0 if sign == "+" else -1.0
        pairs = zip(_filled(left.values, width), _filled(right.values, width), strict=True)
        return PositionValue(left.state, tuple(a + factor * b for a, b in pairs))
    if sign not in "*/":
        raise StatementError("I211", "a number cannot be added to a position", "set its elements one by one")
    if sign == "/" and right == 0:
        raise StatementError("I207", "division by zero", "the controller stops with an alarm here")
    factor = float(right) if sign == "*" else 1.0 / right
    values = tuple(value * factor for value in left.values)
    if any(abs(value) > _FARTHEST for value in values):
        raise StatementError("I202", "the position lies beyond all space", "check the operands")
    return PositionValue(left.state, values)


def _filled(values: tuple[float, ...], width: int) -> list[float]:
    return [0.0 if math.isnan(v) else v for v in values] + [0.0] * (width - len(values))


_ALL = 100_000  # more variables than any controller has


def assign(m: Machine, s: st.Assign) -> None:
    value = s.value
    store_value(m, s.target, m.operations.evaluators[type(value)](m, value))


def store_value(m: Machine, target: ex.Expression, value: Value) -> None:
    """Stores a value wherever a program can store one. Raises StatementError for anything else."""
    _STORES.get(type(target), _no_store)(m, target, value)


def _store_variable(m: Machine, target: ex.Variable, value: Value) -> None:
    if type(value) is SystemPosition and target.store in ex.POSITION_STORES - {ex.Store.SYSTEM}:
        value = dict(value.parts).get(target.store, value)
    write_variable(m, target, value)


def _store_frame(m: Machine, target: ex.FrameRef, value: Value) -> None:
    if target.kind == "tool" and target.number is not None:
        set_tool(m, target.number, value)
    elif target.kind == "user":
        set_frame(m, target, raw_pose(as_position(value)))
    else:
        _no_store(m, target, value)


def _store_system_value(m: Machine, target: ex.SystemValue, value: Value) -> None:
    if target.name not in _TIMERS:
        m.assume(f"{spell(target)} is set: nothing that is timed depends on it")


def _store_element(m: Machine, target: ex.Element, value: Value) -> None:
    if not isinstance(value, (int, float)):
        raise StatementError("I204", "an element of a position holds a number", "use a double variable")
    write_element(m, target, value)


def _store_by_function(m: Machine, target: ex.Function, value: Value) -> None:
    if target.name == "tool-data":
        set_tool(m, target.arguments[0], value)
    elif target.name not in _TIMERS:
        _no_store(m, target, value)


def _no_store(m: Machine, target: ex.Expression, value: Value) -> None:
    raise StatementError("I218", f"nothing can be stored in {spell(target)}", "name a variable")


_TIMERS = ("timer", "timer-running")  # no time passes while the program runs here
_STORES: Mapping[type, Callable[[Machine, Any, Value], None]] = {
    ex.Variable: _store_variable,
    ex.Named: lambda m, e, value: write_name(m, e.name, value),
    ex.Item: write_item,
    ex.Member: write_member,
    ex.FrameRef: _store_frame,
    ex.SystemValue: _store_system_value,
    ex.Element: _store_element,
    ex.Function: _store_by_function,
    ex.Signal: write_signal,
}


def update(m: Machine, s: st.Update) -> None:
    """target := target op operand."""
    if s.operator == "not":
        operand = s.target if s.operand is None else s.operand
        store_value(m, s.target, ~int(number(m, operand)) & 0xFF)
        return
    if s.operand is None:
        raise StatementError("I219", f"'{s.operator}' needs a second value", "write it behind the variable")
    if isinstance(s.target, ex.Variable) and s.target.store in ex.POSITION_STORES:
        value = evaluate(m, s.operand)
        stores = _held_parts(m, s.target) if s.target.store is ex.Store.SYSTEM else (s.target.store,)
        for store in stores:
            _update_position(
                m, s.operator, ex.Variable(store, s.target.index, s.target.local, s.target.name), value
            )
        return
    left = evaluate(m, s.target)
    right = evaluate(m, s.operand)
    check_divisor(m, s.operator, s.operand, right)
    if s.operator == "/" and isinstance(s.target, ex.Variable) and s.target.store in INTEGERS:
        store_value(m, s.target, _quotient(m, left, right))
    else:
        store_value(m, s.target, calculate(s.operator, left, right))


def _quotient(m: Machine, left: Value, right: Value) -> Value:
    """Integer division, towards zero."""
    if not isinstance(left, int) or not isinstance(right, int) or right == 0:
        return calculate("/", left, right)
    quotient = abs(left) // abs(right)
    if abs(left) % abs(right):
        m.assume("the quotient of two integers loses its fraction")
    return quotient if (left < 0) == (right < 0) else -quotient


def _held_parts(m: Machine, system: ex.Variable) -> tuple[ex.Store, ...]:
    value = evaluate(m, system)
    return tuple(store for store, _ in value.parts) if isinstance(value, SystemPosition) else ()


def _update_position(m: Machine, sign: str, target: ex.Variable, value: Value) -> None:
    if isinstance(value, SystemPosition):
        value = dict(value.parts).get(target.store, value)
    if not isinstance(value, (int, float, PositionValue)):
        raise StatementError(
            "I211", "a position is combined with a position or a number", "check the operand"
        )
    write_variable(m, target, combine(sign, held_position(m, target), value))


def clear(m: Machine, s: st.Clear) -> None:
    """Zeroes variables; without a target the call stack is emptied."""
    if s.target is None:
        m.frames.clear()
        return
    if not isinstance(s.target, ex.Variable):
        raise StatementError("I218", f"{spell(s.target)} cannot be cleared", "name a variable")
    first, store, local = whole(m, s.target.index), s.target.store, s.target.local
    if s.count is not None:
        indices = list(range(first, first + min(whole(m, s.count), _ALL)))
    else:
        held = m.frame.locals if local else m.memory.values
        indices = [index for kind, index in held if kind is store and index >= first]
    for index in indices:
        write_variable(m, ex.Variable(store, ex.Number(index), local), zero(store))


def read_input(m: Machine, s: st.ReadInput) -> None:
    value = read_signal(m, s.signal)
    store_value(m, s.target, int(value) if isinstance(value, bool) else value)


def define_frame(m: Machine, s: st.DefineFrame) -> None:
    """A user frame from three points, and a fourth that its origin moves to."""
    arm = role(m, 0, ex.Store.ROBOT)
    points = [pose_of(m, arm, _robot_position(m, p)).position for p in s.points]
    if len(points) < 3:
        raise StatementError("I220", "a frame needs three points", "teach origin, X axis and X-Y plane")
    if s.master_tool:
        m.assume("the frame on the master tool is taken as standing still")
    frame = frame_from_points(*points[:3])
    if len(points) > 3:
        frame = type(frame)(points[3], frame.rotation)
    set_frame(m, s.frame, frame)


def _robot_position(m: Machine, position: ex.Expression) -> PositionValue:
    if not isinstance(position, (ex.Taught, ex.Variable, ex.Unknown)):
        return as_position(evaluate(m, position))
    if isinstance(position, ex.Variable) and position.store is ex.Store.SYSTEM:
        return as_position(read_variable(m, ex.Store.SYSTEM, whole(m, position.index), position.local))
    return position_value(m, position, ex.Store.ROBOT)


def shift_on(m: Machine, s: st.ShiftOn) -> None:
    """From here on taught targets move by the offset."""
    if s.coordinated:
        m.assume("the shift relative to the moving work is left out")
        return
    offset = _robot_position(m, s.offset)
    m.shift = Shift(offset, s.frame if s.frame is not None else ex.FrameRef("own"))
    m.plain = False
    if any(offset.values[3:6]):
        m.assume("a shift with angles turns the tool about its centre point, not about the frame's origin")


def shift_off(m: Machine, s: st.ShiftOff) -> None:
    if not s.coordinated:
        m.shift = None
        m.plain = not (m.tool_now or m.user_now)


def external_tool(m: Machine, s: st.ExternalTool) -> None:
    if s.tool is not None:
        m.assume("speeds about the fixed tool are taken as speeds of the robot's own tool")
