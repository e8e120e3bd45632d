"""Lowers one AS instruction: one short method per rule of grammars/as.lark."""

from __future__ import annotations

import math
from collections.abc import Hashable, Sequence
from typing import Any, Final, NamedTuple

from lark import Token

from olp.core.units import deg, minute, mm, percent
from olp.ir import expressions as ex
from olp.ir import program as st
from olp.ir.transformer import expressions_of
from olp.languages.lark_host import BrokenLineError
from olp.languages.short_reader import NotModelledError, constants, from_zero, xyz_pose, zyz_pose
from olp.languages.statement_rules import BlockRules
from olp.languages.vendor import ENDS_CYCLE

FULL_SPEED: Final = 1.0  # [m/s] that 100 % of a path stand for: no program says it
MODAL: Final = st.Blend(st.BlendKind.RADIUS)
_PATHS: Final = {
    "J": st.Path.JOINT,
    "L": st.Path.LINEAR,
    "H": st.Path.LINEAR,
    "X": st.Path.LINEAR,
    "C": st.Path.CIRCULAR,
}
_UNITS: Final = {"MM/S": mm, "MM/SEC": mm, "CM/MIN": 0.01 / minute, "MM/MIN": mm / minute}
_FUNCTIONS: Final = {
    "SQRT": "sqrt", "ABS": "abs", "SIN": "sin", "COS": "cos", "TAN": "tan", "ATAN2": "atan2", "INT": "trunc",
    "MIN": "min", "MAX": "max", "$ENCODE": "text-of-value", "LEN": "length-of-text", "VAL": "value-of-text",
    "DISTANCE": "pose-distance",
}  # fmt: skip
_COORDINATES: Final = {"DX": "x", "DY": "y", "DZ": "z"}
_HERE: Final = ex.SystemValue("current-pose")
_HERE_AXES: Final = ex.SystemValue("current-joints")
HYBRID: Final = "HMOVE"  # the tool's point goes along a line, while the wrist turns axis by axis
_AXES: Final = 6
HOMES: Final = ("#HOME", "#HOME2")  # where HOME 1 and HOME 2 go


class BlockEnd(NamedTuple):
    """END: closes whatever block is open."""


class NextMoveFields(NamedTuple):
    """The fields that the next move takes, from SPEED, ACCURACY and ACCEL without ALWAYS.

    `always`: all that follow take them.
    """

    fields: tuple[tuple[str, Any], ...]
    always: bool = False


class ContinuousPath(NamedTuple):
    """CP: whether moves pass their targets, within the accuracy that holds, or stop there."""

    on: bool


class Arc(NamedTuple):
    """C1MOVE (`end` False) or C2MOVE, whose pair makes one arc."""

    target: ex.Expression
    end: bool


class BlockStep(NamedTuple):
    """A step as the pendant teaches it: a move and what is done at its end, with levels that the controller holds."""

    words: str
    target: ex.Expression


class PercentOfPath(NamedTuple):
    """Reported once per program: what a percentage means as the speed of a path."""


