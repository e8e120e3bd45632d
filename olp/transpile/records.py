"""Tools, frames and positions that are records in their language become plain positions."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from functools import partial

from olp.ir import program as st
from olp.ir.expressions import CallValue, Expression, Member, Named, PositionLiteral, RecordLiteral, Text
from olp.ir.transformer import (
    Change,
    calls_nothing,
    changed_by,
    expressions_of,
    mapped,
    note_names,
    sets_numbers,
)
from olp.robots.geometry import Pose
from olp.transpile.context import Fate, TranslationContext
from olp.transpile.first_values import is_plain
from olp.transpile.occurrences import changed_rare, with_rows

_COPIES = 5  # of a tool or frame, one of the other
_FLANGE = ("tframe", "tcp", "trsf")
_PARTS = ("uframe", "oframe")  # of a work object's record: the pose is their product


def records(program: st.Program, work: TranslationContext) -> st.Program:
    """Every tool and frame as the pose that it is. Of a record's other members (load, name …) the target knows none."""
    if not work.conventions.has_records:
        return program
    if work.conventions.frame_records:
        program = _without_frames(program, work)
    _refuse_held(program, work)
    change = partial(_change, wholes=_wholes(program, work))
    routines = tuple(replace(_rows(r, work, change), data=_declared(r.data, work)) for r in program.routines)
    return replace(program, routines=routines, data=_declared(program.data, work))


def _refuse_held(program: st.Program, work: TranslationContext) -> None:
    """Every statement with a tool that stands beside the robot, or with work that it or another unit moves."""
    inner = [d for r in program.routines for d in (*r.data, *(s for _, s in work.look(r).rare))]
    names: dict[str, str] = {}
    for d in (*program.data, *inner):
        if isinstance(d, st.Declare) and _is_held(d):
            names[d.name] = "a tool that stands beside the robot, or work that it holds"
        elif isinstance(d, st.Declare) and (unit := _unit_of(d)):
            names[d.name] = f"the work on {unit}, which the move follows wherever it is"
    for s in program.statements() if names else ():
        if isinstance(s, st.Declare):
            continue
        says = next(
            (names[e.name] for e in expressions_of(s) if isinstance(e, Named) and e.name in names), ""
        )
        if says:
            work.lose(s, Fate.REFUSED, "tool", says)


def _unit_of(s: st.Declare) -> str:
    """The mechanical unit (a conveyor, a positioner) that moves a work object; empty for one that stands."""
    if s.type != "frame" or not isinstance(s.value, RecordLiteral) or s.sizes:
        return ""
    unit = {name.casefold(): value for name, value in s.value.members}.get("ufmec")
    return unit.value if isinstance(unit, Text) else ""


def _is_held(s: st.Declare) -> bool:
    if s.type not in ("tool", "frame") or not isinstance(s.value, RecordLiteral) or s.sizes:
        return False
    held = {name.casefold(): value for name, value in s.value.members}.get("robhold")
    return held is not None and getattr(held, "on", True) is (s.type == "frame")


def _without_frames(program: st.Program, work: TranslationContext) -> st.Program:
    """KRL's FRAME is any pose: what is never a tool or a frame of a move is a position."""
    used: set[str] = set()
    looks = [work.look(r) for r in program.routines]
    rare = [s for look in looks for _, s in look.rare]
    for _, e in [system for look in looks for system in look.systems]:
        note_names(e, used)
    for s in rare:
        if isinstance(s, (st.Move, st.SetTool)) and s.tool is not None:
            note_names(s.tool, used)
        if isinstance(s, (st.Move, st.SetFrame)) and s.frame is not None:
            note_names(s.frame, used)
        if isinstance(s, (st.Move, st.SetTool, st.SetFrame)):
            used.update(_called(s))
    set_to = [(s.target.name, s.value) for s in rare if type(s) is st.Assign and isinstance(s.target, Named)]
    set_to += [
        (r.name, s.value)
        for r, look in zip(program.routines, looks, strict=True)
        for _, s in look.rare
        if type(s) is st.Return and s.value is not None
    ]
    handed = _handed(program, rare)
    for _ in range(_COPIES):
        before = len(used)
        for name, value in set_to:
            if name in used:
                note_names(value, used)
                used.update(e.routine for e in expressions_of(value) if type(e) is CallValue)
        for name, value in handed:
            names: set[str] = set()
            note_names(value, names)
            if name in used or names & used:
                used |= {name, *names}
        if len(used) == before:
            break

    def plain(d: st.Declare) -> st.Declare:
        return replace(d, type="position") if d.type in ("tool", "frame") and d.name not in used else d

    def row(s: st.Statement) -> st.Statement:
        return plain(s) if type(s) is st.Declare else s

    def plain_parameter(p: st.Parameter) -> st.Parameter:
        return replace(p, type="position") if p.type in ("tool", "frame") and p.name not in used else p

    routines = tuple(
        replace(
            changed_rare(r, work.look(r), row),
            data=tuple(map(plain, r.data)),
            parameters=tuple(map(plain_parameter, r.parameters)),
            returns="position" if r.returns in ("tool", "frame") and r.name not in used else r.returns,
        )
        for r in program.routines
    )
    return replace(program, routines=routines, data=tuple(map(plain, program.data)))


def _called(s: st.Move | st.SetTool | st.SetFrame) -> set[str]:
    """The routines whose results a statement takes for its tool or frame."""
    systems = [getattr(s, name, None) for name in ("tool", "frame")]
    return {
        e.routine for one in systems if one is not None for e in expressions_of(one) if type(e) is CallValue
    }


