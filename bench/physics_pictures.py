"""Draws, for every term that is seen in durations, the trace it leaves: docs/images/physics/NAME.svg.

    python bench/physics_pictures.py

Each dot is one move of the recording of physics_page.py with only this term in it; up is later than simulated. Of all
that is recorded of a move, the picture takes the column that orders the dots best (the largest share of their variance
between eighths of the moves): it is the one to look at in a recording of one's own.
"""

from __future__ import annotations

import sys
from collections.abc import Mapping
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

ROOT = Path(__file__).parent.parent
sys.path[:0] = [str(ROOT), str(ROOT / "bench")]

from olp.contracts.terms import CYCLE, rich_case  # noqa: E402
from olp.core.units import deg, mm, ms  # noqa: E402
from olp.identification.diagnosis.model import DurationModel, ModelPart  # noqa: E402
from olp.reports.plot.figure import Axes, Dot, Figure, TextLabel, room  # noqa: E402  # noqa: E402
from olp.reports.plot.output import svg  # noqa: E402
from olp.timing.physics import MoveTerm, load_term, term_names  # noqa: E402
from olp.timing.physics._case import MeasuredMoves  # noqa: E402

FOLDER = ROOT / "docs" / "images" / "physics"
Floats = NDArray[np.float64]
_PARTS = 8  # of the moves, along a column
_SEEN = 1e-3  # [s] a trace smaller than this is not drawn
_PARTED = 0.2  # [1] of what the first column leaves has to be explained by a second one that is shown
_AS_GOOD = 0.19  # [1] of the variance
_PLAINER = 0.25  # [1]
_SPEEDS = tuple(np.linspace(0.05, 0.9, 86))  # [m/s]


class Trace(NamedTuple):
    """How much later each of some moves is [ms], over the column that orders them best; `high`: see `parted`."""

    label: str
    over: Floats
    late: Floats
    beside: str = ""  # the column that parts what the first leaves, "" for none
    high: NDArray[np.bool_] | None = None  # (n,) upper half of it


def columns(case: MeasuredMoves) -> Mapping[str, Floats]:
    """What a cause may hang on, in the units people read."""
    fastest = np.full(len(case), np.nan)
    if case.rates is not None and case.rates.rated is not None:
        turning = np.abs(case.rates.path).max(axis=1) * case.base.speed[:, None] / case.rates.rated
        fastest = 100 * turning.max(axis=1)
    return {
        "programmed speed, mm/s": case.base.speed / mm,
        "length, mm": case.length / mm,
        "incline, degrees (up is positive)": np.arcsin(np.clip(case.rise, -1, 1)) / deg,
        "rounding at the end, mm": case.blend / mm,
        "rounding at the start, mm": case.blend_start / mm,
        "turn of the tool, degrees": case.turn / deg,
        "load, kg": case.payload,
        "distance of the end from the base's axis, mm": np.linalg.norm(case.end[:, :2], axis=1) / mm,
        "simulated duration, s": case.simulated,
        "fastest axis, % of its rated speed": fastest,
        "running time, s": case.t_start,
        "simulated duration beyond whole cycles, ms": np.mod(case.simulated, CYCLE) / ms,
    }


def trace_of(term: MoveTerm, case: MeasuredMoves) -> Trace | None:
    """The straight moves with `term` in it, in the plainest of its forms and starts; None: none shows."""
    rows = case.moving & ~case.joint
    known = {
        label: column[rows] for label, column in columns(case).items() if np.isfinite(column[rows]).all()
    }
    best, plainest = None, -1.0
    for form in term.forms(case):
        for values in term.guesses(form, case):
            late = (DurationModel((ModelPart(term, form, values),)).seconds(case) - case.simulated)[rows]
            if np.abs(late).max() < _SEEN:
                continue
            shares = {label: ordered(column, late) for label, column in known.items()}
            # The first form is the usual one; another has to be a good deal plainer.
            if max(shares.values()) > plainest + _PLAINER:
                plainest = max(shares.values())
                label = _first_of_best(shares)
                best = Trace(label, known[label], late / ms)
    return _with_second(best, known) if best else None


