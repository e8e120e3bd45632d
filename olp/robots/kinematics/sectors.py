"""How far axes have turned, said by sectors: signs (KUKA), quarters (ABB), numbers of turns (FANUC)."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from olp.robots.kinematics.configuration import TURN_AXES, Flags, apply_turns, turn_centres, wrap
from olp.robots.model import Robot

Array = NDArray[np.float64]
Sectors = Sequence[tuple[int, float, float]]  # axis, from [rad], to below [rad]

QUARTER = 0.5 * math.pi
_TURN = 2.0 * math.pi
_EDGE = 1e-6  # [rad] an axis on the edge of a sector is in both
_TURNS = (0, 1, -1, 2, -2)


def turned_into(robot: Robot, joints: Array, sectors: Sectors) -> Array:
    """Joints (n, 6) [rad] with axes whole turns further where their sector asks for it and the limits let them."""
    turned = joints.copy()
    for axis, low, high in sectors:
        if axis not in TURN_AXES and not (math.isfinite(low) and math.isfinite(high)):
            continue  # a sign of one of the arm's axes tells no turn
        value = joints[:, axis]
        done = np.zeros(len(joints), dtype=bool)
        for turns in _TURNS:
            further = value + turns * _TURN
            fits = _in(further, low, high) & _in(further, robot.lower[axis], robot.upper[axis] + 1e-9)
            turned[:, axis] = np.where(fits & ~done, further, turned[:, axis])
            done |= fits
    return turned


def said_of(robot: Robot, joints: Array, flags: Flags, sectors: Sequence[Sectors]) -> Array:
    """(n, 6) [rad] what a reader finds with the pose of `joints` (n, 6) [rad], `flags` (n, 6), sectors of each."""
    said = apply_turns(wrap(joints, turn_centres(robot)), flags)
    for row in range(len(said)):
        said[row] = turned_into(robot, said[row : row + 1], sectors[row])[0]
    return said


def stands_in(joints: Array, sectors: Sectors) -> NDArray[np.bool_]:
    """(n,) whether joints (n, 6) [rad] stand in all sectors that have two ends; unknown ones do not.

    A sector with one end tells turns alone, counted as the maker's own arms turn.
    """
    inside = np.ones(len(joints), dtype=bool)
    for axis, low, high in sectors:
        if math.isfinite(low) and math.isfinite(high):
            inside &= _in(joints[:, axis], low, high)
    return inside


def quarters_of(joints: Array) -> NDArray[np.int64]:
    """(n, 3) the quarters of a turn in which S, R, T stand: 0 is 0 to 90 deg, -1 -90 to 0 deg. `joints` (n, 6)."""
    found: NDArray[np.int64] = np.floor(joints[:, (0, 3, 5)] / QUARTER + 1e-9).astype(np.int64)
    return found


def _in(values: Array, low: float, high: float) -> NDArray[np.bool_]:
    return np.asarray((values >= low - _EDGE) & (values < high + _EDGE))
