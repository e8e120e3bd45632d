"""`blending`: corners are rounded, so ramps at blended ends overlap."""

from __future__ import annotations

import numpy as np

from olp.physics._case import Case, Floats
from olp.physics._motion import Motion
from olp.physics.term import Form, MoveTerm, Parameter, Stage

# Key -> how much of a full overlap a rounding r gives at speed v and acceleration a, at most 1.
_LAWS = {
    "braking": r"s = \kappa \min(1, \sqrt{2 r a}/v)",
    "distance": r"s = \kappa \min(1, r a / v^2)",
    "full": r"s = \kappa",
    "corner": r"s = \kappa \cos^2(\theta/2)",
}


class Blending(MoveTerm):
    summary = "corners are rounded: time is saved (or not saved) at blended ends"
    does = (
        "moves with a rounded end, and those after them, differ; moves between exact stops are as simulated"
    )
    source = "overlap of the braking and the next ramp, at most a whole ramp (measured on a DX200, docs/blending.md)"
    confusable = ("settling", "dispatch")
    stage = Stage.SHAPES
    phase = "corner"

    def forms(self, case: Case) -> tuple[Form, ...]:
        rounded = case.moving & ~case.stop_end
        if rounded.sum() < 2:
            return ()
        share = Parameter("overlap", "1", 0.0, 1.3, np.nan, False, "of a braking and the next ramp")
        known = [key for key in ("braking", "distance") if np.nan_to_num(case.blend[rounded]).max() > 0]
        known += ["full"] + (["corner"] if np.isfinite(case.corner[rounded]).all() else [])
        return tuple(Form(key, (share,), _LAWS[key]) for key in known)

    def lacks(self, case: Case) -> str:
        return "" if self.forms(case) else "moves with rounded ends (blend_mm or pl)"

    def guesses(self, form: Form, case: Case) -> Floats:
        return np.array([[0.05], [0.5], [0.95]])

    def act(self, motion: Motion, form: Form, values: Floats, case: Case) -> Motion:
        end = _overlap(form.key, case.blend, motion.speed, motion.decelerate, case.corner)
        before = np.concatenate([[np.nan], case.corner[:-1]])
        start = _overlap(form.key, case.blend_start, motion.speed, motion.accelerate, before)
        return motion.with_(
            share_end=np.where(case.stop_end, motion.share_end, 1.0 - values[0] * end),
            share_start=np.where(case.stop_start, motion.share_start, 1.0 - values[0] * start),
        )

    def says(self, form: Form, values: Floats, case: Case) -> str:
        return f"at rounded corners {values[0]:.0%} of the {'possible ' if form.key != 'full' else ''}overlap of two ramps is used"


def _overlap(key: str, radius: Floats, speed: Floats, slow: Floats, corner: Floats) -> Floats:
    """(n,) [1] of a full overlap."""
    radius = np.nan_to_num(radius)
    if key == "braking":
        return np.asarray(np.minimum(1.0, np.sqrt(2.0 * radius * slow) / speed))
    if key == "distance":
        return np.asarray(np.minimum(1.0, radius * slow / speed**2))
    if key == "corner":
        return np.asarray(np.cos(np.nan_to_num(corner) / 2.0) ** 2)
    return np.ones_like(speed)
