"""Counters that the language declares with their FOR loop (RAPID), as variables of the routine.

Such a counter hides a variable of the same name, which holds after the loop what it held before.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import replace

from olp.ir.block_structure import Block, Node, parse
from olp.ir.expressions import Expression, Function, Named, Number
from olp.ir.program import Declare, For, Next, Program, Routine, Statement
from olp.ir.transformer import mapped, note_names
from olp.languages.vendor import conventions_of, language_of
from olp.transpile.context import Fate, TranslationContext
from olp.transpile.occurrences import with_routines, with_rows


def loop_counters(program: Program, work: TranslationContext) -> Program:
    """Every counter declared in its routine, under another name where it hides a variable that is used there."""
    if not conventions_of(program.vendor).for_declares:
        return program
    if conventions_of(program.vendor).for_turns:
        program = _with_steps(program, work)
    shared = {d.name for d in program.data}
    routines = tuple(_counted(routine, shared, work) for routine in program.routines)
    return replace(program, routines=routines)


def _with_steps(program: Program, work: TranslationContext) -> Program:
    """Loops that count down without saying so, with a step; told where nobody knows which way one counts."""
    symbols = work.symbols(program)

    def stepped(s: Statement, routine: str) -> Statement:
        if type(s) is not For or s.step is not None:
            return s
        start, stop = (symbols.fixed_value(routine, e) for e in (s.start, s.stop))
        if type(start) is Number and type(stop) is Number:
            return s if start.value <= stop.value else replace(s, step=Number(-1))
        if start == Number(1) and type(s.stop) is Function and s.stop.name == "size-of-array":
            return s
        language = language_of(program.vendor)
        says = f"where it ends below its begin {language} counts down: there the loop is passed over"
        work.lose(s, Fate.APPROXIMATED, "step", says)
        return s

    routines = (with_rows(r, [stepped(s, r.name) for s in r.body]) for r in program.routines)
    return with_routines(program, routines)


def _counted(routine: Routine, shared: set[str], work: TranslationContext) -> Routine:
    counters = {s.variable.name: s for s in routine.body if type(s) is For and type(s.variable) is Named}
    nodes = parse(routine.body) if counters else None
    if nodes is None:
        return routine
    given = {p.name for p in routine.parameters} | {d.name for d in routine.data}
    declared = {s.name for s in routine.body if type(s) is Declare}
    outside: set[str] = set()
    _note_outside(nodes, frozenset(), outside)
    hidden = {
        name: work.helper(name)
        for name in counters
        if name in given
        or (name in outside and name in declared)
        or (name in shared and name not in declared)
    }
    free = counters.keys() - hidden.keys()  # of a variable that does nothing else the name is left
    body = [s for s in _renamed(nodes, hidden) if not (type(s) is Declare and s.name in free)]
    rows = [
        Declare(0, hidden.get(name, name), "real" if _has_fraction(s) else "integer")
        for name, s in counters.items()
    ]
    return replace(routine, body=(*rows, *body))


def _note_outside(nodes: Iterable[Node], counted: frozenset[str], found: set[str]) -> None:
    """Names that statements use outside of the loops that count them."""
    for node in nodes:
        if not isinstance(node, Block):
            if type(node) is not Declare:
                _note(node, counted, found)
            continue
        for marker, inside in node.branches:
            if type(marker) is For and type(marker.variable) is Named:
                for bound in (marker.start, marker.stop, marker.step):
                    _note(bound, counted, found)
                _note_outside(inside, counted | {marker.variable.name}, found)
            else:
                _note(marker, counted, found)
                _note_outside(inside, counted, found)
        if type(node.closer) is not Next:
            _note(node.closer, counted, found)


def _note(part: Statement | Expression | None, counted: frozenset[str], found: set[str]) -> None:
    if part is not None:
        names: set[str] = set()
        note_names(part, names)
        found |= names - counted


def _renamed(nodes: Iterable[Node], hidden: Mapping[str, str]) -> Iterable[Statement]:
    """The statements, with the names of `hidden` counters changed within their loops."""
    for node in nodes:
        if not isinstance(node, Block):
            yield node
            continue
        opener = node.branches[0][0]
        if type(opener) is For and type(opener.variable) is Named and opener.variable.name in hidden:
            yield from _loop(node, opener, opener.variable.name, hidden)
            continue
        for marker, inside in node.branches:
            yield marker
            yield from _renamed(inside, hidden)
        yield node.closer


def _loop(node: Block, opener: For, name: str, hidden: Mapping[str, str]) -> Iterable[Statement]:
    def change(e: Expression) -> Expression:
        return Named(hidden[name]) if type(e) is Named and e.name == name else e

    yield replace(opener, variable=Named(hidden[name]))
    for s in _renamed(node.branches[0][1], hidden):
        yield mapped(s, change)
    yield mapped(node.closer, change)


def _has_fraction(s: For) -> bool:
    return any(type(e) is Number and not float(e.value).is_integer() for e in (s.start, s.stop, s.step))
