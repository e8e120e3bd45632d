"""What the source program does at each of its lines, for passes that need the length or the time of a move."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from olp.ir.program import Move
from olp.runtime.plan import Plan, StepKind
from olp.transpile.context import TranslationContext

_NOTHING = 1e-9  # [m] or [rad]


class MoveExecution(NamedTuple):
    """One execution of a move. `length` [m], `angle` [rad]: of the tool; `axes` (k,) [rad]: what each axis turns."""

    length: float
    angle: float
    axes: tuple[float, ...]
    travel: float  # [m/s] programmed, nan
    fraction: float  # [1] programmed, nan
    blend: float  # [m] as the interpreter sees it, nan


@dataclass(slots=True)
class LineExecutions:
    """Executions of each line of the source's own file."""

    work: TranslationContext
    _by_line: dict[int, list[MoveExecution]] | None = field(default=None)
    _with_inputs: dict[int, list[MoveExecution]] | None = field(default=None)
    _room: dict[int, float] | None = field(default=None)

    def of(self, s: Move) -> list[MoveExecution]:
        """All executions of a move, in order: those of the run with the inputs on where the first does not reach it."""
        if self._by_line is None:
            plan = self.work.plan()
            self._by_line = {} if plan is None else _rows(plan)
        found = self._by_line.get(s.line)
        if found is not None:
            return found
        if self._with_inputs is None:
            plan = self.work.plan_with_inputs()
            self._with_inputs = {} if plan is None else _rows(plan)
        return self._with_inputs.get(s.line, [])

    def room(self, s: Move) -> float:
        """[m] half of the shortest way to or from the point of a move, inf where the plan shows none."""
        if self._room is None:
            on, plan = self.work.plan_with_inputs(), self.work.plan()
            self._room = {} if on is None else _rooms(on)
            self._room.update({} if plan is None else _rooms(plan))
        return self._room.get(s.line, math.inf)


def _rooms(plan: Plan) -> dict[int, float]:
    moves = plan.moves
    own = np.where(
        moves.length > _NOTHING, moves.length, np.inf
    )  # nan as well: who does not know bounds nothing
    next_way = np.append(own[1:], np.inf)
    next_way[np.append(moves.mechanism[1:] != moves.mechanism[:-1], True)] = np.inf
    half = 0.5 * np.minimum(own, next_way)
    steps = np.nonzero((plan.kind == StepKind.MOVE) & (plan.source == 0))[0]
    last = np.append(plan.row[plan.kind == StepKind.MOVE], len(moves))
    found: dict[int, float] = {}
    ends = last[np.searchsorted(last, plan.row[steps], side="right")] - 1
    for line, room in zip(plan.line[steps].tolist(), half[ends].tolist(), strict=True):
        if room < found.get(line, math.inf):
            found[line] = room
    return found


def _rows(plan: Plan) -> dict[int, list[MoveExecution]]:
    moves, positions = plan.moves, plan.positions
    steps = np.nonzero((plan.kind == StepKind.MOVE) & (plan.source == 0))[0]
    rows = plan.row[steps]
    turned = np.abs(positions.axes[moves.target[rows]] - positions.axes[moves.start[rows]])
    columns = (
        moves.length[rows].tolist(),
        moves.angle[rows].tolist(),
        map(tuple, turned.tolist()),
        moves.travel[rows].tolist(),
        moves.fraction[rows].tolist(),
        moves.blend[rows].tolist(),
    )
    found: dict[int, list[MoveExecution]] = {}
    for line, execution in zip(plan.line[steps].tolist(), map(MoveExecution, *columns), strict=True):
        found.setdefault(line, []).append(execution)
    return found


def moves_at_all(row: MoveExecution) -> bool:
    """Whether an execution goes anywhere, as far as is known; the first move starts where it ends."""
    return not row.length <= _NOTHING or not row.angle <= _NOTHING or any(a > _NOTHING for a in row.axes)
