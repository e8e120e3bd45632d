"""`joint-speed-limit`: an axis reaches its speed limit, so the path is slowed there."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from olp.timing.physics._case import Floats, MeasuredMoves
from olp.timing.physics._limits import limits_reached, slowed_below
from olp.timing.physics._motion import Motion
from olp.timing.physics.term import Form, MoveTerm, Stage, TermParameter, spoken_axis

_AT_ONCE = " at once"  # behind the key of a form
ALL = -1  # axes together, by their rated speeds
_USUAL = 0.25  # of a rated speed: no drive is slower, and few controllers are set to less
# In BIC: beside other laws that are not quite right, a limit of any size makes up for something.
_UNUSUAL = 120.0
_FEWEST = 4  # moves
_FINER = 4  # times as many places as the rates are known at


class JointSpeedLimit(MoveTerm):
    summary = "an axis reaches its speed limit, so the path is slowed there (near a singularity, say)"
    does = "moves in which the axis has to turn fast are longer, in cruise; all others are as simulated"
    source = "q' = J⁻¹ x'; B. Siciliano et al., Robotics (Springer 2009), section 3.5"
    confusable = ("speed-clamp", "orientation-limit", "joint-acceleration-limit")
    stage = Stage.LIMITS
    phase = "cruise"

    def forms(self, case: MeasuredMoves) -> tuple[Form, ...]:
        if case.rates is None:
            return ()
        rated = case.rates.rated
        forms = []
        if rated is not None:
            forms += _form(case, ALL, "all", "share", "1", _USUAL, "of the rated axis speeds")
        elif len(case.rates.names) > 1:
            forms += _form(case, ALL, "alike", "limit", "rad/s", 0.0, "of all axes")
        forms += [form._replace(key=f"{form.key}{_AT_ONCE}") for form in forms]
        for axis, name in enumerate(case.rates.names):
            usual = _USUAL * float(rated[axis]) if rated is not None and np.isfinite(rated[axis]) else 0.0
            limit = f"limit_{name.lower().replace(' ', '_')}"
            forms += _form(case, axis, name, limit, "rad/s", usual, f"of {spoken_axis(name)}")
        return tuple(forms)

    def lacks(self, case: MeasuredMoves) -> str:
        return "" if case.rates is not None else "a robot, or joint points"

    def guesses(self, form: Form, case: MeasuredMoves) -> Floats:
        asked, limit = _asked(case, form.axis), form.parameters[0]
        return np.clip(limits_reached(asked), limit.low, limit.high)[:, None]

    def doubt(self, form: Form, values: Floats) -> float:
        return _UNUSUAL if values[0] < form.usual else 0.0

    def act(self, motion: Motion, form: Form, values: Floats, case: MeasuredMoves) -> Motion:
        """Where the axis would be too fast, the path is slowed: it brakes and speeds up, or changes speed at once."""
        touched = np.nonzero(_asked(case, form.axis) > values[0])[0]
        if not len(touched):
            return motion
        added = motion.added.copy()
        if form.key.endswith(_AT_ONCE):
            top = motion.top()[touched]
            added[touched] += (
                motion.way[touched] * _beyond(case, form.axis, touched, values[0] / top) / values[0]
            )
            return motion.with_(added=added)
        limit = values[0] / np.maximum(_rates(case, form.axis)[touched], 1e-12)
        added[touched] += slowed_below(motion, touched, limit)
        return motion.with_(added=added)

    def says(self, form: Form, values: Floats, case: MeasuredMoves) -> str:
        if form.key.startswith("alike"):
            return f"the speed limit of each axis is {np.degrees(values[0]):.1f} deg/s"
        if form.axis == ALL:
            return f"the speed limit of each axis is {values[0]:.1%} of its rated speed"
        called = spoken_axis(form.key.removesuffix(_AT_ONCE))
        return f"the speed limit of {called} is {np.degrees(values[0]):.1f} deg/s"


def _form(
    case: MeasuredMoves, axis: int, key: str, name: str, unit: str, usual: float, meaning: str
) -> list[Form]:
    """The form of an axis that some moves turn; else none."""
    asked = _asked(case, axis)
    if (asked > 0).sum() < _FEWEST:
        return []
    high = float(asked.max())
    low = 0.2 * float(np.quantile(asked[asked > 0], 0.05))
    if low >= 0.98 * high:
        return []
    limit = TermParameter(name, unit, low, high, np.inf, True, meaning)
    share = {"all": r"k \min_j V_j", "alike": r"V \min_j 1"}.get(key, "V_j")
    return [Form(key, (limit,), rf"\dot s \le {share} / |q_j'(s)|", axis, usual)]


def _rates(case: MeasuredMoves, axis: int) -> Floats:
    """Turn (n, m) of an axis per unit of path length; for ALL the largest share of a rated speed."""
    rates = case.rates
    assert rates is not None

    def finer() -> Floats:
        if axis == ALL:
            rated = rates.rated if rates.rated is not None else np.ones(len(rates.names))
            coarse = (np.abs(rates.path) / rated).max(axis=2)
        else:
            coarse = np.abs(rates.path[:, :, axis])
        part = np.arange(_FINER) / _FINER
        pieces = coarse[:, :-1, None] + (coarse[:, 1:] - coarse[:, :-1])[:, :, None] * part
        return np.concatenate([pieces.reshape(len(coarse), -1), coarse[:, -1:]], axis=1)

    return case.once(f"rates {axis}", finer)


def _beyond(case: MeasuredMoves, axis: int, rows: NDArray[np.intp], least: Floats) -> Floats:
    """Mean excess (r,) [rad/m] over the path of the axis' rate above `least` (r,), in the moves `rows`."""

    def sorted_() -> Floats:
        """Rates, the highest first, and cumulative sums of their shares of the path, and of both multiplied (3, n,
        m + 1).
        """
        rate = _rates(case, axis)
        share = np.full(rate.shape, 1.0 / (rate.shape[1] - 1))
        share[:, [0, -1]] *= 0.5
        order = np.argsort(-rate, axis=1)
        rate, share = (np.take_along_axis(each, order, axis=1) for each in (rate, share))
        sums = (rate, np.cumsum(share, axis=1), np.cumsum(share * rate, axis=1))
        return np.stack([np.pad(each, ((0, 0), (1, 0))) for each in sums])

    rate, shares, sums = case.once(f"sorted rates {axis}", sorted_)
    above = (rate[rows, 1:] > least[:, None]).sum(axis=1)
    return np.asarray(np.maximum(sums[rows, above] - least * shares[rows, above], 0.0))


def _profile(motion: Motion, places: int) -> Floats:
    """Speed (n, m) [m/s] along the path, without jerk."""
    share = np.linspace(0.0, 1.0, places)[None, :]
    way = motion.way[:, None]
    rising = np.sqrt(2.0 * motion.accelerate[:, None] * share * way)
    falling = np.sqrt(2.0 * motion.decelerate[:, None] * (1.0 - share) * way)
    return np.maximum(np.minimum(np.minimum(rising, falling), motion.speed[:, None]), 1e-9)


def _asked(case: MeasuredMoves, axis: int) -> Floats:
    """Highest speed (n,) [rad/s] of the axis in the simulation."""

    def work_out() -> Floats:
        rate = _rates(case, axis)
        return np.asarray((rate * _profile(case.base, rate.shape[1])).max(axis=1))

    return case.once(f"axis speed {axis}", work_out)
