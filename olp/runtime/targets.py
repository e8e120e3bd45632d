"""Where a move goes: a written position as an entry of the plan's pool of positions."""

from __future__ import annotations

from olp.ir.expressions import FrameRef, Position, Store, Taught, Variable
from olp.runtime.evaluate import whole
from olp.runtime.memory import PositionValue
from olp.runtime.spelling import spell
from olp.runtime.state import Machine, StatementError
from olp.runtime.variables import read_variable


def place(m: Machine, mechanism: int, position: Position, store: Store, relative: FrameRef | None) -> int:
    """The pool index of where `position` is, or of where it leads from here when it is `relative`."""
    if m.plain and relative is None and isinstance(position, Taught):
        job = m.frame.job
        target = m.recorder.taught(mechanism, job.key, job.points, store, position.number)
        if target is None:
            raise missing(position)
        return target
    value = position_value(m, position, store)
    if relative is not None:
        from olp.runtime.poses import here, moved_by

        value = moved_by(m, mechanism, here(m, mechanism), value, relative)
    elif not m.plain:
        value = _current(m, mechanism, value)
    return m.recorder.position(mechanism, value.state, value.values)


def _current(m: Machine, mechanism: int, value: PositionValue) -> PositionValue:
    """The position under the shift and with the tools and frames that hold now."""
    from olp.runtime.poses import current_frames, moved_by

    value = PositionValue(current_frames(m, value.state), value.values)
    shift = m.shift
    if shift is None or not m.world.mechanisms[mechanism].is_robot:
        return value
    return moved_by(m, mechanism, value, shift.offset, shift.frame)


def position_value(m: Machine, position: Position, store: Store) -> PositionValue:
    """The written numbers of a position. Raises StatementError when it has none."""
    if isinstance(position, Taught):
        point = m.frame.job.points.find(store, True, position.number)
        if point is None:
            raise missing(position)
        return PositionValue(point.state, point.values)
    if not isinstance(position, Variable):
        raise StatementError("I209", f"nothing defines {spell(position)}", "declare the name, or correct it")
    value = read_variable(m, store, whole(m, position.index), position.local)
    if not isinstance(value, PositionValue):
        raise StatementError("I209", f"{spell(position)} is no position", "use a position variable")
    return value


def missing(position: Position) -> StatementError:
    """The error for a point that the routine does not teach."""
    return StatementError(
        "I206", f"the routine teaches no {spell(position)}", "add the point, or correct its number"
    )
