"""FANUC termination type CNT 0 to 100: the next move begins while this one brakes."""

from __future__ import annotations

from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from olp.timing.blending._overlap import Overlap, OverlappingLaw
from olp.timing.blending.law import Corners, Passage
from olp.timing.motion.model import ModelParameter

Floats = NDArray[np.float64]


class Continuous(OverlappingLaw):
    """CNT100 begins the next move when this one begins to brake, CNT0 when it has braked to rest, others in
    proportion.

    Braking takes f = V1/d and speeding up r = V2/a, neither less than the acceleration time, and neither so
    long that it takes more than half of its move. Displacements add. With CNT as a share c the corner loses (1
    - c) f + (r - f)/2 over passing the point at full speed; it is passed further away the faster the robot
    goes, as FANUC's manuals say of CNT (they give no distance). FINE is an exact stop, not CNT0: it also waits
    until the arm is in position.

    Not measured: that the displacements add, and that the begin is in proportion, is taken over from how
    braking and accelerating segments overlap in the manuals' figures and from Yaskawa's measured filter.
    """

    summary = "FANUC CNT 0..100: the share of the braking phase that overlaps with the next move"
    source = "FANUC operator's manuals, termination types FINE and CNT (figures); superposition inferred, not measured"
    share_zones = True
    amount = "CNT as a share, 0 to 1 (CNT100 is 1)"
    parameters: ClassVar[tuple[ModelParameter, ...]] = (
        ModelParameter(
            "acceleration_time", "s", 0.1, "assumed: the least time to full speed; no recording is known"
        ),
    )

    def passage(self, corners: Corners) -> Passage:
        overlap = self._overlap(corners)
        duration = np.maximum(overlap.fall, overlap.start + overlap.rise)
        return Passage(
            trim_before=corners.speed_before * overlap.fall / 2,
            trim_after=corners.speed_after * (duration - overlap.start - overlap.rise / 2),
            duration=duration,
            speed_in=corners.speed_before,
            speed_out=corners.speed_after,
            capped=np.zeros(len(corners), dtype=bool),
        )

    def _overlap(self, corners: Corners) -> Overlap:
        least = self._value("acceleration_time")
        fall = np.maximum(corners.speed_before / corners.deceleration, least)
        rise = np.maximum(corners.speed_after / corners.acceleration, least)
        # V f / 2 is what braking takes of the move: half of the move is free for this corner, half for the other one.
        fall = np.maximum(np.minimum(fall, corners.before / corners.speed_before), 1e-9)
        rise = np.maximum(np.minimum(rise, corners.after / corners.speed_after), 1e-9)
        now = np.zeros(len(corners))
        share = np.clip(corners.amount, 0.0, 1.0)
        # A short next move at full speed before the braking ends: no more than its half may pass meanwhile.
        room = corners.after / (2 * corners.speed_after) + rise / 2
        with np.errstate(divide="ignore"):
            fall = np.minimum(fall, np.where(share > 0, room / share, np.inf))
        return Overlap(
            speed_before=corners.speed_before,
            drop=now,
            fall=fall,
            speed_after=corners.speed_after,
            start=(1.0 - share) * fall,
            ramp=now,
            rise=rise,
            lag=0.0,
        )
