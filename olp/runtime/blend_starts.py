"""Where a blend begins that is programmed as a distance, a speed, an angle or a share: as a distance before the target.

After KUKA mxAutomation and KSS manuals: APO structure (CPTP, CDIS, CORI, CVEL). Not measured.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

Floats = NDArray[np.float64]


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
