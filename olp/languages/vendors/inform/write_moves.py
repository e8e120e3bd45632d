"""Writes motion: MOVx, IMOV, SMOVx, REFP and SPEED with their tags and second parts."""

from __future__ import annotations

from typing import Final

from olp.core.units import mm
from olp.ir import program as st
from olp.languages.generator import CannotSayError, Lines
from olp.languages.vendors.inform import values
from olp.languages.vendors.inform.write_values import InformValues

_LETTERS: Final = {st.Path.JOINT: "J", st.Path.LINEAR: "L", st.Path.CIRCULAR: "C", st.Path.SPLINE: "S"}
_TAGS: Final = {st.SpeedUnit.TRAVEL: ("V", 1), st.SpeedUnit.FRACTION: ("VJ", 2), st.SpeedUnit.TURN: ("VR", 1)}


class InformMoves(InformValues):
    """Writes motion."""

    def _speed(self, speed: st.Speed) -> str:
        """`V=187.0`."""
        if speed.unit not in _TAGS:
            raise CannotSayError("a speed of this unit", "INFORM has V= in mm/s, VR= in °/s and VJ= in %")
        tag, decimals = _TAGS[speed.unit]
        _, literal, counted = values.SPEEDS[tag]
        return f"{tag}={self.amount(speed.value, (literal, counted), decimals)}"

    def write_move(self, s: st.Move) -> Lines:
        words = [self._word(s), *map(self.single, s.targets)]
        if s.passes:
            words.append(s.passes)
        if s.speed is not None:
            words.append(self.once(s.speed, self._speed))
        if s.blend is not None:
            words.append(self._blend(s.blend))
        if not _is_plain(s):
            words += self._tags(s)
        text = " ".join(words)
        return text + "".join(map(self._part, s.parts)) if s.parts else text

    def _word(self, s: st.Move) -> str:
        if s.relative is None:
            return f"{'S' if s.coordinated else ''}MOV{_LETTERS[s.path]}"
        joint = s.speed is not None and s.speed.unit is st.SpeedUnit.FRACTION
        if s.coordinated or s.path is not (st.Path.JOINT if joint else st.Path.LINEAR):
            raise CannotSayError(
                "a relative move of this shape", "IMOV moves linearly with V=, or by axes with VJ="
            )
        return "IMOV"

    def _blend(self, blend: st.Blend) -> str:
        kind, value = blend.kind, blend.value
        if kind is st.BlendKind.CONTINUOUS or value is None:
            return "CONT"
        if kind is st.BlendKind.LEVEL:
            return f"PL={self.amount(value, values.LEVEL, 0)}"
        return f"CR={self.amount(value, (mm, mm), 1)}"

    def _tags(self, s: st.Move) -> list[str]:
        """The rarer ones, in the order that controllers write them in."""
        quantity = self.amount
        found = [f"{tag}={self.single(value)}" for tag, value in s.other]
        if s.acceleration is not None:
            found.append(f"ACC={quantity(s.acceleration, values.RATE, 0)}")
        if s.deceleration is not None:
            found.append(f"DEC={quantity(s.deceleration, values.RATE, 0)}")
        if s.end_of_arc:
            found.append("FPT")
        if s.relative is not None and s.relative.kind != "own":
            found.append(self.value(s.relative))
        if s.search is not None:
            found.append(self._search(s))
        if s.no_wait:
            found.append("NWAIT")
        if s.until is not None:
            found.append(f"UNTIL {self.joined(s.until, express=False)}")
        return found

    def _search(self, s: st.Move) -> str:
        assert s.search is not None
        signal, on, time, distance = s.search
        text = f"SRCH {self.signal(signal)}={'ON' if on else 'OFF'}"
        if time is not None:
            text += f" T={self.amount(time, values.TIME, 2)}"
        if distance is not None:
            text += f" DIS={self.amount(distance, values.DISTANCE, 1)}"
        return text

    def _part(self, part: st.MovePart) -> str:
        word = "REFP" if part.path is None else f"MOV{_LETTERS[part.path]}"
        speed = "" if part.speed is None else f" {self._speed(part.speed)}"
        blend = "" if part.blend is None else f" {self._blend(part.blend)}"
        return f"  +{word} {' '.join(map(self.single, part.targets))}{speed}{blend}"

    def write_reference(self, s: st.Reference) -> Lines:
        targets = " ".join(map(self.single, s.targets))
        word = "SREFP" if s.coordinated else "REFP"
        return f"{word} {self.single(s.number)} {targets}{''.join(map(self._part, s.parts))}"

    def write_set_speed(self, s: st.SetSpeed) -> Lines:
        return " ".join(["SPEED", *map(self._speed, s.speeds)])


def _is_plain(s: st.Move) -> bool:
    return (
        s.relative is None
        and s.search is None
        and s.until is None
        and s.acceleration is None
        and s.deceleration is None
        and not (s.end_of_arc or s.no_wait or s.other)
    )
