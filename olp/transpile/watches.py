"""What runs as soon as a condition comes true, as the target's traps: routines that signals call.

A condition of one digital signal is a trap of that signal's edge. One of several is a trap of each of their changes, in
which the condition is asked. No run lets it happen, so each is told. What a target without traps would need, what waits
for other values, and routines that give up the move are left to `source_only` to refuse.
"""

from __future__ import annotations

from collections.abc import Container, Iterator, Mapping
from dataclasses import dataclass, field, replace
from typing import Final

from olp.ir import expressions as ex
from olp.ir import program as st
from olp.ir.points import PointTable
from olp.ir.transformer import calls_nothing, expressions_of, mapped
from olp.languages.limits import TrapWords
from olp.languages.vendor import TRAP, WATCH, language_of
from olp.transpile.context import Fate, TranslationContext

_ANY_EDGE: Final = 2
_TELLS: Final = (
    "{} calls {} between its instructions, and no run here lets it happen: see that it does what it should"
)


@dataclass(frozen=True, slots=True)
class _Watch:
    """`signals`: each with the edge at which it calls: 1 on, 0 off, 2 both."""

    number: int
    signals: tuple[tuple[ex.Signal, int], ...]
    when: ex.Expression
    call: ex.CallValue

    @property
    def trap(self) -> str:
        return f"trap_{self.number}"

    def names(self) -> list[str]:
        count = len(self.signals)
        return (
            [f"watch_{self.number}"]
            if count == 1
            else [f"watch_{self.number}_{n}" for n in range(1, count + 1)]
        )


def watches(program: st.Program, work: TranslationContext) -> st.Program:
    """Traps and the statements that switch them."""
    words = work.limits.traps
    if words is None:
        return program
    declared = list(_declared(program, work))
    numbers = [number for number, _ in declared]
    known = {number: one for number, one in declared if one is not None and numbers.count(number) == 1}
    if not known:
        return program
    own = _Traps(program, work, words, known, len(declared))
    routines = [own.routine(r) for r in program.routines]
    traps = [own.trap(one) for one in known.values()]
    data = [
        st.Declare(0, name, words.data_type, None, shared=True)
        for one in known.values()
        for name in one.names()
    ]
    return replace(program, routines=(*routines, *traps), data=(*program.data, *own.shared, *data))


def _declared(program: st.Program, work: TranslationContext) -> Iterator[tuple[int, _Watch | None]]:
    """The number of each condition that is watched, with how, where the target can."""
    for s in work.rare(program):
        given = dict(s.arguments) if isinstance(s, st.Process) else {}
        if given.get(WATCH) == ex.Text("declared"):
            number, when, call = given["number"], given["when"], given["call"]
            assert isinstance(number, ex.Number)
            assert isinstance(call, ex.CallValue)
            words, leaves = work.limits.traps, work.conventions.leaving_process
            signals = tuple(_signals(when, words.signals)) if words is not None else ()
            fits = signals and not any(
                isinstance(one, st.Process) and one.name == leaves for one in _body(program, call.routine)
            )
            yield int(number.value), _Watch(int(number.value), signals, when, call) if fits else None


def _body(program: st.Program, name: str) -> tuple[st.Statement, ...]:
    return next((r.body for r in program.routines if r.name.casefold() == name.casefold()), ())


def _signals(when: ex.Expression, buses: Container[str]) -> Iterator[tuple[ex.Signal, int]]:
    """The signals that a condition asks, nothing where it asks anything else."""
    edge = _edge(when, buses)
    if edge is not None:
        yield edge
        return
    parts = expressions_of(when)
    found = [e for e in parts if isinstance(e, ex.Signal)]
    if all(
        isinstance(e, (ex.Signal, ex.SignalState, ex.Number, ex.Logic, ex.Unary, ex.Compare)) for e in parts
    ) and all(e.bus in buses for e in found):
        yield from dict.fromkeys((e, _ANY_EDGE) for e in found)


def _edge(when: ex.Expression, buses: Container[str]) -> tuple[ex.Signal, int] | None:
    """`di`, `NOT di`, `di=on`: the signal, and whether it calls when it turns on or off."""
    match when:
        case ex.Signal(bus, _) if bus in buses:
            return when, 1
        case ex.Unary("not", operand):
            inner = _edge(operand, buses)
            return None if inner is None else (inner[0], 1 - inner[1])
        case ex.Compare("=" | "<>" as word, left, ex.SignalState(on)):
            inner = _edge(left, buses)
            return None if inner is None else (inner[0], inner[1] if on == (word == "=") else 1 - inner[1])
    return None


