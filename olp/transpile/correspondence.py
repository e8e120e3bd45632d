"""Maps statements and signals of a translation to those of the source, and values that no file tells.

Statements and signals pair the steps of both runs. What no file tells is zero in a plain run of each, so that the two
may agree by chance: both are run several times more with values made up for it (`olp.runtime.made_up`).
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import lru_cache
from pathlib import PurePath
from typing import Final, NamedTuple

from olp.core.diagnostic import OlpError
from olp.ir import expressions as ex
from olp.ir import program as st
from olp.ir.transformer import calls_nothing, expressions_of
from olp.languages.limits import SPARE_SIGNALS, Registers, limits_of
from olp.languages.vendor import conventions_of, find_vendor
from olp.runtime.assumptions import NAMED_SIGNAL, VARIABLE_LETTERS, SignalKey, signal_key, signal_name
from olp.runtime.made_up import FrameAndTool, MadeUp, MadeUpPosition, UnknownThing
from olp.runtime.plan import Event, Plan
from olp.transpile.context import Translated
from olp.transpile.expression_lowering import LETTERS

# --- Statements ---
# Which statement of the source each line of a translation was made from, found from the two texts' own statements.
#
# The writer makes no list: the translated program and the program that is read again hold the same statements
# in the same order, but for what a language sets beside them. Pairs are found routine by routine and never by counting:
# where one of them has a statement more, the next pair is looked for.

Token = tuple[object, ...]
_AHEAD: Final = 32  # statements that are looked at for the next pair
_SIGNAL: Final = "signal"


def origins_of(translated: st.Program, written: Iterable[st.Program]) -> dict[tuple[str, int], int]:
    """Name and line of a file of `written`, read again -> the line of the source that it was made from."""
    found: dict[tuple[str, int], int] = {}
    several: set[tuple[str, int]] = set()  # lines that were made from two, such as a move with its output
    bodies = {routine.name.casefold(): _steps(routine.body) for routine in translated.routines}
    for program in written:
        for routine in program.routines:
            made = bodies.get(routine.name.casefold())
            for s, t in _paired(made, _steps(routine.body)) if made is not None else ():
                place = (PurePath(program.path).name, t.line)
                if isinstance(s, st.While):
                    continue  # any line of such a loop may be the one that asks
                triggers = s.triggers if isinstance(s, st.Move) else ()
                for line in (s.line, *(s.line - one.above for one in triggers)) if s.line else ():
                    if found.setdefault(place, line) != line:
                        several.add(place)
    for place in several:
        del found[place]
    return found


def _steps(body: Sequence[st.Statement]) -> list[tuple[Token, st.Statement]]:
    found = []
    for at, s in enumerate(body):
        token = ("Wait",) if _only_asks(body, at) else _token(s)
        if token:
            found.append((token, s))
    return found


def _only_asks(body: Sequence[st.Statement], at: int) -> bool:
    """Whether a loop begins that does nothing but ask: languages without a wait for a signal read it as one."""
    if not isinstance(body[at], st.While):
        return False
    inside = next((s for s in body[at + 1 :] if not isinstance(s, st.Comment)), None)
    return isinstance(inside, st.EndWhile)


def _token(s: st.Statement) -> Token:
    """What a statement and its translation have in common; () for what makes no step."""
    match s:
        case st.Move():
            return ("move", s.path)
        case st.Call():
            return ("call", s.routine.casefold())
        case st.SetOutput() | st.PulseOutput():
            return (type(s).__name__, s.signal.index)
        case st.Process(name=name):
            return ("Process", name)
        case st.Dwell(duration=duration):
            return ("Dwell", duration.literal == 0.0)  # one of no time may be a stop there, and no statement
        case st.Wait() | st.Pause() | st.Message():
            return (type(s).__name__,)
        case _:
            return ()


def _meet(made: tuple[Token, st.Statement], written: tuple[Token, st.Statement]) -> bool:
    """Whether a statement may be this one written; a wait with a limit may be a loop that waits and asks."""
    s = made[1]
    loops = isinstance(s, st.Wait) and s.timeout is not None and isinstance(written[1], st.Dwell)
    return loops or made[0] == written[0]


def _paired(
    made: list[tuple[Token, st.Statement]], written: list[tuple[Token, st.Statement]]
) -> Iterable[tuple[st.Statement, st.Statement]]:
    i, j = 0, 0
    while i < len(made) and j < len(written):
        if _meet(made[i], written[j]):
            yield made[i][1], written[j][1]
            i, j = i + 1, j + 1
            continue
        more, others = _next_pair(made, written, i, j)
        i, j = i + more, j + others


def _next_pair(
    made: list[tuple[Token, st.Statement]], written: list[tuple[Token, st.Statement]], i: int, j: int
) -> tuple[int, int]:
    """How many statements of both come before the next pair, as few as can be."""
    for total in range(1, _AHEAD):
        for more in range(total + 1):
            x, y = i + more, j + total - more
            if x < len(made) and y < len(written) and _meet(made[x], written[y]):
                return more, total - more
    return 1, 1


# --- Signals ---


_ANY: Final = "*"  # a computed number: "in *" is "di*", "robot-in *" is "in 2000+*"


@dataclass(frozen=True, slots=True)
class SignalsThere:
    """What signals of the source are in the target. `numbered`: by bus, the name of one with a computed number *."""

    single: Mapping[SignalKey, SignalKey]
    numbered: Mapping[str, str]

    @classmethod
    def of(cls, mapping: Mapping[tuple[str, str], str]) -> SignalsThere:
        """`mapping`: (kind, name in the source) -> name in the target."""
        single: dict[SignalKey, SignalKey] = {}
        numbered: dict[str, str] = {}
        for (kind, name), to in mapping.items():
            if kind != _SIGNAL:
                continue
            bus, _, shown = name.rpartition(" ")
            there, _, index = to.rpartition(" ")
            if shown == _ANY and "+" in index:
                first = int(index.partition("+")[0])
                single |= {SignalKey(bus, n): SignalKey(there, first + n) for n in range(SPARE_SIGNALS)}
            elif shown == _ANY:
                numbered[bus] = index
            else:
                single[_key(bus, shown)] = _key(there or bus, index)
        return cls(single, numbered)

    def find(self, signal: SignalKey) -> SignalKey:
        found = self.single.get(signal)
        if found is not None:
            return found
        name = self.numbered.get(signal.bus) if isinstance(signal.number, int) else None
        return signal if name is None else _key(signal.bus, name.replace(_ANY, str(signal.number)))


def _key(bus: str, shown: str) -> SignalKey:
    return SignalKey(bus, int(shown)) if shown.isdecimal() else SignalKey(NAMED_SIGNAL, shown.casefold())


def renamer(mapping: Mapping[tuple[str, str], str]) -> Callable[[Event], Event]:
    """Events of the source with the target's signals."""
    there = SignalsThere.of(mapping)
    single = {signal_name(old): signal_name(new) for old, new in there.single.items()}

    def name_there(name: str) -> str:
        key = signal_key(name) if there.numbered else None
        return single.get(name, name) if key is None else signal_name(there.find(key))

    def renamed(event: Event) -> Event:
        signals = tuple(sorted(map(name_there, event.signals)))
        return event if signals == event.signals else event._replace(signals=signals)

    return renamed


