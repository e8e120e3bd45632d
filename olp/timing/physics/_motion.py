"""The time law that all terms of moves act on: ramps at both ends, a constant speed between, and added times.

A ramp from rest to v with acceleration a and jerk j takes v/a + a/j (or 2 √(v/j) when a is not reached) and covers
v/2 of that time; behind a moving average of length τ it takes v/a + τ. At a rounded corner the next ramp begins
while the last one ends: the overlap is saved, and a recorder books it on the move before the corner, on the one
after, or on both. On paths that are too short for the speed, the peak speed is the one whose ramps cover the path
(L. Biagiotti and C. Melchiorri, Trajectory Planning for Automatic Machines and Robots, Springer 2008, sections 3.2
and 3.4).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, fields
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from olp.core import compiled_loops

Floats = NDArray[np.float64]

_HALVINGS = 26  # of what the highest speed between two corners may be: to 1e-8 m/s
_STEPS, _EXACT = 25, 1e-12  # of Newton's method for the peak speed, at most; a smaller relative step ends it


# What a corner with rounding r saves, κ being `overlap`: nothing; what braking over the last κ r takes; a share κ of
# what braking over the last r takes; 2 κ r at full speed, at most a ramp; the same without that limit; a share κ of the
# ramp whatever the rounding (1: passed at full speed); what a ramp needs beyond the speed √(κ a r); κ seconds; or, of a
# controller that looks ahead, what ramps from and to √(κ a R) save, R = r cot(δ/2) of the arc that touches both moves
# where they turn by δ, and no more than either move's speed; a is the planned acceleration, whatever the drives give;
# the same on the arc's own way, which is shorter, by ramps that begin in its middle, or at its ends; or of the parabola
# that touches both, R = r cos²(δ/2)/sin(δ/2) at its peak, whose way is shorter, and whose radius grows from there on.
# Or, where a controller averages its speeds: each move reaches its own, however short it is, goes half of the arcs at
# its corners, and spends half of a ramp at each stop and a share 1 - κ of that at each corner.
LAWS = (
    "stop",
    "braking",
    "share",
    "distance",
    "flight",
    "full",
    "radius",
    "fixed",
    "arc",
    "round",
    "circle",
    "parabola",
    "average",
)
AVERAGE = "average"
ARCS = ("arc", "round", "circle", "parabola")  # laws of a controller that looks ahead
EACH = " each"  # behind a law: both moves save half by ramps of their own; else the braking before the corner counts
SHORTER = " shorter"  # behind a law: ramps overlap no longer than the shorter of both takes, each over its own rounding
_REACH = 0.5  # [1] of the shorter move: no corner is rounded beyond its middle
_MOST = 0.9  # of a move's own time that corners may save
_GONE_TO = (
    0.05  # [1] of a parabola's radius: who passes a corner more slowly goes to it, the more so the slower
)
_STEEPEST = 3.0  # [rad] by which lines turn along a parabola; more is a way back
# Gauss' three places on a way of length 1, and their weights.
_GAUSS = (0.5 - math.sqrt(0.15), 0.5, 0.5 + math.sqrt(0.15))
_WEIGHTS = (5 / 18, 8 / 18, 5 / 18)
_LEAST_ABOVE = 0.2  # [1] of a ramp's inverse acceleration that is left above any speed


class MoveCorners(NamedTuple):
    """Properties of a move's corners that its neighbours decide; each (n,)."""

    way: Floats  # [m] of the move before
    speed: Floats  # [m/s] of the move before
    slow: Floats  # [1] braking of the move before over that of this one
    shorter_start: Floats  # [m] way of this move or the one before, whichever is shorter
    shorter_end: Floats  # [m] of this move or the next
    next_way: Floats  # [m] of the move after
    next_speed: Floats  # [m/s] of the move after
    next_slow: Floats  # [1] speeding up of the move after over braking of this one
    turns: Floats  # [1] 1 where the way of this move is [rad], 0 where it is [m]
    last_turns: Floats  # [1] of the move before
    next_turns: Floats  # [1] of the move after

    def take(self, rows: NDArray[np.intp]) -> MoveCorners:
        """The corners of these rows."""
        return MoveCorners(*(column[rows] for column in self))


