"""`payload-inertia`: acceleration of the wrist axes falls with the load's moment of inertia."""

from __future__ import annotations

import numpy as np

from olp.timing.physics._case import Floats, MeasuredMoves
from olp.timing.physics._motion import Motion
from olp.timing.physics._ramps import over_ramp
from olp.timing.physics.term import Form, MoveTerm, Stage, TermParameter

_FIRST_OF_WRIST = 3
_RATIO = "real over simulated"
_LED = "leading axis"  # behind the key of a form: of joint moves, those that an axis of the wrist sets
_OTHER = 0.01  # of the load's inertia
_FEWEST = 4  # moves that an axis leads


class PayloadInertia(MoveTerm):
    summary = "acceleration of the wrist axes falls with the load's moment of inertia"
    does = "moves that turn the wrist are longer with bulky loads; moves that do not are as simulated"
    source = "Euler's equation with a constant torque: rate of the wrist = torque / (I0 + I)"
    confusable = ("payload", "orientation-limit")
    stage = Stage.SCALES
    phase = "accelerate"

    def forms(self, case: MeasuredMoves) -> tuple[Form, ...]:
        if _told(case):
            return _ratios(case)
        inertia = case.payload_inertia[case.moving]
        known = inertia[np.isfinite(inertia)]
        if not len(known) or np.ptp(known) <= 1e-4 * max(1.0, float(np.max(known))) or not _wrist(case).any():
            return ()
        one = TermParameter(
            "growth", "1/(kg m^2)", 0.0, 8.0 / float(np.max(known)), 0.0, False, "of the wrist's inertia"
        )
        share = Form("", (one,), r"a(I) = a / (1 + k I w)")
        every = Form("every move", (one,), r"a(I) = a / (1 + k I)")
        led = (Form(_LED, (one,), r"a(I) = a / (1 + k I)"),) if _may_lead(case) else ()
        if case.rates is None or case.rates.rated_acceleration is None:
            return (share, every, *led)
        return (
            share,
            every,
            *led,
            Form("limit", (one,), r"a(I) \le A_j / (1 + k I) / |q_j'|, \quad j = 4, 5, 6"),
        )

    def lacks(self, case: MeasuredMoves) -> str:
        return (
            "" if self.forms(case) else "payload_inertia_kg_m2 with two values, and moves that turn the wrist"
        )

    def by_axis(self, form: Form) -> bool:
        return super().by_axis(form) or form.key.endswith(_LED)

    def guesses(self, form: Form, case: MeasuredMoves) -> Floats:
        if form.key.startswith(_RATIO):  # 1.5, 3 and 9 times the acceleration with no load at all
            return np.array([[0.5], [2.0], [8.0]]) / _heaviest(case)
        return np.array([[0.02], [0.15], [0.5]]) * form.parameters[0].high

    def act(self, motion: Motion, form: Form, values: Floats, case: MeasuredMoves) -> Motion:
        if form.key == "limit":
            less = 1.0 + values[0] * np.nan_to_num(case.payload_inertia)
            start, end = (case.once(f"wrist limit {k}", lambda k=k: _limits(case, k)) for k in (0, 1))  # type: ignore[misc]
            return motion.with_(
                accelerate=_limited(motion.accelerate, start, less),
                decelerate=_limited(motion.decelerate, end, less),
            )
        if form.key.startswith(_RATIO):
            wrist = _wrist_leads(case) if form.key.endswith(_LED) else _led(case, form.axis)
            real, simulated = (
                1.0 + values[0] * wrist * i for i in (case.payload_inertia, case.sim_payload_inertia)
            )
            ratio = np.where(case.moving, np.nan_to_num(simulated / real, nan=1.0), 1.0)
            return motion.with_(accelerate=motion.accelerate * ratio, decelerate=motion.decelerate * ratio)
        share = case.once("wrist inertia", lambda: _wrist(case) * np.nan_to_num(case.payload_inertia))
        if form.key == "every move":
            share = np.nan_to_num(case.payload_inertia)
        elif form.key == _LED:
            share = _wrist_leads(case) * np.nan_to_num(case.payload_inertia)
        less = 1.0 + values[0] * share
        return motion.with_(accelerate=motion.accelerate / less, decelerate=motion.decelerate / less)

    def says(self, form: Form, values: Floats, case: MeasuredMoves) -> str:
        if form.key.startswith(_RATIO):
            off = int(np.nanargmax(np.abs(case.payload_inertia - case.sim_payload_inertia)))
            real, simulated = float(case.payload_inertia[off]), float(case.sim_payload_inertia[off])
            ratio = (1.0 + values[0] * simulated) / (1.0 + values[0] * real)
            of = "the wrist" if form.axis < 0 else form.key.removeprefix(_RATIO).strip()
            return (
                f"the load's inertia is {real:.3g} kg m², not {simulated:.3g} as simulated: "
                f"{of} has {ratio:.0%} of the acceleration"
            )
        most = float(np.nanmax(case.payload_inertia))
        return f"with {most:.3g} kg m² moves of the wrist have {1 - 1 / (1 + values[0] * most):.0%} less acceleration"


