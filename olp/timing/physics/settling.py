"""`settling`: a fixed time at every exact stop until the axes are in position."""

from __future__ import annotations

import numpy as np

from olp.timing.physics._case import Floats, Mask, MeasuredMoves
from olp.timing.physics._motion import Motion
from olp.timing.physics.term import Form, MoveTerm, Stage, TermParameter

# A time that is less than simulated: only where the simulation already holds one that is too long.
_LESS = 12.0


class Settling(MoveTerm):
    summary = "a fixed time at every exact stop until the axes are in position"
    does = "every move that ends in an exact stop is longer by the same time; blended ends are as simulated"
    source = "in-position check of controllers (PL=0 of INFORM, fine of RAPID, FINE of TP)"
    confusable = ("dispatch", "jerk", "acceleration")
    stage = Stage.ADDS
    phase = "settle"

    def forms(self, case: MeasuredMoves) -> tuple[Form, ...]:
        if not (case.moving & case.stop_end).any():
            return ()
        least = -min(case.idle(_stopping(case, "")), 1.0)
        time = TermParameter("time", "s", least, 3.0, 0.0, False, "at every exact stop")
        every = Form("", (time,), r"T = T_0 + t_s")
        written = _stopping(case, "as written")
        if not written.any() or np.array_equal(written, _stopping(case, "")):
            return (every,)
        return (every, Form("as written", (time,), r"T = T_0 + t_s"))

    def guesses(self, form: Form, case: MeasuredMoves) -> Floats:
        middle = float(np.median(case.residual[_stopping(case, form.key)]))
        return np.array([[max(middle, form.parameters[0].low) or 0.01]])

    def act(self, motion: Motion, form: Form, values: Floats, case: MeasuredMoves) -> Motion:
        stopping = case.once(f"stopping {form.key}", lambda: _stopping(case, form.key).astype(np.float64))
        return motion.with_(added=motion.added + values[0] * stopping)

    def doubt(self, form: Form, values: Floats) -> float:
        return _LESS if values[0] < 0 else 0.0

    def says(self, form: Form, values: Floats, case: MeasuredMoves) -> str:
        more = "longer" if values[0] > 0 else "less"
        return f"every exact stop takes {abs(values[0]) * 1000:.1f} ms {more} until the axes are in position"


def _stopping(case: MeasuredMoves, key: str) -> Mask:
    """Moves that end in an exact stop (n,); with a `key` only those whose exact stop is programmed."""
    stopping = case.moving & case.stop_end
    return np.asarray(stopping & (case.blend == 0) if key else stopping)
