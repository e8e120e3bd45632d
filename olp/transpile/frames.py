"""Tools and frames as the target names them: by number with the statements that set their values, by name, or folded.

INFORM and FANUC number them; KRL numbers or names them; RAPID names them; URScript has one tool and the base.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Any, Final, TypeVar

from olp.ir.expressions import Expression, FrameRef, Function, Named, Number, PositionLiteral
from olp.ir.program import (
    Assign,
    Begin,
    Comment,
    Declare,
    DefineFrame,
    Move,
    Program,
    Routine,
    Statement,
)
from olp.ir.transformer import edited, mapped
from olp.robots.geometry import Pose
from olp.transpile.constant_frames import system_of
from olp.transpile.context import Fate, TranslationContext
from olp.transpile.current_position import HERE, seen_in, systems_of
from olp.transpile.frame_names import BASE, SystemNames, system_words
from olp.transpile.occurrences import with_rows
from olp.transpile.records import literal_of, pose_of_literal
from olp.transpile.symbols import kind_of_value

T = TypeVar("T")
_FLANGE: Final = FrameRef("tool", Number(0))
_ZERO: Final = PositionLiteral("pose", (0.0,) * 6)
_FAR: Final = (
    10.0  # [m] from a frame's origin to the points that define it: rounding them turns it by nothing
)


@dataclass(slots=True)
class _Systems(SystemNames):
    """Statements with the target's tools and frames. `known`: what moves' references became."""

    known: dict[tuple[object, ...], Expression] = field(default_factory=dict)
    same: dict[int, tuple[Expression, str, Expression]] = field(
        default_factory=dict
    )  # by the id of the first
    reading: set[int] = field(default_factory=set)  # ids of the moves that may read where the arm stands

    def move(self, s: Move) -> Move:
        changes: dict[str, Any] = {}
        if s.tool is not None and (tool := self._said("tool", s.tool, s)) is not s.tool:
            changes["tool"] = tool
        frame = s.frame
        base = type(frame) is FrameRef and frame.kind == "base" and frame.number is None
        if frame is not None and not base and (frame := self._said("user", frame, s)) is not s.frame:
            changes["frame"] = frame
        if id(s) in self.reading:
            targets = self._placed(s, s.targets)
            if targets is not s.targets:
                changes["targets"] = targets
        if self.work.limits.pose_functions:
            self._folded(s, frame, changes)
        return edited(s, changes) if changes else s

    def _said(self, kind: str, e: Expression, s: Statement) -> Expression:
        """A tool or frame as the target says it; moves name few of them, over and over."""
        same = self.same.get(id(e))
        if same is not None and same[0] is e and same[1] == kind:
            return same[2]
        key: tuple[object, ...] | None = None
        if type(e) is Named:
            key = (kind, self.routine, e.name)
        elif type(e) is FrameRef and type(e.number) is Number:
            key = (kind, e.kind, e.number.value)
        known = None if key is None else self.known.get(key)
        if known is not None:
            said = e if known == e else known
            self.same[id(e)] = (e, kind, said)
            return said
        losses = len(self.work.losses)
        said = self.numbered(kind, e, s) if not self.work.limits.named_frames else self.named(kind, e, s)
        if key is not None and len(self.work.losses) == losses:
            self.known[key] = said
        return e if said == e else said

    def _folded(self, s: Move, frame: Expression | None, changes: dict[str, Any]) -> None:
        """URScript: the target seen from the base."""
        tool = changes.get("tool", s.tool)
        if type(tool) is FrameRef and tool == _FLANGE:
            changes["tool"] = _ZERO
        if frame is None or (isinstance(frame, FrameRef) and frame.kind in ("base", "robot")):
            return
        if isinstance(frame, FrameRef):
            self.work.lose(s, Fate.REFUSED, "frame", "a frame whose values are not known here")
            return
        changes["frame"] = BASE
        targets = changes.get("targets", s.targets)
        changes["targets"] = tuple([self._in_base(frame, target) for target in targets])
        if s.via is not None:
            changes["via"] = self._in_base(frame, s.via)

    def _in_base(self, frame: Expression, target: Expression) -> Expression:
        if type(target) is Function and target.name == "inverse" and len(target.arguments) == 2:
            return replace(target, arguments=(self._in_base(frame, target.arguments[0]), target.arguments[1]))
        if kind_of_value(self.symbols, self.routine, target) == "joints":
            return target
        return Function("pose-product", (frame, target))

    def _placed(self, s: Statement, node: T) -> T:
        """Readings of the position as the target says them: RAPID names tool and frame, URScript has the base."""

        def change(e: Expression) -> Expression:
            asked = systems_of(e)
            if asked is None:
                return e
            tool, frame = asked
            tool = None if tool is None else self._said("tool", tool, s)
            frame = None if frame is None else self._said("user", frame, s)
            if not self.work.limits.pose_functions:
                return seen_in(tool, frame)
            if frame is None or frame == BASE:
                return HERE
            return Function("pose-product", (Function("pose-inverse", (frame,)), HERE))

        return mapped(node, change)

    def assigned(self, s: Assign) -> list[Statement]:
        """An assignment to a name that stands for a numbered tool or frame sets that one's values."""
        key = system_of(s.target)
        if key is not None and not self.work.limits.named_frames:
            ref = self.numbered(key[0], FrameRef(key[0], Number(key[1])), s)
            if isinstance(ref, FrameRef) and isinstance(ref.number, Number):
                return self.setting(key[0], int(ref.number.value), s.value, s.line, s.comment)
        if key is not None:
            target = self.named(key[0], FrameRef(key[0], Number(key[1])), s)
            return [replace(s, target=target)]
        if isinstance(s.target, Named):
            for kind in ("tool", "user"):
                number = self.numbers.get((kind, s.target))
                if number is not None:
                    return self.setting(kind, number, s.value, s.line, s.comment)
        return [s]

    def setting(
        self, kind: str, number: int, value: Expression, line: int, comment: str = ""
    ) -> list[Statement]:
        """The statements that set the values of a numbered tool or frame."""
        if not self.work.limits.frame_functions:
            return [
                Assign(line, FrameRef(kind, Number(number)), self._position(kind, number, value), comment)
            ]
        if kind == "tool":
            target = Function("tool-data", (Number(number),))
            return [Assign(line, target, self._position(kind, number, value), comment)]
        literal = self.symbols.fixed_value(self.routine, value)
        if not isinstance(literal, PositionLiteral):
            self.work.lose(line, Fate.REFUSED, "frame", "a frame that is computed while the program runs")
            return []
        pose = pose_of_literal(literal)
        corners = [
            pose,
            *(Pose(pose.apply(point), pose.rotation) for point in ((_FAR, 0, 0), (_FAR, _FAR, 0))),
        ]
        points = []
        for corner, suffix in zip(corners, ("o", "x", "xy"), strict=True):
            points.append(
                self._made("position", literal_of(corner), f"frame{number}_{suffix}", literal_of(corner))
            )
        return [DefineFrame(line, FrameRef(kind, Number(number)), tuple(points), comment=comment)]  # type: ignore[arg-type]

    def _position(self, kind: str, number: int, value: Expression) -> Expression:
        literal = self.symbols.fixed_value(self.routine, value)
        if isinstance(literal, PositionLiteral):
            return self._made("position", literal, f"{system_words(kind)}{number}_value", literal)
        return value

    def routine_of(self, routine: Routine) -> Routine:
        self.routine = routine.name
        self.same.clear()
        if self.work.limits.position_read_in == "named":
            self.reading = {id(s) for _, s in self.work.look(routine).rare}
        return with_rows(routine, [self.move(s) if type(s) is Move else s for s in routine.body])

    def routine_with_values(self, routine: Routine, main: bool) -> Routine:
        self.routine = routine.name
        rows: list[Statement] = []
        for s in routine.body:
            if type(s) is Move:
                rows.append(s)
                continue
            if self.work.limits.position_read_in == "named":
                s = self._placed(s, s)
            if isinstance(s, Assign):
                rows += self.assigned(s)
            elif not (
                isinstance(s, Declare) and s.type in ("tool", "frame") and not self.work.limits.named_frames
            ):
                rows.append(s)
        if main and not self.work.limits.named_frames:
            rows[_place(rows) : _place(rows)] = self._all_values()
        return with_rows(routine, rows)

    def _all_values(self) -> list[Statement]:
        rows: list[Statement] = []
        for (kind, number), value in self.values.items():
            rows += self.setting(kind, number, value, 0)
        return [Comment(0, "tools and frames of the translated program"), *rows] if rows else []


def frames(program: Program, work: TranslationContext) -> Program:
    """Every move's tool and frame as the target says them, and their values where it has none yet."""
    systems = _Systems(work, work.symbols(program))
    systems.note_numbers(program)
    routines = tuple(systems.routine_of(routine) for routine in program.routines)
    data = program.data
    main = program.main or (routines[0].name if routines else "")
    routines = tuple(systems.routine_with_values(routine, routine.name == main) for routine in routines)
    if not work.limits.named_frames:
        data = tuple(declare for declare in data if declare.type not in ("tool", "frame"))
        routines = tuple(
            replace(r, data=tuple(d for d in r.data if d.type not in ("tool", "frame"))) for r in routines
        )
    return replace(program, routines=routines, data=(*data, *systems.declared))


def _place(rows: list[Statement]) -> int:
    return next((at for at, s in enumerate(rows) if not isinstance(s, (Begin, Declare))), len(rows))
