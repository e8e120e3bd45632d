"""How a log's clock runs against the plan's: offset and rate, robust against moves that were timed wrongly."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
_ROUNDS = 30
_HUBER = 1.345  # of the scatter: 95 % efficient for normal errors (P. J. Huber, "Robust Statistics", 1981)


class ClockAlignment(NamedTuple):
    """log time = offset + rate * plan time. The rate holds the log's clock and the plan's own error alike."""

    offset: float  # [s]
    rate: float  # [1]
    offset_error: float  # [s] standard error
    rate_error: float  # [1] standard error
    scatter: float  # [s] of single instants around the line


def fit_clock(plan: Floats, log: Floats) -> ClockAlignment | None:
    """The clock from instants (n,) [s] of both; None for fewer than three that differ."""
    good = np.isfinite(plan) & np.isfinite(log)
    x, y = plan[good], log[good]
    if len(x) < 3 or np.ptp(x) <= 0:
        return None
    # Epoch seconds would cost digits.
    shift = float(y[0])
    y = y - shift
    weight = np.ones(len(x))
    for _ in range(_ROUNDS):
        columns = np.stack([np.ones(len(x)), x], axis=1)
        normal = columns.T @ (weight[:, None] * columns)
        offset, rate = np.linalg.solve(normal, columns.T @ (weight * y))
        residual = y - offset - rate * x
        scale = max(1.4826 * float(np.median(np.abs(residual))), 1e-9)
        weight = np.minimum(1.0, _HUBER * scale / np.maximum(np.abs(residual), 1e-15))
    freedom = max(weight.sum() - 2.0, 1.0)
    scatter = float(np.sqrt((weight * residual**2).sum() / freedom))
    spread = scatter * np.sqrt(np.diag(np.linalg.inv(normal)))
    return ClockAlignment(float(offset) + shift, float(rate), float(spread[0]), float(spread[1]), scatter)
