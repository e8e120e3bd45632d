"""Records of a program's own types as one variable for each member, for no target has the source's types."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Set
from dataclasses import dataclass, field, replace
from typing import Final

from olp.ir import expressions as ex
from olp.ir import program as st
from olp.ir.transformer import expressions_of, mapped
from olp.languages.vendor import language_of
from olp.transpile.context import Fate, TranslationContext
from olp.transpile.name_types import AXES, COMPONENTS
from olp.transpile.occurrences import with_routines, with_rows
from olp.transpile.symbols import Symbol, Symbols

_WHOLE_TYPES: Final = {
    "tooldata": "tool",
    "wobjdata": "frame",
}  # records that every target has in a form of its own
# Built-in records which only their own language has: as members, and as variables that a program changes.
_PARTS: Final = {"speed": "speeddata", "zone": "zonedata"}
_DEEPEST: Final = 6
_ALL: Final = ex.Unknown("")  # an index that is left out
_RESULT: Final = ""  # what a routine returns, among its names
MemberPath = tuple[str, ...]


@dataclass(frozen=True, slots=True)
class _Leaf:
    """A member that is no record: the names that lead to it, its type, and the sizes of one that is an array.

    Without a type nothing at hand tells it: the variable for it is one that nothing declares.
    """

    path: MemberPath
    type: str
    sizes: tuple[ex.Expression, ...] = ()


@dataclass(slots=True)
class _Records:
    """`shapes`: type, case folded -> its leaves. `variables`: scope and name -> its type, case folded."""

    symbols: Symbols
    shapes: dict[str, tuple[_Leaf, ...]] = field(default_factory=dict)
    variables: dict[tuple[str, str], str] = field(default_factory=dict)
    parameters: dict[str, dict[str, str]] = field(
        default_factory=dict
    )  # routine, case folded -> name -> type
    names: dict[tuple[str, str, MemberPath], str] = field(default_factory=dict)
    results: dict[str, str] = field(default_factory=dict)  # routine, case folded -> the type that it returns

    @property
    def any(self) -> bool:
        return bool(self.variables) or any(self.parameters.values())

    def of(self, routine: str, name: str) -> tuple[str, str] | None:
        """Scope and name of a record, None of what is none."""
        if name in self.parameters.get(routine.casefold(), ()):
            return routine, name
        symbol = self.symbols.find(routine, name)
        key = ("", name) if symbol is None else (symbol.scope, symbol.name)
        return key if key in self.variables else None


def flat_records(program: st.Program, work: TranslationContext) -> st.Program:
    """`part.place` as `part_place`; a record that is copied is copied member by member.

    A statement that takes a record whole in another way than that is refused.
    """
    program = _settings(_spelled_out(program, work), work)
    found = _found(program, work)
    if not found.any:
        return program
    for s, kind in _odd(program, found):
        says = (
            f"it takes a record of the type {kind} as a whole, which {language_of(work.target)} does not have"
        )
        work.lose(s, Fate.REFUSED, "name", says)
    for (scope, name), kind in [*found.variables.items(), *_parameter_keys(found)]:
        first = "_".join((name, *found.shapes[kind][0].path))
        work.note_once(f"{name} is a record: each of its members is a variable, as {first}")
        for leaf in found.shapes[kind]:
            found.names[(scope, name, leaf.path)] = work.fresh("_".join((name, *leaf.path)))
    data = []
    for r in program.routines:
        for leaf in (
            found.shapes[found.results[r.name.casefold()]] if r.name.casefold() in found.results else ()
        ):
            name = work.fresh("_".join((r.name, "result", *leaf.path)))
            found.names[(r.name.casefold(), _RESULT, leaf.path)] = name
            data.append(st.Declare(0, name, leaf.type, None, leaf.sizes, shared=True))
    own = _Flat(found)
    routines = tuple(own.routine(r) for r in program.routines)
    data = [*(one for d in program.data for one in own.declared(d, "")), *data]
    return replace(program, routines=routines, data=tuple(data))


def _spelled_out(program: st.Program, work: TranslationContext) -> st.Program:
    """The program with the values of speeds and zones that nothing changes, where they are copied or handed over."""
    if not any(d.type in _PARTS for _, d in _declarations(program)) and not any(
        p.type in _PARTS for r in program.routines for p in r.parameters
    ):
        return program
    symbols = work.symbols(program)

    def literal(e: ex.Expression, routine: str) -> ex.Expression:
        symbol = symbols.find(routine, e.name) if isinstance(e, ex.Named) else None
        if symbol is None or symbol.type not in _PARTS or symbol.sizes:
            return e
        return symbols.fixed_value(routine, e) or e

    def row(s: st.Statement, routine: str) -> st.Statement:
        if isinstance(s, st.Assign):
            value = literal(s.value, routine)
            s = s if value is s.value else replace(s, value=value)
        elif isinstance(s, st.Call):
            s = replace(s, arguments=tuple([literal(a, routine) for a in s.arguments]))
        return s

    return with_routines(program, (with_rows(r, [row(s, r.name) for s in r.body]) for r in program.routines))


def _settings(program: st.Program, work: TranslationContext) -> st.Program:
    """Moves with the values of what they take from records that nothing changes, such as motion descriptors."""
    if not any(
        isinstance(d.value, ex.RecordLiteral) and d.type == d.value.type for _, d in _declarations(program)
    ):
        return program
    symbols = work.symbols(program)

    def setting(e: ex.Expression, routine: str) -> ex.Expression:
        if (
            type(e) is ex.Binary
            and e.operator == "*"
            and type(e.left) is ex.Number
            and type(e.right) is ex.Number
        ):
            return ex.Number(e.left.value * e.right.value)
        record = symbols.fixed_value(routine, e.base) if type(e) is ex.Member else None
        if type(e) is not ex.Member or not isinstance(record, ex.RecordLiteral):
            return e
        found = next((value for name, value in record.members if name.casefold() == e.name.casefold()), e)
        return found if type(found) is ex.Number else e

    def row(s: st.Statement, routine: str) -> st.Statement:
        return mapped(s, lambda e: setting(e, routine)) if type(s) is st.Move else s

    return with_routines(program, (with_rows(r, [row(s, r.name) for s in r.body]) for r in program.routines))


def _parameter_keys(found: _Records) -> Iterator[tuple[tuple[str, str], str]]:
    for routine, names in found.parameters.items():
        for name, kind in names.items():
            yield (routine, name), kind


# --- What there is ---


def _found(program: st.Program, work: TranslationContext) -> _Records:
    symbols, types = work.symbols(program), work.conventions.member_types
    found = _Records(symbols)
    layouts = dict(_layouts(program)) if types else {}
    given = [(scope, d, one) for scope, d in _declarations(program) if (one := _element(d.value)) is not None]
    given += _without_value(program)
    used = {
        e.name
        for s in (program.statements() if given else ())
        if not isinstance(s, st.Declare)
        for e in expressions_of(s)
        if isinstance(e, ex.Named)
    }
    for scope, d, literal in given:
        symbol = symbols.find(scope, d.name)
        if symbol is None or symbol.parameter is not None or d.name not in used:
            continue  # what no statement names is no data of the program's: it goes as it went
        kind = _kind_of(symbol, literal)
        leaves = found.shapes.get(kind) or _shape(kind, literal, layouts, types) if kind else ()
        if kind and leaves:
            found.shapes[kind] = leaves
            found.variables[(symbol.scope, symbol.name)] = kind
    for scope, d in _declarations(program) if layouts else ():
        symbol = symbols.find(scope, d.name)
        kind = d.type.casefold()
        if kind not in layouts or d.value is not None or symbol is None or symbol.parameter is not None:
            continue
        leaves = found.shapes.get(kind) or tuple(_laid_out(kind, layouts, types, ()))
        if leaves:
            found.shapes[kind] = leaves
            found.variables[(symbol.scope, symbol.name)] = kind
    for kind in dict.fromkeys(_taken(program)) if layouts else ():
        if (
            kind in layouts
            and kind not in found.shapes
            and (laid := tuple(_laid_out(kind, layouts, types, ())))
        ):
            found.shapes[kind] = laid
    _add_unknown(program, found, layouts.keys())
    _add_undeclared(program, found, work)
    handed = {
        p.type for r in program.routines for p in r.parameters if p.type in _PARTS
    } - found.shapes.keys()
    for kind, literal in _literals(program).items() if handed else ():
        if kind in handed:
            found.shapes[kind] = tuple(_leaves(literal, ()))
    _keep_used(program, found)
    for routine in program.routines:
        if routine.returns.casefold() in found.shapes and routine.returns.casefold() not in _PARTS:
            found.results[routine.name.casefold()] = routine.returns.casefold()
        for parameter in routine.parameters:
            kind = parameter.type.casefold()
            leaves = found.shapes.get(kind, ())
            if any((leaf.sizes and leaf.type != "string") or not leaf.type for leaf in leaves):
                continue
            optional = parameter.optional and not parameter.by_reference
            if kind in found.shapes and not (optional and kind in _PARTS):
                found.parameters.setdefault(routine.name.casefold(), {})[parameter.name] = kind
    return found


def _taken(program: st.Program) -> Iterator[str]:
    """The types that routines take and return, case folded."""
    for routine in program.routines:
        yield from (kind.casefold() for kind in (*(p.type for p in routine.parameters), routine.returns))


def _keep_used(program: st.Program, found: _Records) -> None:
    """Of built-in records, which have more members than most programs ask for, those that a statement names."""
    kinds = _PARTS.keys() & found.shapes.keys()
    if not kinds:
        return
    used = {
        e.name.casefold() for s in program.statements() for e in expressions_of(s) if isinstance(e, ex.Member)
    }
    for kind in kinds:
        leaves = found.shapes[kind]
        found.shapes[kind] = tuple(leaf for leaf in leaves if leaf.path[-1].casefold() in used) or leaves


def _layouts(program: st.Program) -> Iterator[tuple[str, ex.Expression | None]]:
    return ((d.name.casefold(), d.value) for _, d in _declarations(program) if d.type == "structure")


def _shape(
    kind: str,
    literal: ex.RecordLiteral,
    layouts: Mapping[str, ex.Expression | None],
    types: Mapping[str, str],
) -> tuple[_Leaf, ...]:
    """The leaves of a type as its declaration has them, else those of a value: none where one of them has no type."""
    if kind in layouts:
        return tuple(_laid_out(kind, layouts, types, ()))
    leaves = tuple(_leaves(literal, ()))
    return leaves if all(leaf.type for leaf in leaves) else ()


def _add_unknown(program: st.Program, found: _Records, kinds: Set[str]) -> None:
    """Members that a program uses and its declaration of the type, which is that of another version, does not have."""
    for routine in program.routines if found.variables and kinds else ():
        for s in routine.body:
            for e in expressions_of(s):
                root = _root(e) if isinstance(e, ex.Member) else None
                key = None if root is None else found.of(routine.name, root.name)
                kind = found.variables.get(key, "") if key is not None else ""
                if kind not in kinds:
                    continue
                path = _chain(e)[1]
                known = [leaf.path for leaf in found.shapes[kind]]
                if not any(_begins(path, one) or _begins(one, path) for one in known):
                    found.shapes[kind] = (*found.shapes[kind], _Leaf(path, ""))


def _add_undeclared(program: st.Program, found: _Records, work: TranslationContext) -> None:
    """Names that nothing declares, of which statements take members: their type has those that any of them names.

    What one of them is copied from or to is of the same type. A name that is anything else besides is no record.
    """
    paths: dict[str, dict[MemberPath, MemberPath]] = {}  # of each name: folded -> as written
    links: list[tuple[str, str]] = []
    others: set[str] = set()
    for r in program.routines:
        for _, s in work.look(r).rare:
            if isinstance(s, st.Declare):
                continue
            whole: Counter[str] = Counter()
            for e in expressions_of(s):
                if isinstance(e, ex.Named) and _is_undeclared(e.name, r.name, found):
                    whole[e.name] += 1
                elif isinstance(e, ex.Member) and (root := _root(e)) is not None and root.name in whole:
                    path = _record_path(_chain(e)[1])
                    if not path:
                        others.add(root.name)
                    paths.setdefault(root.name, {}).setdefault(_folded(path), path)
                    whole[root.name] -= not isinstance(e.base, ex.Member)
            copied = [(e, _root(e)) for e in ((s.target, s.value) if isinstance(s, st.Assign) else ())]
            roots = [root.name for e, root in copied if root is not None and not isinstance(e, ex.Member)]
            if len(roots) == 2:
                links.append((roots[0], roots[1]))
            elif (
                isinstance(s, st.Assign)
                and roots
                and roots[0] in whole
                and isinstance(s.value, ex.RecordLiteral)
            ):
                given = {_folded(leaf.path): leaf.path for leaf in _leaves(s.value, ()) if all(leaf.path)}
                paths.setdefault(roots[0], {}).update(given)
            elif isinstance(s, st.Assign) and not isinstance(s.value, ex.CallValue):
                roots = []
            calls = [e for e in (s, *expressions_of(s)) if isinstance(e, (st.Call, ex.CallValue))]
            handed = [a for call in calls for a in call.arguments if not isinstance(a, ex.Member)]
            roots += [root.name for a in handed if (root := _root(a))]
            whole.subtract(roots)
            if not isinstance(
                s, (st.If, st.ElseIf, st.While, st.Until, st.Wait)
            ):  # there it is compared, which is refused
                others |= {name for name, count in whole.items() if count > 0}
    for group in _groups(paths.keys(), links):
        members = {key: path for name in group for key, path in paths.get(name, {}).items()}
        known = [name for name in group if name not in paths and not _is_undeclared(name, "", found)]
        if others & set(group) or known or len(members) == 0:
            continue
        leaves = [
            _Leaf(path, "")
            for key, path in members.items()
            if not any(other != key and _begins(other, key) for other in members)
        ]
        found.shapes[group[0].casefold()] = tuple(leaves)
        found.variables.update({("", name): group[0].casefold() for name in group})


def _is_undeclared(name: str, routine: str, found: _Records) -> bool:
    symbol = found.symbols.find(routine, name)
    return symbol is None or not symbol.declared


def _record_path(path: MemberPath) -> MemberPath:
    """The names that lead to a position, without those of its components."""
    at = next((at for at, name in enumerate(path) if name.casefold() in COMPONENTS | AXES), len(path))
    return path[:at]


def _groups(names: Iterable[str], links: Iterable[tuple[str, str]]) -> list[list[str]]:
    """Names that are linked, however far apart, in the order of `names`."""
    group = {name: [name] for name in names}
    for one, other in links:
        if one not in group and other not in group:
            continue
        first, second = group.setdefault(one, [one]), group.setdefault(other, [other])
        if first is not second:
            first += second
            group.update(dict.fromkeys(second, first))
    return list({id(rows): rows for rows in group.values()}.values())


def _begins(path: MemberPath, start: MemberPath) -> bool:
    return tuple(map(str.casefold, path[: len(start)])) == tuple(map(str.casefold, start))


def _laid_out(
    kind: str, layouts: Mapping[str, ex.Expression | None], types: Mapping[str, str], before: MemberPath
) -> Iterator[_Leaf]:
    """The leaves of a type as its declaration has them."""
    layout = layouts.get(kind)
    for name, member in layout.members if isinstance(layout, ex.RecordLiteral) else ():
        path = (*before, name)
        word = ""
        sizes: tuple[ex.Expression, ...] = ()
        if isinstance(member, ex.RecordLiteral):
            word, sizes = member.type, tuple(size for _, size in member.members)
        if word.casefold() in layouts and not sizes and len(path) < _DEEPEST:
            yield from _laid_out(word.casefold(), layouts, types, path)
        else:
            yield _Leaf(path, types.get(word, ""), sizes)


def _without_value(program: st.Program) -> list[tuple[str, st.Declare, ex.RecordLiteral]]:
    """Built-in records that are declared without a value, with one of their kind: it tells the members."""
    bare = [(scope, d) for scope, d in _declarations(program) if d.value is None and d.type in _PARTS]
    if not bare:
        return []
    known = _literals(program)
    return [(scope, d, known[d.type]) for scope, d in bare if d.type in known]


def _literals(program: st.Program) -> dict[str, ex.RecordLiteral]:
    """A value of each built-in record that the program has: it tells the members."""
    literals = [d.value for _, d in _declarations(program) if d.value is not None]
    literals += [
        e for s in program.statements() for e in expressions_of(s) if isinstance(e, ex.RecordLiteral)
    ]
    known = {one.type: one for value in literals if (one := _element(value)) is not None}
    return {kind: known[name] for kind, name in _PARTS.items() if name in known}


def _declarations(program: st.Program) -> Iterator[tuple[str, st.Declare]]:
    yield from (("", d) for d in program.data)
    for routine in program.routines:
        yield from ((routine.name, d) for d in routine.data)
        if st.Declare in set(map(type, routine.body)):
            yield from ((routine.name, s) for s in routine.body if type(s) is st.Declare)


def _element(value: ex.Expression | None) -> ex.RecordLiteral | None:
    """The record itself, of an array its first one."""
    while isinstance(value, ex.RecordLiteral) and value.members and not value.members[0][0]:
        value = value.members[0][1]
    return value if isinstance(value, ex.RecordLiteral) and value.members else None


def _kind_of(symbol: Symbol, literal: ex.RecordLiteral) -> str:
    """The type where it is one of the program's own, or a built-in one that the program changes."""
    kind = symbol.type.casefold()
    if kind in _PARTS:
        return kind if literal.type == _PARTS[kind] and symbol.assigned else ""
    return kind if kind and literal.type.casefold() == kind and kind not in _WHOLE_TYPES else ""


