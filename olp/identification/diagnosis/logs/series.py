"""Sampled curves: between samples, on an even grid, and through linear systems in the frequency domain."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Mask = NDArray[np.bool_]
Complex = NDArray[np.complex128]
GAP = 2.5  # periods of the log without a sample
SMOOTH = 0.008  # [s] standard deviation of the Gaussian that torques and accelerations pass


def hermite(time: Floats, values: Floats, at: Floats) -> Floats:
    """(m, k) cubic between samples: `values` (n, k) at `time` (n,), slopes by parabolas; constant beyond the ends."""
    if len(time) < 3:
        return np.asarray(np.stack([np.interp(at, time, column) for column in values.T], axis=1))
    h = np.maximum(np.diff(time), 1e-12)[:, None]
    secant = np.diff(values, axis=0) / h
    slope = np.empty_like(values)
    slope[1:-1] = (h[1:] * secant[:-1] + h[:-1] * secant[1:]) / (h[1:] + h[:-1])
    slope[0], slope[-1] = secant[0], secant[-1]
    inside = np.clip(at, time[0], time[-1])
    i = np.clip(np.searchsorted(time, inside, side="right") - 1, 0, len(time) - 2)
    step = h[i]
    u = (inside - time[i])[:, None] / step
    v = 1 - u
    ends = v * v * (1 + 2 * u) * values[i] + u * u * (3 - 2 * u) * values[i + 1]
    return np.asarray(ends + u * v * step * (v * slope[i] - u * slope[i + 1]))


class _Readings(NamedTuple):
    """Instants between samples of an even grid: `hermite` there is a weighted sum of four samples."""

    instants: Floats  # (m,) [s]
    rows: NDArray[np.intp]  # (4, m)
    weights: Floats  # (4, m)


@dataclass(frozen=True, slots=True, eq=False)
class Grid:
    """A curve at even instants: `values` (n, k) at `start` + i `step` [s]."""

    start: float
    step: float
    values: Floats
    _asked: list[_Readings] = field(
        default_factory=list, repr=False
    )  # the last ones: a fit asks thousands of times

    @property
    def time(self) -> Floats:
        return np.asarray(self.start + self.step * np.arange(len(self.values)), dtype=np.float64)

    def at(self, instants: Floats, values: Floats | None = None) -> Floats:
        """(m, k) the curve (or other `values` on the same grid) at `instants` [s], which nobody changes afterwards."""
        source = self.values if values is None else values
        if len(source) < 3:
            return hermite(self.time, source, instants)
        places = self._places(instants)
        if not len(places.rows):
            return source
        if source.shape[1] == 1:
            column = np.ascontiguousarray(source[:, 0])
            return np.asarray(sum(w * column[rows] for rows, w in zip(*places[1:], strict=True)))[:, None]
        return np.asarray(sum(w[:, None] * source[rows] for rows, w in zip(*places[1:], strict=True)))

    def _places(self, instants: Floats) -> _Readings:
        """No rows: the instants are the grid's own."""
        if self._asked and self._asked[0].instants is instants:
            return self._asked[0]
        count = len(self.values)
        place = (instants - self.start) / self.step
        if len(place) == count and np.abs(place - np.arange(count)).max(initial=0.0) < 1e-4:
            found = _Readings(instants, np.zeros((0, 0), np.intp), np.zeros((0, 0)))
        else:
            found = _Readings(instants, *_weights(place, count))
        self._asked[:] = [found]
        return found


def _weights(place: Floats, count: int) -> tuple[NDArray[np.intp], Floats]:
    """(4, m) rows and weights at places (m,) in steps from the first of `count` samples; constant beyond the ends."""
    inside = np.clip(place, 0.0, count - 1.0)
    at = np.minimum(inside.astype(np.intp), count - 2)
    u = inside - at
    v = 1.0 - u
    before, after = -0.5 * u * v * v, -0.5 * u * u * v
    here, next_ = v * v * (1 + 2 * u) - after, u * u * (3 - 2 * u) - before
    # Beyond the first and the last sample the curve goes on straight.
    first, last = at == 0, at == count - 2
    here, next_ = here + 2 * before * first - after * last, next_ + 2 * after * last - before * first
    rows = np.stack([np.maximum(at - 1, 0), at, at + 1, np.minimum(at + 2, count - 1)])
    return rows, np.stack([np.where(first, 0.0, before), here, next_, np.where(last, 0.0, after)])


