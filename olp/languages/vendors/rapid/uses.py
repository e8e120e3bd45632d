"""Which names of another language's program are tools and work objects: by what moves do with them."""

from __future__ import annotations

from olp.ir.expressions import Expression, Named
from olp.ir.program import Assign, Declare, Move, Program


def uses(program: Program) -> dict[str, str]:
    """Lower-case name -> tooldata or wobjdata; also of names that hand their value on to one of them."""
    found: dict[str, str] = {}
    given: list[tuple[str, str]] = []
    for one in (*program.data, *program.statements()):
        if isinstance(one, Move):
            _note(found, one.tool, "tooldata")
            _note(found, one.frame, "wobjdata")
        elif isinstance(one, Assign) and isinstance(one.target, Named) and isinstance(one.value, Named):
            given.append((one.target.name.lower(), one.value.name.lower()))
        elif isinstance(one, Declare) and isinstance(one.value, Named):
            given.append((one.name.lower(), one.value.name.lower()))
    for _ in range(len(given)):
        before = len(found)
        for target, value in given:
            if target in found or value in found:
                kind = found.get(target) or found[value]
                found.setdefault(target, kind)
                found.setdefault(value, kind)
        if len(found) == before:
            break
    return found


def _note(found: dict[str, str], value: Expression | None, kind: str) -> None:
    if isinstance(value, Named):
        found.setdefault(value.name.lower(), kind)
