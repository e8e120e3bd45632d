"""Lowers the grammar's expressions: one short method per rule. Aggregates keep their shape until a type is asked."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from typing import Any, Final

from lark import Token, Transformer

from olp.ir import expressions as ex
from olp.languages.lark_host import BrokenLineError
from olp.languages.vendors.rapid import literals
from olp.languages.vendors.rapid.literals import RapidAggregate, ShapeError, coerced, unquoted
from olp.languages.vendors.rapid.names import RapidNames
from olp.languages.vendors.rapid.predefined_data import (
    CONSTANTS,
    FASTEST,
    FUNCTIONS,
    LEAST_ARGUMENTS,
    SIGNAL_TYPES,
    SIGNAL_USERS,
    as_number,
)
from olp.languages.vendors.rapid.syntax import RapidArgument, RapidOption

# WAIT_MAX: waits without a limit; ABB's manuals give the name and no value.
NO_LIMIT: Final = ex.Number(999_999_999)
_CONSTANTS: Final[Mapping[str, ex.Expression]] = {
    **{name: ex.Number(value) for name, value in CONSTANTS.items()},
    "pi": ex.Number(math.pi),
    "wait_max": NO_LIMIT,
    "high": ex.Number(1),
    "low": ex.Number(0),
    "stempty": ex.Text(""),
    "str_empty": ex.Text(""),
}


class RapidExpressionRules(Transformer[Token, Any]):
    """`names` holds while a file is read."""

    def __init__(self) -> None:
        super().__init__()
        self.names = RapidNames()

    # --- literals ---------------------------------------------------------------------------------------------

    def number(self, children: list[Token]) -> ex.Number:
        text = children[0].lower()
        if len(text) > 40:
            raise BrokenLineError(f"a number of {len(text)} characters", word=text[:20])
        if text[:2] in ("0x", "0b", "0o"):
            return ex.Number(int(text, 0))
        return ex.Number(int(text)) if text.isdigit() else ex.Number(float(text))

    def text(self, children: list[Token]) -> ex.Text:
        return ex.Text(unquoted(children[0]))

    def boolean(self, children: list[Token]) -> ex.SignalState:
        return ex.SignalState(children[0].upper() == "TRUE")

    def aggregate(self, children: list[Any]) -> RapidAggregate:
        return RapidAggregate(tuple(child for child in children if child is not None))

    def here(self, children: list[Token]) -> ex.Unknown:
        return ex.Unknown("*")

    def unfilled(self, children: list[Token]) -> ex.Unknown:
        """`<EXP>`: a place that the editor keeps free."""
        return ex.Unknown(str(children[0]))

    # --- operators --------------------------------------------------------------------------------------------

    def or_(self, children: list[Any]) -> ex.Expression:
        return _logic("or", self.plain(children[0]), self.plain(children[2]))

    def and_(self, children: list[Any]) -> ex.Expression:
        return _logic("and", self.plain(children[0]), self.plain(children[2]))

    def and_not(self, children: list[Any]) -> ex.Expression:
        return _logic("and", self.plain(children[0]), ex.Unary("not", self.plain(children[3])))

    def xor(self, children: list[Any]) -> ex.Expression:
        return _logic("xor", self.plain(children[0]), self.plain(children[2]))

    def not_(self, children: list[Any]) -> ex.Unary:
        return ex.Unary("not", self.plain(children[1]))

    def compare(self, children: list[Any]) -> ex.Expression:
        left, right = self.plain(children[0]), self.plain(children[2])
        mode = MODES.get(right.name.lower()) if isinstance(right, ex.Named) else None
        if mode is not None and isinstance(left, ex.CallValue) and left.routine.lower() == "opmode":
            word = str(children[1])
            if word in ("=", "<>"):
                return ex.SystemValue(mode) if word == "=" else ex.Unary("not", ex.SystemValue(mode))
        if isinstance(left, ex.Signal):
            right = as_state(left, right)
        elif isinstance(right, ex.Signal):
            left = as_state(right, left)
        return ex.Compare(str(children[1]), left, right)

    def binary(self, children: list[Any]) -> ex.Expression:
        operator = children[1].lower()
        sides = children[0], children[2]
        if operator == "*" and any(literals.is_turn(one, self.names) for one in sides):
            return literals.turned(*sides)
        if operator in ("+", "-", "*") and (sum_ := self._places(operator, *sides)):
            return sum_
        left, right = self.plain(children[0]), self.plain(children[2])
        if operator == "+" and (literals.is_text(left, self.names) or literals.is_text(right, self.names)):
            return ex.Function("joined-text", (left, right))
        if operator == "/":  # one kind of number: 1/2 is 0.5
            left, right = _real(left), _real(right)
        return ex.Binary(operator, left, right)

    def _places(self, operator: str, left: Any, right: Any) -> ex.Function | None:
        """A sum of two pos, or a pos times a number, component by component; of two pos * is the vector product.

        None for numbers.
        """
        parts: tuple[ex.Expression, ...]
        is_place = [literals.is_place(one, self.names) or literals.is_vector(one) for one in (left, right)]
        if operator == "*" and all(is_place):
            (a, b, c), (x, y, z) = map(literals.place_parts, (left, right))
            products = ((b, z, c, y), (c, x, a, z), (a, y, b, x))
            parts = tuple(
                ex.Binary("-", ex.Binary("*", p, q), ex.Binary("*", r, s)) for p, q, r, s in products
            )
        elif operator == "*":
            if not any(is_place):
                return None
            pos, factor = (left, right) if is_place[0] else (right, left)
            parts = tuple(ex.Binary("*", part, factor) for part in literals.place_parts(pos))
        elif any(is_place):
            sides = map(literals.place_parts, (left, right))
            parts = tuple(_folded(operator, one, other) for one, other in zip(*sides, strict=True))
        else:
            return None
        return ex.Function("pose-angles", (*parts, ex.Number(0), ex.Number(0), ex.Number(0)))

    def negative(self, children: list[Any]) -> ex.Expression:
        operand = self.plain(children[1])
        return ex.Number(-operand.value) if type(operand) is ex.Number else ex.Unary("-", operand)

    def positive(self, children: list[Any]) -> ex.Expression:
        return self.plain(children[1])

    def plain(self, value: ex.Expression | RapidAggregate) -> ex.Expression:
        return self.coerce(value, "")

    def coerce(self, value: ex.Expression | RapidAggregate, kind: str, sizes: int = 0) -> ex.Expression:
        """Raises BrokenLineError where an aggregate does not fit."""
        try:
            return coerced(value, kind, self.names, sizes)
        except ShapeError as wrong:
            raise BrokenLineError(
                str(wrong), word="[", wanted=f"a value of type {kind}" if kind else ""
            ) from None

    # --- names ------------------------------------------------------------------------------------------------

    def sizes(self, children: list[Any]) -> tuple[ex.Expression, ...]:
        return tuple(map(self.plain, children))

    def index(self, children: list[Any]) -> tuple[ex.Expression, ...]:
        found: tuple[ex.Expression, ...] = children[0]
        return found

    def member(self, children: list[Token]) -> str:
        return str(children[0])

    def designator(self, children: list[Any]) -> ex.Expression:
        name = str(children[0])
        if len(children) == 1:
            return self.named(name)
        return self.parts(ex.Named(self.names.spelled(name)), children[1:])

    def named(self, name: str) -> ex.Expression:
        """A name alone: data, a constant of the controller, or a signal."""
        key = name.lower()
        variable = self.names.signal_variable(name)
        if variable is not None:
            return ex.Signal(variable, ex.Named(self.names.spelled(name)))
        if not self.names.knows(key):
            if key in _CONSTANTS:
                return _CONSTANTS[key]
            bus = self.names.bus_of(name)
            if bus is not None:
                return ex.Signal(bus, ex.Text(self.names.spelled(name)))
        return ex.Named(self.names.spelled(name))

    def parts(self, base: ex.Expression, postfixes: list[Any]) -> ex.Expression:
        """`base` with its indices and members: those of positions have neutral names."""
        found = base
        place = 0
        while place < len(postfixes):
            postfix = postfixes[place]
            place += 1
            if isinstance(postfix, tuple):
                found = ex.Item(found, postfix)
                continue
            found, place = self._member(found, postfix, postfixes, place)
        return found

    def _member(
        self, base: ex.Expression, name: str, rest: list[Any], place: int
    ) -> tuple[ex.Expression, int]:
        key = name.lower()
        kind = literals.type_of(base, self.names)
        following = rest[place].lower() if place < len(rest) and isinstance(rest[place], str) else ""
        if kind in ("", "num", "robtarget", "pose", "jointtarget"):
            if key in ("trans", "rot", "extax", "robax") and following:
                return _component(base, key, following), place + 1
            if key == "trans":
                return literals.place_of(base), place
            if key == "rot":
                return literals.turn_of(base), place
            if key in ("robax", "extax"):
                return literals.axes_of(base, key), place
        return ex.Member(base, self._member_name(kind, name)), place

    def _member_name(self, kind: str, name: str) -> str:
        """The member as its structure spells it."""
        members = self.names.members(kind) or ()
        return next((member for member, _ in members if member.lower() == name.lower()), name)

    # --- calls ------------------------------------------------------------------------------------------------

    def option(self, children: list[Any]) -> RapidOption:
        return RapidOption(str(children[1]), children[2])

    def passed_on(self, children: list[Any]) -> RapidOption:
        """`\\Name?parameter`: given when the caller gave it."""
        return RapidOption(str(children[1]) + "?", ex.Named(self.names.spelled(str(children[2]))))

    def argument(self, children: list[Any]) -> RapidArgument:
        if isinstance(children[0], RapidOption):
            return RapidArgument(None, tuple(children))
        return RapidArgument(children[0], tuple(children[1:]))

    def value(self, children: list[Any]) -> ex.Expression | RapidAggregate:
        found: ex.Expression | RapidAggregate = children[0]
        return found

    def arguments(self, children: list[RapidArgument]) -> list[RapidArgument]:
        """Options behind a comma belong to the argument before it: `tool0, \\WObj:=wobj1`."""
        found: list[RapidArgument] = []
        for one in children:
            if one.value is None and found:
                found[-1] = found[-1]._replace(options=(*found[-1].options, *one.options))
            else:
                found.append(one)
        return found

    def call(self, children: list[Any]) -> ex.Expression:
        name, given = str(children[0]), children[1] or []
        found = self._function(name, given)
        return self.parts(found, children[2:]) if len(children) > 2 else found

    def _function(self, name: str, given: list[RapidArgument]) -> ex.Expression:
        key = name.lower()
        if key in self.names.routines:
            return ex.CallValue(self.names.spelled(name), self.passed(name, given))
        if key in SPECIAL:
            found = SPECIAL[key](self, given)
            if found is not None:
                return found
        if key.endswith("dnum") and key[:-4] in FUNCTIONS:
            key = key[:-4]
        if key in FUNCTIONS:
            kinds = ("robtarget",) if key == "offs" else ("pose", "pose") if key[:4] == "pose" else ()
            least = LEAST_ARGUMENTS.get(key, 1)
            if len(given) < least:
                says = f"{name} with {len(given)} argument{'s' * (len(given) != 1)}"
                raise BrokenLineError(says, word=name, wanted=f"{least} of them")
            return ex.Function(FUNCTIONS[key], self.plain_arguments(given, kinds))
        if key in SIGNAL_USERS:
            return self._signal_value(key, given)
        return ex.CallValue(self.names.spelled(name), self.passed(name, given))

    def plain_arguments(
        self, given: list[RapidArgument], kinds: tuple[str, ...] = ()
    ) -> tuple[ex.Expression, ...]:
        """Positional values first, then those of options: `Round(x\\Dec:=2)` has two."""
        values = [one.value for one in given if one.value is not None]
        options = [option.value for one in given for option in one.options if option.value is not None]
        padded = (*kinds, *("" for _ in values))
        positional = tuple(self.coerce(value, kind) for value, kind in zip(values, padded, strict=False))
        return (*positional, *map(self.plain, options))

    def passed(self, name: str, given: list[RapidArgument]) -> tuple[ex.Expression, ...]:
        """The arguments of a call, options by their names."""
        head = self.names.routines.get(name.lower())
        required = [kind for _, kind, optional in head.parameters if not optional] if head else []
        optional = (
            {key.lower(): kind for key, kind, is_optional in head.parameters if is_optional} if head else {}
        )
        found: list[ex.Expression] = []
        count = 0
        for one in given:
            if one.value is not None:
                found.append(self._handed(one.value, required[count] if count < len(required) else ""))
                count += 1
            for option in one.options:
                kind = optional.get(option.name.lower(), "")
                value = None if option.value is None else self._handed(option.value, kind)
                found.append(ex.NamedArgument(option.name, value))
        return tuple(found)

    def _handed(self, value: ex.Expression | RapidAggregate, kind: str) -> ex.Expression:
        """What a parameter of a type gets: a signal itself where the type is one."""
        if isinstance(value, ex.Named) and (usual := _USUAL_SYSTEMS.get(value.name.lower())) is not None:
            return usual
        bus = SIGNAL_TYPES.get(self.names.resolved(kind))
        if bus is not None and isinstance(value, (ex.Named, ex.Signal)):
            return self.signal(value, bus)
        return self.coerce(value, kind)

    def _signal_value(self, key: str, given: list[RapidArgument]) -> ex.Expression:
        signal = self.signal(given[0].value if given else None, SIGNAL_USERS[key])
        return ex.Compare("=", signal, ex.SignalState(True)) if key == "testdi" else signal

    def signal(self, value: ex.Expression | RapidAggregate | None, bus: str) -> ex.Signal:
        """A signal of an instruction: its name, or what an element of an array of signals names."""
        if isinstance(value, ex.Signal):
            return ex.Signal(bus, value.index)
        if isinstance(value, ex.Named):
            return ex.Signal(bus, ex.Text(value.name))
        if not isinstance(value, (ex.Item, ex.Member, ex.Unknown)):
            raise BrokenLineError("a signal is missing", word="", wanted="the name of a signal")
        return ex.Signal(bus, value)


def as_state(signal: ex.Signal, value: ex.Expression) -> ex.Expression:
    """1 and 0 beside a digital signal mean on and off."""
    digital = signal.bus in ("in", "out")
    return (
        ex.SignalState(value.value == 1)
        if digital and type(value) is ex.Number and value.value in (0, 1)
        else value
    )


def _logic(operator: str, left: ex.Expression, right: ex.Expression) -> ex.Logic:
    if isinstance(left, ex.Logic) and all(word == operator for word, _ in left.rest):
        return ex.Logic(left.first, (*left.rest, (operator, right)))
    return ex.Logic(left, ((operator, right),))


def _folded(operator: str, left: ex.Expression, right: ex.Expression) -> ex.Expression:
    if isinstance(right, ex.Number) and right.value == 0:
        return left
    return ex.Binary(operator, left, right)


def _real(value: ex.Expression) -> ex.Expression:
    return ex.Number(float(value.value)) if type(value) is ex.Number else value


def _component(base: ex.Expression, group: str, name: str) -> ex.Expression:
    """`p.trans.x`, `p.rot.q1`, `p.extax.eax_a`, `j.robax.rax_1`."""
    if group == "robax" and name[:4] == "rax_" and name[4:].isdigit():
        return ex.Item(base, (ex.Number(int(name[4:])),))
    if group == "extax" and name[:4] == "eax_" and name[4:] in "abcdef" and name[4:]:
        return ex.Member(base, f"e{'abcdef'.index(name[4:]) + 1}")
    return ex.Member(base, name)


# --- Functions ---
# Functions of RAPID with options, or whose neutral form is another: positions, texts, clocks.

Special = Callable[["RapidExpressionRules", list[RapidArgument]], ex.Expression | None]
_USUAL: Final[Mapping[tuple[str, str], ex.Expression]] = {
    ("tool", "tool0"): ex.FrameRef("tool", ex.Number(0)),
    ("wobj", "wobj0"): ex.FrameRef("base"),
}
_USUAL_SYSTEMS: Final = {name: value for (_, name), value in _USUAL.items()}
_EULER: Final = ("x", "y", "z")
_HERE: Final = frozenset({"tool", "wobj"})
MODES: Final = {"op_man_prog": "manual-reduced", "op_man_test": "manual-full"}  # what OpMode() gives
_ZEROS: Final = (ex.Number(0), ex.Number(0), ex.Number(0))


def _value(
    rules: RapidExpressionRules, given: list[RapidArgument], place: int, kind: str = ""
) -> ex.Expression:
    values = [one.value for one in given if one.value is not None]
    if place >= len(values) or values[place] is None:
        raise BrokenLineError(f"argument {place + 1} of a function is missing", word="(")
    return rules.coerce(values[place], kind)


def _options(rules: RapidExpressionRules, given: list[RapidArgument]) -> dict[str, ex.Expression]:
    found: dict[str, ex.Expression] = {}
    for one in given:
        for option in one.options:
            found[option.name.lower()] = (
                ex.SignalState(True) if option.value is None else rules.coerce(option.value, "")
            )
    return found


def _rel_tool(rules: RapidExpressionRules, given: list[RapidArgument]) -> ex.Expression:
    options = _options(rules, given)
    angles = tuple(options.get(name, ex.Number(0)) for name in ("rx", "ry", "rz"))
    return ex.Function(
        "pose-relative-tool",
        (
            _value(rules, given, 0, "robtarget"),
            *(_value(rules, given, n) for n in (1, 2, 3)),
            *angles,
        ),
    )


def _euler(rules: RapidExpressionRules, given: list[RapidArgument]) -> ex.Expression | None:
    letter = next((name for name in _options(rules, given) if name in _EULER), None)
    if letter is None:
        return None
    return literals.turn_parts(_value(rules, given, 0, "orient"))["xyz".index(letter)]


def _orient(rules: RapidExpressionRules, given: list[RapidArgument]) -> ex.Expression:
    z, y, x = (_value(rules, given, n) for n in range(3))
    return ex.Function("pose-angles", (*_ZEROS, x, y, z))


def _distance(rules: RapidExpressionRules, given: list[RapidArgument]) -> ex.Expression:
    return ex.Function("pose-distance", (_value(rules, given, 0, "pos"), _value(rules, given, 1, "pos")))


def _same(kind: str) -> Special:
    """A function that gives what it is given: numbers are of one kind, quaternions have the length 1."""

    def lowered(rules: RapidExpressionRules, given: list[RapidArgument]) -> ex.Expression | None:
        return None if _options(rules, given) else _value(rules, given, 0, kind)

    return lowered


def _length(rules: RapidExpressionRules, given: list[RapidArgument]) -> ex.Expression:
    """VectMagn: the root of the sum of the squares."""
    return ex.Function("sqrt", (_sum_of_products(rules, given, 0, 0),))


def _dot(rules: RapidExpressionRules, given: list[RapidArgument]) -> ex.Expression:
    return _sum_of_products(rules, given, 0, 1)


def _sum_of_products(
    rules: RapidExpressionRules, given: list[RapidArgument], first: int, second: int
) -> ex.Expression:
    left, right = (literals.place_parts(_value(rules, given, place, "pos")) for place in (first, second))
    x, y, z = (ex.Binary("*", one, other) for one, other in zip(left, right, strict=True))
    return ex.Binary("+", ex.Binary("+", x, y), z)


def _turned(rules: RapidExpressionRules, given: list[RapidArgument]) -> ex.Expression:
    """PoseVect: a place in the frame of a pose."""
    return ex.Function("pose-product", (_value(rules, given, 0, "pose"), _value(rules, given, 1, "pos")))


def _now(name: str) -> Special:
    """CTool, CWObj; None of another task's robot."""

    def lowered(rules: RapidExpressionRules, given: list[RapidArgument]) -> ex.Expression | None:
        return None if _options(rules, given) else ex.SystemValue(name)

    return lowered


