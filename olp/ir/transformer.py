"""Rewrites expressions wherever they stand: in statements, quantities, speeds, blends, literals."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import fields
from typing import Any, Final, TypeVar, get_args

from olp.core.fast_dataclass import changer
from olp.ir import expressions as ex
from olp.ir.program import (
    Acceleration,
    Assign,
    Blend,
    Call,
    Declare,
    For,
    Move,
    ReadInput,
    SetBlend,
    SetSpeed,
    Speed,
    Update,
)

T = TypeVar("T")
_changed_move: Final = changer(Move)
_changed_declare: Final = changer(Declare)
Change = Callable[[ex.Expression], ex.Expression]
Members = tuple[tuple[str, ex.Expression], ...]

EXPRESSIONS: Final = frozenset(get_args(ex.Expression))
_LEAVES: Final = frozenset(
    {ex.Number, ex.SignalState, ex.Taught, ex.Text, ex.Named, ex.PositionLiteral, ex.SystemValue}
)
_MEASURED: Final = frozenset({Speed, Blend, Acceleration})
_NUMBERED: Final = frozenset({ex.Quantity, SetSpeed, SetBlend}) | _MEASURED  # see `_is_written_out`
# Of statements and expressions that hold further ones: the names of the fields that may.
_FIELDS: dict[type, tuple[str, ...]] = {}
# `means`: of a handler, which the program's run does not come to.
_PLAIN: Final = frozenset(
    {"line", "comment", "spelling", "path", "operator", "name", "store", "native", "other", "means"}
)


def mapped(node: T, change: Change) -> T:
    """Return `node` with `change` applied to every expression in it, inner ones first; the same object where
    nothing changes.

    Literal numbers of a quantity (a speed, a time) are not passed to `change`.
    """
    found: T = _mapped(node, change)
    return found


def _mapped(node: Any, change: Change) -> Any:
    kind = type(node)
    if kind in _LEAVES:
        return change(node)
    if kind is Move and is_usual(node):
        return _mapped_move(node, change)
    if kind is Declare and type(node.value) in _LEAVES and not node.sizes:
        value = change(node.value)
        return node if value is node.value else _changed_declare(node, {"value": value})
    if kind is ex.Function:
        arguments = _sequence(node.arguments, change)
        return change(node if arguments is node.arguments else ex.Function(node.name, arguments))
    if kind is ex.RecordLiteral:  # nearly all speeds and zones of a program's data
        members = _members(node.members, change)
        return change(node if members is node.members else ex.RecordLiteral(node.type, members))
    if kind is ex.FrameRef and (node.number is None or type(node.number) is ex.Number):
        return change(node)
    if kind is tuple:
        return _sequence(node, change)
    if kind in _NUMBERED and _is_written_out(kind, node):
        return node
    names = _FIELDS.get(kind)
    if names is None:
        names = _fields_of(kind)
    if not names:
        return change(node) if kind in EXPRESSIONS else node
    changed: dict[str, Any] | None = None
    for name in names:
        old = getattr(node, name)
        if not old:  # None or empty, as most fields of a move are
            continue
        new = _mapped(old, change)
        if new is not old:
            changed = changed or {}
            changed[name] = new
    if changed is not None:
        node = replaced(node, changed)
    return change(node) if kind in EXPRESSIONS else node


def _mapped_move(s: Move, change: Change) -> Move:
    """`mapped` for a usual move (see `is_usual`), which nearly all moves are; faster than the general way."""
    changes: dict[str, Any] = {}
    targets = s.targets
    if len(targets) == 1 and type(targets[0]) in _LEAVES:
        if (target := change(targets[0])) is not targets[0]:
            changes["targets"] = (target,)
    elif (new := _sequence(targets, change)) is not targets:
        changes["targets"] = new
    if (tool := s.tool) is not None:
        seen: Any = change(tool) if type(tool) is ex.Named else _mapped(tool, change)
        if seen is not tool:
            changes["tool"] = seen
    if (frame := s.frame) is not None:
        seen = change(frame) if type(frame) is ex.Named else _mapped(frame, change)
        if seen is not frame:
            changes["frame"] = seen
    if (
        (speed := s.speed) is not None
        and type(speed.value.written) is not ex.Number
        and (new := _mapped(speed, change)) is not speed
    ):
        changes["speed"] = new
    if (
        (blend := s.blend) is not None
        and blend.value is not None
        and type(blend.value.written) is not ex.Number
        and (new := _mapped(blend, change)) is not blend
    ):
        changes["blend"] = new
    return _changed_move(s, changes) if changes else s


def edited(s: Move, changes: dict[str, Any]) -> Move:
    """Return a move with some fields replaced; several times as fast as `dataclasses.replace`."""
    return _changed_move(s, changes)


def is_usual(s: Move) -> bool:
    """Return whether a move has only targets, speed, blend, tool, frame and literal numbers."""
    if (
        s.parts
        or s.other
        or s.via is not None
        or s.deceleration is not None
        or s.relative is not None
        or s.search is not None
        or s.until is not None
        or s.arc is not None
        or s.offset is not None
        or s.tool_offset is not None
        or s.triggers
    ):
        return False
    turn, rate, share = s.turn, s.rate, s.acceleration
    return (
        (turn is None or type(turn.written) is ex.Number)
        and (rate is None or type(rate.value.written) is ex.Number)
        and (share is None or type(share.written) is ex.Number)
    )


def is_written_out(s: Move) -> bool:
    """Return whether a move goes to one place, which is at most a name, and everything else in it is a literal
    number.
    """
    tool, frame, speed, blend = s.tool, s.frame, s.speed, s.blend
    return (
        len(s.targets) == 1
        and type(s.targets[0]) in _LEAVES
        and (speed is None or type(speed.value.written) is ex.Number)
        and (blend is None or blend.value is None or type(blend.value.written) is ex.Number)
        and (
            tool is None
            or (type(tool) is ex.FrameRef and (tool.number is None or type(tool.number) is ex.Number))
        )
        and (
            frame is None
            or (type(frame) is ex.FrameRef and (frame.number is None or type(frame.number) is ex.Number))
        )
        and is_usual(s)
    )


def _sequence(node: tuple[Any, ...], change: Change) -> tuple[Any, ...]:
    for at, item in enumerate(node):
        new = change(item) if type(item) in _LEAVES else _mapped(item, change)
        if new is not item:
            return (*node[:at], new, *[_mapped(later, change) for later in node[at + 1 :]])
    return node


def _members(members: Members, change: Change) -> Members:
    for at, (name, value) in enumerate(members):
        new: ex.Expression = change(value) if type(value) in _LEAVES else _mapped(value, change)
        if new is not value:
            later = ((name, _mapped(value, change)) for name, value in members[at + 1 :])
            return (*members[:at], (name, new), *later)
    return members


def replaced(node: Any, changed: dict[str, Any]) -> Any:
    """Return a dataclass or named tuple with some fields replaced."""
    if type(node) is Move:
        return edited(node, changed)
    if type(node) is Declare:
        return _changed_declare(node, changed)
    if hasattr(node, "_replace"):
        return node._replace(**changed)
    values = {name: changed.get(name, getattr(node, name)) for name in type(node).__slots__}
    return type(node)(**values)


def _fields_of(kind: type) -> tuple[str, ...]:
    """Return the names of the fields that may hold expressions, and remember them."""
    names: tuple[str, ...] = ()
    if hasattr(kind, "_fields"):
        names = tuple(kind._fields)
    elif hasattr(kind, "__dataclass_fields__"):
        names = tuple(
            f.name
            for f in fields(kind)
            if f.name == "other" or (f.name not in _PLAIN and f.type not in _ATOMS)
        )
    _FIELDS[kind] = names
    return names


_ATOMS: Final = frozenset(
    {"str", "int", "float", "bool", "tuple[float, ...]", "tuple[int, ...]", "tuple[tuple[str, str], ...]"}
)


def expressions_of(node: object) -> list[ex.Expression]:
    """Return every expression in a statement or expression, inner ones first: those that `mapped` changes."""
    found: list[ex.Expression] = []
    gather(node, found)
    return found


def gather(node: Any, found: list[ex.Expression]) -> None:
    """Add to `found` what `expressions_of` returns: what there is most of without the detour of `mapped`."""
    kind = type(node)
    if kind in _LEAVES:
        found.append(node)
    elif kind is Move and is_usual(node):
        speed, blend = node.speed, node.blend
        for e in node.targets:
            if type(e) in _LEAVES:
                found.append(e)
            else:
                gather(e, found)
        if node.tool is not None:
            gather(node.tool, found)
        if node.frame is not None:
            gather(node.frame, found)
        if speed is not None and type(speed.value.written) is not ex.Number:
            gather(speed, found)
        if blend is not None and blend.value is not None and type(blend.value.written) is not ex.Number:
            gather(blend, found)
    elif kind is Move:
        _gather_move(node, found)
    elif kind is ex.Function:
        for e in node.arguments:
            if type(e) in _LEAVES:
                found.append(e)
            else:
                gather(e, found)
        found.append(node)
    elif kind is ex.RecordLiteral:
        for _, e in node.members:
            if type(e) in _LEAVES:
                found.append(e)
            else:
                gather(e, found)
        found.append(node)
    elif kind is Declare and not node.sizes:
        if node.value is not None:
            gather(node.value, found)
    elif kind is ex.FrameRef and (node.number is None or type(node.number) is ex.Number):
        found.append(node)
    elif kind is tuple:
        for e in node:
            if type(e) in _LEAVES:
                found.append(e)
            else:
                gather(e, found)
    elif kind not in _NUMBERED or not _is_written_out(kind, node):
        names = _FIELDS.get(kind)
        for name in _fields_of(kind) if names is None else names:
            part = getattr(node, name)
            if type(part) in _LEAVES:
                found.append(part)
            elif part:  # neither None nor empty, as most fields of a move are
                gather(part, found)
        if kind in EXPRESSIONS:
            found.append(node)


def _gather_move(s: Move, found: list[ex.Expression]) -> None:
    """`gather` for any move, in the order of its fields: most have few beside target, speed and blend."""
    for e in s.targets:
        if type(e) in _LEAVES:
            found.append(e)
        else:
            gather(e, found)
    if (speed := s.speed) is not None and type(speed.value.written) is not ex.Number:
        gather(speed.value.written, found)
    if (
        (blend := s.blend) is not None
        and blend.value is not None
        and type(blend.value.written) is not ex.Number
    ):
        gather(blend.value.written, found)
    for part in (s.parts, s.acceleration, s.deceleration, s.relative, s.search, s.until):
        if part:
            gather(part, found)
    for _, e in s.other:
        if type(e) in _LEAVES:
            found.append(e)
        else:
            gather(e, found)
    for part in (s.via, s.arc, s.rate, s.turn, s.tool, s.frame, s.offset, s.tool_offset, s.triggers):
        if part:
            gather(part, found)


def _is_written_out(kind: type, node: Any) -> bool:
    """Whether a node's only values are literal numbers of quantities, of which there are as many as moves."""
    if kind is ex.Quantity:
        return type(node.written) is ex.Number
    if kind in _MEASURED:
        return node.value is None or type(node.value.written) is ex.Number
    return (kind is SetSpeed or kind is SetBlend) and sets_numbers(node)


