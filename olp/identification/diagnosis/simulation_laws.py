"""The laws of motion of the judged simulation, read off its durations: corners, accelerations, ramps, what tuned it.

Simulated durations have no scatter: a law that is right fits them to their digits.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from functools import partial
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from olp.timing.physics._case import CornerPartners
from olp.timing.physics._motion import ARCS, AVERAGE, EACH, Motion

Floats = NDArray[np.float64]
Mask = NDArray[np.bool_]

# --- Corner laws ---
# How the judged simulation passes rounded corners: the law, and its numbers, that come nearest to its durations.
#
# Simulated durations have no scatter, so one law that is right fits all moves to the digits; where none does,
# the nearest one only says how corners answer to other ramps.

SOME_ROUNDING = 1e-6  # [m] where a rounding is told, but not its size
_SIZED = ("braking", "share", "distance", "flight")  # laws that need the size of a rounding
_SPLITS = (1.0, 0.5, 0.0)  # of what a corner saves, to the move before it
_REACHES = (0.5, 0.45, 1 / 3, 0.25, 1.0)  # of the shorter move
_REACHES_BETWEEN = (0.2, 0.3, 0.35, 0.4, 0.6, 0.7, 0.8, 0.9)
_OVERLAPS = (0.05, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0, 1.25, 1.5, 2.0)
_WORTH_A_WALK = (
    4.0  # times what the best of the grid is off: a law between two overlaps of it may be so far off there
)
_WALKED = 4  # steps of one length: a law that is none may come nearer for ever
_DIGITS = 2e-4  # [s] nearer than that, or than half a last digit, a simulation stops at every corner
_BETTER = 0.9  # times what exact stops are off: less is no law of corners
_RAMPS = (0.1, 50.0)  # [m/s²] accelerations of lines, from the slowest to the quickest robot
_RAMP_GRID, _RAMP_STEPS = 24, 14  # accelerations that are tried, and halvings' worth about the best
_LAWS_REFINED = 4  # laws of corners that come nearest
_LAWS_BESIDE = 2  # of them, with each kind of times beside the ramps
_LOOKED_AT = 60  # moves by which they are compared
GOLDEN = (0.382, 0.618)  # [1] of an interval: the first two places of a golden section
_BISECTIONS = 40  # of the logarithm of an acceleration


def cornered(motion: Motion, sim: Floats, told: Mask) -> Motion:
    """`motion` with law, overlap, split and reach from the simulated durations `sim` (n,) [s] of the moves `told` (n,),
    whose ramps are known."""
    rounded = told & ((motion.round_start > 0) | (motion.round_end > 0))
    digits = max(_DIGITS, 0.5 * last_digit(sim[rounded])) if rounded.any() else _DIGITS
    if not rounded.any() or _off(motion, sim, rounded) < digits:
        return motion.with_(law="stop")
    best, least = motion.with_(law="stop"), _BETTER * _off(motion.with_(law="stop"), sim, rounded)
    families = _families(motion)
    coarse = [float(_offs(law, _OVERLAPS, sim, rounded).min()) for law in families]
    for tried, about in zip(families, coarse, strict=True):
        if about <= _WORTH_A_WALK * min(coarse):
            overlap, off = _nearest(tried, sim, rounded)
            if off < least:
                best, least = tried.with_(overlap=overlap), off
    return best if best.law == "stop" or least < digits else _at_its_reach(best, sim, rounded, least)


def averaged_at_corners(motion: Motion, sim: Floats, told: Mask) -> Motion:
    """`motion` of a controller that averages speeds, with overlap and reach from the simulated durations `sim` (n,) [s]
    of the moves `told` (n,)."""
    motion = motion.with_(law=AVERAGE, overlap=1.0)
    rounded = told & ((motion.round_start > 0) | (motion.round_end > 0))
    if not rounded.any():
        return motion
    laws = [motion.with_(reach=reach) for reach in _REACHES]
    best = min(laws, key=lambda law: _off(law, sim, rounded))
    overlap, _ = _nearest(best, sim, rounded)
    return best.with_(overlap=overlap)


def nearer_at_corners(one: Motion, other: Motion, sim: Floats, told: Mask) -> Motion:
    """Of two motions the one that is nearer to the simulated durations `sim` (n,) [s] at the rounded corners of the
    moves `told` (n,), the first where none is."""
    rounded = told & ((one.round_start > 0) | (one.round_end > 0))
    return other if rounded.any() and _off(other, sim, rounded) < _off(one, sim, rounded) else one


def _at_its_reach(motion: Motion, sim: Floats, rounded: Mask, least: float) -> Motion:
    """The law with the reach, between those that are tried first, that comes nearest; `least` [s]: what it is off."""
    best = motion
    for reach in _REACHES_BETWEEN:
        tried = motion.with_(reach=reach)
        if _off(tried, sim, rounded) < least:
            overlap, off = _nearest(tried, sim, rounded)
            best, least = (tried.with_(overlap=overlap), off) if off < least else (best, least)
    return best


def as_long_as(motion: Motion, sim: Floats) -> Floats:
    """(n,) [m/s²] with which each of the moves takes the simulated time `sim` (n,) [s], where corners save what the law
    of `motion` says; that of `motion` where none does."""
    low, high = np.full(len(sim), math.log(_RAMPS[0])), np.full(len(sim), math.log(_RAMPS[1]))
    for _ in range(_BISECTIONS):
        middle = 0.5 * (low + high)
        slow = np.exp(middle)
        longer = motion.with_(accelerate=slow, decelerate=slow).duration() > sim
        low, high = np.where(longer, middle, low), np.where(longer, high, middle)
    inside = (low > math.log(_RAMPS[0])) & (high < math.log(_RAMPS[1]))
    return np.where(inside, np.exp(0.5 * (low + high)), motion.accelerate)


def _families(motion: Motion) -> list[Motion]:
    sized = bool(motion.round_end.max() > SOME_ROUNDING)
    shared = [("full", 0.5), *((law, reach) for law in _SIZED for reach in _REACHES if sized)]
    own = [
        ("full", 0.5),
        *((law, reach) for law in ("braking", "distance", "radius") for reach in _REACHES if sized),
    ]
    return [
        *(motion.with_(law=law, split=split, reach=reach) for law, reach in shared for split in _SPLITS),
        *(motion.with_(law=law + EACH, split=0.5, reach=reach) for law, reach in own),
        *(motion.with_(law=law, split=0.5, reach=reach) for law in ARCS for reach in _REACHES if sized),
    ]


class CornerTimes(NamedTuple):
    """What rounded corners tell of moves: the acceleration, where none is written, and times beside the ramps."""

    slow: float  # [m/s²] of all moves; [1] times what they have
    each: float = 0.0  # [s] in each move
    stop: float = 0.0  # [s] at each exact stop
    rest: float = 0.0  # [s] of an average that a stretch between two stops passes once: half of it at each

    def beside(self, start: Mask, end: Mask) -> Floats:
        """(n,) [s] of moves that `start` (n,) from rest, and `end` at rest."""
        rests = 0.5 * (start.astype(np.float64) + end)
        return np.asarray(self.each + self.stop * end + self.rest * rests)


_TIMES = ((), ("each",), ("stop",), ("rest",), ("each", "stop"), ("stop", "rest"))  # the plainest first


def told_at_corners(motion: Motion, sim: Floats, start: Mask, end: Mask, written: bool) -> CornerTimes:
    """Times beside the ramps with which a law of corners comes nearest to the simulated durations `sim` (n,) [s], and,
    where it is not `written`, the acceleration of all moves. Laws are tried coarsely: what they save hangs on the ramp
    more than on them. `start`, `end` (n,): from a stop, to one.

    `motion` has the openness of its corners; for an acceleration of 1 m/s² where none is written.
    """
    rows = np.unique(np.linspace(0, len(sim) - 1, _LOOKED_AT).astype(np.intp))
    motion, sim, start, end = motion.take(rows), sim[rows], start[rows], end[rows]
    laws = [
        motion.with_(law="stop"),
        *(law for law in _families(motion) if written or law.reach == _REACHES[0]),
    ]
    spans = {names: _Span.of(names, start, end) for names in _TIMES}
    spans = {names: span for names, span in spans.items() if span.rank == len(names)}
    grid = [0.0] if written else np.linspace(math.log(_RAMPS[0]), math.log(_RAMPS[1]), _RAMP_GRID).tolist()

    def left(law: Motion, logarithm: float, overlaps: Sequence[float]) -> Floats:
        more = math.exp(logarithm)
        ramps = ("accelerate", "decelerate", "open_start", "open_end")
        return np.asarray(
            sim - law.with_(**{name: more * getattr(law, name) for name in ramps}).durations(overlaps)
        )

    def nearest(law: Motion, span: _Span, logarithm: float) -> tuple[float, float]:
        return _walked(lambda overlaps: span.misfits(left(law, logarithm, overlaps)))

    def best(law: Motion, span: _Span, at: int) -> float:
        if written:
            return 0.0
        low, high = grid[max(at - 1, 0)], grid[min(at + 1, _RAMP_GRID - 1)]
        return golden_section(lambda one: nearest(law, span, one)[1], low, high, _RAMP_STEPS)

    coarse = np.full((len(spans), len(laws), len(grid)), np.inf)
    for k, law in enumerate(laws):
        for g, one in enumerate(grid):
            off = left(law, one, _OVERLAPS[: 1 if law.law == "stop" else None])
            coarse[:, k, g] = [span.misfits(off).min() for span in spans.values()]
    found = list[tuple[float, CornerTimes]]()
    for (names, span), offs in zip(spans.items(), coarse, strict=True):
        some = _LAWS_REFINED if not names else _LAWS_BESIDE
        for k in np.argsort(offs.min(axis=1), kind="stable")[:some].tolist():
            one = best(laws[k], span, int(np.argmin(offs[k])))
            overlap, off = nearest(laws[k], span, one)
            times = span.times @ left(laws[k], one, [overlap])[0]
            if (times >= _LEAST_BESIDE).all():
                told = dict(zip(names, times.tolist(), strict=True))
                found.append((off, CornerTimes(math.exp(one), **told)))
    least = max(_AS_NEAR * min(off for off, _ in found), _DIGITS)
    return next(told for off, told in found if off <= least)


def golden_section(misfit: Callable[[float], float], low: float, high: float, steps: int) -> float:
    """Where a misfit between two places is least, by a golden section."""
    one, two = (low + share * (high - low) for share in GOLDEN)
    offs = [misfit(one), misfit(two)]
    for _ in range(steps):
        if offs[0] < offs[1]:
            high, two, one = two, one, low + 0.382 * (two - low)
            offs = [misfit(one), offs[0]]
        else:
            low, one, two = one, two, high - 0.382 * (high - one)
            offs = [offs[1], misfit(two)]
    return 0.5 * (low + high)


def _nearest(motion: Motion, sim: Floats, rounded: NDArray[np.bool_]) -> tuple[float, float]:
    """Overlap and how far [s] off it is."""
    return _walked(lambda overlaps: _offs(motion, overlaps, sim, rounded))


def _walked(misfits: Callable[[Sequence[float]], Floats]) -> tuple[float, float]:
    """Overlap and its misfit: the best of a grid, then ever nearer around it. `misfits`: (k,) of k overlaps."""
    offs = misfits(_OVERLAPS)
    at = int(np.argmin(offs))
    place, best = _OVERLAPS[at], float(offs[at])
    step = 0.5 * (_OVERLAPS[min(at + 1, len(_OVERLAPS) - 1)] - _OVERLAPS[max(at - 1, 0)])
    while step > 1e-4:
        for _ in range(_WALKED):
            tried = [one for one in (place - step, place + step) if one > 0]
            better = [
                (one, off) for one, off in zip(tried, misfits(tried).tolist(), strict=True) if off < best
            ]
            if not better:
                break
            place, best = better[0]
        step *= 0.5
    return place, best


class _Span(NamedTuple):
    """Times beside the ramps of n moves, by least squares."""

    left: Floats  # (n, n) what they leave of differences
    times: Floats  # (k, n) the times
    rank: int  # of the moves by them: as many as there are times where these moves tell them

    @classmethod
    def of(cls, names: tuple[str, ...], start: Mask, end: Mask) -> _Span:
        """Of moves that `start` (n,) from rest, and `end` at rest."""
        columns = [CornerTimes(1.0, **{name: 1.0}).beside(start, end) for name in names]
        told = np.stack(columns, axis=1) if columns else np.zeros((len(start), 0))
        times = np.asarray(np.linalg.pinv(told), dtype=np.float64)
        return cls(np.eye(len(start)) - told @ times, times, int(np.linalg.matrix_rank(told)) if names else 0)

    def misfits(self, offs: Floats) -> Floats:
        """(k,) [s] mean of what the times leave of differences `offs` (k, n) [s]."""
        return np.asarray(np.abs(np.matmul(self.left, offs[..., None])[..., 0]).mean(axis=1))


def _off(motion: Motion, sim: Floats, rounded: NDArray[np.bool_]) -> float:
    """[s] mean distance from the simulation at rounded corners."""
    return float(np.mean(np.abs(motion.duration() - sim)[rounded]))


def _offs(motion: Motion, overlaps: Sequence[float], sim: Floats, rounded: NDArray[np.bool_]) -> Floats:
    """(k,) [s] the same with each of k overlaps."""
    return np.asarray(np.compress(rounded, np.abs(motion.durations(overlaps) - sim), axis=1).mean(axis=1))


# --- Accelerations ---
# Accelerations of the judged simulation that nobody wrote down: read off its durations.

_CONTROLLERS_CYCLE = 1e-6  # [s] less ramp than that is none
_ALIKE = 2e-3  # [1] durations that differ by less are the same simulation
_SIM_DIGITS = 2e-4  # [s] that simulated times may be rounded by
_PLACED = 2e-5  # [m] that the digits of both of its places may add to a way
_ON_GRID = 1e-3  # of a recorder's resolution
_ODD = 0.1  # of the moves that an axis leads: more of them show that it has no single acceleration
_LEVELS, _MANY = 4, 0.1  # accelerations of one simulation, and the share of the moves that each has at least
_MOST_ALIKE = 0.8  # of the moves have one of them
_HALVINGS = 60  # of an interval of logarithms
TURNS = 0.01  # [rad] less is no turn of the tool
ONE_ACCELERATION = 1e-3  # of the accelerations: what differs by no more is one
_TELLING = 4  # lines that turn by different angles: fewer do not tell two limits
_ROUNDED_BELOW = 1e-3  # [s] that lines are off: more counts by its size, less by its square
_DOWNHILL, _DAMPED = 80, 1e-3  # steps, and the share of the slopes that dampens the first one
_STILL = 1e-8  # of a logarithm: a step that small is the last one
_TURNED_RIGHT = 5e-4  # [s] nearer to a simulation than that, limits of the turn are its own
_FEW = 0.5  # of the moves: more of them are no exceptions, the simulation has another law


class SimulatedRamps(NamedTuple):
    """What the ramps of a simulation have beside constant accelerations."""

    stronger: float = 1.0  # [1] share of the written accelerations; [m/s²] of all moves where none is written
    build: float = 0.0  # [s] in which an acceleration builds up
    filtered: float = 0.0  # [s] moving average that each ramp passes
    stop: float = 0.0  # [s] beside the motion, at every exact stop
    shortest: float = 0.0  # [s] that a ramp takes at least
    averaged: float = 0.0  # [s] over which speeds are averaged that every move reaches

    @property
    def told(self) -> bool:
        """Whether there is anything."""
        return self != SimulatedRamps()

    @property
    def says(self) -> str:
        """One sentence for the reader."""
        does = [
            f"{what} {1e3 * time:.1f} ms"
            for what, time in (
                ("builds up accelerations in", self.build),
                ("smooths speeds over", self.filtered),
                ("takes at each stop", self.stop),
                ("makes no ramp shorter than", self.shortest),
                ("averages speeds over", self.averaged),
            )
            if time
        ]
        return f"the simulation {' and '.join(does)}: findings are relative to that"

    def with_one_time(self) -> list[SimulatedRamps]:
        """The laws with one time that moves between stops may not tell from this one."""
        time = self.build + self.filtered + self.stop
        return [SimulatedRamps(**{name: time}) for name in ("stop", "build", "filtered")] if time else []

    def with_timed_ramps(self, way: Floats, speed: Floats, slow: Floats) -> SimulatedRamps:
        """This law, or where accelerations `slow` (n,) [m/s²] take next to nothing beside its time, the one in which
        every ramp takes this time: no drive is that strong, and one that is weaker has longer ramps. Of a time at
        stops, that is as much as lets all moves reach their speed, as they do."""
        time = self.filtered + self.stop + self.shortest
        top = np.minimum(speed, np.sqrt(way * slow))
        if not time or self.build or float(np.max(top / slow)) > NO_RAMP * time:
            return self
        ramp = min(time, float(np.min(way / speed))) if self.stop else time
        return SimulatedRamps(stronger=self.stronger, stop=time - ramp, shortest=ramp)

    def as_an_average(self, way: Floats, speed: Floats, slow: Floats) -> SimulatedRamps | None:
        """The law of a controller that averages speeds, where accelerations `slow` (n,) [m/s²] take next to nothing
        beside a time at stops; None where they do."""
        if not self.stop or self.build or self.filtered:
            return None
        ramp = np.minimum(speed, np.sqrt(way * slow)) / slow
        return SimulatedRamps(averaged=self.stop) if float(np.max(ramp)) <= NO_RAMP * self.stop else None

    def weakened(self, way: Floats, speed: Floats, slow: Floats) -> Floats:
        """(n,) [m/s²] accelerations with which no ramp between two stops is shorter than the shortest."""
        if not self.shortest:
            return slow
        top = np.minimum(np.minimum(speed, np.sqrt(way * slow)), way / self.shortest)
        return np.asarray(np.minimum(slow, top / self.shortest))

    def seconds(self, way: Floats, speed: Floats, slow: Floats, jerk: float = math.inf) -> Floats:
        """(n,) [s] between two stops; accelerations build up at a `jerk` [m/s³] where one is given, else in a time."""
        if self.averaged:
            return np.asarray(way / speed + self.averaged)
        slow = self.weakened(way, speed, slow)
        if not self.build:
            beside = np.full(len(way), self.filtered)
            full = way >= speed * (speed / slow + beside)
            short = 2.0 * way / np.maximum(beside + np.sqrt(beside**2 + 4.0 * way / slow), 1e-12)
            top = np.where(full, speed, short)
            return np.asarray(way / top + top / slow + beside + self.stop)
        none = np.zeros(len(way))
        motion = Motion(
            *(
                way,
                speed,
                slow,
                slow,
                none + jerk,
                none,
                none,
                none,
                none + self.stop,
                none + 1.0,
            ),
            filtered=none + self.filtered,
            build=none + (0.0 if math.isfinite(jerk) else self.build),
        )
        return motion.duration()

    def slow(self, way: Floats, speed: Floats, sim: Floats) -> tuple[Floats, Floats]:
        """(n,) [m/s²] with which moves between stops take the simulated time, without `stop`, nan where none does;
        and (n,) [s] that their ramps add to the way at full speed."""
        over = sim - way / speed - self.build - self.filtered
        with np.errstate(divide="ignore", invalid="ignore"):
            if not (self.build or self.filtered):
                own = np.where(over <= way / speed, speed / over, 4.0 * way / sim**2)
                ramp = np.where(over <= way / speed, over, 0.5 * sim)
                return np.where(ramp > self.shortest * (1.0 + _ALIKE), own, np.nan), over
            low, high = np.log(way / sim**2) - 1.0, np.log(speed / 1e-4) + np.zeros(len(way))
        bare = self._replace(stop=0.0)
        for _ in range(_HALVINGS):
            middle = 0.5 * (low + high)
            longer = bare.seconds(way, speed, np.exp(middle)) > sim
            low, high = np.where(longer, middle, low), np.where(longer, high, middle)
        slow = np.exp(0.5 * (low + high))
        fits = np.abs(bare.seconds(way, speed, slow) - sim) < _CONTROLLERS_CYCLE
        return np.where(fits, slow, np.nan), np.where(fits, np.maximum(over, speed / slow), over)


def limited(way: Floats, speed: Floats, sim: Floats, slow: Floats, plain: Mask, law: SimulatedRamps) -> Mask:
    """(n,) moves between stops that the simulation itself made slower than their acceleration says: an axis' limit."""
    with np.errstate(invalid="ignore", divide="ignore"):
        said = law._replace(stop=0.0).seconds(way, speed, slow)
        off = plain & (sim > said * (1.0 + _ALIKE))
    return np.asarray(off & (off.sum() < _FEW * max(int(plain.sum()), 1)), dtype=bool)


