"""Interface through which `time_plan` asks for learnt times; the classes of this module have learnt nothing.

`olp.identification.signature.correction` implements it for a timing signature.
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
    """Learnt corrections for the moves of one plan; this base class has only the prior law's times of joint moves.

    Rows are rows of the plan's Moves, k in all. `rows` (m,): rows with a learnt acceleration. `timed`: joint moves
    that the law of the arm timed.
    """

    plan: Plan
    timed: TimedJoints | None = None
    rows: Rows = field(default_factory=lambda: np.zeros(0, dtype=np.intp))

    def corners(self, joined: Chain) -> Chain:
        """The chain with learnt corners."""
        return joined

    def follow(self, wanted: Demand, joined: Chain, overrides: Floats, report: Report) -> PlanCorrection:
        """This correction completed with the moves whose whole time depends on their corners. Raises OlpError.

        `overrides` (k,) [1]: speed override of each row.
        """
        return self

    @property
    def knows_stops(self) -> Mask:
        """Moves whose stops need no assumption (k,)."""
        result = np.zeros(len(self.plan.moves), dtype=bool)
        if self.timed is not None:
            result[self.timed.rows] = True
        return result

    @property
    def measured_stops(self) -> Mask:
        """Moves whose learnt times include all that the controller adds to a stop (k,)."""
        return np.zeros(len(self.plan.moves), dtype=bool)

    def settled(self, exact: Mask, settling: float) -> Floats:
        """Time of the stops `exact` (k,) of each row (k,) [s]; `settling` [s] where nothing was learnt."""
        result = np.where(exact, settling, 0.0)
        if self.timed is not None:
            result[self.timed.rows] = np.where(exact[self.timed.rows], self.timed.stop, 0.0)
        return result

    def with_whole_times(self, durations: Floats) -> Floats:
        """`durations` (k,) [s] with the learnt times of moves whose whole time was learnt."""
        return durations

    def doubts(self) -> list[str]:
        """Sentences on the uncertainty of joint moves that were never recorded."""
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
        """The timing with its 95 % interval. `times`: duration of the moves and of their stops, (k,) [s] each.

        `lines`: acceleration of linear moves whose program sets none.
        """
        ends = expected_total(self.plan, wanted, times[0], timing.total_s, self.timed, lines.doubt)
        if not lines.published:
            for says in line_doubt_of(self.plan, wanted, times[0], self.timed, lines.doubt):
                report(says)
        return replace(timing, expected=ends)


class Correction:
    """Learnt corrections of a robot; this base class corrects nothing."""

    @property
    def axis_scale(self) -> float:
        """Factor [1] on the time that the arm's axes need to reach their speed in olp's model."""
        return 1.0

    @property
    def knows_joint_moves(self) -> bool:
        """Whether joint moves need no assumption about the arm's axes."""
        return False

    def of_plan(
        self, plan: Plan, wanted: Demand, overrides: Floats, by_axes: bool, report: Report
    ) -> PlanCorrection:
        """The corrections for one plan; writes learnt accelerations into `wanted`. `overrides` (k,) [1]. Raises
        OlpError.

        `by_axes`: the prior law of the arm may time joint moves that were never recorded.
        """
        law = unlearnt_law(plan.robot) if by_axes and plan.robot is not None else None
        return PlanCorrection(plan, timed_by(law, plan, wanted, overrides, None))


def timed_by(
    law: JointLaw | None, plan: Plan, wanted: Demand, overrides: Floats, payload: float | None
) -> TimedJoints | None:
    """The plan's joint moves timed by `law`, None without a law; see `time_joints`."""
    return None if law is None else time_joints(plan, wanted, law, overrides, payload)


NOTHING_LEARNT: Final = Correction()
