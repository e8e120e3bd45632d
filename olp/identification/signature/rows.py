"""Predictions with 95 % intervals for every row of a moves.csv, measured or not.

The intervals are learnt for the kinds of moves that the recording has and assumed for all others: without joint moves
in the recording, their ramps take 0 to 3 times the computed time; without curves, theirs take 0 to 2 times; without
corners, each corner may cost half a stop more or less, and half of what it saves.

Codes: H010 moves outside what was learnt, H012 rows of which nothing can be said, H020 rows that olp's own model times.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from olp.core.diagnostic import Diagnostic, info, warning
from olp.identification.recording.moves import CIRCULAR as CURVED
from olp.identification.recording.moves import JOINT as TURNING
from olp.identification.signature.coefficients import CIRCULAR, CORNER, JOINT, TERMS, CorrectionPart, Parts
from olp.identification.signature.document import Signature
from olp.identification.signature.errors import Spread
from olp.identification.signature.joint_moves import recorded_joint_moves
from olp.identification.signature.moveset import moves_of_recording, with_points
from olp.identification.signature.predict import Prediction, predict, robot_of
from olp.identification.signature.stretch_times import (
    JointRows,
    Motions,
    Times,
    law_savings,
    motions_of,
    times_of,
    with_slowness,
)
from olp.identification.signature.stretches import Stretches, plain_rows, stretches_of
from olp.timing.arm import solve
from olp.timing.arm_prior import line_acceleration, unlearnt_law

if TYPE_CHECKING:
    from olp.identification.recording.moves import RecordedMoves
    from olp.identification.recording.recording import Recording
    from olp.identification.signature.document import LearntPaths
    from olp.identification.signature.term_model import PredictedRows
    from olp.robots.geometry import Pose
    from olp.robots.model import Robot
    from olp.timing.arm_moves import JointLaw

Floats = NDArray[np.float64]
Mask = NDArray[np.bool_]

_JOINT_GUESS, _CURVE_GUESS = 3.0, 2.0
_NORMAL = 1.96


def ends_of(
    parts: Parts,
    kind: NDArray[np.int8],
    times: Times,
    stops: NDArray[np.int64],
    corner: Mask,
    half: Floats,
    strain: Floats,
    law: str,
    joints: JointRows | None = None,
) -> tuple[Floats, Floats]:
    """Low and high (n,) [s]. `joints`: rows whose own law tells an interval.

    `half` (n,) [s] of a straight move from stop to stop there; `strain` (n,) [1] how far outside it is.

    `stops`: ends at which the arm stands; `corner`: rows that begin or end in one. Of joint moves `half` is not used.
    """
    duration = times.duration
    below, above = half * stops / 2, half * stops / 2
    for code, name, guess in ((TURNING, JOINT, _JOINT_GUESS), (CURVED, CIRCULAR, _CURVE_GUESS)):
        rows = kind == code
        if name in parts:
            part = parts[name]
            wide = part.spread.half * np.maximum(1.0, duration / part.longest) * strain
            below = np.where(rows, wide, below)
            above = np.where(rows, wide, above)
        else:
            own = np.where(code == TURNING, 0.0, half) * stops / 2
            below = np.where(rows, own + times.over + times.fixed, below)
            above = np.where(rows, own + (guess - 1) * times.over + times.fixed, above)
    if joints is not None:
        share = stops[joints.rows] / 2
        below[joints.rows] = (joints.times.duration - joints.times.low) * share
        above[joints.rows] = (joints.times.high - joints.times.duration) * share
    known = CORNER in parts and parts[CORNER].law == law
    if known:
        wide = parts[CORNER].row_half * strain
        extra = np.where(corner, np.hypot(below, wide) - below, 0.0)
    else:
        extra = np.where(corner, times.full / 2 + np.abs(np.nan_to_num(times.saving)) / 2, 0.0)
    # A zone that is not known may reach to the middle of the move.
    lost = np.where(np.isnan(times.saving), times.floor / 2, 0.0)
    # Only a corner lets a move take less than its way at the programmed speed.
    lowest = np.where(corner, 0.0, np.minimum(times.floor, duration))
    if joints is not None:
        lowest[joints.rows] = 0.0  # rated speeds are numbers that may be wrong
    low = np.maximum(duration - below - extra - lost, lowest)
    return low, duration + above + extra


def learnt_half(spread: Spread, often: NDArray[np.int64] | Floats) -> float:
    """[s] half-width of a sum; `often` (m,): how many times each distinct move, or stretch, runs."""
    own = _NORMAL * spread.own * float(np.sqrt(np.sum(often.astype(np.float64) ** 2)))
    return float(np.hypot(own, spread.quantile * spread.shared * float(np.sum(often))))


_WAIT_COLUMN = "wait_s"
_SLACK = 0.01  # of a speed: nearer to learnt ones it is one of them


class SignatureRows(NamedTuple):
    """One entry per row of the recording; nan where nothing can be said. Times in s."""

    move: NDArray[np.int64]
    predicted: Floats
    low: Floats
    high: Floats

    def csv(self) -> str:
        """The columns of `olp predict`; cells of rows that cannot be predicted are empty."""
        lines = ["move,predicted_s,low_s,high_s"]
        numbers = zip(self.predicted.tolist(), self.low.tolist(), self.high.tolist(), strict=True)
        for move, row in zip(self.move.tolist(), numbers, strict=True):
            lines.append(",".join([str(move), *("" if np.isnan(v) else f"{v:.6f}" for v in row)]))
        return "\n".join(lines) + "\n"


def predict_recording(
    signature: Signature, recording: Recording
) -> tuple[SignatureRows, tuple[Diagnostic, ...]]:
    """Predicts each row and tells of those it cannot, or only with a wider interval. Raises OlpError (see predict)."""
    assumed: list[str] = []
    known = rows_of(signature, recording, assumed.append)
    moves = known.moves
    kinds = np.array(moves.kinds, dtype=object)
    predicted = np.where(kinds == "wait", _waits(moves), known.times.duration)
    turning = known.motions.turning((kinds == "linear") | (kinds == "circular"))
    low, high = _ends(known, kinds, turning)
    resting = (kinds == "wait") | (known.times.floor == 0)  # or goes nowhere
    low[resting] = high[resting] = predicted[resting]
    told = _by_terms(signature, recording)
    by_terms = np.zeros(len(moves), dtype=bool)
    if told is not None:
        by_terms[told.rows] = True
        if by_terms[kinds == "joint"].all():
            assumed.clear()  # of axes that the terms have told
        predicted[told.rows] = told.duration
        low[told.rows] = np.maximum(told.duration - told.half, 0.0)
        high[told.rows] = told.duration + told.half
    if signature.paths is not None:
        _by_paths(signature, signature.paths, known, turning | by_terms, (predicted, low, high))
    nothing = ~np.isfinite(predicted)
    for values in (predicted, low, high):
        values[nothing] = np.nan
    turning &= ~by_terms
    if turning.any():
        says = f"{int(turning.sum())} paths turn the tool for longer than they travel, their intervals are guessed"
        assumed.append(says)
    found = [
        *_outside(known, told, recording.path),
        *_own(known, ~by_terms, ~nothing & ~by_terms & (kinds != "wait"), assumed, recording.path),
    ]
    if nothing.any():
        found.append(_nothing(moves, nothing, recording.path))
    return SignatureRows(moves.move, predicted, low, high), tuple(found)


def _by_paths(
    signature: Signature,
    paths: LearntPaths,
    known: RecordedTimes,
    others: NDArray[np.bool_],
    columns: tuple[Floats, Floats, Floats],
) -> None:
    """Puts what the law of paths says into the columns, but for straight moves that have a method of their own."""
    said = paths.of_rows(known.moves, robot_of(signature, known.robot), known.stretches)
    use = ~others[said.rows] & for_paths(signature, paths, known.moves, known.stretches)[said.rows]
    for column, values in zip(columns, (said.duration, said.low, said.high), strict=True):
        column[said.rows[use]] = values[use]


def for_paths(
    signature: Signature, paths: LearntPaths, moves: RecordedMoves, stretches: Stretches
) -> NDArray[np.bool_]:
    """(n,) rows that the law of paths is to tell: those that nothing else in the signature was learnt for."""
    plain = plain_rows(moves, stretches)
    if signature.domain.empty:
        return np.ones(len(plain), dtype=bool)
    low, high = signature.domain.speed
    slack = 1.0 + _SLACK
    speed = moves.speed * moves.played
    beyond = (speed < low / slack) | (speed > high * slack)
    arcs = np.array([kind == "circular" for kind in moves.kinds], dtype=bool)
    arcs &= (stretches.stops == 2) & ~stretches.open & (CIRCULAR not in signature.parts)
    return np.asarray(np.where(plain, beyond, paths.corners | arcs))


def _by_terms(signature: Signature, recording: Recording) -> PredictedRows | None:
    """What the terms of a diagnosis say, where the signature holds some."""
    if TERMS not in signature.parts:
        return None
    from olp.identification.signature.term_model import told_rows

    return told_rows(signature, replace(recording, robot=robot_of(signature, recording.robot)))


def _ends(known: RecordedTimes, kinds: NDArray[Any], turning: NDArray[np.bool_]) -> tuple[Floats, Floats]:
    """Low and high (n,) [s] of the moves."""
    stretches, times = known.stretches, known.times
    corner = stretches.begins_rolling | stretches.ends_rolling
    low, high = ends_of(
        known.parts,
        known.moves.kind,
        times,
        stretches.stops,
        corner,
        known.half,
        known.strain,
        known.law,
        known.joints,
    )
    # A corner that leads to nowhere in this recording may save any part of what the stop costs.
    low = np.where(stretches.open, np.maximum(low - times.full - times.fixed, 0.0), low)
    # Of what the wrist can do nothing was learnt: it speeds up between at once and in three times the time.
    low = np.where(turning, times.floor, low)
    high = np.where(turning, times.duration + 2 * times.full + times.fixed, high)
    plain = (kinds == "linear") & ~corner & ~stretches.open & ~turning
    if known.said is not None:
        at = plain[known.told]
        rows, said = known.told[at], known.said
        # Where no line was learnt, what olp says, as unsure.
        more = 0.0 if known.paths_learnt else times.duration[rows] - said.duration[at]
        low[rows], high[rows] = said.low[at] + more, said.high[at] + more
    return low, high


def _waits(moves: RecordedMoves) -> Floats:
    """(n,) [s] as programmed: the column wait_s, else what the simulation says."""
    written = moves.covariates.get(_WAIT_COLUMN, np.full(len(moves), np.nan))
    return np.asarray(np.where(np.isfinite(written), written, moves.sim))


def _own(
    known: RecordedTimes, own: NDArray[np.bool_], said: NDArray[np.bool_], assumed: list[str], file: str
) -> list[Diagnostic]:
    """Rows of which the signature has learnt nothing: timed by olp's own model, their intervals are guesses."""
    found = []
    kinds = np.array(known.moves.kinds, dtype=object)
    for kind, name in ((JOINT, "joint"), (CIRCULAR, "circular")):
        by_law = np.zeros(len(kinds), dtype=bool)
        if known.joints is not None:
            by_law[known.joints.rows] = True
        rows = said & (kinds == name)
        count, by_class = int(np.sum(rows & ~by_law)), int(np.sum(rows & by_law))
        if count and kind not in known.parts:
            says = (
                f"{count} {name} moves: none were learnt, olp's own model times them, with a guessed interval"
            )
            found.append(info("H020", says, file=file))
        if by_class and not known.arm_learnt:
            says = (
                f"{by_class} {name} moves: none were learnt, timed as usual of such an arm; twenty would tell"
            )
            found.append(info("H020", says, file=file))
    corners = int(np.sum(known.stretches.ends_rolling & own))
    if corners and (CORNER not in known.parts or known.parts[CORNER].law != known.law):
        says = f"{corners} corners: the signature learnt none of this law ({known.law}), their intervals are guessed"
        found.append(info("H020", says, file=file))
    open_ends = int(np.sum(known.stretches.open & own))
    if open_ends:
        says = f"{open_ends} moves end in a corner and no row goes on: timed as stops, intervals wider"
        found.append(info("H020", says, file=file))
    return [*found, *(info("H020", f"assumed: {says}", file=file) for says in dict.fromkeys(assumed))]


