"""Positions as poses in the base and back into any frame; the current position; shifts; modal settings.

A written position becomes an entry of the plan's pool of positions. Modal settings hold for all following moves: tool,
frame, speeds, accelerations, sizes of blends, override.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import replace
from functools import lru_cache, reduce
from operator import matmul
from struct import Struct
from typing import Final, TypeVar

import numpy as np

from olp.core.diagnostic import Severity
from olp.ir import expressions as ex
from olp.ir import program as st
from olp.ir.points import PointKind, PointState
from olp.robots.coordinate_systems import in_frame
from olp.robots.geometry import Pose
from olp.robots.kinematics.configuration import Tool
from olp.runtime.evaluate import evaluate, find_slot, is_whole, number, quantity, read_variable, whole
from olp.runtime.memory import ACTIVE, Array, PositionValue, Record, Slot, SystemPosition, Value
from olp.runtime.plan import PATHS
from olp.runtime.recorder import NOWHERE
from olp.runtime.spelling import spell
from olp.runtime.state import Machine, StatementError

T = TypeVar("T")
_POSE_SIZE = 6
_SIX_NUMBERS: Final = Struct("6d")


# Controllers have at most 64 tools and frames; numbers from here on are later states of them.
_FIRST_FRESH = 1_000_000


def fresh_number(numbers: Iterable[int]) -> int:
    """Of a later state of a tool or frame, beside those that are taken."""
    return max(_FIRST_FRESH, max(numbers, default=0) + 1)


def as_position(value: Value) -> PositionValue:
    """A robot position, also out of a system position. Raises StatementError (I213)."""
    if isinstance(value, SystemPosition):
        value = next((part for store, part in value.parts if store is ex.Store.ROBOT), 0)
    if isinstance(value, PositionValue):
        return value
    raise StatementError("I213", "this needs a position", "use a position variable")


def pose_of(m: Machine, mechanism: int, value: PositionValue) -> Pose:
    """The tool's pose in the base.

    Raises StatementError: I213 for a pose cut short, I212 where the robot or its geometry is missing.
    """
    _check_whole(value)
    pose = m.world.cell.pose(mechanism, current_frames(m, value.state), value.values)
    if pose is None:
        name = m.world.mechanisms[mechanism].name
        raise StatementError(
            "I212",
            f"where {name} is in space is not known here",
            "say which robot it is: --robot maker/model, or robot = … in olp.toml",
        )
    return pose


def _check_whole(value: PositionValue) -> None:
    if not is_whole(value):
        raise StatementError("I213", "this needs the position of a robot", "use a position variable")


def raw_pose(value: PositionValue) -> Pose:
    """The six numbers as a pose in their own frame. Raises StatementError (I213) for pulses and joints."""
    return _pose_of(_bytes_of(value))


def _bytes_of(value: PositionValue) -> bytes:
    """The six numbers of a pose. Raises StatementError (I213) for pulses and joints."""
    if value.state.kind is not PointKind.POSE or len(value.values) < _POSE_SIZE:
        raise StatementError("I213", "this needs a Cartesian position", "convert it first")
    return _SIX_NUMBERS.pack(*value.values[:_POSE_SIZE])


@lru_cache(maxsize=1024)
def _pose_of(*frames: bytes) -> Pose:
    """A pose in frames, the outermost first. Moves have few of them. What all share cannot be written to."""
    first, *inner = (Pose.from_xyz_angles(np.frombuffer(numbers)) for numbers in frames)
    pose = reduce(matmul, inner, first)
    pose.position.setflags(write=False)
    pose.rotation.setflags(write=False)
    return pose


def with_pose(value: PositionValue, pose: Pose, state: PointState | None = None) -> PositionValue:
    """`value` with its first six numbers replaced; further axes stay."""
    return PositionValue(state or value.state, _numbers_of(pose) + value.values[_POSE_SIZE:])


def product(first: PositionValue, second: PositionValue, state: PointState) -> PositionValue:
    """`first` with its first six numbers replaced by those of `second` seen from it; further axes stay."""
    return PositionValue(state, _product_of(_bytes_of(first), _bytes_of(second)) + first.values[_POSE_SIZE:])


@lru_cache(maxsize=4096)
def _product_of(first: bytes, second: bytes) -> tuple[float, ...]:
    """Six numbers; worked out once for a move that is looked at ahead and then made."""
    return _numbers_of(_pose_of(first) @ _pose_of(second))


def _numbers_of(pose: Pose) -> tuple[float, ...]:
    return tuple(pose.xyz_angles().tolist())


def current_frames(m: Machine, state: PointState) -> PointState:
    """`state` with the tool and user frame that hold now, where the program has changed them since."""
    if state.frame == ACTIVE:
        return replace(state, frame=m.active_frame[0], user=m.active_frame[1], tool=m.active_tool)
    tool = m.tool_now.get(state.tool, state.tool)
    user = state.user if state.user is None else m.user_now.get(state.user, state.user)
    if tool == state.tool and user == state.user:
        return state
    return replace(state, tool=tool, user=user)


def frame_pose(m: Machine, frame: ex.FrameRef) -> Pose:
    """A frame seen from the base. Raises StatementError for one that moves with the arm."""
    flange = frame.kind == "tool" and frame.number == ex.Number(0)
    if flange or frame.kind in ("base", "robot"):
        return Pose.identity()
    if frame.kind == ACTIVE:
        kind, place = m.active_frame
        return Pose.identity() if kind == "base" else m.world.cell.user_frame(place or 0)
    if frame.kind == "user":
        number = whole(m, frame.number) if frame.number is not None else 0
        return m.world.cell.user_frame(m.user_now.get(number, number))
    raise StatementError("I214", f"the {frame.kind} frame is not known here", "use the base or a user frame")


def own_frame(m: Machine, state: PointState) -> Pose:
    """The frame that a pose is written in, seen from the base."""
    number = ex.Number(state.user) if state.frame == "user" and state.user is not None else None
    return frame_pose(m, ex.FrameRef(state.frame, number))


def frame_state(m: Machine, frame: ex.FrameRef, before: PointState) -> PointState:
    """The state of a pose written in `frame`."""
    number = whole(m, frame.number) if frame.kind == "user" and frame.number is not None else None
    return replace(before, kind=PointKind.POSE, frame=frame.kind, user=number)


def here(m: Machine, mechanism: int) -> PositionValue:
    """Where the mechanism stands, as it was written; before its first move in front of its base, which is assumed.

    Raises StatementError (I215) where nothing can be assumed.
    """
    index = m.recorder.at[mechanism]
    if index == NOWHERE:
        index = m.recorder.at[mechanism] = (
            NOWHERE if "start" in m.assumptions.strict else _before_all(m, mechanism)
        )
    if index == NOWHERE:
        name = m.world.mechanisms[mechanism].name
        raise StatementError(
            "I215",
            f"the position of {name} before its first move is not known",
            f"say it in olp.toml: [start] {name} = {{ joint_deg = [ … ] }}",
        )
    state, values = m.recorder.written(index)
    return PositionValue(state, tuple(float(v) for v in values))


def _before_all(m: Machine, mechanism: int) -> int:
    """The arm in front of its base, the flange pointing down: where a program begins that does not say it."""
    robot = m.world.cell.robot(mechanism)
    if robot is None or not m.world.mechanisms[mechanism].is_robot:
        return NOWHERE
    stretched = m.world.cell.pose(mechanism, PointState(PointKind.JOINT, "joint"), (0.0,) * len(robot.axes))
    reach = 0.0 if stretched is None else float(np.linalg.norm(stretched.position))
    for share in _IN_FRONT:
        values = (share * reach, 0.0, 0.5 * reach, math.pi, 0.0, 0.0)
        axes = m.world.cell.resolve(mechanism, _IN_BASE, np.array([values])).axes[0, : len(robot.axes)]
        if not np.isnan(axes).any():
            m.assume_once(
                f"start {mechanism}",
                f"the arm stands {1000 * values[0]:.0f} mm in front of its base at first and points down: "
                f"[start] may say where",
            )
            begins = values if m.made_up is None else m.made_up.start(values)
            return m.recorder.position(mechanism, _IN_BASE, begins)
    return NOWHERE


_IN_BASE = PointState(PointKind.POSE, "base")
_IN_FRONT = (0.5, 0.4, 0.6, 0.3)  # shares of how far the flange is from the base with all axes at zero


def as_pulses(m: Machine, mechanism: int, value: PositionValue) -> PositionValue:
    """The same position in motor pulses. Raises StatementError (I212) where the robot is missing."""
    if value.state.kind is PointKind.PULSE:
        return value
    _check_whole(value)
    robot = m.world.cell.robot(mechanism)
    state = current_frames(m, value.state)
    resolved = m.world.cell.resolve(mechanism, state, np.asarray([value.values], dtype=np.float64))
    axes = resolved.axes[0]
    if robot is None or not robot.knows_pulses or np.isnan(axes[: len(robot.axes)]).any():
        name = m.world.mechanisms[mechanism].name
        raise StatementError(
            "I212",
            f"this position is not known in pulses of {name}",
            "say which robot it is: --robot maker/model, or robot = … in olp.toml",
        )
    from olp.robots.kinematics.configuration import joints_to_pulses

    pulses = joints_to_pulses(robot, axes[None, : len(robot.axes)])[0]
    return PositionValue(
        replace(value.state, kind=PointKind.PULSE, frame="pulse", user=None), tuple(map(float, pulses))
    )


def as_pose(m: Machine, mechanism: int, value: PositionValue, frame: ex.FrameRef) -> PositionValue:
    """The same position as a pose in `frame`, with the arm's configuration where it is known."""
    if not m.world.mechanisms[mechanism].is_robot:
        return value
    seen = in_frame(pose_of(m, mechanism, value), frame_pose(m, frame))
    state = frame_state(m, frame, replace(value.state, configuration=_configuration(m, mechanism, value)))
    return PositionValue(state, tuple(float(v) for v in seen.xyz_angles()))


