"""Spells motion: J, L, C, A and S with speed, termination and options; what has to stand before a move."""

from __future__ import annotations

import math
from typing import Final

from olp import called
from olp.expression import (
    Expression,
    FrameRef,
    Function,
    Number,
    PositionLiteral,
    Quantity,
    Store,
    SystemValue,
    Taught,
    Text,
    Variable,
)
from olp.program import Blend, BlendKind, Move, Path, Speed, SpeedUnit
from olp.units import mm
from olp.vendors.tp import values
from olp.vendors.tp.write_poses import Scratch, added_lines, component_lines, components, offset_of, shift_of
from olp.vendors.tp.write_positions import PositionWriter
from olp.vendors.tp.write_values import CannotSayError, Words

_LETTERS: Final = {Path.JOINT: "J", Path.LINEAR: "L", Path.SPLINE: "S"}
# The unit that a value is written in when it was not written in one of TP's.
_USUAL: Final = {
    SpeedUnit.FRACTION: "%",
    SpeedUnit.TRAVEL: "mm/sec",
    SpeedUnit.TURN: "deg/sec",
    SpeedUnit.TIME: "sec",
}


class MoveWriter:
    """Spells the moves of one program. Keeps the texts of speeds, which moves share, and the frames that hold."""

    def __init__(self, words: Words, positions: PositionWriter, scratch: Scratch) -> None:
        self.words = words
        self.positions = positions
        self.scratch = scratch
        self.tool: Expression | None = None  # that was selected last; None: not known here
        self.frame: Expression | None = None
        self._speeds: dict[int, tuple[Speed, str]] = {}
        self._blends: dict[int, tuple[Blend, str]] = {}

    def forget(self) -> None:
        """Which frames hold is not known from here on: a label, the end of a block, a call."""
        self.tool = self.frame = None

    # --- the whole move ---------------------------------------------------------------------------------

    def move(self, s: Move) -> list[str]:
        """The lines of a move, behind those that select its frames and build its position."""
        if s.parts or s.search or s.until or s.no_wait or s.passes or s.coordinated:
            raise CannotSayError(
                "a move that does more than one thing", "synchronous groups, searches and UNTIL are not TP's"
            )
        if s.deceleration is not None or s.rate is not None or s.arc is not None:
            raise CannotSayError("this move's deceleration, rate of acceleration or angle of the arc")
        if s.turn is not None:
            raise CannotSayError("a bound on the tool's turning beside the speed")
        lines = self._select(s)
        target, offsets = self._target(s.targets[0], s, lines)
        tail = f" {self._speed(s)} {self._blend(s)}{self._options(s, offsets, lines)}   "
        if s.path is not Path.CIRCULAR:
            return [*lines, f"{_LETTERS[s.path]} {target}{tail}"]
        if s.via is None:
            return [*lines, f"A {target}{tail}"]
        if offsets:
            raise CannotSayError("an arc whose end is computed", "compute it into a position register first")
        return [*lines, f"C {self._position(s.via, s, lines)}    \n{target}{tail}"]

    # --- frames -----------------------------------------------------------------------------------------

    def _select(self, s: Move) -> list[str]:
        lines = []
        if s.frame is not None and s.frame != self.frame:
            lines.append(self.select_frame(s.frame))
        if s.tool is not None and s.tool != self.tool:
            lines.append(self.select_tool(s.tool))
        return lines

    def select_frame(self, frame: Expression) -> str:
        """UFRAME_NUM=…; remembers it."""
        if isinstance(frame, FrameRef) and frame.kind in ("base", "robot"):
            text = "0"
        elif isinstance(frame, FrameRef) and frame.kind == "user" and frame.number is not None:
            text = self.words.value(frame.number)
        else:
            raise CannotSayError("a frame without a number", "assign it to a user frame first")
        self.frame = frame
        return f"UFRAME_NUM={text}"

    def select_tool(self, tool: Expression) -> str:
        """UTOOL_NUM=…; remembers it."""
        if not isinstance(tool, FrameRef) or tool.kind != "tool" or tool.number is None:
            raise CannotSayError("a tool without a number", "assign it to a numbered tool first")
        self.tool = tool
        return f"UTOOL_NUM={self.words.value(tool.number)}"

    # --- where ------------------------------------------------------------------------------------------

    def _position(self, it: Expression, s: Move, lines: list[str]) -> str:
        if type(it) is Taught:
            if it.store is not Store.ROBOT:
                raise CannotSayError(f"a taught position as a {called.STORES[it.store]} on its own")
            number = self.positions.taught(it.number, _number(s.frame), _number(s.tool))
            return self._point(number)
        if isinstance(it, PositionLiteral):
            return self._point(self.positions.literal(it, _number(s.frame), _number(s.tool)))
        if isinstance(it, Variable):
            return self.words.variable(it)
        if isinstance(it, Function) and it.name == "taught":
            return f"P[{self.words.index(it.arguments[0])}]"
        if isinstance(it, Function):
            shift = shift_of(it)
            if shift is not None:
                return self._shifted(*shift, s, lines)
        raise CannotSayError("a computed position", "compute it into a position register first")

    def _point(self, number: int) -> str:
        name = self.positions.details.get(f"P[{number}]")
        return f'P[{number}:"{name}"]' if name else f"P[{number}]"

    def _shifted(self, start: Expression, by: tuple[Expression, ...], s: Move, lines: list[str]) -> str:
        """A position moved along the axes of its frame: copied into a register, whose x, y and z are added to."""
        register = self.scratch.register()
        lines.append(f"PR[{register}]={self._position(start, s, lines)}")
        lines.extend(added_lines(self.words, register, by))
        return f"PR[{register}]"

    def _target(self, it: Expression, s: Move, lines: list[str]) -> tuple[str, list[str]]:
        """The position of a move, and the offsets that a product of poses becomes."""
        words: list[str] = []
        while isinstance(it, Function) and (found := offset_of(it)) is not None:
            word, it, offset = found
            if any(one.startswith(word) for one in words):
                raise CannotSayError(
                    "a product of several poses", "compute it into a position register first"
                )
            words.append(f"{word},{self._offset(offset, lines, 1 + len(words))}")
        return self._position(it, s, lines), words

    def literal_lines(self, register: str, literal: PositionLiteral) -> list[str]:
        """A pose written into a position register component by component."""
        parts = components(literal)
        if parts is None:
            raise CannotSayError("joint values in this place", "a frame or tool is a pose")
        return component_lines(self.words, register, parts)

    # --- how --------------------------------------------------------------------------------------------

    def _speed(self, s: Move) -> str:
        speed = s.speed
        if speed is None:
            raise CannotSayError("a move without a speed of its own")
        joint = s.path is Path.JOINT
        if (speed.unit is SpeedUnit.FRACTION) is not joint and speed.unit is not SpeedUnit.TIME:
            raise CannotSayError(f"a {s.path.value} move with {called.SPEEDS[speed.unit]}")
        known = self._speeds.get(id(speed))
        if known is None:
            # The object is kept, so that its id stays its own.
            known = self._speeds[id(speed)] = (speed, self._spelled(speed))
        return known[1]

    def _spelled(self, speed: Speed) -> str:
        unit, quantity, native = speed
        if native in ("WELD_SPEED", "max_speed"):
            return native
        if isinstance(quantity.written, SystemValue):
            raise CannotSayError("a speed that only the controller knows")
        words = [
            word for word, (kind, scale) in values.UNITS.items() if kind is unit and scale == quantity.scale
        ]
        if not words:
            near = [
                word
                for word, (kind, scale) in values.UNITS.items()
                if kind is unit and math.isclose(scale, quantity.scale)
            ]
            words = near or ([_USUAL[unit]] if unit in _USUAL else [])
        if not words:
            raise CannotSayError(called.SPEEDS[unit])
        return f"{self.words.quantity(quantity, values.UNITS[words[0]][1])}{words[0]}"

    def _blend(self, s: Move) -> str:
        blend = s.blend
        if blend is None:
            return "CNT100"
        known = self._blends.get(id(blend))
        if known is None:
            known = self._blends[id(blend)] = (blend, self._corner(blend))
        if known[1][0] == "C" and known[1][1] != "N" and s.path is Path.JOINT:
            raise CannotSayError("a radius at the end of a joint move", "CR and CD are for lines and arcs")
        return known[1]

    def _corner(self, blend: Blend) -> str:
        kind, value, native = blend
        if kind is BlendKind.CONTINUOUS:
            return "CNT100"
        if value is None or kind not in (BlendKind.SPEED, BlendKind.RADIUS):
            raise CannotSayError(f"a blend by {called.BLENDS[kind]}")
        if kind is BlendKind.RADIUS:
            if value.literal == 0 and not native.startswith("C"):
                return "FINE"
            word, _, second = native.partition(",") if native.startswith("C") else ("CR", "", "")
            return f"{word}{self._argument(value, mm)}{f',{second}' if second else ''}"
        if value.literal is not None:
            return f"CNT{round(value.literal / values.PERCENT)}"
        return f"CNT{self._argument(value, values.PERCENT)}"

    def _argument(self, value: Quantity, scale: float) -> str:
        """The number glued to its word, a register behind a blank."""
        text = self.words.quantity(value, scale)
        return text if isinstance(value.written, Number) else f" {text}"

    def _options(self, s: Move, offsets: list[str], lines: list[str]) -> str:
        plain = s.acceleration is None and not s.other and s.offset is s.tool_offset is s.relative is None
        if plain and not offsets:
            return ""
        words = []
        if s.acceleration is not None:
            literal = s.acceleration.literal
            share = round(literal / values.PERCENT) if literal is not None else None
            words.append(f"ACC{self._argument(s.acceleration, values.PERCENT) if share is None else share}")
        if s.relative is not None:
            if s.relative.kind != "own":
                raise CannotSayError(
                    f"a move by an offset in {called.SYSTEMS.get(s.relative.kind, s.relative.kind)}"
                )
            words.append("INC")
        words += offsets
        for word, offset in (("Offset", s.offset), ("Tool_Offset", s.tool_offset)):
            if offset is not None:
                if any(one.startswith(word) for one in offsets):
                    raise CannotSayError(f"a move with two values for {word}")
                words.append(f"{word},{self._offset(offset, lines, 1 + len(words))}")
        for name, rest in s.other:
            if not isinstance(rest, Text):
                raise CannotSayError(f"the option {name}")
            words.append(f"{name}{rest.value}")
        return "".join(f" {word}" for word in words)

    def _offset(self, offset: Expression, lines: list[str], place: int) -> str:
        """A register that holds the offset; `place` tells those of one move apart."""
        if isinstance(offset, Variable):
            return self.words.variable(offset)
        parts = components(offset)
        if parts is None:
            raise CannotSayError("a computed offset", "compute it into a position register first")
        register = self.scratch.register(place)
        lines.extend(component_lines(self.words, register, parts))
        return f"PR[{register}]"


def _number(frame: Expression | None) -> int | None:
    """The number of a frame or tool that is written out; base is 0."""
    if not isinstance(frame, FrameRef):
        return None
    if frame.kind in ("base", "robot"):
        return 0
    return int(frame.number.value) if isinstance(frame.number, Number) else None
