"""What a language cannot compute within a statement is computed before it: calls, functions, parts of conditions.

A loop whose condition needs such a computation becomes one that is left from within.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

from olp.ir.expressions import (
    Binary,
    CallValue,
    Expression,
    Function,
    Item,
    Member,
    Named,
    Number,
    Quantity,
    Signal,
    SignalState,
)
from olp.ir.program import (
    Assign,
    Break,
    Call,
    Dwell,
    Else,
    ElseIf,
    EndIf,
    EndWhile,
    For,
    If,
    Jump,
    Message,
    Move,
    Program,
    Routine,
    SetOutput,
    Statement,
    Switch,
    Until,
    Wait,
    While,
)
from olp.ir.transformer import calls_nothing, mapped
from olp.ir.tree import Block, Node, flat, negated, parse
from olp.transpile.context import TranslationContext
from olp.transpile.symbols import kind_of_value, symbols_of
from olp.transpile.temporary_values import Values, is_condition, is_number


def hoist(program: Program, work: TranslationContext) -> Program:
    """For INFORM and FANUC: expressions that they can write, all else computed into variables beforehand."""
    own = _Hoist(work, symbols_of(program))
    routines = tuple(own.routine_of(routine) for routine in program.routines)
    return replace(program, routines=routines, data=(*program.data, *own.declared))


@dataclass(slots=True)
class _Hoist(Values):
    """Statements, each behind what computes for it."""

    def routine_of(self, routine: Routine) -> Routine:
        self.routine = routine.name
        nodes = parse(routine.body)
        if nodes is None:
            return routine
        return replace(routine, body=tuple(flat(self.nodes(nodes))))

    # --- statements -------------------------------------------------------------------------------------

    def nodes(self, nodes: list[Node]) -> list[Node]:
        result: list[Node] = []
        for node in nodes:
            if calls_nothing(node) and _is_written_out(node):
                result.append(node)
                continue
            self.used.clear()
            if isinstance(node, Block):
                result += _stamped(self._block(node), node.opener.line)
            else:
                result += _stamped(self._statement(node), node.line)
        return result

    def _block(self, block: Block) -> list[Node]:
        head = block.opener
        if isinstance(head, If):
            return self._if(block)
        inside = [(marker, self.nodes(rows)) for marker, rows in block.branches]
        self.used.clear()
        before: list[Statement] = []
        if isinstance(head, While):
            condition = self.condition(head.condition, before)
            if not before:
                return [Block([(replace(head, condition=condition), inside[0][1])], block.closer)]
            leave = Block([(If(head.line, negated(condition)), [Break(head.line)])], EndIf(head.line))
            endless = While(head.line, SignalState(True), head.comment)
            return [Block([(endless, [*before, leave, *inside[0][1]])], EndWhile(block.closer.line))]
        if isinstance(block.closer, Until):
            condition = self.condition(block.closer.condition, before)
            return [Block([(head, [*inside[0][1], *before])], replace(block.closer, condition=condition))]
        if isinstance(head, Switch):
            value = self.value(head.value, before, alone=True)
            return [*before, Block([(replace(head, value=value), []), *inside[1:]], block.closer)]
        if isinstance(head, For):
            head = replace(
                head,
                start=self.value(head.start, before, alone=True),
                stop=self.value(head.stop, before, alone=True),
                step=None if head.step is None else self.value(head.step, before, alone=True),
            )
            return [*before, Block([(head, inside[0][1])], block.closer)]
        return [Block(inside, block.closer)]

    def _if(self, block: Block) -> list[Node]:
        head = block.opener
        assert isinstance(head, If)
        before: list[Statement] = []
        condition = self.condition(head.condition, before)
        branches: list[tuple[Statement, list[Node]]] = [
            (replace(head, condition=condition), self.nodes(block.branches[0][1]))
        ]
        for at, (marker, rows) in enumerate(block.branches[1:], 1):
            if isinstance(marker, ElseIf):
                self.used.clear()
                needed: list[Statement] = []
                condition = self.condition(marker.condition, needed)
                if needed:
                    # What the condition needs is computed only where the ones before did not hold.
                    inner = Block(
                        [(If(marker.line, marker.condition), rows), *block.branches[at + 1 :]],
                        EndIf(marker.line),
                    )
                    branches.append((Else(marker.line, marker.comment), self.nodes([inner])))
                    return [*before, Block(branches, block.closer)]
                branches.append((replace(marker, condition=condition), self.nodes(rows)))
            else:
                branches.append((marker, self.nodes(rows)))
        return [*before, Block(branches, block.closer)]

    def _statement(self, s: Statement) -> list[Node]:
        before: list[Statement] = []
        match s:
            case Assign():
                return [*before, *self._assign(s)]
            case SetOutput():
                return self._output(s)
            case Wait() | Jump() if s.condition is not None:
                condition = self.condition(s.condition, before)
                if before and isinstance(s, Wait):
                    return self._polled(s)
                return [*before, replace(s, condition=condition)]
            case Dwell() | Move():
                new = self._quantities(s, before)
                if isinstance(new, Move):
                    new = self._move(new, before)
                return [*before, new]
            case Call():
                arguments = tuple(self.value(a, before, alone=True) for a in s.arguments)
                return [*before, replace(s, arguments=arguments)]
            case Message():
                text = self.value(s.text, before, alone=True)  # first: it adds to what stands before
                return [*before, replace(s, text=text)]
            case _:
                return [s]

    def _move(self, s: Move, before: list[Statement]) -> Move:
        targets = tuple(self._position(t, before) for t in s.targets)
        via = None if s.via is None else self._position(s.via, before)
        if targets == s.targets and via == s.via:
            return s
        return replace(s, targets=targets, via=via)

    def _position(self, e: Expression, before: list[Statement]) -> Expression:
        """A computed position whose numbers the target can write."""
        if isinstance(e, CallValue):
            return self._called(e, before)
        if not isinstance(e, (Function, Item)):
            return e
        if isinstance(e, Item):
            return self._index(e, before)
        arguments = tuple(
            self._position(a, before) if self._is_position(a) else self.value(a, before) for a in e.arguments
        )
        return replace(e, arguments=arguments)

    def _polled(self, s: Wait) -> list[Node]:
        """A wait whose condition has to be computed anew each time."""
        before: list[Statement] = []
        self.used.clear()
        condition = self.condition(s.condition, before)
        leave = Block([(If(s.line, condition), [Break(s.line)])], EndIf(s.line))
        head = While(s.line, SignalState(True), s.comment)
        return [Block([(head, [*before, leave])], EndWhile(s.line))]

    def _assign(self, s: Assign) -> list[Node]:
        before: list[Statement] = []
        target = (
            mapped(s.target, lambda e: self._index(e, before))
            if isinstance(s.target, (Item, Member))
            else s.target
        )
        kind = kind_of_value(self.symbols, self.routine, target)
        value = s.value
        if is_condition(value) and not (isinstance(value, Signal) and not self.simple):
            if isinstance(value, Named):
                return [*before, replace(s, target=target)]
            return [*before, *self._as_flag(s.line, target, value, s.comment)]
        if isinstance(value, Function) and not self._is_position(value):
            value = self._function(value, before)
        elif self._is_position(value):
            value = self._position(value, before)
        else:
            value = self.value(value, before, whole=kind == "integer")
        return [*before, replace(s, target=target, value=value)]

    def _output(self, s: SetOutput) -> list[Node]:
        before: list[Statement] = []
        if (
            is_condition(s.value)
            and not isinstance(s.value, (SignalState, Named))
            and not is_number(s.signal.bus)
        ):
            if not self.simple:
                return [s]
            condition = self.condition(s.value, before)
            on: list[Node] = [replace(s, value=SignalState(True))]
            off: list[Node] = [replace(s, value=SignalState(False), comment="")]
            return [*before, Block([(If(s.line, condition), on), (Else(s.line), off)], EndIf(s.line))]
        value = self.value(s.value, before, alone=True)  # first: it adds to what stands before
        return [*before, replace(s, value=value)]

    def _quantities(self, s: Any, before: list[Statement]) -> Any:
        """Computed speeds, times and blends in variables, in the unit that a number of the target has there."""

        def change(node: Any) -> Any:
            if type(node) is not Quantity or isinstance(node.written, Number):
                return node
            scales = self.work.limits.variable_scales
            kind = "integer" if scales else "real"
            scale = scales.get(round(node.scale, 12), node.scale)
            if not scales and isinstance(node.written, Named):
                return node
            factor = node.scale / scale
            value = node.written if abs(factor - 1) < 1e-12 else Binary("*", node.written, Number(factor))
            target = self.temporary(kind)
            before.extend(flat(self._assign(Assign(s.line, target, value))))
            return Quantity(target, scale)

        changes: dict[str, Any] = {}
        for name in ("duration", "acceleration", "deceleration", "turn"):
            old = getattr(s, name, None)
            if old is not None and (new := change(old)) is not old:
                changes[name] = new
        for name in ("speed", "blend", "rate"):
            old = getattr(s, name, None)
            if old is not None and old.value is not None and (new := change(old.value)) is not old.value:
                changes[name] = old._replace(value=new)
        return replace(s, **changes) if changes else s


def _is_written_out(s: Any) -> bool:
    """Whether a move's speed and blend are numbers."""
    measured = [q.value for q in (s.speed, s.blend) if q is not None and q.value is not None]
    return all(type(value.written) is Number for value in measured)


def _stamped(nodes: list[Node], line: int) -> list[Node]:
    """Statements that stand for a part of another one, with its line."""
    result: list[Node] = []
    for node in nodes:
        if isinstance(node, Block):
            result.append(
                Block(
                    [(_at(m, line), _stamped(inside, line)) for m, inside in node.branches],
                    _at(node.closer, line),
                )
            )
        else:
            result.append(_at(node, line))
    return result


def _at(s: Any, line: int) -> Any:
    return s if s.line or not line else replace(s, line=line)
