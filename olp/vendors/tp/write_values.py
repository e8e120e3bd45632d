"""Spells values, registers, arithmetic and conditions in TP: the way back of `expressions`."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import lru_cache
from typing import Final

from olp import called
from olp.expression import (
    Argument,
    Binary,
    Compare,
    Expression,
    FrameRef,
    Function,
    Item,
    Logic,
    Member,
    Named,
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
from olp.points import PointKind, PointTable
from olp.units import deg, mm
from olp.vendors.tp import values

_NO_TEXT: Final = frozenset("'\r\n")  # what no text holds
SIGNALS: Final = {bus: word for word, bus in values.BUSES.items()}
FUNCTIONS: Final = {name: word for word, name in values.FUNCTIONS.items()}
STRING_FUNCTIONS: Final = {name: word for word, name in values.STRING_FUNCTIONS.items()}
_GROUPS: Final = {store: group for group, store in values.GROUP_STORES.items()}
_OPERATORS: Final = {"+": "+", "-": "-", "*": "*", "/": "/", "div": " DIV ", "mod": " MOD "}
_STRENGTH: Final = {"+": 4, "-": 4, "*": 5, "/": 5, "div": 5, "mod": 5}
_LOGIC_STRENGTH: Final = {"or": 1, "and": 2}
_COMPARE_STRENGTH, _UNARY_STRENGTH = 3, 6
_MOST_DECIMALS = 9
_SINGLE = (
    Number,
    Variable,
    Argument,
    Signal,
    State,
    Member,
    Item,
    SystemValue,
    Taught,
    FrameRef,
    Text,
    Named,
    Unknown,
)


class CannotSayError(Exception):
    """TP has no words for it. `help`: what could be done."""

    def __init__(self, message: str, help: str = "") -> None:
        super().__init__(message)
        self.help = help


@lru_cache(maxsize=20_000)
def decimal(value: float, at_least: int = 0) -> str:
    """`value` as a decimal fraction with that many decimals, more where it has more; never "-0", never an exponent."""
    if not math.isfinite(value):
        raise CannotSayError(f"{value} is no number that a program can hold")
    text = f"{value:.{at_least}f}"
    if float(text) != value:
        text = f"{value:.{_MOST_DECIMALS}f}".rstrip("0")
        text += "0" * (at_least - len(text.partition(".")[2]))
    return text.lstrip("-") if not text.strip("-0.") else text.rstrip(".")


def number(literal: Number) -> str:
    """A literal: whole numbers stay whole, 12.0 keeps its point."""
    value = literal.value
    return decimal(value, 1) if isinstance(value, float) else str(int(value))


@dataclass(frozen=True, slots=True)
class Words:
    """How one program spells. `names`: comments of signals, DO[3] -> gripper. `points`: what it teaches.

    `own`: the program is TP's own.
    """

    names: Mapping[str, str]
    points: PointTable = field(default_factory=PointTable)
    own: bool = False

    # --- registers --------------------------------------------------------------------------------------

    def variable(self, it: Variable) -> str:
        name = f":{it.name}" if it.name else ""
        if it.store is Store.REAL:
            return f"R[{self.index(it.index)}{name}]"
        if it.store is Store.STRING:
            return f"SR[{self.index(it.index)}{name}]"
        return f"{self._position_register(it)}{name}]"

    def _position_register(self, it: Variable) -> str:
        if it.store not in _GROUPS or it.local:
            raise CannotSayError(f"a {called.STORES[it.store]}", "TP has R, PR and SR registers")
        group = _GROUPS[it.store]
        return f"PR[{'' if group == 1 else f'GP{group}:'}{self.index(it.index)}"

    def element(self, it: Member | Item) -> str:
        base = it.base
        if isinstance(base, Taught) and isinstance(it, Member):
            return self._taught_component(base, it.name)
        if not isinstance(base, Variable) or base.store not in _GROUPS:
            raise CannotSayError(
                "a component of something that is no position register", "copy it into a PR first"
            )
        if isinstance(it, Member):
            if it.name not in values.ELEMENTS:
                raise CannotSayError(
                    f"the component '{it.name}' of a position", "TP has x y z, W P R and E1 to E3"
                )
            place = str(values.ELEMENTS.index(it.name) + 1)
        elif len(it.indices) == 1:
            place = self.index(it.indices[0])
        else:
            raise CannotSayError("an array of several dimensions")
        return f"{self._position_register(base)},{place}{f':{base.name}' if base.name else ''}]"

    def _taught_component(self, base: Taught, name: str) -> str:
        """A component of a taught position, which no program changes: its number."""
        point = self.points.find(base.store, True, base.number)
        place = values.ELEMENTS.index(name) if name in values.ELEMENTS[:6] else -1
        if point is None or point.state.kind is not PointKind.POSE or place < 0:
            raise CannotSayError(f"the component '{name}' of a taught position", "copy it into a PR first")
        value = round(point.values[place] / (mm if place < 3 else deg), 6)
        return self.value(Number(int(value) if value == int(value) else value))

    def index(self, it: Expression) -> str:
        """A number, or one register."""
        if isinstance(it, Number):
            return str(int(it.value))
        if isinstance(it, Argument) or (isinstance(it, Variable) and it.store is Store.REAL):
            return self.value(it)
        raise CannotSayError("a computed index", "compute it into a register first")

    def signal(self, it: Signal) -> str:
        if it.bus not in SIGNALS or it.part:
            raise CannotSayError(*called.signal(it))
        if isinstance(it.index, Text):
            raise CannotSayError(f"the signal '{it.index.value}' by its name", "say which number it has")
        key = f"{SIGNALS[it.bus]}[{self.index(it.index)}]"
        name = self.names.get(key)
        return f"{key[:-1]}:{name}]" if name else key

    def frame(self, it: FrameRef) -> str:
        if it.kind not in ("user", "tool") or it.number is None:
            raise CannotSayError(f"{called.SYSTEMS.get(it.kind, it.kind)} in this place")
        return f"{'UFRAME' if it.kind == 'user' else 'UTOOL'}[{self.index(it.number)}]"

    def system(self, it: SystemValue) -> str:
        if it.name == "timer":
            return self.named("TIMER", Number(it.index))
        if it.name in ("current-pose", "current-joints"):
            return "LPOS" if it.name == "current-pose" else "JPOS"
        raise CannotSayError(called.value(it.name))

    def named(self, word: str, index: Expression) -> str:
        key = f"{word}[{self.index(index)}]"
        name = self.names.get(key)
        return f"{key[:-1]}:{name}]" if name else key

    # --- values -----------------------------------------------------------------------------------------

    def value(self, it: Expression) -> str:
        """A single value, as it stands alone; a negative number is in parentheses."""
        match it:
            case Number():
                text = number(it)
                return f"({text})" if text[0] == "-" else text
            case Variable():
                return self.variable(it)
            case Argument(place):
                return f"AR[{place}]"
            case Signal():
                return self.signal(it)
            case State(on):
                return "ON" if on else "OFF"
            case Member() | Item():
                return self.element(it)
            case SystemValue():
                return self.system(it)
            case Taught(Store.ROBOT, place):
                return f"P[{place}]"
            case FrameRef():
                return self.frame(it)
            case Text(text):
                if not _NO_TEXT.isdisjoint(text):
                    raise CannotSayError("a text that holds ' or a line end")
                return f"'{text}'"
            case Named(name) if name.startswith("$"):
                return name
            case Unknown(text) if self.own:
                return text
            case Unknown(text):
                raise CannotSayError(f"the word {text}")
            case Named(name):
                raise CannotSayError(f"the variable {name} by its name", "give it a register")
            case _:
                raise CannotSayError("a computed value in this place", "compute it into a register first")

    def assigned(self, it: Expression) -> str:
        """The right side of an assignment: one value, one operation, or mixed logic in parentheses."""
        if isinstance(it, Function) and it.name in STRING_FUNCTIONS:
            return f"{STRING_FUNCTIONS[it.name]} {','.join(map(self.value, it.arguments))}"
        if isinstance(it, Function) and it.name == "joined-text" and len(it.arguments) == 2:
            return "+".join(map(self.value, it.arguments))
        if isinstance(it, _SINGLE):
            return self.value(it)
        if isinstance(it, Binary) and isinstance(it.left, _SINGLE) and isinstance(it.right, _SINGLE):
            if it.operator in _OPERATORS:
                return f"{self.value(it.left)}{_OPERATORS[it.operator]}{self.value(it.right)}"
        elif isinstance(it, Function) and it.name in FUNCTIONS:
            return self.expression(it)
        return f"({self.expression(it)})"

    def expression(self, it: Expression, strength: int = 0) -> str:
        """Mixed logic, in parentheses where it binds less than `strength`."""
        match it:
            case Binary(operator, left, right) if operator in _OPERATORS:
                own = _STRENGTH[operator]
                text = f"{self.expression(left, own)}{_OPERATORS[operator]}{self.expression(right, own + 1)}"
            case Unary("-", operand):
                own, text = _UNARY_STRENGTH, f"(-{self.expression(operand, _UNARY_STRENGTH)})"
            case Unary("not", operand):
                own, text = _UNARY_STRENGTH, f"!{self._truth(operand, _UNARY_STRENGTH)}"
            case Compare(operator, left, right):
                own, text = _COMPARE_STRENGTH, self._comparison(operator, left, right)
            case Logic():
                return self._logic(it, strength)
            case Function(name, arguments) if name in FUNCTIONS:
                return f"{FUNCTIONS[name]}[{','.join(map(self.expression, arguments))}]"
            case Function(name, _):
                raise CannotSayError(called.function(name))
            case Binary(operator, _, _):
                raise CannotSayError(called.operation(operator))
            case _:
                return self.value(it)
        return f"({text})" if own < strength else text

    def _logic(self, it: Logic, strength: int) -> str:
        """A chain from left to right; parentheses where AND would bind before OR otherwise."""
        text, before = self._truth(it.first, _LOGIC_STRENGTH[it.rest[0][0]] if it.rest else 0), 9
        for word, operand in it.rest:
            own = _LOGIC_STRENGTH[word]
            if before < own:
                text = f"({text})"
            text += f" {word.upper()} {self._truth(operand, own + 1)}"
            before = own
        return f"({text})" if before < strength else text

    def _truth(self, it: Expression, strength: int) -> str:
        """An operand of AND, OR and !: a register counts as true when it is not zero."""
        if isinstance(it, (Variable, Argument, Number)):
            text = f"{self.value(it)}<>0"
            return f"({text})" if strength > _COMPARE_STRENGTH else text
        return self.expression(it, strength)

    def _comparison(self, operator: str, left: Expression, right: Expression) -> str:
        if isinstance(right, State) and isinstance(left, (Variable, Argument)):
            right = Number(int(right.on))
        return f"{self.expression(left, 4)}{operator}{self.expression(right, 4)}"

    def condition(self, it: Expression, parentheses: bool = False) -> str:
        """A condition: plain where it compares a single value with another, else mixed logic in parentheses."""
        single = isinstance(it, Compare) and isinstance(it.left, _SINGLE) and isinstance(it.right, _SINGLE)
        if isinstance(it, Compare) and single and not isinstance(it.left, (Number, State)):
            text = self._comparison(it.operator, it.left, it.right)
            return f"({text})" if parentheses else text
        return f"({self._truth(it, 0)})"

    # --- numbers with units -----------------------------------------------------------------------------

    def quantity(self, it: Quantity, scale: float) -> str:
        """`scale`: SI per written unit."""
        written = it.written
        if isinstance(written, Number):
            value = written.value if it.scale == scale else _rounded(written.value * it.scale / scale)
            return decimal(float(value))
        if not math.isclose(it.scale, scale):
            raise CannotSayError("a register in another unit", "convert it into a register of its own first")
        return self.index(written)


def _rounded(value: float) -> float:
    """What another unit made of a number, without the noise of the conversion."""
    return float(f"{value:.9g}")
