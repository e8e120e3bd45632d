"""`olp vendors`: the robot languages."""

from __future__ import annotations

import json
from typing import Any, ClassVar

from pydantic import Field

from olp.servers.mcp.tool import AnswerRow, AssistantTool, ToolAnswer, ToolArguments, ToolCall


class Language(AnswerRow):
    """One robot language."""

    title: str
    suffixes: list[str]


class SupportRow(AnswerRow):
    """What one language does with one statement."""

    reads: bool
    writes: str | None = Field(description="exact, approximated, or null: not at all")


class VendorsAnswer(ToolAnswer):
    """By name."""

    vendors: dict[str, Language]
    statements: dict[str, dict[str, SupportRow]] = Field(description="statement -> language -> support")


class Vendors(AssistantTool[ToolArguments]):
    """`olp vendors --format json`."""

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
