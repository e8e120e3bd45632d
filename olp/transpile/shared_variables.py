"""Variables for languages whose routines share all of them.

Local variables get names that are unique in the program; arguments and results are handed over in variables.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from itertools import product
from typing import Any, Final

from olp.ir import expressions as ex
from olp.ir.program import (
    Assign,
    Begin,
    Call,
    Declare,
    For,
    Move,
    Parameter,
    Program,
    Return,
    Routine,
    Statement,
    Update,
)
from olp.ir.transformer import calls_nothing, expressions_of, mapped
from olp.transpile.context import Fate, Handed, TranslationContext
from olp.transpile.symbols import Symbols, base_of, symbols_of

_SHARING = frozenset({Declare, Return, Call})
_SYSTEMS: Final = ("tool", "frame")
_PLACES: Final = ("position", "joints")
_MOST_ELEMENTS: Final = (
    60  # of an array that a call hands over: each is a statement before it, and one behind it
)
_BY_NUMBER: Final = ("integer", "real", "string")  # types that a language without parameters hands over


def share_variables(program: Program, work: TranslationContext) -> Program:
    """No local variable, no parameter and no returned value is left; routines hand over by variables."""
    if not any(_hands_over(routine) for routine in program.routines):
        for routine in program.routines:
            work.handed.setdefault(routine.name.casefold(), Handed((), {}, None))
        return program
    own = _Shared(program, work)
    routines = tuple(own.routine(routine) for routine in program.routines)
    return replace(program, routines=routines, data=(*program.data, *own.declared))


def _hands_over(routine: Routine) -> bool:
    """Whether anything of a routine may be its own: variables, arguments, a result; or it calls another one."""
    own = routine.parameters or routine.returns or routine.data
    return bool(own) or not _SHARING.isdisjoint(map(type, routine.body))


@dataclass(slots=True)
class _Shared:
    """`names`: (routine, local name) -> its name in the whole program. `results`: of each routine that returns."""

    program: Program
    work: TranslationContext
    names: dict[tuple[str, str], str] = field(default_factory=dict)
    results: dict[str, ex.Named] = field(default_factory=dict)
    declared: list[Declare] = field(default_factory=list)
    parameters: dict[str, tuple[Parameter, ...]] = field(default_factory=dict)
    symbols: Symbols = field(default_factory=Symbols)
    first: str = ""  # the routine that runs first

    def __post_init__(self) -> None:
        self.first = self.program.main or self.program.routines[0].name
        self.symbols = symbols_of(self.program)
        taken: set[str] = {d.name.casefold() for d in self.program.data}
        for routine in self.program.routines:
            self.parameters[routine.name.casefold()] = routine.parameters
            for name, kind, declare in _locals(routine):
                unique = name if name.casefold() not in taken else self.work.fresh(f"{routine.name}_{name}")
                taken.add(unique.casefold())
                self.names[(routine.name, name)] = unique
                self.work.declared_at[unique] = routine.line if declare is None else declare.line
                if declare is None:
                    sizes = next((p.sizes for p in routine.parameters if p.name == name), ())
                    self.declared.append(Declare(0, unique, kind or "real", None, sizes, shared=True))
            if routine.returns or any(isinstance(s, Return) and s.value is not None for s in routine.body):
                returned = ex.Named(self.work.fresh(f"{routine.name}_result"))
                self.work.declared_at[returned.name] = routine.line
                self.results[routine.name.casefold()] = returned
                self.declared.append(Declare(0, returned.name, routine.returns or "real", None, shared=True))
            self._hand_over(routine)
        self._refuse_recursion()

    def _hand_over(self, routine: Routine) -> None:
        """Calls that come up later, out of expressions, are handed their arguments as the first ones were."""
        key = routine.name.casefold()
        known = self.work.handed.get(key)
        if known is None:
            names = {p.name: self.names[(routine.name, p.name)] for p in routine.parameters}
            self.work.handed[key] = Handed(routine.parameters, names, self.results.get(key))
            return
        self.parameters[key] = known.parameters
        if known.result is not None:
            self.results[key] = known.result

    def _refuse_recursion(self) -> None:
        calls = {
            r.name.casefold(): {c.casefold() for s in r.body for c in called_in(s)}
            for r in self.program.routines
        }
        for name in calls:
            seen: set[str] = set()
            todo = [name]
            while todo:
                for other in calls.get(todo.pop(), ()):
                    if other == name:
                        routine = next(r for r in self.program.routines if r.name.casefold() == name)
                        if _locals(routine):
                            says = f"{routine.name} calls itself and has variables of its own"
                            self.work.lose(routine.line, Fate.REFUSED, "recursion", says)
                        todo, seen = [], seen | {other}
                        break
                    if other not in seen:
                        seen.add(other)
                        todo.append(other)

    def routine(self, routine: Routine) -> Routine:
        def change(e: ex.Expression) -> ex.Expression:
            if type(e) is ex.Named:
                name = self.names.get((routine.name, e.name))
                return e if name is None or name == e.name else ex.Named(name)
            return e

        rows: list[Statement] = []
        renamed = any(where == routine.name and old != new for (where, old), new in self.names.items())
        for s in routine.body:
            if type(s) is Move and not renamed and calls_nothing(s):
                rows.append(s)
            elif isinstance(s, Declare):
                rows += self._local(routine, s, change)
            else:
                rows += self._statement(routine, mapped(s, change))
        first = 1 if rows and isinstance(rows[0], Begin) else 0
        rows[first:first] = self._taken(routine)
        # Data of a file beside the routine keep their values between runs: they are the program's.
        for declare in routine.data:
            name = self.names.get((routine.name, declare.name), declare.name)
            self.declared.append(replace(mapped(declare, change), name=name, shared=True))
        return replace(routine, body=tuple(rows), parameters=(), returns="", data=())

    def _taken(self, routine: Routine) -> Iterator[Statement]:
        """What sets the parameters of a routine that programs elsewhere call: these hand over by number."""
        offered = routine.shared and bool(routine.returns) and routine.name != self.first
        if not offered and (not routine.parameters or (routine.name != self.first and not routine.starts)):
            return
        name = routine.name.casefold()
        inside = any(name in map(str.casefold, called_in(s)) for s in self.program.statements())
        if offered and inside:
            return
        if offered:
            says = f"nothing here calls {routine.name}: its caller has to read the variable {self.results[name].name}"
            self.work.lose(
                routine.line, Fate.APPROXIMATED, "argument", f"{says}, which holds what it returns"
            )
        for number, p in enumerate(routine.parameters, 1):
            if inside or p.switch or p.optional or (p.type or "real") not in _BY_NUMBER:
                says = f"the argument {p.name} of {routine.name}: its caller has to set the variable"
                self.work.lose(routine.line, Fate.APPROXIMATED, "argument", says)
                continue
            if p.by_reference:
                says = f"the argument {p.name} of {routine.name}: its caller does not get it back"
                self.work.lose(routine.line, Fate.APPROXIMATED, "argument", says)
            yield Assign(routine.line, ex.Named(self.names[(routine.name, p.name)]), ex.Argument(number))

    def _local(self, routine: Routine, s: Declare, change: Any) -> Iterator[Statement]:
        name = self.names.get((routine.name, s.name), s.name)
        value = mapped(s.value, change)
        again = s.storage == "variable" and not s.shared and value is not None
        rows = _listed(value) if s.sizes else None
        if again and rows is not None:
            self.declared.append(replace(s, line=0, name=name, value=None, shared=True, comment=""))
            for at, one in enumerate(rows, 1):
                yield Assign(s.line, ex.Item(ex.Named(name), (ex.Number(at),)), one)
            return
        again = again and not s.sizes
        kept = value if not again or self._is_held(routine, s, value) else None
        self.declared.append(replace(s, line=0, name=name, value=kept, shared=True, comment=""))
        if again and kept is None:
            assert value is not None
            yield Assign(s.line, ex.Named(name), value, s.comment)

    def _is_held(self, routine: Routine, s: Declare, value: ex.Expression | None) -> bool:
        """Whether a place or a system needs its first value once: nothing changes it, or the target numbers it."""
        literal = isinstance(value, (ex.PositionLiteral, ex.RecordLiteral)) or s.type in _SYSTEMS
        if not literal or s.type not in (*_SYSTEMS, *_PLACES):
            return False
        symbol = self.symbols.find(routine.name, s.name)
        return s.type in _SYSTEMS or symbol is None or not symbol.assigned

    # --- calls ------------------------------------------------------------------------------------------

    def _statement(self, routine: Routine, s: Statement) -> list[Statement]:
        if isinstance(s, Return) and s.value is not None:
            own = self.results[routine.name.casefold()]
            return [Assign(s.line, own, s.value), replace(s, value=None)]
        if not isinstance(s, Call) or s.routine.casefold() not in self.parameters:
            return [s]
        before, after = self.handed_over(s.routine, s.arguments, s.line)
        result = self.results.get(s.routine.casefold())
        if s.result is not None and result is not None:
            after = [Assign(s.line, s.result, result), *after]
        elif s.result is not None:
            self.work.lose(s, Fate.REFUSED, "statement", f"the result of {s.routine}, which returns none")
        return [*before, replace(s, arguments=(), result=None), *after]

    def handed_over(
        self, called: str, arguments: tuple[ex.Expression, ...], line: int
    ) -> tuple[list[Statement], list[Statement]]:
        """What sets the variables of a routine's parameters, and what takes back those passed by reference."""
        parameters = self.parameters[called.casefold()]
        names = self.work.handed[called.casefold()].names
        before: list[Statement] = []
        after: list[Statement] = []
        given = dict(paired(parameters, arguments))
        for parameter in parameters:
            target = ex.Named(names[parameter.name])
            value = given.get(parameter.name, parameter.default)
            if parameter.switch:
                value = ex.SignalState(parameter.name in given)
            if value is None:
                continue
            if parameter.by_reference and isinstance(value, ex.Item):
                others = [given.get(p.name) for p in parameters if p.by_reference and p is not parameter]
                value = self._chosen(value, called, others, before, line)
            pairs = (
                [(target, value)] if not parameter.sizes else self._elements(parameter, target, value, line)
            )
            before += [Assign(line, one, other) for one, other in pairs]
            if parameter.by_reference and isinstance(value, (ex.Named, ex.Item, ex.Member)):
                after += [Assign(line, other, one) for one, other in pairs]
        return before, after

    def _chosen(
        self,
        value: ex.Item,
        called: str,
        others: list[ex.Expression | None],
        before: list[Statement],
        line: int,
    ) -> ex.Item:
        """An element that comes back: the one that was handed over, though the routine may change its index."""
        changed = {e.name for one in others for e in expressions_of(one) if type(e) is ex.Named}
        changed |= self._changed_in(called)
        indices: list[ex.Expression] = []
        for index in value.indices:
            if any(type(e) is ex.Named and e.name in changed for e in expressions_of(index)):
                kept = ex.Named(self.work.fresh("handed_index"))
                self.declared.append(Declare(0, kept.name, "integer", None, shared=True))
                before.append(Assign(line, kept, index))
                index = kept
            indices.append(index)
        return replace(value, indices=tuple(indices))

    def _changed_in(self, called: str) -> set[str]:
        """The variables of all that a routine, or one that it calls, gives a value."""
        found: set[str] = set()
        seen, todo = {called.casefold()}, [called.casefold()]
        while todo:
            name = todo.pop()
            for routine in (r for r in self.program.routines if r.name.casefold() == name):
                for s in routine.body:
                    bases = [base for target in _set_by(s) if (base := base_of(target)) is not None]
                    found |= {one.name for one in bases if (routine.name, one.name) not in self.names}
                    new = {one.casefold() for one in called_in(s)} - seen
                    seen |= new
                    todo += new
        return found

    def _elements(
        self, parameter: Parameter, target: ex.Named, value: ex.Expression, line: int
    ) -> list[tuple[ex.Expression, ex.Expression]]:
        """Each element of an array that is handed over, with that of the routine's own."""
        sizes = [int(size.value) for size in parameter.sizes if type(size) is ex.Number]
        whole = type(value) is ex.Named
        if len(sizes) < len(parameter.sizes) or math.prod(sizes) > _MOST_ELEMENTS or not whole:
            says = f"the array {parameter.name}, which is handed over as a whole"
            if whole and len(sizes) == len(parameter.sizes):
                says = f"{says}: it has more than {_MOST_ELEMENTS} elements"
            self.work.lose(line, Fate.REFUSED, "argument", says)
            return []
        places = product(*(range(1, size + 1) for size in sizes))
        indices = [tuple(map(ex.Number, place)) for place in places]
        return [(ex.Item(target, at), ex.Item(value, at)) for at in indices]


