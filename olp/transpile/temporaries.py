"""What a language cannot compute within a statement is computed before it: calls, functions, parts of conditions.

A loop whose condition needs such a computation becomes one that is left from within.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Set
from dataclasses import dataclass, field, replace
from typing import Any, Final

from olp.core.units import mm
from olp.ir import expressions as ex
from olp.ir import program as st
from olp.ir.block_structure import MIRRORED, Block, Node, flat, negated, parse
from olp.ir.transformer import calls_nothing, expressions_of, mapped, note_names
from olp.languages.vendor import language_of
from olp.runtime.evaluate import COMPARED
from olp.transpile.context import Fate, TranslationContext
from olp.transpile.helper_routines import computes_with_state, with_states
from olp.transpile.integer_inference import NEARLY_HALF
from olp.transpile.symbols import Symbol, Symbols, base_of, holds_number, kind_of_value, symbols_of

# --- Temporary values ---
# Values and conditions that languages with registers can write; what they cannot is computed into variables beforehand.

_READ: Final = {
    "current-pose": "position",
    "current-joints": "joints",
}  # of which an element may be asked for
_TIMED_OUT: Final = ex.SystemValue("timed-out")
_POLL: Final = 0.01  # [s] between two looks, the shortest wait of INFORM and TP
_PLAIN_INDEX: Final = (ex.Number, ex.Text, ex.Named, ex.Variable)


def _asks_reading(e: ex.Expression) -> bool:
    return isinstance(e, (ex.Member, ex.Item)) and type(e.base) is ex.SystemValue and e.base.name in _READ


@dataclass(slots=True)
class Values:
    """The temporaries of one translation; each method adds what has to run first to `before`."""

    work: TranslationContext
    symbols: Symbols
    declared: list[st.Declare] = field(default_factory=list)
    routine: str = ""
    scope: str = ""  # the routine, where a statement of it calls one that needs temporaries of its own
    spare: dict[tuple[str, str], list[ex.Named]] = field(
        default_factory=dict
    )  # temporaries by scope and type, used anew by each statement
    used: dict[str, int] = field(default_factory=dict)
    reads: dict[ex.Signal, ex.Named] = field(default_factory=dict)  # signals that the statement has read
    line: int = 0  # of the statement under way
    changes: Mapping[str, frozenset[str]] = field(
        default_factory=dict
    )  # name, case folded -> the routines that change it
    quiet: Set[str] = frozenset()  # routines, case folded, that change nothing but their own variables

    @property
    def simple(self) -> bool:
        """Whether the target takes only comparisons joined from left to right."""
        return not self.work.limits.nested_logic

    def temporary(self, kind: str) -> ex.Named:
        """A variable for one value within one statement, of the routine's own where that calls another."""
        at = self.used.get(kind, 0)
        self.used[kind] = at + 1
        pool = self.spare.setdefault((self.scope, kind), [])
        if at == len(pool):
            pool.append(self._made(kind))
        return pool[at]

    def _made(self, kind: str) -> ex.Named:
        name = ex.Named(self.work.helper(f"temp_{kind}"))
        self.declared.append(st.Declare(0, name.name, kind, None, shared=True))
        self.symbols.table[("", name.name)] = Symbol(name.name, kind, assigned=1)
        return name

    def _as_flag(
        self, line: int, target: ex.Expression, value: ex.Expression, comment: str = ""
    ) -> list[Node]:
        """A condition's value in a variable: 1 where it holds, else 0."""
        if isinstance(value, ex.SignalState):
            return [st.Assign(line, target, ex.Number(int(value.on)), comment)]
        before: list[st.Statement] = []
        condition = self.condition(value, before)
        block = Block(
            [
                (st.If(line, condition, comment), [st.Assign(line, target, ex.Number(1))]),
                (st.Else(line), [st.Assign(line, target, ex.Number(0))]),
            ],
            st.EndIf(line),
        )
        return [*before, block]

    # --- values -----------------------------------------------------------------------------------------

    def _is_position(self, e: ex.Expression) -> bool:
        return kind_of_value(self.symbols, self.routine, e) in ("position", "joints", "tool", "frame")

    def _index(self, e: ex.Expression, before: list[st.Statement]) -> ex.Expression:
        if isinstance(e, ex.Item):
            return replace(e, indices=tuple(self.value(i, before, alone=True) for i in e.indices))
        return e

    def _position(self, e: ex.Expression, before: list[st.Statement]) -> ex.Expression:
        """A computed position whose numbers the target can write."""
        if isinstance(e, ex.CallValue):
            return self._called(e, before, "position")
        if not isinstance(e, (ex.Function, ex.Item)):
            return e
        if isinstance(e, ex.Item):
            return self._index(e, before)
        arguments = tuple(
            self._position(a, before)
            if self._is_position(a)
            else self._fitting(self.value(a, before), before)
            for a in self._each_in_order(e.arguments, before)
        )
        return replace(e, arguments=arguments)

    def value(
        self, e: ex.Expression, before: list[st.Statement], alone: bool = False, whole: bool = False
    ) -> ex.Expression:
        """An expression that the target can write; `alone`: a single value, as most instructions take it."""
        if _asks_reading(e):
            e = self._read(e, before)
        if type(e) is ex.Member and type(e.base) is ex.Function and self._is_position(e.base):
            e = replace(e, base=self._kept(self._position(e.base, before), "position", before))
        e = self._in_order(e, before)
        if computes_with_state(e):
            e = with_states(e, lambda signal: self._bit(signal, before))
        match e:
            case ex.Number() | ex.Text() | ex.SignalState() | ex.Named():
                return e
            case ex.CallValue():
                return self._called(e, before)
            case ex.Function("text-of-value", (first, *_)) if self._is_state(first):
                return self._state(first, before)
            case ex.Function() if not self._is_position(e):
                if e.name == "text-of-value" and not self._is_lone(e):
                    self._tell_decimals(e)
                function = self._function(e, before)
                if not self.simple and not alone and not self._is_lone(e):
                    return function
                return self._kept(function, kind_of_value(self.symbols, self.routine, e), before)
            case ex.Binary("div" | "mod" as word, left, right) if self.simple:
                made = self._divided(word, left, right, before)
                return self._kept(made, "integer", before) if alone and type(made) is ex.Binary else made
            case ex.Binary(operator, left, right):
                left, right = self.value(left, before), self.value(right, before)
                if operator == "/" and self.simple:
                    left, right = self._exact_quotient(left, right, before)
                new: ex.Expression = ex.Binary(operator, left, right)
            case ex.Unary("-", operand):
                inner = self.value(operand, before)
                new = (
                    ex.Binary("-", ex.Number(0), inner)
                    if self.simple and not isinstance(inner, ex.Number)
                    else ex.Unary("-", inner)
                )
            case ex.Item(indices=indices):
                return replace(e, indices=tuple(self.value(i, before, alone=True) for i in indices))
            case ex.Member() if self.simple:
                made = ex.Binary("/", self._counted(e, before), ex.Number(float(_counts_of(e))))
                return self._kept(made, "real", before) if alone else made
            case ex.Signal(bus) if bus in self.work.limits.signal_variables:
                return self._signal_read(e, before)
            case ex.SystemValue() | ex.Signal() | ex.Member():
                e = self._signal(e, before) if isinstance(e, ex.Signal) else e
                return (
                    e
                    if not alone
                    else self._kept(e, kind_of_value(self.symbols, self.routine, e) or "integer", before)
                )
            case _ if is_condition(e):
                target = self.temporary("integer")
                line = before[-1].line if before else 0
                before.extend(flat(self._as_flag(line, target, e)))
                return target
            case _:
                return e
        kind = kind_of_value(self.symbols, self.routine, e)
        return self._kept(new, "integer" if kind == "integer" or whole else "real", before) if alone else new

    def _counted(self, e: ex.Member, before: list[st.Statement]) -> ex.Named:
        """An element of a position, in the counts of the controller."""
        target = self.temporary("integer")
        before.append(st.Assign(0, target, ex.Binary("*", e, ex.Number(_counts_of(e)))))
        return target

    def _in_counts(
        self, operator: str, left: ex.Expression, right: ex.Expression, before: list[st.Statement]
    ) -> ex.Compare | None:
        """An element of a position compared with another one, or with a number, as the controller counts them."""
        if type(left) is not ex.Member:
            if type(right) is not ex.Member:
                return None
            return self._in_counts(MIRRORED.get(operator, operator), right, left, before)
        count = _counts_of(left)
        if type(right) is ex.Member and _counts_of(right) == count:
            return ex.Compare(operator, self._counted(left, before), self._counted(right, before))
        if type(right) is ex.Number and float(right.value * count).is_integer():
            return ex.Compare(operator, self._counted(left, before), ex.Number(int(right.value * count)))
        return None

    def _bit(self, e: ex.Expression, before: list[st.Statement]) -> ex.Named:
        """A digital signal as a number, in a variable."""
        assert isinstance(e, ex.Signal)
        signal = self._signal(e, before)
        if signal not in self.reads:
            if self.work.limits.signal_variables:
                self.reads[signal] = self.temporary("byte")
                before.append(st.ReadInput(self.line, self.reads[signal], signal))
            else:
                self.reads[signal] = self._kept(signal, "integer", before)
        return self.reads[signal]

    def _signal_read(self, e: ex.Signal, before: list[st.Statement]) -> ex.Named:
        """The variable that a signal's number is read into."""
        signal = self._signal(e, before)
        if signal not in self.reads:
            self.reads[signal] = self.temporary(self.work.limits.signal_variables[e.bus])
            before.append(st.ReadInput(self.line, self.reads[signal], signal))
        return self.reads[signal]

    def _read(self, e: ex.Expression, before: list[st.Statement]) -> ex.Expression:
        """An element of where the arm stands: of a position that is read before."""
        assert isinstance(e, (ex.Member, ex.Item))
        assert isinstance(e.base, ex.SystemValue)
        place = self.temporary(_READ[e.base.name])
        before.append(st.Assign(self.line, place, e.base))
        return replace(e, base=place)

    def _is_state(self, e: ex.Expression) -> bool:
        return kind_of_value(self.symbols, self.routine, e) == "boolean"

    def _state(self, e: ex.Expression, before: list[st.Statement]) -> ex.Named:
        """A condition's text in a variable."""
        condition, target = self.condition(e, before), self.temporary("string")
        on, off = (
            st.Assign(self.line, target, ex.Text("TRUE")),
            st.Assign(self.line, target, ex.Text("FALSE")),
        )
        before += [st.If(self.line, condition), on, st.Else(self.line), off, st.EndIf(self.line)]
        return target

    def _kept(self, e: ex.Expression, kind: str, before: list[st.Statement]) -> ex.Named:
        known = ("integer", "real", "string", *_READ.values())
        e = self._fitting(e, before)
        target = self.temporary(kind if kind in known else "integer")
        before.append(st.Assign(before[-1].line if before else 0, target, e))
        return target

    # --- length -----------------------------------------------------------------------------------------

    def _fitting(self, e: ex.Expression, before: list[st.Statement]) -> ex.Expression:
        """An expression of no more values and operators than the target takes in one; parts stand in variables."""
        most = self.work.limits.most_items
        if not most or _items_of(e) <= most or _items_of(e := mapped(e, _bare_signal)) <= most:
            return e
        match e:
            case ex.Binary(left=left, right=right) | ex.Compare(left=left, right=right):
                left, right = self._pair(self._fitting(left, before), self._fitting(right, before), before)
                return replace(e, left=left, right=right)
            case ex.Unary(operator, operand):
                inner = self._fitting(operand, before)
                return ex.Unary(operator, inner if _items_of(inner) < most else self._part(inner, before))
            case ex.Logic(first, rest):
                joined = self._fitting(first, before)
                for word, part in rest:
                    joined, part = self._pair(joined, self._fitting(part, before), before)
                    flat_ = joined if isinstance(joined, ex.Logic) else ex.Logic(joined, ())
                    joined = ex.Logic(flat_.first, (*flat_.rest, (word, part)))
                return joined
            case _:
                return e

    def _pair(
        self, left: ex.Expression, right: ex.Expression, before: list[st.Statement]
    ) -> tuple[ex.Expression, ex.Expression]:
        """Both sides of an operator: the longer one in a variable, or both, where they are too long together."""
        most = self.work.limits.most_items
        for _ in range(2):
            one, other = _items_of(left), _items_of(right)
            if one + 1 + other <= most:
                break
            if one >= other:
                left = self._part(left, before)
            else:
                right = self._part(right, before)
        return left, right

    def _part(self, e: ex.Expression, before: list[st.Statement]) -> ex.Expression:
        """A part of an expression in a variable: a condition as 1 or 0, which is asked for."""
        if is_condition(e):
            return ex.Compare("<>", self._flag_variable(e, before), ex.Number(0))
        kind = kind_of_value(self.symbols, self.routine, e)
        return self._kept(e, "integer" if kind == "integer" else "real", before)

    def _exact_quotient(
        self, left: ex.Expression, right: ex.Expression, before: list[st.Statement]
    ) -> tuple[ex.Expression, ex.Expression]:
        """Both sides of a division, one of them no whole number: the quotient of two may be whole."""
        kinds = [kind_of_value(self.symbols, self.routine, e) for e in (left, right)]
        if "real" in kinds:
            return left, right
        if isinstance(right, ex.Number):
            return left, ex.Number(float(right.value))
        if isinstance(left, ex.Number):
            return ex.Number(float(left.value)), right
        return self._kept(left, "real", before), right

    def _divided(
        self, word: str, left: ex.Expression, right: ex.Expression, before: list[st.Statement]
    ) -> ex.Expression:
        if any(self._may_be_fraction(e) for e in (left, right)):
            language = language_of(self.work.target)
            says = f"what is divided may be a fraction, which is rounded: {language} divides whole numbers"
            self.work.lose(self.line, Fate.APPROXIMATED, "value", says)
        first, second = self.value(left, before, alone=True), self.value(right, before, alone=True)
        quotient = self.temporary("integer")
        before += [st.Assign(0, quotient, first), st.Update(0, "/", quotient, second)]
        if word == "div":
            return quotient
        return ex.Binary("-", first, ex.Binary("*", quotient, second))

    def _may_be_fraction(self, e: ex.Expression) -> bool:
        if isinstance(e, ex.Number):
            return not float(e.value).is_integer()
        return kind_of_value(self.symbols, self.routine, e) not in ("integer", "byte")

    # --- texts ------------------------------------------------------------------------------------------

    def _is_lone(self, e: ex.Expression) -> bool:
        """Whether the target has this as the right side of an assignment only, of variables alone."""
        return type(e) is ex.Function and e.name in self.work.limits.lone_functions

    def _tell_decimals(self, e: ex.Function) -> None:
        if kind_of_value(self.symbols, self.routine, e.arguments[0]) != "integer":
            says = f"{language_of(self.work.target)} decides with how many decimals a number is written as a text"
            self.work.lose(self.line, Fate.APPROXIMATED, "text", says)

    def _register(self, e: ex.Expression, before: list[st.Statement]) -> ex.Expression:
        """A value in a variable, literals too."""
        found = self.value(e, before, alone=True)
        if isinstance(found, ex.Text):
            return self._kept(found, "string", before)
        return self._kept(found, "real", before) if isinstance(found, ex.Number) else found

    def _lone(self, e: ex.Function, before: list[st.Statement]) -> ex.Expression:
        """A function of texts as the target writes it."""
        if e.name == "text-of-value":
            self._tell_decimals(e)
            return self._register(e.arguments[0], before)
        if e.name == "joined-text" and len(e.arguments) > 2:
            e = ex.Function(e.name, (ex.Function(e.name, e.arguments[:-1]), e.arguments[-1]))
        arguments = tuple(self._register(a, before) for a in e.arguments)
        if e.name == "match-in-text":
            return self._matched(arguments, e.arguments, before)
        if e.name == "part-of-text" and len(arguments) == 2:
            arguments = (*arguments, self._left_from(*arguments, before))
        return replace(e, arguments=arguments)

    def _left_from(self, text: ex.Expression, start: ex.Expression, before: list[st.Statement]) -> ex.Named:
        """How many characters a text has from its character `start` on."""
        count = self.temporary("integer")
        before += [
            st.Assign(0, count, ex.Function("length-of-text", (text,))),
            st.Assign(0, count, ex.Binary("-", count, start)),
            st.Assign(0, count, ex.Binary("+", count, ex.Number(1))),
        ]
        return count

    def _matched(
        self,
        values: tuple[ex.Expression, ...],
        written: tuple[ex.Expression, ...],
        before: list[st.Statement],
    ) -> ex.Named:
        """Where a text stands in another from a character on; one more than the length where it does not."""
        text, start, pattern = values
        wanted = written[2].value if isinstance(written[2], ex.Text) else ""
        if not wanted or any(letter.isalpha() for letter in wanted):
            says = (
                "a search for letters, of which the controller may take capitals and small ones for the same"
            )
            self.work.lose(self.line, Fate.REFUSED, "statement", says)
        found = self.temporary("integer")
        whole = written[1] == ex.Number(1)
        left = self._left_from(text, start, before)
        rest = text
        if not whole:
            rest = self._kept(ex.Function("part-of-text", (text, start, left)), "string", before)
        before += [
            st.Assign(0, found, ex.Function("position-in-text", (rest, pattern))),
            st.If(0, ex.Compare("=", found, ex.Number(0))),
            st.Assign(0, found, ex.Binary("+", left, ex.Number(1))),
            st.EndIf(0),
        ]
        if not whole:
            before += [
                st.Assign(0, found, ex.Binary("+", found, start)),
                st.Assign(0, found, ex.Binary("-", found, ex.Number(1))),
            ]
        return found

    # --- functions and calls ----------------------------------------------------------------------------

    def _function(self, e: ex.Function, before: list[st.Statement]) -> ex.Expression:
        if self._is_lone(e):
            return self._lone(e, before)
        if self.simple and e.name == "round" and len(e.arguments) == 1:
            target = self.temporary("integer")
            before.append(st.Assign(0, target, self.value(e.arguments[0], before)))
            return target
        if self.simple and e.name == "tan":
            sine = self.value(ex.Function("sin", e.arguments), before, alone=True)
            cosine = self.value(ex.Function("cos", e.arguments), before, alone=True)
            return ex.Binary("/", sine, cosine)
        if self.simple and e.name == "abs" and len(e.arguments) == 1:
            return self._absolute(e.arguments[0], before)
        return replace(e, arguments=tuple(self.value(a, before, alone=True) for a in e.arguments))

    def _absolute(self, e: ex.Expression, before: list[st.Statement]) -> ex.Expression:
        kind = "integer" if kind_of_value(self.symbols, self.routine, e) == "integer" else "real"
        target = self.temporary(kind)
        turned = st.Assign(0, target, ex.Binary("-", ex.Number(0), target))
        negative: list[st.Statement] = [st.If(0, ex.Compare("<", target, ex.Number(0))), turned, st.EndIf(0)]
        before += [st.Assign(0, target, self.value(e, before)), *negative]
        return target

    def _called(self, e: ex.CallValue, before: list[st.Statement], wanted: str = "real") -> ex.Expression:
        """A routine's value: called before the statement. `wanted`: its type where no file tells it."""
        kind = kind_of_value(self.symbols, self.routine, e)
        handed = self.work.handed.get(e.routine.casefold())
        if not kind and handed is not None:
            kind = kind_of_value(self.symbols, self.routine, handed.result)
        target = self.temporary(kind or wanted)
        arguments = tuple(self.value(a, before) for a in self._each_in_order(e.arguments, before))
        before.append(st.Call(0, e.routine, arguments, result=target))
        self.reads.clear()  # what the routine does takes time
        return target

    # --- order of evaluation ----------------------------------------------------------------------------

    def _is_loud(self, e: ex.Expression) -> bool:
        """Whether a routine is called in it that changes more than its own variables."""
        return any(
            type(x) is ex.CallValue and x.routine.casefold() not in self.quiet for x in expressions_of(e)
        )

    def _in_order(self, e: ex.Expression, before: list[st.Statement], later: bool = False) -> ex.Expression:
        """What stands left of a call that may change it, read before that call. `later`: a call follows `e`."""
        if not later and not self._is_loud(e):
            return e
        match e:
            case ex.CallValue():
                return self._called(e, before) if later else e
            case ex.Compare(operator, left, right) if later and is_condition(left):
                return ex.Compare("<>", self._flag_variable(e, before), ex.Number(0))
            case ex.Binary(operator, left, right) | ex.Compare(operator, left, right):
                left, right = self._each_in_order((left, right), before, later)
                return replace(e, left=left, right=right)
            case ex.Logic(first, rest):
                parts = self._each_in_order((first, *(part for _, part in rest)), before, later)
                words = (word for word, _ in rest)
                return ex.Logic(parts[0], tuple(zip(words, parts[1:], strict=True)))
            case ex.Unary(operator, operand):
                return ex.Unary(operator, self._in_order(operand, before, later))
            case ex.Function():
                return replace(e, arguments=self._each_in_order(e.arguments, before, later))
            case ex.Signal() if later:
                if is_condition(e):
                    return ex.Compare("<>", self._flag_variable(e, before), ex.Number(0))
                return self._kept(e, "integer", before)
            case ex.Named() | ex.Item() | ex.Member() if later and self._may_change(e):
                kind = kind_of_value(self.symbols, self.routine, e)
                return e if kind in ("tool", "frame") else self._kept(e, kind or "real", before)
            case _:
                return e

    def _each_in_order(
        self, parts: tuple[ex.Expression, ...], before: list[st.Statement], later: bool = False
    ) -> tuple[ex.Expression, ...]:
        return tuple(
            self._in_order(part, before, later or any(map(self._is_loud, parts[at:])))
            for at, part in enumerate(parts, 1)
        )

    def _may_change(self, e: ex.Expression) -> bool:
        """Whether a routine that is called may change a variable, or what it is a part of."""
        name = base_of(e)
        return name is None or bool(self.changes.get(name.name.casefold(), frozenset()) - {self.routine})

    # --- conditions -------------------------------------------------------------------------------------

    def condition(self, e: ex.Expression, before: list[st.Statement]) -> ex.Expression:
        """A condition that the target can write."""
        e = self._with_indices(self._in_order(self._called_once(e, before), before), before)
        if not self.simple:
            return self._fitting(mapped(self._with_values(e, before), self._plain_flag), before)
        plain = self._comparison(e, before)
        if isinstance(plain, ex.Compare):
            return plain
        assert isinstance(plain, ex.Logic)
        parts = self._left_to_right(plain)
        if isinstance(parts, ex.Logic):
            if _grouped(parts) is parts:
                return parts
            if [word for word, _ in parts.rest] == ["or", "and"]:  # (a OR b) AND c, for either way to read it
                (_, second), both = parts.rest
                return ex.Logic(parts.first, (both, ("or", second), both))
        # No order of writing says it, whichever of AND and OR comes first: each part in parentheses becomes a flag.
        plain = _grouped(plain)
        rest = tuple((word, self._flag(part, before)) for word, part in plain.rest)
        return ex.Logic(self._flag(plain.first, before), rest)

    def _called_once(self, e: ex.Expression, before: list[st.Statement]) -> ex.Expression:
        """A condition in which an exclusive OR, which the target lacks, makes no call twice."""
        if not any(type(x) is ex.Logic and joins_calls(x) for x in expressions_of(e)):
            return e
        return mapped(e, lambda x: self._unlike(x, before) if type(x) is ex.Logic and joins_calls(x) else x)

    def _unlike(self, e: ex.Logic, before: list[st.Statement]) -> ex.Expression:
        found = e.first
        for operator, right in e.rest:
            if operator == "xor":
                flags = self._flag_variable(found, before), self._flag_variable(right, before)
                found = ex.Compare("<>", *flags)
            else:
                found = ex.Logic(found, ((operator, right),))
        return found

    def _with_indices(self, e: ex.Expression, before: list[st.Statement]) -> ex.Expression:
        """The signals of an expression by numbers that stand in a variable."""
        if not any(type(x) is ex.Signal and not self._is_plain_index(x.index) for x in expressions_of(e)):
            return e
        return mapped(e, lambda x: self._signal(x, before) if type(x) is ex.Signal else x)

    def _signal(self, e: ex.Signal, before: list[st.Statement]) -> ex.Signal:
        if self._is_plain_index(e.index):
            return e
        kept = self.value(e.index, before, alone=True)
        if not isinstance(kept, ex.Named) or not self._is_plain_index(kept):
            kept = self._kept(kept, "integer", before)
        return replace(e, index=kept)

    def _is_plain_index(self, e: ex.Expression) -> bool:
        """Whether a signal can be named by it: jobs do by whole numbers, which have variables of their own there."""
        if not isinstance(e, _PLAIN_INDEX):
            return False
        return not (self.simple and kind_of_value(self.symbols, self.routine, e) == "real")

    def _with_values(self, e: ex.Expression, before: list[st.Statement]) -> ex.Expression:
        def change(x: ex.Expression) -> ex.Expression:
            if isinstance(x, ex.CallValue):
                return self._called(x, before)
            if _asks_reading(x):
                return self._read(x, before)
            if computes_with_state(x):
                return with_states(x, lambda signal: self._bit(signal, before))
            if self._is_lone(x):
                return self.value(x, before, alone=True)
            return self._function(x, before) if type(x) is ex.Function and _is_of_computed(x) else x

        if any(
            type(x) is ex.CallValue
            or _asks_reading(x)
            or computes_with_state(x)
            or self._is_lone(x)
            or (type(x) is ex.Function and _is_of_computed(x))
            for x in expressions_of(e)
        ):
            return mapped(e, change)
        return e

    def _plain_flag(self, e: ex.Expression) -> ex.Expression:
        """A variable that holds 0 or 1, where a condition stands; no text stands left of what it is compared with."""
        if isinstance(e, ex.Compare) and type(e.left) is ex.Text:
            known = _known(e)
            return known if known is not e else ex.Compare(e.operator, e.right, e.left)
        if isinstance(e, ex.Logic):
            rest = tuple((word, self._as_comparison(part)) for word, part in e.rest)
            return ex.Logic(self._as_comparison(e.first), rest)
        if isinstance(e, ex.Unary) and e.operator == "not":
            return ex.Unary("not", self._as_comparison(e.operand))
        if isinstance(e, ex.Compare) and isinstance(e.right, ex.SignalState) and isinstance(e.left, ex.Named):
            return ex.Compare(e.operator, e.left, ex.Number(int(e.right.on)))
        if isinstance(e, ex.Compare) and is_condition(e.left) is not is_condition(e.right):
            # A state is compared with a state, and not with the number that stands for one.
            left, right = (
                one if is_condition(one) else self._as_comparison(one) for one in (e.left, e.right)
            )
            return ex.Compare(e.operator, left, right)
        return e

    def _as_comparison(self, e: ex.Expression) -> ex.Expression:
        return ex.Compare("<>", e, ex.Number(0)) if isinstance(e, (ex.Named, ex.Item)) else e

    def _comparison(self, e: ex.Expression, before: list[st.Statement]) -> ex.Expression:
        match e := _known(e):
            case ex.SignalState():  # left of the operator a variable or a signal stands
                return ex.Compare("=", self._flag_variable(e, before), ex.Number(1))
            case ex.Signal():
                return ex.Compare("=", e, ex.SignalState(True))
            case ex.Unary("not", operand):
                turned = negated(operand)
                if isinstance(turned, ex.Unary):
                    inner = self._comparison(operand, before)
                    return self._comparison(negated(inner), before)
                return self._comparison(turned, before)
            case ex.Compare(operator, left, right):
                return self._compare(operator, left, right, before)
            case ex.Logic(first, rest):
                return ex.Logic(
                    self._comparison(first, before),
                    tuple((word, self._comparison(part, before)) for word, part in rest),
                )
            case _:
                return ex.Compare("<>", self.value(e, before, alone=True), ex.Number(0))

    def _compare(
        self, operator: str, left: ex.Expression, right: ex.Expression, before: list[st.Statement]
    ) -> ex.Expression:
        if isinstance(right, ex.SignalState) and not isinstance(left, ex.Signal):
            if isinstance(left, (ex.Named, ex.Item)):
                return ex.Compare(operator, left, ex.Number(int(right.on)))
            inner = left if right.on == (operator == "=") else negated(left)
            return self._comparison(inner, before)
        if is_condition(left) and not isinstance(left, (ex.Signal, ex.Named)):
            left = self._flag_variable(left, before)
            right = self._flag_variable(right, before) if is_condition(right) else right
        if self.simple and (counted := self._in_counts(operator, left, right, before)):
            return counted
        if computes_with_state(order := ex.Compare(operator, left, right)):
            order = with_states(order, lambda signal: self._bit(signal, before))
            assert isinstance(order, ex.Compare)
            left, right = order.left, order.right
        if isinstance(right, ex.Signal) and right.bus in self.work.limits.signal_variables:
            # Jobs seen have signals left of the operator alone.
            if not isinstance(left, ex.Signal):
                return self._compare(MIRRORED.get(operator, operator), right, left, before)
            right = self._signal_read(right, before)
        return ex.Compare(operator, self._side(left, before), self._side(right, before))

    def _side(self, e: ex.Expression, before: list[st.Statement]) -> ex.Expression:
        if isinstance(e, (ex.Signal, ex.SignalState)):
            return e
        # Jobs seen compare one value with another: what is computed stands in a variable.
        return self.value(e, before, alone=True)

    def _flag_variable(self, e: ex.Expression, before: list[st.Statement]) -> ex.Expression:
        target = self.temporary("integer")
        before.extend(flat(self._as_flag(0, target, e)))
        return target

    def _flag(self, e: ex.Expression, before: list[st.Statement]) -> ex.Expression:
        return (
            e if isinstance(e, ex.Compare) else ex.Compare("=", self._flag_variable(e, before), ex.Number(1))
        )

    def _left_to_right(self, e: ex.Logic) -> ex.Expression | None:
        """The condition without parentheses: only its first part may be joined itself, and parts may change places."""
        first, rest = e.first, list(e.rest)
        if isinstance(first, ex.Logic):
            inner = self._left_to_right(first)
            if not isinstance(inner, ex.Logic):
                return None
            first, rest = inner.first, [*inner.rest, *rest]
        joined = [part for _, part in rest if isinstance(part, ex.Logic)]
        if not joined:
            return ex.Logic(first, tuple(rest)) if not isinstance(first, ex.Logic) else None
        if len(rest) == 1 and isinstance(first, ex.Compare):
            word, part = rest[0]
            assert isinstance(part, ex.Logic)
            inner = self._left_to_right(part)
            if isinstance(inner, ex.Logic):
                return ex.Logic(inner.first, (*inner.rest, (word, first)))
        return None


