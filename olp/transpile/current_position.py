"""Readings of the arm's current position (CRobT, $POS_ACT, LPOS), and moves that count from it.

By language such a reading is of the tool and in the frame that hold, of the last move, that are named, or in the base.
"""

from __future__ import annotations

import math
from collections.abc import Sequence, Set
from dataclasses import dataclass, field, replace
from enum import Enum
from typing import Final

from olp.core.units import deg, mm
from olp.ir import expressions as ex
from olp.ir import program as st
from olp.ir.transformer import calls_nothing, edited, expressions_of, mapped
from olp.languages.limits import Limits
from olp.transpile.blends import STOP
from olp.transpile.context import BETWEEN, SETTING, Fate, TranslationContext
from olp.transpile.occurrences import with_routines, with_rows
from olp.transpile.partial_positions import component, written_component
from olp.transpile.reaching_definitions import Key, reaching
from olp.transpile.symbols import Symbols

HERE: Final = ex.SystemValue("current-pose")
_BASE: Final = ex.FrameRef("base")
UNSEEN: Final = (
    ex.FrameRef("tool", ex.Number(0)),
    _BASE,
)  # tool and frame of the last move where there is none
_TOOL, _FRAME = "Tool", "WObj"
_HELD: Final = {"base": "the base", "move": "those of the move before"}
_HEADS: Final = (
    "While",
    "Until",
    "ElseIf",
    "Case",
)  # no statement put before them runs each time that they are evaluated

System = tuple[ex.Expression | None, ex.Expression | None]  # tool, frame


def seen_in(tool: ex.Expression | None, frame: ex.Expression | None) -> ex.Function:
    """A reading of the current position with this tool, in this frame; None: those that hold."""
    named = ((_TOOL, tool), (_FRAME, frame))
    return ex.Function(HERE.name, tuple(ex.NamedArgument(name, it) for name, it in named if it is not None))


def systems_of(e: ex.Expression) -> System | None:
    """Tool and frame of a reading of the position that names one of them; None for any other expression."""
    if type(e) is not ex.Function or e.name != HERE.name:
        return None
    named = {a.name.casefold(): a.value for a in e.arguments if isinstance(a, ex.NamedArgument)}
    return named.get(_TOOL.casefold()), named.get(_FRAME.casefold())


def solves(e: ex.Expression) -> bool:
    """Whether an expression computes axes from a pose, or a pose from axes."""
    return type(e) is ex.Function and e.name in ("forward", "inverse")


def _solves_elsewhere(e: ex.Expression) -> bool:
    """Whether it does so with a tool or a frame that is named in the call."""
    return solves(e) and any(type(a) is ex.NamedArgument for a in expressions_of(e))


def position_readings(program: st.Program, work: TranslationContext) -> st.Program:
    """Readings of the position with their tool and frame in the target's way; where points are taught, in the base."""
    if not (work.conventions.names_read_frames or work.conventions.taught_frames):
        return program
    return replace(program, routines=tuple(_routine(routine, work) for routine in program.routines))


def _routine(routine: st.Routine, work: TranslationContext) -> st.Routine:
    rows: list[st.Statement] = []
    last: System = UNSEEN  # tool and frame of the last move above, in the order of the text
    for s in routine.body:
        plain = isinstance(s, st.Move) and calls_nothing(s) and s.targets[0] != HERE
        rows.append(s if plain else _statement(s, last, work))
        if isinstance(s, st.Move):
            last = (s.tool, s.frame)
    return replace(routine, body=tuple(rows))


