"""`olp time JOB --explain LINE`: why one line takes its time."""

from __future__ import annotations

from typing import Any, ClassVar

from pydantic import Field

from olp.servers.mcp.tool import AssistantTool, Timed, ToolAnswer, ToolCall


class ExplainGiven(Timed):
    """The program, and the line of it to explain."""

    job: str = Field(max_length=1024, description="the program, a path below the server's folder")
    line: int = Field(ge=1, le=10_000_000, description="its line, counted from 1 as in an editor")
    called: str = Field(
        "", max_length=100, description="the name of a called job, when the line stands in that one"
    )


class ExplainAnswer(ToolAnswer):
    """The explanation as text."""

    text: str = Field(
        description="phases of the move in s, mm and mm/s, what limits each, the load of the axes, what would help"
    )


class Explain(AssistantTool[ExplainGiven]):
    """Runs `olp time JOB --explain LINE` and returns the text that the command line prints."""

    title: ClassVar[str] = "Why one line takes its time"
    description: ClassVar[str] = (
        "Explains the time of one move of a robot program: its phases (accelerate, cruise, brake) with "
        "their limits, how it blends with its neighbours, the load of each axis, and what twice the speed "
        "or acceleration would save."
    )
    given = ExplainGiven
    answer = ExplainAnswer

    def ask(self, given: ExplainGiven, call: ToolCall) -> dict[str, Any]:
        from olp.languages.vendor import vendor_suffixes

        line = f"{given.called}:{given.line}" if given.called else str(given.line)
        (job,) = call.folder.programs([given.job], vendor_suffixes())
        ran = call.run("time", f"--explain={line}", *given.words(call.folder), "--", job)
        return {"exit_status": ran.status, "told": ran.told, "text": ran.printed.decode(errors="replace")}
