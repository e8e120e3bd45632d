"""Position of the robot at each instant (Apostolovic's thesis, section 4.4, with corners).

Every move adds its displacement; at a blended corner two moves run at once and their displacements add, as measured
on the controller. Positions add in space, orientations as successive turns, axes as angles.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from olp.core.diagnostic import OlpError, error
from olp.core.files import utf8
from olp.core.units import deg, mm
from olp.ir.program import Path
from olp.robots.geometry import (
    angles_from_rotation,
    compose,
    quaternion_from_rotation,
    rotation_from_quaternion,
    slerp,
)
from olp.runtime.paths import point_on_arc, point_on_parabola
from olp.runtime.plan import PATHS, StepKind

if TYPE_CHECKING:
    import pandas

    from olp.runtime.plan import Plan
    from olp.timing.result import Timing

Floats = NDArray[np.float64]
_JOINT, _CIRCULAR, _SPLINE = (PATHS.index(p) for p in (Path.JOINT, Path.CIRCULAR, Path.SPLINE))
_INSTANT = 1e-6  # [s] either side of an instant whose speed is asked for
_MOST_SAMPLES = 20_000_000
_SAME_PLACE = 1e-6  # [m, rad]
_BEYOND = 2  # a move overlaps at most its two neighbours, because a zone reaches at most half of a move


@dataclass(frozen=True, slots=True)
class Track:
    """The leading robot at n instants: `time` (n,) [s], `line` (n,), `position` (n, 3) [m], `rotation` (n, 3, 3),
    `axes` (n, k) [rad or m]; nan where unknown. `segment` (n,): index into `Plan.time`. `tool_changes` (n,): number
    of tool changes so far: at a change the tool point jumps although nothing moves.
    """

    time: Floats
    line: NDArray[np.int32]
    segment: NDArray[np.intp]
    tool_changes: NDArray[np.intp]
    file: tuple[str, ...]
    position: Floats
    rotation: Floats
    axes: Floats
    axis_names: tuple[str, ...]
    linear: tuple[bool, ...]  # which axes are slides

    def frame(self) -> pandas.DataFrame:
        """A table with units in the column names: t_s, line, x_mm … rz_deg, q1_deg … (q7_mm for a slide), file,
        segment, tool_changes."""
        import pandas

        columns: dict[str, object] = {"t_s": self.time, "line": self.line}
        columns.update(zip(("x_mm", "y_mm", "z_mm"), self.position.T / mm, strict=True))
        angles = angles_from_rotation(self.rotation) / deg
        columns.update(zip(("rx_deg", "ry_deg", "rz_deg"), angles.T, strict=True))
        for i, linear in enumerate(self.linear):
            columns[f"q{i + 1}_{'mm' if linear else 'deg'}"] = self.axes[:, i] / (mm if linear else deg)
        names = {name: utf8(name).decode() for name in set(self.file)}  # pandas takes no name that is no text
        columns["file"] = [names[name] for name in self.file]
        columns["segment"] = self.segment
        columns["tool_changes"] = self.tool_changes
        return pandas.DataFrame(columns)


def track(timing: Timing, dt: float) -> Track:
    """The motion of the leading mechanism every `dt` [s], from the start to the end of the program, both included.

    Raises OlpError when a step cannot be timed, when nothing moves, or when there would be more than 20 million rows.
    """
    plan = timing.plan
    _check(timing, dt)
    total = timing.total_s
    count = int(np.floor(total / dt + 1e-9)) + 1
    times = np.minimum(np.append(np.arange(count) * dt, total), total)
    if len(times) > 1 and times[-1] - times[-2] < 1e-9:
        times = times[:-1]
    steps = np.minimum(np.searchsorted(timing.end_s, times, side="left"), len(plan) - 1)
    position, rotation, axes = states(timing, times)
    robot = plan.robot
    known = min(len(robot.axes), axes.shape[1]) if robot else 0
    paths = [source.path for source in plan.sources]
    return Track(
        times,
        plan.line[steps],
        steps,
        _tool_changes(timing, times),
        tuple(paths[s] for s in plan.source[steps].tolist()),
        position,
        rotation,
        axes[:, :known],
        robot.axis_names[:known] if robot else (),
        tuple(axis.linear for axis in robot.axes[:known]) if robot else (),
    )


def _check(timing: Timing, dt: float) -> None:
    if not dt > 0:
        raise OlpError(error("T201", f"the time step must be above zero, not {dt:g} s"))
    if not len(timing.plan.moves):
        raise OlpError(error("T202", "this program moves nothing", file=timing.plan.path))
    unknown = [d for d in timing.diagnostics if d.is_error]
    if unknown:
        raise OlpError(*unknown)
    if timing.total_s / dt > _MOST_SAMPLES:
        raise OlpError(
            error("T203", f"{timing.total_s:g} s in steps of {dt:g} s are too many rows", help="larger --dt")
        )


def states(timing: Timing, times: Floats) -> tuple[Floats, Floats, Floats]:
    """Position (n, 3) [m], rotation (n, 3, 3) and axes (n, k) of the leading mechanism at ascending `times` [s].

    Axes along lines are continued from the first of `times` in each move: the nearer this is to the move's start,
    the safer.
    """
    rows = _leading_rows(timing.plan)
    position, quaternion, axes, here = _poses(timing, rows, times)
    rotation = rotation_from_quaternion(quaternion)
    return position, rotation, _axes_along_paths(timing.plan, rows[here], position, rotation, axes)


def tool_position(timing: Timing, times: Floats) -> Floats:
    """Position (n, 3) [m] as in `states`, without the axes, which take most of its computing time."""
    return _poses(timing, _leading_rows(timing.plan), times)[0]


def tool_speed(timing: Timing, times: Floats) -> Floats:
    """Speed (n,) [m/s] of the leading mechanism's tool point at `times` [s], corners included."""
    rows = _leading_rows(timing.plan)
    ends = np.stack((times - _INSTANT, times + _INSTANT), axis=1).ravel()
    ends = np.clip(ends, 0.0, timing.total_s)
    position = _poses(timing, rows, ends)[0].reshape(-1, 2, 3)
    travelled = np.linalg.norm(position[:, 1] - position[:, 0], axis=1)
    speed: Floats = travelled / np.maximum(np.diff(ends.reshape(-1, 2), axis=1)[:, 0], _INSTANT)
    return speed


