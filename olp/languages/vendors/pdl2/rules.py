"""Lowers one PDL2 instruction: one short method per rule of grammars/pdl2.lark."""

from __future__ import annotations

from dataclasses import replace
from typing import Any, Final, NamedTuple, cast

from lark import Token

from olp.core.units import mm, ms, percent
from olp.ir.expressions import (
    Binary,
    CallValue,
    Compare,
    Expression,
    Function,
    Item,
    Member,
    Named,
    Number,
    PositionLiteral,
    Quantity,
    RecordLiteral,
    Signal,
    SystemValue,
    Text,
    Unary,
)
from olp.ir.program import (
    Acceleration,
    AccelerationUnit,
    Assign,
    Blend,
    BlendKind,
    Break,
    Call,
    Case,
    Default,
    Dwell,
    EndSwitch,
    For,
    Jump,
    Label,
    Message,
    Move,
    Path,
    PulseOutput,
    Repeat,
    Return,
    SetAcceleration,
    SetBlend,
    SetFrame,
    SetOutput,
    SetOverride,
    SetSpeed,
    SetTool,
    Speed,
    SpeedUnit,
    StartTask,
    Switch,
)
from olp.languages.lark_host import BrokenLineError
from olp.languages.short_reader import NotModelledError, constants, zyz_pose
from olp.languages.statement_rules import BlockRules

_EXACT: Final = Blend(BlendKind.RADIUS, Quantity(Number(0), mm))
_FULL: Final = Speed(SpeedUnit.FRACTION, Quantity(Number(100), percent))
_BUSES: Final = {
    "$DIN": "in", "$DOUT": "out", "$IN": "in", "$OUT": "out", "$GIN": "in-group", "$GOUT": "out-group",
    "$AIN": "analog-in", "$AOUT": "analog-out", "$FDIN": "robot-in", "$FDOUT": "robot-out", "$BIT": "flag",
}  # fmt: skip
_FUNCTIONS: Final[dict[str, str]] = {
    "SQRT": "sqrt", "ABS": "abs", "SIN": "sin", "COS": "cos", "TAN": "tan", "ATAN2": "atan2", "ROUND": "round",
    "TRUNC": "trunc", "EXP": "exp", "LN": "log", "POS_INV": "pose-inverse", "STR_LEN": "length-of-text",
}  # fmt: skip
_HERE: Final = SystemValue("current-pose")
_CURRENT: Final[dict[str, Expression]] = {"ARM_POS": _HERE, "ARM_JNTP": SystemValue("current-joints")}
_SCREENS: Final = ("LUN_CRT", "LUN_TP")
_OVERRIDES: Final = ("$ARM_SPD_OVR", "$PROG_SPD_OVR", "$ARM_OVR", "$GEN_OVR")
_RATES: Final = ("$ARM_ACC_OVR", "$PROG_ACC_OVR")


class MoveType(NamedTuple):
    """$MOVE_TYPE: the path of moves that name none."""

    path: Path


class Untyped(NamedTuple):
    """A move that names no path."""

    move: Move


