"""Charts of the agreement between simulation and robot, before and after: durations, residuals, the ladder, the sum
of causes.
"""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from markupsafe import Markup
from numpy.typing import NDArray

from olp.identification.diagnosis import phrasing
from olp.reports.diagnosis.rows import MoveRows
from olp.reports.diagnosis.svg import STEPS, Chart, around, n, scale_limit, step_of, svg
from olp.reports.plot.figure import room

Floats = NDArray[np.float64]
Ladder = Sequence[tuple[str, float, float]]  # term added, BIC, RMSE of unseen moves [s]; the first term is ""
MS = 1000.0
_BINS = 30
_ROOM = 62.0  # [px] that a number beside a bar takes


def scatter(rows: MoveRows) -> Markup:
    """Simulated against measured durations; equal ones are on the diagonal."""
    known = np.isfinite(rows.measured) & np.isfinite(rows.simulated)
    if not known.any():
        return Markup("")
    index = np.flatnonzero(known).tolist()
    measured = rows.measured[known]
    span = room(np.concatenate([measured, rows.simulated[known], rows.modelled[known]]), zero=False)
    chart = Chart(span, span)
    chart.axes("measured [s]", "simulated [s]")
    chart.line(span, span, "diagonal")
    chart.dots(measured, rows.simulated[known], "before", index)
    if rows.causes:
        chart.dots(measured, rows.modelled[known], "after", index)
    return chart.svg(
        "Simulated against measured duration of every move",
        "On the diagonal, simulation and robot take the same time",
    )


def histogram(rows: MoveRows, noise: float) -> Markup:
    """Distribution of the residuals, with the band of the recording's noise."""
    before, after = rows.before * MS, rows.after * MS
    before, after = before[np.isfinite(before)], after[np.isfinite(after)]
    if not len(before):
        return Markup("")
    span = around(before, after, [-2 * noise * MS, 2 * noise * MS] if math.isfinite(noise) else [])
    edges = np.linspace(*span, _BINS + 1)
    counts = [np.histogram(values, edges)[0] for values in (before, after)]
    top = max(int(count.max(initial=1)) for count in counts[: 2 if rows.causes else 1])
    chart = Chart(span, (0.0, top * 1.08))
    chart.axes("robot minus simulation [ms]", "moves")
    if math.isfinite(noise):
        chart.band(-2 * noise * MS, 2 * noise * MS, upright=True)
    for count, css in list(zip(counts, ("before", "after"), strict=True))[: 2 if rows.causes else 1]:
        _bars(chart, edges, count, css)
    return chart.svg(
        "Histogram of the difference between robot and simulation",
        f"{_spread('before', before)}{_spread('after', after) if rows.causes else ''}",
    )


def _bars(chart: Chart, edges: Floats, count: NDArray[np.int64], css: str) -> None:
    zero = float(chart.y(0.0))
    for left, right, value in zip(edges[:-1].tolist(), edges[1:].tolist(), count.tolist(), strict=True):
        if value:
            x, y = float(chart.x(left)), float(chart.y(value))
            chart.box(x + 0.5, y, float(chart.x(right)) - x - 1, zero - y, f"bar {css}")


def _spread(when: str, values: Floats) -> str:
    return f"{when}: root mean square {phrasing.seconds(float(np.sqrt(np.mean(values**2))) / MS)}. "


class Rung(NamedTuple):
    """One step of the ladder."""

    name: str
    heldout: float  # [s] RMSE of moves that the fit did not see
    bic: float
    gain: float  # BIC less than one step before


def rungs(ladder: Ladder) -> list[Rung]:
    """Return the steps of the ladder: the unchanged simulation, then one cause after the other.

    A term that is added a second time has a number behind its name.
    """
    out: list[Rung] = []
    seen: dict[str, int] = {}
    for term, bic, heldout in ladder:
        seen[term] = seen.get(term, 0) + 1
        again = f" ({seen[term]})" if seen[term] > 1 else ""
        name = f"+ {phrasing.term_title(term)}{again}" if term else "simulation as it is"
        out.append(Rung(name, heldout, bic, out[-1].bic - bic if out else math.nan))
    return out


