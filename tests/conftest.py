"""Workers of pytest-xdist share the rewriting of assertions, which takes 8 s in a fresh clone."""

from __future__ import annotations

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
