"""What the grammar's rules hand on to one another, and how they refuse."""

from __future__ import annotations

from typing import NamedTuple

from olp.expression import Expression
from olp.vendors.rapid.literals import Aggregate


class BrokenError(Exception):
    """A clause that is grammatical but makes no sense. `word`: what in it is wrong; `wanted`: what would be right."""

    def __init__(self, message: str, word: str = "", wanted: str = "") -> None:
        super().__init__(message)
        self.message = message
        self.word = word
        self.wanted = wanted


class Option(NamedTuple):
    """`\\Name:=value`; a switch has no value."""

    name: str
    value: Expression | Aggregate | None


class Given(NamedTuple):
    """One argument. `value` None: options alone, in front of the others."""

    value: Expression | Aggregate | None
    options: tuple[Option, ...]
