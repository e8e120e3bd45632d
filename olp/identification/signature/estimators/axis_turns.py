"""The sum of smooth functions of each axis' turn, of the length and of the place, learnt by a Gaussian process."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from olp.identification.signature.axis_paths import axis_paths, has_axes
from olp.identification.signature.coefficients import LearntParameter, Parameters
from olp.identification.signature.domain import points
from olp.identification.signature.estimator import Estimate, Estimator, measured_slowness
from olp.identification.signature.gp import Belief, KernelPart, Places
from olp.identification.signature.moveset import MoveSet
from olp.identification.signature.residual import (
    estimate_smooth,
    fit_smooth,
    learnt_columns,
    place_part,
    size_of,
    spread_of_values,
)

if TYPE_CHECKING:
    from olp.robots.model import Robot

Floats = NDArray[np.float64]

_PREFIX = "turns"


class AxisTurns(Estimator):
    """A Gaussian process whose parts see one axis each, so that moves far apart that turn an axis alike help."""

    summary = "smooth functions of the turn of each axis, of the length and of the place, summed"
    needs_robot = True

    def needs(self, moves: MoveSet, robot: Robot | None) -> str:
        if not has_axes(robot):
            return "the robot and its kinematics are not known"
        assert robot is not None
        if np.isfinite(columns_of(moves, robot)).all(axis=1).sum() < 8:
            return "fewer than 8 moves have a tool orientation and are in the robot's reach"
        return ""

    def fit(self, moves: MoveSet, robot: Robot | None) -> Parameters:
        assert robot is not None
        columns, values = columns_of(moves, robot), measured_slowness(moves)
        good = np.asarray(np.isfinite(columns).all(axis=1) & np.isfinite(values))
        middle = float(np.median(values[good]))
        left = values[good] - middle
        size = spread_of_values(left)
        single = KernelPart(Belief(size, 1.0), (Belief(0.5, 1.0),))
        parts = (*(single for _ in robot.axes), single, place_part(moves.take(good), size))
        return {
            "slowness": LearntParameter(middle, "s²/m"),
            **fit_smooth(_PREFIX, columns[good], "m, rad", _coordinates, parts, left),
        }

    def estimate(self, parameters: Parameters, moves: MoveSet, robot: Robot | None) -> Estimate:
        assert robot is not None
        columns = columns_of(moves, robot)
        known = np.asarray(np.isfinite(columns).all(axis=1))
        usual = np.median(learnt_columns(_PREFIX, parameters), axis=0)
        mean, doubt = estimate_smooth(
            _PREFIX, parameters, np.where(known[:, None], columns, usual), _coordinates
        )
        inside = known & (doubt < 0.9 * size_of(_PREFIX, parameters))
        return Estimate(float(parameters["slowness"].value) + mean, doubt, inside)


def columns_of(moves: MoveSet, robot: Robot) -> Floats:
    """(n, 6 + k) start and end point [m], signed turns of the axes [rad], nan where the axes are not known."""
    paths = axis_paths(moves, robot)
    return np.concatenate([points(moves), paths.end - paths.start], axis=1)


def _coordinates(columns: Floats) -> Places:
    start, end, turns = columns[:, :3], columns[:, 3:6], columns[:, 6:]
    length = np.linalg.norm(end - start, axis=1, keepdims=True)
    return (*((turns[:, i : i + 1],) for i in range(turns.shape[1])), (length,), (start, end))