class AsRules(BlockRules):
    """All of AS. Indices count from 0 there, from 1 here."""

    settled_by: Hashable = True

    def __init__(self) -> None:
        super().__init__()
        self._enclosed: list[ex.Expression] = []  # values of this line that stand in brackets

    def enclosed(self, children: list[Any]) -> ex.Expression:
        value: ex.Expression = children[0]
        self._enclosed.append(value)
        return value

    def item(self, children: list[Any]) -> ex.Expression:
        return ex.Item(ex.Named(self.spelled(str(children[0]))), tuple(map(from_zero, children[1])))

    def name(self, children: list[Any]) -> ex.Expression:
        word = str(children[0]).upper()
        if word == "PI":
            return ex.Number(math.pi)
        if word in ("HERE", "#HERE"):
            return _HERE if word == "HERE" else _HERE_AXES
        return ex.Named(self.spelled(str(children[0]).replace("&", "")))

    # --- positions --------------------------------------------------------------------------------------

    def slot(self, children: list[Any]) -> ex.Expression:
        return ex.Number(0) if children[0] is None else children[0]

    def trans(self, children: list[ex.Expression]) -> ex.Expression:
        if len(children) > 6:
            raise BrokenLineError(f"a transformation with {len(children)} values", wanted="x, y, z, o, a, t")
        values = children + [ex.Number(0)] * (6 - len(children))
        numbers = constants(values)
        if numbers is not None:
            return zyz_pose(numbers)
        x, y, z, o, a, t = values
        zero = ex.Number(0)
        tilted = ex.Function("pose-angles", (x, y, z, zero, a, o))  # Rz(o) Ry(a)
        return ex.Function("pose-product", (tilted, ex.Function("pose-angles", (zero,) * 5 + (t,))))

    def ppoint(self, children: list[Any]) -> ex.Expression:
        return self.joints(children[0])

    def other_place(self, children: list[Any]) -> ex.Expression:
        """FRAME and its like, which compute a place from several others."""
        raise NotModelledError("it computes a place from several others")

    def turn_about(self, children: list[Any]) -> ex.Expression:
        """RX, RY, RZ: a turn about one axis, at the origin."""
        values: list[ex.Expression] = [ex.Number(0)] * 6
        values[3 + "XYZ".index(str(children[0])[1].upper())] = children[1]
        return ex.Function("pose-angles", tuple(values))

    def shift(self, children: list[ex.Expression]) -> ex.Expression:
        return ex.Function("pose-offset", (children[0], *_padded(children[1:], 3)))

    def here(self, _: list[Any]) -> ex.Expression:
        return _HERE

    def here_joints(self, _: list[Any]) -> ex.Expression:
        return _HERE_AXES

    def null(self, _: list[Any]) -> ex.Expression:
        return zyz_pose((0.0,) * 6)

    def inverse(self, children: list[Any]) -> ex.Expression:
        return ex.Function("pose-inverse", (children[1],))

    def compound(self, children: list[Any]) -> ex.Expression:
        sign, *rest = children
        if (len(rest) > 1 or sign is not None) and any(map(_has_axes, rest[::2])):
            raise NotModelledError("axis values are no transformation that + and - put together")
        value = rest[0] if sign is None else ex.Function("pose-inverse", (rest[0],))
        for word, right in zip(rest[1::2], rest[2::2], strict=True):
            right = ex.Function("pose-inverse", (right,)) if word == "-" else right
            value = ex.Function("pose-product", (value, right))
        return value

    # --- values -----------------------------------------------------------------------------------------

    def based(self, children: list[Token]) -> ex.Number:
        text = str(children[0])
        try:
            return ex.Number(int(text[2:], 16 if text[1] in "Hh" else 2))
        except ValueError:
            raise BrokenLineError(
                f"{text} is no number", wanted="^H with hexadecimal digits, ^B with 0 and 1"
            ) from None

    def function(self, children: list[Any]) -> ex.Expression:
        name, arguments = str(children[0]), tuple(children[1] or ())
        word = name.upper()
        if word == "SIG" and arguments:
            return _all_on(arguments)
        if word == "BITS" and len(arguments) == 2:
            group = _group(*arguments)
            return ex.CallValue(word, arguments) if group is None else group
        if word == "TIMER" and len(arguments) == 1 and isinstance(arguments[0], ex.Number):
            return ex.SystemValue("timer", int(arguments[0].value))
        if word in _FUNCTIONS:
            return ex.Function(_FUNCTIONS[word], arguments)
        places = (ex.Named, ex.Item, ex.SystemValue)
        if word in _COORDINATES and len(arguments) == 1 and isinstance(arguments[0], places):
            return ex.Member(arguments[0], _COORDINATES[word])
        return _of_text(word, arguments) or ex.CallValue(self.spelled(name), arguments)

    # --- moves ------------------------------------------------------------------------------------------

    def move(self, children: list[Any]) -> Any:
        word, target, clamp = str(children[0]).upper(), children[1], children[2]
        if word[0] == "C":
            return Arc(target, word[1] == "2")
        other: tuple[tuple[str, ex.Expression], ...] = () if clamp is None else (("clamp", clamp),)
        if word[0] == "H":
            other += ((HYBRID, ex.Number(1)),)
        return st.Move(0, _PATHS[word[0]], (target,), blend=MODAL, other=other)

    def move_till(self, children: list[Any]) -> st.Move:
        return st.Move(0, st.Path.LINEAR, (children[1],), blend=MODAL, until=children[2])

    def approach(self, children: list[Any]) -> st.Move:
        word, target, distance, _ = children
        return self._away(str(word), target, distance)

    def depart(self, children: list[Any]) -> st.Move:
        zero = ex.Number(0)
        return _from_before(_PATHS[str(children[0])[0].upper()], (zero, zero, _back(children[1])), "tool")

    def _away(self, word: str, start: ex.Expression, distance: ex.Expression) -> st.Move:
        """`distance` [mm] back along the tool's z from `start`."""
        zero = ex.Number(0)
        if _has_axes(start):
            start = ex.Function("forward", (start,))
        target = ex.Function("pose-relative-tool", (start, zero, zero, _back(distance), zero, zero, zero))
        return st.Move(0, _PATHS[word[0].upper()], (target,), blend=MODAL)

    def draw(self, children: list[Any]) -> st.Move:
        *values, speed = _padded(children[1:], 7)
        turns = sum(value != ex.Number(0) for value in values[3:])
        along_tool = str(children[0]).upper() != "DRAW"
        if speed != ex.Number(0):
            raise NotModelledError("it has a speed of its own")
        if turns and not along_tool:
            raise NotModelledError("it turns about the axes of the base")
        if turns > 1:  # about x first
            return st.Move(
                0, st.Path.LINEAR, (ex.Function("pose-relative-tool", (_HERE, *values)),), blend=MODAL
            )
        return _from_before(st.Path.LINEAR, values, "tool" if along_tool else "own")

    def drive(self, children: list[Any]) -> list[Any]:
        """One axis by so many degrees, with a share of its speed or that of other moves."""
        _, axis, by, share = children
        numbers = constants([axis, by])
        if numbers is None:
            raise NotModelledError("the axis, or how far it turns, is computed")
        if numbers[0] not in range(1, _AXES + 1):
            raise BrokenLineError(f"there is no axis {numbers[0]:g}", wanted=f"1 to {_AXES}")
        values = tuple(math.radians(numbers[1]) if n == numbers[0] else 0.0 for n in range(1, _AXES + 1))
        target = ex.PositionLiteral("joint", values)
        move = st.Move(0, st.Path.JOINT, (target,), blend=MODAL, relative=ex.FrameRef("own"))
        if share is None:
            return [move]
        speeds = (st.Speed(st.SpeedUnit.FRACTION, ex.Quantity(share, percent)),)
        return [NextMoveFields((("speeds", speeds),)), move]

    def home(self, children: list[Any]) -> st.Move:
        second = children[0] == ex.Number(2)
        return st.Move(0, st.Path.JOINT, (ex.Named(HOMES[second]),), blend=MODAL)

    def block_step(self, children: list[Any]) -> BlockStep:
        return BlockStep(str(children[0]), children[1])

    # --- what holds for the next move, or from here on ----------------------------------------------------

    def speed(self, children: list[Any]) -> Any:
        value, unit, turn, _, always = children
        word = "%" if unit is None else str(unit).upper()
        limit = None if turn is None else ex.Quantity(turn, deg)
        if word == "%":
            speeds: tuple[st.Speed, ...] = (
                st.Speed(st.SpeedUnit.FRACTION, ex.Quantity(value, percent)),
                st.Speed(st.SpeedUnit.TRAVEL, ex.Quantity(value, percent * FULL_SPEED), "%"),
            )
        elif word == "S":
            speeds = (st.Speed(st.SpeedUnit.TIME, ex.Quantity(value, 1.0)),)
        else:
            scale = _UNITS[word]
            speeds = (
                st.Speed(st.SpeedUnit.TRAVEL, ex.Quantity(value, scale)),
                st.Speed(st.SpeedUnit.FRACTION, ex.Quantity(value, scale / FULL_SPEED), word),
            )
        if always:
            return [st.SetSpeed(0, speeds, turn=limit), *([PercentOfPath()] if word != "S" else [])]
        return NextMoveFields((("speeds", speeds), ("turn", limit)))

    def accuracy(self, children: list[Any]) -> Any:
        blend = st.Blend(st.BlendKind.RADIUS, ex.Quantity(children[0], mm))
        return st.SetBlend(0, (blend,)) if children[1] else NextMoveFields((("blend", blend),))

    def rate(self, children: list[Any]) -> Any:
        word, value, _, always = children
        share = ex.Quantity(value, percent)
        if always and str(word).upper() == "ACCEL":
            return st.SetAcceleration(0, (st.Acceleration(st.AccelerationUnit.FRACTION, share),))
        part = "acceleration" if str(word).upper() == "ACCEL" else "deceleration"
        return NextMoveFields(((part, share),), bool(always))

    def rates(self, children: list[Any]) -> Any:
        return self.rate([children[0], self.number([children[1]]), None, None])

    def continuous(self, children: list[Any]) -> ContinuousPath:
        return ContinuousPath(str(children[0]).upper() == "ON")

    def tool(self, children: list[Any]) -> st.SetTool:
        return st.SetTool(0, children[0])

    def base(self, children: list[Any]) -> st.SetFrame:
        return st.SetFrame(0, children[0])

    # --- everything else ----------------------------------------------------------------------------------

    def break_(self, _: list[Any]) -> st.Dwell:
        return st.Dwell(0, ex.Quantity(ex.Number(0), 1.0))

    def dwell(self, children: list[Any]) -> st.Dwell:
        return st.Dwell(0, ex.Quantity(children[1], 1.0))

    def point(self, children: list[Any]) -> st.Assign:
        """A place from a place; where one is of axis values and the other is not, with the tool and base of now."""
        target, value = children
        if value in (_HERE, _HERE_AXES):
            return self.teach([target])
        if _has_axes(target) is not _has_axes(value):
            value = ex.Function("inverse" if _has_axes(target) else "forward", (value,))
        return st.Assign(0, target, value)

    def assign(self, children: list[Any]) -> st.Assign:
        return st.Assign(0, children[0], children[1])

    def teach(self, children: list[Any]) -> st.Assign:
        """A variable gets the place where the arm stands, in axis values where its name begins with #."""
        return st.Assign(0, children[0], _HERE_AXES if _has_axes(children[0]) else _HERE)

    def set_home(self, children: list[Any]) -> st.Assign:
        """The place that HOME, or HOME 2, goes to; the accuracy is that of the signal that the arm is there."""
        word, _, place = children
        place = _HERE_AXES if place == _HERE else place
        return st.Assign(0, ex.Named(HOMES["2" in word]), place)

    def set_timer(self, children: list[Any]) -> st.Assign:
        number, value = children
        if not isinstance(number, ex.Number):
            raise NotModelledError("it computes the number of its timer")
        return st.Assign(0, ex.SystemValue("timer", int(number.value)), value)

    def signed_numbers(self, children: list[Any]) -> list[Any]:
        return children

    def signal(self, children: list[Any]) -> list[Any]:
        pairs = map(_signal, children[0])
        return [st.SetOutput(0, signal, ex.SignalState(on)) for signal, on in pairs]

    def set_bits(self, children: list[Any]) -> st.SetOutput:
        group = _group(children[0], children[1])
        if group is None or group.bus != "out-group":
            raise NotModelledError("it sets signals that are no group of outputs")
        return st.SetOutput(0, group, children[2])

    def pulse(self, children: list[Any]) -> st.PulseOutput:
        time = ex.Number(0.2) if children[1] is None else children[1]
        signal, on = _signal(children[0])
        if not on:
            raise BrokenLineError(
                "a pulse of a signal that is off", wanted="a signal above 0, as in PULSE 7,0.5"
            )
        return st.PulseOutput(0, signal, ex.Quantity(time, 1.0))

    def wait_signals(self, children: list[Any]) -> st.Wait:
        return st.Wait(0, _all_on(children[0]), spelling="SWAIT")

    def halt(self, _: list[Any]) -> st.Process:
        return st.Process(0, "HALT")

    def stop(self, _: list[Any]) -> st.Process:
        """The cycle ends; the next one begins if any is left."""
        return st.Process(0, ENDS_CYCLE)

    def name_only(self, children: list[Any]) -> str:
        return self.spelled(str(children[0]))

    def call(self, children: list[Any]) -> st.Call:
        """A program changes the variables that it is handed: one in brackets is a copy, which nothing here says."""
        arguments = tuple(children[1] or ())
        enclosed, self._enclosed = self._enclosed, []
        for one in arguments:
            if isinstance(one, (ex.Named, ex.Item)) and any(one is other for other in enclosed):
                raise NotModelledError("it hands over a copy of a variable, which stands in brackets")
        return st.Call(0, children[0], arguments)

    def label(self, children: list[Any]) -> str:
        return str(children[0]).casefold()

    def goto(self, children: list[Any]) -> st.Jump:
        return st.Jump(0, children[0], children[1])

    def goto_if(self, children: list[Any]) -> st.Jump:
        return st.Jump(0, children[1], children[0])

    def for_(self, children: list[Any]) -> st.For:
        variable, start, stop, step = children
        if not isinstance(variable, ex.Named):
            raise BrokenLineError("a loop that counts in an array", wanted="a variable, as in FOR i = 1 TO 3")
        return st.For(0, variable, start, stop, step)

    def end(self, _: list[Any]) -> BlockEnd:
        return BlockEnd()

    def printed(self, children: list[Any]) -> ex.Expression:
        texts = tuple(one if _is_text(one) else ex.Function("text-of-value", (one,)) for one in children)
        return texts[0] if len(texts) == 1 else ex.Function("joined-text", texts)

    def message(self, children: list[Any]) -> st.Message:
        return st.Message(0, ex.Text("") if children[1] is None else children[1])


