"""A corner rounded by an arc of given radius that touches both moves."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from olp.timing.blending.law import BlendingLaw, Corners, Passage

Floats = NDArray[np.float64]
_STRAIGHT = 1e-6  # [rad] a turn below this is what rounding leaves of none


class CornerRadius(BlendingLaw):
    """Geometry alone: the arc touches both moves at R tan(turn/2) from the corner point and passes it at R
    (1/cos(turn/2) - 1).

    The tool keeps the lower of both speeds, at most sqrt(a R), its acceleration towards the centre. R shrinks where
    it would touch a move beyond its half. A straight continuation has no corner to round; a reversal has no arc and
    is a stop.
    """

    summary = "an arc of given radius that touches both moves, at constant speed"
    source = "geometry; INFORM's corner radius tag CR= and FANUC's CR are of this kind. Not measured"
    amount = "radius of the arc [m]"

    def passage(self, corners: Corners) -> Passage:
        radius, tangent, speed, capped = self._arc(corners)
        duration = np.divide(radius * corners.turn, speed, out=np.zeros_like(speed), where=speed > 0)
        return Passage(tangent, tangent, duration, speed, speed, capped)

    def span(self, corners: Corners) -> Floats:
        return self.passage(corners).duration

    def position(self, corners: Corners, time: Floats) -> Floats:
        radius, tangent, speed, _ = self._arc(corners)
        angle = self._angle(corners, radius, speed, time)
        sine = np.maximum(np.sin(corners.turn), 1e-12)[:, None]
        turn, r = corners.turn[:, None], radius[:, None]
        # The tangent turns from d1 to d2: its parts along them are sin(turn - angle) and sin(angle) over sin(turn).
        x = -tangent[:, None] + r * (np.cos(turn - angle) - np.cos(turn)) / sine
        y = r * (1 - np.cos(angle)) / sine
        return np.stack([x, y], axis=-1)

    def velocity(self, corners: Corners, time: Floats) -> Floats:
        radius, _, speed, _ = self._arc(corners)
        angle = self._angle(corners, radius, speed, time)
        sine, turn = np.sin(corners.turn)[:, None], corners.turn[:, None]
        straight = sine < 1e-9
        sine = np.where(straight, 1.0, sine)
        x = np.where(straight, 1.0, np.sin(turn - angle) / sine)
        y = np.where(straight, 0.0, np.sin(angle) / sine)
        result: Floats = speed[:, None, None] * np.stack([x, y], axis=-1)
        return result

    def _arc(self, corners: Corners) -> tuple[Floats, Floats, Floats, NDArray[np.bool_]]:
        """Radius [m], tangent [m], speed [m/s], and whether the radius had to shrink."""
        slope = np.tan(np.minimum(corners.turn, np.pi * (1 - 1e-9)) / 2)
        with np.errstate(divide="ignore"):
            room = np.where(slope > 1e-12, corners.half / np.maximum(slope, 1e-300), np.inf)
        radius = np.minimum(corners.amount, room)
        limit = np.minimum(corners.deceleration, corners.acceleration)
        with np.errstate(invalid="ignore"):
            most = np.where(slope > _STRAIGHT, np.where(radius > 1e-12, np.sqrt(limit * radius), 0.0), np.inf)
        speed = np.minimum(np.minimum(corners.speed_before, corners.speed_after), most)
        back = corners.turn > np.pi * (1 - 1e-6)
        radius, speed = np.where(back, 0.0, radius), np.where(back, 0.0, speed)
        return radius, radius * slope, speed, corners.amount > room

    def _angle(self, corners: Corners, radius: Floats, speed: Floats, time: Floats) -> Floats:
        rate = np.divide(speed, radius, out=np.zeros_like(speed), where=radius > 1e-12)
        result: Floats = np.minimum(rate[:, None] * time, corners.turn[:, None])
        return result
