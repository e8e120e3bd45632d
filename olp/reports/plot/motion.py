"""The picture of one segment: speed, acceleration and the load of every axis over time, its phases shaded."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from olp.core.diagnostic import OlpError, error
from olp.core.units import mm, percent
from olp.reports.explain import Explanation, Phase
from olp.reports.plot.figure import SERIES, Axes, Box, Figure, Polyline, Role, TextLabel, room

_WIDTH, _LEFT, _RIGHT = 940, 78, 122
_SHADES: dict[str, tuple[Role, float]] = {
    "rise": ("blue", 0.13),
    "cruise": ("olive", 0.09),
    "fall": ("orange", 0.14),
    "rest": ("muted", 0.16),
}
_WORDS = {"rise": "speeds up", "cruise": "even speed", "fall": "slows down", "rest": "stands"}
_LONGEST_TITLE = 96
Loads = list[tuple[str, NDArray[np.float64]]]


def motion_figure(told: Explanation) -> Figure:
    """Three panels over the time since the segment began. Raises OlpError E005 if there is no motion to draw."""
    if told.time is None or told.speed is None:
        says = f"there is nothing to draw: no motion is known on line {told.line}"
        raise OlpError(error("E005", says, help="leave -o out for the explanation in words"))
    title = f"line {told.line}: {told.statement}"
    speeds, torques = _speed_loads(told), _torque_loads(told)
    figure = Figure(_WIDTH, 890 if torques else 700, title)
    _head(figure, told, title)
    time = told.time - told.begin
    span, width = (round(float(time[0]), 4), round(float(time[-1]), 4)), _WIDTH - _LEFT - _RIGHT
    speed, programmed = told.speed / mm, told.programmed / mm
    panels = [
        Axes(figure, _LEFT, 128, width, 150, span, room([*speed, programmed])),
        Axes(figure, _LEFT, 318, width, 130, span, room(_usual(_acceleration(told)), 0.15)),
        Axes(figure, _LEFT, 488, width, 150, span, _load_range(speeds)),
        Axes(figure, _LEFT, 678, width, 150, span, _load_range(torques)),
    ][: 4 if torques else 3]
    for panel in panels:
        _shade(panel, told)
    since = f"time since the line began, s   (0 is {told.begin:.3f} s of the program)"
    panels[0].frame("", "mm/s", "speed of the tool", x_numbers=False)
    panels[1].frame("", "mm/s²", "acceleration along the path", x_numbers=False)
    if np.isfinite(programmed):
        panels[0].line(span, (programmed, programmed), "muted", 1.3, (5, 4))
        figure.add(TextLabel(_WIDTH - _RIGHT + 6, panels[0].y(programmed) + 4, "programmed", "muted", 11))
    panels[0].line(time, speed, "blue", 2.2)
    panels[1].line(time, _acceleration(told), "orange", 2.0)
    _load_panel(panels[2], told, speeds, "" if torques else since, ("% of rated", "speed of the axes"))
    if torques:
        words = "% of limit", "torque of the axes, without the tool's mass"
        _load_panel(panels[3], told, torques, since, words)
    return figure


def _head(figure: Figure, told: Explanation, title: str) -> None:
    figure.add(TextLabel(24, 34, _short(title), size=16, bold=True))
    often = f" (the first of {told.executions} times)" if told.executions > 1 else ""
    limited = f", limited by {told.limited_by}" if told.limited_by else ""
    figure.add(TextLabel(24, 56, f"{told.kind}, {told.duration:.3f} s{limited}{often}", "muted", 13))
    _key(figure)


def _acceleration(told: Explanation) -> NDArray[np.float64]:
    """Acceleration (n,) [mm/s²] of the tool along its path; nan outside the line's own time."""
    assert told.time is not None
    assert told.speed is not None
    own = (told.time >= told.begin) & (told.time <= told.begin + told.duration)
    return np.where(own, np.gradient(told.speed, told.time) / mm, np.nan)


def _usual(values: NDArray[np.float64]) -> NDArray[np.float64]:
    """The values between the 1 % and 99 % quantiles, so that one jump of the speed does not flatten the rest."""
    known = values[np.isfinite(values)]
    return np.asarray(np.quantile(known, (0.01, 0.99))) if len(known) else known


