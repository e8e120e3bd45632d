"""Lines, arcs and splines slow down where an axis would have to turn faster than it can."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from olp.core.diagnostic import Diagnostic
from olp.runtime.plan import Plan

if TYPE_CHECKING:
    from olp.timing.accelerations import MotionLimits
    from olp.timing.demand import Demand


def slow_down(plan: Plan, limits: MotionLimits, out: Demand, names: list[str]) -> tuple[Diagnostic, ...]:
    """Lowers the speeds of rows and names the axis; what is to be told of singularities, reach and soft limits.

    A row keeps one speed: the mean one of a run that slows down only where the axis asks for it.
    """
    from olp.timing.retiming import along_path

    found = along_path(plan, out.speed, out.acceleration)
    for says in found.assumptions:
        limits.report(says)
    out.slowed = found.known & ~out.unknown & (found.paced < out.speed)
    rows = np.flatnonzero(out.slowed)
    out.speed[rows] = found.paced[rows]
    for mechanism in np.unique(plan.moves.mechanism[rows]):
        robot, name = plan.robots[mechanism], plan.mechanisms[mechanism]
        assert robot is not None
        some = rows[plan.moves.mechanism[rows] == mechanism]
        out.rule[some] = len(names) + found.axis[some]
        names.extend(
            f"axis {axis}" if name.startswith("R") else f"{name} axis {axis}" for axis in robot.axis_names
        )
    return found.diagnostics
