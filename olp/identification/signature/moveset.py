"""Straight moves as the estimators see them: columns in SI, whether they come from a recording or from a plan.

Where the robot allows it, missing points are computed from joints, and missing joints from points.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from olp.identification.recording.moves import RecordedMoves
    from olp.identification.recording.recording import Recording
    from olp.robots.geometry import Pose
    from olp.robots.model import Robot

Floats = NDArray[np.float64]


def with_points(moves: RecordedMoves, robot: Robot | None, tool: Pose | None) -> RecordedMoves:
    """Rows with joint points alone get the tool's, at the flange where no tool is told.

    Not of arcs then: no circle goes through the flange at both ends and the tool in the middle.
    """
    lacking = moves.has_joints & ~moves.has_points & ~middle_alone(moves, tool)
    if not lacking.any() or not _fits(moves, robot):
        return moves
    assert robot is not None
    start, end, first, last = (
        a.copy() for a in (moves.start, moves.end, moves.start_angles, moves.end_angles)
    )
    for joints, points, angles in ((moves.joints_start, start, first), (moves.joints_end, end, last)):
        points[lacking], angles[lacking] = _pose(robot, joints[lacking], tool)
    return replace(moves, start=start, end=end, start_angles=first, end_angles=last)


def middle_alone(moves: RecordedMoves, tool: Pose | None) -> NDArray[np.bool_]:
    """(n,) arcs of which the tool's middle point is told, the ends by joints alone, and the tool not at all."""
    from olp.identification.recording.moves import CIRCULAR

    told = np.isfinite(moves.via).all(axis=1) & moves.has_joints & ~moves.has_points
    return np.asarray((moves.kind == CIRCULAR) & told & (tool is None))


def joint_ends(moves: RecordedMoves, robot: Robot | None, tool: Pose | None) -> tuple[Floats, Floats]:
    """(n, k) [rad | m] at both ends; nan where neither joints nor a reachable pose are told.

    A pose is reached as everywhere in a signature: as `configuration` says, else in front, elbow up; wrist not flipped.
    """
    if robot is None:
        return np.full((2, len(moves), 0), np.nan)[0], np.full((len(moves), 0), np.nan)
    if _fits(moves, robot):
        start, end = moves.joints_start.copy(), moves.joints_end.copy()
    else:
        start, end = (np.full((len(moves), len(robot.axes)), np.nan) for _ in range(2))
    lacking = ~(np.isfinite(start).all(axis=1) & np.isfinite(end).all(axis=1)) & moves.has_points
    lacking &= np.isfinite(moves.start_angles).all(axis=1) & np.isfinite(moves.end_angles).all(axis=1)
    if lacking.any() and robot.geometry is not None and robot.geometry.links is not None:
        flags = posture_flags(moves.texts.get("configuration", ("",) * len(moves)))[lacking]
        start[lacking] = _reach(robot, moves.start[lacking], moves.start_angles[lacking], flags, tool)
        end[lacking] = _reach(robot, moves.end[lacking], moves.end_angles[lacking], flags, tool)
    return start, end


def posture_flags(configuration: tuple[str, ...]) -> NDArray[np.int64]:
    """(n, 6) of RCONF: elbow, and front or back; 0 where a `configuration` is another word."""
    flags = np.zeros((len(configuration), 6), dtype=np.int64)
    for row, text in enumerate(configuration):
        digits = text.replace(",", "").replace(" ", "")
        if len(digits) >= 6 and set(digits) <= {"0", "1"}:
            flags[row, 1:3] = int(digits[1]), int(digits[2])
    return flags


def _fits(moves: RecordedMoves, robot: Robot | None) -> bool:
    return robot is not None and len(moves.slides) == len(robot.axes) and robot.geometry is not None


def _pose(robot: Robot, joints: Floats, tool: Pose | None) -> tuple[Floats, Floats]:
    from olp.robots.geometry import angles_from_rotation
    from olp.robots.kinematics.configuration import forward, with_tool

    position, rotation = forward(robot, joints)
    if tool is not None:
        position, rotation = with_tool(position, rotation, tool)
    return position, np.asarray(angles_from_rotation(rotation))


def _reach(
    robot: Robot, points: Floats, angles: Floats, flags: NDArray[np.int64], tool: Pose | None
) -> Floats:
    from olp.robots.geometry import rotation_from_angles
    from olp.robots.kinematics.configuration import without_tool
    from olp.robots.kinematics.inverse import inverse

    position, rotation = points, rotation_from_angles(angles)
    if tool is not None:
        position, rotation = without_tool(position, rotation, tool)
    joints, reached = inverse(robot, position, rotation, flags)
    joints[~reached] = np.nan
    return joints


Mask = NDArray[np.bool_]

# [m], [rad] Points nearer than this are one start point.
_SAME_PLACE = 1e-3


