"""The 95 % interval of every step of a plan, and of the whole, where a signature times it."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from olp.identification.signature.correction import Signed, corners_of
from olp.ir.program import Path
from olp.runtime.plan import PATHS, Plan, StepKind
from olp.timing.chain import Chain
from olp.timing.demand import Demand
from olp.timing.result import CorrectionInterval

Floats = NDArray[np.float64]
Mask = NDArray[np.bool_]
_STRAIGHT, _JOINT = PATHS.index(Path.LINEAR), PATHS.index(Path.JOINT)


class _Rows(NamedTuple):
    """(k,) per row of Moves; `below`, `above` [s] from what the row takes, nan where nothing is known."""

    below: Floats
    above: Floats
    stops: NDArray[np.int64]
    rolling: Mask  # rows that end in a corner
    begins: Mask  # rows that begin in one
    kind: NDArray[np.int8]


def interval(
    plan: Plan,
    signed: Signed,
    wanted: Demand,
    joined: Chain,
    settling: Floats,
    duration: Floats,
    report: Callable[[str], None],
) -> CorrectionInterval:
    """Of steps that last `duration` (n,) [s]; `settling` (k,) [s] of the rows of Moves."""
    rows = _rows(plan, signed, wanted, joined, settling)
    is_move = plan.kind == StepKind.MOVE
    first, steps = plan.row[is_move], np.nonzero(is_move)[0]
    low, high = duration.copy(), duration.copy()
    low[steps] = np.maximum(duration[steps] - rows.below[first], 0.0)
    high[steps] = duration[steps] + rows.above[first]
    total = float(np.nansum(duration))
    known = np.isfinite(rows.below[first])
    leading = np.zeros(len(rows.below), dtype=bool)
    leading[first[known]] = True
    half, below, above = _sum(plan, signed, rows, leading)
    others = int(np.sum(~known & (wanted.length[first] > 0)))
    if others:
        report(f"the interval is that of {int(known.sum())} moves; {others} other moves count as exact")
    _report_guesses(signed, rows, leading, plan, report)
    floor = total - float(np.nansum((duration[steps])[known]))
    return CorrectionInterval(low, high, max(total - half - below, floor), total + half + above)


def _rows(plan: Plan, signed: Signed, wanted: Demand, joined: Chain, settling: Floats) -> _Rows:
    from olp.identification.recording.moves import CIRCULAR, JOINT, LINEAR
    from olp.identification.signature.intervals import ends_of
    from olp.identification.signature.stretch_times import Times

    count = len(wanted.length)
    path = plan.moves.path
    kind = np.where(path == _STRAIGHT, LINEAR, np.where(path == _JOINT, JOINT, CIRCULAR)).astype(np.int8)
    rolling, begins = corners_of(plan, signed, joined)
    stops = 2 - rolling.astype(np.int64) - begins
    half, strain = np.full(count, np.nan), np.ones(count)
    if signed.said is not None:
        half[signed.rows] = signed.said.high - signed.said.duration
        strain[signed.rows] = signed.said.weight / wanted.speed[signed.rows]
    mine = signed.joints.copy()
    mine[signed.rows] = True
    with np.errstate(divide="ignore", invalid="ignore"):
        s = (1 / wanted.acceleration + 1 / wanted.deceleration) / 2
        floor = wanted.length / wanted.speed
        reached = wanted.speed**2 * s <= wanted.length
        full = np.where(reached, wanted.speed * s, 2 * np.sqrt(wanted.length * s) - floor)
    times = Times(
        floor, full * stops / 2, full, settling, joined.saving, np.where(rolling, joined.saving, 0.0)
    )
    corner = rolling | begins
    ends = ends_of(signed.signature.parts, kind, times, stops, corner, half, strain, plan.zone_law)
    below, above = times.duration - ends[0], ends[1] - times.duration
    if signed.timed is not None:
        at, own = signed.timed.rows, signed.timed.times
        below[at] = (own.duration - own.low) * stops[at] / 2
        above[at] = (own.high - own.duration) * stops[at] / 2
    for values in (below, above):
        values[~mine] = np.nan
    if signed.told is not None:
        below[signed.told.rows] = np.minimum(signed.told.half, signed.told.duration)
        above[signed.told.rows] = signed.told.half
    return _Rows(below, above, stops, rolling, begins, kind)


def _sum(plan: Plan, signed: Signed, rows: _Rows, leading: Mask) -> tuple[float, float, float]:
    """Half-width [s] of what was learnt, and how far guesses reach below and above [s]."""
    from olp.identification.recording.moves import CIRCULAR, JOINT, LINEAR
    from olp.identification.signature.intervals import learnt_half

    parts = signed.signature.parts
    squares = _terms_half(plan, signed, leading) ** 2
    leading = leading & ~_by_terms(signed, len(leading))
    squares += _joint_half(plan, signed, leading) ** 2
    leading = leading & ~_by_law(signed, len(leading))
    guessed = np.zeros(len(rows.below), dtype=bool)
    moves = plan.moves
    keys = np.stack([moves.start, moves.target, moves.via], axis=1)
    for code, name in ((JOINT, "joint"), (CIRCULAR, "circular")):
        own = leading & (rows.kind == code)
        if name in parts and own.any():
            often = np.unique(keys[own], axis=0, return_counts=True)[1]
            squares += learnt_half(parts[name].spread, often) ** 2
        else:
            guessed |= own
    straight = leading & (rows.kind == LINEAR)
    squares += _straight_half(signed, straight, rows.stops) ** 2
    turning = leading & rows.rolling
    learnt = "corner" in parts and parts["corner"].law == plan.zone_law
    if learnt and turning.any():
        # A stretch has one error: it is counted at its first corner.
        often = np.unique(keys[turning & ~rows.begins], axis=0, return_counts=True)[1]
        squares += learnt_half(parts["corner"].spread, often) ** 2
    elif not learnt:
        guessed |= leading & (rows.rolling | rows.begins)
    below, above = (float(np.nansum(side[guessed])) for side in (rows.below, rows.above))
    return float(np.sqrt(squares)), below, above


def _by_terms(signed: Signed, count: int) -> Mask:
    """(k,) rows of Moves whose time a diagnosis' terms told."""
    result = np.zeros(count, dtype=bool)
    if signed.told is not None:
        result[signed.told.rows] = True
    return result


