"""The physics that a diagnosis named, applied to the simulation that was judged."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from olp.core.diagnostic import OlpError, error
from olp.identification.signature.coefficients import Parameters
from olp.identification.signature.estimator import Estimate, Estimator
from olp.identification.signature.moveset import MoveSet

if TYPE_CHECKING:
    from olp.identification.recording.recording import Recording
    from olp.robots.model import Robot

Floats = NDArray[np.float64]

_WHOLE = (
    "is learnt from a whole recording, corners and joint moves with it (olp calibrate --method named_terms)"
)


class NamedTerms(Estimator):
    """The duration of a move is the judged simulation's with the named terms in it, as `olp diagnose` predicts it.

    Not fitted to moves alone: `learn.calibrate` asks the diagnosis. No candidate of `auto`.
    """

    summary = "the terms that olp diagnose named, in the motion of the simulation that it judged"

    def needs(self, moves: MoveSet, robot: Robot | None) -> str:
        return _WHOLE

    def fit(self, moves: MoveSet, robot: Robot | None) -> Parameters:
        raise OlpError(error("H002", f"method {self.name}: {_WHOLE}"))

    def estimate(self, parameters: Parameters, moves: MoveSet, robot: Robot | None) -> Estimate:
        from olp.identification.signature.term_model import case_for, from_parameters, seconds_of
        from olp.timing.arm_prior import line_acceleration

        named = from_parameters(parameters)
        made = case_for(named, _recording_of(moves, robot))
        seconds = np.full(len(moves), np.nan)
        if made is not None:
            seconds[made[1]] = seconds_of(named, made[0])
        inside = np.isfinite(seconds)
        plain = np.where(moves.nominal > 0, moves.nominal, line_acceleration(robot).value)
        slowness = np.where(inside, _slowness(seconds, moves), 1.0 / plain)
        return Estimate(slowness, np.zeros(len(moves)), inside, seconds)


def _slowness(seconds: Floats, moves: MoveSet) -> Floats:
    """(n,) [s²/m] with which constant acceleration comes nearest to these times: 0 where the speed is not enough."""
    way, speed = moves.length, moves.speed
    over = np.maximum(seconds - way / speed, 0.0)
    return np.asarray(np.where(over * speed <= way, over / speed, seconds**2 / (4.0 * way)))


def _recording_of(moves: MoveSet, robot: Robot | None) -> Recording:
    """Each move by itself, from stop to stop."""
    from olp.identification.signature.term_model import bare_recording
    from olp.robots.geometry import angles_from_rotation

    angles = np.full((len(moves), 3), np.nan)
    told = np.asarray(np.isfinite(moves.rotation).all(axis=(1, 2)))
    if told.any():
        angles[told] = angles_from_rotation(moves.rotation[told])
    columns = {
        "start": moves.start,
        "end": moves.end,
        "start_angles": angles,
        "end_angles": angles,
        "speed": moves.speed,
        "payload": moves.payload,
    }
    if moves.joints is not None and robot is not None and moves.joints.shape[2] == len(robot.axes):
        columns |= {"joints_start": moves.joints[:, 0], "joints_end": moves.joints[:, 1]}
    return bare_recording(len(moves), columns, robot, moves.tool)
