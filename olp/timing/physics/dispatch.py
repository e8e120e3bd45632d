"""`dispatch`: a fixed time per executed move, stop or not."""

from __future__ import annotations

import numpy as np

from olp.timing.physics._case import Floats, MeasuredMoves
from olp.timing.physics._motion import Motion
from olp.timing.physics.term import Form, MoveTerm, Stage, TermParameter

# A time that is less than simulated: only where the simulation already holds one that is too long.
_LESS = 12.0


class Dispatch(MoveTerm):
    summary = "a fixed time per executed move, stop or not"
    does = "every move is longer by the same time, whatever its length, speed and end"
    source = "instruction time of controllers: interpreting and preparing a move costs cycles"
    confusable = ("settling", "jerk", "acceleration")
    stage = Stage.ADDS

    def forms(self, case: MeasuredMoves) -> tuple[Form, ...]:
        if not case.moving.any():
            return ()
        least = -min(case.idle(case.moving), 1.0)
        time = TermParameter("time", "s", least, 3.0, 0.0, False, "per executed move")
        moves = Form("", (time,), r"T = T_0 + t_d")
        if case.moving.all():
            return (moves,)
        return (moves, Form("waits too", (time,), r"T = T_0 + t_d"))

    def guesses(self, form: Form, case: MeasuredMoves) -> Floats:
        middle = float(np.median(case.residual[case.moving]))
        return np.array([[max(middle, form.parameters[0].low) or 0.01]])

    def act(self, motion: Motion, form: Form, values: Floats, case: MeasuredMoves) -> Motion:
        where = 1.0 if form.key == "waits too" else case.moving
        return motion.with_(added=motion.added + values[0] * where)

    def doubt(self, form: Form, values: Floats) -> float:
        return _LESS if values[0] < 0 else 0.0

    def says(self, form: Form, values: Floats, case: MeasuredMoves) -> str:
        more = "more" if values[0] > 0 else "less"
        return f"every executed move costs {abs(values[0]) * 1000:.1f} ms {more}, stop or not"
