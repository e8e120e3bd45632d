"""Where a term acts: regions, directions, lines, times, found and confirmed like the term itself.

A condition is one or two plain statements about a move ("y > 150 mm", "line 114"). All statements are tried with all
terms at once, to first order; the promising ones are fitted, and their bounds go to where the moves' own likelihoods
want them. A statement costs as much in BIC as a parameter and the choice among the columns that there were.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from olp.identification.diagnosis.fitting import (
    FREEDOM,
    ROUNDED,
    ModelFit,
    Noise,
    as_large,
    evaluate,
    fit,
    largest,
    ranks,
)
from olp.identification.diagnosis.intervals import ALIKE
from olp.identification.diagnosis.model import (
    FEATURES,
    Condition,
    DurationModel,
    ModelPart,
    Statement,
    feature,
)
from olp.identification.diagnosis.search import TELLING, PartShelf, cheaper, price, swaps
from olp.timing.physics._case import MeasuredMoves

Floats = NDArray[np.float64]
Mask = NDArray[np.bool_]

_FEWEST = 5  # moves inside, and outside
_CUTS = 9  # places where a column is cut at first
_ROUNDS = 2  # of fitting values and moving bounds
_MOST = 40  # words of a column that are tried
_GUESSES, _FORMS = 2, 2  # of a form, and of a term, that are tried
_SIZES = (0.25, 0.5, 1.0, 2.0)  # times what a part does at its guess
_SEVERAL = 12  # statements that are compared by what they do to moves that meet others at corners


class _Said(NamedTuple):
    """All that can be said of some moves and not of others."""

    statements: list[Statement]
    masks: Floats  # (n, s) 1 where a statement holds
    fair: Mask  # (s, s) pairs that hold in enough moves, and not in enough

    def best(
        self, better: Floats, beyond: float = -math.inf, known: Condition | None = None
    ) -> tuple[float, Condition]:
        """One statement or two, where what moves win by a term, `better` (n,) in log-likelihood, sums up to most, less
        what statements cost; and twice that, -inf where it cannot be more than `beyond`.

        Statements that hold in the same moves win the same: of these, the ones about the columns of what is `known`.
        """
        cost = _cost(len(better))
        at = self._contenders(better, cost, beyond)
        if not len(at):
            return -math.inf, Condition(())
        masks = self.masks[:, at]
        worth = masks.T @ (better[:, None] * masks) - 2.0 * cost
        worth.flat[:: len(at) + 1] += cost
        worth = np.where(self.fair[at][:, at], worth, -np.inf)
        of_known = {statement.column for statement in known.statements} if known is not None else set[str]()
        like = np.array([self.statements[k].column in of_known for k in at])
        alike = as_large(worth.ravel()).reshape(worth.shape)
        one, two = np.unravel_index(np.argmax(alike * (1 + like[:, None] + like)), worth.shape)
        chosen = (self.statements[k] for k in {int(at[one]), int(at[two])})
        return 2.0 * float(worth[one, two]), Condition(tuple(sorted(chosen, key=lambda s: s.column)))

    def several(self, better: Floats) -> list[Condition]:
        """The likeliest statements, each of other moves, the best first."""
        alone = np.where(np.diag(self.fair), better @ self.masks, -np.inf)
        kinds: dict[bytes, int] = {}
        for k in np.argsort(ranks(-alone), kind="stable").tolist():
            if alone[k] > 0:
                kinds.setdefault(self.masks[:, k].tobytes(), k)
        return [Condition((self.statements[k],)) for k in list(kinds.values())[:_SEVERAL]]

    def _contenders(self, better: Floats, cost: float, beyond: float) -> NDArray[np.intp]:
        """(c,) the statements that can be among the best: a pair wins no more than either in the moves that win."""
        alone, most = np.stack([better, np.maximum(better, 0.0)]) @ self.masks
        alone = np.where(np.diag(self.fair), alone - cost, -np.inf)
        least = max(float(alone.max()), 0.5 * beyond)
        least -= ROUNDED * float(np.abs(most).max())  # what is equal but for rounding contends
        return np.nonzero((most - 2.0 * cost >= least) | (alone >= least))[0]


class _Tried(NamedTuple):
    gain: float  # [1] twice the log-likelihood
    part: ModelPart


def conditioned(best: ModelFit, case: MeasuredMoves, noise: Noise, shelf: PartShelf, count: int) -> ModelFit:
    """The fit, or one in which a term under a condition is beside its parts, or in the place of one or all of them."""
    if len(case) < 4 * _FEWEST:
        return best
    said = _said(case)
    if not said.statements:
        return best
    beside = _promising(best, case, shelf, said, count)
    winner = _better(_restricted(best, case, noise, said), best, beside, case, noise, said)
    alone = [m for m in (best.model.without(k) for k in range(len(best.model.parts))) if m.parts]
    for model in (DurationModel(), *alone) if best.model.parts else ():
        bare = fit(model, case, noise, 8)
        tried = _promising(bare, case, shelf, said, count)
        winner = _better(winner, bare, tried, case, noise, said)
    winner = _exchanged(winner, case, noise, shelf, said)
    return winner if price(best) - price(winner) > TELLING else best


def fit_anew(model: DurationModel, case: MeasuredMoves, noise: Noise, steps: int) -> ModelFit:
    """The best values near those of `model`, and of each part that has a condition the one that these moves want: what
    was chosen by the moves that are to be predicted would predict them too well."""
    fitted = fit(model, case, noise, steps)
    if all(part.condition is None for part in model.parts):
        return fitted
    said = _said(case, _FEWEST - 1)
    for k, part in enumerate(model.parts):
        if part.condition is None:
            continue
        for _ in range(_ROUNDS):
            chosen = _chosen(fitted, k, case, said)
            if chosen == fitted.model.parts[k].condition:
                break
            parts = list(fitted.model.parts)
            parts[k] = parts[k]._replace(condition=chosen)
            fitted = fit(DurationModel(tuple(parts)), case, noise, steps)
    return fitted


def _chosen(fitted: ModelFit, index: int, case: MeasuredMoves, said: _Said) -> Condition:
    """Of part `index` by these moves; its own where they do not tell another from it.

    A bound may be anywhere between two moves: that it is where these leave much room is likelier in proportion, and
    one odd move beside moves that are to be predicted does not decide on which side all of them are.
    """
    part, under = fitted.model.parts[index], _Under.of(fitted, index, case)
    assert part.condition is not None
    other = under.best(said, part.condition)
    more = under.worth(other) - under.worth(part.condition)
    more += _room(other, case) - _room(part.condition, case)
    return other if 2.0 * more > ALIKE else part.condition


class _Under(NamedTuple):
    """What a part under a condition does to a case, beside the others."""

    part: ModelPart
    rest: DurationModel
    scale: float  # [s]
    case: MeasuredMoves
    better: Floats  # (n,) by how much each move is likelier where the part acts in all
    without: Floats  # (n,) how unlikely each move is without the part
    won: dict[Condition, float]  # what moves win under a condition, kept once it was asked for

    @classmethod
    def of(cls, fitted: ModelFit, index: int, case: MeasuredMoves) -> _Under:
        """Of part `index` of a fit."""
        part, rest = fitted.model.parts[index], fitted.model.without(index)
        always = DurationModel((*rest.parts, part._replace(condition=None)))
        without = _unlikely(rest, fitted.scale, case)
        return cls(
            part, rest, fitted.scale, case, without - _unlikely(always, fitted.scale, case), without, {}
        )

    def worth(self, condition: Condition) -> float:
        """[1] log-likelihood that moves win under a condition, less what its statements cost.

        Where moves meet others at rounded corners they do not win each by itself: a corner is as long as what acts in
        either of its moves makes it.
        """
        if self.case.partners is None:
            return _worth(condition, self.better, self.case)
        if condition not in self.won:
            whole = DurationModel((*self.rest.parts, self.part._replace(condition=condition)))
            self.won[condition] = float((self.without - _unlikely(whole, self.scale, self.case)).sum())
        return self.won[condition] - _cost(len(self.case)) * len(condition.statements)

    def best(self, said: _Said, known: Condition) -> Condition:
        """The condition that is worth most, its bounds where the moves want them."""
        one = said.best(self.better, known=known)[1]
        several = [] if self.case.partners is None else said.several(self.better)
        return self.first([self.bounded(each) for each in (one, *several)])

    def first(self, conditions: list[Condition]) -> Condition:
        """The one that is worth most; of those that are worth as much the first."""
        return conditions[largest(np.array([self.worth(one) for one in conditions]))]

    def bounded(self, condition: Condition) -> Condition:
        """The condition with its bounds where the moves want them."""
        return _bounded(condition, self.better, self.case, self.worth)


def _worth(condition: Condition, better: Floats, case: MeasuredMoves) -> float:
    """[1] log-likelihood that moves win by a term under a condition, `better` (n,), less what its statements cost."""
    return float(better[condition.mask(case)].sum()) - _cost(len(case)) * len(condition.statements)


def _room(condition: Condition, case: MeasuredMoves) -> float:
    """[1] logarithm of the room that bounds have between the moves next to them, each over the mean room between two
    moves: what a bound that may be anywhere adds to a log-likelihood."""
    room = 0.0
    for k, statement in enumerate(condition.statements):
        values = feature(case, statement.column)
        if statement.word or isinstance(values, tuple):
            continue
        others = Condition(tuple(s for i, s in enumerate(condition.statements) if i != k)).mask(case)
        known = np.unique(values[others & np.isfinite(values)])
        bound = statement.above if math.isfinite(statement.above) else statement.below
        at = int(np.searchsorted(known, bound))
        if 0 < at < len(known):
            room += math.log((known[at] - known[at - 1]) * (len(known) - 1) / (known[-1] - known[0]))
    return room


def _restricted(best: ModelFit, case: MeasuredMoves, noise: Noise, said: _Said) -> ModelFit:
    """The fit, or one in which a part of it acts under a condition: moves that are likelier without the part tell that
    directly, where what all moves leave has made the scatter too large for anything else to be told."""
    winner = best
    for k, part in enumerate(best.model.parts):
        if part.condition is not None or not part.conditionable:
            continue
        rest = best.model.without(k)
        better = _won(rest, best.model, best.scale, case)
        gain, condition = said.best(better, 2.0 * float(better.sum()) + TELLING)
        if gain > 2.0 * float(better.sum()) + TELLING:
            bare = fit(rest, case, noise, 8)
            winner = _better(
                winner, bare, [_Tried(gain, part._replace(condition=condition))], case, noise, said
            )
    return winner


def _won(rest: DurationModel, whole: DurationModel, scale: float, case: MeasuredMoves) -> Floats:
    """(n,) by how much each move is likelier, in log-likelihood, with `whole` than with `rest`."""
    return _unlikely(rest, scale, case) - _unlikely(whole, scale, case)


def _unlikely(model: DurationModel, scale: float, case: MeasuredMoves) -> Floats:
    """(n,) minus log-likelihood of each move, less what all models have alike."""
    off = (case.measured - model.seconds(case)) / scale
    return np.asarray(0.5 * (FREEDOM + 1.0) * np.log1p(off**2 / FREEDOM))


def _exchanged(
    winner: ModelFit, case: MeasuredMoves, noise: Noise, shelf: PartShelf, said: _Said
) -> ModelFit:
    """The winner, or one with another term, or another form of the term, in the place of the part that has a condition:
    to first order that may have promised less. The condition follows it."""
    at = [k for k, part in enumerate(winner.model.parts) if part.condition is not None]
    if not at:
        return winner
    others = swaps(winner, at[0], shelf, case, noise, price(winner))
    rest = evaluate(winner.model.without(at[0]), case, noise)
    others += _other_forms(rest, winner.model.parts[at[0]], case, noise, shelf)
    first = min(others, key=price, default=winner)
    if price(first) >= price(winner):
        return winner
    placed = [
        part for part in first.model.parts if part.condition is not None
    ]  # none: a term that acts everywhere
    return min([first, *(_fitted(rest, part, case, noise, said) for part in placed)], key=price)


def _other_forms(
    rest: ModelFit, part: ModelPart, case: MeasuredMoves, noise: Noise, shelf: PartShelf
) -> list[ModelFit]:
    """Fits with the other forms of a part's term in its place, from their first guesses."""
    forms: dict[str, list[ModelPart]] = {}
    for other in shelf.parts:
        if other.label == part.label and other.form.key != part.form.key:
            forms.setdefault(other.form.key, []).append(other._replace(condition=part.condition))
    guesses = [other for of in forms.values() for other in of[:_GUESSES]]
    return [fit(DurationModel((*rest.model.parts, other)), case, noise, 6) for other in guesses]


