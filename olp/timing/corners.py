"""The pieces of motion at corners that are not stopped at: how one row fades out while the next one fades in.

Through a corner both rows move the tool at once and their displacements add. Of each corner two functions of time say
all: how far the row before still gets (`fall`) and how far the row after has got (`rise`). The one begins with the
speed at which its row enters the corner and ends at rest, the other one begins at rest and ends with the speed at
which its row goes on: so position and speed have no jump, whatever the rows are (lines, arcs, joint moves).

Two kinds. *Faded*, as measured on position levels and on moves without any (olp/timing/blending/yaskawa.py,
acceleration_filter.py): speed falls and rises evenly, the middle of the rise `shift` before that of the fall, which
is what the corner saves. The ramps last as long as the acceleration needs; where the moves leave no room for that,
first the shift shrinks and then the speed. *Replaced*, all other laws: the law's own shape.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from olp.ir.program import Path
from olp.robots.times_to_speed import turn_limits
from olp.runtime.paths import point_on_arc, point_on_parabola
from olp.runtime.plan import PATHS, BlendCode, Plan, distinct
from olp.timing.blending.law import Corners, load_law
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
    """[m/s] (n,) at which corners are entered and left; along the row before, and along the row after."""

    entry: Floats
    exit: Floats


class _CornerRoom(NamedTuple):
    """What there is for corners (n,): room [m] on both rows, their limits [m/s^2], `change` [s per m/s] in between.

    `apart`: the middles of their ramps do not coincide; `mixed`: limits of axes and of the tool.
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
        """[s] How long speeds change: ramps that do not coincide have nothing to cancel against."""
        limit = np.minimum(self.fall_limit, self.rise_limit)
        together = np.abs(entry - leave) / limit + np.minimum(entry, leave) * self.change
        alone = np.maximum(entry / self.fall_limit, leave / self.rise_limit)
        # Each ramp keeps the limit of its own row where these are of two kinds.
        return np.where(self.mixed, alone, np.where(self.apart, np.maximum(alone, together), together))

    def for_shift(self, entry: Floats, leave: Floats) -> Floats:
        """[s] How much shift there is room for."""
        last = self.ramp(entry, leave)
        room = np.minimum(self.before / entry, self.after / leave) - last / 2
        return np.asarray(np.minimum(room, self.before / (2 * entry)))


def _raised(both: Floats, most: Floats, fits: Callable[[Rows], Callable[[Floats], Mask]]) -> Floats:
    """How far one of both rows may be above `both`, at most `most` [m/s] (n,), by halving.

    `fits` of rows says of their speeds whether they do: no higher speed does where one does not.
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
    """The corners between rows `before` and `after` (n,) where `faded`: speeds that they allow, and their pieces.

    `shift` (n,) [s] is asked for; `speeds` are the most at which they are entered and left.
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
    """The corners of other laws where `replaced` (n,): speeds that they allow, at most `speeds`, and their pieces.

    Where the law leaves a stop they are 0.
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
    """(n,) [s per m/s] that turning the speed of one row into that of the next takes at the acceleration of both."""
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
    """(n, k) [1/m] shares of the rated speeds by which the axes turn per length of the row."""
    axes = plan.positions.axes[:, : len(speeds)]
    with np.errstate(divide="ignore", invalid="ignore"):
        rates: Floats = (axes[plan.moves.target[rows]] - axes[plan.moves.start[rows]]) / (
            speeds * wanted.length[rows][:, None]
        )
    return rates


def _turn_rate(plan: Plan, wanted: Demand, rows: Rows) -> Floats:
    """(n, 3) [rad/m] by which the tool turns about the axes of the base, per length of the row."""
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
    """(n,) [rad] between the end of one row and the begin of the next."""
    first, second = _direction(plan, before, at_end=True), _direction(plan, after, at_end=False)
    # Of unit vectors; exact for small turns too, where arccos loses half of the digits.
    turn: Floats = np.nan_to_num(2.0 * np.arctan2(_chord(first, second), _chord(first, -second)))
    return turn


def _chord(first: Floats, second: Floats) -> Floats:
    """(n,) between unit vectors."""
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
