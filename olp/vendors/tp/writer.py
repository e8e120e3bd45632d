"""Writes programs as TP listings: what `templates/tp.j2` puts together.

Codes: X002 what TP cannot say.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Final

from olp.diagnostic import Diagnostic, Span, error
from olp.expression import Store, Variable
from olp.program import (
    Assign,
    Call,
    Else,
    ElseIf,
    EndIf,
    For,
    If,
    Label,
    Move,
    Next,
    Process,
    Program,
    Routine,
    SetOutput,
    Statement,
    Switch,
    Wait,
)
from olp.vendors.tp.instructions import BLOCK
from olp.vendors.tp.limits import LIMITS
from olp.vendors.tp.write_flow import FlowWriter, Labels
from olp.vendors.tp.write_moves import MoveWriter
from olp.vendors.tp.write_poses import Scratch
from olp.vendors.tp.write_positions import PositionWriter
from olp.vendors.tp.write_statements import StatementWriter, comment_lines
from olp.vendors.tp.write_values import CannotSayError, Words

_UNKNOWN_AFTER: Final = (Label, Call, Else, EndIf, For, Next, Switch)  # which frames hold, that is
_PR = re.compile(r"Variable\(store=<Store\.ROBOT: 'robot'>, index=Number\(value=(\d+)\)")
_DATE = re.compile(r"(\d\d)?(\d\d)/(\d\d)/(\d\d) (\d\d:\d\d)")


@dataclass(frozen=True, slots=True)
class Listing:
    """One program as the template sees it. Texts of several lines end with a line end."""

    name: str
    kind: str
    owner: str
    comment: str
    created: str
    modified: str
    file_name: str
    version: str
    protect: str
    stack_size: str
    task_priority: str
    time_slice: str
    busy_lamp_off: str
    abort_request: str
    pause_request: str
    default_group: str
    control_code: str
    local_registers: str
    application: str
    line_count: int
    instructions: str
    positions: str


def write(program: Program, date: str) -> tuple[dict[str, object], list[Diagnostic]]:
    """The values for the template, and everything that TP cannot say.

    `date`: YYYY/MM/DD HH:MM, for programs that have none.
    """
    problems: list[Diagnostic] = []
    listings = tuple(
        _ListingWriter(program, routine, problems, date).listing() for routine in program.routines
    )
    return {"listings": listings}, problems


class _ListingWriter:
    def __init__(self, program: Program, routine: Routine, problems: list[Diagnostic], date: str) -> None:
        self.program = program
        self.routine = routine
        self.problems = problems
        self.date = date
        self.own = program.vendor == "tp"
        self.details = routine.details if self.own else {}
        self.positions = PositionWriter(routine.points, self.details, self.own)
        words = Words(self.details, routine.points, self.own)
        self.moves = MoveWriter(words, self.positions, Scratch(_used(program), LIMITS.numbered[Store.ROBOT]))
        self.labels = Labels(routine, self.own)
        self.words = words
        self.statements = StatementWriter(words, self.moves, self.labels.number, self.own)
        self.flow = FlowWriter(words, self.statements, self.labels)
        self._blocks: list[int] = []  # how many ENDIF each open IF needs

    def listing(self) -> Listing:
        instructions = list(self._numbered())
        positions: list[str] = []
        try:
            positions = list(self.positions.lines())
        except CannotSayError as problem:
            self._lose(problem, self.routine.line)
        get = self._attribute
        made = _dated(self.date)
        return Listing(
            name=self.routine.name if self.own else self.routine.name.upper(),
            kind=self.details.get("/PROG", ""),
            owner=get("OWNER", "MNEDITOR"),
            comment=f'"{self.routine.comment}"',
            created=get("CREATE", made),
            modified=get("MODIFIED", made),
            file_name=get("FILE_NAME", ""),
            version=get("VERSION", "0"),
            protect=get("PROTECT", "READ_WRITE"),
            stack_size=get("STACK_SIZE", "0"),
            task_priority=get("TASK_PRIORITY", "50"),
            time_slice=get("TIME_SLICE", "0"),
            busy_lamp_off=get("BUSY_LAMP_OFF", "0"),
            abort_request=get("ABORT_REQUEST", "0"),
            pause_request=get("PAUSE_REQUEST", "0"),
            default_group=get("DEFAULT_GROUP", "1,*,*,*,*"),
            control_code=get("CONTROL_CODE", "00000000 00000000"),
            local_registers=get("LOCAL_REGISTERS", ""),
            application="".join(f"{line}\n" for line in self.details.get("/APPL", "").split("\n") if line),
            line_count=self._count,
            instructions="".join(f"{line}\n" for line in instructions),
            positions="".join(f"{line}\n" for line in positions),
        )

    def _attribute(self, name: str, usual: str) -> str:
        return self.details.get(f"/ATTR {name}", usual)

    # --- lines ------------------------------------------------------------------------------------------

    def _numbered(self) -> Iterator[str]:
        """The instructions with their numbers; those of a P-SPS block count on their own."""
        count = inside = 0
        for text in self._instructions():
            if text == _BLOCK_END:
                inside = 0
                yield "       ------ ;"
                continue
            if inside:
                head, inside = f"   {inside:4}:  ", inside + 1
            else:
                count += 1
                head = f"{count:4}:" if text[:2] in _MOTIONS else f"{count:4}:  "
            first, _, second = text.partition("\n")
            yield f"{head}{first}" if second else f"{head}{first} ;"
            if second:
                yield f"    :  {second} ;"
            if BLOCK in text and text[:2] in _MOTIONS:
                inside = 1
        self._count = count

    def _instructions(self) -> Iterator[str]:
        body = self.routine.body
        at = 0
        move, moves = Move, self.moves
        while at < len(body):
            statement = body[at]
            taken = 1
            try:
                if type(statement) is move:
                    lines = moves.move(statement)
                else:
                    lines, taken = self._other(statement, at)
            except CannotSayError as problem:
                self._lose(problem, statement.line)
                lines = []
            comment = getattr(statement, "comment", "")
            if comment and not (self.own and type(statement) is Label):
                yield from comment_lines(comment)
            yield from lines
            at += taken
            if type(statement) is not move and isinstance(statement, _UNKNOWN_AFTER):
                moves.forget()

    def _other(self, statement: Statement, at: int) -> tuple[list[str], int]:
        """The lines of what is no move, and how many statements they say."""
        body = self.routine.body
        match statement:
            case Label():
                return [self.labels.line(statement)], 1
            case Wait() if statement.timeout is not None:
                return self.flow.timed_wait(statement, body[at + 1] if at + 1 < len(body) else None)
            case If():
                following = body[at + 1 : at + 3]
                if statement.spelling == "one line" and len(following) == 2 and type(following[1]) is EndIf:
                    return self._one_line(statement, following[0]), 3
                self._blocks.append(1)
            case ElseIf():
                if self._blocks:
                    self._blocks[-1] += 1
                return ["ELSE", f"IF {self.words.condition(statement.condition, True)} THEN"], 1
            case EndIf():
                return ["ENDIF"] * (self._blocks.pop() if self._blocks else 1), 1
            case Switch():
                return self.flow.select(body, at)
            case Process() if statement.name == f"{BLOCK} END" and self.own:
                return [_BLOCK_END], 1
            case _:
                pass
        return self.statements.lines(statement), 1

    def _one_line(self, condition: If, action: Statement) -> list[str]:
        (text,) = self.statements.lines(action)
        if not isinstance(action, (Assign, SetOutput)) and not text.startswith(
            ("JMP", "CALL", "RUN", "WAIT")
        ):
            return [f"IF {self.words.condition(condition.condition, True)} THEN", text, "ENDIF"]
        return [f"IF {self.words.condition(condition.condition, True)},{text}"]

    # --- the rest ---------------------------------------------------------------------------------------

    def _lose(self, problem: CannotSayError, line: int) -> None:
        text = self.program.source.line(line)
        span = Span(line, len(text) - len(text.lstrip()) + 1, len(text.rstrip()) + 1)
        message = f"TP cannot say this: {problem}"
        self.problems.append(
            error("X002", message, span, file=self.program.path, source_line=text, help=problem.help)
        )


_BLOCK_END: Final = "------"
_MOTIONS: Final = ("J ", "L ", "C ", "A ", "S ")


def _used(program: Program) -> set[int]:
    """The numbers of position registers that the program names."""
    found: set[int] = set()
    for routine in program.routines:
        for one in routine.body:
            if (
                type(one) is Move
                and type(one.targets[0]) is not Variable
                and one.offset is one.tool_offset is None
            ):
                continue
            text = repr(one)
            if "Store.ROBOT" in text:
                found.update(map(int, _PR.findall(text)))
    return found


def _dated(date: str) -> str:
    """YYYY/MM/DD HH:MM as a listing writes it."""
    match = _DATE.fullmatch(date)
    return (
        f"DATE {match[2]}-{match[3]}-{match[4]}  TIME {match[5]}:00"
        if match
        else "DATE 00-01-01  TIME 00:00:00"
    )
