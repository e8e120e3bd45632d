"""`gravity`: acceleration and deceleration depend on how steeply the move goes up or down."""

from __future__ import annotations

import itertools
from functools import partial

import numpy as np

from olp.timing.physics._case import Floats, MeasuredMoves
from olp.timing.physics._motion import Motion
from olp.timing.physics._ramps import forced, pulled
from olp.timing.physics.term import Form, MoveTerm, Stage, TermParameter

_STEEP = 0.2  # sine of the steepest incline that has to be there
_UPWARD, _SIDEWAYS = 0.25, 120.0  # of the other numbers, and in BIC what less of going up costs
_PLACES = 9  # along a straight move
# What a pull adds to the braking ramp. A controller may brake by its written rate, whatever helps.
_BRAKING = {"against and with": 1.0, "against alone": 1.0, "starting alone": 0.0}
_AXES, _AXES_PLANNED = "each axis", "each axis against alone"  # forms of joint moves
_INCLINE = "incline of the tool"
_RAMPS_APART = "starting and braking apart"
_BODIES = ("elbow", "wrist")
_NEAR, _LED = 1e-3, 8  # [m] a body so near to an axis is no load of it; moves: fewer tell nothing of it
_TAKES_OVER = (
    2.0  # times the acceleration of the axis that sets a move: with more, a weight hardly makes it set it
)
_LESS, _MORE = ("less", "more"), ("more", "less")
_SPREAD = 0.1  # [kg]
_LEAST = 0.05  # of the acceleration remains, whatever gravity takes


class Gravity(MoveTerm):
    summary = "acceleration and deceleration depend on how steeply the move goes up or down"
    does = (
        "ramps change with the sine of the incline, up against down or steep against level; those of joint moves with "
        "what their axes hold, or with how steeply the tool goes"
    )
    source = "Apostolovic, chapter 6 (factors over the incline); Newton's second law"
    confusable = ("reach-inertia", "joint-acceleration-limit", "acceleration")
    stage = Stage.SCALES
    phase = "accelerate"

    def forms(self, case: MeasuredMoves) -> tuple[Form, ...]:
        return (*_of_lines(case), *_of_axes(case), *_of_tool(case))

    def lacks(self, case: MeasuredMoves) -> str:
        return (
            ""
            if self.forms(case)
            else "moves with points at several inclines, or joint moves of an arm that is known"
        )

    def guesses(self, form: Form, case: MeasuredMoves) -> Floats:
        if form.key in (_AXES, _AXES_PLANNED):
            return np.array([[0.15 * p.high for p in form.parameters]])
        if form.key in (_INCLINE, _RAMPS_APART):
            return np.array([[0.2, 0.0], [0.2, 0.2], [0.2, -0.2]])
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
        if form.key in (_AXES, _AXES_PLANNED):
            return _axes_pulled(motion, form, values, case)
        if form.key == _INCLINE:
            sine = case.once(_INCLINE, lambda: _inclines(case))
            up, down = (np.maximum(1.0 + k * sine, _LEAST) for k in (-values[0], values[1]))
            return _forced_rows(motion, up, down)
        if form.key in ("whole arm", "any arm"):
            slopes = _slopes(case, form.key)
            return pulled(motion, slopes @ values, _LEAST)
        if form.key == "lift and reach":
            pull = case.once("lift and reach", lambda: _outside(case)) @ values
            return motion.with_(
                accelerate=motion.accelerate * np.maximum(1.0 - pull, _LEAST),
                decelerate=motion.decelerate * np.maximum(1.0 + pull, _LEAST),
            )
        rise = case.once("rise", lambda: np.where(case.joint, 0.0, case.rise))
        if form.key == _RAMPS_APART:
            start, end = 1.0 - values[0] * rise, 1.0 + values[1] * rise
        elif form.key == "up and down apart":
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
        if form.key in (_AXES, _AXES_PLANNED):
            taken = dict[str, float]()
            for (axis, body), value in zip(_held_axes(case), values, strict=False):
                name = case.rates.names[axis] if case.rates is not None else ""
                most = value * (1.0 + (values[-1] * _heaviest(case) if body and _of_load(form) else 0.0))
                taken[name] = taken.get(name, 0.0) + most
            shares = " and ".join(
                f"{share:.0%} of the acceleration of {name}" for name, share in taken.items()
            )
            helped = (
                "and gives it to the braking"
                if form.key == _AXES
                else "on the way up, and of its braking on the way down"
            )
            return f"holding the arm takes up to {shares} {helped}"
        if form.key in (_INCLINE, _RAMPS_APART):
            starting, braking = (
                f"{abs(v):.0%} {words[int(v < 0)]}" for v, words in zip(values, (_LESS, _MORE), strict=True)
            )
            where = "where the tool goes straight up" if form.key == _INCLINE else "straight up"
            return (
                f"{where} the starting ramp has {starting} acceleration and the braking one "
                f"{braking}, straight down the reverse"
            )
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


