"""Linear acceleration: the acceleration itself rises and falls at a limited rate (limited jerk)."""

from __future__ import annotations

from collections.abc import Callable
from typing import ClassVar, NamedTuple

import numpy as np
from numpy.typing import NDArray

from olp.timing.motion._profile import ROUNDING, Bools, Floats, Problem, Profile, RequestedMoves
from olp.timing.motion.model import ModelParameter, MotionModel, Values

RAMP_TIME = (
    0.12  # [s] what an exact stop adds to length / speed, DX200 at 10 mm/s (published MA2010 recordings)
)

_MOST_STEPS = 60  # of Newton; ten are usual


class Ramp(NamedTuple):
    """A change from a lower to a higher speed: acceleration rises, holds and falls; all (n,)."""

    peak: Floats  # highest acceleration [m/s²]
    rise: Floats  # [s]
    hold: Floats  # [s]
    fall: Floats  # [s]
    length: Floats  # distance covered [m]


class Changes(NamedTuple):
    """The two changes of speed of each move; all (n,). Sizes of changes are stored beside the speeds because they
    are exact.
    """

    first: Floats  # size of the first change [m/s]
    last: Floats  # size of the second one, to the end speed [m/s]
    braking: Bools  # whether the first one brakes, which a move does that starts too fast
    cruise: Floats  # speed in between [m/s]
    end: Floats  # [m/s]
    problem: NDArray[np.int8]


class LinearAcceleration(MotionModel):
    """Acceleration rises at k1, holds at a_max, falls at k2; braking is its mirror image in time.

    (Apostolovic's thesis, section 4.3.) A change of speed by D takes (4.23, 4.39, 4.46)
    t1 = a / k1,   t2 = D / a - a/2 (1/k1 + 1/k2),   t3 = a / k2,   with a = a_max, or where t2 would be
    negative t2 = 0 and a² = 2 D k1 k2 / (k1 + k2) (4.64); its length is s1 + s2 + s3 (4.29, 4.35, 4.45).
    From rest to rest with equal limits the peak speed is, with L3 = twice the length for t2 = 0,
    - v_max where 2 (s1 + s2 + s3) <= L (case 1, and the case without a_max that the text leaves out),
    - a²/2 (1/k1 + 1/k2) + a t with t from 4.56 where L >= L3 (case 2; it exists for every positive k1, k2),
    - a²/2 (1/k1 + 1/k2) with a from 4.66 where L < L3 (case 3).
    Otherwise the peak lies d above the faster end, and d comes from Newton steps on sqrt(d): the length is a convex
    function of it, so steps from above end on the root. Speeds are nowhere subtracted twice: the time of a change
    grows with the root of its size, which would turn a rounding of 1e-16 into 1e-8 s.
    """

    summary = "acceleration rises and falls linearly (limited jerk): up to seven phases"
    source = "Apostolovic's thesis, section 4.3; start and end speeds and unequal limits added"
    parameters = (
        ModelParameter(
            "k1", "m/s³", None, "rate at which acceleration rises; left out: acceleration / ramp_time"
        ),
        ModelParameter(
            "k2", "m/s³", None, "rate at which acceleration falls; left out: acceleration / ramp_time"
        ),
        ModelParameter(
            "ramp_time",
            "s",
            RAMP_TIME,
            "time in which the acceleration is built up; 0.12 s is what an exact stop adds to length / speed "
            "on a DX200 at 10 mm/s (published MA2010 recordings), a guess for any other controller",
        ),
    )

    phases: ClassVar[tuple[str, ...]] = (
        "acceleration rises",
        "acceleration holds",
        "acceleration falls",
        "cruise",
        "deceleration rises",
        "deceleration holds",
        "deceleration falls",
    )

    def solve(self, moves: RequestedMoves, values: Values) -> Profile:
        """Seven phases of constant jerk; see the class for the formulas."""
        k1, k2 = _rates(moves, values)
        changes = _changes(moves, k1, k2)
        first, last = _ramps(moves, changes, k1, k2)
        rest = np.maximum(moves.length - first.length - last.length, 0.0)
        t4 = np.divide(rest, changes.cruise, out=np.zeros_like(rest), where=changes.cruise > 0)
        phases = _phases(first, last, t4, changes.braking, k1, k2)
        return Profile.build(moves, self.phases, *phases, changes.problem)


def ramp(lower: Floats, rise: Floats, limit: Floats, k1: Floats, k2: Floats) -> Ramp:
    """The change from speed `lower` to `lower + rise` [m/s] with acceleration <= limit and rates k1, k2."""
    slowness = 1 / k1 + 1 / k2
    peak = np.minimum(limit, np.sqrt(2 * rise / slowness))
    t1, t3 = peak / k1, peak / k2
    t2 = np.maximum(rise / limit - limit * slowness / 2, 0.0)
    v1 = peak * t1 / 2
    v2 = v1 + peak * t2
    gained = peak * t1**2 / 6 + t2 * (v1 + v2) / 2 + t3 * (v2 + peak * t3 / 3)
    return Ramp(peak, t1, t2, t3, gained + lower * (t1 + t2 + t3))


