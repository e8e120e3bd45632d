"""A routine's statements as nested blocks, and back."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from typing import Final

from olp.ir.expressions import Compare, Expression, Logic, SignalState, Unary
from olp.ir.program import (
    Break,
    Case,
    Continue,
    Default,
    Else,
    ElseIf,
    EndIf,
    EndSwitch,
    EndWhile,
    For,
    If,
    Jump,
    Label,
    Next,
    Repeat,
    Statement,
    Switch,
    Until,
    While,
)

LOOPS: Final = (While, For, Repeat)
_CLOSERS: Final = {If: EndIf, While: EndWhile, For: Next, Repeat: Until, Switch: EndSwitch}
_OPENER_OF: Final = {closer: opener for opener, closer in _CLOSERS.items()}
_BRANCHES: Final = {ElseIf: If, Else: If, Case: Switch, Default: Switch}
_NEGATED: Final = {"=": "<>", "<>": "=", "<": ">=", ">=": "<", ">": "<=", "<=": ">"}


@dataclass(slots=True)
class Block:
    """A block statement. `branches`: each marker with what stands behind it; the first marker opens the block."""

    branches: list[tuple[Statement, list[Node]]]
    closer: Statement

    @property
    def opener(self) -> Statement:
        return self.branches[0][0]

    @property
    def is_loop(self) -> bool:
        return isinstance(self.opener, LOOPS)


Node = Statement | Block


@dataclass(slots=True)
class _Open:
    branches: list[tuple[Statement, list[Node]]] = field(default_factory=list)


def parse(body: Sequence[Statement]) -> list[Node] | None:
    """The blocks of a routine; None where its markers do not pair."""
    top: list[Node] = []
    stack: list[_Open] = []
    here = top
    for statement in body:
        kind = type(statement)
        if kind in _CLOSERS:
            block = _Open([(statement, [])])
            stack.append(block)
            here = block.branches[0][1]
        elif kind in _BRANCHES:
            if not stack or type(stack[-1].branches[0][0]) is not _BRANCHES[kind]:
                return None
            stack[-1].branches.append((statement, []))
            here = stack[-1].branches[-1][1]
        elif kind in _OPENER_OF:
            if not stack or type(stack[-1].branches[0][0]) is not _OPENER_OF[kind]:
                return None
            done = Block(stack.pop().branches, statement)
            here = stack[-1].branches[-1][1] if stack else top
            here.append(done)
        else:
            here.append(statement)
    return None if stack else top


def flat(nodes: Iterable[Node]) -> Iterator[Statement]:
    """The statements of blocks in order of writing."""
    for node in nodes:
        if isinstance(node, Block):
            for marker, inside in node.branches:
                yield marker
                yield from flat(inside)
            yield node.closer
        else:
            yield node


def labels_in(nodes: Iterable[Node]) -> set[str]:
    """The labels within, at any depth."""
    return {s.name for s in flat(nodes) if type(s) is Label}


def jumps_in(nodes: Iterable[Node]) -> list[Jump]:
    """The jumps within, at any depth."""
    return [s for s in flat(nodes) if type(s) is Jump]


def is_plain(node: Node) -> bool:
    """Whether nothing within jumps or is jumped to, and no loop outside is left or begun anew from within."""
    if not isinstance(node, Block):
        return not isinstance(node, (Label, Jump, Break, Continue))
    return not any(isinstance(s, (Label, Jump)) for s in flat([node])) and not leaves(node)


def leaves(node: Node, inside: bool = False) -> bool:
    """Whether a Break or Continue within belongs to a loop outside."""
    if not isinstance(node, Block):
        return isinstance(node, (Break, Continue)) and not inside
    inside = inside or node.is_loop
    return any(leaves(child, inside) for _, children in node.branches for child in children)


def negated(condition: Expression) -> Expression:
    """The opposite condition: comparisons turn round, and and or change places."""
    match condition:
        case SignalState(on):
            return SignalState(not on)
        case Unary("not", operand):
            return operand
        case Compare(operator, left, SignalState(on)) if operator in ("=", "<>"):
            return Compare(operator, left, SignalState(not on))
        case Compare(operator, left, right):
            return Compare(_NEGATED[operator], left, right)
        case Logic(first, rest):
            turned = tuple(("or" if word == "and" else "and", negated(part)) for word, part in rest)
            return Logic(negated(first), turned)
        case _:
            return Unary("not", condition)
