"""How well the data hold the parameters of a fit: 95 % intervals, bounds reached, parameters that nothing tells.

An interval is where the likelihood of the joint fit lies close enough to its best, together with that of every other
way to explain the moves as well: another form of a term, another term in the place of one.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from olp.identification.diagnosis.fitting import (
    FREEDOM,
    LATTICE,
    ModelFit,
    Noise,
    evaluate,
    fit,
    moved,
    parameters_of,
    penalty,
    place_of,
    rounding_of,
    slopes_of,
    whiten,
)
from olp.identification.diagnosis.model import DurationModel, ModelPart
from olp.identification.diagnosis.result import FittedParameter
from olp.timing.physics import TermParameter
from olp.timing.physics._case import MeasuredMoves

Floats = NDArray[np.float64]

_QUANTILE = 1.96
_SMALL = 2.37  # Student's quantile of ν degrees is about 1.96 + 2.37 / ν (Cornish and Fisher)
_TOLD = 1e-9  # of the information: less, along any direction, is no more than the rounding of slopes by differences
_AT = 1e-3  # of the span: that near to a bound is at it
_LOOSE = 0.25  # of the span: a wider standard error says nothing
_PIECES = 10.0  # observations that a wrong form counts as: its errors do not average out over moves alike
_BEYOND = math.log(10.0)  # what a bound is passed by where the data never object
_MORE = 0.3  # times the noise's variance: with more left, a form is not quite the body's
_EQUALLY = 0.1  # of a clock's digit: durations that differ by less are rounded alike
_FREE = 8  # degrees of freedom within groups: fewer do not tell what these have in common
_HOLDS = 0.8  # of its own prediction that a group holds at most


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
        if part.term.name == LATTICE:
            error = _QUANTILE * _lattice_error(case, value)
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
    near = min(place - least, most - place) < _AT * span
    at_bound = near and value != parameter.null and not parameter.listed
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
    fitted: ModelFit,
    case: MeasuredMoves,
    noise: Noise,
    floor: float,
    near: float = 1.0,
    wanted: Collection[int] | None = None,
) -> tuple[list[_Side], list[_Side]]:
    """Of every parameter, or of the `wanted` ones; `near`: the share of the deviations at which they are looked for."""
    errors = _errors(fitted, case, noise, floor)
    place, least, most = place_of(fitted.model)
    sides: tuple[list[_Side], list[_Side]] = ([], [])
    for k, (part, parameter, _) in enumerate(parameters_of(fitted.model)):
        plain, deviations = float(errors.plain[k]), near * float(_deviations(errors, case)[k])
        for sign, ends, bound in ((-1, sides[0], least[k]), (1, sides[1], most[k])):
            if part.term.name == LATTICE or parameter.listed or (wanted is not None and k not in wanted):
                ends.append(_Side(float(place[k]), True))
                continue
            far = distance(fitted, k, sign, plain, deviations, case, noise)
            beyond = _BEYOND if parameter.log else 0.0
            at = float(place[k]) + sign * far if math.isfinite(far) else float(bound) + sign * beyond
            ends.append(_Side(at, math.isfinite(far)))
    return sides


def _deviations(errors: _Errors, case: MeasuredMoves) -> Floats:
    """(p,) of a normal likelihood, at which the interval of each parameter ends."""
    freedom = max(len(case) - len(errors.plain), 1)
    known = errors.plain > 0
    wider = np.where(known, errors.whole / np.where(known, errors.plain, 1.0), 1.0)
    return np.asarray((_QUANTILE + _SMALL / freedom) * wider)


def does_something(
    fitted: ModelFit, bare: ModelFit, parts: Sequence[int], case: MeasuredMoves, noise: Noise, floor: float
) -> bool:
    """Whether the moves object to all `parts` doing nothing at once, beyond where the interval of any of their numbers
    ends; `bare`: the fit without them. Of several numbers, each may do nothing where the others make up for it."""
    far = _deviations(_errors(fitted, case, noise, floor), case)
    owner = [at for at, part in enumerate(fitted.model.parts) for _ in part.values]
    own = [float(far[k]) for k, at in enumerate(owner) if at in parts]
    return len(own) > 1 and math.sqrt(max(2.0 * (bare.loss - fitted.loss), 0.0)) > max(own)


def _others(
    fitted: ModelFit, case: MeasuredMoves, noise: Noise, rivals: Sequence[DurationModel]
) -> list[tuple[ModelFit, float]]:
    """Fits that explain as well, and how much worse they are in BIC."""
    # A form with more parameters is no less true for their price: what counts is how likely the moves are.
    found = [(way.fit, max(2.0 * (way.fit.loss - fitted.loss), 0.0)) for way in ways_of(fitted, case, noise)]
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
    of = {
        (part.label, p.name, p.unit, p.meaning): k
        for k, (part, p, _) in enumerate(parameters_of(other.model))
    }
    shared = [
        (k, of[key])
        for k, (part, p, _) in enumerate(parameters_of(fitted.model))
        if (key := (part.label, p.name, p.unit, p.meaning)) in of
    ]
    others = _ends(other, case, noise, floor, near, {at for _, at in shared})
    terms = parameters_of(other.model)
    for k, at in shared:
        null = _null_of(terms[at][1])
        if other.names == fitted.names and _holds(others[0][at], others[1][at], null):
            continue  # the term acts through the form's other parameters: this one tells nothing
        ends = (min(low[k], others[0][at]), max(high[k], others[1][at]))
        if other.names == fitted.names and _holds(*ends, null) and not _holds(low[k], high[k], null):
            continue  # neither way has the null: between them nothing is as likely
        low[k], high[k] = ends


def _null_of(parameter: TermParameter) -> float:
    """Where the parameter does nothing, in the scale of its interval: at infinity for a limit that is none."""
    if not parameter.log:
        return parameter.null
    return math.log(parameter.null) if parameter.null > 0 else -math.inf


def _holds(low: _Side, high: _Side, null: float) -> bool:
    """Whether an interval holds a null; one at infinity where nothing tells that end."""
    if math.isinf(null):
        return not (high if null > 0 else low).told
    return low.at <= null <= high.at


def _errors(fitted: ModelFit, case: MeasuredMoves, noise: Noise, floor: float) -> _Errors:
    """The larger of what scatter alone leaves and of what repeats of one move leave that have an error in common
    (cluster-robust; K.-Y. Liang, S. Zeger, Biometrika 73, 1986; J. MacKinnon, H. White, J. Econometrics 29, 1985;
    B. Moulton, J. Econometrics 32, 1986), and what a form leaves that is not quite the body's (a discrepancy,
    M. Kennedy, A. O'Hagan, J. Royal Statistical Society B 63, 2001)."""
    slopes = slopes_of(fitted.model, case, noise)
    scale = (FREEDOM + 1.0) / (FREEDOM + 3.0) / fitted.scale**2
    information = slopes.T @ slopes * scale
    size = np.sqrt(np.maximum(np.diag(information), 1e-300))
    inverse = np.linalg.pinv(information / np.outer(size, size), _TOLD) / np.outer(size, size)
    left = case.measured - fitted.model.seconds(case)
    residual = whiten(left, noise, case)
    pull = (FREEDOM + 1.0) / (FREEDOM + (residual / fitted.scale) ** 2) * residual / fitted.scale**2
    held = ((slopes @ inverse) * slopes).sum(axis=1) * scale
    robust = np.zeros(len(inverse))
    for cluster in _in_common(fitted, case, noise):
        scores = np.zeros((int(cluster.max()) + 1, slopes.shape[1]))
        np.add.at(scores, cluster, pull[:, None] * slopes)
        # Without a group the fit would have gone elsewhere by its score over what it does not hold itself: a jackknife.
        scores /= 1.0 - np.minimum(np.bincount(cluster, held), _HOLDS)[:, None]
        robust = np.maximum(robust, np.diag(inverse @ (scores.T @ scores) @ inverse))
        # Few groups may agree by chance: then what moves of a group have in common in the mean of all groups tells.
        share, sums = _alike(pull, cluster), np.zeros_like(scores)
        np.add.at(sums, cluster, slopes)
        mixed = (1.0 - share) * information + share * scale * (sums.T @ sums)
        robust = np.maximum(robust, np.diag(inverse @ mixed @ inverse))
    plain = np.maximum(np.diag(inverse), 0.0)
    # By the scale, which a few moves far off do not move: these tell nothing of the form.
    excess = (fitted.scale / floor) ** 2 - 1.0 if math.isfinite(floor) else 0.0
    excess = excess if excess > _MORE else 0.0  # less is chance
    missed = plain * (floor / fitted.scale) ** 2 * excess * len(case) / _PIECES if excess else 0.0
    known = np.diag(information) > 0
    whole = np.maximum(plain, robust) + missed
    return _Errors(np.where(known, np.sqrt(plain), 0.0), np.where(known, np.sqrt(whole), 0.0))


