"""Names that no available file declares get a declaration without a value, of the type that their uses suggest.

What moves there, or runs with a tool or in a frame that only such a name tells, is no exact translation.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field, replace
from typing import Any, Final, TypeGuard

from olp.ir import expressions as ex
from olp.ir import program as st
from olp.ir.transformer import calls_nothing, changed_by, expressions_of, mapped, note_names, sets_numbers
from olp.languages.vendor import Conventions, conventions_of, language_of, part_of
from olp.transpile.context import Fate, TranslationContext
from olp.transpile.first_values import TEACH_UNDECLARED, UNDECLARED
from olp.transpile.integer_inference import loop_counters
from olp.transpile.name_types import AXES, COMPONENTS, KINDS, NUMERIC, PLACES, TARGET, Use, taken
from olp.transpile.occurrences import Look
from olp.transpile.shared_variables import called_in, handed_over, paired
from olp.transpile.symbols import Symbols, base_of, kind_of_value, symbols_of

_WORDS: Final = {
    "integer": "a whole number",
    "real": "a number",
    "boolean": "true or false",
    "string": "a text",
    "position": "a Cartesian position",
    "joints": "a position by its axes",
    "tool": "a tool",
    "frame": "a frame",
}
_DEEPEST: Final = 6  # members of members
_SYSTEMS_READ: Final = {"Tool": "tool", "WObj": "frame"}  # with which, and in which, a position is read
_KEPT: Final = 20  # elements of an array with a computed index, where the target numbers its variables
ASKS: Final = {
    "taught": TEACH_UNDECLARED,
    "set": "set what no file here declares",
    "status": "set, all the time, what the source's controller tells of itself",
}


def declarations(program: st.Program, work: TranslationContext) -> st.Program:
    """Declares the names that the program uses and nothing declares."""
    program = _typed_parameters(_typed_variables(loop_counters(program, work), work), work)
    program = _typed_results(program)
    _tell_assumed(program, work)
    _tell_calls(program, work)
    unwaited = _unwaited(program)
    if unwaited:
        _refuse_own(program, unwaited, work)
        program = replace(program, data=tuple(d for d in program.data if d.name not in unwaited))
    uses = {name: use for name, use in uses_of(program, work).items() if name not in unwaited}
    if not uses:
        return program
    for _ in range(_DEEPEST):
        records = {name for name, use in uses.items() if use.records and not use.whole and not use.copied}
        if not records:
            break
        program = _flattened(program, records, work)
        uses = {name: use for name, use in uses_of(program, work).items() if name not in unwaited}
    also = work.conventions.own_names
    own = {
        name
        for name in uses
        if work.conventions.is_controllers(name) or (also is not None and also.fullmatch(name))
    }
    told = {
        name for name in own if _is_status(name, uses[name], work.conventions)
    }  # whoever runs it has to tell them there
    own -= told
    _refuse_own(program, own, work)
    uses = {name: use for name, use in uses.items() if name not in own}
    for use in uses.values():
        if use.computed:
            use.kept = work.row_sizes.get(use.name, _KEPT if work.limits.numbered else 0)
    for use in uses.values():
        _tell(use, work)
        work.undeclared[use.name] = use.kind
    _refuse_members(program, {name for name, use in uses.items() if use.records}, work)
    if work.limits.dimensions == "numbers":
        tables = {n for n, use in uses.items() if len(use.sizes) > 1 and use.kind not in NUMERIC}
        _refuse_tables(program, tables, work)
    _tell_moves(program, uses, work)
    program = _with_axes(program, {name for name, use in uses.items() if use.kind == "joints"})
    return replace(program, data=(*program.data, *map(_declaration, uses.values())))


def _typed_variables(program: st.Program, work: TranslationContext) -> st.Program:
    """Variables whose type no declaration and no value tells (what a routine of no file returns), as their uses are."""
    routines: list[st.Routine] = []
    for r in program.routines:
        open_ = {s.name: s for s in reversed(r.body) if _is_untyped(s)}
        if open_:
            body = [_as_stored(s) if _is_untyped(s) else s for s in r.body]
            uses = _uses_alone(program, r, replace(r, body=tuple(body)), program.data)
            types = {name: _type_of(name, "variable", uses.get(name), open_[name], work) for name in open_}
            r = replace(r, body=tuple([_with_type(s, types) if _is_untyped(s) else s for s in r.body]))
        routines.append(r)
    return replace(program, routines=tuple(routines))


def _is_untyped(s: st.Statement) -> TypeGuard[st.Declare]:
    return type(s) is st.Declare and not s.type and not s.sizes


def _as_stored(s: st.Declare) -> st.Statement:
    return st.Assign(s.line, ex.Named(s.name), s.value) if s.value is not None else st.Comment(s.line, "")


def _with_type(s: st.Declare, types: Mapping[str, str]) -> st.Declare:
    return replace(s, type=types[s.name])


def _uses_alone(
    program: st.Program, r: st.Routine, alone: st.Routine, data: tuple[st.Declare, ...]
) -> dict[str, Use]:
    """How a routine uses the names that it no longer declares."""
    others = [one for one in program.routines if one is not r]
    uses = _Seen(program, symbols_of(replace(program, routines=(alone, *others), data=data)))
    uses.look_at(alone)
    uses.spread()
    return uses.uses


def _typed_parameters(program: st.Program, work: TranslationContext) -> st.Program:
    """Parameters without a type (scripts have none) as what their routine takes them for."""
    untyped = {
        r.name: {p.name for p in r.parameters if not p.type and not p.switch} for r in program.routines
    }
    routines: list[st.Routine] = []
    for r in program.routines:
        open_ = untyped[r.name]
        if open_:
            # What a routine does not declare is undeclared: its uses tell what it is.
            alone = replace(r, parameters=tuple(p for p in r.parameters if p.name not in open_))
            data = tuple(d for d in program.data if d.name not in open_)
            uses = _uses_alone(program, r, alone, data)
            taken_for = {
                p: _type_of(p, "parameter", use := uses.get(p), r.line if use is None else use.first, work)
                for p in sorted(open_)
            }
            r = replace(
                r,
                parameters=tuple(
                    replace(p, type=taken_for[p.name], sizes=_open_sizes(p, uses.get(p.name)))
                    if p.name in open_
                    else p
                    for p in r.parameters
                ),
            )
        routines.append(r)
    return _handed_arrays(replace(program, routines=tuple(routines)), untyped)


def _handed_arrays(program: st.Program, untyped: Mapping[str, set[str]]) -> st.Program:
    """Parameters without a type that their routine hands on as an array are arrays, too."""
    while True:
        taken = {r.name: r.parameters for r in program.routines}
        routines: list[st.Routine] = []
        for r in program.routines:
            sizes: dict[str, tuple[ex.Expression, ...]] = {}
            for called, arguments in (pair for s in r.body if untyped[r.name] for pair in handed_over(s)):
                rows = {p.name: p.sizes for p in taken.get(called, ()) if p.sizes}
                for name, e in paired(taken.get(called, ()), arguments):
                    if name in rows and type(e) is ex.Named and e.name in untyped[r.name]:
                        sizes[e.name] = rows[name]
            given = tuple(
                replace(p, sizes=sizes[p.name]) if p.name in sizes and not p.sizes else p
                for p in r.parameters
            )
            routines.append(r if given == r.parameters else replace(r, parameters=given))
        if all(new is old for new, old in zip(routines, program.routines, strict=True)):
            return program
        program = replace(program, routines=tuple(routines))


def _open_sizes(p: st.Parameter, use: Use | None) -> tuple[ex.Expression, ...]:
    """The dimensions of a parameter that its routine uses with indices; how many elements there are is the caller's."""
    if p.sizes or use is None or (use.whole and use.kind in PLACES):
        return p.sizes
    return tuple(ex.Unknown("") for _ in use.sizes)


