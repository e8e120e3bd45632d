"""Both programs run: as olp.toml and the usual assumptions have it, and again with the inputs that they ask for on."""

from __future__ import annotations

from olp.core.diagnostic import OlpError
from olp.ir.program import Program
from olp.robots.robot import Robot
from olp.transpile.context import MOST_AGAIN, asked_inputs, plan_of
from olp.transpile.convert import Converted, rerun
from olp.transpile.receipt import PlanRuns


def runs_of(
    source: Program, converted: Converted, vendor: str, robots: tuple[Robot | None, Robot | None]
) -> PlanRuns:
    """`robots`: of the source, and of the translation where it is another one."""
    asked = asked_inputs(source)
    sets = [asked] if asked else []
    first = [plan_of(source, robots[0], None, None)]
    first += [plan_of(source, robots[0], inputs, MOST_AGAIN) for inputs in sets]
    try:
        there = rerun(converted, vendor, robots[1] or robots[0], source, sets)
    except OlpError:
        return PlanRuns(tuple(first), (None,) * len(first))
    return PlanRuns(tuple(first), there.plans, there.origins)
