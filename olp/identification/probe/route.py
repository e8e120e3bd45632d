"""In which order moves are run, and the ways between them: short, and only along lines that were proved."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Labels = NDArray[np.int64]


class ShortestPaths:
    """The shortest ways between p points along allowed lines. `allowed` (p, p), `points` (p, 3) [m]."""

    def __init__(self, points: Floats, allowed: NDArray[np.bool_]) -> None:
        apart = np.linalg.norm(points[:, None] - points[None], axis=2)
        self.length: Floats = np.where(allowed, apart, np.inf)
        np.fill_diagonal(self.length, 0.0)
        count = len(points)
        self._next: Labels = np.where(np.isfinite(self.length), np.arange(count)[None, :], -1)
        # R. W. Floyd, Algorithm 97: shortest path, Communications of the ACM 5 (1962).
        for middle in range(count):
            over = self.length[:, middle, None] + self.length[None, middle, :]
            better = over < self.length - 1e-12
            self.length = np.where(better, over, self.length)
            self._next = np.where(better, self._next[:, middle, None], self._next)

    def between(self, first: int, last: int) -> list[int]:
        """The points after `first` up to `last`; [] when they are one. Needs a finite length."""
        found: list[int] = []
        at = first
        while at != last:
            at = int(self._next[at, last])
            found.append(at)
        return found


def order(starts: Labels, ends: Labels, ways: ShortestPaths) -> list[int]:
    """Move numbers so that each starts near where the one before ended; always the nearest, the first one stays."""
    rest = list(range(1, len(starts)))
    found = [0] if len(starts) else []
    while rest:
        at = int(ends[found[-1]])
        best = min(rest, key=lambda move: (float(ways.length[at, int(starts[move])]), move))
        rest.remove(best)
        found.append(best)
    return found