def _statement(s: st.Statement, last: System, work: TranslationContext) -> st.Statement:
    if any(_solves_elsewhere(e) for e in expressions_of(s)):
        work.lose(
            s, Fate.REFUSED, "position", "axes and poses computed with a tool and a frame that are named"
        )
    if not any(e == HERE or systems_of(e) is not None for e in expressions_of(s)):
        return s

    asked = [found for e in expressions_of(s) if (found := (None, None) if e == HERE else systems_of(e))]
    for tool, frame in asked[1:]:
        if (tool, frame) != asked[0]:
            work.lose(s, Fate.REFUSED, "position", "two readings of the position with other tools or frames")
    if work.conventions.taught_frames:
        return read_here(s, (None, _BASE), last, work)  # with the tool that holds, whatever is written above
    tool, frame = (own if own is not None else known for own, known in zip(asked[0], last, strict=True))
    # Which tool is active before any move, no program says.
    said = (tool, frame) if last is not UNSEEN else asked[0]
    if isinstance(s, st.Move) and _reads_elsewhere(s, said, work):
        says = "a move to where the arm is with another tool or in another frame, which holds already where it is read"
        work.lose(s, Fate.REFUSED, "position", says)
    return read_here(s, (tool, frame), last, work)


def _reads_elsewhere(s: st.Move, system: System, work: TranslationContext) -> bool:
    """Whether a move chooses another tool or frame than its target is read with, where those that hold count."""
    limits = work.limits
    if limits.position_read_in == "named" and not limits.pose_functions:
        return False  # the reading names them
    (tool, frame), held = system, limits.position_read_in == "move"
    pairs = [(tool, s.tool), *([(frame, s.frame)] if held else [])]
    return any(own is not None and read not in (None, own) for read, own in pairs)


def read_here(s: st.Statement, system: System, last: System, work: TranslationContext) -> st.Statement:
    """The statement reading the position with `system`'s tool and frame; `last`: those of the last move before it."""
    read_in = work.limits.position_read_in
    if read_in == "move" and type(s).__name__ not in _HEADS:
        read_in = "named"
    held = (last[0], _BASE) if read_in == "base" else last
    if read_in != "named" and any(e not in (None, known) for e, known in zip(system, held, strict=True)):
        says = f"the current position with another tool or in another frame than {_HELD[read_in]}"
        work.lose(s, Fate.REFUSED, "position", says)
    reading = seen_in(*system) if read_in == "named" else HERE
    return mapped(s, lambda e: reading if e == HERE or systems_of(e) is not None else e)


# --- Current position moves ---
# Moves relative to the current position, for languages that read this position while the arm still moves.
#
# Some languages count a relative move from the target of the move before, however that one is passed, and some wait
# before they read the position. The others would take a place somewhere on the way: the move before has to stop.

_TURNING: Final = (
    "an offset from the current position that turns the tool: taken to turn it about the axes of the frame, "
    "which no manual at hand tells of both controllers"
)
_READ: Final = frozenset({"current-pose", "current-joints"})
_STRAIGHT: Final = (
    BETWEEN
    | SETTING
    | {
        "SetSpeed",
        "SetBlend",
        "SetAcceleration",
        "SetTool",
        "SetFrame",
        "SetOverride",
        "ObeyFlags",
        "Clear",
        "If",
    }
)
_STOPS: Final = "the arm stops here, because its position is read, or the next move counts from it"
_ON_THE_WAY: Final = "it is read while the arm passes the corner before: how far it is by then is not known"
_UNKNOWN: Final = (
    "relative to the current position: make sure that all moves that lead here stop at their ends"
)


class Lead(Enum):
    """What comes before a reading of the position, unless it is a move with a rounded corner."""

    STOP = "a move that stops"
    BEGIN = "the beginning of the routine"
    OPEN = "several paths of the program, or a routine"


def stops_before_readings(program: st.Program, work: TranslationContext) -> st.Program:
    """Moves right before such a reading stop exactly; where it is unknown which move that is, the receipt says so."""
    return replace(
        program, routines=tuple([_current_position_moves_routine(r, program, work) for r in program.routines])
    )


