"""Quick fixes and formatting for editors.

Quick fixes are those that a lint rule offers, the correction of a misspelt word, a comment that excuses a finding and
edits that hold a time budget. A formatted text is read again; it is dropped unless it is exactly the same program.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import fields, is_dataclass, replace
from functools import partial
from typing import Any

import numpy as np

from olp.checks.fit.fit import offer
from olp.checks.lint.fix import Edit, fixed, fixes
from olp.core.diagnostic import OlpError
from olp.core.source import Source
from olp.identification.timing_job import time_program
from olp.ir.program import Program
from olp.languages.read import read_source
from olp.languages.tokens import Words
from olp.languages.vendor import find_vendor, part_of, vendor_names
from olp.reports.outcome.model import OutcomeFinding
from olp.servers.language.analysis import Analysis, folder_of
from olp.servers.language.document import Action, TextEdit
from olp.servers.language.lens import broken_totals

_MEANT = re.compile(r"did you mean ([\w.$#-]+)\?")


def actions(analysis: Analysis, first: int, last: int) -> list[Action]:
    """What is offered for lines `first` to `last`."""
    findings = [finding for finding in analysis.lint if first <= finding.line <= last]
    found = [
        *_meant(analysis, first, last),
        *_budgets_held(analysis, first, last),
        *_fixes(analysis, findings),
    ]
    for finding in findings:
        found += _excuse(analysis, finding)
    return found


def _fixes(analysis: Analysis, findings: list[OutcomeFinding]) -> Iterator[Action]:
    """What mends the findings, each tried before it is offered: olp/checks/lint/fix.py says what it has to hold."""
    program, job = analysis.program, analysis.settings.job
    if program is None or analysis.timing is None or not findings:
        return
    folder = folder_of(analysis.path)
    job = replace(
        job, max_steps=analysis.most_steps
    )  # as the findings were made: who types does not wait longer
    for edit in fixes(program, findings):
        held = fixed(program, [edit], lambda changed: time_program(changed, job, folder)).done
        if edit in held:
            title = f"{edit.says[:1].upper()}{edit.says[1:]} ({edit.code}{'' if edit.safe else ', changes the motion'})"
            yield Action(title, edit.code, (_text_edit(analysis, edit),), edit.safe)


def _budgets_held(analysis: Analysis, first: int, last: int) -> Iterator[Action]:
    """The fewest edits that bring a broken budget down, at the line that the budget is told above."""
    program = analysis.program
    for budget, line in broken_totals(analysis):
        if program is None or not first <= line <= last:
            continue
        if budget.name not in analysis.offers:
            job = replace(
                analysis.settings.job, signature=budget.signature or analysis.settings.job.signature
            )
            folder = folder_of(analysis.path)
            run = partial(time_program, job=job, folder=folder)
            analysis.offers[budget.name] = offer(program, budget.limit_s, run)
        found = analysis.offers[budget.name]
        if found is not None:
            new = found.program.source
            edits = (
                TextEdit(n, 1, n, len(old) + 1, new.line(n))
                for n, old in enumerate(analysis.source.lines, 1)
                if old != new.line(n)
            )
            yield Action(f"Make it {found.says}", "", tuple(edits))


def _text_edit(analysis: Analysis, edit: Edit) -> TextEdit:
    if not edit.text:
        return TextEdit(edit.first, 1, edit.last + 1, 1, "")
    end = len(analysis.source.line(edit.last)) + 1
    return TextEdit(edit.first, 1, edit.last, end, "\n".join(edit.text))


def _meant(analysis: Analysis, first: int, last: int) -> Iterator[Action]:
    """A misspelt word that the reader has guessed."""
    for found in analysis.diagnostics:
        match = _MEANT.search(found.help)
        if match and first <= found.line <= last and found.file in ("", analysis.path):
            edit = TextEdit(found.line, found.column, found.line, found.end_column, match[1])
            if found.end_column > found.column:
                yield Action(f"Write {match[1]}", found.code, (edit,), True)


def _excuse(analysis: Analysis, finding: OutcomeFinding) -> Iterator[Action]:
    """A comment of its own above the line, where the language has such lines without a number."""
    program = analysis.program
    if program is None or program.vendor not in vendor_names() or not finding.line:
        return
    vendor = find_vendor(program.vendor)
    prefix = vendor.comment_prefix
    if not prefix.strip() or vendor.numbered_lines:
        return
    text = analysis.source.line(finding.line)
    indent = text[: len(text) - len(text.lstrip())] if vendor.indented_comments else ""
    above = TextEdit(finding.line, 1, finding.line, 1, f"{indent}{prefix}olp: ignore {finding.code}\n")
    yield Action(f"Excuse {finding.code} here, with a comment", finding.code, (above,))


def formatting(analysis: Analysis, first: int = 1, last: int = 1 << 30, indent: str = "  ") -> list[TextEdit]:
    """The edits that lay out lines `first` to `last`; none where the program would mean anything else."""
    program = analysis.program
    words: Words | None = None if program is None else part_of(program.vendor, "tokens")
    layout = None if words is None else words.layout
    if program is None or layout is None:
        return []
    old = analysis.source.lines
    new = [
        after if first <= number <= last else before
        for number, (before, after) in enumerate(zip(old, layout.lines(old, indent), strict=True), 1)
    ]
    if new == list(old) or not _same(program, analysis.source, new):
        return []
    return [
        TextEdit(number, 1, number, len(before) + 1, after)
        for number, (before, after) in enumerate(zip(old, new, strict=True), 1)
        if before != after
    ]


def _same(program: Program, source: Source, lines: list[str]) -> bool:
    """Whether the text still says what it said: same statements on the same lines, same findings."""
    raw = "\r\n".join([*lines, ""]).encode("utf-8", "surrogatepass")
    try:
        again = read_source(Source(source.path, raw, source.encoding, tuple(lines)), vendor=program.vendor)
    except OlpError:
        return False
    parts = ("routines", "data", "main")
    said = [(d.code, d.line, d.message) for d in program.diagnostics if d.line]
    still = [(d.code, d.line, d.message) for d in again.diagnostics if d.line]
    return said == still and all(equal(getattr(program, part), getattr(again, part)) for part in parts)


def equal(first: Any, second: Any) -> bool:
    """Whether two parts of programs are the same, whatever they hold; nan is equal to itself."""
    if type(first) is not type(second):
        return False
    if isinstance(first, np.ndarray):
        return bool(first.shape == second.shape and first.tobytes() == second.tobytes())
    if isinstance(first, (list, tuple)):
        return len(first) == len(second) and all(map(equal, first, second))
    if isinstance(first, dict):
        return list(first) == list(second) and all(equal(first[key], second[key]) for key in first)
    if is_dataclass(first):
        return all(equal(getattr(first, f.name), getattr(second, f.name)) for f in fields(first))
    return bool(first == second or (first != first and second != second))
