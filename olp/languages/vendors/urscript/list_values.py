"""Lists that functions take and give back, as arrays: other languages hand arrays over and return none.

A list that all values of a name agree about has a kind and a number of elements. What a function returns becomes a
parameter that it fills; a list that is made in an argument gets a variable of its own before the statement.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Final, NamedTuple

from olp.ir import expressions as ex
from olp.ir import program as st
from olp.ir.transformer import expressions_of, mapped
from olp.languages.vendors.urscript.known_routines import FILLED, room_for

_KINDS: Final[Mapping[type, str]] = {ex.SignalState: "boolean", ex.Text: "string"}
_SINGLE: Final = frozenset({"integer", "real", "boolean", "string"})
# Statements whose values are computed once and before anything else that they do.
_ONCE: Final = (
    st.Assign,
    st.Declare,
    st.Call,
    st.Return,
    st.If,
    st.SetOutput,
    st.Dwell,
    st.Process,
    st.Message,
)


class ListShape(NamedTuple):
    """The type of a list's elements and how many there are; 0: the caller decides."""

    kind: str
    size: int


_Values = list[tuple[str, ex.Expression]]
"""What one name or result gets: the routine in which it is computed, and the value."""


def with_arrays(program: st.Program) -> st.Program:
    """The program with its lists as arrays, where the text tells how long they are."""
    lists = _Lists(program)
    if not lists.is_needed():
        return program
    data = tuple([lists.declared("", d) for d in program.data])
    return replace(program, routines=tuple([lists.routine(r) for r in program.routines]), data=data)


