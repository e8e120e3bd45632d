"""Arithmetic of numbers and texts, within the controller's limits."""

from __future__ import annotations

import math
import operator
from collections.abc import Callable, Mapping
from typing import Any, Final

from olp.runtime.memory import Value
from olp.runtime.state import StatementError

_LARGEST: Final = 1e30  # larger than any variable of a controller holds in practice
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


def calculate(sign: str, left: Value, right: Value) -> Value:
    """`left sign right` on numbers or strings; `/` of two integers is exact. Raises StatementError."""
    if isinstance(left, str) and isinstance(right, str) and sign == "+":
        return left + right
    if not isinstance(left, (int, float)) or not isinstance(right, (int, float)):
        raise StatementError("I201", f"'{sign}' needs two numbers")
    if sign in _BITWISE:
        return int(_BITWISE[sign](int(left), int(right)))
    if sign in ("/", "mod", "div"):
        if right == 0:
            raise StatementError("I207", "division by zero", "the controller stops with an alarm here")
        if sign == "mod":
            return _remainder(left, right)
        if sign == "div":
            return math.trunc(left / right)
        exact = isinstance(left, int) and isinstance(right, int) and left % right == 0
        return left // right if exact else left / right
    if sign not in _ARITHMETIC:
        raise StatementError("I216", f"the operator {sign} is not known to the interpreter")
    result: int | float = _ARITHMETIC[sign](left, right)
    return finite(result)


def finite(value: int | float) -> int | float:
    """The value; one beyond every variable of a controller is refused (I202)."""
    if not -_LARGEST <= value <= _LARGEST:
        raise StatementError("I202", "the value is too large for any variable", "check the operands")
    return value


def _remainder(left: float, right: float) -> int | float:
    if isinstance(left, int) and isinstance(right, int):
        # Truncating division, as integers divide: the remainder takes the sign of the dividend.
        rest = abs(left) % abs(right)
        return -rest if left < 0 else rest
    return math.fmod(left, right)


def compare(sign: str, left: Value, right: Value) -> bool:
    """`left sign right` on two numbers or two texts. Raises StatementError (I208) on anything else."""
    texts = isinstance(left, str) and isinstance(right, str)
    numbers = isinstance(left, (int, float)) and isinstance(right, (int, float))
    if not texts and not numbers:
        raise StatementError("I208", "these two values cannot be compared", "compare numbers, or texts")
    return _COMPARE[sign](left, right)


def round_half_away(value: float) -> int:
    """The nearest whole number, halves away from zero. Raises StatementError (I202) for infinite values."""
    if not math.isfinite(value):
        raise StatementError("I202", "the value is not finite", "check the operands")
    return int(math.copysign(math.floor(abs(value) + 0.5), value))
