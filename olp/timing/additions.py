"""What the controller adds to each step: before it begins, and after its motion has ended."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from olp.robots.controller_effects import Effects
from olp.runtime.plan import Plan, StepKind

Floats = NDArray[np.float64]
_ROUNDING = 1e-9  # of a cycle: a motion that ends this little after a cycle ended with it


class Additions(NamedTuple):
    """[s] per step of the plan (n,)."""

    before: Floats
    after: Floats

    @property
    def total(self) -> Floats:
        return self.before + self.after


def additions(
    plan: Plan,
    end_speed: Floats,
    duration: Floats,
    effects: Effects,
    measured: NDArray[np.bool_] | None = None,
) -> Additions:
    """`end_speed` [m/s] per row of Moves; `duration` [s] per step, of the motion, the wait or the signal itself.

    `measured`, per row of Moves: moves whose time was learnt from stop to stop, with all that is added here in it.
    """
    count = len(plan)
    before, after = np.zeros(count), np.zeros(count)
    if not count or not (effects.dispatch or effects.servo_lag or effects.cycle):
        return Additions(before, after)
    is_move = plan.kind == StepKind.MOVE
    moves = is_move & (np.nan_to_num(duration) > 0)
    stops = np.zeros(count, dtype=bool)
    if is_move.any():
        stops[is_move] = np.maximum.reduceat(end_speed, plan.row[is_move]) == 0.0
    stops &= moves
    learnt = np.zeros(count, dtype=bool)
    if measured is not None and is_move.any():
        learnt[is_move] = measured[plan.row[is_move]]
    before[_standing_before(moves, stops) & ~learnt] = effects.dispatch
    after[stops & ~learnt] = effects.servo_lag
    if effects.cycle:
        whole = _to_whole_cycles(np.where(moves, np.nan_to_num(duration) + after, 0.0), stops, effects.cycle)
        after += np.where(learnt, 0.0, whole)
    return Additions(before, after)


def _standing_before(moves: NDArray[np.bool_], stops: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Whether the last motion before each step ended in a stop; the arm stands at first."""
    last = np.maximum.accumulate(np.where(moves, np.arange(len(moves)), -1))
    earlier = np.concatenate(([-1], last[:-1]))
    standing: NDArray[np.bool_] = (earlier < 0) | stops[earlier]
    return standing


def _to_whole_cycles(motion: Floats, stops: NDArray[np.bool_], cycle: float) -> Floats:
    """What each stop waits for its cycle to end [s]."""
    stretch = np.concatenate(([0], np.cumsum(stops)[:-1]))
    sums = np.bincount(stretch, weights=motion)
    missing = np.ceil(sums / cycle - _ROUNDING) * cycle - sums
    result: Floats = np.where(stops, np.maximum(missing, 0.0)[stretch], 0.0)
    return result