def _by_law(signed: Signed, count: int) -> Mask:
    """(k,) rows of Moves that the law of the arm timed."""
    result = np.zeros(count, dtype=bool)
    if signed.timed is not None:
        result[signed.timed.rows] = True
    return result


def _joint_half(plan: Plan, signed: Signed, leading: Mask) -> float:
    """[s] of the joint moves that the law of the arm timed; repeats of a move have one error, many times."""
    from olp.timing.arm_moves import total_half

    if signed.timed is None or not len(signed.timed.rows):
        return 0.0
    use = np.flatnonzero(leading[signed.timed.rows])
    rows, moves = signed.timed.rows[use], plan.moves
    if not len(rows):
        return 0.0
    keys = np.stack([moves.start[rows], moves.target[rows]], axis=1)
    _, first, often = np.unique(keys, axis=0, return_index=True, return_counts=True)
    return total_half(signed.timed.law, signed.timed.moves.take(use[first]), often.astype(np.float64))


def _terms_half(plan: Plan, signed: Signed, leading: Mask) -> float:
    """[s] Repeats of a move have one error, many times; outside what was learnt it is larger."""
    from olp.identification.signature.coefficients import TERMS
    from olp.identification.signature.intervals import learnt_half

    if signed.told is None:
        return 0.0
    use = leading[signed.told.rows]
    rows, moves = signed.told.rows[use], plan.moves
    keys = np.stack([moves.start[rows], moves.target[rows], moves.via[rows]], axis=1)
    _, inverse = np.unique(keys, axis=0, return_inverse=True)
    if TERMS not in signed.signature.parts:  # the law of paths told them, each with its own interval
        return float(np.sqrt(np.sum(np.bincount(inverse.reshape(-1), signed.told.half[use]) ** 2)))
    often = np.bincount(inverse.reshape(-1), signed.told.strain[use])
    return learnt_half(signed.signature.parts[TERMS].spread, often)


def _straight_half(signed: Signed, straight: Mask, stops: NDArray[np.int64]) -> float:
    """[s] Repeats of a move have one error, many times; a move with one end at rest has half of it."""
    at = np.nonzero(straight[signed.rows])[0]
    if not len(at) or signed.said is None:
        return 0.0
    share = stops[signed.rows[at]] / 2
    _, chosen, inverse = np.unique(signed.again[at], return_index=True, return_inverse=True)
    count = np.bincount(inverse.reshape(-1), share).astype(np.float64)
    return signed.said.take(at[chosen]).total_half(signed.signature, count)


def _report_guesses(
    signed: Signed, rows: _Rows, leading: Mask, plan: Plan, report: Callable[[str], None]
) -> None:
    from olp.identification.recording.moves import CIRCULAR, JOINT

    parts = signed.signature.parts
    leading = leading & ~_by_terms(signed, len(leading)) & ~_by_law(signed, len(leading))
    for code, name in ((JOINT, "joint"), (CIRCULAR, "circular")):
        count = int(np.sum(leading & (rows.kind == code)))
        if count and name not in parts:
            report(f"{count} {name} moves: the signature learnt none, their intervals are guessed")
    corners = int(np.sum(leading & rows.rolling))
    if corners and ("corner" not in parts or parts["corner"].law != plan.zone_law):
        report(f"{corners} moves end in a corner: the signature learnt none, their intervals are guessed")
