"""What holds for the source as a whole, which is parsed once.

A search for a class finds one; imports go one way, those in functions and those for types too; nothing outside a
vendor's folder knows the vendor; what is kept has an end; files that are named exist.
"""

from __future__ import annotations

import ast
import gc
import re
import sys
import tomllib
from collections import defaultdict
from collections.abc import Iterator
from functools import cache
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

import pytest

import olp
from olp.core.documented_names import todays_name
from olp.languages.vendor import maker_of, vendor_names

ROOT = Path(olp.__file__).resolve().parent.parent


def module_name(path: Path) -> str:
    return ".".join(path.relative_to(ROOT).with_suffix("").parts).removesuffix(".__init__")


@cache
def trees() -> dict[str, ast.Module]:
    """Every module of olp, parsed."""
    return {module_name(path): ast.parse(path.read_bytes()) for path in sorted((ROOT / "olp").rglob("*.py"))}


@cache
def nodes(tree: ast.Module) -> tuple[ast.AST, ...]:
    """All nodes of a module, which most tests go through."""
    return tuple(ast.walk(tree))


@pytest.fixture(autouse=True, scope="module")
def _kept_for_these_tests_alone() -> Iterator[None]:
    """The trees are millions of objects: no search for cycles goes through them, and later tests do not find them."""
    gc.disable()
    yield
    for kept in (trees, nodes, named_in, ends_of):
        kept.cache_clear()
    gc.enable()


def classes_twice(trees: dict[str, ast.Module]) -> list[str]:
    """Names of classes that several modules define, with the modules.

    >>> classes_twice({"a": ast.parse("class X: pass"), "b": ast.parse("class X: pass")})
    ['X: a, b']
    """
    found = defaultdict(list)
    for name, tree in trees.items():
        for node in nodes(tree):
            if isinstance(node, ast.ClassDef):
                found[node.name].append(name)
    return [f"{name}: {', '.join(where)}" for name, where in sorted(found.items()) if len(where) > 1]


def imported(tree: ast.Module, known: set[str]) -> set[str]:
    """The modules that a module imports, wherever in it."""
    found = set()
    for node in nodes(tree):
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
    assert classes_twice(twice) == ["X: a, b", "Y: b, c"]
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


@cache
def ends_of(known: frozenset[str]) -> frozenset[str]:
    """What comments may call these files: a/b/c.py is c.py and b/c.py, too."""
    return frozenset("/".join(path.split("/")[i:]) for path in known for i in range(path.count("/") + 1))


def files_not_there(text: str, known: set[str]) -> list[str]:
    """The Python files that a text names, as `name.py` or with the end of their path, and that do not exist.

    >>> files_not_there("see b.py, a/b.py and c/b.py; NAME.py is yours", {"x/a/b.py"})
    ['c/b.py']
    """
    ends = ends_of(frozenset(known))
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


_DOTTED = re.compile(r"\bolp(?:\.[A-Za-z]\w*){2,}")


@cache
def named_in(module: str) -> set[str]:
    """What a module defines or imports, wherever in it."""
    return {
        word
        for node in nodes(trees()[module])
        for word in (getattr(node, at, None) for at in ("id", "name", "attr", "asname"))
        if word
    }


def is_there(dotted: str) -> bool:
    """Whether a dotted name is a module, or something in one; `olp.Plan` is in olp.

    >>> is_there("olp.core.units.mm"), is_there("olp.core.units.miles")
    (True, False)
    """
    dotted = todays_name(dotted) or dotted
    module = next(m for m in (dotted, *prefixes(dotted)) if m in trees())
    return set(dotted.removeprefix(module).split(".")[1:]) <= named_in(module) | set(olp.__all__)


def prefixes(dotted: str) -> Iterator[str]:
    """a.b.c: a.b, a"""
    while "." in dotted:
        dotted = dotted.rpartition(".")[0]
        yield dotted


def test_modules_and_functions_that_comments_and_pages_name_exist() -> None:
    pages = [*(ROOT / "docs").rglob("*.md"), *(ROOT / "olp").rglob("*.py"), *ROOT.glob("*.md")]
    pages = [path for path in pages if path.name != "CHANGELOG.md"]  # what was
    found = {name for path in pages for name in _DOTTED.findall(path.read_text(encoding="utf-8"))}
    assert len(found) > 400
    assert [name for name in sorted(found) if not is_there(name)] == []
    assert not is_there("olp.checks.edit.miles")


# --- vendors ---


PYTHON_WORD = "as"  # a vendor's name that is a word of Python: only as a whole text
NAMES = frozenset(vendor_names())
WORDS = NAMES - {PYTHON_WORD}
MAKERS = frozenset(maker_of(name).casefold() for name in NAMES)


def parts(name: str) -> set[str]:
    """The words of an identifier: snake case, dotted or in capitals' humps."""
    return {part.lower() for part in re.findall(r"[A-Z]+[a-z0-9]*|[a-z0-9]+", name)}


def docstrings(tree: ast.AST) -> set[int]:
    """The ids of the nodes that are docstrings."""
    found = set()
    for node in nodes(tree):
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


