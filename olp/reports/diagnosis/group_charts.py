"""The residuals over running time, by direction, and by groups of moves (start point, speed, job …)."""

from __future__ import annotations

import math
import re
from typing import NamedTuple

import numpy as np
from markupsafe import Markup
from numpy.typing import NDArray

from olp.identification.diagnosis import phrasing
from olp.reports.diagnosis.rows import MoveRows
from olp.reports.diagnosis.svg import Chart, around, n, svg

Floats = NDArray[np.float64]
MS = 1000.0
_SECTORS = 24
_STEEP = math.sin(math.radians(60.0))  # a move that rises more has no bearing worth telling
_MOST = 12  # groups in one chart


class Strip(NamedTuple):
    """One way to part the moves, drawn."""

    caption: str
    chart: Markup


def over_time(rows: MoveRows, noise: float) -> Markup:
    """In order of execution, over the recorder's clock where it was written."""
    clock = bool(np.isfinite(rows.time).all()) and len(rows) > 0
    x = rows.time - rows.time.min() if clock else np.arange(1.0, len(rows) + 1)
    y = _shown(rows)
    if not len(rows) or not np.isfinite(y).any():
        return Markup("")
    chart = Chart(
        (0.0, float(x.max()) * 1.02 or 1.0), around(y, [-2 * noise * MS, 2 * noise * MS]), (760, 280)
    )
    chart.axes("running time [s]" if clock else "moves in order of execution", "robot less simulation [ms]")
    chart.band(-2 * noise * MS, 2 * noise * MS)
    _both(chart, rows, x, np.arange(len(rows)))
    return chart.svg("Difference between robot and simulation over running time")


def _shown(rows: MoveRows) -> Floats:
    """[ms] all values that the charts have to hold."""
    return np.concatenate([rows.before, rows.after]) * MS


def _both(chart: Chart, rows: MoveRows, x: Floats, index: NDArray[np.int64]) -> None:
    chart.dots(x, rows.before[index] * MS, "before", index.tolist())
    if rows.causes:
        chart.dots(x, rows.after[index] * MS, "after", index.tolist())


def by_direction(rows: MoveRows, noise: float) -> Markup:
    """Mean residual by the direction of travel, seen from above; steep moves are left to `steep`."""
    on = rows.on_path
    way = np.where(on[:, None], rows.end - rows.start, np.nan)
    level = on & (np.abs(way[:, 2]) < _STEEP * np.linalg.norm(way, axis=1))
    if level.sum() < 3:
        return Markup("")
    sector = np.round(np.arctan2(way[:, 1], way[:, 0]) / (2 * np.pi / _SECTORS))
    sector = np.where(level, np.mod(np.nan_to_num(sector), _SECTORS), -1).astype(np.int64)
    means = {
        when: np.array([_mean(values[sector == s]) for s in range(_SECTORS)]) * MS
        for when, values in (("before", rows.before), ("after", rows.after))
    }
    return _polar(means if rows.causes else {"before": means["before"]}, noise * MS)


def _mean(values: Floats) -> float:
    known = values[np.isfinite(values)]
    return float(known.mean()) if len(known) else math.nan


def _polar(means: dict[str, Floats], noise: float) -> Markup:
    """Zero is the dashed circle: outside the robot is slower, inside faster."""
    size, zero, reach = 360.0, 88.0, 58.0  # [px]
    largest = float(np.nanmax(np.abs(np.concatenate(list(means.values()))))) or 1.0
    largest = max(largest, 2 * noise if math.isfinite(noise) else 0.0)
    centre = size / 2
    parts = [_ring(centre, zero + reach * share, "grid") for share in (-1.0, 1.0)]
    if math.isfinite(noise):
        band = min(2 * noise / largest, 1.0) * reach
        parts.append(
            f'<circle class="noise ring" cx="{n(centre)}" cy="{n(centre)}" r="{n(zero)}" '
            f'stroke-width="{n(2 * band)}"/>'
        )
    parts.append(_ring(centre, zero, "grid zero"))
    for when, values in means.items():
        for s in np.flatnonzero(np.isfinite(values)).tolist():
            angle, radius = 2 * np.pi * s / _SECTORS, zero + reach * values[s] / largest
            # X is drawn upwards, Y to the left: as one sees a robot from behind.
            dx, dy = -math.sin(angle), -math.cos(angle)
            a, b = (f"{n(centre + r * dx)} {n(centre + r * dy)}" for r in (zero, radius))
            parts.append(f'<path class="spoke {when}" d="M{a}L{b}"/><path class="dots {when}" d="M{b}h.1"/>')
    for label, dx, dy in (("+X", 0, -1), ("−X", 0, 1), ("+Y", -1, 0), ("−Y", 1, 0)):
        x, y = centre + dx * 162, centre + dy * 162 + 4
        parts.append(f'<text x="{n(x)}" y="{n(y)}" text-anchor="middle">{label}</text>')
    ring = phrasing.seconds(largest / MS)
    parts.append(f'<text x="{n(size - 4)}" y="{n(size - 6)}" text-anchor="end">outer ring +{ring}</text>')
    told = "Outside the dashed circle the robot is slower than simulated, inside faster"
    return svg(parts, size, size, "Mean difference by direction of travel, from above", told)


