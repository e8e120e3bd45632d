"""CSV: one row per segment, wait or signal, the file in the last column; opens in any spreadsheet."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from olp.core.diagnostic import Diagnostic
from olp.core.terminal import csv_text
from olp.reports.formats.report import Options, Report, ReportPart

if TYPE_CHECKING:
    from olp.timing.result import Timing

_TOTALS = ("file", "robot", "total_s", "motion_s", "wait_s", "io_s", "untimed")


class Csv(Report):
    """RFC 4180 with a header row, `.` as decimal mark, units in the column names."""

    summary = "one row per segment, for spreadsheets"
    suffixes = (".csv",)

    def part(
        self, file: str, timing: Timing | None, diagnostics: Sequence[Diagnostic], options: Options
    ) -> str:
        if timing is None:
            return ""
        if not options.segments:
            totals = (f"{getattr(timing, name):.6f}" for name in _TOTALS[2:-1])
            return csv_text([[file, timing.robot or "", *totals, timing.untimed]])
        names = _header(options)
        return csv_text([_cell(segment.get(name)) for name in names] for segment in timing.segments())

    def join(self, parts: Sequence[ReportPart], options: Options) -> str:
        header = _header(options) if options.segments else _TOTALS
        return csv_text([header]) + "".join(part.text for part in parts)


def _header(options: Options) -> tuple[str, ...]:
    from olp.timing.result import COLUMNS

    return (*COLUMNS, "low_s", "high_s") if options.interval else COLUMNS


def _cell(value: object) -> object:
    """Rounded to a nanometre and a microsecond: further digits would be rounding noise."""
    return round(value, 6) if isinstance(value, float) else value
