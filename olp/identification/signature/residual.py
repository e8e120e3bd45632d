"""The smooth part that an estimator's named terms leave: a Gaussian process over points and directions."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from olp.identification.signature.coefficients import LearntParameter, Parameters
from olp.identification.signature.domain import points, spread_out
from olp.identification.signature.gp import Belief, Fitted, FittedProcess, KernelPart, Places, answer, learn
from olp.identification.signature.moveset import MoveSet

Floats = NDArray[np.float64]

_PREFIX = "residual"


def fit_residual(moves: MoveSet, values: Floats) -> dict[str, LearntParameter]:
    """`values` (n,) [s²/m]: one part over start and end points together, one over the direction wherever it is."""
    size = spread_of_values(values)
    by_direction = KernelPart(Belief(size, 1.0), (Belief(0.5, 1.0),))
    parts = (place_part(moves, 2 * size), by_direction)
    return fit_smooth(_PREFIX, points(moves), "m", _coordinates, parts, values)


def place_part(moves: MoveSet, size: float) -> KernelPart:
    """A smooth function of start and end point; `size` [s²/m]."""
    reach = max(float(np.median(moves.length)), 1e-3)
    return KernelPart(Belief(size, 1.0), (Belief(0.7 * reach, 1.0), Belief(0.6 * reach, 1.0)))


def estimate_residual(parameters: Parameters, moves: MoveSet) -> tuple[Floats, Floats]:
    """Mean and standard deviation (n,) [s²/m]."""
    return estimate_smooth(_PREFIX, parameters, points(moves), _coordinates)


def learnt_places(parameters: Parameters) -> Floats:
    """(m, 6) [m] start and end points that the process was made of."""
    return learnt_columns(_PREFIX, parameters)


def residual_size(parameters: Parameters) -> float:
    """[s²/m] standard deviation of the process where it knows nothing."""
    return size_of(_PREFIX, parameters)


def _coordinates(places: Floats) -> Places:
    step = places[:, 3:] - places[:, :3]
    way = np.linalg.norm(step, axis=1, keepdims=True)
    return ((places[:, :3], places[:, 3:]), (step / np.where(way > 0, way, 1.0),))


# --- Smooth ---
# Gaussian processes of moves as a signature's file holds them: of many moves neighbours are averaged first.

Coordinates = Callable[[Floats], Places]  # of columns (n, c): what each part sees of them

# Moves a process is made of; of more of them, neighbours are averaged.
MOST = 300
# Of more than _MANY, _FEW tell the lengths.
_MANY, _FEW = 160, 100
_POINTS = 6  # the first columns: start and end point [m]


def fit_smooth(
    prefix: str,
    columns: Floats,
    unit: str,
    coordinates: Coordinates,
    parts: tuple[KernelPart, ...],
    values: Floats,
) -> dict[str, LearntParameter]:
    """`values` (n,) [s²/m] of moves; `columns` (n, 6 or more): start and end point [m], and what else is told.

    Names of the parameters begin with `prefix`; `unit` is that of the columns.
    """
    kept, middle = _averaged(columns, values)
    few = spread_out(kept[:, :_POINTS], _FEW) if len(kept) > _MANY else np.arange(len(kept))
    noise = Belief(0.1 * spread_of_values(values), 1.0)
    process = learn(coordinates(kept), middle, parts, noise, few)
    return {
        f"{prefix}_scales": LearntParameter([p.scale for p in process.parts], "s²/m"),
        f"{prefix}_lengths": LearntParameter([list(p.lengths) for p in process.parts], f"{unit}; 1"),
        f"{prefix}_noise": LearntParameter(process.noise, "s²/m"),
        f"{prefix}_places": LearntParameter(kept.tolist(), unit),
        f"{prefix}_weights": LearntParameter(process.weights.tolist(), "m/s²"),
        f"{prefix}_variances": LearntParameter(process.variances.tolist(), "s⁴/m²"),
    }


def estimate_smooth(
    prefix: str, parameters: Parameters, columns: Floats, coordinates: Coordinates
) -> tuple[Floats, Floats]:
    """Mean and standard deviation (n,) [s²/m]."""
    lengths = parameters[f"{prefix}_lengths"].value
    scales = parameters[f"{prefix}_scales"].value
    process = FittedProcess(
        tuple(Fitted(float(s), tuple(map(float, own))) for s, own in zip(scales, lengths, strict=True)),
        float(parameters[f"{prefix}_noise"].value),
        coordinates(learnt_columns(prefix, parameters)),
        np.array(parameters[f"{prefix}_weights"].value, dtype=np.float64),
        np.array(parameters[f"{prefix}_variances"].value, dtype=np.float64),
    )
    return answer(process, coordinates(columns))


def learnt_columns(prefix: str, parameters: Parameters) -> Floats:
    """(m, c) of the moves that the process was made of."""
    return np.atleast_2d(np.array(parameters[f"{prefix}_places"].value, dtype=np.float64))


def size_of(prefix: str, parameters: Parameters) -> float:
    """[s²/m] standard deviation of the process where it knows nothing."""
    return float(np.sqrt(np.sum(np.square(parameters[f"{prefix}_scales"].value))))


def spread_of_values(values: Floats) -> float:
    """[s²/m] what scales are believed to be near to."""
    return max(float(np.std(values)), 1e-6)


def _averaged(columns: Floats, values: Floats) -> tuple[Floats, Floats]:
    """Columns (m, c) and values (m,): kept moves, each the mean of those nearer to it than to any other."""
    places = columns[:, :_POINTS]
    rows = spread_out(places, MOST)
    if len(rows) == len(places):
        return columns, values
    kept = places[rows]
    square = np.sum(kept**2, axis=1)
    blocks = np.array_split(places, max(1, len(places) // 2048))
    owner = np.concatenate([np.argmin(square - 2 * part @ kept.T, axis=1) for part in blocks])
    count = np.maximum(np.bincount(owner, minlength=len(rows)), 1)
    middle = np.stack([np.bincount(owner, column, len(rows)) for column in columns.T], axis=1)
    return middle / count[:, None], np.bincount(owner, values, len(rows)) / count