@dataclass(slots=True)
class _Traps:
    program: st.Program
    work: TranslationContext
    words: TrapWords
    known: Mapping[int, _Watch]
    count: int  # of all that the program watches
    shared: list[st.Declare] = field(default_factory=list)  # of routines, which a trap is to see

    def routine(self, r: st.Routine) -> st.Routine:
        called = {one.call.routine.casefold() for one in self.known.values()}
        handed = {
            e.name
            for one in self.known.values()
            for a in one.call.arguments
            for e in expressions_of(a)
            if type(e) is ex.Named
        }
        rows: list[st.Statement] = []
        for s in r.body:
            if isinstance(s, st.Declare) and s.name in handed:
                self.shared.append(replace(s, line=0, shared=True))
            elif isinstance(s, st.Process) and s.name == self.work.conventions.halting_process:
                halts = r.name.casefold() in called
                rows += [st.Process(s.line, self.words.stop, (), s.comment)] if halts else [s]
                rows += [st.Process(s.line, self.words.keep)] if halts and _moves(r.body) else []
            elif r.name.casefold() in called and isinstance(s, st.Move) and self._returns(s):
                rows += [st.Comment(s.line, s.comment)] if s.comment else []
            else:
                s = self._at_once(s) if r.name.casefold() in called else s
                rows += self._switched(s)
        return replace(r, body=tuple(rows))

    def _returns(self, s: st.Move) -> bool:
        """Whether a move leads the arm back to its path, as the target does by itself."""
        goal = s.targets[0]
        if type(goal) is not ex.Named or goal.name.casefold() not in self.work.conventions.returning_places:
            return False
        says = f"{language_of(self.work.target)} itself leads the arm back to the path that it left"
        self.work.lose(s, Fate.APPROXIMATED, "option", says)
        return True

    def _at_once(self, s: st.Statement) -> st.Statement:
        """A statement with where the arm stands in the place of where it stood when the condition came true."""
        places = self.work.conventions.interrupted_places

        def change(e: ex.Expression) -> ex.Expression:
            if type(e) is not ex.Named or e.name.casefold() not in places:
                return e
            says = f"{e.name} is taken where the arm stands when the routine asks, a little later"
            self.work.lose(s, Fate.APPROXIMATED, "position", says)
            return ex.SystemValue(places[e.name.casefold()])

        return s if calls_nothing(s) else mapped(s, change)

    def _switched(self, s: st.Statement) -> list[st.Statement]:
        given = dict(s.arguments) if isinstance(s, st.Process) else {}
        how, number = given.get(WATCH), given.get("number")
        if not isinstance(how, ex.Text) or not isinstance(number, ex.Number):
            return [s]
        if how.value == "declared" and int(number.value) in self.known:
            return list(self._begun(s, self.known[int(number.value)]))
        watched = [one for key, one in self.known.items() if number.value in (0, key)]
        if how.value == "declared" or not watched:
            return [s]
        if not number.value and len(watched) < self.count:
            self.work.lose(s, Fate.APPROXIMATED, "order", "it switches those alone that are translated")
        word = self.words.on if how.value == "on" else self.words.off
        return [st.Process(s.line, word, (("", ex.Named(name)),)) for one in watched for name in one.names()]

    def _begun(self, s: st.Statement, one: _Watch) -> Iterator[st.Statement]:
        says = _TELLS.format(language_of(self.work.target), one.call.routine)
        self.work.lose(s, Fate.APPROXIMATED, "order", says)
        self.work.ask("see that what a signal starts at any time does what it should", one.call.routine)
        for name, (signal, edge) in zip(one.names(), one.signals, strict=True):
            yield st.Process(s.line, self.words.end, (("", ex.Named(name)),))
            yield st.Process(s.line, self.words.connect, (("", ex.Named(name)), ("trap", ex.Text(one.trap))))
            yield st.Process(
                s.line,
                self.words.signals[signal.bus],
                (("", signal), ("", ex.Number(edge)), ("", ex.Named(name))),
            )
            yield st.Process(s.line, self.words.off, (("", ex.Named(name)),))

    def trap(self, one: _Watch) -> st.Routine:
        called = _body(self.program, one.call.routine)
        halts = any(
            isinstance(s, st.Process) and s.name == self.work.conventions.halting_process for s in called
        )
        rows: list[st.Statement] = [st.Call(0, one.call.routine, one.call.arguments)]
        if halts:
            rows += [st.Process(0, self.words.restore)] if _moves(called) else []
            rows += [st.Process(0, self.words.start)]
        if one.signals[0][1] == _ANY_EDGE:
            rows = [st.If(0, one.when), *rows, st.EndIf(0)]
        body = (st.Begin(0), *rows, st.End(0))
        return st.Routine(one.trap, 0, body, PointTable(), details={TRAP: ""})


def _moves(body: tuple[st.Statement, ...]) -> bool:
    return any(isinstance(s, st.Move) for s in body)
