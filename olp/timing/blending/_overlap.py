"""Two moves that run at once for a while and whose displacements add; each starts and stops through a filter.

The filter is a moving average over the acceleration time w, which turns a step of speed into a straight ramp,
and then a lag of first order, the position loop of the servo. Both are linear, so every response is known in
closed form.
"""

from __future__ import annotations

from abc import abstractmethod
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from olp.timing.blending.law import BlendingLaw, Corners

Floats = NDArray[np.float64]
_LAGS = 6.0  # after six time constants 0.25 % of a lag is left


@dataclass(frozen=True, slots=True)
class Overlap:
    """Timing of n overlapping corners, (n,) each [s] from the start of the corner. The speed of the move before
    falls to zero from `drop` on; the move after begins at `start` and its command rises over `ramp`; `fall` and
    `rise` are their filter times, `lag` that of the servo.
    """

    speed_before: Floats  # [m/s]
    drop: Floats  # [s]
    fall: Floats  # [s], > 0
    speed_after: Floats  # [m/s]
    start: Floats  # [s]
    ramp: Floats  # [s], 0 for a command that steps
    rise: Floats  # [s], > 0
    lag: float  # [s], >= 0

    @property
    def span(self) -> Floats:
        """Time [s] until both moves have settled."""
        last: Floats = (
            np.maximum(self.drop + self.fall, self.start + self.ramp + self.rise) + _LAGS * self.lag
        )
        return last

    def position(self, time: Floats) -> Floats:
        """Position (x, y) [m], (n, m, 2), at `time` (n, m) [s]."""
        u = time - self.drop[:, None]
        steady = u - (self.fall / 2 + self.lag)[:, None]
        x = self.speed_before[:, None] * (steady - response(1, u, self.fall, self.lag))
        return np.stack([x, self._after(1, time)], axis=-1)

    def velocity(self, time: Floats) -> Floats:
        """Velocity (x, y) [m/s], (n, m, 2), at `time` (n, m) [s]."""
        u = time - self.drop[:, None]
        x = self.speed_before[:, None] * (1.0 - response(0, u, self.fall, self.lag))
        return np.stack([x, self._after(0, time)], axis=-1)

    def _after(self, order: int, time: Floats) -> Floats:
        u = time - self.start[:, None]
        ramp = self.ramp[:, None]
        step = response(order, u, self.rise, self.lag)
        with np.errstate(divide="ignore", invalid="ignore"):
            rise = response(order + 1, u, self.rise, self.lag) - response(
                order + 1, u - ramp, self.rise, self.lag
            )
            ramped = rise / ramp
        result: Floats = self.speed_after[:, None] * np.where(ramp > 0, ramped, step)
        return result


def response(order: int, time: Floats, window: Floats, lag: float) -> Floats:
    """Response (n, m) of the moving average `window` (n,) and the lag to t^order / order! for t > 0."""
    w = window[:, None]
    result: Floats = (_lagged(order + 1, time, lag) - _lagged(order + 1, time - w, lag)) / w
    return result


def _lagged(order: int, time: Floats, lag: float) -> Floats:
    """Response y of a first-order lag to t^order / order!: lag y' + y = command, and y' is the response one order
    lower.
    """
    t = np.maximum(time, 0.0)
    if lag == 0.0:
        return _power(order, t)
    answer: Floats = -np.expm1(-t / lag)
    for k in range(1, order + 1):
        answer = _power(k, t) - lag * answer
    return answer


def _power(order: int, t: Floats) -> Floats:
    result = np.ones_like(t)
    for k in range(1, order + 1):
        result = result * t / k
    return result


# --- Overlapping ---
# The base of the laws in which both moves run at once: their shape is that of an Overlap.


class OverlappingLaw(BlendingLaw):
    """A law that says when the two moves overlap; the position of the tool follows from that."""

    @abstractmethod
    def _overlap(self, corners: Corners) -> Overlap:
        """When each move of each corner fades out and in."""

    def span(self, corners: Corners) -> Floats:
        return self._overlap(corners).span

    def position(self, corners: Corners, time: Floats) -> Floats:
        return self._overlap(corners).position(time)

    def velocity(self, corners: Corners, time: Floats) -> Floats:
        return self._overlap(corners).velocity(time)
