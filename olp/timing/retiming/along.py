"""Axis limits along every line, arc and spline of a plan: highest speed, limiting axis and place, and unreachable
parts.

The joints are sampled along many rows at once.
"""

from __future__ import annotations

from typing import Any, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from olp.core import result_cache
from olp.core.diagnostic import Diagnostic, warning
from olp.core.units import deg, mm
from olp.ir.program import Path
from olp.robots.geometry import compose, invert, rotation_from_quaternion, slerp
from olp.robots.kinematics.configuration import clearance, configuration_of, forward, within_limits
from olp.robots.kinematics.inverse import inverse
from olp.robots.model import Robot
from olp.runtime.paths import point_on_arc, point_on_parabola
from olp.runtime.plan import PATHS, Plan, of_rows
from olp.timing.retiming.path import PathLimits, SampledPath, Singular, spline_through
from olp.timing.retiming.retime import retime

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

    Joints are continuous along each row from the axes at its start. They are nan where `reached` (r, n) is False,
    and from `jump` (r,) on: the first sample at which the axes would have to jump (n: nowhere), by `leap` (r, k)
    [rad].
    """

    rows: Rows
    place: Floats
    joints: Floats
    reached: NDArray[np.bool_]
    jump: NDArray[np.intp]
    leap: Floats


def groups(plan: Plan, rows: Rows, joints: Floats) -> dict[int, Rows]:
    """Rows grouped by their number of samples; 2: both ends suffice. `joints` (r, k): change of the axes."""
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
    """Rows (r,) along which an axis moves much further between two samples than wanted, and than between others."""
    steps = np.abs(np.diff(samples.joints, axis=1))
    most, mean = steps.max(axis=1), steps.mean(axis=1)
    uneven = (most > 1.5 * _ANGLE) & (most > 2.0 * mean)
    found: NDArray[np.bool_] = np.any(uneven | np.isnan(most), axis=1)
    return found


def measure(plan: Plan) -> Floats:
    """Length of each row (m,) [m], or its angle [rad] where only the tool turns."""
    moves = plan.moves
    return np.where(moves.length > 1e-9, moves.length, np.nan_to_num(moves.angle))


def _continued(joints: Floats, start: Floats) -> tuple[Floats, NDArray[np.intp], Floats]:
    """Joints (r, n, k) made continuous from `start` (r, k) by whole turns; where they jump and how far: see Samples."""
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
    """Tool centre points (n, 3) [m] and rotations (n, 3, 3) of the rows, each at its fraction of the path."""
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
    """Tools (n, 3) [m], (n, 3, 3) at the positions `start`: the transform from the flange to the pose."""
    flange = invert(*forward(robot, axes))
    rotation = rotation_from_quaternion(plan.positions.quaternion[start])
    return compose(*flange, plan.positions.position[start], rotation)


Bools = NDArray[np.bool_]

_JOINT = PATHS.index(Path.JOINT)
_NEAR = np.array([1.0 * deg, 1.0 * deg, 10.0 * mm])  # nearer to a singularity no speed is worth telling
_FREE = 1e6  # [rad/s²] an acceleration that limits nothing
_CLOSER = 8  # times as many samples where a singularity may be near
_SLACK = 1e-9  # a limit that is met to this share is not broken


def along_path(
    plan: Plan, programmed: Floats | None = None, acceleration: Floats | None = None
) -> PathLimits:
    """Limits along all lines, arcs and splines of arms whose axes are known.

    `programmed` [m/s] and `acceleration` [m/s²] of the tool, (m,), for each row; by default the plan's own speed
    and no limit. Short rows are sampled at both ends, others every 20 mm and 2.5 deg of an axis (more sparsely in a
    plan of more than 400,000 samples).
    """
    count = len(plan.moves)
    speeds = plan.moves.travel if programmed is None else programmed
    pushes = np.full(count, np.inf) if acceleration is None else acceleration
    result = PathLimits.nothing(count, speeds)
    told: list[str] = []
    for mechanism, robot in enumerate(plan.robots):
        if robot is None:
            continue
        driven = np.flatnonzero((plan.moves.path == _JOINT) & (plan.moves.mechanism == mechanism))
        result.outside[driven] = _outside_at_ends(plan, robot, driven)
        if robot.kind != "arm" or robot.geometry is None:
            continue
        rows = _rows(plan, mechanism, len(robot.axes))
        if not len(rows):
            continue
        result.known[rows] = True
        change = _change(plan, robot, rows)
        if robot.geometry.links is None:
            told.append(f"the axes of {robot.name} along lines are checked at the ends of each line only")
            _ends(plan, robot, rows, change, speeds, result)
            continue
        for samples, part in groups(plan, rows, change).items():
            if samples == 2:
                _ends(plan, robot, part, change[np.searchsorted(rows, part)], speeds, result)
                continue
            known = RetimingCache(plan, robot, samples, part, speeds, pushes)
            fresh = known.fresh(result)
            if not len(fresh):
                known.keep(result)
                continue
            # A program in a loop passes the same row again and again: each is looked at once.
            single, alike = _distinct(plan, robot, fresh, speeds, pushes)
            looked = sample(plan, robot, single, samples)
            _inside(plan, robot, looked, speeds, pushes, result)
            _copy(result, single[alike], fresh)
            # Where axes move further between two samples than was wanted, a singularity may be near: look closer.
            doubtful = np.flatnonzero(coarse(looked)[alike])
            again = doubtful[: MOST // (_CLOSER * samples)]
            if len(again):
                closer = single[np.unique(alike[again])]
                _inside(plan, robot, sample(plan, robot, closer, _CLOSER * samples), speeds, pushes, result)
                _copy(result, single[alike[again]], fresh[again])
            if len(again) == len(doubtful):
                known.keep(result)
    unsure = (result.singular >= 0) | ~np.isnan(result.lost) | ~result.known
    for column in (result.speed, result.place, result.acceleration):
        column[unsure] = np.nan
    result.axis[unsure] = -1
    result.assumptions = tuple(told)
    result.diagnostics = findings(plan, result)
    return result


def _rows(plan: Plan, mechanism: int, width: int) -> Rows:
    """Rows with motion of one mechanism whose path, and whose axes at both ends, are known."""
    moves = plan.moves
    rows = np.flatnonzero((moves.path != _JOINT) & (moves.mechanism == mechanism) & (measure(plan) > 1e-9))
    axes = plan.positions.axes[:, :width]
    sound = ~np.any(np.isnan(axes), axis=1) & ~np.any(np.isnan(plan.positions.position), axis=1)
    found: Rows = rows[sound[moves.start[rows]] & sound[moves.target[rows]]]
    return found


def _change(plan: Plan, robot: Robot, rows: Rows) -> Floats:
    """Change of each axis (r, k), the short way round."""
    axes = plan.positions.axes[:, : len(robot.axes)]
    change = axes[plan.moves.target[rows]] - axes[plan.moves.start[rows]]
    turning = np.array([not axis.linear for axis in robot.axes])
    short: Floats = np.where(turning, change - _TURN * np.rint(change / _TURN), change)
    return short


def _ends(plan: Plan, robot: Robot, rows: Rows, change: Floats, programmed: Floats, out: PathLimits) -> None:
    """Limits of short rows, from the mean change of the axes and the poses at both ends."""
    slope = np.abs(change) / measure(plan)[rows][:, None]
    _limit(robot, rows, slope[:, None, :], np.zeros((len(rows), 1)), out)
    out.outside[rows] = _outside_at_ends(plan, robot, rows)
    if robot.geometry is not None and robot.geometry.links is not None:
        used, start, target = _positions(plan, rows)
        table = np.stack(clearance(robot, plan.positions.axes[used][:, : len(robot.axes)]), axis=1)
        _approach(rows, np.stack((table[start], table[target]), axis=1), out)
    slower = (out.speed[rows] < programmed[rows] * (1 - _SLACK)) & (out.singular[rows] < 0)
    out.paced[rows[slower]] = out.speed[rows[slower]]


def _inside(
    plan: Plan, robot: Robot, samples: Samples, programmed: Floats, pushes: Floats, out: PathLimits
) -> None:
    """Limits of rows sampled along the path."""
    rows, joints = samples.rows, samples.joints
    # A closer look replaces what was found before.
    out.known[rows], out.paced[rows] = True, programmed[rows]
    _reach(plan, robot, samples, out)
    whole = np.flatnonzero(~np.any(np.isnan(joints), axis=(1, 2)))
    if not len(whole):
        return
    path = _paths(samples.place[whole], joints[whole])
    _limit(robot, rows[whole], np.abs(path.first), path.place, out)
    slower = out.speed[rows[whole]] < programmed[rows[whole]] * (1 - _SLACK)
    slower &= out.singular[rows[whole]] < 0
    if slower.any():
        _pace(robot, rows[whole][slower], path, slower, programmed, pushes, out)


def _reach(plan: Plan, robot: Robot, samples: Samples, out: PathLimits) -> None:
    """Singularities, places out of reach and soft limits of sampled rows."""
    rows, joints = samples.rows, samples.joints
    out.singular[rows], out.nearness[rows], out.lost[rows] = Singular.NONE, np.nan, np.nan
    clear = np.stack(clearance(robot, joints.reshape(-1, joints.shape[2])), axis=1)
    _approach(rows, clear.reshape(*joints.shape[:2], 3), out)
    ends = np.stack(
        [plan.positions.axes[at[rows]][:, : joints.shape[2]] for at in (plan.moves.start, plan.moves.target)],
        axis=1,
    )
    for end in (ends[:, 0], ends[:, 1]):
        _approach(rows, np.stack(clearance(robot, end), axis=1)[:, None, :], out)
    gone = ~samples.reached.all(axis=1)
    out.lost[rows[gone]] = samples.place[gone, np.argmin(samples.reached[gone], axis=1)]
    jumped = ~gone & (samples.jump < joints.shape[1])
    # With the arm's flags held, axes jump where the path runs through a singularity: S above axis S, else R and T.
    crossed = jumped & (samples.jump > 0) & (out.singular[rows] < 0)
    above = samples.leap[:, 0] > 0.5 * np.pi
    out.singular[rows[crossed]] = np.where(above[crossed], Singular.SHOULDER, Singular.WRIST)
    out.nearness[rows[crossed]] = 0.0
    sure = out.singular[rows] < 0
    out.known[rows[jumped & sure]] = False
    # Beyond a singularity the axes depend on how the controller passes it: only both ends are certain there.
    out.outside[rows] = np.where(sure, _outside(robot, joints), _outside(robot, ends))


def _paths(place: Floats, joints: Floats) -> SampledPath:
    """Derivatives by `place` (r, n) of joints (r, n, k), from splines over the sample number."""
    number = np.arange(place.shape[1], dtype=np.float64)
    columns = np.concatenate((joints, place[:, :, None]), axis=2)
    _, first, second = spline_through(number, np.moveaxis(columns, 1, 0))(number)
    first, second = np.moveaxis(first, 0, 1), np.moveaxis(second, 0, 1)
    pace, change = first[:, :, -1:], second[:, :, -1:]
    slope = first[:, :, :-1] / pace
    return SampledPath(place, slope, (second[:, :, :-1] - slope * change) / pace**2)


def _limit(robot: Robot, rows: Rows, slope: Floats, place: Floats, out: PathLimits) -> None:
    """Write speed and acceleration limits of the path, where |dq/ds| is `slope` (r, n, k) at `place` (r, n)."""
    steep = slope.max(axis=1)
    with np.errstate(divide="ignore"):
        by_axis = robot.speeds / steep
        pushed = np.nan_to_num(robot.accelerations, nan=np.inf) / steep
    axis = np.argmin(by_axis, axis=1)
    pick = np.arange(len(rows))
    out.speed[rows] = by_axis[pick, axis]
    out.axis[rows] = np.where(np.isfinite(by_axis[pick, axis]), axis, -1)
    out.place[rows] = place[pick, np.argmax(slope[pick, :, axis], axis=1)]
    out.acceleration[rows] = np.nan_to_num(pushed, nan=np.inf, posinf=np.inf).min(axis=1)


def _pace(
    robot: Robot,
    rows: Rows,
    path: SampledPath,
    at: Bools,
    programmed: Floats,
    pushes: Floats,
    out: PathLimits,
) -> None:
    """Mean speed of the rows with local slowing."""
    speed = np.minimum(programmed[rows], 1e3)
    part = SampledPath(path.place[at], path.first[at], path.second[at])
    wide = np.ones_like(part.place)
    run = retime(
        part,
        robot.speeds,
        np.full(len(robot.axes), _FREE),
        speed[:, None] * wide,
        pushes[rows][:, None] * wide,
        speed,
        speed,
    )
    out.paced[rows] = np.minimum(part.place[:, -1] / run.duration, programmed[rows])


def _approach(rows: Rows, clear: Floats, out: PathLimits) -> None:
    """Smallest distance of rows from singularities, from clearances (r, n, 3); a change of sign contains a zero."""
    near = np.nan_to_num(np.abs(clear), nan=np.inf).min(axis=1)
    both = np.any(np.nan_to_num(clear) < 0, axis=1) & np.any(np.nan_to_num(clear) > 0, axis=1)
    both[:, Singular.ELBOW] = False  # its sign also changes halfway between stretched and folded
    near[both] = 0.0
    which = np.argmin(near / _NEAR, axis=1)
    pick = np.arange(len(rows))
    share = near[pick, which] / _NEAR[which]
    before = np.where(
        out.singular[rows] < 0, 1.0, np.nan_to_num(out.nearness[rows]) / _NEAR[out.singular[rows]]
    )
    found = share < before
    out.singular[rows[found]] = which[found]
    out.nearness[rows[found]] = near[pick, which][found]


def _positions(plan: Plan, rows: Rows) -> tuple[Rows, Rows, Rows]:
    """The positions at which rows start and end, each once, and the index of each row's start and target among them."""
    ends = np.concatenate((plan.moves.start[rows], plan.moves.target[rows]))
    used, where = np.unique(ends, return_inverse=True)
    return used.astype(np.intp), where[: len(rows)], where[len(rows) :]