def _bare_signal(e: ex.Expression) -> ex.Expression:
    """`DI[1]`, or `!DI[1]`, for a digital signal that is compared with a state."""
    if not (isinstance(e, ex.Compare) and isinstance(e.right, ex.SignalState) and e.operator in ("=", "<>")):
        return e
    if not (isinstance(e.left, ex.Signal) and is_condition(e.left)):
        return e
    return e.left if e.right.on == (e.operator == "=") else ex.Unary("not", e.left)


def _items_of(e: ex.Expression) -> int:
    """How many values and operators an expression has; an element by a computed index is counted as two."""
    match e:
        case ex.Binary(left=left, right=right) | ex.Compare(left=left, right=right):
            return _items_of(left) + 1 + _items_of(right)
        case ex.Unary(operand=operand):
            return 1 + _items_of(operand)
        case ex.Logic(first, rest):
            both = _items_of(first)
            for word, part in rest:
                both += 1 + _items_of(part)
                both *= 2 if word == "xor" else 1  # written with AND, OR and NOT
            return both
        case ex.Item(indices=indices):
            return 1 if all(type(i) is ex.Number for i in indices) else 2
        case ex.Signal(index=index):
            return 1 if isinstance(index, (ex.Number, ex.Text)) else 2
        case ex.Member(base=base):
            return 1 + _items_of(base)
        case ex.Function(arguments=arguments):
            return 1 + sum(map(_items_of, arguments))
        case _:
            return 1


