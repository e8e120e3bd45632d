"""What the variables hold, and where the arms stand, when a run begins: VAR.DAT, then olp.toml, which wins."""

from __future__ import annotations

from typing import TYPE_CHECKING

from olp.ir.expressions import Store
from olp.ir.points import PointKind, PointState
from olp.runtime.assumptions import WrittenPosition
from olp.runtime.memory import PositionValue
from olp.runtime.state import Machine

if TYPE_CHECKING:
    from olp.robots.backup import PositionVariable

NUMBERS = {Store.BYTE: "B", Store.INTEGER: "I", Store.DOUBLE: "D", Store.REAL: "R", Store.STRING: "S"}
POSITIONS = {Store.ROBOT: "P", Store.BASE: "BP", Store.STATION: "EX"}


def set_initial_values(m: Machine) -> None:
    """Fills the memory. Positions in the headers of routines, loaded before, win over VAR.DAT."""
    values = m.memory.values
    saved = m.world.backup.variables if m.world.backup is not None else None
    if saved is not None:
        for store, letters in NUMBERS.items():
            for index, value in getattr(saved, letters).items():
                values[(store, index)] = value
        for store, letters in POSITIONS.items():
            for index, position in getattr(saved, letters).items():
                values.setdefault((store, index), PositionValue(*saved_position(position)))
    for key, given in m.assumptions.variables.items():
        values[key] = PositionValue(*given) if isinstance(given, tuple) else given
    for name, start in m.assumptions.start.items():
        mechanism = m.add_mechanism(name)
        m.recorder.at[mechanism] = m.recorder.position(mechanism, start.state, start.values)


def saved_position(saved: PositionVariable) -> WrittenPosition:
    """A position of VAR.DAT, in pulses, radians or metres, with what holds for it."""
    if saved.kind == "PULSE":
        return WrittenPosition(PointState(PointKind.PULSE), saved.values)
    if saved.kind == "ANGLE":
        return WrittenPosition(PointState(PointKind.JOINT, "joint"), saved.values)
    return WrittenPosition(PointState(PointKind.POSE, saved.frame.lower() or "base"), saved.values)
