"""Spells values, names, arithmetic and conditions in KRL: the way back of `expressions` and `values`."""

from __future__ import annotations

import math
from decimal import Decimal
from functools import lru_cache
from typing import Final

from olp import called
from olp.expression import (
    Binary,
    CallValue,
    Compare,
    Expression,
    FrameRef,
    Function,
    Item,
    Logic,
    Member,
    Named,
    Number,
    PositionLiteral,
    Quantity,
    RecordLiteral,
    Signal,
    State,
    SystemValue,
    Text,
    Unary,
    Unknown,
)
from olp.units import deg, mm
from olp.vendors._decimals import all_trimmed, trimmed
from olp.vendors.krl import values
from olp.vendors.krl.expressions import BUSES, FUNCTIONS, SYSTEM_VALUES
from olp.vendors.krl.scope import AXES, COMPONENTS, Scope

_SIGNALS: Final = {bus: word for word, bus in BUSES.items()}
_FUNCTIONS: Final = {name: word for word, name in FUNCTIONS.items()}
_SYSTEM: Final = {name: word for word, name in SYSTEM_VALUES.items()}
_MEMBERS: Final = {name: word for word, name in COMPONENTS.items()}
_POSE: Final = tuple(zip(("X", "Y", "Z", "A", "B", "C"), (0, 1, 2, 5, 4, 3), strict=True))
_AXES: Final = ("A1", "A2", "A3", "A4", "A5", "A6")
_BINARY: Final = {"+": ("+", 10), "-": ("-", 10), "*": ("*", 11), "/": ("/", 11), "div": ("/", 11)}
_BITS: Final = {"and": ("B_AND", 7), "xor": ("B_EXOR", 6), "or": ("B_OR", 5)}
_CONDITIONS: Final = (Logic, Compare, State)
_UNARY, _PRODUCT, _ATOM = 12, 13, 14
_DIGITS = 12
_DECIMALS = 9
_NINE_DECIMALS = 1000.0  # up to here nine decimals are not more than twelve digits
_PARTS_OF_POSE = 6


class CannotSayError(Exception):
    """KRL has no words for it. `help`: what could be done."""

    def __init__(self, message: str, help: str = "") -> None:
        super().__init__(message)
        self.help = help


@lru_cache(maxsize=50_000)
def decimal(value: float) -> str:
    """`value` with twelve digits, without an exponent and never "-0"."""
    if not math.isfinite(value):
        raise CannotSayError(f"{value} is no number that a program can hold")
    text = f"{value:.{_DIGITS}g}"
    if "e" in text:
        text = format(Decimal(text), "f")
    return "0" if text in ("-0", "") else text


def number(literal: Number) -> str:
    """A literal: 12 stays whole, 12.0 keeps its point."""
    value = literal.value
    if isinstance(value, float):
        text = repr(value)
        text = text if "e" not in text and "n" not in text else decimal(value)
        return text if "." in text else f"{text}.0"
    return str(value)


@lru_cache(maxsize=10_000)
def _in_units(value: float, has: float, scale: float) -> str:
    return decimal(float(f"{value * has / scale:.10g}"))


def _foreign(value: float) -> str:
    """Without the noise of another language's units: a millionth of a millimetre, a billionth of a degree."""
    text = trimmed(value, _DECIMALS) if abs(value) < _NINE_DECIMALS else None
    return decimal(round(value, _DECIMALS)) if text is None else text.rstrip(".")


def pose_text(it: PositionLiteral, own: bool = True) -> str:
    """`{X 1,Y 2,…}` of a position; components that are not written stay out. `own`: with all digits."""
    found: list[str] = []
    if not own:
        return _foreign_pose(it)
    if it.kind == "pose":
        for word, place in _POSE:
            value = it.values[place]
            if value == value:
                found.append(f"{word} {decimal(value / values.POSE_SCALES[place])}")
        found += _status(it)
    else:
        for word, value in zip(_AXES, it.values, strict=False):
            if value == value:
                found.append(f"{word} {decimal(value / deg)}")
    found += [f"E{n} {decimal(value)}" for n, value in enumerate(it.external, 1) if value == value]
    if not found:
        raise CannotSayError("a position without a number")
    return f"{{{','.join(found)}}}"


def _foreign_pose(it: PositionLiteral) -> str:
    return _plain_pose(it) or _any_foreign(it)


