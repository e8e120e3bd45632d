"""The report: an index of all programs, and one program after the other to look into.

Nothing is loaded from elsewhere, and nothing of a program can become markup: the template escapes every value, the
page's policy allows no request, and only the script that comes with olp may run.

Codes: Y001 none of the programs can be shown.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from datetime import datetime
from pathlib import Path
from typing import Any

from markupsafe import Markup

from olp.core import resources
from olp.core.diagnostic import Diagnostic
from olp.core.files import parse_json
from olp.reports.cell import (
    BranchTime,
    CellLinks,
    ProgramCost,
    cell_tree,
    common_folder,
    cost_of,
    spelled_time,
    told_branches,
)
from olp.reports.diagnosis.svg import variables
from olp.reports.formats._table import at_least
from olp.reports.outcome.model import JudgedItem, Status
from olp.reports.page.data import PageShare, program_data, shares
from olp.reports.webpage import FOLDER, json_in_page, packed_in_page, render_page, script_of
from olp.timing.causes import CAUSES
from olp.timing.timing import Timing

_TEMPLATE = "report.html.j2"
_LIBRARIES = "vendored/libraries.js"
_SCRIPTS = "report_charts.js", "report_space.js", "report.js"
_STYLES = "vendored/uPlot.css", "report.css"
_LONGEST = 25  # lines of a program that are listed without the script
_LONGEST_OF_MANY = 10  # of each of several programs
_SUMMARY = '<script type="application/json" id="summary">', "</script>"
_MOST_S = 1e12  # [s] of a program in an earlier report
_TONES = dict(zip(CAUSES, ("teal", "blue", "red", "orange", "pink"), strict=True))
_STATUS = {Status.HELD: "held", Status.WARNED: "close", Status.FAILED: "over", Status.UNKNOWN: "unknown"}


@dataclass(frozen=True, slots=True)
class PageEntry:
    """One program of a report. `timing`: None where it could not be timed at all."""

    path: str
    timing: Timing | None
    diagnostics: tuple[Diagnostic, ...] = ()
    budgets: tuple[JudgedItem, ...] = ()
    links: CellLinks = field(default_factory=CellLinks)
    branches: tuple[BranchTime, ...] = ()

    @property
    def file(self) -> str:
        return self.path

    @property
    def is_unanswered(self) -> bool:
        """Whether there is an error, or a step without a time: what had to be assumed is told, and an answer."""
        timing = self.timing
        return timing is None or timing.untimed > 0 or any(d.is_error for d in self.diagnostics)

    @property
    def is_partial(self) -> bool:
        """Whether the total leaves something out: steps without a time, or lines that could not be run."""
        told = any(d.is_error for d in self.diagnostics)
        return self.timing is not None and (told or self.timing.untimed > 0 or bool(self.timing.left_open))


def report_page(
    entries: Sequence[PageEntry],
    title: str = "",
    before: str = "",
    now: datetime | None = None,
    hosted: bool = False,
) -> str:
    """One self-contained HTML file, UTF-8. `before`: the text of the last report, whose times are compared.

    `hosted`: for an editor's side view of one program, which has the text itself. The page then says through
    `acquireVsCodeApi` which line is clicked (`{file, line}`, the file's number as in its data) and that it is there
    (`{ready}`); messages `{select: {file, line}}` and `{program: {title, data}}` choose a line and renew the data.
    """
    scripts = [script_of(_LIBRARIES), script_of(*_SCRIPTS)]
    earlier = _earlier(before)
    room = shares([0 if entry.timing is None else len(entry.timing.plan) for entry in entries])
    costs = [ProgramCost() if entry.timing is None else cost_of(entry.timing, _LONGEST) for entry in entries]
    folder = common_folder([entry.path for entry in entries])
    most = _LONGEST if len(entries) == 1 else _LONGEST_OF_MANY
    programs = [
        {
            **_program(row.index, entries[row.index], earlier, costs[row.index], room[row.index]),
            "depth": row.depth,
            "shown": entries[row.index].path[len(folder) :],
            "longest": _lines(costs[row.index], entries[row.index].path)[:most],
        }
        for row in cell_tree(entries)
    ]
    known = [p["total_s"] for p in programs if p["total_s"] is not None]
    starting = [p for p in programs if not p["depth"]]
    total = sum(p["total_s"] or 0.0 for p in starting)
    whole = sum((costs[p["index"]] for p in starting), ProgramCost())
    summary = {p["path"]: p["total_s"] for p in programs}
    values: dict[str, Any] = {
        "title": title
        or (
            programs[0]["path"]
            if len(programs) == 1
            else f"{len(programs)} programs{f' in {folder}' if folder else ''}"
        ),
        "started": len(starting),
        "causes": _causes(whole),
        "costliest": _lines(whole, "")[:most] if len(programs) > 1 else [],
        "spelled": spelled_time(total),
        "css": Markup(variables() + "".join(resources.read_text(FOLDER, name) for name in _STYLES)),
        "scripts": [script for script, _ in scripts],
        "hashes": [found for _, found in scripts],
        "made": (now or datetime.now()).strftime("%Y-%m-%d %H:%M"),
        "programs": programs,
        "first": max(programs, key=lambda p: p["total_s"] or 0.0)["index"],
        "total": f"{total:.3f}",
        "untimed": len(programs) - len(known),
        "partial": any(p["partial"] for p in programs),
        "over": sum(item["status"] == "over" for p in programs for item in p["budgets"]),
        "trend": bool(earlier),
        "hosted": hosted,
        "summary": json_in_page(summary),
    }
    return render_page(_TEMPLATE, values)


def _program(
    index: int, entry: PageEntry, earlier: dict[str, float], cost: ProgramCost, share: PageShare
) -> dict[str, Any]:
    timing, before = entry.timing, earlier.get(entry.path)
    total = None if timing is None else timing.total_s
    change = None if total is None or before is None else total - before
    return {
        "index": index,
        "path": entry.path,
        "name": entry.path.replace("\\", "/").rpartition("/")[2],
        "total_s": None if total is None else round(total, 6),
        "total": "unknown" if total is None else f"{total:.3f}",
        "partial": entry.is_partial,
        "motion": "" if timing is None else f"{timing.motion_s:.3f}",
        "wait": "" if timing is None else f"{timing.wait_s:.3f}",
        "io": "" if timing is None else f"{timing.io_s:.3f}",
        "robot": (timing.robot or "robot not known") if timing is not None else "",
        "interval": ""
        if timing is None or timing.total_ends is None
        else "{:.3f} to {:.3f}".format(*timing.total_ends),
        "moves": 0 if timing is None else len(timing.plan),
        "untimed": 0 if timing is None else timing.untimed,
        "change": "" if change is None else f"{change:+.3f}",
        "worse": change is not None and change > 5e-4,
        "budgets": [{"name": i.name, "status": _STATUS[i.status], "says": i.message} for i in entry.budgets],
        "causes": _causes(cost),
        "branches": told_branches(entry.branches, at_least),
        "assumptions": [] if timing is None else [(a.line, a.says) for a in timing.assumptions],
        "diagnostics": [(str(d.severity), d.code, d.line, d.message, d.help) for d in entry.diagnostics],
        "data": packed_in_page(None if timing is None else program_data(timing, share)),
    }


def _causes(cost: ProgramCost) -> list[tuple[str, str, str, str]]:
    """Cause, seconds, share in percent, colour; the largest first."""
    total = sum(cost.by_cause)
    rows = sorted(zip(cost.by_cause, CAUSES, strict=True), reverse=True)
    return [(cause, f"{v:.3f}", f"{100 * v / total:.1f}", _TONES[cause]) for v, cause in rows if v > 0]


def _lines(cost: ProgramCost, main: str) -> list[tuple[str, ...]]:
    """The lines that take most: line, seconds, share, runs, statement, what limits them, what would help."""
    total = sum(cost.by_cause) or 1.0
    return [
        (
            str(line.line),
            f"{line.seconds:.3f}",
            f"{100 * line.seconds / total:.1f}",
            str(line.runs),
            f"{'' if line.file == main else Path(line.file).name + ': '}{line.statement}",
            line.limited_by,
            line.helps,
        )
        for line in cost.lines
    ]


def _earlier(text: str) -> dict[str, float]:
    """Path -> seconds of an earlier report; empty where the text is none."""
    begin, end = _SUMMARY
    try:
        known = parse_json(text.partition(begin)[2].partition(end)[0])
    except ValueError:
        return {}
    if not isinstance(known, dict):
        return {}
    return {
        name: float(seconds)
        for name, seconds in known.items()
        if isinstance(seconds, (int, float)) and not isinstance(seconds, bool) and 0 <= seconds < _MOST_S
    }
