"""Spells moves: the word and its arguments, the frame by `pose_trans`, the tool by `set_tcp` where it changes."""

from __future__ import annotations

from operator import attrgetter
from typing import Final

from olp import called
from olp.expression import Expression, FrameRef, Function, Number, State
from olp.moves import AccelerationUnit, Blend, BlendKind, Move, Path, SpeedUnit
from olp.vendors.urscript.write_values import CannotSayError, Words

_JOINT = {SpeedUnit.AXIS: "movej", SpeedUnit.TIME: "movej", SpeedUnit.FRACTION: "optimovej"}
_LINEAR = {SpeedUnit.TRAVEL: "movel", SpeedUnit.TIME: "movel", SpeedUnit.FRACTION: "optimovel"}
_OWN_TAGS: Final = frozenset({"t", "v", "mode", "process"})
_UNITS: Final = {"movej": AccelerationUnit.AXIS}
_NOT_SAID: Final = (
    ("search", "a search"),
    ("until", "a move that ends early"),
    ("relative", "a relative move"),
    ("offset", "an offset of a move"),
    ("tool_offset", "an offset in the tool's axes"),
    ("turn", "a bound on the tool's turning"),
    ("arc", "an arc by its angle"),
    ("parts", "what another group does meanwhile"),
    ("deceleration", "a deceleration of its own"),
    ("no_wait", "a move that is not waited for"),
)
_rare = attrgetter(*(name for name, _ in _NOT_SAID))


class MoveWriter:
    """Spells the moves of one routine. Arguments that moves share are spelled once."""

    def __init__(self, words: Words) -> None:
        self._words = words
        self._manners: dict[tuple[object, ...], tuple[str, str]] = {}
        self._kept: list[Move] = []  # whose parts some of the keys name

    def move(self, s: Move) -> str:
        """The move as a call. Raises CannotSayError."""
        key = _key(s)
        found = self._manners.get(key)
        if found is None:
            found = self._manners[key] = self._manner(s)
            self._kept.append(s)
        if any(_rare(s)):
            raise CannotSayError(next(what for name, what in _NOT_SAID if getattr(s, name)))
        if len(s.targets) != 1:
            raise CannotSayError("a move of more than one mechanism")
        word, arguments = found
        target = self.place(s.targets[0], s.frame)
        if s.via is not None:
            target = f"{self.place(s.via, s.frame)}, {target}"
        return f"{word}({target}{arguments})"

    def place(self, e: Expression, frame: Expression | None) -> str:
        """A target, seen from the base. Raises CannotSayError."""
        if (
            frame is None
            or (type(frame) is FrameRef and frame.kind == "base")
            or self._words.kind(e) == "joints"
        ):
            if type(e) is not Function or e.name != "inverse" or frame is None or type(frame) is FrameRef:
                return self._words.value(e)
            pose, *rest = e.arguments
            return self._words.value(Function("inverse", (Function("pose-product", (frame, pose)), *rest)))
        return f"pose_trans({self._words.value(frame)}, {self._words.value(e)})"

    def _manner(self, s: Move) -> tuple[str, str]:
        word = self._word(s)
        other = dict(s.other)
        unknown = other.keys() - _OWN_TAGS if self._words.own else other.keys()
        if unknown:
            raise CannotSayError(f"{', '.join(sorted(unknown))} of a move")
        arguments = [*self._rate(s, word), *self._speed(s, other), *self._blend(s.blend)]
        if "mode" in other:
            arguments.append(f"mode={self._words.value(other['mode'])}")
        return word, "".join(f", {one}" for one in arguments)

    def _word(self, s: Move) -> str:
        if s.speed is None:
            raise CannotSayError("a move without a speed", "name one")
        if s.path is Path.CIRCULAR and s.via is None:
            raise CannotSayError("an arc through points of several moves")
        words = {Path.JOINT: _JOINT, Path.LINEAR: _LINEAR, Path.CIRCULAR: {SpeedUnit.TRAVEL: "movec"}}.get(
            s.path
        )
        if words is None:
            raise CannotSayError("a spline")
        word = words.get(s.speed.unit)
        if word is None:
            raise CannotSayError(f"a {s.path} move with {called.SPEEDS[s.speed.unit]}")
        return "movep" if ("process", State(True)) in s.other and word == "movel" else word

    def _rate(self, s: Move, word: str) -> list[str]:
        if word.startswith("optimove"):
            return [] if s.acceleration is None else [f"a={self._words.quantity(s.acceleration)}"]
        if s.acceleration is not None:
            raise CannotSayError("an acceleration as a share of the rated one")
        if s.rate is None:
            return []
        if s.rate.unit is not _UNITS.get(word, AccelerationUnit.TRAVEL):
            raise CannotSayError(f"{called.ACCELERATIONS[s.rate.unit]} of a {s.path} move")
        return [f"a={self._words.quantity(s.rate.value)}"]

    def _speed(self, s: Move, other: dict[str, Expression]) -> list[str]:
        assert s.speed is not None  # `_word` has looked
        value = self._words.quantity(s.speed.value)
        if s.speed.unit is SpeedUnit.TIME:
            speed = [f"v={self._words.value(other['v'])}"] if "v" in other else []
            return [*speed, f"t={value}"]
        time = [f"t={self._words.value(other['t'])}"] if "t" in other else []
        return [f"v={value}", *time]

    def _blend(self, blend: Blend | None) -> list[str]:
        if blend is None or blend.kind is not BlendKind.RADIUS or blend.value is None:
            raise CannotSayError("a blend that is no radius")
        if blend.value.written in (Number(0), Number(0.0)):
            return []
        return [f"r={self._words.quantity(blend.value)}"]


def _key(s: Move) -> tuple[object, ...]:
    """Equal for moves that go the same way: numbers where all are written out, else the parts themselves."""
    speed, blend, rate = s.speed, s.blend, s.rate
    if speed is not None and blend is not None and blend.value is not None and not s.other:
        numbers = (speed.value.literal, blend.value.literal, 0.0 if rate is None else rate.value.literal)
        if s.acceleration is None and None not in numbers:
            unit = None if rate is None else rate.unit
            return (s.path, speed.unit, blend.kind, unit, s.via is None, speed.value.scale, *numbers)
    parts = (speed, blend, rate, s.acceleration, s.other)
    return (s.path, s.via is None, *map(id, parts))