def changed_by(s: object) -> Iterator[str]:
    """Yield the names of the variables whose value a statement may change, including those passed to routines."""
    given: list[Any] = []
    if isinstance(s, (Assign, Update, ReadInput)):
        given.append(s.target)
    elif isinstance(s, For):
        given.append(s.variable)
    elif isinstance(s, Call):
        given += [*s.arguments, s.result]
    if not calls_nothing(s):
        given += [one for e in expressions_of(s) if isinstance(e, ex.CallValue) for one in e.arguments]
    for it in given:
        while isinstance(it, (ex.Item, ex.Member)):
            it = it.base
        if isinstance(it, ex.Named):
            yield it.name


def note_names(node: Any, found: set[str]) -> None:
    """Add to `found` the name of every variable in a statement or expression."""
    found.update([e.name for e in expressions_of(node) if type(e) is ex.Named])


def sets_numbers(s: object) -> bool:
    """Return whether a statement only sets modal speeds or blends to literal numbers."""
    parts: tuple[Speed | Blend, ...]
    if type(s) is SetSpeed and s.turn is None:
        parts = s.speeds
    elif type(s) is SetBlend:
        parts = s.blends
    else:
        return False
    for part in parts:  # noqa: SIM110 (one or two: a generator takes twice as long, and every pass asks)
        if part.value is not None and type(part.value.written) is not ex.Number:
            return False
    return True


def is_plain(s: object) -> bool:
    """Return whether a statement is a usual move to a plain target, or sets modal speeds or blends to numbers."""
    kind = type(s)
    if kind is Move:
        return type(s.targets[0]) in _LEAVES and is_usual(s)  # type: ignore[arg-type, attr-defined]
    return (kind is SetSpeed or kind is SetBlend) and sets_numbers(s)


def calls_nothing(s: object) -> bool:
    """Return whether a statement is a usual move to a plain target, so that it contains neither a call nor a
    computation.
    """
    return type(s) is Move and type(s.targets[0]) in _LEAVES and is_usual(s)