def _plain_pose(it: PositionLiteral) -> str:
    """A pose with all six numbers and no further axes, as nearly all are; empty for others."""
    if it.kind != "pose" or it.external or len(it.values) != _PARTS_OF_POSE:
        return ""
    x, y, z, rx, ry, rz = it.values
    written = (x / mm, y / mm, z / mm, rz / deg, ry / deg, rx / deg)
    if not (min(written) > -_NINE_DECIMALS and max(written) < _NINE_DECIMALS):
        return ""
    texts = all_trimmed(written, _DECIMALS)
    if texts is None:
        return ""
    given = _pattern(it.native, it.configuration, it.sectors)
    return given % tuple([one.rstrip(".") for one in texts])


@lru_cache(maxsize=1000)
def _pattern(
    native: tuple[tuple[str, str], ...], flags: tuple[int, ...], sectors: tuple[tuple[int, float, float], ...]
) -> str:
    status = _status(PositionLiteral("pose", (), (), flags, native, sectors))
    texts = [*(f"{word} %s" for word, _ in _POSE), *(one.replace("%", "%%") for one in status)]
    return f"{{{','.join(texts)}}}"


def _any_foreign(it: PositionLiteral) -> str:
    if it.kind == "pose":
        pairs = [(word, it.values[place] / values.POSE_SCALES[place]) for word, place in _POSE]
    else:
        pairs = [(word, value / deg) for word, value in zip(_AXES, it.values, strict=False)]
    pairs += [(f"E{n}", value) for n, value in enumerate(it.external, 1)]
    found = [f"{word} {_foreign(value)}" for word, value in pairs if value == value]
    if not found:
        raise CannotSayError("a position without a number")
    place = 6 if it.kind == "pose" and len(found) >= 6 else len(found)
    return f"{{{','.join([*found[:place], *_status(it), *found[place:]])}}}"


def _status(it: PositionLiteral) -> list[str]:
    native = dict(it.native)
    if "S" in native or "T" in native:
        return [f"{word} {native[word]}" for word in ("S", "T") if word in native]
    if len(it.configuration) < 3:
        return []
    turn = values.turn(it.sectors)
    return [f"S {values.status(it.configuration)}", *([] if turn is None else [f"T {turn}"])]


