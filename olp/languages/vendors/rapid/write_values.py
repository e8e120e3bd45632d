"""Spells expressions in RAPID: the way back of `expressions`. What needs a variable of its own gets one."""

from __future__ import annotations

import math
from collections.abc import Container, Mapping, Sequence
from functools import lru_cache
from typing import ClassVar, Final

from olp.core.units import deg, mm
from olp.ir import expressions as ex
from olp.ir import program as st
from olp.ir import terminology
from olp.languages.generator import ATOM, CannotSayError, Generator, Spelled
from olp.languages.literals import all_trimmed
from olp.languages.vendor import TRAP
from olp.languages.vendors.rapid.limits import LONGEST_TEXT
from olp.languages.vendors.rapid.literals import confdata, quoted
from olp.languages.vendors.rapid.names import RapidNames, signal_like
from olp.languages.vendors.rapid.predefined_data import PREDEFINED_NAMES

_BITS: Final = "RAPID computes with the bits of a byte alone: BitAnd, BitOr, BitXOr, BitNeg"
TIMED_OUT: Final = "olp_timed_out"
_NOT_CONNECTED: Final = ex.Number(9e9)
_READERS: Final = {
    "in": "DInput", "out": "DOutput", "in-group": "GInput", "out-group": "GOutput", "analog-in": "AInput",
    "analog-out": "AOutput",
}  # fmt: skip
FRAMES: Final = {"tooldata": "tframe", "wobjdata": "uframe"}
_ANALOG: Final = ("gi", "go", "ai", "ao")
# How strongly operators bind. The kernel manual has a sign and NOT at the head of an expression alone: elsewhere
# they stand in parentheses, and NOT takes in what AND joins.
_INVERTED, _OR, _CONJUNCTION, _COMPARED, _SUM, _PRODUCT, _FACTOR = range(7)
_POSITIONS: Final = ("robtarget", "jointtarget", "pose")
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
_XYZ: Final = ("x", "y", "z")
_AT_ZERO: Final = "[[0,0,0],"
_ZEROS: Final = (ex.Number(0), ex.Number(0), ex.Number(0))

Arguments = tuple[ex.Expression, ...]  # what a function is given
_MODES: Final = {"manual-reduced": "OP_MAN_PROG", "manual-full": "OP_MAN_TEST"}


