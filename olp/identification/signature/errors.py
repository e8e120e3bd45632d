"""How wrong predictions are: learnt from moves, and whole start points, that were held out inside the recording.

Two situations: a move among learnt ones (near), and a move from a start point that was never measured (far). Each has
the half-width that covered 95 % of the held-out moves, and two standard deviations: `shared` by all moves of one
start point, `own` of a single move. In a sum the shared ones add up, the own ones partly cancel.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
LEVEL = 0.95
_NORMAL = 1.96


class Spread(NamedTuple):
    """Errors of 1/a [s²/m] in one situation. `groups`: how many independent groups told `shared`."""

    half: float  # half-width of the 95 % interval of one move
    shared: float
    own: float
    groups: int

    @property
    def quantile(self) -> float:
        """95 % of Student's t with `groups` degrees of freedom (two terms of the expansion in 1/groups)."""
        n, z = max(self.groups, 2), _NORMAL
        return z + (z**3 + z) / (4 * n) + (5 * z**5 + 16 * z**3 + 3 * z) / (96 * n * n)


class ErrorModel(NamedTuple):
    near: Spread
    far: Spread

    def half(self, novelty: Floats) -> Floats:
        """(n,) [s²/m] of single moves."""
        return self._mixed(self.near.half, self.far.half, novelty)

    def total_half(self, novelty: Floats, weight: Floats) -> float:
        """[s] half-width of a sum of moves; `weight` (n,) [m/s]: seconds per slowness, widening included."""
        own = self._mixed(self.near.own, self.far.own, novelty) * weight
        near = np.clip(1.0 - novelty, 0.0, 1.0)
        # Near moves have learnt neighbours on both sides: their shared part is small, but it is shared.
        shared = math.hypot(
            float(np.sum(near * weight)) * self.near.shared * self.near.quantile,
            float(np.sum((1.0 - near) * weight)) * self.far.shared * self.far.quantile,
        )
        return math.hypot(_NORMAL * float(np.sqrt(np.sum(own**2))), shared)

    @staticmethod
    def _mixed(near: float, far: float, novelty: Floats) -> Floats:
        share = np.clip(novelty, 0.0, 1.0)
        return np.asarray(near + share * (far - near))


def spread_of(residuals: Floats, groups: NDArray[np.int64]) -> Spread:
    """From held-out errors (n,) [s²/m] and the group (program, start point) each was held out with."""
    good = np.isfinite(residuals)
    values, labels = residuals[good], groups[good]
    if not len(values):
        return Spread(math.inf, math.inf, math.inf, 0)
    names = np.unique(labels)
    means = np.array([values[labels == g].mean() for g in names.tolist()])
    sizes = np.array([np.sum(labels == g) for g in names.tolist()])
    inner = np.concatenate([values[labels == g] - m for g, m in zip(names.tolist(), means, strict=True)])
    freedom = max(len(values) - len(names), 1)
    own = math.sqrt(float(np.sum(inner**2)) / freedom)
    shared = math.sqrt(max(float(np.mean(means**2 - own**2 / sizes)), 0.0))
    return Spread(_covering(np.abs(values)), shared, own, len(names))


def _covering(sizes: Floats) -> float:
    """The size that LEVEL of such errors do not exceed, with the finite-sample step of conformal prediction."""
    rank = min(math.ceil((len(sizes) + 1) * LEVEL), len(sizes))
    return float(np.sort(sizes)[rank - 1])
