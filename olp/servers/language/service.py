"""The open texts and what is known of each: the program, its plan, its times and what is wrong. One service per server.

It has no threads and no protocol. Findings are marked with every code as on the command line, each at its place in a
file. The rules of `olp lint` run one at a time, so that a waiting request can be answered in between. An editor may set
what the command line's options set; what it leaves out is taken from olp.toml. Code: C013.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from enum import StrEnum
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from olp.core import source
from olp.core.diagnostic import Diagnostic, OlpError, Severity, error
from olp.core.result_cache import SupersededError, TextCache, check, remembering
from olp.core.source import Source
from olp.identification.timing_job import TimingJob, time_plan_of
from olp.ir.program import Program
from olp.reports.outcome.model import Level, OutcomeFinding
from olp.runtime.interpreter import LIMIT, run
from olp.servers.language.document import OpenDocument, Splice, TextChange, read_document
from olp.timing.result import Timing, assumed

if TYPE_CHECKING:
    from olp.checks.fit.fit import Fit

_TEXTS = ("robot", "signature", "model")


@dataclass(frozen=True, slots=True)
class EditorSettings:
    """`job`: how programs are timed. `diagnostics`: invalid settings, which are ignored."""

    job: TimingJob = TimingJob()  # noqa: RUF009, a frozen one
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
    return EditorSettings(TimingJob(**values), tuple(problems))


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
    """Diagnostic for an internal error of olp."""
    says = f"olp made a mistake with this text ({type(problem).__name__}: {str(problem)[:80]})"
    return error("C016", says, help="tell its authors, with the text; nothing of it is timed")


def folder_of(path: str) -> Path | None:
    """Where the file stands or would stand, None where there is no such folder."""
    place = Path(path).parent
    return place if path and place.is_absolute() and place.is_dir() else None


class Weight(StrEnum):
    """How a mark looks: a HINT is nearly invisible."""

    ERROR = "error"
    WARNING = "warning"
    INFO = "info"
    HINT = "hint"


class FindingMark(NamedTuple):
    """A finding from column `column` to `end_column` (0: the line's end) of a line; line 0: of the whole file."""

    file: str
    line: int
    column: int
    end_column: int
    code: str
    weight: Weight
    message: str


_WEIGHTS = {
    Severity.ERROR: Weight.ERROR,
    Severity.WARNING: Weight.WARNING,
    Severity.INFO: Weight.INFO,
    Level.ERROR: Weight.ERROR,
    Level.WARNING: Weight.WARNING,
    Level.NOTE: Weight.INFO,
}


def marks(analysis: Analysis) -> list[FindingMark]:
    """All findings of the text, in this file and in the files that it needs."""
    told = [*map(_of_diagnostic, analysis.diagnostics), *_assumed(analysis)]
    known = {(mark.file, mark.line, mark.message) for mark in told}
    lint = (of_finding(found) for found in analysis.lint)
    return [*told, *(mark for mark in lint if (mark.file, mark.line, mark.message) not in known)]


def moved(found: Iterable[OutcomeFinding], splices: Iterable[Splice]) -> tuple[OutcomeFinding, ...]:
    """Findings of a text as they stand after edits; those of edited lines are gone."""
    return tuple(_moved(found, tuple(splices)))


def _moved(found: Iterable[OutcomeFinding], splices: tuple[Splice, ...]) -> Iterator[OutcomeFinding]:
    for one in found:
        line: int | None = one.line
        for splice in splices:
            line = splice.moved(line) if line else line
        if line is not None:
            yield one if line == one.line else replace(one, line=line, fixes=())


def _of_diagnostic(found: Diagnostic) -> FindingMark:
    return FindingMark(
        found.file,
        found.line,
        found.column,
        found.end_column if found.end_column > found.column else 0,
        found.code,
        _WEIGHTS[found.severity],
        _said(found.message, found.help),
    )


def of_finding(found: OutcomeFinding) -> FindingMark:
    """A finding of a rule as a mark."""
    return FindingMark(
        found.file,
        found.line,
        found.column,
        found.end_column,
        found.code,
        _WEIGHTS[found.level],
        _said(found.message, found.help),
    )


def _assumed(analysis: Analysis) -> Iterator[FindingMark]:
    """What was taken for granted, as quiet as an editor can be."""
    for found in () if analysis.timing is None else assumed(analysis.timing):
        yield _of_diagnostic(found.at(analysis.path))._replace(weight=Weight.HINT)


def _said(message: str, help: str) -> str:
    return f"{message}\nhelp: {help}" if help else message


class ProgramService:
    """`documents` and `analyses` by path; an analysis may be of an earlier edition: see `is_current`."""

    def __init__(self) -> None:
        self.settings = EditorSettings()
        self.documents: dict[str, OpenDocument] = {}
        self.analyses: dict[str, Analysis] = {}
        self._memories: dict[str, TextCache] = {}

    # --- texts ------------------------------------------------------------------------------------------

    def open(self, path: str, text: str, language: str = "", version: int = 0) -> OpenDocument:
        """Use the editor's text for `path` from now on."""
        document = OpenDocument(path, text, language, version)
        self.documents[path] = document
        self._memories[path] = TextCache()
        self.analyses.pop(path, None)
        self._overlay(document)
        return document

    def change(self, path: str, changes: list[TextChange | str], version: int) -> bool:
        """Edits in their order; a text alone replaces all. False where no such text is open."""
        document = self.documents.get(path)
        if document is None:
            return False
        for change in changes:
            if isinstance(change, str):
                document.replace(change)
            else:
                document.change(change)
        document.version = version
        return True

    def close(self, path: str) -> bool:
        """Use the file on the disk again. False if no such text is open."""
        source.drop(path)
        self.analyses.pop(path, None)
        self._memories.pop(path, None)
        return self.documents.pop(path, None) is not None

    # --- what is known of them --------------------------------------------------------------------------

    def configure(self, settings: EditorSettings) -> None:
        """Everything is timed anew."""
        self.settings = settings
        self.forget()

    def forget(self, path: str | None = None) -> None:
        """Mark the analysis of `path`, or of everything if None, as outdated."""
        for known in [path] if path is not None else list(self.analyses):
            if known in self.analyses:
                self.analyses[known] = replace(self.analyses[known], edition=-1)

    def is_current(self, path: str) -> bool:
        document, analysis = self.documents.get(path), self.analyses.get(path)
        return document is not None and analysis is not None and analysis.edition == document.edition

    def current(
        self, path: str, wanted: Callable[[], bool] = lambda: True, whole: bool = True
    ) -> Analysis | None:
        """Analysis of the current text; None if it is not open. Raises SupersededError like `analyse`.

        `whole` False: the analysis of a very long run may be `partial`.
        """
        document = self.documents.get(path)
        if document is None:
            return None
        before = self.analyses.get(path)
        if before is not None and self.is_current(path) and not (whole and before.partial):
            return before
        self._overlay(document)
        analysis = analyse(document, self.settings, wanted, self._memories[path], whole)
        if before is not None:
            # Until the rules have run again, what they found stays where it was.
            analysis = replace(analysis, lint=moved(before.lint, document.splices))
        document.splices.clear()
        self.analyses[path] = analysis
        return analysis

    def dependents(self, path: str) -> list[str]:
        """The other open texts that a change of `path` may concern: they need it, or miss something of its folder."""
        folder = Path(path).parent
        return [
            other
            for other, analysis in self.analyses.items()
            if other != path
            and (path in analysis.needs or (Path(other).parent == folder and analysis.misses))
        ]

    def _overlay(self, document: OpenDocument) -> None:
        if Path(document.path).is_absolute():
            source.put(document.path, document.raw)


def rule_runs(service: ProgramService) -> Iterator[str]:
    """Runs every rule over every open text: the path of one whose findings are complete, "" after each step before."""
    for path in list(service.analyses):
        yield from _over(service, path)


def _over(service: ProgramService, path: str) -> Iterator[str]:
    from olp.checks.lint.rule import LintCase
    from olp.checks.lint.run import RuleChoice, is_excused, rules_for
    from olp.reports.outcome.model import of_diagnostic

    analysis = service.analyses.get(path)
    if analysis is None or analysis.program is None or analysis.timing is None or analysis.linted:
        return
    case = LintCase(analysis.program, analysis.timing)
    found: list[OutcomeFinding] = []
    try:
        rules = rules_for(path, RuleChoice())
    except OlpError as problem:
        rules, found = [], [of_diagnostic(d, path) for d in problem.diagnostics]
    for rule in rules:
        try:
            found.extend(one for one in rule.find(case) if not is_excused(case, one))
        except Exception as problem:
            found.append(of_diagnostic(mistake(problem), path))
        yield ""
    if service.analyses.get(path) is analysis:
        ordered = tuple(sorted(found, key=lambda one: (one.line, one.code)))
        service.analyses[path] = replace(analysis, lint=ordered, linted=True)
        yield path


def complete(service: ProgramService, path: str) -> Analysis | None:
    """Analysis of the newest text including lint, for callers that cannot wait for the next pause."""
    if service.current(path) is None:
        return None
    for _ in _over(service, path):
        pass
    return service.analyses[path]
