"""Clocks that count seconds: those of the source become those of the target, by number or by name.

`timer` with a clock's number or name is the time [s] that it has counted, `timer-running` whether it counts now.
Setting `timer` neither starts nor stops the clock.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from typing import Final, TypeGuard

from olp.ir import expressions as ex
from olp.ir.block_structure import negated
from olp.ir.program import (
    Assign,
    Comment,
    Declare,
    Dwell,
    EndWhile,
    If,
    Program,
    Repeat,
    Routine,
    Statement,
    Until,
    Wait,
    While,
)
from olp.ir.transformer import calls_nothing, expressions_of, mapped, sets_numbers
from olp.transpile.context import Fate, TranslationContext
from olp.transpile.reaching_definitions import Key, Reaching, reaching

COUNTED: Final = "timer"
RUNNING: Final = "timer-running"
TYPE: Final = "clock"  # of a declaration
_STOPPED, _STARTED = 0, 1
_STEPS: Final = "each controller counts a clock in steps of its own, of 1 to 12 ms"
_ASKS: Final = "see that no other program uses these clocks, and set them to 0 before the first start"
_UNSET: Final = (
    "no statement here starts this clock; if another program does, that program must start the new clock, too"
)
_OTHER_TIME: Final = "a clock that is set to another time than 0"
_AHEAD: Final = "it starts at 0 there, and what is compared with it is later by as much"
_SOMETIMES: Final = "a clock that is set to 0 while it runs on some ways here and stands on others"
_ASKED: Final = "asking whether a clock runs"
_OWN: Final = "a clock of a routine's own, which begins anew with each call"


def is_clock(e: ex.Expression | None) -> TypeGuard[ex.SystemValue | ex.Function]:
    """Whether an expression reads a clock: the time that it has counted, or whether it runs."""
    return isinstance(e, (ex.SystemValue, ex.Function)) and e.name in (COUNTED, RUNNING)


def clocks(program: Program, work: TranslationContext) -> Program:
    """The program with the target's clocks; what they cannot do is refused.

    For targets without any, loops that a clock ends become waits with a limit; all other clocks are left alone.
    """
    if not work.limits.clocks:
        return _with_limited_waits(program, work)
    found = {
        routine.name: {i: c for i, s in work.look(routine).rare for c in _clocks_in(s)}
        for routine in program.routines
    }
    if not any(found.values()):
        return program
    own = _Clocks(work, reaching(program, _definitions, {Assign}))
    own.note(program)
    _tell_unset(program, work)
    routines = tuple(own.routine(r) for r in program.routines)
    data = tuple(d for d in program.data if d.type != TYPE)
    return replace(program, routines=routines, data=(*data, *own.declares()))


def _tell_unset(program: Program, work: TranslationContext) -> None:
    """Tells where a clock of the controller is read that nothing here starts: another program does, there.

    Setting it to 0 starts it only where clocks never stop.
    """
    rows = [s for r in program.routines for _, s in work.look(r).rare]
    runs = work.conventions.clocks_run
    started = {
        _key(_clock(s.target))
        for s in rows
        if isinstance(s, Assign) and is_clock(s.target) and (runs or _may_start(s.target, s.value))
    }
    for s in rows if work.source.vendor != work.target else ():
        read = (_clock(e) for e in _clocks_in(s) if not isinstance(s, Assign) or e is not s.target)
        if any(type(clock) is ex.Number and _key(clock) not in started for clock in read):
            work.lose(s, Fate.APPROXIMATED, "value", _UNSET)


def _may_start(clock: ex.SystemValue | ex.Function, value: ex.Expression) -> bool:
    return clock.name == RUNNING and value != ex.SignalState(False)


def _clocks_in(s: Statement) -> list[ex.SystemValue | ex.Function]:
    if calls_nothing(s) or sets_numbers(s):
        return []
    return [e for e in expressions_of(s) if is_clock(e)]


def _clock(e: ex.SystemValue | ex.Function) -> ex.Expression:
    """The number or name of a clock."""
    return e.arguments[0] if isinstance(e, ex.Function) else ex.Number(e.index)


def _key(clock: ex.Expression) -> Key:
    return ("clock", clock.name.casefold() if isinstance(clock, ex.Named) else clock)


def _definitions(s: Statement) -> Mapping[Key, int]:
    """Clocks that a statement starts (_STARTED) or stops (_STOPPED)."""
    if isinstance(s, Assign) and is_clock(s.target) and _switches(s):
        return {_key(_clock(s.target)): _STARTED if s.value == ex.SignalState(True) else _STOPPED}
    return {}


def _switches(s: Assign) -> bool:
    """Whether a statement starts a clock or stops it."""
    return is_clock(s.target) and s.target.name == RUNNING and isinstance(s.value, ex.SignalState)


def _seconds(e: ex.Expression) -> float | None:
    if isinstance(e, ex.Number):
        return float(e.value)
    if isinstance(e, ex.Binary) and e.operator == "/" and isinstance(e.right, ex.Number) and e.right.value:
        top = _seconds(e.left)
        return None if top is None else top / e.right.value
    return None


@dataclass(slots=True)
class _Clocks:
    work: TranslationContext
    states: Reaching
    known: dict[Key, ex.Expression] = field(
        default_factory=dict
    )  # a clock of the source -> that of the target
    taken: set[int] = field(default_factory=set)
    local: set[str] = field(default_factory=set)  # names of clocks that a routine declares, case folded
    ahead: dict[Key, ex.Expression | None] = field(
        default_factory=dict
    )  # what the target's clock, started at 0, shows [s] when the source's passes 0
    held: list[ex.Named] = field(default_factory=list)  # variables of those times

    def note(self, program: Program) -> None:
        """Reserves the numbers of the program's clocks that the target has: such a clock keeps its number."""
        for s in program.statements():
            if isinstance(s, Declare) and s.type == TYPE:
                self.local.add(s.name.casefold())
            for e in _clocks_in(s):
                number = _clock(e)
                if isinstance(number, ex.Number) and 1 <= number.value <= self.work.limits.clocks:
                    self.taken.add(int(number.value))
        if self.work.limits.clock_unit == 1.0:
            self._note_times(program)

    def _note_times(self, program: Program) -> None:
        """Notes clocks that are set to another time than 0 (`ahead`): the target's can only start from 0."""
        times: dict[Key, set[float | None]] = {}
        for s in program.statements():
            if isinstance(s, Assign) and is_clock(s.target) and s.target.name == COUNTED:
                times.setdefault(_key(_clock(s.target)), set()).add(_seconds(s.value))
        for key, found in times.items():
            (only,) = found if len(found) == 1 else (None,)
            if found == {0.0}:
                continue
            if only is not None:
                self.ahead[key] = ex.Number(-only)
                continue
            self.held.append(ex.Named(self.work.helper("clock_passes_0")))
            self.ahead[key] = self.held[-1]

    def declares(self) -> list[Declare]:
        named = [e for e in self.known.values() if isinstance(e, ex.Named)]
        times = [Declare(0, e.name, "real", ex.Number(0.0)) for e in self.held]
        return [*(Declare(0, e.name, TYPE) for e in named), *times]

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
            if isinstance(clock, ex.Named) and clock.name.casefold() in self.local:
                return self._refuse(s, _OWN)
            if not isinstance(clock, (ex.Number, ex.Named)):
                return self._refuse(s, "a clock with a computed number")
        if reads:
            self.work.lose(s, Fate.APPROXIMATED, "value", _STEPS)
        if isinstance(s, Assign) and is_clock(s.target):
            return self._set(routine, at, s, s.target)
        return [self._there(s)]

    def _refuse(self, s: Statement, says: str) -> list[Statement]:
        self.work.lose(s, Fate.REFUSED, "statement", says)
        return [s]

    def _set(
        self, routine: Routine, at: int, s: Assign, target: ex.SystemValue | ex.Function
    ) -> list[Statement]:
        if _switches(s):
            return [self._there(s)]
        ahead = self.ahead.get(_key(_clock(target)))
        if target.name == RUNNING or (_seconds(s.value) != 0.0 and ahead is None):
            return self._refuse(s, _OTHER_TIME)
        if ahead is not None:
            self.work.lose(s, Fate.APPROXIMATED, "value", _AHEAD)
        rows = self._zeroed(routine, at, s, target)
        if isinstance(ahead, ex.Named):
            seconds = _seconds(s.value)
            later = ex.Number(-seconds or 0.0) if seconds is not None else ex.Unary("-", s.value)
            return [*rows, Assign(s.line, ahead, later)]
        return rows

    def _zeroed(
        self, routine: Routine, at: int, s: Assign, target: ex.SystemValue | ex.Function
    ) -> list[Statement]:
        """Statements that set a clock to 0 and let it run, or not, as before."""
        zeroed = self._there(replace(s, value=ex.Number(0)))
        clock = _clock(target)
        on, off = (
            self._there(Assign(s.line, _of(RUNNING, clock), ex.SignalState(state))) for state in (True, False)
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

    def _is_set_next(self, routine: Routine, at: int, clock: ex.Expression) -> bool:
        """Whether the next statement starts or stops the clock: then its state before does not matter."""
        following = next((one for one in routine.body[at + 1 :] if not isinstance(one, Comment)), None)
        return following is not None and _key(clock) in _definitions(following)

    def _there(self, s: Statement) -> Statement:
        """The statement with the target's clocks; comparisons are in the target's unit of time."""
        if isinstance(s, Assign) and is_clock(s.target):
            target = _of(s.target.name, self._known(_clock(s.target)))
            return replace(s, target=target, value=mapped(s.value, self._changed))
        return mapped(s, self._changed)

    def _changed(self, e: ex.Expression) -> ex.Expression:
        if is_clock(e):
            ahead = self.ahead.get(_key(_clock(e))) if e.name == COUNTED else None
            clock = _of(e.name, self._known(_clock(e)))
            return clock if ahead is None else ex.Binary("-", clock, ahead)
        if isinstance(e, ex.Binary) and e.operator == "div" and any(map(is_clock, expressions_of(e))):
            return ex.Function("trunc", (ex.Binary("/", e.left, e.right),))
        return self._in_units(e)

    def _known(self, clock: ex.Expression) -> ex.Expression:
        key = _key(clock)
        if key not in self.known:
            self.known[key] = self._new(clock)
        return self.known[key]

    def _new(self, clock: ex.Expression) -> ex.Expression:
        form = self.work.limits.clock_form
        if not form:
            number = int(clock.value) if isinstance(clock, ex.Number) else ""
            return ex.Named(self.work.helper(f"clock{number}"))
        numbers = range(1, self.work.limits.clocks + 1)
        number = int(clock.value) if isinstance(clock, ex.Number) else 0
        if number not in numbers:
            number = next((n for n in numbers if n not in self.taken), 0)
        if not number:
            self.work.lose(0, Fate.REFUSED, "clock", f"more than {self.work.limits.clocks} clocks")
        self.taken.add(number)
        shown = form.format(number)
        if isinstance(clock, ex.Named):
            self.work.names[("variable", clock.name)] = shown
        self.work.ask(_ASKS, shown)
        return ex.Number(number)

    def _in_units(self, e: ex.Expression) -> ex.Expression:
        """A comparison of a clock with a number, in the unit in which the target counts."""
        if not isinstance(e, ex.Compare):
            return e
        unit = self.work.limits.clock_unit
        left: ex.Expression = e.left
        ahead: ex.Expression | None = None
        scale = _scale_of(left)
        if scale is not None and isinstance(left, ex.Binary):
            left = left.left
        if isinstance(left, ex.Binary) and left.operator == "-" and is_clock(left.left):
            ahead = left.right
            left = left.left
        if not (is_clock(left) and left.name == COUNTED and isinstance(e.right, ex.Number)):
            return e
        clock: ex.Expression = left
        number = e.right.value / (scale or 1.0) / unit
        if isinstance(ahead, ex.Number):
            number += ahead.value / unit
        number = int(round(number, 6)) if float(round(number, 6)).is_integer() else round(number, 6)
        counted: ex.Expression = clock if unit == 1.0 else ex.Binary("*", clock, ex.Number(round(1.0 / unit)))
        right: ex.Expression = ex.Number(number)
        if ahead is not None and not isinstance(ahead, ex.Number):
            right = ex.Binary("+", ahead, right) if number else ahead
        return replace(e, left=counted, right=right)


def _scale_of(e: ex.Expression) -> float | None:
    """The written factor of a product; None where there is none."""
    if isinstance(e, ex.Binary) and e.operator == "*" and isinstance(e.right, ex.Number) and e.right.value:
        return float(e.right.value)
    return None


def _of(name: str, clock: ex.Expression) -> ex.Expression:
    """The expression `name` (timer or timer-running) of a clock, given by its number or its name."""
    return (
        ex.SystemValue(name, int(clock.value))
        if isinstance(clock, ex.Number)
        else ex.Function(name, (clock,))
    )


# --- Waits that a clock ends ---
# Set a clock to 0, then ask signals and the clock again and again: without clocks that is a wait with a limit. Whether
# the limit has passed is asked of the signals, behind the wait.

_MOST_POLLED: Final = 0.1  # [s] that such a loop waits before it asks again
_LIMITED: Final = (
    "the loop that asks a clock is a wait with a limit; the signals tell behind it whether that has passed"
)
_OPPOSITE: Final = {">": "<=", ">=": "<", "<": ">=", "<=": ">"}


@dataclass(frozen=True, slots=True)
class _LimitedWait:
    """A loop from `head` to `tail` of a body that ends when `done` or after `limit` [s] of `clock`.

    `zeroed`: what sets the clock to 0 and starts it. `asks`: the If behind the loop that asks whether the limit has
    passed, and what it asks instead.
    """

    head: int
    tail: int
    clock: Key
    done: ex.Expression
    limit: float
    zeroed: tuple[int, ...]
    asks: tuple[int, ex.Expression] | None

    @property
    def places(self) -> set[int]:
        """Statements that name the clock."""
        return {self.head, self.tail, *self.zeroed, *((self.asks[0],) if self.asks is not None else ())}


def _with_limited_waits(program: Program, work: TranslationContext) -> Program:
    found = {r.name: list(_limited_waits(r.body)) for r in program.routines if work.look(r).rare}
    if not any(found.values()):
        return program
    elsewhere = {
        _key(_clock(c))
        for r in program.routines
        for at, s in enumerate(r.body)
        for c in _clocks_in(s)
        if not any(at in wait.places for wait in found.get(r.name, ()))
    }
    return replace(
        program,
        routines=tuple(
            _written(r, [wait for wait in found.get(r.name, ()) if wait.clock not in elsewhere], work)
            for r in program.routines
        ),
    )


def _limited_waits(body: tuple[Statement, ...]) -> Iterator[_LimitedWait]:
    for head, s in enumerate(body):
        if not isinstance(s, (Repeat, While)):
            continue
        tail, waited = head + 1, 0.0
        while tail < len(body) and isinstance(body[tail], (Dwell, Comment)):
            one = body[tail]
            waited += (one.duration.literal or _MOST_POLLED + 1.0) if isinstance(one, Dwell) else 0.0
            tail += 1
        end = body[tail] if tail < len(body) else None
        if waited > _MOST_POLLED or not isinstance(end, Until if isinstance(s, Repeat) else EndWhile):
            continue
        until = (
            end.condition
            if isinstance(end, Until)
            else negated(s.condition)
            if isinstance(s, While)
            else None
        )
        parts = _ends(until)
        if parts is None:
            continue
        clock, limit, done = parts
        zeroed = _zeroed_before(body, head, clock)
        if zeroed:
            yield _LimitedWait(
                head, tail, clock, done, limit, zeroed, _asked_behind(body, tail, clock, limit, done)
            )


def _ends(until: ex.Expression | None) -> tuple[Key, float, ex.Expression] | None:
    """The clock and its limit [s] with which a loop ends, and what else ends it: signals."""
    if not isinstance(until, ex.Logic) or any(operator != "or" for operator, _ in until.rest):
        return None
    conditions = [until.first, *(e for _, e in until.rest)]
    limits = [(e, passed) for e in conditions if (passed := _passed(e)) is not None]
    others = [e for e in conditions if all(e is not one for one, _ in limits)]
    if len(limits) != 1 or not limits[0][1][2] or not others or not all(map(_asks_signals, others)):
        return None
    done = ex.Logic(others[0], tuple(("or", e) for e in others[1:])) if len(others) > 1 else others[0]
    clock, limit, _ = limits[0][1]
    return clock, limit, done


def _passed(e: ex.Expression) -> tuple[Key, float, bool] | None:
    """The clock that a comparison asks, the time [s], and whether it holds behind that time."""
    if not isinstance(e, ex.Compare) or e.operator not in _OPPOSITE or not isinstance(e.right, ex.Number):
        return None
    scale = _scale_of(e.left)
    counted = e.left.left if scale is not None and isinstance(e.left, ex.Binary) else e.left
    if not is_clock(counted) or counted.name != COUNTED or e.right.value <= 0:
        return None
    return _key(_clock(counted)), e.right.value / (scale or 1.0), e.operator in (">", ">=")


def _asks_signals(e: ex.Expression) -> bool:
    """Whether a condition asks nothing but signals, some of them."""
    inside = expressions_of(e)
    plain = (ex.Signal, ex.SignalState, ex.Number, ex.Compare, ex.Logic, ex.Unary)
    return all(isinstance(one, plain) for one in inside) and any(isinstance(one, ex.Signal) for one in inside)


def _zeroed_before(body: tuple[Statement, ...], head: int, clock: Key) -> tuple[int, ...]:
    """What sets the clock to 0 right before the loop, and starts it; nothing where it may be at another time."""
    found, zero, at = [], False, head - 1
    while at >= 0:
        s = body[at]
        if isinstance(s, Assign) and is_clock(s.target) and _key(_clock(s.target)) == clock:
            if not _switches(s) and _seconds(s.value) != 0:
                return ()
            zero |= not _switches(s)
            found.append(at)
        elif not isinstance(s, Comment):
            break
        at -= 1
    return tuple(found) if zero else ()


def _asked_behind(
    body: tuple[Statement, ...], tail: int, clock: Key, limit: float, done: ex.Expression
) -> tuple[int, ex.Expression] | None:
    """The If right behind a loop that asks whether its limit has passed, and what it asks instead."""
    at = next((n for n in range(tail + 1, len(body)) if not isinstance(body[n], Comment)), len(body))
    s = body[at] if at < len(body) else None
    passed = _passed(s.condition) if isinstance(s, If) else None
    if passed is None or passed[0] != clock or abs(passed[1] - limit) > 1e-9:
        return None
    return at, negated(done) if passed[2] else done


def _written(routine: Routine, waits: list[_LimitedWait], work: TranslationContext) -> Routine:
    if not waits:
        return routine
    body: list[Statement | None] = list(routine.body)
    for wait in waits:
        head = body[wait.head]
        assert head is not None
        for at in (*wait.zeroed, *range(wait.head, wait.tail + 1)):
            one = body[at]
            if isinstance(one, (Repeat, While, Until, Dwell)):
                work.lose(one, Fate.APPROXIMATED, "wait", _LIMITED)
            body[at] = one if isinstance(one, Comment) else None
        body[wait.tail] = Wait(head.line, wait.done, ex.Quantity(ex.Number(wait.limit), 1.0))
        if wait.asks is not None:
            at, condition = wait.asks
            one = body[at]
            assert isinstance(one, If)
            work.lose(one, Fate.APPROXIMATED, "wait", _LIMITED)
            body[at] = replace(one, condition=condition)
    return replace(routine, body=tuple(s for s in body if s is not None))
