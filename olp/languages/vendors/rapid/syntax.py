"""What the grammar's rules hand on to one another, and how they refuse."""

from __future__ import annotations

from typing import NamedTuple

from olp.ir.expressions import Expression
from olp.languages.vendors.rapid.literals import RapidAggregate


class RapidOption(NamedTuple):
    """`\\Name:=value`; a switch has no value."""

    name: str
    value: Expression | RapidAggregate | None


class RapidArgument(NamedTuple):
    """One argument. `value` None: options alone, in front of the others."""

    value: Expression | RapidAggregate | None
    options: tuple[RapidOption, ...]
