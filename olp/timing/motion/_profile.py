"""Answer of a motion model: for every move, phases of constant jerk, which can be evaluated at any time.

All quantities are SI: lengths [m] (or [rad] for an axis), speeds [m/s], accelerations [m/s²], jerks [m/s³].
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, fields, replace
from enum import IntEnum
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

Floats = NDArray[np.float64]
Bools = NDArray[np.bool_]

ROUNDING = 1e-10  # a length missing by less than this fraction is rounding, not a move that is too short


class Problem(IntEnum):
    """Why a move could not be made as requested. The profile then holds the nearest motion that is possible."""

    NONE = 0
    NO_SPEED = 1  # a positive length without speed or acceleration: the move never ends, its duration is inf
    CANNOT_BRAKE = 2  # too short to brake to the end speed: `end_speed` holds the lowest one that can be had
    CANNOT_REACH = 3  # too short, or limited too low, for the end speed: `end_speed` holds the highest one

    @property
    def says(self) -> str:
        """The problem in words, for a diagnostic."""
        return _SAYS[self]


_SAYS = {
    Problem.NONE: "the move is possible as asked",
    Problem.NO_SPEED: "the move has a length but no speed or no acceleration, so it never ends",
    Problem.CANNOT_BRAKE: "the move is too short to brake to the speed asked for at its end",
    Problem.CANNOT_REACH: "the move cannot gain the speed asked for at its end",
}


@dataclass(frozen=True, slots=True)
class RequestedMoves:
    """Input of a motion model, one row per move; every array has shape (n,)."""

    length: Floats  # [m]
    speed: Floats  # programmed speed [m/s]
    acceleration: Floats  # [m/s²], > 0
    deceleration: Floats  # [m/s²], > 0
    start_speed: Floats  # [m/s]
    end_speed: Floats  # wanted [m/s]


@dataclass(frozen=True, slots=True)
class Profile:
    """Speed over time of n moves, each made of p phases of constant jerk.

    Evaluating functions take times of shape (n,) (one instant per move) or (n, m) (m instants per move) and return
    the same shape. Before its start and after its end a move stays in its first and last state.
    """

    moves: RequestedMoves  # what was asked
    phases: tuple[str, ...]  # the p names
    durations: Floats  # [s], (n, p)
    accelerations: Floats  # at each phase's start [m/s²], (n, p)
    jerks: Floats  # [m/s³], (n, p)
    starts: Floats  # time at each phase's start, and the end [s], (n, p + 1)
    positions: Floats  # at each phase's start, and at the end [m], (n, p + 1)
    speeds: Floats  # at each phase's start, and at the end [m/s], (n, p + 1)
    reached: Bools  # the programmed speed was reached, (n,)
    problem: NDArray[np.int8]  # `Problem` per move, (n,)

    @classmethod
    def build(
        cls,
        moves: RequestedMoves,
        phases: tuple[str, ...],
        durations: Floats,
        accelerations: Floats,
        jerks: Floats,
        problem: NDArray[np.int8],
    ) -> Profile:
        """A profile from its phases, shape (n, p) each: speeds and positions follow by exact integration."""
        step = np.where(np.isfinite(durations), durations, 0.0)
        n, p = step.shape
        starts, speeds, positions = np.zeros((3, n, p + 1))
        speeds[:, 0] = moves.start_speed
        for k in range(p):
            t, a, j = step[:, k], accelerations[:, k], jerks[:, k]
            speeds[:, k + 1] = speeds[:, k] + t * (a + t * j / 2)
            positions[:, k + 1] = positions[:, k] + t * (speeds[:, k] + t * (a / 2 + t * j / 6))
            starts[:, k + 1] = starts[:, k] + durations[:, k]
        reached = (speeds.max(axis=1) >= moves.speed * (1 - 1e-12)) & (problem != Problem.NO_SPEED)
        return cls(
            moves, phases, durations, accelerations, jerks, starts, positions, speeds, reached, problem
        )

    def take(self, rows: NDArray[np.intp]) -> Profile:
        """The profiles of these rows, in their order, repeats allowed."""
        moves = RequestedMoves(
            *(getattr(self.moves, name)[rows] for name in RequestedMoves.__dataclass_fields__)
        )
        columns = {f.name: getattr(self, f.name) for f in fields(self)}
        picked: dict[str, Any] = {k: v[rows] for k, v in columns.items() if isinstance(v, np.ndarray)}
        return replace(self, moves=moves, **picked)

    @property
    def duration(self) -> Floats:
        """Time from start to end [s], (n,); inf where the move never ends."""
        return self.starts[:, -1]

    @property
    def peak_speed(self) -> Floats:
        """Highest speed of each move [m/s], (n,)."""
        peak: Floats = self.speeds.max(axis=1)
        return peak

    @property
    def end_speed(self) -> Floats:
        """Speed at the end [m/s], (n,): the requested one unless `problem` says otherwise."""
        return self.speeds[:, -1]

    @property
    def feasible(self) -> Bools:
        """True where the move is made exactly as requested, (n,)."""
        feasible: Bools = self.problem == Problem.NONE
        return feasible

    def position(self, t: ArrayLike) -> Floats:
        """Distance covered [m] at time t [s], (n,) or (n, m)."""
        return self._at(t, lambda s, v, a, j, u: s + u * (v + u * (a / 2 + u * j / 6)))

    def speed(self, t: ArrayLike) -> Floats:
        """Speed [m/s] at time t [s], (n,) or (n, m)."""
        return self._at(t, lambda s, v, a, j, u: v + u * (a + u * j / 2))

    def acceleration(self, t: ArrayLike) -> Floats:
        """Acceleration [m/s²] at time t [s], (n,) or (n, m)."""
        return self._at(t, lambda s, v, a, j, u: a + u * j)

    def jerk(self, t: ArrayLike) -> Floats:
        """Jerk [m/s³] at time t [s], (n,) or (n, m)."""
        return self._at(t, lambda s, v, a, j, u: j + 0.0 * u)

    def time_at(self, position: ArrayLike) -> Floats:
        """Time [s] at which a distance [m] is first covered, (n,) or (n, m); the inverse of `position`."""
        wanted, flat = self._rows(position)
        wanted = np.clip(wanted, 0.0, self.positions[:, -1:])
        row = np.arange(len(wanted))[:, None]
        k = (wanted[:, :, None] > self.positions[:, None, 1:-1]).sum(axis=2)
        s, v = self.positions[row, k], self.speeds[row, k]
        a, j, end = self.accelerations[row, k], self.jerks[row, k], self.durations[row, k]
        low, high = np.zeros_like(wanted), np.where(np.isfinite(end), end, 0.0)
        # Speed is never negative, so the position grows with time and halving the phase finds the instant.
        for _ in range(60):
            middle = (low + high) / 2
            before = s + middle * (v + middle * (a / 2 + middle * j / 6)) < wanted
            low, high = np.where(before, middle, low), np.where(before, high, middle)
        answer: Floats = self.starts[row, k] + high
        return answer[:, 0] if flat else answer

    def defects(self, tolerance: float = 1e-9) -> Bools:
        """True where a move misses its target or breaks a limit, (n,): the check that every answer has to pass.

        Inside a phase the acceleration is linear and does not change sign, so acceleration and speed have their
        extremes at the phases' ends: checking these checks everything.
        """
        m, p = self.moves, self.problem
        step = np.where(np.isfinite(self.durations), self.durations, 0.0)
        last = self.accelerations + step * self.jerks
        length = m.length + step.sum(axis=1) * m.start_speed
        fast = np.maximum(m.speed, m.start_speed)
        steep = np.maximum(m.acceleration, m.deceleration)
        moved = np.abs(self.positions[:, -1] - m.length) > tolerance * length
        ended = np.abs(self.end_speed - m.end_speed) > tolerance * np.maximum(fast, m.end_speed)
        bad: Bools = (moved & (p != Problem.NO_SPEED)) | (ended & (p == Problem.NONE))
        bad |= (step < 0).any(axis=1)
        bad |= (self.speeds > (fast * (1 + tolerance))[:, None]).any(axis=1)
        bad |= (self.speeds < -tolerance * fast[:, None]).any(axis=1)
        for a in (self.accelerations, last):
            bad |= (a > (m.acceleration * (1 + tolerance))[:, None]).any(axis=1)
            bad |= (a < -(m.deceleration * (1 + tolerance))[:, None]).any(axis=1)
        turns = np.minimum(self.accelerations * last, 0.0) < -tolerance * (steep**2)[:, None]
        return bad | turns.any(axis=1) | np.isnan(self.durations).any(axis=1)

    def _rows(self, values: ArrayLike) -> tuple[Floats, bool]:
        """Values as (n, m), and whether they were given as one per move."""
        array = np.asarray(values, dtype=np.float64)
        flat = array.ndim < 2
        n = len(self.durations)
        rows = np.broadcast_to(array, (n,))[:, None] if flat else array
        return np.broadcast_to(rows, (n, rows.shape[1])), flat

    def _at(self, t: ArrayLike, formula: Callable[..., Any]) -> Floats:
        times, flat = self._rows(t)
        times = np.clip(times, 0.0, self.starts[:, -1:])
        row = np.arange(len(times))[:, None]
        k = (times[:, :, None] >= self.starts[:, None, 1:-1]).sum(axis=2)
        u = times - self.starts[row, k]
        state = (self.positions[row, k], self.speeds[row, k], self.accelerations[row, k], self.jerks[row, k])
        answer: Floats = np.asarray(formula(*state, u), dtype=np.float64)
        return answer[:, 0] if flat else answer
