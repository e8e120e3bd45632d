"""The variables of a run: what each kind can hold, initial values, and what was changed when."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import NamedTuple

from olp.expression import POSITION_STORES, Store
from olp.points import PointKind, PointState


class PositionValue(NamedTuple):
    """A position as a variable holds it: pulses, radians, or metres and radians, as `state` says."""

    state: PointState
    values: tuple[float, ...]


class SystemPosition(NamedTuple):
    """Robot, base and station together."""

    parts: tuple[tuple[Store, PositionValue], ...]


Value = int | float | str | bool | PositionValue | SystemPosition
Key = tuple[Store, int]

# Controller manuals: B 0..255, I and D two's complement of 16 and 32 bit.
RANGES: Mapping[Store, tuple[int, int]] = {
    Store.BYTE: (0, 255),
    Store.INTEGER: (-(2**15), 2**15 - 1),
    Store.DOUBLE: (-(2**31), 2**31 - 1),
}
INTEGERS = frozenset(RANGES)
LETTERS: Mapping[Store, str] = {
    Store.BYTE: "B",
    Store.INTEGER: "I",
    Store.DOUBLE: "D",
    Store.REAL: "R",
    Store.STRING: "S",
    Store.ROBOT: "P",
    Store.BASE: "BP",
    Store.STATION: "EX",
    Store.SYSTEM: "PX",
}
EMPTY_PULSES = PositionValue(PointState(PointKind.PULSE), (0.0,) * 6)


@dataclass(slots=True)
class Memory:
    """Global variables. `stamp` counts changes; `changed[key]` is the stamp of a variable's last change."""

    values: dict[Key, Value] = field(default_factory=dict)
    signals: dict[tuple[str, int], int] = field(default_factory=dict)
    stamp: int = 0
    changed: dict[Key, int] = field(default_factory=dict)
    frames: dict[int, object] = field(default_factory=dict)

    def put(self, key: Key, value: Value) -> None:
        """Stores a global value."""
        if self.values.get(key) != value:
            self.stamp += 1
            self.changed[key] = self.stamp
        self.values[key] = value


def zero(store: Store) -> Value:
    """What a variable holds when nobody says."""
    if store in INTEGERS:
        return 0
    if store is Store.REAL:
        return 0.0
    return EMPTY_PULSES if store in POSITION_STORES else ""