def _rates(moves: RequestedMoves, values: Values) -> tuple[Floats, Floats]:
    k1, k2, time = values["k1"], values["k2"], values["ramp_time"]
    assert time is not None
    default = moves.acceleration / time
    return (default if k1 is None else k1), (default if k2 is None else k2)


def _ramps(moves: RequestedMoves, changes: Changes, k1: Floats, k2: Floats) -> tuple[Ramp, Ramp]:
    v0, a, d = moves.start_speed, moves.acceleration, moves.deceleration
    limit = np.where(changes.braking, d, a)
    first = ramp(np.where(changes.braking, changes.cruise, v0), changes.first, limit, k1, k2)
    return first, ramp(changes.end, changes.last, d, k1, k2)


def _changes(moves: RequestedMoves, k1: Floats, k2: Floats) -> Changes:
    """Speeds between and at the ends of each move, nearest to the requested ones."""
    v0, v1 = moves.start_speed, np.minimum(moves.end_speed, moves.speed)
    problem = np.where(v1 < moves.end_speed, np.int8(Problem.CANNOT_REACH), np.int8(Problem.NONE))
    falls = v1 < v0
    v1, gap, short = _end_speeds(moves, v1, falls, k1, k2)
    problem[short] = np.where(falls, Problem.CANNOT_BRAKE, Problem.CANNOT_REACH)[short]
    faster = np.maximum(v0, v1)
    room = np.maximum(moves.speed - faster, 0.0)  # how much faster the programmed speed is than both ends
    room[short] = 0.0
    result = Changes(
        np.where(falls, 0.0, gap), np.where(falls, gap, 0.0), v0 > moves.speed, faster, v1, problem
    )
    rise = _rise(moves, result, room, k1, k2)
    changes = result._replace(
        first=result.first + rise,
        last=result.last + rise,
        braking=np.zeros(len(v0), dtype=np.bool_),
        cruise=np.where(rise == room, np.maximum(moves.speed, faster), faster + rise),
    )
    changes.cruise[short] = faster[short]
    early = result.braking & ~short
    return _brake_first(moves, changes, early, k1, k2) if early.any() else changes


def _end_speeds(
    moves: RequestedMoves, v1: Floats, falls: Bools, k1: Floats, k2: Floats
) -> tuple[Floats, Floats, Bools]:
    """End speeds that are possible and their distances from the start speeds [m/s], and where a move is too short."""
    v0, gap = moves.start_speed, np.abs(v1 - moves.start_speed)
    limit = np.where(falls, moves.deceleration, moves.acceleration)

    def length(size: Floats, at: Bools) -> Floats:
        lower = np.where(falls[at], np.maximum(v0[at] - size, 0.0), v0[at])
        return ramp(lower, size, limit[at], k1[at], k2[at]).length

    direct = ramp(np.minimum(v0, v1), gap, limit, k1, k2).length
    short: Bools = direct > moves.length * (1 + ROUNDING)
    if short.any():
        gap[short] = _halve(lambda size: length(size, short) <= moves.length[short], gap[short])
        v1 = np.where(short, np.where(falls, v0 - gap, v0 + gap), v1)
    return v1, gap, short


def _rise(moves: RequestedMoves, ends: Changes, room: Floats, k1: Floats, k2: Floats) -> Floats:
    """How far the peak speed of each move lies above its faster end [m/s], (n,), at most `room`."""
    v0, v1, a, d = moves.start_speed, ends.end, moves.acceleration, moves.deceleration
    rise = np.where(moves.length > 0, room, 0.0)
    simple = (v0 == 0) & (v1 == 0) & (a == d)
    if simple.any():
        peak = _rest_to_rest(*(x[simple] for x in (moves.length, a, k1, k2)))
        rise[simple] = np.minimum(peak, room[simple])
    open_ = ~simple & (rise > 0)
    if open_.any():
        up, down = _ramps(
            moves, ends._replace(first=ends.first + room, last=ends.last + room, braking=~open_), k1, k2
        )
        open_ &= up.length + down.length > moves.length
    if open_.any():
        rows = np.flatnonzero(open_)
        columns = (v0, ends.first, a, v1, ends.last, d, k1, k2, moves.length, room)
        rise[rows] = _newton(*(column[rows] for column in columns))
    return rise


