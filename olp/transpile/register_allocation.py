"""Names become numbers: variables and registers by their kind, points by the moves that go there."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, Final

from olp.ir.expressions import (
    Binary,
    Element,
    Expression,
    Member,
    Named,
    Number,
    PositionLiteral,
    RecordLiteral,
    SignalState,
    Text,
    Variable,
)
from olp.ir.program import (
    Assign,
    Begin,
    Case,
    Comment,
    ControlGroup,
    Declare,
    DefineFrame,
    ElseIf,
    End,
    Move,
    Program,
    Routine,
    Statement,
    Until,
    While,
)
from olp.ir.transformer import edited, is_usual, is_written_out, mapped
from olp.languages.vendor import language_of
from olp.transpile.arrays import largest_indices
from olp.transpile.context import Fate, TranslationContext
from olp.transpile.point_table import Place, place_of, table
from olp.transpile.position_registers import MEMBERS, PositionNumbers, counts_of
from olp.transpile.symbols import kind_of_value, symbols_of

_NO_SYSTEMS: Final = {"tool": None, "frame": None}
_HEADS: Final = (While, Until, ElseIf, Case)  # before which nothing can run each time
_VALUES: Final = (
    "speed", "blend", "acceleration", "deceleration", "rate", "turn", "offset", "tool_offset", "until"
)  # fmt: skip


def number(program: Program, work: TranslationContext) -> Program:
    """For INFORM and FANUC: no name of a variable or point is left."""
    own = _Numbers(work, symbols_of(program), largest_indices(program, work))
    main = program.main or (program.routines[0].name if program.routines else "")
    own.note_places(program)
    bodies = [(routine, own.body(routine)) for routine in program.routines]
    routines = []
    for routine, body in bodies:
        if own.registers.framed and not (body and isinstance(body[0], Begin)):
            body.insert(0, Begin(0))
        if own.registers.framed and not isinstance(body[-1], End):
            body.append(End(0))
        if routine.name == main:
            at = 1 if body and isinstance(body[0], Begin) else 0
            body[at:at] = own.prologue(program)
        routines.append(own.routine(routine, tuple(body), routine.name == main))
    return replace(program, routines=tuple(routines), data=())


@dataclass(slots=True)
class _Numbers(PositionNumbers):
    """Statements and routines with numbers."""

    # --- statements -------------------------------------------------------------------------------------

    def body(self, routine: Routine) -> list[Statement]:
        self.routine_name = routine.name
        rows: list[Statement] = []
        for s in routine.body:
            before: list[Statement] = []
            self.before, self.line, self.indices = None if type(s) in _HEADS else before, s.line, 0
            new = [self._move(s, before)] if type(s) is Move else self._statement(s, before)
            if before:
                rows += before
            rows += new
        return rows

    def _statement(self, s: Statement, before: list[Statement]) -> list[Statement]:
        match s:
            case Declare():
                return []
            case Assign():
                return self._assign(s, before)
            case DefineFrame(points=points):
                return [replace(s, points=tuple(self.position(p, (0, None), before, s.line) for p in points))]  # type: ignore[misc]
            case _:
                return [mapped(s, self._change)]

    def _move(self, s: Move, before: list[Statement]) -> Move:
        place = place_of(s)
        if is_written_out(s):
            (target,) = s.targets
            changes: dict[str, Any] = {"targets": (self._target(target, place, before, s),)}
            return edited(s, changes | _NO_SYSTEMS if self.registers.steps else changes)
        changes = {"targets": tuple([self._target(t, place, before, s) for t in s.targets])}
        if s.via is not None:
            changes["via"] = self._target(s.via, place, before, s)
        for name in ("speed", "blend") if is_usual(s) else _VALUES:
            old = getattr(s, name)
            if old is not None and (new := mapped(old, self._change)) is not old:
                changes[name] = new
        if self.registers.steps:
            changes |= _NO_SYSTEMS
        return edited(s, changes)

    def _target(self, e: Expression, place: Place, before: list[Statement], s: Move) -> Expression:
        fixed = self._fixed(e)
        if fixed is not None:
            fixed = self._configured(fixed)
            if s.relative is not None:
                return self.constant(fixed, place) if self.registers.steps else fixed
            return self.taught(fixed, place, e.name if isinstance(e, Named) else "")
        return self.position(e, place, before, s.line)

    def _assign(self, s: Assign, before: list[Statement]) -> list[Statement]:
        kind = kind_of_value(self.symbols, "", s.value)
        if kind in ("position", "joints", "tool", "frame"):
            place = self.places.get(s.target.name, (0, None)) if isinstance(s.target, Named) else (0, None)
            value = self.position(s.value, place, before, s.line)
            return [replace(s, target=mapped(s.target, self._change), value=value)]
        if self.registers.elements and isinstance(s.target, Member):
            if s.target.name not in MEMBERS:
                language = language_of(self.work.target)
                says = f"{language} has no data with an element '{s.target.name}' that can be set on its own"
                self.work.lose(s, Fate.REFUSED, "element", says)
                return [s]
            return self._set_element(s)
        value = mapped(s.value, self._change)
        match value:
            case SignalState(on):
                value = Number(int(on))
            case Binary("*", Member(base, name), Number(factor)) if (
                self.registers.elements and factor in (1000, 10_000) and name in MEMBERS
            ):
                value = Element(base, Number(MEMBERS.index(name) + 1))  # type: ignore[arg-type]
        return [replace(s, target=mapped(s.target, self._change), value=value)]

    def _set_element(self, s: Assign) -> list[Statement]:
        assert isinstance(s.target, Member)
        at = MEMBERS.index(s.target.name) + 1
        base: Any = mapped(s.target.base, self._change)
        scale = 1000 if at <= 3 else 10_000
        value = mapped(s.value, self._change)
        count = self.variable(Named(self._counter()))
        counts = counts_of(value, scale)
        return [Assign(s.line, count, counts), Assign(s.line, Element(base, Number(at)), count, s.comment)]

    # --- the whole program ------------------------------------------------------------------------------

    def prologue(self, program: Program) -> list[Statement]:
        """Initial values, and which name is which number."""
        rows: list[Statement] = []
        comments: list[Statement] = []
        for declare in (d for d in program.data if d.name in self.numbers):
            symbol = self.symbols.find("", declare.name)
            if self.registers.comments:
                comments.append(Comment(0, f"{self.work.names[('variable', declare.name)]} {declare.name}"))
            if declare.value is None or declare.name in self.work.registers or symbol is None:
                continue
            rows += self._begins(declare.name, self.variable(Named(declare.name)), declare.value)
        return [*comments, *rows]

    def _begins(self, name: str, target: Variable, value: Expression) -> list[Statement]:
        """What gives a variable, or the elements of an array, the value that it begins with."""
        match value:
            case PositionLiteral() if self.registers.steps:
                assert isinstance(target.index, Number)
                self.initial[int(target.index.value)] = (value, self.places.get(name, (0, None)))
                return []
            case PositionLiteral() | Number() | Text():
                return [Assign(0, target, value)]
            case SignalState(on):
                return [Assign(0, target, Number(int(on)))]
            case RecordLiteral(_, members) if all(not member for member, _ in members):
                assert isinstance(target.index, Number)
                first = int(target.index.value)
                rows: list[Statement] = []
                for at, (_, one) in enumerate(members):
                    rows += self._begins(name, replace(target, index=Number(first + at), name=""), one)
                return rows
        return []

    def routine(self, routine: Routine, body: tuple[Statement, ...], main: bool) -> Routine:
        rows = [
            (True, at, literal, place) for (literal, place), at in self.points.get(routine.name, {}).items()
        ]
        if main:
            rows += [(False, at, literal, place) for at, (literal, place) in sorted(self.initial.items())]
        details = dict(routine.details) if self.work.source.vendor == self.work.target else {}
        if not self.registers.comments:
            details |= {
                self.registers.point.format(number=at): name
                for (name_, at), name in self.names.items()
                if name_ == routine.name and name
            }
        groups = (ControlGroup(("RB1",)),) if rows or main else ()
        return replace(
            routine,
            body=body,
            points=table(rows),
            details=details,
            groups=groups if self.registers.framed else (),
        )
