"""How fast each axis turns along each move: `Rates` of a recording, from the robot's kinematics or from joint points.

The arm's posture is the one of the joint points; without them in front, elbow up, wrist flipped or not, whichever keeps
more of the points inside the soft limits.
"""

from __future__ import annotations

import itertools
import math
from collections import Counter
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from olp.identification.diagnosis.simulation_laws import last_digit
from olp.identification.recording.moves import CIRCULAR, JOINT, LINEAR, WAIT, RecordedMoves
from olp.robots.geometry import (
    quaternion_from_rotation,
    rotation_from_angles,
    rotation_from_quaternion,
    slerp,
)
from olp.robots.kinematics.configuration import joint_speeds, wrap
from olp.robots.kinematics.inverse import branches, inverse, newton
from olp.robots.model import Robot
from olp.runtime.paths import circle, swept_angle
from olp.timing.physics._case import Floats, Mask, Rates

if TYPE_CHECKING:
    from olp.identification.recording.recording import Recording


Labels = NDArray[np.int64]

_ELBOW, _WRIST = 2, 4  # joints of the chain, from 0
PLACES = 21  # along each move
# [m] Joint points and tool points that put the tool's point this near to one place on the flange tell the tool.
_SAME_TOOL = 1e-3
_READ_OFF = (
    "how fast each axis turns along lines is read off the joint and tool points; a robot model would add"
)
_TELLS = "joint-acceleration-limit, joint-speed-limit and torque-speed"


def rates_of(recording: Recording, rows: Labels, way: Floats) -> tuple[Rates | None, tuple[str, ...]]:
    """Signed axis rates of the moves at `rows` (n,) of the recording, and what has to be said of them.

    `way` (n,) [m], or [rad] of the leading axis in joint moves: what the rates are per unit of. None when neither a
    robot with known kinematics nor joint points are there. Raises OlpError (K…).
    """
    moves, robot = recording.moves, recording.robot
    joint_points = _rows_of(moves.joints_start, rows), _rows_of(moves.joints_end, rows)
    if robot is None or robot.geometry is None:
        return _means(moves, rows, way, joint_points, "" if robot is None else robot.name)
    task = _Task(recording, robot, rows, *joint_points)
    path = np.zeros((len(rows), PLACES, len(robot.axes)))
    _joint_moves(task, path)
    _tool_moves(task, path)
    known = np.asarray(task.open & np.isfinite(way) & (way > 0))
    task.leave_out(task.open & ~known, "no length")
    path[~known] = 0.0
    path[known] /= way[known, None, None]
    speeds, slopes = (v if np.isfinite(v).all() else None for v in (robot.speeds, robot.accelerations))
    told = Rates(path, known, True, robot.axis_names, speeds, slopes, task.bodies, task.lifts, task.climb)
    return told, task.told()


def tool_ways(recording: Recording) -> Floats:
    """(n,) [m] how far the tool goes in joint moves, whose ways are [rad]: by the robot's kinematics, else along the
    chord between the tool's points; nan where neither tells it, and in other moves."""
    from olp.robots.kinematics.configuration import forward

    moves, robot = recording.moves, recording.robot
    ways = np.where(moves.kind == JOINT, moves.chord, np.nan)
    at = np.flatnonzero((moves.kind == JOINT) & moves.has_joints)
    if (
        robot is None
        or robot.geometry is None
        or not len(at)
        or moves.joints_start.shape[1] != len(robot.axes)
    ):
        return ways
    task = _Task(recording, robot, at, moves.joints_start[at], moves.joints_end[at])
    joints = _between(task.joints_start, task.joints_end)
    flange, rotation = forward(robot, joints.reshape(len(at) * PLACES, -1))
    tool = flange + rotation @ _tool(task, np.arange(len(at)))[0]
    steps = np.diff(tool.reshape(len(at), PLACES, 3), axis=1)
    ways[at] = np.linalg.norm(steps, axis=2).sum(axis=1)
    return ways


@dataclass(slots=True, eq=False)
class _Task:
    """What is worked on. `open`: moves that can still be told, `why`: what left the others out."""

    recording: Recording
    robot: Robot
    rows: Labels
    joints_start: Floats  # (n, k) nan where not written
    joints_end: Floats
    open: Mask = field(init=False)
    kind: NDArray[np.int8] = field(init=False)
    why: dict[int, str] = field(default_factory=dict)
    notes: list[str] = field(default_factory=list)
    bodies: Floats | None = None  # (n, m, 2, 3) [m], see Rates
    lifts: Floats | None = None  # (n, m, 2, k) [m/rad], see Rates
    climb: Floats | None = None  # (n, m), see Rates

    def __post_init__(self) -> None:
        axes = len(self.robot.axes)
        if self.joints_start.shape[1] != axes:  # no joint points at all: the reader refuses other numbers
            self.joints_start = self.joints_end = np.full((len(self.rows), axes), np.nan)
        self.kind = self.recording.moves.kind[self.rows]
        self.open = np.asarray(self.kind != WAIT)

    @property
    def posed(self) -> Mask:
        """(n,) moves with both joint points."""
        return np.asarray(
            np.isfinite(self.joints_start).all(axis=1) & np.isfinite(self.joints_end).all(axis=1)
        )

    def leave_out(self, which: Mask, why: str) -> None:
        for row in np.nonzero(which & self.open)[0].tolist():
            self.why[row] = why
        self.open &= ~which

    def told(self) -> tuple[str, ...]:
        notes = list(dict.fromkeys(self.notes))
        if self.why:
            number = self.recording.moves.move[self.rows]
            first = {why: int(number[row]) for row, why in sorted(self.why.items(), reverse=True)}
            parts = [
                f"{why} ({count}, the first is move {first[why]})"
                for why, count in Counter(self.why.values()).most_common()
            ]
            moving = int((self.kind != WAIT).sum())
            notes.append(f"{len(self.why)} of {moving} moves have no axis rates: {', '.join(parts)}")
        return tuple(notes)


def _rows_of(points: Floats, rows: Labels) -> Floats:
    return np.asarray(points[rows]) if points.ndim == 2 and len(points) else np.zeros((len(rows), 0))


def _means(
    moves: RecordedMoves, rows: Labels, way: Floats, points: tuple[Floats, Floats], name: str
) -> tuple[Rates | None, tuple[str, ...]]:
    """From joint points alone: each axis as if it turned evenly."""
    what = f"the robot file of {name} has no [links] or [chain]" if name else "the recording names no robot"
    turned = points[1] - points[0]
    known = np.isfinite(turned).all(axis=1) & (moves.kind[rows] != WAIT) & np.isfinite(way) & (way > 0)
    if not turned.shape[1] or not known.any():
        says = "axis rates are not known, so these terms cannot be identified"
        more = (
            "a robot model would also tell where elbow and wrist are, which gravity and reach-inertia go by"
        )
        return None, (f"{what} and there are no joint points: {says}: {_TELLS}; {more}",)
    mean = np.zeros_like(turned)
    mean[known] = turned[known] / way[known, None]
    path = np.repeat(mean[:, None, :], PLACES, axis=1)
    learned = learned_joints(moves, rows, points)
    says = (
        "each axis is assumed to turn evenly over a move; a robot model would add its rates along lines and"
    )
    if learned is not None:
        straight = known & (moves.kind[rows] == LINEAR) & np.isfinite(learned).all(axis=(1, 2))
        along = np.gradient(learned, axis=1) * (PLACES - 1)
        path[straight] = along[straight] / way[straight, None, None]
        says = _READ_OFF
    names = tuple(f"axis {i + 1}" for i in range(turned.shape[1]))
    arm = learned_arm(moves, rows, points)
    if arm is not None:
        along = arm.rates(moves, rows, points)
        reached = known & (moves.kind[rows] != JOINT) & np.isfinite(along).all(axis=(1, 2))
        path[reached, :, : along.shape[2]] = along[reached] / way[reached, None, None]
        says = _READ_OFF if reached.any() else says
    bodies, lifts = (None, None) if arm is None else arm.bodies(moves, rows, points)
    climb = _climb_between(moves, rows, points[0], points[1], None if arm is None else arm.turn, bodies)
    rates = Rates(path, known, False, names, bodies=bodies, lifts=lifts, climb=climb)
    return rates, (f"{what}: {says} its rated speeds",)


