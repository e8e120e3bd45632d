"""From a recording to a signature: straight moves first, then the other parts of a program.

Of straight moves: fit, choice of the method and error model, all from the recording alone.

Codes: H003 too few measured moves, H004 moves that cannot be used, H005 moves faster than length over speed,
H021 what was learnt beside straight moves, H033 repeated moves, H050 to H052, H055 and H056 of joint moves, H054 lines
and arcs whose tool is not told.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from olp.core.diagnostic import Diagnostic, OlpError, error, info, warning
from olp.core.version import __version__
from olp.identification.signature.coefficients import (
    CIRCULAR,
    CORNER,
    FEWEST,
    JOINT,
    STOP,
    CorrectionPart,
    LearntParameter,
    Parameters,
    learn_part,
)
from olp.identification.signature.document import (
    Learnt,
    LearntPaths,
    Score,
    Signature,
    faster_than_programmed,
    learn_paths,
    paths_note,
    pieces_of,
)
from olp.identification.signature.domain import Domain, domain_of
from olp.identification.signature.errors import ErrorModel, Spread, spread_of
from olp.identification.signature.estimator import (
    estimator_names,
    fit_or_refuse,
    load_estimator,
    measured_slowness,
)
from olp.identification.signature.folds import Trial, merit, merit_doubt, residuals, score_of, try_out
from olp.identification.signature.joint_moves import (
    LearntArm,
    contradicting,
    contradiction_notes,
    contradictions,
    faster_than_rated,
    learn_arm,
    learnt_note,
    recorded_joint_moves,
    told_inertia,
    too_fast_notes,
    unsaid_speed_notes,
)
from olp.identification.signature.moveset import MoveSet, middle_alone, moves_of_recording, with_points
from olp.identification.signature.rows import RecordedTimes, rows_of
from olp.identification.signature.stretch_times import law_savings, motions_of
from olp.identification.signature.stretches import Stretches, plain_rows, stretches_of
from olp.robots.controller_effects import generations_in
from olp.timing.arm_prior import arm_prior, line_acceleration

if TYPE_CHECKING:
    from olp.identification.recording.recording import Recording
    from olp.robots.model import Robot

AUTO = "auto"
_FEWEST = 4
_EQUAL = 0.05  # of the logarithm: five percent between two methods say nothing
# [standard errors] by which another method has to be better than one that is preferred: 95 % sure.
_SURE = 1.96
# Of more moves than _ALL the choice is made on _TO_CHOOSE, a long recording tells no more about which method suits; how
# wrong the chosen one is, is told by _TO_JUDGE, as many as the smooth functions are made of.
_ALL, _TO_CHOOSE, _TO_JUDGE = 150, 120, 300


class SignatureFit(NamedTuple):
    """What was learnt from a set of moves, before it has a name and a robot."""

    method: str
    parameters: Parameters
    errors: ErrorModel
    compared: dict[str, Score]


def calibrate_straight(
    recording: Recording, method: str = AUTO, robot: Robot | None = None
) -> tuple[Signature, tuple[Diagnostic, ...]]:
    """The signature of the robot that was recorded, and what there is to say about the recording.

    `method`: a name of `estimator_names()`, or "auto": the one that predicts held-out moves and start points of this
    recording best. `robot`: instead of the recording's. Raises OlpError: H001, H002, H003.
    """
    robot = robot or recording.robot
    moves, _ = moves_of_recording(recording)
    measured = np.isfinite(moves.duration) & (moves.duration > 0)
    told = _left_out(recording, moves, measured)
    moves = moves.take(measured)
    slow = np.isfinite(measured_slowness(moves))
    if not slow.all():
        says = f"{np.sum(~slow)} moves are faster than length over programmed speed and were left out"
        told.append(warning("H005", says, file=recording.path, help="check their speed_mm_s and duration_s"))
        moves = moves.take(slow)
    cycles = average_cycles(moves)
    if cycles.freedom:
        says = f"{len(moves)} rows are {len(cycles.moves)} moves, repeated; their means were used"
        told.append(info("H033", says, file=recording.path))
        moves = cycles.moves
    if len(moves) < _FEWEST:
        says = f"{len(moves)} measured straight moves with exact stops, at least {_FEWEST} are needed"
        raise OlpError(error("H003", says, file=recording.path, help=_needed(recording)))
    fitted = fit_moves(moves, robot, method)
    payload = moves.payload[np.isfinite(moves.payload)]
    settings = recording.settings
    signature = Signature(
        robot=robot.name if robot else "",
        controller=settings.controller or "",
        tool=_tool(recording),
        payload=float(np.median(payload)) if len(payload) else None,
        recording=Learnt(recording.path, recording.sha256, len(moves), settings.time_resolution),
        method=fitted.method,
        parameters=fitted.parameters,
        errors=with_scatter(fitted.errors, cycles),
        domain=domain_of(moves),
        compared=fitted.compared,
        olp=__version__,
    )
    return signature, tuple(told)


def fit_moves(moves: MoveSet, robot: Robot | None, method: str = AUTO) -> SignatureFit:
    """Learns from measured moves. Raises OlpError: H001, H002."""
    compared: dict[str, Score] = {}
    judged, trial = _sample(moves, _TO_JUDGE), None
    if method == AUTO:
        sample = judged if len(moves) <= _ALL else _sample(moves, _TO_CHOOSE)
        able = {name: load_estimator(name) for name in estimator_names()}
        names = [name for name, one in able.items() if not one.needs(sample, robot) and one.suits(sample)]
        trials = try_out(names, sample, robot)
        method = chosen(trials, sample)
        compared = {name: score_of(trials[name], sample) for name in names}
        trial = trials[method] if sample is judged else None
    parameters = fit_or_refuse(load_estimator(method), moves, robot)
    trial = trial or try_out([method], judged, robot)[method]
    compared.setdefault(method, score_of(trial, judged))
    return SignatureFit(method, parameters, _error_model(trial, judged), compared)


def chosen(trials: dict[str, Trial], moves: MoveSet) -> str:
    """The best by `merit`, unless it is not surely better than one that is preferred."""
    merits = {name: merit(score_of(trial, moves)) for name, trial in trials.items()}
    best = min(merits, key=merits.__getitem__)
    for name in merits:
        if load_estimator(name).preferred:
            doubt = merit_doubt(trials[name], trials[best], moves)
            if merits[name] <= merits[best] + max(_EQUAL, _SURE * doubt):
                return name
    return best


def _error_model(trial: Trial, moves: MoveSet) -> ErrorModel:
    close = spread_of(residuals(trial.near, moves), moves.start_labels)
    # Moves between the same learnt ones err alike: no more errors are independent than moves were learnt from.
    close = close._replace(shared=math.hypot(close.shared, close.own / math.sqrt(len(moves))))
    if trial.far is None:
        # One start point says nothing of another: three times as wide is a guess, and said to be outside.
        wide = close._replace(half=3 * close.half, shared=max(close.shared, close.half), groups=2)
        return ErrorModel(close, wide)
    wide = spread_of(residuals(trial.far, moves), trial.far.labels)
    return ErrorModel(close, wide._replace(half=max(wide.half, close.half)))


def _sample(moves: MoveSet, most: int) -> MoveSet:
    """At most that many moves, evenly from first to last."""
    if len(moves) <= most:
        return moves
    return moves.take(np.linspace(0, len(moves) - 1, most).astype(np.int64))


def _needed(recording: Recording) -> str:
    """What lines lack that cannot be learnt from."""
    from olp.identification.recording.moves import LINEAR

    moves = recording.moves
    lines = (moves.kind == LINEAR) & (np.nan_to_num(moves.duration) > 0)
    joints = int(np.sum(lines & ~moves.has_points & moves.has_joints))
    if joints and (recording.robot is None or recording.robot.geometry is None):
        return (
            f"{joints} lines are told by joints alone: name a robot with its geometry (robot = in recording.toml), "
            "which tells how far the tool goes"
        )
    speeds = int(np.sum(lines & ~(moves.speed > 0)))
    if speeds:
        return f"{speeds} lines have no speed_mm_s"
    return "straight moves, arcs or joint moves with duration_s; olp probe makes a program of such moves"


def _at_the_flange(recording: Recording) -> list[Diagnostic]:
    """Notes where lines are told by joints and no tool is, and arcs are but for their middle."""
    from olp.identification.recording.moves import LINEAR

    moves, found = recording.moves, []
    lines = int(np.sum((moves.kind == LINEAR) & ~moves.has_points & moves.has_joints))
    if lines and recording.tool is None:
        says = f"{lines} lines are told by joints and no tool is: their ways are those of the flange"
        help = "give the tool (tool = in recording.toml) if it turns on them"
        found.append(info("H054", says, file=recording.path, help=help))
    arcs = int(np.sum(middle_alone(moves, recording.tool)))
    if arcs:
        says = f"{arcs} arcs are left out: their ends are told by joints, their middle by the tool, and no tool is told"
        found.append(
            warning("H054", says, file=recording.path, help="give the tool (tool = in recording.toml)")
        )
    return found


def _left_out(recording: Recording, moves: MoveSet, measured: NDArray[np.bool_]) -> list[Diagnostic]:
    found = []
    other = len(recording.moves) - len(moves)
    if other:
        says = f"{other} moves are not straight from stop to stop with points and speed: the method does not use them"
        found.append(info("H004", says, file=recording.path))
    empty = int(np.sum(~measured))
    if empty:
        found.append(info("H004", f"{empty} moves have no duration and were not used", file=recording.path))
    return found


def _tool(recording: Recording) -> tuple[float, ...] | None:
    if recording.tool is None:
        return None
    return tuple(float(v) for v in recording.tool.xyz_angles())


# --- Partial cycles ---
# Repeated cycles: one row per move, its mean over the cycles, and what the repeats say about the noise of one run.
#
# Without it a repeat would tell what is held out when the others are fitted, and all errors would look like noise.

Floats = NDArray[np.float64]

# [m], [m/s], [1], [kg] Moves nearer than this are repeats of one move.
_SAME = 1e-5
_NORMAL = 1.96


class Cycles(NamedTuple):
    """`moves`: the distinct ones, in the order of first use. `scatter` [s²/m]: of one run, 0 where nothing repeats."""

    moves: MoveSet
    runs: NDArray[np.int64]  # behind each
    scatter: float
    freedom: int  # degrees of freedom behind `scatter`


def average_cycles(moves: MoveSet) -> Cycles:
    """The mean duration of every move that was run several times."""
    if not len(moves):
        return Cycles(moves, np.zeros(0, dtype=np.int64), 0.0, 0)
    turned = np.nan_to_num(moves.rotation.reshape(len(moves), 9), nan=9.0)
    load = np.nan_to_num(moves.payload, nan=-1.0)
    keys = np.concatenate([moves.start, moves.end, turned, moves.speed[:, None], load[:, None]], axis=1)
    _, first, owner = np.unique(np.round(keys / _SAME), axis=0, return_index=True, return_inverse=True)
    order = np.argsort(first)
    owner = np.argsort(order)[owner.reshape(-1)]
    rows = first[order].astype(np.int64)
    count = np.bincount(owner, minlength=len(rows)).astype(np.int64)
    freedom = int(len(moves) - len(rows))
    if not freedom:
        return Cycles(moves, count, 0.0, 0)
    mean = np.bincount(owner, moves.duration, len(rows)) / count
    off = (moves.duration - mean[owner]) / moves.speed
    kept = moves.take(rows)
    averaged = MoveSet(
        kept.start,
        kept.end,
        kept.rotation,
        kept.speed,
        kept.nominal,
        mean,
        kept.payload,
        kept.configuration,
        kept.program,
        kept.tool,
        kept.joints,
    )
    return Cycles(averaged, count, math.sqrt(float(np.sum(off**2)) / freedom), freedom)


def with_scatter(errors: ErrorModel, cycles: Cycles) -> ErrorModel:
    """Intervals of one run: what was held out were means, whose own noise is smaller by the root of the count."""
    missing = cycles.scatter * math.sqrt(1.0 - float(np.mean(1.0 / cycles.runs)))

    def wider(spread: Spread) -> Spread:
        return spread._replace(
            half=math.hypot(spread.half, _NORMAL * missing), own=math.hypot(spread.own, missing)
        )

    return ErrorModel(wider(errors.near), wider(errors.far)) if missing else errors


Labels = NDArray[np.int64]
Mask = NDArray[np.bool_]

NAMED = "named_terms"  # learnt from the whole recording by a diagnosis
_SHOWN = 5
# Speeds this far apart tell what a stop costs at any speed from what grows with the speed.
_RATIO = 1.5


class _Stretches(NamedTuple):
    """m stretches with corners, their sums [s] (m,)."""

    measured: Floats
    plain: Floats  # without corners
    saving: Floats
    corners: Floats
    first: NDArray[np.intp]  # row of each
    rows: Mask  # (n,) of the recording that are in one


def calibrate(
    recording: Recording, method: str = AUTO, robot: Robot | None = None
) -> tuple[Signature, tuple[Diagnostic, ...]]:
    """The signature of the robot that was recorded, and what there is to say about the recording.

    `method`: a name of `estimator_names()`, or "auto": the one that predicts held-out moves and start points of this
    recording best, of those that learn from moves alone. `robot`: instead of the recording's. Raises OlpError: H001,
    H002, H003, of "named_terms" H040 and N010.
    """
    if robot is not None:
        recording = replace(recording, robot=robot)
    if method == NAMED:
        from olp.identification.signature.from_diagnosis import signature_of_recording

        return signature_of_recording(recording)
    parts: dict[str, CorrectionPart] = {}
    recording, found = _possible(recording)
    straight = recording
    stop = _learn_stop(recording)
    if stop is not None:
        parts[STOP] = stop
        straight = _without_stops(recording, stop.value("fixed_time"))
    arm, said = _learn_joints(recording)
    said = [*found, *_at_the_flange(recording), *said]
    try:
        signature, told = calibrate_straight(straight, method, robot)
    except OlpError as problem:
        paths = _learn_paths(recording)
        if problem.diagnostics[0].code != "H003":
            raise
        if arm is None and paths is None:
            raise OlpError(_too_few(recording, problem), *said) from None
        signature, told = _without_straight(recording, arm, paths), ()
    told = (*told, *said)
    signature = replace(signature, parts=parts, arm=arm)
    if _beside(recording):
        rows = rows_of(signature, recording, lambda says: None)
        for kind, learn in ((CIRCULAR, _learn_curves), (CORNER, _learn_corners)):
            part = learn(rows)
            if part is not None:
                parts[kind] = part
                rows = rows.with_part(kind, part)
    if signature.paths is None:
        signature = _with_paths(signature, recording, rows if _beside(recording) else None)
    if signature.paths is not None:
        told = (*told, paths_note(signature.paths, recording.path))
    return signature, (*told, *(_told(kind, part, recording.path) for kind, part in parts.items()))


def _beside(recording: Recording) -> bool:
    """Whether there is anything but straight moves from stop to stop."""
    others = any(kind in (JOINT, CIRCULAR) for kind in recording.moves.kinds)
    return others or bool(stretches_of(recording.moves).ends_rolling.any())


def _too_few(recording: Recording, problem: OlpError) -> Diagnostic:
    """What H003 says of a recording that has more than straight moves."""
    measured = np.array(recording.moves.kinds, dtype=object)[np.nan_to_num(recording.moves.duration) > 0]
    joint, arcs = (int(np.sum(measured == kind)) for kind in (JOINT, CIRCULAR))
    if not joint + arcs:
        return problem.diagnostics[0]
    straight = problem.diagnostics[0].message.partition(",")[0]
    says = f"{straight}, {joint} joint moves and {arcs} arcs: at least {FEWEST} of one kind are needed"
    return error("H003", says, file=recording.path, help=problem.diagnostics[0].help)


def _possible(recording: Recording) -> tuple[Recording, list[Diagnostic]]:
    """The recording without the times of arcs that are faster than programmed, and what paths contradict each other."""
    moves = with_points(recording.moves, recording.robot, recording.tool)
    pieces, rows = pieces_of(moves, recording.robot, stretches_of(moves))
    resolution = float(np.nan_to_num(recording.noise_floor().resolution))
    measured = np.nan_to_num(moves.duration[rows])
    fast = faster_than_programmed(pieces, measured, resolution) & (measured > 0) & pieces.arc
    told = []
    if fast.any():
        shown = ", ".join(str(number) for number in moves.move[rows[fast]][:_SHOWN].tolist())
        says = f"{int(fast.sum())} arcs are faster than length over programmed speed and were left out: moves {shown}"
        told.append(warning("H005", says, file=recording.path, help="check their speed_mm_s and duration_s"))
    use = rows[(measured > 0) & ~fast]
    labels = np.unique(_programmed(recording)[use], axis=0, return_inverse=True)[1].reshape(-1)
    groups = contradicting(labels, moves.duration[use], resolution)
    told += contradiction_notes(groups, moves.move[use], moves.duration[use], recording.path)
    duration = moves.duration.copy()
    duration[rows[fast]] = np.nan
    return replace(recording, moves=replace(recording.moves, duration=duration)), told


def _programmed(recording: Recording) -> Floats:
    """(n, 3) the number of each row's move, and under which override and with which payload it ran."""
    moves = recording.moves
    conditions = np.nan_to_num(np.stack([moves.override, moves.payload], axis=1), nan=-1.0)
    return np.concatenate([recording.repeats()[:, None].astype(np.float64), conditions], axis=1)


