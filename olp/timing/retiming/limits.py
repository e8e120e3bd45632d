"""What is told of each row: how fast its axes allow it to be, which one, where, and where not at all."""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum

import numpy as np
from numpy.typing import NDArray

from olp.core.diagnostic import Diagnostic

Floats = NDArray[np.float64]


class Singular(IntEnum):
    """Which singularity a row passes, in the order of olp.robots.kinematics.Clearance."""

    NONE = -1
    WRIST = 0
    ELBOW = 1
    SHOULDER = 2


@dataclass(slots=True)
class PathLimits:
    """Per row of Moves, (m,); lengths are metres of tool path, or radians where only the tool turns.

    `known`: the row's axes are known and it is a line, an arc or a spline; of others only `outside` is told.
    `speed` [m/s]: the highest at which no axis exceeds its own anywhere on the row, inf where nothing moves;
    `axis` (-1: none) would be the first to, `place` [m] from the start. `acceleration` [m/s²]: the highest from
    standstill that no axis's acceleration forbids, inf where none is known.
    `paced` [m/s]: mean speed of a run that enters and leaves the row at the programmed speed and slows down only
    where an axis asks for it; the programmed speed where none does.
    `singular`: a Singular; such a row has no trustworthy limits (nan), so `paced` is the programmed speed.
    `nearness` [rad] (shoulder [m]): how near it comes. `lost`: [m] from the start where a pose is out of reach, nan
    if none is; such a row has no limits (nan) either.
    `outside` (-1: none): an axis that leaves its soft limits.
    """

    known: NDArray[np.bool_]
    speed: Floats
    axis: NDArray[np.int8]
    place: Floats
    acceleration: Floats
    paced: Floats
    singular: NDArray[np.int8]
    nearness: Floats
    lost: Floats
    outside: NDArray[np.int8]
    diagnostics: tuple[Diagnostic, ...] = ()
    assumptions: tuple[str, ...] = ()

    @classmethod
    def nothing(cls, count: int, programmed: Floats) -> PathLimits:
        """Rows of which nothing is known."""
        nan, none = np.full(count, np.nan), np.full(count, -1, dtype=np.int8)
        return cls(
            known=np.zeros(count, dtype=np.bool_),
            speed=np.full(count, np.inf),
            axis=none.copy(),
            place=nan.copy(),
            acceleration=np.full(count, np.inf),
            paced=programmed.copy(),
            singular=none.copy(),
            nearness=nan.copy(),
            lost=nan.copy(),
            outside=none,
        )
