"""What inline forms execute: the rules of the public bas.src, resolved with the motion data of the lists.

An inline form sets PDAT_ACT, LDAT_ACT and FDAT_ACT and calls BAS; a spline form names the same data in its WITH list.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Final

from olp.core.units import deg, mm, percent
from olp.ir.expressions import (
    Expression,
    FrameRef,
    Item,
    Member,
    Named,
    Number,
    Quantity,
    RecordLiteral,
    SystemValue,
    Text,
    Unknown,
)
from olp.ir.statements import (
    Acceleration,
    AccelerationUnit,
    Assign,
    Blend,
    BlendKind,
    ExternalTool,
    Path,
    SetAcceleration,
    SetBlend,
    SetFrame,
    SetSpeed,
    SetTool,
    Speed,
    SpeedUnit,
    Statement,
)
from olp.ir.transformer import note_names
from olp.languages.vendors.krl import values
from olp.languages.vendors.krl.scope import Scope

ACTUAL: Final = ("PDAT_ACT", "LDAT_ACT", "FDAT_ACT")
_MOST_SHARE = 100  # [%] of half the way
# Motion data of a form that nobody has changed, as PDEFAULT and LDEFAULT of the public $config.dat have them.
_AS_CREATED: Final = {
    ("PDAT_ACT", "VEL"): 100,
    ("PDAT_ACT", "ACC"): 100,
    ("PDAT_ACT", "APO_DIST"): 100,
    ("LDAT_ACT", "VEL"): 2,
    ("LDAT_ACT", "ACC"): 100,
    ("LDAT_ACT", "APO_DIST"): 100,
}


def joint_speed(value: Expression) -> SetSpeed:
    """`value` [%] of $VEL_AXIS."""
    return SetSpeed(0, (Speed(SpeedUnit.FRACTION, Quantity(value, percent)),))


def path_speed(value: Expression) -> SetSpeed:
    """`value` [m/s] of $VEL.CP."""
    return SetSpeed(0, (Speed(SpeedUnit.TRAVEL, Quantity(value, 1.0)),))


def joint_acceleration(value: Expression, scale: float) -> SetAcceleration:
    return SetAcceleration(0, (Acceleration(AccelerationUnit.FRACTION, Quantity(value, scale)),), Path.JOINT)


def path_acceleration(value: Expression, scale: float) -> SetAcceleration:
    return SetAcceleration(0, (Acceleration(AccelerationUnit.TRAVEL, Quantity(value, scale)),))


# What the public $config.dat gives as defaults.
INITIAL: Final[tuple[Statement, ...]] = (
    joint_acceleration(Number(100), values.ACC_PTP),
    joint_speed(Number(100)),
    path_acceleration(Number(100), values.ACC_CP),
    path_speed(Number(2)),
    SetSpeed(0, (), turn=Quantity(Number(200), deg)),
    SetBlend(0, (Blend(BlendKind.SHARE, Quantity(Number(50), percent)),)),
    SetBlend(0, (Blend(BlendKind.RADIUS, Quantity(Number(3), mm)),)),
    SetBlend(0, (Blend(BlendKind.SPEED, Quantity(Number(100), percent)),)),
    SetBlend(0, (Blend(BlendKind.TURN, Quantity(Number(5), deg)),)),
)


_TURNING: Final = Text("#VAR")


class MotionData:
    """Which motion data hold at a place of the text.

    `missing`: names that no list gives a value, since the last look. Those that nothing declares are as a form begins.
    """

    def __init__(self, scope: Scope) -> None:
        self.scope = scope
        self.missing: list[str] = []
        self.forget()

    def forget(self) -> None:
        """After a label or a branch nothing is known."""
        self._actual: dict[str, str | None] = dict.fromkeys(ACTUAL)
        self._parts: dict[tuple[str, str], Expression] = {}  # what members of these have been set to since
        self.external = False  # $IPO_MODE is #TCP
        self._orientation = _TURNING

    def assign(self, key: str, value: Expression) -> None:
        self._actual[key] = value.name if type(value) is Named else None
        self._parts = {part: one for part, one in self._parts.items() if part[0] != key}

    def assign_part(self, key: str, name: str, value: Expression) -> None:
        """`FDAT_ACT.TOOL_NO = …`; both in capitals."""
        self._parts[key, name] = value

    def changed(self, name: str) -> None:
        """A variable has another value: what was computed from it is not known any more."""
        for part, value in self._parts.items():
            names: set[str] = set()
            note_names(value, names)
            if name.casefold() in map(str.casefold, names):
                self._parts[part] = Member(Named(self.scope.spell(part[0])), self.scope.spell(part[1]))

    def member(self, record: str, name: str) -> Expression:
        """`record.name`: a constant of a list where one gives it, else the expression."""
        if (record, name) in self._parts:
            return self._parts[record, name]
        actual = self._actual.get(record)
        found = self.constant(actual or record, name)
        if found is not None:
            return found
        if actual and actual.upper() not in self.scope.values:
            self.missing.append(actual)
            if not self.scope.known(actual.upper()):
                created = _AS_CREATED.get((record, name))
                if created is not None:
                    return Number(created)
                record = actual  # what nobody sets holds the same as its copy
        return Member(Named(self.scope.spell(record)), self.scope.spell(name))

    def _word(self, record: str, name: str) -> Expression | None:
        """A member that is a constant of an enumeration, None where nothing tells it."""
        if (record, name) in self._parts:
            return self._parts[record, name]
        return self.constant(self._actual.get(record) or record, name)

    def constant(self, record: str, name: str) -> Expression | None:
        value = self.scope.values.get(record.upper())
        if isinstance(value, RecordLiteral):
            for member, found in value.members:
                if member.upper() == name and type(found) in (Number, Text):
                    return found
        return None

    # --- tools and frames -------------------------------------------------------------------------------

    def tool(self, value: Expression) -> Expression:
        """The value of $TOOL."""
        if value == values.NULL_FRAME:
            return FrameRef("tool", Number(0))
        return self.by_number(value, "TOOL_DATA", "tool")

    def frame(self, value: Expression) -> Expression:
        """The value of $BASE."""
        if value == values.NULL_FRAME:
            return FrameRef("base")
        if type(value) is Named and value.name.upper() == "$ROBROOT":
            return FrameRef("robot")
        return self.by_number(value, "BASE_DATA", "user")

    def by_number(self, value: Expression, array: str, kind: str) -> Expression:
        """TOOL_DATA[n] as it is where a list gives its value, else by its number."""
        if isinstance(value, Item) and type(value.base) is Named and value.base.name.upper() == array:
            listed = self.scope.values.get(array)
            if not (isinstance(listed, RecordLiteral) and _has(listed, value.indices[0])):
                return FrameRef(kind, value.indices[0])
        return value

    def numbered_tool(self, number: Expression) -> Expression:
        if type(number) is Number and number.value == 0:
            return FrameRef("tool", Number(0))
        return self.by_number(Item(Named(self.scope.spell("TOOL_DATA")), (number,)), "TOOL_DATA", "tool")

    def numbered_frame(self, number: Expression) -> Expression:
        if type(number) is Number and number.value == 0:
            return FrameRef("base")
        return self.by_number(Item(Named(self.scope.spell("BASE_DATA")), (number,)), "BASE_DATA", "user")

    # --- BAS --------------------------------------------------------------------------------------------

    def bas(self, command: str, argument: Expression) -> tuple[Statement, ...] | None:
        """What `BAS(#command, argument)` sets; None: nothing of motion."""
        found = _COMMANDS.get(command)
        return None if found is None else found(self, argument)

    def joint_data(self) -> tuple[Statement, ...]:
        """PTP_DAT."""
        acceleration = joint_acceleration(self.member("PDAT_ACT", "ACC"), values.ACC_PTP)
        return (acceleration, SetBlend(0, self.joint_blends("PDAT_ACT")))

    def joint_blends(self, record: str) -> tuple[Blend, ...]:
        distance = self.member(record, "APO_DIST")
        mode = self._word(record, "APO_MODE")
        if type(mode) is Text and mode.value.upper() == "#CDIS":
            return (Blend(BlendKind.RADIUS, Quantity(distance, mm)),)
        if type(distance) is Number:
            distance = Number(min(distance.value, _MOST_SHARE))
        return (Blend(BlendKind.SHARE, Quantity(distance, percent)),)

    def path_data(self) -> tuple[Statement, ...]:
        """CP_DAT."""
        acceleration = path_acceleration(self.member("LDAT_ACT", "ACC"), values.ACC_CP)
        blend = Blend(BlendKind.RADIUS, Quantity(self.member("LDAT_ACT", "APO_DIST"), mm))
        return (acceleration, SetBlend(0, (blend,)), *self.orientation())

    def orientation(self) -> tuple[Statement, ...]:
        """$ORI_TYPE, where it changes: with #CONSTANT the tool does not turn to where the point says."""
        kind = self._word("LDAT_ACT", "ORI_TYP")
        said = kind if type(kind) is Text and kind.value.upper() != "#VAR" else _TURNING
        if said == self._orientation:
            return ()
        self._orientation = said
        return (Assign(0, Named("$ORI_TYPE"), said),)

    def frames(self) -> tuple[Statement, ...]:
        """FRAMES."""
        tool = SetTool(0, self.numbered_tool(self.member("FDAT_ACT", "TOOL_NO")))
        frame = SetFrame(0, self.numbered_frame(self.member("FDAT_ACT", "BASE_NO")))
        mode = self._word("FDAT_ACT", "IPO_FRAME")
        external = type(mode) is Text and mode.value.upper() == "#TCP"
        return (tool, frame, *self.interpolation(external))

    def interpolation(self, external: bool) -> tuple[Statement, ...]:
        """$IPO_MODE, where it changes."""
        if external == self.external:
            return ()
        self.external = external
        return (external_tool(external),)


