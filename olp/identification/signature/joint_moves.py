"""What a signature knows of joint moves: the arm's law with learnt numbers, and what it leaves, learnt by
example.

Codes: H050 recorded moves that contradict each other, H051 moves faster than the axes are rated, H052 what
joint moves told.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from olp.core.diagnostic import Diagnostic, info, warning
from olp.identification.signature.arm_fit import fit_arm
from olp.identification.signature.boosted_trees import BoostedTrees, fit_trees
from olp.identification.signature.slow_regions import SlowRegion, corrected, find_regions
from olp.timing.arm import ArmTiming, JointMotions, posture_functions
from olp.timing.arm_moves import JointMoves, JointTimes, joint_moves

if TYPE_CHECKING:
    from olp.identification.recording.moves import RecordedMoves
    from olp.robots.geometry import Pose
    from olp.robots.robot import Robot

Floats = NDArray[np.float64]
Mask = NDArray[np.bool_]
Labels = NDArray[np.int64]
Rows = NDArray[np.intp]

FEWEST: Final = 4
_FOLDS: Final = 4
_EXAMPLES: Final = 40  # moves from which on examples are learnt from
_TREES: Final = (50, 100, 200)
_MOST: Final = 4000  # of more moves this many tell which learner helps, and are its examples
_BETTER: Final = 0.02  # of the mean error that a learner has to take away on moves it did not see
_SURE: Final = 0.95
_MANY: Final = 100  # errors that tell their own quantile; of fewer it is no less than Student's
_NORMAL: Final = 1.96
_TOO_FAST: Final = 0.9  # of the time that the axes need at their rated speeds
_UNTOLD: Final = 0.85  # of the prior's sd that is left of a number that the moves did not tell
_TELLING: Final = 0.5  # of the prior's precision that the moves have to add to a number to have told it
_CONTRADICTION: Final = 8.0  # scatters between repeats of one move
_SAME: Final = 1e-3  # [rad | m], [1] moves that agree this well in everything programmed are one
_SHOWN: Final = 5


@dataclass(frozen=True, slots=True, eq=False)
class LearntArm:
    """`timing` after the recorded moves; `regions` and `trees` correct it where they helped on held-out moves.

    `quantile`: spreads that hold 95 % of held-out moves. `held_out` [%]: mean errors of the candidates on moves they
    did not see. `untold`: numbers that kept their prior. `rows`: moves it was learnt from.
    """

    timing: ArmTiming
    regions: tuple[SlowRegion, ...]
    trees: BoostedTrees | None
    quantile: float
    held_out: Mapping[str, float]
    untold: tuple[str, ...]
    rows: int

    def predict(self, moves: JointMoves) -> JointTimes:
        if not len(moves):
            return JointTimes(*np.zeros((3, 0)))
        law = self.timing.durations(moves.motions)
        duration = law.copy()
        good = np.isfinite(law) & (law > 0)
        if (self.regions or self.trees is not None) and good.any():
            own = moves.take(good)
            duration[good] = np.exp(_log_corrected(self, own, np.log(law[good])))
        wide = np.exp(self.quantile * self.timing.spread(moves.motions))
        return JointTimes(duration, duration / wide, duration * wide)

    def to_json(self) -> dict[str, Any]:
        timing = self.timing
        return {
            "axes": list(timing.axes),
            "parameters": {
                p.name: {
                    "value": float(f"{p.value:.6g}"),  # for people; `mean` is read
                    "unit": p.unit,
                    "mean": p.mean,
                    "sd": float(f"{p.sd:.6g}"),
                    "source": p.source,
                }
                for p in timing.parameters
            },
            "covariance": [row[: i + 1] for i, row in enumerate(timing.covariance.tolist())],
            "scatter": timing.scatter,
            "regions": [list(region) for region in self.regions],
            "trees": None if self.trees is None else self.trees.to_json(),
            "quantile_95": self.quantile,
            "held_out_percent": dict(self.held_out),
            "untold": list(self.untold),
            "rows": self.rows,
        }

    @staticmethod
    def from_json(content: Any) -> LearntArm:
        """Raises KeyError, TypeError or ValueError for what is no such object."""
        axes = tuple(str(axis) for axis in content["axes"])
        given = content["parameters"]
        names = ArmTiming(axes, np.zeros(0), np.zeros((0, 0)), (), 0.0).names
        mean = np.array([given[name]["mean"] for name in names], dtype=np.float64)
        covariance = np.zeros((len(names), len(names)))
        for i, row in enumerate(content["covariance"]):
            covariance[i, : i + 1] = covariance[: i + 1, i] = row
        if not (
            np.isfinite(mean).all() and np.isfinite(covariance).all() and (np.diag(covariance) >= 0).all()
        ):
            raise ValueError("numbers of the arm's law")
        timing = ArmTiming(
            axes, mean, covariance, tuple(str(given[n]["source"]) for n in names), float(content["scatter"])
        )
        trees = content["trees"]
        return LearntArm(
            timing,
            tuple(SlowRegion.from_json(region) for region in content["regions"]),
            None if trees is None else BoostedTrees.from_json(trees),
            float(content["quantile_95"]),
            {str(name): float(value) for name, value in content["held_out_percent"].items()},
            tuple(str(name) for name in content["untold"]),
            int(content["rows"]),
        )


def recorded_joint_moves(
    moves: RecordedMoves, robot: Robot | None, tool: Pose | None, axes: int
) -> tuple[JointMoves, Rows]:
    """Joint rows whose joints are known at both ends, and which rows of the recording they are.

    A row without a share of the speed runs at the rated speeds, unless a speed of the tool is written.
    """
    from olp.identification.recording.moves import JOINT
    from olp.identification.signature.places import joint_ends

    start, end = (
        joint_ends(moves, robot, tool) if robot is not None else (moves.joints_start, moves.joints_end)
    )
    if start.shape[1] != axes:
        return _nothing(axes), np.zeros(0, dtype=np.intp)
    known = (moves.kind == JOINT) & np.isfinite(start).all(axis=1) & np.isfinite(end).all(axis=1)
    known &= np.isfinite(moves.speed_fraction) | np.isnan(moves.speed)
    rows = np.flatnonzero(known)
    speed, acceleration, played = (
        _share(v[rows]) for v in (moves.speed_fraction, moves.acceleration_fraction, moves.override)
    )
    load, inertia = moves.payload[rows], moves.payload_inertia[rows]
    found = joint_moves(robot, start[rows], end[rows], speed, acceleration, played, load, inertia)
    return found, rows


def _nothing(axes: int) -> JointMoves:
    none, one = np.zeros((0, axes)), np.zeros(0)
    return JointMoves(JointMotions(none, posture_functions(none), none, none, one, one, one), none, none)


def _share(values: Floats) -> Floats:
    return np.where(np.isfinite(values) & (values > 0), values, 1.0)


# --- learning ---------------------------------------------------------------------------------------------------------


def learn_arm(
    prior: ArmTiming, moves: JointMoves, measured: Floats, groups: Labels, resolution: float = 0.0
) -> LearntArm:
    """From `measured` (n,) [s]; `groups` (n,): which rows belong to one program. n >= FEWEST."""
    some = _sample(len(moves), _MOST)
    chosen, held_out, ratios = _choose(prior, moves.take(some), measured[some], resolution)
    learnt = _fit(prior, moves, measured, resolution, chosen, some)
    quantile = max(
        _quantile(ratios), _between_groups(prior, moves.take(some), measured[some], groups[some], resolution)
    )
    untold = _untold(prior, learnt.timing)
    return LearntArm(learnt.timing, learnt.regions, learnt.trees, quantile, held_out, untold, len(moves))


def _untold(prior: ArmTiming, after: ArmTiming) -> tuple[str, ...]:
    """Numbers that the moves themselves say little of, or cannot tell from others; weights of the posture aside."""
    own = np.diag(np.linalg.inv(after.covariance) - np.linalg.inv(prior.covariance))
    few = (own * prior.sd**2 < _TELLING) | (after.sd > _UNTOLD * prior.sd)
    names = zip(prior.names, few.tolist(), strict=True)
    return tuple(name for name, kept in names if kept and not name.startswith("posture"))


class _Learner(NamedTuple):
    """What is learnt beside the law: whether regions, and how many trees."""

    name: str
    regions: bool
    trees: int


_LEARNERS: Final = (
    _Learner("law", False, 0),
    _Learner("law and regions", True, 0),
    *(_Learner(f"law and {n} trees", False, n) for n in _TREES),
    *(_Learner(f"law, regions and {n} trees", True, n) for n in _TREES),
)


def _fit(
    prior: ArmTiming, moves: JointMoves, measured: Floats, resolution: float, learner: _Learner, some: Rows
) -> LearntArm:
    """`some`: the rows that examples are taken from."""
    fitted = fit_arm(prior, moves.motions, measured, resolution)
    learnt = LearntArm(fitted.timing, (), None, _NORMAL, {}, (), len(moves))
    if learner.name == "law":
        return learnt
    own = moves.take(some)
    features, law = _features(fitted.timing, own), np.log(fitted.timing.durations(own.motions))
    log_measured = np.log(measured[some])
    regions = find_regions(features, law, log_measured) if learner.regions else ()
    trees = None
    if learner.trees:
        trees = fit_trees(features, log_measured - corrected(regions, features, law), learner.trees)
    return LearntArm(fitted.timing, regions, trees, _NORMAL, {}, (), len(moves))


def _log_corrected(learnt: LearntArm, moves: JointMoves, law: Floats) -> Floats:
    features = _features(learnt.timing, moves)
    result = corrected(learnt.regions, features, law)
    return result if learnt.trees is None else result + learnt.trees.predict(features)


def _features(timing: ArmTiming, moves: JointMoves) -> Floats:
    """(n, f) what examples are told apart by: joints at both ends and between, turns, the law's times, the speed."""
    start, end, motions = moves.start, moves.end, moves.motions
    middle = (start + end) / 2
    found = timing.durations(motions)
    columns = [start, middle, end, end - start, motions.turned]
    if start.shape[1] > 2:
        columns += [np.stack([q[:, 1] + q[:, 2], q[:, 1] - q[:, 2]], axis=1) for q in (start, middle, end)]
    columns.append(timing.axis_times(motions) / np.where(found > 0, found, 1.0)[:, None])
    columns.append(np.stack([np.log(np.where(found > 0, found, 1.0)), motions.fraction], axis=1))
    return np.concatenate(columns, axis=1)


