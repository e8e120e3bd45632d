"""Nothing outside a vendor's folder knows the vendor: neither the name of its language nor that of its maker.

A language's name is found as a text, as a word of a text (but for docstrings), as a part of a name, a module or a file;
a maker's where something is compared with it.
"""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from pathlib import Path

import pytest

import olp
from olp.languages.vendor import maker_of, vendor_names

ROOT = Path(olp.__file__).resolve().parent
PYTHON_WORD = "as"  # a vendor's name that is a word of Python: only as a whole text
NAMES = frozenset(vendor_names())
WORDS = NAMES - {PYTHON_WORD}
MAKERS = frozenset(maker_of(name).casefold() for name in NAMES)
FILES = [path for path in sorted(ROOT.rglob("*.py")) if "vendors" not in path.relative_to(ROOT).parts[:-1]]


def parts(name: str) -> set[str]:
    """The words of an identifier: snake case, dotted or in capitals' humps."""
    return {part.lower() for part in re.findall(r"[A-Z]+[a-z0-9]*|[a-z0-9]+", name)}


def docstrings(tree: ast.AST) -> set[int]:
    """The ids of the nodes that are docstrings."""
    found = set()
    for node in ast.walk(tree):
        if isinstance(node, (ast.Module, ast.ClassDef, ast.FunctionDef)) and ast.get_docstring(
            node, clean=False
        ):
            assert isinstance(node.body[0], ast.Expr)
            found.add(id(node.body[0].value))
    return found


def identifiers(node: ast.AST) -> Iterator[str]:
    """The names that a node gives, uses or imports."""
    for field in ("id", "attr", "arg", "name", "module", "asname"):
        value = getattr(node, field, None)
        if isinstance(value, str):
            yield value


def compared(node: ast.AST) -> Iterator[ast.AST]:
    """What something is compared with, or looked up by."""
    if isinstance(node, ast.Compare):
        yield from ast.walk(node)
    elif isinstance(node, (ast.Dict, ast.Set)):
        yield from (key for key in getattr(node, "keys", getattr(node, "elts", [])) if key is not None)
    elif isinstance(node, ast.MatchValue):
        yield node.value


def known_vendors(text: str) -> list[str]:
    """What a module's text knows of vendors, as `line: word`.

    >>> known_vendors('if target == "krl": pass')
    ['1: krl']
    """
    tree = ast.parse(text)
    told = docstrings(tree)
    found: dict[str, None] = {}
    for node in ast.walk(tree):
        line = getattr(node, "lineno", 0)
        for name in identifiers(node):
            found.update(dict.fromkeys(f"{line}: {word}" for word in sorted(parts(name) & WORDS)))
        if isinstance(node, ast.Constant) and isinstance(node.value, str) and id(node) not in told:
            words = set(re.findall(r"[a-z0-9]+", node.value)) & WORDS | ({node.value} & NAMES)
            found.update(dict.fromkeys(f"{line}: {word}" for word in sorted(words)))
        for other in compared(node):
            if isinstance(other, ast.Constant) and str(other.value).casefold() in MAKERS:
                found[f"{line}: {other.value}"] = None
    return list(found)


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.relative_to(ROOT).as_posix())
def test_no_module_outside_the_vendors_knows_one(path: Path) -> None:
    assert not parts(path.stem) & WORDS
    assert known_vendors(path.read_text(encoding="utf-8")) == []


@pytest.mark.parametrize(
    ("text", "found"),
    [
        ('if work.target == "krl": pass', ["1: krl"]),
        ('"""How KRL and krl differ."""\nx = "as"', ["2: as"]),
        ('NUMBERED = {"inform": 63}', ["1: inform"]),
        ("from olp.languages.vendors.rapid.moves import LAYOUTS", ["1: rapid"]),
        ("def tp_only(): return find(Urscript)", ["1: tp", "1: urscript"]),
        ('help = "such as val3"', ["1: val3"]),
        ('if robot.maker.lower() == "yaskawa": pass', ["1: yaskawa"]),
        ('ROBOT = "yaskawa/gp25"', []),
        ('"""Names of krl."""', []),
    ],
)
def test_what_knows_a_vendor_is_found(text: str, found: list[str]) -> None:
    assert known_vendors(text) == found
