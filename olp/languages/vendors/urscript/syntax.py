"""URScript as it is written: what the grammar makes of a text, before names and units have a meaning."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from typing import Any, Final, NamedTuple

POSE_NUMBERS: Final = 6


class UrscriptName(NamedTuple):
    text: str


class Literal(NamedTuple):
    """A number, a text or a truth value."""

    value: int | float | str | bool


class ListOf(NamedTuple):
    items: tuple[Node, ...]


class PoseOf(NamedTuple):
    """p[…]: x y z [m] and a rotation vector [rad]."""

    items: tuple[Node, ...]


class PlainPose(NamedTuple):
    """p[…] of six numbers that are written out: a path has thousands."""

    values: tuple[float, ...]


class Subscript(NamedTuple):
    base: Node
    indices: tuple[Node, ...]


class UrscriptDot(NamedTuple):
    base: Node
    name: str


class UrscriptArgument(NamedTuple):
    """An argument; `name` empty: by its place."""

    name: str
    value: Node


class Invocation(NamedTuple):
    function: Node
    arguments: tuple[UrscriptArgument, ...]


class Running(NamedTuple):
    """`run name()`: the handle of a thread that starts."""

    call: Node


class Sign(NamedTuple):
    """`operator`: "-", "+" or "not"."""

    operator: str
    operand: Node


class UrscriptPair(NamedTuple):
    """Two operands; `operator` as URScript writes it."""

    operator: str
    left: Node
    right: Node


Node = (
    UrscriptName
    | Literal
    | ListOf
    | PoseOf
    | PlainPose
    | Subscript
    | UrscriptDot
    | Invocation
    | Running
    | Sign
    | UrscriptPair
)


class Definition(NamedTuple):
    """`kind`: def, thread or sec. `parameters`: (name, default or None)."""

    kind: str
    name: str
    parameters: tuple[tuple[str, Node | None], ...]


class Opening(NamedTuple):
    """`word`: if, elif, else or while. `rest`: the statement behind the colon. `closed`: `end` on the same line."""

    word: str
    condition: Node | None
    rest: Simple | None
    closed: bool


class Closing(NamedTuple):
    """`end`."""


class UrscriptKeyword(NamedTuple):
    """return, break, continue, join or kill, and what follows."""

    word: str
    value: Node | None


class Assignment(NamedTuple):
    """`scope`: global, local or empty. `operator`: = or += -= *= /=."""

    scope: str
    target: Node
    operator: str
    value: Node


class Evaluation(NamedTuple):
    """An expression that is a statement: a call, or a word such as halt."""

    value: Node


Simple = UrscriptKeyword | Assignment | Evaluation
Instruction = Definition | Opening | Closing | Simple


def pose_of(items: tuple[Node, ...]) -> PoseOf | PlainPose:
    """p[…] with these items."""
    numbers = [one.value for one in items if type(one) is Literal and type(one.value) in (int, float)]
    if len(items) == len(numbers) == POSE_NUMBERS:
        return PlainPose(tuple(map(float, numbers)))
    return PoseOf(items)


def walk(node: Node) -> Iterator[Node]:
    """The expression and all expressions in it, but for literals and what holds only literals."""
    pending = [node]
    while pending:
        one = pending.pop()
        kind = type(one)
        if kind is Literal or kind is PlainPose:
            continue
        if kind is PoseOf or kind is ListOf:
            items = one.items  # type: ignore[union-attr]
            pending += [item for item in items if type(item) is not Literal]
            continue
        yield one
        pending.extend(_CHILDREN[kind](one))


_CHILDREN: Mapping[type, Callable[[Any], Iterable[Node]]] = {
    UrscriptName: lambda node: (),
    Subscript: lambda node: (node.base, *node.indices),
    UrscriptDot: lambda node: (node.base,),
    Invocation: lambda node: (node.function, *(given.value for given in node.arguments)),
    Running: lambda node: (node.call,),
    Sign: lambda node: (node.operand,),
    UrscriptPair: lambda node: (node.left, node.right),
}


def expressions(instruction: Instruction) -> Iterator[Node]:
    """The expressions that stand in an instruction, from left to right."""
    match instruction:
        case Definition(_, _, parameters):
            yield from (default for _, default in parameters if default is not None)
        case Opening(_, condition, rest, _):
            if condition is not None:
                yield condition
            if rest is not None:
                yield from expressions(rest)
        case UrscriptKeyword(_, value):
            if value is not None:
                yield value
        case Assignment(_, target, _, value):
            yield target
            yield value
        case Evaluation(value):
            yield value


def simple_of(instruction: Instruction) -> Simple | None:
    """The statement without a block in an instruction, None where there is none."""
    if isinstance(instruction, Opening):
        return instruction.rest
    if isinstance(instruction, (Definition, Closing)):
        return None
    return instruction