def _is_of_computed(e: ex.Function) -> bool:
    """Whether a function of numbers has an argument that is computed: controllers take a variable or a number."""
    return any(isinstance(a, (ex.Binary, ex.Unary, ex.Function, ex.Member)) for a in e.arguments)


def _whole(e: ex.Expression) -> ex.Expression:
    """A whole number as loops count: 3, not 3.0."""
    return ex.Number(int(e.value)) if type(e) is ex.Number and float(e.value).is_integer() else e


def _counts_of(e: ex.Member) -> int:
    """The controller counts elements in 0.001 mm and 0.0001 deg."""
    return 1000 if e.name in "xyz" else 10_000


def _known(e: ex.Expression) -> ex.Expression:
    """A condition without the parts that numbers decide, calls apart."""
    if isinstance(e, ex.Compare) and type(e.left) is ex.Number and type(e.right) is ex.Number:
        return ex.SignalState(COMPARED[e.operator](e.left.value, e.right.value))
    if isinstance(e, ex.Compare) and type(e.left) is ex.Text and type(e.right) is ex.Text:
        return ex.SignalState(COMPARED[e.operator](e.left.value, e.right.value))
    words = {word for word, _ in e.rest} if isinstance(e, ex.Logic) else set()
    if not isinstance(e, ex.Logic) or words not in ({"and"}, {"or"}):
        return e
    if any(type(x) is ex.CallValue for x in expressions_of(e)):
        return e
    decides = ex.SignalState(words == {"or"})
    parts = [
        part for part in map(_known, (e.first, *(part for _, part in e.rest))) if not _is_said(part, decides)
    ]
    if decides in parts or not parts:
        return decides if parts else ex.SignalState(not decides.on)
    (word,) = words
    return ex.Logic(parts[0], tuple((word, part) for part in parts[1:])) if len(parts) > 1 else parts[0]


