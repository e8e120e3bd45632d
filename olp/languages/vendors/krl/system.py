"""Assignments to system variables ($VEL, $BASE …) and calls of BAS become modal settings: SetSpeed, SetFrame …

What an assignment means depends on the ones before it: six equal ones to $VEL_AXIS[1..6] are one speed, and PDAT_ACT
holds what BAS(#PTP_PARAMS) sets. `Modal` follows the text and forgets everything at labels and branches.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Final

from olp.core.units import deg, mm, percent
from olp.ir import expressions as ex
from olp.ir import program as st
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
    "CPTP": (st.BlendKind.SHARE, percent),
    "CDIS": (st.BlendKind.RADIUS, mm),
    "CVEL": (st.BlendKind.SPEED, percent),
    "CORI": (st.BlendKind.TURN, deg),
}
_AXES = {"$VEL_AXIS", "$ACC_AXIS"}
_SYSTEMS: Final = {"TOOL_DATA": "tool", "BASE_DATA": "user"}
_FRAME_MEMBERS = ("x", "y", "z", "rx", "ry", "rz")


class Modal:
    """The modal settings at one line of a routine.

    `odd`: variables whose axes got different values; the caller reports and clears them. `first_alone`: variables, with
    their line, of which axis 1 got a value and not all of axes 2 to 4 got the same.
    """

    def __init__(self, scope: Scope) -> None:
        self.data = MotionData(scope)
        self.odd: list[str] = []
        self._axis: dict[str, ex.Expression] = {}
        self._without: dict[str, tuple[int, set[float]]] = {}
        self.first_alone: list[tuple[str, int]] = []

    def finish(self) -> None:
        """Must be called at the end of the routine: completes `first_alone`."""
        for name in tuple(self._without):
            self._close(name)

    def _close(self, name: str) -> None:
        line, missing = self._without.pop(name, (0, set()))
        if missing:
            self.first_alone.append((name, line))

    def forget(self) -> None:
        self.data.forget()
        self._axis.clear()

    def lower(self, it: st.Statement) -> tuple[st.Statement, ...]:
        """The settings that an assignment or a call of BAS means; else the statement itself."""
        if isinstance(it, st.Call):
            return self._call(it)
        if isinstance(it, st.Assign):
            return self._assign(it)
        return (it,)

    def fixed(self, it: st.Statement) -> st.Statement | None:
        """The setting that an assignment means regardless of those before it: path speed, acceleration, blend."""
        if (
            isinstance(it, st.Assign)
            and isinstance(it.target, ex.Member)
            and isinstance(it.target.base, ex.Named)
        ):
            owner, name = it.target.base.name.upper(), it.target.name.upper()
            if (owner in ("$VEL", "$ACC") and name == "CP") or (owner == "$APO" and name in APPROXIMATION):
                return self._member(it, it.target)[0]
        return None

    def _call(self, it: st.Call) -> tuple[st.Statement, ...]:
        if it.routine.upper() != "BAS" or not it.arguments or type(it.arguments[0]) is not ex.Text:
            return (it,)
        argument = it.arguments[1] if len(it.arguments) > 1 else ex.Number(0)
        found = self.data.bas(it.arguments[0].value[1:].upper(), argument)
        return (it,) if found is None else found

    def _assign(self, it: st.Assign) -> tuple[st.Statement, ...]:
        target, value = it.target, it.value
        kind = type(target)
        if kind is ex.Named:
            self.data.changed(target.name)  # type: ignore[union-attr]
        if isinstance(target, ex.SystemValue):
            if target.name == "current-tool":
                return (st.SetTool(0, self.data.tool(value)),)
            return (st.SetFrame(0, self.data.frame(value)),) if target.name == "current-frame" else (it,)
        if isinstance(target, ex.Named):
            return self._named(it, target.name.upper())
        if isinstance(target, ex.Item) and type(target.base) is ex.Named:
            name = target.base.name.upper()
            if name in _SYSTEMS:
                return (replace(it, target=self.data.by_number(target, name, _SYSTEMS[name])),)
            if name in _AXES and target.indices:
                return self._axis_value(it, name, target.indices[0])
            return (it,)
        if isinstance(target, ex.Member):
            return self._member(it, target)
        return (it,)

    def _named(self, it: st.Assign, key: str) -> tuple[st.Statement, ...]:
        if key in ACTUAL:
            self.data.assign(key, it.value)
        elif key == "$OV_PRO":
            return (st.SetOverride(0, ex.Quantity(it.value, percent)),)
        elif key == "$IPO_MODE" and type(it.value) is ex.Text:
            return self.data.interpolation(it.value.value.upper() == "#TCP")
        elif key in ("$VEL", "$ACC", "$APO") and isinstance(it.value, ex.RecordLiteral):
            whole = it.target
            return tuple(
                one
                for name, value in it.value.members
                for one in self._member(st.Assign(0, ex.Member(whole, name), value), ex.Member(whole, name))
            )
        return (it,)

    def _axis_value(self, it: st.Assign, name: str, index: ex.Expression) -> tuple[st.Statement, ...]:
        """$VEL_AXIS[i]: the value of axis 1 is taken for all axes; equal values of the others are dropped."""
        if type(index) is ex.Number and index.value != 1:
            self._without.get(name, (0, set[float]()))[1].discard(index.value)
            if self._axis.get(name) == it.value:
                return ()
            self._without.pop(name, None)
            self.odd.append(name)
            return (it,)
        self._close(name)
        if type(index) is ex.Number:
            self._without[name] = (it.line, {2, 3, 4})
        self._axis[name] = it.value
        return (joint_speed(it.value) if name == "$VEL_AXIS" else joint_acceleration(it.value, percent),)

    def _member(self, it: st.Assign, target: ex.Member) -> tuple[st.Statement, ...]:
        base, name = target.base, target.name.upper()
        if isinstance(base, ex.Named) and base.name.upper() in ACTUAL:
            self.data.assign_part(base.name.upper(), name, it.value)
            return (it,)
        if isinstance(base, ex.SystemValue) and base.name in ("current-tool", "current-frame"):
            return self._frame_member(it, base, target.name)
        if not isinstance(base, ex.Named):
            return (it,)
        owner = base.name.upper()
        if owner == "$VEL":
            return self._path_speed(it, name)
        if owner == "$ACC" and name == "CP":
            return (path_acceleration(it.value, 1.0),)
        if owner == "$APO" and name in APPROXIMATION:
            kind, scale = APPROXIMATION[name]
            return (st.SetBlend(0, (st.Blend(kind, ex.Quantity(it.value, scale)),)),)
        return (it,)

    def _path_speed(self, it: st.Assign, name: str) -> tuple[st.Statement, ...]:
        if name == "CP":
            return (path_speed(it.value),)
        if name == "ORI1":
            self._axis["$VEL.ORI"] = it.value
            return (st.SetSpeed(0, (), turn=ex.Quantity(it.value, deg)),)
        if name == "ORI2" and self._axis.get("$VEL.ORI") == it.value:
            return ()
        if name == "ORI2":
            self.odd.append("$VEL.ORI2")
        return (it,)

    def _frame_member(self, it: st.Assign, base: ex.SystemValue, name: str) -> tuple[st.Statement, ...]:
        """$BASE.Z = …: the active frame with one component replaced."""
        if name not in _FRAME_MEMBERS:
            return (it,)
        parts = tuple(it.value if name == one else ex.Member(base, one) for one in _FRAME_MEMBERS)
        pose = ex.Function("pose-angles", parts)
        return (st.SetTool(0, pose) if base.name == "current-tool" else st.SetFrame(0, pose),)