def of_their_own(
    way: Floats, speed: Floats, sim: Floats, slow: Floats, law: SimulatedRamps, digit: float
) -> Mask:
    """(n,) moves between stops whose simulated time, by the law, is not that of an acceleration `slow` (n,) [m/s²], nor
    is but for the digits of places and the last `digit` [s] of times."""
    with np.errstate(invalid="ignore", divide="ignore"):
        said = law._replace(stop=0.0).seconds(way, speed, slow)
        digits = np.maximum(max(_SIM_DIGITS, digit), _PLACED / speed)
        return np.asarray(np.abs(sim - said) > digits)


class TurnLimits(NamedTuple):
    """What limits how fast lines turn the tool: v ≤ ω L/θ, a ≤ α L/θ."""

    speed: float  # ω [rad/s]
    acceleration: float  # α [rad/s²]
    jerk: float = math.inf  # [m/s³] at which accelerations of all lines build up; inf: in a time, or at once

    @property
    def says(self) -> str:
        """One sentence for the reader."""
        rate, ramp = math.degrees(self.speed), math.degrees(self.acceleration)
        jerk = f", and builds up accelerations at {self.jerk:.4g} m/s³" if math.isfinite(self.jerk) else ""
        return (
            f"the simulation turns the tool at {rate:.4g} deg/s and {ramp:.4g} deg/s² at most{jerk}: findings are "
            "relative to that"
        )


