"""Friction torque in proportion to speed."""

from __future__ import annotations

from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from olp.physics.term import LogTerm, Parameter

Floats = NDArray[np.float64]


class ViscousFriction(LogTerm):
    summary = "torque against motion, in proportion to speed"
    does = "the faster an axis turns, the more torque it needs at the same acceleration, in both directions alike"
    source = "B. Armstrong-Hélouvry, P. Dupont, C. Canudas de Wit, Automatica 30(7), 1994, section 2"
    confusable = ("coulomb-friction", "torque-speed", "servo-lag")
    equation: ClassVar[str] = r"\Delta\tau = b\,\dot q"
    parameters: ClassVar[tuple[Parameter, ...]] = (
        Parameter("viscous", "Nm s/rad", 0.0, 1e5, 0.0, meaning="torque per speed of the axis"),
    )

    def seen_in(self, columns: frozenset[str]) -> bool:
        return bool(columns & {"torque", "current"})


def viscous(speed: Floats) -> Floats:
    """Torque (n,) per unit of the coefficient at `speed` (n,) [rad/s | m/s]."""
    return speed
