"""Tools and frames that a file declares which is not at hand: a number stands for each until the target names them.

olp.toml beside the program may give their values under [names]; then they are declared with these.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from typing import Any

from olp.ir.expressions import (
    Expression,
    FrameRef,
    Function,
    Item,
    Named,
    NamedArgument,
    Number,
    PositionLiteral,
)
from olp.ir.points import PointKind
from olp.ir.program import Declare, Move, Program, Routine, SetFrame, SetTool, Statement
from olp.ir.transformer import calls_nothing, edited, expressions_of, mapped, sets_numbers
from olp.runtime.assumptions import WrittenPosition
from olp.transpile.context import Elsewhere, TranslationContext, world_of
from olp.transpile.current_position import systems_of
from olp.transpile.frame_names import system_label
from olp.transpile.occurrences import Look
from olp.transpile.symbols import Symbols

_FIELDS = {Move: ("tool", "frame"), SetTool: ("tool",), SetFrame: ("frame",)}
_KINDS = {"tool": "tool", "frame": "user"}


def elsewhere(program: Program, work: TranslationContext) -> Program:
    """Notes them in `work.elsewhere` and puts their numbers in their places."""
    symbols = work.symbols(program)
    if not any(_names_undeclared(symbols, routine, work.look(routine)) for routine in program.routines):
        return program
    named = [
        (routine, s, kind, e)
        for routine in program.routines
        for s in routine.body
        for kind, e in _systems(s)
        if _is_undeclared(symbols, routine, e)
    ]
    own = _Elsewhere(work, program)
    for _, s, kind, e in named:
        own.note(kind, e, s)
    routines = tuple(
        replace(r, body=tuple([own.statement(s, r, symbols) for s in r.body])) for r in program.routines
    )
    return replace(program, routines=routines, data=(*program.data, *own.declared.values()))


def _systems(s: Statement) -> Iterator[tuple[str, Expression]]:
    """The tools and frames that a statement names."""
    for name in _FIELDS.get(type(s), ()):
        e = getattr(s, name)
        if e is not None and type(e) is not FrameRef:
            yield _KINDS[name], e
    if not calls_nothing(s) and not sets_numbers(s):
        for e in expressions_of(s):
            for kind, part in zip(("tool", "user"), systems_of(e) or (), strict=False):
                if part is not None:
                    yield kind, part


def _names_undeclared(symbols: Symbols, routine: Routine, look: Look) -> bool:
    systems = [e for _, e in look.systems if type(e) is not FrameRef]
    systems += [e for _, s in look.rare for _, e in _systems(s)]
    return any(_is_undeclared(symbols, routine, e) for e in systems)


def _is_undeclared(symbols: Symbols, routine: Routine, e: Expression) -> bool:
    name = e.base if isinstance(e, Item) and all(isinstance(i, Number) for i in e.indices) else e
    return isinstance(name, Named) and symbols.find(routine.name, name.name) is None


@dataclass(slots=True)
class _Elsewhere:
    """`numbers`: by kind and label; `declared`: what olp.toml gives a value."""

    work: TranslationContext
    program: Program
    numbers: dict[tuple[str, str], int] = field(default_factory=dict)
    declared: dict[str, Declare] = field(default_factory=dict)
    taken: dict[str, set[int]] = field(default_factory=lambda: {"tool": {0}, "user": {0}})

    def __post_init__(self) -> None:
        mapping = self.work.context.mapping
        for kind, table in (("tool", mapping.tools), ("user", mapping.frames)):
            self.taken[kind].update(int(n) for n in table.values() if n.isdecimal())
        for s in self.program.statements():
            for name in _FIELDS.get(type(s), ()):
                e = getattr(s, name)
                number = e.number if type(e) is FrameRef else e.indices[0] if type(e) is Item else None
                if type(number) is Number:
                    self.taken[_KINDS[name]].add(int(number.value))

    def note(self, kind: str, e: Expression, s: Statement) -> None:
        label = system_label(e)
        if (kind, label) in self.numbers or label in self.declared:
            return
        if isinstance(e, Named) and (value := self._given(e.name)) is not None:
            type_ = "tool" if kind == "tool" else "frame"
            self.declared[label] = Declare(0, e.name, type_, value, storage="constant", shared=True)
            return
        wanted = self.work.mapped_system(kind, label)
        if not wanted and self.work.target_conventions.controller_names:
            return  # which names them as the source does
        number = int(wanted) if wanted.isdecimal() else self._free(kind)
        self.numbers[(kind, label)] = number
        self.work.elsewhere[(kind, number)] = Elsewhere(label, s, wanted)

    def _free(self, kind: str) -> int:
        number = next(n for n in range(1, 1000) if n not in self.taken[kind])
        self.taken[kind].add(number)
        return number

    def _given(self, name: str) -> PositionLiteral | None:
        given = world_of(self.work.source, self.work.robot).assumptions.names.get(name.casefold())
        if not isinstance(given, WrittenPosition) or given.state.kind is not PointKind.POSE:
            return None
        return PositionLiteral("pose", given.values[:6])

    def statement(self, s: Statement, routine: Routine, symbols: Symbols) -> Statement:
        changes: dict[str, Any] = {}
        for name in _FIELDS.get(type(s), ()):
            e = getattr(s, name)
            if e is not None and (new := self._numbered(_KINDS[name], e, routine, symbols)) is not e:
                changes[name] = new
        if changes:
            s = edited(s, changes) if isinstance(s, Move) else replace(s, **changes)
        return s if calls_nothing(s) else mapped(s, lambda e: self._reading(e, routine, symbols))

    def _reading(self, e: Expression, routine: Routine, symbols: Symbols) -> Expression:
        """A reading of the position that names such a tool or frame."""
        if not isinstance(e, Function) or systems_of(e) is None:
            return e
        arguments: list[Expression] = []
        for a in e.arguments:
            if isinstance(a, NamedArgument) and a.value is not None:
                kind = "tool" if a.name.casefold() == "tool" else "user"
                a = replace(a, value=self._numbered(kind, a.value, routine, symbols))
            arguments.append(a)
        return replace(e, arguments=tuple(arguments))

    def _numbered(self, kind: str, e: Expression, routine: Routine, symbols: Symbols) -> Expression:
        if type(e) is FrameRef or not _is_undeclared(symbols, routine, e):
            return e
        number = self.numbers.get((kind, system_label(e)))
        return e if number is None else FrameRef(kind, Number(number))