def states_told(target: str) -> frozenset[str]:
    """The signals by which the target's controller tells its own state, as events name them."""
    limits = limits_of(target)
    told = [(bus, index) for bus, index, _ in limits.state_signals.values()]
    told += [limits.manual_signal] if limits.manual_signal is not None else []
    return frozenset(signal_name(_key(bus, str(index))) for bus, index in told)


# --- What no file tells ---


_SEEDS: Final = 4
_MOST_SEEDS: Final = 8
_MOST_BLAMED: Final = 8  # things of which each is tried alone, where both runs differ
_MOST_NAMED: Final = 4
_LABEL: Final = re.compile(r"([A-Z]+)(\d+)")
_SHOWN: Final = re.compile(r"([A-Z]+)\[?(\d+)")
_SYSTEMS: Final = ("tool", "frame")

# Runs both programs: the values for the source, and what makes those for the translation once that has run.
RunBoth = Callable[[MadeUp, Callable[[], MadeUp]], tuple[Plan | None, Plan | None]]


class MadeUpRun(NamedTuple):
    """Both plans with the values of one seed, what was made up, and the same runs with one of these alone."""

    source: Plan | None
    target: Plan | None
    asked: tuple[UnknownThing, ...]
    alone: Callable[[UnknownThing], MadeUpRun]


