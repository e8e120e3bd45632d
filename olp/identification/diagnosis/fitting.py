"""Fitting the parameters of several terms together, so that a few odd moves do not decide.

Residuals follow Student's t (K. Lange, R. Little, J. Taylor, "Robust statistical modeling using the t distribution",
JASA 84, 1989): like least squares near the middle, and far away a logarithm. The scale is fitted along, never below
what the recorder's resolution leaves. Steps are Levenberg and Marquardt's (D. Marquardt, SIAM J. Appl. Math. 11, 1963).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from olp.identification.diagnosis.model import FEATURES, DurationModel, ModelPart
from olp.timing.physics import MoveTerm, TermParameter
from olp.timing.physics._case import MeasuredMoves

Floats = NDArray[np.float64]

FREEDOM = 6.0  # of Student's t
_DENSITY = math.gamma(3.5) / (math.sqrt(FREEDOM * math.pi) * math.gamma(3.0))  # in the middle of it
_ALIKE = 0.02  # of a width: durations that scatter by less are rounded alike
_SCALES = 40  # that are tried
LATTICE = "cycle-quantisation"  # its mean has a slope that says nothing of the cycle
_STEP = 1e-5  # of a parameter's span, for differences
_ROUNDS = 4  # of the scale's fixed point
_FINEST = 64.0  # times as long as the last step along a coordinate is the first
_WHOLE = 0.12  # of a cycle: with less scatter, durations are rounded as they should be
ROUNDED = 1e-9  # of the largest of some values: what is nearer together may be equal but for rounding
_NOTHING = 1e-18  # share of a number that changes none of its digits
_QUICK = 10  # steps: who asks for no more compares many fits
# No step is expected to gain more than so many times what the one before gained, or its slopes told. But where slopes
# explain a fifth of the square of what is left, a gain of a tenth of the moves, a fit closes in: the logarithm of what
# is left falls the faster then, and nobody can know how far.
_AT_MOST, _CLOSES_IN = 2.0, 0.1
_ENOUGH, _LAST = 0.02, 1e-4  # of a step's gain in log-likelihood, for those and for others: less ends the fit


class Noise(NamedTuple):
    """What is known of the scatter before anything is fitted."""

    least: float  # [s] no fit may claim less
    order: float = 0.0  # [1] correlation of one residual with the one before it, in order of execution


class ModelFit(NamedTuple):
    """A model with its best values. `loss`: minus the logarithm of the likelihood, less a constant."""

    model: DurationModel
    loss: float
    scale: float  # [s] of the scatter
    bic: float

    @property
    def names(self) -> tuple[str, ...]:
        """Of the terms, sorted, each once."""
        return tuple(sorted({part.term.name for part in self.model.parts}))

    @property
    def labels(self) -> frozenset[str]:
        return frozenset(part.label for part in self.model.parts)


class _Kept(NamedTuple):
    """A fit that a case keeps, and of how many steps asked for, at least and at most, it is what comes of them."""

    fit: ModelFit
    least: int
    most: float


def whiten(values: Floats, noise: Noise, case: MeasuredMoves) -> Floats:
    """(n, …) with the same scatter, free of what the move before foretells of it.

    Durations that are differences of shared time stamps lose what their neighbour wins: a moving average of order one,
    whose correlation is between -1/2 and 0 (G. Box, G. Jenkins, Time Series Analysis, 1970, section 3.3). What is left
    of a slow cause goes together: an autoregression of order one (D. Cochrane, G. Orcutt, JASA 44, 1949).
    """
    if noise.order == 0.0:
        return values
    name = f"whitener {noise.order}"
    gain, *carried = case.once(name, lambda: _whitener(noise.order, case.follows).ravel()).reshape(
        -1, len(case)
    )
    columns = (len(case), *(1,) * (values.ndim - 1))
    result = gain.reshape(columns) * values
    if noise.order > 0:
        result[1:] += carried[0][1:].reshape(-1, *columns[1:]) * values[:-1]
        return result
    for level, share in enumerate(carried):
        # Rows hold what the 2^level rows up to them bring, and get what as many before these bring.
        result[1 << level :] += share[1 << level :].reshape(-1, *columns[1:]) * result[: -1 << level]
    return result


def unlikely_in_order(left: Floats, order: float, case: MeasuredMoves) -> float:
    """Minus the logarithm of the likelihood, less a constant, of what is left (n,) [s] where neighbours that share
    their time stamps have a correlation `order`, from -1/2 to 0."""
    gain = _whitener(order, case.follows)[0]  # what one of its products is, per value
    return loss_of(whiten(left, Noise(0.0, order), case), _NOTHING)[0] - float(np.log(gain).sum())


def _whitener(order: float, follows: NDArray[np.bool_]) -> Floats:
    """(k, n) of products that have variance one: what a row's own value counts, then, of `follows` (n,) right behind
    the row before: with order above 0 what the value before counts; below 0, for each power of two, what the product
    so many rows before counts (a recursion by doubling: D. Hillis, G. Steele, Communications of the ACM 29, 1986)."""
    behind = follows & (np.arange(len(follows)) > 0)
    if order > 0:
        size = np.sqrt(1.0 - order**2)
        return np.stack([np.where(behind, 1.0 / size, 1.0), np.where(behind, -order / size, 0.0)])
    variance = np.ones(len(behind))  # of what a row has that the rows before it do not foretell
    for row in np.flatnonzero(behind).tolist():
        variance[row] -= order**2 / variance[row - 1]
    levels = [1.0 / np.sqrt(variance)]
    share = np.where(behind, -order * levels[0] * np.roll(levels[0], 1), 0.0)
    far = 1
    while share.any():
        levels.append(share)
        share = np.where(np.arange(len(share)) < far, 0.0, share * np.roll(share, far))
        share[np.abs(share) < _NOTHING] = 0.0
        far *= 2
    return np.stack(levels)


def loss_of(residual: Floats, least: float, start: float = 0.0) -> tuple[float, float]:
    """Loss and scale [s] of residuals (n,), the scale at its best."""
    square = residual**2
    scale = start if start > 0 else max(1.4826 * _median(np.abs(residual)), least)
    for _ in range(_ROUNDS):
        weight = (FREEDOM + 1.0) / (FREEDOM + square / scale**2)
        mean = np.add.reduce(weight * square) / len(
            square
        )  # as `mean` does, which takes as long again to say so
        scale = max(math.sqrt(mean), least)
    far = 0.5 * (FREEDOM + 1.0) * np.log1p(square / (FREEDOM * scale**2))
    return float(far.sum() + len(residual) * np.log(scale)), scale


def losses_of(residuals: Floats, least: float) -> tuple[Floats, Floats]:
    """(k,) each: `loss_of` of residuals (k, n), to the last bit."""
    square = np.ascontiguousarray(residuals) ** 2
    scale = np.array([max(1.4826 * _median(one), least) for one in np.abs(residuals)])
    for _ in range(_ROUNDS):
        weight = (FREEDOM + 1.0) / (FREEDOM + square / (scale**2)[:, None])
        scale = np.maximum(np.sqrt(np.add.reduce(weight * square, axis=1) / square.shape[1]), least)
    far = 0.5 * (FREEDOM + 1.0) * np.log1p(square / (FREEDOM * scale**2)[:, None])
    return far.sum(axis=1) + square.shape[1] * np.log(scale), scale


def _median(values: Floats) -> float:
    """What `np.median` says of a few hundred values, which takes three times as long."""
    ordered, middle = np.sort(values), len(values) // 2
    if not len(values) or ordered[-1] != ordered[-1]:  # nan sorts behind all
        return math.nan
    return float(ordered[middle] if len(values) % 2 else (ordered[middle - 1] + ordered[middle]) / 2.0)


def loss_each(residual: Floats, scale: float, width: float) -> Floats:
    """(n,) minus log-likelihood of residuals (n,) [s] of durations that scatter by `scale` [s] and were then rounded to
    `width` [s]: within half a width of the truth, rounded durations tell nothing (D. Heitjan, D. Rubin, Annals of
    Statistics 19, 1991). Less a constant."""
    if not width > 0:
        return np.asarray(
            0.5 * (FREEDOM + 1.0) * np.log1p((residual / scale) ** 2 / FREEDOM) + math.log(scale)
        )
    off, half = np.abs(residual) / scale, 0.5 * width / scale
    far = _DENSITY * (1.0 + (off + half) ** 2 / FREEDOM) ** (-0.5 * (FREEDOM + 1.0))
    # Beyond what differences of the distribution resolve, its lowest density within the width.
    between = np.maximum(_below(off + half) - _below(off - half), 2.0 * half * far)
    return np.asarray(-np.log(between / width / _DENSITY))


def _below(x: Floats) -> Floats:
    """Distribution of Student's t with 6 degrees of freedom (M. Abramowitz, I. Stegun, 1964, 26.7.4)."""
    share = FREEDOM / (FREEDOM + x**2)
    return np.asarray(0.5 + 0.5 * x / np.sqrt(FREEDOM + x**2) * (1.0 + 0.5 * share + 0.375 * share**2))


