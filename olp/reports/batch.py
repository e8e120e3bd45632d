"""Times many files, on all cores when it pays. A file that cannot be read gives a part with diagnostics, not an
exception.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import partial

from olp.core.diagnostic import Diagnostic, OlpError
from olp.identification.timing_job import (
    TimingJob,
    check_job,
    plan_and_time,
    time_plan_of,
    time_program,
)
from olp.ir.program import Program
from olp.languages.vendor import read
from olp.reports.cell import BranchTime, CellLinks, cost_of, links_of, started, with_run
from olp.reports.formats.report import Options, ReportPart, load_report
from olp.runtime.dispatch import NoSuchRoutineError, begun_at, dispatches, taking

__all__ = [
    "Job",
    "TimingJob",
    "check_job",
    "plan_and_time",
    "shown",
    "time_file",
    "time_files",
    "time_plan_of",
    "time_program",
]

# Below this many files starting the workers costs more than they save.
_WORTH_WORKERS = 24
_CHUNK = 16


@dataclass(frozen=True, slots=True, kw_only=True)
class Job(TimingJob):
    """How files are timed and reported; all settings that a worker process needs."""

    format: str = "text"
    options: Options = field(default_factory=Options)


def time_files(
    paths: Sequence[str], job: Job, workers: int = 0, done: Callable[[int], None] | None = None
) -> list[ReportPart]:
    """One part per path, in their order; programs that a controller starts also get the times of their branches.

    `workers` 0: as many as there are cores. `done(n)` after each n files.
    """
    workers = min(workers or os.cpu_count() or 1, 1 + len(paths) // _WORTH_WORKERS)
    parts: list[ReportPart] = []
    for part in _parts(paths, job, workers):
        parts.append(part)
        if done is not None:
            done(1)
    first = set(started(parts))
    return [part if index in first else replace(part, branches=()) for index, part in enumerate(parts)]


def _parts(paths: Sequence[str], job: Job, workers: int) -> Iterator[ReportPart]:
    if workers <= 1:
        yield from map(partial(time_file, job=job), paths)
        return
    from concurrent.futures import ProcessPoolExecutor

    with ProcessPoolExecutor(workers) as pool:
        yield from pool.map(partial(time_file, job=job), paths, chunksize=_CHUNK)


def time_file(path: str, job: Job) -> ReportPart:
    """Reads, plans and times one file, and renders its share of the report."""
    report = load_report(job.format)
    links = CellLinks()
    try:
        program = read(path, encoding=job.encoding)
        links = links_of(program)
        timing = time_program(program, job)
        links = with_run(links, timing.plan)
        branches = branches_of(program, job)  # of called programs, too: who calls them is not known yet
    except OlpError as problem:
        diagnostics = tuple(d.at(path) for d in problem.diagnostics)
        text = report.part(path, None, diagnostics, job.options)
        lacks = isinstance(problem, NoSuchRoutineError)
        return ReportPart(path, text, diagnostics=diagnostics, links=links, lacks_start=lacks)
    diagnostics = tuple(d.at(path) for d in timing.diagnostics)
    return ReportPart(
        path,
        report.part(path, timing, diagnostics, job.options),
        timing.robot,
        timing.total_s,
        timing.motion_s,
        timing.wait_s,
        timing.io_s,
        len(timing.assumptions),
        diagnostics,
        links,
        cost_of(timing, job.options.top) if job.options.top or job.options.by else None,
        branches,
    )


def branch_times(path: str, job: TimingJob) -> tuple[BranchTime, ...]:
    """The branches of the program in a file; empty where it cannot be read."""
    try:
        return branches_of(read(path, encoding=job.encoding), job)
    except OlpError:
        return ()


def branches_of(program: Program, job: TimingJob) -> tuple[BranchTime, ...]:
    """Every branch of a main program that an external signal or value selects, timed. Empty if there are none."""
    if job.routine is not None:
        program = begun_at(program, job.routine)
    found = []
    for dispatch in dispatches(program):
        for choice in dispatch.choices:
            total, partial = None, True
            try:
                timing = time_program(taking(program, dispatch, choice), job)
                total, partial = timing.total_s, bool(timing.left_open)
            except OlpError:
                pass
            found.append(BranchTime(dispatch.name, dispatch.line, choice.name, choice.line, total, partial))
    return tuple(found)


def shown(parts: Sequence[ReportPart]) -> list[Diagnostic]:
    """All diagnostics of all parts for the user, errors first within a file.

    Problems of a job that several others call are reported once.
    """
    found = (d for part in parts for d in sorted(part.diagnostics, key=lambda d: (not d.is_error, d.line)))
    return list(dict.fromkeys(found))