def _configuration(m: Machine, mechanism: int, value: PositionValue) -> tuple[int, ...]:
    robot = m.world.cell.robot(mechanism)
    if value.state.kind is PointKind.POSE or robot is None or robot.geometry is None:
        return value.state.configuration
    if robot.geometry.links is None:
        return ()
    from olp.robots.kinematics.configuration import configuration_of

    axes = m.world.cell.resolve(mechanism, value.state, np.asarray([value.values], dtype=np.float64)).axes
    return tuple(int(flag) for flag in configuration_of(robot, axes[:, : len(robot.axes)])[0])


def shifted(pose: Pose, offset: Pose, frame: Pose) -> Pose:
    """`pose` (in the base) moved by `offset`, whose numbers are given along the axes of `frame`.

    The tool centre point is translated, and the tool is turned about it: it does not swing round the frame's origin.
    """
    turn = frame.rotation @ offset.rotation @ frame.rotation.T
    return Pose(pose.position + frame.rotation @ offset.position, turn @ pose.rotation)


def moved_by(
    m: Machine, mechanism: int, start: PositionValue, offset: PositionValue, frame: ex.FrameRef
) -> PositionValue:
    """`start` moved by `offset` in `frame`: base, robot, user or tool; "own" is the offset's own frame."""
    if not m.world.mechanisms[mechanism].is_robot or offset.state.kind is not PointKind.POSE:
        return _added(m, mechanism, start, offset)
    if frame.kind == "own":
        frame = ex.FrameRef(
            offset.state.frame, None if offset.state.user is None else ex.Number(offset.state.user)
        )
    pose = pose_of(m, mechanism, start)
    by = raw_pose(offset)
    axes = pose if frame.kind == "tool" else frame_pose(m, frame)
    base = ex.FrameRef("base")
    state = frame_state(m, base, replace(start.state, configuration=_configuration(m, mechanism, start)))
    return PositionValue(state, tuple(float(v) for v in shifted(pose, by, axes).xyz_angles()))


