"""Outputs that switch on the way of a move, at the nearer of its ends: other languages lack RAPID's TriggIO.

A trigger is data. Which one it is has to be known from the text: one instruction sets it, and nothing else names it.
"""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import dataclass, field, replace
from operator import itemgetter
from typing import Final

from olp.ir import terminology
from olp.ir.expressions import Expression, Named, Number, Signal, SignalState, Text
from olp.ir.program import Comment, Declare, Move, Process, Program, Routine, SetOutput, Statement
from olp.ir.transformer import expressions_of
from olp.transpile.context import Fate, TranslationContext
from olp.transpile.occurrences import with_routines, with_rows

_SET: Final = "triggdata"  # the argument of an instruction that names the trigger which it sets
_MOVES: Final = re.compile(r"trigg[ljc]", re.IGNORECASE)
_FURTHER: Final = re.compile(r"\\t[2-8]", re.IGNORECASE)
_SAID: Final = "what it says stands at the moves that name it"


def triggers(program: Program, work: TranslationContext) -> Program:
    """Every move with known triggers as a move, with what they switch before and behind it."""
    if not any(type(s) is Process and _of(s) for r in program.routines for _, s in work.look(r).rare):
        return program
    own = _Triggers(work, program)
    routines = [with_rows(r, [row for s in r.body for row in own.rows(s, r)]) for r in program.routines]
    routines = [with_rows(r, [own.said(s, r) for s in r.body]) for r in routines]
    return with_routines(program, routines)


def _of(s: Process) -> str:
    """The trigger that an instruction sets, "" for any other one."""
    name = dict(s.arguments).get(_SET)
    return name.name if isinstance(name, Named) else ""


def _is_at_start(one: Process) -> bool:
    return dict(one.arguments)["start"] == SignalState(True)


def _distance(one: Process) -> tuple[str, Expression]:
    """How far from the end, or the start, of the move a trigger acts: unit and number."""
    given = dict(one.arguments)
    return ("s", given["s"]) if "s" in given else ("mm", given["mm"])


def _in_order(several: Iterable[Process], at_start: bool) -> list[Process] | None:
    """In the order in which they act, None where the text does not tell it."""
    found = [one for one in several if _is_at_start(one) is at_start]
    far = [_distance(one) for one in found]
    numbers = [e.value for _, e in far if isinstance(e, Number)]
    if len(found) > 1 and (len(numbers) < len(far) or len({unit for unit, _ in far}) > 1):
        return None
    ways = [way if at_start else -way for way in numbers] if len(found) > 1 else [0.0] * len(found)
    return [one for _, one in sorted(zip(ways, found, strict=True), key=itemgetter(0))]


@dataclass(slots=True)
class _Triggers:
    """`shown`: (routine or "", name) of those whose moves are written with what they switch."""

    work: TranslationContext
    program: Program
    shown: set[tuple[str, str]] = field(default_factory=set)
    refused: set[tuple[str, str]] = field(default_factory=set)
    known: dict[tuple[str, str], Process | None] = field(default_factory=dict)

    def rows(self, s: Statement, routine: Routine) -> list[Statement]:
        if type(s) is not Move or not s.other or not _MOVES.fullmatch(s.other[0][0]):
            return [s]
        named = [e for tag, e in s.other[1:] if not tag or _FURTHER.fullmatch(tag)]
        keys = [self._key(e.name, routine) for e in named if isinstance(e, Named)]
        found = [self._setting(key) for key in keys]
        set_by = [one for one in found if one is not None]
        starts, ends = _in_order(set_by, True), _in_order(set_by, False)
        if len(set_by) < len(named) or starts is None or ends is None:
            self.refused.update(keys)
            return [s]
        self.shown.update(keys)
        kept = tuple((tag, e) for tag, e in s.other[1:] if tag and not _FURTHER.fullmatch(tag))
        return [
            *[self._output(s, one) for one in starts],
            replace(s, other=kept),
            *[self._output(s, one) for one in ends],
        ]

    def said(self, s: Statement, routine: Routine) -> Statement:
        """The instruction that sets a trigger as a comment, where all moves with this one could be written."""
        if type(s) is not Process or not (name := _of(s)):
            return s
        key = self._key(name, routine)
        if key not in self.shown or key in self.refused:
            return s
        self.work.lose(s, Fate.APPROXIMATED, "statement", _SAID)
        return Comment(s.line, self.work.source.source.line(s.line).strip().rstrip(";"))

    def _output(self, s: Move, one: Process) -> SetOutput:
        """What a trigger of a move switches, and where it should."""
        signal, value = dict(one.arguments)["signal"], dict(one.arguments)["value"]
        assert isinstance(signal, Signal)
        unit, far = _distance(one)
        size = s.blend.value.literal if s.blend is not None and s.blend.value is not None else None
        if _is_at_start(one) or size != 0.0 or far != Number(0):
            place, way = ("start", "behind") if _is_at_start(one) else ("end", "before")
            length = f"{far.value:g} {unit}" if isinstance(far, Number) else f"a computed number of {unit}"
            name = terminology.signal(signal)[0]
            says = f"{name} switches at the {place} of the move, not {length} {way} it"
            self.work.lose(s, Fate.APPROXIMATED, "order", says)
        return SetOutput(s.line, signal, value)

    def _key(self, name: str, routine: Routine) -> tuple[str, str]:
        own = {d.name for d in routine.data} | {p.name for p in routine.parameters}
        own |= {one.name for one in routine.body if isinstance(one, Declare)}
        return (routine.name if name in own else "", name)

    def _setting(self, key: tuple[str, str]) -> Process | None:
        """The one instruction that sets a trigger to what is written out, None where something else may, too."""
        if key not in self.known:
            self.known[key] = self._found(*key)
        return self.known[key]

    def _found(self, scope: str, name: str) -> Process | None:
        found: Process | None = None
        word = re.compile(rf"(?<!\w){re.escape(name)}(?!\w)", re.IGNORECASE)
        for routine in self.program.routines:
            if self._key(name, routine)[0] != scope or (scope and routine.name != scope):
                continue
            if name in {p.name for p in routine.parameters}:
                return None
            for _, s in self.work.look(routine).rare:
                if isinstance(s, Declare) or (
                    type(s) is Move and s.other and _MOVES.fullmatch(s.other[0][0])
                ):
                    continue
                if type(s) is Process and _of(s) == name:
                    if found is not None or not isinstance(dict(s.arguments)["value"], (Number, SignalState)):
                        return None
                    found = s
                elif any(
                    e == Named(name) or (type(e) is Text and word.search(e.value)) for e in expressions_of(s)
                ):
                    return None
        return found