def _is_said(part: ex.Expression, decides: ex.SignalState) -> bool:
    """Whether a part changes nothing: TRUE among ANDs, FALSE among ORs."""
    return isinstance(part, ex.SignalState) and part != decides


def _grouped(e: ex.Logic) -> ex.Logic:
    """Parts that are joined from left to right with what stands before an AND behind an OR in parentheses; the same
    object where there is none.
    """
    words = [word for word, _ in e.rest]
    for at in range(len(words) - 1, 0, -1):
        if words[at] == "and" and words[at - 1] == "or":
            return ex.Logic(_grouped(ex.Logic(e.first, e.rest[:at])), e.rest[at:])
    return e


def is_condition(e: ex.Expression) -> bool:
    match e:
        case ex.SignalState() | ex.Compare() | ex.Logic() | ex.Unary("not", _):
            return True
        case ex.Signal(bus):
            return not holds_number(bus)
        case _:
            return False


def joins_calls(e: ex.Logic) -> bool:
    """Whether an exclusive OR joins what a routine computes."""
    xor = any(operator == "xor" for operator, _ in e.rest)
    return xor and any(type(x) is ex.CallValue for x in expressions_of(e))


# --- Conditions that stop early ---

_QUIET: Final = (
    st.Assign,
    st.Begin,
    st.Comment,
    st.Declare,
    st.Else,
    st.ElseIf,
    st.End,
    st.EndIf,
    st.If,
    st.Return,
)


