"""Variables that an instruction sets which olp keeps as written: RAPID's `TPReadNum answer,"Which row?"`.

No more is known of it than its text. Where it becomes a comment, what it names is no constant all the same: the person
who puts another instruction in its place sets it.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from dataclasses import replace
from typing import Final

from olp.ir.expressions import Named, Number, SignalState, Text
from olp.ir.program import Assign, Begin, Declare, Process, Program, Routine, Statement
from olp.ir.transformer import calls_nothing, note_names
from olp.transpile.context import Fate, TranslationContext

_QUOTED: Final = re.compile(r'"[^"]*"')
_WORD: Final = re.compile(r"[A-Za-z_]\w*")


def set_elsewhere(program: Program, lost: Iterable[Statement], work: TranslationContext) -> Program:
    """The program that has lost these instructions: what they name begins by an assignment, its users are told."""
    lines: dict[str, int] = {}
    for s in lost:
        for word in _words(s) if isinstance(s, Process) else ():
            lines.setdefault(word, s.line)
    if not lines:
        return program
    main = program.main or program.routines[0].name
    shared = {d.name: d for d in program.data}
    routines = []
    for r in program.routines:
        local = {s.name: s for s in r.body if isinstance(s, Declare)}
        given = _given({**shared, **local}, lines)
        _tell(program, r, given, work)
        begun = [d for d in given if d.name in local or r.name == main]
        routines.append(_begun(r, begun) if begun else r)
    return replace(program, routines=tuple(routines))


def _words(s: Process) -> set[str]:
    texts = [value.value for _, value in s.arguments if isinstance(value, Text)]
    return {word.casefold() for text in texts for word in _WORD.findall(_QUOTED.sub("", text))}


def _given(declared: Mapping[str, Declare], lines: Mapping[str, int]) -> dict[Declare, int]:
    """The variables that lost instructions name, each with the line of the first one."""
    return {
        d: lines[name.casefold()]
        for name, d in declared.items()
        if name.casefold() in lines
        and d.storage == "variable"
        and isinstance(d.value, (Number, SignalState, Text))
    }


def _begun(r: Routine, given: Iterable[Declare]) -> Routine:
    at = next((n for n, s in enumerate(r.body) if not isinstance(s, (Begin, Declare))), len(r.body))
    rows = [Assign(d.line, Named(d.name), d.value) for d in given if d.value is not None]
    return replace(r, body=(*r.body[:at], *rows, *r.body[at:]))


def _tell(program: Program, r: Routine, given: Mapping[Declare, int], work: TranslationContext) -> None:
    lines = {d.name: line for d, line in given.items()}
    for s in r.body if lines else ():
        if calls_nothing(s) or isinstance(s, Declare):
            continue
        names: set[str] = set()
        note_names(s, names)
        for name in sorted(names & lines.keys()):
            setting = program.source.line(lines[name]).strip()
            says = f"it needs {name}, which '{setting}' sets in a way that the target cannot"
            work.lose(s, Fate.APPROXIMATED, "value", says)
