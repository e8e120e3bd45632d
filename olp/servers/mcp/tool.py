"""What every tool has: typed arguments, a typed answer, and the words of the command line between them.

Rows that several tools answer with are those of the command line's JSON, with their units in the names.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any, ClassVar, Generic, Protocol, TypeVar

from pydantic import BaseModel, ConfigDict, Field

from olp.core.registry import file_names, load_from
from olp.robots import EXAMPLE_ROBOT
from olp.servers.confinement import Ran
from olp.servers.folder import Folder


class ToolArguments(BaseModel):
    """The arguments that every tool takes. A number has its unit in its name."""

    model_config = ConfigDict(extra="forbid", strict=True, allow_inf_nan=False)

    rows: int = Field(
        200,
        ge=1,
        le=10_000,
        description="at most this many rows per list of the answer; `truncated` names the lists that were cut",
    )


class ToolAnswer(BaseModel):
    """The keys that the answer of every tool has."""

    model_config = ConfigDict(extra="allow")

    exit_status: int = Field(
        description="0: done and held, 1: a finding (a budget exceeded, a rule broken), 2: could not be answered"
    )
    told: str = Field(description="notes, warnings and problems, as a person at a terminal would see them")
    truncated: list[str] = Field(
        description="the lists that were cut, and how long they are; [] when all is here"
    )


class ToolCall(Protocol):
    """The environment of one call: the served folder, a temporary folder, and the command line."""

    folder: Folder
    temporary: Path  # empty, and gone after the call
    write: bool

    def run(self, *words: str) -> Ran:
        """Run `olp WORD…` and return its exit status and output. Raises OlpError for bad input."""


Arguments = TypeVar("Arguments", bound=ToolArguments)


class AssistantTool(ABC, Generic[Arguments]):
    """A tool that an assistant can call. Each file of `tools/` defines one subclass; the file's name is the tool's
    name.
    """

    title: ClassVar[str]
    description: ClassVar[str]
    writes: ClassVar[bool] = False  # whether it is there with --write only
    given: ClassVar[type[ToolArguments]]
    answer: ClassVar[type[ToolAnswer]]

    @abstractmethod
    def ask(self, given: Arguments, call: ToolCall) -> dict[str, Any]:
        """Return the answer as JSON data, without the key `truncated`. Raises OlpError for bad input."""


def tool_names() -> tuple[str, ...]:
    """Return the names of all tools, sorted."""
    return file_names(AssistantTool, "tools")


def load_tool(name: str) -> AssistantTool[Any]:
    """Return the tool of this name. Raises OlpError (Z006) for an unknown name."""
    return load_from(AssistantTool, name, "tool", "Z006", folder="tools")


class Timed(ToolArguments):
    """The arguments of every tool that times programs; they mean the same as the options of `olp time`."""

    robot: str | None = Field(
        None,
        max_length=200,
        description=f"the robot: a name of the tool robots ({EXAMPLE_ROBOT}), or a robot file; default: the program's",
    )
    accel_mm_s2: float | None = Field(
        None, gt=0, description="acceleration of linear moves in mm/s²; default: the robot's"
    )
    override_pct: float | None = Field(
        None, gt=0, le=1000, description="speed override in percent; default: 100"
    )
    signature: str | None = Field(
        None,
        max_length=1024,
        description="the robot's timing signature, a file; gives the interval low_s to high_s",
    )
    assumptions: str | None = Field(
        None,
        max_length=1024,
        description="an olp.toml that says what inputs and waits do; default: the nearest",
    )
    max_steps: int | None = Field(
        None,
        ge=1,
        le=2_000_000,
        description="stop after this many executed statements; default: 200,000, and ten times those that are read",
    )

    def words(self, folder: Folder) -> Iterator[str]:
        """Yield these arguments as options of the command line. Raises OlpError for a path outside of the server's
        folder.
        """
        if self.robot is not None:
            yield f"--robot={robot_word(self.robot, folder)}"
        for option, path in (("signature", self.signature), ("assumptions", self.assumptions)):
            if path is not None:
                yield f"--{option}={folder.inside(path)}"
        if self.accel_mm_s2 is not None:
            yield f"--accel={self.accel_mm_s2!r}"
        if self.override_pct is not None:
            yield f"--override={self.override_pct!r}"
        if self.max_steps is not None:
            yield f"--max-steps={self.max_steps}"


def robot_word(text: str, folder: Folder) -> str:
    """Return a robot's name unchanged, and a robot file as a path below the folder. Raises OlpError for a path
    outside.
    """
    return folder.inside(text)


class ListedPrograms(Timed):
    """The programs to time, and how they are timed."""

    jobs: list[str] = Field(
        min_length=1,
        max_length=200,
        description="programs, or folders of programs, as paths below the server's folder; '.' is all of it",
    )

    def programs(self, folder: Folder) -> Sequence[str]:
        """Return the programs' paths. Raises OlpError for a path that is outside of the folder or missing, or too
        many programs.
        """
        from olp.languages.vendor import vendor_suffixes

        return folder.programs(self.jobs, vendor_suffixes())


class AnswerRow(BaseModel):
    """A row of an answer. Later versions may add keys."""

    model_config = ConfigDict(extra="allow")


class DiagnosticRow(AnswerRow):
    """An error, a warning or a note at a place of a file; line 0 means the file as a whole."""

    code: str = Field(description="stable; `olp help CODE` explains it")
    severity: str = Field(description="error, warning or info")
    file: str
    line: int
    column: int
    message: str
    help: str = Field(description="what would have worked")


class Assumed(AnswerRow):
    """An assumption that olp made because the program does not state the value."""

    line: int
    says: str


class Segment(AnswerRow):
    """One executed move, wait or signal, in order of execution; a line in a loop appears once per pass."""

    line: int
    statement: str
    kind: str = Field(description="joint, linear, circular, wait, signal …")
    distance_mm: float | None
    speed_mm_s: float | None = Field(description="programmed")
    reached_mm_s: float | None = Field(description="highest speed that is reached")
    accel_mm_s2: float | None
    limited_by: str = Field(description="what keeps this segment from being faster; '' for nothing")
    duration_s: float | None
    end_s: float | None = Field(description="since the start of the program")


class ProgramRow(AnswerRow):
    """One timed program. The real cycle time is expected from low_s to high_s [s], which are null without a
    signature.
    """

    file: str
    robot: str | None
    total_s: float | None = Field(
        description="predicted cycle time; null when the program could not be timed"
    )
    motion_s: float | None
    wait_s: float | None
    io_s: float | None
    low_s: float | None
    high_s: float | None
    segments: list[Segment]
    assumptions: list[Assumed]
    diagnostics: list[DiagnosticRow]


class Found(AnswerRow):
    """One finding of check, diff or lint."""

    code: str = Field(description="stable; `olp help CODE` explains it")
    level: str = Field(description="error, warning or note")
    message: str
    file: str
    line: int
    help: str
    fixable: bool
    numbers: dict[str, float | str] = Field(description="with their units in the names")


class JudgedRow(AnswerRow):
    """One judged item: a budget, a file, or a pair of versions."""

    name: str
    file: str
    line: int
    status: str = Field(description="held, warned, failed or unknown")
    message: str
    seconds: float | None = Field(description="the predicted time it is about [s]")
    limit_s: float | None


class JudgedAnswer(ToolAnswer):
    """The findings, judged items and summary that check, diff and lint return."""

    findings: list[Found]
    items: list[JudgedRow]
    summary: list[str]
