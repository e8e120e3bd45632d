"""Corners of laws that replace the ends of two moves by a piece of its own: radii, and the zones of most makers."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from olp.blending import Corners, load_law
from olp.interpreter.paths import point_on_arc, point_on_parabola
from olp.plan import PATHS, BlendCode, Plan
from olp.program import Path
from olp.timing.demand import Demand

Floats = NDArray[np.float64]
Rows = NDArray[np.intp]
_RADIUS_LAW = "radius"
_CURVES = ((PATHS.index(Path.CIRCULAR), point_on_arc), (PATHS.index(Path.SPLINE), point_on_parabola))
_STEP = 1e-4  # of a curve: its chord there is its direction to 1e-4 of what the curve turns
_NEAR_REST = 1e-6  # [m/s] slower is standing


def round_corners(
    plan: Plan,
    wanted: Demand,
    before: Rows,
    after: Rows,
    rounded: NDArray[np.bool_],
    speed: Floats,
    trim: Floats,
) -> Floats:
    """[s] that the corners between rows `before` and `after` (n,) take where `rounded`, 0 elsewhere.

    Lowers `speed` (n,) [m/s] to what the corner is passed at and adds what is cut off each row to `trim` (m,) [m]. A
    corner is entered and left at the same speed, the lower one of its law. Where the law leaves a stop, `speed` is 0.
    """
    duration = np.zeros(len(before))
    radius = plan.moves.blend_code[before] == BlendCode.RADIUS
    for name, at in ((_RADIUS_LAW, rounded & radius), (plan.zone_law, rounded & ~radius)):
        rows = np.flatnonzero(at)
        if not len(rows):
            continue
        one, two = before[rows], after[rows]
        corners = Corners.of(
            wanted.length[one],
            wanted.length[two],
            wanted.speed[one],
            wanted.speed[two],
            _turns(plan, one, two),
            plan.moves.blend[one],
            wanted.deceleration[one],
            wanted.acceleration[two],
        )
        passage = load_law(name).passage(corners)
        pace = np.minimum(np.minimum(passage.speed_in, passage.speed_out), speed[rows])
        moving = pace > _NEAR_REST
        speed[rows] = np.where(moving, pace, 0.0)
        duration[rows] = np.where(moving, passage.duration, 0.0)
        trim[one] += np.where(moving, passage.trim_before, 0.0)
        trim[two] += np.where(moving, passage.trim_after, 0.0)
    return duration


def _turns(plan: Plan, before: Rows, after: Rows) -> Floats:
    """(n,) [rad] between the end of one row and the begin of the next."""
    first, second = _direction(plan, before, at_end=True), _direction(plan, after, at_end=False)
    # Of unit vectors; exact for small turns too, where arccos loses half of the digits.
    chord, sum_ = np.linalg.norm(first - second, axis=1), np.linalg.norm(first + second, axis=1)
    turn: Floats = np.nan_to_num(2.0 * np.arctan2(chord, sum_))
    return turn


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
