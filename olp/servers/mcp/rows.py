"""Rows that several tools answer with: those of the command line's JSON, with their units in the names."""

from __future__ import annotations

from pydantic import BaseModel, ConfigDict, Field

from olp.servers.mcp.tool import ToolAnswer


class AnswerRow(BaseModel):
    """May grow."""

    model_config = ConfigDict(extra="allow")


class DiagnosticRow(AnswerRow):
    """A problem, a warning or a note at a place of a file; line 0 is the file as a whole."""

    code: str = Field(description="stable; `olp help CODE` explains it")
    severity: str = Field(description="error, warning or info")
    file: str
    line: int
    column: int
    message: str
    help: str = Field(description="what would have worked")


class Assumed(AnswerRow):
    """What the program does not say and was taken for granted."""

    line: int
    says: str


class Segment(AnswerRow):
    """One executed move, wait or signal, in the order of execution; a line in a loop comes several times."""

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
    """One timed program. low_s to high_s is the interval of the real cycle time, null without a signature."""

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
    """A finding of check, diff or lint."""

    code: str = Field(description="stable; `olp help CODE` explains it")
    level: str = Field(description="error, warning or note")
    message: str
    file: str
    line: int
    help: str
    fixable: bool
    numbers: dict[str, float | str] = Field(description="with their units in the names")


class JudgedRow(AnswerRow):
    """One thing that was judged: a budget, a file, a pair of versions."""

    name: str
    file: str
    line: int
    status: str = Field(description="held, warned, failed or unknown")
    message: str
    seconds: float | None = Field(description="the predicted time it is about [s]")
    limit_s: float | None


class JudgedAnswer(ToolAnswer):
    """What check, diff and lint answer."""

    findings: list[Found]
    items: list[JudgedRow]
    summary: list[str]
