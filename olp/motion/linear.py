"""Linear acceleration: the acceleration itself rises and falls at a limited rate (limited jerk)."""

from __future__ import annotations

from collections.abc import Callable
from typing import ClassVar, NamedTuple

import numpy as np
from numpy.typing import NDArray

from olp.motion._profile import ROUNDING, Bools, Floats, Moves, Problem, Profile
from olp.motion.model import MotionModel, Parameter, Values

RAMP_TIME = (
    0.12  # [s] what an exact stop adds to length / speed, DX200 at 10 mm/s (published MA2010 recordings)
)


class Ramp(NamedTuple):
    """A change of speed from a lower to a higher one: acceleration rises, holds and falls; all (n,)."""

    peak: Floats  # highest acceleration [m/s²]
    rise: Floats  # [s]
    hold: Floats  # [s]
    fall: Floats  # [s]
    length: Floats  # distance covered [m]


class LinearAcceleration(MotionModel):
    """Acceleration rises at k1, holds at a_max, falls at k2; braking is its mirror image in time.

    (Apostolovic's thesis, section 4.3.) A change of speed by D takes (4.23, 4.39, 4.46)
    t1 = a / k1,   t2 = D / a - a/2 (1/k1 + 1/k2),   t3 = a / k2,   with a = a_max, or where t2 would be
    negative t2 = 0 and a² = 2 D k1 k2 / (k1 + k2) (4.64); its length is s1 + s2 + s3 (4.29, 4.35, 4.45).
    From rest to rest with equal limits the peak speed is, with L3 = twice the length for t2 = 0,
    - v_max where 2 (s1 + s2 + s3) <= L (case 1, and the case without a_max that the text leaves out),
    - a²/2 (1/k1 + 1/k2) + a t with t from 4.56 where L >= L3 (case 2; it exists for every positive k1, k2),
    - a²/2 (1/k1 + 1/k2) with a from 4.66 where L < L3 (case 3).
    Otherwise the peak speed is bracketed by halving, to the last bit: length grows with it.
    """

    summary = "acceleration rises and falls linearly (limited jerk): up to seven phases"
    source = "Apostolovic's thesis, section 4.3; start and end speeds and unequal limits added"
    parameters = (
        Parameter("k1", "m/s³", None, "rate at which acceleration rises; left out: acceleration / ramp_time"),
        Parameter("k2", "m/s³", None, "rate at which acceleration falls; left out: acceleration / ramp_time"),
        Parameter(
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

    def solve(self, moves: Moves, values: Values) -> Profile:
        """Seven phases of constant jerk; see the class for the formulas."""
        k1, k2 = _rates(moves, values)
        v0 = moves.start_speed
        v1, problem = _end_speeds(moves, k1, k2)
        cruise = _cruise_speed(moves, v1, k1, k2)
        braking = cruise < v0
        first = ramp(
            np.minimum(v0, cruise),
            np.abs(cruise - v0),
            np.where(braking, moves.deceleration, moves.acceleration),
            k1,
            k2,
        )
        last = ramp(v1, np.maximum(cruise - v1, 0.0), moves.deceleration, k1, k2)
        rest = np.maximum(moves.length - first.length - last.length, 0.0)
        t4 = np.divide(rest, cruise, out=np.zeros_like(rest), where=cruise > 0)
        return Profile.build(moves, self.phases, *_phases(first, last, t4, braking, k1, k2), problem)


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


def _rates(moves: Moves, values: Values) -> tuple[Floats, Floats]:
    k1, k2, time = values["k1"], values["k2"], values["ramp_time"]
    assert time is not None
    default = moves.acceleration / time
    return (default if k1 is None else k1), (default if k2 is None else k2)


def _rest_to_rest(moves: Moves, k1: Floats, k2: Floats) -> Floats:
    """Peak speed of moves from rest to rest with equal limits when the programmed speed is out of reach."""
    a, slowness = moves.acceleration, 1 / k1 + 1 / k2
    c1, c2 = a / 2, a**2 / (2 * k1) + a**2 / k2
    c3 = a**3 / (6 * k1**2) + a**3 / (2 * k1 * k2) + a**3 / (3 * k2**2) - moves.length / 2
    holds = np.maximum(-c3, 0.0)
    # The root of 4.56 with the plus sign, written so that nothing cancels.
    t = 2 * holds / (c2 + np.sqrt(c2**2 + 4 * c1 * holds))
    peak = np.cbrt(3 * moves.length * k1**2 * k2**2 / ((2 * k1 + k2) * (k1 + k2)))
    return np.where(c3 <= 0, a**2 * slowness / 2 + a * t, peak**2 * slowness / 2)


def _cruise_speed(moves: Moves, v1: Floats, k1: Floats, k2: Floats) -> Floats:
    """Speed [m/s] between the two changes of speed, (n,)."""
    v0, a, d = moves.start_speed, moves.acceleration, moves.deceleration
    simple = (v0 == 0) & (v1 == 0) & (a == d)
    peak = np.where(simple, _rest_to_rest(moves, k1, k2), np.inf)

    def length(speed: Floats, at: Bools) -> Floats:
        start, end = v0[at], v1[at]
        limit = np.where(speed < start, d[at], a[at])
        first = ramp(np.minimum(speed, start), np.abs(speed - start), limit, k1[at], k2[at])
        return first.length + ramp(end, np.maximum(speed - end, 0.0), d[at], k1[at], k2[at]).length

    cruise = np.where(simple, np.minimum(peak, moves.speed), np.maximum(moves.speed, v1))
    short = ~simple
    short[short] = length(cruise[short], short) > moves.length[short]
    if short.any():
        # A move that starts too fast brakes towards the programmed speed as far as its length allows.
        fits = np.maximum(v0, v1)[short]
        cruise[short] = _halve(lambda v: length(v, short) <= moves.length[short], fits, cruise[short])
    return cruise


def _end_speeds(moves: Moves, k1: Floats, k2: Floats) -> tuple[Floats, NDArray[np.int8]]:
    """The end speeds [m/s] that can be had, (n,), and where they differ from those asked for, (n,)."""
    v0 = moves.start_speed
    v1 = np.minimum(moves.end_speed, moves.speed)
    problem = np.where(v1 < moves.end_speed, np.int8(Problem.CANNOT_REACH), np.int8(Problem.NONE))

    def length(v: Floats, at: Bools) -> Floats:
        limit = np.where(v < v0[at], moves.deceleration[at], moves.acceleration[at])
        return ramp(np.minimum(v, v0[at]), np.abs(v - v0[at]), limit, k1[at], k2[at]).length

    everything = np.ones(len(v0), dtype=np.bool_)
    short = length(v1, everything) > moves.length * (1 + ROUNDING)
    if short.any():
        problem[short] = np.where(v1 < v0, Problem.CANNOT_BRAKE, Problem.CANNOT_REACH)[short]
        v1[short] = _halve(lambda v: length(v, short) <= moves.length[short], v0[short], v1[short])
    return v1, problem


def _halve(fits: Callable[[Floats], Bools], good: Floats, bad: Floats) -> Floats:
    """The last value, going from `good` to `bad`, that fits, (n,)."""
    for _ in range(64):
        middle = (good + bad) / 2
        ok = fits(middle)
        good, bad = np.where(ok, middle, good), np.where(ok, bad, middle)
    return good


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
