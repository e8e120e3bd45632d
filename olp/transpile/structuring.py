"""Labels and jumps as blocks: loops and branches where the pattern shows one, else a loop over numbered steps."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

from olp.ir import program as st
from olp.ir.block_structure import Block, Node, is_plain, jumps_in, labels_in, leaves, negated
from olp.ir.expressions import Compare, Expression, Named, Number, SignalState

_ROUNDS = 200  # of looking for patterns; each round removes a label


def needs_flattening(nodes: list[Node]) -> bool:
    """Whether something jumps into a block from outside: no structured language has that."""
    return any(_is_entered(node, nodes) for node in _blocks(nodes))


def _blocks(nodes: list[Node]) -> list[Block]:
    found: list[Block] = []
    for node in nodes:
        if isinstance(node, Block):
            found.append(node)
            for _, inside in node.branches:
                found += _blocks(inside)
    return found


def _is_entered(block: Block, everything: list[Node]) -> bool:
    """Whether a jump from outside of a branch leads into it."""
    for _, inside in block.branches:
        labels = labels_in(inside)
        if labels:
            own = [id(jump) for jump in jumps_in(inside)]
            if any(jump.target in labels and id(jump) not in own for jump in jumps_in(everything)):
                return True
    return False


# --- blocks as jumps ------------------------------------------------------------------------------------


def flattened(nodes: list[Node], label: Callable[[], str], jumping: bool = False) -> list[Node]:
    """Blocks that something jumps into as jumps; with `jumping` all that hold a label or a jump."""
    top = nodes

    def flatten(nodes: list[Node], leave: str, again: str) -> list[Node]:
        result: list[Node] = []
        for node in nodes:
            if isinstance(node, st.Break) and leave:
                result.append(st.Jump(node.line, leave, comment=node.comment))
            elif isinstance(node, st.Continue) and again:
                result.append(st.Jump(node.line, again, comment=node.comment))
            elif not isinstance(node, Block) or (jumping and is_plain(node)):
                result.append(node)
            elif jumping or _is_entered(node, top) or (leave and leaves(node)):
                result += _opened(node, label, flatten, leave, again)
            else:
                inner = [
                    (m, flatten(inside, "" if node.is_loop else leave, "" if node.is_loop else again))
                    for m, inside in node.branches
                ]
                result.append(Block(inner, node.closer))
        return result

    return flatten(nodes, "", "")


def _opened(
    block: Block,
    label: Callable[[], str],
    flatten: Callable[[list[Node], str, str], list[Node]],
    leave: str,
    again: str,
) -> list[Node]:
    head, closer = block.opener, block.closer
    match head:
        case st.If() | st.Switch():
            return _opened_branches(block, label, flatten, leave, again)
        case st.While():
            start, end = label(), label()
            test: list[Node] = [st.Jump(head.line, end, negated(head.condition), head.comment)]
            if head.condition == SignalState(True):
                test = []
            inside = flatten(block.branches[0][1], end, start)
            return [
                st.Label(head.line, start),
                *test,
                *inside,
                st.Jump(closer.line, start),
                st.Label(closer.line, end),
            ]
        case st.Repeat():
            assert isinstance(closer, st.Until)
            start, test_at, end = label(), label(), label()
            inside = flatten(block.branches[0][1], end, test_at)
            back = st.Jump(closer.line, start, negated(closer.condition), closer.comment)
            return [
                st.Label(head.line, start),
                *inside,
                st.Label(closer.line, test_at),
                back,
                st.Label(closer.line, end),
            ]
        case _:
            assert isinstance(head, st.For)
            return _opened_for(block, head, label, flatten)


def _opened_for(
    block: Block,
    head: st.For,
    label: Callable[[], str],
    flatten: Callable[[list[Node], str, str], list[Node]],
) -> list[Node]:
    from olp.ir.expressions import Binary

    step = head.step or Number(1)
    start, count_at, end = label(), label(), label()
    beyond = Compare(">" if not isinstance(step, Number) or step.value > 0 else "<", head.variable, head.stop)
    line = block.closer.line
    return [
        st.Assign(head.line, head.variable, head.start, head.comment),
        st.Label(head.line, start),
        st.Jump(head.line, end, beyond),
        *flatten(block.branches[0][1], end, count_at),
        st.Label(line, count_at),
        st.Assign(line, head.variable, Binary("+", head.variable, step)),
        st.Jump(line, start),
        st.Label(line, end),
    ]


def _opened_branches(
    block: Block,
    label: Callable[[], str],
    flatten: Callable[[list[Node], str, str], list[Node]],
    leave: str,
    again: str,
) -> list[Node]:
    end = label()
    result: list[Node] = []
    value = block.opener.value if isinstance(block.opener, st.Switch) else None
    rows = block.branches
    if isinstance(block.opener, st.Switch):
        result += [s for s in rows[0][1] if isinstance(s, st.Comment)]
        rows = rows[1:]
    # The branch without a condition is tried last, wherever it stands.
    rows = [row for row in rows if not _is_else(row[0])] + [row for row in rows if _is_else(row[0])]
    for marker, inside in rows:
        following = label()
        condition = _condition(marker, value)
        if condition is not None:
            result.append(st.Jump(marker.line, following, negated(condition), getattr(marker, "comment", "")))
        result += flatten(inside, leave, again)
        result += [st.Jump(marker.line, end), st.Label(marker.line, following)]
    return [*result, st.Label(block.closer.line, end)]


def _is_else(marker: st.Statement) -> bool:
    return not isinstance(marker, (st.If, st.ElseIf, st.Case))


def _condition(marker: st.Statement, value: Expression | None) -> Expression | None:
    if isinstance(marker, (st.If, st.ElseIf)):
        return marker.condition
    if isinstance(marker, st.Case) and value is not None:
        from olp.ir.expressions import Logic

        tests = [Compare("=", value, one) for one in marker.values]
        return tests[0] if len(tests) == 1 else Logic(tests[0], tuple(("or", test) for test in tests[1:]))
    return None


# --- jumps as blocks ------------------------------------------------------------------------------------


def structured(nodes: list[Node]) -> list[Node]:
    """Loops and branches for the labels whose jumps show one; other labels and jumps stay."""
    everything = nodes
    for _ in range(_ROUNDS):
        used = {jump.target for jump in jumps_in(everything)}
        everything = _without_labels(everything, used)
        changed = _one_pattern(everything, everything)
        if changed is None:
            return everything
        everything = changed
    return everything


def _without_labels(nodes: list[Node], used: set[str | Expression]) -> list[Node]:
    kept: list[Node] = []
    for node in nodes:
        if isinstance(node, Block):
            node = Block([(m, _without_labels(inside, used)) for m, inside in node.branches], node.closer)
        elif isinstance(node, st.Label) and node.name not in used:
            kept += _remarks(node)
            continue
        kept.append(node)
    return kept


def _remarks(*gone: Node) -> list[Node]:
    """What labels and jumps said that are not there any more."""
    return [st.Comment(s.line, s.comment) for s in gone if isinstance(s, (st.Label, st.Jump)) and s.comment]


def _one_pattern(nodes: list[Node], everything: list[Node]) -> list[Node] | None:
    """The nodes after one pattern is replaced, which removes a label; None where no pattern is found."""
    for at, node in enumerate(nodes):
        if isinstance(node, Block):
            for branch, (marker, inside) in enumerate(node.branches):
                changed = _one_pattern(inside, everything)
                if changed is not None:
                    branches = [*node.branches]
                    branches[branch] = (marker, changed)
                    return [*nodes[:at], Block(branches, node.closer), *nodes[at + 1 :]]
    for at, node in enumerate(nodes):
        if isinstance(node, st.Label):
            jumps = [jump for jump in jumps_in(everything) if jump.target == node.name]
            changed = _branch(nodes, at, jumps, everything) or _loop(nodes, at, node, jumps, everything)
            if changed is not None:
                return changed
    return None


def _place(nodes: list[Node], jump: st.Jump) -> int:
    return next((at for at, node in enumerate(nodes) if node is jump), -1)


def _closed(inside: list[Node], everything: list[Node], own: set[str] = frozenset()) -> bool:  # type: ignore[assignment]
    """Whether no jump leads into these nodes or out of them (but to `own`)."""
    labels, mine = labels_in(inside), jumps_in(inside)
    ids = {id(jump) for jump in mine}
    if any(jump.target not in labels and jump.target not in own for jump in mine):
        return False
    return not any(jump.target in labels and id(jump) not in ids for jump in jumps_in(everything))


def _branch(nodes: list[Node], at: int, jumps: list[st.Jump], everything: list[Node]) -> list[Node] | None:
    """A jump forward over some statements: they run where its condition does not hold."""
    if len(jumps) != 1 or not 0 <= (start := _place(nodes, jumps[0])) < at:
        return None
    jump, inside, label = jumps[0], nodes[start + 1 : at], nodes[at]
    condition: Expression = SignalState(False) if jump.condition is None else negated(jump.condition)
    if not _closed(inside, everything):
        return _choice(nodes, start, at, jump, everything)
    assert isinstance(label, st.Label)
    if not inside:
        return [*nodes[:start], *_remarks(jump, label), *nodes[at + 1 :]]
    block = Block([(st.If(jump.line, condition, jump.comment), inside)], st.EndIf(label.line, label.comment))
    return [*nodes[:start], block, *nodes[at + 1 :]]


def _choice(
    nodes: list[Node], start: int, at: int, jump: st.Jump, everything: list[Node]
) -> list[Node] | None:
    """IF c GOTO a; …; GOTO b; a: …; b: is a branch with an ELSE."""
    out, end = nodes[at - 1], -1
    if not isinstance(out, st.Jump) or out.condition is not None or jump.condition is None:
        return None
    for place in range(at + 1, len(nodes)):
        label = nodes[place]
        if isinstance(label, st.Label) and label.name == out.target:
            end = place
    if end < 0:
        return None
    first, second = nodes[start + 1 : at - 1], nodes[at + 1 : end]
    if not _closed(first, everything) or not _closed(second, everything):
        return None
    label = nodes[at]
    assert isinstance(label, st.Label)
    branches: list[tuple[st.Statement, list[Node]]] = [
        (st.If(jump.line, negated(jump.condition), jump.comment), [*first, *_remarks(out)]),
        (st.Else(label.line, label.comment), second),
    ]
    # The label behind stays: other jumps may lead to it, and an unused one is taken away.
    return [*nodes[:start], Block(branches, st.EndIf(out.line)), *nodes[end:]]


def _loop(
    nodes: list[Node], at: int, label: st.Label, jumps: list[st.Jump], everything: list[Node]
) -> list[Node] | None:
    """A loop for a jump back to a label; jumps to its head and behind it continue and break it."""
    places = [_place(nodes, jump) for jump in jumps]
    last = max(places, default=-1)
    if last <= at:
        return None
    back = nodes[last]
    assert isinstance(back, st.Jump)
    inside = nodes[at + 1 : last]
    if len(jumps) == 1 and _closed(inside, everything) and back.condition is not None:
        until = st.Until(back.line, negated(back.condition), back.comment)
        if any(leaves(node) for node in inside):
            return None
        return [
            *nodes[:at],
            Block([(st.Repeat(label.line, label.comment), inside)], until),
            *nodes[last + 1 :],
        ]
    if back.condition is not None or any(leaves(node) for node in inside):
        return None
    behind = nodes[last + 1] if last + 1 < len(nodes) else None
    leave = behind.name if isinstance(behind, st.Label) else ""
    if not _closed(inside, everything, {label.name, leave} - {""}):
        return None
    if any(id(jump) not in {id(j) for j in jumps_in(inside)} and jump is not back for jump in jumps):
        return None
    head = st.While(label.line, SignalState(True), label.comment)
    match inside:
        case [st.Jump(condition=exits) as first, *_] if exits is not None and first.target == leave:
            # What leaves at once is the condition of the loop.
            if not (label.comment and first.comment):
                head = st.While(first.line, negated(exits), label.comment or first.comment)
                inside = inside[1:]
    body = _with_exits(inside, label.name, leave)
    if body is None:
        return None
    return [
        *nodes[:at],
        Block([(head, body)], st.EndWhile(back.line, back.comment)),
        *nodes[last + 1 :],
    ]


def _with_exits(nodes: list[Node], again: str, leave: str) -> list[Node] | None:
    """Jumps to the loop's head and behind its end as Continue and Break; None within a loop of its own."""
    result: list[Node] = []
    for node in nodes:
        if isinstance(node, st.Jump) and node.target in (again, leave):
            inner = (
                st.Continue(node.line, node.comment)
                if node.target == again
                else st.Break(node.line, node.comment)
            )
            if node.condition is None:
                result.append(inner)
            else:
                result.append(Block([(st.If(node.line, node.condition), [inner])], st.EndIf(node.line)))
        elif isinstance(node, Block):
            if node.is_loop and any(jump.target in (again, leave) for jump in jumps_in([node])):
                return None
            branches: list[tuple[st.Statement, list[Node]]] = []
            for marker, inside in node.branches:
                changed = inside if node.is_loop else _with_exits(inside, again, leave)
                if changed is None:
                    return None
                branches.append((marker, changed))
            result.append(Block(branches, node.closer))
        else:
            result.append(node)
    return result


