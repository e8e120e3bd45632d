"""The program: what is written, without any vendor's words. Statements in order, each with its line.

Control flow stays as written (block markers and labels), so that structure, names and comments survive a
translation. `control.py` pairs the markers; the interpreter executes; templates write.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from enum import StrEnum
from typing import TYPE_CHECKING, NamedTuple

from olp.diagnostic import Diagnostic
from olp.expression import Expression, FrameRef, Position, Quantity, Signal, Store, Variable
from olp.points import PointTable
from olp.source import Source

if TYPE_CHECKING:
    import os

    from olp.plan import Plan


class Path(StrEnum):
    """The shape of a move between two points."""

    JOINT = "joint"
    LINEAR = "linear"
    CIRCULAR = "circular"
    SPLINE = "spline"


class SpeedUnit(StrEnum):
    """What a programmed speed means."""

    FRACTION = "fraction"  # of the axes' rated speed [1]
    TRAVEL = "travel"  # of the tool centre point [m/s]
    TURN = "turn"  # of the tool's orientation [rad/s]


class Speed(NamedTuple):
    unit: SpeedUnit
    value: Quantity  # SI after scaling: fraction, m/s or rad/s


class BlendKind(StrEnum):
    """How a move's end is passed."""

    LEVEL = "level"  # a controller's position level; 0 is an exact stop
    CONTINUOUS = "continuous"  # no stop, size left to the controller (ERC: CONT)
    RADIUS = "radius"  # [m]


class Blend(NamedTuple):
    kind: BlendKind
    value: Quantity | None = None


class Search(NamedTuple):
    """Move until `signal` turns `on`, at most `distance` [m] or `time` [s] beyond."""

    signal: Signal
    on: bool
    time: Quantity | None = None
    distance: Quantity | None = None


class MovePart(NamedTuple):
    """What another control group does during the same move."""

    path: Path | None  # None: a reference point only (+REFP)
    targets: tuple[Position, ...]
    speed: Speed | None = None
    blend: Blend | None = None


@dataclass(frozen=True, slots=True)
class Move:
    """A motion of one or more control groups in step.

    `targets`: the leading group's positions, as written (robot, then its track, then a station).
    `speed` None: the modal speed holds. `relative`: the target is added to the current position in that frame.
    `coordinated`: the speed is relative to the work on the station in `parts` (SMOV).
    """

    line: int
    path: Path
    targets: tuple[Position, ...]
    speed: Speed | None = None
    blend: Blend | None = None
    parts: tuple[MovePart, ...] = ()
    comment: str = ""
    acceleration: Quantity | None = None  # fraction of rated
    deceleration: Quantity | None = None  # fraction of rated
    relative: FrameRef | None = None
    coordinated: bool = False
    end_of_arc: bool = False
    search: Search | None = None
    until: Expression | None = None  # the move ends early when this holds
    no_wait: bool = False  # the next statements run while this move is under way
    passes: str = ""  # multi-pass tag, as written (T00001)
    other: tuple[tuple[str, Expression], ...] = ()  # further tags and their values, not modelled


@dataclass(frozen=True, slots=True)
class Reference:
    """A reference point for weaving or search. Nothing moves."""

    line: int
    number: Expression
    targets: tuple[Position, ...]
    parts: tuple[MovePart, ...] = ()
    coordinated: bool = False
    comment: str = ""


@dataclass(frozen=True, slots=True)
class SetSpeed:
    """Modal speeds for moves that name none."""

    line: int
    speeds: tuple[Speed, ...]
    comment: str = ""


@dataclass(frozen=True, slots=True)
class Assign:
    """target := value. The target may be a variable, an element of a position, a user frame or a tool."""

    line: int
    target: Expression
    value: Expression
    comment: str = ""


@dataclass(frozen=True, slots=True)
class Update:
    """target := target op operand, op one of + - * / and or xor not; INC and DEC are + 1 and - 1."""

    line: int
    operator: str
    target: Expression
    operand: Expression | None
    comment: str = ""


@dataclass(frozen=True, slots=True)
class Clear:
    """Zeroes `count` variables from `target` on (None: all), or the call stack when `target` is None."""

    line: int
    target: Expression | None
    count: Expression | None = None
    comment: str = ""


@dataclass(frozen=True, slots=True)
class SetOutput:
    line: int
    signal: Signal
    value: Expression
    comment: str = ""


@dataclass(frozen=True, slots=True)
class PulseOutput:
    """Switches an output on for `duration` [s] while the program goes on."""

    line: int
    signal: Signal
    duration: Quantity | None = None
    condition: Expression | None = None
    comment: str = ""
    spelling: str = field(default="", compare=False)  # the vendor's word for the condition, see Wait


@dataclass(frozen=True, slots=True)
class ReadInput:
    line: int
    target: Expression
    signal: Signal
    comment: str = ""


