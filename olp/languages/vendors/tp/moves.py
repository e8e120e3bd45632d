"""Lowers motion instructions: speed, termination and options of a J, L, C, A or S line."""

from __future__ import annotations

from typing import Any, NamedTuple

from lark import Token

from olp.core.units import mm
from olp.ir.expressions import Expression, FrameRef, Number, Quantity, SystemValue, Text
from olp.ir.program import Blend, Move, Speed, SpeedUnit
from olp.languages.lark_host import BrokenLineError
from olp.languages.vendors.tp import values
from olp.languages.vendors.tp.expressions import TpValueRules

OWN = FrameRef(
    "own"
)  # an incremental position is added in its own kind: joints to joints, a pose along its frame
WELD_SPEED = SystemValue("weld-speed")


class TpMoveOption(NamedTuple):
    """One option of a move: the field of `Move` that it sets, "" for one that is kept as written."""

    field: str
    value: Any


class TpMoveRules(TpValueRules):
    """Motion."""

    def position(self, children: list[Expression]) -> Expression:
        return children[0]

    def motion(self, children: list[Any]) -> Move:
        letter = str(children[0])
        positions = [one for one in children[1:3] if one is not None]
        speed, corner = children[3], children[4]
        options: list[TpMoveOption] = [one for one in children[5:] if one is not None]
        path = values.PATHS[letter]
        if (len(positions) == 2) != (letter == "C"):
            wanted = "two positions, as in C P[1] P[2] 100mm/sec FINE" if letter == "C" else "one position"
            raise BrokenLineError(f"a {letter} move with {len(positions)} positions", wanted=wanted)
        if speed is None:
            raise BrokenLineError("a move without a speed", wanted="a speed such as 100mm/sec or 50%")
        if corner is None:
            raise BrokenLineError("a move without a termination", wanted="FINE or CNT0 .. CNT100")
        fields: dict[str, Any] = {one.field: one.value for one in options if one.field}
        other = [one.value for one in options if not one.field]
        return Move(
            0,
            path,
            (positions[-1],),
            speed,
            corner,
            via=positions[0] if letter == "C" else None,
            other=tuple(other),
            **fields,
        )

    # --- speed ------------------------------------------------------------------------------------------

    def speed(self, children: list[Any]) -> Speed:
        if isinstance(children[0], Token):
            if children[0].type == "WELD_SPEED":
                return Speed(SpeedUnit.TRAVEL, Quantity(WELD_SPEED, mm), "WELD_SPEED")
            return Speed(SpeedUnit.TRAVEL, Quantity(Number(values.FASTEST_LINE), mm), "max_speed")
        value, word = children
        unit, scale = values.UNITS[str(word)]
        if isinstance(value, Number) and not value.value > 0:
            raise BrokenLineError("a speed that is not positive", wanted="a number above 0")
        return Speed(unit, Quantity(value, scale))

    def termination(self, children: list[Any]) -> Blend:
        word = str(children[0])
        if word == "FINE":
            return values.FINE
        kind, scale = values.CORNERS[word]
        if len(children) == 1 or children[1] is None:
            raise BrokenLineError(f"{word} without its number", wanted=f"{word}50")
        native = "" if word == "CNT" else word
        if len(children) > 2 and children[2] is not None:
            native = f"{word},{_literal(children[2])}"
        return Blend(kind, Quantity(children[1], scale), native)

    # --- options ----------------------------------------------------------------------------------------

    def acceleration(self, children: list[Any]) -> TpMoveOption:
        return TpMoveOption("acceleration", Quantity(children[1], values.PERCENT))

    def offset(self, children: list[Any]) -> TpMoveOption:
        if len(children) == 1 or children[1] is None:
            return TpMoveOption("", ("Offset", Text("")))
        return TpMoveOption("offset", children[1])

    def tool_offset(self, children: list[Any]) -> TpMoveOption:
        if len(children) == 1 or children[1] is None:
            return TpMoveOption("", ("Tool_Offset", Text("")))
        return TpMoveOption("tool_offset", children[1])

    def incremental(self, _: list[Any]) -> TpMoveOption:
        return TpMoveOption("relative", OWN)

    def other(self, children: list[Token]) -> TpMoveOption:
        return kept(str(children[0]))


def kept(text: str) -> TpMoveOption:
    """An option that is not modelled: its first word, and the rest as written."""
    text = " ".join(text.split())
    length = next((at for at, char in enumerate(text) if not (char.isalpha() or char in "_-")), len(text))
    return TpMoveOption("", (text[:length], Text(text[length:])))


def _literal(value: Expression) -> str:
    if not isinstance(value, Number):
        raise BrokenLineError("a register as the second number of a corner", wanted="a number, as in CR5,10")
    return str(value.value)