def _told(kind: str, part: CorrectionPart, file: str) -> Diagnostic:
    what = {STOP: "straight moves at several speeds", CORNER: "stretches with corners"}.get(
        kind, f"{kind} moves"
    )
    learnt = ", ".join(
        f"{name} {p.value:.4g} ± {p.sd:.2g} {p.unit}"
        for name, p in part.quantities.items()
        if p.sd is not None
    )
    held = f"held out {part.unlearnt:.2f} % without, {part.learnt:.2f} % with it"
    return info("H021", f"{part.rows} {what}: {learnt or 'as the model says'} ({held})", file=file)


def _learn_stop(recording: Recording) -> CorrectionPart | None:
    """What a stop costs at any speed; None where the speeds do not tell or nothing is gained by it."""
    moves, _ = moves_of_recording(recording)
    moves = moves.take(np.isfinite(moves.duration) & (moves.duration > 0))
    if len(moves) < FEWEST or moves.speed.max() < _RATIO * moves.speed.min():
        return None
    way, speed, measured = moves.length, moves.speed, moves.duration
    start = np.array([0.0, max(float(np.median((measured - way / speed) / speed)), 1e-6)])

    def model(q: Floats) -> Floats:
        whole = speed * speed * q[1] <= way
        with np.errstate(invalid="ignore"):  # a search looks below zero, too, and turns back at a nan
            return np.asarray(q[0] + np.where(whole, way / speed + speed * q[1], 2 * np.sqrt(way * q[1])))

    part, found = learn_part(STOP, model, measured, _labels(moves.program), start)
    return part if 0 in found.form and part.value("fixed_time") > 0 else None


