"""What a timing signature says of a plan's moves: their corrected acceleration, stops and corners.

Code: H013 a motion model that a signature does not hold for.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from olp.ir.program import Path
from olp.runtime.plan import PATHS, Plan

if TYPE_CHECKING:
    from collections.abc import Callable

    from olp.identification.signature.document import Signature
    from olp.identification.signature.moveset import MoveSet
    from olp.identification.signature.predict import Prediction
    from olp.identification.signature.term_model import PredictedRows
    from olp.timing.chain import Chain
    from olp.timing.demand import Demand
    from olp.timing.joint_times import TimedJoints

Floats = NDArray[np.float64]
Mask = NDArray[np.bool_]
_STRAIGHT, _JOINT = PATHS.index(Path.LINEAR), PATHS.index(Path.JOINT)
_SAME = 1e-5  # [m] moves nearer than this are one move that runs again


class Signed(NamedTuple):
    """`rows` (m,) of Moves whose acceleration the signature told, and what it said of them, curves by their chords.

    `joints` (k,): mask of Moves, joint moves of the signature's robot. `told`: whole moves, by their rows of Moves,
    whose time a diagnosis' terms told, see correction_terms.py.
    """

    rows: NDArray[np.intp]
    signature: Signature
    said: Prediction | None
    again: NDArray[np.intp]  # (m,) which distinct move each row is: errors of repeats are the same error
    joints: Mask
    told: PredictedRows | None = None
    timed: TimedJoints | None = None  # joint moves that the law of the arm timed


def axis_scale(signature: Signature | None) -> float:
    """[1] by which the axes of the arm take longer to reach their speed than olp's model says."""
    if signature is None:
        return 1.0
    from olp.identification.signature.coefficients import JOINT, value_of

    return value_of(signature.parts, JOINT, "acceleration_time_scale")


def sign(plan: Plan, wanted: Demand, signature: Signature, report: Callable[[str], None]) -> Signed:
    """Puts the corrected acceleration into `wanted`, scaled by ACC= and DEC=. Raises OlpError (see predict)."""
    from olp.identification.signature.coefficients import CIRCULAR, value_of
    from olp.identification.signature.predict import predict, robot_of

    robot_of(signature, plan.robot)
    moves, positions = plan.moves, plan.positions
    arm = np.array([robot is not None and robot is plan.robot for robot in plan.robots], dtype=bool)
    own = arm[moves.mechanism] if len(arm) else np.zeros(len(moves), dtype=bool)
    mine = (
        own & (moves.path != _JOINT) & wanted.metric & ~wanted.unknown & ~wanted.slowed & (wanted.rule == 0)
    )
    mine &= (wanted.length > 0) & np.isfinite(moves.travel)
    known = np.asarray(np.isfinite(positions.position).all(axis=1))
    mine &= known[moves.start] & known[moves.target]
    chord = np.linalg.norm(positions.position[moves.target] - positions.position[moves.start], axis=1)
    mine &= np.nan_to_num(chord) > _SAME
    joints = own & (moves.path == _JOINT) & ~wanted.unknown & (wanted.length > 0)
    rows = np.nonzero(mine)[0]
    if not len(rows):
        report("the signature times none of the paths: none is of the arm and has known points")
        return Signed(rows, signature, None, rows, joints)
    asked = _asked(plan, wanted, signature, rows)
    said = predict(signature, asked, plan.robot)
    if signature.knows_paths:
        curved = moves.path[rows] != _STRAIGHT
        push = said.acceleration / np.where(
            curved, value_of(signature.parts, CIRCULAR, "acceleration_time_scale"), 1.0
        )
        wanted.acceleration[rows] = push * moves.acceleration[rows]
        wanted.deceleration[rows] = push * moves.deceleration[rows]
    outside = [(row, reason) for row, reason in zip(rows.tolist(), said.reasons, strict=True) if reason]
    if outside:
        report(f"{len(outside)} of {len(rows)} paths are outside what the signature learnt: {outside[0][1]}")
    keys = np.round(np.concatenate([asked.start, asked.end, asked.speed[:, None]], axis=1) / _SAME)
    again = np.unique(keys, axis=0, return_inverse=True)[1].reshape(-1)
    return Signed(rows, signature, said, again, joints)


