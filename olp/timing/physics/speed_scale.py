"""`speed-scale`: cruising is slower or faster by one factor."""

from __future__ import annotations

import numpy as np

from olp.timing.physics._case import Floats, MeasuredMoves
from olp.timing.physics._motion import Motion
from olp.timing.physics.term import Form, MoveTerm, Stage, TermParameter

_STRETCHED, _OVERRIDE = "stretched", "override"
# Overrides are set in whole percents: what rounds to 100 % is a clock sooner than an override.
_LEAST, _UNSET = 0.005, 4.0


class SpeedScale(MoveTerm):
    summary = "cruising is slower or faster by one factor (override, speed calibration, clock rate)"
    does = "time lost grows with the time spent at speed; at a lower speed ramps get shorter"
    source = "speed override of controllers ($OV_PRO of KRL, SPEED of INFORM): v = k v_programmed"
    confusable = ("clock", "speed-clamp", "acceleration")
    stage = Stage.SCALES
    phase = "cruise"

    def forms(self, case: MeasuredMoves) -> tuple[Form, ...]:
        if not case.moving.any():
            return ()
        scale = TermParameter("scale", "1", 0.2, 5.0, 1.0, True, "real over simulated speed")
        stretched = Form(_STRETCHED, (scale,), r"T = T_0/k")
        if len(case.override) != len(case) or (case.override == 1.0).all():
            return (Form("", (scale,), r"T = L/(k v) + k v/a"), stretched, *_of_axes(case, scale))
        power = TermParameter(
            "power", "1", -0.5, 2.0, 0.0, False, "of the override, real over simulated: 1 in proportion"
        )
        return (
            Form(_OVERRIDE, (power,), r"T = T_0/o^p"),
            Form(_OVERRIDE + " of the speed", (power,), r"T = L/(o^p v) + o^p v/a"),
            Form("", (scale,), r"T = L/(k v) + k v/a"),
            stretched,
            *_of_axes(case, scale),
        )

    def guesses(self, form: Form, case: MeasuredMoves) -> Floats:
        return np.array([[0.5], [1.0]] if form.key.startswith(_OVERRIDE) else [[0.93], [1.07]])

    def act(self, motion: Motion, form: Form, values: Floats, case: MeasuredMoves) -> Motion:
        scale = np.full(len(case), values[0])
        if form.axis >= 0:
            scale = np.where(case.led(form.axis) & case.joint, scale, 1.0)
        if form.key.startswith(_OVERRIDE):
            scale = case.override ** values[0]
        if form.key in (_STRETCHED, _OVERRIDE):
            return motion.with_(rate=motion.rate / np.where(case.moving, scale, 1.0))
        return motion.with_(speed=motion.speed * scale)

    def doubt(self, form: Form, values: Floats) -> float:
        return _UNSET if form.key == _STRETCHED and abs(values[0] - 1.0) < _LEAST else 0.0

    def says(self, form: Form, values: Floats, case: MeasuredMoves) -> str:
        if form.key.startswith(_OVERRIDE):
            how = "cruising speeds" if form.key.endswith("speed") else "speeds and ramps"
            return f"{how} go with the override to the power of {values[0]:.3g}"
        if form.key == _STRETCHED:
            return f"moves run at {values[0]:.2%} of the simulated pace, ramps included: an override"
        if form.axis >= 0:
            return f"where {form.key} leads, moves cruise at {values[0]:.2%} of the simulated speed"
        return f"moves cruise at {values[0]:.2%} of the simulated speed"


def _of_axes(case: MeasuredMoves, scale: TermParameter) -> tuple[Form, ...]:
    """One factor per leading axis of joint moves, if several axes lead."""
    return tuple(
        Form(
            name,
            (
                scale._replace(
                    name=f"scale_{name.lower().replace(' ', '_')}",
                    meaning=f"real over simulated speed of {name}",
                ),
            ),
            r"T = L/(k_j v) + k_j v/a",
            axis,
        )
        for axis, name in case.leaders
    )
