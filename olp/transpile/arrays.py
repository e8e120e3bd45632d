"""How many elements arrays have; what an index takes from beyond them is refused, for it is another variable."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterator, Mapping, Set
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Final

from olp.ir.expressions import (
    Binary,
    Expression,
    Function,
    Item,
    Member,
    Named,
    Number,
    PositionLiteral,
    RecordLiteral,
    Unknown,
)
from olp.ir.program import (
    Assign,
    Call,
    Declare,
    Dwell,
    Message,
    Move,
    Program,
    Return,
    Routine,
    SetOutput,
    Statement,
)
from olp.ir.transformer import calls_nothing, expressions_of, mapped
from olp.transpile.constant_folding import calls_of, paired
from olp.transpile.context import Fate, TranslationContext
from olp.transpile.occurrences import changed_rare
from olp.transpile.symbols import Symbol, Symbols, kind_of_value, symbols_of

_ONE, _ANY = "one", "any"  # what Limits.dimensions says


def sizes_of(symbols: Symbols, symbol: Symbol) -> tuple[int, ...] | None:
    """The elements of each dimension; () of what is no array, None where nothing at hand tells."""
    found = []
    for size in symbol.sizes:
        value = symbols.fixed_value(symbol.scope, size)
        if not isinstance(value, Number):
            return _listed(symbol) if len(symbol.sizes) == 1 else None
        found.append(int(value.value))
    return tuple(found) if found else _listed(symbol)


def _listed(symbol: Symbol) -> tuple[int, ...] | None:
    """Of an array whose elements are written out and nothing else says how many there are."""
    if isinstance(symbol.value, RecordLiteral) and all(not name for name, _ in symbol.value.members):
        return (len(symbol.value.members),)
    return None if symbol.sizes else ()


_OPEN: Final = Unknown("")  # how many elements a parameter has where its caller decides


def array_parameters(program: Program, work: TranslationContext) -> Program:
    """Arrays that routines take have as many elements as what all calls hand over, where that is one number."""
    while True:
        symbols = work.symbols(program)
        changed = [_sized(r, program, symbols) for r in program.routines]
        if all(new is old for new, old in zip(changed, program.routines, strict=True)):
            return program
        program = replace(program, routines=tuple(changed))  # what a routine hands on is known now


def _sized(routine: Routine, program: Program, symbols: Symbols) -> Routine:
    if not any(_OPEN in p.sizes for p in routine.parameters):
        return routine
    given: dict[str, set[tuple[int, ...] | None]] = {}
    for caller, call in calls_of(routine, program):
        for name, e in paired(routine.parameters, call.arguments):
            e = e.base if type(e) is Item and not e.indices else e
            symbol = symbols.find(caller.name, e.name) if type(e) is Named else None
            given.setdefault(name, set()).add(None if symbol is None else sizes_of(symbols, symbol))
    parameters = []
    for p in routine.parameters:
        sizes = given.get(p.name, set())
        found = next(iter(sizes)) if len(sizes) == 1 else None
        known = _OPEN in p.sizes and found is not None and len(found) == len(p.sizes)
        parameters.append(replace(p, sizes=tuple(map(Number, found or ()))) if known else p)
    same = all(new is old for new, old in zip(parameters, routine.parameters, strict=True))
    return routine if same else replace(routine, parameters=tuple(parameters))


def array_sizes(program: Program, work: TranslationContext) -> Program:
    """Sizes that a program asks for (RAPID's Dim) as numbers, where the declaration tells them."""
    if not any(_asks_size(e) for r in program.routines for e in work.look(r).expressions):
        return program
    symbols = work.symbols(program)

    def change(routine: str, e: Expression) -> Expression:
        if type(e) is not Function or not _asks_size(e):
            return e
        array, dimension = e.arguments
        symbol = symbols.find(routine, array.name) if type(array) is Named else None
        sizes = None if symbol is None else sizes_of(symbols, symbol)
        at = int(dimension.value) if type(dimension) is Number else 0
        return Number(sizes[at - 1]) if sizes and 1 <= at <= len(sizes) else e

    routines = [
        replace(r, body=tuple([mapped(s, partial(change, r.name)) for s in r.body])) for r in program.routines
    ]
    return replace(program, routines=tuple(routines))


def _asks_size(e: Expression) -> bool:
    return type(e) is Function and e.name == "size-of-array"


def largest_indices(program: Program, work: TranslationContext) -> dict[str, int]:
    """The largest index that is written out of each array of one dimension."""
    found: dict[str, int] = {}
    for routine in program.routines:
        for e in work.look(routine).expressions:
            if type(e) is Item and type(e.base) is Named and len(e.indices) == 1:
                index = e.indices[0]
                if type(index) is Number:
                    found[e.base.name] = max(found.get(e.base.name, 1), int(index.value))
    return found


def array_bounds(program: Program, work: TranslationContext) -> Program:
    """Refuses elements beyond an array's end; for numbered languages also computed ones where no end is known."""
    if not any(type(e) is Item for routine in program.routines for e in work.look(routine).expressions):
        return program
    symbols = work.symbols(program)
    for routine in program.routines:
        for _, s in work.look(routine).rare:
            for e in expressions_of(s):
                says = _wrong(symbols, routine.name, e, bool(work.limits.numbered)) if type(e) is Item else ""
                if says:
                    work.lose(s, Fate.REFUSED, "index", says)
                    break
    return program


def _wrong(symbols: Symbols, routine: str, e: Item, numbered: bool) -> str:
    """What is wrong with an element of an array, nothing where it is one, or no array of a program's own."""
    symbol = symbols.find(routine, e.base.name) if type(e.base) is Named else None
    if symbol is None:
        return ""
    sizes = sizes_of(symbols, symbol)
    if sizes == ():
        return ""
    values = [symbols.fixed_value(routine, index) for index in e.indices]
    if sizes is None or not all(sizes):
        unknown = numbered and not all(isinstance(value, Number) for value in values)
        return (
            f"nothing tells how many elements {symbol.name} has, and the index is computed" if unknown else ""
        )
    for value, size in zip(values, sizes, strict=False):
        if isinstance(value, Number) and not 1 <= value.value <= size:
            return f"{symbol.name} has {size} elements, and the index is {_shown(value)}"
    return ""


def _shown(e: Expression) -> str:
    return f"{e.value:g}" if isinstance(e, Number) else ""


# --- Array values ---
# Arrays that are assigned as a whole, element by element where the target has no such value.


def array_values(program: Program, work: TranslationContext) -> Program:
    """`a := [[1,2],[3,4]]` as four assignments."""
    if work.limits.array_literals:
        return program
    if not any(_sets_array(s) for r in program.routines for _, s in work.look(r).rare):
        return program
    routines = tuple(
        replace(r, body=tuple(row for s in r.body for row in _rows(s))) for r in program.routines
    )
    return replace(program, routines=routines)


def _sets_array(s: Statement) -> bool:
    return type(s) is Assign and type(s.target) is Named and _is_array(s.value)


def _rows(s: Statement) -> tuple[Statement, ...]:
    if type(s) is not Assign or not _sets_array(s):
        return (s,)
    rows = [Assign(s.line, Item(s.target, at), value) for at, value in _elements(s.value, ())]
    return (replace(rows[0], comment=s.comment), *rows[1:]) if rows else (s,)


def _is_array(e: Expression) -> bool:
    return type(e) is RecordLiteral and bool(e.members) and not any(name for name, _ in e.members)


def _elements(
    e: Expression, before: tuple[Expression, ...]
) -> Iterator[tuple[tuple[Expression, ...], Expression]]:
    if type(e) is not RecordLiteral or not _is_array(e):
        yield before, e
        return
    for place, (_, value) in enumerate(e.members, 1):
        yield from _elements(value, (*before, Number(place)))


# --- Rows of rows ---
# Arrays of several dimensions as one row, where the target has registers, or no list of lists of such a kind.

_NUMBERS: Final = ("real", "integer")
KEPT_ROWS: Final = 10  # of a dimension with a computed index, where nothing declares the array


def single_rows(program: Program, work: TranslationContext) -> Program:
    """`g{2,3}` of an array of 2 by 4 as the element 7 of a row of 8. What is named as a whole stays as it is."""
    if work.limits.dimensions == _ANY:
        return program
    symbols = symbols_of(program)
    sizes = {key: found for key, (found, s) in _tables(program, symbols).items() if _is_flat(s, work)}
    if work.limits.dimensions == _ONE:
        sizes |= _undeclared_tables(program, symbols, work)
    for routine in program.routines if sizes else ():
        for s in routine.body:
            for key in _named_whole(s, routine.name, symbols):
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
        )
        for r in program.routines
    )
    return replace(program, routines=routines, data=tuple(rows.declared(d, "") for d in program.data))


