"""`olp diagnose`: the physics that a simulation left out."""

from __future__ import annotations

import json
from typing import Any, ClassVar

from pydantic import Field

from olp.servers.mcp.tool import AnswerRow, AssistantTool, ToolAnswer, ToolArguments, ToolCall, robot_word


class DiagnoseGiven(ToolArguments):
    """The recording to diagnose, and optionally the program and robot it belongs to."""

    recording: str = Field(
        max_length=1024,
        description="a folder with moves.csv or log.csv, or a file of moves; below the server's folder",
    )
    job: str | None = Field(
        None, max_length=1024, description="the program that ran; default: recording.toml's"
    )
    robot: str | None = Field(None, max_length=200, description="the robot, instead of the recording's")


class OmittedEffect(AnswerRow):
    """One physical effect that the simulation left out, with its parameters and the evidence for it."""

    term: str = Field(description="a name of the physics, such as jerk or settling")
    says: str
    parameters: dict[str, Any] = Field(description="with their units and intervals")
    evidence: dict[str, Any] = Field(description="errors in s on moves that were held out, before and after")


class DiagnoseAnswer(ToolAnswer):
    """The diagnosis in the schema olp.diagnosis/1: a verdict, the errors, and the effects that were left out."""

    verdict: str = Field(description="explained, partly explained, nothing to explain, or cannot tell")
    data: dict[str, Any]
    mismatch: dict[str, Any] = Field(description="of simulated against recorded times [s]")
    findings: list[OmittedEffect]
    notes: list[str]


class Diagnose(AssistantTool[DiagnoseGiven]):
    """Runs `olp diagnose RECORDING --json -`."""

    title: ClassVar[str] = "What does a simulation leave out?"
    description: ClassVar[str] = (
        "Compares a simulator's times of robot moves with recorded ones and names the physics that the "
        "simulation left out (acceleration, jerk, settling, dispatch …) with sizes, and the proof on moves "
        "that were held out. Takes some seconds."
    )
    given = DiagnoseGiven
    answer = DiagnoseAnswer

    def ask(self, given: DiagnoseGiven, call: ToolCall) -> dict[str, Any]:
        words = [f"--job={call.folder.inside(given.job)}"] if given.job is not None else []
        if given.robot is not None:
            words.append(f"--robot={robot_word(given.robot, call.folder)}")
        ran = call.run("diagnose", "--json=-", *words, "--", call.folder.inside(given.recording))
        return {**json.loads(ran.printed), "exit_status": ran.status, "told": ran.told}
