"""Cuts a log into the moves of a program: by the programmed points, by a move counter, or by the stops alone.

Codes: D040 the places cannot be known, D041 the log has no move counter or no stops that fit the program.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from olp.core.diagnostic import OlpError, error
from olp.identification.recording.fit import interpolate
from olp.identification.recording.log import Log
from olp.identification.recording.programmed import Moved, ProgrammedPath, features_of_log

Floats = NDArray[np.float64]
_OFF = 1e-3  # [m]
_SHARE = 0.6  # of a move's steps that must be within reach
_LEAST_PACE = 0.02  # of the 90 % quantile of all paces: slower is standing


@dataclass(frozen=True, slots=True)
class Segments:
    """Per move of the program, on the log's clock [s]; nan where the log does not show it.

    `begin`, `end` (m,); `until` (m,): when the arm leaves after the wait that follows, nan where none does. `seen`
    (m,): the log goes the move's way. `nearest` (m,) [m] to the move's end. `unexplained`: stretches that are no move.
    """

    begin: Floats
    end: Floats
    until: Floats
    seen: NDArray[np.bool_]
    nearest: Floats
    unexplained: tuple[tuple[float, float], ...] = ()
    offset: Floats | None = None  # (3,) [m] the log stands off the program, the median


def by_points(moves: Moved, way: ProgrammedPath, log: Log) -> Segments:
    """Matching the programmed points: a stop ends when the arm leaves it, a corner where the way is nearest to it."""
    place = features_of_log(moves.timing.plan.robot, log)
    still = stillness(log.time, place)
    found = align(log.time, place, way.time, way.way)
    rests, off = _rests(moves, way, log, place, found, still)
    if float(np.linalg.norm(off.mean(axis=0)[:3])) > _OFF:
        # Along a line an offset cannot be seen on the way, only where the arm stands: pair once more without it.
        place = place - off.mean(axis=0)
        found = align(log.time, place, way.time, way.way)
        shifted = off.mean(axis=0)
        rests, off = _rests(moves, way, log, place, found, still)
    else:
        shifted = np.zeros(place.shape[1])
    nearest = np.full(len(moves) + 1, np.nan)
    shift = _corner_shift(moves, way)
    for i, (low, high) in enumerate(_windows(moves, found, log, place, way.point + off)):
        # A corner may be passed between two samples.
        part = slice(max(low - 1, 0), high + 1)
        at, nearest[i] = pass_by(log.time[part], place[part], way.point[i] + off[i])
        if rests[i] is None:
            rests[i] = Rest(at + shift[i], at + shift[i], place[0])
    return _cut(moves, [r for r in rests if r is not None], found, nearest, (off.mean(axis=0) + shifted)[:3])


def _rests(
    moves: Moved, way: ProgrammedPath, log: Log, place: Floats, found: Alignment, still: float
) -> tuple[list[Rest | None], Floats]:
    """The rest at each of the m + 1 points, None where the arm passes, and how far (m + 1, c) [m] the log is off there.

    The offset is measured where the arm rests; in between it is taken in proportion.
    """
    rests: list[Rest | None] = [None] * (len(moves) + 1)
    stops = np.concatenate([[True], moves.stops])
    for i, (low, high) in enumerate(_windows(moves, found, log, place, way.point + found.offset)):
        if stops[i]:
            dwells = i > 0 and bool(moves.waits[i - 1])
            near = way.point[i] + found.offset
            rests[i] = rest(log.time[low:high], place[low:high], near, still, dwells)
    stood = [(i, r.place - way.point[i]) for i, r in enumerate(rests) if r is not None]
    stood = [(i, off) for i, off in stood if np.linalg.norm(off) < found.reach]
    if not stood:
        return rests, np.broadcast_to(found.offset, way.point.shape).copy()
    at, off = np.array([i for i, _ in stood]), np.stack([off for _, off in stood])
    return rests, interpolate(at.astype(np.float64), off, np.arange(len(rests), dtype=np.float64))


def _cut(moves: Moved, rests: list[Rest], found: Alignment, nearest: Floats, off: Floats) -> Segments:
    arrive, leave = np.array([r.arrive for r in rests]), np.array([r.leave for r in rests])
    begin, end = leave[:-1], leave[1:].copy()
    end[moves.waits] = np.fmax(arrive[1:], leave[1:] - moves.programmed_wait)[moves.waits]
    end[-1] = end[-1] if moves.waits[-1] else arrive[-1]
    until = np.where(moves.waits & (end <= leave[1:]), leave[1:], np.nan)
    seen = _seen(moves, found) & (end >= begin)
    unknown = np.where(seen, 0.0, np.nan)
    return Segments(
        begin + unknown, end + unknown, until + unknown, seen, nearest[1:], _stretches(found), off
    )


def _seen(moves: Moved, found: Alignment) -> NDArray[np.bool_]:
    """(m,): whether the log follows most of the move's path, and travels about the same distance meanwhile."""
    first = np.searchsorted(found.steps, moves.begin)
    last = np.minimum(np.searchsorted(found.steps, moves.end), len(found.steps) - 1)
    near = np.concatenate([[0], np.cumsum(found.distance < found.reach)])
    count = last - first + 1
    share = (near[last + 1] - near[np.minimum(first, last)]) / np.maximum(count, 1)
    gone = found.travelled[last] - found.travelled[np.minimum(first, last)]
    far_enough = gone >= 0.5 * (count - 1) * found.size - found.size
    return np.asarray((share >= _SHARE) & far_enough, dtype=bool)


