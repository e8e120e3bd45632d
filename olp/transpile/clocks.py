"""Clocks that count seconds while they run: by number or by name, as the target has them.

A clock is `timer` of its number or its name: what it has counted [s]. `timer-running` is whether it counts. Setting
`timer` leaves it running or standing.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Final, TypeGuard

from olp.ir.expressions import (
    Binary,
    Compare,
    Expression,
    Function,
    Named,
    Number,
    SignalState,
    SystemValue,
)
from olp.ir.program import Assign, Comment, Declare, Program, Routine, Statement
from olp.ir.transformer import calls_nothing, expressions_of, mapped, sets_numbers
from olp.transpile.context import Fate, TranslationContext
from olp.transpile.reaching_definitions import Key, Reaching, reaching

COUNTED: Final = "timer"
RUNNING: Final = "timer-running"
TYPE: Final = "clock"  # of a declaration
_STOPPED, _STARTED = 0, 1
_STEPS: Final = "each controller counts a clock in steps of its own, of 1 to 12 ms"
_ASKS: Final = "see that no other program uses these clocks, and set them to 0 before the first start"
_OTHER_TIME: Final = "a clock that is set to another time than 0"
_SOMETIMES: Final = "a clock that is set to 0 while it runs on some ways here and stands on others"
_ASKED: Final = "asking whether a clock runs"
_OWN: Final = "a clock of a routine's own, which begins anew with each call"


def is_clock(e: Expression | None) -> TypeGuard[SystemValue | Function]:
    """Whether it is what a clock has counted, or whether one runs."""
    return isinstance(e, (SystemValue, Function)) and e.name in (COUNTED, RUNNING)


def clocks(program: Program, work: TranslationContext) -> Program:
    """Clocks as the target's; what it cannot do with one is refused. A target without any is left to others."""
    if not work.limits.clocks:
        return program
    found = {
        routine.name: {i: c for i, s in enumerate(routine.body) for c in _clocks_in(s)}
        for routine in program.routines
    }
    if not any(found.values()):
        return program
    own = _Clocks(work, reaching(program, _definitions, {Assign}))
    own.note(program)
    routines = tuple(own.routine(r) for r in program.routines)
    data = tuple(d for d in program.data if d.type != TYPE)
    return replace(program, routines=routines, data=(*data, *own.declares()))


def _clocks_in(s: Statement) -> list[SystemValue | Function]:
    if calls_nothing(s) or sets_numbers(s):
        return []
    return [e for e in expressions_of(s) if is_clock(e)]


def _clock(e: SystemValue | Function) -> Expression:
    """The number or name of a clock."""
    return e.arguments[0] if isinstance(e, Function) else Number(e.index)


def _key(clock: Expression) -> Key:
    return ("clock", clock.name.casefold() if isinstance(clock, Named) else clock)


def _definitions(s: Statement) -> Mapping[Key, int]:
    """What a statement leaves a clock at: running or standing."""
    if isinstance(s, Assign) and is_clock(s.target) and _switches(s):
        return {_key(_clock(s.target)): _STARTED if s.value == SignalState(True) else _STOPPED}
    return {}


def _switches(s: Assign) -> bool:
    """Whether a statement starts a clock or stops it."""
    return is_clock(s.target) and s.target.name == RUNNING and isinstance(s.value, SignalState)


def _seconds(e: Expression) -> float | None:
    if isinstance(e, Number):
        return float(e.value)
    if isinstance(e, Binary) and e.operator == "/" and isinstance(e.right, Number) and e.right.value:
        top = _seconds(e.left)
        return None if top is None else top / e.right.value
    return None


