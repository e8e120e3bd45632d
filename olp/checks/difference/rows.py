"""A timed program line by line: what each line does, how often it ran, and how long that took."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from olp.ir.expressions import Taught
from olp.ir.points import PointKind, PointState
from olp.ir.program import Move, Program
from olp.runtime.plan import BlendCode, Plan, StepKind
from olp.runtime.spelling import spell
from olp.timing.timing import Timing

Floats = NDArray[np.float64]
_COMMENT = re.compile(r"\s*(//|;;|![^=]|#\s).*$")
_BLANKS = re.compile(r"\s+")


@dataclass(slots=True)
class ComparedLine:
    """One line. `seconds`: over all `count` executions. Positions [m] and angles are those of its first execution.

    `standing`: the tool and the frame that the target is taught with, as far as the program says.
    `text`: without blanks at the ends and without its comment. `speed`: (unit, value in SI). `signature`: what the
    line says, for finding it again when it stands elsewhere.
    """

    routine: str
    line: int
    text: str
    kind: str
    count: int
    seconds: float
    start: Floats
    target: Floats
    turn: Floats
    via: Floats
    axes: Floats
    speed: tuple[str, float]
    acceleration: tuple[float, float, float]
    blend: tuple[int, float]
    standing: tuple[str, str]
    file: str = ""

    @property
    def signature(self) -> tuple[object, ...]:
        """Two lines that do the same have the same."""
        if self.kind in ("wait", "signal"):
            return (self.routine, self.kind, self.text, round(self.seconds / self.count, 6))
        place = tuple(np.round(self.target, 5).tolist()) if not np.isnan(self.target).any() else self.text
        return (self.routine, self.kind, place, self.speed, self.blend)


def rows_of(timing: Timing, program: Program) -> list[ComparedLine]:
    """Every executed line once, routine by routine in order of first execution, lines in order of writing."""
    plan = timing.plan
    names = [_stem(source.path) for source in plan.sources]
    found: dict[tuple[int, int], ComparedLine] = {}
    seconds = np.nan_to_num(timing.duration_s).tolist()
    lines, sources, kinds = plan.line.tolist(), plan.source.tolist(), plan.kind.tolist()
    starts, standing = _line_starts(program), standing_of(program)
    for step in range(len(plan)):
        key = sources[step], lines[step]
        row = found.get(key)
        if row is None:
            routine = _routine(starts, lines[step]) if sources[step] == 0 else names[sources[step]]
            found[key] = _row(timing, step, kinds[step], routine or names[sources[step]], seconds[step])
            if sources[step] == 0:
                found[key].standing = standing.get(lines[step], ("", ""))
            found[key].file = plan.sources[sources[step]].path.replace("\\", "/").rpartition("/")[2]
        else:
            row.count += 1
            row.seconds += seconds[step]
    order: dict[str, int] = {}
    for row in found.values():
        order.setdefault(row.routine, len(order))
    return sorted(found.values(), key=lambda row: (order[row.routine], row.line))


def _line_starts(program: Program) -> list[tuple[int, str]]:
    return sorted((routine.line, routine.name) for routine in program.routines)


def standing_of(program: Program) -> dict[int, tuple[str, str]]:
    """Line -> tool and frame of the move there."""
    found = {}
    for routine in program.routines:
        for s in routine.body:
            if not isinstance(s, Move) or not s.targets:
                continue
            target = s.targets[0]
            point = (
                routine.points.find(target.store, True, target.number) if isinstance(target, Taught) else None
            )
            tool = "" if point is None else str(point.state.tool)
            frame = "" if point is None else _frame(point.state)
            found[s.line] = (
                tool if s.tool is None else spell(s.tool),
                frame if s.frame is None else spell(s.frame),
            )
    return found


def _frame(state: PointState) -> str:
    """Empty for joint values: they stand in none."""
    if state.kind is not PointKind.POSE:
        return ""
    return state.frame if state.user is None else f"{state.frame} {state.user}"


def _routine(starts: list[tuple[int, str]], line: int) -> str:
    return next((name for start, name in reversed(starts) if start <= line), "")


def _stem(path: str) -> str:
    name = path.replace("\\", "/").rpartition("/")[2]
    return name.rpartition(".")[0] or name


_NONE = np.full(3, np.nan)


def _row(timing: Timing, step: int, kind: int, routine: str, seconds: float) -> ComparedLine:
    plan = timing.plan
    text = _BLANKS.sub(" ", _COMMENT.sub("", plan.statement(step))).strip()
    line, told = int(plan.line[step]), timing.kind[step]
    if kind != StepKind.MOVE:
        none = (math.nan,) * 3
        return ComparedLine(
            routine, line, text, told, 1, seconds, _NONE, _NONE, np.full(4, np.nan), _NONE, np.full(6, np.nan),
            ("", 0.0), none, (0, 0.0), ("", ""),
        )  # fmt: skip
    return _move(timing, plan, step, routine, line, text, told, seconds)


def _move(
    timing: Timing, plan: Plan, step: int, routine: str, line: int, text: str, told: str, seconds: float
) -> ComparedLine:
    moves, places = plan.moves, plan.positions
    row = int(plan.row[step])
    target = int(moves.target[row])
    via = int(moves.via[row])
    return ComparedLine(
        routine,
        line,
        text,
        told,
        1,
        seconds,
        places.position[int(moves.start[row])],
        places.position[target],
        places.quaternion[target],
        places.position[via] if via >= 0 else _NONE,
        places.axes[target],
        next(_speeds(plan, row), ("", 0.0)),
        (float(moves.acceleration[row]), float(moves.deceleration[row]), float(moves.rate[row])),
        _blend(plan, row),
        ("", ""),
    )


def _speeds(plan: Plan, row: int) -> Iterator[tuple[str, float]]:
    moves = plan.moves
    for name in ("fraction", "travel", "turn", "axis_speed", "duration"):
        value = float(getattr(moves, name)[row])
        if not math.isnan(value):
            yield name, value


def _blend(plan: Plan, row: int) -> tuple[int, float]:
    code, size = int(plan.moves.blend_code[row]), float(plan.moves.blend[row])
    return code, 0.0 if math.isnan(size) or code == BlendCode.EXACT else round(size, 9)
