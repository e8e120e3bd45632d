"""RAPID's Dim: how many elements a dimension has (technical reference manual, Dim); other languages get the number."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from translated_texts import ROBOT, converted, run_elsewhere

from olp.core.source import decode
from olp.fluent import Program, read_source
from olp.fluent import read as read_path
from olp.runtime.plan import Plan, StepKind
from olp.transpile import Context
from olp.transpile.convert import convert
from olp.transpile.link import link

_PROGRAM = """MODULE M
CONST num rows:=3;
VAR num table{rows,5};
VAR num rest{2}:=[4,6];
PROC main()
  WaitTime Dim(table,1)/10;
  IF Dim(table,2)=5 THEN
    WaitTime Dim(rest,1)/10;
  ENDIF
  WaitTime total(rest)/10;
ENDPROC
FUNC num total(num values{*})
  VAR num sum:=0;
  FOR i FROM 1 TO Dim(values,1) DO
    sum:=sum+values{i};
  ENDFOR
  RETURN sum;
ENDFUNC
ENDMODULE
"""


def waits(program: Program) -> list[float]:
    return waits_of(program.plan())


def waits_of(plan: Plan) -> list[float]:
    return [round(10 * float(plan.durations[row]), 6) for row in plan.row[plan.kind == StepKind.WAIT]]


def test_sizes_in_the_run() -> None:
    assert waits(read_source(decode(_PROGRAM.encode(), "M.mod"))) == [3, 2, 10]


@pytest.mark.parametrize("target", ["krl", "tp", "inform"])
def test_sizes_that_a_declaration_tells_are_numbers(target: str) -> None:
    text = _PROGRAM.replace("  WaitTime total(rest)/10;\n", "").split("FUNC")[0] + "ENDMODULE\n"
    made = convert(read_source(decode(text.encode(), "M.mod")), target, Context(on_loss="comment"))
    assert not [loss for loss in made.translated.losses if loss.leaves_out]
    assert waits(read_source(decode(made.files[made.main], made.main), vendor=target)) == [3, 2]


@pytest.mark.parametrize("target", ["krl", "tp", "inform"])
def test_the_size_of_a_parameter_is_that_of_the_array_that_is_passed(target: str) -> None:
    assert not [loss for loss in converted(_PROGRAM, "rapid", target).translated.losses if loss.leaves_out]
    assert waits_of(run_elsewhere(_PROGRAM, "rapid", target)) == [3, 2, 10]


def test_the_size_of_a_parameter_that_gets_arrays_of_several_sizes_is_left_out_with_what_needs_it() -> None:
    more = "VAR num other{3}:=[1,2,3];\nPROC main()\n  WaitTime total(other)/10;\n"
    text = _PROGRAM.replace("PROC main()\n", more)
    made = convert(read_source(decode(text.encode(), "M.mod")), "krl", Context(on_loss="comment"))
    assert {loss.line for loss in made.translated.losses if loss.leaves_out} >= {16}


@pytest.mark.parametrize(
    ("target", "wanted"), [("krl", "DECL REAL table[3,5]"), ("urscript", "table = [[0.0,")]
)
def test_a_constant_that_gives_a_size_is_a_number_there(target: str, wanted: str) -> None:
    """KRL and URScript take no variable where an array is declared."""
    text = "MODULE M\nCONST num rows:=3;\nVAR num table{rows,5};\nPROC main()\ntable{rows,2}:=7;\n"
    text += "IF table{3,2}=7 WaitTime 1;\nENDPROC\nENDMODULE\n"
    made = converted(text, "rapid", target)
    assert not made.translated.losses
    assert wanted in b"\n".join(made.files.values()).decode()
    assert waits_of(run_elsewhere(text, "rapid", target)) == [10]


@pytest.mark.parametrize(
    ("target", "wanted"),
    [("rapid", ":=[FALSE,TRUE,FALSE,FALSE]"), ("urscript", " = [False, True, False, False]")],
)
def test_elements_without_a_first_value_are_zeros_and_a_call_that_leaves_one_out_is_refused(
    tmp_path: Path, target: str, wanted: str
) -> None:
    """A list of KRL sets some elements; RAPID got [FALSE,TRUE,,] and ROUTINE 1,,2, which it does not load."""
    (tmp_path / "p.dat").write_text("DEFDAT P\nDECL BOOL B[4]\nB[1]=FALSE\nB[2]=TRUE\nENDDAT\n")
    (tmp_path / "p.src").write_text("DEF P ( )\nB[3]=TRUE\nROUTINE (1, ,2)\nWAIT SEC 1\nEND\n")
    made = convert(link(read_path(tmp_path / "p.src")).program, target, Context(on_loss="comment"))
    assert wanted in b"".join(made.files.values()).decode()
    assert [loss.line for loss in made.translated.losses if loss.leaves_out] == [3]
    assert any("no first value" in loss.says for loss in made.translated.losses)


_COPIES = """MODULE M
VAR num first{3}:=[1,2,3];
VAR num second{3};
VAR num table{2,2}:=[[1,2],[3,4]];
VAR num other{2,2};
PROC main()
  VAR num third{3};
  second:=first;
  pass second,third;
  WaitTime third{3}/10;
  other:=table;
  WaitTime other{2,1}/10;