def rounding_of(case: MeasuredMoves, noise: Noise) -> float:
    """[s] to which each duration was rounded by itself; 0 where neighbours share what rounding leaves."""
    return case.resolution if noise.order == 0.0 else 0.0


def scale_before_rounding(fitted: ModelFit, case: MeasuredMoves, noise: Noise) -> float:
    """[s] the likeliest scatter of what a fit leaves, before durations were rounded."""
    width = rounding_of(case, noise)
    if not width > 0:
        return fitted.scale
    left = case.measured - fitted.model.seconds(case)
    tried = np.geomspace(min(_ALIKE * width, fitted.scale), fitted.scale, _SCALES)
    return min(map(float, tried), key=lambda scale: float(loss_each(left, scale, width).sum()))


def rounded_bic(fitted: ModelFit, case: MeasuredMoves, noise: Noise) -> float:
    """BIC of durations that were rounded: moves that are rounded alike tell once what they tell, not once each."""
    width = rounding_of(case, noise)
    if not width > 0:
        return fitted.bic
    left = case.measured - fitted.model.seconds(case)
    loss = loss_each(left, scale_before_rounding(fitted, case, noise), width).sum()
    return 2.0 * float(loss) + penalty(fitted.model.parts, case)


def penalty(parts: Sequence[ModelPart], case: MeasuredMoves) -> float:
    """What the parts cost in BIC: log n per parameter and per bound of a condition, and the choice between a term's
    forms and between the columns that conditions can be about."""
    said = sum(len(part.condition.statements) for part in parts if part.condition is not None)
    count = sum(len(part.form.parameters) for part in parts) + said
    forms = sum(2.0 * np.log(_choices(part.term, case)) for part in parts)
    return float(count * np.log(len(case)) + forms + 2.0 * said * np.log(len(FEATURES)))