@dataclass(frozen=True, slots=True)
class SharedUnknowns:
    """What makes the values for both runs. `vendor`: of the translation."""

    program: st.Program
    translated: Translated
    vendor: str
    _compared: list[Mapping[UnknownThing, tuple[int, ...]]] = field(default_factory=list)  # once for all runs
    _of_data: dict[UnknownThing, UnknownThing] = field(default_factory=dict)  # likewise

    @property
    def types(self) -> dict[str, str]:
        """Of the source's names that nothing declares and that are no arrays, as its runs look names up."""
        arrays = {d.name for d in self.translated.program.data if d.sizes}
        there = self.translated.mapping
        return {
            self._folded(name, self.program.vendor): type_
            for name, type_ in self.translated.types.items()
            if there.get(("variable", name), name) not in arrays
        }

    def runs(self, both: RunBoth, asked: Mapping[UnknownThing, object]) -> Iterator[MadeUpRun]:
        """With each seed; none where nothing is unknown. `asked`: what the plain run of the source asked for."""
        if not asked:
            return
        if not self._compared:
            self._compared.append(_choices(self.program))
        choices = self._compared[0]
        widest = max((len(choices.get(thing, ())) for thing in asked), default=0)
        for seed in range(1, 1 + min(max(_SEEDS, widest), _MOST_SEEDS)):
            run = self._run(both, seed, choices, None)
            if not run.asked:
                return  # of what it asks for, nothing can be made up
            yield run

    def _run(
        self,
        both: RunBoth,
        seed: int,
        choices: Mapping[UnknownThing, tuple[int, ...]],
        only: UnknownThing | None,
    ) -> MadeUpRun:
        here = MadeUp(seed, types=self.types, choices=choices, only=only)
        source, target = both(here, lambda: self._there(here))
        made = tuple(thing for thing, value in here.asked.items() if value is not None)
        return MadeUpRun(source, target, made, lambda thing: self._run(both, seed, choices, thing))

    def _there(self, here: MadeUp) -> MadeUp:
        if not self._of_data:
            self._of_data.update(self._data_origins())
        origins = {**self._of_data, **dict(self._origins(here))}
        return MadeUp(
            here.seed,
            origins,
            here.types,
            here.choices,
            here.only,
            here.asked,
            dict(self._places(here, origins)),
            turns=self.turns(here),
            timed=self.timed(here),
        )

    def turns(self, here: MadeUp) -> list[SignalKey]:
        """The inputs that the source's run took to change, as the translation calls them."""
        return list(map(SignalsThere.of(self.translated.mapping).find, here.turned))

    def timed(self, here: MadeUp) -> set[SignalKey]:
        """Those of them that ended loops which ask a clock, too."""
        return set(map(SignalsThere.of(self.translated.mapping).find, here.timed))

    # --- which is which -------------------------------------------------------------------------------------

    def _data_origins(self) -> Iterator[tuple[UnknownThing, UnknownThing]]:
        """What is called as it was; one language may fold its letters."""
        for d in self.translated.program.data:
            old = UnknownThing("variable", self._folded(d.name, self.program.vendor))
            yield from ((name, old) for name in self._there_named(d.name))

    def _origins(self, here: MadeUp) -> Iterator[tuple[UnknownThing, UnknownThing]]:
        """A thing of the translation that has a new name, and what it is in the source."""
        mapping = self.translated.mapping
        # A register that got its comment's name, which was made legal, and then became a register: three steps.
        step = {to: name for (kind, name), to in mapping.items() if (kind, to) in mapping}
        first = {to: _root(to, step) for to in step}
        systems = {to for (kind, _), to in mapping.items() if kind in _SYSTEMS}
        registers = limits_of(self.vendor).registers
        for (kind, name), to in mapping.items():
            if kind in _SYSTEMS:
                old = UnknownThing(kind, _system(first.get(name, name)))
                yield UnknownThing(kind, _system(to)), old
                if not to.isdecimal():
                    called = mapping.get(("variable", to), to)  # its name may be no word of the target
                    yield UnknownThing("variable", self._folded(called, self.vendor)), old
            elif kind in ("variable", "point") and name not in systems:
                yield from self._variables(first.get(name, name), to, here, registers)
        signals = SignalsThere.of(self.translated.mapping)
        for old_signal, new_signal in signals.single.items():
            yield UnknownThing("signal", new_signal), UnknownThing("signal", old_signal)
        for thing in here.asked if signals.numbered else ():
            if isinstance(thing.name, SignalKey):
                yield UnknownThing("signal", signals.find(thing.name)), thing

    def _variables(
        self, name: str, to: str, here: MadeUp, registers: Registers | None
    ) -> Iterator[tuple[UnknownThing, UnknownThing]]:
        if name.endswith("*"):
            store = _stores().get(name[:-1])
            first = 1 - conventions_of(self.program.vendor).first_variable
            for thing in here.asked:
                if isinstance(thing.name, tuple) and thing.name[0] is store:
                    place = self._folded(to, self.vendor), int(thing.name[1]) + first
                    yield UnknownThing("element", place), thing
            return
        old = self._variable_here(name, here)
        if registers is None:
            for there in self._there_named(to):
                yield there, old
        elif (shown := _SHOWN.match(to)) is not None:
            store = next((s for s, letter in registers.letters.items() if letter == shown[1]), None)
            if store is not None:
                yield UnknownThing("variable", (store, int(shown[2]))), old

    def _there_named(self, name: str) -> list[UnknownThing]:
        """A name of the translation as it is read again: a pendant's form has a sign before that of its point."""
        before = limits_of(self.vendor).form_points
        names = (name, f"{before}{name}") if before else (name,)
        return [UnknownThing("variable", self._folded(one, self.vendor)) for one in names]

    def _variable_here(self, name: str, here: MadeUp) -> UnknownThing:
        label = _LABEL.fullmatch(name)
        if label is not None and label[1] in _stores():
            numbered = UnknownThing("variable", (_stores()[label[1]], int(label[2])))
            if numbered in here.asked:
                return numbered
        return UnknownThing("variable", self._folded(name, self.program.vendor))

    def _places(
        self, here: MadeUp, origins: Mapping[UnknownThing, UnknownThing]
    ) -> Iterator[tuple[UnknownThing, FrameAndTool]]:
        """The frame and tool of positions that hold them in the translation."""
        there = {old: new.name for new, old in origins.items() if new.kind in _SYSTEMS}
        for thing, made in here.asked.items():
            if isinstance(made, MadeUpPosition):
                frame, old, tool = made.place
                user = None if old is None else there.get(UnknownThing("frame", old), old)
                number = there.get(UnknownThing("tool", tool), tool)
                if isinstance(number, int) and (user is None or isinstance(user, int)):
                    yield thing, (frame, user, number)

    @staticmethod
    def _folded(name: str, vendor: str) -> str:
        return name if _keeps_case(vendor) else name.casefold()