def short_circuit_calls(program: st.Program, work: TranslationContext) -> st.Program:
    """Reports calls in the right operand of AND and OR, which only the source skips once the left one decides."""
    if not work.conventions.stops_early or work.target_conventions.stops_early:
        return program
    quiet = _quiet_of(program)
    for routine in program.routines:
        for _, s in work.look(routine).rare:
            for name in _called_behind(s, quiet):
                says = (
                    f"{language_of(program.vendor)} does not call {name} where what stands before it decides "
                    f"the condition: {language_of(work.target)} may call it there too"
                )
                work.lose(s, Fate.APPROXIMATED, "call", says)
    return program


def _called_behind(s: st.Statement, quiet: Set[str]) -> Iterator[str]:
    """The routines that a condition of a statement calls right of an AND or an OR, but those that change nothing."""
    parts = [part for e in expressions_of(s) if type(e) is ex.Logic for _, part in e.rest]
    called = {x.routine for part in parts for x in expressions_of(part) if type(x) is ex.CallValue}
    yield from sorted(name for name in called if name.casefold() not in quiet)


def _quiet_of(program: st.Program) -> Set[str]:
    return {routine.name.casefold() for routine in program.routines if _changes_nothing(routine)}


def _changes_of(program: st.Program) -> Mapping[str, frozenset[str]]:
    """Which routines change a variable, by its name, case folded."""
    found: dict[str, set[str]] = {}
    for routine in program.routines:
        for s in routine.body:
            for part in ("target", "variable", "result"):
                name = base_of(getattr(s, part, None))
                if name is not None:
                    found.setdefault(name.name.casefold(), set()).add(routine.name)
    return {name: frozenset(routines) for name, routines in found.items()}


