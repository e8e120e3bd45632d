"""The base of all report formats, and the list of them, which is the listing of this folder.

A report over many files is made in two halves, so that the first can run on all cores: `part` renders one file,
`join` puts the parts together.
"""

from __future__ import annotations

import importlib
import pkgutil
from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, ClassVar

from olp.diagnostic import Diagnostic, OlpError, error

if TYPE_CHECKING:
    from olp.timing import Timing


@dataclass(frozen=True, slots=True)
class Options:
    """How much is told. `segments`: each line, not only totals. `width`: characters per line, 0 for no limit.

    `colour`: the report goes to a terminal that shows colour."""

    segments: bool = True
    width: int = 0
    colour: bool = False


@dataclass(frozen=True, slots=True)
class Part:
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


class Report(ABC):
    """One format."""

    summary: ClassVar[str]

    @abstractmethod
    def part(
        self, file: str, timing: Timing | None, diagnostics: Sequence[Diagnostic], options: Options
    ) -> str:
        """One file; `timing` is None when it could not be read."""

    @abstractmethod
    def join(self, parts: Sequence[Part], options: Options) -> str:
        """The whole report, ending in a line end."""


def report_names() -> tuple[str, ...]:
    """The formats there are, without loading them."""
    folder = importlib.import_module("olp.report").__path__
    names = (module.name for module in pkgutil.iter_modules(folder))
    return tuple(sorted(name for name in names if name != "report" and not name.startswith("_")))


def load_report(name: str) -> Report:
    """The format of that name; raises OlpError, listing those there are."""
    if name not in report_names():
        says = f"there is no report format {name!r}"
        raise OlpError(error("T005", says, help=f"available: {', '.join(report_names())}"))
    module = importlib.import_module(f"olp.report.{name}")
    for thing in vars(module).values():
        if isinstance(thing, type) and issubclass(thing, Report) and thing.__module__ == module.__name__:
            return thing()
    raise OlpError(error("T005", f"olp/report/{name}.py defines no report"))