def _current_position_moves_routine(
    routine: st.Routine, program: st.Program, work: TranslationContext
) -> st.Routine:
    body = list(routine.body)
    first = next((r for r in program.routines if r.name == program.main), program.routines[0])
    stand: list[int] = []  # rows before which the target needs a statement that stops the arm
    for at, s in work.look(routine).rare:
        if isinstance(s, st.Dwell) and _is_passed(s, work):
            before = _before(body, at)
            passed = before is Lead.OPEN or (before is Lead.BEGIN and routine is not first)
            if isinstance(before, int):
                move = body[before]
                if isinstance(move, st.Move) and all(
                    isinstance(x, st.Comment) for x in body[before + 1 : at]
                ):
                    body[before] = edited(move, {"blend": STOP})
                else:
                    passed = True  # the statements between them run while the arm rounds the corner
            if passed and work.limits.stand:
                stand.append(at)
        if (
            not work.conventions.waits_before_reading
            and reads_place(s)
            and isinstance(_before(body, at), int)
        ):
            work.lose(s, Fate.APPROXIMATED, "position", _ON_THE_WAY)
        if not _reads(s, work):
            continue
        before = _before(body, at)
        if isinstance(before, int):
            body[before] = _stopped(body[before], work)
        elif before is Lead.OPEN or (before is Lead.BEGIN and routine is not first):
            open_ = any(isinstance(x, st.Move) and not _stops(x) for x in program.statements())
            if open_:
                work.lose(s, Fate.APPROXIMATED, "position", _UNKNOWN)
    if stand and any(isinstance(x, st.Move) and not _stops(x) for x in program.statements()):
        for at in reversed(stand):
            body.insert(at, st.Process(body[at].line, work.limits.stand))
    return with_rows(routine, body)


def _is_passed(s: st.Dwell, work: TranslationContext) -> bool:
    """Whether the target's arm keeps moving during this wait; in other languages it stops, for a wait of 0 s, too."""
    if work.source.vendor == work.target:
        return False
    return bool(work.limits.stand) or s.duration.literal == 0.0


def _reads(s: st.Statement, work: TranslationContext) -> bool:
    if isinstance(s, st.Move) and s.relative is not None:
        return not _is_native(s, work.limits)
    waits = work.conventions.waits_before_reading and not work.target_conventions.waits_before_reading
    return waits and reads_place(s)


def reads_place(s: st.Statement) -> bool:
    """Whether a statement reads the current position."""
    return not calls_nothing(s) and any(
        (isinstance(e, ex.SystemValue) and e.name in _READ) or systems_of(e) is not None
        for e in expressions_of(s)
    )


def _is_native(s: st.Move, limits: Limits) -> bool:
    """Whether the target has a statement for this relative move (along the tool, or in a frame)."""
    if s.path is st.Path.JOINT and not limits.joint_offsets:
        return False
    along_tool = s.relative is not None and s.relative.kind == "tool"
    return ("relative-tool" if along_tool else "relative") in limits.native_offsets


def keeps_systems(s: st.Statement) -> bool:
    """Whether control always goes on to the next statement, with tool and frame unchanged."""
    return type(s).__name__ in _STRAIGHT and not any(type(e) is ex.CallValue for e in expressions_of(s))


def _before(body: list[st.Statement], at: int) -> Lead | int:
    """The row of the last move before row `at` if it always runs and does not stop; else what is there instead."""
    for row in range(at - 1, -1, -1):
        s = body[row]
        if isinstance(s, st.Move):
            return Lead.STOP if _stops(s) else row
        if not keeps_systems(s):
            return Lead.OPEN
    return Lead.BEGIN


def _stops(s: st.Move) -> bool:
    size = None if s.blend is None or s.blend.value is None else s.blend.value.literal
    return size is not None and size <= 0.0


def _stopped(s: st.Statement, work: TranslationContext) -> st.Statement:
    assert isinstance(s, st.Move)
    blend = s.blend
    size = (
        None
        if blend is None or blend.value is None or blend.kind is not st.BlendKind.RADIUS
        else blend.value.literal
    )
    if size is None:
        work.lose(s, Fate.APPROXIMATED, "blend", _STOPS)
    else:
        work.lose(s, Fate.APPROXIMATED, "blend", _STOPS, size / mm, "mm")
    return edited(s, {"blend": STOP})


