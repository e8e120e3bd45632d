"""Lengths and turns of moves that the text alone shows: from one written pose straight to the next."""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, field
from math import inf, nan
from typing import Final

import numpy as np

from olp.ir.expressions import (
    CallValue,
    Function,
    Named,
    Number,
    PositionLiteral,
    SignalState,
    Text,
    Variable,
)
from olp.ir.program import Assign, Call, End, Move, Path, Program, Routine, StartTask, Statement, Update
from olp.ir.transformer import calls_nothing, expressions_of, is_usual
from olp.robots.geometry import Array, rotation_angle, rotation_from_angles
from olp.transpile.context import TranslationContext
from olp.transpile.symbols import Symbols

# What runs between two moves without leading elsewhere; nothing jumps there either.
BETWEEN: Final = frozenset(
    {"Comment", "SetOutput", "PulseOutput", "Dwell", "Wait", "Message", "Declare", "Begin"}
)
SETTING: Final = frozenset({"Assign", "Update", "DefineFrame"})
_PLAIN: Final = (Number, Text, SignalState)
_HOLDERS: Final = frozenset({Named, Variable})  # no component of a tool or of a frame
_NOTHING: Final = 1e-9  # [m]
Segment = tuple[float, float]  # [m] and [rad]


@dataclass(slots=True)
class Walk:
    """Pairs of moves that run one after the other, with the rows of their poses; the program's first and last move."""

    program: Program  # which keeps the moves' ids
    pairs: list[tuple[Move, Move, int, int]] = field(default_factory=list)
    poses: list[tuple[float, ...]] = field(default_factory=list)
    first: list[Move] = field(default_factory=list)
    last: list[Move] = field(default_factory=list)
    _segments: dict[int, Segment] | None = None
    _rooms: dict[int, float] | None = None

    def segments(self) -> dict[int, Segment]:
        """By the id of a move of `program`: its length and its turn, for all whose start and end the text shows.

        The program's first move starts where it ends, as the interpreter takes it, unless something calls its routine.
        """
        if self._segments is None:
            found: dict[int, Segment] = {id(s): (0.0, 0.0) for s in self.first}
            self._segments = found
            if self.pairs:
                _, moves, start, end = zip(*self.pairs, strict=True)
                lengths, turns = _between(np.array(self.poses), list(start), list(end))
                for s, length, turn in zip(moves, lengths, turns, strict=True):
                    if length == length and turn == turn:  # all components are written
                        found[id(s)] = (length, turn)
        return self._segments

    def rooms(self) -> dict[int, float]:
        """By the line of moves: half of the shortest way to or from their points [m], where the text shows all ways.

        A way that goes nowhere bounds nothing, and neither does one that is not there: before the first and behind the
        last move of the program.
        """
        if self._rooms is None:
            ways = {
                s: 0.5 * length if length > _NOTHING else inf for s, (length, _) in self.segments().items()
            }
            behind = {id(before): ways.get(id(s), nan) for before, s, _, _ in self.pairs}
            behind |= dict.fromkeys(map(id, self.last), inf)
            found: dict[int, float] = {}
            self._rooms = found
            for move in self.program.statements():
                if type(move) is Move:
                    room = _least(ways.get(id(move), nan), behind.get(id(move), nan))
                    found[move.line] = _least(room, found.get(move.line, inf))
            for line in [line for line, room in found.items() if room != room]:
                del found[line]
        return self._rooms


def _least(one: float, other: float) -> float:
    """The smaller one, nan where one of them is."""
    return min(one, other) if one == one and other == other else nan


def walk_through(program: Program, work: TranslationContext) -> Walk:
    """The walk through a program, which passes that ask about the same one share."""
    if work.walk is None or work.walk.program is not program:
        work.walk = _walked(program, work.symbols(program))
    return work.walk


def _walked(program: Program, symbols: Symbols) -> Walk:
    main = program.main or (program.routines[0].name if program.routines else "")
    counts = Counter(s.routine.casefold() for s in program.statements() if isinstance(s, (Call, StartTask)))
    once = {r.name.casefold(): r for r in program.routines if counts[r.name.casefold()] == 1}
    others = [s for s in program.statements() if not calls_nothing(s)] if once else []
    values = {e.routine.casefold() for s in others for e in expressions_of(s) if type(e) is CallValue}
    inner = {name: r for name, r in once.items() if name not in values and _runs_through(r)}
    walker = _Walker(Walk(program), symbols, inner)
    for routine in sorted(program.routines, key=lambda one: one.name != main):
        if routine.name not in walker.done:
            walker.begin(routine.name == main and not counts[main.casefold()])
            walker.through(routine)
            walker.end()
    return walker.walk


def _runs_through(routine: Routine) -> bool:
    """Whether a routine runs from its first to its last statement."""
    kinds = {type(s) for s in routine.body[:-1]} | {type(s) for s in routine.body[-1:] if type(s) is not End}
    return all(kind in (Move, Call) or kind.__name__ in BETWEEN or kind.__name__ in SETTING for kind in kinds)


@dataclass(slots=True)
class _Walker:
    """Follows a program as far as the text shows where it runs; `inner`: routines that one call leads into and out of.

    `before`: the last move, whose pose is the last one, None where that is not known; `first`: no move came before;
    `whole`: nothing branched so far; `latest`: the last move.
    """

    walk: Walk
    symbols: Symbols
    inner: dict[str, Routine]
    done: set[str] = field(default_factory=set)
    before: Move | None = None
    latest: Move | None = None
    first: bool = False
    whole: bool = False

    def begin(self, main: bool) -> None:
        self.whole = self.first = main
        self.before = self.latest = None

    def end(self) -> None:
        if self.whole and self.latest is not None:
            self.walk.last.append(self.latest)

    def through(self, routine: Routine) -> None:
        self.done.add(routine.name)
        for s in routine.body:
            if type(s) is Move:
                self._move(s, routine.name)
            elif type(s).__name__ not in BETWEEN and not (type(s) is End and s is routine.body[-1]):
                self._other(s)

    def _other(self, s: Statement) -> None:
        if type(s).__name__ in SETTING and not any(type(e) is CallValue for e in expressions_of(s)):
            self.before = self.before if _keeps_systems(s) else None
            return
        called = self.inner.get(s.routine.casefold()) if type(s) is Call else None
        if (
            type(s) is Call
            and called is not None
            and called.name not in self.done
            and not (s.jump or s.condition is not None)
            and not any(type(e) is CallValue for e in expressions_of(s))
        ):
            self.through(called)
            return
        self.before, self.first, self.whole = None, False, False

    def _move(self, s: Move, routine: str) -> None:
        walk, before = self.walk, self.before
        pose = _pose(s, routine, self.symbols)
        if pose is not None and before is not None and _same_place(before, s):
            walk.pairs.append((before, s, len(walk.poses) - 1, len(walk.poses)))
        elif self.first:
            walk.first.append(s)
        if pose is not None:
            walk.poses.append(pose)
        self.before, self.latest, self.first = (None if pose is None else s), s, False


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
