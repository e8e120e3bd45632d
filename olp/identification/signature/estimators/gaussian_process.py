"""A smooth function of start and end point; needs no robot."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from olp.identification.signature.coefficients import LearntParameter, Parameters
from olp.identification.signature.estimator import Estimate, Estimator, measured_slowness
from olp.identification.signature.moveset import MoveSet
from olp.identification.signature.residual import estimate_residual, fit_residual, residual_size

if TYPE_CHECKING:
    from olp.robots.model import Robot


class GaussianProcess(Estimator):
    """The median, and a Gaussian process for what is left."""

    summary = "a smooth function of start and end point"

    def fit(self, moves: MoveSet, robot: Robot | None) -> Parameters:
        values = measured_slowness(moves)
        good = np.isfinite(values)
        middle = float(np.median(values[good]))
        return {
            "slowness": LearntParameter(middle, "s²/m"),
            **fit_residual(moves.take(good), values[good] - middle),
        }

    def estimate(self, parameters: Parameters, moves: MoveSet, robot: Robot | None) -> Estimate:
        mean, doubt = estimate_residual(parameters, moves)
        inside = doubt < 0.9 * residual_size(parameters)
        return Estimate(float(parameters["slowness"].value) + mean, doubt, np.asarray(inside))