def _in_common(fitted: ModelFit, case: MeasuredMoves, noise: Noise) -> list[NDArray[np.int64]]:
    """(n,) each: the same number for moves that may have an error in common. They were programmed alike, or, where each
    duration was rounded by itself, last equally long and are rounded alike."""
    labels = [case.repeats if len(case.repeats) == len(case) else np.arange(len(case))]
    if (width := rounding_of(case, noise)) > 0:
        labels.append(np.round(fitted.model.seconds(case) / (_EQUALLY * width)).astype(np.int64))
    return [np.unique(one, return_inverse=True)[1] for one in labels]


def _alike(values: Floats, cluster: NDArray[np.int64]) -> float:
    """[1] share of the variance of `values` (n,) that the moves of a `cluster` (n,) have in common (the correlation
    within classes of R. Fisher, 1925, by an analysis of variance)."""
    count = np.bincount(cluster)
    free = len(values) - len(count)
    if free < _FREE:
        return 0.0
    within = float(((values - (np.bincount(cluster, values) / count)[cluster]) ** 2).sum()) / free
    return max(1.0 - within / max(float(values.var(ddof=1)), 1e-300), 0.0)


def _lattice_error(case: MeasuredMoves, cycle: float) -> float:
    """[s] of a cycle: the durations are m c + noise, so the variance is s² / Σ m² (a line through the origin)."""
    counts = np.round(case.measured / cycle)
    off = case.measured - counts * cycle
    return float(np.sqrt(np.mean(off**2) / max(float((counts**2).sum()), 1.0)))