def _typed_results(program: st.Program) -> st.Program:
    """Routines that return a value as functions of its type, also where the text alone gave that value none."""
    symbols = symbols_of(program)
    routines: list[st.Routine] = []
    for r in program.routines:
        if not r.returns:
            values = (s.value for s in r.body if type(s) is st.Return and s.value is not None)
            kinds = {kind_of_value(symbols, r.name, value) for value in values}
            if len(kinds) == 1:
                r = replace(r, returns=kinds.pop())
        routines.append(r)
    return replace(program, routines=tuple(routines))


def _type_of(name: str, what: str, use: Use | None, at: st.Statement | int, work: TranslationContext) -> str:
    """The type of a parameter or variable that the text gives none, told at a statement or line."""
    kind = "real" if use is None else use.kind
    if kind == "integer" and not work.conventions.whole_numbers:
        kind = "real"
    says = f"{name}, a {what} without a type, is taken for {_taken(use)}"
    work.lose(at, Fate.APPROXIMATED, what, says)
    return kind


def _tell_assumed(program: st.Program, work: TranslationContext) -> None:
    """Statements that mean what the reader has assumed, because no file says it."""
    codes = work.conventions.assumed_codes
    said: dict[int, list[str]] = {}
    for d in program.diagnostics if codes else ():
        if d.code in codes:
            said.setdefault(d.line, []).append(d.message)
    for s in program.statements() if said else ():
        for message in said.get(s.line, ()) if not isinstance(s, st.Comment) else ():
            work.lose(s, Fate.APPROXIMATED, "value", message)


