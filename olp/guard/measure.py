"""What a budget is about: the seconds of a program, of a routine, or from one label to another."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from olp.guard.budget import Budget
from olp.plan import StepKind
from olp.program import Call, Label, Program
from olp.timing import Timing

Bools = NDArray[np.bool_]
_KINDS = {"motion": StepKind.MOVE, "wait": StepKind.WAIT, "io": StepKind.SIGNAL}


class Measured(NamedTuple):
    """`seconds`: None where it cannot be said, and `why` tells the reason. `steps` (n,): those that count."""

    seconds: float | None
    steps: Bools
    why: str = ""


def measure(timing: Timing, program: Program, budget: Budget) -> Measured:
    """The seconds that `budget` is about: of several executions those of the longest."""
    everything = np.ones(len(timing.plan), dtype=bool)
    if timing.plan.stop_reason.startswith("stopped after") and not len(timing.plan):
        return Measured(None, everything, timing.plan.stop_reason)
    runs, why = _runs(timing, program, budget)
    if not runs:
        return Measured(None, everything, why)
    if budget.upper:
        if timing.high_s is None:
            return Measured(
                None, everything, 'on = "upper" needs a signature: signature = "FILE", or --signature'
            )
        if budget.routine or budget.start:
            return Measured(None, everything, 'on = "upper" is known of whole programs only')
        return Measured(timing.high_s, everything)
    kind = _KINDS.get(budget.of)
    counted = everything if kind is None else timing.plan.kind == kind
    sums = [float(np.nansum(timing.duration_s[run & counted])) for run in runs]
    longest = int(np.argmax(sums))
    steps = runs[longest] & counted
    if np.isnan(timing.duration_s[steps]).any():
        return Measured(None, steps, f"{int(np.isnan(timing.duration_s[steps]).sum())} steps cannot be timed")
    return Measured(sums[longest], steps)


def _runs(timing: Timing, program: Program, budget: Budget) -> tuple[list[Bools], str]:
    """Which steps belong to each execution, and why there is none."""
    if budget.routine:
        return _of_routine(timing, program, budget.routine), f"the routine {budget.routine} was not executed"
    if budget.start:
        return _between(timing, program, budget), f"nothing runs between {budget.start} and {budget.stop}"
    return [np.ones(len(timing.plan), dtype=bool)], ""


def _of_routine(timing: Timing, program: Program, name: str) -> list[Bools]:
    plan, wanted = timing.plan, name.casefold()
    main = next((r for r in program.routines if r.name == program.main), program.routines[0])
    if main.name.casefold() == wanted:
        return [np.ones(len(plan), dtype=bool)]
    calls = {s.line for s in main.body if isinstance(s, Call) and s.routine.casefold() == wanted}
    runs = []
    for span in plan.calls:
        if span.line in calls:
            run = np.zeros(len(plan), dtype=bool)
            run[span.start : span.stop] = True
            runs.append(run)
    if runs:
        return runs
    own = next((r for r in program.routines if r.name.casefold() == wanted), None)
    if own is not None:
        inside = (plan.source == 0) & (plan.line >= own.line) & (plan.line <= (own.last_line or own.line))
        return _contiguous(inside)
    stems = [s.path.replace("\\", "/").rpartition("/")[2].rpartition(".")[0].casefold() for s in plan.sources]
    return _contiguous(np.isin(plan.source, [i for i, stem in enumerate(stems) if stem == wanted and i]))


def _between(timing: Timing, program: Program, budget: Budget) -> list[Bools]:
    plan = timing.plan
    lines: dict[str, int] = {}
    for routine in program.routines:
        for s in routine.body:
            if isinstance(s, Label):
                lines.setdefault(s.name.casefold(), s.line)
    first, last = (lines.get(name.lstrip("*").casefold()) for name in (budget.start, budget.stop))
    if first is None or last is None:
        return []
    own = plan.source == 0
    inside = own & (plan.line > first) & (plan.line < last)
    # What is called in between belongs to it: other files run between two lines of the span.
    index = np.maximum.accumulate(np.where(own, np.arange(len(plan)), -1)) if len(plan) else np.zeros(0, int)
    return _contiguous(np.where(own, inside, (index >= 0) & inside[np.maximum(index, 0)]))


def _contiguous(inside: Bools) -> list[Bools]:
    edges = np.flatnonzero(np.diff(np.concatenate(([False], inside, [False])).astype(np.int8)))
    runs = []
    for start, stop in zip(edges[::2], edges[1::2], strict=True):
        run = np.zeros(len(inside), dtype=bool)
        run[start:stop] = True
        runs.append(run)
    return runs
