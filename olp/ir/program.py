"""The program: what is written, without any vendor's words. All statements, one class each, in routines.

Control flow stays as written (block markers and labels, each a statement with its line), so that structure, names and
comments survive a translation. So do moves: which path, where to, how fast, how the end is passed.
`block_structure.py` pairs the markers; the interpreter executes; templates write.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, fields
from enum import StrEnum
from typing import Final, NamedTuple

from olp.core.diagnostic import Diagnostic
from olp.core.fast_dataclass import fast_init
from olp.core.source import Source
from olp.ir.expressions import Expression, FrameRef, Named, Position, Quantity, Signal, Store, Variable
from olp.ir.points import PointTable


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
    AXIS = "axis"  # of the axis that turns furthest [rad/s]
    TIME = "time"  # no speed: the move takes this long [s]


class Speed(NamedTuple):
    unit: SpeedUnit
    value: Quantity  # SI after scaling: fraction, m/s, rad/s or s
    native: str = ""  # the name it was written with (RAPID v100)


class AccelerationUnit(StrEnum):
    """What a programmed acceleration means."""

    FRACTION = "fraction"  # of the rated one [1]
    TRAVEL = "travel"  # of the tool centre point [m/s²]
    AXIS = "axis"  # of the axis that turns furthest [rad/s²]


class Acceleration(NamedTuple):
    unit: AccelerationUnit
    value: Quantity  # SI after scaling: fraction, m/s² or rad/s²


class BlendKind(StrEnum):
    """How a move's end is passed."""

    LEVEL = "level"  # a controller's position level; 0 is an exact stop
    CONTINUOUS = "continuous"  # no stop, size left to the controller (ERC: CONT)
    RADIUS = "radius"  # [m]; 0 is an exact stop
    SHARE = "share"  # of half of the way to the point [1] (KRL $APO.CPTP)
    SPEED = "speed"  # share of the programmed speed that is left at the corner [1]
    TURN = "turn"  # [rad] of reorientation that is left (KRL $APO.CORI)


class Blend(NamedTuple):
    """`value` None: the modal one of this kind; of CONTINUOUS there is none."""

    kind: BlendKind
    value: Quantity | None = None
    native: str = ""  # the name it was written with (RAPID z10)


class Search(NamedTuple):
    """Move until `signal` turns `on`, at most `distance` [m] or `time` [s] beyond."""

    signal: Signal
    on: bool
    time: Quantity | None = None
    distance: Quantity | None = None


class PathTrigger(NamedTuple):
    """An output that switches while a move is under way, `metres` and `seconds` behind its end, or its start.

    Negative ones lie before that end. Times count from where the arm is at the distance. `above`: how many lines
    above the move it stands, 0 where the move itself names it.
    """

    signal: Signal
    value: Expression
    at_start: bool
    metres: Quantity | None = None
    seconds: Quantity | None = None
    above: int = 0

    @property
    def is_shifted(self) -> bool:
        """Whether it acts anywhere else than at an end of the move."""
        return any(far is not None and far.literal != 0.0 for far in (self.metres, self.seconds))


class MovePart(NamedTuple):
    """What another control group does during the same move."""

    path: Path | None  # None: a reference point only (+REFP)
    targets: tuple[Position, ...]
    speed: Speed | None = None
    blend: Blend | None = None


@fast_init
@dataclass(frozen=True, slots=True)
class Move:
    """A motion of one or more control groups in step.

    `targets`: the leading group's positions, as written (robot, then its track, then a station): taught points and
    position variables in INFORM, any expression with a position as its value elsewhere.
    `speed` None: the modal speed holds. `relative`: the target is added to the current position in that frame.
    `coordinated`: the speed is relative to the work on the station in `parts` (SMOV).
    """

    line: int
    path: Path
    targets: tuple[Expression, ...]
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
    via: Expression | None = None  # of an arc that is one statement
    arc: Quantity | None = None  # [rad] that an arc turns about its axis instead of ending at its target
    rate: Acceleration | None = None  # of this move alone; beside it `acceleration` is None
    turn: Quantity | None = None  # the tool turns no faster [rad/s], whatever the speed
    tool: Expression | None = None  # None: that of the point, else the modal one
    frame: Expression | None = None  # None: that of the point, else the modal one
    offset: Expression | None = None  # a pose added in the move's frame
    tool_offset: Expression | None = None  # a pose added in the tool's axes
    triggers: tuple[PathTrigger, ...] = ()  # in the order in which they are named

    @property
    def has_signals(self) -> bool:
        """Whether it may name signals."""
        return self.until is not None or self.search is not None or bool(self.triggers)