def _is_flat(symbol: Symbol, work: TranslationContext) -> bool:
    return work.limits.dimensions == _ONE or symbol.type not in _NUMBERS


def _tables(program: Program, symbols: Symbols) -> dict[tuple[str, str], tuple[tuple[int, ...], Symbol]]:
    """Scope and name of each array of several dimensions whose ends are known -> its sizes."""
    found = {}
    for d in program.data:
        if len(d.sizes) > 1:
            symbols.find("", d.name)  # which makes its symbol
    for symbol in symbols.table.values():
        if len(symbol.sizes) > 1 and symbol.parameter is None:
            sizes = sizes_of(symbols, symbol)
            if sizes and len(sizes) == len(symbol.sizes) and all(size > 0 for size in sizes):
                found[(symbol.scope, symbol.name)] = (sizes, symbol)
    return found


def _undeclared_tables(
    program: Program, symbols: Symbols, work: TranslationContext
) -> dict[tuple[str, str], tuple[int, ...]]:
    """Of arrays that no file at hand declares the largest indices written out; some more where others are computed."""
    found: dict[tuple[str, str], tuple[int, ...]] = {}
    odd: set[tuple[str, str]] = set()
    for routine in program.routines:
        for e in work.look(routine).expressions:
            if type(e) is not Item or type(e.base) is not Named or len(e.indices) < 2:
                continue
            symbol = symbols.find(routine.name, e.base.name)
            key = ("", e.base.name)
            if symbol is not None and symbol.declared:
                continue
            written = [int(one.value) if isinstance(one, Number) else KEPT_ROWS for one in e.indices]
            before = found.get(key, (1,) * len(e.indices))
            if len(before) != len(written):
                odd.add(key)
            else:
                found[key] = tuple(map(max, before, written))
    found = {key: sizes for key, sizes in found.items() if key not in odd}
    work.row_sizes.update({name: math.prod(sizes) for (_, name), sizes in found.items()})
    return found


