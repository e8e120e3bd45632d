"""RAPID's quaternions, number by number, in languages whose positions have three angles."""

import math

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from translated_texts import ROBOT, converted, module, read, run_elsewhere

from olp.core.diagnostic import OlpError
from olp.runtime.plan import StepKind
from olp.transpile.compare import compare_plans
from olp.transpile.context import Fate

AXES = "[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]]"
DATA = (
    f"VAR robtarget p:=[[900,20,400],[0.5,-0.5,0.5,0.5],{AXES};",
    f"VAR robtarget s:=[[900,20,400],[0,1,0,0],{AXES};",
    "PERS tooldata t:=[TRUE,[[10,20,100],[1,0,0,0]],[1,[0,0,1],[1,0,0,0],0,0,0]];",
    'PERS wobjdata w:=[FALSE,TRUE,"",[[0,0,0],[1,0,0,0]],[[5,6,7],[1,0,0,0]]];',
    "VAR num x:=0;",
)
# Turns of all kinds: any, no rotation, half ones, those of 90 deg about y and next to them, those not of unit length.
TURNS = [
    *np.random.default_rng(5).normal(size=(6, 4)),
    [1, 0, 0, 0],
    [0, 0.6, 0, 0.8],
    [0, 0, 1, 0],
    [math.sqrt(0.5), 0, math.sqrt(0.5), 0],
    [0.5, -0.5, -0.5, 0.5],
    [0.7071, 0.0001, 0.7071, 0.0002],
    [0.70703, 0.01, 0.70711, -0.01],
]


def unit(turn):
    return [float(v) for v in np.array(turn) / np.linalg.norm(turn)]


def written(place, turn, order=(2, 0, 3, 1)):
    return [f"{place}.q{k + 1}:={turn[k]:.9f};" for k in order]


def turned(place, turn):
    return module(
        "MoveL s,v100,fine,t\\WObj:=w;", *written(place, turn), "MoveL p,v100,fine,t\\WObj:=w;", data=DATA
    )


def target_turn(plan):
    """The turn of the place that the last move goes to."""
    last = plan.moves.target[plan.row[np.flatnonzero(plan.kind == StepKind.MOVE)[-1]]]
    w, x, y, z = plan.positions.quaternion[last]
    return Rotation.from_quat([x, y, z, w])


@pytest.mark.parametrize("turn", TURNS)
def test_a_turn_that_is_written_number_by_number_is_the_turn_of_its_quaternion(turn):
    w, x, y, z = turn
    plan = read(turned("p.rot", turn), "rapid").plan(robot=ROBOT)
    assert (target_turn(plan) * Rotation.from_quat([x, y, z, w]).inv()).magnitude() < 1e-6


@pytest.mark.slow(
    *(
        "p.rot-tp",
        "p.rot-urscript",
        "t.tframe.rot-krl",
        "t.tframe.rot-urscript",
        "w.oframe.rot-krl",
        "w.oframe.rot-tp",
    )
)
@pytest.mark.parametrize("target", ["krl", "tp", "urscript"])
@pytest.mark.parametrize("place", ["p.rot", "t.tframe.rot", "w.oframe.rot"])
def test_a_turn_that_is_written_number_by_number_is_the_same_elsewhere(place, target):
    for turn in TURNS:
        text = turned(place, unit(turn))
        found = compare_plans(
            read(text, "rapid").plan(robot=ROBOT), run_elsewhere(text, "rapid", target), speeds=False
        )
        assert found.steps == 2
        assert found.worst_position < (4e-4 if place[0] == "w" else 1e-6)
        assert found.worst_angle < math.radians(0.02), turn
    told = [
        loss for loss in converted(text, "rapid", target).translated.losses if loss.line in (9, 10, 11, 12)
    ]
    assert {loss.fate for loss in told} == {Fate.APPROXIMATED}
    assert {loss.line for loss in told} == {9, 10, 11, 12}


