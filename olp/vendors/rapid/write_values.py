"""Spells expressions in RAPID: the way back of `expressions`. What needs a variable of its own gets one."""

from __future__ import annotations

from collections.abc import Mapping
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
from olp.vendors.rapid.names import Names, signal_like
from olp.vendors.rapid.predefined import PREDEFINED_NAMES
from olp.vendors.rapid.texts import quoted
from olp.vendors.rapid.write_functions import FUNCTIONS, NO_AXES, NO_CONFIGURATION, common_base, robjoint_text
from olp.vendors.rapid.write_positions import CannotSayError, literal, number

PREFIXES: Final = {
    "in": "di", "out": "do", "in-group": "gi", "out-group": "go", "analog-in": "ai", "analog-out": "ao",
    "in-half-group": "giHalf", "out-half-group": "goHalf", "system-in": "diSystem", "system-out": "doSystem",
    "direct-in": "diDirect", "register": "goRegister", "robot-in": "diRobot", "robot-out": "doRobot",
    "tool-in": "diTool", "tool-out": "doTool", "configurable-in": "diConf", "configurable-out": "doConf",
    "flag": "doFlag", "cyclic-flag": "doCyclic", "timer-flag": "doTimer",
}  # fmt: skip
TIMED_OUT: Final = "olp_timed_out"
_READERS: Final = {
    "in": "DInput", "out": "DOutput", "in-group": "GInput", "out-group": "GOutput", "analog-in": "AInput",
    "analog-out": "AOutput",
}  # fmt: skip
_FRAMES: Final = {"tooldata": "tframe", "wobjdata": "uframe"}
_ANALOG: Final = ("gi", "go", "ai", "ao")
_STRENGTH: Final = {"xor": 1, "+": 5, "-": 5, "*": 6, "/": 6, "div": 6, "mod": 6, "and": 3, "or": 1}
_ATOM, _UNARY, _COMPARED, _CONJUNCTION, _INVERTED = 8, 7, 4, 3, 2
_WORDS: Final = {
    "abs": "Abs", "sqrt": "Sqrt", "sin": "Sin", "cos": "Cos", "tan": "Tan", "asin": "ASin", "acos": "ACos",
    "atan": "ATan", "atan2": "ATan2", "exp": "Exp", "power": "Pow", "trunc": "Trunc", "max": "Max", "min": "Min",
    "length-of-text": "StrLen", "part-of-text": "StrPart",
}  # fmt: skip
_POSES: Final = ("pose-product", "pose-inverse")
_ANGLES: Final = ("rx", "ry", "rz")
_BEFORE: Final = {
    "x": "trans",
    "y": "trans",
    "z": "trans",
    "q1": "rot",
    "q2": "rot",
    "q3": "rot",
    "q4": "rot",
}


