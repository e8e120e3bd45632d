"""Spells values: the way back of `expressions`, with the same factors taken off."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Any, Final

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
    NamedArgument,
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
from olp.vendors.urscript import builtins, helpers
from olp.vendors.urscript.folding import scaled
from olp.vendors.urscript.rotations import angles_from_vector, vector_from_angles

_SAME = 1e-12
_NO_TEXT: Final = frozenset('"\r\n')  # what no text holds
_LEAST = 1e-3  # smaller numbers than these may be written with an exponent
_DECIMALS = 10  # of metres and radians of other languages' points: a ten-millionth of a millimetre
_STANDARD_SIGNALS = 8
_ZERO = "p[0.0, 0.0, 0.0, 0.0, 0.0, 0.0]"
_PLACES: Final = {"x": 0, "y": 1, "z": 2, "rotation1": 3, "rotation2": 4, "rotation3": 5}
_ANGLES: Final = ("rx", "ry", "rz")
_COMPARE: Final = {"=": "==", "<>": "!=", "<": "<", ">": ">", "<=": "<=", ">=": ">="}
_BINARY: Final = {"+": ("+", 6), "-": ("-", 6), "*": ("*", 7), "/": ("/", 7), "mod": ("%", 7)}
_LOGIC: Final = {"or": 1, "xor": 2, "and": 3}
_NOT, _COMPARISON, _SIGN, _WHOLE = 4, 5, 8, 9


class CannotSayError(Exception):
    """URScript has no word for this. `help`: what to do instead."""

    def __init__(self, what: str, help: str = "") -> None:
        super().__init__(what)
        self.help = help


class Words:
    """Spells the values of one program. `types`: name -> `Declare.type`, "list" for arrays; `used`: helpers needed."""

    def __init__(self, own: bool) -> None:
        self.own = own
        self.types: dict[str, str] = {}
        self.returns: dict[str, str] = {}
        self.used: set[str] = set()

    def value(self, e: Expression) -> str:
        """The expression as text. Raises CannotSayError."""
        return self.rated(e)[0]

    def rated(self, e: Expression) -> tuple[str, int]:
        """The text and how tightly it holds together."""
        spell = _SPELL.get(type(e))
        if spell is None:
            raise CannotSayError("a value of a kind that URScript does not have")
        return spell(self, e)

    def at_least(self, e: Expression, strength: int) -> str:
        text, own = self.rated(e)
        return text if own >= strength else f"({text})"

    def quantity(self, q: Quantity) -> str:
        """The SI value."""
        return self.value(q.written if q.scale == 1.0 else scaled(q.written, q.scale))

    def kind(self, e: Expression) -> str:
        """position, joints, list, another type, or nothing where it is not known."""
        match e:
            case Named(name):
                return self.types.get(name, "")
            case PositionLiteral(kind):
                return "joints" if kind == "joint" else "position"
            case SystemValue(name):
                return {"current-joints": "joints", "current-pose": "position"}.get(name, "")
            case Function(name):
                return "joints" if name in ("inverse", "joints") else "position" if _is_pose(name) else ""
            case CallValue(routine):
                return self.returns.get(routine, "")
            case Item(Named(name), _):
                return self.types.get(f"{name}[]", "")
            case _:
                return ""

    # --- literals ---------------------------------------------------------------------------------------

    def _number(self, e: Number) -> tuple[str, int]:
        value = e.value
        if not math.isfinite(value):
            raise CannotSayError(f"the number {value}")
        text = repr(value)
        return text, _WHOLE if text[0] != "-" else _SIGN

    def _text(self, e: Text) -> tuple[str, int]:
        if not _NO_TEXT.isdisjoint(e.value):
            raise CannotSayError("a text with quotes or a line end in it", "write it without them")
        return f'"{e.value}"', _WHOLE

    def _state(self, e: State) -> tuple[str, int]:
        return str(e.on), _WHOLE

    def _position(self, e: PositionLiteral) -> tuple[str, int]:
        if e.external and any(value == value and value != 0.0 for value in e.external):
            raise CannotSayError("further axes of a position", "UR arms have none")
        total = sum(e.values)
        if total != total and any(value != value for value in e.values):
            raise CannotSayError("a position with components left out", "write all of them")
        if e.kind == "joint":
            return f"[{', '.join(map(self.decimal, e.values))}]", _WHOLE
        turn = e.values[3:6]
        if self.own and e.native:
            written = dict(e.native).get("vector", "")
            if written and angles_from_vector(*map(float, written.split(","))) == turn:
                return f"p[{self._decimals(e.values[:3])}, {written}]", _WHOLE
        return f"p[{self._decimals((*e.values[:3], *vector_from_angles(*turn)))}]", _WHOLE

    def _decimals(self, values: tuple[float, ...]) -> str:
        """`decimal` of each, all at once where they are spelled alike."""
        texts = None if self.own else all_trimmed(values, _DECIMALS)
        if texts is None:
            return ", ".join(map(self.decimal, values))
        if min(map(abs, values)) < _LEAST:
            pairs = zip(values, texts, strict=True)
            texts = [text if abs(value) >= _LEAST else self.decimal(value) for value, text in pairs]
        return ", ".join([f"{one}0" if one[-1] == "." else one for one in texts])

    def decimal(self, value: float) -> str:
        """A length or an angle of a point."""
        if self.own:
            return repr(value)
        text = trimmed(value, _DECIMALS) if abs(value) >= _LEAST else None
        if text is None:
            return repr(round(value, _DECIMALS) + 0.0)
        return f"{text}0" if text[-1] == "." else text

    def _record(self, e: RecordLiteral) -> tuple[str, int]:
        if all(not name for name, _ in e.members):
            return f"[{', '.join(self.value(value) for _, value in e.members)}]", _WHOLE
        return f"struct({', '.join(f'{name}={self.value(value)}' for name, value in e.members)})", _WHOLE

    # --- names ------------------------------------------------------------------------------------------

    def _named(self, e: Named) -> tuple[str, int]:
        return e.name, _WHOLE

    def _unknown(self, e: Unknown) -> tuple[str, int]:
        if not self.own:
            raise CannotSayError(f"the word {e.text}")
        return e.text, _WHOLE

    def _frame(self, e: FrameRef) -> tuple[str, int]:
        if e.kind == "base" or (e.kind == "tool" and e.number == Number(0)):
            return _ZERO, _WHOLE
        raise CannotSayError(called.SYSTEMS.get(e.kind, e.kind), "name a frame with its pose")

    def _item(self, e: Item) -> tuple[str, int]:
        text = self.element(e)
        return (f"r2d({text})", _WHOLE) if self.kind(e.base) == "joints" else (text, _WHOLE)

    def element(self, e: Item) -> str:
        """An element in URScript's own unit."""
        base = self.at_least(e.base, _WHOLE)
        return f"{base}[{', '.join(map(self.index, e.indices))}]"

    def index(self, e: Expression) -> str:
        """An index from 0 of one from 1."""
        if type(e) is Number:
            return str(int(e.value) - 1)
        if type(e) is Binary and e.operator == "+" and e.right == Number(1):
            return self.value(e.left)
        return f"{self.at_least(e, 6)} - 1"

    def _member(self, e: Member) -> tuple[str, int]:
        kind = self.kind(e.base)
        if kind in ("joints", "list"):
            raise CannotSayError(f"the component {e.name} of joint angles or a list")
        record = kind not in ("", "position")
        if e.name in _PLACES and not record:
            text = f"{self.at_least(e.base, _WHOLE)}[{_PLACES[e.name]}]"
            return (text, _WHOLE) if _PLACES[e.name] > 2 else (f"{text} * 1000.0", 7)
        if e.name in _ANGLES and not record:
            return self.helper(f"olp_{e.name}", (e.base,))
        if not record and e.name in ("q1", "q2", "q3", "q4"):
            raise CannotSayError(f"the component {e.name} of a quaternion")
        return f"{self.at_least(e.base, _WHOLE)}.{e.name}", _WHOLE

    def helper(self, name: str, arguments: tuple[Expression, ...]) -> tuple[str, int]:
        """A call of one of olp's own functions, which the script then holds."""
        self.used.add(name)
        return f"{name}({', '.join(map(self.value, arguments))})", _WHOLE

    def _signal(self, e: Signal) -> tuple[str, int]:
        word = builtins.INPUT_WORDS.get(e.bus)
        if word is None or type(e.index) is Text:
            raise CannotSayError(*called.signal(e))
        if e.bus in ("in", "out") and type(e.index) is Number and e.index.value >= _STANDARD_SIGNALS:
            word = word.replace("_standard", "")
        return f"{word}({self.value(e.index)})", _WHOLE

    def _system(self, e: SystemValue) -> tuple[str, int]:
        words = {"current-pose": "get_actual_tcp_pose()", "current-joints": "get_actual_joint_positions()"}
        if e.name == "timed-out":
            return f"{helpers.COUNTER} <= 0", _COMPARISON
        if e.name not in words:
            raise CannotSayError(called.value(e.name))
        return words[e.name], _WHOLE

    # --- arithmetic -------------------------------------------------------------------------------------

    def _unary(self, e: Unary) -> tuple[str, int]:
        if e.operator == "not":
            return f"not ({self.value(e.operand)})", _NOT
        return f"-{self.at_least(e.operand, _SIGN)}", _SIGN

    def _binary(self, e: Binary) -> tuple[str, int]:
        special = self._factor(e)
        if special is not None:
            return special
        if e.operator == "div":
            return self.helper("olp_trunc", (Binary("/", e.left, e.right),))
        found = e.left if type(e.left) is Function and e.left.name == "position-in-text" else None
        if e.operator == "-" and found is not None and e.right == Number(1) and len(found.arguments) == 2:
            return f"str_find({self.arguments(found.arguments)})", _WHOLE
        if e.operator not in _BINARY:
            raise CannotSayError(called.operation(e.operator))
        word, strength = _BINARY[e.operator]
        return f"{self.at_least(e.left, strength)} {word} {self.at_least(e.right, strength + 1)}", strength

    def _factor(self, e: Binary) -> tuple[str, int] | None:
        """Metres and radians out of what olp holds in millimetres and degrees."""
        if e.operator != "*" or type(e.right) is not Number:
            return None
        factor, operand = e.right.value, e.left
        if abs(factor / mm - 1.0) < _SAME:
            if isinstance(operand, Member) and self._is_length(operand):
                return f"{self.at_least(operand.base, _WHOLE)}[{_PLACES[operand.name]}]", _WHOLE
            if type(operand) is Function and operand.name == "pose-distance":
                return f"point_dist({', '.join(map(self.value, operand.arguments))})", _WHOLE
        if abs(factor / deg - 1.0) < _SAME:
            return self.radians(operand), _WHOLE
        if abs(factor * deg - 1.0) < _SAME:
            return f"r2d({self.value(operand)})", _WHOLE
        return None

    def _is_length(self, e: Member) -> bool:
        return _PLACES.get(e.name, 9) < 3 and self.kind(e.base) in ("", "position")

    def radians(self, degrees: Expression) -> str:
        """An angle of olp [deg] in radians."""
        if type(degrees) is Item and self.kind(degrees.base) == "joints":
            return self.element(degrees)
        if type(degrees) is Function and degrees.name in builtins.TO_ANGLE:
            return f"{degrees.name}({', '.join(map(self.value, degrees.arguments))})"
        if type(degrees) is Binary and degrees.operator == "*" and type(degrees.right) is Number:
            undone = abs(degrees.right.value * deg - 1.0) < _SAME
            if undone:
                return self.value(degrees.left)
        return f"d2r({self.value(degrees)})"

    def _compare(self, e: Compare) -> tuple[str, int]:
        left, right = self.at_least(e.left, _COMPARISON + 1), self.at_least(e.right, _COMPARISON + 1)
        return f"{left} {_COMPARE[e.operator]} {right}", _COMPARISON

    def _logic(self, e: Logic) -> tuple[str, int]:
        text, strength = self.rated(e.first)
        for word, operand in e.rest:
            wanted = _LOGIC[word]
            left = text if strength >= wanted else f"({text})"
            text, strength = f"{left} {word} {self.at_least(operand, wanted + 1)}", wanted
        return text, strength

    # --- calls ------------------------------------------------------------------------------------------

    def _call(self, e: CallValue) -> tuple[str, int]:
        return f"{e.routine}({self.arguments(e.arguments)})", _WHOLE

    def arguments(self, arguments: tuple[Expression, ...]) -> str:
        return ", ".join(map(self.value, arguments))

    def _given(self, e: NamedArgument) -> tuple[str, int]:
        if e.value is None:
            raise CannotSayError(f"the switch {e.name}")
        return f"{e.name}={self.value(e.value)}", _WHOLE

    def _function(self, e: Function) -> tuple[str, int]:
        from olp.vendors.urscript.write_functions import function

        return function(self, e)


_SPELL: Final[Mapping[type, Callable[[Words, Any], tuple[str, int]]]] = {
    Number: Words._number,
    Text: Words._text,
    State: Words._state,
    PositionLiteral: Words._position,
    RecordLiteral: Words._record,
    Named: Words._named,
    Unknown: Words._unknown,
    FrameRef: Words._frame,
    Item: Words._item,
    Member: Words._member,
    Signal: Words._signal,
    SystemValue: Words._system,
    Unary: Words._unary,
    Binary: Words._binary,
    Compare: Words._compare,
    Logic: Words._logic,
    CallValue: Words._call,
    NamedArgument: Words._given,
    Function: Words._function,
}


def _is_pose(name: str) -> bool:
    return name == "forward" or (name.startswith("pose-") and name not in ("pose-distance", "pose-element"))
