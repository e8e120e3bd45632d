"""`joint-acceleration-limit`: an axis reaches its acceleration limit, so the path accelerates more slowly there."""

from __future__ import annotations

import numpy as np

from olp.timing.physics._case import Floats, MeasuredMoves
from olp.timing.physics._limits import limits_reached, slowed_below
from olp.timing.physics._motion import Motion
from olp.timing.physics._ramps import forced, where_passed
from olp.timing.physics.term import Form, MoveTerm, Stage, TermParameter, spoken_axis

ALL = -1  # axes together, by their rated accelerations
_FEWEST = 4  # moves
_CURVED = " with curvature"  # behind the key of a form
_BENT = 0.1  # of what a move asks of an axis: less of it by the curvature of the axis' way is left out
_HARDEST = 0.75  # quantile of what moves ask: a limit is reached by those above it first
_PASSES = 4  # of a ramp
_LEFT = 0.1  # of a limit: what curvature uses beyond the rest of it makes a ramp no slower, but the path


class JointAccelerationLimit(MoveTerm):
    summary = "an axis reaches its acceleration limit, so the path accelerates more slowly in some poses and directions"
    does = (
        "ramps are longer where the axis turns far per millimetre of path, and as simulated elsewhere; curvature uses "
        "a part of the limit on fast lines (“all with curvature”); in joint moves, loads and friction lower it, too"
    )
    source = "q'' = q' s'' + q'' s'²; J. Bobrow, S. Dubowsky, J. Gibson, Int. J. Robotics Research 4(3), 1985"
    confusable = ("reach-inertia", "gravity", "torque-speed", "joint-speed-limit")
    stage = Stage.LIMITS
    phase = "accelerate"

    def forms(self, case: MeasuredMoves) -> tuple[Form, ...]:
        if case.rates is None:
            return ()
        forms = []
        if case.rates.rated_acceleration is not None and (_asked(case, ALL) > 0).sum() >= _FEWEST:
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
            if (asked > 0).sum() < _FEWEST:
                continue
            high, low = float(asked.max()), float(np.quantile(asked[asked > 0], 0.05))
            if high <= 1.02 * low:
                continue
            says = f"that {spoken_axis(name)} can give"
            limit = TermParameter(
                f"limit_{name.lower().replace(' ', '_')}", "rad/s^2", 0.2 * low, high, np.inf, True, says
            )
            forms.append(Form(name, (limit,), r"a \le A_j / |q_j'|", axis))
        # Of one axis the few moves that tell its curvature are as well explained by much else (samples/up20).
        curved = (_with_curvature(form, case) for form in forms if form.axis == ALL and _bends(case))
        return (*forms, *curved)

    def lacks(self, case: MeasuredMoves) -> str:
        return "" if case.rates is not None else "a robot, or joint points"

    def guesses(self, form: Form, case: MeasuredMoves) -> Floats:
        limit = form.parameters[0]
        asked = _asked_along(case) if form.key.endswith(_CURVED) else _asked(case, form.axis)
        return np.clip(limits_reached(asked), limit.low, limit.high)[:, None]

    def act(self, motion: Motion, form: Form, values: Floats, case: MeasuredMoves) -> Motion:
        if form.key.endswith(_CURVED):
            return _along_curves(motion, values[0], case)
        rates, ramps = _rates(case, form.axis), (motion.accelerate, motion.decelerate)
        if _even(case, form.axis):
            # The drive of a joint move is limited in what it could give: weights and friction take their share of it.
            left = np.minimum(
                motion.limited, 1.0 / np.maximum(1.0, rates[:, 0] * case.base.accelerate / values[0])
            )
            up, down = (slow * left / motion.limited for slow in ramps)
            return motion.with_(accelerate=up, decelerate=down, limited=left)
        # A ramp that the limit makes longer passes other places than the simulation's.
        up, down = (1.0 / np.maximum(1.0, rates * slow[:, None] / values[0]) for slow in ramps)
        return forced(motion, up, down)

    def says(self, form: Form, values: Floats, case: MeasuredMoves) -> str:
        if form.axis == ALL:
            curved = "; on fast lines, curvature uses a part of it" if form.key.endswith(_CURVED) else ""
            return f"the acceleration limit of each axis is {values[0]:.1%} of its rated one{curved}"
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


# --- The curvature of the axes' ways: q'' s'² ---


def _with_curvature(form: Form, case: MeasuredMoves) -> Form:
    """The form of all axes where q'' s'² counts, too."""
    share = form.parameters[0]
    share = share._replace(high=max(share.high, float(_asked_along(case).max())))
    equation = r"|q_j' \ddot s + q_j'' \dot s^2| \le k A_j"
    return form._replace(key=f"{form.key}{_CURVED}", parameters=(share,), equation=equation)