def turning_limits(
    way: Floats, speed: Floats, slow: Floats, turn: Floats, sim: Floats, plain: Mask, law: SimulatedRamps
) -> TurnLimits | None:
    """Limits of the turns `turn` (n,) [rad] of the tool in `plain` lines between stops with which all of these take the
    simulated time; None where no such limits do.

    Travel and turn share one law, the slower leads. Where accelerations build up, those that the turn limits tell
    whether they do so at one jerk or in one time.
    """
    bare = law._replace(stop=0.0)
    turns = np.flatnonzero(plain & (turn > TURNS) & (way > 0))
    way, speed, slow, turn, sim = (column[turns] for column in (way, speed, slow, turn, sim))
    longer = sim > bare.seconds(way, speed, slow) * (1.0 + _ALIKE)
    one = len(slow) > 0 and np.ptp(slow) <= ONE_ACCELERATION * float(slow.max())
    jerks = (math.inf, float(slow.max()) / law.build) if law.build and one else (math.inf,)

    def off(rate: float, ramp: float, jerk: float) -> Floats:
        limited_by = np.minimum(speed, rate * way / turn), np.minimum(slow, ramp * way / turn)
        return np.asarray(bare.seconds(way, *limited_by, jerk) - sim)

    for jerk in jerks:
        found = _nearest_limits(partial(off, jerk=jerk), turn[longer], sim[longer])
        if found is not None and float(np.abs(off(*found, jerk)).mean()) <= _TURNED_RIGHT:
            return TurnLimits(*found, jerk)
    return None


