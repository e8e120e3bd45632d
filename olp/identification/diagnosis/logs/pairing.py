"""Which instant of the simulation belongs to which of the log: offset, rate, and where the log waited longer.

Windows of the log are shifted until the simulated axes lie on the measured ones (Gauss and Newton, fractions of a
sample); a robust line through the instants is the clock, its steps at rests are dwell.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from olp.identification.diagnosis.logs.result import ExtraDwell
from olp.identification.diagnosis.logs.series import Grid, Spectrum, even
from olp.identification.recording.from_log import ClockAlignment, fit_clock
from olp.identification.recording.log import Log

Floats = NDArray[np.float64]
_COARSE = 0.02  # [s] step of the speed profiles
_RATES = (1.0, 0.999, 1.001, 0.998, 1.002, 0.995, 1.005, 0.99, 1.01, 0.98, 1.02)
_POOR = 0.03  # of a window's motion that may be left before the window is looked for elsewhere
_BAD = 0.1  # of it that may be left before the window counts as not paired
_REACH = 20.0  # [s] how far it is looked for
_WINDOWS = 60
_ROUNDS = 30
_SLOWEST = 0.05  # of the quickest axis' usual speed: the noise of an axis that hardly moves is no motion
_RETIMED = 0.08  # [s] scatter of windows: more is no lag of a servo
_SURE = 4.0  # standard errors of a rate
LEAST_RATE = 5e-6  # quartz clocks differ by more


@dataclass(frozen=True, slots=True)
class Pairing:
    """log time = offset + rate * simulated time, plus the dwell before it.

    `at` (w,) [s] of the log, `off` (w,) [s] by which each window is off that line.
    """

    clock: ClockAlignment
    dwell: tuple[ExtraDwell, ...]
    unpaired: tuple[tuple[float, float], ...]  # [s] of the log: the simulation does not go there
    retimed: bool  # the moves themselves take other times: no clock tells them
    at: Floats
    off: Floats

    def simulated(self, time: Floats) -> Floats:
        """(n,) [s] on the simulation's clock."""
        return np.asarray((time - self.clock.offset - self.late(time)) / self.clock.rate)

    def quicker(self, factor: float, error: float) -> Pairing:
        """With a rate `factor` times as large, about the middle of the windows; `error` (standard) of the factor."""
        middle = float(np.median(self.at)) - self.clock.offset
        rate = self.clock.rate * factor
        offset = self.clock.offset - middle * (factor - 1)
        clock = ClockAlignment(
            offset, rate, max(self.clock.offset_error, middle * error), error, self.clock.scatter
        )
        return replace(self, clock=clock)

    def late(self, time: Floats) -> Floats:
        """(n,) [s] dwell before each instant."""
        late = np.zeros(len(time))
        for stop in self.dwell:
            late += np.where(time > stop.time, stop.extra, 0.0)
        return late


@dataclass(frozen=True, slots=True, eq=False)
class _Curves:
    grid: Grid
    speed: Floats  # (n, k)
    profile: Floats  # (m,) pace on a coarse grid from grid.start
    scale: Floats  # (k,) usual speeds


def pair(log: Log, sim: Log, values: Floats, reference: Floats) -> Pairing | None:
    """From one curve (n, k) of both logs [rad | m]; None when they never move together."""
    grid = even(sim.time, reference, sim.period)
    spectrum = Spectrum(grid)
    speed = np.stack([spectrum.derivative(1, j, sim.period) for j in range(reference.shape[1])], axis=1)
    usual = np.sqrt((speed**2).mean(axis=0))
    scale = np.maximum(usual, max(_SLOWEST * float(usual.max()), 1e-6))
    curves = _Curves(grid, speed, _pace(grid.time, grid.values, scale), scale)
    first = _by_moves(log, sim) or _by_profile(log.time, values, curves)
    if first is None:
        return None
    windows = _windows(log.time, values, scale)
    if len(windows) < 1:
        return None
    pairing = Pairing(ClockAlignment(*first, 0.0, 0.0, 0.0), (), (), False, np.zeros(0), np.zeros(0))
    for turn in range(3):
        at, shift, good = _shifts(log.time, values, windows, curves, pairing, turn == 0)
        if not good.any():
            return None
        pairing = _line(pairing, at, shift, good, log, values)
    missing = [
        (float(log.time[a]), float(log.time[b - 1]))
        for a, b, ok in zip(*windows.T, good, strict=True)
        if not ok
    ]
    off = shift[good]
    return Pairing(pairing.clock, pairing.dwell, tuple(missing), pairing.retimed, at[good], off)