def _climb_between(
    moves: RecordedMoves, rows: Labels, first: Floats, last: Floats, turn: float | None, bodies: Floats | None
) -> Floats:
    """(n, m) Sine of the incline of joint moves: the tool goes with the wrist, as far from it as between its two ends
    seen from the turning arm; straight from end to end where nobody knows the wrist. nan for other moves."""
    start, end = moves.start[rows], moves.end[rows]
    share = np.linspace(0.0, 1.0, PLACES)[None, :, None]
    points = start[:, None] + share * (end - start)[:, None]
    if turn is not None and bodies is not None:
        wrist = bodies[:, :, 1]
        bearing = turn * _between(first, last)[..., 0]
        ahead = (_turned_about_z(p - wrist[:, k], -bearing[:, k]) for p, k in ((start, 0), (end, -1)))
        near, far = (of[:, None] for of in ahead)
        followed = wrist + _turned_about_z(near + share * (far - near), bearing)
        lacking = np.isnan(followed).any(axis=(1, 2), keepdims=True)
        points = np.where(lacking, points, followed)
    return np.where((moves.kind[rows] == JOINT)[:, None], _inclines(points), np.nan)


def _turned_about_z(points: Floats, angle: Floats) -> Floats:
    """Points (…, 3) turned by angles (…) [rad] about the vertical."""
    x, y, z = np.moveaxis(points, -1, 0)
    cos, sin = np.cos(angle), np.sin(angle)
    return np.stack([cos * x - sin * y, sin * x + cos * y, z], axis=-1)


def _inclines(points: Floats) -> Floats:
    """(n, m) Sine of the incline along points (n, m, 3): 0 where they stand still, nan where they are not known."""
    step = np.gradient(points, axis=1)
    size = np.linalg.norm(step, axis=2)
    return np.asarray(np.where(size > 1e-9, step[..., 2] / np.where(size > 1e-9, size, 1.0), size * 0.0))


# --- joint moves ------------------------------------------------------------------------------------------------------


def _joint_moves(task: _Task, path: Floats) -> None:
    """All axes move in proportion: the same rate along the whole move."""
    mine = task.open & (task.kind == JOINT)
    told = mine & task.posed
    path[told] = (task.joints_end - task.joints_start)[told, None, :]
    if told.any():
        at = np.nonzero(told)[0]
        along = _between(task.joints_start[at], task.joints_end[at])
        _add_bodies(task, at, along)
        _add_climb(task, at, along)
    rest = np.asarray(mine & ~told)
    if not rest.any():
        return
    at = np.nonzero(rest)[0]
    ways = _ways(task, rest)
    at = at[task.open[at]]
    if not len(at):
        return
    posture, seed = _posture(task, ways, at)
    ends = _ends(task.robot, ways, posture, seed)
    reached = np.isfinite(ends).all(axis=(0, 2))
    path[at[reached]] = (ends[1] - ends[0])[reached, None, :]
    _add_climb(task, at[reached], _between(ends[0], ends[1])[reached])
    task.leave_out(_mask(task, at[~reached]), "out of reach")
    if reached.any():
        task.notes.append(
            "joint moves without joint points: the axes' turns are those between their tool points"
        )


def _ends(robot: Robot, ways: ToolPaths, posture: Labels, seed: Floats) -> Floats:
    """(2, n, k) Joints at start and end in one posture, each by itself; numeric arms end near where they start."""

    first = joints_along(robot, ways, np.zeros(1), posture, seed)[:, 0]
    place, rotation, _, _ = ways.at(np.ones(1))
    near = np.where(np.isfinite(first), first, (robot.lower + robot.upper) / 2.0)
    last, _ = inverse(robot, place[:, 0], rotation[:, 0], posture, near)
    return np.stack([first, last])


# --- lines and arcs ---------------------------------------------------------------------------------------------------


def _tool_moves(task: _Task, path: Floats) -> None:
    wanted = np.asarray(task.open & (task.kind != JOINT))
    if not wanted.any():
        return
    ways = _ways(task, wanted)
    at = np.nonzero(wanted & task.open)[0]
    if not len(at):
        return
    posture, seed = _posture(task, ways, at)
    share = np.linspace(0.0, 1.0, PLACES)
    joints = joints_along(task.robot, ways, share, posture, seed)
    rates = rates_along(task.robot, ways, share, joints)
    reached = np.isfinite(rates).all(axis=(1, 2))
    path[at[reached]] = rates[reached]
    _add_bodies(task, at[reached], joints[reached])
    task.leave_out(_mask(task, at[~reached]), "out of reach")


def _between(start: Floats, end: Floats) -> Floats:
    """(n, m, k) joints along joint moves."""
    share = np.linspace(0.0, 1.0, PLACES)[None, :, None]
    return np.asarray(start[:, None, :] + share * (end - start)[:, None, :])


def _add_bodies(task: _Task, at: NDArray[np.intp], joints: Floats) -> None:
    """Where the elbow and the wrist centre are along the moves `at`, and how each axis lifts them, of arms that have
    both."""
    from olp.robots.kinematics.configuration import geometry_of, sweep

    geometry = geometry_of(task.robot)
    if geometry.links is None:
        return
    count, places, axes = joints.shape
    swept = sweep(task.robot, geometry, joints.reshape(count * places, axes).T)
    if task.bodies is None or task.lifts is None:
        task.bodies = np.full((len(task.rows), PLACES, 2, 3), np.nan)
        task.lifts = np.full((len(task.rows), PLACES, 2, axes), np.nan)
    for which, joint in enumerate((_ELBOW, _WRIST)):
        task.bodies[at, :, which] = swept.origins[joint].T.reshape(count, places, 3)
        lifts = np.zeros((axes, count * places))
        for turned, direction, origin in zip(
            geometry.joints[:joint], swept.axes, swept.origins, strict=False
        ):
            arm = swept.origins[joint] - origin
            slides = task.robot.axes[turned.axis].linear
            lifts[turned.axis] += direction[2] if slides else direction[0] * arm[1] - direction[1] * arm[0]
        task.lifts[at, :, which] = lifts.T.reshape(count, places, axes)


def _add_climb(task: _Task, at: NDArray[np.intp], joints: Floats) -> None:
    """How steeply the tool goes along the joint moves `at`, from their joints (n, m, k)."""
    from olp.robots.kinematics.configuration import forward

    count, places, axes = joints.shape
    flange, rotation = forward(task.robot, joints.reshape(count * places, axes))
    tool, _ = _tool(task, at)
    if task.climb is None:
        task.climb = np.full((len(task.rows), PLACES), np.nan)
    task.climb[at] = _inclines((flange + rotation @ tool).reshape(count, places, 3))


