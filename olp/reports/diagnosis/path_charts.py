"""The moves where they are in the cell, coloured by what the simulation misses: from above and from the side."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from markupsafe import Markup
from numpy.typing import NDArray

from olp.identification.diagnosis import phrasing
from olp.reports.diagnosis.colours import STEPS, scale_limit, step_of
from olp.reports.diagnosis.rows import MoveRows
from olp.reports.diagnosis.svg import Chart, n
from olp.reports.plot.axes import room

Floats = NDArray[np.float64]
MM = 1000.0


class View(NamedTuple):
    """What is drawn to the right and upwards: columns of a point."""

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
    return chart.svg(f"{view.name}, {when}: the path, moves coloured by robot less simulation")


def _at(chart: Chart, points: Floats, view: View) -> list[tuple[float, float]]:
    """[px]"""
    return list(
        zip(
            chart.x(points[:, view.right] * MM).tolist(),
            chart.y(points[:, view.up] * MM).tolist(),
            strict=True,
        )
    )


def legend(rows: MoveRows) -> tuple[str, str]:
    """What the ends of the colour scale stand for."""
    on = rows.on_path
    limit = scale_limit(rows.before[on] if on.any() else rows.before)
    return phrasing.seconds(-limit), phrasing.seconds(limit, sign=True)


def data(rows: MoveRows) -> dict[str, Any]:
    """What the page's script draws and tells at the pointer: compact columns, mm and ms."""
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
