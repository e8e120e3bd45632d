"""All statements of a program, one class each; moves have a module of their own.

Control flow stays as written: block markers and labels, each a statement with its line.
"""

from __future__ import annotations

from dataclasses import dataclass, field

from olp.core.fast_dataclass import fast_init
from olp.ir.expressions import Expression, FrameRef, Named, Position, Quantity, Signal, Variable
from olp.ir.moves import (
    Move,
    ObeyFlags,
    Reference,
    SetAcceleration,
    SetBlend,
    SetFrame,
    SetOverride,
    SetSpeed,
    SetTool,
)


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
    type as written. A declaration of a position may be taught data that only looks like a program line.
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
    """

    line: int
    text: str
    handler: str = ""
    beside: str = ""
    means: tuple[Statement, ...] = field(default=(), compare=False)


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
