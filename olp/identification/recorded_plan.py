"""Recorded moves as a plan, so that the model that times programs times them too: one law for both.

A diagnosis judges the recording's own simulation, or else these times.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from olp.core.source import Source
from olp.identification.diagnosis.case_making import JudgedTimes, Making, case_beside
from olp.identification.recording.moves import CIRCULAR, JOINT, LINEAR, WAIT, RecordedMoves
from olp.identification.signature.joint_moves import recorded_joint_moves
from olp.identification.signature.moveset import joint_ends, with_points
from olp.identification.signature.stretch_times import zones
from olp.identification.signature.stretches import stretches_of
from olp.ir.program import Path
from olp.languages.vendor import blending_of
from olp.robots.controller_effects import generations_in
from olp.runtime.paths import shape_paths, turn_between
from olp.runtime.plan import PATHS, USUAL_LAW, BlendCode, MoveConditions, Moves, Plan, Positions, StepKind
from olp.runtime.recorder import Extra, beyond_targets
from olp.timing.arm_prior import arm_prior
from olp.timing.blending.law import load_law

if TYPE_CHECKING:
    from olp.identification.recording.recording import Recording
    from olp.robots.geometry import Pose
    from olp.robots.model import Robot

Floats = NDArray[np.float64]
Mask = NDArray[np.bool_]

_PATH: Final = {JOINT: Path.JOINT, LINEAR: Path.LINEAR, CIRCULAR: Path.CIRCULAR}
_WAIT_COLUMN: Final = "wait_s"


class UnlearntTimes(NamedTuple):
    """What olp's own model says of n recorded moves, nothing learnt; nan where it cannot tell."""

    duration: Floats  # (n,) [s]
    stop: Floats  # (n,) [s] of it, what the exact stop at the end costs at any speed
    assumptions: tuple[str, ...]


def unlearnt_times(recording: Recording) -> UnlearntTimes:
    """As `olp time` times a program of these moves; joint moves of an arm without a name by the arms of the library.

    Raises OlpError for a robot file that the model cannot use.
    """
    from olp.timing.timing import time_plan

    timing = time_plan(plan_of_recording(recording))
    duration, stop = timing.duration_s.copy(), timing.stop_s.copy()
    if recording.robot is None:
        moves = recording.moves
        axes = tuple(f"q{i + 1}" for i in range(moves.joints_start.shape[1]))
        law = arm_prior(None, generations_in(recording.settings.controller), axes)
        joints, rows = recorded_joint_moves(moves, None, None, len(axes))
        duration[rows] = law.durations(joints.motions)
        stop[rows] = np.minimum(law.stop, duration[rows])
    return UnlearntTimes(duration, stop, tuple(dict.fromkeys(a.says for a in timing.assumptions)))


def plan_of_recording(recording: Recording) -> Plan:
    """One step per row: moves with their circumstances, waits as long as `wait_s` says (nan: not known).

    A corner that no row goes on from is an exact stop. A row lacking points, joints or a speed has unknown ones here.
    """
    robot = _as_recorded(recording)
    moves = with_points(recording.moves, recording.robot, recording.tool)
    count = len(moves)
    waits = moves.kind == WAIT
    driven = np.flatnonzero(~waits)
    positions = _positions(moves.take(driven), robot, recording.tool)
    row = np.zeros(count, dtype=np.int32)
    row[driven], row[waits] = np.arange(len(driven)), np.arange(int(waits.sum()))
    law = _law(moves, robot)
    positions, columns = _columns(moves, driven, positions, robot, law)
    written = moves.covariates.get(_WAIT_COLUMN, np.full(count, np.nan))
    return Plan(
        sources=(Source(recording.path, b"", "utf-8", ()),),
        robot=robot,
        mechanisms=("RB1",),
        kind=np.where(waits, StepKind.WAIT, StepKind.MOVE).astype(np.int8),
        row=row,
        source=np.zeros(count, dtype=np.int16),
        line=np.zeros(count, dtype=np.int32),
        moves=columns,
        durations=written[waits],
        positions=positions,
        robots=(robot,),
        zone_law=law,
        conditions=_conditions(moves, driven),
    )


