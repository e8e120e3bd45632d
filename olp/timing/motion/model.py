"""Base class of all motion models; the files of this folder are the list of models."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import ClassVar, final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from olp.core.diagnostic import Diagnostic, OlpError, error, raise_errors
from olp.core.registry import file_names, load_from
from olp.timing.motion._profile import Bools, Floats, Problem, Profile, RequestedMoves

Values = Mapping[str, Floats | None]  # a model's parameters by name, shape (n,); None where left to the model


@dataclass(frozen=True, slots=True)
class ModelParameter:
    """A parameter that a model needs besides speeds and accelerations."""

    name: str
    unit: str
    default: float | None  # None: the model derives it, as `source` says
    source: str


class MotionModel(ABC):
    """Turns lengths, speeds and accelerations of many moves at once into profiles of speed over time."""

    summary: ClassVar[str]
    source: ClassVar[str]
    parameters: ClassVar[tuple[ModelParameter, ...]] = ()

    @property
    def name(self) -> str:
        """Name of the model: that of its file."""
        return type(self).__module__.rpartition(".")[2]

    @abstractmethod
    def solve(self, moves: RequestedMoves, values: Values) -> Profile:
        """Profiles of valid moves (lengths >= 0, limits > 0); a length of 0 takes no time."""

    @final
    def profile(
        self,
        length: ArrayLike,
        speed: ArrayLike,
        acceleration: ArrayLike,
        deceleration: ArrayLike | None = None,
        start_speed: ArrayLike = 0.0,
        end_speed: ArrayLike = 0.0,
        **parameters: ArrayLike,
    ) -> Profile:
        """Profiles of n moves: each argument has shape () or (n,), in m (or rad), m/s, m/s², m/s³, s.

        `deceleration` equals `acceleration` if omitted. `Profile.problem` tells for each move what could not be
        done as requested. Raises OlpError for negative or non-finite numbers, for unknown parameters, and for a
        profile that, integrated, misses its target: every answer is checked.
        """
        braking = acceleration if deceleration is None else deceleration
        moves, values = self._moves(
            (length, speed, acceleration, braking, start_speed, end_speed), parameters
        )
        stuck = _stuck(moves)
        profile = self.solve(_sound(moves, stuck), values)
        if stuck.any():
            profile = _never_ending(profile, stuck)
        wrong = profile.defects()
        if wrong.any():
            rows = ", ".join(str(i) for i in np.flatnonzero(wrong)[:5])
            says = f"the {self.name} motion model missed its own target for {wrong.sum()} moves (rows {rows})"
            raise OlpError(error("T003", says, help="the model is wrong here: please report the moves"))
        return profile

    def _moves(
        self, arguments: tuple[ArrayLike, ...], parameters: dict[str, ArrayLike]
    ) -> tuple[RequestedMoves, Values]:
        given = [np.asarray(a, dtype=np.float64) for a in (*arguments, *parameters.values())]
        names = [*RequestedMoves.__dataclass_fields__, *parameters]
        # A deceleration that was left out is the acceleration, and is not complained about twice.
        twice = "deceleration" if arguments[3] is arguments[2] else ""
        checked = [(n, g) for n, g in zip(names, given, strict=True) if n != twice]
        problems = [d for name, array in checked for d in _bad_numbers(name, array)]
        known = [p.name for p in self.parameters]
        for name in parameters:
            if name not in known:
                says = f"the {self.name} motion model has no parameter {name!r}"
                problems.append(error("T002", says, help=f"it has: {', '.join(known) or 'none'}"))
        shape = np.broadcast_shapes((1,), *(a.shape for a in given))
        if len(shape) != 1:
            raise OlpError(error("T001", f"a motion model takes one number per move, not shape {shape}"))
        raise_errors(problems)
        rows = [np.broadcast_to(a, shape) for a in given]
        values = dict(zip(names[6:], rows[6:], strict=True))
        defaults = {
            p.name: None if p.default is None else np.broadcast_to(p.default, shape) for p in self.parameters
        }
        return RequestedMoves(*rows[:6]), defaults | values


def _bad_numbers(name: str, array: NDArray[np.float64]) -> list[Diagnostic]:
    wrong = ~(np.isfinite(array) & (array >= 0))
    if name not in RequestedMoves.__dataclass_fields__:
        wrong |= array == 0
    if not wrong.any():
        return []
    value = np.atleast_1d(array)[np.atleast_1d(wrong)][0]
    limit = (
        "finite and not negative" if name in RequestedMoves.__dataclass_fields__ else "finite and positive"
    )
    says = f"{name} = {value} in {wrong.sum()} of {array.size} values"
    return [error("T001", says, help=f"{name} has to be {limit}")]


def _stuck(moves: RequestedMoves) -> Bools:
    limits = np.minimum(np.minimum(moves.speed, moves.acceleration), moves.deceleration)
    return (moves.length > 0) & (limits <= 0)


def _sound(moves: RequestedMoves, stuck: Bools) -> RequestedMoves:
    """The same moves with placeholders where a limit is zero, so that models never divide by zero."""

    def positive(a: Floats) -> Floats:
        return np.where(a > 0, a, 1.0)

    return RequestedMoves(
        np.where(stuck, 0.0, moves.length),
        np.where(stuck, 1.0, positive(moves.speed)),
        positive(moves.acceleration),
        positive(moves.deceleration),
        np.where(stuck, 0.0, moves.start_speed),
        np.where(stuck, 0.0, moves.end_speed),
    )


def _never_ending(profile: Profile, stuck: Bools) -> Profile:
    durations = profile.durations.copy()
    durations[stuck, len(profile.phases) // 2] = np.inf
    moves = replace(profile.moves, speed=np.where(stuck, 0.0, profile.moves.speed))
    problem = np.where(stuck, np.int8(Problem.NO_SPEED), profile.problem)
    return Profile.build(moves, profile.phases, durations, profile.accelerations, profile.jerks, problem)


def model_names() -> tuple[str, ...]:
    """Names of all motion models (the files of this folder), without loading them."""
    return file_names(MotionModel)


def load_model(name: str) -> MotionModel:
    """Load the motion model called `name`. Raises OlpError (T004) with the known names if there is none."""
    return load_from(MotionModel, name, "motion model", "T004")
