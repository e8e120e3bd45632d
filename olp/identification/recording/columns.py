"""The names of columns and what stands in them: the contract of docs/recording.md as data."""

from __future__ import annotations

import difflib
import re
from collections import Counter
from collections.abc import Collection, Iterable
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from olp.core.diagnostic import Diagnostic, Severity, Span
from olp.core.units import deg, mm, percent
from olp.identification.recording.table import SHOWN, Floats, RecordingTable, TableColumn

# What no robot's recording holds, in any column's unit: products of such numbers are no numbers any more.
MOST: Final = 1e9
MOST_SECONDS: Final = 1e12  # clocks may count from 1970, in milliseconds
_LEAST = 1e-6  # of what is divided by: a millionth of a second, of a mm/s, of a percent


class ColumnRule(NamedTuple):
    """What a number of a column can be, and by how much it is multiplied to become SI."""

    factor: float = 1.0
    lowest: float = -MOST
    above: bool = False  # 0 itself is too low, and so is what is nearly 0
    highest: float = MOST
    whole: bool = False
    least: float = 0.0  # what is nearer to 0, but not 0, is no measurement

    def fits(self, values: NDArray[np.float64]) -> NDArray[np.bool_]:
        """(n,) whether each can be; what is nan can."""
        with np.errstate(invalid="ignore"):
            tiny = (values < _LEAST) if self.above else (values > 0) & (values < self.least)
            bad: NDArray[np.bool_] = tiny | (values < self.lowest) | (values > self.highest)
        return ~bad

    def told(self, value: float) -> str:
        """What a `value` that does not fit would have to be."""
        if self.highest != MOST:
            return f"it lies between {self.lowest:g} and {self.highest:g}"
        if value > self.highest:
            return f"it is at most {self.highest:g}"
        if value > 0.0:
            return f"it is {'' if self.above else '0 or '}at least {_LEAST:g}"
        return f"it is {'above' if self.above else 'at least'} {self.lowest:g}"


_DURATION = ColumnRule(lowest=0.0, least=_LEAST)

