"""The commands: one file each, found by being here.

`time.py` is `olp time`, `robot_import.py` is `olp robot import`, `recording_from_log.py` is `olp recording from-log`.
`command.py` holds what they share.
"""

from __future__ import annotations

from argparse import ArgumentParser, Namespace
from collections.abc import Sequence
from importlib import import_module
from pkgutil import iter_modules
from typing import Protocol, cast

SHARED = "command"


class Command(Protocol):
    """What the module of a command offers. Heavy imports belong inside `run`: help imports every command.

    One that runs until it is ended says `SERVES = True`.
    """

    SUMMARY: str
    """One line for `olp --help`."""

    def add_arguments(self, parser: ArgumentParser) -> None:
        """Declares the arguments."""

    def run(self, args: Namespace) -> int:
        """Does the work and returns the exit status. Raises OlpError for bad input."""


def names() -> list[str]:
    """Every command as it is typed, sorted: "robot import", "robots", "time"."""
    modules = (module.name for module in iter_modules(__path__))
    return sorted(spoken(name) for name in modules if name != SHARED and not name.startswith("_"))


def spoken(module: str) -> str:
    """The words that start a module's command."""
    return module.replace("_", " ", 1).replace("_", "-")


def load(name: str) -> Command:
    """The command of that name, one of `names()`."""
    return cast(Command, import_module(f"{__name__}.{name.replace(' ', '_').replace('-', '_')}"))


def split(words: Sequence[str]) -> tuple[str, list[str]]:
    """The longest command that `words` start with, and the words after it; ("", words) when there is none."""
    known = set(names())
    for length in range(len(words), 0, -1):
        name = " ".join(words[:length])
        if name in known:
            return name, list(words[length:])
    return "", list(words)
