"""`torque-speed`: less acceleration is available at high axis speed."""

from __future__ import annotations

import numpy as np

from olp.timing.physics._case import Floats, MeasuredMoves
from olp.timing.physics._motion import Motion
from olp.timing.physics._ramps import PASSED, longer, where_passed
from olp.timing.physics.term import Form, MoveTerm, Stage, TermParameter

_SPREAD = 1.3  # the fastest over the slowest speed that has to be there
_MOST = 0.98
_WAYS = PASSED / len(PASSED)  # that a ramp covers while it passes each of these speeds
_HALVINGS, _ROUNDED = 14, 1e-6


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
        slower = motion.with_(speed=speed)
        top = slower.top()
        start, end = (_along(case, key, k) * top[:, None] for k in (0, 1))
        found = slower.with_(
            accelerate=motion.accelerate / longer(_force(start / values[0], knee, law)),
            decelerate=motion.decelerate / longer(_force(end / values[0], knee, law)),
        )
        ramps = [
            (per / values[0], slow)
            for per, slow in (
                (_along(case, key, 0), motion.accelerate),
                (_along(case, key, 1), motion.decelerate),
            )
        ]
        return _on_short_ways(found, slower, ramps, knee, law)

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


def _force(share: Floats, knee: float, law: str) -> Floats:
    """Remaining share (n, k) of the acceleration. `share`: axis speed over its idle or base speed, at the full
    speed of the path, at the places where the ramp passes the speeds of `PASSED`.
    """
    share = share * PASSED
    if law == "power":
        return np.asarray(np.minimum(1.0, 1.0 / np.maximum(share, 1e-9)))
    return np.asarray(np.minimum(1.0, np.maximum((1.0 - share) / (1.0 - knee), 1.0 - _MOST)))


def _on_short_ways(
    found: Motion, slower: Motion, ramps: list[tuple[Floats, Floats]], knee: float, law: str
) -> Motion:
    """`found`, with an acceleration of the same total time where both ramps together are longer than the path.

    The less force is left, the longer the path covered at high speed: bisection finds the peak speed. `ramps`: for
    each ramp the share of the idle or base speed per speed of the path (n, k), and the whole acceleration (n,).
    """

    shares, slows = (np.stack(columns) for columns in zip(*ramps, strict=True))

    def over(peak: Floats) -> Floats:
        """Divisor (2, r, k) of each ramp's acceleration where the ramp passes the speeds of `PASSED`."""
        return np.asarray(1.0 / _force(shares * peak[:, None], knee, law))

    def covered(peak: Floats) -> Floats:
        """Length (r,) [m] of both ramps."""
        return np.asarray(peak**2 * (over(peak) @ _WAYS / slows).sum(axis=0))

    rows = np.nonzero(slower.way > 0)[0]
    shares, slows = shares[:, rows], slows[:, rows]
    short = np.nonzero(covered(slower.top()[rows]) > (1.0 + _ROUNDED) * slower.way[rows])[0]
    if not len(short):
        return found
    rows, shares, slows = rows[short], shares[:, short], slows[:, short]
    way, speed = slower.way[rows], slower.speed[rows]
    low, high = np.zeros(len(rows)), slower.top()[rows]
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        fits = covered(middle) <= way
        low, high = np.where(fits, middle, low), np.where(fits, high, middle)
    # Ramps that are a little too short go on at the speed that they reach.
    time = low * (over(low).mean(axis=2) / slows).sum(axis=0)
    time = time + (way - covered(low)) / np.maximum(low, 1e-9)
    slow = np.where(
        2.0 * way <= speed * time, 4.0 * way / time**2, speed / np.maximum(time - way / speed, 1e-9)
    )
    accelerate, decelerate = found.accelerate.copy(), found.decelerate.copy()
    accelerate[rows] = decelerate[rows] = slow
    return found.with_(accelerate=accelerate, decelerate=decelerate)


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


def _along(case: MeasuredMoves, key: str, end: int) -> Floats:
    """`_fastest` (n, k) where the simulation's ramp at one end passes the speeds of `PASSED`."""

    return case.once(f"fastest {key} {end}", lambda: where_passed(case, _fastest(case, key), end))
