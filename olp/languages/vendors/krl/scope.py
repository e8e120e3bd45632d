"""What the names of a program mean: their first spelling, their type, their value where a data list gives one."""

from __future__ import annotations

from typing import Final, NamedTuple

from olp.ir import terminology
from olp.ir.expressions import Expression, Item, Member, Named, Number, Signal, SystemValue

CONFIG_MARK: Final = " of $config.dat"  # ends `Declare.native` of what stands in the controller's own list
POSES: Final = frozenset({"FRAME", "POS", "E6POS"})
AXES: Final = frozenset({"AXIS", "E6AXIS"})
NEUTRAL_TYPES: Final = {
    "INT": "integer",
    "REAL": "real",
    "BOOL": "boolean",
    "CHAR": "string",
    "FRAME": "frame",
    "POS": "position",
    "E6POS": "position",
    "AXIS": "joints",
    "E6AXIS": "joints",
}
COMPONENTS: Final = {
    "X": "x",
    "Y": "y",
    "Z": "z",
    "A": "rz",
    "B": "ry",
    "C": "rx",
    "S": "s",
    "T": "t",
    **{f"E{n}": f"e{n}" for n in range(1, 7)},
}
MODES: Final = {"#T1": "manual-reduced", "#T2": "manual-full", "#AUT": "automatic", "#EX": "automatic"}
AXIS_NUMBERS: Final = {f"A{n}": n for n in range(1, 7)}
SYSTEM_TYPES: Final = {
    "$TOOL": "FRAME",
    "$BASE": "FRAME",
    "$POS_ACT": "E6POS",
    "$POS_ACT_MES": "E6POS",
    "$AXIS_ACT": "E6AXIS",
    "$AXIS_ACT_MES": "E6AXIS",
    "$H_POS": "E6AXIS",
    "$NULLFRAME": "FRAME",
    "$WORLD": "FRAME",
    "$ROBROOT": "FRAME",
    "TOOL_DATA": "FRAME",
    "BASE_DATA": "FRAME",
    "$OV_PRO": "INT",
    "$APO": "APO",
    "$VEL": "CP",
    "$ACC": "CP",
    "$LOAD": "LOAD",
}
_SYSTEM_KINDS: Final = {
    "current-pose": "E6POS",
    "current-joints": "E6AXIS",
    "manual-reduced": "BOOL",
    "manual-full": "BOOL",
    **dict.fromkeys(terminology.STATES, "BOOL"),
    "timer": "INT",
    "timer-running": "BOOL",
}
_STRUCTURES: Final = {
    "FDAT": {"TOOL_NO": "INT", "BASE_NO": "INT", "IPO_FRAME": "IPO_MODE", "POINT2": "CHAR"},
    "PDAT": {"VEL": "REAL", "ACC": "REAL", "APO_DIST": "REAL", "APO_MODE": "APO_MODE", "GEAR_JERK": "REAL"},
    "LDAT": {"VEL": "REAL", "ACC": "REAL", "APO_DIST": "REAL", "APO_FAC": "REAL", "ORI_TYP": "ORI_TYPE"},
    "LOAD": {"M": "REAL", "CM": "FRAME", "J": "INERTIA"},
    "INERTIA": {"X": "REAL", "Y": "REAL", "Z": "REAL"},
    "APO": {"CPTP": "INT", "CDIS": "REAL", "CORI": "REAL", "CVEL": "INT"},
    "CP": {"CP": "REAL", "ORI1": "REAL", "ORI2": "REAL"},
    "EKI_STATUS": {"BUFF": "INT", "READ": "INT", "MSG_NO": "INT", "CONNECTED": "BOOL", "COUNTER": "INT"},
}


class KrlReference(NamedTuple):
    """A name with what stands behind it. `parts`: (member in capitals, ()) or ("", indices; None: left empty)."""

    key: str  # in capitals
    name: str
    parts: tuple[tuple[str, tuple[Expression | None, ...]], ...] = ()


