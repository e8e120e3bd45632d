"""What an editor shows above a program (its time and budgets), and what it can change: quick fixes and formatting.

Quick fixes are those that a lint rule offers, the correction of a misspelt word, a comment that excuses a finding and
edits that hold a time budget. A formatted text is read again; it is dropped unless it is exactly the same program.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterator
from dataclasses import fields, is_dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from olp.checks.fit.fit import offer
from olp.checks.guard.budget import Budget, budgets_for
from olp.checks.guard.judge import measure
from olp.checks.lint.fix import Edit, fixed, fixes
from olp.core.diagnostic import OlpError
from olp.core.source import Source
from olp.identification.timing_job import time_program
from olp.ir.program import Program, Routine
from olp.languages.tokens import Words
from olp.languages.vendor import find_vendor, part_of, read_source, vendor_names
from olp.reports.outcome.model import OutcomeFinding
from olp.runtime.plan import StepKind
from olp.servers.language.document import Action, TextEdit
from olp.servers.language.service import Analysis, folder_of
from olp.timing.result import Timing


class Lens(NamedTuple):
    """`text` belongs above line `line`. `over`: a budget is exceeded."""

    line: int
    text: str
    over: bool = False


def lenses(analysis: Analysis) -> list[Lens]:
    """One for the program and one for each budget that holds for it, above the routine that runs."""
    timing, program = analysis.timing, analysis.program
    if timing is None or program is None or not program.routines:
        return []
    main = _main(program)
    return [
        Lens(main.line, _total(timing)),
        *(_lens(analysis, budget, main.line) for budget in _budgets(analysis)),
    ]


def _total(timing: Timing) -> str:
    incomplete = any(d.is_error for d in timing.diagnostics)
    total = f"{'at least ' * incomplete}{timing.total_s:.3f} s"
    if timing.interval is not None:
        total += f" (95 %: {timing.low_s:.3f} to {timing.high_s:.3f})"
    parts = f"motion {timing.motion_s:.3f} s, waits {timing.wait_s:.3f} s, I/O {timing.io_s:.3f} s"
    how = "timing signature" if timing.interval is not None else f"{timing.model} acceleration"
    return f"{total}: {parts} · {timing.robot or 'robot not known'}, {how}"


def _budgets(analysis: Analysis) -> Iterator[Budget]:
    if not Path(analysis.path).is_absolute():
        return
    try:
        for each in budgets_for(analysis.path):
            yield from (budget for budget in each.budgets if budget.covers(analysis.path))
    except (OSError, OlpError):
        return


def broken_totals(analysis: Analysis) -> Iterator[tuple[Budget, int]]:
    """Budgets of the whole program that are exceeded, and the lines that their lenses stand above."""
    if analysis.timing is None or analysis.program is None or not analysis.program.routines:
        return
    main = _main(analysis.program).line
    for budget in _budgets(analysis):
        if budget.of == "total" and not budget.routine and _lens(analysis, budget, main).over:
            yield budget, main


def _main(program: Program) -> Routine:
    return next((r for r in program.routines if r.name == program.main), program.routines[0])


def _lens(analysis: Analysis, budget: Budget, line: int) -> Lens:
    assert analysis.timing is not None
    assert analysis.program is not None
    head = f"budget {budget.name}: "
    try:
        measured = measure(_timing(analysis, budget), analysis.program, budget)
    except OlpError as problem:
        return Lens(line, f"{head}{problem.diagnostics[0].message}")
    place = line
    if budget.routine:
        named = (r.line for r in analysis.program.routines if r.name.casefold() == budget.routine.casefold())
        place = next(named, line)
    if measured.seconds is None:
        return Lens(place, f"{head}{measured.why}")
    left = budget.limit_s - measured.seconds
    over = measured.seconds > budget.limit_s + budget.tolerance_s
    what = "" if budget.of == "total" else f" of {budget.of}"
    says = f"{measured.seconds:.3f} s{what} of {budget.limit_s:g} s, "
    return Lens(place, f"{head}{says}{f'{-left:.3f} s over' if left < 0 else f'{left:.3f} s left'}", over)


def _timing(analysis: Analysis, budget: Budget) -> Timing:
    """With the budget's own signature, if it has one. Raises OlpError."""
    from olp.identification.timing_job import time_plan_of

    assert analysis.timing is not None
    if not budget.signature:
        return analysis.timing
    return time_plan_of(analysis.timing.plan, replace(analysis.settings.job, signature=budget.signature))