def _is_status(name: str, use: Use, conventions: Conventions) -> bool:
    """Whether a name is a value of the controller's own that the program reads and does not set."""
    return conventions.is_controllers(name) and not use.assigned and use.kind not in PLACES


def _flattened(program: st.Program, records: set[str], work: TranslationContext) -> st.Program:
    """Members of structures whose layout nobody knows (RAPID's vFast.v_tcp) as variables of their own."""
    names: dict[tuple[str, str], str] = {}

    def change(e: ex.Expression) -> ex.Expression:
        name = _member_of(e)
        if type(e) is not ex.Member or name not in records:
            return e
        key = (name, e.name.casefold())
        if key not in names:
            names[key] = work.fresh(f"{name}_{e.name}")
        member = ex.Named(names[key])
        return replace(e.base, base=member) if type(e.base) is ex.Item else member

    routines = tuple(replace(r, body=tuple([mapped(s, change) for s in r.body])) for r in program.routines)
    return replace(program, routines=routines)


def _refuse_members(program: st.Program, records: set[str], work: TranslationContext) -> None:
    """Members of structures that are also taken as a whole: without their layout there is no declaration of them."""
    for s in program.statements() if records else ():
        for name in sorted({_member_of(e) for e in expressions_of(s)} & records):
            says = f"{name} is not declared here, and nothing tells the members of its type"
            work.lose(s, Fate.REFUSED, "name", says)


def _refuse_tables(program: st.Program, tables: set[str], work: TranslationContext) -> None:
    """Rows of rows in a language that has them of numbers alone: without their sizes they become no single row."""
    for s in program.statements() if tables else ():
        for name in sorted(_names(s) & tables):
            says = f"{name} is not declared here, and {language_of(work.target)} has several indices for numbers alone"
            work.lose(s, Fate.REFUSED, "index", says)


def _member_of(e: ex.Expression) -> str:
    """The variable that an expression takes a member of which no position has, "" of any other expression."""
    if type(e) is not ex.Member or e.name.casefold() in COMPONENTS | AXES:
        return ""
    base = e.base.base if type(e.base) is ex.Item else e.base
    return base.name if type(base) is ex.Named else ""


def _unwaited(program: st.Program) -> set[str]:
    """The limit of waits, where no wait here has it: it would hold for programs that are not at hand."""
    prefix = conventions_of(program.vendor).wait_limit_prefix
    if not prefix:
        return set()
    found = {d.name for d in program.data if d.name.startswith(prefix)}
    for s in program.statements() if found else ():
        if isinstance(s, st.Wait):
            found -= _names(s)
    return found


