"""The verdict on a recording, and the noise floor that it is measured by: what the names leave over it decides."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from olp.identification.diagnosis import evidence
from olp.identification.diagnosis.folds import rms
from olp.identification.diagnosis.naming import NamingResult
from olp.identification.diagnosis.scatter import REMAINS, Scatter, beyond_digits, digits_of, scatter_of
from olp.identification.diagnosis.waits import far_on_one_side, tails_of

Floats = NDArray[np.float64]

AGREES = 2.0  # times the noise floor: what is off by more is no agreement
EXPLAINED = 1.5  # times the noise floor that names leave at most
FEWEST = 4  # moves; fewer are no comparison
_HALVED = 4.0  # times the mean square: an explanation takes away half of the error, at least
_MORE = 2.0  # times the mean square: names that explain more of it than they leave as scatter
_GROWS = 0.01  # [s/s] of the moves' times: makers say of their own simulations that they are off by no more
_BY_CHANCE = 3.3  # standard errors that chance passes in one of two thousand recordings
_FAR = 6.0  # times the middle's scatter: what is farther off counts as that, no single long move decides


def unseen_errors(named: NamingResult) -> Floats:
    """(m,) [s] of the moves that do not wait, by names that were found and fitted without them."""
    predicted = named.selection.predicted if named.fit.model.parts else named.clean.simulated
    return np.asarray((named.clean.measured - predicted)[in_time(named)])


def in_time(named: NamingResult) -> NDArray[np.bool_]:
    """Of the moves that were fitted, those that do not wait: some wait for less than the terms may be off by."""
    return np.asarray(~named.waiting[~named.late])


def floor_of(named: NamingResult) -> Scatter:
    """Of repeats where there are enough, else of what remains or of moves that are alike; at least the digits."""
    least = max(digits_of(named.clean), named.noise.least)
    return scatter_of(left_over(named), named.clean, least, named.remains.structured)


def left_over(named: NamingResult) -> Floats:
    """(n,) [s] of the moves that are not late."""
    return np.asarray(named.clean.measured - named.fit.model.seconds(named.clean))


def verdict_of(named: NamingResult) -> str:
    """One of VERDICTS, from the durations alone."""
    if len(named.late) < FEWEST:
        return "not-judged"
    sigma, tails = floor_of(named).value, heavy_tails(named)
    off = left_over(named)[in_time(named)]
    left, raw = _beside(off, tails), rms(named.clean.residual)
    nameless = not named.fit.model.parts and not named.late.any()
    pattern = named.remains.surely_structured if nameless else named.remains.structured
    pattern = pattern and not only_rounding(named)
    if nameless:
        grows = _grows(off, named.clean.simulated[in_time(named)])
        differs = pattern or grows or left > AGREES * sigma or bool(far_moves(named).any())
        return "unexplained" if differs else "no-mismatch"
    unseen = (named.clean.measured - named.selection.predicted)[in_time(named)]  # by the whole search
    if max(left, _beside(unseen, tails)) <= EXPLAINED * sigma and not (
        pattern and left**2 > evidence.LITTLE * raw**2
    ):
        return "explained"
    return "partly-explained"


def only_rounding(named: NamingResult) -> bool:
    """Whether what remains is no more than the recorder's digits leave: it has a pattern where few durations are
    foretold, each of which is rounded by the same."""
    here = np.flatnonzero(in_time(named))
    return not beyond_digits(left_over(named)[here], named.clean.take(here), named.noise.order)


def far_moves(named: NamingResult) -> NDArray[np.bool_]:
    """(n,) of the moves that are not late, those that no scatter makes: far out, and on one side."""
    here, sigma = in_time(named), floor_of(named).value
    far = np.zeros(len(here), dtype=bool)
    far[here] = far_on_one_side(left_over(named)[here], sigma, named.clean.resolution)
    return far


def taken_away(named: NamingResult) -> float:
    """[1] How many times larger the unseen moves' mean square is without the names, over what is asked of an
    explanation; 0 where it hardly differs.

    Asked is half of the error beyond the noise. Where nothing but what the names leave tells the noise, none is beyond
    it: half of the error of the moves in which they act, or, if they leave scatter, more of all moves' mean square than
    they leave.
    """
    if not named.fit.model.parts:
        return math.inf
    raw, floor = named.clean.residual, floor_of(named)
    unseen = named.clean.measured - named.selection.predicted
    if floor.source != REMAINS:
        return evidence.clipped_cut(raw, unseen, floor.value) / _HALVED
    acts = np.abs(raw - unseen) > evidence.ACTS * floor.value
    there = evidence.clipped_cut(raw[acts], unseen[acts], 0.0) if acts.any() else 0.0
    scatter = rms(unseen) <= EXPLAINED * floor.value
    whole = evidence.clipped_cut(raw, unseen, 0.0) if scatter else 0.0
    return max(there / _HALVED, whole / _MORE)


def heavy_tails(named: NamingResult) -> float:
    """[s²] of the mean square of what the names leave, what is a scatter's; none of a pattern."""
    if named.remains.structured:
        return 0.0
    return tails_of(left_over(named), named.clean, beside_names=bool(named.fit.model.parts))


def _beside(off: Floats, tails: float) -> float:
    """[s] root mean square of `off` (n,) [s] without the heavy tails of a scatter, `tails` [s²], which are not in the
    noise floor either."""
    return math.sqrt(max(float(np.mean(off**2)) - tails, 0.0))


def joined(one: str, other: str, found: bool) -> str:
    """The verdict of durations and logs together."""
    judged = {one, other} - {"not-judged"}
    if not judged:
        return "not-judged"
    if found:
        return "explained" if judged <= {"explained", "no-mismatch"} else "partly-explained"
    return "unexplained" if "unexplained" in judged else "no-mismatch"


def _grows(off: Floats, seconds: Floats) -> bool:
    """Whether the size of a difference, `off` (n,) [s], grows with the moves' `seconds` (n,), by least squares, by more
    than makers say of their own simulations and than chance does: a recorder scatters as much in short moves as in long
    ones, and robots repeat to within thousandths."""
    size = np.abs(off - np.median(off))
    size = np.minimum(size, _FAR * 1.4826 * float(np.median(size)))
    long = seconds - seconds.mean()
    square = max(float(long @ long), 1e-12)
    slope = float(size @ long) / square
    rest = size - size.mean() - slope * long
    error = math.sqrt(float(rest @ rest) / max(len(off) - 2, 1) / square)
    return slope > _GROWS and slope > _BY_CHANCE * error