def _ways(task: _Task, wanted: Mask) -> ToolPaths:
    """The flange's ways of those of the `wanted` moves that can be told; the others are left out, with the reason."""
    from olp.robots.geometry import rotation_from_angles
    from olp.robots.kinematics.configuration import forward

    moves, rows = task.recording.moves, task.rows
    task.leave_out(wanted & ~task.posed & ~moves.has_points[rows], "no tool points")
    start_angles, end_angles = moves.start_angles[rows], moves.end_angles[rows]
    turned = np.isfinite(np.concatenate([start_angles, end_angles], axis=1)).all(axis=1)
    task.leave_out(wanted & ~task.posed & ~turned, "no tool orientation")
    bent = task.kind == CIRCULAR
    task.leave_out(wanted & bent & ~np.isfinite(moves.via[rows]).all(axis=1), "no middle point")
    at = np.nonzero(wanted & task.open)[0]
    tool, known = _tool(task, at)
    start, end = moves.start[rows[at]].copy(), moves.end[rows[at]].copy()
    first, last = np.empty((len(at), 3, 3)), np.empty((len(at), 3, 3))
    posed = task.posed[at]
    off = np.eye(3) if task.recording.tool is None else task.recording.tool.rotation.T
    free = ~posed
    first[free] = rotation_from_angles(start_angles[at][free]) @ off
    last[free] = rotation_from_angles(end_angles[at][free]) @ off
    for place, rotation, joints in ((start, first, task.joints_start), (end, last, task.joints_end)):
        flange, rotation[posed] = forward(task.robot, joints[at[posed]])
        place[posed] = flange + rotation[posed] @ tool
    via = np.where(bent[at, None], moves.via[rows[at]], np.nan)
    if not known and free.any():
        task.notes.append(
            "the tool is not given: its points are assumed to be the flange's; set tool = [x, y, z, rx, ry, rz] "
            "in recording.toml for correct axis rates"
        )
    return ToolPaths(start, end, via, first, last, np.broadcast_to(tool, (len(at), 3)).copy())


def _tool(task: _Task, at: NDArray[np.intp]) -> tuple[Floats, bool]:
    """(3,) [m] the tool's point on the flange, and whether anything tells it: recording.toml, or joint and tool points
    together."""
    from olp.robots.kinematics.configuration import forward

    recording = task.recording
    given = None if recording.tool is None else recording.tool.position
    both = at[task.posed[at] & recording.moves.has_points[task.rows[at]]]
    if not len(both):
        return (np.zeros(3), False) if given is None else (given, True)
    seen = []
    for joints, place in ((task.joints_start, recording.moves.start), (task.joints_end, recording.moves.end)):
        position, rotation = forward(task.robot, joints[both])
        seen.append(np.einsum("nji,nj->ni", rotation, place[task.rows[both]] - position))
    offsets = np.concatenate(seen)
    tool = np.median(offsets, axis=0) if given is None else given
    if np.percentile(np.abs(offsets - tool), 95) > _SAME_TOOL:
        links = None if task.robot.geometry is None else task.robot.geometry.links
        third = "; is q3 the angle to the horizontal that the pendant shows? q3 + q2 is the joint's"
        task.notes.append(
            f"joint points and tool points disagree on the tool of {task.robot.name}: the joint points "
            f"are used{third if links is not None and links.third_to_horizontal else ''}"
        )
    return np.asarray(tool), True


def _posture(task: _Task, ways: ToolPaths, at: NDArray[np.intp]) -> tuple[Labels, Floats]:
    """(n, 6) RCONF's first flags and (n, k) joints to begin near, nan where there are no joint points."""
    from olp.robots.kinematics.configuration import configuration_of

    seed = task.joints_start[at]
    flags = np.zeros((len(at), 6), dtype=np.int64)
    posed = np.isfinite(seed).all(axis=1)
    assert task.robot.geometry is not None
    if task.robot.geometry.links is None:
        if not posed.all():
            task.notes.append("the arm's posture is not given: assumed near the middle of the axes' ranges")
        return flags, seed
    if posed.any():
        flags[posed] = configuration_of(task.robot, seed[posed])
    if not posed.all():
        flags[~posed] = _usual_posture(task, ways.take(np.nonzero(~posed)[0]))
    return flags, seed


def _usual_posture(task: _Task, ways: ToolPaths) -> Labels:
    """(6,) In front, elbow up; the wrist's sign that keeps more ends of ways inside the soft limits."""
    from olp.identification.probe.reach import FLIPPED, PLAIN
    from olp.robots.kinematics.configuration import within_limits

    robot, count = task.robot, len(ways.start)
    inside = []
    for posture in (PLAIN, FLIPPED):
        flags = np.broadcast_to(np.array(posture, dtype=np.int64), (count, 6))
        nowhere = np.full((count, len(robot.axes)), np.nan)
        joints = joints_along(robot, ways, np.linspace(0.0, 1.0, 2), flags, nowhere)
        inside.append(int(within_limits(robot, joints.reshape(2 * count, -1)).all(axis=1).sum()))
    chosen = FLIPPED if inside[1] > inside[0] else PLAIN
    sign = "below zero" if chosen == FLIPPED else "zero or more"
    task.notes.append(
        f"the arm's posture is not given: assumed in front of axis {robot.axis_names[0]}, elbow up, axis "
        f"{robot.axis_names[4]} {sign} from the straight wrist"
    )
    return np.array(chosen, dtype=np.int64)


def _mask(task: _Task, at: NDArray[np.intp]) -> Mask:
    mask = np.zeros(len(task.rows), dtype=bool)
    mask[at] = True
    return mask


# --- Learned joints ---
# An arm's joints along straight moves, where no robot is named but joint and tool points are: read off the points.
#
# The joints at all recorded ends are a smooth function of the tool's place: a polyharmonic spline through them
# (J. Duchon, Splines minimizing rotation-invariant semi-norms in Sobolev spaces, 1977) gives them in between, where it
# foretells ends
# that it was not given.

_FEWEST, _MOST = 24, 320  # ends that a spline goes through
_FIFTH = 5  # every fifth end is foretold from the others
# Of the spread of an axis: what nine of ten foretold ends are off, at most. Near a singularity one may be far off.
_GOOD, _OF_ENDS = 0.05, 0.9


def learned_joints(
    moves: RecordedMoves, rows: NDArray[np.int64], points: tuple[Floats, Floats]
) -> Floats | None:
    """(n, m, k) [rad | m] at m places along the straight way of the moves at `rows`; None where the points do not tell.

    `points`: (n, k) each, joints at start and end.
    """
    places = np.concatenate([moves.start[rows], moves.end[rows]])
    joints = np.concatenate(points)
    good = np.isfinite(places).all(axis=1) & np.isfinite(joints).all(axis=1)
    if not good.any():
        return None
    _, one = np.unique(np.round(np.concatenate([places, joints], axis=1)[good], 6), axis=0, return_index=True)
    at = np.nonzero(good)[0][one]
    if len(at) < _FEWEST:
        return None
    at = at[np.linspace(0, len(at) - 1, min(len(at), _MOST)).astype(np.int64)]
    best, least = None, _GOOD
    for features in (_cylindrical, _plain):
        inputs = features(places)
        held = np.arange(len(at)) % _FIFTH == 0
        told = _Spline(inputs[at[~held]], joints[at[~held]])(inputs[at[held]])
        spread = np.maximum(np.ptp(joints[at], axis=0), 1e-6)
        off = float((np.quantile(np.abs(told - joints[at[held]]), _OF_ENDS, axis=0) / spread).max())
        if off < least:
            best, least = features, off
    if best is None:
        return None
    spline = _Spline(best(places[at]), joints[at])
    share = np.linspace(0.0, 1.0, PLACES)[None, :, None]
    start, end = moves.start[rows], moves.end[rows]
    along = start[:, None, :] + share * (end - start)[:, None, :]
    result = spline(best(along.reshape(-1, 3))).reshape(len(rows), PLACES, -1)
    # Behind the arm the first axis' angle may be written with a turn more or less; no axis turns that far at once.
    result = np.unwrap(result, axis=1)
    # The recorded ends are met exactly, but for whole turns.
    first, last = points[0] - result[:, 0], points[1] - result[:, -1]
    last -= 2.0 * np.pi * np.rint((last - first) / (2.0 * np.pi))
    return np.asarray(result + first[:, None, :] * (1.0 - share) + last[:, None, :] * share)


