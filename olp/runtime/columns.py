"""From recorded rows to the plan's columns: all positions resolved batch by batch, all paths measured at once."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Final, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from olp.ir.points import PointState
from olp.ir.program import Path
from olp.robots.coordinate_systems import Cell, Floats, quaternions
from olp.robots.geometry import compose, quaternion_from_rotation, rotation_from_quaternion
from olp.runtime.arm_branch import keep_branches, says_of
from olp.runtime.paths import circle, cross, shape_paths, swept_angle, turn_between
from olp.runtime.plan import PATHS, Moves, Positions

# --- Whole arcs ---
# Arcs that one statement describes: from where the arm stands, through a via point, to a target.
#
# The plan tells an arc by a third point beyond its target, as jobs do that chain circular moves. Here that
# point is made: on the same circle, as far beyond the target as the way back to the start leaves.


def beyond_targets(
    positions: Positions, moves: Moves, extras: Mapping[int, Extra]
) -> tuple[Positions, Moves, dict[int, int]]:
    """Positions with the added points, moves whose target an angle replaces, and row -> added point.

    `extras`: rows with a via point. Rows on no circle (three points on a line) get none: they run straight.
    """
    added: list[Floats] = []
    turns: list[Floats] = []
    axes: list[Floats] = []
    third: dict[int, int] = {}
    start, target = moves.start.copy(), moves.target.copy()
    count = len(positions)

    def add(point: Floats, like: int) -> int:
        added.append(point)
        turns.append(positions.quaternion[like])
        axes.append(np.full(positions.axes.shape[1], np.nan))
        return count + len(added) - 1

    def point(index: int) -> Floats:
        return positions.position[index][None] if index < count else added[index - count][None]

    for row, extra in extras.items():
        a, b = point(start[row]), point(extra.via)  # after an arc with an angle the start is an added point
        end = int(target[row])
        c = positions.position[end][None]
        centre, radius, axis = circle(a, b, c)
        if not np.isfinite(radius[0]):
            continue
        swept = float(swept_angle(a - centre, c - centre, axis)[0])
        if not np.isnan(extra.arc):
            swept = extra.arc
            target[row] = add(_turned(a, centre, axis, swept), end)
            following = np.flatnonzero((moves.mechanism == moves.mechanism[row]) & (moves.start == end))
            following = following[following > row][:1]
            start[following] = target[row]
        third[row] = add(_turned(a, centre, axis, swept + (2 * np.pi - swept % (2 * np.pi)) / 2), end)
    if not added:
        return positions, moves, third
    grown = Positions(
        np.concatenate([positions.position, np.array(added)]),
        np.concatenate([positions.quaternion, np.array(turns)]),
        np.concatenate([positions.axes, np.array(axes)]),
    )
    return grown, replace(moves, start=start, target=target), third


def _turned(point: Floats, centre: Floats, axis: Floats, angle: float) -> Floats:
    """(3,) [m]: a point (1, 3) turned about the circle's axis."""
    spoke = point - centre
    turned = spoke * np.cos(angle) + cross(axis, spoke) * np.sin(angle)
    result: Floats = (centre + turned)[0]
    return result


# --- Blend starts ---
# Where a blend begins that is programmed as a distance, a speed, an angle or a share: as a distance before the target.
#
# After KUKA mxAutomation and KSS manuals: APO structure (CPTP, CDIS, CORI, CVEL). Not measured.


def from_distance(cdis: ArrayLike) -> Floats:
    """C_DIS: $APO.CDIS [m] from the target point."""
    return np.asarray(cdis, dtype=np.float64)


def from_speed(cvel: ArrayLike, speed: ArrayLike, deceleration: ArrayLike) -> Floats:
    """C_VEL: [m] left when braking from `speed` [m/s] at `deceleration` [m/s²] reaches the share $APO.CVEL (0 to 1)."""
    result: Floats = (np.asarray(cvel) * np.asarray(speed)) ** 2 / (2 * np.asarray(deceleration))
    return result


def from_angle(cori: ArrayLike, angle: ArrayLike, length: ArrayLike) -> Floats:
    """C_ORI: [m] left of `length` [m] when $APO.CORI [rad] of the whole reorientation `angle` [rad] is left."""
    turned = np.asarray(angle, dtype=np.float64)
    share = np.divide(cori, turned, out=np.ones(np.broadcast(cori, turned).shape), where=turned > 0)
    result: Floats = np.minimum(share, 1.0) * np.asarray(length)
    return result


