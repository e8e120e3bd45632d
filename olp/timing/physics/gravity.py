"""`gravity`: acceleration and deceleration depend on how steeply the move goes up or down."""

from __future__ import annotations

from functools import partial

import numpy as np

from olp.timing.physics._case import Floats, MeasuredMoves
from olp.timing.physics._motion import Motion
from olp.timing.physics._ramps import pulled
from olp.timing.physics.term import Form, MoveTerm, Stage, TermParameter

_STEEP = 0.2  # sine of the steepest incline that has to be there
_UPWARD, _SIDEWAYS = 0.25, 120.0  # of the other numbers, and in BIC what less of going up costs
_PLACES = 9  # along a straight move
# What a pull adds to the braking ramp. A controller may brake by its written rate, whatever helps.
_BRAKING = {"against and with": 1.0, "against alone": 1.0, "starting alone": 0.0}
_LEAST = 0.05  # of the acceleration remains, whatever gravity takes


class Gravity(MoveTerm):
    summary = "acceleration and deceleration depend on how steeply the move goes up or down"
    does = "ramps change with the sine of the incline: up against down, or steep against level"
    source = "Apostolovic, chapter 6 (factors over the incline); Newton's second law"
    confusable = ("reach-inertia", "joint-acceleration-limit", "acceleration")
    stage = Stage.SCALES
    phase = "accelerate"

    def forms(self, case: MeasuredMoves) -> tuple[Form, ...]:
        rise = case.rise[case.moving & ~case.joint]
        if len(rise) < 4 or np.ptp(rise) < _STEEP:
            return ()
        share = TermParameter("share", "1", -0.9, 0.9, 0.0, False, "acceleration lost straight up")
        steep = TermParameter("share", "1", 0.0, 0.95, 0.0, False, "acceleration lost straight up")
        arm = [
            TermParameter(
                name,
                "1",
                0.0,
                1.5,
                0.0,
                False,
                f"acceleration lost to lifting the {name}",
            )
            for name in ("wrist", "elbow")
        ]
        whole = Form("whole arm", tuple(arm), r"a_{acc,dec} = a\,(1 \mp k_w z_w'(s) \mp k_e z_e'(s))")
        inward = TermParameter(
            "inward", "1", -1.0, 1.0, 0.0, False, "acceleration lost to drawing the arm in"
        )
        guessed = Form(
            "lift and reach", (arm[0], inward), r"a_{acc,dec} = a\,(1 \mp k_w z'(s) \pm k_r r'(s))"
        )
        return (
            *((whole,) if case.bodies_known else (guessed, _anywhere())),
            Form("both ramps", (share,), r"a_\uparrow = a\,(1 - k\sin\gamma)"),
            Form("steep", (share,), r"a = a_0\,(1 - k\,|\sin\gamma|)"),
            Form(
                "against and with",
                (steep,),
                r"a_{acc} = a\,(1 - k\sin\gamma),\; a_{dec} = a\,(1 + k\sin\gamma)",
            ),
            Form(
                "against alone",
                (steep,),
                r"a_{acc} = a\,\min(1, 1 - k\sin\gamma),\; a_{dec} = a\,\min(1, 1 + k\sin\gamma)",
            ),
            Form(
                "starting alone",
                (share,),
                r"a_{acc} = a\,(1 - k\sin\gamma),\; a_{dec} = a",
            ),
            Form(
                "up and down apart",
                _apart(),
                r"a_\gamma = a\,(1 - k_u \max(\sin\gamma, 0) - k_d \max(-\sin\gamma, 0))",
            ),
        )

    def lacks(self, case: MeasuredMoves) -> str:
        return "" if self.forms(case) else "moves with points at several inclines"

    def guesses(self, form: Form, case: MeasuredMoves) -> Floats:
        if form.key == "any arm":
            return np.array([[0.2, 0.0, 0.0, 0.0, 0.0], [0.4, 0.2, 0.0, 0.0, 0.0]])
        if form.key == "lift and reach":
            return np.array([[0.2, 0.0], [0.3, 0.2], [0.5, 0.3]])
        if form.key == "whole arm":
            return np.array([[0.2, 0.2], [0.5, 0.1], [0.1, 0.5]])
        if form.key == "up and down apart":
            return np.array([[0.3, 0.0], [0.0, 0.3], [0.3, 0.3]])
        return (
            np.array([[-0.2], [0.2]])
            if form.key in ("both ramps", "steep", "starting alone")
            else np.array([[0.2], [0.5]])
        )

    def act(self, motion: Motion, form: Form, values: Floats, case: MeasuredMoves) -> Motion:
        if form.key in ("whole arm", "any arm"):
            slopes = case.once(form.key, lambda: (_lifts if form.key == "whole arm" else _works)(case))
            return pulled(motion, slopes @ values, _LEAST)
        if form.key == "lift and reach":
            pull = case.once("lift and reach", lambda: _outside(case)) @ values
            return motion.with_(
                accelerate=motion.accelerate * np.maximum(1.0 - pull, _LEAST),
                decelerate=motion.decelerate * np.maximum(1.0 + pull, _LEAST),
            )
        rise = case.once("rise", lambda: np.where(case.joint, 0.0, case.rise))
        if form.key == "up and down apart":
            pull = values[0] * np.maximum(rise, 0.0) + values[1] * np.maximum(-rise, 0.0)
            start = end = 1.0 - pull
        else:
            pull = values[0] * (np.abs(rise) if form.key == "steep" else rise)
            start, end = 1.0 - pull, 1.0 + _BRAKING.get(form.key, -1.0) * pull
        most = 1.0 if form.key == "against alone" else np.inf
        return motion.with_(
            accelerate=motion.accelerate * np.clip(start, _LEAST, most),
            decelerate=motion.decelerate * np.clip(end, _LEAST, most),
        )

    def doubt(self, form: Form, values: Floats) -> float:
        # Weight that is felt in many ways, and hardly in going up, is none.
        sideways = form.key == "any arm" and values[0] < _UPWARD * float(np.abs(values[1:]).max())
        return _SIDEWAYS if sideways else 0.0

    def says(self, form: Form, values: Floats, case: MeasuredMoves) -> str:
        if form.key == "whole arm":
            return (
                f"lifting takes up to {values.sum():.0%} of the acceleration (wrist {values[0]:.0%}, "
                f"elbow {values[1]:.0%}) and gives it to the braking"
            )
        if form.key == "lift and reach":
            return (
                f"lifting takes up to {values[0]:.0%} of the acceleration and drawing the arm in {values[1]:.0%}, "
                "and they give it to the braking"
            )
        if form.key == "any arm":
            return (
                f"lifting takes up to {values[0]:.0%} of the acceleration in the middle of the space, more or less "
                "elsewhere, and gives it to the braking"
            )
        if form.key == "steep":
            less = f"{abs(values[0]):.0%} {'less' if values[0] > 0 else 'more'} acceleration"
            return f"straight up and straight down both ramps have {less} than level moves"
        if form.key == "both ramps":
            way, back = ("up", "down") if values[0] > 0 else ("down", "up")
            less = f"{abs(values[0]):.0%} less acceleration"
            return f"straight {way} both ramps have {less}, straight {back} as much more"
        if form.key == "starting alone":
            way, back = ("up", "down") if values[0] > 0 else ("down", "up")
            less = f"{abs(values[0]):.0%} less acceleration"
            return f"straight {way} the starting ramp has {less}, straight {back} as much more; braking is as simulated"
        if form.key == "up and down apart":
            up, down = (f"{abs(v):.0%} {'less' if v >= 0 else 'more'}" for v in values)
            return f"straight up both ramps have {up} acceleration, straight down {down}"
        if form.key == "against alone":
            return f"gravity takes {values[0]:.0%} of the acceleration straight up, and of the braking straight down"
        return f"straight up gravity takes {values[0]:.0%} of the acceleration and gives it to the braking"


