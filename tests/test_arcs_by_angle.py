"""KRL's arcs that turn by an angle (CA): how far they go, and the same arcs in languages without such a word."""

from __future__ import annotations

import math

import numpy as np
import pytest
from translated_texts import ROBOT, converted, krl, read, run_elsewhere

from olp.core.units import mm
from olp.runtime.interpreter import run
from olp.transpile.compare import WRITTEN, compare_plans

RADIUS = 50 * mm
CENTRE = np.array([550.0, 0.0, 500.0]) * mm
SYSTEMS = ("BAS(#INITMOV,0)", "$BASE=$NULLFRAME", "$TOOL=$NULLFRAME", "$VEL.CP=0.1")
START = "PTP {X 500,Y 0,Z 500,A 0,B 90,C 0}"
ARC = "CIRC {X 550,Y 50,Z 500},{X 600,Y 0,Z 500}, CA "


def plan_of(*rows):
    return run(read(krl(*SYSTEMS, START, *rows), "krl"), robot=ROBOT)


@pytest.mark.parametrize("degrees", [15.0, 90.0, 180.0, 270.0, 349.0, 360.0, 400.0, 720.0, -90.0, -360.0])
def test_it_is_as_long_as_its_angle_and_ends_there(degrees):
    plan = plan_of(f"{ARC}{degrees}")
    assert float(plan.moves.length[1:].sum()) == pytest.approx(RADIUS * math.radians(abs(degrees)), rel=1e-9)
    turned = math.pi - math.radians(degrees)  # from the start at -x over +y
    there = CENTRE + RADIUS * np.array([math.cos(turned), math.sin(turned), 0.0])
    assert plan.positions.position[plan.moves.target[-1]] == pytest.approx(there, abs=1e-9)
    assert not np.isnan(plan.positions.axes[plan.moves.target[-1], :6]).any()


def test_an_arc_by_an_offset_turns_from_where_the_arm_is():
    plan = plan_of("CIRC_REL {X 50,Y 50},{X 100}, CA 90")
    top = CENTRE + RADIUS * np.array([0.0, 1.0, 0.0])
    assert plan.positions.position[plan.moves.target[-1]] == pytest.approx(top, abs=1e-9)


def test_the_orientation_at_its_end_is_an_assumption():
    turned = "CIRC {X 550,Y 50,Z 500},{X 600,Y 0,Z 500,A 10,B 90,C 0}, CA 90"
    said = [[it.says for it in plan_of(row).assumptions] for row in (turned, f"{ARC}90")]
    assert [sum("orientation of its target" in it for it in texts) for texts in said] == [1, 0]


def test_the_angle_is_bounded():
    plan = plan_of(f"{ARC}1E9")
    assert [d.code for d in plan.diagnostics if d.is_error] == ["I308"]


@pytest.mark.parametrize("target", ["inform", "rapid", "tp", "urscript"])
def test_other_languages_go_through_points(target):
    text = krl(*SYSTEMS, START, f"{ARC}360", f"{ARC}-100", "LIN {X 500,Y 10,Z 500,A 0,B 90,C 0}")
    assert not [loss for loss in converted(text, "krl", target).translated.losses if loss.leaves_out]
    here, there = run(read(text, "krl"), robot=ROBOT), run_elsewhere(text, "krl", target)
    found = [d for d in compare_plans(here, there, tolerances=WRITTEN).found if d.part != "blend"]
    assert not found


def test_from_a_place_that_no_text_tells_it_is_rejected():
    text = krl("DECL E6POS P", *SYSTEMS, START, "P=$POS_ACT", "P.X=P.X+1", "LIN P", f"{ARC}90")
    losses = converted(text, "krl", "rapid").translated.losses
    assert [loss.line for loss in losses if loss.leaves_out] == [11]


@pytest.mark.parametrize(("turn", "told"), [(0, []), (20, [5])])
def test_a_tool_that_turns_on_an_arc_by_an_angle_is_told(turn, told):
    rows = (
        "LIN {X 700,Y 0,Z 500,A 0,B 90,C 0}",
        f"CIRC {{X 720,Y 20,Z 500,A 0,B 90,C 0}},{{X 740,Y 0,Z 500,A {turn},B 90,C 0}},CA 270",
    )
    text = krl("BAS(#INITMOV,0)", "PTP {A1 0,A2 -90,A3 90,A4 0,A5 10,A6 0}", *rows)
    losses = converted(text, "krl", "rapid").translated.losses
    assert [loss.line for loss in losses if "by an angle" in loss.says] == told