@lru_cache(maxsize=32)
def _keeps_case(vendor: str) -> bool:
    return find_vendor(vendor).case_sensitive


@lru_cache(maxsize=1)
def _stores() -> dict[str, ex.Store]:
    return {letters: store for store, letters in LETTERS.items()}


def _root(name: str, step: Mapping[str, str]) -> str:
    """The name that the source has for `name`, over all steps from one name to the next."""
    seen = {name}
    while (before := step.get(name)) is not None and before not in seen:
        seen.add(name := before)
    return name


def _system(label: str) -> int | str:
    return int(label) if label.isdecimal() else label.casefold()


# --- what values are compared with --------------------------------------------------------------------------


def _choices(program: st.Program) -> dict[UnknownThing, tuple[int, ...]]:
    """The whole numbers that the source compares each of its variables and inputs with, and one beyond them."""
    found: dict[UnknownThing, dict[int, None]] = {}
    fold = not find_vendor(program.vendor).case_sensitive
    main = program.main or (program.routines[0].name if program.routines else "")
    for routine in program.routines:
        switched: ex.Expression | None = None
        own = routine.parameters if routine.name == main else ()
        given = {
            _thing(ex.Named(one.name), fold): UnknownThing("argument", n) for n, one in enumerate(own, 1)
        }
        for s in routine.body:
            pairs: list[tuple[ex.Expression, ex.Expression]] = []
            if isinstance(s, st.Switch):
                switched = s.value
            elif isinstance(s, st.Case) and switched is not None:
                pairs = [(switched, value) for value in s.values]
            if not calls_nothing(s):
                compared = (e for e in expressions_of(s) if isinstance(e, ex.Compare))
                pairs += [pair for e in compared for pair in ((e.left, e.right), (e.right, e.left))]
            for value, constant in pairs:
                thing, number = _thing(value, fold), _whole(constant)
                thing = given.get(thing, thing)
                if thing is not None and number is not None:
                    found.setdefault(thing, {})[number] = None
    return {thing: (*numbers, max(numbers) + 1) for thing, numbers in found.items()}