def _changes_nothing(routine: st.Routine) -> bool:
    """Whether a routine computes a value from what it is given, and sets nothing but its own variables."""
    own = {d.name.casefold() for d in routine.body if isinstance(d, st.Declare)}
    own |= {p.name.casefold() for p in routine.parameters if not p.by_reference}
    for s in routine.body:
        if not isinstance(s, _QUIET) or any(type(e) is ex.CallValue for e in expressions_of(s)):
            return False
        if isinstance(s, st.Assign):
            base = base_of(s.target)
            if not isinstance(base, ex.Named) or base.name.casefold() not in own:
                return False
    return True


# --- Temporaries ---


def _calls(node: Node) -> bool:
    """Whether a statement, or a statement of a block that is none of those in it, computes by calling a routine."""
    if isinstance(node, Block):
        return any(map(_calls, (*(marker for marker, _ in node.branches), node.closer)))
    return any(type(e) is ex.CallValue for e in expressions_of(node))


def hoist(program: st.Program, work: TranslationContext) -> st.Program:
    """For languages with registers: expressions that they can write, all else computed into variables beforehand."""
    own = _Hoist(work, symbols_of(program), changes=_changes_of(program), quiet=_quiet_of(program))
    routines = tuple(own.routine_of(routine) for routine in program.routines)
    return replace(program, routines=routines, data=(*program.data, *own.declared))


