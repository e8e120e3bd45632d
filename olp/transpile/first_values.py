"""First values of data, which may name other data: written out as the target needs them.

RAPID computes constants from each other in any order; KRL's lists hold only what is written out, URScript runs its
declarations one after the other, and registers are set by the program.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Set
from dataclasses import dataclass, replace
from itertools import product
from math import prod
from typing import Final, TypeGuard

from olp.ir import expressions as ex
from olp.ir import program as st
from olp.ir.points import Point
from olp.ir.transformer import expressions_of, mapped, note_names
from olp.runtime.assumptions import Given
from olp.runtime.memory import SAVED_NUMBERS, SAVED_POSITIONS, saved_position
from olp.transpile.context import SET_BACK, Fate, TranslationContext, world_of
from olp.transpile.occurrences import changed_rare
from olp.transpile.reaching_definitions import ENTRY, UNSET, Key, Reaching, reaching
from olp.transpile.symbols import Symbols, base_of

_NUMBERS_AND_TEXTS: Final = (ex.Number, ex.Text, ex.SignalState)
_PLAIN: Final = (*_NUMBERS_AND_TEXTS, ex.PositionLiteral, type(None))
_LEFT: Final = (ex.Named, ex.Item, ex.Binary)  # what is not known before the program runs
_SETTING: Final = frozenset({st.Assign, st.For, st.ReadInput, st.Call, st.Clear})
_DEEPEST: Final = 20  # a value that names a value that names …


def first_values(program: st.Program, work: TranslationContext) -> st.Program:
    """First values that the text can compute become literals."""
    if all(is_plain(d.value) for d in program.data) and not any(r.data for r in program.routines):
        return program
    symbols = work.symbols(program)
    routines = tuple(
        replace(r, data=tuple(_written(d, symbols, r.name, work) for d in r.data)) if r.data else r
        for r in program.routines
    )
    data = tuple(_written(d, symbols, "", work) for d in program.data)
    return replace(program, routines=routines, data=data)


def _written(s: st.Declare, symbols: Symbols, routine: str, work: TranslationContext) -> st.Declare:
    if is_plain(s.value) or isinstance(s.value, ex.Signal):
        return s
    value: ex.Expression | None = s.value
    for _ in range(_DEEPEST):
        found = mapped(value, lambda e: _known(e, symbols, routine))
        if found == value:
            break
        value = found
    if any(isinstance(e, _LEFT) for e in expressions_of(value)):
        says = f"what {s.name} begins with is computed from values that are not known here"
        work.lose(s, Fate.APPROXIMATED, "value", says)
        work.ask("set what no file at hand gives a value", s.name)
        return replace(s, value=None)
    value = _taught(s, value, work)
    return s if value is s.value else replace(s, value=value)


def is_plain(value: ex.Expression | None) -> bool:
    """Whether a value is written out: nothing in it is computed, nor a position to be taught."""
    if type(value) is ex.RecordLiteral:
        return all(type(e) in _NUMBERS_AND_TEXTS for _, e in value.members)
    return type(value) in _PLAIN


def _taught(s: st.Declare, value: ex.Expression | None, work: TranslationContext) -> ex.Expression | None:
    """An array of which some positions have no values, with zeros in their places if the target writes no such."""
    if not isinstance(value, ex.RecordLiteral) or work.source.vendor == work.target:
        return value
    found = mapped(value, lambda e: with_zeros(e) if is_untaught(e) else e)
    if found is value:
        return value
    work.ask("teach what no file here declares, or copy its values", f"elements of {s.name}")
    if work.limits.untaught_points:
        return value
    says = f"elements of {s.name} have no values: zeros are written in their places"
    work.lose(s, Fate.APPROXIMATED, "value", says)
    return found


def is_untaught(e: ex.Expression) -> TypeGuard[ex.PositionLiteral]:
    values = e.values if type(e) is ex.PositionLiteral else ()
    return bool(values) and values[0] != values[0] and all(v != v for v in values[:6])


def with_zeros(untaught: ex.PositionLiteral) -> ex.PositionLiteral:
    return replace(untaught, values=(0.0,) * 6)


def _known(e: ex.Expression, symbols: Symbols, routine: str) -> ex.Expression:
    """One step: a name as what it always is, an operation on numbers as its result."""
    match e:
        case ex.Named(name):
            symbol = symbols.find(routine, name)
            fixed = symbol.value if symbol is not None and symbol.is_fixed else None
            return fixed or e
        case ex.Item():
            return symbols.fixed_value(routine, e) or e
        case ex.Unary("-", ex.Number(value)):
            return ex.Number(-value)
        case ex.Unary("not", ex.SignalState(on)):
            return ex.SignalState(not on)
        case ex.Binary(operator, ex.Number(left), ex.Number(right)):
            return _computed(operator, left, right) or e
    return e


def _computed(operator: str, left: float, right: float) -> ex.Number | None:
    match operator:
        case "+":
            return ex.Number(left + right)
        case "-":
            return ex.Number(left - right)
        case "*":
            return ex.Number(left * right)
        case "/" if right:
            return ex.Number(float(f"{left / right:.12g}"))
        case "div" if right:
            return ex.Number(int(left / right))
    return None


# --- Values that last ---
# What a data list of KRL or a PERS of RAPID holds lives on when the program ends: a counter goes on where it stood, a
# tool or frame that the program shifts is shifted once more. Languages with such data keep tools and frames anyway.

_LASTS: Final = (
    "{} keeps its last value when the program starts again; there it begins with its first one each time"
)
_PLACED_DATA: Final = ("tool", "frame")
_UNSEEN: Final = "see that no other program needs what this one sets, as it sees no variable of it"
_SET_AGAIN: Final = (
    "see that no other program needs what these hold when this one starts: it sets their first values"
)


def persistent_variables(program: st.Program, work: TranslationContext) -> st.Program:
    """Variables whose last value the next run reads become persistent; reported where the target has no such data."""
    given = {d.name for d in program.data if lasts(d, work)}
    changed = _changed_parts(program, work)
    parts = {name: found for name, found in changed.items() if name in given}
    read = _read_first(program, parts) if parts else {}
    _ask_for_shared(program, work, changed.keys(), given - read.keys())
    if not parts:
        return program
    if work.limits.keeps_data:
        data = (replace(d, storage="persistent") if d.name in read else d for d in program.data)
        return replace(program, data=tuple(data))
    taught = _taught_places(program, work)
    for name, s in read.items():
        if name not in taught:
            work.lose(s, Fate.APPROXIMATED, "value", _LASTS.format(name))
    return program


def _ask_for_shared(
    program: st.Program, work: TranslationContext, changed: Set[str], begins: Set[str]
) -> None:
    """Asks about variables that other programs of the source see. `begins`: no run here reads their last values."""
    if work.source.vendor == work.target or work.limits.keeps_data:
        return
    for d in program.data:
        if not d.shared or d.name not in changed:
            continue
        if not work.limits.shares_programs and (d.name in work.registers or lasts(d, work)):
            work.ask(_UNSEEN, d.name)
        elif work.limits.shares_programs and d.name in begins - work.registers:
            work.ask(_SET_AGAIN, d.name)


def _taught_places(program: st.Program, work: TranslationContext) -> set[str]:
    """Positions whose values lie beside the target's program, where they live on as well."""
    if work.limits.registers is None or not work.limits.registers.steps:
        return set()
    return {d.name for d in program.data if _is_of_places(d.value)}


