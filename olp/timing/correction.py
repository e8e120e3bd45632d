"""What was learnt of a robot's times, as `time_plan` asks it; the classes of this module have learnt nothing.

`olp.identification.signature.correction` has those of a timing signature.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from olp.runtime.plan import Plan
from olp.timing.arm_moves import JointLaw
from olp.timing.arm_prior import LineAcceleration, unlearnt_law
from olp.timing.chain import Chain
from olp.timing.demand import Demand
from olp.timing.joint_times import TimedJoints, doubt_of, expected_total, line_doubt_of, time_joints
from olp.timing.result import Timing

Floats = NDArray[np.float64]
Mask = NDArray[np.bool_]
Rows = NDArray[np.intp]
Report = Callable[[str], None]


@dataclass(frozen=True)
class PlanCorrection:
    """What was learnt of the moves of one plan: nothing, but what the law of such arms says of their joint moves.

    Rows are rows of the plan's Moves, k of them. `rows` (m,): those whose acceleration was learnt. `timed`: joint moves
    that the law of the arm timed.
    """

    plan: Plan
    timed: TimedJoints | None = None
    rows: Rows = field(default_factory=lambda: np.zeros(0, dtype=np.intp))

    def corners(self, joined: Chain) -> Chain:
        """Corners as learnt."""
        return joined

    def follow(self, wanted: Demand, joined: Chain, overrides: Floats, report: Report) -> PlanCorrection:
        """The correction with the moves whose whole time is known once their corners are. Raises OlpError.

        `overrides` (k,) [1].
        """
        return self

    @property
    def knows_stops(self) -> Mask:
        """(k,) Moves whose stops need no assumption."""
        result = np.zeros(len(self.plan.moves), dtype=bool)
        if self.timed is not None:
            result[self.timed.rows] = True
        return result

    @property
    def measured_stops(self) -> Mask:
        """(k,) Moves whose learnt times hold all that the controller adds to a stop already."""
        return np.zeros(len(self.plan.moves), dtype=bool)

    def settled(self, exact: Mask, settling: float) -> Floats:
        """(k,) [s] that the stops `exact` (k,) take; `settling` [s] where nothing is known."""
        result = np.where(exact, settling, 0.0)
        if self.timed is not None:
            result[self.timed.rows] = np.where(exact[self.timed.rows], self.timed.stop, 0.0)
        return result

    def with_whole_times(self, durations: Floats) -> Floats:
        """(k,) [s] with the moves whose whole time was learnt."""
        return durations

    def doubts(self) -> list[str]:
        """How sure the times of joint moves are that nobody recorded."""
        return [] if self.timed is None else doubt_of(self.plan, self.timed)

    def with_interval(
        self,
        timing: Timing,
        wanted: Demand,
        joined: Chain,
        times: tuple[Floats, Floats],
        lines: LineAcceleration,
        report: Report,
    ) -> Timing:
        """The timing with its 95 % interval. `times`: how long moves last and their stops, (k,) [s] each.

        `lines`: what lines accelerate with that program nothing.
        """
        ends = expected_total(self.plan, wanted, times[0], timing.total_s, self.timed, lines.doubt)
        if not lines.published:
            for says in line_doubt_of(self.plan, wanted, times[0], self.timed, lines.doubt):
                report(says)
        return replace(timing, expected=ends)


class Correction:
    """What was learnt of a robot: nothing."""

    @property
    def axis_scale(self) -> float:
        """[1] By which the axes of the arm take longer to reach their speed than olp's model says."""
        return 1.0

    @property
    def knows_joint_moves(self) -> bool:
        """Whether nothing has to be assumed of the arm's axes."""
        return False

    def of_plan(
        self, plan: Plan, wanted: Demand, overrides: Floats, by_axes: bool, report: Report
    ) -> PlanCorrection:
        """What it says of a plan; puts its accelerations into `wanted`. `overrides` (k,) [1]. Raises OlpError.

        `by_axes`: the law of such arms may time joint moves that nobody recorded.
        """
        law = unlearnt_law(plan.robot) if by_axes and plan.robot is not None else None
        return PlanCorrection(plan, timed_by(law, plan, wanted, overrides, None))


def timed_by(
    law: JointLaw | None, plan: Plan, wanted: Demand, overrides: Floats, payload: float | None
) -> TimedJoints | None:
    """The plan's joint moves by the law of the arm, where there is one; see `time_joints`."""
    return None if law is None else time_joints(plan, wanted, law, overrides, payload)


NOTHING_LEARNT: Final = Correction()