def _fastest(rules: RapidExpressionRules, given: list[RapidArgument]) -> ex.Expression:
    return as_number(FASTEST)


def _bits(operator: str) -> Special:
    def lowered(rules: RapidExpressionRules, given: list[RapidArgument]) -> ex.Expression:
        return ex.Binary(operator, _value(rules, given, 0), _value(rules, given, 1))

    return lowered


def _inverted(rules: RapidExpressionRules, given: list[RapidArgument]) -> ex.Expression:
    return ex.Binary("-", ex.Number(255), _value(rules, given, 0))


def _shifted(operator: str) -> Special:
    """BitLSh, BitRSh: of a byte."""

    def lowered(rules: RapidExpressionRules, given: list[RapidArgument]) -> ex.Expression:
        shifted = ex.Binary(operator, _value(rules, given, 0), two_to(_value(rules, given, 1)))
        return ex.Binary("mod", shifted, ex.Number(256)) if operator == "*" else shifted

    return lowered


def _bit_is_set(rules: RapidExpressionRules, given: list[RapidArgument]) -> ex.Expression:
    return bit_is_set(_value(rules, given, 0), _value(rules, given, 1))


def bit_is_set(value: ex.Expression, place: ex.Expression) -> ex.Compare:
    """Whether a bit is 1; `place` counts from 1."""
    shifted = value if place == ex.Number(1) else ex.Binary("div", value, bit_value(place))
    return ex.Compare("=", ex.Binary("mod", shifted, ex.Number(2)), ex.Number(1))


