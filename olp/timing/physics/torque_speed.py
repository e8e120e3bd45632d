"""`torque-speed`: less acceleration is available at high axis speed."""

from __future__ import annotations

import numpy as np

from olp.timing.physics._case import Floats, MeasuredMoves
from olp.timing.physics._motion import Motion
from olp.timing.physics._ramps import PASSED, where_passed
from olp.timing.physics._ramps import slower as longer_by
from olp.timing.physics.term import Form, MoveTerm, Stage, TermParameter

_SPREAD = 1.3  # the fastest over the slowest speed that has to be there
_MOST = 0.98
_WAYS = PASSED / len(PASSED)  # that a ramp covers while it passes each of these speeds
_STEPS, _EXACT, _ROUNDED = 25, 1e-6, 1e-6  # of Newton's method at most; shares of a way that are nothing


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
            speed = np.minimum(speed, _MOST * values[0] / np.maximum(_per_speed(case, key), 1e-12))
        knee = float(values[1]) if law == "knee" else 0.0
        limited = motion.with_(speed=speed)
        shares, top = _both_along(case, key) / values[0], limited.top()
        slows = np.stack([motion.accelerate, motion.decelerate])
        over = _over(shares * top[:, None], knee, law)
        accelerate, decelerate = slows / longer_by(over)
        covered = top**2 * (over @ _WAYS / slows).sum(axis=0)
        short = np.nonzero((limited.way > 0) & (covered > (1.0 + _ROUNDED) * limited.way))[0]
        if len(short):
            ways = (limited.way[short], speed[short], top[short])
            slow = _on_short_ways(*ways, shares[:, short], slows[:, short], knee, law)
            accelerate[short] = decelerate[short] = slow
        return limited.with_(accelerate=accelerate, decelerate=decelerate)

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


def _over(share: Floats, knee: float, law: str) -> Floats:
    """Divisor (2, n, k) of the acceleration of each ramp. `share`: axis speed over its idle or base speed, where the
    ramp passes the speeds of `PASSED`.
    """
    if law == "power":
        return np.maximum(share, 1.0)
    whole = 1.0 - knee
    return np.asarray(whole / np.minimum(np.maximum(1.0 - share, (1.0 - _MOST) * whole), whole))


def _growth(share: Floats, over: Floats, knee: float, law: str) -> Floats:
    """Slope (2, n, k) of the divisor `over` by the logarithm of the speed."""
    if law == "power":
        return np.where(over > 1.0, over, 0.0)
    return np.where((over > 1.0) & (over * (1.0 - _MOST) < 1.0), over**2 * share / (1.0 - knee), 0.0)


def _on_short_ways(
    way: Floats, speed: Floats, peak: Floats, shares: Floats, slows: Floats, knee: float, law: str
) -> Floats:
    """Acceleration (n,) that takes the same total time where both ramps together are longer than the path.

    The less force is left, the longer the path covered at high speed: Newton's method in logarithms finds the speed at
    which both ramps cover the way (n,) [m], from the highest one without jerk on, `peak` (n,) [m/s]. `shares`: of the
    idle or base speed per speed of the path, for each ramp (2, n, k); `slows` (2, n): its whole acceleration.
    """
    low, high = np.zeros(len(way)), peak
    for _ in range(_STEPS):
        share = shares * peak[:, None]
        over = _over(share, knee, law)
        ramps = (over @ _WAYS / slows).sum(axis=0)
        covered = peak**2 * ramps
        off = np.log(covered / way)
        if np.abs(off).max() <= _EXACT:
            break
        slope = 2.0 + (_growth(share, over, knee, law) @ _WAYS / slows).sum(axis=0) / ramps
        low, high = np.where(off <= 0, peak, low), np.where(off <= 0, high, peak)
        tried = peak * np.exp(-off / slope)
        tried = np.where((tried > low) & (tried < high), tried, 0.5 * (low + high))
        peak = np.where(np.abs(off) <= _EXACT, peak, tried)
    time = peak * (over.mean(axis=2) / slows).sum(axis=0)
    # What the ramps fall short of the way is passed at the speed that they reach.
    time = time + (way - covered) / np.maximum(peak, 1e-9)
    return np.asarray(
        np.where(2.0 * way <= speed * time, 4.0 * way / time**2, speed / np.maximum(time - way / speed, 1e-9))
    )


def _unit(case: MeasuredMoves, key: str) -> str:
    if key == "path":
        return f"{case.unit}/s"
    return "1" if case.rates is not None and case.rates.rated is not None else "rad/s"


def _speed(case: MeasuredMoves, key: str) -> Floats:
    """Speed (n,) of the path, or of the fastest axis, in the simulation."""
    return np.asarray(_per_speed(case, key) * case.base.top())


def _per_speed(case: MeasuredMoves, key: str) -> Floats:
    """Highest speed (n,) of the path, or of the fastest axis, per speed of the path."""
    return case.once(f"fastest {key}", lambda: _fastest(case, key).max(axis=1))


def _fastest(case: MeasuredMoves, key: str) -> Floats:
    """Speed (n, m) of the path, or of the fastest axis (as a share of rated speeds, if known), per speed of the
    path, along the path.
    """
    rates = case.rates
    if key == "path" or rates is None:
        even = 1.0 / case.ratio if key == "path" else np.zeros(len(case))
        return np.repeat(even[:, None], 2, axis=1)
    rated = rates.rated if rates.rated is not None else np.ones(rates.path.shape[2])
    return np.asarray((np.abs(rates.path) / rated).max(axis=2))


def _both_along(case: MeasuredMoves, key: str) -> Floats:
    """`_fastest` (2, n, k) where each ramp of the simulation passes the speeds of `PASSED`, times these."""

    def work_out() -> Floats:
        fastest = _fastest(case, key)
        return np.stack([where_passed(case, fastest, end) for end in (0, 1)]) * PASSED

    return case.once(f"fastest {key} along", work_out)
