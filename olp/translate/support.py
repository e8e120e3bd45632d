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

from olp.called import kind_of
from olp.diagnostic import OlpError
from olp.export import writable
from olp.plan import StepKind
from olp.program import Move, Path, Statement
from olp.resources import read_text
from olp.translate.probes import probes, program_with
from olp.vendors.vendor import vendor_names

if TYPE_CHECKING:
    from olp.robot import Robot

_SHARED = "olp.vendors._rules"
_BASE = "olp.vendors._short"
_NEUTRAL = frozenset({"olp.program", "olp.statements", "olp.moves"})
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
def timed_as(kind: str) -> str:
    """What a statement of this kind adds to a program's time: "move", "wait", "signal", or "" for nothing."""
    from olp.interpreter import run

    statements = probes().get(kind, ())
    program = program_with(statements, "krl")
    lines = {line for line, s in enumerate(statements, 1) if kind_of(s) == kind}
    plan = run(program, robot=_robot())
    steps = zip(plan.line.tolist(), plan.kind.tolist(), strict=True)
    return next((StepKind(code).name.lower() for line, code in steps if line in lines), "")


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
            imported = {node.module for node in ast.walk(tree) if isinstance(node, ast.ImportFrom)}
            if _SHARED in imported:
                made |= _shared(vendor)
            if _BASE in imported:
                made |= _made_in(_tree_of(_BASE))
    classes = {statement.__name__ for statement in get_args(Statement)}
    found = made & classes - {"Move"}
    if "Move" in made:
        found |= {f"Move {path.value}" for path in Path if f"Path.{path.name}" in made}
    return frozenset(found)


def _shared(vendor: str) -> set[str]:
    """What the rules that several languages share make, of those that this language's grammar names."""
    named = set(re.findall(r"\b[a-z_]+\b", read_text("grammars", f"{vendor}.lark")))
    tree = _tree_of(_SHARED)
    made: set[str] = set()
    for node in ast.walk(tree):
        if isinstance(node, ast.FunctionDef) and node.name in named:
            made |= _made_in(node)
    return made


def _tree_of(module: str) -> ast.Module:
    spec = find_spec(module)
    assert spec is not None
    assert spec.origin is not None
    return ast.parse(FilePath(spec.origin).read_text(encoding="utf-8"))


def _made_in(tree: ast.AST) -> set[str]:
    """Names that are called, or named in a table as what is to be called, and paths of moves.

    A name that the module defines itself is something else than the statement that is called so.
    """
    found: set[str] = set()
    own = {node.name for node in ast.walk(tree) if isinstance(node, ast.ClassDef)}
    for node in ast.walk(tree):
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Name):
            found.add(node.func.id)
        elif isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name):
            found.add(f"{node.value.id.removeprefix('Move')}.{node.attr}")
        elif isinstance(node, ast.Dict):
            found |= {it.id for value in node.values for it in ast.walk(value) if isinstance(it, ast.Name)}
    return found - own - _foreign(tree)


def _foreign(tree: ast.AST) -> set[str]:
    """Names that come from elsewhere than the neutral program."""
    imports = [node for node in ast.walk(tree) if isinstance(node, ast.ImportFrom)]
    return {
        name.asname or name.name for node in imports if node.module not in _NEUTRAL for name in node.names
    }


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