def known_vendors(tree: ast.Module) -> list[str]:
    """What a module knows of vendors, as `line: word`.

    A language's name is found as a text, as a word of a text (but for docstrings), as a part of a name, a module or a
    file; a maker's where something is compared with it.

    >>> known_vendors(ast.parse('if target == "krl": pass'))
    ['1: krl']
    """
    told = docstrings(tree)
    found: dict[str, None] = {}
    for node in nodes(tree):
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


def test_no_module_outside_the_vendors_knows_one() -> None:
    """Neither the name of a language nor that of its maker."""
    inside = "olp.languages.vendors."
    outside = {name: tree for name, tree in trees().items() if not name.startswith(inside)}
    assert [name for name in outside if parts(name.rpartition(".")[2]) & WORDS] == []
    told = [f"{name}: {word}" for name, tree in outside.items() for word in known_vendors(tree)]
    assert told == []


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
    assert known_vendors(ast.parse(text)) == found


# --- what is kept ---


GROWING = {"add", "append", "appendleft", "extend", "insert", "setdefault", "update"}


def endless(decorator):
    """Whether it is functools.cache, or lru_cache without an end."""
    text = ast.unparse(decorator).removeprefix("functools.")
    return text == "cache" or text.replace(" ", "") in ("lru_cache(None)", "lru_cache(maxsize=None)")


def kept_for_ever(tree):
    """Functions whose results for any arguments are kept without end."""
    for node in nodes(tree):
        if not isinstance(node, ast.FunctionDef) or not any(map(endless, node.decorator_list)):
            continue
        if node.args.posonlyargs + node.args.args + node.args.kwonlyargs:
            yield node.name


def containers(tree):
    """Names of a module's own mutable containers, but for those that hold one entry per class."""
    for node in tree.body:
        targets = node.targets if isinstance(node, ast.Assign) else [getattr(node, "target", None)]
        value = getattr(node, "value", None)
        kind = ast.unparse(node.annotation) if isinstance(node, ast.AnnAssign) else ""
        made = isinstance(value, (ast.Dict, ast.List, ast.Set, ast.DictComp, ast.ListComp, ast.SetComp)) or (
            isinstance(value, ast.Call)
            and ast.unparse(value.func) in ("dict", "list", "set", "deque", "defaultdict", "Counter")
        )
        if made and "dict[type" not in kind:
            yield from (target.id for target in targets if isinstance(target, ast.Name))


def grown(function, names):
    """Which of the module's names a function puts something into, or hands to one that may."""
    for node in ast.walk(function):
        if isinstance(node, ast.Subscript) and isinstance(node.ctx, ast.Store):
            held = node.value
        elif (
            isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute) and node.func.attr in GROWING
        ):
            held = node.func.value
        else:
            continue
        if isinstance(held, ast.Name) and held.id in names:
            yield held.id


def emptied(tree, name):
    """Whether a module takes something out of a container again."""
    text = ast.unparse(tree)
    return (
        any(f"{name}.{how}(" in text for how in ("clear", "pop", "popitem", "popleft"))
        or f"del {name}[" in text
    )


def gathered(tree):
    """Containers of a module that its functions put something into."""
    names = set(containers(tree))
    functions = [node for node in nodes(tree) if names and isinstance(node, (ast.FunctionDef, ast.Lambda))]
    return {name for function in functions for name in grown(function, names)}


def test_every_cache_of_the_package_has_an_end() -> None:
    """Of results: a size, or nothing that tells them apart. Of a module's own: something takes out of it again."""
    found, gathering = [], 0
    for module, tree in trees().items():
        names = gathered(tree)
        gathering += len(names)
        without = [*kept_for_ever(tree), *(name for name in names if not emptied(tree, name))]
        found += [f"{module}: {name}" for name in without]
    assert found == []
    assert gathering >= 3


def test_olp_imports_nothing_that_its_installation_does_not_bring():
    """An import of scipy, which the tests bring, ended `olp diagnose` in a traceback for whoever installed olp."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    asked = [
        *project["dependencies"],
        *(x for some in project["optional-dependencies"].values() for x in some),
    ]
    brought = {re.split(r"[^\w-]", one)[0].lower().replace("-", "_") for one in asked}
    known = {*sys.stdlib_module_names, "olp", "pytest"} | brought  # a plugin of pytest is imported by pytest
    known |= {{"pillow": "PIL"}.get(name, name) for name in brought}
    known |= {"markupsafe", "lsprotocol", "mcp_types", "pydantic"}  # which jinja2, pygls and mcp bring
    known |= {"matplotlib"}  # of the notebook that draws: a figure is drawn where it is there
    unknown = defaultdict(set)
    for module, tree in trees().items():
        for node in nodes(tree):
            names = [alias.name for alias in node.names] if isinstance(node, ast.Import) else []
            if isinstance(node, ast.ImportFrom) and not node.level and node.module:
                names = [node.module]
            for name in names:
                if (package := name.split(".")[0]) not in known:
                    unknown[package].add(module)
    assert not unknown
