"""Times as an Excel workbook: a sheet of programs, one of rows, and one of a main program's branches.

Needs openpyxl. Text that begins like a formula is written as text. Code: Y002 openpyxl is not installed.
"""

from __future__ import annotations

import csv
import io
from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, Any

from olp.core.diagnostic import OlpError, error

if TYPE_CHECKING:
    from olp.reports.formats.report import ReportPart

_PROGRAMS = ("file", "depth", "robot", "total_s", "motion_s", "wait_s", "io_s", "started")
_BRANCHES = ("file", "decides", "line", "value", "leads_to_line", "total_s")
_LINES = ("file", "line", "statement", "runs", "seconds", "mostly", "what_would_help")


def workbook_of(table: str, parts: Sequence[ReportPart]) -> bytes:
    """The file. `table`: the rows of the report as CSV. Raises OlpError (Y002)."""
    from olp.reports.cell import cell_tree

    try:
        from openpyxl import Workbook
    except ImportError:
        raise OlpError(no_excel("written")) from None
    book = Workbook(write_only=True)
    programs = [
        (
            p.file,
            row.depth,
            p.robot,
            p.total_s,
            p.motion_s,
            p.wait_s,
            p.io_s,
            "yes" if row.depth == 0 else "no",
        )
        for row in cell_tree(parts)
        if (p := parts[row.index])
    ]
    _sheet(book, "programs", [_PROGRAMS, *programs])
    _sheet(book, "rows", _numbers(csv.reader(io.StringIO(table))))
    branches = [
        (p.file, b.decides, b.line, b.value, b.leads_to, b.total_s) for p in parts for b in p.branches
    ]
    if branches:
        _sheet(book, "branches", [_BRANCHES, *branches])
    lines = [
        (c.file, c.line, c.statement, c.runs, c.seconds, c.cause, c.helps)
        for p in parts
        if p.cost is not None
        for c in p.cost.lines
    ]
    if lines:
        _sheet(book, "costliest lines", [_LINES, *lines])
    data = io.BytesIO()
    book.save(data)
    return data.getvalue()


def no_excel(done: str) -> Any:
    """The error for a missing openpyxl."""
    return error(
        "Y002", f"a workbook is {done} by openpyxl, which is not installed", help='pip install "olp[excel]"'
    )


def _numbers(rows: Iterable[Sequence[str]]) -> Iterable[list[object]]:
    for row in rows:
        yield [_number(cell) for cell in row]


def _number(cell: str) -> object:
    try:
        return float(cell) if cell and cell[0] in "-.0123456789" else cell
    except ValueError:
        return cell


def _sheet(book: Any, title: str, rows: Iterable[Sequence[object]]) -> None:
    from openpyxl.cell import WriteOnlyCell
    from openpyxl.utils.exceptions import IllegalCharacterError

    sheet = book.create_sheet(title)
    sheet.freeze_panes = "A2"
    for row in rows:
        cells = []
        for value in row:
            try:
                cell = WriteOnlyCell(sheet, value)
            except IllegalCharacterError:
                cell = WriteOnlyCell(sheet, str(value).encode("unicode_escape").decode("ascii"))
            if isinstance(value, str):
                cell.data_type = "s"  # never a formula
            cells.append(cell)
        sheet.append(cells)
