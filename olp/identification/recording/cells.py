"""From cells to numbers, with every cell that cannot be one told by its row and column.

Codes: D014 not a number, D015 a value that cannot be.
"""

from __future__ import annotations

import re
from collections import Counter
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from olp.core.diagnostic import Diagnostic, Severity, Span
from olp.identification.recording.columns import ColumnRule
from olp.identification.recording.table import SHOWN, Floats, RecordingTable, TableColumn

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
    with np.errstate(invalid="ignore"):
        low = values <= rule.lowest if rule.above else values < rule.lowest
        outside = low | (values > rule.highest)
        broken = (values % 1 != 0) & ~np.isnan(values) if rule.whole else np.zeros(len(values), dtype=bool)
    for row in np.nonzero(outside)[0].tolist():
        problems.cell("D015", f"{name} cannot be {values[row]:g}", row, name, _range(rule))
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


def _range(rule: ColumnRule) -> str:
    if np.isfinite(rule.highest):
        return f"it lies between {rule.lowest:g} and {rule.highest:g}"
    return f"it is {'above' if rule.above else 'at least'} {rule.lowest:g}"
