"""The sweep of sweep.py as loops over numbers, for the compiled extra. Same names, same answers."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from olp.core import compiled_loops

Floats = NDArray[np.float64]
Line = tuple[float, float]  # x = a - b y


def _limit(
    p: Floats, r: Floats, low: Floats, high: Floats, i: int, j: int, half: float
) -> tuple[float, float, float, float]:
    """Factors of x and y, low and high of limit j of interval i: at its start, at its end, inside; sweep.intervals."""
    m = p.shape[1]
    if j < m:
        change = p[i, j] * half
        return r[i, j] - change, change, low[i, j], high[i, j]
    if j < 2 * m:
        k = j - m
        change = p[i + 1, k] * half
        return -change, change + r[i + 1, k], low[i + 1, k], high[i + 1, k]
    k = j - 2 * m
    before, after = r[i, k] / 2, r[i + 1, k] / 2
    change = (p[i, k] * half + p[i + 1, k] * half) / 2 + (before - after) / 4
    return after - change, before + change, max(low[i, k], low[i + 1, k]), min(high[i, k], high[i + 1, k])


def _solved(
    p: Floats, r: Floats, low: Floats, high: Floats, i: int, half: float, last: float, lines: Floats
) -> float:
    """Fills `lines` (4, ...): a, b, lower a, lower b of interval i; gives the largest y that is possible at all."""
    for j in range(lines.shape[1]):
        fx, fy, bottom, top = _limit(p, r, low, high, i, j, half)
        if fx == 0.0:
            lines[0, j], lines[1, j], lines[2, j], lines[3, j] = math.inf, 0.0, -math.inf, 0.0
            if fy != 0.0:
                last = min(last, max(top / fy, bottom / fy))
            continue
        share = 1.0 / fx
        lines[1, j] = lines[3, j] = fy * share
        if fx > 0.0:
            lines[0, j], lines[2, j] = top * share, bottom * share
        else:
            lines[0, j], lines[2, j] = bottom * share, top * share
    return last


def _bounds(
    p: Floats, r: Floats, low: Floats, high: Floats, axes: int, i: int, half: float, cap: float, y: float
) -> tuple[float, float, bool]:
    """The largest x of interval i for y, how fast it falls with y, and whether there is an x for y at all."""
    best, falls, least, possible = cap, 0.0, 0.0, True
    for j in range(2 * p.shape[1] + axes):
        fx, fy, bottom, top = _limit(p, r, low, high, i, j, half)
        if fx == 0.0:
            possible = possible and bottom <= fy * y <= top
            continue
        share = 1.0 / fx
        above, below = (top - fy * y) * share, (bottom - fy * y) * share
        if fx < 0.0:
            above, below = below, above
        if above < best:
            best, falls = above, fy * share
        if below > least:
            least = below
    return best, falls, possible and best >= least


def _top(lines: Floats, cap: float, y: float) -> Line:
    """The line that bounds x from above at y."""
    a, b = cap, 0.0
    for j in range(lines.shape[1]):
        if lines[0, j] - lines[1, j] * y < a - b * y:
            a, b = lines[0, j], lines[1, j]
    return a, b


def _bottom(lines: Floats, y: float) -> Line:
    """The line that bounds x from below at y."""
    a, b = 0.0, 0.0
    for j in range(lines.shape[1]):
        if lines[2, j] - lines[3, j] * y > a - b * y:
            a, b = lines[2, j], lines[3, j]
    return a, b


def _peak(lines: Floats, cap: float, y: float) -> float:
    """The smallest y up to the given one where the largest x is largest: see sweep._peaks."""
    rise_a, rise_b = _top(lines, cap, 0.0)
    if rise_b >= 0.0:
        return 0.0
    fall_a, fall_b, bounded = 0.0, 0.0, False
    for _ in range(60):
        top_a, top_b = _top(lines, cap, y)
        low_a, low_b = _bottom(lines, y)
        room = (top_a - top_b * y) - (low_a - low_b * y)
        following = y
        if room < -1e-12 * (abs(top_a) + abs(top_b * y)):
            following = (top_a - low_a) / (top_b - low_b)
        else:
            if top_b < 0.0:
                rise_a, rise_b = top_a, top_b
            else:
                fall_a, fall_b, bounded = top_a, top_b, True
            if bounded:
                following = (fall_a - rise_a) / (fall_b - rise_b)
        before, y = y, max(following, 0.0)
        if abs(y - before) <= 1e-13 * before:
            break
    return y


@compiled_loops.kernel(_limit, _solved, _bounds, _top, _bottom, _peak)
def sweep_one(
    p: Floats, r: Floats, low: Floats, high: Floats, cap: Floats, step: Floats, axes: int, start: float, end: float,
    x: Floats,
) -> None:  # fmt: skip
    """Fills x (n,) of one path; p, r, low, high (n, m), cap (n,), step (n - 1,): see sweep.Strips."""
    n, m = p.shape
    lines = np.empty((4, 2 * m + axes))
    x[n - 1] = min(end, cap[n - 1])
    for i in range(n - 2, -1, -1):
        half = 0.5 / step[i]
        best, falls, possible = _bounds(p, r, low, high, axes, i, half, cap[i], x[i + 1])
        # Where x does not fall with y, the peak lies at y or further on and is not needed.
        if falls > 0.0 or not possible:
            last = _solved(p, r, low, high, i, half, cap[i + 1], lines)
            y = min(x[i + 1], _peak(lines, cap[i], last))
            a, b = _top(lines, cap[i], y)
            best = a - b * y
        x[i] = max(best, 0.0)
    x[0] = min(x[0], start)
    for i in range(n - 1):
        best = x[i + 1]
        for j in range(2 * m + axes):
            fx, fy, bottom, top = _limit(p, r, low, high, i, j, 0.5 / step[i])
            if fy > 0.0:
                best = min(best, (top - fx * x[i]) / fy)
            elif fy < 0.0:
                best = min(best, (bottom - fx * x[i]) / fy)
        x[i + 1] = max(best, 0.0)