def even(time: Floats, values: Floats, step: float) -> Grid:
    """The curve on a grid of `step` [s] from its first to its last sample. Rows that are not numbers are left out."""
    good = np.isfinite(values).all(axis=1)
    time, values = time[good], values[good]
    grows = np.append(np.diff(time) > 0, True)  # a recorder quicker than its clock repeats instants
    time, values = time[grows], values[grows]
    instants = time[0] + step * np.arange(int(np.floor((time[-1] - time[0]) / step + 1e-6)) + 1)
    return Grid(float(time[0]), step, hermite(time, values, instants))


def misread(time: Floats, values: Floats) -> Floats:
    """(k,) RMS of what writing curves (n, k) down and reading them between samples leave: the digits of both logs that
    are compared, and the way over an even grid back to uneven instants."""
    found = np.zeros(values.shape[1])
    for axis, column in enumerate(values.T):
        known = np.isfinite(column)
        if known.sum() < 3:
            continue
        at, seen = time[known], column[known, None]
        off = even(at, seen, float(np.median(np.diff(at)))).at(at) - seen
        found[axis] = np.sqrt(float((off**2).mean()) + _digit(column[known]) ** 2 / 6.0)
    return found


def _digit(values: Floats) -> float:
    """The smallest step between two values that were written."""
    step = np.diff(np.unique(values))
    return float(step.min()) if len(step) else 0.0


class Spectrum:
    """A grid's Fourier transform, once; every linear system is then a product.

    The curve is led back to its beginning on a smooth way, so that it repeats without a jump.
    """

    def __init__(self, grid: Grid, lead: float = 3.0) -> None:
        self.grid = grid
        n = len(grid.values)
        self.size = _smooth_number(n + max(int(lead / grid.step), 16))
        way = np.arange(1, self.size - n + 1) / (self.size - n + 1)
        fade = (0.5 - 0.5 * np.cos(np.pi * way))[:, None]
        back = grid.values[-1] + (grid.values[0] - grid.values[-1]) * fade
        self.middle = grid.values[0]
        self.transform: Complex = np.fft.rfft(np.concatenate([grid.values, back]) - self.middle, axis=0)
        # [rad/s]
        self.omega: Floats = np.asarray(2 * np.pi * np.fft.rfftfreq(self.size, grid.step), dtype=np.float64)

    def through(self, transfer: Complex, axis: int) -> Floats:
        """(n,) the answer of a system `transfer` (f,) to the curve of `axis`, on the grid."""
        answer: Floats = np.fft.irfft(self.transform[:, axis] * transfer, self.size)
        return answer[: len(self.grid.values)]

    def derivative(self, order: int, axis: int, smooth: float = 0.0) -> Floats:
        """(n,) the derivative, behind a Gaussian of `smooth` [s] standard deviation that shifts nothing."""
        transfer = (1j * self.omega) ** order * np.exp(-0.5 * (self.omega * smooth) ** 2)
        curve = self.through(np.asarray(transfer, dtype=np.complex128), axis)
        # The transform is of the curve less its first value.
        return curve if order else np.asarray(curve + self.middle[axis])


def smoothed(grid: Grid, instants: Floats) -> Floats:
    """(m, k) a curve without what is quicker than axes answer, at `instants` [s]."""
    spectrum = Spectrum(grid)
    axes = range(grid.values.shape[1])
    return grid.at(instants, np.stack([spectrum.derivative(0, j, SMOOTH) for j in axes], axis=1))


