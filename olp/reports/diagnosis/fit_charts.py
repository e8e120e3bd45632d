"""How well the simulation meets the robot, before and after: durations, residuals, the ladder, the sum of causes."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from markupsafe import Markup
from numpy.typing import NDArray

from olp.identification.diagnosis import phrasing
from olp.reports.diagnosis.rows import MoveRows
from olp.reports.diagnosis.svg import Chart, around, svg
from olp.reports.plot.axes import room

Floats = NDArray[np.float64]
Ladder = Sequence[tuple[str, float, float]]  # term added, BIC, RMSE of unseen moves [s]; the first term is ""
MS = 1000.0
_BINS = 30
_ROOM = 62.0  # [px] that a number beside a bar takes


def scatter(rows: MoveRows) -> Markup:
    """Simulated against measured durations; on the diagonal both agree."""
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
    """How the residuals spread, with the band of the recording's noise."""
    before, after = rows.before * MS, rows.after * MS
    before, after = before[np.isfinite(before)], after[np.isfinite(after)]
    if not len(before):
        return Markup("")
    span = around(before, after, [-2 * noise * MS, 2 * noise * MS] if math.isfinite(noise) else [])
    edges = np.linspace(*span, _BINS + 1)
    counts = [np.histogram(values, edges)[0] for values in (before, after)]
    top = max(int(count.max(initial=1)) for count in counts[: 2 if rows.causes else 1])
    chart = Chart(span, (0.0, top * 1.08))
    chart.axes("robot less simulation [ms]", "moves")
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
    """The simulation as it is, then one cause after the other; a term that is added again is numbered."""
    out: list[Rung] = []
    seen: dict[str, int] = {}
    for term, bic, heldout in ladder:
        seen[term] = seen.get(term, 0) + 1
        again = f" ({seen[term]})" if seen[term] > 1 else ""
        name = f"+ {phrasing.term_title(term)}{again}" if term else "simulation as it is"
        out.append(Rung(name, heldout, bic, out[-1].bic - bic if out else math.nan))
    return out


def ladder(steps: list[Rung], noise: float) -> Markup:
    """The error on unseen moves, cause by cause, down to the noise floor."""
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
    """From the simulated total to the measured one, by causes; [s] summed over all moves."""
    parts = [(name, float(np.nansum(values))) for name, values in rows.causes.items()]
    parts.append(("without a name", float(np.nansum(rows.after))))
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
