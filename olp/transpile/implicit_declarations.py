"""Names that no file at hand declares: declared without a value, as what their uses take them for, and told.

What moves there, or runs with a tool or in a frame that only such a name tells, is no exact translation.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from typing import Final

from olp.ir.expressions import Expression, Member, Named, Number
from olp.ir.program import Assign, Call, Declare, For, Move, Program, Routine, Statement, Wait
from olp.ir.transformer import mapped, note_names
from olp.languages.vendor import conventions_of, language_of
from olp.transpile.constant_folding import called_in, paired
from olp.transpile.context import Fate, TranslationContext
from olp.transpile.name_types import COMPONENTS, PLACES, TARGET, Use
from olp.transpile.name_uses import uses_of
from olp.transpile.symbols import base_of

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
_ASKS: Final = {
    "taught": "teach what no file here declares, or copy its values",
    "set": "set what no file here declares",
}


def undeclared(program: Program, work: TranslationContext) -> Program:
    """Every name declared."""
    program = _counters(program)
    _tell_calls(program, work)
    unwaited = _unwaited(program)
    if unwaited:
        _refuse_own(program, unwaited, work)
        program = replace(program, data=tuple(d for d in program.data if d.name not in unwaited))
    uses = {name: use for name, use in uses_of(program, work).items() if name not in unwaited}
    if not uses:
        return program
    records = {name for name, use in uses.items() if use.records and not use.whole}
    if records:
        program = _flattened(program, records)
        uses = {name: use for name, use in uses_of(program, work).items() if name not in unwaited}
    own = {name for name in uses if name.startswith("$")}
    _refuse_own(program, own, work)
    uses = {name: use for name, use in uses.items() if name not in own}
    for use in uses.values():
        _tell(use, work)
    _tell_moves(program, uses, work)
    return replace(program, data=(*program.data, *map(_declaration, uses.values())))


def _counters(program: Program) -> Program:
    """Where FOR declares what it counts, that is no variable of the program."""
    if not conventions_of(program.vendor).for_declares:
        return program
    known = {d.name for d in program.data}
    routines = []
    for routine in program.routines:
        own = (
            known
            | {p.name for p in routine.parameters}
            | {s.name for s in routine.body if type(s) is Declare}
        )
        counted = {s.variable.name: s for s in routine.body if type(s) is For and type(s.variable) is Named}
        rows = [
            Declare(0, name, "real" if _has_fraction(s) else "integer")
            for name, s in counted.items()
            if name not in own
        ]
        routines.append(replace(routine, body=(*rows, *routine.body)) if rows else routine)
    return replace(program, routines=tuple(routines))


def _has_fraction(s: For) -> bool:
    return any(type(e) is Number and not float(e.value).is_integer() for e in (s.start, s.stop, s.step))


def _flattened(program: Program, records: set[str]) -> Program:
    """Members of structures whose layout nobody knows (RAPID's vFast.v_tcp) as variables of their own."""

    def change(e: Expression) -> Expression:
        if (
            type(e) is Member
            and type(e.base) is Named
            and e.base.name in records
            and e.name not in COMPONENTS
        ):
            return Named(f"{e.base.name}_{e.name}")
        return e

    routines = tuple(replace(r, body=tuple([mapped(s, change) for s in r.body])) for r in program.routines)
    return replace(program, routines=routines)


def _unwaited(program: Program) -> set[str]:
    """The limit of waits, where no wait here has it: it would hold for programs that are not at hand."""
    prefix = conventions_of(program.vendor).wait_limit_prefix
    if not prefix:
        return set()
    found = {d.name for d in program.data if d.name.startswith(prefix)}
    for s in program.statements() if found else ():
        if isinstance(s, Wait):
            found -= _names(s)
    return found


def _refuse_own(program: Program, names: set[str], work: TranslationContext) -> None:
    """What names a variable of the controller (KRL's $MODE_OP): as a program's own variable it would mean nothing."""
    for s in program.statements() if names else ():
        found = sorted(_names(s) & names)
        if found:
            own, other = language_of(program.vendor), language_of(work.target)
            says = f"{found[0]} belongs to {own}'s controllers, those of {other} have none"
            work.lose(s, Fate.REFUSED, "name", says)


def _tell_calls(program: Program, work: TranslationContext) -> None:
    """Routines that no file at hand has, one line for each: the translation calls what nobody has translated."""
    known = {routine.name.casefold() for routine in program.routines}
    known |= {name.casefold() for name in work.context.mapping.routines}
    called = [(s, name) for r in program.routines for _, s in work.look(r).rare for name in called_in(s)]
    for s, name in called:
        if name and name.casefold() not in known:
            known.add(name.casefold())
            says = f"{name} is in no file here: {language_of(work.target)} needs a routine of its own for it"
            work.lose(s, Fate.APPROXIMATED, "call", says)


def _declaration(use: Use) -> Declare:
    storage = "persistent" if use.kind in PLACES else "variable"
    sizes = tuple(Number(size) for size in use.sizes)
    return Declare(
        0, use.name, use.kind, None, sizes, storage, shared=True, comment="not declared in the source"
    )


def _tell(use: Use, work: TranslationContext) -> None:
    """One line for each name, at its first use."""
    kind = _WORDS[use.kind] if use.kinds else "a number, for nothing tells its type"
    if TARGET in use.kinds and use.kind == "position":
        kind = "a Cartesian position, which it may not be"
    verb = "taught" if use.kind in PLACES else "set"
    says = f"{use.name} is not declared here: taken for {kind}"
    if use.indices and use.sizes:
        size = "x".join(str(size) for size in use.sizes)
        says += f", {size} of them"
    work.lose(use.first, Fate.APPROXIMATED, "name", f"{says}; its value has to be {verb}")
    work.ask(_ASKS[verb], use.name)
    for line in sorted(use.computed) if use.sizes and (work.limits.numbered or not all(use.sizes)) else ():
        says = f"{use.name} is not declared here, and nothing tells how many elements it has"
        work.lose(line, Fate.REFUSED, "index", says)


def _tell_moves(program: Program, uses: dict[str, Use], work: TranslationContext) -> None:
    """Every move that depends on such a name, or on a position that is computed from one."""
    origin = {name: name for name in uses}
    places = {name for name, use in uses.items() if use.kind in PLACES}
    _spread(program, origin, places)
    told = {(use.first.line, use.name) for use in uses.values()}
    for s in program.statements():
        if type(s) is not Move and type(s) is not Assign:
            continue
        for name in sorted({origin[n] for n in _names(s) if n in (origin if type(s) is Move else places)}):
            if (s.line, name) not in told:
                told.add((s.line, name))
                work.lose(s, Fate.APPROXIMATED, "name", f"it depends on {name}, which is not declared here")


def _spread(program: Program, origin: dict[str, str], places: set[str]) -> None:
    """Adds the variables and parameters that positions of undeclared names are handed to."""
    by_name = {routine.name.casefold(): routine for routine in program.routines}
    handed: list[tuple[str, Iterable[str]]] = []
    for s in program.statements():
        if type(s) is Assign and (base := base_of(s.target)) is not None:
            handed.append((base.name, sorted(_names(s.value))))
        elif type(s) is Call and s.routine.casefold() in by_name:
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


def _arguments(called: Routine, s: Call) -> list[tuple[str, Iterable[str]]]:
    given = paired(called.parameters, s.arguments)
    return [(name, sorted(_names(value))) for name, value in given if value is not None]


def _names(node: Statement | Expression) -> set[str]:
    found: set[str] = set()
    note_names(node, found)
    return found
