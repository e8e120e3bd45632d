"""Which moves are held out together: start points, jobs, cycles or speeds where the recording has them, else blocks."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from olp.recording import Recording

Labels = NDArray[np.int64]

COUNT = 5  # folds
_LARGEST = 0.6  # of the moves that one group may hold
_ORDER = ("start", "job", "cycle", "speed")


class Folds(NamedTuple):
    by: str  # what the groups are
    labels: Labels  # (n,) 0 … COUNT - 1


def folds_of(recording: Recording, rows: Labels) -> Folds:
    """Groups dealt out into folds of about equal size."""
    groups = {name: labels[rows] for name, labels in recording.groups().items()}
    texts = sorted(name for name in groups if name not in (*_ORDER, "type"))
    for name in (*_ORDER[:2], *texts, *_ORDER[2:]):
        labels = groups.get(name)
        if labels is not None and _serves(labels):
            return Folds(name, _dealt(labels))
    return Folds("block", blocks(len(rows)))


def blocks(count: int) -> Labels:
    """Stretches of execution: two in each fold, so that a drift is not mistaken for a difference between folds."""
    pieces = min(2 * COUNT, max(count // 3, 2))
    return np.asarray((np.arange(count) * pieces // max(count, 1)) % COUNT, dtype=np.int64)


def interleaved(count: int) -> Labels:
    """Every fifth move; for effects that act in too few moves to spare a whole group."""
    return np.asarray(np.arange(count) % COUNT, dtype=np.int64)


def _serves(labels: Labels) -> bool:
    _, count = np.unique(labels, return_counts=True)
    return bool(len(count) >= 3 and count.max() <= _LARGEST * len(labels) and np.median(count) >= 2)


def _dealt(labels: Labels) -> Labels:
    """The largest groups first, each to the fold that has least."""
    names, count = np.unique(labels, return_counts=True)
    load, fold_of = np.zeros(min(COUNT, len(names)), dtype=np.int64), dict[int, int]()
    for at in np.argsort(-count, kind="stable").tolist():
        fold = int(np.argmin(load))
        fold_of[int(names[at])] = fold
        load[fold] += count[at]
    return np.array([fold_of[int(label)] for label in labels.tolist()], dtype=np.int64)
