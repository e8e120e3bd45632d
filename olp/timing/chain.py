"""How neighbouring moves join: where the arm stops, how fast it passes a corner, what the overlap saves.

Corners with a position level follow olp/blending/yaskawa.py: z before the point the next move begins, its speed ramping
up over the next z/V while the first still runs at V. The corner saves z/(2V), with z = the level's zone, but at most
half of the shorter neighbour; dense points save less. Corner radii, and the zones of other laws, replace the ends of
both moves: see olp/timing/corners.py.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from olp.blending.yaskawa import PositionLevels, delays
from olp.plan import BlendCode, Plan, StepKind
from olp.timing.corners import round_corners
from olp.timing.demand import Demand

Floats = NDArray[np.float64]
_OVERLAPPING = "yaskawa"  # the law under which moves run at once; others replace the corner


@dataclass(frozen=True, slots=True)
class Chain:
    """Per row of Moves.

    `start_speed`, `end_speed` [m/s] at its corners. `saving` [s]: what the corner at its end saves. `ramp` [s]: how
    long its speed ramps up while the row before still runs. `exact_stop`: whether it ends in one. `trim` [m]: how much
    of it its corners replace, where their law replaces anything; the time in the corner is a saving below zero then.
    """

    start_speed: Floats
    end_speed: Floats
    saving: Floats
    ramp: Floats
    exact_stop: NDArray[np.bool_]
    trim: Floats


def chain(plan: Plan, wanted: Demand) -> Chain:
    """Joins the rows of each mechanism."""
    moves = plan.moves
    count = len(moves)
    exact = moves.blend_code == BlendCode.EXACT
    moving = wanted.length > 1e-9
    start, end, saving, ramp, trim = np.zeros((5, count))
    result = Chain(start, end, saving, ramp, exact & moving, trim)
    era = _eras(plan, exact & ~moving)
    for mechanism in np.unique(moves.mechanism):
        rows = np.nonzero((moves.mechanism == mechanism) & moving & ~wanted.unknown)[0]
        if len(rows) > 1:
            _join(plan, wanted, rows, era, result)
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


def _join(plan: Plan, wanted: Demand, rows: NDArray[np.intp], era: NDArray[np.intp], out: Chain) -> None:
    moves = plan.moves
    before, after = rows[:-1], rows[1:]
    code = moves.blend_code[before]
    linked = (code != BlendCode.EXACT) & (era[before] == era[after])
    linked &= wanted.metric[before] & wanted.metric[after]
    speed = np.where(linked, np.minimum(wanted.speed[before], wanted.speed[after]), 0.0)
    overlapping = plan.zone_law == _OVERLAPPING
    rounded = linked & ((code == BlendCode.RADIUS) | ((code == BlendCode.ZONE) & (not overlapping)))
    duration = np.zeros(len(before))
    if rounded.any():
        duration = round_corners(plan, wanted, before, after, rounded, speed, out.trim)
    wished = speed
    speed = _reachable(wished, wanted.length[rows] - out.trim[rows], wanted, rows)
    out.end_speed[before] = speed
    out.start_speed[after] = speed
    if rounded.any():  # at a lower speed a corner of the same shape takes longer
        slower = np.divide(wished, speed, out=np.ones_like(speed), where=rounded & (speed > 0))
        out.saving[before] = -duration * slower
    zoned = linked & (code == BlendCode.ZONE) & (speed > 0) & overlapping
    if zoned.any():
        half = 0.5 * np.minimum(wanted.length[before], wanted.length[after])
        zone = np.where(zoned, np.minimum(moves.blend[before], half), 0.0)
        pace, way = wanted.speed[rows], wanted.length[rows]
        # Where a fast move meets a slow one, the last z of the fast one is travelled at its own speed.
        overlap = np.divide(zone, pace[:-1], out=np.zeros_like(zone), where=zoned)
        cruise = np.divide(way, pace, out=np.full_like(way, np.inf), where=pace > 0)
        ramp, handing = np.insert(overlap, 0, 0.0), np.append(overlap, 0.0)
        late = delays(cruise, ramp, handing, PositionLevels().alone)
        out.ramp[after] = overlap
        out.saving[before[zoned]] = (overlap / 2 - late[:-1])[zoned]


def _reachable(speed: Floats, length: Floats, wanted: Demand, rows: NDArray[np.intp]) -> Floats:
    """Corner speeds (n - 1,) lowered until every row can brake and accelerate between its corners."""
    up, down = wanted.acceleration[rows], wanted.deceleration[rows]
    start, end = np.concatenate(([0.0], speed)), np.concatenate((speed, [0.0]))
    gain = np.where(end > start, 2 * up * length, 2 * down * length)
    if not np.any(np.abs(end**2 - start**2) > gain * (1 + 1e-9)):
        return speed
    squares = (speed**2).tolist()
    brake, push = (2 * down * length).tolist(), (2 * up * length).tolist()
    following = 0.0
    for i in range(len(squares) - 1, -1, -1):
        following = squares[i] = min(squares[i], following + brake[i + 1])
    previous = 0.0
    for i in range(len(squares)):
        previous = squares[i] = min(squares[i], previous + push[i])
    lowered: Floats = np.sqrt(np.array(squares))
    return lowered
