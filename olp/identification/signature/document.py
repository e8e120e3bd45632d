"""The signature as an object: what was learnt, from what, how sure, and where it holds.

Lines and arcs with corners between them have a law of their own (`LearntPaths`), and what the law leaves unexplained is
learnt by example. Code: H053 what was learnt of paths.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from olp.core.diagnostic import Diagnostic, info
from olp.identification.signature.coefficients import CorrectionPart, LearntParameter
from olp.identification.signature.domain import Domain
from olp.identification.signature.errors import ErrorModel
from olp.identification.signature.joint_moves import LearntArm, held_out_words
from olp.identification.signature.stretch_times import arc_length, zones
from olp.timing.path_law import NUMBERS, SCATTER, PathPieces, path_durations, prior_numbers

if TYPE_CHECKING:
    from olp.identification.recording.moves import RecordedMoves
    from olp.identification.signature.stretches import Stretches
    from olp.robots.model import Robot
    from olp.timing.arm_prior import LineAcceleration

Floats = NDArray[np.float64]
Mask = NDArray[np.bool_]
Labels = NDArray[np.int64]
Rows = NDArray[np.intp]

_FREEDOM: Final = 3.0  # of Student's t
_ROUNDS: Final = 40
_STEP: Final = 1e-5  # for derivatives
_LEAST_SCATTER: Final = 0.003
_FOLDS: Final = 5
_EXAMPLES: Final = 20  # pieces from which on examples are learnt from
_MOST: Final = 600  # examples that are kept
_MOST_FITTED: Final = 2000  # of more pieces this many tell the numbers
_LENGTHS: Final = (2.0, 4.0)  # [sd of a feature] over which a residual changes
_SIZE: Final = 0.05  # [1] of what the law leaves
_NOISE: Final = 0.01  # [1] of a piece recorded again
_BETTER: Final = 0.02
_AT_ONCE: Final = 2048  # rows that a kernel is made for: more leave the processor's own memory
_WHOLE_CIRCLE: Final = 0.02  # of the way to the middle point: an end nearer to the start closes a circle
_TILT: Final = 1.5
_NORMAL: Final = 1.96
_TOO_FAST: Final = 0.9  # of the time at programmed speed
_NAMES: Final = tuple(number.name for number in NUMBERS)


class PathRows(NamedTuple):
    """`rows` (m,) of a recording and what the law of paths says of them, (m,) [s] each."""

    rows: Rows
    duration: Floats
    low: Floats
    high: Floats


class Examples(NamedTuple):
    """A Gaussian process of what the law leaves: scaled features (m, f), their weights (m,), and how to scale."""

    features: Floats
    weights: Floats
    centre: Floats
    scale: Floats  # (f,) 0 for a feature that was the same in all examples
    length: float

    def predict(self, features: Floats) -> Floats:
        """(n,) of ln(duration)."""
        scaled = _scaled(features, self.centre, self.scale)
        result = np.zeros(len(scaled))
        for begin in range(0, len(scaled), _AT_ONCE):
            rows = slice(begin, begin + _AT_ONCE)
            result[rows] = _kernel(scaled[rows], self.features, self.length) @ self.weights
        return result


@dataclass(frozen=True, slots=True, eq=False)
class LearntPaths:
    """`numbers` of the law in the order of NUMBERS, and their `covariance`.

    `half` of ln(duration) holds 95 % of held-out pieces, which are like those learnt from. `corners`: whether corners
    and arcs were among the pieces, and the law was nearer to them than the parts.
    """

    numbers: Floats
    covariance: Floats
    examples: Examples | None
    half: float
    held_out: Mapping[str, float]  # [%]
    rows: int
    corners: bool = False

    def predict(self, pieces: PathPieces) -> Floats:
        """(n,) [s]"""
        law = path_durations(self.numbers, pieces)
        if self.examples is None or not len(pieces):
            return law
        return np.asarray(law * np.exp(self.examples.predict(_features(self.numbers, pieces))))

    def halves(self, pieces: PathPieces) -> Floats:
        """(n,) of ln(duration) that hold 95 %: a corner is hardly known where none was learnt."""
        slope = _slope(self.numbers, pieces)
        unknown = np.sqrt(np.sum((slope @ self.covariance) * slope, axis=1))
        return np.asarray(np.hypot(self.half, _NORMAL * unknown))

    def of_rows(self, moves: RecordedMoves, robot: Robot | None, stretches: Stretches) -> PathRows:
        pieces, rows = pieces_of(moves, robot, stretches)
        duration = self.predict(pieces)
        wide = np.exp(self.halves(pieces))
        return PathRows(rows, duration, duration / wide, duration * wide)

    def to_json(self) -> dict[str, Any]:
        examples = self.examples
        return {
            "numbers": {
                n.name: {"mean": value, "unit": n.unit, "logarithmic": n.logarithmic}
                for n, value in zip(NUMBERS, self.numbers.tolist(), strict=True)
            },
            "examples": None
            if examples is None
            else {k: v.tolist() if isinstance(v, np.ndarray) else v for k, v in examples._asdict().items()},
            "covariance": [row[: i + 1] for i, row in enumerate(self.covariance.tolist())],
            "half_95": self.half,
            "held_out_percent": dict(self.held_out),
            "rows": self.rows,
            "corners": self.corners,
        }

    @staticmethod
    def from_json(content: Any) -> LearntPaths:
        """Reads the object back. Raises KeyError, TypeError or ValueError for anything else."""
        numbers = np.array([content["numbers"][name]["mean"] for name in _NAMES], dtype=np.float64)
        given, examples = content["examples"], None
        if given is not None:
            arrays = [
                np.array(given[key], dtype=np.float64) for key in ("features", "weights", "centre", "scale")
            ]
            examples = Examples(arrays[0], arrays[1], arrays[2], arrays[3], float(given["length"]))
            shape = arrays[0].shape
            if shape != (len(arrays[1]), len(arrays[2])) or arrays[2].shape != arrays[3].shape:
                raise ValueError("examples of different shapes")
        covariance = np.zeros((len(numbers), len(numbers)))
        for i, row in enumerate(content["covariance"]):
            covariance[i, : i + 1] = covariance[: i + 1, i] = row
        half = float(content["half_95"])
        known = np.isfinite(numbers).all() and np.isfinite(covariance).all()
        if not (known and (np.diag(covariance) >= 0).all() and half >= 0):
            raise ValueError("numbers of the law of paths")
        held_out = {str(name): float(value) for name, value in content["held_out_percent"].items()}
        rows, corners = int(content["rows"]), bool(content["corners"])
        return LearntPaths(numbers, covariance, examples, half, held_out, rows, corners)


# --- pieces of a recording --------------------------------------------------------------------------------------------


def pieces_of(moves: RecordedMoves, robot: Robot | None, stretches: Stretches) -> tuple[PathPieces, Rows]:
    """Lines and arcs with points and a speed that go somewhere, and which rows of the recording they are."""
    from olp.identification.recording.moves import CIRCULAR, LINEAR
    from olp.identification.signature.stretches import meets

    count = len(moves)
    arc = moves.kind == CIRCULAR
    length, curvature, first, last = _shapes(moves, arc)
    rolling = np.stack([stretches.begins_rolling, stretches.ends_rolling], axis=1)
    zone = np.nan_to_num(zones(moves, robot))
    with np.errstate(invalid="ignore"):
        turn = np.nan_to_num(np.arccos(np.clip(np.sum(last[:-1] * first[1:], axis=1), -1.0, 1.0)))
    axis, wrist = _axes(moves, robot, length)
    axis = np.where(arc & (np.nan_to_num(moves.chord) < _WHOLE_CIRCLE * length), 0.0, axis)
    tilt = np.minimum(np.abs(np.diff(wrist)) / 2, _TILT)
    joins = meets(moves) if count > 1 else np.zeros(0, dtype=bool)
    pieces = PathPieces(
        length=length,
        speed=moves.speed,
        acceleration=moves.acceleration,
        share=np.where(
            ~(moves.acceleration > 0) & (moves.acceleration_fraction > 0), moves.acceleration_fraction, 1.0
        ),
        arc=arc,
        curvature=curvature,
        override=moves.played,
        rolling=rolling,
        zone=_both(zone[:-1], rolling),
        turn=_both(turn, rolling),
        tilt=_both(tilt, rolling),
        axis=axis,
        first=~np.concatenate([[False], joins])[:count],
    )
    good = ((moves.kind == LINEAR) | arc) & (np.nan_to_num(length) > 0) & (np.nan_to_num(moves.speed) > 0)
    rows = np.flatnonzero(good)
    return pieces.take(rows), rows


def _both(between: Floats, rolling: Mask) -> Floats:
    """(n, 2): a value per joint between neighbours (n - 1,) given to both ends of each move; 0 at stops."""
    result = np.zeros(rolling.shape)
    if len(between):
        result[1:, 0], result[:-1, 1] = between, between
    return np.where(rolling, result, 0.0)


def _shapes(moves: RecordedMoves, arc: Mask) -> tuple[Floats, Floats, Floats, Floats]:
    """(n,) [m] along the path and [1/m] its curvature, (n, 3) its directions at the start and at the end."""
    from olp.runtime.paths import circle

    length = moves.chord.copy()
    with np.errstate(divide="ignore", invalid="ignore"):
        first = (moves.end - moves.start) / length[:, None]
    last, curvature = first.copy(), np.zeros(len(moves))
    if arc.any():
        start, via, end = moves.start[arc], moves.via[arc], moves.end[arc]
        with np.errstate(divide="ignore", invalid="ignore"):
            centre, radius, normal = circle(start, via, end)
            first[arc] = np.cross(normal, start - centre) / radius[:, None]
            last[arc] = np.cross(normal, end - centre) / radius[:, None]
        way = np.linalg.norm(via - start, axis=1)
        # An end at the start tells no radius: the middle point is then taken as the opposite one.
        whole = length[arc] < _WHOLE_CIRCLE * way
        with np.errstate(divide="ignore", invalid="ignore"):
            curvature[arc] = np.nan_to_num(np.where(whole, 2.0 / way, 1.0 / radius))
        length[arc] = np.where(whole, np.pi * way, arc_length(start, via, end))
    return length, curvature, first, last


def _axes(moves: RecordedMoves, robot: Robot | None, length: Floats) -> tuple[Floats, Floats]:
    """(n,) [s] that the slowest axis needs, and (n,) [rad/m] that the wrist turns; 0 where not known."""
    if robot is None or moves.joints_start.shape[1] != len(robot.axes):
        return np.zeros(len(moves)), np.zeros(len(moves))
    turned = np.abs(moves.joints_end - moves.joints_start)
    axis = np.nan_to_num(np.max(turned / robot.speeds, axis=1, initial=0.0))
    with np.errstate(divide="ignore", invalid="ignore"):
        wrist = np.nan_to_num(np.linalg.norm(turned[:, 3:], axis=1) / length, posinf=0.0)
    return axis, wrist


def faster_than_programmed(pieces: PathPieces, measured: Floats, resolution: float) -> Mask:
    """(n,) pieces from stop to stop that took less time than their length needs at the programmed speed."""
    least = pieces.length / (pieces.speed * pieces.override)
    return np.asarray(~pieces.rolling.any(axis=1) & (measured + resolution < _TOO_FAST * least))


# --- learning ---------------------------------------------------------------------------------------------------------


def learn_paths(
    pieces: PathPieces, measured: Floats, groups: Labels, lines: LineAcceleration, resolution: float
) -> LearntPaths:
    """From `measured` (n,) [s], n >= 4; `groups`: programs; `lines`: what was known of the arm before."""
    if len(measured) > _MOST_FITTED:
        some = np.linspace(0, len(measured) - 1, _MOST_FITTED).astype(np.intp)
        pieces, measured, groups = pieces.take(some), measured[some], groups[some]
    fold = _fold(groups)
    lengths = (0.0, *_LENGTHS) if len(measured) >= _EXAMPLES else (0.0,)
    errors = {length: np.zeros(len(measured)) for length in lengths}
    for number in np.unique(fold).tolist():
        out, rest = np.flatnonzero(fold == number), np.flatnonzero(fold != number)
        numbers, _ = _fit(pieces.take(rest), measured[rest], lines, resolution)
        law = np.log(path_durations(numbers, pieces.take(out)))
        for length in lengths:
            added = np.zeros(len(out))
            if length:
                near = _examples(numbers, pieces.take(rest), measured[rest], length)
                added = near.predict(_features(numbers, pieces.take(out)))
            errors[length][out] = np.log(measured[out]) - law - added
    means = {length: float(np.mean(np.abs(np.expm1(-e)))) for length, e in errors.items()}
    best = min(means.values())
    chosen = next(length for length in lengths if means[length] <= (1.0 + _BETTER) * best)
    numbers, covariance = _fit(pieces, measured, lines, resolution)
    examples = _examples(numbers, pieces, measured, chosen) if chosen else None
    held_out = {f"law and examples over {n:g}" if n else "law": 100.0 * mean for n, mean in means.items()}
    return LearntPaths(numbers, covariance, examples, _half(errors[chosen]), held_out, len(measured))


def _fold(groups: Labels) -> Labels:
    """Labels of the folds: whole programs where there are several, else every fifth piece."""
    if len(np.unique(groups)) >= 2:
        return groups % _FOLDS if groups.max() >= _FOLDS else groups
    return np.arange(len(groups), dtype=np.int64) % _FOLDS


def _half(errors: Floats) -> float:
    from olp.identification.signature.errors import Spread

    count, away = len(errors), np.sort(np.abs(errors))
    place = int(np.ceil(0.95 * (count + 1)))
    if place <= count:
        return float(away[place - 1])
    return float(np.sqrt(np.mean(away**2))) * Spread(1.0, 0.0, 1.0, max(count - 1, 2)).quantile


def _fit(
    pieces: PathPieces, measured: Floats, lines: LineAcceleration, resolution: float
) -> tuple[Floats, Floats]:
    """The most probable numbers and their covariance: Gauss-Newton with Student's weights."""
    prior, sd = prior_numbers(lines)
    logs, rounding = np.log(measured), resolution / np.sqrt(12.0) / measured
    numbers, scatter, damping = prior.copy(), SCATTER, 1e-3

    def cost(values: Floats, left: Floats, variance: Floats) -> float:
        own = (_FREEDOM + 1.0) * np.sum(np.log1p(left**2 / (_FREEDOM * variance)))
        return float(own + np.sum(((values - prior) / sd) ** 2))

    left = logs - np.log(path_durations(numbers, pieces))
    for _ in range(_ROUNDS):
        variance = scatter**2 + rounding**2
        weight = (_FREEDOM + 1.0) / (_FREEDOM + left**2 / variance) / variance
        slope = _slope(numbers, pieces)
        normal = slope.T @ (slope * weight[:, None]) + np.diag(sd**-2.0)
        pull = slope.T @ (weight * left) - (numbers - prior) / sd**2
        now = cost(numbers, left, variance)
        for _ in range(8):
            step = np.linalg.solve(normal + damping * np.diag(np.diag(normal)), pull)
            trial = logs - np.log(path_durations(numbers + step, pieces))
            if np.isfinite(trial).all() and cost(numbers + step, trial, variance) <= now:
                break
            damping *= 8.0
        else:
            break
        numbers, left = np.asarray(numbers + step, dtype=np.float64), trial
        damping = max(damping / 6.0, 1e-9)
        found = 1.4826 * float(np.median(np.abs(left)))
        scatter = max((len(left) * found + 8 * SCATTER) / (len(left) + 8), _LEAST_SCATTER)
        if np.max(np.abs(step) / sd) < 1e-3:
            break
    variance = scatter**2 + rounding**2
    weight = (_FREEDOM + 1.0) / (_FREEDOM + left**2 / variance) / variance
    slope = _slope(numbers, pieces)
    covariance = np.linalg.inv(slope.T @ (slope * weight[:, None]) + np.diag(sd**-2.0))
    return numbers, np.asarray(covariance)


