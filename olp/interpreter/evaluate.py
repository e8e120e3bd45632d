"""The value of an expression, as the controller would compute it."""

from __future__ import annotations

import math
import operator
from collections.abc import Callable, Mapping
from typing import Any

from olp.assumptions import VARIABLE_LETTERS
from olp.expression import (
    POSITION_STORES,
    Argument,
    Binary,
    Compare,
    Element,
    Expression,
    FrameRef,
    Function,
    Logic,
    Number,
    Quantity,
    Signal,
    State,
    Store,
    SystemValue,
    Taught,
    Text,
    Unary,
    Unknown,
    Variable,
)
from olp.interpreter.memory import INTEGERS, RANGES, PositionValue, SystemPosition, Value, zero
from olp.interpreter.spelling import spell
from olp.interpreter.state import Machine, StatementError

_POSITION_PARTS = (Store.ROBOT, Store.BASE, Store.STATION)


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
    return literal if literal is not None else number(m, value.written) * value.scale


def holds(m: Machine, condition: Expression) -> bool:
    """Whether a condition is true; a bare number or signal counts as true when it is not zero."""
    value = evaluate(m, condition)
    return bool(value) if isinstance(value, (bool, int, float)) else value != ""


def round_half_away(value: float) -> int:
    """The nearest whole number, halves away from zero. Raises StatementError (I202) for infinite values."""
    if not math.isfinite(value):
        raise StatementError("I202", "the value is not finite", "check the operands")
    return int(math.copysign(math.floor(abs(value) + 0.5), value))


def read_variable(m: Machine, store: Store, index: int, local: bool) -> Value:
    """A variable's value; one that nobody ever set holds zero, which is reported."""
    key = (store, index)
    values = m.frame.locals if local else m.memory.values
    value = values.get(key)
    if value is not None:
        return value
    if store is Store.SYSTEM:
        parts = ((part, values.get((part, index))) for part in _POSITION_PARTS)
        held = tuple(
            (part, part_value) for part, part_value in parts if isinstance(part_value, PositionValue)
        )
        if held:
            return SystemPosition(held)
    value = values[key] = zero(store)
    name = f"{'L' if local else ''}{VARIABLE_LETTERS[store]}{index:03d}"
    if store in POSITION_STORES:
        del values[key]
        raise StatementError(
            "I203",
            f"position {name} has no value",
            f"put VAR.DAT beside the job, or say it in olp.toml: [variables] {name} = {{ pulse = [ … ] }}",
        )
    shown = '""' if store is Store.STRING else "0"
    where = "never set before it is read here" if local else "not in VAR.DAT or olp.toml"
    m.assume(f"{name} is taken as {shown}: {where}")
    return value


def write_variable(m: Machine, target: Variable, value: Value) -> None:
    """Stores a value as the variable's kind holds it. Raises StatementError when it does not fit."""
    key = (target.store, whole(m, target.index))
    if target.store is Store.SYSTEM:
        _write_system(m, key[1], target.local, value)
        return
    held = coerce(m, target.store, value)
    if target.local:
        if m.frame.locals.get(key) != held:
            m.memory.stamp += 1
            m.memory.changed[(target.store, -1 - key[1])] = m.memory.stamp
        m.frame.locals[key] = held
    else:
        m.memory.put(key, held)


def _write_system(m: Machine, index: int, local: bool, value: Value) -> None:
    if not isinstance(value, SystemPosition):
        raise StatementError(
            "I204", "only a whole system position can be stored here", "use a PX variable or $PX000"
        )
    for store, part in value.parts:
        write_variable(m, Variable(store, Number(index), local), part)


def coerce(m: Machine, store: Store, value: Value) -> Value:
    """`value` as a variable of kind `store` holds it."""
    if store in INTEGERS:
        return _integer(m, store, value)
    if store is Store.REAL:
        if isinstance(value, (int, float)):
            return float(value)
        raise StatementError("I204", "a real variable holds numbers only")
    if store is Store.STRING:
        return value if isinstance(value, str) else _as_text(value)
    if isinstance(value, PositionValue):
        return value
    raise StatementError("I204", "a position variable holds positions only", "set its elements one by one")