class Words:
    """How one program spells. `types`: RAPID's type of every name, lower case; `clocks`: their names in order.

    `names`: the program's structures. `own`: it was read from RAPID. `before`: instructions that have to stand
    before the one that is spelled.
    """

    def __init__(self, types: Mapping[str, str], clocks: tuple[str, ...], own: bool, names: Names) -> None:
        self.types = types
        self.clocks = clocks
        self.own = own
        self.before: list[str] = []
        self.temporary: dict[str, str] = {}  # name -> type
        self.timed_out = False
        self.names = names

    # --- names ------------------------------------------------------------------------------------------------

    def type_of(self, it: Expression) -> str:
        """RAPID's type of a value, "" where it is not known."""
        match it:
            case Named(name):
                return self.types.get(name.lower()) or self.temporary.get(name, "")
            case Item(base, _):
                return self.type_of(base)
            case Member(base, name):
                members = self.names.members(self.type_of(base)) or ()
                return next((self.names.resolved(of) for member, of in members if member == name), "num")
            case PositionLiteral(kind, _):
                return "jointtarget" if kind == "joint" else "robtarget"
            case Function(name, _) if name in _POSES:
                return "pose"
            case Function("joints" | "inverse", _) | SystemValue("current-joints"):
                return "jointtarget"
            case Function(name, _) if name.startswith(("pose-off", "pose-rel", "forward")):
                return "robtarget"
            case SystemValue("current-pose"):
                return "robtarget"
        return ""

    def signal(self, it: Signal) -> str:
        if isinstance(it.index, Text):
            return it.index.value
        prefix = PREFIXES.get(it.bus)
        if prefix is None:
            raise CannotSayError(*called.signal(it))
        if isinstance(it.index, Number):
            return f"{prefix}{int(it.index.value)}"
        named = it.index.base if isinstance(it.index, Item) else it.index
        is_signal = isinstance(named, Named) and self.types.get(named.name.lower(), "").startswith("signal")
        if self.own or is_signal:
            return self.value(it.index)
        raise CannotSayError("a signal with a computed number", "signals have names in RAPID")

    def _read(self, it: Signal) -> str:
        """A signal's value: by its name where that looks like a signal's, otherwise through a function."""
        name = self.signal(it)
        declared = self.types.get(name.lower(), "").startswith("signal")
        word = _READERS.get(it.bus)
        if declared or word is None or signal_like(name) == it.bus:
            return name
        return f"{word}({name})"

    def is_digital(self, it: Signal) -> bool:
        return not PREFIXES.get(it.bus, "di").startswith(_ANALOG)

    def temporary_name(self, kind: str) -> str:
        """A variable that the program does not have."""
        count = 1
        while f"olp_{kind}{count}" in self.temporary or f"olp_{kind}{count}" in self.types:
            count += 1
        name = f"olp_{kind}{count}"
        self.temporary[name] = kind
        return name

    def stored(self, it: Expression, kind: str) -> Named:
        """The value in a variable, which an instruction before this one sets."""
        if isinstance(it, Named) and self.type_of(it) in (kind, ""):
            return it
        text = self.value(it, kind)
        name = self.temporary_name(kind)
        self.before.append(f"{name}:={text};")
        return Named(name)

    # --- values -----------------------------------------------------------------------------------------------

    def value(self, it: Expression, kind: str = "", strength: int = 0) -> str:
        """An expression; `kind`: the type that is expected; in parentheses where it binds less than `strength`."""
        text, own = self._spelled(it, kind)
        return f"({text})" if own < strength else text

    def _spelled(self, it: Expression, kind: str) -> tuple[str, int]:
        match it:
            case Number(value):
                return number(value), _ATOM if value >= 0 else _UNARY
            case Named(name):
                return name, _ATOM
            case Text(text):
                return quoted(text), _ATOM
            case State(on):
                return ("TRUE" if on else "FALSE"), _ATOM
            case Unknown(text):
                return text, _ATOM
            case Signal():
                return self._read(it), _ATOM
            case Binary() | Logic() | Compare() | Unary():
                return self._operation(it)
            case Item(base, indices):
                return self._item(base, indices), _ATOM
            case Member(base, name):
                return self._member(base, name), _ATOM
            case PositionLiteral():
                return literal(it, kind or self._literal_kind(it), self.own), _ATOM
            case RecordLiteral(of, members):
                return self._record(of, members, kind), _ATOM
            case SystemValue(name, index):
                return self._system(name, index), _ATOM
            case FrameRef():
                return self._frame(it), _ATOM
            case CallValue(routine, arguments):
                return f"{routine}({self.arguments(arguments)})", _ATOM
            case Function(name, arguments):
                return self._function(name, arguments, kind)
        raise CannotSayError("a value that RAPID has no words for")

    def _literal_kind(self, it: PositionLiteral) -> str:
        return "jointtarget" if it.kind == "joint" else "robtarget"

    def _operation(self, it: Binary | Logic | Compare | Unary) -> tuple[str, int]:
        match it:
            case Binary(operator, left, right):
                own = _STRENGTH.get(operator)
                if own is None:
                    raise CannotSayError(called.operation(operator))
                if operator == "/":  # always of real numbers
                    left, right = _whole(left), _whole(right)
                word = operator.upper() if operator.isalpha() else operator
                return f"{self.value(left, '', own)} {word} {self.value(right, '', own + 1)}", own
            case Compare(operator, left, right):
                first, second = self._compared(left, right), self._compared(right, left)
                return f"{first}{operator}{second}", _COMPARED
            case Unary("-", operand):
                return f"-{self.value(operand, '', _UNARY)}", _UNARY
            case Unary("not", operand):
                return f"NOT {self.condition(operand, _INVERTED)}", _INVERTED
            case Logic(first_one, rest):
                return self._logic(first_one, rest)
        raise CannotSayError("an operation that RAPID does not have")

    def _compared(self, it: Expression, other: Expression) -> str:
        if isinstance(it, State) and isinstance(other, Signal) and self.is_digital(other):
            return "1" if it.on else "0"
        return self.value(it, "", _COMPARED + 1)

    def _logic(self, first: Expression, rest: tuple[tuple[str, Expression], ...]) -> tuple[str, int]:
        """From left to right; RAPID's AND binds stronger than OR, so a mixture gets parentheses."""
        own = _STRENGTH[rest[0][0]] if rest else _ATOM
        text = self.condition(first, own)
        for place, (word, operand) in enumerate(rest):
            strength = _STRENGTH[word]
            if place and strength > own:
                text = f"({text})"
            own = strength
            inverted = word == "and" and isinstance(operand, Unary) and operand.operator == "not"
            inner = (
                f"NOT {self.condition(operand.operand, _COMPARED)}"
                if inverted and isinstance(operand, Unary)
                else None
            )
            text += f" {word.upper()} {inner or self.condition(operand, strength + 1)}"
        return text, own

    def condition(self, it: Expression, strength: int = 0) -> str:
        """A truth value: a signal alone is compared with 1."""
        if isinstance(it, Signal) and self.is_digital(it):
            text = f"{self._read(it)}=1"
            return f"({text})" if strength > _COMPARED else text
        return self.value(it, "", strength)

    def _item(self, base: Expression, indices: tuple[Expression, ...]) -> str:
        if self.type_of(base) == "jointtarget" and len(indices) == 1 and isinstance(indices[0], Number):
            if isinstance(base, (SystemValue, Function)):
                base = self.stored(base, "jointtarget")
            return f"{self.value(base)}.robax.rax_{indices[0].value}"
        return f"{self.value(base)}{{{','.join(self.value(index) for index in indices)}}}"

    def _member(self, base: Expression, name: str) -> str:
        if name in _ANGLES:
            return f"EulerZYX(\\{name[1].upper()},{self.turn(base)})"
        if isinstance(base, (SystemValue, Function, CallValue)):
            base = self.stored(base, self.type_of(base) or "robtarget")
        text, kind = self.value(base), self.type_of(base)
        if kind in _FRAMES and name in _BEFORE:
            return f"{text}.{_FRAMES[kind]}.{_BEFORE[name]}.{name}"
        if name in _BEFORE and kind not in ("pos", "orient") and not self._is_record(kind):
            return f"{text}.{_BEFORE[name]}.{name}"
        if len(name) == 2 and name[0] == "e" and name[1] in "123456":
            return f"{text}.extax.eax_{'abcdef'[int(name[1]) - 1]}"
        return f"{text}.{name}"

    def _is_record(self, kind: str) -> bool:
        return bool(kind) and kind not in ("robtarget", "pose", "jointtarget", "num")

    def turn(self, base: Expression) -> str:
        """An orient: `base.rot`, or the orient itself."""
        if isinstance(base, (SystemValue, Function, CallValue)):
            base = self.stored(base, self.type_of(base) or "robtarget")
        text, kind = self.value(base), self.type_of(base)
        if kind in _FRAMES:
            return f"{text}.{_FRAMES[kind]}.rot"
        return text if kind == "orient" else f"{text}.rot"

    def place(self, base: Expression) -> str:
        """A pos: `base.trans`, or the pos itself."""
        if base == SystemValue("current-pose"):
            return "CPos()"
        if isinstance(base, (SystemValue, Function, CallValue)):
            base = self.stored(base, self.type_of(base) or "robtarget")
        text = self.value(base)
        return text if self.type_of(base) == "pos" else f"{text}.trans"

    def _record(self, of: str, members: tuple[tuple[str, Expression], ...], kind: str) -> str:
        predefined = PREDEFINED_NAMES.get((of, members)) if of else None
        if predefined is not None and predefined not in self.types:
            return predefined
        if of == "jointtarget":
            joints = dict(members)["joints"]
            values = joints.arguments if isinstance(joints, Function) else ()
            return f"[{robjoint_text(self, values)},{self._extra(members[1][1])}]"
        if of == "robjoint" and all(isinstance(value, Item) for _, value in members):
            return robjoint_text(self, tuple(value for _, value in members))
        if of == "extjoint":
            base = common_base(tuple(value for _, value in members), tuple(f"e{n}" for n in range(1, 7)))
            if base is not None:
                return f"{self.value(base)}.extax"
        known = dict(self.names.members(of) or ())
        texts = [self.value(value, known.get(name, kind if not name else "")) for name, value in members]
        return f"[{','.join(texts)}]"

    def joints(self, it: Expression) -> str:
        arguments = it.arguments if isinstance(it, Function) else ()
        if len(arguments) > 6:
            raise CannotSayError("a position of more than six axes")
        return ",".join([*(self.value(one) for one in arguments), *["0"] * (6 - len(arguments))])

    def _extra(self, it: Expression) -> str:
        return self.value(it.value) if isinstance(it, NamedArgument) and it.value is not None else NO_AXES

    def _system(self, name: str, index: int) -> str:
        if name == "current-pose":
            return "CRobT()"
        if name == "current-joints":
            return "CJointT()"
        if name == "timed-out":
            self.timed_out = True
            return TIMED_OUT
        if name == "timer":
            if 0 < index <= len(self.clocks):
                return f"ClkRead({self.clocks[index - 1]})"
            raise CannotSayError(f"timer {index}", "declare a clock")
        raise CannotSayError(called.value(name))

    def _frame(self, it: FrameRef) -> str:
        if it.kind in ("base", "robot"):
            return "wobj0"
        if it.kind == "tool" and it.number in (None, Number(0)):
            return "tool0"
        raise CannotSayError(
            called.SYSTEMS.get(it.kind, it.kind), "tools and work objects have names in RAPID"
        )

    # --- functions and calls --------------------------------------------------------------------------------

    def arguments(self, found: tuple[Expression, ...]) -> str:
        """`a,b\\Option:=c`: options stand behind an argument without a comma."""
        text = ""
        for place, one in enumerate(found):
            if isinstance(one, NamedArgument):
                text += self.option(one)
            else:
                text += f"{',' if place else ''}{self.value(one)}"
        return text

    def option(self, it: NamedArgument) -> str:
        if it.name.endswith("?") and it.value is not None:
            return f"\\{it.name}{self.value(it.value)}"
        return f"\\{it.name}" if it.value is None else f"\\{it.name}:={self.value(it.value)}"

    def _function(self, name: str, arguments: tuple[Expression, ...], kind: str) -> tuple[str, int]:
        if name == "joined-text":
            first, second = arguments
            return f"{self.value(first, '', 5)} + {self.value(second, '', 6)}", 5
        if name in _WORDS:
            return f"{_WORDS[name]}({','.join(map(self.value, arguments))})", _ATOM
        special = FUNCTIONS.get(name)
        if special is None:
            raise CannotSayError(called.function(name))
        return special(self, arguments, kind), _ATOM

    def as_pose(self, it: Expression) -> str:
        """A value of type pose."""
        kind = self.type_of(it)
        if kind in _FRAMES:
            return f"{self.value(it)}.{_FRAMES[kind]}"
        if isinstance(it, (PositionLiteral, Function)) and not (
            isinstance(it, Function) and it.name not in FUNCTIONS
        ):
            if self.type_of(it) == "robtarget" and isinstance(it, Function):
                it = self.stored(it, "robtarget")
                return f"[{it.name}.trans,{it.name}.rot]"
            return self.value(it, "pose")
        if self.type_of(it) in ("robtarget", "") and not self.own:
            text = (
                self.value(it) if isinstance(it, (Named, Item, Member)) else self.stored(it, "robtarget").name
            )
            return f"[{text}.trans,{text}.rot]"
        return self.value(it, "pose")

    def as_robtarget(self, it: Expression) -> str:
        """A value of type robtarget."""
        kind = self.type_of(it)
        if kind in _FRAMES:
            text = f"{self.value(it)}.{_FRAMES[kind]}"
            return f"[{text}.trans,{text}.rot,{NO_CONFIGURATION},{NO_AXES}]"
        if self.type_of(it) == "pose" and not (self.own and isinstance(it, Named)):
            name = self.stored(it, "pose").name
            return f"[{name}.trans,{name}.rot,{NO_CONFIGURATION},{NO_AXES}]"
        return self.value(it, "robtarget")

    def scaled(self, quantity: Quantity, unit: float) -> str:
        """A quantity in `unit` (SI per written unit)."""
        ratio = quantity.scale / unit
        if abs(ratio - 1.0) < 1e-12:
            return self.value(quantity.written)
        if isinstance(quantity.written, Number):
            value = round(quantity.written.value * ratio, 9)
            return number(int(value) if value == int(value) else value)
        return f"{self.value(quantity.written, '', 6)} * {number(round(ratio, 12))}"


def _whole(it: Expression) -> Expression:
    """2.0 as 2."""
    whole = isinstance(it, Number) and isinstance(it.value, float) and it.value.is_integer()
    return Number(int(it.value)) if whole and isinstance(it, Number) else it
