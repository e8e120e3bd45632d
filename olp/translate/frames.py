"""Tools and frames as the target names them: by number with the statements that set their values, by name, or folded.

INFORM and FANUC number them; KRL numbers or names them; RAPID names them; URScript has one tool and the base.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any, Final, TypeVar

from olp.expression import Expression, FrameRef, Function, Item, Named, Number, PositionLiteral
from olp.geometry import Pose
from olp.program import (
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
from olp.translate.here import HERE, NAMING, seen_in, systems_of
from olp.translate.known import system_of
from olp.translate.records import literal_of, pose_of_literal
from olp.translate.rewrite import calls_nothing, edited, mapped
from olp.translate.symbols import Symbols, kind_of_value, symbols_of
from olp.translate.work import Fate, Work

T = TypeVar("T")
_BASE: Final = FrameRef("base")
_FLANGE: Final = FrameRef("tool", Number(0))
_ZERO: Final = PositionLiteral("pose", (0.0,) * 6)
_FAR: Final = (
    10.0  # [m] from a frame's origin to the points that define it: rounding them turns it by nothing
)
_NUMBERS: Final[Mapping[str, int]] = {"tool": 63, "user": 63}
_NUMBERED: Final[Mapping[str, Mapping[str, int]]] = {
    "inform": {"tool": 63, "user": 63},
    "tp": {"tool": 10, "user": 9},
}


@dataclass(slots=True)
class _Systems:
    """Tools ("tool") and frames ("user"). `numbers`: of a name or value; `values`: to be set, by kind and number."""

    work: Work
    symbols: Symbols
    routine: str = ""
    numbers: dict[tuple[str, Expression], int] = field(default_factory=dict)
    taken: dict[str, set[int]] = field(default_factory=lambda: {"tool": {0}, "user": {0}})
    values: dict[tuple[str, int], PositionLiteral] = field(default_factory=dict)
    made: dict[tuple[str, Expression], Named] = field(default_factory=dict)
    declared: list[Declare] = field(default_factory=list)
    known: dict[tuple[object, ...], Expression] = field(default_factory=dict)  # what moves' references became
    same: dict[int, tuple[Expression, str, Expression]] = field(
        default_factory=dict
    )  # by the id of the first
    counted: set[tuple[str, str]] = field(
        default_factory=set
    )  # variables that hold a number of a tool or frame

    # --- numbers ----------------------------------------------------------------------------------------

    def numbered(self, kind: str, e: Expression, s: Statement) -> Expression:
        """A tool or frame by number."""
        if isinstance(e, FrameRef):
            if e.kind != kind or e.number is None:
                return e
            ref = self._mapped_number(kind, e)
            known = self._set_once(kind, e)
            if known is not None and isinstance(ref.number, Number) and self.work.context.mapping.set_values:
                self.values.setdefault((kind, int(ref.number.value)), known)
            return ref
        if isinstance(e, Named):
            symbol = self.symbols.find(self.routine, e.name)
            if symbol is not None and symbol.type in ("integer", "real"):
                return FrameRef(kind, e)
            if (
                symbol is not None
                and not symbol.is_fixed
                and symbol.type in ("tool", "frame")
                and symbol.assigned
            ):
                return self._varying(kind, e, s)
        value = self.symbols.fixed_value(self.routine, e)
        if not isinstance(value, PositionLiteral):
            self.work.lose(s, Fate.REFUSED, kind, "the tool or frame is computed while the program runs")
            return FrameRef(kind, Number(0))
        if kind == "user" and not any(value.values):
            return _BASE
        return FrameRef(kind, Number(self._number(kind, e if isinstance(e, (Named, Item)) else value, value)))

    def _mapped_number(self, kind: str, e: FrameRef) -> FrameRef:
        wanted = self._map(kind).get(_shown(e))
        if wanted is not None and wanted.isdecimal():
            self.work.names[(_words(kind), _shown(e))] = wanted
            return FrameRef(kind, Number(int(wanted)))
        if isinstance(e.number, Number):
            self.taken[kind].add(int(e.number.value))
        return e

    def _set_once(self, kind: str, e: FrameRef) -> PositionLiteral | None:
        """The value that the program itself gives to a numbered tool or frame, once and for all."""
        return self.work.systems.get((kind, int(e.number.value))) if isinstance(e.number, Number) else None

    def _map(self, kind: str) -> Mapping[str, str]:
        mapping = self.work.context.mapping
        return mapping.tools if kind == "tool" else mapping.frames

    def _number(self, kind: str, key: Expression, value: PositionLiteral | None) -> int:
        number = self.numbers.get((kind, key))
        if number is None:
            shown = _shown(key)
            wanted = self._map(kind).get(shown, "")
            number = int(wanted) if wanted.isdecimal() else _own_number(key)
            if number in self.taken[kind] and not wanted.isdecimal():
                number = next(n for n in range(1, 1000) if n not in self.taken[kind])
            largest = _NUMBERED.get(self.work.target, _NUMBERS)[kind]
            if number > largest:
                self.work.lose(0, Fate.REFUSED, _words(kind), f"more than {largest} {_words(kind)}s")
            self.numbers[(kind, key)] = number
            self.taken[kind].add(number)
            self.work.names[(_words(kind), shown)] = str(number)
            if value is not None and self.work.context.mapping.set_values:
                self.values[(kind, number)] = value
        return number

    def _varying(self, kind: str, e: Named, s: Statement) -> Expression:
        """A name whose value changes: a number of its own, which is set anew, or a variable that holds a number."""
        symbol = self.symbols.find(self.routine, e.name)
        assert symbol is not None
        if symbol.storage == "modal" and self.work.target == "inform":
            self.work.lose(
                s, Fate.REFUSED, _words(kind), f"which {_words(kind)} holds depends on the way to this move"
            )
            return FrameRef(kind, Number(0))
        value = symbol.value if isinstance(symbol.value, PositionLiteral) else None
        return FrameRef(kind, Number(self._number(kind, e, value)))

    # --- names ------------------------------------------------------------------------------------------

    def named(self, kind: str, e: Expression, s: Statement) -> Expression:
        """A tool or frame by name, or by number where KRL has one."""
        if isinstance(e, PositionLiteral):
            if kind == "user" and not any(e.values):
                return _BASE
            return self._made(kind, e, "tool" if kind == "tool" else "frame", e)
        if isinstance(e, Item):
            literal = self.symbols.fixed_value(self.routine, e)
            if isinstance(literal, PositionLiteral):
                return self._made(kind, e, f"{_words(kind)}_{_own_number(e)}", literal)
        if not isinstance(e, FrameRef) or e.kind != kind or e.number is None:
            return e
        if not isinstance(e.number, Number):
            if self.work.target != "krl":
                self.work.lose(
                    s,
                    Fate.REFUSED,
                    _words(kind),
                    f"the {_words(kind)}'s number is computed while the program runs",
                )
            return e
        number = int(e.number.value)
        wanted = self._map(kind).get(str(number))
        if wanted is not None:
            self.work.names[(_words(kind), str(number))] = wanted
            return FrameRef(kind, Number(int(wanted))) if wanted.isdecimal() else Named(wanted)
        stem = f"{_words(kind)}_{number}"
        known = self.work.systems.get((kind, number))
        if known is not None:
            return self._made(kind, e, stem, known)
        if self.work.target == "krl":
            return e
        if number == 0:
            return _BASE if kind == "user" else e
        if (made := self.made.get((kind, e))) is not None:
            return made
        return self._made(kind, e, stem, literal_of(self._known(kind, number)))

    def _known(self, kind: str, number: int) -> Pose:
        cell = self.work.cell()
        if kind == "tool":
            found = cell.tools.get(number)
            if found is not None:
                return found.pose
        elif number in cell.user_frames:
            return cell.user_frames[number]
        says = f"the values of {_words(kind)} {number} are not in the program: zeros are written"
        self.work.lose(0, Fate.APPROXIMATED, _words(kind), says)
        self.work.ask("set these values, which are zeros now", f"{_words(kind)} {number}")
        return Pose.identity()

    def _made(self, kind: str, key: Expression, stem: str, value: PositionLiteral) -> Named:
        name = self.made.get((kind, key))
        if name is None:
            name = self.made[(kind, key)] = Named(
                self.work.helper(stem) if kind == "position" else self.work.fresh(stem)
            )
            self.declared.append(
                Declare(0, name.name, _words(kind), value, storage="persistent", shared=True)
            )
            self.work.names[(_words(kind), _shown(key))] = name.name
        return name

    # --- statements -------------------------------------------------------------------------------------

    def move(self, s: Move) -> Move:
        changes: dict[str, Any] = {}
        if s.tool is not None and (tool := self._said("tool", s.tool, s)) is not s.tool:
            changes["tool"] = tool
        frame = s.frame
        base = type(frame) is FrameRef and frame.kind == "base" and frame.number is None
        if frame is not None and not base and (frame := self._said("user", frame, s)) is not s.frame:
            changes["frame"] = frame
        if self.work.target in NAMING and not calls_nothing(s):
            targets = self._placed(s, s.targets)
            if targets is not s.targets:
                changes["targets"] = targets
        if self.work.target == "urscript":
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
        said = self.numbered(kind, e, s) if self.work.target in _NUMBERED else self.named(kind, e, s)
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
        changes["frame"] = _BASE
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
            if self.work.target != "urscript":
                return seen_in(tool, frame)
            if frame is None or frame == _BASE:
                return HERE
            return Function("pose-product", (Function("pose-inverse", (frame,)), HERE))

        return mapped(node, change)

    def assigned(self, s: Assign) -> list[Statement]:
        """An assignment to a name that stands for a numbered tool or frame sets that one's values."""
        key = system_of(s.target)
        if key is not None and self.work.target in _NUMBERED:
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
        if self.work.target != "inform":
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
            return self._made("position", literal, f"{_words(kind)}{number}_value", literal)
        return value

    def routine_of(self, routine: Routine) -> Routine:
        self.routine = routine.name
        self.same.clear()
        return replace(routine, body=tuple([self.move(s) if type(s) is Move else s for s in routine.body]))

    def routine_with_values(self, routine: Routine, main: bool) -> Routine:
        self.routine = routine.name
        rows: list[Statement] = []
        for s in routine.body:
            if self.work.target in NAMING and not isinstance(s, Move):
                s = self._placed(s, s)
            if isinstance(s, Assign):
                rows += self.assigned(s)
            elif not (
                isinstance(s, Declare) and s.type in ("tool", "frame") and self.work.target in _NUMBERED
            ):
                rows.append(s)
        if main and self.work.target in _NUMBERED:
            rows[_place(rows) : _place(rows)] = self._all_values()
        return replace(routine, body=tuple(rows))

    def _all_values(self) -> list[Statement]:
        rows: list[Statement] = []
        for (kind, number), value in self.values.items():
            rows += self.setting(kind, number, value, 0)
        return [Comment(0, "tools and frames of the translated program"), *rows] if rows else []


