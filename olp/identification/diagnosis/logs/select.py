"""Which few of several terms explain a residual: all small sets compete, then blocks that no fit saw decide.

Data and library come whitened, cut into blocks. All that is asked of them (every set's fit, every fold's error)
follows from one matrix of products per block, so sets cost nothing.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from itertools import combinations, pairwise

import numpy as np
from numpy.typing import NDArray

from olp.identification.diagnosis.logs.statistics import student_quantile, student_tail

Floats = NDArray[np.float64]
Flags = NDArray[np.bool_]
BLOCKS = 12
FOLDS = 4
Set = tuple[int, ...]


@dataclass(frozen=True, slots=True)
class LibraryColumn:
    """One column of the library. `term` "" is always in (offset, inertia, gravity); `parameters` it costs.

    `positive`: a negative size has no meaning.
    """

    term: str
    positive: bool = False
    parameters: int = 1


@dataclass(frozen=True, slots=True, eq=False)
class Products:
    """(b, d, d) X'X of every block; the last of the d columns is the residual to explain. `count` (b,) samples.

    `prior` (d,): what is added per sample to a column's own square, so that directions that the motion hardly excites
    stay small; 0 leaves a column to the data.
    """

    blocks: Floats
    count: Floats
    columns: tuple[LibraryColumn, ...]
    prior: Floats

    @property
    def total(self) -> Floats:
        return np.asarray(self.blocks.sum(axis=0))

    def fit(self, members: Set, use: Flags | None = None) -> Floats:
        """(p,) sizes of the columns `members`, from the blocks `use` (b,) or from all."""
        blocks, count = (self.blocks, self.count) if use is None else (self.blocks[use], self.count[use])
        return solve(blocks.sum(axis=0) + np.diag(self.prior * count.sum()), members)

    @property
    def terms(self) -> tuple[str, ...]:
        return tuple(dict.fromkeys(c.term for c in self.columns if c.term))

    def members(self, chosen: tuple[str, ...]) -> Set:
        """Indices of the columns of these terms, and of those that are always in."""
        return tuple(i for i, c in enumerate(self.columns) if not c.term or c.term in chosen)


def products(
    library: Floats, residual: Floats, columns: tuple[LibraryColumn, ...], prior: Floats | None = None
) -> Products:
    """From a whitened library (n, p) and residual (n,), cut into `BLOCKS` stretches of equally many samples."""
    whole = np.column_stack([library, residual])
    edges = np.linspace(0, len(whole), BLOCKS + 1).astype(int)
    parts = [whole[a:b] for a, b in pairwise(edges)]
    known = np.zeros(whole.shape[1])
    if prior is not None:
        known[:-1] = prior
    return Products(np.stack([p.T @ p for p in parts]), np.diff(edges).astype(float), columns, known)


def solve(gram: Floats, members: Set) -> Floats:
    """(p,) least squares sizes of the columns `members`; columns of one direction share it."""
    index = np.array(members, dtype=int)
    scale = np.sqrt(np.maximum(gram[index, index], 1e-300))
    inside = gram[np.ix_(index, index)] / np.outer(scale, scale)
    values, vectors = np.linalg.eigh(inside)
    good = values > 1e-10 * values.max(initial=1e-300)
    right = vectors.T @ (gram[index, -1] / scale)
    sizes: Floats = vectors[:, good] @ (right[good] / values[good]) / scale
    return sizes


def left(gram: Floats, members: Set, sizes: Floats) -> float:
    """Squares that these sizes leave."""
    weights = np.zeros(len(gram))
    weights[list(members)] = -sizes
    weights[-1] = 1.0
    return max(float(weights @ gram @ weights), 1e-300)


def criterion(products: Products, chosen: tuple[str, ...]) -> float:
    """BIC of the terms `chosen`; infinite when a size has no meaning."""
    members = products.members(chosen)
    sizes = products.fit(members)
    if any(products.columns[i].positive and s < 0 for i, s in zip(members, sizes, strict=True)):
        return math.inf
    count = products.count.sum()
    if not count > 0:
        return math.inf  # gaps everywhere: nothing tells one set from another
    cost = sum(products.columns[i].parameters for i in members)
    return float(count * math.log(left(products.total, members, sizes) / count) + cost * math.log(count))


def best(products: Products, most: int = 4) -> tuple[tuple[str, ...], dict[tuple[str, ...], float]]:
    """The set of terms with the least BIC, and the BIC of every set that was looked at."""
    sets = [s for size in range(most + 1) for s in combinations(products.terms, size)]
    scores = {s: criterion(products, s) for s in sets}
    return min(scores, key=lambda s: scores[s]), scores


def held_out(products: Products, chosen: tuple[str, ...]) -> Floats:
    """(b,) mean square of every block under sizes fitted without that block's fold."""
    members = products.members(chosen)
    number = np.arange(len(products.blocks))
    result = np.zeros(len(number))
    for fold in range(FOLDS):
        out = number % FOLDS == fold
        sizes = products.fit(members, ~out)
        for b in number[out].tolist():
            result[b] = left(products.blocks[b], members, sizes) / products.count[b]
    return result


def held_out_rms(products: Products, chosen: tuple[str, ...]) -> float:
    """Root of the mean of `held_out`, in the unit of the target."""
    return math.sqrt(max(float(held_out(products, chosen).mean()), 0.0))


def gain(products: Products, chosen: tuple[str, ...], term: str) -> tuple[float, float]:
    """How much a chosen term helps on held-out blocks (mean of ln of squares without over with) and its p-value."""
    without = tuple(t for t in chosen if t != term)
    ratio = np.log(held_out(products, without) / held_out(products, chosen))
    spread = float(ratio.std(ddof=1) / math.sqrt(len(ratio)))
    mean = float(ratio.mean())
    return mean, student_tail(mean / max(spread, 1e-300), len(ratio) - 1)


def intervals(products: Products, chosen: tuple[str, ...]) -> tuple[Set, Floats, Floats]:
    """Columns, their sizes and half-widths of 95 % intervals.

    The larger of what white innovations say and of what fits without one block each say (jackknife: B. Efron, C. Stein,
    Ann. Stat. 9(3), 1981), for noise that grows with the motion or goes on for longer than the filter knows.
    """
    members = products.members(chosen)
    index = np.array(members, dtype=int)
    sizes = products.fit(members)
    prior = np.diag(products.prior[index]) * products.count.sum()
    inverse = np.linalg.pinv(products.total[np.ix_(index, index)] + prior, rcond=1e-13, hermitian=True)
    freedom = max(products.count.sum() - len(members), 1.0)
    plain = inverse * left(products.total, members, sizes) / freedom
    number = np.arange(len(products.blocks))
    without = np.stack([products.fit(members, number != b) for b in number.tolist()])
    blocks = len(number)
    jackknife = (blocks - 1) / blocks * np.square(without - without.mean(axis=0)).sum(axis=0)
    widths = np.maximum(1.96 * np.sqrt(np.diag(plain)), student_quantile(blocks - 1) * np.sqrt(jackknife))
    return members, sizes, widths