def _windows(moves: Moved, found: Alignment, log: Log, place: Floats, point: Floats) -> list[tuple[int, int]]:
    """Samples low to high - 1 between the middles of the moves on both sides of each of the m + 1 points."""
    keys = np.arange(len(found.steps), dtype=np.float64)
    middle = (np.interp(moves.begin, found.steps, keys) + np.interp(moves.end, found.steps, keys)) / 2
    at = np.interp(middle, keys, found.where)
    low = np.concatenate([[-np.inf], at])
    high = np.concatenate([at, [np.inf]])
    first = np.searchsorted(log.time, low, side="left")
    last = np.searchsorted(log.time, high, side="right")
    # Before the first and after the last move the arm may come by once more.
    away = np.linalg.norm(place - point[0], axis=1)
    before = np.nonzero(away[: np.searchsorted(log.time, found.where)[0]] > 2 * found.reach)[0]
    first[0] = before[-1] + 1 if len(before) else 0
    begin = int(np.searchsorted(log.time, found.where)[-1])
    after = np.nonzero(np.linalg.norm(place[begin:] - point[-1], axis=1) > 2 * found.reach)[0]
    last[-1] = begin + after[0] if len(after) else len(log)
    return list(zip(first.tolist(), last.tolist(), strict=True))


def _corner_shift(moves: Moved, way: ProgrammedPath) -> Floats:
    """(m + 1,) [s]: in the plan, from where the way is nearest to a corner to where the move ends.

    It is 0 when the corner is passed evenly, and what a change of speed in the corner makes otherwise.
    """
    shift = np.zeros(len(moves) + 1)
    for i in np.nonzero(~moves.stops[:-1])[0].tolist():
        low = np.searchsorted(way.time, (moves.begin[i] + moves.end[i]) / 2)
        high = np.searchsorted(way.time, (moves.begin[i + 1] + moves.end[i + 1]) / 2)
        if high - low > 2:
            shift[i + 1] = moves.end[i] - pass_by(way.time[low:high], way.way[low:high], way.point[i + 1])[0]
    return shift


def _stretches(found: Alignment) -> tuple[tuple[float, float], ...]:
    """[s] from, to: where the log moves out of the program's reach, for longer than the reach itself.

    Shorter ones are the chords that a coarse log cuts off a curve.
    """
    inside = np.concatenate([[True], found.explained, [True]]).astype(np.int64)
    change = inside[1:] - inside[:-1]
    begins, ends = np.nonzero(change < 0)[0], np.nonzero(change > 0)[0]
    last = len(found.time) - 1
    return tuple(
        (float(found.time[max(b - 1, 0)]), float(found.time[min(e, last)]))
        for b, e in zip(begins.tolist(), ends.tolist(), strict=True)
        if (e - b) * found.size > found.reach
    )