def _bends(case: MeasuredMoves) -> bool:
    """Whether curvature changes what the moves that ask most of the axes ask of them."""
    plain, along = _asked(case, ALL), _asked_along(case)
    most = np.maximum(plain, along)
    hardest = (most > 0) & (most >= np.quantile(most[most > 0], _HARDEST))
    return int((hardest & (np.abs(along - plain) > _BENT * most)).sum()) >= _FEWEST


def _turns(case: MeasuredMoves) -> Floats:
    """|q'|/A (n, m, k) [s²/m] of each axis along each way."""
    return case.once("rated turns", lambda: np.abs(_slopes(case)))


def _slopes(case: MeasuredMoves) -> Floats:
    """q'/A (n, m, k) [s²/m] likewise."""
    rates = case.rates
    assert rates is not None
    assert rates.rated_acceleration is not None
    return np.asarray(rates.path / rates.rated_acceleration)


def _curvatures(case: MeasuredMoves) -> Floats:
    """q''/A (n, m, k) [s²/m²] likewise, positive where the axis turns the faster the farther the move is on its way."""

    def work_out() -> Floats:
        slopes = _slopes(case)
        places = slopes.shape[1]
        per_way = np.gradient(slopes, 1.0 / (places - 1), axis=1) if places > 1 else 0.0 * slopes
        return np.asarray(np.sign(slopes) * per_way / np.maximum(case.base.way, 1e-9)[:, None, None])

    return case.once("rated curvatures", work_out)


def _asked_along(case: MeasuredMoves) -> Floats:
    """Highest share (n,) of a rated acceleration along the simulation's whole way."""

    def work_out() -> Floats:
        turns, curvatures, base = _turns(case), _curvatures(case), case.base
        share = np.linspace(0.0, 1.0, turns.shape[1])[None, :]
        rising = 2.0 * (base.accelerate * base.way)[:, None] * share
        falling = 2.0 * (base.decelerate * base.way)[:, None] * (1.0 - share)
        cruising = base.speed[:, None] ** 2
        square = np.minimum(np.minimum(rising, falling), cruising)
        starts, stops = (rising < np.minimum(falling, cruising)), (falling <= np.minimum(rising, cruising))
        push = np.where(starts, base.accelerate[:, None], np.where(stops, -base.decelerate[:, None], 0.0))
        return np.asarray(np.abs(turns * push[:, :, None] + curvatures * square[:, :, None]).max(axis=(1, 2)))

    return case.once("rated share asked along", work_out)


def _most_along(case: MeasuredMoves) -> Floats:
    """Largest |q'|/A and |q''|/A (n, 2, k) along each way."""
    both = (_turns(case), np.abs(_curvatures(case)))
    return case.once("rated most along", lambda: np.stack([one.max(axis=1) for one in both], axis=1))


def _along_curves(motion: Motion, limit: float, case: MeasuredMoves) -> Motion:
    """The motion with ramps that leave q'' s'² its part of the limit, and no faster than q'' s'² alone allows."""
    most, ramp = _most_along(case), np.maximum(motion.accelerate, motion.decelerate)
    asked = most[:, 0] * ramp[:, None] + most[:, 1] * (motion.top() ** 2)[:, None]
    rows = np.nonzero((asked > limit).any(axis=1))[0]
    if not len(rows):
        return motion
    turns, curvatures = _turns(case)[rows], _curvatures(case)[rows]
    some = motion.take(rows)
    up = _share_left(some, some.accelerate[:, None], limit, turns, curvatures)
    down = _share_left(some, some.decelerate[:, None], limit, turns[:, ::-1], -curvatures[:, ::-1])
    bent = forced(some, up, down[:, ::-1])
    changed = {name: vars(motion)[name].copy() for name in ("accelerate", "decelerate", "added")}
    for name, column in changed.items():
        column[rows] = vars(bent)[name]
    fastest = np.sqrt(limit / np.maximum(np.abs(curvatures).max(axis=2), 1e-12))
    capped = np.nonzero((bent.way > 0) & (fastest.min(axis=1) < bent.speed))[0]
    changed["added"][rows[capped]] += slowed_below(bent, capped, fastest[capped])
    return motion.with_(**changed)


def _share_left(motion: Motion, slow: Floats, limit: float, turns: Floats, curvatures: Floats) -> Floats:
    """Share (n, m) of the acceleration `slow` (n, 1) that the axes leave a ramp from rest, places from there on.

    How fast the ramp is at a place depends on what it had before (E. Picard's iteration).
    """
    step = 2.0 * motion.way[:, None] / (turns.shape[1] - 1)
    fastest = motion.speed[:, None] ** 2
    square = slow * step * np.arange(turns.shape[1])
    for _ in range(_PASSES):
        room = limit - curvatures * np.minimum(square, fastest)[:, :, None]
        room = np.maximum(room, _LEFT * limit) / np.maximum(turns, 1e-12)
        left = np.minimum(slow, room.min(axis=2))
        square = np.zeros_like(left)
        np.cumsum(0.5 * step * (left[:, 1:] + left[:, :-1]), axis=1, out=square[:, 1:])
    return np.asarray(left / slow)
