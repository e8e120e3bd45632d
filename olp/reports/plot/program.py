"""The picture of a program: the tool's path from above, from the side and in space, and its speed over time."""

from __future__ import annotations

import math
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from olp.core.diagnostic import OlpError, error
from olp.core.source import file_name
from olp.core.units import deg, mm
from olp.ir.program import Path
from olp.reports.plot.figure import Axes, Box, Dot, Figure, Polyline, Role, TextLabel, room
from olp.runtime.plan import PATHS, StepKind

if TYPE_CHECKING:
    from olp.timing.result import Timing

Floats = NDArray[np.float64]
_WIDTH, _HEIGHT = 1080, 760
_SAMPLES = 6_000  # instants of the whole program, spread evenly, besides the ends of all moves
_MOST_LABELS = 14
_COLOURS: dict[Path, Role] = {
    Path.JOINT: "muted",
    Path.LINEAR: "blue",
    Path.CIRCULAR: "orange",
    Path.SPLINE: "purple",
}
_DASHES: dict[Path, tuple[float, ...]] = {path: (5.0, 3.5) if path is Path.JOINT else () for path in Path}
_TURN, _TILT = 35.0 * deg, 28.0 * deg  # from where the view in space looks
_LONGEST_NAME = 90


def program_figure(timing: Timing) -> Figure:
    """The path in three views above its speed over time. Raises OlpError where the program cannot be tracked."""
    from olp.timing.track import tool_speed, track

    plan = timing.plan
    # Refuses what cannot be drawn, with the reasons.
    track(timing, max(timing.total_s, 1.0))
    is_move = plan.kind == StepKind.MOVE
    ends = timing.end_s[is_move]
    times = np.unique(np.concatenate((np.linspace(0.0, timing.total_s, _SAMPLES), ends)))
    position = _positions(timing, times)
    if not np.isfinite(position).all(axis=1).any():
        says = "there is nothing to draw: where the tool is, is nowhere known (a station, or no robot named)"
        raise OlpError(error("E005", says, file=plan.path, help="--robot R names an arm"))
    figure = Figure(_WIDTH, _HEIGHT, f"path and speed of {plan.path}")
    _head(figure, timing)
    kinds = plan.moves.path[plan.row[is_move]][np.minimum(np.searchsorted(ends, times), len(ends) - 1)]
    marks = position[np.searchsorted(times, ends)], plan.line[is_move]
    views = (
        ("from above", "x, mm", "y, mm", position[:, [0, 1]], marks[0][:, [0, 1]], 70.0),
        ("from the side", "x, mm", "z, mm", position[:, [0, 2]], marks[0][:, [0, 2]], 415.0),
        ("in space", "", "", _in_space(position), _in_space(marks[0]), 745.0),
    )
    for title, across, up, path, points, left in views:
        _view(figure, (title, across, up), path, kinds, points, marks[1], left)
    _speeds(figure, timing, times, tool_speed(timing, times) / mm, kinds)
    return figure


def _positions(timing: Timing, times: Floats) -> Floats:
    from olp.timing.track import states

    return np.asarray(states(timing, times)[0] / mm)


def _in_space(points: Floats) -> Floats:
    """Parallel projection (n, 2), seen from the front right and above."""
    x, y, z = points.T
    across = y * math.cos(_TURN) - x * math.sin(_TURN)
    away = x * math.cos(_TURN) + y * math.sin(_TURN)
    return np.stack((-across, z * math.cos(_TILT) - away * math.sin(_TILT)), axis=1)


def _head(figure: Figure, timing: Timing) -> None:
    name = file_name(timing.plan.path) or "program"
    figure.add(TextLabel(24, 34, name[:_LONGEST_NAME], size=16, bold=True))
    robot = timing.robot or "robot not known"
    says = (
        f"{robot}, {timing.total_s:.3f} s: motion {timing.motion_s:.3f} s, waits {timing.wait_s:.3f} s, "
        f"I/O {timing.io_s:.3f} s"
    )
    figure.add(TextLabel(24, 56, says, "muted", 13))
    x = 70.0
    used = np.unique(timing.plan.moves.path)
    for path, colour in _COLOURS.items():
        if PATHS.index(path) in used:
            figure.add(
                Polyline(((x, 78), (x + 18, 78)), colour, 2.4, _DASHES[path]),
                TextLabel(x + 24, 82, f"{path} moves", "muted", 11.5),
            )
            x += 44 + 6.3 * len(f"{path} moves")
    figure.add(Dot(x + 6, 78, 4.5, "green", hollow=True), TextLabel(x + 16, 82, "start", "muted", 11.5))
    figure.add(Dot(x + 62, 78, 4.5, "red"), TextLabel(x + 72, 82, "end", "muted", 11.5))
    figure.add(TextLabel(x + 112, 82, "numbers are lines of the jobs", "muted", 11.5))