def by_counter(moves: Moved, log: Log) -> Segments:
    """By the column `move`: half-way between the samples where it changes. Raises OlpError (D041)."""
    if log.move is None or not (log.move >= 0).any():
        raise OlpError(error("D041", "the log has no column move that counts", file=log.file))
    change = np.nonzero(np.diff(log.move))[0]
    first = np.concatenate([[0], change + 1])
    counts = log.move[first]
    begins = np.concatenate([log.time[:1], (log.time[change] + log.time[change + 1]) / 2])
    ends = np.append(begins[1:], log.time[-1])
    use = counts >= 0
    index = _move_of(moves, counts[use], log)
    begin, end, until = np.full(len(moves), np.nan), np.full(len(moves), np.nan), np.full(len(moves), np.nan)
    begin[index], end[index] = begins[use], ends[use]
    follows = np.append(begin[1:], np.nan)
    until = np.where(moves.waits, follows, np.nan)
    seen = ~np.isnan(begin)
    return Segments(begin, end, until, seen, np.full(len(moves), np.nan))


def _move_of(moves: Moved, counts: NDArray[np.int64], log: Log) -> NDArray[np.intp]:
    """Which move each run of the counter is: numbers from 1 (or 0) on, lines of the program, or one after the other."""
    plan = moves.timing.plan
    lines = plan.line[moves.step]
    once = len(set(counts.tolist())) == len(counts)
    if once and counts.min() >= 1 and counts.max() <= len(moves):
        return (counts - 1).astype(np.intp)
    if once and counts.min() == 0 and counts.max() < len(moves):
        return counts.astype(np.intp)
    if len(counts) == len(moves) and (np.array_equal(counts, lines) or not once or counts.max() > len(moves)):
        return np.arange(len(moves))
    says = f"the log counts {len(counts)} moves from {counts.min()} to {counts.max()}, the program runs {len(moves)}"
    raise OlpError(
        error("D041", says, file=log.file, help="cut the log to one run of the program, or say --by points")
    )


def by_dwell(moves: Moved, log: Log) -> Segments:
    """By the stops alone: each stretch between two rests is what runs between two stops of the program.

    Needs no robot and no points. A stretch of several moves without a stop stays whole: those moves are not seen.
    Raises OlpError (D041) when the program stops more or less often than the log.
    """
    place = log.q
    still = still_of_axes(log)
    stretches = stretches_between_rests(log.time, place, still)
    groups = np.split(np.arange(len(moves)), np.nonzero(moves.stops)[0][:-1] + 1)
    if len(stretches) != len(groups):
        says = f"the log moves {len(stretches)} times between rests, the program {len(groups)} times between stops"
        help = "stops too short to be seen in the log? say --by points, with the robot"
        raise OlpError(error("D041", says, file=log.file, help=help))
    begin, end, until = np.full(len(moves), np.nan), np.full(len(moves), np.nan), np.full(len(moves), np.nan)
    for number, (group, (start, stop)) in enumerate(zip(groups, stretches, strict=True)):
        if len(group) > 1:
            continue
        move, last = int(group[0]), number == len(groups) - 1
        leaves = stop if last else stretches[number + 1][0]
        begin[move], end[move] = start, stop if moves.waits[move] or last else leaves
        if moves.waits[move]:
            until[move] = leaves
            end[move] = max(end[move], leaves - moves.programmed_wait[move])
    seen = ~np.isnan(begin)
    return Segments(begin, end, until, seen, np.full(len(moves), np.nan))


def still_of_axes(log: Log) -> float:
    """[rad | m] below which the axes' movement is noise; a quarter of a millimetre per metre at least."""
    return max(stillness(log.time, log.q), 5e-5)


def stretches_between_rests(time: Floats, place: Floats, still: float) -> list[tuple[float, float]]:
    """[s] begin and end of every motion: the pace is above a fiftieth of what is usual, by more than the noise."""
    if len(time) < 3:
        return []
    step = np.linalg.norm(place[2:] - place[:-2], axis=1)
    pace = step / np.maximum(time[2:] - time[:-2], 1e-9)
    usual = float(np.quantile(pace, 0.9))
    moving = np.concatenate([[False], (pace > _LEAST_PACE * usual) & (step > still), [False]])
    change = moving[1:].astype(np.int64) - moving[:-1].astype(np.int64)
    begins, ends = np.nonzero(change > 0)[0], np.nonzero(change < 0)[0]
    return [
        (float(time[b]), float(time[min(e + 1, len(time) - 1)]))
        for b, e in zip(begins.tolist(), ends.tolist(), strict=True)
        if float(np.linalg.norm(place[min(e + 1, len(place) - 1)] - place[b])) > still or e - b > 2
    ]


