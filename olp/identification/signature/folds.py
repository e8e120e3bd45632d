"""Holding out inside a recording: predictions for moves that the estimator has not seen, and the choice by them."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from olp.identification.signature.document import Score
from olp.identification.signature.estimator import duration_of, learnt, load_estimator, measured_slowness
from olp.identification.signature.moveset import MoveSet, direction_labels

if TYPE_CHECKING:
    from olp.robots.model import Robot

Floats = NDArray[np.float64]
Labels = NDArray[np.int64]

# Moves up to which every tenth is held out, and start points by twelfths; beyond, fifths and sixths tell as much.
_FEW = 150


class HeldOut(NamedTuple):
    """Predictions of moves by what was learnt without them; nan where nothing could be learnt."""

    slowness: Floats  # (n,) [s²/m]
    labels: Labels  # (n,) with which group each move was held out


def by_moves(count: int) -> Labels:
    """Return the fold (n,) of each move: every tenth move, of many every fifth, is in the same one.

    So the neighbours in time of a held-out move are learnt from.
    """
    return np.arange(count, dtype=np.int64) % (10 if count <= _FEW else 5)


def by_starts(moves: MoveSet) -> Labels | None:
    """Return the fold (n,) of each move by its start point; None with fewer than three points.

    Several points are in one fold when there are many.
    """
    labels = moves.start_labels
    if labels.max(initial=0) < 2:
        return None
    return labels % (12 if len(moves) <= _FEW else 6)


def by_directions(moves: MoveSet) -> Labels | None:
    """Return the fold (n,) of each move by its direction; None with fewer than three directions, too few to compare."""
    labels = direction_labels(moves)
    return labels if len(np.unique(labels)) > 2 else None


class Trial(NamedTuple):
    """A method's predictions of moves, of start points and of directions that it had not seen."""

    near: HeldOut
    far: HeldOut | None
    turned: HeldOut | None


def try_out(names: list[str], moves: MoveSet, robot: Robot | None) -> dict[str, Trial]:
    """Return the predictions of each named method in all three situations; None where the moves do not allow one."""
    folds = (by_moves(len(moves)), by_starts(moves), by_directions(moves))
    held = [None if labels is None else hold_out(names, moves, robot, labels) for labels in folds]
    near, far, turned = held
    assert near is not None
    return {
        name: Trial(near[name], far[name] if far else None, turned[name] if turned else None)
        for name in names
    }


def hold_out(names: list[str], moves: MoveSet, robot: Robot | None, labels: Labels) -> dict[str, HeldOut]:
    """Return the predictions of each method for each fold, learnt without that fold."""
    result = {name: np.full(len(moves), np.nan) for name in names}
    for label in np.unique(labels).tolist():
        out = labels == label
        if out.all():
            continue
        rest, asked = moves.take(~out), moves.take(out)
        for name in names:
            estimator = load_estimator(name)
            if not estimator.needs(rest, robot):
                parameters = learnt(name, rest, robot)
                result[name][out] = estimator.estimate(parameters, asked, robot).slowness
    return {name: HeldOut(slowness, labels) for name, slowness in result.items()}


def percentage(held: HeldOut | None, moves: MoveSet) -> float:
    """[%] mean absolute percentage error of the durations; nan where nothing was held out."""
    if held is None or np.isnan(held.slowness).all():
        return float("nan")
    error = np.abs(duration_of(held.slowness, moves) - moves.duration) / moves.duration
    return 100.0 * float(np.nanmean(error))


def residuals(held: HeldOut, moves: MoveSet) -> Floats:
    """(n,) [s²/m] measured less predicted."""
    return np.asarray(measured_slowness(moves) - held.slowness)


def score_of(trial: Trial, moves: MoveSet) -> Score:
    return Score(*(percentage(held, moves) for held in trial))


def merit(score: Score) -> float:
    """Return what the choice of a method minimises: the mean logarithm of its errors in the three situations.

    So 10 % less error counts the same in each.
    """
    known = [np.log(v) for v in score if np.isfinite(v) and v > 0]
    return float(np.mean(known)) if known else float("inf")


def merit_doubt(one: Trial, other: Trial, moves: MoveSet) -> float:
    """Standard error of the difference between the merits of two methods: groups that are held out are the sample.

    The jackknife over the groups of each situation (B. Efron, The jackknife, the bootstrap and other resampling
    plans, SIAM 1982, equation 3.13); situations count as independent.
    """
    variances = []
    for mine, others in zip(one, other, strict=True):
        if mine is None or others is None:
            continue
        first, second = (_group_sums(held, moves) for held in (mine, others))
        use = np.isfinite(first + second)
        first, second = first[use], second[use]
        count = len(first)
        without = first.sum() - first, second.sum() - second
        if count < 2 or min(without[0].min(), without[1].min()) <= 0:
            continue
        ratio = np.log(without[0] / without[1])
        variances.append((count - 1) / count * float(np.sum((ratio - ratio.mean()) ** 2)))
    return float(np.sqrt(np.sum(variances)) / len(variances)) if variances else 0.0


def _group_sums(held: HeldOut, moves: MoveSet) -> Floats:
    """(groups,) sums of the relative errors of each group that was held out together."""
    error = np.abs(duration_of(held.slowness, moves) - moves.duration) / moves.duration
    return np.asarray(np.bincount(np.unique(held.labels, return_inverse=True)[1], error), dtype=np.float64)
