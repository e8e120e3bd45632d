"""Signals by number or by name, as the target has them, and times as it can say them; the mapping file says which.

Where signals have names and the source computes a number, a variable stands for the signal of that number. Outputs and
waits get the variable by an assignment before them; whatever else reads a signal calls a routine that does both.
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from itertools import chain
from typing import Any, Final

from olp.ir import expressions as ex
from olp.ir import program as st
from olp.ir.points import PointTable
from olp.ir.transformer import calls_nothing, expressions_of, mapped, sets_numbers
from olp.languages.limits import SPARE_SIGNALS, limits_of, writable
from olp.languages.vendor import language_of
from olp.runtime.assumptions import holds_number
from olp.runtime.end_actions import shown_at_ends, split_at_end
from olp.transpile.context import Fate, TranslationContext
from olp.transpile.occurrences import Look, changed_rare, with_rare_rows, with_rows
from olp.transpile.signal_variables import NUMBER
from olp.transpile.symbols import Symbols

# How signals that have only a number are called where they have names.
_STEMS: Final[Mapping[str, str]] = {
    "in": "di",
    "out": "do",
    "in-group": "gi",
    "out-group": "go",
    "analog-in": "ai",
    "analog-out": "ao",
    "robot-in": "ri",
    "robot-out": "ro",
    "tool-in": "ti",
    "tool-out": "to",
    "configurable-in": "ci",
    "configurable-out": "co",
}
_GROUPS: Final = ("in-group", "out-group", "in-half-group", "out-half-group")
_DECLARED: Final = "SIGNAL"  # the kind of a declaration that makes a group
_FROM_ZERO: Final = (
    "its number is computed: there is no signal 0 there, and one that is written as 0 has another number"
)
# Behind the signals that most programs use, and behind inputs 1025 and 1026, which hold TRUE and FALSE on some
# controllers; as many as a word has bits.
_FIRST_FREE, _FREE_SIZE = 1041, 16
_ANALOG: Final = frozenset({"analog-in", "analog-out"})
# Signals beside the usual ones, and which hundred of the target's spare numbers is theirs: the same in each program of
# a cell, and far enough from the next for a computed number.
_BESIDE: Final[Mapping[str, int]] = {
    "robot-in": 0, "robot-out": 0, "tool-in": 1, "tool-out": 1, "configurable-in": 2, "configurable-out": 2,
}  # fmt: skip
_BESIDE_OTHERS: Final = "a signal with a computed number, beside names under [signals] for others"


def stem_of(bus: str) -> str:
    """The stem of the names that signals get which have a number only, where the target has names."""
    return _STEMS.get(bus, re.sub(r"[^a-z]", "_", bus))


def plain_bus(bus: str) -> str:
    """What a signal is where it has a name: whose it is (the robot's, the tool's, the system's) makes no difference."""
    if bus == "tool-analog-in":
        return "analog-in"
    kind = bus.rpartition("-")[2]
    return kind if kind in ("in", "out") and bus not in _ANALOG else bus


def signals(program: st.Program, work: TranslationContext) -> st.Program:
    """Every signal as the target addresses it."""
    own = _Signals(work)
    if work.limits.first_signal or work.limits.last_signals:
        own.keep_numbers(program)
    if work.limits.first_signal:
        own.from_zero = not work.conventions.controller_names and _counts_from_zero(program.vendor)
    if work.conventions.controller_names and not work.target_conventions.controller_names:
        own.note(program)
    routines = tuple(replace(r, body=tuple([own.statement(s) for s in r.body])) for r in program.routines)
    data = (*program.data, *own.groups.values()) if own.groups else program.data
    return replace(program, routines=routines, data=data)


def signal_names(program: st.Program, work: TranslationContext) -> st.Program:
    """Names that the source gives numbered signals and clocks become comments of the statements that use them.

    So do those of numbered variables of a kind that becomes an array, for its elements have no names: what computes
    the number of one makes all of them elements.
    """
    looks = [work.look(r).expressions for r in program.routines]
    arrays = frozenset(
        e.store for found in looks for e in found if type(e) is ex.Variable and type(e.index) is not ex.Number
    )
    named = {
        r.name
        for r, found in zip(program.routines, looks, strict=True)
        if any(_name_in(e, arrays) for e in found) or (arrays and any(_has_name(s, arrays) for s in r.body))
    }
    if not named:
        return program
    routines = [
        with_rows(r, [_with_names(s, arrays) for s in r.body]) if r.name in named else r
        for r in program.routines
    ]
    return replace(program, routines=tuple(routines))


def _has_name(s: st.Statement, arrays: frozenset[ex.Store]) -> bool:
    """Whether a move's target has one, which is not among a routine's expressions."""
    return calls_nothing(s) and any(_name_in(e, arrays) for e in expressions_of(s))


def _with_names(s: st.Statement, arrays: frozenset[ex.Store]) -> st.Statement:
    if getattr(s, "comment", True) or sets_numbers(s) or (calls_nothing(s) and not arrays):
        return s
    found = filter(None, (_name_in(e, arrays) for e in expressions_of(s)))
    named: Any = s
    comment = ", ".join(dict.fromkeys(found))
    return replace(named, comment=comment) if comment else s


def _name_in(e: ex.Expression, arrays: frozenset[ex.Store]) -> str:
    """What the source calls a signal, a clock or a variable whose number alone the translation has."""
    if type(e) is ex.Variable:
        return e.name if e.store in arrays else ""
    return e.name if type(e) is ex.Signal else e.comment if type(e) is ex.SystemValue else ""


@dataclass(slots=True)
class _Signals:
    work: TranslationContext
    numbers: dict[tuple[str, str], int] = field(default_factory=dict)
    taken: dict[str, set[int]] = field(default_factory=dict)
    groups: dict[tuple[str, str], st.Declare] = field(
        default_factory=dict
    )  # by bus and number or name in the source
    from_zero: bool = False  # the source has signals with the number 0, and the target none
    refused: str = ""  # a signal of the statement under way that the target does not have

    def keep_numbers(self, program: st.Program) -> None:
        """The numbers that signals have already, as long as one of them has none that the target has."""
        numbers = {
            (e.bus, int(e.index.value))
            for s in program.statements()
            if type(s) is not st.Move or s.has_signals
            for e in expressions_of(s)
            if type(e) is ex.Signal and isinstance(e.index, ex.Number)
        }
        if not all(self._exists(bus, number) for bus, number in numbers):
            for bus, number in numbers:
                self.taken.setdefault(bus, set()).add(number)

    def _exists(self, bus: str, number: int) -> bool:
        """Whether the target has a signal of this number."""
        return self.work.limits.first_signal <= number <= self.work.limits.last_signals.get(bus, math.inf)

    def note(self, program: st.Program) -> None:
        """Gives numbers to names: those that show a number keep it, all others get the numbers after them."""
        names: list[tuple[str, str]] = []
        for s in program.statements():
            for e in expressions_of(s) if type(s) is not st.Move or s.has_signals else ():
                if (
                    type(e) is ex.Signal
                    and isinstance(e.index, ex.Text)
                    and (e.bus, e.index.value) not in names
                ):
                    names.append((e.bus, e.index.value))
        for bus, name in names:
            digits = re.search(r"(\d+)\D*$", name)
            number = int(digits[1]) if digits else 0
            if number and self._exists(bus, number) and number not in self.taken.setdefault(bus, set()):
                self._take(bus, name, number)

    def _take(self, bus: str, name: str, number: int) -> None:
        self.numbers[(bus, name)] = number
        self.taken.setdefault(bus, set()).add(number)

    def statement(self, s: st.Statement) -> st.Statement:
        if type(s) is st.Move and not s.has_signals:
            return s
        if any(type(e) is ex.Signal and "analog" in e.bus for e in expressions_of(s)):
            self._tell_analog(s)
        if bus := _beside_named(self.work, s):
            self.work.lose(s, Fate.REFUSED, "signal", f"{_BESIDE_OTHERS} ({bus})")
            return s
        if self.from_zero and any(map(_is_computed, expressions_of(s))):
            self.work.lose(s, Fate.APPROXIMATED, "index", _FROM_ZERO)
        if isinstance(s, (st.SetOutput, st.PulseOutput)) and "in" in s.signal.bus.split("-"):
            self.work.lose(s, Fate.REFUSED, "signal", "an input that is set")
            return s
        s = mapped(s, self.change)
        if self.refused:
            help = "map it under [signals] in the mapping file, or set or read its signals one by one"
            self.work.lose(s, Fate.REFUSED, "signal", self.refused, help=help)
            self.refused = ""
        if self.work.target_conventions.group_sizes:
            self._tell_group(s)
        return s

    def _tell_analog(self, s: st.Statement) -> None:
        """Tells that an analog signal keeps its number, which another controller takes for another voltage."""
        here, there = self.work.conventions.analog_values, self.work.target_conventions.analog_values
        says = (
            f"the value of an analog signal is {here} in {language_of(self.work.source.vendor)} and {there} in "
            f"{language_of(self.work.target)}: it is written as it is, scale it"
        )
        self.work.lose(s, Fate.APPROXIMATED, "value", says)

    def change(self, e: ex.Expression) -> ex.Expression:
        if type(e) is ex.Function and e.name == NUMBER:
            held = e.arguments[0]
            return held.index if isinstance(held, ex.Signal) else held
        if type(e) is not ex.Signal:
            return e
        if e.bus in self.work.conventions.counted_signals and self.work.source.vendor != self.work.target:
            e = replace(e, bus=plain_bus(e.bus))
        shown = self._shown(e)
        wanted = self.work.context.mapping.signals.get(f"{e.bus} {shown}") if shown else None
        if wanted is not None:
            self.work.names[("signal", f"{e.bus} {shown}")] = wanted
            bus, _, index = wanted.rpartition(" ")
            return replace(
                e, bus=bus or e.bus, index=ex.Number(int(index)) if index.isdecimal() else ex.Text(index)
            )
        if self.work.limits.spare_signals and self._is_beside(e.bus) and not isinstance(e.index, ex.Text):
            return self._beside(e, shown)
        if self.work.limits.declared_groups and shown and e.bus in _GROUPS:
            ends = self._declared(shown)
            if ends is not None:
                return self._group(e, shown, ends)
            size = self.work.conventions.group_sizes.get(e.bus)
            if size is None:
                return self._free_group(e, shown)
            if isinstance(e.index, ex.Number) and e.index.value >= 1:
                return self._group(e, shown, ((int(shown) - 1) * size + 1, int(shown) * size))
        if shown and e.bus in self.work.target_conventions.group_sizes:
            return self._sized_group(e, shown)
        if shown and e.bus in _GROUPS:
            self._tell_ends(e, shown)
        if self.work.target_conventions.controller_names and isinstance(e.index, ex.Number):
            name = f"{stem_of(e.bus)}{int(e.index.value)}"
            self.work.names[("signal", f"{e.bus} {shown}")] = name
            return replace(e, bus=plain_bus(e.bus), index=ex.Text(name))
        if isinstance(e.index, ex.Number) and not self._exists(e.bus, int(e.index.value)):
            return self._counted_on(replace(e, index=ex.Number(self._number(e.bus, shown))), shown)
        if not self.work.target_conventions.controller_names and isinstance(e.index, ex.Text):
            return self._counted_on(replace(e, index=ex.Number(self._number(e.bus, e.index.value))), shown)
        return self._counted_on(e, shown)

    def _counted_on(self, e: ex.Signal, shown: str) -> ex.Signal:
        """The same signal where the target counts some of these anew: its configurable ones, those of its tool."""
        if type(e.index) is ex.Text or e.bus not in self.work.limits.further_signals:
            return e
        if type(e.index) is not ex.Number:
            for n in range(self.work.limits.last_signals[e.bus] + 1):
                self._counted_on(replace(e, index=ex.Number(n)), str(n))
            return replace(e, bus=f"counted-{e.bus}")
        number = int(e.index.value)
        first, bus = next(
            ((n, bus) for n, bus in self.work.limits.further_signals.get(e.bus, ()) if number >= n), (0, "")
        )
        if not bus:
            return e
        self.work.names[("signal", f"{e.bus} {shown}")] = f"{bus} {number - first}"
        return replace(e, bus=bus, index=ex.Number(number - first))

    def _is_beside(self, bus: str) -> bool:
        return bus in _BESIDE and bus not in self.work.limits.own_signals

    def _beside(self, e: ex.Signal, shown: str) -> ex.Signal:
        """A signal of a kind that the target lacks, among the usual ones."""
        first = self.work.limits.spare_signals + SPARE_SIGNALS * _BESIDE[e.bus]
        there = plain_bus(e.bus)
        index = ex.Number(first + int(shown)) if shown else ex.Binary("+", ex.Number(first), e.index)
        to = f"{there} {first + int(shown)}" if shown else f"{there} {first}+*"
        self.work.names[("signal", f"{e.bus} {shown or '*'}")] = to
        says = (
            "connect these signals with their new numbers, or give others under [signals] in the mapping file"
        )
        self.work.ask(says, f"{e.bus} {shown or '*'} is {to}")
        return replace(e, bus=there, index=index)

    def _declared(self, name: str) -> tuple[int, int] | None:
        """The first and last signal of a group that the source declares."""
        source = self.work.source
        local = (s for s in source.statements() if isinstance(s, st.Declare))
        for d in (*source.data, *local) if source.vendor != self.work.target else ():
            value = d.value if d.name.casefold() == name.casefold() else None
            if isinstance(value, ex.RecordLiteral) and value.type == _DECLARED and len(value.members) == 2:
                ends = [e.index for _, e in value.members if isinstance(e, ex.Signal)]
                numbers = [int(end.value) for end in ends if isinstance(end, ex.Number)]
                return (numbers[0], numbers[1]) if len(numbers) == 2 else None
        return None

    def _tell_ends(self, e: ex.Signal, shown: str) -> None:
        """What a group consists of, where the configuration of the target says it and no program."""
        if (ends := self._declared(shown)) is not None:
            way = e.bus.partition("-")[0]
            says = "configure these groups with the signals of the source"
            self.work.ask(says, f"{e.bus} {shown} is {way} {ends[0]} to {ends[1]}")

    def _sized_group(self, e: ex.Signal, shown: str) -> ex.Signal:
        """A group where the target has groups of a size alone, one behind the other; those of others are refused."""
        ends, sizes = self._declared(shown), self.work.target_conventions.group_sizes
        if ends is None:
            name = f"{e.bus} {shown}"
            self.work.ask(f"see that these groups have {sizes[e.bus]} signals, as all have there", name)
            return (
                e
                if isinstance(e.index, ex.Number) and e.index.value >= 1
                else replace(e, index=ex.Number(self._number(e.bus, shown)))
            )
        first, size = ends[0], ends[1] - ends[0] + 1
        for bus, count in sizes.items():
            if count == size and bus.partition("-")[0] == e.bus.partition("-")[0] and first % size == 1:
                self.work.names[("signal", f"{e.bus} {shown}")] = f"{bus} {first // size + 1}"
                return replace(e, bus=bus, index=ex.Number(first // size + 1))
        self.refused = f"the {e.bus.replace('-', ' ')} {shown} of {size} signals from {first} on"
        return e

    def _tell_group(self, s: st.Statement) -> None:
        """Refuses numbers that the target's groups are too small for."""
        pairs: list[tuple[ex.Expression, ex.Expression]] = (
            [(s.signal, s.value)] if isinstance(s, st.SetOutput) else []
        )
        for e in expressions_of(s):
            if type(e) is ex.Compare:
                pairs += ((e.left, e.right), (e.right, e.left))
        for signal, value in pairs:
            size = (
                self.work.target_conventions.group_sizes.get(signal.bus)
                if type(signal) is ex.Signal
                else None
            )
            if size and type(value) is ex.Number and value.value >= 2**size:
                says = f"{value.value:g} in a group, which has {size} signals there"
                self.work.lose(s, Fate.REFUSED, "signal", says)

    def _free_group(self, e: ex.Signal, shown: str) -> ex.Signal:
        """Free signals for a group whose signals are not declared in any file at hand."""
        count = sum(bus == e.bus for bus, _ in self.groups if (e.bus, shown) != (bus, _))
        first = _FIRST_FREE + _FREE_SIZE * count
        known = (e.bus, shown) in self.groups
        found = self._group(e, shown, (first, first + _FREE_SIZE - 1))
        if not known:
            says = f"give these groups the signals that are wired: they are declared with {_FREE_SIZE} each"
            self.work.ask(says, f"{e.bus} {shown} from {first} on")
        return found

    def _group(self, e: ex.Signal, number: str, ends: tuple[int, int]) -> ex.Signal:
        """A group of signals that a declaration makes. `ends`: its first and last one."""
        bus, way = e.bus.replace("half-", ""), e.bus.partition("-")[0]
        declared = self.groups.get((e.bus, number))
        if declared is None:
            value = ex.RecordLiteral(_DECLARED, tuple(("", ex.Signal(way, ex.Number(end))) for end in ends))
            own = number if number.isidentifier() else f"{way.upper()}_{ends[0]}_{ends[1]}"
            name = own if self._declared(number) else self.work.fresh(own)
            declared = self.groups[(e.bus, number)] = st.Declare(
                0, name, "signal", value, storage="constant", native=_DECLARED
            )
        self.work.names[("signal", f"{e.bus} {number}")] = f"{bus} {declared.name}"
        return replace(e, bus=bus, index=ex.Text(declared.name))

    def _number(self, bus: str, name: str) -> int:
        known = self.numbers.get((bus, name))
        if known is None:
            taken = self.taken.setdefault(bus, set())
            last = self.work.limits.last_signals.get(bus, 100_000)
            free = (n for n in chain(range(1, last + 1), (0,)) if n not in taken and self._exists(bus, n))
            known = next(free, -1)
            if known < 0:
                self.refused = f"{bus} {name}, as all {last + 1} of these signals are taken"
                return 0
            self._take(bus, name, known)
            says = "give the numbers of these under [signals] in the mapping file; now they have free ones"
            self.work.ask(says, f"{bus} {name} is {known}")
        self.work.names[("signal", f"{bus} {name}")] = str(known)
        return known

    def _shown(self, e: ex.Signal) -> str:
        if isinstance(e.index, ex.Number):
            return str(int(e.index.value))
        return e.index.value if isinstance(e.index, ex.Text) else ""


# --- Move end actions ---

_MID: Final = "at the middle of the corner: written after the move"


def move_end_actions(program: st.Program, work: TranslationContext) -> st.Program:
    """Moves that set an output or call a routine at their end become a move and a statement behind it."""
    if work.conventions.actions_at_ends:
        for s in program.statements():
            if isinstance(s, st.Move) and len(split_at_end(s)) > 1:
                size = None if s.blend is None or s.blend.value is None else s.blend.value.literal
                if size is None or size > 0.0:
                    work.lose(s, Fate.APPROXIMATED, "end", f"{s.other[0][0]} acts {_MID}")
    return shown_at_ends(program)


# --- Pulses ---
# Pulses of outputs: how long one lasts that names no time, and which way it switches.

_INVERTS: Final = "a pulse that switches it on is written"


def pulses(program: st.Program, work: TranslationContext) -> st.Program:
    """Every pulse with its time, as each language takes another one where none is named; those to off are refused."""
    if not any(isinstance(s, st.PulseOutput) for s in work.rare(program)):
        return program
    own = work.conventions
    usual = own.usual_pulse
    on = {
        s.signal
        for s in program.statements()
        if isinstance(s, st.SetOutput) and s.value != ex.SignalState(False)
    }

    def pulse(s: st.Statement) -> st.Statement:
        if not isinstance(s, st.PulseOutput):
            return s
        if own.off_pulse and s.spelling == own.off_pulse:
            work.lose(s, Fate.REFUSED, "statement", "a pulse that switches an output off, or may do so")
        if own.on_pulse and s.spelling != own.on_pulse:
            says = f"{own.inverting_pulse}: {_INVERTS}"
            if s.signal in on:
                work.lose(
                    s, Fate.APPROXIMATED, "option", f"{says}, and the program switches the output on, too"
                )
            else:
                work.note_at(s, says)
        lasts = s.duration.literal if s.duration is not None else usual or None
        longest = work.limits.longest_pulse
        if longest and lasts is not None and lasts > longest:
            says = f"a pulse of {lasts:g} s: {longest:g} s is the longest one"
            help = "set the output, wait and reset it, or --on-loss comment writes it as a comment"
            work.lose(s, Fate.REFUSED, "statement", says, help=help)
        elif lasts is not None and 0.0 < lasts < work.limits.shortest_pulse:
            shortest = work.limits.shortest_pulse
            says = f"a pulse of {lasts:g} s: {shortest:g} s is the shortest one"
            work.lose(s, Fate.APPROXIMATED, "duration", says, shortest - lasts, "s")
            return replace(s, duration=ex.Quantity(ex.Number(shortest), 1.0))
        elif longest and lasts is None:
            work.note_at(s, f"a pulse that is computed must not last longer than {longest:g} s")
        if work.limits.pulse_note:
            work.note_at(s, work.limits.pulse_note)
        if s.duration is not None or not usual:
            return s
        if own.pulse_setting:
            work.lose(s, Fate.APPROXIMATED, "duration", own.pulse_setting)
        return replace(s, duration=ex.Quantity(ex.Number(usual), 1.0))

    return replace(
        program,
        routines=tuple([replace(r, body=tuple([pulse(s) for s in r.body])) for r in program.routines]),
    )


# --- Times ---
# Waits that are longer or finer than the target's words can say.

_MOST_PARTS: Final = 20  # waits that stand for one; longer ones are refused


def long_waits(program: st.Program, work: TranslationContext) -> st.Program:
    """Waits that are too long for the target as several, those of conditions are refused; times in the target's steps.

    A wait of no time, which only stops the move before it, stays: the writer leaves it out.
    """
    longest, step = work.limits.longest_wait, work.limits.wait_step
    if not longest:
        return program

    def rounded(s: st.Statement, seconds: float) -> float:
        if not step:
            return seconds
        written = float(f"{max(round(seconds / step), 1) * step:.9g}")
        if not math.isclose(written, seconds, abs_tol=1e-9):
            says = f"rounded to {step:g} s"
            work.lose(s, Fate.APPROXIMATED, "duration", says, abs(written - seconds), "s")
            return written
        return seconds

    def rows(s: st.Statement) -> list[st.Statement]:
        if isinstance(s, st.PulseOutput) and s.duration is not None and s.duration.literal is not None:
            seconds = rounded(s, s.duration.literal)
            return [s if seconds == s.duration.literal else replace(s, duration=_seconds(seconds))]
        if isinstance(s, st.Wait) and s.timeout is not None:
            return [wait(s, s.timeout)]
        return dwells(s) if isinstance(s, st.Dwell) else [s]

    def known(s: st.Statement, lasts: ex.Quantity) -> float | None:
        if lasts.literal is None:
            work.note_at(s, f"a wait that is computed must not last longer than {longest:g} s")
            return None
        return rounded(s, lasts.literal)

    def wait(s: st.Wait, lasts: ex.Quantity) -> st.Wait:
        seconds = known(s, lasts)
        if seconds is None or (seconds == lasts.literal and seconds <= longest):
            return s
        if seconds > longest:
            refuse(s, seconds)
            return s
        return replace(s, timeout=_seconds(seconds))

    def refuse(s: st.Statement, seconds: float) -> None:
        says = f"a wait of up to {seconds:g} s: {longest:g} s is the longest one"
        work.lose(s, Fate.REFUSED, "duration", says, help="wait in a loop, or --on-loss comment")

    def dwells(s: st.Dwell) -> list[st.Statement]:
        if step and s.duration.literal == 0.0:  # nothing of it is written, so that its comment stands alone
            return [replace(s, comment=""), st.Comment(s.line, s.comment)] if s.comment else [s]
        seconds = known(s, s.duration)
        if seconds is None or (seconds == s.duration.literal and seconds <= longest):
            return [s]
        count = math.ceil(seconds / longest)
        if count > _MOST_PARTS:
            refuse(s, seconds)
            return [s]
        parts = [longest] * (count - 1) + [seconds - longest * (count - 1)]
        return [replace(s, duration=_seconds(part)) for part in parts]

    routines = [replace(r, body=tuple([row for s in r.body for row in rows(s)])) for r in program.routines]
    return replace(program, routines=tuple(routines))


def _seconds(value: float) -> ex.Quantity:
    return ex.Quantity(ex.Number(value), 1.0)


_INDEX: Final = "number"


def signal_aliases(program: st.Program, work: TranslationContext) -> st.Program:
    """Every signal with a computed number as the one whose name ends with that number."""
    if work.conventions.controller_names or not work.target_conventions.controller_names:
        return program
    symbols = work.symbols(program)
    own = _Aliases(work)
    routines = [
        own.routine(_with_constant_signals(routine, work.look(routine), symbols))
        for routine in program.routines
    ]
    if routines == list(program.routines):
        return program
    readers = [own.reader(bus, name) for bus, name in own.readers.items()]
    declares = [st.Declare(0, name, f"signal {_kind(bus)}") for (bus, _), name in own.variables.items()]
    return replace(program, routines=(*routines, *readers), data=(*program.data, *declares))


def _with_constant_signals(routine: st.Routine, look: Look, symbols: Symbols) -> st.Routine:
    """Signals whose number is a constant (`$OUT[gripper]`) as those of that number."""

    def change(e: ex.Expression) -> ex.Expression:
        if not isinstance(e, ex.Signal) or type(e.index) is not ex.Named:
            return e
        symbol = symbols.find(routine.name, e.index.name)
        if symbol is None or symbol.storage != "constant":
            return e
        number = symbols.fixed_value(routine.name, e.index)
        return replace(e, index=number) if isinstance(number, ex.Number) else e

    return changed_rare(routine, look, lambda s: mapped(s, change))


def _counts_from_zero(vendor: str) -> bool:
    return vendor in writable() and not limits_of(vendor).first_signal


def _beside_named(work: TranslationContext, s: st.Statement) -> str:
    """The bus of a signal with a computed number whose others the mapping file puts elsewhere, one by one."""
    named = work.context.mapping.signals
    if not named or not work.limits.spare_signals:
        return ""
    buses = (e.bus for e in expressions_of(s) if isinstance(e, ex.Signal) and _is_computed(e))
    return next(
        (
            b
            for b in buses
            if b in _BESIDE.keys() - work.limits.own_signals and any(key.startswith(f"{b} ") for key in named)
        ),
        "",
    )


def _kind(bus: str) -> str:
    """What a variable for a signal is declared as: registers are groups of outputs."""
    plain = plain_bus(bus)
    if not {"in", "out"}.isdisjoint(plain.split("-")):
        return plain
    return "out-group" if holds_number(bus) else "out"


def _is_computed(e: ex.Expression) -> bool:
    return isinstance(e, ex.Signal) and not isinstance(e.index, (ex.Number, ex.Text))


@dataclass(slots=True)
class _Aliases:
    work: TranslationContext
    variables: dict[tuple[str, int], str] = field(
        default_factory=dict
    )  # (bus, which one of a statement) -> name
    readers: dict[str, str] = field(default_factory=dict)  # bus -> the routine that reads a signal of it

    def routine(self, routine: st.Routine) -> st.Routine:
        return with_rare_rows(routine, self.work.look(routine), self._rows)

    def _rows(self, s: st.Statement) -> list[st.Statement]:
        return self._statement(s) if any(map(_is_computed, expressions_of(s))) else [s]

    def _statement(self, s: st.Statement) -> list[st.Statement]:
        signals = [e for e in expressions_of(s) if isinstance(e, ex.Signal) and _is_computed(e)]
        renamed = self.work.context.mapping.signals
        if bus := next((e.bus for e in signals if any(k.startswith(f"{e.bus} ") for k in renamed)), ""):
            self.work.lose(s, Fate.REFUSED, "signal", f"{_BESIDE_OTHERS} ({bus})")
            return [s]
        for e in signals:
            self.work.names[("signal", f"{e.bus} *")] = f"{stem_of(e.bus)}*"
        before: list[st.Statement] = []
        stand: dict[ex.Signal, ex.Signal] = {}
        if isinstance(s, (st.SetOutput, st.PulseOutput, st.ReadInput)):
            self._stand(s.signal, s.line, stand, before)
        elif isinstance(s, st.Wait):
            for e in dict.fromkeys(signals):
                self._stand(e, s.line, stand, before)

        def change(e: ex.Expression) -> ex.Expression:
            if isinstance(e, ex.Signal) and _is_computed(e):
                return stand.get(e) or self._read(e)
            return _shorter(e, self.readers)

        return [*before, mapped(s, change)]

    def _stand(
        self, e: ex.Signal, line: int, stand: dict[ex.Signal, ex.Signal], before: list[st.Statement]
    ) -> None:
        """A variable for a signal of one statement, and what makes it stand for it."""
        if not _is_computed(e):
            return
        key = (e.bus, sum(one.bus == e.bus for one in stand) + 1)
        name = self.variables.get(key)
        if name is None:
            name = self.variables[key] = self.work.helper(f"signal_{stem_of(e.bus)}")
        stand[e] = replace(e, bus=plain_bus(e.bus), index=ex.Named(name))
        before.append(st.Assign(line, ex.Named(name), _called(e.bus, e.index)))

    def _read(self, e: ex.Signal) -> ex.Expression:
        name = self.readers.get(e.bus)
        if name is None:
            name = self.readers[e.bus] = self.work.helper(f"read_{stem_of(e.bus)}")
        return ex.CallValue(name, (e.index,))

    def reader(self, bus: str, name: str) -> st.Routine:
        """The routine that reads a signal by its number: a state, or the number that a group carries."""
        variable = ex.Named(
            self.variables.setdefault((bus, 0), self.work.helper(f"read_{stem_of(bus)}_signal"))
        )
        signal = ex.Signal(plain_bus(bus), variable)
        value: ex.Expression = signal if holds_number(bus) else ex.Compare("=", signal, ex.SignalState(True))
        body = (
            st.Begin(0),
            st.Assign(0, variable, _called(bus, ex.Named(_INDEX))),
            st.Return(0, value),
            st.End(0),
        )
        returns = "real" if holds_number(bus) else "boolean"
        parameters = (st.Parameter(_INDEX, "integer"),)
        return st.Routine(name, 0, body, PointTable(), parameters=parameters, returns=returns, shared=False)


def _called(bus: str, number: ex.Expression) -> ex.Expression:
    """The name of the signal with a number."""
    return ex.Function(
        "joined-text", (ex.Text(stem_of(bus)), ex.Function("text-of-value", (number, ex.Number(0))))
    )


def _shorter(e: ex.Expression, readers: dict[str, str]) -> ex.Expression:
    """A state that was compared with on or off: what the routine returns."""
    if not isinstance(e, ex.Compare) or e.operator not in ("=", "<>"):
        return e
    for one, other in ((e.left, e.right), (e.right, e.left)):
        if (
            isinstance(one, ex.CallValue)
            and one.routine in readers.values()
            and isinstance(other, ex.SignalState)
        ):
            return one if other.on == (e.operator == "=") else ex.Unary("not", one)
    return e
