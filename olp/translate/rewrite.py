"""Rewrites expressions wherever they stand: in statements, quantities, speeds, blends, literals."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import fields
from typing import Any, Final, TypeVar, cast, get_args

from olp.expression import Expression, Number, Quantity, State, Taught, Text
from olp.moves import Acceleration, Blend, Speed
from olp.program import Statement

T = TypeVar("T")
Change = Callable[[Expression], Expression]

EXPRESSIONS: Final = frozenset(get_args(Expression))
_LEAVES: Final = frozenset({Number, State, Taught, Text})
_MEASURED: Final = frozenset({Speed, Blend, Acceleration})
# Of statements and expressions that hold further ones: the names of the fields that may.
_FIELDS: dict[type, tuple[str, ...]] = {}
_PLAIN: Final = frozenset(
    {"line", "comment", "spelling", "path", "operator", "name", "store", "native", "other"}
)


def mapped(node: T, change: Change) -> T:
    """`node` with `change` done to every expression in it, inner ones first. The same object where nothing changes.

    Numbers that are written out as a quantity (a speed, a time) are left alone.
    """
    return cast(T, _mapped(node, change))


def _mapped(node: Any, change: Change) -> Any:
    kind = type(node)
    if kind in _LEAVES:
        return change(node)
    if kind is tuple:
        return _sequence(node, change)
    if kind in _MEASURED and (node.value is None or type(node.value.written) is Number):
        return node  # a speed or blend that is written out: there are as many as moves
    if kind is Quantity and type(node.written) is Number:
        return node
    names = _FIELDS.get(kind)
    if names is None:
        names = _FIELDS[kind] = _field_names(kind)
    if not names:
        return change(node) if kind in EXPRESSIONS else node
    changed: dict[str, Any] | None = None
    for name in names:
        old = getattr(node, name)
        if old is None:
            continue
        new = _mapped(old, change)
        if new is not old:
            changed = changed or {}
            changed[name] = new
    if changed is not None:
        node = replaced(node, changed)
    return change(node) if kind in EXPRESSIONS else node


def _sequence(node: tuple[Any, ...], change: Change) -> tuple[Any, ...]:
    if not node:
        return node
    if len(node) == 1:
        only = _mapped(node[0], change)
        return node if only is node[0] else (only,)
    new = tuple([_mapped(item, change) for item in node])
    return node if all(a is b for a, b in zip(new, node, strict=True)) else new


def replaced(node: Any, changed: dict[str, Any]) -> Any:
    """A dataclass or named tuple with some fields replaced."""
    if hasattr(node, "_replace"):
        return node._replace(**changed)
    values = {name: changed.get(name, getattr(node, name)) for name in type(node).__slots__}
    return type(node)(**values)


def _field_names(kind: type) -> tuple[str, ...]:
    if hasattr(kind, "_fields"):
        return tuple(kind._fields)
    if not hasattr(kind, "__dataclass_fields__"):
        return ()
    return tuple(
        f.name for f in fields(kind) if f.name == "other" or (f.name not in _PLAIN and f.type not in _ATOMS)
    )


_ATOMS: Final = frozenset(
    {"str", "int", "float", "bool", "tuple[float, ...]", "tuple[int, ...]", "tuple[tuple[str, str], ...]"}
)


def expressions_of(node: object) -> Iterator[Expression]:
    """Every expression in a statement or expression, inner ones first."""
    found: list[Expression] = []

    def note(expression: Expression) -> Expression:
        found.append(expression)
        return expression

    mapped(node, note)
    yield from found


def statements_mapped(body: tuple[Statement, ...], change: Change) -> tuple[Statement, ...]:
    """All statements of a body, rewritten."""
    return tuple([cast(Statement, _mapped(statement, change)) for statement in body])