def _choose(
    prior: ArmTiming, moves: JointMoves, measured: Floats, resolution: float
) -> tuple[_Learner, dict[str, float], Floats]:
    """The learner that does best on moves it did not see, all mean errors [%], and its errors over their spreads."""
    count = len(moves)
    learners = _LEARNERS if count >= _EXAMPLES else _LEARNERS[:1]
    fold = np.random.default_rng(0).permutation(count) % min(_FOLDS if count > 2 * FEWEST else count, count)
    errors = {learner: np.full(count, np.nan) for learner in learners}
    spread = np.full(count, np.nan)
    for number in range(int(fold.max()) + 1):
        out, rest = np.flatnonzero(fold == number), np.flatnonzero(fold != number)
        kept = moves.take(out)
        for regions in sorted({learner.regions for learner in learners}):
            most = max((x.trees for x in learners if x.regions == regions), default=0)
            learner = _Learner("law" if not regions and not most else "examples", regions, most)
            every = np.arange(len(rest))
            learnt = _fit(prior, moves.take(rest), measured[rest], resolution, learner, every)
            law = np.log(learnt.timing.durations(kept.motions))
            features = _features(learnt.timing, kept)
            base = corrected(learnt.regions, features, law)
            for candidate in (x for x in learners if x.regions == regions):
                added = np.zeros(len(out))
                if candidate.trees and learnt.trees is not None:
                    added = learnt.trees.take(candidate.trees).predict(features)
                errors[candidate][out] = np.log(measured[out]) - base - added
        spread[out] = learnt.timing.spread(kept.motions)
    means = {learner: float(np.mean(np.abs(np.expm1(-e)))) for learner, e in errors.items()}
    best = min(learners, key=means.__getitem__)
    chosen = next(x for x in learners if means[x] <= (1.0 + _BETTER) * means[best])
    held_out = {learner.name: 100.0 * mean for learner, mean in means.items()}
    return chosen, held_out, np.abs(errors[chosen]) / spread


