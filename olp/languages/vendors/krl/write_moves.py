"""Writes motion: PTP, LIN, CIRC with their forms, and the modal statements before them where something changes.

In KRL speed, blend sizes, tool and frame are variables. A move that carries them is written as an assignment where
the wanted value differs from the one known to hold, and the move; after labels and blocks nothing is known.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import Any, ClassVar, Final

from olp.core.units import deg, mm, ms, percent
from olp.ir import expressions as ex
from olp.ir import program as st
from olp.ir import terminology
from olp.ir.transformer import mapped
from olp.languages.generator import CannotSayError, decimal
from olp.languages.vendors.krl import values
from olp.languages.vendors.krl.limits import LIMITS
from olp.languages.vendors.krl.scope import AXES
from olp.languages.vendors.krl.write_forms import InlineForms
from olp.languages.vendors.krl.write_values import AXIS_WORDS, POSE, KrlValues, pose_text

_SIZES: Final = {
    st.BlendKind.RADIUS: ("$APO.CDIS", mm, "C_DIS"),
    st.BlendKind.SHARE: ("$APO.CPTP", percent, "C_PTP"),
    st.BlendKind.SPEED: ("$APO.CVEL", percent, "C_VEL"),
    st.BlendKind.TURN: ("$APO.CORI", deg, "C_ORI"),
}
_WORDS: Final = {st.Path.JOINT: "PTP", st.Path.LINEAR: "LIN", st.Path.CIRCULAR: "CIRC", st.Path.SPLINE: "SPL"}
_OF_PATH = (st.BlendKind.SPEED, st.BlendKind.TURN)
_USUAL: Final = ex.Quantity(ex.Number(100), percent)
_USUAL_TURN: Final = ex.Quantity(ex.Number(200), deg)
_USUAL_OF_FORMS: Final = ex.Quantity(ex.Number(100), values.ACC_PTP)
_SET_BY_FORMS: Final = ("$TOOL", "$BASE", "$VEL.CP", "joint", "$APO.CDIS", "$APO.CPTP")
_MEMBERS: Final = {"x": "X", "y": "Y", "z": "Z", "rz": "A", "ry": "B", "rx": "C"}
_ANGLES = ("x", "y", "z", "rx", "ry", "rz")
_ZERO: Final = ex.Number(0)
_POSES: Final = ("pose-product", "pose-inverse")


class KrlMoves(KrlValues):
    """Writes moves and settings. `in_block`: within SPLINE … ENDSPLINE, where moves name no blend.

    `forms`: of moves that are written as the pendant writes them. `turning`: $VEL.ORI1 and 2 where the program sets
    them once, at its beginning. `rated`: whether joint moves (True) or paths (False) of another language's program
    name accelerations, so that those which name none set the usual one; `turns`: the same of the paths' turning.
    """

    forms: InlineForms | None = None
    turning = ""
    rated: frozenset[bool] = frozenset()
    turns = False

    cannot: ClassVar = {
        st.Move: {
            **dict.fromkeys(
                ("parts", "coordinated", "search", "until"),
                "a move of several groups, or one that ends early",
            ),
            **dict.fromkeys(
                ("offset", "tool_offset", "no_wait"),
                "a move with an offset, or one that is not waited for",
            ),
        }
    }
    templates: ClassVar = {st.SetOverride: "$OV_PRO={share}"}
    fields: ClassVar = {"share": "percent"}

    def begin(self) -> None:
        super().begin()
        self.in_block = False
        self.temporaries: dict[str, str] = {}  # variables for computed positions: name -> type
        self._last: st.Blend | None = None
        self._given: dict[str, object] = {}  # the objects of the settings that hold

    def forget(self) -> None:
        if self.holds:
            super().forget()
            self._given.clear()

    def know(self, known: Mapping[str, object]) -> None:
        super().know(known)
        self._given.clear()

    def forget_from(self, name: str) -> None:
        known = len(self.holds)
        super().forget_from(name)
        if len(self.holds) < known:
            self._given.clear()

    # --- moves ------------------------------------------------------------------------------------------

    def write_move(self, s: st.Move) -> list[str]:
        """Assignments first, then the move."""
        if ex.Function in map(type, (*s.targets, s.via, s.tool, s.frame)):
            before, s = self.computed(s)
            return [*before, *self._triggers(s), *self._move(s)]
        return [*self._triggers(s), *self._move(s)] if s.triggers else self._move(s)

    def _triggers(self, s: st.Move) -> list[str]:
        """What switches while the move is under way; assignments between them and the move do no harm."""
        return [self._trigger(s.line, one) for one in s.triggers]

    def _trigger(self, line: int, one: st.PathTrigger) -> str:
        (deed,) = self.lines(st.SetOutput(line, one.signal, one.value))
        metres, seconds = (0.0 if far is None else far.literal or 0.0 for far in (one.metres, one.seconds))
        delay = decimal(round(seconds / ms, 6))
        if one.metres is None:
            return f"TRIGGER WHEN DISTANCE={0 if one.at_start else 1} DELAY={delay} DO {deed}"
        start = " ONSTART" if one.at_start else ""
        return f"TRIGGER WHEN PATH={decimal(round(metres / mm, 6))}{start} DELAY={delay} DO {deed}"

    def _move(self, s: st.Move) -> list[str]:
        if not self.own and s.path is not st.Path.JOINT and self.scope.type_of(s.targets[0]) in AXES:
            raise CannotSayError(f"a {s.path.value} move to joint angles", "use the pose that they reach")
        if self.forms is not None and (form := self.forms.lines(s)) is not None:
            return self._form(s, form)
        blend, native = s.blend, self._native(s.blend)
        if s.other and not self.own:
            raise CannotSayError(f"'{s.other[0][0]}' of a move")
        if native[:1] == "S" or native == "C_SPL" or self.in_block or s.other:
            return [self._spline_form(s)]
        lines = self._modal(s)
        target = self._target(s)
        passed = "" if blend is None else self._blend_words(blend, s.path)
        lines.append(f"{self._word(s)} {target}{passed}{_frame_word(s.relative)}")
        return lines

    def _form(self, s: st.Move, form: list[str]) -> list[str]:
        """The fold of a move, which sets all but how fast the tool turns."""
        lines: list[str] = []
        self._turned(lines, s)
        for name in _SET_BY_FORMS:
            self.holds.pop(name, None)
        self._given.clear()
        joint = s.path is st.Path.JOINT
        usual = s.acceleration is None and s.rate is None
        self.holds[f"acceleration {joint}"] = self._usual(joint) if usual else None
        return [*lines, *form]

    def initialised(self) -> None:
        """BAS (#INITMOV,0) has set accelerations and how fast the tool turns."""
        for joint in (True, False):
            self.holds[f"acceleration {joint}"] = self._usual(joint)
        for axis in (1, 2):
            self.holds[f"$VEL.ORI{axis}"] = self.quantity(_USUAL_TURN, deg)

    def _usual(self, joint: bool) -> str:
        return self.quantity(self._unprogrammed(joint), percent)

    def _unprogrammed(self, joint: bool) -> ex.Quantity:
        """The acceleration of a move that names none."""
        return _USUAL_OF_FORMS if joint and self.forms else _USUAL

    def _native(self, blend: st.Blend | None) -> str:
        """The words that KRL's own program wrote; other languages' names mean nothing here."""
        return blend.native if blend is not None and self.own else ""

    def end_block(self) -> str:
        """ENDSPLINE, with the blend of the block's last move."""
        self.in_block = False
        last = self._last
        return f"ENDSPLINE{self._blend_words(last, st.Path.LINEAR).replace(' S ', ' ') if last is not None else ''}"

    def _word(self, s: st.Move) -> str:
        word = _WORDS[s.path]
        if s.path is st.Path.SPLINE and not self.in_block:
            raise CannotSayError("a spline outside of a spline block", "KRL has SPLINE … ENDSPLINE")
        return word if s.relative is None else f"{word}_REL"

    def _target(self, s: st.Move) -> str:
        if len(s.targets) != 1:
            raise CannotSayError("a move with several positions")
        target = s.targets[0]
        text = pose_text(target, self.own) if type(target) is ex.PositionLiteral else self.value(target)
        if s.via is not None:
            text = f"{self.value(s.via)},{text}"
        elif s.path is st.Path.CIRCULAR:
            raise CannotSayError("an arc of single points", "an arc in KRL names its auxiliary point")
        if s.arc is not None:
            text += f",CA {self.quantity(s.arc, deg)}"
        return text

    def _blend_words(self, blend: st.Blend, path: st.Path) -> str:
        if values.is_stop(blend):
            return ""
        if self._native(blend):
            return f" {blend.native}"
        if blend.kind is st.BlendKind.CONTINUOUS:
            return " C_PTP" if path is st.Path.JOINT else " C_DIS"
        if blend.kind not in _SIZES:
            raise CannotSayError(f"a blend by {terminology.BLENDS[blend.kind]}")
        joint = path is st.Path.JOINT
        if (joint and blend.kind in _OF_PATH) or (not joint and blend.kind is st.BlendKind.SHARE):
            raise CannotSayError(f"a blend by {terminology.BLENDS[blend.kind]} on this kind of move")
        return f" {_SIZES[blend.kind][2]}"

    # --- spline forms -----------------------------------------------------------------------------------

    def _spline_form(self, s: st.Move) -> str:
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
        if not (self.in_block or s.blend is None or values.is_stop(s.blend)):
            passed = f" {native.removeprefix('S ')}" if native else self._blend_words(s.blend, s.path)
        return f"{text}{passed}{_frame_word(s.relative)}"

    def _settings(self, s: st.Move) -> Iterator[tuple[str, str]]:
        quantity = self.quantity
        if s.speed is not None:
            yield from self._speed_setting(s.speed)
        if s.turn is not None:
            yield "$VEL.ORI1", quantity(s.turn, deg)
        if s.tool is not None:
            yield "$TOOL", self.value(s.tool)
        if s.frame is not None:
            yield "$BASE", self.value(s.frame)
        if s.acceleration is not None:
            share = quantity(s.acceleration, percent)
            yield from ((f"$ACC_AXIS[{axis}]", share) for axis in range(1, 7))
        if s.rate is not None:
            yield from self._rate_setting(s.rate)
        if (
            s.blend is not None
            and s.blend.value is not None
            and s.blend.kind in _SIZES
            and not values.is_stop(s.blend)
        ):
            name, scale, _ = _SIZES[s.blend.kind]
            yield name, quantity(s.blend.value, scale)
        for name, value in s.other:
            yield name, self.value(value)

    def _speed_setting(self, speed: st.Speed) -> Iterator[tuple[str, str]]:
        if speed.unit is st.SpeedUnit.FRACTION:
            yield "$VEL_AXIS[1]", f"SVEL_JOINT({self.quantity(speed.value, percent)})"
        elif speed.unit is st.SpeedUnit.TRAVEL:
            yield "$VEL.CP", self.quantity(speed.value, 1.0)
        else:
            raise CannotSayError(f"{terminology.SPEEDS[speed.unit]} in a WITH list")

    def _rate_setting(self, rate: st.Acceleration) -> Iterator[tuple[str, str]]:
        if rate.unit is not st.AccelerationUnit.TRAVEL:
            raise CannotSayError("an acceleration of the axes in a WITH list")
        yield "$ACC.CP", self.quantity(rate.value, 1.0)

    # --- assignments before a move ----------------------------------------------------------------------

    def _modal(self, s: st.Move) -> list[str]:
        """What has to be assigned before the move, where it is not known to hold."""
        given = self._given
        lines: list[str] = []
        # Canonical programs share their values: the same object needs no second look.
        joint = s.path is st.Path.JOINT
        if s.tool is not None and given.get("tool") is not s.tool:
            self._set(lines, "$TOOL", self.value(s.tool))
            given["tool"] = s.tool
        if s.frame is not None and given.get("frame") is not s.frame:
            self._set(lines, "$BASE", self.value(s.frame))
            given["frame"] = s.frame
        key = "joint" if joint else "path"
        if s.speed is not None and given.get(key) is not s.speed:
            self._speed(lines, s.speed)
            given[key] = s.speed  # not before it is written: what cannot be said is told for each move
        self._turned(lines, s)
        if s.rate is not None:
            self._rate(lines, s.rate)
        elif s.acceleration is not None:
            self._fraction(lines, s.acceleration, joint)
        elif s.speed is not None and joint in self.rated:
            self._fraction(lines, self._unprogrammed(joint), joint)
        blend = s.blend
        if (
            blend is not None
            and blend.value is not None
            and blend.kind in _SIZES
            and not values.is_stop(blend)
        ):
            name, scale, _ = _SIZES[blend.kind]
            self._set(lines, name, self.quantity(blend.value, scale))
        return lines

    def _set(self, lines: list[str], name: str, value: str) -> None:
        if self.holds.get(name) != value:
            self.holds[name] = value
            lines.append(f"{name}={value}")

    def _speed(self, lines: list[str], speed: st.Speed) -> None:
        if speed.unit is st.SpeedUnit.FRACTION:
            value = self.quantity(speed.value, percent)
            if self.holds.get("joint") != value:
                self.holds["joint"] = value
                lines.append(f"BAS (#VEL_PTP,{value})")
        elif speed.unit is st.SpeedUnit.TRAVEL:
            self._set(lines, "$VEL.CP", self.quantity(speed.value, 1.0))
        elif speed.unit is st.SpeedUnit.TURN:
            # The slower of both counts: what a move before has set would hold.
            self._set(lines, "$VEL.CP", f"{LIMITS.speed_ranges[st.SpeedUnit.TRAVEL][1]:g}")
            self._turn(lines, self.quantity(speed.value, deg))
        else:
            raise CannotSayError(terminology.SPEEDS[speed.unit], "KRL knows %, m/s and deg/s")

    def _turned(self, lines: list[str], s: st.Move) -> None:
        """How fast the tool turns; moves that bound it not may do so as fast as INITMOV lets them."""
        if s.turn is not None:
            self._turn(lines, self.quantity(s.turn, deg))
        elif self.turns and s.path is not st.Path.JOINT and not says_turning(s):
            self._turn(lines, self.quantity(_USUAL_TURN, deg))

    def _turn(self, lines: list[str], value: str) -> None:
        if value == self.turning:
            return
        self._set(lines, "$VEL.ORI1", value)
        self._set(lines, "$VEL.ORI2", value)

    def _rate(self, lines: list[str], rate: st.Acceleration) -> None:
        if rate.unit is st.AccelerationUnit.TRAVEL:
            self.holds["acceleration False"] = None
            self._set(lines, "$ACC.CP", self.quantity(rate.value, 1.0))
        elif rate.unit is st.AccelerationUnit.FRACTION:
            self._fraction(lines, rate.value, joint=True)
        else:
            raise CannotSayError("an acceleration of the axes in rad/s²")

    def _fraction(self, lines: list[str], share: ex.Quantity, joint: bool) -> None:
        key = f"acceleration {joint}"
        text = self.quantity(share, percent)
        if self.holds.get(key) == text:
            return
        self.holds[key] = text
        if joint:
            lines += _axes("$ACC_AXIS", _whole(share, text))
        else:
            self.holds.pop("$ACC.CP", None)
            lines.append(f"BAS (#ACC_CP,{text})")

    # --- modal statements -------------------------------------------------------------------------------

    def write_set_speed(self, s: st.SetSpeed) -> list[str]:
        self.forget()
        lines: list[str] = []
        for speed in s.speeds:
            self._speed(lines, speed)
        if s.turn is not None:
            self._turn(lines, self.quantity(s.turn, deg))
        self.forget()
        return lines

    def write_set_acceleration(self, s: st.SetAcceleration) -> list[str]:
        self.forget()
        lines: list[str] = []
        for unit, value in s.rates:
            if unit is st.AccelerationUnit.FRACTION:
                if s.path in (None, st.Path.JOINT):
                    lines += self._joint_share(value)
                if s.path is not st.Path.JOINT:
                    lines.append(f"BAS (#ACC_CP,{self.quantity(value, percent)})")
            elif unit is st.AccelerationUnit.TRAVEL and value.scale == values.ACC_CP:
                lines.append(f"BAS (#ACC_CP,{self.value(value.written)})")
            elif unit is st.AccelerationUnit.TRAVEL:
                lines.append(f"$ACC.CP={self.quantity(value, 1.0)}")
            else:
                raise CannotSayError("an acceleration of the axes in rad/s²")
        return lines

    def _joint_share(self, value: ex.Quantity) -> list[str]:
        if value.scale == values.ACC_PTP:
            return [f"BAS (#ACC_PTP,{self.value(value.written)})"]
        return _axes("$ACC_AXIS", self.quantity(value, percent))

    def write_set_blend(self, s: st.SetBlend) -> list[str]:
        self.forget()
        lines = []
        for blend in s.blends:
            if blend.kind not in _SIZES or blend.value is None:
                raise CannotSayError(f"a blend by {terminology.BLENDS[blend.kind]} for all moves")
            name, scale, _ = _SIZES[blend.kind]
            lines.append(f"{name}={self.quantity(blend.value, scale)}")
        return lines

    def write_set_tool(self, s: st.SetTool) -> list[str]:
        before, s = self.computed(s)
        self.forget()
        return [*before, self._replaced("$TOOL", "current-tool", s.tool)]

    def write_set_frame(self, s: st.SetFrame) -> list[str]:
        before, s = self.computed(s)
        self.forget()
        return [*before, self._replaced("$BASE", "current-frame", s.frame)]

    def percent(self, it: ex.Quantity) -> str:
        return self.quantity(it, percent)

    def _replaced(self, name: str, current: str, value: ex.Expression) -> str:
        """`$BASE.Z=…` where all other components are those that hold."""
        if isinstance(value, ex.Function) and value.name == "pose-angles":
            holds = ex.SystemValue(current)
            pairs = zip(_ANGLES, value.arguments, strict=True)
            changed = [(one, it) for one, it in pairs if it != ex.Member(holds, one)]
            if len(changed) == 1:
                return f"{name}.{_MEMBERS[changed[0][0]]}={self.value(changed[0][1])}"
        return f"{name}={self.value(value)}"

    # --- computed positions -----------------------------------------------------------------------------

    def computed(self, s: Any) -> tuple[list[str], Any]:
        """The lines that fill variables, and the statement that uses them: KRL aggregates hold numbers only.

        KRL's own programs come back as they are.
        """
        if self.own:
            return [], s
        self._before: list[str] = []
        self._filled = 0
        self._poses: dict[ex.Expression, ex.Expression] = {}
        if isinstance(s, st.Move):
            s = replace(
                s,
                targets=tuple(map(self._plain, s.targets)),
                via=s.via and self._plain(s.via),
                tool=s.tool and self._plain(s.tool),
                frame=s.frame and self._plain(s.frame),
            )
        elif isinstance(s, st.Call):
            s = replace(s, arguments=tuple(map(self._plain, s.arguments)))
        else:
            name = {st.Assign: "value", st.Return: "value", st.SetTool: "tool", st.SetFrame: "frame"}[type(s)]
            s = replace(s, **{name: self._parted(self._plain(getattr(s, name)))})
        return self._before, s

    def _parted(self, it: ex.Expression) -> ex.Expression:
        """The expression with variables for the positions of which it takes elements."""
        return mapped(it, self._of_variable)

    def _of_variable(self, e: ex.Expression) -> ex.Expression:
        base = e.base if type(e) is ex.Member else None
        if type(e) is not ex.Member or type(base) is not ex.Function or base.name not in _POSES:
            return e
        if base not in self._poses:
            name = self._temporary("FRAME")
            self._before.append(f"{name}={self.value(self._plain(base))}")
            self._poses[base] = ex.Named(name)
        return ex.Member(self._poses[base], e.name)

    def _plain(self, it: ex.Expression) -> ex.Expression:
        """The expression with variables for its computed positions."""
        if not isinstance(it, ex.Function):
            return it
        arguments = tuple(map(self._plain, it.arguments))
        if it.name == "pose-offset":
            return ex.Function(
                "pose-product", (self._numbers((*arguments[1:4], _ZERO, _ZERO, _ZERO)), arguments[0])
            )
        if it.name == "pose-relative-tool":
            return self._relative(arguments)
        if it.name == "pose-angles":
            return self._numbers(arguments)
        if it.name == "joints":
            return self._fill("E6AXIS", list(zip(AXIS_WORDS, arguments, strict=False)))
        return ex.Function(it.name, arguments)

    def _relative(self, arguments: tuple[ex.Expression, ...]) -> ex.Expression:
        """p · shift · Rx · Ry · Rz, one factor for each angle that is not 0."""
        padded = [*arguments, *[_ZERO] * (7 - len(arguments))]
        pose, x, y, z, *angles = padded
        factors = [self._numbers((x, y, z, angles[0], _ZERO, _ZERO))]
        for place, angle in enumerate(angles[1:], 4):
            if angle not in (_ZERO, ex.Number(0.0)):
                parts: list[ex.Expression] = [_ZERO] * 6
                parts[place] = angle
                factors.append(self._numbers(tuple(parts)))
        for factor in factors:
            pose = ex.Function("pose-product", (pose, factor))
        return pose

    def _numbers(self, parts: tuple[ex.Expression, ...]) -> ex.Expression:
        """x y z [mm], rx ry rz [deg]."""
        numbers = [_constant(one) for one in parts]
        if all(one is not None for one in numbers):
            found = tuple((n or 0.0) * scale for n, scale in zip(numbers, values.POSE_SCALES, strict=True))
            return ex.PositionLiteral("pose", found)
        return self._fill("FRAME", [(word, parts[place]) for word, place in POSE])

    def _temporary(self, word: str) -> str:
        self._filled += 1
        name = f"COMPUTED_{'POSE' if word == 'FRAME' else 'AXES'}_{self._filled}"
        while self.scope.known(name):
            name += "_"
        self.temporaries[name] = word
        return name

    def _fill(self, word: str, parts: list[tuple[str, ex.Expression]]) -> ex.Expression:
        parts = [(key, self._parted(value)) for key, value in parts]
        name = self._temporary(word)
        self._before.append(f"{name}={{{','.join(f'{key} 0' for key, _ in parts)}}}")
        for key, value in parts:
            if value not in (_ZERO, ex.Number(0.0)):
                self._before.append(f"{name}.{key}={self.value(value)}")
        return ex.Named(name)


def says_turning(s: st.Move) -> bool:
    """Whether a move bounds how fast the tool turns, or is as fast as that."""
    return s.turn is not None or (s.speed is not None and s.speed.unit is st.SpeedUnit.TURN)


def _whole(share: ex.Quantity, text: str) -> str:
    """$ACC_AXIS holds whole percents, at least 1."""
    return text if share.literal is None else str(max(round(share.literal / percent), 1))


def _axes(name: str, text: str) -> list[str]:
    return [f"{name}[{axis}]={text}" for axis in range(1, 7)]


def _frame_word(frame: ex.FrameRef | None) -> str:
    """Of a relative move: behind the blend, as the manuals have it."""
    if frame is None or frame.kind == "own":
        return ""
    if frame.kind == "tool":
        return " #TOOL"
    raise CannotSayError("a relative move in another frame", "#BASE or #TOOL")


def _constant(it: ex.Expression) -> float | None:
    if type(it) is ex.Number:
        return float(it.value)
    if isinstance(it, ex.Unary) and type(it.operand) is ex.Number and it.operator == "-":
        return -float(it.operand.value)
    return None
