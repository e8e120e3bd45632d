"""What the uses of a name say of its type: the kinds that functions take, and what was seen of one name."""

from __future__ import annotations

from collections.abc import Mapping, Set
from dataclasses import dataclass, field, replace
from typing import Final

from olp.ir import expressions as ex
from olp.ir import program as st
from olp.ir.transformer import expressions_of, mapped, note_names
from olp.transpile.context import Fate, TranslationContext
from olp.transpile.shared_variables import called_in, paired
from olp.transpile.symbols import Symbols, base_of, symbols_of

PLACES: Final = ("joints", "tool", "frame", "position")
TARGET: Final = "target"  # of a joint move, which goes to axis values or to a pose
# What a name is when its uses say several things: the first of these.
KINDS: Final = (*PLACES, "string", "boolean", "integer", "real")
COMPONENTS: Final = frozenset({"x", "y", "z", "rx", "ry", "rz", *(f"e{n}" for n in range(1, 7))})
_TURNS: Final = frozenset({"rx", "ry", "rz"})
AXES: Final = frozenset(f"a{n}" for n in range(1, 7))
NUMERIC: Final = ("integer", "real")
# What functions take, the last one repeated.
_TAKES: Final[Mapping[str, tuple[str, ...]]] = {
    "pose-offset": ("position", "real"),
    "pose-relative-tool": ("position", "real"),
    "pose-product": ("position",),
    "pose-inverse": ("position",),
    "pose-distance": ("position",),
    "pose-element": ("position", "integer"),
    "pose-interpolate": ("position", "position", "real"),
    "pose-add": ("position",),
    "pose-subtract": ("position",),
    "pose-angles": ("real",),
    "pose-quaternion": ("real",),
    "pose-vector": ("real",),
    "inverse": ("position",),
    "forward": ("joints",),
    "joints": ("real",),
    "length-of-text": ("string",),
    "joined-text": ("string",),
    "part-of-text": ("string", "integer"),
    "position-in-text": ("string",),
    "match-in-text": ("string", "integer", "string"),
    "find-in-text": ("string", "integer", "string"),
    "same-text": ("string", "string"),
    "code-of-character": ("string",),
    "text-of-value": ("",),
}
NUMERIC_FUNCTIONS: Final = frozenset(
    {
        "sqrt",
        "sin",
        "cos",
        "tan",
        "asin",
        "acos",
        "atan",
        "atan2",
        "abs",
        "round",
        "trunc",
        "floor",
        "ceil",
        "power",
    }
)


def taken(function: str, count: int) -> tuple[str, ...]:
    """What a function takes its `count` arguments for, "" where that tells nothing."""
    takes = _TAKES.get(function, ("real",) if function in NUMERIC_FUNCTIONS else ("",))
    return tuple(takes[min(at, len(takes) - 1)] for at in range(count))


@dataclass(slots=True)
class Use:
    """One name. `kinds`: what its uses, or those of its elements, take it for. `lines`: the first statement with it.

    `indices`: each use as an array; an index that is computed is None, one that a loop counts its largest value.
    `records`: members that no position has. `whole`: it is used without an index, too. `copied`: so is an element.
    """

    name: str
    first: st.Statement
    kinds: set[str] = field(default_factory=set)
    indices: list[tuple[int | None, ...]] = field(default_factory=list)
    computed: dict[int, st.Statement] = field(
        default_factory=dict
    )  # by line: with an index that nothing bounds
    records: set[str] = field(default_factory=set)
    whole: bool = False
    copied: bool = False
    assigned: bool = False
    kept: int = 0  # elements of each dimension at least

    @property
    def kind(self) -> str:
        """Its type, as `Declare.type` says it; a name of which nothing can be told is a number."""
        return next(
            (kind for kind in KINDS if kind in self.kinds), "position" if TARGET in self.kinds else "real"
        )

    @property
    def sizes(self) -> tuple[int, ...]:
        """The largest index of each dimension, 0 where none is known; () of what is no array."""
        if not self.indices or (self.kind == "joints" and self.whole):
            return ()
        count = max(map(len, self.indices))
        known = [[row[at] or 0 for row in self.indices if at < len(row)] for at in range(count)]
        return tuple(max(self.kept, *column, 0) for column in known)


