"""What is known of one text: the program, what happens when it runs, how long that takes, what is wrong."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from olp.diagnostic import Diagnostic, OlpError
from olp.language.document import Document
from olp.language.settings import Settings
from olp.memory import Memory, remembering
from olp.outcome.model import Finding
from olp.program import Program
from olp.source import Source
from olp.timing import Timing


class SupersededError(Exception):
    """A newer text has come: nobody wants the answer any more."""


class Runs(NamedTuple):
    """Executions of the lines of this file: `line` (r,) sorted, `step` (r,) in order of execution within a line."""

    line: NDArray[np.int32]
    step: NDArray[np.int64]


@dataclass(frozen=True)
class Analysis:
    """`edition` of the document that it is about. `program`, `timing` None: it could not be read, or run.

    `diagnostics`: those of `olp time`, of this file and of others it needs. `lint`: those of `olp lint` besides.
    """

    path: str
    edition: int
    source: Source
    settings: Settings
    program: Program | None = None
    timing: Timing | None = None
    diagnostics: tuple[Diagnostic, ...] = ()
    lint: tuple[Finding, ...] = ()
    linted: bool = False  # the rules have run over this edition

    @cached_property
    def runs(self) -> Runs:
        """Which steps belong to which line of this file."""
        if self.timing is None:
            return Runs(np.zeros(0, dtype=np.int32), np.zeros(0, dtype=np.int64))
        plan = self.timing.plan
        own = np.flatnonzero(plan.source == 0)
        order = own[np.argsort(plan.line[own], kind="stable")]
        return Runs(plan.line[order], order)

    def steps(self, line: int) -> list[int]:
        """The executions of a line of this file, in order."""
        first, last = np.searchsorted(self.runs.line, [line, line + 1])
        return [int(step) for step in self.runs.step[first:last]]

    @cached_property
    def end_s(self) -> NDArray[np.float64]:
        """[s] (n,) The running total at each step's end."""
        assert self.timing is not None
        return self.timing.end_s

    @property
    def misses(self) -> bool:
        """Whether something is wrong that another file may set right."""
        return any(found.is_error for found in self.diagnostics)

    @property
    def needs(self) -> tuple[str, ...]:
        """The other files that decided about this one."""
        found = [] if self.program is None else [s.path for s in self.program.companions]
        if self.timing is not None:
            found += [s.path for s in self.timing.plan.sources[1:]]
        return tuple(dict.fromkeys(found))


def _always() -> bool:
    return True


def analyse(
    document: Document,
    settings: Settings,
    wanted: Callable[[], bool] = _always,
    memory: Memory | None = None,
) -> Analysis:
    """Reads, runs and times the text. Never raises for a bad program.

    `memory`: of earlier texts of the document, whose unchanged lines and moves are not worked out again.
    Raises SupersededError as soon as `wanted` says that nobody waits for it.
    """
    with remembering(Memory() if memory is None else memory):
        return _analysed(document, settings, wanted)


def _analysed(document: Document, settings: Settings, wanted: Callable[[], bool]) -> Analysis:
    from olp.language.reading import read_document

    source = document.source()
    edition = document.edition
    program: Program | None = None
    timing: Timing | None = None
    try:
        program = read_document(source, document.language)
        _check(wanted)
        timing = _timed(program, settings, wanted)
        found = timing.diagnostics
    except OlpError as problem:
        found = problem.diagnostics
    diagnostics = tuple(dict.fromkeys(d.at(document.path) for d in (*settings.diagnostics, *found)))
    return Analysis(document.path, edition, source, settings, program, timing, diagnostics)


def _timed(program: Program, settings: Settings, wanted: Callable[[], bool]) -> Timing:
    from olp.batch import time_plan_of
    from olp.interpreter import run

    job = settings.job
    plan = run(program, robot=job.robot, folder=folder_of(program.path), max_steps=_MOST_STEPS)
    _check(wanted)
    return time_plan_of(plan, job)


# A program that never ends must not keep somebody who types waiting.
_MOST_STEPS = 200_000


def folder_of(path: str) -> Path | None:
    """Where the file stands or would stand, None where there is no such folder."""
    place = Path(path).parent
    return place if path and place.is_absolute() and place.is_dir() else None


def _check(wanted: Callable[[], bool]) -> None:
    if not wanted():
        raise SupersededError
