"""Student's distribution and false discoveries, without scipy."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]


def student_tail(t: float, freedom: float) -> float:
    """P(T > t) for Student's T; nan stays nan."""
    if math.isnan(t):
        return math.nan
    x = freedom / (freedom + t * t)
    half = 0.5 * _incomplete_beta(freedom / 2, 0.5, x)
    return half if t > 0 else 1 - half


def student_quantile(freedom: float, share: float = 0.975) -> float:
    """t with P(T < t) = `share` > 1/2."""
    low, high = 0.0, 1e4
    for _ in range(80):
        middle = (low + high) / 2
        low, high = (middle, high) if student_tail(middle, freedom) > 1 - share else (low, middle)
    return (low + high) / 2


def false_discovery(p_values: Floats, level: float) -> NDArray[np.bool_]:
    """Which of (m,) looks are discoveries at the false discovery rate `level` (Benjamini, Hochberg 1995)."""
    count = len(p_values)
    order = np.argsort(p_values)
    passes = p_values[order] <= level * np.arange(1, count + 1) / max(count, 1)
    last = np.nonzero(passes)[0].max(initial=-1)
    found = np.zeros(count, dtype=bool)
    found[order[: last + 1]] = True
    return found


def _incomplete_beta(a: float, b: float, x: float) -> float:
    """Regularised, by Lentz's continued fraction (Numerical Recipes, section 6.4)."""
    if x <= 0 or x >= 1:
        return 0.0 if x <= 0 else 1.0
    if x > (a + 1) / (a + b + 2):
        return 1 - _incomplete_beta(b, a, 1 - x)
    front = math.exp(
        math.lgamma(a + b) - math.lgamma(a) - math.lgamma(b) + a * math.log(x) + b * math.log1p(-x)
    )
    c, d = 1.0, 1 / _away(1 - (a + b) * x / (a + 1))
    total = d
    for m in range(1, 300):
        for top in (
            m * (b - m) * x / ((a + 2 * m - 1) * (a + 2 * m)),
            -(a + m) * (a + b + m) * x / ((a + 2 * m) * (a + 2 * m + 1)),
        ):
            d = 1 / _away(1 + top * d)
            c = _away(1 + top / c)
            total *= c * d
        if abs(c * d - 1) < 1e-14:
            break
    return front * total / a


def _away(value: float) -> float:
    return value if abs(value) > 1e-300 else 1e-300
