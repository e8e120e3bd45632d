"""What the page draws of one program: segments, the path, the speed over time, the text. Plain numbers, few digits."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from olp.core.units import deg, mm
from olp.ir.program import Path
from olp.reports.webpage import printable
from olp.robots.model import Vector
from olp.runtime.plan import PATHS, StepKind
from olp.timing.timing import Timing
from olp.timing.track import states, tool_position, tool_speed

Floats = NDArray[np.float64]
_ON_CURVE = 9  # points along an arc or spline
_ON_LINE = 4  # at most, along any other move: between them the page moves evenly
_CURVES = [PATHS.index(p) for p in (Path.CIRCULAR, Path.SPLINE)]


@dataclass(frozen=True, slots=True)
class PageShare:
    """How much of one program a page holds: a page of a megabyte opens at once, whatever the program.

    `segments`: the first ones. `samples`: instants of the speed profile. `points`: of the path in space. `poses`: of
    the arm. `lines`: of text, all files together; beyond, only lines that take time.
    """

    segments: int = 40_000
    samples: int = 4000
    points: int = 40_000
    poses: int = 2000
    lines: int = 12_000


def shares(segments: Sequence[int]) -> list[PageShare]:
    """The shares of programs with so many segments in one page: what the short ones leave goes to the long ones."""
    whole, count = PageShare(), max(len(segments), 1)
    found = [0] * len(segments)
    left = whole.segments
    for place, index in enumerate(sorted(range(len(segments)), key=lambda i: segments[i])):
        found[index] = min(segments[index], left // (count - place))
        left -= found[index]
    samples, points, poses, lines = (
        min(max(size // count, least), most)
        for size, least, most in (
            (40_000, 200, whole.samples),
            (40_000, 300, whole.points),
            (12_000, 100, whole.poses),
            (20_000, 100, whole.lines),
        )
    )
    return [PageShare(n, samples, points, poses, lines) for n in found]


def program_data(timing: Timing, share: PageShare | None = None) -> dict[str, Any]:
    """Everything of one program that fits into its share, ready for JSON; templates/report.js draws it.

    `of`: its segments in all. One entry per segment: `line`, `file` (number in `files`), `kind` (in `kinds`), `rule`
    (in `rules`), `seconds`, `mm`, `speed` [mm/s] and `percent` as programmed, `reached` [mm/s], `accel` [mm/s²], `low`
    and `high` [s]; None where unknown. `profile`, `path`, `arm`: samples of the motion as `olp track` has it; or None.
    """
    share = share or PageShare()
    plan, first = timing.plan, slice(0, share.segments)
    limited, of_kind = timing.limited_by[first], timing.kind[first]
    rules, kinds = sorted(set(limited)), sorted(set(of_kind))
    return {
        "of": len(plan),
        "line": plan.line[first].tolist(),
        "file": plan.source[first].tolist(),
        "kinds": kinds,
        "kind": [kinds.index(kind) for kind in of_kind],
        "rules": rules,
        "rule": [rules.index(rule) for rule in limited],
        "seconds": _short(timing.duration_s[first], 6),
        "mm": _short(timing.distance_mm[first], 3),
        "speed": _short(timing.speed_mm_s[first], 2),
        "percent": _short(timing.speed_pct[first], 2),
        "reached": _short(timing.reached_mm_s[first], 2),
        "accel": _short(timing.accel_mm_s2[first], 1),
        "low": None if timing.interval is None else _short(timing.interval.low[first], 6),
        "high": None if timing.interval is None else _short(timing.interval.high[first], 6),
        "profile": _profile(timing, share),
        "path": (path := _path(timing, share)),
        "arm": _arm(timing, share, path),
        "files": _files(timing, share),
    }


def _short(values: Floats, digits: int) -> list[float | None]:
    return [None if math.isnan(v) else round(v, digits) for v in values.tolist()]


def _profile(timing: Timing, share: PageShare) -> dict[str, Any] | None:
    """The tool's speed [mm/s] at even instants; None where no move can be followed."""
    total = float(timing.end_s[: share.segments][-1]) if share.segments and len(timing.plan) else 0.0
    if total <= 0 or not (timing.plan.kind == StepKind.MOVE).any() or timing.untimed:
        return None
    count = int(min(share.samples, max(200, 12 * len(timing.plan))))
    times = np.linspace(0.0, total, count)
    speed = tool_speed(timing, times) / mm
    if np.isnan(speed).all():
        return None
    return {"end": round(total, 6), "speed": [None if math.isnan(v) else round(v) for v in speed.tolist()]}


