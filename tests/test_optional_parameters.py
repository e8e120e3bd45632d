"""RAPID's optional parameters and switches (technical reference manual, Present), where arguments have their place.

The oracle is the meaning of each call: the waits, in tenths of a second.
"""

from __future__ import annotations

import pytest

from olp.core.source import decode
from olp.fluent import Program, read_source
from olp.runtime.plan import StepKind
from olp.transpile import Context
from olp.transpile.convert import convert

_PROGRAM = """MODULE M
PROC main()
  rest 1;
  rest 1\\more:=2;
  rest 3\\twice;
  rest 4\\more:=0\\twice;
  through 5\\more:=2;
  through 5;
  WaitTime total(6)/10;
  WaitTime total(6\\more:=3)/10;
ENDPROC
PROC rest(num a\\num more\\switch twice)
  IF Present(more) THEN
    WaitTime (a+more)/10;
  ELSE
    WaitTime a/10;
  ENDIF
  IF Present(twice) THEN
    WaitTime a/10;
  ENDIF
ENDPROC
PROC through(num a\\num more)
  rest a\\more?more;
ENDPROC
FUNC num total(num a\\num more)
  IF NOT Present(more) RETURN a;
  RETURN a+more;
ENDFUNC
ENDMODULE
"""
_TENTHS = [1, 3, 3, 3, 4, 4, 7, 5, 6, 9]


def waits(program: Program) -> list[float]:
    plan = program.plan()
    return [round(10 * float(plan.durations[row]), 6) for row in plan.row[plan.kind == StepKind.WAIT]]


def test_present_in_the_run() -> None:
    assert waits(read_source(decode(_PROGRAM.encode(), "M.mod"))) == _TENTHS


@pytest.mark.parametrize("target", ["krl", "urscript"])
def test_arguments_that_are_left_out(target: str) -> None:
    made = convert(read_source(decode(_PROGRAM.encode(), "M.mod")), target, Context())
    assert waits(read_source(decode(made.files[made.main], made.main), vendor=target)) == _TENTHS


def test_fanuc_takes_the_flags_as_numbers() -> None:
    made = convert(read_source(decode(_PROGRAM.encode(), "M.mod")), "tp", Context(on_loss="comment"))
    assert not [loss for loss in made.translated.losses if loss.leaves_out]
