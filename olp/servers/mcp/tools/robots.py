"""`olp robots`: the library of robots."""

from __future__ import annotations

import json
from typing import Any, ClassVar

from pydantic import Field

from olp.robots import EXAMPLE_ROBOT
from olp.servers.mcp.tool import AnswerRow, AssistantTool, ToolAnswer, ToolArguments, ToolCall, robot_word


class RobotsGiven(ToolArguments):
    """The robots to list."""

    robots: list[str] = Field(
        [], max_length=100, description=f"names such as {EXAMPLE_ROBOT} or gp25, or robot files; default: all"
    )


class RobotRow(AnswerRow):
    """The data of one robot; null where a value is not known."""

    robot: str
    maker: str
    model: str
    kind: str
    payload_kg: float | None
    has_geometry: bool
    pose_verified: bool = Field(description="poses computed from pulses agree with a controller's own")
    linear_acceleration_mm_s2: float | None
    axes: list[dict[str, Any]] = Field(
        description="per axis: limits in deg or mm, speed per s, acceleration per s²"
    )


class RobotsAnswer(ToolAnswer):
    """One entry per robot."""

    robots: list[RobotRow]


class Robots(AssistantTool[RobotsGiven]):
    """Runs `olp robots --format json`."""

    title: ClassVar[str] = "Known robots"
    description: ClassVar[str] = (
        "Lists the robots that olp knows, with their axes, limits and speeds, and how far each can be "
        "trusted. The names are what the other tools take as robot."
    )
    given = RobotsGiven
    answer = RobotsAnswer

    def ask(self, given: RobotsGiven, call: ToolCall) -> dict[str, Any]:
        names = [robot_word(robot, call.folder) for robot in given.robots]
        ran = call.run("robots", "--format=json", "--", *names)
        return {"exit_status": ran.status, "told": ran.told, "robots": json.loads(ran.printed)}
