"""One acceleration for everything: what a simulation has, fitted."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from olp.identification.signature.coefficients import LearntParameter, Parameters
from olp.identification.signature.estimator import Estimate, Estimator, measured_slowness
from olp.identification.signature.moveset import MoveSet

if TYPE_CHECKING:
    from olp.robots.model import Robot


class MedianSlowness(Estimator):
    """The median of 1/a (6.1): half of the moves may be wrong and it still holds."""

    summary = "one acceleration for all moves"

    def fit(self, moves: MoveSet, robot: Robot | None) -> Parameters:
        values = measured_slowness(moves)
        values = values[np.isfinite(values)]
        middle = float(np.median(values))
        # Of a median, in standard deviations of the mean of a normal distribution.
        doubt = 1.2533 * float(np.median(np.abs(values - middle))) * 1.4826 / np.sqrt(len(values))
        return {"slowness": LearntParameter(middle, "s²/m", float(doubt))}

    def estimate(self, parameters: Parameters, moves: MoveSet, robot: Robot | None) -> Estimate:
        count = len(moves)
        return Estimate(
            np.full(count, float(parameters["slowness"].value)), np.zeros(count), np.ones(count, dtype=bool)
        )
