"""A search for a class finds one, and imports go one way: those in functions and those for types count too."""

from __future__ import annotations

import ast
import re
from collections import defaultdict
from functools import cache
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

import olp

ROOT = Path(olp.__file__).resolve().parent.parent


def module_name(path: Path) -> str:
    return ".".join(path.relative_to(ROOT).with_suffix("").parts).removesuffix(".__init__")


@cache
def trees() -> dict[str, ast.Module]:
    """Every module of olp, parsed."""
    return {module_name(path): ast.parse(path.read_bytes()) for path in sorted((ROOT / "olp").rglob("*.py"))}


def classes_twice(trees: dict[str, ast.Module]) -> list[str]:
    """Names of classes that several modules define, with the modules.

    A class that extends one of its own name counts as that one: users' `olp.Plan` is a subclass.

    >>> classes_twice({"a": ast.parse("class X: pass"), "b": ast.parse("class X: pass")})
    ['X: a, b']
    """
    found = defaultdict(list)
    for name, tree in trees.items():
        for node in ast.walk(tree):
            if isinstance(node, ast.ClassDef):
                bases = {base.attr for base in node.bases if isinstance(base, ast.Attribute)}
                if node.name not in bases:
                    found[node.name].append(name)
    return [f"{name}: {', '.join(where)}" for name, where in sorted(found.items()) if len(where) > 1]


def imported(tree: ast.Module, known: set[str]) -> set[str]:
    """The modules that a module imports, wherever in it."""
    found = set()
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and node.module:
            whole = {alias.name: f"{node.module}.{alias.name}" for alias in node.names}
            found |= {path if path in known else node.module for path in whole.values()}
    return found & known


def circle(trees: dict[str, ast.Module]) -> list[str]:
    """The modules of one import circle, in order; none where there is no circle.

    >>> circle({"a": ast.parse("import b"), "b": ast.parse("def f():\\n    import a")})
    ['a', 'b', 'a']
    """
    known = set(trees)
    arrows = {name: imported(tree, known) - {name} for name, tree in trees.items()}
    try:
        TopologicalSorter(arrows).prepare()
    except CycleError as problem:
        around = list(problem.args[1])
        return [str(name) for name in reversed(around)]
    return []


def test_a_class_name_is_given_once() -> None:
    assert classes_twice(trees()) == []


def test_no_module_imports_itself_through_others() -> None:
    assert circle(trees()) == []


def test_what_breaks_either_is_found() -> None:
    twice = {
        "a": ast.parse("class X: pass"),
        "b": ast.parse("class X: pass\nclass Y(m.Y): pass\n"),
        "c": ast.parse("class Y: pass"),
    }
    assert classes_twice(twice) == ["X: a, b"]
    lazy = {
        "a": ast.parse("from b import c"),
        "b": ast.parse(""),
        "b.c": ast.parse("def f():\n    import d"),
        "d": ast.parse("if TYPE_CHECKING:\n    from a import X"),
    }
    found = circle(lazy)
    assert set(found) == {"a", "b.c", "d"}
    assert found[0] == found[-1]


_PYTHON_FILE = re.compile(r"(?<![\w./*{}…-])[\w./*{}…-]+?\.py\b")


def files_not_there(text: str, known: set[str]) -> list[str]:
    """The Python files that a text names, as `name.py` or with the end of their path, and that do not exist.

    >>> files_not_there("see b.py, a/b.py and c/b.py; NAME.py is yours", {"x/a/b.py"})
    ['c/b.py']
    """
    ends = {"/".join(path.split("/")[i:]) for path in known for i in range(path.count("/") + 1)}
    named = (found[0].lstrip("./") for found in _PYTHON_FILE.finditer(text) if not set("*{…") & set(found[0]))
    return [name for name in named if name not in ends and not name.endswith("NAME.py")]


def test_files_that_comments_and_pages_name_exist() -> None:
    folders = ("olp", "docs", "tests", "bench", "hosts", "samples", "scripts", "templates", "grammars")
    here = [path for folder in folders for path in sorted((ROOT / folder).rglob("*"))]
    here = [path for path in here if not {"node_modules", "__pycache__"} & set(path.parts)]
    known = {path.relative_to(ROOT).as_posix() for path in here if path.suffix == ".py"}
    texts = [path for path in here if path.suffix == ".md" or path.relative_to(ROOT).parts[0] == "olp"]
    texts = [path for path in texts if path.suffix in (".md", ".py")]
    wrong = [
        f"{path.relative_to(ROOT)}: {name}"
        for path in [*texts, ROOT / "README.md", ROOT / "CONTRIBUTING.md"]
        for name in files_not_there(path.read_text(encoding="utf-8"), known)
    ]
    assert wrong == []
