"""A process that reads and translates for days keeps what it needs: caches have an end, and garbage is collected."""

from __future__ import annotations

import ast
import gc
from importlib import import_module
from pathlib import Path

import pytest

import olp
from olp.core import memory_limit

ROOT = Path(olp.__file__).parent
FILES = sorted(ROOT.rglob("*.py"))
GROWING = {"add", "append", "appendleft", "extend", "insert", "setdefault", "update"}


def endless(decorator):
    """Whether it is functools.cache, or lru_cache without an end."""
    text = ast.unparse(decorator).removeprefix("functools.")
    return text == "cache" or text.replace(" ", "") in ("lru_cache(None)", "lru_cache(maxsize=None)")


def kept_for_ever(tree):
    """Functions whose results for any arguments are kept without end."""
    for node in ast.walk(tree):
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
    functions = [node for node in ast.walk(tree) if names and isinstance(node, (ast.FunctionDef, ast.Lambda))]
    return {name for function in functions for name in grown(function, names)}


def test_every_cache_of_the_package_has_an_end():
    """Of results: a size, or nothing that tells them apart. Of a module's own: something takes out of it again."""
    found, gathering = [], 0
    for path in FILES:
        tree = ast.parse(path.read_text(encoding="utf-8"))
        names = gathered(tree)
        gathering += len(names)
        without = [*kept_for_ever(tree), *(name for name in names if not emptied(tree, name))]
        found += [f"{path.relative_to(ROOT)}: {name}" for name in without]
    assert found == []
    assert gathering >= 3


@pytest.mark.parametrize("folder", ["inform", "tp", "urscript"])
def test_lines_that_were_seen_are_forgotten_when_there_are_too_many(folder, monkeypatch):
    """Each reader's memory of lines, with a small bound."""
    modules = {"inform": "instructions", "tp": "instructions", "urscript": "lines"}
    module = import_module(f"olp.languages.vendors.{folder}.{modules[folder]}")
    monkeypatch.setattr(module, "_MOST_CACHED", 20)
    texts = {
        "inform": "/JOB\r\n//NAME A\r\n//POS\r\n///NPOS 0,0,0,0,0,0\r\n//INST\r\n///DATE 2026/01/01 00:00\r\n"
        "///ATTR SC,RW\r\n///GROUP1 RB1\r\nNOP\r\n{}END\r\n",
        "tp": "/PROG  A\n/ATTR\n/MN\n{}/POS\n/END\n",
        "urscript": "def A():\n{}end\n",
    }
    rows = {
        "inform": "TIMER T={:.2f}\r\n",
        "tp": "   1:  WAIT {:.2f}(sec) ;\n",
        "urscript": "  sleep({:.2f})\n",
    }
    from olp.core.source import decode
    from olp.fluent import read_source

    lines = "".join(rows[folder].format(n / 100) for n in range(1, 300))
    name = {"inform": "A.JBI", "tp": "a.ls", "urscript": "a.script"}[folder]
    read_source(decode(texts[folder].format(lines).encode(), name))
    assert 0 < len(module._seen) <= 20 + 2


def test_garbage_in_cycles_is_collected_although_readers_build_without_looking_for_it(monkeypatch):
    """What a reader built counts as old, and Python looks at old objects only when it knows of enough of them."""
    monkeypatch.setattr(memory_limit, "_MOST_ADDED", 200_000)
    gc.collect()
    before = len(gc.get_objects())
    most = max(200_000, before)
    for _ in range(4 * most // 20_000):
        with memory_limit.no_garbage_collection():
            for _ in range(20_000):
                one: list[object] = []
                one.append(one)
    assert len(gc.get_objects()) - before < 2 * most


def test_collecting_is_left_as_it_was():
    assert gc.isenabled()
    with memory_limit.no_garbage_collection():
        assert not gc.isenabled()
        with memory_limit.no_garbage_collection():
            assert not gc.isenabled()
        assert not gc.isenabled()
    assert gc.isenabled()