@dataclass(slots=True)
class _Hoist(Values):
    """Statements, each behind what computes for it. `late`: whether the wait before reached its limit, if a loop."""

    late: ex.Named | None = None

    def routine_of(self, routine: st.Routine) -> st.Routine:
        self.routine = routine.name
        nodes = parse(routine.body)
        if nodes is None:
            return routine
        return replace(routine, body=tuple(flat(self.nodes(nodes))))

    # --- statements -------------------------------------------------------------------------------------

    def _begin(self, node: Node) -> None:
        """The temporaries of a statement are free for the next one."""
        self.used.clear()
        self.reads.clear()
        self.scope = self.routine if _calls(node) else ""

    def nodes(self, nodes: list[Node]) -> list[Node]:
        result: list[Node] = []
        for node in nodes:
            if calls_nothing(node) and _is_written_out(node):
                result.append(node)
                continue
            self.line = node.opener.line if isinstance(node, Block) else node.line
            self._begin(node)
            if isinstance(node, Block):
                result += _stamped(self._block(node), node.opener.line)
            else:
                result += _stamped(self._statement(node), node.line)
        return result

    def _block(self, block: Block) -> list[Node]:
        head = block.opener
        if isinstance(head, st.If):
            return self._if(block)
        inside = [(marker, self.nodes(rows)) for marker, rows in block.branches]
        self._begin(block)
        before: list[st.Statement] = []
        if isinstance(head, st.While):
            if head.condition == ex.SignalState(True):
                return [Block(inside, block.closer)]
            condition = self.condition(head.condition, before)
            if not before:
                return [Block([(replace(head, condition=condition), inside[0][1])], block.closer)]
            leave = Block(
                [(st.If(head.line, negated(condition)), [st.Break(head.line)])], st.EndIf(head.line)
            )
            endless = st.While(head.line, ex.SignalState(True), head.comment)
            return [Block([(endless, [*before, leave, *inside[0][1]])], st.EndWhile(block.closer.line))]
        if isinstance(block.closer, st.Until):
            condition = self.condition(block.closer.condition, before)
            return [Block([(head, [*inside[0][1], *before])], replace(block.closer, condition=condition))]
        if isinstance(head, st.Switch):
            value = self.value(head.value, before, alone=True)
            if self.simple and isinstance(value, (ex.Number, ex.Text)):  # jobs seen choose by variables
                kind = kind_of_value(self.symbols, self.routine, value)
                chosen = self._made(kind or "real")
                before.append(st.Assign(head.line, chosen, value))
                value = chosen
            return [*before, Block([(replace(head, value=value), inside[0][1]), *inside[1:]], block.closer)]
        if isinstance(head, st.For):
            parts = (head.start, head.stop, *(() if head.step is None else (head.step,)))
            values = [_whole(self.value(e, before, alone=True)) for e in self._each_in_order(parts, before)]
            # The controller looks at the bound again in each round, when the temporaries hold other values.
            values[1:] = [self._lasting(e, before) for e in values[1:]]
            limits = self.work.limits  # a language with a type for integers has them by then
            if (
                limits.for_counts_whole
                and not limits.integer_type
                and not self._may_be_fraction(head.variable)
            ):
                values = [self._whole_bound(e, head, place, before) for place, e in enumerate(values)]
            head = replace(
                head, start=values[0], stop=values[1], step=None if head.step is None else values[2]
            )
            return [*before, Block([(head, inside[0][1])], block.closer)]
        return [Block(inside, block.closer)]

    def _whole_bound(
        self, e: ex.Expression, head: st.For, place: int, before: list[st.Statement]
    ) -> ex.Expression:
        """The begin, end or step of a loop as an integer: up to a fraction are the whole numbers before it."""
        if not self._may_be_fraction(e):
            return e
        if place == 1 and (head.step is None or isinstance(head.step, ex.Number)):
            up = head.step is None or head.step.value > 0
            e = ex.Binary("-" if up else "+", e, ex.Number(NEARLY_HALF))
        else:
            language = language_of(self.work.target)
            says = f"a bound of a loop that may be a fraction is rounded: {language} counts whole numbers"
            self.work.lose(head, Fate.APPROXIMATED, "loop", says)
        target = self._made("integer")
        before.append(st.Assign(self.line, target, e))
        return target

    def _lasting(self, e: ex.Expression, before: list[st.Statement]) -> ex.Expression:
        """A temporary as a variable that no other statement uses."""
        if not any(e in pool for pool in self.spare.values()):
            return e
        kind = kind_of_value(self.symbols, self.routine, e)
        target = self._made(kind)
        before.append(st.Assign(self.line, target, e))
        return target

    def _if(self, block: Block) -> list[Node]:
        head = block.opener
        assert isinstance(head, st.If)
        before: list[st.Statement] = []
        condition = self.condition(head.condition, before)
        branches: list[tuple[st.Statement, list[Node]]] = [
            (replace(head, condition=condition), self.nodes(block.branches[0][1]))
        ]
        for at, (marker, rows) in enumerate(block.branches[1:], 1):
            if isinstance(marker, st.ElseIf):
                self._begin(marker)
                needed: list[st.Statement] = []
                condition = self.condition(marker.condition, needed)
                if needed:
                    # What the condition needs is computed only where the ones before did not hold.
                    inner = Block(
                        [(st.If(marker.line, marker.condition), rows), *block.branches[at + 1 :]],
                        st.EndIf(marker.line),
                    )
                    branches.append((st.Else(marker.line, marker.comment), self.nodes([inner])))
                    return [*before, Block(branches, block.closer)]
                branches.append((replace(marker, condition=condition), self.nodes(rows)))
            else:
                branches.append((marker, self.nodes(rows)))
        return [*before, Block(branches, block.closer)]

    def _statement(self, s: st.Statement) -> list[Node]:
        before: list[st.Statement] = []
        if isinstance(s, (st.SetOutput, st.PulseOutput)) and not self._is_plain_index(s.signal.index):
            s = replace(s, signal=self._signal(s.signal, before))
            return [*before, *self._statement(s)]
        match s:
            case st.Assign():
                return [*before, *self._assign(s)]
            case st.SetOutput():
                return self._output(s)
            case st.Wait() if s.condition is not None:
                asked = self._with_indices(s.condition, before)
                needed: list[st.Statement] = []
                condition = self.condition(asked, needed)
                if needed:
                    return self._polled(s)
                return [*before, replace(s, condition=condition)]
            case st.Jump() if s.condition == _TIMED_OUT and self.late is not None:
                late, self.late = self.late, None
                return [replace(s, condition=ex.Compare("<>", late, ex.Number(0)))]
            case st.Jump() | st.Pause() | st.Return(value=None) if s.condition is not None:
                condition = self.condition(self._with_indices(s.condition, before), before)
                return [*before, replace(s, condition=condition)]
            case st.Dwell() | st.Move():
                new = self._quantities(s, before)
                if isinstance(new, st.Move):
                    new = self._move(new, before)
                return [*before, new]
            case st.Call():
                given = self._each_in_order(s.arguments, before)
                arguments = tuple(self.value(a, before, alone=True) for a in given)
                if (asked := s.condition) is not None:
                    asked = self.condition(self._with_indices(asked, before), before)
                return [*before, replace(s, arguments=arguments, condition=asked)]
            case st.Update(operand=operand) if operand is not None and self._has_lone(operand):
                value = self.value(operand, before, alone=True)
                return [*before, replace(s, operand=value)]
            case st.Return(value=value) if value is not None and self._has_lone(value):
                if is_condition(value):
                    found: ex.Expression = self._flag_variable(self.condition(value, before), before)
                else:
                    found = self.value(value, before)
                return [*before, replace(s, value=found)]
            case st.Message():
                text = self.value(s.text, before, alone=True)  # first: it adds to what stands before
                return [*before, replace(s, text=text)]
            case _:
                return [s]

    def _has_lone(self, e: ex.Expression) -> bool:
        return any(self._is_lone(x) for x in expressions_of(e))

    def _move(self, s: st.Move, before: list[st.Statement]) -> st.Move:
        targets = tuple(self._target(t, before) for t in s.targets)
        via = None if s.via is None else self._target(s.via, before)
        if targets == s.targets and via == s.via:
            return s
        return replace(s, targets=targets, via=via)

    def _target(self, e: ex.Expression, before: list[st.Statement]) -> ex.Expression:
        """Where a move goes: a position that is put together from numbers is put into a register first."""
        found = self._position(e, before)
        if not isinstance(found, ex.Function) or found.name != "pose-angles":
            return found
        place = self.temporary("position")
        before.append(st.Assign(self.line, place, found))
        return place

    def _polled(self, s: st.Wait) -> list[Node]:
        """A wait whose condition has to be computed anew each time, until its limit where it has one."""
        before: list[st.Statement] = []
        self.used.clear()
        self.reads.clear()
        condition = self.condition(s.condition, before)
        leave = Block([(st.If(s.line, condition), [st.Break(s.line)])], st.EndIf(s.line))
        head = st.While(s.line, ex.SignalState(True), s.comment)
        if s.timeout is None:
            self.work.lose(s, Fate.EXACT, "wait", "a loop asks for what this waits for")
            return [Block([(head, [*before, leave])], st.EndWhile(s.line))]
        says = f"a loop asks every {_POLL * 1000:g} ms for what this waits for, until its limit"
        self.work.lose(s, Fate.APPROXIMATED, "wait", says, _POLL, "s")
        waited, limit = self._made("real"), ex.Binary("*", s.timeout.written, ex.Number(s.timeout.scale))
        begun: list[st.Statement] = [st.Assign(s.line, waited, ex.Number(0.0))]
        if type(s.timeout.written) is ex.Number:
            # Half a step less, as sums of hundredths come out a little below or above.
            most: ex.Expression = ex.Number(
                float(f"{s.timeout.written.value * s.timeout.scale - _POLL / 2:.9g}")
            )
        else:
            most = self._made("real")
            begun.insert(0, st.Assign(s.line, most, s.timeout.written if s.timeout.scale == 1.0 else limit))
        over: list[Node] = [st.Break(s.line)]
        self.late = None
        if self.work.limits.timed_out == "jump":
            self.late = self._made("integer")
            begun.append(st.Assign(s.line, self.late, ex.Number(0)))
            over.insert(0, st.Assign(s.line, self.late, ex.Number(1)))
        ends = Block([(st.If(s.line, ex.Compare(">=", waited, most)), over)], st.EndIf(s.line))
        again: list[Node] = [
            st.Dwell(s.line, ex.Quantity(ex.Number(_POLL), 1.0)),
            st.Assign(s.line, waited, ex.Binary("+", waited, ex.Number(_POLL))),
        ]
        return [*begun, Block([(head, [*before, leave, ends, *again])], st.EndWhile(s.line))]

    def _assign(self, s: st.Assign) -> list[Node]:
        before: list[st.Statement] = []
        target = (
            mapped(s.target, lambda e: self._index(e, before))
            if isinstance(s.target, (ex.Item, ex.Member))
            else s.target
        )
        kind = kind_of_value(self.symbols, self.routine, target)
        value = s.value
        if is_condition(value) and not (isinstance(value, ex.Signal) and not self.simple):
            if isinstance(value, ex.Named):
                return [*before, replace(s, target=target)]
            return [*before, *self._as_flag(s.line, target, value, s.comment)]
        if isinstance(value, ex.Function) and not self._is_position(value):
            value = self._function(
                replace(value, arguments=self._each_in_order(value.arguments, before)), before
            )
        elif self._is_position(value):
            value = self._position(value, before)
        elif isinstance(value, ex.CallValue):
            value = self._called(value, before, kind or "real")
        else:
            value = self._fitting(self.value(value, before, whole=kind == "integer"), before)
        return [*before, replace(s, target=target, value=value)]

    def _output(self, s: st.SetOutput) -> list[Node]:
        before: list[st.Statement] = []
        # A whole number may stand for the state itself; FANUC's signals go on from 1 on, and not from 0.5.
        if (
            not holds_number(s.signal.bus)
            and self._is_counted(s.value)
            and (self.simple or self._may_be_fraction(s.value))
        ):
            s = replace(s, value=ex.Compare("<>", s.value, ex.Number(0)))
        if (
            is_condition(s.value)
            and not isinstance(s.value, (ex.SignalState, ex.Named))
            and not holds_number(s.signal.bus)
        ):
            if not self.simple:
                if any(type(x) is ex.CallValue for x in expressions_of(s.value)):
                    value = self.condition(s.value, before)
                else:
                    value = self._fitting(self._with_indices(s.value, before), before)
                return [*before, s if value is s.value else replace(s, value=value)]
            condition = self.condition(s.value, before)
            on: list[Node] = [replace(s, value=ex.SignalState(True))]
            off: list[Node] = [replace(s, value=ex.SignalState(False), comment="")]
            return [
                *before,
                Block([(st.If(s.line, condition), on), (st.Else(s.line), off)], st.EndIf(s.line)),
            ]
        type_ = self.work.limits.signal_variables.get(s.signal.bus)
        value = self.value(s.value, before, alone=type_ is None)  # first: it adds to what stands before
        if type_ is not None and not (isinstance(value, ex.Number) or self._has_type(value, type_)):
            target = self.temporary(type_)
            before.append(st.Assign(s.line, target, value))
            value = target
        return [*before, replace(s, value=value)]

    def _is_counted(self, e: ex.Expression) -> bool:
        return kind_of_value(self.symbols, self.routine, e) in ("integer", "real", "byte")

    def _has_type(self, e: ex.Expression, type_: str) -> bool:
        return isinstance(e, ex.Named) and kind_of_value(self.symbols, self.routine, e) == type_

    def _quantities(self, s: Any, before: list[st.Statement]) -> Any:
        """Computed speeds, times and blends in variables, in the unit that a number of the target has there."""

        scales = self.work.limits.variable_scales
        kind = "integer" if scales else "real"

        def change(node: Any, name: str, unit: float | None = None) -> Any:
            """`unit`: that numbers have there in a variable, too, where the target has no finer ones for those."""
            if type(node) is not ex.Quantity or isinstance(node.written, ex.Number):
                return node
            finer = name in ("speed", "duration")
            scale = scales.get(round(node.scale, 12), node.scale) if finer else node.scale
            if not scales and isinstance(node.written, ex.Named):
                if unit is None or math.isclose(node.scale, unit):
                    return node
                scale = unit
            factor = node.scale / scale
            value = (
                node.written if abs(factor - 1) < 1e-12 else ex.Binary("*", node.written, ex.Number(factor))
            )
            target = self.temporary(kind)
            before.extend(flat(self._assign(st.Assign(s.line, target, value))))
            return ex.Quantity(target, scale)

        changes: dict[str, Any] = {}
        for name in ("duration", "acceleration", "deceleration", "turn"):
            old = getattr(s, name, None)
            unit = 1.0 if name == "duration" else None
            if old is not None and (new := change(old, name, unit)) is not old:
                changes[name] = new
        for name in ("speed", "blend", "rate"):
            old = getattr(s, name, None)
            unit = mm if name == "speed" and old is not None and old.unit is st.SpeedUnit.TRAVEL else None
            if (
                old is not None
                and old.value is not None
                and (new := change(old.value, name, unit)) is not old.value
            ):
                changes[name] = old._replace(value=new)
        return replace(s, **changes) if changes else s


