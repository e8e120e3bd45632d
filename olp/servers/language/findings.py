"""Findings as an editor marks them: every code as on the command line, each at its place in a file."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from enum import StrEnum
from typing import NamedTuple

from olp.core.diagnostic import Diagnostic, Severity
from olp.reports.outcome.model import Level, OutcomeFinding
from olp.servers.language.analysis import Analysis
from olp.servers.language.document import Splice
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
    from dataclasses import replace

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