def _plain(places: Floats) -> Floats:
    return places


def _cylindrical(places: Floats) -> Floats:
    """(n, 3) The first axis turns with the bearing, the others with distance and height."""
    return np.stack(
        [np.arctan2(places[:, 1], places[:, 0]), np.hypot(places[:, 0], places[:, 1]), places[:, 2]], axis=1
    )


class _Spline:
    """Through values (n, k) at inputs (n, d): cubes of distances and a plane."""

    def __init__(self, inputs: Floats, values: Floats) -> None:
        self.middle, self.spread = inputs.mean(axis=0), np.maximum(inputs.std(axis=0), 1e-9)
        self.inputs = (inputs - self.middle) / self.spread
        count, width = self.inputs.shape
        plane = np.concatenate([np.ones((count, 1)), self.inputs], axis=1)
        whole = np.zeros((count + width + 1,) * 2)
        whole[:count, :count] = _cubes(self.inputs, self.inputs)
        whole[:count, count:], whole[count:, :count] = plane, plane.T
        right = np.concatenate([values, np.zeros((width + 1, values.shape[1]))])
        self.weights = np.linalg.lstsq(whole, right, rcond=1e-12)[0]

    def __call__(self, inputs: Floats) -> Floats:
        """(m, k) at inputs (m, d)."""
        inputs = (inputs - self.middle) / self.spread
        basis = np.concatenate([_cubes(inputs, self.inputs), np.ones((len(inputs), 1)), inputs], axis=1)
        return np.asarray(basis @ self.weights)


def _cubes(one: Floats, other: Floats) -> Floats:
    square = (one**2).sum(axis=1)[:, None] + (other**2).sum(axis=1)[None, :] - 2.0 * one @ other.T
    return np.asarray(np.maximum(square, 0.0) ** 1.5)


# --- Learned arm ---
# The lengths of an arm that nobody named, from the joints and points of the recorded ends.
#
# In the plane of an arm the wrist is as far out and as high as the sines of the second joint and of the forearm's
# angle add up to, and so is the tool on it (M. Brandstötter, A. Angerer, M. Hofbaur, Austrian Robotics Workshop, 2014):
# the lengths follow by least squares.

_OF_ARM, _TRIMS = 0.7, 20  # of the recorded ends that an arm has to reach, and steps to find these
_ROUNDS = 8  # of I. Newton's method from joints that turn evenly to those of a line


class LearnedArm(NamedTuple):
    """`turn`, `coupled`: signs of the first joint, and of the second in the forearm's angle; `out`, `up` (5,) [m]
    lengths by the columns of `_sines`."""

    turn: float
    coupled: float
    out: Floats
    up: Floats
    tool: Floats  # (3,) [m] the tool's point seen from the wrist, in the tool's directions

    def bodies(
        self, moves: RecordedMoves, rows: Labels, points: tuple[Floats, Floats]
    ) -> tuple[Floats, Floats]:
        """(n, m, 2, 3) [m] elbow and wrist centre along moves between `points`, and (n, m, 2, k) [m/rad] their rise by
        each axis; nan where they are not known."""
        upper, fore, bearing = self._angles(moves, rows, points)
        sines, bodies = _sines(upper, fore), []
        lifts = np.zeros((*upper.shape, 2, points[0].shape[-1]))
        by_upper, by_fore = (
            np.stack([np.cos(angle), -np.sin(angle)], axis=-1) @ self.up[at]
            for angle, at in ((upper, slice(1, 3)), (fore, slice(3, 5)))
        )
        lifts[..., 0, 1], lifts[..., 1, 1] = by_upper, by_upper + self.coupled * by_fore
        lifts[..., 1, 2] = by_fore
        for last in (3, 5):  # elbow, wrist
            out, up = (sines[..., :last] @ lengths[:last] for lengths in (self.out, self.up))
            bodies.append(np.stack([out * np.cos(bearing), out * np.sin(bearing), up], axis=-1))
        return np.stack(bodies, axis=2), lifts

    def rates(self, moves: RecordedMoves, rows: Labels, points: tuple[Floats, Floats]) -> Floats:
        """(n, m, 3) [rad per whole way] of the first three joints along lines and arcs between `points`; nan where they
        are not known."""
        upper, fore, bearing = self._angles(moves, rows, points)
        place, _, speed, _ = self._ways(moves, rows).at(np.linspace(0.0, 1.0, PLACES))
        out = np.cos(bearing) * place[..., 0] + np.sin(bearing) * place[..., 1]
        outwards = np.cos(bearing) * speed[..., 0] + np.sin(bearing) * speed[..., 1]
        across = np.cos(bearing) * speed[..., 1] - np.sin(bearing) * speed[..., 0]
        by_upper, by_fore = self._steps(upper, fore, np.stack([outwards, speed[..., 2]], axis=-1))
        out = np.where(np.abs(out) > 1e-9, out, np.nan)
        return np.stack([self.turn * across / out, by_upper, by_fore - self.coupled * by_upper], axis=-1)

    def _angles(
        self, moves: RecordedMoves, rows: Labels, points: tuple[Floats, Floats]
    ) -> tuple[Floats, Floats, Floats]:
        """(n, m) each: the upper arm's and the forearm's angle and the arm's bearing along moves between `points`."""
        joints, turning = _between(*points), moves.kind[rows] == JOINT
        upper, fore, bearing = (
            joints[..., 1],
            joints[..., 2] + self.coupled * joints[..., 1],
            self.turn * joints[..., 0],
        )
        wrist = self._ways(moves, rows).at(np.linspace(0.0, 1.0, PLACES))[0]
        x, y, z = np.moveaxis(wrist[~turning], -1, 0)
        # Forwards or over its back, an arm stays so along a move.
        first = bearing[~turning][:, :1]
        side = np.where(np.cos(first) * x[:, :1] + np.sin(first) * y[:, :1] < 0, -1.0, 1.0)
        upper[~turning], fore[~turning] = self._there(
            upper[~turning], fore[~turning], np.stack([side * np.hypot(x, y), z], axis=-1)
        )
        bearing[~turning] = np.arctan2(side * y, side * x)
        return upper, fore, bearing

    def _ways(self, moves: RecordedMoves, rows: Labels) -> ToolPaths:
        """The wrist's ways of tool moves; the tool is not turned where nothing tells that."""
        ends = moves.start[rows], moves.end[rows]
        first, last = (
            rotation_from_angles(np.nan_to_num(a[rows])) for a in (moves.start_angles, moves.end_angles)
        )
        via = np.where((moves.kind[rows] == CIRCULAR)[:, None], moves.via[rows], np.nan)
        return ToolPaths(*ends, via, first, last, np.broadcast_to(self.tool, (len(rows), 3)))

    def _there(self, upper: Floats, fore: Floats, wrist: Floats) -> tuple[Floats, Floats]:
        """Angles (n, m) of the upper arm and the forearm with the wrist there, `wrist` (n, m, 2) outwards and up, from
        those that turn evenly; nan where these do not lead there."""
        lengths = np.stack([self.out, self.up], axis=1)
        for _ in range(_ROUNDS):
            one, other = self._steps(upper, fore, wrist - _sines(upper, fore) @ lengths)
            upper, fore = upper + one, fore + other
        near = np.abs(wrist - _sines(upper, fore) @ lengths).max(axis=-1) < _SAME_TOOL
        return np.where(near, upper, np.nan), np.where(near, fore, np.nan)

    def _steps(self, upper: Floats, fore: Floats, way: Floats) -> tuple[Floats, Floats]:
        """Turns (n, m) of the upper arm and the forearm that move the wrist by small steps `way` (n, m, 2) outwards and
        up, or, per time, for such a speed; nan where the arm is stretched."""
        lengths = np.stack([self.out, self.up], axis=1)
        one, other = (
            np.stack([np.cos(angle), -np.sin(angle)], axis=-1) @ lengths[at]
            for angle, at in ((upper, slice(1, 3)), (fore, slice(3, 5)))
        )
        area = one[..., 0] * other[..., 1] - one[..., 1] * other[..., 0]
        area = np.where(np.abs(area) > 1e-9, area, np.nan)
        return (
            (way[..., 0] * other[..., 1] - way[..., 1] * other[..., 0]) / area,
            (one[..., 0] * way[..., 1] - one[..., 1] * way[..., 0]) / area,
        )