def frames(program: Program, work: Work) -> Program:
    """Every move's tool and frame as the target says them, and their values where it has none yet."""
    systems = _Systems(work, symbols_of(program))
    routines = tuple(systems.routine_of(routine) for routine in program.routines)
    data = program.data
    main = program.main or (routines[0].name if routines else "")
    routines = tuple(systems.routine_with_values(routine, routine.name == main) for routine in routines)
    if work.target in _NUMBERED:
        data = tuple(declare for declare in data if declare.type not in ("tool", "frame"))
        routines = tuple(
            replace(r, data=tuple(d for d in r.data if d.type not in ("tool", "frame"))) for r in routines
        )
    return replace(program, routines=routines, data=(*data, *systems.declared))


def _place(rows: list[Statement]) -> int:
    return next((at for at, s in enumerate(rows) if not isinstance(s, (Begin, Declare))), len(rows))


def _own_number(e: Expression) -> int:
    """The number that an element of an array of tools or frames has; 0 for all else, which nothing may have."""
    index = e.indices[0] if isinstance(e, Item) and len(e.indices) == 1 else None
    return int(index.value) if isinstance(index, Number) else 0


def _words(kind: str) -> str:
    return {"user": "frame"}.get(kind, kind)


def _shown(e: Expression) -> str:
    if isinstance(e, Named):
        return e.name
    if isinstance(e, FrameRef) and isinstance(e.number, Number):
        return str(int(e.number.value))
    if isinstance(e, Item):
        return f"{_shown(e.base)}[{_own_number(e)}]"
    if isinstance(e, PositionLiteral):
        return " ".join(f"{v:g}" for v in e.values)
    return str(e)
