"""Lowers one PDL2 instruction: one short method per rule of grammars/pdl2.lark."""

from __future__ import annotations

import re
from collections.abc import Collection, Iterable
from dataclasses import replace
from typing import Any, Final, NamedTuple, cast

from lark import Token

from olp.core.units import mm, ms, percent
from olp.ir import expressions as ex
from olp.ir import program as st
from olp.ir.transformer import mapped
from olp.languages.lark_host import BrokenLineError
from olp.languages.short_reader import NotModelledError, constants, zyz_pose
from olp.languages.statement_rules import BlockRules
from olp.languages.vendors.pdl2.manners import MANNERS

_EXACT: Final = st.Blend(st.BlendKind.RADIUS, ex.Quantity(ex.Number(0), mm))
_FULL: Final = st.Speed(st.SpeedUnit.FRACTION, ex.Quantity(ex.Number(100), percent))
_BUSES: Final = {
    "$DIN": "in", "$DOUT": "out", "$IN": "in", "$OUT": "out", "$GIN": "in-group", "$GOUT": "out-group",
    "$AIN": "analog-in", "$AOUT": "analog-out", "$FDIN": "robot-in", "$FDOUT": "robot-out", "$BIT": "flag",
}  # fmt: skip
_FUNCTIONS: Final[dict[str, str]] = {
    "SQRT": "sqrt", "ABS": "abs", "SIN": "sin", "COS": "cos", "TAN": "tan", "ATAN2": "atan2", "ROUND": "round",
    "ASIN": "asin", "ACOS": "acos", "TRUNC": "trunc", "EXP": "exp", "LN": "log",
    "POS_INV": "pose-inverse", "STR_LEN": "length-of-text",
}  # fmt: skip
_HERE: Final = ex.SystemValue("current-pose")
_CURRENT: Final[dict[str, ex.Expression]] = {"ARM_POS": _HERE, "ARM_JNTP": ex.SystemValue("current-joints")}
_SCREENS: Final = ("LUN_CRT", "LUN_TP")
_OVERRIDES: Final = ("$ARM_SPD_OVR", "$PROG_SPD_OVR", "$ARM_OVR", "$GEN_OVR")
_SETS: Final = re.compile(r"\s*(" + "|".join(map(re.escape, _OVERRIDES)) + r")\s*:=([^-]*)", re.IGNORECASE)
_RATES: Final = ("$ARM_ACC_OVR", "$PROG_ACC_OVR")


def overrides_set(lines: Iterable[str]) -> tuple[str, ...]:
    """The overrides that a program sets, in order, without those that are 100 % beside others all the time."""
    found: dict[str, set[str]] = {}
    for line in lines:
        if "_OVR" in line.upper() and (match := _SETS.match(line)):
            found.setdefault(match[1].upper(), set()).add(match[2].strip())
    varying = tuple(name for name, values in found.items() if values != {"100"})
    return varying or tuple(found)


class MoveType(NamedTuple):
    """$MOVE_TYPE: the path of moves that name none."""

    path: st.Path


class Untyped(NamedTuple):
    """A move that names no path."""

    move: st.Move