def _slope(numbers: Floats, pieces: PathPieces) -> Floats:
    """(n, p): derivatives of ln(duration) by the p numbers, by finite differences."""
    columns = []
    for i in range(len(numbers)):
        bent = np.zeros(len(numbers))
        bent[i] = _STEP
        high, low = (np.log(path_durations(numbers + sign * bent, pieces)) for sign in (1.0, -1.0))
        columns.append((high - low) / (2 * _STEP))
    return np.stack(columns, axis=1)


def _features(numbers: Floats, pieces: PathPieces) -> Floats:
    """(n, f): the features by which examples are compared."""
    law = path_durations(numbers, pieces)
    highest = float(np.exp(numbers[_NAMES.index("highest speed")]))
    single: tuple[Floats, ...] = (
        np.log(pieces.length / law),
        np.log(np.minimum(pieces.speed * pieces.override, highest)),
        np.asarray(pieces.arc, dtype=np.float64),
        np.asarray(pieces.first, dtype=np.float64),
        np.log(pieces.axis / law + 0.01),
    )
    pairs = (
        np.asarray(pieces.rolling, dtype=np.float64),
        np.log1p(pieces.zone / 1e-3),
        pieces.turn,
        pieces.tilt,
    )
    return np.concatenate([*(v[:, None] for v in single), *pairs], axis=1)


