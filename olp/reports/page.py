"""The report: an index of all programs, and a detailed view of each.

Nothing is loaded from elsewhere, and nothing of a program can become markup: the template escapes every value, the
page's policy allows no request, and only the script that comes with olp may run.

Codes: Y001 none of the programs can be shown.

For a program the page draws segments, the path, the speed over time and the text, from plain numbers with few
digits.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from datetime import datetime
from pathlib import PurePath
from typing import Any

import numpy as np
from markupsafe import Markup
from numpy.typing import NDArray

from olp.core import resources
from olp.core.diagnostic import Diagnostic
from olp.core.files import parse_json
from olp.core.source import file_name
from olp.core.units import deg, mm
from olp.ir.program import Path
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
from olp.reports.webpage import FOLDER, json_in_page, packed_in_page, printable, render_page, script_of
from olp.robots.model import Vector
from olp.runtime.plan import PATHS, StepKind
from olp.timing.causes import CAUSES
from olp.timing.result import Timing
from olp.timing.track import states, tool_position, tool_speed

Floats = NDArray[np.float64]
_ON_CURVE = 9  # points along an arc or spline
_ON_LINE = 4  # at most, along any other move: between them the page moves evenly
_CURVES = [PATHS.index(p) for p in (Path.CIRCULAR, Path.SPLINE)]


@dataclass(frozen=True, slots=True)
class PageShare:
    """Limits on the data of one program in a page, so that a page of about a megabyte opens quickly.

    `segments`: the first ones. `samples`: instants of the speed profile. `points`: of the path in space. `poses`:
    of the arm. `lines`: of text, all files together; of longer texts only lines that take time.
    """

    segments: int = 40_000
    samples: int = 4000
    points: int = 40_000
    poses: int = 2000
    lines: int = 12_000


def shares(segments: Sequence[int]) -> list[PageShare]:
    """The shares of programs with these numbers of segments in one page: short programs leave their rest to long
    ones.
    """
    whole, count = PageShare(), max(len(segments), 1)
    found = [0] * len(segments)
    left = whole.segments
    for place, index in enumerate(sorted(range(len(segments)), key=lambda i: segments[i])):
        found[index] = min(segments[index], left // (count - place))
        left -= found[index]
    samples, points, poses, lines = (
        min(max(size // count, least), most)
        for size, least, most in (
            (40_000, 200, whole.samples),
            (40_000, 300, whole.points),
            (12_000, 100, whole.poses),
            (20_000, 100, whole.lines),
        )
    )
    return [PageShare(n, samples, points, poses, lines) for n in found]


def program_data(timing: Timing, share: PageShare | None = None) -> dict[str, Any]:
    """The data of one program within its share, ready for JSON; templates/report.js draws them.

    `of`: number of its segments. One entry per segment: `line`, `file` (index into `files`), `kind` (into `kinds`),
    `rule` (into `rules`), `seconds`, `mm`, `speed` [mm/s] and `percent` as programmed, `reached` [mm/s], `accel`
    [mm/s²], `low` and `high` [s]; None where unknown. `profile`, `path`, `arm`: samples of the motion as in `olp
    track`; or None.
    """
    share = share or PageShare()
    plan, first = timing.plan, slice(0, share.segments)
    limited, of_kind = timing.limited_by[first], timing.kind[first]
    rules, kinds = sorted(set(limited)), sorted(set(of_kind))
    return {
        "of": len(plan),
        "line": plan.line[first].tolist(),
        "file": plan.source[first].tolist(),
        "kinds": kinds,
        "kind": [kinds.index(kind) for kind in of_kind],
        "rules": rules,
        "rule": [rules.index(rule) for rule in limited],
        "seconds": _short(timing.duration_s[first], 6),
        "mm": _short(timing.distance_mm[first], 3),
        "speed": _short(timing.speed_mm_s[first], 2),
        "percent": _short(timing.speed_pct[first], 2),
        "reached": _short(timing.reached_mm_s[first], 2),
        "accel": _short(timing.accel_mm_s2[first], 1),
        "low": None if timing.interval is None else _short(timing.interval.low[first], 6),
        "high": None if timing.interval is None else _short(timing.interval.high[first], 6),
        "profile": _profile(timing, share),
        "path": (path := _path(timing, share)),
        "arm": _arm(timing, share, path),
        "files": _files(timing, share),
    }


def _short(values: Floats, digits: int) -> list[float | None]:
    return [None if math.isnan(v) else round(v, digits) for v in values.tolist()]


def _profile(timing: Timing, share: PageShare) -> dict[str, Any] | None:
    """The tool's speed [mm/s] at even instants; None where no move can be followed."""
    total = float(timing.end_s[: share.segments][-1]) if share.segments and len(timing.plan) else 0.0
    if total <= 0 or not (timing.plan.kind == StepKind.MOVE).any() or timing.untimed:
        return None
    count = int(min(share.samples, max(200, 12 * len(timing.plan))))
    times = np.linspace(0.0, total, count)
    speed = tool_speed(timing, times) / mm
    if np.isnan(speed).all():
        return None
    return {"end": round(total, 6), "speed": [None if math.isnan(v) else round(v) for v in speed.tolist()]}