def _added(m: Machine, mechanism: int, start: PositionValue, offset: PositionValue) -> PositionValue:
    """Axis by axis, in pulses, radians or metres."""
    if start.state.kind is not offset.state.kind and offset.state.kind is PointKind.PULSE:
        start = as_pulses(m, mechanism, start)
    if start.state.kind is not offset.state.kind:
        raise StatementError(
            "I211", "the position and its offset are of different kinds", "convert one of them first"
        )
    width = max(len(start.values), len(offset.values))
    a = list(start.values) + [0.0] * (width - len(start.values))
    b = list(offset.values) + [0.0] * (width - len(offset.values))
    return PositionValue(
        start.state, tuple(x + (0.0 if math.isnan(y) else y) for x, y in zip(a, b, strict=True))
    )


def place(
    m: Machine, mechanism: int, position: ex.Position, store: ex.Store, relative: ex.FrameRef | None
) -> int:
    """The pool index of where `position` is, or of where it leads from here when it is `relative`."""
    if m.plain and relative is None and isinstance(position, ex.Taught):
        job = m.frame.job
        target = m.recorder.taught(mechanism, job.key, job.points, store, position.number)
        if target is None:
            raise missing(position)
        return target
    value = position_value(m, position, store)
    if relative is not None:
        value = moved_by(m, mechanism, here(m, mechanism), value, relative)
    elif not m.plain:
        value = _current(m, mechanism, value)
    return m.recorder.position(mechanism, value.state, value.values)