# --- Relative ---
# Moves by an offset from the current position, and offsets of targets, for languages without such statements.

_TURNS: Final = ("rx", "ry", "rz")
_ZEROS: Final = (ex.Number(0), ex.Number(0.0))


def relative(program: st.Program, work: TranslationContext) -> st.Program:
    """The program with offsets as computed positions: from the current position, or from the target."""
    own = _Relative(program, work, work.symbols(program), work.limits.native_offsets)
    routines = []
    for routine in program.routines:
        own.name = routine.name
        rows: list[st.Statement] = []
        external = False
        for s in routine.body:
            if isinstance(s, st.ExternalTool):
                external = s.tool is not None
            if isinstance(s, st.Move):
                if external:
                    says = "a move with the tool fixed in space, where the arm holds the work"
                    work.lose(s, Fate.REFUSED, "statement", says)
                rows += own.move(s)
            else:
                rows.append(s)
        routines.append(with_rows(routine, rows))
    program = with_routines(program, routines)
    return replace(program, data=(*program.data, *own.declared)) if own.declared else program


@dataclass(slots=True)
class _Relative:
    program: st.Program
    work: TranslationContext
    symbols: Symbols
    native: frozenset[str]
    name: str = ""
    declared: list[st.Declare] = field(default_factory=list)  # axis values that are put together

    def move(self, s: st.Move) -> list[st.Statement]:
        if s.relative is not None and not _is_native(s, self.work.limits):
            if (axes := self._axes(s.targets[0])) is not None:
                return self._joints_from_here(s, axes)
            return [self._from_here(s)]
        if s.relative is not None and isinstance(s.targets[0], ex.Function) and s.targets[0].name == "joints":
            return self._joints_from_here(s, list(s.targets[0].arguments))
        if s.relative is not None and self._turns(s.targets[0]) and s.relative.kind != "tool":
            self.work.lose(s, Fate.APPROXIMATED, "orientation", _TURNING)
        if (s.offset is not None or s.tool_offset is not None) and "offset" not in self.native:
            return [self._offset(s)]
        return [s]

    def _turns(self, offset: ex.Expression) -> bool:
        """Whether an offset of another maker's program is known to turn the tool."""
        own = self.work.source.vendor == self.work.target
        by = None if own else self.symbols.fixed_position(self.name, offset)
        return by is not None and by.kind == "pose" and any(_moved(by.values)[3:])

    def _axes(self, offset: ex.Expression) -> list[ex.Expression] | None:
        """What an offset in joint values adds to each axis; None for any other offset."""
        if isinstance(offset, ex.Function) and offset.name == "joints":
            return list(offset.arguments)
        by = self.symbols.fixed_position(self.name, offset)
        if by is None or by.kind != "joint":
            return None
        beside: list[ex.Expression] = [ex.NamedArgument("axes")] if any(by.external) else []
        return [
            *(written_component(value or 0.0, by.kind, at) for at, value in enumerate(by.values[:6])),
            *beside,
        ]

    def _joints_from_here(self, s: st.Move, by: list[ex.Expression]) -> list[st.Statement]:
        """A move to the current axis values, to each of which its offset is added before."""
        if any(isinstance(one, ex.NamedArgument) for one in by):
            self.work.lose(s, Fate.REFUSED, "relative", "a move by an offset of external axes")
            return [s]
        name = ex.Named(self.work.helper("target"))
        self.declared.append(st.Declare(0, name.name, "joints", shared=True))
        before: list[st.Statement] = [st.Assign(s.line, name, ex.SystemValue("current-joints"))]
        for at, value in enumerate(by):
            if value not in _ZEROS:
                axis = component(name, "joint", at)
                before.append(st.Assign(s.line, axis, ex.Binary("+", axis, value)))
        return [*before, replace(s, targets=(name,), relative=None)]

    def _from_here(self, s: st.Move) -> st.Move:
        """A relative move as a move to a computed position; the middle point of an arc is an offset, too."""
        relative = s.relative
        assert relative is not None
        own_frame = relative.kind == "own" or relative == s.frame
        if relative.kind != "tool" and not own_frame and not _is_base(relative):
            self.work.lose(
                s, Fate.REFUSED, "relative", "a move by an offset in another frame than the move's own"
            )
            return s
        frame = s.frame if own_frame or relative.kind == "tool" else _BASE
        seen = isinstance(frame, ex.FrameRef) and _is_base(frame)
        if self.work.limits.position_read_in == "base" and not seen:
            if relative.kind != "tool":
                says = "a joint move by an offset in another frame than the base, where the position is read"
                self.work.lose(s, Fate.REFUSED, "relative", says)
                return s
            frame = _BASE
        here = self._place(s.tool, frame)
        target = self._moved(s, here, s.targets[0])
        via = None if s.via is None else self._moved(s, here, s.via)
        if target is None or (s.via is not None and via is None):
            return s
        return replace(s, targets=(target,), via=via, relative=None, frame=frame)

    def _moved(self, s: st.Move, here: ex.Expression, offset: ex.Expression) -> ex.Expression | None:
        """The position at an offset from `here`; None where it is rejected."""
        by = self._offset_value(offset)
        values: Sequence[ex.Expression]
        if by is not None and by.kind != "joint":
            values = _written(by)
        elif by is None and isinstance(offset, ex.Named) and self._is_pose(offset):
            values = self._components(offset)
        elif isinstance(offset, ex.Function) and offset.name == "pose-angles" and len(offset.arguments) == 6:
            values = offset.arguments
        elif (
            isinstance(offset, ex.Function)
            and offset.name == "pose-offset"
            and _is_nothing(offset.arguments[0])
        ):
            values = (*offset.arguments[1:4], *[ex.Number(0)] * 3)
        else:
            self.work.lose(s, Fate.REFUSED, "relative", "a move by an offset that is computed")
            return None
        turns = sum(v not in _ZEROS for v in values[3:])
        if s.relative is not None and s.relative.kind != "tool":
            if by is None and any(self._is_left_open(offset, turn) for turn in _TURNS):
                says = "the offset's angles, which nothing here sets, are left out: they are taken for zero"
                self.work.lose(s, Fate.APPROXIMATED, "orientation", says)
                self.work.ask("see that these offsets have no angles", _name_of(offset))
                turns = 0
            if not turns:
                return ex.Function("pose-offset", (here, *values[:3]))
            self.work.lose(s, Fate.REFUSED, "relative", "a move by an offset that turns the tool")
            return None
        # About z first, as no `pose-relative-tool` turns.
        if turns > 1 or (turns and self._is_computed(list(values))):
            turned = offset if by is None else replace(by, values=_moved(by.values))
            return ex.Function("pose-product", (here, turned))
        return ex.Function("pose-relative-tool", (here, *values))

    def _place(self, tool: ex.Expression | None, frame: ex.Expression | None) -> ex.Expression:
        """A reading of the current position in the frame of the move."""
        return seen_in(tool, frame) if self.work.limits.position_read_in == "named" else HERE

    def _offset(self, s: st.Move) -> st.Move:
        target = s.targets[0]
        fixed = self.symbols.fixed_position(self.name, target)
        if fixed is not None and fixed.kind == "joint":
            self.work.lose(
                s, Fate.REFUSED, "offset", "an offset from a position that is given by axis values"
            )
            return replace(s, offset=None, tool_offset=None)
        for offset, name in ((s.offset, "pose-offset"), (s.tool_offset, "pose-relative-tool")):
            if offset is None:
                continue
            by = self._offset_value(offset)
            values: list[ex.Expression] = []
            if by is not None and by.kind != "joint":
                values += _written(by)
            elif isinstance(offset, ex.Named) and by is None:
                values += self._components(offset)
            if by is not None and by.kind == "joint":
                self.work.lose(s, Fate.REFUSED, "offset", "an offset in joint values")
                return s
            turns = sum(v not in _ZEROS for v in values[3:])
            # `pose-relative-tool` turns about x first, an offset's angles about z first: several are a product.
            if not values or (turns and (turns > 1 or name == "pose-offset" or self._is_computed(values))):
                # It turns as well, or may do so: a frame before the target, or one behind it.
                pair = (offset, target) if name == "pose-offset" else (target, offset)
                target = ex.Function("pose-product", pair)
            else:
                target = ex.Function(name, (target, *(values[:3] if name == "pose-offset" else values)))
        return replace(s, targets=(target,), offset=None, tool_offset=None)

    def _components(self, offset: ex.Named) -> list[ex.Expression]:
        """The components of a position that the program computes; angles that only it could set are zero."""
        if not self.work.limits.numbered and any(
            self._is_left_open(offset, part) for part in ("x", "y", "z", *_TURNS)
        ):
            self.work.ask("set these values, which are zeros now", offset.name)
        return [
            *(ex.Member(offset, name) for name in ("x", "y", "z")),
            *(
                ex.Number(0)
                if self._never(offset, name) and not self._is_left_open(offset, name)
                else ex.Member(offset, name)
                for name in _TURNS
            ),
        ]

    def _is_set_elsewhere(self, e: ex.Expression) -> bool:
        """Whether a register has the values that an operator or another program gave it, and none from here."""
        return _name_of(e) in self.work.registers and not any(
            isinstance(s, st.Assign) and e in expressions_of(s.target) for s in self.program.statements()
        )

    def _is_left_open(self, e: ex.Expression, member: str) -> bool:
        """Whether no statement sets this component of a register: an operator or another program does."""
        if not isinstance(e, ex.Named) or e.name not in self.work.registers:
            return False
        places = (e, ex.Member(e, member))
        return not any(isinstance(s, st.Assign) and s.target in places for s in self.program.statements())

    def _is_pose(self, name: ex.Named) -> bool:
        symbol = self.symbols.find(self.name, name.name)
        return symbol is not None and symbol.type == "position" and not symbol.sizes

    def _offset_value(self, offset: ex.Expression) -> ex.PositionLiteral | None:
        """The constant value of an offset; None where it has none, or only a camera or another program sets it."""
        if not isinstance(offset, ex.Named) or offset.name not in self.work.registers:
            return self.symbols.fixed_position(self.name, offset)
        by = self.symbols.fixed_position(self.name, offset)
        if by is not None and not any(v == v and v for v in by.values):
            says = f"the values of {offset.name} are not in the program: zeros are written"
            self.work.lose(0, Fate.APPROXIMATED, "variable", says)
            self.work.ask("set these values, which are zeros now", offset.name)
            return None
        return by

    def _is_computed(self, values: list[ex.Expression]) -> bool:
        """Whether an angle is computed that the target can only express as a product of poses."""
        return not self.work.limits.computed_turns and not all(isinstance(v, ex.Number) for v in values)

    def _never(self, name: ex.Named, member: str) -> bool:
        """Whether nothing ever sets this component of a position to anything but zero, nor is it another at first."""
        if self._is_set_elsewhere(name):
            return False
        first = (d.value for d in self.program.declarations() if d.name == name.name)
        if any(isinstance(e, ex.PositionLiteral) and _component(e, member) for e in first):
            return False
        for s in self.program.statements():
            if not isinstance(s, st.Assign):
                continue
            if s.target == ex.Member(name, member) and s.value not in _ZEROS:
                return False
            if s.target == name:
                value = self.symbols.fixed_position(self.name, s.value)
                if value is None or any(value.values[3:6]):
                    return False
        return True


