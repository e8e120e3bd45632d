"""`orientation-limit`: the reorientation, not the travel, sets the time."""

from __future__ import annotations

import numpy as np

from olp.timing.physics._case import Floats, MeasuredMoves
from olp.timing.physics._limits import limits_reached
from olp.timing.physics._motion import Motion
from olp.timing.physics.term import Form, MoveTerm, Stage, TermParameter

_TURN = 0.02  # [rad] that a few moves have to turn
_SLOWS, _WEAKENS = "slows the path", "slows the path and its ramps"
_OWN = "of its own"  # the key of a turn beside the travel, and what comes behind it:
_AT_ONCE, _RAMPS = ", at once", ", in two ramps"  # without ramps, without a limit of the speed


class OrientationLimit(MoveTerm):
    summary = "the reorientation, not the travel, sets the time"
    does = (
        "moves that turn the tool far on a short path take as long as the turn; all others are as simulated"
    )
    source = "orientation speed VR of INFORM, v_reori of RAPID, $VEL.ORI of KRL: the slower of travel and turn leads"
    confusable = ("joint-speed-limit", "speed-clamp")
    stage = Stage.LIMITS
    phase = "cruise"

    def forms(self, case: MeasuredMoves) -> tuple[Form, ...]:
        turn = _turns(case)
        if (turn > _TURN).sum() < 3:
            return ()
        needed = turn[turn > _TURN] / np.maximum(case.simulated[turn > _TURN], 1e-3)
        low, high = 0.1 * float(np.quantile(needed, 0.1)), 3.0 * float(needed.max())
        rate = TermParameter("rate", "rad/s", low, high, np.inf, True, "the fastest turn of the tool")
        ramp = TermParameter("acceleration", "rad/s^2", low, 400.0 * high, np.inf, True, "of the turn")
        return (
            Form(_SLOWS, (rate,), r"v \le \omega L / \theta"),
            Form(_WEAKENS, (rate, ramp), r"v \le \omega L / \theta,\; a \le \alpha L / \theta"),
            Form(_OWN, (rate, ramp), r"T \ge \theta/\omega + \omega/\alpha"),
            Form(f"{_OWN}{_AT_ONCE}", (rate,), r"T \ge \theta/\omega"),
            Form(f"{_OWN}{_RAMPS}", (ramp,), r"T \ge 2\sqrt{\theta/\alpha}"),
        )

    def lacks(self, case: MeasuredMoves) -> str:
        return "" if self.forms(case) else "moves with orientations that change"

    def guesses(self, form: Form, case: MeasuredMoves) -> Floats:
        turn = _turns(case)
        needed = turn[turn > _TURN] / np.maximum(case.simulated[turn > _TURN], 1e-3)
        rates = limits_reached(needed)
        if form.key.endswith(_RAMPS):
            return limits_reached(4.0 * needed / np.maximum(case.simulated[turn > _TURN], 1e-3))[:, None]
        if len(form.parameters) == 1:
            return rates[:, None]
        return np.array([[rate, rate / time] for rate in rates for time in (0.1, 0.4)])

    def act(self, motion: Motion, form: Form, values: Floats, case: MeasuredMoves) -> Motion:
        turn = _turns(case)
        if form.key in (_SLOWS, _WEAKENS):
            # Waits have no way, and keep a speed that can be divided by.
            per_turn = np.where(motion.way > 0, motion.way / np.maximum(turn, 1e-9), np.inf)
            slowed = motion.with_(speed=np.minimum(motion.speed, values[0] * per_turn))
            if form.key == _SLOWS:
                return slowed
            ramp = np.where(turn > 1e-6, values[1] * per_turn, np.inf)
            up, down = (np.minimum(own, ramp) for own in (motion.accelerate, motion.decelerate))
            return slowed.with_(accelerate=up, decelerate=down)
        if form.key.endswith(_AT_ONCE):
            whole = turn / values[0]
        elif form.key.endswith(_RAMPS):
            whole = 2.0 * np.sqrt(turn / values[0])
        else:
            rate, ramp = values
            whole = np.where(turn >= rate**2 / ramp, turn / rate + rate / ramp, 2.0 * np.sqrt(turn / ramp))
        return motion.with_(least=np.maximum(motion.least, np.where(turn > 1e-6, whole, 0.0)))

    def says(self, form: Form, values: Floats, case: MeasuredMoves) -> str:
        if form.key.endswith(_RAMPS):
            return f"the limit of the tool's turning acceleration is {np.degrees(values[0]):.0f} deg/s²"
        return f"the limit of the tool's turning speed is {np.degrees(values[0]):.1f} deg/s"


def _turns(case: MeasuredMoves) -> Floats:
    """Reorientation (n,) [rad] of straight moves, 0 where unknown."""
    return case.once("turn", lambda: np.where(case.moving & ~case.joint, np.nan_to_num(case.turn), 0.0))
