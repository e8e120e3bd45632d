"""How far predicted durations are from measured ones."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from olp.identification.diagnosis.result import Errors

Floats = NDArray[np.float64]


def rms(values: Floats) -> float:
    """Root mean square, in the unit of `values` (n,); 0 of nothing."""
    return float(np.sqrt(np.mean(values**2))) if len(values) else 0.0


def errors_of(residual: Floats, measured: Floats) -> Errors:
    """RMSE [s], mean and worst absolute percentage, of residuals (n,) [s] of measured durations (n,) [s]."""
    if not len(residual):
        return Errors(math.nan, math.nan, math.nan)
    share = 100.0 * np.abs(residual) / np.where(measured > 0, measured, np.nan)
    return Errors(rms(residual), float(np.nanmean(share)), float(np.nanmax(share)))