def _path(timing: Timing, share: PageShare) -> dict[str, Any] | None:
    """Polylines in space [mm]: points, the instant `t` [s] of each, and the step that leads to it."""
    plan = timing.plan
    moves = np.flatnonzero(plan.kind[: share.segments] == StepKind.MOVE)
    if not len(moves) or timing.untimed:
        return _corner_points(timing, share)
    ends, duration = timing.end_s[moves], np.nan_to_num(timing.duration_s[moves])
    curved = np.isin(plan.moves.path[plan.row[moves]], _CURVES)
    on_line = min(_ON_LINE, max(1, share.points // len(moves)))
    count = np.where(duration > 0, np.where(curved, _ON_CURVE, on_line), 1)
    of = np.repeat(np.arange(len(moves)), count)
    nth = np.arange(len(of)) - np.repeat(np.cumsum(count) - count, count) + 1
    rested = np.flatnonzero(
        np.diff(moves, prepend=-2) != 1
    )  # moves that begin after something else than a move
    times = np.concatenate((ends[of] - duration[of] * (1.0 - nth / count[of]), (ends - duration)[rested]))
    order = np.argsort(times, kind="stable")[:: -(-len(times) // share.points)]
    times, steps = times[order], moves[np.concatenate((of, rested))[order]]
    return _polyline(tool_position(timing, times) / mm, steps.tolist(), times)


def _corner_points(timing: Timing, share: PageShare) -> dict[str, Any] | None:
    """The targets alone, for timings with unknown times."""
    plan = timing.plan
    steps = np.flatnonzero(plan.kind[: share.segments] == StepKind.MOVE)
    targets = plan.moves.target[plan.row[steps]]
    return _polyline(plan.positions.position[targets] / mm, steps.tolist()) if len(steps) else None


def _polyline(position: Floats, steps: Sequence[int], times: Floats | None = None) -> dict[str, Any] | None:
    known = [all(map(math.isfinite, place)) for place in position.tolist()]
    if sum(known) < 2:
        return None
    place = np.round(position[known], 1)
    return {
        "t": None if times is None else _short(times[known], 4),
        "x": place[:, 0].tolist(),
        "y": place[:, 1].tolist(),
        "z": place[:, 2].tolist(),
        "step": [step for step, ok in zip(steps, known, strict=True) if ok],
    }


def _arm(timing: Timing, share: PageShare, path: dict[str, Any] | None) -> dict[str, Any] | None:
    """The arm: its chain [mm], and `axes` [deg, of a slide mm] at some of the path's instants `t` [s].

    `floor`: the height of the floor in the base frame [mm]; None if unknown. The result is None without geometry or
    angles.
    """
    robot = timing.plan.robot
    if robot is None or robot.geometry is None or path is None or path["t"] is None:
        return None
    times = np.array(path["t"])
    times = times[:: -(-len(times) // share.poses)]
    axes = states(timing, times)[2][:, : len(robot.axes)]
    if np.isnan(axes).any(axis=1).all():
        return None
    linear, geometry = [axis.linear for axis in robot.axes], robot.geometry
    units = np.where(linear, mm, deg)
    return {
        "names": list(robot.axis_names),
        "linear": linear,
        "t": times.tolist(),
        "axes": [_short(column, 2) for column in (axes / units).T],
        "joints": [
            {"axis": j.axis, "direction": j.direction, "offset": _in_mm(j.offset)} for j in geometry.joints
        ],
        "flange": _in_mm(geometry.flange_offset),
        "floor": None if geometry.base_height is None else round(-geometry.base_height / mm, 2),
    }


def _in_mm(offset: Vector) -> list[float]:
    return [round(v / mm, 3) for v in offset]


def _files(timing: Timing, share: PageShare) -> list[dict[str, Any]]:
    """The text of each file that ran; of very long ones only the lines that take time, with their numbers."""
    plan = timing.plan
    left = share.lines
    files = []
    for index, source in enumerate(plan.sources):
        if index and not (plan.source == index).any():
            continue
        lines = source.lines
        numbers = list(range(1, len(lines) + 1))
        if len(lines) > left:
            numbers = sorted(set(plan.line[plan.source == index].tolist()))[:left]
        left = max(0, left - len(numbers))
        files.append(
            {
                "index": index,
                "name": file_name(source.path),
                "lines": [printable(lines[n - 1].rstrip())[:200] for n in numbers],
                "numbers": numbers if len(numbers) != len(lines) else None,
            }
        )
    return files


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
        """Whether there is an error, or a step without a time; assumptions alone do not count."""
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
    """One self-contained HTML file, UTF-8. `before`: the text of the last report, for comparing the times.

    `hosted`: for an editor's side view of one program, which shows the text itself. The page then reports through
    `acquireVsCodeApi` the clicked line (`{file, line}`, with the file's index in its data) and that it has loaded
    (`{ready}`); the messages `{select: {file, line}}` and `{program: {title, data}}` select a line and replace the
    data.
    """
    scripts = [script_of(_LIBRARIES), script_of(*_SCRIPTS)]
    earlier = _earlier(before)
    room = shares([0 if entry.timing is None else len(entry.timing.plan) for entry in entries])
    costs = [ProgramCost() if entry.timing is None else cost_of(entry.timing, _LONGEST) for entry in entries]
    folder = common_folder([entry.path for entry in entries])
    most = _LONGEST if len(entries) == 1 else _LONGEST_OF_MANY
    programs: list[dict[str, Any]] = [
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
        "name": file_name(entry.path),
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
    """The lines that take most time: line, seconds, share, runs, statement, limit, and how to shorten it."""
    total = sum(cost.by_cause) or 1.0
    return [
        (
            str(line.line),
            f"{line.seconds:.3f}",
            f"{100 * line.seconds / total:.1f}",
            str(line.runs),
            f"{'' if line.file == main else PurePath(line.file).name + ': '}{line.statement}",
            line.limited_by,
            line.helps,
        )
        for line in cost.lines
    ]


def _earlier(text: str) -> dict[str, float]:
    """Seconds by path from an earlier report; empty if the text is not a report."""
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
