"""Integer inference: variables that hold whole values only become integers where a language counts with integers.

Other indices are rounded. RAPID has one type for both, URScript none that is written. A counter that its FOR loop
declares (RAPID) becomes a variable of the routine; one that it hides keeps the value that it had before the loop.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Set
from dataclasses import dataclass, field, replace
from typing import Any, Final

from olp.ir import expressions as ex
from olp.ir import program as st
from olp.ir.block_structure import Block, Node, parse
from olp.ir.transformer import calls_nothing, expressions_of, mapped, note_names, sets_numbers
from olp.languages.vendor import conventions_of, language_of
from olp.runtime.assumptions import holds_number
from olp.transpile.context import Fate, TranslationContext
from olp.transpile.occurrences import with_routines, with_rows
from olp.transpile.shared_variables import handed_over, paired
from olp.transpile.symbols import Symbol, Symbols, base_of, kind_of_value, symbols_of

_ROUNDED: Final = frozenset({"round", "trunc", "floor", "ceil"})
_COUNTED: Final = (ex.Variable, ex.Named, ex.Binary, ex.Item)
_WHOLE_DIVISION: Final = ("div", "mod")
_HEADS: Final = (st.While, st.Until, st.ElseIf, st.Case)  # before which nothing can run each time
Key = tuple[str, str]  # routine ("" for the whole program), name


def whole_numbers(program: st.Program, work: TranslationContext) -> st.Program:
    """Where loops and indices need integers: every counter and every index one."""
    if not work.limits.integer_type:
        return program
    program = _alike_by_reference(program, work)
    if not _counts(program, work):
        return program
    symbols = symbols_of(program)
    held = _Held(symbols)
    wanted = {key for routine in program.routines for key in _wanted(symbols, routine)}
    if wanted:
        for routine in program.routines:
            held.note(routine)
        unset = held.unset(work.registers)
        whole = wanted & held.whole(unset - wanted)
        for _, name in sorted(whole):  # those that the program sets before it reads them are integers already
            if name in work.registers:
                work.ask("see that these hold whole numbers when it starts", name)
        program = _retyped(program, whole)
    return _rounded(program, work)


class WholeValues:
    """Which values of a program are whole numbers, whatever way it takes, and are computed as such (no 2.0, no 6/2)."""

    def __init__(self, program: st.Program, registers: Set[str]) -> None:
        self._held = _Held(symbols_of(program), written=True)
        for routine in program.routines:
            self._held.note(routine)
        self._whole = self._held.whole(self._held.unset(registers))

    def holds(self, routine: str, e: ex.Expression) -> bool:
        """Whether an expression of a routine is such a value."""
        return self._held._is_whole(routine, e, self._whole)


def remainders(program: st.Program, work: TranslationContext) -> st.Program:
    """Tells where a remainder of what may be below zero is taken: no manual says which sign it has."""
    found = [
        (routine.name, s, e)
        for routine in program.routines
        for _, s in work.look(routine).rare
        for e in expressions_of(s)
        if type(e) is ex.Binary and e.operator == "mod"
    ]
    if not found or work.source.vendor == work.target:
        return program
    held = _Held(symbols_of(program))
    for routine in program.routines:
        held.note(routine)
    above = held.not_negative(work.registers)
    says = "of numbers below zero the manuals do not say which sign MOD gives: taken as that of the number divided"
    told: set[int] = set()
    for name, s, e in found:
        safe = all(held._is_above(name, part, above) for part in (e.left, e.right))
        if not safe and s.line and s.line not in told:
            told.add(s.line)
            work.note_at(s, says)
    return program


def switching_fractions(program: st.Program, work: TranslationContext) -> st.Program:
    """Tells where a number that may be below 1 switches a signal: some controllers leave it off, others do not."""
    if not work.conventions.on_from_one or work.target_conventions.on_from_one:
        return program
    found = [
        (routine.name, s)
        for routine in program.routines
        for s in routine.body
        if type(s) is st.SetOutput and type(s.value) in _COUNTED and not holds_number(s.signal.bus)
    ]
    whole = WholeValues(program, work.registers) if found else None
    for name, s in found:
        if whole is not None and not whole.holds(name, s.value):
            says = "the number may be below 1: the source leaves the signal off then, here it is on unless it is 0"
            work.lose(s, Fate.APPROXIMATED, "value", says)
    return program


def _alike_by_reference(program: st.Program, work: TranslationContext) -> st.Program:
    """Whole numbers that stand for fractions in a call by reference as fractions: both sides are of one type."""
    takes = {r.name: r.parameters for r in program.routines if any(p.by_reference for p in r.parameters)}
    calls = [
        (r.name, name, given)
        for r in program.routines
        if takes
        for _, s in work.look(r).rare
        for name, given in handed_over(s)
        if name in takes
    ]
    while calls:
        symbols = symbols_of(program)
        wrong: set[Key] = set()
        for caller, name, given in calls:
            for parameter, value in paired(takes[name], given):
                base = base_of(value)
                one = symbols.find(name, parameter)
                other = symbols.find(caller, base.name) if isinstance(base, ex.Named) else None
                if one is None or one.parameter is None or not one.parameter.by_reference or other is None:
                    continue
                if {one.type, other.type} == {"integer", "real"}:
                    wrong |= {(symbol.scope, symbol.name) for symbol in (one, other)}
        if not wrong:
            break
        program = _retyped(program, wrong, "real")
    return program


def _counts(program: st.Program, work: TranslationContext) -> bool:
    """Whether there is a loop that counts, an index, or a whole quotient."""
    looks = [work.look(r) for r in program.routines]
    loops = any(type(s) in (st.For, st.Switch) for look in looks for _, s in look.rare)
    return loops or any(
        type(e) is ex.Item or _divides(e) or _rounds(e) or _number_of(e) is not None
        for look in looks
        for e in look.expressions
    )


def _number_of(e: ex.Expression) -> ex.Expression | None:
    """The computed number of a signal, a tool or a frame."""
    number = e.index if type(e) is ex.Signal else e.number if type(e) is ex.FrameRef else None
    return None if isinstance(number, (ex.Number, ex.Text)) else number


def _with_number(e: ex.Expression, number: ex.Expression) -> ex.Expression:
    """The signal, tool or frame with this number."""
    if isinstance(e, ex.Signal):
        return replace(e, index=number)
    return replace(e, number=number) if isinstance(e, ex.FrameRef) else e


def _rounds(e: ex.Expression) -> bool:
    return type(e) is ex.Function and e.name in ("round", "trunc")


def _divides(e: ex.Expression) -> bool:
    return type(e) is ex.Binary and e.operator in _WHOLE_DIVISION


def _key(symbols: Symbols, routine: str, e: ex.Expression | None) -> Key | None:
    """The declared number that an expression names."""
    symbol = symbols.find(routine, e.name) if type(e) is ex.Named else None
    return (symbol.scope, symbol.name) if symbol is not None and _is_number(symbol) else None


def _is_number(symbol: Symbol) -> bool:
    """Whether it may be an integer: a real number, or a constant of which only the value tells the type."""
    return symbol.type == "real" or (not symbol.type and isinstance(symbol.value, ex.Number))


def _wanted(symbols: Symbols, routine: st.Routine) -> Iterator[Key]:
    """Numbers that count a loop, are divided as whole ones, or of which an index is computed."""
    for s in routine.body:
        if calls_nothing(s) or sets_numbers(s):
            continue
        found: list[ex.Expression | None] = [s.variable, s.start, s.stop, s.step] if type(s) is st.For else []
        found += [s.value] if type(s) is st.Switch else []
        found += [index for e in expressions_of(s) if type(e) is ex.Item for index in e.indices]
        found += [_number_of(e) for e in expressions_of(s)]
        found += [
            part
            for e in expressions_of(s)
            if isinstance(e, ex.Binary) and _divides(e)
            for part in (e.left, e.right)
        ]
        for part in found:
            for e in expressions_of(part) if part is not None else ():
                key = _key(symbols, routine.name, e)
                if key is not None:
                    yield key


@dataclass(slots=True)
class _Held:
    """`values`: what each number is set to, with the routine where that stands; None: nobody knows.

    `written`: a number that is written with decimals (2.0) counts as a fraction.
    """

    symbols: Symbols
    written: bool = False
    values: dict[Key, list[tuple[str, ex.Expression | None]]] = field(default_factory=dict)
    loops: dict[Key, list[tuple[str, st.For]]] = field(default_factory=dict)  # those that a number counts

    def _set(self, routine: str, target: ex.Expression | None, value: ex.Expression | None) -> None:
        key = self._key(routine, base_of(target))
        if key is not None:
            self.values.setdefault(key, []).append((routine, value))

    def note(self, routine: st.Routine) -> None:
        for s in routine.body:
            if calls_nothing(s) or sets_numbers(s):
                continue
            match s:
                case st.Assign(target=target, value=value):
                    self._set(routine.name, target, value)
                case st.Update(operator=operator, target=target, operand=operand):
                    self._set(
                        routine.name,
                        target,
                        None if operand is None else ex.Binary(operator, target, operand),
                    )
                case st.For(variable=variable, start=start):
                    self._set(routine.name, variable, start)
                    if (key := self._key(routine.name, variable)) is not None:
                        self.loops.setdefault(key, []).append((routine.name, s))
                case st.ReadInput(target=target, signal=signal):
                    self._set(routine.name, target, signal)
                case st.Clear(target=target):
                    self._set(routine.name, target, ex.Number(0))
                case st.Call(routine=name, arguments=arguments, result=result):
                    self._set(routine.name, result, None)
                    self._hand(routine.name, name, arguments)
            for e in expressions_of(s):
                if type(e) is ex.CallValue:
                    self._hand(routine.name, e.routine, e.arguments)

    def _hand(self, caller: str, name: str, arguments: tuple[ex.Expression, ...]) -> None:
        called = self.symbols.routines.get(name)
        if called is None:  # nobody knows what it does with its arguments
            for given in arguments:
                self._set(caller, given.value if isinstance(given, ex.NamedArgument) else given, None)
            return
        by_name = {p.name: p for p in called.parameters}
        for parameter, value in paired(called.parameters, arguments):
            self._set(called.name, ex.Named(parameter), None)  # other files may hand it a fraction
            if by_name[parameter].by_reference:
                self._set(caller, value, None)

    def unset(self, registers: Set[str]) -> set[Key]:
        """Registers that other programs set, or an operator, and this one never does."""
        return {
            key
            for symbol in self.symbols
            if symbol.name in registers and (key := (symbol.scope, symbol.name)) not in self.values
        }

    def whole(self, unknown: Set[Key]) -> set[Key]:
        """Numbers that never hold a fraction, whatever way the program takes. `unknown`: those that may hold one."""
        numbers = [symbol for symbol in self.symbols if _is_number(symbol) and symbol.parameter is None]
        kept = {(symbol.scope, symbol.name) for symbol in numbers} - unknown
        for symbol in numbers:
            if symbol.value is not None:
                self.values.setdefault((symbol.scope, symbol.name), []).append((symbol.scope, symbol.value))
        while True:
            left = {
                key
                for key in kept
                if all(self._is_whole(r, e, kept) for r, e in self.values.get(key, ()))
                and all(s.step is None or self._is_whole(r, s.step, kept) for r, s in self.loops.get(key, ()))
            }
            if left == kept:
                return kept
            kept = left

    def not_negative(self, registers: Set[str]) -> set[Key]:
        """Numbers that are never below zero, whatever way the program takes. `registers`: others set these, too."""
        numbers = [
            symbol
            for symbol in self.symbols
            if symbol.type in ("real", "integer") and symbol.parameter is None and not symbol.sizes
        ]
        begins = {(symbol.scope, symbol.name): symbol.value for symbol in numbers}
        kept = {key for key in begins if key[1] not in registers}
        while True:
            left = {
                key
                for key in kept
                if (begins[key] is None or self._is_above(key[0], begins[key], kept))
                and all(self._is_above(r, e, kept) for r, e in self.values.get(key, ()))
                and all(self._is_above(r, s.stop, kept) for r, s in self.loops.get(key, ()))
            }
            if left == kept:
                return kept
            kept = left

    def _is_above(self, routine: str, e: ex.Expression | None, kept: Set[Key]) -> bool:
        """Whether a value is zero or above it, where the variables `kept` are."""
        match e:
            case ex.Number(value):
                return value >= 0
            case ex.Binary("+" | "*" | "/" | "div", left, right):
                return self._is_above(routine, left, kept) and self._is_above(routine, right, kept)
            case ex.Binary("mod", left, _):
                return self._is_above(routine, left, kept)
            case ex.Function("abs" | "sqrt" | "text-length" | "size-of-array"):
                return True
            case ex.Function(name, (one, *_)) if name in _ROUNDED:
                return self._is_above(routine, one, kept)
            case ex.Signal(bus):
                return not bus.startswith("analog")
        key = self._key(routine, e)
        return key is not None and key in kept

    def _key(self, routine: str, e: ex.Expression | None) -> Key | None:
        symbol = self.symbols.find(routine, e.name) if type(e) is ex.Named else None
        return None if symbol is None else (symbol.scope, symbol.name)

    def _is_whole(self, routine: str, e: ex.Expression | None, whole: set[Key]) -> bool:
        match e:
            case ex.Number(value):
                return isinstance(value, int) if self.written else float(value).is_integer()
            case ex.Unary("-", operand):
                return self._is_whole(routine, operand, whole)
            case ex.Binary("div" | "mod" | "and" | "or" | "xor"):
                return True
            case ex.Binary("+" | "-" | "*", left, right):
                return self._is_whole(routine, left, whole) and self._is_whole(routine, right, whole)
            case ex.Function(name) if name in _ROUNDED:
                return True
            case ex.Signal(bus):
                return "analog" not in bus
            case ex.RecordLiteral(_, members):
                return all(not name and self._is_whole(routine, one, whole) for name, one in members)
        key = _key(self.symbols, routine, e)
        return key in whole if key is not None else kind_of_value(self.symbols, routine, e) == "integer"


def _retyped(program: st.Program, keys: set[Key], kind: str = "integer") -> st.Program:
    """These numbers as integers, or of another kind, where they are declared."""
    if not keys:
        return program

    def declare(scope: str, s: st.Declare) -> st.Declare:
        if ("" if s.shared else scope, s.name) not in keys:
            return s
        value = s.value
        if isinstance(value, ex.Number) and kind == "integer":
            value = ex.Number(int(value.value))
        return replace(s, type=kind, native="" if kind == "real" else s.native, value=value)

    def row(scope: str, s: st.Statement) -> st.Statement:
        return declare(scope, s) if isinstance(s, st.Declare) else s

    routines = tuple(
        replace(
            r,
            parameters=tuple(replace(p, type=kind) if (r.name, p.name) in keys else p for p in r.parameters),
            body=tuple([row(r.name, s) for s in r.body]),
            data=tuple(declare(r.name, d) for d in r.data),
        )
        for r in program.routines
    )
    return replace(program, routines=routines, data=tuple(declare("", d) for d in program.data))


# --- indices that may be fractions --------------------------------------------------------------------------


def _rounded(program: st.Program, work: TranslationContext) -> st.Program:
    """An index that is no integer goes into one before the statement, which rounds it."""
    symbols = symbols_of(program)
    own = _Rounding(symbols, work)
    return replace(program, routines=tuple(map(own.routine, program.routines)))


# A whole number less this is rounded to itself, also where numbers have seven digits and there are thousands.
NEARLY_HALF: Final = 0.499


def _known_step(s: st.For) -> float:
    """By how much a loop counts; 0 where that is computed."""
    if s.step is None:
        return 1.0
    return float(s.step.value) if isinstance(s.step, ex.Number) else 0.0


@dataclass(slots=True)
class _Rounding:
    symbols: Symbols
    work: TranslationContext
    names: list[str] = field(default_factory=list)  # of integers, which each routine has for itself
    made: dict[str, None] = field(
        default_factory=dict
    )  # those of the routine under way, and of bounds of its loops
    used: int = 0  # integers of the statement under way

    @property
    def language(self) -> str:
        return language_of(self.work.target)

    @property
    def integers(self) -> str:
        """What the target calls its integers."""
        return self.work.limits.integer_type

    def routine(self, r: st.Routine) -> st.Routine:
        """A routine with integers of its own: one that it calls between two statements would change shared ones."""
        self.made = {}
        rows = self.rows(r)
        declared = [st.Declare(r.line, name, "integer", None) for name in self.made]
        head = 1 if rows and type(rows[0]) is st.Begin else 0
        return replace(r, body=(*rows[:head], *declared, *rows[head:]))

    def rows(self, routine: st.Routine) -> list[st.Statement]:
        rows: list[st.Statement] = []
        for s in routine.body:
            if calls_nothing(s) or sets_numbers(s):
                rows.append(s)
                continue
            before: list[st.Statement] = []
            self.used = 0
            if type(s) is st.For:
                s = self._counted(routine.name, s, before)
            elif type(s) is st.Switch and kind_of_value(self.symbols, routine.name, s.value) == "real":
                says = (
                    f"what chooses may be a fraction, which is rounded: {self.language} has {self.integers}"
                )
                s = replace(s, value=self._whole(s.value, s, before, says))

            def change(
                e: ex.Expression, s: st.Statement = s, before: list[st.Statement] = before
            ) -> ex.Expression:
                if isinstance(e, ex.Function) and _rounds(e) and len(e.arguments) == 1:
                    return self._function(e, s, before)
                if isinstance(e, ex.Binary) and _divides(e):
                    left, right = (self._operand(routine.name, part, s, before) for part in (e.left, e.right))
                    return ex.Binary(e.operator, left, right)
                if (number := _number_of(e)) is not None:
                    number = self._index(routine.name, number, s, before)
                    return _with_number(e, number)
                if type(e) is not ex.Item or not self._is_array(routine.name, e.base):
                    return e
                indices = tuple(self._index(routine.name, index, s, before) for index in e.indices)
                return e if indices == e.indices else ex.Item(e.base, indices)

            changed = mapped(s, change)
            rows += [*before, changed]
        return rows

    def _counted(self, routine: str, s: st.For, before: list[st.Statement]) -> st.For:
        """A loop with bounds that are whole numbers."""
        if kind_of_value(self.symbols, routine, s.variable) != "integer":
            self.work.lose(
                s,
                Fate.REFUSED,
                "loop",
                f"{self.language} counts loops with {self.integers}, and this one may count fractions",
            )
            return s
        bounds: dict[str, Any] = {}
        for part in ("start", "stop", "step"):
            e = getattr(s, part)
            if e is None or self._is_integer(routine, e):
                continue
            name = ex.Named(self.work.helper("whole_bound"))
            self.made[name.name] = None
            bounds[part] = name
            if part == "stop" and (step := _known_step(s)):
                # Whole numbers up to a fraction are those up to what it is rounded to towards the beginning.
                e = ex.Binary("-" if step > 0 else "+", e, ex.Number(NEARLY_HALF))
            else:
                says = f"a bound of a loop that may be a fraction is rounded: {self.language} has {self.integers}"
                self.work.lose(s, Fate.APPROXIMATED, "loop", says)
            before.append(st.Assign(s.line, name, e))
        return replace(s, **bounds) if bounds else s

    def _is_integer(self, routine: str, e: ex.Expression) -> bool:
        return (isinstance(e, ex.Number) and float(e.value).is_integer()) or kind_of_value(
            self.symbols, routine, e
        ) == "integer"

    def _is_array(self, routine: str, base: ex.Expression) -> bool:
        symbol = self.symbols.find(routine, base.name) if type(base) is ex.Named else None
        return symbol is not None and bool(symbol.sizes)

    def _index(
        self, routine: str, e: ex.Expression, s: st.Statement, before: list[st.Statement]
    ) -> ex.Expression:
        if type(e) is ex.Number and float(e.value).is_integer():
            return ex.Number(int(e.value))
        if self._is_integer(routine, e):
            return e
        if isinstance(s, _HEADS):
            says = "an index that may be a fraction, in a condition before which nothing can round it"
            self.work.lose(s, Fate.REFUSED, "index", says)
            return e
        says = f"an index that may be a fraction is rounded: {self.language} has {self.integers}"
        return self._whole(e, s, before, says)

    def _function(self, e: ex.Function, s: st.Statement, before: list[st.Statement]) -> ex.Expression:
        """An integer that takes the number before the statement, which rounds it; cut, one less where that went up."""
        if not self.work.limits.has_integers or isinstance(s, _HEADS):
            return e
        kept, (number,) = self._whole(e.arguments[0], s, before), e.arguments
        if e.name == "trunc":
            for sign, beyond in (("-", ">"), ("+", "<")):
                ahead = ex.Logic(
                    ex.Compare(beyond, kept, number), (("and", ex.Compare(beyond, kept, ex.Number(0))),)
                )
                before += [
                    st.If(s.line, ahead),
                    st.Assign(s.line, kept, ex.Binary(sign, kept, ex.Number(1))),
                    st.EndIf(s.line),
                ]
        return kept

    def _operand(
        self, routine: str, e: ex.Expression, s: st.Statement, before: list[st.Statement]
    ) -> ex.Expression:
        if type(e) is ex.Number and float(e.value).is_integer():
            return ex.Number(int(e.value))
        if self._is_integer(routine, e) or isinstance(s, _HEADS):
            return e
        says = f"what is divided may be a fraction, which is rounded: {self.language} has {self.integers}"
        return self._whole(e, s, before, says)

    def _whole(
        self, e: ex.Expression, s: st.Statement, before: list[st.Statement], says: str = ""
    ) -> ex.Named:
        """A variable that takes the value before the statement, rounded, which is told by `says`."""
        self.used += 1
        if self.used > len(self.names):
            self.names.append(self.work.helper("whole_index"))
        kept = ex.Named(self.names[self.used - 1])
        self.made[kept.name] = None
        before.append(st.Assign(s.line, kept, e))
        if says:
            self.work.lose(s, Fate.APPROXIMATED, "index", says)
        return kept


def loop_counters(program: st.Program, work: TranslationContext) -> st.Program:
    """Every counter declared in its routine, under another name where it hides a variable that is used there."""
    if not conventions_of(program.vendor).for_declares:
        return program
    if conventions_of(program.vendor).for_turns:
        program = _with_steps(program, work)
    shared = {d.name for d in program.data}
    routines = tuple(_counted(routine, shared, work) for routine in program.routines)
    return replace(program, routines=routines)


def _with_steps(program: st.Program, work: TranslationContext) -> st.Program:
    """Loops that count down without saying so, with a step; told where nobody knows which way one counts."""
    symbols = work.symbols(program)

    def stepped(s: st.Statement, routine: str) -> st.Statement:
        if type(s) is not st.For or s.step is not None:
            return s
        start, stop = (symbols.fixed_value(routine, e) for e in (s.start, s.stop))
        if type(start) is ex.Number and type(stop) is ex.Number:
            return s if start.value <= stop.value else replace(s, step=ex.Number(-1))
        if start == ex.Number(1) and type(s.stop) is ex.Function and s.stop.name == "size-of-array":
            return s
        language = language_of(program.vendor)
        says = f"where it ends below its begin {language} counts down: there the loop is passed over"
        work.lose(s, Fate.APPROXIMATED, "step", says)
        return s

    routines = (with_rows(r, [stepped(s, r.name) for s in r.body]) for r in program.routines)
    return with_routines(program, routines)


def _counted(routine: st.Routine, shared: set[str], work: TranslationContext) -> st.Routine:
    if not any(type(s) is st.For for s in routine.body) or (nodes := parse(routine.body)) is None:
        return routine
    loops = [s for s in routine.body if type(s) is st.For and type(s.variable) is ex.Named]
    kinds = {(s.variable.name, counts_fractions(s)) for s in loops}  # type: ignore[union-attr]
    mixed = frozenset(name for name, fraction in kinds if fraction and (name, False) in kinds)
    routine = replace(routine, body=tuple(_apart(nodes, frozenset(), mixed, work)))
    counters = dict.fromkeys(
        s.variable.name for s in routine.body if type(s) is st.For and type(s.variable) is ex.Named
    )
    nodes = parse(routine.body) if counters else None
    if nodes is None:
        return routine
    given = {p.name for p in routine.parameters} | {d.name for d in routine.data}
    declared = {s.name for s in routine.body if type(s) is st.Declare}
    outside: set[str] = set()
    _note_outside(nodes, frozenset(), outside)
    hidden = {
        name: work.helper(name)
        for name in counters
        if name in given
        or (name in outside and name in declared)
        or (name in shared and name not in declared)
    }
    free = counters.keys() - hidden.keys()  # of a variable that does nothing else the name is left
    body = [s for s in _renamed(nodes, hidden) if not (type(s) is st.Declare and s.name in free)]
    fractions = {
        s.variable.name
        for s in routine.body
        if type(s) is st.For and type(s.variable) is ex.Named and counts_fractions(s)
    }
    rows = [
        st.Declare(0, hidden.get(name, name), "real" if name in fractions else "integer") for name in counters
    ]
    return replace(routine, body=(*rows, *body))


def _apart(
    nodes: Iterable[Node], counted: frozenset[str], mixed: frozenset[str], work: TranslationContext
) -> Iterable[st.Statement]:
    """The statements; a loop within a loop whose counter has the same name counts with one of its own.

    So does one that counts fractions where others of its name (`mixed`) count whole numbers.
    """
    for node in nodes:
        if not isinstance(node, Block):
            yield node
            continue
        opener = node.branches[0][0]
        name = opener.variable.name if type(opener) is st.For and type(opener.variable) is ex.Named else ""
        if isinstance(opener, st.For) and (name in counted or (name in mixed and counts_fractions(opener))):
            own = tuple(_loop(node, opener, name, {name: work.helper(name)}))
            yield from _apart(parse(own) or (), counted, mixed, work)
            continue
        for marker, inside in node.branches:
            yield marker
            yield from _apart(inside, counted | {name} if name else counted, mixed, work)
        yield node.closer


def _note_outside(nodes: Iterable[Node], counted: frozenset[str], found: set[str]) -> None:
    """Names that statements use outside of the loops that count them."""
    for node in nodes:
        if not isinstance(node, Block):
            if type(node) is not st.Declare:
                _note(node, counted, found)
            continue
        for marker, inside in node.branches:
            if type(marker) is st.For and type(marker.variable) is ex.Named:
                for bound in (marker.start, marker.stop, marker.step):
                    _note(bound, counted, found)
                _note_outside(inside, counted | {marker.variable.name}, found)
            else:
                _note(marker, counted, found)
                _note_outside(inside, counted, found)
        if type(node.closer) is not st.Next:
            _note(node.closer, counted, found)


def _note(part: st.Statement | ex.Expression | None, counted: frozenset[str], found: set[str]) -> None:
    if part is not None:
        names: set[str] = set()
        note_names(part, names)
        found |= names - counted


def _renamed(nodes: Iterable[Node], hidden: Mapping[str, str]) -> Iterable[st.Statement]:
    """The statements, with the names of `hidden` counters changed within their loops."""
    for node in nodes:
        if not isinstance(node, Block):
            yield node
            continue
        opener = node.branches[0][0]
        if type(opener) is st.For and type(opener.variable) is ex.Named and opener.variable.name in hidden:
            yield from _loop(node, opener, opener.variable.name, hidden)
            continue
        for marker, inside in node.branches:
            yield marker
            yield from _renamed(inside, hidden)
        yield node.closer


def _loop(node: Block, opener: st.For, name: str, hidden: Mapping[str, str]) -> Iterable[st.Statement]:
    def change(e: ex.Expression) -> ex.Expression:
        return ex.Named(hidden[name]) if type(e) is ex.Named and e.name == name else e

    yield replace(opener, variable=ex.Named(hidden[name]))
    for s in _renamed(node.branches[0][1], hidden):
        yield mapped(s, change)
    yield mapped(node.closer, change)


def counts_fractions(s: st.For) -> bool:
    """Whether a number of a loop that is written out is a fraction, or what it begins with or counts by a quotient."""
    written = any(type(e) is ex.Number and not float(e.value).is_integer() for e in (s.start, s.stop, s.step))
    return written or any(_is_quotient(e) for e in (s.start, s.step))


def _is_quotient(e: ex.Expression | None) -> bool:
    match e:
        case ex.Binary("/"):
            return True
        case ex.Binary("+" | "-" | "*", left, right):
            return _is_quotient(left) or _is_quotient(right)
        case ex.Unary("-", operand):
            return _is_quotient(operand)
    return False
