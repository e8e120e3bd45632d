"""`olp vendors`: the robot languages."""

from __future__ import annotations

import json
from typing import Any, ClassVar

from pydantic import Field

from olp.servers.mcp.tool import AnswerRow, AssistantTool, ToolAnswer, ToolArguments, ToolCall


class Language(AnswerRow):
    """One robot language: its title and file suffixes."""

    title: str
    suffixes: list[str]


class SupportRow(AnswerRow):
    """Whether one language reads, and how exactly it writes, one kind of statement."""

    reads: bool
    writes: str | None = Field(description="exact, approximated, or null: not at all")


class VendorsAnswer(ToolAnswer):
    """The robot languages by name, and which statements each one reads and writes."""

    vendors: dict[str, Language]
    statements: dict[str, dict[str, SupportRow]] = Field(description="statement -> language -> support")


class Vendors(AssistantTool[ToolArguments]):
    """Runs `olp vendors --format json`."""

    title: ClassVar[str] = "Robot languages"
    description: ClassVar[str] = (
        "Lists the robot languages that olp reads and writes, with their file suffixes, and which "
        "statements each can say."
    )
    given = ToolArguments
    answer = VendorsAnswer

    def ask(self, given: ToolArguments, call: ToolCall) -> dict[str, Any]:
        ran = call.run("vendors", "--format=json")
        return {**json.loads(ran.printed), "exit_status": ran.status, "told": ran.told}
