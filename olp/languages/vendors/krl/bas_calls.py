"""Finds the statements that one call of BAS stands for, so that KRL's own programs keep their inline forms."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

from olp.ir import expressions as ex
from olp.ir import program as st
from olp.languages.vendors.krl.body import FORGETS
from olp.languages.vendors.krl.motion_data import ACTUAL, MotionData
from olp.languages.vendors.krl.scope import Scope
from olp.languages.vendors.krl.write_values import KrlValues

MODAL: Final = (st.SetSpeed, st.SetAcceleration, st.SetBlend, st.SetTool, st.SetFrame, st.ExternalTool)
_MOST: Final = 16  # statements of one call
_COMMANDS: Final = ("INITMOV", "PTP_PARAMS", "CP_PARAMS", "PTP_DAT", "CP_DAT", "FRAMES")


class BasCalls:
    """Follows a routine as the reader did."""

    def __init__(self, scope: Scope, words: KrlValues) -> None:
        self._words = words
        self._data = MotionData(scope)

    def follow(self, it: st.Statement) -> None:
        """Notes what a statement says about the motion data."""
        if isinstance(it, FORGETS):
            self._data.forget()
        elif isinstance(it, st.ExternalTool):
            self._data.external = it.tool is not None
        elif (
            isinstance(it, st.Assign) and isinstance(it.target, ex.Named) and it.target.name.upper() in ACTUAL
        ):
            self._data.assign(it.target.name.upper(), it.value)

    def call(self, body: Sequence[st.Statement], place: int) -> tuple[int, str] | None:
        """How many statements from `place` on one call of BAS stands for, and that call; None: not one."""
        first = body[place]
        if not isinstance(first, MODAL) or not first.line:
            return None
        group = []
        for at in range(place, min(place + _MOST, len(body))):
            one = body[at]
            if not isinstance(one, MODAL) or one.line != first.line:
                break
            group.append(one)
        if len(group) < 2:
            return None
        argument = _speed(group[-1])
        external = self._data.external
        for command in _COMMANDS:
            found = self._data.bas(command, argument)
            if found is not None and len(found) == len(group) and all(map(_alike, found, group)):
                value = "0" if command in ("INITMOV", "FRAMES") else self._words.value(argument)
                plain = command in ("PTP_DAT", "CP_DAT", "FRAMES")
                return len(group), f"BAS (#{command})" if plain else f"BAS (#{command},{value})"
            self._data.external = external
        return None


def _speed(it: st.Statement) -> ex.Expression:
    return it.speeds[0].value.written if isinstance(it, st.SetSpeed) and it.speeds else ex.Number(0)


def _alike(one: st.Statement, other: st.Statement) -> bool:
    """Equal but for the line and the comment."""
    if type(one) is not type(other):
        return False
    skipped = "comment"
    names = [name for name in type(one).__dataclass_fields__ if name not in ("line", skipped)]
    return all(getattr(one, name) == getattr(other, name) for name in names)