# --- Alignment ---
# Which part of a log is which part of a program: dynamic time warping along the way, whatever the time it took.
#
# Both ways are cut into steps of equal length, so dwells and speeds play no part, and paired in order at least squared
# distance (H. Sakoe, S. Chiba, "Dynamic programming algorithm optimization for spoken word recognition", IEEE Trans.
# ASSP 26(1), 1978). A distance counts no more than `REACH`: what lies farther away is not explained by the program, and
# a stretch that only one of the two has cannot pull the rest apart.

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
    """Both, reduced to the dimensions in which they extend: a tool that does not turn needs 3 of the 12."""
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


# --- Boundaries ---
# When a move ends, to a fraction of a sample: where the arm comes to rest and leaves again, or passes nearest by.

_LEAST_STILL = 5e-5  # [m] movements below this are rest
_NOISES = 6.0
_NEAR = 0.010  # [m] a rest farther from its point than this (and 3 times the nearest) is another one


class Rest(NamedTuple):
    """[s] when the arm came to rest and when it left; nan where the log does not show it. `place` (c,) [m]."""

    arrive: float
    leave: float
    place: Floats


def stillness(time: Floats, place: Floats) -> float:
    """[m] below which a movement is noise: six times the scatter while the arm hardly moves, at least 0.05 mm.

    From second differences, which a steady motion does not feel: var = 6 σ².
    """
    if len(time) < 5:
        return _LEAST_STILL
    bend = np.linalg.norm(place[2:] - 2 * place[1:-1] + place[:-2], axis=1)
    speed = np.linalg.norm(place[2:] - place[:-2], axis=1)
    slow = bend[speed <= np.quantile(speed, 0.2)]
    noise = float(np.median(slow)) / math.sqrt(6.0)
    return max(_LEAST_STILL, _NOISES * noise)


def rest(time: Floats, place: Floats, point: Floats, still: float, dwells: bool = False) -> Rest | None:
    """The rest near `point` (c,) in samples (n,), (n, c); None when the arm does not stop there.

    `still` [m]: see `stillness`. `dwells`: the program waits there, so it is no turning point however short.
    """
    if len(time) < 3:
        return None
    distance = np.linalg.norm(place - point, axis=1)
    near = np.nonzero(distance <= max(3 * distance.min(), _NEAR))[0]
    pace = np.full(len(time), np.inf)
    inner = near[(near > 0) & (near < len(time) - 1)]
    span = np.maximum(time[inner + 1] - time[inner - 1], 1e-9)
    pace[inner] = np.linalg.norm(place[inner + 1] - place[inner - 1], axis=1) / span
    for end, beside in ((0, 1), (len(time) - 1, len(time) - 2)):
        if end in near:
            pace[end] = np.linalg.norm(place[end] - place[beside]) / max(abs(time[end] - time[beside]), 1e-9)
    if not np.isfinite(pace).any():
        return None
    slowest = int(np.argmin(pace))
    away = np.linalg.norm(place - place[slowest], axis=1)
    first, last = _run(away <= still, slowest)
    centre = np.median(place[first : last + 1], axis=0)
    away = np.linalg.norm(place - centre, axis=1)
    if away[slowest] <= still:
        first, last = _run(away <= still, slowest)
    after, before = (time[last:], away[last:]), (-time[: first + 1][::-1], away[: first + 1][::-1])
    turned = None if dwells else _turning_point(after, before, still)
    if turned is not None:
        return Rest(turned, turned, centre)
    return Rest(-_begin(*before, still), _begin(*after, still), centre)


