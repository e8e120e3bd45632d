"""Steps as the pendant teaches them: `JOINT SPEED9 ACCU1 TIMER0 TOOL1 WORK0 CLAMP1 (OFF,0,0,O) OX= WX= #[...] ;`.

Each names its path, levels of speed, accuracy and time, tool, work, clamps, outputs (OX) and inputs (WX). The clamps,
outputs, the time and the inputs come at the end of the move. What a level is stands in the tables SPEED, ACCUR, TIMER,
ACCEL and DECEL of the controller (auxiliary functions 0301 to 0303), which a saved file holds as .AUXDATA.

From a forum's explanation of such a step (robot-forum.com, thread 37567), a saved RS005L, and CATIA's manual of its
"Kawasaki AS translator" (block format). Nothing was found of the order at the end of a step.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from typing import Final, NamedTuple

from olp.core.units import mm, percent
from olp.ir.expressions import Expression, FrameRef, Logic, Number, Quantity, Signal, SignalState, Text, Unary
from olp.ir.program import Blend, BlendKind, Dwell, Move, Path, SetOutput, Speed, SpeedUnit, Statement, Wait
from olp.languages.lark_host import BrokenLineError

from .rules import FIRST_OF, FULL_SPEED, BlockStep, bus_of

Levels = Mapping[str, tuple[float, ...]]
# As the controller is delivered: [%], [mm] of the levels 1 to 4, [s], [%], [%].
LEVELS: Final[dict[str, tuple[float, ...]]] = {
    "SPEED": tuple(10.0 * n for n in range(1, 11)),
    "ACCUR": (1.0, 10.0, 50.0, 100.0),
    "TIMER": tuple(n / 10 for n in range(10)),
    "ACCEL": (100.0,) * 10,
    "DECEL": (100.0,) * 10,
}
_PATHS: Final = {
    "JOINT": Path.JOINT, "LINEAR": Path.LINEAR, "LIN2": Path.LINEAR, "CIR1": Path.CIRCULAR, "CIR2": Path.CIRCULAR
}  # fmt: skip
_LEVEL: Final = re.compile(r"(SPEED|ACCU|TIMER|TOOL|WORK)(\d{1,2})", re.IGNORECASE)
_PART: Final = re.compile(r"\([^()]*\)|[^\s()]+")
_NUMBER: Final = re.compile(r"\d+\.?\d*")
_SIGNALS: Final = re.compile(r"(OX|WX)=((?:-?\d{1,4}(?:,-?\d{1,4})*)?)", re.IGNORECASE)
_NOTHING: Final = re.compile(r"CL\d=[-+0.,]*", re.IGNORECASE)  # what a gun is apart from its work: nowhere


class TaughtStep(NamedTuple):
    """`arc`: whether it is the end of an arc, None for other moves. `clamps`: number and state. `assumed`: what is not
    known for certain, kind and message."""

    move: Move
    arc: bool | None
    clamps: tuple[tuple[str, str], ...]
    at_end: tuple[Statement, ...]
    assumed: tuple[tuple[str, str], ...]


def step_of(step: BlockStep, levels: Levels, line: int) -> TaughtStep:
    """The step's move and what it does, with the controller's tables. Raises BrokenLineError."""
    first, *parts = _PART.findall(step.words)
    word = first.upper()
    said = _TaughtWords(word, levels)
    for part in parts:
        said.take(part)
    index, given = said.speed, said.levels
    at_end = tuple(said.at_end(line))
    move = Move(
        line,
        _PATHS[word],
        (step.target,),
        speed=_speed(word, index, said.plain, levels),
        blend=_blend(given.get("ACCU", 1), levels),
        acceleration=_rate("ACCEL", index, levels),
        deceleration=_rate("DECEL", index, levels),
        tool=FrameRef("tool", Number(given.get("TOOL", 0))),
        other=tuple(said.other),
    )
    arc = None if move.path is not Path.CIRCULAR else word == "CIR2"
    return TaughtStep(move, arc, tuple(said.clamps), at_end, tuple(said.assumed(levels, at_end)))


class _TaughtWords:
    """The words of a step."""

    def __init__(self, word: str, levels: Levels) -> None:
        self.word = word
        self.table = levels
        self.levels: dict[str, int] = {}
        self.speed: int | None = None
        self.plain: float | None = None  # a speed that is written out
        self.clamps: list[tuple[str, str]] = []
        self.signals: dict[str, list[int]] = {}
        self.other: list[tuple[str, Expression]] = []
        self._clamp = ""

    def take(self, part: str) -> None:
        level, signals = _LEVEL.fullmatch(part), _SIGNALS.fullmatch(part)
        if level is not None:
            self._level(level[1].upper(), int(level[2]))
        elif signals is not None:
            numbers = [int(one) for one in signals[2].split(",") if one]
            self.signals[signals[1].upper()] = numbers
        elif part[0] == "(":
            state = part[1:-1].split(",")[0].strip().upper()
            self.clamps.append((self._clamp or "1", state))
        elif part.upper().startswith("CLAMP") or (part.isdigit() and self.clamps):
            self._clamp = part.upper().removeprefix("CLAMP")
        elif _NUMBER.fullmatch(part) and self.speed is None and self.plain is None:
            self.plain = float(part)
        elif not _NOTHING.fullmatch(part):
            self.other.append((part, Text("")))

    def _level(self, word: str, number: int) -> None:
        if word == "SPEED":
            self.speed = number
            if number >= len(self.table["SPEED"]):
                raise BrokenLineError(f"there is no SPEED{number}", wanted="SPEED0 to SPEED9")
        if word == "ACCU" and number > len(LEVELS["ACCUR"]):
            raise BrokenLineError(f"there is no ACCU{number}", wanted="ACCU1 to ACCU4")
        if word == "TIMER" and number >= len(self.table["TIMER"]):
            raise BrokenLineError(f"there is no TIMER{number}", wanted="TIMER0 to TIMER9")
        if word == "WORK" and number:
            self.other.append((f"WORK{number}", Text("")))
        self.levels[word] = number

    def at_end(self, line: int) -> Iterator[Statement]:
        for number in self.signals.get("OX", ()):
            bus = bus_of(abs(number))
            signal = Signal(bus, Number(abs(number) - FIRST_OF[bus]))
            yield SetOutput(line, signal, SignalState(number > 0))
        seconds = self.table["TIMER"][self.levels.get("TIMER", 0)]
        if seconds:
            yield Dwell(line, Quantity(Number(seconds), 1.0))
        wanted = [_input(number) for number in self.signals.get("WX", ())]
        if wanted:
            yield Wait(
                line,
                wanted[0]
                if len(wanted) == 1
                else Logic(wanted[0], tuple(("and", one) for one in wanted[1:])),
            )

    def assumed(self, levels: Levels, at_end: tuple[Statement, ...]) -> Iterator[tuple[str, str]]:
        if not levels.get("saved"):
            yield (
                "levels",
                "steps that were taught have the levels of a controller as delivered: SPEED0 to 9 are 10 to 100 %, "
                "ACCU1 to 4 are 1, 10, 50 and 100 mm, TIMER0 to 9 are 0 to 0.9 s",
            )
        if self.levels.get("ACCU") == 0:
            yield "ACCU0", "ACCU0 is taken as a stop"
        if self.word == "JOINT" and self.plain is not None:
            yield "percent", "a speed that a joint step writes out is taken as percent"
        if self.word in ("LIN2", "CIR1", "CIR2"):
            kinds = {"LIN2": "a line", "CIR1": "the point on the way of an arc", "CIR2": "the end of an arc"}
            yield self.word, f"{self.word} is taken as {kinds[self.word]}"
        if self.clamps:
            yield "clamps", "which signals the clamps are is in the controller: they begin OFF"
        if len(at_end) > 1 or self.signals.get("WX"):
            yield "order", "at the end of a step come the clamps, OX, the time, then the wait for WX"


def _input(number: int) -> Expression:
    """WX counts inputs from 1 or from 1001 on."""
    signal = Signal("in", Number(abs(number) - (FIRST_OF["in"] if abs(number) > FIRST_OF["in"] else 0)))
    return signal if number > 0 else Unary("not", signal)


def _speed(word: str, index: int | None, plain: float | None, levels: Levels) -> Speed | None:
    share = plain if index is None else levels["SPEED"][index]
    if share is None:
        return None
    if word == "JOINT":
        return Speed(SpeedUnit.FRACTION, Quantity(Number(share), percent))
    if index is None:
        return Speed(SpeedUnit.TRAVEL, Quantity(Number(share), mm))
    return Speed(SpeedUnit.TRAVEL, Quantity(Number(share), percent * FULL_SPEED), "%")


def _blend(level: int, levels: Levels) -> Blend:
    size = levels["ACCUR"][level - 1] if 0 < level <= len(levels["ACCUR"]) else 0.0
    return Blend(BlendKind.RADIUS, Quantity(Number(size), mm))


def _rate(name: str, index: int | None, levels: Levels) -> Quantity | None:
    """A share of the rated acceleration, None for all of it."""
    share = levels[name][index] if index is not None and index < len(levels[name]) else 100.0
    return None if share == 100.0 else Quantity(Number(share), percent)
