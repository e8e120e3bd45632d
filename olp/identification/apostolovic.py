"""The equations of Apostolovic's thesis that turn a measured time into a corrected acceleration.

N. Apostolovic, "An innovative method for improvement of robotic simulation cycle time accuracy", Memorial
University of Newfoundland, chapters 5 and 6. Misprints and limits of the equations: docs/thesis.md.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

Floats = NDArray[np.float64]


def bearing(along: ArrayLike, across: ArrayLike) -> Floats:
    """Direction [rad] of a move in its test plane (5.2): the arc tangent of `across / along` [m], any shape.

    Horizontal tests: along = change of X, across = change of Y. Downward test: along = change of Z, across =
    change of Y, so the "incline" is measured from the vertical. A move and its way back have the same bearing.
    """
    return np.asarray(np.arctan(np.divide(across, along)))


def adjusted_acceleration(duration: ArrayLike, length: ArrayLike, speed: ArrayLike) -> Floats:
    """Acceleration [m/s²] with which constant acceleration takes `duration` [s] for `length` [m] (6.1).

    Holds for a trapezoid, that is up to duration 2 length / speed; beyond it the speed is not reached and the
    triangle's 4 length / duration² takes over. Not a number where the duration is at most length / speed: no
    acceleration makes a move that fast. Any broadcastable shapes.
    """
    time, way, top = (np.asarray(x, dtype=np.float64) for x in (duration, length, speed))
    spare = time * top - way
    with np.errstate(divide="ignore", invalid="ignore"):
        trapezoid = np.where(spare > 0, top**2 / spare, np.nan)
        return np.where(spare > way, 4 * way / time**2, trapezoid)


def correction_factor(adjusted: ArrayLike, nominal: ArrayLike) -> Floats:
    """Adjusted over nominal acceleration, C_H (6.2) or C_V (6.4) [1], any broadcastable shapes."""
    return np.divide(adjusted, nominal, dtype=np.float64)


def interpolated_factor(angle: ArrayLike, angles: ArrayLike, factors: ArrayLike) -> Floats:
    """Factor [1] at `angle` [rad] between the neighbours in a table with rising `angles`, shape (k,) (6.3).

    Not a number outside the table: the equation has no neighbours there.
    """
    at, known, table = (np.asarray(x, dtype=np.float64) for x in (angle, angles, factors))
    return np.asarray(np.interp(at, known, table, left=np.nan, right=np.nan))