@dataclass(frozen=True, eq=False)
class Motion:
    """Motion of n moves; path lengths are metres, or radians of the leading axis in joint moves."""

    way: Floats  # (n,) [m | rad]; 0 for waits
    speed: Floats  # (n,) [m/s | rad/s]
    accelerate: Floats  # (n,) [m/s² | rad/s²]
    decelerate: Floats  # (n,)
    jerk: Floats  # (n,) [m/s³ | rad/s³], inf: none
    round_start: Floats  # (n,) [m] rounding at the start; 0 from an exact stop
    round_end: Floats  # (n,) [m]
    least: Floats  # (n,) [s] that the move takes whatever the ways says
    added: Floats  # (n,) [s]
    rate: Floats  # (n,) [1] by which whole durations are longer
    cycle: float = 0.0  # [s] of which whole durations are multiples; 0: not
    early: float = 0.0  # [1] of a cycle by which rounding up begins early: 0.5 rounds to the nearest
    timed: bool = False  # whether waits end by a timer of their own, between cycles
    law: str = "stop"  # how rounded corners are passed, one of LAWS, with EACH or without
    overlap: float = 1.0  # [1] of the rounding, of its time or of the ramps that the law uses; [s] of "fixed"
    split: float = 0.5  # [1] of what a corner saves that the move before it gets
    reach: float = _REACH  # [1] of the shorter of its two moves that a corner is rounded over at most
    portion: float = 0.0  # [1/m] times a rounding: its share of a way in rad (laws of the shorter ramp)
    corners: MoveCorners | None = None  # None: all moves are like their neighbours
    filtered: Floats = field(
        default_factory=lambda: np.zeros(0)
    )  # (n,) [s] moving average that each ramp passes
    build: Floats = field(
        default_factory=lambda: np.zeros(0)
    )  # (n,) [s] an acceleration takes, whatever its size
    open_start: Floats = field(
        default_factory=lambda: np.zeros(0)
    )  # (n,) [m/s²] planned acceleration, times the radius of the arc at the start over its rounding
    open_end: Floats = field(default_factory=lambda: np.zeros(0))  # (n,) [m/s²] the same at the end
    delayed: Floats = field(
        default_factory=lambda: np.zeros(0)
    )  # (n,) [s] moving average behind the planner: what stops waits for all of it
    leaving: Floats = field(
        default_factory=lambda: np.zeros(0)
    )  # (n,) [1] acceleration next to rest, where no speed changes a force, over that of the whole ramp
    arriving: Floats = field(default_factory=lambda: np.zeros(0))  # (n,) [1] the same of the ramp at the end
    bend_start: Floats = field(
        default_factory=lambda: np.zeros(0)
    )  # (n,) [rad] by which lines turn at the corner at the start
    bend_end: Floats = field(default_factory=lambda: np.zeros(0))  # (n,) [rad] the same at the end
    limited: Floats = field(
        default_factory=lambda: np.zeros(0)
    )  # (n,) [1] share of the simulated acceleration that limits of axes have left, whatever else takes of it
    shortest: Floats = field(default_factory=lambda: np.zeros(0))  # (n,) [s] that a ramp takes at least

    def __post_init__(self) -> None:
        none = np.zeros(len(self.way))
        right_angle = np.minimum(self.accelerate, self.decelerate)
        for name, default in (
            ("filtered", none),
            ("build", none),
            ("open_start", right_angle),
            ("open_end", right_angle),
            ("delayed", none),
            ("leaving", none + 1.0),
            ("arriving", none + 1.0),
            ("bend_start", none),
            ("bend_end", none),
            ("limited", none + 1.0),
            ("shortest", none),
        ):
            if len(getattr(self, name)) != len(self.way):
                object.__setattr__(self, name, default)

    def with_(self, **changes: Floats | float | str | MoveCorners | None) -> Motion:
        """A copy with some columns changed. The search makes millions: faster than `dataclasses.replace`."""
        copy = object.__new__(Motion)
        own = vars(copy)
        own.update(vars(self), **changes)
        own.pop("_highest", None)
        if "jerk" in changes or "build" in changes:
            own.pop("_jerked", None)
        if "round_start" in changes or "round_end" in changes:
            own.pop("_rounded", None)
        if "delayed" in changes:
            own.pop("_waits", None)
        if "shortest" in changes:
            own.pop("_floored", None)
        return copy

    # Kept by the copies of `with_` while their columns are the same: the search asks for them before all else.

    @cached_property
    def _jerked(self) -> bool:
        """Whether the acceleration of some moves takes time to build up."""
        return bool(np.isfinite(self.jerk).any() or self.build.any())

    @cached_property
    def _rounded(self) -> bool:
        """Whether some moves have a rounded corner."""
        return bool(((self.round_start > 0) | (self.round_end > 0)).any())

    @property
    def looks_ahead(self) -> bool:
        """Whether moves meet at rounded corners that a controller passes at a speed which it plans for each."""
        return self.law in ARCS and self._rounded

    @cached_property
    def _waits(self) -> bool:
        """Whether an average behind the planner delays some moves."""
        return bool(self.delayed.any())

    @cached_property
    def _floored(self) -> bool:
        """Whether some ramps have a shortest time."""
        return bool(self.shortest.any())

    def lengthened(self) -> Motion:
        """The same durations between stops by accelerations alone: no ramp is shorter than the shortest."""
        if not self._floored or self.law == AVERAGE:
            return self
        top = self.top()
        least = np.where(self.shortest > 0, top / np.maximum(self.shortest, 1e-9), np.inf)
        accelerate, decelerate = (np.minimum(own, least) for own in (self.accelerate, self.decelerate))
        return self.with_(accelerate=accelerate, decelerate=decelerate, shortest=np.zeros(len(self.way)))

    def where(self, mask: NDArray[np.bool_], other: Motion) -> Motion:
        """`other` in the moves of `mask` (n,), this motion in all others."""
        mine, others = vars(self), vars(other)
        differ = [name for name in _COLUMNS if mine[name] is not others[name]]
        return self.with_(**{name: np.where(mask, others[name], mine[name]) for name in differ})

    def meeting(self, base: Motion, before: NDArray[np.int64], after: NDArray[np.int64]) -> Motion:
        """The motion with corners at which the moves that meet there are changed as they are from their `base`, and
        which both pass at one speed.

        `before`, `after` (n,): rows of the moves that end where these begin, and that begin where these end. What one
        end of a move changes in its ramps may be the opposite in the next move: of gravity, going up and going down.
        """
        corners, met = base.corners, self
        ramps = ("speed", "accelerate", "decelerate")
        if self.looks_ahead and self.open_end is not base.open_end:
            # A corner has one speed, which the move plans whose end it rounds.
            known = base.open_end > 0
            opened = np.where(known, self.open_end / np.where(known, base.open_end, 1.0), 1.0)
            met = self.with_(open_start=base.open_start * opened[before])
        if corners is None or not self._by_neighbours or all(vars(self)[n] is vars(base)[n] for n in ramps):
            return met
        slow, fast = self._down / base._down, self.top() / base.top()
        last = corners._replace(
            speed=np.minimum(corners.speed, np.sqrt(corners.way * base._down * corners.slow)) * fast[before],
            slow=corners.slow * slow[before] / slow,
        )
        if SHORTER not in self.law and self.law not in ARCS:
            return met.with_(corners=last)
        up = self._up / base._up
        next_up = base._down * corners.next_slow
        both = last._replace(
            next_speed=np.minimum(corners.next_speed, np.sqrt(corners.next_way * next_up)) * fast[after],
            next_slow=corners.next_slow * up[after] / slow,
        )
        return met.with_(corners=both)

    @property
    def _up(self) -> Floats:
        """Acceleration (n,) next to rest, where corners are rounded."""
        return self.accelerate * self.leaving

    @property
    def _down(self) -> Floats:
        """Deceleration (n,) next to rest."""
        return self.decelerate * self.arriving

    @property
    def _by_neighbours(self) -> bool:
        """Whether the time that a corner saves hangs on the ramps of its other move."""
        if self.law == AVERAGE:
            return False
        if self.law in ARCS or SHORTER in self.law:
            return self._rounded
        return self._rounded and self.law != "stop" and EACH not in self.law and self.split != 1.0

    def duration(self) -> Floats:
        """Durations (n,) [s] before `rate` and `cycle`, which act on whole durations."""
        if self.law == AVERAGE:
            return self._averaged()
        if self._floored:
            return self.lengthened().duration()
        law, corners = self.law.removesuffix(SHORTER), self.corners
        looped = law != self.law and self._rounded and not self._jerked and not self._waits
        if looped and corners and _LOOPS.worth(len(self.way)):
            return self._in_loops(law, corners)
        if law in ARCS and self._rounded:
            return self._through_arcs()
        travel, top = self._travel()
        whole = np.maximum(travel, self.least) + self.added
        if self._waits:
            whole = whole + self._delay(top)
        if self.law == "stop" or not self._rounded:
            return np.asarray(whole)
        return np.asarray(whole - np.minimum(self._saved(top), _MOST * travel))

    def durations(self, overlaps: Sequence[float]) -> Floats:
        """(k, n) [s] `duration` with each of k overlaps, at about the price of one: laws without SHORTER alone."""
        column = np.reshape(overlaps, (-1, 1)).astype(np.float64)
        whole = self.with_(overlap=column).duration()
        return np.asarray(np.broadcast_to(whole, (len(column), len(self.way))))

    @property
    def manner(self) -> tuple[object, ...]:
        """What motions of the same moves have in common that can stand one below the other as one."""
        own = vars(self)
        return *(own[name] for name in _IN_COMMON), self._jerked

    def _delay(self, top: Floats) -> Floats:
        """Time (n,) [s] for which moves wait for the average behind the planner: all of it up to a stop; at a rounded
        end the next move begins as soon as what is left of the averaged ramp is the rounding, by the laws that say so,
        else in the middle of it.
        """
        law = self.law.removesuffix(EACH)
        spared = 0.5 * self.delayed
        if law in ("braking", "share"):
            shorter = self.corners.shorter_end if self.corners is not None else self.way
            end = np.minimum(self.round_end, self.reach * shorter)
            average = np.maximum(self.delayed, 0.0)
            both = [
                last_part(end if law == "share" else self.overlap * end, top, self._down, smoothed)
                for smoothed in (average, 0.0 * average)
            ]
            longer = (both[0] - both[1]) * (self.overlap if law == "share" else 1.0)
            spared = np.where(self.delayed > 0, longer, spared)
        return np.asarray(self.delayed - np.where(self.round_end > 0, spared, 0.0))

    @property
    def _neighbours(self) -> MoveCorners:
        """What the corners hang on; without any the moves are like their neighbours."""
        one = np.ones(len(self.way))
        return self.corners or MoveCorners(
            self.way, self.speed, one, self.way, self.way, self.way, self.speed, one, one, one, one
        )

    def _through_arcs(self) -> Floats:
        """`duration` of moves that begin and end at the speeds of the arcs or parabolas at their corners.

        Behind a moving average, ramps from and to rest take as much longer as between stops.
        """
        corners, up, down = self._neighbours, self.accelerate, self.decelerate
        way = np.maximum(self.way, 1e-9)
        start = np.minimum(self.round_start, self.reach * corners.shorter_start)
        end = np.minimum(self.round_end, self.reach * corners.shorter_end)
        open_start, open_end = self.overlap * self.open_start, self.overlap * self.open_end
        bends, cut = np.zeros(len(way)), np.asarray(1.0)
        shorter_start = shorter_end = bends
        if self.law in CURVES:
            curve = CURVES[self.law]
            (shorter_start, flat_start), (shorter_end, flat_end) = map(
                curve, (self.bend_start, self.bend_end)
            )
            cut = np.minimum(self.overlap / _GONE_TO, 1.0)
            way = np.maximum(way - cut * (shorter_start * start + shorter_end * end), 1e-9)
            open_start, open_end = open_start * flat_start, open_end * flat_end
        first = np.minimum(np.sqrt(start * open_start), np.fmin(self.speed, corners.speed))
        last = np.minimum(np.sqrt(end * open_end), np.fmin(self.speed, corners.next_speed))
        after = before = None
        if self.law == "circle":
            arcs = (cut * start * (1.0 - shorter_start), cut * end * (1.0 - shorter_end))
            first, after = _along_arc(first, arcs[0], np.minimum(np.sqrt(start * open_start), self.speed), up)
            last, before = _along_arc(last, arcs[1], np.minimum(np.sqrt(end * open_end), self.speed), down)
        if self.law == "parabola":
            first, after = _bending(first, start, open_start, self.bend_start, up, self.speed, cut)
            last, before = _bending(last, end, open_end, self.bend_end, down, self.speed, cut)
        if after is not None and before is not None:
            way = np.maximum(way - after.way - before.way, 1e-9)
            bends = after.seconds + before.seconds
        last = np.minimum(last, np.sqrt(first**2 + 2.0 * up * way))
        first = np.minimum(first, np.sqrt(last**2 + 2.0 * down * way))
        if self._jerked:
            last = _reached(first, last, way, up, self._jerks[0])
            first = _reached(last, first, way, down, self._jerks[1])
        reached = np.sqrt((down * first**2 + up * last**2 + 2.0 * up * down * way) / (up + down))
        top = np.minimum(self.speed, reached)
        if self._jerked:
            top = _peak_between(first, last, top, way, (up, down), self._jerks)
        up, down = _above(up, self.leaving, first / top), _above(down, self.arriving, last / top)
        if self._jerked:
            jerks = self._jerks
            ramps = _covered(first, top, up, jerks[0]) + _covered(last, top, down, jerks[1])
            travel = _ramp_between(first, top, up, jerks[0]) + _ramp_between(last, top, down, jerks[1])
        else:
            ramps = 0.5 * ((top**2 - first**2) / up + (top**2 - last**2) / down)
            travel = (top - first) / up + (top - last) / down
        travel = travel + np.maximum(way - ramps, 0.0) / top
        if self.filtered.any():
            bare = self.with_(filtered=np.zeros(len(self.way)))
            rests = 0.5 * ((first == 0.0).astype(np.float64) + (last == 0.0))
            travel = travel + rests * (self._travel()[0] - bare._travel()[0])
        travel = np.where(self.way > 0, travel + bends, 0.0)
        whole = np.maximum(travel, self.least) + self.added
        return np.asarray(whole + self._delay(top) if self._waits else whole)

    def _averaged(self) -> Floats:
        """`duration` of moves whose speeds are averaged over what their ramps take."""
        corners = self._neighbours
        start = np.minimum(self.round_start, self.reach * corners.shorter_start)
        end = np.minimum(self.round_end, self.reach * corners.shorter_end)
        way = self.way - _arc(self.bend_start)[0] * start - _arc(self.bend_end)[0] * end
        travel = np.maximum(way, 0.0) / self.speed
        for ramp, rounding, jerk in zip(
            (self.accelerate, self.decelerate), (start, end), self._jerks, strict=True
        ):
            left = np.where(rounding > 0, 1.0 - self.overlap, 1.0)
            travel = travel + 0.5 * left * np.maximum(_ramp(self.speed, ramp, jerk), self.shortest)
        return np.asarray(np.maximum(np.where(self.way > 0, travel, 0.0), self.least) + self.added)

    def _saved(self, top: Floats) -> Floats:
        """Time (n,) [s] saved at both corners; `top` (n,) [m/s]: the highest speed of each move."""
        corners = self._neighbours
        if SHORTER in self.law:
            return self._overlapped(corners, top)
        law = self.law.removesuffix(EACH)
        start = np.minimum(self.round_start, self.reach * corners.shorter_start)
        end = np.minimum(self.round_end, self.reach * corners.shorter_end)
        if law != self.law:
            saved = 0.5 * self._saving(law, start, top, self._up)
            return saved + 0.5 * self._saving(law, end, top, self._down)
        saved = self.split * self._saving(law, end, top, self._down)
        if self.split == 1.0:
            return saved
        slow = self._down * corners.slow
        fast = np.minimum(corners.speed, np.sqrt(corners.way * slow)) if self.corners is not None else top
        return saved + (1.0 - self.split) * self._saving(law, start, fast, slow)

    def _in_loops(self, law: str, corners: MoveCorners) -> Floats:
        """`duration` of moves without a jerk whose ramps overlap no longer than the shorter one."""
        result = np.empty(len(self.way))
        own = (self.way, self.speed, self.accelerate, self.decelerate, self._up, self._down)
        ends = (self.round_start, self.round_end)
        beside = (corners.way, corners.speed, corners.slow, corners.turns, corners.last_turns)
        after = (corners.next_way, corners.next_speed, corners.next_slow, corners.next_turns)
        columns = (*own, *ends, self.least, self.added, self.filtered, *beside, *after)
        numbers = (self.overlap, self.split, self.portion)
        _compiled_durations(columns, _IN_LOOPS[law], numbers, result)
        return result

    def _overlapped(self, corners: MoveCorners, top: Floats) -> Floats:
        """(n,) [s] by both corners, as long as the shorter of the ramps that meet there."""
        down = self._down
        before, after = down * corners.slow, down * corners.next_slow
        last = np.minimum(corners.speed, np.sqrt(corners.way * before))
        first = np.minimum(corners.next_speed, np.sqrt(corners.next_way * after))
        start, end = self.round_start, self.round_end
        saved = self.split * np.minimum(
            self._ramp_over(end, self.way, top, down, corners.turns),
            self._ramp_over(end, corners.next_way, first, after, corners.next_turns),
        )
        if self.split == 1.0:
            return saved
        return saved + (1.0 - self.split) * np.minimum(
            self._ramp_over(start, corners.way, last, before, corners.last_turns),
            self._ramp_over(start, self.way, top, self._up, corners.turns),
        )

    def _ramp_over(self, rounding: Floats, way: Floats, fast: Floats, slow: Floats, turns: Floats) -> Floats:
        """(n,) [s] of a ramp of a move over its rounding, by the law; `turns` (n,): 1 where its way is [rad]."""
        law = self.law.removesuffix(SHORTER)
        if self.portion > 0:
            rounding = np.where(turns > 0, rounding * self.portion * way, rounding)
        most = _REACH * way / (max(self.overlap, 1e-9) if law == "braking" else 1.0)
        return self._saving(law, np.minimum(rounding, most), fast, slow)

    def _saving(self, law: str, rounding: Floats, fast: Floats, slow: Floats) -> Floats:
        """Time (n,) [s] that one corner saves for both of its moves; `fast` [m/s] and `slow` [m/s²] of the ramp
        that ends there.
        """
        fast, ramp = np.maximum(fast, 1e-9), fast / slow
        reach = rounding if law == "share" else self.overlap * rounding
        if law == "full":
            saved = self.overlap * _ramp(fast, slow, self._jerk_of(slow))
        elif law == "fixed":
            saved = np.zeros(len(fast)) + self.overlap
        elif law in ("distance", "flight"):
            saved = 2.0 * reach / fast
            saved = saved if law == "flight" else np.minimum(saved, ramp)
        elif law == "radius":
            passed = np.minimum(np.sqrt(reach * slow) / fast, 1.0)
            saved = ramp * (2.0 - passed) * passed
        else:
            inside = 2.0 * reach * slow <= fast**2
            saved = np.where(inside, np.sqrt(2.0 * reach / slow), 0.5 * ramp + reach / fast)
            saved = self.overlap * saved if law == "share" else saved
        return np.asarray(np.where(rounding > 0, saved, 0.0))

    def _travel(self) -> tuple[Floats, Floats]:
        """Time of the path alone (n,) [s], and the highest speed (n,) [m/s]."""
        jerked = self._jerked
        if not jerked and _TRAVELLED.worth(len(self.way)):
            travel, top = np.empty((2, len(self.way)))
            ramps = (self.accelerate, self.decelerate, self.filtered)
            _compiled_travel((self.way, self.speed, *ramps), travel, top)
            return travel, top
        moving, speed, ramps = self.way > 0, self.speed, self._ramps(self.speed, jerked)
        short = np.flatnonzero((speed * ramps > self.way) & moving)
        if len(short):
            speed = speed.copy()
            speed[short] = self._some(short, _TRAVEL)._peak()
            ramps = self._ramps(speed, jerked)
        return np.where(moving, self.way / np.where(moving, speed, 1.0) + ramps, 0.0), speed

    def _ramps(self, speed: Floats, jerked: bool) -> Floats:
        """Time (n,) [s] that the ramps add to the path at full speed, half of their duration; `jerked`: some have a
        finite jerk.
        """
        if jerked:
            up, down = self._jerks
            both = _ramp(speed, self.accelerate, up) + _ramp(speed, self.decelerate, down)
        else:
            both = speed / self.accelerate + speed / self.decelerate
        return np.asarray(0.5 * both + self.filtered)

    def _peak(self) -> Floats:
        """Speed (n,) [m/s] whose ramps cover the path exactly; in closed form where both ends reach their
        acceleration, or neither does.
        """
        slow = 0.5 * (1.0 / self.accelerate + 1.0 / self.decelerate)
        if not self._jerked:
            root = np.sqrt(self.filtered**2 + 4.0 * np.maximum(slow, 1e-12) * self.way)
            return np.minimum(self.speed, 2.0 * self.way / (self.filtered + root))
        if self.filtered.any():
            return self._solved()
        up, down = self._jerks
        build = 0.5 * (self.accelerate / up + self.decelerate / down)
        root = np.sqrt(build**2 + 4.0 * np.maximum(slow, 1e-12) * self.way)
        reached = 2.0 * self.way / (build + root)
        unreached = self._unreached()
        full = (reached * up >= self.accelerate**2) & (reached * down >= self.decelerate**2)
        peak = np.where(full, reached, unreached)
        over = (unreached * up > self.accelerate**2) | (unreached * down > self.decelerate**2)
        mixed = np.nonzero(~full & over)[0]
        if len(mixed):
            peak[mixed] = self._some(mixed, _TRAVEL)._solved()
        return np.minimum(peak, self.speed)

    def _solved(self) -> Floats:
        """Speed (n,) [m/s] whose ramps cover the path exactly, by Newton's method in logarithms.

        Ramps that do not reach their acceleration are the shortest: their speed is one from above, and the way of the
        ramps is smooth and bends upwards there.
        """
        peak = np.minimum(self._unreached(), self.speed)
        for _ in range(_STEPS):
            ramps = self._ramps(peak, True)
            growth = self._growth(peak, self.accelerate) + self._growth(peak, self.decelerate)
            slope = ramps + 0.5 * growth
            step = ramps / slope * np.log(self.way / (peak * ramps))
            peak = np.minimum(peak * np.exp(step), self.speed)
            if np.abs(step).max() < _EXACT:
                break
        return np.asarray(peak)

    def _growth(self, speed: Floats, acceleration: Floats) -> Floats:
        """(n,) [s] by which a ramp grows with the logarithm of its speed."""
        jerk = self._jerk_of(acceleration)
        reached = speed * jerk >= acceleration**2
        return np.asarray(np.where(reached, speed / acceleration, np.sqrt(speed / jerk)))

    @property
    def _jerks(self) -> tuple[Floats, Floats]:
        """(n,) [m/s³] of the ramps at the start and at the end."""
        return self._jerk_of(self.accelerate), self._jerk_of(self.decelerate)

    def _jerk_of(self, acceleration: Floats) -> Floats:
        """(n,) [m/s³] with which an acceleration builds up: the own one, or one that grows with it."""
        if not self.build.any():
            return self.jerk
        with np.errstate(divide="ignore"):
            return np.asarray(np.minimum(self.jerk, acceleration / self.build))

    def _unreached(self) -> Floats:
        """(n,) [m/s] peak of ramps that cover the path without reaching their accelerations."""
        up, down = self._jerks
        with np.errstate(divide="ignore"):
            return np.asarray(np.cbrt((self.way / (1.0 / np.sqrt(up) + 1.0 / np.sqrt(down))) ** 2))

    def top(self) -> Floats:
        """Highest speed without jerk (n,) [m/s]: the programmed speed, or less on short paths."""
        return self._highest

    @cached_property
    def _highest(self) -> Floats:
        if self.law == AVERAGE:
            return self.speed
        way = np.maximum(self.way, 1e-9)
        slow = 0.5 * (1.0 / self.accelerate + 1.0 / self.decelerate)
        top = np.minimum(self.speed, np.sqrt(way / slow))
        if self._floored:
            # A ramp covers what the longer of both times needs: the speed is the lowest of those by either time.
            least = np.maximum(self.shortest, 1e-12)
            for ramp in (self.accelerate, self.decelerate):
                top = np.minimum(top, 4.0 * way / (least + np.sqrt(least**2 + 8.0 * way / ramp)))
            top = np.minimum(top, way / least)
        return np.asarray(top)

    def repeated(self, count: int) -> Motion:
        """The moves `count` times, one set below the other."""
        own = vars(self)
        columns: dict[str, Floats | MoveCorners] = {name: np.tile(own[name], count) for name in _COLUMNS}
        if self.corners is not None:
            columns["corners"] = MoveCorners(*(np.tile(column, count) for column in self.corners))
        result = self.with_(**columns)
        vars(result)["_jerked"] = self._jerked
        return result

    def take(self, rows: NDArray[np.intp]) -> Motion:
        """Some of the moves."""
        some = self._some(rows)
        return some if self.corners is None else some.with_(corners=self.corners.take(rows))

    def _some(self, rows: NDArray[np.intp], columns: tuple[str, ...] = ()) -> Motion:
        """Some of the moves, each as if its neighbours were equal to it; `columns`: those that are needed, () all."""
        own = vars(self)
        some = self.with_(corners=None, **{name: own[name][rows] for name in columns or _COLUMNS})
        if not self._jerked:
            vars(some)["_jerked"] = False
        return some


