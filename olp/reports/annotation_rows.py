"""What there is to say about each line: its executions counted and summed, and what the jobs it calls took."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from olp.ir.program import Begin, Program

if TYPE_CHECKING:
    from numpy.typing import NDArray

    from olp.runtime.plan import CallSpan
    from olp.timing.timing import Timing

_AVERAGED = ("distance_mm", "speed_mm_s", "reached_mm_s", "accel_mm_s2")


@dataclass(frozen=True, slots=True)
class AnnotationRow:
    """One line, as a template sees it; templates/inform_annotation.j2 lists the kinds.

    Numbers other than `seconds` are the mean of the `count` executions, nan where they do not apply.
    """

    line: int
    kind: str
    statement: str
    count: int
    seconds: float  # [s], all executions together
    end_s: float  # [s] from the program's start to the end of the last execution
    distance_mm: float = math.nan
    speed_mm_s: float = math.nan  # as programmed
    reached_mm_s: float = math.nan  # the highest
    accel_mm_s2: float = math.nan
    limited_by: str = ""
    motion_s: float = math.nan  # [s], of the total only, like the next two
    wait_s: float = math.nan
    io_s: float = math.nan

    @property
    def mean_s(self) -> float:
        """[s] of one execution."""
        return self.seconds / self.count if self.count else 0.0


def rows(program: Program, timing: Timing) -> list[AnnotationRow]:
    """The rows of `program`'s file in the order of its lines, the total first."""
    found = [*_own(program, timing), *_calls(program, timing)]
    found.sort(key=lambda row: row.line)
    return [*_total(program, timing), *found]


def _total(program: Program, timing: Timing) -> Iterator[AnnotationRow]:
    body = program.routines[0].body if program.routines else ()
    begin = next((statement for statement in body if isinstance(statement, Begin)), None)
    if begin is not None:
        text = program.source.line(begin.line).strip()
        total = timing.total_s
        yield AnnotationRow(
            begin.line,
            "total",
            text,
            1,
            total,
            total,
            motion_s=timing.motion_s,
            wait_s=timing.wait_s,
            io_s=timing.io_s,
        )


def _own(program: Program, timing: Timing) -> Iterator[AnnotationRow]:
    """One row per line of this file that was executed and takes time or moves."""
    plan = timing.plan
    here = [index for index, source in enumerate(plan.sources) if source.path == program.source.path]
    steps = np.nonzero(np.isin(plan.source, here))[0]
    lines, first, group, counts = np.unique(
        plan.line[steps], return_index=True, return_inverse=True, return_counts=True
    )
    seconds = np.bincount(group, timing.duration_s[steps], len(lines))
    ends = np.zeros(len(lines))
    np.maximum.at(ends, group, timing.end_s[steps])
    means = [_mean(getattr(timing, name)[steps], group, len(lines)) for name in _AVERAGED]
    columns = zip(
        lines.tolist(),
        steps[first].tolist(),
        counts.tolist(),
        seconds.tolist(),
        ends.tolist(),
        *(mean.tolist() for mean in means),
        strict=True,
    )
    for line, step, count, total, end, *numbers in columns:
        text = program.source.line(line).strip()
        distance, speed, reached, acceleration = numbers
        yield AnnotationRow(
            line,
            timing.kind[step],
            text,
            count,
            total,
            end,
            distance,
            speed,
            reached,
            acceleration,
            timing.limited_by[step],
        )


def _mean(values: NDArray[np.float64], group: NDArray[np.intp], size: int) -> NDArray[np.float64]:
    """The mean of each group's known values, nan where none is known."""
    is_known = ~np.isnan(values)
    count = np.bincount(group[is_known], minlength=size)
    total = np.bincount(group[is_known], values[is_known], size)
    with np.errstate(invalid="ignore"):
        mean: NDArray[np.float64] = np.where(count > 0, total / count, np.nan)
    return mean


def _calls(program: Program, timing: Timing) -> Iterator[AnnotationRow]:
    """One row per call of the main routine, with what all its executions took in other files."""
    plan = timing.plan
    if not plan.sources or plan.sources[0].path != program.source.path:
        return
    spent = np.concatenate(
        [[0.0], np.cumsum(np.where(plan.source > 0, np.nan_to_num(timing.duration_s), 0.0))]
    )
    ends = np.concatenate([[0.0], timing.end_s])
    spans: dict[int, list[CallSpan]] = {line: [] for line in sorted({span.line for span in plan.calls})}
    for span in plan.calls:
        spans[span.line].append(span)
    for line, found in spans.items():
        seconds = sum(float(spent[span.stop] - spent[span.start]) for span in found)
        if seconds > 0.0:
            text = program.source.line(line).strip()
            yield AnnotationRow(line, "call", text, len(found), seconds, float(ends[found[-1].stop]))
