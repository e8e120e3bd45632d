"""How many elements arrays have; what an index takes from beyond them is refused, for it is another variable."""

from __future__ import annotations

import itertools
import math
from collections import Counter
from collections.abc import Iterator, Mapping, Set
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Final, NamedTuple

from olp.ir import expressions as ex
from olp.ir import program as st
from olp.ir.transformer import calls_nothing, expressions_of, mapped
from olp.transpile.context import Fate, TranslationContext
from olp.transpile.implicit_declarations import uses_of
from olp.transpile.name_types import Use
from olp.transpile.occurrences import changed_rare, with_routines, with_rows
from olp.transpile.shared_variables import calls_of, handed_over, paired
from olp.transpile.symbols import Symbol, Symbols, base_of, kind_of_value, symbols_of

# Types of which an element has an index of its own; axes are elements of what holds them.
_SINGLE: Final = ("real", "integer", "boolean", "string", "position", "tool", "frame")
_ONE, _NUMBERS_ALONE, _ANY = "one", "numbers", "any"  # what Limits.dimensions says


def sizes_of(symbols: Symbols, symbol: Symbol) -> tuple[int, ...] | None:
    """The elements of each dimension; () of what is no array, None where nothing at hand tells."""
    found = []
    for size in symbol.sizes:
        value = symbols.fixed_value(symbol.scope, size)
        if not isinstance(value, ex.Number):
            return _listed(symbol) if len(symbol.sizes) == 1 else None
        found.append(int(value.value))
    return tuple(found) if found else _listed(symbol)


def _listed(symbol: Symbol) -> tuple[int, ...] | None:
    """Of an array whose elements are written out and nothing else says how many there are."""
    if isinstance(symbol.value, ex.RecordLiteral) and all(not name for name, _ in symbol.value.members):
        return (len(symbol.value.members),)
    return None if symbol.sizes else ()


_OPEN: Final = ex.Unknown("")  # how many elements a parameter has where its caller decides


def array_parameters(program: st.Program, work: TranslationContext) -> st.Program:
    """Arrays that routines take have as many elements as what all calls hand over, where that is one number."""
    while True:
        symbols = work.symbols(program)
        changed = [_sized(r, program, symbols) for r in program.routines]
        if all(new is old for new, old in zip(changed, program.routines, strict=True)):
            return program
        program = replace(program, routines=tuple(changed))  # what a routine hands on is known now


def _sized(routine: st.Routine, program: st.Program, symbols: Symbols) -> st.Routine:
    if not any(_OPEN in p.sizes for p in routine.parameters):
        return routine
    given: dict[str, set[tuple[int, ...] | None]] = {}
    for caller, call in calls_of(routine, program):
        for name, e in paired(routine.parameters, call.arguments):
            e = e.base if type(e) is ex.Item and not e.indices else e
            symbol = symbols.find(caller.name, e.name) if type(e) is ex.Named else None
            given.setdefault(name, set()).add(None if symbol is None else sizes_of(symbols, symbol))
    parameters = []
    for p in routine.parameters:
        sizes = given.get(p.name, set())
        found = next(iter(sizes)) if len(sizes) == 1 else None
        known = _OPEN in p.sizes and found is not None and len(found) == len(p.sizes)
        parameters.append(replace(p, sizes=tuple(map(ex.Number, found or ()))) if known else p)
    same = all(new is old for new, old in zip(parameters, routine.parameters, strict=True))
    return routine if same else replace(routine, parameters=tuple(parameters))


def handed_arrays(program: st.Program, work: TranslationContext) -> st.Program:
    """An array that a routine changes for its callers is theirs, where all calls hand over the same one.

    For targets whose routines share all variables: all elements would be copied there and back, in other registers.
    """
    if not work.limits.numbered or work.source.vendor == work.target:
        return program
    while True:
        symbols = work.symbols(program)
        found = ((r, _same_arrays(r, program, symbols, work)) for r in program.routines if r.parameters)
        routine, same = next(((r, names) for r, names in found if names), (None, {}))
        if routine is None:
            return program
        program = _with_same(program, routine, same, work)


def _same_arrays(
    routine: st.Routine, program: st.Program, symbols: Symbols, work: TranslationContext
) -> dict[str, Symbol]:
    """By parameter the array that every call hands over for it."""
    plain = not any(p.optional or p.switch for p in routine.parameters)
    wanted = [(at, p) for at, p in enumerate(routine.parameters) if p.sizes and p.by_reference]
    if not plain or not wanted or routine.starts or routine.name == program.main:
        return {}
    calls = calls_of(routine, program)
    if any(len(call.arguments) != len(routine.parameters) for _, call in calls):
        return {}
    found: dict[str, Symbol] = {}
    for at, p in wanted:
        given = [_whole_array(call.arguments[at], caller, symbols) for caller, call in calls]
        keys = {None if one is None else (one.scope, one.name) for one in given}
        symbol = given[0] if given else None
        if len(keys) != 1 or symbol is None or (symbol.scope and not _is_bare(symbol, work)):
            continue
        if symbol.scope or (routine.name, symbol.name) not in symbols.table:  # else a local one hides it
            found[p.name] = symbol
    return found


def _whole_array(e: ex.Expression, caller: st.Routine, symbols: Symbols) -> Symbol | None:
    """An array that is handed over as a whole, None for what a caller was handed itself."""
    e = e.base if type(e) is ex.Item and not e.indices else e
    symbol = symbols.find(caller.name, e.name) if type(e) is ex.Named else None
    return None if symbol is None or not symbol.sizes or symbol.parameter is not None else symbol


def _is_bare(symbol: Symbol, work: TranslationContext) -> bool:
    """Whether a local variable can be the program's: nothing gives it a value at each call."""
    return symbol.value is None and symbol.storage == "variable" and not work.conventions.data_begin_anew


