"""Tools and frames that a program sets once, at its beginning, to values that its text shows: they are constants.

Some programs write a position component by component and then make it a tool or a frame.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from typing import Any, Final

from olp.core.units import deg, mm
from olp.ir.expressions import (
    Expression,
    FrameRef,
    Function,
    Member,
    Named,
    Number,
    PositionLiteral,
    SystemValue,
    Unary,
)
from olp.ir.program import (
    Assign,
    Call,
    Case,
    Default,
    DefineFrame,
    Else,
    ElseIf,
    EndIf,
    EndSwitch,
    EndWhile,
    For,
    Label,
    Next,
    Program,
    Repeat,
    SetFrame,
    SetTool,
    Statement,
    While,
)
from olp.ir.transformer import expressions_of, mapped
from olp.transpile.context import TranslationContext

_STRAIGHT = frozenset(
    {"Begin", "Declare", "Comment", "SetOutput", "Dwell", "Message", "SetTool", "SetFrame", "SetSpeed"}
)
_MEMBERS = {"x": (0, mm), "y": (1, mm), "z": (2, mm), "rx": (3, deg), "ry": (4, deg), "rz": (5, deg)}
Key = tuple[str, int]


def known_systems(program: Program, work: TranslationContext) -> Program:
    """Notes the values in `work.systems`; the statements that set them are left out."""
    if not program.routines:
        return program
    counts = _counts(s for routine in program.routines for _, s in work.look(routine).rare)
    if not counts:
        return program
    main = program.main or program.routines[0].name
    routines = []
    for routine in program.routines:
        if routine.name == main:
            routine = replace(routine, body=tuple(_Preface(work, counts).rows(routine.body, program)))
        routines.append(routine)
    return replace(program, routines=tuple(routines))


def system_of(target: Expression | None) -> Key | None:
    """(tool or user, number) that an assignment to `target` sets."""
    if (
        isinstance(target, Function)
        and target.name == "tool-data"
        and isinstance(target.arguments[0], Number)
    ):
        return "tool", int(target.arguments[0].value)
    if isinstance(target, FrameRef) and target.kind in ("tool", "user") and isinstance(target.number, Number):
        return target.kind, int(target.number.value)
    return None


def _counts(statements: Iterable[Statement]) -> dict[Key, int]:
    found: dict[Key, int] = {}
    for s in statements:
        if not isinstance(s, (Assign, DefineFrame)):
            continue
        key = system_of(s.target if isinstance(s, Assign) else s.frame)
        if key is not None:
            found[key] = found.get(key, 0) + 1
    return found


@dataclass(slots=True)
class _Preface:
    """The statements before anything branches, with what positions hold there."""

    work: TranslationContext
    counts: dict[Key, int]
    held: dict[str, list[float]] = field(default_factory=dict)

    def rows(self, body: tuple[Statement, ...], program: Program) -> list[Statement]:
        for declare in program.data:
            if isinstance(declare.value, PositionLiteral) and declare.value.kind == "pose":
                zeros = not any(declare.value.values) and declare.name in self.work.registers
                self.held[declare.name] = [math.nan] * 6 if zeros else list(declare.value.values)
        rows: list[Statement] = []
        for at, s in enumerate(body):
            if isinstance(s, (Assign, DefineFrame)):
                if not self._sets(s):
                    rows.append(s)
            elif type(s).__name__ in _STRAIGHT:
                rows.append(s)
            else:
                rows += body[at:]
                break
        return rows

    def _sets(self, s: Assign | DefineFrame) -> bool:
        """Whether the statement sets a tool or frame to a value that is known, and nothing else sets that one."""
        key = system_of(s.target if isinstance(s, Assign) else s.frame)
        if key is not None and self.counts[key] == 1:
            value = self._value(s.value) if isinstance(s, Assign) else self._corner(s)
            if value is not None and not any(map(math.isnan, value)):
                self.work.systems[key] = PositionLiteral("pose", tuple(value))
                return True
        if isinstance(s, Assign):
            self._note(s)
        return False

    def _note(self, s: Assign) -> None:
        if isinstance(s.target, Named):
            value = self._value(s.value)
            self.held[s.target.name] = [math.nan] * 6 if value is None else value
        elif isinstance(s.target, Member) and isinstance(s.target.base, Named):
            at, scale = _MEMBERS.get(s.target.name, (-1, 1.0))
            number = _number(s.value)
            if at >= 0:
                row = self.held.setdefault(s.target.base.name, [math.nan] * 6)
                row[at] = math.nan if number is None else number * scale

    def _value(self, e: Expression) -> list[float] | None:
        if isinstance(e, PositionLiteral):
            return list(e.values) if e.kind == "pose" and len(e.values) >= 6 else None
        return list(self.held[e.name]) if isinstance(e, Named) and e.name in self.held else None

    def _corner(self, s: DefineFrame) -> list[float] | None:
        """A frame by three points that are written in the base: INFORM's MFRAME."""
        from olp.core.diagnostic import OlpError
        from olp.robots.geometry import frame_from_points

        if len(s.points) < 3 or s.master_tool:
            return None
        points: list[Any] = list(s.points[:3])
        corners = [self._value(point) for point in points]
        places = [
            self.work.states.get(point.name, "") if isinstance(point, Named) else "" for point in points
        ]
        if any(corner is None for corner in corners) or any(place != "base" for place in places):
            return None
        try:
            pose = frame_from_points(*(corner[:3] for corner in corners if corner is not None))
        except OlpError:
            return None
        return [float(v) for v in pose.xyz_angles()] if len(s.points) == 3 else None


