"""W007: another tool or frame in the middle of a path."""

from __future__ import annotations

from collections.abc import Iterator

from olp.checks.difference.compare import standing_of
from olp.checks.lint.rule import LintCase, Rule
from olp.reports.outcome.model import OutcomeFinding
from olp.runtime.plan import BlendCode


class ToolChange(Rule):
    """Two path moves without a stop between them whose targets are taught with different tools or frames."""

    code = "W007"
    title = "tool or frame changes within a path"
    why = (
        "The tool centre point or the frame changes between two moves: the controller stops, or rounds the corner "
        "unexpectedly. Most often one point was taught with the wrong tool."
    )
    example = "MOVL C00001 V=300.0 PL=3   taught with tool 1\nMOVL C00002 V=300.0        taught with tool 2"
    better = "teach both with the same tool, or stop between them"

    def find(self, case: LintCase) -> Iterator[OutcomeFinding]:
        standing, plan = standing_of(case.program), case.plan
        told = set()
        for before, after in zip(case.steps, case.steps[1:], strict=False):
            lines = int(plan.line[before]), int(plan.line[after])
            if after != before + 1 or lines[1] in told or not (case.on_path(before) and case.on_path(after)):
                continue
            first, second = (standing.get(line, ("", "")) for line in lines)
            stops = int(plan.moves.blend_code[case.row(before)]) == BlendCode.EXACT
            if first[0] != second[0] and "" not in (first[0], second[0]):
                what = f"tool {first[0]} → {second[0]}"
            elif (
                not stops
                and first[1] != second[1]
                and all("user" in frame for frame in (first[1], second[1]))
            ):
                what = f"frame {first[1]} → {second[1]}"
            else:
                continue
            told.add(lines[1])
            yield self.finding(case, lines[1], f"{what} within a path", "teach both points with the same one")
