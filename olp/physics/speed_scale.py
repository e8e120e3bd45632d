"""`speed-scale`: cruising is slower or faster by one factor."""

from __future__ import annotations

import numpy as np

from olp.physics._case import Case, Floats
from olp.physics._motion import Motion
from olp.physics.term import Form, MoveTerm, Parameter, Stage


class SpeedScale(MoveTerm):
    summary = "cruising is slower or faster by one factor (override, speed calibration, clock rate)"
    does = "time lost grows with the time spent at speed; ramps even get shorter when the speed is lower"
    source = "speed override of controllers ($OV_PRO of KRL, SPEED of INFORM): v = k v_programmed"
    confusable = ("clock", "speed-clamp", "acceleration")
    stage = Stage.SCALES
    phase = "cruise"

    def forms(self, case: Case) -> tuple[Form, ...]:
        if not case.moving.any():
            return ()
        scale = Parameter("scale", "1", 0.2, 5.0, 1.0, True, "real over simulated speed")
        return (Form("", (scale,), r"T = L/(k v) + k v/a"),)

    def guesses(self, form: Form, case: Case) -> Floats:
        return np.array([[0.93], [1.07]])

    def act(self, motion: Motion, form: Form, values: Floats, case: Case) -> Motion:
        return motion.with_(speed=motion.speed * values[0])

    def says(self, form: Form, values: Floats, case: Case) -> str:
        return f"moves cruise at {values[0]:.2%} of the simulated speed"