def _integer(m: Machine, store: Store, value: Value) -> int:
    if isinstance(value, str):
        value = _parsed(value)
    if not isinstance(value, (int, float)):
        raise StatementError("I204", "an integer variable holds numbers only")
    result = value
    if isinstance(value, float):
        result = round_half_away(value)
        if result != value:
            m.assume("a real value is rounded to the nearest integer, halves away from zero")
    low, high = RANGES[store]
    if not low <= result <= high:
        raise StatementError(
            "I205",
            f"{result} does not fit a {store.value} variable ({low} .. {high}): it keeps its value",
            "the controller stops with an alarm here; use a wider variable",
        )
    return int(result)


def _parsed(text: str) -> float:
    try:
        return float(text)
    except ValueError:
        raise StatementError("I204", f"the text {text[:40]!r} is not a number") from None


def _as_text(value: Value) -> str:
    if isinstance(value, bool):
        return "ON" if value else "OFF"
    if isinstance(value, (int, float)):
        return str(value)
    raise StatementError("I204", "a position cannot become a text")


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
    raise StatementError("I201", f"{spell(what)} is not a whole number")


def _binary(m: Machine, e: Binary) -> Value:
    left, right = evaluate(m, e.left), evaluate(m, e.right)
    return calculate(e.operator, left, right)


def calculate(sign: str, left: Value, right: Value) -> Value:
    """`left sign right` on numbers or strings; `/` of two integers is exact. Raises StatementError."""
    if isinstance(left, str) and isinstance(right, str) and sign == "+":
        return left + right
    if not isinstance(left, (int, float)) or not isinstance(right, (int, float)):
        raise StatementError("I201", f"'{sign}' needs two numbers")
    if sign in _BITWISE:
        return int(_BITWISE[sign](int(left), int(right)))
    if sign in ("/", "mod"):
        if right == 0:
            raise StatementError("I207", "division by zero", "the controller stops with an alarm here")
        if sign == "mod":
            return _remainder(left, right)
        exact = isinstance(left, int) and isinstance(right, int) and left % right == 0
        return left // right if exact else left / right
    try:
        result: Value = _ARITHMETIC[sign](left, right)
    except OverflowError:
        raise StatementError("I202", "the value is not finite", "check the operands") from None
    return result


def _remainder(left: float, right: float) -> int | float:
    if isinstance(left, int) and isinstance(right, int):
        # Truncating division, as integer DIV has it: the remainder takes the sign of the dividend.
        return int(math.copysign(abs(left) % abs(right), left))
    return math.fmod(left, right)


_ARITHMETIC: Mapping[str, Callable[[Any, Any], Any]] = {
    "+": operator.add,
    "-": operator.sub,
    "*": operator.mul,
}
_BITWISE: Mapping[str, Callable[[int, int], int]] = {
    "and": operator.and_,
    "or": operator.or_,
    "xor": operator.xor,
}
_COMPARE: Mapping[str, Callable[[Any, Any], bool]] = {
    "=": operator.eq,
    "<>": operator.ne,
    "<": operator.lt,
    ">": operator.gt,
    "<=": operator.le,
    ">=": operator.ge,
}


def _compare(m: Machine, e: Compare) -> Value:
    left, right = evaluate(m, e.left), evaluate(m, e.right)
    if isinstance(left, str) is not isinstance(right, str):
        raise StatementError(
            "I208", f"{spell(e.left)} and {spell(e.right)} cannot be compared", "compare like with like"
        )
    return _COMPARE[e.operator](left, right)


def _logic(m: Machine, e: Logic) -> Value:
    # Every operand is evaluated: which inputs are read must not depend on the order of writing.
    result = holds(m, e.first)
    for word, condition in e.rest:
        value = holds(m, condition)
        result = (result and value) if word == "and" else (result or value)
    return result


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
}