def _with_same(
    program: st.Program, routine: st.Routine, same: Mapping[str, Symbol], work: TranslationContext
) -> st.Program:
    """The program whose routine names the arrays of its callers, without the parameters for them."""
    owners = {s.scope for s in same.values() if s.scope}
    others = {
        n for r in program.routines if r is not routine and r.name not in owners for n in work.look(r).names()
    }
    others |= {d.name for d in program.data} | {n for n in work.look(routine).names() if n not in same}
    public = {s.name: work.fresh(s.name) if s.name in others else s.name for s in same.values() if s.scope}
    names = {name: public.get(s.name, s.name) if s.scope else s.name for name, s in same.items()}
    kept = [at for at, p in enumerate(routine.parameters) if p.name not in same]
    moved: list[st.Declare] = []

    def change(new: Mapping[str, str], e: ex.Expression) -> ex.Expression:
        if type(e) is ex.Named:
            return ex.Named(new[e.name]) if e.name in new else e
        if type(e) is ex.CallValue and e.routine.casefold() == routine.name.casefold():
            return replace(e, arguments=tuple(e.arguments[at] for at in kept))
        return e

    def row(s: st.Statement, new: Mapping[str, str]) -> st.Statement:
        if calls_nothing(s) and not new:
            return s
        s = mapped(s, partial(change, new))
        if isinstance(s, st.Call) and s.routine.casefold() == routine.name.casefold():
            s = replace(s, arguments=tuple(s.arguments[at] for at in kept))
        return s

    routines = []
    for r in program.routines:
        new = names if r is routine else public if r.name in owners else {}
        body: list[st.Statement] = []
        for s in (*r.data, *r.body):
            if r.name in owners and isinstance(s, st.Declare) and s.name in public:
                moved.append(replace(s, name=public[s.name], shared=True))
        for s in r.body:
            if not (r.name in owners and isinstance(s, st.Declare) and s.name in public):
                body.append(row(s, new))
        data = tuple(d for d in r.data if not (r.name in owners and d.name in public))
        parameters = tuple(r.parameters[at] for at in kept) if r is routine else r.parameters
        routines.append(replace(r, body=tuple(body), data=data, parameters=parameters))
    return replace(program, routines=tuple(routines), data=(*program.data, *moved))


# Statements that change no variable but the one that they name, and are passed from the one before to the next.
_STRAIGHT: Final = frozenset(
    {st.Assign, st.Comment, st.Declare, st.Dwell, st.Message, st.Move, st.SetBlend, st.SetFrame, st.SetOutput}
    | {st.SetSpeed, st.SetTool}
)


_PLAIN_INDEX: Final = (ex.Number, ex.Named, ex.Binary, ex.Unary)


def passing_arrays(program: st.Program, work: TranslationContext) -> st.Program:
    """An array of which each element is read right behind where it is set, and not again, as one variable.

    Where the arrays of a program are more than the numbered variables that the target is delivered with.
    """
    registers = work.limits.registers
    if registers is None or work.source.vendor == work.target:
        return program
    symbols = work.symbols(program)
    arrays = [symbol for symbol in symbols if symbol.sizes]
    needed: Counter[ex.Store | None] = Counter()
    for symbol in arrays:
        needed[registers.stores.get(symbol.type)] += math.prod(sizes_of(symbols, symbol) or (1,))
    crowded = {s for s, n in needed.items() if s is not None and n > work.limits.numbered.get(s, 0)}
    if not crowded:
        return program
    routines = []
    for r in program.routines:
        own = {
            s.name
            for s in r.body
            if isinstance(s, st.Declare) and s.sizes and not s.shared and s.value is None
            if s.storage == "variable" and registers.stores.get(s.type) in crowded
        }
        passing = {name for name in own if _is_passing(name, r)}
        routines.append(_with_single(r, passing) if passing else r)
    return with_routines(program, routines)


def _is_passing(array: str, routine: st.Routine) -> bool:
    """Whether an array is only read element by element, each in the same straight run as the line that sets it."""
    whole = ex.Named(array)
    held: tuple[ex.Expression, ...] | None = None  # the indices of the element that was set last
    for s in routine.body:
        if isinstance(s, st.Declare) and s.name == array:
            continue
        found = expressions_of(s)
        reads = [e for e in found if type(e) is ex.Item and e.base == whole]
        if found.count(whole) != len(reads):
            return False
        straight = type(s) in _STRAIGHT and not any(type(e) is ex.CallValue for e in found)
        target = s.target if isinstance(s, st.Assign) else None
        if type(target) is ex.Item and target.base == whole:
            reads.remove(target)
            inner = [e for index in target.indices for e in expressions_of(index)]
            if any(type(e) not in _PLAIN_INDEX for e in inner):
                return False
            following: tuple[ex.Expression, ...] | None = target.indices
        else:
            changed = base_of(target)
            inner = [e for index in held or () for e in expressions_of(index)]
            following = held if straight and (changed is None or changed not in inner) else None
        if reads and (not straight or any(e.indices != held for e in reads)):
            return False
        held = following if straight else None
    return True


def _with_single(routine: st.Routine, arrays: Set[str]) -> st.Routine:
    def change(e: ex.Expression) -> ex.Expression:
        return e.base if type(e) is ex.Item and type(e.base) is ex.Named and e.base.name in arrays else e

    rows = [
        replace(s, sizes=()) if isinstance(s, st.Declare) and s.name in arrays else mapped(s, change)
        for s in routine.body
    ]
    return with_rows(routine, rows)


