"""`payload`: acceleration falls with the carried mass."""

from __future__ import annotations

import numpy as np

from olp.timing.physics._case import Floats, MeasuredMoves
from olp.timing.physics._motion import Motion
from olp.timing.physics.term import Form, MoveTerm, Stage, TermParameter

_SPREAD = 0.1  # [kg]
_TOLD = "real over simulated"
_AT_CORNERS = "at corners, too"
_LOADS = 6  # of those that are carried, the simulated one among them


class Payload(MoveTerm):
    summary = "acceleration falls with the carried mass"
    does = "ramps of moves with more payload are longer; moves without are as simulated"
    source = "Newton's second law with a constant force: a = F / (m0 + m); Apostolovic, equation 6.19 (carried mass)"
    confusable = ("payload-inertia", "acceleration")
    stage = Stage.SCALES
    phase = "accelerate"

    def forms(self, case: MeasuredMoves) -> tuple[Form, ...]:
        mass = case.payload[case.moving]
        if _told(case):
            both = np.concatenate([mass, case.sim_payload[case.moving]])
            most = TermParameter(
                "growth", "1/kg", 0.0, 8.0 / float(np.nanmax(both)), 0.0, False, "of the inertia"
            )
            return (Form(_TOLD, (most,), r"a = a_{sim} (1 + k m_{sim}) / (1 + k m)"),)
        if not len(mass) or np.isnan(mass).all() or np.nanmax(mass) - np.nanmin(mass) < _SPREAD:
            return ()
        one = TermParameter(
            "growth", "1/kg", 0.0, 8.0 / float(np.nanmax(mass)), 0.0, False, "of the inertia per kilogram"
        )
        loss = TermParameter(
            "loss", "1/kg", 0.0, 0.95 / float(np.nanmax(mass)), 0.0, False, "of the force per kilogram"
        )
        forms = [Form("", (one,), r"a(m) = a / (1 + k m)"), Form("weight", (loss,), r"a(m) = a\,(1 - k m)")]
        low, high = float(np.nanmin(mass)), float(np.nanmax(mass))
        # A simulation carries a load that some move carries: any other says that its acceleration is another one.
        simulated = TermParameter(
            "simulated",
            "kg",
            low,
            high,
            np.nan,
            False,
            "load that the simulation carries: one that a move carries",
            listed=True,
        )
        forms.append(
            Form("from the simulated load", (one, simulated), r"a(m) = a\,(1 + k m_{sim}) / (1 + k m)")
        )
        return (*forms, *_at_corners(case, one))

    def lacks(self, case: MeasuredMoves) -> str:
        return "" if self.forms(case) else "payload_kg, with at least two different masses"

    def guesses(self, form: Form, case: MeasuredMoves) -> Floats:
        growth = np.array([[0.02], [0.1]]) * form.parameters[0].high
        if len(form.parameters) == 1:
            return growth
        return np.array([[k[0], load] for k in growth for load in _carried(case)])

    def act(self, motion: Motion, form: Form, values: Floats, case: MeasuredMoves) -> Motion:
        if form.key == _TOLD:
            ratio = (1.0 + values[0] * np.nan_to_num(case.sim_payload)) / (
                1.0 + values[0] * np.nan_to_num(case.payload)
            )
            return motion.with_(accelerate=motion.accelerate * ratio, decelerate=motion.decelerate * ratio)
        if form.key == "weight":
            rest = 1.0 - values[0] * case.once("carried", lambda: np.nan_to_num(case.payload))
            return motion.with_(accelerate=motion.accelerate * rest, decelerate=motion.decelerate * rest)
        simulated = values[1] if len(values) > 1 else 0.0
        carried = case.once(
            "carried or none", lambda: np.where(np.isfinite(case.payload), case.payload, -1.0)
        )
        ratio = (1.0 + values[0] * simulated) / (1.0 + values[0] * np.where(carried < 0, simulated, carried))
        weaker = motion.with_(accelerate=motion.accelerate * ratio, decelerate=motion.decelerate * ratio)
        if form.key != _AT_CORNERS:
            return weaker
        return weaker.with_(open_start=motion.open_start * ratio, open_end=motion.open_end * ratio)

    def says(self, form: Form, values: Floats, case: MeasuredMoves) -> str:
        if form.key == _TOLD:
            off = int(np.nanargmax(np.abs(case.payload - case.sim_payload)))
            ratio = (1.0 + values[0] * case.sim_payload[off]) / (1.0 + values[0] * case.payload[off])
            return (
                f"with {case.payload[off]:.4g} kg, not {case.sim_payload[off]:.4g} kg as simulated, "
                f"there is {ratio:.1%} of the acceleration"
            )
        most = float(np.nanmax(case.payload))
        least = float(np.nanmin(case.payload)) if len(values) > 1 else 0.0
        less = 1.0 - (1.0 + values[0] * least) / (1.0 + values[0] * most)
        less = values[0] * most if form.key == "weight" else less
        where = ", along the way and at corners" if form.key == _AT_CORNERS else ""
        carries = f"; the simulation carries {values[1]:.4g} kg" if len(values) > 1 else ""
        return f"with {most:.4g} kg there is {less:.0%} less acceleration than with {least:.4g} kg{where}{carries}"


def _at_corners(case: MeasuredMoves, one: TermParameter) -> tuple[Form, ...]:
    """Corners, too: a controller that looks ahead passes them by what it plans for the load, or as without one."""
    if not case.base.looks_ahead:
        return ()
    return (Form(_AT_CORNERS, (one,), r"a(m) = a / (1 + k m),\ v_c^2(m) = v_c^2 / (1 + k m)"),)


def _carried(case: MeasuredMoves) -> Floats:
    """Loads (k,) [kg] that the moves carry: the distinct ones, or quantiles if there are too many."""
    loads = case.payload[case.moving & np.isfinite(case.payload)]
    each = np.unique(loads)
    return (
        each
        if len(each) <= _LOADS
        else np.unique(np.quantile(loads, np.linspace(0.0, 1.0, _LOADS), method="nearest"))
    )


def _told(case: MeasuredMoves) -> bool:
    """Whether the simulation used another load than the robot carries."""
    if len(case.sim_payload) != len(case):
        return False
    off = np.abs(case.payload - case.sim_payload)[case.moving]
    return bool(np.isfinite(off).any() and np.nanmax(off) > _SPREAD)
