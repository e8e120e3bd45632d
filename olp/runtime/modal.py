"""What holds for all following moves: tool, frame, speeds, accelerations, sizes of blends, override."""

from __future__ import annotations

import math
from collections.abc import Mapping
from functools import lru_cache
from typing import Final

import numpy as np

from olp.core.diagnostic import Severity
from olp.ir.expressions import Expression, FrameRef, Item, Named, Number, Quantity
from olp.ir.program import (
    AccelerationUnit,
    MovePart,
    ObeyFlags,
    Path,
    SetAcceleration,
    SetBlend,
    SetFrame,
    SetOverride,
    SetSpeed,
    SetTool,
    Speed,
    SpeedUnit,
)
from olp.robots.geometry import Pose
from olp.robots.kinematics.configuration import Tool
from olp.runtime.evaluate import evaluate, number, quantity, whole
from olp.runtime.memory import ACTIVE, PositionValue, Record, Value
from olp.runtime.plan import PATHS
from olp.runtime.poses import as_position, fresh_number, raw_pose
from olp.runtime.scope import find_slot
from olp.runtime.spelling import spell
from olp.runtime.state import Machine, StatementError

FRACTION, TRAVEL, TURN, AXIS, TIME = 0, 1, 2, 3, 4
UNITS: Mapping[SpeedUnit, int] = {
    SpeedUnit.FRACTION: FRACTION,
    SpeedUnit.TRAVEL: TRAVEL,
    SpeedUnit.TURN: TURN,
    SpeedUnit.AXIS: AXIS,
    SpeedUnit.TIME: TIME,
}
PATH_CODES: Final[Mapping[Path, int]] = {path: code for code, path in enumerate(PATHS)}
JOINT: Final = PATH_CODES[Path.JOINT]
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


def set_speed(m: Machine, s: SetSpeed) -> None:
    """Keeps the speeds for the moves that name none."""
    for speed in s.speeds:
        m.modal[UNITS[speed.unit]] = _checked(m, UNITS[speed.unit], quantity(m, speed.value))
    if s.turn is not None:
        m.turn = turn_rate(m, s.turn)


def turn_rate(m: Machine, turn: Quantity) -> float:
    """[rad/s] that a move turns its tool at no faster; a bound of zero would keep it from turning at all."""
    value = quantity(m, turn)
    return _checked(m, UNITS[SpeedUnit.TURN], value) if value <= 0.0 else value


def part_speed(m: Machine, part: MovePart, leading: tuple[int, float]) -> tuple[int, int, float]:
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


def move_speed(m: Machine, speed: Speed | None, path: int) -> tuple[int, float]:
    """(unit, SI value) of a move's own speed, or of the one that holds."""
    if speed is None:
        return _modal_speed(
            m, FRACTION if path == JOINT and AXIS not in m.modal else AXIS if path == JOINT else TRAVEL
        )
    unit = UNITS[speed.unit]
    written, scale = speed.value
    value = (written.value if type(written) is Number else number(m, written)) * scale
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
_OUTER, _INNER = "uframe", "oframe"  # of a work object's record (ABB: wobjdata)


def set_tool(m: Machine, s: SetTool) -> None:
    m.active_tool = tool_number(m, s.tool)


def set_frame(m: Machine, s: SetFrame) -> None:
    m.active_frame = frame_place(m, s.frame)


def set_override(m: Machine, s: SetOverride) -> None:
    share = quantity(m, s.share)
    if not 0.0 < share <= 1.0:
        raise StatementError("I306", f"an override of {share:.0%} is left out", "write 1 .. 100 %")
    m.override = share
    m.fastest = math.inf if s.fastest is None else _checked(m, TRAVEL, quantity(m, s.fastest))


def obey_flags(m: Machine, s: ObeyFlags) -> None:
    m.obeys_flags = s.on


def set_acceleration(m: Machine, s: SetAcceleration) -> None:
    """Keeps the accelerations for moves that name none, for joint moves, for all others, or for both."""
    for rate in s.rates:
        value = quantity(m, rate.value)
        if value <= 0.0:
            raise StatementError(
                "I307", "an acceleration that is not above zero is left out", "write one above 0"
            )
        if rate.unit is AccelerationUnit.FRACTION:
            for joint in (True, False):
                if s.path is None or joint is (s.path is Path.JOINT):
                    m.rates[(joint, RATE_FRACTION)] = min(value, 1.0)
        else:
            m.rates[(rate.unit is AccelerationUnit.AXIS, RATE_ABSOLUTE)] = value


def set_blend(m: Machine, s: SetBlend) -> None:
    for blend in s.blends:
        if blend.value is not None:
            m.blends[blend.kind] = max(0.0, quantity(m, blend.value))


def tool_number(m: Machine, tool: Expression) -> int:
    """The number in the cell of a tool: its own, or one given to its value. Raises StatementError."""
    if isinstance(tool, FrameRef):
        number = whole(m, tool.number) if tool.number is not None else 0
        return m.tool_now.get(number, number)
    if (pose := _elsewhere(m, tool, "tool", "the flange")) is not None:
        return _number_of(m, "tool", pose, m.world.tools)
    value = evaluate(m, tool)
    if isinstance(value, (int, float)):
        return m.tool_now.get(int(value), int(value))
    if isinstance(value, Record) and value.members.get("robhold") is False:
        m.assume_once(
            "held work",
            f"{spell(tool)} stands beside the robot: speeds about it are taken as the robot's own",
        )
    pose = raw_pose(as_position(_member(value, _FLANGE)))
    return _number_of(m, "tool", pose, m.world.tools)


def frame_place(m: Machine, frame: Expression) -> tuple[str, int | None]:
    """Where targets stand: base, or user and the number in the cell of a frame. Raises StatementError."""
    if isinstance(frame, FrameRef):
        if frame.kind in ("base", "robot"):
            return "base", None
        number = whole(m, frame.number) if frame.number is not None else 0
        return "user", m.user_now.get(number, number)
    pose = _elsewhere(m, frame, "frame", "the base")
    if pose is None:
        value = evaluate(m, frame)
        if isinstance(value, (int, float)):
            number = int(value)
            return ("user", m.user_now.get(number, number)) if number else ("base", None)
        pose = _work_pose(value)
    if _told(pose)[1]:
        return "base", None
    return "user", _number_of(m, "user", pose, m.world.cell.user_frames)


def _elsewhere(m: Machine, e: Expression, kind: str, taken: str) -> Pose | None:
    """Where a tool or frame is that a file declares which is not here: `taken`, which is told; None where one is."""
    name = e.base if isinstance(e, Item) else e
    if not isinstance(name, Named) or name.name.casefold() in m.assumptions.names:
        return None
    slot = find_slot(m, name.name)
    if slot is not None and slot.value is not None:
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
    outer = raw_pose(as_position(members[_OUTER]))
    return outer @ raw_pose(as_position(members[_INNER])) if _INNER in members else outer


def _member(value: Value, names: tuple[str, ...]) -> Value:
    if not isinstance(value, Record):
        return value
    found = next((v for name, v in value.members.items() if name.casefold() in names), None)
    return value if found is None else found


def _number_of(m: Machine, kind: str, pose: Pose, known: Mapping[int, object]) -> int:
    """A number that stands for this pose from now on."""
    values = _told(pose)[0]
    number = m.placed.get((kind, values))
    if number is None:
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
