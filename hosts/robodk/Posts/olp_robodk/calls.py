"""RoboDK's calls as a program of olp: one line per call, one statement per line, SI inside.

RoboDK speaks in mm, mm/s, mm/s², deg, deg/s, deg/s² and ms; poses are 4x4 matrices in mm, of the tool in the active
frame. Joint angles are the controller's own, as RoboDK's robots have them.
"""

from __future__ import annotations

import math
import re
from dataclasses import replace
from typing import Any

import numpy as np

from olp.core.diagnostic import Diagnostic, Span, error, warning
from olp.core.source import Source
from olp.ir.expressions import FrameRef, Number, PositionLiteral, Quantity, Signal, SignalState, Text, Unary
from olp.ir.points import PointTable
from olp.ir.program import (
    Acceleration,
    AccelerationUnit,
    Assign,
    Blend,
    BlendKind,
    Call,
    Comment,
    Dwell,
    Message,
    Move,
    Path,
    Pause,
    Program,
    Routine,
    SetFrame,
    SetOutput,
    SetTool,
    Speed,
    SpeedUnit,
    Wait,
)
from olp.robots.geometry import angles_from_rotation

_MM, _DEG = 1e-3, math.pi / 180
# What is written, and told, where RoboDK sets no speed: slow.
_SPEED, _AXIS_SPEED = 0.1, 10 * _DEG  # [m/s], [rad/s]
CODE = "OLPCODE"  # a comment that stands for a line of the user's own code, word for word
_NUMBERED = re.compile(r"(?:DO|DI|OUT|IN|\$OUT|\$IN|OT#|IN#|)[\[(]?\s*(\d+)(?:\.0*)?\s*[\])]?", re.I)
_CALL = re.compile(r"\s*([A-Za-z_]\w*)\s*(?:\(\s*\))?\s*;?\s*")