def _is_of_places(value: ex.Expression | None) -> bool:
    if isinstance(value, ex.RecordLiteral):
        return all(not name and isinstance(one, ex.PositionLiteral) for name, one in value.members)
    return isinstance(value, ex.PositionLiteral)


def lasts(d: st.Declare, work: TranslationContext) -> bool:
    """Whether a variable still has its last value when the program starts again."""
    known = d.value is not None and (d.type not in _PLACED_DATA or not work.limits.keeps_data)
    return known and (d.storage == "persistent" or (work.conventions.data_last and d.storage == "variable"))


def _changed_parts(program: st.Program, work: TranslationContext) -> dict[str, set[str]]:
    """By variable the members and elements that statements set, "" where they set all of it or one that is computed."""
    found: dict[str, set[str]] = {}
    for s in work.rare(program):
        for name, part in _parts_set(s):
            found.setdefault(name, set()).add(part)
    return found


def _parts_set(s: st.Statement) -> list[tuple[str, str]]:
    if type(s) is not st.Assign:
        return [(name, "") for name in _set_by(s)] if type(s) in _SETTING else []
    target = s.target
    if isinstance(target, ex.Member) and isinstance(target.base, ex.Named):
        return [(target.base.name, target.name)]
    if isinstance(target, ex.Item) and isinstance(target.base, ex.Named):
        place = [f"{i.value:g}" for i in target.indices if type(i) is ex.Number]
        return [(target.base.name, ",".join(place) if len(place) == len(target.indices) else "")]
    base = base_of(target)
    return [] if base is None else [(base.name, "")]