_IN_COMMON = ("cycle", "early", "timed", "law", "overlap", "split", "reach", "portion")  # of all moves
_COLUMNS = tuple(column.name for column in fields(Motion) if column.name not in (*_IN_COMMON, "corners"))
_TRAVEL = (
    "way",
    "speed",
    "accelerate",
    "decelerate",
    "jerk",
    "filtered",
    "build",
)  # what the way alone hangs on


_IN_LOOPS = {"full": 0, "share": 1, "braking": 2}  # laws of the shorter ramp
_LOOPS = compiled_loops.Loops(1.5e-7)  # [s] per move that they save, measured
_TRAVELLED = compiled_loops.Loops(2e-7)  # [s] likewise, of some hundred moves


def _less(one: float, other: float) -> float:
    """What `np.minimum` says."""
    return one if one < other or one != one else other


def _more(one: float, other: float) -> float:
    """What `np.maximum` says."""
    return one if one > other or one != one else other


def _looped_ramp(
    law: int,
    overlap: float,
    portion: float,
    rounding: float,
    way: float,
    fast: float,
    slow: float,
    turns: float,
) -> float:
    """The same as `Motion._ramp_over` of one move."""
    if portion > 0.0 and turns > 0.0:
        rounding = rounding * portion * way
    rounding = _less(rounding, _REACH * way / (max(overlap, 1e-9) if law == 2 else 1.0))
    if not rounding > 0.0:
        return 0.0
    fast = _more(fast, 1e-9)
    ramp = fast / slow
    if law == 0:
        return overlap * ramp
    reach = rounding if law == 1 else overlap * rounding
    inside = 2.0 * reach * slow <= fast * fast
    saved = math.sqrt(2.0 * reach / slow) if inside else 0.5 * ramp + reach / fast
    return overlap * saved if law == 1 else saved


