"""Workers of pytest-xdist share the rewriting of assertions, which takes 8 s in a fresh clone."""

from __future__ import annotations

import gc
import importlib
from contextlib import suppress
from pathlib import Path

import pytest


def pytest_sessionstart(session: pytest.Session) -> None:
    """Every second worker imports the last module first: each writes half of the bytecode and finds the other half.

    What is collected, and in which order, is not changed by it. A module that cannot be imported is told when it is
    collected.
    """
    worker = getattr(session.config, "workerinput", {}).get("workerid", "gw0")
    if int(worker.removeprefix("gw")) % 2:
        for path in sorted(Path(__file__).parent.glob("test_*.py"), reverse=True):
            with suppress(Exception, pytest.skip.Exception):
                importlib.import_module(path.stem)


def pytest_collection() -> None:
    """Nothing that is collected becomes free: a search for cycles in it finds none, and takes a sixth of the time."""
    gc.disable()


def pytest_collection_finish() -> None:
    """The 14,000 tests and all modules stay to the end: later searches leave them out."""
    gc.freeze()
    gc.enable()


def pytest_addoption(parser: pytest.Parser) -> None:
    parser.addoption("--quick", action="store_true", help="leave out the tests that are marked as slow")


def pytest_collection_modifyitems(config: pytest.Config, items: list[pytest.Item]) -> None:
    """With `--quick`, leave out what `slow` marks: the whole test, or those of its parameters that it names."""
    if not config.getoption("--quick"):
        return
    parameters: dict[tuple[str, ...], set[str]] = {}
    kept, left = [], []
    for item in items:
        mark = item.get_closest_marker("slow")
        given = item.callspec.id if isinstance(item, pytest.Function) and hasattr(item, "callspec") else ""
        if mark and mark.args:
            test = item.nodeid.partition("[")[0]
            parameters.setdefault((test, *mark.args), set()).add(given)
        (left if mark and (not mark.args or given in mark.args) else kept).append(item)
    for (test, *named), there in parameters.items():
        if unknown := set(named) - there:
            raise pytest.UsageError(
                f"{test} is marked as slow for {sorted(unknown)}, which are none of {sorted(there)}"
            )
    config.hook.pytest_deselected(items=left)
    items[:] = kept
