"""What stands above a program: its time, what that is made of, and the budgets it is held to."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

from olp.checks.guard.budget import Budget, budgets_for
from olp.checks.guard.measure import measure
from olp.core.diagnostic import OlpError
from olp.servers.language.analysis import Analysis
from olp.timing.timing import Timing


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
    main = next((r for r in program.routines if r.name == program.main), program.routines[0])
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
    from olp.reports.batch import time_plan_of

    assert analysis.timing is not None
    if not budget.signature:
        return analysis.timing
    return time_plan_of(analysis.timing.plan, replace(analysis.settings.job, signature=budget.signature))
