"""Control flow in the target's own words: blocks for jumps where it has no GOTO, jumps for blocks that it lacks."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any, Final

from olp.ir import program as st
from olp.ir.block_structure import LOOPS, Block, Node, flat, negated, parse
from olp.ir.expressions import (
    Binary,
    Compare,
    Expression,
    Item,
    Logic,
    Named,
    Number,
    SignalState,
    Text,
    Variable,
)
from olp.ir.transformer import expressions_of
from olp.transpile.context import Fate, TranslationContext
from olp.transpile.integer_inference import WholeValues, counts_fractions
from olp.transpile.name_types import reached_from
from olp.transpile.structuring import flattened, machine, needs_flattening, structured
from olp.transpile.symbols import Symbols, kind_of_value

_CONDITIONAL: Final = (st.Call, st.Return, st.Pause, st.PulseOutput, st.StartTask)


def flow(program: st.Program, work: TranslationContext) -> st.Program:
    """Every routine with the blocks and jumps that the target has."""
    shared: list[st.Declare] = []  # where variables have numbers, none is a routine's own
    counters = _Counters(work.source, program)
    routines = tuple([_routine(routine, work, shared, counters) for routine in program.routines])
    return replace(program, routines=routines, data=(*program.data, *shared))


def calls_without_return(program: st.Program, work: TranslationContext) -> st.Program:
    """Calls that do not come back (INFORM's JUMP JOB) become a call and a return; those of the same routine, a jump.

    Where routines call each other in this way, the calls would nest ever deeper.
    """
    found = [s for s in work.rare(program) if isinstance(s, st.Call) and s.jump]
    if not found:
        return program
    routines = {r.name.casefold(): r for r in program.routines}
    return replace(program, routines=tuple(_coming_back(r, routines, work) for r in program.routines))


def _coming_back(
    routine: st.Routine, routines: Mapping[str, st.Routine], work: TranslationContext
) -> st.Routine:
    own, top = routine.name.casefold(), ""
    body: list[st.Statement] = []
    for s in routine.body:
        if not isinstance(s, st.Call) or not s.jump:
            body.append(s)
        elif s.routine.casefold() == own and not routine.parameters:
            top = top or work.fresh("begin")
            body.append(st.Jump(s.line, top, s.condition, comment=s.comment))
        elif own in {s.routine.casefold()} | reached_from(s.routine.casefold(), routines):
            says = (
                f"{s.routine} leads back to {routine.name}: calls in the place of jumps would go ever deeper"
            )
            work.lose(s, Fate.REFUSED, "call", says)
            body.append(s)
        else:
            rows: list[st.Statement] = [replace(s, jump=False, condition=None), st.Return(s.line)]
            if s.condition is not None:
                rows = [st.If(s.line, s.condition), *rows, st.EndIf(s.line)]
            body += rows
    if top:
        body.insert(1 if body and isinstance(body[0], st.Begin) else 0, st.Label(routine.line, top))
    return replace(routine, body=tuple(body))


@dataclass(slots=True)
class _Counters:
    """Which routines of a program name what its FOR loops count; found for all variables of a kind at once."""

    program: st.Program
    lowered: st.Program
    _named: dict[type, dict[Expression, set[str]]] = field(default_factory=dict)
    _whole: WholeValues | None = None

    def whole(self, work: TranslationContext) -> WholeValues:
        """Which of its values are whole numbers."""
        if self._whole is None:
            self._whole = WholeValues(self.lowered, work.registers)
        return self._whole

    def named_in(self, variable: Expression) -> set[str]:
        """The routines that name a loop's variable."""
        kind = type(variable)
        if kind not in self._named:
            found: dict[Expression, set[str]] = {}
            for routine in self.program.routines:
                for s in routine.body:
                    for e in expressions_of(s):
                        if type(e) is kind:
                            found.setdefault(e, set()).add(routine.name)
            self._named[kind] = found
        return self._named[kind].get(variable, set())


def _routine(
    routine: st.Routine, work: TranslationContext, shared: list[st.Declare], counters: _Counters
) -> st.Routine:
    body = routine.body
    kinds = set(map(type, body))
    if not work.limits.conditional_statements and not kinds.isdisjoint(_CONDITIONAL):
        body = tuple(s for statement in body for s in _unconditional(statement))
    if any(isinstance(s, st.Jump) and not isinstance(s.target, str) for s in body):
        symbols = work.symbols(counters.lowered)
        body = tuple(
            s for statement in body for s in _uncomputed(statement, body, routine.name, work, symbols)
        )
    nodes = parse(body)
    if nodes is None:
        work.lose(routine.line, Fate.REFUSED, "blocks", f"the blocks of {routine.name} are not closed")
        return routine
    target = _Target(work, routine, counters, {s.name for s in body if isinstance(s, st.Label)})
    if needs_flattening(nodes):
        nodes = flattened(nodes, target.label)
    if not work.limits.has_goto and any(isinstance(s, (st.Label, st.Jump)) for s in flat(nodes)):
        nodes = structured(nodes)
        if any(isinstance(s, (st.Label, st.Jump)) for s in flat(nodes)):
            counter = target.variable("step", "integer")
            nodes = machine(flattened(nodes, target.label, jumping=True), counter)
    nodes = target.lowered(nodes, None)
    rows = list(flat(nodes))
    if work.limits.numbered:
        shared += [replace(one, value=None, shared=True) for one in target.declared]
    else:
        rows[1 if rows and isinstance(rows[0], st.Begin) else 0 : 0] = target.declared
    return replace(routine, body=tuple(rows))


def _unconditional(s: st.Statement) -> list[st.Statement]:
    """A statement with a condition of its own as a block."""
    condition = getattr(s, "condition", None)
    if not isinstance(s, _CONDITIONAL) or condition is None:
        return [s]
    inside: Any = replace(s, condition=None)
    return [st.If(s.line, condition), inside, st.EndIf(s.line)]


def _uncomputed(
    s: st.Statement, body: tuple[st.Statement, ...], routine: str, work: TranslationContext, symbols: Symbols
) -> list[st.Statement]:
    """A jump to a computed label as a choice between all labels that it can lead to."""
    if not isinstance(s, st.Jump) or isinstance(s.target, str):
        return [s]
    rows: list[st.Statement] = [] if s.condition is None else [st.If(s.line, s.condition)]
    value = s.target
    holds = _holds(value, routine, symbols)
    first = True
    for label in (s for s in body if isinstance(s, st.Label)):
        known = _label_value(label.name, holds)
        if known is None:
            continue
        test = Compare("=", value, known)
        rows.append(st.If(s.line, test) if first else st.ElseIf(s.line, test))
        rows.append(st.Jump(s.line, label.name))
        first = False
    if first:
        work.lose(s, Fate.REFUSED, "label", "a computed jump that no label answers")
        return []
    # Without such a label the source's controller stops the program with an alarm.
    rows += [st.Else(s.line), st.Pause(s.line), st.EndIf(s.line)]
    return rows if s.condition is None else [*rows, st.EndIf(s.line)]


def _label_value(label: str, holds: str) -> Expression | None:
    """What a variable of a type holds that chooses a label; None of a label that no number chooses."""
    if holds == "string":
        return Text(label)
    if label.isdecimal():
        return Number(int(label))
    return None if holds else Text(label)


def _holds(value: Expression, routine: str, symbols: Symbols) -> str:
    """The type of what chooses a label, "" where nothing tells it."""
    base = value.base if isinstance(value, Item) else value
    if isinstance(base, Variable):
        return base.store.value
    symbol = symbols.find(routine, base.name) if isinstance(base, Named) else None
    return "" if symbol is None else symbol.type


@dataclass(slots=True)
class _Loop:
    """Where Break and Continue of the innermost loop go, once something asks for it."""

    leave: str = ""
    again: str = ""
    before_again: list[st.Statement] = field(default_factory=list)  # what a Continue has to do first
    keeps_break: bool = True
    keeps_continue: bool = True


@dataclass(slots=True)
class _Target:
    work: TranslationContext
    routine: st.Routine
    counters: _Counters
    labels: set[str]
    read_outside: dict[Expression, bool] = field(default_factory=dict)  # by variable, see _is_read_outside
    declared: list[st.Declare] = field(default_factory=list)

    def label(self) -> str:
        count = len(self.labels) + 1
        while f"L{count}" in self.labels:
            count += 1
        self.labels.add(f"L{count}")
        return f"L{count}"

    def variable(self, stem: str, kind: str) -> Named:
        name = Named(self.work.helper(stem))
        self.declared.append(st.Declare(0, name.name, kind, Text("") if kind == "string" else Number(0)))
        return name

    def lowered(self, nodes: list[Node], loop: _Loop | None) -> list[Node]:
        result: list[Node] = []
        for node in nodes:
            if isinstance(node, Block):
                result += self._block(node, loop)
            elif isinstance(node, st.Break) and loop is not None and not loop.keeps_break:
                loop.leave = loop.leave or self.label()
                result.append(st.Jump(node.line, loop.leave, comment=node.comment))
            elif isinstance(node, st.Continue) and loop is not None:
                result += self._continue(node, loop)
            else:
                result.append(node)
        return result

    def _continue(self, s: st.Continue, loop: _Loop) -> list[Node]:
        if loop.keeps_continue:
            return [*loop.before_again, s]
        loop.again = loop.again or self.label()
        return [st.Jump(s.line, loop.again, comment=s.comment)]

    def _block(self, block: Block, loop: _Loop | None) -> list[Node]:
        match block.opener:
            case st.If():
                return self._if(block, loop)
            case st.Switch():
                return self._switch(block, loop)
            case st.While():
                return self._while(block)
            case st.For():
                return self._for(block)
            case _:
                return self._repeat(block)

    # --- branches ---------------------------------------------------------------------------------------

    def _if(self, block: Block, loop: _Loop | None) -> list[Node]:
        branches = [(marker, self.lowered(inside, loop)) for marker, inside in block.branches]
        if self.work.limits.has_elseif or not any(isinstance(m, st.ElseIf) for m, _ in branches):
            return [Block(branches, block.closer)]
        if len(branches) > self.work.limits.deepest_if:
            return self._in_a_row(branches, block.closer)
        return [_nested(branches, block.closer)]

    def _in_a_row(self, branches: list[tuple[st.Statement, list[Node]]], closer: st.Statement) -> list[Node]:
        """More branches than blocks may stand within one another: each jumps behind the last one."""
        end, rows = self.label(), []
        for marker, inside in branches:
            if isinstance(marker, (st.If, st.ElseIf)):
                opener = st.If(marker.line, marker.condition, marker.comment)
                rows.append(Block([(opener, [*inside, st.Jump(marker.line, end)])], st.EndIf(marker.line)))
            else:
                rows += [*_comment_of(marker), *inside]
        return [*rows, *_comment_of(closer), st.Label(closer.line, end)]

    def _switch(self, block: Block, loop: _Loop | None) -> list[Node]:
        limits = self.work.limits
        values = [value for m, _ in block.branches if isinstance(m, st.Case) for value in m.values]
        of_texts = any(isinstance(value, Text) and value.value[:1] != "#" for value in values)
        fractions = any(isinstance(one, Number) and not float(one.value).is_integer() for one in values)
        has_switch = limits.has_switch and not (limits.texts_by_statement and of_texts)
        has_switch = has_switch and not (limits.integer_type and fractions)
        if has_switch and all(isinstance(value, (Number, Text)) for value in values):
            return [Block([(m, self.lowered(inside, loop)) for m, inside in block.branches], block.closer)]
        switch = block.opener
        assert isinstance(switch, st.Switch)
        before: list[Node] = []
        value = switch.value
        if not isinstance(value, (Named, Number)):
            kind_of_choice = "string" if of_texts else "real" if fractions else "integer"
            name = self.variable("choice", kind_of_choice)
            before.append(st.Assign(switch.line, name, value, switch.comment))
            value = name
        else:
            before += _comment_of(switch)
        before += [s for s in block.branches[0][1] if isinstance(s, st.Comment)]
        branches: list[tuple[st.Statement, list[Node]]] = []
        for marker, inside in block.branches[1:]:
            if isinstance(marker, st.Case):
                test = _any_of(value, marker.values)
                kind = st.ElseIf if branches else st.If
                branches.append((kind(marker.line, test, marker.comment), inside))
        default = next((pair for pair in block.branches[1:] if isinstance(pair[0], st.Default)), None)
        end = st.EndIf(block.closer.line, getattr(block.closer, "comment", ""))
        if not branches:
            inside = self.lowered(default[1], loop) if default else []
            return [*before, *(_comment_of(default[0]) if default else []), *inside, *_comment_of(end)]
        if default is not None:
            branches.append((st.Else(default[0].line, getattr(default[0], "comment", "")), default[1]))
        return [*before, *self._if(Block(branches, end), loop)]

    # --- loops ------------------------------------------------------------------------------------------

    def _inside(
        self, block: Block, before_again: list[st.Statement] | None = None, jumps: bool = False
    ) -> tuple[_Loop, list[Node]]:
        limits = self.work.limits
        loop = _Loop(
            before_again=before_again or [],
            keeps_break=limits.has_break and not jumps,
            keeps_continue=limits.has_continue and not jumps,
        )
        inside = self.lowered(block.branches[0][1], loop)
        if loop.again:
            inside.append(st.Label(block.closer.line, loop.again))
        return loop, inside

    def _while(self, block: Block) -> list[Node]:
        head, closer = block.opener, block.closer
        assert isinstance(head, st.While)
        endless = head.condition == SignalState(True)
        if self.work.limits.has_while and (self.work.limits.has_endless or not endless):
            loop, inside = self._inside(block)
            return [Block([(head, inside)], closer), *self._end(loop, closer)]
        start = self.label()
        loop, inside = self._inside(block, jumps=True)
        if not endless:
            loop.leave = loop.leave or self.label()
        test: list[Node] = [] if endless else [st.Jump(head.line, loop.leave, negated(head.condition))]
        first: list[Node] = [st.Label(head.line, start, head.comment), *test]
        back = st.Jump(closer.line, start, comment=getattr(closer, "comment", ""))
        return [*first, *inside, back, *self._end(loop, closer)]

    def _end(self, loop: _Loop, closer: st.Statement) -> list[Node]:
        return [st.Label(closer.line, loop.leave)] if loop.leave else []

    def _repeat(self, block: Block) -> list[Node]:
        limits, head, until = self.work.limits, block.opener, block.closer
        assert isinstance(until, st.Until)
        comment = getattr(head, "comment", "")
        if limits.has_repeat:
            loop, inside = self._inside(block)
            return [Block([(head, inside)], until), *self._end(loop, until)]
        within = block.branches[0][1]
        if limits.has_goto and limits.has_while and all(isinstance(node, st.Comment) for node in within):
            # Nothing happens in it: asked before or behind is the same.
            waits = st.While(head.line, negated(until.condition), comment)
            return [Block([(waits, within)], st.EndWhile(until.line, until.comment))]
        if limits.has_goto:
            start = self.label()
            loop, inside = self._inside(block, jumps=True)
            back = st.Jump(until.line, start, negated(until.condition), until.comment)
            return [st.Label(head.line, start, comment), *inside, back, *self._end(loop, until)]
        leave: list[st.Statement] = [
            st.If(until.line, until.condition),
            st.Break(until.line),
            st.EndIf(until.line),
        ]
        loop, inside = self._inside(block, leave)
        test = Block([(leave[0], [leave[1]])], leave[2])
        head = st.While(head.line, SignalState(True), comment)
        return [Block([(head, [*inside, test])], st.EndWhile(until.line, until.comment))]

    def _for(self, block: Block) -> list[Node]:
        limits, head, closer = self.work.limits, block.opener, block.closer
        assert isinstance(head, st.For)
        step_fits = not limits.for_step_is_one or head.step in (None, Number(1), Number(-1))
        step_fits = step_fits and not (limits.for_counts_whole and self._counts_fractions(head))
        step_fits = step_fits and not (limits.for_bounds_whole and self._is_between_whole(head))
        there, keeps_last = self.work.target_conventions, self.work.conventions.for_keeps_last
        other_end = there.for_declares or there.for_keeps_last is not keeps_last
        changed = _names_changed(block)
        counts = there.for_declares and getattr(head.variable, "name", "") in changed  # there it is only read
        before: list[Node] = []
        if limits.has_for and step_fits and not counts and not (other_end and self._is_used_outside(head)):
            if not there.for_declares:  # nothing says whether others look at their bounds again
                head = self._with_own_bounds(head, changed, before)
            loop, inside = self._inside(block)
            if isinstance(closer, st.Next):
                closer = replace(closer, variable=head.variable)
            return [*before, Block([(head, inside)], closer), *self._end(loop, closer)]
        start = self._kept(head.start, before, head.line) if keeps_last else head.start
        before.append(st.Assign(head.line, head.variable, start, head.comment))
        stop = self._kept(head.stop, before, head.line)
        step = self._kept(head.step or Number(1), before, head.line)
        last = self._last(head, start, stop, step) if keeps_last and self._is_used_outside(head) else []
        count: st.Statement = st.Assign(closer.line, head.variable, Binary("+", head.variable, step))
        as_while = Block(
            [(st.While(head.line, _not_beyond(head.variable, stop, step)), block.branches[0][1])],
            st.EndWhile(closer.line, getattr(closer, "comment", "")),
        )
        if limits.has_continue or not limits.has_goto:
            loop, inside = self._inside(as_while, [count])
            again: list[Node] = [Block([(as_while.opener, [*inside, count])], as_while.closer)]
            return [*before, *again, *last, *self._end(loop, closer)]
        # A Continue jumps to the label before the count.
        loop, inside = self._inside(as_while, jumps=not limits.has_while)
        counted = Block([(as_while.opener, [*inside, count])], as_while.closer)
        return [*before, *self._while_of(counted), *last, *self._end(loop, closer)]

    def _is_between_whole(self, head: st.For) -> bool:
        """Whether a loop may begin or end at a fraction, or at a whole number of a type that holds fractions."""
        if counts_fractions(head):
            return True
        whole = self.counters.whole(self.work)
        return not all(whole.holds(self.routine.name, e) for e in (head.start, head.stop))

    def _counts_fractions(self, head: st.For) -> bool:
        """Whether a loop's variable may hold fractions; where its type is still to be found, what is written tells."""
        if self.work.limits.integer_type:
            return counts_fractions(head)
        kind = kind_of_value(self.work.symbols(self.counters.lowered), self.routine.name, head.variable)
        return kind == "real" or counts_fractions(head)

    def _with_own_bounds(self, head: st.For, changed: frozenset[str], before: list[Node]) -> st.For:
        """Bounds that the loop itself changes, as they were when it began."""
        if not changed.isdisjoint(_named_in(head.stop)):
            head = replace(head, stop=self._kept(head.stop, before, head.line))
        if head.step is not None and not changed.isdisjoint(_named_in(head.step)):
            head = replace(head, step=self._kept(head.step, before, head.line))
        return head

    def _last(self, head: st.For, start: Expression, stop: Expression, step: Expression) -> list[Node]:
        """After a loop: sets its variable back to the last value, which it has there in the source."""
        back: Node = st.Assign(head.line, head.variable, Binary("-", head.variable, step))
        runs = _not_beyond(start, stop, step)
        if isinstance(start, Number) and isinstance(stop, Number) and isinstance(step, Number):
            return [back] if (stop.value - start.value) * step.value >= 0 else []
        return [Block([(st.If(head.line, runs), [back])], st.EndIf(head.line))]

    def _while_of(self, block: Block) -> list[Node]:
        """A while block whose body is already converted."""
        if self.work.limits.has_while:
            return [block]
        head = block.opener
        assert isinstance(head, st.While)
        start, leave = self.label(), self.label()
        return [
            st.Label(head.line, start),
            st.Jump(head.line, leave, negated(head.condition)),
            *block.branches[0][1],
            st.Jump(block.closer.line, start, comment=getattr(block.closer, "comment", "")),
            st.Label(block.closer.line, leave),
        ]

    def _kept(self, value: Expression, before: list[Node], line: int) -> Expression:
        """A copy of a bound, as it was when the loop began."""
        if isinstance(value, Number):
            return value
        kind = kind_of_value(self.work.symbols(self.counters.lowered), self.routine.name, value)
        name = self.variable("bound", "integer" if kind == "integer" else "real")
        before.append(st.Assign(line, name, value))
        return name

    def _is_used_outside(self, head: st.For) -> bool:
        """Whether the loop's variable is read or written outside of the loops that count it."""
        if head.variable not in self.read_outside:  # many loops of a routine count the same variable
            self.read_outside[head.variable] = self._is_read_outside(head.variable)
        if self.read_outside[head.variable]:
            return True
        local = any(
            isinstance(s, st.Declare) and s.name == getattr(head.variable, "name", "")
            for s in self.routine.body
        )
        # Routines that no file has may read what has a number.
        read = self.work.missing and getattr(head.variable, "name", "") in self.work.registers
        others = read or self.counters.named_in(head.variable) - {self.routine.name}
        return not local and bool(others)

    def _is_read_outside(self, variable: Expression) -> bool:
        """Whether statements of the routine itself name the variable outside of the loops that count it."""
        depth = 0
        for s in self.routine.body:
            if isinstance(s, st.For) and s.variable == variable:
                depth += 1
            elif isinstance(s, LOOPS):
                depth += depth > 0
            elif type(s).__name__ in ("EndWhile", "Next", "Until"):
                depth -= depth > 0
            elif depth == 0 and not isinstance(s, st.Declare) and variable in expressions_of(s):
                return True
        return False


def _named_in(value: object) -> set[str]:
    return {e.name for e in expressions_of(value) if isinstance(e, Named)}


def _names_changed(block: Block) -> frozenset[str]:
    """The variables that statements within a block set or count."""
    found: set[str] = set()
    rows: list[Node] = [*block.branches[0][1]]
    while rows:
        row = rows.pop()
        if isinstance(row, Block):
            rows += [node for marker, inside in row.branches for node in (marker, *inside)]
        elif isinstance(row, (st.Assign, st.Update)) and isinstance(row.target, Named):
            found.add(row.target.name)
    return frozenset(found)


def _not_beyond(variable: Expression, stop: Expression, step: Expression) -> Expression:
    up, down = Compare("<=", variable, stop), Compare(">=", variable, stop)
    if isinstance(step, Number):
        return up if step.value > 0 else down
    rising: Expression = Logic(Compare(">", step, Number(0)), (("and", up),))
    falling: Expression = Logic(Compare("<", step, Number(0)), (("and", down),))
    return Logic(rising, (("or", falling),))


def _any_of(value: Expression, values: tuple[Expression, ...]) -> Expression:
    tests = [Compare("=", value, one) for one in values]
    return tests[0] if len(tests) == 1 else Logic(tests[0], tuple(("or", test) for test in tests[1:]))


def _nested(branches: list[tuple[st.Statement, list[Node]]], closer: st.Statement) -> Block:
    """ElseIf as an If within an Else."""
    for at in range(len(branches) - 1, 0, -1):
        marker, inside = branches[at]
        if isinstance(marker, st.ElseIf):
            inner = Block(
                [(st.If(marker.line, marker.condition, marker.comment), inside), *branches[at + 1 :]],
                st.EndIf(closer.line),
            )
            branches = [*branches[:at], (st.Else(marker.line), [inner])]
    return Block(branches, closer)


def _comment_of(s: st.Statement) -> list[Node]:
    """The comment of a statement that is removed, on a line of its own."""
    text = getattr(s, "comment", "")
    return [st.Comment(s.line, text)] if text else []
