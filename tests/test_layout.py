"""A search for a class finds one, and imports go one way: those in functions and those for types count too."""

from __future__ import annotations

import ast
from collections import defaultdict
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

import olp

ROOT = Path(olp.__file__).resolve().parent.parent


def module_name(path: Path) -> str:
    return ".".join(path.relative_to(ROOT).with_suffix("").parts).removesuffix(".__init__")


FILES = {module_name(path): path for path in sorted((ROOT / "olp").rglob("*.py"))}
TREES = {name: ast.parse(path.read_bytes()) for name, path in FILES.items()}


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
    assert classes_twice(TREES) == []


def test_no_module_imports_itself_through_others() -> None:
    assert circle(TREES) == []


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