def _leading_rows(plan: Plan) -> NDArray[np.intp]:
    """The first row of every move."""
    rows: NDArray[np.intp] = plan.row[plan.kind == StepKind.MOVE].astype(np.intp)
    return rows


def _poses(
    timing: Timing, rows: NDArray[np.intp], times: Floats
) -> tuple[Floats, Floats, Floats, NDArray[np.intp]]:
    """Position, quaternion and driven axes at `times`, and which of `rows` each instant belongs to."""
    plan = timing.plan
    begins = timing.rows.start[rows]
    # A move with a long overlap may begin before the one in front of it: then more than two run at once.
    all_begun = np.searchsorted(np.maximum.accumulate(begins), times, side="right") - 1
    any_begun = np.searchsorted(np.minimum.accumulate(begins[::-1])[::-1], times, side="right") - 1
    here = np.maximum(any_begun, 0)
    first = np.maximum(all_begun - _BEYOND, 0)
    start = plan.moves.start[rows[first]]
    position = plan.positions.position[start].copy()
    quaternion = plan.positions.quaternion[start].copy()
    axes = plan.positions.axes[start].copy()
    for offset in range(int((here - first).max(initial=0)) + 1):
        index = np.minimum(first + offset, len(rows) - 1)
        live = (first + offset < len(rows)) & (times >= timing.rows.start[rows[index]])
        if offset:
            jump, twist = _tool_change(plan, rows, index)
            position += np.where(live[:, None], jump, 0.0)
            quaternion = np.where(live[:, None], _multiply(quaternion, twist), quaternion)
        fraction = np.where(live, timing.rows.fraction(rows[index], times), 0.0)
        moved, turned, driven = _displacement(plan, rows[index], fraction)
        position += moved
        quaternion = _multiply(quaternion, turned)
        axes += driven
    return position, quaternion, axes, here


def _tool_change(plan: Plan, rows: NDArray[np.intp], index: NDArray[np.intp]) -> tuple[Floats, Floats]:
    """Jump of the tool point, (n, 3) [m] and quaternion (n, 4), where a row uses another tool than the row before."""
    moves, positions = plan.moves, plan.positions
    before, after = moves.target[rows[np.maximum(index - 1, 0)]], moves.start[rows[index]]
    twist = _multiply(_conjugate(positions.quaternion[before]), positions.quaternion[after])
    return positions.position[after] - positions.position[before], twist


def _tool_changes(timing: Timing, times: Floats) -> NDArray[np.intp]:
    """Number of moves (n,) begun at `times` with another tool than the move before."""
    rows = _leading_rows(timing.plan)
    jump, twist = _tool_change(timing.plan, rows, np.arange(len(rows)))
    turned = 2 * np.linalg.norm(twist[:, 1:], axis=1)
    other = (np.linalg.norm(jump, axis=1) > _SAME_PLACE) | (turned > _SAME_PLACE)
    other[0] = False
    count: NDArray[np.intp] = np.searchsorted(np.sort(timing.rows.start[rows[other]]), times, side="right")
    return count