def _short(title: str) -> str:
    return title if len(title) <= _LONGEST_TITLE else title[: _LONGEST_TITLE - 1] + "…"


def _key(figure: Figure) -> None:
    """Legend of the shades."""
    x = float(_LEFT)
    for kind, (colour, opacity) in _SHADES.items():
        figure.add(
            Box(x, 76, 16, 12, colour, min(1.0, opacity * 2)),
            TextLabel(x + 22, 86, _WORDS[kind], "muted", 11.5),
        )
        x += 34 + 6.3 * len(_WORDS[kind])
    figure.add(Polyline(((x + 4, 82), (x + 22, 82)), "frame", 1.0, (2, 3)))
    figure.add(TextLabel(x + 28, 86, "the line's time begins and ends", "muted", 11.5))


def _shade(panel: Axes, told: Explanation) -> None:
    for phase in _merged(told.phases):
        colour, opacity = _SHADES[phase[0]]
        panel.band(phase[1] - told.begin, phase[2] - told.begin, colour, opacity)
    for edge in (0.0, told.duration):
        if panel.x_range[0] < edge < panel.x_range[1]:
            x = panel.x(edge)
            panel.figure.add(Polyline(((x, panel.top), (x, panel.top + panel.height)), "frame", 1.0, (2, 3)))


def _merged(phases: tuple[Phase, ...]) -> list[tuple[str, float, float]]:
    """Neighbouring phases of one kind, merged."""
    found: list[tuple[str, float, float]] = []
    for phase in phases:
        if found and found[-1][0] == phase.kind:
            found[-1] = (phase.kind, found[-1][1], phase.end)
        else:
            found.append((phase.kind, phase.begin, phase.end))
    return found


def _load_panel(panel: Axes, told: Explanation, loads: Loads, x_label: str, words: tuple[str, str]) -> None:
    """The shares [%] of one limit over time, with the name and peak of each axis. `words`: y label and title."""
    assert told.time is not None
    panel.frame(x_label, *words, x_numbers=bool(x_label))
    if not loads:
        middle = panel.left + panel.width / 2, panel.top + panel.height / 2
        panel.figure.add(TextLabel(*middle, "the robot's axes are not known", "muted", 13, "middle"))
        return
    if panel.y_range[1] > 100:
        panel.line(panel.x_range, (100.0, 100.0), "red", 1.2, (5, 4))
    ends = []
    for i, (name, share) in enumerate(loads):
        colour = SERIES[i % len(SERIES)]
        panel.line(told.time - told.begin, share, colour, 1.7)
        peak = float(np.nan_to_num(share).max())
        ends.append((panel.y(peak), name, colour, peak))
    _label_right(panel, ends)


def _load_range(loads: Loads) -> tuple[float, float]:
    low, high = room(np.concatenate([share for _, share in loads]) if loads else [100.0])
    # The limit is shown when the axes come near it, not when it would flatten everything else.
    return low, max(high, 108.0) if high > 60 else high


def _speed_loads(told: Explanation) -> Loads:
    return [(axis.name, axis.share / percent) for axis in told.axes]


def _torque_loads(told: Explanation) -> Loads:
    """Torque shares of the axes whose torque and limit are known."""
    shares = [(axis.name, axis.torque_share) for axis in told.axes]
    return [(name, share / percent) for name, share in shares if share is not None]


def _label_right(panel: Axes, ends: list[tuple[float, str, Role, float]]) -> None:
    """Names and peaks on the right, in order of the peaks, without overlap."""
    x = panel.left + panel.width + 10
    ends = sorted(ends)
    places = [max(y, panel.top + 6) for y, *_ in ends]
    step = 16.0
    for i, j in pairwise(range(len(places))):
        places[j] = max(places[j], places[i] + step)
    overflow = places[-1] - (panel.top + panel.height + 4)
    for i in range(len(places) - 1, -1, -1):
        if overflow > 0:
            limit = panel.top + panel.height + 4 - step * (len(places) - 1 - i)
            places[i] = min(places[i], limit)
    for y, (_, name, colour, peak) in zip(places, ends, strict=True):
        panel.figure.add(Polyline(((x, y), (x + 14, y)), colour, 2.4))
        panel.figure.add(TextLabel(x + 19, y + 4, f"{name} {peak:.{1 if peak < 10 else 0}f} %", "ink", 11.5))