def _read_first(program: st.Program, parts: Mapping[str, Set[str]]) -> dict[str, st.Statement]:
    """Those of these variables that a statement reads before the program has set them, each with the first one."""

    def made(s: st.Statement) -> dict[Key, int]:
        keys: dict[Key, int] = {}
        for name, part in _parts_set(s):
            whole = not part and (type(s) is not st.Assign or isinstance(s.target, ex.Named))
            keys |= {(name, one): 1 for one in parts.get(name, ()) if whole or one == part != ""}
        return keys

    ways = reaching(program, made, _SETTING)
    found: dict[str, st.Statement] = {}
    for r in program.routines:
        own = {d.name for d in (*r.data, *(s for s in r.body if type(s) is st.Declare))}
        own |= {p.name for p in r.parameters}
        for index, s in enumerate(r.body):
            if ways.before[r.name][index] is None or type(s) is st.Comment:
                continue
            for name in sorted((_names_taken(s) & parts.keys()) - own - found.keys()):
                if any(UNSET in ways.at(r.name, index, (name, part)) for part in parts[name]):
                    found[name] = s
    return found


def _names_taken(s: st.Statement) -> set[str]:
    """Names of variables whose values a statement takes: of an assignment not what it sets."""
    if type(s) is not st.Assign:
        return _names_read(s)
    found: set[str] = set()
    note_names(s.value, found)
    for e in expressions_of(s.target):
        for index in e.indices if isinstance(e, ex.Item) else ():
            note_names(index, found)
    return found


# --- Variables without a first value ---
# Where a variable of the target has no value until it is set, what begins with zero in the source begins so there.

_ZEROS: Final[Mapping[str, ex.Expression]] = {
    "integer": ex.Number(0),
    "real": ex.Number(0),
    "boolean": ex.SignalState(False),
}
_NOTHING: Final[Mapping[str, ex.Expression]] = {
    **_ZEROS,
    "string": ex.Text(""),
    "position": ex.PositionLiteral("pose", (0.0,) * 6),
    "joints": ex.PositionLiteral("joint", (0.0,) * 6),
}
POSE_ELEMENTS: Final = ("x", "y", "z", "rx", "ry", "rz")  # in the order in which languages number them
_MOST_ZEROS: Final = 1000  # elements of an array that are written out
_MOST_LOCAL_ZEROS: Final = 100  # elements of a routine's own array that it sets one by one
_MOST_SHARED_ZEROS: Final = 20  # elements of a program's array that its first routine sets one by one
TEACH: Final = "teach these positions, which are zeros now"
_TEACH_REGISTERS: Final = "teach these positions"
TEACH_UNDECLARED: Final = "teach what no file here declares, or copy its values"
UNDECLARED: Final = "not declared in the source"  # whose value nobody knows: the controller stops there


def default_values(program: st.Program, work: TranslationContext) -> st.Program:
    """Numbers and booleans without a first value get the zero that the source gives them."""
    program = _set_by_runs(program, work)
    if not work.limits.unset_variables:
        return program
    _ask_anew(program, work)
    used = _elements_used(program, work)
    data = tuple(_begun(d, used.get(d.name, set())) for d in program.data)
    return replace(program, data=data, routines=_with_zeros(program))


def _elements_used(program: st.Program, work: TranslationContext) -> dict[str, set[tuple[int, ...]] | None]:
    """The elements of each array that statements name, None where an index is computed."""
    used: dict[str, set[tuple[int, ...]] | None] = {}
    for s in [s for r in program.routines for _, s in work.look(r).rare if type(s) is not st.Declare]:
        for e in expressions_of(s):
            if type(e) is ex.Item and type(e.base) is ex.Named:
                _note_element(e, e.base.name, used)
    return used


