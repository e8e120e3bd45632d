"""Base classes of terms: one effect that a simulation may have left out, as a forward model. One file per term.

The file's name is the term's name with _ for -; the files of `olp/timing/physics/` are the list of terms. A term of
moves changes the `Motion` of all moves together, so that terms act jointly (a slower speed also needs a shorter
ramp); a term of logs is identified from time series, see `olp/identification/diagnosis/logs`. A term may be both.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from enum import IntEnum
from functools import cached_property
from typing import ClassVar, NamedTuple

import numpy as np
from numpy.typing import NDArray

from olp.core.registry import file_names, load_from
from olp.timing.physics._case import MeasuredMoves
from olp.timing.physics._motion import Motion

Floats = NDArray[np.float64]


class Stage(IntEnum):
    """Order in which terms act on a motion; terms of one stage can act in any order."""

    SCALES = 1  # factors on acceleration and speed
    LIMITS = 2  # the least of several limits
    SHAPES = 3  # jerk, corners
    ADDS = 4  # seconds beside the motion
    CLOCKS = 5  # what happens to whole durations


class TermParameter(NamedTuple):
    """One parameter of a term. `null`: the value at which the term has no effect (may be infinite); `listed`: only
    the values that the term guesses are possible, none between them.
    """

    name: str
    unit: str  # SI, "1" for a ratio
    low: float
    high: float
    null: float
    log: bool = False  # whether the search walks in its logarithm (positive scales)
    meaning: str = ""
    listed: bool = False


class Form(NamedTuple):
    """One way in which a term may act; `key` distinguishes the forms of one term ("" for a single one)."""

    key: str
    parameters: tuple[TermParameter, ...]
    equation: str  # LaTeX
    axis: int = -1  # of the robot, from 0, where a form belongs to one axis
    usual: float = 0.0  # the least value of its parameter that physics expects, see `MoveTerm.doubt`


def spoken_axis(name: str) -> str:
    """The name of an axis in a sentence: "axis A1", and "axis 1" where that is its name, as of an unknown robot."""
    return name if name.startswith("axis ") else f"axis {name}"


class Term(ABC):
    """One effect: its description, source, and the terms it may be confused with."""

    summary: ClassVar[str]  # what it means
    does: ClassVar[str]  # what it does to which moves: the trace it leaves
    source: ClassVar[str]  # paper, equation, manual or measurement
    confusable: ClassVar[tuple[str, ...]] = ()  # names of terms that may look like it

    @cached_property
    def name(self) -> str:
        """Name of the term: that of its file with - for _."""
        return type(self).__module__.rpartition(".")[2].replace("_", "-")


class MoveTerm(Term):
    """A term that changes durations of moves."""

    stage: ClassVar[Stage]
    phase: ClassVar[str] = "whole"  # of olp.identification.diagnosis.result.PHASES: where in a move it acts
    conditionable: ClassVar[bool] = True  # it changes moves one by one, so it may act in some of them alone
    by_time: ClassVar[bool] = False  # its size changes with the running time

    @abstractmethod
    def forms(self, case: MeasuredMoves) -> tuple[Form, ...]:
        """The forms that these moves can identify; () if they cannot identify the term at all."""

    def lacks(self, case: MeasuredMoves) -> str:
        """What has to be recorded to identify this term; "" when nothing is missing."""
        return ""

    def by_axis(self, form: Form) -> bool:
        """Whether the form asks which axis leads a move: then it acts on the axes that may take over one by one."""
        return form.axis >= 0

    @abstractmethod
    def guesses(self, form: Form, case: MeasuredMoves) -> Floats:
        """Start values for the search (g, p), in SI, inside the bounds."""

    @abstractmethod
    def act(self, motion: Motion, form: Form, values: Floats, case: MeasuredMoves) -> Motion:
        """The motion with the effect of the term."""

    def doubt(self, form: Form, values: Floats) -> float:
        """Penalty, in units of BIC, for values that physics does not expect; 0 for expected ones."""
        return 0.0

    def beside_acceleration(
        self, form: Form, values: Floats, case: MeasuredMoves
    ) -> tuple[Floats, float] | None:
        """The same law with one number less beside another acceleration: values of which one is that at which the term
        begins, and the factor [1] on all accelerations. None where one of the numbers does not stand for a factor."""
        return None

    def says(self, form: Form, values: Floats, case: MeasuredMoves) -> str:
        """One clause with the numbers for the user: "every exact stop takes 38 ms longer"."""
        return ", ".join(f"{p.name} {v:.4g} {p.unit}" for p, v in zip(form.parameters, values, strict=True))


class LogTerm(Term):
    """A term that changes time series; `olp/identification/diagnosis/logs` looks for each kind of trace."""

    @abstractmethod
    def seen_in(self, columns: frozenset[str]) -> bool:
        """Whether a log with these columns ("command", "speed", "torque", "current", "sim") can identify the term."""


def term_names() -> tuple[str, ...]:
    """All terms, sorted."""
    return tuple(name.replace("_", "-") for name in file_names(Term))


def load_term(name: str) -> Term:
    """Load the term called `name`. Raises OlpError (N001) if there is none."""
    return load_from(Term, name.replace("-", "_"), "term", "N001")
