"""Moves that are neither stopped nor given a zone: only the controller's acceleration filter rounds the corner."""

from __future__ import annotations

from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from olp.timing.blending._overlap import Overlap, OverlappingLaw
from olp.timing.blending.law import Corners, Passage
from olp.timing.blending.yaskawa import FILTER_TIME, SERVO_LAG, filter_times
from olp.timing.motion.model import ModelParameter

Floats = NDArray[np.float64]


class AccelerationFilter(OverlappingLaw):
    """The next move begins when the command of this one ends; the filter lets one fall while the other rises.

    A moving average over the acceleration time w turns each step of commanded speed into a straight ramp of w,
    whatever the speed, and the servo follows with a lag. The corner costs no time, and its size grows with the
    speed: without the lag the tool passes the corner point at V w/4 sin(turn/2), and the lag adds to that; with
    the measured numbers V x 25 ms at a turn of 60 degrees. Where V/w is more than the acceleration limits
    allow, w grows to V/limit.

    This is a Yaskawa move without a PL tag as measured, and the neutral choice where a program says only
    "continue".
    """

    summary = "no zone: the acceleration filter rounds the corner, in proportion to the speed"
    source = "published DX200 recordings of an MA2010: a turn of 60 degrees at 50, 100, 200, 400 and 800 mm/s"
    amount = "nothing: not used"
    measured = True
    parameters: ClassVar[tuple[ModelParameter, ...]] = (
        ModelParameter("acceleration_time", "s", FILTER_TIME, "published DX200 recordings of an MA2010"),
        ModelParameter(
            "servo_lag", "s", SERVO_LAG, "published DX200 recordings of an MA2010: corner at 50 to 800 mm/s"
        ),
    )

    def passage(self, corners: Corners) -> Passage:
        window = filter_times(corners, self._value("acceleration_time"))
        return Passage(
            trim_before=corners.speed_before * window / 2,
            trim_after=corners.speed_after * window / 2,
            duration=window,
            speed_in=corners.speed_before,
            speed_out=corners.speed_after,
            capped=np.zeros(len(corners), dtype=bool),
        )

    def _overlap(self, corners: Corners) -> Overlap:
        window = filter_times(corners, self._value("acceleration_time"))
        now = np.zeros(len(corners))
        return Overlap(
            speed_before=corners.speed_before,
            drop=now,
            fall=window,
            speed_after=corners.speed_after,
            start=now,
            ramp=now,
            rise=window,
            lag=self._value("servo_lag"),
        )
