"""A Gaussian process: a sum of smooth functions, each of some groups of coordinates, with noise that bears outliers.

The covariance of each part is s² m(d) with m the Matérn 5/2 function and d² the sum over its groups of (distance /
length)²; C. E. Rasmussen and C. K. I. Williams, Gaussian Processes for Machine Learning (MIT Press 2006), equations
4.17, 5.8, 5.9.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

# [standard deviations] Beyond this a value's noise is taken as larger, the further the more; rounds of that.
_OUTLIER, _ROUNDS = 4.0, 2
_JITTER = 1e-8
_ENOUGH = 3e-3  # of the log-likelihood: less is no reason to go on
_BLOCK = 4096

# Coordinates (n, k) of every group of every part.
Places = tuple[tuple[Floats, ...], ...]


class Belief(NamedTuple):
    """Log-normal: a middle value and the spread of the logarithm."""

    middle: float
    spread: float


class KernelPart(NamedTuple):
    """One smooth function: its size, and its length in each group of coordinates."""

    scale: Belief
    lengths: tuple[Belief, ...]


class Fitted(NamedTuple):
    scale: float
    lengths: tuple[float, ...]


class FittedProcess(NamedTuple):
    """What was learnt of n values at `places`."""

    parts: tuple[Fitted, ...]
    noise: float
    places: Places
    weights: Floats  # (n,) inverse covariance times values
    variances: Floats  # (n,) of each value's noise


def learn(
    places: Places,
    values: Floats,
    parts: tuple[KernelPart, ...],
    noise: Belief,
    few: NDArray[np.int64] | None = None,
) -> FittedProcess:
    """The most probable scales, lengths and noise, with outliers set apart, and the weights.

    `few`: row numbers from which scales, lengths and noise are learnt, by default all.
    """
    whole = _squares(places, places)
    rows = np.arange(len(values)) if few is None else few
    squares = [[square[np.ix_(rows, rows)] for square in groups] for groups in whole]
    beliefs = [b for part in parts for b in (part.scale, *part.lengths)] + [noise]
    middle = np.log([b.middle for b in beliefs])
    spread = np.array([b.spread for b in beliefs])
    extra, theta, every = np.ones(len(rows)), middle, np.ones(len(values))
    for turn in range(_ROUNDS):
        share = extra

        def cost(t: Floats, share: Floats = share) -> tuple[float, Floats]:
            value, slope = _cost(t, squares, values[rows], share)
            off = (t - middle) / spread
            return value + 0.5 * float(off @ off), slope + off / spread

        theta = minimise(cost, theta, 40 if turn == 0 else 10, _ENOUGH)
        every = _extra(theta, whole, values, every)
        extra = every[rows]
    fitted = _fitted(theta, whole)
    size = float(np.exp(theta[-1]))
    variances = np.asarray(size**2 * every, dtype=np.float64)
    matrix = sum(_covariances(fitted, whole)) + np.diag(variances)
    weights = np.asarray(np.linalg.solve(matrix, values), dtype=np.float64)
    return FittedProcess(fitted, size, places, weights, variances)


def answer(process: FittedProcess, places: Places) -> tuple[Floats, Floats]:
    """Mean and standard deviation (n,) at new places; the noise is not in the standard deviation."""
    own = sum(_covariances(process.parts, _squares(process.places, process.places))) + np.diag(
        process.variances
    )
    # Once: a solution for each block costs more than the rest.
    whiten = np.linalg.inv(np.linalg.cholesky(own))
    whole = sum(part.scale**2 for part in process.parts)
    count = len(places[0][0])
    mean, doubt = np.empty(count), np.empty(count)
    for begin in range(0, count, _BLOCK):
        rows = slice(begin, begin + _BLOCK)
        asked = tuple(tuple(group[rows] for group in part) for part in places)
        cross = sum(_covariances(process.parts, _squares(asked, process.places)))
        mean[rows] = cross @ process.weights
        solved = whiten @ np.asarray(cross).T
        doubt[rows] = np.sqrt(np.maximum(whole - np.sum(solved**2, axis=0), 0.0))
    return mean, doubt


def _extra(theta: Floats, squares: list[list[Floats]], values: Floats, extra: Floats) -> Floats:
    """How many times the common variance each value's noise has: 1, and more for those the others do not foresee."""
    noise = float(np.exp(2 * theta[-1]))
    inverse = np.linalg.inv(sum(_covariances(_fitted(theta, squares), squares)) + np.diag(noise * extra))
    left_out = (inverse @ values) / np.diag(inverse)
    # The value's own inflated noise must not excuse it.
    plain = np.sqrt(np.maximum(1.0 / np.diag(inverse) - noise * (extra - 1.0), noise))
    return np.asarray(np.maximum(1.0, np.abs(left_out) / plain / _OUTLIER) ** 2)


