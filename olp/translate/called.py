"""What people call things that the neutral program has names for: kinds of statements, speeds, blends, signals."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Final

from olp.expression import Store
from olp.moves import AccelerationUnit, BlendKind, SpeedUnit

# By `kind_of` a statement; 0 and more of them read "3 × joint move".
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
    "analog-in": "analog input",
    "analog-out": "analog output",
    "robot-in": "robot input",
    "robot-out": "robot output",
    "tool-in": "tool input",
    "tool-out": "tool output",
    "configurable-in": "configurable input",
    "configurable-out": "configurable output",
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


def signal(bus: str) -> str:
    """What people call a kind of signal."""
    return SIGNALS.get(bus, f"{bus} signal")


def language(vendor: str) -> str:
    """How people call a vendor's language: INFORM, TP."""
    from olp.vendors.vendor import find_vendor

    return find_vendor(vendor).title.split()[-1]
