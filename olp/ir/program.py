"""The program: what is written, without any vendor's words. Statements in order, each with its line.

Control flow stays as written (block markers and labels), so that structure, names and comments survive a
translation. `block_structure.py` pairs the markers; the interpreter executes; templates write.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, fields

from olp.core.diagnostic import Diagnostic
from olp.core.source import Source
from olp.ir.expressions import Expression, FrameRef, Store, Variable
from olp.ir.points import PointTable
from olp.ir.statements import (
    Acceleration,
    AccelerationUnit,
    Assign,
    Begin,
    Blend,
    BlendKind,
    Break,
    Call,
    Case,
    Clear,
    Comment,
    Continue,
    Declare,
    Default,
    DefineFrame,
    Disabled,
    Dwell,
    Else,
    ElseIf,
    End,
    EndIf,
    EndSwitch,
    EndWhile,
    ExternalTool,
    For,
    If,
    Jump,
    Label,
    Message,
    Move,
    MovePart,
    Next,
    ObeyFlags,
    Opaque,
    Path,
    PathTrigger,
    Pause,
    Process,
    PulseOutput,
    ReadInput,
    Reference,
    Repeat,
    Return,
    Search,
    SetAcceleration,
    SetBlend,
    SetFrame,
    SetOutput,
    SetOverride,
    SetSpeed,
    SetTool,
    ShiftOff,
    ShiftOn,
    Speed,
    SpeedUnit,
    StartTask,
    Statement,
    Switch,
    Synchronise,
    Until,
    Update,
    Wait,
    WaitTask,
    While,
)

__all__ = [
    "Acceleration",
    "AccelerationUnit",
    "Assign",
    "Begin",
    "Blend",
    "BlendKind",
    "Break",
    "Call",
    "Case",
    "Clear",
    "Comment",
    "Continue",
    "ControlGroup",
    "Declare",
    "Default",
    "DefineFrame",
    "Disabled",
    "Dwell",
    "Else",
    "ElseIf",
    "End",
    "EndIf",
    "EndSwitch",
    "EndWhile",
    "ExternalTool",
    "For",
    "If",
    "Jump",
    "Label",
    "LineKind",
    "Message",
    "Move",
    "MovePart",
    "Next",
    "ObeyFlags",
    "Opaque",
    "Parameter",
    "Path",
    "PathTrigger",
    "Pause",
    "Process",
    "Program",
    "PulseOutput",
    "ReadInput",
    "Reference",
    "Repeat",
    "Return",
    "Routine",
    "Search",
    "SetAcceleration",
    "SetBlend",
    "SetFrame",
    "SetOutput",
    "SetOverride",
    "SetSpeed",
    "SetTool",
    "ShiftOff",
    "ShiftOn",
    "Speed",
    "SpeedUnit",
    "StartTask",
    "Statement",
    "Switch",
    "Synchronise",
    "Until",
    "Update",
    "Wait",
    "WaitTask",
    "While",
]


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