def _without_stops(recording: Recording, fixed: float) -> Recording:
    """The recording with that much taken off its straight moves from stop to stop."""
    _, rows = moves_of_recording(recording)
    duration = recording.moves.duration.copy()
    duration[rows] -= fixed
    return replace(recording, moves=replace(recording.moves, duration=duration))


def _learn_joints(recording: Recording) -> tuple[LearntArm | None, list[Diagnostic]]:
    """The law of the arm's joint moves and what there is to say of them: from those that run from stop to stop, of
    too few of these from all, those that run into others with what their corners save by olp's own law.
    """
    moves, robot = recording.moves, recording.robot
    axes = len(robot.axes) if robot is not None else moves.joints_start.shape[1]
    rated = told_inertia(moves, robot)
    joints, rows = recorded_joint_moves(moves, robot, recording.tool, axes, rated)
    stretches = stretches_of(moves)
    rolling = stretches.begins_rolling | stretches.ends_rolling | stretches.open
    use = np.nan_to_num(moves.duration[rows]) > 0
    use &= joints.motions.turned.max(axis=1, initial=0.0) > 0
    alone = use & ~rolling[rows]
    if alone.sum() >= FEWEST or alone.sum() == use.sum():
        use, rolling, saved = alone, np.zeros(len(moves), dtype=bool), np.zeros(len(moves))
    else:
        stands = 2.0 - stretches.begins_rolling - (stretches.ends_rolling | stretches.open)
        stops = (~stretches.ends_rolling & ~stretches.open).astype(np.float64)
        joints = joints.at_ends(np.asarray(stands[rows] / 2.0, dtype=np.float64), stops[rows])
        saved = _saved_by_corners(recording, stretches)
    joints, rows = joints.take(use), rows[use]
    measured = moves.duration[rows] + saved[rows]
    resolution = float(np.nan_to_num(recording.noise_floor().resolution))
    fast = faster_than_rated(robot, joints, measured, resolution)
    told = too_fast_notes(rows[fast], moves.move, robot, recording.path)
    joints, rows, measured = joints.take(~fast), rows[~fast], measured[~fast]
    if len(rows) < FEWEST:
        return None, told
    told += contradiction_notes(
        contradictions(joints, measured, resolution), moves.move[rows], measured, recording.path
    )
    controller = recording.settings.controller
    prior = arm_prior(robot, generations_in(controller or ""), [f"q{i + 1}" for i in range(axes)])
    prior = replace(prior, load_inertia=rated)
    if robot is not None:
        unsaid = np.isnan(moves.speed_fraction[rows])
        told += unsaid_speed_notes(joints, measured, prior, unsaid, recording.path)
    learnt = learn_arm(prior, joints, measured, _programs(recording, rows), resolution)
    return learnt, [*told, learnt_note(learnt, int(rolling[rows].sum()), recording.path)]


