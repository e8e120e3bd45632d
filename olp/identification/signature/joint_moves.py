"""What a signature knows of joint moves: the arm's law with learnt numbers, and what it leaves, learnt by
example.

Codes: H050 recorded moves that contradict each other, H051 moves faster than the axes are rated, H052 what
joint moves told, H055 joint moves that tell less than olp knows without them, H056 joint moves whose speed is not told
and that are slow.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, Final, NamedTuple

import numpy as np
from numpy.typing import NDArray

from olp.core.diagnostic import Diagnostic, info, warning
from olp.identification.signature.boosted_trees import BoostedTrees, fit_trees
from olp.timing.arm import ArmTiming, JointMotions, gradient, solve
from olp.timing.arm_moves import JointMoves, JointTimes, joint_moves, rated_inertia
from olp.timing.arm_prior import fastest_speed

if TYPE_CHECKING:
    from olp.identification.recording.moves import RecordedMoves
    from olp.robots.geometry import Pose
    from olp.robots.model import Robot


# --- Slow regions ---
# Regions of one feature in which moves take far longer than the law says, or always the same time.
#
# Controllers slow down near a limit, in a protected zone, or replan: a few moves, all beyond one bound of one
# feature. A single split with medians on both sides finds such a region from a handful of moves, where many
# small trees need hundreds.

Floats = NDArray[np.float64]

_FEWEST: Final = 4  # moves that make a region
_CUTS: Final = 64
_SLOW_REGIONS_MOST: Final = 3  # regions
_GAIN: Final = 0.04  # of the sum of absolute errors that a region has to take away at least
_DIFFERENT: Final = (
    0.15  # of the logarithm: a region differs by this much, smaller steps are for smooth learners
)


class SlowRegion(NamedTuple):
    """Moves whose `feature` is above `bound` (below, if not `above`): ln(duration) = share x law + offset.

    `share` is 1, or 0 where all of them take the same time.
    """

    feature: int
    bound: float
    above: bool
    share: float
    offset: float

    def holds(self, features: Floats) -> NDArray[np.bool_]:
        values = features[:, self.feature]
        return np.asarray(values > self.bound if self.above else values <= self.bound)

    @staticmethod
    def from_json(content: Any) -> SlowRegion:
        """Raises TypeError or ValueError for what is no region."""
        feature, bound, above, share, offset = content
        return SlowRegion(int(feature), float(bound), bool(above), float(share), float(offset))


def corrected(regions: Sequence[SlowRegion], features: Floats, log_law: Floats) -> Floats:
    """(n,) ln(duration) of the law with the regions, a later one over an earlier one."""
    result = log_law.copy()
    for region in regions:
        inside = region.holds(features)
        result[inside] = region.share * log_law[inside] + region.offset
    return result


def find_regions(features: Floats, log_law: Floats, log_measured: Floats) -> tuple[SlowRegion, ...]:
    """The regions that take most of the absolute errors away, none if all are alike."""
    found: list[SlowRegion] = []
    for _ in range(_SLOW_REGIONS_MOST):
        now = log_measured - corrected(found, features, log_law)
        best = _best(features, log_law, log_measured, now)
        if best is None:
            break
        found.append(best)
    return tuple(found)


def _best(features: Floats, log_law: Floats, log_measured: Floats, now: Floats) -> SlowRegion | None:
    count = len(now)
    if count < 2 * _FEWEST:
        return None
    total = np.abs(now)
    best, most = None, _GAIN * float(total.sum())
    for feature in range(features.shape[1]):
        order = np.argsort(features[:, feature], kind="stable")
        values = features[order, feature]
        for cut in _cuts(values):
            for above, rows in ((True, order[cut:]), (False, order[:cut])):
                if not _FEWEST <= len(rows) <= count // 2:
                    continue
                gain, shift = _gain(log_measured[rows] - log_law[rows], total[rows])
                if gain > most and abs(float(np.median(now[rows]))) > _DIFFERENT:
                    bound = float(values[cut - 1] + values[cut]) / 2
                    best, most = SlowRegion(feature, bound, above, 1.0, shift), gain
    if best is None:
        return None
    best = _sharpened(best, most, features[:, best.feature], log_measured - log_law, total)
    rows = np.flatnonzero(best.holds(features))
    same = float(np.median(log_measured[rows]))
    if np.sum(np.abs(log_measured[rows] - same)) < np.sum(
        np.abs(log_measured[rows] - log_law[rows] - best.offset)
    ):
        return best._replace(share=0.0, offset=same)
    return best


def _gain(residual: Floats, total: Floats) -> tuple[float, float]:
    """What a shift by the median takes away of the absolute errors `total`, and the shift."""
    shift = float(np.median(residual))
    return float(np.sum(total - np.abs(residual - shift))), shift


def _sharpened(
    region: SlowRegion, gain: float, values: Floats, residual: Floats, total: Floats
) -> SlowRegion:
    """The same region with the best of all bounds near its own."""
    order = np.argsort(values, kind="stable")
    ordered, count = values[order], len(values)
    at = int(np.searchsorted(ordered, region.bound))
    reach = count // _CUTS + 2
    for cut in range(max(at - reach, _FEWEST), min(at + reach, count - _FEWEST) + 1):
        rows = order[cut:] if region.above else order[:cut]
        if ordered[cut] > ordered[cut - 1] and _FEWEST <= len(rows) <= count // 2:
            found, shift = _gain(residual[rows], total[rows])
            if found > gain:
                gain = found
                region = region._replace(bound=float(ordered[cut - 1] + ordered[cut]) / 2, offset=shift)
    return region


def _cuts(values: Floats) -> list[int]:
    """Where a sorted feature may be split, denser towards both ends."""
    count = len(values)
    inner = np.linspace(0, count, _CUTS + 2)[1:-1].astype(np.int64)
    edge = np.unique(np.geomspace(_FEWEST, count // 2, _CUTS // 2).astype(np.int64))
    cuts = np.unique(np.concatenate([inner, edge, count - edge]))
    return [int(c) for c in cuts if 0 < c < count and values[c] > values[c - 1]]


# --- Arm fit ---
# From recorded joint moves to an arm's timing: the most probable numbers under the prior, and what they leave
# unknown.
#
# Gauss-Newton on the logarithms of the durations with Student's weights, so that pauses and replanned moves
# count little, nor does a number told of this arm that the moves contradict: it may run at half of its rated speeds.
# A spread over all arms holds for this one, too: few moves with a pause among them must not lead beyond it.


_FREEDOM: Final = (
    3.0  # degrees of freedom of Student's t: one move in twenty is off by more than three scatters
)
_STEPS: Final = 60
_LEAST_SCATTER: Final = 0.004
_TOLD: Final = (
    0.25  # [1 | s] prior sd up to which a number is told of this arm; of more it is a spread over arms
)
_MISFIT: Final = 2.0  # of the prior's scatter: a law that leaves more does not fit
_KNOWN_SCATTER_WEIGHT: Final = 8.0  # moves that the prior's scatter counts as much as


class ArmFit(NamedTuple):
    """`timing` after the moves; `residual` (n,) ln(measured/law) and `weight` (n,) that each move had, 0 to 1 about."""

    timing: ArmTiming
    residual: Floats
    weight: Floats


def fit_arm(prior: ArmTiming, motions: JointMotions, measured: Floats, resolution: float = 0.0) -> ArmFit:
    """`measured` (n,) [s] above zero, of moves whose numbers are all finite; `resolution` [s] of them.

    Where the prior's own place leads to a law that does not fit, its speeds are all scaled as the moves ask first.
    """
    log_measured, rounding = np.log(measured), resolution / np.sqrt(12.0) / measured
    found = _fit_from(prior.mean, prior, motions, log_measured, rounding)
    if found.timing.scatter <= _MISFIT * prior.scatter:
        return found
    scaled = prior.mean.copy()
    scaled[: len(prior.axes)] -= np.median(log_measured - _logs(prior.mean, motions))
    again = _fit_from(scaled, prior, motions, log_measured, rounding)
    return again if again.timing.scatter < found.timing.scatter else found


def _fit_from(
    start: Floats, prior: ArmTiming, motions: JointMotions, log_measured: Floats, rounding: Floats
) -> ArmFit:
    known: Floats = np.asarray(np.linalg.inv(prior.covariance), dtype=np.float64)
    mean = start.copy()
    scatter = max(prior.scatter, _scatter(log_measured - _logs(mean, motions), prior.scatter))
    damping = 1e-3
    residual = log_measured - _logs(mean, motions)
    for _ in range(_STEPS):
        variance = scatter**2 + rounding**2
        weight = _weights(residual, variance)
        precision = _doubted(known, mean - prior.mean, prior.sd)
        cost = _cost(residual, variance, mean - prior.mean, precision)
        jacobian = gradient(mean, motions)
        scaled = jacobian * (weight / variance)[:, None]
        normal = jacobian.T @ scaled + precision
        pull = scaled.T @ residual - precision @ (mean - prior.mean)
        moved = False
        for _ in range(8):
            step = np.linalg.solve(normal + damping * np.diag(np.diag(normal)), pull)
            trial = log_measured - _logs(mean + step, motions)
            if (
                np.isfinite(trial).all()
                and _cost(trial, variance, mean + step - prior.mean, precision) <= cost
            ):
                moved = True
                break
            damping *= 8.0
        if not moved:
            break
        mean, residual = np.asarray(mean + step, dtype=np.float64), trial
        damping = max(damping / 6.0, 1e-9)
        scatter = _scatter(residual, prior.scatter)
        if np.max(np.abs(step) / np.sqrt(np.diag(prior.covariance))) < 1e-3:
            break
    variance = scatter**2 + rounding**2
    weight = _weights(residual, variance)
    jacobian = gradient(mean, motions)
    precision = _doubted(known, mean - prior.mean, prior.sd)
    told = jacobian.T @ (jacobian * (weight / variance)[:, None])
    covariance = np.asarray(np.linalg.inv(told + precision), dtype=np.float64)
    timing = replace(prior, mean=mean, covariance=covariance, scatter=scatter)
    return ArmFit(timing, residual, weight)


def _logs(mean: Floats, motions: JointMotions) -> Floats:
    return np.log(np.maximum(solve(mean, motions).duration, 1e-6))


def _weights(residual: Floats, variance: Floats) -> Floats:
    """Of Student's t."""
    return np.asarray((_FREEDOM + 1.0) / (_FREEDOM + residual**2 / variance))