def array_sizes(program: st.Program, work: TranslationContext) -> st.Program:
    """Sizes that constants give (`VAR num a{COUNT}`) as numbers; so those that a program asks for (RAPID's Dim)."""
    if work.source.vendor != work.target:
        program = _counted(program, work)
    if not any(_asks_size(e) for r in program.routines for e in work.look(r).expressions):
        return program
    symbols = work.symbols(program)

    def change(routine: str, e: ex.Expression) -> ex.Expression:
        if type(e) is not ex.Function or not _asks_size(e):
            return e
        array, dimension = e.arguments
        symbol = symbols.find(routine, array.name) if type(array) is ex.Named else None
        sizes = None if symbol is None else sizes_of(symbols, symbol)
        if symbol is not None and symbol.type == "joints" and not symbol.sizes:
            sizes = (6,)
        at = int(dimension.value) if type(dimension) is ex.Number else 0
        return ex.Number(sizes[at - 1]) if sizes and 1 <= at <= len(sizes) else e

    routines = [
        replace(r, body=tuple([mapped(s, partial(change, r.name)) for s in r.body])) for r in program.routines
    ]
    return replace(program, routines=tuple(routines))


def _counted(program: st.Program, work: TranslationContext) -> st.Program:
    """Not all languages take a name where they declare an array."""
    declared = [
        *program.data,
        *(d for r in program.routines for d in (*r.data, *work.look(r).of_kind(st.Declare))),
    ]
    if all(isinstance(size, (ex.Number, ex.Unknown)) for d in declared for size in d.sizes):
        return program
    symbols = work.symbols(program)

    def one(scope: str, d: st.Declare) -> st.Declare:
        sizes = [symbols.fixed_value(scope, size) for size in d.sizes]
        known = [new if isinstance(new, ex.Number) else old for new, old in zip(sizes, d.sizes, strict=True)]
        return replace(d, sizes=tuple(known)) if known else d

    routines = [
        replace(
            r,
            data=tuple(one(r.name, d) for d in r.data),
            body=tuple(one(r.name, s) if isinstance(s, st.Declare) else s for s in r.body),
        )
        for r in program.routines
    ]
    return replace(program, data=tuple(one("", d) for d in program.data), routines=tuple(routines))


def _asks_size(e: ex.Expression) -> bool:
    return type(e) is ex.Function and e.name == "size-of-array"


def largest_indices(program: st.Program, work: TranslationContext) -> dict[str, int]:
    """The largest index that is written out of each array of one dimension."""
    found: dict[str, int] = {}
    for routine in program.routines:
        for e in work.look(routine).expressions:
            if type(e) is ex.Item and type(e.base) is ex.Named and len(e.indices) == 1:
                index = e.indices[0]
                if type(index) is ex.Number:
                    found[e.base.name] = max(found.get(e.base.name, 1), int(index.value))
    return found


def array_bounds(program: st.Program, work: TranslationContext) -> st.Program:
    """Refuses elements beyond an array's end; for numbered languages also computed ones where no end is known."""
    if not any(type(e) is ex.Item for routine in program.routines for e in work.look(routine).expressions):
        return program
    symbols = work.symbols(program)
    for routine in program.routines:
        for _, s in work.look(routine).rare:
            for e in expressions_of(s):
                says = (
                    _wrong(symbols, routine.name, e, bool(work.limits.numbered)) if type(e) is ex.Item else ""
                )
                if says:
                    work.lose(s, Fate.REFUSED, "index", says)
                    break
    return program


def _wrong(symbols: Symbols, routine: str, e: ex.Item, numbered: bool) -> str:
    """What is wrong with an element of an array, nothing where it is one, or no array of a program's own."""
    symbol = symbols.find(routine, e.base.name) if type(e.base) is ex.Named else None
    if symbol is None:
        return ""
    sizes = sizes_of(symbols, symbol)
    if any(kind_of_value(symbols, routine, index) == "string" for index in e.indices):
        return f"an element of {symbol.name} by a text"
    if says := _counted_otherwise(symbols, symbol, e, sizes):
        return says
    if sizes == ():
        return ""
    values = [
        None if _is_register(symbols, index) else symbols.fixed_value(routine, index) for index in e.indices
    ]
    if sizes is None or not all(sizes):
        if numbered and len(e.indices) > 1:  # which no row of variables has
            return f"nothing tells how many elements {symbol.name} has"
        unknown = numbered and not all(isinstance(value, ex.Number) for value in values)
        return (
            f"nothing tells how many elements {symbol.name} has, and the index is computed" if unknown else ""
        )
    for value, size in zip(values, sizes, strict=False):
        if isinstance(value, ex.Number) and not 1 <= value.value <= size:
            return f"{symbol.name} has {size} elements, and the index is {_shown(value)}"
    return ""


def _is_register(symbols: Symbols, e: ex.Expression) -> bool:
    """Whether it is a variable that no line declares: the controller's own, which others set, too."""
    declared = symbols.declared.get(e.name) if type(e) is ex.Named else None
    return declared is not None and declared.shared and not declared.line


def _counted_otherwise(symbols: Symbols, symbol: Symbol, e: ex.Item, sizes: tuple[int, ...] | None) -> str:
    """What is wrong with the number of indices; a name that a pass made may be the copy of an array."""
    count = len(symbol.sizes if sizes is None else sizes)
    if not symbol.declared or symbol.type not in _SINGLE or count == len(e.indices):
        return ""
    declared = symbols.declared.get(symbol.name)
    made = not symbol.scope and symbol.parameter is None and (declared is None or not declared.line)
    if not count and (made or isinstance(symbol.value, ex.Named)):
        return ""
    given = f"{len(e.indices)} {'index' if len(e.indices) == 1 else 'indices'}"
    return f"{symbol.name} with {given}, declared with {count or 'none'}"


def _shown(e: ex.Expression) -> str:
    return f"{e.value:g}" if isinstance(e, ex.Number) else ""


# --- Array values ---
# Arrays that are assigned as a whole, element by element where the target has no such value.


_MOST_COPIED: Final = 256  # elements of an array that a statement copies, as statements of their own