def _saved_by_corners(recording: Recording, stretches: Stretches) -> Floats:
    """(n,) [s] by olp's law of corners; 0 where it does not know."""
    robot = recording.robot
    moves = with_points(recording.moves, robot, recording.tool)
    motions = motions_of(moves, robot, recording.tool, lambda says: None)
    return np.nan_to_num(law_savings(moves, motions, stretches, robot)[0])


def _programs(recording: Recording, rows: NDArray[np.intp]) -> Labels:
    """(n,) which program each row belongs to, by the column `program`, else `job`."""
    names = recording.moves.texts.get("program", recording.moves.job)
    return _labels(tuple(names[i] for i in rows.tolist()))


def _learn_paths(recording: Recording) -> LearntPaths | None:
    """The law of lines and arcs from all measured ones; None of too few."""
    moves = with_points(recording.moves, recording.robot, recording.tool)
    stretches = stretches_of(moves)
    pieces, rows = pieces_of(moves, recording.robot, stretches)
    resolution = float(np.nan_to_num(recording.noise_floor().resolution))
    measured = np.nan_to_num(moves.duration[rows])
    use = (measured > 0) & ~stretches.open[rows] & ~faster_than_programmed(pieces, measured, resolution)
    pieces, rows = pieces.take(use), rows[use]
    if len(rows) < FEWEST:
        return None
    lines = line_acceleration(recording.robot, recording.settings.controller or "")
    return learn_paths(pieces, moves.duration[rows], _programs(recording, rows), lines, resolution)


