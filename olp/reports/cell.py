"""A cell: the programs that a controller starts, their calls, and where their time goes.

Totals of a cell are sums over the programs that a controller starts. A called program runs in its caller's time: it
is listed below its first caller, and not summed again.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple, Protocol

import numpy as np

from olp.ir.expressions import CallValue
from olp.ir.program import Assign, Call, Program
from olp.runtime.plan import BlendCode, StepKind
from olp.timing.causes import CAUSES, seconds_by_cause

if TYPE_CHECKING:
    from olp.runtime.plan import Plan
    from olp.timing.result import Timing

_SPEED, _RAMP, _STOP, _WAIT, _IO = range(len(CAUSES))


class CellLinks(NamedTuple):
    """Routines that other files may call in a file, and routines that it calls: names in upper case."""

    vendor: str = ""
    defines: tuple[str, ...] = ()
    calls: tuple[str, ...] = ()


def links_of(program: Program) -> CellLinks:
    own = {routine.name.upper() for routine in program.routines}
    own.add(Path(program.path).stem.upper())
    called = dict.fromkeys(name.upper() for name in _called(program))
    return CellLinks(program.vendor, tuple(sorted(own)), tuple(name for name in called if name not in own))


def with_run(links: CellLinks, plan: Plan) -> CellLinks:
    """`links` with the files that ran, including macros by their numbers."""
    ran = np.unique(plan.source).tolist()
    stems = (Path(plan.sources[source].path).stem.upper() for source in ran if source)
    return links._replace(calls=tuple(dict.fromkeys((*links.calls, *stems))))


def _called(program: Program) -> Iterator[str]:
    for s in program.statements():
        if isinstance(s, Call) and s.macro is None:
            yield s.routine
        elif isinstance(s, Assign) and isinstance(s.value, CallValue):
            yield s.value.routine


class CellMember(Protocol):
    """One program of a cell."""

    @property
    def file(self) -> str: ...
    @property
    def links(self) -> CellLinks: ...


@dataclass(frozen=True, slots=True)
class CellRow:
    """One program of a cell, by its index: below its first caller, `depth` calls from a program that a controller
    starts.
    """

    index: int
    depth: int


def cell_tree(parts: Sequence[CellMember]) -> list[CellRow]:
    """Every part once: those that a controller starts in their order, each followed by the parts that it is the
    first to call.
    """
    callees = _callees(parts)
    called = {callee for found in callees for callee in found}
    rows: list[CellRow] = []
    met: set[int] = set()

    def visit(start: int) -> None:
        waiting = [CellRow(start, 0)]
        while waiting:
            row = waiting.pop()
            if row.index in met:
                continue
            met.add(row.index)
            rows.append(row)
            waiting += [CellRow(callee, row.depth + 1) for callee in reversed(callees[row.index])]

    for index in [*(i for i in range(len(parts)) if i not in called), *range(len(parts))]:
        visit(index)  # of programs that call one another in a circle the first one is started
    return rows


def started(parts: Sequence[CellMember]) -> list[int]:
    """Indices of the programs that a controller starts."""
    return sorted(row.index for row in cell_tree(parts) if row.depth == 0)


def common_folder(files: Sequence[str]) -> str:
    """The folder that all files' names begin with, up to a slash, so that rows can omit it."""
    if len(files) < 2:
        return ""
    head = files[0].replace("\\", "/").rpartition("/")[0]
    while head and not all(file.replace("\\", "/").startswith(head + "/") for file in files):
        head = head.rpartition("/")[0]
    return head + "/" if head else ""


def _callees(parts: Sequence[CellMember]) -> list[list[int]]:
    """Indices of the other parts that each part calls, found as the run finds them."""
    places: dict[tuple[str, str, str], int] = {}
    for index, part in enumerate(parts):
        for name in part.links.defines:
            places.setdefault((part.links.vendor, os.path.dirname(os.path.abspath(part.file)), name), index)
    found: list[list[int]] = []
    for index, part in enumerate(parts):
        folders = _folders(part.links.vendor, os.path.dirname(os.path.abspath(part.file)))
        near = (
            next(
                (places[k] for folder in folders if (k := (part.links.vendor, folder, name)) in places), index
            )
            for name in part.links.calls
        )
        found.append([other for other in dict.fromkeys(near) if other != index])
    return found


@lru_cache(maxsize=1024)
def _folders(vendor: str, folder: str) -> tuple[str, ...]:
    from olp.languages.vendor import find_vendor, vendor_names

    if vendor not in vendor_names():
        return (folder,)
    return tuple(str(place) for place in find_vendor(vendor).folders_with(Path(folder)))


@dataclass(frozen=True, slots=True)
class LineCost:
    """One line of a program over all its executions: seconds [s], split by CAUSES, and how to make it shorter."""

    file: str
    line: int
    statement: str
    runs: int
    seconds: float
    by_cause: tuple[float, ...]
    limited_by: str
    helps: str

    def __add__(self, other: LineCost) -> LineCost:
        sums = tuple(a + b for a, b in zip(self.by_cause, other.by_cause, strict=True))
        return replace(self, runs=self.runs + other.runs, seconds=self.seconds + other.seconds, by_cause=sums)

    @property
    def cause(self) -> str:
        """The cause of most of its time."""
        return CAUSES[int(np.argmax(self.by_cause))]


