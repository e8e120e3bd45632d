"""`payload`: acceleration falls with the carried mass."""

from __future__ import annotations

import numpy as np

from olp.physics._case import Case, Floats
from olp.physics._motion import Motion
from olp.physics.term import Form, MoveTerm, Parameter, Stage

_SPREAD = 0.1  # [kg]


class Payload(MoveTerm):
    summary = "acceleration falls with the carried mass"
    does = "ramps of moves with more payload are longer; moves without are as simulated"
    source = "Newton's second law with a constant force: a = F / (m0 + m); Apostolovic, equation 6.19 (carried mass)"
    confusable = ("payload-inertia", "acceleration")
    stage = Stage.SCALES
    phase = "accelerate"

    def forms(self, case: Case) -> tuple[Form, ...]:
        mass = case.payload[case.moving]
        if not len(mass) or np.isnan(mass).all() or np.nanmax(mass) - np.nanmin(mass) < _SPREAD:
            return ()
        one = Parameter(
            "growth", "1/kg", 0.0, 8.0 / float(np.nanmax(mass)), 0.0, False, "of the inertia per kilogram"
        )
        loss = Parameter(
            "loss", "1/kg", 0.0, 0.95 / float(np.nanmax(mass)), 0.0, False, "of the force per kilogram"
        )
        forms = [Form("", (one,), r"a(m) = a / (1 + k m)"), Form("weight", (loss,), r"a(m) = a\,(1 - k m)")]
        if np.nanmin(mass) > _SPREAD:
            forms.append(Form("above the lightest", (one,), r"a(m) = a / (1 + k (m - m_{min}))"))
        return tuple(forms)

    def lacks(self, case: Case) -> str:
        return "" if self.forms(case) else "payload_kg, with at least two different masses"

    def guesses(self, form: Form, case: Case) -> Floats:
        return np.array([[0.02], [0.1]]) * form.parameters[0].high

    def act(self, motion: Motion, form: Form, values: Floats, case: Case) -> Motion:
        if form.key == "weight":
            rest = 1.0 - values[0] * np.nan_to_num(case.payload)
            return motion.with_(accelerate=motion.accelerate * rest, decelerate=motion.decelerate * rest)
        least = _lightest(case) if form.key else 0.0
        less = 1.0 + values[0] * np.nan_to_num(case.payload - least)
        return motion.with_(accelerate=motion.accelerate / less, decelerate=motion.decelerate / less)

    def says(self, form: Form, values: Floats, case: Case) -> str:
        least, most = _lightest(case), float(np.nanmax(case.payload))
        base = least if form.key == "above the lightest" else 0.0
        less = values[0] * most if form.key == "weight" else 1.0 - 1.0 / (1.0 + values[0] * (most - base))
        return f"with {most:.4g} kg there is {less:.0%} less acceleration than with {base:.4g} kg"


def _lightest(case: Case) -> float:
    """[kg]"""
    return case.number("lightest payload", lambda: float(np.nanmin(case.payload)))
