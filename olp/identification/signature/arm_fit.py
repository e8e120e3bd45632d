"""From recorded joint moves to an arm's timing: the most probable numbers under the prior, and what they leave
unknown.

Gauss-Newton on the logarithms of the durations with Student's weights, so that pauses and replanned moves
count little.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from olp.timing.arm import ArmTiming, JointMotions, gradient, solve

Floats = NDArray[np.float64]

_FREEDOM: Final = (
    3.0  # degrees of freedom of Student's t: one move in twenty is off by more than three scatters
)
_STEPS: Final = 60
_ENOUGH: Final = 1e-6
_LEAST_SCATTER: Final = 0.004
_KNOWN_SCATTER_WEIGHT: Final = 8.0  # moves that the prior's scatter counts as much as


class ArmFit(NamedTuple):
    """`timing` after the moves; `residual` (n,) ln(measured/law) and `weight` (n,) that each move had, 0 to 1 about."""

    timing: ArmTiming
    residual: Floats
    weight: Floats


def fit_arm(
    prior: ArmTiming,
    motions: JointMotions,
    measured: Floats,
    resolution: float = 0.0,
    start: Floats | None = None,
) -> ArmFit:
    """`measured` (n,) [s] above zero, of moves whose numbers are all finite; `resolution` [s] of them."""
    log_measured = np.log(measured)
    rounding = resolution / np.sqrt(12.0) / measured
    precision: Floats = np.asarray(np.linalg.inv(prior.covariance), dtype=np.float64)
    mean = prior.mean.copy() if start is None else start.copy()
    scatter = max(prior.scatter, _scatter(log_measured - _logs(mean, motions), prior.scatter))
    damping = 1e-3
    residual = log_measured - _logs(mean, motions)
    for _ in range(_STEPS):
        variance = scatter**2 + rounding**2
        weight = _weights(residual, variance)
        cost = _cost(residual, variance, mean - prior.mean, precision)
        jacobian = gradient(mean, motions)
        scaled = jacobian * (weight / variance)[:, None]
        normal = jacobian.T @ scaled + precision
        pull = scaled.T @ residual - precision @ (mean - prior.mean)
        moved = False
        for _ in range(8):
            step = np.linalg.solve(normal + damping * np.diag(np.diag(normal)), pull)
            trial = log_measured - _logs(mean + step, motions)
            if (
                np.isfinite(trial).all()
                and _cost(trial, variance, mean + step - prior.mean, precision) <= cost
            ):
                moved = True
                break
            damping *= 8.0
        if not moved:
            break
        mean, residual = np.asarray(mean + step, dtype=np.float64), trial
        damping = max(damping / 6.0, 1e-9)
        scatter = _scatter(residual, prior.scatter)
        if np.max(np.abs(step) / np.sqrt(np.diag(prior.covariance))) < 1e-3:
            break
    variance = scatter**2 + rounding**2
    weight = _weights(residual, variance)
    jacobian = gradient(mean, motions)
    covariance = np.linalg.inv(jacobian.T @ (jacobian * (weight / variance)[:, None]) + precision)
    timing = replace(prior, mean=mean, covariance=covariance, scatter=scatter)
    return ArmFit(timing, residual, weight)


def _logs(mean: Floats, motions: JointMotions) -> Floats:
    return np.log(np.maximum(solve(mean, motions).duration, 1e-6))


def _weights(residual: Floats, variance: Floats) -> Floats:
    """Of Student's t."""
    return np.asarray((_FREEDOM + 1.0) / (_FREEDOM + residual**2 / variance))


def _cost(residual: Floats, variance: Floats, away: Floats, precision: Floats) -> float:
    own = (_FREEDOM + 1.0) * np.sum(np.log1p(residual**2 / (_FREEDOM * variance)))
    return float(own + away @ precision @ away)


def _scatter(residual: Floats, known: float) -> float:
    """[1] the residual's scale by its median, with the prior's as some more moves."""
    count = len(residual)
    found = 1.4826 * float(np.median(np.abs(residual))) if count else known
    mixed = np.sqrt((count * found**2 + _KNOWN_SCATTER_WEIGHT * known**2) / (count + _KNOWN_SCATTER_WEIGHT))
    return max(float(mixed), _LEAST_SCATTER)