@dataclass(frozen=True, slots=True, eq=False)
class MoveSet:
    """n straight moves from stop to stop; nan where something is not known.

    `duration` [s] is nan for moves to predict. `nominal` [m/s²]: the simulation's acceleration. `program`: label of
    the program a move belongs to; errors within one are correlated.
    """

    start: Floats  # (n, 3) [m] tool centre point in the robot's base frame
    end: Floats  # (n, 3) [m]
    rotation: Floats  # (n, 3, 3) of the tool, at the start
    speed: Floats  # (n,) [m/s] programmed
    nominal: Floats  # (n,) [m/s²]
    duration: Floats  # (n,) [s]
    payload: Floats  # (n,) [kg]
    configuration: tuple[str, ...]  # (n,) posture of the arm, "" where not told
    program: tuple[str, ...]  # (n,)
    tool: Pose | None = None  # on the flange, None where it is not told
    joints: Floats | None = None  # (n, 2, k) [rad] axes at start and end; nan or None where not told

    def __len__(self) -> int:
        return len(self.speed)

    @property
    def length(self) -> Floats:
        """(n,) [m]"""
        result: Floats = np.linalg.norm(self.end - self.start, axis=1)
        return result

    @property
    def direction(self) -> Floats:
        """(n, 3) unit vectors."""
        way = self.length[:, None]
        return np.asarray((self.end - self.start) / np.where(way > 0, way, 1.0))

    @property
    def start_labels(self) -> NDArray[np.int64]:
        """(n,) one number per start point, in the order of first use."""
        places = np.round(self.start / _SAME_PLACE).astype(np.int64)
        order: dict[tuple[int, ...], int] = {}
        return np.array([order.setdefault(tuple(p), len(order)) for p in places.tolist()], dtype=np.int64)

    @property
    def usable(self) -> Mask:
        """(n,) moves whose time a signature can say: a way, a speed, both points."""
        finite = np.isfinite(self.start).all(axis=1) & np.isfinite(self.end).all(axis=1)
        return np.asarray(finite & np.isfinite(self.speed) & (np.nan_to_num(self.length) > 0))

    def take(self, which: NDArray[np.bool_] | NDArray[np.int64]) -> MoveSet:
        """The moves of a mask or of row numbers."""
        rows = np.nonzero(which)[0] if which.dtype == np.bool_ else which
        return MoveSet(
            self.start[rows],
            self.end[rows],
            self.rotation[rows],
            self.speed[rows],
            self.nominal[rows],
            self.duration[rows],
            self.payload[rows],
            tuple(self.configuration[i] for i in rows.tolist()),
            tuple(self.program[i] for i in rows.tolist()),
            self.tool,
            None if self.joints is None else self.joints[rows],
        )


def moves_of_recording(
    recording: Recording, stops: bool = True, kinds: tuple[str, ...] = ("linear",)
) -> tuple[MoveSet, NDArray[np.int64]]:
    """The straight moves of a recording, and the row of each in `recording.moves`.

    Left out: moves of another kind, without points or speed, and, with `stops`, moves that do not run from exact stop
    to exact stop. Curves among `kinds` are told by their chords.
    """
    from olp.identification.signature.stretches import stretches_of
    from olp.robots.geometry import rotation_from_angles

    moves = with_points(recording.moves, recording.robot, recording.tool)
    known = np.array([kind in kinds for kind in moves.kinds], dtype=bool)
    known &= moves.has_points & np.isfinite(moves.speed)
    if stops:
        known &= moves.stops & ~stretches_of(moves).begins_rolling
    known &= np.nan_to_num(moves.chord) > 0
    rows = np.nonzero(known)[0].astype(np.int64)
    turned = np.isfinite(moves.start_angles[rows]).all(axis=1)
    rotation = np.full((len(rows), 3, 3), np.nan)
    if turned.any():
        rotation[turned] = rotation_from_angles(moves.start_angles[rows][turned])
    joints = np.stack([moves.joints_start[rows], moves.joints_end[rows]], axis=1)
    postures = moves.texts.get("configuration", ("",) * len(moves))
    return (
        MoveSet(
            start=moves.start[rows],
            end=moves.end[rows],
            rotation=rotation,
            speed=(moves.speed * moves.played)[rows],
            nominal=moves.acceleration[rows],
            duration=moves.duration[rows],
            payload=moves.payload[rows],
            configuration=tuple(postures[i] for i in rows.tolist()),
            program=tuple(moves.job[i] for i in rows.tolist()),
            tool=recording.tool,
            joints=joints if np.isfinite(joints).any() and not any(moves.slides) else None,
        ),
        rows,
    )


def direction_labels(moves: MoveSet) -> NDArray[np.int64]:
    """(n,) towards the base 0, away 1, down 2, up 3: the tests of the thesis, and their opposite."""
    x, z = moves.direction[:, 0], moves.direction[:, 2]
    upright = np.abs(z) > np.abs(x)
    return np.where(upright, 2 + (z > 0), (x > 0).astype(np.int64)).astype(np.int64)
