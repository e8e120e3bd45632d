"""The recorder's clock runs at another rate, has another origin, or its channels are not sampled at one instant."""

from __future__ import annotations

from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from olp.timing.physics._case import Floats, MeasuredMoves
from olp.timing.physics._motion import Motion
from olp.timing.physics.term import Form, LogTerm, MoveTerm, Stage, TermParameter

Complex = NDArray[np.complex128]


class Clock(MoveTerm, LogTerm):
    summary = "the recorder's time runs at another rate or offset"
    does = (
        "all axes are late by the same time, whatever their speed, load or acceleration; at another rate "
        "the lateness grows with time, rests included"
    )
    source = "straight line between two clocks; a pure delay has the gain 1 at every frequency"
    confusable = ("servo-lag", "speed-scale", "joint-compliance")
    equation: ClassVar[str] = r"t_\mathrm{log} = t_0 + r\,t"
    parameters: ClassVar[tuple[TermParameter, ...]] = (
        TermParameter("offset", "s", -1e9, 1e9, 0.0, meaning="by which the recorder's clock is ahead"),
        TermParameter("rate", "1", 0.5, 2.0, 1.0, meaning="seconds of the recorder in a second"),
    )

    stage = Stage.CLOCKS
    conditionable = False

    def forms(self, case: MeasuredMoves) -> tuple[Form, ...]:
        rate = TermParameter("rate", "1", 0.9, 1.1, 1.0, True, "seconds of the recorder in a second")
        return (Form("", (rate,), r"T_\mathrm{recorded} = r\,T"),)

    def guesses(self, form: Form, case: MeasuredMoves) -> Floats:
        return np.array([[0.99], [1.01]])

    def act(self, motion: Motion, form: Form, values: Floats, case: MeasuredMoves) -> Motion:
        return motion.with_(rate=motion.rate * values[0])

    def says(self, form: Form, values: Floats, case: MeasuredMoves) -> str:
        which = "fast" if values[0] > 1 else "slow"
        return f"the recorder's clock runs {abs(values[0] - 1):.3%} {which}: all durations are off by it"

    def seen_in(self, columns: frozenset[str]) -> bool:
        return bool(columns & {"command", "sim"})


def shift(omega: NDArray[np.float64], late: float) -> Complex:
    """Transfer function of a delay of `late` [s], minus 1, at `omega` (n,) [rad/s]."""
    away: Complex = np.exp(-1j * omega * late) - 1
    return away
