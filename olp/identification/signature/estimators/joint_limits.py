"""Each axis accelerates at its own rate, and the axis that turns most for it decides at each end of the move."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from olp.identification.signature.axis_paths import axis_paths, has_axes
from olp.identification.signature.coefficients import LearntParameter, Parameters
from olp.identification.signature.estimator import Estimate, Estimator, measured_slowness
from olp.identification.signature.gp import minimise
from olp.identification.signature.moveset import MoveSet

if TYPE_CHECKING:
    from olp.robots.model import Robot

Floats = NDArray[np.float64]

# The smooth maximum: axes that are nearly as slow as the slowest one count a little.
POWER = 6.0
# Beliefs: an axis needs about 0.3 s to a rated speed of about 3 rad/s, and other times than acceleration are small.
_ACCELERATION, _SPREAD = 10.0, 1.0  # [rad/s²], of the logarithm
_MOST_ROWS = 1500


class JointLimits(Estimator):
    """1/a = c + (r_start + r_end) / 2, r = max over axes of |dq/ds| / A at that end, ds along J⁻¹ of the path.

    c holds what does not depend on the axes. A: one acceleration for both senses of each axis, learnt with a
    log-normal belief, so that an axis that never decides keeps it, with its uncertainty.
    """

    summary = "an acceleration per axis, the slowest axis decides at each end"
    needs_robot = True

    def needs(self, moves: MoveSet, robot: Robot | None) -> str:
        if not has_axes(robot):
            return "the robot and its kinematics are not known"
        assert robot is not None
        if np.isfinite(axis_paths(moves, robot).start_rate).all(axis=1).sum() < 8:
            return "fewer than 8 moves have a tool orientation and are in the robot's reach"
        return ""

    def fit(self, moves: MoveSet, robot: Robot | None) -> Parameters:
        assert robot is not None
        paths = axis_paths(moves, robot)
        slowness = measured_slowness(moves)
        good = np.isfinite(paths.start_rate + paths.end_rate).all(axis=1) & np.isfinite(slowness)
        rows = np.nonzero(good)[0][:: max(1, len(moves) // _MOST_ROWS)]
        rates = (np.abs(paths.start_rate[rows]), np.abs(paths.end_rate[rows]))
        values = slowness[rows]
        size = max(float(np.median(values)) * 0.1, 1e-6)
        axes = rates[0].shape[1]
        start = np.concatenate([[np.log(np.median(values) / 2)], np.full(axes, np.log(_ACCELERATION))])
        found = minimise(lambda theta: _cost(theta, rates, values, size), start, 80)
        doubt = _doubt(found, rates, values, size)
        names = list(robot.axis_names)
        return {
            "axes": LearntParameter(names, ""),
            "constant": LearntParameter(float(np.exp(found[0])), "s²/m", float(np.exp(found[0]) * doubt[0])),
            "accelerations": LearntParameter(
                np.exp(found[1:]).tolist(), "rad/s²", (np.exp(found[1:]) * doubt[1:]).tolist()
            ),
            # Near one: the moves say nothing of this axis.
            "log_doubt": LearntParameter(doubt.tolist(), "1"),
        }

    def estimate(self, parameters: Parameters, moves: MoveSet, robot: Robot | None) -> Estimate:
        assert robot is not None
        paths = axis_paths(moves, robot)
        known = np.asarray(np.isfinite(paths.start_rate + paths.end_rate).all(axis=1))
        theta = np.log([parameters["constant"].value, *parameters["accelerations"].value])
        rates = (np.abs(paths.start_rate), np.abs(paths.end_rate))
        usual = tuple(np.where(known[:, None], r, np.nanmedian(r, axis=0)) for r in rates)
        return Estimate(_said(theta, (usual[0], usual[1]))[0], np.zeros(len(moves)), known)


def _said(theta: Floats, rates: tuple[Floats, Floats]) -> tuple[Floats, Floats]:
    """Slowness (n,) [s²/m] and its slopes (n, 1 + k) along the logarithms."""
    constant, inverse = np.exp(theta[0]), np.exp(-theta[1:])
    total = np.full(len(rates[0]), constant)
    slopes = np.zeros((len(total), len(theta)))
    slopes[:, 0] = constant
    for rate in rates:
        needed = rate * inverse
        top = np.maximum(needed.max(axis=1), 1e-12)
        share = (needed / top[:, None]) ** POWER
        whole = share.sum(axis=1)
        slowest = top * whole ** (1 / POWER)
        total = total + slowest / 2
        slopes[:, 1:] -= (slowest / whole)[:, None] * share / 2
    return total, slopes


def _cost(theta: Floats, rates: tuple[Floats, Floats], values: Floats, size: float) -> tuple[float, Floats]:
    """Pseudo-Huber loss of the errors in units of `size`, and the beliefs; with gradient."""
    said, slopes = _said(theta, rates)
    error = (said - values) / size
    root = np.sqrt(1 + error**2)
    off = (theta[1:] - np.log(_ACCELERATION)) / _SPREAD
    gradient = slopes.T @ (error / root) / size
    gradient[1:] += off / _SPREAD
    return float(np.sum(root - 1)) + 0.5 * float(off @ off), gradient


def _doubt(theta: Floats, rates: tuple[Floats, Floats], values: Floats, size: float) -> Floats:
    """Standard deviations of the logarithms: Laplace's approximation about the best point."""
    said, slopes = _said(theta, rates)
    error = (said - values) / size
    weight = (1 + error**2) ** -0.5
    belief = np.diag([1e-9] + [1 / _SPREAD**2] * (len(theta) - 1))
    square = (slopes * weight[:, None]).T @ slopes / size**2 + belief
    return np.asarray(np.sqrt(np.diag(np.linalg.inv(square))))
