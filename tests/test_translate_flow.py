"""Control flow in another form runs the same statements in the same order: both are interpreted and compared."""

import dataclasses

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from olp.core.source import decode
from olp.ir.block_structure import parse
from olp.ir.expressions import Compare, Logic, Number, Quantity, Store, Variable
from olp.ir.points import PointTable
from olp.ir.program import (
    Assign,
    Begin,
    Break,
    Case,
    Continue,
    Default,
    Dwell,
    Else,
    ElseIf,
    End,
    EndIf,
    EndSwitch,
    EndWhile,
    For,
    If,
    Jump,
    Label,
    Next,
    Program,
    Repeat,
    Routine,
    Switch,
    Until,
    Update,
    While,
)
from olp.languages.limits import limits_of
from olp.runtime.interpreter import run
from olp.transpile.context import Context, TranslationContext
from olp.transpile.control_flow import flow

FUEL = Variable(Store.INTEGER, Number(0))
FULL = 25  # passes of all jumps back together


def counter(number):
    return Variable(Store.INTEGER, Number(number))


def program_of(body):
    rows = [Begin(0), *body, End(0)]
    stamped = tuple(dataclasses.replace(s, line=n) for n, s in enumerate(rows, 1))
    return Program("inform", decode(b"", "made.jbi", "cp1252"), (Routine("MADE", 1, stamped, PointTable()),))


def trace(program):
    """The durations of all waits in order: every wait has one of its own."""
    plan = run(program, max_steps=20_000)
    assert not plan.stop_reason, plan.stop_reason
    return plan.durations.tolist()


def lowered(program, **changes):
    limits = dataclasses.replace(limits_of("inform"), **changes)
    work = TranslationContext(program, "urscript", limits, Context(), lambda _: None)
    result = flow(program, work)
    assert not work.losses
    return result


NO_GOTO = {
    "has_goto": False,
    "has_repeat": False,
    "has_for": False,
    "has_switch": False,
    "has_continue": True,
    "has_break": True,
    "has_endless": True,
}
NO_BLOCKS = {
    "has_while": False,
    "has_repeat": False,
    "has_switch": False,
    "has_elseif": False,
    "has_break": False,
}
NO_REPEAT = {"has_repeat": False, "has_break": False, "has_endless": False}
TARGETS = {"no goto": NO_GOTO, "no blocks": NO_BLOCKS, "no repeat": NO_REPEAT}

# --- random programs ------------------------------------------------------------------------------------

CONDITIONS = st.builds(
    lambda n, operator, value: Compare(operator, counter(n), Number(value)),
    st.integers(1, 3),
    st.sampled_from(["=", "<>", "<", ">", "<=", ">="]),
    st.integers(0, 5),
)
UPDATES = st.builds(
    lambda n, value: Update(0, "+", counter(n), Number(value)), st.integers(1, 3), st.integers(-1, 3)
)
LABELS = st.sampled_from(["A", "B", "C", "D"])


def guarded(condition):
    """Holds a limited number of times in all, so that every program ends."""
    return Logic(Compare("<", FUEL, Number(FULL)), (("and", condition),))


@st.composite
def blocks(draw, depth, in_loop):
    rows = []
    for _ in range(draw(st.integers(1, 4))):
        kind = draw(st.sampled_from(KINDS if depth else SIMPLE))
        rows += draw(one(kind, depth, in_loop))
    return rows


SIMPLE = ["dwell", "dwell", "update", "jump", "label", "exit"]
KINDS = [*SIMPLE, "if", "if", "while", "for", "repeat", "switch"]
BURN = Update(0, "+", FUEL, Number(1))


