"""The names of columns and what stands in them: the contract of docs/recording.md as data."""

from __future__ import annotations

import difflib
import re
from collections.abc import Collection, Iterable
from typing import Final, NamedTuple

from olp.core.units import mm, percent

KINDS: Final = ("joint", "linear", "circular", "wait")


class ColumnRule(NamedTuple):
    """What a number of a column can be, and by how much it is multiplied to become SI."""

    factor: float = 1.0
    lowest: float = float("-inf")
    above: bool = False  # `lowest` itself is too low
    highest: float = float("inf")
    whole: bool = False


_DURATION, _POSITIVE, _ANY = ColumnRule(lowest=0.0), ColumnRule(lowest=0.0, above=True), ColumnRule()
_MOST = 1e9  # a counter beyond it counts nothing

MOVE_NUMBERS: Final = {
    "move": ColumnRule(lowest=0.0, highest=_MOST, whole=True),
    "duration_s": _DURATION,
    "sim_s": _DURATION,
    "speed_mm_s": ColumnRule(mm, 0.0, True),
    "speed_pct": ColumnRule(percent, 0.0, True),
    "accel_mm_s2": ColumnRule(mm, 0.0, True),
    "accel_pct": ColumnRule(percent, 0.0, True),
    "blend_mm": ColumnRule(mm, 0.0),
    "pl": ColumnRule(lowest=0.0, highest=8.0, whole=True),
    "t_start_s": _ANY,
    "cycle": ColumnRule(lowest=0.0, highest=_MOST, whole=True),
    "line": ColumnRule(lowest=1.0, highest=_MOST, whole=True),
    "payload_kg": ColumnRule(lowest=0.0),
    "payload_inertia_kg_m2": ColumnRule(lowest=0.0),
    "sim_payload_kg": ColumnRule(lowest=0.0),
    "sim_payload_inertia_kg_m2": ColumnRule(lowest=0.0),
    "override_pct": ColumnRule(percent, 0.0, True),
    "sim_override_pct": ColumnRule(percent, 0.0, True),
    "temperature_c": ColumnRule(lowest=-273.15),
}
MOVE_TEXTS: Final = ("type", "job")
POINTS: Final = {
    "start": tuple(f"{axis}_start_mm" for axis in "xyz"),
    "end": tuple(f"{axis}_end_mm" for axis in "xyz"),
    "via": tuple(f"{axis}_via_mm" for axis in "xyz"),
}
TURNS: Final = {
    "start": tuple(f"r{axis}_start_deg" for axis in "xyz"),
    "end": tuple(f"r{axis}_end_deg" for axis in "xyz"),
    "constant": tuple(f"r{axis}_deg" for axis in "xyz"),
}
LOG_POINT: Final = ("x_mm", "y_mm", "z_mm")
LOG_TURN: Final = TURNS["constant"]

_MOVE_AXIS = re.compile(r"q([1-9]\d?)_(start|end)_(deg|mm)")
_LOG_AXIS = re.compile(r"(q|qd|tau|i)([1-9]\d?)_(deg|mm|cmd_deg|cmd_mm|deg_s|mm_s|nm|n|a)")
LOG_UNITS: Final = {
    ("q", "deg"): ("q", False), ("q", "mm"): ("q", True), ("q", "cmd_deg"): ("command", False),
    ("q", "cmd_mm"): ("command", True), ("qd", "deg_s"): ("speed", False), ("qd", "mm_s"): ("speed", True),
    ("tau", "nm"): ("torque", False), ("tau", "n"): ("torque", True), ("i", "a"): ("current", False),
}  # fmt: skip


class AxisColumn(NamedTuple):
    """A column of one axis: `what` (start, end, q, command, speed, torque, current), counted from 1."""

    what: str
    number: int
    slides: bool  # millimetres instead of degrees


def move_axis(name: str) -> AxisColumn | None:
    """What a column of joint points of moves holds, None when it is none."""
    match = _MOVE_AXIS.fullmatch(name)
    return AxisColumn(match[2], int(match[1]), match[3] == "mm") if match else None


def log_axis(name: str) -> AxisColumn | None:
    """What a column of a log holds for one axis, None when it is none."""
    match = _LOG_AXIS.fullmatch(name)
    what = LOG_UNITS.get((match[1], match[3])) if match else None
    return AxisColumn(what[0], int(match[2]), what[1]) if match and what else None


def move_names(axes: int = 6) -> list[str]:
    """Every name that means something in moves.csv."""
    joints = [f"q{i}_{end}_deg" for i in range(1, axes + 1) for end in ("start", "end")]
    points = [name for names in (*POINTS.values(), *TURNS.values()) for name in names]
    return [*MOVE_NUMBERS, *MOVE_TEXTS, *points, *joints]


def log_names(axes: int = 6) -> list[str]:
    """Every name that means something in log.csv."""
    units = ("q{}_deg", "q{}_cmd_deg", "qd{}_deg_s", "tau{}_nm", "i{}_a")
    joints = [unit.format(i) for i in range(1, axes + 1) for unit in units]
    return ["t_s", "move", *LOG_POINT, *LOG_TURN, *joints]


def nearest(name: str, known: Iterable[str], taken: Collection[str] = ()) -> str:
    """The known name that `name` was probably meant to be, "" when none is near. `taken`: already in the file."""
    free = [other for other in known if other not in taken]
    plain = {_plain(other): other for other in free}
    if _plain(name) in plain:
        return plain[_plain(name)]
    # A name that ends in another unit (x_start_m, duration_ms) is the likeliest mistake of all.
    stems = {_stem(other): other for other in reversed(free) if _stem(other)}
    if _stem(name) in stems:
        return stems[_stem(name)]
    close = difflib.get_close_matches(_plain(name), plain, n=1, cutoff=0.85)
    return plain[close[0]] if close else ""


def _plain(name: str) -> str:
    return re.sub(r"[^a-z0-9]", "", name.lower())


_UNIT = re.compile(r"_(mm_s2|m_s2|mm_s|m_s|deg_s|rad_s|kg_m2|deg|rad|mm|m|ms|s|pct|percent|kg|c|nm|a)$")


def _stem(name: str) -> str:
    """The name without its unit, "" when it has none or says nothing without it."""
    stem, changed = _UNIT.subn("", name.lower())
    return _plain(stem) if changed and len(stem) > 1 else ""
