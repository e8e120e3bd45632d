"""The smooth part that an estimator's named terms leave: a Gaussian process over points and directions."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from olp.signature.domain import points, spread_out
from olp.signature.estimator import Parameter, Parameters
from olp.signature.gp import Belief, Fitted, Part, Places, Process, answer, learn
from olp.signature.moveset import MoveSet

Floats = NDArray[np.float64]

# Moves a process is made of; of more of them, neighbours are averaged.
MOST = 300
# Of more than _MANY, _FEW tell the lengths.
_MANY, _FEW = 160, 100


def fit_residual(moves: MoveSet, values: Floats) -> dict[str, Parameter]:
    """`values` (n,) [s²/m]: one part over start and end points together, one over the direction wherever it is."""
    rows = spread_out(points(moves), MOST)
    places, centre = _averaged(moves, values, rows)
    size = max(float(np.std(centre)), 1e-6)
    reach = max(float(np.median(moves.length)), 1e-3)
    by_place = Part(Belief(2 * size, 1.0), (Belief(0.7 * reach, 1.0), Belief(0.6 * reach, 1.0)))
    by_direction = Part(Belief(size, 1.0), (Belief(0.5, 1.0),))
    few = spread_out(places, _FEW) if len(places) > _MANY else np.arange(len(places))
    noise = Belief(0.1 * size, 1.0)
    process = learn(_coordinates(places), centre, (by_place, by_direction), noise, few)
    return {
        "residual_scales": Parameter([p.scale for p in process.parts], "s²/m"),
        "residual_lengths": Parameter([list(p.lengths) for p in process.parts], "m, m; 1"),
        "residual_noise": Parameter(process.noise, "s²/m"),
        "residual_places": Parameter(places.tolist(), "m"),
        "residual_weights": Parameter(process.weights.tolist(), "m/s²"),
        "residual_variances": Parameter(process.variances.tolist(), "s⁴/m²"),
    }


def estimate_residual(parameters: Parameters, moves: MoveSet) -> tuple[Floats, Floats]:
    """Mean and standard deviation (n,) [s²/m]."""
    lengths = parameters["residual_lengths"].value
    scales = parameters["residual_scales"].value
    process = Process(
        tuple(Fitted(float(s), tuple(map(float, own))) for s, own in zip(scales, lengths, strict=True)),
        float(parameters["residual_noise"].value),
        _coordinates(learnt_places(parameters)),
        np.array(parameters["residual_weights"].value, dtype=np.float64),
        np.array(parameters["residual_variances"].value, dtype=np.float64),
    )
    return answer(process, _coordinates(points(moves)))


def learnt_places(parameters: Parameters) -> Floats:
    """(m, 6) [m] start and end points that the process was made of."""
    return np.array(parameters["residual_places"].value, dtype=np.float64).reshape(-1, 6)


def residual_size(parameters: Parameters) -> float:
    """[s²/m] standard deviation of the process where it knows nothing."""
    return float(np.sqrt(np.sum(np.square(parameters["residual_scales"].value))))


def _coordinates(places: Floats) -> Places:
    step = places[:, 3:] - places[:, :3]
    way = np.linalg.norm(step, axis=1, keepdims=True)
    return ((places[:, :3], places[:, 3:]), (step / np.where(way > 0, way, 1.0),))


def _averaged(moves: MoveSet, values: Floats, rows: NDArray[np.int64]) -> tuple[Floats, Floats]:
    """Places (m, 6) and values (m,): the kept ones, each with the mean of those nearer to it than to any other."""
    places = points(moves)
    if len(rows) == len(places):
        return places, values
    kept = places[rows]
    square = np.sum(kept**2, axis=1)
    blocks = np.array_split(places, max(1, len(places) // 2048))
    owner = np.concatenate([np.argmin(square - 2 * part @ kept.T, axis=1) for part in blocks])
    count = np.maximum(np.bincount(owner, minlength=len(rows)), 1)
    middle = np.stack([np.bincount(owner, column, len(rows)) for column in places.T], axis=1) / count[:, None]
    return middle, np.bincount(owner, values, len(rows)) / count
