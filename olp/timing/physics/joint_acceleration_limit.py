"""`joint-acceleration-limit`: an axis reaches its acceleration limit, so the path accelerates more slowly there."""

from __future__ import annotations

import numpy as np

from olp.timing.physics._case import Floats, MeasuredMoves
from olp.timing.physics._limits import limits_reached
from olp.timing.physics._motion import Motion
from olp.timing.physics._ramps import forced, where_passed
from olp.timing.physics.term import Form, MoveTerm, Stage, TermParameter, spoken_axis

ALL = -1  # axes together, by their rated accelerations


class JointAccelerationLimit(MoveTerm):
    summary = "an axis reaches its acceleration limit, so the path accelerates more slowly in some poses and directions"
    does = "ramps are longer where the axis turns far per millimetre of path, and as simulated elsewhere"
    source = "q'' = q' s'' + q'' s'²; J. Bobrow, S. Dubowsky, J. Gibson, Int. J. Robotics Research 4(3), 1985"
    confusable = ("reach-inertia", "gravity", "torque-speed", "joint-speed-limit")
    stage = Stage.LIMITS
    phase = "accelerate"

    def forms(self, case: MeasuredMoves) -> tuple[Form, ...]:
        if case.rates is None:
            return ()
        forms = []
        if case.rates.rated_acceleration is not None and (_asked(case, ALL) > 0).sum() >= 4:
            asked = _asked(case, ALL)
            share = TermParameter(
                "share",
                "1",
                0.2 * float(np.quantile(asked[asked > 0], 0.05)),
                float(asked.max()),
                np.inf,
                True,
                "of the rated axis accelerations",
            )
            forms.append(Form("all", (share,), r"a \le k \min_j A_j / |q_j'|"))
        for axis, name in enumerate(case.rates.names):
            asked = _asked(case, axis)
            if (asked > 0).sum() < 4:
                continue
            high, low = float(asked.max()), float(np.quantile(asked[asked > 0], 0.05))
            if high <= 1.02 * low:
                continue
            says = f"that {spoken_axis(name)} can give"
            limit = TermParameter(
                f"limit_{name.lower().replace(' ', '_')}", "rad/s^2", 0.2 * low, high, np.inf, True, says
            )
            forms.append(Form(name, (limit,), r"a \le A_j / |q_j'|", axis))
        return tuple(forms)

    def lacks(self, case: MeasuredMoves) -> str:
        return "" if case.rates is not None else "a robot, or joint points"

    def guesses(self, form: Form, case: MeasuredMoves) -> Floats:
        limit = form.parameters[0]
        return np.clip(limits_reached(_asked(case, form.axis)), limit.low, limit.high)[:, None]

    def act(self, motion: Motion, form: Form, values: Floats, case: MeasuredMoves) -> Motion:
        rates, ramps = _rates(case, form.axis), (motion.accelerate, motion.decelerate)
        # A ramp that the limit makes longer passes other places than the simulation's.
        if _even(case, form.axis):
            up, down = (slow / np.maximum(1.0, rates[:, 0] * slow / values[0]) for slow in ramps)
            return motion.with_(accelerate=up, decelerate=down)
        up, down = (1.0 / np.maximum(1.0, rates * slow[:, None] / values[0]) for slow in ramps)
        return forced(motion, up, down)

    def says(self, form: Form, values: Floats, case: MeasuredMoves) -> str:
        if form.axis == ALL:
            return f"the acceleration limit of each axis is {values[0]:.1%} of its rated one"
        return f"the acceleration limit of {spoken_axis(form.key)} is {np.degrees(values[0]):.0f} deg/s²"


def _passed(case: MeasuredMoves, axis: int, end: int) -> Floats:
    """Rates (n, k) [rad/m] of the axis where one ramp of the simulation passes the speeds of `PASSED`; (n, 1) where
    the axes turn in proportion along all moves, as joint moves have it."""

    def work_out() -> Floats:
        rates = _rates(case, axis)
        return rates[:, :1] if _even(case, axis) else where_passed(case, rates, end)

    return case.once(f"ramp {axis} {end}", work_out)


def _even(case: MeasuredMoves, axis: int) -> bool:
    """Whether axes turn in proportion along all moves, as joint moves have it."""
    rates = _rates(case, axis)
    return bool(case.once(f"even slopes {axis}", lambda: np.array([(rates == rates[:, :1]).all()]))[0])


def _rates(case: MeasuredMoves, axis: int) -> Floats:
    """Turn (n, m) of an axis per unit of path length; for ALL the largest share of a rated acceleration."""
    rates = case.rates
    assert rates is not None
    if axis != ALL:
        return case.once(f"slopes {axis}", lambda: np.abs(rates.path[:, :, axis]))
    rated = rates.rated_acceleration
    assert rated is not None
    return case.once("rated slopes", lambda: (np.abs(rates.path) / rated).max(axis=2))


def _asked(case: MeasuredMoves, axis: int) -> Floats:
    """Highest acceleration (n,) [rad/s²] of the axis in the simulation's ramps."""
    start, end = (_passed(case, axis, k).max(axis=1) for k in (0, 1))
    return np.asarray(np.maximum(start * case.base.accelerate, end * case.base.decelerate))
