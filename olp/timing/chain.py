"""How neighbouring moves join: where the arm stops, how fast it passes a corner, what the overlap saves.

Corners with a position level follow olp/timing/blending/yaskawa.py: z before the point the next move begins, its
speed ramping up over the next z/V while the first still runs at V. The corner saves z/(2V), with z = the level's zone,
but at most half of the shorter neighbour; dense points save less, and so do points too near for the arm to change its
speed between them. Corner radii, and the zones of other laws, replace the ends of both moves. Either way a row is a
body between its corners, and the pieces in its corners: see olp/timing/corners.py.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from olp.runtime.plan import BlendCode, Plan, StepKind, distinct
from olp.timing.blending.law import load_law
from olp.timing.blending.yaskawa import PositionLevels, delays
from olp.timing.corners import Speeds, fade, replace_ends
from olp.timing.demand import Demand
from olp.timing.result import CornerPieces

Floats = NDArray[np.float64]
_MOST_PASSES = 20  # over a chain: slower corners are smaller, which leaves their moves longer
_PATIENT = 4  # passes that go half of the way: a corner that was lowered is never raised again
_SAME_SPEED = 1e-9


@dataclass(frozen=True, slots=True)
class Chain:
    """Per row of Moves.

    `start_speed`, `end_speed` [m/s] at its corners. `saving` [s]: what the corner at its end saves over passing the
    point at that speed; a corner that replaces the ends of its moves has its time here, as a saving below zero.
    `exact_stop`: whether it ends in one. `trim` [m]: how much of it is in corners; of that, `cornering` [s] passes at
    the corners' speed. `corners`: the motion there; `previous`: the row whose corner it begins in, -1 if in none.
    """

    start_speed: Floats
    end_speed: Floats
    saving: Floats
    exact_stop: NDArray[np.bool_]
    trim: Floats
    cornering: Floats
    corners: CornerPieces
    previous: NDArray[np.intp]


class Caps(NamedTuple):
    """[m/s] (m,) the most with which rows of Moves may begin and end: what a motion model can do of them."""

    start: Floats
    end: Floats


def chain(plan: Plan, wanted: Demand, caps: Caps | None = None) -> Chain:
    """Joins the rows of each mechanism, at no more than the speeds `caps` where given."""
    moves = plan.moves
    count = len(moves)
    exact = moves.blend_code == BlendCode.EXACT
    moving = wanted.length > 1e-9
    start, end, saving, trim, cornering = np.zeros((5, count))
    result = Chain(start, end, saving, exact & moving, trim, cornering, CornerPieces.none(count),
                   np.full(count, -1))  # fmt: skip
    era = _eras(plan, exact & ~moving)
    for mechanism in distinct(moves.mechanism):
        rows = np.nonzero((moves.mechanism == mechanism) & moving & ~wanted.unknown)[0]
        if len(rows) > 1:
            _join(plan, wanted, rows, era, caps, result)
    return result


def _eras(plan: Plan, stopped: NDArray[np.bool_]) -> NDArray[np.intp]:
    """Number of halts before each row: waits that take time, and exact stops at moves that go nowhere."""
    is_move = plan.kind == StepKind.MOVE
    halts = np.zeros(len(plan), dtype=np.intp)
    waits = plan.kind == StepKind.WAIT
    halts[waits] = plan.durations[plan.row[waits]] > 0
    first_rows = plan.row[is_move]
    halted_before_step = np.cumsum(halts)[is_move]
    rows_per_step = np.diff(np.append(first_rows, len(plan.moves)))
    era: NDArray[np.intp] = np.repeat(halted_before_step, rows_per_step) + np.cumsum(stopped)
    return era


def _join(
    plan: Plan, wanted: Demand, rows: NDArray[np.intp], era: NDArray[np.intp], caps: Caps | None, out: Chain
) -> None:
    moves = plan.moves
    before, after = rows[:-1], rows[1:]
    code = moves.blend_code[before]
    linked = (code != BlendCode.EXACT) & (era[before] == era[after])
    linked &= wanted.metric[before] & wanted.metric[after]
    replaced = code == BlendCode.RADIUS
    if not load_law(plan.zone_law).runs_at_once:
        replaced |= code == BlendCode.ZONE
    faded, replaced = linked & ~replaced, linked & replaced
    shift = _shifts(plan, wanted, rows, faded & (code == BlendCode.ZONE))
    speeds = Speeds(*(np.where(linked, wanted.speed[own], 0.0) for own in (before, after)))
    if caps is not None:
        speeds = Speeds(
            np.minimum(speeds.entry, caps.end[before]), np.minimum(speeds.exit, caps.start[after])
        )
    # Speeds that no corner lets the moves reach would only make the first corners larger than any that there will be.
    coupled = np.abs(speeds.entry - speeds.exit) <= _SAME_SPEED * speeds.entry
    speeds = _reachable(speeds, wanted.length[rows], wanted, rows, coupled)
    for turn in range(_MOST_PASSES):
        speeds, pieces = fade(plan, wanted, before, after, faded, shift, speeds)
        speeds, shapes = replace_ends(plan, wanted, before, after, replaced, speeds)
        left = wanted.length[rows] - _trims(pieces, rows) - _trims(shapes, rows)
        left = np.maximum(left, 0.0)
        if not turn:  # speeds that the moves between have no room to change change at no corner either
            same = np.abs(speeds.entry - speeds.exit) <= _SAME_SPEED * speeds.entry
            least = _reachable(speeds, left, wanted, rows, linked).entry
            short = np.minimum(wanted.length[before], wanted.length[after])
            coupled = same & (
                least**2 > short * np.minimum(wanted.deceleration[before], wanted.acceleration[after])
            )
        wished, speeds = speeds, _reachable(speeds, left, wanted, rows, coupled)
        if speeds is wished:
            break
        if turn < _PATIENT:  # slower corners are smaller and leave more room: half of the way there, by ratio
            speeds = Speeds(*(np.sqrt(a * b) for a, b in zip(wished, speeds, strict=True)))
            continue
        # Slower corners are smaller: what fits once fits again.
        shift = np.minimum(shift, pieces.shift[before])
        if turn > _PATIENT:  # what is lowered again and again is left as fast as it is entered, which ends it
            coupled |= (speeds.entry < wished.entry) | (speeds.exit < wished.exit)
    out.end_speed[before], out.start_speed[after] = speeds
    out.saving[before] = pieces.shift[before] - shapes.span[before]
    for own, speed, part in ((before, speeds.entry, pieces.before), (after, speeds.exit, pieces.after)):
        out.cornering[own] += np.divide(part[before], speed, out=np.zeros(len(before)), where=speed > 0)
    out.trim[rows] = _trims(pieces, rows) + _trims(shapes, rows)
    out.corners.add(pieces)
    out.corners.add(shapes)
    out.previous[after] = np.where(out.corners.span[before] > 0, before, -1)


def _trims(pieces: CornerPieces, rows: NDArray[np.intp]) -> Floats:
    """[m] of each row (n,) in the corners at its end and, with the row before it, at its begin."""
    trims: Floats = pieces.before[rows] + np.append(0.0, pieces.after[rows[:-1]])
    return trims


def _shifts(plan: Plan, wanted: Demand, rows: NDArray[np.intp], zoned: NDArray[np.bool_]) -> Floats:
    """(n - 1,) [s] by which the corners between `rows` (n,) are passed earlier, those `zoned` by position levels."""
    before, after = rows[:-1], rows[1:]
    if not zoned.any():
        return np.zeros(len(before))
    half = 0.5 * np.minimum(wanted.length[before], wanted.length[after])
    zone = np.where(zoned, np.minimum(plan.moves.blend[before], half), 0.0)
    pace, way = wanted.speed[rows], wanted.length[rows]
    # Where a fast move meets a slow one, the last z of the fast one is travelled at its own speed.
    overlap = np.divide(zone, pace[:-1], out=np.zeros_like(zone), where=zoned)
    cruise = np.divide(way, pace, out=np.full_like(way, np.inf), where=pace > 0)
    late = delays(cruise, np.insert(overlap, 0, 0.0), np.append(overlap, 0.0), PositionLevels().alone)
    shift: Floats = np.where(zoned, overlap / 2 - late[:-1], 0.0)
    return shift


def _reachable(
    speeds: Speeds, length: Floats, wanted: Demand, rows: NDArray[np.intp], coupled: NDArray[np.bool_]
) -> Speeds:
    """Corner speeds (n - 1,) lowered until every row can brake and accelerate between its corners; else the same ones.

    `length` (n,) [m] of the rows between their corners. Where `coupled` a corner is left as fast as it is entered.
    """
    up, down = wanted.acceleration[rows], wanted.deceleration[rows]
    start, end = np.append(0.0, speeds.exit), np.append(speeds.entry, 0.0)
    gain = np.where(end > start, 2 * up * length, 2 * down * length)
    if not np.any(np.abs(end**2 - start**2) > gain * (1 + 1e-9)):
        return speeds
    entry, leave = (speeds.entry**2).tolist(), (speeds.exit**2).tolist()
    brake, push = (2 * down * length).tolist(), (2 * up * length).tolist()
    same = coupled.tolist()
    following = 0.0
    for i in range(len(entry) - 1, -1, -1):
        leave[i] = min(leave[i], following + brake[i + 1])
        if same[i]:
            entry[i] = leave[i] = min(entry[i], leave[i])
        following = entry[i]
    previous = 0.0
    for i in range(len(entry)):
        entry[i] = min(entry[i], previous + push[i])
        if same[i]:
            entry[i] = leave[i] = min(entry[i], leave[i])
        previous = leave[i]
    return Speeds(np.sqrt(np.array(entry)), np.sqrt(np.array(leave)))