def bit_value(place: ex.Expression) -> ex.Expression:
    if isinstance(place, ex.Number):
        return two_to(ex.Number(place.value - 1))
    return two_to(ex.Binary("-", place, ex.Number(1)))


def two_to(exponent: ex.Expression) -> ex.Expression:
    if isinstance(exponent, ex.Number) and exponent.value in range(53):
        return ex.Number(2 ** int(exponent.value))
    return ex.Function("power", (ex.Number(2), exponent))


def _place_now(rules: RapidExpressionRules, given: list[RapidArgument]) -> ex.Expression | None:
    """CRobT; in which frame and with which tool is kept where it is written. None: of another task's robot."""
    options = _options(rules, given)
    if not options:
        return ex.SystemValue("current-pose")
    if not options.keys() <= _HERE:
        return None
    return ex.Function(
        "current-pose", tuple(ex.NamedArgument(name, value) for name, value in _kept(rules, given))
    )


def _spot_now(rules: RapidExpressionRules, given: list[RapidArgument]) -> ex.Expression | None:
    """CPos: CRobT without its turn."""
    here = _place_now(rules, given)
    return None if here is None else literals.place_of(here)


def _joints_now(rules: RapidExpressionRules, given: list[RapidArgument]) -> ex.Expression | None:
    return None if _options(rules, given) else ex.SystemValue("current-joints")


