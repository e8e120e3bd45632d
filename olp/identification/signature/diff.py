"""What two signatures say differently: facts, and the times of the moves both were learnt on."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from olp.core.units import mm
from olp.identification.signature.document import Signature
from olp.identification.signature.moveset import MoveSet
from olp.identification.signature.predict import predict

Floats = NDArray[np.float64]


class SignatureDifference(NamedTuple):
    """`facts`: name, old, new. `start`, `end` (m, 3) [m], `old`, `new` (m,) [s]: at the moves of both domains."""

    facts: list[tuple[str, str, str]]
    start: Floats
    end: Floats
    old: Floats
    new: Floats
    apart: NDArray[np.bool_]  # (m,) the intervals do not touch

    @property
    def percent(self) -> Floats:
        """(m,) [%] new less old, of old."""
        return np.asarray(100.0 * (self.new - self.old) / self.old)


def difference(old: Signature, new: Signature) -> SignatureDifference:
    """Compares at the highest speed that both know. Raises OlpError where one cannot predict."""
    facts = [
        (name, str(a), str(b))
        for name, a, b in (
            ("robot", old.robot, new.robot),
            ("controller", old.controller, new.controller),
            ("method", old.method, new.method),
            ("payload_kg", old.payload, new.payload),
            ("moves", old.recording.moves, new.recording.moves),
            ("recording", old.recording.sha256[:12], new.recording.sha256[:12]),
        )
        if a != b
    ]
    places = np.concatenate([old.domain.moves, new.domain.moves])
    angles = np.concatenate([old.domain.angles, new.domain.angles])
    rows = np.unique(np.round(places / mm, 3), axis=0, return_index=True)[1]
    moves = domain_moves(places[rows], angles[rows], min(old.domain.speed[1], new.domain.speed[1]))
    before, after = predict(old, moves), predict(new, moves)
    apart = (before.high < after.low) | (after.high < before.low)
    return SignatureDifference(facts, moves.start, moves.end, before.duration, after.duration, apart)


def domain_moves(places: Floats, angles: Floats, speed: float) -> MoveSet:
    """Moves (m, 6) [m] with the tool at `angles` (m, 3) [rad] as a set to predict, at `speed` [m/s]."""
    from olp.robots.geometry import rotation_from_angles

    count = len(places)
    unknown = np.full(count, np.nan)
    rotation = np.full((count, 3, 3), np.nan)
    told = np.asarray(np.isfinite(angles).all(axis=1))
    if told.any():
        rotation[told] = rotation_from_angles(angles[told])
    return MoveSet(
        start=places[:, :3],
        end=places[:, 3:],
        rotation=rotation,
        speed=np.full(count, speed),
        nominal=unknown,
        duration=unknown,
        payload=unknown,
        configuration=("",) * count,
        program=("",) * count,
    )
