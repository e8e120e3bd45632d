"""Functions that the target lacks, as routines of the translation."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from typing import Final, NamedTuple, TypeGuard

from olp.ir.expressions import (
    Binary,
    CallValue,
    Compare,
    Expression,
    Function,
    Logic,
    Named,
    Number,
    Store,
    Variable,
)
from olp.ir.points import PointTable
from olp.ir.program import (
    Assign,
    Begin,
    Declare,
    Else,
    End,
    EndIf,
    EndWhile,
    If,
    Parameter,
    Program,
    Return,
    Routine,
    Statement,
    Update,
    While,
)
from olp.ir.transformer import mapped
from olp.languages.vendor import language_of
from olp.transpile.context import Fate, TranslationContext
from olp.transpile.occurrences import changed_rare

_BITS: Final = ("and", "or", "xor")
_BYTE: Final = 255
_WHOLE: Final = ("floor", "ceil", "trunc")


def helper_routines(program: Program, work: TranslationContext) -> Program:
    """Powers, whole numbers, the larger of two numbers and bits, computed by routines where the target has none."""
    if not work.limits.lacks:
        return program
    own = _Helpers(work)
    routines = [
        changed_rare(r, look, own.statement)
        if any(map(own.asks, look.expressions)) or any(own.is_bitwise(s) for _, s in look.rare)
        else r
        for r in program.routines
        for look in (work.look(r),)
    ]
    return replace(program, routines=(*routines, *own.made.values()))


@dataclass(slots=True)
class _Helpers:
    work: TranslationContext
    made: dict[str, Routine] = field(default_factory=dict)  # by the function's name

    def asks(self, e: Expression) -> bool:
        name = e.operator if isinstance(e, Binary) else e.name if isinstance(e, Function) else ""
        return name in self.work.limits.lacks

    def is_bitwise(self, s: Statement) -> TypeGuard[Update]:
        """Whether bits of a variable are set (`AND B001 15`, `NOT B001 B002`) in a way that the target has not."""
        return type(s) is Update and (s.operator == "not" or s.operator in self.work.limits.lacks)

    def statement(self, s: Statement) -> Statement:
        if not self.is_bitwise(s):
            return mapped(s, lambda e: self._change(e, s))
        operand = s.target if s.operand is None else s.operand
        if s.operator == "not":
            if not (_is_byte(s.target) and _is_byte(operand)):
                self.work.lose(s, Fate.REFUSED, "value", "the bits of a number beyond a byte inverted")
            return Assign(s.line, s.target, Binary("-", Number(_BYTE), operand), s.comment)
        value = self._change(Binary(s.operator, s.target, operand), s)
        return Assign(s.line, s.target, value, s.comment)

    def _change(self, e: Expression, s: Statement) -> Expression:
        language = language_of(self.work.target)
        if isinstance(e, Binary) and e.operator in _BITS:
            if e.operator in self.work.limits.lacks:
                says = f"{language} has no bits of numbers: a loop computes them, of whole numbers from 0 on"
                self.work.lose(s, Fate.APPROXIMATED, "value", says)
            return self._called(e.operator, (e.left, e.right))
        if not isinstance(e, Function) or len(e.arguments) != (1 if e.name in _WHOLE else 2):
            return e
        if e.name == "power" and "power" in self.work.limits.lacks:
            says = f"{language} has no powers: a loop multiplies, for whole exponents from 0 on"
            self.work.lose(s, Fate.APPROXIMATED, "value", says)
        return self._called(e.name, e.arguments)

    def _called(self, name: str, given: tuple[Expression, ...]) -> Expression:
        if name not in self.work.limits.lacks or name not in COMPUTED:
            return Binary(name, *given) if name in _BITS else Function(name, given)
        if name not in self.made:
            words = (f"{name}_of", "first", "second", "result", "count")
            routine, *others = map(self.work.helper, words)
            self.made[name] = COMPUTED[name](_HelperNames(routine, *map(Named, others)), name)
        return CallValue(self.made[name].name, given)


def _is_byte(e: Expression) -> bool:
    if isinstance(e, Variable):
        return e.store is Store.BYTE
    return isinstance(e, Number) and 0 <= e.value <= _BYTE


class _HelperNames(NamedTuple):
    """Of a routine, its parameters and its variables: none that the program has."""

    routine: str
    a: Named
    b: Named
    result: Named
    counter: Named


def _routine(names: _HelperNames, kinds: tuple[str, str, str], rows: Sequence[Statement]) -> Routine:
    """`kinds`: of both parameters and of the value."""
    first, second, returns = kinds
    parameters = (Parameter(names.a.name, first), Parameter(names.b.name, second))
    body = (Begin(0), *rows, End(0))
    return Routine(names.routine, 0, body, PointTable(), parameters=parameters, returns=returns)


def _power(names: _HelperNames, _: str) -> Routine:
    result, count = names.result, names.counter
    rows: list[Statement] = [
        Declare(0, result.name, "real", None),
        Declare(0, count.name, "integer", None),
        Assign(0, result, Number(1.0)),
        Assign(0, count, Number(0)),
        While(0, Compare("<", count, names.b)),
        Assign(0, result, Binary("*", result, names.a)),
        Assign(0, count, Binary("+", count, Number(1))),
        EndWhile(0),
        Return(0, result),
    ]
    return _routine(names, ("real", "integer", "real"), rows)


def _larger(names: _HelperNames, function: str) -> Routine:
    test = Compare(">" if function == "max" else "<", names.a, names.b)
    rows: list[Statement] = [If(0, test), Return(0, names.a), EndIf(0), Return(0, names.b)]
    return _routine(names, ("real", "real", "real"), rows)


def _whole(names: _HelperNames, function: str) -> Routine:
    """The nearest whole number, and one less or more where it lies on the other side."""
    a, result = names.a, names.result
    above, below = Compare(">", result, a), Compare("<", result, a)
    down: list[Statement] = [If(0, above), Assign(0, result, Binary("-", result, Number(1))), EndIf(0)]
    up: list[Statement] = [If(0, below), Assign(0, result, Binary("+", result, Number(1))), EndIf(0)]
    rows = {"floor": down, "ceil": up}.get(function) or [
        If(0, Compare(">", a, Number(0))),
        *down,
        Else(0),
        *up,
        EndIf(0),
    ]
    nearest = Assign(0, result, Function("round", (a,)))
    body = [Begin(0), Declare(0, result.name, "integer", None), nearest, *rows, Return(0, result), End(0)]
    given = (Parameter(a.name, "real"),)
    return Routine(names.routine, 0, tuple(body), PointTable(), parameters=given, returns="integer")


def _bits(names: _HelperNames, operator: str) -> Routine:
    """Bit by bit, the lowest first; `count` is the value of the bit."""
    _, a, b, result, count = names
    last_a, last_b = (Binary("mod", one, Number(2)) for one in (a, b))
    both = Logic(Compare("=", last_a, Number(1)), (("and", Compare("=", last_b, Number(1))),))
    tests: dict[str, Expression] = {
        "and": both,
        "or": Compare(">", Binary("+", last_a, last_b), Number(0)),
        "xor": Compare("<>", last_a, last_b),
    }
    left = Logic(Compare(">", a, Number(0)), (("or", Compare(">", b, Number(0))),))
    rows: list[Statement] = [
        Declare(0, result.name, "integer", None),
        Declare(0, count.name, "integer", None),
        Assign(0, result, Number(0)),
        Assign(0, count, Number(1)),
        While(0, left),
        If(0, tests[operator]),
        Assign(0, result, Binary("+", result, count)),
        EndIf(0),
        Assign(0, a, Binary("div", a, Number(2))),
        Assign(0, b, Binary("div", b, Number(2))),
        Assign(0, count, Binary("*", count, Number(2))),
        EndWhile(0),
        Return(0, result),
    ]
    return _routine(names, ("integer", "integer", "integer"), rows)


COMPUTED: Final[dict[str, Callable[[_HelperNames, str], Routine]]] = {
    "power": _power,
    "max": _larger,
    "min": _larger,
    **dict.fromkeys(_WHOLE, _whole),
    **dict.fromkeys(_BITS, _bits),
}