# --- Texts ---


def texts_by_statement(program: st.Program, work: TranslationContext) -> st.Program:
    """For KRL: texts that are put together within a statement are put together before it, in variables."""
    if not work.limits.texts_by_statement:
        return program
    with_texts = [any(map(_is_put_together, work.look(r).expressions)) for r in program.routines]
    if not any(with_texts):
        return program
    own = _TextHoist(work, symbols_of(program))
    routines = tuple(
        own.routine_of(r) if has else r for r, has in zip(program.routines, with_texts, strict=True)
    )
    used: set[str] = set()
    for r, has in zip(routines, with_texts, strict=True):
        for s in r.body if has else ():
            note_names(s, used)
    needed = (d for d in own.texts.declared if d.name in used)  # others were taken up by the statement itself
    return replace(program, routines=routines, data=(*program.data, *needed))


_PUT_TOGETHER: Final = frozenset({"joined-text", "text-of-value", "part-of-text", "match-in-text"})


def _is_put_together(e: ex.Expression) -> bool:
    return type(e) is ex.Function and e.name in _PUT_TOGETHER


def _has_text(s: st.Statement) -> bool:
    return not calls_nothing(s) and any(map(_is_put_together, expressions_of(s)))


@dataclass(slots=True)
class _Texts(Values):
    """Texts in variables. `made`: what the statement's variables hold, for a text that takes them up as its parts."""

    made: dict[ex.Named, st.Assign] = field(default_factory=dict)

    def lowered(self, e: Any, before: list[st.Statement]) -> Any:
        """An expression, or a statement, whose texts are variables."""
        return mapped(e, lambda x: self._text(x, before) if type(x) is ex.Function else x)

    def whole(self, e: ex.Expression, before: list[st.Statement]) -> ex.Expression:
        """A text that a statement of its own puts together."""
        return self._taken(self.lowered(e, before), before)

    def _taken(self, e: ex.Expression, before: list[st.Statement]) -> ex.Expression:
        """What a variable of this statement holds, which nothing else needs then."""
        row = self.made.pop(e, None) if isinstance(e, ex.Named) else None
        if row is None:
            return e
        before.remove(row)
        return row.value

    def _text(self, e: ex.Function, before: list[st.Statement]) -> ex.Expression:
        if e.name not in _PUT_TOGETHER:
            return e
        if e.name == "match-in-text":
            return self._place(e, before)
        first, *more = e.arguments
        if e.name == "text-of-value" and self._is_state(first):
            return self._state(first, before)
        if e.name == "text-of-value" and not more:
            says = f"{language_of(self.work.target)} writes a number with up to six digits as a text"
            self.work.lose(self.line, Fate.APPROXIMATED, "text", says)
        if e.name == "joined-text":
            e = ex.Function(e.name, tuple(self._taken(one, before) for one in e.arguments))
        elif e.name == "part-of-text" and not isinstance(first, ex.Named):
            e = ex.Function(e.name, (self._kept(first, "string", before), *more))
        return self._kept(e, "string", before)

    def _kept(self, e: ex.Expression, kind: str, before: list[st.Statement]) -> ex.Named:
        target = self.temporary(kind)
        row = st.Assign(self.line, target, e)
        before.append(row)
        self.made[target] = row
        return target

    def condition(self, e: ex.Expression, before: list[st.Statement]) -> ex.Expression:
        return e

    def _place(self, e: ex.Function, before: list[st.Statement]) -> ex.Named:
        """One more than the length of the text where the target says 0."""
        text, start, pattern = e.arguments
        text = text if isinstance(text, (ex.Named, ex.Text)) else self._kept(text, "string", before)
        if not isinstance(start, ex.Number):
            start = self._kept(start, "integer", before)
        found = self.temporary("integer")
        behind = ex.Binary("+", ex.Function("length-of-text", (text,)), ex.Number(1))
        before += [
            st.Assign(self.line, found, ex.Function("find-in-text", (text, start, pattern))),
            st.If(self.line, ex.Compare("=", found, ex.Number(0))),
            st.Assign(self.line, found, behind),
            st.EndIf(self.line),
        ]
        return found


@dataclass(slots=True)
class _TextHoist(_Hoist):
    """Statements behind those that put their texts together; all else stays as it is."""

    texts: _Texts = field(init=False)

    def __post_init__(self) -> None:
        self.texts = _Texts(self.work, self.symbols)

    def _begun(self) -> _Texts:
        texts = self.texts
        texts.routine, texts.line = self.routine, self.line
        texts.used.clear()
        texts.made.clear()
        return texts

    def value(
        self, e: ex.Expression, before: list[st.Statement], alone: bool = False, whole: bool = False
    ) -> ex.Expression:
        found: ex.Expression = self._begun().lowered(e, before)
        return found

    def condition(self, e: ex.Expression, before: list[st.Statement]) -> ex.Expression:
        return self.value(e, before)

    def _statement(self, s: st.Statement) -> list[Node]:
        if not _has_text(s):
            return [s]
        if isinstance(s, st.Wait):
            return self._polled(s)
        texts, before = self._begun(), list[st.Statement]()
        new: Any
        if isinstance(s, st.Message):
            new = replace(s, text=texts.whole(s.text, before))
        elif isinstance(s, st.Assign) and kind_of_value(self.symbols, self.routine, s.value) == "string":
            new = replace(s, value=texts.whole(s.value, before))
        else:
            new = texts.lowered(s, before)
        return [*before, new]


def _is_written_out(s: Any) -> bool:
    """Whether a move's speed and blend are numbers."""
    measured = [q.value for q in (s.speed, s.blend) if q is not None and q.value is not None]
    return all(type(value.written) is ex.Number for value in measured)


def _stamped(nodes: list[Node], line: int) -> list[Node]:
    """Statements that stand for a part of another one, with its line."""
    result: list[Node] = []
    for node in nodes:
        if isinstance(node, Block):
            result.append(
                Block(
                    [(_at(m, line), _stamped(inside, line)) for m, inside in node.branches],
                    _at(node.closer, line),
                )
            )
        else:
            result.append(_at(node, line))
    return result


def _at(s: Any, line: int) -> Any:
    return s if s.line or not line else replace(s, line=line)
