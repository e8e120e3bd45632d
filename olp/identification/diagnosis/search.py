"""Which terms together explain a case best: small sets all at once, larger ones from the best smaller ones.

Columns of what each term does at its guesses screen all pairs by weighted least squares, and the promising ones are
fitted properly, as nonlinear models. Sets are compared by BIC (G. Schwarz, Annals of Statistics 6, 1978) with a price
for each name beyond it, because many names are tried.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Sequence
from itertools import permutations
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from olp.identification.diagnosis.fitting import (
    FREEDOM,
    ModelFit,
    Noise,
    evaluate,
    fit,
    ranks,
    slopes_of,
    whiten,
)
from olp.identification.diagnosis.model import Condition, DurationModel, ModelPart
from olp.timing.physics import MoveTerm, load_term, term_names
from olp.timing.physics._case import MeasuredMoves

Floats = NDArray[np.float64]

PRICE = 6.0  # of a name, in BIC
TELLING = 10.0  # in BIC, of each name: "very strong" by R. Kass and A. Raftery, JASA 90, 1995
MOST = 5  # names in one answer
_MOVES_PER_NAME = 10  # fewer moves are no evidence
_SETTLED = 20  # steps, for fits that are compared with one that had its time
_OF_A_TERM = 4  # guesses that are fitted alone, and forms that are tried in the place of another term
_EXCHANGES = 3
_BESIDE_ALL = 18  # guesses of one more term that are tried beside a whole set
_STARTS = 2  # of a term that is added
_DIGITS = 4  # of a BIC: fits stop where a step gains less than 1e-4
_IN_PLACE = 32  # guesses that are tried in the place of a part
_CLOSE = 5  # exchanged terms that are fitted to the end
_SPARED = 2  # of ten moves a fold may keep two


class Effort(NamedTuple):
    """How wide a search goes."""

    singles: int  # fitted of those that were screened
    pairs: int  # fitted of those that were screened
    leaders: int  # single terms that are fitted with others
    beam: int  # sets of one size that are added to, and looked at in the end
    additions: int  # to each
    most: int = MOST
    steps: int = 8  # of each fit


WIDE = Effort(singles=36, pairs=16, leaders=3, beam=3, additions=12)
NARROW = Effort(singles=12, pairs=5, leaders=1, beam=2, additions=5, most=4, steps=5)


class PartShelf(NamedTuple):
    """All parts at all their guesses, and what each does alone."""

    parts: tuple[ModelPart, ...]
    columns: Floats  # (n, m) [s]

    def take(self, rows: NDArray[np.int64]) -> PartShelf:
        """Of some of the moves."""
        return PartShelf(self.parts, self.columns[rows])


def move_terms() -> tuple[MoveTerm, ...]:
    """All terms that durations of moves can tell."""
    return tuple(term for term in map(load_term, term_names()) if isinstance(term, MoveTerm))


def shelf_of(case: MeasuredMoves, terms: Iterable[MoveTerm]) -> PartShelf:
    """Every form of every term at every guess."""
    parts = [
        ModelPart(term, form, values)
        for term in terms
        for form in term.forms(case)
        for values in term.guesses(form, case)
    ]
    columns = [DurationModel((part,)).seconds(case) - case.simulated for part in parts]
    return PartShelf(tuple(parts), np.stack(columns, axis=1) if columns else np.zeros((len(case), 0)))


def price(fitted: ModelFit) -> float:
    """BIC and the price of the names; what sets are ranked by. The axes of one term are one name."""
    parts = fitted.model.parts
    whole = fitted.bic + PRICE * len({part.term.name for part in parts}) + doubts(fitted.model)
    return round(whole, _DIGITS)  # of two that are equal but for where their fits stopped, the first


def doubts(model: DurationModel) -> float:
    """In BIC, against values that physics does not expect."""
    return sum(part.term.doubt(part.form, part.values) for part in model.parts)


def cheaper(model: DurationModel, case: MeasuredMoves, noise: Noise, steps: int, asked: float) -> ModelFit:
    """The model fitted; given up where its price gets nowhere near to below the one that is `asked`."""
    return fit(model, case, noise, steps, below=asked - PRICE * len({part.term.name for part in model.parts}))


def most_names(case: MeasuredMoves) -> int:
    """How many names the moves are evidence for."""
    return (len(case) + _SPARED) // _MOVES_PER_NAME


def search(case: MeasuredMoves, noise: Noise, shelf: PartShelf, effort: Effort) -> list[ModelFit]:
    """All sets that were fitted, the best first; the empty one is among them."""
    found: dict[tuple[tuple[str, str], ...], ModelFit] = {}

    def keep(model: DurationModel) -> ModelFit:
        key = tuple(sorted((part.label, part.form.key) for part in model.parts))
        fitted = cheaper(model, case, noise, effort.steps, bar(len(model.parts)))
        if key not in found or price(fitted) < price(found[key]):
            found[key] = fitted
        return found[key]

    def bar(size: int) -> float:
        """The price below which a set is among those of its size that are looked at again."""
        prices = sorted(price(f) for f in found.values() if len(f.model.parts) == size)
        return prices[effort.beam - 1] if size > 1 and len(prices) >= effort.beam else np.inf

    empty = keep(DurationModel())
    most = min(effort.most, most_names(case))
    if most == 0:
        return [empty]
    for part in _alone(shelf, empty, case, noise, effort.singles):
        keep(DurationModel((part,)))
    singles = sorted((f for f in found.values() if f.model.parts), key=price)
    if most > 1:
        for one, two in _promising_pairs(shelf, empty, case, noise, effort.pairs):
            keep(DurationModel((shelf.parts[one], shelf.parts[two])))
        for leader in _of_each_term(singles)[: effort.leaders]:
            for part in additions(shelf, leader, case, noise, effort.additions):
                keep(DurationModel((leader.model.parts[0], part)))
    for size in range(2, most):
        best = sorted((f for f in found.values() if len(f.model.parts) == size), key=price)[: effort.beam]
        for fitted in best:
            for part in additions(shelf, fitted, case, noise, effort.additions):
                keep(DurationModel((*fitted.model.parts, part)))
        if best and not _gained(found.values(), size):
            break
    return sorted(found.values(), key=price)


def additions(
    shelf: PartShelf, fitted: ModelFit, case: MeasuredMoves, noise: Noise, count: int, starts: int = _STARTS
) -> list[ModelPart]:
    """The parts that promise most beside a fit, up to `starts` of each term."""
    taken, result = Counter[str](), list[ModelPart]()
    names = {part.term.name for part in fitted.model.parts if part.form.axis < 0}
    for part in _promising(shelf, fitted, case, noise):
        if len(result) >= count:
            break
        if part.label not in fitted.labels and part.term.name not in names:
            taken[part.label] += 1
            if taken[part.label] <= starts:
                result.append(part)
    return result


def nearest_single(shelf: PartShelf, case: MeasuredMoves, noise: Noise, count: int) -> list[DurationModel]:
    """The terms that come nearest alone, the best first, each once."""
    tried = [
        fit(DurationModel((part,)), case, noise, WIDE.steps)
        for part in _alone(shelf, evaluate(DurationModel(), case, noise), case, noise, WIDE.singles)
    ]
    best: dict[str, DurationModel] = {}
    for fitted in sorted(tried, key=price):
        best.setdefault(fitted.model.parts[0].term.name, fitted.model)
    return list(best.values())[:count]


def _promising(
    shelf: PartShelf, fitted: ModelFit, case: MeasuredMoves, noise: Noise, whole: ModelFit | None = None
) -> list[ModelPart]:
    """Of each form its two likeliest guesses, the forms by what their columns explain of a fit's residual.

    That is, to first order, what of a column goes with the residual; a limit's column also has to be of the right size.
    A guess that is the second by its size alone comes behind those of all forms. `whole`: a fit that is more than
    `fitted`; what it explains is not far out, however few moves differ.
    """
    residual = whiten(case.measured - fitted.model.seconds(case), noise, case)
    known = whole or fitted
    off = whiten(case.measured - known.model.seconds(case), noise, case) / known.scale
    weight = (FREEDOM + 1.0) / (FREEDOM + off**2)
    root = np.sqrt(weight)[:, None]
    columns = root * whiten(shelf.columns, noise, case)
    if fitted.model.parts:
        slopes = root * slopes_of(fitted.model, case, noise)
        basis, _ = np.linalg.qr(slopes[:, slopes.any(axis=0)])
        columns = columns - basis @ (basis.T @ columns)
    size = (columns**2).sum(axis=0)
    pull = columns.T @ (root[:, 0] * residual)
    # A limit does not make anything quicker.
    pull = np.where([part.reversible for part in shelf.parts], pull, np.maximum(pull, 0.0))
    gain = np.where(size > 1e-12, pull**2 / np.maximum(size, 1e-12), 0.0)
    direct = 2.0 * pull - size
    told, near, much = (ranks(values).tolist() for values in (gain, direct, size))
    forms: dict[tuple[str, str], list[int]] = {}
    for index, part in enumerate(shelf.parts):
        forms.setdefault((part.label, part.form.key), []).append(index)
    ranked = sorted(forms.values(), key=lambda of: -max(told[k] for k in of))
    likely, spare = list[int](), list[int]()
    for of in ranked:
        first, most = max(of, key=lambda k: near[k]), max(told[k] for k in of)
        # Guesses that do the same, one more of it than the other, gain alike: the one that does most, as no slope leads
        # away from where a term does next to nothing.
        other = max((k for k in of if told[k] == most and k != first), key=lambda k: much[k], default=first)
        likely += [first] if told[first] == most else [first, other]
        spare += [other] if told[first] == most and other != first else []
    return [shelf.parts[k] for k in (*likely, *spare) if gain[k] > 0]


def _alone(
    shelf: PartShelf, empty: ModelFit, case: MeasuredMoves, noise: Noise, count: int
) -> list[ModelPart]:
    """What is fitted alone: of each term a few forms, of the likeliest terms more."""
    seen, result = Counter[str](), list[ModelPart]()
    ranked = _promising(shelf, empty, case, noise)
    for part in ranked:
        seen[part.term.name] += 1
        if seen[part.term.name] <= (_OF_A_TERM if len(result) < count // 2 else 1) and len(result) < count:
            result.append(part)
    return result


def _of_each_term(fits: Sequence[ModelFit]) -> list[ModelFit]:
    """The first of each label."""
    best: dict[str, ModelFit] = {}
    for fitted in fits:
        best.setdefault(fitted.model.parts[0].label, fitted)
    return list(best.values())


def exchanged(best: ModelFit, shelf: PartShelf, case: MeasuredMoves, noise: Noise) -> ModelFit:
    """The fit, with other terms in the place of its parts, and one more, as long as that is better; what a screening to
    first order overlooked is found here."""
    for _ in range(_EXCHANGES):
        tried = [swaps(best, k, shelf, case, noise, price(best)) for k in range(len(best.model.parts))]
        others = [fits[0] for fits in tried if fits]
        names = {part.term.name for part in best.model.parts}
        if len(names) < min(MOST, most_names(case)):
            more = additions(shelf, best, case, noise, _BESIDE_ALL, _OF_A_TERM)
            others += [
                cheaper(DurationModel((*best.model.parts, part)), case, noise, WIDE.steps, price(best))
                for part in more
            ]
        others = [
            f for f in others if len(f.model.parts) == len(best.model.parts) or f.bic < best.bic - TELLING
        ]
        first = min(others, key=price, default=best)
        if price(first) >= price(best):
            break
        best = first
    return best


def merged(best: ModelFit, shelf: PartShelf, case: MeasuredMoves, noise: Noise) -> ModelFit:
    """The fit, or one with a name less: another form of a term, with more parameters, does what a second name made up
    for (an inertia that grows from a reach, beside an acceleration that makes up for where it grows from)."""
    parts = best.model.parts
    for kept, gone in permutations(range(len(parts)), 2):
        rest = [part for k, part in enumerate(parts) if k not in (kept, gone)]
        richer = [
            other._replace(condition=parts[kept].condition)
            for other in shelf.parts
            if other.label == parts[kept].label and len(other.values) > len(parts[kept].values)
        ]
        tried = [
            cheaper(DurationModel((*rest, other)), case, noise, WIDE.steps, price(best)) for other in richer
        ]
        first = min(tried, key=price, default=best)
        if price(first) < price(best):
            return merged(first, shelf, case, noise)
    return best


def of_all_axes(best: ModelFit, shelf: PartShelf, case: MeasuredMoves, noise: Noise) -> ModelFit:
    """The fit, with all those axes of the terms that it has for some that are worth it: one by one each may be worth
    less than what the others, without theirs, make up for."""
    names = {part.term.name for part in best.model.parts if part.form.axis >= 0}
    more: dict[str, list[ModelPart]] = {}
    for one in shelf.parts:
        if one.term.name in names and not any(_rivals(one, part) for part in best.model.parts):
            more.setdefault(one.label, []).append(one)
    if not more:
        return best
    model = best.model
    for guesses in more.values():
        tried = [DurationModel((*model.parts, one)) for one in guesses]
        model = min(tried, key=lambda one: evaluate(one, case, noise).loss)
    full = fit(model, case, noise, _SETTLED)
    while True:
        axes = [k for k, part in enumerate(full.model.parts) if part.form.axis >= 0]
        least = full.bic + TELLING
        fewer = min((fit(full.model.without(k), case, noise, below=least) for k in axes), key=lambda f: f.bic)
        if fewer.bic >= least or len(fewer.model.parts) <= len(best.model.parts):
            break
        full = fewer
    return full if price(full) < price(best) - TELLING else best


def in_its_place(
    bare: ModelFit, gone: ModelPart, shelf: PartShelf, case: MeasuredMoves, noise: Noise, tried: set[str]
) -> ModelFit:
    """The fit without the part `gone`, or with what terms that it has for other axes do for the same axis; not with
    labels that were `tried`."""
    names = {part.term.name for part in bare.model.parts if part.form.axis >= 0}
    more = [
        fit(DurationModel((*bare.model.parts, one)), case, noise, _SETTLED, below=bare.bic - TELLING)
        for one in shelf.parts
        if one.form.axis == gone.form.axis >= 0 and one.term.name in names and one.label not in tried
        if not any(_rivals(one, part) for part in bare.model.parts)
    ]
    return min((f for f in more if f.bic < bare.bic - TELLING), key=price, default=bare)


def with_fewer_numbers(
    best: ModelFit, index: int, shelf: PartShelf, case: MeasuredMoves, noise: Noise
) -> ModelFit | None:
    """The best fit with a form of fewer numbers in the place of part `index`; None where its term has none."""
    parts, gone = best.model.parts, best.model.parts[index]
    others = [
        one._replace(condition=gone.condition)
        for one in shelf.parts
        if one.label == gone.label and len(one.values) < len(gone.values)
    ]
    tried = [
        fit(DurationModel((*parts[:index], one, *parts[index + 1 :])), case, noise, _SETTLED)
        for one in others
    ]
    return min(tried, key=price, default=None)


def reformed(best: ModelFit, shelf: PartShelf, case: MeasuredMoves, noise: Noise) -> ModelFit:
    """The fit, with other forms of its terms in the place of its parts where these do better: to first order a form
    with more parameters promises more, and a limit of which the guesses are far off promises nothing."""
    for index in range(len(best.model.parts)):
        tried = [
            cheaper(_placed(best, index, other), case, noise, WIDE.steps, price(best))
            for other in _nearest_guesses(best, index, shelf, case, noise)
        ]
        first = min(tried, key=price, default=best)
        if price(first) < price(best):
            return reformed(first, shelf, case, noise)
    return best


def _nearest_guesses(
    best: ModelFit, index: int, shelf: PartShelf, case: MeasuredMoves, noise: Noise
) -> list[ModelPart]:
    """Of each other form of a part's term the guess that comes nearest in its place."""
    part = best.model.parts[index]
    forms: dict[str, list[ModelPart]] = {}
    for other in shelf.parts:
        if other.label == part.label and other.form.key != part.form.key:
            forms.setdefault(other.form.key, []).append(other._replace(condition=part.condition))
    return [
        min(of, key=lambda one: evaluate(_placed(best, index, one), case, noise).loss)
        for of in forms.values()
    ]


