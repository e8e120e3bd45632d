"""Among learnt moves a smooth function of the place, from elsewhere terms of the axes' motion, between them both."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from olp.signature.domain import domain_of, nearest, points
from olp.signature.estimator import Estimate, Parameter, Parameters, load_estimator, measured_slowness
from olp.signature.estimators.axis_terms import AxisTerms
from olp.signature.moveset import MoveSet
from olp.signature.residual import estimate_residual, fit_residual, learnt_places

if TYPE_CHECKING:
    from olp.robot import Robot


_TABLES = "factors"


class TermsAndPlaces(AxisTerms):
    """`gaussian_process` near learnt moves, `axis_terms` as far as a start point that was not learnt.

    Where the factor tables interpolate between start radii (`factors` is inside), they and the terms count alike there.
    """

    summary = "a smooth function of the place among learnt moves, terms of the axes' motion elsewhere"
    preferred = True

    def fit(self, moves: MoveSet, robot: Robot | None) -> Parameters:
        values = measured_slowness(moves)
        good = np.isfinite(values)
        middle, domain = float(np.median(values[good])), domain_of(moves)
        factors = load_estimator(_TABLES)
        tables = {} if factors.needs(moves, robot) else factors.fit(moves, robot)
        return {
            **tables,
            **super().fit(moves, robot),
            "slowness": Parameter(middle, "s²/m"),
            **fit_residual(moves.take(good), values[good] - middle),
            "near": Parameter(domain.near, "m"),
            "far": Parameter(max(domain.far, domain.near + 1e-3), "m"),
        }

    def estimate(self, parameters: Parameters, moves: MoveSet, robot: Robot | None) -> Estimate:
        carried = self._carried(parameters, moves, robot)
        mean, doubt = estimate_residual(parameters, moves)
        near, far = float(parameters["near"].value), float(parameters["far"].value)
        distance = nearest(points(moves), learnt_places(parameters))
        share = np.clip((far - distance) / (far - near), 0.0, 1.0)
        here = float(parameters["slowness"].value) + mean
        slowness = share * here + (1.0 - share) * carried.slowness
        return Estimate(slowness, share * doubt + (1.0 - share) * carried.sd, carried.inside | (share >= 1.0))

    def _carried(self, parameters: Parameters, moves: MoveSet, robot: Robot | None) -> Estimate:
        terms = super().estimate(parameters, moves, robot)
        if "tables" not in parameters:
            return terms
        tables = load_estimator(_TABLES).estimate(parameters, moves, robot)
        both = 0.5 * (terms.slowness + np.nan_to_num(tables.slowness))
        slowness = np.where(tables.inside, np.where(terms.inside, both, tables.slowness), terms.slowness)
        return Estimate(slowness, terms.sd, terms.inside | tables.inside)
