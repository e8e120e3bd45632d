"""Base class of all blending laws; the files of this folder are the list of laws.

A corner is where one move ends and the next begins without a stop. Positions near it have two coordinates along the
two moves: `x` along the direction of the move before, up to 0 at the corner point, and `y` along that of the move
after, from 0 on, so that the tool is at corner point + x d1 + y d2. That holds for every angle and in space.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass, fields
from typing import ClassVar, NamedTuple, final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from olp.core.diagnostic import Diagnostic, OlpError, error, raise_errors
from olp.core.registry import file_names, load_from
from olp.timing.motion.model import ModelParameter

Floats = NDArray[np.float64]
Bools = NDArray[np.bool_]

_SAMPLES = 257  # instants at which a corner is looked at: the nearest one is refined by a parabola
_BLOCK = 4096  # corners looked at together, so that the samples of a block stay in the cache


@dataclass(frozen=True, slots=True)
class Corners:
    """Input of a blending law, one row per corner; every array has shape (n,)."""

    before: Floats  # length of the move before [m]
    after: Floats  # length of the move after [m]
    speed_before: Floats  # programmed [m/s], > 0
    speed_after: Floats  # programmed [m/s], > 0
    turn: Floats  # angle between the two directions [rad], 0 straight on, pi back
    amount: Floats  # what the program writes, in the unit the law names
    deceleration: Floats  # limit of the move before [m/s²], > 0, inf where none is known
    acceleration: Floats  # limit of the move after [m/s²], > 0, inf where none is known

    @classmethod
    def of(
        cls,
        before: ArrayLike,
        after: ArrayLike,
        speed_before: ArrayLike,
        speed_after: ArrayLike,
        turn: ArrayLike,
        amount: ArrayLike = 0.0,
        deceleration: ArrayLike = np.inf,
        acceleration: ArrayLike = np.inf,
    ) -> Corners:
        """Corners from numbers or arrays that broadcast to one shape. Raises OlpError (T011) for invalid numbers,
        such as negative lengths.
        """
        given = [before, after, speed_before, speed_after, turn, amount, deceleration, acceleration]
        arrays = [np.asarray(value, dtype=np.float64) for value in given]
        names = [field.name for field in fields(cls)]
        raise_errors([d for name, a in zip(names, arrays, strict=True) for d in _senseless(name, a)])
        shape = np.broadcast_shapes((1,), *(a.shape for a in arrays))
        if len(shape) != 1:
            raise OlpError(error("T011", f"a blending law takes one number per corner, not shape {shape}"))
        return cls(*(np.broadcast_to(a, shape) for a in arrays))

    @property
    def half(self) -> Floats:
        """Half of the shorter neighbour [m]: no controller here lets a zone reach further."""
        shorter: Floats = 0.5 * np.minimum(self.before, self.after)
        return shorter

    def take(self, rows: slice | NDArray[np.intp]) -> Corners:
        """The corners of these rows."""
        return Corners(*(getattr(self, field.name)[rows] for field in fields(self)))

    def __len__(self) -> int:
        return len(self.before)


@dataclass(frozen=True, slots=True)
class Passage:
    """How the corners are passed, (n,) each.

    The move before is cut by `trim_before` and the move after by `trim_after`; the corner replaces them: it takes
    `duration`, is entered at `speed_in` and left at `speed_out`. `capped`: the moves are too short for the corner
    that the program requests.
    """

    trim_before: Floats  # [m]
    trim_after: Floats  # [m]
    duration: Floats  # [s]
    speed_in: Floats  # [m/s]
    speed_out: Floats  # [m/s]
    capped: Bools

    @property
    def saving(self) -> Floats:
        """Time saved [s] compared with `speed_in` up to the corner point and `speed_out` from there on; negative
        for a loss.
        """
        saved = _ratio(self.trim_before, self.speed_in) + _ratio(self.trim_after, self.speed_out)
        result: Floats = saved - self.duration
        return result


class SpeedRange(NamedTuple):
    """Lowest and highest speed of the tool within each corner [m/s], (n,) each."""

    slowest: Floats
    fastest: Floats


class BlendingLaw(ABC):
    """Behaviour of one controller family at a corner. `amount`: meaning and unit of the number in the program."""

    summary: ClassVar[str]
    source: ClassVar[str]
    amount: ClassVar[str]
    measured: ClassVar[bool] = False  # whether recordings of a real controller stand behind the law
    overlap_skips: ClassVar[bool] = (
        False  # whether the robot leaves out a point whose zone meets another; else cut
    )
    share_zones: ClassVar[bool] = False  # a zone is a share of the speed, and no length
    runs_at_once: ClassVar[bool] = (
        False  # both moves run at once for a while; else something replaces the corner
    )
    parameters: ClassVar[tuple[ModelParameter, ...]] = ()

    def __init__(self, **values: float) -> None:
        """The law with its parameters (SI). Raises OlpError: T012 unknown parameter, T011 not a positive number."""
        known = {p.name: p.default for p in self.parameters}
        problems = []
        for name, value in values.items():
            if name not in known:
                says = f"the {self.name} blending law has no parameter {name!r}"
                problems.append(error("T012", says, help=f"it has: {', '.join(known) or 'none'}"))
            elif not (np.isfinite(value) and value > 0):
                problems.append(
                    error("T011", f"{name} = {value}", help=f"{name} has to be finite and positive")
                )
        raise_errors(problems)
        self.values = {**known, **values}

    @property
    def name(self) -> str:
        """Name of the law: that of its file."""
        return type(self).__module__.rpartition(".")[2]

    def _value(self, name: str) -> float:
        value = self.values[name]
        assert value is not None
        return value

    @abstractmethod
    def passage(self, corners: Corners) -> Passage:
        """Time and speeds of the corners, in closed form."""

    @abstractmethod
    def span(self, corners: Corners) -> Floats:
        """Duration [s] of each corner's curve, (n,): the range of times that `position` and `velocity` accept."""

    @abstractmethod
    def position(self, corners: Corners, time: Floats) -> Floats:
        """Position (x, y) [m] (see the module), (n, m, 2), at `time` (n, m) [s] since the corner began."""

    @abstractmethod
    def velocity(self, corners: Corners, time: Floats) -> Floats:
        """Velocity (x, y) [m/s], (n, m, 2), at `time` (n, m) [s] since the corner began."""

    @final
    def distance(self, corners: Corners) -> Floats:
        """Smallest distance of the tool from the corner point [m], (n,); sampled at 257 instants, the nearest one
        refined.
        """
        return self._over_blocks(corners, self._distance)

    @final
    def speed_range(self, corners: Corners) -> SpeedRange:
        """Lowest and highest speed within each corner, sampled at 257 instants."""
        squares = self._over_blocks(corners, self._speeds)
        return SpeedRange(squares[:, 0], squares[:, 1])

    def _over_blocks(self, corners: Corners, look: Callable[[Corners], Floats]) -> Floats:
        starts = range(0, len(corners), _BLOCK)
        return np.concatenate([look(corners.take(slice(s, s + _BLOCK))) for s in starts])

    def _instants(self, corners: Corners) -> Floats:
        return self.span(corners)[:, None] * np.linspace(0.0, 1.0, _SAMPLES)

    def _distance(self, corners: Corners) -> Floats:
        square = _square(self.position(corners, self._instants(corners)), corners.turn)
        nearest = np.clip(np.argmin(square, axis=1), 1, _SAMPLES - 2)
        rows = np.arange(len(corners))
        left, middle, right = (square[rows, nearest + k] for k in (-1, 0, 1))
        bend = left - 2 * middle + right
        with np.errstate(divide="ignore", invalid="ignore"):
            lowest = middle - np.where(bend > 0, (right - left) ** 2 / (8 * bend), 0.0)
        least = np.minimum(lowest, square.min(axis=1))
        result: Floats = np.sqrt(np.maximum(least, 0.0))
        return result

    def _speeds(self, corners: Corners) -> Floats:
        square = _square(self.velocity(corners, self._instants(corners)), corners.turn)
        extremes = np.stack([square.min(axis=1), square.max(axis=1)], axis=1)
        result: Floats = np.sqrt(np.maximum(extremes, 0.0))
        return result


