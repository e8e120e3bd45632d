"""Writes moves: the word and its arguments, the frame by `pose_trans`, the tool by `set_tcp` where it changes."""

from __future__ import annotations

from typing import ClassVar, Final

from olp.ir import expressions as ex
from olp.ir import program as st
from olp.ir import terminology
from olp.languages.generator import CannotSayError, Lines
from olp.languages.vendors.urscript.write_values import UrscriptValues

_JOINT = {st.SpeedUnit.AXIS: "movej", st.SpeedUnit.TIME: "movej", st.SpeedUnit.FRACTION: "optimovej"}
_LINEAR = {st.SpeedUnit.TRAVEL: "movel", st.SpeedUnit.TIME: "movel", st.SpeedUnit.FRACTION: "optimovel"}
_OWN_TAGS: Final = frozenset({"t", "v", "mode", "process"})
_UNITS: Final = {"movej": st.AccelerationUnit.AXIS}


class UrscriptMoves(UrscriptValues):
    """Writes moves and the tools before them. Arguments that moves share are spelled once."""

    cannot: ClassVar = {
        st.Move: {
            "search": "a search",
            "until": "a move that ends early",
            "relative": "a relative move",
            "offset": "an offset of a move",
            "tool_offset": "an offset in the tool's axes",
            "turn": "a bound on the tool's turning",
            "arc": "an arc by its angle",
            "parts": "what another group does meanwhile",
            "deceleration": "a deceleration of its own",
            "no_wait": "a move that is not waited for",
        }
    }

    def __init__(self, program: st.Program) -> None:
        super().__init__(program)
        self._manners: dict[tuple[object, ...], tuple[str, str]] = {}
        self._kept: list[st.Move] = []  # whose parts some of the keys name

    def forget(self) -> None:
        self._tool: str | None = None  # what set_tcp holds as far as the text tells, None: unknown
        self._given: ex.Expression | None = None  # the tool of the last move, which the next one shares

    def write_move(self, s: st.Move) -> Lines:
        """set_tcp where the tool changes, and the move."""
        lines = []
        if s.tool is not None and (s.tool is not self._given or self._tool is None):
            wanted = self.tool(s.tool)
            self._given = s.tool
            if wanted != self._tool:
                lines.append(f"set_tcp({wanted})")
                self._tool = wanted
        lines.append(self._move(s))
        return lines

    def tool(self, e: ex.Expression) -> str:
        """The arguments of set_tcp."""
        text = self.value(e)
        name = dict(e.native).get("name", "") if self.own and type(e) is ex.PositionLiteral else ""
        return f'{text}, "{name}"' if name else text

    def _move(self, s: st.Move) -> str:
        key = _key(s)
        found = self._manners.get(key)
        if found is None:
            found = self._manners[key] = self._manner(s)
            self._kept.append(s)
        if len(s.targets) != 1:
            raise CannotSayError("a move of more than one mechanism")
        word, arguments = found
        target = self.place(s.targets[0], s.frame)
        if s.via is not None:
            target = f"{self.place(s.via, s.frame)}, {target}"
        return f"{word}({target}{arguments})"

    def place(self, e: ex.Expression, frame: ex.Expression | None) -> str:
        """A target, seen from the base. Raises CannotSayError."""
        if frame is None or (type(frame) is ex.FrameRef and frame.kind == "base") or self.kind(e) == "joints":
            if (
                type(e) is not ex.Function
                or e.name != "inverse"
                or frame is None
                or type(frame) is ex.FrameRef
            ):
                return self.value(e)
            pose, *rest = e.arguments
            return self.value(ex.Function("inverse", (ex.Function("pose-product", (frame, pose)), *rest)))
        return f"pose_trans({self.value(frame)}, {self.value(e)})"

    def _manner(self, s: st.Move) -> tuple[str, str]:
        word = self._word(s)
        other = dict(s.other)
        unknown = other.keys() - _OWN_TAGS if self.own else other.keys()
        if unknown:
            raise CannotSayError(f"{', '.join(sorted(unknown))} of a move")
        arguments = [*self._rate(s, word), *self._speed(s, other), *self._blend(s.blend)]
        if "mode" in other:
            arguments.append(f"mode={self.value(other['mode'])}")
        return word, "".join(f", {one}" for one in arguments)

    def _word(self, s: st.Move) -> str:
        if s.speed is None:
            raise CannotSayError("a move without a speed", "name one")
        if s.path is st.Path.CIRCULAR and s.via is None:
            raise CannotSayError("an arc through points of several moves")
        words = {
            st.Path.JOINT: _JOINT,
            st.Path.LINEAR: _LINEAR,
            st.Path.CIRCULAR: {st.SpeedUnit.TRAVEL: "movec"},
        }.get(s.path)
        if words is None:
            raise CannotSayError("a spline")
        word = words.get(s.speed.unit)
        if word is None:
            raise CannotSayError(f"a {s.path} move with {terminology.SPEEDS[s.speed.unit]}")
        return "movep" if ("process", ex.SignalState(True)) in s.other and word == "movel" else word

    def _rate(self, s: st.Move, word: str) -> list[str]:
        if word.startswith("optimove"):
            return [] if s.acceleration is None else [f"a={self.quantity(s.acceleration)}"]
        if s.acceleration is not None:
            raise CannotSayError("an acceleration as a share of the rated one")
        if s.rate is None:
            return []
        if s.rate.unit is not _UNITS.get(word, st.AccelerationUnit.TRAVEL):
            raise CannotSayError(f"{terminology.ACCELERATIONS[s.rate.unit]} of a {s.path} move")
        return [f"a={self.quantity(s.rate.value)}"]

    def _speed(self, s: st.Move, other: dict[str, ex.Expression]) -> list[str]:
        assert s.speed is not None  # `_word` has looked
        value = self.quantity(s.speed.value)
        if s.speed.unit is st.SpeedUnit.TIME:
            speed = [f"v={self.value(other['v'])}"] if "v" in other else []
            return [*speed, f"t={value}"]
        time = [f"t={self.value(other['t'])}"] if "t" in other else []
        return [f"v={value}", *time]

    def _blend(self, blend: st.Blend | None) -> list[str]:
        if blend is None or blend.kind is not st.BlendKind.RADIUS or blend.value is None:
            raise CannotSayError("a blend that is no radius")
        if blend.value.written in (ex.Number(0), ex.Number(0.0)):
            return []
        return [f"r={self.quantity(blend.value)}"]


def _key(s: st.Move) -> tuple[object, ...]:
    """Equal for moves that go the same way: numbers where all are written out, else the parts themselves."""
    speed, blend, rate = s.speed, s.blend, s.rate
    if speed is not None and blend is not None and blend.value is not None and not s.other:
        numbers = (speed.value.literal, blend.value.literal, 0.0 if rate is None else rate.value.literal)
        if s.acceleration is None and None not in numbers:
            unit = None if rate is None else rate.unit
            return (s.path, speed.unit, blend.kind, unit, s.via is None, speed.value.scale, *numbers)
    parts = (speed, blend, rate, s.acceleration, s.other)
    return (s.path, s.via is None, *map(id, parts))
