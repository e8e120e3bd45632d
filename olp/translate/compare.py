"""Are two plans the same motion? Zero-length moves are left out, and an arc in two steps counts as one."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence, Set
from dataclasses import dataclass, field
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from olp.interpreter.state import VALUE_IS_UNKNOWN
from olp.plan import PATHS, BlendCode, Plan, StepKind
from olp.program import Path
from olp.units import deg, mm

Floats = NDArray[np.float64]
_POSITION = 0.001 * mm  # [m]
_ANGLE = 0.0001 * deg  # [rad]
_STILL = 0.002 * mm  # [m] a shorter move goes nowhere
_TURN = 0.0002 * deg  # [rad]
_INSTANT = 1e-6  # [s] by which points that are rounded change a move


class Step(NamedTuple):
    """One thing that happens: a move, a wait or a signal, in SI. nan where the plan does not know."""

    kind: StepKind
    line: int
    path: Path | None = None
    position: tuple[float, ...] = ()
    rotation: tuple[float, ...] = ()  # quaternion
    axes: tuple[float, ...] = ()
    travel: float = math.nan
    turn: float = math.nan
    time: float = math.nan  # of a joint move: what its programmed speed asks for
    blend: float = math.nan
    exact: bool = False  # the arm stops at the end
    duration: float = math.nan
    seconds: float = 0.0  # what the step takes as timed, with those that were put together with it


@dataclass(slots=True)
class Comparison:
    """What differs. The worst of matching steps: position and blend [m], angle [rad], speed [1], wait [s].

    `unknown`: lines of the first program that its run left out, for it does not know their values. `until`: the first
    of them where the two go different ways from there on, which is not compared; 0: all was.
    """

    steps: int = 0
    differences: list[str] = field(default_factory=list)
    worst_position: float = 0.0
    worst_angle: float = 0.0
    worst_speed: float = 0.0
    worst_blend: float = 0.0
    worst_wait: float = 0.0
    unknown: tuple[int, ...] = ()
    until: int = 0

    @property
    def is_equal(self) -> bool:
        """Whether nothing differs but, within the limits, numbers."""
        return not self.differences


def compare_plans(
    one: Plan,
    other: Plan,
    *,
    speeds: bool = True,
    blends: bool = True,
    position: float = _POSITION,
    angle: float = _ANGLE,
    without: Set[int] = frozenset(),
    loose: Mapping[str, Set[int]] | None = None,
) -> Comparison:
    """The differences of two plans. `position` [m], `angle` [rad]: what may differ; speeds and waits may not.

    `without`: lines of `one` that are known to have no counterpart. `loose`: "speed" and "blend", the lines of `one`
    where they are known to differ.
    """
    loose = loose or {}
    first, second = steps_of(one, without), steps_of(other)
    result = _compared(first, second, (position, angle), speeds, blends, loose)
    result.unknown = tuple(dict.fromkeys(d.line for d in one.diagnostics if d.code in VALUE_IS_UNKNOWN))
    if one.unknown < 0 or result.is_equal:
        return result
    known = steps_of(one, without, stop=one.unknown)
    until = _compared(known, second[: len(known)], (position, angle), speeds, blends, loose)
    until.unknown, until.until = result.unknown, result.unknown[0]
    return until


def _compared(
    first: Sequence[Step],
    second: Sequence[Step],
    limits: tuple[float, float],
    speeds: bool,
    blends: bool,
    loose: Mapping[str, Set[int]],
) -> Comparison:
    result = Comparison(min(len(first), len(second)))
    for at, (a, b) in enumerate(zip(first, second, strict=False)):
        where = f"step {at + 1} (line {a.line}, {b.line})"
        if a.kind is not b.kind:
            result.differences.append(f"{where}: {a.kind.name.lower()} and {b.kind.name.lower()}")
            return result
        if a.kind is StepKind.MOVE:
            own_speed = speeds and a.line not in loose.get("speed", frozenset())
            own_blend = blends and a.line not in loose.get("blend", frozenset())
            _compare_moves(a, b, where, result, limits, own_speed, own_blend)
        elif a.kind is StepKind.WAIT:
            off = abs(a.duration - b.duration)
            result.worst_wait = max(result.worst_wait, off)
            if off > 1e-6:
                result.differences.append(f"{where}: waits of {a.duration:g} s and {b.duration:g} s")
    if len(first) != len(second):
        result.differences.append(f"the source runs {len(first)} steps, the translation {len(second)}")
    return result


def _compare_moves(
    a: Step, b: Step, where: str, result: Comparison, limits: tuple[float, float], speeds: bool, blends: bool
) -> None:
    if a.path is not b.path:
        result.differences.append(f"{where}: {a.path} and {b.path}")
    off = _distance(a.position, b.position)
    result.worst_position = max(result.worst_position, off)
    if off > limits[0]:
        result.differences.append(f"{where}: {off / mm:.6f} mm apart")
    turned = _between(a.rotation, b.rotation)
    result.worst_angle = max(result.worst_angle, turned)
    if turned > limits[1]:
        result.differences.append(f"{where}: turned by {turned / deg:.6f} deg")
    if a.path is Path.JOINT and any(map(math.isnan, (*a.position, *b.position))):
        apart = _distance(a.axes, b.axes)
        result.worst_angle = max(result.worst_angle, apart)
        if apart > limits[1] * 3:
            result.differences.append(f"{where}: axes turned by {apart / deg:.6f} deg")
    if speeds:
        _compare_speeds(a, b, where, result)
    if blends:
        _compare_blends(a, b, where, result)


def _compare_speeds(a: Step, b: Step, where: str, result: Comparison) -> None:
    for name, x, y in (("speed", a.travel, b.travel), ("time at speed", a.time, b.time)):
        if math.isnan(x) or math.isnan(y) or max(x, y) <= 0.0:
            continue
        off = abs(x - y) / max(x, y)
        if off > 1e-4 and name != "speed" and abs(x - y) <= _INSTANT:
            continue
        result.worst_speed = max(result.worst_speed, off)
        if off > 1e-4:
            result.differences.append(f"{where}: {name} {x:g} and {y:g}")


def _compare_blends(a: Step, b: Step, where: str, result: Comparison) -> None:
    x, y = (0.0 if s.exact else s.blend for s in (a, b))
    if a.exact is b.exact and (math.isnan(x) or math.isnan(y)):
        return
    off = abs((0.0 if math.isnan(x) else x) - (0.0 if math.isnan(y) else y))
    result.worst_blend = max(result.worst_blend, off)
    if off > 1e-6 or a.exact is not b.exact:
        result.differences.append(f"{where}: blends of {x / mm:g} mm and {y / mm:g} mm")


def _distance(a: tuple[float, ...], b: tuple[float, ...]) -> float:
    pairs = [(x, y) for x, y in zip(a, b, strict=False) if not math.isnan(x) and not math.isnan(y)]
    if a and b and any(math.isnan(v) for v in (*a, *b)) and not pairs:
        return 0.0
    return math.sqrt(sum((x - y) ** 2 for x, y in pairs))


def _between(a: tuple[float, ...], b: tuple[float, ...]) -> float:
    if any(map(math.isnan, (*a, *b))) or not a or not b:
        return 0.0
    x, y = np.array(a), np.array(b)
    chord = min(float(np.linalg.norm(x - y)), float(np.linalg.norm(x + y)))
    return 4.0 * math.asin(min(chord / 2.0, 1.0))


# --- steps ----------------------------------------------------------------------------------------------


def steps_of(
    plan: Plan, without: Set[int] = frozenset(), seconds: Sequence[float] = (), stop: int | None = None
) -> list[Step]:
    """What happens, in order: moves that go nowhere left out, the two halves of an arc put together.

    `without`: lines of the program's own file whose steps are left out. `seconds`: of each step, as it was timed.
    `stop`: how many of the plan's steps are looked at.
    """
    found: list[Step] = []
    waiting = 0.0  # seconds of steps that count with the next one
    moved = False
    for at in range(len(plan) if stop is None else stop):
        kind, line = StepKind(int(plan.kind[at])), int(plan.line[at])
        if without and line in without and plan.source[at] == 0:
            continue
        row = int(plan.row[at])
        took = waiting + (float(seconds[at]) if len(seconds) else 0.0)
        waiting = 0.0
        if kind is not StepKind.MOVE:
            found.append(Step(kind, line, duration=float(plan.durations[row]), seconds=took))
        elif moved and _goes_nowhere(plan, row):
            if found and found[-1].kind is StepKind.MOVE:
                total = found[-1].seconds + took
                found[-1] = found[-1]._replace(**_ending(plan, row), seconds=total)
            else:
                waiting = took
        elif _is_half_arc(plan, at, row):
            waiting = took
        else:
            found.append(_move(plan, row, line)._replace(seconds=took))
        moved = moved or kind is StepKind.MOVE
    return found


def _is_half_arc(plan: Plan, at: int, row: int) -> bool:
    """Whether a circular step is followed at once by the one that ends its arc."""
    if plan.moves.path[row] != PATHS.index(Path.CIRCULAR) or _is_arc_end(plan, at):
        return False
    return at + 1 < len(plan) and plan.kind[at + 1] == StepKind.MOVE


def _is_arc_end(plan: Plan, at: int) -> bool:
    """Whether a circular step ends its arc: it holds its own middle, or is the last of a chain."""
    row = int(plan.row[at])
    via = int(plan.moves.via[row])
    if via < 0:
        return True  # a straight way to the chain's first point
    if not _is_chain(plan, row):
        return True  # one statement with its own middle
    return bool(plan.moves.before[row])


def _is_chain(plan: Plan, row: int) -> bool:
    """Whether the third point is the target or start of a neighbour, as in chains of points."""
    moves, third = plan.moves, int(plan.moves.via[row])
    near = slice(max(0, row - 3), row + 4)
    return bool((moves.target[near] == third).any() or (moves.start[near] == third).any())


def _goes_nowhere(plan: Plan, row: int) -> bool:
    moves, positions = plan.moves, plan.positions
    a, b = int(moves.start[row]), int(moves.target[row])
    if a == b:
        return True
    if not np.isnan(positions.position[[a, b]]).any():
        close = float(np.linalg.norm(positions.position[a] - positions.position[b])) < _STILL
        return close and _between(tuple(positions.quaternion[a]), tuple(positions.quaternion[b])) < _TURN
    difference = positions.axes[a] - positions.axes[b]
    known = difference[~np.isnan(difference)]
    return bool(len(known)) and bool((np.abs(known) < _TURN).all())


def _ending(plan: Plan, row: int) -> dict[str, Any]:
    code, blend = int(plan.moves.blend_code[row]), float(plan.moves.blend[row])
    return {"exact": code == 0, "blend": 0.0 if code == 0 else blend}


def _move(plan: Plan, row: int, line: int) -> Step:
    moves, positions = plan.moves, plan.positions
    target = int(moves.target[row])
    path = PATHS[int(moves.path[row])]
    if path is Path.CIRCULAR and int(moves.via[row]) < 0:
        path = Path.LINEAR
    code = int(moves.blend_code[row])
    # FANUC's CNT is a share of the braking, no length.
    size = math.nan if plan.zone_law == "fanuc" and code == BlendCode.ZONE else float(moves.blend[row])
    return Step(
        StepKind.MOVE,
        line,
        path,
        tuple(positions.position[target].tolist()),
        tuple(positions.quaternion[target].tolist()),
        tuple(positions.axes[target].tolist()),
        float(moves.travel[row]) if path is not Path.JOINT else math.nan,
        float(moves.turn[row]),
        _asked(plan, row) if path is Path.JOINT else float(moves.duration[row]),
        0.0 if code == 0 else size,
        code == 0,
    )


def _asked(plan: Plan, row: int) -> float:
    """[s] that a joint move's programmed speed asks for, no less than its axes need; nan without a robot."""
    moves, robot = plan.moves, plan.robot
    start, target = int(moves.start[row]), int(moves.target[row])
    turned = np.abs(plan.positions.axes[target] - plan.positions.axes[start])
    least = 0.0
    if robot is not None and not np.isnan(turned[: len(robot.axes)]).any():
        least = float((turned[: len(robot.axes)] / robot.speeds).max())
    if not math.isnan(moves.duration[row]):
        return max(float(moves.duration[row]), least)
    if not math.isnan(moves.axis_speed[row]):
        known = turned[~np.isnan(turned)]
        return max(float(known.max() / moves.axis_speed[row]), least) if len(known) else math.nan
    if not math.isnan(moves.travel[row]):
        return max(float(moves.length[row] / moves.travel[row]), least)
    if robot is None or math.isnan(moves.fraction[row]) or np.isnan(turned[: len(robot.axes)]).any():
        return math.nan
    return least / float(moves.fraction[row])
