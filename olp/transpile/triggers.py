"""Outputs that switch while a move is under way: as the target says it, or at the nearer end of the move.

RAPID's TriggIO sets data which moves name. What it holds has to be known from the text: one instruction sets it, and
nothing else names it.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field, replace
from typing import Final

from olp.core.units import mm, ms
from olp.ir import program as st
from olp.ir import terminology
from olp.ir.expressions import Named, Number, Quantity, SignalState, Text
from olp.ir.transformer import expressions_of
from olp.runtime.moves import in_order, trigger_of
from olp.transpile.context import Fate, TranslationContext
from olp.transpile.occurrences import with_routines, with_rows

_SET: Final = "triggdata"  # the argument of an instruction that names the trigger which it sets
_MOVES: Final = re.compile(r"trigg[ljc]", re.IGNORECASE)
_FURTHER: Final = re.compile(r"\\t[2-8]", re.IGNORECASE)
_SAID: Final = "its output and its distance or time are written with the moves that use it"
_CORNER: Final = "in a corner each controller measures from its own end of the move"
_CURVED: Final = "the path is curved: one controller may measure along it, another straight to the end"


def triggers(program: st.Program, work: TranslationContext) -> st.Program:
    """Moves get what their known triggers switch, and where, as their own `triggers`."""
    if not any(type(s) is st.Process and _of(s) for r in program.routines for _, s in work.look(r).rare):
        return program
    own = _Triggers(work, program)
    routines = [with_rows(r, [row for s in r.body for row in own.rows(s, r)]) for r in program.routines]
    routines = [with_rows(r, [own.said(s, r) for s in r.body]) for r in routines]
    return with_routines(program, routines)


def on_the_way(program: st.Program, work: TranslationContext) -> st.Program:
    """Triggers of moves as the target has them; where it has none, statements before and behind the move."""
    if not any(type(s) is st.Move and s.triggers for s in program.statements()):
        return program
    routines = [
        with_rows(r, [row for s in r.body for row in _said(s, work)]) if r.body else r
        for r in program.routines
    ]
    return with_routines(program, routines)


def _said(s: st.Statement, work: TranslationContext) -> list[st.Statement]:
    if type(s) is not st.Move or not s.triggers:
        return [s]
    if all(_acts_at_an_end(one, s) for one in s.triggers):
        return _beside(s, work)
    forms = work.limits.path_triggers
    if forms is None or len(s.triggers) > forms.most or not all(forms.say(one, s.path) for one in s.triggers):
        return _beside(s, work)
    for one in s.triggers:
        says = _CORNER if _size(s) != 0.0 and not one.at_start else ""
        if not says and s.path is not st.Path.LINEAR and one.metres is not None:
            says = _CURVED
        if says:
            work.lose(_switched(s, one), Fate.APPROXIMATED, "order", says)
    return [s]


def _beside(s: st.Move, work: TranslationContext) -> list[st.Statement]:
    """What its triggers switch before and behind a move, in the order in which they act."""
    starts, ends = _near(s.triggers, True), _near(s.triggers, False)
    return [
        *[_output(s, one, work) for one in _in_order(starts) or starts],
        replace(s, triggers=()),
        *[_output(s, one, work) for one in _in_order(ends) or ends],
    ]


def _switched(s: st.Move, one: st.PathTrigger) -> st.SetOutput:
    return st.SetOutput(s.line - one.above, one.signal, one.value)


def _output(s: st.Move, one: st.PathTrigger, work: TranslationContext) -> st.SetOutput:
    switched = _switched(s, one)
    if not _acts_at_an_end(one, s):
        name, end = terminology.signal(one.signal)[0], "start" if one.at_start else "end"
        shifts = [(one.metres, mm, "mm"), (one.seconds, ms, "ms")] if one.is_shifted else []
        says = " and ".join(_shift_text(far, scale, unit) for far, scale, unit in shifts if far is not None)
        where = f", not {says} it" if says else f": {_CORNER}"
        work.lose(switched, Fate.APPROXIMATED, "order", f"{name} switches at the {end} of the move{where}")
    return switched


def _shift_text(far: Quantity, scale: float, unit: str) -> str:
    if far.literal is None:
        return f"a computed number of {unit} from"
    return f"{abs(far.literal) / scale:g} {unit} {'before' if far.literal < 0.0 else 'behind'}"


def _acts_at_an_end(one: st.PathTrigger, s: st.Move) -> bool:
    """Whether a trigger acts where the arm stands at that end of its move."""
    return not one.at_start and _size(s) == 0.0 and not one.is_shifted


def _size(s: st.Move) -> float | None:
    """How large the blend at a move's end is, 0 for an exact stop."""
    return s.blend.value.literal if s.blend is not None and s.blend.value is not None else None