def _better(
    winner: ModelFit, bare: ModelFit, tried: list[_Tried], case: MeasuredMoves, noise: Noise, said: _Said
) -> ModelFit:
    """The winner, or a fit with one of the parts beside `bare` that is better."""
    for one in tried:
        winner = min(winner, _fitted(bare, one.part, case, noise, said, price(winner)), key=price)
    return winner


def _said(case: MeasuredMoves, fewest: int = _FEWEST) -> _Said:
    """Of conditions that hold in `fewest` moves at least."""
    known = case.fits.get(("said", fewest))
    if isinstance(known, _Said):
        return known
    statements = list(_statements(case))
    masks = np.array([s.mask(case) for s in statements], dtype=np.float64).reshape(-1, len(case)).T
    inside = masks.T @ masks
    columns = np.array([s.column for s in statements])
    fair = (inside >= fewest) & (inside <= len(case) - fewest)
    fair &= (columns[:, None] != columns) | np.eye(len(columns), dtype=bool)
    said = _Said(statements, masks, fair)
    case.keep(("said", fewest), said)
    return said


def _statements(case: MeasuredMoves) -> Iterator[Statement]:
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
    bare: ModelFit, case: MeasuredMoves, shelf: PartShelf, said: _Said, count: int
) -> list[_Tried]:
    """Of each label the part that explains most of the residual where one statement holds, under the best condition."""
    residual = case.measured - bare.model.seconds(case)
    weight = (FREEDOM + 1.0) / (FREEDOM + (residual / bare.scale) ** 2)
    free = [k for k, p in enumerate(shelf.parts) if p.conditionable and p.label not in bare.labels]
    if not free or not said.fair.any():
        return []
    columns = shelf.columns[:, free]
    pull = (columns * (weight * residual)[:, None]).T @ said.masks
    either = np.array([shelf.parts[k].reversible for k in free])[:, None]
    square = (columns**2 * weight[:, None]).T @ said.masks
    linear = _gain(np.where(either, pull, np.maximum(pull, 0.0)), square) / bare.scale**2
    sized = [_relief(residual, size * columns, bare.scale) for size in _SIZES]
    gains = np.stack([linear, *(2.0 * one.T @ said.masks for one in sized)])
    gains[:, :, ~np.diag(said.fair)] = 0.0
    tried = dict[tuple[str, str], list[_Tried]]()
    for row in np.argsort(ranks(-gains.max(axis=(0, 2))), kind="stable").tolist():
        part = shelf.parts[free[row]]
        of_form = tried.setdefault((part.label, part.form.key), [])
        if len(of_form) < _GUESSES:
            how, at = np.unravel_index(largest(gains[:, row].ravel()), gains[:, row].shape)
            best = (float(gains[how, row, at]), Condition((said.statements[int(at)],)))
            for size in sized:
                beyond = max(best[0], *(one.gain for one in of_form)) if of_form else best[0]
                best = max(best, said.best(size[:, row], beyond), key=lambda t: t[0])
            gain = best[0] - part.term.doubt(part.form, part.values)
            of_form.append(_Tried(gain, part._replace(condition=best[1])))
    ranked = sorted((max(one, key=lambda t: t.gain) for one in tried.values()), key=lambda t: -t.gain)
    return [one for k, one in enumerate(ranked) if _of_label(ranked[:k], one) < _FORMS][:count]