class Scope:
    """Names of one file and the lists read with it; `enter` begins a routine, whose declarations hide those.

    `values`: constants of data lists by their name in capitals. `signals`: what SIGNAL has named.
    """

    def __init__(self) -> None:
        self._spellings: dict[str, str] = {}
        self.types: dict[str, str] = dict(SYSTEM_TYPES)
        self.local_types: dict[str, str] = {}
        self.structures: dict[str, dict[str, str]] = {name: dict(it) for name, it in _STRUCTURES.items()}
        self.signals: dict[str, Signal] = {}
        self.local_signals: dict[str, Signal] = {}
        self.values: dict[str, Expression] = {}
        self.arrays: set[str] = {"TOOL_DATA", "BASE_DATA"}
        self.inside = False

    def enter(self) -> None:
        """A routine begins."""
        self.local_types, self.local_signals, self.inside = {}, {}, True

    def leave(self) -> None:
        self.local_types, self.local_signals, self.inside = {}, {}, False

    def spell(self, word: str) -> str:
        """The name as it was spelt first: KRL does not tell capitals from small letters."""
        return self._spellings.setdefault(word.upper(), str(word))

    def declare(self, word: str, type: str, array: bool = False) -> None:
        """`type` in capitals."""
        if array:
            self.arrays.add(word.upper())
        (self.local_types if self.inside else self.types)[word.upper()] = type

    def keep(self, key: str, value: Expression) -> None:
        """What a list gives a name, in capitals."""
        self.values[key] = value

    def value_of(self, key: str) -> Expression | None:
        """What a list gives a name, in capitals; None where none does."""
        return self.values.get(key)

    def lay_out(self, kind: str, members: tuple[tuple[str, str], ...]) -> None:
        """STRUC `kind`, with its members and their types, all in capitals."""
        self.structures[kind] = dict(members)

    def has_layout(self, kind: str) -> bool:
        return kind in self.structures

    def type_of_member(self, kind: str, member: str) -> str:
        """All in capitals; empty where it is not known."""
        return self.structures.get(kind, {}).get(member, "")

    def name_signal(self, word: str, signal: Signal) -> None:
        (self.local_signals if self.inside else self.signals)[word.upper()] = signal

    def type_of_name(self, key: str) -> str:
        return self.local_types.get(key) or self.types.get(key, "")

    def known(self, key: str) -> bool:
        return key in self.local_types or key in self.types

    @property
    def signals_at_all(self) -> bool:
        """Whether SIGNAL has named any."""
        return bool(self.signals or self.local_signals)

    def signal(self, key: str) -> Signal | None:
        found = self.local_signals.get(key)
        if found is None and key not in self.local_types:
            found = self.signals.get(key)
        return found

    def type_of(self, it: Expression | None) -> str:
        """The KRL type in capitals, empty where it is not known."""
        kind = type(it)
        if kind is Named:
            return self.type_of_name(it.name.upper())  # type: ignore[union-attr]
        if kind is Number:
            return "INT" if isinstance(it.value, int) else "REAL"  # type: ignore[union-attr]
        if isinstance(it, Item):
            base = self.type_of(it.base)
            array = isinstance(it.base, Named) and it.base.name.upper() in self.arrays
            return "REAL" if base in AXES and not array else base
        if isinstance(it, Member):
            base = self.type_of(it.base)
            if base in POSES or base in AXES:
                return "INT" if it.name in ("s", "t") else "REAL"
            return self.structures.get(base, {}).get(it.name.upper(), "")
        if isinstance(it, Signal):
            return "INT" if it.bus.endswith("-group") else ""  # several signals are a whole number
        if isinstance(it, SystemValue):
            return _SYSTEM_KINDS.get(it.name, "FRAME")
        return ""

    def member(self, base: Expression, word: str) -> Expression:
        """`base.word`: components of positions by their neutral names, axes as elements."""
        key = word.upper()
        owner = self.type_of(base)
        if owner in AXES:
            number = AXIS_NUMBERS.get(key)
            if number is not None:
                return Item(base, (Number(number),))
        if not owner or owner in POSES or owner in AXES:
            component = COMPONENTS.get(key)
            if component is not None:
                return Member(base, component)
        return Member(base, self.spell(word))
