"""All axes together against their reference: is everything late by one clock, or each axis by its own physics?

Three stories compete by BIC: no clock fault, a clock and no servo lag, both. In each, every axis takes the best set of
its terms; the clock's one number is fitted over all axes at once.
"""

from __future__ import annotations

import itertools
import math
from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from olp.identification.diagnosis.logs.follow import (
    BACKLASH,
    COMPLIANCE,
    LAG,
    Follower,
    FollowingShape,
    Whitened,
    compared,
    jacobian,
    refine,
    whitened,
)
from olp.identification.diagnosis.logs.select import criterion
from olp.timing.physics.clock import shift
from olp.timing.physics.joint_compliance import swing
from olp.timing.physics.servo_lag import lag

Floats = NDArray[np.float64]
TERMS = (LAG, COMPLIANCE, BACKLASH)
_COST = {LAG: 1, COMPLIANCE: 3, BACKLASH: 1}
_LOOK_ELSEWHERE = 4.0  # ln of independent frequencies that the scan looked at
_STEP = 0.02  # [s] of the lateness at a time
_EARLY = 0.02  # [s]
_FAR = 0.1  # [s] a clock that is that far off is more steps away than there are
NONE, CLOCK, BOTH = "none", "clock", "both"


@dataclass(frozen=True, slots=True)
class AxisStory:
    """What one axis does: its terms, their numbers, and the BIC of every set that was refitted."""

    terms: tuple[str, ...]
    shape: FollowingShape
    score: float
    scores: tuple[tuple[tuple[str, ...], float], ...]


@dataclass(frozen=True, slots=True)
class Story:
    """One account of all axes. `late` [s]: what the measured axes' clock reads too much against the reference."""

    name: str
    late: float
    late_error: float  # [s] standard error
    axes: tuple[AxisStory, ...]
    score: float


def stories(followers: list[Follower], unfaulted: float | None) -> tuple[list[Story], list[Whitened]]:
    """The accounts, best first. `unfaulted` [s]: the lateness at which no clock is wrong; None: there is none."""
    first = 0.0 if unfaulted is None else unfaulted
    fulls = [refine(f, start(f, first), first, None, 3) for f in followers]
    noises = [noise_of(f, s, first) for f, s in zip(followers, fulls, strict=True)]
    found = []
    if unfaulted is not None:
        axes = tuple(_axis(f, n, first, TERMS, s) for f, n, s in zip(followers, noises, fulls, strict=True))
        found.append(Story(NONE, first, 0.0, axes, sum(a.score for a in axes)))
    # The logs are paired as if all were the clock's: from there it has few steps to go.
    clock = _with_clock(followers, noises, 0.0, (COMPLIANCE, BACKLASH), CLOCK, None)
    # From too early a clock the lags begin too long and find their way; from too late a one they would begin at 0.
    near = unfaulted is not None and abs(unfaulted - clock.late) < _FAR
    early = first if near else clock.late - _EARLY
    found += [clock, _with_clock(followers, noises, early, TERMS, BOTH, fulls)]
    return sorted(found, key=lambda s: s.score), noises


def noise_of(follower: Follower, full: FollowingShape, late: float) -> Whitened:
    """What no mixture of lateness, terms and derivatives explains is the noise that everything is whitened by."""
    axis, reference = follower.axis, follower.reference
    left = follower.residual - follower.effects(full, late)
    smooth = reference.grid.step
    columns = [np.ones(len(left))]
    columns += [follower.seen(reference.derivative(order, axis, smooth)) for order in (1, 2, 3)]
    library = np.stack(columns, axis=1)
    use = follower.use
    sizes = np.linalg.lstsq(library[use], left[use], rcond=1e-10)[0]
    return whitened(follower, left - library @ sizes)


def _axis(
    follower: Follower, noise: Whitened, late: float, allowed: tuple[str, ...], guess: FollowingShape | None
) -> AxisStory:
    """The best set of terms of one axis: all sets by their linear columns, the best three refitted."""
    first = guess if guess is not None else start(follower, late)
    full = refine(follower, first.only(allowed), late, noise, 3)
    table = compared(follower, replace(full, lag=1e-4) if math.isnan(full.lag) else full, late, noise)
    sets = [s for size in range(len(allowed) + 1) for s in combinations(allowed, size)]
    rough = sorted(sets, key=lambda s: criterion(table, s))
    tried = list(dict.fromkeys([(), *rough[:3]]))
    results = []
    for terms in tried:
        shape = refine(follower, full.only(terms), late, noise, 3)
        results.append((terms, shape, _score(follower, shape, late, noise, terms)))
    terms, shape, score = min(results, key=lambda r: r[2])
    return AxisStory(terms, shape, score, tuple((t, s) for t, _, s in results))