def filled_arrays(program: st.Program, work: TranslationContext) -> st.Program:
    """Arrays of which some elements have a first value (KRL's lists) with zeros for the others, where a declaration
    gives all values or none. Numbered variables are set one by one."""
    if work.limits.numbered or work.source.vendor == work.target:
        return program

    used: set[str] = set()

    def is_used(name: str) -> bool:
        if not used:
            used.update(*(work.look(r).names() for r in program.routines))
        return name in used

    def row(d: st.Declare) -> st.Declare:
        counts = [int(size.value) for size in d.sizes if type(size) is ex.Number]
        zero = _NOTHING.get(d.type)
        if not counts or len(counts) != len(d.sizes) or zero is None:
            return d
        value = _whole(d.value, counts, zero)
        if value is d.value:
            return d
        if is_used(d.name):
            says = f"elements of {d.name} that have no first value are zeros there"
            work.lose(d.line, Fate.APPROXIMATED, "value", says)
        return replace(d, value=value)

    def statement(s: st.Statement) -> st.Statement:
        return row(s) if isinstance(s, st.Declare) else s

    routines = [
        replace(changed_rare(r, work.look(r), statement), data=tuple(map(row, r.data)))
        for r in program.routines
    ]
    return replace(program, data=tuple(map(row, program.data)), routines=tuple(routines))


def _whole(value: ex.Expression | None, counts: list[int], zero: ex.Expression) -> ex.Expression | None:
    """The elements of an array, those that are left out as zeros; as it is where nothing is left out."""
    if not counts:
        return zero if value is None or value == ex.Unknown("") else value
    if not isinstance(value, ex.RecordLiteral) or any(name for name, _ in value.members):
        if value != ex.Unknown(""):
            return value
        value = ex.RecordLiteral("", ())
    given = [one for _, one in value.members][: counts[0]]
    given += [ex.Unknown("")] * (counts[0] - len(given))
    whole = [_whole(one, counts[1:], zero) for one in given]
    members = tuple(("", one) for one in whole if one is not None)
    return value if members == value.members else replace(value, members=members)


def reset_own_variables(program: st.Program, work: TranslationContext) -> st.Program:
    """Routines set their local variables at each call, for targets that keep the values from call to call."""
    if not work.conventions.data_begin_anew:
        return program
    return replace(program, routines=_with_zeros(program))


def shared_default_values(program: st.Program, work: TranslationContext) -> st.Program:
    """Data that are read before they are set get the zero with which each run of the source begins."""
    if not work.conventions.data_begin_anew:
        return program
    open_ = {
        d.name
        for d in program.data
        if d.type in _ZEROS and d.value is None and d.storage == "variable" and d.comment != UNDECLARED
    } - work.helpers
    if not open_:
        return program
    parts = _changed_parts(program, work)
    read = _read_first(program, {name: parts.get(name, {""}) for name in open_})
    used = _elements_used(program, work)
    data = []
    for d in program.data:
        begun_ = _begun(d, used.get(d.name, set())) if d.name in read else d
        few = prod(int(size.value) for size in d.sizes if type(size) is ex.Number) <= _MOST_SHARED_ZEROS
        if begun_ is not d and not few:
            work.ask("set all elements of these to zero before each start", d.name)
        data.append(begun_ if few else d)
    return replace(program, data=tuple(data))


def unset_data(program: st.Program, work: TranslationContext) -> st.Program:
    """Reports variables kept by the controller that the program reads before it sets them."""
    if not work.conventions.data_set_elsewhere:
        return program
    kinds = {*_ZEROS, "position", "joints"}
    open_ = {d.name for d in program.data if d.value is None and d.type in kinds and d.comment != UNDECLARED}
    parts = _changed_parts(program, work) if open_ else {}
    for name, s in _read_first(program, {name: parts.get(name, {""}) for name in open_}).items():
        says = f"on some path nothing has set {name}, which another program may set: it begins with zero"
        work.lose(s, Fate.APPROXIMATED, "value", says)
        work.ask("set what another program may set, which is zero now", name)
    return program


def _ask_anew(program: st.Program, work: TranslationContext) -> None:
    """Data that begin anew with each run in the source, that statements change, and that the target keeps."""
    if not work.conventions.data_begin_anew:
        return
    for d in _changed_data(program, work):
        if d.type in _NOTHING:
            work.ask(SET_BACK, d.name)


def _changed_data(program: st.Program, work: TranslationContext) -> list[st.Declare]:
    """The variables of the source, none of a routine's own, that statements change."""
    symbols = work.symbols(program)  # which knows what calls change by reference, too
    changed = {name for s in program.statements() for name, _ in _parts_set(s)}
    return [
        d
        for d in program.data
        if (d.name in changed or ((symbol := symbols.find("", d.name)) is not None and symbol.assigned))
        and d.storage == "variable"
        and d.name not in work.helpers
        and d.comment != UNDECLARED
    ]


