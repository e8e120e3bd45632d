"""`olp time`: every line's time."""

from __future__ import annotations

import json
from typing import Any, ClassVar

from pydantic import Field

from olp.languages.vendor import find_vendor, vendor_names
from olp.servers.mcp.tool import AssistantTool, ListedPrograms, ProgramRow, ToolAnswer, ToolCall

_LANGUAGES = ", ".join(f"{one.title} {one.suffixes[0]}" for one in map(find_vendor, vendor_names()))


class TimeGiven(ListedPrograms):
    """The programs to time, and how much detail to return."""

    summary: bool = Field(False, description="only the totals, no segments")


class TimeAnswer(ToolAnswer):
    """The predicted times of each program."""

    programs: list[ProgramRow]


class Time(AssistantTool[TimeGiven]):
    """Runs `olp time --format json`; each program has the keys of that format."""

    title: ClassVar[str] = "Cycle time of robot programs"
    description: ClassVar[str] = (
        f"Predicts how long robot programs take ({_LANGUAGES}): total, motion, waiting and I/O in seconds, and for "
        "every executed line its distance in mm, speeds in mm/s, duration in s and what limits it. What the "
        "program does not say is listed under assumptions. Ask with summary=true first when there are many "
        "programs."
    )
    given = TimeGiven
    answer = TimeAnswer

    def ask(self, given: TimeGiven, call: ToolCall) -> dict[str, Any]:
        words = [*given.words(call.folder), *(["--summary"] if given.summary else [])]
        jobs = given.programs(call.folder)
        ran = call.run("time", "--format=json", "--workers=1", *words, "--", *jobs)
        return {"exit_status": ran.status, "told": ran.told, "programs": json.loads(ran.printed)}