def _newton(
    v0: Floats, first: Floats, a: Floats, v1: Floats, last: Floats, d: Floats,
    k1: Floats, k2: Floats, length: Floats, room: Floats,
) -> Floats:  # fmt: skip
    """The rise [m/s], below `room`, with which the changes `first` + rise and `last` + rise together cover `length`."""
    slowness = 1 / k1 + 1 / k2
    limit = np.minimum(a, d)
    # Each of these alone would already cover the length: no change covers less than a third of its time at its top.
    known = [room, np.cbrt(9 * length**2 / (2 * slowness)), np.sqrt(3 * np.maximum(a, d) * length)]
    with np.errstate(divide="ignore", over="ignore", invalid="ignore"):
        time = length / (v0 + v1)
        slow = np.where(time > limit * slowness, np.inf, time**2 / (2 * slowness))
    root = np.sqrt(np.minimum(np.minimum.reduce(known), slow))
    for _ in range(_MOST_STEPS):
        rise = root * root
        up, down = ramp(v0, first + rise, a, k1, k2), ramp(v1, last + rise, d, k1, k2)
        slope = _slope(v0, up) + _slope(v1, down)
        step = (up.length + down.length - length) / (2 * root * slope)
        root = np.where(step > 0, root - step, root)
        if not (step > 2e-16 * root).any():
            break
    size: Floats = np.minimum(root * root, room)
    return size


def _slope(lower: Floats, change: Ramp) -> Floats:
    """Length [m] that a change of speed gains per size of the change [m/s]."""
    slope: Floats = lower / change.peak + change.rise / 2 + change.hold + change.fall
    return slope


def _brake_first(moves: RequestedMoves, changes: Changes, early: Bools, k1: Floats, k2: Floats) -> Changes:
    """Moves that start faster than the programmed speed brake to it first, or towards it as far as the length
    allows.
    """
    v0, rates = moves.start_speed[early], (k1[early], k2[early])
    whole, d = changes.last[early], moves.deceleration[early]

    def last(size: Floats) -> Floats:
        return np.where(size == most, moves.speed[early] - changes.end[early], np.maximum(whole - size, 0.0))

    def fits(size: Floats) -> Bools:
        first = ramp(v0 - size, size, d, *rates).length
        rest = ramp(changes.end[early], last(size), d, *rates).length
        return first + rest <= moves.length[early]

    most = v0 - moves.speed[early]
    size = np.where(fits(most), most, _halve(fits, most))
    for column, values in (
        (changes.first, size),
        (changes.last, last(size)),
        (changes.cruise, np.where(size == most, moves.speed[early], v0 - size)),
    ):
        column[early] = values
    changes.braking[early] = True
    return changes


def _rest_to_rest(length: Floats, a: Floats, k1: Floats, k2: Floats) -> Floats:
    """Peak speed of moves from rest to rest with equal limits when the programmed speed is out of reach."""
    slowness = 1 / k1 + 1 / k2
    c1, c2 = a / 2, a**2 / (2 * k1) + a**2 / k2
    c3 = a**3 / (6 * k1**2) + a**3 / (2 * k1 * k2) + a**3 / (3 * k2**2) - length / 2
    holds = np.maximum(-c3, 0.0)
    # The root of 4.56 with the plus sign, written so that nothing cancels.
    t = 2 * holds / (c2 + np.sqrt(c2**2 + 4 * c1 * holds))
    peak = np.cbrt(3 * length * k1**2 * k2**2 / ((2 * k1 + k2) * (k1 + k2)))
    return np.where(c3 <= 0, a**2 * slowness / 2 + a * t, peak**2 * slowness / 2)


def _halve(fits: Callable[[Floats], Bools], most: Floats) -> Floats:
    """The largest size in 0..most that fits, (n,), exact to the last bit.

    Bisects over the bit patterns of the numbers, so that tiny answers are as exact as large ones.
    """
    good, bad = np.zeros(len(most), dtype=np.int64), most.view(np.int64).copy()
    for _ in range(64):
        middle = good + (bad - good) // 2
        ok = fits(middle.view(np.float64))
        good, bad = np.where(ok, middle, good), np.where(ok, bad, middle)
    return good.view(np.float64)


def _phases(
    first: Ramp, last: Ramp, t4: Floats, braking: Bools, k1: Floats, k2: Floats
) -> tuple[Floats, Floats, Floats]:
    """Durations, start accelerations and jerks of the seven phases, (n, 7) each."""
    zero = np.zeros_like(t4)
    # Braking is acceleration seen backwards in time (4.49): it sets in at k2 and lets go at k1.
    t1 = np.where(braking, first.fall, first.rise)
    t3 = np.where(braking, first.rise, first.fall)
    sign = np.where(braking, -1.0, 1.0)
    onset, release = np.where(braking, k2, k1), np.where(braking, k1, k2)
    durations = [t1, first.hold, t3, t4, last.fall, last.hold, last.rise]
    accelerations = [zero, sign * first.peak, sign * first.peak, zero, zero, -last.peak, -last.peak]
    jerks = [sign * onset, zero, -sign * release, zero, -k2, zero, k1]
    return np.stack(durations, 1), np.stack(accelerations, 1), np.stack(jerks, 1)