def _apart() -> tuple[TermParameter, TermParameter]:
    """One parameter for moves that go up, one for those that go down, with either sign: controllers' tables differ."""
    up, down = (
        TermParameter(name, "1", -0.9, 0.9, 0.0, False, f"acceleration lost straight {name}")
        for name in ("up", "down")
    )
    return up, down


def _lifts(case: MeasuredMoves) -> Floats:
    """Rise of wrist and elbow per path length, along the path (n, m, 2); 0 for joint moves."""
    assert case.rates is not None
    assert case.rates.bodies is not None
    height = case.rates.bodies[:, :, ::-1, 2]
    slope = (
        np.gradient(height, axis=1) * (height.shape[1] - 1) / np.maximum(case.base.way, 1e-9)[:, None, None]
    )
    return np.where((case.joint | ~case.moving)[:, None, None], 0.0, np.nan_to_num(slope))


def _outside(case: MeasuredMoves) -> Floats:
    """Rise of the tool, and its approach to the first axis, per path length (n, 2).

    From tool points alone these two describe how an arm's bodies rise: the elbow goes up as the arm is drawn in.
    """
    length = np.maximum(np.nan_to_num(case.length), 1e-9)
    near, far = (np.hypot(p[:, 0], p[:, 1]) for p in (case.start, case.end))
    both = np.stack([case.rise, np.nan_to_num(near - far) / length], axis=1)
    return np.where((case.joint | ~case.moving)[:, None], 0.0, both)