# --- References ---
# Parameters that a routine hands back: by value where it never changes them, as its result where it changes one, and
# else in variables of the program, which its calls set before and read behind.

_ROUNDS: Final = 5  # of routines that hand a parameter on


def references(program: st.Program, work: TranslationContext) -> st.Program:
    """`PROC a(PERS tooldata t)` as `PROC a(tooldata t)` where nothing assigns to t, here or in what it is handed to.

    A language that hands on variables takes no number in their place: there by value too, if some call gives one.
    """
    if work.limits.reference_parameters:
        if work.source.vendor == work.target or not _hands_values(program, work):
            return program
        return _in_turns(_by_value(program), work)
    program = _in_turns(_by_value(program), work)
    _tell_aliases(program, work)
    return _in_variables(_returned(program, work), work) if work.limits.returned_parameters else program


def _hands_values(program: st.Program, work: TranslationContext) -> bool:
    """Whether a call hands a parameter that is a reference anything else than a variable of the target."""
    taken = {r.name.casefold(): r.parameters for r in program.routines}
    for s in work.rare(program):
        calls: list[st.Call | ex.CallValue] = [s] if isinstance(s, st.Call) else []
        calls += [e for e in expressions_of(s) if isinstance(e, ex.CallValue)]
        for call in calls:
            references = {p.name for p in taken.get(call.routine.casefold(), ()) if p.by_reference}
            given = paired(taken.get(call.routine.casefold(), ()), call.arguments)
            if any(
                name in references
                and (not isinstance(e, (ex.Named, ex.Item, ex.Member)) or _is_no_place(e, work))
                for name, e in given
            ):
                return True
    return False


def _is_no_place(e: ex.Expression | None, work: TranslationContext) -> bool:
    """Whether the target has no variable for a component: an angle of a turn that it holds as one value, and, where
    calls return what they change, whatever has another unit there."""
    limits = work.limits
    parts = COMPONENTS if limits.returned_parameters else _TURNS
    return limits.angles_together and isinstance(e, ex.Member) and e.name in parts


def _in_turns(program: st.Program, work: TranslationContext) -> st.Program:
    """Components that are no variables there, handed over to be changed: in one that is read back behind the call."""
    taken = {}
    for routine in program.routines:
        count = sum(p.by_reference for p in routine.parameters)
        if count == 1 or (
            count and work.limits.reference_parameters
        ):  # several come back in variables anyhow
            taken[routine.name.casefold()] = routine.parameters
    return (
        replace(program, routines=tuple(_apart(r, taken, work) for r in program.routines))
        if taken
        else program
    )


def _apart(
    routine: st.Routine, taken: Mapping[str, tuple[st.Parameter, ...]], work: TranslationContext
) -> st.Routine:
    names: list[str] = []
    body: list[st.Statement] = []
    for s in routine.body:
        calls: list[st.Call | ex.CallValue] = [s] if isinstance(s, st.Call) else []
        calls += [e for e in expressions_of(s) if isinstance(e, ex.CallValue)]
        found = [(call, e) for call in calls for e in _without_place(call, taken, work)]
        if not found:
            body.append(s)
            continue
        if (
            _call_of(s) is not found[0][0]
            or any(call is not found[0][0] for call, _ in found)
            or not all(_stays(e, routine, found[0][0]) for _, e in found)
        ):
            says = f"{found[0][0].routine} changes a component of a position, which is no variable there"
            work.lose(s, Fate.REFUSED, "argument", says)
            body.append(s)
            continue
        while len(names) < len(found):
            names.append(work.fresh("component"))
        pairs = [(e, ex.Named(name)) for (_, e), name in zip(found, names, strict=False)]
        body += [st.Assign(s.line, name, e) for e, name in pairs]
        body.append(_handing(s, pairs))
        body += [st.Assign(s.line, e, name) for e, name in pairs]
    if not names:
        return routine
    own = [st.Declare(routine.line, name, "real") for name in names]
    return replace(routine, body=(*own, *body))


