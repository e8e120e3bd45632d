"""What to say when a plan misses a robot, or asks one for what it cannot do."""

from __future__ import annotations

import numpy as np

from olp.core.diagnostic import Diagnostic, OlpError, error, warning
from olp.ir.program import Path
from olp.robots.coordinate_systems import ROBOT_GAP, Gap
from olp.robots.robot import candidates_for_pulses
from olp.runtime.plan import PATHS, Plan, of_rows
from olp.runtime.state import Machine

_MOST_NAMED = 6
_UNREACHED = "check the robot, the tool and the user frame that the points are written in"


def missing_robots(m: Machine, plan: Plan) -> list[Diagnostic]:
    """One finding per thing that leaves positions unknown, with what would help."""
    found = [_finding(m, gap) for gap in m.world.cell.gaps.values() if gap.unusable]
    return found + _moves_without_axes(m, plan)


def _finding(m: Machine, gap: Gap) -> Diagnostic:
    file = m.jobs.program.path
    name = gap.key.removeprefix(ROBOT_GAP)
    if name == gap.key:
        return error(
            "I002", gap.says, file=file, help="use a robot file that has it, or teach the points as poses"
        )
    return error("I001", gap.says, file=file, help=f"{_remedy(m, name)}; {_candidates(m, name)}")


def _remedy(m: Machine, name: str) -> str:
    """How to say which robot the mechanism `name` is: the command line names the first arm only."""
    first = next((one.name for one in m.world.mechanisms if one.is_robot), name)
    if name == first:
        return 'say which one it is: --robot maker/model, or robot = "maker/model" in olp.toml'
    return f'say which one it is: {name} = "maker/model" under [robots] in olp.toml'


def _candidates(m: Machine, name: str) -> str:
    """The library robots whose soft limits hold all pulses of the mechanism `name`."""
    for index, mechanism in enumerate(m.world.mechanisms):
        span = m.recorder.pulse_span(index) if mechanism.name == name else None
        if span is None:
            continue
        try:
            fits = candidates_for_pulses(*(list(map(float, edge)) for edge in span))
        except OlpError:
            return "olp robots lists them"
        names = [fit.robot.name for fit in fits]
        if not names:
            return f"no library robot with {len(span[0])} axes reaches all of the pulses"
        more = f" and {len(names) - _MOST_NAMED} more" if len(names) > _MOST_NAMED else ""
        return f"the pulses fit {', '.join(names[:_MOST_NAMED])}{more}"
    return "olp robots lists them"


def _moves_without_axes(m: Machine, plan: Plan) -> list[Diagnostic]:
    """Moves to poses out of reach; without a robot joint moves to poses, which cannot be timed."""
    moves = plan.moves
    joint = moves.path == PATHS.index(Path.JOINT)
    findings: list[Diagnostic] = []
    for index, mechanism in enumerate(m.world.mechanisms):
        robot = mechanism.robot
        if not mechanism.is_robot or (robot is not None and robot.geometry is None):
            continue
        if f"{ROBOT_GAP}{mechanism.name}" in m.world.cell.gaps:  # told already
            continue
        rows = np.nonzero((moves.mechanism == index) & (joint if robot is None else True))[0]
        width = len(robot.axes) if robot is not None else 6
        target = moves.target[rows]
        lost = np.isnan(plan.positions.axes[target, :width]).any(axis=1)
        lost &= ~np.isnan(plan.positions.position[target, 0])
        if robot is None:
            says = f"this joint move to a Cartesian point needs the robot {mechanism.name}"
            findings += of_rows(plan, rows[lost], error, "I003", says, _remedy(m, mechanism.name))
        else:
            says = f"{mechanism.name} does not reach the target of this move"
            findings += of_rows(plan, rows[lost], warning, "I004", says, _UNREACHED)
    return findings
