"""Base class of all report formats; the files of this folder are the list of formats.

A report over many files is made in two steps, so that the first can run on all cores: `part` renders one file,
`join` combines the parts.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, ClassVar, Final

from olp.core.diagnostic import Diagnostic
from olp.core.registry import file_names, load_from
from olp.runtime.plan import leaves_open

if TYPE_CHECKING:
    from olp.reports.cell import BranchTime, CellLinks, ProgramCost
    from olp.timing.result import Timing


def _no_links() -> CellLinks:
    from olp.reports.cell import CellLinks

    return CellLinks()


@dataclass(frozen=True, slots=True)
class Options:
    """Amount of detail. `segments`: each line, not only totals. `width`: characters per line, 0 for no limit.

    `top`: number of costliest lines to list. `by`: only the totals by cause, job or line. `sort`: of several
    programs, by time or file; else each one below its caller. `colour`: the report goes to a terminal with colour.
    `interval`: a signature gives every segment an interval.
    """

    segments: bool = True
    width: int = 0
    colour: bool = False
    interval: bool = False
    top: int = 0
    by: str = ""
    sort: str = ""


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
    links: CellLinks = field(default_factory=lambda: _no_links())  # what it calls, and others may call in it
    cost: ProgramCost | None = None  # where its time goes, where that was asked for
    branches: tuple[BranchTime, ...] = ()  # of a main program that somebody else tells what to do
    lacks_start: bool = False  # it has no routine, or none of the name that was to be started

    @property
    def failed(self) -> bool:
        return any(d.is_error for d in self.diagnostics)

    @property
    def is_partial(self) -> bool:
        """Whether the total is incomplete, or rests on an assumption that no file supports."""
        return any(map(leaves_open, self.diagnostics))


class Report(ABC):
    """One format."""

    summary: ClassVar[str]
    suffixes: ClassVar[tuple[str, ...]] = ()  # of the files that hold it, lower case

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
    """Load the format called `name`. Raises OlpError (T005) with the known names if there is none."""
    return load_from(Report, name, "report format", "T005")


def format_of(file: str) -> str | None:
    """The format for a file's suffix, None if unknown. The rows of a workbook are those of CSV."""
    suffix = Path(file).suffix.lower()
    if suffix == WORKBOOK:
        return "csv"
    return next((name for name in report_names() if suffix in load_report(name).suffixes), None)


WORKBOOK: Final = ".xlsx"
