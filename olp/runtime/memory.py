"""The variables of a run: what each kind can hold, initial values, and what was changed when."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, NamedTuple

from olp.ir.expressions import POSITION_STORES, Store
from olp.ir.points import PointKind, PointState
from olp.runtime.assumptions import SignalKey, WrittenPosition

if TYPE_CHECKING:
    from olp.robots.backup.var_dat import PositionVariable


class PositionValue(NamedTuple):
    """A position as a variable holds it: pulses, radians, or metres and radians, as `state` says.

    `external`: further axes as written, mm or deg. `written_turn`: the four numbers of a quaternion that a program
    writes one by one, which have no unit length until the last, and the three angles [rad] that they gave.
    """

    state: PointState
    values: tuple[float, ...]
    external: tuple[float, ...] = ()
    written_turn: tuple[float, ...] = ()


class SystemPosition(NamedTuple):
    """Robot, base and station together."""

    parts: tuple[tuple[Store, PositionValue], ...]


@dataclass(slots=True)
class Record:
    """A structure's value. Copied when it is assigned. `partial`: members that are missing have no value yet."""

    type: str
    members: dict[str, Value]
    partial: bool = False


class AssumedResult(int):
    """The assumed value of a function whose text is not available; so are its elements."""


@dataclass(slots=True)
class Array:
    """An array's value; `None` where nothing was stored yet. Copied when it is assigned."""

    items: list[Value | None]


@dataclass(slots=True)
class Slot:
    """A named variable: what it holds (None: nothing yet) and its type as in `Declare.type`.

    `shared`: other files see it.
    """

    value: Value | None
    type: str = ""
    shared: bool = False


Value = int | float | str | bool | PositionValue | SystemPosition | Record | Array
Scope = dict[str, Slot]
Key = tuple[Store, int]
Changes = dict[tuple[str, int | str], int]

# Controller manuals: B 0..255, I and D two's complement of 16 and 32 bit.
RANGES: Mapping[Store, tuple[int, int]] = {
    Store.BYTE: (0, 255),
    Store.INTEGER: (-(2**15), 2**15 - 1),
    Store.DOUBLE: (-(2**31), 2**31 - 1),
}
INTEGERS = frozenset(RANGES)
WHOLE = -1  # of a named variable, see `Memory.changed`
ACTIVE = "active"  # the frame of a pose that is meant in the frame active at the move
EMPTY_PULSES = PositionValue(PointState(PointKind.PULSE), (0.0,) * 6)


@dataclass(slots=True)
class Memory:
    """Global variables and signals. `stamp` counts changes.

    `changed`: (kind or bus, index) -> stamp of the last change by the program. A name has 0 for any change, WHOLE for
    one that was not of a single element, and the indices of its elements.
    `assumed`: variables that are zero because nothing gave them a value.
    """

    values: dict[Key, Value] = field(default_factory=dict)
    signals: dict[SignalKey, int] = field(default_factory=dict)
    stamp: int = 0
    changed: Changes = field(default_factory=dict)
    assumed: set[Key] = field(default_factory=set)

    def put(self, key: Key, value: Value) -> None:
        """Stores a global value."""
        if self.values.get(key) != value:
            self.stamp += 1
            self.changed[key] = self.stamp
        if self.assumed:
            self.assumed.discard(key)
        self.values[key] = value


def zero(store: Store) -> Value:
    """The first value of a variable that nothing states."""
    if store in INTEGERS:
        return 0
    if store is Store.REAL:
        return 0.0
    return EMPTY_PULSES if store in POSITION_STORES else ""


# --- Saved values ---
# What a controller's backup holds of each kind of variable, and under which letters.

SAVED_NUMBERS = {Store.BYTE: "B", Store.INTEGER: "I", Store.DOUBLE: "D", Store.REAL: "R", Store.STRING: "S"}
SAVED_POSITIONS = {Store.ROBOT: "P", Store.BASE: "BP", Store.STATION: "EX"}


def saved_position(saved: PositionVariable) -> WrittenPosition:
    """A position of VAR.DAT, in pulses, radians or metres, with what holds for it."""
    if saved.kind == "PULSE":
        return WrittenPosition(PointState(PointKind.PULSE), saved.values)
    if saved.kind == "ANGLE":
        return WrittenPosition(PointState(PointKind.JOINT, "joint"), saved.values)
    return WrittenPosition(PointState(PointKind.POSE, saved.frame.lower() or "base"), saved.values)
