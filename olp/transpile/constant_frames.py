"""Tools and frames that a program sets once, at its beginning, to values that its text shows: they are constants.

Some programs write a position component by component and then make it a tool or a frame.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from typing import Any, Final

from olp.core.units import deg, mm
from olp.ir import expressions as ex
from olp.ir import program as st
from olp.ir.transformer import expressions_of, mapped
from olp.transpile.context import TranslationContext

_STRAIGHT = frozenset(
    {"Begin", "Declare", "Comment", "SetOutput", "Dwell", "Message", "SetTool", "SetFrame", "SetSpeed"}
)
_MEMBERS = {"x": (0, mm), "y": (1, mm), "z": (2, mm), "rx": (3, deg), "ry": (4, deg), "rz": (5, deg)}
Key = tuple[str, int]


def constant_systems(program: st.Program, work: TranslationContext) -> st.Program:
    """Puts the constant tools and frames into `work.systems` and drops the statements that set them."""
    if not program.routines:
        return program
    counts = _counts(s for routine in program.routines for _, s in work.look(routine).rare)
    if not counts:
        return program
    taken = _taken(program, work, set(counts))
    main = program.main or program.routines[0].name
    routines = []
    for routine in program.routines:
        if routine.name == main:
            routine = replace(routine, body=tuple(_Preface(work, counts, taken).rows(routine.body, program)))
        routines.append(routine)
    return replace(program, routines=tuple(routines))


def system_of(target: ex.Expression | None) -> Key | None:
    """(tool or user, number) that an assignment to `target` sets."""
    if (
        isinstance(target, ex.Function)
        and target.name == "tool-data"
        and isinstance(target.arguments[0], ex.Number)
    ):
        return "tool", int(target.arguments[0].value)
    if (
        isinstance(target, ex.FrameRef)
        and target.kind in ("tool", "user")
        and isinstance(target.number, ex.Number)
    ):
        return target.kind, int(target.number.value)
    return None


def _taken(program: st.Program, work: TranslationContext, keys: set[Key]) -> set[Key]:
    """Those of `keys` that something here moves with or reads: what sets others, does so for other programs."""
    found: set[Key] = set()
    for routine in program.routines if keys else ():
        for s in routine.body:
            if type(s) is st.Move:
                found |= {system_of(s.tool), system_of(s.frame)} & keys  # type: ignore[arg-type]
            elif type(s) in (st.SetTool, st.SetFrame):
                found |= {system_of(s.tool if type(s) is st.SetTool else s.frame)} & keys  # type: ignore
        for _, s in work.look(routine).rare:
            read = s.value if isinstance(s, st.Assign) and system_of(s.target) is not None else s
            if not isinstance(s, st.DefineFrame):
                found |= {system_of(e) for e in expressions_of(read)} & keys  # type: ignore[arg-type]
        if found == keys:
            break
    return found


def _counts(statements: Iterable[st.Statement]) -> dict[Key, int]:
    found: dict[Key, int] = {}
    for s in statements:
        if not isinstance(s, (st.Assign, st.DefineFrame)):
            continue
        key = system_of(s.target if isinstance(s, st.Assign) else s.frame)
        if key is not None:
            found[key] = found.get(key, 0) + 1
    return found


@dataclass(slots=True)
class _Preface:
    """The statements before anything branches, with what positions hold there."""

    work: TranslationContext
    counts: dict[Key, int]
    taken: set[Key]
    held: dict[str, list[float]] = field(default_factory=dict)

    def rows(self, body: tuple[st.Statement, ...], program: st.Program) -> list[st.Statement]:
        for declare in program.data:
            if isinstance(declare.value, ex.PositionLiteral) and declare.value.kind == "pose":
                zeros = not any(declare.value.values) and declare.name in self.work.registers
                self.held[declare.name] = [math.nan] * 6 if zeros else list(declare.value.values)
        rows: list[st.Statement] = []
        for at, s in enumerate(body):
            if isinstance(s, (st.Assign, st.DefineFrame)):
                left = self._left(s)
                if left is not None:
                    rows.append(left)
            elif type(s).__name__ in _STRAIGHT:
                rows.append(s)
            else:
                rows += body[at:]
                break
        return rows

    def _left(self, s: st.Assign | st.DefineFrame) -> st.Statement | None:
        """What stays of a statement: nothing where it sets a tool or frame of this program's moves to a value that is
        known, and nothing else sets that one."""
        key = system_of(s.target if isinstance(s, st.Assign) else s.frame)
        if key is not None and self.counts[key] == 1:
            value = self._value(s.value) if isinstance(s, st.Assign) else self._corner(s)
            if value is not None and not any(map(math.isnan, value)):
                known = ex.PositionLiteral("pose", tuple(value))
                if key in self.taken:
                    self.work.systems[key] = known
                    return None
                if isinstance(s, st.DefineFrame):
                    return st.Assign(s.line, s.frame, known, s.comment)
        if isinstance(s, st.Assign):
            self._note(s)
        return s

    def _note(self, s: st.Assign) -> None:
        if isinstance(s.target, ex.Named):
            value = self._value(s.value)
            self.held[s.target.name] = [math.nan] * 6 if value is None else value
        elif isinstance(s.target, ex.Member) and isinstance(s.target.base, ex.Named):
            at, scale = _MEMBERS.get(s.target.name, (-1, 1.0))
            number = _number(s.value)
            if at >= 0:
                row = self.held.setdefault(s.target.base.name, [math.nan] * 6)
                row[at] = math.nan if number is None else number * scale

    def _value(self, e: ex.Expression) -> list[float] | None:
        if isinstance(e, ex.PositionLiteral):
            return list(e.values) if e.kind == "pose" and len(e.values) >= 6 else None
        return list(self.held[e.name]) if isinstance(e, ex.Named) and e.name in self.held else None

    def _corner(self, s: st.DefineFrame) -> list[float] | None:
        """A frame by three points that are written in the base: INFORM's MFRAME."""
        from olp.core.diagnostic import OlpError
        from olp.robots.geometry import frame_from_points

        if len(s.points) < 3 or s.master_tool:
            return None
        points: list[Any] = list(s.points[:3])
        corners = [self._value(point) for point in points]
        places = [
            self.work.states.get(point.name, "") if isinstance(point, ex.Named) else "" for point in points
        ]
        if any(corner is None for corner in corners) or any(place != "base" for place in places):
            return None
        try:
            pose = frame_from_points(*(corner[:3] for corner in corners if corner is not None))
        except OlpError:
            return None
        return [float(v) for v in pose.xyz_angles()] if len(s.points) == 3 else None