def learned_arm(moves: RecordedMoves, rows: Labels, points: tuple[Floats, Floats]) -> LearnedArm | None:
    """The arm whose joints `points` (n, k) each, at start and end, put the tool where it was recorded; None when none
    of this kind does."""
    places = np.concatenate([moves.start[rows], moves.end[rows]])
    angles = np.concatenate([moves.start_angles[rows], moves.end_angles[rows]])
    joints = np.concatenate(points)
    good = np.isfinite(places).all(axis=1) & np.isfinite(joints).all(axis=1)
    if good.sum() < _FEWEST or joints.shape[1] <= _ELBOW:
        return None
    places, angles, joints = places[good], angles[good], joints[good]
    turned = rotation_from_angles(angles) if np.isfinite(angles).all() else np.zeros((len(joints), 3, 0))
    best, least = None, _SAME_TOOL
    for turn, coupled in itertools.product((1.0, -1.0), (0.0, 1.0, -1.0)):
        sines = _sines(joints[:, 1], joints[:, 2] + coupled * joints[:, 1])
        cos, sin = np.cos(turn * joints[:, 0]), np.sin(turn * joints[:, 0])
        tool = cos[:, None] * turned[:, 0] + sin[:, None] * turned[:, 1], turned[:, 2]
        none = np.zeros_like(sines)
        told = np.stack([np.hstack([sines, none, tool[0]]), np.hstack([none, sines, tool[1]])], axis=1)
        wanted = np.stack([cos * places[:, 0] + sin * places[:, 1], places[:, 2]], axis=1)
        lengths, off = _of_most(told, wanted)
        if off < least:
            tool_of = lengths[10:] if len(lengths) > 10 else np.zeros(3)
            best, least = LearnedArm(turn, coupled, lengths[:5], lengths[5:10], tool_of), off
    return best


def _of_most(told: Floats, wanted: Floats) -> tuple[Floats, float]:
    """(q,) least squares of `told` (n, d, q) times them for `wanted` (n, d), over those of the n that fit best, and by
    how much the worst of these is off: ends that the arm does not reach have some joints or other (least trimmed
    squares, P. Rousseeuw, K. Van Driessen, Data Mining and Knowledge Discovery 12, 2006)."""
    most = np.arange(len(told))
    for _ in range(_TRIMS):
        square, right = told[most].reshape(-1, told.shape[2]), wanted[most].ravel()
        lengths = np.asarray(np.linalg.lstsq(square, right, rcond=1e-9)[0], dtype=np.float64)
        off = np.abs(told @ lengths - wanted).max(axis=1)
        kept = np.sort(np.argsort(off, kind="stable")[: math.ceil(_OF_ARM * len(told))])
        if np.array_equal(kept, most):
            break
        most = kept
    return lengths, float(off[kept].max())


def _sines(upper: Floats, fore: Floats) -> Floats:
    """(…, 5) one, and sine and cosine of each angle (…)."""
    return np.stack([np.ones_like(upper), np.sin(upper), np.cos(upper), np.sin(fore), np.cos(fore)], axis=-1)


# --- The axes along the tool's ways ---
# Lines and arcs as flange poses, with the posture continued. Orientation turns the short way at a constant rate, as
# `olp track` plays a program.


# [m/s per rad/s] Damping of the inverse Jacobian: exact to 1e-4 where the weakest direction moves 1 cm per radian,
# and finite at a singularity.
_DAMPING = 1e-4
# [rad] A larger step between two places may be another posture, or a singularity between them: looked at more finely.
_SUDDEN = 0.35
_FINER = 16


@dataclass(frozen=True, slots=True, eq=False)
class ToolPaths:
    """n ways of the tool's point, and the flange that carries it. `via` is nan for lines."""

    start: Floats  # (n, 3) [m]
    end: Floats  # (n, 3) [m]
    via: Floats  # (n, 3) [m]
    first: Floats  # (n, 3, 3) rotation of the flange at the start
    last: Floats  # (n, 3, 3) at the end
    tool: Floats  # (n, 3) [m] the tool's point seen from the flange

    def take(self, rows: NDArray[np.intp]) -> ToolPaths:
        return replace(self, **{name: getattr(self, name)[rows] for name in self.__slots__})

    def at(self, share: Floats) -> tuple[Floats, Floats, Floats, Floats]:
        """At m shares 0..1 of the way: the flange (n, m, 3) [m], (n, m, 3, 3), its speed (n, m, 3) [m], and its spin
        (n, 3) [rad], both per whole way."""
        place, speed = self._points(share)
        turn = quaternion_from_rotation(self.first.transpose(0, 2, 1) @ self.last)
        so_far = slerp(np.array([1.0, 0.0, 0.0, 0.0]), turn[:, None, :], share[None, :])
        rotation = self.first[:, None] @ rotation_from_quaternion(so_far)
        spin = np.einsum("nij,nj->ni", self.first, _vector(turn))
        arm = np.einsum("nmij,nj->nmi", rotation, self.tool)
        return place - arm, rotation, speed - np.cross(spin[:, None, :], arm), spin

    def _points(self, share: Floats) -> tuple[Floats, Floats]:
        """(n, m, 3) [m] places of the tool's point and its speed per whole way."""
        chord = self.end - self.start
        place = self.start[:, None] + share[None, :, None] * chord[:, None]
        speed = np.broadcast_to(chord[:, None], place.shape).copy()
        bent = np.isfinite(self.via).all(axis=1)
        if bent.any():
            place[bent], speed[bent] = _arc(self.start[bent], self.via[bent], self.end[bent], share)
        return place, speed


