"""How neighbouring moves join: where the arm stops, how fast it passes a corner, what the overlap saves.

Corners with a position level follow olp/timing/blending/yaskawa.py: z before the point the next move begins, its
speed ramping up over the next z/V while the first still runs at V. The corner saves z/(2V), with z = the level's
zone, but at most half of the shorter neighbour; dense points save less, and so do points too near for the arm to
change its speed between them. Corner radii, and the zones of other laws, replace the ends of both moves. Either way
a row consists of a body between its corners, and of pieces in its corners, where one row fades out while the next
one fades in.

Through a corner both rows move the tool at once and their displacements add. Two functions of time describe each
corner: the remaining travel of the row before (`fall`) and the travel so far of the row after (`rise`). `fall`
begins at the speed at which its row enters the corner and ends at rest; `rise` begins at rest and ends at the speed
at which its row continues: so position and speed have no jump, whatever the rows are (lines, arcs, joint moves).

There are two kinds. *Faded*, as measured on position levels and on moves without any
(olp/timing/blending/yaskawa.py, acceleration_filter.py): speed falls and rises evenly, the middle of the rise
`shift` before that of the fall, which is what the corner saves. The ramps last as long as the acceleration needs;
where the moves leave no room for that, first the shift shrinks and then the speed. *Replaced*, all other laws: the
law's own shape.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from olp.ir.program import Path
from olp.robots.times_to_speed import turn_limits
from olp.runtime.paths import point_on_arc, point_on_parabola
from olp.runtime.plan import PATHS, BlendCode, Plan, StepKind, distinct
from olp.timing.blending.law import Corners, load_law
from olp.timing.blending.yaskawa import PositionLevels, delays
from olp.timing.demand import Demand
from olp.timing.result import CornerPieces, LawCorners

Floats = NDArray[np.float64]
Mask = NDArray[np.bool_]
Rows = NDArray[np.intp]
_RADIUS_LAW = "radius"
_JOINT = PATHS.index(Path.JOINT)
_CURVES = ((PATHS.index(Path.CIRCULAR), point_on_arc), (PATHS.index(Path.SPLINE), point_on_parabola))
_STEP = 1e-4  # of a curve: its chord there is its direction to 1e-4 of what the curve turns
_BITS = 30  # of a share that is found by halving
_NEAR_REST = 1e-6  # [m/s] slower is standing
_ROUNDING = 1e-12  # [s]


class Speeds(NamedTuple):
    """Speeds [m/s] (n,) at the corners: `entry` along the row before, `exit` along the row after."""

    entry: Floats
    exit: Floats


class _CornerRoom(NamedTuple):
    """Room for the corners (n,): length [m] on both rows, their acceleration limits [m/s²], `change` [s per m/s]
    between them.

    `apart`: the middles of their ramps do not coincide; `mixed`: one limit is of the axes, the other of the tool.
    """

    before: Floats
    after: Floats
    fall_limit: Floats
    rise_limit: Floats
    change: Floats
    apart: Mask
    mixed: Mask

    def take(self, rows: Rows) -> _CornerRoom:
        return _CornerRoom._make(column[rows] for column in self)

    def ramp(self, entry: Floats, leave: Floats) -> Floats:
        """Duration [s] of the speed change; ramps whose middles do not coincide cannot cancel each other."""
        limit = np.minimum(self.fall_limit, self.rise_limit)
        together = np.abs(entry - leave) / limit + np.minimum(entry, leave) * self.change
        alone = np.maximum(entry / self.fall_limit, leave / self.rise_limit)
        # Each ramp keeps the limit of its own row where these are of two kinds.
        return np.where(self.mixed, alone, np.where(self.apart, np.maximum(alone, together), together))

    def for_shift(self, entry: Floats, leave: Floats) -> Floats:
        """The largest shift [s] that the moves have room for."""
        last = self.ramp(entry, leave)
        room = np.minimum(self.before / entry, self.after / leave) - last / 2
        return np.asarray(np.minimum(room, self.before / (2 * entry)))


def _raised(both: Floats, most: Floats, fits: Callable[[Rows], Callable[[Floats], Mask]]) -> Floats:
    """The largest speed from `both` to `most` [m/s] (n,) for one of the two rows, found by bisection.

    `fits(rows)` returns a test of speeds for these rows; where one speed fails every higher one does.
    """
    found = np.maximum(both, most)
    at = np.flatnonzero(most > both)
    at = at[~fits(at)(most[at])]
    if not len(at):
        return found
    low, way, fit = both[at], most[at] - both[at], fits(at)
    share = np.zeros(len(at))
    for bit in range(1, _BITS + 1):
        more = share + 0.5**bit
        share = np.where(fit(low + more * way), more, share)
    found[at] = np.where(share > 1 - 2 * 0.5**_BITS, most[at], low + share * way)
    return found


def fade(
    plan: Plan, wanted: Demand, before: Rows, after: Rows, faded: Mask, shift: Floats, speeds: Speeds
) -> tuple[Speeds, CornerPieces]:
    """Faded corners between rows `before` and `after` (n,), where `faded`: their feasible speeds and their pieces.

    `shift` (n,) [s] is the requested one; `speeds` are upper bounds.
    """
    pieces = CornerPieces.none(len(plan.moves))
    at = np.flatnonzero(faded & (speeds.entry > 0) & (speeds.exit > 0))
    if not len(at):
        return speeds, pieces
    one, two = before[at], after[at]
    joint = plan.moves.path == _JOINT
    asked = shift[at]
    room = _CornerRoom(
        wanted.length[one] / 2,
        wanted.length[two] / 2,
        wanted.deceleration[one],
        wanted.acceleration[two],
        _change_per_speed(plan, wanted, one, two),
        asked > 0,
        joint[one] != joint[two],
    )
    with np.errstate(divide="ignore"):
        most = np.sqrt(2 * np.minimum(room.before, room.after) / room.change)
    both = np.minimum(np.minimum(speeds.entry[at], speeds.exit[at]), most)
    # What is left of the shift where both rows are as slow as the slower one; no more of it is given up for speed.
    kept = np.clip(np.minimum(asked, room.for_shift(both, both)), 0.0, None) - _ROUNDING

    def left_at(rows: Rows) -> Callable[[Floats], Mask]:
        here, slow, least = room.take(rows), both[rows], kept[rows]
        return lambda speed: here.for_shift(slow, speed) >= least

    def entered_at(rows: Rows) -> Callable[[Floats], Mask]:
        here, fast, least = room.take(rows), leave[rows], kept[rows]
        return lambda speed: here.for_shift(speed, fast) >= least

    leave = _raised(both, speeds.exit[at], left_at)
    entry = _raised(both, speeds.entry[at], entered_at)
    moved = np.clip(np.minimum(asked, room.for_shift(entry, leave)), 0.0, None)
    fall = room._replace(apart=room.apart & (moved > 0)).ramp(entry, leave)
    rise = np.maximum(fall, 2 * moved)
    lead = np.maximum(fall / 2 - moved, rise / 2)  # from the begin to the middle of the rise
    trail = np.maximum(rise / 2, moved + fall / 2)
    for values, told in (
        (pieces.span, lead + trail), (pieces.lead, lead), (pieces.before, entry * (lead + moved)),
        (pieces.after, leave * trail), (pieces.entry, entry), (pieces.exit, leave), (pieces.fall, fall),
        (pieces.rise, rise), (pieces.shift, moved),
    ):  # fmt: skip
        values[one] = told
    lowered = Speeds(speeds.entry.copy(), speeds.exit.copy())
    lowered.entry[at], lowered.exit[at] = entry, leave
    return lowered, pieces


def replace_ends(
    plan: Plan, wanted: Demand, before: Rows, after: Rows, replaced: Mask, speeds: Speeds
) -> tuple[Speeds, CornerPieces]:
    """Corners of other laws where `replaced` (n,): their feasible speeds, at most `speeds`, and their pieces.

    The speeds are 0 where the law leaves a stop.
    """
    pieces = CornerPieces.none(len(plan.moves))
    lowered = Speeds(speeds.entry.copy(), speeds.exit.copy())
    radius = plan.moves.blend_code[before] == BlendCode.RADIUS
    for name, at in ((_RADIUS_LAW, replaced & radius), (plan.zone_law, replaced & ~radius)):
        rows = np.flatnonzero(at & (speeds.entry > 0) & (speeds.exit > 0))
        if not len(rows):
            continue
        one, two = before[rows], after[rows]
        corners = Corners.of(
            wanted.length[one],
            wanted.length[two],
            speeds.entry[rows],
            speeds.exit[rows],
            _turns(plan, one, two),
            plan.moves.blend[one],
            wanted.deceleration[one],
            wanted.acceleration[two],
        )
        law = load_law(name)
        passage = law.passage(corners)
        moving = np.minimum(passage.speed_in, passage.speed_out) > _NEAR_REST
        lowered.entry[rows] = np.where(moving, passage.speed_in, 0.0)
        lowered.exit[rows] = np.where(moving, passage.speed_out, 0.0)
        for values, told in (
            (pieces.span, passage.duration), (pieces.lead, passage.duration), (pieces.before, passage.trim_before),
            (pieces.after, passage.trim_after), (pieces.entry, passage.speed_in), (pieces.exit, passage.speed_out),
        ):  # fmt: skip
            values[one] = np.where(moving, told, 0.0)
        shaped = np.flatnonzero(moving)
        pieces.shapes.append(LawCorners(law, corners.take(shaped), one[shaped]))
    return lowered, pieces


def _change_per_speed(plan: Plan, wanted: Demand, before: Rows, after: Rows) -> Floats:
    """Time per speed (n,) [s per m/s] to turn the velocity of one row into that of the next at the acceleration of
    both.
    """
    lowest = np.minimum(wanted.deceleration[before], wanted.acceleration[after])
    joint = plan.moves.path == _JOINT
    change = 1 / lowest
    lines = np.flatnonzero(~joint[before] & ~joint[after])
    if len(lines):
        one, two = before[lines], after[lines]
        steer = _chord(_direction(plan, one, at_end=True), _direction(plan, two, at_end=False))
        turned = np.linalg.norm(_turn_rate(plan, wanted, two) - _turn_rate(plan, wanted, one), axis=1)
        push = turn_limits(plan.robot)[1]
        change[lines] = np.maximum(
            np.nan_to_num(steer, nan=2.0) / lowest[lines], np.nan_to_num(turned) / push
        )
    both = joint[before] & joint[after]
    for mechanism in distinct(plan.moves.mechanism[before[both]]):
        robot = plan.robots[mechanism]
        at = np.flatnonzero(both & (plan.moves.mechanism[before] == mechanism))
        if robot is None:
            continue
        one, two = before[at], after[at]
        first, second = (_axis_rates(plan, wanted, rows, robot.speeds) for rows in (one, two))
        limit = np.maximum(
            np.abs(first).max(axis=1) * wanted.deceleration[one],
            np.abs(second).max(axis=1) * wanted.acceleration[two],
        )
        with np.errstate(divide="ignore", invalid="ignore"):
            found = np.abs(second - first).max(axis=1) / limit
        change[at] = np.where(np.isfinite(found), found, change[at])
    return np.where(change > 1e-9, change, 0.0)


def _axis_rates(plan: Plan, wanted: Demand, rows: Rows, speeds: Floats) -> Floats:
    """Axis motion per length of the row, as shares of the rated speeds (n, k) [s/m]."""
    axes = plan.positions.axes[:, : len(speeds)]
    with np.errstate(divide="ignore", invalid="ignore"):
        rates: Floats = (axes[plan.moves.target[rows]] - axes[plan.moves.start[rows]]) / (
            speeds * wanted.length[rows][:, None]
        )
    return rates


def _turn_rate(plan: Plan, wanted: Demand, rows: Rows) -> Floats:
    """Rotation of the tool about the axes of the base per length of the row (n, 3) [rad/m]."""
    turned = plan.positions.quaternion
    start, target = turned[plan.moves.start[rows]], turned[plan.moves.target[rows]]
    w, v, x, u = start[:, :1], start[:, 1:], target[:, :1], target[:, 1:]
    vector = w * u - x * v - np.cross(u, v)  # of target times the inverse of start
    sine = np.linalg.norm(vector, axis=1, keepdims=True)
    cosine = x * w + np.sum(u * v, axis=1, keepdims=True)
    angle = 2.0 * np.arctan2(sine, np.abs(cosine)) * np.where(cosine < 0, -1.0, 1.0)
    with np.errstate(divide="ignore", invalid="ignore"):
        rate: Floats = np.where(sine > 0, vector / sine, 0.0) * angle / wanted.length[rows][:, None]
    return rate


def _turns(plan: Plan, before: Rows, after: Rows) -> Floats:
    """Angle between the end direction of one row and the start direction of the next (n,) [rad]."""
    first, second = _direction(plan, before, at_end=True), _direction(plan, after, at_end=False)
    # Of unit vectors; exact for small turns too, where arccos loses half of the digits.
    turn: Floats = np.nan_to_num(2.0 * np.arctan2(_chord(first, second), _chord(first, -second)))
    return turn


def _chord(first: Floats, second: Floats) -> Floats:
    """Distance between unit vectors (n,)."""
    chord: Floats = np.linalg.norm(first - second, axis=1)
    return chord


def _direction(plan: Plan, rows: Rows, at_end: bool) -> Floats:
    """(n, 3) unit vectors along the path of the tool, at the row's start or end."""
    moves, point = plan.moves, plan.positions.position
    start, target = point[moves.start[rows]], point[moves.target[rows]]
    way = target - start
    for code, shape in _CURVES:
        at = np.flatnonzero((moves.path[rows] == code) & (moves.via[rows] >= 0))
        if len(at):
            curve = start[at], target[at], point[moves.via[rows[at]]], moves.before[rows[at]]
            near = shape(*curve, np.full(len(at), 1.0 - _STEP if at_end else _STEP))
            way[at] = target[at] - near if at_end else near - start[at]
    with np.errstate(divide="ignore", invalid="ignore"):
        unit: Floats = way / np.linalg.norm(way, axis=1, keepdims=True)
    return unit


