"""What people call the things of the neutral program: statements, speeds, blends, signals, functions, values."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final

from olp.ir.expressions import Number, Signal, Store, Text
from olp.ir.program import AccelerationUnit, BlendKind, Move, Path, SpeedUnit, Statement

# The comment above the statements that set the target's tools and frames.
SYSTEMS_ARE_SET: Final = "tools and frames of the translated program"

# By kind: the statement's class, a move by its path.
STATEMENTS: Final[Mapping[str, str]] = {
    "Move joint": "joint move",
    "Move linear": "linear move",
    "Move circular": "circular move",
    "Move spline": "spline move",
    "Reference": "reference point",
    "SetSpeed": "speed setting",
    "Assign": "assignment",
    "Update": "increment, sum",
    "Clear": "clearing of variables",
    "SetOutput": "output",
    "PulseOutput": "output pulse",
    "ReadInput": "input into variable",
    "Dwell": "wait for a time",
    "Wait": "wait for a condition",
    "Label": "label",
    "Jump": "jump",
    "Call": "call",
    "Return": "return",
    "If": "IF",
    "ElseIf": "ELSEIF",
    "Else": "ELSE",
    "EndIf": "end of IF",
    "While": "WHILE",
    "EndWhile": "end of WHILE",
    "For": "FOR",
    "Next": "end of FOR",
    "Switch": "SWITCH",
    "Case": "CASE",
    "Default": "DEFAULT",
    "EndSwitch": "end of SWITCH",
    "Pause": "pause",
    "StartTask": "start of a task",
    "WaitTask": "wait for a task",
    "Synchronise": "synchronising tasks",
    "Repeat": "REPEAT",
    "Until": "UNTIL",
    "Break": "exit from a loop",
    "Continue": "next round of a loop",
    "Declare": "declaration",
    "SetAcceleration": "acceleration setting",
    "SetBlend": "blend setting",
    "SetTool": "choice of tool",
    "SetFrame": "choice of frame",
    "SetOverride": "override",
    "ObeyFlags": "arm flags on or off",
    "ShiftOn": "shift on",
    "ShiftOff": "shift off",
    "DefineFrame": "frame from points",
    "ExternalTool": "tool beside the robot",
    "Message": "message",
    "Process": "process instruction",
    "Comment": "comment",
    "Begin": "begin",
    "End": "end",
    "Disabled": "disabled line",
    "Opaque": "unknown statement",
    "program": "program",
}
SPEEDS: Final[Mapping[SpeedUnit, str]] = {
    SpeedUnit.FRACTION: "a share of full speed [%]",
    SpeedUnit.TRAVEL: "a speed of the tool [mm/s]",
    SpeedUnit.TURN: "a turning speed of the tool [deg/s]",
    SpeedUnit.AXIS: "a speed of the leading axis [deg/s]",
    SpeedUnit.TIME: "a duration of the move [s]",
}
ACCELERATIONS: Final[Mapping[AccelerationUnit, str]] = {
    AccelerationUnit.FRACTION: "a share of the rated acceleration [%]",
    AccelerationUnit.TRAVEL: "an acceleration of the tool [mm/s²]",
    AccelerationUnit.AXIS: "an acceleration of the leading axis [deg/s²]",
}
BLENDS: Final[Mapping[BlendKind, str]] = {
    BlendKind.LEVEL: "a position level",
    BlendKind.CONTINUOUS: "a blend without a size",
    BlendKind.RADIUS: "a radius [mm]",
    BlendKind.SHARE: "a share of the way [%]",
    BlendKind.SPEED: "a share of the speed [%]",
    BlendKind.TURN: "an angle of turning [deg]",
}
SIGNALS: Final[Mapping[str, str]] = {
    "in": "digital input",
    "out": "digital output",
    "in-group": "group input",
    "out-group": "group output",
    "in-half-group": "half a group input",
    "out-half-group": "half a group output",
    "analog-in": "analog input",
    "analog-out": "analog output",
    "robot-in": "robot input",
    "robot-out": "robot output",
    "tool-in": "tool input",
    "tool-out": "tool output",
    "tool-analog-in": "analog tool input",
    "configurable-in": "configurable input",
    "configurable-out": "configurable output",
    "panel-in": "operator panel input",
    "panel-out": "operator panel output",
    "system-in": "system input",
    "system-out": "system output",
    "weld-in": "welding input",
    "weld-out": "welding output",
    "weld-stick-in": "wire stick input",
    "weld-stick-out": "wire stick output",
    "flag": "flag",
    "timer-flag": "timer flag",
    "cyclic-flag": "cyclic flag",
    "marker": "marker",
    "register": "register",
}
FUNCTIONS: Final[Mapping[str, str]] = {
    "bit-not": "inverting the bits of a number",
    "forward": "the pose of joint values",
    "given": "asking whether an argument is given",
    "joints": "joint values that are computed",
    "inverse": "the joint values of a pose",
    "joined-text": "joining texts",
    "length-of-text": "the length of a text",
    "log": "a logarithm",
    "part-of-text": "a part of a text",
    "position-in-text": "the place of one text in another",
    "match-in-text": "the place of one text in another from a character on",
    "find-in-text": "the place of one text in another from a character on",
    "same-text": "comparing texts",
    "signal-number": "the number of a signal",
    "size-of-array": "the size of an array that nothing at hand tells",
    "text-of-value": "a number as a text",
    "value-of-text": "a text as a number",
    "pose-add": "the sum of two poses",
    "pose-subtract": "the difference of two poses",
    "pose-angles": "a pose whose angles are computed",
    "pose-distance": "the distance of two poses",
    "pose-element": "an element of a pose by a computed number",
    "pose-interpolate": "a pose between two poses",
    "pose-inverse": "the inverse of a pose",
    "pose-offset": "a pose with an offset",
    "pose-product": "a pose seen in another pose that is computed",
    "pose-quaternion": "a pose whose quaternion is computed",
    "pose-relative-tool": "a pose with an offset along the tool",
    "pose-vector": "a pose whose turning vector is computed",
    "random": "a random number",
    "taught": "a taught point by a computed number",
    "timer": "a clock",
    "timer-running": "asking whether a clock runs",
    "step-position": "the position of another step",
    "tool-data": "the values of a tool",
}
VALUES: Final[Mapping[str, str]] = {
    "current-frame": "the frame in use",
    "current-joints": "the axis values of the current position",
    "current-pose": "the current position",
    "manual-full": "whether the mode is manual at full speed",
    "manual-reduced": "whether the mode is manual at reduced speed",
    "position-pose": "the pose of a position",
    "returned": "the value that a call returned",
    "timed-out": "asking whether a wait has timed out",
    "timer": "a clock",
    "timer-running": "asking whether a clock runs",
    "weld-speed": "the speed that the welding equipment sets",
}
# What a program asks of the controller that runs it
STATES: Final[Mapping[str, str]] = {
    "at-home": "whether the arm stands at home",
    "automatic": "whether the mode is automatic",
    "faulted": "whether an error stands",
    "guard-closed": "whether the guard is closed",
    "may-move": "whether the arm may move",
    "motors-on": "whether the motors are on",
    "no-emergency-stop": "whether no emergency stop stands",
    "running": "whether a program runs",
}
SYSTEMS: Final[Mapping[str, str]] = {
    "base": "the base",
    "robot": "the robot's own frame",
    "user": "a frame by its number",
    "tool": "a tool by its number",
    "master-tool": "the frame of another robot's tool",
    "own": "the value's own frame",
}
OPERATORS: Final[Mapping[str, str]] = {
    "and": "AND of the bits of numbers",
    "or": "OR of the bits of numbers",
    "xor": "exclusive OR of the bits of numbers",
    "not": "NOT of a number",
    "mod": "the remainder of a division",
    "div": "a division without its remainder",
}
STORES: Final[Mapping[Store, str]] = {
    Store.BYTE: "byte variable",
    Store.INTEGER: "integer variable",
    Store.DOUBLE: "double integer variable",
    Store.REAL: "real variable",
    Store.STRING: "text variable",
    Store.ROBOT: "position variable",
    Store.BASE: "position variable of a track",
    Store.STATION: "position variable of a station",
    Store.SYSTEM: "position variable of all groups",
}


_MOVES: Final = {path: f"Move {path.value}" for path in Path}


def kind_of(statement: Statement) -> str:
    """A kind of statement: its class in the neutral program, a move by its path."""
    if type(statement) is Move:
        return _MOVES[statement.path]
    return type(statement).__name__


def statement(it: Statement) -> str:
    """What people call a statement."""
    return STATEMENTS[kind_of(it)]


_MAPPED = "map it under [signals] in the mapping file"


def signal(e: Signal) -> tuple[str, str]:
    """What people call a signal that a language does not have, and what to do: `CannotSayError(*signal(e))`."""
    if isinstance(e.index, Number):
        number = str(int(e.index.value))
    else:
        number = e.index.value if isinstance(e.index, Text) else ""
    known = SIGNALS.get(e.bus, e.bus)
    if e.bus.endswith("group"):
        return f"the {known} {number}".rstrip(), "set or read its signals one by one"
    if not number:
        return f"the {known} with a computed number", _MAPPED
    kind = "in" if e.bus.endswith("in") else "out"
    return f"the {known} {number}", f'{_MAPPED}, as in "{e.bus} {number}" = "{kind} 12"'


def function(name: str) -> str:
    """What people call a function."""
    return FUNCTIONS.get(name, f"the function {name}")


def value(name: str) -> str:
    """What people call a value that only the controller knows."""
    return VALUES.get(name) or STATES.get(name, f"the controller's value {name}")


def state_variable(name: str) -> str:
    """The variable that tells what a program asks of the controller, where a language has no word for it."""
    return name.replace("-", "_")


def operation(operator: str) -> str:
    """What people call an operator."""
    return OPERATORS.get(operator, f"the operation {operator}")
