"""The smooth part that an estimator's named terms leave: a Gaussian process over points and directions."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from olp.identification.signature.domain import points
from olp.identification.signature.estimator import LearntParameter, Parameters
from olp.identification.signature.gp import Belief, KernelPart, Places
from olp.identification.signature.moveset import MoveSet
from olp.identification.signature.smooth import (
    estimate_smooth,
    fit_smooth,
    learnt_columns,
    size_of,
    spread_of_values,
)

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
