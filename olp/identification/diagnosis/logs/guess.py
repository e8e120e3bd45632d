"""First guesses of what an axis does: lag and play at once, then an oscillation or a twist."""

from __future__ import annotations

import itertools
import math
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from olp.identification.diagnosis.logs.follow import Follower, FollowingShape, refine
from olp.timing.physics.clock import shift
from olp.timing.physics.joint_compliance import swing
from olp.timing.physics.servo_lag import lag

Floats = NDArray[np.float64]
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
    return np.exp(np.interp(np.arange(len(power)), middles, np.log(np.maximum(medians, 1e-300))))