def array_values(program: st.Program, work: TranslationContext) -> st.Program:
    """`a := [[1,2],[3,4]]` as four assignments; `a := b` of two arrays as one for each element."""
    if work.limits.array_literals:
        return program
    if not any(_may_set_array(s) for r in program.routines for _, s in work.look(r).rare):
        return program
    rows = _WholeArrays(work, work.symbols(program), [])
    routines = tuple(
        replace(r, body=tuple([row for s in r.body for row in rows.of(r.name, s)])) for r in program.routines
    )
    return replace(program, routines=routines, data=(*program.data, *rows.declared))


def _may_set_array(s: st.Statement) -> bool:
    return (
        type(s) is st.Assign
        and type(s.target) is ex.Named
        and (_is_array(s.value) or type(s.value) is ex.Named)
    )


class _WholeArrays(NamedTuple):
    work: TranslationContext
    symbols: Symbols
    declared: list[st.Declare]

    def of(self, routine: str, s: st.Statement) -> tuple[st.Statement, ...]:
        if type(s) is not st.Assign or not _may_set_array(s):
            return (s,)
        pairs: list[tuple[ex.Expression, ex.Expression]]
        if type(s.value) is ex.Named:
            pairs = self._copied(routine, s, s.value)
        else:
            pairs = [(ex.Item(s.target, at), value) for at, value in _elements(s.value, ())]
            pairs = self._apart(routine, s, pairs)
        rows = [st.Assign(s.line, target, value) for target, value in pairs]
        return (replace(rows[0], comment=s.comment), *rows[1:]) if rows else (s,)

    def _apart(
        self, routine: str, s: st.Assign, pairs: list[tuple[ex.Expression, ex.Expression]]
    ) -> list[tuple[ex.Expression, ex.Expression]]:
        """`a := [a{2},a{1}]` by way of an array of its own: the first element changes before the second is computed."""
        names = {e.name for _, value in pairs for e in expressions_of(value) if type(e) is ex.Named}
        if not isinstance(s.target, ex.Named) or s.target.name not in names:
            return pairs
        symbol = self.symbols.find(routine, s.target.name)
        sizes = None if symbol is None else sizes_of(self.symbols, symbol)
        if symbol is None or not sizes:
            self.work.lose(s, Fate.REFUSED, "array", "an array that is computed from its own elements")
            return []
        name = ex.Named(self.work.helper("array"))
        self.declared.append(
            st.Declare(0, name.name, symbol.type, None, tuple(map(ex.Number, sizes)), shared=True)
        )
        first = [(replace(target, base=name), value) for target, value in pairs if type(target) is ex.Item]
        return [*first, *((target, held) for (target, _), (held, _) in zip(pairs, first, strict=True))]

    def _copied(
        self, routine: str, s: st.Assign, value: ex.Named
    ) -> list[tuple[ex.Expression, ex.Expression]]:
        """Target and value of each element; none where the statement copies no array."""
        if not isinstance(s.target, ex.Named):
            return []
        found = [self.symbols.find(routine, name) for name in (s.target.name, value.name)]
        if not all(symbol is not None and symbol.sizes for symbol in found):
            return []
        known = {sizes_of(self.symbols, symbol) for symbol in found if symbol is not None}
        sizes = next(iter(known)) if len(known) == 1 else None
        if sizes is None or math.prod(sizes) > _MOST_COPIED:
            says = f"{s.target.name} gets all elements of {value.name}: nothing tells how many"
            if sizes is not None:
                says = f"{s.target.name} gets all elements of {value.name}, more than {_MOST_COPIED}"
            self.work.lose(s, Fate.REFUSED, "array", says)
            return []
        places = itertools.product(*(range(1, size + 1) for size in sizes))
        indices = [tuple(ex.Number(at) for at in place) for place in places]
        return [(ex.Item(s.target, at), ex.Item(value, at)) for at in indices]


def _is_array(e: ex.Expression) -> bool:
    return type(e) is ex.RecordLiteral and bool(e.members) and not any(name for name, _ in e.members)


def _elements(
    e: ex.Expression, before: tuple[ex.Expression, ...]
) -> Iterator[tuple[tuple[ex.Expression, ...], ex.Expression]]:
    if type(e) is not ex.RecordLiteral or not _is_array(e):
        yield before, e
        return
    for place, (_, value) in enumerate(e.members, 1):
        yield from _elements(value, (*before, ex.Number(place)))


# --- Rows of rows ---
# Arrays of several dimensions as one row, where the target has registers, or no list of lists of such a kind.

_NUMBERS: Final = ("real", "integer")
_KEPT: Final = 10  # of a dimension with a computed index, where nothing declares the array


def single_rows(program: st.Program, work: TranslationContext) -> st.Program:
    """`g{2,3}` of an array of 2 by 4 as the element 7 of a row of 8, also where a routine takes it as a parameter.

    What is named as a whole otherwise stays as it is.
    """
    if work.limits.dimensions == _ANY:
        return program
    symbols = symbols_of(program)
    sizes = {key: found for key, (found, s) in _tables(program, symbols).items() if _is_flat(s, work)}
    sizes |= _undeclared_tables(program, symbols, work)
    handed = _handed_tables(program, symbols) if sizes else []
    for routine in program.routines if sizes else ():
        for s in routine.body:
            for key in _named_whole(s, routine.name, symbols):
                sizes.pop(key, None)
    while odd := [pair for pair in handed if sizes.get(pair[0]) != sizes.get(pair[1])]:
        for key in {key for pair in odd for key in pair}:
            sizes.pop(key, None)
    if not sizes:
        return program
    for (_, name), dimensions in sizes.items():
        shape = " by ".join(map(str, dimensions))
        work.notes.append(f"{name}: {shape} elements in one row, the last index runs first")
    rows = _SingleRows(work, symbols, sizes)
    routines = tuple(
        replace(
            r,
            body=tuple(rows.statement(s, r.name) for s in r.body),
            data=tuple(rows.declared(d, r.name) for d in r.data),
            parameters=tuple(rows.taken(p, r.name) for p in r.parameters),
        )
        for r in program.routines
    )
    return replace(program, routines=routines, data=tuple(rows.declared(d, "") for d in program.data))