def _set_by_runs(program: st.Program, work: TranslationContext) -> st.Program:
    """Where each run of the source sets the first values of its variables, so does each start of the translation:
    what the target declares holds in its first run alone."""
    if not work.conventions.data_set_by_run:
        return program
    rows = {
        d.name: [st.Assign(d.line, place, value) for place, value in _elements(ex.Named(d.name), d.value)]
        for d in _changed_data(program, work)
        if d.value is not None
    }
    if not rows:
        return program
    main = program.main or program.routines[0].name
    routines = [
        replace(r, body=tuple(behind_declarations(r.body, rows))) if r.name == main or r.starts else r
        for r in program.routines
    ]
    return replace(program, routines=tuple(routines))


def _elements(
    place: ex.Named | ex.Item, value: ex.Expression
) -> Iterator[tuple[ex.Named | ex.Item, ex.Expression]]:
    """A value by what sets it: an array by its elements."""
    if not (isinstance(value, ex.RecordLiteral) and all(not name for name, _ in value.members)):
        yield place, value
        return
    base, before = (place.base, place.indices) if isinstance(place, ex.Item) else (place, ())
    for n, (_, part) in enumerate(value.members, 1):
        yield from _elements(ex.Item(base, (*before, ex.Number(n))), part)


def _note_element(e: ex.Item, name: str, used: dict[str, set[tuple[int, ...]] | None]) -> None:
    """`used`: the elements of each array that statements name, None where an index is computed."""
    place = tuple([int(i.value) for i in e.indices if type(i) is ex.Number])
    known = used.setdefault(name, set())
    if len(place) < len(e.indices) or not place:
        used[name] = None
    elif known is not None:
        known.add(place)


def _begun(d: st.Declare, used: set[tuple[int, ...]] | None) -> st.Declare:
    zero = _ZEROS.get(d.type)
    if zero is None or d.value is not None or d.comment == UNDECLARED:
        return d
    if not d.sizes:
        return replace(d, value=zero)
    sizes = [int(size.value) for size in d.sizes if type(size) is ex.Number]
    if len(sizes) < len(d.sizes) or prod(sizes) > _MOST_ZEROS:
        return d
    return replace(d, value=_zeros(sizes, (), used, zero))


def _zeros(
    sizes: list[int], before: tuple[int, ...], used: set[tuple[int, ...]] | None, zero: ex.Expression
) -> ex.Expression:
    """Nested rows with a zero for each element that is used, `Unknown("")` for others."""
    if not sizes:
        return zero if used is None or before in used else ex.Unknown("")
    return ex.RecordLiteral(
        "", tuple([("", _zeros(sizes[1:], (*before, n), used, zero)) for n in range(1, sizes[0] + 1)])
    )


def _with_zeros(program: st.Program) -> tuple[st.Routine, ...]:
    """Routines that set what they declare to zero, where something reads it before it is set."""
    routines = []
    own = {r.name: _local_zeros(r) for r in program.routines}
    ways = None
    for r in program.routines:
        if not own[r.name]:
            routines.append(r)
            continue
        if ways is None:
            ways = reaching(program, lambda s: {("local", name): 1 for name in _set_by(s)}, _SETTING)
        open_: set[str] = set()
        for index, s in enumerate(r.body):
            state = ways.before[r.name][index]
            read = _names_read(s) & own[r.name].keys() if state is not None else set()
            open_ |= {name for name in read if ENTRY in (state or {}).get(("local", name), {ENTRY})}
        rows = {name: rows for name, rows in own[r.name].items() if name in open_}
        routines.append(replace(r, body=tuple(behind_declarations(r.body, rows))) if rows else r)
    return tuple(routines)


def _local_zeros(r: st.Routine) -> dict[str, list[st.Assign]]:
    """What sets each variable of a routine's own, or its elements, to zero."""
    found: dict[str, list[st.Assign]] = {}
    for d in (*r.data, *(s for s in r.body if type(s) is st.Declare)):
        zero = _ZEROS.get(d.type)
        sizes = [int(size.value) for size in d.sizes if type(size) is ex.Number]
        few = len(sizes) == len(d.sizes) and prod(sizes) <= _MOST_LOCAL_ZEROS
        if zero is not None and d.value is None and few and d.comment != UNDECLARED:
            places = product(*(range(1, size + 1) for size in sizes)) if sizes else ()
            items = [ex.Item(ex.Named(d.name), tuple(map(ex.Number, place))) for place in places]
            found[d.name] = [st.Assign(0, target, zero) for target in items or (ex.Named(d.name),)]
    return found