def _nothing(moves: RecordedMoves, nothing: NDArray[np.bool_], file: str) -> Diagnostic:
    first = int(np.argmax(nothing))
    says = (
        f"{int(nothing.sum())} of {len(moves)} rows are not predicted, the first is move {moves.move[first]} "
        f"({moves.kinds[first]})"
    )
    help = "a path needs points and speed_mm_s, a joint move joints (or points with angles), speed_pct and a robot"
    return warning("H012", says, file=file, help=f"{help}; a wait its programmed time in sim_s or wait_s")


def _outside(known: RecordedTimes, told: PredictedRows | None, file: str) -> list[Diagnostic]:
    """One note for all moves that are outside, with the commonest reason's first example."""
    rows, reasons = (known.told, known.said.reasons if known.said else ())
    if told is not None:
        rows, reasons = told.rows, told.reasons
    numbers = known.moves.move[rows].tolist() if reasons else []
    far = [(number, reason) for number, reason in zip(numbers, reasons, strict=True) if reason]
    if not far:
        return []
    kinds = Counter(reason.split(" ")[0] for _, reason in far)
    number, reason = next(p for p in far if p[1].startswith(kinds.most_common(1)[0][0]))
    often = f"{len(far)} of {len(numbers)} moves are outside what was learnt, their intervals are wider"
    says = f"{often}: move {number}, {reason}"
    return [info("H010", says, file=file)]