def _placed(best: ModelFit, index: int, part: ModelPart) -> DurationModel:
    """The model with a part in the place of another."""
    parts = best.model.parts
    return DurationModel((*parts[:index], part, *parts[index + 1 :]))


def swaps(
    fitted: ModelFit, index: int, shelf: PartShelf, case: MeasuredMoves, noise: Noise, asked: float = np.inf
) -> list[ModelFit]:
    """The fits in which every other term stands in the place of part `index`, under its condition, the best first, each
    term once. `asked`: the price from which on a fit is of no use."""
    rest = fitted.model.without(index)
    used = {part.term.name for part in fitted.model.parts}
    condition = fitted.model.parts[index].condition
    count, forms, best = 0, set[tuple[str, str]](), dict[str, ModelFit]()
    there = shelf if condition is None else _under(condition, shelf, case)
    for part in _promising(there, evaluate(rest, case, noise), case, noise, fitted):
        name = part.term.name
        form = (name, part.form.key)
        # Two guesses of a form are two ways to one fit: they keep no other form of the term from being tried.
        if name in used or (form not in forms and len({f for f in forms if f[0] == name}) == _OF_A_TERM):
            continue
        forms.add(form)
        count += 1
        if count > _IN_PLACE:
            break
        placed = part._replace(condition=condition if part.conditionable else None)
        tried = cheaper(DurationModel((*rest.parts, placed)), case, noise, 6, asked)
        if name not in best or tried.bic < best[name].bic:
            best[name] = tried
    close = sorted(best.values(), key=lambda f: f.bic)
    settled = [cheaper(f.model, case, noise, _SETTLED, asked) for f in close[:_CLOSE]]
    return sorted([*settled, *close[_CLOSE:]], key=lambda f: f.bic)