def _set_by(s: st.Statement) -> list[str]:
    match s:
        case (
            st.Assign(target=ex.Named(name))
            | st.For(variable=ex.Named(name))
            | st.ReadInput(target=ex.Named(name))
        ):
            return [name]
        case st.Call(result=ex.Named(name)):
            return [name]
    return []


def _names_read(s: st.Statement) -> set[str]:
    found: set[str] = set()
    match s:
        case st.Assign(target=ex.Named()):
            note_names(s.value, found)
        case st.For(variable=ex.Named()):
            for e in (s.start, s.stop, s.step):
                note_names(e, found)
        case st.Call(result=ex.Named()):
            note_names(replace(s, result=None), found)
        case st.ReadInput(target=ex.Named()) | st.Declare():
            pass
        case _:
            note_names(s, found)
    return found


def behind_declarations(
    body: tuple[st.Statement, ...], rows: Mapping[str, list[st.Assign]]
) -> list[st.Statement]:
    """`rows`: what sets each name first, behind its declaration and those that follow that one.

    What the body does not declare is set behind the declarations at its head, before one that reads it.
    """
    waiting = {name.casefold(): assigns for name, assigns in rows.items()}
    declared = {s.name.casefold() for s in body if type(s) is st.Declare}
    first = [name for name in waiting if name not in declared]
    head = _head(body, set(first))
    found: list[st.Statement] = []
    due: list[st.Assign] = []
    for index, s in enumerate(body):
        if index == head:
            due += [row for name in first for row in waiting[name]]
        if due and (index == head or not isinstance(s, (st.Begin, st.Declare))):
            found, due = [*found, *due], []
        found.append(s)
        if type(s) is st.Declare:
            due += waiting.get(s.name.casefold(), [])
    rest = [row for name in first for row in waiting[name]] if head == len(body) else []
    return [*found, *due, *rest]


def _head(body: tuple[st.Statement, ...], names: set[str]) -> int:
    """Where a body's declarations end, with comments between them; before the first that reads one of `names`."""
    end = 0
    for index, s in enumerate(body):
        if not isinstance(s, (st.Begin, st.Declare, st.Comment)):
            break
        if type(s) is st.Declare and s.value is not None:
            read: set[str] = set()
            note_names(s.value, read)
            if names & {name.casefold() for name in read}:
                break
        if not isinstance(s, st.Comment):
            end = index + 1
    return end


# --- Saved values ---
# What numbered variables hold before a program sets them: the values of VAR.DAT and olp.toml beside it.
#
# A controller's variables live on when a program ends. Positions among them are taught like points; numbers
# are counters and recipes, which keep their values in languages that have data beside the program, and are
# left to their operator in others.


def saved_values(work: TranslationContext) -> dict[tuple[ex.Store, int], Given]:
    """By kind and number; olp.toml wins over VAR.DAT. Nothing where neither file is there."""
    if not work.conventions.saved_variables:
        return {}
    world = world_of(work.source, work.robot)
    found: dict[tuple[ex.Store, int], Given] = {}
    variables = None if world.backup is None else world.backup.variables
    if variables is not None:
        for store, letters in SAVED_NUMBERS.items():
            found |= {(store, n): value for n, value in getattr(variables, letters).items()}
        for store, letters in SAVED_POSITIONS.items():
            found |= {(store, n): saved_position(value) for n, value in getattr(variables, letters).items()}
    return found | dict(world.assumptions.variables)


def saved_points(values: Mapping[tuple[ex.Store, int], Given]) -> Iterator[Point]:
    """The positions of robots among them."""
    for (store, number), value in values.items():
        if store is ex.Store.ROBOT and isinstance(value, tuple):
            yield Point(number, value.values, value.state, 0)


def saved_number(value: Given | None) -> ex.Expression | None:
    """A number or text as it is written in a declaration; None for what a declaration has anyway, or for a position."""
    if isinstance(value, str):
        return ex.Text(value) if value else None
    return ex.Number(value) if isinstance(value, (int, float)) and value else None