@pytest.mark.parametrize("target", ["krl", "tp", "inform", "urscript"])
@pytest.mark.parametrize("number", [1, 2, 3, 4])
def test_a_number_that_is_read_is_that_of_the_turn_but_for_its_sign(number, target):
    data = (*DATA, f"VAR robtarget r:=[[900,20,400],[0.27,-0.53,0.61,0.52],{AXES};")
    text = module(f"x:=r.rot.q{number};", "WaitTime x*x;", data=data)
    one, other = read(text, "rapid").plan(robot=ROBOT), run_elsewhere(text, "rapid", target)
    assert other.durations[-1] == pytest.approx(one.durations[-1], abs=6e-3 if target == "inform" else 1e-4)
    assert one.durations[-1] == pytest.approx(unit([0.27, -0.53, 0.61, 0.52])[number - 1] ** 2, abs=1e-4)


@pytest.mark.parametrize("target", ["krl", "tp", "urscript"])
@pytest.mark.parametrize(
    ("rows", "lines"),
    [
        (["p.rot.q2:=x;"], {9}),
        (["p.rot.q1:=1;", "p.rot.q2:=0;", "p.rot.q3:=0;", "p.rot.q3:=x;"], {9, 10, 11, 12}),
        (["p.rot.q1:=1;", "p.rot.q2:=0;", "s.rot.q3:=0;", "p.rot.q4:=x;"], {9, 10, 11, 12}),
        (["p.rot.q1:=p.rot.q2;", "p.rot.q2:=0;", "p.rot.q3:=0;", "p.rot.q4:=1;"], {9, 10, 11, 12}),
        (["w.uframe.trans.x:=3;", "w.oframe.trans.x:=3;"], {9, 10}),
        (["w:=[FALSE,TRUE,\"\",[[1,0,0],[1,0,0,0]],[[5,6,7],[1,0,0,0]]];", "w.oframe.trans.x:=3;"], {10}),
    ],
)  # fmt: skip
def test_what_is_no_whole_turn_or_no_whole_frame_is_refused(rows, lines, target):
    text = module("MoveL s,v100,fine,t\\WObj:=w;", *rows, "MoveL p,v100,fine,t\\WObj:=w;", data=DATA)
    with pytest.raises(OlpError) as told:
        converted(text, "rapid", target, on_loss="error")
    assert {found.line for found in told.value.diagnostics} >= lines


@pytest.mark.parametrize("target", ["krl", "tp", "urscript"])
def test_components_of_tools_and_frames_are_set_and_read_where_they_have_numbers_too(target):
    rows = (
        "MoveL s,v100,fine,t\\WObj:=w;", "t.tframe.trans.z:=t.tframe.trans.z+40;", "w.oframe.trans.y:=33;",
        "MoveL s,v100,fine,t\\WObj:=w;", "WaitTime t.tframe.trans.z/100;",
        "t:=[TRUE,[[1,2,3],[1,0,0,0]],[1,[0,0,1],[1,0,0,0],0,0,0]];", "t.tframe.trans.x:=w.oframe.trans.y;",
        "MoveL s,v100,fine,t\\WObj:=w;",
    )  # fmt: skip
    text = module(*rows, data=DATA)
    one, other = read(text, "rapid").plan(robot=ROBOT), run_elsewhere(text, "rapid", target)
    found = compare_plans(one, other, speeds=False)
    assert found.differences == []
    assert found.steps == 4
    assert not [
        loss for loss in converted(text, "rapid", target).translated.losses if loss.fate is Fate.REFUSED
    ]


@pytest.mark.parametrize("target", ["tp", "inform"])
def test_components_of_a_tool_of_one_routine_are_refused_where_tools_have_numbers(target):
    data = "VAR tooldata l:=[TRUE,[[10,20,100],[1,0,0,0]],[1,[0,0,1],[1,0,0,0],0,0,0]];"
    text = module(data, "l.tframe.trans.x:=x;", "MoveL s,v100,fine,l\\WObj:=w;", data=DATA)
    with pytest.raises(OlpError) as told:
        converted(text, "rapid", target, on_loss="error")
    assert 9 in {found.line for found in told.value.diagnostics}
