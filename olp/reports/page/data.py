"""What the page draws of one program: segments, the path, the speed over time, the text. Plain numbers, few digits."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from olp.core.units import mm
from olp.ir.program import Path
from olp.reports.webpage import printable
from olp.runtime.plan import PATHS, StepKind
from olp.timing.timing import Timing
from olp.timing.track import tool_position, tool_speed

Floats = NDArray[np.float64]
_MOST_SAMPLES = 4000  # instants of the speed profile: more than a screen has columns
_MOST_POINTS = 30_000  # of the path in space
_ON_CURVE = 9  # points along an arc or spline
_MOST_LINES = 12_000  # of program text, all files together; beyond, only lines that take time
_CURVES = [PATHS.index(p) for p in (Path.CIRCULAR, Path.SPLINE)]


def program_data(timing: Timing) -> dict[str, Any]:
    """Everything of one program, ready for JSON."""
    plan = timing.plan
    rules = sorted(set(timing.limited_by))
    kinds = sorted(set(timing.kind))
    return {
        "line": plan.line.tolist(),
        "file": plan.source.tolist(),
        "kinds": kinds,
        "kind": [kinds.index(kind) for kind in timing.kind],
        "rules": rules,
        "rule": [rules.index(rule) for rule in timing.limited_by],
        "seconds": _short(timing.duration_s, 6),
        "mm": _short(timing.distance_mm, 3),
        "speed": _short(timing.speed_mm_s, 2),
        "percent": _short(timing.speed_pct, 2),
        "reached": _short(timing.reached_mm_s, 2),
        "accel": _short(timing.accel_mm_s2, 1),
        "low": None if timing.interval is None else _short(timing.interval.low, 6),
        "high": None if timing.interval is None else _short(timing.interval.high, 6),
        "profile": _profile(timing),
        "path": _path(timing),
        "files": _files(timing),
    }


def _short(values: Floats, digits: int) -> list[float | None]:
    return [None if math.isnan(v) else round(v, digits) for v in values.tolist()]


def _profile(timing: Timing) -> dict[str, Any] | None:
    """The tool's speed [mm/s] at even instants; None where no move can be followed."""
    total = timing.total_s
    if total <= 0 or not (timing.plan.kind == StepKind.MOVE).any() or timing.untimed:
        return None
    count = int(min(_MOST_SAMPLES, max(200, 12 * len(timing.plan))))
    times = np.linspace(0.0, total, count)
    speed = tool_speed(timing, times) / mm
    if np.isnan(speed).all():
        return None
    return {"end": round(total, 6), "speed": [None if math.isnan(v) else round(v) for v in speed.tolist()]}


def _path(timing: Timing) -> dict[str, Any] | None:
    """Polylines in space [mm]: points, and of each point the step that leads to it."""
    plan = timing.plan
    ends = timing.end_s
    moves = np.flatnonzero(plan.kind == StepKind.MOVE)
    if not len(moves) or timing.untimed:
        return _corner_points(timing)
    duration = np.nan_to_num(timing.duration_s[moves])
    curved = np.isin(plan.moves.path[plan.row[moves]], _CURVES) & (duration > 0)
    count = np.where(curved, _ON_CURVE, 1)
    of = np.repeat(np.arange(len(moves)), count)
    nth = np.arange(len(of)) - np.repeat(np.cumsum(count) - count, count) + 1
    times = ends[moves][of] - duration[of] * (1.0 - nth / count[of])
    keep = slice(None, None, 1 + len(times) // _MOST_POINTS)
    chosen = times[keep]
    order = np.argsort(chosen, kind="stable")
    position = np.full((len(chosen), 3), np.nan)
    position[order] = tool_position(timing, np.maximum.accumulate(chosen[order])) / mm
    return _polyline(position, moves[of][keep].tolist())


def _corner_points(timing: Timing) -> dict[str, Any] | None:
    """The targets alone, where the times are not all known."""
    plan = timing.plan
    steps = np.flatnonzero(plan.kind == StepKind.MOVE)
    targets = plan.moves.target[plan.row[steps]]
    return _polyline(plan.positions.position[targets] / mm, steps.tolist()) if len(steps) else None


def _polyline(position: Floats, steps: Sequence[int]) -> dict[str, Any] | None:
    known = [all(map(math.isfinite, place)) for place in position.tolist()]
    if sum(known) < 2:
        return None
    place = np.round(position[known], 2)
    return {
        "x": place[:, 0].tolist(),
        "y": place[:, 1].tolist(),
        "z": place[:, 2].tolist(),
        "step": [step for step, ok in zip(steps, known, strict=True) if ok],
    }


def _files(timing: Timing) -> list[dict[str, Any]]:
    """The text of each file that ran; of very long ones only the lines that take time, with their numbers."""
    plan = timing.plan
    left = _MOST_LINES
    files = []
    for index, source in enumerate(plan.sources):
        if index and not (plan.source == index).any():
            continue
        lines = source.lines
        numbers = list(range(1, len(lines) + 1))
        if len(lines) > left:
            numbers = sorted(set(plan.line[plan.source == index].tolist()))[:left]
        left = max(0, left - len(numbers))
        files.append(
            {
                "index": index,
                "name": source.path.replace("\\", "/").rpartition("/")[2],
                "lines": [printable(lines[n - 1].rstrip())[:200] for n in numbers],
                "numbers": numbers if len(numbers) != len(lines) else None,
            }
        )
    return files