def _ring(centre: float, radius: float, css: str) -> str:
    return f'<circle class="{css}" cx="{n(centre)}" cy="{n(centre)}" r="{n(radius)}"/>'


def steep(rows: MoveRows) -> list[tuple[str, int, float, float]]:
    """Up, level and down: how many moves, and the mean residual before and after [s]."""
    on = rows.on_path
    way = np.where(on[:, None], rows.end - rows.start, np.nan)
    with np.errstate(invalid="ignore", divide="ignore"):
        rise = way[:, 2] / np.linalg.norm(way, axis=1)
    third = math.sin(math.radians(5.0))
    parts = {"up": rise > third, "level (within 5°)": np.abs(rise) <= third, "down": rise < -third}
    return [
        (name, int(chosen.sum()), _mean(rows.before[chosen]), _mean(rows.after[chosen]))
        for name, chosen in parts.items()
        if chosen.any()
    ]


def strips(rows: MoveRows, groups: dict[str, list[str]], noise: float) -> list[Strip]:
    """A row of dots per group, for every way to part the moves."""
    return [_strip(rows, name, labels, noise) for name, labels in groups.items()]


def _strip(rows: MoveRows, name: str, labels: list[str], noise: float) -> Strip:
    found = list(dict.fromkeys(label for label in labels if label))
    found.sort(key=labels.count, reverse=True)
    shown = sorted(found[:_MOST], key=_order)
    column = np.array(labels, dtype=object)
    height = 30.0 * len(shown)
    chart = Chart(
        around(_shown(rows), [-2 * noise * MS, 2 * noise * MS]),
        (0.0, float(len(shown))),
        (480, height + 58),
        150,
    )
    chart.axes("robot less simulation [ms]", "", y_ticks=False)
    chart.band(-2 * noise * MS, 2 * noise * MS, upright=True)
    for i, label in enumerate(shown):
        index = np.flatnonzero(column == label)
        middle = len(shown) - i - 0.5
        y = float(chart.y(middle))
        chart.text(chart.left - 8, y + 4, label if len(label) <= 20 else label[:19] + "…", "end", "label")
        looks = [("before", rows.before, 0.18), *([("after", rows.after, -0.18)] if rows.causes else [])]
        for when, values, shift in looks:
            shift = shift if rows.causes else 0.0
            level = np.full(len(index), middle + shift)
            chart.dots(values[index] * MS, level, when, index.tolist())
            mean = _mean(values[index]) * MS
            if math.isfinite(mean):
                x, at = n(chart.x(mean)), float(chart.y(middle + shift))
                chart.parts.append(f'<path class="mean {when}" d="M{x} {n(at - 6)}V{n(at + 6)}"/>')
    rest = len(found) - len(shown)
    left_out = f"; {rest} more groups are not drawn" if rest else ""
    return Strip(
        f"By {name}; bars are means{left_out}.",
        chart.svg(f"Difference between robot and simulation by {name}"),
    )


def _order(label: str) -> list[tuple[int, float, str]]:
    """TP2 before TP10."""
    return [
        (0, float(part), "") if part.isdecimal() else (1, 0.0, part)
        for part in re.split(r"(\d+)", label)
        if part
    ]