def from_share(cptp: ArrayLike, length: ArrayLike) -> Floats:
    """C_PTP: share $APO.CPTP (0 to 1) of the greatest distance, which is half of the move of `length` [m or rad]."""
    result: Floats = 0.5 * np.asarray(cptp) * np.asarray(length)
    return result


# --- Columns ---

_JOINT: Final = PATHS.index(Path.JOINT)
NOWHERE = -1  # the position before the first move

# start, target, mechanism, path, unit, speed, blend code, blend, acceleration, deceleration, end of arc
MoveRow = tuple[int, int, int, int, int, float, int, float, float, float, bool]


class Extra(NamedTuple):
    """What moves of some languages say besides, as it stands in the first row of a move.

    `rate` [m/s²], of a joint move [rad/s²]. `turn` [rad/s]: bound of the tool's turning. `via`: pool index of the point
    that an arc passes on its way (-1: none). `arc` [rad]: what it turns about its axis, whatever its target (nan).
    `blend`: the kind of blend whose number becomes metres once the path is known.
    """

    rate: float = math.nan
    turn: float = math.nan
    via: int = -1
    arc: float = math.nan
    blend: str = ""


NO_EXTRA: Final = Extra()


@dataclass(slots=True)
class Batch:
    """Positions of one mechanism under one state, to be resolved together."""

    mechanism: int
    state: PointState
    rows: list[int] = field(default_factory=list)  # index in the pool
    values: list[Sequence[float]] = field(default_factory=list)


def columns(
    cell: Cell,
    batches: Iterable[Batch],
    count: int,
    rows: Sequence[MoveRow],
    extras: Mapping[int, Extra] | None = None,
) -> tuple[Positions, Moves]:
    """The `count` positions and all moves of a plan."""
    positions, tools, says = _resolve(cell, batches, count)
    moves, end_of_arc = _moves(rows)
    if not len(moves):
        return positions, moves
    positions, moves, tools = keep_branches(cell, positions, tools, says, moves)
    positions, moves = _with_target_tools(cell, positions, tools, moves)
    extras = extras or {}
    with_via = {row: extra for row, extra in extras.items() if extra.via >= 0}
    positions, moves, whole_arcs = beyond_targets(positions, moves, with_via)
    via, before, length = shape_paths(moves, positions, end_of_arc, whole_arcs)
    angle = turn_between(positions.quaternion[moves.start], positions.quaternion[moves.target])
    moves = replace(moves, via=via, before=before, length=length, angle=angle)
    return positions, with_extras(moves, extras, units_of(rows))


def _resolve(
    cell: Cell, batches: Iterable[Batch], count: int
) -> tuple[Positions, NDArray[np.int32], NDArray[np.int8]]:
    """All positions, the tool that each was taught with (-1 for what carries none), what it says of the arm (Named)."""
    width = max((len(m.robot.axes) for m in cell.mechanisms if m.robot), default=6)
    position = np.full((count, 3), np.nan)
    quaternion = np.full((count, 4), np.nan)
    axes = np.full((count, max(width, 6)), np.nan)
    tools = np.full(count, -1, dtype=np.int32)
    says = np.zeros(count, dtype=np.int8)
    for batch in batches:
        rows = np.array(batch.rows)
        resolved = cell.resolve(batch.mechanism, batch.state, _rectangle(batch.values))
        position[rows] = resolved.position
        quaternion[rows] = quaternions(resolved)
        known = min(resolved.axes.shape[1], axes.shape[1])  # seven pulses of an unknown arm tell nothing
        axes[rows, :known] = resolved.axes[:, :known]
        if cell.mechanisms[batch.mechanism].is_robot:
            tools[rows] = batch.state.tool
            says[rows] = says_of(cell, batch.mechanism, batch.state, resolved.axes)
    return Positions(position, quaternion, axes), tools, says


def _rectangle(values: list[Sequence[float]]) -> Floats:
    """(n, w) from rows that may differ in width, nan where a row is short."""
    width = max(len(row) for row in values)
    if all(len(row) == width for row in values):
        return np.array(values, dtype=np.float64)
    return np.array([[*row, *[np.nan] * (width - len(row))] for row in values], dtype=np.float64)


