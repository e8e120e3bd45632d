"""Gradient boosting of regression trees with robust leaves: learns the residual of a law of physics.

J. H. Friedman, Greedy function approximation: a gradient boosting machine, Annals of Statistics 29 (2001):
splits by clipped gradients (Huber), leaves by medians, each tree a small step. Small and vectorised:
features are binned once, and a level of a tree is one histogram.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Ints = NDArray[np.int64]

_BINS: Final = 32
_DEPTH: Final = 4
_STEP: Final = 0.08  # share of each leaf's median that is added
_ROWS, _COLUMNS = 0.6, 0.5  # share of rows and features that a tree sees: trees that differ average better
_LEAF: Final = 5  # rows that a leaf holds at least
_CLIP: Final = 3.0  # scales beyond which a residual counts no more for a split
_RIDGE: Final = 3.0  # rows of residual zero in each leaf


@dataclass(frozen=True, slots=True, eq=False)
class BoostedTrees:
    """`edges`: (f) of each feature's bins. Complete trees: `feature`, `bin` (t, 2^depth - 1), `value` (t, 2^depth)."""

    base: float
    edges: tuple[Floats, ...]
    feature: Ints
    bin: Ints
    value: Floats

    def predict(self, features: Floats) -> Floats:
        """(n,) of features (n, f)."""
        return self.base + _sum(_binned(features, self.edges), self.feature, self.bin, self.value)

    def take(self, trees: int) -> BoostedTrees:
        """The first trees alone."""
        return BoostedTrees(self.base, self.edges, self.feature[:trees], self.bin[:trees], self.value[:trees])

    def to_json(self) -> dict[str, Any]:
        """Plain numbers."""
        return {
            "base": self.base,
            "edges": [edge.tolist() for edge in self.edges],
            "feature": self.feature.tolist(),
            "bin": self.bin.tolist(),
            "value": np.round(self.value, 7).tolist(),
        }

    @staticmethod
    def from_json(content: Any) -> BoostedTrees:
        """Raises KeyError, TypeError or ValueError for what is no such model."""
        edges = tuple(np.array(edge, dtype=np.float64) for edge in content["edges"])
        feature, bins = (np.array(content[key], dtype=np.int64) for key in ("feature", "bin"))
        value = np.array(content["value"], dtype=np.float64)
        if (
            feature.shape != bins.shape
            or feature.ndim != 2
            or value.shape != (len(feature), feature.shape[1] + 1)
        ):
            raise ValueError("trees of different shapes")
        if feature.size and not (feature.min() >= 0 and feature.max() < len(edges)):
            raise ValueError("a tree asks for a feature that there is not")
        return BoostedTrees(float(content["base"]), edges, feature, bins, value)


def fit_trees(features: Floats, target: Floats, rounds: int, seed: int = 0) -> BoostedTrees:
    """`features` (n, f), `target` (n,) finite; deterministic for a `seed`."""
    count, width = features.shape
    draw = np.random.default_rng(seed)
    quantiles = np.linspace(0.0, 1.0, _BINS + 1)[1:-1]
    edges = tuple(np.unique(np.quantile(features[:, f], quantiles)) for f in range(width))
    binned = _binned(features, edges)
    base = float(np.median(target))
    left = target - base
    feature, bins, value = [], [], []
    rows, columns = max(int(_ROWS * count), 1), max(int(_COLUMNS * width), 1)
    for _ in range(rounds):
        use = draw.choice(count, rows, replace=False)
        some = np.sort(draw.choice(width, columns, replace=False))
        clip = _CLIP * 1.4826 * float(np.median(np.abs(left)))
        own_feature, own_bin, node = _grow(binned[np.ix_(use, some)], np.clip(left[use], -clip, clip))
        leaf = _STEP * _leaves(node, left[use])
        feature.append(some[own_feature])
        bins.append(own_bin)
        value.append(leaf)
        left = left - leaf[_descend(binned, feature[-1], own_bin)]
    shape = (0, 2**_DEPTH - 1)
    return BoostedTrees(
        base,
        edges,
        np.array(feature, dtype=np.int64).reshape(-1, shape[1]),
        np.array(bins, dtype=np.int64).reshape(-1, shape[1]),
        np.array(value).reshape(-1, 2**_DEPTH),
    )


def _binned(features: Floats, edges: tuple[Floats, ...]) -> NDArray[np.int8]:
    columns = [np.searchsorted(edge, features[:, f], side="right") for f, edge in enumerate(edges)]
    return np.stack(columns, axis=1).astype(np.int8)


def _grow(binned: NDArray[np.int8], gradient: Floats) -> tuple[Ints, Ints, Ints]:
    """Feature and bin of every inner node, and the leaf of every row."""
    count, width = binned.shape
    feature, bins = np.zeros(2**_DEPTH - 1, dtype=np.int64), np.full(2**_DEPTH - 1, _BINS, dtype=np.int64)
    node = np.zeros(count, dtype=np.int64)
    pull, every = np.repeat(gradient, width), np.arange(width) * _BINS
    place = binned.astype(np.int64) + every
    for level in range(_DEPTH):
        nodes = 2**level
        where = (place + node[:, None] * (width * _BINS)).ravel()
        shape = (nodes, width, _BINS)
        sums = np.bincount(where, pull, nodes * width * _BINS).reshape(shape).cumsum(axis=2)
        counts = np.bincount(where, minlength=nodes * width * _BINS).reshape(shape).cumsum(axis=2)
        rest_sum, rest_count = sums[:, :, -1:] - sums, counts[:, :, -1:] - counts
        gain = sums**2 / (counts + _RIDGE) + rest_sum**2 / (rest_count + _RIDGE)
        gain -= sums[:, :, -1:] ** 2 / (counts[:, :, -1:] + _RIDGE)
        gain = np.where((counts < _LEAF) | (rest_count < _LEAF), 0.0, gain).reshape(nodes, -1)
        best = np.argmax(gain, axis=1)
        good = gain[np.arange(nodes), best] > 0
        first = nodes - 1
        feature[first : first + nodes] = np.where(good, best // _BINS, 0)
        bins[first : first + nodes] = np.where(good, best % _BINS, _BINS)
        chosen = binned[np.arange(count), feature[first + node]]
        node = 2 * node + (chosen > bins[first + node])
    return feature, bins, node


def _leaves(node: Ints, left: Floats) -> Floats:
    """(2^depth,) median of each leaf, drawn to zero where a leaf holds few."""
    order = np.lexsort((left, node))
    counts = np.bincount(node, minlength=2**_DEPTH)
    begin = np.cumsum(counts) - counts
    ordered = left[order]
    last = len(left) - 1
    low, high = (np.minimum(begin + half, last) for half in ((counts - 1) // 2, counts // 2))
    median = (ordered[low] + ordered[high]) / 2
    return np.asarray(np.where(counts > 0, median * counts / (counts + _RIDGE), 0.0))


def _descend(binned: NDArray[np.int8], feature: Ints, bins: Ints) -> Ints:
    """(n,) the leaf of every row in one tree."""
    node = np.zeros(len(binned), dtype=np.int64)
    every = np.arange(len(binned))
    for level in range(_DEPTH):
        inner = 2**level - 1 + node
        node = 2 * node + (binned[every, feature[inner]] > bins[inner])
    return node


def _sum(binned: NDArray[np.int8], feature: Ints, bins: Ints, value: Floats) -> Floats:
    total = np.zeros(len(binned))
    for own_feature, own_bin, own_value in zip(feature, bins, value, strict=True):
        total += own_value[_descend(binned, own_feature, own_bin)]
    return total