@dataclass(frozen=True, slots=True)
class Dwell:
    """Waits a given time [s]."""

    line: int
    duration: Quantity
    comment: str = ""


@dataclass(frozen=True, slots=True)
class Wait:
    """Waits until `condition` holds, at most `timeout` [s] (None: for ever).

    `spelling`: the word that the vendor wrote where several mean the same (INFORM FOREXPRESS, IFEXPRESS,
    IFTHENEXP); a hint for the vendor's own writer, no part of the meaning.
    """

    line: int
    condition: Expression
    timeout: Quantity | None = None
    comment: str = ""
    spelling: str = field(default="", compare=False)  # the vendor's word for the condition, see Wait


@dataclass(frozen=True, slots=True)
class Label:
    line: int
    name: str
    comment: str = ""


@dataclass(frozen=True, slots=True)
class Jump:
    """To a label of this routine: by name, or computed (`target` an expression whose value is the label's name)."""

    line: int
    target: str | Expression
    condition: Expression | None = None
    comment: str = ""
    spelling: str = field(default="", compare=False)  # the vendor's word for the condition, see Wait


@dataclass(frozen=True, slots=True)
class Call:
    """Another routine by name, or a macro by number. `jump`: control does not come back."""

    line: int
    routine: str
    arguments: tuple[Expression, ...] = ()
    condition: Expression | None = None
    macro: Expression | None = None
    jump: bool = False
    comment: str = ""
    spelling: str = field(default="", compare=False)  # the vendor's word for the condition, see Wait


@dataclass(frozen=True, slots=True)
class Return:
    line: int
    value: Expression | None = None
    condition: Expression | None = None
    comment: str = ""
    spelling: str = field(default="", compare=False)  # the vendor's word for the condition, see Wait


@dataclass(frozen=True, slots=True)
class If:
    line: int
    condition: Expression
    comment: str = ""
    spelling: str = field(default="", compare=False)  # the vendor's word for the condition, see Wait


@dataclass(frozen=True, slots=True)
class ElseIf:
    line: int
    condition: Expression
    comment: str = ""
    spelling: str = field(default="", compare=False)  # the vendor's word for the condition, see Wait


@dataclass(frozen=True, slots=True)
class Else:
    line: int
    comment: str = ""


@dataclass(frozen=True, slots=True)
class EndIf:
    line: int
    comment: str = ""


@dataclass(frozen=True, slots=True)
class While:
    line: int
    condition: Expression
    comment: str = ""
    spelling: str = field(default="", compare=False)  # the vendor's word for the condition, see Wait


@dataclass(frozen=True, slots=True)
class EndWhile:
    line: int
    comment: str = ""


@dataclass(frozen=True, slots=True)
class For:
    """Counts `variable` from `start` to `stop`, both included, by `step` (None: 1)."""

    line: int
    variable: Variable
    start: Expression
    stop: Expression
    step: Expression | None = None
    comment: str = ""


@dataclass(frozen=True, slots=True)
class Next:
    line: int
    variable: Variable | None
    comment: str = ""


@dataclass(frozen=True, slots=True)
class Switch:
    line: int
    value: Expression
    comment: str = ""


@dataclass(frozen=True, slots=True)
class Case:
    line: int
    values: tuple[Expression, ...]
    comment: str = ""


@dataclass(frozen=True, slots=True)
class Default:
    line: int
    comment: str = ""


@dataclass(frozen=True, slots=True)
class EndSwitch:
    line: int
    comment: str = ""


@dataclass(frozen=True, slots=True)
class Pause:
    """Stops the program until the operator starts it again."""

    line: int
    condition: Expression | None = None
    comment: str = ""
    spelling: str = field(default="", compare=False)  # the vendor's word for the condition, see Wait


@dataclass(frozen=True, slots=True)
class StartTask:
    """Starts a routine in a parallel task."""

    line: int
    routine: str
    task: str
    condition: Expression | None = None
    comment: str = ""
    spelling: str = field(default="", compare=False)  # the vendor's word for the condition, see Wait
    synchronised: bool = False  # the task's moves keep step with this one (INFORM SYNC)


@dataclass(frozen=True, slots=True)
class WaitTask:
    """Waits until a parallel task has ended."""

    line: int
    task: str
    comment: str = ""


@dataclass(frozen=True, slots=True)
class Synchronise:
    """Waits until all tasks have reached the synchronisation point `number`."""

    line: int
    number: Expression
    tasks: Expression | None = None
    comment: str = ""


@dataclass(frozen=True, slots=True)
class ShiftOn:
    """From here on every taught target is moved by `offset` in `frame` (None: the offset's own frame)."""

    line: int
    offset: Position
    frame: FrameRef | None = None
    comment: str = ""
    coordinated: bool = False  # of the station's coordinated group (INFORM SSFTON, SSFTOF)


