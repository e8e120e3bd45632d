"""`external-wait`: time lost at certain moves for reasons outside the arm (signals, sensors), often scattered."""

from __future__ import annotations

import numpy as np

from olp.timing.physics._case import Floats, MeasuredMoves
from olp.timing.physics._motion import Motion
from olp.timing.physics.term import Form, MoveTerm, Stage


class ExternalWait(MoveTerm):
    summary = "time lost at certain moves for reasons outside the arm (signals, sensors), often scattered"
    does = "a few moves are much longer, by times of their own; all others are as simulated"
    equation = r"T_i = T_{0,i} + w_i"
    source = "handshakes in cell programs; found as one-sided outliers (F. R. Hampel et al., Robust Statistics, 1986)"
    confusable = ("settling", "dispatch")
    stage = Stage.ADDS

    def forms(self, case: MeasuredMoves) -> tuple[Form, ...]:
        """No forms: the waits are found in the residuals, see olp/identification/diagnosis/waits.py."""
        return ()

    def guesses(self, form: Form, case: MeasuredMoves) -> Floats:
        return np.zeros((0, 0))

    def act(self, motion: Motion, form: Form, values: Floats, case: MeasuredMoves) -> Motion:
        return motion.with_(added=motion.added + values)
