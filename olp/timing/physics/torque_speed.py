"""`torque-speed`: less acceleration is available at high axis speed."""

from __future__ import annotations

from functools import partial

import numpy as np

from olp.timing.physics._case import Floats, MeasuredMoves
from olp.timing.physics._motion import Motion
from olp.timing.physics._ramps import divided_by_speed, fastest_along, per_speed
from olp.timing.physics.term import Form, MoveTerm, Stage, TermParameter

_SPREAD = 1.3  # the fastest over the slowest speed that has to be there
_MOST = 0.98


class TorqueSpeed(MoveTerm):
    summary = "less acceleration is available at high axis speed"
    does = "ramps to high speeds are longer than in proportion to the speed; slow moves are as simulated"
    source = "torque-speed line of a servo motor: ∫ dv / (a (1 - v/v0)); constant power above a base speed"
    confusable = ("acceleration", "viscous-friction", "joint-acceleration-limit", "speed-clamp")
    stage = Stage.SCALES
    phase = "accelerate"

    def forms(self, case: MeasuredMoves) -> tuple[Form, ...]:
        forms = []
        for key in ("path", "axes"):
            used = _speed(case, key)[case.moving]
            if len(used) < 4 or float(used.max()) < _SPREAD * max(float(np.quantile(used, 0.1)), 1e-9):
                continue
            top, unit = float(used.max()), _unit(case, key)
            idle = TermParameter(
                "idle_speed", unit, 0.3 * top, top * 60.0, np.inf, True, "at which nothing is left"
            )
            knee = TermParameter(
                "knee", "1", 0.0, 0.95, 0.0, False, "share of the idle speed up to which all is there"
            )
            base = TermParameter(
                "base_speed",
                unit,
                max(0.1 * float(used.min()), 1e-3 * top),  # axes of moves that nobody knows turn at 0
                top,
                np.inf,
                True,
                "above which power is constant",
            )
            forms.append(Form(f"{key} line", (idle,), r"a(v) = a\,(1 - v/v_0)"))
            forms.append(Form(f"{key} knee", (idle, knee), r"a(v) = a\,\min(1, (1 - v/v_0)/(1 - k))"))
            forms.append(Form(f"{key} power", (base,), r"a(v) = a\,\min(1, v_b/v)"))
        return tuple(forms)

    def lacks(self, case: MeasuredMoves) -> str:
        return "" if self.forms(case) else "moves at several speeds"

    def guesses(self, form: Form, case: MeasuredMoves) -> Floats:
        key, law = form.key.split()
        top = float(_speed(case, key)[case.moving].max())
        if law == "knee":
            return np.array([[0.8 * top, 0.4], [1.1 * top, 0.6], [1.3 * top, 0.3]])
        return np.array([[0.9], [1.3], [3.0], [10.0]] if law == "line" else [[0.25], [0.5], [0.8]]) * top

    def act(self, motion: Motion, form: Form, values: Floats, case: MeasuredMoves) -> Motion:
        key, law = form.key.split()
        speed = motion.speed
        if law != "power":
            # No motor passes the speed at which nothing is left.
            speed = np.minimum(speed, _MOST * values[0] / np.maximum(per_speed(case, key), 1e-12))
        knee = float(values[1]) if law == "knee" else 0.0
        shares = fastest_along(case, key) / values[0]
        return divided_by_speed(motion.with_(speed=speed), shares, partial(_divided, knee=knee, law=law))

    def says(self, form: Form, values: Floats, case: MeasuredMoves) -> str:
        key, law = form.key.split()
        of = "the path's" if key == "path" else "the fastest axis's"
        unit = (
            form.parameters[0].unit.replace("1", "of the rated") if key == "axes" else form.parameters[0].unit
        )
        if law == "power":
            return f"above {values[0]:.3g} {unit} of {of} speed the acceleration falls as one over the speed"
        above = f" above {values[0] * values[1]:.3g} {unit}" if law == "knee" else ""
        return f"acceleration falls with {of} speed{above} and would be nothing at {values[0]:.3g} {unit}"


def _divided(share: Floats, knee: float, law: str) -> tuple[Floats, Floats]:
    """Divisor (2, n, k) of the acceleration of each ramp, and its slope by the logarithm of the speed. `share`: axis
    speed over its idle or base speed, where the ramp passes the speeds of `PASSED`.
    """
    if law == "power":
        over = np.maximum(share, 1.0)
        return over, np.where(over > 1.0, over, 0.0)
    whole = 1.0 - knee
    over = np.asarray(whole / np.minimum(np.maximum(1.0 - share, (1.0 - _MOST) * whole), whole))
    return over, np.where((over > 1.0) & (over * (1.0 - _MOST) < 1.0), over**2 * share / whole, 0.0)


def _unit(case: MeasuredMoves, key: str) -> str:
    if key == "path":
        return f"{case.unit}/s"
    return "1" if case.rates is not None and case.rates.rated is not None else "rad/s"


def _speed(case: MeasuredMoves, key: str) -> Floats:
    """Speed (n,) of the path, or of the fastest axis, in the simulation."""
    return np.asarray(per_speed(case, key) * case.base.top())
