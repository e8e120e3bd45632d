"""An arm's joints along straight moves, where no robot is named but joint and tool points are: read off the points.

The joints at all recorded ends are a smooth function of the tool's place: a polyharmonic spline through them
(J. Duchon, Splines minimizing rotation-invariant semi-norms in Sobolev spaces, 1977) gives them in between, where it
foretells ends
that it was not given.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from olp.identification.recording.moves import RecordedMoves

Floats = NDArray[np.float64]

PLACES = 21  # along each move
_FEWEST, _MOST = 24, 320  # ends that a spline goes through
_FIFTH = 5  # every fifth end is foretold from the others
_GOOD = 0.03  # of the spread of an axis: what foretold ends are off, at most


def learned_joints(
    moves: RecordedMoves, rows: NDArray[np.int64], points: tuple[Floats, Floats]
) -> Floats | None:
    """(n, m, k) [rad | m] at m places along the straight way of the moves at `rows`; None where the points do not tell.

    `points`: (n, k) each, joints at start and end.
    """
    places = np.concatenate([moves.start[rows], moves.end[rows]])
    joints = np.concatenate(points)
    good = np.isfinite(places).all(axis=1) & np.isfinite(joints).all(axis=1)
    if not good.any():
        return None
    _, one = np.unique(np.round(np.concatenate([places, joints], axis=1)[good], 6), axis=0, return_index=True)
    at = np.nonzero(good)[0][one]
    if len(at) < _FEWEST:
        return None
    at = at[np.linspace(0, len(at) - 1, min(len(at), _MOST)).astype(np.int64)]
    best, least = None, _GOOD
    for features in (_cylindrical, _plain):
        inputs = features(places)
        held = np.arange(len(at)) % _FIFTH == 0
        told = _Spline(inputs[at[~held]], joints[at[~held]])(inputs[at[held]])
        spread = np.maximum(np.ptp(joints[at], axis=0), 1e-6)
        off = float((np.sqrt(((told - joints[at[held]]) ** 2).mean(axis=0)) / spread).max())
        if off < least:
            best, least = features, off
    if best is None:
        return None
    spline = _Spline(best(places[at]), joints[at])
    share = np.linspace(0.0, 1.0, PLACES)[None, :, None]
    start, end = moves.start[rows], moves.end[rows]
    along = start[:, None, :] + share * (end - start)[:, None, :]
    result = spline(best(along.reshape(-1, 3))).reshape(len(rows), PLACES, -1)
    # The recorded ends are met exactly.
    first, last = points[0] - result[:, 0], points[1] - result[:, -1]
    return np.asarray(result + first[:, None, :] * (1.0 - share) + last[:, None, :] * share)


def _plain(places: Floats) -> Floats:
    return places


def _cylindrical(places: Floats) -> Floats:
    """(n, 3) The first axis turns with the bearing, the others with distance and height."""
    return np.stack(
        [np.arctan2(places[:, 1], places[:, 0]), np.hypot(places[:, 0], places[:, 1]), places[:, 2]], axis=1
    )


class _Spline:
    """Through values (n, k) at inputs (n, d): cubes of distances and a plane."""

    def __init__(self, inputs: Floats, values: Floats) -> None:
        self.middle, self.spread = inputs.mean(axis=0), np.maximum(inputs.std(axis=0), 1e-9)
        self.inputs = (inputs - self.middle) / self.spread
        count, width = self.inputs.shape
        plane = np.concatenate([np.ones((count, 1)), self.inputs], axis=1)
        whole = np.zeros((count + width + 1,) * 2)
        whole[:count, :count] = _cubes(self.inputs, self.inputs)
        whole[:count, count:], whole[count:, :count] = plane, plane.T
        right = np.concatenate([values, np.zeros((width + 1, values.shape[1]))])
        self.weights = np.linalg.lstsq(whole, right, rcond=1e-12)[0]

    def __call__(self, inputs: Floats) -> Floats:
        """(m, k) at inputs (m, d)."""
        inputs = (inputs - self.middle) / self.spread
        basis = np.concatenate([_cubes(inputs, self.inputs), np.ones((len(inputs), 1)), inputs], axis=1)
        return np.asarray(basis @ self.weights)


def _cubes(one: Floats, other: Floats) -> Floats:
    square = (one**2).sum(axis=1)[:, None] + (other**2).sum(axis=1)[None, :] - 2.0 * one @ other.T
    return np.asarray(np.maximum(square, 0.0) ** 1.5)
