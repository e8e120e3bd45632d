"""Friction torque that depends on the direction of motion only."""

from __future__ import annotations

from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from olp.physics.term import LogTerm, Parameter

Floats = NDArray[np.float64]


class CoulombFriction(LogTerm):
    summary = "torque against motion, the same at every speed"
    does = (
        "the torque steps by twice its size where an axis reverses; slow motion needs as much as quick motion"
    )
    source = "B. Armstrong-Hélouvry, P. Dupont, C. Canudas de Wit, Automatica 30(7), 1994, section 2"
    confusable = ("viscous-friction", "backlash", "gravity")
    equation: ClassVar[str] = r"\Delta\tau = c\,\operatorname{sign}\dot q"
    parameters: ClassVar[tuple[Parameter, ...]] = (
        Parameter("coulomb", "Nm", 0.0, 1e5, 0.0, meaning="torque against motion at any speed"),
    )

    def seen_in(self, columns: frozenset[str]) -> bool:
        return bool(columns & {"torque", "current"})


def coulomb(speed: Floats, soft: float) -> Floats:
    """Torque (n,) per unit of the coefficient, a step `soft` [rad/s | m/s] wide: noise hides the direction there."""
    return np.tanh(speed / soft) if soft > 0 else np.sign(speed)
