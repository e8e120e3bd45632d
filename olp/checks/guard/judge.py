"""One file against its budgets: items that held or not, and the lines that would bring the time down."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from olp.checks.guard.budget import Budget
from olp.checks.guard.measure import Measured, measure
from olp.core.diagnostic import OlpError
from olp.ir.program import Program
from olp.reports.batch import Job, time_program
from olp.reports.outcome.model import JudgedItem, Level, OutcomeFinding, Status, of_diagnostic
from olp.timing.timing import Timing

_WORST = 3  # lines that are told per budget


@dataclass(frozen=True, slots=True)
class JudgedFile:
    """What became of one file. `read`: the files whose content decided, for the cache; `unread`: it could not be."""

    path: str
    items: tuple[JudgedItem, ...]
    findings: tuple[OutcomeFinding, ...]
    total_s: float | None
    motion_s: float = 0.0
    wait_s: float = 0.0
    io_s: float = 0.0
    high_s: float | None = None
    read: tuple[str, ...] = ()
    unread: bool = False


def judge(path: str, budgets: Sequence[Budget], job: Job) -> JudgedFile:
    """Times the program in `path` and holds it against `budgets`. Never raises for a bad program."""
    from olp.languages.read import read

    try:
        program = read(path, encoding=job.encoding)
        timings = {given: _timed(program, job, given) for given in {b.signature for b in budgets} | {""}}
    except OlpError as problem:
        findings = tuple(of_diagnostic(d, path) for d in problem.diagnostics)
        why = problem.diagnostics[0].message
        unknown = tuple(_unknown(b, path, why) for b in budgets)
        return JudgedFile(path, unknown, findings, None, read=(path,), unread=True)
    plain = timings[""]
    items, more = judge_timing(path, program, timings, budgets)
    found = [*_once([of_diagnostic(d.at(path)) for d in plain.diagnostics]), *more]
    read_files = tuple(
        dict.fromkeys([path, *(s.path for s in plain.plan.sources), *(s.path for s in program.companions)])
    )
    whole = not plain.untimed and not plain.left_open
    total = plain.total_s if whole else None
    sums = (plain.motion_s, plain.wait_s, plain.io_s, plain.high_s)
    return JudgedFile(path, tuple(items), tuple(found), total, *sums, read_files)


def judge_timing(
    path: str, program: Program, timings: Mapping[str, Timing], budgets: Sequence[Budget]
) -> tuple[list[JudgedItem], list[OutcomeFinding]]:
    """What `budgets` say of a program that is timed. `timings`: by the signature that a budget asks for."""
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


def _once(found: list[OutcomeFinding]) -> list[OutcomeFinding]:
    seen: dict[tuple[str, str, int, str], OutcomeFinding] = {}
    for finding in found:
        seen.setdefault((finding.code, finding.file, finding.line, finding.message), finding)
    return list(seen.values())


def _timed(program: Program, job: Job, signature: str) -> Timing:
    return time_program(program, replace(job, signature=signature) if signature else job)


def _unknown(budget: Budget, path: str, why: str) -> JudgedItem:
    return JudgedItem(budget.name, path, Status.UNKNOWN, why, limit_s=budget.limit_s, group="budget")


def _one(
    path: str, timing: Timing, budget: Budget, measured: Measured
) -> tuple[JudgedItem, list[OutcomeFinding]]:
    if measured.seconds is None:
        return _unknown(budget, path, measured.why), []
    seconds, limit = measured.seconds, budget.limit_s + budget.tolerance_s
    broken = next(iter(timing.left_open), None)
    if broken is not None and seconds <= limit:
        # What cannot be read or run takes time too. Over the limit it is over either way.
        item = _unknown(budget, path, f"at least {seconds:.3f} s: {broken.message}")
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
    """What a budget says of the `seconds` [s] that it is about, in a program of `total_s` [s] that is known whole."""
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
    """The line of the program itself that takes most: one of the worst, or the call that leads to them."""
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
    """What would bring the line's time down."""
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
