"""Names that the target takes: letters, length, its own words, and no two that it reads as one."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Final

from olp.ir.expressions import CallValue, Expression, Named, NamedArgument, PositionLiteral
from olp.ir.program import Call, Declare, Jump, Label, Move, Program, Routine, StartTask, Statement, WaitTask
from olp.ir.transformer import expressions_of, mapped
from olp.languages.vendor import find_vendor, vendor_names
from olp.transpile.context import Fate, TranslationContext
from olp.transpile.occurrences import with_routines, with_rows

_LETTERS: Final = str.maketrans(
    {
        "ä": "ae",
        "ö": "oe",
        "ü": "ue",
        "Ä": "Ae",
        "Ö": "Oe",
        "Ü": "Ue",
        "ß": "ss",
        "é": "e",
        "è": "e",
        "à": "a",
    }
)


def names(program: Program, work: TranslationContext) -> Program:
    """Every routine, variable and label with a name that the target takes; what changed is in the mapping."""
    own = _Names(work, frozenset(p.name.casefold() for r in program.routines for p in r.parameters))
    start = work.limits.started.casefold()
    first = program.main or (program.routines[0].name if program.routines else "")
    if start and first.casefold() != start:
        own.taken["name"] = {start}  # the controller would start there
    for routine in program.routines:
        own.name("routine", routine.name)
    if not work.limits.numbered:
        _note_all(program, own)
    routines = tuple(own.routine(routine) for routine in program.routines)
    data = tuple(own.declare(declare) for declare in program.data)
    main = own.name("routine", program.main) if program.main else ""
    work.registers = {own.known.get(("variable", name), name) for name in work.registers}
    return replace(program, routines=routines, data=data, main=main)


def spelling(program: Program, work: TranslationContext) -> Program:
    """Calls and jumps spelt as the routines and labels that they name, where the source's language reads both as one.

    What only differs in case is one thing there, and may be two in the target.
    """
    if program.vendor not in vendor_names() or find_vendor(program.vendor).case_sensitive:
        return program
    declared = {routine.name.casefold(): routine.name for routine in reversed(program.routines)}

    def change(e: Expression) -> Expression:
        name = declared.get(e.routine.casefold(), e.routine) if type(e) is CallValue else ""
        return replace(e, routine=name) if type(e) is CallValue and name != e.routine else e

    routines = []
    for routine in program.routines:
        look = work.look(routine)
        labels = {s.name.casefold(): s.name for _, s in look.rare if isinstance(s, Label)}
        rows = list(routine.body)
        for at, s in look.rare:
            if any(type(e) is CallValue for e in expressions_of(s)):
                rows[at] = s = mapped(s, change)
            if isinstance(s, (Call, StartTask)):
                rows[at] = replace(s, routine=declared.get(s.routine.casefold(), s.routine))
            elif isinstance(s, Jump) and isinstance(s.target, str):
                rows[at] = replace(s, target=labels.get(s.target.casefold(), s.target))
        routines.append(with_rows(routine, rows))
    main = declared.get(program.main.casefold(), program.main)
    return replace(with_routines(program, routines), main=main)


def _note_all(program: Program, own: _Names) -> None:
    for declare in program.data:
        own.name("variable", declare.name)
    for routine in program.routines:
        for parameter in routine.parameters:
            own.name("variable", parameter.name)


@dataclass(slots=True)
class _Names:
    work: TranslationContext
    parameters: frozenset[str] = frozenset()  # of the program's routines, case folded
    known: dict[tuple[str, str], str] = field(default_factory=dict)
    taken: dict[str, set[str]] = field(default_factory=dict)
    same: set[str] = field(default_factory=set)  # variables that are called as they were
    legal: re.Pattern[str] = field(init=False)

    def __post_init__(self) -> None:
        self.legal = re.compile(self.work.limits.names)

    def name(self, kind: str, name: str, scope: str = "") -> str:
        """What `name` is called in the target."""
        key = (f"{kind} {scope}" if scope else kind, name)
        found = self.known.get(key)
        if found is None:
            found = self.known[key] = self._legal(kind, name, scope)
            if found != name:
                self.work.names.setdefault((kind, name), found)
        return found

    def _legal(self, kind: str, name: str, scope: str) -> str:
        limits = self.work.limits
        wanted = self._wanted(kind).get(name)
        text = wanted or (name if name.isascii() else name.translate(_LETTERS))
        if wanted is None and not self.legal.fullmatch(text):
            text = re.sub(r"[^A-Za-z0-9_]", "_", text) or "n"
            if not self.legal.fullmatch(text):
                text = f"n_{text}" if self.legal.fullmatch(f"n_{text}") else f"n{text.strip('_')}"
        if text.upper() in limits.reserved:
            text = f"{text}_1"
        longest = limits.variable_name
        if kind != "variable":
            longest = limits.routine_name if kind == "routine" else limits.label_name
        # Routines and variables share one room in most languages.
        place = f"label {scope}" if kind == "label" else "name"
        room = self.taken.get(place)
        if room is None:
            room = self.taken[place] = set()
        return self._unique(text[:longest] if longest else text, longest, room)

    def _unique(self, text: str, longest: int, room: set[str]) -> str:
        count, name, exact = 1, text, self.work.limits.case_sensitive
        seen = name if exact else name.casefold()
        while seen in room:
            count += 1
            tail = f"_{count}"
            name = (text[: longest - len(tail)] if longest else text) + tail
            seen = name if exact else name.casefold()
        room.add(seen)
        return name

    def _wanted(self, kind: str) -> Mapping[str, str]:
        mapping = self.work.context.mapping
        if kind == "variable":
            return mapping.variables
        return mapping.routines if kind == "routine" else {}

    # --- the program ------------------------------------------------------------------------------------

    def routine(self, routine: Routine) -> Routine:
        body = tuple([self._statement(s, routine.name) for s in routine.body])
        parameters = tuple(replace(p, name=self.name("variable", p.name)) for p in routine.parameters)
        data = tuple(self.declare(declare) for declare in routine.data)
        return replace(
            routine, name=self.name("routine", routine.name), body=body, parameters=parameters, data=data
        )

    def declare(self, s: Declare) -> Declare:
        plain = type(s.value) is PositionLiteral and not s.sizes
        changed, name = s if plain else mapped(s, self._change), self.name("variable", s.name)
        return changed if name == s.name else replace(changed, name=name)

    def _statement(self, s: Statement, scope: str) -> Statement:
        kind = type(s)
        if kind is Move:
            return mapped(s, self._change)
        if kind is Label or kind is Jump:
            return self._jump(s, scope)
        if isinstance(s, Declare):
            return self.declare(s)
        s = mapped(s, self._change)
        if isinstance(s, (Call, StartTask)) and s.routine:
            return replace(s, routine=self.name("routine", s.routine))
        return s

    def _jump(self, s: Statement, scope: str) -> Statement:
        if isinstance(s, Label):
            return replace(s, name=self.name("label", s.name, scope))
        assert isinstance(s, Jump)
        s = mapped(s, self._change)
        return replace(s, target=self.name("label", s.target, scope)) if isinstance(s.target, str) else s

    def _change(self, e: Expression) -> Expression:
        if type(e) is Named:
            if e.name in self.same:
                return e
            new = self.name("variable", e.name)
            if new != e.name:
                return Named(new)
            self.same.add(new)
            return e
        if type(e) is CallValue:
            return replace(e, routine=self.name("routine", e.routine))
        if type(e) is NamedArgument and e.name.rstrip("?").casefold() in self.parameters:
            return replace(e, name=self.name("variable", e.name))
        return e


# --- Tasks ---
# Parallel tasks by their numbers, where the target has no names for them.


def tasks(program: Program, work: TranslationContext) -> Program:
    """Every task that has a name by a number, in the order of their starts."""
    most, spelt = work.limits.tasks, work.limits.task_name
    if not most:
        return program
    own = re.compile(re.escape(spelt).replace(r"\{\}", r"\d+") + r"\Z")
    started = dict.fromkeys(s.task for s in program.statements() if isinstance(s, StartTask) and s.task)
    named = [name for name in started if not own.match(name)]
    if not named:
        return program
    taken = {name for name in started if own.match(name)}
    free = [name for n in range(1, most + 1) if (name := spelt.format(n)) not in taken]
    numbers = dict(zip(named, free, strict=False))
    work.names.update({("task", name): number for name, number in numbers.items()})

    def numbered(s: Statement) -> Statement:
        if not isinstance(s, (StartTask, WaitTask)) or s.task not in started or own.match(s.task):
            return s
        if s.task not in numbers:
            work.lose(s, Fate.REFUSED, "statement", f"more than {most} parallel tasks")
            return s
        return replace(s, task=numbers[s.task])

    routines = tuple(replace(r, body=tuple(map(numbered, r.body))) for r in program.routines)
    return replace(program, routines=routines)
