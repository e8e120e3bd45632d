"""Spells moves, and declares the speeds and zones that they need and nobody has."""

from __future__ import annotations

from collections.abc import Mapping
from operator import attrgetter
from typing import Final

from olp.core.units import deg, mm
from olp.ir import expressions as ex
from olp.ir import program as st
from olp.ir import terminology
from olp.languages.generator import CannotSayError
from olp.languages.vendors.rapid.moves import LAYOUTS, OWN
from olp.languages.vendors.rapid.names import RapidNames
from olp.languages.vendors.rapid.predefined_data import SPEEDS, ZONES
from olp.languages.vendors.rapid.write_values import RapidValues, decimal, literal

_WORDS: Final = {st.Path.LINEAR: "MoveL", st.Path.CIRCULAR: "MoveC", st.Path.JOINT: "MoveJ"}
# What few moves have, and what they have then.
_READ_RARE: Final = attrgetter(
    "parts", "rate", "relative", "search", "until", "arc", "offset", "tool_offset", "coordinated"
)
_NO_RARE: Final = ((), None, None, None, None, None, None, None, False)
_TRIGGERED: Final = {"out": "DOp", "out-group": "GOp", "analog-out": "AOp"}
_USUAL_TURN: Final = 500.0  # [deg/s] of the predefined speeds
_FULL_NAMES: Final = {values: name for name, values in SPEEDS.items() if name != "vmax"}
_ZONE_NAMES: Final = {zone.values[0]: name for name, zone in ZONES.items() if name != "fine"}


