"""Assignments to the controller's own variables and calls of BAS, as statements of motion.

What an assignment means depends on the ones before it: six equal ones to $VEL_AXIS[1..6] are one speed, PDAT_ACT says
what BAS(#PTP_PARAMS) sets. `Modal` follows the text and forgets at labels and branches.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Final

from olp.core.units import deg, mm, percent
from olp.ir.expressions import (
    Expression,
    Function,
    Item,
    Member,
    Named,
    Number,
    Quantity,
    RecordLiteral,
    SystemValue,
    Text,
)
from olp.ir.statements import (
    Assign,
    Blend,
    BlendKind,
    Call,
    SetBlend,
    SetFrame,
    SetOverride,
    SetSpeed,
    SetTool,
    Statement,
)
from olp.languages.vendors.krl.motion_data import (
    ACTUAL,
    MotionData,
    joint_acceleration,
    joint_speed,
    path_acceleration,
    path_speed,
)
from olp.languages.vendors.krl.scope import Scope

APPROXIMATION: Final = {
    "CPTP": (BlendKind.SHARE, percent),
    "CDIS": (BlendKind.RADIUS, mm),
    "CVEL": (BlendKind.SPEED, percent),
    "CORI": (BlendKind.TURN, deg),
}
_AXES = {"$VEL_AXIS", "$ACC_AXIS"}
_SYSTEMS: Final = {"TOOL_DATA": "tool", "BASE_DATA": "user"}
_FRAME_MEMBERS = ("x", "y", "z", "rx", "ry", "rz")


class Modal:
    """`odd`: the variables whose axes got different values, since the last look."""

    def __init__(self, scope: Scope) -> None:
        self.data = MotionData(scope)
        self.odd: list[str] = []
        self._axis: dict[str, Expression] = {}

    def forget(self) -> None:
        self.data.forget()
        self._axis.clear()

    def lower(self, it: Statement) -> tuple[Statement, ...]:
        """What an assignment or a call stands for: itself, or statements of motion."""
        if isinstance(it, Call):
            return self._call(it)
        if isinstance(it, Assign):
            return self._assign(it)
        return (it,)

    def fixed(self, it: Statement) -> Statement | None:
        """What an assignment stands for whatever stands before it: path speed, path acceleration, blend sizes."""
        if isinstance(it, Assign) and isinstance(it.target, Member) and isinstance(it.target.base, Named):
            owner, name = it.target.base.name.upper(), it.target.name.upper()
            if (owner in ("$VEL", "$ACC") and name == "CP") or (owner == "$APO" and name in APPROXIMATION):
                return self._member(it, it.target)[0]
        return None

    def _call(self, it: Call) -> tuple[Statement, ...]:
        if it.routine.upper() != "BAS" or not it.arguments or type(it.arguments[0]) is not Text:
            return (it,)
        argument = it.arguments[1] if len(it.arguments) > 1 else Number(0)
        found = self.data.bas(it.arguments[0].value[1:].upper(), argument)
        return (it,) if found is None else found

    def _assign(self, it: Assign) -> tuple[Statement, ...]:
        target, value = it.target, it.value
        kind = type(target)
        if kind is Named:
            self.data.changed(target.name)  # type: ignore[union-attr]
        if isinstance(target, SystemValue):
            if target.name == "current-tool":
                return (SetTool(0, self.data.tool(value)),)
            return (SetFrame(0, self.data.frame(value)),) if target.name == "current-frame" else (it,)
        if isinstance(target, Named):
            return self._named(it, target.name.upper())
        if isinstance(target, Item) and type(target.base) is Named:
            name = target.base.name.upper()
            if name in _SYSTEMS:
                return (replace(it, target=self.data.by_number(target, name, _SYSTEMS[name])),)
            if name in _AXES and target.indices:
                return self._axis_value(it, name, target.indices[0])
            return (it,)
        if isinstance(target, Member):
            return self._member(it, target)
        return (it,)

    def _named(self, it: Assign, key: str) -> tuple[Statement, ...]:
        if key in ACTUAL:
            self.data.assign(key, it.value)
        elif key == "$OV_PRO":
            return (SetOverride(0, Quantity(it.value, percent)),)
        elif key == "$IPO_MODE" and type(it.value) is Text:
            return self.data.interpolation(it.value.value.upper() == "#TCP")
        elif key in ("$VEL", "$ACC", "$APO") and isinstance(it.value, RecordLiteral):
            whole = it.target
            return tuple(
                one
                for name, value in it.value.members
                for one in self._member(Assign(0, Member(whole, name), value), Member(whole, name))
            )
        return (it,)

    def _axis_value(self, it: Assign, name: str, index: Expression) -> tuple[Statement, ...]:
        """$VEL_AXIS[i]: the first axis speaks for all; the same value for the others adds nothing."""
        if type(index) is Number and index.value != 1:
            if self._axis.get(name) == it.value:
                return ()
            self.odd.append(name)
            return (it,)
        self._axis[name] = it.value
        return (joint_speed(it.value) if name == "$VEL_AXIS" else joint_acceleration(it.value, percent),)

    def _member(self, it: Assign, target: Member) -> tuple[Statement, ...]:
        base, name = target.base, target.name.upper()
        if isinstance(base, Named) and base.name.upper() in ACTUAL:
            self.data.assign_part(base.name.upper(), name, it.value)
            return (it,)
        if isinstance(base, SystemValue) and base.name in ("current-tool", "current-frame"):
            return self._frame_member(it, base, target.name)
        if not isinstance(base, Named):
            return (it,)
        owner = base.name.upper()
        if owner == "$VEL":
            return self._path_speed(it, name)
        if owner == "$ACC" and name == "CP":
            return (path_acceleration(it.value, 1.0),)
        if owner == "$APO" and name in APPROXIMATION:
            kind, scale = APPROXIMATION[name]
            return (SetBlend(0, (Blend(kind, Quantity(it.value, scale)),)),)
        return (it,)

    def _path_speed(self, it: Assign, name: str) -> tuple[Statement, ...]:
        if name == "CP":
            return (path_speed(it.value),)
        if name == "ORI1":
            self._axis["$VEL.ORI"] = it.value
            return (SetSpeed(0, (), turn=Quantity(it.value, deg)),)
        if name == "ORI2" and self._axis.get("$VEL.ORI") == it.value:
            return ()
        if name == "ORI2":
            self.odd.append("$VEL.ORI2")
        return (it,)

    def _frame_member(self, it: Assign, base: SystemValue, name: str) -> tuple[Statement, ...]:
        """$BASE.Z = …: the frame that holds, with one component replaced."""
        if name not in _FRAME_MEMBERS:
            return (it,)
        parts = tuple(it.value if name == one else Member(base, one) for one in _FRAME_MEMBERS)
        pose = Function("pose-angles", parts)
        return (SetTool(0, pose) if base.name == "current-tool" else SetFrame(0, pose),)