def _number(e: Expression) -> float | None:
    if isinstance(e, Number):
        return float(e.value)
    if isinstance(e, Unary) and e.operator == "-":
        inner = _number(e.operand)
        return None if inner is None else -inner
    return None


# --- Tools and frames that hold ---
# What a program reads of the tool and the frame that hold (KRL's `F=$BASE`), where the statements before it in its
# routine set them, whatever way led here.

_CURRENT: Final = {"current-tool": "tool", "current-frame": "frame"}
_LEADS_HERE: Final = (
    Label,
    Else,
    ElseIf,
    EndIf,
    While,
    EndWhile,
    Repeat,
    For,
    Next,
    Case,
    Default,
    EndSwitch,
    Call,
)
_ZERO_FRAME: Final = PositionLiteral("pose", (0.0,) * 6)


def held_systems(program: Program, work: TranslationContext) -> Program:
    """The tool and the frame that hold, by their names where they are read."""
    if not work.limits.named_frames:
        return program
    return replace(program, routines=tuple(replace(r, body=_with_held(r.body)) for r in program.routines))


def _with_held(body: tuple[Statement, ...]) -> tuple[Statement, ...]:
    if not any(isinstance(s, Assign) and _reads_system(s.value) for s in body):
        return body
    rows: list[Statement] = []
    holds: dict[str, Expression] = {}
    for s in body:
        if isinstance(s, SetTool):
            holds["tool"] = s.tool
        elif isinstance(s, SetFrame):
            holds["frame"] = s.frame
        elif isinstance(s, _LEADS_HERE):
            holds.clear()
        elif isinstance(s, Assign):
            if _reads_system(s.value):
                s = replace(s, value=_as_held(s.value, holds))
            # What has been copied stays when its own value changes.
            changed = {e for e in expressions_of(s.target) if isinstance(e, (Named, FrameRef))}
            holds = {part: e for part, e in holds.items() if not changed & set(expressions_of(e))}
        rows.append(s)
    return tuple(rows)


def _reads_system(e: Expression) -> bool:
    return any(isinstance(one, SystemValue) and one.name in _CURRENT for one in expressions_of(e))


def _as_held(e: Expression, holds: Mapping[str, Expression]) -> Expression:
    def change(one: Expression) -> Expression:
        if not isinstance(one, SystemValue) or one.name not in _CURRENT:
            return one
        found = holds.get(_CURRENT[one.name], one)
        nothing = found in (FrameRef("base"), FrameRef("tool", Number(0)), FrameRef("user", Number(0)))
        return _ZERO_FRAME if nothing else found

    return mapped(e, change)
