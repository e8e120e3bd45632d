"""Text for the terminal: a table per program, its totals, assumptions and problems."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from olp.core.diagnostic import Diagnostic
from olp.core.source import file_name
from olp.core.terminal import BOLD, DIM, RED, YELLOW, paint
from olp.reports.cell import (
    CellRow,
    ProgramCost,
    cell_tree,
    common_folder,
    spelled_time,
    started,
    told_branches,
    told_causes,
)
from olp.reports.formats import _table
from olp.reports.formats.report import Options, Report, ReportPart

if TYPE_CHECKING:
    from olp.timing.result import Timing

_STATEMENT, _LIMITED = 1, 6
_UNKNOWN = "unknown"
_NARROWEST = 12  # characters of a column that is cut
_OVERVIEW = ("file", "total s", "motion s", "waits s", "I/O s", "assumed", "problems")


class TextReport(Report):
    """Aligned columns. Diagnostics go to the error stream, where every command puts them, not into the table."""

    summary = "a table for people"
    suffixes = (".txt",)

    def part(
        self, file: str, timing: Timing | None, diagnostics: Sequence[Diagnostic], options: Options
    ) -> str:
        if timing is None or not options.segments:
            return ""
        body = list(_table.rows(timing))
        header, *rows = _aligned([_table.HEADER, *body], _table.LEFT, options.width, _STATEMENT)
        if options.colour:
            header, rows = paint(header, BOLD), list(map(_painted, rows, body))
        if not body:
            header = "no move, wait or signal was executed"
        total = _table.totals(timing)
        lines = [file, header, *rows, "", paint(total, BOLD) if options.colour else total]
        if lacking := _table.missing(timing):
            lines.append(paint(lacking, RED) if options.colour else lacking)
        lines += [f"assumed: {says}" for says in _table.grouped(timing)]
        if timing.plan.stop_reason:
            lines.append(f"stopped: {timing.plan.stop_reason}")
        return "\n".join(lines) + "\n"

    def join(self, parts: Sequence[ReportPart], options: Options) -> str:
        text = "" if options.by else "\n".join(part.text for part in parts if part.text)
        blocks = [text] if text else []
        if (len(parts) > 1 and options.by in ("", "job")) or not (blocks or options.by):
            blocks.append(_overview(parts, options))
        first = started(parts)
        told = [
            f"{file_name(parts[i].file)}: {says}"
            for i in first
            for says in told_branches(parts[i].branches, _table.at_least)
        ]
        if told and not options.by:
            blocks.append("\n".join(told) + "\n")
        costs = [cost for i in first if (cost := parts[i].cost) is not None]
        if costs:
            cost = sum(costs[1:], costs[0] + ProgramCost())
            if options.by in ("", "cause"):
                blocks.append(f"where the time goes: {told_causes(cost.by_cause)}\n")
            if options.by in ("", "line") and cost.lines:
                blocks.append(_costliest(cost, options))
        return "\n".join(blocks)


_COSTLIEST = ("time s", "share", "runs", "line", "statement", "mostly", "what would help")


def _costliest(cost: ProgramCost, options: Options) -> str:
    """Table of the costliest lines, over all programs that a controller starts."""
    total = sum(cost.by_cause) or 1.0
    rows: list[tuple[str, ...]] = [
        (
            f"{line.seconds:.3f}",
            f"{100 * line.seconds / total:.0f} %",
            str(line.runs),
            f"{file_name(line.file)}:{line.line}",
            line.statement,
            line.cause,
            line.helps,
        )
        for line in cost.lines[: options.top or _FEW]
    ]
    head = f"the {len(rows)} lines that cost most" if len(rows) > 1 else "the line that costs most"
    table = _aligned([_COSTLIEST, *rows], {3, 4, 5, 6}, options.width, 4)
    return "\n".join([head, *table]) + "\n"


_FEW = 10


def _overview(parts: Sequence[ReportPart], options: Options) -> str:
    """A row per program, called ones below their first caller, and a row with the total."""
    order = cell_tree(parts)
    if options.sort:
        flat = (CellRow(row.index, 0) for row in order)
        order = sorted(flat, key=lambda row: _sorted_by(parts[row.index], options.sort))
    folder = common_folder([part.file for part in parts])
    rows: list[tuple[str, ...]] = [
        ("  " * row.depth + parts[row.index].file[len(folder) :], *_summary(parts[row.index])[1:])
        for row in order
    ]
    title = []
    if len(parts) > 1:
        rows.append(_sum(parts))
        first = [parts[i].total_s or 0.0 for i in started(parts)]
        programs = f"{len(first)} program{'' if len(first) == 1 else 's'} that a controller starts"
        sentence = f"{programs}{{}}: {spelled_time(sum(first))}"
        place = f" in {folder}" if folder else ""
        title = [sentence.format("" if 0 < options.width < len(sentence) + len(place) else place)]
    table = _aligned([_OVERVIEW, *_short_names(rows, options.width)], {0}, options.width, 0)
    return "\n".join([*title, *table]) + "\n"


def _sorted_by(part: ReportPart, by: str) -> tuple[float, str]:
    return (-(part.total_s or 0.0) if by == "time" else 0.0, part.file)


def _painted(line: str, cells: Sequence[str]) -> str:
    """The line in colours: waits dim, unknown values red, speeds that are never reached yellow."""
    if _UNKNOWN in cells:
        return paint(line, RED)
    limited = cells[_LIMITED]
    if not limited:
        return paint(line, DIM)
    return paint(line, YELLOW) if limited.endswith("acceleration") else line


def _summary(part: ReportPart) -> tuple[str, ...]:
    problems = sum(d.is_error for d in part.diagnostics)
    return (part.file, *_times(part), str(part.assumed or ""), str(problems or ""))


def _times(part: ReportPart) -> tuple[str, ...]:
    if part.total_s is None:
        return ("not timed", "", "", "")
    others = (part.motion_s, part.wait_s, part.io_s)
    return (_table.at_least(part.total_s, part.is_partial), *(f"{t or 0.0:.3f}" for t in others))


def _sum(parts: Sequence[ReportPart]) -> tuple[str, ...]:
    """The last row. A called routine's time is part of its caller's, and is summed there only."""
    counted = [parts[index] for index in started(parts)]
    label = f"{len(parts)} files"
    if len(counted) < len(parts):
        label = f"{len(counted)} of {label}, calling the others"
    total, *others = (
        sum(getattr(part, name) or 0.0 for part in counted)
        for name in ("total_s", "motion_s", "wait_s", "io_s")
    )
    times = (_table.at_least(total, any(part.is_partial for part in parts)), *(f"{t:.3f}" for t in others))
    problems = sum(d.is_error for part in parts for d in part.diagnostics)
    assumed = sum(part.assumed for part in parts)
    return (label, *times, str(assumed or ""), str(problems or ""))


def _short_names(rows: Sequence[Sequence[str]], width: int) -> list[Sequence[str]]:
    """The same rows with file names cut at the start where the terminal is narrow, since their ends differ."""
    columns = list(zip(_OVERVIEW, *rows, strict=True))
    size = max(width - sum(2 + max(map(len, column)) for column in columns[1:]), _NARROWEST)
    if not width:
        return list(rows)
    return [(name if len(name) <= size else "…" + name[1 - size :], *rest) for name, *rest in rows]


def _aligned(rows: Sequence[Sequence[str]], left: set[int], width: int, elastic: int) -> list[str]:
    """Rows in columns two blanks apart; the `elastic` column is cut when a line would be wider than `width`."""
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    over = sum(widths) + 2 * (len(widths) - 1) - width
    if width and over > 0:
        widths[elastic] = max(widths[elastic] - over, _NARROWEST)
    lines = []
    for row in rows:
        cells = [_fit(cell, size, i in left) for i, (cell, size) in enumerate(zip(row, widths, strict=True))]
        lines.append("  ".join(cells).rstrip())
    return lines


def _fit(cell: str, size: int, left: bool) -> str:
    if len(cell) > size:
        cell = cell[: size - 1] + "…"
    return cell.ljust(size) if left else cell.rjust(size)