def _axes_along_paths(
    plan: Plan, rows: NDArray[np.intp], position: Floats, rotation: Floats, axes: Floats
) -> Floats:
    """Axes (n, k): as driven in joint moves; from the tool's pose along lines and curves."""
    robot = plan.robot
    if robot is None or robot.geometry is None:
        return axes
    from olp.robots.kinematics.tracking import track_paths

    width = len(robot.axes)
    curved = np.flatnonzero(plan.moves.path[rows] != _JOINT)
    begins, of = _runs(rows[curved])
    starts = plan.moves.start[rows[curved[begins]]]
    known = np.flatnonzero(~np.isnan(plan.positions.axes[starts][:, :width]).any(axis=1))
    follows = np.isin(of, known)
    axes[curved[~follows]] = np.nan
    curved, starts = curved[follows], starts[known]
    begins, of = _runs(rows[curved])
    seeds = plan.positions.axes[starts][:, :width]
    for paths in np.split(np.arange(len(begins)), np.flatnonzero(np.diff(begins // _AT_ONCE)) + 1):
        if not len(paths):
            continue
        first, last = paths[0], paths[-1]
        part = slice(begins[first], begins[last + 1] if last + 1 < len(begins) else len(curved))
        at, mine = curved[part], of[part] - first
        tool, turn = _tools(plan, starts[paths], seeds[paths])
        back = np.swapaxes(turn, -1, -2)
        off = -np.einsum("nij,nj->ni", back, tool)
        flange = compose(position[at], rotation[at], off[mine], back[mine])
        axes[at, :width] = track_paths(robot, *flange, seeds[paths], begins[paths] - begins[first])
    return axes


def _runs(values: NDArray[np.intp]) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Start of each run of equal `values` (n,), and the number of the run that each value belongs to (n,)."""
    begins = np.flatnonzero(np.diff(values, prepend=-1))
    return begins, np.repeat(np.arange(len(begins)), np.diff(np.append(begins, len(values))))


_AT_ONCE = 100_000  # samples whose axes are worked out together: more would take memory and save no time


def _tools(plan: Plan, start: NDArray[np.int32], axes: Floats) -> tuple[Floats, Floats]:
    """Tools (n, 3) [m], (n, 3, 3) at positions `start`: the transform from the flange to the pose."""
    from olp.robots.kinematics.configuration import forward

    assert plan.robot is not None
    position, rotation = forward(plan.robot, axes)
    back = np.swapaxes(rotation, -1, -2)
    pose = plan.positions.position[start], rotation_from_quaternion(plan.positions.quaternion[start])
    return np.einsum("nij,nj->ni", back, pose[0] - position), back @ pose[1]


def _displacement(plan: Plan, rows: NDArray[np.intp], fraction: Floats) -> tuple[Floats, Floats, Floats]:
    """Displacement of each row at `fraction` of its path: shift (n, 3) [m], turn as quaternion (n, 4), axes (n, k)."""
    moves, positions = plan.moves, plan.positions
    start, target = moves.start[rows], moves.target[rows]
    a, b = positions.position[start], positions.position[target]
    share = fraction[:, None]
    shift = (b - a) * share
    driven = (positions.axes[target] - positions.axes[start]) * share
    path, via = moves.path[rows], moves.via[rows]
    for code, shape in ((_CIRCULAR, point_on_arc), (_SPLINE, point_on_parabola)):
        curved = (path == code) & (via >= 0)
        if curved.any():
            c = positions.position[via[curved]]
            shift[curved] = (
                shape(a[curved], b[curved], c, moves.before[rows][curved], fraction[curved]) - a[curved]
            )
    turn = _multiply(_conjugate(positions.quaternion[start]), positions.quaternion[target])
    turn = slerp(np.broadcast_to([1.0, 0.0, 0.0, 0.0], turn.shape), turn, fraction)
    joint = path == _JOINT
    if joint.any() and plan.robot is not None and plan.robot.geometry is not None:
        shift[joint], turn[joint] = _joint_displacement(plan, rows[joint], driven[joint])
    return shift, turn, driven


def _joint_displacement(plan: Plan, rows: NDArray[np.intp], driven: Floats) -> tuple[Floats, Floats]:
    """Tool displacement of a joint move, which is a curve: forward kinematics of the intermediate axes."""
    from olp.robots.kinematics.configuration import forward

    assert plan.robot is not None
    width = len(plan.robot.axes)
    start = plan.moves.start[rows]
    axes = plan.positions.axes[start][:, :width]
    flange = forward(plan.robot, axes + driven[:, :width])
    position, rotation = compose(*flange, *_tools(plan, start, axes))
    then = rotation_from_quaternion(plan.positions.quaternion[start])
    turn = np.swapaxes(then, -1, -2) @ rotation
    return position - plan.positions.position[start], quaternion_from_rotation(turn)


def _multiply(first: Floats, second: Floats) -> Floats:
    """(n, 4) product of quaternions."""
    w, v = first[:, :1], first[:, 1:]
    x, u = second[:, :1], second[:, 1:]
    scalar = w * x - np.sum(v * u, axis=1, keepdims=True)
    product: Floats = np.concatenate([scalar, w * u + x * v + np.cross(v, u)], axis=1)
    return product


def _conjugate(quaternion: Floats) -> Floats:
    conjugate: Floats = quaternion * np.array([1.0, -1.0, -1.0, -1.0])
    return conjugate
