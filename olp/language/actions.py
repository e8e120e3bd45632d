"""Quick fixes: what findings of rules carry, a word that was meant, a finding that is excused."""

from __future__ import annotations

import re
from collections.abc import Iterator

from olp.language.analysis import Analysis
from olp.language.edits import Action, TextEdit
from olp.outcome.model import Finding
from olp.vendors.vendor import find_vendor, vendor_names

_MEANT = re.compile(r"did you mean ([\w.$#-]+)\?")


def actions(analysis: Analysis, first: int, last: int) -> list[Action]:
    """What is offered for lines `first` to `last`."""
    found = list(_meant(analysis, first, last))
    for finding in analysis.lint:
        if first <= finding.line <= last:
            found += [*_fixes(analysis, finding), *_excuse(analysis, finding)]
    return found


def _fixes(analysis: Analysis, finding: Finding) -> Iterator[Action]:
    """The changes that a finding carries: none of them can alter where the robot goes."""
    edits = []
    for first, last, text in finding.fixes:
        if text:
            end = len(analysis.source.line(last)) + 1
            edits.append(TextEdit(first, 1, last, end, text))
        else:
            edits.append(TextEdit(first, 1, last + 1, 1, ""))
    if edits:
        title = finding.help or f"mend {finding.code}"
        yield Action(f"{title[:1].upper()}{title[1:]} ({finding.code})", finding.code, tuple(edits), True)


def _meant(analysis: Analysis, first: int, last: int) -> Iterator[Action]:
    """A misspelt word that the reader has guessed."""
    for found in analysis.diagnostics:
        match = _MEANT.search(found.help)
        if match and first <= found.line <= last and found.file in ("", analysis.path):
            edit = TextEdit(found.line, found.column, found.line, found.end_column, match[1])
            if found.end_column > found.column:
                yield Action(f"Write {match[1]}", found.code, (edit,), True)


def _excuse(analysis: Analysis, finding: Finding) -> Iterator[Action]:
    """A comment of its own above the line, where the language has such lines without a number."""
    program = analysis.program
    if program is None or program.vendor not in vendor_names() or not finding.line:
        return
    prefix = find_vendor(program.vendor).comment_prefix
    if not prefix.strip() or prefix[:1].isdigit() or program.vendor == "tp":
        return
    text = analysis.source.line(finding.line)
    indent = text[: len(text) - len(text.lstrip())] if program.vendor != "inform" else ""
    above = TextEdit(finding.line, 1, finding.line, 1, f"{indent}{prefix}olp: ignore {finding.code}\n")
    yield Action(f"Excuse {finding.code} here, with a comment", finding.code, (above,))