def _kept(rules: RapidExpressionRules, given: list[RapidArgument]) -> list[tuple[str, ex.Expression | None]]:
    return [
        (option.name, None if option.value is None else _system(rules, option.name, option.value))
        for one in given
        for option in one.options
    ]


def _system(
    rules: RapidExpressionRules, name: str, value: ex.Expression | literals.RapidAggregate
) -> ex.Expression:
    """tool0 and wobj0 are the flange and the base."""
    key = (name.lower(), value.name.lower()) if isinstance(value, ex.Named) else ("", "")
    return _USUAL.get(key) or rules.coerce(value, "")


def _solved(name: str, kind: str) -> Special:
    """CalcRobT, CalcJointT: the tool and the work object behind the position; None with any other option."""

    def lowered(rules: RapidExpressionRules, given: list[RapidArgument]) -> ex.Expression | None:
        options = _options(rules, given)
        tool = next(iter([one.value for one in given if one.value is not None][1:2]), None)
        if tool is None or not options.keys() <= {"wobj"}:
            return None
        frame = next(
            (value for key, value in _kept(rules, given) if key.lower() == "wobj"), ex.FrameRef("base")
        )
        systems = (("Tool", _system(rules, "tool", tool)), ("WObj", frame))
        return ex.Function(
            name, (_value(rules, given, 0, kind), *(ex.NamedArgument(key, value) for key, value in systems))
        )

    return lowered