def _doubted(precision: Floats, away: Floats, sd: Floats) -> Floats:
    """(p, p) the prior's precision with Student's weights of how far numbers told of this arm are `away` from it."""
    weight = np.sqrt(np.where(sd <= _TOLD, np.minimum(_weights(away, sd**2), 1.0), 1.0))
    return np.asarray(precision * np.outer(weight, weight))


def _cost(residual: Floats, variance: Floats, away: Floats, precision: Floats) -> float:
    own = (_FREEDOM + 1.0) * np.sum(np.log1p(residual**2 / (_FREEDOM * variance)))
    return float(own + away @ precision @ away)


def _scatter(residual: Floats, known: float) -> float:
    """[1] the residual's scale by its median, with the prior's as some more moves."""
    count = len(residual)
    found = 1.4826 * float(np.median(np.abs(residual))) if count else known
    mixed = np.sqrt((count * found**2 + _KNOWN_SCATTER_WEIGHT * known**2) / (count + _KNOWN_SCATTER_WEIGHT))
    return max(float(mixed), _LEAST_SCATTER)


# --- Joint moves ---

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
_SLOWER: Final = 1.5  # times what a joint move takes at 100 %: it was programmed at less
_TOO_FAST: Final = 0.9  # of the time that the axes need at their rated speeds
_UNTOLD: Final = 0.85  # of the prior's sd that is left of a number that the moves did not tell
_TELLING: Final = 0.5  # of the prior's precision that the moves have to add to a number to have told it
_CONTRADICTION: Final = 8.0  # scatters between repeats of one move
_SCATTERS: Final = (
    0.005,
    0.03,
)  # [1] least and most that repeats scatter by; where half of them contradict, all do
_SAME: Final = 1e-3  # [rad | m], [1] moves that agree this well in everything programmed are one
_SHOWN: Final = 5


