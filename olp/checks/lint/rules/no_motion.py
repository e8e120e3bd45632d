"""W015: a move to the current position."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from olp.checks.lint.rule import LintCase, Rule, Suggestion
from olp.core.units import mm
from olp.ir.program import Path, Program
from olp.reports.outcome.model import Level, OutcomeFinding
from olp.runtime.plan import PATHS

_NOTHING = 1e-3 * mm
_ARC = PATHS.index(Path.CIRCULAR), PATHS.index(Path.SPLINE)


class NoMotion(Rule):
    """A move whose target is the current position, each time it runs."""

    code = "W015"
    title = "move that goes nowhere"
    level = Level.NOTE
    why = (
        "The arm is already at the target. The move costs a stop and does nothing; often a copied point was never "
        "taught again."
    )
    example = "MOVL C00004 V=300.0\nMOVL C00005 V=300.0   with C00005 = C00004"
    better = "leave the second one out"
    suggests = True

    def find(self, case: LintCase) -> Iterator[OutcomeFinding]:
        plan = case.plan
        moves = plan.moves
        for line, steps in case.lines.items():
            rows = [case.row(step) for step in steps]
            still = [self._still(case, row) for row in rows]
            # The first move of a run is to wherever the arm is taken to stand; an arc begins where the arm is.
            if (
                all(still)
                and steps[0] != 0
                and int(moves.path[rows[0]]) not in _ARC
                and not self._first(case, steps)
            ):
                yield self.finding(case, line, "the arm is already at this target", "leave the move out")

    def suggest(self, program: Program, found: OutcomeFinding) -> Iterator[Suggestion]:
        yield found.line, found.line, "", "leave the move out"

    @staticmethod
    def _still(case: LintCase, row: int) -> bool:
        moves = case.plan.moves
        axes = case.plan.positions.axes
        same = int(moves.start[row]) == int(moves.target[row])
        turned = np.nan_to_num(axes[int(moves.start[row])] - axes[int(moves.target[row])])
        still = (
            float(moves.length[row]) <= _NOTHING
            and float(moves.angle[row]) < 1e-6
            and not np.abs(turned).max() > 1e-6
        )
        return same or bool(still)

    @staticmethod
    def _first(case: LintCase, steps: list[int]) -> bool:
        return any(step == min(case.steps) for step in steps)
