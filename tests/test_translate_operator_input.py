"""A variable that only an instruction without a counterpart sets is no constant: a person puts the instruction back."""

from __future__ import annotations

import pytest

from olp.core.source import decode
from olp.fluent import read_source
from olp.transpile import Context
from olp.transpile.context import Fate
from olp.transpile.convert import convert

_PROGRAM = """MODULE M
VAR num waits{4}:=[0.1,0.2,0.3,0.4];
PROC main()
  VAR num row:=0;
  TPReadNum row,"Which row? (1 to 4)";
  IF row>0 THEN
    WaitTime waits{row};
  ENDIF
ENDPROC
ENDMODULE
"""


@pytest.mark.parametrize("target", ["krl", "tp"])
def test_what_the_operator_types_is_no_constant(target: str) -> None:
    made = convert(read_source(decode(_PROGRAM.encode(), "M.mod")), target, Context(on_loss="comment"))
    losses = made.translated.losses
    assert [loss.line for loss in losses if loss.leaves_out] == [5]
    told = {loss.line for loss in losses if loss.fate is Fate.APPROXIMATED and "TPReadNum" in loss.says}
    assert told == {6, 7}