def _leaves(literal: ex.RecordLiteral, before: MemberPath) -> Iterator[_Leaf]:
    for name, value in literal.members:
        path = (*before, name)
        if isinstance(value, ex.RecordLiteral) and value.type in _WHOLE_TYPES:
            yield _Leaf(path, _WHOLE_TYPES[value.type])
        elif isinstance(value, ex.RecordLiteral):
            if not name or not value.members or not value.members[0][0] or len(path) > _DEEPEST:
                yield _Leaf(path, "")
            else:
                yield from _leaves(value, path)
        else:
            yield _Leaf(path, _leaf_type(value) if name else "")


def _leaf_type(value: ex.Expression) -> str:
    match value:
        case ex.Number():
            return "real"
        case ex.SignalState():
            return "boolean"
        case ex.Text():
            return "string"
        case ex.PositionLiteral():
            return "joints" if value.kind == "joint" else "position"
        case _:
            return ""


# --- What names a record as a whole ---


def _odd(program: st.Program, found: _Records) -> list[tuple[st.Statement, str]]:
    """Statements that take records whole, but for copies and calls, each with the type of one."""
    odd: list[tuple[st.Statement, str]] = []
    own = {routine.name.casefold(): routine for routine in program.routines}
    for routine in program.routines:
        for s in routine.body:
            if isinstance(s, st.Declare):
                continue
            kinds: set[str] = set()
            allowed: list[ex.Expression] = []
            if isinstance(s, st.Assign) and _is_copy(s, routine.name, found):
                allowed = [s.target, s.value]
            elif isinstance(s, st.Return) and _is_returned(s, routine.name, found):
                allowed = [s.value] if s.value is not None else []
            elif isinstance(s, st.Return):
                kinds |= {found.results.get(routine.name.casefold(), "")} - {""}
            taken = getattr(s, "value", None) if allowed else None
            kinds |= {kind for e in expressions_of(s) if e is not taken and (kind := _returned_by(e, found))}
            for call in (s, *expressions_of(s)):
                if isinstance(call, (st.Call, ex.CallValue)):
                    called = own.get(call.routine.casefold())
                    handed = called is None or _fits(call, called, routine.name, found)
                    allowed += call.arguments if handed else ()
            kinds |= _whole(s, routine.name, found, allowed)
            odd += [(s, kind) for kind in sorted(kinds)]
    return odd


