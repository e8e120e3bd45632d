"""What the terms of a diagnosis say of a plan's moves: whole durations, corners and joint moves included."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from olp.identification.recording.moves import CIRCULAR, JOINT, LINEAR
from olp.identification.signature.correction import Signed
from olp.ir.program import Path
from olp.runtime.plan import PATHS, Plan
from olp.timing.chain import Chain
from olp.timing.demand import Demand
from olp.timing.path_law import USUAL_ACCELERATION

if TYPE_CHECKING:
    from collections.abc import Callable

    from olp.identification.recording import Recording
    from olp.identification.signature.term_model import NamedModel

Floats = NDArray[np.float64]
Mask = NDArray[np.bool_]
Rows = NDArray[np.intp]
_LINEAR, _CIRCULAR, _JOINT = (PATHS.index(path) for path in (Path.LINEAR, Path.CIRCULAR, Path.JOINT))
_SOME_ROUNDING = 1e-6  # [m] of a corner that nobody tells the size of
_AXES = frozenset({"joint-speed-limit", "orientation-limit"})  # terms that know what else slows a path


def by_terms(
    plan: Plan,
    wanted: Demand,
    joined: Chain,
    signed: Signed,
    overrides: Floats,
    report: Callable[[str], None],
) -> Signed:
    """`signed` with the rows that the signature's terms tell. Raises OlpError (see named_rows).

    `overrides` (m,) [1] of the rows of Moves.
    """
    from olp.identification.signature.coefficients import TERMS

    if TERMS not in signed.signature.parts:
        return signed
    from olp.identification.signature.term_model import terms_of, told_rows

    arm = np.array([robot is not None and robot is plan.robot for robot in plan.robots], dtype=bool)
    own = np.nonzero(arm[plan.moves.mechanism])[0] if len(arm) else np.zeros(0, dtype=np.intp)
    if not len(own):
        return signed
    named = terms_of(signed.signature)
    names = {part.term.name for part in named.model.parts}
    use = _usable(plan, wanted, own)
    if not names & _AXES:
        slow = use & (plan.moves.path[own] != _JOINT) & (wanted.slowed[own] | (wanted.rule[own] != 0))
        if slow.any():
            report(
                f"{int(slow.sum())} paths are slowed by an axis or by the tool's turn: olp's own model times them"
            )
        use &= ~slow
    told = told_rows(signed.signature, _recording(plan, joined, signed, named, own, use, overrides[own]))
    if told is None:
        return signed
    if "payload" in names and np.isfinite(named.payload):
        report(f"the arm carries {named.payload:g} kg, as in the recording of the signature")
    return signed._replace(told=told._replace(rows=own[told.rows]))


def by_paths(plan: Plan, wanted: Demand, joined: Chain, signed: Signed, overrides: Floats) -> Signed:
    """`signed` with the lines and arcs that `olp predict` would time by the law of paths, timed by it."""
    from olp.identification.signature.coefficients import TERMS
    from olp.identification.signature.path_moves import pieces_of
    from olp.identification.signature.rows import for_paths
    from olp.identification.signature.stretches import stretches_of
    from olp.identification.signature.term_model import PredictedRows, bare_recording

    paths, robot, moves = signed.signature.paths, plan.robot, plan.moves
    if paths is None or robot is None or TERMS in signed.signature.parts:
        return signed
    mine = np.array([r is robot for r in plan.robots], dtype=bool)[moves.mechanism]
    own = np.flatnonzero(mine & (wanted.unknown | (wanted.length > 0)))  # who stands still is in no recording
    use = _usable(plan, wanted, own) & (moves.path[own] != _JOINT)
    if not use.any():
        return signed
    path, axes = moves.path[own], plan.positions.axes[:, : len(robot.axes)]
    kind = np.where(path == _LINEAR, LINEAR, np.where(path == _JOINT, JOINT, CIRCULAR)).astype(np.int8)
    asked = np.where(moves.acceleration[own] == 1.0, np.nan, USUAL_ACCELERATION * moves.acceleration[own])
    rounding = np.where(moves.blend[own] > 0, moves.blend[own], _SOME_ROUNDING)
    columns = {
        "kind": kind,
        "start": plan.positions.position[moves.start[own]],
        "end": plan.positions.position[moves.target[own]],
        "via": _middles(plan, own),
        "joints_start": axes[moves.start[own]],
        "joints_end": axes[moves.target[own]],
        "speed": np.where(use, moves.travel[own], np.nan),
        "acceleration": np.where(np.isnan(moves.rate[own]), asked, moves.rate[own]),
        "blend": np.where(joined.end_speed[own] > 0, rounding, 0.0),
        "override": overrides[own],
    }
    recorded = bare_recording(len(own), columns, robot, None).moves
    stretches = stretches_of(recorded)
    pieces, rows = pieces_of(recorded, robot, stretches)
    good = for_paths(signed.signature, paths, recorded, stretches)[rows]
    pieces, rows = pieces.take(good), rows[good]
    if not len(rows):
        return signed
    duration = paths.predict(pieces)
    half = duration * float(np.expm1(paths.half))
    told = PredictedRows(own[rows], duration, half, np.ones(len(rows)), ("",) * len(rows))
    return signed._replace(told=told)


def _usable(plan: Plan, wanted: Demand, own: Rows) -> Mask:
    """(n,) of the arm's rows: moves that go somewhere and whose way the terms can follow."""
    moves = plan.moves
    known = ~wanted.unknown[own] & (wanted.length[own] > 0)
    arcs = (moves.path[own] == _CIRCULAR) & (moves.via[own] >= 0)
    return np.asarray(known & ((moves.path[own] == _LINEAR) | (moves.path[own] == _JOINT) | arcs))


