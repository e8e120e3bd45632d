"""What a loop depends on: the statements that leave it and the variables that decide."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass

from olp.ir.block_structure import ControlFlow
from olp.ir.expressions import (
    Binary,
    CallValue,
    Compare,
    Element,
    Expression,
    Function,
    Item,
    Logic,
    Member,
    Named,
    NamedArgument,
    Number,
    Signal,
    SignalState,
    Text,
    Unary,
    Variable,
)
from olp.ir.program import (
    Assign,
    Break,
    Call,
    Case,
    ElseIf,
    End,
    If,
    Jump,
    ReadInput,
    Return,
    SetOutput,
    Statement,
    Switch,
    Until,
    Update,
    While,
)


@dataclass(frozen=True, slots=True)
class Region:
    """The statements between the head of a loop and the way back to it.

    `exits`: indices of statements that leave it. `reads`: (kind or bus, index, local) of all variables and signals
    that decide whether it is left or goes on; index None when it is computed.
    """

    exits: tuple[int, ...]
    reads: frozenset[tuple[str, int | None, bool]]


def region(body: tuple[Statement, ...], flow: ControlFlow, first: int, last: int) -> Region:
    """The region of the loop from `first` to the statement `last` that leads back."""
    exits = tuple(i for i in range(first, last) if _leaves(body, i, flow, first, last))
    exits += tuple(i for i in range(first, last) if _around(body[i], flow, i, last))
    deciding = list(_conditions(body[last]))
    if isinstance(body[first], While):
        deciding.extend(_conditions(body[first]))
    for index in exits:
        deciding.extend(_conditions(body[index]))
        for opener, end in flow.end.items():
            if first <= opener < index < end and flow.opener.get(opener) == opener:
                deciding.extend(c for marker in _markers(flow, opener) for c in _conditions(body[marker]))
        deciding.extend(
            c for i in range(first, index) if _skips(body[i], flow, i, index) for c in _conditions(body[i])
        )
    reads = {read for condition in deciding for read in reads_of(condition)}
    return Region(exits, frozenset(reads | _behind(body, flow, range(first, last), reads)))


Read = tuple[str, int | None, bool]
ANYTHING: Read = ("", None, False)  # what a routine gives back may depend on anything


def influences(bodies: Iterable[Sequence[Statement]], reads: frozenset[Read]) -> frozenset[Read]:
    """All that `reads` depend on through what `bodies` assign, the conditions around the assignments included."""
    parts = [(_assignments(body), _all_conditions(body)) for body in bodies]
    found, size = set(reads), -1
    while size != len(found):
        size = len(found)
        for assignments, conditions in parts:
            given = [sources for target, sources in assignments if not found.isdisjoint(target)]
            for sources in given:
                found |= sources
            if given:
                found |= conditions
    return frozenset(found)


def _assignments(body: Sequence[Statement]) -> list[tuple[set[Read], set[Read]]]:
    """What each statement sets, and what it reads for that."""
    found = []
    for s in body:
        if isinstance(s, (Assign, SetOutput)):
            target, value = (s.target if isinstance(s, Assign) else s.signal), s.value
            found.append((set(reads_of(target)), _sources(value)))
        elif isinstance(s, Update):
            found.append((set(reads_of(s.target)), set() if s.operand is None else _sources(s.operand)))
        elif isinstance(s, ReadInput):
            found.append((set(reads_of(s.target)), set(reads_of(s.signal))))
        elif isinstance(s, Call) and (s.result is not None or s.arguments):
            handed = (*s.arguments, *(() if s.result is None else (s.result,)))
            found.append(({read for e in handed for read in reads_of(e)}, {ANYTHING}))
    return found


def _sources(value: Expression) -> set[Read]:
    return set(reads_of(value)) | ({ANYTHING} if isinstance(value, CallValue) else set())


def _all_conditions(body: Sequence[Statement]) -> set[Read]:
    return {read for s in body for condition in _conditions(s) for read in reads_of(condition)}


def _behind(body: tuple[Statement, ...], flow: ControlFlow, inside: range, reads: set[Read]) -> set[Read]:
    """What conditions inside the loop read that decide whether a deciding variable is set: progress in them is some."""
    found: set[Read] = set()
    for opener, end in flow.end.items():
        if opener not in inside or flow.opener.get(opener) != opener or isinstance(body[opener], While):
            continue
        targets = (s.target for s in body[opener:end] if isinstance(s, (Assign, Update, ReadInput)))
        if any(read in reads for target in targets for read in reads_of(target)):
            conditions = (c for marker in _markers(flow, opener) for c in _conditions(body[marker]))
            found.update(read for condition in conditions for read in reads_of(condition))
    return found


def _leaves(body: tuple[Statement, ...], index: int, flow: ControlFlow, first: int, last: int) -> bool:
    statement = body[index]
    if isinstance(statement, (Return, End)):
        return True
    if isinstance(statement, Call):
        return statement.jump
    if isinstance(statement, Break):
        return flow.loop.get(index, first) <= first  # one of a loop inside ends that one
    if isinstance(statement, Jump):
        target = flow.labels.get(statement.target) if isinstance(statement.target, str) else None
        return target is None or not first <= target <= last
    return False


def _around(statement: Statement, flow: ControlFlow, index: int, last: int) -> bool:
    """Whether the way back stands in the branch of an IF: the loop is left where the branch is not taken."""
    return isinstance(statement, If) and index < last < flow.after.get(index, index)


def _skips(statement: Statement, flow: ControlFlow, index: int, over: int) -> bool:
    """Whether a jump inside the loop can pass over an exit."""
    if not isinstance(statement, Jump) or not isinstance(statement.target, str):
        return False
    return flow.labels.get(statement.target, index) > over


def _markers(flow: ControlFlow, opener: int) -> Iterator[int]:
    marker, end = opener, flow.end[opener]
    while marker < end:
        yield marker
        marker = flow.after[marker]


def _conditions(statement: Statement) -> Iterator[Expression]:
    if isinstance(statement, (If, ElseIf, While, Until)):
        yield statement.condition
    elif isinstance(statement, (Jump, Return, Call)):
        if statement.condition is not None:
            yield statement.condition
        if isinstance(statement, Jump) and not isinstance(statement.target, str):
            yield statement.target
    elif isinstance(statement, Switch):
        yield statement.value
    elif isinstance(statement, Case):
        yield from statement.values


def is_literal(e: Expression) -> bool:
    """Whether an expression is the same whatever happens: literals, and operators between them."""
    if isinstance(e, (Compare, Binary)):
        return is_literal(e.left) and is_literal(e.right)
    if isinstance(e, Logic):
        return all(is_literal(part) for part in (e.first, *(condition for _, condition in e.rest)))
    if isinstance(e, Unary):
        return is_literal(e.operand)
    return isinstance(e, (Number, Text, SignalState))


def reads_of(e: Expression) -> Iterator[tuple[str, int | None, bool]]:
    """(kind or bus, index, local) of every variable and signal in an expression."""
    if isinstance(e, (Variable, Signal)):
        kind = e.store if isinstance(e, Variable) else e.bus
        index = int(e.index.value) if isinstance(e.index, Number) else None
        yield kind, index, isinstance(e, Variable) and e.local
        yield from reads_of(e.index)
    elif isinstance(e, (Compare, Binary)):
        yield from reads_of(e.left)
        yield from reads_of(e.right)
    elif isinstance(e, Logic):
        for part in (e.first, *(condition for _, condition in e.rest)):
            yield from reads_of(part)
    elif isinstance(e, Unary):
        yield from reads_of(e.operand)
    elif isinstance(e, (Function, CallValue)):
        for argument in e.arguments:
            yield from reads_of(argument)
    elif isinstance(e, Named):
        yield f"name:{e.name.casefold()}", 0, False
    elif isinstance(e, (Item, Member)):
        yield from reads_of(e.base)
        for inner in e.indices if isinstance(e, Item) else ():
            yield from reads_of(inner)
    elif isinstance(e, NamedArgument) and e.value is not None:
        yield from reads_of(e.value)
    elif isinstance(e, Element):
        yield from reads_of(e.variable)