def ladder(steps: list[Rung], noise: float) -> Markup:
    """Draw the RMS error of held-out moves after each step, beside the `noise` floor [s].

    Empty with fewer than two steps, or where an error is not known.
    """
    values = [step.heldout * MS for step in steps]
    if len(steps) < 2 or not all(map(math.isfinite, values)):
        return Markup("")
    top = max(*values, noise * MS if math.isfinite(noise) else 0.0) * 1.14 or 1.0
    chart = Chart((0.0, top), (0.0, float(len(steps))), (760.0, 34.0 * len(steps) + 58.0), left=190.0)
    chart.axes("typical error of unseen moves (root mean square) [ms]", "", y_ticks=False)
    if math.isfinite(noise):
        chart.band(0.0, noise * MS, upright=True)
    for i, (step, value) in enumerate(zip(steps, values, strict=True)):
        y, end = float(chart.y(len(steps) - i - 0.5)), float(chart.x(value))
        chart.text(chart.left - 10, y + 4, _cut(step.name, 26), "end", "label")
        chart.box(chart.left, y - 9, end - chart.left, 18, f"bar {'after' if i else 'before'}")
        chart.text(end + 7, y + 4, phrasing.seconds(step.heldout), css="label")
    told = "; ".join(f"{step.name}: {phrasing.seconds(step.heldout)}" for step in steps)
    return chart.svg("Evidence ladder: error of unseen moves after each cause", told)


def waterfall(rows: MoveRows) -> Markup:
    """Draw the way from the simulated total to the measured one: each cause's seconds, summed over all moves."""
    parts = [(name, float(np.nansum(values))) for name, values in rows.causes.items()]
    parts.append(("unexplained", float(np.nansum(rows.after))))
    known = np.isfinite(rows.measured) & np.isfinite(rows.simulated)
    if not rows.causes or not known.any():
        return Markup("")
    total = float(rows.simulated[known].sum())
    levels = np.cumsum([0.0, *(value for _, value in parts)])
    width, row = 760.0, 30.0
    chart = Chart(
        around(levels, share=0.12), (0.0, float(len(parts))), (width, row * len(parts) + 58.0), left=190.0
    )
    chart.axes(f"seconds beside the simulation's total of {total:.2f} s", "", y_ticks=False)
    for i, ((name, value), begin) in enumerate(zip(parts, levels.tolist(), strict=False)):
        y = float(chart.y(len(parts) - i - 0.5))
        x = sorted((float(chart.x(begin)), float(chart.x(begin + value))))
        css = f"s{i % 8}" if i < len(parts) - 1 else "rest"
        chart.text(chart.left - 10, y + 4, _cut(name, 26), "end", "label")
        chart.box(x[0], y - 8, max(x[1] - x[0], 1.0), 16, f"bar {css}")
        inside = x[1] + _ROOM < width
        where, anchor = (x[1] + 7, "start") if inside else (x[0] - 7, "end")
        chart.text(where, y + 4, phrasing.seconds(value, sign=True), anchor, "label")
    told = "; ".join(f"{name} {phrasing.seconds(value, sign=True)}" for name, value in parts)
    return svg(chart.parts, width, chart.height, "What each cause adds to the total time", told)


def _cut(text: str, size: int) -> str:
    return text if len(text) <= size else text[: size - 1] + "…"


# --- Group charts ---
# The residuals over running time, by direction, and by groups of moves (start point, speed, job …).

_SECTORS = 24
_STEEP = math.sin(math.radians(60.0))  # a move that rises more has no bearing worth telling
_MOST = 12  # groups in one chart


class Strip(NamedTuple):
    """Chart of one grouping of the moves."""

    caption: str
    chart: Markup


def over_time(rows: MoveRows, noise: float) -> Markup:
    """Draw the residuals over the recorder's clock where it was recorded, else in order of execution. `noise` [s]."""
    clock = bool(np.isfinite(rows.time).all()) and len(rows) > 0
    x = rows.time - rows.time.min() if clock else np.arange(1.0, len(rows) + 1)
    y = _shown(rows)
    if not len(rows) or not np.isfinite(y).any():
        return Markup("")
    chart = Chart(
        (0.0, float(x.max()) * 1.02 or 1.0), around(y, [-2 * noise * MS, 2 * noise * MS]), (760, 280)
    )
    chart.axes("running time [s]" if clock else "moves in order of execution", "robot minus simulation [ms]")
    chart.band(-2 * noise * MS, 2 * noise * MS)
    _both(chart, rows, x, np.arange(len(rows)))
    return chart.svg("Difference between robot and simulation over running time")


def _shown(rows: MoveRows) -> Floats:
    """Return all residuals [ms] that the axes of the charts must include."""
    return np.concatenate([rows.before, rows.after]) * MS


def _both(chart: Chart, rows: MoveRows, x: Floats, index: NDArray[np.int64]) -> None:
    chart.dots(x, rows.before[index] * MS, "before", index.tolist())
    if rows.causes:
        chart.dots(x, rows.after[index] * MS, "after", index.tolist())


