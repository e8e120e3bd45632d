"""`payload-inertia`: acceleration of the wrist axes falls with the load's moment of inertia."""

from __future__ import annotations

import numpy as np

from olp.physics._case import Case, Floats
from olp.physics._motion import Motion
from olp.physics._ramps import over_ramp
from olp.physics.term import Form, MoveTerm, Parameter, Stage

_FIRST_OF_WRIST = 3


class PayloadInertia(MoveTerm):
    summary = "acceleration of the wrist axes falls with the load's moment of inertia"
    does = "moves that turn the wrist are longer with bulky loads; moves that do not are as simulated"
    source = "Euler's equation with a constant torque: rate of the wrist = torque / (I0 + I)"
    confusable = ("payload", "orientation-limit")
    stage = Stage.SCALES
    phase = "accelerate"

    def forms(self, case: Case) -> tuple[Form, ...]:
        inertia = case.payload_inertia[case.moving]
        known = inertia[np.isfinite(inertia)]
        if not len(known) or np.ptp(known) <= 1e-4 * max(1.0, float(np.max(known))) or not _wrist(case).any():
            return ()
        one = Parameter(
            "growth", "1/(kg m^2)", 0.0, 8.0 / float(np.max(known)), 0.0, False, "of the wrist's inertia"
        )
        share = Form("", (one,), r"a(I) = a / (1 + k I w)")
        every = Form("every move", (one,), r"a(I) = a / (1 + k I)")
        if case.rates is None or case.rates.rated_acceleration is None:
            return (share, every)
        return (share, every, Form("limit", (one,), r"a(I) \le A_j / (1 + k I) / |q_j'|, \quad j = 4, 5, 6"))

    def lacks(self, case: Case) -> str:
        return (
            "" if self.forms(case) else "payload_inertia_kg_m2 with two values, and moves that turn the wrist"
        )

    def guesses(self, form: Form, case: Case) -> Floats:
        return np.array([[0.02], [0.15]]) * form.parameters[0].high

    def act(self, motion: Motion, form: Form, values: Floats, case: Case) -> Motion:
        if form.key == "limit":
            less = 1.0 + values[0] * np.nan_to_num(case.payload_inertia)
            start, end = (case.once(f"wrist limit {k}", lambda k=k: _limits(case, k)) for k in (0, 1))  # type: ignore[misc]
            return motion.with_(
                accelerate=_limited(motion.accelerate, start, less),
                decelerate=_limited(motion.decelerate, end, less),
            )
        share = case.once("wrist inertia", lambda: _wrist(case) * np.nan_to_num(case.payload_inertia))
        if form.key == "every move":
            share = np.nan_to_num(case.payload_inertia)
        less = 1.0 + values[0] * share
        return motion.with_(accelerate=motion.accelerate / less, decelerate=motion.decelerate / less)

    def says(self, form: Form, values: Floats, case: Case) -> str:
        most = float(np.nanmax(case.payload_inertia))
        return f"with {most:.3g} kg m² moves of the wrist have {1 - 1 / (1 + values[0] * most):.0%} less acceleration"


def _wrist(case: Case) -> Floats:
    """(n,) share of the turning that the wrist does: its fastest axis over the fastest of all."""
    rates = case.rates
    if rates is None or rates.path.shape[2] <= _FIRST_OF_WRIST:
        return np.zeros(len(case))
    mean = np.abs(rates.path).mean(axis=1)
    most = mean.max(axis=1)
    return np.asarray(
        np.where(most > 0, mean[:, _FIRST_OF_WRIST:].max(axis=1) / np.where(most > 0, most, 1.0), 0.0)
    )


def _limited(slow: Floats, limit: Floats, less: Floats) -> Floats:
    """(n,) an acceleration under a limit that is `less` times smaller; the whole limit is simulated already."""
    return np.asarray(slow * np.minimum(slow, np.maximum(limit / less, 1e-6)) / np.minimum(slow, limit))


def _limits(case: Case, end: int) -> Floats:
    """(n,) of the path by the wrist's rated accelerations over one ramp, inf where the wrist does not turn."""
    rates = case.rates
    assert rates is not None
    assert rates.rated_acceleration is not None
    wrist = np.abs(rates.path[:, :, _FIRST_OF_WRIST:]) / rates.rated_acceleration[_FIRST_OF_WRIST:]
    with np.errstate(divide="ignore"):
        return np.asarray(1.0 / over_ramp(case, wrist.max(axis=2), end))
