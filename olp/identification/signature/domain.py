"""Where a signature was learnt, and how far a move is from it."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from olp.core.units import mm

if TYPE_CHECKING:
    from olp.identification.signature.moveset import MoveSet

Floats = NDArray[np.float64]

# Rows of the learnt moves that a file keeps; more of them only describe the same region again.
KEPT = 400
# [1] Times `far` from which on a place is outside.
_FAR = 1.5
# Values at the very edge of what was learnt are inside.
_SLACK = 1e-6


class Domain(NamedTuple):
    """Ranges of the learnt moves and the moves themselves (thinned), all SI."""

    speed: tuple[float, float]  # [m/s]
    length: tuple[float, float]  # [m]
    payload: tuple[float, float] | None  # [kg]
    moves: Floats  # (m, 6) [m] start and end points
    angles: Floats  # (m, 3) [rad] Rx, Ry, Rz of the tool, nan where not told
    near: float  # [m] how far a move of the recording is from the others, nine in ten
    far: float  # [m] how far a move from a start point that is left out is from the others, the median

    @property
    def empty(self) -> bool:
        """Whether no straight move was learnt at all."""
        return not len(self.moves)

    def distance(self, moves: MoveSet) -> Floats:
        """(n,) [m] to the nearest learnt move: the way its start and end have to be carried, root sum square."""
        return nearest(points(moves), self.moves)

    def novelty(self, moves: MoveSet) -> Floats:
        """(n,) [1]: 0 among learnt moves, 1 as far as a start point that was not learnt, growing beyond."""
        if self.empty:
            return np.ones(len(moves))
        span = max(self.far - self.near, 1e-3)
        return np.asarray(np.maximum(0.0, (self.distance(moves) - self.near) / span))

    def strain(self, moves: MoveSet) -> Floats:
        """(n,) [1] from 1: how much the interval widens because speed, load or place are outside."""
        if self.empty:
            return np.ones(len(moves))
        low, high = self.speed
        pace = np.maximum(moves.speed / high, low / moves.speed)
        place = self.distance(moves) / (_FAR * max(self.far, self.near, 1e-3))
        load = np.ones(len(moves))
        if self.payload is not None:
            carried = np.where(np.isnan(moves.payload), self.payload[0], moves.payload)
            load = np.maximum(1.0, (carried + 1.0) / (self.payload[1] + 1.0))
            load = np.maximum(load, (self.payload[0] + 1.0) / (carried + 1.0))
        return np.asarray(np.maximum(1.0, pace) * np.maximum(1.0, place) * load)

    def outside(self, moves: MoveSet) -> list[str]:
        """Per move why it is outside, "" inside."""
        if self.empty:
            return ["no straight move was learnt"] * len(moves)
        reasons: list[list[str]] = [[] for _ in range(len(moves))]
        self._range(reasons, moves.speed, self.speed, "speed", "mm/s", mm)
        self._range(reasons, moves.length, self.length, "length", "mm", mm, 0.25)
        if self.payload is not None:
            self._range(reasons, moves.payload, self.payload, "payload", "kg", 1.0)
        far = self.distance(moves)
        for row in np.nonzero(far > _FAR * max(self.far, self.near) + _SLACK)[0].tolist():
            reasons[row].append(f"{far[row] / mm:.0f} mm from the nearest learnt move")
        return ["; ".join(r) for r in reasons]

    @staticmethod
    def _range(
        reasons: list[list[str]],
        values: Floats,
        known: tuple[float, float],
        name: str,
        unit: str,
        factor: float,
        slack: float = 0.01,
    ) -> None:
        low, high = known
        wrong = (values < low * (1 - slack) - _SLACK) | (values > high * (1 + slack) + _SLACK)
        for row in np.nonzero(wrong)[0].tolist():
            learnt = f"{low / factor:g}" if low == high else f"{low / factor:g} to {high / factor:g}"
            reasons[row].append(f"{name} {values[row] / factor:g} {unit} (learnt: {learnt})")


def domain_of(moves: MoveSet) -> Domain:
    """The domain of measured moves."""
    places = points(moves)
    rows = spread_out(places, KEPT)
    kept = places[rows]
    near = float(np.quantile(_nearest_other(kept), 0.9)) if len(kept) > 1 else 0.0
    far = _left_out_distance(moves.start_labels[rows], kept)
    payload = moves.payload[np.isfinite(moves.payload)]
    length = moves.length
    return Domain(
        (float(moves.speed.min()), float(moves.speed.max())),
        (float(length.min()), float(length.max())),
        (float(payload.min()), float(payload.max())) if len(payload) else None,
        kept,
        _angles(moves.rotation[rows]),
        near,
        max(far, near),
    )


def points(moves: MoveSet) -> Floats:
    """(n, 6) [m]"""
    return np.concatenate([moves.start, moves.end], axis=1)


def nearest(places: Floats, known: Floats) -> Floats:
    """(n,) [m] from each row to the nearest of `known`, in blocks that fit in memory."""
    result = np.empty(len(places))
    square = np.sum(known**2, axis=1)
    for begin in range(0, len(places), 4096):
        part = places[begin : begin + 4096]
        apart = np.sum(part**2, axis=1)[:, None] + square - 2 * part @ known.T
        result[begin : begin + 4096] = np.sqrt(np.maximum(apart.min(axis=1), 0.0))
    return result


def spread_out(places: Floats, count: int) -> NDArray[np.int64]:
    """At most `count` row numbers, rising: each the farthest from those chosen before, so that all is covered."""
    if len(places) <= count:
        return np.arange(len(places), dtype=np.int64)
    chosen = np.empty(count, dtype=np.int64)
    chosen[0] = 0
    far = np.sum((places - places[0]) ** 2, axis=1)
    for i in range(1, count):
        chosen[i] = int(np.argmax(far))
        far = np.minimum(far, np.sum((places - places[chosen[i]]) ** 2, axis=1))
    return np.asarray(np.sort(chosen))


def _angles(rotation: Floats) -> Floats:
    from olp.robots.geometry import angles_from_rotation

    result = np.full((len(rotation), 3), np.nan)
    told = np.asarray(np.isfinite(rotation).all(axis=(1, 2)))
    if told.any():
        result[told] = angles_from_rotation(rotation[told])
    return result


def _nearest_other(places: Floats) -> Floats:
    square = np.sum(places**2, axis=1)
    apart = square[:, None] + square - 2 * places @ places.T
    np.fill_diagonal(apart, np.inf)
    return np.asarray(np.sqrt(np.maximum(apart.min(axis=1), 0.0)))


def _left_out_distance(labels: NDArray[np.int64], places: Floats) -> float:
    """[m] median over start points of the distance of their moves to those of all others; 0 with one start."""
    found = []
    for label in np.unique(labels).tolist()[:50]:
        own = labels == label
        if not own.all():
            found.append(float(np.median(nearest(places[own], places[~own]))))
    return float(np.median(found)) if found else 0.0