class Calls:
    """What RoboDK has said so far."""

    def __init__(self) -> None:
        self.rated = 0.0  # [rad/s] of the axes; above nothing, joint speeds are shares of it
        self.lines: list[str] = []
        self.routines: dict[str, list[Any]] = {}
        self.first: dict[str, int] = {}
        self.body: list[Any] = []
        self.problems: list[Diagnostic] = []
        self.codes: list[str] = []
        self.numbered: set[int] = set()  # lines that give a numbered tool or frame its value
        # None until RoboDK says one.
        self.speed: float | None = None  # [m/s]
        self.acceleration: float | None = None  # [m/s²]
        self.axis_speed: float | None = None  # [rad/s]
        self.axis_acceleration: float | None = None  # [rad/s²]
        self.arm_axes = 0  # further axes are external ones; 0: not known
        self.blend = 0.0  # [m]
        self.frame: Any = FrameRef("base")
        self.tool: Any = FrameRef("tool", Number(0))

    def said(self, name: str, *arguments: object) -> int:
        """Takes a call down; its line, counted from 1."""
        words = ", ".join(_spelled(a) for a in arguments)
        self.lines.append(f"{name}({words})")
        return len(self.lines)

    def begin(self, name: str) -> None:
        """A routine of that name follows."""
        line = self.said("ProgStart", name)
        self.body = self.routines.setdefault(name, [])
        self.first.setdefault(name, line)
        # Each routine is written for itself: nothing that holds is taken for granted.
        if not isinstance(self.tool, FrameRef):
            self.body.append(SetTool(line, self.tool))
        if not isinstance(self.frame, FrameRef):
            self.body.append(SetFrame(line, self.frame))

    def move(self, path: Path, pose: Any, joints: Any, via: Any = None) -> None:
        """A move to a pose (None: to joint angles in deg)."""
        line = self.said(f"Move{path.value[0].upper()}", *(p for p in (via, pose, joints) if p is not None))
        target = self.target(line, path, pose, joints)
        if target is None:
            return
        self.body.append(
            Move(
                line,
                path,
                (target,),
                self._speed(line, path),
                Blend(BlendKind.RADIUS, _quantity(max(0.0, self.blend))),
                rate=self._rate(path),
                via=None if via is None else position(via),
            )
        )

    def target(self, line: int, path: Path, pose: Any, joints: Any) -> PositionLiteral | None:
        """Angles for joint moves, which say the arm's posture too; poses for the others."""
        angles = numbers(joints)
        if self.arm_axes and len(angles) > self.arm_axes:
            self.wrong(
                line, "external axes are not written", "leave them where they are, or use RoboDK's own post"
            )
            return None
        if path is Path.JOINT and angles:
            return PositionLiteral("joint", tuple(a * _DEG for a in angles))
        if pose is None:
            self.wrong(line, "a linear or circular move needs a pose", "make the target a Cartesian one")
            return None
        return position(pose)

    def _speed(self, line: int, path: Path) -> Speed:
        if path is not Path.JOINT:
            if self.speed is None:
                self.speed = _SPEED
                self.warn(
                    line, f"no speed is set: {_SPEED / _MM:g} mm/s is written", "set the speed in RoboDK"
                )
            return Speed(SpeedUnit.TRAVEL, _quantity(self.speed))
        if self.axis_speed is None:
            self.axis_speed = _AXIS_SPEED
            self.warn(
                line, f"no joint speed is set: {_AXIS_SPEED / _DEG:g} deg/s is written", "set it in RoboDK"
            )
        if self.rated > 0:
            return Speed(SpeedUnit.FRACTION, _quantity(min(1.0, self.axis_speed / self.rated)))
        return Speed(SpeedUnit.AXIS, _quantity(self.axis_speed))

    def _rate(self, path: Path) -> Acceleration | None:
        joint = path is Path.JOINT
        value = self.axis_acceleration if joint else self.acceleration
        if value is None or (joint and self.rated > 0):  # a share of what nobody knows
            return None
        return Acceleration(AccelerationUnit.AXIS if joint else AccelerationUnit.TRAVEL, _quantity(value))

    def set_system(self, kind: str, pose: Any, number: object, name: object) -> None:
        """The tool ("tool") on the flange or the frame ("user") in the robot's base holds from here on.

        With a number it is the controller's of that number, and the program gives it this value.
        """
        call, make = ("setTool", SetTool) if kind == "tool" else ("setFrame", SetFrame)
        line = self.said(call, pose, number, name)
        value: Any = position(pose)
        if isinstance(number, int | float) and number > 0:
            numbered = FrameRef(kind, Number(int(number)))
            self.body.append(Assign(line, numbered, value))
            self.numbered.add(line)
            value = numbered
        setattr(self, "tool" if kind == "tool" else "frame", value)
        self.body.append(make(line, value))

    def pause(self, time_ms: float) -> None:
        """Nothing or less: until the operator goes on."""
        line = self.said("Pause", time_ms)
        if time_ms <= 0:
            self.body.append(Pause(line))
        else:
            self.body.append(Dwell(line, _quantity(time_ms / 1000)))

    def output(self, call: str, name: object, value: object) -> None:
        """A digital or analog output."""
        line = self.said(call, name, value)
        bus = "out" if call == "setDO" else "analog-out"
        level = SignalState(is_on(value)) if call == "setDO" else Number(_number(value))
        self.body.append(SetOutput(line, Signal(bus, _index(name)), level))

    def wait(self, name: object, value: object, timeout_ms: float) -> None:
        """For a digital input; a timeout of less than nothing is none."""
        line = self.said("waitDI", name, value, timeout_ms)
        signal = Signal("in", _index(name))
        condition = signal if is_on(value) else Unary("not", signal)
        timeout = None if timeout_ms < 0 else _quantity(timeout_ms / 1000)
        self.body.append(Wait(line, condition, timeout))

    def code(self, text: str, is_call: bool) -> None:
        """A call of a program, or code of the controller's own language, which is kept word for word."""
        line = self.said("RunCode", text, is_call)
        called = _CALL.fullmatch(text)
        if is_call and called:
            self.body.append(Call(line, called[1]))
            return
        if is_call:
            self.warn(line, f"this call is written word for word: {text!r}", "check it in the program")
        self.codes.append(text)
        self.body.append(Comment(line, f"{CODE}{len(self.codes) - 1}"))

    def message(self, text: str, is_comment: bool) -> None:
        """For the operator, or for who reads the program."""
        line = self.said("RunMessage", text, is_comment)
        for part in text.splitlines() or [""]:
            self.body.append(Comment(line, part) if is_comment else Message(line, Text(part)))

    def wrong(self, line: int, says: str, help: str) -> None:
        """A call that cannot be written in any language."""
        self.problems.append(error("X011", says, Span(line), source_line=self.lines[line - 1], help=help))

    def warn(self, line: int, says: str, help: str) -> None:
        """A call that is written, but should be looked at."""
        self.problems.append(warning("X011", says, Span(line), source_line=self.lines[line - 1], help=help))

    def program(self, path: str) -> Program:
        """All of it. `path`: what it is called in messages; its lines are RoboDK's calls."""
        text = "\n".join(self.lines)
        called = {name.casefold(): name for name in self.routines}
        routines = tuple(
            Routine(name, self.first[name], tuple(_respelled(s, called) for s in body), PointTable())
            for name, body in self.routines.items()
        )
        source = Source(path, text.encode(), "utf-8", tuple(self.lines))
        return Program("robodk", source, routines, main=next(iter(self.routines), ""))