def _outside_at_ends(plan: Plan, robot: Robot, rows: Rows) -> NDArray[np.int8]:
    """First axis (r,) outside its soft limits at the start or the target of each row, -1 if none."""
    used, start, target = _positions(plan, rows)
    found = _outside(robot, plan.positions.axes[used][:, None, : len(robot.axes)])
    either: NDArray[np.int8] = np.where(found[target] >= 0, found[target], found[start])
    return either


def _outside(robot: Robot, joints: Floats) -> NDArray[np.int8]:
    """First axis (r,) of joints (r, n, k) that leaves its soft limits, -1 if none."""
    inside = within_limits(robot, joints.reshape(-1, joints.shape[2])).reshape(joints.shape)
    beyond = np.any(~inside & ~np.isnan(joints), axis=1)
    anywhere = np.any(beyond, axis=1)
    found: NDArray[np.int8] = np.where(anywhere, np.argmax(beyond, axis=1), -1).astype(np.int8)
    return found


# --- Findings ---
# What limits along a plan's paths have to be told, each with its line.

_MANNERS = ("a straight wrist", "a stretched arm", "a wrist above axis S")


def findings(plan: Plan, limits: PathLimits) -> tuple[Diagnostic, ...]:
    """One warning per file and kind of problem, at its first line, with the number of further ones."""
    moves = plan.moves

    def lost(row: int) -> tuple[str, str]:
        travels = moves.length[row] > 1e-9
        whole, unit, name = (moves.length[row], mm, "mm") if travels else (moves.angle[row], deg, "deg")
        place = f"{limits.lost[row] / unit:.1f} of {whole / unit:.1f} {name}"
        return (
            f"{_name(plan, row)}: the path to this point leaves the arm's reach after {place}",
            "both ends are reachable, the path between them is not: use a joint move or a point between",
        )

    def outside(row: int) -> tuple[str, str]:
        axis = _axis(plan, row, int(limits.outside[row]))
        return (
            f"{_name(plan, row)}: axis {axis} leaves its soft limits on this move",
            "the controller will stop here with an alarm",
        )

    def singular(row: int) -> tuple[str, str]:
        kind, near = int(limits.singular[row]), limits.nearness[row]
        shown = f"{near / mm:.1f} mm" if kind == 2 else f"{near / deg:.2f} deg"
        return (
            f"{_name(plan, row)}: this move passes within {shown} of a singularity ({_MANNERS[kind]})",
            "axis speeds are not known there: the time is that of the programmed speed, the robot may be slower",
        )

    found = [
        ("L103", ~np.isnan(limits.lost), lost),
        ("L104", limits.outside >= 0, outside),
        ("L105", limits.singular >= 0, singular),
    ]
    told: list[Diagnostic] = []
    for code, where, says in found:
        rows = np.flatnonzero(where)
        if len(rows):
            told += of_rows(plan, rows, warning, code, *says(int(rows[0])))
    return tuple(told)