def _square(along: Floats, turn: Floats) -> Floats:
    """Squared length (n, m) of x d1 + y d2."""
    x, y = along[..., 0], along[..., 1]
    result: Floats = x * x + y * y + 2 * x * y * np.cos(turn)[:, None]
    return result


def _ratio(length: Floats, speed: Floats) -> Floats:
    """Time [s] for a length at a speed; 0 where the length is 0."""
    return np.divide(length, speed, out=np.zeros_like(length), where=length > 0)


def _senseless(name: str, array: Floats) -> list[Diagnostic]:
    endless = name in ("deceleration", "acceleration")
    positive = endless or name.startswith("speed")
    wrong = np.isnan(array) | (array < 0) | (np.isinf(array) & (not endless)) | ((array == 0) & positive)
    if name == "turn":
        wrong |= array > np.pi * (1 + 1e-9)
    if not wrong.any():
        return []
    value = np.atleast_1d(array)[np.atleast_1d(wrong)][0]
    limit = "from 0 to pi" if name == "turn" else "positive" if positive else "finite and not negative"
    says = f"{name} = {value} in {wrong.sum()} of {array.size} corners"
    return [error("T011", says, help=f"{name} has to be {limit}")]


def law_names() -> tuple[str, ...]:
    """Names of all blending laws (the files of this folder), without loading them."""
    return file_names(BlendingLaw)


def load_law(name: str, **values: float) -> BlendingLaw:
    """Load the blending law called `name`, with parameters `values` (SI). Raises OlpError (T013) with the known
    names if there is none; T011 and T012 see BlendingLaw.
    """
    return load_from(BlendingLaw, name, "blending law", "T013", values=values)
