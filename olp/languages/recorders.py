"""What controllers record of their own accord: a vendor reads it, this is the form in which it hands it on.

A vendor that has such files has a module `recorder` with `RECORDER`, a `ControllerRecorder`; one whose logs are tables
with column names of their own has a module `log_columns` with `LOG_COLUMNS`, a `ControllerLog`.

Codes: D050 a file of the set is missing, D051 what a file holds is not what it says, D052 motions that no recording can
hold.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from olp.core.diagnostic import Diagnostic
from olp.languages.vendor import part_of, vendor_names

Floats = NDArray[np.float64]


@dataclass(frozen=True, slots=True)
class ControllerMotion:
    """One motion as the controller carried it out: from `begin` to `end` on the recorder's clock [s].

    `kind`: joint, linear or circular. `says`: further columns of moves.csv in their units, such as `speed_mm_s`.
    `job` is "" and `line` 0 where the recorder does not tell them.
    """

    kind: str
    job: str
    line: int
    begin: float
    end: float
    says: Mapping[str, float] = field(default_factory=dict)


@dataclass(frozen=True, slots=True)
class ControllerRun:
    """One recording of a controller. `robot`: as the controller calls it. `period` [s] of its samples.

    `time` (n,) [s]; `joints` (n, k) [deg | mm], `slides` (k,) which axes are lengths, () for none; `tool` (n, 6) x y z
    [mm] and Rx Ry Rz [deg] in the robot's base, None where it is not recorded so. `flange_tool`: the tool on the flange
    in the same units, None where it is not told.
    """

    name: str
    robot: str
    period: float
    motions: tuple[ControllerMotion, ...]
    time: Floats
    joints: Floats
    tool: Floats | None = None
    flange_tool: tuple[float, ...] | None = None
    controller: str = ""
    diagnostics: tuple[Diagnostic, ...] = ()
    slides: tuple[bool, ...] = ()


class ControllerRecorder(ABC):
    """A controller's recorder. `files`: what its files are called, for people."""

    files: ClassVar[str]

    @abstractmethod
    def set_of(self, path: Path) -> Path | None:
        """What all files of the recording to which `path` belongs have in common, None where it is none of these."""

    @abstractmethod
    def read(self, stem: Path) -> ControllerRun:
        """The recording. Raises OlpError (D050, D051)."""


def recorders() -> Sequence[ControllerRecorder]:
    """Every recorder that a vendor reads."""
    found = (part_of(name, "recorder") for name in vendor_names())
    return [recorder for recorder in found if recorder is not None]


class ControllerLog(ABC):
    """A log as a table whose columns are not called as a recording's are. `files`: what writes it, for people.

    `joint_names`: how the names of the axes end where ROS records them, from the base on; () where they are numbered.
    """

    files: ClassVar[str]
    joint_names: ClassVar[tuple[str, ...]] = ()

    @abstractmethod
    def knows(self, names: Sequence[str]) -> bool:
        """Whether these are the columns of such a log."""

    @abstractmethod
    def columns(self, cells: Mapping[str, Floats]) -> Mapping[str, Floats]:
        """The columns of a recording's log in their units (docs/recording.md); `cells`: the numbers as written."""


def controller_logs() -> Sequence[ControllerLog]:
    """Every kind of log that a vendor knows."""
    found = (part_of(name, "log_columns") for name in vendor_names())
    return [log for log in found if log is not None]
