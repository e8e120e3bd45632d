"""Markdown: tables for a merge request, a wiki, a mail."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from olp.core.diagnostic import Diagnostic
from olp.reports.formats import _table
from olp.reports.formats.report import Options, Report, ReportPart

if TYPE_CHECKING:
    from olp.timing.result import Timing


class Markdown(Report):
    """A heading, a table, the totals and what was assumed, per program."""

    summary = "tables for merge requests and wikis"
    suffixes = (".md", ".markdown")

    def part(
        self, file: str, timing: Timing | None, diagnostics: Sequence[Diagnostic], options: Options
    ) -> str:
        lines = [f"## {_escape(file)}", ""]
        if timing is not None:
            if options.segments:
                lines += [
                    _row(_table.HEADER),
                    "| " + " | ".join(_rule()) + " |",
                    *map(_row, _table.rows(timing)),
                    "",
                ]
            lines += [f"**{_table.totals(timing)}**", ""]
            if lacking := _table.missing(timing):
                lines += [lacking, ""]
            if timing.assumptions:
                lines += ["Assumed:", ""]
                lines += [f"- {_escape(says)}" for says in _table.grouped(timing)] + [""]
        if diagnostics:
            lines += [f"- `{d.severity}[{d.code}]` {_place(d)}{_escape(d.message)}" for d in diagnostics] + [
                ""
            ]
        return "\n".join(lines)

    def join(self, parts: Sequence[ReportPart], options: Options) -> str:
        return "\n".join(part.text for part in parts)


def _place(diagnostic: Diagnostic) -> str:
    return f"line {diagnostic.line}: " if diagnostic.line else ""


def _rule() -> list[str]:
    return ["---" if i in _table.LEFT else "---:" for i in range(len(_table.HEADER))]


def _row(cells: Sequence[str]) -> str:
    return "| " + " | ".join(_escape(cell) for cell in cells) + " |"


def _escape(text: str) -> str:
    return text.replace("|", "\\|").replace("*", "\\*").replace("<", "&lt;")
