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
  VAR num row{first};
  TPReadNum row,"Which row? (1 to 4)";
  IF row>0 THEN
    WaitTime waits{row};
  ENDIF
ENDPROC
ENDMODULE
"""


@pytest.mark.parametrize("first", [":=0", ""])
@pytest.mark.parametrize("target", ["krl", "tp"])
def test_what_the_operator_types_is_no_constant(target: str, first: str) -> None:
    text = _PROGRAM.replace("{first}", first)
    made = convert(read_source(decode(text.encode(), "M.mod")), target, Context(on_loss="comment"))
    losses = made.translated.losses
    assert [loss.line for loss in losses if loss.leaves_out] == [5]
    told = {loss.line for loss in losses if loss.fate is Fate.APPROXIMATED and "TPReadNum" in loss.says}
    assert told == {6, 7}


_FOUND = """MODULE M
CONST robtarget p1:=[[700,200,700],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
VAR robtarget found;
PERS num held:=1;
VAR num list{2};
PROC main()
  SearchL \\Stop,di1,found,p1,v100,tool0;
  TPReadNum held,"Which?";
  TPReadNum list{1},"Which?";
  MoveL Offs(found,0,0,50),v100,fine,tool0;
  WaitTime held;
  WaitTime list{1};
ENDPROC
ENDMODULE
"""


@pytest.mark.parametrize("target", ["krl", "tp", "inform", "urscript"])
def test_what_needs_a_place_or_a_number_that_is_left_out_is_told(target: str) -> None:
    made = convert(read_source(decode(_FOUND.encode(), "M.mod")), target, Context(on_loss="comment"))
    told = {
        loss.line for loss in made.translated.losses if "sets in a way that the target cannot" in loss.says
    }
    assert told == {10, 11, 12}
