"""Targets of moves that are any expression, evaluated in the frame and with the tool of the move."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from olp.ir.expressions import Expression, FrameRef, Function, Named, Number, PositionLiteral, Store
from olp.ir.points import PointKind, PointState
from olp.ir.program import Move, Path, Statement
from olp.robots.coordinate_systems import EXTERNAL_AXES, in_frame
from olp.robots.geometry import Pose
from olp.runtime.evaluate import evaluate, find_slot, position_of
from olp.runtime.memory import ACTIVE, PositionValue
from olp.runtime.poses import (
    as_position,
    current_frames,
    frame_place,
    here,
    moved_by,
    pose_of,
    position_in,
    raw_pose,
    tool_number,
)
from olp.runtime.recorder import NOWHERE
from olp.runtime.spelling import spell
from olp.runtime.state import Machine, StatementError
from olp.runtime.structures import literal_position

Place = tuple[str, int | None]
_JOINT_PATH, _POSE = Path.JOINT, PointKind.POSE  # looked up once: every move asks
_JOINTS = PointState(PointKind.JOINT, "joint")
_POSE_SIZE = 6
_STANDING = frozenset({0.0, 9e9})  # of an axis beside the arm: at zero, or not connected
_AHEAD = 2_000  # statements
_FAR = 1e6  # [m, rad] what is farther is told where it is used


def place_of(m: Machine, mechanism: int, s: Move, target: Expression) -> int:
    """The pool index of a move's target or via point."""
    value = _value_of(m, mechanism, s, target)
    place = m.recorder.position(mechanism, value.state, value.values)
    if value.external and s.relative is None:
        m.recorder.further[place] = value.external
    return place


def arc_poses(m: Machine, mechanism: int, s: Move) -> tuple[Pose, Pose, Pose]:
    """Start, via point and target of an arc, in its own frame and with its own tool.

    Raises StatementError (I212) where the arm's place is not known.
    """
    assert s.via is not None
    tool, place = _own_tool(m, s), _own_place(m, s)
    values = (here(m, mechanism), *(_value_of(m, mechanism, s, e) for e in (s.via, s.targets[0])))
    start, via, end = (raw_pose(_seen(m, mechanism, value, place, tool)) for value in values)
    return start, via, end


def _own_tool(m: Machine, s: Move) -> int:
    return m.active_tool if s.tool is None else tool_number(m, s.tool)


def _own_place(m: Machine, s: Move) -> Place:
    return m.active_frame if s.frame is None else frame_place(m, s.frame)


def _value_of(m: Machine, mechanism: int, s: Move, target: Expression) -> PositionValue:
    """A move's target or via point, with all its components."""
    tool, place = _own_tool(m, s), _own_place(m, s)
    if m.made_up is not None:
        m.made_up.place = (*place, tool)
    value = literal_position(target) if type(target) is PositionLiteral else evaluate(m, target)
    if not isinstance(value, PositionValue):
        value = position_of(value, spell(target))
    own_tool = value.state.frame not in (ACTIVE, "joint") and s.tool is None
    value = position_in(value, place, value.state.tool if own_tool else tool)
    if value.state.frame == "user" or own_tool:
        # A taught point names its frame and tool by number; the program may have given them other values since.
        value = value._replace(state=current_frames(m, value.state))
    if not m.obeys_flags and s.path is _JOINT_PATH and value.state.configuration:
        value = value._replace(state=replace(value.state, configuration=(), sectors=()))
    state = value.state
    if s.frame is not None and state.kind is _POSE and (state.frame, state.user) != place:
        value = value._replace(state=state.at(place[0], place[1], state.tool))
    if s.relative is not None:
        value = _relative(m, mechanism, value, s.relative, place, tool)
    elif any(map(math.isnan, value.values)):
        value = _filled(m, mechanism, value)
    if m.shift is not None:
        value = _displaced(m, value)
    if s.offset is not None or s.tool_offset is not None:
        value = _offset(m, mechanism, s, value)
    if not _STANDING.issuperset(value.external) and any(
        v not in _STANDING and not math.isnan(v) for v in value.external
    ):
        m.assume_once("external axes", EXTERNAL_AXES)
    if m.conventions.systems_stay and s.tool is not None and s.frame is not None:
        m.active_tool, m.active_frame = tool, place
    return value


def _relative(
    m: Machine, mechanism: int, by: PositionValue, frame: FrameRef, place: Place, tool: int
) -> PositionValue:
    """The current position moved by the written components; the others stay."""
    values = tuple(0.0 if math.isnan(v) else v for v in by.values)
    if by.state.kind is PointKind.JOINT:
        start = _joints_here(m, mechanism)
        width = max(len(values), len(start))
        pairs = zip(_padded(start, width), _padded(values, width), strict=True)
        return by._replace(values=tuple(a + b for a, b in pairs))
    start_value = _seen(m, mechanism, here(m, mechanism), place, tool)
    if frame.kind != "tool":
        number = None if place[1] is None else Number(place[1])
        frame = FrameRef(place[0], number) if frame.kind == "own" else frame
    moved = moved_by(m, mechanism, start_value, by._replace(values=values), frame)
    return moved._replace(state=replace(moved.state, tool=tool))


