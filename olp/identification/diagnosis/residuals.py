"""Whether what remains is scatter, or goes together with something: order, columns, repeats.

Each look is a test with a p-value, and the p-values are corrected for the number of looks (S. Holm, Scand. J. Statist.
6, 1979), so that one clean recording in a hundred is called structured.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from olp.identification.diagnosis.result import Correlate
from olp.identification.diagnosis.scatter import f_tail, far_out, neighbours
from olp.timing.physics._case import MeasuredMoves

Floats = NDArray[np.float64]
Labels = NDArray[np.int64]

LEVEL = 0.01
FALSE_DISCOVERIES = 0.05  # of the names, and of the moves that are called significant
_SURE = 0.001  # that chance makes what a verdict alone rests on
_FEWEST = 8
_LAGS = 5
_SHARED = -0.25  # correlation of neighbours of whose scatter half is of stamps that they share
_ORDER, _ORDERS = "previous move", "previous moves"  # what residuals go together with
_GROUPS = {"start": "start point", "repeat": "programmed move", "speed": "each speed"}
_TURNS = 1e-4  # [rad | m] less is no turn of an axis
_FINEST = 0.25  # of the recorder's resolution: residuals that differ by less are alike
_MUTUAL = 1.3  # times: the error of a correlation between nearest neighbours, some of which are each other's


class Remains(NamedTuple):
    """What the tests said of residuals."""

    correlates: tuple[Correlate, ...]  # the significant ones, the surest first
    order: float  # [1] correlation of a residual with the one before it; 0 when it is not significant
    chance: float = 1.0  # that one of all looks is as sure as the surest

    @property
    def structured(self) -> bool:
        return bool(self.correlates)

    @property
    def surely_structured(self) -> bool:
        """Of a thousand clean recordings one is: where no name holds, nothing else tells that a difference is real."""
        return self.chance <= _SURE


def remains_of(residual: Floats, case: MeasuredMoves, groups: dict[str, Labels]) -> Remains:
    """Looks at residuals (n,) [s] from every side."""
    clipped = no_farther(residual, case.resolution)
    clipped = np.clip(clipped, *np.quantile(clipped, [0.005, 0.995])) if len(residual) > 50 else clipped
    told = _as_recorded(clipped, case.resolution)
    found = [
        *_by_order(clipped),
        *_by_columns(told, case),
        *_by_neighbours(told, case),
        *_by_groups(told, {**groups, "repeat": case.repeats}),
    ]
    looks = len(found)
    kept, found = list[Correlate](), sorted(found, key=lambda c: c.p_value)
    for rank, look in enumerate(found):
        if look.p_value * (looks - rank) > LEVEL:
            break
        kept.append(look)
    order = next((c.statistic for c in kept if c.column == _ORDER), 0.0)
    if not order and any(c.column == _ORDERS for c in kept):
        # Of few moves, all that went before tell it more surely.
        lag = next(c.statistic for c in found if c.column == _ORDER)
        order = lag if lag < _SHARED else 0.0
    if any(c.column == "speed_mm_s" for c in kept):
        kept = [c for c in kept if c.column != _GROUPS["speed"]]  # the same, seen as groups
    chance = min(found[0].p_value * looks, 1.0) if found else 1.0
    return Remains(tuple(kept), float(np.clip(order, -0.95, 0.95)), chance)


def no_farther(residual: Floats, resolution: float) -> Floats:
    """(n,) [s] residuals of which none is farther out than scatter goes: one move that is far off hides how neighbours
    go together, and leaves echoes where what it foretells of the next ones is taken off. `resolution` [s]: digits make
    the middle nought where most values are equal."""
    middle = float(np.median(residual)) if len(residual) else 0.0
    far = far_out(residual - middle, resolution)
    if not far.any():
        return residual
    reach = float(np.abs(residual - middle)[~far].max(initial=0.0))
    return np.clip(residual, middle - reach, middle + reach)


def _as_recorded(residual: Floats, resolution: float) -> Floats:
    """(n,) [s] without what is far below a recorder's resolution [s]: it is no order among residuals.

    Where durations are whole multiples of a cycle, most residuals are the same number of digits. A cycle that is off by
    less than its own error would rank them all by their length.
    """
    if not resolution > 0:
        return residual
    finest = _FINEST * resolution
    return np.asarray(np.round(residual / finest) * finest)


def of_axes(residual: Floats, case: MeasuredMoves) -> tuple[Correlate, ...]:
    """Where residuals (n,) [s] go together with how one axis turns: of each such axis what is surest, the surest first.

    It tells the place of what no term explains, and decides nothing.
    """
    rates = case.rates
    if rates is None:
        return ()
    known = rates.known & case.moving
    turns = rates.path.mean(axis=1) * case.base.way[:, None]
    ways = np.where(np.abs(turns) > _TURNS, np.sign(turns), 0.0)
    rows = np.arange(len(case))[:, None]
    latest = np.maximum.accumulate(
        np.where(ways != 0, rows, 0), axis=0
    )  # the last turn so far, also behind waits
    before = np.take_along_axis(ways, np.concatenate([latest[:1], latest[:-1]]), axis=0)
    back = (ways * before < 0).astype(float)
    found = list[list[Correlate]]()
    for k, axis in enumerate(rates.names):
        told = {
            f"how far {axis} turns": np.abs(turns),
            f"which way {axis} turns": ways,
            f"{axis} turning back": back,
        }
        looks = []
        for name, values in told.items():
            column = values[known, k]
            if len(column) >= _FEWEST and np.ptp(column) > 0:
                rho = rank_correlation(residual[known], column)
                looks.append(Correlate(name, rho, _two_sided(rho * math.sqrt(len(column) - 1))))
        found.append(sorted(looks, key=lambda look: look.p_value))
    count = sum(map(len, found))
    sure = [looks[0] for looks in found if looks and looks[0].p_value * count <= LEVEL]
    return tuple(sorted(sure, key=lambda look: look.p_value))


def _by_order(residual: Floats) -> list[Correlate]:
    """Autocorrelation, over several moves of ranks (G. Box, D. Pierce, JASA 65, 1970; J.-M. Dufour, R. Roy,
    Communications in Statistics 15, 1986), and the strongest period (R. Fisher, 1929)."""
    n = len(residual)
    if n < _FEWEST:
        return []
    centred = residual - residual.mean()
    shift = float(residual.mean() / max(float(residual.std(ddof=1)), 1e-12)) * math.sqrt(n)
    mean = Correlate("mean", shift / math.sqrt(n + shift**2), _two_sided(shift))
    power = float(centred @ centred)
    if power <= 0 or n < 3 * _FEWEST:
        return [mean]
    lag = float(centred[1:] @ centred[:-1]) / power
    first = Correlate(_ORDER, lag, _two_sided(lag * math.sqrt(n)))
    ordered = ranks(residual) - (n + 1) / 2.0  # heavy tails: two far moves would be a pattern
    spread = float(ordered @ ordered)
    ranked = [float(ordered[k:] @ ordered[:-k]) / spread for k in range(1, _LAGS + 1)]
    together = n * (n + 2) * sum(r**2 / (n - k) for k, r in enumerate(ranked, 1))
    box = Correlate(_ORDERS, math.sqrt(together / (n * _LAGS)), _chi_square(together, _LAGS))
    spectrum = np.abs(np.fft.rfft(centred)[1:]) ** 2
    peak = float(spectrum.max() / spectrum.sum())
    fisher = min(1.0, len(spectrum) * (1.0 - peak) ** (len(spectrum) - 1))
    return [mean, first, box, Correlate("a period in the order of moves", math.sqrt(peak), fisher)]


def _by_columns(residual: Floats, case: MeasuredMoves) -> list[Correlate]:
    """Spearman's rank correlation with every number known of a move, by the name of its column in a recording."""
    columns: dict[str, Floats] = {
        "length_mm": case.length,
        "speed_pct" if case.unit == "rad" else "speed_mm_s": case.base.speed,
        "sim_s": case.simulated,
        "incline": case.rise,
        "t_start_s": case.t_start,
        "move": np.arange(len(case), dtype=float),
        "turn_deg": case.turn,
        "payload_kg": case.payload,
        "payload_inertia_kg_m2": case.payload_inertia,
        "corner_deg": np.where(case.stop_end, np.nan, case.corner),
        **{
            f"{axis}_{end}_mm": points[:, k]
            for end, points in (("start", case.start), ("end", case.end))
            for k, axis in enumerate("xyz")
        },
        **case.covariates,
    }
    found = []
    for name, values in columns.items():
        known = np.isfinite(values)
        if known.sum() < _FEWEST or np.ptp(values[known]) <= 0:
            continue
        rho = rank_correlation(residual[known], values[known])
        found.append(Correlate(name, rho, _two_sided(rho * math.sqrt(known.sum() - 1))))
    return found