def _has_axes(place: ex.Expression) -> bool:
    """Whether a place is of axis values: the names of variables that hold such begin with #."""
    base = place.base if isinstance(place, ex.Item) else place
    if isinstance(base, ex.Named):
        return base.name.lstrip(".").startswith("#")
    if isinstance(base, ex.PositionLiteral):
        return base.kind == "joint"
    if isinstance(base, ex.SystemValue):
        return base == _HERE_AXES
    return isinstance(base, ex.Function) and base.name == "joints"


def _back(distance: ex.Expression) -> ex.Expression:
    return ex.Number(-distance.value) if isinstance(distance, ex.Number) else ex.Unary("-", distance)


def _from_before(path: st.Path, values: Sequence[ex.Expression], frame: str) -> st.Move:
    """A move by an offset [mm, deg] that counts from the target of the move before, however that one is passed."""
    values = _padded(list(values), 6)
    numbers = constants(values)
    offset = ex.Function("pose-angles", tuple(values)) if numbers is None else xyz_pose(numbers)
    return st.Move(0, path, (offset,), blend=MODAL, relative=ex.FrameRef(frame))


def _of_text(word: str, arguments: tuple[ex.Expression, ...]) -> ex.Expression | None:
    """A function of texts, whose characters are counted from 1."""
    one = ex.Number(1)
    if word == "$LEFT" and len(arguments) == 2:
        return ex.Function("part-of-text", (arguments[0], one, arguments[1]))
    if word == "$MID" and len(arguments) == 3:
        return ex.Function("part-of-text", arguments)
    if word == "INSTR" and len(arguments) in (2, 3):
        first = arguments[:-2] or (one,)
        return ex.Function("find-in-text", (arguments[-2], *first, arguments[-1]))
    if word == "$CHR" and len(arguments) == 1:
        return ex.Function("character-of-code", arguments)
    if word == "ASC" and len(arguments) in (1, 2):
        start = arguments[1] if len(arguments) == 2 else one
        text = arguments[0] if start == one else ex.Function("part-of-text", (arguments[0], start, one))
        return ex.Function("code-of-character", (text,))
    return None


