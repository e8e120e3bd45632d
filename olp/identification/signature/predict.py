"""Times of moves from a signature: the number, its 95 % interval, and where it is a guess.

Codes: H009 the signature is of another robot, H010 moves outside what was learnt, H011 the robot is not known.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from olp.core.diagnostic import OlpError, error
from olp.identification.signature.coefficients import STOP, value_of
from olp.identification.signature.document import Signature
from olp.identification.signature.estimator import duration_of, load_estimator
from olp.identification.signature.moveset import MoveSet

if TYPE_CHECKING:
    from olp.robots.model import Robot

Floats = NDArray[np.float64]
# [1] An estimator that says it extrapolates is believed half.
_OUTSIDE = 2.0


@dataclass(frozen=True, slots=True)
class Prediction:
    """n moves. `acceleration` [m/s²]: the corrected one (6.1); `reasons`: why a move is outside, "" inside."""

    duration: Floats  # (n,) [s]
    low: Floats  # (n,) [s] of the 95 % interval
    high: Floats  # (n,) [s]
    acceleration: Floats  # (n,) [m/s²]
    reasons: tuple[str, ...]
    novelty: Floats  # (n,) [1] see Domain
    weight: Floats  # (n,) [m/s] seconds per slowness, widening included

    def take(self, rows: NDArray[np.intp]) -> Prediction:
        """The moves of these row numbers."""
        return Prediction(
            self.duration[rows],
            self.low[rows],
            self.high[rows],
            self.acceleration[rows],
            tuple(self.reasons[i] for i in rows.tolist()),
            self.novelty[rows],
            self.weight[rows],
        )

    def total_half(self, signature: Signature, times: Floats | None = None) -> float:
        """[s] half-width of the interval of the sum; `times` (n,): how often each move runs."""
        often = np.ones(len(self.duration)) if times is None else times
        return signature.errors.total_half(self.novelty, self.weight * often)


def predict(signature: Signature, moves: MoveSet, robot: Robot | None = None) -> Prediction:
    """Predicts usable moves. `robot`: the one they are made by, by default the signature's.

    Raises OlpError: H001 an unknown method, H008 parameters it cannot use, H009, H011.
    """
    robot = robot_of(signature, robot)
    estimator = load_estimator(signature.method)
    if estimator.needs_robot and robot is None:
        raise OlpError(
            error("H011", f"method {signature.method} needs the robot's kinematics, none is known")
        )
    try:
        estimate = estimator.estimate(signature.parameters, moves, robot)
    except (KeyError, TypeError, ValueError, IndexError) as problem:
        what = f"{type(problem).__name__}: {problem}"
        says = f"method {signature.method} cannot use the signature's parameters ({what})"
        raise OlpError(error("H008", says)) from None
    domain = signature.domain
    novelty = domain.novelty(moves)
    # From a new place the held-out start points have shown what an estimator's extrapolation costs.
    strain = domain.strain(moves) * np.where(estimate.inside | (novelty > 0.5), 1.0, _OUTSIDE)
    # Of several speeds the part of a stop that does not grow with the speed was learnt by itself.
    duration = duration_of(estimate.slowness, moves) + value_of(signature.parts, STOP, "fixed_time")
    if estimate.seconds is not None:
        duration = np.where(np.isfinite(estimate.seconds), estimate.seconds, duration)
    weight = moves.speed * strain
    half = signature.errors.half(novelty) * weight
    # No interval reaches below what the programmed speed allows.
    floor = np.minimum(moves.length / moves.speed, duration)
    reasons = domain.outside(moves)
    for row in np.nonzero(~estimate.inside)[0].tolist():
        reasons[row] = reasons[row] or f"beyond what method {signature.method} saw"
    with np.errstate(divide="ignore"):
        acceleration = 1.0 / np.maximum(estimate.slowness, 1e-9)
    low, high = np.maximum(duration - half, floor), duration + half
    return Prediction(duration, low, high, acceleration, tuple(reasons), novelty, weight)


def robot_of(signature: Signature, robot: Robot | None) -> Robot | None:
    """The robot to compute with. Raises OlpError (H009) when the given one is not the signature's."""
    if robot is not None:
        if signature.robot and robot.name != signature.robot:
            says = f"the signature is of {signature.robot}, the moves are of {robot.name}"
            raise OlpError(error("H009", says, help="calibrate on a recording of this robot"))
        return robot
    if not signature.robot:
        return None
    from olp.robots.robot import load_robot

    try:
        return load_robot(signature.robot)
    except OlpError:
        return None
