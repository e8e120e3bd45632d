"""The run in RoboDK's tree: frames, tools, targets, one program. RoboDK's units: mm, deg, ms."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from robodk.robolink import INSTRUCTION_COMMENT
from robodk.robomath import Mat

from olp.ir.program import Path
from olp.robots.geometry import rotation_from_quaternion
from olp_station.steps import Floats, Motion, Run

_MM, _DEG = 1e3, 180 / math.pi


class Station:
    """What has been made so far."""

    def __init__(self, link: Any, robot: Any, run: Run) -> None:
        self.link, self.robot, self.run = link, robot, run
        self.base = robot.Parent()
        self.program = link.AddProgram(run.name, robot)
        self.items: dict[tuple[str, str], Any] = {}
        self.targets: dict[tuple[Any, ...], Any] = {}
        self.now = {"frame": "?", "tool": "?"}

    def system(self, kind: str, name: str) -> Any:
        """The frame or tool of that name, made when it is first asked for; "": the robot's base, or its bare flange."""
        key = (kind, name)
        if key not in self.items:
            value = matrix(*self.run.systems.get(key, (np.zeros(3), np.array([1.0, 0, 0, 0]))))
            if kind == "tool":
                self.items[key] = self.robot.AddTool(value, name or "flange")
            elif not name:
                self.items[key] = self.base
            else:
                self.items[key] = self.link.AddFrame(name, self.base)
                self.items[key].setPose(value)
        return self.items[key]

    def use(self, motion: Motion) -> None:
        """The instructions for frame and tool, where they change."""
        for kind, name in (("frame", motion.frame), ("tool", motion.tool)):
            if self.now[kind] != name:
                item = self.system(kind, name)
                (self.program.setPoseFrame if kind == "frame" else self.program.setPoseTool)(item)
                self.now[kind] = name

    def target(self, name: str, motion: Motion, pose: tuple[Floats, Floats], axes: Floats | None) -> Any:
        """A target in the move's frame; the same place is the same target."""
        by_joints = motion.path is Path.JOINT and axes is not None and bool(np.isfinite(axes).all())
        key = (
            motion.frame,
            by_joints,
            *np.round([*pose[0], *pose[1]], 7),
            *(np.round(axes, 7) if by_joints else ()),
        )
        if key not in self.targets:
            made = self.link.AddTarget(name, self.system("frame", motion.frame), self.robot)
            made.setAsJointTarget() if by_joints else made.setAsCartesianTarget()
            frame = self.run.systems.get(("frame", motion.frame))
            inside = matrix(*pose) if frame is None else matrix(*frame).invH() * matrix(*pose)
            made.setPose(inside)
            if axes is not None and np.isfinite(axes).all():
                made.setJoints([float(a) * _DEG for a in axes])
            self.targets[key] = made
        return self.targets[key]

    def move(self, name: str, motion: Motion, rounding: bool) -> None:
        """Speed, acceleration and rounding of this one move, then the move."""
        self.use(motion)
        if math.isfinite(motion.speed):
            if motion.path is Path.JOINT:
                self.program.setSpeed(-1, motion.speed * _DEG, -1, motion.acceleration * _DEG)
            else:
                self.program.setSpeed(motion.speed * _MM, -1, motion.acceleration * _MM, -1)
        if rounding:
            self.program.setRounding(motion.radius * _MM if motion.radius > 0 else -1)
        end = self.target(name, motion, motion.pose, motion.axes)
        if motion.path is Path.JOINT:
            self.program.MoveJ(end)
        elif motion.path is Path.CIRCULAR and motion.via is not None and motion.length > 0:
            self.program.MoveC(self.target(f"{name} via", motion, motion.via, None), end)
        else:
            self.program.MoveL(end)


def build(link: Any, robot: Any, run: Run, rounding: bool = False) -> str:
    """Makes the items; a sentence about them. The robot is put where the program starts."""
    link.Render(False)
    station = Station(link, robot, run)
    program = station.program
    program.ShowInstructions(False)
    if len(run.start) and np.isfinite(run.start).all():
        robot.setJoints([float(a) * _DEG for a in run.start])
    if not rounding:
        program.setRounding(-1)
    for step in run.steps:
        takes = f": {step.duration:.3f} s" if step.duration else ""
        program.RunInstruction(f"{step.line} {step.statement}{takes}"[:200], INSTRUCTION_COMMENT)
        if step.motion is not None:
            station.move(f"line {step.line}", step.motion, rounding)
        elif step.output is not None:
            program.setDO(step.output[0], int(step.output[1]))
        if step.motion is None and step.duration:
            program.Pause(step.duration * 1e3)
    program.setParam("olp", _times(run))
    program.ShowInstructions(True)
    link.Render(True)
    made = sum(kind == "frame" and bool(name) for kind, name in station.items)
    tools = sum(kind == "tool" and bool(name) for kind, name in station.items)
    return (
        f"{run.name}: {len(station.targets)} targets, {made} frames, {tools} tools, {len(run.steps)} steps, "
        f"predicted {run.total:.3f} s ({run.robot})"
    )


def _times(run: Run) -> dict[str, Any]:
    """What the program item keeps: seconds per step, and what was taken for granted."""
    rows = [[step.line, round(step.duration, 6)] for step in run.steps]
    return {
        "robot": run.robot,
        "total_s": round(run.total, 6),
        "line_s": rows,
        "assumed": list(run.assumptions),
    }


def matrix(position: Floats, quaternion: Floats) -> Mat:
    """RoboDK's pose [mm]."""
    turn = rotation_from_quaternion(quaternion)
    rows = [[*map(float, turn[i]), float(position[i]) * _MM] for i in range(3)]
    return Mat([*rows, [0.0, 0.0, 0.0, 1.0]])
