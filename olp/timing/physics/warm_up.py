"""`warm-up`: durations drift as an exponential of running time."""

from __future__ import annotations

import numpy as np

from olp.timing.physics._case import Floats, MeasuredMoves
from olp.timing.physics._motion import Motion
from olp.timing.physics.term import Form, MoveTerm, Stage, TermParameter

_FEWEST = 12
_LONGEST = 2.0  # times the recording: a longer time constant is a straight line
_RAMPS = "ramps"  # friction of cold grease takes torque, and with it acceleration
_STIFF = "stiff ramps"  # what resists is more by a share, so that ramps take longer by it
_LEAST = 0.05  # of an acceleration that is left


class WarmUp(MoveTerm):
    summary = "durations drift as an exponential of running time"
    does = "the same move is longer at the beginning than at the end of the recording, or shorter"
    source = "first-order thermal model: grease friction falls with exp(-t/τ) (A. C. Bittencourt, S. Gunnarsson, 2012)"
    confusable = ("clock", "speed-scale")
    stage = Stage.CLOCKS
    conditionable = False
    by_time = True

    def forms(self, case: MeasuredMoves) -> tuple[Form, ...]:
        if len(case) < _FEWEST or not np.isfinite(case.t_start).all() or np.ptp(case.t_start) <= 0:
            return ()
        time = _time(case)
        span = float(np.ptp(time))
        last = TermParameter("tau", "s", span / 40.0, _LONGEST * span, np.inf, True, "time constant")
        share = TermParameter("share", "1", -0.5, 0.5, 0.0, False, "of a duration, cold")
        warm = TermParameter("share", "1", -0.5, 0.5, 0.0, False, "of a duration, warm")
        fixed = TermParameter("time", "s", -1.0, 1.0, 0.0, False, "per move, cold")
        longer = TermParameter("share", "1", -0.5, 4.0, 0.0, False, "of a ramp's time, cold")
        lost = TermParameter("share", "1", -0.9, 0.9, 0.0, False, "of the acceleration that is missing, cold")
        return (
            Form("share", (share, last), r"T = T_0 (1 + A e^{-t/\tau})"),
            Form("seconds", (fixed, last), r"T = T_0 + A e^{-t/\tau}"),
            Form("share, cold as simulated", (warm, last), r"T = T_0 (1 + A (1 - e^{-t/\tau}))"),
            Form("share of the simulated", (share, last), r"T = T_0 + A T_s e^{-t/\tau}"),
            Form(_RAMPS, (lost, last), r"T = L/v + v/(a\,(1 - A e^{-t/\tau}))"),
            Form(_STIFF, (longer, last), r"T = L/v + v/a\,(1 + A e^{-t/\tau})"),
        )

    def lacks(self, case: MeasuredMoves) -> str:
        return "" if self.forms(case) else "t_start_s"

    def guesses(self, form: Form, case: MeasuredMoves) -> Floats:
        span = float(np.ptp(_time(case)))
        size = 0.02 if form.key.startswith("share") else 0.02 * float(np.median(case.measured))
        size = 0.1 if form.key in (_RAMPS, _STIFF) else size
        return np.array([[sign * size, part * span] for sign in (1, -1) for part in (0.08, 0.25, 0.7)])

    def act(self, motion: Motion, form: Form, values: Floats, case: MeasuredMoves) -> Motion:
        cold = np.exp(-_time(case) / values[1])
        if form.key == "seconds":
            return motion.with_(added=motion.added + values[0] * cold * case.moving)
        if form.key == "share of the simulated":
            return motion.with_(added=motion.added + values[0] * cold * case.moving * case.simulated)
        if form.key in (_RAMPS, _STIFF):
            part = values[0] * cold
            left = np.maximum(1.0 - part, _LEAST) if form.key == _RAMPS else 1.0 / (1.0 + part)
            ramps = ("accelerate", "decelerate", "open_start", "open_end")
            return motion.with_(**{name: getattr(motion, name) * left for name in ramps})
        cold = 1.0 - cold if form.key != "share" else cold
        return motion.with_(rate=motion.rate * (1.0 + values[0] * cold * case.moving))

    def says(self, form: Form, values: Floats, case: MeasuredMoves) -> str:
        if form.key == _RAMPS:
            missing = f"{abs(values[0]):.2%} {'less' if values[0] > 0 else 'more'}"
            return f"cold, ramps have {missing} acceleration, with a time constant of {values[1]:.0f} s"
        if form.key == _STIFF:
            share = f"{abs(values[0]):.2%} {'longer' if values[0] > 0 else 'shorter'}"
            return f"cold, ramps are {share}, with a time constant of {values[1]:.0f} s"
        size = f"{values[0] * 1000:+.1f} ms" if form.key == "seconds" else f"{values[0]:+.2%}"
        size += " of the simulated time" if form.key == "share of the simulated" else ""
        when = "in the long run" if form.key == "share, cold as simulated" else "cold"
        return f"moves take {size} {when}, with a time constant of {values[1]:.0f} s"


def _time(case: MeasuredMoves) -> Floats:
    """Time (n,) [s] since the recording began."""
    began = case.began if np.isfinite(case.began) else float(np.min(case.t_start))
    return case.once("running time", lambda: case.t_start - began)
