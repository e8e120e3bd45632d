"""The program: what is written, without any vendor's words. Statements in order, each with its line.

Control flow stays as written (block markers and labels), so that structure, names and comments survive a
translation. `control.py` pairs the markers; the interpreter executes; templates write.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from olp.diagnostic import Diagnostic
from olp.expression import FrameRef, Store, Variable
from olp.moves import Blend, BlendKind, Move, MovePart, Path, Reference, Search, SetSpeed, Speed, SpeedUnit
from olp.points import PointTable
from olp.source import Source
from olp.statements import (
    Assign,
    Begin,
    Call,
    Case,
    Clear,
    Comment,
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
    Next,
    Opaque,
    Pause,
    Process,
    PulseOutput,
    ReadInput,
    Return,
    SetOutput,
    ShiftOff,
    ShiftOn,
    StartTask,
    Statement,
    Switch,
    Synchronise,
    Update,
    Wait,
    WaitTask,
    While,
)

if TYPE_CHECKING:
    import os

    from olp.plan import Plan

__all__ = [
    "Assign",
    "Begin",
    "Blend",
    "BlendKind",
    "Call",
    "Case",
    "Clear",
    "Comment",
    "ControlGroup",
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
    "Opaque",
    "Path",
    "Pause",
    "Process",
    "Program",
    "PulseOutput",
    "ReadInput",
    "Reference",
    "Return",
    "Routine",
    "Search",
    "SetOutput",
    "SetSpeed",
    "ShiftOff",
    "ShiftOn",
    "Speed",
    "SpeedUnit",
    "StartTask",
    "Statement",
    "Switch",
    "Synchronise",
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
