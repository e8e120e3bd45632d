"""Modules for tests of RAPID, and how two programs are compared that stand in other lines."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace

from olp.core.source import decode
from olp.fluent import read_source
from olp.ir.program import Move, Program, Routine, Statement

NO_AXES = "[9E9,9E9,9E9,9E9,9E9,9E9]"


def module(body: Iterable[str] | str = (), data: Iterable[str] | str = ()) -> str:
    """A module with these lines in PROC main, and these declarations before it."""
    inside = [body] if isinstance(body, str) else list(body)
    before = [data] if isinstance(data, str) else list(data)
    rows = ["MODULE Sample", *before, "PROC main()", *inside, "ENDPROC", "ENDMODULE"]
    return "\r\n".join(rows) + "\r\n"


def read(text: str, path: str = "test.mod") -> Program:
    return read_source(decode(text.encode("cp1252"), path), vendor="rapid")


def statements(body: Iterable[str] | str, data: Iterable[str] | str = ()) -> list[Statement]:
    """The statements of main, all in line 0. The module must be without errors."""
    program = read(module(body, data))
    assert not errors(program), [d.render() for d in program.diagnostics]
    return [replace(one, line=0) for one in program.routines[0].body]


def statement(body: str, data: Iterable[str] | str = ()) -> Statement:
    (found,) = statements(body, data)
    return found


def move(body: str, data: Iterable[str] | str = ()) -> Move:
    found = statement(body, data)
    assert isinstance(found, Move)
    return found


def errors(program: Program) -> list[str]:
    return [f"{d.code} {d.line}" for d in program.diagnostics if d.is_error]


def codes(program: Program) -> dict[str, list[int]]:
    found: dict[str, list[int]] = {}
    for one in program.diagnostics:
        found.setdefault(one.code, []).append(one.line)
    return found


def without_lines(program: Program) -> tuple[object, ...]:
    """All that a program means, wherever its lines stand."""

    def routine(one: Routine) -> Routine:
        body = tuple(replace(s, line=0) for s in one.body)
        return replace(one, line=0, last_line=0, body=body, points=None)  # type: ignore[arg-type]

    data = tuple(replace(one, line=0) for one in program.data)
    return tuple(map(routine, program.routines)), data, program.main


def again(program: Program) -> Program:
    """Written and read."""
    return read_source(decode(program.export("rapid"), program.path), vendor="rapid")