class RapidMoves(RapidValues):
    """Writes moves, whose speeds and blends they share. `declared`: new data, by name."""

    def __init__(self, program: st.Program, types: Mapping[str, str], names: RapidNames) -> None:
        super().__init__(program, types, names)
        self.declared: dict[str, str] = {}
        self._speeds: dict[tuple[int, int], tuple[object, object, str]] = {}
        self._named_speeds: dict[tuple[float, float | None], str] = {}

    def move(self, s: st.Move) -> str:
        """The instruction of a move alone."""
        if s.other:
            return self._with_process(s)
        if s.triggers:
            return self._with_triggers(s)
        return self._plain_move(s, "")

    def _plain_move(self, s: st.Move, triggers: str) -> str:
        target = s.targets[0]
        word = self._word(s, target)
        via = f"{self._position(s.via)}," if s.via is not None else ""
        conc = "\\Conc," if s.no_wait else ""
        if triggers:
            word = word.replace("Move", "Trigg")
        how = f"{self._speed(s)},{triggers}{self._blend(s.blend)},{self._tool(s)}{self._work_object(s)}"
        return f"{word} {conc}{via}{self._position(target)},{how};"

    def _with_triggers(self, s: st.Move) -> str:
        """TriggL, TriggC: each trigger in a variable, which an instruction before the move sets."""
        names = []
        for one in s.triggers:
            names.append(self.temporary_name("triggdata"))
            self.before.append(self._trigger(names[-1], one))
        first, *further = names
        return self._plain_move(
            s, first + "".join(f"\\T{n}:={name}" for n, name in enumerate(further, 2)) + ","
        )

    def _trigger(self, name: str, one: st.PathTrigger) -> str:
        """TriggIO, or TriggEquip where it acts earlier or later than at its distance."""
        option = _TRIGGERED.get(one.signal.bus)
        if option is None:
            raise CannotSayError(f"{terminology.signal(one.signal)[0]} on the way of a move")
        setting = f"\\{option}:={self.signal(one.signal)},{self._trigger_value(one.value)};"
        metres, seconds = (None if far is None else far.literal for far in (one.metres, one.seconds))
        start = "\\Start" if one.at_start else ""
        distance = decimal(round(abs(metres or 0.0) / mm, 6))
        if seconds and metres is None:
            return f"TriggIO {name},{decimal(round(-seconds, 6))}\\Time{setting}"
        if seconds:
            return f"TriggEquip {name},{distance}{start},{decimal(round(-seconds, 6))}{setting}"
        return f"TriggIO {name},{distance}{start}{setting}"

    def _trigger_value(self, value: ex.Expression) -> str:
        return str(int(value.on)) if isinstance(value, ex.SignalState) else self.value(value)

    def _word(self, s: st.Move, target: ex.Expression) -> str:
        _refuse_what_is_not_said(s)
        if s.path is st.Path.JOINT and (self._is_joints(target) or self._was_joints(s, target)):
            return "MoveAbsJ"
        if s.path not in _WORDS or (s.path is st.Path.CIRCULAR) != (s.via is not None):
            raise CannotSayError(f"a {s.path.value} move of this shape")
        if (
            not self.own
            and s.path is not st.Path.JOINT
            and any(self._is_joints(e) for e in (target, s.via) if e is not None)
        ):
            raise CannotSayError(f"a {s.path.value} move to joint angles", "use the pose that they reach")
        return _WORDS[s.path]

    def _is_joints(self, target: ex.Expression) -> bool:
        return self.type_of(target) == "jointtarget"

    def _was_joints(self, s: st.Move, target: ex.Expression) -> bool:
        """Whether the instruction itself says it, of data that another file declares."""
        if not self.own or self.type_of(target):
            return False
        return "moveabsj" in self.program.source.line(s.line).casefold()

    def _position(self, it: ex.Expression) -> str:
        if isinstance(it, ex.Named):
            return self.as_robtarget(it) if self.type_of(it) == "pose" else it.name
        if isinstance(it, ex.PositionLiteral):
            return literal(it, "robtarget", self.own)
        if self._is_joints(it):
            return self.typed(it, "jointtarget")
        return self.as_robtarget(it)

    # --- speed, zone, tool ------------------------------------------------------------------------------------

    def _speed(self, s: st.Move) -> str:
        key = (id(s.speed), id(s.turn))
        known = self._speeds.get(key)
        if known is not None:
            return known[2]
        if s.speed is None:
            raise CannotSayError("a move without a speed")
        text = self._spelled_speed(s.speed, s.turn)
        self._speeds[key] = (s.speed, s.turn, text)  # the objects are kept, so that their ids stay their own
        return text

    def _spelled_speed(self, speed: st.Speed, turn: ex.Quantity | None) -> str:
        unit, value, native = speed
        base = native.partition(OWN)[0] if self.own else ""
        if unit is st.SpeedUnit.TIME:
            return f"{base or 'v1000'}\\T:={self.quantity(value, 1.0)}"
        if unit is not st.SpeedUnit.TRAVEL:
            raise CannotSayError(terminology.SPEEDS[unit], "RAPID's speeds are those of the tool, in mm/s")
        if base:
            return f"{base}\\V:={self.quantity(value, mm)}" if native.endswith(f"{OWN}V") else base
        if value.literal is None:
            if isinstance(value.written, ex.Member) and value.written.name == "v_tcp":
                return self.value(value.written.base)
            if turn is None or turn.literal is not None:
                bounded = self._literal_speed(1000, None if turn is None else turn.literal)
                return f"{bounded}\\V:={self.quantity(value, mm)}"
        if turn is not None and turn.literal is None:
            return f"[{self.quantity(value, mm)},{self.quantity(turn, deg)},5000,1000]"
        assert value.literal is not None
        wanted = (value.literal / mm, None if turn is None else turn.literal)
        known = self._named_speeds.get(wanted)
        if known is None:
            known = self._named_speeds[wanted] = self._literal_speed(*wanted)
        return known

    def _literal_speed(self, travel: float, turn: float | None) -> str:
        """The predefined one of these numbers, else one that is declared. [mm/s], [rad/s]"""
        travel = round(travel, 4)  # finer than any controller keeps it
        degrees = _USUAL_TURN if turn is None else round(turn / deg, 6)
        known = _FULL_NAMES.get((travel, degrees, 5000, 1000))
        if known is not None and known not in self.types:
            return known
        name = f"v{_as_name(travel)}" + ("" if degrees == _USUAL_TURN else f"_{_as_name(degrees)}")
        return self._declare(name, "speeddata", f"[{decimal(travel)},{decimal(degrees)},5000,1000]")

    def _blend(self, blend: st.Blend | None) -> str:
        if blend is None:
            raise CannotSayError("a move that does not say how its end is passed")
        return self.once(blend, self._spelled_blend)

    def _spelled_blend(self, blend: st.Blend) -> str:
        kind, value, native = blend
        if kind is not st.BlendKind.RADIUS or value is None:
            raise CannotSayError(f"a blend by {terminology.BLENDS[kind]}", "RAPID's zones are radii in mm")
        if self.own and native:
            base = native.partition(OWN)[0]
            return f"{base}\\Z:={self.quantity(value, mm)}" if native.endswith(f"{OWN}Z") else base
        if value.literal is None:
            if isinstance(value.written, ex.Member) and value.written.name == "pzone_tcp":
                return self.value(value.written.base)
            return f"z10\\Z:={self.quantity(value, mm)}"
        radius = round(value.literal / mm, 4)
        if radius <= 0.0:
            return "fine"
        known = _ZONE_NAMES.get(radius)
        if known is not None and known not in self.types:
            return known
        # The other members in the proportions of the predefined zones.
        wide, turned = decimal(round(radius * 1.5, 6)), decimal(round(radius * 0.15, 6))
        numbers = f"[FALSE,{decimal(radius)},{wide},{wide},{turned},{wide},{turned}]"
        return self._declare(f"z{_as_name(radius)}", "zonedata", numbers)

    def _declare(self, name: str, kind: str, value: str) -> str:
        text = f"{kind} {{}}:={value};"
        for count in range(1000):
            one = f"{name}_{count}" if count else name
            if self.declared.get(one) == text:
                return one
            if (
                one not in self.declared
                and one.lower() not in self.types
                and one not in SPEEDS
                and one not in ZONES
            ):
                self.declared[one] = text
                return one
        raise CannotSayError(f"another {kind}", "a thousand of them have names of their own")

    def declarations(self) -> list[str]:
        """The speeds and zones that were missing, as constants."""
        return [f"CONST {text.format(name)}" for name, text in self.declared.items()]

    def _tool(self, s: st.Move) -> str:
        if s.tool is None:
            raise CannotSayError("a move without a tool")
        if not self.own and self.type_of(s.tool) == "wobjdata":
            raise CannotSayError("a tool that is a work object of other moves")
        return s.tool.name if isinstance(s.tool, ex.Named) else self.value(s.tool)

    def _work_object(self, s: st.Move) -> str:
        if s.frame is None or (isinstance(s.frame, ex.FrameRef) and s.frame.kind in ("base", "robot")):
            return ""
        return f"\\WObj:={s.frame.name if isinstance(s.frame, ex.Named) else self.value(s.frame)}"

    # --- with options and processes -----------------------------------------------------------------------------

    def _with_process(self, s: st.Move) -> str:
        """The arguments in the order of their roles, each with its options."""
        if not self.own:
            names = ", ".join(name or "a value" for name, _ in s.other)
            raise CannotSayError(f"{names} of another language")
        word = s.other[0][0] if s.other[0][1] == ex.SignalState(True) and OWN not in s.other[0][0] else ""
        if not word:
            word = self._word(s, s.targets[0])
        layout = LAYOUTS[word.lower()]
        extras, options, leading = self._sorted(s.other, word)
        head, tail = layout.head.replace("x", ""), layout.tail
        parts = [self._role(role, s, options) for role in head]
        ending = [self._role(role, s, options) for role in tail]
        before = layout.head.startswith("x")
        middle = [*extras, *parts] if before else [*parts, *extras]
        conc = "\\Conc," if s.no_wait else ""
        return f"{word} {conc}{leading}{','.join([*middle, *ending])};"

    def _sorted(
        self, other: tuple[tuple[str, ex.Expression], ...], word: str
    ) -> tuple[list[str], dict[str, str], str]:
        """Extra arguments with their options, options by the role of their argument, and options in front."""
        extras: list[str] = []
        options: dict[str, str] = {}
        leading = ""
        behind_extra = False
        for name, value in other:
            role, mark, option = name.partition(OWN)
            if name == word and value == ex.SignalState(True):
                continue
            if not mark:
                extras.append(self.value(value))
                behind_extra = True
                continue
            given = value if isinstance(value, ex.NamedArgument) else ex.NamedArgument(option, value)
            text = self.option(given)
            if role:
                options[role] = options.get(role, "") + text
            elif behind_extra and not word.lower().startswith("search"):
                extras[-1] += text
            else:
                leading += f"{text},"
        return extras, options, leading

    def _role(self, role: str, s: st.Move, options: dict[str, str]) -> str:
        text = {
            "t": lambda: self._position(s.targets[0]),
            "j": lambda: self._position(s.targets[0]),
            "v": lambda: "" if s.via is None else self._position(s.via),
            "s": lambda: self._speed(s),
            "z": lambda: self._blend(s.blend),
            "o": lambda: self._tool(s) + self._work_object(s),
        }[role]()
        return text + options.get(role, "")


def _refuse_what_is_not_said(s: st.Move) -> None:
    if _READ_RARE(s) == _NO_RARE and len(s.targets) == 1:
        return
    lost = {
        "a second control group": bool(s.parts),
        "an acceleration of this move alone": s.rate is not None,
        "a relative move": s.relative is not None,
        "a search": s.search is not None,
        "a condition that ends the move": s.until is not None,
        "an arc by its angle": s.arc is not None,
        "an offset": s.offset is not None or s.tool_offset is not None,
        "a move of several mechanisms": len(s.targets) != 1,
        "motion relative to a station": s.coordinated,
    }
    found = [what for what, lossy in lost.items() if lossy]
    if found:
        raise CannotSayError(", ".join(found))


def _as_name(value: float) -> str:
    """12.5 as 12_5."""
    return decimal(value).replace(".", "_").replace("-", "m")
