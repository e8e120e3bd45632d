"""Handlers of errors: in the place of the waits that they serve, or out of use with the statements that they serve.

In some languages a wait that reaches its limit is an error: a handler of the routine runs, else one of a caller, else
the program stops. Other targets have no handlers. A wait gets a branch there with what the handler does about its
error, or stops the program and waits again. What a handler does about other errors is left out, which is told: the
target's controller stops where something fails. What waits need and cannot be said stays for `source_only` to refuse.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence, Set
from dataclasses import dataclass, field, replace
from typing import Final

from olp.ir import expressions as ex
from olp.ir import program as st
from olp.ir.block_structure import Node, flat, negated, parse
from olp.ir.transformer import expressions_of
from olp.languages.vendor import ErrorHandling, language_of
from olp.runtime.raised import (
    HANDLES,
    Answer,
    ErrorPath,
    answer_to,
    new_label,
    own_errors,
    raised_answers,
    statements_of,
    with_raised,
)
from olp.transpile.context import PROCESS, Fate, TranslationContext

_LISTED: Final = "LISTED"  # that of some
_OTHER: Final = ""  # any error that the handler does not name
_TIMED_OUT: Final = ex.SystemValue("timed-out")
_STOPS: Final = (
    "a wait at its limit is an error in {}: there the program stops, and waits again when it is started"
)
_ASKED_AGAIN: Final = "whether the wait has reached its limit: the condition is asked for again"
_ENDLESS: Final = (
    "{} gives up after some repetitions (4, or as its controller is set up): there it goes on without end"
)
_BUS: Final = "left out: it handles {}; there the controller itself stops where the bus of a signal fails"
_FAILS: Final = "left out: it handles {}; there the controller itself stops where something fails so"
_LEFT_OUT: Final = "left out: nothing in the translation raises what it handles ({})"
# Kinds of statements that cannot fail, as long as nothing in them can; and of such expressions.
_PLAIN: Final = """
    Assign Update Clear Dwell Message Pause Return If ElseIf Else EndIf While EndWhile For Next Repeat Until Break
    Continue Switch Case Default EndSwitch Label Jump Call Declare