def turning_limits_at_corners(
    free: Motion,
    motion: Motion,
    partners: CornerPartners | None,
    turn: Floats,
    turning: Mask,
    sim: Floats,
) -> TurnLimits | None:
    """Limits of the turns `turn` (n,) [rad] of the tool with which the lines `turning` (n,) come nearest to the
    simulated times `sim` (n,) [s], by the law of corners of `motion`; None where too few turn.
    `free`: the motion without limits."""
    longer = turning & (sim > free.duration() + _SIM_DIGITS)
    per_turn = np.where(turn > TURNS, motion.way / np.where(turn > TURNS, turn, 1.0), np.inf)

    def off(rate: float, ramp: float) -> Floats:
        speed = np.minimum(free.speed, rate * per_turn)
        up, down = (np.minimum(one, ramp * per_turn) for one in (free.accelerate, free.decelerate))
        tried = motion.with_(speed=speed, accelerate=up, decelerate=down)
        tried = tried if partners is None else tried.meeting(motion, partners.before, partners.after)
        return np.asarray((tried.duration() - sim)[turning])

    found = _nearest_limits(off, turn[longer], sim[longer])
    return None if found is None else TurnLimits(*found)


def _nearest_limits(
    off: Callable[[float, float], Floats], turn: Floats, sim: Floats
) -> tuple[float, float] | None:
    """Speed [rad/s] and acceleration [rad/s²] with which least is `off` [s]; None where the turns `turn` (n,) [rad] of
    lines that last longer than their ways, `sim` (n,) [s], are too few kinds."""
    if len(np.unique(np.round(np.stack([turn, sim]), 4), axis=1).T) < _TELLING:
        return None
    mean = turn / sim
    rate, ramp = float(mean.max()), float(np.max(4.0 * mean / sim))
    starts = [(one * rate, other * ramp) for one in (1.1, 2.0) for other in (0.5, 1.0, 2.0)]
    tried = [_downhill(lambda place: off(*np.exp(place)), np.log(start)) for start in starts]
    rate, ramp = np.exp(min(tried, key=lambda one: one[1])[0]).tolist()
    return rate, ramp