# --- Recorded ---
# The rows of a recording as a signature and olp's own model see them together.

_ALONG = ("linear", "circular")


@dataclass(frozen=True, slots=True, eq=False)
class RecordedTimes:
    """`half` (n,) [s]: half-width of the signature's interval along paths; `strain` (n,) [1]: how far outside.

    `told`: the rows that the signature's method was asked for, `said`: what it said, in that order.
    """

    moves: RecordedMoves
    motions: Motions
    stretches: Stretches
    saving: Floats
    law: str
    settling: float  # [s] of joint moves when none were learnt
    paths_learnt: bool  # else lines and arcs take what olp says, `settling` per exact stop included
    parts: Parts
    half: Floats
    strain: Floats
    told: NDArray[np.int64]
    said: Prediction | None
    joints: JointRows | None = None  # those that the law of joint moves told
    arm_learnt: bool = True  # else the law is what is known of such arms
    robot: Robot | None = None

    @property
    def times(self) -> Times:
        """What each row takes, with the parts as they are."""
        return times_of(
            self.moves,
            self.motions,
            self.stretches,
            self.parts,
            self.saving,
            self.settling,
            0.0 if self.paths_learnt else self.settling,
            self.joints,
        )

    def with_part(self, kind: str, part: CorrectionPart) -> RecordedTimes:
        return replace(self, parts={**self.parts, kind: part})


