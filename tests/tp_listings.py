"""Listings for tests: instructions and positions in, a whole program out."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from olp.core.source import decode
from olp.fluent import read_source
from olp.ir.program import Program

HEAD = """/PROG  PART
/ATTR
OWNER\t\t= MNEDITOR;
COMMENT\t\t= "made";
DEFAULT_GROUP\t= 1,*,*,*,*;
/APPL
/MN
"""
POSITION = """P[{0}]{{
   GP1:
\tUF : 1, UT : 2,\t\tCONFIG : 'N U T, 0, 0, 0',
\tX = {1:9.3f}  mm,\tY =    12.500  mm,\tZ =     -.384  mm,
\tW =   178.500 deg,\tP =     3.250 deg,\tR =   -21.500 deg
}};
"""


def listing(*instructions: str, points: int = 4, positions: str | None = None, head: str = HEAD) -> str:
    """The text of a program with these instructions (without numbers and semicolons)."""
    lines = "".join(f"{n:4}:  {text} ;\n" for n, text in enumerate(instructions, 1))
    taught = "".join(POSITION.format(n, 100.25 * n) for n in range(1, points + 1))
    return f"{head}{lines}/POS\n{taught if positions is None else positions}/END\n"


def read(text: str, encoding: str = "latin-1") -> Program:
    return read_source(decode(text.encode(encoding), "part.ls"))


def body(*instructions: str, **more: Any) -> list[Any]:
    """The statements, with line 0."""
    program = read(listing(*instructions, **more))
    errors = [one.render() for one in program.diagnostics if one.is_error]
    assert not errors, "\n".join(errors)
    return [replace(one, line=0) for one in program.routines[0].body]


def one(instruction: str) -> Any:
    (statement,) = body(instruction)
    return statement


def codes(text: str) -> list[str]:
    return [found.code for found in read(text).diagnostics if found.code not in ("P533", "P534")]