def _current(m: Machine, mechanism: int, value: PositionValue) -> PositionValue:
    """The position under the shift and with the tools and frames that hold now."""

    value = PositionValue(current_frames(m, value.state), value.values)
    shift = m.shift
    if shift is None or not m.world.mechanisms[mechanism].is_robot:
        return value
    return moved_by(m, mechanism, value, shift.offset, shift.frame)


def position_value(m: Machine, position: ex.Position, store: ex.Store) -> PositionValue:
    """The written numbers of a position. Raises StatementError when it has none."""
    if isinstance(position, ex.Taught):
        point = m.frame.job.points.find(store, True, position.number)
        if point is None:
            raise missing(position)
        return PositionValue(point.state, point.values)
    if not isinstance(position, ex.Variable):
        raise StatementError("I209", f"nothing defines {spell(position)}", "declare the name, or correct it")
    value = read_variable(m, store, whole(m, position.index), position.local)
    if not isinstance(value, PositionValue):
        raise StatementError("I209", f"{spell(position)} is no position", "use a position variable")
    return value


def missing(position: ex.Position) -> StatementError:
    """The error for a point that the routine does not teach."""
    return StatementError(
        "I206", f"the routine teaches no {spell(position)}", "add the point, or correct its number"
    )


FRACTION, TRAVEL, TURN, AXIS, TIME = 0, 1, 2, 3, 4
UNITS: Mapping[st.SpeedUnit, int] = {
    st.SpeedUnit.FRACTION: FRACTION,
    st.SpeedUnit.TRAVEL: TRAVEL,
    st.SpeedUnit.TURN: TURN,
    st.SpeedUnit.AXIS: AXIS,
    st.SpeedUnit.TIME: TIME,
}
PATH_CODES: Final[Mapping[st.Path, int]] = {path: code for code, path in enumerate(PATHS)}
JOINT: Final = PATH_CODES[st.Path.JOINT]
# Nobody says how fast a move without any speed is: as slow as manual operation, in runs and in translations.
UNTOLD_SPEED: Final = (0.1, 0.25, 0.1, 0.1, 10.0)  # [1], [m/s], [rad/s], [rad/s], [s]
SHOWN_UNTOLD: Final = ("10 % of the rated joint speed", "250 mm/s", "0.1 rad/s", "0.1 rad/s", "10 s")
_HIGHEST: Final = (1.0, 1e3, 1e3, 1e3, 1e5)  # faster than any machine, longer than any move
_TOO_FAST: Final = (
    "a joint speed above 100 % is taken as 100 %",
    "a speed above 1000 m/s is taken as 1000 m/s",
    "a speed above 1000 rad/s is taken as 1000 rad/s",
    "a speed above 1000 rad/s is taken as 1000 rad/s",
    "a move of more than a day is taken to last a day",
)


