"""How well the data hold the parameters of a fit: 95 % intervals, bounds reached, parameters that nothing tells.

An interval is where the likelihood of the joint fit lies close enough to its best, together with that of every other
way to explain the moves as well: another form of a term, another term in the place of one.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from olp.identification.diagnosis.errors import rms
from olp.identification.diagnosis.fitting import (
    FREEDOM,
    ModelFit,
    Noise,
    evaluate,
    parameters_of,
    place_of,
    slopes_of,
    whiten,
)
from olp.identification.diagnosis.model import DurationModel
from olp.identification.diagnosis.profile import distance
from olp.identification.diagnosis.result import FittedParameter
from olp.identification.diagnosis.ways import ALIKE, ways_of
from olp.timing.physics import TermParameter
from olp.timing.physics._case import MeasuredMoves

Floats = NDArray[np.float64]

_QUANTILE = 1.96
_SMALL = 2.37  # Student's quantile of ν degrees is about 1.96 + 2.37 / ν (Cornish and Fisher)
_AT = 1e-3  # of the span: that near to a bound is at it
_LOOSE = 0.25  # of the span: a wider standard error says nothing
_PIECES = 10.0  # observations that a wrong form counts as: its errors do not average out over moves alike
_BEYOND = math.log(10.0)  # what a bound is passed by where the data never object
_MORE = 0.3  # times the noise's variance: with more left, a form is not quite the body's
_HOLDS = 0.8  # of its own prediction that a group holds at most
_SAME = 0.05  # times the scatter: predictions that differ by less are those of one law
_LATTICE = "cycle-quantisation"


class _Errors(NamedTuple):
    """(p,) standard errors in the search's coordinates, 0 where the fit has no slope."""

    plain: Floats  # of scatter alone
    whole: Floats  # with what repeats have in common and with what the form misses


class _Side(NamedTuple):
    """[coordinate] one end of an interval, and whether the data set it."""

    at: float
    told: bool


def parameters_with_intervals(
    fitted: ModelFit,
    case: MeasuredMoves,
    noise: Noise,
    rivals: Sequence[DurationModel] = (),
    floor: float = math.inf,
) -> list[dict[str, FittedParameter]]:
    """One mapping per part. `rivals`: models with other terms that cannot be told from this one. `floor` [s]: scatter
    that is known from elsewhere; what is left beyond it is the form's.

    Ends are those of the profile likelihood, at as many deviations as standard errors are larger than scatter makes
    them (information of Student's t: (ν+1)/(ν+3) JᵀJ/s², Lange, Little, Taylor 1989, appendix B).
    """
    if not fitted.model.parts:
        return []
    low, high = _ends(fitted, case, noise, floor)
    for other, worse in _others(fitted, case, noise, rivals):
        near = math.sqrt(max(1.0 - worse / ALIKE, 0.0))
        _widen(low, high, fitted, other, near, case, noise, floor)
    result: list[dict[str, FittedParameter]] = [{} for _ in fitted.model.parts]
    index_of = {id(part): k for k, part in enumerate(fitted.model.parts)}
    for k, (part, parameter, value) in enumerate(parameters_of(fitted.model)):
        if part.term.name == _LATTICE:
            error = _QUANTILE * _lattice_error(case, fitted, value)
            told = FittedParameter(value, parameter.unit, value - error, value + error)
        else:
            told = _told(parameter, value, low[k], high[k])
        result[index_of[id(part)]][parameter.name] = told
    return result


def _told(parameter: TermParameter, value: float, low: _Side, high: _Side) -> FittedParameter:
    """An end that nothing tells is that of the range, or, where the term does nothing at infinity, far beyond it."""
    bounds = (parameter.low, parameter.high)
    least, most = np.log(bounds) if parameter.log else bounds
    span = float(most - least)
    place = math.log(value) if parameter.log else value
    at_bound = min(place - least, most - place) < _AT * span and value != parameter.null
    # Beyond the span's ends no likelihood was asked.
    ends = np.clip([low.at, high.at], place - 20 * span, place + 20 * span)
    ends = np.exp(np.clip(ends, -700, 700)) if parameter.log else ends
    held = (high.told or low.told) and high.at - low.at < 2 * _QUANTILE * _LOOSE * span
    return FittedParameter(
        value,
        parameter.unit,
        float(ends[0]),
        float(ends[1]),
        bool(at_bound),
        bool(held and high.told and low.told),
    )


def _ends(
    fitted: ModelFit, case: MeasuredMoves, noise: Noise, floor: float
) -> tuple[list[_Side], list[_Side]]:
    """Of every parameter."""
    errors = _errors(fitted, case, noise, floor)
    place, least, most = place_of(fitted.model)
    freedom = max(len(case) - len(place), 1)
    sides: tuple[list[_Side], list[_Side]] = ([], [])
    for k, (part, parameter, _) in enumerate(parameters_of(fitted.model)):
        plain, whole = float(errors.plain[k]), float(errors.whole[k])
        deviations = (_QUANTILE + _SMALL / freedom) * (whole / plain if plain > 0 else 1.0)
        for sign, ends, bound in ((-1, sides[0], least[k]), (1, sides[1], most[k])):
            if part.term.name == _LATTICE:
                ends.append(_Side(float(place[k]), True))
                continue
            far = distance(fitted, k, sign, plain, deviations, case, noise)
            beyond = _BEYOND if parameter.log else 0.0
            at = float(place[k]) + sign * far if math.isfinite(far) else float(bound) + sign * beyond
            ends.append(_Side(at, math.isfinite(far)))
    return sides


