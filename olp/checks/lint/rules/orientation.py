"""W004: the reorientation of the tool limits the time."""

from __future__ import annotations

from collections.abc import Iterator

from olp.checks.lint.rule import LintCase, Rule
from olp.reports.outcome.model import OutcomeFinding


class OrientationRules(Rule):
    """A line whose time is set by the reorientation of the tool, not by its travel."""

    code = "W004"
    title = "orientation rules the time"
    why = (
        "The tool turns so far on a short path that the wrist limits the speed: the programmed one is not reached. "
        "Often one point was taught carelessly; spread the rotation over the longer move before or after."
    )
    example = "MOVL C00001 V=500.0   40 mm further and 90 deg turned"
    better = "turn on the long approach"

    def find(self, case: LintCase) -> Iterator[OutcomeFinding]:
        for line, steps in case.lines.items():
            step = next((s for s in steps if case.turn_rules(s)), None)
            if step is not None:
                angle, way = float(case.timing.angle_deg[step]), float(case.timing.distance_mm[step])
                says = f"the tool turns {angle:.0f} deg on {way:.0f} mm: the turn decides"
                yield self.finding(
                    case, line, says, "turn less here, or spread the turn over the moves around"
                )