def _is_flat(symbol: Symbol, work: TranslationContext) -> bool:
    return work.limits.dimensions == _ONE or symbol.type not in _NUMBERS


def _tables(program: st.Program, symbols: Symbols) -> dict[tuple[str, str], tuple[tuple[int, ...], Symbol]]:
    """Scope and name of each array of several dimensions whose ends are known -> its sizes."""
    found = {}
    for d in program.data:
        if len(d.sizes) > 1:
            symbols.find("", d.name)  # which makes its symbol
    for symbol in symbols.table.values():
        if len(symbol.sizes) > 1:
            sizes = sizes_of(symbols, symbol)
            if sizes and len(sizes) == len(symbol.sizes) and all(size > 0 for size in sizes):
                found[(symbol.scope, symbol.name)] = (sizes, symbol)
    return found


def _undeclared_tables(
    program: st.Program, symbols: Symbols, work: TranslationContext
) -> dict[tuple[str, str], tuple[int, ...]]:
    """Of arrays that no file at hand declares the largest indices written out; some more where others are computed."""
    if not any(
        _is_open_table(e, routine.name, symbols)
        for routine in program.routines
        for e in work.look(routine).expressions
    ):
        return {}
    uses: dict[str, Use] = {}
    for name, use in uses_of(program, work).items():
        numbers = work.limits.dimensions == _NUMBERS_ALONE and use.kind in _NUMBERS
        if not numbers and len(use.sizes) > 1 and len({len(row) for row in use.indices}) == 1:
            uses[name] = use
    sizes: dict[str, tuple[int, ...]] = {}
    for kept in range(_KEPT, 0, -1):
        sizes = {
            name: tuple(
                max(1, *(kept if at is None else at for at in column))
                for column in zip(*use.indices, strict=True)
            )
            for name, use in uses.items()
        }
        if _have_room(sizes, uses, work):
            break
    work.row_sizes.update({name: math.prod(found) for name, found in sizes.items()})
    return {("", name): found for name, found in sizes.items()}


def _have_room(
    sizes: Mapping[str, tuple[int, ...]], uses: Mapping[str, Use], work: TranslationContext
) -> bool:
    """Whether the rows leave half of the target's numbered variables to what is declared."""
    registers = work.limits.registers
    if registers is None:
        return True
    taken: Counter[ex.Store] = Counter()
    for name, found in sizes.items():
        taken[registers.stores.get(uses[name].kind, ex.Store.REAL)] += math.prod(found)
    return all(2 * count <= work.limits.most_numbered(store) for store, count in taken.items())


def _is_open_table(e: ex.Expression, routine: str, symbols: Symbols) -> bool:
    """Whether an expression is an element, by several indices, of an array that nothing declares."""
    if type(e) is not ex.Item or type(e.base) is not ex.Named or len(e.indices) < 2:
        return False
    symbol = symbols.find(routine, e.base.name)
    return symbol is None or not symbol.declared


def _handed_tables(program: st.Program, symbols: Symbols) -> list[tuple[tuple[str, str], tuple[str, str]]]:
    """Each array that a call hands over as a whole, with the parameter that takes it, by scope and name."""
    found = []
    for routine in program.routines:
        for s in routine.body:
            for called, arguments in handed_over(s):
                taker = symbols.routines.get(called)
                for name, e in paired(taker.parameters, arguments) if taker is not None else ():
                    if type(e) is ex.Named:
                        found.append((_key(symbols, routine.name, e.name), (called, name)))
    return found


def _key(symbols: Symbols, routine: str, name: str) -> tuple[str, str]:
    symbol = symbols.find(routine, name)
    return ("", name) if symbol is None else (symbol.scope, symbol.name)


def _named_whole(s: st.Statement, routine: str, symbols: Symbols) -> Iterator[tuple[str, str]]:
    """Names that a statement takes otherwise than element by element, or as what a routine of the program takes."""
    if calls_nothing(s) or isinstance(s, st.Declare):
        return
    elements = Counter(
        e.name
        for called, arguments in handed_over(s)
        if called in symbols.routines
        for e in arguments
        if type(e) is ex.Named
    )
    names: Counter[str] = Counter()
    for e in expressions_of(s):
        if type(e) is ex.Named:
            names[e.name] += 1
        elif type(e) is ex.Item and type(e.base) is ex.Named and len(e.indices) > 1:
            elements[e.base.name] += 1
    for name, count in names.items():
        if count != elements[name]:
            yield _key(symbols, routine, name)


@dataclass(slots=True)
class _SingleRows:
    """`sizes`: of the arrays that become a row, by scope and name."""

    work: TranslationContext
    symbols: Symbols
    sizes: dict[tuple[str, str], tuple[int, ...]]

    def _of(self, routine: str, name: str) -> tuple[int, ...] | None:
        return self.sizes.get(_key(self.symbols, routine, name))

    def taken(self, p: st.Parameter, routine: str) -> st.Parameter:
        sizes = self._of(routine, p.name) if len(p.sizes) > 1 else None
        return p if sizes is None else replace(p, sizes=(ex.Number(math.prod(sizes)),))

    def statement(self, s: st.Statement, routine: str) -> st.Statement:
        if isinstance(s, st.Declare):
            return self.declared(s, routine)
        if calls_nothing(s):
            return s

        def change(e: ex.Expression) -> ex.Expression:
            if type(e) is not ex.Item or type(e.base) is not ex.Named or len(e.indices) < 2:
                return e
            sizes = self._of(routine, e.base.name)
            if sizes is None or len(sizes) != len(e.indices):
                return e
            for index, size in zip(e.indices, sizes, strict=True):
                if isinstance(index, ex.Number) and not 1 <= index.value <= size:
                    says = f"{e.base.name} has {size} elements, and the index is {_shown(index)}"
                    self.work.lose(s, Fate.REFUSED, "index", says)
            return replace(e, indices=(_place(e.indices, sizes),))

        return mapped(s, change)

    def declared(self, d: st.Declare, routine: str) -> st.Declare:
        sizes = self._of(routine, d.name) if len(d.sizes) > 1 else None
        if sizes is None:
            return d
        value = d.value
        if isinstance(value, ex.RecordLiteral) and _is_array(value):
            value = replace(value, members=tuple(("", one) for _, one in _elements(value, ())))
        return replace(d, sizes=(ex.Number(math.prod(sizes)),), value=value)


