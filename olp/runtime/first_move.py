"""Inputs and values with which a program that would end before its first move makes it.

A program that checks its inputs, or what it is called with, ends at once where nothing tells them and zeros are taken.
Other values are tried then: one thing at a time, the one that was asked for last first, and where that leads no further
several at once. What the move does not need is taken as zero again.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from random import Random
from typing import ClassVar, Final, NamedTuple

from olp.ir.expressions import POSITION_STORES, Number, Store, SystemValue
from olp.ir.program import Case, ElseIf, If, Jump, Move, Statement, Switch, Until, While
from olp.ir.transformer import expressions_of
from olp.runtime.assumptions import VARIABLE_LETTERS, SignalKey, signal_name
from olp.runtime.made_up import MadeUp, UnknownThing
from olp.runtime.memory import Value

MOST_STATEMENTS: Final = 10_000  # of one try
_ALL_STATEMENTS: Final = 100_000  # of all of them
_LEAST_STATEMENTS: Final = 1_000  # what making a run ready costs about
_MOST_CHOICES: Final = 12  # numbers that are tried for one thing
_AT_ONCE: Final = 40  # tries with several at once
_NUMBERS: Final = ("integer", "real", "")

Given = Mapping[UnknownThing, int | float | bool]


class MoveReachedError(Exception):
    """A try has reached a move. Caught by whoever tries."""


class AskedAt(NamedTuple):
    """Where a thing was asked for first: index of the source, line."""

    source: int
    line: int


class Try(NamedTuple):
    """`asked`: what nothing tells and the run asked for, in order, with the type that it has."""

    reached: bool
    asked: Mapping[UnknownThing, str]
    statements: int


@dataclass(slots=True)
class TakenValues(MadeUp):
    """What a run is told: `given` for some things, nothing for all others. `first_asked`: where each was asked for."""

    polls: ClassVar[bool] = False

    given: Given = field(default_factory=dict)
    place_now: Callable[[], AskedAt] = lambda: AskedAt(0, 0)
    kinds: dict[UnknownThing, str] = field(default_factory=dict)
    first_asked: dict[UnknownThing, AskedAt] = field(default_factory=dict)

    def _told(self, thing: UnknownThing, type_: str) -> int | float | bool | None:
        self.kinds.setdefault(thing, type_)
        self.first_asked.setdefault(thing, self.place_now())
        return self.given.get(thing)

    def signal(self, key: SignalKey, is_number: bool) -> int | None:
        made = self._told(UnknownThing("signal", key), "integer" if is_number else "boolean")
        return None if made is None else int(made)

    def variable(self, store: Store, index: int, frames: bool) -> Value | None:
        if store in POSITION_STORES or store is Store.STRING:
            return None
        return self._told(
            UnknownThing("variable", (store, index)), "real" if store is Store.REAL else "integer"
        )

    def named(self, name: str, type_: str) -> Value | None:
        if type_ != "boolean" and type_ not in _NUMBERS:
            return None
        return self._told(UnknownThing("variable", name), type_)

    def argument(self, number: int, type_: str) -> Value | None:
        if type_ != "boolean" and type_ not in _NUMBERS:
            return None
        return self._told(UnknownThing("argument", number), type_)

    def result(self, name: str) -> int | bool:
        given = self._told(UnknownThing("result", name), "result")
        return given if isinstance(given, bool) else int(given or 0)


def values_that_move(attempt: Callable[[Given], Try], first: Try, numbers: Sequence[int]) -> Given | None:
    """What to take for what nothing tells, None where no move is found. `numbers`: that the program compares with."""
    search = _Search(attempt, numbers)
    found = search.one_by_one(first) or search.several()
    return None if found is None else search.needed(found)


@dataclass(slots=True)
class _Search:
    attempt: Callable[[Given], Try]
    numbers: Sequence[int]
    statements: int = 0
    best: dict[UnknownThing, int | float | bool] = field(default_factory=dict)
    asked: dict[UnknownThing, str] = field(default_factory=dict)
    tried: dict[frozenset[tuple[UnknownThing, int | float | bool]], Try] = field(default_factory=dict)

    def _tries(self, given: Given) -> Try | None:
        """None where enough was tried. What chance gives again would run as before, and counts without a run."""
        if self.statements > _ALL_STATEMENTS:
            return None
        key = frozenset(given.items())
        tried = self.tried.get(key) or self.attempt(given)
        self.tried[key] = tried
        self.statements += max(tried.statements, _LEAST_STATEMENTS)
        return tried

    def _others(self, type_: str) -> Sequence[int | bool]:
        if type_ == "boolean":
            return (True,)
        return (True, *self.numbers) if type_ == "result" else self.numbers

    def one_by_one(self, first: Try) -> Given | None:
        self.asked = dict(first.asked)
        waiting = self._each()
        while (one := next(waiting, None)) is not None:
            given = {**self.best, **one}
            tried = self._tries(given)
            if tried is None:
                return None
            if tried.reached:
                return given
            if tried.asked.keys() - self.asked.keys():
                self.best.update(one)
                self.asked |= {thing: t for thing, t in tried.asked.items() if thing not in self.asked}
                waiting = self._each()
        return None

    def _each(self) -> Iterator[Given]:
        """One thing with another value: the first choices of all things before the second ones."""
        free = [
            (thing, self._others(t)) for thing, t in reversed(self.asked.items()) if thing not in self.best
        ]
        for rank in range(max((len(values) for _, values in free), default=0)):
            yield from ({thing: values[rank]} for thing, values in free if rank < len(values))

    def several(self) -> Given | None:
        chance = Random(0)
        for _ in range(_AT_ONCE):
            given = dict(self.best)
            for thing, type_ in self.asked.items():
                if chance.random() < 0.5:
                    given[thing] = chance.choice(self._others(type_))
            tried = self._tries(given)
            if tried is None:
                return None
            if tried.reached:
                return given
            self.asked |= {one: t for one, t in tried.asked.items() if one not in self.asked}
        return None

    def needed(self, found: Given) -> Given:
        """Without what the move is reached without."""
        kept = dict(found)
        for thing in list(found):
            less = {one: value for one, value in kept.items() if one != thing}
            tried = self.attempt(less)
            if tried.reached:
                kept = less
        return kept


# --- what is searched for, and how it is told ---------------------------------------------------------------------


def holds_move(bodies: Iterable[Sequence[Statement]]) -> bool:
    """Whether there is a move to another place than where the arm is."""
    return any(isinstance(s, Move) and not _stays(s) for body in bodies for s in body)


def _stays(s: Move) -> bool:
    return len(s.targets) == 1 and isinstance(s.targets[0], SystemValue) and s.relative is None


def numbers_compared(bodies: Iterable[Sequence[Statement]]) -> tuple[int, ...]:
    """What conditions and cases compare with, and 1; also one more and one less, for what has to differ."""
    conditions = (Jump, If, ElseIf, While, Until, Switch, Case)
    written = [e for body in bodies for s in body if isinstance(s, conditions) for e in expressions_of(s)]
    found = [e.value for e in written if isinstance(e, Number)]
    numbers = dict.fromkeys([1, *(int(value) for value in found if float(value).is_integer())])
    near = [number + by for number in numbers for by in (1, -1)]
    return tuple(n for n in dict.fromkeys([*numbers, *near]) if n != 0)[:_MOST_CHOICES]


def spelled(thing: UnknownThing) -> str:
    """As olp.toml names it."""
    if isinstance(thing.name, SignalKey):
        return signal_name(thing.name)
    if thing.kind == "argument":
        return f"argument {thing.name} of the main routine"
    if isinstance(thing.name, tuple) and isinstance(thing.name[0], Store):
        return f"{VARIABLE_LETTERS[thing.name[0]]}{int(thing.name[1]):03d}"
    return f"what {str(thing.name)[:60]} returns" if thing.kind == "result" else str(thing.name)


_TOLD_ELSEWHERE: Final = {
    "argument": "run the program that calls it",
    "result": "only the controller knows: check what follows",
}


def where_told(thing: UnknownThing) -> str:
    if thing.kind in _TOLD_ELSEWHERE:
        return _TOLD_ELSEWHERE[thing.kind]
    table = "inputs" if thing.kind == "signal" else "names" if isinstance(thing.name, str) else "variables"
    return f"say in olp.toml what it is, under [{table}]"


def shown(thing: UnknownThing, value: float | bool) -> str:
    if value is True:
        return "ON" if thing.kind == "signal" else "true"
    return str(value)