ENDPROC
PROC pass(num values{*}, INOUT num into{*})
  into:=values;
ENDPROC
ENDMODULE
"""


@pytest.mark.parametrize("target", ["krl", "tp", "inform", "urscript"])
def test_an_array_that_is_assigned_as_a_whole_has_all_elements(target: str) -> None:
    losses = converted(_COPIES, "rapid", target).translated.losses
    assert not [loss for loss in losses if loss.leaves_out]
    assert waits_of(run_elsewhere(_COPIES, "rapid", target)) == [3, 3]


def test_an_array_of_unknown_size_that_is_assigned_as_a_whole_is_left_out() -> None:
    text = _COPIES.replace("pass second,third;", "pass second,third;\n  pass first,first;\n  pass more,more;")
    text = text.replace("VAR num table", "VAR num more{4};\nVAR num table")
    left = [loss for loss in converted(text, "rapid", "krl").translated.losses if loss.leaves_out]
    assert "into gets all elements of values: nothing tells how many" in {loss.says for loss in left}


_HANDED = """MODULE M
VAR num table{100};
PROC main()
  fill table,3;
  WaitTime table{70}/10;
  WaitTime table{2}/10;
ENDPROC
PROC fill(INOUT num values{*},num first)
  FOR i FROM 1 TO Dim(values,1) DO
    values{i}:=first+i;
  ENDFOR
  again values;
ENDPROC
PROC again(INOUT num values{*})
  values{2}:=values{2}+4;
ENDPROC
ENDMODULE
"""


@pytest.mark.parametrize("target", ["tp", "inform"])
def test_an_array_that_all_calls_hand_over_is_no_copy(target: str) -> None:
    """Of more than 60 elements the call was left out, with what it sets."""
    made = converted(_HANDED, "rapid", target)
    assert not [loss for loss in made.translated.losses if loss.leaves_out]
    assert waits_of(run_elsewhere(_HANDED, "rapid", target)) == [73, 9]


def test_arrays_that_calls_hand_over_in_turn_are_copied() -> None:
    text = _HANDED.replace("{100}", "{7}").replace("{70}", "{7}")
    text = text.replace(
        "PROC main()\n", "VAR num other{7};\nPROC main()\n  fill other,1;\n  WaitTime other{2}/10;\n"
    )
    assert waits_of(run_elsewhere(text, "rapid", "tp")) == [7, 10, 9]


_PASSING = """MODULE M
CONST robtarget p0:=[[600,0,500],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
PROC main()
  VAR robtarget way{3000};
  MoveJ p0,v500,fine,tool0;
  FOR i FROM 1 TO 3 DO
    way{i+1}:=Offs(p0,0,0,i*10);
    MoveL way{i+1},v100,fine,tool0;
  ENDFOR
ENDPROC
ENDMODULE
"""


@pytest.mark.parametrize("target", ["tp", "inform"])
def test_an_array_whose_elements_are_read_where_they_are_set_is_one_variable(target: str) -> None:
    """There are not so many variables: all moves to its elements were left out."""
    made = converted(_PASSING, "rapid", target)
    assert not [loss for loss in made.translated.losses if loss.leaves_out]
    assert not [ask for ask in made.translated.asks if "set the controller up" in ask]
    plan = run_elsewhere(_PASSING, "rapid", target)
    np.testing.assert_allclose(
        plan.positions.position[plan.moves.target, 2], [0.5, 0.51, 0.52, 0.53], atol=1e-6
    )


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("  ENDFOR", "  ENDFOR\n  MoveL way{2},v100,fine,tool0;"),
        ("    MoveL way{i+1}", "    MoveL way{i}"),
        ("    MoveL", "    IF i>1 THEN\n      MoveL way{i},v100,fine,tool0;\n    ENDIF\n    MoveL"),
    ],
)
def test_an_array_whose_elements_are_read_elsewhere_stays_one(old: str, new: str) -> None:
    text = _PASSING.replace("{3000}", "{300}").replace(old, new)
    text = text.replace("  FOR", "  way{1}:=p0;\n  FOR", 1)
    plan, wanted = run_elsewhere(text, "rapid", "tp"), read_source(decode(text.encode(), "M.mod")).plan(ROBOT)
    heights, right = (one.positions.position[one.moves.target, 2] for one in (plan, wanted))
    np.testing.assert_allclose(heights, right, atol=1e-6)


@pytest.mark.parametrize("target", ["tp", "inform"])
def test_an_element_of_a_table_of_unknown_size_is_called_that(target: str) -> None:
    """It was "a computed position (compute it into a position register first)"."""
    text = ".PROGRAM draw(.&p[,])\nLMOVE .p[1,2]\n.END\n"
    says = [loss.says for loss in converted(text, "as", target).translated.losses if loss.leaves_out]
    assert says == ["nothing tells how many elements .p has"]
