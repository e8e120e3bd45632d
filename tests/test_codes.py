"""Codes of diagnostics: stable, one meaning each, every one documented."""

from __future__ import annotations

import ast
import re
from functools import cache
from pathlib import Path

from olp.__main__ import explained_code, main
from olp.core.resources import code_meanings

ROOT = Path(__file__).parent.parent
CODE = re.compile(r"[A-Z]\d{3}")
QUOTED = re.compile(r"""["'][A-Z]\d{3}["']""")  # a module without such holds no code


@cache
def emitted() -> dict[str, set[str]]:
    """Code -> the modules that hold it as a string of its own; those that end in 000 are patterns."""
    found: dict[str, set[str]] = {}
    for path in sorted((ROOT / "olp").rglob("*.py")):
        text = path.read_text(encoding="utf-8")
        for node in ast.walk(ast.parse(text)) if QUOTED.search(text) else ():
            if isinstance(node, ast.Constant) and isinstance(node.value, str) and CODE.fullmatch(node.value):
                found.setdefault(node.value, set()).add(path.relative_to(ROOT).as_posix())
    return {code: modules for code, modules in found.items() if not code.endswith("000")}


# Packages whose modules share one area of codes.
WHOLE = {"__main__": "commands", "cli": "commands", "robots": "robots", "runtime": "interpreter"}

# Modules whose codes are those of another: what commands write, what all vendors share, what serves a folder.
OF = {
    "files": "commands",
    "annotation": "annotate",
    "generator": "vendors",
    "lark": "vendors",
    "loading": "vendors",
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


def test_olp_help_explains_every_code():
    unexplained = {code: sorted(modules) for code, modules in emitted().items() if not explained_code(code)}
    assert unexplained == {}, "olp/core/codes.toml explains codes"


def test_no_code_is_explained_that_nothing_emits():
    sources = "".join(path.read_text(encoding="utf-8") for path in (ROOT / "olp").rglob("*.py"))
    assert sorted(code_meanings().keys() - set(CODE.findall(sources))) == []
    assert all(code_meanings().values())


def test_olp_help_knows_codes_and_rules(capsys):
    assert main(["help", "p020"]) == 0
    assert capsys.readouterr().out.startswith("P020: broken instruction")
    assert main(["help", "W001"]) == 0
    assert "better: MOVL C00001 V=300.0 PL=1" in capsys.readouterr().out
    assert main(["help", "X999"]) == 2
    assert "C001" in capsys.readouterr().err


# They read what others have said under a code, and say nothing under it themselves.
READERS = {"lint": "W", "guard": "M", "writers": ""}  # the last: the contract of writers


def test_no_two_areas_share_a_code():
    shared = {}
    for code, modules in emitted().items():
        areas = {area(module) for module in modules}
        if len({one for one in areas if READERS.get(one, code[0]) == code[0]}) != 1:
            shared[code] = sorted(modules)
    assert shared == {}
