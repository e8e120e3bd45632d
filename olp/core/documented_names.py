"""Keeps the module names that the documentation of version 0.1 used: `olp.recording`, `olp.lint.run` and the like.

Each is the module of today under a second name, loaded when somebody imports it.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from importlib import import_module
from importlib.machinery import ModuleSpec
from types import ModuleType
from typing import TYPE_CHECKING, Final, cast

if TYPE_CHECKING:
    from importlib.abc import Loader

# The name in the documentation -> the module or package of today.
DOCUMENTED: Final = {
    "olp.acceleration": "olp.timing.acceleration",
    "olp.backup": "olp.robots.backup",
    "olp.batch": "olp.reports.batch",
    "olp.blending": "olp.timing.blending",
    "olp.controller": "olp.servers.controller",
    "olp.diagnosis": "olp.identification.diagnosis",
    "olp.diagnosis.html": "olp.reports.diagnosis",
    "olp.diagnostic": "olp.core.diagnostic",
    "olp.dynamics": "olp.robots.dynamics",
    "olp.edit": "olp.checks.edit",
    "olp.geometry": "olp.robots.geometry",
    "olp.kinematics": "olp.robots.kinematics",
    "olp.lint": "olp.checks.lint",
    "olp.motion": "olp.timing.motion",
    "olp.physics": "olp.timing.physics",
    "olp.placing": "olp.checks.edit",
    "olp.plan": "olp.runtime.plan",
    "olp.program": "olp.ir.program",
    "olp.recording": "olp.identification.recording",
    "olp.retiming": "olp.timing.retiming",
    "olp.robot": "olp.robots.robot",
    "olp.signature": "olp.identification.signature",
    "olp.source": "olp.core.source",
    "olp.written": "olp.languages.literals",
}


def todays_name(name: str) -> str | None:
    """`olp.lint.run` -> `olp.checks.lint.run`; None for a name that the table does not hold."""
    head, rest = name, ""
    while head not in DOCUMENTED:
        head, dot, last = head.rpartition(".")
        if not dot:
            return None
        rest = f".{last}{rest}"
    return DOCUMENTED[head] + rest


# Not derived from importlib.abc's classes: those load tempfile, random and more, which costs every command 10 ms.


class _Alias:
    def __init__(self, name: str) -> None:
        self._module = import_module(name)
        self._spec = self._module.__spec__

    def create_module(self, spec: ModuleSpec) -> ModuleType:
        return self._module

    def exec_module(self, module: ModuleType) -> None:
        module.__spec__ = self._spec  # the import machinery has put the alias there


class _Finder:
    def find_spec(
        self, fullname: str, path: Sequence[str] | None, target: ModuleType | None = None
    ) -> ModuleSpec | None:
        name = todays_name(fullname)
        return None if name is None else ModuleSpec(fullname, cast("Loader", _Alias(name)))


def install() -> None:
    """Makes the names importable. Once is enough; more does no harm."""
    if not any(isinstance(finder, _Finder) for finder in sys.meta_path):
        sys.meta_path.insert(0, _Finder())
