"""Which moves are held out together: start points, jobs or cycles where the recording has them, else blocks.

Not speeds: a law is told by how they differ, and nobody could know it without one of few.

Groups are dealt so that the difference is spread over the folds, as in stratified k-fold validation by groups: a fold
with nearly all moves in which something acts would ask for what nobody can know from the others.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from olp.identification.diagnosis.result import Errors

if TYPE_CHECKING:
    from olp.identification.recording.recording import Recording


Labels = NDArray[np.int64]
Floats = NDArray[np.float64]

COUNT = 5  # folds
_LARGEST = 0.6  # of the moves that one group may hold
HALF = 0.5  # of the square of a difference: no fold holds more, nobody could know it from the others
_BEYOND = 3.0  # times the middle's scatter: what a move differs by beyond that counts as the difference
_CAPPED = 0.9  # quantile of it that a single move counts at most: no single wait decides
EACH_FIFTH = "every fifth move"  # what the groups are where every fifth move is one
_FIRST, _LAST = (
    ("start", "job"),
    "cycle",
)  # kinds of groups; between them those that the recording's texts name
_FINE = 1000  # parts of a move that sums are rounded to
_NO_FOLDS = ("speed", "type")


class Folds(NamedTuple):
    by: str  # what the groups are
    labels: Labels  # (n,) 0 … COUNT - 1


def folds_of(recording: Recording, rows: Labels, residual: Floats | None = None) -> Folds:
    """Groups dealt out into folds of about equal size. `residual` (n,) [s] measured less simulated of the `rows`."""
    groups = {name: labels[rows] for name, labels in recording.groups().items()}
    texts = sorted(name for name in groups if name not in (*_FIRST, _LAST, *_NO_FOLDS))
    weight = _beyond(residual) if residual is not None else np.zeros(len(rows))
    found = list[Folds]()
    for name in (*_FIRST, *texts, _LAST):
        labels = groups.get(name)
        if labels is not None and _serves(labels):
            found.append(Folds(name, _dealt(labels, weight)))
    found.append(Folds("block", blocks(len(rows))))
    found.append(Folds(EACH_FIFTH, interleaved(recording.repeats()[rows])))
    square = weight**2
    spread = [f for f in found if np.bincount(f.labels, square).max() <= HALF * float(square.sum())]
    return (spread or found)[0]


def kinds_of(groups: dict[str, Labels], late: NDArray[np.bool_]) -> list[Folds]:
    """Every way to hold out whole places, programs and what columns tell, of the moves that are not `late` (n,).

    Not speeds and types of moves, see above.
    """
    some = {name: labels[~late] for name, labels in groups.items() if name not in _NO_FOLDS}
    even = np.zeros(int((~late).sum()))
    return [Folds(name, _dealt(labels, even)) for name, labels in some.items() if _serves(labels, 2)]


def _beyond(residual: Floats) -> Floats:
    """(n,) [s] by how much each move differs beyond the middle ones."""
    off = np.abs(residual - np.median(residual))
    beyond = np.maximum(off - _BEYOND * 1.4826 * float(np.median(off)), 0.0)
    if not (beyond > 0).any():
        return beyond
    return np.asarray(np.minimum(beyond, np.quantile(beyond[beyond > 0], _CAPPED)))


def blocks(count: int) -> Labels:
    """Stretches of execution: two in each fold, so that a drift is not mistaken for a difference between folds."""
    pieces = min(2 * COUNT, max(count // 3, 2))
    return np.asarray((np.arange(count) * pieces // max(count, 1)) % COUNT, dtype=np.int64)


def interleaved(programmed: Labels) -> Labels:
    """Every fifth programmed move with all its repeats, by labels (n,) of what was programmed alike; of fewer than five
    every fifth repeat. For effects that act in too few moves to spare a whole group."""
    _, first, place = np.unique(programmed, return_index=True, return_inverse=True)
    turn = np.argsort(np.argsort(first))[place] if len(first) >= COUNT else np.arange(len(programmed))
    return np.asarray(turn % COUNT, dtype=np.int64)


def _serves(labels: Labels, groups: int = 3) -> bool:
    _, count = np.unique(labels, return_counts=True)
    return bool(len(count) >= groups and count.max() <= _LARGEST * len(labels) and np.median(count) >= 2)


def _dealt(labels: Labels, weight: Floats) -> Labels:
    """The groups with most of the difference first, then the largest, then the first in the recording, each to the
    first fold that has least of both. Sums are whole thousandths of a move: no last bit decides."""
    names, place, count = np.unique(labels, return_inverse=True, return_counts=True)
    share = np.bincount(place, weight) / max(float(weight.sum()), 1e-300)
    size, amount = _FINE * count, np.rint(_FINE * len(labels) * share).astype(np.int64)
    load, fold_of = np.zeros(min(COUNT, len(names)), np.int64), np.zeros(len(names), np.int64)
    for at in np.lexsort((-count, -np.maximum(amount, size))).tolist():
        fold_of[at] = int(np.argmin(load))
        load[fold_of[at]] += size[at] + amount[at]
    return np.asarray(fold_of[place])


# --- Errors ---
# How far predicted durations are from measured ones.


def rms(values: Floats) -> float:
    """Root mean square, in the unit of `values` (n,); 0 of nothing."""
    return float(np.sqrt(np.mean(values**2))) if len(values) else 0.0


def errors_of(residual: Floats, measured: Floats) -> Errors:
    """RMSE [s], mean and worst absolute percentage, of residuals (n,) [s] of measured durations (n,) [s]."""
    if not len(residual):
        return Errors(math.nan, math.nan, math.nan)
    share = 100.0 * np.abs(residual) / np.where(measured > 0, measured, np.nan)
    return Errors(rms(residual), float(np.nanmean(share)), float(np.nanmax(share)))