"""
_SIGNALLING: Final = (st.SetOutput, st.PulseOutput, st.ReadInput, st.Wait)  # fail with their bus alone
_SAFE: Final = frozenset(_PLAIN.split())
_UNTRANSLATED: Final = (st.Comment, st.Disabled, st.Process, st.Opaque, st.Begin, st.End)
_SAFE_VALUES: Final = (
    ex.Number,
    ex.Text,
    ex.Signal,
    ex.SignalState,
    ex.Named,
    ex.Member,
    ex.Compare,
    ex.Logic,
    ex.Unary,
    ex.Binary,
)
_MARKERS: Final = (st.If, st.ElseIf, st.Else, st.EndIf, st.Switch, st.Case, st.Default, st.EndSwitch)
_SAFE_OPERATORS: Final = frozenset({"+", "-", "*"})
_SAFE_FUNCTIONS: Final = frozenset({"given"})


def handlers(program: st.Program, work: TranslationContext) -> st.Program:
    """What a handler does about a wait at its time limit goes behind this wait; other handlers are dropped."""
    known = work.conventions.errors
    if known is None or not any(_has_handler(r) or _timed(r) for r in program.routines):
        return program
    pass_ = _Handlers(program, work, known)
    return replace(program, routines=tuple([pass_.routine(r) for r in program.routines]))


def _has_handler(routine: st.Routine) -> bool:
    return any(isinstance(s, st.Disabled) and s.handler for s in routine.body)


def _timed(routine: st.Routine) -> list[int]:
    """Places of the waits that have a limit."""
    return [place for place, s in enumerate(routine.body) if isinstance(s, st.Wait) and s.timeout is not None]


def _failing(routine: st.Routine) -> set[int]:
    """Places of the waits that fail at their limits: nothing asks whether they have reached it."""
    return {place for place in _timed(routine) if not _is_asked(routine.body[place + 1 : place + 2])}


def _is_asked(following: Sequence[st.Statement]) -> bool:
    return any(isinstance(s, st.Assign) and s.value == _TIMED_OUT for s in following)


@dataclass(slots=True)
class _Handlers:
    """`answers`: by routine what its handler does about a wait that fails there, as far as that is known."""

    program: st.Program
    work: TranslationContext
    known: ErrorHandling
    routines: dict[str, st.Routine] = field(init=False)
    own: frozenset[str] = field(init=False)  # errors that the program declares, case folded
    answers: dict[str, Answer | None] = field(init=False)
    raised: dict[str, Set[str]] = field(
        init=False
    )  # by routine: the errors that it raises and answers itself

    def __post_init__(self) -> None:
        self.routines = {r.name.casefold(): r for r in self.program.routines}
        self.own = own_errors(self.program)
        self.answers = {name: self._answer(r) for name, r in self.routines.items()}
        self.raised = {
            name: raised_answers(r, self.known, self.own).keys() for name, r in self.routines.items()
        }

    # --- what a handler does ------------------------------------------------------------------------------------

    def _answer(self, routine: st.Routine) -> Answer | None:
        """What the routine's own handler does about a wait; None where it has none, or that cannot be said."""
        return answer_to(self.known.wait, routine, self.known, self.own) if _failing(routine) else None

    # --- which errors there are ---------------------------------------------------------------------------------

    def _is_possible(self, routine: st.Routine, error: str) -> bool:
        """Whether the translation of a routine can come to an error that its handler would get."""
        if error == self.known.wait:
            return self._waits_fail(routine, set())
        return not self._is_left_out(error) and self._can_fail(routine, set())

    def _is_left_out(self, error: str) -> bool:
        """Whether only statements that are left out raise an error."""
        return error in self.own or self.known.foreign.fullmatch(error) is not None

    def _waits_fail(self, routine: st.Routine, seen: set[str]) -> bool:
        """Whether a wait fails here, or in what is called, without an answer of its own."""
        name = routine.name.casefold()
        if name in seen:
            return False
        seen.add(name)
        if self.answers[name] is None and _failing(routine):
            return True
        return any(self._waits_fail(called, seen) for called in self._called(routine))

    def _uses_signals(self, routine: st.Routine, seen: set[str]) -> bool:
        """Whether a bus may fail here, or in what is called."""
        name = routine.name.casefold()
        if name in seen:
            return False
        seen.add(name)
        return any(
            isinstance(s, _SIGNALLING) or any(isinstance(e, ex.Signal) for e in expressions_of(s))
            for s in routine.body
        ) or any(self._uses_signals(called, seen) for called in self._called(routine))

    def _called(self, routine: st.Routine) -> list[st.Routine]:
        names = [s.routine for s in routine.body if isinstance(s, st.Call)]
        names += [e.routine for s in routine.body for e in expressions_of(s) if isinstance(e, ex.CallValue)]
        return [self.routines[n.casefold()] for n in dict.fromkeys(names) if n.casefold() in self.routines]

    def _can_fail(self, routine: st.Routine, seen: set[str]) -> bool:
        """Whether anything else than a wait at its limit and a bus may fail here, or in what is called."""
        seen.add(routine.name.casefold())
        return any(self._may_fail(s, seen) for s in routine.body)

    def _may_fail(self, s: st.Statement, seen: set[str]) -> bool:
        if isinstance(s, _UNTRANSLATED):
            return False
        known = isinstance(s, _SIGNALLING) or type(s).__name__ in _SAFE
        if not known or (isinstance(s, st.Call) and self._call_fails(s.routine, seen)):
            return True
        return any(self._value_fails(e, seen) for e in expressions_of(s))

    def _value_fails(self, e: ex.Expression, seen: set[str]) -> bool:
        if isinstance(e, ex.CallValue):
            return self._call_fails(e.routine, seen)
        if isinstance(e, ex.Function):
            return e.name not in _SAFE_FUNCTIONS
        return not isinstance(e, _SAFE_VALUES) or (
            isinstance(e, ex.Binary) and e.operator not in _SAFE_OPERATORS
        )

    def _call_fails(self, name: str, seen: set[str]) -> bool:
        if name.casefold() in self.work.conventions.replaceable_routines:
            return False  # the errors that it raises are those of what it reaches
        called = self.routines.get(name.casefold())
        return called is None or (called.name.casefold() not in seen and self._can_fail(called, seen))

    # --- the translation ----------------------------------------------------------------------------------------

    def routine(self, routine: st.Routine) -> st.Routine:
        routine = with_raised(self.program, routine, self.own)
        places = _failing(routine)
        answer = self.answers[routine.name.casefold()]
        dropped = self._judge(routine, answer)
        flagged = set() if self.work.limits.timed_out == "asked" else set(_timed(routine)) - places
        if not places and not dropped and not flagged:
            return routine
        labels = {s.name for s in routine.body if isinstance(s, st.Label)}
        rows: list[st.Statement] = []
        for place, s in enumerate(routine.body):
            if place in places:
                assert isinstance(s, st.Wait)
                rows += self._answered(s, answer, labels)
            elif place - 1 in flagged:
                rows += self._flagged(s, routine.body[place - 1], labels)
            elif isinstance(s, st.Disabled) and s.line in dropped:
                rows += [comment] if (comment := dropped[s.line]) is not None else []
            else:
                rows.append(s)
        return replace(routine, body=tuple(rows))

    def _flagged(self, s: st.Statement, wait: st.Statement, labels: set[str]) -> list[st.Statement]:
        """The assignment that keeps whether the wait before it has reached its limit."""
        assert isinstance(s, st.Assign)
        assert isinstance(wait, st.Wait)
        late, in_time = replace(s, value=ex.SignalState(True)), replace(s, value=ex.SignalState(False))
        if self.work.limits.timed_out != "jump":
            self.work.lose(s, Fate.APPROXIMATED, "wait", _ASKED_AGAIN)
            return [st.If(s.line, wait.condition), in_time, st.Else(s.line), late, st.EndIf(s.line)]
        at_limit = new_label(labels, "late")
        labels.add(at_limit)
        onward = new_label(labels, "onward")
        labels.add(onward)
        rows: list[st.Statement] = [st.Jump(s.line, at_limit, _TIMED_OUT), in_time, st.Jump(s.line, onward)]
        return [*rows, st.Label(s.line, at_limit), replace(late, comment=""), st.Label(s.line, onward)]

    def _judge(self, routine: st.Routine, answer: Answer | None) -> dict[int, st.Comment | None]:
        """By line the rows of handlers that go: a comment for what is left out, None for what its wait has."""
        rows = [s for s in routine.body if isinstance(s, st.Disabled) and s.handler in (HANDLES, _LISTED)]
        nodes = parse(statements_of(rows)) if rows else None
        if nodes is None:
            return {}
        ways = {
            error: {s.line for s in flat(ErrorPath(self.known, self.own, error).through(nodes))}
            for error in (_OTHER, self.known.wait, *self._named(nodes))
        }
        possible = {error for error in ways if self._is_possible(routine, error)}
        raised = self.raised[routine.name.casefold()]
        stopping = {error for error in ways if not self._is_left_out(error)} - {self.known.wait}
        stopping = stopping if self._uses_signals(routine, set()) else set()
        found: dict[int, st.Comment | None] = {}
        line = rows[0].line
        for s in rows:
            line = s.line if s.means else line  # what has no meaning of its own goes with what is before it
            errors = {error for error, lines in ways.items() if line in lines}
            if not errors and (s is rows[0] or all(isinstance(one, _MARKERS) for one in s.means)):
                errors = set(ways)  # it only frames what runs
            if self.known.wait in errors & possible:
                continue
            if errors & possible:
                found[s.line] = st.Comment(s.line, s.text.strip())
                self._tell_left_out(s, _FAILS, errors & possible, PROCESS)
            elif errors & raised or (answer is not None and self.known.wait in errors):
                found[s.line] = None
                self._tell_moved(s, stopping if s is rows[0] else set())
            else:
                found[s.line] = st.Comment(s.line, s.text.strip())
                self._tell_left_out(s, _BUS if errors & stopping else _LEFT_OUT, errors)
        return found

    def _tell_moved(self, s: st.Disabled, stopping: set[str]) -> None:
        """What is other of a row of a handler that stands behind its wait."""
        if stopping:
            self._tell_left_out(s, _BUS, stopping)
        if any(isinstance(one, st.Process) and one.name == self.known.again for one in s.means):
            says = _ENDLESS.format(language_of(self.program.vendor))
            self.work.lose(s, Fate.APPROXIMATED, "order", says)

    def _tell_left_out(self, s: st.Disabled, says: str, errors: set[str], part: str = "option") -> None:
        told = errors - {self.known.wait} if _OTHER in errors else errors
        names = ", ".join(sorted(error.upper() or "any other error" for error in told))
        self.work.lose(s, Fate.APPROXIMATED, part, says.format(names or "nothing"))

    def _named(self, nodes: Iterable[Node]) -> set[str]:
        """The errors that a handler names, case folded."""
        names = {e.name.casefold() for s in flat(nodes) for e in expressions_of(s) if isinstance(e, ex.Named)}
        return {n for n in names if n in self.own or self.known.names.fullmatch(n)}

    def _answered(self, s: st.Wait, answer: Answer | None, labels: set[str]) -> list[st.Statement]:
        """A wait that fails, with what comes of it."""
        way = self.work.limits.timed_out
        late_condition = _TIMED_OUT if way else negated(s.condition)
        if not way:
            self.work.lose(s, Fate.APPROXIMATED, "wait", _ASKED_AGAIN)
        again, onward = new_label(labels, "again"), new_label(labels, "onward")
        if answer is None:
            says = _STOPS.format(language_of(self.program.vendor))
            self.work.lose(s, Fate.APPROXIMATED, "wait", says)
            if way != "jump":
                stop = (st.If(s.line, late_condition), st.Pause(s.line), st.EndIf(s.line))
                return [st.Repeat(s.line), s, *stop, st.Until(s.line, negated(late_condition))]
            inside: list[st.Statement] = [st.Pause(s.line), st.Jump(s.line, again)]
        else:
            inside = answer.rows(self.known, again, onward)
        targets = {one.target for one in inside if isinstance(one, st.Jump)}
        labels |= {again, onward}
        rows: list[st.Statement] = [st.Label(s.line, again)] if again in targets else []
        if way == "jump":
            late = new_label(labels, "late")
            labels.add(late)
            rows += [
                s,
                st.Jump(s.line, late, _TIMED_OUT),
                st.Jump(s.line, onward),
                st.Label(s.line, late),
                *inside,
            ]
            return [*rows, st.Label(s.line, onward)]
        rows += [s, st.If(s.line, late_condition), *inside, st.EndIf(s.line)]
        return [*rows, st.Label(s.line, onward)] if onward in targets else rows
