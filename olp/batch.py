"""Times many files, on all cores when it pays. A file that cannot be read is a part with diagnostics, no exception."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from functools import lru_cache, partial
from typing import TYPE_CHECKING

from olp.diagnostic import Diagnostic, OlpError
from olp.report import Options, Part, load_report

if TYPE_CHECKING:
    from olp.assumptions import Assumptions
    from olp.plan import Plan
    from olp.program import Program
    from olp.signature import Signature
    from olp.timing import Timing

# Below this many files starting the workers costs more than they save.
_WORTH_WORKERS = 24
_CHUNK = 16


@dataclass(frozen=True, slots=True)
class Job:
    """How files are timed; everything a worker process needs. `acceleration` [m/s²], speed `override` [1]."""

    format: str = "text"
    options: Options = field(default_factory=Options)
    robot: str | None = None
    model: str | None = None
    acceleration: float | None = None
    encoding: str | None = None
    assumptions: str | None = None  # path of an olp.toml, else the nearest one
    max_steps: int = 2_000_000
    cycles: int = 1
    override: float | None = None
    acceleration_law: str | None = None
    signature: str | None = None  # path of a signature file


def time_files(
    paths: Sequence[str], job: Job, workers: int = 0, done: Callable[[int], None] | None = None
) -> list[Part]:
    """One part per path, in their order. `workers` 0: as many as there are cores. `done(n)` after each n files."""
    workers = min(workers or os.cpu_count() or 1, 1 + len(paths) // _WORTH_WORKERS)
    parts: list[Part] = []
    for part in _parts(paths, job, workers):
        parts.append(part)
        if done is not None:
            done(1)
    return parts


def _parts(paths: Sequence[str], job: Job, workers: int) -> Iterator[Part]:
    if workers <= 1:
        yield from map(partial(time_file, job=job), paths)
        return
    from concurrent.futures import ProcessPoolExecutor

    with ProcessPoolExecutor(workers) as pool:
        yield from pool.map(partial(time_file, job=job), paths, chunksize=_CHUNK)


def time_file(path: str, job: Job) -> Part:
    """Reads, plans and times one file, and renders its share of the report."""
    report = load_report(job.format)
    try:
        timing = plan_and_time(path, job)
    except OlpError as problem:
        diagnostics = tuple(d.at(path) for d in problem.diagnostics)
        return Part(path, report.part(path, None, diagnostics, job.options), diagnostics=diagnostics)
    diagnostics = tuple(d.at(path) for d in timing.diagnostics)
    text = report.part(path, timing, diagnostics, job.options)
    return Part(
        path,
        text,
        timing.robot,
        timing.total_s,
        timing.motion_s,
        timing.wait_s,
        timing.io_s,
        len(timing.assumptions),
        diagnostics,
        tuple(source.path for source in timing.plan.sources[1:]),
    )


def plan_and_time(path: str, job: Job) -> Timing:
    """Reads, plans and times one file. Raises OlpError when it cannot be read or planned at all."""
    from olp.reading import read

    return time_program(read(path, encoding=job.encoding), job)


def time_program(program: Program, job: Job, folder: str | os.PathLike[str] | None = None) -> Timing:
    """Plans and times a program. `folder`: where what it calls stands, if not beside it.

    Raises OlpError when it cannot be planned at all.
    """
    from olp.interpreter import run

    plan = run(
        program,
        robot=job.robot,
        folder=folder,
        assumptions=_assumptions(job),
        cycles=job.cycles,
        max_steps=job.max_steps,
    )
    return time_plan_of(plan, job)


def time_plan_of(plan: Plan, job: Job) -> Timing:
    """Times a plan as `job` says. Raises OlpError like `time_plan`."""
    from olp.timing import time_plan

    signature = _signature(job.signature)
    return time_plan(plan, job.model, job.acceleration, job.override, job.acceleration_law, signature)


def check_job(job: Job) -> None:
    """Raises OlpError for a setting that would fail with every file: told once, before the first is read."""
    if job.robot is not None:
        from olp.robot import load_robot

        load_robot(job.robot)
    if job.model is not None:
        from olp.motion import load_model

        load_model(job.model)
    _signature(job.signature)
    if job.acceleration_law is not None:
        from olp.acceleration import load_law

        load_law(job.acceleration_law)
    if job.encoding is not None:
        from olp.reading import check_encoding

        check_encoding(job.encoding)
    assumptions = _assumptions(job)
    if assumptions is not None and not os.path.exists(assumptions.path):
        raise OlpError(*assumptions.diagnostics)


@lru_cache(maxsize=4)
def _signature(path: str | None) -> Signature | None:
    if path is None:
        return None
    from olp.signature import read_signature

    return read_signature(path)


def _assumptions(job: Job) -> Assumptions | None:
    if job.assumptions is None:
        return None
    from olp.assumptions import load_assumptions

    return load_assumptions(job.assumptions)


def shown(parts: Sequence[Part]) -> list[Diagnostic]:
    """All diagnostics of all parts that a user should see, errors first within a file.

    What is wrong with a job that several others call is told once.
    """
    found = (d for part in parts for d in sorted(part.diagnostics, key=lambda d: (not d.is_error, d.line)))
    return list(dict.fromkeys(found))
