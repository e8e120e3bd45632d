"""How well the data hold the parameters of a fit: 95 % intervals, bounds reached, parameters that nothing tells."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from olp.diagnosis.fitting import FREEDOM, Fit, Noise, parameters_of, slopes_of
from olp.diagnosis.result import FittedParameter
from olp.physics._case import Case

Floats = NDArray[np.float64]

_QUANTILE = 1.96
_AT = 1e-3  # of the span: that near to a bound is at it
_LOOSE = 0.25  # of the span: a wider standard error says nothing


def parameters_with_intervals(fitted: Fit, case: Case, noise: Noise) -> list[dict[str, FittedParameter]]:
    """One mapping per part. Intervals are of the joint fit, symmetric in the search's coordinates (so of logarithms).

    Information of Student's t: (ν+1)/(ν+3) JᵀJ/s² (Lange, Little, Taylor 1989, appendix B).
    """
    if not fitted.model.parts:
        return []
    slopes = slopes_of(fitted.model, case, noise)
    information = slopes.T @ slopes * (FREEDOM + 1.0) / (FREEDOM + 3.0) / fitted.scale**2
    size = np.sqrt(np.maximum(np.diag(information), 1e-300))
    error = np.sqrt(np.maximum(np.diag(np.linalg.pinv(information / np.outer(size, size))), 0.0)) / size
    result: list[dict[str, FittedParameter]] = [{} for _ in fitted.model.parts]
    index_of = {id(part): k for k, part in enumerate(fitted.model.parts)}
    for (part, parameter, value), sd in zip(parameters_of(fitted.model), error.tolist(), strict=True):
        if part.term.name == "cycle-quantisation":
            sd = _lattice_error(case, fitted, value)
        low, high = (
            np.log([parameter.low, parameter.high]) if parameter.log else (parameter.low, parameter.high)
        )
        place = float(np.log(value)) if parameter.log else value
        span = float(high - low)
        at_bound = min(place - low, high - place) < _AT * span and value != parameter.null
        ends = np.clip([place - _QUANTILE * sd, place + _QUANTILE * sd], place - 20 * span, place + 20 * span)
        ends = np.exp(np.clip(ends, -700, 700)) if parameter.log else ends
        result[index_of[id(part)]][parameter.name] = FittedParameter(
            value,
            parameter.unit,
            float(ends[0]),
            float(ends[1]),
            bool(at_bound and part.term.name != "cycle-quantisation"),
            bool(sd < _LOOSE * span) or part.term.name == "cycle-quantisation",
        )
    return result


def _lattice_error(case: Case, fitted: Fit, cycle: float) -> float:
    """[s] of a cycle: the durations are m c + noise, so the variance is s² / Σ m² (a line through the origin)."""
    counts = np.round(case.measured / cycle)
    off = case.measured - counts * cycle
    return float(np.sqrt(np.mean(off**2) / max(float((counts**2).sum()), 1.0)))