def _without_place(
    call: st.Call | ex.CallValue, taken: Mapping[str, tuple[st.Parameter, ...]], work: TranslationContext
) -> list[ex.Member]:
    parameters = taken.get(call.routine.casefold(), ())
    references = {p.name for p in parameters if p.by_reference}
    given = paired(parameters, call.arguments) if references else ()
    return [e for p, e in given if p in references and isinstance(e, ex.Member) and _is_no_place(e, work)]


def _handing(s: st.Statement, pairs: list[tuple[ex.Member, ex.Named]]) -> st.Statement:
    call = _call_of(s)
    assert call is not None
    new = {id(e): name for e, name in pairs}

    def one(e: ex.Expression) -> ex.Expression:
        if isinstance(e, ex.NamedArgument) and e.value is not None:
            return replace(e, value=new.get(id(e.value), e.value))
        return new.get(id(e), e)

    arguments = tuple(map(one, call.arguments))
    if isinstance(s, st.Call):
        return replace(s, arguments=arguments)
    assert isinstance(s, st.Assign)
    assert isinstance(call, ex.CallValue)
    return replace(s, value=replace(call, arguments=arguments))


def _stays(e: ex.Expression, routine: st.Routine, call: st.Call | ex.CallValue) -> bool:
    """Whether a place means the same behind a call: what its indices are made of is the caller's own, and kept."""
    indices: set[str] = set()
    while isinstance(e, (ex.Item, ex.Member)):
        for index in e.indices if isinstance(e, ex.Item) else ():
            note_names(index, indices)
        e = e.base
    handed = {one.name for one in call.arguments if isinstance(one, ex.Named)}
    return indices <= _own_names(routine) - handed


def _by_value(program: st.Program) -> st.Program:
    for _ in range(_ROUNDS):
        if not any(p.by_reference for r in program.routines for p in r.parameters):
            break
        symbols = symbols_of(program)
        routines = tuple(
            replace(r, parameters=tuple(_plain(r, p, symbols) for p in r.parameters))
            for r in program.routines
        )
        if all(a.parameters == b.parameters for a, b in zip(routines, program.routines, strict=True)):
            break
        program = replace(program, routines=routines)
    return program


def _plain(routine: st.Routine, one: st.Parameter, symbols: Symbols) -> st.Parameter:
    symbol = symbols.find(routine.name, one.name)
    changed = symbol is None or symbol.assigned
    return one if not one.by_reference or changed else replace(one, by_reference=False)


def _tell_caller(routine: st.Routine, work: TranslationContext, called: Set[str], does: str) -> None:
    """What programs that are not here have to do where nothing here calls a routine that hands something back."""
    if routine.name.casefold() not in called:
        says = f"nothing here calls {routine.name}: its caller has to {does}"
        work.lose(routine.line, Fate.APPROXIMATED, "argument", says)


def _called(program: st.Program) -> set[str]:
    return {name.casefold() for s in program.statements() for name in called_in(s)}


def _returned(program: st.Program, work: TranslationContext) -> st.Program:
    """A routine that hands one parameter back and returns nothing returns it; its calls store it."""
    inside = _called(program)
    started = {s.routine.casefold() for s in program.statements() if isinstance(s, st.StartTask)}
    handed: dict[str, tuple[st.Routine, st.Parameter]] = {}
    for routine in program.routines:
        changed = [p for p in routine.parameters if p.by_reference]
        if len(changed) == 1 and not routine.returns and routine.name.casefold() not in started:
            handed[routine.name.casefold()] = routine, changed[0]

    def row(s: st.Statement) -> st.Statement:
        if not isinstance(s, st.Call) or s.result is not None or s.routine.casefold() not in handed:
            return s
        called, one = handed[s.routine.casefold()]
        given = next((e for p, e in paired(called.parameters, s.arguments) if p == one.name), None)
        return replace(s, result=given) if isinstance(given, (ex.Named, ex.Item, ex.Member)) else s

    routines = []
    for routine in program.routines:
        routine = replace(routine, body=tuple(map(row, routine.body)))
        if routine.name.casefold() in handed:
            one = handed[routine.name.casefold()][1]
            _tell_caller(routine, work, inside, f"read {one.name} as what it returns")
            routine = _with_result(routine, one)
        routines.append(routine)
    return replace(program, routines=tuple(routines))