# --- Ways ---
# Other ways in which the same terms explain a case as well: other values of the same form, and other forms.
#
# What the data do not choose between belongs into the intervals of all parameters that the ways have in common.

ALIKE = 6.0  # in BIC: what is no worse than that is not told apart
_GUESSES = 2  # of a form, that are fitted
_SETTLED = 2.0  # in BIC: "not worth more than a bare mention" by R. Kass and A. Raftery, JASA 90, 1995
_STEPS = 12


class AlternativeModel(NamedTuple):
    """Parts stand in the same places as those of the best model, except the one at `place`, which is another."""

    fit: ModelFit
    worse: float  # in BIC
    place: int

    @property
    def part(self) -> ModelPart:
        return self.fit.model.parts[self.place]


def ways_of(
    best: ModelFit, case: MeasuredMoves, noise: Noise, places: Collection[int] | None = None
) -> list[AlternativeModel]:
    """The best fits in which one part, of those at `places` where they are given, has another form of its term, or
    starts elsewhere in its own, the best first."""
    found = list[AlternativeModel]()
    for index in range(len(best.model.parts)) if places is None else places:
        part = best.model.parts[index]
        if part.term.name == LATTICE:
            continue
        others = {p.label for k, p in enumerate(best.model.parts) if k != index}
        for form in part.term.forms(case):
            parts = [
                ModelPart(part.term, form, values, part.condition) for values in part.term.guesses(form, case)
            ]
            if not parts or parts[0].label in others or (form.axis >= 0) != (part.form.axis >= 0):
                continue
            models = [_replaced(best.model, index, other) for other in parts]
            models.sort(key=lambda model: evaluate(model, case, noise).loss)
            dearer = penalty(models[0].parts, case) - penalty(best.model.parts, case)
            least = best.bic + ALIKE + max(dearer, 0.0)  # as good by BIC, or as likely
            tried = [fit(model, case, noise, _STEPS, below=least) for model in models[:_GUESSES]]
            closest = min(tried, key=lambda f: f.bic)
            if closest.bic < least:
                found.append(AlternativeModel(closest, max(closest.bic - best.bic, 0.0), index))
    return sorted(found, key=lambda way: way.worse)


def settled(best: ModelFit, case: MeasuredMoves, noise: Noise) -> ModelFit:
    """The same terms, each in the first of its forms that does as well with no more parameters: its plain law."""
    for index in range(len(best.model.parts)):
        part = best.model.parts[index]
        keys = [form.key for form in part.term.forms(case)]
        plainer = [
            way
            for way in ways_of(best, case, noise, (index,))
            if way.worse < _SETTLED
            and _key(way) in keys[: keys.index(part.form.key)]
            and len(way.part.values) <= len(part.values)
        ]
        if plainer:
            first = min(plainer, key=lambda way: keys.index(_key(way)))
            best = fit(first.fit.model, case, noise, 30)
    return best


