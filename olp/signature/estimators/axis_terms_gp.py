"""Terms of the axes' motion for what carries over to other places, a smooth function for what does not."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from olp.signature.estimator import Estimate, Parameters, measured_slowness
from olp.signature.estimators.axis_terms import AxisTerms
from olp.signature.moveset import MoveSet
from olp.signature.residual import estimate_residual, fit_residual

if TYPE_CHECKING:
    from olp.robot import Robot


class AxisTermsGp(AxisTerms):
    """`axis_terms`, and a Gaussian process over start and end points for what it leaves."""

    summary = "terms of the axes' motion, and a smooth function of start and end point for the rest"

    def fit(self, moves: MoveSet, robot: Robot | None) -> Parameters:
        terms = super().fit(moves, robot)
        left = measured_slowness(moves) - super().estimate(terms, moves, robot).slowness
        good = np.isfinite(left)
        return {**terms, **fit_residual(moves.take(good), left[good])}

    def estimate(self, parameters: Parameters, moves: MoveSet, robot: Robot | None) -> Estimate:
        carried = super().estimate(parameters, moves, robot)
        mean, doubt = estimate_residual(parameters, moves)
        return Estimate(carried.slowness + mean, np.hypot(carried.sd, doubt), carried.inside)