def _of(s: st.Process) -> str:
    """The trigger that an instruction sets, "" for any other one."""
    name = dict(s.arguments).get(_SET)
    return name.name if isinstance(name, Named) else ""


def _near(several: Iterable[st.PathTrigger], at_start: bool) -> list[st.PathTrigger]:
    return [one for one in several if one.at_start is at_start]


def _in_order(several: Sequence[st.PathTrigger]) -> list[st.PathTrigger] | None:
    """Those near one end of a move in the order in which they act, None where the text does not tell it."""
    places = [
        tuple(0.0 if far is None else far.literal for far in (one.metres, one.seconds)) for one in several
    ]
    if len(several) > 1 and any(None in place for place in places):
        return None
    return in_order(several, [(metres or 0.0, seconds or 0.0) for metres, seconds in places])


@dataclass(slots=True)
class _Triggers:
    """`shown`: (routine or "", name) of those whose moves are written with what they switch."""

    work: TranslationContext
    program: st.Program
    shown: set[tuple[str, str]] = field(default_factory=set)
    refused: set[tuple[str, str]] = field(default_factory=set)
    known: dict[tuple[str, str], st.Process | None] = field(default_factory=dict)

    def rows(self, s: st.Statement, routine: st.Routine) -> list[st.Statement]:
        if type(s) is not st.Move or not s.other or not _MOVES.fullmatch(s.other[0][0]):
            return [s]
        named = [e for tag, e in s.other[1:] if not tag or _FURTHER.fullmatch(tag)]
        keys = [self._key(e.name, routine) for e in named if isinstance(e, Named)]
        set_by = [one for key in keys if (one := self._setting(key)) is not None]
        found = tuple(one for one in map(trigger_of, set_by) if one is not None)
        told = all(_in_order(_near(found, at_start)) is not None for at_start in (True, False))
        if len(found) < len(named) or not told:
            self.refused.update(keys)
            return [s]
        self.shown.update(keys)
        kept = tuple((tag, e) for tag, e in s.other[1:] if tag and not _FURTHER.fullmatch(tag))
        return [replace(s, other=kept, triggers=found)]

    def said(self, s: st.Statement, routine: st.Routine) -> st.Statement:
        """The instruction that sets a trigger as a comment, where all moves with this one could be written."""
        if type(s) is not st.Process or not (name := _of(s)):
            return s
        key = self._key(name, routine)
        if key not in self.shown or key in self.refused:
            return s
        self.work.lose(s, Fate.EXACT, "statement", _SAID)
        return st.Comment(s.line, self.work.source.source.line(s.line).strip().rstrip(";"))

    def _key(self, name: str, routine: st.Routine) -> tuple[str, str]:
        own = {d.name for d in routine.data} | {p.name for p in routine.parameters}
        own |= {one.name for one in routine.body if isinstance(one, st.Declare)}
        return (routine.name if name in own else "", name)

    def _setting(self, key: tuple[str, str]) -> st.Process | None:
        """The one instruction that sets a trigger to what is written out, None where something else may, too."""
        if key not in self.known:
            self.known[key] = self._found(*key)
        return self.known[key]

    def _found(self, scope: str, name: str) -> st.Process | None:
        found: st.Process | None = None
        word = re.compile(rf"(?<!\w){re.escape(name)}(?!\w)", re.IGNORECASE)
        for routine in self.program.routines:
            if self._key(name, routine)[0] != scope or (scope and routine.name != scope):
                continue
            if name in {p.name for p in routine.parameters}:
                return None
            for _, s in self.work.look(routine).rare:
                if isinstance(s, st.Declare) or (
                    type(s) is st.Move and s.other and _MOVES.fullmatch(s.other[0][0])
                ):
                    continue
                if type(s) is st.Process and _of(s) == name:
                    if found is not None or not isinstance(dict(s.arguments)["value"], (Number, SignalState)):
                        return None
                    found = s
                elif any(
                    e == Named(name) or (type(e) is Text and word.search(e.value)) for e in expressions_of(s)
                ):
                    return None
        return found