def _filled(m: Machine, mechanism: int, value: PositionValue) -> PositionValue:
    """The position with the current values in place of components that are not written."""
    if value.state.kind is PointKind.JOINT:
        now = _joints_here(m, mechanism)
    else:
        state = value.state
        now = _seen(m, mechanism, here(m, mechanism), (state.frame, state.user), state.tool).values
    width = max(len(value.values), len(now))
    pairs = zip(_padded(value.values, width, math.nan), _padded(now, width), strict=True)
    return value._replace(values=tuple(b if math.isnan(a) else a for a, b in pairs))


def _padded(values: tuple[float, ...], width: int, by: float = 0.0) -> tuple[float, ...]:
    return values + (by,) * (width - len(values))


def _seen(m: Machine, mechanism: int, value: PositionValue, place: Place, tool: int) -> PositionValue:
    """A position as a pose in a frame, at a tool's centre point."""
    state = value.state
    if state.kind is PointKind.POSE and (state.frame, state.user) == place and state.tool == tool:
        return value
    pose = pose_of(m, mechanism, value)
    if state.tool != tool:
        cell = m.world.cell
        pose = pose @ cell.tool_pose(state.tool).inverse() @ cell.tool_pose(tool)
    frame = FrameRef(place[0], None if place[1] is None else Number(place[1]))
    origin = Pose.identity() if place[1] is None else m.world.cell.user_frame(place[1])
    seen = in_frame(pose, origin)
    state = replace(
        PointState(PointKind.POSE, frame.kind, place[1], tool, state.configuration), sectors=state.sectors
    )
    return PositionValue(state, tuple(float(v) for v in seen.xyz_angles()), value.external)


def _joints_here(m: Machine, mechanism: int) -> tuple[float, ...]:
    """Axis values [rad] where the arm stands. Raises StatementError (I212) where no robot lets them be known."""
    value = here(m, mechanism)
    if value.state.kind is PointKind.JOINT:
        return value.values
    robot = m.world.cell.robot(mechanism)
    axes = m.recorder.axes_here(mechanism)[: len(robot.axes) if robot is not None else 6]
    if np.isnan(axes).any():
        raise StatementError(
            "I212",
            "the axes of the arm are not known here",
            "say which robot it is: --robot maker/model, or robot = … in olp.toml",
        )
    from olp.robots.kinematics.configuration import readings_of_joints

    return tuple(float(v) for v in (axes if robot is None else readings_of_joints(robot, axes[None])[0]))


def _seed(m: Machine, mechanism: int) -> NDArray[np.float64] | None:
    """(k,) current axes; None where they are unknown."""
    try:
        return np.array(_joints_here(m, mechanism))
    except StatementError:
        return None


def _displaced(m: Machine, value: PositionValue) -> PositionValue:
    """A pose under the active program displacement (RAPID PDispSet): one more frame inside its own."""
    if m.shift is None or value.state.kind is not PointKind.POSE:
        return value
    pose = raw_pose(m.shift.offset) @ raw_pose(value)
    return value._replace(values=tuple(float(v) for v in pose.xyz_angles()))


def _offset(m: Machine, mechanism: int, s: Move, value: PositionValue) -> PositionValue:
    """The target moved by an offset in its frame, and by one along the tool's axes."""
    if value.state.kind is not PointKind.POSE:
        tool = value.state.tool
        value = _seen(m, mechanism, value, m.active_frame, tool)
    pose = raw_pose(value)
    if s.offset is not None:
        pose = raw_pose(as_position(evaluate(m, s.offset))) @ pose
    if s.tool_offset is not None:
        pose = pose @ raw_pose(as_position(evaluate(m, s.tool_offset)))
    return value._replace(values=tuple(float(v) for v in pose.xyz_angles()))


def current(
    m: Machine, joints: bool, tool: Expression | None = None, frame: Expression | None = None
) -> PositionValue:
    """The current axes, or the current pose in a frame and at a tool; without a name, the active ones."""
    from olp.runtime.state import role

    mechanism = role(m, 0, Store.ROBOT)
    if m.recorder.at[mechanism] == NOWHERE:
        here(m, mechanism)  # says that it is not known
    if joints:
        return PositionValue(PointState(PointKind.JOINT, "joint"), _joints_here(m, mechanism))
    place = m.active_frame if frame is None else frame_place(m, frame)
    number = m.active_tool if tool is None else tool_number(m, tool)
    seen = _seen(m, mechanism, here(m, mechanism), place, number)
    return seen._replace(state=replace(seen.state, frame=ACTIVE, user=None))


