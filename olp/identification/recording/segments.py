"""Cuts a log into the moves of a program: by the programmed points, by a move counter, or by the stops alone.

Codes: D040 the places cannot be known, D041 the log has no move counter or no stops that fit the program.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from olp.core.diagnostic import OlpError, error
from olp.identification.recording.alignment import Alignment, align
from olp.identification.recording.boundaries import Rest, pass_by, rest, stillness
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
    """(m,): most of the move's way is within reach of the log, and the log goes about as far meanwhile."""
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
    still = _still_of_axes(log)
    stretches = _stretches_between_rests(log.time, place, still)
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


def _still_of_axes(log: Log) -> float:
    """[rad | m] below which the axes' movement is noise; a quarter of a millimetre per metre at least."""
    return max(stillness(log.time, log.q), 5e-5)


def _stretches_between_rests(time: Floats, place: Floats, still: float) -> list[tuple[float, float]]:
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