def _arc(start: Floats, via: Floats, end: Floats, share: Floats) -> tuple[Floats, Floats]:
    """(n, m, 3) [m] places and speed per whole way on the circle through three points; a line where they are on one."""
    centre, radius, axis = circle(start, via, end)
    spoke = start - centre
    with np.errstate(invalid="ignore"):
        swept = swept_angle(spoke, end - centre, axis)
        angle = (swept[:, None] * share[None, :])[:, :, None]
        across = np.cross(axis, spoke)[:, None]
        out = spoke[:, None] * np.cos(angle) + across * np.sin(angle)
        speed = swept[:, None, None] * (across * np.cos(angle) - spoke[:, None] * np.sin(angle))
    round_ = np.isfinite(radius)[:, None, None]
    chord = (end - start)[:, None]
    place = np.where(round_, centre[:, None] + out, start[:, None] + share[None, :, None] * chord)
    return place, np.where(round_, speed, chord)


def _vector(quaternion: Floats) -> Floats:
    """(n, 3) [rad] rotation vectors of quaternions (n, 4) with w >= 0."""
    sine = np.linalg.norm(quaternion[:, 1:], axis=1)
    angle = 2.0 * np.arctan2(sine, quaternion[:, 0])
    scale = np.where(sine > 1e-12, angle / np.where(sine > 1e-12, sine, 1.0), 2.0)
    return np.asarray(quaternion[:, 1:] * scale[:, None])


def joints_along(robot: Robot, ways: ToolPaths, share: Floats, posture: Labels, seed: Floats) -> Floats:
    """(n, m, k) [rad | m] continuous along each way, nan from where a place is out of reach.

    `posture` (n, 6): RCONF's first flags at the start, for spherical wrists; other arms begin near `seed` (n, k)
    [rad | m], or in mid-range where it is nan. Raises OlpError (K…).
    """
    place, rotation, _, _ = ways.at(share)
    if robot.geometry is None or robot.geometry.links is None:
        return _numerically(robot, place, rotation, seed)
    joints = _flat(robot, place, rotation, np.repeat(posture, len(share), axis=0))
    steps = np.diff(joints, axis=1)
    joints[:, 1:] -= np.cumsum(2.0 * np.pi * np.rint(np.nan_to_num(steps) / (2.0 * np.pi)), axis=1)
    sudden = np.nonzero((np.abs(np.diff(joints, axis=1)) > _SUDDEN).any(axis=(1, 2)))[0]
    if len(sudden):
        fine = np.interp(
            np.arange((len(share) - 1) * _FINER + 1), np.arange(len(share)) * float(_FINER), share
        )
        joints[sudden] = _nearest(robot, ways.take(sudden), fine, joints[sudden, 0])[:, ::_FINER]
    return joints


def rates_along(robot: Robot, ways: ToolPaths, share: Floats, joints: Floats) -> Floats:
    """(n, m, k) [rad | m per whole way] that turn the axes along `joints` (n, m, k); nan where those are.

    Near a singularity the rates are large and finite; arms with more than six axes take the shortest turn.
    """
    _, _, speed, spin = ways.at(share)
    count, places, axes = joints.shape
    known = np.isfinite(joints).all(axis=2).ravel()
    both = np.concatenate([speed, np.broadcast_to(spin[:, None], speed.shape)], axis=2).reshape(-1, 6)[known]
    rates = np.full((count * places, axes), np.nan)
    rates[known] = joint_speeds(robot, joints.reshape(-1, axes)[known], both, _DAMPING)
    return rates.reshape(count, places, axes)


def _flat(robot: Robot, place: Floats, rotation: Floats, posture: Labels) -> Floats:
    count, places = place.shape[:2]
    joints, _ = inverse(robot, place.reshape(-1, 3), rotation.reshape(-1, 3, 3), posture)
    return joints.reshape(count, places, -1)


def _nearest(robot: Robot, ways: ToolPaths, share: Floats, first: Floats) -> Floats:
    """(n, m, 6) Of all eight solutions the one that is nearest to the place before, from `first` (n, 6) on."""
    place, rotation, _, _ = ways.at(share)
    every = branches(robot, place.reshape(-1, 3), rotation.reshape(-1, 3, 3))
    every = every.reshape(len(first), len(share), 8, -1)
    found = np.empty((len(first), len(share), every.shape[-1]))
    found[:, 0] = last = first
    for i in range(1, len(share)):
        apart = wrap(every[:, i] - last[:, None])
        far = np.nan_to_num(np.sum(apart * apart, axis=2), nan=np.inf)
        last = last + np.take_along_axis(apart, np.argmin(far, axis=1)[:, None, None], axis=1)[:, 0]
        found[:, i] = last
    return found


def _numerically(robot: Robot, place: Floats, rotation: Floats, seed: Floats) -> Floats:
    """(n, m, k) Each place solved from the one before, all ways at once."""
    count, places = place.shape[:2]
    found = np.empty((count, places, len(robot.axes)))
    near = np.isfinite(seed).all(axis=1)
    found[near, 0], good = newton(robot, place[near, 0], rotation[near, 0], seed[near])
    found[np.nonzero(near)[0][~good], 0] = np.nan
    found[~near, 0] = inverse(robot, place[~near, 0], rotation[~near, 0])[0]
    for i in range(1, places):
        found[:, i] = np.nan
        rows = np.nonzero(np.isfinite(found[:, i - 1]).all(axis=1))[0]
        joints, good = newton(robot, place[rows, i], rotation[rows, i], found[rows, i - 1])
        found[rows[good], i] = joints[good]
    return found


# --- joint moves without a robot --------------------------------------------------------------------------------------


class AxisLimits(NamedTuple):
    """What each axis can do in the judged simulation, as its joint moves tell; `leading` sets each move's speed."""

    speeds: Floats  # (k,) [rad/s], inf where the axis never sets a move's speed
    accelerations: Floats  # (k,) [rad/s²], inf where it never sets a ramp
    leading: NDArray[np.intp]  # (n,)
    speed: Floats  # (n,) [rad/s] of the leading axis
    acceleration: Floats  # (n,) [rad/s²] of the leading axis
    confirmed: Mask  # (n,) the times of other moves show the same speed and acceleration
    off: Floats  # (n,) [1] the time by these limits over the simulated one, less one
    together: bool = True  # all limits hold at once; False: the slowest axis takes its own time
    beside: float = 0.0  # [s] that every move between stops takes beside them
    built: float = 0.0  # [s] in which accelerations build up
    shortest: float = 0.0  # [s] that a ramp takes at least

    @property
    def unknown(self) -> Mask:
        """(n,) moves that take longer than these limits say: a corner makes one shorter, never longer."""
        return np.asarray(self.off < -_OFF)

    @property
    def likely_speeds(self) -> tuple[Floats, Mask]:
        """(k,) [rad/s] `speeds`, and (k,) where they are none of these: an axis whose highest speed no move reaches is
        taken to reach it in the time that the others take, inf where nothing tells that."""
        shown = self.speeds < _SHOWN
        ramps = np.where(self.accelerations < _SHOWN, self.accelerations, np.inf)
        both = shown & np.isfinite(ramps)
        if both.sum() < 2 or not (likely := ~shown & np.isfinite(ramps)).any():
            return self.speeds, np.zeros(len(shown), dtype=bool)
        time = float(np.median(self.speeds[both] / ramps[both]))
        return np.where(likely, time * ramps, self.speeds), likely

    def tell(self, some: NDArray[np.int64]) -> bool:
        """Whether they tell the times of `some` moves, by their rows: those at rounded corners then stop there."""
        return bool(len(some) and (np.abs(self.off[some]) < _OFF).all())


