"""A process that reads for days keeps what it needs: lines are forgotten, and garbage is collected."""

from __future__ import annotations

import gc
import subprocess
import sys
from importlib import import_module
from pathlib import Path

import pytest

import olp
from olp.core import garbage_collection, result_cache

ROOT = Path(olp.__file__).parent


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


def test_garbage_in_cycles_is_collected_although_readers_build_without_looking_for_it():
    """What a reader built counts as old, and Python looks at old objects only when it knows of enough of them.

    In a Python of its own: as many objects are let live as there were, and earlier tests leave a million.
    """
    code = """
import gc
from olp.core import garbage_collection
garbage_collection._MOST_ADDED = 100_000
before = len(gc.get_objects())
for _ in range(25):
    with garbage_collection.no_garbage_collection():
        for _ in range(20_000):
            one = []
            one.append(one)
print(len(gc.get_objects()) - before)
"""
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, check=True, cwd=ROOT.parent)
    assert int(done.stdout) < 250_000


def test_collecting_is_left_as_it_was():
    assert gc.isenabled()
    with garbage_collection.no_garbage_collection():
        assert not gc.isenabled()
        with garbage_collection.no_garbage_collection():
            assert not gc.isenabled()
        assert not gc.isenabled()
    assert gc.isenabled()


def test_a_shelf_of_bounded_size_keeps_what_is_asked_for_and_drops_the_rest() -> None:
    shelf = result_cache.CacheShelf(most=3)
    shelf.put("kept", 1)
    for n in range(20):
        shelf.put(n, n + 1)
        assert shelf.get("kept") == 1
    assert [shelf.get(n) for n in (0, 10, 19)] == [None, None, 20]