@dataclass(frozen=True, slots=True)
class Reference:
    """A reference point for weaving or search. Nothing moves."""

    line: int
    number: Expression
    targets: tuple[Position, ...]
    parts: tuple[MovePart, ...] = ()
    coordinated: bool = False
    comment: str = ""


@fast_init
@dataclass(frozen=True, slots=True)
class SetAcceleration:
    """Modal accelerations for moves that name none; FRACTION holds for all kinds of moves unless `path` says which."""

    line: int
    rates: tuple[Acceleration, ...]
    path: Path | None = None
    comment: str = ""


@fast_init
@dataclass(frozen=True, slots=True)
class SetBlend:
    """Modal sizes of blends for moves whose blend names a kind and no size."""

    line: int
    blends: tuple[Blend, ...]
    comment: str = ""


@fast_init
@dataclass(frozen=True, slots=True)
class SetTool:
    """The tool that holds from here on: FrameRef("tool", n), a name, or a pose on the flange."""

    line: int
    tool: Expression
    comment: str = ""


@fast_init
@dataclass(frozen=True, slots=True)
class SetFrame:
    """The frame that targets stand in from here on: FrameRef("user", n), FrameRef("base"), a name, or a pose."""

    line: int
    frame: Expression
    comment: str = ""


@dataclass(frozen=True, slots=True)
class SetOverride:
    """All programmed speeds are multiplied by `share` [1] from here on.

    `fastest`: no tool moves faster then [m/s] (RAPID VelSet); moves that last a given time are left alone.
    """

    line: int
    share: Quantity
    comment: str = ""
    fastest: Quantity | None = None


@dataclass(frozen=True, slots=True)
class ObeyFlags:
    """From here on joint moves go to the arm flags of their targets (`on`), or to the nearest axes."""

    line: int
    on: bool
    comment: str = ""


@fast_init
@dataclass(frozen=True, slots=True)
class SetSpeed:
    """Modal speeds for moves that name none; `turn` [rad/s] bounds the tool's turning on all of them."""

    line: int
    speeds: tuple[Speed, ...]
    comment: str = ""
    turn: Quantity | None = None
    path: Path | None = None  # FRACTION of moves of this path only; None: of joint moves


@fast_init
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


@fast_init
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


@fast_init
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
    result: Expression | None = None  # where the returned value goes


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
    variable: Variable | Named
    start: Expression
    stop: Expression
    step: Expression | None = None
    comment: str = ""


@dataclass(frozen=True, slots=True)
class Next:
    line: int
    variable: Variable | Named | None
    comment: str = ""


@dataclass(frozen=True, slots=True)
class Repeat:
    """Opens a loop that its Until closes: the body runs at least once."""

    line: int
    comment: str = ""


@dataclass(frozen=True, slots=True)
class Until:
    """Leaves the loop when the condition holds."""

    line: int
    condition: Expression
    comment: str = ""


@dataclass(frozen=True, slots=True)
class Break:
    """Leaves the innermost loop."""

    line: int
    comment: str = ""


@dataclass(frozen=True, slots=True)
class Continue:
    """Goes to the next pass of the innermost loop."""

    line: int
    comment: str = ""


@fast_init
@dataclass(frozen=True, slots=True)
class Declare:
    """A named variable comes into being.

    `type`: integer, real, boolean, string, position, joints, tool, frame, speed, zone, signal, or the language's word.
    `storage`: variable, constant or persistent. `sizes`: of an array. `shared`: other files see it. `native`: the
    type as written. `above`: comments on the lines above it, outside of routines. A declaration of a position may be
    taught data that only looks like a program line.
    """

    line: int
    name: str
    type: str
    value: Expression | None = None
    sizes: tuple[Expression, ...] = ()
    storage: str = "variable"
    shared: bool = False
    native: str = field(default="", compare=False)
    comment: str = ""
    above: tuple[str, ...] = field(default=(), compare=False)


def is_same(one: Declare, other: Declare) -> bool:
    """Whether two declarations of a name say the same of it, wherever they stand."""
    return (one.type, one.value, one.sizes, one.storage) == (
        other.type,
        other.value,
        other.sizes,
        other.storage,
    )


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
    offset: Expression
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