def _refuse_own(program: st.Program, names: set[str], work: TranslationContext) -> None:
    """What sets a variable of the controller, or moves to one: as a program's own variable it would mean nothing."""
    for s in program.statements() if names else ():
        found = sorted(_names(s) & names)
        if found:
            own, other = language_of(program.vendor), language_of(work.target)
            says = f"{found[0]} belongs to {own}'s controllers, those of {other} have none"
            work.lose(s, Fate.REFUSED, "name", says)


def _tell_calls(program: st.Program, work: TranslationContext) -> None:
    """Calls of routines that no file at hand has; those that only the source's own controllers have are refused."""
    known = {routine.name.casefold() for routine in program.routines}
    known |= {name.casefold() for name in work.context.mapping.routines}
    own: Mapping[str, str] = part_of(program.vendor, "known_routines") or {}
    values: Mapping[str, str] = (
        part_of(program.vendor, "known_functions") or own
    )  # statements call programs alone
    other = language_of(work.target)
    called = [(s, name) for r in program.routines for _, s in work.look(r).rare for name in called_in(s)]
    for s, name in called:
        if not name or name.casefold() in known:
            continue
        calls = isinstance(s, st.Call) and s.routine == name
        what = (own if calls else values).get(name.casefold())
        if what is None or name.casefold() in work.conventions.replaceable_routines:
            where = "is in no file here" if what is None else f"is {what}"
            if what is None:
                work.missing.add(name)
            says = f"{name} {where}: {other} needs a routine of its own for it{_told_of(s, name, work)}"
            work.lose(s, Fate.APPROXIMATED, "call", says)
        else:
            help = f'write one for {other} and name it in the mapping file: [routines] {name} = "…"'
            work.lose(s, Fate.REFUSED, "call", f"{name}, {what}, is unknown to {other}", help=help)


def _told_of(s: st.Statement, name: str, work: TranslationContext) -> str:
    """How a routine gives back its value, and what it may do with the variables of a call and cannot in the target."""
    calls = [
        e for e in (s, *expressions_of(s)) if isinstance(e, (st.Call, ex.CallValue)) and e.routine == name
    ]
    if work.limits.numbered and any(isinstance(call, ex.CallValue) for call in calls):
        kept = _kept(calls, work).replace(", which", ", and which")
        return f", which puts its value into the variable whose number is its last argument{kept}"
    return _kept(calls, work)


def _kept(calls: list[st.Call | ex.CallValue], work: TranslationContext) -> str:
    named = any(base_of(one) is not None for call in calls for one in call.arguments)
    if not named or not work.target_conventions.arguments_are_values:
        return ""
    fills = any(call.routine.casefold() in work.conventions.filling_routines for call in calls)
    if work.conventions.arguments_are_values and not fills:
        return ""
    return ", which cannot change its arguments"


def _declaration(use: Use) -> st.Declare:
    storage = "persistent" if use.kind in PLACES else "variable"
    sizes = tuple(ex.Number(max(size, 1)) for size in use.sizes)
    return st.Declare(0, use.name, use.kind, None, sizes, storage, shared=True, comment=UNDECLARED)


def _taken(use: Use | None) -> str:
    """What a name is taken for, in words."""
    if use is None or not use.kinds:
        return "a number, because nothing gives its type"
    if TARGET in use.kinds and use.kind == "position":
        return "a Cartesian position, which it may not be"
    return _WORDS[use.kind]


