"""A timing signature applied to a plan: accelerations, stops, corners, whole times and intervals of its moves."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from olp.identification.recording.moves import CIRCULAR, JOINT, LINEAR
from olp.identification.recording.recording import Recording
from olp.identification.signature import coefficients
from olp.identification.signature.coefficients import CORNER, STOP, TERMS, value_of
from olp.identification.signature.document import Signature, pieces_of
from olp.identification.signature.moveset import MoveSet
from olp.identification.signature.predict import Prediction, predict, robot_of
from olp.identification.signature.rows import ends_of, for_paths, learnt_half
from olp.identification.signature.stretch_times import Times
from olp.identification.signature.stretches import stretches_of
from olp.identification.signature.term_model import (
    NamedModel,
    PredictedRows,
    bare_recording,
    terms_of,
    told_rows,
)
from olp.ir.program import Path
from olp.robots.geometry import Pose, angles_from_rotation, rotation_from_quaternion
from olp.runtime.paths import point_on_arc
from olp.runtime.plan import PATHS, Plan, StepKind
from olp.timing.arm_moves import total_half
from olp.timing.arm_prior import LineAcceleration, unlearnt_law
from olp.timing.chain import Chain
from olp.timing.correction import Correction, PlanCorrection, timed_by
from olp.timing.demand import Demand
from olp.timing.joint_times import doubt_of
from olp.timing.result import CorrectionInterval, Timing

Floats = NDArray[np.float64]
Mask = NDArray[np.bool_]
Rows = NDArray[np.intp]
Report = Callable[[str], None]
_LINEAR, _CIRCULAR, _JOINT = (PATHS.index(path) for path in (Path.LINEAR, Path.CIRCULAR, Path.JOINT))
_SAME = 1e-5  # [m] moves nearer than this are one move that runs again


class SignatureCorrection(Correction):
    """A timing signature as `time_plan` asks it."""

    def __init__(self, signature: Signature) -> None:
        self.signature = signature

    @property
    def axis_scale(self) -> float:
        return value_of(self.signature.parts, coefficients.JOINT, "acceleration_time_scale")

    @property
    def knows_joint_moves(self) -> bool:
        return self.signature.arm is not None

    def of_plan(
        self, plan: Plan, wanted: Demand, overrides: Floats, by_axes: bool, report: Report
    ) -> SignedPlan:
        signature = self.signature
        signed = _sign(plan, wanted, signature, report)
        arm = signature.arm
        if arm is None and by_axes and plan.robot is not None:
            law = unlearnt_law(plan.robot, signature.controller)
            return replace(signed, timed=timed_by(law, plan, wanted, overrides, signature.payload))
        return replace(signed, timed=timed_by(arm, plan, wanted, overrides, signature.payload))


@dataclass(frozen=True, kw_only=True)
class SignedPlan(PlanCorrection):
    """`said` (m,): what the signature said of the `rows` whose acceleration it told, curves by their chords.

    `joints` (k,): mask of Moves, joint moves of the signature's robot. `told`: moves, by their rows of Moves, whose
    whole time the terms of a diagnosis or the law of paths told.
    """

    signature: Signature
    said: Prediction | None
    again: Rows  # (m,) which distinct move each row is: errors of repeats are the same error
    joints: Mask
    told: PredictedRows | None = None

    def corners(self, joined: Chain) -> Chain:
        """Corners as learnt, where the plan's corners follow the law that they were learnt of."""
        part = self.signature.parts.get(CORNER)
        if part is None or part.law != self.plan.zone_law:
            return joined
        rolling, first = _corners_of(self, joined)
        saving = joined.saving.copy()
        rounded = (
            joined.saving < 0
        )  # for corners that replace the ends of their moves, the time in the corner
        scaled = saving * np.where(rounded, 1.0, part.value("saving_scale")) - part.value("corner_time")
        saving = np.where(rolling, scaled, saving)
        last = first & ~rolling
        return replace(joined, saving=np.where(last, saving - part.value("stretch_time"), saving))

    def follow(self, wanted: Demand, joined: Chain, overrides: Floats, report: Report) -> SignedPlan:
        return _by_paths(_by_terms(self, wanted, joined, overrides, report), wanted, joined, overrides)

    @property
    def knows_stops(self) -> Mask:
        return self.measured_stops

    @property
    def measured_stops(self) -> Mask:
        """(k,) rows of Moves whose learnt times hold all that the controller adds to a stop already."""
        result: Mask = self.joints & (coefficients.JOINT in self.signature.parts)
        result[self.rows] = self.signature.knows_paths
        if self.told is not None:
            result[self.told.rows] = True
        if self.timed is not None:
            result[self.timed.rows] = True
        return result

    def settled(self, exact: Mask, settling: float) -> Floats:
        """(k,) [s] per row of Moves that an exact stop takes: what was learnt, and `settling` where nothing was."""
        parts = self.signature.parts
        result = np.where(exact, settling, 0.0)
        told = np.zeros(len(exact), dtype=bool)
        told[self.rows] = self.signature.knows_paths
        # Measured times end when the arm stands still: what settles is in the acceleration, or was learnt beside it.
        stop = value_of(parts, STOP, "fixed_time")
        curve = stop + value_of(parts, coefficients.CIRCULAR, "fixed_time")
        result = np.where(told & exact, np.where(self.plan.moves.path == _LINEAR, stop, curve), result)
        if coefficients.JOINT in parts:
            result = np.where(self.joints & exact, parts[coefficients.JOINT].value("fixed_time"), result)
        if self.timed is not None:
            at = self.timed.rows
            result[at] = np.where(exact[at], self.timed.stop, 0.0)
        return result

    def with_whole_times(self, durations: Floats) -> Floats:
        if self.told is None:
            return durations
        result = durations.copy()
        result[self.told.rows] = self.told.duration
        return result

    def doubts(self) -> list[str]:
        return [] if self.signature.arm is not None or self.timed is None else doubt_of(self.plan, self.timed)

    def with_interval(
        self,
        timing: Timing,
        wanted: Demand,
        joined: Chain,
        times: tuple[Floats, Floats],
        lines: LineAcceleration,
        report: Report,
    ) -> Timing:
        seen = _interval(self, wanted, joined, times[1], timing.duration_s, report)
        unseen = 0 if self.said is None else sum(map(bool, self.said.reasons))
        return replace(timing, interval=seen, unseen=unseen)