def _looped_travel(way: float, speed: float, up: float, down: float, filtered: float) -> tuple[float, float]:
    """The same as `Motion._travel` of one move without a jerk."""
    if not way > 0.0:
        return 0.0, speed
    ramps = 0.5 * (speed / up + speed / down) + filtered
    if speed * ramps > way:
        mean = _more(0.5 * (1.0 / up + 1.0 / down), 1e-12)
        root = math.sqrt(filtered * filtered + 4.0 * mean * way)
        speed = _less(speed, 2.0 * way / (filtered + root))
        ramps = 0.5 * (speed / up + speed / down) + filtered
    return way / speed + ramps, speed


@compiled_loops.kernel(_less, _more, _looped_travel)
def _compiled_travel(columns: tuple[Floats, ...], travel: Floats, top: Floats) -> None:
    """The same as `Motion._travel`, to the last bit: a search asks for it hundreds of thousands of times."""
    way, speed, up, down, filtered = columns
    for i in range(len(way)):
        travel[i], top[i] = _looped_travel(way[i], speed[i], up[i], down[i], filtered[i])


@compiled_loops.kernel(_less, _more, _looped_ramp, _looped_travel)
def _compiled_durations(
    columns: tuple[Floats, ...], law: int, numbers: tuple[float, float, float], result: Floats
) -> None:
    """The same as `Motion.duration`, to the last bit: a search asks for it thousands of times."""
    way, speed, up, down, leave, arrive, start, end, least, added, filtered = columns[:11]
    last_way, last_speed, slow, turns, last_turns, next_way, next_speed, next_slow, next_turns = columns[11:]
    overlap, split, portion = numbers
    for i in range(len(way)):
        travel, top = _looped_travel(way[i], speed[i], up[i], down[i], filtered[i])
        before, after = arrive[i] * slow[i], arrive[i] * next_slow[i]
        saved = split * _less(
            _looped_ramp(law, overlap, portion, end[i], way[i], top, arrive[i], turns[i]),
            _looped_ramp(
                law,
                overlap,
                portion,
                end[i],
                next_way[i],
                _less(next_speed[i], math.sqrt(next_way[i] * after)),
                after,
                next_turns[i],
            ),
        )
        if split != 1.0:
            saved += (1.0 - split) * _less(
                _looped_ramp(
                    law,
                    overlap,
                    portion,
                    start[i],
                    last_way[i],
                    _less(last_speed[i], math.sqrt(last_way[i] * before)),
                    before,
                    last_turns[i],
                ),
                _looped_ramp(law, overlap, portion, start[i], way[i], top, leave[i], turns[i]),
            )
        result[i] = _more(travel, least[i]) + added[i] - _less(saved, _MOST * travel)