def _place(indices: tuple[ex.Expression, ...], sizes: tuple[int, ...]) -> ex.Expression:
    """Where an element stands in the row, counted from 1."""
    fixed, terms = 1, list[ex.Expression]()
    for at, index in enumerate(indices):
        step = math.prod(sizes[at + 1 :])
        if isinstance(index, ex.Number):
            fixed += int(index.value - 1) * step
        else:
            fixed -= step
            terms.append(index if step == 1 else ex.Binary("*", index, ex.Number(step)))
    if not terms:
        return ex.Number(fixed)
    total = terms[0]
    for term in terms[1:]:
        total = ex.Binary("+", total, term)
    return total if not fixed else ex.Binary("+" if fixed > 0 else "-", total, ex.Number(abs(fixed)))


# --- Vectors ---
# URScript's computed p[…] for languages without rotation vectors: components are assigned one by one.

_TURNS: Final = ("rotation1", "rotation2", "rotation3")
_AXES: Final = ("x", "y", "z")
# Statements before which others can be put: what a loop's head computes is computed anew each time.
_SIMPLE: Final = (st.Assign, st.Move, st.Call, st.Return, st.SetOutput, st.Dwell, st.Message)
_ZERO: Final = ex.PositionLiteral("pose", (0.0,) * 6)


def vectors(program: st.Program, work: TranslationContext) -> st.Program:
    """p[x, y, z, a[3], a[4], a[5]] as a copy of `a` with another place; a[3] of a constant as its number."""
    if not work.conventions.pose_lists or work.target_conventions.pose_lists:
        return program
    own = _Vectors(work, work.symbols(program))
    routines = tuple(
        replace(r, body=tuple(row for s in r.body for row in own.rows(s, r.name))) for r in program.routines
    )
    return replace(program, routines=routines, data=(*program.data, *own.declared))


@dataclass(slots=True)
class _Vectors:
    work: TranslationContext
    symbols: Symbols
    declared: list[st.Declare] = field(default_factory=list)

    def rows(self, s: st.Statement, routine: str) -> list[st.Statement]:
        """The statement behind those that compute its positions."""
        if calls_nothing(s):
            return [s]
        if type(s) is st.Declare and type(s.value) is ex.Function and not s.shared:
            # What is computed is assigned: not every language computes where it declares.
            declared = replace(s, value=None, comment="")
            return [declared, *self.rows(st.Assign(s.line, ex.Named(s.name), s.value, s.comment), routine)]
        before: list[st.Statement] = []

        def change(e: ex.Expression) -> ex.Expression:
            if type(e) is ex.Function and e.name == "pose-vector" and isinstance(s, _SIMPLE):
                return self._copied(e, s.line, before)
            return e

        s = mapped(s, change)
        s = mapped(s, lambda e: self._component(e, routine))
        return [*[mapped(row, lambda e: self._component(e, routine)) for row in before], s]

    def _copied(self, e: ex.Function, line: int, before: list[st.Statement]) -> ex.Expression:
        turns = e.arguments[3:6]
        base = turns[0].base if type(turns[0]) is ex.Member else None
        if base is None or turns != tuple(ex.Member(base, name) for name in _TURNS):
            return e
        name = ex.Named(self.work.helper("position"))
        self.declared.append(st.Declare(0, name.name, "position", _ZERO, shared=True))
        before.append(st.Assign(line, name, base))
        for axis, value in zip(_AXES, e.arguments[:3], strict=True):
            written = _in_mm(value)
            if written != ex.Member(base, axis):
                before.append(st.Assign(line, ex.Member(name, axis), written))
        return name

    def _component(self, e: ex.Expression, routine: str) -> ex.Expression:
        """A component of the rotation vector [rad] of a position that nothing changes."""
        if type(e) is not ex.Member or e.name not in _TURNS:
            return e
        value = self.symbols.fixed_value(routine, e.base)
        if type(value) is not ex.PositionLiteral or value.kind != "pose" or len(value.values) < 6:
            return e
        return ex.Number(_rotation_vector(value.values)[_TURNS.index(e.name)])


def _in_mm(e: ex.Expression) -> ex.Expression:
    """A length in metres as one in millimetres, with numbers folded."""
    match e:
        case ex.Binary("+" | "-" as operator, left, right):
            return ex.Binary(operator, _in_mm(left), _in_mm(right))
        case _:
            return ex.scaled(e, 1000)


def _rotation_vector(values: tuple[float, ...]) -> tuple[float, ...]:
    """[rad] of a pose's angles."""
    from olp.robots.geometry import quaternion_from_rotation, rotation_from_angles

    w, x, y, z = (float(v) for v in quaternion_from_rotation(rotation_from_angles(values[3:6])))
    size = math.sqrt(x * x + y * y + z * z)
    angle = 2.0 * math.atan2(size, w)
    scale = angle / size if size > 0.0 else 0.0
    return tuple(float(f"{v * scale:.12g}") for v in (x, y, z))