def _moves(rows: Sequence[MoveRow]) -> tuple[Moves, NDArray[np.bool_]]:
    """The moves, their paths not yet measured, and which of them end an arc."""
    cells = list(zip(*rows, strict=True)) if rows else [()] * 11
    start, target, mechanism, path, unit, speed, code, blend, acceleration, deceleration, end_of_arc = cells
    starts, targets = np.array(start, dtype=np.int32), np.array(target, dtype=np.int32)
    units, speeds = np.array(unit, dtype=np.int8), np.array(speed, dtype=np.float64)
    count = len(rows)
    moves = Moves(
        # Nobody knows where the arm stood before its first move: it is taken to stand at that move's target.
        start=np.where(starts == NOWHERE, targets, starts).astype(np.int32),
        target=targets,
        via=np.full(count, -1, dtype=np.int32),
        before=np.zeros(count, dtype=bool),
        mechanism=np.array(mechanism, dtype=np.int16),
        path=np.array(path, dtype=np.int8),
        fraction=np.where(units == 0, speeds, np.nan),
        travel=np.where(units == 1, speeds, np.nan),
        turn=np.where(units == 2, speeds, np.nan),
        acceleration=np.array(acceleration, dtype=np.float64),
        deceleration=np.array(deceleration, dtype=np.float64),
        blend_code=np.array(code, dtype=np.int8),
        blend=np.array(blend, dtype=np.float64),
        length=np.zeros(count),
        angle=np.zeros(count),
        axis_speed=np.where(units == 3, speeds, np.nan),
        duration=np.where(units == 4, speeds, np.nan),
        rate=np.full(count, np.nan),
    )
    return moves, np.array(end_of_arc, dtype=bool)


def units_of(rows: Sequence[MoveRow]) -> NDArray[np.int8]:
    """(m,) what the speed of each row is of, see `Recorder.row`."""
    return np.array([row[4] for row in rows], dtype=np.int8)


def with_extras(moves: Moves, extras: Mapping[int, Extra], units: NDArray[np.int8]) -> Moves:
    """Accelerations, bounds of turning, times and blends that need the path's length."""
    timed = units == 4
    if not extras and not timed.any():
        return moves
    rate, turn, blend = moves.rate.copy(), moves.turn.copy(), moves.blend.copy()
    for row, extra in extras.items():
        rate[row] = extra.rate
        if not math.isnan(extra.turn):
            turn[row] = extra.turn if math.isnan(turn[row]) else min(turn[row], extra.turn)
        if extra.blend:
            blend[row] = _metres(extra, float(blend[row]), moves, row)
    with np.errstate(divide="ignore", invalid="ignore"):
        pace = np.where(timed & (moves.path != _JOINT), moves.length / moves.duration, moves.travel)
        turning = np.where(
            timed & (moves.path != _JOINT) & (moves.length <= 0), moves.angle / moves.duration, turn
        )
    return replace(moves, rate=rate, turn=turning, blend=blend, travel=pace)


# KUKA's DEF_ACC_CP: what a share of the speed is braked with where the program says nothing else.
_USUAL_BRAKING = 2.3  # [m/s²]


def _metres(extra: Extra, value: float, moves: Moves, row: int) -> float:
    """[m] before the target at which a blend that is no length begins."""

    length = float(moves.length[row])
    if extra.blend == "share":
        return float(from_share(min(value, 1.0), length))
    if extra.blend == "turn":
        return float(from_angle(value, float(moves.angle[row]), length))
    braking = _USUAL_BRAKING if math.isnan(extra.rate) else extra.rate
    speed = float(moves.travel[row])
    return 0.0 if math.isnan(speed) else float(from_speed(min(value, 1.0), speed, braking))


def _with_target_tools(
    cell: Cell, positions: Positions, tools: NDArray[np.int32], moves: Moves
) -> tuple[Positions, Moves]:
    """Where a move's target was taught with another tool, its start is seen with that tool too.

    The controller moves the tool that the target names; the arm stands where it stood, but the point that
    travels is another one.
    """
    changed = np.nonzero(tools[moves.start] != tools[moves.target])[0]
    if not len(changed):
        return positions, moves
    start = moves.start.copy()
    old, new = tools[start[changed]], tools[moves.target[changed]]
    extra: list[Positions] = []
    for first, second in sorted(set(zip(old.tolist(), new.tolist(), strict=True))):
        rows = changed[(old == first) & (new == second)]
        swap = cell.tool_pose(first).inverse() @ cell.tool_pose(second)
        seen = start[rows]
        position, rotation = compose(
            positions.position[seen],
            rotation_from_quaternion(positions.quaternion[seen]),
            swap.position,
            swap.rotation,
        )
        start[rows] = len(positions) + sum(map(len, extra)) + np.arange(len(rows))
        extra.append(Positions(position, quaternion_from_rotation(rotation), positions.axes[seen]))
    together = (
        np.concatenate([getattr(p, name) for p in (positions, *extra)])
        for name in ("position", "quaternion", "axes")
    )
    return Positions(*together), replace(moves, start=start)