class RapidValues(Generator):
    """Spells expressions. `types`: RAPID's type of every name, lower case.

    `names`: the program's structures. `before`: instructions that have to stand before the one that is spelled.
    """

    language = "RAPID"
    binary: ClassVar = {
        "+": (" + ", _SUM),
        "-": (" - ", _SUM),
        "*": (" * ", _PRODUCT),
        "/": (" / ", _PRODUCT),
        "div": (" DIV ", _PRODUCT),
        "mod": (" MOD ", _PRODUCT),
        "and": (" AND ", _CONJUNCTION),
        "or": (" OR ", _OR),
        "xor": (" XOR ", _OR),
    }
    unary: ClassVar = {"-": ("-{}", _SUM, _FACTOR), "not": ("NOT {}", _INVERTED, _COMPARED)}
    logic: ClassVar = {"and": (" AND ", _CONJUNCTION), "or": (" OR ", _OR), "xor": (" XOR ", _OR)}
    no_value = "a value that RAPID has no words for"
    signals: ClassVar = {
        "in": "di", "out": "do", "in-group": "gi", "out-group": "go", "analog-in": "ai", "analog-out": "ao",
        "in-half-group": "giHalf", "out-half-group": "goHalf", "system-in": "diSystem", "system-out": "doSystem",
        "direct-in": "diDirect", "register": "goRegister", "robot-in": "diRobot", "robot-out": "doRobot",
        "tool-in": "diTool", "tool-out": "doTool", "configurable-in": "diConf", "configurable-out": "doConf",
        "flag": "doFlag", "cyclic-flag": "doCyclic", "timer-flag": "doTimer",
    }  # fmt: skip
    functions: ClassVar = {
        "abs": "Abs", "sqrt": "Sqrt", "sin": "Sin", "cos": "Cos", "tan": "Tan", "asin": "ASin", "acos": "ACos",
        "atan": "ATan", "atan2": "ATan2", "exp": "Exp", "power": "Pow", "trunc": "Trunc", "max": "Max", "min": "Min",
        "length-of-text": "StrLen", "part-of-text": "StrPart",
        "match-in-text": "StrMatch", "timer": "ClkRead", "size-of-array": "Dim",
    }  # fmt: skip

    def __init__(self, program: st.Program, types: Mapping[str, str], names: RapidNames) -> None:
        super().__init__(program, program.vendor == "rapid")
        self.types = types
        self.arrays: frozenset[str] = frozenset()  # names in lower case
        self.before: list[str] = []
        self.temporary: dict[str, str] = {}  # name -> type
        self.under_way: set[str] = set()  # those of them that the statement under way has
        self.has_traps = any(TRAP in routine.details for routine in program.routines)
        self.timed_out = False
        self.names = names

    # --- names ------------------------------------------------------------------------------------------------

    def type_of(self, it: ex.Expression) -> str:
        """RAPID's type of a value, "" where it is not known."""
        match it:
            case ex.Named(name):
                return self.types.get(name.lower()) or self.temporary.get(name, "")
            case ex.Item(base, _):
                return self.type_of(base)
            case ex.Member(base, name):
                members = self.names.members(self.type_of(base)) or ()
                return next((self.names.resolved(of) for member, of in members if member == name), "num")
            case ex.PositionLiteral(kind, _):
                return "jointtarget" if kind == "joint" else "robtarget"
            case ex.Function(name, _) if name in _POSES:
                return "pose"
            case ex.Function("joints" | "inverse", _) | ex.SystemValue("current-joints"):
                return "jointtarget"
            case ex.Function(name, _) if name.startswith(("pose-off", "pose-rel", "forward")):
                return "robtarget"
            case ex.SystemValue("current-pose") | ex.Function("current-pose", _):
                return "robtarget"
        return ""

    def signal(self, it: ex.Signal) -> str:
        if isinstance(it.index, ex.Text):
            name = it.index.value
            if not self.own and not (name.isascii() and name.isidentifier()):
                raise CannotSayError(f"the signal '{name}'", "names have letters, digits and _ in RAPID")
            return name
        prefix = self.signals.get(it.bus)
        if prefix is None:
            raise CannotSayError(*terminology.signal(it))
        if isinstance(it.index, ex.Number):
            return f"{prefix}{int(it.index.value)}"
        named = it.index.base if isinstance(it.index, ex.Item) else it.index
        is_signal = isinstance(named, ex.Named) and self.types.get(named.name.lower(), "").startswith(
            "signal"
        )
        if self.own or is_signal:
            return self.value(it.index)
        raise CannotSayError("a signal with a computed number", "signals have names in RAPID")

    def _read(self, it: ex.Signal) -> str:
        """A signal's value: by its name where that looks like a signal's, otherwise through a function."""
        name = self.signal(it)
        declared = self.types.get(name.lower(), "").startswith("signal")
        word = _READERS.get(it.bus)
        if declared or word is None or signal_like(name) == it.bus:
            return name
        return f"{word}({name})"

    def is_digital(self, it: ex.Signal) -> bool:
        return not self.signals.get(it.bus, "di").startswith(_ANALOG)

    def temporary_name(self, kind: str) -> str:
        """A variable that the program does not have. The next statement may take the same one.

        Not where a trap may come in between, nor a trigger, which a later one must not change while it waits.
        """
        taken: Container[str] = self.under_way
        if kind == "triggdata" or self.has_traps:
            taken = self.temporary
        count = 1
        while f"olp_{kind}{count}" in taken or f"olp_{kind}{count}" in self.types:
            count += 1
        name = f"olp_{kind}{count}"
        self.temporary[name] = kind
        self.under_way.add(name)
        return name

    def stored(self, it: ex.Expression, kind: str) -> ex.Named:
        """The value in a variable, which an instruction before this one sets."""
        if isinstance(it, ex.Named) and self.type_of(it) in (kind, ""):
            return it
        text = self.as_robtarget(it) if kind == "robtarget" else self.typed(it, kind)
        name = self.temporary_name(kind)
        self.before.append(f"{name}:={text};")
        return ex.Named(name)

    # --- values -----------------------------------------------------------------------------------------------

    def typed(self, e: ex.Expression, kind: str) -> str:
        """An expression where the type `kind` is expected, "" for any."""
        if kind == "orient" and isinstance(e, ex.Function) and e.name == "pose-product":
            return self.orient_text(e)
        if kind and isinstance(e, ex.PositionLiteral):
            return literal(e, kind, self.own)
        if kind and isinstance(e, ex.RecordLiteral):
            return self._record(e, kind)
        if kind and isinstance(e, ex.Function) and e.name in self._functions and e.name != "joined-text":
            return str(self._functions[e.name](self, e.arguments, kind))
        return self.value(e)

    def spell_number(self, e: ex.Number) -> Spelled:
        return number(e.value), ATOM if e.value >= 0 else _SUM

    def spell_text(self, e: ex.Text) -> str:
        if len(e.value) > LONGEST_TEXT and not self.own:
            raise CannotSayError(f"a text of more than {LONGEST_TEXT} characters")
        return quoted(e.value)

    def spell_unknown(self, e: ex.Unknown) -> Spelled:
        return e.text if self.own or not e.text else super().spell_unknown(e)

    def spell_signal(self, e: ex.Signal) -> str:
        return self._read(e)

    def spell_position_literal(self, e: ex.PositionLiteral) -> str:
        return literal(e, "jointtarget" if e.kind == "joint" else "robtarget", self.own)

    def spell_binary(self, e: ex.Binary) -> Spelled:
        if e.operator == "/":  # always of real numbers
            e = ex.Binary("/", _whole(e.left), _whole(e.right))
        if e.operator in self.logic and any(map(self._is_number, (e.left, e.right))):
            raise CannotSayError(terminology.operation(e.operator), _BITS)
        return super().spell_binary(e)

    def _is_number(self, e: ex.Expression) -> bool:
        return not self.own and (type(e) is ex.Number or self.type_of(e) == "num")

    def spell_compare(self, e: ex.Compare) -> Spelled:
        return f"{self._compared(e.left, e.right)}{e.operator}{self._compared(e.right, e.left)}", _COMPARED

    def _compared(self, it: ex.Expression, other: ex.Expression) -> str:
        if isinstance(it, ex.SignalState) and isinstance(other, ex.Signal) and self.is_digital(other):
            return "1" if it.on else "0"
        return self.value(it, _COMPARED + 1)

    def operand(self, e: ex.Expression, strength: int) -> str:
        """An operand of AND, OR and NOT: a signal alone is compared, too."""
        return self.condition(e, strength)

    def spell_unary(self, e: ex.Unary) -> Spelled:
        if e.operator == "not" and isinstance(e.operand, ex.Signal) and self.is_digital(e.operand):
            return f"{self._read(e.operand)}=0", _COMPARED
        if e.operator == "not" and self._is_number(e.operand):
            raise CannotSayError("the bits of a number inverted", _BITS)
        return super().spell_unary(e)

    def condition(self, it: ex.Expression, strength: int = 0) -> str:
        """A truth value: a signal alone is compared with 1."""
        if isinstance(it, ex.Signal) and self.is_digital(it):
            text = f"{self._read(it)}=1"
            return f"({text})" if strength > _COMPARED else text
        return self.value(it, strength)

    def spell_item(self, e: ex.Item) -> str:
        base, indices = e.base, e.indices
        array = isinstance(base, ex.Named) and base.name.lower() in self.arrays
        axis = self.type_of(base) == "jointtarget" and len(indices) == 1 and not array
        if axis and isinstance(indices[0], ex.Number):
            if isinstance(base, (ex.SystemValue, ex.Function)):
                base = self.stored(base, "jointtarget")
            return f"{self.value(base)}.robax.rax_{indices[0].value}"
        if axis:
            raise CannotSayError("an axis by a computed number")
        if isinstance(base, ex.Item):  # dimensions stand in one pair of braces
            if self.type_of(base) in _POSITIONS:
                raise CannotSayError("a component of a position by a computed number")
            return self.spell_item(ex.Item(base.base, (*base.indices, *indices)))
        return f"{self.value(base)}{{{','.join(self.value(index) for index in indices)}}}"

    def spell_member(self, e: ex.Member) -> str:
        base, name = e.base, e.name
        if name in _ANGLES:
            return f"EulerZYX(\\{name[1].upper()},{self.turn(base)})"
        if isinstance(base, (ex.SystemValue, ex.Function, ex.CallValue)):
            base = self.stored(base, self.type_of(base) or "robtarget")
        if not isinstance(base, ex.Named | ex.Item | ex.Member):
            raise CannotSayError("a component of a value without a name", "assign it to a variable first")
        text, kind = self.value(base), self.type_of(base)
        if kind in FRAMES and name in _BEFORE:
            return f"{text}.{FRAMES[kind]}.{_BEFORE[name]}.{name}"
        if name in _BEFORE and kind not in ("pos", "orient") and not self._is_record(kind):
            return f"{text}.{_BEFORE[name]}.{name}"
        if len(name) == 2 and name[0] == "e" and name[1] in "123456":
            return f"{text}.extax.eax_{'abcdef'[int(name[1]) - 1]}"
        return f"{text}.{name}"

    def _is_record(self, kind: str) -> bool:
        return bool(kind) and kind not in ("robtarget", "pose", "jointtarget", "num")

    def turn(self, base: ex.Expression) -> str:
        """An orient: `base.rot`, or the orient itself."""
        if isinstance(base, (ex.SystemValue, ex.Function, ex.CallValue)):
            base = self.stored(base, self.type_of(base) or "robtarget")
        text, kind = self.value(base), self.type_of(base)
        if kind in FRAMES:
            return f"{text}.{FRAMES[kind]}.rot"
        return text if kind == "orient" else f"{text}.rot"

    def place(self, base: ex.Expression) -> str:
        """A pos: `base.trans`, or the pos itself."""
        if base == ex.SystemValue("current-pose"):
            return "CPos()"
        if isinstance(base, (ex.SystemValue, ex.Function, ex.CallValue)):
            base = self.stored(base, self.type_of(base) or "robtarget")
        text, kind = self.value(base), self.type_of(base)
        if kind in FRAMES:
            return f"{text}.{FRAMES[kind]}.trans"
        return text if kind == "pos" else f"{text}.trans"

    def spell_record_literal(self, e: ex.RecordLiteral) -> str:
        return self._record(e, "")

    def _record(self, e: ex.RecordLiteral, kind: str) -> str:
        of, members = e.type, e.members
        predefined = PREDEFINED_NAMES.get((of, members)) if of else None
        if predefined is not None and predefined not in self.types:
            return predefined
        if of == "jointtarget":
            joints = dict(members)["joints"]
            values = joints.arguments if isinstance(joints, ex.Function) else ()
            return f"[{self.robjoint_text(values)},{self._extra(members[1][1])}]"
        if of == "robjoint" and all(isinstance(value, ex.Item) for _, value in members):
            return self.robjoint_text(tuple(value for _, value in members))
        if of == "extjoint":
            if any(value == _NOT_CONNECTED for _, value in members):
                return f"[{','.join('9E9' if v == _NOT_CONNECTED else self.value(v) for _, v in members)}]"
            base = common_base(tuple(value for _, value in members), tuple(f"e{n}" for n in range(1, 7)))
            if base is not None:
                return f"{self.value(base)}.extax"
        known = dict(self.names.members(of) or ())
        texts = [self.typed(value, known.get(name, kind if not name else "")) for name, value in members]
        return f"[{','.join(texts)}]"

    def joints(self, it: ex.Expression) -> str:
        arguments = it.arguments if isinstance(it, ex.Function) else ()
        if len(arguments) > 6:
            raise CannotSayError("a position of more than six axes")
        return ",".join([*(self.value(one) for one in arguments), *["0"] * (6 - len(arguments))])

    def _extra(self, it: ex.Expression) -> str:
        return self.value(it.value) if isinstance(it, ex.NamedArgument) and it.value is not None else NO_AXES

    def spell_system_value(self, e: ex.SystemValue) -> Spelled:
        name = e.name
        if name in _MODES:
            return f"OpMode()={_MODES[name]}", _COMPARED
        if name == "current-pose":
            return "CRobT()"
        if name == "current-joints":
            return "CJointT()"
        if name == "timed-out":
            self.timed_out = True
            return TIMED_OUT
        raise CannotSayError(terminology.value(name))

    def spell_frame_ref(self, e: ex.FrameRef) -> str:
        if e.kind in ("base", "robot"):
            return "wobj0"
        if e.kind == "tool" and e.number in (None, ex.Number(0)):
            return "tool0"
        raise CannotSayError(
            terminology.SYSTEMS.get(e.kind, e.kind), "tools and work objects have names in RAPID"
        )

    # --- functions and calls --------------------------------------------------------------------------------

    def arguments(self, given: Sequence[ex.Expression]) -> str:
        """`a,b\\Option:=c`: options stand behind an argument without a comma."""
        if not self.own and ex.Unknown("") in given:
            raise CannotSayError("a call that leaves an argument out", "hand over a value")
        text = ""
        for place, one in enumerate(given):
            if isinstance(one, ex.NamedArgument):
                text += self.option(one)
            else:
                text += f"{',' if place else ''}{self.value(one)}"
        return text

    def option(self, it: ex.NamedArgument) -> str:
        if it.name.endswith("?") and it.value is not None:
            return f"\\{it.name}{self.value(it.value)}"
        return f"\\{it.name}" if it.value is None else f"\\{it.name}:={self.value(it.value)}"

    def as_pose(self, it: ex.Expression) -> str:
        """A value of type pose."""
        kind = self.type_of(it)
        if kind in FRAMES:
            return f"{self.value(it)}.{FRAMES[kind]}"
        if isinstance(it, (ex.PositionLiteral, ex.Function)) and not (
            isinstance(it, ex.Function) and it.name not in self._functions
        ):
            if self.type_of(it) == "robtarget" and isinstance(it, ex.Function):
                it = self.stored(it, "robtarget")
                return f"[{it.name}.trans,{it.name}.rot]"
            return self.typed(it, "pose")
        if self.type_of(it) in ("robtarget", "") and not self.own:
            text = (
                self.value(it)
                if isinstance(it, (ex.Named, ex.Item, ex.Member))
                else self.stored(it, "robtarget").name
            )
            return f"[{text}.trans,{text}.rot]"
        return self.typed(it, "pose")

    def as_robtarget(self, it: ex.Expression) -> str:
        """A value of type robtarget."""
        kind = self.type_of(it)
        if kind in FRAMES:
            text = f"{self.value(it)}.{FRAMES[kind]}"
            return f"[{text}.trans,{text}.rot,{NO_CONFIGURATION},{NO_AXES}]"
        if self.type_of(it) == "pose" and not (self.own and isinstance(it, ex.Named)):
            name = self.stored(it, "pose").name
            return f"[{name}.trans,{name}.rot,{NO_CONFIGURATION},{NO_AXES}]"
        return self.typed(it, "robtarget")

    def quantity(self, it: ex.Quantity, unit: float) -> str:
        ratio = it.scale / unit
        if abs(ratio - 1.0) < 1e-12:
            return self.value(it.written)
        if isinstance(it.written, ex.Number):
            value = round(it.written.value * ratio, 9)
            return number(int(value) if value == int(value) else value)
        return f"{self.value(it.written, 6)} * {number(round(ratio, 12))}"

    # --- functions that have a form of their own ------------------------------------------------------------

    def function_pose_product(self, given: Arguments, kind: str = "") -> str:
        return self._pose_call("PoseMult", given, kind)

    def function_pose_inverse(self, given: Arguments, kind: str = "") -> str:
        return self._pose_call("PoseInv", given, kind)

    def _pose_call(self, word: str, given: Arguments, kind: str) -> str:
        text = f"{word}({','.join(map(self.as_pose, given))})"
        if kind != "robtarget":
            return text
        name = self.temporary_name("pose")
        self.before.append(f"{name}:={text};")
        return f"[{name}.trans,{name}.rot,{NO_CONFIGURATION},{NO_AXES}]"

    def function_pose_offset(self, given: Arguments, kind: str = "") -> str:
        base = self.as_robtarget(given[0])
        if isinstance(given[0], ex.PositionLiteral) and base.startswith(_AT_ZERO):
            # A turn at a place that is computed: nobody writes an offset from zero.
            return f"[{self.place_text(given[1:4])},{base.removeprefix(_AT_ZERO)}"
        return f"Offs({base},{','.join(map(self.value, given[1:4]))})"

    def function_pose_relative_tool(self, given: Arguments, kind: str = "") -> str:
        angles = "".join(
            f"\\{name}:={self.value(value)}"
            for name, value in zip(("Rx", "Ry", "Rz"), given[4:7], strict=False)
            if value != ex.Number(0)
        )
        moved = ",".join(map(self.value, given[1:4]))
        return f"RelTool({self.as_robtarget(given[0])},{moved}{angles})"

    def function_pose_angles(self, given: Arguments, kind: str = "") -> str:
        place, turn, rest = given[:3], given[3:6], given[6:]
        if kind == "pos" or (not kind and turn == _ZEROS and place != _ZEROS):
            return self.place_text(place)
        if kind == "orient" or (not kind and place == _ZEROS):
            return self.turn_text(turn)
        turned = "[1,0,0,0]" if turn == _ZEROS else self.turn_text(turn)
        return self._assembled(self.place_text(place), turned, rest, kind)

    def function_pose_quaternion(self, given: Arguments, kind: str = "") -> str:
        turn = f"[{','.join(map(self.value, given[3:7]))}]"
        if kind == "orient" or (not kind and given[:3] == _ZEROS):
            return turn
        return self._assembled(self.place_text(given[:3]), turn, given[7:], kind)

    def function_pose_add(self, given: Arguments, kind: str = "") -> str:
        first, second = (self.stored(one, "robtarget").name for one in given)
        name = self.temporary_name("pose")
        self.before.append(f"{name}:=PoseMult([[0,0,0],{first}.rot],[[0,0,0],{second}.rot]);")
        place = ",".join(f"{first}.trans.{c}+{second}.trans.{c}" for c in _XYZ)
        return self._assembled(f"[{place}]", f"{name}.rot", (), kind)

    def function_joints(self, given: Arguments, kind: str = "") -> str:
        axes = [self.value(one.value) for one in given if isinstance(one, ex.NamedArgument) and one.value]
        return f"[{self.robjoint_text(given[:6])},{axes[0] if axes else NO_AXES}]"

    def function_pose_distance(self, given: Arguments, kind: str = "") -> str:
        def pos(it: ex.Expression) -> str:
            return (
                self.typed(it, "pos") if isinstance(it, (ex.Function, ex.PositionLiteral)) else self.place(it)
            )

        return f"Distance({pos(given[0])},{pos(given[1])})"

    def function_text_of_value(self, given: Arguments, kind: str = "") -> str:
        word = "NumToStr" if len(given) > 1 else "ValToStr"
        return f"{word}({','.join(map(self.value, given))})"

    def function_round(self, given: Arguments, kind: str = "") -> str:
        digits = f"\\Dec:={self.value(given[1])}" if len(given) > 1 else ""
        return f"Round({self.value(given[0])}{digits})"

    def _assembled(self, place: str, turn: str, rest: tuple[ex.Expression, ...], kind: str) -> str:
        if kind == "pose":
            return f"[{place},{turn}]"
        given = {
            one.name: one.value for one in rest if isinstance(one, ex.NamedArgument) and one.value is not None
        }
        arm = self.value(given["conf"]) if "conf" in given else NO_CONFIGURATION
        axes = self.value(given["axes"]) if "axes" in given else NO_AXES
        return f"[{place},{turn},{arm},{axes}]"

    def place_text(self, values: tuple[ex.Expression, ...]) -> str:
        """`p.trans`, or `[x,y,z]`."""
        base = common_base(values, _XYZ)
        return self.place(base) if base is not None else f"[{','.join(map(self.value, values))}]"

    def turn_text(self, values: tuple[ex.Expression, ...]) -> str:
        """`p.rot`, or `OrientZYX(z,y,x)`."""
        base = common_base(values, _ANGLES)
        if self.own and isinstance(base, ex.Function) and base.name == "pose-product":
            return self.orient_text(base)
        if base is not None:
            return self.turn(base)
        return f"OrientZYX({','.join(self.value(value) for value in reversed(values))})"

    def orient_text(self, e: ex.Expression) -> str:
        """A value of type orient; a product of two as one."""
        match e:
            case ex.Function("pose-product", (left, right)):
                first, second = map(self.orient_text, (left, right))
                grouped = isinstance(right, ex.Function) and right.name == "pose-product"
                return f"{first} * {f'({second})' if grouped else second}"
            case ex.Function("pose-angles", arguments):
                return self.turn_text(arguments[3:6])
        return self.typed(e, "orient")

    def robjoint_text(self, values: tuple[ex.Expression, ...]) -> str:
        """`j.robax`, a robjoint, or `[…]`."""
        if len(values) == 6:
            items = [one for one in values if isinstance(one, ex.Item)]
            if [one.indices for one in items] == [(ex.Number(n),) for n in range(1, 7)] and len(
                {one.base for one in items}
            ) == 1:
                return f"{self.value(items[0].base)}.robax"
            base = common_base(values, tuple(f"rax_{n}" for n in range(1, 7)))
            if base is not None:
                return self.value(base)
        return f"[{self.joints(ex.Function('joints', values))}]"

    def function_forward(self, given: Arguments, kind: str = "") -> str:
        return self._solved("CalcRobT", self.typed(given[0], "jointtarget"), given)

    def function_inverse(self, given: Arguments, kind: str = "") -> str:
        return self._solved("CalcJointT", self.as_robtarget(given[0]), given)

    def _solved(self, word: str, first: str, given: Arguments) -> str:
        named = {one.name: one.value for one in given if isinstance(one, ex.NamedArgument)}
        tool, frame = named.get("Tool"), named.get("WObj")
        chosen = "" if frame is None or frame == ex.FrameRef("base") else f"\\WObj:={self.value(frame)}"
        return f"{word}({first},{'tool0' if tool is None else self.value(tool)}{chosen})"

    def function_given(self, given: Arguments, kind: str = "") -> str:
        return f"Present({self.value(given[0])})"

    def function_current_pose(self, given: Arguments, kind: str = "") -> str:
        return f"CRobT({self.arguments(given)})"

    def function_current_joints(self, given: Arguments, kind: str = "") -> str:
        return f"CJointT({self.arguments(given)})"

    def function_joined_text(self, given: Arguments, kind: str = "") -> Spelled:
        # RAPID joins texts to nothing else.
        first, *others = (ex.Function("text-of-value", (e,)) if self._is_number(e) else e for e in given)
        texts = [self.value(first, _SUM), *(self.value(one, _PRODUCT) for one in others)]
        return " + ".join(texts), _SUM if others else ATOM


