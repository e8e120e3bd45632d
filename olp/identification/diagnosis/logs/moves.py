"""Where in a program the axes are off: per numbered move, how late, and in which phase most."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from olp.identification.diagnosis.result import MoveResidual

Floats = NDArray[np.float64]
_STILL = 0.02  # of the move's greatest pace
_STEADY = 0.05  # of it: change of pace over a phase's sample


def late_moves(
    move: NDArray[np.int64], period: float, residual: Floats, speed: Floats, floor: Floats
) -> tuple[MoveResidual, ...]:
    """From residuals (n, k), speeds (n, k) and noise (k,) per axis; nan where not used."""
    found = []
    scale = np.maximum(floor, 1e-12)
    for number in np.unique(move[move >= 0]).tolist():
        rows = np.nonzero((move == number) & np.isfinite(residual).all(axis=1))[0]
        if len(rows) < 8:
            continue
        off, pace = residual[rows] / scale, speed[rows] / scale
        power = float((pace**2).sum())
        late = -float((pace * off).sum()) / max(power, 1e-300)
        error = 1 / math.sqrt(max(power, 1e-300))
        clear = abs(late) > max(4 * error, 0.02 * period)
        found.append(MoveResidual(int(number), None, None, _phase(off, speed[rows]), late, bool(clear)))
    return tuple(found)


def _phase(off: Floats, speed: Floats) -> str:
    """The phase with the largest share of squares."""
    pace = np.sqrt((speed**2).sum(axis=1))
    top = float(pace.max(initial=0.0))
    change = np.gradient(pace)
    still = pace < _STILL * top
    steady = np.abs(change) < _STEADY * max(float(np.abs(change).max(initial=0.0)), 1e-300)
    squares = (off**2).sum(axis=1)
    parts = {
        "settle": still,
        "cruise": ~still & steady,
        "accelerate": ~still & ~steady & (change > 0),
        "decelerate": ~still & ~steady & (change < 0),
    }
    return max(parts, key=lambda name: float(squares[parts[name]].sum()))
