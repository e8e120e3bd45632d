"""`olp report`: a page that people look at."""

from __future__ import annotations

from typing import Any, ClassVar

from pydantic import Field

from olp.servers.mcp.tool import AssistantTool, ListedPrograms, ToolAnswer, ToolCall


class ReportGiven(ListedPrograms):
    """The programs to report on, and the file for the HTML page."""

    output: str = Field(max_length=1024, description="the file to write, such as report.html")
    force: bool = Field(False, description="write over the page that is there; its totals make the trend")
    title: str = Field("", max_length=200, description="heading of the page")


class ReportAnswer(ToolAnswer):
    """The path of the page that was written."""

    file: str


class ReportTool(AssistantTool[ReportGiven]):
    """Runs `olp report`. Writes one file, so the tool is only there on a server with --write."""

    title: ClassVar[str] = "A page with Gantt, speed and path"
    description: ClassVar[str] = (
        "Writes one HTML page about robot programs for people: Gantt, speed over time, path in 3D, text "
        "with times."
    )
    writes: ClassVar[bool] = True
    given = ReportGiven
    answer = ReportAnswer

    def ask(self, given: ReportGiven, call: ToolCall) -> dict[str, Any]:
        target = call.folder.new(given.output, (".html", ".htm"), force=given.force)
        jobs = given.programs(call.folder)
        words = list(given.words(call.folder))
        ran = call.run("report", f"--output={target}", f"--title={given.title}", *words, "--", *jobs)
        return {"exit_status": ran.status, "told": ran.told, "file": target}