def _is_copy(s: st.Assign, routine: str, found: _Records) -> bool:
    leaves = _under(s.target, routine, found)
    if not leaves:
        return False
    if isinstance(s.value, ex.RecordLiteral) and repr(_root(s.target)) in map(repr, expressions_of(s.value)):
        return False
    return _gives(s.value, [(path, leaf) for _, path, leaf in leaves], routine, found)


def _is_returned(s: st.Return, routine: str, found: _Records) -> bool:
    kind = found.results.get(routine.casefold())
    if kind is None or s.value is None:
        return False
    return _gives(s.value, [(leaf.path, leaf) for leaf in found.shapes[kind]], routine, found)


def _gives(
    value: ex.Expression, leaves: list[tuple[MemberPath, _Leaf]], routine: str, found: _Records
) -> bool:
    """Whether a value has these members, each of which is copied."""
    paths = [path for path, _ in leaves]
    if isinstance(value, ex.RecordLiteral):
        if value.type in _PARTS.values():
            return _has(value, paths)
        given = [_folded(leaf.path) for leaf in _leaves(value, ())]
        arrays = {_folded(path) for path, leaf in leaves if leaf.sizes and leaf.type != "string"}
        return bool(given) and arrays.isdisjoint(given) and set(given) <= set(map(_folded, paths))
    if any(leaf.sizes and leaf.type != "string" for _, leaf in leaves):
        return False
    if kind := _returned_by(value, found):
        return paths == [leaf.path for leaf in found.shapes[kind]]
    if isinstance(value, ex.CallValue):
        return value.routine.casefold() not in map(str.casefold, found.symbols.routines)
    return paths == [path for _, path, _ in _under(value, routine, found)]


