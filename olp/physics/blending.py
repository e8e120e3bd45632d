"""`blending`: corners are rounded, so ramps at blended ends overlap."""

from __future__ import annotations

import numpy as np

from olp.physics._case import Case, Floats
from olp.physics._motion import Motion
from olp.physics.term import Form, MoveTerm, Parameter, Stage

_EQUATIONS = {
    "braking": r"s = t_{brake}(\min(\kappa r, L/2))",
    "distance": r"s = \min(2 \kappa r / v,\, v/a)",
    "full": r"s = \kappa\,v/a",
}
_UNKNOWN = 1e-6  # [m] a rounding that nobody tells the size of


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
        rounded = case.base.round_end[case.moving] > 0
        if rounded.sum() < 2:
            return ()
        rounding = Parameter("overlap", "1", 0.0, 3.0, np.nan, False, "of the rounding that is used")
        ramps = Parameter("overlap", "1", 0.0, 1.3, np.nan, False, "of a braking and the next ramp")
        forms = [Form("full", (ramps,), _EQUATIONS["full"])]
        if case.base.round_end.max() > _UNKNOWN:
            split = Parameter(
                "split", "1", 0.0, 1.0, 0.5, False, "of what is saved that the move before gets"
            )
            forms += [Form(key, (rounding,), _EQUATIONS[key]) for key in ("braking", "distance")]
            forms.append(Form("braking, split", (rounding, split), _EQUATIONS["braking"]))
        return tuple(forms)

    def lacks(self, case: Case) -> str:
        return "" if self.forms(case) else "moves with rounded ends (blend_mm or pl)"

    def guesses(self, form: Form, case: Case) -> Floats:
        overlaps = np.array([[0.02], [0.5], [1.0]])
        return overlaps if len(form.parameters) == 1 else np.hstack([overlaps, np.full_like(overlaps, 0.5)])

    def act(self, motion: Motion, form: Form, values: Floats, case: Case) -> Motion:
        law = form.key.split(",")[0]
        split = float(values[1]) if len(values) > 1 else 0.5
        return motion.with_(law=law, overlap=float(values[0]), split=split)

    def says(self, form: Form, values: Floats, case: Case) -> str:
        if values[0] < 0.02:
            return "rounded corners save no time: they take as long as exact stops"
        if form.key == "full":
            return f"at rounded corners {values[0]:.0%} of the braking overlaps with the next ramp"
        how = (
            "as long as braking there takes"
            if form.key.startswith("braking")
            else "as long as it takes at full speed"
        )
        return f"moves overlap over {values[0]:.0%} of the rounding, {how}"