def _thing(e: ex.Expression, fold: bool) -> UnknownThing | None:
    match e:
        case ex.Named(name):
            return UnknownThing("variable", name.casefold() if fold else name)
        case ex.Argument(number):
            return UnknownThing("argument", number)
        case ex.Variable(store, ex.Number(index), False):
            return UnknownThing("variable", (store, int(index)))
        case ex.Signal(bus, ex.Number(index)):
            return UnknownThing("signal", SignalKey(bus, int(index)))
        case ex.Signal(_, ex.Text(name)):
            return UnknownThing("signal", SignalKey(NAMED_SIGNAL, name.casefold()))
    return None


def _whole(e: ex.Expression) -> int | None:
    if isinstance(e, ex.Unary) and e.operator == "-":
        value = _whole(e.operand)
        return None if value is None else -value
    return int(e.value) if isinstance(e, ex.Number) and e.value == int(e.value) else None


# --- what made a difference ---------------------------------------------------------------------------------


def blamed(run: MadeUpRun, differs: Callable[[MadeUpRun], bool]) -> str:
    """What both runs differ with, as a person would say it: the value that makes it alone, or that none of them does.

    Where things are many, the first ones are tried; what is not tried is not said to make nothing.
    """
    tried = run.asked[:_MOST_BLAMED]
    decided = True
    for thing in tried:
        try:
            if differs(run.alone(thing)):
                return f"with another value of {said(thing)}"
        except OlpError:
            decided = False
    more = len(run.asked) - _MOST_NAMED
    named = ", ".join(map(said, run.asked[:_MOST_NAMED])) + (f" and {more} more" if more > 0 else "")
    if len(run.asked) == 1:
        return f"with another value of {named}"
    none_alone = decided and len(tried) == len(run.asked)
    why = (
        "no single one of them makes it differ"
        if none_alone
        else "which of them makes it differ is not known"
    )
    return f"with other values of {named} together ({why})"


def said(thing: UnknownThing) -> str:
    kind, name = thing
    if isinstance(name, SignalKey):
        return signal_name(name)
    if kind == "argument":
        return f"argument {name}"
    if kind == "start":
        return "where the arm stands at first"
    if isinstance(name, tuple):
        store, index = name
        letters = VARIABLE_LETTERS[store] if isinstance(store, ex.Store) else store
        return f"{letters}{index:03d}"
    return f"{kind} {name}" if kind in _SYSTEMS else str(name)
