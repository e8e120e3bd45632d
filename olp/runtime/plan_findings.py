"""What is told of moves of a plan: once per file, at the first line that it holds of, with the number of the others."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np
from numpy.typing import NDArray

from olp.core.diagnostic import Diagnostic, Span
from olp.runtime.plan import Plan, StepKind


def lines_of(plan: Plan, rows: NDArray[np.integer]) -> dict[int, list[int]]:
    """Index into `plan.sources` -> its lines, each once, that `rows` (r,) of the plan's Moves are from."""
    if not len(rows):
        return {}
    steps = np.flatnonzero(plan.kind == StepKind.MOVE)
    owners = steps[np.searchsorted(plan.row[steps], rows, side="right") - 1]
    lines: dict[int, dict[int, None]] = {}
    for source, line in zip(plan.source[owners].tolist(), plan.line[owners].tolist(), strict=True):
        lines.setdefault(source, {})[line] = None
    return {source: list(found) for source, found in lines.items()}


def of_rows(
    plan: Plan, rows: NDArray[np.integer], tell: Callable[..., Diagnostic], code: str, says: str, how: str
) -> Iterator[Diagnostic]:
    """`tell` is `error`, `warning` or `info`; `rows` (r,) of the plan's Moves in order; `says` of the first of them."""
    for source, found in lines_of(plan, rows).items():
        line, more = found[0], len(found) - 1
        text = plan.sources[source].line(line)
        count = "" if not more else " (and once more)" if more == 1 else f" (and in {more} more lines)"
        span = Span(line, len(text) - len(text.lstrip()) + 1, len(text.rstrip()) + 1)
        yield tell(code, says + count, span, file=plan.sources[source].path, source_line=text, help=how)
