"""`olp vendors`: the robot languages."""

from __future__ import annotations

import json
from typing import Any, ClassVar

from pydantic import Field

from olp.servers.mcp.rows import Row
from olp.servers.mcp.tool import Answer, Call, Given, Tool


class Language(Row):
    """One robot language."""

    title: str
    suffixes: list[str]


class Support(Row):
    """What one language does with one statement."""

    reads: bool
    writes: str | None = Field(description="exact, approximated, or null: not at all")


class VendorsAnswer(Answer):
    """By name."""

    vendors: dict[str, Language]
    statements: dict[str, dict[str, Support]] = Field(description="statement -> language -> support")


class Vendors(Tool[Given]):
    """`olp vendors --format json`."""

    title: ClassVar[str] = "Robot languages"
    description: ClassVar[str] = (
        "Lists the robot languages that olp reads and writes, with their file suffixes, and which "
        "statements each can say."
    )
    given = Given
    answer = VendorsAnswer

    def ask(self, given: Given, call: Call) -> dict[str, Any]:
        ran = call.run("vendors", "--format=json")
        return {**json.loads(ran.printed), "exit_status": ran.status, "told": ran.told}
