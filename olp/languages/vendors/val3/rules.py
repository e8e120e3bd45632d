"""Lowers one VAL3 instruction: one short method per rule of grammars/val3.lark."""

from __future__ import annotations

import re
from typing import Any, Final, NamedTuple

from olp.core.units import deg, mm, percent
from olp.ir.expressions import (
    Binary,
    CallValue,
    Compare,
    Expression,
    FrameRef,
    Function,
    Item,
    Member,
    Named,
    Number,
    PositionLiteral,
    Quantity,
    Signal,
    SignalState,
    SystemValue,
    Text,
    Unary,
)
from olp.ir.program import (
    Assign,
    Blend,
    BlendKind,
    Call,
    Case,
    Default,
    Dwell,
    EndSwitch,
    For,
    If,
    Message,
    Move,
    Path,
    SetOutput,
    SetOverride,
    Speed,
    SpeedUnit,
    StartTask,
    Switch,
    Wait,
)
from olp.languages.lark_host import BrokenLineError
from olp.languages.short_reader import NotModelledError, constants, from_zero, joints, xyz_pose
from olp.languages.statement_rules import BlockRules
from olp.languages.vendors.val3.data import JOINTS, MIXED, POSES, SIGNALS, WORLD, Val3Declarations, named

_PATHS: Final = {"movej": Path.JOINT, "movel": Path.LINEAR, "movec": Path.CIRCULAR}
_FUNCTIONS: Final = {
    "sqrt": "sqrt", "abs": "abs", "sin": "sin", "cos": "cos", "tan": "tan", "asin": "asin", "acos": "acos",
    "atan": "atan", "round": "round", "roundUp": "ceil", "roundDown": "floor", "min": "min", "max": "max",
    "power": "power", "exp": "exp", "ln": "log", "distance": "pose-distance", "len": "length-of-text",
}  # fmt: skip
_WORDS: Final[dict[str, Expression]] = {"off": Number(0), "joint": Number(1), "cartesian": Number(1)}
_MESSAGES: Final = frozenset(("popUpMsg", "logMsg", "put", "putln"))
_STOPS: Final = frozenset(("waitEndMove", "open", "close", "stopMove", "restartMove"))
_TIMED_OUT: Final = SystemValue("timed-out")
_POSE_FUNCTIONS: Final = frozenset(("pose-product", "pose-inverse", "pose-angles", "forward"))


class Leave(NamedTuple):
    """break: leaves a loop, or ends a case."""