def common_base(values: tuple[ex.Expression, ...], names: tuple[str, ...]) -> ex.Expression | None:
    """The position whose members these are, None when they are not all of one."""
    bases = [
        one.base
        for one, name in zip(values, names, strict=True)
        if isinstance(one, ex.Member) and one.name == name
    ]
    return bases[0] if len(bases) == len(names) and all(base == bases[0] for base in bases) else None


def _whole(it: ex.Expression) -> ex.Expression:
    """2.0 as 2."""
    whole = isinstance(it, ex.Number) and isinstance(it.value, float) and float(it.value).is_integer()
    return ex.Number(int(it.value)) if whole and isinstance(it, ex.Number) else it


# --- Write positions ---
# Spells positions, tools, work objects and other structures: the way back of `literals`.

NO_AXES: Final = "[9E9,9E9,9E9,9E9,9E9,9E9]"
NO_CONFIGURATION: Final = "[0,0,0,0]"
_SAME: Final = 1e-9  # how far the cosine of half an angle may be from 1 for two quaternions to be one turn
_TURN_DIGITS: Final = 9
_DIGITS: Final = (4, 9)
_EXACT_DIGITS: Final = (4, 9, 12, 15)


def decimal(value: float, scale: float = 1.0, exact: bool = True) -> str:
    """The number whose `scale`-fold is `value`, with as few digits as give exactly it.

    At most fifteen decimals, nine unless `exact`: values that were computed need no more.
    """
    written = value / scale
    if not math.isfinite(written):
        raise CannotSayError(f"{written} is no number that a program can hold")
    for digits in _EXACT_DIGITS if exact else _DIGITS:
        text = f"{written:.{digits}f}".rstrip("0").rstrip(".")
        if float(text) * scale == value:
            break
    return "0" if text in ("-0", "") else text