def _set_by(s: Statement) -> tuple[ex.Expression, ...]:
    if isinstance(s, (Assign, Update)):
        return (s.target,)
    return (s.variable,) if isinstance(s, For) else ()


def _listed(value: ex.Expression | None) -> list[ex.Expression] | None:
    """The elements of an array of numbers or texts that is written out, None for any other value."""
    if not isinstance(value, ex.RecordLiteral) or any(name for name, _ in value.members):
        return None
    found = [one for _, one in value.members]
    return found if all(isinstance(one, (ex.Number, ex.Text, ex.SignalState)) for one in found) else None


def handed_over(s: Statement) -> Iterator[tuple[str, tuple[ex.Expression, ...]]]:
    """The routines that a statement calls, with what they are handed."""
    if type(s) is Call:
        yield s.routine, s.arguments
    if not calls_nothing(s):
        yield from ((e.routine, e.arguments) for e in expressions_of(s) if type(e) is ex.CallValue)


def paired(
    parameters: tuple[Parameter, ...], arguments: tuple[ex.Expression, ...]
) -> Iterator[tuple[str, ex.Expression | None]]:
    """Each argument with the name of its parameter."""
    positional = iter(
        [p for p in parameters if not p.optional and not p.switch] + [p for p in parameters if p.optional]
    )
    for argument in arguments:
        if isinstance(argument, ex.NamedArgument):
            yield argument.name, argument.value
        else:
            parameter = next(positional, None)
            if parameter is not None:
                yield parameter.name, argument


def calls_of(routine: Routine, program: Program) -> list[tuple[Routine, Call | ex.CallValue]]:
    name = routine.name.casefold()
    return [
        (r, call)
        for r in program.routines
        for s in r.body
        if not calls_nothing(s)
        for call in (s, *expressions_of(s))
        if isinstance(call, (Call, ex.CallValue)) and call.routine.casefold() == name
    ]


def called_in(s: Statement) -> list[str]:
    """The routines that a statement calls."""
    if calls_nothing(s):
        return []
    found = [s.routine] if isinstance(s, Call) else []
    return found + [e.routine for e in expressions_of(s) if type(e) is ex.CallValue]


def _locals(routine: Routine) -> list[tuple[str, str, Declare | None]]:
    """(name, type, declaration) of what is local to a routine; parameters have no declaration."""
    found: list[tuple[str, str, Declare | None]] = [(p.name, p.type, None) for p in routine.parameters]
    found += [(d.name, d.type, d) for d in routine.data if not d.shared]
    known = {name for name, _, _ in found}
    for s in routine.body:
        if isinstance(s, Declare) and not s.shared and s.name not in known:
            known.add(s.name)
            found.append((s.name, s.type, s))
    return found
