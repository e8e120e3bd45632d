"""Spells motion: J, L, C, A and S with speed, termination and options; what has to stand before a move."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from typing import ClassVar, Final

import numpy as np

from olp.core.units import deg, mm
from olp.ir import expressions as ex
from olp.ir import program as st
from olp.ir import terminology
from olp.ir.points import PointKind, PointTable
from olp.languages.generator import CannotSayError, Generator, Spelled, decimal, without_noise
from olp.languages.vendors.tp import values
from olp.languages.vendors.tp.limits import LIMITS, MOST_ARGUMENTS
from olp.languages.vendors.tp.write_positions import TpPositionWriter
from olp.robots.geometry import Pose

# --- Write values ---
# Spells values, registers, arithmetic and conditions in TP: the way back of `expressions`.

_FUNCTIONS: Final = {name: word for word, name in values.FUNCTIONS.items()}
_STRING_FUNCTIONS: Final = {name: word for word, name in values.STRING_FUNCTIONS.items()}
_GROUPS: Final = {store: group for group, store in values.GROUP_STORES.items()}
_SWITCHED: Final = frozenset({"out", "robot-out", "out-group", "analog-out"})
_COMPARED, _UNARY = 3, 6  # how strongly comparisons and signs bind


class TpValues(Generator):
    """Spells expressions. `names`: comments of signals, DO[3] -> gripper. `points`: what the program teaches."""

    language = "TP"
    binary: ClassVar = {
        "+": ("+", 4),
        "-": ("-", 4),
        "*": ("*", 5),
        "/": ("/", 5),
        "div": (" DIV ", 5),
        "mod": (" MOD ", 5),
    }
    unary: ClassVar = {"-": ("(-{})", _UNARY, _UNARY), "not": ("!{}", _UNARY, _UNARY)}
    logic: ClassVar = {"and": (" AND ", 2), "or": (" OR ", 1)}
    compared = (_COMPARED, 4)
    signals: ClassVar = {bus: word for word, bus in values.BUSES.items()}
    states = ("OFF", "ON")
    quotes = "'"
    not_in_text = frozenset("'\r\n")
    no_text = "a text that holds ' or a line end"
    first_signal = 1
    no_value = ("a computed value in this place", "compute it into a register first")
    singles = frozenset(
        {
            ex.Number,
            ex.Variable,
            ex.Argument,
            ex.Signal,
            ex.SignalState,
            ex.Member,
            ex.Item,
            ex.SystemValue,
            ex.Taught,
            ex.FrameRef,
            ex.Text,
            ex.Named,
            ex.Unknown,
        }
    )

    def __init__(self, program: st.Program, date: str) -> None:
        super().__init__(program, program.vendor == "tp", date)
        self.names: Mapping[str, str] = {}
        self.points = PointTable()

    # --- registers --------------------------------------------------------------------------------------

    def spell_variable(self, e: ex.Variable) -> str:
        name = f":{e.name}" if e.name else ""
        if e.store is ex.Store.REAL:
            return f"R[{self.index(e.index)}{name}]"
        if e.store is ex.Store.STRING:
            return f"SR[{self.index(e.index)}{name}]"
        return f"{self._position_register(e)}{name}]"

    def _position_register(self, it: ex.Variable) -> str:
        if it.store not in _GROUPS or it.local:
            raise CannotSayError(f"a {terminology.STORES[it.store]}", "TP has R, PR and SR registers")
        group = _GROUPS[it.store]
        return f"PR[{'' if group == 1 else f'GP{group}:'}{self.index(it.index)}"

    def spell_member(self, e: ex.Member) -> str:
        return self._element(e)

    def spell_item(self, e: ex.Item) -> str:
        return self._element(e)

    def _element(self, it: ex.Member | ex.Item) -> str:
        base = it.base
        if isinstance(base, ex.Taught) and isinstance(it, ex.Member):
            return self._taught_component(base, it.name)
        if not isinstance(base, ex.Variable) or base.store not in _GROUPS:
            raise CannotSayError(
                "a component of something that is no position register", "copy it into a PR first"
            )
        if isinstance(it, ex.Member):
            if it.name not in values.ELEMENTS:
                raise CannotSayError(
                    f"the component '{it.name}' of a position", "TP has x y z, W P R and E1 to E3"
                )
            place = str(values.ELEMENTS.index(it.name) + 1)
        elif len(it.indices) == 1:
            place = self.index(it.indices[0])
        else:
            raise CannotSayError("an array of several dimensions")
        return f"{self._position_register(base)},{place}{f':{base.name}' if base.name else ''}]"

    def _taught_component(self, base: ex.Taught, name: str) -> str:
        """A component of a taught position, which no program changes: its number."""
        point = self.points.find(base.store, True, base.number)
        place = values.ELEMENTS.index(name) if name in values.ELEMENTS[:6] else -1
        if point is None or point.state.kind is not PointKind.POSE or place < 0:
            raise CannotSayError(f"the component '{name}' of a taught position", "copy it into a PR first")
        value = round(point.values[place] / (mm if place < 3 else deg), 6)
        return self.single(ex.Number(int(value) if value == int(value) else value))

    def index(self, it: ex.Expression) -> str:
        """A number, or one register."""
        if isinstance(it, ex.Number):
            return str(int(it.value))
        if isinstance(it, ex.Argument) or (isinstance(it, ex.Variable) and it.store is ex.Store.REAL):
            return self.value(it)
        raise CannotSayError("a computed index", "compute it into a register first")

    def signal(self, it: ex.Signal) -> str:
        if it.part:
            raise CannotSayError(*terminology.signal(it))
        word = self.signal_word(it)
        if isinstance(it.index, ex.Text):
            raise CannotSayError(f"the signal '{it.index.value}' by its name", "say which number it has")
        return self.named(word, it.index)

    def spell_frame_ref(self, e: ex.FrameRef) -> str:
        if e.kind not in ("user", "tool") or e.number is None:
            raise CannotSayError(f"{terminology.SYSTEMS.get(e.kind, e.kind)} in this place")
        return f"{'UFRAME' if e.kind == 'user' else 'UTOOL'}[{self.index(e.number)}]"

    def spell_system_value(self, e: ex.SystemValue) -> str:
        if e.name == "timer":
            return self.named("TIMER", ex.Number(e.index))
        if e.name in ("current-pose", "current-joints"):
            return "LPOS" if e.name == "current-pose" else "JPOS"
        raise CannotSayError(terminology.value(e.name))

    def named(self, word: str, index: ex.Expression) -> str:
        """A word with its number, and the comment that the program gives it."""
        key = f"{word}[{self.index(index)}]"
        name = self.names.get(key)
        return f"{key[:-1]}:{name}]" if name else key

    # --- values -----------------------------------------------------------------------------------------

    def target(self, e: ex.Expression) -> str:
        return self.single(e)

    def spell_number(self, e: ex.Number) -> str:
        """A negative number is in parentheses."""
        text = self.number(e)
        return f"({text})" if text[0] == "-" else text

    def spell_argument(self, e: ex.Argument) -> str:
        self.at_most_arguments(e.number, MOST_ARGUMENTS)
        return f"AR[{e.number}]"

    def spell_taught(self, e: ex.Taught) -> Spelled:
        return f"P[{e.number}]" if e.store is ex.Store.ROBOT else self.spell_other(e)

    def spell_named(self, e: ex.Named) -> str:
        if e.name.startswith("$"):
            return e.name
        raise CannotSayError(f"the variable {e.name} by its name", "give it a register")

    def assigned(self, it: ex.Expression) -> str:
        """The right side of an assignment: one value, one operation, or mixed logic in parentheses."""
        if isinstance(it, ex.Function) and it.name in _STRING_FUNCTIONS:
            return f"{_STRING_FUNCTIONS[it.name]} {','.join(map(self.single, it.arguments))}"
        if isinstance(it, ex.Function) and it.name == "joined-text" and len(it.arguments) == 2:
            return "+".join(map(self.single, it.arguments))
        if type(it) in self.singles or (isinstance(it, ex.Function) and it.name in _FUNCTIONS):
            return self.value(it)
        if isinstance(it, ex.Binary) and type(it.left) in self.singles and type(it.right) in self.singles:
            return self.value(it)
        return f"({self.value(it)})"

    def spell_function(self, e: ex.Function) -> str:
        if e.name not in _FUNCTIONS:
            raise CannotSayError(terminology.function(e.name))
        return f"{_FUNCTIONS[e.name]}[{self.arguments(e.arguments)}]"

    def operand(self, e: ex.Expression, strength: int) -> str:
        """An operand of AND, OR and !: a register counts as true when it is not zero."""
        if isinstance(e, (ex.Variable, ex.Argument, ex.Number)):
            text = f"{self.single(e)}<>0"
            return f"({text})" if strength > _COMPARED else text
        return self.value(e, strength)

    def spell_compare(self, e: ex.Compare) -> Spelled:
        if isinstance(e.right, ex.SignalState) and isinstance(e.left, (ex.Variable, ex.Argument)):
            e = ex.Compare(e.operator, e.left, ex.Number(int(e.right.on)))
        return super().spell_compare(e)

    def condition(self, e: ex.Expression, strength: int = 0) -> str:
        """Plain where it compares a single value with another and binds no stronger, else in parentheses.

        Clocks are compared in parentheses alone.
        """
        single = isinstance(e, ex.Compare) and type(e.left) in self.singles and type(e.right) in self.singles
        if isinstance(e, ex.Compare) and single and not isinstance(e.left, (ex.Number, ex.SignalState)):
            if not self.own and ex.SystemValue in (type(e.left), type(e.right)):
                return f"({self.value(e)})"
            text = self.value(e)
            return f"({text})" if strength else text
        return f"({self.operand(e, 0)})"

    # --- numbers with units -----------------------------------------------------------------------------

    def quantity(self, it: ex.Quantity, unit: float) -> str:
        written = it.written
        if isinstance(written, ex.Number):
            value = written.value if it.scale == unit else without_noise(written.value * it.scale / unit)
            return decimal(float(value))
        if not math.isclose(it.scale, unit):
            raise CannotSayError("a register in another unit", "convert it into a register of its own first")
        return self.index(written)


# --- Write moves ---

_HERE: Final = ("current-pose", "current-joints")
_LETTERS: Final = {st.Path.JOINT: "J", st.Path.LINEAR: "L", st.Path.SPLINE: "S"}
# The unit that a value is written in when it was not written in one of TP's.
_USUAL: Final = {
    st.SpeedUnit.FRACTION: "%",
    st.SpeedUnit.TRAVEL: "mm/sec",
    st.SpeedUnit.TURN: "deg/sec",
    st.SpeedUnit.TIME: "sec",
}

_POSE_AXES: Final = 6
_LENGTHS: Final = 3
_VIA: Final = 3  # of the registers of one move: behind that of its target and those of two offsets
_BUILDERS: Final = ("pose-angles", "pose-vector")
_DECIMALS: Final = 5
Components = tuple[ex.Expression, ...]  # x y z [mm], W P R [deg]
_PR = re.compile(r"Variable\(store=<Store\.ROBOT: 'robot'>, index=Number\(value=(\d+)\)")


class TpMoves(TpValues):
    """Writes moves. `positions`: those of the routine; `scratch`: registers that the program leaves free."""

    cannot: ClassVar = {
        st.Move: {
            **dict.fromkeys(
                ("parts", "search", "until", "no_wait", "passes", "coordinated"),
                (
                    "a move that does more than one thing",
                    "synchronous groups, searches and UNTIL are not TP's",
                ),
            ),
            **dict.fromkeys(
                ("deceleration", "rate", "arc"),
                "this move's deceleration, rate of acceleration or angle of the arc",
            ),
            "turn": "a bound on the tool's turning beside the speed",
        }
    }

    def __init__(self, program: st.Program, date: str) -> None:
        super().__init__(program, date)
        self.scratch = Scratch(
            _used(program), LIMITS.numbered[ex.Store.ROBOT], LIMITS.enlarged[ex.Store.ROBOT]
        )
        self.positions = TpPositionWriter(PointTable(), {}, self.own)

    def forget(self) -> None:
        self.tool: ex.Expression | None = None  # that was selected last; None: not known here
        self.frame: ex.Expression | None = None

    def forget_from(self, name: str) -> None:
        numbers = [e.number for e in (self.tool, self.frame) if isinstance(e, ex.FrameRef)]
        if any(e is not None and type(e) is not ex.Number and name in self.value(e) for e in numbers):
            self.forget()

    # --- the whole move ---------------------------------------------------------------------------------

    def write_move(self, s: st.Move) -> list[str]:
        """The lines of a move, behind those that select its frames and build its position."""
        lines = self._select(s)
        target, offsets = self._target(s.targets[0], s, lines)
        tail = f" {self._speed(s)} {self._blend(s)}{self._options(s, offsets, lines)}   "
        if s.path is not st.Path.CIRCULAR:
            return [*lines, f"{_LETTERS[s.path]} {target}{tail}"]
        if s.via is None:
            return [*lines, f"A {target}{tail}"]
        if offsets:
            raise CannotSayError("an arc whose end is computed", "compute it into a position register first")
        via = self._position(s.via, s, lines, _VIA)
        return [*lines, f"C {via}    \n{target}{tail}"]

    # --- frames -----------------------------------------------------------------------------------------

    def _select(self, s: st.Move) -> list[str]:
        lines = []
        if s.frame is not None and s.frame != self.frame:
            lines.append(self.select_frame(s.frame))
        if s.tool is not None and s.tool != self.tool:
            lines.append(self.select_tool(s.tool))
        return lines

    def select_frame(self, frame: ex.Expression) -> str:
        """UFRAME_NUM=…; remembers it."""
        if isinstance(frame, ex.FrameRef) and frame.kind in ("base", "robot"):
            text = "0"
        elif isinstance(frame, ex.FrameRef) and frame.kind == "user" and frame.number is not None:
            text = self.single(frame.number)
        else:
            raise CannotSayError("a frame without a number", "assign it to a user frame first")
        self.frame = frame
        return f"UFRAME_NUM={text}"

    def select_tool(self, tool: ex.Expression) -> str:
        """UTOOL_NUM=…; remembers it."""
        if not isinstance(tool, ex.FrameRef) or tool.kind != "tool" or tool.number is None:
            raise CannotSayError("a tool without a number", "assign it to a numbered tool first")
        self.tool = tool
        return f"UTOOL_NUM={self.single(tool.number)}"

    # --- where ------------------------------------------------------------------------------------------

    def _position(
        self, it: ex.Expression, s: st.Move, lines: list[str], place: int = 0, moved: bool = False
    ) -> str:
        """`place`: of the register that holds it where it has to be built; `moved`: an offset is added to it."""
        if type(it) is ex.Taught:
            if it.store is not ex.Store.ROBOT:
                raise CannotSayError(f"a taught position as a {terminology.STORES[it.store]} on its own")
            number = self.positions.taught(it.number, _number(s.frame), _number(s.tool))
            return self._point(number)
        if isinstance(it, ex.PositionLiteral):
            return self._point(self.positions.literal(it, _number(s.frame), _number(s.tool)))
        if isinstance(it, ex.Variable):
            return self.value(it)
        if isinstance(it, ex.Function) and it.name == "taught":
            return f"P[{self.index(it.arguments[0])}]"
        if isinstance(it, ex.Function):
            shift = shift_of(it)
            if shift is not None:
                return self._shifted(*shift, s, lines, place)
        if isinstance(it, ex.SystemValue) and it.name in _HERE:
            register = self.scratch.register(place)
            # Where the arm stands, whatever the tool and the frame; as a pose where something is added to it.
            lines.append(f"PR[{register}]={'LPOS' if moved else 'JPOS'}")
            return f"PR[{register}]"
        raise CannotSayError("a computed position", "compute it into a position register first")

    def _point(self, number: int) -> str:
        name = self.positions.details.get(f"P[{number}]")
        return f"P[{number}:{name}]" if name else f"P[{number}]"

    def _shifted(
        self, start: ex.Expression, by: tuple[ex.Expression, ...], s: st.Move, lines: list[str], place: int
    ) -> str:
        """A position moved along the axes of its frame: copied into a register, whose x, y and z are added to."""
        register = self.scratch.register(place)
        if isinstance(start, ex.SystemValue) and start.name == "current-pose":
            lines.append(f"PR[{register}]=LPOS")
        else:
            lines.append(f"PR[{register}]={self._position(start, s, lines, place)}")
        lines.extend(self.added_lines(register, by))
        return f"PR[{register}]"

    def _target(self, it: ex.Expression, s: st.Move, lines: list[str]) -> tuple[str, list[str]]:
        """The position of a move, and the offsets that a product of poses becomes."""
        words: list[str] = []
        while isinstance(it, ex.Function) and (found := offset_of(it)) is not None:
            word, it, offset = found
            if any(one.startswith(word) for one in words):
                raise CannotSayError(
                    "a product of several poses", "compute it into a position register first"
                )
            words.append(f"{word},{self._offset(offset, lines, 1 + len(words))}")
        return self._position(it, s, lines, moved=bool(words)), words

    def literal_lines(self, register: str, literal: ex.PositionLiteral) -> list[str]:
        """A pose written into a position register component by component."""
        parts = components(literal)
        if parts is None:
            raise CannotSayError("joint values in this place", "a frame or tool is a pose")
        return self.component_lines(register, parts)

    # --- how --------------------------------------------------------------------------------------------

    def _speed(self, s: st.Move) -> str:
        speed = s.speed
        if speed is None:
            raise CannotSayError("a move without a speed of its own")
        joint = s.path is st.Path.JOINT
        if (speed.unit is st.SpeedUnit.FRACTION) is not joint and speed.unit is not st.SpeedUnit.TIME:
            raise CannotSayError(f"a {s.path.value} move with {terminology.SPEEDS[speed.unit]}")
        return self.once(speed, self._spelled)

    def _spelled(self, speed: st.Speed) -> str:
        unit, quantity, native = speed
        if native in ("WELD_SPEED", "max_speed"):
            return native
        if isinstance(quantity.written, ex.SystemValue):
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
            raise CannotSayError(terminology.SPEEDS[unit])
        return f"{self.quantity(quantity, values.UNITS[words[0]][1])}{words[0]}"

    def _blend(self, s: st.Move) -> str:
        blend = s.blend
        if blend is None:
            return "CNT100"
        text = self.once(blend, self._corner)
        if s.path is st.Path.JOINT and text[0] == "C" and text[1] != "N":
            raise CannotSayError("a radius at the end of a joint move", "CR and CD are for lines and arcs")
        return text

    def _corner(self, blend: st.Blend) -> str:
        kind, value, native = blend
        if kind is st.BlendKind.CONTINUOUS:
            return "CNT100"
        if value is None or kind not in (st.BlendKind.SPEED, st.BlendKind.RADIUS):
            raise CannotSayError(f"a blend by {terminology.BLENDS[kind]}")
        if kind is st.BlendKind.RADIUS:
            if value.literal == 0 and not native.startswith("C"):
                return "FINE"
            word, _, second = native.partition(",") if native.startswith("C") else ("CR", "", "")
            return f"{word}{self._argument(value, mm)}{f',{second}' if second else ''}"
        if value.literal is not None:
            return f"CNT{round(value.literal / values.PERCENT)}"
        return f"CNT{self._argument(value, values.PERCENT)}"

    def _argument(self, value: ex.Quantity, scale: float) -> str:
        """The number glued to its word, a register behind a blank."""
        text = self.quantity(value, scale)
        return text if isinstance(value.written, ex.Number) else f" {text}"

    def _options(self, s: st.Move, offsets: list[str], lines: list[str]) -> str:
        plain = s.acceleration is None and not s.other and s.offset is s.tool_offset is s.relative is None
        plain = plain and not s.triggers
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
                    f"a move by an offset in {terminology.SYSTEMS.get(s.relative.kind, s.relative.kind)}"
                )
            words.append("INC")
        words += offsets
        for word, offset in (("Offset", s.offset), ("Tool_Offset", s.tool_offset)):
            if offset is not None:
                if any(one.startswith(word) for one in offsets):
                    raise CannotSayError(f"a move with two values for {word}")
                words.append(f"{word},{self._offset(offset, lines, 1 + len(words))}")
        for name, rest in s.other:
            if not isinstance(rest, ex.Text):
                raise CannotSayError(f"the option {name}")
            words.append(f"{name}{rest.value}")
        words += [self._trigger(s.line, one) for one in s.triggers]
        return "".join(f" {word}" for word in words)

    def _trigger(self, line: int, one: st.PathTrigger) -> str:
        """What switches before the end of a move, or shortly behind it."""
        (deed,) = self.lines(st.SetOutput(line, one.signal, one.value))
        if one.at_start or one.signal.bus not in _SWITCHED:
            raise CannotSayError(f"{deed} on the way of a move")
        if one.metres is not None:
            return f"DB {abs(one.metres.literal or 0.0) / mm:.1f}mm,{deed}"
        seconds = 0.0 if one.seconds is None else one.seconds.literal or 0.0
        hundredths = f"{abs(seconds):.2f}".removeprefix("0")
        return f"{'TA' if seconds > 0.0 else 'TB'} {hundredths}sec,{deed}"

    def _offset(self, offset: ex.Expression, lines: list[str], place: int) -> str:
        """A register that holds the offset; `place` tells those of one move apart."""
        if isinstance(offset, ex.Variable):
            return self.value(offset)
        parts = components(offset)
        if parts is None:
            raise CannotSayError("a computed offset", "compute it into a position register first")
        register = self.scratch.register(place)
        lines.extend(self.component_lines(register, parts))
        return f"PR[{register}]"

    # --- registers that are filled component by component ---------------------------------------------------

    def component_lines(self, register: str, parts: Components) -> list[str]:
        """The lines that write all components of a register."""
        return [f"PR[{register},{place}]={self._component(part)}" for place, part in enumerate(parts, 1)]

    def added_lines(self, register: str, parts: tuple[ex.Expression, ...]) -> list[str]:
        """The lines that add to the first components of a register."""
        return [
            f"PR[{register},{place}]=(PR[{register},{place}]+{self.value(part, 5)})"
            for place, part in enumerate(parts, 1)
            if not _is_zero(part)
        ]

    def _component(self, part: ex.Expression) -> str:
        if isinstance(part, ex.Number):
            text = decimal(float(part.value))
            return f"({text})" if text[0] == "-" else text
        return self.assigned(part)


def _number(frame: ex.Expression | None) -> int | None:
    """The number of a frame or tool that is written out; base is 0."""
    if not isinstance(frame, ex.FrameRef):
        return None
    if frame.kind in ("base", "robot"):
        return 0
    return int(frame.number.value) if isinstance(frame.number, ex.Number) else None


class Scratch:
    """Position registers that nobody else uses, for values that TP can only build component by component."""

    def __init__(self, used: set[int], delivered: int, largest: int) -> None:
        """`delivered`: how many a controller has as delivered; `largest`: how many one has that is set up for more, as
        it has to be where `used` goes beyond them.
        """
        self._free = [number for number in range(delivered, 0, -1) if number not in used]
        if max(used, default=0) > delivered:
            self._free += [number for number in range(delivered + 1, largest + 1) if number not in used]

    def register(self, place: int = 0) -> str:
        """The highest free one, the next for `place` 1 … Raises CannotSayError when all are taken."""
        if place >= len(self._free):
            raise CannotSayError("a position that needs a register of its own: all PR are in use")
        return str(self._free[place])


def is_position(it: ex.Expression) -> bool:
    """Whether a move can name it: taught, written out, or in a register."""
    return isinstance(it, (ex.Taught, ex.PositionLiteral)) or (
        isinstance(it, ex.Variable) and it.store is ex.Store.ROBOT and not it.local
    )


def shift_of(
    it: ex.Function,
) -> tuple[ex.Expression, tuple[ex.Expression, ex.Expression, ex.Expression]] | None:
    """The position and x y z [mm] that are added to it along the axes of its frame; None where more happens."""
    if it.name == "pose-offset" and len(it.arguments) == 4:
        start, x, y, z = it.arguments
        return start, (x, y, z)
    if it.name == "pose-add" and len(it.arguments) == 2:
        start, by = it.arguments
        parts = components(by)
        if parts is not None and all(map(_is_zero, parts[_LENGTHS:])):
            return start, parts[:_LENGTHS]  # type: ignore[return-value]
    return None


def offset_of(it: ex.Function) -> tuple[str, ex.Expression, ex.Expression] | None:
    """(Offset or Tool_Offset, the position, the offset) of a product of two poses; None where TP has neither."""
    if it.name == "pose-relative-tool" and len(it.arguments) >= 4:
        start, *by = it.arguments
        turns = by[_LENGTHS:]
        # About one axis only, or the order of the turns would be another one.
        if sum(not _is_zero(turn) for turn in turns) > 1:
            return None
        filled = (*by, *[ex.Number(0)] * (_POSE_AXES - len(by)))
        return "Tool_Offset", start, ex.Function("pose-angles", filled)
    if it.name != "pose-product" or len(it.arguments) != 2:
        return None
    first, second = it.arguments
    if _is_built(second) and (is_position(first) or _is_computed(first)):
        return "Tool_Offset", first, second
    if is_position(second) or _is_computed(second):
        return "Offset", second, first
    return None


def components(it: ex.Expression) -> Components | None:
    """x y z [mm] and W P R [deg] of a pose that is put together from numbers; None for anything else."""
    if isinstance(it, ex.PositionLiteral) and it.kind == "pose" and len(it.values) == _POSE_AXES:
        units = [mm] * _LENGTHS + [deg] * _LENGTHS
        return tuple(ex.Number(round(v / unit, _DECIMALS)) for v, unit in zip(it.values, units, strict=True))
    if not isinstance(it, ex.Function) or len(it.arguments) != _POSE_AXES:
        return None
    if it.name == "pose-angles":
        return it.arguments
    if it.name == "pose-vector":
        angles = _angles(it.arguments[_LENGTHS:])
        return (
            None
            if angles is None
            else (*(term_by_term(one, 1000) for one in it.arguments[:_LENGTHS]), *angles)
        )
    return None


def _angles(vector: tuple[ex.Expression, ...]) -> tuple[ex.Number, ...] | None:
    """W P R [deg] of a rotation vector [rad] of plain numbers."""
    values = [one.value for one in vector if isinstance(one, ex.Number)]
    if len(values) != _LENGTHS:
        return None
    if not any(values):
        return (ex.Number(0),) * _LENGTHS
    angle = float(np.linalg.norm(values))
    x, y, z = np.array(values) / angle
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    rotation = np.eye(3) + np.sin(angle) * cross + (1.0 - np.cos(angle)) * (cross @ cross)
    turned = Pose(np.zeros(3), rotation).xyz_angles()[_LENGTHS:]
    return tuple(ex.Number(round(float(value) / deg, _DECIMALS)) for value in turned)


def term_by_term(it: ex.Expression, factor: int) -> ex.Expression:
    """`it` times a number, each term of a sum on its own."""
    if isinstance(it, ex.Binary) and it.operator in "+-":
        return ex.Binary(it.operator, term_by_term(it.left, factor), term_by_term(it.right, factor))
    return ex.without_decimals(ex.scaled(it, factor))


def _is_zero(it: ex.Expression) -> bool:
    return isinstance(it, ex.Number) and it.value == 0


def _is_built(it: ex.Expression) -> bool:
    return isinstance(it, ex.Function) and it.name in _BUILDERS and components(it) is not None


def _is_computed(it: ex.Expression) -> bool:
    return isinstance(it, ex.Function) and (shift_of(it) is not None or offset_of(it) is not None)


def _used(program: st.Program) -> set[int]:
    """The numbers of position registers that the program names."""
    found: set[int] = set()
    for routine in program.routines:
        for one in routine.body:
            if (
                type(one) is st.Move
                and type(one.targets[0]) is not ex.Variable
                and one.offset is one.tool_offset is None
            ):
                continue
            text = repr(one)
            if "Store.ROBOT" in text:
                found.update(map(int, _PR.findall(text)))
    return found
