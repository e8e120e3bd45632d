"""One small program for every kind of statement, to find out what a language makes of it."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from functools import lru_cache
from typing import Any

from olp.core.source import decode
from olp.ir import expressions as ex
from olp.ir import program as st
from olp.ir.points import PointTable
from olp.languages.limits import limits_of, writable
from olp.languages.vendor import find_vendor

Probes = Mapping[str, tuple[st.Statement, ...]]

_N, _P, _Q = ex.Named("n"), ex.Named("p1"), ex.Named("p2")
_R = ex.Variable(ex.Store.ROBOT, ex.Number(1))
_MORE = ex.Compare(">", _N, ex.Number(0))
_IN, _OUT = ex.Signal("in", ex.Number(2)), ex.Signal("out", ex.Number(3))
_TOOL = ex.PositionLiteral("pose", (0.01, -0.02, 0.2, 0.1, 0.2, 0.3))
_PERCENT, _MM = 0.01, 0.001


def _move(path: st.Path, **more: Any) -> st.Move:
    slow = st.Speed(st.SpeedUnit.FRACTION, ex.Quantity(ex.Number(40), _PERCENT))
    fast = st.Speed(st.SpeedUnit.TRAVEL, ex.Quantity(ex.Number(250), _MM))
    stop = st.Blend(st.BlendKind.RADIUS, ex.Quantity(ex.Number(0), _MM))
    joint = path is st.Path.JOINT
    plain = st.Move(
        0,
        path,
        (_P,),
        slow if joint else fast,
        stop,
        tool=ex.FrameRef("tool", ex.Number(0)),
        frame=ex.FrameRef("base"),
    )
    return replace(plain, **more)


_START = _move(st.Path.LINEAR, targets=(_Q,))


_SHIFT = ex.PositionLiteral("pose", (0.01, -0.02, 0.03, 0.0, 0.0, 0.1))
_STEP = st.Assign(0, _N, ex.Number(3))
_SHORT = st.Dwell(0, ex.Quantity(ex.Number(1), 1.0))
_DOWN = st.Update(0, "-", _N, ex.Number(1))
_SLOW = st.Speed(st.SpeedUnit.TRAVEL, ex.Quantity(ex.Number(100), _MM))
_HALF = ex.Quantity(ex.Number(50), _PERCENT)

_MOVES: Probes = {
    "Move joint": (_move(st.Path.JOINT),),
    "Move linear": (_move(st.Path.LINEAR),),
    "Move circular": (_START, _move(st.Path.CIRCULAR, targets=(ex.Named("p3"),), via=_P)),
    "Move spline": (_START, _move(st.Path.SPLINE), _move(st.Path.SPLINE, targets=(ex.Named("p3"),))),
    "SetSpeed": (st.SetSpeed(0, (_SLOW,)), _move(st.Path.LINEAR, speed=None)),
    "SetAcceleration": (
        st.SetAcceleration(0, (st.Acceleration(st.AccelerationUnit.FRACTION, _HALF),)),
        _move(st.Path.LINEAR),
    ),
    "SetBlend": (
        st.SetBlend(0, (st.Blend(st.BlendKind.RADIUS, ex.Quantity(ex.Number(5), _MM)),)),
        _move(st.Path.LINEAR, blend=st.Blend(st.BlendKind.RADIUS)),
    ),
    "SetTool": (st.SetTool(0, _TOOL), _move(st.Path.LINEAR, tool=None)),
    "SetFrame": (st.SetFrame(0, _TOOL), _move(st.Path.LINEAR, frame=None)),
    "SetOverride": (st.SetOverride(0, _HALF), _move(st.Path.LINEAR)),
    "ObeyFlags": (st.ObeyFlags(0, False), _move(st.Path.JOINT)),
    "ShiftOn": (st.ShiftOn(0, _SHIFT), _move(st.Path.LINEAR), st.ShiftOff(0)),
    "ExternalTool": (st.ExternalTool(0, ex.Number(1)),),
    "DefineFrame": (
        st.DefineFrame(0, ex.FrameRef("user", ex.Number(1)), (_R, _R, _R)),
        _move(st.Path.LINEAR),
    ),
    "Reference": (st.Reference(0, ex.Number(1), (_R,)), _move(st.Path.LINEAR)),
}
_VALUES: Probes = {
    "Assign": (_STEP,),
    "Update": (st.Update(0, "+", _N, ex.Number(1)),),
    "Clear": (st.Clear(0, _N),),
    "SetOutput": (st.SetOutput(0, _OUT, ex.SignalState(True)),),
    "PulseOutput": (st.PulseOutput(0, _OUT, ex.Quantity(ex.Number(0.5), 1.0)),),
    "ReadInput": (st.ReadInput(0, _N, ex.Signal("in-group", ex.Number(1))),),
    "Declare": (st.Declare(0, "m", "integer", ex.Number(1)), st.Assign(0, ex.Named("m"), ex.Number(2))),
}
_COURSE: Probes = {
    "Dwell": (st.Dwell(0, ex.Quantity(ex.Number(0.5), 1.0)),),
    "Wait": (st.Wait(0, ex.Compare("=", _IN, ex.SignalState(True))),),
    "Call": (st.Call(0, "OTHER"),),
    "Return": (st.Return(0),),
    "Pause": (st.Pause(0),),
    "StartTask": (st.StartTask(0, "OTHER", "SUB1"),),
    "WaitTask": (st.StartTask(0, "OTHER", "SUB1"), st.WaitTask(0, "SUB1")),
    "Synchronise": (st.Synchronise(0, ex.Number(1)),),
}
_WORDS: Probes = {
    "Message": (st.Message(0, ex.Text("ready")),),
    "Process": (st.Process(0, "ARCON"),),
    "Comment": (st.Comment(0, "text"),),
    "Disabled": (st.Disabled(0, "MOVE"),),
    "Opaque": (st.Opaque(0, "TEXT"),),
    "Begin": (st.Begin(0),),
    "End": (st.End(0),),
}
_LEFT = (
    st.While(0, ex.SignalState(True)), _DOWN, st.If(0, _MORE), st.Continue(0), st.EndIf(0), st.Break(0), st.EndWhile(0),
)  # fmt: skip
_BRANCH = (
    st.If(0, _MORE),
    _STEP,
    st.ElseIf(0, ex.Compare("=", _N, ex.Number(0))),
    _STEP,
    st.Else(0),
    _STEP,
    st.EndIf(0),
)
# Kinds that stand together only.
_BLOCKS: tuple[tuple[tuple[str, ...], tuple[st.Statement, ...]], ...] = (
    (("ShiftOff",), _MOVES["ShiftOn"]),
    (("While", "EndWhile"), (st.While(0, _MORE), _DOWN, st.EndWhile(0))),
    (("Break", "Continue"), _LEFT),
    (
        ("Switch", "Case", "Default", "EndSwitch"),
        (st.Switch(0, _N), st.Case(0, (ex.Number(1),)), _SHORT, st.Default(0), st.EndSwitch(0)),
    ),
    (("If", "ElseIf", "Else", "EndIf"), _BRANCH),
    (("Repeat", "Until"), (st.Repeat(0), _DOWN, st.Until(0, ex.Compare("<=", _N, ex.Number(0))))),
    (("For", "Next"), (st.For(0, _N, ex.Number(1), ex.Number(3)), _SHORT, st.Next(0, _N))),
    (("Label", "Jump"), (st.Label(0, "again"), _DOWN, st.Jump(0, "again", _MORE))),
)


@lru_cache
def probes() -> Probes:
    """Kind of statement -> the statements of a program that has one."""
    blocks = {name: statements for names, statements in _BLOCKS for name in names}
    return {**_MOVES, **_VALUES, **_COURSE, **_WORDS, **blocks}


_WAITS = (st.Dwell(0, ex.Quantity(ex.Number(0.1), 1.0)),)


def program_with(
    statements: tuple[st.Statement, ...], target: str, other: tuple[st.Statement, ...] = _WAITS
) -> st.Program:
    """A program of another language than `target` that holds these statements, and `other` in the routine "OTHER"."""
    named = [name for name in writable() if name != target and not limits_of(name).registers]
    vendor = max(
        named, key=lambda name: len(find_vendor(name).reads)
    )  # the richest, whichever others there are
    last = len(statements)
    lines = tuple(replace(s, line=n) for n, s in enumerate(statements, 1))
    called = tuple(replace(s, line=n) for n, s in enumerate(other, last + 1))
    place = {"p1": 0.0, "p2": 0.06, "p3": 0.12}
    data = [
        st.Declare(
            0, name, "position", ex.PositionLiteral("pose", (0.9, y, 0.5 + y * y, 3.0, 0.1, 0.2)), shared=True
        )
        for name, y in place.items()
    ]
    data.append(st.Declare(0, "n", "integer", ex.Number(0), shared=True))
    source = decode(b"\n" * (last + len(called) + 1), "probe", "cp1252")
    main = st.Routine("MAIN", 1, lines, PointTable())
    sub = st.Routine("OTHER", last + 1, called, PointTable())
    return st.Program(vendor, source, (main, sub), data=tuple(data), main="MAIN")