def label_of(name: ex.Expression) -> str:
    """A variable, or an element of an array by its constant index, as the receipt names it."""
    if (
        isinstance(name, ex.Item)
        and isinstance(name.base, ex.Named)
        and isinstance(name.indices[0], ex.Number)
    ):
        return f"{name.base.name}[{name.indices[0].value}]"
    assert isinstance(name, ex.Named)
    return name.name


@dataclass(slots=True)
class Unset:
    """Which variables a program reads that have no value then. `name_of`: what a variable is called in the target.

    `begins`: whether a value is known that it begins with. `is_set`: whether statements set all of it anywhere.
    """

    program: st.Program
    work: TranslationContext
    name_of: Callable[[ex.Variable], ex.Expression]
    begins: Callable[[ex.Expression], bool]
    is_set: Callable[[ex.Expression], bool]
    _ways: Reaching | None = None

    def tell(self) -> None:
        """Positions and numbers that are read and not set, as far as one way there shows."""
        self._tell_positions()
        self._tell_values()

    def _why(self, e: ex.Variable, routine: st.Routine, index: int) -> tuple[ex.Expression, str] | None:
        """The name of what a statement reads, and why it has no value there; None where it has one."""
        if e.local or type(e.index) is not ex.Number or e.store is ex.Store.SYSTEM:
            return None
        name = self.name_of(e)
        if self.begins(name):
            return None
        if not self.is_set(name):
            return name, "nothing here sets"
        if self._ways is None:
            self._ways = reaching(self.program, _registers_set, _SETTING | {st.Update})
        unset = any(UNSET in self._ways.at(routine.name, index, key) for key in _parts_of(e))
        return (name, "on some path nothing has set") if unset else None

    def _tell_values(self) -> None:
        """What statements read beside the targets of moves. Registers of the target hold what its operator sets."""
        told: set[str] = set()
        for routine in self.program.routines:
            for index, s in _with_values(routine, self.work):
                for e in read_by(s):
                    found = self._why(e, routine, index)
                    if found is None:
                        self._ask_for_all(e)
                        continue
                    label = label_of(found[0])
                    if label in told:
                        continue
                    told.add(label)
                    if self.work.limits.numbered:
                        self.work.ask("set these registers on the controller before it runs", label)
                        continue
                    says = (
                        f"{found[1]} all of {label}, and no VAR.DAT or olp.toml holds it: it begins with zero"
                    )
                    self.work.lose(s, Fate.APPROXIMATED, "value", says)
                    self.work.ask("set these values, which are zeros now", label)

    def _ask_for_all(self, e: ex.Variable) -> None:
        """A register whose number is computed may be any of them."""
        name = None if e.local or type(e.index) is ex.Number else self.name_of(e)
        if isinstance(name, ex.Item) and isinstance(name.base, ex.Named):
            self.work.ask("see that those of these which are read have values", f"{name.base.name}[…]")

    def _tell_positions(self) -> None:
        numbers = bool(self.work.limits.numbered)
        ends = "it has to be taught" if numbers else "zeros are declared"
        told: set[str] = set()
        for routine in self.program.routines:
            places = (
                (index, s, e)
                for index, s in enumerate(routine.body)
                if type(s) is st.Move
                for e in (*s.targets, *((s.offset, s.tool_offset) if numbers else ()))
                if isinstance(e, ex.Variable)
            )
            for index, s, e in places:
                found = self._why(e, routine, index)
                if found is None or label_of(found[0]) in told:
                    continue
                label = label_of(found[0])
                told.add(label)
                says = f"{found[1]} this position, and no VAR.DAT or olp.toml holds it: {ends}"
                self.work.lose(s, Fate.APPROXIMATED, "position", says)
                self.work.ask(_TEACH_REGISTERS if numbers else TEACH, label)


def _with_values(routine: st.Routine, work: TranslationContext) -> list[tuple[int, st.Statement]]:
    """The statements that take values, in order: those that are not plain, and moves with a computed speed or blend."""
    look = work.look(routine)
    if not any(isinstance(e, ex.Variable) for e in look.values):
        return look.rare
    rare = {index for index, _ in look.rare}
    return [(index, s) for index, s in enumerate(routine.body) if index in rare or type(s) is st.Move]


def _parts_of(e: ex.Variable) -> list[Key]:
    """What has to be set of a register: of a position each element, of which a statement may set one."""
    assert isinstance(e.index, ex.Number)
    store = (
        ex.Store.ROBOT if e.store is ex.Store.SYSTEM else e.store
    )  # a position of the system holds the robot's
    return [("register", store, int(e.index.value), part) for part in POSE_ELEMENTS]