def by_direction(rows: MoveRows, noise: float) -> Markup:
    """Draw the mean residual by the direction of travel, seen from above, without the moves of `steep`."""
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
    """Draw a polar chart of mean residuals: outside the dashed circle (zero) the robot is slower, inside faster."""
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
    """Return a row each for the moves that go up, level and down: name, how many, mean residual [s] before and after.

    Only moves along a path count, and only rows that have moves are returned.
    """
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
    """Draw one chart per grouping of the moves, a row of dots for each group. `groups`: name -> label of each move."""
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
    chart.axes("robot minus simulation [ms]", "", y_ticks=False)
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
    """Sort key that puts TP2 before TP10."""
    return [
        (0, float(part), "") if part.isdecimal() else (1, 0.0, part)
        for part in re.split(r"(\d+)", label)
        if part
    ]


# --- Path charts ---
# The moves where they are in the cell, coloured by what the simulation misses: from above and from the side.

MM = 1000.0


class View(NamedTuple):
    """Columns of a point that are drawn to the right and upwards."""

    name: str
    right: int
    up: int


VIEWS = (View("From above", 0, 1), View("From the side", 0, 2))
_AXES = ("X [mm]", "Y [mm]", "Z [mm]")


class Panel(NamedTuple):
    title: str
    chart: Markup


def panels(rows: MoveRows) -> list[Panel]:
    """Every view before and, where causes were found, after, on one scale of colours."""
    on = rows.on_path
    if not on.any():
        return []
    limit = scale_limit(rows.before[on])
    looks = [("before", rows.before), *([("after", rows.after)] if rows.causes else [])]
    return [
        Panel(f"{view.name}, {when}", _view(rows, on, view, when, step_of(residual, limit)))
        for view in VIEWS
        for when, residual in looks
    ]


def _view(rows: MoveRows, on: NDArray[np.bool_], view: View, when: str, steps: NDArray[np.int64]) -> Markup:
    ends = np.concatenate([rows.start[on], rows.end[on]]) * MM
    chart = Chart(
        room(ends[:, view.right], zero=False), room(ends[:, view.up], zero=False), (480.0, 340.0), equal=True
    )
    chart.axes(_AXES[view.right], _AXES[view.up])
    # The strongest colours are drawn last: they lie on top.
    for step in sorted(range(STEPS), key=lambda s: abs(s - STEPS // 2)):
        chosen = np.flatnonzero(on & (steps == step))
        d = "".join(
            f"M{n(a[0])} {n(a[1])}L{n(b[0])} {n(b[1])}"
            for a, b in zip(
                _at(chart, rows.start[chosen], view), _at(chart, rows.end[chosen], view), strict=True
            )
        )
        if d:
            chart.parts.append(f'<path class="way r{step}" d="{d}"/>')
    middle = (rows.start[on] + rows.end[on]) / 2 * MM
    chart.dots(middle[:, view.right], middle[:, view.up], "unseen", np.flatnonzero(on).tolist())
    return chart.svg(f"{view.name}, {when}: the path, moves coloured by robot minus simulation")


def _at(chart: Chart, points: Floats, view: View) -> list[tuple[float, float]]:
    """Return the positions [px] of `points` (n, 3) [m] in a view."""
    return list(
        zip(
            chart.x(points[:, view.right] * MM).tolist(),
            chart.y(points[:, view.up] * MM).tolist(),
            strict=True,
        )
    )


def legend(rows: MoveRows) -> tuple[str, str]:
    """Return the labels of both ends of the colour scale."""
    on = rows.on_path
    limit = scale_limit(rows.before[on] if on.any() else rows.before)
    return phrasing.seconds(-limit), phrasing.seconds(limit, sign=True)


def data(rows: MoveRows) -> dict[str, Any]:
    """Data of the page's script for drawing and tooltips: compact columns, mm and ms."""
    limit = scale_limit(rows.before[rows.on_path])
    on = rows.on_path
    points = np.round(np.concatenate([rows.start, rows.end], axis=1) * MM, 1)
    return {
        "names": [rows.name(i) for i in range(len(rows))],
        "before": _list(rows.before * MM, 2),
        "after": _list(rows.after * MM, 2),
        "found": bool(rows.causes),
        "ways": [[i, *points[i].tolist()] for i in np.flatnonzero(on).tolist()],
        "limit": round(limit * MM, 3),
    }


def _list(values: Floats, digits: int) -> list[float | None]:
    return [round(v, digits) if np.isfinite(v) else None for v in values.tolist()]
