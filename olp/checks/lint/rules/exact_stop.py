"""W001: an exact stop in the middle of a path."""

from __future__ import annotations

from collections.abc import Iterator
from math import degrees, radians

import numpy as np

from olp.checks.lint.rule import LintCase, Rule, Suggestion
from olp.checks.lint.zones import rounded
from olp.ir.program import Program
from olp.reports.outcome.model import OutcomeFinding
from olp.runtime.plan import BlendCode, StepKind

_SHARP = radians(75)  # from here on a stop may be meant: the tool turns back or round a corner
_SHORT = 1e-3  # [m]


class ExactStop(Rule):
    """Two path moves in nearly the same direction with an exact stop between them that no action needs."""

    code = "W001"
    title = "exact stop inside a path"
    why = (
        "The robot stops although the path goes straight on and nothing happens there: no output, no wait, no call. "
        "Braking, starting and settling cost some 0.1 to 0.4 s each time."
    )
    example = "MOVL C00001 V=300.0 PL=0\nMOVL C00002 V=300.0"
    better = "MOVL C00001 V=300.0 PL=1\nMOVL C00002 V=300.0"
    suggests = True

    def find(self, case: LintCase) -> Iterator[OutcomeFinding]:
        plan, told = case.plan, set()
        for step in case.steps:
            line = int(plan.line[step])
            if line in told or step + 1 >= len(plan) or not self._stops(case, step):
                continue
            turn = case.turn(step, step + 1)
            if np.isfinite(turn) and turn < _SHARP:
                told.add(line)
                says = f"the robot stops here, and goes on at {degrees(turn):.0f} deg to where it came from"
                yield self.finding(case, line, says, "give the corner a rounding, if nothing needs the stop")

    def suggest(self, program: Program, found: OutcomeFinding) -> Iterator[Suggestion]:
        text = rounded(program.vendor, program.source.line(found.line))
        if text is not None:
            yield found.line, found.line, text, "round the corner a little"

    def _stops(self, case: LintCase, step: int) -> bool:
        """Whether the step ends in an exact stop and the next step continues the path."""
        plan = case.plan
        if plan.kind[step + 1] != StepKind.MOVE or plan.source[step + 1] != plan.source[step]:
            return False
        first, second = case.row(step), case.row(step + 1)
        moves = plan.moves
        long = min(float(moves.length[first]), float(moves.length[second])) > _SHORT
        exact = int(moves.blend_code[first]) == BlendCode.EXACT
        between = range(int(plan.line[step]) + 1, int(plan.line[step + 1]))
        quiet = not any(line in case.statements and self._acts(case, line) for line in between)
        return exact and long and quiet and case.on_path(step) and case.on_path(step + 1)

    @staticmethod
    def _acts(case: LintCase, line: int) -> bool:
        from olp.ir.program import Comment, SetSpeed

        return not isinstance(case.statements[line], (Comment, SetSpeed))
