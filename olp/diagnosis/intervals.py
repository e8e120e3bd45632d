"""How well the data hold the parameters of a fit: 95 % intervals, bounds reached, parameters that nothing tells."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from olp.diagnosis.fitting import FREEDOM, Fit, Noise, parameters_of, slopes_of, whiten
from olp.diagnosis.result import FittedParameter
from olp.physics._case import Case

Floats = NDArray[np.float64]

_QUANTILE = 1.96
_AT = 1e-3  # of the span: that near to a bound is at it
_LOOSE = 0.25  # of the span: a wider standard error says nothing


def parameters_with_intervals(fitted: Fit, case: Case, noise: Noise) -> list[dict[str, FittedParameter]]:
    """One mapping per part. Intervals are of the joint fit, symmetric in the search's coordinates (so of logarithms).

    Information of Student's t: (ν+1)/(ν+3) JᵀJ/s² (Lange, Little, Taylor 1989, appendix B), see `_errors`.
    """
    if not fitted.model.parts:
        return []
    error = _errors(fitted, case, noise)
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


def _errors(fitted: Fit, case: Case, noise: Noise) -> Floats:
    """(p,) standard errors in the search's coordinates: the larger of what scatter alone leaves and of what repeats of
    one move leave that have an error in common (cluster-robust; K.-Y. Liang, S. Zeger, Biometrika 73, 1986)."""
    slopes = slopes_of(fitted.model, case, noise)
    information = slopes.T @ slopes * (FREEDOM + 1.0) / (FREEDOM + 3.0) / fitted.scale**2
    size = np.sqrt(np.maximum(np.diag(information), 1e-300))
    inverse = np.linalg.pinv(information / np.outer(size, size)) / np.outer(size, size)
    residual = whiten(case.measured - fitted.model.seconds(case), noise.order)
    pull = (FREEDOM + 1.0) / (FREEDOM + (residual / fitted.scale) ** 2) * residual / fitted.scale**2
    labels = case.repeats if len(case.repeats) == len(case) else np.arange(len(case))
    _, cluster = np.unique(labels, return_inverse=True)
    scores = np.zeros((int(cluster.max()) + 1, slopes.shape[1]))
    np.add.at(scores, cluster, pull[:, None] * slopes)
    count, freedom = len(scores), max(len(scores) - slopes.shape[1], 1)
    robust = inverse @ (scores.T @ scores) @ inverse * count / freedom
    return np.sqrt(np.maximum(np.maximum(np.diag(inverse), np.diag(robust)), 0.0))


def _lattice_error(case: Case, fitted: Fit, cycle: float) -> float:
    """[s] of a cycle: the durations are m c + noise, so the variance is s² / Σ m² (a line through the origin)."""
    counts = np.round(case.measured / cycle)
    off = case.measured - counts * cycle
    return float(np.sqrt(np.mean(off**2) / max(float((counts**2).sum()), 1.0)))
