"""Built-in functions: numbers, texts, poses and frames."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace

from olp.core.units import deg
from olp.ir.expressions import Expression, FrameRef, Store, Taught, Variable
from olp.ir.points import PointKind, PointState
from olp.ir.program import Move
from olp.robots.geometry import Pose
from olp.robots.kinematics.configuration import Tool
from olp.runtime.evaluate import evaluate, number, whole
from olp.runtime.memory import ACTIVE, PositionValue, SystemPosition, Value
from olp.runtime.poses import (
    as_pose,
    as_position,
    as_pulses,
    frame_pose,
    frame_state,
    fresh_number,
    own_frame,
    pose_of,
    raw_pose,
    with_pose,
)
from olp.runtime.spelling import spell
from olp.runtime.state import Machine, StatementError

Arguments = Sequence[Expression]
_MOST_DECIMALS = 1_100  # no number has more


def frame_value(m: Machine, frame: FrameRef) -> Value:
    """A frame as a position in the base."""
    return with_pose(PositionValue(PointState(PointKind.POSE, "base"), ()), frame_pose(m, frame))


def set_tool(m: Machine, argument: Expression, value: Value) -> None:
    """Gives a tool new data; what was recorded with the old ones keeps them."""
    tool = whole(m, argument)
    m.tool_now[tool] = fresh = fresh_number(m.world.cell.tools)
    m.world.tools[fresh] = Tool(raw_pose(as_position(value)))
    m.plain = False


def set_frame(m: Machine, frame: FrameRef, pose: Pose) -> None:
    """Gives a user frame a new place; what was recorded in the old one stays where it was."""
    user = whole(m, frame.number) if frame.number is not None else 0
    m.user_now[user] = fresh = fresh_number(m.world.cell.user_frames)
    m.world.cell.user_frames[fresh] = pose
    m.plain = False


def _position(m: Machine, e: Expression) -> PositionValue:
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
    return with_pose(first, raw_pose(first) @ raw_pose(second), state)


def _inverse(m: Machine, arguments: Arguments) -> Value:
    value = _position(m, arguments[0])
    return with_pose(value, raw_pose(value).inverse())


def _convert(m: Machine, arguments: Arguments) -> Value:
    """A position in another frame, or in pulses; a tool may be named for it."""
    value = evaluate(m, arguments[0])
    frames = [a for a in arguments[1:] if isinstance(a, FrameRef)]
    tool = next((f for f in frames if f.kind == "tool" and f.number is not None), None)
    frame = next((f for f in frames if f is not tool), FrameRef("pulse"))
    if not isinstance(value, SystemPosition):
        return _converted(m, _position(m, arguments[0]), frame, tool)
    parts = tuple(
        (store, _converted(m, part, frame, tool) if store is Store.ROBOT else part)
        for store, part in value.parts
    )
    return SystemPosition(parts)


def _converted(m: Machine, value: PositionValue, frame: FrameRef, tool: FrameRef | None) -> PositionValue:
    from olp.runtime.state import role

    mechanism = role(m, 0, Store.ROBOT)
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
    moves = [s for s in m.frame.job.body if isinstance(s, Move)]
    if not 1 <= wanted <= len(moves):
        raise StatementError("I217", f"the routine has no step {wanted}", f"it has {len(moves)} moves")
    step = moves[wanted - 1]
    written = [*step.targets, *(t for part in step.parts for t in part.targets)]
    parts = [(p.store, position_value(m, p, p.store)) for p in written if isinstance(p, (Taught, Variable))]
    return SystemPosition(tuple(parts))


def _shift_between(m: Machine, arguments: Arguments) -> Value:
    """The shift that takes the first position to the second, along the axes of a frame."""
    from olp.runtime.state import role

    frame = next((a for a in arguments if isinstance(a, FrameRef)), FrameRef("base"))
    positions = [_position(m, a) for a in arguments if not isinstance(a, FrameRef)]
    if len(positions) < 2:  # two arguments may be one position and a frame
        raise StatementError("I213", "a shift needs two positions", "name the reference and the target")
    mechanism = role(m, 0, Store.ROBOT)
    first, second = (pose_of(m, mechanism, p) for p in positions[:2])
    axes = first.rotation if frame.kind == "tool" else frame_pose(m, frame).rotation
    turn = axes.T @ second.rotation @ first.rotation.T @ axes
    shift = Pose(axes.T @ (second.position - first.position), turn)
    return with_pose(PositionValue(PointState(PointKind.POSE, frame.kind), ()), shift)


def _convert_shift(m: Machine, arguments: Arguments) -> Value:
    """A shift along the axes of its own frame as the same shift along the axes of another one."""
    value = _position(m, arguments[0])
    frame = next((a for a in arguments[1:] if isinstance(a, FrameRef)), FrameRef("base"))
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


def _text(m: Machine, e: Expression) -> str:
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
}

# Every function takes one argument at least. What a controller's manual makes optional is not counted.
