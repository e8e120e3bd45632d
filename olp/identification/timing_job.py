"""Reads, plans and times one program with everything that a user may set: robot, model, law, signature."""

from __future__ import annotations

import os
from dataclasses import dataclass
from functools import lru_cache
from typing import TYPE_CHECKING

from olp.core.diagnostic import OlpError

if TYPE_CHECKING:
    from olp.core.diagnostic import Diagnostic
    from olp.ir.program import Program
    from olp.runtime.assumptions import Assumptions
    from olp.runtime.plan import Plan
    from olp.timing.correction import Correction
    from olp.timing.result import Timing


@dataclass(frozen=True, slots=True, kw_only=True)
class TimingJob:
    """How files are timed; everything a worker process needs. `acceleration` [m/s²], speed `override` [1]."""

    robot: str | None = None
    model: str | None = None
    acceleration: float | None = None
    encoding: str | None = None
    assumptions: str | None = None  # path of an olp.toml, else the nearest one
    max_steps: int | None = None  # statements of a run; None: what a cell needs
    cycles: int = 1
    override: float | None = None
    acceleration_law: str | None = None
    signature: str | None = None  # path of a signature file
    routine: str | None = (
        None  # that is started; None: the one that the language or the file names, else the first
    )


def plan_and_time(path: str, job: TimingJob) -> Timing:
    """Reads, plans and times one file. Raises OlpError when it cannot be read or planned at all."""
    from olp.languages.vendor import read

    return time_program(read(path, encoding=job.encoding), job)


def time_program(program: Program, job: TimingJob, folder: str | os.PathLike[str] | None = None) -> Timing:
    """Plans and times a program. `folder`: where what it calls stands, if not beside it.

    Raises OlpError when it cannot be planned at all.
    """
    from olp.runtime.dispatch import begun_at
    from olp.runtime.interpreter import run

    plan = run(
        program if job.routine is None else begun_at(program, job.routine),
        robot=job.robot,
        folder=folder,
        assumptions=_assumptions(job),
        cycles=job.cycles,
        max_steps=job.max_steps,
        first_move=True,
    )
    return time_plan_of(plan, job)


def time_plan_of(plan: Plan, job: TimingJob) -> Timing:
    """Times a plan as `job` says. Raises OlpError like `time_plan`."""
    from olp.timing.timing import time_plan

    learnt = _learnt(job.signature)
    return time_plan(plan, job.model, job.acceleration, job.override, job.acceleration_law, learnt)


def check_job(job: TimingJob) -> None:
    """Raises OlpError for a setting that would fail with every file: told once, before the first is read."""
    if job.robot is not None:
        from olp.robots.robot import load_robot

        load_robot(job.robot)
    if job.model is not None:
        from olp.timing.motion.model import load_model

        load_model(job.model)
    _learnt(job.signature)
    if job.acceleration_law is not None:
        from olp.timing.acceleration.law import load_law

        load_law(job.acceleration_law)
    if job.encoding is not None:
        from olp.languages.vendor import check_encoding

        check_encoding(job.encoding)
    from olp.runtime.assumptions import UNREADABLE

    problems = _mistakes(job)
    if any(one.code in UNREADABLE for one in problems):
        raise OlpError(*problems)


def check_assumptions(job: TimingJob) -> None:
    """Raises OlpError for a mistake in the olp.toml that was named: for commands whose plans do not tell it."""
    problems = _mistakes(job)
    if problems:
        raise OlpError(*problems)


def _mistakes(job: TimingJob) -> list[Diagnostic]:
    assumptions = _assumptions(job)
    return [] if assumptions is None else [one for one in assumptions.diagnostics if one.is_error]


@lru_cache(maxsize=4)
def _learnt(path: str | None) -> Correction | None:
    if path is None:
        return None
    from olp.identification.signature.correction import SignatureCorrection
    from olp.identification.signature.file import read_signature

    return SignatureCorrection(read_signature(path))


def _assumptions(job: TimingJob) -> Assumptions | None:
    if job.assumptions is None:
        return None
    from olp.runtime.assumptions import load_assumptions

    return load_assumptions(job.assumptions)
