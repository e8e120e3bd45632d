"""`olp annotate`: predicted times as comments in a program."""

from __future__ import annotations

from typing import Any, ClassVar

from pydantic import Field

from olp.servers.mcp.tool import AssistantTool, Timed, ToolAnswer, ToolCall


class AnnotateGiven(Timed):
    """The program to annotate, and the file for the annotated copy."""

    job: str = Field(max_length=1024, description="the program, a path below the server's folder")
    output: str = Field(max_length=1024, description="the file to write; never the program itself")
    force: bool = Field(False, description="write over another program that is there")
    remove: bool = Field(False, description="take the annotations out again instead")


class AnnotateAnswer(ToolAnswer):
    """The path of the file that was written."""

    file: str


class Annotate(AssistantTool[AnnotateGiven]):
    """Runs `olp annotate`. Writes one file, so the tool is only there on a server with --write."""

    title: ClassVar[str] = "Write predicted times into a program"
    description: ClassVar[str] = (
        "Writes a copy of a robot program with the predicted time of each line as a comment, or one without"
        " these comments. All else stays byte for byte."
    )
    writes: ClassVar[bool] = True
    given = AnnotateGiven
    answer = AnnotateAnswer

    def ask(self, given: AnnotateGiven, call: ToolCall) -> dict[str, Any]:
        from olp.languages.vendor import vendor_suffixes

        (job,) = call.folder.programs([given.job], vendor_suffixes())
        target = call.folder.new(given.output, vendor_suffixes(), force=given.force)
        words = [*given.words(call.folder), *(["--remove"] if given.remove else [])]
        ran = call.run("annotate", f"--output={target}", *words, "--", job)
        return {"exit_status": ran.status, "told": ran.told, "file": target}
