"""Targets of KRL that leave components out, where no text shows the place before: they are put together as it runs."""

from __future__ import annotations

import re

import pytest
from translated_texts import ROBOT, converted, krl, read, run_elsewhere, translated

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
