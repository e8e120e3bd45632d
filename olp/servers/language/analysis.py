"""What is known of one text: the program, what happens when it runs, how long that takes, what is wrong.

An editor may set the same words as the command line. What is left out stands in olp.toml.

Code: C013.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from olp.core.diagnostic import Diagnostic, OlpError, error
from olp.core.memory_limit import SupersededError, TextCache, check, remembering
from olp.core.source import Source
from olp.identification.timing_job import time_plan_of
from olp.ir.program import Program
from olp.reports.batch import Job
from olp.reports.outcome.model import OutcomeFinding
from olp.runtime.interpreter import LIMIT, run
from olp.servers.language.document import OpenDocument, read_document
from olp.timing.result import Timing

if TYPE_CHECKING:
    from olp.checks.fit.fit import Fit


_TEXTS = ("robot", "signature", "model")


@dataclass(frozen=True, slots=True)
class EditorSettings:
    """`job`: how programs are timed. `diagnostics`: what of the settings cannot be used, and is left out."""

    job: Job = Job()  # noqa: RUF009, a frozen one
    diagnostics: tuple[Diagnostic, ...] = ()


def settings_of(given: object) -> EditorSettings:
    """From `{"robot": …, "signature": …, "override": …, "model": …}`, or that under the key `olp`; override in %."""
    if isinstance(given, Mapping) and isinstance(given.get("olp"), Mapping):
        given = given["olp"]
    if not isinstance(given, Mapping):
        return EditorSettings()
    problems: list[Diagnostic] = []
    values: dict[str, Any] = {}
    for name in _TEXTS:
        value = given.get(name)
        if isinstance(value, str):
            values[name] = value.strip() or None
        elif value is not None:
            problems.append(_wrong(name, value, f"olp.{name} is a text"))
    override = given.get("override")
    if isinstance(override, (int, float)) and not isinstance(override, bool) and 0 < override < float("inf"):
        values["override"] = override / 100.0
    elif override not in (None, 0, ""):
        problems.append(_wrong("override", override, "olp.override is a number of % above zero"))
    return EditorSettings(Job(**values), tuple(problems))


def _wrong(name: str, value: object, says: str) -> Diagnostic:
    return error("C013", f"the setting olp.{name} cannot be {str(value)[:40]!r}", help=says)


class LineRuns(NamedTuple):
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
    settings: EditorSettings
    program: Program | None = None
    timing: Timing | None = None
    diagnostics: tuple[Diagnostic, ...] = ()
    lint: tuple[OutcomeFinding, ...] = ()
    linted: bool = False  # the rules have run over this edition
    partial: bool = False  # it goes on behind the steps that were run
    most_steps: int | None = None  # statements that were run at most

    @cached_property
    def runs(self) -> LineRuns:
        """Which steps belong to which line of this file."""
        if self.timing is None:
            return LineRuns(np.zeros(0, dtype=np.int32), np.zeros(0, dtype=np.int64))
        plan = self.timing.plan
        own = np.flatnonzero(plan.source == 0)
        order = own[np.argsort(plan.line[own], kind="stable")]
        return LineRuns(plan.line[order], order)

    def steps(self, line: int) -> list[int]:
        """The executions of a line of this file, in order."""
        first, last = np.searchsorted(self.runs.line, [line, line + 1])
        return [int(step) for step in self.runs.step[first:last]]

    @cached_property
    def end_s(self) -> NDArray[np.float64]:
        """[s] (n,) The running total at each step's end."""
        assert self.timing is not None
        return self.timing.end_s

    @cached_property
    def offers(self) -> dict[str, Fit | None]:
        """What brings each broken budget down, by its name, as far as somebody has asked."""
        return {}

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


def analyse(
    document: OpenDocument,
    settings: EditorSettings,
    wanted: Callable[[], bool] = lambda: True,
    memory: TextCache | None = None,
    whole: bool = True,
) -> Analysis:
    """Reads, runs and times the text. Never raises for a bad program, nor for a mistake in olp: that is a finding.

    `memory`: of earlier texts of the document, whose unchanged lines and moves are not worked out again. `whole` False:
    a program that goes on and on is `partial`, so that somebody who types need not wait for its end.
    Raises SupersededError as soon as `wanted` says that nobody waits for it.
    """
    source, edition = document.source(), document.edition
    program: Program | None = None
    timing: Timing | None = None
    some = max(_SOME_STEPS, len(source.lines) + _STEPS_MORE)
    most = _MOST_STEPS if whole else min(_MOST_STEPS, some)
    try:
        with remembering(TextCache() if memory is None else memory, wanted):
            program = read_document(source, document.language)
            check()
            timing = _timed(program, settings, most)
        found = timing.diagnostics
    except OlpError as problem:
        found = problem.diagnostics
    except SupersededError:
        raise
    except Exception as problem:
        found = (mistake(problem),)
    partial = most < _MOST_STEPS and any(d.code == LIMIT for d in found)
    if partial:
        found = tuple(d for d in found if d.code != LIMIT)
    diagnostics = tuple(dict.fromkeys(d.at(document.path) for d in (*settings.diagnostics, *found)))
    return Analysis(
        document.path,
        edition,
        source,
        settings,
        program,
        timing,
        diagnostics,
        partial=partial,
        most_steps=most,
    )


# A program that never ends must not keep somebody waiting: not while typing, and not for ever.
_MOST_STEPS = 200_000
_SOME_STEPS, _STEPS_MORE = 2000, 250  # in any program; more than it has lines


def _timed(program: Program, settings: EditorSettings, most: int) -> Timing:
    job = settings.job
    plan = run(program, robot=job.robot, folder=folder_of(program.path), max_steps=most)
    check()
    return time_plan_of(plan, job)


def mistake(problem: Exception) -> Diagnostic:
    """What is told where olp itself has failed."""
    says = f"olp made a mistake with this text ({type(problem).__name__}: {str(problem)[:80]})"
    return error("C016", says, help="tell its authors, with the text; nothing of it is timed")


def folder_of(path: str) -> Path | None:
    """Where the file stands or would stand, None where there is no such folder."""
    place = Path(path).parent
    return place if path and place.is_absolute() and place.is_dir() else None