def _named_whole(s: Statement, routine: str, symbols: Symbols) -> Iterator[tuple[str, str]]:
    """Names that a statement takes otherwise than element by element."""
    if calls_nothing(s) or isinstance(s, Declare):
        return
    elements: Counter[str] = Counter()
    names: Counter[str] = Counter()
    for e in expressions_of(s):
        if type(e) is Named:
            names[e.name] += 1
        elif type(e) is Item and type(e.base) is Named and len(e.indices) > 1:
            elements[e.base.name] += 1
    for name, count in names.items():
        if count != elements[name]:
            symbol = symbols.find(routine, name)
            yield ("", name) if symbol is None else (symbol.scope, symbol.name)


@dataclass(slots=True)
class _SingleRows:
    """`sizes`: of the arrays that become a row, by scope and name."""

    work: TranslationContext
    symbols: Symbols
    sizes: dict[tuple[str, str], tuple[int, ...]]

    def _of(self, routine: str, name: str) -> tuple[int, ...] | None:
        symbol = self.symbols.find(routine, name)
        return self.sizes.get(("", name) if symbol is None else (symbol.scope, symbol.name))

    def statement(self, s: Statement, routine: str) -> Statement:
        if isinstance(s, Declare):
            return self.declared(s, routine)
        if calls_nothing(s):
            return s

        def change(e: Expression) -> Expression:
            if type(e) is not Item or type(e.base) is not Named or len(e.indices) < 2:
                return e
            sizes = self._of(routine, e.base.name)
            if sizes is None or len(sizes) != len(e.indices):
                return e
            for index, size in zip(e.indices, sizes, strict=True):
                if isinstance(index, Number) and not 1 <= index.value <= size:
                    says = f"{e.base.name} has {size} elements, and the index is {_shown(index)}"
                    self.work.lose(s, Fate.REFUSED, "index", says)
            return replace(e, indices=(_place(e.indices, sizes),))

        return mapped(s, change)

    def declared(self, d: Declare, routine: str) -> Declare:
        sizes = self._of(routine, d.name) if len(d.sizes) > 1 else None
        if sizes is None:
            return d
        value = d.value
        if isinstance(value, RecordLiteral) and _is_array(value):
            value = replace(value, members=tuple(("", one) for _, one in _elements(value, ())))
        return replace(d, sizes=(Number(math.prod(sizes)),), value=value)


def _place(indices: tuple[Expression, ...], sizes: tuple[int, ...]) -> Expression:
    """Where an element stands in the row, counted from 1."""
    fixed, terms = 1, list[Expression]()
    for at, index in enumerate(indices):
        step = math.prod(sizes[at + 1 :])
        if isinstance(index, Number):
            fixed += int(index.value - 1) * step
        else:
            fixed -= step
            terms.append(index if step == 1 else Binary("*", index, Number(step)))
    if not terms:
        return Number(fixed)
    total = terms[0]
    for term in terms[1:]:
        total = Binary("+", total, term)
    return total if not fixed else Binary("+" if fixed > 0 else "-", total, Number(abs(fixed)))