def _choices(term: MoveTerm, case: MeasuredMoves) -> float:
    """[1] Forms of a term, at least one."""
    count = case.once(
        f"forms {term.name}", lambda: np.array([max(len(term.forms(case)), 1)], dtype=np.float64)
    )
    return float(count[0])


def ranks(values: Floats) -> NDArray[np.int64]:
    """(n,) 0 for the lowest of `values` (n,), one more behind each gap that is more than rounding: what is equal on
    paper has one rank on every machine, and its order is then a stated one."""
    if not len(values):
        return np.zeros(0, dtype=np.int64)
    known = np.isfinite(values)
    near = ROUNDED * float(np.abs(values[known]).max(initial=0.0))
    order = np.argsort(values, kind="stable")
    ordered = values[order]
    with np.errstate(invalid="ignore"):  # of two that are infinite
        apart = np.diff(ordered) > near
    result = np.empty(len(values), dtype=np.int64)
    result[order] = np.concatenate([[0], np.cumsum(apart)])
    return result


def as_large(values: Floats) -> NDArray[np.bool_]:
    """(n,) which of `values` (n,) are as large as any, but for rounding."""
    known = np.abs(values[np.isfinite(values)])
    return np.asarray(values >= float(values.max()) - ROUNDED * float(known.max(initial=0.0)))


def largest(values: Floats) -> int:
    """The first of `values` (n,) that is as large as any, but for rounding."""
    return int(np.argmax(as_large(values)))


def evaluate(model: DurationModel, case: MeasuredMoves, noise: Noise) -> ModelFit:
    """A model as it stands, nothing fitted but the scale."""
    return _judged(model, case.measured - model.seconds(case), case, noise)


def fit(
    model: DurationModel,
    case: MeasuredMoves,
    noise: Noise,
    steps: int = 10,
    held: int = -1,
    below: float = math.inf,
) -> ModelFit:
    """The best values near those of `model`; the coordinate `held` stays where it is. A case keeps what came of it,
    also for who allows more steps than were worth it.

    `below`: the BIC from which on the fit is of no use. It is given up where steps gain too little to get there.
    """
    if not model.parts:
        return evaluate(model, case, noise)
    parts = tuple((p.term.name, p.form, p.values.tobytes(), p.condition) for p in model.parts)
    key = (parts, noise, held, steps <= _QUICK)
    known = case.fits.get(key)
    if isinstance(known, _Kept) and known.least <= steps <= known.most:
        return known.fit
    found, enough = _fitted(model, case, noise, steps, held, below)
    if enough is not None:
        case.keep(key, _Kept(found, enough or steps, math.inf if enough else steps))
    return found


