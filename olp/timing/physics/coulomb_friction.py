"""Friction torque that depends on the direction of motion only."""

from __future__ import annotations

from typing import ClassVar

import numpy as np

from olp.timing.physics._case import Floats, MeasuredMoves
from olp.timing.physics._motion import Motion
from olp.timing.physics.term import Form, LogTerm, MoveTerm, Stage, TermParameter

_INFERRED = 4.0  # in BIC: durations never tell it from another acceleration, which is the plainer name


class CoulombFriction(MoveTerm, LogTerm):
    summary = "torque against motion, the same at every speed"
    does = "torque steps by twice its size where an axis reverses; slow motion needs as much as quick motion"
    source = "B. Armstrong-Hélouvry, P. Dupont, C. Canudas de Wit, Automatica 30(7), 1994, section 2"
    confusable = ("viscous-friction", "backlash", "gravity")
    equation: ClassVar[str] = r"\Delta\tau = c\,\operatorname{sign}\dot q"
    parameters: ClassVar[tuple[TermParameter, ...]] = (
        TermParameter("coulomb", "Nm", 0.0, 1e5, 0.0, meaning="torque against motion at any speed"),
    )

    stage = Stage.SCALES
    phase = "accelerate"

    def forms(self, case: MeasuredMoves) -> tuple[Form, ...]:
        if not case.moving.any():
            return ()
        share = TermParameter("share", "1", 0.0, 0.95, 0.0, False, "of the force that friction takes")
        return (Form("", (share,), r"a_{acc} = a\,(1 - k),\; a_{dec} = a\,(1 + k)"),)

    def guesses(self, form: Form, case: MeasuredMoves) -> Floats:
        return np.array([[0.3], [0.7]])

    def doubt(self, form: Form, values: Floats) -> float:
        return _INFERRED

    def act(self, motion: Motion, form: Form, values: Floats, case: MeasuredMoves) -> Motion:
        return motion.with_(
            accelerate=motion.accelerate * (1.0 - values[0]), decelerate=motion.decelerate * (1.0 + values[0])
        )

    def says(self, form: Form, values: Floats, case: MeasuredMoves) -> str:
        return f"dry friction takes {values[0]:.0%} of the force from speeding up and gives it to braking"

    def seen_in(self, columns: frozenset[str]) -> bool:
        return bool(columns & {"torque", "current"})


def coulomb(speed: Floats, soft: float) -> Floats:
    """Torque (n,) per unit of the coefficient: a step smoothed over `soft` [rad/s | m/s], because noise hides the
    direction near rest.
    """
    return np.tanh(speed / soft) if soft > 0 else np.sign(speed)
