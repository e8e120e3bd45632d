"""Gears and links that give way: the axis oscillates about where its motor is."""

from __future__ import annotations

from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from olp.timing.physics.term import LogTerm, TermParameter

Complex = NDArray[np.complex128]


class JointCompliance(LogTerm):
    summary = "axes oscillate after acceleration changes"
    does = (
        "the axis lags in proportion to its acceleration, and rings at one frequency after every change of it"
    )
    source = "M. W. Spong, Modeling and Control of Elastic Joint Robots, ASME J. Dyn. Syst. 109(4), 1987"
    confusable = ("servo-lag", "clock")
    equation: ClassVar[str] = r"\ddot q = \omega^2(\theta - q) + 2\zeta\omega(\dot\theta - \dot q)"
    parameters: ClassVar[tuple[TermParameter, ...]] = (
        TermParameter("frequency", "Hz", 1.0, 100.0, float("inf"), True, "of the oscillation, undamped"),
        TermParameter("damping", "1", 0.0, 1.0, 0.0, meaning="ratio: 1 is without any oscillation"),
    )

    def seen_in(self, columns: frozenset[str]) -> bool:
        return bool(columns & {"command", "sim"})


def swing(omega: NDArray[np.float64], frequency: float, damping: float) -> Complex:
    """Transfer function from motor to axis, minus 1, at `omega` (n,) [rad/s]; `frequency` [rad/s], `damping` [1]."""
    below = frequency**2 + 2j * damping * frequency * omega
    away: Complex = omega**2 / (below - omega**2)
    return away