def _with_paths(signature: Signature, recording: Recording, rows: RecordedTimes | None) -> Signature:
    """With the law of paths, for speeds that no straight move was learnt at, and for arcs of which none was.

    For corners too, if held-out pieces are nearer to it than all are to what was learnt of them otherwise.
    """
    moves = recording.moves if rows is None else rows.moves
    stretches = stretches_of(moves)
    along = np.array([kind in ("linear", "circular") for kind in moves.kinds], dtype=bool)
    beside = along & ~plain_rows(moves, stretches) & ~stretches.open & (np.nan_to_num(moves.duration) > 0)
    speeds = (moves.speed * moves.played)[along & np.isfinite(moves.speed)]
    if not beside.any() and (not len(speeds) or speeds.max() < _RATIO * speeds.min()):
        return signature  # straight moves at one speed, which the method tells
    paths = _learn_paths(recording)
    if paths is None:
        return signature
    if rows is not None and beside.sum() >= FEWEST:
        error = np.abs(rows.times.duration[beside] / moves.duration[beside] - 1.0)
        known = 100.0 * float(np.mean(np.where(np.isfinite(error), error, 1.0)))
        paths = replace(paths, corners=min(paths.held_out.values()) < known)
    return replace(signature, paths=paths)


def _without_straight(recording: Recording, arm: LearntArm | None, paths: LearntPaths | None) -> Signature:
    """A signature without a method for straight moves: if no law of paths, what is usual of any arm."""
    settings, robot = recording.settings, recording.robot
    learnt = sum(part.rows for part in (arm, paths) if part is not None)
    nothing = np.zeros((0, 6))
    payload = recording.moves.payload[np.isfinite(recording.moves.payload)]
    lines = line_acceleration(robot, settings.controller or "")
    slowness = 1.0 / lines.value
    doubt = slowness * float(np.expm1(lines.doubt))
    spread = Spread(slowness * float(np.expm1(_NORMAL * lines.doubt)), doubt, doubt, 2)
    return Signature(
        robot=robot.name if robot else "",
        controller=settings.controller or "",
        tool=None if recording.tool is None else tuple(float(v) for v in recording.tool.xyz_angles()),
        payload=float(np.median(payload)) if len(payload) else None,
        recording=Learnt(recording.path, recording.sha256, learnt, settings.time_resolution),
        method="constant",
        parameters={"slowness": LearntParameter(slowness, "s²/m", doubt)},
        errors=ErrorModel(spread, spread),
        domain=Domain((0.0, 0.0), (0.0, 0.0), None, nothing, nothing[:, :3], 0.0, 0.0),
        compared={},
        olp=__version__,
        paths=paths,
    )


