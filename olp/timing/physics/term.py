"""The shape of a term: one effect that a simulation may have left out, as a forward model. One file per term.

The file's name is the term's name with _ for -; `olp/timing/physics/` is the list of them. A term of moves changes the
`Motion` of all moves together, so that terms act jointly (a slower speed also needs a shorter ramp); a term of
logs is told from time series, see `olp/identification/diagnosis/logs`. A term may be both.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from enum import IntEnum
from typing import ClassVar, NamedTuple

import numpy as np
from numpy.typing import NDArray

from olp.core.registry import file_names, load_from
from olp.timing.physics._case import MeasuredMoves
from olp.timing.physics._motion import Motion

Floats = NDArray[np.float64]


class Stage(IntEnum):
    """In which order terms act on a motion; terms of one stage do not hinder each other."""

    SCALES = 1  # factors on acceleration and speed
    LIMITS = 2  # the least of several limits
    SHAPES = 3  # jerk, corners
    ADDS = 4  # seconds beside the motion
    CLOCKS = 5  # what happens to whole durations


class TermParameter(NamedTuple):
    """One number of a term. `null`: the value at which the term does nothing (may be infinite); `listed`: it is one of
    those that the term guesses, and nothing between them."""

    name: str
    unit: str  # SI, "1" for a ratio
    low: float
    high: float
    null: float
    log: bool = False  # whether the search walks in its logarithm (positive scales)
    meaning: str = ""
    listed: bool = False


class Form(NamedTuple):
    """One way a term may act; `key` tells forms of one term apart ("" when there is only one)."""

    key: str
    parameters: tuple[TermParameter, ...]
    equation: str  # LaTeX
    axis: int = -1  # of the robot, from 0, where a form belongs to one axis


class Term(ABC):
    """What is known of one effect, in words and numbers."""

    summary: ClassVar[str]  # what it means
    does: ClassVar[str]  # what it does to which moves: the trace it leaves
    source: ClassVar[str]  # paper, equation, manual or measurement
    confusable: ClassVar[tuple[str, ...]] = ()  # names of terms that may look like it

    @property
    def name(self) -> str:
        """The contract's name: the file's name with - for _."""
        return type(self).__module__.rpartition(".")[2].replace("_", "-")


class MoveTerm(Term):
    """A term that is seen in durations of moves."""

    stage: ClassVar[Stage]
    phase: ClassVar[str] = "whole"  # of olp.identification.diagnosis.result.PHASES: where in a move it acts
    conditionable: ClassVar[bool] = True  # it changes moves one by one, so it may act in some of them alone
    by_time: ClassVar[bool] = False  # its size changes with the running time

    @abstractmethod
    def forms(self, case: MeasuredMoves) -> tuple[Form, ...]:
        """The forms that these moves can tell; () when they cannot tell the term at all."""

    def lacks(self, case: MeasuredMoves) -> str:
        """What would have to be recorded for this term to be told, "" when nothing is missing."""
        return ""

    @abstractmethod
    def guesses(self, form: Form, case: MeasuredMoves) -> Floats:
        """(g, p) starts for the search, in SI, inside the bounds."""

    @abstractmethod
    def act(self, motion: Motion, form: Form, values: Floats, case: MeasuredMoves) -> Motion:
        """The motion with the term in it."""

    def doubt(self, form: Form, values: Floats) -> float:
        """What values that physics does not expect cost, in units of BIC: 0 for those it does."""
        return 0.0

    def says(self, form: Form, values: Floats, case: MeasuredMoves) -> str:
        """One clause with the numbers, for a person: "every exact stop takes 38 ms longer"."""
        return ", ".join(f"{p.name} {v:.4g} {p.unit}" for p, v in zip(form.parameters, values, strict=True))


class LogTerm(Term):
    """A term that is seen in time series; `olp/identification/diagnosis/logs` looks for each kind of trace."""

    @abstractmethod
    def seen_in(self, columns: frozenset[str]) -> bool:
        """Whether a log with these columns ("command", "speed", "torque", "current", "sim") can tell the term."""


def term_names() -> tuple[str, ...]:
    """All terms, sorted."""
    return tuple(name.replace("_", "-") for name in file_names(Term))


def load_term(name: str) -> Term:
    """The term of a name. Raises OlpError N001."""
    return load_from(Term, name.replace("-", "_"), "term", "N001")
