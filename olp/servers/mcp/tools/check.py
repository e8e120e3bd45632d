"""`olp check`: cycle-time budgets."""

from __future__ import annotations

import json
from typing import Any, ClassVar

from pydantic import Field

from olp.servers.mcp.tool import AnswerRow, AssistantTool, JudgedAnswer, ListedPrograms, ToolCall


class CheckGiven(ListedPrograms):
    """The programs to check, and the file with their cycle-time budgets."""

    budgets: str | None = Field(
        None,
        max_length=1024,
        description="an olp.toml with [[budget]] tables; default: the nearest of each program",
    )


class Total(AnswerRow):
    """The predicted times [s] of one program; null where it could not be timed."""

    file: str
    total_s: float | None
    motion_s: float | None
    wait_s: float | None
    io_s: float | None
    high_s: float | None = Field(description="upper end of the interval, null without a signature")


class CheckAnswer(JudgedAnswer):
    """The judged budgets (`items`), their findings, and the predicted times of each program."""

    programs: list[Total]


class Check(AssistantTool[CheckGiven]):
    """Runs `olp check` without its cache, because a cache would write into the user's folder."""

    title: ClassVar[str] = "Are the cycle-time budgets held?"
    description: ClassVar[str] = (
        "Holds robot programs against the cycle-time budgets that olp.toml files beside them state: "
        "predicted seconds against limit_s, each held, warned, failed or unknown, with the lines that cost "
        "most."
    )
    given = CheckGiven
    answer = CheckAnswer

    def ask(self, given: CheckGiven, call: ToolCall) -> dict[str, Any]:
        words = list(given.words(call.folder))
        if given.budgets is not None:
            words.append(f"--budgets={call.folder.inside(given.budgets)}")
        jobs = given.programs(call.folder)
        ran = call.run("check", "--format=json", "--no-cache", "--workers=1", *words, "--", *jobs)
        return {**json.loads(ran.printed), "exit_status": ran.status, "told": ran.told}
