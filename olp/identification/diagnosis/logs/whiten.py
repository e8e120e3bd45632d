"""Residuals of neighbouring samples go together; a filter makes them independent before anything is counted.

The noise is an autoregression of order 8 (Yule and Walker); data and library go through its inverse. On residuals of
4 ms, criteria on raw samples name two to eight terms that are not there.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Mask = NDArray[np.bool_]
Labels = NDArray[np.int64]
ORDER = 8
_ORDERS = (ORDER, 4, 2, 1, 0)  # where gaps leave no run of samples that is long enough for more
_SHARE = 0.25  # of the used samples that a filter has to leave


def runs(time: Floats, use: Mask) -> Labels:
    """(n,) the number of the unbroken run that a used sample belongs to, -1 for the others."""
    step = np.diff(time, prepend=time[0])
    broken = (step > 1.6 * max(float(np.median(np.diff(time))), 1e-12)) | ~use | ~np.append(True, use[:-1])
    labels = np.cumsum(broken).astype(np.int64)
    return np.where(use, labels, -1)


def order_of(run: Labels) -> int:
    """The filter's order: less than `ORDER` where so many samples were dropped that hardly any has its neighbours."""
    used = max(int((run >= 0).sum()), 1)
    return next((order for order in _ORDERS if kept(run, order).sum() >= _SHARE * used), 0)


def autoregression(noise: Floats, run: Labels, order: int = ORDER) -> Floats:
    """(order,) coefficients a: noise[t] = a[0] noise[t-1] + … + white; Levinson's recursion on autocovariances."""
    good = run >= 0
    centred = np.where(good, noise - noise[good].mean(), 0.0) if good.any() else noise
    covariance = np.zeros(order + 1)
    for k in range(order + 1):
        same = good[k:] & (run[k:] == run[: len(run) - k])
        count = max(int(same.sum()), 1)
        covariance[k] = float((centred[k:] * centred[: len(centred) - k])[same].sum()) / count
    covariance[0] *= 1 + 1e-9
    a = np.zeros(0)
    error = max(covariance[0], 1e-300)
    for k in range(1, order + 1):
        reflection = (
            (covariance[k] - a @ covariance[k - 1 : 0 : -1]) / error if k > 1 else covariance[1] / error
        )
        reflection = float(np.clip(reflection, -0.9999, 0.9999))
        a = np.append(a - reflection * a[::-1], reflection)
        error *= 1 - reflection**2
    return a


def kept(run: Labels, order: int = ORDER) -> Mask:
    """(n,) samples that have `order` neighbours before them in their run."""
    result = np.zeros(len(run), dtype=bool)
    result[order:] = (run[order:] >= 0) & (run[order:] == run[: len(run) - order])
    return result


def whiten(columns: Floats, a: Floats, keep: Mask) -> Floats:
    """(m, …) the innovations of `columns` (n, …) at the m samples `keep`."""
    order = len(a)
    result = columns[order:].copy()
    for k in range(1, order + 1):
        result -= a[k - 1] * columns[order - k : len(columns) - k]
    return np.asarray(result[keep[order:]])
