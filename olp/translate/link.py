"""A program together with the routines that it calls from the files beside it, as one program."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, TypeVar

from olp.diagnostic import Diagnostic
from olp.expression import CallValue
from olp.program import Call, Program, Routine, Statement
from olp.source import Source
from olp.translate.rewrite import expressions_of

S = TypeVar("S", bound=Statement)


@dataclass(frozen=True, slots=True)
class Part:
    """One file of a linked program: its lines stand behind those of the parts before, from `offset` + 1 on."""

    path: str
    offset: int
    count: int


@dataclass(frozen=True, slots=True)
class Linked:
    program: Program
    parts: tuple[Part, ...]

    def place(self, line: int) -> tuple[str, int]:
        """The file and the line there of a line of the linked program."""
        for part in reversed(self.parts):
            if line > part.offset:
                return part.path, line - part.offset
        return self.program.path, line

    def located(self, found: Diagnostic) -> Diagnostic:
        """A diagnostic of the linked program with the file and the line that people know."""
        path, line = self.place(found.line)
        if not found.line or line == found.line:
            return found
        # The text of another file is not at hand, so there is nothing to draw a caret under.
        return replace(found, file=path, line=line, column=1, end_column=1, source_line="")


def link(program: Program) -> Linked:
    """`program` with the routines that its calls name and the files of its folder hold; their lines follow its own."""
    from olp.interpreter.jobs import Jobs

    path = Path(program.path) if program.path else None
    folder = path.parent if path is not None and path.is_file() else None
    parts = [Part(program.path, 0, len(program.source.lines))]
    if folder is None:
        return Linked(program, tuple(parts))
    jobs = Jobs(program, folder)
    routines = list(program.routines)
    data = list(program.data)
    lines = list(program.source.lines)
    offsets: dict[int, int] = {id(program): 0}
    todo = [name for routine in routines for name in _called(routine)]
    have = {routine.name.casefold() for routine in routines}
    while todo:
        name = todo.pop(0)
        job = None if name.casefold() in have else jobs.find(name)
        have.add(name.casefold())
        if job is None or any(routine is job.routine for routine in routines):
            continue
        other = job.program
        if id(other) not in offsets:
            offset = offsets[id(other)] = len(lines)
            parts.append(Part(other.path, offset, len(other.source.lines)))
            lines += other.source.lines
            known = {declare.name.casefold() for declare in data}
            data += [_moved(d, offset) for d in other.data if d.name.casefold() not in known]
        routine = _shifted(job.routine, offsets[id(other)])
        have.add(routine.name.casefold())
        routines.append(routine)
        todo += _called(routine)
    if len(parts) == 1:
        return Linked(program, tuple(parts))
    source = Source(program.source.path, program.source.raw, program.source.encoding, tuple(lines))
    main = program.main or program.routines[0].name
    joined = replace(program, source=source, routines=tuple(routines), data=tuple(data), main=main)
    return Linked(joined, tuple(parts))


def _called(routine: Routine) -> list[str]:
    found: list[str] = []
    for s in routine.body:
        if isinstance(s, Call) and s.routine:
            found.append(s.routine)
        elif type(s).__name__ in ("Assign", "If", "While", "Return", "SetOutput"):
            found += [e.routine for e in expressions_of(s) if type(e) is CallValue]
    return found


def _shifted(routine: Routine, offset: int) -> Routine:
    return replace(
        routine,
        body=tuple([_moved(s, offset) for s in routine.body]),
        data=tuple([_moved(d, offset) for d in routine.data]),
        line=routine.line + offset,
    )


def _moved(s: S, offset: int) -> S:
    """A statement `offset` lines further down."""
    statement: Any = s
    return replace(statement, line=s.line + offset) if s.line else s
