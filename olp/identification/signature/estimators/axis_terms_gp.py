"""Terms of the axes' motion for what carries over to other places, a smooth function for what does not."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from olp.identification.signature.coefficients import LearntParameter, Parameters
from olp.identification.signature.domain import domain_of, nearest, points
from olp.identification.signature.estimator import Estimate, learnt, measured_slowness
from olp.identification.signature.estimators.axis_terms import AxisTerms
from olp.identification.signature.moveset import MoveSet
from olp.identification.signature.residual import estimate_residual, fit_residual, learnt_places

if TYPE_CHECKING:
    from olp.robots.model import Robot


_TERMS = "axis_terms"


class AxisTermsGp(AxisTerms):
    """`axis_terms`, and a Gaussian process over start and end points for what it leaves."""

    summary = "terms of the axes' motion, and a smooth function of start and end point for the rest"

    def fit(self, moves: MoveSet, robot: Robot | None) -> Parameters:
        terms = learnt(_TERMS, moves, robot)
        left = measured_slowness(moves) - super().estimate(terms, moves, robot).slowness
        good = np.isfinite(left)
        domain = domain_of(moves)
        return {
            **terms,
            **fit_residual(moves.take(good), left[good]),
            "near": LearntParameter(domain.near, "m"),
            "far": LearntParameter(max(domain.far, domain.near + 1e-3), "m"),
        }

    def estimate(self, parameters: Parameters, moves: MoveSet, robot: Robot | None) -> Estimate:
        carried = super().estimate(parameters, moves, robot)
        mean, doubt = estimate_residual(parameters, moves)
        near, far = float(parameters["near"].value), float(parameters["far"].value)
        # What the terms leave is a fact of the place: from a start point that was not learnt it carried nothing over.
        believed = np.clip((far - nearest(points(moves), learnt_places(parameters))) / (far - near), 0.0, 1.0)
        return Estimate(carried.slowness + believed * mean, np.hypot(carried.sd, doubt), carried.inside)
