"""Codes of diagnostics: stable, one meaning each, every one documented."""

from __future__ import annotations

import ast
import re
from functools import cache
from pathlib import Path

ROOT = Path(__file__).parent.parent
CODE = re.compile(r"[A-Z]\d{3}")


@cache
def emitted() -> dict[str, set[str]]:
    """Code -> the modules that hold it as a string of its own; those that end in 000 are patterns."""
    found: dict[str, set[str]] = {}
    for path in sorted((ROOT / "olp").rglob("*.py")):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Constant) and isinstance(node.value, str) and CODE.fullmatch(node.value):
                found.setdefault(node.value, set()).add(path.relative_to(ROOT).as_posix())
    return {code: modules for code, modules in found.items() if not code.endswith("000")}


def documented() -> set[str]:
    """Every code that a page of docs/ names, ranges such as T001..T003 written out."""
    text = "\n".join(
        p.read_text(encoding="utf-8") for p in (ROOT / "docs").glob("*.md") if p.stem != "figures"
    )
    ranges = re.findall(r"\b([A-Z])(\d{3})(?:\.\.| to )\1(\d{3})\b", text)
    spread = {f"{letter}{n:03}" for letter, low, high in ranges for n in range(int(low), int(high) + 1)}
    return spread | set(re.findall(r"\b[A-Z]\d{3}\b", text))


# Packages whose modules share one area of codes.
WHOLE = {"__main__": "commands", "cli": "commands", "robots": "robots", "runtime": "interpreter"}

# Modules whose codes are those of another: what commands write, what all vendors share, what serves a folder.
OF = {
    "files": "commands",
    "annotation": "annotate",
    "generator": "vendors",
    "lark": "vendors",
    "short": "vendors",
    "mcp": "folder",
    "web": "folder",
}


def area(module: str) -> str:
    """What a module belongs to: its package, or itself. Commands, and the files they write, are one."""
    package, *inside = module.removesuffix(".py").split("/")[1:]
    if package in WHOLE or not inside:
        return WHOLE.get(package, package)
    name = inside[0] if len(inside) > 1 else inside[0].split("_")[0]
    return OF.get(name, name)


def test_every_code_is_explained_in_the_docs():
    known = documented()
    assert {code: sorted(modules) for code, modules in emitted().items() if code not in known} == {}


# They read what others have said under a code, and say nothing under it themselves.
READERS = {"lint": "W", "guard": "M"}


def test_no_two_areas_share_a_code():
    shared = {}
    for code, modules in emitted().items():
        areas = {area(module) for module in modules}
        if len({one for one in areas if READERS.get(one, code[0]) == code[0]}) != 1:
            shared[code] = sorted(modules)
    assert shared == {}
