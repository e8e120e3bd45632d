"""A dead band at reversals: the axis stands still until the gear has crossed its play."""

from __future__ import annotations

from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from olp.timing.physics.term import LogTerm, TermParameter

Floats = NDArray[np.float64]


class Backlash(LogTerm):
    summary = "a dead band at reversals"
    does = "after a reversal the axis stands still until the play is crossed, then is off by half of the play"
    source = "M. Nordin, P.-O. Gutman, Controlling mechanical systems with backlash, Automatica 38(10), 2002"
    confusable = ("coulomb-friction",)
    equation: ClassVar[str] = r"q = \min(\max(q^-, \theta - \tfrac{b}{2}), \theta + \tfrac{b}{2})"
    parameters: ClassVar[tuple[TermParameter, ...]] = (
        TermParameter("play", "rad", 0.0, 0.1, 0.0, meaning="whole width of the dead band"),
    )

    def seen_in(self, columns: frozenset[str]) -> bool:
        return bool(columns & {"command", "sim"})


def play(motor: Floats, width: float) -> Floats:
    """Lag (n,) of the axis behind its motor, both [rad | m], for a dead band of `width`.

    Within a stretch of one direction the play operator is a maximum (or minimum) with where the stretch before ended,
    so the loop runs over the ends of stretches only.
    """
    half = width / 2
    if half <= 0:
        return np.zeros_like(motor)
    # Less than a hundredth of the play is no reversal: at rest a computed curve is never quite still.
    direction = np.sign(np.diff(np.round(motor / (half / 50))))
    moves = np.nonzero(direction)[0]
    if not len(moves):
        return np.zeros_like(motor)
    turns = moves[1:][direction[moves[1:]] != direction[moves[:-1]]]
    edges = np.concatenate([[0], turns, [len(motor)]])
    # Nobody knows where in the play the log begins: on the side of the first motion.
    first = rises = bool(direction[moves[0]] > 0)
    at = float(motor[0] - half if rises else motor[0] + half)
    before = []
    for end in motor[edges[1:] - 1].tolist():
        before.append(at)
        at = max(end - half, at) if rises else min(end + half, at)
        rises = not rises
    lengths = np.diff(edges)
    held = np.repeat(before, lengths)
    rising = np.repeat((np.arange(len(before)) % 2 == 0) == first, lengths)
    axis = np.where(rising, np.maximum(motor - half, held), np.minimum(motor + half, held))
    return np.asarray(axis - motor)