def _name(plan: Plan, row: int) -> str:
    return plan.mechanisms[int(plan.moves.mechanism[row])]


def _axis(plan: Plan, row: int, axis: int) -> str:
    robot = plan.robots[int(plan.moves.mechanism[row])]
    return robot.axis_names[axis] if robot else str(axis + 1)


# --- Cache ---
# Rows that an earlier plan of the same text held too: what was found along them holds still.

_FOUND: Final = (
    "known", "speed", "axis", "place", "acceleration", "paced", "singular", "nearness", "lost", "outside",
)  # fmt: skip


class RetimingCache:
    """Cached results for `rows` (r,) of a plan with `samples` samples each, if the process keeps a memory cache.

    A result is reused where all its inputs are identical bit for bit. Edits insert and remove rows, so the rows
    before the first change and after the last change are compared.
    """

    def __init__(
        self, plan: Plan, robot: Robot, samples: int, rows: Rows, speeds: Floats, pushes: Floats
    ) -> None:
        self._rows, self._robot = rows, robot
        self._shelf = result_cache.shelf("rows along paths")
        if self._shelf is not None:
            self._key = (robot.name, samples)
            self._asked = _bits(_asked(plan, robot, rows, speeds, pushes))

    def fresh(self, result: PathLimits) -> Rows:
        """The rows without a cached result; cached results of the others are written into `result`."""
        before: Any = None if self._shelf is None else self._shelf.get(self._key)
        if before is None or before[0] is not self._robot or before[1].dtype != self._asked.dtype:
            return self._rows
        _, asked, found = before
        count = min(len(asked), len(self._asked))
        head = _same(asked[:count], self._asked[:count])
        left = count - head
        tail = _same(asked[len(asked) - left :][::-1], self._asked[len(self._asked) - left :][::-1])
        for place, name in enumerate(_FOUND):
            column = getattr(result, name)
            column[self._rows[:head]] = found[:head, place]
            if tail:
                column[self._rows[-tail:]] = found[-tail:, place]
        return self._rows[head : len(self._rows) - tail]

    def keep(self, result: PathLimits) -> None:
        """Store the results of the rows for the next plan."""
        if self._shelf is not None:
            found = np.stack([getattr(result, name)[self._rows] for name in _FOUND], axis=1)
            self._shelf.put(self._key, (self._robot, self._asked, found))