@dataclass(frozen=True, slots=True)
class ShiftOff:
    line: int
    comment: str = ""
    coordinated: bool = False  # of the station's coordinated group (INFORM SSFTON, SSFTOF)


@dataclass(frozen=True, slots=True)
class DefineFrame:
    """A user frame from taught points: origin, a point on +x, a point in the x-y plane, and optionally a new origin."""

    line: int
    frame: FrameRef
    points: tuple[Position, ...]
    master_tool: bool = False
    comment: str = ""


@dataclass(frozen=True, slots=True)
class ExternalTool:
    """Turns control about a fixed tool on (`tool` given) or off."""

    line: int
    tool: Expression | None
    comment: str = ""


@dataclass(frozen=True, slots=True)
class Message:
    line: int
    text: Expression
    comment: str = ""


@dataclass(frozen=True, slots=True)
class Process:
    """A process instruction (arc, weave, cut, sensor, operator …): no motion of its own, its time is an assumption.

    `arguments`: (tag, value) in the order of writing; positional words have the tag "".
    """

    line: int
    name: str
    arguments: tuple[tuple[str, Expression], ...] = ()
    comment: str = ""


@dataclass(frozen=True, slots=True)
class Comment:
    """A comment on a line of its own, without its mark."""

    line: int
    text: str


@dataclass(frozen=True, slots=True)
class Begin:
    """The routine's first statement (INFORM NOP)."""

    line: int
    comment: str = ""


@dataclass(frozen=True, slots=True)
class End:
    """The routine's last statement."""

    line: int
    comment: str = ""


@dataclass(frozen=True, slots=True)
class Disabled:
    """A statement switched off by the programmer; kept word for word."""

    line: int
    text: str


@dataclass(frozen=True, slots=True)
class Opaque:
    """A statement that olp keeps word for word and does not model."""

    line: int
    text: str


Statement = (
    Move | Reference | SetSpeed | Assign | Update | Clear | SetOutput | PulseOutput | ReadInput | Dwell | Wait
    | Label | Jump | Call | Return | If | ElseIf | Else | EndIf | While | EndWhile | For | Next
    | Switch | Case | Default | EndSwitch | Pause | StartTask | WaitTask | Synchronise
    | ShiftOn | ShiftOff | DefineFrame | ExternalTool | Message | Process | Comment | Begin | End | Disabled | Opaque
)  # fmt: skip


@dataclass(frozen=True, slots=True)
class ControlGroup:
    """The mechanisms that one part of a move drives, as written (`RB1`, `BS1`, `ST1` …)."""

    mechanisms: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class Routine:
    """One job, subroutine or main program.

    `relative_to`: the job is a relative one, its points hold in that frame. `locals`: allocated local variables per
    kind. `details`: header facts that only the vendor's own writer needs, in order.
    """

    name: str
    line: int
    body: tuple[Statement, ...]
    points: PointTable
    groups: tuple[ControlGroup, ...] = ()
    comment: str = ""
    relative_to: FrameRef | None = None
    locals: Mapping[Store, int] = field(default_factory=dict)
    arguments: tuple[Store | None, ...] = ()
    aliases: Mapping[str, Variable] = field(default_factory=dict)
    details: Mapping[str, str] = field(default_factory=dict)
    last_line: int = 0


@dataclass(frozen=True, slots=True)
class Program:
    """All routines of one file, with the text they came from. Nothing of the text is lost."""

    vendor: str
    source: Source
    routines: tuple[Routine, ...]
    diagnostics: tuple[Diagnostic, ...] = ()
    line_kinds: bytes = b""  # one LineKind per source line, so that no line is ever unaccounted for

    @property
    def path(self) -> str:
        return self.source.path

    def to_bytes(self) -> bytes:
        """The file's bytes, unchanged."""
        return self.source.raw

    def statements(self) -> Iterator[Statement]:
        """All statements of all routines in order of writing."""
        for routine in self.routines:
            yield from routine.body

    def plan(self, robot: object = None, **options: object) -> Plan:
        """Executes the program: see `olp.interpreter.run` for the options."""
        from olp.interpreter import run

        return run(self, robot=robot, **options)  # type: ignore[arg-type]

    def export(
        self, vendor: str, output: str | os.PathLike[str] | None = None, **options: str | None
    ) -> bytes:
        """The program in `vendor`'s language; see `olp.export.export` for the options."""
        from olp.export import export

        return export(self, vendor, output, **options)


class LineKind:
    """What a source line was understood as (values of `Program.line_kinds`)."""

    BLANK = 0
    RECORD = 1  # a header record
    POINT = 2
    STATEMENT = 3
    COMMENT = 4
    FREE_TEXT = 5  # text that the header announces (argument comments)
    OPAQUE = 6  # kept, not modelled
    ERROR = 7  # has a diagnostic