class Pdl2Rules(BlockRules):
    """All of PDL2. `fly_distance`: the program sets $FLY_DIST, so that MOVEFLY goes by it."""

    def __init__(self, fly_distance: bool) -> None:
        super().__init__()
        self.fly_distance = self.settled_by = fly_distance

    # --- values -----------------------------------------------------------------------------------------

    def value(self, children: list[Any]) -> Expression:
        return self.conjunction(children)

    def sum(self, children: list[Any]) -> Expression:
        """Vectors are not computed with: what one means in the frame of a position is not known here."""
        if len(children) > 1 and any(isinstance(one, RecordLiteral) for one in children):
            raise NotModelledError(children)
        return super().sum(children)

    def equal(self, children: list[Expression]) -> Compare:
        return Compare("=", *children)

    def text(self, children: list[Token]) -> Text:
        return Text(str(children[0])[1:-1].replace("''", "'"))

    def composed(self, children: list[Expression]) -> Expression:
        value = children[0]
        for right in children[1:]:
            value = Function("pose-product", (value, right))
        return value

    def name(self, children: list[Any]) -> Expression:
        word = str(children[0])
        return _CURRENT.get(word.upper()) or Named(self.spelled(word))

    def system(self, children: list[Any]) -> Expression:
        return Named(str(children[0]).upper())

    def item(self, children: list[Any]) -> Expression:
        word, indices = str(children[0]), tuple(children[1])
        if word.upper() in _BUSES and len(indices) == 1:
            return Signal(_BUSES[word.upper()], indices[0])
        if word.upper() == "$TIMER" and len(indices) == 1 and isinstance(indices[0], Number):
            return Binary("*", SystemValue("timer", int(indices[0].value)), Number(1000))
        return Item(Named(word.upper() if word[0] == "$" else self.spelled(word)), indices)

    def member(self, children: list[Any]) -> Expression:
        return Member(children[0], str(children[1]).lower())

    def member_item(self, children: list[Any]) -> Expression:
        return Item(self.member(children[:2]), tuple(children[2]))

    def function(self, children: list[Any]) -> Expression:
        name, arguments = str(children[0]), tuple(children[1] or ())
        word = name.upper()
        if word == "POS":
            return _pose(arguments)
        if word == "VEC":
            return RecordLiteral("vector", tuple(zip("xyz", arguments, strict=False)))
        if word in _CURRENT:
            return _CURRENT[word]
        if word in _FUNCTIONS:
            return Function(_FUNCTIONS[word], arguments)
        return CallValue(self.spelled(name), arguments)

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

    def setting(self, children: list[Any]) -> tuple[Expression, Expression | None]:
        return children[0], children[1]

    def with_(self, children: list[Any]) -> tuple[str, Any]:
        return "with", children[-1]

    def move(self, children: list[Any]) -> Any:
        word, _, path, _, target, *tails = children
        return self._move(str(word), path, target, tails)

    def near(self, children: list[Any]) -> Any:
        word, _, path, target, distance, *tails = children
        return self._move(str(word), path, _back(target, distance), tails)

    def away(self, children: list[Any]) -> Any:
        word, _, path, distance, *tails = children
        return self._move(str(word), path, _back(_HERE, distance), tails)

    def relative(self, children: list[Any]) -> Any:
        word, _, path, vector, frame, *tails = children
        if not isinstance(vector, RecordLiteral) or len(vector.members) != 3:
            raise NotModelledError(vector)
        way = tuple(value for _, value in vector.members)
        place = frame.name.upper() if isinstance(frame, Named) else "TOOL"
        if place == "TOOL":
            target = Function("pose-relative-tool", (_HERE, *way, Number(0), Number(0), Number(0)))
        elif place == "UFRAME":
            target = Function("pose-offset", (_HERE, *way))
        else:
            raise NotModelledError(frame)
        return self._move(str(word), path, target, tails)

    def _move(self, word: str, path: Token | None, target: Expression, tails: list[Any]) -> Any:
        fields: dict[str, Any] = {}
        other: list[tuple[str, Expression]] = []
        settings: list[tuple[Expression, Expression | None]] = []
        for name, value in tails:
            if name == "with":
                settings.append(value)
            elif name:
                fields[name] = value
        shape = Path.JOINT if path is None else Path(str(path).lower())
        if "via" in fields:
            shape = Path.CIRCULAR
        elif shape is Path.CIRCULAR:
            raise BrokenLineError("an arc without a point on it", wanted="VIA and a position")
        fly = word.upper() == "MOVEFLY"
        blend = (
            (Blend(BlendKind.RADIUS) if self.fly_distance else Blend(BlendKind.CONTINUOUS)) if fly else _EXACT
        )
        move = Move(0, shape, (target,), _FULL if shape is Path.JOINT else None, blend, **fields)
        for key, value in settings:
            move = self._with(move, key, value, other, fly)
        move = replace(move, other=tuple(other))
        return move if path is not None or move.via is not None else Untyped(move)

    def _with(
        self, move: Move, key: Expression, value: Expression | None, other: list[Any], fly: bool
    ) -> Move:
        """The move with one of its own settings, or with a condition that holds during it."""
        word = key.name if isinstance(key, Named) else ""
        if value is None:
            other.append(("condition", key))
            return move
        if word == "$LIN_SPD":
            return move if move.path is Path.JOINT else replace(move, speed=_travel(value))
        if word in _OVERRIDES and move.path is Path.JOINT:
            return replace(move, speed=Speed(SpeedUnit.FRACTION, Quantity(value, percent)))
        if word == "$ROT_SPD":
            return replace(move, turn=Quantity(value, 1.0))
        if word == "$FLY_DIST" and fly:
            return replace(move, blend=Blend(BlendKind.RADIUS, Quantity(value, mm)))
        if word == "$TOOL":
            return replace(move, tool=value)
        if word == "$UFRAME":
            return replace(move, frame=value)
        if word in _RATES:
            return replace(move, acceleration=Quantity(value, percent))
        other.append((word or "setting", value))
        return move

    # --- assignments -----------------------------------------------------------------------------------

    def assign(self, children: list[Any]) -> Any:
        target, value = children
        if isinstance(target, Signal):
            return SetOutput(0, target, value)
        if isinstance(target, Binary):  # a timer, in ms
            return Assign(0, target.left, Binary("/", value, Number(1000)))
        if isinstance(target, Named) and target.name[0] == "$":
            return self._system(target.name, target, value)
        if not isinstance(target, (Named, Item, Member)):
            raise BrokenLineError("nothing can be stored here", wanted="a variable or a port")
        return Assign(0, target, value)

    def update(self, children: list[Any]) -> Any:
        target, word, value = children
        return self.assign([target, Binary(str(word)[0], target, value)])

    def _system(self, word: str, target: Named, value: Expression) -> Any:
        if word == "$TOOL":
            return SetTool(0, value)
        if word == "$UFRAME":
            return SetFrame(0, value)
        if word == "$LIN_SPD":
            return SetSpeed(0, (_travel(value),))
        if word == "$ROT_SPD":
            return SetSpeed(0, (), turn=Quantity(value, 1.0))
        if word in _OVERRIDES:
            return SetOverride(0, Quantity(value, percent))
        if word in _RATES:
            return SetAcceleration(0, (Acceleration(AccelerationUnit.FRACTION, Quantity(value, percent)),))
        if word == "$FLY_DIST":
            return SetBlend(0, (Blend(BlendKind.RADIUS, Quantity(value, mm)),))
        if word == "$MOVE_TYPE" and isinstance(value, Named) and value.name.upper() in ("JOINT", "LINEAR"):
            return MoveType(Path(value.name.lower()))
        raise NotModelledError(target)

    # --- everything else ----------------------------------------------------------------------------------

    def delay(self, children: list[Any]) -> Dwell:
        return Dwell(0, Quantity(children[0], ms))

    def written(self, children: list[Any]) -> Expression:
        """A value that WRITE shows, with so many decimals; how wide is left to the target."""
        value, _, *decimals = children
        return Function("text-of-value", (value, *decimals)) if decimals else cast(Expression, value)

    def write(self, children: list[Any]) -> list[Message]:
        """What the pendant or the screen shows: a message for each of its lines; into a file, it is not modelled."""
        place, *items = children
        if place is not None and not (isinstance(place, Named) and place.name.upper() in _SCREENS):
            raise NotModelledError(place)
        lines: list[list[Expression]] = [[]]
        for item in items:
            if isinstance(item, Named) and item.name.upper() == "NL":
                lines.append([])
            else:
                lines[-1].append(item)
        return [Message(0, _shown(line)) for line in lines if line] or [Message(0, Text(""))]

    def pulse(self, children: list[Any]) -> list[PulseOutput | Dwell]:
        """Without ADVANCE the program waits until the pulse has ended."""
        return [self.pulse_on(children), Dwell(0, Quantity(children[1], ms))]

    def pulse_on(self, children: list[Any]) -> PulseOutput:
        if not isinstance(children[0], Signal):
            raise BrokenLineError("a pulse on what is no port", wanted="PULSE $DOUT[1] FOR 500")
        return PulseOutput(0, children[0], Quantity(children[1], ms))

    def for_(self, children: list[Any]) -> For:
        variable, start, direction, stop, step = children
        if not isinstance(variable, Named):
            raise BrokenLineError(
                "a loop that counts in an array", wanted="a variable, as in FOR i := 1 TO 3 DO"
            )
        if str(direction).upper() == "DOWNTO":
            step = Number(-1) if step is None else Unary("-", step)
        return For(0, variable, start, stop, step)

    def repeat(self, _: list[Any]) -> Repeat:
        return Repeat(0)

    def select(self, children: list[Any]) -> Switch:
        return Switch(0, children[0])

    def case(self, children: list[Any]) -> Case:
        return Case(0, tuple(children[0]))

    def otherwise(self, _: list[Any]) -> Default:
        return Default(0)

    def end_select(self, _: list[Any]) -> EndSwitch:
        return EndSwitch(0)

    def goto(self, children: list[Any]) -> Jump:
        return Jump(0, str(children[0]).casefold())

    def label(self, children: list[Any]) -> Label:
        return Label(0, str(children[0]).casefold())

    def return_(self, children: list[Any]) -> Return:
        return Return(0, children[0])

    def break_(self, _: list[Any]) -> Break:
        return Break(0)

    def activate(self, children: list[Any]) -> StartTask:
        return StartTask(0, self.spelled(str(children[0])), str(children[0]))

    def call(self, children: list[Any]) -> Call:
        return Call(0, self.spelled(str(children[0])), tuple(children[1] or ()))


