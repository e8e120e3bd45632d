"""Moves to taught points become moves to names, each with the frame and the tool that the point was taught with."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Final

from olp.ir.expressions import Expression, Item, Named, Number, Store, Taught, Variable
from olp.ir.points import PointKind, PointState
from olp.ir.program import Move, Path, Routine, Statement
from olp.ir.transformer import edited, is_usual, is_written_out
from olp.transpile.context import Fate
from olp.transpile.point_lowering import Points, frame_of, tool_of

Value = Callable[[Any], Any]  # of whatever holds expressions
_VALUES: Final = (
    "speed",
    "blend",
    "acceleration",
    "deceleration",
    "rate",
    "turn",
    "until",
    "search",
    "offset",
    "tool_offset",
    "other",
)
_MOVING: Final = ("tool", "master-tool")


def has_names(s: Move) -> bool:
    """Whether a move goes to a named position, and nothing else of it can be numbered."""
    return type(s.targets[0]) is Named and (is_written_out(s) or _names_systems(s))


def _names_systems(s: Move) -> bool:
    """Whether a move's tool and frame are names, and all else of it but the target numbers that are written out."""
    speed, blend = s.speed, s.blend
    return (
        type(s.tool) is Named
        and type(s.frame) is Named
        and len(s.targets) == 1
        and (speed is None or type(speed.value.written) is Number)
        and (blend is None or blend.value is None or type(blend.value.written) is Number)
        and is_usual(s)
    )


def lifted_move(points: Points, routine: Routine, s: Move, value: Value) -> list[Statement]:
    """The move with names; as it was, with a loss, where its target cannot be known."""
    if s.parts and _stands_still(points, s):
        says = "the station stands at the same place in all points: its part of the moves is left out"
        points.work.note_once(says)
        s = edited(s, {"parts": (), "coordinated": False})
    if s.parts or len(s.targets) > 1:
        points.work.lose(s, Fate.REFUSED, "groups", "a move of several control groups")
        return [s]
    state = _state(points, routine, s.targets[0], value)
    target = _target(points, routine, s, value, state)
    if target is None:
        return [s]
    via = None
    if s.via is not None:
        via = value(s.via)
        if isinstance(s.via, Taught):
            other = points.taught(routine, s.via.store, s.via.number)
            via = other if other is not None else via
    name, state = target
    changes: dict[str, Any] = {"via": via} if via is not None else {}
    if name is not s.targets[0]:
        changes["targets"] = (name,)
    for field in () if is_written_out(s) else ("speed", "blend") if is_usual(s) else _VALUES:
        old = getattr(s, field)
        if old is not None:
            new = value(old)
            if new is not old:
                changes[field] = new
    if state is not None and s.relative is None:
        if state.frame in _MOVING:
            points.work.lose(
                s, Fate.REFUSED, "frame", "the position is written in a frame that moves with the arm"
            )
            return [s]
        if s.tool is None:
            changes["tool"] = tool_of(state)
        if s.frame is None:
            changes["frame"] = frame_of(state)
    if None in changes.values():
        changes = {name: new for name, new in changes.items() if new is not None}
    if state is None and s.tool is None and s.relative is None and points.work.conventions.taught_frames:
        says = "in which frame and with which tool this position is meant is not known: base and flange are written"
        points.work.lose(s, Fate.APPROXIMATED, "frame", says)
    return [edited(s, changes) if changes else s]


def _stands_still(points: Points, s: Move) -> bool:
    """Whether all that a move has besides its arm are stations that no point of the program moves."""
    targets = [target for part in s.parts for target in part.targets]
    stations = all(type(target) is Taught and target.store is Store.STATION for target in targets)
    return bool(targets) and stations and points.station_stands()


def _state(points: Points, routine: Routine, target: Expression, value: Value) -> PointState | None:
    if isinstance(target, Taught):
        point = points.point(routine, target.store, target.number)
        return None if point is None else point.state
    if isinstance(target, Variable) and points.work.conventions.taught_frames:
        # A position register stands in whatever frame holds.
        name = value(target)
        name = name.base if isinstance(name, Item) else name
        return points.states.get(name.name) if isinstance(name, Named) else None
    return None


def _target(
    points: Points, routine: Routine, s: Move, value: Value, state: PointState | None
) -> tuple[Expression, PointState | None] | None:
    written = s.targets[0]
    if isinstance(written, (Taught, Variable)) and written.store is not Store.ROBOT:
        points.work.lose(s, Fate.REFUSED, "groups", "a move of a track or a station alone")
        return None
    if not isinstance(written, Taught):
        return value(written), state
    if state is not None and state.kind is not PointKind.POSE and s.path is not Path.JOINT:
        seen = points.in_space(routine, written.store, written.number)
        if seen is None:
            points.work.need_robot(s, "a straight move to a point in joint values is known by its robot only")
            return None
        literal, base = seen
        key = (routine.name, written.store, False, -1 - written.number)
        name = points.names.get(key)
        if name is None:
            name = points.names[key] = points.add(f"P{written.number}_pose", literal, base, 0)
        return Named(name), base
    name_ = points.taught(routine, written.store, written.number)
    if name_ is None:
        points.work.lose(s, Fate.REFUSED, "target", "the point has no values that can be known")
        return None
    return name_, state