def _padded(values: list[ex.Expression], count: int) -> tuple[ex.Expression, ...]:
    if len(values) > count:
        raise BrokenLineError(f"{len(values)} values", wanted=f"at most {count}")
    return (*values, *[ex.Number(0)] * (count - len(values)))


def _signal(number: ex.Expression) -> tuple[ex.Signal, bool]:
    """The signal, and whether it is wanted on: 1 .. outputs, 1001 .. inputs, 2001 .. internal; -n means off."""
    on = True
    if isinstance(number, ex.Unary) and number.operator == "-":
        number, on = number.operand, False
    elif isinstance(number, ex.Number) and number.value < 0:
        number, on = ex.Number(-number.value), False
    if any(isinstance(e, (ex.Compare, ex.Logic, ex.SignalState)) for e in expressions_of(number)):
        raise NotModelledError("it chooses a signal by what is true, which is -1 here, and switches that off")
    if isinstance(number, ex.Number):
        bus = bus_of(int(number.value))
        return ex.Signal(bus, ex.Number(number.value - FIRST_OF[bus])), on
    return ex.Signal("out", number), on


FIRST_OF: Final = {"out": 0, "in": 1000, "flag": 2000}  # the number before the first signal of a kind


def bus_of(number: int) -> str:
    """1 .. are outputs, 1001 .. inputs, 2001 .. internal signals."""
    return "out" if number <= 1000 else "in" if number <= 2000 else "flag"


def _group(first: ex.Expression, count: ex.Expression) -> ex.Signal | None:
    """The signals that BITS names, as a group of its own; None for internal ones and computed numbers."""
    if not isinstance(first, ex.Number) or not isinstance(count, ex.Number):
        return None
    start, last = int(first.value), int(first.value) + int(count.value) - 1
    bus = bus_of(start)
    if bus == "flag" or bus_of(last) != bus or not 1 <= start <= last < start + 32:
        return None
    here = FIRST_OF[bus]
    return ex.Signal(f"{bus}-group", ex.Text(f"BITS_{bus.upper()}_{start - here}_{last - here}"))


def _all_on(numbers: Any) -> ex.Expression:
    conditions: list[ex.Expression] = [
        signal if on else ex.Unary("not", signal) for signal, on in map(_signal, numbers)
    ]
    if len(conditions) == 1:
        return conditions[0]
    return ex.Logic(conditions[0], tuple(("and", one) for one in conditions[1:]))


def _is_text(e: ex.Expression) -> bool:
    """Whether a value is a text: the names of variables that hold one begin with $."""
    base = e.base if isinstance(e, ex.Item) else e
    return isinstance(base, ex.Text) or (isinstance(base, ex.Named) and base.name.startswith("$"))