def _fitted(
    model: DurationModel, case: MeasuredMoves, noise: Noise, steps: int, held: int, below: float
) -> tuple[ModelFit, int | None]:
    """The best values, and the steps after which none was worth another one; 0 where more might have been, None where
    the fit was given up."""
    enough = 0
    place, damping = _pack(model), 1e-3
    seconds, smooth = model.both(case)
    best = _judged(model, case.measured - seconds, case, noise)
    residual = whiten(case.measured - seconds, noise, case)
    low, high = _bounds(model)
    still = [k for k, (p, _, _) in enumerate(parameters_of(model)) if k == held or p.term.name == LATTICE]
    for step in range(1, steps + 1):
        slopes = _slopes(model, place, (low, high), smooth, case, noise, still)
        weight = (FREEDOM + 1.0) / (FREEDOM + (residual / best.scale) ** 2)
        normal = slopes.T @ (weight[:, None] * slopes)
        pull = slopes.T @ (weight * residual)
        before, gained = best, 0.0
        for _ in range(5):
            grown = normal.copy()
            grown.flat[:: len(normal) + 1] += damping * np.maximum(normal.diagonal(), 1e-12)
            try:
                tried = _bounded(grown, pull, place, low, high)
            except np.linalg.LinAlgError:
                break
            candidate = _unpack(model, tried)
            seconds, between = candidate.both(case)
            left = whiten(case.measured - seconds, noise, case)
            loss, scale = loss_of(left, noise.least, best.scale)
            if loss < best.loss - 1e-9:
                gained = best.loss - loss
                place, residual, smooth, model = tried, left, between, candidate
                best = ModelFit(model, loss, scale, best.bic + 2.0 * (loss - best.loss))
                damping = max(damping / 10.0, 1e-9)
                break
            damping *= 10.0
        if gained < (_ENOUGH if steps <= _QUICK else _LAST):
            enough = step
            break
        if smooth is seconds and (missing := 0.5 * (best.bic - below)) > _AT_MOST * gained * (steps - step):
            told = max(gained, _told(normal, pull) / before.scale**2)
            if told < _CLOSES_IN * len(case) and missing > _AT_MOST * told * (steps - step):
                return best, None
    if smooth is seconds or (steps <= _QUICK and best.scale < _WHOLE * model.motion(case).cycle):
        return best, enough
    return _stepped(best, place, (low, high), case, noise, held), enough


def _told(normal: Floats, pull: Floats) -> float:
    """[s²] what slopes tell, to first order, that a fit gains in log-likelihood, times the square of its scale."""
    return 0.5 * float(pull @ np.linalg.lstsq(normal, pull, rcond=1e-9)[0])


def _stepped(
    best: ModelFit,
    place: Floats,
    bounds: tuple[Floats, Floats],
    case: MeasuredMoves,
    noise: Noise,
    held: int,
) -> ModelFit:
    """The best of steps along each coordinate, half as long where none is better: durations that are rounded to a cycle
    have no slope to follow (R. Hooke, T. Jeeves, Journal of the ACM 8, 1961)."""
    slopes = _slopes(best.model, place, bounds, best.model.smooth(case), case, noise)
    cost = penalty(best.model.parts, case)
    for k, (part, parameter, value) in enumerate(parameters_of(best.model)):
        if part.term.name == LATTICE:  # as many cycles as a move has
            slopes[:, k] = case.simulated / (1.0 if parameter.log else value)
    size = np.sqrt(np.mean(slopes**2, axis=0))
    free = [k for k in range(len(place)) if k != held and size[k] > 0]
    if not free:
        return best
    length, least = best.scale, best.scale / _FINEST
    while length > least:
        better, trials = best, []
        for k in free:
            for sign in (-1.0, 1.0):
                tried = place.copy()
                tried[k] = np.clip(place[k] + sign * length / size[k], bounds[0][k], bounds[1][k])
                trials.append((k, tried))
        here = _unpack(best.model, place)
        changes = [_changed(best.model, k, tried) for k, tried in trials]
        seconds = np.stack([whole for whole, _ in here.both_with(changes, case)], axis=1)
        losses, scales = losses_of(whiten(case.measured[:, None] - seconds, noise, case).T, noise.least)
        for (_, tried), loss, scale in zip(trials, losses.tolist(), scales.tolist(), strict=True):
            if loss < better.loss - _ENOUGH:
                better, step = ModelFit(_unpack(best.model, tried), loss, scale, 2.0 * loss + cost), tried
        if better is best:
            length /= 2.0
        else:
            best, place = better, step
    return best