# --- Sums ---
# Positions that some languages add and subtract element by element, for languages that cannot.

_ELEMENTS: Final = (*_AXES, "rz", "ry", "rx")


def sums(program: st.Program, work: TranslationContext) -> st.Program:
    """PR[1]=PR[2]+PR[3] as a copy of the first with elements that are set one by one."""
    if not work.conventions.sums_of_positions or work.target_conventions.sums_of_positions:
        return program
    own = _Sums(work, work.symbols(program))
    routines = tuple(
        replace(r, body=tuple([row for s in r.body for row in own.rows(s, r.name)])) for r in program.routines
    )
    return replace(program, routines=routines, data=(*program.data, *own.declared))


@dataclass(slots=True)
class _Sums:
    work: TranslationContext
    symbols: Symbols
    declared: list[st.Declare] = field(default_factory=list)

    def rows(self, s: st.Statement, routine: str, kind: str = "") -> list[st.Statement]:
        """`kind`: of the target, where the program does not declare it."""
        if type(s) is not st.Assign or type(s.value) is not ex.Binary or s.value.operator not in ("+", "-"):
            return [s]
        kind = kind or kind_of_value(self.symbols, routine, s.target)
        if type(s.target) is ex.FrameRef:  # a tool or a frame by its number gets the sum as a whole
            rows: list[st.Statement] = []
            whole = self._place(s.value, s, "position", routine, rows)
            return [*rows, replace(s, value=whole)]
        if kind not in ("position", "joints") or isinstance(s.target, ex.Member):
            return [s]
        sign, left, right = s.value.operator, s.value.left, s.value.right
        if sign == "-" and left == right:
            return [replace(s, value=ex.PositionLiteral("joint" if kind == "joints" else "pose", (0.0,) * 6))]
        rows = []
        first, second = (self._place(e, s, kind, routine, rows) for e in (left, right))
        if left != s.target:
            rows.append(st.Assign(s.line, s.target, first, s.comment))
        for target, one, other in zip(*(_parts(e, kind) for e in (s.target, first, second)), strict=True):
            rows.append(st.Assign(s.line, target, ex.Binary(sign, one, other)))
        return rows

    def _place(
        self, e: ex.Expression, s: st.Assign, kind: str, routine: str, rows: list[st.Statement]
    ) -> ex.Named | ex.Item:
        """A variable that holds `e` and that the statement does not change."""
        if isinstance(e, (ex.Named, ex.Item)) and e != s.target:
            return e
        name = ex.Named(self.work.helper("position"))
        self.declared.append(st.Declare(0, name.name, kind, None if kind == "joints" else _ZERO, shared=True))
        if type(e) is ex.Binary:
            rows += self.rows(st.Assign(s.line, name, e), routine, kind)
        else:
            rows.append(st.Assign(s.line, name, e))
        return name


def _parts(e: ex.Expression, kind: str) -> list[ex.Expression]:
    if kind == "joints":
        return [ex.Item(e, (ex.Number(n),)) for n in range(1, 7)]
    return [ex.Member(e, name) for name in _ELEMENTS]


# --- Sums of poses ---
# URScript adds and subtracts the places of two poses, and composes their turns.

_COMPOSED: Final = {"pose-add": "+", "pose-subtract": "-"}
_HOLDING: Final = (st.Assign, st.Declare, st.Move, st.Return)


def composed_poses(program: st.Program, work: TranslationContext) -> st.Program:
    """`pose_sub(a, b)` as a product of poses, which gives the turn, with elements that are set one by one."""
    if work.source.vendor == work.target:
        return program
    own = _ComposedPoses(work, frozenset(_COMPOSED) - {"pose-add" if work.limits.pose_sums else ""})
    if not any(own.is_composed(e) for r in program.routines for e in work.look(r).expressions):
        return program
    routines = tuple([replace(r, body=tuple(own.body(r))) for r in program.routines])
    return replace(program, routines=routines, data=(*program.data, *own.declared))


def _is_shift(e: ex.Function) -> bool:
    """Whether the second pose does not turn: the sum is an offset."""
    second = e.arguments[1]
    if type(second) is ex.Function and second.name == "pose-vector":
        return all(one == ex.Number(0) for one in second.arguments[3:6])
    return type(second) is ex.PositionLiteral and not any(second.values[3:6])


@dataclass(slots=True)
class _ComposedPoses:
    work: TranslationContext
    names: frozenset[str]  # of the functions that the target does not have
    declared: list[st.Declare] = field(default_factory=list)

    def is_composed(self, e: ex.Expression) -> bool:
        return type(e) is ex.Function and e.name in self.names and len(e.arguments) == 2 and not _is_shift(e)

    def body(self, routine: st.Routine) -> Iterator[st.Statement]:
        for s in routine.body:
            if not isinstance(s, _HOLDING) or not any(map(self.is_composed, expressions_of(s))):
                yield s
                continue
            rows: list[st.Statement] = []
            changed = mapped(s, partial(self._change, s.line, rows))
            if isinstance(changed, st.Declare):
                yield replace(changed, value=None)
                yield from rows
                assert changed.value is not None
                yield st.Assign(s.line, ex.Named(changed.name), changed.value)
            else:
                yield from rows
                yield changed

    def _change(self, line: int, rows: list[st.Statement], e: ex.Expression) -> ex.Expression:
        if type(e) is not ex.Function or not self.is_composed(e):
            return e
        first, second = (self._held(line, rows, one) for one in e.arguments)
        result = self._new()
        sign = _COMPOSED[e.name]
        turned = (first, second) if sign == "+" else (ex.Function("pose-inverse", (second,)), first)
        rows.append(st.Assign(line, result, ex.Function("pose-product", turned)))
        for axis in _AXES:
            value = ex.Binary(sign, ex.Member(first, axis), ex.Member(second, axis))
            rows.append(st.Assign(line, ex.Member(result, axis), value))
        return result

    def _held(self, line: int, rows: list[st.Statement], e: ex.Expression) -> ex.Expression:
        if type(e) is ex.Named:
            return e
        name = self._new()
        rows.append(st.Assign(line, name, e))
        return name

    def _new(self) -> ex.Named:
        name = ex.Named(self.work.helper("position"))
        self.declared.append(st.Declare(0, name.name, "position", _ZERO, shared=True))
        return name