def _others(
    fitted: ModelFit, case: MeasuredMoves, noise: Noise, rivals: Sequence[DurationModel]
) -> list[tuple[ModelFit, float]]:
    """Fits that explain as well, and how much worse they are in BIC."""
    told = fitted.model.seconds(case)
    found = [
        (way.fit, way.worse)
        for way in ways_of(fitted, case, noise)
        # The same law in other words: its numbers are those of another equation.
        if rms(way.fit.model.seconds(case) - told) > _SAME * fitted.scale
    ]
    found += [
        (other, max(other.bic - fitted.bic, 0.0)) for other in (evaluate(m, case, noise) for m in rivals)
    ]
    return [(other, worse) for other, worse in found if worse < ALIKE]


def _widen(
    low: list[_Side],
    high: list[_Side],
    fitted: ModelFit,
    other: ModelFit,
    near: float,
    case: MeasuredMoves,
    noise: Noise,
    floor: float,
) -> None:
    """Sides of the parameters that both fits have, so that they hold the other's interval, made smaller by `near`."""
    errors = _errors(other, case, noise, floor).whole
    place, _, _ = place_of(other.model)
    of = {
        (part.label, p.name, p.unit, p.meaning): k
        for k, (part, p, _) in enumerate(parameters_of(other.model))
    }
    for k, (part, p, _) in enumerate(parameters_of(fitted.model)):
        at = of.get((part.label, p.name, p.unit, p.meaning))
        if at is None:
            continue
        reach = _QUANTILE * near * float(errors[at])
        low[k] = min(low[k], _Side(float(place[at]) - reach, low[k].told))
        high[k] = max(high[k], _Side(float(place[at]) + reach, high[k].told))


def _errors(fitted: ModelFit, case: MeasuredMoves, noise: Noise, floor: float) -> _Errors:
    """The larger of what scatter alone leaves and of what repeats of one move leave that have an error in common
    (cluster-robust; K.-Y. Liang, S. Zeger, Biometrika 73, 1986; J. MacKinnon, H. White, J. Econometrics 29, 1985),
    and what a form leaves that is not quite the body's
    (a discrepancy, M. Kennedy, A. O'Hagan, J. Royal Statistical Society B 63, 2001)."""
    slopes = slopes_of(fitted.model, case, noise)
    scale = (FREEDOM + 1.0) / (FREEDOM + 3.0) / fitted.scale**2
    information = slopes.T @ slopes * scale
    size = np.sqrt(np.maximum(np.diag(information), 1e-300))
    inverse = np.linalg.pinv(information / np.outer(size, size)) / np.outer(size, size)
    left = case.measured - fitted.model.seconds(case)
    residual = whiten(left, noise, case)
    pull = (FREEDOM + 1.0) / (FREEDOM + (residual / fitted.scale) ** 2) * residual / fitted.scale**2
    labels = case.repeats if len(case.repeats) == len(case) else np.arange(len(case))
    _, cluster = np.unique(labels, return_inverse=True)
    scores = np.zeros((int(cluster.max()) + 1, slopes.shape[1]))
    np.add.at(scores, cluster, pull[:, None] * slopes)
    # Without a group the fit would have gone elsewhere by its score over what it does not hold itself (a jackknife).
    leverage = np.bincount(cluster, ((slopes @ inverse) * slopes).sum(axis=1) * scale)
    scores /= 1.0 - np.minimum(leverage, _HOLDS)[:, None]
    robust = inverse @ (scores.T @ scores) @ inverse
    plain = np.maximum(np.diag(inverse), 0.0)
    excess = float(np.mean(left**2)) / floor**2 - 1.0 if math.isfinite(floor) else 0.0
    excess = excess if excess > _MORE else 0.0  # less is chance
    missed = plain * (floor / fitted.scale) ** 2 * excess * len(case) / _PIECES if excess else 0.0
    known = np.diag(information) > 0
    whole = np.maximum(plain, np.diag(robust)) + missed
    return _Errors(np.where(known, np.sqrt(plain), 0.0), np.where(known, np.sqrt(whole), 0.0))


def _lattice_error(case: MeasuredMoves, fitted: ModelFit, cycle: float) -> float:
    """[s] of a cycle: the durations are m c + noise, so the variance is s² / Σ m² (a line through the origin)."""
    counts = np.round(case.measured / cycle)
    off = case.measured - counts * cycle
    return float(np.sqrt(np.mean(off**2) / max(float((counts**2).sum()), 1.0)))