_MOST_PASSES = 20  # over a chain: slower corners are smaller, which leaves their moves longer
_PATIENT = 4  # passes that go half of the way: a corner that was lowered is never raised again
_SAME_SPEED = 1e-9


@dataclass(frozen=True, slots=True)
class Chain:
    """How each row of Moves joins its neighbours.

    `start_speed`, `end_speed` [m/s] at its corners. `saving` [s]: what the corner at its end saves over passing the
    point at that speed; a corner that replaces the ends of its moves has its time here, as a negative saving.
    `exact_stop`: whether the row ends in one. `trim` [m]: the part of the row in corners; of that, `cornering` [s]
    passes at the corners' speed. `corners`: the motion in the corners; `previous`: the row whose corner this row
    begins in, -1 if none.
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
    """Highest speeds [m/s] (m,) at which rows of Moves may begin and end, as the motion model can do."""

    start: Floats
    end: Floats


def chain(plan: Plan, wanted: Demand, caps: Caps | None = None) -> Chain:
    """Join the rows of each mechanism, at no more than the speeds `caps` if given."""
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
    """Number of halts before each row: waits that take time, and exact stops at moves without motion."""
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
    """Length [m] of each row (n,) inside the corners at its start and its end."""
    trims: Floats = pieces.before[rows] + np.append(0.0, pieces.after[rows[:-1]])
    return trims


def _shifts(plan: Plan, wanted: Demand, rows: NDArray[np.intp], zoned: NDArray[np.bool_]) -> Floats:
    """Time (n - 1,) [s] by which the corners between `rows` (n,) are passed earlier, where `zoned` by position
    levels.
    """
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
    """Corner speeds (n - 1,), lowered until every row can accelerate and brake between its corners; `speeds` itself
    if nothing changes.

    `length` (n,) [m] of the rows between their corners. Where `coupled`, the speed at the corner's exit equals that
    at its entry.
    """
    up, down = wanted.acceleration[rows], wanted.deceleration[rows]
    start, end = np.append(0.0, speeds.exit), np.append(speeds.entry, 0.0)
    gain = np.where(end > start, 2 * up * length, 2 * down * length)
    if not np.any(np.abs(end**2 - start**2) > gain * (1 + 1e-9)):
        return speeds
    entry, leave = speeds.entry**2, speeds.exit**2
    entry[coupled] = leave[coupled] = np.where(leave < entry, leave, entry)[coupled]
    brake, push = 2 * down[1:] * length[1:], 2 * up[:-1] * length[:-1]
    _lower(leave[::-1], entry[::-1], brake[::-1], coupled[::-1])
    _lower(entry, leave, push, coupled)
    return Speeds(np.sqrt(entry), np.sqrt(leave))


def _lower(reached: Floats, left: Floats, gain: Floats, coupled: NDArray[np.bool_]) -> None:
    """Lowers the squares of speeds, in place, until each one is reached from the corner before it.

    `reached` (n - 1,) and `left` are those on the side of a corner that is met first and on its other side, `gain` what
    they may grow by on the way there; the first way begins at rest. Only corners that are too fast, and those behind
    them, are looked at one by one.
    """
    too_fast = np.nonzero(reached > np.append(0.0, left[:-1]) + gain)[0]
    if not len(too_fast):
        return
    done = -1
    grows, both = gain.tolist(), coupled.tolist()
    for first in too_fast.tolist():
        if first < done:
            continue  # what was lowered before it went on as far as here
        at, before = first, float(left[first - 1]) if first else 0.0
        while at < len(grows) and (most := before + grows[at]) < reached[at]:
            reached[at] = most
            if both[at]:
                left[at] = most
            before = float(left[at])
            at += 1
        done = at