# --- anything else --------------------------------------------------------------------------------------


@dataclass(slots=True)
class _Exit:
    """Which step is next, -1 for the end; `comment`: what the jump there said."""

    to: int
    comment: str = ""


@dataclass(slots=True)
class _Step:
    """Statements between labels and jumps, and what follows: with a condition the first exit where it holds."""

    nodes: list[Node]
    line: int
    exits: list[_Exit]
    condition: Expression | None = None


def machine(nodes: list[Node], counter: Named) -> list[Node]:
    """Steps between labels and jumps, each chosen by a counter that says which one is next."""
    head = [node for node in nodes if isinstance(node, (st.Begin, st.Declare))]
    tail = [node for node in nodes if isinstance(node, st.End)]
    rest: list[Node] = [node for node in nodes if not isinstance(node, (st.Begin, st.Declare, st.End))]
    line = getattr(rest[0], "line", 0) if rest and not isinstance(rest[0], Block) else 0
    branches: list[tuple[st.Statement, list[Node]]] = [(st.Switch(line, counter), [])]
    first, steps = _joined(_steps(rest, line))
    for number, step in enumerate(steps):
        branches.append((st.Case(line, (Number(number),)), [*step.nodes, *_next(counter, step)]))
    choice = Block(branches, st.EndSwitch(line))
    loop = Block([(st.While(line, Compare(">=", counter, Number(0))), [choice])], st.EndWhile(line))
    return [*head, st.Assign(line, counter, Number(first)), loop, *tail]