def _sign(plan: Plan, wanted: Demand, signature: Signature, report: Report) -> SignedPlan:
    """Puts the corrected acceleration into `wanted`, scaled by ACC= and DEC=. Raises OlpError (see predict)."""
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
        return SignedPlan(plan=plan, rows=rows, signature=signature, said=None, again=rows, joints=joints)
    asked = _asked(plan, wanted, signature, rows)
    said = predict(signature, asked, plan.robot)
    if signature.knows_paths:
        curved = moves.path[rows] != _LINEAR
        push = said.acceleration / np.where(
            curved, value_of(signature.parts, coefficients.CIRCULAR, "acceleration_time_scale"), 1.0
        )
        wanted.acceleration[rows] = push * moves.acceleration[rows]
        wanted.deceleration[rows] = push * moves.deceleration[rows]
    outside = [(row, reason) for row, reason in zip(rows.tolist(), said.reasons, strict=True) if reason]
    if outside:
        report(f"{len(outside)} of {len(rows)} paths are outside what the signature learnt: {outside[0][1]}")
    keys = np.round(np.concatenate([asked.start, asked.end, asked.speed[:, None]], axis=1) / _SAME)
    again = np.unique(keys, axis=0, return_inverse=True)[1].reshape(-1)
    return SignedPlan(plan=plan, rows=rows, signature=signature, said=said, again=again, joints=joints)


def _asked(plan: Plan, wanted: Demand, signature: Signature, rows: NDArray[np.intp]) -> MoveSet:
    """The moves of these rows, curves by their chords."""
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


def _corners_of(signed: SignedPlan, joined: Chain) -> tuple[Mask, Mask]:
    """(k,) rows of the arm that end in a corner, and those that begin in one."""
    mine = signed.joints.copy()
    mine[signed.rows] = True
    return mine & (joined.end_speed > 0), mine & (joined.start_speed > 0)


