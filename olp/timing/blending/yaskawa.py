"""Yaskawa position levels: two neighbouring moves run at once and their displacements add."""

from __future__ import annotations

from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from olp.timing.blending._overlap import Overlap, OverlappingLaw
from olp.timing.blending.law import Corners, Passage
from olp.timing.motion.model import ModelParameter

Floats = NDArray[np.float64]

STOP_TIME = 0.166  # [s] DX200 and MA2010, PL runs at 10 mm/s
FILTER_TIME = (
    0.15  # [s] of the acceleration filter of a DX200 and MA2010, whose robot file says how it was measured
)
SERVO_LAG = 0.043  # [s] DX200 and MA2010, corner runs at 50 to 800 mm/s (docs/blending.md)
_CORNER_RUNS = "published DX200 recordings of an MA2010, corner at 50 to 800 mm/s; shapes only, not times"


class PositionLevels(OverlappingLaw):
    """With a position level PL = 1 to 8 the next move begins while `z` of this one is left.

    Over the next z/V seconds its commanded speed rises evenly from nothing to its full speed, while this move
    still runs at V to its end. So the corner saves z/(2V), the tool reaches up to twice its speed where the
    path goes straight on, and with u from 0 to 1 passes corner - z (1 - u) d1 + z u²/2 d2. `z` is the level's
    zone, at most half of the shorter neighbour.

    Both commands then go through the acceleration filter (a moving average) and the lag of the servo, which
    round the shape and cost nothing at a corner. Dense points: between the end of the move before and the begin of
    the move after, a move runs alone for at least half of what an exact stop costs (`alone`); else the move after
    waits.
    Inferred from one spacing, 49 lines of 2.04 mm at 10 mm/s; never slower than without overlap.
    """

    summary = "Yaskawa position levels: the next move begins a zone before the point"
    source = (
        "published DX200 recordings of an MA2010 at 10 mm/s, PL 0 to 8, fitted on one of four tests; zones "
        "per controller from SC.PRM"
    )
    amount = "zone of the position level [m]"
    measured = True
    runs_at_once = True
    parameters: ClassVar[tuple[ModelParameter, ...]] = (
        ModelParameter(
            "stop_time",
            "s",
            STOP_TIME,
            "what an exact stop costs: published DX200 recordings of an MA2010, PL runs `linear`: 0.1655 s",
        ),
        ModelParameter("acceleration_time", "s", FILTER_TIME, _CORNER_RUNS),
        ModelParameter("servo_lag", "s", SERVO_LAG, _CORNER_RUNS),
    )

    @property
    def alone(self) -> float:
        """Minimum time [s] for which each move runs without its neighbours."""
        return self._value("stop_time") / 2

    def passage(self, corners: Corners) -> Passage:
        zone = np.minimum(corners.amount, corners.half)
        duration = zone / corners.speed_before
        return Passage(
            trim_before=zone,
            trim_after=corners.speed_after * duration / 2,
            duration=duration,
            speed_in=corners.speed_before,
            speed_out=corners.speed_after,
            capped=corners.amount > corners.half,
        )

    def _overlap(self, corners: Corners) -> Overlap:
        ramp = np.minimum(corners.amount, corners.half) / corners.speed_before
        window = filter_times(corners, self._value("acceleration_time"))
        return Overlap(
            speed_before=corners.speed_before,
            drop=ramp,
            fall=window,
            speed_after=corners.speed_after,
            start=np.zeros_like(ramp),
            ramp=ramp,
            rise=window,
            lag=self._value("servo_lag"),
        )


def intervals(
    length: Floats, speed: Floats, zone_in: Floats, zone_out: Floats, speed_before: Floats, alone: float
) -> Floats:
    """Time [s] (n,) from the start of each move of a chain to that of the next; of the last, to its end.

    A move speeds up over `zone_in` [m] at `speed_before` [m/s], and the next one starts where `zone_out` [m] of its
    `length` is left, or later if it has not run `alone` [s] yet (see `delays`).
    """
    ramp = np.divide(zone_in, speed_before, out=np.zeros_like(zone_in), where=zone_in > 0)
    return (
        length / speed + ramp / 2 + delays(length / speed, ramp, zone_out / speed, alone) - zone_out / speed
    )


def delays(cruise: Floats, ramp: Floats, overlap: Floats, alone: float) -> Floats:
    """Delay [s] (n,) at the end of each move of a chain that lets it run for `alone` [s] without its neighbours.

    `cruise`: length over speed; `ramp`: how long the move before still runs; `overlap`: how long the next one would
    run at the same time [s]. A delay is at most what the overlap saves, as more has not been measured.
    """
    lacking = np.where((ramp > 0) & (overlap > 0), alone + overlap + ramp / 2 - cruise, 0.0)
    if not (lacking > 0).any():
        return np.zeros_like(cruise)
    delay, result = 0.0, []
    for lack, saved in zip(lacking.tolist(), (overlap / 2).tolist(), strict=True):
        # A move that began late itself has the end of the one before earlier in its own time.
        delay = min(max(lack - delay, 0.0), saved)
        result.append(delay)
    return np.array(result)


def filter_times(corners: Corners, shortest: float) -> Floats:
    """Acceleration time [s] (n,), at least `shortest`, longer where the acceleration limits require it. Both moves
    share one filter.
    """
    needed = np.maximum(
        corners.speed_before / corners.deceleration, corners.speed_after / corners.acceleration
    )
    result: Floats = np.maximum(needed, shortest)
    return result