def _of_label(before: list[_Tried], one: _Tried) -> int:
    return sum(other.part.label == one.part.label for other in before)


def _relief(residual: Floats, columns: Floats, scale: float) -> Floats:
    """(n, m) by which moves are likelier with columns (n, m), in log-likelihood: what acts in few moves and is far
    larger than the scatter has next to no weight to first order."""
    before = np.log1p((residual / scale) ** 2 / FREEDOM)[:, None]
    after = np.log1p(((residual[:, None] - columns) / scale) ** 2 / FREEDOM)
    return np.asarray(0.5 * (FREEDOM + 1.0) * (before - after))


def _gain(pull: Floats, square: Floats) -> Floats:
    return np.asarray(np.where(square > 1e-15, pull**2 / np.maximum(square, 1e-15), 0.0))


def _fitted(
    bare: ModelFit, part: ModelPart, case: MeasuredMoves, noise: Noise, said: _Said, asked: float = math.inf
) -> ModelFit:
    """The part beside the others, its values and its condition by turns; `asked`: the price from which on it is of no
    use."""
    fitted = fit(DurationModel((*bare.model.parts, part)), case, noise, 6)
    for _ in range(_ROUNDS):
        moved = _moved(fitted, case, said)
        if moved.parts[-1].condition == fitted.model.parts[-1].condition:
            break
        again = cheaper(moved, case, noise, 8, asked)
        if again.bic >= fitted.bic:
            break
        fitted = again
    return fitted