_ENOUGH_MOVES = 5  # joint moves: fewer tell no limits
_OFF, _OF_ALL = 2e-3, 0.8  # of a simulated time that limits may be off, in this share of the moves
_NEARER = 0.5  # [1] of a law's misfit that the other one must leave: axes with limits in proportion obey both
_MUCH_NEARER = 0.2  # [1] likewise, where a plainer law does
_DIGITS = 1e-4  # [s] no simulated time is told nearer
_FOR_A_TIME = 4  # different moves within their digits that a time beside the ramps has to bring
_EXACT = 3e-4  # of a simulated time: nearer, there is no other law to look for
# How many times stand beside limits, and whether accelerations build up in the first one, or no ramp is shorter.
_TIMES_BESIDE = ((0, False, False), (1, False, False), (1, True, False), (1, False, True), (2, True, False))
_LIMIT_ROUNDS = 60
_FAR = 40.0  # logarithm of a limit that is none, and whose square is still a number
_BESIDE = 0.03  # [s] beside the ramps, to begin with
_SLOPE_STEP = 1e-5  # of a logarithm, of a slope of a time with accelerations that build up
_SAME = 9  # digits in which two moves are one
_ITS_OWN = 0.9  # [1] of its own time, by which a move tells its limits alone
_NO_LIMIT, _NEEDED = (
    20.0,
    1e-3,
)  # logarithm of a limit that is none, and sum of shares of times that needs one
_SHOWN = 0.5 * math.exp(_NO_LIMIT)  # [rad/s | rad/s²] a limit that is larger is none
_STARTS = (
    (1.02, 1.3),
    (1.2, 1.3),
    (1.02, 4.0),
    (1.3, 4.0),
)  # times the least speeds and accelerations that can be


def limits_from_times(
    turned: Floats, share: Floats, ramps: Floats, sim: Floats, stops: Mask, together: bool = False
) -> AxisLimits | None:
    """The axes' limits that give joint moves their simulated times `sim` (n,) [s]; None where none do.

    `turned` (n, k) [rad] without sign; `share`, `ramps` (n,) [1] of the rated speeds and accelerations. In one law all
    limits hold at once for the synchronous axes, in the other, which is not tried for axes that go `together`, the
    slowest axis takes its own time. Where neither fits,
    a time beside the ramps may be in all of them: a moving average, or what a stop takes; or accelerations build up in
    such a time, of which slow moves spend a part, with or without a time at stops; or no ramp is shorter. Moves between
    two exact `stops` (n,) tell them: how long a rounded move takes hangs on its corners, too. All moves do only where
    the limits of those are not most moves'.
    """
    moving = np.isfinite(sim) & (sim > 0) & np.isfinite(turned).all(axis=1) & (turned.max(axis=1) > 1e-6)
    plain = moving & stops
    found = _limits_told_by(plain, moving, turned, share, ramps, sim, together)
    if (
        found is None
        or found.confirmed.sum() < _OF_ALL * moving.sum()
        or _rounds_nothing(found, moving & ~plain)
    ):
        found = _limits_told_by(moving, moving, turned, share, ramps, sim, together)
    return found


def _rounds_nothing(found: AxisLimits, others: Mask) -> bool:
    """Whether the moves at rounded corners take as long as between stops: then they tell limits, too, that no move
    between stops reaches."""
    return bool(others.any() and (np.abs(found.off[others]) <= _OFF).mean() >= _OF_ALL)


def _limits_told_by(
    told: Mask, moving: Mask, turned: Floats, share: Floats, ramps: Floats, sim: Floats, together: bool
) -> AxisLimits | None:
    """The limits behind the times of the moves `told`, and what they say of all that are `moving`."""
    if told.sum() < _ENOUGH_MOVES:
        return None
    per_speed, per_ramp = (
        turned / share[:, None],
        turned / ramps[:, None],
    )  # the less, the quicker an axis is done
    least = np.concatenate(
        [(per_speed / sim[:, None])[told].max(axis=0), (4.0 * per_ramp / sim[:, None] ** 2)[told].max(axis=0)]
    )
    turns = np.nonzero(least[: turned.shape[1]] > 1e-9)[0]
    per_speed, per_ramp = per_speed[:, turns], per_ramp[:, turns]
    least = least.reshape(2, -1)[:, turns]
    best: tuple[float, Floats, AxisLaw, int] | None = None
    digits = max(0.5 * last_digit(sim[told]), _DIGITS)
    one = np.unique(
        np.round(np.concatenate([per_speed, per_ramp], axis=1)[told], _SAME), axis=0, return_index=True
    )[1]
    for times, builds, least_ramp in _TIMES_BESIDE:
        plainer = best
        for law in (
            AxisLaw(at_once, builds, least_ramp) for at_once in ((True,) if together else (True, False))
        ):
            for start in _STARTS:
                logs = np.append(np.log(least * np.array(start)[:, None]).ravel(), [np.log(_BESIDE)] * times)
                found = _limits_fitted(logs, per_speed[told], per_ramp[told], sim[told], law)
                off = np.abs(np.expm1(_over(found, per_speed[told], per_ramp[told], sim[told], law)[0]))
                misfit = float(np.quantile(off, _OF_ALL))
                beyond = int(((off * sim[told])[one] > 1.02 * digits).sum())
                as_near = 1.0 if best is None or best[2] == law else _NEARER
                if best is plainer and plainer is not None and plainer[0] <= _OFF:
                    # Moves that a plainer law misses by more than their digits are as good as a nearer law.
                    as_near = 1.0 if plainer[3] - beyond >= _FOR_A_TIME else _MUCH_NEARER
                if best is None or misfit < as_near * best[0]:
                    best = misfit, found, law, beyond
        if best is not None and best[0] <= _EXACT:
            break
    if best is None or best[0] > _OFF:
        return None
    _, logs, law, _ = best
    logs = _without_idle(logs, per_speed[told], per_ramp[told], sim[told], law)
    off, (fastest, strongest), _ = _over(logs, per_speed, per_ramp, np.where(moving, sim, 1.0), law)
    off = np.where(moving, np.expm1(off), np.nan)
    speeds, accelerations, beside, built, shortest = _apart(logs, len(turns), law)
    at = np.arange(len(sim))
    leading = turns[fastest]
    with np.errstate(divide="ignore", invalid="ignore"):
        pace = np.where(moving, speeds[fastest] / per_speed[at, fastest], np.nan)
        ramp = np.where(moving, accelerations[strongest] / per_ramp[at, strongest], np.nan)
    sure = told.copy()
    sure[told] = _confirmed(logs, per_speed[told], per_ramp[told], sim[told], law)
    shown = np.isin(fastest, fastest[sure]) & np.isin(strongest, strongest[sure])
    sure |= moving & ~told & shown & (off >= -_OFF)
    way = turned[at, leading]
    whole = np.full((2, turned.shape[1]), np.inf)
    for row, limits, active in ((0, speeds, fastest), (1, accelerations, strongest)):
        sets = np.unique(active[sure])
        whole[row, turns[sets]] = limits[sets]
    return AxisLimits(
        *(whole[0], whole[1], leading, pace * way, ramp * way, sure, off),
        together=law.together,
        beside=beside,
        built=built,
        shortest=shortest,
    )