def _examples(numbers: Floats, pieces: PathPieces, measured: Floats, length: float) -> Examples:
    keep = np.arange(len(measured))
    if len(keep) > _MOST:
        keep = np.linspace(0, len(keep) - 1, _MOST).astype(np.intp)
    own = pieces.take(keep)
    features = _features(numbers, own)
    centre, spread = features.mean(axis=0), features.std(axis=0)
    scale = np.where(spread > 1e-3, spread, 0.0)
    scaled = _scaled(features, centre, scale)
    left = np.log(measured[keep] / path_durations(numbers, own))
    matrix = _kernel(scaled, scaled, length) + _NOISE**2 * np.eye(len(keep))
    return Examples(
        scaled, np.asarray(np.linalg.solve(matrix, left), dtype=np.float64), centre, scale, length
    )


def _scaled(features: Floats, centre: Floats, scale: Floats) -> Floats:
    return np.asarray(np.where(scale > 0, (features - centre) / np.where(scale > 0, scale, 1.0), 0.0))


def _kernel(one: Floats, two: Floats, length: float) -> Floats:
    apart = np.sum(one**2, axis=1)[:, None] + np.sum(two**2, axis=1) - 2.0 * one @ two.T
    return np.asarray(_SIZE**2 * np.exp(-np.maximum(apart, 0.0) / (2.0 * length**2)))