def _with_result(routine: st.Routine, one: st.Parameter) -> st.Routine:
    value = ex.Named(one.name)
    body: list[st.Statement] = [
        replace(s, value=value) if isinstance(s, st.Return) else s
        for s in routine.body
        if not isinstance(s, st.End)
    ]
    if not body or not isinstance(body[-1], st.Return) or body[-1].condition is not None:
        body.append(st.Return(routine.body[-1].line if routine.body else routine.line, value))
    parameters = tuple(replace(p, by_reference=False) if p is one else p for p in routine.parameters)
    return replace(routine, body=tuple(body), parameters=parameters, returns=one.type or "real")


_FIRST: Final[Mapping[str, ex.Expression]] = {
    "integer": ex.Number(0),
    "real": ex.Number(0.0),
    "boolean": ex.SignalState(False),
    "string": ex.Text(""),
    "position": ex.PositionLiteral("pose", (0.0,) * 6),
    "joints": ex.PositionLiteral("joint", (0.0,) * 6),
}


def _in_variables(program: st.Program, work: TranslationContext) -> st.Program:
    """Parameters that a routine hands back as variables of the program, where every call of it stands alone.

    A routine that calls itself, and one that is called within a condition or a sum, keep theirs.
    """
    routines = {r.name.casefold(): r for r in program.routines}
    handed = {
        name: {p.name: work.fresh(f"{r.name}_{p.name}") for p in r.parameters if p.by_reference}
        for name, r in routines.items()
        if any(p.by_reference for p in r.parameters) and _may_be_variables(r)
    }
    handed = {name: new for name, new in handed.items() if name not in reached_from(name, routines)}
    for s in program.statements() if handed else ():
        alone = _call_of(s)
        inside = {
            e.routine.casefold() for e in expressions_of(s) if isinstance(e, ex.CallValue) and e is not alone
        }
        if isinstance(s, st.StartTask):
            inside.add(s.routine.casefold())
        if alone is not None and not _is_plain(routines.get(alone.routine.casefold()), alone):
            inside.add(alone.routine.casefold())
        for name in inside:
            handed.pop(name, None)
    if not handed:
        return program
    called = _called(program)
    for name, names in handed.items():
        _tell_caller(
            routines[name], work, called, f"set before, and read behind: {', '.join(names.values())}"
        )
    data = [
        st.Declare(0, new, p.type, _FIRST[p.type], shared=True)
        for name, names in handed.items()
        for p in routines[name].parameters
        if (new := names.get(p.name)) is not None
    ]
    bodies = [replace(r, body=_renamed(r, handed.get(r.name.casefold(), {}))) for r in program.routines]
    made = [
        replace(
            r,
            body=tuple(row for s in r.body for row in _around(s, handed, routines)),
            parameters=tuple(p for p in r.parameters if p.name not in handed.get(r.name.casefold(), {})),
        )
        for r in bodies
    ]
    return replace(program, routines=tuple(made), data=(*program.data, *data))


def _tell_aliases(program: st.Program, work: TranslationContext) -> None:
    """Refuses calls whose routine also reaches by its name what they hand over to be changed: it gets a copy."""
    routines = {r.name.casefold(): r for r in program.routines}
    changing = {name for name, r in routines.items() if any(p.by_reference for p in r.parameters)}
    named: dict[str, set[str]] = {}
    for routine in program.routines if changing else ():
        for s in routine.body:
            calls: list[st.Call | ex.CallValue] = [s] if isinstance(s, st.Call) else []
            calls += [e for e in expressions_of(s) if isinstance(e, ex.CallValue)]
            for call in calls:
                name = call.routine.casefold()
                if name not in changing:
                    continue
                if name not in named:
                    named[name] = _names_within(name, routines)
                given = paired(routines[name].parameters, call.arguments)
                references = {p.name for p in routines[name].parameters if p.by_reference}
                places = [e for p, e in given if p in references and base_of(e) is not None]
                shared = named[name] - _own_names(routine)
                for one in places:
                    base = base_of(one)
                    if base is not None and (base.name in shared or places.count(one) > 1):
                        says = f"{call.routine} reaches {base.name} in another way, too: there it gets a copy of it"
                        work.lose(s, Fate.REFUSED, "argument", says)
                        break


