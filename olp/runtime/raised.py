"""What a handler of errors does about one error: in the place of a statement that raises it, and in translations.

A program raises errors of its own, `RAISE ERR_GRIP;`: the handler of the routine runs, and says where to go on. In a
plan and in a translation what it does stands in the place of that statement. Where the handler repeats the statement,
or raises the error once more for a caller, the statement stays as it is.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from itertools import count
from typing import Any, Final

from olp.ir import program as st
from olp.ir.block_structure import Block, Node, flat, parse
from olp.ir.expressions import Compare, Expression, Logic, Named, Text, Unary
from olp.ir.transformer import expressions_of
from olp.languages.vendor import ErrorHandling, conventions_of

HANDLES: Final = "ERROR"  # the handler of all errors, of `Disabled.handler`
_OWN_TYPE: Final = "errnum"


def own_errors(program: st.Program) -> frozenset[str]:
    """Errors that the program declares, case folded."""
    data = (*program.data, *(s for s in program.statements() if isinstance(s, st.Declare)))
    return frozenset(d.name.casefold() for d in data if _OWN_TYPE in (d.type, d.native))


def with_raised(program: st.Program, routine: st.Routine, own: frozenset[str] | None = None) -> st.Routine:
    """The routine with what its handler does in the place of the statements that raise its own errors."""
    known = conventions_of(program.vendor).errors
    if known is None or not any(isinstance(s, st.Process) and s.name == known.raises for s in routine.body):
        return routine
    answers = raised_answers(routine, known, own_errors(program) if own is None else own)
    if not answers:
        return routine
    labels = {s.name for s in routine.body if isinstance(s, st.Label)}
    rows: list[st.Statement] = []
    for s in routine.body:
        answer = answers.get(error_of(s, known))
        rows += [s] if answer is None else _inline(s, answer, known, labels)
    return replace(routine, body=tuple(rows))


def raised_answers(routine: st.Routine, known: ErrorHandling, own: frozenset[str]) -> dict[str, Answer]:
    """What the routine's own handler does about the program's errors that the routine raises itself."""
    found: dict[str, Answer] = {}
    for error in {error_of(s, known) for s in routine.body} & own:
        answer = answer_to(error, routine, known, own)
        if answer is not None and not any(
            isinstance(s, st.Process) and s.name == known.again for s in flat(answer.nodes)
        ):
            found[error] = answer
    return found


def error_of(s: st.Statement, known: ErrorHandling) -> str:
    """The error that a statement raises, case folded; "" for any other statement."""
    if not isinstance(s, st.Process) or s.name != known.raises:
        return ""
    text = next((value.value for _, value in s.arguments if isinstance(value, Text)), "")
    return text.casefold()


def _inline(s: st.Statement, answer: Answer, known: ErrorHandling, labels: set[str]) -> list[st.Statement]:
    """What a handler does in the place of the statement that raises its error."""
    onward = new_label(labels, "onward")
    rows = answer.rows(known, "", onward)
    if not any(isinstance(one, st.Jump) and one.target == onward for one in rows):
        return rows
    labels.add(onward)
    return [*rows, st.Label(s.line, onward)]


# --- the way of one error through a handler ---------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class Answer:
    """What a handler does where a statement has failed."""

    nodes: tuple[Node, ...]

    def rows(self, known: ErrorHandling, again: str, onward: str) -> list[st.Statement]:
        """The statements, with jumps to where the program repeats the statement or goes on behind it."""
        ends = {known.again: again, known.onward: onward}
        return [
            st.Jump(one.line, ends[one.name]) if isinstance(one, st.Process) else one
            for one in flat(_without_last(self.nodes, known.onward))
        ]


def answer_to(error: str, routine: st.Routine, known: ErrorHandling, own: frozenset[str]) -> Answer | None:
    """What the routine's own handler does about an error; None where it has none, or that cannot be said."""
    rows = [s for s in routine.body if isinstance(s, st.Disabled) and s.handler]
    if not rows or any(s.handler != HANDLES for s in rows):
        return None
    nodes = parse(statements_of(rows))
    done = None if nodes is None else _to_its_end(ErrorPath(known, own, error).through(nodes), known)
    if not done or not all(_can_be_said(s, known) for s in flat(done)):
        return None
    return Answer(tuple(done))


def _to_its_end(nodes: Sequence[Node], known: ErrorHandling) -> list[Node] | None:
    """The statements up to where the handler retries, goes on, or leaves the routine; None where it does neither."""
    for place, node in enumerate(nodes):
        if _ends(node, known):
            return list(nodes[: place + 1])
    return None


def _ends(node: Node, known: ErrorHandling) -> bool:
    if isinstance(node, Block):
        wholes: dict[type, type] = {st.If: st.Else, st.Switch: st.Default}
        whole = wholes.get(type(node.opener))
        markers = [type(marker) for marker, _ in node.branches]
        inside = [nodes for m, nodes in node.branches if not isinstance(m, st.Switch)]
        return whole in markers and all(any(_ends(one, known) for one in nodes) for nodes in inside)
    if isinstance(node, st.Return):
        return node.condition is None
    return isinstance(node, st.Process) and node.name in (known.again, known.onward)


