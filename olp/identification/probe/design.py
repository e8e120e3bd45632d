"""Which moves tell most: the rows that leave the least variance of what is wanted, before anything is measured.

V. V. Fedorov, Theory of Optimal Experiments (Academic Press 1972), chapter 3: exchanges until none helps; the
criterion is the average variance of prediction (I-optimality) of a Gaussian process.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Labels = NDArray[np.int64]

# Noise of one measured move, of the variance of the function: a hundredth of a second in three seconds.
NOISE = 0.01
_ROUNDS = 20
_GAIN = 1e-9


def most_telling(
    covariance: Floats, count: int, known: NDArray[np.bool_], allowed: NDArray[np.bool_]
) -> Labels:
    """(count,) rows to measure beside the `known` (n,) ones, among `allowed`: the most telling one first.

    `covariance` (n, n): of all moves; the variance left is averaged over all of them. Rows that are known already
    are not measured again. Gives fewer rows when fewer are allowed.
    """
    fixed = np.nonzero(known)[0]
    free = allowed & ~known
    chosen: list[int] = []
    left = _without(covariance, fixed)
    for _ in range(min(count, int(free.sum()))):
        best = _best(left, free, chosen)
        chosen.append(best)
        left = _less(left, best)
    for _ in range(_ROUNDS):
        changed = False
        for place, row in enumerate(chosen):
            others = chosen[:place] + chosen[place + 1 :]
            left = _without(covariance, np.concatenate([fixed, np.array(others, dtype=np.int64)]))
            gain = _gains(left, free, others)
            best = int(np.argmax(gain))
            if gain[best] > gain[row] * (1 + _GAIN):
                chosen[place] = best
                changed = True
        if not changed:
            break
    return _ranked(covariance, fixed, chosen)


def share_left(covariance: Floats, rows: Labels) -> float:
    """[1] The average standard deviation that measuring `rows` leaves, of the one before."""
    before = float(np.sqrt(np.diag(covariance)).mean())
    after = np.sqrt(np.maximum(np.diag(_without(covariance, rows)), 0.0))
    return float(after.mean()) / before


def _ranked(covariance: Floats, fixed: Labels, chosen: list[int]) -> Labels:
    """The same rows, each the most telling one after those before it."""
    left, rest, order = _without(covariance, fixed), sorted(chosen), []
    while rest:
        gain = _gains(left, np.ones(len(left), dtype=bool), [])
        best = max(rest, key=lambda row: float(gain[row]))
        rest.remove(best)
        order.append(best)
        left = _less(left, best)
    return np.array(order, dtype=np.int64)


def _gains(left: Floats, free: NDArray[np.bool_], taken: list[int]) -> Floats:
    gain = np.sum(left**2, axis=0) / (np.diag(left) + NOISE)
    gain[~free] = -1.0
    gain[taken] = -1.0
    return np.asarray(gain)


def _best(left: Floats, free: NDArray[np.bool_], taken: list[int]) -> int:
    return int(np.argmax(_gains(left, free, taken)))


def _less(left: Floats, row: int) -> Floats:
    """The covariance after one more row was measured."""
    column = left[:, row]
    return np.asarray(left - np.outer(column, column) / (column[row] + NOISE))


def _without(covariance: Floats, rows: Labels) -> Floats:
    """The covariance after `rows` were measured."""
    if not len(rows):
        return covariance
    own = covariance[np.ix_(rows, rows)] + NOISE * np.eye(len(rows))
    return np.asarray(covariance - covariance[:, rows] @ np.linalg.solve(own, covariance[rows]))
