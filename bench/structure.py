"""Figures of the layout: modules, those that one neighbour alone imports, floors, long functions, class names, words.

    python bench/structure.py

A floor is one more than the highest floor among a module's imports; imports in functions and for types count too. A
condition on a vendor is a comparison, a `case`, a key of a table or of a look-up that names a vendor, a maker or one of
a maker's robots; other lines that name a maker mention it: sources, examples, files of laws.
"""

from __future__ import annotations

import ast
import re
from collections import Counter, defaultdict
from graphlib import TopologicalSorter
from pathlib import Path

import olp
from olp.languages.vendor import maker_of, vendor_names

OLP = Path(olp.__file__).resolve().parent
LONG = 80
"""A function of more lines than these is listed."""
SMALL = 150
"""A module of fewer lines that one neighbour alone imports is counted: it may be part of that neighbour."""
VENDORS = "olp.languages.vendors."
MARK = re.compile(r"\b(TODO|FIXME|XXX|HACK|NotImplementedError)\b")

Imports = dict[str, set[str]]


def module_name(path: Path) -> str:
    return ".".join(path.relative_to(OLP.parent).with_suffix("").parts).removesuffix(".__init__")


def imports_of(tree: ast.Module, known: set[str]) -> set[str]:
    """The modules that a module imports, wherever in it."""
    found = set()
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and node.module:
            paths = (f"{node.module}.{alias.name}" for alias in node.names)
            found |= {path if path in known else node.module for path in paths}
    return found & known


def floors(imports: Imports) -> dict[str, int]:
    """The floor of each module; one that imports nothing of olp is on floor 1."""
    found: dict[str, int] = {}
    for name in TopologicalSorter(imports).static_order():
        found[name] = 1 + max((found[other] for other in imports[name]), default=0)
    return found


def highest_path(imports: Imports) -> list[str]:
    """The modules of one longest chain of imports, from the top."""
    levels = floors(imports)
    path = [max(levels, key=levels.__getitem__)]
    while imports[path[-1]]:
        path.append(max(sorted(imports[path[-1]]), key=levels.__getitem__))
    return path


def one_neighbour(imports: Imports) -> list[tuple[str, str]]:
    """Modules that one other module alone imports, with it. A folder's listing finds others: commands, vendors."""
    users = defaultdict(set)
    for name, others in imports.items():
        for other in others:
            users[other].add(name)
    return sorted((name, next(iter(found))) for name, found in users.items() if len(found) == 1)


def long_functions(trees: dict[str, ast.Module]) -> list[str]:
    """Functions of more than `LONG` lines, as lines and place."""
    return [
        f"{(node.end_lineno or 0) - node.lineno + 1} {name}.{node.name}"
        for name, tree in trees.items()
        for node in ast.walk(tree)
        if isinstance(node, ast.FunctionDef) and (node.end_lineno or 0) - node.lineno >= LONG
    ]


def classes_twice(trees: dict[str, ast.Module]) -> list[str]:
    """Class names that are given more than once."""
    names = (
        node.name for tree in trees.values() for node in ast.walk(tree) if isinstance(node, ast.ClassDef)
    )
    return sorted(name for name, count in Counter(names).items() if count > 1)


def asked_for(node: ast.AST) -> list[ast.AST]:
    """The expressions in a node whose value decides what happens: compared, matched, or a key."""
    match node:
        case ast.Compare(left, _, comparators):
            return [left, *comparators]
        case ast.MatchValue(value) | ast.Subscript(slice=value):
            return [value]
        case ast.Dict(keys):
            return [key for key in keys if key is not None]
        case ast.Call(ast.Attribute(attr="get" | "startswith" | "endswith"), [key, *_]):
            return [key]
    return []


def conditions(trees: dict[str, ast.Module], names: re.Pattern[str]) -> list[str]:
    """Where a text that `names` matches as a whole decides something: place and text."""
    found = {
        (name, text.lineno, text.value)
        for name, tree in trees.items()
        for node in ast.walk(tree)
        for asked in asked_for(node)
        for text in ast.walk(asked)
        if isinstance(text, ast.Constant) and isinstance(text.value, str) and names.fullmatch(text.value)
    }
    return [f"{name}:{line} {text}" for name, line, text in sorted(found)]


def lines_with(word: re.Pattern[str], texts: dict[str, str]) -> int:
    return sum(word.search(line) is not None for text in texts.values() for line in text.splitlines())


def main() -> None:
    texts = {module_name(path): path.read_text(encoding="utf-8") for path in sorted(OLP.rglob("*.py"))}
    trees = {name: ast.parse(text) for name, text in texts.items()}
    imports = {name: imports_of(tree, set(trees)) - {name} for name, tree in trees.items()}
    alone = one_neighbour(imports)
    sizes = {name: text.count("\n") for name, text in texts.items()}
    print(*(f"{sizes[name]:5} {name} <- {sizes[user]} {user}" for name, user in alone), sep="\n")
    print("longest chain:", *highest_path(imports), sep="\n  ")
    print(*long_functions(trees), sep="\n")
    print(f"{len(texts)} modules, {sum(sizes.values())} lines, {len(alone)} with one neighbour")
    small = sum(sizes[name] < SMALL for name, _ in alone)
    print(f"{small} of these have fewer than {SMALL} lines")
    outside = {name: text for name, text in texts.items() if not name.startswith(VENDORS)}
    makers = "|".join(sorted({maker_of(name) for name in vendor_names()}))
    decides = re.compile(rf"(?:{'|'.join(vendor_names())}|(?:{makers})(?:/.*)?)", re.IGNORECASE)
    asked = conditions({name: trees[name] for name in outside}, decides)
    print(*asked, sep="\n")
    print(f"{len(asked)} conditions on a vendor outside vendors' folders")
    mentions = lines_with(re.compile(rf"\b(?:{makers})\b", re.IGNORECASE), outside)
    print(f"{mentions} lines outside vendors' folders name a maker")
    print(f"{lines_with(MARK, texts)} lines with a mark of unfinished work")
    twice = classes_twice(trees)
    print(f"{max(floors(imports).values())} floors, {len(twice)} class names given twice", *twice)


if __name__ == "__main__":
    main()
