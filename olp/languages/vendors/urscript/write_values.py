"""Spells values: the way back of `expressions`, with the same factors taken off."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import ClassVar, Final

from olp.core.units import deg, mm
from olp.ir import expressions as ex
from olp.ir import program as st
from olp.ir import terminology
from olp.languages.generator import LARGEST_WHOLE, CannotSayError, Generator, Spelled
from olp.languages.literals import all_trimmed, trimmed
from olp.languages.vendors.urscript import builtins, helpers
from olp.languages.vendors.urscript.syntax import angles_from_vector, vector_from_angles

_SAME = 1e-12
_LEAST = 1e-3  # smaller numbers than these may be written with an exponent
_DECIMALS = 10  # of metres and radians of other languages' points: a ten-millionth of a millimetre
_ZERO = "p[0.0, 0.0, 0.0, 0.0, 0.0, 0.0]"
PLACES: Final = {"x": 0, "y": 1, "z": 2, "rotation1": 3, "rotation2": 4, "rotation3": 5}
_ANGLES: Final = ("rx", "ry", "rz")
_NOT, _COMPARISON, _SIGN, _WHOLE = 4, 5, 8, 9
_EULER = 2.718281828459045
_ORIGIN = (ex.Number(0.0), ex.Number(0.0), ex.Number(0.0))

Arguments = tuple[ex.Expression, ...]  # what a function is given


class UrscriptValues(Generator):
    """Spells expressions. `types`: name -> `Declare.type`, "list" for arrays; `used`: helpers needed."""

    language = "URScript"
    binary: ClassVar = {
        "+": (" + ", 6),
        "-": (" - ", 6),
        "*": (" * ", 7),
        "/": (" / ", 7),
        "mod": (" % ", 7),
    }
    unary: ClassVar = {"not": ("not ({})", _NOT, 0), "-": ("-{}", _SIGN, _SIGN)}
    logic: ClassVar = {"or": (" or ", 1), "xor": (" xor ", 1), "and": (" and ", 1)}
    comparisons: ClassVar = {"=": " == ", "<>": " != ", "<": " < ", ">": " > ", "<=": " <= ", ">=": " >= "}
    compared = (_COMPARISON, _COMPARISON + 1)
    states = ("False", "True")
    separator = ", "
    no_text = ("a text with quotes or a line end in it", "write it without them")
    no_value = "a value of a kind that URScript does not have"

    def __init__(self, program: st.Program) -> None:
        super().__init__(program, program.vendor == "urscript")
        self.types: dict[str, str] = {}
        self.returns: dict[str, str] = {}
        self.used: set[str] = set()

    def quantity(self, it: ex.Quantity, unit: float = 1.0) -> str:
        return self.value(it.written if it.scale == unit else ex.scaled(it.written, it.scale / unit))

    def kind(self, e: ex.Expression) -> str:
        """position, joints, list, another type, or nothing where it is not known."""
        match e:
            case ex.Named(name):
                return self.types.get(name, "")
            case ex.PositionLiteral(kind):
                return "joints" if kind == "joint" else "position"
            case ex.SystemValue(name):
                return {"current-joints": "joints", "current-pose": "position"}.get(name, "")
            case ex.Function(name):
                return "joints" if name in ("inverse", "joints") else "position" if _is_pose(name) else ""
            case ex.CallValue(routine):
                return self.returns.get(routine, "")
            case ex.Item(ex.Named(name), _):
                return self.types.get(f"{name}[]", "")
            case _:
                return ""

    # --- literals ---------------------------------------------------------------------------------------

    def spell_logic(self, e: ex.Logic) -> Spelled:
        """The manual does not say which of `and`, `or` and `xor` binds first: where they meet, parentheses do."""
        text, last = self.operand(e.first, 2), ""
        for operator, operand in e.rest:
            word, _ = self.logic[operator]
            left = text if last in ("", operator) else self.enclosed(text)
            text, last = f"{left}{word}{self.operand(operand, 2)}", operator
        return text, 1

    def spell_number(self, e: ex.Number) -> Spelled:
        value = e.value
        if not math.isfinite(value):
            raise CannotSayError(f"the number {value}")
        text = repr(float(value) if abs(value) > LARGEST_WHOLE and not self.own else value)
        return (text, _SIGN) if text[0] == "-" else text

    def spell_position_literal(self, e: ex.PositionLiteral) -> Spelled:
        if e.external and any(value == value and value != 0.0 for value in e.external):
            raise CannotSayError("further axes of a position", "UR arms have none")
        total = sum(e.values)
        if total != total and any(value != value for value in e.values):
            raise CannotSayError("a position with components left out", "write all of them")
        if e.kind == "joint":
            return f"[{', '.join(map(self.decimal, e.values))}]"
        turn = e.values[3:6]
        if self.own and e.native:
            written = dict(e.native).get("vector", "")
            if written and angles_from_vector(*map(float, written.split(","))) == turn:
                return f"p[{self._decimals(e.values[:3])}, {written}]"
        return f"p[{self._decimals((*e.values[:3], *vector_from_angles(*turn)))}]"

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

    def spell_record_literal(self, e: ex.RecordLiteral) -> Spelled:
        if all(not name for name, _ in e.members):
            return f"[{', '.join(self.value(value) for _, value in e.members)}]"
        return f"struct({', '.join(f'{name}={self.value(value)}' for name, value in e.members)})"

    # --- names ------------------------------------------------------------------------------------------

    def spell_frame_ref(self, e: ex.FrameRef) -> Spelled:
        if e.kind == "base" or (e.kind == "tool" and e.number == ex.Number(0)):
            return _ZERO
        raise CannotSayError(terminology.SYSTEMS.get(e.kind, e.kind), "name a frame with its pose")

    def spell_item(self, e: ex.Item) -> Spelled:
        text = self.element(e)
        return f"r2d({text})" if self.kind(e.base) == "joints" else text

    def element(self, e: ex.Item) -> str:
        """An element in URScript's own unit."""
        base = self.value(e.base, _WHOLE)
        return f"{base}[{', '.join(map(self.index, e.indices))}]"

    def index(self, e: ex.Expression) -> str:
        """An index from 0 of one from 1."""
        if type(e) is ex.Number:
            return str(int(e.value) - 1)
        if type(e) is ex.Binary and e.operator == "+" and e.right == ex.Number(1):
            return self.value(e.left)
        return f"{self.value(e, 6)} - 1"

    def spell_member(self, e: ex.Member) -> Spelled:
        kind = self.kind(e.base)
        if kind in ("joints", "list"):
            raise CannotSayError(f"the component {e.name} of joint angles or a list")
        record = kind not in ("", "position")
        if e.name in PLACES and not record:
            text = f"{self.value(e.base, _WHOLE)}[{PLACES[e.name]}]"
            return text if PLACES[e.name] > 2 else (f"{text} * 1000.0", 7)
        if e.name in _ANGLES and not record:
            return self.helper(f"olp_{e.name}", (e.base,))
        if not record and e.name in ("q1", "q2", "q3", "q4"):
            raise CannotSayError(f"the component {e.name} of a quaternion")
        return f"{self.value(e.base, _WHOLE)}.{e.name}"

    def helper(self, name: str, arguments: tuple[ex.Expression, ...]) -> str:
        """A call of one of olp's own functions, which the script then holds."""
        self.used.add(name)
        return f"{name}({', '.join(map(self.value, arguments))})"

    def spell_signal(self, e: ex.Signal) -> Spelled:
        return f"{self.signal_function(builtins.INPUT_WORDS, e)}({self.value(e.index)})"

    def signal_function(self, words: Mapping[str, str], e: ex.Signal) -> str:
        """The function that reads or sets a signal."""
        word = words.get(e.bus)
        if word is None or type(e.index) is ex.Text:
            raise CannotSayError(*terminology.signal(e))
        if word in helpers.TEXTS:
            self.used.add(word)
        return word

    def spell_system_value(self, e: ex.SystemValue) -> Spelled:
        words = {"current-pose": "get_actual_tcp_pose()", "current-joints": "get_actual_joint_positions()"}
        if e.name == "timed-out":
            return f"{helpers.COUNTER} <= 0", _COMPARISON
        if e.name not in words:
            raise CannotSayError(terminology.value(e.name))
        return words[e.name]

    # --- arithmetic -------------------------------------------------------------------------------------

    def spell_binary(self, e: ex.Binary) -> Spelled:
        special = self._factor(e)
        if special is not None:
            return special
        if e.operator == "div":
            return self.helper("olp_trunc", (ex.Binary("/", e.left, e.right),))
        found = (
            e.left if type(e.left) is ex.Function and e.operator == "-" and e.right == ex.Number(1) else None
        )
        if found is not None and found.name == "position-in-text" and len(found.arguments) == 2:
            return f"str_find({self.arguments(found.arguments)})"
        if found is not None and found.name == "find-in-text":
            text, start, wanted = found.arguments
            return f"str_find({self.arguments((text, wanted))}, {self.index(start)})"
        return super().spell_binary(e)

    def _factor(self, e: ex.Binary) -> str | None:
        """Metres and radians out of what olp holds in millimetres and degrees."""
        if e.operator != "*" or type(e.right) is not ex.Number:
            return None
        factor, operand = e.right.value, e.left
        if abs(factor / mm - 1.0) < _SAME:
            if isinstance(operand, ex.Member) and self._is_length(operand):
                return f"{self.value(operand.base, _WHOLE)}[{PLACES[operand.name]}]"
            if type(operand) is ex.Function and operand.name == "pose-distance":
                return f"point_dist({', '.join(map(self.value, operand.arguments))})"
        if abs(factor / deg - 1.0) < _SAME:
            return self.radians(operand)
        if abs(factor * deg - 1.0) < _SAME:
            return f"r2d({self.value(operand)})"
        return None

    def metres(self, e: ex.Expression) -> ex.Expression:
        """A length [mm] in metres: elements of poses, which have them there, stay as they are."""
        if type(e) is ex.Binary and e.operator in "+-" and any(map(self._has_length, (e.left, e.right))):
            return ex.Binary(e.operator, self.metres(e.left), self.metres(e.right))
        return ex.scaled(e, mm)

    def _has_length(self, e: ex.Expression) -> bool:
        if type(e) is ex.Binary and e.operator in "+-":
            return self._has_length(e.left) or self._has_length(e.right)
        return isinstance(e, ex.Member) and self._is_length(e)

    def spell_compare(self, e: ex.Compare) -> Spelled:
        """Two lengths, or one and a number, are compared in metres."""
        sides = (e.left, e.right)
        if any(map(self._has_length, sides)) and all(
            type(x) is ex.Number or self._has_length(x) for x in sides
        ):
            e = ex.Compare(e.operator, self.metres(e.left), self.metres(e.right))
        return super().spell_compare(e)

    def _is_length(self, e: ex.Member) -> bool:
        return PLACES.get(e.name, 9) < 3 and self.kind(e.base) in ("", "position")

    def radians(self, degrees: ex.Expression) -> str:
        """An angle of olp [deg] in radians."""
        if type(degrees) is ex.Item and self.kind(degrees.base) == "joints":
            return self.element(degrees)
        if type(degrees) is ex.Function and degrees.name in builtins.TO_ANGLE:
            return f"{degrees.name}({', '.join(map(self.value, degrees.arguments))})"
        if type(degrees) is ex.Binary and degrees.operator == "*" and type(degrees.right) is ex.Number:
            undone = abs(degrees.right.value * deg - 1.0) < _SAME
            if undone:
                return self.value(degrees.left)
        return f"d2r({self.value(degrees)})"

    # --- calls ------------------------------------------------------------------------------------------

    def spell_named_argument(self, e: ex.NamedArgument) -> Spelled:
        if e.value is None:
            raise CannotSayError(f"the switch {e.name}")
        return f"{e.name}={self.value(e.value)}"

    # --- functions --------------------------------------------------------------------------------------

    def spell_function(self, e: ex.Function) -> Spelled:
        """URScript's own word, an expression of them, or one of olp's helpers."""
        name, given = e.name, e.arguments
        if name in self._functions:
            return self._functions[name](self, given)
        if name in builtins.FROM_ANGLE:
            return f"{name}({self.radians(given[0])})"
        if name in builtins.TO_ANGLE:
            return f"r2d({name}({self.arguments(given)}))"
        if name in builtins.FUNCTION_WORDS:
            return f"{builtins.FUNCTION_WORDS[name]}({self.arguments(given)})"
        if name in helpers.WORDS:
            return self.helper(helpers.WORDS[name], given)
        if self.own or name in builtins.KNOWN:
            return f"{name}({self.arguments(given)})"
        raise CannotSayError(terminology.function(name))

    def pose(self, values: tuple[ex.Expression, ...]) -> str:
        """p[…] of metres and radians."""
        return f"p[{', '.join(self.value(value) for value in values)}]"

    def function_joints(self, given: Arguments) -> Spelled:
        values = [
            self.value(ex.scaled(one, deg)) if type(one) is ex.Number else self.radians(one) for one in given
        ]
        return f"[{', '.join(values)}]", _WHOLE

    def function_inverse(self, given: Arguments) -> Spelled:
        first, *rest = given
        near = [f"qnear={self.value(one)}" for one in rest[:1] if type(one) is not ex.NamedArgument]
        more = [self.value(one) for one in rest[len(near) :]]
        return f"get_inverse_kin({', '.join([self.value(first), *near, *more])})", _WHOLE

    def function_forward(self, given: Arguments) -> Spelled:
        return f"get_forward_kin({self.arguments(given)})", _WHOLE

    def function_pose_vector(self, given: Arguments) -> Spelled:
        return self.pose(given), _WHOLE

    def function_pose_element(self, given: Arguments) -> Spelled:
        base, index = given
        return self.element(ex.Item(base, (index,))), _WHOLE

    def function_pose_offset(self, given: Arguments) -> Spelled:
        """Positions of the two add, and the second turn is none."""
        base, *shift = given
        lengths = tuple(ex.scaled(one, mm) for one in shift)
        return f"pose_add({self.value(base)}, {self.pose((*lengths, *_ORIGIN))})", _WHOLE

    def function_pose_relative_tool(self, given: Arguments) -> Spelled:
        """Shift and turns one after the other, each about an axis that the ones before have turned."""
        base, *numbers = given
        shift = tuple(ex.scaled(one, mm) for one in numbers[:3])
        text, turned = self.value(base), False
        for axis, angle in enumerate(numbers[3:6]):
            if angle in (ex.Number(0), ex.Number(0.0)):
                continue
            turn = list(_ORIGIN)
            turn[axis] = ex.Number(0.0)
            written = [self.value(one) for one in turn]
            written[axis] = (
                self.value(ex.scaled(angle, deg)) if type(angle) is ex.Number else self.radians(angle)
            )
            place = ", ".join(self.value(one) for one in (_ORIGIN if turned else shift))
            text, turned = f"pose_trans({text}, p[{place}, {', '.join(written)}])", True
        if not turned:
            text = f"pose_trans({text}, {self.pose((*shift, *_ORIGIN))})"
        return text, _WHOLE

    def function_pose_angles(self, given: Arguments) -> Spelled:
        """pose-angles of numbers is a pose like any other."""
        if all(type(one) is ex.Number for one in given) and len(given) == 6:
            factors = (mm, mm, mm, deg, deg, deg)
            values = tuple(
                float(one.value) * factor
                for one, factor in zip(given, factors, strict=True)
                if isinstance(one, ex.Number)
            )
            return self.value(ex.PositionLiteral("pose", values))
        return self.helper("olp_pose", given)

    def function_pose_distance(self, given: Arguments) -> Spelled:
        return f"point_dist({self.arguments(given)}) * 1000.0", 7

    def function_joined_text(self, given: Arguments) -> Spelled:
        if not given:
            return '""'
        text = self.value(given[0])
        for one in given[1:]:
            text = f"str_cat({text}, {self.value(one)})"
        return text, _WHOLE

    def function_part_of_text(self, given: Arguments) -> Spelled:
        text, start, *count = given
        first = self.index(start)
        if count == [ex.Number(1)]:
            return f"str_at({self.value(text)}, {first})"
        return f"str_sub({', '.join([self.value(text), first, *map(self.value, count)])})", _WHOLE

    def function_position_in_text(self, given: Arguments) -> Spelled:
        return f"str_find({self.arguments(given)}) + 1", 6

    def function_length_of_text(self, given: Arguments) -> Spelled:
        return f"str_len({self.arguments(given)})", _WHOLE

    def function_size_of_array(self, given: Arguments) -> Spelled:
        return f"length({self.value(given[0])})", _WHOLE

    def function_exp(self, given: Arguments) -> Spelled:
        return f"pow({_EULER}, {self.value(given[0])})", _WHOLE

    def function_log(self, given: Arguments) -> Spelled:
        return f"log({_EULER}, {self.value(given[0])})", _WHOLE

    def function_abs(self, given: Arguments) -> Spelled:
        return f"norm({self.arguments(given)})", _WHOLE

    def function_run(self, given: Arguments) -> Spelled:
        return f"run {self.value(given[0])}", 8


def _is_pose(name: str) -> bool:
    return name == "forward" or (name.startswith("pose-") and name not in ("pose-distance", "pose-element"))
