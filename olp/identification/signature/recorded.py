"""The rows of a recording as a signature and olp's own model see them together."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from olp.identification.signature.coefficients import JOINT, CorrectionPart, Parts
from olp.identification.signature.document import Signature
from olp.identification.signature.joint_moves import LearntArm, recorded_joint_moves
from olp.identification.signature.motions import Motions, motions_of, with_slowness
from olp.identification.signature.moveset import moves_of_recording
from olp.identification.signature.places import with_points
from olp.identification.signature.predict import Prediction, predict, robot_of
from olp.identification.signature.stretch_times import JointRows, Times, law_savings, times_of
from olp.identification.signature.stretches import Stretches, stretches_of
from olp.timing.arm import solve

if TYPE_CHECKING:
    from olp.identification.recording import Recording
    from olp.identification.recording.moves import RecordedMoves
    from olp.robots.geometry import Pose
    from olp.robots.robot import Robot

Floats = NDArray[np.float64]

_ALONG = ("linear", "circular")


@dataclass(frozen=True, slots=True, eq=False)
class RecordedTimes:
    """`half` (n,) [s]: half-width of the signature's interval along paths; `strain` (n,) [1]: how far outside.

    `told`: the rows that the signature's method was asked for, `said`: what it said, in that order.
    """

    moves: RecordedMoves
    motions: Motions
    stretches: Stretches
    saving: Floats
    law: str
    settling: float  # [s] of joint moves when none were learnt
    parts: Parts
    half: Floats
    strain: Floats
    told: NDArray[np.int64]
    said: Prediction | None
    joints: JointRows | None = None  # those that the law of joint moves told
    robot: Robot | None = None

    @property
    def times(self) -> Times:
        """What each row takes, with the parts as they are."""
        return times_of(
            self.moves, self.motions, self.stretches, self.parts, self.saving, self.settling, self.joints
        )

    def with_part(self, kind: str, part: CorrectionPart) -> RecordedTimes:
        return replace(self, parts={**self.parts, kind: part})


def rows_of(signature: Signature, recording: Recording, report: Callable[[str], None]) -> RecordedTimes:
    """`report` is called with what had to be assumed. Raises OlpError (see predict)."""
    from olp.robots.controller_effects import Effects, settling_of

    robot = robot_of(signature, recording.robot)
    if recording.robot is None and robot is not None:
        recording = replace(recording, robot=robot)
    moves = with_points(recording.moves, robot, recording.tool)
    learnt = JOINT in signature.parts or signature.arm is not None  # then the axes' accelerations were, too
    motions = motions_of(moves, robot, recording.tool, (lambda says: None) if learnt else report)
    count = len(moves)
    half, strain = np.full(count, np.nan), np.ones(count)
    asked, told = moves_of_recording(recording, stops=False, kinds=_ALONG)
    said = None
    if len(told):
        said = predict(signature, asked, robot)
        motions = with_slowness(motions, told, 1.0 / said.acceleration)
        half[told], strain[told] = said.high - said.duration, said.weight / asked.speed
    _joint_at_tool_speed(motions, moves, signature)
    stretches = stretches_of(moves)
    saving, law = law_savings(moves, motions, stretches, robot)
    settling, assumed = settling_of(Effects(), robot)
    if assumed and not learnt and any(kind == "joint" for kind in moves.kinds):
        report(assumed)
    joints = None if signature.arm is None else _joint_rows(signature.arm, moves, robot, recording.tool)
    return RecordedTimes(
        moves,
        motions,
        stretches,
        saving,
        law,
        settling,
        signature.parts,
        half,
        strain,
        told,
        said,
        joints,
        robot,
    )


def _joint_rows(arm: LearntArm, moves: RecordedMoves, robot: Robot | None, tool: Pose | None) -> JointRows:
    joints, rows = recorded_joint_moves(moves, robot, tool, len(arm.timing.axes))
    floor = np.max(solve(arm.timing.mean, joints.motions).cruise, axis=1, initial=0.0)
    return JointRows(rows, arm.predict(joints), floor, arm.timing.stop)


def _joint_at_tool_speed(motions: Motions, moves: RecordedMoves, signature: Signature) -> None:
    """A joint move with a speed of the tool and no share of the axes': accelerates as the simulation's paths do."""
    from olp.timing.accelerations import DEFAULT_LINEAR_ACCELERATION

    at = np.array([kind == "joint" for kind in moves.kinds], dtype=bool)
    at &= np.isnan(motions.slowness[:, 0]) & np.isfinite(motions.distance[:, 0])
    given = moves.acceleration[at]
    motions.slowness[at, 0] = 1.0 / np.where(given > 0, given, DEFAULT_LINEAR_ACCELERATION)