def _folded(path: MemberPath) -> MemberPath:
    return tuple(name.casefold().removesuffix("[]") for name in path)


def _returned_by(e: ex.Expression, found: _Records) -> str:
    """The type of the record that a call returns, "" of anything else."""
    return found.results.get(e.routine.casefold(), "") if isinstance(e, ex.CallValue) else ""


def _fits(s: st.Call | ex.CallValue, called: st.Routine, routine: str, found: _Records) -> bool:
    names = found.parameters.get(called.name.casefold(), {})
    if len(s.arguments) != len(called.parameters) or any(p.optional or p.switch for p in called.parameters):
        return False
    return all(
        _is_like(argument, found.shapes[names[p.name]], routine, found)
        if p.name in names
        else not _under(argument, routine, found)
        for p, argument in zip(called.parameters, s.arguments, strict=True)
    )


def _has(literal: ex.RecordLiteral, paths: list[MemberPath]) -> bool:
    """Whether a record has these members, and if it is one of the program's own no others."""
    own = [leaf.path for leaf in _leaves(literal, ())]
    return set(paths) <= set(own) if literal.type in _PARTS.values() else paths == own


def _is_like(e: ex.Expression, leaves: tuple[_Leaf, ...], routine: str, found: _Records) -> bool:
    """Whether what is handed over has these members."""
    paths = [leaf.path for leaf in leaves]
    if isinstance(e, ex.RecordLiteral):
        return _has(e, paths)
    return paths == [path for _, path, _ in _under(e, routine, found)]


