"""Judges a timed program against its budgets: items that held or not, and the lines that would bring the time down.

A budget limits the seconds of a program, of a routine, or from one label to another.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from olp.checks.guard.budget import ENDS, Budget, label_name
from olp.core.source import file_stem
from olp.ir.program import Call, For, Label, Program, Repeat, Routine, While
from olp.reports.outcome.model import JudgedItem, Level, OutcomeFinding, Status
from olp.runtime.folder import read_cached
from olp.runtime.plan import Plan, StepKind
from olp.timing.result import Timing

Bools = NDArray[np.bool_]
_HEADS = (Label, For, While, Repeat)  # a run may come back to these
_KINDS = {"motion": StepKind.MOVE, "wait": StepKind.WAIT, "io": StepKind.SIGNAL}


class Measured(NamedTuple):
    """`seconds`: None if unknown (`why` is the reason). `steps` (n,): the steps that count."""

    seconds: float | None
    steps: Bools
    why: str = ""
    absent: bool = False  # the program has no such part, or never comes there


def measure(timing: Timing, program: Program, budget: Budget) -> Measured:
    """The seconds that `budget` limits: of several executions those of the longest."""
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
    """The steps of each execution, and the reason if there is none."""
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
    """Executions of a routine that routines other than the main one call. Its own calls count as part of it."""
    for index, source in enumerate(plan.sources):
        own = program if index == 0 else read_cached(Path(source.path))
        stem = file_stem(source.path).casefold()
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
    """Position within a routine at each step. `line`: its own line, or that of its call while the call lasts; 0
    elsewhere.

    `unit`: the same number for all steps of one call, another one for every other step.
    """

    line: NDArray[np.int32]
    unit: NDArray[np.int64]


def _trail_of(plan: Plan, routine: Routine, source: int) -> _Trail:
    last = routine.last_line or max((s.line for s in routine.body), default=routine.line)
    own = (plan.source == source) & (plan.line >= routine.line) & (plan.line <= last)
    return _Trail(np.where(own, plan.line, 0).astype(np.int32), np.arange(len(plan), dtype=np.int64))


def _executions(trail: _Trail, inside: Bools, routine: Routine, begin: int) -> list[Bools]:
    """The steps `inside` as one mask per execution; each begins after line `begin` of the routine."""
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


_WORST = 3  # lines that are told per budget


def judge_timing(
    path: str, program: Program, timings: Mapping[str, Timing], budgets: Sequence[Budget]
) -> tuple[list[JudgedItem], list[OutcomeFinding]]:
    """Verdicts of `budgets` on a timed program. `timings`: by the signature that a budget names."""
    items: list[JudgedItem] = []
    found: list[OutcomeFinding] = []
    for budget in budgets:
        timing = timings[budget.signature]
        measured = measure(timing, program, budget)
        if measured.absent and budget.anywhere:
            continue
        item, more = _one(path, timing, budget, measured)
        items.append(item)
        found.extend(more)
    return items, found


def unknown_item(budget: Budget, path: str, why: str) -> JudgedItem:
    """The verdict where the seconds of a budget are not known."""
    return JudgedItem(budget.name, path, Status.UNKNOWN, why, limit_s=budget.limit_s, group="budget")


def _one(
    path: str, timing: Timing, budget: Budget, measured: Measured
) -> tuple[JudgedItem, list[OutcomeFinding]]:
    if measured.seconds is None:
        return unknown_item(budget, path, measured.why), []
    seconds, limit = measured.seconds, budget.limit_s + budget.tolerance_s
    broken = next(iter(timing.left_open), None)
    if broken is not None and seconds <= limit:
        # What cannot be read or run takes time too. Over the limit it is over either way.
        item = unknown_item(budget, path, f"at least {seconds:.3f} s: {broken.message}")
        return replace(item, seconds=seconds, line=broken.line if broken.file in ("", path) else 0), []
    status, says = verdict(budget, seconds, timing.total_s)
    item = JudgedItem(budget.name, path, status, says, 0, seconds, budget.limit_s, "budget")
    whole = budget.of == "total" and not budget.routine and not budget.start
    if whole and timing.total_ends is not None:
        low, high = (round(end, 6) for end in timing.total_ends)
        item = replace(item, low_s=low, high_s=high)
    if seconds <= limit:
        return item, []
    worst = _worst(path, timing, measured)
    told = "\n".join(f"{f.file}:{f.line}: {f.message}; {f.help}" for f in worst)
    item = replace(item, line=_place(path, timing, measured, worst), details=told)
    level = Level.ERROR if budget.fails else Level.WARNING
    head = OutcomeFinding(
        "M010",
        level,
        f"{budget.name}: {says}",
        path,
        item.line,
        title="cycle time over its budget",
        help="the lines below take most of it",
        anchor=budget.name,
        numbers={
            "seconds": round(seconds, 6),
            "limit_s": budget.limit_s,
            "over_s": round(seconds - budget.limit_s, 6),
        },
    )
    return item, [head, *worst]


def verdict(budget: Budget, seconds: float, total_s: float) -> tuple[Status, str]:
    """Verdict of a budget on the `seconds` [s] that it limits, in a program of known total `total_s` [s]."""
    limit, over = budget.limit_s + budget.tolerance_s, seconds - budget.limit_s
    what = "" if budget.of == "total" else f" of {budget.of}"
    word = {"upper": "upper end", "lower": "lower end"}.get(budget.on, "predicted")
    if seconds > limit:
        says = f"{word} {seconds:.3f} s{what}, {over:.3f} s over the budget of {budget.limit_s:g} s"
        return (Status.FAILED if budget.fails else Status.WARNED), says
    if budget.on == "lower" and limit < total_s:
        # Over, but no further than what the recording leaves open.
        says = f"predicted {total_s:.3f} s; the budget of {budget.limit_s:g} s is within the interval"
        return Status.WARNED, says
    says = f"{word} {seconds:.3f} s{what}, {-over:.3f} s below the budget of {budget.limit_s:g} s"
    return (Status.WARNED if seconds >= budget.warn_s else Status.HELD), says


def _place(path: str, timing: Timing, measured: Measured, worst: list[OutcomeFinding]) -> int:
    """The line of the program itself that takes most time: one of the worst, or the call that leads to them."""
    own = next((found.line for found in worst if found.file == path), 0)
    if own:
        return own
    seconds = np.nan_to_num(timing.duration_s) * measured.steps
    sums: dict[int, float] = {}
    for span in timing.plan.calls:
        sums[span.line] = sums.get(span.line, 0.0) + float(seconds[span.start : span.stop].sum())
    return max(sums, key=lambda line: sums[line], default=0)


def _worst(path: str, timing: Timing, measured: Measured) -> list[OutcomeFinding]:
    """The lines that take longest, each summed over its executions, with what limits them."""
    plan, steps = timing.plan, np.flatnonzero(measured.steps)
    keys = plan.source[steps].astype(np.int64) << 32 | plan.line[steps]
    _, first, line = np.unique(keys, return_index=True, return_inverse=True)
    sums = np.bincount(line, np.nan_to_num(timing.duration_s[steps]), len(first))
    order = np.lexsort((first, -sums))[:_WORST].tolist()
    return [
        _line(timing, measured, int(steps[first[at]]), float(sums[at]), path) for at in order if sums[at] > 0
    ]


def _line(timing: Timing, measured: Measured, step: int, seconds: float, path: str) -> OutcomeFinding:
    plan = timing.plan
    key = int(plan.source[step]), int(plan.line[step])
    source = plan.sources[key[0]]
    same = (plan.source == key[0]) & (plan.line == key[1]) & measured.steps
    times = int(np.count_nonzero(same))
    often = f" in {times} executions" if times > 1 else ""
    return OutcomeFinding(
        "M011",
        Level.NOTE,
        f"{seconds:.3f} s{often}: {plan.statement(step)}",
        source.path or path,
        key[1],
        title="a line that takes much of a budget",
        help=advice(timing, step),
        source_line=source.line(key[1]),
        anchor=plan.statement(step),
        numbers={"seconds": round(seconds, 6)},
    )


def advice(timing: Timing, step: int) -> str:
    """Sentence on how to reduce the line's time."""
    kind, rule = timing.kind[step], timing.limited_by[step]
    if kind == "wait":
        return "a wait: give the signal earlier, or set its real duration under [waits] in olp.toml"
    if kind == "signal":
        return "a process instruction: its time is that of [process] in olp.toml"
    speed, reached = _number(timing.speed_mm_s, step), _number(timing.reached_mm_s, step)
    if rule.endswith("acceleration"):
        never = (
            f" (V={speed:g} mm/s, reached {reached:.0f})"
            if speed and reached and reached < 0.99 * speed
            else ""
        )
        return f"limited by {rule}{never}: more speed changes nothing; a longer corner rounding or fewer stops do"
    if rule == "speed":
        return "the programmed speed limits it: a higher one shortens it"
    if rule.startswith("orientation"):
        return "the tool's rotation limits it: turn less, or spread the rotation over a longer path"
    return f"limited by {rule}" if rule else ""


def _number(values: NDArray[np.float64], step: int) -> float | None:
    value = float(values[step])
    return None if np.isnan(value) else value