def paths_note(learnt: LearntPaths, file: str) -> Diagnostic:
    says = f"{learnt.rows} lines and arcs: {held_out_words(learnt.held_out)}"
    return info("H053", says, file=file)


SCHEMA = "olp-signature"
# 2 holds `parts`, 3 the law of joint moves, which an older olp would leave out in silence: what is not there lowers the
# version that is written. 8 holds the inertia of the rated load.
VERSION = 8
_LAWS_AS_NOW = 7


class Learnt(NamedTuple):
    """The recording behind a signature. `moves`: those that were used; `resolution` [s] of their times, or None."""

    name: str
    sha256: str
    moves: int
    resolution: float | None


class Score(NamedTuple):
    """Held-out mean absolute percentage errors [%] inside the recording; nan where it could not be held out."""

    moves: float  # every tenth move at a time
    starts: float  # whole start points
    directions: float = float("nan")  # all moves towards the base, away from it, down, up


@dataclass(frozen=True, slots=True)
class Signature:
    """`tool` (6,) [m, rad] on the flange and `payload` [kg]: None where the recording does not say."""

    robot: str
    controller: str
    tool: tuple[float, ...] | None
    payload: float | None
    recording: Learnt
    method: str
    parameters: Mapping[str, LearntParameter]
    errors: ErrorModel
    domain: Domain
    compared: Mapping[str, Score]
    olp: str
    parts: Mapping[str, CorrectionPart] = field(
        default_factory=dict
    )  # what was learnt beside straight moves, see coefficients.py
    arm: LearntArm | None = None  # what was learnt of joint moves
    paths: LearntPaths | None = None  # what was learnt of arcs and of paths with corners

    @property
    def knows_paths(self) -> bool:
        """Whether any line or arc was learnt; else olp's own model times them."""
        return not self.domain.empty or self.paths is not None

    @property
    def version(self) -> int:
        """The version of the file: the oldest one that can hold all of the content."""
        if self.arm is not None and self.arm.timing.load_inertia is not None:
            return VERSION
        if self.arm is not None or self.paths is not None:
            return _LAWS_AS_NOW
        return 2 if self.parts else 1