def _steps(nodes: list[Node], line: int) -> list[_Step]:
    steps: list[list[Node]] = [[]]
    at: dict[str, int] = {}
    jumps: dict[int, st.Jump] = {}
    for node in nodes:
        if isinstance(node, st.Label):
            steps.append(_remarks(node))
            at.setdefault(node.name, len(steps) - 1)
        elif isinstance(node, st.Jump):
            jumps[len(steps) - 1] = node
            steps.append([])
        else:
            steps[-1].append(node)
    found = []
    for number, inside in enumerate(steps):
        onward = _Exit(number + 1 if number + 1 < len(steps) else -1)
        jump = jumps.get(number)
        if jump is None:
            found.append(_Step(inside, line, [onward]))
            continue
        target = _Exit(at.get(str(jump.target), -1), jump.comment)
        exits = [target] if jump.condition is None else [target, onward]
        found.append(_Step(inside, jump.line, exits, jump.condition))
    return found


def _joined(steps: list[_Step]) -> tuple[int, list[_Step]]:
    """(the first one, the steps that are reached), without empty ones, each as long as its end leads to it alone."""
    for step in steps:
        for one in step.exits:
            _pass_empty(one, steps)
    empty = not steps[0].nodes and len(steps[0].exits) == 1 and not steps[0].exits[0].comment
    entry = steps[0].exits[0].to if empty and steps[0].exits[0].to >= 0 else 0
    kept = [entry]
    sources: dict[int, int] = {entry: 1}  # step -> from how many places it is reached
    for number in kept:
        for one in steps[number].exits:
            sources[one.to] = sources.get(one.to, 0) + 1
            if one.to >= 0 and one.to not in kept:
                kept.append(one.to)
    gone: set[int] = set()
    for number in sorted(kept):
        step = steps[number]
        while (
            number not in gone and len(step.exits) == 1 and sources[to := step.exits[0].to] == 1 and to >= 0
        ):
            said = step.exits[0].comment
            step.nodes += [st.Comment(step.line, said)] if said else []
            step.nodes += steps[to].nodes
            step.line, step.exits, step.condition = steps[to].line, steps[to].exits, steps[to].condition
            gone.add(to)
    numbers = {number: at for at, number in enumerate(sorted(set(kept) - gone))}
    for number in numbers:
        steps[number].exits = [replace(one, to=numbers.get(one.to, -1)) for one in steps[number].exits]
    return numbers[entry], [steps[number] for number in numbers]


def _pass_empty(one: _Exit, steps: list[_Step]) -> None:
    """Leads an exit past steps that only lead on, as long as no comment is lost."""
    for _ in steps:  # an endless loop of empty steps stays one
        empty = steps[one.to] if one.to >= 0 else None
        if empty is None or empty.nodes or len(empty.exits) != 1:
            return
        if one.comment and empty.exits[0].comment:
            return
        one.to, one.comment = empty.exits[0].to, one.comment or empty.exits[0].comment


def _next(counter: Named, step: _Step) -> list[Node]:
    chosen: list[list[Node]] = [
        [st.Assign(step.line, counter, Number(one.to), one.comment)] for one in step.exits
    ]
    if step.condition is None:
        return chosen[0]
    branches: list[tuple[st.Statement, list[Node]]] = [
        (st.If(step.line, step.condition), chosen[0]),
        (st.Else(step.line), chosen[1]),
    ]
    return [Block(branches, st.EndIf(step.line))]
