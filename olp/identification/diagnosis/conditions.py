"""Where a term acts: regions, directions, lines, times, found and confirmed like the term itself.

A condition is one or two plain statements about a move ("y > 150 mm", "line 114"). All statements are tried with all
terms at once, to first order; the promising ones are fitted, and their bounds go to where the moves' own likelihoods
want them. A statement costs as much in BIC as a parameter and the choice among the columns that there were.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from olp.identification.diagnosis.fitting import FREEDOM, ModelFit, Noise, fit
from olp.identification.diagnosis.model import (
    FEATURES,
    Condition,
    DurationModel,
    ModelPart,
    Statement,
    feature,
)
from olp.identification.diagnosis.search import TELLING, PartShelf, price
from olp.timing.physics._case import MeasuredMoves

Floats = NDArray[np.float64]
Mask = NDArray[np.bool_]

_FEWEST = 5  # moves inside, and outside
_CUTS = 9  # places where a column is cut at first
_ROUNDS = 2  # of fitting values and moving bounds
_MOST = 40  # words of a column that are tried
_WORTH = 30.0  # [1] what is left promises more, else all that there is to tell is told
_LEFT = 0.6  # of the mean square that is left without a condition: with one it is less
_FIRST, _MORE = 40, 1.1  # of each part to be fitted, and times what one statement explains
_SECOND = 6  # statements to which a second one is tried
_PARTS = 3  # of a term and its statements that are fitted


_Key = tuple[str, str, tuple[tuple[str, bool, str], ...]]


class _Tried(NamedTuple):
    gain: float  # [1] of the sum of squares, in units of the scatter's variance
    part: ModelPart


def conditioned(best: ModelFit, case: MeasuredMoves, noise: Noise, shelf: PartShelf, count: int) -> ModelFit:
    """The fit, or one in which a term under a condition is beside its parts, or in the place of one or all of them."""
    if len(case) < 4 * _FEWEST:
        return best
    statements = list(_statements(case))
    if not statements:
        return best
    masks = np.stack([s.mask(case) for s in statements], axis=1)
    beside = _promising(best, case, shelf, statements, masks, count)
    if not beside or beside[0].gain < _WORTH:
        return best  # there is nothing left to be told
    winner = _better(best, best, beside, case, noise)
    alone = [m for m in (best.model.without(k) for k in range(len(best.model.parts))) if m.parts]
    for model in (DurationModel(), *alone) if best.model.parts else ():
        bare = fit(model, case, noise, 8)
        tried = _promising(bare, case, shelf, statements, masks, count)
        winner = _better(winner, bare, tried, case, noise)
    if winner is best:
        return best
    left, without = (float(np.mean((case.measured - f.model.seconds(case)) ** 2)) for f in (winner, best))
    return winner if price(best) - price(winner) > TELLING and left < _LEFT * without else best


def _better(
    winner: ModelFit, bare: ModelFit, tried: list[_Tried], case: MeasuredMoves, noise: Noise
) -> ModelFit:
    """The winner, or a fit with one of the parts beside `bare` that is better."""
    return min([winner, *(_fitted(bare, one.part, case, noise) for one in tried)], key=price)


def _statements(case: MeasuredMoves) -> Iterator[Statement]:
    """All that can be said of some moves and not of others."""
    for name in FEATURES:
        values = feature(case, name)
        if isinstance(values, tuple):
            words = [w for w in dict.fromkeys(values) if w]
            if 2 <= len(words) <= _MOST:
                yield from (Statement(name, word=word) for word in words)
            continue
        known = np.unique(values[np.isfinite(values)])
        if len(known) < 2:
            continue
        cuts = np.quantile(values[np.isfinite(values)], np.linspace(0, 1, _CUTS + 2)[1:-1])
        for cut in np.unique(np.searchsorted(known, cuts)).tolist():
            if 0 < cut < len(known):
                middle = 0.5 * float(known[cut - 1] + known[cut])
                yield Statement(name, above=middle)
                yield Statement(name, below=middle)


def _promising(
    bare: ModelFit,
    case: MeasuredMoves,
    shelf: PartShelf,
    statements: list[Statement],
    masks: Mask,
    count: int,
) -> list[_Tried]:
    """Terms under one or two statements, by what their columns explain of the residual inside them."""
    residual = case.measured - bare.model.seconds(case)
    weight = (FREEDOM + 1.0) / (FREEDOM + (residual / bare.scale) ** 2)
    inside = masks.sum(axis=0)
    fair = (inside >= _FEWEST) & (inside <= len(case) - _FEWEST)
    used = set(bare.labels)
    free = [k for k, p in enumerate(shelf.parts) if p.conditionable and p.label not in used]
    if not free or not fair.any():
        return []
    columns = shelf.columns[:, free]
    pulled, squared = columns * (weight * residual)[:, None], columns**2 * weight[:, None]
    either = np.array([shelf.parts[k].reversible for k in free])[:, None]
    pull = pulled.T @ masks
    gain = _gain(np.where(either, pull, np.maximum(pull, 0.0)), squared.T @ masks)
    gain[:, ~fair] = 0.0
    tried, seconds = dict[_Key, _Tried](), 0
    for at in np.argsort(-gain, axis=None)[: _FIRST * count].tolist():
        row, column = divmod(at, gain.shape[1])
        part, statement = shelf.parts[free[row]], statements[column]
        _note(tried, gain[row, column], part._replace(condition=Condition((statement,))))
        if seconds >= _SECOND * count:
            continue
        seconds += 1
        both = masks & masks[:, [column]]
        pull = pulled[:, row] @ both
        more = _gain(pull if either[row, 0] else np.maximum(pull, 0.0), squared[:, row] @ both)
        more[(both.sum(axis=0) < _FEWEST) | ~fair] = 0.0
        for second in np.argsort(-more)[:4].tolist():
            if statements[second].column != statement.column and more[second] > _MORE * gain[row, column]:
                pair = Condition(tuple(sorted((statement, statements[second]), key=lambda s: s.column)))
                _note(tried, float(more[second]), part._replace(condition=pair))
    found, seen = list[_Tried](), Counter[str]()
    for one in sorted(tried.values(), key=lambda t: -t.gain):
        seen[one.part.label] += 1
        if seen[one.part.label] <= _PARTS and len(found) < count:
            found.append(_Tried(one.gain / bare.scale**2, one.part))
    return found


def _note(tried: dict[_Key, _Tried], gain: float, part: ModelPart) -> None:
    """The best guess of each form under the same columns."""
    key = _key(part)
    if key not in tried or gain > tried[key].gain:
        tried[key] = _Tried(gain, part)


def _key(part: ModelPart) -> _Key:
    assert part.condition is not None
    said = tuple((s.column, math.isfinite(s.above), s.word) for s in part.condition.statements)
    return part.label, part.form.key, said


def _gain(pull: Floats, square: Floats) -> Floats:
    return np.asarray(np.where(square > 1e-15, pull**2 / np.maximum(square, 1e-15), 0.0))


def _fitted(bare: ModelFit, part: ModelPart, case: MeasuredMoves, noise: Noise) -> ModelFit:
    """The part beside the others, its values and its bounds by turns."""
    fitted = fit(DurationModel((*bare.model.parts, part)), case, noise, 6)
    for _ in range(_ROUNDS):
        moved = _moved(fitted, case)
        if moved.parts[-1].condition == fitted.model.parts[-1].condition:
            break
        again = fit(moved, case, noise, 8)
        if again.bic >= fitted.bic:
            break
        fitted = again
    return fitted


def _moved(fitted: ModelFit, case: MeasuredMoves) -> DurationModel:
    """The last part's bounds where the moves' likelihoods want them, one statement after the other."""
    part = fitted.model.parts[-1]
    assert part.condition is not None
    rest = DurationModel(fitted.model.parts[:-1])
    always = DurationModel((*rest.parts, part._replace(condition=None)))
    losses = [
        np.log1p(((case.measured - m.seconds(case)) / fitted.scale) ** 2 / FREEDOM) for m in (rest, always)
    ]
    better = losses[0] - losses[1]
    statements = list(part.condition.statements)
    for k, statement in enumerate(statements):
        others = Condition(tuple(s for i, s in enumerate(statements) if i != k)).mask(case)
        statements[k] = _best_cut(statement, np.where(others, better, 0.0), others, case)
    return DurationModel((*rest.parts, part._replace(condition=Condition(tuple(statements)))))


def _best_cut(statement: Statement, better: Floats, others: Mask, case: MeasuredMoves) -> Statement:
    values = feature(case, statement.column)
    if statement.word or isinstance(values, tuple):
        return statement
    sign = 1.0 if math.isfinite(statement.above) else -1.0
    known = others & np.isfinite(values)
    order = np.argsort(-sign * values[known])
    ordered, total = values[known][order], np.cumsum(better[known][order])
    ends = np.nonzero(np.diff(ordered) != 0)[0]
    ends = ends[(ends >= _FEWEST - 1) & (ends < len(ordered) - 1)]
    if not len(ends):
        return statement
    at = int(ends[np.argmax(total[ends])])
    middle = 0.5 * float(ordered[at] + ordered[at + 1])
    return statement._replace(above=middle) if sign > 0 else statement._replace(below=middle)
