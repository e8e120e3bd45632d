"""What the source program does at each of its lines, for passes that need the length or the time of a move."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from olp.plan import Plan, StepKind
from olp.program import Move
from olp.translate.work import Work

_NOTHING = 1e-9  # [m] or [rad]


class Row(NamedTuple):
    """One execution of a move. `length` [m], `angle` [rad]: of the tool; `axes` (k,) [rad]: what each axis turns."""

    length: float
    angle: float
    axes: tuple[float, ...]
    travel: float  # [m/s] programmed, nan
    fraction: float  # [1] programmed, nan
    blend: float  # [m] as the interpreter sees it, nan


@dataclass(slots=True)
class Rows:
    """Executions of each line of the source's own file."""

    work: Work
    _by_line: dict[int, list[Row]] | None = field(default=None)

    def of(self, s: Move) -> list[Row]:
        """All executions of a move, in order; none where the plan does not reach it."""
        if self._by_line is None:
            plan = self.work.plan()
            self._by_line = {} if plan is None else _rows(plan)
        return self._by_line.get(s.line, [])


def _rows(plan: Plan) -> dict[int, list[Row]]:
    found: dict[int, list[Row]] = {}
    moves, positions = plan.moves, plan.positions
    turned = np.abs(positions.axes[moves.target] - positions.axes[moves.start])
    steps = np.nonzero((plan.kind == StepKind.MOVE) & (plan.source == 0))[0]
    for step in steps.tolist():
        row = int(plan.row[step])
        found.setdefault(int(plan.line[step]), []).append(
            Row(
                float(moves.length[row]),
                float(moves.angle[row]),
                tuple(turned[row].tolist()),
                float(moves.travel[row]),
                float(moves.fraction[row]),
                float(moves.blend[row]),
            )
        )
    return found


def moves_at_all(row: Row) -> bool:
    """Whether an execution goes anywhere, as far as is known; the first move starts where it ends."""
    return not row.length <= _NOTHING or not row.angle <= _NOTHING or any(a > _NOTHING for a in row.axes)