def number(value: int | float) -> str:
    """A literal as it stands in an expression: 12 stays whole, 12.0 keeps its point."""
    if isinstance(value, int):
        return str(int(value))
    text = repr(value)
    if not math.isfinite(value):
        raise CannotSayError(f"{value} is no number that a program can hold")
    return text.replace("e", "E")


def quaternion(rx: float, ry: float, rz: float) -> tuple[float, float, float, float]:
    """w x y z, w >= 0, of R = Rz(rz) Ry(ry) Rx(rx) [rad]."""
    cx, sx, cy, sy = math.cos(rx / 2), math.sin(rx / 2), math.cos(ry / 2), math.sin(ry / 2)
    cz, sz = math.cos(rz / 2), math.sin(rz / 2)
    q = (
        cz * cy * cx + sz * sy * sx,
        cz * cy * sx - sz * sy * cx,
        cz * sy * cx + sz * cy * sx,
        sz * cy * cx - cz * sy * sx,
    )
    return q if q[0] >= 0 else (-q[0], -q[1], -q[2], -q[3])


@lru_cache(maxsize=20_000)
def turn(rx: float, ry: float, rz: float, written: str) -> str:
    """`[q1,q2,q3,q4]`; the digits that were read where they still mean this turn."""
    computed = quaternion(rx, ry, rz)
    if written:
        known = tuple(float(text) for text in written.split(","))
        size = math.sqrt(sum(q * q for q in known))
        if size and abs(sum(a * b for a, b in zip(computed, known, strict=True))) / size > 1.0 - _SAME:
            return f"[{written}]"
    texts = all_trimmed(computed, _TURN_DIGITS)
    assert texts is not None  # none is greater than one
    return f"[{','.join([one.rstrip('.') for one in texts])}]"