def _asked(plan: Plan, robot: Robot, rows: Rows, speeds: Floats, pushes: Floats) -> Floats:
    """Every number (r, n) that decides the result of a row."""
    moves, positions = plan.moves, plan.positions
    via = moves.via[rows]
    third = np.where((via >= 0)[:, None], positions.position[via], np.nan)
    ends = [
        part[at[rows]]
        for at in (moves.start, moves.target)
        for part in (positions.position, positions.quaternion, positions.axes[:, : len(robot.axes)])
    ]
    single = (moves.path, moves.before, moves.length, moves.angle, speeds, pushes)
    columns = np.stack([np.asarray(one[rows], dtype=np.float64) for one in single], axis=1)
    return np.concatenate((*ends, third, columns), axis=1)


def _distinct(
    plan: Plan, robot: Robot, rows: Rows, speeds: Floats, pushes: Floats
) -> tuple[Rows, NDArray[np.intp]]:
    """The first of all rows (r,) that are equal bit for bit in what decides their results, and which of these each row
    is equal to (r,).
    """
    _, first, alike = np.unique(
        _bits(_asked(plan, robot, rows, speeds, pushes)), return_index=True, return_inverse=True
    )
    order = np.argsort(first)
    rank = np.empty_like(order)
    rank[order] = np.arange(len(order))
    return rows[first[order]], rank[alike]


def _copy(result: PathLimits, rows: Rows, to: Rows) -> None:
    """Write what was found along `rows` (r,) to the rows `to` (r,)."""
    for name in _FOUND:
        column = getattr(result, name)
        column[to] = column[rows]


def _bits(table: Floats) -> NDArray[np.void]:
    """Each row of a table as one opaque value, so that nan equals itself."""
    whole = np.ascontiguousarray(table)
    bits: NDArray[np.void] = whole.view(np.dtype((np.void, whole.itemsize * whole.shape[1])))[:, 0]
    return bits


def _same(first: NDArray[np.void], second: NDArray[np.void]) -> int:
    """Number of equal elements before the first difference."""
    differ = np.flatnonzero(first != second)
    return int(differ[0]) if len(differ) else len(first)
