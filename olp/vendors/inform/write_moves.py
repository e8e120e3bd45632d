"""Spells motion: MOVx, IMOV, SMOVx, REFP and SPEED with their tags and second parts."""

from __future__ import annotations

from typing import Final

from olp.program import Blend, BlendKind, Move, MovePart, Path, Reference, SetSpeed, Speed, SpeedUnit
from olp.units import mm
from olp.vendors.inform import values
from olp.vendors.inform.write_values import CannotSayError, Words

_LETTERS: Final = {Path.JOINT: "J", Path.LINEAR: "L", Path.CIRCULAR: "C", Path.SPLINE: "S"}
_TAGS: Final = {SpeedUnit.TRAVEL: ("V", 1), SpeedUnit.FRACTION: ("VJ", 2), SpeedUnit.TURN: ("VR", 1)}


class MoveWriter:
    """Keeps the texts of speeds and blends, which the moves of a job share."""

    def __init__(self, words: Words) -> None:
        self.words = words
        self._speeds: dict[int, tuple[Speed, str]] = {}

    def speed(self, speed: Speed) -> str:
        """`V=187.0`."""
        known = self._speeds.get(id(speed))
        if known is not None:
            return known[1]
        if speed.unit not in _TAGS:
            raise CannotSayError("a speed of this unit", "INFORM has V= in mm/s, VR= in °/s and VJ= in %")
        tag, decimals = _TAGS[speed.unit]
        _, literal, counted = values.SPEEDS[tag]
        text = f"{tag}={self.words.quantity(speed.value, (literal, counted), decimals)}"
        self._speeds[id(speed)] = (speed, text)  # the object is kept, so that its id stays its own
        return text

    def move(self, s: Move) -> str:
        words = [self._word(s), *map(self.words.position, s.targets)]
        if s.passes:
            words.append(s.passes)
        if s.speed is not None:
            words.append(self.speed(s.speed))
        if s.blend is not None:
            words.append(self._blend(s.blend))
        if not _is_plain(s):
            words += self._tags(s)
        text = " ".join(words)
        return text + "".join(map(self._part, s.parts)) if s.parts else text

    def _word(self, s: Move) -> str:
        if s.relative is None:
            return f"{'S' if s.coordinated else ''}MOV{_LETTERS[s.path]}"
        joint = s.speed is not None and s.speed.unit is SpeedUnit.FRACTION
        if s.coordinated or s.path is not (Path.JOINT if joint else Path.LINEAR):
            raise CannotSayError(
                "a relative move of this shape", "IMOV moves linearly with V=, or by axes with VJ="
            )
        return "IMOV"

    def _blend(self, blend: Blend) -> str:
        kind, value = blend.kind, blend.value
        if kind is BlendKind.CONTINUOUS or value is None:
            return "CONT"
        if kind is BlendKind.LEVEL:
            return f"PL={self.words.quantity(value, values.LEVEL, 0)}"
        return f"CR={self.words.quantity(value, (mm, mm), 1)}"

    def _tags(self, s: Move) -> list[str]:
        """The rarer ones, in the order that controllers write them in."""
        quantity = self.words.quantity
        found = [f"{tag}={self.words.value(value)}" for tag, value in s.other]
        if s.acceleration is not None:
            found.append(f"ACC={quantity(s.acceleration, values.RATE, 0)}")
        if s.deceleration is not None:
            found.append(f"DEC={quantity(s.deceleration, values.RATE, 0)}")
        if s.end_of_arc:
            found.append("FPT")
        if s.relative is not None and s.relative.kind != "own":
            found.append(self.words.frame(s.relative))
        if s.search is not None:
            found.append(self._search(s))
        if s.no_wait:
            found.append("NWAIT")
        if s.until is not None:
            found.append(f"UNTIL {self.words.condition(s.until, express=False)}")
        return found

    def _search(self, s: Move) -> str:
        assert s.search is not None
        signal, on, time, distance = s.search
        text = f"SRCH {self.words.signal(signal)}={'ON' if on else 'OFF'}"
        if time is not None:
            text += f" T={self.words.quantity(time, values.TIME, 2)}"
        if distance is not None:
            text += f" DIS={self.words.quantity(distance, values.DISTANCE, 1)}"
        return text

    def _part(self, part: MovePart) -> str:
        word = "REFP" if part.path is None else f"MOV{_LETTERS[part.path]}"
        speed = "" if part.speed is None else f" {self.speed(part.speed)}"
        blend = "" if part.blend is None else f" {self._blend(part.blend)}"
        return f"  +{word} {' '.join(map(self.words.position, part.targets))}{speed}{blend}"

    def reference(self, s: Reference) -> str:
        targets = " ".join(map(self.words.position, s.targets))
        word = "SREFP" if s.coordinated else "REFP"
        return f"{word} {self.words.value(s.number)} {targets}{''.join(map(self._part, s.parts))}"

    def set_speed(self, s: SetSpeed) -> str:
        return " ".join(["SPEED", *map(self.speed, s.speeds)])


def _is_plain(s: Move) -> bool:
    return (
        s.relative is None
        and s.search is None
        and s.until is None
        and s.acceleration is None
        and s.deceleration is None
        and not (s.end_of_arc or s.no_wait or s.other)
    )