def _number(e: ex.Expression) -> float | None:
    if isinstance(e, ex.Number):
        return float(e.value)
    if isinstance(e, ex.Unary) and e.operator == "-":
        inner = _number(e.operand)
        return None if inner is None else -inner
    return None


# --- Tools and frames that hold ---
# What a program reads of the tool and the frame that hold (KRL's `F=$BASE`), where the statements before it in its
# routine set them, whatever way led here.

_CURRENT: Final = {"current-tool": "tool", "current-frame": "frame"}
_ZERO_FRAME: Final = ex.PositionLiteral("pose", (0.0,) * 6)


def active_systems(program: st.Program, work: TranslationContext) -> st.Program:
    """Readings of the active tool or frame become the name of the one that is active there."""
    if not work.limits.named_frames:
        return program
    if not any(isinstance(s, st.Assign) and _reads_system(s.value) for s in work.rare(program)):
        return program
    return replace(program, routines=tuple(replace(r, body=_with_held(r.body)) for r in program.routines))


def _with_held(body: tuple[st.Statement, ...]) -> tuple[st.Statement, ...]:
    if not any(isinstance(s, st.Assign) and _reads_system(s.value) for s in body):
        return body
    rows: list[st.Statement] = []
    holds: dict[str, ex.Expression] = {}
    for s in body:
        if isinstance(s, st.SetTool):
            holds["tool"] = s.tool
        elif isinstance(s, st.SetFrame):
            holds["frame"] = s.frame
        elif isinstance(s, (*st.WAYS_MEET, st.Call)):
            holds.clear()
        elif isinstance(s, st.Assign):
            if _reads_system(s.value):
                s = replace(s, value=_as_held(s.value, holds))
            # What has been copied stays when its own value changes.
            changed = {e for e in expressions_of(s.target) if isinstance(e, (ex.Named, ex.FrameRef))}
            holds = {part: e for part, e in holds.items() if not changed & set(expressions_of(e))}
        rows.append(s)
    return tuple(rows)


def _reads_system(e: ex.Expression) -> bool:
    return any(isinstance(one, ex.SystemValue) and one.name in _CURRENT for one in expressions_of(e))


def _as_held(e: ex.Expression, holds: Mapping[str, ex.Expression]) -> ex.Expression:
    def change(one: ex.Expression) -> ex.Expression:
        if not isinstance(one, ex.SystemValue) or one.name not in _CURRENT:
            return one
        found = holds.get(_CURRENT[one.name], one)
        nothing = found in (
            ex.FrameRef("base"),
            ex.FrameRef("tool", ex.Number(0)),
            ex.FrameRef("user", ex.Number(0)),
        )
        return _ZERO_FRAME if nothing else found

    return mapped(e, change)
