"""From a case to the terms that are believed: search, waits set apart, confirmation on moves that were not fitted."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from olp.diagnosis import confirm
from olp.diagnosis.fitting import Fit, Noise, fit
from olp.diagnosis.folds import Folds
from olp.diagnosis.remains import Remains, remains_of
from olp.diagnosis.search import WIDE, Shelf, move_terms, search, shelf_of, swaps
from olp.diagnosis.simplest import SMALL, TELLING, simplest, worth
from olp.diagnosis.waits import late_moves, spread, waiting_moves
from olp.diagnosis.ways import ALIKE
from olp.physics._case import Case

Floats = NDArray[np.float64]
Mask = NDArray[np.bool_]
Labels = NDArray[np.int64]

_DRIFT, _STILL = "warm-up", 0.2  # correlation of neighbours that a drift's own term may leave
_ENDS = 0.97  # of the longest time constant that a recording can tell, its own length
_TRIES, _STEPS = 3, 25  # sets of each size that are fitted to the end
_LONE = 15.0  # in BIC: of a limit in so few moves that no others confirm it
_ROUNDS = 2  # of search and setting waits apart


class Named(NamedTuple):
    """What the search came to."""

    fit: Fit
    late: Mask  # (n,) of the whole case: moves that are left out of the clean one
    waiting: Mask  # (n,) those, and moves that wait for less
    clean: Case  # the case without late moves
    noise: Noise
    shelf: Shelf
    folds: Folds  # of the clean case
    selection: confirm.Selection
    gains: tuple[confirm.Gain, ...]
    remains: Remains


def name(case: Case, noise: Noise, folds: Folds, groups: dict[str, Labels]) -> Named:
    """Search, set waits apart, search again, and drop what does not hold on moves that were not fitted."""
    late = np.zeros(len(case), dtype=bool)
    for last in (False,) * (_ROUNDS - 1) + (True,):
        clean = case.take(np.nonzero(~late)[0].astype(np.int64))
        shelf = shelf_of(clean, move_terms())
        best = _chosen(clean, noise, shelf)
        noise = noise._replace(order=_order(best, clean))
        if noise.order:
            best = _chosen(clean, noise, shelf)
        again = late_moves(best, case, noise.least)
        if last or np.array_equal(again, late):
            break
        late = again
    clean_folds = Folds(folds.by, folds.labels[~late])
    selection = confirm.selection(clean, noise, clean_folds)
    best, gains = _confirmed(fit(best.model, clean, noise, 30), clean, noise, clean_folds, selection, shelf)
    clean_groups = {name: labels[~late] for name, labels in groups.items()}
    remains = remains_of(clean.measured - best.model.seconds(clean), clean, clean_groups)
    drifting = [k for k, part in enumerate(best.model.parts) if part.term.name == _DRIFT]
    if drifting and remains.order > _STILL:
        # What still drifts beside an exponential was none.
        bare = fit(best.model.without(drifting[0]), clean, noise, 30)
        best, gains = _confirmed(bare, clean, noise, clean_folds, selection, shelf)
        remains = remains_of(clean.measured - best.model.seconds(clean), clean, clean_groups)
    residual = case.measured - best.model.seconds(case)
    waiting = waiting_moves(late, residual, spread(residual[~late], noise.least), case.resolution)
    return Named(best, late, waiting, clean, noise, shelf, clean_folds, selection, gains, remains)


def _chosen(clean: Case, noise: Noise, shelf: Shelf) -> Fit:
    return simplest(search(clean, noise, shelf, WIDE), clean, noise, _TRIES, _STEPS)


def _order(best: Fit, clean: Case) -> float:
    """Correlation between neighbours in what the best set leaves; a whitened search is fairer then."""
    left = clean.measured - best.model.seconds(clean)
    order = remains_of(left, clean, {}).order
    return order if abs(order) > 0.1 else 0.0


def _confirmed(
    best: Fit, case: Case, noise: Noise, folds: Folds, selection: confirm.Selection, shelf: Shelf
) -> tuple[Fit, tuple[confirm.Gain, ...]]:
    """The parts that held-out moves confirm, the weakest removed one at a time."""
    while best.model.parts:
        gains = [confirm.gain_of(best, k, case, noise, folds) for k in range(len(best.model.parts))]
        whole = float(np.mean((best.model.seconds(case) - case.simulated) ** 2))
        weak = [
            k
            for k, gain in enumerate(gains)
            if not (gain.holds or _sure_alone(best, k, case, noise))
            or _dispensable(best, k, case, noise, whole)
            or _seldom(best, k, selection, case, noise, shelf)
            or _endless(best, k)
        ]
        if not weak:
            return best, tuple(gains)
        worst = min(weak, key=lambda k: gains[k].loglik)
        best = fit(best.model.without(worst), case, noise, 30)
    return best, ()


def _sure_alone(best: Fit, index: int, case: Case, noise: Noise) -> bool:
    """Whether a limit that one or two moves reach is worth so much that it is told, beside the wait that it may be."""
    if not confirm.lone_limit(best, index, case):
        return False
    return worth(fit(best.model.without(index), case, noise, 15), best) > _LONE


def _dispensable(best: Fit, index: int, case: Case, noise: Noise, whole: float) -> bool:
    """Whether the others do nearly as well without part `index`: by BIC, or by what they predict. `whole` [s²]: mean
    square of all that is explained."""
    others = fit(best.model.without(index), case, noise, 15)
    missed = float(np.mean((best.model.seconds(case) - others.model.seconds(case)) ** 2))
    return worth(others, best) < TELLING or missed < SMALL * whole


def _endless(best: Fit, index: int) -> bool:
    """Whether a drift does not end within the recording: a straight line is no exponential."""
    part = best.model.parts[index]
    return part.term.name == _DRIFT and float(part.values[1]) > _ENDS * part.form.parameters[1].high


def _seldom(
    best: Fit, index: int, selection: confirm.Selection, case: Case, noise: Noise, shelf: Shelf
) -> bool:
    """Whether most searches inside the folds chose neither the term nor one that looks like it: by what is known, or by
    these moves, in which it would do as well."""
    term = best.model.parts[index].term
    others = {part.term.name for k, part in enumerate(best.model.parts) if k != index}
    like = {term.name, *term.confusable} - others
    if 2 * _votes(like, selection) >= selection.folds:
        return False
    if not _votes({term.name}, selection):
        return True
    used = set(best.names)
    for other in swaps(best, index, shelf, case, noise):
        if other.bic - best.bic < ALIKE:
            like |= set(other.names) - used
    return 2 * _votes(like, selection) < selection.folds


def _votes(like: set[str], selection: confirm.Selection) -> int:
    return sum(bool(like & names) for names in selection.sets)
