"""What holds for all following moves: tool, frame, accelerations, sizes of blends, override."""

from __future__ import annotations

from typing import TYPE_CHECKING

from olp.ir.expressions import Expression, FrameRef, Item, Named
from olp.ir.program import (
    AccelerationUnit,
    ObeyFlags,
    Path,
    SetAcceleration,
    SetBlend,
    SetFrame,
    SetOverride,
    SetTool,
)
from olp.robots.coordinate_systems import Tool
from olp.robots.geometry import Pose
from olp.runtime.evaluate import evaluate, quantity, whole
from olp.runtime.functions import FIRST_FRESH, as_position
from olp.runtime.memory import ACTIVE, PositionValue, Record, Value
from olp.runtime.poses import raw_pose
from olp.runtime.scope import find_slot
from olp.runtime.spelling import spell
from olp.runtime.state import Machine, StatementError

if TYPE_CHECKING:
    from collections.abc import Mapping

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
    if _is_elsewhere(m, tool, "tool", "the flange"):
        return _number_of(m, "tool", Pose.identity(), m.world.tools)
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
    if _is_elsewhere(m, frame, "frame", "the base"):
        return "base", None
    value = evaluate(m, frame)
    if isinstance(value, (int, float)):
        number = int(value)
        return ("user", m.user_now.get(number, number)) if number else ("base", None)
    pose = _work_pose(value)
    if pose == Pose.identity():
        return "base", None
    return "user", _number_of(m, "user", pose, m.world.cell.user_frames)


def _is_elsewhere(m: Machine, e: Expression, kind: str, taken: str) -> bool:
    """Whether a tool or frame has no value at hand, as a file that is not here declares it: `taken`, which is told."""
    name = e.base if isinstance(e, Item) else e
    if not isinstance(name, Named) or name.name.casefold() in m.assumptions.names:
        return False
    slot = find_slot(m, name.name)
    if slot is not None and slot.value is not None:
        return False
    says = f"nothing at hand gives the {kind} {name.name} a value (no file beside it, no [names] in olp.toml)"
    m.assume_once(f"{kind} {name.name}", f"{says}: {taken} is taken")
    return True


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
    values = tuple(float(v) for v in pose.xyz_angles())
    number = m.placed.get((kind, values))
    if number is None:
        number = m.placed[(kind, values)] = max(FIRST_FRESH, max(known, default=0) + 1)
        if kind == "tool":
            m.world.tools[number] = Tool(pose)
        else:
            m.world.cell.user_frames[number] = pose
    return number


def position_in(value: PositionValue, place: tuple[str, int | None], tool: int) -> PositionValue:
    """A pose without a frame of its own as one in `place`, seen at `tool`; joint values get the tool."""
    state = value.state
    if state.frame == ACTIVE:
        state = state.at(place[0], place[1], tool)
    elif state.tool != tool:
        state = state.at(state.frame, state.user, tool)
    return value if state is value.state else PositionValue(state, value.values, value.external)