# --- Vectors ---
# URScript's computed p[…] for languages without rotation vectors: components are assigned one by one.

_TURNS: Final = ("rotation1", "rotation2", "rotation3")
_AXES: Final = ("x", "y", "z")
# Statements before which others can be put: what a loop's head computes is computed anew each time.
_SIMPLE: Final = (Assign, Move, Call, Return, SetOutput, Dwell, Message)
_ZERO: Final = PositionLiteral("pose", (0.0,) * 6)


def vectors(program: Program, work: TranslationContext) -> Program:
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
    declared: list[Declare] = field(default_factory=list)

    def rows(self, s: Statement, routine: str) -> list[Statement]:
        """The statement behind those that compute its positions."""
        if calls_nothing(s):
            return [s]
        if type(s) is Declare and type(s.value) is Function and not s.shared:
            # What is computed is assigned: not every language computes where it declares.
            declared = replace(s, value=None, comment="")
            return [declared, *self.rows(Assign(s.line, Named(s.name), s.value, s.comment), routine)]
        before: list[Statement] = []

        def change(e: Expression) -> Expression:
            if type(e) is Function and e.name == "pose-vector" and isinstance(s, _SIMPLE):
                return self._copied(e, s.line, before)
            return e

        s = mapped(s, change)
        s = mapped(s, lambda e: self._component(e, routine))
        return [*[mapped(row, lambda e: self._component(e, routine)) for row in before], s]

    def _copied(self, e: Function, line: int, before: list[Statement]) -> Expression:
        turns = e.arguments[3:6]
        base = turns[0].base if type(turns[0]) is Member else None
        if base is None or turns != tuple(Member(base, name) for name in _TURNS):
            return e
        name = Named(self.work.helper("position"))
        self.declared.append(Declare(0, name.name, "position", _ZERO, shared=True))
        before.append(Assign(line, name, base))
        for axis, value in zip(_AXES, e.arguments[:3], strict=True):
            written = _in_mm(value)
            if written != Member(base, axis):
                before.append(Assign(line, Member(name, axis), written))
        return name

    def _component(self, e: Expression, routine: str) -> Expression:
        """A component of the rotation vector [rad] of a position that nothing changes."""
        if type(e) is not Member or e.name not in _TURNS:
            return e
        value = self.symbols.fixed_value(routine, e.base)
        if type(value) is not PositionLiteral or value.kind != "pose" or len(value.values) < 6:
            return e
        return Number(_rotation_vector(value.values)[_TURNS.index(e.name)])


def _in_mm(e: Expression) -> Expression:
    """A length in metres as one in millimetres, with numbers folded."""
    match e:
        case Number(value):
            return Number(float(f"{value * 1000:.12g}"))
        case Binary("*", left, Number(factor)) if abs(factor * 1000 - 1) < 1e-12:
            return left
        case Binary("+" | "-" as operator, left, right):
            return Binary(operator, _in_mm(left), _in_mm(right))
        case _:
            return Binary("*", e, Number(1000))


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


def sums(program: Program, work: TranslationContext) -> Program:
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
    declared: list[Declare] = field(default_factory=list)

    def rows(self, s: Statement, routine: str, kind: str = "") -> list[Statement]:
        """`kind`: of the target, where the program does not declare it."""
        if type(s) is not Assign or type(s.value) is not Binary or s.value.operator not in ("+", "-"):
            return [s]
        kind = kind or kind_of_value(self.symbols, routine, s.target)
        if kind not in ("position", "joints") or isinstance(s.target, Member):
            return [s]
        sign, left, right = s.value.operator, s.value.left, s.value.right
        if sign == "-" and left == right:
            return [replace(s, value=PositionLiteral("joint" if kind == "joints" else "pose", (0.0,) * 6))]
        rows: list[Statement] = []
        first, second = (self._place(e, s, kind, routine, rows) for e in (left, right))
        if left != s.target:
            rows.append(Assign(s.line, s.target, first, s.comment))
        for target, one, other in zip(*(_parts(e, kind) for e in (s.target, first, second)), strict=True):
            rows.append(Assign(s.line, target, Binary(sign, one, other)))
        return rows

    def _place(
        self, e: Expression, s: Assign, kind: str, routine: str, rows: list[Statement]
    ) -> Named | Item:
        """A variable that holds `e` and that the statement does not change."""
        if isinstance(e, (Named, Item)) and e != s.target:
            return e
        name = Named(self.work.helper("position"))
        self.declared.append(Declare(0, name.name, kind, None if kind == "joints" else _ZERO, shared=True))
        if type(e) is Binary:
            rows += self.rows(Assign(s.line, name, e), routine, kind)
        else:
            rows.append(Assign(s.line, name, e))
        return name