def _cost(theta: Floats, squares: list[list[Floats]], values: Floats, extra: Floats) -> tuple[float, Floats]:
    """Minus the logarithm of the marginal likelihood, and its gradient along the logarithms (5.8, 5.9)."""
    fitted = _fitted(theta, squares)
    shapes = [_shape(part, groups) for part, groups in zip(fitted, squares, strict=True)]
    whole = np.asarray(sum(covariance for covariance, _ in shapes))
    noise = np.exp(2 * theta[-1]) * extra
    try:
        factor = np.linalg.cholesky(whole + np.diag(noise + _JITTER * float(whole[0, 0])))
    except np.linalg.LinAlgError:
        return np.inf, np.zeros_like(theta)
    inverse_factor = np.linalg.solve(factor, np.eye(len(values)))
    inverse = inverse_factor.T @ inverse_factor
    weights = inverse @ values
    cost = 0.5 * float(values @ weights) + float(np.log(np.diag(factor)).sum())
    inner = inverse - np.outer(weights, weights)
    gradient = []
    for part, (own, steepness), groups in zip(fitted, shapes, squares, strict=True):
        gradient.append(float(np.vdot(inner, own)))
        common = inner * steepness
        gradient += [
            0.5 * float(np.vdot(common, square)) / length**2
            for square, length in zip(groups, part.lengths, strict=True)
        ]
    gradient.append(float(np.diag(inner) @ noise))
    return cost, np.array(gradient)


def _fitted(theta: Floats, squares: list[list[Floats]]) -> tuple[Fitted, ...]:
    parts, place = [], 0
    for groups in squares:
        numbers = np.exp(theta[place : place + 1 + len(groups)]).tolist()
        parts.append(Fitted(numbers[0], tuple(numbers[1:])))
        place += 1 + len(groups)
    return tuple(parts)


def _covariances(parts: tuple[Fitted, ...], squares: list[list[Floats]]) -> list[Floats]:
    return [_shape(part, groups)[0] for part, groups in zip(parts, squares, strict=True)]


def _shape(part: Fitted, groups: list[Floats]) -> tuple[Floats, Floats]:
    """Covariance, and its steepness: the slope along the logarithm of a length is that times (distance / length)²."""
    square = sum(square / length**2 for square, length in zip(groups, part.lengths, strict=True))
    near = np.sqrt(5.0 * np.asarray(square))
    common = part.scale**2 * np.exp(-near)
    steepness = common * (1 + near)
    return steepness + common * near * near / 3, 5 / 3 * steepness


def _squares(first: Places, second: Places) -> list[list[Floats]]:
    return [
        [_apart(a, b) for a, b in zip(mine, others, strict=True)]
        for mine, others in zip(first, second, strict=True)
    ]


def _apart(first: Floats, second: Floats) -> Floats:
    square = np.sum(first**2, axis=1)[:, None] + np.sum(second**2, axis=1) - 2 * first @ second.T
    return np.asarray(np.maximum(square, 0.0))


# --- Minimise ---
# A small minimiser for smooth functions of a few variables: BFGS with a backtracking line search.
#
# J. Nocedal and S. J. Wright, Numerical Optimization (2nd ed., Springer 2006), algorithms 3.1 and 6.1.

# Of the decrease that the slope promises, the share that has to come true.
_MINIMISE_ENOUGH = 1e-4
_LONGEST = 1.0  # in the units of the variables, which are logarithms


def minimise(
    function: Callable[[Floats], tuple[float, Floats]], start: Floats, most: int, enough: float = 1e-6
) -> Floats:
    """The best point found from `start`. `function` gives value and gradient.

    Ends after `most` steps, or when one gains less than `enough`.
    """
    place = np.array(start, dtype=np.float64)
    value, slope = function(place)
    inverse = np.eye(len(place)) / max(1.0, float(np.linalg.norm(slope)))
    for _ in range(most):
        step = -inverse @ slope
        if step @ slope >= 0:
            inverse = np.eye(len(place)) / max(1.0, float(np.linalg.norm(slope)))
            step = -inverse @ slope
        step *= min(1.0, _LONGEST / max(float(np.max(np.abs(step))), 1e-12))
        size = 1.0
        while size > 1e-6:
            reached, new_slope = function(place + size * step)
            if reached <= value + _MINIMISE_ENOUGH * size * float(step @ slope):
                break
            size *= 0.4
        else:
            return place
        moved, turned = size * step, new_slope - slope
        place = place + moved
        gained, value, slope = value - reached, reached, new_slope
        curve = float(moved @ turned)
        if curve > 1e-12:
            left = np.eye(len(place)) - np.outer(moved, turned) / curve
            inverse = left @ inverse @ left.T + np.outer(moved, moved) / curve
        if gained < enough:
            return place
    return place
