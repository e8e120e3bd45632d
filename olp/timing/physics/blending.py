"""`blending`: corners are rounded, so ramps at blended ends overlap."""

from __future__ import annotations

import numpy as np

from olp.timing.physics._case import Floats, MeasuredMoves
from olp.timing.physics._motion import ARCS, CURVES, EACH, SHORTER, Motion
from olp.timing.physics.term import Form, MoveTerm, Stage, TermParameter

_EQUATIONS = {
    "full": r"s = \kappa\,v/a",
    "fixed": r"s = \kappa",
    "braking": r"s = t_{brake}(\min(\kappa r, L/2))",
    "share": r"s = \kappa\,t_{brake}(\min(r, L/2))",
    "distance": r"s = \min(2 \kappa r / v,\, v/a)",
    "flight": r"s = 2 \kappa r / v",
    "full shorter": r"s = \kappa\,\min(v/a, v'/a')",
    "braking shorter": r"s = \min(t(\min(\kappa r, L/2)), t'(\min(\kappa r, L'/2)))",
    "share shorter": r"s = \kappa\,\min(t(\min(r, L/2)), t'(\min(r, L'/2)))",
    "share shorter, as planned": r"s = \kappa\,\min(t_0(\min(r, L/2)), t_0'(\min(r, L'/2)))",
    "radius": r"s = \frac{v}{a}\,x\,(2 - x),\; x = \min(\sqrt{\kappa a r}/v, 1)",
    "arc": r"v_c = \min(\sqrt{\kappa a r / \tan(\delta/2)}, v, v')",
    "round": r"v_c = \min(\sqrt{\kappa a r / \tan(\delta/2)}, v, v'),\; l = L - r + r \delta/(2 \tan(\delta/2))",
    "circle": r"v_c = \min(\sqrt{\kappa a r / \tan(\delta/2)}, v),\; l_c = r \delta/(2 \tan(\delta/2))",
    "parabola": r"v_c = \min(\sqrt{\kappa a r \cos^2(\delta/2) / \sin(\delta/2)}, v, v')",
}
_HOW = {
    "braking": "moves overlap over {0:.0%} of the rounding, as long as braking there takes",
    "share": "moves overlap for {0:.0%} of the time that braking over the rounding takes",
    "distance": "moves overlap over {0:.0%} of the rounding, as long as it takes at full speed",
    "flight": "a corner saves {0:.0%} of the time that the rounding takes at full speed",
    "full": "at rounded corners {0:.0%} of the braking overlaps with the next ramp",
    "fixed": "every rounded corner saves {1:.1f} ms",
    "full shorter": "at rounded corners {0:.0%} of the shorter ramp overlaps with the other",
    "braking shorter": "moves overlap over {0:.0%} of the rounding, as long as the quicker of both takes for it",
    "share shorter": "moves overlap for {0:.0%} of the time that the quicker of both takes for its rounding",
    "radius": "rounded corners are passed at the speed that {0:.0%} of the rounding allows as a radius",
    "arc": "rounded corners are passed at the speed that an arc over {0:.0%} of the rounding allows",
    "round": "rounded corners cut the way short by an arc, and its middle is passed at the speed that {0:.0%} of its "
    "radius allows",
    "circle": "rounded corners are passed along an arc, at the speed that {0:.0%} of its radius allows",
    "parabola": "rounded corners are passed along a parabola, at the speed that {0:.0%} of its radius allows",
}
_SIZED = ("braking", "share", "distance", "flight")  # laws that need the size of a rounding
_OWN = ("full", "braking", "distance", "radius")
_SHORTER = tuple(law + SHORTER for law in ("braking", "share"))  # as long as the quicker of both ramps takes
_STOPS = (
    0.05  # [1] of a rounding, or of the ramps there: who uses less stops at the corner, the more so the less
)
_UNKNOWN = 1e-6  # [m] a rounding that nobody tells the size of
_CUT = ", cut"  # behind the key of a form: how much of the shorter move may be rounded is fitted too
_SHARE = ", as a share"  # behind the key of a form: a rounding is a share of the way, as controllers' of joint moves
_RESIZED = (
    ", resized"  # behind the key of a form: the simulation's law of corners, which begin farther or nearer
)
_PLANNED = ", as planned"  # behind the key of a form: the simulation's ramps overlap, whatever the robot's do
_FEWEST = 4  # such corners
_SPLITS = (1.0, 0.5, 0.0)
_PORTIONS = (0.5, 2.0)  # [1/m] that a search for such a share begins with
_SIZE = TermParameter(
    "size", "1", 0.1, 6.0, 1.0, True, "of the rounding at which corners begin, over the simulation's"
)
_SIZES = (0.4, 2.5)  # that a search begins with
_OVERLAPS = {"full": (0.5,), "fixed": (0.1,), "flight": (0.5,), "share": (0.5,)} | {
    law + SHORTER: (0.5,) for law in ("full", "share")
}


