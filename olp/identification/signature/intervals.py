"""95 % intervals of move durations: learnt for the kinds of moves that the recording has, assumed for all others.

Assumed: without joint moves in the recording, their ramps take 0 to 3 times the computed time; without curves, theirs
take 0 to 2 times; without corners, each corner may cost half a stop more or less, and half of what it saves.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from olp.identification.recording.moves import CIRCULAR as CURVED
from olp.identification.recording.moves import JOINT as TURNING
from olp.identification.signature.coefficients import CIRCULAR, CORNER, JOINT, Parts
from olp.identification.signature.errors import Spread
from olp.identification.signature.stretch_times import JointRows, Times

Floats = NDArray[np.float64]
Mask = NDArray[np.bool_]

_JOINT_GUESS, _CURVE_GUESS = 3.0, 2.0
_NORMAL = 1.96


def ends_of(
    parts: Parts,
    kind: NDArray[np.int8],
    times: Times,
    stops: NDArray[np.int64],
    corner: Mask,
    half: Floats,
    strain: Floats,
    law: str,
    joints: JointRows | None = None,
) -> tuple[Floats, Floats]:
    """Low and high (n,) [s]. `joints`: rows whose own law tells an interval.

    `half` (n,) [s] of a straight move from stop to stop there; `strain` (n,) [1] how far outside it is.

    `stops`: ends at which the arm stands; `corner`: rows that begin or end in one. Of joint moves `half` is not used.
    """
    duration = times.duration
    below, above = half * stops / 2, half * stops / 2
    for code, name, guess in ((TURNING, JOINT, _JOINT_GUESS), (CURVED, CIRCULAR, _CURVE_GUESS)):
        rows = kind == code
        if name in parts:
            part = parts[name]
            wide = part.spread.half * np.maximum(1.0, duration / part.longest) * strain
            below = np.where(rows, wide, below)
            above = np.where(rows, wide, above)
        else:
            own = np.where(code == TURNING, 0.0, half) * stops / 2
            below = np.where(rows, own + times.over + times.fixed, below)
            above = np.where(rows, own + (guess - 1) * times.over + times.fixed, above)
    if joints is not None:
        share = stops[joints.rows] / 2
        below[joints.rows] = (joints.times.duration - joints.times.low) * share
        above[joints.rows] = (joints.times.high - joints.times.duration) * share
    known = CORNER in parts and parts[CORNER].law == law
    if known:
        wide = parts[CORNER].row_half * strain
        extra = np.where(corner, np.hypot(below, wide) - below, 0.0)
    else:
        extra = np.where(corner, times.full / 2 + np.abs(np.nan_to_num(times.saving)) / 2, 0.0)
    # A zone that is not known may reach to the middle of the move.
    lost = np.where(np.isnan(times.saving), times.floor / 2, 0.0)
    # Only a corner lets a move take less than its way at the programmed speed.
    lowest = np.where(corner, 0.0, np.minimum(times.floor, duration))
    if joints is not None:
        lowest[joints.rows] = 0.0  # rated speeds are numbers that may be wrong
    low = np.maximum(duration - below - extra - lost, lowest)
    return low, duration + above + extra


def learnt_half(spread: Spread, often: NDArray[np.int64] | Floats) -> float:
    """[s] half-width of a sum; `often` (m,): how many times each distinct move, or stretch, runs."""
    own = _NORMAL * spread.own * float(np.sqrt(np.sum(often.astype(np.float64) ** 2)))
    return float(np.hypot(own, spread.quantile * spread.shared * float(np.sum(often))))