def position(pose: Any) -> PositionLiteral:
    """A 4x4 matrix [mm]."""
    matrix = np.array([[float(pose[i, j]) for j in range(4)] for i in range(3)])
    angles = angles_from_rotation(matrix[:, :3])
    return PositionLiteral("pose", (*(matrix[:, 3] * _MM).tolist(), *map(float, angles)))


def numbers(joints: Any) -> list[float]:
    """Joint values [deg] of a list or of RoboDK's column matrix; [] for none."""
    if joints is None:
        return []
    if not isinstance(joints, list | tuple):
        joints = joints.tolist() if hasattr(joints, "tolist") else list(joints)
    return [float(value[0] if isinstance(value, list) else value) for value in joints]


def is_on(value: object) -> bool:
    """What RoboDK says of a digital signal: 1, 1.0, True, "ON" …"""
    return str(value).strip().lower() not in ("0", "0.0", "false", "off", "low", "")


def _quantity(value: float) -> Quantity:
    return Quantity(Number(value), 1.0)


def _number(value: object) -> float:
    try:
        return float(str(value))
    except ValueError:
        return 0.0


def _index(name: object) -> Number | Text:
    """3, "3" and what RoboDK's users write for it, "DO[3]" or "$OUT[3]", are number 3; the rest are names."""
    numbered = _NUMBERED.fullmatch(str(name).strip())
    return Number(int(numbered[1])) if numbered else Text(str(name).strip())


def _respelled(statement: Any, called: dict[str, str]) -> Any:
    if isinstance(statement, Call):
        return replace(statement, routine=called.get(statement.routine.casefold(), statement.routine))
    return statement


def _spelled(value: object) -> str:
    if value is None or isinstance(value, str | int | bool):
        return repr(value)
    if isinstance(value, float):
        return f"{value:g}"
    if isinstance(value, list | tuple) or getattr(value, "size", lambda: (0, 0))() != (4, 4):
        return "[" + ", ".join(f"{v:.3f}" for v in numbers(value)) + "]"
    return "Pose(" + ", ".join(f"{v:.3f}" for v in _angles(value)) + ")"


def _angles(pose: Any) -> list[float]:
    values = position(pose).values
    return [v / _MM for v in values[:3]] + [v / _DEG for v in values[3:]]
