"""Values and conditions in what INFORM and FANUC can write; what they cannot is computed into variables beforehand."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import Final

from olp.ir.expressions import (
    Binary,
    CallValue,
    Compare,
    Expression,
    Function,
    Item,
    Logic,
    Member,
    Named,
    Number,
    Signal,
    SignalState,
    SystemValue,
    Text,
    Unary,
)
from olp.ir.program import (
    Assign,
    Call,
    Declare,
    Else,
    EndIf,
    If,
    Statement,
)
from olp.ir.transformer import expressions_of, mapped
from olp.ir.tree import Block, Node, flat, negated
from olp.transpile.context import TranslationContext
from olp.transpile.symbols import Symbols, kind_of_value

_FLAG_WORDS: Final = ("group", "analog", "register")


@dataclass(slots=True)
class Values:
    """The temporaries of one translation; each method adds what has to run first to `before`."""

    work: TranslationContext
    symbols: Symbols
    declared: list[Declare] = field(default_factory=list)
    routine: str = ""
    spare: dict[str, list[Named]] = field(
        default_factory=dict
    )  # temporaries by type, used anew by each statement
    used: dict[str, int] = field(default_factory=dict)

    @property
    def simple(self) -> bool:
        """Whether the target takes only comparisons joined from left to right."""
        return not self.work.limits.nested_logic

    def temporary(self, kind: str) -> Named:
        """A variable for one value within one statement."""
        at = self.used.get(kind, 0)
        self.used[kind] = at + 1
        pool = self.spare.setdefault(kind, [])
        if at == len(pool):
            pool.append(Named(self.work.helper(f"temp_{kind}")))
            declare = Declare(0, pool[-1].name, kind, None, shared=True)
            self.declared.append(declare)
            from olp.transpile.symbols import Symbol

            self.symbols.table[("", pool[-1].name)] = Symbol(pool[-1].name, kind, assigned=1)
        return pool[at]

    def _as_flag(self, line: int, target: Expression, value: Expression, comment: str = "") -> list[Node]:
        """A condition's value in a variable: 1 where it holds, else 0."""
        if isinstance(value, SignalState):
            return [Assign(line, target, Number(int(value.on)), comment)]
        before: list[Statement] = []
        condition = self.condition(value, before)
        block = Block(
            [
                (If(line, condition, comment), [Assign(line, target, Number(1))]),
                (Else(line), [Assign(line, target, Number(0))]),
            ],
            EndIf(line),
        )
        return [*before, block]

    # --- values -----------------------------------------------------------------------------------------

    def _is_position(self, e: Expression) -> bool:
        return kind_of_value(self.symbols, self.routine, e) in ("position", "joints", "tool", "frame")

    def _index(self, e: Expression, before: list[Statement]) -> Expression:
        if isinstance(e, Item):
            return replace(e, indices=tuple(self.value(i, before, alone=True) for i in e.indices))
        return e

    def value(
        self, e: Expression, before: list[Statement], alone: bool = False, whole: bool = False
    ) -> Expression:
        """An expression that the target can write; `alone`: a single value, as most instructions take it."""
        match e:
            case Number() | Text() | SignalState() | Named():
                return e
            case CallValue():
                return self._called(e, before)
            case Function() if not self._is_position(e):
                function = self._function(e, before)
                if not self.simple and not alone:
                    return function
                return self._kept(function, kind_of_value(self.symbols, self.routine, e), before)
            case Binary("div" | "mod" as word, left, right) if self.simple:
                return self._divided(word, left, right, before)
            case Binary(operator, left, right):
                new: Expression = Binary(operator, self.value(left, before), self.value(right, before))
            case Unary("-", operand):
                inner = self.value(operand, before)
                new = (
                    Binary("-", Number(0), inner)
                    if self.simple and not isinstance(inner, Number)
                    else Unary("-", inner)
                )
            case Item(indices=indices):
                return replace(e, indices=tuple(self.value(i, before, alone=True) for i in indices))
            case Member(name=name) if self.simple:
                # The controller counts elements in 0.001 mm and 0.0001 deg.
                count = 1000 if name in "xyz" else 10_000
                target = self.temporary("integer")
                before.append(Assign(0, target, Binary("*", e, Number(count))))
                return Binary("/", target, Number(count))
            case SystemValue() | Signal() | Member():
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

    def _kept(self, e: Expression, kind: str, before: list[Statement]) -> Named:
        target = self.temporary(kind if kind in ("integer", "real", "string") else "integer")
        before.append(Assign(before[-1].line if before else 0, target, e))
        return target

    def _divided(self, word: str, left: Expression, right: Expression, before: list[Statement]) -> Expression:
        from olp.ir.program import Update

        first, second = self.value(left, before, alone=True), self.value(right, before, alone=True)
        quotient = self.temporary("integer")
        before += [Assign(0, quotient, first), Update(0, "/", quotient, second)]
        if word == "div":
            return quotient
        return Binary("-", first, Binary("*", quotient, second))

    def _function(self, e: Function, before: list[Statement]) -> Expression:
        if self.simple and e.name == "round" and len(e.arguments) == 1:
            target = self.temporary("integer")
            before.append(Assign(0, target, self.value(e.arguments[0], before)))
            return target
        if self.simple and e.name == "tan":
            sine = self.value(Function("sin", e.arguments), before, alone=True)
            cosine = self.value(Function("cos", e.arguments), before, alone=True)
            return Binary("/", sine, cosine)
        if self.simple and e.name == "abs" and len(e.arguments) == 1:
            return self._absolute(e.arguments[0], before)
        return replace(e, arguments=tuple(self.value(a, before, alone=True) for a in e.arguments))

    def _absolute(self, e: Expression, before: list[Statement]) -> Expression:
        kind = "integer" if kind_of_value(self.symbols, self.routine, e) == "integer" else "real"
        target = self.temporary(kind)
        turned = Assign(0, target, Binary("-", Number(0), target))
        negative: list[Statement] = [If(0, Compare("<", target, Number(0))), turned, EndIf(0)]
        before += [Assign(0, target, self.value(e, before)), *negative]
        return target

    def _called(self, e: CallValue, before: list[Statement]) -> Expression:
        """A routine's value: called before the statement."""
        kind = kind_of_value(self.symbols, self.routine, e) or "real"
        target = self.temporary(kind)
        arguments = tuple(self.value(a, before) for a in e.arguments)
        before.append(Call(0, e.routine, arguments, result=target))
        return target

    # --- conditions -------------------------------------------------------------------------------------

    def condition(self, e: Expression, before: list[Statement]) -> Expression:
        """A condition that the target can write."""
        if not self.simple:
            return mapped(self._with_values(e, before), self._plain_flag)
        plain = self._comparison(e, before)
        if isinstance(plain, Compare):
            return plain
        assert isinstance(plain, Logic)
        parts = self._left_to_right(plain)
        if parts is not None:
            return parts
        # No order of writing says it: each part that stands in parentheses becomes a flag.
        rest = tuple((word, self._flag(part, before)) for word, part in plain.rest)
        return Logic(self._flag(plain.first, before), rest)

    def _with_values(self, e: Expression, before: list[Statement]) -> Expression:
        if any(type(x) is CallValue for x in expressions_of(e)):
            return mapped(e, lambda x: self._called(x, before) if isinstance(x, CallValue) else x)
        return e

    def _plain_flag(self, e: Expression) -> Expression:
        """FANUC: a variable that holds 0 or 1, where a condition stands."""
        if isinstance(e, Logic):
            rest = tuple((word, self._as_comparison(part)) for word, part in e.rest)
            return Logic(self._as_comparison(e.first), rest)
        if isinstance(e, Unary) and e.operator == "not":
            return Unary("not", self._as_comparison(e.operand))
        if isinstance(e, Compare) and isinstance(e.right, SignalState) and isinstance(e.left, Named):
            return Compare(e.operator, e.left, Number(int(e.right.on)))
        return e

    def _as_comparison(self, e: Expression) -> Expression:
        return Compare("<>", e, Number(0)) if isinstance(e, (Named, Item)) else e

    def _comparison(self, e: Expression, before: list[Statement]) -> Expression:
        match e:
            case SignalState(on):
                return Compare("=", Number(1), Number(1 if on else 0))
            case Signal():
                return Compare("=", e, SignalState(True))
            case Unary("not", operand):
                turned = negated(operand)
                if isinstance(turned, Unary):
                    inner = self._comparison(operand, before)
                    return self._comparison(negated(inner), before)
                return self._comparison(turned, before)
            case Compare(operator, left, right):
                return self._compare(operator, left, right, before)
            case Logic(first, rest):
                return Logic(
                    self._comparison(first, before),
                    tuple((word, self._comparison(part, before)) for word, part in rest),
                )
            case _:
                return Compare("<>", self.value(e, before, alone=True), Number(0))

    def _compare(
        self, operator: str, left: Expression, right: Expression, before: list[Statement]
    ) -> Expression:
        if isinstance(right, SignalState) and not isinstance(left, Signal):
            if isinstance(left, (Named, Item)):
                return Compare(operator, left, Number(int(right.on)))
            inner = left if right.on == (operator == "=") else negated(left)
            return self._comparison(inner, before)
        if is_condition(left) and not isinstance(left, (Signal, Named)):
            left = self._flag_variable(left, before)
            right = self._flag_variable(right, before) if is_condition(right) else right
        return Compare(operator, self._side(left, before), self._side(right, before))

    def _side(self, e: Expression, before: list[Statement]) -> Expression:
        if isinstance(e, (Signal, SignalState)):
            return e
        # Jobs seen compare one value with another: what is computed stands in a variable.
        return self.value(e, before, alone=True)

    def _flag_variable(self, e: Expression, before: list[Statement]) -> Expression:
        target = self.temporary("integer")
        before.extend(flat(self._as_flag(0, target, e)))
        return target

    def _flag(self, e: Expression, before: list[Statement]) -> Expression:
        return e if isinstance(e, Compare) else Compare("=", self._flag_variable(e, before), Number(1))

    def _left_to_right(self, e: Logic) -> Expression | None:
        """The condition without parentheses: only its first part may be joined itself, and parts may change places."""
        first, rest = e.first, list(e.rest)
        if isinstance(first, Logic):
            inner = self._left_to_right(first)
            if not isinstance(inner, Logic):
                return None
            first, rest = inner.first, [*inner.rest, *rest]
        joined = [part for _, part in rest if isinstance(part, Logic)]
        if not joined:
            return Logic(first, tuple(rest)) if not isinstance(first, Logic) else None
        if len(rest) == 1 and isinstance(first, Compare):
            word, part = rest[0]
            assert isinstance(part, Logic)
            inner = self._left_to_right(part)
            if isinstance(inner, Logic):
                return Logic(inner.first, (*inner.rest, (word, first)))
        return None


def is_number(bus: str) -> bool:
    return any(word in bus for word in _FLAG_WORDS)


def is_condition(e: Expression) -> bool:
    match e:
        case SignalState() | Compare() | Logic() | Unary("not", _):
            return True
        case Signal(bus):
            return not is_number(bus)
        case _:
            return False