@dataclass(frozen=True, slots=True, eq=False)
class LearntArm:
    """`timing` after the recorded moves; `regions` and `trees` correct it where they helped on held-out moves.

    `quantile`: spreads that hold 95 % of held-out moves. `held_out` [%]: mean errors of the candidates on moves they
    did not see. `untold`: numbers that kept their prior. `rows`: moves it was learnt from. `nothing`: held-out moves
    were surely nearer to olp's own numbers, which were kept.
    """

    timing: ArmTiming
    regions: tuple[SlowRegion, ...]
    trees: BoostedTrees | None
    quantile: float
    held_out: Mapping[str, float]
    untold: tuple[str, ...]
    rows: int
    nothing: bool = False

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
            "load_inertia_kg_m2": timing.load_inertia,
            "regions": [list(region) for region in self.regions],
            "trees": None if self.trees is None else self.trees.to_json(),
            "quantile_95": self.quantile,
            "held_out_percent": dict(self.held_out),
            "untold": list(self.untold),
            "rows": self.rows,
        }

    @staticmethod
    def from_json(content: Any) -> LearntArm:
        """The arm of its JSON content. Raises KeyError, TypeError or ValueError if the content is invalid."""
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
        inertia = content.get("load_inertia_kg_m2")
        if inertia is not None and not 0 < float(inertia) < np.inf:
            raise ValueError(f"load_inertia_kg_m2 {inertia}")
        timing = ArmTiming(
            axes,
            mean,
            covariance,
            tuple(str(given[n]["source"]) for n in names),
            float(content["scatter"]),
            None if inertia is None else float(inertia),
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
    moves: RecordedMoves, robot: Robot | None, tool: Pose | None, axes: int, rated: float | None = None
) -> tuple[JointMoves, Rows]:
    """Joint rows whose joints are known at both ends, and which rows of the recording they are.

    A row without a share of the speed runs at the rated speeds, unless a speed of the tool is written. `rated` [kg m²]
    of the rated load, None for a usual one.
    """
    from olp.identification.recording.moves import JOINT
    from olp.identification.signature.moveset import joint_ends

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
    found = joint_moves(robot, start[rows], end[rows], speed, acceleration, played, load, inertia, rated)
    return found, rows


