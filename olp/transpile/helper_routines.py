"""Functions that the target lacks, as routines of the translation."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from typing import Final, NamedTuple, TypeGuard

from olp.ir import expressions as ex
from olp.ir import program as st
from olp.ir.points import PointTable
from olp.ir.transformer import mapped
from olp.languages.vendor import language_of
from olp.transpile.context import Fate, TranslationContext
from olp.transpile.occurrences import changed_rare
from olp.transpile.symbols import holds_number

_BITS: Final = ("and", "or", "xor")
_BYTE: Final = 255
_WHOLE: Final = ("floor", "ceil", "trunc")
_STATE: Final = "number-of-state"  # of a signal, or a condition
_CONDITION: Final = "number-of-condition"  # where signals are numbers
_ORDERS: Final = ("<", ">", "<=", ">=")


def helper_routines(program: st.Program, work: TranslationContext) -> st.Program:
    """Powers, whole numbers, the larger of two numbers, bits and the numbers of states, computed by routines where the
    target has none."""
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
    made: dict[str, st.Routine] = field(default_factory=dict)  # by the function's name

    @property
    def asked(self) -> Callable[[ex.Expression], bool]:
        """What stands in arithmetic as a number that the target does not take for one."""
        lacks = self.work.limits.lacks
        return is_truth if _STATE in lacks else is_condition if _CONDITION in lacks else _is_state

    def asks(self, e: ex.Expression) -> bool:
        if computes_with_state(e, self.asked):
            return True
        name = e.operator if isinstance(e, ex.Binary) else e.name if isinstance(e, ex.Function) else ""
        return name in self.work.limits.lacks

    def is_bitwise(self, s: st.Statement) -> TypeGuard[st.Update]:
        """Whether bits of a variable are set (`AND B001 15`, `NOT B001 B002`) in a way that the target has not."""
        return type(s) is st.Update and (s.operator == "not" or s.operator in self.work.limits.lacks)

    def statement(self, s: st.Statement) -> st.Statement:
        if type(s) is st.SetOutput and _is_state(s.signal) and _inverts(s.value):
            return replace(s, value=ex.Unary("not", s.value.right))
        if not self.is_bitwise(s):
            return mapped(s, lambda e: self._change(e, s))
        operand = s.target if s.operand is None else s.operand
        if s.operator == "not":
            if not (_is_byte(s.target) and _is_byte(operand)):
                self.work.lose(s, Fate.REFUSED, "value", "the bits of a number beyond a byte inverted")
            return st.Assign(s.line, s.target, ex.Binary("-", ex.Number(_BYTE), operand), s.comment)
        value = self._change(ex.Binary(s.operator, s.target, operand), s)
        return st.Assign(s.line, s.target, value, s.comment)

    def _change(self, e: ex.Expression, s: st.Statement) -> ex.Expression:
        name = next((one for one in (_STATE, _CONDITION) if one in self.work.limits.lacks), "")
        if name and computes_with_state(e, self.asked):
            e = with_states(e, lambda one: self._called(name, (one,)), self.asked)
        language = language_of(self.work.target)
        if isinstance(e, ex.Binary) and e.operator in _BITS:
            if e.operator in self.work.limits.lacks:
                says = f"{language} has no bits of numbers: a loop computes them, of whole numbers from 0 on"
                self.work.lose(s, Fate.APPROXIMATED, "value", says)
            return self._called(e.operator, (e.left, e.right))
        if not isinstance(e, ex.Function) or len(e.arguments) != (1 if e.name in _WHOLE else 2):
            return e
        if e.name == "power" and "power" in self.work.limits.lacks:
            says = f"{language} has no powers: a loop multiplies, for whole exponents from 0 on"
            self.work.lose(s, Fate.APPROXIMATED, "value", says)
        return self._called(e.name, e.arguments)

    def _called(self, name: str, given: tuple[ex.Expression, ...]) -> ex.Expression:
        if name not in self.work.limits.lacks or name not in COMPUTED:
            return ex.Binary(name, *given) if name in _BITS else ex.Function(name, given)
        if name not in self.made:
            words = (f"{name}_of", "first", "second", "result", "count")
            if name in (_STATE, _CONDITION):
                words = ("number_of_state", "state", *words[2:])
            routine, *others = map(self.work.helper, words)
            self.made[name] = COMPUTED[name](_HelperNames(routine, *map(ex.Named, others)), name)
        return ex.CallValue(self.made[name].name, given)


def _is_state(e: ex.Expression) -> bool:
    """Whether it is a digital signal, which is a number in RAPID and a state elsewhere."""
    return type(e) is ex.Signal and not holds_number(e.bus)


def _inverts(e: ex.Expression) -> TypeGuard[ex.Binary]:
    """Whether it is `1 - di1`: the other state."""
    return type(e) is ex.Binary and e.operator == "-" and e.left == ex.Number(1) and _is_state(e.right)


def is_condition(e: ex.Expression) -> bool:
    """Whether it is true or false, whatever it asks."""
    return type(e) in (ex.Compare, ex.Logic) or (type(e) is ex.Unary and e.operator == "not")


def is_truth(e: ex.Expression) -> bool:
    return _is_state(e) or is_condition(e)


def computes_with_state(e: ex.Expression, asked: Callable[[ex.Expression], bool] = _is_state) -> bool:
    """Whether a digital signal takes part in arithmetic, or is asked whether it is more or less than a number.

    `asked`: what is looked for in its place.
    """
    match e:
        case ex.Binary(operator, left, right) if asked is _is_state or operator not in _BITS:
            return asked(left) or asked(right)
        case ex.Compare(operator, left, right):
            return operator in _ORDERS and (asked(left) or asked(right))
        case ex.Unary("-", operand):
            return asked(operand)
        case _:
            return False


def with_states(
    e: ex.Expression,
    number: Callable[[ex.Expression], ex.Expression],
    asked: Callable[[ex.Expression], bool] = _is_state,
) -> ex.Expression:
    """With `number` of each digital signal in the place of it, and 1 and 0 in the place of ON and OFF."""

    def one(side: ex.Expression) -> ex.Expression:
        if isinstance(side, ex.SignalState):
            return ex.Number(int(side.on))
        return number(side) if asked(side) else side

    if isinstance(e, ex.Unary):
        return replace(e, operand=one(e.operand))
    assert isinstance(e, (ex.Binary, ex.Compare))
    return replace(e, left=one(e.left), right=one(e.right))


def _is_byte(e: ex.Expression) -> bool:
    if isinstance(e, ex.Variable):
        return e.store is ex.Store.BYTE
    return isinstance(e, ex.Number) and 0 <= e.value <= _BYTE


class _HelperNames(NamedTuple):
    """Of a routine, its parameters and its variables: none that the program has."""

    routine: str
    a: ex.Named
    b: ex.Named
    result: ex.Named
    counter: ex.Named


def _routine(names: _HelperNames, kinds: tuple[str, str, str], rows: Sequence[st.Statement]) -> st.Routine:
    """`kinds`: of both parameters and of the value."""
    first, second, returns = kinds
    parameters = (st.Parameter(names.a.name, first), st.Parameter(names.b.name, second))
    body = (st.Begin(0), *rows, st.End(0))
    return st.Routine(names.routine, 0, body, PointTable(), parameters=parameters, returns=returns)


def _power(names: _HelperNames, _: str) -> st.Routine:
    result, count = names.result, names.counter
    rows: list[st.Statement] = [
        st.Declare(0, result.name, "real", None),
        st.Declare(0, count.name, "integer", None),
        st.Assign(0, result, ex.Number(1.0)),
        st.Assign(0, count, ex.Number(0)),
        st.While(0, ex.Compare("<", count, names.b)),
        st.Assign(0, result, ex.Binary("*", result, names.a)),
        st.Assign(0, count, ex.Binary("+", count, ex.Number(1))),
        st.EndWhile(0),
        st.Return(0, result),
    ]
    return _routine(names, ("real", "integer", "real"), rows)


def _larger(names: _HelperNames, function: str) -> st.Routine:
    test = ex.Compare(">" if function == "max" else "<", names.a, names.b)
    rows: list[st.Statement] = [st.If(0, test), st.Return(0, names.a), st.EndIf(0), st.Return(0, names.b)]
    return _routine(names, ("real", "real", "real"), rows)


def _whole(names: _HelperNames, function: str) -> st.Routine:
    """The nearest whole number, and one less or more where it lies on the other side."""
    a, result = names.a, names.result
    above, below = ex.Compare(">", result, a), ex.Compare("<", result, a)
    down: list[st.Statement] = [
        st.If(0, above),
        st.Assign(0, result, ex.Binary("-", result, ex.Number(1))),
        st.EndIf(0),
    ]
    up: list[st.Statement] = [
        st.If(0, below),
        st.Assign(0, result, ex.Binary("+", result, ex.Number(1))),
        st.EndIf(0),
    ]
    rows = {"floor": down, "ceil": up}.get(function) or [
        st.If(0, ex.Compare(">", a, ex.Number(0))),
        *down,
        st.Else(0),
        *up,
        st.EndIf(0),
    ]
    nearest = st.Assign(0, result, ex.Function("round", (a,)))
    body = [
        st.Begin(0),
        st.Declare(0, result.name, "integer", None),
        nearest,
        *rows,
        st.Return(0, result),
        st.End(0),
    ]
    given = (st.Parameter(a.name, "real"),)
    return st.Routine(names.routine, 0, tuple(body), PointTable(), parameters=given, returns="integer")


def _bits(names: _HelperNames, operator: str) -> st.Routine:
    """Bit by bit, the lowest first; `count` is the value of the bit."""
    _, a, b, result, count = names
    last_a, last_b = (ex.Binary("mod", one, ex.Number(2)) for one in (a, b))
    both = ex.Logic(ex.Compare("=", last_a, ex.Number(1)), (("and", ex.Compare("=", last_b, ex.Number(1))),))
    tests: dict[str, ex.Expression] = {
        "and": both,
        "or": ex.Compare(">", ex.Binary("+", last_a, last_b), ex.Number(0)),
        "xor": ex.Compare("<>", last_a, last_b),
    }
    left = ex.Logic(ex.Compare(">", a, ex.Number(0)), (("or", ex.Compare(">", b, ex.Number(0))),))
    rows: list[st.Statement] = [
        st.Declare(0, result.name, "integer", None),
        st.Declare(0, count.name, "integer", None),
        st.Assign(0, result, ex.Number(0)),
        st.Assign(0, count, ex.Number(1)),
        st.While(0, left),
        st.If(0, tests[operator]),
        st.Assign(0, result, ex.Binary("+", result, count)),
        st.EndIf(0),
        st.Assign(0, a, ex.Binary("div", a, ex.Number(2))),
        st.Assign(0, b, ex.Binary("div", b, ex.Number(2))),
        st.Assign(0, count, ex.Binary("*", count, ex.Number(2))),
        st.EndWhile(0),
        st.Return(0, result),
    ]
    return _routine(names, ("integer", "integer", "integer"), rows)


def _number_of_state(names: _HelperNames, _: str) -> st.Routine:
    state = names.a
    on = ex.Compare("=", state, ex.SignalState(True))
    rows = (
        st.Begin(0),
        st.If(0, on),
        st.Return(0, ex.Number(1)),
        st.EndIf(0),
        st.Return(0, ex.Number(0)),
        st.End(0),
    )
    given = (st.Parameter(state.name, "boolean"),)
    return st.Routine(names.routine, 0, rows, PointTable(), parameters=given, returns="integer")


COMPUTED: Final[dict[str, Callable[[_HelperNames, str], st.Routine]]] = {
    "power": _power,
    "max": _larger,
    "min": _larger,
    **dict.fromkeys(_WHOLE, _whole),
    **dict.fromkeys(_BITS, _bits),
    **dict.fromkeys((_STATE, _CONDITION), _number_of_state),
}
