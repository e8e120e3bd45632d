"""How much durations scatter: from repeats, else from what remains, else from neighbours, never from a pattern.

What remains of a model may still have a pattern: then moves that are alike, or come one after the other, differ by less
than all do, and their differences tell the scatter (J. Rice, Annals of Statistics 12, 1984; J. von Neumann, Annals of
Mathematical Statistics 12, 1941).
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from olp.timing.physics._case import MeasuredMoves

Floats = NDArray[np.float64]
Labels = NDArray[np.int64]

REPEATS, REMAINS, NEIGHBOURS, DIGITS = "repeats", "what remains", "neighbours", "the clock's digits"
_ENOUGH = 8  # degrees of freedom behind repeats
_LARGER = 0.001  # how seldom chance leaves so much more than a few repeats scatter
_FEWEST = 12  # moves without repeats
_BY_CHANCE = 2.33  # standard deviations that chance passes once in a hundred recordings
_ROUND = 1e-3  # of the resolution
_ALIKE = 0.25  # of the resolution: durations that differ by less are rounded alike
_PATTERN = 0.8  # times what remains: neighbours that differ by less show a pattern
_STEP = 3.0  # standard deviations of a difference: what is farther is a step
_SURELY = 3.3  # standard deviations, that chance passes in one of two thousand recordings
_APART = 2.0  # times the clock's digits
_SIDES = ("direction", "length and speed", "place", "start", "end")  # from which moves can be alike
FEWEST_FAR = 3  # moves far out: one or two are too few to tell a cause
_FAR = 6.0  # standard deviations of the middle: what is farther is no scatter


class Scatter(NamedTuple):
    """[s], and what told it: one of `REPEATS`, `REMAINS`, `NEIGHBOURS`, `DIGITS`; "" where nothing is known."""

    value: float
    source: str = ""


def scatter_of(left: Floats, case: MeasuredMoves, least: float, structured: bool) -> Scatter:
    """Of what a model leaves, `left` (n,) [s] of the moves of `case`; `least` [s]: what the clock's digits leave;
    `structured`: whether `left` goes together with anything."""
    freedom = _freedom(case)
    repeats = _off_repeats(left, case) if freedom >= _ENOUGH else None
    if repeats is None and len(left) <= 2:
        return Scatter(least, DIGITS)
    heaps = _within_two_heaps(left, case.resolution) if repeats is None and not structured else None
    whole = Scatter(_middle(left - np.median(left), case.resolution) if heaps is None else heaps, REMAINS)
    if repeats is not None:
        repeated = _of_repeats(repeats, case, structured)
        ratio = (whole.value / max(repeated, least)) ** 2
        heavy = 1.0 + 0.5 * _peaked(repeats, case.resolution)
        same = not structured and f_tail(ratio, (len(left) - 1) / heavy, freedom / heavy) > _LARGER
        # All moves tell the same scatter more surely than a few repeats.
        found = whole if same else Scatter(repeated, REPEATS)
    else:
        found = _of_neighbours(left, case, whole) if structured and len(left) >= _FEWEST else whole
    return found if found.value > least else Scatter(least, DIGITS)


def digits_of(case: MeasuredMoves) -> float:
    """[s] standard deviation that rounding to the clock's digits leaves in a difference of two durations, where the
    simulated ones are rounded as well (a uniform distribution each)."""
    if not case.resolution > 0:
        return 0.0
    off = np.abs(case.simulated / case.resolution - np.round(case.simulated / case.resolution))
    return case.resolution * float(np.sqrt((2.0 if (off < _ROUND).all() else 1.0) / 12.0))


def beyond_digits(left: Floats, case: MeasuredMoves, order: float = 0.0) -> bool:
    """Whether `left` (n,) [s] is more than rounding leaves by chance; the error of repeats is one and the same, and so
    is that of moves for which one duration is foretold (a pallet's places differ, lines to them take one time).

    `order` [1]: correlation of a residual with the one before it. Where both are cut at one rounded stamp it is below
    0, and a duration has the errors of two stamps; what neighbours share tells how much of the second one there is. The
    square of a uniform error has a variance of 0.8 times its mean's square.
    """
    digits = digits_of(case)
    if not digits > 0:
        return True
    foretold = np.unique(np.rint((case.measured - left) / (_ALIKE * case.resolution)))
    count = min(len(case) - _freedom(case), len(foretold))
    square = float(np.mean(left**2))
    stamp = min(max(-order, 0.0) * square, case.resolution**2 / 12.0)  # [s²]
    more = square / (digits**2 + stamp) - 1.0
    return more > _BY_CHANCE * math.sqrt(0.8 / count)


def f_tail(x: float, top: float, bottom: float) -> float:
    """Tail of Fisher's F (E. Paulson, Annals of Mathematical Statistics 13, 1942: the cube root is nearly normal)."""
    a, b, root = 2.0 / (9.0 * top), 2.0 / (9.0 * bottom), max(x, 0.0) ** (1.0 / 3.0)
    z = ((1.0 - b) * root - (1.0 - a)) / math.sqrt(b * root**2 + a)
    return 0.5 * math.erfc(z / math.sqrt(2.0))


def _freedom(case: MeasuredMoves) -> int:
    """Degrees of freedom behind repeats."""
    return len(case) - len(np.unique(case.repeats)) if len(case.repeats) == len(case) else 0


def _off_repeats(left: Floats, case: MeasuredMoves) -> Floats:
    """(m,) [s] of the moves that have repeats, from the mean of these, in order of execution."""
    _, group, count = np.unique(case.repeats, return_inverse=True, return_counts=True)
    mean = np.bincount(group, left) / count
    many = count[group] > 1
    # Each deviation from its group's mean is as large as one of free values would be.
    return np.asarray(((left - mean[group]) * np.sqrt(count[group] / np.maximum(count[group] - 1, 1)))[many])


def _of_repeats(off: Floats, case: MeasuredMoves, structured: bool) -> float:
    """[s] between repeats of one move, `off` (m,) [s] each, without what drifts from one move to the next, or
    alternates."""
    whole = _middle(off, case.resolution)
    if not structured or len(off) <= _FEWEST:
        return whole
    apart = (off[lag:] - off[:-lag] for lag in (1, 2))
    after = min(_middle(one / np.sqrt(2.0), case.resolution) for one in apart)
    return after if after < _PATTERN * whole else whole


def _peaked(off: Floats, resolution: float) -> float:
    """[1] excess of the kurtosis, at least 0: variances of a heavy-tailed scatter differ by chance as those of fewer
    values do (G. Box, Biometrika 40, 1953)."""
    near = off[~far_out(off, resolution)]
    square = float(np.mean(near**2)) if len(near) else 0.0
    return max(float(np.mean(near**4)) / square**2 - 3.0, 0.0) if square > 0 else 0.0


def _of_neighbours(left: Floats, case: MeasuredMoves, whole: Scatter) -> Scatter:
    """The least that differences of moves which are alike in some way say, where that is clearly less than `whole`."""
    others = [_robust(np.diff(left), case.resolution)]
    for near in neighbours(case).values():
        others.append(_robust((left - left[near])[near >= 0], case.resolution))
    least = min(others)
    return Scatter(least, NEIGHBOURS) if least < _PATTERN * whole.value else whole


def _middle(values: Floats, resolution: float) -> float:
    """[s] root mean square of values (n,) around zero, without those that are far out; `resolution` [s]: digits make
    the middle nought where most values are equal."""
    near = ~far_out(values, resolution)
    return float(np.sqrt(np.mean(values[near] ** 2))) if near.any() else 0.0


def _within_two_heaps(left: Floats, resolution: float) -> float | None:
    """[s] of values (n,) around the middle of their heap, of two; None where they are one, or two that are as near
    as digits put them.

    No scatter with one middle has a kurtosis below a uniform one's, 1.8, whose error is √(1.32/n): what lies in two
    heaps is an effect that some moves have.
    """
    near = left[~far_out(left - np.median(left), resolution)]
    count = len(near)
    if count < _FEWEST:
        return None
    off = np.sort(near - near.mean())
    square = float(np.mean(off**2))
    if not square > 0 or float(np.mean(off**4)) / square**2 > 1.8 - _SURELY * math.sqrt(1.32 / count):
        return None
    first = np.arange(1, count)
    below = np.cumsum(off)[:-1]  # the mean is 0: above is as much
    low, high = below / first, -below / (count - first)
    at = int(np.argmax(first * (count - first) * (high - low) ** 2))
    if high[at] - low[at] <= _APART * resolution:
        return None
    middle = np.where(np.arange(count) <= at, low[at], high[at])
    return float(np.sqrt(np.mean((off - middle) ** 2)))


def far_out(values: Floats, resolution: float, share: float = 1.0) -> NDArray[np.bool_]:
    """(n,) which of the values around zero are farther out than the middle ones' scatter goes, or than a `share` of
    that."""
    reach = _FAR * max(1.4826 * float(np.median(np.abs(values))), resolution / 2.0)
    return np.asarray(np.abs(values) > share * reach)


def _robust(differences: Floats, resolution: float) -> float:
    """[s] of one value, from differences of two: of those near the middle, so that pairs across a step do not count.

    The middle alone would be nought where most pairs are equal in the clock's digits.
    """
    if not len(differences):
        return np.inf
    size = np.abs(differences)
    near = size <= max(_STEP * 1.4826 * float(np.median(size)), _STEP * resolution)
    return float(np.sqrt(np.mean(differences[near] ** 2) / 2.0)) if near.any() else 0.0


def neighbours(case: MeasuredMoves) -> dict[str, NDArray[np.intp]]:
    """For each side from which moves can be alike, (n,) the row of the move most like each; -1 where that is not known.

    Repeats of one move are no neighbours of it: only what was programmed otherwise tells of a pattern.
    """
    rows = case.once("most like each", lambda: np.stack(list(_neighbours(case).values())).astype(np.float64))
    return {name: near.astype(np.intp) for name, near in zip(_SIDES, rows, strict=True)}


def _neighbours(case: MeasuredMoves) -> dict[str, NDArray[np.intp]]:
    labels = case.repeats if len(case.repeats) == len(case) else np.arange(len(case))
    way = case.end - case.start
    length = np.linalg.norm(way, axis=1)
    with np.errstate(divide="ignore", invalid="ignore"):
        direction = way / length[:, None]
        size = np.stack([np.log(case.base.way), np.log(case.base.speed)], axis=1)
    sides = {
        "direction": direction,
        "length and speed": size,
        "place": 0.5 * (case.start + case.end),
        "start": case.start,
        "end": case.end,
    }
    return {name: _nearest(sides[name], labels, case.moving) for name in _SIDES}


def _nearest(columns: Floats, labels: Labels, moving: NDArray[np.bool_]) -> NDArray[np.intp]:
    """(n,) rows; of several that are as near, the one that was executed next to the move."""
    result = np.full(len(columns), -1, dtype=np.intp)
    good = np.nonzero(moving & np.isfinite(columns).all(axis=1))[0]
    scale = columns[good].std(axis=0) if len(good) else np.zeros(0)
    if not len(good) or not (scale > 0).any():
        return result
    places = columns[good][:, scale > 0] / scale[scale > 0]
    away = ((places[:, None, :] - places[None, :, :]) ** 2).sum(axis=2)
    away[labels[good][:, None] == labels[good][None, :]] = np.inf
    away += 1e-9 * np.abs(good[:, None] - good[None, :])
    near = np.argmin(away, axis=1)
    known = np.isfinite(away[np.arange(len(good)), near])
    result[good[known]] = good[near[known]]
    return result