def _travel(value: Expression) -> Speed:
    return Speed(SpeedUnit.TRAVEL, Quantity(value, 1.0))


def _pose(values: tuple[Expression, ...]) -> Expression:
    """POS(x, y, z, a, e, r, 'flags'); values that are left out at the end are 0, as in POS(0)."""
    flags = values[-1].value if values and isinstance(values[-1], Text) else ""
    given = values[:-1] if values and isinstance(values[-1], Text) else values
    if not given or len(given) > 6:
        raise BrokenLineError(f"a position with {len(given)} values", wanted="POS(x, y, z, a, e, r, 'flags')")
    values = (*given, *[Number(0)] * (6 - len(given)))
    numbers = constants(values)
    if numbers is not None:
        return zyz_pose(numbers, (("CNFG", flags),) if flags else ())
    x, y, z, a, e, r = values
    zero = Number(0)
    tilted = Function("pose-angles", (x, y, z, zero, e, a))  # Rz(a) Ry(e)
    return Function("pose-product", (tilted, Function("pose-angles", (*(zero,) * 5, r))))


def _shown(items: list[Expression]) -> Expression:
    """A line of what WRITE shows, its values as texts."""
    parts = tuple(one if _is_shown(one) else Function("text-of-value", (one,)) for one in items)
    return parts[0] if len(parts) == 1 else Function("joined-text", parts)


def _is_shown(e: Expression) -> bool:
    return isinstance(e, Text) or (isinstance(e, Function) and e.name == "text-of-value")


def _back(start: Expression, distance: Expression) -> Expression:
    """`distance` [mm] back along the tool's z."""
    back = Number(-distance.value) if isinstance(distance, Number) else Unary("-", distance)
    if isinstance(start, PositionLiteral) and start.kind == "joint":
        start = Function("forward", (start,))
    zero = Number(0)
    return Function("pose-relative-tool", (start, zero, zero, back, zero, zero, zero))