@st.composite
def one(draw, kind, depth, in_loop):
    match kind:
        case "dwell":
            return [Dwell(0, Quantity(Number(0), 1.0))]
        case "update":
            return [draw(UPDATES)]
        case "label":
            return [Label(0, draw(LABELS))]
        case "jump":
            return [BURN, Jump(0, draw(LABELS), guarded(draw(CONDITIONS)))]
        case "exit":
            if not in_loop:
                return []
            leave = draw(st.sampled_from([Break(0), Continue(0)]))
            return [BURN, If(0, draw(CONDITIONS)), leave, EndIf(0)]
        case "if":
            rows = [If(0, draw(CONDITIONS)), *draw(blocks(depth - 1, in_loop))]
            for _ in range(draw(st.integers(0, 2))):
                rows += [ElseIf(0, draw(CONDITIONS)), *draw(blocks(depth - 1, in_loop))]
            if draw(st.booleans()):
                rows += [Else(0), *draw(blocks(depth - 1, in_loop))]
            return [*rows, EndIf(0)]
        case "while":
            inside = draw(blocks(depth - 1, True))
            return [While(0, guarded(draw(CONDITIONS))), BURN, *inside, EndWhile(0)]
        case "for":
            # Nobody says what a jump into a counting loop does: none of its labels stays within.
            inside = [s for s in draw(blocks(depth - 1, True)) if not isinstance(s, Label)]
            variable, start, stop = counter(10 + depth), draw(st.integers(0, 3)), draw(st.integers(0, 4))
            return [For(0, variable, Number(start), Number(stop)), BURN, *inside, Next(0, variable)]
        case "repeat":
            inside = draw(blocks(depth - 1, True))
            done = Logic(Compare(">=", FUEL, Number(FULL)), (("or", draw(CONDITIONS)),))
            return [Repeat(0), BURN, *inside, Until(0, done)]
        case _:
            rows = [Switch(0, counter(1))]
            for value in range(draw(st.integers(1, 3))):
                rows += [Case(0, (Number(value),)), *draw(blocks(depth - 1, in_loop))]
            if draw(st.booleans()):
                rows += [Default(0), *draw(blocks(depth - 1, in_loop))]
            return [*rows, EndSwitch(0)]


@st.composite
def programs(draw):
    rows = draw(blocks(2, False))
    known = {}
    kept = []
    for row in rows:  # every label once
        if isinstance(row, Label) and row.name in known:
            continue
        if isinstance(row, Label):
            known[row.name] = True
        kept.append(row)
    missing = {s.target for s in kept if isinstance(s, Jump)} - set(known)
    kept += [Label(0, name) for name in sorted(missing)]
    waits = iter(range(1, 1000))
    rows = [
        dataclasses.replace(s, duration=Quantity(Number(next(waits)), 0.001)) if isinstance(s, Dwell) else s
        for s in kept
    ]
    start = [Assign(0, counter(n), Number(draw(st.integers(0, 3)))) for n in range(1, 4)]
    return program_of([*start, Assign(0, FUEL, Number(0)), *rows, Dwell(0, Quantity(Number(7777), 0.001))])


@pytest.mark.parametrize("target", TARGETS)
@settings(max_examples=40, deadline=None, suppress_health_check=[HealthCheck.too_slow])
@given(data=st.data())
def test_a_random_program_with_jumps_runs_the_same_in_another_form(target, data):
    program = data.draw(programs())
    changed = lowered(program, **TARGETS[target])
    kinds = {type(s) for s in changed.routines[0].body}
    if target == "no goto":
        assert not kinds & {Label, Jump, Repeat, For, Switch}
    else:
        assert not kinds & {Repeat, Break, Continue}
    assert parse(changed.routines[0].body) is not None
    np.testing.assert_array_equal(trace(changed), trace(program))


# --- by hand --------------------------------------------------------------------------------------------


def wait(seconds):
    return Dwell(0, Quantity(Number(seconds), 1.0))


def fewer(value):
    return Compare("<", counter(1), Number(value))


@pytest.mark.parametrize("target", TARGETS)
def test_a_loop_that_is_jumped_into_asks_its_condition_where_it_did(target):
    one_more = Update(0, "+", counter(1), Number(1))
    loop = [While(0, fewer(3)), wait(0.1), Label(0, "IN"), wait(0.2), one_more, EndWhile(0)]
    program = program_of([Assign(0, counter(1), Number(0)), Jump(0, "IN"), *loop, wait(0.5)])
    changed = lowered(program, **TARGETS[target])
    # Entered behind the first wait; the counter is 1, 2 and 3 when the condition is asked.
    assert trace(changed) == [0.2, 0.1, 0.2, 0.1, 0.2, 0.5]


@pytest.mark.parametrize("target", TARGETS)
def test_a_loop_that_asks_at_its_end_runs_once_at_least_wherever_it_is_entered(target):
    one_more = Update(0, "+", counter(1), Number(1))
    loop = [
        Repeat(0),
        wait(0.1),
        Label(0, "IN"),
        wait(0.2),
        one_more,
        Until(0, Compare(">=", counter(1), Number(2))),
    ]
    entered = program_of([Assign(0, counter(1), Number(5)), Jump(0, "IN"), *loop, wait(0.5)])
    assert trace(lowered(entered, **TARGETS[target])) == [0.2, 0.5]
    begun = program_of([Assign(0, counter(1), Number(0)), *loop, wait(0.5)])
    assert trace(lowered(begun, **TARGETS[target])) == [0.1, 0.2, 0.1, 0.2, 0.5]