def _downhill(off: Callable[[Floats], Floats], place: Floats) -> tuple[Floats, float]:
    """Where the lengths of `off` (n,) [s], of which large ones count by their size and small ones by its square, sum up
    to least, from a `place` (p,) on, and that sum: damped steps of Gauss and Newton (K. Levenberg, Quarterly of Applied
    Mathematics 2, 1944), each move weighted by how far it is off."""

    def cost(values: Floats) -> float:
        return float((np.sqrt(1.0 + (values / _ROUNDED_BELOW) ** 2) - 1.0).sum())

    now, damped = off(place), _DAMPED
    least = cost(now)
    for _ in range(_DOWNHILL):
        slopes = np.stack([(off(place + _STEP * one) - now) / _STEP for one in np.eye(len(place))], axis=1)
        weight = 1.0 / np.sqrt(1.0 + (now / _ROUNDED_BELOW) ** 2)
        square, pull = slopes.T @ (weight[:, None] * slopes), slopes.T @ (weight * now)
        size = np.diag(square) + _NOTHING
        for _ in range(_ROUNDS):
            step = np.clip(-np.linalg.solve(square + damped * np.diag(size), pull), -0.5, 0.5)
            there = off(place + step)
            if cost(there) < least:
                break
            damped *= 4.0
        else:
            break
        place, now, least, damped = place + step, there, cost(there), max(damped / 8.0, _DAMPED * 1e-6)
        if np.abs(step).max() < _STILL:
            break
    return place, least


def inferred(
    way: Floats,
    speed: Floats,
    sim: Floats,
    stops: Mask,
    resolution: float,
    law: SimulatedRamps,
    known: Floats,
    leading: NDArray[np.intp],
) -> Floats:
    """(n,) [m/s²] with which ramps by the law take the simulated time, without what stops take; rows with rounded ends
    get the others' median, of the same axis if any, or what is `known` of a robot where no row tells it. `leading`
    (n,): axes of joint moves."""
    slow, over = law.slow(way, speed, sim)
    told = (over > _CONTROLLERS_CYCLE) & np.isfinite(slow)
    digits = max(_SIM_DIGITS, _DIGIT * last_digit(sim))
    if stops.all() or _stops_everywhere(slow, over, told, stops, leading, digits):
        stops = np.ones_like(stops)
    good = stops & told
    if not good.any():
        return np.where(np.isfinite(known), known, 1e3 * float(np.median(speed)))
    on_grid = resolution > 0 and np.abs(sim / resolution - np.round(sim / resolution)).max() < _ON_GRID
    near = 1.01 * max(resolution if on_grid else last_digit(sim), 1e-4)
    found = np.full(len(way), _middle_of(slow[good], over[good]))
    for axis in np.unique(leading[good]).tolist():
        of_it = leading == axis
        found[of_it] = _middle_of(slow[good & of_it], over[good & of_it])
    off = np.abs(law._replace(stop=0.0).seconds(way, speed, found) - sim) > near
    for axis in np.unique(leading).tolist():
        of_it = leading == axis
        if (stops & of_it).any() and np.mean(off[stops & of_it]) > _ODD:
            found[of_it] = np.where(good, slow, found)[of_it]
    return np.where(good & limited(way, speed, sim, found, good, law), slow, found)


def _middle_of(slow: Floats, over: Floats) -> float:
    """[m/s²] Long ramps tell the acceleration best: the median weighted by their length, `over` (n,) [s]."""
    order = np.argsort(slow)
    weight = np.cumsum(over[order])
    return float(slow[order][np.searchsorted(weight, 0.5 * weight[-1])])


def _stops_everywhere(
    slow: Floats, over: Floats, told: Mask, stops: Mask, leading: NDArray[np.intp], digits: float
) -> bool:
    """Whether moves with rounded ends, taken for moves between stops, have the same few accelerations `slow` as those
    between stops have: then the simulation knows of no rounding. `digits` [s]: what simulated times are rounded by.

    Another acceleration says nothing where none of the moves between stops is led by the same axis, `leading` (n,).
    """
    known, asked = told & stops, told & ~stops
    if not asked.any():
        return False
    one = known if known.any() else asked
    levels = _levels(slow[one], over[one], digits)
    if not 0 < len(levels) <= _LEVELS:
        return False
    near = np.abs(slow[asked][:, None] / levels - 1.0) < _ALIKE + digits / over[asked][:, None]
    alike = np.asarray(near.any(axis=1))
    compared = alike | np.isin(leading[asked], leading[one])
    return bool(alike.any() and alike[compared].mean() >= _MOST_ALIKE)


def _levels(slow: Floats, over: Floats, digits: float) -> Floats:
    """The accelerations that nearly all of `slow` are, within the digits of simulated times; none when many."""
    left, found = np.ones(len(slow), dtype=bool), list[float]()
    while left.mean() > 1.0 - _MOST_ALIKE and len(found) < _LEVELS:
        near = np.abs(slow[:, None] / slow[left] - 1.0) < _ALIKE + digits / over[:, None]
        counts = near[left].sum(axis=0)
        if counts.max() < _MANY * len(slow):
            return np.zeros(0)
        best = slow[left][int(np.argmax(counts))]
        found.append(float(best))
        left &= np.abs(slow / best - 1.0) >= _ALIKE + digits / over
    return np.array(found) if left.mean() <= 1.0 - _MOST_ALIKE else np.zeros(0)


# --- Tuned ---
# With which share of the written speeds and accelerations the judged simulation seems to have been run.
#
# Somebody may have tuned it: an override or another acceleration that makes totals agree is in its durations,
# not in the program. Terms act on the motion that the simulation had, so that share has to be known.

FEWEST = 8  # plain moves
_MOST = 4.0  # times faster or slower
_GRID = 161
_REFINED = 40  # halvings' worth of a golden section
_SHARES = (0.8, 0.95)  # of the moves that have to agree; few may be long enough to reach their speed
_TUNED_BETTER = 0.2  # of the written values' misfit: what tuning has to leave at most
_LEAST = 2e-4  # [s] misfits below are digits


