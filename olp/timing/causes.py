"""Causes of a program's time: each second of each step has one cause.

speed: the arm moves evenly, at the programmed speed or at its highest. acceleration: it gains or loses speed. exact
stop: what passing the point at speed would save, that is half of each ramp from or to rest there, and the settling.
wait and I/O: nothing moves.
"""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

from olp.runtime.plan import BlendCode, StepKind
from olp.timing.result import Timing

Floats = NDArray[np.float64]
CAUSES: Final = ("speed", "acceleration", "exact stop", "wait", "I/O")
_SPEED, _RAMP, _STOP, _WAIT, _IO = range(len(CAUSES))
_AT_REST: Final = 1e-9
"""[m/s or rad/s] A slower arm stands: what is left of a ramp that ends there differs from processor to processor."""


def seconds_by_cause(timing: Timing) -> Floats:
    """Time of each step by CAUSES (n, 5) [s]; each row sums to the step's duration. Steps without a time are 0."""
    plan = timing.plan
    found = np.zeros((len(plan), len(CAUSES)))
    seconds = np.nan_to_num(timing.duration_s)
    found[plan.kind == StepKind.WAIT, _WAIT] = seconds[plan.kind == StepKind.WAIT]
    found[plan.kind == StepKind.SIGNAL, _IO] = seconds[plan.kind == StepKind.SIGNAL]
    steps = np.flatnonzero(plan.kind == StepKind.MOVE)
    if len(steps):
        found[steps] = _of_moves(timing, plan.row[steps], seconds[steps])
    return found


def _of_moves(timing: Timing, rows: NDArray[np.int32], seconds: Floats) -> Floats:
    """`seconds_by_cause` of moves; `rows`: the row of each move's leading mechanism."""
    clock, profile = timing.rows, timing.rows.profile.take(rows.astype(np.intp))
    lasting = np.nan_to_num(profile.durations)
    even = ((profile.accelerations == 0) & (profile.jerks == 0)) * lasting
    ramps = lasting - even
    exact = timing.plan.moves.blend_code == BlendCode.EXACT
    stops_after = exact[rows]
    stops_before = np.concatenate(([False], stops_after[:-1]))
    rising = profile.speeds[:, 1:] > profile.speeds[:, :-1]
    from_rest = (ramps * rising).sum(axis=1) * (profile.speeds[:, 0] < _AT_REST) * stops_before
    to_rest = (ramps * ~rising).sum(axis=1) * (profile.speeds[:, -1] < _AT_REST) * stops_after
    found = np.zeros((len(rows), len(CAUSES)))
    corners = clock.corners.span[rows] / 2 + clock.entry[rows] / 2
    found[:, _SPEED] = even.sum(axis=1) + corners
    found[:, _STOP] = (from_rest + to_rest) / 2
    found[:, _RAMP] = ramps.sum(axis=1) - found[:, _STOP]
    found /= np.where(clock.rate[rows] > 0, clock.rate[rows], 1.0)[:, None]
    moving = found.sum(axis=1)
    rest = seconds - moving
    # What is beyond the motion is the stop's; a time that was learnt may be shorter than the motion by itself.
    found[:, _STOP] += np.where(rest > 0, rest, 0.0) * stops_after
    found[:, _RAMP] += np.where(rest > 0, rest, 0.0) * ~stops_after
    share = np.where((rest < 0) & (moving > 0), seconds / np.where(moving > 0, moving, 1.0), 1.0)
    return found * share[:, None]