# --- Moves whose whole time is known: by the terms of a diagnosis, and by the law of paths ---


_SOME_ROUNDING = 1e-6  # [m] of a corner of unknown size
_AXES = frozenset({"joint-speed-limit", "orientation-limit"})  # terms that know what else slows a path


def _by_terms(
    signed: SignedPlan, wanted: Demand, joined: Chain, overrides: Floats, report: Report
) -> SignedPlan:
    """`signed` with the rows that the signature's terms tell. Raises OlpError (see named_rows).

    `overrides` (m,) [1] of the rows of Moves.
    """
    plan = signed.plan
    if TERMS not in signed.signature.parts:
        return signed
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
    told = told_rows(signed.signature, _recording(signed, joined, named, own, use, overrides[own]))
    if told is None:
        return signed
    if "payload" in names and np.isfinite(named.payload):
        report(f"the arm carries {named.payload:g} kg, as in the recording of the signature")
    return replace(signed, told=told._replace(rows=own[told.rows]))


def _by_paths(signed: SignedPlan, wanted: Demand, joined: Chain, overrides: Floats) -> SignedPlan:
    """`signed` with the lines and arcs that `olp predict` would time by the law of paths, timed by it."""
    plan, paths = signed.plan, signed.signature.paths
    robot, moves = plan.robot, plan.moves
    if paths is None or robot is None or TERMS in signed.signature.parts:
        return signed
    mine = np.array([r is robot for r in plan.robots], dtype=bool)[moves.mechanism]
    own = np.flatnonzero(
        mine & (wanted.unknown | (wanted.length > 0))
    )  # moves that go nowhere are in no recording
    use = _usable(plan, wanted, own) & (moves.path[own] != _JOINT)
    if not use.any():
        return signed
    path, axes = moves.path[own], plan.positions.axes[:, : len(robot.axes)]
    kind = np.where(path == _LINEAR, LINEAR, np.where(path == _JOINT, JOINT, CIRCULAR)).astype(np.int8)
    rounding = np.where(moves.blend[own] > 0, moves.blend[own], _SOME_ROUNDING)
    columns = {
        "kind": kind,
        "start": plan.positions.position[moves.start[own]],
        "end": plan.positions.position[moves.target[own]],
        "via": _middles(plan, own),
        "joints_start": axes[moves.start[own]],
        "joints_end": axes[moves.target[own]],
        "speed": np.where(use, moves.travel[own], np.nan),
        "acceleration": moves.rate[own] * moves.acceleration[own],
        "acceleration_fraction": moves.acceleration[own],
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
    half = duration * np.expm1(paths.halves(pieces))
    told = PredictedRows(own[rows], duration, half, np.ones(len(rows)), ("",) * len(rows))
    return replace(signed, told=told)


def _usable(plan: Plan, wanted: Demand, own: Rows) -> Mask:
    """(n,) of the arm's rows: moves with a path that the terms can follow."""
    moves = plan.moves
    known = ~wanted.unknown[own] & (wanted.length[own] > 0)
    arcs = (moves.path[own] == _CIRCULAR) & (moves.via[own] >= 0)
    return np.asarray(known & ((moves.path[own] == _LINEAR) | (moves.path[own] == _JOINT) | arcs))


def _recording(
    signed: SignedPlan, joined: Chain, named: NamedModel, own: Rows, use: Mask, override: Floats
) -> Recording:
    """The arm's rows as a recording; those not in `use` are included for their neighbours."""
    plan = signed.plan
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
    result = np.full((len(quaternion), 3), np.nan)
    known = np.asarray(np.isfinite(quaternion).all(axis=1))
    if known.any():
        result[known] = angles_from_rotation(rotation_from_quaternion(quaternion[known]))
    return result


# --- The interval ---


class _Rows(NamedTuple):
    """(k,) per row of Moves; `below`, `above` [s] from what the row takes, nan where nothing is known."""

    below: Floats
    above: Floats
    stops: NDArray[np.int64]
    rolling: Mask  # rows that end in a corner
    begins: Mask  # rows that begin in one
    kind: NDArray[np.int8]


def _interval(
    signed: SignedPlan, wanted: Demand, joined: Chain, settling: Floats, duration: Floats, report: Report
) -> CorrectionInterval:
    """Of steps that last `duration` (n,) [s]; `settling` (k,) [s] of the rows of Moves."""
    plan = signed.plan
    rows = _rows(signed, wanted, joined, settling)
    is_move = plan.kind == StepKind.MOVE
    first, steps = plan.row[is_move], np.nonzero(is_move)[0]
    low, high = duration.copy(), duration.copy()
    low[steps] = np.maximum(duration[steps] - rows.below[first], 0.0)
    high[steps] = duration[steps] + rows.above[first]
    total = float(np.nansum(duration))
    known = np.isfinite(rows.below[first])
    leading = np.zeros(len(rows.below), dtype=bool)
    leading[first[known]] = True
    half, below, above = _sum(signed, rows, leading)
    others = int(np.sum(~known & (wanted.length[first] > 0)))
    if others:
        report(f"the interval is that of {int(known.sum())} moves; {others} other moves count as exact")
    _report_guesses(signed, rows, leading, report)
    floor = total - float(np.nansum((duration[steps])[known]))
    return CorrectionInterval(low, high, max(total - half - below, floor), total + half + above)


def _rows(signed: SignedPlan, wanted: Demand, joined: Chain, settling: Floats) -> _Rows:
    count = len(wanted.length)
    plan = signed.plan
    path = plan.moves.path
    kind = np.where(path == _LINEAR, LINEAR, np.where(path == _JOINT, JOINT, CIRCULAR)).astype(np.int8)
    rolling, begins = _corners_of(signed, joined)
    stops = 2 - rolling.astype(np.int64) - begins
    half, strain = np.full(count, np.nan), np.ones(count)
    if signed.said is not None:
        half[signed.rows] = signed.said.high - signed.said.duration
        strain[signed.rows] = signed.said.weight / wanted.speed[signed.rows]
    mine = signed.joints.copy()
    mine[signed.rows] = True
    with np.errstate(divide="ignore", invalid="ignore"):
        s = (1 / wanted.acceleration + 1 / wanted.deceleration) / 2
        floor = wanted.length / wanted.speed
        reached = wanted.speed**2 * s <= wanted.length
        full = np.where(reached, wanted.speed * s, 2 * np.sqrt(wanted.length * s) - floor)
    times = Times(
        floor, full * stops / 2, full, settling, joined.saving, np.where(rolling, joined.saving, 0.0)
    )
    corner = rolling | begins
    ends = ends_of(signed.signature.parts, kind, times, stops, corner, half, strain, plan.zone_law)
    below, above = times.duration - ends[0], ends[1] - times.duration
    if signed.timed is not None:
        at, own = signed.timed.rows, signed.timed.times
        below[at] = (own.duration - own.low) * stops[at] / 2
        above[at] = (own.high - own.duration) * stops[at] / 2
    for values in (below, above):
        values[~mine] = np.nan
    if signed.told is not None:
        below[signed.told.rows] = np.minimum(signed.told.half, signed.told.duration)
        above[signed.told.rows] = signed.told.half
    return _Rows(below, above, stops, rolling, begins, kind)


def _sum(signed: SignedPlan, rows: _Rows, leading: Mask) -> tuple[float, float, float]:
    """Half-width [s] of what was learnt, and how far guesses reach below and above [s]."""
    plan, parts = signed.plan, signed.signature.parts
    squares = _terms_half(signed, leading) ** 2
    leading = leading & ~_of_terms(signed, len(leading))
    squares += _joint_half(signed, leading) ** 2
    leading = leading & ~_of_law(signed, len(leading))
    guessed = np.zeros(len(rows.below), dtype=bool)
    moves = plan.moves
    keys = np.stack([moves.start, moves.target, moves.via], axis=1)
    for code, name in ((JOINT, "joint"), (CIRCULAR, "circular")):
        own = leading & (rows.kind == code)
        if name in parts and own.any():
            often = np.unique(keys[own], axis=0, return_counts=True)[1]
            squares += learnt_half(parts[name].spread, often) ** 2
        else:
            guessed |= own
    straight = leading & (rows.kind == LINEAR)
    squares += _straight_half(signed, straight, rows.stops) ** 2
    turning = leading & rows.rolling
    learnt = "corner" in parts and parts["corner"].law == plan.zone_law
    if learnt and turning.any():
        # A stretch has one error: it is counted at its first corner.
        often = np.unique(keys[turning & ~rows.begins], axis=0, return_counts=True)[1]
        squares += learnt_half(parts["corner"].spread, often) ** 2
    elif not learnt:
        guessed |= leading & (rows.rolling | rows.begins)
    below, above = (float(np.nansum(side[guessed])) for side in (rows.below, rows.above))
    return float(np.sqrt(squares)), below, above


def _of_terms(signed: SignedPlan, count: int) -> Mask:
    """(k,) rows of Moves whose time a diagnosis' terms told."""
    result = np.zeros(count, dtype=bool)
    if signed.told is not None:
        result[signed.told.rows] = True
    return result


def _of_law(signed: SignedPlan, count: int) -> Mask:
    """(k,) rows of Moves that the law of the arm timed."""
    result = np.zeros(count, dtype=bool)
    if signed.timed is not None:
        result[signed.timed.rows] = True
    return result


def _joint_half(signed: SignedPlan, leading: Mask) -> float:
    """[s] of the joint moves that the law of the arm timed; repeats of a move have one error, many times."""
    if signed.timed is None or not len(signed.timed.rows):
        return 0.0
    use = np.flatnonzero(leading[signed.timed.rows])
    rows, moves = signed.timed.rows[use], signed.plan.moves
    if not len(rows):
        return 0.0
    keys = np.stack([moves.start[rows], moves.target[rows]], axis=1)
    _, first, often = np.unique(keys, axis=0, return_index=True, return_counts=True)
    return total_half(signed.timed.law, signed.timed.moves.take(use[first]), often.astype(np.float64))


def _terms_half(signed: SignedPlan, leading: Mask) -> float:
    """[s] Repeats of a move have one error, many times; outside what was learnt it is larger."""
    if signed.told is None:
        return 0.0
    use = leading[signed.told.rows]
    rows, moves = signed.told.rows[use], signed.plan.moves
    keys = np.stack([moves.start[rows], moves.target[rows], moves.via[rows]], axis=1)
    _, inverse = np.unique(keys, axis=0, return_inverse=True)
    if TERMS not in signed.signature.parts:  # the law of paths told them, each with its own interval
        return float(np.sqrt(np.sum(np.bincount(inverse.reshape(-1), signed.told.half[use]) ** 2)))
    often = np.bincount(inverse.reshape(-1), signed.told.strain[use])
    return learnt_half(signed.signature.parts[TERMS].spread, often)


def _straight_half(signed: SignedPlan, straight: Mask, stops: NDArray[np.int64]) -> float:
    """[s] Repeats of a move have one error, many times; a move with one end at rest has half of it."""
    at = np.nonzero(straight[signed.rows])[0]
    if not len(at) or signed.said is None:
        return 0.0
    share = stops[signed.rows[at]] / 2
    _, chosen, inverse = np.unique(signed.again[at], return_index=True, return_inverse=True)
    count = np.bincount(inverse.reshape(-1), share).astype(np.float64)
    return signed.said.take(at[chosen]).total_half(signed.signature, count)


def _report_guesses(signed: SignedPlan, rows: _Rows, leading: Mask, report: Report) -> None:
    parts, law = signed.signature.parts, signed.plan.zone_law
    leading = leading & ~_of_terms(signed, len(leading)) & ~_of_law(signed, len(leading))
    for code, name in ((JOINT, "joint"), (CIRCULAR, "circular")):
        count = int(np.sum(leading & (rows.kind == code)))
        if count and name not in parts:
            report(f"{count} {name} moves: the signature learnt none, their intervals are guessed")
    corners = int(np.sum(leading & rows.rolling))
    if corners and ("corner" not in parts or parts["corner"].law != law):
        report(f"{corners} moves end in a corner: the signature learnt none, their intervals are guessed")
