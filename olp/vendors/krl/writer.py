"""Writes programs as KRL: what `templates/krl.j2` puts together.

Codes: X002 what KRL cannot say.
"""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import PureWindowsPath

from olp.diagnostic import Diagnostic, Span, error
from olp.program import (
    Declare,
    Move,
    Program,
    Routine,
)
from olp.vendors.krl import write_data
from olp.vendors.krl.neighbours import CONFIG_MARK
from olp.vendors.krl.scope import Scope
from olp.vendors.krl.write_data import is_of_config
from olp.vendors.krl.write_routine import HEADER, TYPES, RoutineWriter, as_text
from olp.vendors.krl.write_values import CannotSayError, Words


def write(program: Program, date: str, pair: bool = False) -> tuple[dict[str, object], list[Diagnostic]]:
    """The values for the template, and everything that KRL cannot say. KRL programs hold no `date`.

    `pair`: data go into a list beside the program, "companions" {".dat": text}; else they are declared in the one
    routine that uses them, and what several routines share stands in a list behind the program.
    """
    del date
    writer = _Writer(program, pair)
    return writer.values(), writer.problems


class _Writer:
    def __init__(self, program: Program, pair: bool) -> None:
        self.program = program
        self.own = program.vendor == "krl"
        self.problems: list[Diagnostic] = []
        self.pair = pair
        self.scope = _scope_of(program)
        main = program.main
        ordered = sorted(program.routines, key=lambda one: bool(main) and one.name != main)
        self.routines = list(program.routines) if self.own else ordered
        strings = {one.name for one in _all_data(program) if one.type == "string"}
        strings |= {p.name for routine in program.routines for p in routine.parameters if p.type == "string"}
        self.words = Words(self.scope, self.own, frozenset() if self.own else frozenset(strings))

    def begins(self, routine: Routine) -> bool:
        """Whether a program of another language starts with this routine, and moves: KRL's own says itself how."""
        first = self.program.main or self.routines[0].name
        return (
            not self.own and routine.name == first and any(type(s) is Move for s in self.program.statements())
        )

    def values(self) -> dict[str, object]:
        local, shared = self._places()
        first = self.routines[0] if self.routines else None
        texts = tuple(
            RoutineWriter(self, one, local.get(one.name, ()), one is first).text() for one in self._programs()
        )
        list_text = self._list(shared)
        values: dict[str, object] = {"routines": texts, "list": "" if self.pair else list_text}
        if self.pair and list_text:
            values["companions"] = {".dat": list_text}
        return values

    def _programs(self) -> list[Routine]:
        return [one for one in self.routines if "list" not in one.details or not self.own]

    def _places(self) -> tuple[dict[str, tuple[Declare, ...]], list[Declare]]:
        """(data declared in a routine, by its name; data of the list)."""
        rows = [one for one in self.program.data if not is_of_config(one)]
        rows += [one for routine in self.routines for one in routine.data]
        if self.pair or self.own:
            return {}, rows
        local: dict[str, tuple[Declare, ...]] = {}
        shared: list[Declare] = []
        users = _users(self.program)
        first = self.routines[0].name if self.routines else ""
        for one in rows:
            names, assigned = users.get(one.name, (set(), False))
            if len(names) == 1 and (not assigned or names == {first}):
                local[next(iter(names))] = (*local.get(next(iter(names)), ()), one)
            else:
                shared.append(one)
        return local, shared

    def _list(self, rows: list[Declare]) -> str:
        lists = [one for one in self.routines if "list" in one.details] if self.own else []
        details = next((one.details for one in self.routines if "data head" in one.details and self.own), {})
        alone = not self.routines  # data that other programs use
        if not rows and not lists and not details and not alone:
            return ""
        owner = lists[0] if lists else None
        stem = (
            PureWindowsPath(self.program.path.replace("/", "\\")).stem
            if self.own and self.program.path
            else ""
        )
        name = owner.name if owner else (self.program.main or stem or self._first_name())
        above = owner.details.get("above", "") if owner else details.get("data above", "")
        public = " PUBLIC" if alone or (owner is not None and owner.details["list"] == "PUBLIC") else ""
        head = [details.get("data head", f"DEFDAT {name}{public}")]
        if "data rows" in details:
            head.append(details["data rows"])
        written: list[str] = []
        for one in rows:
            try:
                written += write_data.rows(self.words, [one], alone)
            except CannotSayError as problem:
                self.lose(problem, one.line)
        return (above + "\n" if above else "" if self.own else HEADER) + as_text([*head, *written, "ENDDAT"])

    def _first_name(self) -> str:
        return self.routines[0].name if self.routines else "PROGRAM"

    def lose(self, problem: CannotSayError, line: int) -> None:
        text = self.program.source.line(line)
        span = Span(line, len(text) - len(text.lstrip()) + 1, len(text.rstrip()) + 1)
        message = f"KRL cannot say this: {problem}"
        self.problems.append(
            error("X002", message, span, file=self.program.path, source_line=text, help=problem.help)
        )


def _all_data(program: Program) -> Iterable[Declare]:
    yield from program.data
    for routine in program.routines:
        yield from routine.data
        yield from (one for one in routine.body if isinstance(one, Declare))


def _scope_of(program: Program) -> Scope:
    """Types and values of all data, as the reader would know them."""
    scope = Scope()
    for one in _all_data(program):
        native = one.native.removesuffix(CONFIG_MARK) if program.vendor == "krl" else ""
        scope.declare(one.name, native or TYPES.get(one.type, one.type.upper()), bool(one.sizes))
        if one.native == "STRUC":
            members = getattr(one.value, "members", ())
            scope.structures[one.name.upper()] = {name.upper(): it.type for name, it in members}
    for one in (*program.data, *(one for routine in program.routines for one in routine.data)):
        if one.value is not None:
            scope.values[one.name.upper()] = one.value
    for routine in program.routines:
        for given in routine.parameters:
            word = given.native.removesuffix("[]") if program.vendor == "krl" else ""
            scope.declare(given.name, word or TYPES.get(given.type, ""), given.native.endswith("[]"))
    return scope


def _users(program: Program) -> dict[str, tuple[set[str], bool]]:
    """Name -> (the routines that use it, whether one of them assigns it)."""
    from olp.vendors.krl.naming import names_in

    found: dict[str, tuple[set[str], bool]] = {}
    for routine in program.routines:
        for one in routine.body:
            for name, assigned in names_in(one):
                names, before = found.get(name, (set(), False))
                found[name] = (names | {routine.name}, before or assigned)
    return found
