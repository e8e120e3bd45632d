"""From measured moves to a signature: fit, choice and error model, all from the recording alone.

Codes: H003 too few measured moves, H004 moves that cannot be used, H005 moves faster than length over speed,
H033 repeated moves, H054 lines whose tool is not told.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from olp.core.diagnostic import Diagnostic, OlpError, error, info, warning
from olp.core.version import __version__
from olp.identification.signature.document import Learnt, Score, Signature
from olp.identification.signature.domain import domain_of
from olp.identification.signature.errors import ErrorModel, Spread, spread_of
from olp.identification.signature.estimator import (
    Parameters,
    estimator_names,
    fit_or_refuse,
    load_estimator,
    measured_slowness,
)
from olp.identification.signature.folds import Trial, merit, merit_doubt, residuals, score_of, try_out
from olp.identification.signature.moveset import MoveSet, moves_of_recording

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


def calibrate(
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
    told.extend(_at_the_flange(recording))
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
        names = [n for n in estimator_names() if not load_estimator(n).needs(sample, robot)]
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
    """A note where lines are told by joints and no tool is."""
    from olp.identification.recording.moves import LINEAR

    moves = recording.moves
    lines = int(np.sum((moves.kind == LINEAR) & ~moves.has_points & moves.has_joints))
    if not lines or recording.tool is not None:
        return []
    says = f"{lines} lines are told by joints and no tool is: their ways are those of the flange"
    return [
        info(
            "H054",
            says,
            file=recording.path,
            help="give the tool (tool = in recording.toml) if it turns on them",
        )
    ]


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
