"""The report: an index of all programs, and one program after the other to look into.

Nothing is loaded from elsewhere, and nothing of a program can become markup: the template escapes every value, the
page's policy allows no request, and only the script that comes with olp may run.

Codes: Y001 none of the programs can be shown.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path
from typing import Any

from markupsafe import Markup

from olp.core import resources
from olp.core.diagnostic import Diagnostic
from olp.core.files import parse_json
from olp.reports.diagnosis.svg import variables
from olp.reports.outcome.model import JudgedItem, Status
from olp.reports.page.data import program_data
from olp.reports.webpage import FOLDER, json_in_page, render_page, script_of
from olp.timing.timing import Timing

_TEMPLATE = "report.html.j2"
_LONGEST = 25  # lines of a program that are listed without the script
_SUMMARY = '<script type="application/json" id="summary">', "</script>"
_MOST_S = 1e12  # [s] of a program in an earlier report
_STATUS = {Status.HELD: "held", Status.WARNED: "close", Status.FAILED: "over", Status.UNKNOWN: "unknown"}


@dataclass(frozen=True, slots=True)
class PageEntry:
    """One program of a report. `timing`: None where it could not be timed at all."""

    path: str
    timing: Timing | None
    diagnostics: tuple[Diagnostic, ...] = ()
    budgets: tuple[JudgedItem, ...] = ()

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
    script, script_hash = script_of("report.js")
    earlier = _earlier(before)
    programs = [_program(index, entry, earlier.get(entry.path)) for index, entry in enumerate(entries)]
    known = [p["total_s"] for p in programs if p["total_s"] is not None]
    summary = {p["path"]: p["total_s"] for p in programs}
    values: dict[str, Any] = {
        "title": title or (programs[0]["path"] if len(programs) == 1 else f"{len(programs)} programs"),
        "css": Markup(variables() + resources.read_text(FOLDER, "report.css")),
        "js": script,
        "js_hash": script_hash,
        "made": (now or datetime.now()).strftime("%Y-%m-%d %H:%M"),
        "programs": programs,
        "first": max(range(len(programs)), key=lambda i: programs[i]["total_s"] or 0.0),
        "total": f"{sum(known):.3f}",
        "untimed": len(programs) - len(known),
        "partial": any(p["partial"] for p in programs),
        "over": sum(item["status"] == "over" for p in programs for item in p["budgets"]),
        "trend": bool(earlier),
        "hosted": hosted,
        "summary": json_in_page(summary),
    }
    return render_page(_TEMPLATE, values)


def _program(index: int, entry: PageEntry, before: float | None) -> dict[str, Any]:
    timing = entry.timing
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
        "longest": [] if timing is None else _longest(timing),
        "assumptions": [] if timing is None else [(a.line, a.says) for a in timing.assumptions],
        "diagnostics": [(str(d.severity), d.code, d.line, d.message, d.help) for d in entry.diagnostics],
        "data": json_in_page(None if timing is None else program_data(timing)),
    }


def _longest(timing: Timing) -> list[tuple[str, ...]]:
    """The lines that take most, summed over their executions: line, statement, seconds, share, what limits them."""
    sums: dict[tuple[int, int], list[float]] = {}
    first: dict[tuple[int, int], int] = {}
    plan = timing.plan
    for step, seconds in enumerate(timing.duration_s.tolist()):
        key = int(plan.source[step]), int(plan.line[step])
        sums.setdefault(key, []).append(0.0 if seconds != seconds else seconds)
        first.setdefault(key, step)
    total = timing.total_s or 1.0
    rows: list[tuple[str, ...]] = []
    for key in sorted(sums, key=lambda k: -sum(sums[k]))[:_LONGEST]:
        seconds, step = sum(sums[key]), first[key]
        if seconds <= 0:
            break
        name = "" if key[0] == 0 else f"{Path(plan.sources[key[0]].path).name}: "
        rows.append(
            (
                str(key[1]),
                f"{name}{plan.statement(step)}",
                str(len(sums[key])),
                f"{seconds:.3f}",
                f"{100 * seconds / total:.1f}",
                timing.limited_by[step],
            )
        )
    return rows


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
