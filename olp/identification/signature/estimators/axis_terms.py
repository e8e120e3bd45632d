"""Which of the arm's axes cost time: a few named terms of the motion of the axes, chosen by held-out start points.

The terms do not change when the move is mirrored left to right. Those of the axes' speeds do not change when it is
run backwards either; what differs between there and back is left to the pitch of the forearm and to gravity.
"""

from __future__ import annotations

from itertools import combinations
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from olp.identification.signature.axis_paths import axis_paths, has_axes
from olp.identification.signature.coefficients import LearntParameter, Parameters
from olp.identification.signature.estimator import Estimate, Estimator, measured_slowness
from olp.identification.signature.moveset import MoveSet, direction_labels

if TYPE_CHECKING:
    from olp.robots.model import Robot


Floats = NDArray[np.float64]

MOST_TERMS = 4
MEMBERS = 20
RIDGES = (2.0, 5.0, 15.0)
# Rows that the terms are chosen on; the weights are fitted on all.
_MOST_ROWS = 600
_MOST_GROUPS = 12
# Rounds and limit [standard deviations] of the weights that leave outliers out by and by (Huber).
_ROUNDS, _HUBER = 4, 2.5
# How much a direction that is held out counts beside a start point that is.
_DIRECTIONS = 0.3


class Terms(NamedTuple):
    names: tuple[str, ...]
    values: Floats  # (n, k)


class AxisTerms(Estimator):
    """The median of the best small models; the uncertainty grows where they disagree."""

    summary = "a few terms of the axes' motion, chosen by held-out start points"
    needs_robot = True

    def needs(self, moves: MoveSet, robot: Robot | None) -> str:
        if not has_axes(robot):
            return "the robot and its kinematics are not known"
        assert robot is not None
        if np.isfinite(terms_of(moves, robot).values).all(axis=1).sum() < 12:
            return "fewer than 12 moves have a tool orientation and are in the robot's reach"
        return ""

    def fit(self, moves: MoveSet, robot: Robot | None) -> Parameters:
        assert robot is not None
        names, values = terms_of(moves, robot)
        slowness = measured_slowness(moves)
        good = np.asarray(np.isfinite(values).all(axis=1) & np.isfinite(slowness))
        values, slowness, used = values[good], slowness[good], moves.take(good)
        middle, spread = values.mean(axis=0), values.std(axis=0)
        scaled = (values - middle) / np.where(spread > 1e-9, spread, 1.0)
        members = [
            robust_member(scaled, slowness, terms, ridge) for terms, ridge in chosen(scaled, slowness, used)
        ]
        return {
            "terms": LearntParameter(list(names), ""),
            "middle": LearntParameter(middle.tolist(), "rad, rad/m, m"),
            "spread": LearntParameter(np.where(spread > 1e-9, spread, 1.0).tolist(), "rad, rad/m, m"),
            "low": LearntParameter(values.min(axis=0).tolist(), "rad, rad/m, m"),
            "high": LearntParameter(values.max(axis=0).tolist(), "rad, rad/m, m"),
            "models": LearntParameter(
                [{"terms": [names[t] for t in m.terms], "weights": m.weights.tolist()} for m in members],
                "s²/m per spread",
            ),
        }

    def estimate(self, parameters: Parameters, moves: MoveSet, robot: Robot | None) -> Estimate:
        assert robot is not None
        names, values = terms_of(moves, robot)
        index = {name: i for i, name in enumerate(names)}
        order = [index[name] for name in parameters["terms"].value]
        middle, spread, low, high = (
            np.array(parameters[k].value, dtype=np.float64) for k in ("middle", "spread", "low", "high")
        )
        known = np.asarray(np.isfinite(values).all(axis=1))
        own = np.where(known[:, None], values[:, order], middle)
        place = {name: i for i, name in enumerate(parameters["terms"].value)}
        members = [
            SubsetModel(tuple(place[t] for t in m["terms"]), np.array(m["weights"], dtype=np.float64))
            for m in parameters["models"].value
        ]
        said = answers(members, (own - middle) / spread)
        slack = 0.25 * (high - low)
        inside = known & np.all((own >= low - slack) & (own <= high + slack), axis=1)
        return Estimate(np.median(said, axis=1), said.std(axis=1), inside)


def terms_of(moves: MoveSet, robot: Robot) -> Terms:
    """The terms of n moves; nan where the axes are not known."""
    paths = axis_paths(moves, robot)
    turned = np.abs(paths.end - paths.start)
    rate = np.abs(paths.start_rate) + np.abs(paths.end_rate)
    horizontal = moves.start[:, :2]
    outward = np.sum(moves.direction[:, :2] * horizontal, axis=1) / np.linalg.norm(horizontal, axis=1)
    columns = {"length": moves.length, "outward": outward, "upward": moves.direction[:, 2]}
    axes = robot.axis_names
    for axis in range(3):
        # The fourth power grows late and then steeply, as an axis that begins to be the slowest does.
        columns[f"turn of {axes[axis]}, 4th power"] = turned[:, axis] ** 4
    for axis in (0, 1, 2, 4):
        columns[f"rate of {axes[axis]} at both ends"] = rate[:, axis]
    for axis in (4,):
        columns[f"rate of {axes[axis]} at the start"] = paths.start_rate[:, axis]
        columns[f"rate of {axes[axis]} at the end"] = paths.end_rate[:, axis]
    return Terms(tuple(columns), np.stack(list(columns.values()), axis=1))


