"""Which terms together explain a case best: small sets all at once, larger ones from the best smaller ones.

Columns of what each term does at its guesses screen all pairs by weighted least squares, and the promising ones are
fitted properly, as nonlinear models. Sets are compared by BIC (G. Schwarz, Annals of Statistics 6, 1978) with a price
for each name beyond it, because many names are tried.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from olp.diagnosis.fitting import FREEDOM, Fit, Noise, evaluate, fit, slopes_of, whiten
from olp.diagnosis.model import Model, Part
from olp.physics import MoveTerm, load_term, term_names
from olp.physics._case import Case

Floats = NDArray[np.float64]

PRICE = 6.0  # of a name, in BIC
MOST = 5  # names in one answer
_MOVES_PER_NAME = 10  # fewer moves are no evidence
_SETTLED = 20  # steps, for fits that are compared with one that had its time
_SPARED = 2  # of ten moves a fold may keep two


class Effort(NamedTuple):
    """How wide a search goes."""

    pairs: int  # fitted of those that were screened
    leaders: int  # single terms that are fitted with every other
    beam: int  # sets of one size that are added to
    additions: int  # to each
    most: int = MOST
    steps: int = 8  # of each fit


WIDE = Effort(pairs=40, leaders=3, beam=5, additions=8)
NARROW = Effort(pairs=12, leaders=1, beam=2, additions=5, most=4, steps=5)


class Shelf(NamedTuple):
    """All parts at all their guesses, and what each does alone."""

    parts: tuple[Part, ...]
    columns: Floats  # (n, m) [s]


def move_terms() -> tuple[MoveTerm, ...]:
    """All terms that durations of moves can tell."""
    return tuple(term for term in map(load_term, term_names()) if isinstance(term, MoveTerm))


def shelf_of(case: Case, terms: Iterable[MoveTerm]) -> Shelf:
    """Every form of every term at every guess."""
    parts = [
        Part(term, form, values)
        for term in terms
        for form in term.forms(case)
        for values in term.guesses(form, case)
    ]
    base = Model().smooth(case)
    columns = [Model((part,)).smooth(case) - base for part in parts]
    return Shelf(tuple(parts), np.stack(columns, axis=1) if columns else np.zeros((len(case), 0)))


def price(fitted: Fit) -> float:
    """BIC and the price of the names; what sets are ranked by."""
    parts = fitted.model.parts
    doubts = sum(part.term.doubt(part.form, part.values) for part in parts)
    return fitted.bic + PRICE * len(parts) + doubts


def search(case: Case, noise: Noise, shelf: Shelf, effort: Effort) -> list[Fit]:
    """All sets that were fitted, the best first; the empty one is among them."""
    found: dict[tuple[tuple[str, str], ...], Fit] = {}

    def keep(model: Model) -> Fit:
        key = tuple(sorted((part.label, part.form.key) for part in model.parts))
        fitted = fit(model, case, noise, effort.steps)
        if key not in found or price(fitted) < price(found[key]):
            found[key] = fitted
        return found[key]

    empty = keep(Model())
    most = min(effort.most, (len(case) + _SPARED) // _MOVES_PER_NAME)
    if most == 0:
        return [empty]
    singles = _singles(shelf, case, noise, keep)
    if most > 1:
        _pairs(shelf, empty, singles, case, noise, effort, keep)
    for size in range(2, most):
        best = sorted((f for f in found.values() if len(f.model.parts) == size), key=price)[: effort.beam]
        for fitted in best:
            for part in additions(shelf, fitted, case, noise, effort.additions):
                keep(Model((*fitted.model.parts, part)))
        if best and size > 2 and not _gained(found.values(), size):
            break
    return sorted(found.values(), key=price)


def additions(shelf: Shelf, fitted: Fit, case: Case, noise: Noise, count: int) -> list[Part]:
    """The parts that promise most beside a fit: what it does not explain of their columns goes with its residual."""
    residual = whiten(case.measured - fitted.model.seconds(case), noise.order)
    weight = (FREEDOM + 1.0) / (FREEDOM + (residual / fitted.scale) ** 2)
    root = np.sqrt(weight)[:, None]
    columns = root * whiten(shelf.columns, noise.order)
    if fitted.model.parts:
        basis, _ = np.linalg.qr(root * slopes_of(fitted.model, case, noise))
        columns = columns - basis @ (basis.T @ columns)
    size = (columns**2).sum(axis=0)
    gain = np.where(size > 1e-12, (columns.T @ (root[:, 0] * residual)) ** 2 / np.maximum(size, 1e-12), 0.0)
    taken, result = set(fitted.labels), list[Part]()
    names = {part.term.name for part in fitted.model.parts if part.form.axis < 0}
    for index in np.argsort(-gain).tolist():
        part = shelf.parts[index]
        if gain[index] <= 0 or len(result) >= count:
            break
        if part.label not in taken and part.term.name not in names:
            taken.add(part.label)
            result.append(part)
    return result


def swaps(fitted: Fit, index: int, shelf: Shelf, case: Case, noise: Noise) -> list[Fit]:
    """The fits in which every other term stands in the place of part `index`, the best first, each term once."""
    rest = fitted.model.without(index)
    used = {part.term.name for part in fitted.model.parts}
    bare = evaluate(rest, case, noise)
    best: dict[str, Fit] = {}
    for part in _best_guesses(shelf, bare, case, noise):
        if part.term.name not in used:
            tried = fit(Model((*rest.parts, part)), case, noise, _SETTLED)
            if part.term.name not in best or tried.bic < best[part.term.name].bic:
                best[part.term.name] = tried
    return sorted(best.values(), key=lambda f: f.bic)


def _best_guesses(shelf: Shelf, beside: Fit, case: Case, noise: Noise) -> list[Part]:
    """Of each form the guess with the least loss beside a fit."""
    best: dict[tuple[str, str], tuple[float, Part]] = {}
    for part in shelf.parts:
        loss = evaluate(Model((*beside.model.parts, part)), case, noise).loss
        key = (part.label, part.form.key)
        if key not in best or loss < best[key][0]:
            best[key] = (loss, part)
    return [part for _, part in best.values()]


def _gained(found: Iterable[Fit], size: int) -> bool:
    """Whether the sets of one more name are any better than those of `size`."""
    by = {
        k: min((price(f) for f in found if len(f.model.parts) == k), default=np.inf) for k in (size, size + 1)
    }
    return by[size + 1] < by[size]


def _singles(shelf: Shelf, case: Case, noise: Noise, keep: Callable[[Model], Fit]) -> list[Fit]:
    """Each form from its two best guesses."""
    forms: dict[tuple[str, str], list[tuple[float, Part]]] = {}
    for part in shelf.parts:
        loss = evaluate(Model((part,)), case, noise).loss
        forms.setdefault((part.label, part.form.key), []).append((loss, part))
    tried = [part for guesses in forms.values() for _, part in sorted(guesses, key=lambda g: g[0])[:2]]
    fits = [keep(Model((part,))) for part in tried]
    best: dict[str, Fit] = {}
    for fitted in sorted(fits, key=price):
        best.setdefault(fitted.model.parts[0].label, fitted)
    return list(best.values())


def _pairs(
    shelf: Shelf,
    empty: Fit,
    singles: list[Fit],
    case: Case,
    noise: Noise,
    effort: Effort,
    keep: Callable[[Model], Fit],
) -> None:
    """Pairs that least squares finds promising, and the leading single terms with every other."""
    for one, two in _promising(shelf, empty, case, noise, effort.pairs):
        keep(Model((shelf.parts[one], shelf.parts[two])))
    for leader in singles[: effort.leaders]:
        for part in additions(shelf, leader, case, noise, len(shelf.parts)):
            keep(Model((leader.model.parts[0], part)))


def _promising(shelf: Shelf, empty: Fit, case: Case, noise: Noise, count: int) -> list[tuple[int, int]]:
    """Pairs of columns of different terms by what they explain together, the best guesses of each two forms."""
    m = shelf.columns.shape[1]
    if m < 2:
        return []
    residual = whiten(case.residual, noise.order)
    weight = (FREEDOM + 1.0) / (FREEDOM + (residual / empty.scale) ** 2)
    columns = whiten(shelf.columns, noise.order)
    size = np.sqrt((weight[:, None] * columns**2).sum(axis=0))
    columns = columns / np.where(size > 1e-12, size, np.inf)
    gram = columns.T @ (weight[:, None] * columns)
    pull = columns.T @ (weight * residual)
    one, two = np.triu_indices(m, 1)
    free = 1.0 - gram[one, two] ** 2
    gain = pull[one] ** 2 + pull[two] ** 2 - 2.0 * gram[one, two] * pull[one] * pull[two]
    gain = np.where(free > 1e-4, gain / np.maximum(free, 1e-4), 0.0)
    seen, result = set[tuple[str, ...]](), list[tuple[int, int]]()
    for at in np.argsort(-gain).tolist():
        a, b = shelf.parts[one[at]], shelf.parts[two[at]]
        key = (a.label, a.form.key, b.label, b.form.key)
        if len(result) >= count or gain[at] <= 0:
            break
        if not _rivals(a, b) and key not in seen:
            seen.add(key)
            result.append((int(one[at]), int(two[at])))
    return result


def _rivals(a: Part, b: Part) -> bool:
    """Whether two parts cannot stand in one model: forms of one term, unless of different axes."""
    return a.term.name == b.term.name and (a.form.axis < 0 or a.form.axis == b.form.axis)