class AxisLaw(NamedTuple):
    """How the limits of axes make the time of a joint move."""

    together: bool  # all hold at once; False: the slowest axis takes its own time
    builds: bool = False  # accelerations build up in the first time beside the limits
    least_ramp: bool = False  # no ramp is shorter than the first time; neither: that time is added


def _apart(logs: Floats, width: int, law: AxisLaw) -> tuple[Floats, Floats, float, float, float]:
    """Speeds and accelerations (k,), [s] beside the ramps, [s] in which they build up and [s] that they take at least,
    of their logarithms: (2k,) of the limits, then of the times."""
    numbers = np.exp(np.clip(logs, -_FAR, _FAR))  # a step of the fit may lead to a limit that is none
    times = numbers[2 * width :].tolist()
    built = times.pop(0) if law.builds else 0.0
    shortest = times.pop(0) if law.least_ramp else 0.0
    return numbers[:width], numbers[width : 2 * width], sum(times), built, shortest


def _confirmed(logs: Floats, per_speed: Floats, per_ramp: Floats, sim: Floats, law: AxisLaw) -> Mask:
    """(n,) moves whose times the others foretell: a move that alone sets a limit would take as long at another speed
    with other ramps, however often it is repeated. By the leverage of each (D. Hoaglin, R. Welsch, American
    Statistician 32, 1978) among the different ones whose times the limits give: what is odd shows nothing of others.
    """
    width, at = per_speed.shape[1], np.arange(len(sim))
    off, sets, slopes = _over(logs, per_speed, per_ramp, sim, law)
    columns = np.zeros((len(sim), len(logs)))
    columns[at, sets[0]] = slopes[0]
    columns[at, width + sets[1]] += slopes[1]
    columns[:, 2 * width :] = slopes[2]
    agree = np.abs(np.expm1(off)) <= _OFF
    same = np.round(np.concatenate([per_speed, per_ramp, sim[:, None]], axis=1), _SAME)
    _, first, which = np.unique(same, axis=0, return_index=True, return_inverse=True)
    basis, size, _ = np.linalg.svd((columns * agree[:, None])[first], full_matrices=False)
    own = (basis[:, size > _OFF] ** 2).sum(axis=1)[which.ravel()]
    return np.asarray(agree & (own < _ITS_OWN))


def _without_idle(logs: Floats, per_speed: Floats, per_ramp: Floats, sim: Floats, law: AxisLaw) -> Floats:
    """The limits, without those that the times do not need: a quick move would just allow them."""

    def off(tried: Floats) -> float:
        return float(np.abs(_over(tried, per_speed, per_ramp, sim, law)[0]).sum())

    width = per_speed.shape[1]
    order = np.argsort(np.bincount(_over(logs, per_speed, per_ramp, sim, law)[1][0], minlength=width))
    for axis in order.tolist():
        for limit in (axis, width + axis):
            freed = logs.copy()
            freed[limit] = _NO_LIMIT
            if off(freed) <= off(logs) + _NEEDED:
                logs = freed
    return logs


def _over(
    logs: Floats, per_speed: Floats, per_ramp: Floats, sim: Floats, law: AxisLaw
) -> tuple[Floats, tuple[NDArray[np.intp], NDArray[np.intp]], tuple[Floats, Floats, Floats]]:
    """(n,) Logarithm of a move's time over the simulated one, the axes that set its speed and its ramp, and how much
    that logarithm changes with those of the two limits and of the times (n, t) beside them."""
    speeds, accelerations, beside, built, shortest = _apart(logs, per_speed.shape[1], law)
    paces, ramps = speeds / np.maximum(per_speed, 1e-12), accelerations / np.maximum(per_ramp, 1e-12)
    at = np.arange(len(sim))
    if law.together:
        fastest, strongest = np.argmin(paces, axis=1), np.argmin(ramps, axis=1)
    else:
        fastest = strongest = np.argmax(_durations(paces, ramps, built, shortest), axis=1)
    pace, ramp = paces[at, fastest], ramps[at, strongest]
    bare = _durations(pace, ramp, built, shortest)
    time = bare + beside
    of_times = [beside / time]
    if law.builds or law.least_ramp:
        up = np.exp(_SLOPE_STEP)
        longer = built * up, shortest * up
        more = (
            (pace * up, ramp, built, shortest),
            (pace, ramp * up, built, shortest),
            (pace, ramp, *longer),
        )
        one, two, three = ((_durations(*numbers) - bare) / (time * _SLOPE_STEP) for numbers in more)
        of_times = [three, *of_times][: len(logs) - 2 * per_speed.shape[1]]
    else:
        full = pace**2 <= ramp
        cruise, speeding = 1.0 / pace, pace / ramp
        one = np.where(full, (speeding - cruise) / time, 0.0)
        two = np.where(full, -speeding, -1.0 / np.sqrt(ramp)) / time
        of_times = of_times[: len(logs) - 2 * per_speed.shape[1]]
    return np.log(time / sim), (fastest, strongest), (one, two, np.array(of_times).reshape(-1, len(sim)).T)


def _durations(pace: Floats, ramp: Floats, built: float, shortest: float) -> Floats:
    """[s] of moves over 1 at a `pace` [1/s] and a `ramp` [1/s²] that is `built` up in a time [s], or where a ramp takes
    the `shortest` time [s] at least."""
    if shortest:
        top = np.minimum(np.minimum(pace, np.sqrt(ramp)), 1.0 / shortest)
        ramp = np.minimum(ramp, top / shortest)
    if not built:
        return np.asarray(np.where(pace**2 <= ramp, 1.0 / pace + pace / ramp, 2.0 / np.sqrt(ramp)))
    reached = 2.0 / (built + np.sqrt(built**2 + 4.0 / ramp))
    peak = np.where(reached >= ramp * built, reached, np.cbrt(ramp / (4.0 * built)))
    top = np.minimum(pace, peak)
    over = np.where(top >= ramp * built, top / ramp + built, 2.0 * np.sqrt(top * built / ramp))
    return np.asarray(1.0 / top + over)


def _limits_fitted(logs: Floats, per_speed: Floats, per_ramp: Floats, sim: Floats, law: AxisLaw) -> Floats:
    """Logarithms of the limits near these, by Levenberg and Marquardt's steps; odd moves hardly count."""
    width, at, damping = per_speed.shape[1], np.arange(len(sim)), 1e-2
    off, sets, slopes = _over(logs, per_speed, per_ramp, sim, law)
    for _ in range(_LIMIT_ROUNDS):
        scale = max(float(np.median(np.abs(off))), 1e-5)
        weight = 1.0 / (1.0 + (off / (3.0 * scale)) ** 2)
        columns = np.zeros((len(sim), len(logs)))
        columns[at, sets[0]] = slopes[0]
        columns[at, width + sets[1]] += slopes[1]
        columns[:, 2 * width :] = slopes[2]
        normal, pull = columns.T @ (weight[:, None] * columns), -columns.T @ (weight * off)
        loss = float(np.sum(np.log1p((off / (3.0 * scale)) ** 2)))
        for _ in range(6):
            tried = logs + np.linalg.solve(
                normal + damping * (np.diag(np.diag(normal)) + 1e-6 * np.eye(len(logs))), pull
            )
            there = _over(tried, per_speed, per_ramp, sim, law)
            if float(np.sum(np.log1p((there[0] / (3.0 * scale)) ** 2))) < loss - 1e-9:
                logs, (off, sets, slopes) = tried, there
                damping = max(damping / 10.0, 1e-9)
                break
            damping *= 10.0
        else:
            break
    return logs