def _bounded(normal: Floats, pull: Floats, place: Floats, low: Floats, high: Floats) -> Floats:
    """(p,) where a step leads; coordinates that it takes beyond a bound stay there, and the others make up for it."""
    tried = place + np.linalg.solve(normal, pull)
    out = (tried < low) | (tried > high)
    if not out.any() or out.all():
        return np.minimum(np.maximum(tried, low), high)  # as `clip` does, which takes as long again to say so
    fixed = np.clip(tried, low, high)[out] - place[out]
    step = np.linalg.solve(normal[np.ix_(~out, ~out)], pull[~out] - normal[np.ix_(~out, out)] @ fixed)
    tried[~out] = place[~out] + step
    return np.clip(tried, low, high)


def _judged(model: DurationModel, residual: Floats, case: MeasuredMoves, noise: Noise) -> ModelFit:
    loss, scale = loss_of(whiten(residual, noise, case), noise.least)
    return ModelFit(model, loss, scale, 2.0 * loss + penalty(model.parts, case))


def slopes_of(model: DurationModel, case: MeasuredMoves, noise: Noise) -> Floats:
    """(n, p) of the whitened prediction by the search's coordinates, at the model's values."""
    return _slopes(model, _pack(model), _bounds(model), model.smooth(case), case, noise)


def place_of(model: DurationModel) -> tuple[Floats, Floats, Floats]:
    """(p,) each: the values in the search's coordinates, and their bounds."""
    return _pack(model), *_bounds(model)


def moved(model: DurationModel, index: int, coordinate: float) -> DurationModel:
    """The model with one of the search's coordinates somewhere else."""
    place = _pack(model)
    place[index] = coordinate
    return _unpack(model, place)


def parameters_of(model: DurationModel) -> list[tuple[ModelPart, TermParameter, float]]:
    """All parameters in the order of the search's coordinates."""
    return [(p, q, float(v)) for p in model.parts for q, v in zip(p.form.parameters, p.values, strict=True)]


def _slopes(
    model: DurationModel,
    place: Floats,
    bounds: tuple[Floats, Floats],
    here: Floats,
    case: MeasuredMoves,
    noise: Noise,
    still: Sequence[int] = (),
) -> Floats:
    """(n, p) by differences, 0 for what is listed or stays `still`; `here`: the smooth prediction at `place`."""
    low, high = bounds
    steps, changes, free, first = [], [], [], 0
    for owner, part in enumerate(model.parts):
        last = first + len(part.form.parameters)
        for index in range(first, last):
            if part.form.parameters[index - first].listed or index in still:
                continue
            step = _STEP * (high[index] - low[index])
            steps.append(-step if place[index] + step > high[index] else step)
            moved = place[first:last].copy()
            moved[index - first] += steps[-1]
            changes.append((owner, _placed(part, moved)))
            free.append(index)
        first = last
    there = _unpack(model, place).smooth_with(changes, case)
    columns = np.zeros((len(case), len(place)))
    for index, one, step in zip(free, there, steps, strict=True):
        columns[:, index] = (one - here) / step
    return whiten(columns, noise, case)


def _pack(model: DurationModel) -> Floats:
    return np.array([np.log(value) if p.log else value for _, p, value in parameters_of(model)])


def _bounds(model: DurationModel) -> tuple[Floats, Floats]:
    of = [p for _, p, _ in parameters_of(model)]
    low = np.array([np.log(p.low) if p.log else p.low for p in of])
    return low, np.array([np.log(p.high) if p.log else p.high for p in of])


def _unpack(model: DurationModel, place: Floats) -> DurationModel:
    parts, at = [], 0
    for part in model.parts:
        width = len(part.form.parameters)
        parts.append(_placed(part, place[at : at + width]))
        at += width
    return DurationModel(tuple(parts))


def _changed(model: DurationModel, coordinate: int, place: Floats) -> tuple[int, ModelPart]:
    """The part that owns one of the search's coordinates, at `place` (p,), and its number."""
    first = 0
    for owner, part in enumerate(model.parts):
        last = first + len(part.form.parameters)
        if coordinate < last:
            return owner, _placed(part, place[first:last])
        first = last
    raise IndexError(coordinate)


def _placed(part: ModelPart, coordinates: Floats) -> ModelPart:
    """The part at the search's coordinates (p,) of its own parameters."""
    values, log = coordinates.copy(), [k for k, p in enumerate(part.form.parameters) if p.log]
    if log:
        values[log] = np.exp(values[log])
    return ModelPart(part.term, part.form, values, part.condition)
