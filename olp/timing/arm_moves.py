"""Joint moves as an arm's law and what is learnt beside it see them, whether they come from a recording or a
plan.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from olp.timing.arm import ArmTiming, JointMotions, gradient, posture_functions
from olp.timing.arm_inertia import relative_inertia

if TYPE_CHECKING:
    from olp.robots.robot import Robot

Floats = NDArray[np.float64]
Mask = NDArray[np.bool_]
Rows = NDArray[np.intp]


@dataclass(frozen=True, slots=True, eq=False)
class JointMoves:
    """n joint moves: the law's view of them, and the joints at both ends (n, k) [rad | m]."""

    motions: JointMotions
    start: Floats
    end: Floats

    def __len__(self) -> int:
        return len(self.start)

    def take(self, rows: Rows | Mask) -> JointMoves:
        return JointMoves(self.motions.take(rows), self.start[rows], self.end[rows])


class JointTimes(NamedTuple):
    """(n,) [s] each; nan where nothing can be said."""

    duration: Floats
    low: Floats
    high: Floats


def joint_moves(
    robot: Robot | None,
    start: Floats,
    end: Floats,
    fraction: Floats,
    acceleration: Floats,
    override: Floats,
    payload: Floats | None = None,
    inertia: Floats | None = None,
) -> JointMoves:
    """From joints (n, k) [rad | m] at both ends; shares (n,) [1]; `payload` (n,) [kg] and its `inertia` [kg m²]."""
    middle = (start + end) / 2
    if robot is None:
        relative = np.ones((2, *start.shape))
    else:
        relative = np.stack(relative_inertia(robot, np.nan_to_num(middle), payload, inertia))
    motions = JointMotions(
        np.abs(end - start),
        posture_functions(middle),
        relative[0],
        relative[1],
        fraction,
        acceleration,
        override,
    )
    return JointMoves(motions, start, end)


class JointLaw(Protocol):
    """What times joint moves: the arm's law as it is known, or with what was learnt beside it."""

    @property
    def timing(self) -> ArmTiming: ...

    @property
    def quantile(self) -> float:
        """[spreads] of a 95 % interval."""

    def predict(self, moves: JointMoves) -> JointTimes: ...


class PriorArm(NamedTuple):
    """The law alone, with what is known of an arm without any recorded move."""

    timing: ArmTiming
    quantile: float = 1.96

    def predict(self, moves: JointMoves) -> JointTimes:
        duration = self.timing.durations(moves.motions)
        wide = np.exp(self.quantile * self.timing.spread(moves.motions))
        return JointTimes(duration, duration / wide, duration * wide)


def total_half(law: JointLaw, moves: JointMoves, often: Floats) -> float:
    """[s] half-width of the 95 % interval of a sum; `often` (n,): how many times each move runs.

    What is not known of the law's numbers is the same in all moves; the scatter of a move is its own.
    """
    timing = law.timing
    seconds = timing.durations(moves.motions) * often
    pull = seconds @ gradient(timing.mean, moves.motions)
    variance = float(pull @ timing.covariance @ pull) + float(np.sum((seconds * timing.scatter) ** 2))
    return law.quantile * float(np.sqrt(variance))