def told_inertia(moves: RecordedMoves, robot: Robot | None) -> float | None:
    """[kg m²] of the rated load, where measured rows tell more than a usual one has: nobody tells a controller, or a
    simulation of it, a load that the arm may not carry. None where they do not."""
    if robot is None:
        return None
    measured = np.nan_to_num(moves.duration) > 0
    most = max(
        float(np.nan_to_num(column[measured]).max(initial=0.0))
        for column in (moves.payload_inertia, moves.sim_payload_inertia)
    )
    return most if most > rated_inertia(robot) else None


def _nothing(axes: int) -> JointMoves:
    none, one = np.zeros((0, axes)), np.zeros(0)
    return joint_moves(None, none, none, one, one, one)


def _share(values: Floats) -> Floats:
    return np.where(np.isfinite(values) & (values > 0), values, 1.0)


# --- learning ---------------------------------------------------------------------------------------------------------


def learn_arm(
    prior: ArmTiming, moves: JointMoves, measured: Floats, groups: Labels, resolution: float = 0.0
) -> LearntArm:
    """From `measured` (n,) [s]; `groups` (n,): which rows belong to one program. n >= FEWEST."""
    some = _sample(len(moves), _MOST)
    chosen, held_out, ratios = _choose(prior, moves.take(some), measured[some], resolution)
    if chosen is _NOTHING:
        return LearntArm(prior, (), None, _quantile(ratios), held_out, prior.names, len(moves), nothing=True)
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


_NOTHING: Final = _Learner("nothing learnt", False, 0)  # what olp says of this arm without any recording
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
    solved = solve(timing.mean, motions)
    found = solved.duration
    columns = [start, middle, end, end - start, motions.turned]
    if start.shape[1] > 2:
        columns += [np.stack([q[:, 1] + q[:, 2], q[:, 1] - q[:, 2]], axis=1) for q in (start, middle, end)]
    columns.append(solved.axis_times / np.where(found > 0, found, 1.0)[:, None])
    columns.append(np.stack([np.log(np.where(found > 0, found, 1.0)), motions.fraction], axis=1))
    return np.concatenate(columns, axis=1)


def _choose(
    prior: ArmTiming, moves: JointMoves, measured: Floats, resolution: float
) -> tuple[_Learner, dict[str, float], Floats]:
    """The learner that does best on moves it did not see, all mean errors [%], and its errors over their spreads.

    `_NOTHING` where olp alone is surely nearer to them than the best learner.
    """
    count = len(moves)
    learners = _LEARNERS if count >= _EXAMPLES else _LEARNERS[:1]
    folds = min(_FOLDS if count > 2 * FEWEST else count, count)
    # Neighbours are often alike: a move seen at another speed tells nothing of how well others are told.
    fold = np.arange(count) * folds // count
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
    alone = np.log(measured) - _logs(prior.mean, moves.motions)
    held_out = {learner.name: 100.0 * mean for learner, mean in means.items()}
    held_out[_NOTHING.name] = 100.0 * float(np.mean(np.abs(np.expm1(-alone))))
    if _surely_less(np.abs(alone), np.abs(errors[chosen])):
        return _NOTHING, held_out, np.abs(alone) / prior.spread(moves.motions)
    return chosen, held_out, np.abs(errors[chosen]) / spread


def _surely_less(one: Floats, other: Floats) -> bool:
    """Whether `one` (n,) is less than `other` (n,) on average, beyond what pairs differ by chance."""
    apart = other - one
    return bool(apart.mean() > _NORMAL * apart.std(ddof=1) / np.sqrt(len(apart)))


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
    """(n,) moves that took less time than an axis needs at its rated speed; without a robot, at that of any arm."""
    rated = fastest_speed() if robot is None else robot.speeds
    pace = (moves.motions.fraction * np.minimum(moves.motions.override, 1.0))[:, None] * rated
    least = np.max(moves.motions.turned / pace, axis=1, initial=0.0)
    return np.asarray(measured + resolution < _TOO_FAST * least)


