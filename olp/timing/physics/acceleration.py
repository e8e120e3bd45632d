"""`acceleration`: the real constant acceleration differs from the simulated one."""

from __future__ import annotations

import numpy as np

from olp.timing.physics._case import Floats, MeasuredMoves
from olp.timing.physics._motion import Motion
from olp.timing.physics.term import Form, MoveTerm, Stage, TermParameter

_WIDEST = 8.0  # times the simulated acceleration, and one over it
_ALIKE = 1e-3
_ALONG = "along the way"


class AccelerationTerm(MoveTerm):
    summary = "the real constant acceleration differs from the simulated one"
    does = "every ramp is longer or shorter by the same ratio: time lost grows with the speed, not with the length"
    source = "N. Apostolovic, An innovative method … (docs/thesis.md), equations 4.6 and 6.1"
    confusable = ("coulomb-friction", "jerk", "settling", "dispatch", "torque-speed", "speed-scale")
    stage = Stage.SCALES
    phase = "accelerate"

    def forms(self, case: MeasuredMoves) -> tuple[Form, ...]:
        if not case.moving.any():
            return ()
        nominal = (case.base.accelerate / case.ratio)[case.moving]
        pace = case.pace
        if np.ptp(nominal) <= _ALIKE * pace:
            unit = f"{case.unit}/s^2"
            one = TermParameter(
                "acceleration", unit, pace / _WIDEST, pace * _WIDEST, pace, True, "of every ramp"
            )
            return (Form("", (one,), r"T = L/v + v/a"), *_along_the_way(case, one, "a"))
        one = TermParameter("scale", "1", 1 / _WIDEST, _WIDEST, 1.0, True, "real over simulated acceleration")
        whole = Form("", (one,), r"T = L/v + v/(k\,a)")
        return (whole, *_along_the_way(case, one, r"(k\,a)"), *_of_axes(case))

    def guesses(self, form: Form, case: MeasuredMoves) -> Floats:
        return np.array([[0.75], [1.3]]) * form.parameters[0].null

    def act(self, motion: Motion, form: Form, values: Floats, case: MeasuredMoves) -> Motion:
        scale = np.full(len(case), values[0] / form.parameters[0].null)
        if form.axis >= 0:
            scale = np.where(case.led(form.axis) & case.joint, scale, 1.0)
        changed = motion.with_(accelerate=motion.accelerate * scale, decelerate=motion.decelerate * scale)
        if case.base.shortest.any():
            # Ramps that take one time, whatever the speed, are those of the drives: stronger ones take less.
            own = np.abs(case.base.accelerate * case.base.shortest / case.base.top() - 1.0) < _ALIKE
            changed = changed.with_(shortest=motion.shortest / np.where(own, np.maximum(scale, 1.0), 1.0))
        if form.key == _ALONG:
            return changed
        return changed.with_(
            open_start=motion.open_start * scale,
            open_end=motion.open_end * scale,
        )

    def says(self, form: Form, values: Floats, case: MeasuredMoves) -> str:
        ratio = values[0] / form.parameters[0].null
        absolute = f"{values[0]:.4g} {form.parameters[0].unit}, " if form.parameters[0].unit != "1" else ""
        if form.axis >= 0:
            return f"where {form.key} leads, the real acceleration is {ratio:.1%} of the simulated one"
        corners = ", corners are passed as simulated" if form.key == _ALONG else ""
        return f"the real acceleration is {absolute}{ratio:.1%} of the simulated one{corners}"


def _along_the_way(case: MeasuredMoves, one: TermParameter, slow: str) -> tuple[Form, ...]:
    """Ramps alone: how fast a controller that looks ahead passes a corner hangs on what it allows across the way, which
    need not be what its drives give along it."""
    if not case.base.looks_ahead:
        return ()
    return (Form(_ALONG, (one,), rf"T = L/v + v/{slow},\ v_c\ \text{{as simulated}}"),)


def _of_axes(case: MeasuredMoves) -> tuple[Form, ...]:
    """One factor per leading axis of joint moves, if several axes lead."""
    forms = []
    for axis, name in case.leaders:
        of = f"scale_{name.lower().replace(' ', '_')}"
        one = TermParameter(
            of, "1", 1 / _WIDEST, _WIDEST, 1.0, True, f"real over simulated acceleration of {name}"
        )
        forms.append(Form(name, (one,), r"T = L/v + v/(k_j\,a)", axis))
    return tuple(forms)