def _by_moves(log: Log, sim: Log) -> tuple[float, float] | None:
    """Offset and rate from the beginnings of moves that both logs number."""
    if log.move is None or sim.move is None:
        return None
    firsts = [_begins(log.time, log.move), _begins(sim.time, sim.move)]
    both = sorted(set(firsts[0]) & set(firsts[1]))
    found = fit_clock(np.array([firsts[1][m] for m in both]), np.array([firsts[0][m] for m in both]))
    return None if found is None or abs(found.rate - 1) > 0.2 else (found.offset, found.rate)


def _begins(time: Floats, move: NDArray[np.int64]) -> dict[int, float]:
    """Number of a move -> its first instant [s]."""
    numbers, first = np.unique(move, return_index=True)
    return {int(m): float(time[i]) for m, i in zip(numbers, first, strict=True) if m >= 0}


def _pace(time: Floats, values: Floats, scale: Floats, step: float = _COARSE) -> Floats:
    """(m,) how fast all axes go together, every `step` [s] from the first sample on."""
    instants = np.arange(time[0], time[-1], step)
    coarse = np.stack([np.interp(instants, time, column) for column in values.T], axis=1)
    return np.asarray(np.sqrt((np.square(np.diff(coarse, axis=0) / step / scale)).sum(axis=1)))


def _by_profile(time: Floats, values: Floats, curves: _Curves) -> tuple[float, float] | None:
    """Offset and rate at which the paces of both correlate best."""
    own = curves.profile - curves.profile.mean()
    best = (-np.inf, 0.0, 1.0)
    for rate in _RATES:
        pace = _pace(time / rate, values, curves.scale)
        if len(pace) < 8 or len(own) < 8:
            return None
        pace = pace - pace.mean()
        size = 1 << (len(pace) + len(own)).bit_length()
        match = np.fft.irfft(np.fft.rfft(pace, size) * np.conj(np.fft.rfft(own, size)), size)
        at = int(np.argmax(match))
        lag = at - size if at > size // 2 else at
        # The pace at log time t is that of the simulation at t - offset.
        offset = float(time[0]) + rate * (lag * _COARSE - curves.grid.start)
        if match[at] > best[0] * (1 + 1e-3):
            best = (float(match[at]), offset, rate)
    return None if best[0] <= 0 else (best[1], best[2])


def _windows(time: Floats, values: Floats, scale: Floats) -> NDArray[np.int64]:
    """(w, 2) first and last-but-one sample of stretches of equal motion."""
    way = np.concatenate(
        [[0.0], np.cumsum(np.abs(np.diff(values[:: _stride(time)], axis=0) / scale).sum(axis=1))]
    )
    count = int(np.clip((time[-1] - time[0]) / 2.0, 1, _WINDOWS))
    edges = np.searchsorted(way, np.linspace(0, way[-1], count + 1)) * _stride(time)
    edges = np.unique(np.clip(edges, 0, len(time)))
    pairs = np.stack([edges[:-1], edges[1:]], axis=1)
    return np.asarray(pairs[pairs[:, 1] - pairs[:, 0] > 20])


def _stride(time: Floats) -> int:
    """Samples in a coarse step: noise of the axes is not motion."""
    return max(int(_COARSE * 2 / max(float(np.median(np.diff(time))), 1e-9)), 1)