def _names_within(name: str, routines: Mapping[str, st.Routine]) -> set[str]:
    """The variables of the program that a routine, and what it calls, names."""
    found: set[str] = set()
    for one in {name, *reached_from(name, routines)}:
        routine = routines.get(one)
        if routine is None:
            continue
        names: set[str] = set()
        for s in routine.body:
            for e in expressions_of(s):
                note_names(e, names)
        found |= names - _own_names(routine)
    return found


def _own_names(routine: st.Routine) -> set[str]:
    return {p.name for p in routine.parameters} | {
        s.name for s in (*routine.data, *routine.body) if isinstance(s, st.Declare)
    }


def _may_be_variables(r: st.Routine) -> bool:
    return all(
        p.type in _FIRST and "[" not in p.native and not (p.optional or p.switch or p.default)
        for p in r.parameters
        if p.by_reference
    )


def reached_from(name: str, routines: Mapping[str, st.Routine]) -> set[str]:
    """The routines that one calls, directly or through others."""
    found: set[str] = set()
    todo = [name]
    while todo:
        routine = routines.get(todo.pop())
        for s in routine.body if routine is not None else ():
            called = [s.routine] if isinstance(s, (st.Call, st.StartTask)) else []
            called += [e.routine for e in expressions_of(s) if isinstance(e, ex.CallValue)]
            new = {one.casefold() for one in called} - found
            found |= new
            todo += new
    return found


def _call_of(s: st.Statement) -> st.Call | ex.CallValue | None:
    """The call that a statement is, or whose value is all that it assigns."""
    if isinstance(s, st.Call):
        return s
    return s.value if isinstance(s, st.Assign) and isinstance(s.value, ex.CallValue) else None


def _is_plain(called: st.Routine | None, call: st.Call | ex.CallValue) -> bool:
    """Whether what a call hands to parameters that come back can be read once more behind it."""
    if called is None:
        return True
    if isinstance(call, st.Call) and (call.condition is not None or call.jump):
        return False
    if any(isinstance(e, ex.NamedArgument) for e in call.arguments):
        return False
    given = dict(paired(called.parameters, call.arguments))
    places = [given.get(p.name) for p in called.parameters if p.by_reference]
    return all(
        e is not None
        and not (isinstance(e, ex.Item) and not all(isinstance(i, ex.Number) for i in e.indices))
        for e in places
    )


def _renamed(r: st.Routine, names: Mapping[str, str]) -> tuple[st.Statement, ...]:
    if not names:
        return r.body
    return tuple(
        mapped(s, lambda e: ex.Named(names[e.name]) if isinstance(e, ex.Named) and e.name in names else e)
        for s in r.body
    )


def _around(
    s: st.Statement, handed: Mapping[str, Mapping[str, str]], routines: Mapping[str, st.Routine]
) -> list[st.Statement]:
    """A call between what sets the variables and what reads them."""
    call = _call_of(s)
    names = handed.get(call.routine.casefold()) if call is not None else None
    if call is None or names is None:
        return [s]
    parameters = routines[call.routine.casefold()].parameters
    given = dict(paired(parameters, call.arguments))
    before = [
        st.Assign(s.line, ex.Named(names[p]), e) for p, e in given.items() if p in names and e is not None
    ]
    behind: list[st.Statement] = [
        st.Assign(s.line, e, ex.Named(names[p]))
        for p, e in given.items()
        if p in names and isinstance(e, (ex.Named, ex.Item, ex.Member))
    ]
    left = tuple(e for p in parameters if p.name not in names and (e := given.get(p.name)) is not None)
    if isinstance(call, st.Call):
        return [*before, replace(call, arguments=left), *behind]
    assert isinstance(s, st.Assign)
    return [*before, replace(s, value=replace(call, arguments=left)), *behind]