def _smooth_number(least: int) -> int:
    """The first number from `least` on that has no prime factor above 5."""
    best = 1 << (least - 1).bit_length()
    five = 1
    while five < best:
        three = five
        while three < best:
            rest = -(-least // three)
            best = min(best, three * (1 << max(rest - 1, 0).bit_length()))
            three *= 3
        five *= 5
    return best


def gaps(time: Floats) -> tuple[tuple[float, float], ...]:
    """From, to [s] of every stretch without samples."""
    if len(time) < 3:
        return ()
    step = np.diff(time)
    where = np.nonzero(step > GAP * max(float(np.median(step)), 1e-9))[0]
    return tuple((float(time[i]), float(time[i + 1])) for i in where.tolist())


def dropped(time: Floats) -> int:
    """How many samples are missing, by the median period; a step of one and a half periods or less is jitter."""
    if len(time) < 3:
        return 0
    step = np.diff(time)
    missing = np.round(step / max(float(np.median(step)), 1e-9)) - 1
    return int(missing[missing > 0].sum())


def beside_gaps(time: Floats, holes: tuple[tuple[float, float], ...], least: float, margin: float) -> Mask:
    """(n,) samples within `margin` [s] of a hole longer than `least` [s], and of both ends: systems swing in there."""
    bad = (time < time[0] + margin) | (time > time[-1] - margin / 2)
    for begin, end in holes:
        if end - begin > least:
            bad |= (time > begin - margin / 2) & (time < end + margin)
    return np.asarray(bad)


def rests(time: Floats, speed: Floats, least: float = 0.08) -> list[tuple[int, int]]:
    """First and last sample of every stretch of at least `least` [s] in which no axis moves.

    `speed` (n, k), without much noise; still is a hundredth of what the axis does at its 95th percentile.
    """
    usual = np.quantile(np.abs(speed), 0.95, axis=0)
    pace = np.max(np.abs(speed) / np.maximum(usual, 1e-12), axis=1)
    still = np.concatenate([[False], pace < 0.01, [False]]).astype(np.int8)
    change = np.diff(still)
    begins, ends = np.nonzero(change > 0)[0], np.nonzero(change < 0)[0] - 1
    return [(b, e) for b, e in zip(begins.tolist(), ends.tolist(), strict=True) if time[e] - time[b] >= least]


# --- Whiten ---
# Residuals of neighbouring samples go together; a filter makes them independent before anything is counted.
#
# The noise is an autoregression of order 8 (Yule and Walker); data and library go through its inverse. On residuals of
# 4 ms, criteria on raw samples name two to eight terms that are not there.

Labels = NDArray[np.int64]
ORDER = 8
_ORDERS = (ORDER, 4, 2, 1, 0)  # where gaps leave no run of samples that is long enough for more
_SHARE = 0.25  # of the used samples that a filter has to leave


def runs(time: Floats, use: Mask) -> Labels:
    """(n,) the number of the unbroken run that a used sample belongs to, -1 for the others."""
    step = np.diff(time, prepend=time[0])
    broken = (step > 1.6 * max(float(np.median(np.diff(time))), 1e-12)) | ~use | ~np.append(True, use[:-1])
    labels = np.cumsum(broken).astype(np.int64)
    return np.where(use, labels, -1)


def order_of(run: Labels) -> int:
    """The filter's order: less than `ORDER` where so many samples were dropped that hardly any has its neighbours."""
    used = max(int((run >= 0).sum()), 1)
    return next((order for order in _ORDERS if kept(run, order).sum() >= _SHARE * used), 0)


def autoregression(noise: Floats, run: Labels, order: int = ORDER) -> Floats:
    """(order,) coefficients a: noise[t] = a[0] noise[t-1] + … + white; Levinson's recursion on autocovariances."""
    good = run >= 0
    centred = np.where(good, noise - noise[good].mean(), 0.0) if good.any() else noise
    covariance = np.zeros(order + 1)
    for k in range(order + 1):
        same = good[k:] & (run[k:] == run[: len(run) - k])
        count = max(int(same.sum()), 1)
        covariance[k] = float((centred[k:] * centred[: len(centred) - k])[same].sum()) / count
    covariance[0] *= 1 + 1e-9
    a = np.zeros(0)
    error = max(covariance[0], 1e-300)
    for k in range(1, order + 1):
        reflection = (
            (covariance[k] - a @ covariance[k - 1 : 0 : -1]) / error if k > 1 else covariance[1] / error
        )
        reflection = float(np.clip(reflection, -0.9999, 0.9999))
        a = np.append(a - reflection * a[::-1], reflection)
        error *= 1 - reflection**2
    return a


def kept(run: Labels, order: int = ORDER) -> Mask:
    """(n,) samples that have `order` neighbours before them in their run."""
    result = np.zeros(len(run), dtype=bool)
    result[order:] = (run[order:] >= 0) & (run[order:] == run[: len(run) - order])
    return result


def whiten(columns: Floats, a: Floats, keep: Mask) -> Floats:
    """(m, …) the innovations of `columns` (n, …) at the m samples `keep`."""
    order = len(a)
    result = columns[order:].copy()
    for k in range(1, order + 1):
        result -= a[k - 1] * columns[order - k : len(columns) - k]
    return np.asarray(result[keep[order:]])
