"""Which part of a log is which part of a program: dynamic time warping along the way, whatever the time it took.

Both ways are cut into steps of equal length, so dwells and speeds play no part, and paired in order at least squared
distance (H. Sakoe, S. Chiba, "Dynamic programming algorithm optimization for spoken word recognition", IEEE Trans.
ASSP 26(1), 1978). A distance counts no more than `REACH`: what lies farther away is not explained by the program, and
a stretch that only one of the two has cannot pull the rest apart.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
Indices = NDArray[np.intp]
REACH = 0.025  # [m]
_STEPS = 2_500  # that the program's way is cut into
_MOST_STEPS = 12_000
_FLAT = 1e-3  # [m] an extent that no distance depends on
_MOST_CONSIDERED = 100_000  # samples of a log that are looked at for its way


@dataclass(frozen=True, slots=True)
class Alignment:
    """`time` (k,) [s] of the log's steps and the program's `steps` (j,) [s]; pairs in order, both ascending.

    `where` (j,) [s]: when the log is at each step of the program. `distance` (j,) [m] to the nearest paired step.
    `explained` (k,): whether a step of the log is within reach of the program.
    `travelled` (j,) [m]: the log's way so far.
    """

    time: Floats
    steps: Floats
    where: Floats
    distance: Floats
    explained: NDArray[np.bool_]
    travelled: Floats
    size: float  # [m] of a step
    reach: float  # [m]
    offset: Floats  # (c,) [m] median of log - program over the paired steps within reach


def align(log_time: Floats, log_way: Floats, time: Floats, way: Floats) -> Alignment:
    """Pairs a log (n, c) [m] with a program's way (p, c) [m], times ascending [s]."""
    length = float(np.linalg.norm(np.diff(way, axis=0), axis=1).sum())
    # Steps of two ways may be half a step apart: far less than the reach.
    size = min(max(length / _STEPS, 1e-4), REACH / 3)
    mine, asked = keyframes(log_time, log_way, size), keyframes(time, way, size)
    while max(len(mine[0]), len(asked[0])) > _MOST_STEPS:
        size *= 1.5
        mine, asked = keyframes(log_time, log_way, size), keyframes(time, way, size)
    reach = max(REACH, 3 * size)
    left, right = _pairs(*_spanned(mine[1], asked[1]), reach)
    difference = mine[1][left] - asked[1][right]
    distance = np.linalg.norm(difference, axis=1)
    near = distance < reach
    nearest = np.full(len(asked[0]), np.inf)
    np.minimum.at(nearest, right, distance)
    explained = np.zeros(len(mine[0]), dtype=bool)
    explained[left[near]] = True
    first = np.searchsorted(right, np.arange(len(asked[0])), side="left")
    last = np.searchsorted(right, np.arange(len(asked[0])), side="right") - 1
    # Of all steps of the log paired with one of the program, those that are as near as any say when.
    where = (mine[0][left[first]] + mine[0][left[last]]) / 2
    offset = np.median(difference[near], axis=0) if near.any() else np.zeros(way.shape[1])
    travelled = (left[first] + left[last]) / 2 * size
    return Alignment(mine[0], asked[0], where, nearest, explained, travelled, size, reach, offset)


def keyframes(time: Floats, way: Floats, size: float) -> tuple[Floats, Floats]:
    """Times (k,) and places (k, c) every `size` [m] along the way; standing still, however noisily, adds none."""
    stride = 1 + len(time) // _MOST_CONSIDERED
    time, way = time[::stride], way[::stride]
    times, places = [float(time[0])], [way[0]]
    here, before = way[0], float(time[0])
    for at, place in zip(time.tolist(), way, strict=True):
        step = place - here
        gone = float(np.sqrt(step @ step))
        if gone < size:
            before = at if gone < size / 2 else before
            continue
        count = min(int(gone / size), _MOST_STEPS)
        for share in np.arange(1, count + 1) / count:
            times.append(before + (at - before) * share)
            places.append(here + step * share)
        here, before = place, at
        if len(times) > 4 * _MOST_STEPS:
            break
    return np.array(times), np.array(places)


def _spanned(log: Floats, asked: Floats) -> tuple[Floats, Floats]:
    """Both in the directions in which they extend at all: a tool that does not turn needs 3 of the 12."""
    both = np.concatenate([log, asked])
    middle = both.mean(axis=0)
    axes = np.linalg.eigh((both - middle).T @ (both - middle))[1]
    seen = (both - middle) @ axes
    seen = seen[:, np.ptp(seen, axis=0) > _FLAT]
    return seen[: len(log)], seen[len(log) :]


def _pairs(log: Floats, asked: Floats, reach: float) -> tuple[Indices, Indices]:
    """Paired steps in order: every step of both is in at least one pair."""
    rows, columns = len(log), len(asked)
    came = np.zeros((rows, columns), dtype=np.int8)  # 0 both advance, 1 the log, 2 the program
    before, last = np.full(rows, np.inf), np.full(rows, np.inf)  # cost at the two previous diagonals, by row
    for diagonal in range(rows + columns - 1):
        low, high = max(0, diagonal - columns + 1), min(rows, diagonal + 1)
        index = np.arange(low, high)
        gap = log[low:high] - asked[diagonal - index]
        cost = np.minimum(np.einsum("ij,ij->i", gap, gap), reach * reach)
        both = np.full(high - low, np.inf)
        one = np.full(high - low, np.inf)
        inside = index > 0
        both[inside] = before[index[inside] - 1]
        one[inside] = last[index[inside] - 1]
        options = np.stack([both, one, last[low:high]])
        if diagonal == 0:
            options[:] = 0.0
        choice = np.argmin(options, axis=0)
        current = np.full(rows, np.inf)
        current[low:high] = options[choice, np.arange(high - low)] + cost
        came[index, diagonal - index] = choice
        before, last = last, current
    return _backwards(came)


def _backwards(came: NDArray[np.int8]) -> tuple[Indices, Indices]:
    row, column = came.shape[0] - 1, came.shape[1] - 1
    left, right = [row], [column]
    while row or column:
        choice = came[row, column] if row and column else (1 if row else 2)
        row -= choice != 2
        column -= choice != 1
        left.append(row)
        right.append(column)
    return np.array(left[::-1], dtype=np.intp), np.array(right[::-1], dtype=np.intp)
