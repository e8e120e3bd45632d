"""A Gaussian process of few observations: averaged over what its lengths and weights may be, none of them chosen.

Few moves do not tell the lengths of a process. Each member of a fixed grid answers, weighted by the evidence of the
observations (C. E. Rasmussen and C. K. I. Williams, Gaussian Processes for Machine Learning, MIT Press 2006, equations
2.30 and 5.9, the scale maximised). An observation may be the sum of several moves, as the total of a program is.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Labels = NDArray[np.int64]

# Lengths of the Matérn functions in spreads of what was learnt, a factor √3 apart; how much the terms count beside the
# place; noise of one move as a
# share of the variance of the function, large for totals that somebody took by hand.
LENGTHS = (1.0, 1.7, 3.0, 5.0)
SHARES = (0.3, 1.0, 3.0)
NOISES = (1e-3, 1e-2, 0.1, 1.0)
# The unknown level of all moves, in variances of the function: nothing is believed of it.
_LEVEL = 4.0
_ROOT5 = np.sqrt(5.0)


class Views(NamedTuple):
    """n moves seen twice."""

    places: Floats  # (n, 6) [m] start and end points
    terms: Floats  # (n, k) of the axes' motion, k = 0 without a robot

    def take(self, rows: Labels) -> Views:
        return Views(self.places[rows], self.terms[rows])


class Ruler(NamedTuple):
    """Middle and spread of what was learnt, per column of both views."""

    place_middle: Floats
    place_spread: Floats
    term_middle: Floats
    term_spread: Floats


class Observations(NamedTuple):
    """m numbers, each `share` of moves summed: `owner` (n,) says in which of them a move is."""

    values: Floats  # (m,)
    owner: Labels  # (n,)
    share: Floats  # (n,)

    def sum(self, rows: Floats) -> Floats:
        """(m, …) of (n, …): the moves' rows, weighed and summed."""
        weighed = rows * self.share.reshape(-1, *([1] * (rows.ndim - 1)))
        if len(self.owner) == len(self.values) and np.array_equal(self.owner, np.arange(len(self.owner))):
            return np.asarray(weighed)
        result = np.zeros((len(self.values), *rows.shape[1:]))
        np.add.at(result, self.owner, weighed)
        return result


class MixtureMember(NamedTuple):
    """One process of the grid."""

    place_length: float
    term_length: float
    term_share: float
    noise: float


class MixturePrediction(NamedTuple):
    """`sd`: of the process itself and between the members, in the unit of the values."""

    mean: Floats
    sd: Floats


def ruler_of(views: Views) -> Ruler:
    place, term = views
    # All three coordinates of both ends have one unit: the smallest spread must not stretch a coordinate's noise.
    place_spread = np.maximum(place.std(axis=0), 0.05 * max(float(place.std(axis=0).max(initial=0.0)), 1e-3))
    spread = term.std(axis=0)
    # A term that did not change while learning tells nothing.
    return Ruler(place.mean(axis=0), place_spread, term.mean(axis=0), np.where(spread > 1e-6, spread, np.inf))


def average_covariance(first: Views, second: Views, ruler: Ruler) -> Floats:
    """(n, m) of variance one per unit share: the mean over the grid, for what is designed before anything is known."""
    place, term = _distances(first, second, ruler)
    share = float(np.mean(SHARES)) if first.terms.shape[1] else 0.0
    total = sum(_matern(place / length) + share * _matern(term / length) for length in LENGTHS)
    return np.asarray(total / len(LENGTHS) + _LEVEL)


def members(views: Views) -> Iterator[MixtureMember]:
    """The grid."""
    if not views.terms.shape[1]:
        yield from (MixtureMember(length, 1.0, 0.0, noise) for length in LENGTHS for noise in NOISES)
        return
    for place in LENGTHS:
        for term in LENGTHS:
            yield from (MixtureMember(place, term, share, noise) for share in SHARES for noise in NOISES)


def answer(views: Views, seen: Observations, ruler: Ruler, wanted: Views) -> MixturePrediction:
    """The function at `wanted` (w,) from observations of the moves `views`."""
    level = float(seen.values.sum() / seen.sum(np.ones(len(seen.owner))).sum())
    left = seen.values - level * seen.sum(np.ones(len(seen.owner)))
    # Sums of sums of covariances are the same for all members: formed once per length.
    ones = np.ones(len(seen.owner))
    own, cross = _distances(views, views, ruler), _distances(wanted, views, ruler)
    inner = {n: [seen.sum(np.ascontiguousarray(seen.sum(_matern(d / n)).T)) for d in own] for n in LENGTHS}
    outer = {n: [seen.sum(np.ascontiguousarray(_matern(d / n).T)).T for d in cross] for n in LENGTHS}
    weight = seen.sum(ones)
    size = float(np.mean(seen.sum(seen.share)))
    said: list[tuple[float, Floats, Floats]] = []
    for member in members(views):
        share = member.term_share
        among = inner[member.place_length][0] + share * inner[member.term_length][1]
        to = outer[member.place_length][0] + share * outer[member.term_length][1]
        noise = member.noise * size * np.eye(len(left))
        said.append(
            _one(among + _LEVEL * np.outer(weight, weight) + noise, to + _LEVEL * weight, left, member)
        )
    evidence = np.array([e for e, _, _ in said])
    belief = np.exp(evidence - evidence.max())
    belief /= belief.sum()
    means, variances = np.array([m for _, m, _ in said]), np.array([v for _, _, v in said])
    mean = belief @ means
    return MixturePrediction(mean + level, np.sqrt(belief @ (variances + (means - mean) ** 2)))


def _one(own: Floats, cross: Floats, left: Floats, member: MixtureMember) -> tuple[float, Floats, Floats]:
    """Evidence, mean and variance of one process; its scale is the most probable one."""
    factor = np.linalg.cholesky(own)
    white = np.linalg.solve(factor, left)
    scale = max(float(white @ white) / len(left), 1e-30)
    evidence = -0.5 * len(left) * np.log(scale) - float(np.log(np.diag(factor)).sum())
    solved = np.linalg.solve(factor, cross.T)
    prior = 1.0 + member.term_share + _LEVEL
    return evidence, solved.T @ white, scale * np.maximum(prior - np.sum(solved**2, axis=0), 0.0)


def _distances(first: Views, second: Views, ruler: Ruler) -> tuple[Floats, Floats]:
    """(n, m) each, in spreads: of the places and of the terms."""
    middles = (ruler.place_middle, ruler.term_middle)
    spreads = (ruler.place_spread, ruler.term_spread)
    found = []
    for a, b, middle, spread in zip(first, second, middles, spreads, strict=True):
        one, two = (a - middle) / spread, (b - middle) / spread
        apart = np.sum(one**2, axis=1)[:, None] + np.sum(two**2, axis=1) - 2 * one @ two.T
        found.append(np.sqrt(np.maximum(apart, 0.0)))
    return found[0], found[1]


def _matern(distance: Floats) -> Floats:
    """Matérn 5/2 (4.17)."""
    near = _ROOT5 * distance
    return np.asarray((1 + near + near * near / 3) * np.exp(-near))
