"""Whether terms hold on groups of moves that their fit never saw, both ways: with them, and without them.

`selection` repeats the whole search inside each fold; its errors are the ones that a diagnosis quotes.
"""

from __future__ import annotations

from collections import Counter
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from olp.diagnosis.errors import rms
from olp.diagnosis.fitting import FREEDOM, Fit, Noise, fit
from olp.diagnosis.folds import Folds, interleaved
from olp.diagnosis.search import NARROW, move_terms, search, shelf_of
from olp.diagnosis.simplest import simplest
from olp.physics._case import Case
from olp.physics.term import Stage

Floats = NDArray[np.float64]

_TRIES, _STEPS = 1, 10  # sets of each size that are fitted on
_FEWEST = 3  # moves in which a term acts, in the training part of each fold


class Gain(NamedTuple):
    """What a term brings on moves that were not fitted."""

    loglik: float  # summed difference of log-likelihoods, with it less without it
    error: float  # its standard error
    before: float  # [s] RMSE without it
    after: float  # [s] RMSE with it

    @property
    def holds(self) -> bool:
        return self.loglik > 1.0 and self.loglik > 1.3 * self.error


class Selection(NamedTuple):
    """The search repeated inside the folds. Predictions are of moves that it did not see."""

    predicted: Floats  # (n,) [s]
    chosen: Counter[str]  # name -> in how many folds it was chosen
    folds: int
    sets: tuple[frozenset[str], ...] = ()  # the names that each fold chose


def gain_of(fitted: Fit, index: int, case: Case, noise: Noise, folds: Folds) -> Gain:
    """Adding part `index` to the others, held out by the folds."""
    labels = _labels_for(fitted, index, case, folds)
    with_it, without = (np.full(len(case), np.nan) for _ in range(2))
    for label in np.unique(labels).tolist():
        seen, held = _parts(labels, label)
        train, test = case.take(seen), case.take(held)
        with_it[held] = test.measured - fit(fitted.model, train, noise, 6).model.seconds(test)
        bare = fit(fitted.model.without(index), train, noise, 6)
        without[held] = test.measured - bare.model.seconds(test)
    difference = _loss(without, fitted.scale) - _loss(with_it, fitted.scale)
    return Gain(
        float(difference.sum()),
        float(difference.std() * np.sqrt(len(difference))),
        rms(without),
        rms(with_it),
    )


def lone_limit(fitted: Fit, index: int, case: Case) -> bool:
    """Whether part `index` is a limit that one or two moves reach: no other move can confirm it, and a wait there would
    look the same."""
    if fitted.model.parts[index].term.stage is not Stage.LIMITS:
        return False
    return 0 < int(_acts(fitted, index, case).sum()) < _FEWEST


def _acts(fitted: Fit, index: int, case: Case) -> NDArray[np.bool_]:
    """(n,) moves that a part changes by more than half of the scatter."""
    whole = fitted.model.seconds(case)
    return np.asarray(np.abs(whole - fitted.model.without(index).seconds(case)) > 0.5 * fitted.scale)


def selection(case: Case, noise: Noise, folds: Folds) -> Selection:
    """Search and fit without each fold, predict it."""
    predicted, sets = np.full(len(case), np.nan), list[frozenset[str]]()
    for label in np.unique(folds.labels).tolist():
        seen, held = _parts(folds.labels, label)
        train, test = case.take(seen), case.take(held)
        if not len(seen):
            predicted[held] = test.simulated
            continue
        found = search(train, noise, shelf_of(train, move_terms()), NARROW)
        best = simplest(found, train, noise, _TRIES, _STEPS)
        predicted[held] = best.model.seconds(test)
        sets.append(frozenset(best.names))
    return Selection(predicted, Counter(name for names in sets for name in names), len(sets), tuple(sets))


def placebo(fitted: Fit, case: Case, noise: Noise, times: int, seed: int = 1) -> float:
    """Share of searches that name something in what the model leaves, shuffled among the moves."""
    from dataclasses import replace

    rng = np.random.default_rng(seed)
    left = case.measured - fitted.model.seconds(case)
    left = left - np.median(left)
    found = 0
    for _ in range(times):
        shuffled = rng.permutation(left)
        blind = replace(case, measured=case.simulated + shuffled, derived={})
        found += bool(search(blind, noise, shelf_of(blind, move_terms()), NARROW)[0].model.parts)
    return found / times if times else float("nan")


def _labels_for(fitted: Fit, index: int, case: Case, folds: Folds) -> NDArray[np.int64]:
    """The folds, unless one of them holds nearly all moves in which the part acts."""
    acts = _acts(fitted, index, case)
    for label in np.unique(folds.labels).tolist():
        if acts[folds.labels != label].sum() < min(_FEWEST, acts.sum()):
            labels = np.zeros(len(case), dtype=np.int64)
            for some in (acts, ~acts):
                labels[some] = interleaved(int(some.sum()))
            return labels
    return folds.labels


def _parts(labels: NDArray[np.int64], label: int) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    return np.nonzero(labels != label)[0].astype(np.int64), np.nonzero(labels == label)[0].astype(np.int64)


def _loss(residual: Floats, scale: float) -> Floats:
    """(n,) minus log-likelihood of each."""
    return np.asarray(0.5 * (FREEDOM + 1.0) * np.log1p((residual / scale) ** 2 / FREEDOM))
