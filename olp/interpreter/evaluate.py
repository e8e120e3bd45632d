"""The value of an expression, as the controller would compute it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from olp.expression import (
    Argument,
    Binary,
    CallValue,
    Compare,
    Element,
    Expression,
    FrameRef,
    Function,
    Item,
    Logic,
    Member,
    Named,
    NamedArgument,
    Number,
    PositionLiteral,
    Quantity,
    RecordLiteral,
    Signal,
    State,
    SystemValue,
    Taught,
    Text,
    Unary,
    Unknown,
    Variable,
)
from olp.interpreter.arithmetic import calculate, compare, round_half_away
from olp.interpreter.memory import PositionValue, Value
from olp.interpreter.spelling import spell
from olp.interpreter.state import Machine, StatementError
from olp.interpreter.variables import read_variable, store_variable


def evaluate(m: Machine, expression: Expression) -> Value:
    """The value of `expression`. Raises StatementError for what has none."""
    return _EVALUATORS[type(expression)](m, expression)


def number(m: Machine, expression: Expression) -> int | float:
    """The value as a number; on and off count as 1 and 0. Raises StatementError (I201) for anything else."""
    if type(expression) is Number:
        return expression.value
    value = evaluate(m, expression)
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
    value = evaluate(m, condition)
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


def _binary(m: Machine, e: Binary) -> Value:
    left, right = evaluate(m, e.left), evaluate(m, e.right)
    if isinstance(left, PositionValue):
        from olp.interpreter.elements import combine

        if isinstance(right, (int, float, PositionValue)):
            return combine(e.operator, left, right)
    return calculate(e.operator, left, right)


def _compare(m: Machine, e: Compare) -> Value:
    return compare(e.operator, evaluate(m, e.left), evaluate(m, e.right))


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


def _signal(m: Machine, e: Signal) -> Value:
    from olp.interpreter.signals import read_signal

    return read_signal(m, e)


def _argument(m: Machine, e: Argument) -> Value:
    arguments = m.frame.arguments
    if 0 < e.number <= len(arguments):
        return arguments[e.number - 1]
    m.assume(f"argument {e.number} was not passed by the caller: taken as 0")
    return 0


def _element(m: Machine, e: Element) -> Value:
    from olp.interpreter.elements import read_element

    return read_element(m, e)


def _system(m: Machine, e: SystemValue) -> Value:
    from olp.interpreter.system import read_system_value

    return read_system_value(m, e)


def _function(m: Machine, e: Function) -> Value:
    from olp.interpreter.functions import call_function

    return call_function(m, e)


def _unknown(m: Machine, e: Unknown) -> Value:
    raise StatementError("I209", f"nothing defines {e.text}", "declare the name, or correct it")


def _frame(m: Machine, e: FrameRef) -> Value:
    from olp.interpreter.functions import frame_value

    return frame_value(m, e)


def _named(m: Machine, e: Named) -> Value:
    from olp.interpreter.scope import read_name

    return read_name(m, e.name)


def _item(m: Machine, e: Item) -> Value:
    from olp.interpreter.structures import read_item

    return read_item(m, e)


def _member(m: Machine, e: Member) -> Value:
    from olp.interpreter.structures import read_member

    return read_member(m, e)


def _position_literal(m: Machine, e: PositionLiteral) -> Value:
    from olp.interpreter.structures import literal_position

    return literal_position(e)


def _record(m: Machine, e: RecordLiteral) -> Value:
    from olp.interpreter.scope import literal

    return literal(m, e)


def _call_value(m: Machine, e: CallValue) -> Value:
    from olp.interpreter.flow import value_of_call

    return value_of_call(m, e)


def _named_argument(m: Machine, e: NamedArgument) -> Value:
    return True if e.value is None else evaluate(m, e.value)


_EVALUATORS: Mapping[type, Callable[[Machine, Any], Value]] = {
    Number: lambda m, e: e.value,
    Text: lambda m, e: e.value,
    State: lambda m, e: e.on,
    Variable: _variable,
    Taught: _taught,
    Element: _element,
    Signal: _signal,
    SystemValue: _system,
    Argument: _argument,
    FrameRef: _frame,
    Unary: _unary,
    Binary: _binary,
    Compare: _compare,
    Logic: _logic,
    Function: _function,
    Unknown: _unknown,
    Named: _named,
    Item: _item,
    Member: _member,
    PositionLiteral: _position_literal,
    RecordLiteral: _record,
    CallValue: _call_value,
    NamedArgument: _named_argument,
}