def _learn_curves(rows: RecordedTimes) -> CorrectionPart | None:
    at = _stop_to_stop(rows, "circular")
    if at.sum() < FEWEST:
        return None
    motions, measured = rows.motions.take(at), rows.moves.duration[at]
    stop = rows.times.fixed[at]
    part, _ = learn_part(
        CIRCULAR, lambda q: motions.duration(q[0], 2) + stop + q[1], measured, _groups(rows, at)
    )
    return part


def _learn_corners(rows: RecordedTimes) -> CorrectionPart | None:
    found = _stretches(rows)
    if len(found.measured) < FEWEST:
        return None

    def model(q: Floats) -> Floats:
        return np.asarray(found.plain - q[0] * found.saving + q[1] + q[2] * found.corners)

    groups = _labels(tuple(rows.moves.job[i] for i in found.first.tolist()))
    part, _ = learn_part(CORNER, model, found.measured, groups, law=rows.law)
    # The sum of a stretch is what was fitted; where its rows part is the recorder's convention, and scatters more.
    times = rows.with_part(CORNER, part).times
    off = np.sort(np.abs(rows.moves.duration - times.duration)[found.rows])
    within = float(off[min(int(np.ceil(0.95 * (len(off) + 1))), len(off)) - 1])
    return part._replace(row_half=max(within, part.spread.half / 2))