def _shifts(
    time: Floats, values: Floats, windows: NDArray[np.int64], curves: _Curves, start: Pairing, search: bool
) -> tuple[Floats, Floats, NDArray[np.bool_]]:
    """Middle [s], shift [s] off `start`, and whether it is paired, of every window."""
    at, shift, good = [], [], []
    expected = 0.0
    for a, b in windows.tolist():
        when, what = time[a:b], values[a:b]
        found, rest = _newton(when, what, curves, start, expected)
        if search and rest > _POOR:
            other = _search(when, what, curves, start, expected)
            again, left = _newton(when, what, curves, start, other)
            if left < rest:
                found, rest = again, left
        fine = rest < _BAD
        expected = found if fine and search else expected
        at.append(float(when.mean()))
        shift.append(found)
        good.append(fine)
    return np.array(at), np.array(shift), np.array(good, dtype=bool)


def _newton(when: Floats, what: Floats, curves: _Curves, start: Pairing, shift: float) -> tuple[float, float]:
    """The shift [s] of one window from a near guess, and the share of its motion that is left."""
    rate = start.clock.rate
    moved = np.square((what - what.mean(axis=0)) / curves.scale).sum()
    for _ in range(15):
        there = start.simulated(when) - shift / rate
        off = what - curves.grid.at(there)
        off = off - np.median(off, axis=0)
        slope = curves.grid.at(there, curves.speed) / rate
        slope = (slope - slope.mean(axis=0)) / curves.scale
        power = float((slope**2).sum())
        step = -float((slope * off / curves.scale).sum()) / max(power, 1e-12)
        shift += float(np.clip(step, -0.25, 0.25))
        if abs(step) < 1e-7:
            break
    return shift, float(np.sqrt(np.square(off / curves.scale).sum() / max(moved, 1e-300)))


def _search(when: Floats, what: Floats, curves: _Curves, start: Pairing, expected: float) -> float:
    """[s] The shift at which the paces agree best, near ones first."""
    own = _pace(when, what, curves.scale)
    begin = (float(start.simulated(when[:1])[0]) - expected - curves.grid.start) / _COARSE
    reach = int(_REACH / _COARSE)
    low = int(np.clip(begin - reach, 0, len(curves.profile)))
    there = curves.profile[low : int(np.clip(begin + reach + len(own), 0, len(curves.profile)))]
    if len(there) < len(own) or len(own) < 4:
        return expected
    match = np.correlate(there, own, "valid")
    energy = np.convolve(there**2, np.ones(len(own)), "valid") + (own**2).sum()
    away = np.abs(low + np.arange(len(match)) - begin) / reach
    best = low + int(np.argmin(energy - 2 * match + 0.05 * (own**2).sum() * away))
    return expected + (begin - best) * _COARSE


