"""Friction torque in proportion to speed."""

from __future__ import annotations

from typing import ClassVar

import numpy as np

from olp.physics._case import Case, Floats
from olp.physics._motion import Motion
from olp.physics.term import Form, LogTerm, MoveTerm, Parameter, Stage

_MOST = 0.95  # of the force that friction may take at the highest speed


class ViscousFriction(MoveTerm, LogTerm):
    summary = "torque against motion, in proportion to speed"
    does = "the faster an axis turns, the more torque it needs at the same acceleration, in both directions alike"
    source = "B. Armstrong-Hélouvry, P. Dupont, C. Canudas de Wit, Automatica 30(7), 1994, section 2"
    confusable = ("coulomb-friction", "torque-speed", "servo-lag")
    equation: ClassVar[str] = r"\Delta\tau = b\,\dot q"
    parameters: ClassVar[tuple[Parameter, ...]] = (
        Parameter("viscous", "Nm s/rad", 0.0, 1e5, 0.0, meaning="torque per speed of the axis"),
    )

    stage = Stage.SCALES
    phase = "accelerate"

    def forms(self, case: Case) -> tuple[Form, ...]:
        speed = (case.base.speed / case.ratio)[case.moving]
        if not len(speed) or np.ptp(speed) <= 0:
            return ()
        loss = Parameter("loss", "s/m", 0.0, _MOST / float(speed.max()), 0.0, False, "of the force per speed")
        return (Form("", (loss,), r"a_{acc} = a\,(1 - k v),\; a_{dec} = a\,(1 + k v)"),)

    def guesses(self, form: Form, case: Case) -> Floats:
        return np.array([[0.3], [0.8]]) * form.parameters[0].high

    def act(self, motion: Motion, form: Form, values: Floats, case: Case) -> Motion:
        """Ramps whose force falls, or grows, with the speed: ∫ dv / (1 ∓ k v)."""
        share = np.clip(values[0] * motion.speed / case.ratio, 1e-9, _MOST)
        return motion.with_(
            accelerate=motion.accelerate * share / -np.log1p(-share),
            decelerate=motion.decelerate * share / np.log1p(share),
        )

    def says(self, form: Form, values: Floats, case: Case) -> str:
        top = float((case.base.speed / case.ratio)[case.moving].max())
        return f"friction takes {values[0] * top:.0%} of the force at {top:.3g} {case.unit}/s"

    def seen_in(self, columns: frozenset[str]) -> bool:
        return bool(columns & {"torque", "current"})


def viscous(speed: Floats) -> Floats:
    """Torque (n,) per unit of the coefficient at `speed` (n,) [rad/s | m/s]."""
    return speed