def stacked(motions: Sequence[Motion], own: Sequence[Motion], whole: Motion) -> Motion:
    """Motions in one manner as one, one below the other. `own`: the moves' own motion, as often as each has them;
    `whole`: as often as all have them. A column that is nowhere changed is that of `whole`."""
    columns = dict[str, Floats]()
    changed, bases, all_of = [vars(one) for one in motions], [vars(one) for one in own], vars(whole)
    pairs = list(zip(changed, bases, strict=True))
    for name in _COLUMNS:
        for one, base in pairs:
            if one[name] is not base[name]:
                columns[name] = np.concatenate([one[name] for one in changed])
                break
        else:
            columns[name] = all_of[name]
    result = motions[0].with_(**columns, corners=whole.corners)
    vars(result)["_jerked"] = motions[0]._jerked
    return result


def last_part(rest: Floats, speed: Floats, slow: Floats, average: Floats) -> Floats:
    """Time (n,) [s] that the last `rest` (n,) [m] before a stop takes, from `speed` (n,) [m/s] at the deceleration
    `slow` (n,) [m/s²], where the speed passes a moving average of length `average` (n,) [s].

    Of a time t before the stop, a/2 ((t - τ/2)² + τ²/12) is left while all of the average is inside the ramp, so that
    t = τ/2 + √(2 r/a - τ²/12); a t³/6τ at the end; and at the beginning, u behind it, a u³/6τ more than at full speed.
    Ramp and average may change places: two moving averages of one step.
    """
    ramp = speed / slow
    long, short = np.maximum(ramp, average), np.maximum(np.minimum(ramp, average), 1e-9)
    slow = speed / long
    whole, jerk = long + short, slow / short
    covered = 0.5 * speed * whole
    inside = 0.5 * short + np.sqrt(np.maximum(2.0 * rest / slow - short**2 / 12.0, 0.0))
    ending = np.cbrt(6.0 * rest / jerk)
    # u³ - 6 u v/j + 6 (s - r)/j = 0 by three times the angle.
    size = np.sqrt(2.0 * speed / jerk)
    share = np.clip(1.5 * (covered - rest) / (speed * size), 0.0, 1.0)
    beginning = whole - 2.0 * size * np.sin(np.arcsin(share) / 3.0)
    told = np.where(inside <= long, inside, beginning)
    told = np.where(6.0 * rest <= slow * short**2, ending, told)
    return np.asarray(np.where(rest >= covered, 0.5 * whole + rest / speed, told))


