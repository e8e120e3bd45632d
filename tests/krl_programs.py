"""Small KRL programs for the tests."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from olp.core.source import Source, decode
from olp.fluent import Program, fluent
from olp.ir.program import Statement
from olp.languages.templating import shipped
from olp.languages.vendors.krl.reader import read_program
from olp.languages.vendors.krl.writer import write


def source(lines: list[str] | str, path: str = "part.src") -> Source:
    text = lines if isinstance(lines, str) else "\r\n".join(lines) + "\r\n"
    return decode(text.encode("cp1252"), path)


def read(*body: str, dat: list[str] | None = None, config: list[str] | None = None) -> Program:
    """A program PART of these lines, with the rows of a .dat and a $config.dat."""
    given = []
    if dat is not None:
        given.append(source(["DEFDAT PART", *dat, "ENDDAT"], "part.dat"))
    if config is not None:
        given.append(source(["DEFDAT $CONFIG", *config, "ENDDAT"], "$config.dat"))
    return fluent(read_program(source(["DEF PART ( )", *body, "END"]), tuple(given)))


def body(*lines: str, **lists: list[str]) -> tuple[Statement, ...]:
    """The statements of a program without a finding, lines removed."""
    program = read(*lines, **lists)
    assert not [d.render() for d in program.diagnostics if d.is_error]
    return tuple(unplaced(one) for one in program.routines[0].body)


def one(line: str, **lists: list[str]) -> Any:
    """The only statement of a line."""
    (found,) = body(line, **lists)
    return found


def unplaced(statement: Any) -> Any:
    triggers = tuple(trigger._replace(above=0) for trigger in getattr(statement, "triggers", ()))
    return replace(statement, line=0, **({"triggers": triggers} if triggers else {}))


def codes(program: Program) -> list[tuple[str, int]]:
    return [(d.code, d.line) for d in program.diagnostics]


def written(program: Program) -> tuple[str, str]:
    """The texts of the .src and of the .dat."""
    values, problems = write(program, "", pair=True)
    assert not problems, [d.render() for d in problems]
    companions: Any = values.get("companions", {})
    return shipped("krl").render(values), companions.get(".dat", "")


def again(program: Program) -> Program:
    """Written and read again, with the same $config.dat."""
    text, rows = written(program)
    given = [source(rows, "part.dat")] if rows else []
    given += [one for one in program.companions if "config" in one.path]
    return read_program(source(text, program.path), tuple(given))


def meaning(program: Program) -> Any:
    """All of a program but its lines."""
    routines = [
        (r.name, [unplaced(s) for s in r.body], r.parameters, r.returns, r.shared, dict(r.details))
        for r in program.routines
    ]
    return routines, [unplaced(d) for d in program.data], program.main