def _of_lines(case: MeasuredMoves) -> tuple[Form, ...]:
    """Of the pull along straight moves."""
    if not _climbs(case):
        return ()
    share = TermParameter("share", "1", -0.9, 0.9, 0.0, False, "acceleration lost straight up")
    steep = TermParameter("share", "1", 0.0, 0.95, 0.0, False, "acceleration lost straight up")
    arm = _lifted_parts()
    whole = Form("whole arm", tuple(arm), r"a_{acc,dec} = a\,(1 \mp k_w z_w'(s) \mp k_e z_e'(s))")
    inward = TermParameter("inward", "1", -1.0, 1.0, 0.0, False, "acceleration lost to drawing the arm in")
    guessed = Form("lift and reach", (arm[0], inward), r"a_{acc,dec} = a\,(1 \mp k_w z'(s) \pm k_r r'(s))")
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
            _RAMPS_APART,
            _starting_and_braking(),
            r"a_{acc} = a\,(1 - k\sin\gamma),\; a_{dec} = a\,(1 + k_b\sin\gamma)",
        ),
        Form(
            "up and down apart",
            _apart(),
            r"a_\gamma = a\,(1 - k_u \max(\sin\gamma, 0) - k_d \max(-\sin\gamma, 0))",
        ),
    )


def _climbs(case: MeasuredMoves) -> bool:
    """Whether straight moves go up or down."""
    rise = case.rise[case.moving & ~case.joint]
    return len(rise) >= 4 and bool(np.ptp(rise) >= _STEEP)


def _lifted_parts() -> tuple[TermParameter, TermParameter]:
    wrist, elbow = (
        TermParameter(name, "1", 0.0, 1.5, 0.0, False, f"acceleration lost to lifting the {name}")
        for name in ("wrist", "elbow")
    )
    return wrist, elbow


def _of_axes(case: MeasuredMoves) -> tuple[Form, ...]:
    """Of the torque that each axis of a joint move has left; lines beside these are pulled as ever."""
    held = _held_axes(case)
    if not held or case.rates is None:
        return ()
    names = case.rates.names
    own = [
        TermParameter(
            f"{_BODIES[body]}_{names[axis].lower().replace(' ', '_')}",
            "1",
            0.0,
            1.5,
            0.0,
            False,
            f"acceleration of {names[axis]} lost to holding the {_BODIES[body]} farthest out",
        )
        for axis, body in held
    ]
    lines = _lifted_parts() if _climbs(case) and case.bodies_known else ()
    heaviest = case.number("heaviest", partial(_heaviest, case))
    most = 8.0 / max(heaviest, 1e-9)
    load = TermParameter("load", "1/kg", 0.0, most, 0.0, False, "more weight at the wrist per kilogram")
    law = r"a_{acc,dec} = \min_j a_j (1 \mp \sum_b k_{jb}\,\partial z_b / \partial q_j)"
    return tuple(
        Form(key, (*own, *lines, *((load,) if heaviest > 0 else ())), law) for key in (_AXES, _AXES_PLANNED)
    )


def _heaviest(case: MeasuredMoves) -> float:
    """[kg] of the loads; 0 where they are not all known, or do not differ."""
    mass = case.payload[case.moving]
    return float(mass.max()) if np.isfinite(mass).all() and np.ptp(mass) > _SPREAD else 0.0


def _held_axes(case: MeasuredMoves) -> list[tuple[int, int]]:
    """Axes and bodies of which joint moves tell how much of the axis' torque holds the body."""
    lifts = None if case.rates is None else case.rates.lifts
    if lifts is None:
        return []
    pairs = itertools.product(range(lifts.shape[3]), range(len(_BODIES)))
    return [(axis, body) for axis, body in pairs if _farthest(case, axis, body) > 0]


def _of_load(form: Form) -> bool:
    return form.parameters[-1].name == "load"


def _farthest(case: MeasuredMoves, axis: int, body: int) -> float:
    """[m] that a body is out from an axis, at most; 0 where too few moves that the axis may set tell."""

    def work_out() -> float:
        sets = _reserve(case)[:, axis] < _TAKES_OVER
        far = np.abs(_out(case, axis, body)[sets]).max(axis=1, initial=0.0)
        return float(far.max()) if (far > _NEAR).sum() >= _LED else 0.0

    return case.number(f"lift {axis} {body}", work_out)


def _out(case: MeasuredMoves, axis: int, body: int) -> Floats:
    """(n, m) [m] how far out from an axis a body is: a turn of the axis lifts it by as much."""
    assert case.rates is not None
    assert case.rates.lifts is not None
    return np.nan_to_num(case.rates.lifts[:, :, body, axis])


def _reserve(case: MeasuredMoves) -> Floats:
    """(n, k) [1] the acceleration that each axis of a joint move allows, over that of the axis that sets it; inf for
    axes that do not turn, and in other moves."""
    return case.once("reserve", lambda: _allowed(case))


def _allowed(case: MeasuredMoves) -> Floats:
    rates = case.rates
    assert rates is not None
    turned = np.abs(rates.path[:, 0])
    if rates.rated_acceleration is None:
        allowed = np.where(np.stack([case.led(k) for k in range(turned.shape[1])], axis=1), 1.0, np.inf)
    else:
        allowed = rates.rated_acceleration / np.where(turned > 0, turned, np.nan)
    allowed = np.where(
        np.isfinite(allowed) & (case.joint & case.moving & rates.known)[:, None], allowed, np.inf
    )
    least = allowed.min(axis=1, keepdims=True)
    return np.asarray(allowed / np.where(np.isfinite(least), least, 1.0))


