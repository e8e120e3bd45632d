"""Small linear models: which few of many named terms explain, judged by groups that are held out.

Every subset of up to `most` terms is fitted by ridge regression without each group in turn, all at once by normal
equations. The best ones answer together, by their median: where they disagree, the answer is not known.
"""

from __future__ import annotations

from itertools import combinations
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Labels = NDArray[np.int64]


class SubsetModel(NamedTuple):
    """One small model: an intercept and a weight for each of its terms."""

    terms: tuple[int, ...]
    weights: Floats  # (1 + len(terms),)


def all_subsets(count: int, most: int) -> list[tuple[int, ...]]:
    """Every choice of one to `most` of `count` terms."""
    return [c for size in range(1, most + 1) for c in combinations(range(count), size)]


def grouped_errors(
    terms: Floats,
    values: Floats,
    scale: Floats,
    labels: Labels,
    subsets: list[tuple[int, ...]],
    ridge: float,
) -> Floats:
    """(m,) mean over groups of the mean |error| / `scale` of each subset, each group predicted by the others.

    `terms` (n, k) standardised, `values`, `scale` (n,). `ridge`: in observations of weight one per term.
    """
    columns = np.concatenate([np.ones((len(terms), 1)), terms], axis=1)
    whole, right = columns.T @ columns, columns.T @ values
    groups = [np.nonzero(labels == g)[0] for g in np.unique(labels).tolist()]
    result = np.empty(len(subsets))
    for size in sorted({len(s) for s in subsets}):
        which = [i for i, s in enumerate(subsets) if len(s) == size]
        picked = np.array([(0, *(t + 1 for t in subsets[i])) for i in which])
        damping = np.diag([0.0] + [ridge] * size)
        total = np.zeros(len(which))
        for rows in groups:
            own = columns[rows]
            left = (whole - own.T @ own)[picked[:, :, None], picked[:, None, :]] + damping
            weights = np.linalg.solve(left, (right - own.T @ values[rows])[picked][:, :, None])[:, :, 0]
            dense = np.zeros((len(which), columns.shape[1]))
            np.put_along_axis(dense, picked, weights, axis=1)
            error = np.abs(own @ dense.T - values[rows, None]) / scale[rows, None]
            total += error.mean(axis=0)
        result[which] = total / len(groups)
    return result


def fit_member(
    terms: Floats, values: Floats, weight: Floats, chosen: tuple[int, ...], ridge: float
) -> SubsetModel:
    """Ridge regression of one subset; `weight` (n,) of the rows."""
    columns = np.concatenate([np.ones((len(terms), 1)), terms[:, list(chosen)]], axis=1)
    damping = np.diag([0.0] + [ridge] * len(chosen))
    left = columns.T @ (columns * weight[:, None]) + damping
    return SubsetModel(
        chosen, np.asarray(np.linalg.solve(left, columns.T @ (values * weight)), dtype=np.float64)
    )


def answers(members: list[SubsetModel], terms: Floats) -> Floats:
    """(n, members)"""
    return np.stack([m.weights[0] + terms[:, list(m.terms)] @ m.weights[1:] for m in members], axis=1)
