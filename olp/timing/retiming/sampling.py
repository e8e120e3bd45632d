"""Joints along the lines, arcs and splines of a plan: many rows sampled in few calls."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from olp.ir.program import Path
from olp.robots.geometry import compose, invert, rotation_from_quaternion, slerp
from olp.robots.kinematics.chain import forward
from olp.robots.kinematics.configuration import configuration_of
from olp.robots.kinematics.inverse import inverse
from olp.robots.model import Robot
from olp.runtime.paths import point_on_arc, point_on_parabola
from olp.runtime.plan import PATHS, Plan

Floats = NDArray[np.float64]
Rows = NDArray[np.intp]

_CURVES = ((PATHS.index(Path.CIRCULAR), point_on_arc), (PATHS.index(Path.SPLINE), point_on_parabola))
_TURN = 2.0 * np.pi
# A row is looked at often enough that the tool travels and turns, and every axis, no further between samples.
_TRAVEL, _ANGLE = 0.02, np.radians(2.5)  # [m], [rad]
_COUNTS = (5, 9, 17, 33, 65, 129)  # samples of a row; rows of one count are solved together
MOST = 400_000  # samples of a plan: beyond, every row is looked at half as often


class Samples(NamedTuple):
    """`rows` (r,) of a plan's Moves, their `place` (r, n) [m from the start] and `joints` (r, n, k) [rad].

    Joints are continuous along each row from the axes of its start; nan where `reached` (r, n) is not, and from
    `jump` (r,) on, the first sample at which the axes would have to jump (n: nowhere) by `leap` (r, k) [rad].
    """

    rows: Rows
    place: Floats
    joints: Floats
    reached: NDArray[np.bool_]
    jump: NDArray[np.intp]
    leap: Floats


def groups(plan: Plan, rows: Rows, joints: Floats) -> dict[int, Rows]:
    """Rows by how often they have to be looked at; 2: the ends are enough. `joints` (r, k): change of the axes."""
    moves = plan.moves
    turned = np.maximum(np.nan_to_num(moves.angle[rows]), np.abs(joints).max(axis=1, initial=0.0))
    wanted = np.maximum(moves.length[rows] / _TRAVEL, turned / _ANGLE)
    short = wanted <= 2.0  # half as often as others: of such rows a CAM program has 100,000
    while True:
        found = {2: rows[short]}
        counts = np.asarray(_COUNTS)[np.minimum(np.searchsorted(_COUNTS, wanted), len(_COUNTS) - 1)]
        for count in _COUNTS:
            found[count] = rows[~short & (counts == count)]
        if sum(count * len(part) for count, part in found.items() if count > 2) <= MOST or wanted.max() <= 5:
            return {count: part for count, part in found.items() if len(part)}
        wanted = wanted / 2.0


def sample(plan: Plan, robot: Robot, rows: Rows, count: int) -> Samples:
    """`count` samples of each row of `rows`, for an arm with a closed-form inverse."""
    fraction = np.linspace(0.0, 1.0, count)
    start = plan.moves.start[rows]
    axes = plan.positions.axes[start][:, : len(robot.axes)]
    position, rotation = _poses(plan, np.repeat(rows, count), np.tile(fraction, len(rows)))
    back = invert(*_tools(plan, robot, start, axes))
    flange = compose(position, rotation, *(np.repeat(part, count, axis=0) for part in back))
    flags = configuration_of(robot, axes)
    flags[:, 3:] = 0
    joints, reached = inverse(robot, *flange, np.repeat(flags, count, axis=0))
    steps = np.linalg.norm(np.diff(position.reshape(len(rows), count, 3), axis=1), axis=2)
    place = np.concatenate((np.zeros((len(rows), 1)), np.cumsum(steps, axis=1)), axis=1)
    # Chords of a curve are a little short; where nothing travels, the place is the angle that is turned.
    length = measure(plan)[rows]
    with np.errstate(divide="ignore", invalid="ignore"):
        scaled = place * (length / place[:, -1])[:, None]
    still = place[:, -1] <= 1e-9
    place = np.where(still[:, None], length[:, None] * fraction, scaled)
    continued, jump, leap = _continued(joints.reshape(len(rows), count, -1), axes)
    return Samples(rows, place, continued, reached.reshape(len(rows), count), jump, leap)


def coarse(samples: Samples) -> NDArray[np.bool_]:
    """(r,): rows along which an axis moves much further between two samples than was wanted, and than elsewhere."""
    steps = np.abs(np.diff(samples.joints, axis=1))
    most, mean = steps.max(axis=1), steps.mean(axis=1)
    uneven = (most > 1.5 * _ANGLE) & (most > 2.0 * mean)
    found: NDArray[np.bool_] = np.any(uneven | np.isnan(most), axis=1)
    return found


def measure(plan: Plan) -> Floats:
    """(m,): the length of each row [m], or where only the tool turns its angle [rad]."""
    moves = plan.moves
    return np.where(moves.length > 1e-9, moves.length, np.nan_to_num(moves.angle))


def _continued(joints: Floats, start: Floats) -> tuple[Floats, NDArray[np.intp], Floats]:
    """Joints (r, n, k) by whole turns continuous from `start` (r, k), where they jump and how far: see Samples."""
    steps = np.diff(joints, axis=1, prepend=start[:, None, :])
    turns = _TURN * np.rint(np.nan_to_num(steps) / _TURN)
    jumps = np.abs(steps - turns).max(axis=2) > 0.5 * np.pi
    jumps[:, 0] |= np.abs(steps[:, 0] - turns[:, 0]).max(axis=1) > 1e-3
    continued: Floats = joints - np.cumsum(turns, axis=1)
    continued[np.logical_or.accumulate(jumps, axis=1)] = np.nan
    jump = np.where(jumps.any(axis=1), np.argmax(jumps, axis=1), joints.shape[1])
    at = np.minimum(jump, joints.shape[1] - 1)
    return continued, jump, np.abs(steps - turns)[np.arange(len(at)), at]


def _poses(plan: Plan, rows: Rows, fraction: Floats) -> tuple[Floats, Floats]:
    """Tool centre points (n, 3) [m], (n, 3, 3) of the rows, each at its fraction of the path."""
    moves, positions = plan.moves, plan.positions
    start, target, via = moves.start[rows], moves.target[rows], moves.via[rows]
    a, b = positions.position[start], positions.position[target]
    point = a + (b - a) * fraction[:, None]
    for code, shape in _CURVES:
        at = np.flatnonzero((moves.path[rows] == code) & (via >= 0))
        if len(at):
            third = positions.position[via[at]]
            point[at] = shape(a[at], b[at], third, moves.before[rows[at]], fraction[at])
    return point, rotation_from_quaternion(
        slerp(positions.quaternion[start], positions.quaternion[target], fraction)
    )


def _tools(plan: Plan, robot: Robot, start: NDArray[np.int32], axes: Floats) -> tuple[Floats, Floats]:
    """The tools (n, 3) [m], (n, 3, 3): whatever the poses of the positions `start` have beyond the flange."""
    flange = invert(*forward(robot, axes))
    rotation = rotation_from_quaternion(plan.positions.quaternion[start])
    return compose(*flange, plan.positions.position[start], rotation)