def _by_neighbours(residual: Floats, case: MeasuredMoves) -> list[Correlate]:
    """Whether moves that are alike have residuals alike, whatever the curve: ranks against the most similar move's.

    One look per programmed move, as repeats would count a neighbour many times. Two moves may be each other's nearest,
    which makes chance coincidences less rare (P. Moran, Biometrika 37, 1950).
    """
    one, means = _programmed(residual, case)
    found = []
    for name, near in neighbours(case.fold(one)).items():
        known = near >= 0
        if known.sum() < 3 * _FEWEST:
            continue
        r = rank_correlation(means[known], means[near[known]])
        z = max(r, 0.0) * math.sqrt(known.sum()) / _MUTUAL  # a pattern makes neighbours alike, never opposite
        found.append(Correlate(f"moves of like {name}", r, _two_sided(z)))
    return found


def _programmed(residual: Floats, case: MeasuredMoves) -> tuple[Labels, Floats]:
    """The first row of each programmed move, and the means of the residuals of its repeats."""
    if len(case.repeats) != len(case):
        return np.arange(len(case)), residual
    _, one, group, count = np.unique(case.repeats, return_index=True, return_inverse=True, return_counts=True)
    order = np.argsort(one)
    return one[order], (np.bincount(group, residual) / count)[order]