def tuned(way: Floats, speed: Floats, slow: Floats, sim: Floats, plain: Mask) -> tuple[float, float]:
    """Share of the speeds and of the accelerations `slow` (n,) [m/s²] (nan: not written) in the simulated times `sim`.

    (1, 1) where the written values do, or where no two shares do either. `plain`: straight moves between exact stops.
    """
    good = plain & np.isfinite(sim) & (way > 0) & (sim > 0) & np.isfinite(speed)
    written = bool(np.isfinite(slow[good]).all())
    slow = slow[good] if written else np.ones(int(good.sum()))
    way, speed, sim = way[good], speed[good], sim[good]
    if len(way) < FEWEST:
        return 1.0, 1.0
    for share in _SHARES:
        found = _tuned(way, speed, slow, sim, written, share)
        if found != (1.0, 1.0):
            return found
    return 1.0, 1.0


# The ramps of a simulation may be no trapezoids: accelerations that build up, a smoothed speed, a time at each stop.

_DIGIT = 0.51  # of a simulated time's last digit: a law that is nearer is the simulation's own
_COARSEST = 2e-3  # [s] digits that tell such laws from each other
_ROUNDS = 30  # of Gauss and Newton
_STEP = 1e-4  # relative, of a slope
_NOTHING = 1e-12  # [s] that moves are off which take a law's time but for rounding
_TOLD_BY = 5  # moves that differ, of a law with two numbers
_TOLD_BESIDE = 3  # of them, at two speeds, of one time beside ramps
_LEAST_BESIDE = 2e-3  # [s] beside the ramps; less is digits
# A simulation that moves in steps ends each move within a step of its law, and brakes by as much sooner or later.
_STEP_OF_TIME = 2e-3  # [s] off its law, at most
_STEPPED = 0.1  # of what constant accelerations alone are off: more is another law
_AS_NEAR = 1.5  # times what the nearest law is off: a plainer one will do
_LAWS = (("stop",), ("build",), ("filtered",), ("build", "stop"))  # the plainest first
NO_RAMP = 0.02  # of the time beside it: a ramp that is so short is none
_SHORT = 0.2  # of the moves have the shortest ramp, at first
_LONGER = 1.2  # times that: other ramps
_SHORTEST = ("shortest",)  # a law of moves between stops
_FIRST_TIMES = 12  # that a law may begin with


def ramps_of(way: Floats, speed: Floats, slow: Floats, sim: Floats, plain: Mask) -> SimulatedRamps | None:
    """The plainest of `ramps_that_fit`; None where no law does."""
    return next(iter(ramps_that_fit(way, speed, slow, sim, plain)), None)


def ramps_that_fit(
    way: Floats, speed: Floats, slow: Floats, sim: Floats, plain: Mask
) -> list[SimulatedRamps]:
    """The laws that come as near to the simulated times as their digits allow, the plainest first, the plain one alone
    where a share of the written speeds and accelerations does; else one that does but for the steps of a simulation;
    none where no law does. The rest as in `tuned`."""
    good = plain & np.isfinite(sim) & (way > 0) & (sim > 0) & np.isfinite(speed)
    written = bool(np.isfinite(slow[good]).all())
    digit = last_digit(sim[good])
    if good.sum() < FEWEST or digit > _COARSEST:
        return []
    faster, stronger = tuned(way, speed, slow, sim, plain)
    way, speed, sim = way[good], speed[good], sim[good]
    slow = slow[good] if written else np.ones(len(way))
    near = max(_DIGIT * digit, _LEAST)

    def off(law: SimulatedRamps, faster: float = 1.0, share: float = _SHARES[0]) -> float:
        return float(np.quantile(np.abs(law.seconds(way, faster * speed, law.stronger * slow) - sim), share))

    stronger = stronger if written else _stronger(way, faster * speed, slow, sim)
    plain_law = SimulatedRamps(stronger)
    plainly = off(plain_law, faster)
    kinds = _kinds(way, speed, slow)
    if plainly <= near:
        # A share that most moves agree on may be that of their one speed; a time beside what is written fits all.
        beside = written and stronger != 1.0 and kinds >= _TOLD_BESIDE and off(plain_law, faster, 1.0) > near
        return (_beside_written(way, speed, slow, sim, near) if beside else []) or [SimulatedRamps()]
    if kinds < _TOLD_BY:
        if kinds < _TOLD_BESIDE or _kinds(speed) < 2:
            return []
        if written:
            return _beside_written(way, speed, slow, sim, near)
        # Two numbers for so few moves: speeds are as they are written, and no move is off.
        one_time = (_nearest_law(way, speed, slow, sim, names, digit) for names in _LAWS if len(names) == 1)
        return [law for law in one_time if law is not None and off(law, 1.0, 1.0) <= near]
    laws = [_nearest_law(way, speed, slow, sim, names, digit) for names in (*_LAWS, _SHORTEST)]
    if written:
        most = _MOST * float(np.median(sim - way / speed))
        laws.append(
            SimulatedRamps(shortest=_nearest_time(lambda time: off(SimulatedRamps(shortest=time)), most))
        )
    found = [(off(law), law) for law in laws if law is not None]
    if exact := [law for misfit, law in found if misfit <= near]:
        return exact
    # Lines of one speed do not tell a share of the written accelerations from a time beside them.
    if written and (beside_written := _beside_written(way, speed, slow, sim, near)):
        return beside_written
    least = min((misfit for misfit, _ in found), default=math.inf)
    if least > min(_STEP_OF_TIME, _STEPPED * plainly):
        return []
    return [law for misfit, law in found if misfit <= _AS_NEAR * least][:1]


def _beside_written(
    way: Floats, speed: Floats, slow: Floats, sim: Floats, near: float
) -> list[SimulatedRamps]:
    """The laws, beside accelerations `slow` (n,) [m/s²] as they are written, with which all moves take the simulated
    time `sim` (n,) [s] as nearly as `near` [s] says: those with one time, or else those with two."""
    over = float(np.median(sim - SimulatedRamps().seconds(way, speed, slow)))
    if over < _LEAST_BESIDE:
        return []

    def law(names: tuple[str, ...], beside: float) -> SimulatedRamps:
        one = SimulatedRamps(**{names[0]: beside})
        if len(names) == 1:
            return one
        left = sim - one.seconds(way, speed, slow)
        return one._replace(**{names[1]: 0.5 * float(left.min() + left.max())})

    def off(names: tuple[str, ...], beside: float) -> float:
        return float(np.abs(law(names, beside).seconds(way, speed, slow) - sim).max())

    for count in (1, 2):
        found = list[SimulatedRamps]()
        for names in (names for names in _LAWS if len(names) == count):
            beside = _nearest_time(lambda time, n=names: off(n, time), _MOST * over)  # type: ignore[misc]
            one = law(names, beside)
            if off(names, beside) <= near and min(getattr(one, name) for name in names) >= _LEAST_BESIDE:
                found.append(one)
        if found:
            return found
    return []