def set_speed(m: Machine, s: st.SetSpeed) -> None:
    """Keeps the speeds for the moves that name none."""
    for speed in s.speeds:
        m.modal[UNITS[speed.unit]] = _checked(m, UNITS[speed.unit], quantity(m, speed.value))
    if s.turn is not None:
        m.turn = turn_rate(m, s.turn)


def turn_rate(m: Machine, turn: ex.Quantity) -> float:
    """[rad/s] that a move turns its tool at no faster; a bound of zero would keep it from turning at all."""
    value = quantity(m, turn)
    return _checked(m, UNITS[st.SpeedUnit.TURN], value) if value <= 0.0 else value


def part_speed(m: Machine, part: st.MovePart, leading: tuple[int, float]) -> tuple[int, int, float]:
    """(path, unit, speed) of a further group; `leading`: unit and speed of the leading one.

    Without a speed of its own a group keeps step: on a joint path only its rated speed bounds it, on another one
    the leading speed does.
    """
    assert part.path is not None
    path = PATH_CODES[part.path]
    value = 0.0 if part.speed is None else quantity(m, part.speed.value)
    if part.speed is not None and value > 0.0:
        unit = UNITS[part.speed.unit]
        return path, unit, _checked(m, unit, value)
    # Generators write VJ=0.0 for a table that only keeps step.
    if path == JOINT or leading[0] == FRACTION:
        return JOINT, FRACTION, 1.0
    return path, *leading


def move_speed(m: Machine, speed: st.Speed | None, path: int) -> tuple[int, float]:
    """(unit, SI value) of a move's own speed, or of the one that holds."""
    if speed is None:
        return _modal_speed(
            m, FRACTION if path == JOINT and AXIS not in m.modal else AXIS if path == JOINT else TRAVEL
        )
    unit = UNITS[speed.unit]
    if unit == FRACTION and path != JOINT:
        says = f"a straight move has no speed in percent: {SHOWN_UNTOLD[TRAVEL]} is taken"
        m.fault(StatementError("I309", says, "write its speed in mm/s", Severity.WARNING))
        return TRAVEL, UNTOLD_SPEED[TRAVEL]
    written, scale = speed.value
    value = (written.value if type(written) is ex.Number else number(m, written)) * scale
    if not 0.0 < value <= _HIGHEST[unit]:
        value = _checked(m, unit, value)
    m.last[unit] = value
    return unit, value


def _modal_speed(m: Machine, unit: int) -> tuple[int, float]:
    value = m.modal.get(unit) or m.last.get(unit)
    if value is None:
        m.assume(f"no speed was set before this move: {SHOWN_UNTOLD[unit]} is taken")
        value = UNTOLD_SPEED[unit]
    elif unit not in m.modal:
        m.assume("the move names no speed and none was set: that of the last move of its kind is taken")
    return unit, value


def _checked(m: Machine, unit: int, value: float) -> float:
    """A usable speed; the controller refuses others, here the nearest one is taken with a warning."""
    if 0.0 < value <= _HIGHEST[unit]:
        return value
    if value > 0.0:
        m.fault(StatementError("I302", _TOO_FAST[unit], "write a lower speed", Severity.WARNING))
        return _HIGHEST[unit]
    advice = "set the variable it comes from, in the program or in olp.toml"
    says = f"the speed is not above zero: {SHOWN_UNTOLD[unit]} is taken"
    m.fault(StatementError("I301", says, advice, Severity.WARNING))
    return UNTOLD_SPEED[unit]


def share(m: Machine, value: float, what: str) -> float:
    """A fraction of the rated acceleration in (0, 1]."""
    if 0.0 < value <= 1.0:
        return value
    m.fault(
        StatementError(
            "I303", f"{what} of {value:.0%} is taken as 100 %", "write 1 .. 100 %", Severity.WARNING
        )
    )
    return 1.0


RATE_FRACTION, RATE_ABSOLUTE = 0, 1
_FLANGE = ("tframe", "tcp", "trsf")  # the member of a tool's record that is its centre point
_OUTER, _INNER = "uframe", "oframe"  # of a work object's record


