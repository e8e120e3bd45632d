"""`acceleration`: the real constant acceleration differs from the simulated one."""

from __future__ import annotations

import numpy as np

from olp.physics._case import Case, Floats
from olp.physics._motion import Motion
from olp.physics.term import Form, MoveTerm, Parameter, Stage

_WIDEST = 8.0  # times the simulated acceleration, and one over it
_ALIKE = 1e-3


class Acceleration(MoveTerm):
    summary = "the real constant acceleration differs from the simulated one"
    does = "every ramp is longer or shorter by the same ratio: time lost grows with the speed, not with the length"
    source = (
        "N. Apostolovic, An innovative method …, Memorial University of Newfoundland, equation 4.6 and 6.1"
    )
    confusable = ("coulomb-friction", "jerk", "settling", "dispatch", "torque-speed", "speed-scale")
    stage = Stage.SCALES
    phase = "accelerate"

    def forms(self, case: Case) -> tuple[Form, ...]:
        if not case.moving.any():
            return ()
        nominal = (case.base.accelerate / case.ratio)[case.moving]
        pace = case.pace
        if np.ptp(nominal) <= _ALIKE * pace:
            unit = f"{case.unit}/s^2"
            one = Parameter("acceleration", unit, pace / _WIDEST, pace * _WIDEST, pace, True, "of every ramp")
            return (Form("", (one,), r"T = L/v + v/a"),)
        one = Parameter("scale", "1", 1 / _WIDEST, _WIDEST, 1.0, True, "real over simulated acceleration")
        return (Form("", (one,), r"T = L/v + v/(k\,a)"),)

    def guesses(self, form: Form, case: Case) -> Floats:
        return np.array([[0.75], [1.3]]) * form.parameters[0].null

    def act(self, motion: Motion, form: Form, values: Floats, case: Case) -> Motion:
        scale = values[0] / form.parameters[0].null
        return motion.with_(accelerate=motion.accelerate * scale, decelerate=motion.decelerate * scale)

    def says(self, form: Form, values: Floats, case: Case) -> str:
        ratio = values[0] / form.parameters[0].null
        absolute = f"{values[0]:.4g} {form.parameters[0].unit}, " if form.parameters[0].unit != "1" else ""
        return f"the real acceleration is {absolute}{ratio:.1%} of the simulated one"