class Val3Rules(BlockRules):
    """All of VAL3. `known`: what is known of names; indices count from 0 there, from 1 here."""

    def __init__(self, known: Val3Declarations) -> None:
        super().__init__(fold=False)
        self.known = known
        self.frameless = False  # a move went to a point of which nobody says the frame

    # --- values -----------------------------------------------------------------------------------------

    def text(self, children: list[Any]) -> Text:
        return Text(re.sub(r"\\(.)", r"\1", str(children[0])[1:-1]))

    def value(self, children: list[Any]) -> Expression:
        return self.conjunction(children)

    def name(self, children: list[Any]) -> Expression:
        word = str(children[0])
        if word in _WORDS and word not in self.known.types:
            return _WORDS[word]
        if word == "flange" and word not in self.known.types:
            return FrameRef("tool", Number(0))
        if word == "world" and word not in self.known.types:
            return FrameRef("base")
        if self.known.types.get(word) in SIGNALS:
            return self._signal(word)
        return Item(Named(word), (Number(1),)) if word in self.known.arrays else Named(word)

    def item(self, children: list[Any]) -> Expression:
        word, indices = str(children[0]), children[1]
        zero = indices == [Number(0)]
        if zero and word not in self.known.arrays:
            return self.name(children[:1])
        if self.known.types.get(word) in SIGNALS:
            raise NotModelledError(word)
        return Item(Named(word), tuple(map(from_zero, indices)))

    def _signal(self, word: str) -> Signal:
        return Signal("analog-in" if self.known.types[word] == "aio" else "in", Text(word))

    def member(self, children: list[Any]) -> Expression:
        base, name = children[0], str(children[1])
        return base if name == "trsf" else Member(base, name)

    def member_item(self, children: list[Any]) -> Expression:
        base, name, indices = children
        return Item(Member(base, str(name)), tuple(map(from_zero, indices)))

    def braces(self, children: list[Expression]) -> Expression:
        if len(children) in (3, 8):
            raise NotModelledError(children)  # a configuration, a motion descriptor
        if len(children) != 6:
            raise BrokenLineError(
                f"{len(children)} values in braces", wanted="six: x, y, z, rx, ry, rz, or six joint values"
            )
        numbers = constants(children)
        if numbers is not None:
            return xyz_pose(numbers, tuple((f"j{n}", repr(v)) for n, v in enumerate(numbers, 1)))
        x, y, z, rx, ry, rz = children
        zero = Number(0)
        value: Expression = Function("pose-angles", (x, y, z, rx, zero, zero))
        for turn in ((zero, ry, zero), (zero, zero, rz)):
            value = Function("pose-product", (value, Function("pose-angles", (zero, zero, zero, *turn))))
        return value

    def not_(self, children: list[Any]) -> Any:
        if self._is_pose(children[0]):
            return Function("pose-inverse", (children[0],))
        return Unary("not", children[0])

    def product(self, children: list[Any]) -> Expression:
        value: Expression = children[0]
        for word, right in zip(children[1::2], children[2::2], strict=True):
            if word == "*" and (self._is_pose(value) or self._is_pose(right)):
                value = Function("pose-product", (value, right))
            else:
                value = Binary("mod" if word == "%" else str(word), value, right)
        return value

    def _type(self, value: Expression) -> str:
        base = value.base if isinstance(value, Item) else value
        return self.known.types.get(base.name, "") if isinstance(base, Named) else ""

    def _is_pose(self, value: Expression) -> bool:
        if isinstance(value, Function):
            return value.name in _POSE_FUNCTIONS
        return isinstance(value, PositionLiteral) or self._type(value) in POSES

    def function(self, children: list[Any]) -> Any:
        name, arguments = str(children[0]), tuple(children[1] or ())
        if name in ("dioGet", "aioGet") and len(arguments) == 1:
            return self._port(name, arguments[0], "in")
        if name == "appro" and len(arguments) == 2:
            return Function("pose-product", arguments)
        if name == "here":
            return SystemValue("current-pose")
        if name == "herej":
            return SystemValue("current-joints")
        if name == "jointToPoint" and len(arguments) == 3:
            return Function("forward", arguments[2:])
        return Function(_FUNCTIONS[name], arguments) if name in _FUNCTIONS else CallValue(name, arguments)

    def _port(self, name: str, value: Expression, direction: str) -> Signal:
        bus = f"analog-{direction}" if name.startswith("aio") else direction
        if isinstance(value, Signal):
            return Signal(bus, value.index)
        if not isinstance(value, Named):
            raise NotModelledError(value)
        return Signal(bus, Text(value.name))

    # --- moves ------------------------------------------------------------------------------------------

    def _move(self, name: str, arguments: tuple[Expression, ...]) -> Move:
        count = 4 if name == "movec" else 3
        if len(arguments) != count:
            wanted = "via, end" if count == 4 else "target"
            raise BrokenLineError(
                f"{name} with {len(arguments)} arguments", wanted=f"{wanted}, tool and mdesc"
            )
        *points, tool, mdesc = arguments
        path = _PATHS[name]
        if path is Path.JOINT:
            points[-1] = _as_joints(points[-1])
            speed = Speed(SpeedUnit.FRACTION, Quantity(Member(mdesc, "vel"), percent))
        else:
            speed = Speed(SpeedUnit.TRAVEL, Quantity(Member(mdesc, "tmax"), mm))
        corner = Binary("*", Member(mdesc, "blend"), Member(mdesc, "leave"))
        return Move(
            0,
            path,
            (points[-1],),
            speed,
            Blend(BlendKind.RADIUS, Quantity(corner, mm)),
            acceleration=Quantity(Member(mdesc, "accel"), percent),
            deceleration=Quantity(Member(mdesc, "decel"), percent),
            via=points[0] if count == 4 else None,
            turn=None if path is Path.JOINT else Quantity(Member(mdesc, "rmax"), deg),
            tool=tool,
            frame=self._frame(points[-1]),
        )

    def _father(self, point: Expression) -> str:
        """The frame of a point: that of its data, or of the point that it was made from; empty where nobody says."""
        while isinstance(point, Function) and point.arguments:
            point = point.arguments[0]
        if isinstance(point, Item) and isinstance(point.base, Named):
            name, index = point.base.name, point.indices[0]
            if isinstance(index, Number) and (own := self.known.fathers.get(f"{name}[{index.value - 1}]")):
                return own
            return self.known.fathers.get(name, "")
        return self.known.fathers.get(point.name, "") if isinstance(point, Named) else ""

    def _frame(self, point: Expression) -> Expression:
        if isinstance(point, Function) and point.name == "forward":
            return FrameRef("base")
        if isinstance(point, PositionLiteral) or self._type(point) in JOINTS:
            return FrameRef("base")
        father = self._father(point)
        if father == MIXED:
            raise NotModelledError(father)
        if not father and not isinstance(point, SystemValue):
            self.frameless = True
        return FrameRef("base") if father in ("", WORLD) else named(father)

    # --- instructions -----------------------------------------------------------------------------------

    def assign(self, children: list[Any]) -> Any:
        target, value = children
        if isinstance(value, CallValue) and value.routine in _PATHS:
            return self._move(value.routine, value.arguments)
        if wait := _watched(value):
            return [wait, Assign(0, target, Unary("not", _TIMED_OUT))]
        if isinstance(target, Signal):
            bus = target.bus.replace("in", "out")
            return SetOutput(
                0,
                Signal(bus, target.index),
                Number(int(value.on)) if isinstance(value, SignalState) else value,
            )
        if not isinstance(target, (Named, Item, Member)):
            raise BrokenLineError("nothing can be stored here", wanted="a variable")
        kind = self._type(target)
        if kind in JOINTS:
            value = _as_joints(value)
        if isinstance(target, Named) and kind.startswith("point"):
            self._inherit(target.name, value)
        return Assign(0, target, value)

    def _inherit(self, name: str, value: Expression) -> None:
        if father := self._father(value):
            self.known.fathers[name] = father

    def call(self, children: list[Any]) -> Call:
        return Call(0, str(children[0]), tuple(children[1] or ()))

    def task(self, children: list[Any]) -> StartTask:
        task = children[0].value if isinstance(children[0], Text) else ""
        return StartTask(0, str(children[-2]), task)

    def builtin(self, children: list[Any]) -> Any:
        name, arguments = str(children[0]), tuple(children[1] or ())
        if name in _PATHS:
            return self._move(name, arguments)
        if name == "delay" and len(arguments) == 1:
            return Dwell(0, Quantity(arguments[0], 1.0))
        if name in ("wait", "watch") and arguments:
            return Wait(0, arguments[0], Quantity(arguments[1], 1.0) if len(arguments) > 1 else None)
        if name in _STOPS:
            return Dwell(0, Quantity(Number(0), 1.0))
        if name in _MESSAGES:
            return Message(0, arguments[-1] if arguments else Text(""))
        if name in ("dioSet", "aioSet") and len(arguments) == 2:
            return SetOutput(0, self._port(name, arguments[0], "out"), arguments[1])
        if name == "setMonitorSpeed" and len(arguments) == 1:
            return SetOverride(0, Quantity(arguments[0], percent))
        raise NotModelledError(name)

    def if_(self, children: list[Any]) -> Any:
        """Before one that watches for a signal, the wait."""
        value, wanted = _wanted(children[0])
        if wait := _watched(value):
            return [wait, If(0, Unary("not", _TIMED_OUT) if wanted else _TIMED_OUT)]
        return If(0, children[0])

    def for_(self, children: list[Any]) -> For:
        variable, start, stop, step = children
        if not isinstance(variable, Named):
            raise BrokenLineError("a loop that counts in an array", wanted="a variable, as in for i=1 to 3")
        return For(0, variable, start, stop, step)

    def switch(self, children: list[Any]) -> Switch:
        return Switch(0, children[0])

    def case(self, children: list[Any]) -> Case:
        return Case(0, tuple(children[0]))

    def default(self, _: list[Any]) -> Default:
        return Default(0)

    def end_switch(self, _: list[Any]) -> EndSwitch:
        return EndSwitch(0)

    def break_(self, _: list[Any]) -> Leave:
        return Leave()


def _as_joints(value: Expression) -> Expression:
    """Six numbers in braces where joint values are wanted: degrees of the axes, and no pose."""
    if isinstance(value, PositionLiteral) and value.native[:1] and value.native[0][0] == "j1":
        return joints(float(v) for _, v in value.native)
    return value


def _wanted(value: Expression) -> tuple[Expression, bool]:
    """x of `x`, `x==true`, `!x` and `x==false`, and whether it is wanted true."""
    if isinstance(value, Unary) and value.operator == "not":
        return value.operand, False
    if isinstance(value, Compare) and value.operator == "=" and isinstance(value.right, SignalState):
        return value.left, value.right.on
    return value, True


def _watched(value: Expression) -> Wait | None:
    """watch(condition, time): waits, and says whether the condition came."""
    if isinstance(value, CallValue) and value.routine == "watch" and len(value.arguments) == 2:
        return Wait(0, value.arguments[0], Quantity(value.arguments[1], 1.0))
    return None
