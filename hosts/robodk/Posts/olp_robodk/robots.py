"""Which robot of olp's library RoboDK means."""

from __future__ import annotations

import re

from olp.robots.robot import Robot, load_robot, robot_names


def robot_named(chosen: str, name: str) -> Robot | None:
    """`chosen` as olp calls it; else the one whose model is in RoboDK's name ("Motoman GP25"), None without one.

    Raises OlpError for a chosen robot that there is none of.
    """
    if chosen:
        return load_robot(chosen)
    words = _letters(name)
    known = [robot for robot in robot_names() if words.endswith(_letters(robot.rpartition("/")[2]))]
    best = max(known, key=len, default="")
    return load_robot(best) if best and _letters(name) else None


def _letters(text: str) -> str:
    return re.sub(r"[^a-z0-9]", "", text.lower())