def _whole(s: st.Statement, routine: str, found: _Records, allowed: list[ex.Expression]) -> set[str]:
    """Types of the records in a statement that are not taken member by member."""
    total: dict[str, int] = {}
    for e in expressions_of(s):
        if isinstance(e, ex.Named) and (key := found.of(routine, e.name)) is not None:
            total[e.name] = total.get(e.name, 0) + 1
    for e in expressions_of(s):
        leaf = _leaf_of(e, routine, found) if isinstance(e, ex.Member) else None
        root = _root(e) if leaf is not None else None
        if root is not None:
            total[root.name] -= 1
        if isinstance(e, ex.Item) and not e.indices and isinstance(e.base, ex.Member) and root is None:
            leaf = _leaf_of(e.base, routine, found)
            root = _root(e.base)
            if leaf is not None and root is not None and leaf.sizes and leaf.type != "string":
                total[root.name] += 1  # all elements at once
    for e in allowed:
        root = _root(e) if _under(e, routine, found) else None
        if root is not None:
            total[root.name] -= 1
    kinds = set()
    for name, count in total.items():
        key = found.of(routine, name)
        if count and key is not None:
            kinds.add(_kind(key, found))
    return kinds


def _kind(key: tuple[str, str], found: _Records) -> str:
    return found.variables.get(key) or found.parameters[key[0].casefold()][key[1]]