def _parts(e: Expression, kind: str) -> list[Expression]:
    if kind == "joints":
        return [Item(e, (Number(n),)) for n in range(1, 7)]
    return [Member(e, name) for name in _ELEMENTS]


# --- Texts ---
# KRL's texts, which are arrays of characters, as the one value that they are elsewhere.

_WHOLE = Unknown("")  # an index that is left out


def texts(program: Program, work: TranslationContext) -> Program:
    """NAME[] is the text itself, NAMES[2,] one of several; characters that are never taken together are texts of one.

    A single character of a text is read as a part of it; setting one is refused.
    """
    if not work.conventions.text_arrays:
        return program
    rows = {
        d.name.casefold(): len(d.sizes)
        for d in (*program.data, *(d for r in program.routines for d in _declared(r, work)))
        if d.type == "string" and d.sizes
    }
    single = _characters(program, rows, work)
    rows = {name: count for name, count in rows.items() if name not in single}

    def shorter(d: Declare) -> Declare:
        return d if d.name.casefold() in single else _shorter(d)

    routines = tuple(
        replace(
            changed_rare(r, work.look(r), lambda s: _row(s, rows, single, work)),
            data=tuple(map(shorter, r.data)),
        )
        for r in program.routines
    )
    return replace(program, routines=routines, data=tuple(map(shorter, program.data)))


def _characters(program: Program, rows: Mapping[str, int], work: TranslationContext) -> set[str]:
    """Of the arrays of characters those of which each use names one character, in lower case."""
    counts: dict[str, list[int]] = {}  # uses, and those of one character
    for r in program.routines if rows else ():
        for p in r.parameters:
            counts.setdefault(p.name.casefold(), [0, 0])[0] += 1
        for _, s in work.look(r).rare:
            for e in () if isinstance(s, Declare) else expressions_of(s):
                if type(e) is Named:
                    counts.setdefault(e.name.casefold(), [0, 0])[0] += 1
                elif (character := _character(e, rows)) is not None:
                    counts.setdefault(character.name.casefold(), [0, 0])[1] += 1
    given = {d.name.casefold() for d in program.data if d.value is not None}
    return {
        name for name in rows if name not in given and (c := counts.get(name)) is not None and c[0] == c[1]
    }


def _character(e: Expression, rows: Mapping[str, int]) -> Named | None:
    """The text of which an expression names one character."""
    if type(e) is not Item or type(e.base) is not Named:
        return None
    return e.base if len(e.indices) == rows.get(e.base.name.casefold()) and e.indices[-1] != _WHOLE else None


def _declared(routine: Routine, work: TranslationContext) -> list[Declare]:
    return [*(s for _, s in work.look(routine).rare if isinstance(s, Declare)), *routine.data]


def _row(s: Statement, rows: Mapping[str, int], single: Set[str], work: TranslationContext) -> Statement:
    if isinstance(s, Declare):
        s = s if s.name.casefold() in single else _shorter(s)
    target = s.target if isinstance(s, Assign) else None
    if target is not None and (set_one := _character(target, rows)) is not None:
        work.lose(s, Fate.REFUSED, "statement", f"setting a single character of the text {set_one.name}")

    def change(e: Expression) -> Expression:
        if e is not target and type(e) is Item and _character(e, rows) is not None:
            text = Item(e.base, e.indices[:-1]) if len(e.indices) > 1 else e.base
            return Function("part-of-text", (text, e.indices[-1], Number(1)))
        return _matched(_whole(e))

    return mapped(s, change)


def _matched(e: Expression) -> Expression:
    """Where a text stands, 0: nowhere, from one more than the length: nowhere."""
    if type(e) is not Function or e.name != "find-in-text":
        return e
    behind = Binary("+", Function("length-of-text", e.arguments[:1]), Number(1))
    return Binary("mod", Function("match-in-text", e.arguments), behind)


def _shorter(d: Declare) -> Declare:
    return replace(d, sizes=d.sizes[:-1]) if d.type == "string" and d.sizes else d


def _whole(e: Expression) -> Expression:
    if type(e) is not Item or (e.indices and e.indices[-1] != _WHOLE):
        return e
    indices = [index for index in e.indices if index != _WHOLE]
    return Item(e.base, tuple(indices)) if indices else e.base
