"""The open texts and what is known of them. One per server; no threads, no protocol.

Findings are marked with every code as on the command line, each at its place in a file. The rules of `olp lint` run one
at a time, so that whoever waits can be let in between.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import replace
from enum import StrEnum
from pathlib import Path
from typing import NamedTuple

from olp.core import source
from olp.core.diagnostic import Diagnostic, OlpError, Severity
from olp.core.memory_limit import TextCache
from olp.reports.outcome.model import Level, OutcomeFinding
from olp.servers.language.analysis import Analysis, EditorSettings, analyse, mistake
from olp.servers.language.document import OpenDocument, Splice, TextChange
from olp.timing.result import assumed


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
    """Everything that is told of the text, of this file and of the files it needs."""
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
        """From now on the text of `path` is the editor's."""
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
        """The file on the disk counts again. False where no such text is open."""
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
        """What is known of `path`, of everything when None, is out of date."""
        for known in [path] if path is not None else list(self.analyses):
            if known in self.analyses:
                self.analyses[known] = replace(self.analyses[known], edition=-1)

    def is_current(self, path: str) -> bool:
        document, analysis = self.documents.get(path), self.analyses.get(path)
        return document is not None and analysis is not None and analysis.edition == document.edition

    def current(
        self, path: str, wanted: Callable[[], bool] = lambda: True, whole: bool = True
    ) -> Analysis | None:
        """What is known of the text as it is now; None where none is open. Raises SupersededError like `analyse`.

        `whole` False: a program that goes on and on may be `partial`.
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
    """What is known of the newest text, rules included: for whoever cannot wait for the next pause."""
    if service.current(path) is None:
        return None
    for _ in _over(service, path):
        pass
    return service.analyses[path]