def chosen(scaled: Floats, slowness: Floats, moves: MoveSet) -> list[tuple[tuple[int, ...], float]]:
    """The MEMBERS best pairs of terms and ridge."""
    step = max(1, -(-len(moves) // _MOST_ROWS))
    rows = np.arange(0, len(moves), step)
    part = moves.take(rows)
    terms, values = scaled[rows], slowness[rows]
    # Errors of the time count, in percent of it.
    scale = part.duration / part.speed
    varying = [i for i in range(terms.shape[1]) if terms[:, i].std() > 1e-6]
    subsets = [tuple(varying[i] for i in s) for s in all_subsets(len(varying), MOST_TERMS)]
    groups = [(1.0, group) for group in (_groups(part.start_labels),) if group is not None]
    ways = _groups(direction_labels(part))
    groups += [(_DIRECTIONS if groups else 1.0, ways)] if ways is not None else []
    groups = groups or [(1.0, np.arange(len(part)) % 5)]
    pairs: list[tuple[float, tuple[int, ...], float]] = []
    for ridge in RIDGES:
        total = np.zeros(len(subsets))
        for weight, labels in groups:
            total += weight * grouped_errors(terms, values, scale, labels, subsets, ridge)
        best = np.argsort(total, kind="stable")[:MEMBERS]
        pairs += [(float(total[i]), subsets[i], ridge) for i in best.tolist()]
    pairs.sort()
    return [(terms_, ridge * len(moves) / len(part)) for _, terms_, ridge in pairs[:MEMBERS]]


def robust_member(scaled: Floats, slowness: Floats, terms: tuple[int, ...], ridge: float) -> SubsetModel:
    """A subset's weights, in which single wrong times count little."""
    weight = np.ones(len(slowness))
    member = fit_member(scaled, slowness, weight, terms, ridge)
    for _ in range(_ROUNDS):
        residual = np.abs(slowness - answers([member], scaled)[:, 0])
        size = 1.4826 * float(np.median(residual)) + 1e-9
        weight = np.minimum(1.0, _HUBER * size / np.maximum(residual, 1e-12))
        member = fit_member(scaled, slowness, weight, terms, ridge)
    return member


def _groups(labels: NDArray[np.int64]) -> NDArray[np.int64] | None:
    """Labels with at least two groups and at most _MOST_GROUPS; None when there is only one."""
    if len(np.unique(labels)) < 2:
        return None
    return np.asarray(labels % _MOST_GROUPS)


# --- Small linear models ---
# Which few of many named terms explain, judged by groups that are held out. Every subset of up to `most` terms is
# fitted by ridge regression without each group in turn, all at once by normal equations. The best ones answer together,
# by their median: where they disagree, the answer is not known.


Labels = NDArray[np.int64]


class SubsetModel(NamedTuple):
    """One small model: an intercept and a weight for each of its terms."""

    terms: tuple[int, ...]
    weights: Floats  # (1 + len(terms),)


def all_subsets(count: int, most: int) -> list[tuple[int, ...]]:
    """Every choice of one to `most` of `count` terms."""
    return [c for size in range(1, most + 1) for c in combinations(range(count), size)]


def grouped_errors(
    terms: Floats,
    values: Floats,
    scale: Floats,
    labels: Labels,
    subsets: list[tuple[int, ...]],
    ridge: float,
) -> Floats:
    """(m,) mean over groups of the mean |error| / `scale` of each subset, each group predicted by the others.

    `terms` (n, k) standardised, `values`, `scale` (n,). `ridge`: in observations of weight one per term.
    """
    columns = np.concatenate([np.ones((len(terms), 1)), terms], axis=1)
    whole, right = columns.T @ columns, columns.T @ values
    groups = [np.nonzero(labels == g)[0] for g in np.unique(labels).tolist()]
    result = np.empty(len(subsets))
    for size in sorted({len(s) for s in subsets}):
        which = [i for i, s in enumerate(subsets) if len(s) == size]
        picked = np.array([(0, *(t + 1 for t in subsets[i])) for i in which])
        damping = np.diag([0.0] + [ridge] * size)
        total = np.zeros(len(which))
        for rows in groups:
            own = columns[rows]
            left = (whole - own.T @ own)[picked[:, :, None], picked[:, None, :]] + damping
            weights = np.linalg.solve(left, (right - own.T @ values[rows])[picked][:, :, None])[:, :, 0]
            dense = np.zeros((len(which), columns.shape[1]))
            np.put_along_axis(dense, picked, weights, axis=1)
            error = np.abs(own @ dense.T - values[rows, None]) / scale[rows, None]
            total += error.mean(axis=0)
        result[which] = total / len(groups)
    return result


def fit_member(
    terms: Floats, values: Floats, weight: Floats, chosen: tuple[int, ...], ridge: float
) -> SubsetModel:
    """Ridge regression of one subset; `weight` (n,) of the rows."""
    columns = np.concatenate([np.ones((len(terms), 1)), terms[:, list(chosen)]], axis=1)
    damping = np.diag([0.0] + [ridge] * len(chosen))
    left = columns.T @ (columns * weight[:, None]) + damping
    return SubsetModel(
        chosen, np.asarray(np.linalg.solve(left, columns.T @ (values * weight)), dtype=np.float64)
    )


def answers(members: list[SubsetModel], terms: Floats) -> Floats:
    """(n, members): the slowness that each member says."""
    return np.stack([m.weights[0] + terms[:, list(m.terms)] @ m.weights[1:] for m in members], axis=1)
