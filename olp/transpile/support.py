"""What each language reads and writes.

Read: what the vendor states. Written: found out, as each kind of statement is translated once, through
all passes and the vendor's writer, and what comes out is looked at.
"""

from __future__ import annotations

from functools import lru_cache
from typing import TYPE_CHECKING, NamedTuple, get_args

from olp.core.diagnostic import OlpError
from olp.ir.program import Move, Path, Statement
from olp.ir.terminology import kind_of
from olp.languages.limits import writable
from olp.languages.vendor import find_vendor, vendor_names
from olp.robots import EXAMPLE_ROBOT
from olp.runtime.plan import StepKind
from olp.transpile.statement_programs import probes, program_with

if TYPE_CHECKING:
    from olp.robots.model import Robot


class Support(NamedTuple):
    """`reads`: the reader makes such statements. `writes`: "exact", "approximated", or "" where it is refused."""

    reads: bool
    writes: str


def kinds() -> tuple[str, ...]:
    """All kinds of statements of the neutral program, moves by their path."""
    found: list[str] = []
    for statement in get_args(Statement):
        found += [f"Move {path.value}" for path in Path] if statement is Move else [statement.__name__]
    return tuple(found)


def support() -> dict[str, dict[str, Support]]:
    """Kind of statement -> vendor -> what it does with it."""
    table: dict[str, dict[str, Support]] = {}
    for kind in kinds():
        table[kind] = {
            vendor: Support(kind in find_vendor(vendor).reads, written_by(vendor, kind))
            for vendor in vendor_names()
        }
    return table


@lru_cache
def timed_as(kind: str) -> str:
    """What a statement of this kind adds to a program's time: "move", "wait", "signal", or "" for nothing."""
    from olp.runtime.interpreter import run

    statements = probes().get(kind, ())
    program = program_with(statements, "")
    lines = {line for line, s in enumerate(statements, 1) if kind_of(s) == kind}
    plan = run(program, robot=_robot())
    steps = zip(plan.line.tolist(), plan.kind.tolist(), strict=True)
    return next((StepKind(code).name.lower() for line, code in steps if line in lines), "")


def written_by(vendor: str, kind: str) -> str:
    """What becomes of a statement of this kind in the vendor's language: "exact", "approximated" or "" (refused)."""
    statements = probes().get(kind)
    return "" if statements is None or vendor not in writable() else _written(vendor, statements)


@lru_cache(maxsize=1000)
def _written(vendor: str, statements: tuple[Statement, ...]) -> str:
    """The same of a program with these statements: kinds that stand together only share one."""
    from olp.transpile.context import Context, Fate
    from olp.transpile.convert import convert

    robot = _robot()
    try:
        converted = convert(
            program_with(statements, vendor), vendor, Context(robot=robot), date="2000/01/01 00:00"
        )
    except OlpError:
        return ""
    is_exact = all(loss.fate is Fate.EXACT for loss in converted.translated.losses)
    return "exact" if is_exact else "approximated"


@lru_cache
def _robot() -> Robot:
    from olp.robots.robot import load_robot

    return load_robot(EXAMPLE_ROBOT)