def _tell(use: Use, work: TranslationContext) -> None:
    """One line for each name, at its first use."""
    kind = _taken(use)
    verb = "taught" if use.kind in PLACES else "set"
    own = work.conventions.is_controllers(use.name)
    where = "tells of the source's controller" if own else "is not declared here"
    says = f"{use.name} {where}: taken for {kind}"
    size = ""
    if use.indices and use.sizes:
        size = "x".join(str(max(size, 1)) for size in use.sizes)
        says += f", {size} of them"
    says += f"; its value has to be {verb}"
    work.lose(use.first, Fate.APPROXIMATED, "name", says, name=use.name)
    work.ask(ASKS["status" if own else verb], use.name)
    apart = work.target_conventions.first_element - work.conventions.first_element
    if size and apart and not work.limits.numbered:
        higher = "one higher" if apart > 0 else "one lower"
        work.ask(
            f"copy the elements of these under a number that is {higher} in each index, as the first has another",
            use.name,
        )
    if not use.sizes or not use.computed:
        return
    if work.limits.numbered or use.name in work.row_sizes:
        # An index beyond them is that of another variable, in a row of rows of another element: the limit has to be
        # seen by whoever runs the program.
        work.ask("see that no index goes beyond the numbers kept for what no file here declares", use.name)
        says = (
            f"nothing here tells how many elements {use.name} has: {size} are kept, none may be used beyond"
        )
        for s in use.computed.values():
            work.lose(s, Fate.APPROXIMATED, "index", says)
        return
    # The controller stops at an index beyond a declaration that is too small: nothing is silently wrong.
    work.ask("set how many elements those have that no file here declares", use.name)
    says = f"nothing here tells how many elements {use.name} has: its declaration has the largest index written out"
    for s in use.computed.values():
        work.lose(s, Fate.APPROXIMATED, "index", says)


def _with_axes(program: st.Program, joints: set[str]) -> st.Program:
    """Axes by their numbers, as those of declared joint values are."""

    def change(e: ex.Expression) -> ex.Expression:
        if type(e) is ex.Member and e.name.casefold() in AXES and (root := base_of(e)) is not None:
            return ex.Item(e.base, (ex.Number(int(e.name[1:])),)) if root.name in joints else e
        return e

    if not joints:
        return program
    routines = tuple(replace(r, body=tuple([mapped(s, change) for s in r.body])) for r in program.routines)
    return replace(program, routines=routines)


def _tell_moves(program: st.Program, uses: dict[str, Use], work: TranslationContext) -> None:
    """Every move that depends on such a name, or on a position that is computed from one."""
    origin = {name: name for name in uses}
    places = {name for name, use in uses.items() if use.kind in PLACES}
    _spread(program, origin, places)
    told = {(use.first.line, use.name) for use in uses.values()}
    for s in program.statements():
        if type(s) is not st.Move and type(s) is not st.Assign:
            continue
        for name in sorted({origin[n] for n in _names(s) if n in (origin if type(s) is st.Move else places)}):
            if (s.line, name) not in told:
                told.add((s.line, name))
                work.lose(s, Fate.APPROXIMATED, "name", f"it depends on {name}, which is not declared here")


def _spread(program: st.Program, origin: dict[str, str], places: set[str]) -> None:
    """Adds the variables and parameters that positions of undeclared names are handed to."""
    by_name = {routine.name.casefold(): routine for routine in program.routines}
    handed: list[tuple[str, Iterable[str]]] = []
    for s in program.statements():
        if type(s) is st.Assign and (base := base_of(s.target)) is not None:
            handed.append((base.name, sorted(_names(s.value))))
        elif type(s) is st.Call and s.routine.casefold() in by_name:
            handed += _arguments(by_name[s.routine.casefold()], s)
    changed = True
    while changed:
        changed = False
        for name, sources in handed:
            found = next((source for source in sources if source in places), None)
            if found is not None and name not in origin:
                origin[name] = origin[found]
                places.add(name)
                changed = True


def _arguments(called: st.Routine, s: st.Call) -> list[tuple[str, Iterable[str]]]:
    given = paired(called.parameters, s.arguments)
    return [(name, sorted(_names(value))) for name, value in given if value is not None]


def _names(node: st.Statement | ex.Expression) -> set[str]:
    found: set[str] = set()
    note_names(node, found)
    return found


# --- Name uses ---
# How a program uses the names that nothing at hand declares: what tells their type, and how large their arrays are.


def uses_of(program: st.Program, work: TranslationContext) -> dict[str, Use]:
    """The names of `program` that nothing declares, in order of their first use."""
    symbols = work.symbols(program)
    if not any(_uses_unknown(routine, symbols, work.look(routine)) for routine in program.routines):
        return {}
    seen = _Seen(program, symbols)
    for routine in program.routines:
        seen.look_at(routine)
    seen.spread()
    signs = conventions_of(program.vendor).name_signs
    for use in seen.uses.values() if signs else ():
        sign = next((kind for sign, kind in signs.items() if use.name.startswith(sign)), None)
        use.kinds = use.kinds if sign is None else {sign}
    if not conventions_of(program.vendor).whole_numbers:
        for use in seen.uses.values():
            use.kinds = {"real" if kind == "integer" else kind for kind in use.kinds}
    return seen.uses