def external_tool(external: bool) -> ExternalTool:
    """With #TCP the tool stands in the room, at $BASE, and the arm holds the work."""
    return ExternalTool(0, SystemValue("current-frame") if external else None)


def _has(listed: RecordLiteral, index: Expression) -> bool:
    if type(index) is not Number:
        return True
    place = int(index.value) - 1
    return 0 <= place < len(listed.members) and type(listed.members[place][1]) is not Unknown


_COMMANDS: Final[dict[str, Callable[[MotionData, Expression], tuple[Statement, ...]]]] = {
    "INITMOV": lambda data, _: INITIAL,
    "VEL_PTP": lambda data, value: (joint_speed(value),),
    "ACC_PTP": lambda data, value: (joint_acceleration(value, values.ACC_PTP),),
    "VEL_CP": lambda data, value: (path_speed(value),),
    "ACC_CP": lambda data, value: (path_acceleration(value, values.ACC_CP),),
    "TOOL": lambda data, value: (SetTool(0, data.numbered_tool(value)),),
    "BASE": lambda data, value: (SetFrame(0, data.numbered_frame(value)),),
    "FRAMES": lambda data, _: data.frames(),
    "PTP_DAT": lambda data, _: (joint_speed(data.member("PDAT_ACT", "VEL")), *data.joint_data()),
    "CP_DAT": lambda data, _: (path_speed(data.member("LDAT_ACT", "VEL")), *data.path_data()),
    "PTP_PARAMS": lambda data, value: (*data.joint_data(), *data.frames(), joint_speed(value)),
    "CP_PARAMS": lambda data, value: (*data.path_data(), *data.frames(), path_speed(value)),
}