def _chain(e: ex.Expression) -> tuple[ex.Expression, MemberPath]:
    """The variable or the element of an array that a member belongs to, and the names that lead to it."""
    path: list[str] = []
    while isinstance(e, ex.Member):
        path.append(e.name)
        e = e.base
    return e, tuple(reversed(path))


def _root(e: ex.Expression) -> ex.Named | None:
    base = _chain(e)[0]
    base = base.base if isinstance(base, ex.Item) else base
    return base if isinstance(base, ex.Named) else None


def _leaf_of(e: ex.Member, routine: str, found: _Records) -> _Leaf | None:
    """The leaf that this very member is."""
    root = _root(e)
    key = None if root is None else found.of(routine, root.name)
    if key is None:
        return None
    path = tuple(name.casefold() for name in _chain(e)[1])
    leaves = found.shapes[_kind(key, found)]
    return next((leaf for leaf in leaves if tuple(name.casefold() for name in leaf.path) == path), None)


def _under(e: ex.Expression, routine: str, found: _Records) -> list[tuple[ex.Expression, MemberPath, _Leaf]]:
    """Of a record, or of a member that is one: its variable, the names from there on, and the leaf; of others none."""
    base, path = _chain(e)
    root = _root(e)
    key = None if root is None else found.of(routine, root.name)
    if key is None or not isinstance(base, (ex.Named, ex.Item)):
        return []
    lower = tuple(name.casefold() for name in path)
    leaves = found.shapes[_kind(key, found)]
    return [
        (base, leaf.path[len(path) :], leaf)
        for leaf in leaves
        if len(leaf.path) > len(path) and tuple(name.casefold() for name in leaf.path[: len(path)]) == lower
    ]