def set_tool(m: Machine, s: st.SetTool) -> None:
    m.active_tool = tool_number(m, s.tool)


def set_frame(m: Machine, s: st.SetFrame) -> None:
    m.active_frame = frame_place(m, s.frame)


def set_override(m: Machine, s: st.SetOverride) -> None:
    share = quantity(m, s.share)
    if not 0.0 < share <= 1.0:
        raise StatementError("I306", f"an override of {share:.0%} is left out", "write 1 .. 100 %")
    m.override = share
    m.fastest = math.inf if s.fastest is None else _checked(m, TRAVEL, quantity(m, s.fastest))


def obey_flags(m: Machine, s: st.ObeyFlags) -> None:
    m.obeys_flags = s.on


def set_acceleration(m: Machine, s: st.SetAcceleration) -> None:
    """Keeps the accelerations for moves that name none, for joint moves, for all others, or for both."""
    for rate in s.rates:
        value = quantity(m, rate.value)
        if value <= 0.0:
            raise StatementError(
                "I307", "an acceleration that is not above zero is left out", "write one above 0"
            )
        if rate.unit is st.AccelerationUnit.FRACTION:
            for joint in (True, False):
                if s.path is None or joint is (s.path is st.Path.JOINT):
                    m.rates[(joint, RATE_FRACTION)] = min(value, 1.0)
        else:
            m.rates[(rate.unit is st.AccelerationUnit.AXIS, RATE_ABSOLUTE)] = value


def set_blend(m: Machine, s: st.SetBlend) -> None:
    for blend in s.blends:
        if blend.value is not None:
            m.blends[blend.kind] = max(0.0, quantity(m, blend.value))


def tool_number(m: Machine, tool: ex.Expression) -> int:
    """The number in the cell of a tool: its own, or one given to its value. Raises StatementError."""
    if isinstance(tool, ex.FrameRef):
        number = whole(m, tool.number) if tool.number is not None else 0
        return m.tool_now.get(number, number)
    return _asked_once(m, tool, m.tools_named, _tool_of_value)


def frame_place(m: Machine, frame: ex.Expression) -> tuple[str, int | None]:
    """Where targets stand: base, or user and the number in the cell of a frame. Raises StatementError."""
    if isinstance(frame, ex.FrameRef):
        if frame.kind in ("base", "robot"):
            return "base", None
        number = whole(m, frame.number) if frame.number is not None else 0
        return "user", m.user_now.get(number, number)
    return _asked_once(m, frame, m.frames_named, _place_of_value)


def _asked_once(
    m: Machine,
    e: ex.Expression,
    known: dict[int, tuple[Slot, int, T]],
    find: Callable[[Machine, ex.Expression], T],
) -> T:
    """`find` for a tool or frame; the answer of before where a variable holds it and none has changed since."""
    slot = find_slot(m, e.name) if type(e) is ex.Named else None
    before = None if slot is None else known.get(id(slot))
    if before is not None and before[0] is slot and before[1] == m.memory.stamp:
        return before[2]
    found = find(m, e)
    # Not of numbers, whose tools and frames may be redefined; what is assumed of held work is counted at every move.
    counted = slot is None or (find is _tool_of_value and _stands_beside(slot.value))
    if slot is not None and not counted and isinstance(slot.value, (PositionValue, Record)):
        known[id(slot)] = (slot, m.memory.stamp, found)
    return found


def _tool_of_value(m: Machine, tool: ex.Expression) -> int:
    if (pose := _elsewhere(m, tool, "tool", "the flange")) is not None:
        return number_of(m, "tool", pose)
    value = evaluate(m, tool)
    if isinstance(value, (int, float)):
        return m.tool_now.get(int(value), int(value))
    if _stands_beside(value):
        m.assume_once(
            "held work",
            f"{spell(tool)} stands beside the robot: speeds about it are taken as the robot's own",
        )
    pose = raw_pose(as_position(_member(value, _FLANGE)))
    return number_of(m, "tool", pose)


def _stands_beside(tool: Value | None) -> bool:
    return isinstance(tool, Record) and tool.members.get("robhold") is False