class Pdl2Rules(BlockRules):
    """All of PDL2. `fly_distance`: the program sets $FLY_DIST, so that MOVEFLY goes by it.

    `overrides`: the variables of this kind that it sets; the controller multiplies them with each other.
    """

    def __init__(self, fly_distance: bool, overrides: tuple[str, ...]) -> None:
        super().__init__()
        self.fly_distance, self.overrides = fly_distance, overrides
        self.settled_by = (fly_distance, overrides)

        self._enclosed: list[ex.Expression] = []  # values of this line that stand in brackets

    # --- values -----------------------------------------------------------------------------------------

    def enclosed(self, children: list[Any]) -> ex.Expression:
        value: ex.Expression = children[0]
        self._enclosed.append(value)
        return value

    def _handed_over(self, arguments: tuple[ex.Expression, ...]) -> tuple[ex.Expression, ...]:
        """Arguments of a call. A variable in brackets is handed over as a copy, which no statement here says."""
        enclosed, self._enclosed = self._enclosed, []
        for argument in arguments:
            variable = isinstance(argument, (ex.Named, ex.Item, ex.Member))
            if variable and any(argument is one for one in enclosed):
                raise NotModelledError("it hands over a copy of a variable, which stands in brackets")
        return arguments

    def value(self, children: list[Any]) -> ex.Expression:
        return self.conjunction(children)

    def sum(self, children: list[Any]) -> ex.Expression:
        """Vectors are not computed with: what one means in the frame of a position is not known here."""
        if len(children) > 1 and any(isinstance(one, ex.RecordLiteral) for one in children):
            raise NotModelledError("it computes with vectors")
        return super().sum(children)

    def equal(self, children: list[ex.Expression]) -> ex.Compare:
        return ex.Compare("=", *children)

    def text(self, children: list[Token]) -> ex.Text:
        return ex.Text(str(children[0])[1:-1].replace("''", "'"))

    def composed(self, children: list[ex.Expression]) -> ex.Expression:
        value = children[0]
        for right in children[1:]:
            value = ex.Function("pose-product", (value, right))
        return value

    def name(self, children: list[Any]) -> ex.Expression:
        word = str(children[0])
        return _CURRENT.get(word.upper()) or ex.Named(self.spelled(word))

    def system(self, children: list[Any]) -> ex.Expression:
        return ex.Named(str(children[0]).upper())

    def item(self, children: list[Any]) -> ex.Expression:
        word, indices = str(children[0]), tuple(children[1])
        if word.upper() in _BUSES and len(indices) == 1:
            return ex.Signal(_BUSES[word.upper()], indices[0])
        if word.upper() == "$TIMER" and len(indices) == 1 and isinstance(indices[0], ex.Number):
            return ex.Binary("*", ex.SystemValue("timer", int(indices[0].value)), ex.Number(1000))
        return ex.Item(ex.Named(word.upper() if word[0] == "$" else self.spelled(word)), indices)

    def member(self, children: list[Any]) -> ex.Expression:
        return ex.Member(children[0], str(children[1]).lower())

    def member_item(self, children: list[Any]) -> ex.Expression:
        return ex.Item(self.member(children[:2]), tuple(children[2]))

    def function(self, children: list[Any]) -> ex.Expression:
        name, arguments = str(children[0]), tuple(children[1] or ())
        word = name.upper()
        if word == "POS":
            return _pose(arguments)
        if word == "VEC":
            return ex.RecordLiteral("vector", tuple(zip("xyz", arguments, strict=False)))
        if word in _CURRENT:
            return _CURRENT[word]
        if word in _FUNCTIONS:
            return ex.Function(_FUNCTIONS[word], arguments)
        return ex.CallValue(self.spelled(name), self._handed_over(arguments))

    # --- moves ------------------------------------------------------------------------------------------

    def arm(self, children: list[Any]) -> Any:
        return children[0]

    def via(self, children: list[Any]) -> tuple[str, Any]:
        return "via", children[0]

    def til(self, children: list[Any]) -> tuple[str, Any]:
        return "until", children[0]

    def advance(self, _: list[Any]) -> tuple[str, Any]:
        return "no_wait", True

    def comma(self, _: list[Any]) -> tuple[str, Any]:
        return "", None

    def setting(self, children: list[Any]) -> tuple[ex.Expression, ex.Expression | None]:
        return children[0], children[1]

    def with_(self, children: list[Any]) -> tuple[str, Any]:
        return "with", children[-1]

    def move(self, children: list[Any]) -> Any:
        word, arm, path, _, target, *tails = children
        return self._move(str(word), arm, path, target, tails)

    def near(self, children: list[Any]) -> Any:
        word, arm, path, target, distance, *tails = children
        return self._move(str(word), arm, path, _back(target, distance), tails)

    def away(self, children: list[Any]) -> Any:
        word, arm, path, distance, *tails = children
        return self._move(str(word), arm, path, _back(_HERE, distance), tails)

    def relative(self, children: list[Any]) -> Any:
        word, arm, path, vector, frame, *tails = children
        if not isinstance(vector, ex.RecordLiteral) or len(vector.members) != 3:
            raise NotModelledError("it goes by what is no vector of three numbers")
        way = tuple(value for _, value in vector.members)
        place = frame.name.upper() if isinstance(frame, ex.Named) else "TOOL"
        if place == "TOOL":
            target = ex.Function(
                "pose-relative-tool", (_HERE, *way, ex.Number(0), ex.Number(0), ex.Number(0))
            )
        elif place == "UFRAME":
            target = ex.Function("pose-offset", (_HERE, *way))
        else:
            raise NotModelledError("it goes by a vector in neither the tool's nor the user's frame")
        return self._move(str(word), arm, path, target, tails)

    def _move(
        self,
        word: str,
        arm: ex.Expression | None,
        path: Token | None,
        target: ex.Expression,
        tails: list[Any],
    ) -> Any:
        """`arm`: which of the controller's arms moves; only the first one is that of the program."""
        fields: dict[str, Any] = {}
        other = [("arm", arm)] if arm is not None and arm != ex.Number(1) else []
        settings: list[tuple[ex.Expression, ex.Expression | None]] = []
        for name, value in tails:
            if name == "with":
                settings.append(value)
            elif name:
                fields[name] = value
        shape = st.Path.JOINT if path is None else st.Path(str(path).lower())
        if "via" in fields:
            shape = st.Path.CIRCULAR
        elif shape is st.Path.CIRCULAR:
            raise BrokenLineError("an arc without a point on it", wanted="VIA and a position")
        fly = word.upper() == "MOVEFLY"
        blend = (
            (st.Blend(st.BlendKind.RADIUS) if self.fly_distance else st.Blend(st.BlendKind.CONTINUOUS))
            if fly
            else _EXACT
        )
        move = st.Move(0, shape, (target,), _FULL if shape is st.Path.JOINT else None, blend, **fields)
        for key, value in settings:
            move = self._with(move, key, value, other, fly)
        move = replace(move, other=tuple(other))
        return move if path is not None or move.via is not None else Untyped(move)

    def _with(
        self, move: st.Move, key: ex.Expression, value: ex.Expression | None, other: list[Any], fly: bool
    ) -> st.Move:
        """The move with one of its own settings, or with a condition that holds during it."""
        word = key.name if isinstance(key, ex.Named) else ""
        if value is None:
            other.append(("condition", key))
            return move
        if word == "$LIN_SPD":
            return move if move.path is st.Path.JOINT else replace(move, speed=_travel(value))
        if word in _OVERRIDES and move.path is st.Path.JOINT:
            if word in self.overrides:  # this value stands in for that one, and is no share of it
                raise NotModelledError(f"{word} is not what another line sets it to")
            return replace(move, speed=st.Speed(st.SpeedUnit.FRACTION, ex.Quantity(value, percent)))
        if word == "$ROT_SPD":
            return replace(move, turn=ex.Quantity(value, 1.0))
        if word == "$FLY_DIST" and fly:
            return replace(move, blend=st.Blend(st.BlendKind.RADIUS, ex.Quantity(value, mm)))
        if word == "$TOOL":
            return replace(move, tool=value)
        if word == "$UFRAME":
            return replace(move, frame=value)
        if word in _RATES:
            return replace(move, acceleration=ex.Quantity(value, percent))
        other.append((word or "setting", value))
        return move

    # --- assignments -----------------------------------------------------------------------------------

    def assign(self, children: list[Any]) -> Any:
        target, value = children
        if isinstance(target, ex.Signal):
            return st.SetOutput(0, target, value)
        if isinstance(target, ex.Binary):  # a timer, in ms
            return st.Assign(0, target.left, ex.Binary("/", value, ex.Number(1000)))
        if isinstance(target, ex.Named) and target.name[0] == "$":
            return self._system(target.name, target, value)
        if not isinstance(target, (ex.Named, ex.Item, ex.Member)):
            raise BrokenLineError("nothing can be stored here", wanted="a variable or a port")
        return st.Assign(0, target, value)

    def update(self, children: list[Any]) -> Any:
        target, word, value = children
        return self.assign([target, ex.Binary(str(word)[0], target, value)])

    def _system(self, word: str, target: ex.Named, value: ex.Expression) -> Any:
        if word == "$TOOL":
            return st.SetTool(0, value)
        if word == "$UFRAME":
            return st.SetFrame(0, value)
        if word == "$LIN_SPD":
            return st.SetSpeed(0, (_travel(value),))
        if word == "$ROT_SPD":
            return st.SetSpeed(0, (), turn=ex.Quantity(value, 1.0))
        if word in _OVERRIDES:
            if word not in self.overrides:
                return []  # 100 %, beside another one
            if word in self.overrides[1:]:
                raise NotModelledError(f"it is multiplied with {self.overrides[0]}")
            return st.SetOverride(0, ex.Quantity(value, percent))
        if word in _RATES:
            return st.SetAcceleration(
                0, (st.Acceleration(st.AccelerationUnit.FRACTION, ex.Quantity(value, percent)),)
            )
        if word == "$FLY_DIST":
            return st.SetBlend(0, (st.Blend(st.BlendKind.RADIUS, ex.Quantity(value, mm)),))
        if word == "$MOVE_TYPE" and isinstance(value, ex.Named) and value.name.upper() in ("JOINT", "LINEAR"):
            return MoveType(st.Path(value.name.lower()))
        if word.casefold() in MANNERS:
            return st.Assign(0, target, ex.Text(value.name) if isinstance(value, ex.Named) else value)
        if word == "$SPD_OPT" and value == ex.Named("SPD_LIN"):
            return []  # as a controller begins: the speeds are those of the tool along and about its path
        raise NotModelledError("it is a system variable that olp does not know")

    # --- everything else ----------------------------------------------------------------------------------

    def delay(self, children: list[Any]) -> st.Dwell:
        return st.Dwell(0, ex.Quantity(children[0], ms))

    def written(self, children: list[Any]) -> ex.Expression:
        """A value that WRITE shows, with so many decimals; how wide is left to the target."""
        value, _, *decimals = children
        return ex.Function("text-of-value", (value, *decimals)) if decimals else cast(ex.Expression, value)

    def write(self, children: list[Any]) -> list[st.Message]:
        """What the pendant or the screen shows: a message for each of its lines; into a file, it is not modelled."""
        place, *items = children
        if place is not None and not (isinstance(place, ex.Named) and place.name.upper() in _SCREENS):
            raise NotModelledError("it writes into a file")
        lines: list[list[ex.Expression]] = [[]]
        for item in items:
            if isinstance(item, ex.Named) and item.name.upper() == "NL":
                lines.append([])
            else:
                lines[-1].append(item)
        return [st.Message(0, _shown(line)) for line in lines if line] or [st.Message(0, ex.Text(""))]

    def pulse(self, children: list[Any]) -> list[st.PulseOutput | st.Dwell]:
        """Without ADVANCE the program waits until the pulse has ended."""
        return [self.pulse_on(children), st.Dwell(0, ex.Quantity(children[1], ms))]

    def pulse_on(self, children: list[Any]) -> st.PulseOutput:
        if not isinstance(children[0], ex.Signal):
            raise BrokenLineError("a pulse on what is no port", wanted="PULSE $DOUT[1] FOR 500")
        return st.PulseOutput(0, children[0], ex.Quantity(children[1], ms))

    def for_(self, children: list[Any]) -> st.For:
        variable, start, direction, stop, step = children
        if not isinstance(variable, ex.Named):
            raise BrokenLineError(
                "a loop that counts in an array", wanted="a variable, as in FOR i := 1 TO 3 DO"
            )
        if str(direction).upper() == "DOWNTO":
            step = ex.Number(-1) if step is None else ex.Unary("-", step)
        return st.For(0, variable, start, stop, step)

    def goto(self, children: list[Any]) -> st.Jump:
        return st.Jump(0, str(children[0]).casefold())

    def label(self, children: list[Any]) -> st.Label:
        return st.Label(0, str(children[0]).casefold())

    def return_(self, children: list[Any]) -> st.Return:
        return st.Return(0, children[0])

    def activate(self, children: list[Any]) -> st.StartTask:
        return st.StartTask(0, self.spelled(str(children[0])), str(children[0]))

    def call(self, children: list[Any]) -> st.Call:
        return st.Call(0, self.spelled(str(children[0])), self._handed_over(tuple(children[1] or ())))


