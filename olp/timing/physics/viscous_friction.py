"""Friction torque in proportion to speed."""

from __future__ import annotations

from typing import ClassVar

import numpy as np

from olp.timing.physics._case import Floats, MeasuredMoves
from olp.timing.physics._motion import Motion
from olp.timing.physics.term import Form, LogTerm, MoveTerm, Stage, TermParameter

_MOST = 0.95  # of the force that friction may take at the highest speed


class ViscousFriction(MoveTerm, LogTerm):
    summary = "torque against motion, in proportion to speed"
    does = "the faster an axis turns, the more torque it needs at the same acceleration, in both directions alike"
    source = "B. Armstrong-Hélouvry, P. Dupont, C. Canudas de Wit, Automatica 30(7), 1994, section 2"
    confusable = ("coulomb-friction", "torque-speed", "servo-lag")
    equation: ClassVar[str] = r"\Delta\tau = b\,\dot q"
    parameters: ClassVar[tuple[TermParameter, ...]] = (
        TermParameter("viscous", "Nm s/rad", 0.0, 1e5, 0.0, meaning="torque per speed of the axis"),
    )

    stage = Stage.SCALES
    phase = "accelerate"

    def forms(self, case: MeasuredMoves) -> tuple[Form, ...]:
        share = _shares(case)[case.moving]
        if not len(share) or np.ptp(share) <= 0:
            return ()
        loss = TermParameter(
            "loss", "1/s", 0.0, _MOST / float(share.max()), 0.0, False, "of acceleration per speed"
        )
        return (Form("", (loss,), r"a_{acc} = a - k v,\; a_{dec} = a + k v"),)

    def guesses(self, form: Form, case: MeasuredMoves) -> Floats:
        return np.array([[0.3], [0.8]]) * form.parameters[0].high

    def act(self, motion: Motion, form: Form, values: Floats, case: MeasuredMoves) -> Motion:
        """Ramps whose force falls, or grows, with the speed: ∫ dv / (a ∓ k v)."""
        top = motion.top()
        share = np.clip(values[0] * top / motion.accelerate, 1e-4, _MOST)
        back = np.clip(values[0] * top / motion.decelerate, 1e-4, None)
        # What a ramp costs beyond its way at full speed V: ∫ (1 - v/V) dv / (a ∓ k v), V/2a without friction.
        slower = 2.0 * (share + (1.0 - share) * np.log1p(-share)) / share**2
        faster = 2.0 * ((1.0 + back) * np.log1p(back) - back) / back**2
        return motion.with_(
            accelerate=motion.accelerate / slower,
            decelerate=motion.decelerate / faster,
        )

    def says(self, form: Form, values: Floats, case: MeasuredMoves) -> str:
        most = values[0] * float(_shares(case)[case.moving].max())
        return f"friction takes up to {most:.0%} of the force at the programmed speeds"

    def seen_in(self, columns: frozenset[str]) -> bool:
        return bool(columns & {"torque", "current"})


def viscous(speed: Floats) -> Floats:
    """Torque (n,) per unit of the coefficient at `speed` (n,) [rad/s | m/s]."""
    return speed


def _shares(case: MeasuredMoves) -> Floats:
    """Speed over acceleration of the simulation (n,) [s]."""
    return np.asarray(case.base.top() / case.base.accelerate)
