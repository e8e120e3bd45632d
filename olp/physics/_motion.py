"""The time law that all terms of moves act on: ramps at both ends, a speed between, and what is added.

A ramp from rest to v with acceleration a and jerk j takes v/a + a/j (or 2 √(v/j) when a is not reached) and covers
v/2 of that time; `share` of a ramp is paid where a corner is not an exact stop. With ways that are too short, the
peak speed is the one whose ramps cover the way (L. Biagiotti and C. Melchiorri, Trajectory Planning for Automatic
Machines and Robots, Springer 2008, sections 3.2 and 3.4).
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

_STEPS = 25  # of the bisection for the peak speed: a factor of 3e-8


@dataclass(frozen=True, slots=True, eq=False)
class Motion:
    """n moves; units of a way are metres, or radians of the leading axis in joint moves."""

    way: Floats  # (n,) [m | rad]; 0 for waits
    speed: Floats  # (n,) [m/s | rad/s]
    accelerate: Floats  # (n,) [m/s² | rad/s²]
    decelerate: Floats  # (n,)
    jerk: Floats  # (n,) [m/s³ | rad/s³], inf: none
    share_start: Floats  # (n,) [1] of the ramp that is paid at the start; 1 from an exact stop
    share_end: Floats  # (n,)
    least: Floats  # (n,) [s] that the move takes whatever the ways says
    added: Floats  # (n,) [s]
    rate: Floats  # (n,) [1] by which whole durations are longer
    cycle: float = 0.0  # [s] of which whole durations are multiples; 0: not

    def with_(self, **changes: Floats | float) -> Motion:
        return replace(self, **changes)  # type: ignore[arg-type]

    def duration(self) -> Floats:
        """(n,) [s] before `rate` and `cycle`, which hold for whole durations."""
        return np.asarray(np.maximum(self._travel(), self.least) + self.added)

    def _travel(self) -> Floats:
        """(n,) [s] of the way alone."""
        speed, ramps = self.speed, self._ramps(self.speed)
        short = np.nonzero(speed * ramps > self.way)[0]
        if len(short):
            speed = speed.copy()
            speed[short] = self.take(short)._peak()
            ramps = self._ramps(speed)
        moving = self.way > 0
        return np.where(moving, self.way / np.where(moving, speed, 1.0) + ramps, 0.0)

    def _ramps(self, speed: Floats) -> Floats:
        """(n,) [s] half the ramps' time: what they cost beyond the way at full speed."""
        start = _ramp(speed, self.accelerate, self.jerk) * self.share_start
        end = _ramp(speed, self.decelerate, self.jerk) * self.share_end
        return np.asarray(0.5 * (start + end))

    def _peak(self) -> Floats:
        """(n,) [m/s] whose ramps cover the way exactly."""
        slow = 0.5 * (self.share_start / self.accelerate + self.share_end / self.decelerate)
        high = np.minimum(self.speed, np.sqrt(self.way / np.maximum(slow, 1e-12)))
        if not np.isfinite(self.jerk).any():
            return high
        low = np.zeros_like(high)
        for _ in range(_STEPS):
            middle = 0.5 * (low + high)
            over = middle * self._ramps(middle) > self.way
            high, low = np.where(over, middle, high), np.where(over, low, middle)
        return 0.5 * (low + high)

    def take(self, rows: NDArray[np.intp]) -> Motion:
        """Some of the moves."""
        parts = {name: getattr(self, name)[rows] for name in _COLUMNS}
        return Motion(cycle=self.cycle, **parts)


_COLUMNS = tuple(name for name in Motion.__slots__ if name != "cycle")


def _ramp(speed: Floats, acceleration: Floats, jerk: Floats) -> Floats:
    """(n,) [s] from rest to a speed."""
    plain = speed / acceleration
    if not np.isfinite(jerk).any():
        return plain
    reached = speed * jerk >= acceleration**2
    return np.asarray(np.where(reached, plain + acceleration / jerk, 2.0 * np.sqrt(speed / jerk)))