def ramps_beside(way: Floats, speed: Floats, slow: Floats, sim: Floats, beside: float) -> SimulatedRamps:
    """Of the laws with one time, `beside` [s], beside constant accelerations the one that comes nearest to `sim` (n,)
    [s]; the plain one where that time is within the digits. `way`, `speed`, `slow` (n,) of the axis that leads."""
    if beside < _LEAST_BESIDE:
        return SimulatedRamps()
    laws = [SimulatedRamps(**{names[0]: beside}) for names in _LAWS if len(names) == 1]
    return min(
        laws, key=lambda law: float(np.quantile(np.abs(law.seconds(way, speed, slow) - sim), _SHARES[0]))
    )


_LIKELY_LAWS = 3  # the plainest first
_TRIED_TIMES, _GOLDEN = 32, 24  # times beside ramps, and steps of a golden section about the best of them


def ramps_by_corners(
    way: Floats, speed: Floats, slow: Floats, sim: Floats, plain: Mask, lines: Mask, ends: Floats
) -> list[SimulatedRamps]:
    """Of each law with one time beside constant accelerations the nearest one, and of two times beside written ones,
    where the moves between stops, `plain` (n,), are of too few kinds to tell a ramp from a time beside it. Only a law
    of corners that fits tells which is it.

    What a rounded corner saves is the same in `lines` (n,) with the same roundings at their `ends` (n, 2) [m], and of
    one speed where they brake over less: a law is right if these are all off by one time, and those between stops by
    none.
    """
    good = lines & np.isfinite(sim) & (way > 0) & (sim > 0) & np.isfinite(speed)
    plain = (plain & good)[good]
    written = bool(np.isfinite(slow[good]).all())
    way, speed, sim, slow = (
        way[good],
        speed[good],
        sim[good],
        slow[good] if written else np.ones(int(good.sum())),
    )
    digit = last_digit(sim)
    if (
        not plain.any()
        or plain.all()
        or digit > _COARSEST
        or _kinds(way[plain], speed[plain], slow[plain]) >= _TOLD_BY
    ):
        return []
    shorter = written & (speed**2 < 2.0 * slow * ends[good].max(axis=1))
    tell = np.column_stack([ends[good], np.where(shorter, speed, 0.0)])
    alike = np.unique(np.round(tell, 6), axis=0, return_inverse=True)[1].ravel()
    classes = [alike == one for one in np.unique(alike[~plain]).tolist()]
    most = float(np.median((sim - way / speed)[plain]))

    def law(names: tuple[str, ...], beside: float) -> SimulatedRamps:
        stop = beside if names == ("stop",) else 0.0
        one = SimulatedRamps(**{names[0]: beside})
        if written:
            left = (sim - one.seconds(way, speed, slow))[plain]
            return one if len(names) == 1 else one._replace(**{names[1]: float(np.median(left))})
        own = one.slow(way[plain], speed[plain], sim[plain] - stop)[0] / slow[plain]
        return one._replace(stronger=float(np.nanmedian(own)) if np.isfinite(own).any() else 1.0)

    def off(tried: SimulatedRamps) -> float:
        if tried.stronger <= 0.0:  # moves between stops would be too quick for a time so long beside them
            return math.inf
        left = sim - tried.seconds(way, speed, tried.stronger * slow)
        for one in classes:
            left[one] -= np.median(left[one])
        return float(np.quantile(np.abs(left), _SHARES[0]))

    found = list[tuple[float, SimulatedRamps]]()
    for names in (names for names in _LAWS if len(names) == 1 or written):
        beside = _nearest_time(lambda time, n=names: off(law(n, time)), most)  # type: ignore[misc]
        one = law(names, beside)
        if min(getattr(one, name) for name in names) >= _LEAST_BESIDE:
            found.append((off(one), one))
    near = max(_AS_NEAR * min((misfit for misfit, _ in found), default=0.0), _DIGIT * digit, _LEAST)
    return [one for misfit, one in found if misfit <= near][:_LIKELY_LAWS]


def _nearest_time(off: Callable[[float], float], most: float) -> float:
    """[s] at which `off` is least, up to `most`: by a grid and a golden section about its best place."""
    if most <= _LEAST_BESIDE:
        return 0.0
    grid = np.geomspace(_LEAST_BESIDE, most, _TRIED_TIMES)
    at = int(np.argmin([off(time) for time in grid.tolist()]))
    low, high = float(grid[max(at - 1, 0)]), float(grid[min(at + 1, len(grid) - 1)])
    for _ in range(_GOLDEN):
        one, two = low + 0.382 * (high - low), high - 0.382 * (high - low)
        low, high = (low, two) if off(one) <= off(two) else (one, high)
    return 0.5 * (low + high)


def _kinds(*columns: Floats) -> int:
    """How many moves there are that differ."""
    return len(np.unique(np.round(np.log(np.stack(columns)), 4), axis=1).T)


def _nearest_law(
    way: Floats, speed: Floats, slow: Floats, sim: Floats, names: tuple[str, ...], digit: float
) -> SimulatedRamps | None:
    """The law with these times beside constant accelerations, by least squares in which what is far off counts less;
    None where one of them would be none. Moves that are too short for their speed mislead what it begins with: where
    it is off, the best of a grid of times is another beginning."""

    def law(values: Floats) -> SimulatedRamps:
        numbers = np.exp(np.clip(values, -20.0, 20.0)).tolist()
        return SimulatedRamps(numbers[0], **dict(zip(names, numbers[1:], strict=True)))

    def left(values: Floats) -> Floats:
        tried = law(values)
        return sim - tried.seconds(way, speed, tried.stronger * slow)

    def off(values: Floats) -> float:
        return float(np.quantile(np.abs(left(values)), _SHARES[0]))

    begin = _of_long_moves(way, speed, slow, sim, names, digit)
    tried = [] if begin is None else [_least_squares(begin, left, digit)]
    if not tried or off(tried[0]) > max(_DIGIT * digit, _LEAST):
        most = max(float(np.median(sim - way / speed)), _LEAST_BESIDE)
        times = np.geomspace(_LEAST_BESIDE, most, _FIRST_TIMES).tolist()
        grid = [_with_a_time(way, speed, slow, sim, names, time) for time in times]
        known = [values for values in grid if values is not None]
        tried += [_least_squares(min(known, key=off), left, digit)] if known else []
    found = [law(values) for values in sorted(tried, key=off)[:1]]
    return next((one for one in found if min(getattr(one, name) for name in names) >= _LEAST_BESIDE), None)


