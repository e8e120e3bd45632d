"""Among learnt moves smooth functions, from elsewhere terms of the axes' motion, between them both."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from olp.identification.signature.coefficients import LearntParameter, Parameters
from olp.identification.signature.domain import domain_of, nearest, points
from olp.identification.signature.estimator import Estimate, learnt, load_estimator
from olp.identification.signature.estimators.averaged_process import MOST
from olp.identification.signature.estimators.axis_terms import AxisTerms
from olp.identification.signature.moveset import MoveSet
from olp.identification.signature.residual import estimate_residual, learnt_places

if TYPE_CHECKING:
    from olp.robots.model import Robot


_TABLES, _TERMS, _PLACES = "factors", "axis_terms", "gaussian_process"
# Beside _PLACES; the last ones for few moves, between which the terms have to carry.
_ALWAYS: tuple[str, ...] = ("axis_turns",)
_FEW: tuple[str, ...] = ("averaged_process", "axis_terms_gp")


class TermsAndPlaces(AxisTerms):
    """The mean of smooth functions near learnt moves, `axis_terms` as far as a start point that was not learnt.

    The mean of `gaussian_process` and `axis_turns`, of few moves of `averaged_process` and `axis_terms_gp` too: they
    err differently where moves are sparse. Where the factor tables interpolate between start radii (`factors` is
    inside), they and the terms count alike there.
    """

    summary = "smooth functions of place and axes among learnt moves, terms of the axes' motion elsewhere"
    preferred = True

    def fit(self, moves: MoveSet, robot: Robot | None) -> Parameters:
        domain = domain_of(moves)
        tables = {} if load_estimator(_TABLES).needs(moves, robot) else learnt(_TABLES, moves, robot)
        found: dict[str, LearntParameter] = {
            **tables,
            **learnt(_TERMS, moves, robot),
            **learnt(_PLACES, moves, robot),
            "near": LearntParameter(domain.near, "m"),
            "far": LearntParameter(max(domain.far, domain.near + 1e-3), "m"),
        }
        for name in _ALWAYS + (_FEW if len(moves) <= MOST else ()):
            if not load_estimator(name).needs(moves, robot):
                own = learnt(name, moves, robot)
                found.update({f"{name}: {key}": parameter for key, parameter in own.items()})
        return found

    def estimate(self, parameters: Parameters, moves: MoveSet, robot: Robot | None) -> Estimate:
        carried = self._carried(parameters, moves, robot)
        near, far = float(parameters["near"].value), float(parameters["far"].value)
        distance = nearest(points(moves), learnt_places(parameters))
        share = np.clip((far - distance) / (far - near), 0.0, 1.0)
        here = _among_learnt(parameters, moves, robot)
        slowness = share * here.slowness + (1.0 - share) * carried.slowness
        return Estimate(
            slowness, share * here.sd + (1.0 - share) * carried.sd, carried.inside | (share >= 1.0)
        )

    def _carried(self, parameters: Parameters, moves: MoveSet, robot: Robot | None) -> Estimate:
        terms = super().estimate(parameters, moves, robot)
        if "tables" not in parameters:
            return terms
        tables = load_estimator(_TABLES).estimate(parameters, moves, robot)
        both = 0.5 * (terms.slowness + np.nan_to_num(tables.slowness))
        slowness = np.where(tables.inside, np.where(terms.inside, both, tables.slowness), terms.slowness)
        return Estimate(slowness, terms.sd, terms.inside | tables.inside)


def _among_learnt(parameters: Parameters, moves: MoveSet, robot: Robot | None) -> Estimate:
    """The mean of what the smooth functions say; `sd`: their own and that between them."""
    mean, doubt = estimate_residual(parameters, moves)
    said, sds = [float(parameters["slowness"].value) + mean], [doubt]
    known = np.ones(len(moves), dtype=bool)
    for name in _ALWAYS + _FEW:
        own = {k.removeprefix(f"{name}: "): v for k, v in parameters.items() if k.startswith(f"{name}: ")}
        if own:
            estimate = load_estimator(name).estimate(own, moves, robot)
            known &= estimate.inside if name == _ALWAYS[0] else True
            said.append(estimate.slowness)
            sds.append(estimate.sd)
    together = np.array(said)
    # Where the axes are not known, or turn as in no learnt move, the place alone answers.
    slowness = np.where(known, together.mean(axis=0), together[0])
    spread = np.sqrt(np.mean(np.square(sds), axis=0) + np.where(known, together.var(axis=0), 0.0))
    return Estimate(slowness, spread, known)