def _moved(fitted: ModelFit, case: MeasuredMoves, said: _Said) -> DurationModel:
    """The model with a new condition on its last part: the present condition or the best other one, whichever fits
    the moves better after its bounds were refined one after the other.
    """
    part, under = fitted.model.parts[-1], _Under.of(fitted, len(fitted.model.parts) - 1, case)
    assert part.condition is not None
    best = under.first([under.bounded(part.condition), under.best(said, part.condition)])
    return DurationModel((*under.rest.parts, part._replace(condition=best)))


def _bounded(
    condition: Condition,
    better: Floats,
    case: MeasuredMoves,
    worth: Callable[[Condition], float] | None = None,
) -> Condition:
    """The condition with its bounds where these moves want them, without a statement that is then of no use: a rough
    bound may have needed another one beside it. `worth` of a condition: else what the moves inside win by themselves.
    """
    statements = list(condition.statements)
    for k, statement in enumerate(statements):
        others = Condition(tuple(s for i, s in enumerate(statements) if i != k)).mask(case)
        statements[k] = _best_cut(statement, np.where(others, better, 0.0), others, case)
    whole, known = Condition(tuple(statements)), np.ones(len(better), dtype=bool)
    alone = [Condition((_best_cut(statement, better, known, case),)) for statement in statements]
    each = [whole, *alone]
    told = [_worth(one, better, case) if worth is None else worth(one) for one in each]
    return each[largest(np.array(told))]


def _cost(count: int) -> float:
    """Of a statement, in log-likelihood: half of what `penalty` says."""
    return 0.5 * math.log(count) + math.log(len(FEATURES))


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
    at = int(ends[largest(total[ends])])
    middle = 0.5 * float(ordered[at] + ordered[at + 1])
    return statement._replace(above=middle) if sign > 0 else statement._replace(below=middle)