def _travel(value: ex.Expression) -> st.Speed:
    return st.Speed(st.SpeedUnit.TRAVEL, ex.Quantity(value, 1.0))


def _pose(values: tuple[ex.Expression, ...]) -> ex.Expression:
    """POS(x, y, z, a, e, r, 'flags'); values that are left out at the end are 0, as in POS(0)."""
    flags = values[-1].value if values and isinstance(values[-1], ex.Text) else ""
    given = values[:-1] if values and isinstance(values[-1], ex.Text) else values
    if not given or len(given) > 6:
        raise BrokenLineError(f"a position with {len(given)} values", wanted="POS(x, y, z, a, e, r, 'flags')")
    values = (*given, *[ex.Number(0)] * (6 - len(given)))
    numbers = constants(values)
    if numbers is not None:
        return zyz_pose(numbers, (("CNFG", flags),) if flags else ())
    x, y, z, a, e, r = values
    zero = ex.Number(0)
    tilted = ex.Function("pose-angles", (x, y, z, zero, e, a))  # Rz(a) Ry(e)
    return ex.Function("pose-product", (tilted, ex.Function("pose-angles", (*(zero,) * 5, r))))


def _shown(items: list[ex.Expression]) -> ex.Expression:
    """A line of what WRITE shows, its values as texts."""
    parts = tuple(one if _is_shown(one) else ex.Function("text-of-value", (one,)) for one in items)
    return parts[0] if len(parts) == 1 else ex.Function("joined-text", parts)


