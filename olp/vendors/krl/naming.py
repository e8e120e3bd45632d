"""Which names a statement uses, and which of them it changes."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import fields, is_dataclass
from typing import Any

from olp.expression import Item, Member, Named
from olp.program import Assign, Call, For, ReadInput, Statement, Update

_CHANGES = (Assign, Update, ReadInput)


def names_in(statement: Statement) -> Iterator[tuple[str, bool]]:
    """(name, whether the statement may change it); what a call is given may be changed by it."""
    changed: set[str] = set()
    if isinstance(statement, _CHANGES):
        changed = {_root(statement.target)}
    elif isinstance(statement, For):
        changed = {_root(statement.variable)}
    elif isinstance(statement, Call):
        changed = {name for one in (*statement.arguments, statement.result) for name in _names(one)}
    for name in set(_names(statement)):
        yield name, name in changed


def _root(it: Any) -> str:
    while isinstance(it, (Item, Member)):
        it = it.base
    return it.name if isinstance(it, Named) else ""


def _names(it: Any) -> Iterator[str]:
    if type(it) is Named:
        yield it.name
    elif isinstance(it, tuple):
        for one in it:
            yield from _names(one)
    elif is_dataclass(it) and not isinstance(it, type):
        for field in fields(it):
            yield from _names(getattr(it, field.name))
