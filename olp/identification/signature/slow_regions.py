"""Regions of one feature in which moves take far longer than the law says, or always the same time.

Controllers slow down near a limit, in a protected zone, or replan: a few moves, all beyond one bound of one
feature. A single split with medians on both sides finds such a region from a handful of moves, where many
small trees need hundreds.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

_FEWEST: Final = 4  # moves that make a region
_CUTS: Final = 64
_MOST: Final = 3  # regions
_GAIN: Final = 0.04  # of the sum of absolute errors that a region has to take away at least
_DIFFERENT: Final = (
    0.15  # of the logarithm: a region differs by this much, smaller steps are for smooth learners
)


class SlowRegion(NamedTuple):
    """Moves whose `feature` is above `bound` (below, if not `above`): ln(duration) = share x law + offset.

    `share` is 1, or 0 where all of them take the same time.
    """

    feature: int
    bound: float
    above: bool
    share: float
    offset: float

    def holds(self, features: Floats) -> NDArray[np.bool_]:
        values = features[:, self.feature]
        return np.asarray(values > self.bound if self.above else values <= self.bound)

    @staticmethod
    def from_json(content: Any) -> SlowRegion:
        """Raises TypeError or ValueError for what is no region."""
        feature, bound, above, share, offset = content
        return SlowRegion(int(feature), float(bound), bool(above), float(share), float(offset))


def corrected(regions: Sequence[SlowRegion], features: Floats, log_law: Floats) -> Floats:
    """(n,) ln(duration) of the law with the regions, a later one over an earlier one."""
    result = log_law.copy()
    for region in regions:
        inside = region.holds(features)
        result[inside] = region.share * log_law[inside] + region.offset
    return result


def find_regions(features: Floats, log_law: Floats, log_measured: Floats) -> tuple[SlowRegion, ...]:
    """The regions that take most of the absolute errors away, none if all are alike."""
    found: list[SlowRegion] = []
    for _ in range(_MOST):
        now = log_measured - corrected(found, features, log_law)
        best = _best(features, log_law, log_measured, now)
        if best is None:
            break
        found.append(best)
    return tuple(found)


def _best(features: Floats, log_law: Floats, log_measured: Floats, now: Floats) -> SlowRegion | None:
    count = len(now)
    if count < 2 * _FEWEST:
        return None
    total = np.abs(now)
    best, most = None, _GAIN * float(total.sum())
    for feature in range(features.shape[1]):
        order = np.argsort(features[:, feature], kind="stable")
        values = features[order, feature]
        for cut in _cuts(values):
            for above, rows in ((True, order[cut:]), (False, order[:cut])):
                if not _FEWEST <= len(rows) <= count // 2:
                    continue
                gain, shift = _gain(log_measured[rows] - log_law[rows], total[rows])
                if gain > most and abs(float(np.median(now[rows]))) > _DIFFERENT:
                    bound = float(values[cut - 1] + values[cut]) / 2
                    best, most = SlowRegion(feature, bound, above, 1.0, shift), gain
    if best is None:
        return None
    best = _sharpened(best, most, features[:, best.feature], log_measured - log_law, total)
    rows = np.flatnonzero(best.holds(features))
    same = float(np.median(log_measured[rows]))
    if np.sum(np.abs(log_measured[rows] - same)) < np.sum(
        np.abs(log_measured[rows] - log_law[rows] - best.offset)
    ):
        return best._replace(share=0.0, offset=same)
    return best


def _gain(residual: Floats, total: Floats) -> tuple[float, float]:
    """What a shift by the median takes away of the absolute errors `total`, and the shift."""
    shift = float(np.median(residual))
    return float(np.sum(total - np.abs(residual - shift))), shift


def _sharpened(
    region: SlowRegion, gain: float, values: Floats, residual: Floats, total: Floats
) -> SlowRegion:
    """The same region with the best of all bounds near its own."""
    order = np.argsort(values, kind="stable")
    ordered, count = values[order], len(values)
    at = int(np.searchsorted(ordered, region.bound))
    reach = count // _CUTS + 2
    for cut in range(max(at - reach, _FEWEST), min(at + reach, count - _FEWEST) + 1):
        rows = order[cut:] if region.above else order[:cut]
        if ordered[cut] > ordered[cut - 1] and _FEWEST <= len(rows) <= count // 2:
            found, shift = _gain(residual[rows], total[rows])
            if found > gain:
                gain = found
                region = region._replace(bound=float(ordered[cut - 1] + ordered[cut]) / 2, offset=shift)
    return region


def _cuts(values: Floats) -> list[int]:
    """Where a sorted feature may be split, denser towards both ends."""
    count = len(values)
    inner = np.linspace(0, count, _CUTS + 2)[1:-1].astype(np.int64)
    edge = np.unique(np.geomspace(_FEWEST, count // 2, _CUTS // 2).astype(np.int64))
    cuts = np.unique(np.concatenate([inner, edge, count - edge]))
    return [int(c) for c in cuts if 0 < c < count and values[c] > values[c - 1]]
