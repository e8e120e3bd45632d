"""What inline forms execute: the rules of the public bas.src, resolved with the motion data of the lists.

An inline form sets PDAT_ACT, LDAT_ACT and FDAT_ACT and calls BAS; a spline form names the same data in its WITH list.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Final

from olp.core.units import deg, mm, percent
from olp.ir import expressions as ex
from olp.ir import program as st
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


def joint_speed(value: ex.Expression) -> st.SetSpeed:
    """`value` [%] of $VEL_AXIS."""
    return st.SetSpeed(0, (st.Speed(st.SpeedUnit.FRACTION, ex.Quantity(value, percent)),))


def path_speed(value: ex.Expression) -> st.SetSpeed:
    """`value` [m/s] of $VEL.CP."""
    return st.SetSpeed(0, (st.Speed(st.SpeedUnit.TRAVEL, ex.Quantity(value, 1.0)),))


def joint_acceleration(value: ex.Expression, scale: float) -> st.SetAcceleration:
    return st.SetAcceleration(
        0, (st.Acceleration(st.AccelerationUnit.FRACTION, ex.Quantity(value, scale)),), st.Path.JOINT
    )


def path_acceleration(value: ex.Expression, scale: float) -> st.SetAcceleration:
    return st.SetAcceleration(0, (st.Acceleration(st.AccelerationUnit.TRAVEL, ex.Quantity(value, scale)),))


# What the public $config.dat gives as defaults.
_INITIAL: Final[tuple[st.Statement, ...]] = (
    joint_acceleration(ex.Number(100), values.ACC_PTP),
    joint_speed(ex.Number(100)),
    path_acceleration(ex.Number(100), values.ACC_CP),
    path_speed(ex.Number(2)),
    st.SetSpeed(0, (), turn=ex.Quantity(ex.Number(200), deg)),
    st.SetBlend(0, (st.Blend(st.BlendKind.SHARE, ex.Quantity(ex.Number(50), percent)),)),
    st.SetBlend(0, (st.Blend(st.BlendKind.RADIUS, ex.Quantity(ex.Number(3), mm)),)),
    st.SetBlend(0, (st.Blend(st.BlendKind.SPEED, ex.Quantity(ex.Number(100), percent)),)),
    st.SetBlend(0, (st.Blend(st.BlendKind.TURN, ex.Quantity(ex.Number(5), deg)),)),
)


_TURNING: Final = ex.Text("#VAR")


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
        self._parts: dict[tuple[str, str], ex.Expression] = {}  # what members of these have been set to since
        self.external = False  # $IPO_MODE is #TCP
        self._orientation = _TURNING

    def assign(self, key: str, value: ex.Expression) -> None:
        self._actual[key] = value.name if type(value) is ex.Named else None
        self._parts = {part: one for part, one in self._parts.items() if part[0] != key}
        if isinstance(value, ex.RecordLiteral):
            for name, member in value.members:
                if type(member) in (ex.Number, ex.Text):
                    self._parts[key, name.upper()] = member

    def assign_part(self, key: str, name: str, value: ex.Expression) -> None:
        """`FDAT_ACT.TOOL_NO = …`; both in capitals."""
        self._parts[key, name] = value

    def changed(self, name: str) -> None:
        """A variable has another value: what was computed from it is not known any more."""
        for part, value in self._parts.items():
            names: set[str] = set()
            note_names(value, names)
            if name.casefold() in map(str.casefold, names):
                self._parts[part] = ex.Member(ex.Named(self.scope.spell(part[0])), self.scope.spell(part[1]))

    def member(self, record: str, name: str) -> ex.Expression:
        """`record.name`: a constant of a list where one gives it, else the expression."""
        if (record, name) in self._parts:
            return self._parts[record, name]
        actual = self._actual.get(record)
        found = self.constant(actual or record, name)
        if found is not None:
            return found
        if actual and self.scope.value_of(actual.upper()) is None:
            self.missing.append(actual)
            if not self.scope.known(actual.upper()):
                created = _AS_CREATED.get((record, name))
                if created is not None:
                    return ex.Number(created)
                record = actual  # what nobody sets holds the same as its copy
        return ex.Member(ex.Named(self.scope.spell(record)), self.scope.spell(name))

    def _word(self, record: str, name: str) -> ex.Expression | None:
        """A member that is a constant of an enumeration, None where nothing tells it."""
        if (record, name) in self._parts:
            return self._parts[record, name]
        return self.constant(self._actual.get(record) or record, name)

    def constant(self, record: str, name: str) -> ex.Expression | None:
        value = self.scope.value_of(record.upper())
        if isinstance(value, ex.RecordLiteral):
            for member, found in value.members:
                if member.upper() == name and type(found) in (ex.Number, ex.Text):
                    return found
        return None

    # --- tools and frames -------------------------------------------------------------------------------

    def tool(self, value: ex.Expression) -> ex.Expression:
        """The value of $TOOL."""
        if value == values.NULL_FRAME:
            return ex.FrameRef("tool", ex.Number(0))
        return self.by_number(value, "TOOL_DATA", "tool")

    def frame(self, value: ex.Expression) -> ex.Expression:
        """The value of $BASE."""
        if value == values.NULL_FRAME:
            return ex.FrameRef("base")
        if type(value) is ex.Named and value.name.upper() == "$ROBROOT":
            return ex.FrameRef("robot")
        return self.by_number(value, "BASE_DATA", "user")

    def by_number(self, value: ex.Expression, array: str, kind: str) -> ex.Expression:
        """TOOL_DATA[n] as it is where a list gives its value, else by its number."""
        if isinstance(value, ex.Item) and type(value.base) is ex.Named and value.base.name.upper() == array:
            listed = self.scope.value_of(array)
            if not (isinstance(listed, ex.RecordLiteral) and _has(listed, value.indices[0])):
                return ex.FrameRef(kind, value.indices[0])
        return value

    def numbered_tool(self, number: ex.Expression) -> ex.Expression:
        if type(number) is ex.Number and number.value == 0:
            return ex.FrameRef("tool", ex.Number(0))
        return self.by_number(
            ex.Item(ex.Named(self.scope.spell("TOOL_DATA")), (number,)), "TOOL_DATA", "tool"
        )

    def numbered_frame(self, number: ex.Expression) -> ex.Expression:
        if type(number) is ex.Number and number.value == 0:
            return ex.FrameRef("base")
        return self.by_number(
            ex.Item(ex.Named(self.scope.spell("BASE_DATA")), (number,)), "BASE_DATA", "user"
        )

    def chosen_tool(self, number: ex.Expression) -> tuple[st.Statement, ...]:
        """BAS(#TOOL,n): below 1 it is the flange."""
        flange = st.SetTool(0, self.numbered_tool(ex.Number(0)))
        return _above_zero(number, st.SetTool(0, self.numbered_tool(number)), flange)

    def chosen_frame(self, number: ex.Expression) -> tuple[st.Statement, ...]:
        """BAS(#BASE,n): below 1 it is $WORLD."""
        world = st.SetFrame(0, self.numbered_frame(ex.Number(0)))
        return _above_zero(number, st.SetFrame(0, self.numbered_frame(number)), world)

    # --- BAS --------------------------------------------------------------------------------------------

    def bas(self, command: str, argument: ex.Expression) -> tuple[st.Statement, ...] | None:
        """What `BAS(#command, argument)` sets; None: nothing of motion."""
        found = _COMMANDS.get(command)
        return None if found is None else found(self, argument)

    def initial(self) -> tuple[st.Statement, ...]:
        """INITMOV: the defaults, $BASE=$WORLD and $TOOL=TOOL_DATA[1]."""
        chosen = (
            st.SetFrame(0, self.numbered_frame(ex.Number(0))),
            st.SetTool(0, self.numbered_tool(ex.Number(1))),
        )
        return (*_INITIAL, *chosen, *self.interpolation(False))

    def joint_data(self) -> tuple[st.Statement, ...]:
        """PTP_DAT."""
        acceleration = joint_acceleration(self.member("PDAT_ACT", "ACC"), values.ACC_PTP)
        return (acceleration, st.SetBlend(0, self.joint_blends("PDAT_ACT")))

    def joint_blends(self, record: str) -> tuple[st.Blend, ...]:
        distance = self.member(record, "APO_DIST")
        mode = self._word(record, "APO_MODE")
        if type(mode) is ex.Text and mode.value.upper() == "#CDIS":
            return (st.Blend(st.BlendKind.RADIUS, ex.Quantity(distance, mm)),)
        if type(distance) is ex.Number:
            distance = ex.Number(min(distance.value, _MOST_SHARE))
        return (st.Blend(st.BlendKind.SHARE, ex.Quantity(distance, percent)),)

    def path_data(self) -> tuple[st.Statement, ...]:
        """CP_DAT."""
        acceleration = path_acceleration(self.member("LDAT_ACT", "ACC"), values.ACC_CP)
        blend = st.Blend(st.BlendKind.RADIUS, ex.Quantity(self.member("LDAT_ACT", "APO_DIST"), mm))
        return (acceleration, st.SetBlend(0, (blend,)), *self.orientation())

    def orientation(self) -> tuple[st.Statement, ...]:
        """$ORI_TYPE, where it changes: with #CONSTANT the tool does not turn to where the point says."""
        kind = self._word("LDAT_ACT", "ORI_TYP")
        said = kind if type(kind) is ex.Text and kind.value.upper() != "#VAR" else _TURNING
        if said == self._orientation:
            return ()
        self._orientation = said
        return (st.Assign(0, ex.Named("$ORI_TYPE"), said),)

    def frames(self) -> tuple[st.Statement, ...]:
        """FRAMES."""
        numbers = self.member("FDAT_ACT", "TOOL_NO"), self.member("FDAT_ACT", "BASE_NO")
        tool, frame = self.chosen_tool(numbers[0]), self.chosen_frame(numbers[1])
        if self._named("TOOL_NO"):
            tool = tool if len(tool) == 1 else (st.SetTool(0, self.numbered_tool(numbers[0])),)
        if self._named("BASE_NO"):
            frame = frame if len(frame) == 1 else (st.SetFrame(0, self.numbered_frame(numbers[1])),)
        mode = self._word("FDAT_ACT", "IPO_FRAME")
        external = type(mode) is ex.Text and mode.value.upper() == "#TCP"
        return (*tool, *frame, *self.interpolation(external))

    def _named(self, number: str) -> bool:
        """Whether a number of FDAT_ACT is that of a form's own data, which choose by name and seldom none."""
        return self._actual["FDAT_ACT"] is not None and ("FDAT_ACT", number) not in self._parts

    def interpolation(self, external: bool) -> tuple[st.Statement, ...]:
        """$IPO_MODE, where it changes."""
        if external == self.external:
            return ()
        self.external = external
        return (external_tool(external),)


def external_tool(external: bool) -> st.ExternalTool:
    """With #TCP the tool stands in the room, at $BASE, and the arm holds the work."""
    return st.ExternalTool(0, ex.SystemValue("current-frame") if external else None)


def _above_zero(
    number: ex.Expression, chosen: st.SetTool | st.SetFrame, none: st.SetTool | st.SetFrame
) -> tuple[st.Statement, ...]:
    """An element of a list that a program chooses by a computed number: a list has none at 0."""
    system = chosen.tool if isinstance(chosen, st.SetTool) else chosen.frame
    if type(number) is ex.Number or not isinstance(system, ex.Item):
        return (chosen,)
    below = st.If(0, ex.Compare("<=", number, ex.Number(0)))
    return (below, none, st.Else(0), chosen, st.EndIf(0))


def _has(listed: ex.RecordLiteral, index: ex.Expression) -> bool:
    if type(index) is not ex.Number:
        return True
    place = int(index.value) - 1
    return 0 <= place < len(listed.members) and type(listed.members[place][1]) is not ex.Unknown


_COMMANDS: Final[dict[str, Callable[[MotionData, ex.Expression], tuple[st.Statement, ...]]]] = {
    "INITMOV": lambda data, _: data.initial(),
    "VEL_PTP": lambda data, value: (joint_speed(value),),
    "ACC_PTP": lambda data, value: (joint_acceleration(value, values.ACC_PTP),),
    "VEL_CP": lambda data, value: (path_speed(value),),
    "ACC_CP": lambda data, value: (path_acceleration(value, values.ACC_CP),),
    "TOOL": lambda data, value: data.chosen_tool(value),
    "BASE": lambda data, value: data.chosen_frame(value),
    "FRAMES": lambda data, _: data.frames(),
    "PTP_DAT": lambda data, _: (joint_speed(data.member("PDAT_ACT", "VEL")), *data.joint_data()),
    "CP_DAT": lambda data, _: (path_speed(data.member("LDAT_ACT", "VEL")), *data.path_data()),
    "PTP_PARAMS": lambda data, value: (*data.joint_data(), *data.frames(), joint_speed(value)),
    "CP_PARAMS": lambda data, value: (*data.path_data(), *data.frames(), path_speed(value)),
}
