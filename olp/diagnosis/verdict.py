"""The verdict, and the noise that it is measured by."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from olp.diagnosis.naming import Named
from olp.diagnosis.remains import LEVEL, f_tail, remains_of
from olp.diagnosis.scatter import Scatter, scatter_of
from olp.diagnosis.waits import spread

if TYPE_CHECKING:
    from olp.recording.recording import NoiseFloor

Floats = NDArray[np.float64]

_ENOUGH = 8  # degrees of freedom behind repeats, for them to judge a fit
_MOST = 0.5  # of the mean square that names leave: with more they explain too little
# The same where what remains goes with time: a cause that comes and goes leaves its mean to terms that always act.
_MOST_BY_TIME = 0.12
_BY_TIME = ("previous move", "previous moves", "a period in the order of moves", "t_start_s", "move", "cycle")
_TAILS = 1.6  # times the middle's scatter: then a few moves hold most of the difference
_ROUGH, _DIGITS = 0.03, 8.0  # share of a duration, and times the digits' standard deviation
_FEW, _MOST_ELSEWHERE = 0.05, 0.35  # of the moves, and of the mean square that names leave in all others
_LITTLE = 0.02  # of the mean square: what remains does not matter


def floor_of(floor: NoiseFloor, named: Named) -> Scatter:
    """Of repeats where there are enough, else of what remains or of moves that are alike; at least the digits."""
    digits = float(np.nan_to_num(floor.resolution)) / np.sqrt(12.0)
    least = max(digits, named.noise.least)
    return scatter_of(left_over(named), named.clean, least, named.remains.structured)


def _within_digits(named: Named, floor: NoiseFloor) -> bool:
    """Whether what remains is less than the clock's own digits leave: no pattern in it matters then.

    (The scatter of repeats would not do: what drifts or comes back scatters repeats.)
    """
    digits = float(np.nan_to_num(floor.resolution)) / np.sqrt(12.0)
    return bool(digits > 0 and float(np.mean(left_over(named) ** 2)) <= digits**2)


def _no_scatter(named: Named, floor: NoiseFloor) -> bool:
    """Whether the difference is far more than digits leave, in seconds and in percent: robots repeat better."""
    digits = float(np.nan_to_num(floor.resolution)) / np.sqrt(12.0)
    residual, measured = named.clean.residual, np.maximum(named.clean.measured, 1e-6)
    rough = float(np.mean(np.abs(residual) / measured)) > _ROUGH
    return bool(digits > 0 and rough and float(np.mean(residual**2)) > (_DIGITS * digits) ** 2)


def left_over(named: Named) -> Floats:
    """(n,) [s] of the moves that are not late."""
    return np.asarray(named.clean.measured - named.fit.model.seconds(named.clean))


def verdict_of(named: Named, floor: NoiseFloor, found: bool) -> str:
    """One of VERDICTS, from the durations alone."""
    above = _above_repeats(named, floor)
    structured = named.remains.structured and not _within_digits(named, floor)
    if not found:
        return "unexplained" if structured or above or _no_scatter(named, floor) else "no-mismatch"
    raw, left = float(np.mean(named.clean.residual**2)), float(np.mean(left_over(named) ** 2))
    most = left > _MOST * raw and not _in_a_few_moves(named)
    if most and left > (_TAILS * spread(left_over(named), named.noise.least)) ** 2:
        return "unexplained" if not named.late.any() else "partly-explained"
    if not structured and not above:
        return "explained"
    by_time = _by_time(named)
    much = left > _MOST_BY_TIME * raw if by_time else left > _MOST * raw
    if much and not named.late.any() and (by_time or not _in_a_few_moves(named)):
        return "unexplained"
    return "partly-explained" if left > _LITTLE * raw else "explained"


def _by_time(named: Named) -> bool:
    """Whether what remains goes with time: also between repeats of the same move, where moves repeat.

    A program that runs again and again brings what is wrong with a move back with a period.
    """
    remains, case = named.remains, named.clean
    if not (abs(remains.order) > 0 or any(c.column in _BY_TIME for c in remains.correlates)):
        return False
    if len(case.repeats) != len(case):
        return True
    _, inverse, count = np.unique(case.repeats, return_inverse=True, return_counts=True)
    if len(case) - len(count) < _ENOUGH:
        return True
    left = left_over(named)
    often = (count > 1)[inverse]
    within = (left - (np.bincount(inverse, left) / count)[inverse]) * np.sqrt(
        count / np.maximum(count - 1, 1)
    )[inverse]
    rows = np.nonzero(often)[0].astype(np.int64)
    again = remains_of(within[rows], case.take(rows), {})
    return abs(again.order) > 0 or any(c.column in _BY_TIME for c in again.correlates)


def _in_a_few_moves(named: Named) -> bool:
    """Whether the names leave so much in a few moves only, and hold in all others."""
    left = left_over(named) ** 2
    rest = np.argsort(left)[: len(left) - math.ceil(_FEW * len(left))]
    before = float(np.sum(named.clean.residual[rest] ** 2))
    return bool(before > 0 and float(np.sum(left[rest])) < _MOST_ELSEWHERE * before)


def joined(one: str, other: str, found: bool) -> str:
    """The verdict of durations and logs together."""
    if found:
        return "explained" if {one, other} <= {"explained", "no-mismatch"} else "partly-explained"
    return "unexplained" if "unexplained" in (one, other) else "no-mismatch"


def _above_repeats(named: Named, floor: NoiseFloor) -> bool:
    """Whether what remains is more than repeats of the same move scatter (F test)."""
    if floor.freedom < _ENOUGH or not floor.floor > 0:
        return False
    left = left_over(named)
    ratio = float(np.mean(left**2)) / floor.floor**2
    return ratio > 1.3 and f_tail(ratio, len(left), floor.freedom) < LEVEL