class Blending(MoveTerm):
    summary = "corners are rounded: time is saved (or not saved) at blended ends"
    does = "moves with a rounded end, or those after them, differ; moves between exact stops are as simulated"
    source = (
        "measured on a DX200 (docs/blending.md); the recorder decides which of the two moves gets the saving"
    )
    confusable = ("settling", "dispatch")
    stage = Stage.SHAPES
    conditionable = False
    phase = "corner"

    def forms(self, case: MeasuredMoves) -> tuple[Form, ...]:
        rounded = case.base.round_end[case.moving] > 0
        if rounded.sum() < 2:
            return ()
        sized = bool(case.base.round_end.max() > _UNKNOWN)
        split = TermParameter("split", "1", -0.2, 1.2, 0.5, False, "share of the saving for the move before")
        reach = TermParameter(
            "reach", "1", 0.1, 1.0, 0.5, False, "share of the shorter move that is rounded at most"
        )
        portion = TermParameter(
            "portion", "1/m", 0.02, 50.0, np.nan, True, "share of each way that a rounding is, per its size"
        )
        shared = ("full", "full" + SHORTER, "fixed", *((*_SIZED, *_SHORTER) if sized else ()))
        parted = ("share" + SHORTER,) if sized and _turning(case) >= 2 else ()
        planned = ("share" + SHORTER,) if sized else ()
        own = _OWN if sized else _OWN[:1]
        arcs = ARCS if sized and np.isfinite(case.corner).any() else ()
        cut = _SIZED if sized and _cut(case) >= _FEWEST else ()
        return (
            *(Form(law, (_amount(law), split), _EQUATIONS[law]) for law in shared),
            *(Form(law + _CUT, (_amount(law), split, reach), _EQUATIONS[law]) for law in cut),
            *(Form(law + _SHARE, (_amount(law), split, portion), _EQUATIONS[law]) for law in parted),
            *(Form(law + EACH, (_amount(law),), _EQUATIONS[law]) for law in own),
            *(Form(law, (_amount(law),), _EQUATIONS[law]) for law in arcs),
            *(Form(law + _RESIZED, (_SIZE,), r"r = \kappa r_0") for law in CURVES if law == case.base.law),
            *(Form(law + _PLANNED, (_amount(law), split), _EQUATIONS[law + _PLANNED]) for law in planned),
            *(
                Form(law + _SHARE + _PLANNED, (_amount(law), split, portion), _EQUATIONS[law + _PLANNED])
                for law in parted
            ),
        )

    def lacks(self, case: MeasuredMoves) -> str:
        return "" if self.forms(case) else "moves with rounded ends (blend_mm or pl)"

    def guesses(self, form: Form, case: MeasuredMoves) -> Floats:
        if form.key.endswith(_RESIZED):
            return np.array([[size] for size in _SIZES])
        overlaps = _OVERLAPS.get(_law(form), (0.05, 0.5, 1.0))
        if len(form.parameters) == 1:
            return np.array([[overlap] for overlap in overlaps])
        thirds = [[0.3]] if form.key.endswith(_CUT) else [[p] for p in _PORTIONS if _SHARE in form.key]
        rest = thirds or [[]]
        return np.array(
            [[overlap, split, *more] for overlap in overlaps for split in _SPLITS for more in rest]
        )

    def act(self, motion: Motion, form: Form, values: Floats, case: MeasuredMoves) -> Motion:
        if form.key.endswith(_RESIZED):
            start, end = values[0] * motion.round_start, values[0] * motion.round_end
            return motion.with_(round_start=start, round_end=end)
        overlap, split, third = (*values.tolist(), *(0.5, 0.5)[len(values) - 1 :])[:3]
        last = {"portion": third, "reach": 0.5} if _SHARE in form.key else {"reach": third, "portion": 0.0}
        how = {"law": _law(form), "overlap": overlap, "split": split, **last}
        if not form.key.endswith(_PLANNED):
            return motion.with_(**how, added=motion.added + _as_stops(case, _law(form), overlap))
        stops = case.once("without corners", lambda: case.base.with_(law="stop").duration())
        passed = case.base.with_(**how, added=case.base.added + _as_stops(case, _law(form), overlap))
        saved = stops - passed.duration()
        return motion.with_(law="stop", added=motion.added - saved)

    def says(self, form: Form, values: Floats, case: MeasuredMoves) -> str:
        if form.key.endswith(_RESIZED):
            return f"rounded corners begin at {values[0]:.0%} of the way ahead at which the simulation's do"
        law = _law(form).removesuffix(EACH)
        if values[0] < (0.0005 if law == "fixed" else 0.02):
            return "rounded corners save no time: they take as long as exact stops"
        how = _HOW[law].format(values[0], 1000.0 * values[0])
        how += ", by the simulation's ramps" if form.key.endswith(_PLANNED) else ""
        if len(values) == 1:
            return f"{how}; both moves at a corner gain"
        share = float(np.clip(values[1], 0.0, 1.0))
        return f"{how}; the move before the corner gains {share:.0%} of it"


