"""What occurs in a routine, found in one walk that all passes share: nearly all statements are plain.

A plain statement is a move to a place that is named, numbered or written out, with nothing rare beside it, or a
setting of modal speeds and blends to numbers: most passes have nothing to do there.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence, Set
from dataclasses import dataclass, field, replace
from operator import is_
from typing import Any, TypeVar

from olp.ir.expressions import Expression, Named, Number, PositionLiteral
from olp.ir.program import Declare, Disabled, Move, Program, Routine, Statement, Wait
from olp.ir.transformer import expressions_of, gather, is_plain, note_names

Part = TypeVar("Part", Program, Routine)
Kind = TypeVar("Kind")


@dataclass(slots=True)
class Look:
    """`rare`: the statements that are not plain, with their places in `body`; `plain`: the moves that are."""

    body: tuple[Statement, ...]
    rare: list[tuple[int, Statement]] = field(default_factory=list)
    plain: list[Move] = field(default_factory=list)
    _expressions: list[Expression] | None = None
    _systems: list[tuple[str, Expression]] | None = None
    _values: list[Expression] | None = None
    _named: Set[str] | None = None

    def __post_init__(self) -> None:
        plain, rare = self.plain, self.rare
        for at, s in enumerate(self.body):
            if not is_plain(s):
                rare.append((at, s))
            elif type(s) is Move:
                plain.append(s)

    def handled(self) -> list[Statement]:
        """Where a wait has a limit, what handlers may do about it."""
        if not any(isinstance(s, Wait) and s.timeout is not None for _, s in self.rare):
            return []
        return [inner for _, s in self.rare if isinstance(s, Disabled) for inner in s.means]

    def of_kind(self, *kinds: type[Kind]) -> list[Kind]:
        """The statements of these classes, none of which is a move or sets modal speeds or blends."""
        return [s for _, s in self.rare if isinstance(s, kinds)]

    @property
    def expressions(self) -> list[Expression]:
        """All expressions in what is not plain."""
        if self._expressions is None:
            self._expressions = [e for _, s in self.rare for e in expressions_of(s)]
        return self._expressions

    @property
    def systems(self) -> list[tuple[str, Expression]]:
        """The tools ("tool") and frames ("user") of plain moves; moves share them, and each object is there once."""
        if self._systems is None:
            tools = {id(s.tool): s.tool for s in self.plain}
            frames = {id(s.frame): s.frame for s in self.plain}
            found = [("tool", e) for e in tools.values() if e is not None]
            self._systems = found + [("user", e) for e in frames.values() if e is not None]
        return self._systems

    @property
    def values(self) -> list[Expression]:
        """All expressions in the tools, frames and computed speeds and blends of plain moves."""
        if self._values is None:
            self._values = []
            for _, e in self.systems:
                gather(e, self._values)
            for s in self.plain:
                speed, blend = s.speed, s.blend
                if speed is not None and type(speed.value.written) is not Number:
                    gather(speed.value.written, self._values)
                if blend is not None and blend.value is not None and type(blend.value.written) is not Number:
                    gather(blend.value.written, self._values)
        return self._values

    def direct(self) -> list[Move]:
        """Plain moves to places that are not named, but written out or numbered."""
        return [s for s in self.plain if type(s.targets[0]) is not Named or len(s.targets) > 1]

    def unnamed(self) -> list[Move]:
        """All moves that go to anything but a name, in order of writing."""
        return [
            s
            for s in self.body
            if type(s) is Move and (type(s.targets[0]) is not Named or len(s.targets) > 1)
        ]

    def names(self) -> set[str]:
        """The variables that the statements name."""
        return {*self.names_in_moves()} | {e.name for e in self.expressions if type(e) is Named}

    def names_in_moves(self) -> Set[str]:
        """The variables that plain moves name."""
        if self._named is None:
            found = {s.targets[0].name for s in self.plain if type(s.targets[0]) is Named}
            others = list(self.values)
            for s in self.direct():
                gather(s.targets, others)
            self._named = found.union([e.name for e in others if type(e) is Named])
        return self._named


def changed_rare(routine: Routine, look: Look, change: Callable[[Statement], Statement]) -> Routine:
    """`routine` with `change` done to every statement that is not plain; the same object where nothing changes."""
    rows: list[Statement] | None = None
    for at, s in look.rare:
        new = change(s)
        if new is not s:
            rows = rows or list(look.body)
            rows[at] = new
    return routine if rows is None else replace(routine, body=tuple(rows))


def with_rare_rows(routine: Routine, look: Look, change: Callable[[Statement], list[Statement]]) -> Routine:
    """`routine` with what `change` makes of every statement that is not plain; the same where nothing changes."""
    rows: list[Statement] = []
    done = 0
    for at, s in look.rare:
        new = change(s)
        if len(new) != 1 or new[0] is not s:
            rows += look.body[done:at]
            rows += new
            done = at + 1
    return replace(routine, body=(*rows, *look.body[done:])) if done else routine


def names_of_data(data: Iterable[Declare]) -> set[str]:
    """The variables that the values and sizes of data name."""
    found: set[str] = set()
    for d in data:
        if d.sizes or type(d.value) is not PositionLiteral:
            note_names(d, found)
    return found


def with_rows(routine: Routine, rows: Sequence[Statement]) -> Routine:
    """`routine` with these statements; the same object where they are those that it has."""
    if len(rows) == len(routine.body) and all(map(is_, rows, routine.body)):
        return routine
    return replace(routine, body=tuple(rows))


def with_routines(program: Program, routines: Iterable[Routine]) -> Program:
    """`program` with these routines; the same object where they are those that it has."""
    routines = tuple(routines)
    if len(routines) == len(program.routines) and all(map(is_, routines, program.routines)):
        return program
    return replace(program, routines=routines)


def with_same_parts(program: Program, old: Program) -> Program:
    """`program` with the routines, statements and data of `old` that are the same: what was found in them holds on."""
    if program is old:
        return program
    before = {r.name: r for r in old.routines}
    routines = tuple([_with_same(r, before.get(r.name, r)) for r in program.routines])
    return _with_same(replace(program, routines=routines), old)


def _with_same(new: Part, old: Part) -> Part:
    """`new` with the tuples of `old` that hold the same objects; `old` where nothing else differs."""
    changes: dict[str, Any] = {}
    differs = False
    for name in new.__dataclass_fields__:
        one, other = getattr(new, name), getattr(old, name)
        if one is other:
            continue
        if type(one) is tuple and len(one) == len(other) and all(map(is_, one, other)):
            changes[name] = other
        else:
            differs = True
    return replace(new, **changes) if differs else old


def literals_in(data: Iterable[Declare], looks: Iterable[Look]) -> Iterator[PositionLiteral]:
    """Every position that is written out: in data, and in the statements that `looks` are of."""
    for d in data:
        if type(d.value) is PositionLiteral:
            yield d.value
        elif d.value is not None:
            yield from (e for e in expressions_of(d.value) if type(e) is PositionLiteral)
    for look in looks:
        plain = (*(e for s in look.direct() for e in s.targets), *(e for _, e in look.systems))
        for e in (*(part for one in plain for part in expressions_of(one)), *look.expressions):
            if type(e) is PositionLiteral:
                yield e
