"""A process that reads and translates for days keeps what it needs: caches have an end, and garbage is collected."""

from __future__ import annotations

import ast
import gc
import inspect
import pkgutil
from functools import _lru_cache_wrapper
from importlib import import_module
from pathlib import Path

import pytest

import olp
from olp.collecting import no_garbage_collection

ROOT = Path(olp.__file__).parent
FILES = sorted(ROOT.rglob("*.py"))
GROWING = {"add", "append", "appendleft", "extend", "insert", "setdefault", "update"}


def cached_functions():
    for module in pkgutil.walk_packages(olp.__path__, "olp."):
        if module.name.rpartition(".")[2] in ("__main__",):
            continue
        try:
            found = import_module(module.name)
        except ModuleNotFoundError as missing:
            if (missing.name or "").startswith("olp"):
                raise
            continue  # an extra that is not installed here
        for name, value in vars(found).items():
            if isinstance(value, _lru_cache_wrapper) and value.__module__ == module.name:
                yield f"{module.name}.{name}", value


def test_a_cache_of_results_has_an_end_or_holds_one_result():
    found = dict(cached_functions())
    assert len(found) > 30
    endless = [
        name
        for name, function in found.items()
        if function.cache_info().maxsize is None and inspect.signature(function.__wrapped__).parameters
    ]
    assert endless == []


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


def test_what_a_module_gathers_while_it_works_is_emptied_again():
    endless, gathering = [], 0
    for path in FILES:
        tree = ast.parse(path.read_text(encoding="utf-8"))
        names = set(containers(tree))
        functions = [node for node in ast.walk(tree) if isinstance(node, (ast.FunctionDef, ast.Lambda))]
        for name in {name for function in functions for name in grown(function, names)}:
            gathering += 1
            if not emptied(tree, name):
                endless.append(f"{path.relative_to(ROOT)}: {name}")
    assert endless == []
    assert gathering >= 3


@pytest.mark.parametrize("folder", ["inform", "tp", "urscript"])
def test_lines_that_were_seen_are_forgotten_when_there_are_too_many(folder, monkeypatch):
    """Each reader's memory of lines, with a small bound."""
    modules = {"inform": "instructions", "tp": "parsing", "urscript": "lines"}
    module = import_module(f"olp.vendors.{folder}.{modules[folder]}")
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
    from olp.reading import read_source
    from olp.source import decode

    lines = "".join(rows[folder].format(n / 100) for n in range(1, 300))
    name = {"inform": "A.JBI", "tp": "a.ls", "urscript": "a.script"}[folder]
    read_source(decode(texts[folder].format(lines).encode(), name))
    assert 0 < len(module._seen) <= 20 + 2


def test_garbage_in_cycles_is_collected_although_readers_build_without_looking_for_it():
    """What a reader built counts as old, and Python looks at old objects only when it knows of enough of them."""
    gc.collect()
    before, made = len(gc.get_objects()), 0
    while made < 2_600_000:
        with no_garbage_collection():
            for _ in range(100_000):
                one: list[object] = []
                one.append(one)
            made += 100_000
    assert len(gc.get_objects()) - before < 1_400_000


def test_collecting_is_left_as_it_was():
    assert gc.isenabled()
    with no_garbage_collection():
        assert not gc.isenabled()
        with no_garbage_collection():
            assert not gc.isenabled()
        assert not gc.isenabled()
    assert gc.isenabled()