def _stretches(rows: RecordedTimes) -> _Stretches:
    """The stretches with corners of which every row was measured and can be predicted."""
    label, times, moves = rows.stretches.label, rows.times, rows.moves
    rolls = rows.stretches.ends_rolling
    corners = np.bincount(label, rolls)
    plain = times.floor + times.over + times.fixed
    whole = (
        np.isfinite(plain) & np.isfinite(moves.duration) & np.isfinite(times.saving) & ~rows.stretches.open
    )
    good = (corners > 0) & (np.bincount(label, ~whole) == 0)
    first = np.unique(label, return_index=True)[1]
    sums = [np.bincount(label, np.nan_to_num(v))[good] for v in (moves.duration, plain, times.saving)]
    return _Stretches(sums[0], sums[1], sums[2], corners[good].astype(np.float64), first[good], good[label])


def _stop_to_stop(rows: RecordedTimes, kind: str) -> Mask:
    at = np.array([name == kind for name in rows.moves.kinds], dtype=bool)
    at &= (rows.stretches.stops == 2) & ~rows.stretches.open
    return np.asarray(at & np.isfinite(rows.times.duration) & np.isfinite(rows.moves.duration))


def _groups(rows: RecordedTimes, at: Mask) -> Labels:
    return _labels(tuple(rows.moves.job[i] for i in np.nonzero(at)[0].tolist()))


def _labels(names: tuple[str, ...]) -> Labels:
    order: dict[str, int] = {}
    return np.array([order.setdefault(name, len(order)) for name in names], dtype=np.int64)
