"""What a budget is about: the seconds of a program, of a routine, or from one label to another."""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from olp.checks.guard.budget import ENDS, Budget, label_name
from olp.ir.program import Call, For, Label, Program, Repeat, Routine, While
from olp.runtime.folder import read_cached
from olp.runtime.plan import Plan, StepKind
from olp.timing.timing import Timing

Bools = NDArray[np.bool_]
_HEADS = (Label, For, While, Repeat)  # a run may come back to these
_KINDS = {"motion": StepKind.MOVE, "wait": StepKind.WAIT, "io": StepKind.SIGNAL}


class Measured(NamedTuple):
    """`seconds`: None where it cannot be said, and `why` tells the reason. `steps` (n,): those that count."""

    seconds: float | None
    steps: Bools
    why: str = ""
    absent: bool = False  # the program has no such part, or never comes there


def measure(timing: Timing, program: Program, budget: Budget) -> Measured:
    """The seconds that `budget` is about: of several executions those of the longest."""
    everything = np.ones(len(timing.plan), dtype=bool)
    runs, why = _runs(timing, program, budget)
    if not runs:
        return Measured(None, everything, why, absent=True)
    if budget.on != ENDS[0]:
        ends = timing.total_ends
        on = f'on = "{budget.on}"'
        if ends is None:
            return Measured(None, everything, f'{on} needs a signature: signature = "FILE", or --signature')
        end = ends[1] if budget.on == "upper" else ends[0]
        if budget.routine or budget.start:
            return Measured(None, everything, f"{on} is known of whole programs only")
        return Measured(end, everything)
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
    spans = [span for span in plan.calls if span.line in calls and span.stop > span.start]
    if spans:
        return [_run(len(plan), span.start, span.stop) for span in spans]
    return _called_further_down(plan, program, wanted)


def _called_further_down(plan: Plan, program: Program, wanted: str) -> list[Bools]:
    """Executions of a routine that others than the main one call. What it calls itself belongs to it where it goes
    on afterwards."""
    for index, source in enumerate(plan.sources):
        own = program if index == 0 else read_cached(Path(source.path))
        stem = source.path.replace("\\", "/").rpartition("/")[2].rpartition(".")[0].casefold()
        for routine in own.routines:
            if routine.name.casefold() == wanted or (index and stem == wanted):
                trail = _trail_of(plan, routine, index)
                return _executions(trail, trail.line > 0, routine, routine.line)
    return []


def _between(timing: Timing, program: Program, budget: Budget) -> list[Bools]:
    labels: dict[str, tuple[int, Routine]] = {}
    for routine in program.routines:
        for s in routine.body:
            if isinstance(s, Label):
                labels.setdefault(s.name.casefold(), (s.line, routine))
    first, last = (labels.get(label_name(name)) for name in (budget.start, budget.stop))
    if first is None or last is None:
        return []
    main = next((r for r in program.routines if r.name == program.main), program.routines[0])
    trail = _trail_of(timing.plan, first[1], 0)
    if first[1] is main:
        for unit, span in enumerate(timing.plan.calls):
            trail.line[span.start : span.stop] = span.line
            trail.unit[span.start : span.stop] = -1 - unit
    return _executions(trail, (trail.line > first[0]) & (trail.line < last[0]), first[1], first[0])


class _Trail(NamedTuple):
    """Where a routine is at each step. `line`: its own, of a call while that lasts where known, else 0.

    `unit`: the same number for all steps of one call, another one for every other step.
    """

    line: NDArray[np.int32]
    unit: NDArray[np.int64]


def _trail_of(plan: Plan, routine: Routine, source: int) -> _Trail:
    last = routine.last_line or max((s.line for s in routine.body), default=routine.line)
    own = (plan.source == source) & (plan.line >= routine.line) & (plan.line <= last)
    return _Trail(np.where(own, plan.line, 0).astype(np.int32), np.arange(len(plan), dtype=np.int64))


def _executions(trail: _Trail, inside: Bools, routine: Routine, begin: int) -> list[Bools]:
    """The steps `inside` as one mask per execution; each begins behind line `begin` of the routine."""
    steps = np.flatnonzero(inside).tolist()
    if not steps:
        return []
    head = int(trail.line[steps[0]])
    # Who is at the first line again has begun anew, unless a loop leads back there.
    loops = any(begin < s.line <= head and isinstance(s, _HEADS) for s in routine.body)
    cuts = [0]
    for position, (before, after) in enumerate(pairwise(steps), 1):
        again = int(trail.line[after]) == head and trail.unit[after] != trail.unit[before] and not loops
        left = after > before + 1 and bool((trail.line[before + 1 : after] > 0).any())
        back = after > before + 1 and not loops and trail.line[after] <= trail.line[before]
        if again or left or back:
            cuts.append(position)
    return [_run(len(inside), steps[a], steps[b - 1] + 1) for a, b in pairwise([*cuts, len(steps)])]


def _run(count: int, start: int, stop: int) -> Bools:
    run = np.zeros(count, dtype=bool)
    run[start:stop] = True
    return run