def _parabola(bend: Floats) -> tuple[Floats, Floats]:
    """(n,) each, of corners that turn by `bend` (n,) [rad] along a parabola which touches both lines at one distance,
    the rounding: the share of that by which half of the way is shorter, ½ - c²/(2 k) asinh(k/c), c and k the cosine
    and sine of half the turn; and c, the radius at the peak over that of the arc that touches there, too."""
    flat, steep = np.cos(0.5 * bend), np.sin(0.5 * bend)
    some = np.maximum(steep, 1e-6)
    way = 0.5 + flat**2 / (2.0 * some) * np.arcsinh(some / np.maximum(flat, 1e-9))
    return np.asarray(1.0 - way), flat


def _arc(bend: Floats) -> tuple[Floats, Floats]:
    """The same of the arc itself, whose radius is one."""
    half = np.maximum(0.5 * bend, 1e-6)
    return np.asarray(np.maximum(1.0 - half / np.tan(half), 0.0)), np.ones(len(bend))


CURVES = {"round": _arc, "circle": _arc, "parabola": _parabola}  # that are shorter than both lines


class _Bend(NamedTuple):
    """Part of an arc or a parabola, next to its middle, that is passed no faster than its radius allows."""

    way: Floats  # (n,) [m]
    seconds: Floats  # (n,)


