"""RAPID's FOR declares its counter, which hides a variable of the same name (technical reference manual, FOR)."""

from __future__ import annotations

import pytest
from translated_texts import ROBOT, converted, krl, module, read, run_elsewhere, translated

from olp.core.source import decode
from olp.fluent import Program, read_source
from olp.runtime.interpreter import run
from olp.runtime.plan import StepKind
from olp.transpile import Context
from olp.transpile.context import Fate
from olp.transpile.convert import convert

# Behind the loops i is 7 again, and n is 40.
_PROGRAM = """MODULE Count
  VAR num n;
  PROC main()
    VAR num i:=7;
    n:=40;
    FOR i FROM 1 TO 2 DO
      WaitTime i/10;
    ENDFOR
    WaitTime i/10;
    FOR n FROM 3 TO i/2 DO
      WaitTime n/10;
    ENDFOR
    WaitTime n/10;
  ENDPROC
ENDMODULE
"""
_WAITS = [0.1, 0.2, 0.7, 0.3, 4.0]  # s


def waits(program: Program) -> list[float]:
    plan = program.plan()
    return [round(float(plan.durations[row]), 6) for row in plan.row[plan.kind == StepKind.WAIT]]


def test_a_loop_hides_the_variable_of_its_name() -> None:
    assert waits(read_source(decode(_PROGRAM.encode(), "Count.mod"))) == _WAITS


@pytest.mark.parametrize("target", ["krl", "tp", "inform", "urscript"])
def test_a_translated_loop_leaves_that_variable_alone(target: str) -> None:
    made = convert(read_source(decode(_PROGRAM.encode(), "Count.mod")), target, Context(on_loss="comment"))
    assert not [loss for loss in made.translated.losses if loss.leaves_out]
    assert waits(read_source(decode(made.files[made.main], made.main), vendor=target)) == _WAITS


def test_a_counter_whose_variable_does_nothing_else_keeps_its_name() -> None:
    text = _PROGRAM.replace("    WaitTime i/10;\n    FOR n", "    FOR n").replace("i/2", "3")
    made = convert(read_source(decode(text.encode(), "Count.mod")), "krl", Context())
    written = made.files[made.main].decode()
    assert "INT i\r\n" in written
    assert "FOR i=1 TO 2" in written


@pytest.mark.parametrize("target", ["krl", "tp", "inform", "urscript"])
def test_a_loop_without_a_step_counts_down_where_it_ends_below_its_begin(target):
    rows = (
        "FOR i FROM 3 TO 1 DO",
        "SetAO ao1,i;",
        "ENDFOR",
        "FOR i FROM 3 TO 1 STEP 1 DO",
        "SetAO ao1,i;",
        "ENDFOR",
    )
    plan = run(read(module(*rows), "rapid"), ROBOT)
    there = run_elsewhere(module(*rows), "rapid", target)
    for one in (plan, there):
        assert [event.value for _, event in sorted(one.events.items())] == [3, 2, 1]


def test_a_loop_whose_direction_nobody_knows_is_told():
    rows = ("FOR i FROM 1 TO n DO", "SetAO ao1,i;", "ENDFOR", "n:=n-1;")
    losses = converted(module(*rows, data=("VAR num n:=3;",)), "rapid", "krl").translated.losses
    assert [(one.line, one.fate) for one in losses if one.part == "step"] == [(4, Fate.APPROXIMATED)]
    rows = ("FOR i FROM 1 TO n STEP 1 DO", *rows[1:])
    losses = converted(module(*rows, data=("VAR num n:=3;",)), "rapid", "krl").translated.losses
    assert not [one for one in losses if one.part == "step"]


def test_a_loop_that_may_do_nothing_has_its_step_in_rapid():
    text = krl(
        "DECL INT I",
        "DECL INT N",
        "N=0",
        "FOR I=1 TO N",
        "$ANOUT[1]=I",
        "ENDFOR",
        "FOR I=1 TO 3",
        "$ANOUT[1]=I",
        "ENDFOR",
    )
    written = translated(text, "krl", "rapid")
    assert "TO N STEP 1 DO" in written
    assert "FROM 1 TO 3 DO" in written
    assert [event.value for _, event in sorted(run_elsewhere(text, "krl", "rapid").events.items())] == [
        1,
        2,
        3,
    ]
