"""`torque-speed`: less acceleration is available at high axis speed."""

from __future__ import annotations

import numpy as np

from olp.physics._case import Case, Floats
from olp.physics._motion import Motion
from olp.physics.term import Form, MoveTerm, Parameter, Stage

_SPREAD = 1.3  # the fastest over the slowest speed that has to be there
_MOST = 0.98


class TorqueSpeed(MoveTerm):
    summary = "less acceleration is available at high axis speed"
    does = "ramps to high speeds are longer than in proportion to the speed; slow moves are as simulated"
    source = "torque-speed line of a servo motor: ∫ dv / (a (1 - v/v0)); constant power above a base speed"
    confusable = ("acceleration", "viscous-friction", "joint-acceleration-limit", "speed-clamp")
    stage = Stage.SCALES
    phase = "accelerate"

    def forms(self, case: Case) -> tuple[Form, ...]:
        forms = []
        for key in ("path", "axes"):
            speed = _speed(case, key)
            used = speed[case.moving]
            if len(used) < 4 or float(used.max()) < _SPREAD * max(float(np.quantile(used, 0.1)), 1e-9):
                continue
            top = float(used.max())
            unit = f"{case.unit}/s" if key == "path" else "rad/s"
            idle = Parameter(
                "idle_speed", unit, top / _MOST, top * 60.0, np.inf, True, "at which nothing is left"
            )
            base = Parameter(
                "base_speed",
                unit,
                0.1 * float(used.min()),
                top,
                np.inf,
                True,
                "above which power is constant",
            )
            forms.append(Form(f"{key} line", (idle,), r"a(v) = a\,(1 - v/v_0)"))
            forms.append(Form(f"{key} power", (base,), r"a(v) = a\,\min(1, v_b/v)"))
        return tuple(forms)

    def lacks(self, case: Case) -> str:
        return "" if self.forms(case) else "moves at several speeds"

    def guesses(self, form: Form, case: Case) -> Floats:
        top = float(_speed(case, form.key.split()[0])[case.moving].max())
        return np.array([[1.3], [3.0], [10.0]] if form.key.endswith("line") else [[0.25], [0.5], [0.8]]) * top

    def act(self, motion: Motion, form: Form, values: Floats, case: Case) -> Motion:
        key, law = form.key.split()
        share = _speed(case, key) / values[0]
        if law == "line":
            share = np.clip(share, 1e-6, _MOST)
            less = -np.log1p(-share) / share
        else:
            # Ramp v_b/a, then a falls as v_b/v: together (v²/v_b + v_b) / (2 a).
            less = np.where(share > 1.0, 0.5 * (share + 1.0 / np.maximum(share, 1e-9)), 1.0)
        return motion.with_(accelerate=motion.accelerate / less, decelerate=motion.decelerate / less)

    def says(self, form: Form, values: Floats, case: Case) -> str:
        of = "the path's" if form.key.startswith("path") else "the fastest axis's"
        unit = form.parameters[0].unit
        if form.key.endswith("line"):
            return f"acceleration falls with {of} speed and would be nothing at {values[0]:.3g} {unit}"
        return f"above {values[0]:.3g} {unit} of {of} speed the acceleration falls as one over the speed"


def _speed(case: Case, key: str) -> Floats:
    """(n,) of the path, or of the fastest axis at either end."""
    if key == "path":
        return np.asarray(case.base.speed / case.ratio)
    rates = case.rates
    if rates is None:
        return np.zeros(len(case))

    def fastest() -> Floats:
        assert rates is not None
        ends = np.maximum(np.abs(rates.start), np.abs(rates.end)).max(axis=1)
        return np.asarray(ends * case.base.speed)

    return case.once("fastest axis", fastest)
