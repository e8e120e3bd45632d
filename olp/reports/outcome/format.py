"""The base of all formats of an outcome, and the list of them, which is the listing of this folder."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import ClassVar

from olp.core.registry import file_names, load_from
from olp.reports.outcome.model import Outcome

_OTHERS = frozenset({"model"})


class OutcomeFormat(ABC):
    """A way to tell an outcome. `suffix`: of a file that holds it."""

    summary: ClassVar[str]
    suffix: ClassVar[str]

    @abstractmethod
    def render(self, outcome: Outcome) -> str:
        """The whole outcome as text, the same for the same outcome."""


def format_names() -> tuple[str, ...]:
    """The names of all formats, sorted."""
    return tuple(name for name in file_names(OutcomeFormat) if name not in _OTHERS)


def load_format(name: str) -> OutcomeFormat:
    """The format called `name`. Raises OlpError (C011) that lists the known ones."""
    return load_from(OutcomeFormat, name, "format", "C011")
