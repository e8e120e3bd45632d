"""Axes that follow their commands late: the first-order answer of a position loop."""

from __future__ import annotations

from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from olp.timing.physics.term import LogTerm, TermParameter

Complex = NDArray[np.complex128]


class ServoLag(LogTerm):
    summary = "an axis follows its command late by a time constant"
    does = (
        "the axis lags in proportion to its speed and comes to rest as an exponential; "
        "unlike a late clock, the lag also smooths quick motion, and each axis has its own constant"
    )
    source = (
        "position loop with gain K_v = 1/T: H. Gross, J. Hamann, G. Wiegärtner, Electrical Feed Drives, 2001"
    )
    confusable = ("clock", "joint-compliance")
    equation: ClassVar[str] = r"T\,\dot q + q = q_\mathrm{cmd}"
    parameters: ClassVar[tuple[TermParameter, ...]] = (
        TermParameter(
            "time constant", "s", 0.0, 0.5, 0.0, meaning="how far behind the axis is at constant speed"
        ),
    )

    def seen_in(self, columns: frozenset[str]) -> bool:
        return bool(columns & {"command", "sim"})


def lag(omega: NDArray[np.float64], constant: float) -> Complex:
    """Transfer function from command to axis, minus 1, at `omega` (n,) [rad/s], for a time `constant` [s]."""
    away: Complex = -1j * omega * constant / (1 + 1j * omega * constant)
    return away
