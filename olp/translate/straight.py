"""Lengths and turns of moves that the text alone shows: from one written pose straight to the next."""

from __future__ import annotations

from typing import Final

import numpy as np

from olp.expression import CallValue, Function, Named, Number, PositionLiteral, State, Text, Variable
from olp.geometry import Array, rotation_angle, rotation_from_angles
from olp.program import Assign, Call, Move, Path, Program, StartTask, Statement, Update
from olp.translate.rewrite import expressions_of, is_usual
from olp.translate.symbols import Symbols

# What runs between two moves without leading elsewhere; nothing jumps there either.
_BETWEEN: Final = frozenset(
    {"Comment", "SetOutput", "PulseOutput", "Dwell", "Wait", "Message", "Declare", "Begin"}
)
_SETTING: Final = frozenset({"Assign", "Update", "DefineFrame"})
_PLAIN: Final = (Number, Text, State)
_HOLDERS: Final = frozenset({Named, Variable})  # no component of a tool or of a frame
Segment = tuple[float, float]  # [m] and [rad]


def segments(program: Program, symbols: Symbols) -> dict[int, Segment]:
    """By the id of a move: its length and its turn, for all whose start and end the text shows.

    The main routine's first move starts where it ends, as the interpreter takes it, unless something calls that one.
    """
    main = program.main or (program.routines[0].name if program.routines else "")
    called = {s.routine.casefold() for s in program.statements() if isinstance(s, (Call, StartTask))}
    found: dict[int, Segment] = {}
    pairs: list[tuple[Move, int, int]] = []
    poses: list[tuple[float, ...]] = []
    for routine in program.routines:
        before: Move | None = None  # whose pose is the last one
        first = routine.name == main and main.casefold() not in called
        for s in routine.body:
            if type(s) is not Move:
                if type(s).__name__ in _SETTING and not any(type(e) is CallValue for e in expressions_of(s)):
                    before = before if _keeps_systems(s) else None
                elif type(s).__name__ not in _BETWEEN:
                    before, first = None, False
                continue
            pose = _pose(s, routine.name, symbols)
            if pose is not None and before is not None and _same_place(before, s):
                pairs.append((s, len(poses) - 1, len(poses)))
            elif first:
                found[id(s)] = (0.0, 0.0)
            if pose is not None:
                poses.append(pose)
            before, first = (None if pose is None else s), False
    if pairs:
        moves, start, end = zip(*pairs, strict=True)
        lengths, turns = _between(np.array(poses), list(start), list(end))
        for s, length, turn in zip(moves, lengths, turns, strict=True):
            if length == length and turn == turn:  # all components are written
                found[id(s)] = (length, turn)
    return found


def _between(poses: Array, start: list[int], end: list[int]) -> tuple[list[float], list[float]]:
    """Lengths [m] and turns [rad] from rows of `poses` (n, 6) to others, nan where a component is."""
    places, turned = poses[:, :3], rotation_from_angles(poses[:, 3:])
    lengths = np.linalg.norm(places[end] - places[start], axis=1)
    return lengths.tolist(), rotation_angle(turned[start], turned[end]).tolist()


def _keeps_systems(s: Statement) -> bool:
    """Whether an assignment changes no tool and no frame: it sets a number, a text or a state."""
    if not isinstance(s, (Assign, Update)) or type(s.target) not in _HOLDERS:
        return False
    return isinstance(s.value if isinstance(s, Assign) else s.operand, _PLAIN)


def _pose(s: Move, routine: str, symbols: Symbols) -> tuple[float, ...] | None:
    if s.via is not None or s.path is Path.CIRCULAR or len(s.targets) != 1 or not _is_whole(s):
        return None
    target = s.targets[0]
    if type(target) is Function and target.name == "pose-product" and _outer(s) is not None:
        target = target.arguments[1]  # seen from the frame that both ends stand in
    value = symbols.fixed_value(routine, target)
    if type(value) is not PositionLiteral or value.kind != "pose":
        return None
    values = value.values[:6]
    return values if len(values) == 6 else None


def _is_whole(s: Move) -> bool:
    """Whether the move ends where its target is."""
    if is_usual(s):
        return True
    return not s.parts and all(
        e is None for e in (s.relative, s.search, s.until, s.offset, s.tool_offset, s.via, s.arc)
    )


def _same_place(one: Move, other: Move) -> bool:
    tools = one.tool is other.tool or one.tool == other.tool
    frames = one.frame is other.frame or one.frame == other.frame
    return tools and frames and _outer(one) == _outer(other)


def _outer(s: Move) -> Named | None:
    """The named frame that a target is multiplied with."""
    target = s.targets[0]
    first = target.arguments[0] if type(target) is Function and target.name == "pose-product" else None
    return first if type(first) is Named else None
