"""`jerk`: acceleration ramps up and down at a finite rate."""

from __future__ import annotations

import numpy as np

from olp.timing.physics._case import Floats, MeasuredMoves
from olp.timing.physics._motion import Motion
from olp.timing.physics.term import Form, MoveTerm, Stage, TermParameter

_FILTERED = "filtered"  # every ramp passes a moving average: one time for all, not one jerk
# Behind the planner, which does not know of it: it delays an arm that stops by its length, one that passes by about
# half of it (`Motion._delay`).
_HALF = "filtered, half at corners"
_DELAYED = (
    r"T = T_0 + \tau,\; \text{to a rounded end}\; T_0 + \tau/2 + \sqrt{2 r/a} - \sqrt{2 r/a - \tau^2/12}"
)
_LONGEST = 1.0  # [s] of such an average
_OWN = "each axis"  # a jerk for each axis that leads a joint move: as much more as its acceleration is
_SHORTEST = 1e-9  # [s] below which a ramp is built up at once
_ALIKE = 1e-3  # of the accelerations: what differs by no more is one


class Jerk(MoveTerm):
    summary = "acceleration ramps up and down at a finite rate"
    does = "every full ramp takes a/j longer whatever the speed; slow moves, which never reach a, lose less"
    source = "Biagiotti and Melchiorri, Trajectory Planning for Automatic Machines and Robots, section 3.4"
    confusable = ("settling", "dispatch", "acceleration")
    stage = Stage.SHAPES
    phase = "accelerate"

    def forms(self, case: MeasuredMoves) -> tuple[Form, ...]:
        if not case.moving.any():
            return ()
        pace = case.pace
        null = _smallest(case)
        one = TermParameter(
            "jerk", f"{case.unit}/s^3", pace * 0.7, pace * 2000.0, null, True, "of every ramp"
        )
        means = "time in which acceleration builds up"
        time = TermParameter("ramp_time", "s", 0.0, _LONGEST, _longest(case.base.filtered), False, means)
        own_time = time._replace(null=_longest(case.base.build))
        each = case.base.accelerate[case.moving] / case.ratio[case.moving]
        differ = bool(case.joint.any()) and float(np.ptp(each)) > _ALIKE * float(each.max())
        differ = differ or own_time.null > 0
        own = (Form(_OWN, (own_time,), r"T = L/v + v/a + \tau,\; j = a/\tau"),)
        return (
            Form("", (one,), r"T = L/v + v/a + a/j"),
            Form(_FILTERED, (time,), r"T = L/v + v/a + \tau"),
            Form(_HALF, (time,), _DELAYED),
            *(own if differ else ()),
        )

    def guesses(self, form: Form, case: MeasuredMoves) -> Floats:
        if form.key in (_FILTERED, _HALF, _OWN):
            at = form.parameters[0].null
            return np.array([[0.02], [0.1]]) if at == 0 else at * np.array([[0.5], [2.0]])
        return np.array([[2.0], [6.0], [20.0], [70.0]]) * case.pace

    def act(self, motion: Motion, form: Form, values: Floats, case: MeasuredMoves) -> Motion:
        # The real time in the place of the simulated one, which may be the longer.
        if form.key == _FILTERED:
            return motion.with_(filtered=motion.filtered - case.base.filtered + values[0])
        if form.key == _HALF:
            more = case.moving * (values[0] - case.base.filtered)
            return motion.with_(delayed=motion.delayed + more)
        if form.key == _OWN and case.base.build.any():
            return motion.with_(build=np.where(case.base.build > 0, values[0], motion.build))
        if form.key == _OWN:
            return motion.with_(
                jerk=np.minimum(motion.jerk, case.base.accelerate / max(values[0], _SHORTEST))
            )
        # The real jerk in the place of the simulated one, which may be the smaller.
        rest = np.where(np.isfinite(case.base.jerk), np.inf, motion.jerk)
        return motion.with_(jerk=np.minimum(rest, values[0] * case.ratio))

    def says(self, form: Form, values: Floats, case: MeasuredMoves) -> str:
        if form.key in (_FILTERED, _HALF):
            time = f"{values[0] * 1000:.0f} ms"
            to_corners = ", moves to rounded corners about half of it" if form.key == _HALF else ""
            return f"acceleration builds up in {time}, whatever its size: every ramp takes that much longer{to_corners}"
        if form.key == _OWN and case.base.build.any():
            simulated = f"{form.parameters[0].null * 1000:.0f} ms"
            return f"acceleration builds up in {values[0] * 1000:.0f} ms, in the simulation in {simulated}"
        if form.key == _OWN:
            time = f"{values[0] * 1000:.0f} ms"
            return f"each axis builds up its acceleration at a jerk of its own, the simulated one in {time}"
        ramp, unit, null = case.pace / values[0], form.parameters[0].unit, form.parameters[0].null
        if np.isfinite(null):
            return f"acceleration builds up at {values[0]:.4g} {unit}, in the simulation at {null:.4g} {unit}"
        return (
            f"acceleration builds up at {values[0]:.4g} {unit}: a full ramp at the simulated acceleration takes "
            f"{ramp * 1000:.0f} ms longer"
        )


def _smallest(case: MeasuredMoves) -> float:
    """[m/s³ | rad/s³] of the simulation over the moves' `ratio`, inf where no acceleration takes time to build up."""
    return float((case.base.jerk / case.ratio).min(initial=np.inf))


def _longest(times: Floats) -> float:
    """[s] of the simulation; a wait has none."""
    return float(times.max(initial=0.0))