def _between_groups(
    prior: ArmTiming, moves: JointMoves, measured: Floats, groups: Labels, resolution: float
) -> float:
    """[spreads] that hold 95 % of the moves of programs that were not learnt; 0 where one program is all there is."""
    labels, counts = np.unique(groups, return_counts=True)
    large = labels[counts >= max(FEWEST, len(groups) // 10)]
    if len(large) < 2:
        return 0.0
    ratios = []
    for label in large[:_FOLDS].tolist():
        out, rest = np.flatnonzero(groups == label), np.flatnonzero(groups != label)
        learnt = fit_arm(prior, moves.motions.take(rest), measured[rest], resolution).timing
        own = moves.motions.take(out)
        ratios.append(np.abs(np.log(measured[out] / learnt.durations(own))) / learnt.spread(own))
    return _quantile(np.concatenate(ratios))


def _quantile(ratios: Floats) -> float:
    """[spreads] that hold 95 % of moves, a new one counted with them; never less than one."""
    from olp.identification.signature.errors import Spread

    count = len(ratios)
    usual = Spread(1.0, 0.0, 1.0, max(count - 1, 2)).quantile
    place = int(np.ceil(_SURE * (count + 1)))
    if place > count:  # of fewer than nineteen the largest one stands for less than 95 %
        scale = float(np.sqrt(np.mean(np.minimum(ratios, 10.0) ** 2))) if count else 1.0
        return max(scale, 1.0) * usual
    found = float(np.sort(ratios)[place - 1])
    return max(found, usual if count < _MANY else 1.0)


def _sample(count: int, most: int) -> Rows:
    return np.arange(count) if count <= most else np.linspace(0, count - 1, most).astype(np.intp)


# --- what is wrong with a recording -----------------------------------------------------------------------------------


def faster_than_rated(robot: Robot | None, moves: JointMoves, measured: Floats, resolution: float) -> Mask:
    """(n,) moves that took less time than an axis needs at its rated speed."""
    if robot is None:
        return np.zeros(len(moves), dtype=bool)
    pace = (moves.motions.fraction * np.minimum(moves.motions.override, 1.0))[:, None] * robot.speeds
    least = np.max(moves.motions.turned / pace, axis=1, initial=0.0)
    return np.asarray(measured + resolution < _TOO_FAST * least)


def contradictions(moves: JointMoves, measured: Floats, resolution: float) -> list[Rows]:
    """Groups of rows that were programmed alike and took times beyond any scatter of the others."""
    shares = np.stack([moves.motions.fraction, moves.motions.acceleration, moves.motions.override], axis=1)
    keys = np.round(np.concatenate([moves.start, moves.end, shares, moves.motions.load], axis=1) / _SAME)
    _, label = np.unique(keys, axis=0, return_inverse=True)
    label = label.reshape(-1)
    logs = np.log(measured)
    middle = (
        np.array([np.median(logs[label == i]) for i in range(int(label.max()) + 1)]) if len(label) else logs
    )
    away = np.abs(logs - middle[label])
    again = np.bincount(label)[label] > 1 if len(label) else np.zeros(0, dtype=bool)
    if not again.any():
        return []
    usual = max(1.4826 * float(np.median(away[again])), 0.005)
    bad = again & (away > _CONTRADICTION * np.hypot(usual, resolution / measured))
    return [np.flatnonzero(label == i) for i in np.unique(label[bad]).tolist()]


def contradiction_notes(
    groups: Sequence[Rows], move: Labels, measured: Floats, file: str
) -> list[Diagnostic]:
    """One warning for all of them, with the first groups' rows."""
    if not groups:
        return []
    shown = [
        "moves " + ", ".join(f"{move[row]} ({measured[row]:.3f} s)" for row in rows[:_SHOWN].tolist())
        for rows in groups[:_SHOWN]
    ]
    says = f"{len(groups)} moves were recorded again with times beyond any scatter: {'; '.join(shown)}"
    help = (
        "look for a pause, another override or load in these rows; the usual time of each was believed most"
    )
    return [warning("H050", says, file=file, help=help)]


def too_fast_notes(rows: Rows, move: Labels, file: str) -> list[Diagnostic]:
    if not len(rows):
        return []
    shown = ", ".join(str(move[row]) for row in rows[:_SHOWN].tolist())
    says = f"{len(rows)} joint moves are faster than the rated speeds of the axes and were left out: moves {shown}"
    help = "check robot, joints, speed_pct and duration_s of these rows"
    return [warning("H051", says, file=file, help=help)]


def learnt_note(learnt: LearntArm, file: str) -> Diagnostic:
    best = min(learnt.held_out, key=learnt.held_out.__getitem__)
    says = (
        f"{learnt.rows} joint moves: mean error on held-out ones {learnt.held_out['law']:.2f} % by the law, "
        f"{learnt.held_out[best]:.2f} % by {best}"
    )
    if learnt.untold:
        says += f"; not told by these moves, as before them: {', '.join(learnt.untold)}"
    return info("H052", says, file=file)