def _registers_set(s: st.Statement) -> dict[Key, int]:
    """The registers that a statement sets, and elements of them."""
    match s:
        case st.Assign(target=ex.Element(ex.Variable() as e, ex.Number(at))) if type(e.index) is ex.Number:
            return dict.fromkeys(_parts_of(e)[int(at) - 1 : int(at)], 1)
        case st.Assign(target=ex.Member(ex.Variable() as e, part)) if type(e.index) is ex.Number:
            return {key: 1 for key in _parts_of(e) if key[-1] == part}
        case (
            st.Assign(target=ex.Variable() as e)
            | st.ReadInput(target=ex.Variable() as e)
            | st.For(variable=ex.Variable() as e)
        ):
            pass
        case st.Update(target=ex.Variable() as e) | st.Call(result=ex.Variable() as e):
            pass
        case st.Clear(target=ex.Variable() as e, count=count) if type(e.index) is ex.Number:
            first = int(e.index.value)
            many = int(count.value) if type(count) is ex.Number else 1
            return {
                key: 1
                for n in range(first, first + many)
                for key in _parts_of(replace(e, index=ex.Number(n)))
            }
        case _:
            return {}
    return dict.fromkeys(_parts_of(e), 1) if type(e.index) is ex.Number else {}


def _found_by(target: ex.Expression) -> tuple[ex.Expression, ...]:
    """The values by which a place is found: what is set itself is not read."""
    match target:
        case ex.Element(place, index):
            return (*_found_by(place), index)
        case ex.Item(place, indices):
            return (*_found_by(place), *indices)
        case ex.Member(place):
            return _found_by(place)
        case ex.Variable(index=index):
            return (index,)
    return ()


def read_by(s: st.Statement) -> Iterator[ex.Variable]:
    """Variables whose values a statement takes: not what it sets, and of a move not where it goes."""
    skipped: list[ex.Expression | None] = []
    read: object = s
    if isinstance(s, st.Move):
        skipped = [e for e in (*s.targets, s.offset, s.tool_offset) if isinstance(e, ex.Variable)]
    elif isinstance(s, (st.Clear, st.ReadInput)):
        skipped = [s.target]
    elif isinstance(s, st.Assign):
        read = (s.value, _found_by(s.target))
    elif isinstance(s, (st.For, st.Call)):
        skipped = [s.variable if isinstance(s, st.For) else s.result]
    for e in expressions_of(read):
        if isinstance(e, ex.Variable) and e not in skipped:
            yield e


# --- Where positions are taught ---


def taught_frames(program: st.Program, work: TranslationContext) -> st.Program:
    """Says of positions that have to be taught with which tool and in which frame the moves take them."""
    axes = {
        d.name for d in (*program.data, *(d for r in program.routines for d in r.data)) if d.type == "joints"
    }
    for says in (TEACH, _TEACH_REGISTERS, TEACH_UNDECLARED):
        labels = work.asks.get(says)
        if labels is None:
            continue
        found: dict[str, set[str]] = {label: set() for label in labels}
        for s in program.statements():
            if isinstance(s, st.Move) and (s.path is not st.Path.JOINT or says == TEACH_UNDECLARED):
                for e in s.targets:
                    if type(e) is ex.Item and not (
                        type(e.base) is ex.Named and type(e.indices[0]) is ex.Number
                    ):
                        continue
                    if isinstance(e, ex.Named) and e.name in axes:
                        continue
                    if isinstance(e, (ex.Named, ex.Item)) and (label := label_of(e)) in found:
                        shown = _shown_frame(s.tool), _shown_frame(s.frame)
                        found[label] |= {" in ".join(shown)} if all(shown) else set()
        work.asks[says] = {
            f"{label} ({' or '.join(sorted(found[label]))})" if found[label] else label: None
            for label in labels
        }
    return program


def _shown_frame(e: ex.Expression | None) -> str:
    match e:
        case ex.Named(name):
            return name
        case ex.FrameRef("tool", ex.Number(0)):
            return "the flange"
        case ex.FrameRef("tool", ex.Number(number)):
            return f"tool {number}"
        case ex.FrameRef("user", ex.Number(number)):
            return f"frame {number}"
        case ex.FrameRef("base"):
            return "the base"
    return ""