def _handed(program: st.Program, rare: Iterable[st.Statement]) -> list[tuple[str, Expression]]:
    """Parameters, each with what a call hands over for it."""
    given = {r.name.casefold(): r.parameters for r in program.routines if r.parameters}
    found: list[tuple[str, Expression]] = []
    for s in rare:
        calls = [(s.routine, s.arguments)] if isinstance(s, st.Call) else []
        if given and not (calls_nothing(s) or sets_numbers(s)):
            calls += [(e.routine, e.arguments) for e in expressions_of(s) if type(e) is CallValue]
        for routine, arguments in calls:
            for p, value in zip(given.get(routine.casefold(), ()), arguments, strict=False):
                if p.type in ("tool", "frame"):
                    found.append((p.name, value))
    return found


def _rows(routine: st.Routine, work: TranslationContext, change: Change) -> st.Routine:
    inside = work.conventions.records_in_statements

    def row(s: st.Statement) -> st.Statement:
        return _plain(s, work) if isinstance(s, st.Declare) else mapped(s, change) if inside else s

    return (
        with_rows(routine, list(map(row, routine.body)))
        if inside
        else changed_rare(routine, work.look(routine), row)
    )


def _declared(data: tuple[st.Declare, ...], work: TranslationContext) -> tuple[st.Declare, ...]:
    return tuple(_plain(declare, work) for declare in data)


def _plain(s: st.Declare, work: TranslationContext) -> st.Declare:
    system = s.type in ("tool", "frame")
    if not s.sizes and (type(s.value) is PositionLiteral or (not system and is_plain(s.value))):
        return s
    if not system or not isinstance(s.value, RecordLiteral) or s.sizes:
        return mapped(s, _change)
    value = pose_of_record(s.value)
    if value is None:
        work.lose(s, Fate.REFUSED, s.type, f"the value of {s.name} is computed")
        return s
    return replace(s, value=value, native="")


def pose_of_record(record: Expression | None) -> PositionLiteral | None:
    """The pose that a tool's or frame's record is, None where it is computed."""
    if isinstance(record, PositionLiteral):
        return record
    if not isinstance(record, RecordLiteral):
        return None
    members = {name.casefold(): value for name, value in record.members}
    for name in _FLANGE:
        if name in members:
            return pose_of_record(members[name])
    if "uframe" not in members:
        return None
    outer, inner = pose_of_record(members["uframe"]), pose_of_record(members.get("oframe"))
    if outer is None:
        return None
    return outer if inner is None else literal_of(pose_of_literal(outer) @ pose_of_literal(inner))


def pose_of_literal(literal: PositionLiteral) -> Pose:
    """A written pose as one to compute with; components that are not written count as zero."""
    return Pose.from_xyz_angles([0.0 if v != v else v for v in literal.values[:6]])


def literal_of(pose: Pose) -> PositionLiteral:
    """A pose as it is written."""
    return PositionLiteral("pose", tuple(float(v) for v in pose.xyz_angles()))


def _change(e: Expression, wholes: frozenset[tuple[str, str]] = frozenset()) -> Expression:
    """tGripper.tframe is the tool itself; a record in the place of a tool is its pose.

    `wholes`: (frame, part) of frames that one of their two parts is.
    """
    if isinstance(e, Member) and e.name.casefold() in _FLANGE:
        return e.base
    if isinstance(e, Member) and isinstance(e.base, Named) and (e.base.name, e.name.casefold()) in wholes:
        return e.base
    if isinstance(e, RecordLiteral):
        return pose_of_record(e) or e
    return e


def _wholes(program: st.Program, work: TranslationContext) -> frozenset[tuple[str, str]]:
    """(frame, part) of the frames whose other part changes nothing, whatever the program does.

    Nothing but assignments to the part itself may change such a frame.
    """
    found = {
        (d.name, part)
        for d in program.data
        if d.type == "frame" and not d.sizes
        for part in _whole_parts(d.value)
    }
    for routine in program.routines if found else ():
        hidden = {d.name for d in routine.data} | {p.name for p in routine.parameters}
        for _, s in work.look(routine).rare:
            if isinstance(s, st.Declare):
                hidden.add(s.name)
                continue
            changed = list(changed_by(s))
            name, part = _part_of(s.target) if isinstance(s, st.Assign) else ("", "")
            if isinstance(s, st.Assign) and isinstance(s.target, Named):
                name, kept = s.target.name, _whole_parts(s.value)
            else:
                kept = {part} if part else set()
            if kept:
                found -= {(n, p) for n, p in found if n == name and p not in kept}
                changed = changed[1:]
            hidden.update(changed)
        found -= {(n, p) for n, p in found if n in hidden}
    return frozenset(found)


def _whole_parts(value: Expression | None) -> set[str]:
    """The parts of a frame's record that are the frame, since the other one changes nothing."""
    if not isinstance(value, RecordLiteral):
        return set()
    members = {name.casefold(): pose_of_record(inner) for name, inner in value.members}
    still = {name for name in _PARTS if (pose := members.get(name)) is not None and not any(pose.values)}
    return {part for part, other in (_PARTS, _PARTS[::-1]) if other in still}


def _part_of(target: Expression) -> tuple[str, str]:
    """(frame, part) of a target within one of a frame's two parts, "" for any other one."""
    while isinstance(target, Member):
        if isinstance(target.base, Named) and target.name.casefold() in _PARTS:
            return target.base.name, target.name.casefold()
        target = target.base
    return "", ""
