"""What a signature knows beside straight moves from stop to stop: a few learnt quantities per kind of move.

Every part corrects olp's own model of constant acceleration, so that nothing learnt means the model as it is.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from olp.identification.signature.errors import Spread, spread_of


class LearntParameter(NamedTuple):
    """One learnt quantity as the file holds it: a number or nested lists of numbers or names."""

    value: Any
    unit: str
    sd: Any = None  # standard deviation in the same shape, None where it cannot be told


Parameters = Mapping[str, LearntParameter]


# --- Robust ---
# Least squares of a few quantities that bends for outliers, and the choice of which of them to learn.

Floats = NDArray[np.float64]
Labels = NDArray[np.int64]
Model = Callable[[Floats], Floats]  # quantities (p,) -> (n,)

_STEPS = 40
_BEND = 1.5  # standard deviations from which on a residual counts by its size (P. J. Huber, 1964)
_TINY = 1e-9
_EQUAL = 0.05  # five percent between two forms say nothing: the one named first is taken


class Solved(NamedTuple):
    values: Floats  # (p,)
    sd: Floats  # (p,) 0 for those that were not free


class FormChoice(NamedTuple):
    """`form`: which quantities were learnt. `errors` (n,): measured less predicted, each without its own fold."""

    form: tuple[int, ...]
    solved: Solved
    errors: Floats
    plain: Floats  # (n,) the same with nothing learnt


def solve(model: Model, start: Floats, form: tuple[int, ...], measured: Floats, lowest: Floats) -> Solved:
    """Gauss-Newton steps with Huber weights on the quantities `form`, none below `lowest` (p,)."""
    values, free = start.copy(), list(form)
    sd = np.zeros_like(values)
    if not free:
        return Solved(values, sd)
    for _ in range(_STEPS):
        off = measured - model(values)
        slope, weight = _slopes(model, values, free), _weights(off)
        step = np.linalg.pinv(slope.T @ (weight[:, None] * slope)) @ (slope.T @ (weight * off))
        after = np.maximum(values[free] + step, lowest[free])
        moved = float(np.max(np.abs(after - values[free]) / (np.abs(values[free]) + 1e-6)))
        values[free] = after
        if moved < _TINY:
            break
    off = measured - model(values)
    slope, weight = _slopes(model, values, free), _weights(off)
    freedom = max(len(measured) - len(free), 1)
    spread = float(np.sum(weight * off * off)) / freedom
    covariance = np.linalg.pinv(slope.T @ (weight[:, None] * slope)) * spread
    sd[free] = np.sqrt(np.maximum(np.diag(covariance), 0.0))
    return Solved(values, sd)


def choose(
    model: Model,
    start: Floats,
    forms: tuple[tuple[int, ...], ...],
    measured: Floats,
    folds: Labels,
    lowest: Floats,
) -> FormChoice:
    """The form that predicts held-out rows best; of those that are equally good, the one named first.

    `folds` (n,): rows of one number are held out together. A form that some fold leaves too few rows for is not tried.
    """
    held: dict[tuple[int, ...], Floats] = {}
    for form in forms:
        errors = np.full(len(measured), np.nan)
        for fold in np.unique(folds).tolist():
            rest = folds != fold
            if rest.sum() <= len(form):
                break
            found = solve(lambda q, r=rest: model(q)[r], start, form, measured[rest], lowest)  # type: ignore[misc]
            errors[~rest] = (measured - model(found.values))[~rest]
        if np.isfinite(errors).all():
            held[form] = errors
    size = {form: np.log(np.mean(np.abs(errors)) + _TINY) for form, errors in held.items()}
    best = min(size.values())
    chosen = next(form for form in held if size[form] <= best + _EQUAL)
    return FormChoice(
        chosen, solve(model, start, chosen, measured, lowest), held[chosen], measured - model(start)
    )


def _weights(off: Floats) -> Floats:
    scale = max(1.4826 * float(np.median(np.abs(off))), _TINY)
    return np.asarray(np.minimum(1.0, _BEND * scale / np.maximum(np.abs(off), _TINY)))


def _slopes(model: Model, values: Floats, free: list[int]) -> Floats:
    columns = []
    for i in free:
        step = 1e-6 * max(1.0, abs(float(values[i])))
        high, low = values.copy(), values.copy()
        high[i] += step
        low[i] -= step
        columns.append((model(high) - model(low)) / (2 * step))
    return np.stack(columns, axis=1)


# --- Coefficients ---

STOP, JOINT, CIRCULAR, CORNER = "stop", "joint", "circular", "corner"
TERMS = "terms"  # of method named_terms: nothing learnt beside the terms, but how wrong they are [s]
FEWEST = 4  # rows that a part is learnt from
_FOLDS = 10
_MANY = 40


class LearntQuantity(NamedTuple):
    name: str
    unit: str
    plain: float  # what it is when nothing was learnt
    lowest: float


class CorrectionKind(NamedTuple):
    """`forms`: which quantities may be learnt together, the simplest first."""

    name: str
    quantities: tuple[LearntQuantity, ...]
    forms: tuple[tuple[int, ...], ...]


_SCALE = LearntQuantity("acceleration_time_scale", "1", 1.0, 0.05)
_FIXED = LearntQuantity("fixed_time", "s", 0.0, -1.0)
KINDS: Mapping[str, CorrectionKind] = {
    kind.name: kind
    for kind in (
        CorrectionKind(
            STOP,
            (LearntQuantity("fixed_time", "s", 0.0, 0.0), LearntQuantity("slowness", "s²/m", 0.3, 1e-9)),
            ((1,), (0, 1)),
        ),
        CorrectionKind(JOINT, (_SCALE, _FIXED), ((), (0,), (1,), (0, 1))),
        CorrectionKind(CIRCULAR, (_SCALE, _FIXED), ((), (0,), (1,), (0, 1))),
        CorrectionKind(
            CORNER,
            (
                LearntQuantity("saving_scale", "1", 1.0, 0.0),
                LearntQuantity("stretch_time", "s", 0.0, -10.0),
                LearntQuantity("corner_time", "s", 0.0, -10.0),
            ),
            ((), (0,), (1,), (2,), (0, 1), (0, 2), (1, 2), (0, 1, 2)),
        ),
        CorrectionKind(TERMS, (), ((),)),
    )
}


class CorrectionPart(NamedTuple):
    """Learnt `quantities` by name; held-out errors in s.

    `rows`: rows (stretches, for corners) it was learnt from; `longest` [s]: of them. `row_half` [s]: half-width that
    95 % of the rows of held-out stretches kept. `unlearnt`, `learnt`: held-out mean absolute errors [%] without and
    with the part. `law`: the blending law of the corners.
    """

    quantities: Mapping[str, LearntParameter]
    spread: Spread
    row_half: float
    rows: int
    longest: float
    unlearnt: float
    learnt: float
    law: str = ""

    def value(self, name: str) -> float:
        return float(self.quantities[name].value)


Parts = Mapping[str, CorrectionPart]


def value_of(parts: Parts, kind: str, name: str) -> float:
    """A learnt quantity, or what it is when nothing was learnt."""
    if kind in parts:
        return parts[kind].value(name)
    return next(q.plain for q in KINDS[kind].quantities if q.name == name)


def learn_part(
    kind: str, model: Model, measured: Floats, groups: Labels, plain: Floats | None = None, law: str = ""
) -> tuple[CorrectionPart, FormChoice]:
    """From `measured` (n,) [s], n >= FEWEST; `groups` (n,): rows of one program. `plain`: instead of the kind's own."""
    known = KINDS[kind]
    start = np.array([q.plain for q in known.quantities]) if plain is None else plain
    lowest = np.array([q.lowest for q in known.quantities])
    folds = np.arange(len(measured), dtype=np.int64) % min(_FOLDS, len(measured))
    found = choose(model, start, known.forms, measured, folds, lowest)
    spread = spread_of(found.errors, groups)
    spread = spread._replace(half=max(spread.half, half_of_few(found.errors)))
    quantities = {
        q.name: LearntParameter(float(value), q.unit, float(sd) if i in found.form else None)
        for i, (q, value, sd) in enumerate(
            zip(known.quantities, found.solved.values, found.solved.sd, strict=True)
        )
    }
    before, after = (100.0 * float(np.mean(np.abs(e) / measured)) for e in (found.plain, found.errors))
    longest = float(np.max(measured))
    part = CorrectionPart(quantities, spread, spread.half, len(measured), longest, before, after, law)
    return part, found


def half_of_few(errors: Floats) -> float:
    """[s] half-width by Student's t: of few errors the largest one covers less than 95 %. 0 of many."""
    if len(errors) >= _MANY:
        return 0.0
    own = float(np.sqrt(np.mean(errors**2)))
    return own * Spread(own, 0.0, own, len(errors) - 1).quantile
