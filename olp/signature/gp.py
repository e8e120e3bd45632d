"""A Gaussian process: smooth functions of a few groups of coordinates, with noise that bears outliers.

Covariance s² m(d) with m the Matérn 5/2 function and d² the sum over groups of (distance / length)²;
C. E. Rasmussen and C. K. I. Williams, Gaussian Processes for Machine Learning
(MIT Press 2006), equations 4.17, 5.8, 5.9.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from olp.signature.minimise import minimise

Floats = NDArray[np.float64]

_ROOT5 = np.sqrt(5.0)
# [standard deviations] Beyond this a value's noise is taken as larger, the further the more; rounds of that.
_OUTLIER, _ROUNDS = 4.0, 2
_JITTER = 1e-8


class Prior(NamedTuple):
    """Log-normal beliefs of scale, lengths and noise: middle value and spread of the logarithm."""

    scale: tuple[float, float]
    lengths: tuple[tuple[float, float], ...]
    noise: tuple[float, float]

    @property
    def middle(self) -> Floats:
        return np.log([self.scale[0], *(m for m, _ in self.lengths), self.noise[0]])

    @property
    def spread(self) -> Floats:
        return np.array([self.scale[1], *(s for _, s in self.lengths), self.noise[1]])


class Process(NamedTuple):
    """What was learnt: values are those at `places`, less nothing."""

    scale: float
    lengths: tuple[float, ...]
    noise: float
    places: tuple[Floats, ...]  # one (n, k) array per group
    weights: Floats  # (n,) inverse covariance times values
    extra: Floats  # (n,) variance of each value's noise


def learn(places: tuple[Floats, ...], values: Floats, prior: Prior, floor: float = 0.0) -> Process:
    """The most probable scale, lengths and noise (not below `floor`), with outliers set apart, and the weights."""
    squares = [_squares(p, p) for p in places]
    extra = np.ones(len(values))
    theta = prior.middle
    for turn in range(_ROUNDS):
        share = extra
        theta = minimise(lambda t: _cost(t, squares, values, share, prior), theta, 40 if turn == 0 else 12)  # noqa: B023
        noise = max(float(np.exp(theta[-1])), floor)
        inverse = np.linalg.inv(_covariance(theta, squares)[0] + np.diag(noise**2 * extra))
        spread = np.sqrt(1.0 / np.diag(inverse))
        left_out = (inverse @ values) / np.diag(inverse)
        # The value's own inflated noise must not excuse it.
        plain = np.sqrt(np.maximum(spread**2 - noise**2 * (extra - 1.0), noise**2))
        extra = np.maximum(1.0, np.abs(left_out) / plain / _OUTLIER) ** 2
    noise = max(float(np.exp(theta[-1])), floor)
    matrix = _covariance(theta, squares)[0] + np.diag(noise**2 * extra)
    weights = np.asarray(np.linalg.solve(matrix, values))
    lengths = tuple(float(v) for v in np.exp(theta[1:-1]))
    variances = np.asarray(noise**2 * extra, dtype=np.float64)
    return Process(float(np.exp(theta[0])), lengths, noise, places, weights, variances)


def answer(process: Process, places: tuple[Floats, ...]) -> tuple[Floats, Floats]:
    """Mean and standard deviation (n,) at new places; the noise is not in the standard deviation."""
    theta = np.log([process.scale, *process.lengths, process.noise])
    cross = _covariance(theta, [_squares(a, b) for a, b in zip(places, process.places, strict=True)])[0]
    own = _covariance(theta, [_squares(p, p) for p in process.places])[0] + np.diag(process.extra)
    solved = np.linalg.solve(own, cross.T)
    variance = process.scale**2 - np.sum(cross * solved.T, axis=1)
    return np.asarray(cross @ process.weights), np.sqrt(np.maximum(variance, 0.0))


def _cost(
    theta: Floats, squares: Sequence[Floats], values: Floats, extra: Floats, prior: Prior
) -> tuple[float, Floats]:
    """Minus the logarithm of the posterior density of the logarithms, and its gradient (5.8, 5.9)."""
    covariance, slopes = _covariance(theta, squares, slopes=True)
    noise = np.exp(2 * theta[-1]) * extra
    try:
        factor = np.linalg.cholesky(covariance + np.diag(noise + _JITTER * np.exp(2 * theta[0])))
    except np.linalg.LinAlgError:
        return np.inf, np.zeros_like(theta)
    inverse_factor = np.linalg.solve(factor, np.eye(len(values)))
    inverse = inverse_factor.T @ inverse_factor
    weights = inverse @ values
    cost = 0.5 * float(values @ weights) + float(np.log(np.diag(factor)).sum())
    inner = inverse - np.outer(weights, weights)
    gradient = [float(np.sum(inner * covariance)), *(0.5 * float(np.sum(inner * s)) for s in slopes)]
    gradient.append(float(np.sum(np.diag(inner) * noise)))
    off = (theta - prior.middle) / prior.spread
    return cost + 0.5 * float(off @ off), np.array(gradient) + off / prior.spread


def _covariance(
    theta: Floats, squares: Sequence[Floats], slopes: bool = False
) -> tuple[Floats, list[Floats]]:
    """The covariance, and its slope along the logarithm of each length."""
    parts = [s * np.exp(-2 * t) for s, t in zip(squares, theta[1:-1], strict=True)]
    distance = np.sqrt(sum(parts[1:], parts[0]))
    fall = np.exp(2 * theta[0] - _ROOT5 * distance)
    covariance = (1 + _ROOT5 * distance + 5 / 3 * distance**2) * fall
    common = (5 / 3) * (1 + _ROOT5 * distance) * fall if slopes else fall
    return covariance, [common * p for p in parts] if slopes else []


def _squares(first: Floats, second: Floats) -> Floats:
    apart = np.sum(first**2, axis=1)[:, None] + np.sum(second**2, axis=1) - 2 * first @ second.T
    return np.asarray(np.maximum(apart, 0.0))