def _told(case: MeasuredMoves) -> bool:
    """Whether the simulation used another inertia of the load than the robot's in moves that turn the wrist."""
    if len(case.sim_payload_inertia) != len(case) or not np.isfinite(case.payload_inertia).any():
        return False
    off = np.abs(case.payload_inertia - case.sim_payload_inertia)
    return bool(
        (
            np.nan_to_num(off)[case.moving & (_led(case, -1) > 0)] > _OTHER * np.nanmax(case.payload_inertia)
        ).any()
    )


def _heaviest(case: MeasuredMoves) -> float:
    """The largest inertia of the load [kg m²], of the robot or of the simulation."""
    return float(np.nanmax(np.concatenate([case.payload_inertia, case.sim_payload_inertia])))


def _ratios(case: MeasuredMoves) -> tuple[Form, ...]:
    """Two forms for the whole wrist, and one for each of its axes."""
    equation = r"a = a_{sim} (1 + k I_{sim} w) / (1 + k I w)"
    growth = TermParameter(
        "growth", "1/(kg m^2)", 0.0, 200.0 / _heaviest(case), 0.0, False, "of the wrist's inertia"
    )
    forms = [Form(_RATIO, (growth,), equation)]
    assert case.rates is not None
    if _may_lead(case):
        leading = r"a = a_{sim} (1 + k I_{sim}) / (1 + k I)"
        forms.append(Form(f"{_RATIO}, {_LED}", (growth,), leading))
    for axis, name in enumerate(case.rates.names):
        if axis >= _FIRST_OF_WRIST and (_led(case, axis) > 0).sum() >= _FEWEST:
            one = growth._replace(
                name=f"growth_{name.lower().replace(' ', '_')}", meaning=f"of the inertia of {name}"
            )
            forms.append(Form(f"{_RATIO} {name}", (one,), equation, axis))
    return tuple(forms)


def _led(case: MeasuredMoves, axis: int) -> Floats:
    """The wrist's share of the turning (n,); for a single `axis`: 1 in the moves that it leads.

    With joint moves in the case, straight moves are 0: there the program sets the acceleration, and the axes
    follow.
    """
    if axis < 0:
        share = case.once("wrist", lambda: _wrist(case))
    else:
        share = case.led(axis).astype(np.float64)
    return np.where(case.joint, share, 0.0) if (case.joint & case.moving).any() else share


def _may_lead(case: MeasuredMoves) -> bool:
    """Whether rated speeds tell the leading axis of joint moves, and enough are led by one of the wrist."""
    if case.rates is None or case.rates.rated is None or len(case.rates.names) <= _FIRST_OF_WRIST:
        return False
    return int((_wrist_leads(case) > 0).sum()) >= _FEWEST


def _wrist_leads(case: MeasuredMoves) -> Floats:
    """1 in the joint moves (n,) that an axis of the wrist leads, 0 in all others: axes start and end together, so the
    load slows a move where the wrist sets its pace, or would with this load (`Rivals`)."""
    assert case.rates is not None
    leads = np.any([case.led(axis) for axis in range(_FIRST_OF_WRIST, len(case.rates.names))], axis=0)
    return np.asarray(leads & case.joint & case.moving, dtype=np.float64)


def _wrist(case: MeasuredMoves) -> Floats:
    """The wrist's share of the turning (n,): its fastest axis over the fastest of all."""
    rates = case.rates
    if rates is None or rates.path.shape[2] <= _FIRST_OF_WRIST:
        return np.zeros(len(case))
    mean = np.abs(rates.path).mean(axis=1)
    most = mean.max(axis=1)
    return np.asarray(
        np.where(most > 0, mean[:, _FIRST_OF_WRIST:].max(axis=1) / np.where(most > 0, most, 1.0), 0.0)
    )


def _limited(slow: Floats, limit: Floats, less: Floats) -> Floats:
    """Acceleration (n,) under a limit divided by `less`; the simulation already has the undivided limit."""
    return np.asarray(slow * np.minimum(slow, np.maximum(limit / less, 1e-6)) / np.minimum(slow, limit))


def _limits(case: MeasuredMoves, end: int) -> Floats:
    """Limit (n,) of the path's acceleration from the wrist's rated accelerations over one ramp, inf where the wrist
    does not turn.
    """
    rates = case.rates
    assert rates is not None
    assert rates.rated_acceleration is not None
    wrist = np.abs(rates.path[:, :, _FIRST_OF_WRIST:]) / rates.rated_acceleration[_FIRST_OF_WRIST:]
    with np.errstate(divide="ignore"):
        return np.asarray(1.0 / over_ramp(case, wrist.max(axis=2), end))
