"""Noise of an axis, what its rest goes together with, and the verdict."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from olp.identification.diagnosis.logs.result import AxisResidual, LogCorrelate
from olp.identification.diagnosis.logs.select import LibraryColumn, held_out, products
from olp.identification.diagnosis.logs.series import rests
from olp.identification.diagnosis.logs.statistics import student_tail
from olp.identification.diagnosis.logs.whiten import autoregression, kept, order_of, runs, whiten

Floats = NDArray[np.float64]
Mask = NDArray[np.bool_]
CLEAR = 1.5  # times the noise: less is not called a mismatch
_MOST_CORRELATES = 3
_CERTAIN = 1e-3
_WHOLE = 0.9  # of the mismatch's squares: more is explained, not partly


def noise_floor(time: Floats, residual: Floats, speed: Floats, use: Mask) -> float:
    """RMS of what no motion causes: scatter at rests around each rest's mean, or of neighbours, whichever is more."""
    third = np.diff(residual, 3)
    good = use[3:] & use[:-3]
    white = 1.4826 * float(np.median(np.abs(third[good]))) / math.sqrt(20.0) if good.any() else math.nan
    squares, freedom = 0.0, 0
    for begin, end in rests(time, speed, 0.15):
        # The first half of a rest belongs to what still swings.
        part = residual[(begin + end) // 2 : end + 1]
        part = part[use[(begin + end) // 2 : end + 1]]
        if len(part) > 8:
            squares += float(((part - part.mean()) ** 2).sum())
            freedom += len(part) - 1
    still = math.sqrt(squares / freedom) if freedom > 60 else 0.0
    return max(white, still)


def goes_with_motion(time: Floats, residual: Floats, motion: dict[str, Floats], use: Mask) -> float:
    """p-value that columns of motion help to predict a residual on blocks that no fit saw."""
    library = np.column_stack([np.ones(len(residual)), *motion.values()])
    run = runs(time, use)
    order = order_of(run)
    a = autoregression(np.where(use, residual, 0.0), run, order)
    keep = kept(run, order)
    if keep.sum() < 300:
        return 1.0
    columns = (LibraryColumn(""), *(LibraryColumn("motion") for _ in motion))
    table = products(whiten(library, a, keep), whiten(np.where(use, residual, 0.0), a, keep), columns)
    ratio = np.log(held_out(table, ()) / held_out(table, ("motion",)))
    spread = max(float(ratio.std(ddof=1)) / math.sqrt(len(ratio)), 1e-300)
    return student_tail(float(ratio.mean()) / spread, len(ratio) - 1)


def correlates(
    axis: int, signal: str, residual: Floats, columns: dict[str, Floats], use: Mask
) -> tuple[LogCorrelate, ...]:
    """Columns that a rest goes together with, strongest first; neighbours count by how independent they are."""
    rest = residual[use] - residual[use].mean()
    found = []
    for name, values in columns.items():
        other = values[use]
        if not np.isfinite(other).all() or other.std() <= 1e-9 * max(float(np.abs(other).max()), 1e-9):
            continue
        for kind, left in (("", rest), ("size of the rest with ", np.abs(rest) - np.abs(rest).mean())):
            if not left.std() > 0:
                continue
            r = float(np.corrcoef(left, other)[0, 1])
            alike = _memory(left) * _memory(other - other.mean())
            count = max(len(left) * (1 - alike) / (1 + alike), 3.0)
            t = abs(r) * math.sqrt((count - 2) / max(1 - r * r, 1e-12))
            p = min(2 * student_tail(t, count - 2), 1.0)
            if p < _CERTAIN and abs(r) > 0.1:
                found.append(LogCorrelate(axis, signal, kind + name, r, p))
    return tuple(sorted(found, key=lambda c: -abs(c.statistic))[:_MOST_CORRELATES])


def _memory(values: Floats) -> float:
    """Correlation of neighbours, from 0 to just below 1."""
    power = float(values @ values)
    return float(np.clip(values[1:] @ values[:-1] / max(power, 1e-300), 0.0, 0.99999))


def verdict_of(axes: tuple[AxisResidual, ...], named: bool, structured: set[tuple[int, str]]) -> str:
    """Of what the simulation was judged by. `structured`: (axis, signal) whose rest follows the motion."""
    if not axes:
        return "not-judged"
    before = after = 0.0
    open_ends = False
    for a in axes:
        unit = max(a.floor if math.isfinite(a.floor) else a.after, 1e-9 * a.before, 1e-12)
        gone = max((a.before**2 - unit**2) / unit**2, 0.0)
        rest = max((a.after**2 - unit**2) / unit**2, 0.0)
        before, after = before + gone, after + rest
        open_ends |= a.after > CLEAR * unit and (a.axis, a.signal) in structured
    if not named:
        return "unexplained" if open_ends else "no-mismatch"
    if not open_ends or after <= (1 - _WHOLE) * before:
        return "explained"
    return "partly-explained"
