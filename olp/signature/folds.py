"""Holding out inside a recording: predictions for moves that the estimator has not seen, and the choice by them."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from olp.signature.document import Score
from olp.signature.estimator import Estimator, duration_of, measured_slowness
from olp.signature.moveset import MoveSet, direction_labels

if TYPE_CHECKING:
    from olp.robot import Robot

Floats = NDArray[np.float64]
Labels = NDArray[np.int64]

# Moves up to which every tenth is held out, and start points by twelfths; beyond, fifths and sixths tell as much.
_FEW = 200


class HeldOut(NamedTuple):
    """Predictions of moves by what was learnt without them; nan where nothing could be learnt."""

    slowness: Floats  # (n,) [s²/m]
    labels: Labels  # (n,) with which group each move was held out


def by_moves(count: int) -> Labels:
    """Every tenth (of many moves every fifth) together, so that its neighbours in time stay."""
    return np.arange(count, dtype=np.int64) % (10 if count <= _FEW else 5)


def by_starts(moves: MoveSet) -> Labels | None:
    """Start points, several together when there are many; None with fewer than three."""
    labels = moves.start_labels
    if labels.max(initial=0) < 2:
        return None
    return labels % (12 if len(moves) <= _FEW else 6)


def by_directions(moves: MoveSet) -> Labels | None:
    """The senses of the motion; None when all moves have the same."""
    labels = direction_labels(moves)
    return labels if len(np.unique(labels)) > 1 else None


def hold_out(estimator: Estimator, moves: MoveSet, robot: Robot | None, labels: Labels) -> HeldOut:
    """Fits without each group in turn."""
    result = np.full(len(moves), np.nan)
    for label in np.unique(labels).tolist():
        out = labels == label
        rest = moves.take(~out)
        if out.all() or estimator.needs(rest, robot):
            continue
        parameters = estimator.fit(rest, robot)
        result[out] = estimator.estimate(parameters, moves.take(out), robot).slowness
    return HeldOut(result, labels)


def percentage(held: HeldOut | None, moves: MoveSet) -> float:
    """[%] mean absolute percentage error of the durations; nan where nothing was held out."""
    if held is None or np.isnan(held.slowness).all():
        return float("nan")
    error = np.abs(duration_of(held.slowness, moves) - moves.duration) / moves.duration
    return 100.0 * float(np.nanmean(error))


def residuals(held: HeldOut, moves: MoveSet) -> Floats:
    """(n,) [s²/m] measured less predicted."""
    return np.asarray(measured_slowness(moves) - held.slowness)


def score_of(near: HeldOut, far: HeldOut | None, turned: HeldOut | None, moves: MoveSet) -> Score:
    return Score(*(percentage(held, moves) for held in (near, far, turned)))


def merit(score: Score) -> float:
    """What the choice minimises: the situations count by ratio, a tenth off any is worth the same."""
    known = [np.log(v) for v in score if np.isfinite(v) and v > 0]
    return float(np.mean(known)) if known else float("inf")