def _can_be_said(s: st.Statement, known: ErrorHandling) -> bool:
    """Whether a handler's statement means the same behind the statement that fails."""
    if isinstance(s, st.Process):
        return s.name in (known.again, known.onward)
    return not isinstance(s, (st.Opaque, st.Label, st.Jump)) and not any(
        isinstance(e, Named) and e.name.casefold() == known.number for e in expressions_of(s)
    )


def statements_of(rows: Iterable[st.Disabled]) -> list[st.Statement]:
    """What the rows of a handler mean, in the lines of these rows: another file's have moved."""
    return [_in_line(one, row.line) for row in rows for one in row.means]


def _in_line(s: Any, line: int) -> Any:
    return replace(s, line=line)


def new_label(taken: Iterable[str], stem: str) -> str:
    return next(name for name in (f"{stem}{n}" for n in count(1)) if name not in taken)


@dataclass(frozen=True, slots=True)
class ErrorPath:
    """One error on its way through a handler. `own`: errors that the program declares; `error`: case folded."""

    known: ErrorHandling
    own: frozenset[str]
    error: str

    def through(self, nodes: Iterable[Node]) -> list[Node]:
        """The statements of a handler that run for the error: branches for other errors are removed."""
        found: list[Node] = []
        for node in nodes:
            if not isinstance(node, Block):
                found.append(node)
            elif isinstance(node.opener, st.Switch) and self._holds_error(node.opener.value):
                found += self._case(node)
            else:
                found += self._branches(node)
        return found

    def _holds_error(self, e: Expression) -> bool:
        return isinstance(e, Named) and e.name.casefold() == self.known.number

    def _is_named(self, e: Expression) -> bool | None:
        """Whether it is this error; None for what is no name of an error."""
        name = e.name.casefold() if isinstance(e, Named) else ""
        is_error = name in self.own or self.known.names.fullmatch(name)
        return name == self.error if is_error else None

    def _case(self, block: Block) -> list[Node]:
        """The block of a choice that the error selects."""
        other: list[Node] = []
        for marker, inside in block.branches[1:]:
            if isinstance(marker, st.Default):
                other = inside
                continue
            asked = [self._is_named(value) for value in getattr(marker, "values", ())]
            if None in asked:
                return [Block([(m, self.through(nodes)) for m, nodes in block.branches], block.closer)]
            if True in asked:
                return self.through(inside)
        return self.through(other)

    def _branches(self, block: Block) -> list[Node]:
        """A block without the branches that do not run; of a single branch that runs, only its content."""
        branches: list[tuple[st.Statement, list[Node]]] = []
        for marker, inside in block.branches:
            holds = self._decided(marker.condition) if isinstance(marker, (st.If, st.ElseIf)) else None
            if holds is False:
                continue
            done = self.through(inside)
            if not branches and (holds or isinstance(marker, st.Else)):
                return done
            if not branches and isinstance(marker, st.ElseIf):
                marker = st.If(marker.line, marker.condition, marker.comment)
            branches.append((st.Else(marker.line) if holds else marker, done))
            if holds:
                break
        return [Block(branches, block.closer)] if branches else []

    def _decided(self, e: Expression) -> bool | None:
        """Whether a condition holds; None where that depends on more than the error."""
        match e:
            case Compare("=" | "<>" as operator, left, right) if self._holds_error(left):
                named = self._is_named(right)
                return None if named is None else named == (operator == "=")
            case Compare("=" | "<>" as operator, left, right) if self._holds_error(right):
                return self._decided(Compare(operator, right, left))
            case Unary("not", operand):
                inner = self._decided(operand)
                return None if inner is None else not inner
            case Logic(first, rest):
                value = self._decided(first)
                for word, part in rest:
                    value = _joined(word == "or", value, self._decided(part))
                return value
        return None


def _joined(wins: bool, one: bool | None, other: bool | None) -> bool | None:
    """Two conditions by "or" (`wins` True: one that holds decides) or "and" (False)."""
    if wins in (one, other):
        return wins
    return None if None in (one, other) else not wins


def _without_last(nodes: Sequence[Node], name: str) -> list[Node]:
    """The statements without a last process instruction, behind which execution goes on in the same way."""
    if not nodes:
        return []
    *before, last = nodes
    if isinstance(last, st.Process) and last.name == name:
        return before
    if isinstance(last, Block) and not last.is_loop:
        branches = [(marker, _without_last(inside, name)) for marker, inside in last.branches]
        branches = [
            (marker, inside) for marker, inside in branches if inside or not isinstance(marker, st.Else)
        ]
        return [*before, Block(branches, last.closer)]
    return list(nodes)