def rows_of(signature: Signature, recording: Recording, report: Callable[[str], None]) -> RecordedTimes:
    """`report` is called with what had to be assumed. Raises OlpError (see predict)."""
    from olp.robots.controller_effects import Effects, settling_of

    robot = robot_of(signature, recording.robot)
    if recording.robot is None and robot is not None:
        recording = replace(recording, robot=robot)
    moves = with_points(recording.moves, robot, recording.tool)
    arm: JointLaw | None = signature.arm
    if arm is None and robot is not None:
        arm = unlearnt_law(robot, signature.controller)
    told_by_law = JOINT in signature.parts or arm is not None  # then what is assumed of axes is not used
    motions = motions_of(moves, robot, recording.tool, (lambda says: None) if told_by_law else report)
    count = len(moves)
    half, strain = np.full(count, np.nan), np.ones(count)
    asked, told = moves_of_recording(recording, stops=False, kinds=_ALONG)
    said = None
    if len(told):
        said = predict(signature, asked, robot)
        usual = line_acceleration(robot, signature.controller).value
        own = np.where(asked.nominal > 0, asked.nominal, usual)
        push = said.acceleration if signature.knows_paths else own
        motions = with_slowness(motions, told, 1.0 / push)
        half[told], strain[told] = said.high - said.duration, said.weight / asked.speed
    _joint_at_tool_speed(motions, moves, line_acceleration(robot, signature.controller).value)
    stretches = stretches_of(moves)
    saving, law = law_savings(moves, motions, stretches, robot)
    settling, assumed = settling_of(Effects(), robot)
    if assumed and not told_by_law and any(kind == "joint" for kind in moves.kinds):
        report(assumed)
    joints = None if arm is None else _joint_rows(arm, moves, robot, recording.tool, signature.payload)
    return RecordedTimes(
        moves,
        motions,
        stretches,
        saving,
        law,
        settling,
        signature.knows_paths,
        signature.parts,
        half,
        strain,
        told,
        said,
        joints,
        signature.arm is not None,
        robot,
    )


def _joint_rows(
    arm: JointLaw, moves: RecordedMoves, robot: Robot | None, tool: Pose | None, payload: float | None
) -> JointRows:
    """`payload` [kg] of rows that do not say theirs."""
    if payload is not None:
        moves = replace(moves, payload=np.where(np.isnan(moves.payload), payload, moves.payload))
    joints, rows = recorded_joint_moves(moves, robot, tool, len(arm.timing.axes), arm.timing.load_inertia)
    floor = np.max(solve(arm.timing.mean, joints.motions).cruise, axis=1, initial=0.0)
    return JointRows(rows, arm.predict(joints), floor, arm.timing.stop)


def _joint_at_tool_speed(motions: Motions, moves: RecordedMoves, usual: float) -> None:
    """A joint move with a speed of the tool and no share of the axes': accelerates as lines do, else as is `usual`."""
    at = np.array([kind == "joint" for kind in moves.kinds], dtype=bool)
    at &= np.isnan(motions.slowness[:, 0]) & np.isfinite(motions.distance[:, 0])
    given = moves.acceleration[at]
    motions.slowness[at, 0] = 1.0 / np.where(given > 0, given, usual)
