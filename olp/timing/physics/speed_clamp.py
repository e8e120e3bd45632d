"""`speed-clamp`: programmed speeds above some value are not reached."""

from __future__ import annotations

import numpy as np

from olp.timing.physics._case import Floats, Mask, MeasuredMoves
from olp.timing.physics._limits import limits_reached
from olp.timing.physics._motion import Motion
from olp.timing.physics.term import Form, MoveTerm, Stage, TermParameter


class SpeedClamp(MoveTerm):
    summary = "programmed speeds above some value are not reached"
    does = "fast moves are longer in proportion to their length; moves below the clamp are as simulated"
    source = (
        "maximum TCP speed of controllers (safety-rated reduced speed, ISO 10218-1, 250 mm/s in manual mode)"
    )
    confusable = ("speed-scale", "joint-speed-limit", "torque-speed")
    stage = Stage.LIMITS
    phase = "cruise"

    def forms(self, case: MeasuredMoves) -> tuple[Form, ...]:
        speed = _speeds(case)
        if not len(speed):
            return ()
        top, unit = float(speed.max()), f"{case.unit}/s"
        clamp = TermParameter(
            "clamp", unit, 0.3 * float(speed.min()), top, np.inf, True, "the most that is reached"
        )
        return (Form("", (clamp,), r"v \le v_{max}"),)

    def guesses(self, form: Form, case: MeasuredMoves) -> Floats:
        # What moves reach: on short ways that is less than what is programmed.
        wanted = _wanted(case)
        levels = limits_reached(case.base.top()[wanted])
        return np.clip(levels, form.parameters[0].low, form.parameters[0].high)[:, None]

    def act(self, motion: Motion, form: Form, values: Floats, case: MeasuredMoves) -> Motion:
        wanted = case.once("clamped", lambda: _wanted(case).astype(np.float64)) > 0
        clamped = np.where(wanted, values[0], np.inf)
        return motion.with_(speed=np.minimum(motion.speed, clamped))

    def says(self, form: Form, values: Floats, case: MeasuredMoves) -> str:
        if case.unit == "m":
            return f"the speed limit of all moves is {values[0] * 1000:.4g} mm/s, whatever is programmed"
        return f"the speed limit of all moves is {np.degrees(values[0]):.4g} deg/s, whatever is programmed"


def _speeds(case: MeasuredMoves) -> Floats:
    return np.asarray(case.base.speed[_wanted(case)])


def _wanted(case: MeasuredMoves) -> Mask:
    """Straight moves (n,); joint moves if there are no straight ones."""
    return np.asarray(case.moving & (~case.joint if (case.moving & ~case.joint).any() else case.joint))