class _Lists:
    def __init__(self, program: st.Program) -> None:
        self.program = program
        self.routines = {r.name: r for r in program.routines}
        self.own = {r.name: _own_names(r) for r in program.routines}
        self.declares = {
            (r.name, s.name): s for r in program.routines for s in r.body if type(s) is st.Declare
        }
        self.declares |= {("", d.name): d for d in program.data}
        self.names: dict[tuple[str, str], _Values] = defaultdict(list)
        self.results: dict[str, _Values] = defaultdict(list)
        self.changes: set[tuple[str, str]] = set()  # names of which single elements are set
        self._made = 0
        for d in program.data:
            self._note("", d)
        for r in program.routines:
            for s in r.body:
                self._note(r.name, s)
        self.given_back = {
            name: shape
            for name, r in self.routines.items()
            if r.returns == "list" and (shape := self._result(name, frozenset())) is not None and shape.size
        }
        self.given_back = {
            name: shape for name, shape in self.given_back.items() if self._may_be_filled(self.routines[name])
        }

    def is_needed(self) -> bool:
        lists = any(d.type == "list" and not d.sizes for d in self.declares.values())
        return lists or any(p.type == "list" for r in self.program.routines for p in r.parameters)

    # --- what the text says -----------------------------------------------------------------------------

    def _scope(self, routine: str, name: str) -> str:
        return routine if name in self.own.get(routine, ()) else ""

    def _note(self, routine: str, s: st.Statement) -> None:
        if isinstance(s, st.Declare) and s.value is not None:
            self.names[self._scope(routine, s.name), s.name].append((routine, s.value))
        elif isinstance(s, st.Assign):
            self._set(routine, s.target, s.value)
        elif isinstance(s, st.Call):
            call = ex.CallValue(s.routine, s.arguments)
            self._pass(routine, call)
            if s.result is not None:
                self._set(routine, s.result, call)
        elif isinstance(s, st.Return) and s.value is not None:
            self.results[routine].append((routine, s.value))
        for e in expressions_of(s):
            if type(e) is ex.CallValue:
                self._pass(routine, e)

    def _set(self, routine: str, target: ex.Expression, value: ex.Expression) -> None:
        if type(target) is ex.Named:
            self.names[self._scope(routine, target.name), target.name].append((routine, value))
        elif type(target) is ex.Item and type(target.base) is ex.Named:
            self.changes.add((self._scope(routine, target.base.name), target.base.name))

    def _pass(self, routine: str, call: ex.CallValue) -> None:
        called = self.routines.get(call.routine)
        if called is None:
            return
        for p, value in zip(called.parameters, _arguments(called, call.arguments) or (), strict=False):
            self.names[called.name, p.name].append((routine, value))

    # --- shapes -----------------------------------------------------------------------------------------

    def shape(
        self, routine: str, e: ex.Expression, seen: frozenset[object] = frozenset()
    ) -> ListShape | None:
        """The shape of a value, None where it is no list or nothing tells."""
        if type(e) is ex.RecordLiteral and e.type == "list" and e.members:
            kinds = {_kind(value) for _, value in e.members}
            kinds = {"real"} if kinds == {"integer", "real"} else kinds
            kind = kinds.pop() if len(kinds) == 1 else ""
            return ListShape(kind, len(e.members)) if kind else None
        if type(e) is ex.Named:
            return self._named(self._scope(routine, e.name), e.name, seen)
        if type(e) is ex.CallValue:
            return self._result(e.routine, seen)
        if type(e) is ex.Function and e.name in FILLED:
            size = room_for(e)
            return None if size is None else ListShape(FILLED[e.name], size)
        return None

    def _named(self, scope: str, name: str, seen: frozenset[object]) -> ListShape | None:
        declared = self.declares.get((scope, name))
        if declared is not None and declared.type != "list":
            (size,) = declared.sizes if len(declared.sizes) == 1 else (None,)
            known = type(size) is ex.Number and declared.type in _SINGLE
            return ListShape(declared.type, int(size.value)) if known else None  # type: ignore[union-attr]
        return self._merged(self.names.get((scope, name)), (scope, name), seen, declared is None)

    def _result(self, routine: str, seen: frozenset[object]) -> ListShape | None:
        return self._merged(self.results.get(routine), routine, seen, open_=False)

    def _merged(
        self, values: _Values | None, key: object, seen: frozenset[object], open_: bool
    ) -> ListShape | None:
        """What all values agree about; `open_`: of a parameter, which may get lists of several lengths."""
        found: set[ListShape | None] = set()
        written: set[ListShape | None] = set()  # numbers that stand in the text may be of either kind
        for routine, value in values if values is not None and key not in seen else ():
            if not (type(value) is ex.Named and self._says_nothing(routine, value.name, {*seen, key})):
                one = self.shape(routine, value, seen | {key})
                (written if type(value) is ex.RecordLiteral else found).add(one)
        kinds = {"" if one is None else one.kind for one in found}
        free = {"" if one is None else one.kind for one in written}
        if "integer" in free and ("real" in kinds or "real" in free):
            free = free - {"integer"} | {"real"}
        kinds |= free
        sizes = {one.size for one in (*found, *written) if one is not None}
        if len(kinds) != 1 or "" in kinds or (len(sizes) > 1 and not open_):
            return None
        return ListShape(kinds.pop(), sizes.pop() if len(sizes) == 1 else 0)

    def _says_nothing(self, routine: str, name: str, seen: set[object]) -> bool:
        """Whether the shape of a name is being asked for, or is that of what no call hands over."""
        key = (self._scope(routine, name), name)
        return key in seen or (routine in self.own and key not in self.names and key not in self.declares)

    # --- what is written instead ------------------------------------------------------------------------

    def declared(self, scope: str, d: st.Declare) -> st.Declare:
        """A declaration of a list as one of an array; its first value stays with the statement that sets it."""
        shape = self._named(scope, d.name, frozenset()) if d.type == "list" and not d.sizes else None
        if shape is None or not shape.size:
            return d
        value = d.value if type(d.value) is ex.RecordLiteral else None
        return replace(d, type=shape.kind, value=value, sizes=(ex.Number(shape.size),))

    def _parameter(self, routine: str, p: st.Parameter) -> st.Parameter:
        if p.type != "list" or p.default is not None or (routine, p.name) in self.changes:
            return p
        shape = self._named(routine, p.name, frozenset())
        if shape is None:
            return p
        size = ex.Number(shape.size) if shape.size else ex.Unknown("")
        return replace(p, type=shape.kind, sizes=(size,))

    def _may_be_filled(self, r: st.Routine) -> bool:
        """Whether every call of it may stand as a statement of its own."""
        if r.name == self.program.main or any(type(s) is st.Return and s.value is None for s in r.body):
            return False
        for caller in self.program.routines:
            for s in caller.body:
                calls = [e for e in expressions_of(s) if type(e) is ex.CallValue and e.routine == r.name]
                if calls and not (len(calls) == 1 and self._is_first(caller, s, calls[0])):
                    return False
                given = [e.arguments for e in calls]
                given += [s.arguments] if type(s) is st.Call and s.routine == r.name else []
                if any(_arguments(r, arguments) is None for arguments in given):
                    return False
        return True

    def _is_first(self, caller: st.Routine, s: st.Statement, call: ex.Expression) -> bool:
        """Whether the call may be made before the statement: nothing that it changes is read there before it."""
        if not isinstance(s, _ONCE) or any(type(e) is ex.Logic for e in expressions_of(s)):
            return False
        inside = {id(e) for e in (call, *expressions_of(call))}
        names = [e.name for e in expressions_of(s) if type(e) is ex.Named and id(e) not in inside]
        targets = {s.target.name} if isinstance(s, st.Assign) and type(s.target) is ex.Named else set()
        return all(name in targets or name in self.own[caller.name] for name in names)

    def routine(self, r: st.Routine) -> st.Routine:
        shape = self.given_back.get(r.name)
        parameters = tuple([self._parameter(r.name, p) for p in r.parameters])
        out = ""
        if shape is not None:
            out = _free(f"{r.name}_list", self.own[r.name])
            filled = st.Parameter(out, shape.kind, by_reference=True, sizes=(ex.Number(shape.size),))
            given = [replace(p, optional=False, default=None) for p in parameters]  # calls say all of them
            parameters = (*given, filled)
        made: list[st.Statement] = []
        rows = [row for s in r.body for row in self._statements(r, s, out, made)]
        returns = "" if shape is not None else r.returns
        return replace(r, body=(*made, *rows), parameters=parameters, returns=returns)

    def _statements(
        self, r: st.Routine, s: st.Statement, out: str, made: list[st.Statement]
    ) -> Iterator[st.Statement]:
        if isinstance(s, _ONCE):
            before: list[st.Statement] = []
            s = self._lifted(r, s, made, before)
            yield from before
        if isinstance(s, st.Declare):
            declared = self.declared(self._scope(r.name, s.name), s)
            yield declared
            if s.value is not None and declared.value is None:
                yield self._stored(s.line, s.name, s.value, s.comment)
        elif isinstance(s, st.Assign) and type(s.target) is ex.Named:
            yield from self._set_apart(s, made)
        elif isinstance(s, st.Call) and s.routine in self.given_back:
            target = s.result if type(s.result) is ex.Named else None
            name = (
                self._temporary(self.given_back[s.routine], s.line, made) if target is None else target.name
            )
            yield self._stored(s.line, name, ex.CallValue(s.routine, s.arguments), s.comment)
        elif isinstance(s, st.Return) and out and s.value is not None:
            yield self._stored(s.line, out, s.value, "")
            if s is not r.body[-1]:
                yield replace(s, value=None)
        else:
            yield s

    def _set_apart(self, s: st.Assign, made: list[st.Statement]) -> Iterator[st.Statement]:
        """What goes into a variable; a list that is computed from itself by way of another one."""
        assert isinstance(s.target, ex.Named)
        value = s.value
        filled = type(value) is ex.CallValue and value.routine in self.given_back
        if filled and s.target in expressions_of(value):
            assert isinstance(value, ex.CallValue)
            name = self._temporary(self.given_back[value.routine], s.line, made)
            yield self._stored(s.line, name, value, s.comment)
            yield st.Assign(s.line, s.target, ex.Named(name))
        else:
            yield self._stored(s.line, s.target.name, value, s.comment, s)

    def _stored(
        self, line: int, name: str, value: ex.Expression, comment: str, s: st.Assign | None = None
    ) -> st.Statement:
        """A list goes into a variable: by the routine that fills it, or as it is."""
        if type(value) is ex.CallValue and value.routine in self.given_back:
            called = self.routines[value.routine]
            arguments = _arguments(called, value.arguments) or value.arguments
            return st.Call(line, value.routine, (*arguments, ex.Named(name)), comment=comment)
        return st.Assign(line, ex.Named(name), value, comment) if s is None else s

    def _lifted(
        self, r: st.Routine, s: st.Statement, made: list[st.Statement], before: list[st.Statement]
    ) -> st.Statement:
        """The statement with a variable for each list that an argument makes; `before`: what sets those."""

        def change(e: ex.Expression) -> ex.Expression:
            if type(e) is not ex.CallValue or e.routine not in self.routines:
                return e
            return replace(e, arguments=all_held(e.routine, e.arguments))

        def all_held(routine: str, given: tuple[ex.Expression, ...]) -> tuple[ex.Expression, ...]:
            parameters = self.routines[routine].parameters
            kinds = [self._named(routine, p.name, frozenset()) for p in parameters]
            kinds += [None] * (len(given) - len(kinds))
            return tuple([held(one, wanted) for one, wanted in zip(given, kinds, strict=False)])

        def held(one: ex.Expression, wanted: ListShape | None) -> ex.Expression:
            is_made = type(one) in (ex.RecordLiteral, ex.CallValue) or (
                type(one) is ex.Function and one.name in FILLED
            )
            shape = self.shape(r.name, one) if is_made else None
            if shape is None or not shape.size:
                return one
            if wanted is not None and type(one) is ex.RecordLiteral:
                shape = shape._replace(kind=wanted.kind)
            name = self._temporary(shape, s.line, made)
            before.append(self._stored(s.line, name, one, ""))
            return ex.Named(name)

        changed = mapped(s, change)
        if isinstance(changed, st.Call) and changed.routine in self.routines:
            changed = replace(changed, arguments=all_held(changed.routine, changed.arguments))
        return changed

    def _temporary(self, shape: ListShape, line: int, made: list[st.Statement]) -> str:
        self._made += 1
        every: set[str] = {name for _, name in self.names}
        name = _free(f"list_{self._made}", every)
        made.append(st.Declare(line, name, shape.kind, None, (ex.Number(shape.size),)))
        return name


def _own_names(r: st.Routine) -> frozenset[str]:
    declared = (s.name for s in r.body if type(s) is st.Declare and not s.shared)
    return frozenset((*declared, *(p.name for p in r.parameters)))


def _arguments(called: st.Routine, given: Sequence[ex.Expression]) -> tuple[ex.Expression, ...] | None:
    """One value for each parameter, in their order; None where one has none."""
    named = {one.name: one.value for one in given if type(one) is ex.NamedArgument}
    plain = [one for one in given if type(one) is not ex.NamedArgument]
    found: list[ex.Expression] = []
    for at, p in enumerate(called.parameters):
        value = plain[at] if at < len(plain) else named.get(p.name) or p.default
        if value is None:
            return None
        found.append(value)
    return tuple(found)


def _kind(e: ex.Expression) -> str:
    if type(e) is ex.Number:
        return "integer" if type(e.value) is int else "real"
    if type(e) in (ex.Binary, ex.Unary, ex.Item, ex.Member):
        return "real"
    return _KINDS.get(type(e), "")


def _free(name: str, taken: Iterable[str]) -> str:
    used = set(taken)
    while name in used:
        name += "_"
    return name