def _recording(
    plan: Plan, joined: Chain, signed: Signed, named: NamedModel, own: Rows, use: Mask, override: Floats
) -> Recording:
    """The arm's rows one after another; those that are not in `use` are there for their neighbours."""
    from olp.identification.signature.term_model import bare_recording
    from olp.robots.geometry import Pose

    moves, positions, robot = plan.moves, plan.positions, plan.robot
    assert robot is not None
    path, start, end = moves.path[own], moves.start[own], moves.target[own]
    kind = np.where(path == _LINEAR, LINEAR, np.where(path == _JOINT, JOINT, CIRCULAR)).astype(np.int8)
    rolls = joined.end_speed[own] > 0
    # Of two rates the one that takes both their times: 2/a = 1/up + 1/down.
    rate = 2.0 / (1.0 / moves.acceleration[own] + 1.0 / moves.deceleration[own])
    # A corner without a tag is passed at full speed: it is rounded as far as braking would take.
    braking = np.nan_to_num((moves.travel[own] * override) ** 2 / (2.0 * named.linear * rate))
    rounding = np.where(moves.blend[own] > 0, moves.blend[own], np.maximum(braking, _SOME_ROUNDING))
    joint = kind == JOINT
    fraction = np.minimum(moves.fraction[own] * override, np.maximum(moves.fraction[own], 1.0))
    axes = positions.axes[:, : len(robot.axes)]
    still = np.where(use, 0.0, np.nan)[:, None]  # a row that the terms shall not tell has no known axes
    columns = {
        "kind": kind,
        "start": positions.position[start],
        "end": positions.position[end],
        "via": _middles(plan, own),
        "start_angles": _angles(positions.quaternion[start]),
        "end_angles": _angles(positions.quaternion[end]),
        "joints_start": axes[start] + still,
        "joints_end": axes[end] + still,
        "speed": np.where(use & ~joint, moves.travel[own] * override, np.nan),
        "speed_fraction": np.where(use & joint, fraction, np.nan),
        "acceleration": np.where(joint, np.nan, named.linear * rate),
        "acceleration_fraction": np.where(joint, rate, np.nan),
        "blend": np.where(rolls, rounding, 0.0),
    }
    tool = signed.signature.tool
    return bare_recording(len(own), columns, robot, None if tool is None else Pose.from_xyz_angles(tool))


def _middles(plan: Plan, own: Rows) -> Floats:
    """(n, 3) [m] half way along the arcs, whose own third point may lie before or behind them; nan for other moves."""
    from olp.runtime.paths import point_on_arc

    moves, point = plan.moves, plan.positions.position
    result = np.full((len(own), 3), np.nan)
    at = np.nonzero((moves.path[own] == _CIRCULAR) & (moves.via[own] >= 0))[0]
    if len(at):
        rows = own[at]
        curve = (
            point[moves.start[rows]],
            point[moves.target[rows]],
            point[moves.via[rows]],
            moves.before[rows],
        )
        result[at] = point_on_arc(*curve, np.full(len(at), 0.5))
    return result


def _angles(quaternion: Floats) -> Floats:
    """(n, 3) [rad] Rx, Ry, Rz; nan where the tool's orientation is not known."""
    from olp.robots.geometry import angles_from_rotation, rotation_from_quaternion

    result = np.full((len(quaternion), 3), np.nan)
    known = np.asarray(np.isfinite(quaternion).all(axis=1))
    if known.any():
        result[known] = angles_from_rotation(rotation_from_quaternion(quaternion[known]))
    return result