# --- Hints ---
# What stands behind a line: its time, the running total, and what limits it.


class Hint(NamedTuple):
    """`text` belongs behind line `line`; `seconds`: of all its executions, nan where it cannot be timed."""

    line: int
    text: str
    seconds: float
    times: int  # executions


def hints(analysis: Analysis, first: int = 1, last: int = 1 << 30) -> list[Hint]:
    """The hints of lines `first` to `last`, in order: one for every line that moves, waits or calls."""
    if analysis.timing is None:
        return []
    found = {hint.line: hint for hint in _calls(analysis, first, last)}
    found.update((hint.line, hint) for hint in _lines(analysis, first, last))
    return [found[line] for line in sorted(found)]


def _lines(analysis: Analysis, first: int, last: int) -> Iterator[Hint]:
    runs = analysis.runs
    start, stop = np.searchsorted(runs.line, [first, last + 1])
    lines, steps = runs.line[start:stop], runs.step[start:stop]
    if not len(lines):
        return
    timing = analysis.timing
    assert timing is not None
    cuts = np.flatnonzero(np.diff(lines)) + 1
    begins = [0, *cuts.tolist()]
    ends = [*cuts.tolist(), len(lines)]
    seconds, totals = timing.duration_s[steps], analysis.end_s[steps].tolist()
    sums = np.add.reduceat(seconds, begins).tolist()
    kinds, each, every = timing.plan.kind[steps].tolist(), seconds.tolist(), steps.tolist()
    for line, begin, end, whole in zip(lines[begins].tolist(), begins, ends, sums, strict=True):
        if kinds[begin] != StepKind.MOVE and not whole:
            continue  # an output takes no time
        limit = timing.limited_by[every[begin]] if kinds[begin] == StepKind.MOVE else ""
        yield Hint(line, _text(each[begin:end], whole, totals[end - 1], limit), whole, end - begin)


def _text(each: list[float], whole: float, total: float, limit: str) -> str:
    """`0.290 s  Σ 0.426 s  speed`, or `2 × 0.290 s = 0.580 s  Σ 2.096 s  speed` where a line runs more often."""
    if math.isnan(whole):
        return "no time"
    head = f"{whole:.3f} s"
    if len(each) > 1:
        same = max(each) - min(each) < _SAME
        head = f"{len(each)} × {each[0]:.3f} s = {head}" if same else f"{len(each)} × = {head}"
    return "  ".join(filter(None, (head, f"Σ {total:.3f} s", limit)))


_SAME = 5e-4  # [s] less is not seen with three decimals


def _calls(analysis: Analysis, first: int, last: int) -> Iterator[Hint]:
    """Calls of the main routine: what runs under them."""
    timing = analysis.timing
    assert timing is not None
    ends = analysis.end_s
    spans: dict[int, list[tuple[float, float]]] = {}
    for span in timing.plan.calls:
        if first <= span.line <= last and span.stop > span.start:
            before = float(ends[span.start - 1]) if span.start else 0.0
            after = float(ends[span.stop - 1])
            spans.setdefault(span.line, []).append((after - before, after))
    for line, found in spans.items():
        each = [seconds for seconds, _ in found]
        yield Hint(line, _text(each, sum(each), found[-1][1], ""), sum(each), len(found))


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
    """Verified changes that fix the findings; olp/checks/lint/fix.py defines the check."""
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
    """Corrections of misspelt words that the reader has recognised."""
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
    """The edits that format lines `first` to `last`; none if they would change the program."""
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
