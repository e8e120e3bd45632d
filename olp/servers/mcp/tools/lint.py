"""`olp lint`: motion mistakes."""

from __future__ import annotations

import json
from typing import Any, ClassVar

from pydantic import Field

from olp.servers.mcp.tool import AssistantTool, JudgedAnswer, ListedPrograms, ToolCall


class LintGiven(ListedPrograms):
    """The programs to check for motion mistakes, and the rules to apply."""

    select: list[str] = Field([], max_length=50, description="only these rules, such as W001; default: all")
    ignore: list[str] = Field([], max_length=50, description="not these rules")


class Lint(AssistantTool[LintGiven]):
    """Runs `olp lint` without fixes: reports findings and changes no file."""

    title: ClassVar[str] = "Motion mistakes in robot programs"
    description: ClassVar[str] = (
        "Finds mistakes in robot programs that cost time or safety: undefined points, stops that should be "
        "blended, speeds that are never reached, moves that go nowhere … Each finding has a code, a line "
        "and what would help."
    )
    given = LintGiven
    answer = JudgedAnswer

    def ask(self, given: LintGiven, call: ToolCall) -> dict[str, Any]:
        codes = [f"--select={','.join(given.select)}", f"--ignore={','.join(given.ignore)}"]
        jobs = given.programs(call.folder)
        ran = call.run("lint", "--format=json", "--workers=1", *codes, *given.words(call.folder), "--", *jobs)
        return {**json.loads(ran.printed), "exit_status": ran.status, "told": ran.told}