def _along_arc(middle: Floats, half: Floats, most: Floats, slow: Floats) -> tuple[Floats, _Bend]:
    """Speed (n,) [m/s] with which half an arc, `half` (n,) [m] long, is left whose middle is passed at so many (n,)
    [m/s], no faster than `most` (n,) [m/s] on it, by ramps of `slow` (n,) [m/s²]; and its time."""
    ramp = np.minimum(half, np.maximum(most**2 - middle**2, 0.0) / (2.0 * slow))
    left = np.sqrt(middle**2 + 2.0 * slow * ramp)
    seconds = (left - middle) / slow + np.maximum(half - ramp, 0.0) / np.maximum(most, 1e-9)
    return left, _Bend(half, np.where(half > 0, seconds, 0.0))


def _bending(
    peak: Floats,
    rounding: Floats,
    opened: Floats,
    bend: Floats,
    slow: Floats,
    speed: Floats,
    cut: Floats | float,
) -> tuple[Floats, _Bend]:
    """Speed (n,) [m/s] with which half a parabola is left whose `peak` is passed at so many (n,) [m/s], where `opened`
    (n,) [m/s²] times the `rounding` (n,) [m] is the square of the speed that is allowed there; and its part that is
    passed no faster than the radius lets it.

    That is v² = v0² (1 + ξ²)^3/2, ξ being the tangent of the angle to the peak: it asks for a ramp of 3 ξ v0²/(2 R0),
    until that is the own one, `slow` (n,), the line begins or the `speed` (n,) is reached. Who passes the peak more
    slowly comes to it, if at all, by a ramp of his own. `cut` [1]: share of all this, for corners that are gone to.
    """
    steep = np.tan(0.5 * np.minimum(bend, _STEEPEST))
    square = np.maximum(opened * rounding, 1e-12)
    radius = rounding * np.cos(0.5 * bend) / np.maximum(steep, 1e-6)
    ramp = 2.0 * slow * radius / (3.0 * square)  # ξ that it reaches
    missing = ramp**2 - np.maximum(1.0 - peak**2 / square, 0.0) / 1.5
    begins = ramp - np.sqrt(np.maximum(missing, 0.0))
    fastest = np.sqrt(np.maximum(np.cbrt(speed**2 / square) ** 2 - 1.0, 0.0))
    ends = cut * np.minimum(np.minimum(ramp, steep), fastest)
    bends = (rounding > 0) & (missing >= 0.0) & (begins < ends)
    begins, ends = np.where(bends, begins, 0.0), np.where(bends, ends, 0.0)
    first, last = (np.sqrt(square) * (1.0 + tangent**2) ** 0.75 for tangent in (begins, ends))
    mean = sum(
        weight * (1.0 + (begins + share * (ends - begins)) ** 2) ** -0.25
        for share, weight in zip(_GAUSS, _WEIGHTS, strict=True)
    )
    seconds = radius * (ends - begins) / np.sqrt(square) * mean + (first - peak) / slow
    way = 0.5 * radius * (ends * np.sqrt(1.0 + ends**2) + np.arcsinh(ends))
    return np.where(bends, last, peak), _Bend(way, np.where(bends, seconds, 0.0))


