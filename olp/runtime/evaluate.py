"""The value of an expression, as the controller would compute it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from olp.ir.expressions import (
    Argument,
    Compare,
    Expression,
    Logic,
    NamedArgument,
    Number,
    Quantity,
    SignalState,
    Taught,
    Text,
    Unary,
    Unknown,
    Variable,
)
from olp.runtime.arithmetic import compare, round_half_away
from olp.runtime.memory import PositionValue, Value
from olp.runtime.spelling import spell
from olp.runtime.state import Machine, StatementError
from olp.runtime.variables import read_variable, store_variable


def evaluate(m: Machine, expression: Expression) -> Value:
    """The value of `expression`. Raises StatementError for what has none."""
    return m.operations.evaluators[type(expression)](m, expression)


def known(m: Machine, expression: Expression, otherwise: Value) -> Value:
    """The value, `otherwise` where no file says it and it may be assumed, which is reported."""
    try:
        return evaluate(m, expression)
    except StatementError as problem:
        if not m.may_assume(problem) or problem.code == "I215":
            raise
        m.fault(problem, f"taken as {_shown(otherwise)}")
        return otherwise


def _shown(value: Value) -> str:
    if isinstance(value, bool):
        return "on" if value else "off"
    return "an empty text" if value == "" else str(value)


def number(m: Machine, expression: Expression) -> int | float:
    """The value as a number; on and off count as 1 and 0. Raises StatementError (I201) for anything else."""
    if type(expression) is Number:
        return expression.value
    value = known(m, expression, 0)
    if isinstance(value, (int, float)):
        return value
    raise StatementError(
        "I201", f"{spell(expression)} is not a number", "use a byte, integer, double or real variable"
    )


def whole(m: Machine, expression: Expression) -> int:
    """The value as a whole number, for indices and counts. Raises StatementError (I201)."""
    value = number(m, expression)
    return value if type(value) is int else round_half_away(value)


def quantity(m: Machine, value: Quantity) -> float:
    """The SI value of a number with a unit."""
    literal = value.literal
    return float(literal) if literal is not None else number(m, value.written) * value.scale


def holds(m: Machine, condition: Expression) -> bool:
    """Whether a condition is true; a bare number or signal counts as true when it is not zero."""
    value = known(m, condition, False)
    return bool(value) if isinstance(value, (bool, int, float)) else value != ""


def write_variable(m: Machine, target: Variable, value: Value) -> None:
    """Stores a value as the variable's kind holds it. Raises StatementError when it does not fit."""
    store_variable(m, target.store, whole(m, target.index), target.local, value)


def _variable(m: Machine, v: Variable) -> Value:
    index = v.index.value if type(v.index) is Number else whole(m, v.index)
    return read_variable(m, v.store, int(index), v.local)


def _taught(m: Machine, taught: Taught) -> Value:
    point = m.frame.job.points.find(taught.store, True, taught.number)
    if point is None:
        raise StatementError(
            "I206", f"the routine teaches no {spell(taught)}", "add the point, or correct its number"
        )
    return PositionValue(point.state, point.values)


def _unary(m: Machine, e: Unary) -> Value:
    if e.operator == "not":
        value = evaluate(m, e.operand)
        return not value if isinstance(value, bool) else ~_as_int(value, e.operand) & 0xFF
    return -number(m, e.operand)


def _as_int(value: Value, what: Expression) -> int:
    if isinstance(value, int):
        return value
    raise StatementError(
        "I201", f"{spell(what)} is not a whole number", "use a byte, integer or double variable"
    )


def _compare(m: Machine, e: Compare) -> Value:
    return compare(e.operator, *both(m, e.left, e.right))


def both(m: Machine, left: Expression, right: Expression) -> tuple[Value, Value]:
    """Two values that are compared or combined: one that no file says is the zero of the other's kind."""
    try:
        first = evaluate(m, left)
    except StatementError as problem:
        if not m.may_assume(problem) or problem.code == "I215":
            raise
        second = known(m, right, 0)
        return known(m, left, _zero_like(second, problem)), second
    try:
        return first, evaluate(m, right)
    except StatementError as problem:
        if not m.may_assume(problem) or problem.code == "I215":
            raise
        zero = _zero_like(first, problem)
        m.fault(problem, f"taken as {_shown(zero)}")
        return first, zero


def _zero_like(value: Value, problem: StatementError) -> Value:
    """Nothing, of the kind of `value`. Raises `problem` where there is none: a position is somewhere."""
    if isinstance(value, (bool, int, float, str)):
        return type(value)()
    raise problem


def _logic(m: Machine, e: Logic) -> Value:
    # Every operand is evaluated: which inputs are read must not depend on the order of writing.
    result = holds(m, e.first)
    for word, condition in e.rest:
        value = holds(m, condition)
        result = _JOINED[word](result, value)
    return result


_JOINED: Mapping[str, Callable[[bool, bool], bool]] = {
    "and": lambda a, b: a and b,
    "or": lambda a, b: a or b,
    "xor": lambda a, b: a is not b,
}


def _argument(m: Machine, e: Argument) -> Value:
    arguments = m.frame.arguments
    if 0 < e.number <= len(arguments):
        return arguments[e.number - 1]
    m.assume(f"argument {e.number} was not passed by the caller: taken as 0")
    return 0


def _unknown(m: Machine, e: Unknown) -> Value:
    certain = m.conventions.taught_frames  # a language without names: the text is a mistake
    raise StatementError(
        "I209", f"nothing defines {e.text}", "declare the name, or correct it", certain=certain
    )


def _named_argument(m: Machine, e: NamedArgument) -> Value:
    return True if e.value is None else evaluate(m, e.value)


# What needs no other part of the interpreter; machine.py adds the rest.
PLAIN: Mapping[type, Callable[[Machine, Any], Value]] = {
    Number: lambda m, e: e.value,
    Text: lambda m, e: e.value,
    SignalState: lambda m, e: e.on,
    Variable: _variable,
    Taught: _taught,
    Argument: _argument,
    Unary: _unary,
    Compare: _compare,
    Logic: _logic,
    Unknown: _unknown,
    NamedArgument: _named_argument,
}