def _text(rules: RapidExpressionRules, given: list[RapidArgument]) -> ex.Expression | None:
    """NumToStr and ValToStr; None with an exponent."""
    return None if _options(rules, given) else ex.Function("text-of-value", rules.plain_arguments(given))


def _match(rules: RapidExpressionRules, given: list[RapidArgument]) -> ex.Expression | None:
    """StrMatch; StrFind of one character, which is a set of one."""
    values = rules.plain_arguments(given)
    return ex.Function("match-in-text", values) if len(values) == 3 and not _options(rules, given) else None


def _find(rules: RapidExpressionRules, given: list[RapidArgument]) -> ex.Expression | None:
    values = rules.plain_arguments(given)
    single = len(values) == 3 and isinstance(values[2], ex.Text) and len(values[2].value) == 1
    return _match(rules, given) if single else None


def _size(rules: RapidExpressionRules, given: list[RapidArgument]) -> ex.Expression | None:
    values = rules.plain_arguments(given)
    return ex.Function("size-of-array", values) if len(values) == 2 else None


def _timer(rules: RapidExpressionRules, given: list[RapidArgument]) -> ex.Expression | None:
    values = rules.plain_arguments(given)
    return ex.Function("timer", values) if len(values) == 1 else None


def _present(rules: RapidExpressionRules, given: list[RapidArgument]) -> ex.Expression:
    return ex.Function("given", (_value(rules, given, 0),))


# None: the function is called as it is written.
SPECIAL: Final[Mapping[str, Special]] = {
    "reltool": _rel_tool,
    "eulerzyx": _euler,
    "orientzyx": _orient,
    "distance": _distance,
    "crobt": _place_now,
    "cjointt": _joints_now,
    "cpos": _spot_now,
    "calcrobt": _solved("forward", "jointtarget"),
    "calcjointt": _solved("inverse", "robtarget"),
    "numtostr": _text,
    "valtostr": _text,
    "strmatch": _match,
    "strfind": _find,
    "dim": _size,
    "clkread": _timer,
    "present": _present,
    "dnumtonum": _same(""),
    "numtodnum": _same(""),
    "norient": _same("orient"),
    "vectmagn": _length,
    "dotprod": _dot,
    "posevect": _turned,
    "ctool": _now("current-tool"),
    "cwobj": _now("current-frame"),
    "maxrobspeed": _fastest,
    "bitand": _bits("and"),
    "bitor": _bits("or"),
    "bitxor": _bits("xor"),
    "bitneg": _inverted,
    "bitlsh": _shifted("*"),
    "bitrsh": _shifted("div"),
    "bitcheck": _bit_is_set,
}
