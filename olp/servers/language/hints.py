"""What stands behind a line: its time, the running total, and what limits it."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from olp.runtime.plan import StepKind
from olp.servers.language.analysis import Analysis


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