def _line(
    start: Pairing, at: Floats, shift: Floats, good: NDArray[np.bool_], log: Log, values: Floats
) -> Pairing:
    """The clock through the windows' instants, with a step wherever the log waited."""
    when = at[good]
    there = start.simulated(when) - shift[good] / start.clock.rate
    if len(when) < 3:
        clock = ClockAlignment(
            start.clock.offset + float(np.median(shift[good])), start.clock.rate, 1.0, 1.0, 0.0
        )
        return Pairing(clock, start.dwell, (), False, at, shift)
    steps = _steps(there, when, max(2.5 * log.period, 0.012))
    times = [_longest_rest(log.time, values, when[i], when[i + 1]) for i in steps.tolist()]
    clock, sizes = _fit(there, when, np.array(times))
    lasting = np.abs(sizes) > max(2.5 * log.period, 0.012)
    if not lasting.all():
        times = [t for t, ok in zip(times, lasting, strict=True) if ok]
        clock, sizes = _fit(there, when, np.array(times))
    if abs(clock.rate - 1) < max(_SURE * clock.rate_error, LEAST_RATE):
        # A rate that is not sure would shift the log's end by more than a servo's lag.
        level, sizes = _fit(there, when, np.array(times), 1.0)
        clock = level._replace(rate_error=clock.rate_error)
    dwell = tuple(ExtraDwell(t, float(s)) for t, s in zip(times, sizes, strict=True))
    retimed = len(steps) > max(3, len(when) // 4) or clock.scatter > max(_RETIMED, 2 * log.period)
    return Pairing(clock, dwell, (), retimed, at, shift)


def _steps(there: Floats, when: Floats, least: float) -> NDArray[np.intp]:
    """Windows after which the log is late by another time than before, for at least three windows or to the end."""
    slope = float(np.median(np.diff(when) / np.maximum(np.diff(there), 1e-9)))
    late = when - slope * there
    ends = np.concatenate([late[:1], late, late[-1:]])
    lasting = np.median(np.stack([ends[:-2], ends[1:-1], ends[2:]]), axis=0)  # one odd window is no dwell
    gained = np.diff(lasting)
    usual = 1.4826 * float(np.median(np.abs(gained - np.median(gained))))
    return np.nonzero(np.abs(gained - np.median(gained)) > max(least, 8 * usual))[0]


def _fit(
    there: Floats, when: Floats, times: Floats, known: float | None = None
) -> tuple[ClockAlignment, Floats]:
    """when = offset + rate * there + steps, robust (Huber); the rate may be `known`."""
    shift = float(when[0])
    steps = (when[:, None] > times[None, :]).astype(float)
    middle = float(there.mean())
    columns = np.column_stack([np.ones(len(there)), there - middle, steps])
    if known is not None:
        shift_by = known * (there - middle)
        columns = np.delete(columns, 1, axis=1)
    else:
        shift_by = np.zeros(len(there))
    target = when - shift - shift_by
    weight = np.ones(len(there))
    for _ in range(_ROUNDS):
        normal = columns.T @ (weight[:, None] * columns)
        found = np.linalg.lstsq(normal, columns.T @ (weight * target), rcond=1e-12)[0]
        sizes = np.asarray(found, dtype=np.float64)
        left = target - columns @ sizes
        scale = max(1.4826 * float(np.median(np.abs(left))), 1e-9)
        weight = np.minimum(1.0, 1.345 * scale / np.maximum(np.abs(left), 1e-15))
    freedom = max(weight.sum() - columns.shape[1], 1.0)
    scatter = float(np.sqrt((weight * left**2).sum() / freedom))
    spread = scatter * np.sqrt(np.maximum(np.diag(np.linalg.pinv(normal)), 0))
    if known is not None:
        offset = float(sizes[0]) + shift - known * middle
        return ClockAlignment(offset, known, float(spread[0]), 0.0, scatter), sizes[1:]
    offset = float(sizes[0]) + shift - float(sizes[1]) * middle
    error = float(np.hypot(spread[0], spread[1] * middle))
    return ClockAlignment(offset, float(sizes[1]), error, float(spread[1]), scatter), sizes[2:]


def _longest_rest(time: Floats, values: Floats, begin: float, end: float) -> float:
    """[s] the middle of the quietest stretch between two instants."""
    a, b = np.searchsorted(time, [begin, end])
    stride = _stride(time)
    part = values[a:b:stride]
    if len(part) < 4:
        return (begin + end) / 2
    pace = np.abs(np.diff(part, axis=0)).sum(axis=1)
    still = np.concatenate([[False], pace < 0.02 * max(float(pace.max()), 1e-12), [False]]).astype(np.int8)
    change = np.diff(still)
    begins, ends = np.nonzero(change > 0)[0], np.nonzero(change < 0)[0]
    if not len(begins):
        return float(time[a + stride * int(np.argmin(pace))])
    longest = int(np.argmax(ends - begins))
    return float(time[min(a + stride * int(begins[longest] + ends[longest]) // 2, len(time) - 1)])