def _component(e: ex.PositionLiteral, member: str) -> bool:
    """Whether this component of a position is written, and not zero."""
    value = dict(zip(("x", "y", "z", "rx", "ry", "rz"), e.values, strict=False)).get(member, 0.0)
    return bool(value) and not math.isnan(value)


def _name_of(e: ex.Expression) -> str:
    return e.name if isinstance(e, ex.Named) else ""


def _written(by: ex.PositionLiteral) -> list[ex.Number]:
    """The components in mm and deg; those that are not written are 0."""
    scales = [mm] * 3 + [deg] * 3
    return [
        ex.Number(0 if math.isnan(v) or not v else float(f"{v / scale:.9g}"))
        for v, scale in zip(by.values[:6], scales, strict=True)
    ]


def _is_nothing(e: ex.Expression) -> bool:
    return isinstance(e, ex.PositionLiteral) and not any(e.values[:6])


def _moved(values: tuple[float, ...]) -> tuple[float, ...]:
    """The components in m and rad; those that are not written are 0."""
    return tuple(0.0 if math.isnan(v) else v for v in values[:6])


def _is_base(frame: ex.FrameRef) -> bool:
    return frame.kind in ("base", "robot")


# --- Shifts ---
# Shifts of all following targets, for languages that have no such statement: an offset of each target.

