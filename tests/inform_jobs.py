"""Jobs for the tests of the INFORM reader: text in, program out."""

from __future__ import annotations

import re
from collections.abc import Sequence

from olp.core.source import decode
from olp.fluent import read_source
from olp.ir.program import Program, Statement

ALIASES = (
    "LD000 V_Seam",
    "LP001 Greifer_Öffnen",
    "LI002 two words",
    "LB003 PL",
    "R004 4th-gauge",
    "P005 HOME",
)


def job(
    instructions: Sequence[str] = (),
    points: Sequence[str] = (),
    aliases: Sequence[str] = (),
    header: Sequence[str] = ("///DATE 2026/03/02 14:07", "///ATTR SC,RW", "///GROUP1 RB1"),
    name: str = "TEST",
) -> list[str]:
    """The lines of a whole job around the given ones."""
    families = [re.sub(r"\d.*", "", row) for row in points]
    counts = [
        sum(family == one or (one == "EC" and family == "E") for family in families) for one in FAMILIES
    ]
    lines = ["/JOB", f"//NAME {name}", "//POS", f"///NPOS {','.join(map(str, counts))}", *points]
    if aliases:
        lines += ["//ALIAS", *aliases]
    return [*lines, "//INST", *header, "NOP", *instructions, "END"]


FAMILIES = ("C", "BC", "EC", "P", "BP", "EX")


def read_lines(lines: Sequence[str], end: str = "\r\n", encoding: str = "utf-8") -> Program:
    """The program of a text, as a controller would write it."""
    text = "".join(line + end for line in lines)
    return read_source(decode(text.encode(encoding, "surrogateescape"), "test.jbi"), vendor="inform")


def read_statements(*instructions: str) -> list[Statement]:
    """The statements of instructions with the names of ALIASES, NOP and END left out; no diagnostic but of points."""
    program = read_lines(job(instructions, aliases=ALIASES))
    told = [
        d.render()
        for d in program.diagnostics
        if d.code not in ("P030", "P032", "P034", "P110", "P111", "P113")
    ]
    assert not told, "\n".join(told)
    return list(program.routines[0].body[1:-1])


def read_statement(instruction: str) -> Statement:
    (statement,) = read_statements(instruction)
    return statement


def told(lines: Sequence[str]) -> list[str]:
    """All diagnostics of a text, rendered."""
    return [d.render() for d in read_lines(lines).diagnostics]