@dataclass(slots=True)
class _Clocks:
    work: TranslationContext
    states: Reaching
    known: dict[Key, Expression] = field(default_factory=dict)  # a clock of the source -> that of the target
    taken: set[int] = field(default_factory=set)
    local: set[str] = field(default_factory=set)  # names of routines' own ones, case folded

    def note(self, program: Program) -> None:
        """Numbers that clocks have already stay theirs, as far as the target has them."""
        for s in program.statements():
            if isinstance(s, Declare) and s.type == TYPE:
                self.local.add(s.name.casefold())
            for e in _clocks_in(s):
                number = _clock(e)
                if isinstance(number, Number) and 1 <= number.value <= self.work.limits.clocks:
                    self.taken.add(int(number.value))

    def declares(self) -> list[Declare]:
        named = [e for e in self.known.values() if isinstance(e, Named)]
        return [Declare(0, e.name, TYPE) for e in named]

    def routine(self, routine: Routine) -> Routine:
        rows: list[Statement] = []
        for at, s in enumerate(routine.body):
            if isinstance(s, Declare) and s.type == TYPE:
                continue
            rows += self._statement(routine, at, s) if _clocks_in(s) else [s]
        return replace(routine, body=tuple(rows))

    def _statement(self, routine: Routine, at: int, s: Statement) -> list[Statement]:
        reads = [e for e in _clocks_in(s) if not (isinstance(s, Assign) and e is s.target)]
        if any(e.name == RUNNING for e in reads):
            return self._refuse(s, _ASKED)
        for clock in map(_clock, _clocks_in(s)):
            if isinstance(clock, Named) and clock.name.casefold() in self.local:
                return self._refuse(s, _OWN)
            if not isinstance(clock, (Number, Named)):
                return self._refuse(s, "a clock with a computed number")
        if reads:
            self.work.lose(s, Fate.APPROXIMATED, "value", _STEPS)
        if isinstance(s, Assign) and is_clock(s.target):
            return self._set(routine, at, s, s.target)
        return [self._there(s)]

    def _refuse(self, s: Statement, says: str) -> list[Statement]:
        self.work.lose(s, Fate.REFUSED, "statement", says)
        return [s]

    def _set(self, routine: Routine, at: int, s: Assign, target: SystemValue | Function) -> list[Statement]:
        if _switches(s):
            return [self._there(s)]
        if target.name == RUNNING or _seconds(s.value) != 0.0:
            return self._refuse(s, _OTHER_TIME)
        zeroed = self._there(replace(s, value=Number(0)))
        clock = _clock(target)
        on, off = (
            self._there(Assign(s.line, _of(RUNNING, clock), SignalState(state))) for state in (True, False)
        )
        if self.work.conventions.clocks_run:
            return [zeroed, on]
        if at and _definitions(routine.body[at - 1]).get(_key(clock)) == _STOPPED:
            return [zeroed]
        stops = self.work.limits.zeroing_stops
        if self._is_set_next(routine, at, clock):
            return [off, zeroed] if stops else [zeroed]
        states = self.states.at(routine.name, at, _key(clock))
        if _STARTED not in states:
            return [off, zeroed] if stops else [zeroed]
        if self.work.conventions.zeroed_clock:
            self.work.lose(s, Fate.APPROXIMATED, "value", self.work.conventions.zeroed_clock)
        if not stops:
            return [zeroed]
        return [off, zeroed, on] if states == {_STARTED} else self._refuse(s, _SOMETIMES)

    def _is_set_next(self, routine: Routine, at: int, clock: Expression) -> bool:
        """Whether the next statement starts or stops it, whatever it did."""
        following = next((one for one in routine.body[at + 1 :] if not isinstance(one, Comment)), None)
        return following is not None and _key(clock) in _definitions(following)

    def _there(self, s: Statement) -> Statement:
        """A statement with the target's clocks, comparisons in its unit."""
        return mapped(s, self._changed)

    def _changed(self, e: Expression) -> Expression:
        if is_clock(e):
            return _of(e.name, self._known(_clock(e)))
        if isinstance(e, Binary) and e.operator == "div" and any(map(is_clock, expressions_of(e))):
            return Function("trunc", (Binary("/", e.left, e.right),))
        return self._in_units(e)

    def _known(self, clock: Expression) -> Expression:
        key = _key(clock)
        if key not in self.known:
            self.known[key] = self._new(clock)
        return self.known[key]

    def _new(self, clock: Expression) -> Expression:
        form = self.work.limits.clock_form
        if not form:
            number = int(clock.value) if isinstance(clock, Number) else ""
            return Named(self.work.helper(f"clock{number}"))
        numbers = range(1, self.work.limits.clocks + 1)
        number = int(clock.value) if isinstance(clock, Number) else 0
        if number not in numbers:
            number = next((n for n in numbers if n not in self.taken), 0)
        if not number:
            self.work.lose(0, Fate.REFUSED, "clock", f"more than {self.work.limits.clocks} clocks")
        self.taken.add(number)
        shown = form.format(number)
        if isinstance(clock, Named):
            self.work.names[("variable", clock.name)] = shown
        self.work.ask(_ASKS, shown)
        return Number(number)

    def _in_units(self, e: Expression) -> Expression:
        """A comparison of a clock with a number, in the unit in which the target counts."""
        if not isinstance(e, Compare):
            return e
        unit = self.work.limits.clock_unit
        scale, clock, limit = _compared(e.left, e.right)
        if clock is None or limit is None:
            return e
        number = limit / scale / unit
        number = int(round(number, 6)) if float(round(number, 6)).is_integer() else round(number, 6)
        counted: Expression = clock if unit == 1.0 else Binary("*", clock, Number(round(1.0 / unit)))
        return replace(e, left=counted, right=Number(number))


def _compared(left: Expression, right: Expression) -> tuple[float, Expression | None, float | None]:
    """(units a second, the clock, the number beside it)"""
    if not isinstance(right, Number):
        return 1.0, None, None
    scale = 1.0
    if (
        isinstance(left, Binary)
        and left.operator == "*"
        and isinstance(left.right, Number)
        and left.right.value
    ):
        scale, left = float(left.right.value), left.left
    if is_clock(left) and left.name == COUNTED:
        return scale, left, float(right.value)
    return 1.0, None, None


def _of(name: str, clock: Expression) -> Expression:
    """A clock by its number, or by its name."""
    return SystemValue(name, int(clock.value)) if isinstance(clock, Number) else Function(name, (clock,))
