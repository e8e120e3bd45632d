"""The base of all report formats, and the list of them, which is the listing of this folder.

A report over many files is made in two halves, so that the first can run on all cores: `part` renders one file,
`join` puts the parts together.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, ClassVar

from olp.core.diagnostic import Diagnostic
from olp.core.registry import file_names, load_from
from olp.runtime.state import ASSUMABLE

if TYPE_CHECKING:
    from olp.timing.timing import Timing


@dataclass(frozen=True, slots=True)
class Options:
    """How much is told. `segments`: each line, not only totals. `width`: characters per line, 0 for no limit.

    `colour`: the report goes to a terminal that shows colour. `interval`: a signature gives every segment one.
    """

    segments: bool = True
    width: int = 0
    colour: bool = False
    interval: bool = False


@dataclass(frozen=True, slots=True)
class ReportPart:
    """One file's share of a report. Times [s]; None where the file could not be timed at all."""

    file: str
    text: str = ""
    robot: str | None = None
    total_s: float | None = None
    motion_s: float | None = None
    wait_s: float | None = None
    io_s: float | None = None
    assumed: int = 0  # number of assumptions
    diagnostics: tuple[Diagnostic, ...] = field(default=())
    called: tuple[str, ...] = ()  # other files whose routines ran in its time

    @property
    def failed(self) -> bool:
        return any(d.is_error for d in self.diagnostics)

    @property
    def is_partial(self) -> bool:
        """Whether the total leaves something out, or had to assume what no file says."""
        return any(d.is_error or d.code in ASSUMABLE for d in self.diagnostics)


class Report(ABC):
    """One format."""

    summary: ClassVar[str]

    @abstractmethod
    def part(
        self, file: str, timing: Timing | None, diagnostics: Sequence[Diagnostic], options: Options
    ) -> str:
        """One file; `timing` is None when it could not be read."""

    @abstractmethod
    def join(self, parts: Sequence[ReportPart], options: Options) -> str:
        """The whole report, ending in a line end."""


def report_names() -> tuple[str, ...]:
    """The formats there are, without loading them."""
    return file_names(Report)


def load_report(name: str) -> Report:
    """The format of that name; raises OlpError (T005), listing those there are."""
    return load_from(Report, name, "report format", "T005")
