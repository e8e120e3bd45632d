"""Least squares of a few quantities that bends for outliers, and the choice of which of them to learn."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

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
