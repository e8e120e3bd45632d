"""For few moves, and for totals: smooth in the terms of the axes' motion and in place, no length of it chosen."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from olp.identification.signature.axis_paths import has_axes
from olp.identification.signature.coefficients import LearntParameter, Parameters
from olp.identification.signature.domain import points
from olp.identification.signature.estimator import Estimate, Estimator, measured_slowness
from olp.identification.signature.estimators.axis_terms import terms_of
from olp.identification.signature.mixture import Observations, Views, answer, ruler_of
from olp.identification.signature.moveset import MoveSet

if TYPE_CHECKING:
    from olp.robots.model import Robot

# More moves tell the lengths themselves, and other methods are quicker then.
MOST = 60
_BLOCK = 2000


class AveragedProcess(Estimator):
    """Gaussian processes over points and over terms of the axes, averaged by their evidence."""

    summary = f"for up to {MOST} moves: smooth in the axes' motion and in place, averaged over its lengths"
    needs_robot = True

    def needs(self, moves: MoveSet, robot: Robot | None) -> str:
        if not has_axes(robot):
            return "the robot and its kinematics are not known"
        assert robot is not None
        if len(moves) > MOST:
            return f"it is for at most {MOST} moves"
        if np.isfinite(terms_of(moves, robot).values).all(axis=1).sum() < 4:
            return "fewer than 4 moves have a tool orientation and are in the robot's reach"
        return ""

    def fit(self, moves: MoveSet, robot: Robot | None) -> Parameters:
        assert robot is not None
        views, slowness = views_of(moves, robot), measured_slowness(moves)
        rows = np.nonzero(np.isfinite(views.terms).all(axis=1) & np.isfinite(slowness))[0]
        count = len(rows)
        seen = Observations(slowness[rows], np.arange(count, dtype=np.int64), np.ones(count))
        return parameters_of(views.take(rows), seen)

    def estimate(self, parameters: Parameters, moves: MoveSet, robot: Robot | None) -> Estimate:
        assert robot is not None
        learnt, seen = _learnt(parameters)
        wanted = views_of(moves, robot)
        known = np.asarray(np.isfinite(wanted.terms).all(axis=1))
        ruler = ruler_of(learnt)
        terms = np.where(known[:, None], wanted.terms, ruler.term_middle)
        low, high = learnt.terms.min(axis=0), learnt.terms.max(axis=0)
        slack = 0.25 * (high - low) + 1e-9
        inside = known & np.all((terms >= low - slack) & (terms <= high + slack), axis=1)
        parts = [
            answer(learnt, seen, ruler, Views(wanted.places[i : i + _BLOCK], terms[i : i + _BLOCK]))
            for i in range(0, len(moves), _BLOCK)
        ]
        if not parts:
            return Estimate(np.zeros(0), np.zeros(0), np.zeros(0, dtype=bool))
        return Estimate(
            np.concatenate([p.mean for p in parts]), np.concatenate([p.sd for p in parts]), inside
        )


def views_of(moves: MoveSet, robot: Robot) -> Views:
    """Terms are nan where the axes are not known."""
    return Views(points(moves), terms_of(moves, robot).values)


def parameters_of(views: Views, seen: Observations) -> Parameters:
    """What the file holds: the moves and what was observed of them. `seen.values` [s²/m], or [s] with shares [m/s]."""
    return {
        "places": LearntParameter(views.places.tolist(), "m"),
        "terms": LearntParameter(views.terms.tolist(), "rad, rad/m, m"),
        "observations": LearntParameter(seen.values.tolist(), "s²/m times share"),
        "observation_of_move": LearntParameter(seen.owner.tolist(), ""),
        "share": LearntParameter(seen.share.tolist(), "1 or m/s"),
    }


def _learnt(parameters: Parameters) -> tuple[Views, Observations]:
    def array(name: str, kind: Any = np.float64) -> Any:
        return np.array(parameters[name].value, dtype=kind)

    places = array("places").reshape(-1, 6)
    views = Views(places, array("terms").reshape(len(places), -1))
    return views, Observations(array("observations"), array("observation_of_move", np.int64), array("share"))
