"""Spells motion: PTP, LIN, CIRC with their forms, and the modal statements before them where something changes.

In KRL speed, blend sizes, tool and frame are variables. A move that carries them is written as an assignment where
the wanted value differs from the one known to hold, and the move; after labels and blocks nothing is known.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final

from olp import called
from olp.expression import (
    Expression,
    FrameRef,
    Function,
    Member,
    Number,
    PositionLiteral,
    Quantity,
    SystemValue,
)
from olp.moves import (
    Acceleration,
    AccelerationUnit,
    Blend,
    BlendKind,
    Move,
    Path,
    SetAcceleration,
    SetBlend,
    SetFrame,
    SetOverride,
    SetSpeed,
    SetTool,
    Speed,
    SpeedUnit,
)
from olp.units import deg, mm, percent
from olp.vendors.krl import values
from olp.vendors.krl.write_values import CannotSayError, Words, pose_text

_SIZES: Final = {
    BlendKind.RADIUS: ("$APO.CDIS", mm, "C_DIS"),
    BlendKind.SHARE: ("$APO.CPTP", percent, "C_PTP"),
    BlendKind.SPEED: ("$APO.CVEL", percent, "C_VEL"),
    BlendKind.TURN: ("$APO.CORI", deg, "C_ORI"),
}
_WORDS: Final = {Path.JOINT: "PTP", Path.LINEAR: "LIN", Path.CIRCULAR: "CIRC", Path.SPLINE: "SPL"}
_OF_PATH = (BlendKind.SPEED, BlendKind.TURN)
_USUAL: Final = Quantity(Number(100), percent)
_MEMBERS: Final = {"x": "X", "y": "Y", "z": "Z", "rz": "A", "ry": "B", "rx": "C"}
_ANGLES = ("x", "y", "z", "rx", "ry", "rz")


class MoveWriter:
    """`in_block`: within SPLINE … ENDSPLINE, where moves name no blend."""

    def __init__(self, words: Words) -> None:
        self.words = words
        self.in_block = False
        self._last: Blend | None = None
        self._known: dict[str, str] = {}
        self._told: dict[str, object] = {}

    def forget(self) -> None:
        """After a label, a block or a call nothing is known to hold."""
        if self._known:
            self._known.clear()
            self._told.clear()

    # --- moves ------------------------------------------------------------------------------------------

    def move(self, s: Move) -> list[str]:
        """The lines of a move: assignments first."""
        if s.parts or s.coordinated or s.search is not None or s.until is not None:
            raise CannotSayError("a move of several groups, or one that ends early")
        if s.offset is not None or s.tool_offset is not None or s.no_wait:
            raise CannotSayError("a move with an offset, or one that is not waited for")
        blend, native = s.blend, self._native(s.blend)
        if s.other and not self.words.own:
            raise CannotSayError(f"'{s.other[0][0]}' of a move")
        if native[:1] == "S" or native == "C_SPL" or self.in_block or s.other:
            return [self._spline_form(s)]
        lines = self._modal(s)
        target = self._target(s)
        passed = "" if blend is None else self._blend_words(blend, s.path)
        lines.append(f"{self._word(s)} {target}{passed}{_frame_word(s.relative)}")
        return lines

    def _native(self, blend: Blend | None) -> str:
        """The words that KRL's own program wrote; other languages' names mean nothing here."""
        return blend.native if blend is not None and self.words.own else ""

    def end_block(self) -> str:
        """ENDSPLINE, with the blend of the block's last move."""
        self.in_block = False
        last = self._last
        return (
            f"ENDSPLINE{self._blend_words(last, Path.LINEAR).replace(' S ', ' ') if last is not None else ''}"
        )

    def _word(self, s: Move) -> str:
        word = _WORDS[s.path]
        if s.path is Path.SPLINE and not self.in_block:
            raise CannotSayError("a spline outside of a spline block", "KRL has SPLINE … ENDSPLINE")
        return word if s.relative is None else f"{word}_REL"

    def _target(self, s: Move) -> str:
        if len(s.targets) != 1:
            raise CannotSayError("a move with several positions")
        target = s.targets[0]
        text = (
            pose_text(target, self.words.own)
            if type(target) is PositionLiteral
            else self.words.expression(target)
        )
        if s.via is not None:
            text = f"{self.words.expression(s.via)},{text}"
        elif s.path is Path.CIRCULAR:
            raise CannotSayError("an arc of single points", "an arc in KRL names its auxiliary point")
        if s.arc is not None:
            text += f",CA {self.words.quantity(s.arc, deg)}"
        return text

    def _blend_words(self, blend: Blend, path: Path) -> str:
        if _is_stop(blend):
            return ""
        if self._native(blend):
            return f" {blend.native}"
        if blend.kind is BlendKind.CONTINUOUS:
            return " C_PTP" if path is Path.JOINT else " C_DIS"
        if blend.kind not in _SIZES:
            raise CannotSayError(f"a blend by {called.BLENDS[blend.kind]}")
        joint = path is Path.JOINT
        if (joint and blend.kind in _OF_PATH) or (not joint and blend.kind is BlendKind.SHARE):
            raise CannotSayError(f"a blend by {called.BLENDS[blend.kind]} on this kind of move")
        return f" {_SIZES[blend.kind][2]}"

    # --- spline forms -----------------------------------------------------------------------------------

    def _spline_form(self, s: Move) -> str:
        """SPTP, SLIN, SCIRC or SPL with all that the move carries in its WITH list."""
        word, native = self._word(s), self._native(s.blend)
        self._last = s.blend
        if word[0] != "S" and native not in ("C_DIS", "C_PTP"):
            word = f"S{word}"
        settings = list(self._settings(s))
        text = f"{word} {self._target(s)}"
        if settings:
            text += f" WITH {', '.join(f'{name}={value}' for name, value in settings)}"
        passed = ""
        if not (self.in_block or s.blend is None or _is_stop(s.blend)):
            passed = f" {native.removeprefix('S ')}" if native else self._blend_words(s.blend, s.path)
        return f"{text}{passed}{_frame_word(s.relative)}"

    def _settings(self, s: Move) -> Iterator[tuple[str, str]]:
        quantity = self.words.quantity
        if s.speed is not None:
            yield from self._speed_setting(s.speed)
        if s.turn is not None:
            yield "$VEL.ORI1", quantity(s.turn, deg)
        if s.tool is not None:
            yield "$TOOL", self.words.expression(s.tool)
        if s.frame is not None:
            yield "$BASE", self.words.expression(s.frame)
        if s.acceleration is not None:
            yield "$ACC_AXIS[1]", quantity(s.acceleration, percent)
        if s.rate is not None:
            yield from self._rate_setting(s.rate)
        if (
            s.blend is not None
            and s.blend.value is not None
            and s.blend.kind in _SIZES
            and not _is_stop(s.blend)
        ):
            name, scale, _ = _SIZES[s.blend.kind]
            yield name, quantity(s.blend.value, scale)
        for name, value in s.other:
            yield name, self.words.expression(value)

    def _speed_setting(self, speed: Speed) -> Iterator[tuple[str, str]]:
        if speed.unit is SpeedUnit.FRACTION:
            yield "$VEL_AXIS[1]", f"SVEL_JOINT({self.words.quantity(speed.value, percent)})"
        elif speed.unit is SpeedUnit.TRAVEL:
            yield "$VEL.CP", self.words.quantity(speed.value, 1.0)
        else:
            raise CannotSayError(f"{called.SPEEDS[speed.unit]} in a WITH list")

    def _rate_setting(self, rate: Acceleration) -> Iterator[tuple[str, str]]:
        if rate.unit is not AccelerationUnit.TRAVEL:
            raise CannotSayError("an acceleration of the axes in a WITH list")
        yield "$ACC.CP", self.words.quantity(rate.value, 1.0)

    # --- assignments before a move ----------------------------------------------------------------------

    def _modal(self, s: Move) -> list[str]:
        """What has to be assigned before the move, where it is not known to hold."""
        told = self._told
        lines: list[str] = []
        # Canonical programs share their values: the same object needs no second look.
        joint = s.path is Path.JOINT
        if s.tool is not None and told.get("tool") is not s.tool:
            self._set(lines, "$TOOL", self.words.expression(s.tool))
            told["tool"] = s.tool
        if s.frame is not None and told.get("frame") is not s.frame:
            self._set(lines, "$BASE", self.words.expression(s.frame))
            told["frame"] = s.frame
        key = "joint" if joint else "path"
        if s.speed is not None and told.get(key) is not s.speed:
            self._speed(lines, s.speed)
            told[key] = s.speed  # not before it is written: what cannot be said is told for each move
        if s.turn is not None:
            self._turn(lines, self.words.quantity(s.turn, deg))
        if s.rate is not None:
            self._rate(lines, s.rate)
        elif s.acceleration is not None:
            self._fraction(lines, s.acceleration, joint)
        elif s.speed is not None and (f"acceleration {joint}") in self._known:
            self._fraction(lines, _USUAL, joint)
        blend = s.blend
        if blend is not None and blend.value is not None and blend.kind in _SIZES and not _is_stop(blend):
            name, scale, _ = _SIZES[blend.kind]
            self._set(lines, name, self.words.quantity(blend.value, scale))
        return lines

    def _set(self, lines: list[str], name: str, value: str) -> None:
        if self._known.get(name) != value:
            self._known[name] = value
            lines.append(f"{name}={value}")

    def _speed(self, lines: list[str], speed: Speed) -> None:
        if speed.unit is SpeedUnit.FRACTION:
            value = self.words.quantity(speed.value, percent)
            if self._known.get("joint") != value:
                self._known["joint"] = value
                lines.append(f"BAS (#VEL_PTP,{value})")
        elif speed.unit is SpeedUnit.TRAVEL:
            self._set(lines, "$VEL.CP", self.words.quantity(speed.value, 1.0))
        elif speed.unit is SpeedUnit.TURN:
            self._turn(lines, self.words.quantity(speed.value, deg))
        else:
            raise CannotSayError(called.SPEEDS[speed.unit], "KRL knows %, m/s and deg/s")

    def _turn(self, lines: list[str], value: str) -> None:
        self._set(lines, "$VEL.ORI1", value)
        self._set(lines, "$VEL.ORI2", value)

    def _rate(self, lines: list[str], rate: Acceleration) -> None:
        if rate.unit is AccelerationUnit.TRAVEL:
            self._set(lines, "$ACC.CP", self.words.quantity(rate.value, 1.0))
        elif rate.unit is AccelerationUnit.FRACTION:
            self._fraction(lines, rate.value, joint=True)
        else:
            raise CannotSayError("an acceleration of the axes in rad/s²")

    def _fraction(self, lines: list[str], share: Quantity, joint: bool) -> None:
        key = f"acceleration {joint}"
        text = self.words.quantity(share, percent)
        if self._known.get(key) == text:
            return
        self._known[key] = text
        if joint:
            lines += _axes("$ACC_AXIS", _whole(share, text))
        else:
            lines.append(f"BAS (#ACC_CP,{text})")

    # --- modal statements -------------------------------------------------------------------------------

    def set_speed(self, s: SetSpeed) -> list[str]:
        self.forget()
        lines: list[str] = []
        for speed in s.speeds:
            self._speed(lines, speed)
        if s.turn is not None:
            self._turn(lines, self.words.quantity(s.turn, deg))
        self.forget()
        return lines

    def set_acceleration(self, s: SetAcceleration) -> list[str]:
        self.forget()
        lines: list[str] = []
        for unit, value in s.rates:
            if unit is AccelerationUnit.FRACTION:
                if s.path in (None, Path.JOINT):
                    lines += self._joint_share(value)
                if s.path is not Path.JOINT:
                    lines.append(f"BAS (#ACC_CP,{self.words.quantity(value, percent)})")
            elif unit is AccelerationUnit.TRAVEL and value.scale == values.ACC_CP:
                lines.append(f"BAS (#ACC_CP,{self.words.expression(value.written)})")
            elif unit is AccelerationUnit.TRAVEL:
                lines.append(f"$ACC.CP={self.words.quantity(value, 1.0)}")
            else:
                raise CannotSayError("an acceleration of the axes in rad/s²")
        return lines

    def _joint_share(self, value: Quantity) -> list[str]:
        if value.scale == values.ACC_PTP:
            return [f"BAS (#ACC_PTP,{self.words.expression(value.written)})"]
        return _axes("$ACC_AXIS", self.words.quantity(value, percent))

    def set_blend(self, s: SetBlend) -> list[str]:
        self.forget()
        lines = []
        for blend in s.blends:
            if blend.kind not in _SIZES or blend.value is None:
                raise CannotSayError(f"a blend by {called.BLENDS[blend.kind]} for all moves")
            name, scale, _ = _SIZES[blend.kind]
            lines.append(f"{name}={self.words.quantity(blend.value, scale)}")
        return lines

    def set_tool(self, s: SetTool) -> list[str]:
        self.forget()
        return [_replaced("$TOOL", "current-tool", s.tool, self.words)]

    def set_frame(self, s: SetFrame) -> list[str]:
        self.forget()
        return [_replaced("$BASE", "current-frame", s.frame, self.words)]

    def set_override(self, s: SetOverride) -> list[str]:
        return [f"$OV_PRO={self.words.quantity(s.share, percent)}"]


