"""The base of all estimators, and the list of them, which is the listing of `estimators/`.

Codes: H001 no such estimator, H002 the recording does not hold what the estimator needs.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from functools import lru_cache
from typing import TYPE_CHECKING, ClassVar, NamedTuple

import numpy as np
from numpy.typing import NDArray

from olp.core.diagnostic import OlpError, error
from olp.core.registry import file_names, load_from
from olp.identification.signature.coefficients import Parameters
from olp.identification.signature.moveset import MoveSet

if TYPE_CHECKING:
    from olp.robots.model import Robot

Floats = NDArray[np.float64]

_FOLDER = "estimators"
_KEPT = 16  # fits that are remembered: of all methods, on the same moves


class Estimate(NamedTuple):
    """What an estimator says of n moves."""

    slowness: Floats  # (n,) [s²/m] one over the corrected acceleration (6.1)
    sd: Floats  # (n,) [s²/m] the estimator's own doubt; 0 where it has no opinion
    inside: NDArray[np.bool_]  # (n,) whether the estimator interpolates here
    seconds: Floats | None = (
        None  # (n,) [s] of methods that know more than an acceleration; nan where they do not
    )


class Estimator(ABC):
    """Learns how much longer than length/speed a move takes, as one over an acceleration (equation 6.1).

    Of constant acceleration, slowness s makes a move of length L at speed v take L/v + v s (a trapezoid), or
    2 √(L s) where v is not reached. All effects that grow with the speed are in it.
    """

    summary: ClassVar[str]
    needs_robot: ClassVar[bool] = False
    preferred: ClassVar[bool] = False  # among methods that are equally good

    @property
    def name(self) -> str:
        """The name of the file the estimator lives in."""
        return type(self).__module__.rpartition(".")[2]

    def needs(self, moves: MoveSet, robot: Robot | None) -> str:
        """Why this estimator cannot learn from these moves, "" when it can."""
        return ""

    def suits(self, moves: MoveSet) -> bool:
        """Whether it says something of most moves like these: one that does not is no choice by itself."""
        return True

    @abstractmethod
    def fit(self, moves: MoveSet, robot: Robot | None) -> Parameters:
        """Learns from measured moves; uses nothing else."""

    @abstractmethod
    def estimate(self, parameters: Parameters, moves: MoveSet, robot: Robot | None) -> Estimate:
        """Slowness of moves, from learnt parameters as they stand in a file."""


def measured_slowness(moves: MoveSet) -> Floats:
    """(n,) [s²/m] one over the adjusted acceleration (6.1); nan where no acceleration makes a move that fast."""
    from olp.identification.apostolovic import adjusted_acceleration

    return np.asarray(1.0 / adjusted_acceleration(moves.duration, moves.length, moves.speed))


def duration_of(slowness: Floats, moves: MoveSet) -> Floats:
    """(n,) [s] of moves with constant acceleration 1/`slowness` from rest to rest (section 4.2)."""
    way, speed = moves.length, moves.speed
    s = np.maximum(slowness, 0.0)
    return np.asarray(np.where(speed * speed * s <= way, way / speed + speed * s, 2 * np.sqrt(way * s)))


def estimator_names() -> tuple[str, ...]:
    """The estimators there are: the files of `estimators/`, without loading them."""
    return file_names(Estimator, _FOLDER)


def load_estimator(name: str) -> Estimator:
    """The estimator of that name; raises OlpError (H001), listing those there are and `auto`."""
    return load_from(Estimator, name, "method", "H001", folder=_FOLDER, others=("auto",))


@lru_cache(maxsize=_KEPT)
def learnt(name: str, moves: MoveSet, robot: Robot | None) -> Parameters:
    """`fit` of the estimator of that name; several that build on one another then learn its part once."""
    return load_estimator(name).fit(moves, robot)


def fit_or_refuse(estimator: Estimator, moves: MoveSet, robot: Robot | None) -> Parameters:
    """`fit`, after asking whether it can. Raises OlpError (H002)."""
    why = estimator.needs(moves, robot)
    if why:
        raise OlpError(error("H002", f"method {estimator.name}: {why}"))
    return learnt(estimator.name, moves, robot)