# --- Texts ---
# KRL's texts, which are arrays of characters, as the one value that they are elsewhere.

_WHOLE = ex.Unknown("")  # an index that is left out


class _TextRow(NamedTuple):
    """A text as an array of characters. `scope`: the routine that declares it, "" for those of the whole program."""

    scope: str
    indices: int


def texts(program: st.Program, work: TranslationContext) -> st.Program:
    """NAME[] is the text itself, NAMES[2,] one of several; characters that are never taken together are texts of one.

    A single character of a text is read as a part of it; setting one is refused.
    """
    if not work.conventions.text_arrays:
        return program
    rows = _text_rows(program, work)
    single = _characters(program, rows, work)

    def shorter(d: st.Declare, scope: str) -> st.Declare:
        return d if (scope, d.name.casefold()) in single else _shorter(d)

    routines: list[st.Routine] = []
    for r in program.routines:
        known = {name: row for name, row in rows[r.name].items() if (row.scope, name) not in single}
        changed = changed_rare(
            r,
            work.look(r),
            lambda s, r=r, known=known: _row(
                shorter(s, r.name) if isinstance(s, st.Declare) else s, known, work
            ),
        )
        routines.append(replace(changed, data=tuple(shorter(d, r.name) for d in r.data)))
    return replace(program, routines=tuple(routines), data=tuple(shorter(d, "") for d in program.data))


def _text_rows(program: st.Program, work: TranslationContext) -> dict[str, dict[str, _TextRow]]:
    """By routine the texts that it may name, in lower case."""
    shared = {
        d.name.casefold(): _TextRow("", len(d.sizes)) for d in program.data if d.type == "string" and d.sizes
    }
    found: dict[str, dict[str, _TextRow]] = {}
    for r in program.routines:
        own = dict(shared)
        for d in _declared(r, work):
            own.pop(d.name.casefold(), None)
            if d.type == "string" and d.sizes:
                own[d.name.casefold()] = _TextRow(r.name, len(d.sizes))
        for p in r.parameters:
            own.pop(p.name.casefold(), None)
            if p.type == "string" and p.native.endswith("[]"):  # whose last index its type has
                own[p.name.casefold()] = _TextRow(r.name, len(p.sizes) + 1)
        found[r.name] = own
    return found


def _characters(
    program: st.Program, rows: Mapping[str, Mapping[str, _TextRow]], work: TranslationContext
) -> set[tuple[str, str]]:
    """Of the arrays of characters those of which each use names one character, by scope and name in lower case."""
    counts: dict[tuple[str, str], list[int]] = {}  # uses, and those of one character
    for r in program.routines:
        known = rows[r.name]
        taken = {p.name.casefold() for p in r.parameters}
        for _, s in work.look(r).rare if known else ():
            for e in () if isinstance(s, st.Declare) else expressions_of(s):
                named = type(e) is ex.Named
                text = e if named else _character(e, known)
                name = "" if text is None else text.name.casefold()
                if name in known and name not in taken:
                    counts.setdefault((known[name].scope, name), [0, 0])[0 if named else 1] += 1
    given = {("", d.name.casefold()) for d in program.data if d.value is not None}
    return {key for key, (uses, characters) in counts.items() if key not in given and uses == characters}


def _character(e: ex.Expression, rows: Mapping[str, _TextRow]) -> ex.Named | None:
    """The text of which an expression names one character."""
    if type(e) is not ex.Item or type(e.base) is not ex.Named:
        return None
    row = rows.get(e.base.name.casefold())
    return e.base if row is not None and len(e.indices) == row.indices and e.indices[-1] != _WHOLE else None


def _declared(routine: st.Routine, work: TranslationContext) -> list[st.Declare]:
    return [*(s for _, s in work.look(routine).rare if isinstance(s, st.Declare)), *routine.data]


def _row(s: st.Statement, rows: Mapping[str, _TextRow], work: TranslationContext) -> st.Statement:
    target = s.target if isinstance(s, st.Assign) else None
    if target is not None and (set_one := _character(target, rows)) is not None:
        work.lose(s, Fate.REFUSED, "statement", f"setting a single character of the text {set_one.name}")

    def change(e: ex.Expression) -> ex.Expression:
        if e is not target and type(e) is ex.Item and _character(e, rows) is not None:
            text = ex.Item(e.base, e.indices[:-1]) if len(e.indices) > 1 else e.base
            return ex.Function("part-of-text", (text, e.indices[-1], ex.Number(1)))
        return _matched(_whole(e))

    return mapped(s, change)


def _matched(e: ex.Expression) -> ex.Expression:
    """Where a text stands, 0: nowhere, from one more than the length: nowhere."""
    if type(e) is not ex.Function or e.name != "find-in-text":
        return e
    behind = ex.Binary("+", ex.Function("length-of-text", e.arguments[:1]), ex.Number(1))
    return ex.Binary("mod", ex.Function("match-in-text", e.arguments), behind)


def _shorter(d: st.Declare) -> st.Declare:
    return replace(d, sizes=d.sizes[:-1]) if d.type == "string" and d.sizes else d


def _whole(e: ex.Expression) -> ex.Expression:
    if type(e) is not ex.Item or (e.indices and e.indices[-1] != _WHOLE):
        return e
    indices = [index for index in e.indices if index != _WHOLE]
    return ex.Item(e.base, tuple(indices)) if indices else e.base
