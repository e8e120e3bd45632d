"""Pairs the block markers of a routine: where each IF, WHILE, FOR and SWITCH goes, and which labels exist."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Final

from olp.core.diagnostic import Diagnostic, Span, error, warning
from olp.ir import program as st
from olp.ir.expressions import Compare, Expression, Logic, SignalState, Unary

_OPENERS: Final[Mapping[type, str]] = {
    st.If: "IFTHEN",
    st.While: "WHILE",
    st.For: "FOR",
    st.Switch: "SWITCH",
    st.Repeat: "REPEAT",
}
_CLOSERS: Final[Mapping[type, type]] = {
    st.EndIf: st.If,
    st.EndWhile: st.While,
    st.Next: st.For,
    st.EndSwitch: st.Switch,
    st.Until: st.Repeat,
}
LOOPS: Final = (st.While, st.For, st.Repeat)
_BRANCHES: Final[Mapping[type, type]] = {
    st.ElseIf: st.If,
    st.Else: st.If,
    st.Case: st.Switch,
    st.Default: st.Switch,
}
LAST_BRANCHES: Final = (st.Else, st.Default)  # for all other cases: no branch of their block follows
# Message and help of what does not pair, without a keyword: for languages with other words.
UNPAIRED: Final = {
    "P110": ("this block is never closed", "add its end after its last statement"),
    "P111": ("this belongs to a block that is not open", "remove it, or open the block above it"),
    "P114": ("this belongs inside of a loop", "remove it, or put it into a loop"),
    "P115": ("this stands behind the branch for all other cases", "that branch comes last, and once"),
}
_CLOSER_WORD: Final[Mapping[type, str]] = {
    st.If: "ENDIF",
    st.While: "ENDWHILE",
    st.For: "NEXT",
    st.Switch: "ENDSWITCH",
    st.Repeat: "UNTIL",
}


@dataclass(slots=True)
class ControlFlow:
    """`after[i]`: for a marker at i the next marker of its block; for a closer its opener. `end[i]`: its closer.

    `loop[i]`: for a Break or Continue at i the opener of its loop.
    `labels`: name -> index in the body. `problems`: unpaired markers, unknown and repeated labels.
    """

    after: dict[int, int] = field(default_factory=dict)
    end: dict[int, int] = field(default_factory=dict)
    opener: dict[int, int] = field(default_factory=dict)
    loop: dict[int, int] = field(default_factory=dict)
    labels: dict[str, int] = field(default_factory=dict)
    problems: list[Diagnostic] = field(default_factory=list)


def pair(body: Sequence[st.Statement]) -> ControlFlow:
    """The control flow of `body`. Never raises: what does not pair is a diagnostic in `problems`."""
    flow = ControlFlow()
    open_blocks: list[list[int]] = []  # indices of each open block's markers
    jumps: list[st.Jump] = []
    for index, statement in enumerate(body):
        kind = type(statement)
        if kind is st.Label:
            _add_label(flow, body, index)
        elif kind is st.Jump and isinstance(statement, st.Jump) and isinstance(statement.target, str):
            jumps.append(statement)
        elif kind in _OPENERS:
            open_blocks.append([index])
        elif kind is st.Break or kind is st.Continue:
            _add_exit(flow, body, index, open_blocks)
        elif kind in _BRANCHES or kind in _CLOSERS:
            _continue_block(flow, body, index, open_blocks)
    for markers in open_blocks:
        opener = body[markers[0]]
        _close(flow, markers, len(body))
        word = _OPENERS[type(opener)]
        flow.problems.append(
            error(
                "P110",
                f"{word} is never closed",
                Span(opener.line),
                help=f"add {_CLOSER_WORD[type(opener)]} after its last statement",
            )
        )
    flow.problems.extend(_missing_labels(jumps, flow))
    return flow


def _add_label(flow: ControlFlow, body: Sequence[st.Statement], index: int) -> None:
    label = body[index]
    assert isinstance(label, st.Label)
    if label.name in flow.labels:
        first = body[flow.labels[label.name]].line
        flow.problems.append(
            warning(
                "P112",
                f"label *{label.name} stands twice",
                Span(label.line),
                help=f"jumps go to the first one, in line {first}",
            )
        )
        return
    flow.labels[label.name] = index


def _add_exit(
    flow: ControlFlow, body: Sequence[st.Statement], index: int, open_blocks: list[list[int]]
) -> None:
    loops = [markers[0] for markers in open_blocks if type(body[markers[0]]) in LOOPS]
    if loops:
        flow.loop[index] = loops[-1]
        return
    word = type(body[index]).__name__.upper()
    flow.problems.append(
        error("P114", f"{word} outside of a loop", Span(body[index].line), help="remove it, or open a loop")
    )


def _continue_block(
    flow: ControlFlow, body: Sequence[st.Statement], index: int, open_blocks: list[list[int]]
) -> None:
    kind = type(body[index])
    closes = kind in _CLOSERS
    wanted = _CLOSERS[kind] if closes else _BRANCHES[kind]
    # A marker of an outer block means that the inner ones were never closed: those are reported at the end.
    depth = next(
        (d for d in range(len(open_blocks) - 1, -1, -1) if _opens(body, open_blocks[d], wanted)), None
    )
    if depth is None:
        word = kind.__name__.upper()
        flow.problems.append(
            error(
                "P111",
                f"{word} without {_OPENERS[wanted]}",
                Span(body[index].line),
                help="remove it, or open the block",
            )
        )
        return
    for markers in open_blocks[depth + 1 :]:
        opener = body[markers[0]]
        word = _OPENERS[type(opener)]
        flow.problems.append(
            error(
                "P110", f"{word} is never closed", Span(opener.line), help=f"add {_CLOSER_WORD[type(opener)]}"
            )
        )
        _close(flow, markers, index)
    del open_blocks[depth + 1 :]
    markers = open_blocks[depth]
    last = next((m for m in markers if type(body[m]) in LAST_BRANCHES), None)
    if last is not None and not closes:
        flow.problems.append(_behind_last(body[index], body[last]))
    markers.append(index)
    if closes:
        open_blocks.pop()
        _close(flow, markers, index)


def _behind_last(branch: st.Statement, last: st.Statement) -> Diagnostic:
    """A branch that no run reaches, or that no controller takes."""
    word = type(last).__name__.upper()
    message = f"{type(branch).__name__.upper()} behind the {word} of line {last.line}"
    return error("P115", message, Span(branch.line), help=f"{word} comes last in its block, and once")


def _opens(body: Sequence[st.Statement], markers: list[int], wanted: type) -> bool:
    return type(body[markers[0]]) is wanted


def _close(flow: ControlFlow, markers: list[int], end: int) -> None:
    for marker, following in zip(markers, [*markers[1:], end], strict=True):
        flow.after[marker] = following
        flow.end[marker] = end
        flow.opener[marker] = markers[0]


def _missing_labels(jumps: list[st.Jump], flow: ControlFlow) -> list[Diagnostic]:
    known = ", ".join(f"*{name}" for name in list(flow.labels)[:8]) or "none"
    return [
        error(
            "P113",
            f"label *{jump.target} does not exist",
            Span(jump.line),
            help=f"labels of this job: {known}",
        )
        for jump in jumps
        if jump.target not in flow.labels
    ]


# --- Tree ---
# A routine's statements as nested blocks, and back.

_TREE_CLOSERS: Final = {
    st.If: st.EndIf,
    st.While: st.EndWhile,
    st.For: st.Next,
    st.Repeat: st.Until,
    st.Switch: st.EndSwitch,
}
_OPENER_OF: Final = {closer: opener for opener, closer in _TREE_CLOSERS.items()}
_NEGATED: Final = {"=": "<>", "<>": "=", "<": ">=", ">=": "<", ">": "<=", "<=": ">"}
MIRRORED: Final = {"<": ">", ">": "<", "<=": ">=", ">=": "<="}  # comparisons whose sides change places


@dataclass(slots=True)
class Block:
    """A block statement. `branches`: each marker with what stands behind it; the first marker opens the block."""

    branches: list[tuple[st.Statement, list[Node]]]
    closer: st.Statement

    @property
    def opener(self) -> st.Statement:
        return self.branches[0][0]

    @property
    def is_loop(self) -> bool:
        return isinstance(self.opener, LOOPS)


Node = st.Statement | Block


@dataclass(slots=True)
class _Open:
    branches: list[tuple[st.Statement, list[Node]]] = field(default_factory=list)


def parse(body: Sequence[st.Statement]) -> list[Node] | None:
    """The blocks of a routine; None where its markers do not pair."""
    top: list[Node] = []
    stack: list[_Open] = []
    here = top
    for statement in body:
        kind = type(statement)
        if kind in _TREE_CLOSERS:
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


def flat(nodes: Iterable[Node]) -> Iterator[st.Statement]:
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
    return {s.name for s in flat(nodes) if type(s) is st.Label}


def jumps_in(nodes: Iterable[Node]) -> list[st.Jump]:
    """The jumps within, at any depth."""
    return [s for s in flat(nodes) if type(s) is st.Jump]


def is_plain(node: Node) -> bool:
    """Whether nothing within jumps or is jumped to, and no loop outside is left or begun anew from within."""
    if not isinstance(node, Block):
        return not isinstance(node, (st.Label, st.Jump, st.Break, st.Continue))
    return not any(isinstance(s, (st.Label, st.Jump)) for s in flat([node])) and not leaves(node)


def leaves(node: Node, inside: bool = False) -> bool:
    """Whether a Break or Continue within belongs to a loop outside."""
    if not isinstance(node, Block):
        return isinstance(node, (st.Break, st.Continue)) and not inside
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
        case Logic(first, rest) if all(word in ("and", "or") for word, _ in rest):
            turned = tuple(("or" if word == "and" else "and", negated(part)) for word, part in rest)
            return Logic(negated(first), turned)
        case _:
            return Unary("not", condition)