@fast_init
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
    """A statement switched off by the programmer; kept word for word.

    `handler`: it is switched on, and belongs to the handler of this name, which runs where something fails: `ERROR`,
    `UNDO`, `BACKWARD`, `LISTED` (an ERROR of some errors alone). No plan shows that. `means`: its statements.
    `beside`: what the words mean beyond the statement before, which they stand for; a translation leaves that out.
    `acts`: the machine does something else without that.
    """

    line: int
    text: str
    handler: str = ""
    beside: str = ""
    means: tuple[Statement, ...] = field(default=(), compare=False)
    acts: bool = False


@dataclass(frozen=True, slots=True)
class Opaque:
    """A statement that olp keeps word for word and does not model."""

    line: int
    text: str


Statement = (
    Move | Reference | SetSpeed | Assign | Update | Clear | SetOutput | PulseOutput | ReadInput | Dwell | Wait
    | Label | Jump | Call | Return | If | ElseIf | Else | EndIf | While | EndWhile | For | Next
    | Switch | Case | Default | EndSwitch | Pause | StartTask | WaitTask | Synchronise
    | Repeat | Until | Break | Continue | Declare
    | SetAcceleration | SetBlend | SetTool | SetFrame | SetOverride | ObeyFlags
    | ShiftOn | ShiftOff | DefineFrame | ExternalTool | Message | Process | Comment | Begin | End | Disabled | Opaque
)  # fmt: skip
# Neither move nor wait nor compute: notes, declarations, and what later moves take over.
MOVES_NOTHING: Final = (Comment, Declare, Begin, SetSpeed, SetBlend, SetAcceleration, SetTool, SetFrame)
# Reached in several ways: what held at the line above need not hold here. Behind UNTIL stands who left the loop, too.
WAYS_MEET: Final = (
    Label, Else, ElseIf, EndIf, While, EndWhile, Repeat, Until, For, Next, Case, Default, EndSwitch,
)  # fmt: skip


@dataclass(frozen=True, slots=True)
class ControlGroup:
    """The mechanisms that one part of a move drives, as written (`RB1`, `BS1`, `ST1` …)."""

    mechanisms: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class Parameter:
    """What a routine takes, by name; `type` as that of `Declare`.

    `by_reference`: the caller's variable changes with it. `optional`: the caller may leave it out, and `default` holds
    then. `switch`: it is given or not, and has no value. `sizes`: of an array, elements per dimension; `Unknown("")`
    where the caller decides.
    """

    name: str
    type: str = ""
    by_reference: bool = False
    optional: bool = False
    switch: bool = False
    default: Expression | None = None
    native: str = ""
    sizes: tuple[Expression, ...] = ()


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
    parameters: tuple[Parameter, ...] = ()
    returns: str = ""  # the type of the value, as `Declare.type`; empty: none
    data: tuple[Declare, ...] = ()  # of a file beside it (KRL .dat): keep their values between runs
    shared: bool = True  # other files may call it
    starts: bool = False  # a main routine of its own file, beside that of the program


@dataclass(frozen=True, slots=True)
class Program:
    """All routines of one file, with the text they came from. Nothing of the text is lost."""

    vendor: str
    source: Source
    routines: tuple[Routine, ...]
    diagnostics: tuple[Diagnostic, ...] = ()
    line_kinds: bytes = b""  # one LineKind per source line, so that no line is ever unaccounted for
    data: tuple[Declare, ...] = ()  # declared outside the routines
    main: str = ""  # the routine that runs; empty: the first one
    companions: tuple[Source, ...] = ()  # files read with it (KRL .dat); diagnostics name theirs
    main_is_guessed: bool = False  # nothing in the text says which routine runs: `main` is the first that can

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

    def declarations(self) -> Iterator[Declare]:
        """The data that routines share, then of each routine its own data and what its body declares."""
        yield from self.data
        for routine in self.routines:
            yield from routine.data
            yield from (s for s in routine.body if type(s) is Declare)


def like(program: Program, model: Program) -> Program:
    """`program` as an object of the class of `model`: what was read again keeps the methods of what it came from."""
    if type(program) is type(model):
        return program
    return type(model)(**{field.name: getattr(program, field.name) for field in fields(Program)})


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