def _as_recorded(recording: Recording) -> Robot | None:
    """The robot with the controller that the recording names."""
    robot, told = recording.robot, generations_in(recording.settings.controller)
    return robot if robot is None or not told else replace(robot, controllers=told)


def _law(moves: RecordedMoves, robot: Robot | None) -> str:
    """The blending law of position levels where there are any, else that of the maker's programs."""
    if (moves.level > 0).any() or robot is None:
        return USUAL_LAW
    return blending_of(robot.maker) or USUAL_LAW


def _positions(moves: RecordedMoves, robot: Robot | None, tool: Pose | None) -> Positions:
    """Start and end of each move in turn: (2m,) rows. Only a known tool's pose tells the axes of paths."""
    from olp.robots.geometry import quaternion_from_rotation, rotation_from_angles

    count = len(moves)
    place = _alternating(moves.start, moves.end)
    angles = _alternating(moves.start_angles, moves.end_angles)
    turned = np.full((2 * count, 4), np.nan)
    known = np.isfinite(angles).all(axis=1)
    if known.any():
        turned[known] = quaternion_from_rotation(rotation_from_angles(angles[known]))
    axes = np.full((2 * count, max(6, moves.joints_start.shape[1])), np.nan)
    if robot is not None:
        first, last = joint_ends(moves, robot, tool)
        axes = np.full((2 * count, max(6, len(robot.axes))), np.nan)
        axes[:, : first.shape[1]] = _alternating(first, last)
        if tool is None:  # the points of paths may be those of any tool
            guessed = np.repeat((moves.kind != JOINT) & ~moves.has_joints, 2)
            axes[guessed] = np.nan
        _orient(turned, axes[:, : len(robot.axes)], robot, tool)
    return Positions(place, turned, axes)


def _alternating(start: Floats, end: Floats) -> Floats:
    """(2m, k) of starts and ends (m, k)."""
    return np.stack([start, end], axis=1).reshape(2 * len(start), start.shape[1])


def _orient(turned: Floats, axes: Floats, robot: Robot, tool: Pose | None) -> None:
    """Puts orientations that no angles tell, but the axes do, into `turned`."""
    from olp.robots.geometry import quaternion_from_rotation
    from olp.robots.kinematics.configuration import forward

    lacking = np.isnan(turned).any(axis=1) & np.isfinite(axes).all(axis=1)
    if robot.geometry is None or not lacking.any():
        return
    _, rotation = forward(robot, axes[lacking])
    turned[lacking] = quaternion_from_rotation(rotation if tool is None else rotation @ tool.rotation)


def _columns(
    moves: RecordedMoves, driven: NDArray[np.intp], positions: Positions, robot: Robot | None, law: str
) -> tuple[Positions, Moves]:
    """The rows `driven` (m,) as moves of a plan, and the positions with those that shape arcs."""
    own = moves.take(driven)
    count, joint = len(own), own.kind == JOINT
    code, blend = _blends(moves, driven, robot, law)
    by_tool = np.isnan(own.speed_fraction) & np.isfinite(own.speed)
    fraction = np.where(np.isfinite(own.speed_fraction), own.speed_fraction, 1.0)
    scale = np.where(np.isfinite(own.acceleration_fraction), own.acceleration_fraction, 1.0)
    scale = np.where(
        joint | ~np.isfinite(own.acceleration), scale, 1.0
    )  # a written acceleration is the whole of it
    nothing = np.full(count, np.nan)
    even = np.arange(count, dtype=np.int32) * 2
    columns = Moves(
        start=even,
        target=even + 1,
        via=np.full(count, -1, dtype=np.int32),
        before=np.zeros(count, dtype=bool),
        mechanism=np.zeros(count, dtype=np.int16),
        path=np.array([PATHS.index(_PATH[kind]) for kind in own.kind.tolist()], dtype=np.int8),
        fraction=np.where(joint & ~by_tool, fraction, np.nan),
        travel=np.where(joint & ~by_tool, np.nan, own.speed),
        turn=nothing,
        acceleration=scale,
        deceleration=scale,
        blend_code=code,
        blend=blend,
        length=nothing,
        angle=turn_between(positions.quaternion[even], positions.quaternion[even + 1]),
        axis_speed=nothing,
        duration=nothing,
        rate=np.where(joint, np.nan, own.acceleration),
    )
    return _shaped(own, columns, positions)