def _with_lag(guess: FollowingShape, lagging: FollowingShape) -> FollowingShape:
    return replace(guess, lag=lagging.lag)


def _score(
    follower: Follower, shape: FollowingShape, late: float, noise: Whitened, terms: tuple[str, ...]
) -> float:
    left = noise.of(follower.residual - follower.effects(shape, late))
    constant = noise.of(np.ones(len(follower.time)))
    left = left - constant * float((constant * left).sum()) / max(float((constant**2).sum()), 1e-300)
    cost = sum(
        _COST[t] * math.log(len(left)) + (2 * _LOOK_ELSEWHERE if t == COMPLIANCE else 0) for t in terms
    )
    return len(left) * math.log(max(float((left**2).sum()), 1e-300) / len(left)) + cost


def _with_clock(
    followers: list[Follower],
    noises: list[Whitened],
    late: float,
    allowed: tuple[str, ...],
    name: str,
    guesses: list[FollowingShape] | None,
) -> Story:
    """Alternates between the common lateness, linear over all axes at once, and the axes' own terms."""
    shapes = [FollowingShape() for _ in followers]
    error = math.nan
    if guesses is not None:
        shapes = [
            refine(f, g.only((LAG,)), late, n, 2) for f, g, n in zip(followers, guesses, noises, strict=True)
        ]
    for _ in range(10):
        step, error = lateness(followers, noises, shapes, late)
        late += step
        shapes = [refine(f, s, late, n, 2) for f, s, n in zip(followers, shapes, noises, strict=True)]
        if abs(step) < 0.02 * error:
            break
    axes = tuple(
        _axis(f, n, late, allowed, None if guesses is None else _with_lag(g, s))
        for f, n, g, s in zip(followers, noises, guesses or shapes, shapes, strict=True)
    )
    for _ in range(3):
        shapes = [a.shape for a in axes]
        step, error = lateness(followers, noises, shapes, late)
        late += step
        axes = tuple(
            replace(a, shape=(s := refine(f, a.shape, late, n, 2)), score=_score(f, s, late, n, a.terms))
            for a, f, n in zip(axes, followers, noises, strict=True)
        )
        if abs(step) < 0.1 * error:
            break
    total = sum(a.score for a in axes) + math.log(sum(int(n.keep.sum()) for n in noises))
    return Story(name, late, error, axes, total)


def lateness(
    followers: list[Follower], noises: list[Whitened], shapes: list[FollowingShape], late: float
) -> tuple[float, float]:
    """Step [s] of the common lateness and its standard error, the axes' own numbers free beside it."""
    power = product = 0.0
    for follower, noise, shape in zip(followers, noises, shapes, strict=True):
        _, effect, slope = jacobian(follower, shape, late)
        width = 1e-5
        moved = (follower.effects(shape, late + width) - effect) / width
        own = noise.of(np.column_stack([slope, np.ones(len(effect))]))
        both = noise.of(np.column_stack([moved, follower.residual - effect]))
        basis = np.linalg.qr(own / np.maximum(np.linalg.norm(own, axis=0), 1e-300))[0]
        both = both - basis @ (basis.T @ both)
        # What is left by a wrong lateness is no noise: the fit of this axis alone tells how much is.
        alone = both[:, 1] - both[:, 0] * float(both[:, 0] @ both[:, 1]) / max(
            float(both[:, 0] @ both[:, 0]), 1e-300
        )
        variance = max(float(alone @ alone) / len(both), 1e-300)
        power += float(both[:, 0] @ both[:, 0]) / variance
        product += float(both[:, 0] @ both[:, 1]) / variance
    step = float(np.clip(product / max(power, 1e-300), -_STEP, _STEP))
    return step, 1 / math.sqrt(max(power, 1e-300))


# --- Guess ---
# First guesses of what an axis does: lag and play at once, then an oscillation or a twist.

Complex = NDArray[np.complex128]
_FREQUENCIES = 80
_DAMPINGS = (0.02, 0.08, 0.25)


def start(follower: Follower, late: float = 0.0) -> FollowingShape:
    """A first guess of every term at once: lag and play by least squares, the oscillation by a scan of what is left."""
    use, axis, reference = follower.use, follower.axis, follower.reference
    residual = follower.residual - (follower.delay(late) if late else 0.0)
    velocity = reference.derivative(1, axis, 0.5 * reference.grid.step)
    side = direction(reference.grid.values[:, axis])
    library = np.stack([np.ones(len(use)), -follower.seen(velocity), -follower.seen(side)], axis=1)
    _, late_by, half = np.linalg.lstsq(library[use], residual[use], rcond=None)[0]
    guess = FollowingShape(lag=float(np.clip(late_by, 2e-4, 0.4)), play=float(np.clip(2 * half, 1e-6, 0.1)))
    guess = refine(follower, guess, late, None, 3)
    left = follower.residual - follower.effects(guess, late)
    tried = []
    for frequency, damping, size in scan(follower, left, late, guess.lag):
        there = replace(guess, frequency=frequency, damping=damping, swing=size)
        there = refine(follower, there, late, None, 2)
        rest = (follower.residual - follower.effects(there, late))[use]
        tried.append((float(rest.var()), there))
    if follower.load is not None:
        there = twisted(follower, guess, left, late)
        tried.append((float((follower.residual - follower.effects(there, late))[use].var()), there))
    return min(tried, key=lambda t: t[0])[1]


