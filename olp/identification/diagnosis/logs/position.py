"""Where the axes are against where they should be: the clock, servo lag, compliance and play that blocks confirm."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from olp.identification.diagnosis.logs.follow import Follower, FollowingShape, Whitened, jacobian, refine
from olp.identification.diagnosis.logs.following import (
    BOTH,
    CLOCK,
    NONE,
    Story,
    lateness,
    noise_of,
    stories,
)
from olp.identification.diagnosis.logs.select import (
    LibraryColumn,
    Products,
    criterion,
    gain,
    held_out,
    intervals,
    products,
)
from olp.identification.diagnosis.logs.series import SMOOTH, Spectrum, beside_gaps, even, gaps
from olp.identification.diagnosis.logs.statistics import student_tail

Floats = NDArray[np.float64]
Mask = NDArray[np.bool_]
_LONGEST = 8_000  # samples in which stories compete; the whole log then confirms or refuses
_MARGIN = 0.25  # [s] after a gap and at the ends, in which unseen motion still rings
_LEAST = 0.1  # of what is left: an effect of less is not named
_HELPS = 1.1  # times: held-out RMS without a term over that with it; less is not worth a name
_LEAST_LAG = 0.25  # sampling periods; a whole one where nobody knows what the clock's offset should be
_ALIKE = 0.25  # of their time: how far apart axes may be late and still have one clock


@dataclass(frozen=True, slots=True, eq=False)
class AxisResult:
    """One axis after everything. `shape` holds only the terms that were kept; `whole` the products of whole log."""

    follower: Follower
    noise: Whitened
    shape: FollowingShape
    terms: tuple[str, ...]
    gains: dict[str, tuple[float, float]]  # term -> gain on held-out blocks, p-value
    delta_bic: dict[str, float]
    raw: Products
    contribution: dict[str, float]  # term -> RMS [rad | m]


@dataclass(frozen=True, slots=True, eq=False)
class PositionResult:
    axes: tuple[AxisResult, ...]
    late: float  # [s] against the reference's clock
    late_error: float
    clock: bool  # whether the story has a clock in it
    clock_gain: tuple[float, float]
    clock_delta: float
    scores: dict[str, float]  # story -> BIC more than the best
    refused: bool  # axes were late by different times: not a clock, whatever its score
    zero: float  # [s] the lateness that means that no clock is wrong


def followers(
    time: Floats,
    measured: Floats,
    reference_time: Floats,
    reference: Floats,
    usable: Mask,
    torques: Floats | None = None,
) -> list[Follower]:
    """One for every axis that moves. `time` (n,) [s] is on the reference's clock; `torques`
    (n, k, 2) [Nm | N] measured, and measured less simulated, where axes may give way to them.
    """
    step = float(np.median(np.diff(reference_time)))
    grid = even(reference_time, reference, step)
    spectrum = Spectrum(grid)
    # What is missing of a plan is bridged; behind a hole in it nothing is known for a while.
    holes = gaps(reference_time)
    use = usable & ~beside_gaps(time, tuple(holes), 3.5 * step, _MARGIN)
    use &= (time >= grid.start) & (time <= grid.time[-1])
    reach = np.ptp(reference, axis=0)
    found = []
    for axis in np.nonzero(reach > 1e-3)[0].tolist():
        good = use & np.isfinite(measured[:, axis])
        if good.sum() > 500:
            values = np.where(good, measured[:, axis], 0.0)
            load = None
            if torques is not None:
                rise = grid.at(time, spectrum.derivative(2, axis, SMOOTH)[:, None])
                load = np.column_stack([torques[:, axis, 0], rise, torques[:, axis, 1]])
            found.append(Follower(axis, time, values, spectrum, good, load))
    return found


def stretch(all_axes: list[Follower]) -> list[Follower]:
    """The followers of the stretch of at most `_LONGEST` samples in which all axes move most."""
    first = all_axes[0]
    grid = first.reference.grid
    count = len(first.time)
    if count <= _LONGEST * 1.25:
        return all_axes
    pace = np.abs(np.diff(grid.values, axis=0, prepend=grid.values[:1]))
    pace = np.cumsum(np.sqrt(pace / np.maximum(pace.mean(axis=0), 1e-300)).sum(axis=1))
    width = min(int(_LONGEST * (first.time[-1] - first.time[0]) / count / grid.step), len(pace) - 1)
    at = int(np.argmax(pace[width:] - pace[:-width]))
    low, high = grid.time[at], grid.time[min(at + width, len(pace) - 1)]
    a, b = np.searchsorted(first.time, [low, high])
    i, j = at, min(at + width, len(pace) - 1)
    small = Spectrum(replace(grid, start=float(low), values=grid.values[i : j + 1]))
    inside = (first.time[a:b] > low + _MARGIN) & (first.time[a:b] < high - _MARGIN)
    return [
        Follower(
            *(f.axis, f.time[a:b], f.measured[a:b], small, f.use[a:b] & inside),
            f.load[a:b] if f.load is not None else None,
        )
        for f in all_axes
        if np.ptp(small.grid.values[:, f.axis]) > 1e-3 and (f.use[a:b] & inside).sum() > 500
    ]


def judge(all_axes: list[Follower], unfaulted: float | None) -> PositionResult:
    """The best story, what each axis has in it, and what of that the whole log confirms."""
    short = stretch(all_axes)
    told, noises = stories(short, unfaulted)
    scores = {s.name: s.score - told[0].score for s in told}
    refused = False
    story = told[0]
    zero = unfaulted if unfaulted is not None else story.late
    if story.name in (CLOCK, BOTH) and unfaulted is not None and not _agree(short, noises, story, zero):
        story, refused = next(s for s in told if s.name == NONE), True
    has_clock = story.name in (CLOCK, BOTH)
    by_axis = {f.axis: a for f, a in zip(short, story.axes, strict=True)}
    results = []
    for f in all_axes:
        shape, terms = (
            (by_axis[f.axis].shape, by_axis[f.axis].terms) if f.axis in by_axis else (FollowingShape(), ())
        )
        noise = noise_of(f, shape, story.late)
        results.append(_axis(f, noise, shape, terms, story.late, zero, unfaulted is None))
    late = story.late
    # An axis that lost its lag would have the clock make up for it.
    sure = [r for r in results if r.follower.axis in by_axis and r.terms == by_axis[r.follower.axis].terms]
    sure = sure or results
    step, error = lateness([r.follower for r in sure], [r.noise for r in sure], [r.shape for r in sure], late)
    if has_clock and len(short[0].time) < len(all_axes[0].time):
        late += step
    without = [s.score for s in told if s.name == NONE]
    delta = (min(without) - story.score) if without and has_clock else math.nan
    clock_gain = _clock_gain(results, story.late, zero) if has_clock else (0.0, 1.0)
    return PositionResult(tuple(results), late, error, has_clock, clock_gain, delta, scores, refused, zero)


def _agree(all_axes: list[Follower], noises: list[Whitened], story: Story, zero: float) -> bool:
    """Whether two thirds of the axes, asked alone, are late by the same time; what is not common is no clock."""
    whole = story.late - zero
    same = []
    for f, n, a in zip(all_axes, noises, story.axes, strict=True):
        late, shape, error = story.late, a.shape, 0.0
        for _ in range(4):
            step, error = lateness([f], [n], [shape], late)
            late += step
            shape = refine(f, shape, late, n, 2)
        same.append(abs(late - story.late) < max(_ALIKE * abs(whole), 4 * error))
    return sum(same) * 3 >= 2 * len(same)


def _clock_gain(results: list[AxisResult], late: float, zero: float) -> tuple[float, float]:
    """Mean of ln of held-out squares without the clock over with it, all axes together, and its p-value."""
    if late == zero:
        return 0.0, 1.0
    ratio = np.zeros(0)
    for r in results:
        table = _products(r.follower, r.noise, r.shape, r.terms, late, zero)
        own = np.log(held_out(table, r.terms) / held_out(table, ("clock", *r.terms)))
        ratio = own if not len(ratio) else ratio + own
    spread = max(float(ratio.std(ddof=1)) / math.sqrt(len(ratio)), 1e-300)
    mean = float(ratio.mean())
    return mean, student_tail(mean / spread, len(ratio) - 1)


def seconds_left(result: PositionResult) -> float:
    """[s] RMS of what is left of all axes, as time at their own speeds."""
    off = way = 0.0
    for axis in result.axes:
        f = axis.follower
        left = (f.residual - f.effects(axis.shape, result.late))[f.use]
        speed = f.seen(f.reference.derivative(1, f.axis, f.reference.grid.step))[f.use]
        scale = max(float((speed**2).mean()), 1e-300)
        off, way = off + float(left.var()) / scale, way + 1.0
    return math.sqrt(off / max(way, 1.0))


def drift(result: PositionResult) -> tuple[float, float]:
    """By how much the lateness grows per second [1] and its standard error, everything else free beside it."""
    power = product = 0.0
    for axis in result.axes:
        follower, late = axis.follower, result.late
        _, effect, slope = jacobian(follower, axis.shape, late)
        moved = (follower.effects(axis.shape, late + 1e-5) - effect) / 1e-5
        middle = float(follower.time[follower.use].mean())
        own = axis.noise.of(np.column_stack([slope, np.ones(len(effect)), moved]))
        grows = moved * (follower.time - middle)
        both = axis.noise.of(np.column_stack([grows, follower.residual - effect]))
        basis = np.linalg.qr(own / np.maximum(np.linalg.norm(own, axis=0), 1e-300))[0]
        both = both - basis @ (basis.T @ both)
        square, across = float(both[:, 0] @ both[:, 0]), float(both[:, 0] @ both[:, 1])
        rest = both[:, 1] - both[:, 0] * across / max(square, 1e-300)
        variance = max(float(rest @ rest) / len(rest), 1e-300)
        power, product = power + square / variance, product + across / variance
    return product / max(power, 1e-300), 1 / math.sqrt(max(power, 1e-300))


def _table(
    follower: Follower, shape: FollowingShape, terms: tuple[str, ...], late: float, zero: float
) -> Floats:
    """(n, 2 + t) constant, clock and the terms, linear at the fitted shapes."""
    base = follower.delay(late)
    columns = [np.ones(len(base)), base - (follower.delay(zero) if zero else 0.0)]
    before = base
    for number in range(1, len(terms) + 1):
        # Each on top of those before it: a gear swings as its servo moves it, not as it was told to.
        now = follower.effects(shape.only(terms[:number]), late)
        columns.append(now - before)
        before = now
    return np.stack(columns, axis=1)


def _products(
    follower: Follower,
    noise: Whitened | None,
    shape: FollowingShape,
    terms: tuple[str, ...],
    late: float,
    zero: float,
) -> Products:
    kinds = (
        LibraryColumn(""),
        LibraryColumn("clock"),
        *(LibraryColumn(t, t != "joint-compliance", 3 if t == "joint-compliance" else 1) for t in terms),
    )
    table = _table(follower, shape, terms, late, zero)
    target = follower.residual - (follower.delay(zero) if zero else 0.0)
    if late == zero:
        table, kinds = np.delete(table, 1, axis=1), (kinds[0], *kinds[2:])
    if noise is None:
        return products(table[follower.use], target[follower.use], kinds)
    return products(noise.of(table), noise.of(target), kinds)


def _axis(
    follower: Follower,
    noise: Whitened,
    shape: FollowingShape,
    terms: tuple[str, ...],
    late: float,
    zero: float,
    late_free: bool,
) -> AxisResult:
    """Terms stay while they are large enough and the held-out blocks want them."""
    while True:
        shape = refine(follower, shape.only(terms), late, noise, 2)
        # A clock is one for all axes: as a free column it would stand for the lag that is left out.
        table = _products(follower, noise, shape, terms, late, late)
        gains = {t: gain(table, terms, t) for t in terms}
        whole = criterion(table, terms)
        delta = {t: criterion(table, tuple(c for c in terms if c != t)) - whole for t in terms}
        left = follower.residual - follower.effects(shape, late)
        rest = float(left[follower.use].std())
        base = follower.delay(late)
        size = {
            t: float((follower.effects(shape.only((t,)), late) - base)[follower.use].std()) for t in terms
        }
        known = _products(follower, None, shape, terms, late, late)
        after = held_out(known, terms).mean()
        helps = {t: held_out(known, tuple(c for c in terms if c != t)).mean() / after for t in terms}
        least = 1.0 if late_free else _LEAST_LAG
        weak = [
            t
            for t in terms
            if size[t] < _LEAST * rest
            or not delta[t] > 0
            or helps[t] < _HELPS**2
            or _no_sense(t, shape, follower, least)
        ]
        if not weak:
            raw = _products(follower, None, shape, terms, late, zero)
            return AxisResult(follower, noise, shape, terms, gains, delta, raw, size)
        worst = min(weak, key=lambda t: size[t])
        terms = tuple(t for t in terms if t != worst)


def _no_sense(term: str, shape: FollowingShape, follower: Follower, least: float) -> bool:
    """A lag of a fraction of a sample, or an oscillation that ran into its bounds."""
    step = follower.reference.grid.step
    if term == "servo-lag":
        # It says more of how the log was written than of a servo.
        return shape.lag < least * step
    if term == "joint-compliance":
        beyond = shape.frequency > 0.9 * math.pi / step or shape.frequency < 2 * math.pi * 0.6
        return beyond or abs(shape.swing) > 10 or shape.damping > 0.49 or shape.twist <= 2e-12
    return shape.play <= 2e-9


def drop(result: AxisResult, terms: tuple[str, ...], late: float, zero: float) -> AxisResult:
    """The axis with only `terms`, refitted."""
    return _axis(result.follower, result.noise, result.shape, terms, late, zero, False)


def numbers(result: AxisResult, late: float, has_clock: bool) -> dict[str, tuple[float, float]]:
    """Name of a number of the shape -> value and half-width of its 95 % interval."""
    names, effect, slope = jacobian(result.follower, result.shape, late)
    if not names:
        return {}
    ones = np.ones(len(effect))
    matrix = [slope, ones]
    if has_clock:
        matrix.append((result.follower.effects(result.shape, late + 1e-5) - effect) / 1e-5)
    whole = result.noise.of(np.column_stack(matrix))
    left = result.noise.of(result.follower.residual - effect)
    table = products(whole, left, (LibraryColumn(""),) * whole.shape[1])
    _, _, widths = intervals(table, ())
    return {n: (getattr(result.shape, n), float(w)) for n, w in zip(names, widths, strict=False)}
