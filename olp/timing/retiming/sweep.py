"""The largest speed along a path under linear limits, by one sweep back and one forward.

Reachability analysis (H. Pham and Q.-C. Pham, "A new approach to time-optimal path parameterization based on
reachability analysis", IEEE T-RO 34(3), 2018). With x = ds/dt squared and u = d²s/dt², constant between two
samples, every limit reads low <= p u + r x <= high. Here it holds at both ends of each interval: with x at its
start, y at its end and u = (y - x) / 2d, two limits in x and y. On a cubic spline an axis's acceleration q' u + q'' x
is quadratic inside the interval, so it stays between its ends and the middle one of its three Bernstein
coefficients, which is linear in x and y too and becomes a third limit: nothing is exceeded between the samples.

The largest x for a y is the least of many lines, a concave function; so the largest controllable x is found at
y = min(controllable y, where that function peaks).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

_MOST_CUTS = 60  # of the search for a peak; two to six are usual


class Strips(NamedTuple):
    """Limits low <= p u + r x <= high at the n samples of b paths, (n, m, b) each; low < 0 < high.

    `cap` (n, b): largest x. `step` (n - 1, b): length of the intervals. The first `axes` of the m limits are those
    of axes, of which r = dp/ds.
    """

    p: Floats
    r: Floats
    low: Floats
    high: Floats
    cap: Floats
    step: Floats
    axes: int


class IntervalBounds(NamedTuple):
    """Of every interval: x <= a - b y for all its lines, (n - 1, 2m + axes, b) each; `low_*`: x >= a - b y."""

    a: Floats
    b: Floats
    low_a: Floats
    low_b: Floats


def sweep(strips: Strips, start: Floats, end: Floats) -> Floats:
    """The largest x (n, b) with x <= `start` (b,) at the first and x <= `end` (b,) at the last sample."""
    x_part, y_part, low, high = intervals(strips)
    lines = _lines(x_part, y_part, low, high)
    peak = _peaks(lines, strips.cap, _last_y(x_part, y_part, low, high, strips.cap))
    x = np.empty_like(strips.cap)
    x[-1] = np.minimum(end, strips.cap[-1])
    for i in range(len(x) - 2, -1, -1):
        y = np.minimum(x[i + 1], peak[i])
        x[i] = np.minimum(np.min(lines.a[i] - lines.b[i] * y, axis=0), strips.cap[i])
    np.maximum(x, 0.0, out=x)
    x[0] = np.minimum(x[0], start)
    forward = _lines(y_part, x_part, low, high)
    for i in range(len(x) - 1):
        y = np.min(forward.a[i] - forward.b[i] * x[i], axis=0)
        x[i + 1] = np.maximum(np.minimum(y, x[i + 1]), 0.0)
    return x


def intervals(strips: Strips) -> tuple[Floats, Floats, Floats, Floats]:
    """Factors of x and y, low and high, (n - 1, 2m + axes, b): each limit at the start, at the end and, for axes,
    inside each interval."""
    p, r, axes = strips.p, strips.r, slice(strips.axes)
    half = 0.5 / strips.step[:, None, :]
    first, last = p[:-1] * half, p[1:] * half
    before, after = r[:-1, axes] / 2, r[1:, axes] / 2
    middle = (first[:, axes] + last[:, axes]) / 2 + (before - after) / 4
    low, high = strips.low, strips.high
    return (
        np.concatenate((r[:-1] - first, -last, after - middle), axis=1),
        np.concatenate((first, last + r[1:], before + middle), axis=1),
        np.concatenate((low[:-1], low[1:], np.maximum(low[:-1, axes], low[1:, axes])), axis=1),
        np.concatenate((high[:-1], high[1:], np.minimum(high[:-1, axes], high[1:, axes])), axis=1),
    )


def _lines(x_part: Floats, y_part: Floats, low: Floats, high: Floats) -> IntervalBounds:
    """Limits solved for x; where x does not occur they say nothing about it."""
    none = x_part == 0.0
    factor = 1.0 / np.where(none, 1.0, x_part)
    b = np.where(none, 0.0, y_part * factor)
    up, down = high * factor, low * factor
    falling = factor < 0
    a = np.where(none, np.inf, np.where(falling, down, up))
    return IntervalBounds(a, b, np.where(none, -np.inf, np.where(falling, up, down)), b)


def _last_y(x_part: Floats, y_part: Floats, low: Floats, high: Floats, cap: Floats) -> Floats:
    """Largest y (n - 1, b) by its own cap and by the limits in which x does not occur."""
    alone = (x_part == 0.0) & (y_part != 0.0)
    last = cap[1:]
    if alone.any():
        factor = 1.0 / np.where(alone, y_part, 1.0)
        bound = np.where(alone, np.maximum(high * factor, low * factor), np.inf)
        last = np.minimum(last, bound.min(axis=1))
    return last


def _peaks(lines: IntervalBounds, cap: Floats, last: Floats) -> Floats:
    """The smallest y (n - 1, b) where the largest x is largest, within 0..`last`.

    Kelley's cutting planes: where the rising and the falling line found so far meet is the next place to look;
    from places no x is possible at, the lines of both bounds lead back to the last one that is (Newton).
    """
    shape = last.shape
    a, b, low_a, low_b = (part.transpose(0, 2, 1).reshape(-1, part.shape[1]) for part in lines)
    cap, y = cap[:-1].reshape(-1, 1), last.reshape(-1).copy()
    a, b = np.append(a, cap, axis=1), np.append(b, np.zeros_like(cap), axis=1)
    low_a, low_b = np.append(low_a, np.zeros_like(cap), axis=1), np.append(low_b, np.zeros_like(cap), axis=1)
    rising_a, rising_b = _active(a, b, np.zeros(len(y)))
    falling_a, falling_b = np.zeros(len(y)), np.full(len(y), np.nan)
    y = np.where(rising_b < 0, y, 0.0)
    rows = np.flatnonzero(rising_b < 0)
    for _ in range(_MOST_CUTS):
        if not len(rows):
            break
        at, top, bottom = y[rows], (a[rows], b[rows]), (-low_a[rows], -low_b[rows])
        (top_a, top_b), (bottom_a, bottom_b) = _active(*top, at), _active(*bottom, at)
        room = top_a - top_b * at + (bottom_a - bottom_b * at)
        outside = room < -1e-12 * (np.abs(top_a) + np.abs(top_b * at))
        rising = ~outside & (top_b < 0)
        falling = ~outside & ~rising
        rising_a[rows[rising]], rising_b[rows[rising]] = top_a[rising], top_b[rising]
        falling_a[rows[falling]], falling_b[rows[falling]] = top_a[falling], top_b[falling]
        with np.errstate(divide="ignore", invalid="ignore"):
            back = (top_a + bottom_a) / (top_b + bottom_b)
            met = (falling_a[rows] - rising_a[rows]) / (falling_b[rows] - rising_b[rows])
        # No falling line yet: the last place that is possible is the peak.
        following = np.where(outside, back, np.where(np.isnan(met), at, met))
        y[rows] = np.maximum(following, 0.0)
        rows = rows[np.abs(following - at) > 1e-13 * at]
    return y.reshape(shape)


def _active(a: Floats, b: Floats, y: Floats) -> tuple[Floats, Floats]:
    """The line (a, b) of each row that is lowest at y (n,)."""
    row = np.arange(len(a))
    k = np.argmin(a - b * y[:, None], axis=1)
    return a[row, k], b[row, k]