def _held(case: MeasuredMoves) -> Floats:
    """(n, m, p) Share of the farthest that each body of `_held_axes` is out from its axis, against the way it turns; 0
    where the axis sets no joint move."""
    assert case.rates is not None
    parts = [
        _out(case, axis, body)
        / _farthest(case, axis, body)
        * np.where(np.isfinite(_reserve(case)[:, axis]), np.sign(case.rates.path[:, 0, axis]), 0.0)[:, None]
        for axis, body in _held_axes(case)
    ]
    return np.stack(parts, axis=2)


def _axes_pulled(motion: Motion, form: Form, values: Floats, case: MeasuredMoves) -> Motion:
    """Each axis loses what it holds against its turn; of all, the one that has least left sets the ramp."""
    pairs, held, reserve = _held_axes(case), case.once("held", lambda: _held(case)), _reserve(case)
    wrist = np.ones(len(case))
    if _of_load(form):
        wrist = wrist + values[-1] * np.nan_to_num(case.payload)
    pulls = dict[int, Floats]()
    for k, (axis, body) in enumerate(pairs):
        pull = held[:, :, k] * (values[k] * (wrist if body else np.ones(1)))[:, None]
        pulls[axis] = pulls[axis] + pull if axis in pulls else pull
    others = np.delete(reserve, list(pulls), axis=1).min(axis=1, initial=np.inf)
    up = down = np.where(case.joint & np.isfinite(reserve).any(axis=1), others, 1.0)[:, None]
    for axis, pull in pulls.items():
        up = np.minimum(up, reserve[:, axis, None] * np.maximum(1.0 - pull, _LEAST))
        down = np.minimum(down, reserve[:, axis, None] * np.maximum(1.0 + pull, _LEAST))
    if len(values) > len(pairs) + 1:  # lines are lifted, too
        lifted = _slopes(case, "whole arm") @ values[len(pairs) : len(pairs) + 2]
        up, down = up * np.maximum(1.0 - lifted, _LEAST), down * np.maximum(1.0 + lifted, _LEAST)
    most = 1.0 if form.key == _AXES_PLANNED else np.inf
    up, down = np.minimum(up, most), np.minimum(down, most)
    return _forced_rows(motion, up, down)


def _forced_rows(motion: Motion, up: Floats, down: Floats) -> Motion:
    """`forced`, of the moves of which less or more than the whole acceleration is available."""
    rows = np.flatnonzero((up != 1.0).any(axis=1) | (down != 1.0).any(axis=1))
    if not len(rows):
        return motion
    some = forced(motion.take(rows), up[rows], down[rows])
    accelerate, decelerate = motion.accelerate.copy(), motion.decelerate.copy()
    accelerate[rows], decelerate[rows] = some.accelerate, some.decelerate
    return motion.with_(accelerate=accelerate, decelerate=decelerate)


def _of_tool(case: MeasuredMoves) -> tuple[Form, ...]:
    """Of how steeply the tool goes along its way, that of joint moves included."""
    if case.rates is None or case.rates.climb is None:
        return ()
    sine = _inclines(case)[case.joint & case.moving]
    if (np.abs(sine).max(axis=1, initial=0.0) > _STEEP).sum() < _LED or np.ptp(sine) < _STEEP:
        return ()
    law = r"a_{acc} = a\,(1 - k\sin\gamma(s)),\; a_{dec} = a\,(1 + k_b\sin\gamma(s))"
    return (Form(_INCLINE, _starting_and_braking(), law),)


def _starting_and_braking() -> tuple[TermParameter, TermParameter]:
    """One parameter for each ramp, with either sign: friction helps to brake, and controllers may brake as written."""
    share = TermParameter("share", "1", -0.9, 0.9, 0.0, False, "acceleration lost straight up")
    braking = TermParameter("braking", "1", -0.9, 0.9, 0.0, False, "braking gained straight up")
    return share, braking


def _inclines(case: MeasuredMoves) -> Floats:
    """(n, m) Sine of the incline of the tool's way along all moves; 0 where it is not known."""
    assert case.rates is not None
    assert case.rates.climb is not None
    return np.where(case.joint[:, None], np.nan_to_num(case.rates.climb), case.rise[:, None])


def _apart() -> tuple[TermParameter, TermParameter]:
    """One parameter for moves that go up, one for those that go down, with either sign: controllers' tables differ."""
    up, down = (
        TermParameter(name, "1", -0.9, 0.9, 0.0, False, f"acceleration lost straight {name}")
        for name in ("up", "down")
    )
    return up, down


def _slopes(case: MeasuredMoves, key: str) -> Floats:
    """(n, m, p) what the parameters of a form along straight moves multiply."""
    return case.once(key, lambda: (_lifts if key == "whole arm" else _works)(case))


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