def _key(way: AlternativeModel) -> str:
    return way.part.form.key


def _replaced(model: DurationModel, index: int, part: ModelPart) -> DurationModel:
    return DurationModel((*model.parts[:index], part, *model.parts[index + 1 :]))


# --- Profile ---
# How far a parameter can go before the data object, all others refitted: intervals by profile likelihood.
#
# A limit that few moves reach has no parabola around its best value: moves come under it one by one. Where the data
# never object, the side is open (D. Venzon, S. Moolgavkar, Applied Statistics 37, 1988).

_PROFILE_STEPS = 4  # of each refit
_TRIES = 6  # refits per side
_NEAR = 0.12  # of the distance that is looked for
_FIRST = 0.05  # of the room to the bound, where nothing tells how far to go
_QUICKLY = 4.0  # times as far, at most, from one try to the next
_BEHIND = (0.15, 0.4, 1.0)  # of the room behind an end: where the likelihood is asked again
_STEPS_BEHIND = 10
_LIKELY = 4  # starts


def distance(
    best: ModelFit, index: int, sign: int, error: float, deviations: float, case: MeasuredMoves, noise: Noise
) -> float:
    """[coordinate] to where the likelihood has fallen as far as `deviations` of a normal one; inf where it never does.

    `error`: standard error by the curvature at the best value, 0 where there is none.
    """
    place, low, high = place_of(best.model)
    room = float(high[index] - place[index] if sign > 0 else place[index] - low[index])
    if room <= 0:
        return math.inf

    def asked(model: DurationModel, at: float, steps: int = _PROFILE_STEPS) -> tuple[DurationModel, float]:
        there = moved(model, index, float(place[index]) + sign * at)
        tried = fit(there, case, noise, steps, held=index)
        return tried.model, math.sqrt(max(2.0 * (tried.loss - best.loss), 0.0))

    at = _nearest(best.model, asked, room, error, deviations)
    if math.isfinite(at) and math.isinf(parameters_of(best.model)[index][1].null):
        # A limit that fewer moves reach may do as well when others make up for it.
        starts = _starts(best.model, index, case)
        for share in _BEHIND:
            behind = at + share * (room - at)
            there = float(place[index]) + sign * behind
            likely = sorted(starts, key=lambda m: evaluate(moved(m, index, there), case, noise).loss)
            if any(asked(model, behind, _STEPS_BEHIND)[1] < deviations for model in likely[:_LIKELY]):
                at = behind if share < 1.0 else math.inf
    return at


def _starts(model: DurationModel, index: int, case: MeasuredMoves) -> list[DurationModel]:
    """The model, and, where the part of coordinate `index` has more than one, with its guesses at the others."""
    part = parameters_of(model)[index][0]
    if len(part.values) == 1:
        return [model]
    guessed = [part._replace(values=values) for values in part.term.guesses(part.form, case)]
    return [model, *(DurationModel(tuple(g if p is part else p for p in model.parts)) for g in guessed)]


def _nearest(
    model: DurationModel,
    asked: Callable[[DurationModel, float], tuple[DurationModel, float]],
    room: float,
    error: float,
    deviations: float,
) -> float:
    """[coordinate] to the first end."""
    at = min(deviations * error, room) if error > 0 else _FIRST * room
    inside, fallen_inside, outside, fallen_outside = 0.0, 0.0, math.inf, math.inf
    for _ in range(_TRIES):
        tried, fallen = asked(model, at)
        if abs(fallen - deviations) < _NEAR * deviations:
            return at * deviations / fallen
        if fallen < deviations:
            if at >= room:
                return math.inf
            inside, fallen_inside, model = at, fallen, tried
        else:
            outside, fallen_outside = at, fallen
        if math.isinf(outside):
            at = min(at * min(max(deviations / max(fallen, 1e-9), 1.5), _QUICKLY), room)
        else:
            share = (deviations - fallen_inside) / max(fallen_outside - fallen_inside, 1e-9)
            at = inside + (outside - inside) * min(max(share, 0.1), 0.9)
    return at
