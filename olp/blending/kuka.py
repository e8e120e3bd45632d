"""KUKA approximate positioning, $APO: where it begins is the program's, how the corner is passed is a parabola."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from olp.blending._parabola import ParabolicLaw

Floats = NDArray[np.float64]


class Approximation(ParabolicLaw):
    """LIN and CIRC with C_DIS, C_VEL or C_ORI, PTP with C_PTP, brought to one number: the distance at which it
    begins.

    The beginning is "at the earliest" where the programmed criterion is met, and never before half of the move:
    the shortest of the criterion's distance and of the halves of both neighbours counts, on both sides (CP-CP
    approximation evaluates the smaller radius). That the curve between is a parabola is how KUKA's manuals draw
    it; its speed is not stated.
    """

    summary = "KUKA approximate positioning C_DIS, C_VEL, C_ORI, C_PTP: a parabola within the approximation distance"
    source = "KUKA mxAutomation and KSS manuals: APO structure (CPTP, CDIS, CORI, CVEL). Not measured"
    amount = "approximation distance [m], see from_distance, from_speed, from_angle, from_share"


def from_distance(cdis: ArrayLike) -> Floats:
    """C_DIS: $APO.CDIS [m] from the target point."""
    return np.asarray(cdis, dtype=np.float64)


def from_speed(cvel: ArrayLike, speed: ArrayLike, deceleration: ArrayLike) -> Floats:
    """C_VEL: [m] left when braking from `speed` [m/s] at `deceleration` [m/s²] reaches the share $APO.CVEL (0 to 1)."""
    result: Floats = (np.asarray(cvel) * np.asarray(speed)) ** 2 / (2 * np.asarray(deceleration))
    return result


def from_angle(cori: ArrayLike, angle: ArrayLike, length: ArrayLike) -> Floats:
    """C_ORI: [m] left of `length` [m] when $APO.CORI [rad] of the whole reorientation `angle` [rad] is left."""
    turned = np.asarray(angle, dtype=np.float64)
    share = np.divide(cori, turned, out=np.ones(np.broadcast(cori, turned).shape), where=turned > 0)
    result: Floats = np.minimum(share, 1.0) * np.asarray(length)
    return result


def from_share(cptp: ArrayLike, length: ArrayLike) -> Floats:
    """C_PTP: share $APO.CPTP (0 to 1) of the greatest distance, which is half of the move of `length` [m or rad]."""
    result: Floats = 0.5 * np.asarray(cptp) * np.asarray(length)
    return result