MOVE_NUMBERS: Final = {
    "move": ColumnRule(lowest=0.0, highest=MOST, whole=True),
    "duration_s": _DURATION,
    "sim_s": _DURATION,
    "speed_mm_s": ColumnRule(mm, 0.0, True),
    "speed_pct": ColumnRule(percent, 0.0, True),
    "accel_mm_s2": ColumnRule(mm, 0.0, True),
    "accel_pct": ColumnRule(percent, 0.0, True),
    "blend_mm": ColumnRule(mm, 0.0),
    "pl": ColumnRule(lowest=0.0, highest=8.0, whole=True),
    "t_start_s": ColumnRule(lowest=-MOST_SECONDS, highest=MOST_SECONDS),
    "cycle": ColumnRule(lowest=0.0, highest=MOST, whole=True),
    "line": ColumnRule(lowest=1.0, highest=MOST, whole=True),
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


def like_radians(joints: Floats, slides: tuple[bool, ...]) -> bool:
    """Whether joint values (n, k) [rad | m], read as degrees, look like radians: four axes or more that turn, and
    none farther than 7 degrees from 0. A whole turn is 6.3 radians; an arm that goes no farther than 7 degrees does
    no work.
    """
    turning = joints[:, ~np.array(slides, dtype=bool)]
    if turning.shape[1] < 4 or not len(turning):
        return False
    return bool(np.ptp(turning, axis=0).max() > 0.0) and bool(np.abs(turning).max() < 7 * deg)


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


_UNIT = re.compile(
    r"_(mm_s2|m_s2|mm_s|m_s|deg_s|rad_s|kg_m2|deg|rad|mm|m|ms|s|pct|percent|kg|c|nm|a|ticks|cycles)$"
)


def unit_of(name: str) -> str:
    """The unit at the end of a column's name, "" when it has none."""
    found = _UNIT.search(name.lower())
    return found[1] if found else ""


def _stem(name: str) -> str:
    """The name without its unit, "" when it has none or says nothing without it."""
    stem, changed = _UNIT.subn("", name.lower())
    return _plain(stem) if changed and len(stem) > 1 else ""


# --- Numbers of cells ---
# From cells to numbers, with every cell that cannot be one told by its row and column.
#
# Codes: D014 not a number, D015 a value that cannot be.

NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?")
_COMMA = re.compile(r"[+-]?\d+,\d+")


class Problems:
    """What is wrong with one table. Of each kind and column the first are told one by one, the rest counted."""

    def __init__(self, table: RecordingTable) -> None:
        self.table = table
        self.found: list[Diagnostic] = []
        self._count: Counter[tuple[str, str]] = Counter()

    def cell(
        self,
        code: str,
        message: str,
        row: int,
        name: str,
        help: str = "",
        severity: Severity = Severity.ERROR,
    ) -> None:
        """A problem in the cell of `row` (from 0; -1: the header) and the column `name`."""
        self._count[code, name] += 1
        if self._count[code, name] > SHOWN:
            return
        index = self.table.names.index(name) if name in self.table.names else 0
        span, source = self.table.place(row, index)
        if span is None and row >= 0:
            message = f"row {row + 1}: {message}"
        line, column, end = span or Span(0)
        self.found.append(
            Diagnostic(code, message, severity, self.table.file, line, column, end, help, source)
        )

    def whole(self, code: str, message: str, help: str = "", severity: Severity = Severity.ERROR) -> None:
        """A problem of the table as a whole."""
        self.found.append(Diagnostic(code, message, severity, self.table.file, help=help))

    def all(self) -> list[Diagnostic]:
        """Everything found, with one line more for each kind that was cut short."""
        rest = [
            Diagnostic(code, f"column {name}: {count - SHOWN:,} more like this", file=self.table.file)
            for (code, name), count in self._count.items()
            if count > SHOWN
        ]
        return [*self.found, *rest]


class NumberColumn(NamedTuple):
    """(n,) as written, nan where nothing is written or no number; `bad`: rows that hold something else."""

    values: Floats
    bad: NDArray[np.intp]


def numbers(column: TableColumn) -> NumberColumn:
    """The cells as numbers. `nan` and `inf` are no numbers here: what is missing is left empty."""
    if column.values is not None:
        wrong = ~np.isfinite(column.values) & ~column.missing
        return NumberColumn(np.where(wrong | column.missing, np.nan, column.values), np.nonzero(wrong)[0])
    cells = column.text or ()
    values, bad = np.full(len(cells), np.nan), []
    for row, cell in enumerate(cells):
        if not cell:
            continue
        if NUMBER.fullmatch(cell) and np.isfinite(float(cell)):
            values[row] = float(cell)
        else:
            bad.append(row)
    return NumberColumn(values, np.array(bad, dtype=np.intp))


def texts(column: TableColumn) -> tuple[str, ...]:
    """The cells as text; numbers of a typed file as they are usually written."""
    if column.text is not None:
        return column.text
    assert column.values is not None
    cells = zip(column.values.tolist(), column.missing.tolist(), strict=True)
    return tuple("" if missing else f"{value:.15g}" for value, missing in cells)


def checked(problems: Problems, name: str, column: TableColumn, rule: ColumnRule) -> Floats:
    """(n,) in SI. Cells that are no number (D014) or cannot be (D015) are told and nan."""
    values, bad = numbers(column)
    shown = texts(column) if len(bad) else ()
    for row in bad.tolist():
        tell_bad(problems, name, shown[row] if column.text is not None else "nan", row)
    outside = ~rule.fits(values)
    with np.errstate(invalid="ignore"):
        broken = (values % 1 != 0) & ~np.isnan(values) if rule.whole else np.zeros(len(values), dtype=bool)
    for row in np.nonzero(outside)[0].tolist():
        problems.cell("D015", f"{name} cannot be {values[row]:g}", row, name, rule.told(values[row]))
    for row in np.nonzero(broken & ~outside)[0].tolist():
        problems.cell("D015", f"{name} must be a whole number, not {values[row]:g}", row, name)
    good: Floats = np.where(outside | broken, np.nan, values) * rule.factor
    return good


def tell_bad(problems: Problems, name: str, cell: str, row: int) -> None:
    """Notes a cell that is no number: D015 when it says nan or infinity, else D014."""
    if cell.lower().strip("+-") in ("nan", "inf", "infinity") or NUMBER.fullmatch(cell):
        problems.cell(
            "D015", f"{name} cannot be {cell}", row, name, "leave the cell of a missing value empty"
        )
        return
    help = "the decimal mark is a point" if _COMMA.fullmatch(cell) else ""
    problems.cell("D014", f"{name} is not a number: {cell[:40]!r}", row, name, help)