class Words:
    """How one file spells. `own`: the program is KRL's own; `strings`: names whose values are texts elsewhere."""

    def __init__(self, scope: Scope, own: bool, strings: frozenset[str] = frozenset()) -> None:
        self.scope = scope
        self.own = own
        self.strings = strings

    # --- names ------------------------------------------------------------------------------------------

    def name(self, it: Expression) -> str:
        """What can stand left of an equals sign."""
        if isinstance(it, Named):
            return f"{it.name}[]" if it.name in self.strings else it.name
        if isinstance(it, Item):
            return self._item(it)
        if isinstance(it, Member):
            return self._member(it)
        if isinstance(it, SystemValue):
            return self.system(it)
        if isinstance(it, Signal):
            return self.signal(it)
        raise CannotSayError("an assignment to this", "assign to a variable")

    def _item(self, it: Item) -> str:
        base = self.scope.type_of(it.base)
        if base in AXES and len(it.indices) == 1 and type(it.indices[0]) is Number:
            place = int(it.indices[0].value)
            if not self._is_array(it.base):
                return f"{self.name(it.base)}.A{place}" if place <= len(_AXES) else self._external(it, place)
        if (
            isinstance(it.base, SystemValue)
            and it.base.name == "current-joints"
            and type(it.indices[0]) is Number
        ):
            return f"$AXIS_ACT.A{it.indices[0].value}"
        if isinstance(it.base, Named) and not self.own and it.base.name in self.strings:
            raise CannotSayError("an array of texts")
        indices = ",".join("" if type(one) is Unknown else self.expression(one) for one in it.indices)
        base_text = it.base.name if isinstance(it.base, Named) else self.name(it.base)
        return f"{base_text}[{indices}]"

    def _external(self, it: Item, place: int) -> str:
        return f"{self.name(it.base)}.E{place - len(_AXES)}"

    def _is_array(self, it: Expression) -> bool:
        return isinstance(it, Named) and it.name.upper() in self.scope.arrays

    def _member(self, it: Member) -> str:
        if self.scope.type_of(it.base) in self.scope.structures and it.name in _MEMBERS:
            return f"{self.name(it.base)}.{it.name}"
        return f"{self.name(it.base)}.{_MEMBERS.get(it.name, it.name)}"

    def signal(self, it: Signal) -> str:
        if isinstance(it.index, Text):
            return it.index.value
        if it.bus not in _SIGNALS:
            raise CannotSayError(*called.signal(it))
        return f"{_SIGNALS[it.bus]}[{self.expression(it.index)}]"

    def system(self, it: SystemValue) -> str:
        if it.name == "timer":
            return f"$TIMER[{it.index}]"
        if it.name == "timed-out":
            return "TIMED_OUT"
        if it.name not in _SYSTEM:
            raise CannotSayError(called.value(it.name))
        return _SYSTEM[it.name]

    # --- values -----------------------------------------------------------------------------------------

    def expression(self, it: Expression, strength: int = 0) -> str:
        """In parentheses where it binds less than `strength`."""
        kind = type(it)
        if kind is Number:
            text = number(it)  # type: ignore[arg-type]
            return f"({text})" if text[0] == "-" and strength > _UNARY else text
        if isinstance(it, (Named, Item, Member, SystemValue, Signal)):
            return self.name(it)
        if isinstance(it, PositionLiteral):
            return self.position(it)
        if isinstance(it, Text):
            return self._text(it)
        if isinstance(it, State):
            return "TRUE" if it.on else "FALSE"
        if isinstance(it, (Binary, Unary, Compare, Logic)):
            text, own = self._operation(it)
            return f"({text})" if own < strength else text
        return self._other(it, strength)

    def _other(self, it: Expression, strength: int) -> str:
        if isinstance(it, Function):
            return self._function(it, strength)
        if isinstance(it, CallValue):
            return f"{it.routine}({self.arguments(it.arguments)})"
        if isinstance(it, RecordLiteral):
            return self.record(it)
        if isinstance(it, FrameRef):
            return self.frame(it)
        if isinstance(it, Unknown) and (self.own or not it.text):
            return it.text
        raise CannotSayError("a value of a kind that KRL does not have")

    def arguments(self, given: tuple[Expression, ...]) -> str:
        return ",".join(self.expression(one) for one in given)

    def position(self, it: PositionLiteral) -> str:
        if it.native and dict(it.native).get("name") and not any(it.values):
            return "$NULLFRAME"
        return pose_text(it, self.own)

    def _text(self, it: Text) -> str:
        if it.value[:1] == "#" and it.value[1:].isidentifier():
            return it.value
        if '"' in it.value or not it.value.isprintable():
            raise CannotSayError('a text that holds " or a control character')
        return f'"{it.value}"'

    def record(self, it: RecordLiteral) -> str:
        if not self.own and any(not name for name, _ in it.members):
            raise CannotSayError("an array as a whole in this place")
        types = self.scope.structures.get(it.type.upper(), {})
        parts = []
        for name, value in it.members:
            word = name if name.upper().partition("[")[0] in types else _MEMBERS.get(name, name)
            parts.append(f"{word} {self.expression(value)}")
        return f"{{{','.join(parts)}}}"

    def frame(self, it: FrameRef) -> str:
        """A tool or frame by its number."""
        if it.number is None:
            if it.kind == "robot":
                return "$ROBROOT"
            if it.kind == "base":
                return "$NULLFRAME"
            raise CannotSayError(called.SYSTEMS.get(it.kind, it.kind))
        if type(it.number) is Number and it.number.value == 0:
            return "$NULLFRAME"
        if it.kind not in ("tool", "user"):
            raise CannotSayError(called.SYSTEMS.get(it.kind, it.kind))
        return f"{'TOOL_DATA' if it.kind == 'tool' else 'BASE_DATA'}[{self.expression(it.number)}]"

    # --- operations -------------------------------------------------------------------------------------

    def _operation(self, it: Binary | Unary | Compare | Logic) -> tuple[str, int]:
        """The text and how strongly it binds."""
        if isinstance(it, Unary):
            word = "-" if it.operator == "-" else "NOT "
            return f"{word}{self.expression(it.operand, _UNARY if word == '-' else _PRODUCT)}", _UNARY
        if isinstance(it, Compare):
            operator = "==" if it.operator == "=" else it.operator
            return f"{self.expression(it.left, 8)}{operator}{self.expression(it.right, 8)}", 1
        if isinstance(it, Logic):
            return self._logic(it)
        return self._binary(it)

    def _logic(self, it: Logic) -> tuple[str, int]:
        """From left to right; where AND follows OR, what stands before goes into parentheses."""
        strengths = {"and": 4, "or": 2}
        text, bound = "", 0
        for place, (operator, operand) in enumerate(it.rest):
            own = strengths[operator]
            left = self.expression(it.first, own) if place == 0 else (f"({text})" if bound < own else text)
            text, bound = f"{left} {operator.upper()} {self.expression(operand, own + 1)}", own
        return text, bound

    def _binary(self, it: Binary) -> tuple[str, int]:
        left, right = it.left, it.right
        if it.operator in _BINARY:
            word, own = _BINARY[it.operator]
            if word == "/":
                return self._quotient(it, own)
            return f"{self.expression(left, own)}{word}{self.expression(right, own + 1)}", own
        if it.operator in _BITS:
            word, own = _BITS[it.operator]
            if it.operator == "xor" and self._is_condition(left) and self._is_condition(right):
                return f"{self.expression(left, 4)} EXOR {self.expression(right, 4)}", 3
            return f"{self.expression(left, own)} {word} {self.expression(right, own + 1)}", own
        if it.operator == "mod" and self._is_integer(left) and self._is_integer(right):
            a, b = self.expression(left, 11), self.expression(right, 12)
            return f"{a}-{a}/{b}*{b}", 10
        raise CannotSayError(called.operation(it.operator), "KRL has + - * / and B_AND, B_OR, B_EXOR")

    def _quotient(self, it: Binary, own: int) -> tuple[str, int]:
        """A quotient of two INT is cut: that is `div`; of others it is not."""
        whole = self._is_integer(it.left) and self._is_integer(it.right)
        right = self.expression(it.right, own + 1)
        if whole == (it.operator == "div") or (it.operator == "/" and not whole):
            return f"{self.expression(it.left, own)}/{right}", own
        if it.operator == "div":
            raise CannotSayError("a whole quotient of numbers that are not INT")
        if type(it.left) is Number:
            return f"{number(Number(float(it.left.value)))}/{right}", own
        return f"1.0*{self.expression(it.left, own + 1)}/{right}", own

    def _is_integer(self, it: Expression) -> bool:
        if isinstance(it, Binary):
            return it.operator != "/" and self._is_integer(it.left) and self._is_integer(it.right)
        if isinstance(it, Unary):
            return self._is_integer(it.operand)
        return self.scope.type_of(it) == "INT"

    def _is_condition(self, it: Expression) -> bool:
        if isinstance(it, Unary):
            return it.operator == "not"
        digital = isinstance(it, Signal) and it.bus in ("in", "out", "flag", "cyclic-flag", "timer-flag")
        return digital or type(it) in _CONDITIONS or self.scope.type_of(it) == "BOOL"

    # --- functions --------------------------------------------------------------------------------------

    def _function(self, it: Function, strength: int) -> str:
        name, arguments = it.name, it.arguments
        if name == "pose-product" and len(arguments) == 2:
            text = f"{self.expression(arguments[0], _PRODUCT)}:{self.expression(arguments[1], _ATOM)}"
            return f"({text})" if strength > _PRODUCT else text
        if name == "joined-text" and len(arguments) == 1 and isinstance(arguments[0], Text):
            return f'"{arguments[0].value}"'
        if name == "bit-not":
            return f"B_NOT {self.expression(arguments[0], _PRODUCT)}"
        if name == "pose-angles" and len(arguments) == _PARTS_OF_POSE:
            return self._aggregate([(word, arguments[place]) for word, place in _POSE])
        if name == "joints":
            return self._aggregate(list(zip(_AXES, arguments, strict=False)))
        if name in _FUNCTIONS:
            return f"{_FUNCTIONS[name]}({self.arguments(arguments)})"
        raise CannotSayError(called.function(name))

    def _aggregate(self, parts: list[tuple[str, Expression]]) -> str:
        """Numbers only, but in KRL's own programs; `write_poses` puts computed ones into a variable first."""
        given = [(word, one) for word, one in parts if not (type(one) is Number and one.value != one.value)]
        if not self.own and not all(type(one) is Number for _, one in given):
            raise CannotSayError("a computed position in this place", "compute it into a variable first")
        return f"{{{','.join(f'{word} {self.expression(one)}' for word, one in given)}}}"

    # --- numbers with units -----------------------------------------------------------------------------

    def quantity(self, it: Quantity, scale: float) -> str:
        """`scale`: SI per written unit."""
        written = it.written
        if math.isclose(it.scale, scale, rel_tol=1e-12):
            return self.expression(written)
        if type(written) is Number:
            return _in_units(written.value, it.scale, scale)
        return f"{self.expression(written, 11)}*{decimal(float(f'{it.scale / scale:.12g}'))}"