_SHIFT: Final = ("shift",)
_NO_SHIFT: Final = ex.PositionLiteral("pose", (0.0,) * 6)
_PART_OF_OTHERS: Final = "a move within a shift of all targets"


def shifts(program: st.Program, work: TranslationContext) -> st.Program:
    """Each target with the shift that is active at its move; ShiftOn and ShiftOff set a variable, or are dropped."""
    if not any(isinstance(s, st.ShiftOn) for s in work.rare(program)):
        return program
    return _Shifts(program, work, work.symbols(program)).program_without()


@dataclass(slots=True)
class _Shifts:
    """`changes`: the statements that switch a shift, by number. `held`: a variable with the active shift, needed where
    several of them can reach a move, or one whose values change.
    """

    program: st.Program
    work: TranslationContext
    symbols: Symbols
    changes: list[tuple[str, st.ShiftOn | st.ShiftOff]] = field(default_factory=list)
    held: ex.Named | None = None
    needed: set[int] = field(default_factory=set)  # changes that can reach a move which uses the variable
    refused: set[int] = field(default_factory=set)

    def program_without(self) -> st.Program:
        program = self.program
        self.changes = [
            (r.name, s) for r in program.routines for s in r.body if isinstance(s, (st.ShiftOn, st.ShiftOff))
        ]
        numbers = {id(s): number for number, (_, s) in enumerate(self.changes)}

        def sets(s: st.Statement) -> dict[Key, int]:
            return {_SHIFT: numbers[id(s)]} if id(s) in numbers else {}

        ways = reaching(program, sets, frozenset({st.ShiftOn, st.ShiftOff}))
        moved = [
            [
                self._move(r.name, s, ways.at(r.name, at, _SHIFT)) if isinstance(s, st.Move) else s
                for at, s in enumerate(r.body)
            ]
            for r in program.routines
        ]
        routines = [
            with_rows(r, [new for s in rows for new in self._switched(s)])
            for r, rows in zip(program.routines, moved, strict=True)
        ]
        program = with_routines(program, routines)
        if self.held is None:
            return program
        kept = st.Declare(0, self.held.name, "position", _NO_SHIFT, shared=True)
        return replace(program, data=(*program.data, kept))

    def _switched(self, s: st.Statement) -> list[st.Statement]:
        """The statements that replace one that switches a shift."""
        if not isinstance(s, (st.ShiftOn, st.ShiftOff)):
            return [s]
        number = next(at for at, (_, one) in enumerate(self.changes) if one is s)
        if number in self.refused or s.coordinated:
            self.work.lose(s, Fate.REFUSED, "shift", "a shift of all following targets")
            return [s]
        if self.held is None or number not in self.needed:
            return [st.Comment(s.line, s.comment)] if s.comment else []
        value = s.offset if isinstance(s, st.ShiftOn) else _NO_SHIFT
        return [st.Assign(s.line, self.held, value, comment=s.comment)]

    def _move(self, routine: str, s: st.Move, found: Set[int]) -> st.Move:
        on = {
            number: one
            for number in found
            if number >= 0 and isinstance(one := self.changes[number][1], st.ShiftOn)
        }
        if not on or s.relative is not None:
            return s
        frames = {one.frame for one in on.values()}
        constants = [self.symbols.fixed_position(self.changes[n][0], one.offset) for n, one in on.items()]
        says = self._objection(routine, s, frames, constants, list(on.values()))
        if says:
            self.refused |= set(on)
            self.work.lose(s, Fate.REFUSED, "shift", says)
            return s
        (frame,) = frames
        by = constants[0] if len(found) == 1 else None
        if by is None:
            self.held = self.held or ex.Named(self.work.helper("shift"))
            self.needed |= found
        targets = tuple(self._shifted(target, frame, by) for target in s.targets)
        return replace(s, targets=targets, via=None if s.via is None else self._shifted(s.via, frame, by))

    def _objection(
        self,
        routine: str,
        s: st.Move,
        frames: Set[ex.FrameRef | None],
        constants: list[ex.PositionLiteral | None],
        on: list[st.ShiftOn],
    ) -> str:
        """Why the shift cannot be added to a move's targets; empty where it can."""
        if len(frames) > 1 or any(one.coordinated for one in on) or s.offset is not None:
            return _PART_OF_OTHERS
        (frame,) = frames
        if (
            frame is not None
            and frame.kind != "tool"
            and frame != s.frame
            and not _is_same_base(frame, s.frame)
        ):
            return f"{_PART_OF_OTHERS}, which is meant in another frame than its own"
        for target in (*s.targets, *(() if s.via is None else (s.via,))):
            fixed = self.symbols.fixed_position(routine, target)
            if fixed is not None and fixed.kind == "joint":
                return f"{_PART_OF_OTHERS} to axis values"
        turns = any(by is None or any(by.values[3:6]) or by.kind == "joint" for by in constants)
        if (
            frame is not None
            and turns
            and not all(self._keeps_turn(one, by) for one, by in zip(on, constants, strict=True))
        ):
            return f"{_PART_OF_OTHERS} that may turn the tool"
        return ""

    def _keeps_turn(self, one: st.ShiftOn, by: ex.PositionLiteral | None) -> bool:
        """Whether a shift has no angles, so that the tool does not turn."""
        if by is not None:
            return by.kind != "joint" and not any(by.values[3:6])
        relative = _Relative(self.program, self.work, self.symbols, frozenset())
        return isinstance(one.offset, ex.Named) and all(relative._never(one.offset, turn) for turn in _TURNS)

    def _shifted(
        self, target: ex.Expression, frame: ex.FrameRef | None, by: ex.PositionLiteral | None
    ) -> ex.Expression:
        """The target under a shift in `frame`; None: one more frame inside the target's own."""
        held = self.held
        if by is None:
            assert held is not None
            if frame is None:
                return ex.Function("pose-product", (held, target))
            along: list[ex.Expression] = [ex.Member(held, name) for name in ("x", "y", "z")]
        else:
            if frame is None and any(by.values[3:6]):
                return ex.Function("pose-product", (by, target))
            along = list(_written(by)[:3])
        if frame is not None and frame.kind == "tool":
            return ex.Function("pose-relative-tool", (target, *along, *[ex.Number(0)] * 3))
        return ex.Function("pose-offset", (target, *along))


def _is_same_base(one: ex.FrameRef, other: ex.Expression | None) -> bool:
    return _is_base(one) and isinstance(other, ex.FrameRef) and _is_base(other)