def _is_shown(e: ex.Expression) -> bool:
    return isinstance(e, ex.Text) or (isinstance(e, ex.Function) and e.name == "text-of-value")


def _back(start: ex.Expression, distance: ex.Expression) -> ex.Expression:
    """`distance` [mm] back along the tool's z."""
    back = ex.Number(-distance.value) if isinstance(distance, ex.Number) else ex.Unary("-", distance)
    if isinstance(start, ex.PositionLiteral) and start.kind == "joint":
        start = ex.Function("forward", (start,))
    zero = ex.Number(0)
    return ex.Function("pose-relative-tool", (start, zero, zero, back, zero, zero, zero))


def with_bits(body: list[st.Statement], integers: Collection[str]) -> list[st.Statement]:
    """AND, OR, XOR and NOT of whole numbers compute with their bits; `integers`: case folded names of such data."""

    def whole(e: ex.Expression) -> bool:
        if isinstance(e, (ex.Item, ex.Named)):
            base = e.base if isinstance(e, ex.Item) else e
            return isinstance(base, ex.Named) and base.name.casefold() in integers
        if isinstance(e, ex.Binary):
            return e.operator != "/" and whole(e.left) and whole(e.right)
        if isinstance(e, ex.Unary):
            return e.operator == "-" and whole(e.operand)
        if isinstance(e, ex.Signal):
            return e.bus.endswith("-group")
        return (isinstance(e, ex.Number) and float(e.value).is_integer()) or (
            isinstance(e, ex.Function) and e.name in ("bit-not", "trunc", "round")
        )

    def change(e: ex.Expression) -> ex.Expression:
        if isinstance(e, ex.Unary) and e.operator == "not" and whole(e.operand):
            return ex.Function("bit-not", (e.operand,))
        if isinstance(e, ex.Logic) and whole(e.first) and all(whole(one) for _, one in e.rest):
            value = e.first
            for word, right in e.rest:
                value = ex.Binary(word, value, right)
            return value
        return e

    return [mapped(one, change) for one in body]