def _whole(share: Quantity, text: str) -> str:
    """$ACC_AXIS holds whole percents, at least 1."""
    return text if share.literal is None else str(max(round(share.literal / percent), 1))


def _axes(name: str, text: str) -> list[str]:
    return [f"{name}[{axis}]={text}" for axis in range(1, 7)]


def _frame_word(frame: FrameRef | None) -> str:
    """Of a relative move: behind the blend, as the manuals have it."""
    if frame is None or frame.kind == "own":
        return ""
    if frame.kind == "tool":
        return " #TOOL"
    raise CannotSayError("a relative move in another frame", "#BASE or #TOOL")


def _is_stop(blend: Blend) -> bool:
    return blend.kind is BlendKind.RADIUS and blend.value is not None and blend.value.literal == 0.0


def _replaced(name: str, current: str, value: Expression, words: Words) -> str:
    """`$BASE.Z=…` where all other components are those that hold."""
    if isinstance(value, Function) and value.name == "pose-angles":
        holds = SystemValue(current)
        changed = [
            (one, it) for one, it in zip(_ANGLES, value.arguments, strict=True) if it != Member(holds, one)
        ]
        if len(changed) == 1:
            return f"{name}.{_MEMBERS[changed[0][0]]}={words.expression(changed[0][1])}"
    return f"{name}={words.expression(value)}"
