"""One small program for every kind of statement, to find out what a language makes of it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from functools import lru_cache
from typing import Any

from olp.core.source import decode
from olp.ir.expressions import (
    Compare,
    FrameRef,
    Named,
    Number,
    PositionLiteral,
    Quantity,
    Signal,
    SignalState,
    Store,
    Text,
    Variable,
)
from olp.ir.points import PointTable
from olp.ir.program import (
    Acceleration,
    AccelerationUnit,
    Assign,
    Begin,
    Blend,
    BlendKind,
    Break,
    Call,
    Case,
    Clear,
    Comment,
    Continue,
    Declare,
    Default,
    DefineFrame,
    Disabled,
    Dwell,
    Else,
    ElseIf,
    End,
    EndIf,
    EndSwitch,
    EndWhile,
    ExternalTool,
    For,
    If,
    Jump,
    Label,
    Message,
    Move,
    Next,
    ObeyFlags,
    Opaque,
    Path,
    Pause,
    Process,
    Program,
    PulseOutput,
    ReadInput,
    Reference,
    Repeat,
    Return,
    Routine,
    SetAcceleration,
    SetBlend,
    SetFrame,
    SetOutput,
    SetOverride,
    SetSpeed,
    SetTool,
    ShiftOff,
    ShiftOn,
    Speed,
    SpeedUnit,
    StartTask,
    Statement,
    Switch,
    Synchronise,
    Until,
    Update,
    Wait,
    WaitTask,
    While,
)
from olp.languages.limits import limits_of, writable
from olp.languages.vendor import find_vendor

Probes = Mapping[str, tuple[Statement, ...]]

_N, _P, _Q = Named("n"), Named("p1"), Named("p2")
_R = Variable(Store.ROBOT, Number(1))
_MORE = Compare(">", _N, Number(0))
_IN, _OUT = Signal("in", Number(2)), Signal("out", Number(3))
_TOOL = PositionLiteral("pose", (0.01, -0.02, 0.2, 0.1, 0.2, 0.3))
_PERCENT, _MM = 0.01, 0.001


def _move(path: Path, **more: Any) -> Move:
    slow = Speed(SpeedUnit.FRACTION, Quantity(Number(40), _PERCENT))
    fast = Speed(SpeedUnit.TRAVEL, Quantity(Number(250), _MM))
    stop = Blend(BlendKind.RADIUS, Quantity(Number(0), _MM))
    joint = path is Path.JOINT
    plain = Move(
        0,
        path,
        (_P,),
        slow if joint else fast,
        stop,
        tool=FrameRef("tool", Number(0)),
        frame=FrameRef("base"),
    )
    return replace(plain, **more)


_START = _move(Path.LINEAR, targets=(_Q,))


_STEP = Assign(0, _N, Number(3))
_SHORT = Dwell(0, Quantity(Number(1), 1.0))
_DOWN = Update(0, "-", _N, Number(1))
_SLOW = Speed(SpeedUnit.TRAVEL, Quantity(Number(100), _MM))
_HALF = Quantity(Number(50), _PERCENT)

_MOVES: Probes = {
    "Move joint": (_move(Path.JOINT),),
    "Move linear": (_move(Path.LINEAR),),
    "Move circular": (_START, _move(Path.CIRCULAR, targets=(Named("p3"),), via=_P)),
    "Move spline": (_START, _move(Path.SPLINE), _move(Path.SPLINE, targets=(Named("p3"),))),
    "SetSpeed": (SetSpeed(0, (_SLOW,)), _move(Path.LINEAR, speed=None)),
    "SetAcceleration": (
        SetAcceleration(0, (Acceleration(AccelerationUnit.FRACTION, _HALF),)),
        _move(Path.LINEAR),
    ),
    "SetBlend": (
        SetBlend(0, (Blend(BlendKind.RADIUS, Quantity(Number(5), _MM)),)),
        _move(Path.LINEAR, blend=Blend(BlendKind.RADIUS)),
    ),
    "SetTool": (SetTool(0, _TOOL), _move(Path.LINEAR, tool=None)),
    "SetFrame": (SetFrame(0, _TOOL), _move(Path.LINEAR, frame=None)),
    "SetOverride": (SetOverride(0, _HALF), _move(Path.LINEAR)),
    "ObeyFlags": (ObeyFlags(0, False), _move(Path.JOINT)),
    "ShiftOn": (ShiftOn(0, _P), _move(Path.LINEAR), ShiftOff(0)),
    "ExternalTool": (ExternalTool(0, Number(1)),),
    "DefineFrame": (DefineFrame(0, FrameRef("user", Number(1)), (_R, _R, _R)), _move(Path.LINEAR)),
    "Reference": (Reference(0, Number(1), (_R,)), _move(Path.LINEAR)),
}
_VALUES: Probes = {
    "Assign": (_STEP,),
    "Update": (Update(0, "+", _N, Number(1)),),
    "Clear": (Clear(0, _N),),
    "SetOutput": (SetOutput(0, _OUT, SignalState(True)),),
    "PulseOutput": (PulseOutput(0, _OUT, Quantity(Number(0.5), 1.0)),),
    "ReadInput": (ReadInput(0, _N, Signal("in-group", Number(1))),),
    "Declare": (Declare(0, "m", "integer", Number(1)), Assign(0, Named("m"), Number(2))),
}
_COURSE: Probes = {
    "Dwell": (Dwell(0, Quantity(Number(0.5), 1.0)),),
    "Wait": (Wait(0, Compare("=", _IN, SignalState(True))),),
    "Call": (Call(0, "OTHER"),),
    "Return": (Return(0),),
    "Pause": (Pause(0),),
    "StartTask": (StartTask(0, "OTHER", "SUB1"),),
    "WaitTask": (StartTask(0, "OTHER", "SUB1"), WaitTask(0, "SUB1")),
    "Synchronise": (Synchronise(0, Number(1)),),
}
_WORDS: Probes = {
    "Message": (Message(0, Text("ready")),),
    "Process": (Process(0, "ARCON"),),
    "Comment": (Comment(0, "text"),),
    "Disabled": (Disabled(0, "MOVE"),),
    "Opaque": (Opaque(0, "TEXT"),),
    "Begin": (Begin(0),),
    "End": (End(0),),
}
_LEFT = (
    While(0, SignalState(True)), _DOWN, If(0, _MORE), Continue(0), EndIf(0), Break(0), EndWhile(0),
)  # fmt: skip
_BRANCH = (If(0, _MORE), _STEP, ElseIf(0, Compare("=", _N, Number(0))), _STEP, Else(0), _STEP, EndIf(0))
# Kinds that stand together only.
_BLOCKS: tuple[tuple[tuple[str, ...], tuple[Statement, ...]], ...] = (
    (("ShiftOff",), _MOVES["ShiftOn"]),
    (("While", "EndWhile"), (While(0, _MORE), _DOWN, EndWhile(0))),
    (("Break", "Continue"), _LEFT),
    (
        ("Switch", "Case", "Default", "EndSwitch"),
        (Switch(0, _N), Case(0, (Number(1),)), _SHORT, Default(0), EndSwitch(0)),
    ),
    (("If", "ElseIf", "Else", "EndIf"), _BRANCH),
    (("Repeat", "Until"), (Repeat(0), _DOWN, Until(0, Compare("<=", _N, Number(0))))),
    (("For", "Next"), (For(0, _N, Number(1), Number(3)), _SHORT, Next(0, _N))),
    (("Label", "Jump"), (Label(0, "again"), _DOWN, Jump(0, "again", _MORE))),
)


@lru_cache
def probes() -> Probes:
    """Kind of statement -> the statements of a program that has one."""
    blocks = {name: statements for names, statements in _BLOCKS for name in names}
    return {**_MOVES, **_VALUES, **_COURSE, **_WORDS, **blocks}


def program_with(statements: tuple[Statement, ...], target: str) -> Program:
    """A program of another language than `target` that holds these statements."""
    named = [name for name in writable() if name != target and not limits_of(name).registers]
    vendor = max(
        named, key=lambda name: len(find_vendor(name).reads)
    )  # the richest, whichever others there are
    lines = tuple(replace(s, line=n) for n, s in enumerate(statements, 1))
    place = {"p1": 0.0, "p2": 0.06, "p3": 0.12}
    data = [
        Declare(
            0, name, "position", PositionLiteral("pose", (0.9, y, 0.5 + y * y, 3.0, 0.1, 0.2)), shared=True
        )
        for name, y in place.items()
    ]
    data.append(Declare(0, "n", "integer", Number(0), shared=True))
    other = Routine(
        "OTHER", len(lines) + 1, (Dwell(len(lines) + 1, Quantity(Number(0.1), 1.0)),), PointTable()
    )
    source = decode(b"\n" * (len(lines) + 2), "probe", "cp1252")
    main = Routine("MAIN", 1, lines, PointTable())
    return Program(vendor, source, (main, other), data=tuple(data), main="MAIN")