def twisted(follower: Follower, guess: FollowingShape, left: Floats, late: float) -> FollowingShape:
    """`guess` and a gear that gives way to the torque, by least squares of what is `left` (n,)."""
    assert follower.load is not None
    use = follower.use
    matrix = np.column_stack([np.ones(len(use)), follower.load * np.array([-1.0, 1.0, -1.0])])[use]
    _, twist, push, give = np.linalg.lstsq(matrix, left[use], rcond=None)[0].tolist()
    there = replace(guess, twist=max(twist, 1e-12), push=max(push, 0.0), give=give)
    return refine(follower, there, late, None, 2)


def direction(values: Floats) -> Floats:
    """(n,) the direction of the last motion, held at rest: -1 or 1."""
    step = np.diff(values, prepend=values[0])
    # A quantised or filtered command never quite stands still.
    step = np.where(np.abs(step) > 1e-4 * np.abs(step).max(initial=0.0), np.sign(step), 0.0)
    where = np.maximum.accumulate(np.where(step != 0, np.arange(len(step)), 0))
    held = step[where]
    first = held[held != 0][0] if held.any() else 1.0
    return np.asarray(np.where(held == 0, first, held))


def scan(
    follower: Follower, residual: Floats, late: float, constant: float
) -> list[tuple[float, float, float]]:
    """Frequency [rad/s], damping and size of the oscillations that explain most of a residual (n,), best two.

    By spectra on the even grid, on top of a clock that is `late` [s] and a lag of `constant` [s].
    """
    reference, axis = follower.reference, follower.axis
    grid = reference.grid
    good = follower.use
    filled = np.interp(grid.time, follower.time[good], (residual - residual[good].mean())[good], 0.0, 0.0)
    padded = np.zeros(reference.size)
    padded[: len(filled)] = filled
    omega = reference.omega
    nyquist = math.pi / grid.step
    low, high = 2 * math.pi * 1.0, min(0.6 * nyquist, 2 * math.pi * 60)
    inside = (omega > 0.3 * low) & (omega < min(1.5 * high, nyquist))
    w, answer = omega[inside], np.fft.rfft(padded)[inside]
    weight = np.sqrt(1 / _level(np.abs(answer) ** 2))
    source = reference.transform[inside, axis] * (1 + shift(w, late)) * (1 + lag(w, constant)) * weight
    # Far above the motion an oscillation looks like lateness or lag: both are taken out first.
    taken = _real(np.stack([1j * w * source, w**2 * source, 1j * w**3 * source], axis=1))
    basis = np.linalg.qr(taken / np.maximum(np.linalg.norm(taken, axis=0), 1e-300))[0]
    target = _real(answer * weight)
    target = target - basis @ (basis.T @ target)
    tried = []
    for frequency in np.geomspace(low, high, _FREQUENCIES).tolist():
        own = []
        for damping in _DAMPINGS:
            column = _real(swing(w, frequency, damping) * source)
            column = column - basis @ (basis.T @ column)
            norm = max(float(column @ column), 1e-300)
            product = float(column @ target)
            own.append((product * product / norm, frequency, damping, float(np.clip(product / norm, -5, 5))))
        tried.append(max(own))
    scores = np.array([t[0] for t in tried])
    peaks = [i for i in range(len(scores)) if scores[i] == scores[max(i - 2, 0) : i + 3].max()]
    best = sorted(peaks, key=lambda i: -scores[i])[:2]
    return [tried[i][1:] for i in best]


def _real(values: Complex) -> Floats:
    """Complex equations as twice as many real ones."""
    return np.concatenate([values.real, values.imag])


def _level(power: Floats) -> Floats:
    """A smooth floor under a spectrum: running medians over 1/40 of it."""
    edges = np.unique(np.linspace(0, len(power), 41).astype(int))
    middles = (edges[:-1] + edges[1:]) / 2
    medians = [np.median(power[a:b]) for a, b in itertools.pairwise(edges)]
    return np.asarray(np.exp(np.interp(np.arange(len(power)), middles, np.log(np.maximum(medians, 1e-300)))))