def _path(timing: Timing, share: PageShare) -> dict[str, Any] | None:
    """Polylines in space [mm]: points, the instant `t` [s] of each, and the step that leads to it."""
    plan = timing.plan
    moves = np.flatnonzero(plan.kind[: share.segments] == StepKind.MOVE)
    if not len(moves) or timing.untimed:
        return _corner_points(timing, share)
    ends, duration = timing.end_s[moves], np.nan_to_num(timing.duration_s[moves])
    curved = np.isin(plan.moves.path[plan.row[moves]], _CURVES)
    on_line = min(_ON_LINE, max(1, share.points // len(moves)))
    count = np.where(duration > 0, np.where(curved, _ON_CURVE, on_line), 1)
    of = np.repeat(np.arange(len(moves)), count)
    nth = np.arange(len(of)) - np.repeat(np.cumsum(count) - count, count) + 1
    rested = np.flatnonzero(
        np.diff(moves, prepend=-2) != 1
    )  # moves that begin after something else than a move
    times = np.concatenate((ends[of] - duration[of] * (1.0 - nth / count[of]), (ends - duration)[rested]))
    order = np.argsort(times, kind="stable")[:: -(-len(times) // share.points)]
    times, steps = times[order], moves[np.concatenate((of, rested))[order]]
    return _polyline(tool_position(timing, times) / mm, steps.tolist(), times)


def _corner_points(timing: Timing, share: PageShare) -> dict[str, Any] | None:
    """The targets alone, where the times are not all known."""
    plan = timing.plan
    steps = np.flatnonzero(plan.kind[: share.segments] == StepKind.MOVE)
    targets = plan.moves.target[plan.row[steps]]
    return _polyline(plan.positions.position[targets] / mm, steps.tolist()) if len(steps) else None


def _polyline(position: Floats, steps: Sequence[int], times: Floats | None = None) -> dict[str, Any] | None:
    known = [all(map(math.isfinite, place)) for place in position.tolist()]
    if sum(known) < 2:
        return None
    place = np.round(position[known], 1)
    return {
        "t": None if times is None else _short(times[known], 4),
        "x": place[:, 0].tolist(),
        "y": place[:, 1].tolist(),
        "z": place[:, 2].tolist(),
        "step": [step for step, ok in zip(steps, known, strict=True) if ok],
    }


def _arm(timing: Timing, share: PageShare, path: dict[str, Any] | None) -> dict[str, Any] | None:
    """The arm: its chain [mm], and `axes` [deg, of a slide mm] at some of the path's instants `t` [s].

    `floor`: the height of the floor in the base frame [mm]; None where nobody says. None without geometry or angles.
    """
    robot = timing.plan.robot
    if robot is None or robot.geometry is None or path is None or path["t"] is None:
        return None
    times = np.array(path["t"])
    times = times[:: -(-len(times) // share.poses)]
    axes = states(timing, times)[2][:, : len(robot.axes)]
    if np.isnan(axes).any(axis=1).all():
        return None
    linear, geometry = [axis.linear for axis in robot.axes], robot.geometry
    units = np.where(linear, mm, deg)
    return {
        "names": list(robot.axis_names),
        "linear": linear,
        "t": times.tolist(),
        "axes": [_short(column, 2) for column in (axes / units).T],
        "joints": [
            {"axis": j.axis, "direction": j.direction, "offset": _in_mm(j.offset)} for j in geometry.joints
        ],
        "flange": _in_mm(geometry.flange_offset),
        "floor": None if geometry.base_height is None else round(-geometry.base_height / mm, 2),
    }


def _in_mm(offset: Vector) -> list[float]:
    return [round(v / mm, 3) for v in offset]


def _files(timing: Timing, share: PageShare) -> list[dict[str, Any]]:
    """The text of each file that ran; of very long ones only the lines that take time, with their numbers."""
    plan = timing.plan
    left = share.lines
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
