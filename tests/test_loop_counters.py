"""RAPID's FOR declares its counter, which hides a variable of the same name (technical reference manual, FOR)."""

from __future__ import annotations

import pytest

from olp.core.source import decode
from olp.fluent import Program, read_source
from olp.runtime.plan import StepKind
from olp.transpile import Context
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
