"""The smooth part that an estimator's named terms leave: a Gaussian process over start and end points."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from olp.signature.domain import points, spread_out
from olp.signature.estimator import Parameter, Parameters
from olp.signature.gp import Prior, Process, answer, learn
from olp.signature.moveset import MoveSet

Floats = NDArray[np.float64]

# Moves a process is made of; more of them are averaged onto these.
MOST = 300


def fit_residual(moves: MoveSet, values: Floats) -> dict[str, Parameter]:
    """`values` (n,) [s²/m] over start and end points (in units of their own spread over the recording)."""
    rows = spread_out(points(moves), MOST)
    places, centre = _averaged(moves, values, rows)
    size = max(float(np.std(centre)), 1e-6)
    reach = max(float(np.median(moves.length)), 1e-3)
    prior = Prior((2 * size, 1.0), ((0.7 * reach, 1.0), (0.6 * reach, 1.0)), (0.15 * size, 1.0))
    process = learn((places[:, :3], places[:, 3:]), centre, prior, 1e-4 * size)
    return {
        "residual_scale": Parameter(process.scale, "s²/m"),
        "residual_lengths": Parameter(list(process.lengths), "m"),
        "residual_noise": Parameter(process.noise, "s²/m"),
        "residual_places": Parameter(places.tolist(), "m"),
        "residual_weights": Parameter(process.weights.tolist(), "m/s²"),
        "residual_variances": Parameter(process.extra.tolist(), "s⁴/m²"),
    }


def estimate_residual(parameters: Parameters, moves: MoveSet) -> tuple[Floats, Floats]:
    """Mean and standard deviation (n,) [s²/m]."""
    places = np.array(parameters["residual_places"].value, dtype=np.float64).reshape(-1, 6)
    process = Process(
        float(parameters["residual_scale"].value),
        tuple(float(v) for v in parameters["residual_lengths"].value),
        float(parameters["residual_noise"].value),
        (places[:, :3], places[:, 3:]),
        np.array(parameters["residual_weights"].value, dtype=np.float64),
        np.array(parameters["residual_variances"].value, dtype=np.float64),
    )
    return answer(process, (moves.start, moves.end))


def _averaged(moves: MoveSet, values: Floats, rows: NDArray[np.int64]) -> tuple[Floats, Floats]:
    """Places (m, 6) and values (m,): the kept ones, each with the mean of those nearer to it than to any other."""
    places = points(moves)
    if len(rows) == len(places):
        return places, values
    kept = places[rows]
    square = np.sum(kept**2, axis=1)
    owner = np.concatenate(
        [
            np.argmin(square - 2 * part @ kept.T, axis=1)
            for part in np.array_split(places, max(1, len(places) // 2048))
        ]
    )
    count = np.maximum(np.bincount(owner, minlength=len(rows)), 1)
    middle = np.stack([np.bincount(owner, column, len(rows)) for column in places.T], axis=1) / count[:, None]
    return middle, np.bincount(owner, values, len(rows)) / count