def _blends(
    moves: RecordedMoves, driven: NDArray[np.intp], robot: Robot | None, law: str
) -> tuple[NDArray[np.int8], Floats]:
    """How each row ends, and the size of its rounding [m]."""
    rolls = stretches_of(moves).ends_rolling[driven]
    zone = zones(moves, robot)[driven]
    sized = BlendCode.RADIUS if load_law(law).share_zones else BlendCode.ZONE
    rounded = np.where(np.nan_to_num(zone) > 0, sized, BlendCode.UNTAGGED)
    return np.where(rolls, rounded, BlendCode.EXACT).astype(np.int8), np.where(rolls, zone, np.nan)


def _shaped(own: RecordedMoves, moves: Moves, positions: Positions) -> tuple[Positions, Moves]:
    """With the arcs' circles and all lengths; of an arc whose circle three points do not tell nothing is known."""
    arcs = np.flatnonzero(own.kind == CIRCULAR)
    extras = {row: Extra(via=len(positions) + i) for i, row in enumerate(arcs.tolist())}
    if len(arcs):
        blank = np.full((len(arcs), positions.axes.shape[1]), np.nan)
        turned = positions.quaternion[moves.start[arcs]]
        positions = Positions(
            np.concatenate([positions.position, own.via[arcs]]),
            np.concatenate([positions.quaternion, turned]),
            np.concatenate([positions.axes, blank]),
        )
    positions, moves, third = beyond_targets(positions, moves, extras)
    lost = np.array([row for row in arcs.tolist() if row not in third], dtype=np.intp)
    path = moves.path.copy()
    path[lost] = PATHS.index(Path.LINEAR)
    moves = replace(moves, path=path)
    via, before, length = shape_paths(moves, positions, np.ones(len(moves), dtype=bool), third)
    bent = lost[~_straight(own, lost)]
    length[bent] = np.nan
    return positions, replace(moves, via=via, before=before, length=length)


def _straight(own: RecordedMoves, rows: NDArray[np.intp]) -> Mask:
    """(r,) whether the middle point of these arcs lies between their ends: then they are lines."""
    first, second = own.via[rows] - own.start[rows], own.end[rows] - own.via[rows]
    return np.asarray(np.sum(first * second, axis=1) > 0)


def _conditions(moves: RecordedMoves, driven: NDArray[np.intp]) -> MoveConditions:
    return MoveConditions(moves.played[driven], moves.payload[driven], moves.payload_inertia[driven])


def case_of(recording: Recording) -> Making:
    """All measured moves whose simulated duration is known or can be predicted. Raises OlpError N010."""
    notes = list[str]()
    return case_beside(recording, _judged(recording, notes), notes)


def _judged(recording: Recording, notes: list[str]) -> JudgedTimes:
    moves = recording.moves
    if np.isfinite(moves.sim).any():
        return JudgedTimes(moves.sim, np.zeros(len(moves)), own=False)
    own = unlearnt_times(recording)
    notes.append("no sim_s: olp's own prediction is judged, which `olp time` gives, too")
    notes.extend(f"olp's own prediction: {says}" for says in own.assumptions)
    return JudgedTimes(own.duration, own.stop, own=True)