def _above(acceleration: Floats, at_rest: Floats, share: Floats) -> Floats:
    """Acceleration (n,) of the part of a ramp above a `share` (n,) of its speed, where that next to rest is `at_rest`
    (n,) times that of the whole ramp.

    Of a force that changes evenly with the speed, 1/a = (1 + s v/V)/a0, ramps from rest have a0/(1 + s/3), those from
    f V on a0/(1 + s (1 + 2f)/3), both by the time that they take beyond their way at full speed.
    """
    return acceleration * at_rest / np.maximum(1.0 + (at_rest - 1.0) * (1.0 + 2.0 * share), _LEAST_ABOVE)


def _covered(low: Floats, high: Floats, slow: Floats, jerk: Floats) -> Floats:
    """(n,) [m] of a ramp between two speeds (n,) [m/s]: at the mean of both."""
    return np.asarray(0.5 * (low + high) * _ramp_between(low, high, slow, jerk))


def _ramp_between(low: Floats, high: Floats, slow: Floats, jerk: Floats) -> Floats:
    """Duration (n,) [s] of such a ramp."""
    return _ramp(np.maximum(high - low, 1e-12), slow, jerk)


def _reached(low: Floats, high: Floats, way: Floats, slow: Floats, jerk: Floats) -> Floats:
    """(n,) [m/s] `high`, or the speed that a ramp from `low` (n,) [m/s] reaches over the way (n,) [m]."""
    low, high, way, slow, jerk = np.broadcast_arrays(low, high, way, slow, jerk)
    beyond = _covered(low, np.maximum(high, low), slow, jerk) > way
    if not beyond.any():
        return high
    # In closed form where the ramp reaches its acceleration, h²/2a + b h/2 = rest with b = a/j; else by d = h - l from
    # s³ + 2 l s = way √j with s = √d (Cardano).
    build = slow / jerk
    square, rest = 0.5 * slow * build, low**2 - low * slow * build + 2.0 * slow * way
    reached = np.sqrt(np.maximum(square**2 + rest, 0.0)) - square
    half, third = 0.5 * way * np.sqrt(np.where(np.isfinite(jerk), jerk, 0.0)), 2.0 / 3.0 * low
    root = np.cbrt(half + np.sqrt(half**2 + third**3))
    short = low + (root - third / np.maximum(root, 1e-12)) ** 2
    full = reached - low >= slow * build
    return np.where(beyond, np.where(full, reached, short), high)


def _peak_between(
    first: Floats,
    last: Floats,
    top: Floats,
    way: Floats,
    slow: tuple[Floats, Floats],
    jerks: tuple[Floats, Floats],
) -> Floats:
    """(n,) [m/s] `top`, or the speed whose ramps, from the `first` and to the `last` (n,) [m/s], cover the way: where
    both reach their accelerations in closed form, else by bisection."""
    columns = np.broadcast_arrays(first, last, top, way, *slow, *jerks)
    first, last, top, way = columns[:4]
    top = np.maximum(top, np.maximum(first, last))

    def over(speed: Floats, first: Floats, last: Floats, way: Floats, *ramps: Floats) -> Floats:
        up, down, up_jerk, down_jerk = ramps
        return _covered(first, speed, up, up_jerk) + _covered(last, speed, down, down_jerk) - way

    beyond = over(top, first, last, way, *columns[4:]) > 0.0
    if not beyond.any():
        return top
    first, last, way, up, down, up_jerk, down_jerk = (
        column[beyond] for column in (first, last, way, *columns[4:])
    )
    build, brake = up / up_jerk, down / down_jerk
    square, line = 0.5 / up + 0.5 / down, 0.5 * (build + brake)
    rest = way + 0.5 * (first**2 / up + last**2 / down - first * build - last * brake)
    speed = (np.sqrt(np.maximum(line**2 + 4.0 * square * rest, 0.0)) - line) / (2.0 * square)
    bent = (speed - first < up * build) | (speed - last < down * brake)
    if bent.any():
        own = tuple(column[bent] for column in (first, last, way, up, down, up_jerk, down_jerk))
        low, high = np.maximum(own[0], own[1]), top[beyond][bent]
        for _ in range(_HALVINGS):
            middle = 0.5 * (low + high)
            longer = over(middle, *own) > 0.0
            low, high = np.where(longer, low, middle), np.where(longer, middle, high)
        speed[bent] = low
    found = top.copy()
    found[beyond] = speed
    return found


def _ramp(speed: Floats, acceleration: Floats, jerk: Floats) -> Floats:
    """Duration (n,) [s] of a ramp from rest to a speed."""
    plain = speed / acceleration
    if not np.isfinite(jerk).any():
        return plain
    reached = speed * jerk >= acceleration**2
    return np.asarray(np.where(reached, plain + acceleration / jerk, 2.0 * np.sqrt(speed / jerk)))
