"""Targets of KRL that leave components out, where no text shows the place before: they are put together as it runs."""

from __future__ import annotations

import re

import pytest
from translated_texts import ROBOT, converted, krl, module, read, run_elsewhere, translated

from olp.runtime.interpreter import run
from olp.transpile.compare import WRITTEN, compare_plans

JOINTS = "PTP {A1 10,A2 -10,A3 20,A4 0,A5 40,A6 0}"
SYSTEMS = ("$TOOL={X 0,Y 0,Z 100,A 0,B 0,C 0}", "$BASE={X 100,Y 50,Z 0,A 10,B 0,C 0}")
AXES = ("PTP_REL {A1 10,A3 -2.5}", "PTP {A2 -20}", "PTP_REL {A6 15}")
ARCS = ("CIRC {X 700,Y 20,Z 500},{X 720,Y 60,Z 510}", "CIRC {X 730,Y 90},{Y 120,A 5}")
MOVES = ("LIN {Z 500}", "LIN {X 700,Y 10}", "LIN {Z 450,A 5}", "PTP {X 720}")


@pytest.mark.parametrize("target", ["rapid", "tp", "urscript"])
def test_the_arm_comes_to_the_same_places(target):
    text = krl("BAS(#INITMOV,0)", *SYSTEMS, JOINTS, *MOVES, *ARCS, *AXES)
    assert not [loss for loss in converted(text, "krl", target).translated.losses if loss.leaves_out]
    here, there = run(read(text, "krl"), robot=ROBOT), run_elsewhere(text, "krl", target)
    found = compare_plans(here, there, tolerances=WRITTEN)
    assert found.steps == 10
    assert not found.found


@pytest.mark.parametrize("target", ["rapid", "tp", "urscript"])
def test_axes_that_differ_each_time_are_read_when_the_arm_is_there(target):
    rows = ("FOR N=1 TO 2", "IF N==2 THEN", "PTP {A1 40}", "ENDIF", "PTP {A2 -30}", "ENDFOR")
    text = krl("DECL INT N", "BAS(#INITMOV,0)", JOINTS, *rows)
    assert not [loss for loss in converted(text, "krl", target).translated.losses if loss.leaves_out]
    here, there = run(read(text, "krl"), robot=ROBOT), run_elsewhere(text, "krl", target)
    found = compare_plans(here, there, tolerances=WRITTEN)
    assert found.steps == 3  # the second PTP {A2 -30} moves nothing
    assert not found.found


def test_a_corner_before_it_becomes_a_stop_and_is_told():
    text = krl("BAS(#INITMOV,0)", JOINTS, "LIN {Z 500}", "LIN {X 700} C_DIS", "LIN {Z 450}")
    blends = [loss.line for loss in converted(text, "krl", "tp").translated.losses if loss.part == "blend"]
    assert blends == [5]


def test_the_arguments_of_rapids_own_functions_keep_their_names():
    written = translated(krl("BAS(#INITMOV,0)", *SYSTEMS, JOINTS, MOVES[0]), "krl", "rapid")
    assert re.search(r":=CRobT\(\\Tool:=\w+\\WObj:=\w+\);", written)
    assert "target.trans.z:=500;" in written


COMPUTED = (
    "LIN {Z H}", "LIN_REL {X D,Z -D}", "LIN_REL {Z D} #TOOL", "PTP {A5 D}", "PTP_REL {A1 D}",
    "P={X H,Y 0,Z 500,A 0,B 90,C 0,S 2,T 10}", "LIN P", "Q={A1 D,A2 -20,A3 30,A4 0,A5 50,A6 0}", "PTP Q",
    "Q={A1 Q.A1+D,A2 -25,A3 30,A4 0,A5 50,A6 0}", "PTP Q", "PTP {A1 D,A2 -15,A3 25,A4 0,A5 45,A6 0,E1 0,E2 0}",
)  # fmt: skip


@pytest.mark.parametrize("target", ["rapid", "tp", "urscript"])
def test_components_that_are_computed_come_to_the_same_places(target):
    given = ("DECL REAL H,D", "DECL E6POS P", "DECL E6AXIS Q", "BAS(#INITMOV,0)", *SYSTEMS, "H=600", "D=15")
    text = krl(*given, JOINTS, *COMPUTED)
    assert not [loss for loss in converted(text, "krl", target).translated.losses if loss.leaves_out]
    here, there = run(read(text, "krl"), robot=ROBOT), run_elsewhere(text, "krl", target)
    found = compare_plans(here, there, tolerances=WRITTEN)
    assert found.steps == 10
    assert not found.found


@pytest.mark.parametrize("target", ["rapid", "tp", "urscript", "inform"])
def test_external_axes_of_computed_positions_are_written_or_rejected(target):
    rows = ("LIN {X D,Y 0,Z 500,A 0,B 90,C 0,E1 D}", "PTP {A1 D,A2 -15,A3 25,A4 0,A5 45,A6 0,E1 100}")
    text = krl("DECL REAL D", "BAS(#INITMOV,0)", "D=600", JOINTS, *rows)
    lost = {loss.line for loss in converted(text, "krl", target).translated.losses if loss.leaves_out}
    assert lost == (set() if target == "rapid" else {6, 7})
    if target == "rapid":
        written = translated(text, "krl", target)
        assert "MoveL [[D,0,500]," in written
        assert ",[D,9E9,9E9,9E9,9E9,9E9]]" in written
        assert "MoveAbsJ [[D,-15,25,0,45,0],[100,9E9,9E9,9E9,9E9,9E9]]" in written


@pytest.mark.parametrize("target", ["krl", "tp", "urscript"])
def test_computed_external_axes_of_rapid_are_rejected_where_they_cannot_be_said(target):
    rows = ("x:=[[500,e,400],[0,1,0,0],[0,0,0,0],[e,9E9,9E9,9E9,9E9,9E9]];", "MoveL x,v100,fine,tool0;")
    text = module(*rows, data=("VAR robtarget x;", "VAR num e:=10;"))
    assert 5 in {loss.line for loss in converted(text, "rapid", target).translated.losses if loss.leaves_out}


@pytest.mark.parametrize("row", ["P={Z 500}", "P={Z D}", "Q={A1 D}"])
def test_what_an_assignment_leaves_out_is_not_guessed(row):
    text = krl("DECL REAL D", "DECL E6POS P", "DECL E6AXIS Q", row)
    assert {5} == {loss.line for loss in converted(text, "krl", "rapid").translated.losses if loss.leaves_out}
