"""What each language reads and writes, found out from the code: no table is kept by hand.

Read: the statements that the vendor's lowering code makes. Written: each kind of statement is translated once, through
all passes and the vendor's writer, and what comes out is looked at.
"""

from __future__ import annotations

import ast
import re
from functools import lru_cache
from importlib.util import find_spec
from pathlib import Path as FilePath
from typing import TYPE_CHECKING, NamedTuple, get_args

from olp.diagnostic import OlpError
from olp.export import writable
from olp.program import Move, Path, Statement
from olp.resources import read_text
from olp.translate.probes import probes, program_with
from olp.vendors.vendor import vendor_names

if TYPE_CHECKING:
    from olp.robot import Robot

_SHARED = "olp.vendors._rules"
_WRITING = ("write", "templates", "limits")


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
            vendor: Support(kind in read_by(vendor), written_by(vendor, kind)) for vendor in vendor_names()
        }
    return table


@lru_cache
def read_by(vendor: str) -> frozenset[str]:
    """The kinds of statements that a vendor's lowering code makes."""
    spec = find_spec(f"olp.vendors.{vendor}")
    places = list(spec.submodule_search_locations or ()) if spec is not None else []
    files = [file for place in places for file in sorted(FilePath(place).glob("*.py"))]
    if not files and spec is not None and spec.origin:
        files = [FilePath(spec.origin)]
    made: set[str] = set()
    for file in files:
        if not file.stem.startswith(_WRITING):
            tree = ast.parse(file.read_text(encoding="utf-8"))
            made |= _made_in(tree)
            if any(isinstance(node, ast.ImportFrom) and node.module == _SHARED for node in ast.walk(tree)):
                made |= _shared(vendor)
    classes = {statement.__name__ for statement in get_args(Statement)}
    found = made & classes - {"Move"}
    if "Move" in made:
        found |= {f"Move {path.value}" for path in Path if f"Path.{path.name}" in made}
    return frozenset(found)


def _shared(vendor: str) -> set[str]:
    """What the rules that several languages share make, of those that this language's grammar names."""
    named = set(re.findall(r"\b[a-z_]+\b", read_text("grammars", f"{vendor}.lark")))
    spec = find_spec(_SHARED)
    assert spec is not None
    assert spec.origin is not None
    made: set[str] = set()
    for node in ast.walk(ast.parse(FilePath(spec.origin).read_text(encoding="utf-8"))):
        if isinstance(node, ast.FunctionDef) and node.name in named:
            made |= _made_in(node)
    return made


def _made_in(tree: ast.AST) -> set[str]:
    """Names that are called or named as values, and paths of moves."""
    found: set[str] = set()
    for node in ast.walk(tree):
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Name):
            found.add(node.func.id)
        elif isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name):
            found.add(f"{node.value.id.removeprefix('Move')}.{node.attr}")
        elif isinstance(node, (ast.Dict, ast.Tuple)):
            values = node.values if isinstance(node, ast.Dict) else node.elts
            found |= {value.id for value in values if isinstance(value, ast.Name)}
    return found


@lru_cache(maxsize=1000)
def written_by(vendor: str, kind: str) -> str:
    """What becomes of a statement of this kind in the vendor's language: "exact", "approximated" or "" (refused)."""
    from olp.translate.convert import convert
    from olp.translate.work import Context, Fate

    statements = probes().get(kind)
    if statements is None or vendor not in writable():
        return ""
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
    from olp.robot import load_robot

    return load_robot("yaskawa/gp25")
