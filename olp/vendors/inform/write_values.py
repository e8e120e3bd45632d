"""Spells values, variables, arithmetic and conditions in INFORM: the way back of `values` and `expressions`."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from typing import Final

from olp import called
from olp.expression import (
    Binary,
    Compare,
    Element,
    Expression,
    FrameRef,
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

LETTERS: Final = {
    Store.BYTE: "B",
    Store.INTEGER: "I",
    Store.DOUBLE: "D",
    Store.REAL: "R",
    Store.STRING: "S",
    Store.ROBOT: "P",
    Store.BASE: "BP",
    Store.STATION: "EX",
    Store.SYSTEM: "PX",
}
TAUGHT_LETTERS: Final = {Store.ROBOT: "C", Store.BASE: "BC", Store.STATION: "EC"}
BUSES: Final = {
    "in": "IN",
    "out": "OT",
    "in-group": "IG",
    "out-group": "OG",
    "in-half-group": "IGH",
    "out-half-group": "OGH",
    "system-in": "SIN",
    "system-out": "SOUT",
    "direct-in": "RIN",
    "analog-in": "AI",
    "analog-out": "AO",
    "register": "MREG",
}
FRAMES: Final = {"base": "BF", "robot": "RF", "tool": "TF", "master-tool": "MTF"}
_NO_TEXT = frozenset('"\r\n')  # what no text holds
_POSITION_VALUES = {"position-pulse": "$PX000", "position-pose": "$PX001"}
_STRENGTH = {"+": 1, "-": 1, "*": 2, "/": 2}
_MOST_DECIMALS = 9


class CannotSayError(Exception):
    """INFORM has no words for it. `help`: what could be done."""

    def __init__(self, message: str, help: str = "") -> None:
        super().__init__(message)
        self.help = help


@lru_cache(maxsize=20_000)
def decimal(value: float, at_least: int = 0) -> str:
    """`value` as a decimal fraction with that many decimals, more where it has more; never "-0", never an exponent."""
    if not math.isfinite(value):
        raise CannotSayError(f"{value} is no number that a job can hold")
    text = f"{value:.{at_least}f}"
    if float(text) != value:
        text = f"{value:.{_MOST_DECIMALS}f}".rstrip("0")
        text += "0" * (at_least - len(text.partition(".")[2]))
    return text.lstrip("-") if not text.strip("-0.") else text.rstrip(".")


def number(literal: Number) -> str:
    """A literal as it stands in an expression: 12 stays whole, 12.0 keeps its point."""
    value = literal.value
    return decimal(value, 1) if isinstance(value, float) else str(int(value))


@dataclass(frozen=True, slots=True)
class Words:
    """How one job spells. `digits`: of a variable's number; `point_digits`: of a taught point's."""

    aliases: Mapping[str, Variable]
    digits: int = 3
    point_digits: int = 5
    station_letter: str = "EC"

    # --- names ------------------------------------------------------------------------------------------

    def variable(self, it: Variable) -> str:
        if it.name and self.aliases.get(it.name) == it:
            return it.name
        letter = ("L" if it.local else "") + LETTERS[it.store]
        if type(it.index) is not Number:
            return f"{letter}[{self.expression(it.index)}]"
        return f"{letter}{int(it.index.value):0{self.digits}d}"

    def taught(self, it: Taught) -> str:
        letter = self.station_letter if it.store is Store.STATION else TAUGHT_LETTERS.get(it.store, "")
        if not letter:
            raise CannotSayError(f"a taught position as a {called.STORES[it.store]}")
        return f"{letter}{it.number:0{self.point_digits}d}"

    def position(self, it: Expression) -> str:
        if type(it) is Taught:
            return self.taught(it)
        return self.value(it)

    def signal(self, it: Signal) -> str:
        """Without the half of a register, which stands behind it as a word of its own."""
        if it.bus not in BUSES:
            raise CannotSayError(*called.signal(it))
        return f"{BUSES[it.bus]}#({self.value(it.index)})"

    def frame(self, it: FrameRef) -> str:
        if it.number is not None and it.kind in ("user", "tool"):
            return f"{'UF' if it.kind == 'user' else 'TL'}#({self.value(it.number)})"
        if it.kind not in FRAMES:
            raise CannotSayError(called.SYSTEMS.get(it.kind, it.kind))
        return FRAMES[it.kind]

    def system(self, it: SystemValue) -> str:
        if it.name == "returned":
            return "$RV"
        if it.name in _POSITION_VALUES:
            return _POSITION_VALUES[it.name]
        letters = {store.value: letter for store, letter in LETTERS.items()}
        if it.name not in letters:
            raise CannotSayError(called.value(it.name))
        return f"${letters[it.name]}{it.index:03d}"

    # --- values -----------------------------------------------------------------------------------------

    def value(self, it: Expression) -> str:
        """A single value, as instructions take it."""
        match it:
            case Number():
                return number(it)
            case Variable():
                return self.variable(it)
            case Taught():
                return self.taught(it)
            case Text(text):
                if not _NO_TEXT.isdisjoint(text):
                    raise CannotSayError('a text that holds " or a line end')
                return f'"{text}"'
            case State(on):
                return "ON" if on else "OFF"
            case Unknown(text):
                return text
            case FrameRef():
                return self.frame(it)
            case _:
                raise CannotSayError(
                    "a computed value in this place", "compute it into a variable with SET … EXPRESS first"
                )

    def expression(self, it: Expression, strength: int = 0) -> str:
        """Arithmetic, as it stands behind EXPRESS; in parentheses where it binds less than `strength`."""
        match it:
            case Binary(operator, left, right) if operator in _STRENGTH:
                own = _STRENGTH[operator]
                text = f"{self.expression(left, own)} {operator} {self.expression(right, own + 1)}"
                return f"( {text} )" if own < strength else text
            case Unary("-", operand):
                return f"-{self.expression(operand, 3)}"
            case Signal():
                return self.signal(it)
            case SystemValue(name):
                raise CannotSayError(f"{called.value(name)} within a computation")
            case Binary(operator) | Unary(operator):
                raise CannotSayError(called.operation(operator), "EXPRESS has + - * and /")
            case Compare() | Logic() | Element():
                raise CannotSayError(
                    "a comparison or an element within a computation", "EXPRESS has + - * and /"
                )
            case _:
                return self.value(it)

    def condition(self, it: Expression, express: bool) -> str:
        """A condition; `express`: joined by ANDEXP and OREXP instead of ANDIF and ORIF."""
        ending = "EXP" if express else "IF"
        if type(it) is Logic:
            rest = (f" {word.upper()}{ending} {self._comparison(other)}" for word, other in it.rest)
            return self._comparison(it.first) + "".join(rest)
        return self._comparison(it)

    def _comparison(self, it: Expression) -> str:
        if type(it) is not Compare:
            raise CannotSayError(
                "a condition that compares nothing", "write it as comparisons joined by AND and OR"
            )
        return f"{self.expression(it.left)}{it.operator}{self.expression(it.right)}"

    # --- numbers with units -----------------------------------------------------------------------------

    def quantity(self, it: Quantity, scales: tuple[float, float], at_least: int) -> str:
        """`scales`: SI per written unit of a literal, and of a counted variable (see `values`)."""
        literal, counted = scales
        written = it.written
        if type(written) is Number:
            value = written.value if it.scale == literal else _rounded(written.value * it.scale / literal)
            return decimal(float(value), at_least)
        counts = type(written) is not Variable or written.store in (Store.BYTE, Store.INTEGER, Store.DOUBLE)
        if not math.isclose(it.scale, counted if counts else literal):
            raise CannotSayError("a variable in another unit", "convert it into a variable of its own first")
        return self.value(written)


def _rounded(value: float) -> float:
    """What another unit made of a number, without the noise of the conversion."""
    return float(f"{value:.9g}")


def is_simple(condition: Expression) -> bool:
    """Whether IFTHEN and IF can say it: comparisons of single values, none of them a text."""
    parts = (
        (condition.first, *(part for _, part in condition.rest)) if type(condition) is Logic else (condition,)
    )
    return all(
        type(part) is Compare
        and not any(type(side) in (Binary, Unary, Text) for side in (part.left, part.right))
        for part in parts
    )