def _asked(plan: Plan, wanted: Demand, signature: Signature, rows: NDArray[np.intp]) -> MoveSet:
    """The moves of these rows, curves by their chords."""
    from olp.identification.signature.moveset import MoveSet
    from olp.robots.geometry import Pose, rotation_from_quaternion

    moves, positions = plan.moves, plan.positions
    start, end = positions.position[moves.start[rows]], positions.position[moves.target[rows]]
    turned = positions.quaternion[moves.start[rows]]
    rotation = np.full((len(rows), 3, 3), np.nan)
    told = np.asarray(np.isfinite(turned).all(axis=1))
    if told.any():
        rotation[told] = rotation_from_quaternion(turned[told])
    nothing = np.full(len(rows), np.nan)
    return MoveSet(
        start=start,
        end=end,
        rotation=rotation,
        speed=wanted.speed[rows],
        nominal=wanted.acceleration[rows],
        duration=nothing,
        payload=nothing,
        configuration=("",) * len(rows),
        program=(plan.path,) * len(rows),
        tool=None if signature.tool is None else Pose.from_xyz_angles(signature.tool),
        joints=np.stack([positions.axes[moves.start[rows]], positions.axes[moves.target[rows]]], axis=1),
    )


def settled(plan: Plan, signed: Signed, exact: Mask, settling: float) -> Floats:
    """(k,) [s] per row of Moves that an exact stop takes: what was learnt, and `settling` where nothing was."""
    from olp.identification.signature.coefficients import CIRCULAR, JOINT, STOP, value_of

    parts = signed.signature.parts
    result = np.where(exact, settling, 0.0)
    told = np.zeros(len(exact), dtype=bool)
    told[signed.rows] = signed.signature.knows_paths
    # Measured times end when the arm stands still: what settles is in the acceleration, or was learnt beside it.
    stop = value_of(parts, STOP, "fixed_time")
    curve = stop + value_of(parts, CIRCULAR, "fixed_time")
    result = np.where(told & exact, np.where(plan.moves.path == _STRAIGHT, stop, curve), result)
    if JOINT in parts:
        result = np.where(signed.joints & exact, parts[JOINT].value("fixed_time"), result)
    if signed.timed is not None:
        at = signed.timed.rows
        result[at] = np.where(exact[at], signed.timed.stop, 0.0)
    return result


def measured_stops(signed: Signed) -> Mask:
    """(k,) rows of Moves whose learnt times hold all that the controller adds to a stop already."""
    from olp.identification.signature.coefficients import JOINT

    result: Mask = signed.joints & (JOINT in signed.signature.parts)
    result[signed.rows] = signed.signature.knows_paths
    if signed.told is not None:
        result[signed.told.rows] = True
    if signed.timed is not None:
        result[signed.timed.rows] = True
    return result


def turn_corners(plan: Plan, signed: Signed, joined: Chain) -> Chain:
    """Corners as learnt, where the plan's corners follow the law that they were learnt of."""
    from olp.identification.signature.coefficients import CORNER

    part = signed.signature.parts.get(CORNER)
    if part is None or part.law != plan.zone_law:
        return joined
    rolling, first = corners_of(plan, signed, joined)
    saving = joined.saving.copy()
    rounded = joined.saving < 0  # of corners that replace the ends of their moves it is their time
    scaled = saving * np.where(rounded, 1.0, part.value("saving_scale")) - part.value("corner_time")
    saving = np.where(rolling, scaled, saving)
    last = first & ~rolling
    return replace(joined, saving=np.where(last, saving - part.value("stretch_time"), saving))


def corners_of(plan: Plan, signed: Signed, joined: Chain) -> tuple[Mask, Mask]:
    """(k,) rows of the arm that end rolling, and those that begin so."""
    mine = signed.joints.copy()
    mine[signed.rows] = True
    return mine & (joined.end_speed > 0), mine & (joined.start_speed > 0)