def contradictions(moves: JointMoves, measured: Floats, resolution: float) -> list[Rows]:
    """Groups of joint moves that were programmed alike and took times beyond any scatter of the others."""
    own = moves.motions
    shares = np.stack([own.fraction, own.acceleration, own.override, own.ramps, own.stop], axis=1)
    keys = np.round(np.concatenate([moves.start, moves.end, shares, own.load[:, :, 0]], axis=1) / _SAME)
    _, label = np.unique(keys, axis=0, return_inverse=True)
    return contradicting(label.reshape(-1), measured, resolution)


def contradicting(label: Labels, measured: Floats, resolution: float) -> list[Rows]:
    """Groups of rows of one `label` (n,) each whose times (n,) [s] differ beyond any scatter of others."""
    logs = np.log(measured)
    middle = (
        np.array([np.median(logs[label == i]) for i in range(int(label.max()) + 1)]) if len(label) else logs
    )
    away = np.abs(logs - middle[label])
    again = np.bincount(label)[label] > 1 if len(label) else np.zeros(0, dtype=bool)
    if not again.any():
        return []
    usual = float(np.clip(1.4826 * np.median(away[again]), *_SCATTERS))
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
    says = f"{len(groups)} moves have repeats that differ beyond any scatter: {'; '.join(shown)}"
    help = "look for a pause, another override or load in these rows; the usual time of each counts most"
    return [warning("H050", says, file=file, help=help)]


def too_fast_notes(rows: Rows, move: Labels, robot: Robot | None, file: str) -> list[Diagnostic]:
    if not len(rows):
        return []
    shown = ", ".join(str(move[row]) for row in rows[:_SHOWN].tolist())
    limit = "any arm of the library" if robot is None else "the rated speeds of the axes"
    says = f"{len(rows)} joint moves are faster than {limit} and were left out: moves {shown}"
    help = "check robot, joints, speed_pct and duration_s of these rows"
    return [warning("H051", says, file=file, help=help)]


def unsaid_speed_notes(
    moves: JointMoves, measured: Floats, prior: ArmTiming, unsaid: Mask, file: str
) -> list[Diagnostic]:
    """A warning where moves whose speed is `unsaid` (n,) take much longer than at full speed."""
    slow = int(np.sum(unsaid & (measured > _SLOWER * prior.durations(moves.motions))))
    if not slow:
        return []
    says = (
        f"{slow} joint moves without speed_pct take more than {_SLOWER:g} times as long as at 100 %, at which they "
        "are taken to run"
    )
    return [warning("H056", says, file=file, help="give speed_pct of these rows, or override_pct")]


def held_out_words(held_out: Mapping[str, float]) -> str:
    """The mean errors [%] of the law, of another learner where that does better, and of olp with nothing learnt."""
    learners = {name: error for name, error in held_out.items() if name != _NOTHING.name}
    best = min(learners, key=learners.__getitem__)
    words = f"mean error on held-out ones {held_out['law']:.2f} % by the law"
    if learners[best] != learners["law"]:
        words += f", {learners[best]:.2f} % by {best}"
    if _NOTHING.name in held_out:
        words += f", {held_out[_NOTHING.name]:.2f} % with nothing learnt"
    return words


def learnt_note(learnt: LearntArm, rolling: int, file: str) -> Diagnostic:
    """`rolling`: how many of the moves run into others."""
    if learnt.nothing:
        says = f"{learnt.rows} joint moves tell less than olp knows without them: {held_out_words(learnt.held_out)}"
        help = "nothing was learnt of joint moves; check robot, joints, speed_pct and duration_s, and record more"
        return warning("H055", says, file=file, help=help)
    says = f"{learnt.rows} joint moves: {held_out_words(learnt.held_out)}"
    if rolling:
        says += f"; {rolling} of them run into others, with what olp's law says of their corners"
    if learnt.timing.load_inertia is not None:
        says += f"; the rated load is taken to have {learnt.timing.load_inertia:g} kg m², the most that is told here"
    if min(learnt.held_out.values()) == learnt.held_out[_NOTHING.name]:
        says += "; these few moves show no gain"
    if learnt.untold:
        says += f"; not determined by these moves, prior values kept: {', '.join(learnt.untold)}"
    return info("H052", says, file=file)