# --- Member by member ---


@dataclass(slots=True)
class _Flat:
    found: _Records
    own: dict[str, st.Routine] = field(init=False)
    _arrays: set[ex.Expression] = field(init=False)  # variables of members that are arrays themselves

    def __post_init__(self) -> None:
        own = self.found
        self.own = {r.name.casefold(): r for r in own.symbols.routines.values()}
        self._arrays = {
            ex.Named(own.names[(*key, leaf.path)])
            for key, kind in own.variables.items()
            for leaf in own.shapes[kind]
            if leaf.sizes
        }

    def routine(self, r: st.Routine) -> st.Routine:
        body = tuple(one for s in r.body for one in self.statement(s, r))
        data = tuple(one for d in r.data for one in self.declared(d, r.name))
        parameters = tuple(one for p in r.parameters for one in self._parameter(p, r))
        returns = "" if r.name.casefold() in self.found.results else r.returns
        return replace(r, body=body, data=data, parameters=parameters, returns=returns)

    def _parameter(self, p: st.Parameter, r: st.Routine) -> list[st.Parameter]:
        kind = self.found.parameters.get(r.name.casefold(), {}).get(p.name)
        if kind is None:
            return [p]
        key = (r.name.casefold(), p.name)
        return [
            replace(p, name=self.found.names[(*key, leaf.path)], type=leaf.type, native="")
            for leaf in self.found.shapes[kind]
        ]

    def declared(self, d: st.Declare, routine: str) -> list[st.Declare]:
        key = self.found.of(routine, d.name)
        if key is None or key not in self.found.variables:
            return [d]
        rows = []
        for at, leaf in enumerate(self.found.shapes[self.found.variables[key]]):
            if not leaf.type:
                continue
            value = None if d.value is None else _part(d.value, leaf.path)
            name = self.found.names[(*key, leaf.path)]
            row = replace(d, name=name, type=leaf.type, value=value, sizes=(*d.sizes, *leaf.sizes), native="")
            rows.append(row if not at else replace(row, comment=""))
        return rows

    def statement(self, s: st.Statement, r: st.Routine) -> list[st.Statement]:
        if isinstance(s, st.Declare):
            return list(self.declared(s, r.name))
        if isinstance(s, st.Assign) and _is_copy(s, r.name, self.found):
            return list(self._copied(s, r.name))
        if isinstance(s, st.Return) and _is_returned(s, r.name, self.found):
            return self._returned(s, r)
        if isinstance(s, st.Call):
            s = replace(s, arguments=self._arguments(s, r.name))
        return [mapped(s, lambda e: self._leaf(e, r.name))]

    def _copied(self, s: st.Assign, routine: str) -> Iterator[st.Statement]:
        if isinstance(s.value, ex.CallValue) and not _returned_by(s.value, self.found):
            # A routine that no file has: it is handed the members to be set.
            members = self._argument(s.target, routine)
            handed = (*self._arguments(s.value, routine), *members)
            call = st.Call(s.line, s.value.routine, handed, comment=s.comment)
            yield mapped(call, lambda e: self._leaf(e, routine))
            return
        yield from self._called(s.value, s.line, routine)
        comment = s.comment
        for base, rest, leaf in _under(s.target, routine, self.found):
            target = _all(self._named(base, leaf, routine), leaf)
            given = self._given(s.value, rest, routine)
            if given is not None:  # what a value leaves out has none
                yield mapped(st.Assign(s.line, target, given, comment), lambda e: self._leaf(e, routine))
                comment = ""

    def _returned(self, s: st.Return, r: st.Routine) -> list[st.Statement]:
        """The members of what a routine returns, in variables of their own."""
        assert s.value is not None
        rows = list(self._called(s.value, s.line, r.name))
        for leaf in self.found.shapes[self.found.results[r.name.casefold()]]:
            target = _all(ex.Named(self.found.names[(r.name.casefold(), _RESULT, leaf.path)]), leaf)
            given = self._given(s.value, leaf.path, r.name)
            if given is not None:
                rows.append(mapped(st.Assign(s.line, target, given), lambda e: self._leaf(e, r.name)))
        rows.append(replace(s, value=None, condition=None))
        if s.condition is None:
            return rows
        condition = mapped(s.condition, lambda e: self._leaf(e, r.name))
        return [st.If(s.line, condition), *rows, st.EndIf(s.line)]

    def _called(self, value: ex.Expression, line: int, routine: str) -> Iterator[st.Statement]:
        if isinstance(value, ex.CallValue):
            call = st.Call(line, value.routine, self._arguments(value, routine))
            yield mapped(call, lambda e: self._leaf(e, routine))

    def _given(self, value: ex.Expression, path: MemberPath, routine: str) -> ex.Expression | None:
        """A member of a record that is copied, None where its value leaves it out."""
        if isinstance(value, ex.RecordLiteral):
            return _part(value, path)
        if kind := _returned_by(value, self.found):
            assert isinstance(value, ex.CallValue)
            leaf = next(leaf for leaf in self.found.shapes[kind] if leaf.path == path)
            return _all(ex.Named(self.found.names[(value.routine.casefold(), _RESULT, path)]), leaf)
        return next(
            _all(self._named(base, leaf, routine), leaf)
            for base, rest, leaf in _under(value, routine, self.found)
            if rest == path
        )

    def _arguments(self, call: st.Call | ex.CallValue, routine: str) -> tuple[ex.Expression, ...]:
        called = self.own.get(call.routine.casefold())
        kinds = self.found.parameters.get(call.routine.casefold(), {})
        names = [kinds.get(p.name, "") for p in called.parameters] if called is not None else []
        return tuple(
            one
            for at, a in enumerate(call.arguments)
            for one in self._argument(a, routine, names[at] if at < len(names) else "")
        )

    def _argument(self, e: ex.Expression, routine: str, kind: str = "") -> list[ex.Expression]:
        if kind and isinstance(e, ex.RecordLiteral):
            return [part for leaf in self.found.shapes[kind] if (part := _part(e, leaf.path)) is not None]
        leaves = _under(e, routine, self.found)
        return [self._named(base, leaf, routine) for base, _, leaf in leaves] or [e]

    def _named(self, base: ex.Expression, leaf: _Leaf, routine: str) -> ex.Expression:
        root = _root(base)
        assert root is not None
        key = self.found.of(routine, root.name)
        assert key is not None
        scope = key[0].casefold() if key not in self.found.variables else key[0]
        name = ex.Named(self.found.names[(scope, key[1], leaf.path)])
        return replace(base, base=name) if isinstance(base, ex.Item) else name

    def _leaf(self, e: ex.Expression, routine: str) -> ex.Expression:
        if isinstance(e, ex.CallValue):
            return replace(e, arguments=self._arguments(e, routine))
        if isinstance(e, ex.Item) and isinstance(e.base, ex.Item) and e.base.base in self._arrays:
            return ex.Item(e.base.base, (*e.base.indices, *(e.indices or (_ALL,))))
        leaf = _leaf_of(e, routine, self.found) if isinstance(e, ex.Member) else None
        return e if leaf is None else self._named(_chain(e)[0], leaf, routine)


def _all(e: ex.Expression, leaf: _Leaf) -> ex.Expression:
    """A text as a whole, which KRL has as an array of characters."""
    if not leaf.sizes:
        return e
    return ex.Item(e.base, (*e.indices, _ALL)) if isinstance(e, ex.Item) else ex.Item(e, ())


def _part(value: ex.Expression, path: MemberPath) -> ex.Expression | None:
    """What a value has at a member; of an array the members of all its elements."""
    if isinstance(value, ex.RecordLiteral) and value.members and not value.members[0][0] and path:
        parts = [_part(one, path) for _, one in value.members]
        return ex.RecordLiteral("", tuple(("", one) for one in parts if one is not None))
    if not path:
        return value
    if not isinstance(value, ex.RecordLiteral):
        return None
    members = {name.casefold().removesuffix("[]"): one for name, one in value.members}
    inside = members.get(path[0].casefold())
    return None if inside is None else _part(inside, path[1:])
