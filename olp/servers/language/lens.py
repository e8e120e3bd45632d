"""What stands above a program: its time, what that is made of, and the budgets it is held to."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import numpy as np

from olp.checks.guard.budget import Budget, budgets_for
from olp.checks.guard.judge import measure
from olp.core.diagnostic import OlpError
from olp.ir.program import Program, Routine
from olp.runtime.plan import StepKind
from olp.servers.language.analysis import Analysis
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