def _of_long_moves(
    way: Floats, speed: Floats, slow: Floats, sim: Floats, names: tuple[str, ...], digit: float
) -> Floats | None:
    """Logarithms of the share of `slow` and of each of the times that a law has, as long moves have them: their times
    are straight lines of the ramps; None where there is none beside them."""
    ramp, over = speed / slow, sim - way / speed
    weight = np.ones(len(way))
    for _ in range(_ROUNDS):
        root = np.sqrt(weight)
        columns = np.stack([ramp, np.ones(len(way))], axis=1)
        (weaker, beside), *_ = np.linalg.lstsq(root[:, None] * columns, root * over, rcond=None)
        weight = _counts(over - weaker * ramp - beside, digit)
    if weaker <= 0 or beside < _LEAST_BESIDE:
        return None
    if names == _SHORTEST:
        beside = max(float(np.quantile(over, _SHORT)), _LEAST_BESIDE)
        longer = over > _LONGER * beside
        weaker = float(np.median((over / ramp)[longer])) if longer.any() else weaker
    return np.array([-np.log(weaker), *(np.log(beside / len(names)) for _ in names)])


def _with_a_time(
    way: Floats, speed: Floats, slow: Floats, sim: Floats, names: tuple[str, ...], beside: float
) -> Floats | None:
    """The same, where all times together are `beside` [s] and most moves have the share; None where they have none."""
    one = SimulatedRamps(**dict.fromkeys(names, beside / len(names)))
    with np.errstate(invalid="ignore", divide="ignore"):
        own = one.slow(way, speed, sim - one.stop)[0] / slow
    own = own[np.isfinite(own) & (own > 0)]
    if len(own) < FEWEST:
        return None
    return np.array([np.log(np.median(own)), *(np.log(beside / len(names)) for _ in names)])


def _least_squares(values: Floats, left: Callable[[Floats], Floats], digit: float) -> Floats:
    """The values near these at which the sum of squares of what is `left` (n,) [s] is least; what is far off counts
    less."""
    now = left(values)
    for _ in range(_ROUNDS):
        weight = _counts(now, digit)
        slopes = np.stack([(left(values + _STEP * one) - now) / _STEP for one in np.eye(len(values))], axis=1)
        root = np.sqrt(weight)
        step, *_ = np.linalg.lstsq(root[:, None] * slopes, -root * now, rcond=1e-9)
        step = np.asarray(np.clip(step, -0.5, 0.5), dtype=np.float64)
        for _half in range(_ROUNDS):
            there = left(values + step)
            if weight @ there**2 <= weight @ now**2:
                break
            step = 0.5 * step
        values, now = np.asarray(values + step, dtype=np.float64), there
        if np.abs(step).max() < 1e-7:
            break
    return values


def _counts(off: Floats, digit: float) -> Floats:
    """(n,) [1] weights of moves that are `off` (n,) [s]."""
    scale = max(float(np.median(np.abs(off))), digit, _NOTHING)
    return np.asarray(1.0 / (1.0 + (off / (2.0 * scale)) ** 2))


def last_digit(seconds: Floats) -> float:
    """[s] the last digit of simulated times."""
    for digit in (1e-1, 1e-2, 1e-3):
        if np.abs(seconds / digit - np.round(seconds / digit)).max(initial=0.0) < 1e-6:
            return digit
    return 0.0


def _tuned(
    way: Floats, speed: Floats, slow: Floats, sim: Floats, written: bool, share: float
) -> tuple[float, float]:
    """So that a `share` of the moves agree."""

    def misfit(faster: float, stronger: float) -> float:
        return float(np.quantile(np.abs(trapezoid(way, faster * speed, stronger * slow) - sim), share))

    def stronger_of(faster: float) -> float:
        return _stronger(way, faster * speed, slow, sim)

    plainly = misfit(1.0, 1.0 if written else stronger_of(1.0))
    as_written = float(np.median(np.abs(trapezoid(way, speed, slow) - sim))) if written else math.inf
    # What half of the moves take is no chance: the others meet rounded corners.
    if min(plainly, as_written) <= _LEAST:
        return 1.0, 1.0
    tried = list[tuple[float, float]]()
    if written:
        tried += [(1.0, stronger_of(1.0)), (_best(lambda f: misfit(f, 1.0)), 1.0)]
    if not tried or _kinds(way, speed, slow) >= _TOLD_BY:
        both = _best(lambda f: misfit(f, stronger_of(f)))
        tried.append((both, stronger_of(both)))
    exact = [t for t in tried if misfit(*t) <= _LEAST]
    faster, stronger = exact[0] if exact else min(tried, key=lambda t: misfit(*t))
    if misfit(faster, stronger) >= _TUNED_BETTER * plainly:
        return 1.0, 1.0
    return faster, stronger if written else 1.0


def trapezoid(way: Floats, speed: Floats, slow: Floats) -> Floats:
    """(n,) [s] between two stops at constant acceleration."""
    ramp = speed / slow
    return np.asarray(np.where(way >= speed * ramp, way / speed + ramp, 2.0 * np.sqrt(way / slow)))


def _stronger(way: Floats, speed: Floats, slow: Floats, sim: Floats) -> float:
    """The share of `slow` that the middle move says; long ramps tell it best."""
    over = sim - way / speed
    with np.errstate(divide="ignore", invalid="ignore"):
        own = np.where(over <= way / speed, speed / over, 4.0 * way / sim**2) / slow
    good = (over > 0) & np.isfinite(own)
    if not good.any():
        return 1.0
    order = np.argsort(own[good])
    weight = np.cumsum(over[good][order])
    return float(own[good][order][np.searchsorted(weight, 0.5 * weight[-1])])


def _best(misfit: Callable[[float], float]) -> float:
    """By a grid and a golden section about its best place, in logarithms."""
    grid = np.exp(np.linspace(-np.log(_MOST), np.log(_MOST), _GRID))
    at = int(np.argmin([misfit(f) for f in grid.tolist()]))
    low, high = grid[max(at - 1, 0)], grid[min(at + 1, _GRID - 1)]
    for _ in range(_REFINED):
        one, two = low + 0.382 * (high - low), high - 0.382 * (high - low)
        low, high = (low, two) if misfit(float(one)) < misfit(float(two)) else (one, high)
    return float(0.5 * (low + high))