def _uses_unknown(routine: st.Routine, symbols: Symbols, look: Look) -> bool:
    """Whether a routine names anything that nothing declares."""
    for name in look.names() - symbols.declared.keys():
        symbol = symbols.find(routine.name, name)
        if symbol is None or not symbol.declared:
            return True
    return False


@dataclass(slots=True)
class _Seen:
    program: st.Program
    symbols: Symbols
    uses: dict[str, Use] = field(default_factory=dict)
    links: list[tuple[str, str]] = field(default_factory=list)  # names that hold the same kind of value
    routine: st.Routine = field(init=False)
    counted: dict[str, list[int | None]] = field(
        default_factory=dict
    )  # of loops that are open: largest value
    loops: list[str] = field(default_factory=list)
    statement: st.Statement = field(init=False)

    def look_at(self, routine: st.Routine) -> None:
        self.routine = routine
        for s in routine.body:
            self.statement = s
            if type(s) is st.Move:
                self._move(s)
            if calls_nothing(s) or sets_numbers(s):
                continue
            handle = _STATEMENTS.get(type(s))
            if handle is not None:
                handle(self, s)
            for name in changed_by(s):
                if (use := self._use(ex.Named(name))) is not None:
                    use.assigned = True
            for e in expressions_of(s):  # whatever no rule looks into
                if type(e) is ex.Named:
                    self._use(e)
                elif type(e) is ex.NamedArgument and e.name in _SYSTEMS_READ:
                    self.see(e.value, _SYSTEMS_READ[e.name])

    def spread(self) -> None:
        """Names that are compared with or assigned to each other are of one type."""
        changed = True
        while changed:
            changed = False
            for left, right in self.links:
                one, other = self.uses[left].kinds, self.uses[right].kinds
                if one != other:
                    one |= other
                    other |= one
                    changed = True

    # --- names ------------------------------------------------------------------------------------------

    def _use(self, e: ex.Expression | None) -> Use | None:
        """What is known of a name that nothing declares, None for any other expression."""
        if type(e) is not ex.Named:
            return None
        found = self.uses.get(e.name)
        if found is not None and not self._is_own(e.name):
            return found
        symbol = self.symbols.find(self.routine.name, e.name)
        if symbol is not None and symbol.declared:
            return None
        return self.uses.setdefault(e.name, Use(e.name, self.statement))

    def _is_own(self, name: str) -> bool:
        return (self.routine.name, name) in self.symbols.table

    def _kind(self, e: ex.Expression | None) -> str:
        """What a value is by its own; a number that is written out tells little."""
        if type(e) is ex.Number:
            return ""
        if self._bare(e) is not None:
            return ""
        return kind_of_value(self.symbols, self.routine.name, e)

    def _bare(self, e: ex.Expression | None) -> Use | None:
        """The undeclared name that an expression is, or an element of."""
        return self._use(e.base) if type(e) is ex.Item else self._use(e)

    # --- expressions ------------------------------------------------------------------------------------

    def see(self, e: Any, kind: str = "") -> None:
        """An expression where a value of this kind is taken."""
        match e:
            case ex.Named():
                use = self._use(e)
                if use is not None:
                    use.whole = True
                    use.kinds |= {kind} - {""}
            case ex.Item(base, indices):
                self._item(base, indices, kind)
                self._whole_element(base)
            case ex.Member(base, name):
                self._member(base, name.casefold())
            case ex.Binary(operator, left, right):
                self._binary(operator, left, right, kind)
            case ex.Compare(_, left, right):
                self._same(left, right)
            case ex.Logic(first, rest):
                for part in (first, *(condition for _, condition in rest)):
                    self.see(part, "boolean")
            case ex.Unary(operator, operand):
                self.see(operand, "boolean" if operator == "not" else kind if kind in NUMERIC else "real")
            case ex.Function(name, arguments):
                for argument, kind in zip(arguments, taken(name, len(arguments)), strict=True):
                    self.see(argument, kind)
            case ex.Signal(_, index) | ex.FrameRef(_, index):
                self.see(index, "integer")
            case ex.CallValue(name, arguments):
                self._arguments(name, arguments)
            case ex.Quantity(written, _):
                self.see(written, "real")

    def _item(self, base: ex.Expression, indices: tuple[ex.Expression, ...], kind: str) -> None:
        for index in indices:
            self.see(index, "integer")
        use = self._use(base)
        if use is None:
            self.see(base)
            return
        largest = tuple(self._largest(index) for index in indices)
        use.indices.append(largest)
        use.kinds |= {kind} - {""}
        if any(self._largest(index) is None for index in indices):
            use.computed[self.statement.line] = self.statement

    def _whole_element(self, base: ex.Expression) -> None:
        use = self._use(base)
        if use is not None:
            use.copied = True

    def _largest(self, index: ex.Expression) -> int | None:
        """The largest value of an index that is written out, or that an open loop counts; None: not known here."""
        match index:
            case ex.Number(value):
                return int(value)
            case ex.Named(name):
                fixed = self.symbols.fixed_value(self.routine.name, index)
                if isinstance(fixed, ex.Number):
                    return int(fixed.value)
                return (self.counted.get(name) or [None])[-1]
            case ex.Binary("+" | "-" as operator, left, ex.Number(value)):
                largest = self._largest(left)
                return None if largest is None else largest + int(value if operator == "+" else -value)
        return None

    def _member(self, base: ex.Expression, name: str) -> None:
        kind = "position" if name in COMPONENTS else "joints" if name in AXES else ""
        use = None if kind else self._bare(base)
        if use is None:
            self.see(base, kind)
            return
        use.records.add(name)
        if type(base) is ex.Item:
            self._item(base.base, base.indices, "")

    def _binary(self, operator: str, left: ex.Expression, right: ex.Expression, kind: str) -> None:
        if operator in ("div", "mod"):
            inner = "integer"
        elif operator in ("and", "or", "xor"):
            inner = "integer" if kind in NUMERIC else "boolean"
        elif operator == "/":
            inner = "real"
        else:
            sides = {self._kind(left), self._kind(right)} - set(NUMERIC) - {""}
            inner = next(iter(sides)) if sides else kind if kind in ("integer", *PLACES, "string") else "real"
        self.see(left, inner)
        self.see(right, inner)

    def _same(self, left: ex.Expression, right: ex.Expression) -> None:
        """Two values that are compared, or one that is assigned to the other."""
        first, second = self._bare(left), self._bare(right)
        if first is not None and second is not None and first is not second:
            self.links.append((first.name, second.name))
        for one, other in ((left, right), (right, left)):
            self.see(one, "real" if type(other) is ex.Number else self._kind(other))

    def _arguments(self, routine: str, arguments: tuple[ex.Expression, ...]) -> None:
        called = self.symbols.routines.get(routine)
        if called is None:
            for argument in arguments:
                self.see(argument)
            return
        kinds = {p.name: p.type for p in called.parameters}
        counts = {p.name: len(p.sizes) for p in called.parameters}
        for name, value in paired(called.parameters, arguments):
            if counts.get(name) and (use := self._use(value)) is not None:
                use.indices.append((0,) * counts[name])  # it is handed over as an array
            self.see(value, kinds.get(name, "") if kinds.get(name, "") in KINDS else "")

    # --- statements -------------------------------------------------------------------------------------

    def _move(self, s: st.Move) -> None:
        for measured in (s.speed, s.blend, s.rate):
            if measured is not None and measured.value is not None:
                self.see(measured.value)
        if not calls_nothing(s):
            for quantity in (s.acceleration, s.deceleration, s.arc, s.turn):
                self.see(quantity)
            for pose in (s.via, s.offset, s.tool_offset):
                self.see(pose, "position")
            self.see(s.until, "boolean")
            for one in s.triggers:
                self._switched(one)
        kind = "position" if s.path is not st.Path.JOINT else self._joint_target(s)
        for target in s.targets:
            self.see(target, kind)
        self.see(s.tool, "tool")
        self.see(s.frame, "frame")

    def _joint_target(self, s: st.Move) -> str:
        """The instruction may say whether a joint move goes to axis values; the neutral move does not."""
        word = conventions_of(self.program.vendor).joint_target_word
        if not word:
            return TARGET
        return "joints" if word in self.program.source.line(s.line).casefold() else "position"

    def _for(self, s: st.For) -> None:
        self._same(s.variable, s.start)
        fraction = any(
            type(e) is ex.Number and not float(e.value).is_integer() for e in (s.start, s.stop, s.step)
        )
        for e in (s.variable, s.start, s.stop, s.step):
            self.see(e, "real" if fraction else "integer")
        name = s.variable.name if isinstance(s.variable, ex.Named) else ""
        bounds = [e.value for e in (s.start, s.stop) if type(e) is ex.Number]
        self.counted.setdefault(name, []).append(int(max(bounds)) if len(bounds) == 2 else None)
        self.loops.append(name)

    def _next(self, s: st.Statement) -> None:
        if self.loops:
            self.counted[self.loops.pop()].pop()

    def _assign(self, s: st.Assign) -> None:
        self._same(s.target, s.value)

    def _switch(self, s: st.Switch) -> None:
        cases = [value for one in self.routine.body if type(one) is st.Case for value in one.values]
        whole = all(type(value) is ex.Number and float(value.value).is_integer() for value in cases)
        self.see(s.value, "integer" if whole else self._kind(cases[0]))
        for value in cases:
            self.see(value)

    def _output(self, s: st.SetOutput) -> None:
        self._switched(s)

    def _switched(self, s: st.SetOutput | st.PathTrigger) -> None:
        kind = kind_of_value(self.symbols, self.routine.name, s.signal)
        self.see(s.signal)
        numeric = conventions_of(self.program.vendor).numeric_booleans
        self.see(s.value, "integer" if kind == "boolean" and numeric else kind)

    def _call(self, s: st.Call) -> None:
        self._arguments(s.routine, s.arguments)
        called = self.symbols.routines.get(s.routine)
        self.see(s.result, "" if called is None else called.returns)
        self.see(s.condition, "boolean")