def _anywhere() -> Form:
    """The work against gravity as a quadratic function of height and reach, which approximates any arm in one
    posture.
    """
    parameters = (
        TermParameter("up", "1", 0.0, 1.5, 0.0, False, "acceleration lost to going up in the middle"),
        TermParameter("inward", "1", -1.0, 1.0, 0.0, False, "acceleration lost to drawing the arm in"),
        TermParameter("higher", "1", -3.0, 3.0, 0.0, False, "more of it for going up at the top"),
        TermParameter("farther", "1", -3.0, 3.0, 0.0, False, "more of it for drawing in far out"),
        TermParameter("mixed", "1", -3.0, 3.0, 0.0, False, "more of each with the other"),
    )
    return Form(
        "any arm",
        parameters,
        r"a_{acc,dec} = a\,(1 \mp U'(s)),\; U' = (k_u + k_h \zeta - k_m \rho) z' - (k_i + k_f \rho - k_m \zeta) r'",
    )


def _mean(values: Floats) -> float:
    return float(np.mean(values))


def _spread(values: Floats) -> float:
    """[m] twice the standard deviation, at least a millimetre."""
    return max(2.0 * float(np.std(values)), 1e-3)


def _works(case: MeasuredMoves) -> Floats:
    """Contribution of each parameter of `any arm` to the pull along the path (n, m, 5).

    zeta and rho: height and reach from the mean of all moves' ends, in units of their spread.
    """
    linear = case.moving & ~case.joint
    places = np.linspace(0.0, 1.0, _PLACES)[None, :, None]
    points = case.start[:, None, :] + places * (case.end - case.start)[:, None, :]
    height, reach = points[:, :, 2], np.hypot(points[:, :, 0], points[:, :, 1])
    shape = []
    for name, values in (("height", height), ("reach", reach)):
        both = values[linear][:, [0, -1]]
        both = both[np.isfinite(both)] if np.isfinite(both).any() else np.zeros(1)
        middle = case.number(f"middle {name}", partial(_mean, both))
        spread = case.number(f"spread {name}", partial(_spread, both))
        shape.append((values - middle) / spread)
    zeta, rho = shape
    way = np.maximum(np.nan_to_num(case.length), 1e-9)[:, None]
    up = np.gradient(height, axis=1) * (_PLACES - 1) / way
    inward = -np.gradient(reach, axis=1) * (_PLACES - 1) / way
    basis = [up, inward, zeta * up, rho * inward, zeta * inward - rho * up]
    return np.where(linear[:, None, None], np.nan_to_num(np.stack(basis, axis=2)), 0.0)
