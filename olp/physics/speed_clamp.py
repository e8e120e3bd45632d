"""`speed-clamp`: programmed speeds above some value are not reached."""

from __future__ import annotations

import numpy as np

from olp.physics._case import Case, Floats
from olp.physics._motion import Motion
from olp.physics.term import Form, MoveTerm, Parameter, Stage


class SpeedClamp(MoveTerm):
    summary = "programmed speeds above some value are not reached"
    does = "fast moves are longer in proportion to their length; moves below the clamp are as simulated"
    source = (
        "maximum TCP speed of controllers (safety-rated reduced speed, ISO 10218-1, 250 mm/s in manual mode)"
    )
    confusable = ("speed-scale", "joint-speed-limit", "torque-speed")
    stage = Stage.LIMITS
    phase = "cruise"

    def forms(self, case: Case) -> tuple[Form, ...]:
        speed = _speeds(case)
        if not len(speed):
            return ()
        top, unit = float(speed.max()), f"{case.unit}/s"
        clamp = Parameter(
            "clamp", unit, 0.3 * float(speed.min()), top, np.inf, True, "the most that is reached"
        )
        return (Form("", (clamp,), r"v \le v_{max}"),)

    def guesses(self, form: Form, case: Case) -> Floats:
        levels = np.unique(np.round(_speeds(case), 6))
        if len(levels) > 5:
            levels = np.quantile(levels, [0.3, 0.6, 0.8, 0.9, 1.0])
        return np.unique(np.concatenate([0.95 * levels, 0.8 * levels]))[:, None]

    def act(self, motion: Motion, form: Form, values: Floats, case: Case) -> Motion:
        return motion.with_(speed=np.minimum(motion.speed, values[0] * case.ratio))

    def says(self, form: Form, values: Floats, case: Case) -> str:
        if case.unit == "m":
            return f"no move is faster than {values[0] * 1000:.4g} mm/s, whatever is programmed"
        return f"no move is faster than {np.degrees(values[0]):.4g} deg/s, whatever is programmed"


def _speeds(case: Case) -> Floats:
    """Speeds that straight moves ask for; where there are none, those of joint moves."""
    wanted = case.moving & (~case.joint if (case.moving & ~case.joint).any() else case.joint)
    return np.asarray(case.base.speed[wanted])