def _place_of_value(m: Machine, frame: ex.Expression) -> tuple[str, int | None]:
    pose = _elsewhere(m, frame, "frame", "the base")
    if pose is None:
        value = evaluate(m, frame)
        if isinstance(value, (int, float)):
            number = int(value)
            return ("user", m.user_now.get(number, number)) if number else ("base", None)
        pose = _work_pose(value)
    values, is_none = _told(pose)
    return ("base", None) if is_none else ("user", _number_of(m, "user", pose, values))


def _is_left_open(m: Machine, array: Value, e: ex.Expression) -> bool:
    """Whether an element of an array has no value."""
    if not (isinstance(array, Array) and isinstance(e, ex.Item) and len(e.indices) == 1):
        return False
    at = whole(m, e.indices[0])
    return 0 < at <= len(array.items) and array.items[at - 1] is None


def _elsewhere(m: Machine, e: ex.Expression, kind: str, taken: str) -> Pose | None:
    """Where a tool or frame is that a file declares which is not here: `taken`, which is told; None where one is."""
    name = e.base if isinstance(e, ex.Item) else e
    if not isinstance(name, ex.Named) or name.name.casefold() in m.assumptions.names:
        return None
    slot = find_slot(m, name.name)
    if slot is not None and slot.value is not None and not _is_left_open(m, slot.value, e):
        return None
    made = None if m.made_up is None else m.made_up.pose(kind, spell(e).casefold())
    if made is not None:
        return made
    says = f"nothing at hand gives the {kind} {name.name} a value (no file beside it, no [names] in olp.toml)"
    m.assume_once(f"{kind} {name.name}", f"{says}: {taken} is taken")
    return Pose.identity()


def _work_pose(value: Value) -> Pose:
    if not isinstance(value, Record):
        return raw_pose(as_position(value))
    members = {name.casefold(): member for name, member in value.members.items()}
    if _OUTER not in members:
        return raw_pose(as_position(_member(value, _FLANGE)))
    return _pose_of(*(_bytes_of(as_position(members[part])) for part in (_OUTER, _INNER) if part in members))


def _member(value: Value, names: tuple[str, ...]) -> Value:
    if not isinstance(value, Record):
        return value
    found = next((v for name, v in value.members.items() if name.casefold() in names), None)
    return value if found is None else found


def number_of(m: Machine, kind: str, pose: Pose) -> int:
    """The number, in the cell, of a tool or frame with this pose: the same one whenever the pose is the same."""
    return _number_of(m, kind, pose, _told(pose)[0])


def _number_of(m: Machine, kind: str, pose: Pose, values: tuple[float, ...]) -> int:
    """A number that stands for this pose, whose six numbers are `values`, from now on."""
    number = m.placed.get((kind, values))
    if number is None:
        known: Mapping[int, object] = m.world.tools if kind == "tool" else m.world.cell.user_frames
        number = m.placed[(kind, values)] = fresh_number(known)
        if kind == "tool":
            m.world.tools[number] = Tool(pose)
        else:
            m.world.cell.user_frames[number] = pose
    return number


def _told(pose: Pose) -> tuple[tuple[float, ...], bool]:
    """The six numbers of a frame or tool, and whether it is none; worked out once, for moves have few of them."""
    return _told_of(pose.position.tobytes(), pose.rotation.tobytes())


@lru_cache(maxsize=1024)
def _told_of(position: bytes, rotation: bytes) -> tuple[tuple[float, ...], bool]:
    pose = Pose(np.frombuffer(position), np.frombuffer(rotation).reshape(3, 3))
    return tuple(pose.xyz_angles().tolist()), pose == Pose.identity()


def position_in(value: PositionValue, place: tuple[str, int | None], tool: int) -> PositionValue:
    """A pose without a frame of its own as one in `place`, seen at `tool`; joint values get the tool."""
    state = value.state
    if state.frame == ACTIVE:
        state = state.at(place[0], place[1], tool)
    elif state.tool != tool:
        state = state.at(state.frame, state.user, tool)
    return value if state is value.state else PositionValue(state, value.values, value.external)