_Handler = Callable[[_Seen, Any], None]


def _condition(seen: _Seen, s: Any) -> None:
    seen.see(s.condition, "boolean")


def _seeing(**kinds: str) -> _Handler:
    def handle(seen: _Seen, s: Any) -> None:
        for name, kind in kinds.items():
            seen.see(getattr(s, name), kind)

    return handle


def _read(seen: _Seen, s: st.ReadInput) -> None:
    seen.see(s.signal)
    seen.see(s.target, kind_of_value(seen.symbols, seen.routine.name, s.signal))


def _update(seen: _Seen, s: st.Update) -> None:
    if s.operand is not None:
        seen._same(s.target, s.operand)


def _define(seen: _Seen, s: st.DefineFrame) -> None:
    for point in s.points:
        seen.see(point, "position")


def _return(seen: _Seen, s: st.Return) -> None:
    seen.see(s.value, seen.routine.returns if seen.routine.returns in KINDS else "")


_STATEMENTS: Final[dict[type, _Handler]] = {
    st.Assign: _Seen._assign,
    st.Call: _Seen._call,
    st.DefineFrame: _define,
    st.Dwell: _seeing(duration="real"),
    st.ElseIf: _condition,
    st.For: _Seen._for,
    st.If: _condition,
    st.Jump: _condition,
    st.PulseOutput: _seeing(signal="", duration="real", condition="boolean"),
    st.ReadInput: _read,
    st.Return: _return,
    st.SetFrame: _seeing(frame="frame"),
    st.SetOutput: _Seen._output,
    st.SetTool: _seeing(tool="tool"),
    st.ShiftOn: _seeing(offset="position"),
    st.Switch: _Seen._switch,
    st.Until: _condition,
    st.Update: _update,
    st.Wait: _condition,
    st.While: _condition,
}
