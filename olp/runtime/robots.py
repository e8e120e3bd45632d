"""What to say when a plan misses a robot, or asks one for what it cannot do."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np
from numpy.typing import NDArray

from olp.core.diagnostic import Diagnostic, OlpError, Span, error, warning
from olp.ir.program import Path
from olp.robots.coordinate_systems import ROBOT_GAP, Gap
from olp.robots.robot import candidates_for_pulses
from olp.runtime.plan import PATHS, Plan, StepKind
from olp.runtime.state import Machine

ROBOT_IS_ASKED_FOR = ("I001", "I003")  # codes of findings that say that moves need a robot
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


# --- Plan findings ---
# What is told of moves of a plan: once per file, at the first line that it holds of, with the number of the others.


def lines_of(plan: Plan, rows: NDArray[np.integer]) -> dict[int, list[int]]:
    """Index into `plan.sources` -> its lines, each once, that `rows` (r,) of the plan's Moves are from."""
    if not len(rows):
        return {}
    steps = np.flatnonzero(plan.kind == StepKind.MOVE)
    owners = steps[np.searchsorted(plan.row[steps], rows, side="right") - 1]
    lines: dict[int, dict[int, None]] = {}
    for source, line in zip(plan.source[owners].tolist(), plan.line[owners].tolist(), strict=True):
        lines.setdefault(source, {})[line] = None
    return {source: list(found) for source, found in lines.items()}


def of_rows(
    plan: Plan, rows: NDArray[np.integer], tell: Callable[..., Diagnostic], code: str, says: str, how: str
) -> Iterator[Diagnostic]:
    """`tell` is `error`, `warning` or `info`; `rows` (r,) of the plan's Moves in order; `says` of the first of them."""
    for source, found in lines_of(plan, rows).items():
        line, more = found[0], len(found) - 1
        text = plan.sources[source].line(line)
        count = "" if not more else " (and once more)" if more == 1 else f" (and in {more} more lines)"
        span = Span(line, len(text) - len(text.lstrip()) + 1, len(text.rstrip()) + 1)
        yield tell(code, says + count, span, file=plan.sources[source].path, source_line=text, help=how)