def _with_second(trace: Trace, known: Mapping[str, Floats]) -> Trace:
    others = {label: parted(trace, column) for label, column in known.items() if label != trace.label}
    beside = _first_of_best(others)
    if others[beside] < _PARTED:
        return trace
    return trace._replace(beside=beside, high=known[beside] > np.median(known[beside]))


def _first_of_best(shares: Mapping[str, float]) -> str:
    """Columns hang together; of those that are nearly as good as the best, the first is the plainest to read."""
    return next(label for label, share in shares.items() if share >= max(shares.values()) - _AS_GOOD)


def parted(trace: Trace, column: Floats) -> float:
    """The share of what the first column leaves that upper and lower half of another explain, eighth by eighth."""
    high = column > np.median(column)
    if not 0.2 < high.mean() < 0.8:
        return 0.0
    left = explained = 0.0
    for part in _eighths(trace.over):
        late, upper = trace.late[part], high[part]
        left += float(np.var(late)) * len(part)
        if upper.any() and not upper.all():
            explained += (
                len(part)
                * upper.mean()
                * (1 - upper.mean())
                * (late[upper].mean() - late[~upper].mean()) ** 2
            )
    return explained / left if left > 1e-4 * float(np.var(trace.late)) * len(trace.late) + 1e-9 else 0.0


def _eighths(column: Floats) -> list[NDArray[np.intp]]:
    """The rows in eighths along a column, or by its values where these are few."""
    values = np.unique(column)
    if len(values) <= _PARTS:
        return [np.flatnonzero(column == value) for value in values]
    return np.array_split(np.argsort(column, kind="stable"), _PARTS)


def ordered(column: Floats, late: Floats) -> float:
    """The share of the variance of `late` that lies between eighths of the moves along `column`."""
    if len(column) < 2 * _PARTS or np.ptp(column) == 0:
        return 0.0
    parts = [late[rows] for rows in _eighths(column)]
    whole = float(np.var(late))
    if whole <= 1e-18:
        return 0.0  # the same for all: any column will do
    within = sum(float(np.var(part)) * len(part) for part in parts) / len(late)
    return 1.0 - within / whole


def picture(name: str, trace: Trace) -> str:
    """An SVG that follows the reader's light or dark theme."""
    figure = Figure(560, 236, f"{name}: how much later each move is, over its {trace.label}")
    panel = Axes(figure, 70, 22, 470, 164, room(trace.over, zero=False), room(trace.late))
    panel.frame(trace.label, "later, ms")
    colours = np.where(
        np.zeros(len(trace.late), bool) if trace.high is None else trace.high, "orange", "blue"
    )
    for x, y, colour in zip(trace.over.tolist(), trace.late.tolist(), colours.tolist(), strict=True):
        figure.add(Dot(panel.x(x), panel.y(y), 2.6, colour))
    if trace.beside:
        figure.add(
            TextLabel(
                540, 12, f"orange: upper half of {trace.beside.partition(',')[0]}", "orange", 11.0, "end"
            )
        )
    return svg(figure)


def pictures() -> Mapping[str, str]:
    """The pictures by term."""
    case = rich_case(moves=160, speeds=_SPEEDS)
    drawn: dict[str, str] = {}
    for name in term_names():
        term = load_term(name)
        found = trace_of(term, case) if isinstance(term, MoveTerm) else None
        if found is not None:
            drawn[name] = picture(name, found)
    return drawn


if __name__ == "__main__":
    FOLDER.mkdir(parents=True, exist_ok=True)
    for name, text in pictures().items():
        (FOLDER / f"{name}.svg").write_text(text, encoding="utf-8", newline="\n")
        print(name)
