"""From a case to the terms that are named: search, waits set apart, evidence on moves that were not fitted."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from olp.identification.diagnosis.conditions import conditioned
from olp.identification.diagnosis.evidence import (
    CUT,
    Gain,
    Selection,
    chosen,
    confirmed,
    cut,
    folds_for,
    noise_left,
    remains_beside,
    selection,
)
from olp.identification.diagnosis.fitting import ModelFit, Noise, fit, unlikely_in_order
from olp.identification.diagnosis.folds import Folds, kinds_of
from olp.identification.diagnosis.model import DurationModel
from olp.identification.diagnosis.residuals import Remains, remains_of
from olp.identification.diagnosis.search import (
    PRICE,
    WIDE,
    PartShelf,
    exchanged,
    merged,
    move_terms,
    of_all_axes,
    price,
    reformed,
    search,
    shelf_of,
)
from olp.identification.diagnosis.waits import (
    late_moves,
    of_one_line,
    price_of_waits,
    spread,
    told_by_unseen_moves,
    waiting_moves,
    with_its_line,
)
from olp.timing.physics._case import MeasuredMoves

Mask = NDArray[np.bool_]
Labels = NDArray[np.int64]

_ROUNDS = 2  # of search and setting waits apart
_STAMPS = -0.5  # correlation of neighbours that share their time stamps
_ORDERS = (-0.49, -0.45, -0.4, -0.3)  # of neighbours that share their stamps
_LEAST_ORDER, _MOST_ORDER = -0.49, 0.95  # of the correlation of neighbours
_BY_CHANCE = 3.3  # standard deviations that chance passes in one of two thousand recordings


class NamingResult(NamedTuple):
    """What the search came to."""

    fit: ModelFit
    late: Mask  # (n,) of the whole case: moves that are left out of the clean one
    waiting: Mask  # (n,) those, and moves that wait for less
    clean: MeasuredMoves  # the case without late moves
    noise: Noise
    shelf: PartShelf
    folds: Folds  # of the clean case
    selection: Selection
    gains: tuple[Gain, ...]
    remains: Remains
    groups: dict[str, Labels]  # of the clean case
    fallen: dict[str, str]  # names that the search found and moves do not confirm: why


def name(case: MeasuredMoves, noise: Noise, folds: Folds, groups: dict[str, Labels]) -> NamingResult:
    """Search, set waits apart, search again, and drop what does not hold on moves that were not fitted."""
    whole = shelf_of(case, move_terms())
    known = _everywhere(case, noise, whole)
    late, best = _set_apart(known, case, noise, whole)
    clean, shelf = _without(late, case, whole)
    for last in (False,) * (_ROUNDS - 1) + (True,):
        noise = noise._replace(order=_order(best, clean))
        if noise.order:
            best = _found(clean, noise, shelf)
        again = _waits(best, case, noise)
        if last or np.array_equal(again, late):
            break
        late = again
        clean, shelf = _without(late, case, whole)
        best = _found(clean, noise, shelf, None if late.any() else known)
    clean_folds = Folds(folds.by, folds.labels[~late])
    best, gains, fell = confirmed(
        fit(best.model, clean, noise, 30), clean, noise, clean_folds, shelf, kinds_of(groups, late)
    )
    if not np.array_equal(again := _waits(best, case, noise), late):
        # Beside the names that hold, some are late no longer; or some are, and a name that fell had them.
        late, clean_folds = again, Folds(folds.by, folds.labels[~again])
        clean, shelf = _without(late, case, whole)
        best = _found(clean, noise, shelf) if late.any() else best
        best, gains, fell = confirmed(
            fit(best.model, clean, noise, 30), clean, noise, clean_folds, shelf, kinds_of(groups, late)
        )
    if (
        order := _order(best, clean)
    ) != noise.order:  # names under a condition have left less than the search
        noise = noise._replace(order=order)
        best = fit(best.model, clean, noise, 30)
    clean_folds = folds_for(best, range(len(best.model.parts)), clean, clean_folds)
    seen = selection(clean, noise, clean_folds, shelf, best.model)
    clean_groups = {name: labels[~late] for name, labels in groups.items()}
    remains = remains_beside(best.model, clean, noise, clean_groups)
    residual = case.measured - best.model.seconds(case)
    waiting = waiting_moves(late, residual, spread(residual[~late], noise.least), case.resolution)
    if (there := of_one_line(late, case)).any():
        waiting &= there
    return NamingResult(
        best, late, waiting, clean, noise, shelf, clean_folds, seen, gains, remains, clean_groups, fell
    )


def _set_apart(known: ModelFit, case: MeasuredMoves, noise: Noise, whole: PartShelf) -> tuple[Mask, ModelFit]:
    """(n,) the moves that wait beside what is `known` without conditions, or beside nothing where a name made up for a
    part of their waits, and what the others tell; none where a name under a condition explains all moves at a lower
    price: each would make up for some of what the other does."""
    late, best = _waits(known, case, noise), _found(case, noise, whole, known)
    if not late.any():
        late = _waits(fit(DurationModel(), case, noise), case, noise)
    if late.any():
        clean, shelf = _without(late, case, whole)
        apart = _found(clean, noise, shelf)
        if price(apart) + _price_apart(late, apart) < price(best):
            return late, apart
    return np.zeros_like(late), best


def price_of(named: NamingResult) -> float:
    """In BIC, of the names and of the moves that are set apart."""
    return price(named.fit) + _price_apart(named.late, named.fit)


def _price_apart(late: Mask, apart: ModelFit) -> float:
    """In BIC, of the moves that are `late` (n,) beside a fit to the others."""
    few = int(late.sum())
    return (
        PRICE + price_of_waits(few, len(late), len(late)) + 2.0 * few * math.log(apart.scale) if few else 0.0
    )


def _without(late: Mask, case: MeasuredMoves, whole: PartShelf) -> tuple[MeasuredMoves, PartShelf]:
    """The moves that are not `late` (n,) and what parts do to them; of all moves that is `whole`."""
    if not late.any():
        return case, whole
    clean = case.take(np.nonzero(~late)[0].astype(np.int64))
    return clean, shelf_of(clean, move_terms())


def instead(named: NamingResult, model: DurationModel) -> NamingResult:
    """Other names, fitted, confirmed and held against unseen moves like those that were found."""
    clean, noise = named.clean, named.noise
    kinds = kinds_of(named.groups, np.zeros(len(clean), dtype=bool))
    best, gains, fell = confirmed(fit(model, clean, noise, 30), clean, noise, named.folds, named.shelf, kinds)
    seen = selection(clean, noise, named.folds, named.shelf, best.model, named.selection.found)
    return _with(named, best, gains)._replace(selection=seen, fallen=fell)


def nameless(named: NamingResult) -> NamingResult:
    """No name at all."""
    return _with(named, fit(DurationModel(), named.clean, named.noise), ())


def _with(named: NamingResult, best: ModelFit, gains: tuple[Gain, ...]) -> NamingResult:
    remains = remains_beside(best.model, named.clean, named.noise, named.groups)
    return named._replace(fit=best, gains=gains, remains=remains)


def _found(clean: MeasuredMoves, noise: Noise, shelf: PartShelf, known: ModelFit | None = None) -> ModelFit:
    """Fitted to the end: what few moves tell is far off after few steps. `known`: what was found without conditions."""
    best = known if known is not None else _everywhere(clean, noise, shelf)
    return fit(conditioned(best, clean, noise, shelf, WIDE.additions).model, clean, noise, 30)


def _everywhere(clean: MeasuredMoves, noise: Noise, shelf: PartShelf) -> ModelFit:
    """Without conditions."""
    best = reformed(chosen(search(clean, noise, shelf, WIDE), clean, noise), shelf, clean, noise)
    best = of_all_axes(exchanged(best, shelf, clean, noise), shelf, clean, noise)
    best = merged(best, shelf, clean, noise)
    return reformed(best, shelf, clean, noise)


def _order(best: ModelFit, clean: MeasuredMoves) -> float:
    """Correlation between neighbours in what the best set leaves; 0 where they alternate, as no shared stamp does."""
    left = clean.measured - best.model.seconds(clean)
    order = remains_of(left, clean, {}).order
    if order < _STAMPS - _BY_CHANCE / math.sqrt(len(left)) or abs(order) <= 0.1:
        return 0.0
    order = float(np.clip(order, _LEAST_ORDER, _MOST_ORDER))
    if order > 0.0:
        return order
    # Neighbours tell their correlation less surely than all moves do that scatter is of stamps alone, or that one far
    # move would echo for long.
    return min((order, *_ORDERS), key=lambda one: unlikely_in_order(left, one, clean))


def _waits(best: ModelFit, case: MeasuredMoves, noise: Noise) -> Mask:
    """(n,) the late moves, or none where that takes away less than it leaves, or unseen moves do not tell it from the
    tails of a scatter: waits are a name, too."""
    late = late_moves(best, case, noise.least)
    rest = np.nonzero(~late)[0].astype(np.int64)
    left = case.measured - best.model.seconds(case)
    floor = noise_left(best, case.take(rest), noise)
    held = (
        late.any()
        and cut(left, left[rest], floor) >= CUT
        and told_by_unseen_moves(left, noise.least, case.resolution)
    )
    return with_its_line(late, left, case) if held else np.zeros_like(late)