def _view(
    figure: Figure,
    words: tuple[str, str, str],
    path: Floats,
    kinds: NDArray[np.int8],
    points: Floats,
    lines: NDArray[np.int32],
    left: float,
) -> None:
    title, across, up = words
    panel = Axes(figure, left, 126, 270, 270, *_equal(path))
    if across:
        panel.frame(across, up, title)
    else:
        figure.add(TextLabel(left, 117, title, "ink", 12.5, bold=True))
        figure.add(Box(left, 126, 270, 270, "muted", 0.06))
        _cross(panel)
    _path(panel, path, kinds)
    first, last = path[0], path[-1]
    figure.add(Dot(panel.x(first[0]), panel.y(first[1]), 4.5, "green", hollow=True))
    figure.add(Dot(panel.x(last[0]), panel.y(last[1]), 4.5, "red"))
    _numbers(panel, points, lines)


def _equal(path: Floats) -> tuple[tuple[float, float], tuple[float, float]]:
    """Ranges with equal scale for both axes of a square panel."""
    known = path[np.isfinite(path).all(axis=1)]
    low, high = known.min(axis=0), known.max(axis=0)
    middle, half = (low + high) / 2, max(float((high - low).max()) * 0.58, 1.0)
    return (middle[0] - half, middle[0] + half), (middle[1] - half, middle[1] + half)


def _path(panel: Axes, path: Floats, kinds: NDArray[np.int8]) -> None:
    """One line per stretch of moves of one kind."""
    edges = [0, *(np.flatnonzero(np.diff(kinds)) + 1).tolist(), len(kinds)]
    for begin, end in pairwise(edges):
        part = path[max(begin - 1, 0) : end]
        kind = PATHS[int(kinds[begin])]
        panel.line(part[:, 0], part[:, 1], _COLOURS[kind], 1.7, _DASHES[kind])


def _numbers(panel: Axes, points: Floats, lines: NDArray[np.int32]) -> None:
    """Line numbers of the program beside their points, evenly chosen, without overlap."""
    chosen = np.unique(np.linspace(0, len(lines) - 1, min(len(lines), _MOST_LABELS)).round().astype(int))
    taken: list[tuple[float, float]] = []
    for index in chosen.tolist():
        x, y = panel.x(points[index, 0]) + 6, panel.y(points[index, 1]) - 5
        if not (math.isfinite(x) and math.isfinite(y)):
            continue
        if all(abs(x - a) > 24 or abs(y - b) > 12 for a, b in taken):
            taken.append((x, y))
            panel.figure.add(Dot(x - 6, y + 5, 2.2, "ink"), TextLabel(x, y, str(lines[index]), "ink", 10.5))


def _cross(panel: Axes) -> None:
    """The base frame's directions, in the corner of the panel."""
    x0, y0, length = panel.left + 36, panel.top + panel.height - 34, 24.0
    for axis, name in enumerate("xyz"):
        unit = np.zeros((1, 3))
        unit[0, axis] = 1.0
        right, up = _in_space(unit)[0]
        end = x0 + right * length, y0 - up * length
        panel.figure.add(Polyline(((x0, y0), end), "frame", 1.5))
        panel.figure.add(TextLabel(end[0] + right * 7, end[1] - up * 7 + 4, name, "muted", 11, "middle"))


def _speeds(figure: Figure, timing: Timing, times: Floats, speed: Floats, kinds: NDArray[np.int8]) -> None:
    span = (0.0, max(timing.total_s, 1e-3))
    panel = Axes(figure, 70, 486, _WIDTH - 70 - 40, 210, span, room(speed))
    plan = timing.plan
    for step in np.flatnonzero((plan.kind != StepKind.MOVE) & (timing.duration_s > 0)).tolist():
        end = float(timing.end_s[step])
        panel.band(end - float(timing.duration_s[step]), end, "muted", 0.18)
    panel.frame("time, s", "mm/s", "speed of the tool (grey: waits and I/O)")
    edges = [0, *(np.flatnonzero(np.diff(kinds)) + 1).tolist(), len(kinds)]
    for begin, end in pairwise(edges):
        part = slice(max(begin - 1, 0), end)
        panel.line(times[part], speed[part], _COLOURS[PATHS[int(kinds[begin])]], 1.6)