def _turning_point(after: tuple[Floats, Floats], before: tuple[Floats, Floats], still: float) -> float | None:
    """[s] the instant of a stop too short to tell its two ends apart, None for a real rest.

    A motion that goes as t^p from its turning point passes s, 4 s and 16 s at times that grow by r = 4^(1/p) each. So
    it is within s for 2/(r - 1) times as long as it takes from s to 4 s, and √r times that where the samples within
    reach all lie on one side.
    """
    levels = (still, 4 * still, 16 * still)
    left, within = [], 0.0
    for time, away in (after, before):
        beyond = [np.nonzero(away >= reach)[0] for reach in levels]
        if not len(beyond[0]) or not len(beyond[1]) or not beyond[0][0]:
            return None
        passed = [_crossing(time, away, int(i[0]), r) for i, r in zip(beyond, levels, strict=True) if len(i)]
        quick = passed[1] - passed[0]
        growth = (passed[2] - passed[1]) / max(quick, 1e-12) if len(passed) > 2 else 2.0
        growth = min(max(growth, 1.5), 4.0)
        within = max(within, 2 * growth**0.5 / (growth - 1) * quick)
        left.append(passed[0])
    leave, came = left
    shortest = 1.1 * within + float(after[0][1] - after[0][0])
    return (leave - came) / 2 if leave + came < shortest else None


def _crossing(time: Floats, away: Floats, index: int, level: float) -> float:
    """[s] at which `away` passes `level` between sample `index` - 1 and `index`."""
    share = (level - away[index - 1]) / max(away[index] - away[index - 1], 1e-15)
    return float(time[index - 1] + np.clip(share, 0.0, 1.0) * (time[index] - time[index - 1]))


def _run(inside: NDArray[np.bool_], at: int) -> tuple[int, int]:
    """First and last index of the unbroken run of True around `at`."""
    outside = np.nonzero(~inside)[0]
    cut = int(np.searchsorted(outside, at))
    first = int(outside[cut - 1]) + 1 if cut else 0
    last = int(outside[cut]) - 1 if cut < len(outside) else len(inside) - 1
    return first, last


def _begin(time: Floats, away: Floats, still: float) -> float:
    """[s] when a motion began whose first sample here is still at rest; nan when nothing moves.

    The samples from s to 16 s beyond the rest, at least three, are carried back to zero as a motion at constant speed
    or, when that fits them better, at constant acceleration.
    """
    beyond = np.nonzero(away > still)[0]
    if not len(beyond):
        return float("nan")
    first = int(beyond[0])
    far = np.nonzero(away > 16 * still)[0]
    last = min(max(int(far[0]) if len(far) else len(away), first + 3), len(away))
    falls = np.nonzero(np.diff(away[first:last]) <= 0)[0]
    if len(falls) and last - first <= 3:
        last = first + 1 + int(falls[0])
    crossing = _crossing(time, away, first, still)
    if last - first < 2:
        return crossing
    t, x = time[first:last] - time[first], away[first:last]
    if t[-1] <= 0:  # a clock that stands still
        return crossing
    fits = []
    for shape in (x, np.sqrt(x)):
        slope, height = np.polyfit(t, shape, 1)
        if slope > 0:
            misfit = float(np.abs(slope * t + height - shape).max() / shape[-1])
            fits.append((misfit, float(time[first] - height / slope)))
    if not fits:
        return crossing
    # Two samples fit both: a motion that doubles its speed within them is still accelerating.
    chosen = min(fits)[1] if last - first > 2 else fits[-1 if x[1] > 2.5 * x[0] else 0][1]
    # The slowest begin taken for real, at constant jerk, is within s for 1.7 times as long as from s to 4 s.
    double = np.nonzero(away > 4 * still)[0]
    reach = 2 * (_crossing(time, away, int(double[0]), 4 * still) - crossing) if len(double) else 0.0
    return float(np.clip(chosen, min(float(time[first - 1]), crossing - reach), crossing))


def pass_by(time: Floats, place: Floats, point: Floats) -> tuple[float, float]:
    """When the way is nearest to `point`, on the straight pieces between samples [s], and how near [m]."""
    near = place - point
    if len(time) == 1:
        return float(time[0]), float(np.linalg.norm(near[0]))
    step = np.diff(near, axis=0)
    square = np.maximum(np.einsum("ij,ij->i", step, step), 1e-18)
    share = np.clip(-np.einsum("ij,ij->i", near[:-1], step) / square, 0.0, 1.0)
    distance = np.linalg.norm(near[:-1] + share[:, None] * step, axis=1)
    best = int(np.argmin(distance))
    return float(time[best] + share[best] * (time[best + 1] - time[best])), float(distance[best])