def place(values: tuple[float, ...], exact: bool = True) -> str:
    """`[x,y,z]` of metres."""
    x, y, z = values[:3]
    return f"[{decimal(x, mm, exact)},{decimal(y, mm, exact)},{decimal(z, mm, exact)}]"


def axes(external: tuple[float, ...]) -> str:
    """External axes [mm or deg]; 9E9: not connected."""
    if not external:
        return NO_AXES
    texts = ["9E9" if math.isnan(value) else decimal(value) for value in external[:6]]
    return f"[{','.join(texts + ['9E9'] * (6 - len(texts)))}]"


def literal(it: ex.PositionLiteral, kind: str, own: bool) -> str:
    """A position as a value of type `kind`. `own`: what RAPID wrote beside it holds."""
    if it.kind == "joint":
        if len(it.values) > 6:
            raise CannotSayError("a position of more than six axes")
        values = [*it.values, *[0.0] * (6 - len(it.values))]
        return f"[[{','.join(decimal(value, deg, own) for value in values)}],{axes(it.external)}]"
    values6 = it.values[:6]
    total = sum(values6)
    if total != total and any(map(math.isnan, values6)):
        raise CannotSayError("a position with values left out", "write all six")
    native = dict(it.native) if own else {}
    if kind == "pos":
        return place(values6, own)
    turned = turn(values6[3], values6[4], values6[5], native.get("orient", ""))
    if kind == "orient":
        return turned
    pose = f"{place(values6, own)},{turned}"
    if kind == "pose":
        return f"[{pose}]"
    if kind == "tooldata":
        return f"[TRUE,[{pose}],[1,[0,0,1],[1,0,0,0],0,0,0]]"
    if kind == "wobjdata":
        return f'[FALSE,TRUE,"",[{pose}],[[0,0,0],[1,0,0,0]]]'
    found = native.get("confdata", "") or confdata(it.configuration, it.sectors)
    arm = f"[{found}]" if found else NO_CONFIGURATION
    return f"[{pose},{arm},{axes(it.external)}]"