def _by_groups(residual: Floats, groups: dict[str, Labels]) -> list[Correlate]:
    """Analysis of variance on ranks (W. Kruskal, W. Wallis, JASA 47, 1952)."""
    found, seen = [], set[bytes]()
    ranked = ranks(residual)
    for name, labels in groups.items():
        if len(labels) != len(residual):
            continue
        names, first, inverse, count = np.unique(
            labels, return_index=True, return_inverse=True, return_counts=True
        )
        parted = first[inverse].tobytes()
        if len(names) < 2 or len(names) > len(labels) // 2 or parted in seen:
            continue
        seen.add(parted)
        means = np.bincount(inverse, ranked) / count
        between = float((count * (means - ranked.mean()) ** 2).sum())
        total = float(((ranked - ranked.mean()) ** 2).sum())
        if total <= 0:
            continue
        k, n = len(names), len(labels)
        ratio = (between / (k - 1)) / max((total - between) / (n - k), 1e-12 * total)
        found.append(
            Correlate(_GROUPS.get(name, name), math.sqrt(between / total), f_tail(ratio, k - 1, n - k))
        )
    return found


def rank_correlation(a: Floats, b: Floats) -> float:
    """Of two columns (n,), C. Spearman's; 0 where one of them is constant."""
    one, two = ranks(a), ranks(b)
    one, two = one - one.mean(), two - two.mean()
    size = math.sqrt(float(one @ one) * float(two @ two))
    return float(one @ two) / size if size > 0 else 0.0


def ranks(values: Floats) -> Floats:
    """Ranks; equal values share the middle one."""
    _, inverse, count = np.unique(values, return_inverse=True, return_counts=True)
    last = np.cumsum(count)
    return np.asarray((last - (count - 1) / 2.0)[inverse], dtype=float)


def _two_sided(z: float) -> float:
    return math.erfc(abs(z) / math.sqrt(2.0))


def _chi_square(x: float, freedom: int) -> float:
    """Tail of chi square (Wilson and Hilferty, PNAS 17, 1931)."""
    k = 2.0 / (9.0 * freedom)
    return 0.5 * math.erfc((((x / freedom) ** (1.0 / 3.0) - (1.0 - k)) / math.sqrt(k)) / math.sqrt(2.0))
