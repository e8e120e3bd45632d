"""What a template can do with a value: the filters, and the rule that only texts and numbers are written."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Any

from jinja2 import Undefined
from jinja2.exceptions import SecurityError


def scalar(value: Any) -> str:
    """The text of a text or number. Raises SecurityError for anything else, UndefinedError for what is missing."""
    if isinstance(value, (str, int, float, Undefined)):
        return str(value)
    raise SecurityError(f"only texts and numbers can be written, not a {type(value).__name__}")


def fixed(value: float, decimals: int = 3) -> str:
    """`value` with that many decimals (at most 9), never "-0"."""
    text = f"{float(value):.{min(max(int(decimals), 0), 9)}f}"
    return text.lstrip("-") if not text.strip("-0.") else text


def short(value: float, digits: int = 3) -> str:
    """`value` rounded to that many digits, without an exponent or needless zeros: 592, 7.41, 0.0533."""
    number = float(value)
    if not number or not math.isfinite(number):
        return "0" if not number else str(number)
    decimals = min(max(int(digits), 1), 9) - 1 - math.floor(math.log10(abs(number)))
    text = fixed(round(number, decimals), max(decimals, 0))
    return text.rstrip("0").rstrip(".") if "." in text else text


def known(value: Any) -> bool:
    """Whether `value` is a number and not nan, None or an empty text."""
    return (isinstance(value, str) and bool(value)) or (isinstance(value, (int, float)) and value == value)


def cut(text: str, width: int) -> str:
    """The first `width` characters."""
    return scalar(text)[: max(int(width), 0)]


def default(value: Any, other: Any = "") -> Any:
    """`other` where `value` is undefined or None."""
    return other if value is None or isinstance(value, Undefined) else value


FILTERS: Mapping[str, Callable[..., Any]] = {
    "fixed": fixed,
    "short": short,
    "known": known,
    "cut": cut,
    "default": default,
    "upper": lambda text: scalar(text).upper(),
    "lower": lambda text: scalar(text).lower(),
    "trim": lambda text: scalar(text).strip(),
    "round": lambda value: round(float(value)),
    "abs": lambda value: abs(value) if isinstance(value, (int, float)) else abs(float(value)),
    "length": len,
    "first": lambda items: items[0],
    "last": lambda items: items[-1],
}
