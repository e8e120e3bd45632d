"""Friction torque in proportion to speed."""

from __future__ import annotations

from typing import ClassVar

import numpy as np

from olp.timing.physics._case import Floats, MeasuredMoves
from olp.timing.physics._motion import Motion
from olp.timing.physics._ramps import PASSED, divided_by_speed, fastest_along, per_speed
from olp.timing.physics.term import Form, LogTerm, MoveTerm, Stage, TermParameter

_MOST = 0.95  # of the force that friction may take at the highest speed
# Friction is against drives, and helps brakes, unless a planner brakes as it did without.
_SIGNS, _DRIVES = np.array([1.0, -1.0])[:, None, None], np.array([1.0, 0.0])[:, None, None]
_EQUATIONS = {
    "": r"a_{acc} = a - k v,\; a_{dec} = a + k v",
    "axes": r"a_{acc} = a\,(1 - k \dot q),\; a_{dec} = a\,(1 + k \dot q)",
    "speeding up": r"a_{acc} = a - k v,\; a_{dec} = a",
    "axes, speeding up": r"a_{acc} = a\,(1 - k \dot q),\; a_{dec} = a",
}  # by the speed of the path, or by that of the fastest axis
_AXES, _ALONE = "axes", "speeding up"  # what keys begin and end with
_MEANS = {False: "of acceleration per speed", True: "share of acceleration per speed of the fastest axis"}


class ViscousFriction(MoveTerm, LogTerm):
    summary = "torque against motion, in proportion to speed"
    does = "the faster an axis turns, the more torque it needs at the same acceleration, in both directions alike"
    source = "B. Armstrong-Hélouvry, P. Dupont, C. Canudas de Wit, Automatica 30(7), 1994, section 2"
    confusable = ("coulomb-friction", "torque-speed", "servo-lag")
    equation: ClassVar[str] = r"\Delta\tau = b\,\dot q"
    parameters: ClassVar[tuple[TermParameter, ...]] = (
        TermParameter("viscous", "Nm s/rad", 0.0, 1e5, 0.0, meaning="torque per speed of the axis"),
    )

    stage = Stage.SCALES
    phase = "accelerate"

    def forms(self, case: MeasuredMoves) -> tuple[Form, ...]:
        forms = []
        for key, equation in _EQUATIONS.items():
            share = _shares(case, key)[case.moving]
            if len(share) and np.ptp(share) > 0:
                means = _MEANS[key.startswith(_AXES)]
                loss = TermParameter(
                    "loss", _unit(case, key), 0.0, _MOST / float(share.max()), 0.0, False, means
                )
                forms.append(Form(key, (loss,), equation))
        return tuple(forms)

    def guesses(self, form: Form, case: MeasuredMoves) -> Floats:
        return np.array([[0.3], [0.8]]) * form.parameters[0].high

    def act(self, motion: Motion, form: Form, values: Floats, case: MeasuredMoves) -> Motion:
        """Ramps whose force falls, or grows, with the speed: ∫ dv / (a ∓ k v)."""
        if form.key.startswith(_AXES):
            shares = fastest_along(case, "axes")
        else:
            shares = PASSED / np.stack([motion.accelerate, motion.decelerate])[..., None]
        signs = _DRIVES if form.key.endswith(_ALONE) else _SIGNS
        return divided_by_speed(motion, values[0] * signs * shares, _divided)

    def says(self, form: Form, values: Floats, case: MeasuredMoves) -> str:
        most = values[0] * float(_shares(case, form.key)[case.moving].max())
        of = " of the fastest axis" if form.key.startswith(_AXES) else ""
        when = ", which braking does not use" if form.key.endswith(_ALONE) else ""
        return f"friction{of} takes up to {most:.0%} of the force at the programmed speeds{when}"

    def seen_in(self, columns: frozenset[str]) -> bool:
        return bool(columns & {"torque", "current"})


def viscous(speed: Floats) -> Floats:
    """Torque (n,) per unit of the coefficient at `speed` (n,) [rad/s | m/s]."""
    return speed


def _divided(share: Floats) -> tuple[Floats, Floats]:
    """Divisor (2, n, k) of accelerations of which friction takes a `share` (2, n, k), less than 0 where it helps, and
    its slope by the logarithm of the speed."""
    over = 1.0 / np.maximum(1.0 - share, 1.0 - _MOST)
    return over, np.where(share < _MOST, over**2 * share, 0.0)


def _shares(case: MeasuredMoves, key: str) -> Floats:
    """(n,) [s] speed over acceleration of the simulation; "axes": [1] or [rad/s] speed of the fastest axis."""
    top = case.base.top()
    return np.asarray(per_speed(case, "axes") * top if key.startswith(_AXES) else top / case.base.accelerate)


def _unit(case: MeasuredMoves, key: str) -> str:
    if not key.startswith(_AXES):
        return "1/s"
    return "1" if case.rates is not None and case.rates.rated is not None else "s/rad"
