"""Lowers move lines: MOVx, IMOV, SMOVx, REFP with their tags and second parts."""

from __future__ import annotations

from typing import Any, Final, NamedTuple

from lark import Token

from olp.core.units import mm
from olp.ir.expressions import FrameRef, Number, Position
from olp.ir.program import (
    Blend,
    BlendKind,
    Move,
    MovePart,
    Path,
    Reference,
    Search,
    SetSpeed,
    Speed,
    SpeedUnit,
)
from olp.languages.lark_host import BrokenLineError
from olp.languages.vendors.inform import values
from olp.languages.vendors.inform.expressions import InformExpressionRules, checked

PATHS: Final = {"J": Path.JOINT, "L": Path.LINEAR, "C": Path.CIRCULAR, "S": Path.SPLINE}
_SPEED_WORDS = {unit: f"{word}=" for word, (unit, _, _) in values.SPEEDS.items()}
_FRAME_WORDS = {"base": "BF", "robot": "RF", "tool": "TF", "master-tool": "MTF", "user": "UF#"}
_SENTENCES = {
    "speed": "speed",
    "blend": "position level",
    "acceleration": "acceleration",
    "deceleration": "deceleration",
    "relative": "coordinate system",
    "search": "search",
    "until": "UNTIL",
    "passes": "pass",
    "end_of_arc": "FPT",
    "no_wait": "NWAIT",
}
_CONTINUOUS = Blend(BlendKind.CONTINUOUS)


class MoveTag(NamedTuple):
    """One word after a move's positions: a field of Move, its value, and how it begins in the line."""

    field: str
    value: Any
    word: str


def _level(written: Any) -> Blend:
    """PL=n."""
    if type(written) is Number and written.value not in range(9):
        raise BrokenLineError(f"a position level of {written.value}", word="PL=", wanted="0 to 8")
    return Blend(BlendKind.LEVEL, values.quantity(written, values.LEVEL))


def _check_speed(speed: Speed) -> None:
    """The leading group's speed times the move: it cannot be 0."""
    checked(speed.value, _SPEED_WORDS[speed.unit], "a speed")


class InformMoveRules(InformExpressionRules):
    def move(self, children: list[Any]) -> Move:
        word, rest = children[0], children[1:]
        targets, tags, parts = _sorted(rest)
        fields = _fields(tags)
        if "speed" in fields:
            _check_speed(fields["speed"])
        other = tuple(tag.value for tag in tags if tag.field == "other")
        if other:
            fields["other"] = other
        if word == "IMOV":
            fields.setdefault("relative", FrameRef("own"))
            spoken = fields.get("speed")
            joint = spoken is not None and spoken.unit is SpeedUnit.FRACTION
            path = Path.JOINT if joint else Path.LINEAR
        elif "relative" in fields:
            wrong = next(tag.word for tag in tags if tag.field == "relative")
            raise BrokenLineError(
                "a coordinate system belongs to IMOV only", word=wrong, wanted="no coordinate system"
            )
        else:
            path = PATHS[word[-1]]
        if word[0] == "S":
            fields["coordinated"] = True
        return Move(0, path, targets, parts=parts, **fields)

    def part(self, children: list[Any]) -> MovePart:
        _, word, *rest = children
        if word[:3] != "MOV":
            raise BrokenLineError(
                f"{word} cannot be the second part of a move", word=f"+{word}", wanted="MOVJ, MOVL or REFP"
            )
        targets, tags, _ = _sorted(rest)
        return MovePart(PATHS[word[-1]], targets, **_fields(tags))

    def reference_part(self, children: list[Any]) -> MovePart:
        return MovePart(None, tuple(children[2:]))

    def reference(self, children: list[Any]) -> Reference:
        word, number, *rest = children
        parts = tuple(part for part in rest if type(part) is MovePart)
        targets = tuple(part for part in rest if type(part) is not MovePart)
        return Reference(0, number, targets, parts, coordinated=word[0] == "S")

    def set_speed(self, children: list[Speed]) -> SetSpeed:
        for speed in children:
            _check_speed(speed)
        return SetSpeed(0, tuple(children))

    def level(self, children: list[Any]) -> MoveTag:
        return MoveTag("blend", _level(children[1]), "PL=")

    def rate(self, children: list[Any]) -> MoveTag:
        field = "acceleration" if children[0] == "ACC=" else "deceleration"
        rate = checked(values.quantity(children[1], values.RATE), children[0], "a rate")
        return MoveTag(field, rate, str(children[0]))

    def radius(self, children: list[Any]) -> MoveTag:
        return MoveTag("blend", Blend(BlendKind.RADIUS, values.quantity(children[1], (mm, mm))), "CR=")

    def other(self, children: list[Any]) -> MoveTag:
        return MoveTag("other", (str(children[0])[:-1], children[1]), str(children[0]))

    def continuous(self, _: list[Token]) -> MoveTag:
        return MoveTag("blend", _CONTINUOUS, "CONT")

    def end_of_arc(self, _: list[Token]) -> MoveTag:
        return MoveTag("end_of_arc", True, "FPT")

    def no_wait(self, children: list[Token]) -> MoveTag:
        return MoveTag("no_wait", True, str(children[0]))

    def passes(self, children: list[Token]) -> MoveTag:
        return MoveTag("passes", str(children[0]), str(children[0]))

    def relative(self, children: list[FrameRef]) -> MoveTag:
        return MoveTag("relative", children[0], _FRAME_WORDS[children[0].kind])

    def search(self, children: list[Any]) -> MoveTag:
        signal, _, state, time, _, distance = children
        travel = None if distance is None else values.quantity(distance, values.DISTANCE)
        return MoveTag("search", Search(signal, state == "ON", time, travel), "SRCH")

    def until(self, children: list[Any]) -> MoveTag:
        return MoveTag("until", children[0], "UNTIL")


def _sorted(rest: list[Any]) -> tuple[tuple[Position, ...], list[MoveTag], tuple[MovePart, ...]]:
    targets, tags, parts = [], [], []
    for item in rest:
        kind = type(item)
        if kind is MoveTag:
            tags.append(item)
        elif kind is Speed:
            tags.append(MoveTag("speed", item, _SPEED_WORDS[item.unit]))
        elif kind is MovePart:
            parts.append(item)
        else:
            targets.append(item)
    return tuple(targets), tags, tuple(parts)


def _fields(tags: list[MoveTag]) -> dict[str, Any]:
    fields: dict[str, Any] = {}
    for tag in tags:
        if tag.field == "other":
            continue
        if tag.field in fields:
            message = f"a second {_SENTENCES[tag.field]} in one line"
            raise BrokenLineError(message, word=tag.word, wanted=f"one {_SENTENCES[tag.field]}")
        fields[tag.field] = tag.value
    return fields
