"""What a timing signature says of a plan's straight moves: their corrected acceleration, and an interval.

Code: H013 a motion model that a signature does not hold for.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from olp.plan import PATHS, Plan, StepKind
from olp.program import Path

if TYPE_CHECKING:
    from collections.abc import Callable

    from olp.signature import Prediction, Signature
    from olp.timing.demand import Demand

Floats = NDArray[np.float64]
_STRAIGHT = PATHS.index(Path.LINEAR)
_SAME = 1e-5  # [m] moves nearer than this are one move that runs again


class Signed(NamedTuple):
    """`rows` (m,) of Moves that the signature times, and what it says of them."""

    rows: NDArray[np.intp]
    signature: Signature
    said: Prediction
    again: NDArray[np.intp]  # (m,) which distinct move each row is: errors of repeats are the same error


class Interval(NamedTuple):
    """95 %: `low`, `high` (n,) [s] per step, nan where nothing is known; of the whole program [s]."""

    low: Floats
    high: Floats
    total_low: float
    total_high: float


def sign(plan: Plan, wanted: Demand, signature: Signature, report: Callable[[str], None]) -> Signed | None:
    """Puts the corrected acceleration into `wanted`, scaled by ACC= and DEC=. Raises OlpError (see predict)."""
    from olp.geometry import Pose, rotation_from_quaternion
    from olp.signature import MoveSet, predict

    moves, positions = plan.moves, plan.positions
    arm = np.array([robot is not None and robot is plan.robot for robot in plan.robots], dtype=bool)
    mine = (moves.path == _STRAIGHT) & wanted.metric & ~wanted.unknown & ~wanted.slowed & (wanted.rule == 0)
    mine &= (wanted.length > 0) & np.isfinite(moves.travel)
    mine &= arm[moves.mechanism] if len(arm) else False
    known = np.asarray(np.isfinite(positions.position).all(axis=1))
    mine &= known[moves.start] & known[moves.target]
    rows = np.nonzero(mine)[0]
    if not len(rows):
        report("the signature times none of the moves: none is a straight move of the arm with known points")
        return None
    start, end = positions.position[moves.start[rows]], positions.position[moves.target[rows]]
    turned = positions.quaternion[moves.start[rows]]
    rotation = np.full((len(rows), 3, 3), np.nan)
    told = np.asarray(np.isfinite(turned).all(axis=1))
    if told.any():
        rotation[told] = rotation_from_quaternion(turned[told])
    nothing = np.full(len(rows), np.nan)
    asked = MoveSet(
        start=start,
        end=end,
        rotation=rotation,
        speed=wanted.speed[rows],
        nominal=wanted.acceleration[rows],
        duration=nothing,
        payload=nothing,
        configuration=("",) * len(rows),
        program=(plan.path,) * len(rows),
        tool=None if signature.tool is None else Pose.from_xyz_angles(signature.tool),
    )
    said = predict(signature, asked, plan.robot)
    wanted.acceleration[rows] = said.acceleration * moves.acceleration[rows]
    wanted.deceleration[rows] = said.acceleration * moves.deceleration[rows]
    outside = [(row, reason) for row, reason in zip(rows.tolist(), said.reasons, strict=True) if reason]
    if outside:
        report(
            f"{len(outside)} of {len(rows)} straight moves are outside what the signature learnt: {outside[0][1]}"
        )
    keys = np.round(np.concatenate([start, end, asked.speed[:, None]], axis=1) / _SAME)
    again = np.unique(keys, axis=0, return_inverse=True)[1].reshape(-1)
    return Signed(rows, signature, said, again)


def interval(
    plan: Plan, signed: Signed, duration: Floats, stops: NDArray[np.bool_], report: Callable[[str], None]
) -> Interval:
    """Of steps that last `duration` (n,) [s]; `stops` (rows of Moves): moves that run from stop to stop."""
    is_move = plan.kind == StepKind.MOVE
    first = plan.row[is_move]
    low, high = duration.copy(), duration.copy()
    low[is_move] = high[is_move] = np.nan
    place = dict(zip(first.tolist(), np.nonzero(is_move)[0].tolist(), strict=True))
    led = [(i, place[row]) for i, row in enumerate(signed.rows.tolist()) if row in place]
    index = np.array([i for i, _ in led], dtype=np.intp)
    steps = np.array([s for _, s in led], dtype=np.intp)
    said = signed.said
    low[steps] = duration[steps] - (said.duration - said.low)[index]
    high[steps] = duration[steps] + (said.high - said.duration)[index]
    # Repeats of a move have one error, many times.
    names, chosen, count = np.unique(signed.again[index], return_index=True, return_counts=True)
    half = (
        said.take(index[chosen]).total_half(signed.signature, count.astype(np.float64)) if len(names) else 0.0
    )
    total = float(np.nansum(duration))
    others = int(is_move.sum()) - len(steps)
    if others:
        report(
            f"the interval is that of {len(steps)} straight moves; {others} other moves are taken as exact"
        )
    rolling = int(np.sum(~stops[signed.rows]))
    if rolling:
        report(f"{rolling} straight moves pass a corner; the signature was learnt from stop to stop")
    floor = total - float(np.nansum(duration[steps])) if len(steps) else total
    return Interval(low, high, max(total - half, floor), total + half)