def joints_of(
    m: Machine,
    value: PositionValue,
    near: PositionValue | None = None,
    tool: Expression | None = None,
    frame: Expression | None = None,
) -> PositionValue:
    """The axes that reach a pose, nearest to `near`, or to where the arm is.

    With a tool and in a frame, those that hold where none is named. Raises StatementError (I212).
    """
    from olp.runtime.state import role

    if value.state.kind is PointKind.JOINT:
        return value
    mechanism = role(m, 0, Store.ROBOT)
    place = m.active_frame if frame is None else frame_place(m, frame)
    placed = position_in(value, place, m.active_tool if tool is None else tool_number(m, tool))
    rows = np.asarray([placed.values[:6]], dtype=np.float64)
    read = _seed(m, mechanism) if near is None else np.array(near.values)
    found = _axes_near(m, mechanism, placed.state, rows, None if read is None else read[None])
    if found is None or np.isnan(found).any():
        raise StatementError(
            "I212",
            "the axes that reach this pose are not known",
            "say which robot it is: --robot maker/model",
        )
    return PositionValue(_JOINTS, tuple(found[0].tolist()))


def _axes_near(
    m: Machine, mechanism: int, state: PointState, rows: NDArray[np.float64], read: NDArray[np.float64] | None
) -> NDArray[np.float64] | None:
    """Axes (n, k) that reach poses (n, 6) nearest to `read` (n, k), nan out of reach; None without a robot."""
    from olp.robots.kinematics.configuration import joints_of_readings, readings_of_joints

    robot = m.world.cell.robot(mechanism)
    seed = None
    if robot is not None and read is not None and read.shape[1] == len(robot.axes):
        seed = joints_of_readings(robot, read)
    axes = m.world.cell.resolve(mechanism, state, rows, seed).axes
    return None if robot is None else readings_of_joints(robot, axes[:, : len(robot.axes)])


def joints_near(m: Machine, value: PositionValue, near: PositionValue) -> PositionValue:
    """`joints_of` where a program gives the axes beside a pose: those of the moves that follow are found together.

    One by one they take ten times as long. Raises StatementError (I212).
    """
    body, at = m.frame.job.body, m.frame.pc
    if at > m.ahead.get(id(body), 0):
        m.ahead[id(body)] = at + _AHEAD
        _solve(m, [pair for s in body[at - 1 : at + _AHEAD] if (pair := _asked(m, s)) is not None])
    found = m.solved.get((value, near, m.active_tool, m.active_frame))
    return joints_of(m, value, near) if found is None else found


def _asked(m: Machine, s: Statement) -> tuple[PositionValue, PositionValue] | None:
    """The pose and the axes near it of a joint move to such a pair; None where its values are not known yet."""
    asked = s.targets[0] if type(s) is Move else None
    if type(asked) is not Function or asked.name != "inverse" or len(asked.arguments) != 2:
        return None
    if not all(_is_known(m, e) for e in asked.arguments):
        return None
    try:
        value, near = (as_position(evaluate(m, e)) for e in asked.arguments)
    except StatementError:  # which that statement will tell
        return None
    usual = value.state.kind is _POSE and near.state.kind is PointKind.JOINT
    sized = len(value.values) == _POSE_SIZE and len(near.values) == _POSE_SIZE
    return (value, near) if usual and sized and all(abs(v) < _FAR for v in value.values) else None


def _is_known(m: Machine, e: Expression) -> bool:
    """Whether the evaluation of an expression changes and reports nothing."""
    if type(e) is Named:
        slot = find_slot(m, e.name)
        return slot is not None and slot.value is not None
    if type(e) is Function:
        return e.name == "pose-product" and all(_is_known(m, one) for one in e.arguments)
    return type(e) is PositionLiteral


def _solve(m: Machine, asked: list[tuple[PositionValue, PositionValue]]) -> None:
    """Puts the axes of these poses into `m.solved`, as far as they can be reached."""
    from olp.runtime.state import role

    mechanism = role(m, 0, Store.ROBOT)
    groups: dict[PointState, list[tuple[PositionValue, PositionValue]]] = {}
    for one in asked:
        groups.setdefault(position_in(one[0], m.active_frame, m.active_tool).state, []).append(one)
    for state, pairs in groups.items():
        rows = np.array([value.values[:_POSE_SIZE] for value, _ in pairs])
        found = _axes_near(m, mechanism, state, rows, np.array([near.values for _, near in pairs]))
        for (value, near), axes in zip(pairs, () if found is None else found.tolist(), strict=False):
            if not any(map(math.isnan, axes)):
                m.solved[(value, near, m.active_tool, m.active_frame)] = PositionValue(_JOINTS, tuple(axes))


def pose_at(
    m: Machine, value: PositionValue, tool: Expression | None = None, frame: Expression | None = None
) -> PositionValue:
    """The pose that joint values reach, in a frame and at a tool, those that hold where none is named.

    Raises StatementError (I212).
    """
    from olp.runtime.state import role

    mechanism = role(m, 0, Store.ROBOT)
    place = m.active_frame if frame is None else frame_place(m, frame)
    number = m.active_tool if tool is None else tool_number(m, tool)
    seen = _seen(m, mechanism, position_in(value, place, number), place, number)
    return seen._replace(state=replace(seen.state, frame=ACTIVE, user=None))
