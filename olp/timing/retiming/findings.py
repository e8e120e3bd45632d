"""What limits along a plan's paths have to be told, each with its line."""

from __future__ import annotations

import numpy as np

from olp.core.diagnostic import Diagnostic, warning
from olp.core.units import deg, mm
from olp.runtime.plan import Plan
from olp.runtime.plan_findings import of_rows
from olp.timing.retiming.limits import PathLimits

_MANNERS = ("a straight wrist", "a stretched arm", "a wrist above axis S")


def findings(plan: Plan, limits: PathLimits) -> tuple[Diagnostic, ...]:
    """One warning per file and kind of trouble, at its first line, counting the others."""
    moves = plan.moves

    def lost(row: int) -> tuple[str, str]:
        travels = moves.length[row] > 1e-9
        whole, unit, name = (moves.length[row], mm, "mm") if travels else (moves.angle[row], deg, "deg")
        place = f"{limits.lost[row] / unit:.1f} of {whole / unit:.1f} {name}"
        return (
            f"{_name(plan, row)}: the way to this point leaves the reach of the arm after {place}",
            "both ends can be reached, what lies between them cannot: use a joint move or a point between",
        )

    def outside(row: int) -> tuple[str, str]:
        axis = _axis(plan, row, int(limits.outside[row]))
        return (
            f"{_name(plan, row)}: axis {axis} leaves its soft limits on this move",
            "the controller will stop here with an alarm",
        )

    def singular(row: int) -> tuple[str, str]:
        kind, near = int(limits.singular[row]), limits.nearness[row]
        shown = f"{near / mm:.1f} mm" if kind == 2 else f"{near / deg:.2f} deg"
        return (
            f"{_name(plan, row)}: this move passes within {shown} of a singularity ({_MANNERS[kind]})",
            "its axes' speeds cannot be told there: the time is that of the programmed speed, the robot may be slower",
        )

    found = [
        ("L103", ~np.isnan(limits.lost), lost),
        ("L104", limits.outside >= 0, outside),
        ("L105", limits.singular >= 0, singular),
    ]
    told: list[Diagnostic] = []
    for code, where, says in found:
        rows = np.flatnonzero(where)
        if len(rows):
            told += of_rows(plan, rows, warning, code, *says(int(rows[0])))
    return tuple(told)


def _name(plan: Plan, row: int) -> str:
    return plan.mechanisms[int(plan.moves.mechanism[row])]


def _axis(plan: Plan, row: int, axis: int) -> str:
    robot = plan.robots[int(plan.moves.mechanism[row])]
    return robot.axis_names[axis] if robot else str(axis + 1)