def _as_stops(case: MeasuredMoves, law: str, overlap: float) -> Floats:
    """(n,) [s] that rounded corners take beside their ramps, less what the simulation takes there: who stops at them
    spends what a simulation takes at every stop, who passes them does not."""
    stopped = 0.0 if law == "fixed" else 1.0 - min(overlap / _STOPS, 1.0)
    at_stops, simulated = _at_corners(case)
    return np.asarray(stopped * at_stops - simulated)


def _at_corners(case: MeasuredMoves) -> tuple[Floats, Floats]:
    """(n,) [s] each: what a simulation takes at every stop, of moves with rounded ends; and what it takes there, which
    is the same where it stops at them, else nothing."""

    def work_out() -> Floats:
        base = case.base
        rounded = (base.round_end > 0) & case.moving
        if base.law == "stop":
            return np.stack([np.where(rounded, base.added, 0.0)] * 2)
        stops = base.added[case.moving & ~rounded]
        time = float(np.median(stops)) if len(stops) else 0.0
        return np.stack([np.where(rounded, max(time, 0.0), 0.0), np.zeros(len(case))])

    at_stops, simulated = case.once("time at corners", work_out)
    return at_stops, simulated


def _law(form: Form) -> str:
    """Name of a form's law in `Motion`."""
    return form.key.removesuffix(_PLANNED).removesuffix(_CUT).removesuffix(_SHARE).removesuffix(_RESIZED)


def _turning(case: MeasuredMoves) -> int:
    """Number of rounded corners at which a joint move ends or begins."""
    rounded = case.joint & ((case.base.round_end > 0) | (case.base.round_start > 0))
    return int((rounded & case.moving).sum())


def _cut(case: MeasuredMoves) -> int:
    """Number of corners whose rounding exceeds a third of the shorter move."""
    corners, base = case.base.corners, case.base
    shorter = base.way if corners is None else corners.shorter_end
    return int(((base.round_end > shorter / 3.0) & case.moving).sum())


def _amount(law: str) -> TermParameter:
    """The parameter for how much a corner saves."""
    if law == "fixed":
        return TermParameter("saving", "s", 0.0, 2.0, np.nan, False, "of every rounded corner")
    if law.startswith("full"):
        return TermParameter(
            "overlap", "1", 0.0, 1.3, np.nan, False, "share of braking that overlaps the next ramp"
        )
    meaning = "share of the braking time" if law.startswith("share") else "share of the rounding that is used"
    return TermParameter("overlap", "1", 0.0, 1.5 if law.startswith("share") else 3.0, np.nan, False, meaning)