@dataclass(frozen=True, slots=True)
class ProgramCost:
    """Where one program's time goes [s]: by CAUSES, and by its costliest lines, those of called jobs included."""

    by_cause: tuple[float, ...] = (0.0,) * len(CAUSES)
    lines: tuple[LineCost, ...] = ()

    def __add__(self, other: ProgramCost) -> ProgramCost:
        """The sum of both; a line that both programs run is counted as one."""
        known: dict[tuple[str, int], LineCost] = {}
        for cost in (*self.lines, *other.lines):
            key = os.path.normpath(cost.file), cost.line
            known[key] = known[key] + cost if key in known else cost
        lines = sorted(known.values(), key=lambda cost: -cost.seconds)
        sums = tuple(a + b for a, b in zip(self.by_cause, other.by_cause, strict=True))
        return ProgramCost(sums, tuple(lines))


def cost_of(timing: Timing, most: int) -> ProgramCost:
    """Sums over the steps of a program, the `most` costliest lines first."""
    shares = seconds_by_cause(timing)
    if not len(shares):
        return ProgramCost()
    plan = timing.plan
    keys = plan.source.astype(np.int64) << 32 | plan.line.astype(np.int64)
    _, first, of, runs = np.unique(keys, return_index=True, return_inverse=True, return_counts=True)
    sums = np.stack([np.bincount(of, column, len(first)) for column in shares.T], axis=1)
    seconds = sums.sum(axis=1)
    order = np.lexsort((first, -seconds))[:most]
    lines = []
    for n in order[seconds[order] > 0].tolist():
        steps = np.flatnonzero(of == n)
        step = int(steps[np.argmax(np.nan_to_num(timing.duration_s[steps]))])
        by_cause = tuple(round(float(v), 9) for v in sums[n])
        lines.append(
            LineCost(
                plan.sources[int(plan.source[step])].path,
                int(plan.line[step]),
                plan.statement(step),
                int(runs[n]),
                round(float(seconds[n]), 9),
                by_cause,
                timing.limited_by[step],
                _helps(timing, step, by_cause),
            )
        )
    return ProgramCost(tuple(round(float(v), 9) for v in shares.sum(axis=0)), tuple(lines))


def _helps(timing: Timing, step: int, by_cause: tuple[float, ...]) -> str:
    """What would shorten the line, and the most that this would save."""
    cause = int(np.argmax(by_cause))
    if cause == _WAIT:
        return "what it waits for, earlier"
    if cause == _IO:
        return "a quicker process, or its output set on the way"
    if timing.plan.kind[step] != StepKind.MOVE:
        return ""
    rule, stop = timing.limited_by[step], by_cause[_STOP]
    zone = ""
    if stop > 0.005 and timing.plan.moves.blend_code[timing.plan.row[step]] == BlendCode.EXACT:
        zone = f"a zone instead of the exact stop (up to {stop:.2f} s)"
    if cause == _STOP and zone:
        return zone
    if cause == _RAMP:
        return "; ".join(filter(None, (_softer(rule), zone)))
    return "; ".join(filter(None, (_faster(timing, step, rule), zone)))


def _softer(rule: str) -> str:
    if rule.startswith("axis") or " axis " in rule:
        return f"a pose that asks less of {rule.removesuffix(' acceleration').removesuffix(' speed')}"
    if rule.startswith("orientation"):
        return "less rotation of the tool along the path"
    return "fewer, longer moves: it gains and loses speed all the way"


def _faster(timing: Timing, step: int, rule: str) -> str:
    percent, speed = float(timing.speed_pct[step]), float(timing.speed_mm_s[step])
    if rule.startswith("orientation"):
        return "less rotation of the tool along the path"
    if percent < 99.5:
        return f"a higher speed than {percent:g} %"
    if "axis" in rule:
        return f"a pose that asks less of {rule.removesuffix(' speed')}, which is at its limit"
    if speed == speed:
        return f"a higher speed than {speed:g} mm/s"
    return "a shorter way"


@dataclass(frozen=True, slots=True)
class BranchTime:
    """One value of the variable that selects a branch in a main program: its target line, and the time of a run
    with it [s].
    """

    decides: str
    line: int
    value: str
    leads_to: int
    total_s: float | None
    partial: bool


def spelled_time(seconds: float) -> str:
    """A time in words: 41.2 s, 3 min 05 s, 1 h 32 min."""
    if seconds < 59.95:
        return f"{seconds:.1f} s"
    whole = round(seconds)
    if whole < 3600:
        return f"{whole // 60} min {whole % 60:02d} s"
    return f"{whole // 3600} h {whole % 3600 // 60:02d} min"


def told_causes(by_cause: Sequence[float]) -> str:
    """One sentence with the causes of the time, the largest first."""
    total = sum(by_cause)
    if total <= 0:
        return "nothing takes time"
    shares = sorted(zip(by_cause, CAUSES, strict=True), reverse=True)
    return ", ".join(f"{cause} {100 * v / total:.0f} % ({v:.3f} s)" for v, cause in shares if v > 0)


def told_branches(branches: Sequence[BranchTime], at_least: Callable[[float, bool], str]) -> list[str]:
    """One sentence per variable that selects a branch."""
    grouped: dict[tuple[str, int], list[BranchTime]] = {}
    for branch in branches:
        grouped.setdefault((branch.decides, branch.line), []).append(branch)
    grouped = {key: group for key, group in grouped.items() if any(b.total_s for b in group)}
    return [
        f"{decides} decides (line {line}): "
        + ", ".join(
            f"{b.value}: {'not timed' if b.total_s is None else at_least(b.total_s, b.partial) + ' s'}"
            f" (line {b.leads_to})"
            for b in group
        )
        for (decides, line), group in grouped.items()
    ]