def _under(condition: Condition, shelf: PartShelf, case: MeasuredMoves) -> PartShelf:
    """The parts with what they do where the condition holds; in all moves those that act in no part of them."""
    outside = ~condition.mask(case)[:, None] & np.array([part.conditionable for part in shelf.parts])
    return shelf._replace(columns=np.where(outside, 0.0, shelf.columns))


def _gained(found: Iterable[ModelFit], size: int) -> bool:
    """Whether the sets of one more name are any better than those of `size`."""
    by = {
        k: min((price(f) for f in found if len(f.model.parts) == k), default=np.inf) for k in (size, size + 1)
    }
    return by[size + 1] < by[size]


def _promising_pairs(
    shelf: PartShelf, empty: ModelFit, case: MeasuredMoves, noise: Noise, count: int
) -> list[tuple[int, int]]:
    """Pairs of columns of different terms by what they explain together, the best guesses of each two forms."""
    m = shelf.columns.shape[1]
    if m < 2:
        return []
    residual = whiten(case.residual, noise, case)
    weight = (FREEDOM + 1.0) / (FREEDOM + (residual / empty.scale) ** 2)
    columns = whiten(shelf.columns, noise, case)
    size = np.sqrt((weight[:, None] * columns**2).sum(axis=0))
    columns = columns / np.where(size > 1e-12, size, np.inf)
    gram = columns.T @ (weight[:, None] * columns)
    pull = columns.T @ (weight * residual)
    one, two = np.triu_indices(m, 1)
    free = 1.0 - gram[one, two] ** 2
    gain = pull[one] ** 2 + pull[two] ** 2 - 2.0 * gram[one, two] * pull[one] * pull[two]
    gain = np.where(free > 1e-4, gain / np.maximum(free, 1e-4), 0.0)
    seen, result = set[tuple[str, ...]](), list[tuple[int, int]]()
    for at in np.argsort(ranks(-gain), kind="stable").tolist():
        a, b = shelf.parts[one[at]], shelf.parts[two[at]]
        key = (a.label, a.form.key, b.label, b.form.key)
        if len(result) >= count or gain[at] <= 0:
            break
        if not _rivals(a, b) and key not in seen:
            seen.add(key)
            result.append((int(one[at]), int(two[at])))
    return result


def _rivals(a: ModelPart, b: ModelPart) -> bool:
    """Whether two parts cannot stand in one model: forms of one term, unless of different axes."""
    return a.term.name == b.term.name and (min(a.form.axis, b.form.axis) < 0 or a.form.axis == b.form.axis)
