"""W002: a programmed speed that is never reached."""

from __future__ import annotations

from collections.abc import Iterator
from math import ceil

from olp.checks.lint.rule import LintCase, Rule, Suggestion
from olp.core.units import mm
from olp.ir.program import Program
from olp.reports.outcome.model import Level, OutcomeFinding

_SHARE = 0.5
_SLOW = 50.0  # [mm/s] below this nobody gains anything


class UnreachedSpeed(Rule):
    """A line on which the tool never comes near its programmed speed."""

    code = "W002"
    title = "speed never reached"
    level = Level.NOTE
    why = (
        "The move is too short for its speed: the tool brakes before it reaches half of the programmed value. A "
        "higher speed changes nothing, and the number misleads whoever estimates the time from it."
    )
    example = "MOVL C00001 V=1500.0\nMOVL C00002 V=1500.0   with 12 mm between them"
    better = "MOVL C00002 V=300.0"
    suggests = True

    def find(self, case: LintCase) -> Iterator[OutcomeFinding]:
        timing = case.timing
        programmed, peak = timing.speed_mm_s, timing.reached_mm_s
        # All steps at once, since most are not slow; a number that is not known compares as false.
        slow = ((programmed > _SLOW) & (peak > 0) & (peak < _SHARE * programmed)).tolist()
        for line, steps in case.lines.items():
            # Where the turn decides, that is what has to change.
            if (
                all(slow[step] for step in steps)
                and all(map(case.on_path, steps))
                and not any(map(case.turn_rules, steps))
            ):
                speed, reached = programmed[steps], peak[steps]
                says = f"V = {speed[0]:g} mm/s is never reached: at most {reached.max():.0f} mm/s"
                yield self.finding(
                    case, line, says, f"write what it reaches, about {_round(float(reached.max())):g}",
                    numbers={"speed_mm_s": float(speed[0]), "reached_mm_s": round(float(reached.max()), 3)},
                )  # fmt: skip

    def suggest(self, program: Program, found: OutcomeFinding) -> Iterator[Suggestion]:
        from olp.checks.edit import ChangeSpeed, edited
        from olp.core.diagnostic import OlpError
        from olp.ir.program import SpeedUnit
        from olp.languages.literals import speed_of

        old = speed_of(program, found.line)
        reached = found.numbers.get("reached_mm_s")
        if old is None or old.unit is not SpeedUnit.TRAVEL or not isinstance(reached, float):
            return
        speed = ceil(reached)  # no slower than the line is
        try:
            result = edited(program, [ChangeSpeed(found.line, speed * mm)])
        except OlpError:
            return
        if [one.path for one in result.sources] == [program.path]:
            for _, line in result.lines:
                yield line, line, result.program.source.line(line), f"write V = {speed} mm/s"


def _round(value: float) -> float:
    return round(value, -1) if value >= 100 else round(value)
