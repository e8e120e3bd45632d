"""The outcome of a command that judges: items that held or not, and findings at lines of programs.

`OutcomeFormat` is the base class of its formats; the files of this folder are the list of formats.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Collection, Mapping
from dataclasses import dataclass, field
from enum import StrEnum
from hashlib import sha256
from typing import ClassVar

from olp.core.diagnostic import Diagnostic, Severity
from olp.core.registry import file_names, load_from


class Level(StrEnum):
    """Severity of a finding: an error breaks the build, a warning is shown, a note explains."""

    ERROR = "error"
    WARNING = "warning"
    NOTE = "note"


class Status(StrEnum):
    """Result of an item."""

    HELD = "held"
    WARNED = "warned"
    FAILED = "failed"
    UNKNOWN = "unknown"  # could not be judged


@dataclass(frozen=True, slots=True)
class OutcomeFinding:
    """One finding at one place. `code` is stable; `line` and `column` count from 1, line 0: the file as a whole.

    `title`: short meaning of the code. `help`: how to improve it. `numbers`: measured values with their unit in the
    name (`total_s`, `over_s`). `anchor`: identifies the finding when lines above it are added or removed. `fixes`:
    (first line, last line, new text) that a tool may apply safely.
    """

    code: str
    level: Level
    message: str
    file: str = ""
    line: int = 0
    column: int = 1
    end_column: int = 0  # 0: the line's end
    title: str = ""
    help: str = ""
    source_line: str = ""
    anchor: str = ""
    numbers: Mapping[str, float | str] = field(default_factory=dict)
    fixes: tuple[tuple[int, int, str], ...] = ()

    @property
    def fingerprint(self) -> str:
        """16 hexadecimal digits that do not change when the finding moves to another line."""
        text = "\0".join((self.code, self.file.replace("\\", "/"), self.anchor or self.source_line.strip()))
        return sha256(text.encode("utf-8", "surrogatepass")).hexdigest()[:16]


@dataclass(frozen=True, slots=True)
class JudgedItem:
    """One judged item, like a test: a budget of a job, a rule over a file, a pair of versions.

    `seconds`: the predicted cycle time that was judged, None for other items. `limit_s`: its limit. `low_s`,
    `high_s`: the ends of the 95 % interval of a whole program's time, None for a part of a program.
    """

    name: str
    file: str
    status: Status
    message: str = ""
    line: int = 0
    seconds: float | None = None
    limit_s: float | None = None
    group: str = ""
    details: str = ""  # lines for where an item stands alone, as in JUnit
    low_s: float | None = None
    high_s: float | None = None

    def untold(self, places: Collection[tuple[str, int]]) -> bool:
        """Whether it could not be judged, and no finding at one of the `places` (file, line) reports that."""
        return self.status is Status.UNKNOWN and (not self.line or (self.file, self.line) not in places)


@dataclass(frozen=True, slots=True)
class Outcome:
    """All results of a run. `summary`: sentences for the user; `data`: additional content of the JSON output."""

    command: str
    findings: tuple[OutcomeFinding, ...] = ()
    items: tuple[JudgedItem, ...] = ()
    summary: tuple[str, ...] = ()
    data: Mapping[str, object] = field(default_factory=dict)

    @property
    def told(self) -> tuple[OutcomeFinding, ...]:
        """The findings, plus one (M012) for each item that could not be judged and has no finding.

        For formats that contain findings only and would otherwise omit these items.
        """
        places = {(found.file, found.line) for found in self.findings}
        return (
            *self.findings,
            *(_of_item(item) for item in self.items if item.untold(places)),
        )

    @property
    def exit_status(self) -> int:
        """0 done and held, 1 a finding that fails, 2 something could not be judged."""
        if any(item.status is Status.UNKNOWN for item in self.items):
            return 2
        failed = any(item.status is Status.FAILED for item in self.items)
        return 1 if failed or any(f.level is Level.ERROR for f in self.findings) else 0


def _of_item(item: JudgedItem) -> OutcomeFinding:
    says = f"{item.name}: {item.message or item.status}"
    title = "something could not be judged"
    return OutcomeFinding("M012", Level.ERROR, says, item.file, item.line, title=title, anchor=item.name)


def of_diagnostic(found: Diagnostic, file: str = "") -> OutcomeFinding:
    """A diagnostic of reading, running or timing as a finding."""
    level = {Severity.ERROR: Level.ERROR, Severity.WARNING: Level.WARNING}.get(found.severity, Level.NOTE)
    return OutcomeFinding(
        found.code,
        level,
        found.message,
        found.file or file,
        found.line,
        found.column,
        found.end_column,
        help=found.help,
        source_line=found.source_line,
        anchor="" if found.source_line.strip() else found.message,
    )


_OTHERS = frozenset({"model"})


class OutcomeFormat(ABC):
    """Base class of output formats. `suffix`: of a file in this format."""

    summary: ClassVar[str]
    suffix: ClassVar[str]

    @abstractmethod
    def render(self, outcome: Outcome) -> str:
        """The whole outcome as text, the same for the same outcome."""


def format_names() -> tuple[str, ...]:
    """The names of all formats, sorted."""
    return tuple(name for name in file_names(OutcomeFormat) if name not in _OTHERS)


def load_format(name: str) -> OutcomeFormat:
    """The format called `name`. Raises OlpError (C011) that lists the known ones."""
    return load_from(OutcomeFormat, name, "format", "C011")
