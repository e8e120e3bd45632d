"""What a translation once changed without a word: a program for each cause, and what has to be said of it."""

from __future__ import annotations

import math
import re
from pathlib import Path

import numpy as np
import pytest
from translated_texts import converted, inform, krl, module, read, run_elsewhere, script, tp, translated

import olp
from olp.core.diagnostic import OlpError
from olp.core.source import decode, load
from olp.fluent import read_source
from olp.robots.robot import load_robot
from olp.runtime.assumptions import NAMED_SIGNAL, Assumptions, SignalKey
from olp.runtime.dispatch import begun_at
from olp.runtime.interpreter import run
from olp.runtime.plan import BlendCode, StepKind
from olp.transpile import Context
from olp.transpile.compare import compare_plans
from olp.transpile.context import PROCESS, Fate, Mapping
from olp.transpile.convert import convert, run_converted, runs_of
from olp.transpile.link import link, with_starts
from olp.transpile.preflight import before_it_runs
from olp.transpile.receipt import receipt_of, verdict_of

ROBOT = load_robot("yaskawa/gp25")
P1, P2 = (1, 0, 1, 900, 0, 400, 180, 0, 0), (2, 0, 1, 900, 100, 400, 180, 0, 0)
TARGETS = (
    "CONST robtarget p1:=[[900,0,400],[0,1,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];",
    "CONST robtarget p2:=[[900,100,400],[0,1,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];",
    "VAR num x:=0;",
)
HOME = ("BAS(#INITMOV,0)", "PTP {A1 0,A2 -90,A3 90,A4 0,A5 40,A6 0}", "$VEL.CP=0.5", "$APO.CDIS=20")


def poses(*places):
    return [f"LIN {{X {x},Y {y},Z {z},A 0,B 90,C 0}}" for x, y, z in places]


def losses(text, vendor, target):
    return converted(text, vendor, target).translated.losses


def refused(text, vendor, target):
    """Line -> what is said of a statement that the target cannot take."""
    with pytest.raises(OlpError) as told:
        converted(text, vendor, target, on_loss="error")
    return {found.line: found.message for found in told.value.diagnostics}


def code(text, mark):
    """The lines of a translation that are no comments."""
    return [line.strip() for line in text.splitlines() if line.strip() and not line.strip().startswith(mark)]


# --- 1: registers that nothing sets -------------------------------------------------------------------------


@pytest.mark.parametrize("target", ["rapid", "krl", "urscript"])
def test_registers_of_a_listing_that_nothing_sets_are_named(target):
    rows = ("J P[1] 100% FINE", "R[3]=R[4]+1", "PR[5,1]=10", "L PR[5] 100mm/sec FINE", "R[6]=R[6]+1")
    made = converted(tp(*rows, positions=(P1,)), "tp", target)
    asked = {
        thing.partition(" (")[0]
        for says, things in made.translated.asks.items()
        if "zeros" in says
        for thing in things
    }
    assert {"R4", "PV5", "R6"} <= asked
    assert "R3" not in asked
    lines = {loss.line for loss in made.translated.losses if "begins with zero" in loss.says}
    assert lines >= {7, 10}


# --- speeds that nothing tells ------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("target", "taken"), [("krl", "50 %"), ("tp", "50 %"), ("inform", "50 %"), ("urscript", "rad/s")]
)
def test_a_speed_of_the_tool_that_no_way_turns_into_one_of_the_axes_is_told(target, taken):
    """Nobody knows where the arm stands before: 500 mm/s of the tool may be 5 % of its axes or all of them."""
    moves = ("MoveJ p1,v500,fine,tool0;", "MoveJ p2,v500,fine,tool0;")
    told = [x for x in losses(module(*moves, data=TARGETS), "rapid", target) if "goes nowhere" in x.says]
    assert [(x.line, x.fate, x.part) for x in told] == [(6, Fate.APPROXIMATED, "speed")]
    assert "500 mm/s is taken for" in told[0].says
    assert told[0].says.endswith(taken)


# --- 2: options of moves ------------------------------------------------------------------------------------


@pytest.mark.parametrize("option", ["Skip,LBL[2]", "TA .20sec,R[1]=2"])
@pytest.mark.parametrize("target", ["rapid", "krl", "inform", "urscript"])
def test_what_happens_on_the_way_of_a_move_is_refused_with_it(option, target):
    rows = ("J P[1] 100% FINE", f"L P[2] 100mm/sec FINE {option}", "LBL[2]")
    assert option.split()[0].split(",")[0] in refused(tp(*rows, positions=(P1, P2)), "tp", target)[7]


BEHIND = {
    "TA .20sec,CALL OPEN(3)": (r"OPEN\b", "0.2 s behind its end"),
    "DB 10mm,DO[1]=DI[1]": (
        r"DOUT OT|\$OUT\[1\]=|SetDO do1|set_standard_digital_out\(1",
        "10 mm before its end",
    ),
    "DB 10mm,DO[1]=PULSE,0.5sec": (r"PULSE OT|PULSE ?\(\$OUT|PulseDO|run olp_pulse", "10 mm before its end"),
    "TB .50sec,P-SPS": ("", "a P-SPS block runs behind its move"),
}


@pytest.mark.parametrize("option", BEHIND)
@pytest.mark.parametrize("target", ["rapid", "krl", "inform", "urscript"])
def test_what_a_move_does_on_its_way_is_done_behind_it_and_told(option, target):
    """The move itself was left out with it."""
    rows = ("J P[1] 100% FINE", f"L P[2] 100mm/sec FINE {option}", "L P[1] 100mm/sec FINE")
    text = tp(*rows, positions=(P1, P2))
    there = run_elsewhere(text, "tp", target)
    assert len(there.moves) == 3
    deed, says = BEHIND[option]
    written = translated(text, "tp", target)
    assert len(re.findall(deed, written)) >= 1
    told = [loss for loss in losses(text, "tp", target) if loss.line == 7 and says in loss.says]
    assert [loss.fate for loss in told] == [Fate.APPROXIMATED]
    assert not [loss for loss in losses(text, "tp", target) if loss.leaves_out]


ON_THE_WAY = {
    ("TB .50sec,DO[4]=ON", "krl"): r"TRIGGER WHEN DISTANCE=1 DELAY=-500 DO \$OUT\[4\]=TRUE",
    ("TA .20sec,DO[4:gun]=OFF", "krl"): r"\$OUT\[4\]=FALSE",
    ("DB 10.0mm,RO[1]=ON", "rapid"): r"TriggIO (\w+),10\\DOp:=ro1,1;\s+TriggL P2,v100,\1,fine",
    ("DB 10mm,DO[1]=ON", "krl"): r"TRIGGER WHEN PATH=-10 DELAY=0 DO \$OUT\[1\]=TRUE",
    ("TB 0.25sec,DO[4]=ON", "inform"): r"DOUT OT#\(4\) ON",
    ("TB 0.25sec,DO[4]=ON", "urscript"): r"set_digital_out\(4, True\)|set_standard_digital_out\(4, True\)",
}


@pytest.mark.parametrize(("option", "target"), ON_THE_WAY)
def test_an_output_on_the_way_of_a_move_stays_there_or_is_told(option, target):
    rows = ("J P[1] 100% FINE", f"L P[2] 100mm/sec FINE {option}", "L P[1] 100mm/sec FINE")
    text = tp(*rows, positions=(P1, P2))
    written = translated(text, "tp", target)
    assert re.search(ON_THE_WAY[option, target], written)
    told = [loss for loss in losses(text, "tp", target) if loss.line == 7 and loss.part == "order"]
    assert bool(told) is not bool(re.search("TRIGGER|Trigg", written))


@pytest.mark.parametrize(
    "setting", ["PAYLOAD[1:part]", "COL DETECT OFF", "COL GUARD ADJUST 80", "LOCK PREG", "RSR[1]=ENABLE"]
)
def test_how_a_controller_of_fanuc_moves_is_a_comment_that_is_told(setting):
    text = tp("J P[1] 100% FINE", setting, "L P[2] 100mm/sec FINE", positions=(P1, P2))
    assert f"! not translated: 2:{setting}" in translated(text, "tp", "rapid")
    assert [str(loss.fate) for loss in losses(text, "tp", "rapid") if loss.line == 7] == ["approximated"]


def test_an_option_that_moves_the_wrist_otherwise_is_told():
    rows = ("J P[1] 100% FINE", "L P[2] 100mm/sec FINE Wjnt")
    found = losses(tp(*rows, positions=(P1, P2)), "tp", "rapid")
    assert [(loss.line, loss.fate) for loss in found if loss.part == "option"] == [(7, Fate.APPROXIMATED)]


@pytest.mark.parametrize("options", ["Arc Start[1]", "PTH Arc End[2]", "ACC50 Arc Start[1,R[2]]"])
def test_a_weld_that_fanucs_move_begins_is_told_and_the_move_is_made(options):
    rows = ("J P[1] 100% FINE", f"L P[2] 100mm/sec FINE {options}")
    found = losses(tp(*rows, positions=(P1, P2)), "tp", "rapid")
    assert [(loss.line, loss.fate) for loss in found if loss.part == "process"] == [(7, Fate.APPROXIMATED)]
    assert "MoveL" in translated(tp(*rows, positions=(P1, P2)), "tp", "rapid")


@pytest.mark.parametrize("number", [1, 20])
def test_a_weld_under_numbered_conditions_is_one_where_the_target_has_such(number):
    weld = (f"Arc Start[{number}]", "L P[2] 10mm/sec FINE", f"Arc End[{number}]")
    text = tp("J P[1] 100% FINE", *weld, positions=(P1, P2))
    found = converted(text, "tp", "inform")
    told = [
        (loss.line, loss.fate, loss.part) for loss in found.translated.losses if loss.part == "conditions"
    ]
    assert told == [(7, Fate.APPROXIMATED, "conditions"), (9, Fate.APPROXIMATED, "conditions")]
    (asked,) = (things for says, things in found.translated.asks.items() if "welding conditions" in says)
    assert asked == (f"ARCON {number}", f"ARCOF {number}")
    job = found.files[found.main].decode()
    rows = [row for row in job.splitlines() if row.startswith(("MOV", "ARC"))]
    assert [row.split()[0] for row in rows] == ["MOVJ", "ARCON", "MOVL", "ARCOF"]
    assert f"ARCON ASF#({number})" in rows
    assert f"ARCOF AEF#({number})" in rows
    back = translated(job, "inform", "tp")
    assert f"Arc Start[{number}] ;" in back
    assert f"Arc End[{number}] ;" in back


@pytest.mark.parametrize(
    "weld", ["Arc Start[R[1]]", "Arc Start[20.0Volts,180.0Amps]", "Arc Start[1,2]", "Arc Start"]
)
def test_a_weld_whose_conditions_are_no_number_is_left_out(weld):
    text = tp("J P[1] 100% FINE", weld, positions=(P1,))
    assert [loss.line for loss in losses(text, "tp", "inform") if loss.leaves_out] == [7]


# --- 3: handlers --------------------------------------------------------------------------------------------


@pytest.mark.parametrize("target", ["krl", "tp", "inform", "urscript"])
def test_a_handler_is_told_as_left_out_and_never_an_exact_comment(target):
    rows = (
        "MoveL p2,v100,fine,tool0;",
        "x:=1/x;",
        "ERROR",
        "SetDO do1,1;",
        "MoveL p1,v100,fine,tool0;",
        "TRYNEXT;",
    )
    text = module(*rows, data=TARGETS)
    made = [
        loss for loss in losses(text, "rapid", target) if "itself stops where something fails" in loss.says
    ]
    told = [(loss.line, loss.fate, loss.part) for loss in made]
    assert told == [(n, Fate.APPROXIMATED, PROCESS) for n in (8, 9, 10, 11)]
    program, there = read(text, "rapid"), converted(text, "rapid", target)
    runs = runs_of(program, there, target, (ROBOT, None))
    assert "left-out" in {one.kind for one in verdict_of(there.translated, runs, [], False).objections}


# --- 4: a tool that is fixed in space -----------------------------------------------------------------------


@pytest.mark.parametrize("target", ["rapid", "tp", "inform", "urscript"])
def test_a_move_with_the_tool_fixed_in_space_is_no_move_to_the_plain_pose(target):
    text = krl(*HOME, "$IPO_MODE=#TCP", *poses((900, 0, 600)), "$IPO_MODE=#BASE", *poses((900, 50, 600)))
    made = converted(text, "krl", target)
    gone = {loss.line for loss in made.translated.losses if loss.leaves_out}
    assert 7 in gone
    assert 9 not in gone


# --- 5: offsets that turn -----------------------------------------------------------------------------------


@pytest.mark.parametrize("target", ["rapid", "krl", "inform", "urscript"])
@pytest.mark.parametrize("turns", [(30, 0, 0), (0, 40, 0), (30, 40, 0), (0, 40, 50), (30, 40, 50)])
def test_an_offset_along_the_tool_turns_as_it_did(turns, target):
    elements = [f"PR[5,{at}]={value}" for at, value in enumerate((10, -20, 30, *turns), 1)]
    text = tp("J P[1] 100% FINE", *elements, "L P[2] 100mm/sec FINE Tool_Offset,PR[5]", positions=(P1, P2))
    plan, other = read(text, "tp").plan(robot=ROBOT), run_elsewhere(text, "tp", target)
    assert compare_plans(plan, other, speeds=False).differences == []


@pytest.mark.parametrize("target", ["rapid", "krl", "inform", "urscript"])
@pytest.mark.parametrize("word", ["Offset", "Tool_Offset"])
def test_an_offset_from_axis_values_is_rejected(word, target):
    """It was a product of axis values and a pose, which no controller takes, and counted as exact where no run came."""
    text = tp("PR[5,1]=10", f"J P[1] 100% FINE {word},PR[5]", positions=(P1,))
    pose = text[text.index("\tX =") : text.index("};")]
    axes = ",\n".join(f"\tJ{n} = 10.000 deg" for n in range(1, 7))
    (loss,) = [
        x for x in converted(text.replace(pose, axes + "\n"), "tp", target).translated.losses if x.leaves_out
    ]
    assert (loss.line, loss.says) == (7, "an offset from a position that is given by axis values")


# --- 6: names that differ in case ---------------------------------------------------------------------------


@pytest.mark.parametrize("target", ["rapid", "tp", "inform", "urscript"])
def test_a_call_in_another_case_names_its_routine(target):
    text = "\r\n".join(["DEF PART ( )", "mysub()", "GOTO over", "WAIT SEC 9", "OVER:", "END", "DEF MySub()",
                        "WAIT SEC 2", "END", ""])  # fmt: skip
    plan = run_elsewhere(text, "krl", target)
    assert plan.durations.tolist() == [2.0]


# --- 7: the advance run -------------------------------------------------------------------------------------


def advance(*between):
    first, second, third = poses((900, 0, 600), (900, 100, 600), (900, 100, 500))
    return krl("DECL BOOL B", *HOME, first, f"{second} C_DIS", *between, third)


def blends(plan):
    return [plan.moves.blend_code[plan.row[n]] for n in range(len(plan)) if plan.kind[n] == StepKind.MOVE]


@pytest.mark.parametrize(
    "between",
    [("$OUT[3]=TRUE",), ("B=$IN[1]",), ("IF $IN[1] THEN", "B=TRUE", "ENDIF"), ("PULSE ($OUT[1],TRUE,0.5)",),
     ("WAIT SEC 0",), ("WAIT FOR $IN[2]",), ("CONTINUE", "B=TRUE", "$OUT[3]=TRUE")],
)  # fmt: skip
@pytest.mark.parametrize("target", ["rapid", "tp", "inform", "urscript"])
def test_what_stops_the_advance_run_stops_the_arm_in_both(between, target):
    text = advance(*between)
    for plan in (read(text, "krl").plan(robot=ROBOT), run_elsewhere(text, "krl", target)):
        assert blends(plan)[2] == BlendCode.EXACT


@pytest.mark.parametrize(
    "between",
    [("CONTINUE", "$OUT[3]=TRUE"), ("CONTINUE", "; closes", "$OUT[3]=TRUE"), ("B=TRUE",), ("$FLAG[1]=TRUE",)],
)
def test_what_does_not_stop_the_advance_run_keeps_the_blend(between):
    text = advance(*between)
    assert blends(read(text, "krl").plan(robot=ROBOT))[2] != BlendCode.EXACT
    if "FLAG" not in between[0]:
        assert blends(run_elsewhere(text, "krl", "rapid"))[2] != BlendCode.EXACT


# --- 8: clocks ----------------------------------------------------------------------------------------------


def test_a_clock_is_never_another_controllers_timer():
    data = (*TARGETS, "VAR clock c;")
    text = module("ClkStart c;", "MoveL p2,v100,fine,tool0;", "x:=ClkRead(c);", data=data)
    assert "$TIMER[1]/1000.0" in "".join(code(translated(text, "rapid", "krl"), ";"))
    text = krl("DECL REAL X", "$TIMER[1]=0", "X=$TIMER[1]/1000", "IF $TIMER[1]>2500 THEN", "HALT", "ENDIF")
    assert "ClkRead(clock1)>2.5" in "".join(code(translated(text, "krl", "rapid"), "!"))
    assert "TIMER[1]>2.5" in "".join(code(translated(text, "krl", "tp"), "!"))
    for target in ("inform", "urscript"):
        assert set(refused(text, "krl", target)) >= {3, 4, 5}


@pytest.mark.parametrize(
    ("rows", "written"),
    [
        (("$TIMER[1]=0", "$TIMER_STOP[1]=FALSE"), ["ClkReset", "ClkStart"]),
        (("$TIMER_STOP[1]=FALSE", "WAIT SEC 1", "$TIMER[1]=0"), ["ClkStart", "ClkReset", "ClkStart"]),
        (("$TIMER_STOP[1]=TRUE", "WAIT SEC 1", "$TIMER[1]=0"), ["ClkStop", "ClkReset"]),
    ],
)
def test_a_clock_that_is_set_to_0_goes_on_as_before(rows, written):
    text = "".join(code(translated(krl(*rows), "krl", "rapid"), "!"))
    assert re.findall(r"Clk\w+", text) == written


def test_a_clock_that_runs_on_some_ways_alone_is_refused():
    rows = ("IF $IN[1] THEN", "$TIMER_STOP[1]=FALSE", "ENDIF", "$TIMER[1]=0", "WAIT SEC 1")
    assert list(refused(krl(*rows), "krl", "rapid")) == [5]


@pytest.mark.parametrize("target", ["krl", "tp", "inform", "urscript"])
def test_robots_of_several_tasks_never_move_together_elsewhere(target):
    text = module("IF IsSyncMoveOn() THEN", "WaitTime 2;", "ELSE", "WaitTime 1;", "ENDIF")
    assert run_elsewhere(text, "rapid", target).durations.tolist() == [1.0]
    told = [loss for loss in losses(text, "rapid", target) if "IsSyncMoveOn is FALSE" in loss.says]
    assert [loss.fate for loss in told] == [Fate.APPROXIMATED]


# --- settings from variables -------------------------------------------------------------------------------


@pytest.mark.parametrize("target", ["krl", "tp", "urscript"])
def test_what_is_set_from_a_variable_is_set_again_when_it_has_changed(target):
    data = (
        *TARGETS,
        "VAR speeddata v:=[100,500,5000,1000];",
        "PERS tooldata t:=[TRUE,[[0,0,100],[1,0,0,0]],[1,[0,0,1],[1,0,0,0],0,0,0]];",
    )
    rows = (
        "MoveL p1,v,fine,t;", "v.v_tcp:=50;", "MoveL p2,v,fine,t;", "FOR i FROM 1 TO 2 DO", "Incr v.v_tcp;",
        "MoveL Offs(p1,0,20*i,0),v,fine,t;", "ENDFOR",
        "t:=[TRUE,[[0,0,50],[1,0,0,0]],[1,[0,0,1],[1,0,0,0],0,0,0]];", "MoveL p2,v,fine,t;",
    )  # fmt: skip
    text = module(*rows, data=data)
    one, other = read(text, "rapid").plan(robot=ROBOT), run_elsewhere(text, "rapid", target)
    assert compare_plans(one, other).differences == []
    # The tool shows in the axes below the wrist, which stands in one of two ways.
    ends = [plan.positions.axes[plan.moves.target[-1]][:3] for plan in (one, other)]
    assert ends[0] == pytest.approx(ends[1], abs=1e-6)


# --- components that one language has ------------------------------------------------------------------------


@pytest.mark.parametrize("target", ["krl", "tp", "inform", "urscript"])
def test_components_of_one_language_alone_are_refused(target):
    data = (
        *TARGETS,
        "PERS tooldata t:=[TRUE,[[0,0,100],[1,0,0,0]],[1,[0,0,1],[1,0,0,0],0,0,0]];",
        'PERS wobjdata w:=[FALSE,TRUE,"",[[0,0,0],[1,0,0,0]],[[0,0,0],[1,0,0,0]]];',
        "VAR robtarget p:=[[900,0,400],[0,1,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];",
    )
    rows = (
        "p.trans.x:=5;",
        "p.rot.q1:=x;",
        "t.tframe.rot.q2:=x;",
        "w.uframe.trans.x:=x;",
        "w.oframe.trans.x:=x;",
        "x:=t.tload.mass;",
    )
    text = module(*rows, "x:=p.robconf.cf1;", "MoveL p,v100,fine,t\\WObj:=w;", data=data)
    lines = [
        n for n, line in enumerate(text.splitlines(), 1) if line.strip() in (*rows[1:], "x:=p.robconf.cf1;")
    ]
    assert set(refused(text, "rapid", target)) >= set(lines)


@pytest.mark.parametrize("target", ["krl", "tp", "inform", "urscript"])
def test_axes_computed_with_a_tool_and_a_frame_are_refused(target):
    data = (*TARGETS, "VAR jointtarget j;", "VAR robtarget p;")
    text = module("j:=CalcJointT(p1,tool0);", "p:=CalcRobT(j,tool0\\WObj:=wobj0);", data=data)
    lines = [n for n, line in enumerate(text.splitlines(), 1) if "Calc" in line]
    assert set(refused(text, "rapid", target)) >= set(lines)


def test_axes_are_computed_with_the_tool_and_the_frame_that_are_named():
    data = (
        *TARGETS,
        "PERS tooldata t:=[TRUE,[[0,0,100],[1,0,0,0]],[1,[0,0,1],[1,0,0,0],0,0,0]];",
        'PERS wobjdata w:=[FALSE,TRUE,"",[[30,20,10],[1,0,0,0]],[[0,0,0],[1,0,0,0]]];',
        "VAR jointtarget j;",
        "VAR robtarget p;",
    )
    text = module(
        "MoveJ p2,v100,fine,tool0;",
        "MoveJ p1,v100,fine,t\\WObj:=w;",
        "MoveJ p2,v100,fine,tool0;",
        "j:=CalcJointT(p1,t\\WObj:=w);",
        "MoveAbsJ j,v100,fine,t\\WObj:=w;",
        "MoveJ p2,v100,fine,tool0;",
        "p:=CalcRobT(j,t\\WObj:=w);",
        "MoveJ p,v100,fine,t\\WObj:=w;",
        data=data,
    )
    plan = read(text, "rapid").plan(robot=ROBOT)
    axes = plan.positions.axes[plan.moves.target]
    assert np.abs(axes[[3, 5]] - axes[1]).max() < 1e-6


@pytest.mark.parametrize("target", ["krl", "tp", "urscript"])
def test_a_position_with_the_configuration_and_the_axes_of_another_one_is_translated(target):
    data = (*TARGETS, "VAR robtarget p;")
    rows = (
        "p:=[[p1.trans.x+5,p1.trans.y,p1.trans.z],p1.rot,p1.robconf,p1.extax];",
        "p.robconf:=p2.robconf;",
        "p.extax:=p2.extax;",
        "MoveL p,v100,fine,tool0;",
        "MoveL [[p1.trans.x,p1.trans.y+5,p1.trans.z],[0,1,0,0],p1.robconf,p1.extax],v100,fine,tool0;",
    )
    text = module(*rows, data=data)
    made = converted(text, "rapid", target)
    assert not [loss for loss in made.translated.losses if loss.leaves_out and loss.fate is not Fate.EXACT]
    told = {loss.line for loss in made.translated.losses if "configuration" in loss.says + loss.part}
    assert told == {
        n for n, line in enumerate(text.splitlines(), 1) if line.strip() in (rows[0], rows[1], rows[4])
    }


def test_axes_beside_the_arm_that_are_set_are_not_left_out():
    data = (*TARGETS, "VAR robtarget p;")
    text = module("p.extax.eax_a:=x;", "p.extax:=p2.extax;", "MoveL p,v100,fine,tool0;", data=data)
    assert refused(text, "rapid", "krl")


def test_both_points_of_an_arc_are_put_into_registers_of_their_own_in_tp():
    text = module(
        "MoveJ p1,v100,fine,tool0;",
        "MoveC Offs(p1,50,50,x),Offs(p1,100,0,x),v100,fine,tool0;",
        data=TARGETS,
    )
    lines = code(translated(text, "rapid", "tp"), "!")
    (at,) = [n for n, line in enumerate(lines) if re.search(r"\bC PR\[", line)]
    via, target = (re.search(r"PR\[(\d+)\]", lines[n])[1] for n in (at, at + 1))
    assert via != target
    assert any(f"PR[{via}]=P[" in line for line in lines[:at])
    assert any(f"PR[{target}]=P[" in line for line in lines[:at])


@pytest.mark.parametrize("target", ["krl", "tp", "inform", "urscript"])
def test_a_move_with_a_process_is_made_without_it_and_is_not_proven(target):
    data = (*TARGETS, "PERS welddata w:=[10,0,[5,0,24,120,0,0,0,0,0],[0,0,0,0,0,0,0,0,0]];")
    text = module(
        "MoveJ p1,v100,fine,tool0;",
        "ArcLStart p1,v100,s,w\\Weave:=v,fine,tool0;",
        "ArcLEnd p2,v100,s,w,fine,tool0;",
        "SpotL p1,v100,g,sp,tool0;",
        data=data,
    )
    lines = [n for n, line in enumerate(text.splitlines(), 1) if line.startswith(("Arc", "Spot"))]
    made = converted(text, "rapid", target)
    found = {loss.line: loss for loss in made.translated.losses if loss.part == PROCESS}
    assert list(found) == lines
    assert {loss.fate for loss in found.values()} == {Fate.APPROXIMATED}
    source = read(text, "rapid")
    runs = runs_of(source, made, target, (ROBOT, None))
    told = verdict_of(made.translated, runs, ()).objections
    assert {(one.kind, one.line) for one in told} >= {("left-out", line) for line in lines}


@pytest.mark.parametrize("option", ["\\Corr", "\\T1:=x"])
def test_what_a_process_does_to_the_way_is_refused_with_its_move(option):
    text = module(f"ArcLEnd p2,v100,s,w,fine,tool0{option};", data=TARGETS)
    assert refused(text, "rapid", "krl")


@pytest.mark.parametrize("word", ["GripLoad load0;", "gripload load0;", "MotionSup\\Off;", "ActUnit STN1;"])
def test_what_each_controller_sets_in_its_own_way_is_a_comment_that_is_told(word):
    made = converted(module(word, "MoveJ p1,v100,fine,tool0;", data=TARGETS), "rapid", "krl")
    found = [loss for loss in made.translated.losses if loss.line == 6]
    assert [loss.fate for loss in found] == [Fate.APPROXIMATED]


@pytest.mark.parametrize("target", ["krl", "inform", "tp", "urscript"])
def test_an_exclusive_or_is_written_in_every_language(target):
    data = ("VAR bool a:=TRUE;", "VAR num n:=2;")
    for n, waits in ((2, 0.0), (1, 3.0)):
        text = module(f"n:={n};", "IF a XOR n=2 THEN", "WaitTime 3;", "ENDIF", data=data)
        assert not [x for x in losses(text, "rapid", target) if x.leaves_out]
        plan = run_elsewhere(text, "rapid", target)
        assert plan.durations.sum() == pytest.approx(waits)


@pytest.mark.parametrize("target", ["krl", "inform", "tp"])
def test_axes_of_a_pose_are_not_computed_by_a_function_that_takes_more(target):
    text = script("q = get_inverse_kin(p[0.4,0.2,0.4,0,3.14,0])", "movej(q)")
    assert refused(text, "urscript", target)


def test_axes_of_a_pose_are_not_computed_with_the_flange_where_a_tool_holds():
    rows = ("q = get_inverse_kin(p[0.4,0.2,0.4,0,3.14,0])", "movej(q)")
    assert not [x for x in losses(script(*rows), "urscript", "rapid") if x.fate is not Fate.APPROXIMATED]
    assert refused(script("set_tcp(p[0,0,0.1,0,0,0])", *rows), "urscript", "rapid")


def test_a_position_with_an_axis_that_tp_has_no_number_for_is_refused_alone():
    far = "[[900,0,400],[0,1,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,1063.4]]"
    text = module("MoveL p1,v100,fine,tool0;", f"MoveL {far},v100,fine,tool0;", data=TARGETS)
    lost = [loss.line for loss in losses(text, "rapid", "tp") if loss.fate is Fate.COMMENTED]
    assert lost == [next(n for n, line in enumerate(text.splitlines(), 1) if "1063" in line)]


# --- 10: whole numbers --------------------------------------------------------------------------------------


@pytest.mark.parametrize("target", ["rapid", "urscript", "tp"])
def test_what_becomes_an_int_is_rounded(target):
    rows = (
        "DECL INT N",
        "DECL REAL X",
        "X=2.5",
        "N=X*1.1",
        "WAIT SEC N",
        "N=7/2",
        "WAIT SEC N",
        "N=0.3*X",
        "WAIT SEC N",
    )
    text = krl(*rows)
    assert read(text, "krl").plan().durations.tolist() == [3.0, 3.0, 1.0]
    assert run_elsewhere(text, "krl", target).durations.tolist() == [3.0, 3.0, 1.0]


# --- 11: pulses ---------------------------------------------------------------------------------------------


def test_a_pulse_longer_than_krl_takes_is_refused():
    text = module("PulseDO\\High\\PLength:=5,do1;", "PulseDO\\High\\PLength:=3,do1;")
    assert list(refused(text, "rapid", "krl")) == [3]


# --- 12: elements of external axes --------------------------------------------------------------------------


def test_an_element_of_a_station_is_no_place_in_space():
    assert 10 in refused(inform("SETE EX117 (1) D015"), "inform", "krl")


# --- 13: a speed of nothing ---------------------------------------------------------------------------------


@pytest.mark.parametrize("target", ["krl", "tp", "inform", "urscript"])
def test_a_move_without_speed_is_refused(target):
    data = ("CONST speeddata v0:=[0,500,5000,1000];", *TARGETS)
    text = module(
        "MoveJ p1,v100,fine,tool0;", "MoveJ p2,v0,fine,tool0;", "MoveL p1,v0,fine,tool0;", data=data
    )
    assert set(refused(text, "rapid", target)) == {8, 9}
    assert not [x for x in losses(text, "rapid", target) if x.unit == "%" and x.size > 1000]


# --- 14: comments -------------------------------------------------------------------------------------------


@pytest.mark.parametrize("target", ["krl", "tp", "inform", "urscript"])
def test_every_comment_behind_a_block_is_still_there(target):
    words = [f"word{n}x" for n in range(14)]
    rows = [
        "WHILE x>0 DO", "x:=x-1;", "ENDWHILE", "TEST x", "CASE 1:", "x:=2;", "DEFAULT:", "ENDTEST", "IF x=0 THEN",
        "x:=1;", "ELSE", "ENDIF", "FOR i FROM 1 TO 2 DO", "ENDFOR",
    ]  # fmt: skip
    text = module(
        *(f"{row} ! {word}" for row, word in zip(rows, words, strict=True)), data=("VAR num x:=2;",)
    )
    made = translated(text, "rapid", target)
    assert [word for word in words if word not in made] == []


def test_a_program_of_script_keeps_its_comments_too():
    assert "kept" in translated(script("while (True): # kept", "  break", "end"), "urscript", "tp")


# --- offsets from where the arm stands ----------------------------------------------------------------------


@pytest.mark.parametrize("target", ["rapid", "urscript"])
def test_a_step_along_the_tool_turns_as_it_did(target):
    text = krl(*HOME, *poses((900, 0, 600)), "LIN_REL {X 10,Y 0,Z 0,A 20,B 30,C 0} #TOOL")
    plan, other = read(text, "krl").plan(robot=ROBOT), run_elsewhere(text, "krl", target)
    ends = [p.positions.quaternion[p.moves.target[-1]] for p in (plan, other)]
    assert math.isclose(abs(float(ends[0] @ ends[1])), 1.0, abs_tol=1e-9)


# --- 9: types -----------------------------------------------------------------------------------------------


def test_the_state_of_an_input_becomes_what_the_variable_is():
    rows = ("DECL BOOL B", "B=$IN[139]", "$OUT[1]=$IN[2]", "IF B==$IN[4] THEN", "WAIT SEC 1", "ENDIF")
    made = code(translated(krl(*rows), "krl", "rapid"), "!")
    assert "B:=di139=1;" in made
    assert "IF B=(di4=1) THEN" in made
    made = code(
        translated(inform("DIN B000 IN#(1)", "DOUT OT#(2) B000", "SET B001 B000"), "inform", "krl"), ";"
    )
    assert made[made.index("IF $IN[1]==TRUE THEN") :][1:4] == ["B0=1", "ELSE", "B0=0"]
    assert "$OUT[2]=B0<>0" in made
    assert "B1=B0" in made


def test_a_tool_of_a_routine_stands_in_the_module():
    rows = (*HOME, "T1={X 0,Y 0,Z 100,A 0,B 0,C 0}", "$TOOL=T1", *poses((900, 0, 600)))
    made = translated(krl("DECL FRAME T1", *rows), "krl", "rapid")
    assert made.index("PERS tooldata") < made.index("PROC PART()")
    assert "PERS" not in made[made.index("PROC PART()") :]


def test_a_variable_that_holds_joint_values_and_a_pose_is_refused():
    points = ["///TOOL 0", "///POSTYPE ROBOT", "///RECTAN", f"///RCONF {','.join('0' * 24)}"]
    points += ["P00040=900.000,0.000,400.000,180.0000,0.0000,0.0000"]
    text = inform("MOVJ P040 VJ=10.00", "GETS PX040 $PX000", points=points)
    for target in ("krl", "rapid"):
        assert list(refused(text, "inform", target)) == [16]
    assert "=$AXIS_ACT" not in "".join(code(translated(text, "inform", "krl"), ";"))


def test_decimals_that_are_rounded_to_are_kept():
    text = module("x:=Round(2.345\\Dec:=1);", "WaitTime x;", data=TARGETS)
    made = translated(text, "rapid", "urscript")
    assert "olp_round(2.345 * 10) / 10" in made
    assert run_elsewhere(text, "rapid", "urscript").durations.tolist() == pytest.approx([2.3])


def test_a_program_that_begins_with_an_output_has_no_continue_before_it():
    text = module("SetDO do1,1;", "MoveL p2,v100,z10,tool0;", "SetDO do2,1;", data=TARGETS)
    made = code(translated(text, "rapid", "krl"), ";")
    assert made[made.index("$OUT[1]=TRUE") - 1] != "CONTINUE"
    assert made[made.index("$OUT[2]=TRUE") - 1] == "CONTINUE"


def test_what_follows_an_exact_stop_elsewhere_waits_for_the_arm():
    """CONTINUE there would switch the output while the arm is still on its way to that stop."""
    rows = ("MoveL p1,v100,fine,tool0;", "grip;", "MoveL p2,v100,z10,tool0;", "SetDO do1,1;")
    rows += ("IF di1=1 THEN", "MoveL p1,v100,fine,tool0;", "ENDIF", "SetDO do2,1;")
    text = module(*rows, data=TARGETS).replace(
        "ENDMODULE", "PROC grip()\r\nSetDO do3,1;\r\nENDPROC\r\nENDMODULE"
    )
    made = converted(text, "rapid", "krl")
    lines = code("\n".join(data.decode() for data in made.files.values()), ";")
    assert lines[lines.index("$OUT[1]=TRUE") - 1] == "CONTINUE"
    assert lines[lines.index("$OUT[2]=TRUE") - 1] == "ENDIF"  # the arm stands or passes the corner
    assert lines[lines.index("$OUT[3]=TRUE") - 1].startswith("DEF grip")
    told = {loss.line: loss.says for loss in made.translated.losses if loss.part in ("order", "blend")}
    assert "advance run" in told[9]
    assert "exact stop" in told[8]


# --- what begins with zero -----------------------------------------------------------------------------------


def test_what_begins_with_zero_has_a_zero_where_a_variable_begins_without_a_value():
    """KRL stops at a variable that was never set; a num of RAPID and a register of FANUC are zero."""
    rows = (
        "VAR num i;",
        "VAR num late;",
        "WHILE i<3 DO",
        "i:=i+1;",
        "ENDWHILE",
        "late:=i;",
        "x:=late+all{2}+share;",
    )
    data = (*TARGETS, "VAR num all{3};", "VAR num share;", "VAR bool ready;")
    made = converted(module(*rows, "IF ready Stop;", data=data), "rapid", "krl")
    lines = code("\n".join(data.decode() for data in made.files.values()), ";")
    assert [row for row in lines if row.startswith(("all[", "DECL REAL share", "DECL BOOL ready"))] == [
        "all[2]=0",
        "DECL REAL share=0",
        "DECL BOOL ready=FALSE",
    ]
    assert lines[lines.index("WHILE i<3") - 1] == "i=0"
    assert "late=0" not in lines
    asked = " ".join(f"{says}: {things}" for says, things in made.translated.asks.items())
    assert "set these back before each start, as they keep their values from run to run: ('x',)" in asked


def test_registers_have_values_in_a_list_and_the_receipt_asks_for_them():
    made = converted(
        tp("R[2]=R[R[1]]+R[7]", "L P[1] 100mm/sec FINE", positions=((1, 0, 1, *P1[3:]),)), "tp", "krl"
    )
    lines = code("\n".join(data.decode() for data in made.files.values()), ";")
    assert sum(row.startswith("R[") and row.endswith("]=0") for row in lines) == 200


# --- position registers -------------------------------------------------------------------------------------


@pytest.mark.parametrize("target", ["krl", "rapid", "urscript"])
def test_sums_of_position_registers_are_computed_element_by_element(target):
    """No language but FANUC's and INFORM's adds positions with a sign; the sums are those of the elements."""
    one, other = (1, 0, 1, 400, 100, 300, 170, 10, 20), (2, 0, 1, 10, 20, 30, 4, 5, 6)
    rows = ("PR[3]=P[1]+P[2]", "PR[4]=PR[3]-P[2]", "PR[4]=P[2]+PR[4]", "PR[5]=LPOS-LPOS", "PR[5]=PR[5]+PR[4]")
    head = ("UFRAME_NUM=0", "UTOOL_NUM=1", "J P[1] 10% FINE")
    ends = []
    for text in ((*rows, "L PR[5] 100mm/sec FINE"), ("L P[3] 100mm/sec FINE",)):
        places = (one, other, (3, 0, 1, 410, 120, 330, 174, 15, 26))
        plan = run_elsewhere(tp(*head, *text, positions=places), "tp", target)
        last = plan.moves.target[plan.row[plan.kind == StepKind.MOVE][-1]]
        ends.append([*plan.positions.position[last], *np.abs(plan.positions.quaternion[last])])
    assert ends[0] == pytest.approx(ends[1], abs=1e-6)
    assert ends[0][:3] == pytest.approx([0.41, 0.12, 0.33], abs=1e-6)


def test_what_needs_an_input_that_is_not_read_any_more_is_named():
    text = inform("DIN B010 IG#(30)", "IFTHENEXP B009=B010", "DOUT OT#(1) ON", "ENDIF")
    made = converted(text, "inform", "urscript").translated
    assert any("which 'DIN B010 IG#(30)' sets" in loss.says for loss in made.losses if loss.line == 11)


@pytest.mark.parametrize("target", ["krl", "rapid", "urscript", "inform"])
def test_a_register_that_is_read_before_it_is_set_is_named(target):
    """It is set further down, for the next round: in the first one the arm would go to the frame's origin."""
    rows = (
        "LBL[1]",
        "J PR[5] 10% FINE",
        "R[3]=R[2]",
        "R[4]=1",
        "R[7]=R[4]",
        "PR[5]=P[1]",
        "R[2]=2",
        "JMP LBL[1]",
    )
    made = converted(tp(*rows, positions=((1, 0, 1, *P1[3:]),)), "tp", target).translated
    asked = {
        says: things for says, things in made.asks.items() if "set these" in says or "teach these" in says
    }
    assert [len(things) for things in asked.values()] == [1, 1], asked  # PR[5] and R[2], not R[4]


def test_a_message_is_no_longer_than_the_pendant_takes():
    """FANUC's MESSAGE takes 24 characters, Yaskawa's MSG 32."""
    text = module('TPWrite "Feeder empty, add parts to feeder and press PB1";')
    said = [row for row in translated(text, "rapid", "tp").splitlines() if "MESSAGE" in row]
    assert [row.split("[")[1].rstrip("] ;") for row in said] == [
        "Feeder empty, add parts",
        "to feeder and press PB1",
    ]


def test_a_register_that_only_an_operator_sets_is_no_zero_in_another_register():
    made = converted(inform("SET P001 P000", "ADD P001 P002", "MOVL P001 V=100.0 PL=0"), "inform", "tp")
    text = b"".join(made.files.values()).decode()
    assert "PR[2,1:PV1]=PR[2,1:PV1]+PR[3,1:PV2]" in text
    assert any("PV2" in names for names in made.translated.asks.values())


# --- moves that stop otherwise, and work that moves ---------------------------------------------------------


@pytest.mark.parametrize("target", ["krl", "tp", "inform", "urscript"])
def test_data_of_a_stop_point_take_the_place_of_the_zone(target):
    text = module("MoveL p1,v100,z10\\Inpos:=inpos50,tool0;", "MoveL p2,v100,z10,tool0;", "MoveL p1,v100,fine,tool0;",
                  data=TARGETS)  # fmt: skip
    for plan in (read(text, "rapid").plan(robot=ROBOT), run_elsewhere(text, "rapid", target)):
        assert [code == BlendCode.EXACT for code in blends(plan)] == [True, False, True]
    waits = text.replace("inpos50", "stoptime0_5")
    assert "Inpos" in refused(waits, "rapid", target)[6]


@pytest.mark.parametrize("target", ["krl", "tp", "inform", "urscript"])
def test_a_move_that_follows_a_conveyor_is_no_move_to_where_it_was(target):
    frame = '[FALSE,FALSE,"{}",[[0,0,0],[1,0,0,0]],[[0,0,0],[1,0,0,0]]];'
    data = (
        *TARGETS,
        f"PERS wobjdata belt:={frame.format('CNV1')}",
        f"PERS wobjdata desk:={frame.format('')}",
    )
    rows = ("MoveL p1,v100,fine,tool0\\WObj:=belt;", "MoveL p2,v100,fine,tool0\\WObj:=desk;")
    assert list(refused(module(*rows, data=data), "rapid", target)) == [8]


# --- what a statement that is left out takes with it --------------------------------------------------------


@pytest.mark.parametrize("target", ["inform", "urscript"])
def test_moves_in_a_frame_whose_choice_is_left_out_are_left_out_too(target):
    rows = (
        *HOME,
        "$BASE=BASE_DATA[1]",
        *poses((1200, 0, 800)),
        "$BASE=BASE_DATA[n]",
        *poses((1200, 90, 800)),
        "$BASE=BASE_DATA[1]",
        *poses((1200, 0, 800)),
    )
    made = converted(krl("INT n", "n=2", "IF $IN[3] THEN", "n=3", "ENDIF", *rows), "krl", target)
    lost = {loss.line: loss.says for loss in made.translated.losses if loss.fate is Fate.COMMENTED}
    assert list(lost) == [13, 14]
    assert "it needs the frame that '$BASE=BASE_DATA[n]' sets" in lost[14]


# --- inline forms of splines --------------------------------------------------------------------------------

FORM = (
    ";FOLD SLIN P1 Vel=0.5 m/s CPDAT1 Tool[2]:grip Base[3] ;%{PE}",
    "SLIN XP1 WITH $VEL=SVEL_CP(0.5, ,LCPDAT1),$TOOL=STOOL2(FP1),$BASE=SBASE(FP1.BASE_NO),"
    "$IPO_MODE=SIPO_MODE(FP1.IPO_FRAME),$LOAD=SLOAD(FP1.TOOL_NO),$ACC=SACC_CP(LCPDAT1),"
    "$ORI_TYPE=SORI_TYP(LCPDAT1),$APO=SAPO(LCPDAT1),$JERK=SJERK(LCPDAT1)",
    ";ENDFOLD",
)


def with_list(*rows):
    return krl("E6POS XP1", "XP1={X 900,Y 0,Z 400,A 0,B 90,C 0}", *rows, *FORM)


def test_a_form_without_its_list_has_the_tool_and_base_of_its_caption():
    text = translated(with_list(*HOME), "krl", "tp")
    rows = [row.partition(":")[2].strip(" ;") for row in text.splitlines() if "NUM=" in row]
    assert rows[-2:] == ["UFRAME_NUM=3", "UTOOL_NUM=2"]


@pytest.mark.parametrize(
    "data", ["DECL LDAT LCPDAT1={VEL 2.0,ACC 100.0,APO_DIST 0.0,ORI_TYP #CONSTANT}", "$ORI_TYPE=#CONSTANT"]
)
def test_a_move_that_keeps_the_tool_as_it_was_is_refused(data):
    told = refused(krl(data, *HOME, *with_list().splitlines()[1:-1]), "krl", "rapid")
    assert any("ORI_TYPE" in says for says in told.values())


def test_form_data_that_keep_the_tool_as_it_was_are_refused():
    data = "DECL LDAT LP1={VEL 2.0,ACC 100.0,APO_DIST 0.0,ORI_TYP #CONSTANT}"
    rows = ("LDAT_ACT=LP1", "BAS(#CP_DAT)", *poses((900, 0, 400)))
    assert any("ORI_TYPE" in says for says in refused(krl(data, *HOME, *rows), "krl", "rapid").values())


# --- speeds -------------------------------------------------------------------------------------------------


def test_a_speed_that_is_guessed_as_the_way_is_not_known_is_a_loss():
    text = tp(
        "R[1]=1", "IF R[1]=2,JMP LBL[1]", "JMP LBL[2]", "LBL[1]", "J P[1] 40% FINE", "LBL[2]", positions=(P1,)
    )
    says = [loss.says for loss in losses(text, "tp", "rapid") if loss.part == "speed"]
    assert says == ["this run does not show its path: 40 % is taken for 400 mm/s"]


def test_the_way_of_a_move_behind_an_input_is_that_of_the_run_with_it_on():
    rows = ("J P[1] 100% FINE", "IF DI[1]=OFF,JMP LBL[2]", "J P[2] 40% FINE", "LBL[2]")
    plan = read(tp(*rows, positions=(P1, P2)), "tp").plan(robot=ROBOT)
    assert len(plan.moves) == 1
    assert not [x for x in losses(tp(*rows, positions=(P1, P2)), "tp", "rapid") if "does not show" in x.says]


def test_a_joint_move_that_turns_the_tool_in_its_place_has_a_speed_of_its_own():
    rows = (
        "movej([0, -1.2, 1.2, -1.5, -1.57, 0], a=1, v=1)",
        "movej([0, -1.2, 1.2, -1.5, -1.57, 1.5], a=1, v=0.5)",
    )
    found = code(translated(script(*rows), "urscript", "rapid"), "!")
    speeds = [row for row in found if row.startswith("CONST speeddata")]
    assert speeds
    assert not [row for row in speeds if ":=[0," in row or ",0,5000" in row]


@pytest.mark.parametrize("target", ["tp", "inform"])
def test_a_speed_in_a_variable_of_urscript_is_counted_in_the_targets_unit(target):
    rows = (
        "v = 0.1",
        "movej([0, -1.2, 1.2, -1.5, -1.57, 0], a=1, v=1)",
        "movel(p[0.7, 0.1, 0.4, 0, 3.14, 0], a=1, v=v)",
        "movel(p[0.7, 0.3, 0.4, 0, 3.14, 0], a=1, v=v)",
    )
    plan = run_elsewhere(script(*rows), "urscript", target)
    assert [round(float(v), 4) for v in plan.moves.travel[1:]] == [0.1, 0.1]


# --- URScript's windows and settings ------------------------------------------------------------------------


def test_a_window_that_is_not_waited_for_is_a_message_and_settings_are_no_loss():
    rows = ("set_gravity([0, 0, 9.82])", 'popup("part", title="cell", warning=False)', "sleep(1)")
    made = converted(script(*rows), "urscript", "rapid")
    assert not [loss for loss in made.translated.losses if loss.fate is not Fate.EXACT]
    assert 'TPWrite "part";' in translated(script(*rows), "urscript", "rapid")
    one, other = (
        read(script(*rows), "urscript").plan(robot=ROBOT),
        run_elsewhere(script(*rows), "urscript", "rapid"),
    )
    assert compare_plans(one, other, without={2}).is_equal


# --- angles that are set one by one -------------------------------------------------------------------------


@pytest.mark.parametrize("target", ["rapid", "urscript"])
def test_angles_that_are_set_one_by_one_are_one_turn(target):
    rows = ("E6POS p", "p={X 900,Y 0,Z 400,A 0,B 0,C 0}", *HOME, "p.A=10", "p.B=90", "p.C=p.C+20", "LIN p")
    one, other = read(krl(*rows), "krl").plan(robot=ROBOT), run_elsewhere(krl(*rows), "krl", target)
    assert compare_plans(one, other).worst_angle < 1e-6


def test_an_angle_that_reads_one_set_before_is_set_on_its_own():
    rows = ("E6POS p", "p={X 900,Y 0,Z 400,A 0,B 30,C 0}", *HOME, "p.A=10", "p.B=p.A+5", "p.C=7", "LIN p")
    found = [row for row in code(translated(krl(*rows), "krl", "rapid"), "!") if "OrientZYX" in row]
    assert found == [
        "p.rot:=OrientZYX(10,EulerZYX(\\Y,p.rot),EulerZYX(\\X,p.rot));",
        "p.rot:=OrientZYX(EulerZYX(\\Z,p.rot),EulerZYX(\\Z,p.rot) + 5,7);",
    ]


def test_parts_of_a_frame_of_rapid_stand_in_its_user_frame():
    rows = ("FRAME b", "b={X 10,Y 0,Z 0,A 0,B 0,C 0}", *HOME, "b.A=5", "$BASE=b", *poses((900, 0, 400)))
    text = translated(krl(*rows), "krl", "rapid")
    assert "b.uframe.rot:=OrientZYX(5," in text
    assert "b.rot" not in text


# --- routines that leave the speed to their caller ----------------------------------------------------------


@pytest.mark.parametrize("target", ["rapid", "tp", "urscript"])
def test_a_move_without_a_speed_gets_a_slow_one_and_a_loss(target):
    text = krl("PTP {A1 0,A2 -90,A3 90,A4 0,A5 40,A6 0}", *poses((900, 0, 400)))
    says = [loss.says for loss in losses(text, "krl", target) if "takes its caller's" in loss.says]
    assert [one.rpartition(": ")[2] for one in says] == ["10 %", "250 mm/s"]
    assert [float(v) for v in run_elsewhere(text, "krl", target).moves.travel[1:]] == [0.25]


def test_a_joint_move_from_where_the_arm_cannot_be_stays_a_move():
    rows = (*HOME, *poses((9000, 0, 400)), "PTP {A1 0,A2 -90,A3 90,A4 0,A5 40,A6 0}")
    made = converted(krl(*rows), "krl", "rapid")
    assert not [loss for loss in made.translated.losses if loss.fate is Fate.COMMENTED]


# --- registers that a statement would have set which is left out --------------------------------------------


def test_what_needs_a_register_that_is_not_set_any_more_is_named():
    rows = ("GETS PX000 $PX000", "CNVRT PX000 PX000 UF#(1)", "SUB PX000 PX001", "MOVL P000 V=100.0")
    found = losses(inform(*rows), "inform", "urscript")
    assert {
        loss.line for loss in found if "it needs" in loss.says and "'SUB PX000 PX001' sets" in loss.says
    } == {13}


def test_what_is_set_anew_before_a_move_does_not_lack_what_was_lost_before_or_is_lost_behind_it():
    rows = (
        "pT:=p1;", "pT.trans:=PoseVect(pose1,pT.trans);", "MoveL pT,v100,fine,tool0;", "pT:=p2;",
        "MoveL pT,v100,fine,tool0;", "x:=pT.trans.x;", "WHILE x>0 DO", "MoveL pT,v50,fine,tool0;",
        "pT.trans:=PoseVect(pose1,pT.trans);", "x:=x-1;", "ENDWHILE", "WaitTime x;",
    )  # fmt: skip
    found = losses(module(*rows, data=(*TARGETS, "VAR robtarget pT;", "VAR pose pose1;")), "rapid", "krl")
    first = 8
    needs = {loss.line - first for loss in found if "it needs" in loss.says}
    assert {loss.line - first for loss in found if loss.leaves_out} >= {1, 2, 7, 8}
    assert needs == {2, 7}


# --- arrays of several dimensions ---------------------------------------------------------------------------

TABLES = (
    "VAR num g{2,3}:=[[1,2,3],[4,5,6]];",
    "VAR robtarget q{2,2};",
    "CONST robtarget a:=[[900,0,400],[0,1,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];",
)


@pytest.mark.parametrize("target", ["tp", "inform", "urscript", "krl"])
def test_an_array_of_rows_is_one_row_where_there_is_no_other(target):
    rows = (
        "MoveJ a,v1000,fine,tool0;",
        "FOR i FROM 1 TO 2 DO",
        "FOR j FROM 1 TO 2 DO",
        "q{i,j}:=a;",
        "q{i,j}.trans.y:=10*i+g{i,j+1};",
        "MoveL q{i,j},v500,fine,tool0;",
        "ENDFOR",
        "ENDFOR",
        "g{2,3}:=g{1,2}+1;",
        "WaitTime g{2,3}/10;",
    )
    text = module("VAR num i;", "VAR num j;", *rows, data=TABLES)
    one, other = read(text, "rapid").plan(robot=ROBOT), run_elsewhere(text, "rapid", target)
    assert compare_plans(one, other).is_equal
    assert compare_plans(one, other).steps == 6


HANDED = """MODULE M
PERS num g{2,3}:=[[1,2,3],[4,5,6]];
CONST robtarget a{2}:=[[[900,0,400],[0,1,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]],
  [[800,70,450],[0,1,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]]];
VAR robtarget p;
PROC fill(num n, INOUT num table{*,*})
  FOR k FROM 1 TO 3 DO
    table{2,k}:=n*k+table{1,k};
  ENDFOR
  again table;
ENDPROC
PROC again(INOUT num rows{*,*})
  rows{1,3}:=rows{2,1};
ENDPROC
PROC main()
  MoveJ a{1},v1000,fine,tool0;
  fill 10,g;
  p:=a{1};
  p.trans.y:=g{2,3}+g{1,3};
  p.trans.z:=a{2}.trans.z;
  MoveL p,v500,fine,tool0;
  WaitTime g{2,1+g{1,1}}/100;
ENDPROC
ENDMODULE
"""


@pytest.mark.parametrize("target", ["tp", "inform", "urscript", "krl"])
def test_a_table_is_handed_over_and_back_through_several_routines(target):
    one, other = read(HANDED, "rapid").plan(robot=ROBOT), run_elsewhere(HANDED, "rapid", target)
    assert compare_plans(one, other).is_equal
    # by hand: y is 10*3+3+11, as `again` copied 10*1+1; the wait is of 10*2+2
    assert (1000 * other.positions.position[other.moves.target[1]]).round(3).tolist() == [900, 44, 450]
    assert other.durations[other.row[other.kind == StepKind.WAIT]].round(6).tolist() == [0.22]


def test_computed_targets_share_one_position_variable_in_inform():
    """There are 128 of them."""
    offsets = [(10.5 * n, -7 * n, 2 * n) for n in range(1, 66)]
    moves = [f"MoveL Offs(p,{x},{y},{z}),v500,fine,tool0;" for x, y, z in offsets]
    moves += [f"MoveL Offs(p,{x}*0.5,-{z}*2,0),v500,fine,tool0;" for x, _, z in offsets]
    text = module("p:=a;", *moves, data=("VAR robtarget p;", TABLES[2]))
    other = run_elsewhere(text, "rapid", "inform")
    assert compare_plans(read(text, "rapid").plan(robot=ROBOT), other).is_equal
    there = [(900 + x, y, 400 + z) for x, y, z in offsets] + [
        (900 + x / 2, -2 * z, 400) for x, _, z in offsets
    ]
    found = 1000 * other.positions.position[other.moves.target]
    assert found.round(3).tolist() == [pytest.approx(place) for place in there]
    made = converted(text, "rapid", "inform").files
    assert all(b" * 1000" not in job for job in made.values())


def test_a_joint_move_by_an_offset_is_no_imov():
    """IMOV is a straight move: the place is computed in the base, where the position is read."""
    rows = (*HOME[1:], *poses((900, 0, 400)), "PTP_REL {Z -30,Y 20}")
    base = (HOME[0], "$TOOL=$NULLFRAME", "$BASE=$NULLFRAME")
    other = run_elsewhere(krl(*base, *rows), "krl", "inform")
    assert (1000 * other.positions.position[other.moves.target[-1]]).round(3).tolist() == [900, 20, 370]
    made = converted(krl(*base, *rows), "krl", "inform").files
    (job,) = made.values()
    assert b"IMOV" not in job
    assert b"MOVJ P" in job
    elsewhere = (*base[:2], "$BASE={X 500,Y 0,Z 0,A 0,B 0,C 0}")
    assert any(
        "in another frame than the base" in one.says
        for one in losses(krl(*elsewhere, *rows), "krl", "inform")
    )


def test_a_loop_that_only_waits_is_no_jump():
    text = krl("REPEAT", "UNTIL $IN[2]", "REPEAT", ";hold", "UNTIL $IN[3]", "WAIT SEC 0.3")
    made = translated(text, "krl", "rapid")
    assert "GOTO" not in made
    assert code(made, "!")[2:6] == ["WHILE di2=0 DO", "ENDWHILE", "WHILE di3=0 DO", "ENDWHILE"]


def test_an_element_beyond_one_of_the_rows_is_refused():
    text = module("WaitTime g{1,4};", data=TABLES)
    with pytest.raises(OlpError, match="3 elements"):
        converted(text, "rapid", "tp", on_loss="error")


# --- what a program leaves to its caller --------------------------------------------------------------------


@pytest.mark.parametrize(
    ("text", "vendor", "asks"),
    [
        (krl(*HOME[1:], *poses((900, 0, 400))), "krl", True),
        (krl(*HOME, *poses((900, 0, 400))), "krl", False),
        (krl("$TOOL=$NULLFRAME", "$BASE=$NULLFRAME", *HOME, *poses((900, 0, 400))), "krl", False),
        (script("movej([0, -1.2, 1.2, -1.5, -1.57, 0], a=1, v=1)"), "urscript", True),
        (module("MoveL p1,v100,fine,tool0;", data=TARGETS), "rapid", False),
    ],
)
def test_the_receipt_asks_for_a_tool_that_the_program_leaves_to_its_caller(text, vendor, asks):
    made = converted(text, vendor, "tp")
    assert any("which tool was active" in says for says in made.translated.asks) is asks


def test_a_speed_of_another_axis_than_the_first_is_told_of_a_spline_move():
    row = "SPTP {A1 0,A2 -90,A3 90,A4 0,A5 40,A6 0} WITH $VEL_AXIS[1]=30, $VEL_AXIS[2]=20"
    said = [loss.says for loss in losses(krl("BAS(#INITMOV,0)", row), "krl", "rapid")]
    assert any("the option $VEL_AXIS[2] means nothing in RAPID" in one for one in said)


def test_the_axes_of_a_spline_move_accelerate_alike_when_it_is_written_again():
    row = "SPTP {A1 0,A2 -90,A3 90,A4 0,A5 40,A6 0} WITH $ACC_AXIS[1]=SACC_JOINT(PDEFAULT)"
    text = translated(krl("BAS(#INITMOV,0)", row), "krl", "krl")
    assert all(f"$ACC_AXIS[{axis}]=100" in text for axis in range(1, 7))


def test_a_routine_of_the_maker_that_moves_nothing_is_a_comment():
    text = translated(krl(*HOME, "SET_CD_PARAMS(0)", *poses((900, 0, 400))), "krl", "rapid")
    assert "! not translated: SET_CD_PARAMS(0)" in text


@pytest.mark.parametrize("target", ["krl", "inform"])
def test_the_time_of_a_move_that_goes_nowhere_is_told_where_it_is_lost(target):
    text = module("MoveJ p1,v100,fine,tool0;", "MoveL p1,v100\\T:=3,fine,tool0;", data=TARGETS)
    assert any(
        "takes 3 s for it: here it takes no time" in loss.says for loss in losses(text, "rapid", target)
    )
    assert not any("takes 3 s" in loss.says for loss in losses(text, "rapid", "tp"))


@pytest.mark.parametrize("target", ["krl", "tp", "inform", "urscript"])
def test_numbers_of_fifteen_digits_are_told(target):
    text = module("VAR dnum near:=0;", "far:=4294967295;", "near:=far;", data=("VAR dnum far:=0;", *TARGETS))
    said = {loss.line for loss in losses(text, "rapid", target) if "15 digits" in loss.says}
    assert said == {2, 7}
    assert not [loss for loss in losses(text, "rapid", "rapid") if "15 digits" in loss.says]


def test_a_turned_target_of_a_joint_move_leaves_the_arm_to_kuka():
    told = {
        loss.line
        for loss in losses(
            module(
                "MoveJ RelTool(p1,0,0,-50),v100,fine,tool0;",
                "MoveJ Offs(p1,0,0,50),v100,fine,tool0;",
                data=TARGETS,
            ),
            "rapid",
            "krl",
        )
        if "arm configuration is left to the controller" in loss.says
    }
    assert told == {6}


@pytest.mark.parametrize("target", ["inform", "tp", "urscript"])
@pytest.mark.parametrize(
    ("call", "refused_there"), [("grow x;", True), ("add_to x,x;", True), ("add_to x,y;", False)]
)
def test_a_variable_that_a_routine_reaches_in_two_ways_is_no_copy(target, call, refused_there):
    text = (
        "MODULE M\r\nVAR num x:=1;\r\nVAR num y:=1;\r\nPROC main()\r\n" + call + "\r\nENDPROC\r\n"
        "PROC grow(INOUT num a)\r\nx:=x+1;\r\na:=a+x;\r\nENDPROC\r\n"
        "PROC add_to(INOUT num a,INOUT num b)\r\na:=a+1;\r\nb:=b+a;\r\nENDPROC\r\nENDMODULE\r\n"
    )
    said = [loss for loss in losses(text, "rapid", target) if "reaches x in another way" in loss.says]
    assert bool(said) is refused_there
    assert not [loss for loss in losses(text, "rapid", "krl") if "in another way" in loss.says]


# --- comments about routines --------------------------------------------------------------------------------

KRL_REMARKS = (
    "&ACCESS RVP\r\n; author\r\nDEF PART(n :IN) ; head\r\nDECL INT n ; how many\r\nBAS(#INITMOV,0)\r\n"
    "PTP {A1 0,A2 -90,A3 90,A4 0,A5 40,A6 0}\r\nTRIGGER WHEN DISTANCE=0 DELAY=20 DO $OUT[3]=TRUE ; glue\r\n"
    "LIN {X 900,Y 0,Z 400,A 0,B 90,C 0}\r\nEND ; tail\r\n; behind\r\n"
)
RAPID_REMARKS = (
    "MODULE M\r\n! author\r\nPROC main() ! head\r\nVAR num n; ! how many\r\nn:=1; ! glue\r\nENDPROC ! tail\r\n"
    "! behind\r\nPROC other()\r\nn:=n+1;\r\nENDPROC\r\nENDMODULE\r\n"
)


@pytest.mark.parametrize("target", ["krl", "rapid", "tp", "inform", "urscript"])
@pytest.mark.parametrize(("text", "vendor"), [(KRL_REMARKS, "krl"), (RAPID_REMARKS, "rapid")])
def test_comments_about_a_routine_are_kept(text, vendor, target):
    wanted = {"author", "head", "how many", "glue", "tail", "behind"}
    if vendor == "rapid" and target in ("tp", "inform"):
        wanted.remove("how many")  # of a variable, which is a register there
    made = translated(text, vendor, target)
    assert {one for one in wanted if one not in made} == set()


def test_comments_about_a_routine_stay_in_their_places_in_krl():
    lines = translated(KRL_REMARKS, "krl", "krl").splitlines()
    assert "; author" in lines
    assert "DEF PART (n :IN) ; head" in lines
    assert lines[-2:] == ["END ; tail", "; behind"]


# --- records of a program's own types -----------------------------------------------------------------------

RECORDS = (
    "RECORD part",
    "num count;",
    "robtarget place;",
    "speeddata v;",
    "bool done;",
    "ENDRECORD",
    "RECORD cell",
    "part one;",
    "num list;",
    "ENDRECORD",
    "PERS part p_a:=[3,[[900,0,400],[0,1,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]],[100,500,5000,1000],FALSE];",
    "VAR part p_b;",
    "VAR part p_list{2};",
    "VAR cell c1;",
)


def with_records(*rows):
    lines = ["MODULE M", *RECORDS, "PROC main()", "VAR num i;", *rows, "ENDPROC"]
    return "\r\n".join(
        [*lines, "PROC go(part x)", "MoveL x.place,v100,fine,tool0;", "ENDPROC", "ENDMODULE", ""]
    )


@pytest.mark.parametrize("target", ["krl", "tp", "inform", "urscript"])
def test_records_are_one_variable_for_each_member(target):
    text = with_records(
        "p_b:=p_a;",
        "p_b.place.trans.y:=50*p_a.count;",
        "p_a.v:=[200,500,5000,1000];",
        "MoveL p_a.place,p_a.v,fine,tool0;",
        "c1.one:=p_b;",
        "FOR i FROM 1 TO 2 DO",
        "p_list{i}:=c1.one;",
        "p_list{i}.place.trans.y:=10*i;",
        "MoveL p_list{i}.place,p_a.v,fine,tool0;",
        "ENDFOR",
        "go p_b;",
        "IF NOT p_b.done WaitTime c1.one.count;",
    )
    made = converted(text, "rapid", target)
    assert not [loss for loss in made.translated.losses if loss.leaves_out and loss.fate is not Fate.EXACT]
    one, other = read(text, "rapid").plan(robot=ROBOT), run_elsewhere(text, "rapid", target)
    found = compare_plans(one, other)
    assert found.steps == 5
    assert found.worst_position < 1e-6
    assert not [x for x in found.found if x.part not in ("speed",)]


def test_a_record_that_is_returned_and_compared_as_a_whole_stays_refused():
    lines = ["MODULE M", *RECORDS, "PROC main()", "IF made()=p_b WaitTime p_b.count;", "ENDPROC"]
    lines += ["FUNC part made()", "RETURN p_a;", "ENDFUNC", "ENDMODULE", ""]
    assert "a record of the type part as a whole" in "".join(
        refused("\r\n".join(lines), "rapid", "krl").values()
    )


# --- programs of other languages that ended in a traceback, or in a text that the target does not take --------


@pytest.mark.parametrize(
    ("text", "vendor", "target", "says"),
    [
        (script("x = 2", "sleep(struct(a=x, b=3).a)"), "urscript", "rapid", "without a name"),
        (krl("DECL FRAME F,G", "DECL INT I", "I=2", "F=G:{X 1,Y I}"), "krl", "inform", "omitted"),
        (krl("DECL E6POS P1", "LIN P1:{Z 5}"), "krl", "rapid", "omitted"),
        (tp("UTOOL[R[1]]=PR[2]"), "tp", "inform", "assigned"),
        (tp("R[2]=VR[1].MODELID"), "tp", "rapid", "word VR[1].MODELID"),
    ],
)
def test_what_the_target_has_no_words_for_is_refused_with_its_line(text, vendor, target, says):
    told = refused(text, vendor, target)
    assert any(says in message for message in told.values()), told
    assert 0 not in told


def test_exclusive_or_is_written_where_a_language_has_it():
    assert "EXOR" in translated(script("x = True", "y = False", "z = x xor y"), "urscript", "krl")


def test_words_for_expressions_follow_the_condition_and_not_the_words_of_the_other_language():
    program = read_source(decode(b".PROGRAM part()\nSWAIT 1007,-1008\n.END\n", "part.as"), vendor="as")
    made = convert(program, "inform", Context(robot=ROBOT))
    assert b"WAIT FOREXPRESS IN#(7)=ON ANDEXP IN#(8)=OFF" in b"".join(made.files.values())


def test_both_points_of_a_relative_arc_are_relative():
    rows = (*HOME, *poses((900, 0, 400)), "CIRC_REL {X 5,Y 5},{X 10}")
    found = [line for line in code(translated(krl(*rows), "krl", "rapid"), "!") if "MoveC" in line]
    assert found
    assert all(line.count("CRobT") == 2 for line in found)


def test_a_frame_without_a_value_is_written_as_one_that_stands():
    text = (
        b"PROGRAM part\nVAR f : POSITION\n p : POSITION\nBEGIN\n $UFRAME := f\n MOVE LINEAR TO p\nEND part\n"
    )
    made = convert(read_source(decode(text, "part.pdl"), vendor="pdl2"), "rapid", Context(on_loss="comment"))
    assert b'f:=[FALSE,TRUE,"",' in b"".join(made.files.values())


def test_a_number_beside_a_text_is_made_a_text():
    text = b'.PROGRAM part()\nn = 2\nPRINT "n=",n\n.END\n'
    made = convert(read_source(decode(text, "part.as"), vendor="as"), "rapid", Context(robot=ROBOT))
    assert b'TPWrite "n="\\Num:=n;' in b"".join(made.files.values())


# --- arithmetic and counters ------------------------------------------------------------------------------------


@pytest.mark.parametrize("target", ["krl", "rapid", "urscript"])
def test_integers_of_inform_are_divided_towards_zero(target):
    rows = ["MOVJ C00000 VJ=50.00 PL=0", "SET D000 -7", "DIV D000 2", "ADD D000 10", "SET B000 D000"]
    rows += ["TIMER T=B000", "SET D001 7", "DIV D001 2", "SET B000 D001", "TIMER T=B000"]
    point = "C00000=900.000,0.000,400.000,180.0000,0.0000,0.0000"
    head = [
        "/JOB",
        "//NAME PART",
        "//POS",
        "///NPOS 1,0,0,0,0,0",
        "///TOOL 0",
        "///POSTYPE ROBOT",
        "///RECTAN",
    ]
    head += ["///RCONF 0,0,0,0,0,0,0,0", point, "//INST", "///DATE 2026/03/02 14:07", "///ATTR SC,RW"]
    text = "\r\n".join([*head, "///GROUP1 RB1", "NOP", *rows, "END", ""])
    plans = read(text, "inform").plan(robot=ROBOT), run_elsewhere(text, "inform", target)
    assert [pytest.approx([0.07, 0.03]) == plan.durations.tolist() for plan in plans] == [True, True]


def test_just_one_of_two_flags_compares_states_in_tp():
    """R[1]<>0 is a state, R[1] alone a number, which no state is compared with."""
    rows = ["DECL BOOL a,b", "a=TRUE", "b=FALSE", *HOME, "IF a EXOR b AND a THEN", "$OUT[1]=TRUE", "ENDIF"]
    assert "IF ((R[1:a]<>0)<>(R[2:b]<>0 AND R[1:a]<>0)) THEN" in translated(krl(*rows), "krl", "tp")


@pytest.mark.parametrize("target", ["krl", "rapid", "inform", "urscript"])
def test_a_counter_of_tp_ends_at_the_last_value(target):
    rows = ["L P[1] 100mm/sec FINE", "FOR R[1]=1 TO 3", "WAIT .10(sec)", "ENDFOR", "WAIT R[1]", "R[3]=2"]
    rows += ["FOR R[2]=R[3] DOWNTO 1", "WAIT .10(sec)", "ENDFOR", "WAIT R[2]"]
    text = tp(*rows, positions=((1, 0, 1, *P1[3:]),))
    for plan in (read(text, "tp").plan(robot=ROBOT), run_elsewhere(text, "tp", target)):
        assert plan.durations.tolist() == pytest.approx([0.1, 0.1, 0.1, 3.0, 0.1, 0.1, 1.0])


@pytest.mark.parametrize("target", ["tp", "rapid", "inform"])
def test_a_counter_of_krl_ends_one_step_beyond_it(target):
    rows = ["INT i", *HOME, "FOR i=1 TO 2", "WAIT SEC 0.1", "ENDFOR", "WAIT SEC i"]
    for plan in (read(krl(*rows), "krl").plan(robot=ROBOT), run_elsewhere(krl(*rows), "krl", target)):
        assert plan.durations.tolist() == pytest.approx([0.1, 0.1, 3.0])


# --- variables of a routine's own ---------------------------------------------------------------------------

OWN = """MODULE M
PROC main()
VAR num i:=5;
Count 1;
Count 2;
SetAO ao1,i;
ENDPROC
PROC Count(num by)
VAR num i:=1;
VAR num sum;
VAR pos place:=[1,2,3];
VAR num list{2};
sum:=sum+by;
i:=i+sum;
place.x:=place.x+i;
list{by}:=list{by}+i;
SetAO ao1,i;
SetAO ao2,10*place.x+list{1}+list{2};
ENDPROC
ENDMODULE
"""


@pytest.mark.parametrize("target", ["krl", "tp", "urscript"])
def test_variables_of_a_routine_begin_anew_with_each_call(target):
    plan = run_elsewhere(OWN, "rapid", target)
    set_to = [event.value for _, event in sorted(plan.events.items()) if event.kind == "set"]
    assert set_to == [2, 32, 3, 43, 5]


def test_a_routine_leaves_variables_of_its_callers_with_the_same_name_alone():
    plan = run(read(OWN, "rapid"), ROBOT)
    set_to = [event.value for _, event in sorted(plan.events.items()) if event.kind == "set"]
    assert set_to == [2, 32, 3, 43, 5]


# --- whether a wait has reached its limit -------------------------------------------------------------------


@pytest.mark.parametrize("target", ["krl", "tp", "inform", "urscript"])
@pytest.mark.parametrize("on", [0, 1])
def test_whether_a_wait_has_reached_its_limit_is_kept(target, on):
    data = ("VAR bool late;",)
    rows = ("WaitDI di1,1\\MaxTime:=1\\TimeFlag:=late;", "IF late SetDO do1,1;", "SetDO do2,1;")
    text = module(*rows, data=data)
    source = read(text, "rapid")
    given = {SignalKey(NAMED_SIGNAL, "di1"): (on,)}
    plan = run_converted(converted(text, "rapid", target), target, ROBOT, source, given)
    assert sum(event.kind == "set" for event in plan.events.values()) == 2 - on


def test_in_krl_a_truth_value_is_not_compared_with_a_number():
    rows = ("WaitDI di1,1\\MaxTime:=1\\TimeFlag:=late;", "IF late SetDO do1,1;")
    assert "late=TIMED_OUT\r\n" in translated(module(*rows, data=("VAR bool late;",)), "rapid", "krl")


# --- numbers that no file declares --------------------------------------------------------------------------


@pytest.mark.parametrize(("target", "sets"), [("tp", "R[2:n]=1.5*R[1:by]"), ("urscript", "n = 1.5 * by")])
def test_a_number_that_no_file_declares_keeps_its_fraction_where_all_numbers_are_real(target, sets):
    rows = ("FOR by FROM 1 TO 3 DO", "n:=1.5*by;", "ENDFOR", "n:=n+place{n};", "SetAO ao1,n;")
    assert sets in translated(module(*rows), "rapid", target)


# --- a line to joint values ---------------------------------------------------------------------------------

PULSES = (
    "///TOOL 0",
    "///POSTYPE PULSE",
    "///PULSE",
    "P00001=1000,0,0,0,-30000,0",
    "P00002=2000,0,0,0,-30000,0",
)


@pytest.mark.parametrize("target", ["krl", "rapid", "tp", "urscript"])
def test_a_line_to_a_variable_in_pulses_goes_to_the_pose_that_they_reach(target):
    text = inform("MOVJ P001 VJ=25.00 PL=0", "MOVL P002 V=100.0 PL=0", "MOVL P001 V=50.0 PL=0", points=PULSES)
    assert not [loss for loss in losses(text, "inform", target) if loss.leaves_out]
    here, there = read(text, "inform").plan(robot=ROBOT), run_elsewhere(text, "inform", target)
    found = compare_plans(here, there)
    assert found.steps == 3
    assert not found.found


@pytest.mark.parametrize("target", ["krl", "rapid"])
def test_a_line_to_joint_values_that_a_statement_sets_is_rejected(target):
    rows = ("MOVJ P001 VJ=25.00 PL=0", "SET P002 P001", "MOVL P002 V=100.0 PL=0")
    assert 17 in refused(inform(*rows, points=PULSES), "inform", target)


# --- elements of tables -------------------------------------------------------------------------------------


@pytest.mark.parametrize("target", ["tp", "inform", "urscript"])
def test_elements_of_a_constant_table_of_positions_by_computed_numbers(target):
    places = [
        f"CONST robtarget p{n}:=[[{890 + n},0,400],[0,1,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];"
        for n in (1, 2)
    ]
    tool = "PERS tooldata t1:=[TRUE,[[0,0,50],[1,0,0,0]],[1,[0,0,1],[1,0,0,0],0,0,0]];"
    data = (
        *places,
        tool,
        "CONST robtarget all{2,2}:=[[p1,p2],[p2,p1]];",
        "VAR num order{2}:=[2,1];",
        "VAR num k;",
    )
    rows = (
        "FOR i FROM 1 TO 2 DO",
        "k:=order{i};",
        "MoveL all{i,k},v100,fine,t1;",
        "MoveL all{order{i},1},v100,fine,t1;",
    )
    text = module(*rows, "MoveL Offs(all{k,i},0,0,order{i}),v100,fine,t1;", "ENDFOR", data=data)
    made = converted(text, "rapid", target)
    assert not [one for one in made.translated.losses if one.leaves_out]
    here, there = read(text, "rapid").plan(robot=ROBOT), run_elsewhere(text, "rapid", target)
    found = compare_plans(here, there)
    assert found.steps == 5
    assert found.worst_position < 1e-4


# --- the end of the program -------------------------------------------------------------------------------


ENDS = """MODULE M
VAR num n:=1;
PROC main()
part;
SetAO ao1,2;
ENDPROC
PROC part()
SetAO ao1,1;
IF n=1 EXIT;
SetAO ao1,3;
ENDPROC
ENDMODULE
"""


def set_to(plan):
    return [event.value for _, event in sorted(plan.events.items())]


def test_nothing_runs_behind_the_end_of_the_program():
    assert set_to(run(read(ENDS, "rapid"), ROBOT)) == [1]
    listing = tp("AO[1]=1", "ABORT", "AO[1]=3")
    assert set_to(run(read(listing, "tp"), ROBOT)) == [1]


@pytest.mark.parametrize("target", ["tp", "urscript"])
def test_a_routine_that_ends_the_program_does_so_there(target):
    assert not [one for one in converted(ENDS, "rapid", target).translated.losses if one.leaves_out]
    assert set_to(run_elsewhere(ENDS, "rapid", target)) == [1]


def test_fanucs_abort_is_rapids_exit():
    listing = tp("AO[1]=1", "IF R[1]=0,JMP LBL[1]", "ABORT", "LBL[1]", "AO[1]=3")
    assert "EXIT;" in translated(listing, "tp", "rapid")


# --- decimals -----------------------------------------------------------------------------------------------


def test_trunc_keeps_as_many_decimals_as_it_says():
    rows = [f"SetAO ao1,Trunc({x}\\Dec:=2);" for x in (12.3456, -12.3456, 0.29)]
    values = set_to(run(read(module(*rows, "SetAO ao1,Trunc(-2.7);"), "rapid"), ROBOT))
    assert values == [12.34, -12.34, 0.29, -2]


@pytest.mark.parametrize("target", ["krl", "tp", "urscript"])
def test_a_number_from_a_rounded_position_is_the_same_number(target):
    turned = 'PERS wobjdata wT:=[FALSE,TRUE,"",[[10,20,30],[0.966,0,0,0.259]],[[0,0,0],[1,0,0,0]]];'
    data = (*TARGETS, "VAR robtarget here;", turned)
    rows = ("MoveL p2,v100,fine,tool0\\WObj:=wT;", "here:=CRobT(\\Tool:=tool0\\WObj:=wobj0);")
    text = module(*rows, "SetAO ao1,here.trans.x/7;", data=data)
    here, there = read(text, "rapid").plan(robot=ROBOT), run_elsewhere(text, "rapid", target)
    assert not [x for x in compare_plans(here, there).found if x.part == "signal"]


# --- types that RAPID's compiler takes ----------------------------------------------------------------------


def test_a_work_object_is_taken_for_a_position_or_a_tool_by_its_frame_in_rapid():
    rows = ("global plane = p[1,2,3,0,0,1]", "p1 = p[0.4,0.1,0.2,0,3,0]", "movel(pose_trans(plane, p1))")
    rows += ("x = pose_add(plane, p1)", "movel(x)")
    written = translated(script(*rows), "urscript", "rapid")
    assert "PERS wobjdata plane" in written
    text = script(*rows, "set_tcp(plane)", "movel(p1)")
    assert "a tool that is a work object" in refused(text, "urscript", "rapid")[8]
    assert re.search(r"olp_robtarget\d:=\[plane.uframe.trans,plane.uframe.rot,", written)


def early(body):
    counted = ("FUNC bool counted(num y)", *body, "RETURN y>1;", "ENDFUNC")
    return module("IF n>5 AND counted(2) THEN", "WaitTime 1;", "ENDIF", data=("VAR num n:=0;", *counted))


@pytest.mark.parametrize("target", ["inform", "krl", "tp", "urscript"])
def test_a_call_that_rapid_leaves_out_behind_a_decided_condition_is_told(target):
    told = [loss.says for loss in losses(early(["n:=n+1;"]), "rapid", target)]
    assert any("does not call counted where what stands before it decides" in reason for reason in told)


@pytest.mark.parametrize("target", ["inform", "krl", "tp", "urscript"])
def test_a_call_that_changes_nothing_is_no_loss_behind_a_decided_condition(target):
    told = [loss.says for loss in losses(early([]), "rapid", target)]
    assert not any("does not call" in reason for reason in told)


# --- Text that no compiler takes ----------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("target", "rows"),
    [
        (
            "rapid",
            ['"n "\\Num:=n;', '"b "\\Bool:=b;', '"s "\\Bool:=di2=1;', '"t " + t;', "TPWrite ValToStr(n);"],
        ),
        (
            "krl",
            [
                '"%g",TEXT_VALUE)',
                'temp_string[]="TRUE"',
                "IF $IN[2]==TRUE THEN",
                "StrAdd(TEXT_WHOLE[],t_1[])",
            ],
        ),
        ("inform", ['CAT$ S002 "n " S001', "IFTHEN B000<>0", "IFTHEN IN#(2)=ON", 'CAT$ S001 "t " S000']),
    ],
)
def test_values_that_a_message_shows_are_made_texts(target, rows):
    """URScript's textmsg takes any value: numbers and states were joined with texts as if they were such."""
    shown = ["n = 3", "b = True", 't = "abc"', 'textmsg("n ", n)', 'textmsg("b ", b)']
    text = translated(
        script(*shown, 'textmsg("s ", get_standard_digital_in(2))', 'textmsg("t ", to_str(t))', "textmsg(n)"),
        "urscript",
        target,
    )
    for row in rows:
        assert row in text


def test_a_message_of_tp_names_the_signal_that_it_shows():
    assert "MESSAGE[s <in 2>]" in translated(
        script('textmsg("s ", get_standard_digital_in(2))'), "urscript", "tp"
    )


FUNCTION_OF_A_SIGNAL = (
    "def part():\n  def shut(go):\n    set_digital_out(1, go)\n    return get_digital_in(2)\n  end\n"
    "  shut(True)\n  shut(get_digital_in(3))\n  if shut(False):\n    sleep(1)\n  end\nend\n"
)


@pytest.mark.parametrize(
    ("target", "rows"),
    [
        (
            "rapid",
            ["VAR bool unused_boolean;", "unused_boolean:=shut(TRUE);", "shut(di3=1);", "RETURN di2=1;"],
        ),
        ("krl", ["unused_boolean=shut (TRUE)", "unused_boolean=shut ($IN[3])", "RETURN $IN[2]"]),
    ],
)
def test_a_function_that_is_called_for_what_it_does_gives_its_result_to_a_variable(target, rows):
    text = translated(FUNCTION_OF_A_SIGNAL, "urscript", target)
    for row in rows:
        assert row in text


def test_a_first_value_stands_behind_its_declaration_and_never_behind_a_later_one():
    """`ok` was set to FALSE behind the declaration of `i`, after it had been set."""
    rows = ["if get_digital_in(1):", "  ok = True", "end", "i = 0", "while i < 2:", "  i = i + 1", "end"]
    text = translated(script("ok = False", *rows, "set_digital_out(3, ok)"), "urscript", "krl")
    assert text.count("ok=FALSE") == 1
    call = ["def part():", "  def f():", "    return get_digital_in(1)", "  end", "  n = 0", "  while n < 2:"]
    call += ["    ok = f()", "    n = n + 1", "  end", "  i = 0", "  set_digital_out(3, ok)", "end", ""]
    text = translated("\n".join(call), "urscript", "krl")
    assert text.index("DECL BOOL ok") < text.index("ok=FALSE") < text.index("ok=f ()")


@pytest.mark.parametrize("target", ["rapid", "krl", "tp", "inform"])
def test_whole_numbers_below_and_above_are_computed_where_the_target_has_no_word(target):
    rows = [
        "x = -2.5",
        "sleep(floor(7 / 2))",
        "sleep(ceil(x) + 4)",
        "sleep(floor(x) + 4)",
        "sleep(ceil(2.0))",
    ]
    assert not [x for x in losses(script(*rows), "urscript", target) if x.leaves_out]
    assert run_elsewhere(script(*rows), "urscript", target).durations.tolist() == [3.0, 2.0, 1.0, 2.0]


def test_what_a_variable_begins_with_is_a_constant_in_rapid():
    """VAR takes constant expressions alone; a signal is no truth value there."""
    text = translated(script("n = 5", "m = n + 1", "s = get_digital_in(2)", "sleep(m)"), "urscript", "rapid")
    for row in ("VAR num n:=5;", "VAR num m;", "m:=n + 1;", "VAR bool s;", "s:=di2=1;"):
        assert row in text


# --- order of evaluation ------------------------------------------------------------------------------------

INC = ("FUNC num inc(num k)", "n:=n+k;", "RETURN n;", "ENDFUNC")
FAR = ("FUNC num far(num k)", "RETURN Abs(k-3*n)+Abs(n-7*k);", "ENDFUNC")


@pytest.mark.parametrize("target", ["inform", "tp"])
@pytest.mark.parametrize(
    "rows",
    [
        ("x:=n+inc(2);",),
        ("x:=Max(n,inc(2));",),
        ("x:=inc(1)+n+inc(2);",),
        ("IF n<2 AND inc(2)>0 THEN", "x:=4;", "ENDIF"),
        ("IF n>2 XOR inc(2)>2 THEN", "x:=5;", "ENDIF", "x:=x+n;"),
        ("x:=far(1)+far(5);",),
        ("FOR i FROM 1 TO far(n)-5 DO", "x:=x+Abs(n-7)+Abs(n+1);", "ENDFOR"),
    ],
)
def test_what_stands_left_of_a_call_is_read_before_it(rows, target):
    text = module(*rows, "WaitTime x;", data=("VAR num x:=0;", "VAR num n:=1;", *INC, *FAR))
    here, there = read(text, "rapid").plan(), run_elsewhere(text, "rapid", target)
    assert here.durations.sum() > 0
    assert here.durations.sum() == pytest.approx(there.durations.sum())


def test_an_output_beside_a_move_that_is_not_waited_for_is_no_part_of_it():
    """`MoveLDO \\\\Conc` is no instruction, and would switch at the end of the move."""
    points = ["///TOOL 0", "///POSTYPE BASE", "///RECTAN", "///RCONF 0,0,0,0,0,0,0,0"]
    points += [f"C0000{n}=900.000,{y}.000,400.000,180.0000,0.0000,0.0000" for n, y in ((0, 0), (1, 200))]
    rows = ["MOVJ C00000 VJ=50.00 PL=0", "MOVL C00001 V=300.0 PL=2 NWAIT", "DOUT OT#(5) ON"]
    text = translated(inform(*rows, points=points), "inform", "rapid")
    assert re.search(r"MoveL \\Conc,P1,v300,z\w+,tool0;\s+SetDO do5,1;", text)


@pytest.mark.parametrize(("target", "rows"), [("krl", "n=0\r\nm[1]=1\r\nm[2]=2\r\n"), ("rapid", "n:=0;")])
def test_variables_that_each_run_of_a_script_sets_first_do_not_go_on_where_the_last_run_stopped(target, rows):
    up = ("def up():", "n = n + 1", "m[1] = m[0] + n", "end")
    text = translated(
        script("global n = 0", "global m = [1, 2]", *up, "up()", "if n > 1:", "sleep(m[1])", "end"),
        "urscript",
        target,
    )
    assert rows in re.sub(r"\n +", "\n", text)


def test_a_pulse_that_inverts_is_told_where_the_program_switches_the_output_on():
    rows = ("SetDO doLamp,1;", "PulseDO\\PLength:=0.5,doLamp;", "PulseDO\\PLength:=0.5,doOther;")
    told = [loss.line for loss in losses(module(*rows), "rapid", "krl") if loss.part == "option"]
    assert told == [4]


@pytest.mark.parametrize("target", ["inform", "tp"])
def test_a_remainder_for_a_group_of_outputs_is_computed_before(target):
    text = module("n:=37;", "SetGO goState,n MOD 16;", "WaitTime n MOD 5;", data=("VAR num n:=0;",))
    here, there = read(text, "rapid").plan(), run_elsewhere(text, "rapid", target)
    assert [e.value for plan in (here, there) for e in plan.events.values()] == [5.0, 5.0]
    assert here.durations.sum() == pytest.approx(there.durations.sum()) == 2.0


def test_an_element_of_a_position_is_added_to_in_counts():
    """What `D001 / 1000` is of whole numbers is published nowhere."""
    text = module(
        "x:=x+5;", "p1.trans.x:=p1.trans.x+x-50;", "MoveL p1,v100,fine,tool0;", data=TARGETS
    ).replace("CONST", "VAR")
    written = translated(text, "rapid", "inform")
    assert re.search(r"SET (D\d+)  EXPRESS D\d+ \+ R\d+ \* 1000 - 50000", written)


def test_a_shift_in_the_axes_of_the_tool_with_a_turn_that_is_written_out():
    text = module("x:=20;", "MoveL RelTool(p1,0,x,-2*x\\Rx:=10\\Rz:=15),v100,fine,tool0;", data=TARGETS)
    plan, other = read(text, "rapid").plan(robot=ROBOT), run_elsewhere(text, "rapid", "inform")
    assert compare_plans(plan, other, speeds=False, blends=False).is_equal


def test_an_override_that_each_run_of_the_source_begins_without_is_asked_for():
    text = module("VelSet 50,5000;", "MoveL p1,v100,fine,tool0;", data=TARGETS)
    made = converted(text, "rapid", "krl")
    assert any("the override, to 100 %" in things for things in made.translated.asks.values())


def test_a_computed_speed_bounds_the_turning_as_the_source_does():
    rows = ("$VEL.ORI1=90", "x=$OV_PRO", "$VEL.CP=x*0.01", "LIN {X 900,Y 0,Z 400,A 0,B 90,C 0}")
    text = translated(krl("DECL REAL x", *HOME, *rows), "krl", "rapid")
    assert re.search(r"MoveL .*,v1000_90\\V:=", text)
    text = translated(krl("DECL REAL x", *HOME, "x=$OV_PRO", "$VEL.ORI1=x", *rows[3:]), "krl", "rapid")
    assert re.search(r"MoveL .*,\[500,\w+,5000,1000\],", text)


BOTH = (
    "DEFFCT BOOL BOTH(N :IN,A :OUT,B :OUT)", "DECL INT N", "DECL REAL A,B",
    "IF N>2 THEN", "A=N", "RETURN FALSE", "ENDIF", "A=A+1", "B=B*2", "RETURN TRUE", "ENDFCT",
    "DEF TWICE(A :OUT,B :OUT)", "DECL REAL A,B", "DECL BOOL OK", "OK=BOTH(1,B,A)", "OK=BOTH(5,A,B)", "END",
)  # fmt: skip


@pytest.mark.parametrize("target", ["urscript", "tp", "inform", "rapid"])
def test_several_parameters_that_a_routine_hands_back(target):
    rows = ("DECL REAL X,Y", "DECL BOOL OK", "X=1", "Y=3", "OK=BOTH(1,X,Y)", "WAIT SEC X+10*Y", "TWICE(X,Y)")
    text = krl(*rows, "WAIT SEC X+10*Y") + "\r\n".join(BOTH)
    here, there = read(text, "krl").plan(), run_elsewhere(text, "krl", target)
    assert here.durations.tolist() == pytest.approx([62.0, 5.0 + 10 * 7.0])
    assert there.durations.tolist() == pytest.approx(here.durations.tolist())
    assert not [loss for loss in losses(text, "krl", target) if loss.leaves_out]


# --- texts that + joins, screens, and the place where the arm stands ----------------------------------------

SUMS = {
    "tp": tp("SR[2]='b'", "R[1]=5", "SR[1]=SR[2]+R[1]", "SR[3]=SR[1]+SR[2]"),
    "pdl2": "PROGRAM p\nVAR n : INTEGER\n  s, t : STRING[9]\nBEGIN\n  n := 5\n  s := 'b'\n  t := s + 'c'\nEND p\n",
    "as": '.PROGRAM p() #0\n  $s = "b"\n  $t = $s+"c"\n.END\n',
}


@pytest.mark.parametrize("vendor", SUMS)
@pytest.mark.parametrize("target", ["inform", "krl", "urscript"])
def test_texts_are_joined_by_what_the_target_has_for_it(vendor, target):
    """`S1[]=S2[]+R1`, `SET S001  EXPRESS S000 + D000` and `s + "c"` are no statements of these languages."""
    text = translated(SUMS[vendor], vendor, target)
    assert any(word in text for word in ("CAT$ ", "StrAdd(", "str_cat("))
    mark = {"inform": "'", "krl": ";", "urscript": "#"}[target]
    assert not [row for row in code(text, mark) if "+" in row]


def pdl2(*rows, data=()):
    body = "".join(f"  {row}\n" for row in rows)
    return f"PROGRAM p\nVAR\n  n : INTEGER\n{''.join(f'  {row}' for row in data)}BEGIN\n{body}END p\n"


def test_what_pdl2_writes_to_its_screen_is_a_text_with_values():
    """The whole of what stands in the parentheses, names and NL too, was shown word for word."""
    text = translated(pdl2("n := 3", "WRITE LUN_CRT ('n ', n::4, NL, 'done', NL)"), "pdl2", "rapid")
    assert code(text, "!")[-4:-2] == ['TPWrite "n "\\Num:=n;', 'TPWrite "done";']


def test_what_pdl2_writes_into_a_file_is_no_message():
    told = refused(pdl2("WRITE n ('x', n, NL)"), "pdl2", "rapid")
    assert list(told) == [5]


@pytest.mark.parametrize(("target", "rows"), [("inform", ("ON", "OFF")), ("tp", ("ON", "OFF"))])
@pytest.mark.parametrize("vendor", ["pdl2", "as"])
def test_outputs_are_on_or_off_and_no_numbers(vendor, target, rows):
    source = {
        "pdl2": pdl2("$DOUT[3] := ON", "$DOUT[4] := OFF"),
        "as": ".PROGRAM p() #0\n  SIGNAL 3,-4\n.END\n",
    }[vendor]
    text = translated(source, vendor, target)
    form = "DOUT OT#({}) {}" if target == "inform" else "DO[{}]={} ;"
    for number, row in zip((3, 4), rows, strict=True):
        assert form.format(number, row) in text


FRAMES = (
    "$UFRAME := POS(100, 0, 50, 90, 0, 0, '')",
    "$TOOL := POS(0, 0, 120, 0, 0, 0, '')",
    "$LIN_SPD := 0.1",
)
AWAY = (*FRAMES, "MOVE JOINT TO {0, -10, -100, 0, 45, 0}", "MOVE LINEAR AWAY 100")


@pytest.mark.parametrize("target", ["krl", "rapid", "tp", "urscript"])
def test_a_move_from_where_the_arm_stands_is_seen_in_the_frame_that_holds(target):
    """TP added millimetres to axis values, URScript took the base's pose for one in the frame."""
    text = pdl2(*AWAY, "MOVE LINEAR RELATIVE VEC(10, 0, -20) IN UFRAME")
    here, there = read(text, "pdl2").plan(robot="yaskawa/gp25"), run_elsewhere(text, "pdl2", target)
    assert compare_plans(here, there).is_equal


def test_a_position_that_inform_reads_in_the_base_is_not_taken_for_one_in_a_frame():
    assert list(refused(pdl2(*AWAY), "pdl2", "inform")) == [9]


@pytest.mark.parametrize("target", ["krl", "rapid", "tp"])
def test_a_position_and_a_vector_are_not_added(target):
    rows = ("p1 := POS(800, 100, 600, 0, 180, 0, '')", "MOVE LINEAR TO p1 + VEC(0, 0, 100)")
    assert list(refused(pdl2(*rows, data=("p1 : POSITION\n",)), "pdl2", target)) == [7]


# --- what a job can say --------------------------------------------------------------------------------------


def job(*rows, vendor="krl", names="INT n,m"):
    text = krl(f"DECL {names}", *rows) if vendor == "krl" else module(*rows)
    return code(translated(text, vendor, "inform"), "'")


@pytest.mark.parametrize(
    ("condition", "row"),
    [
        ("($IN[1] OR $IN[2]) AND $IN[3]", "ON ANDEXP IN#(3)=ON OREXP IN#(2)=ON ANDEXP IN#(3)=ON"),
        ("$IN[1] OR ($IN[2] AND $IN[3])", "IN#(2)=ON ANDEXP IN#(3)=ON OREXP IN#(1)=ON"),
    ],
)
def test_conditions_of_a_job_mean_the_same_whichever_of_and_and_or_comes_first(condition, row):
    """`IN#(1)=ON OREXP IN#(2)=ON ANDEXP IN#(3)=ON` is another condition where AND comes first."""
    assert next(one for one in job(f"WAIT FOR {condition}") if one.startswith("WAIT")).endswith(row)


def test_a_condition_of_many_parts_is_a_flag_where_its_meaning_hung_on_the_order():
    rows = job("IF ($IN[1] OR $IN[2] OR $IN[3]) AND $IN[4] THEN", "HALT", "ENDIF")
    assert "IFTHEN IN#(1)=ON ORIF IN#(2)=ON ORIF IN#(3)=ON" in rows
    assert not [row for row in rows if "ORIF" in row and "ANDIF" in row]


def test_joined_conditions_behind_a_line_have_the_words_for_expressions():
    """`JUMP *L IF a ANDIF b` is in no published job, `JUMP *L IFEXPRESS a ANDEXP b` is."""
    rows = job("REPEAT", "n=n+1", "UNTIL (n>12) OR $IN[7]")
    assert "JUMP *L1 IFEXPRESS D000<=12 ANDEXP IN#(7)=OFF" in rows


def test_a_quotient_in_a_job_has_a_side_that_is_no_whole_number():
    rows = job("VAR num a;", "a:=7/2;", "IF a>3 Stop;", vendor="rapid")
    assert "SET R000  EXPRESS 7.0 / 2.0" in rows
    rows = job("DECL POS p", "p={X 1,Y 2,Z 3,A 0,B 0,C 0}", "r=p.X", names="REAL r")
    assert [row for row in rows if row.endswith(" / 1000.0")]


def test_a_job_that_moves_by_variables_alone_has_a_control_group():
    data = (*TARGETS[:2], "PROC sub(robtarget p)", "MoveL p,v50,fine,tool0;", "ENDPROC")
    text = translated(module("MoveJ p1,v100,fine,tool0;", "sub p2;", data=data), "rapid", "inform")
    assert text.count("///GROUP1 RB1") == 2


def test_groups_of_signals_are_those_that_a_job_has():
    rows = job("SIGNAL a $OUT[17] TO $OUT[24]", "SIGNAL b $OUT[5] TO $OUT[8]", "a=200", "b=9")
    assert rows[-3:-1] == ["DOUT OG#(3) 200", "DOUT OGH#(2) 9"]


@pytest.mark.parametrize(("ends", "value"), [((1, 16), 5), ((2, 9), 5), ((17, 24), 300)])
def test_groups_of_another_size_and_numbers_beyond_a_group_are_refused(ends, value):
    """OG# has eight signals: the others were switched as well, and 300 is no value of it."""
    rows = ("SIGNAL a $OUT[{}] TO $OUT[{}]".format(*ends), f"a={value}")
    assert list(refused(krl(*rows), "krl", "inform")) == [3]


def test_the_size_of_a_group_that_no_file_tells_is_asked_for():
    made = converted(module("SetGO go1,5;"), "rapid", "inform")
    assert any("8 signals" in says for says in made.translated.asks)


@pytest.mark.parametrize(
    ("time", "row"),
    [("0.123", "TIMER T=0.12"), ("0.004", "TIMER T=0.01"), ("0", ""), ("0.5", "TIMER T=0.50")],
)
def test_times_of_a_job_are_hundredths_of_a_second(time, row):
    text = module(f"WaitTime {time};", "SetDO do1,1;")
    rows = code(translated(text, "rapid", "inform"), "'")
    assert [one for one in rows if one.startswith("TIMER")] == ([row] if row else [])
    told = [one for one in losses(text, "rapid", "inform") if one.part == "duration"]
    assert bool(told) is (time in ("0.123", "0.004"))


@pytest.mark.parametrize("target", ["inform", "krl", "rapid", "tp", "urscript"])
def test_a_wait_of_no_time_ends_the_move_before_exactly(target):
    """AS's BREAK was told as a corner in the source and a stop in the translation; `olp time` rounded it."""
    rows = ("SPEED 50 ALWAYS", "ACCURACY 10 ALWAYS", "JMOVE #a", "JMOVE #b", "BREAK", "SIGNAL 1", "JMOVE #a")
    data = ".JOINTS\n#a 0 -10 -100 0 45 0\n#b 0 -20 -90 0 45 0\n.END\n"
    text = "\n".join([".PROGRAM p() #0", *rows, ".END", data])
    here, there = read(text, "as").plan(robot="yaskawa/gp25"), run_elsewhere(text, "as", target)
    assert here.moves.blend_code.tolist()[1] == BlendCode.EXACT == there.moves.blend_code.tolist()[1]
    assert not [one for one in compare_plans(here, there).found if one.part == "blend" and one.line == 6]


def test_as_sets_its_clocks_and_teaches_where_the_arm_stands():
    rows = (
        "JMOVE #a",
        "HERE p",
        "HERE #q",
        "TIMER 1 = 0",
        "TWAIT 0.5",
        "t = TIMER(1)",
        "LMOVE p",
        "JMOVE #q",
    )
    data = ".JOINTS\n#a 0 -10 -100 0 45 0\n.END\n"
    text = translated("\n".join([".PROGRAM p() #0", *rows, ".END", data]), "as", "rapid")
    for row in (":=CRobT(", ":=CJointT();", "ClkReset clock1;", "ClkStart clock1;", "t:=ClkRead(clock1);"):
        assert row in text


# --- 30: arrays that routines take ----------------------------------------------------------------------------

ARRAYS = """DEF k ( )
INT arr[5],i
INT m[2,3]
FOR i=1 TO 5
arr[i]=i*3
ENDFOR
m[2,3]=7
halve(arr[])
more(m[,])
IF (arr[5]==7) AND (m[2,3]==8) THEN
$OUT[4]=TRUE
ENDIF
END
DEF halve (v[] :OUT)
INT v[]
INT k
FOR k=1 TO 5
v[k]=v[k]/2
ENDFOR
END
DEF more (v[,] :OUT)
INT v[,]
v[2,3]=v[2,3]+1
END
"""
OWN_ARRAYS = """MODULE m
PROC main()
VAR num arr{5};
VAR num m{2,3};
arr{4}:=12;
m{2,3}:=7;
halve arr;
more m;
IF arr{4}=6 AND m{2,3}=8 SetDO do4,1;
ENDPROC
PROC halve(INOUT num v{*})
FOR k FROM 1 TO Dim(v,1) DO
v{k}:=v{k}/2;
ENDFOR
ENDPROC
PROC more(INOUT num v{*,*})
v{Dim(v,1),Dim(v,2)}:=v{2,3}+1;
ENDPROC
ENDMODULE
"""


def _switches(text, vendor, target):
    plan = run_elsewhere(text, vendor, target)
    return sum(event.kind == "set" for event in plan.events.values())


@pytest.mark.parametrize(
    ("text", "vendor", "target", "parts"),
    [
        (ARRAYS, "krl", "rapid", ["INOUT num v{*})", "INOUT num v{*,*})", "halve arr;", "more m;"]),
        (ARRAYS, "krl", "urscript", ["arr = halve(arr)", "m = more(m)"]),
        (OWN_ARRAYS, "rapid", "krl", ["halve (arr[])", "more (m[,])", "DEF more (v[,] :OUT)", "REAL v[,]"]),
        (OWN_ARRAYS, "rapid", "urscript", ["while (k <= 5)", "v[1, 2] = v[1, 2] + 1"]),
    ],
)
def test_an_array_that_a_routine_takes_is_one_there(text, vendor, target, parts):
    written = translated(text, vendor, target)
    for part in parts:
        assert part in written
    assert _switches(text, vendor, target) == 1


@pytest.mark.parametrize("target", ["tp", "inform"])
def test_each_element_is_handed_over_where_variables_have_numbers(target):
    text = ARRAYS.replace("more(m[,])\n", "").replace("INT m[2,3]\n", "").replace("m[2,3]=7\n", "")
    text = text.replace("AND (m[2,3]==8) ", "").split("DEF more")[0]
    assert _switches(text, "krl", target) == 1


def test_an_array_that_is_handed_over_as_a_whole_comes_back_in_the_run():
    plan = run(read(ARRAYS, "krl"), ROBOT)
    assert sum(event.kind == "set" for event in plan.events.values()) == 1


def test_an_array_of_which_nothing_tells_the_size_is_not_handed_over_by_its_first_element():
    text = ARRAYS.replace("INT arr[5],i", "INT i").replace("more(m[,])\n", "")
    assert "handed over" in " ".join(refused(text, "krl", "tp").values())


# --- 31: arm flags that a variable takes over -----------------------------------------------------------------

FLAGGED = (
    "DECL E6POS P,Q",
    *HOME,
    "P={X 900,Y 0,Z 400,A 0,B 90,C 0,S 6,T 27}",
    "Q=P",
    "Q.Z=Q.Z+N",
    "PTP Q",
    "LIN P",
)


@pytest.mark.parametrize("target", ["rapid", "urscript"])
def test_arm_flags_of_a_pose_in_a_variable_are_told_where_they_are_left_out(target):
    told = [loss.line for loss in losses(krl(*FLAGGED), "krl", target) if loss.part == "configuration"]
    assert told == [len(HOME) + 6]
    plain = krl(*(row.replace(",S 6,T 27", "") for row in FLAGGED))
    assert not [loss for loss in losses(plain, "krl", target) if loss.part == "configuration"]


# --- 32: texts are compared by a function in KRL --------------------------------------------------------------


def test_texts_are_compared_by_strcomp_in_krl():
    """`==` compares no arrays of CHAR (KUKA's bas.src and integrators use StrComp)."""
    data = ('VAR string s:="part";', 'VAR string names{2}:=["a","b"];')
    rows = (
        's:=s+"x";',
        'IF s="partx" Set do1;',
        'IF s<>"b" AND names{2}="b" Set do2;',
        'TEST s CASE "q": Set do3;',
    )
    text = module(*rows, "ENDTEST", data=data)
    written = translated(text, "rapid", "krl")
    assert not re.search(r"\[\] *(==|<>)|,\] *(==|<>)", written)
    assert 'NOT StrComp(s_1[],"b",#CASE_SENS) AND StrComp(names[2,],"b",#CASE_SENS)' in written
    assert _switches(text, "rapid", "krl") == 2


def test_the_run_compares_texts_with_strcomp():
    rows = ('A[]="abc"', 'B[]="abd"', "C=StrComp(A[],B[],#CASE_SENS)", "IF NOT C THEN", "WAIT SEC 1", "ENDIF")
    assert read(krl("DECL CHAR A[9],B[9]", "DECL BOOL C", *rows), "krl").plan().durations.tolist() == [1.0]


# --- 33: signals from 0 on ------------------------------------------------------------------------------------


@pytest.mark.parametrize("target", ["krl", "tp", "inform"])
def test_a_computed_number_of_a_signal_that_may_be_0_is_told_where_signals_begin_with_1(target):
    rows = (
        "set_digital_out(0, True)",
        "i = 2",
        "while i > 0:",
        "set_digital_out(i, True)",
        "i = i - 1",
        "end",
    )
    told = [loss.line for loss in losses(script(*rows), "urscript", target) if loss.part == "index"]
    assert told == [5]
    tp_rows = ("R[1]=2", "DO[R[1]]=ON")
    assert not [x for x in losses(tp(*tp_rows, positions=(P1,)), "tp", "krl") if "is computed" in x.says]


def test_what_a_call_changes_by_reference_is_set_back_too():
    routine = "PROC more(INOUT num v{*})\r\nv{1}:=v{1}+1;\r\nENDPROC\r\n"
    text = module("more lst;", "WaitTime lst{1};", data=("VAR num lst{2}:=[1,2];",))
    text = text.replace("ENDMODULE", routine + "ENDMODULE")
    made = converted(text, "rapid", "krl")
    assert any("lst" in things for says, things in made.translated.asks.items() if "set these back" in says)


def test_sums_of_positions_in_a_job_are_added_to_a_copy():
    """`SET P003  EXPRESS P001 + P002` is in no published job; `ADD P001 P002` and `SUB P001 P002` are."""
    sums = ("PR[3]=PR[1]+PR[2]", "PR[3]=PR[1]-PR[2]", "PR[1]=PR[2]+PR[1]", "PR[1]=PR[1]-PR[2]")
    set_ = ("PR[1,1]=1", "PR[2,1]=2")
    rows = code(translated(tp(*set_, *sums), "tp", "inform"), "'")
    found = [row.split()[0] for row in rows if re.match(r"(SET|ADD|SUB) P\d+ P\d+$", row)]
    assert found == ["SET", "ADD", "SET", "SUB", "ADD", "SUB"]
    assert not [row for row in rows if "EXPRESS P" in row]


def test_a_text_of_several_parts_is_joined_by_two_at_a_time():
    data = ('VAR string a:="";', 'VAR string b:="z";')
    text = module('a:=b+"x"+b+"y";', "TPWrite a;", data=data)
    rows = code(translated(text, "rapid", "inform"), "'")
    assert [len(row.split()) for row in rows if row.startswith("CAT$")] == [4, 4, 4]


# --- 34: loops that count with the same name within one another -----------------------------------------------


@pytest.mark.parametrize("target", ["krl", "tp", "inform", "urscript"])
def test_a_loop_within_a_loop_has_a_counter_of_its_own_in_rapid(target):
    rows = ("FOR i FROM 1 TO 3 DO", "FOR i FROM 5 TO 7 DO", "x:=x+i;", "ENDFOR", "x:=x+100*i;", "ENDFOR")
    text = module(*rows, "WaitTime x;", data=TARGETS)
    for plan in (read(text, "rapid").plan(), run_elsewhere(text, "rapid", target)):
        assert plan.durations.sum() == pytest.approx(3 * 18 + 100 * 6)


def test_what_switches_on_the_way_of_a_move_that_goes_is_a_comment_too():
    rows = ("SPLINE", "SPL {X 900,Y 0,Z 400,A 0,B 90,C 0}", "TRIGGER WHEN PATH=10 DELAY=0 DO $OUT[3]=TRUE")
    rows += ("SPL {X 900,Y 50,Z 400,A 0,B 90,C 0}", "ENDSPLINE")
    text = krl(*HOME, *rows)
    assert "! not translated: TRIGGER WHEN PATH=10" in translated(text, "krl", "rapid")
    first = text[: text.index("TRIGGER")].count("\n") + 1
    assert first in {loss.line for loss in losses(text, "krl", "rapid") if loss.leaves_out}


def test_the_tool_and_the_base_of_one_spline_move_hold_for_it_alone():
    rows = ("SLIN {X 900,Y 0,Z 400,A 0,B 90,C 0} WITH $TOOL={X 0,Y 0,Z 100,A 0,B 0,C 0},$BASE=$NULLFRAME",)
    text = krl(*HOME, "$TOOL=$NULLFRAME", "$BASE=$NULLFRAME", *rows, *poses((900, 50, 400)))
    plan = read(text, "krl").plan(robot=ROBOT)
    assert plan.moves.length[-1] == pytest.approx(
        math.hypot(0.05, 0.1)
    )  # the flange goes on from where it was


def test_a_name_that_begins_as_a_numbered_variable_is_followed_from_routine_to_routine():
    lose = "DEF LOSE()\r\nLREALPOS.A=$TIMER[1]*LREALPOS.B\r\nEND\r\n"
    text = krl(*HOME, "LOSE()", "LIN LREALPOS") + lose
    found = [
        loss for loss in losses(text, "krl", "inform") if "it needs" in loss.says and "LREALPOS" in loss.says
    ]
    assert [loss.line for loss in found if loss.leaves_out] == [
        text[: text.index("LIN LREALPOS")].count("\n") + 1
    ]


# --- States in numbers of URScript ----------------------------------------------------------------------------


def test_a_state_in_a_number_becomes_a_number_in_urscript():
    """URScript has no conversion between a state and a number: the line would stop the program."""
    rows = ("J P[1] 100% FINE", "R[3]=DI[1]", "R[4]=(DI[1] AND DI[2])", "DO[2]=R[3]")
    lines = code(translated(tp(*rows, positions=(P1,)), "tp", "urscript"), "#")
    assert lines[lines.index("R3 = 1") - 1] == "if (get_standard_digital_in(1) == True):"
    assert (
        lines[lines.index("R4 = 1") - 1] == "if (get_standard_digital_in(1) and get_standard_digital_in(2)):"
    )
    assert "set_standard_digital_out(2, R3 != 0)" in lines


# --- Listings that call one another -----------------------------------------------------------------------------


@pytest.fixture
def called_listings(tmp_path):
    """A main program that waits with a limit, and calls one that sets the limit and is handed too much."""

    def listing(name, *rows):
        lines = [f"{n:4d}:  {row} ;" for n, row in enumerate(rows, 1)]
        head = [f"/PROG  {name}", "/ATTR", "DEFAULT_GROUP\t= *,*,*,*,*;", "/MN"]
        (tmp_path / f"{name.lower()}.ls").write_text("\n".join([*head, *lines, "/POS", "/END", ""]))

    listing("SHOW", "WAIT DI[1]=ON TIMEOUT,LBL[1]", "CALL PICK(R[1],150,'BOX')", "LBL[1]", "DO[2]=ON")
    listing("PICK", "R[2]=AR[2]", "$WAITTMOUT=200", "WAIT DI[3]=ON TIMEOUT,LBL[1]", "LBL[1]")
    return link(olp.read(tmp_path / "show.ls")).program


@pytest.mark.parametrize("target", ["rapid", "krl", "urscript"])
def test_the_controllers_limit_of_waits_is_one_variable_of_all_listings(target, called_listings):
    made = convert(called_listings, target, Context(robot=ROBOT, on_loss="comment"))
    text = b"\n".join(made.files.values()).decode()
    limits = set(re.findall(r"\w*WAITTMOUT\w*", text))
    assert len(limits) == 1
    assert re.search(rf"{limits.pop()}\s*:?=\s*200\b", text)


@pytest.mark.parametrize("target", ["rapid", "krl", "urscript"])
def test_a_call_hands_over_no_more_than_the_routine_takes(target, called_listings):
    made = convert(called_listings, target, Context(robot=ROBOT, on_loss="comment"))
    text = b"\n".join(made.files.values()).decode()
    assert "BOX" not in text
    assert any("2 of its 3 arguments" in str(one) for one in made.translated.remarks)


# --- Settings that some ways alone make ---------------------------------------------------------------------------

ON_SOME_WAYS = krl(
    *HOME, "IF $IN[1] THEN", "$OV_PRO=50", "$BASE={X 100,Y 0,Z 0,A 0,B 0,C 0}", "ENDIF", "IF $IN[2] THEN", "$OV_PRO=30",
    "ENDIF", *poses((900, 0, 400)),
)  # fmt: skip


@pytest.mark.parametrize(
    ("target", "begins"), [("rapid", "frame:=wobj0;"), ("tp", "UFRAME[1]=PR[100] ;"), ("urscript", None)]
)
def test_a_frame_that_one_way_chooses_does_not_hold_in_the_next_run(target, begins):
    """The variable that holds it lives on in RAPID's and KRL's data, and as a frame of FANUC's controller."""
    text = translated(ON_SOME_WAYS, "krl", target)
    first = re.search(r"IF di1=1|IF \(DI\[1\]\)|if \(get", text).start()
    assert begins is None or begins in text[:first]


def test_a_tool_that_one_way_chooses_does_not_hold_in_the_next_run_of_krl():
    rows = (
        "if get_digital_in(1):",
        "  set_tcp(p[0, 0, 0.1, 0, 0, 0])",
        "end",
        "movel(p[0.5, 0, 0.4, 0, 3.1, 0])",
    )
    text = translated(script(*rows), "urscript", "krl")
    assert text.index("tool=$NULLFRAME") < text.index("IF $IN[1]")
    assert "DECL FRAME tool={X 0" in text  # a list holds what is written out


def test_no_override_is_the_whole_speed_where_one_way_alone_sets_one():
    text = translated(ON_SOME_WAYS, "krl", "urscript")
    assert "global override = 100.0" in text
    one = run(read(ON_SOME_WAYS, "krl"), robot=ROBOT)
    assert compare_plans(one, run_elsewhere(ON_SOME_WAYS, "krl", "urscript")).differences == []


def test_a_frame_of_a_routines_own_is_a_persistent_of_rapids_module():
    """RAPID has no PERS in routines; each call begins with the first value."""
    rows = (
        "local plane = p[0.1, 0.2, 0.3, 0, 0, 0]", "movel(pose_trans(plane, p[0.5, 0, 0.4, 0, 3.14, 0]))",
        "plane[2] = 0.4", "movel(pose_trans(plane, p[0.5, 0, 0.4, 0, 3.14, 0]))",
    )  # fmt: skip
    text = translated(script(*rows), "urscript", "rapid")
    head, body = text.split("PROC ", 1)
    assert "PERS wobjdata plane" in head
    assert "PERS" not in body
    assert body.index("plane.uframe:=[[100,200,300],[1,0,0,0]];") < body.index("MoveL")


def test_what_a_call_changes_by_reference_is_of_one_type_in_krl():
    """RAPID's byte is a num; a controller of KUKA takes no REAL for an INT that it changes."""
    data = ("VAR num sol{2,3};", "VAR byte cnt:=0;")
    rows = ("fill sol;", "bump cnt;", "WaitTime cnt + sol{1,2};")
    text = module(*rows, data=data).replace(
        "ENDMODULE",
        "PROC fill(INOUT byte got{*,*})\r\ngot{1,2}:=3;\r\nENDPROC\r\n"
        "PROC bump(INOUT num n)\r\nn:=n+1;\r\nENDPROC\r\nENDMODULE",
    )
    written = translated(text, "rapid", "krl")
    assert {"DECL REAL sol[2,3]", "DECL REAL got[,]", "DECL REAL cnt=0"} <= set(code(written, ";"))


# --- What a left-out block would have set -------------------------------------------------------------------------


@pytest.mark.parametrize("target", ["rapid", "krl", "tp"])
def test_what_follows_a_left_out_block_lacks_what_the_block_sets(target):
    """The move went to where the variable stood before, "exact"."""
    rows = (
        "place = p[0.3, 0.1, 0.2, 0, 3.1, 0]", "n = 0", "while (force() > 3):", "  n = n + 1",
        "  place = p[0.3, 0.1, n * 0.01, 0, 3.1, 0]", "end", "movel(place)", "if (n > 3):",
        "  set_digital_out(2, True)", "end",
    )  # fmt: skip
    found = {loss.line: (str(loss.fate), loss.says) for loss in losses(script(*rows), "urscript", target)}
    assert found[8][0] == "commented"
    assert "it needs place" in found[8][1]
    assert "it needs n" in found[9][1]


# --- Scripts ------------------------------------------------------------------------------------------------------


def test_a_function_of_rapid_returns_a_robtarget_and_no_pose():
    text = translated(
        "def part():\n  def above(p1):\n    return pose_trans(p1, p[0, 0, -0.1, 0, 0, 0])\n  end\n"
        "  def seen(base, p1):\n    return pose_trans(base, p1)\n  end\n"
        "  movel(above(p[0.3, 0.1, 0.2, 0, 3.1, 0]))\n"
        "  movel(seen(p[0.1, 0, 0, 0, 0, 0.2], p[0.3, 0.1, 0.2, 0, 3.1, 0]))\nend\n",
        "urscript",
        "rapid",
    )
    assert "RETURN PoseMult" not in text
    assert re.search(r"(\w+):=PoseMult\(.*\);\s+RETURN \[\1\.trans,\1\.rot,", text)


@pytest.mark.parametrize("target", ["rapid", "krl", "tp"])
def test_the_length_of_a_list_is_a_number(target):
    rows = (
        "steps = [0.1, 0.2, 0.3]",
        "i = 0",
        "while (i < length(steps)):",
        "  sleep(steps[i])",
        "  i = i + 1",
        "end",
    )
    text = script(*rows)
    assert not [loss for loss in losses(text, "urscript", target) if loss.fate is Fate.COMMENTED]
    one = run(read(text, "urscript"), robot=ROBOT)
    assert len(one.kind) == 3
    assert compare_plans(one, run_elsewhere(text, "urscript", target)).is_equal


@pytest.mark.parametrize("target", ["tp", "inform"])
def test_a_move_to_what_a_function_without_its_result_returns_is_left_out(target):
    """The result's RETURN is left out: the move went to a register that nothing sets."""
    text = (
        "def part():\n  def seen(base, p1):\n    off = pose_trans(base, p1)\n"
        "    return interpolate_pose(base, off, 0.5)\n  end\n"
        "  place = p[0, 0, 0, 0, 0, 0]\n  place = seen(p[0.1, 0, 0, 0, 0, 0.2], p[0.3, 0.1, 0.2, 0, 3.1, 0])\n"
        "  movel(place)\nend\n"
    )
    found = {loss.line: (str(loss.fate), loss.says) for loss in losses(text, "urscript", target)}
    assert found[8][0] == "commented"
    assert "it needs place" in found[8][1]


@pytest.mark.parametrize("target", ["tp", "inform"])
def test_an_argument_by_its_name_is_handed_over_once(target):
    """Its default was handed over behind it."""
    text = (
        "def part():\n  def shut(n, twice=False):\n    if (twice):\n      sleep(n * 0.5)\n    end\n"
        "    sleep(n)\n  end\n"
        "  shut(2, twice=True)\n  shut(3)\nend\n"
    )
    one = run(read(text, "urscript"), robot=ROBOT)
    assert compare_plans(one, run_elsewhere(text, "urscript", target)).is_equal
    assert len(one.kind) == 3


@pytest.mark.parametrize(
    ("target", "wanted"), [("rapid", "frame:=frame_3;"), ("urscript", "frame = frame_3")]
)
def test_a_frame_by_its_number_that_one_way_chooses_is_translated(target, wanted):
    rows = (*HOME, "IF $IN[1] THEN", "$BASE=BASE_DATA[3]", "ENDIF", *poses((900, 0, 400)))
    text = krl(*rows)
    assert wanted in translated(text, "krl", target)
    assert not [loss for loss in losses(text, "krl", target) if loss.fate is Fate.COMMENTED]


# --- FANUC's registers and speeds ---------------------------------------------------------------------------------


def test_a_point_that_a_frame_is_computed_from_stays_a_robtarget_of_rapid():
    """P1 became a wobjdata, which no move takes for its target."""
    rows = (
        "J P[1] 20% FINE",
        "PR[5]=P[1]",
        "PR[6]=PR[5]",
        "PR[6,3]=PR[6,3]+20",
        "UFRAME[2]=PR[6]",
        "UFRAME_NUM=2",
    )
    text = translated(
        tp(*rows, "L PR[6] 100mm/sec FINE", positions=((1, 2, 1, 900, 0, 400, 180, 0, 0),)), "tp", "rapid"
    )
    assert set(re.findall(r"(\w+) P1:=", text)) == {"robtarget"}
    assert set(re.findall(r"(\w+) PV6:=", text)) == {"robtarget"}
    assert "frame_2.uframe:=[PV6.trans,PV6.rot];" in text


def test_a_speed_of_turning_is_not_bound_by_the_speed_of_the_move_before_in_krl():
    rows = ("J P[1] 50% FINE", "L P[2] 5mm/sec FINE", "L P[3] 90deg/sec FINE")
    text = tp(*rows, positions=(P1, P2, (3, 0, 1, 850, 100, 400, 180, 0, 60)))
    lines = code(translated(text, "tp", "krl"), ";")
    slow, turning = lines.index("$VEL.CP=0.005"), lines.index("$VEL.ORI1=90")
    assert "$VEL.CP=3" in lines[slow:turning]
    one, other = run(read(text, "tp"), robot=ROBOT), run_elsewhere(text, "tp", "krl")
    assert compare_plans(one, other).differences == []


_HANDED_BACK = "q.trans:=PoseVect(pe,q.trans);", "q.rot:=OrientZYX(10,0,0)*q.rot;"


def handing_back(computed):
    """A function and a procedure that hand back what is `computed` in them."""
    data = (*TARGETS, "VAR robtarget pA;", "VAR robtarget pB;", "VAR pose pe;")
    rows = ("MoveL p1,v100,fine,tool0;", "pA:=above(p1);", "MoveL pA,v100,fine,tool0;", "lift pB;")
    return module(*rows, "MoveL pB,v100,fine,tool0;", data=data).replace(
        "ENDMODULE",
        f"FUNC robtarget above(robtarget p)\r\nVAR robtarget q;\r\nq:=p;\r\n{computed}\r\n"
        f"RETURN q;\r\nENDFUNC\r\nPROC lift(INOUT robtarget q)\r\nq:=p2;\r\n{computed}\r\n"
        "ENDPROC\r\nENDMODULE",
    )


def test_what_a_routine_hands_back_without_its_value_is_lost_for_its_callers():
    """A left-out statement inside of the routine computes it: the callers' moves went elsewhere, "exact"."""
    found = {
        loss.line: (str(loss.fate), loss.says)
        for loss in losses(handing_back(_HANDED_BACK[0]), "rapid", "krl")
    }
    assert found[11][0] == found[13][0] == "commented"
    assert "it needs pA" in found[11][1]
    assert "it needs pB" in found[13][1]


@pytest.mark.parametrize("target", ["tp", "inform"])
@pytest.mark.parametrize("computed", _HANDED_BACK)
def test_a_product_that_a_routine_hands_back_is_computed_there(computed, target):
    text = handing_back(computed)
    assert not any(loss.leaves_out for loss in losses(text, "rapid", target))
    one, other = run(read(text, "rapid")), run_elsewhere(text, "rapid", target)
    assert compare_plans(one, other).differences == []


# --- Products of turns --------------------------------------------------------------------------------------------

TURNS = module(
    "MoveJ p1,v100,fine,tool0;", "q:=p1;", "q.rot:=OrientZYX(30,0,0)*q.rot;", "MoveL q,v100,fine,tool0;",
    "o:=o*q.rot*OrientZYX(0,10,0);", "q.rot:=o;", "MoveL q,v100,fine,tool0;",
    data=(*TARGETS, "VAR robtarget q;", "VAR orient o:=[1,0,0,0];"),
)  # fmt: skip


@pytest.mark.parametrize("target", ["krl", "urscript"])
def test_a_product_of_two_orients_is_one_turn_behind_the_other(target):
    """URScript got `p[…] * p[…]`, which it does not know; the run left the line out."""
    plan = run(read(TURNS, "rapid"), robot=ROBOT)
    assert not [d for d in plan.diagnostics if d.is_error]
    assert compare_plans(plan, run_elsewhere(TURNS, "rapid", target), speeds=False).differences == []
    assert "] * olp_pose" not in translated(TURNS, "rapid", "urscript")
    said = TURNS.replace("OrientZYX(30,0,0)*q.rot", "OrientZYX(30,0,180)")
    said = said.replace("o*q.rot*OrientZYX(0,10,0)", "OrientZYX(30,-10,180)")
    assert compare_plans(plan, run(read(said, "rapid"), robot=ROBOT)).differences == []


def test_a_product_of_two_orients_is_written_back_as_it_was():
    text = translated(TURNS, "rapid", "rapid")
    assert "q.rot:=OrientZYX(30,0,0) * q.rot;" in text
    assert "o:=o * q.rot * OrientZYX(0,10,0);" in text


def test_the_load_of_a_tool_with_a_name_is_asked_for():
    """A script's `set_tcp` says nothing of it; only tools with numbers were asked for."""
    data = (*TARGETS, "PERS tooldata grip:=[TRUE,[[0,0,150],[1,0,0,0]],[2.5,[0,0,80],[1,0,0,0],0,0,0]];")
    text = module("MoveL p1,v100,fine,grip;", data=data)
    translation = converted(text, "rapid", "urscript").translated
    asked = before_it_runs(link(read(text, "rapid")), translation, "urscript", None, True)
    assert any("loads of the tools" in one for one in asked)


# --- AS ---------------------------------------------------------------------------------------------------------


def test_a_departure_counts_from_the_target_of_the_move_before_however_that_is_passed():
    text = ".PROGRAM part()\nSPEED 500 MM/S ALWAYS\nLMOVE a\nLDEPART 20\nTDRAW 0,0,-10\n.END\n"
    made = translated(text + ".TRANS\na 400 0 500 0 180 0\n.END\n", "as", "krl")
    assert made.count(" #TOOL") == 2
    assert "POS_ACT" not in made


def test_tables_that_as_hands_over_are_tables():
    text = ".PROGRAM part()\nPOINT t[1,2] = a\nCALL sub(&t[,])\n.END\n.PROGRAM sub(.&p[,])\nLMOVE .p[1,2]\n.END\n"
    made = translated(text + ".TRANS\na 400 0 500 0 180 0\n.END\n", "as", "krl")
    assert "sub (t_1[,])" in made
    assert "DECL E6POS _p[,]" in made


def test_an_offset_from_the_target_before_names_no_posture():
    text = ".PROGRAM part()\nSPEED 50 ALWAYS\nJMOVE a\nJDEPART 20\n.END\n.TRANS\na 900 0 500 0 180 0\n.END\n"
    made = translated(text, "as", "krl")
    assert re.search(r"PTP_REL \{X 0,Y 0,Z -20,A 0,B 0,C 0\}", made)


# --- PDL2 -------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("target", ["krl", "rapid", "tp", "inform", "urscript"])
def test_settings_of_how_moves_are_made_are_comments_that_are_told(target):
    rows = ("$FLY_TYPE := FLY_CART", "$TERM_TYPE := NOSETTLE", "$CNFG_CARE := TRUE", "$STRESS_PER:= 65")
    body = (*rows, "$SPD_OPT := SPD_LIN", "$LIN_SPD := 0.25", "MOVE LINEAR TO POS(900,0,500,0,90,0,'')")
    text = "\n".join(["PROGRAM part", "BEGIN", *body, "END part", ""])
    made = converted(text, "pdl2", target)
    assert not [loss for loss in made.translated.losses if loss.leaves_out]
    assert {loss.line for loss in made.translated.losses if loss.fate is Fate.APPROXIMATED} >= {3, 4, 5, 6}


@pytest.mark.parametrize("target", ["krl", "rapid"])
def test_a_loop_that_asks_at_its_end_waits_as_long_as_a_jump(target):
    text = "PROGRAM part\nBEGIN\n  REPEAT\n    DELAY 100\n  UNTIL $DIN[5] = ON\nEND part\n"
    here, there = read(text, "pdl2").plan(), run_elsewhere(text, "pdl2", target)
    assert [step.duration for step in here.steps()] == pytest.approx([0.1, 0.0])  # and the wait for $DIN[5]
    assert [step.duration for step in there.steps()] == pytest.approx([0.1, 0.0])


# --- TP's registers ---------------------------------------------------------------------------------------------


@pytest.mark.parametrize("target", ["krl", "rapid", "inform", "urscript"])
def test_a_component_by_a_computed_number_is_left_out_with_what_needs_it(target):
    text = tp("PR[1]=P[1]", "R[2]=3", "PR[1,R[2]]=R[1]+5", "L PR[1] 100mm/sec FINE")
    made = converted(text, "tp", target)
    assert {loss.says for loss in made.translated.losses if loss.leaves_out} >= {
        "an element of a position by a computed number"
    }


@pytest.mark.parametrize("target", ["krl", "rapid", "urscript"])
def test_a_frame_that_is_a_sum_of_registers_gets_the_sum(target):
    rows = [f"PR[{n},{at}]={value}" for n in (1, 2) for at, value in enumerate((10 * n, 5, 0, 0, 0, 0), 1)]
    rows += ["UFRAME[1]=PR[1]+PR[2]", "UFRAME_NUM[GP1]=1", "UTOOL_NUM[GP1]=1", "PR[3]=PR[1]-PR[1]"]
    made = run_elsewhere(tp(*rows, "L PR[3] 100mm/sec FINE"), "tp", target)
    there = made.positions.position[made.moves.target]
    np.testing.assert_allclose(there, [[0.03, 0.01, 0.0]], atol=2e-6)


@pytest.mark.parametrize("target", ["krl", "rapid", "urscript"])
def test_parameters_of_pdl2_have_their_defaults_and_tables(target):
    head = ["PROGRAM part", "VAR t : ARRAY[3] OF INTEGER"]
    head += ["ROUTINE twice(a : INTEGER; b : INTEGER (150))", "BEGIN", "DELAY b * a", "END twice"]
    head += ["ROUTINE fill(c : ARRAY[*] OF INTEGER)", "BEGIN", "c[2] := 30", "END fill"]
    text = "\n".join(
        [
            *head,
            "BEGIN",
            "t[1] := 1",
            "t[2] := 2",
            "t[3] := 3",
            "twice(2)",
            "twice(2, 5)",
            "fill(t)",
            "DELAY t[2]",
            "END part",
            "",
        ]
    )
    for plan in (read(text, "pdl2").plan(), run_elsewhere(text, "pdl2", target)):
        assert [step.duration for step in plan.steps()] == pytest.approx([0.3, 0.01, 0.03])


@pytest.mark.parametrize("target", ["krl", "rapid", "inform"])
def test_a_hybrid_move_is_told(target):
    text = ".PROGRAM part()\nSPEED 500 MM/S ALWAYS\nHMOVE a\n.END\n.TRANS\na 900 0 500 0 180 0\n.END\n"
    made = converted(text, "as", target)
    assert [loss.line for loss in made.translated.losses if loss.part == "option"] == [3]


@pytest.mark.parametrize("target", ["rapid", "krl"])
@pytest.mark.parametrize(
    ("rows", "says"),
    [
        (["x = 1.5", 'x = "text"'], "texts in a variable of numbers: the target has a type for each"),
        (["x = 1.5", "x = [1, 2, 3]"], "in a variable of numbers|x with 1 index"),
        (["x = 1.5", "p = get_actual_tcp_pose()", "x = p"], "positions in a variable of numbers"),
        (['s = "text"', "x = sqrt(s)"], "sqrt of texts, where it takes numbers"),
        (["p = get_actual_tcp_pose()", "x = not (p)"], "the operator not on positions"),
    ],
)
def test_values_of_another_kind_than_a_typed_language_takes_are_told(rows, says, target):
    text = script(*rows)
    made = converted(text, "urscript", target)
    assert any(re.search(says, loss.says) for loss in made.translated.losses)


@pytest.mark.parametrize("target", ["rapid", "tp", "inform", "urscript"])
def test_an_input_that_is_set_is_told(target):
    made = converted(krl("SIGNAL CODE $IN[1] TO $IN[4]", "CODE=5"), "krl", target)
    assert any(loss.says == "an input that is set" for loss in made.translated.losses if loss.leaves_out)


def test_a_frame_that_held_where_a_loop_was_left_is_no_frame_behind_its_end():
    """EXIT leaves the loop with the first base, UNTIL with the second: `F=$BASE` took the second."""
    loop = (
        "REPEAT",
        "$BASE=BASE_DATA[1]",
        "IF $IN[1] THEN",
        "EXIT",
        "ENDIF",
        "$BASE=BASE_DATA[2]",
        "UNTIL $IN[2]",
    )
    text = krl("DECL FRAME F", *loop, "F=$BASE", "LIN F")
    assert "the frame in use" in " ".join(refused(text, "krl", "rapid").values())


@pytest.mark.parametrize("arm", ["ARM[2]", "ARM[which]"])
@pytest.mark.parametrize("target", ["krl", "rapid", "tp"])
def test_a_move_of_another_arm_is_no_move_of_the_only_one(arm, target):
    place, moves = (
        "p := POS(900, 0, 400, 0, 90, 0, '')",
        ("MOVE ARM[1] LINEAR TO p", f"MOVE {arm} LINEAR TO p"),
    )
    text = pdl2(place, "which := 2", *moves, data=("p : POSITION\n", "which : INTEGER\n"))
    told = [line for line, says in refused(text, "pdl2", target).items() if "arm" in says]
    assert told == [1 + text.splitlines().index(next(row for row in text.splitlines() if arm in row))]


# --- Comments of data ---------------------------------------------------------------------------------------


@pytest.mark.parametrize("target", ["tp", "inform", "urscript", "krl"])
def test_comments_between_the_data_of_a_rapid_module_are_kept(target):
    data = "! made for cell 7", "CONST num turns:=3; ! of the table", "! counts parts", "VAR num parts:=0;"
    written = translated(module("parts:=turns;", "WaitTime parts;", data=data), "rapid", target)
    for said in ("made for cell 7", "of the table", "counts parts"):
        assert written.count(said) == 1, (said, written)


@pytest.mark.parametrize("target", ["tp", "inform", "urscript", "krl"])
def test_comments_of_data_that_the_target_has_no_line_for_are_kept(target):
    """Tools, speeds, loads, clocks, loop variables and points may be settings, numbers or nothing there."""
    told = {
        "PERS tooldata grip:=[TRUE,[[0,0,120],[1,0,0,0]],[3,[0,0,60],[1,0,0,0],0,0,0]];": "a gripper",
        "PERS loaddata part:=[1.2,[0,0,30],[1,0,0,0],0,0,0];": "a part",
        "CONST speeddata slow:=[80,200,1000,1000];": "a speed",
        "CONST zonedata wide:=[FALSE,12,18,18,1.8,18,1.8];": "a zone",
        "CONST robtarget pick:=[[1100,50,920],[0,1,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];": "a point",
        "VAR clock watch;": "a clock",
        "VAR num unused;": "of no use",
    }
    data = [row for one, says in told.items() for row in (f"! above {says}", f"{one} ! behind {says}")]
    body = (
        *("! above a count", "VAR num i; ! behind a count", "FOR i FROM 1 TO 2 DO"),
        *("MoveL pick, slow, wide, grip;", "ENDFOR"),
    )
    written = translated(module(*body, data=tuple(data)), "rapid", target)
    for says in (*told.values(), "a count"):
        for place in ("above", "behind"):
            assert written.count(f"{place} {says}") == 1, (place, says, written)


@pytest.mark.parametrize("target", ["tp", "inform", "urscript", "rapid"])
def test_comments_of_labels_and_jumps_are_kept_where_steps_take_their_place(target):
    """A language without jumps gets numbered steps: those that are reached, and none that only leads on."""
    rows = (
        *("again: ; one", "WAIT SEC 1 ; two", "IF $IN[3] THEN", "GOTO over ; three", "ENDIF"),
        *("IF $IN[1] THEN", "GOTO other ; four", "ENDIF", "GOTO again ; five", "other: ; six", "WAIT SEC 2"),
        *("IF $IN[2] THEN", "GOTO again ; seven", "ENDIF", "GOTO over ; eight", "over: ; nine", "WAIT SEC 3"),
    )
    written = translated(krl(*rows), "krl", target)
    for said in ("one", "two", "three", "four", "five", "six", "seven", "eight", "nine"):
        assert len(re.findall(rf"\b{said}\b", written)) == 1, (said, written)
    if target == "urscript":
        assert re.findall(r"if \(step == (\d)\)", written) == ["0", "1", "2", "3"]
        assert not re.search(r"step == \d\):\n\s*step = ", written)


@pytest.mark.parametrize("target", ["tp", "inform", "urscript", "rapid"])
def test_what_krl_says_of_a_program_in_its_first_lines_is_kept(target):
    text = "&ACCESS RVP\n&REL 1\n&COMMENT loads pallets\n" + krl("WAIT SEC 1")
    written = translated(text, "krl", target)
    assert written.count("loads pallets") == 1
    again = translated(written, target, "krl")
    assert "\n&COMMENT loads pallets" in again or target in ("rapid", "urscript")
    assert again.count("loads pallets") == 1


@pytest.mark.parametrize("target", ["tp", "inform", "urscript", "rapid"])
def test_comments_of_a_list_beside_krl_are_kept(tmp_path, target):
    (tmp_path / "job.dat").write_text(
        "DEFDAT job\n; made for cell 7\nDECL INT turns=3 ; of the table\nENDDAT\n"
    )
    (tmp_path / "job.src").write_text("DEF job()\nWAIT SEC turns\nEND\n")
    result = convert(read_source(load(tmp_path / "job.src")), target)
    written = b"".join(result.files.values()).decode("cp1252")
    for said in ("made for cell 7", "of the table"):
        assert written.count(said) == 1, (said, written)


# --- Signals that the target's controller lacks ---------------------------------------------------------------


def test_an_output_beyond_those_of_the_box_gets_a_free_number_and_is_asked_for():
    text = krl("$OUT[127]=TRUE", "$OUT[1]=FALSE", "WAIT FOR $IN[200]", "$OUT[127]=FALSE")
    result = converted(text, "krl", "urscript")
    asked = next(things for says, things in result.translated.asks.items() if "free ones" in says)
    assert sorted(asked) == ["in 200 is 1", "out 127 is 2"]
    written = translated(text, "krl", "urscript")
    assert code(written, "#")[1:4:2] == [
        "set_standard_digital_out(2, True)",
        "while (not (get_standard_digital_in(1))):",
    ]


def test_more_outputs_than_the_box_has_are_refused():
    text = krl(*(f"$OUT[{n}]=TRUE" for n in range(100, 119)))
    assert refused(text, "krl", "urscript") == {
        20: "URScript cannot express this: out 118, as all 18 of these signals are taken"
    }


def test_a_mapped_output_keeps_the_mapping():
    mapping = Mapping(signals={"out 127": "tool-out 1"})
    result = convert(read(krl("$OUT[127]=TRUE"), "krl"), "urscript", Context(robot=ROBOT, mapping=mapping))
    assert b"set_tool_digital_out(1, True)" in b"".join(result.files.values())


# --- Groups of signals are whole numbers ----------------------------------------------------------------------


def test_a_quotient_of_a_group_into_krl_keeps_its_fraction():
    text = tp("R[1]=GI[3]/2", "R[2]=GI[3] DIV 4", "R[3]=GI[3] MOD 4", "IF (GI[3]/2>1.2),JMP LBL[1]", "LBL[1]")
    rows = [line for line in code(translated(text, "tp", "krl"), ";") if "IN_1041_1056" in line]
    assert rows[:4] == [
        "R1=IN_1041_1056/2.0",
        "R2=IN_1041_1056/4",
        "R3=IN_1041_1056-IN_1041_1056/4*4",
        "IF IN_1041_1056/2.0>1.2 THEN",
    ]


@pytest.mark.parametrize(("target", "row"), [("rapid", "x:=gi3 DIV 2;"), ("tp", "R[1:x]=GI[1] DIV 2 ;")])
def test_a_quotient_of_a_group_of_krl_is_cut(target, row):
    text = krl("SIGNAL gi3 $IN[1] TO $IN[4]", "DECL REAL x", "x=gi3/2", "WAIT SEC x")
    assert row in translated(text, "krl", target)


# --- comments outside of routines ---------------------------------------------------------------------------

OUTSIDE = {
    "rapid": (
        "! c1", "MODULE M ! c2", "! c3", "RECORD pair", "num a;", "ENDRECORD", "! c4", "VAR num x:=1; ! c5",
        "! c6", "PROC main() ! c7", "! c8", "x:=x+1;", "SetDO do1,x;", "sub;", "ENDPROC ! c9", "! c10",
        "PROC sub()", "SetDO do2,1;", "ENDPROC", "! c11", "ENDMODULE ! c12", "! c13",
    ),
    "krl": (
        ";c1", "DEF PART ( ) ;c2", ";c3", "$OUT[1]=TRUE", "SUB()", "END ;c4", ";c5", "DEF SUB()", "$OUT[2]=TRUE",
        "END ;c6", "", ";c7",
    ),
    "as": (
        "; c1", ".PROGRAM part() ; c2", "; c3", "SIGNAL 1 ; c4", "CALL sub", ".END", "; c5", ".PROGRAM sub()",
        "SIGNAL -1", ".END", "; c6",
    ),
    "pdl2": (
        "-- c1", "PROGRAM part -- c2", "-- c3", "VAR x : INTEGER -- c4", "ROUTINE sub -- c5", "BEGIN",
        "$DOUT[1] := OFF", "END sub -- c6", "-- c7", "BEGIN -- c8", "x := 1", "$DOUT[x] := ON -- c9", "sub",
        "END part -- c10", "-- c11",
    ),
    "urscript": (
        "# c1", "def part(): # c2", "x = 1 # c3", "set_digital_out(x, True)", "def sub():", "sleep(1)",
        "end # c4", "sub()", "end # c5", "# c6",
    ),
}  # fmt: skip


@pytest.mark.parametrize("vendor", OUTSIDE)
@pytest.mark.parametrize("target", ["rapid", "krl", "urscript", "inform", "tp"])
def test_comments_outside_of_routines_stand_in_the_translation(vendor, target):
    text = "\r\n".join([*OUTSIDE[vendor], ""])
    written = translated(text, vendor, target)
    if vendor != target:
        assert set(re.findall(r"\bc\d+\b", written)) == set(re.findall(r"\bc\d+\b", text))


def test_a_module_is_written_as_it_was_with_its_comments():
    """What other languages have in the routines stands where it stood."""
    text = "\r\n".join([*OUTSIDE["rapid"], ""])
    program = read_source(decode(text.encode("cp1252"), "part.mod"), vendor="rapid")
    written = program.export("rapid").decode("cp1252")
    assert re.findall(r"c\d+", written) == re.findall(r"c\d+", text)


@pytest.mark.parametrize("target", ["rapid", "tp", "inform", "urscript"])
@pytest.mark.parametrize("rows", [("$OV_PRO=30", "$OV_PRO=OLD"), ("WAIT FOR OLD==100",)])
def test_the_speed_that_the_operator_has_chosen_is_told_as_unknown(rows, target):
    """`OLD=$OV_PRO` … `$OV_PRO=OLD` gave back 100 % of a pendant that stood at 30, and nothing said so."""
    text = krl("DECL INT OLD", "OLD=$OV_PRO", *rows, *poses((900, 0, 400)))
    told = [x for x in losses(text, "krl", target) if "operator has chosen" in x.says]
    assert [x.fate for x in told] == [Fate.APPROXIMATED]


def test_the_comment_of_the_call_that_starts_a_script_stays():
    text = "def prog():\n  set_digital_out(1, True)\nend\nprog() # at night alone\n"
    assert "; at night alone" in translated(text, "urscript", "krl")


@pytest.mark.parametrize(
    ("end", "stays"),
    [
        (";ENDFOLD only when cold", True),
        (";ENDFOLD (Grip)", False),
        (";ENDFOLD", False),
    ],
)
def test_what_stands_behind_the_end_of_a_fold_stays_unless_it_is_its_name(end, stays):
    text = krl(";FOLD Grip the part", "$OUT[1]=TRUE", end)
    rows = [row.strip() for row in translated(text, "krl", "rapid").splitlines()]
    assert rows[2:-2] == [
        "! Grip the part",
        "SetDO do1,1;",
        *(["! only when cold"] if stays else []),
    ]


# --- text that no compiler takes ----------------------------------------------------------------------------


@pytest.mark.parametrize("target", ["rapid", "krl", "tp"])
def test_a_computed_jump_chooses_labels_of_its_variables_kind(target):
    """A byte chooses labels that are numbers, a text all labels by their names."""
    rows = ("*10", "PAUSE", "*AGAIN", "PAUSE")
    number = translated(inform("JUMP LABEL: B001", *rows), "inform", target)
    text = translated(inform("JUMP LABEL: S000", *rows), "inform", target)
    quote = "'" if target == "tp" else '"'
    assert f"{quote}AGAIN{quote}" not in number
    assert all(f"{quote}{label}{quote}" in text for label in ("10", "AGAIN"))


@pytest.mark.parametrize(
    ("target", "stops"), [("rapid", "Stop;"), ("krl", "HALT"), ("inform", "PAUSE"), ("urscript", "popup")]
)
def test_a_computed_jump_to_no_label_stops_the_program(target, stops):
    """FANUC's controller ends it with an alarm there; the translation went on with the next statement."""
    rows = ("R[7]=DI[1]", "JMP LBL[R[7]]", "DO[4]=ON", "LBL[1]", "DO[5]=ON", "LBL[2]", "DO[6]=ON")
    written = translated(tp(*rows), "tp", target)
    assert written.index(stops) < re.search(r"(OUT\[|do|OT#\(|out\()4", written).start()


def test_a_computed_jump_that_no_label_answers_is_refused():
    said = losses(inform("JUMP LABEL: B001", "*AGAIN", "PAUSE"), "inform", "rapid")
    assert [one.says for one in said if one.fate is Fate.REFUSED or "computed jump" in one.says] == [
        "a computed jump that no label answers"
    ]


def test_values_of_two_kinds_are_compared_nowhere():
    text = krl("INT N", "CHAR NAME[8]", "IF N==NAME[] THEN", "$OUT[1]=TRUE", "ENDIF")
    assert any("compared with" in one.says for one in losses(text, "krl", "rapid"))


def test_a_single_position_has_no_elements():
    said = losses(krl("E6POS X1", "PTP X1[3]"), "krl", "rapid")
    assert any("X1 with 1 index, declared with none" in one.says for one in said)


def test_tools_that_a_list_leaves_open_are_zeros_that_are_told(tmp_path):
    (tmp_path / "R1" / "System").mkdir(parents=True)
    (tmp_path / "R1" / "Program").mkdir()
    lists = ["DEFDAT $CONFIG", "DECL FRAME TOOL_DATA[4]", "TOOL_DATA[2]={X 1,Y 2,Z 3,A 0,B 0,C 0}", "ENDDAT"]
    (tmp_path / "R1" / "System" / "$config.dat").write_text("\n".join(lists))
    program = tmp_path / "R1" / "Program" / "chosen.src"
    rows = ["DEF chosen()", "INT n", "n=1", "IF $IN[1] THEN", "n=2", "ENDIF", "$TOOL=TOOL_DATA[n]"]
    program.write_text("\n".join([*rows, "PTP {X 500,Y 0,Z 400,A 0,B 0,C 180}", "END"]))
    made = convert(read_source(load(program)), "rapid", Context(on_loss="comment"))
    (text,) = (raw.decode() for raw in made.files.values())
    assert text.count("[TRUE,[[") == 5  # four, and the one that holds
    says = "no file has values for TOOL_DATA[1], TOOL_DATA[3], TOOL_DATA[4]: zeros are written"
    assert says in [one.says for one in made.translated.losses]


def test_cases_that_are_fractions_are_no_switch_of_integers():
    rows = [
        "R[1]=2.5",
        "SELECT R[1]=1,JMP LBL[1]",
        "       =2.5,JMP LBL[2]",
        "LBL[1]",
        "DO[1]=ON",
        "LBL[2]",
        "DO[2]=ON",
    ]
    made = translated(tp(*rows), "tp", "krl")
    assert "CASE" not in made
    assert "==2.5" in made


def test_an_element_of_a_pose_by_a_computed_number_is_no_position():
    rows = ["i = 2", "p1 = p[0.1, 0.2, 0.3, 0, 0, 0]", "if p1[i] < 0.1:", "  sleep(1)", "end"]
    said = {one.says for one in losses(script(*rows), "urscript", "krl")}
    assert "an element of a pose by a computed number" in said
    assert not any("compared with" in one for one in said)


def test_an_element_of_an_array_of_joint_values_is_no_axis():
    rows = [f"tab[{n}]={{A1 {n},A2 -90,A3 90,A4 0,A5 10,A6 0}}" for n in (1, 2, 3)]
    text = krl(
        "E6AXIS tab[3]",
        "$BASE=$NULLFRAME",
        "$TOOL=$NULLFRAME",
        *rows,
        "PTP tab[2]",
        "tab[2].A3=95",
        "PTP tab[2]",
    )
    made = translated(text, "krl", "rapid")
    assert "MoveAbsJ tab{2}," in made
    assert "tab{2}.robax.rax_3:=95;" in made
    made = translated(text, "krl", "tp")
    assert re.search(r"PR\[2,3(:\w+)?\]=95 ", made)
    said = losses(text, "krl", "inform")
    assert any("one axis of joint values" in one.says for one in said)


def test_a_saved_array_of_joint_values_has_joint_values_in_its_gaps():
    text = ".PROGRAM main()\nJMOVE #safe[2]\n.END\n.JOINTS\n#safe[2] 0 10 -20 0 30 0\n.END\n"
    program = read_source(decode(text.encode(), "part.as"))
    made = convert(program, "rapid", Context(robot=ROBOT, on_loss="comment"))
    (text,) = (raw.decode() for raw in made.files.values())
    assert text.count("[[0,0,0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]]") == 2
    assert re.search(r"MoveAbsJ \w+\{3\},", text)


@pytest.mark.parametrize("target", ["rapid", "krl", "tp", "inform"])
def test_a_function_of_data_that_the_target_lacks_goes_with_its_calls(target):
    text = "\n".join(
        [
            "def part():",
            "  def pair(t):",
            "    return struct(a = t, b = [t, 2*t])",
            "  end",
            "  def row(t):",
            "    return [t, 2*t]",
            "  end",
            "  s = pair(0.5)",
            "  z = row(3)",
            "  if z[1] > 2:",
            "    set_standard_digital_out(1, True)",
            "  end",
            "end",
            "",
        ]
    )
    made = translated(text, "urscript", target)
    assert not re.search(r"(FUNC|DEFFCT) list|^ *RETURN \[", made, re.MULTILINE)
    assert {3, 6, 8, 9, 10} <= {one.line for one in losses(text, "urscript", target)}


def test_no_number_stands_left_in_a_condition_of_inform():
    rows = [
        "IF never SetDO do1,1;",
        "IF never OR di1=1 SetDO do2,1;",
        "IF 5>x SetDO do3,1;",
        "IF 5>k SetDO do4,1;",
    ]
    data = ("VAR bool never:=FALSE;", "VAR num k:=3;", "VAR num x:=0;")
    text = module("x:=x+1;", "WHILE TRUE DO", *rows, "WaitTime 1;", "ENDWHILE", data=data)
    made = code(translated(text, "rapid", "inform"), "'")
    assert not [row for row in made if re.match(r"(IFTHEN|WHILE)\w* -?\d|.*(OR|AND)IF \d", row)]
    assert "JUMP *L1" in made
    assert any(re.fullmatch(r"IFTHEN \w+<5", row) for row in made)


def test_more_branches_than_tp_nests_stand_in_a_row():
    rows = [row for n in range(2, 13) for row in (f"ELSEIF x={n} THEN", f"SetDO do{n},1;")]
    rows = ["x:=x+1;", "IF x=1 THEN", "SetDO do1,1;", *rows, "ELSE", "SetDO do99,1;", "ENDIF"]
    made = code(translated(module(*rows, data=("VAR num x:=0;",)), "rapid", "tp"), "!")
    depth = [row.count(") THEN") - row.count("ENDIF") for row in made]
    assert max(np.cumsum(depth)) == 1
    assert sum("JMP LBL[1]" in row for row in made) == 12


def test_a_group_of_signals_is_read_into_and_set_from_a_byte_in_inform():
    """Jobs seen have DIN B010 IG#(30) and DOUT OG#(2) B003; no SET has a signal, no DOUT another variable."""
    rows = [
        "n:=gi1+2;", "SetGO go1,n;", "SetGO go2,gi1;", "IF n>gi2 THEN", "WaitTime 1;", "ENDIF", "IF gi1>gi2 THEN",
        "WaitTime 2;", "ENDIF", "WaitUntil n<gi2;", "SetGO go3,5;",
    ]  # fmt: skip
    made = converted(module(*rows, data=["VAR num n;"]), "rapid", "inform")
    assert not made.translated.losses
    text = made.files["main.JBI"].decode("cp1252").replace("\r\n", "\n")
    assert "DIN B000 IG#(1)\nSET R000  EXPRESS B000 + 2\nSET B000 R000\nDOUT OG#(1) B000\n" in text
    assert "DIN B000 IG#(1)\nDOUT OG#(2) B000\n" in text
    assert "IFTHEN IG#(2)<R000\n" in text
    assert "DIN B000 IG#(2)\nIFTHEN IG#(1)>B000\n" in text
    assert "WAIT IG#(2)>R000\n" in text
    assert "DOUT OG#(3) 5\n" in text
    one = run(read(module(*rows, data=["VAR num n;"]), "rapid"), robot=ROBOT)
    assert compare_plans(one, run_converted(made, "inform", ROBOT)).differences == []


@pytest.mark.parametrize("target", ["rapid", "tp", "inform", "urscript"])
def test_an_angle_that_a_call_changes_is_handed_over_in_a_variable(target):
    """RAPID and URScript hold a turn as one value: no routine takes an angle of it to change it."""
    routines = krl(
        "DECL FRAME F", "DECL E6POS Q[3]", "DECL INT I", *HOME, "I=2",
        "F={X 900,Y 0,Z 400,A 10,B 80,C 20}", "Q[2]={X 900,Y 50,Z 400,A 10,B 80,C 20}",
        "ANGLES(F.A,F.Y)", "PLACE(F.C)", "PLACE(Q[I].Z)", "PLACE(Q[I].B)", "LOOK(F.B)", "LIN F", "LIN Q[2]",
    ) + "\r\n".join([
        "DEF ANGLES(A :OUT,B :OUT)", "REAL A,B", "A=A+1", "B=A+2", "END",
        "DEF PLACE(X :OUT)", "REAL X", "X=X-5", "END",
        "DEF LOOK(X :OUT)", "REAL X", "WAIT SEC X/100", "END", "",
    ])  # fmt: skip
    made = converted(routines, "krl", target)
    assert not [loss for loss in made.translated.losses if loss.leaves_out]
    if target == "rapid":
        text = b"".join(made.files.values()).decode()
        assert not re.search(r"(ANGLES|PLACE) .*EulerZYX", text)
        assert re.search(r"LOOK EulerZYX\(\\Y,", text)  # by value, as it changes nothing
    one = run(read(routines, "krl"), robot=ROBOT)
    assert compare_plans(one, run_converted(made, target, ROBOT)).differences == []


def test_an_angle_changed_through_an_index_that_the_call_changes_is_refused():
    routines = krl(
        "DECL E6POS Q[3]", "DECL INT I", "I=2", "Q[2]={X 900,Y 50,Z 400,A 0,B 90,C 0}", "NEXT(Q[I].B,I)",
    ) + "\r\n".join(["DEF NEXT(A :OUT,N :OUT)", "REAL A", "INT N", "N=3", "A=5", "END", ""])  # fmt: skip
    (told,) = refused(routines, "krl", "rapid").values()
    assert "component of a position" in told


@pytest.mark.parametrize("target", ["tp", "inform", "urscript"])
def test_a_first_routine_that_others_call_sets_first_values_at_its_start_alone(target):
    """main is called again: in the source that sets nothing back, as its variables begin when the module is loaded."""
    text = module(
        "total:=total+1;", "WaitTime total;", "IF total<8 again;", data=["VAR num total:=5;"]
    ).replace("ENDMODULE", "PROC again()\r\nWaitTime 0.5;\r\nmain;\r\nENDPROC\r\nENDMODULE")  # fmt: skip
    made = converted(text, "rapid", target)
    assert ["main_start"] in [list(things) for things in made.translated.asks.values()]
    assert waits_of_plan(run_converted(made, target, ROBOT)) == [6, 0.5, 7, 0.5, 8]
    once = translated(text.replace("main;", "WaitTime 1;"), "rapid", target)  # nothing calls it
    assert "main_start" not in once


def waits_of_plan(plan):
    return [round(float(plan.durations[row]), 3) for row in plan.row[plan.kind == StepKind.WAIT]]


@pytest.mark.parametrize("target", ["rapid", "krl", "urscript", "inform"])
def test_a_register_that_only_the_speed_of_a_move_reads_is_named(target):
    """A robot that is told to move at zero stops there."""
    made = converted(tp("J P[1] 100% FINE", "L P[2] R[6]mm/sec FINE", positions=(P1, P2)), "tp", target)
    assert "R6" in [thing for things in made.translated.asks.values() for thing in things]


def test_a_position_register_that_only_an_offset_reads_is_named_in_inform():
    rows = ("J P[1] 100% FINE", "L P[2] 100mm/sec FINE Offset,PR[4:above]")
    made = converted(tp(*rows, positions=(P1, P2)), "tp", "inform")
    assert made.translated.asks["teach these positions"] == ("above",)


def test_components_that_calls_change_are_declared_in_their_own_routine():
    """`component` was set in a module that declares no such data."""
    text = krl("DECL FRAME F", "PLACE(F)", "LIN F") + "\r\n".join([
        "DEF PLACE(G :OUT)", "DECL FRAME G", "G={X 900,Y 0,Z 500,A 0,B 80,C 0}", "TURN(G.A,G.B)", "END",
        "DEF TURN(A :OUT,B :OUT)", "DECL REAL A,B", "A=A+1", "B=B+1", "END", "",
    ])  # fmt: skip
    made = code(translated(text, "krl", "rapid"), "!")
    place = made[made.index("LOCAL PROC PLACE(INOUT robtarget G)") :]
    assert {"VAR num component;", "VAR num component2;"} <= set(place[:3])


def test_a_position_of_which_one_angle_is_set_begins_with_a_turn_in_rapid():
    """Four zeros are no quaternion: EulerZYX stops the program."""
    text = translated(
        krl("DECL FRAME F,G", "F.X=900", "F.Z=500", "F.A=5", "F.X=910", "F.B=80", "G=F", "LIN G"),
        "krl",
        "rapid",
    )
    assert re.search(r"VAR robtarget F:=\[\[0,0,0\],\[1,0,0,0\],", text)
    assert "VAR robtarget G;" in text


@pytest.mark.parametrize("target", ["rapid", "urscript"])
@pytest.mark.parametrize(
    ("rows", "same"),
    [
        (["F.C=5"], False),  # only C - A is told by the turn there
        (["F.C=F.C+5"], True),
        (["F.B=80", "F.C=5"], False),  # a controller may have any A and C before
        (["F.A=1", "F.B=91", "F.C=0", "LIN F", "F.B=F.B+1"], False),  # 91 is read as 89
    ],
)
def test_single_angles_at_90_degrees_are_what_a_controller_with_whole_turns_makes_of_them(target, rows, same):
    rows = ["F={X 900,Y 0,Z 500,A 10,B 90,C 0}", "LIN F", *rows, "LIN F"]
    text = krl("DECL FRAME F", "$VEL.CP=0.2", *rows)
    made = converted(text, "krl", target)
    source = read(text, "krl")
    runs = runs_of(source, made, target, (ROBOT, ROBOT))
    found = receipt_of(link(source), made.translated, target, tuple(made.files), runs, (ROBOT, ROBOT))
    told = found.verdict.objections
    assert all("turned by" in one.says for one in told)
    assert (not told) is same


def test_a_loop_whose_body_changes_its_counter_is_no_for_in_rapid():
    """A counter is only read there, and a controller loads no module that sets it."""
    text = translated(krl("DECL INT I", "FOR I=1 TO 6", "WAIT SEC I", "I=I+1", "ENDFOR"), "krl", "rapid")
    assert "FOR " not in text
    assert "WHILE I<=6 DO" in text


@pytest.mark.parametrize(
    ("target", "bound"),
    [("inform", r"SET (D\d+) D\d+\s+FOR D\d+ START= 1 TO \1\b"), ("tp", r"R\[\d+:bound\]")],
)
def test_a_bound_that_its_loop_changes_is_what_it_was_at_the_beginning(target, bound):
    rows = ("DECL INT I,N", "N=3", "FOR I=1 TO N", "N=N+1", "WAIT SEC I", "ENDFOR")
    assert re.search(bound, translated(krl(*rows), "krl", target))
    plain = translated(krl(*rows[:3], *rows[4:]), "krl", target)
    assert not re.search(bound, plain)


def test_a_relative_move_names_the_frame_it_counts_in_for_inform():
    """IMOV without a frame counts in the base, wherever the variable's numbers stand."""
    turned = "$BASE={X 0,Y 0,Z 100,A 90,B 0,C 0}"
    rows = (
        "$VEL.CP=0.2",
        "$TOOL=$NULLFRAME",
        *poses((900, 0, 400)),
        "LIN_REL {X -50}",
        turned,
        "LIN_REL {X -50}",
    )
    found = re.findall(
        r"IMOV P\d+ V=\d+.0 PL=0(.*)", translated(krl("$BASE=$NULLFRAME", *rows), "krl", "inform")
    )
    assert [row.strip() for row in found] == ["BF", "UF#(1)"]


def test_an_output_that_switches_without_its_delay_is_left_out_for_the_exit_status():
    text = module("SetDO\\SDelay:=0.5,do1,1;", "WaitTime 1;")
    made = converted(text, "rapid", "krl")
    runs = runs_of(read(text, "rapid"), made, "krl", (ROBOT, None))
    told = verdict_of(made.translated, runs, ()).objections
    assert [(one.kind, "delay" in one.says) for one in told] == [("left-out", True)]


def test_a_bound_on_turning_beyond_what_krl_takes_is_noted():
    made = converted(
        module("MoveL p1,v100,fine,tool0;", "MoveL p2,v100,fine,tool0;", data=TARGETS), "rapid", "krl"
    )
    assert any("400 deg/s at most, where up to 500" in note for note in made.translated.notes)


@pytest.mark.parametrize("target", ["rapid", "tp", "inform", "urscript"])
def test_a_trigger_acts_at_the_next_move_whatever_waits_before_it(target):
    """It was done where it is written, two seconds before the arm leaves."""
    rows = (
        "$VEL.CP=0.2", *poses((900, 0, 400)), "TRIGGER WHEN DISTANCE=0 DELAY=0 DO $OUT[19]=TRUE",
        "$OUT[18]=FALSE", "WAIT SEC 2", *poses((900, 100, 400)), "WAIT SEC 1",
    )  # fmt: skip
    text = krl(*rows)
    made = converted(text, "krl", target)
    assert not [loss for loss in made.translated.losses if "at which move" in loss.says]
    for plan in (run(read(text, "krl"), robot=ROBOT), run_converted(made, target, ROBOT)):
        kinds = [int(plan.kind[row]) for row in range(len(plan.kind))]
        steps = [kind for kind in kinds if kind in (StepKind.MOVE, StepKind.WAIT, StepKind.SIGNAL)]
        wait = steps.index(StepKind.WAIT)
        assert steps[wait : wait + 3] == [StepKind.WAIT, StepKind.SIGNAL, StepKind.MOVE]


@pytest.mark.parametrize(
    ("target", "reading"),
    [
        ("rapid", r"MoveL CRobT\(\\Tool:=tool_2\\WObj:=frame_3\),\S+,fine,tool_2\\WObj:=frame_3;"),
        (
            "urscript",
            r"movel\(pose_trans\(frame_3, pose_trans\(pose_inv\(frame_3\), get_actual_tcp_pose\(\)\)\)",
        ),
        ("inform", r"GETS PX000 \$PX001\s+MOVL P000 "),  # a variable keeps the base that it was read in
    ],
)
def test_a_move_to_where_the_arm_is_moves_nothing_whatever_tool_and_frame_hold(target, reading):
    rows = (
        "$VEL.CP=0.2", "$TOOL=TOOL_DATA[1]", "$BASE=$NULLFRAME", *poses((900, 0, 400)),
        "$TOOL=TOOL_DATA[2]", "$BASE=BASE_DATA[3]", "LIN $POS_ACT",
    )  # fmt: skip
    assert re.search(reading, translated(krl(*rows), "krl", target))


@pytest.mark.parametrize("target", ["krl", "urscript", "inform", "tp"])
def test_a_move_to_where_the_arm_is_with_the_tool_of_the_move_before_is_refused(target):
    """CRobT() reads with the tool of the last move: the arm moves by the difference of both tools."""
    data = [*TARGETS, "PERS tooldata tG:=[TRUE,[[0,0,150],[1,0,0,0]],[1,[0,0,50],[1,0,0,0],0,0,0]];"]
    for here in ("CRobT()", "Offs(CRobT(),0,0,10)"):
        other = module("MoveL p1,v100,fine,tool0;", f"MoveL {here},v100,fine,tG;", data=data)
        assert any("where the arm is" in says for says in refused(other, "rapid", target).values())
        same = module("MoveL p1,v100,fine,tG;", f"MoveL {here},v100,fine,tG;", data=data)
        assert not [loss for loss in losses(same, "rapid", target) if loss.leaves_out]


# --- digital signals, numbers in RAPID, that are computed with ---


@pytest.mark.parametrize(
    ("target", "computed", "asked", "inverted"),
    [
        (
            "krl",
            r"x\w*=number_of_state\(\$IN\[1\]\)\+2\*number_of_state\(\$IN\[2\]\)",
            r"IF number_of_state\(\$IN\[1\]\)\+number_of_state\(\$IN\[2\]\)==2 THEN",
            r"\$OUT\[3\]=NOT \$OUT\[3\]",
        ),
        (
            "urscript",
            r"x = number_of_state\(get_standard_digital_in\(1\)\) \+ 2 \* number_of_state",
            r"if \(number_of_state\(\S+\)\) \+ number_of_state\(\S+\)\) == 2\)",
            r"set_standard_digital_out\(3, not \(get_standard_digital_out\(3\)\)\)",
        ),
        (
            "tp",
            r"R\[(\d+):\S+\]=DI\[1\] ;\s+\d+:  R\[(\d+):\S+\]=DI\[2\] ;\s+\d+:  R\[\S+\]=\(R\[\1:\S+\]\+2\*R\[\2",
            r"IF \(R\[\S+\]\+R\[\S+\]=2\) THEN",
            r"DO\[3\]=\(!DO\[3\]\)",
        ),
        (
            "inform",
            r"DIN B000 IN#\(1\)\s+DIN B001 IN#\(2\)\s+SET R\d+  EXPRESS B000 \+ 2 \* B001",
            r"SET (R\d+)  EXPRESS B000 \+ B001\s+IFTHEN \1=2",
            r"IFTHEN OT#\(3\)=OFF\s+DOUT OT#\(3\) ON",
        ),
    ],
)
def test_digital_signals_that_are_computed_with_are_numbers(target, computed, asked, inverted):
    """They stood in the arithmetic of languages in which they are states, and a sum was compared with ON."""
    rows = ("x:=di1+2*di2;", "IF di1+di2=2 THEN", "x:=5;", "ENDIF", "SetDO do3,1-do3;")
    text = translated(module(*rows, data=TARGETS), "rapid", target)
    for shape in (computed, asked, inverted):
        assert re.search(shape, text), text


@pytest.mark.parametrize(
    ("target", "shape"), [("krl", r"number_of_state\(\$IN\[1\]\)>0"), ("inform", "IFTHEN B000>0")]
)
def test_a_digital_signal_that_is_more_than_0_is_a_number(target, shape):
    assert re.search(shape, translated(module("IF di1>0 x:=1;", data=TARGETS), "rapid", target))


def test_a_digital_output_that_is_set_to_a_number_is_on_where_that_is_not_0():
    """DOUT of an OT# takes ON, OFF or a byte."""
    text = translated(module("x:=gi1;", "SetDO do3,x;", data=TARGETS), "rapid", "inform")
    assert re.search(r"IFTHEN (\w\d+)<>0\s+DOUT OT#\(3\) ON\s+ELSE\s+DOUT OT#\(3\) OFF", text), text


@pytest.mark.parametrize("target", ["krl", "tp", "inform", "urscript"])
def test_a_pose_of_a_table_that_gets_another_turn_stays_at_its_place(target):
    """In TP the element was zeroed, and its place then added to itself."""
    data = (
        "VAR robtarget c{2,2}:=[[[[900,1,400],[0,1,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]],"
        "[[900,2,400],[0,1,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]]],"
        "[[[900,3,400],[0,1,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]],"
        "[[900,4,400],[0,1,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]]]];",
        "VAR num a;",
    )
    rows = (
        "FOR i FROM 1 TO 2 DO", "FOR j FROM 1 TO 2 DO", "c{i,j}.rot:=OrientZYX(10*i,0,180);",
        "MoveL c{i,j},v100,fine,tool0;", "c{i,j}.trans:=[800,10*j,350];", "MoveL c{i,j},v100,fine,tool0;",
        "ENDFOR", "ENDFOR",
    )  # fmt: skip
    text = module(*rows, data=data)
    plan = read(text, "rapid")
    there = run_elsewhere(text, "rapid", target)
    found = compare_plans(run(plan, robot=ROBOT), there)
    assert not found.found


def test_a_turn_that_is_computed_from_the_pose_itself_is_computed_whole():
    rows = ("p.rot:=OrientZYX(EulerZYX(\\X,p.rot),0,EulerZYX(\\Z,p.rot));", "MoveL p,v100,fine,tool0;")
    data = ("VAR robtarget p:=[[900,0,400],[0,1,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];",)
    text = module("p.rot:=OrientZYX(10,0,180);", *rows, data=data)
    there = run_elsewhere(text, "rapid", "krl")
    assert not compare_plans(run(read(text, "rapid"), robot=ROBOT), there).found


def test_the_opposite_of_an_exclusive_or_is_no_and_of_both_opposites():
    """A loop that jumps out became `if (not a and not b)`, which both true do not leave."""
    rows = ("WHILE a XOR b DO", "x:=x+1;", "IF x=3 GOTO out;", "a:=di1=1;", "ENDWHILE", "out:", "x:=9;")
    data = (*TARGETS, "VAR bool a:=FALSE;", "VAR bool b:=FALSE;")
    assert "if (not (a xor b)):" in translated(module(*rows, data=data), "rapid", "urscript")


def test_no_condition_of_tp_is_inverted_twice():
    text = translated(
        module("IF NOT di1=1 AND x>2 XOR b Stop;", data=(*TARGETS, "VAR bool b;")), "rapid", "tp"
    )
    assert "!!" not in text
    assert "OR DI[1] AND 0>2 AND R[1:b]<>0" in text  # behind a first half of its own: the line takes 20 items


@pytest.mark.parametrize("target", ["rapid", "tp", "urscript", "inform"])
def test_a_wait_of_less_than_no_time_is_one_of_none(target):
    """KRL passes it; other controllers refuse to load or to run it, and INFORM waited for 0.01 s."""
    none = krl(*HOME, "LIN {X 900,Y 0,Z 400,A 0,B 90,C 0}", "WAIT SEC 0")
    assert translated(none.replace("SEC 0", "SEC -1"), "krl", target) == translated(none, "krl", target)


def test_a_whole_division_of_what_may_be_a_fraction_is_told_where_the_target_rounds_it():
    """3.5 DIV 2 is 1 in TP and DIV D000 2 of 4, which is 2, in INFORM."""
    says = "what is divided may be a fraction, which is rounded: INFORM divides whole numbers"
    text = tp("R[1]=7/2", "R[2]=R[1] DIV 2", "R[3]=7 DIV 2")
    found = [loss.line for loss in converted(text, "tp", "inform").translated.losses if says in loss.says]
    assert found == [7]


@pytest.mark.parametrize("target", ["tp", "inform"])
def test_signals_in_arithmetic_of_a_condition_before_a_statement_are_read_before(target):
    """`PAUSE IFEXPRESS IN#(1) + IN#(2)=2` and `IF (DI[1]+DI[2]=2) THEN` do not load."""
    rows = ("IF di1+di2=2 Stop;", "IF di1+di2=2 RETURN;", "IF di1*2=2 there;", "x:=1;")
    text = module(*rows, data=TARGETS).replace("ENDMODULE", "PROC there()\r\nx:=2;\r\nENDPROC\r\nENDMODULE")
    assert not re.search(r"(IN#\(\d\)|DI\[\d\]) ?[+*]", translated(text, "rapid", target))


@pytest.mark.parametrize("target", ["krl", "tp", "inform", "urscript"])
def test_another_number_than_0_switches_a_digital_output_on(target):
    rows = ("SetDO do1,2;", "x:=x+2;", "SetDO do2,x;", "SetDO do3,0;")
    assert not objections(module(*rows, data=TARGETS), "rapid", target)


@pytest.mark.parametrize("target", ["krl", "tp", "inform", "urscript"])
@pytest.mark.parametrize(
    "rows",
    [
        ("WaitUntil di1+di2=1;",),
        ("WHILE di1=0 DO", "ENDWHILE"),
        ("WHILE di1=0 DO", "! nothing", "ENDWHILE"),
        ("WHILE di1=0 DO", "WaitTime 0.05;", "ENDWHILE"),
    ],
)
def test_a_loop_that_waits_for_a_signal_is_no_difference(rows, target):
    """In URScript it pauses for a step, as the controller stops a loop that takes no time."""
    text = module(*rows, "SetDO do3,1;", data=TARGETS)
    assert not objections(text, "rapid", target)
    if target == "urscript":
        assert re.search(r"while .*\n +(sync|sleep)\(", translated(text, "rapid", target))


def objections(text, vendor, target):
    source, made = read(text, vendor), converted(text, vendor, target)
    runs = runs_of(source, made, target, (ROBOT, ROBOT))
    found = receipt_of(link(source), made.translated, target, tuple(made.files), runs, (ROBOT, ROBOT))
    return found.verdict.objections


def test_a_job_of_no_file_gets_a_state_as_a_number():
    """ARGFON is no argument."""
    assert "CALL JOB:elsewhere ARGF1 ARGF0" in translated(module("elsewhere TRUE,FALSE;"), "rapid", "inform")


def test_a_called_routine_changes_no_index_of_its_caller():
    """`whole_index` was one variable of all routines: the function below changed it before the element was set."""
    more = "FUNC num up(num x)\r\nRETURN Trunc(x)+1;\r\nENDFUNC\r\nENDMODULE"
    data = ("VAR num m{9};", "VAR num n:=2;", "VAR num k;")
    text = module("n:=n*1.5;", "m{n}:=up(7);", "SetAO ao1,m{3};", data=data).replace("ENDMODULE", more)
    found = run_elsewhere(text, "rapid", "krl")
    assert not any(d.is_error for d in found.diagnostics)
    written = translated(text, "rapid", "krl")
    assert written.count("DECL INT whole_index\r\n") == 2


# --- whole numbers that nothing sets ------------------------------------------------------------------------


def test_registers_that_krl_divides_as_integers_are_asked_to_hold_whole_numbers():
    """FANUC's registers hold fractions too; of those that others set nobody knows."""
    rows = ("R[5]=R[1] MOD 4", "R[6]=R[2] DIV 3", "R[2]=6", "R[3]=7", "R[7]=R[3] MOD 2", "R[8]=R[9]")
    made = converted(tp(*rows), "tp", "krl")
    asked = {says: list(things) for says, things in made.translated.asks.items() if "whole" in says}
    assert asked == {"see that these hold whole numbers when it starts": ["R1", "R2"]}


def test_a_number_that_gets_one_of_which_nobody_knows_is_no_integer():
    made = converted(tp("R[7]=R[8]", "R[6]=R[7] MOD 2"), "tp", "krl")
    assert b"REAL R7=0.0" in b"".join(made.files.values())
    assert any("may be a fraction" in loss.says for loss in made.translated.losses)


# --- loops that the controller takes for endless ----------------------------------------------------------------


def test_numbered_steps_that_only_ask_take_time():
    """URScript's controller stops a program whose loop neither waits nor moves; between the moves it asks in turn."""
    rows = (
        "LBL[1]", "IF DI[1]=ON,JMP LBL[2]", "IF DI[2]=ON,JMP LBL[3]", "IF R[1]>5,JMP LBL[4]", "JMP LBL[1]", "LBL[2]",
        "L P[1] 100mm/sec FINE", "JMP LBL[1]", "LBL[3]", "L P[2] 100mm/sec FINE", "IF DI[3]=OFF,JMP LBL[1]", "LBL[4]",
        "DO[1]=ON", "JMP LBL[1]",
    )  # fmt: skip
    text = translated(tp(*rows, positions=(P1, P2)), "tp", "urscript")
    steps = re.split(r"\n    (?:el)?if \(step == \d+\):\n", text)[1:]
    idle = [step for step in steps if "sync()" in step]
    assert idle
    assert not [step for step in idle if "movel" in step]
    # Whoever follows the steps without a move passes one with sync().
    leads = {at: {int(to) for to in re.findall(r"step = (\d+)", step)} for at, step in enumerate(steps)}
    quick = {at for at, step in enumerate(steps) if "movel" not in step and "sync()" not in step}
    while ends := {at for at in quick if not leads[at] & quick}:
        quick -= ends
    assert not quick


@pytest.mark.parametrize(("row", "waits"), [("n = n + 1", False), ("k = k + 1", True)])
def test_a_loop_that_waits_for_somebody_else_takes_time(row, waits):
    rows = ["VAR num n:=0;", "VAR num k:=0;"]
    text = translated(
        module("WHILE n<5 DO", f"{row.replace('=', ':=')};", "ENDWHILE", data=rows), "rapid", "urscript"
    )
    assert ("sync()" in text) is waits


# --- truth values among numbers ---------------------------------------------------------------------------------

AS_TRUTHS = """.PROGRAM main()
  n = 4
  JMOVE home
  TWAIT 4+3*(n>2)
  y = (n==4)+(n==3)
  z = -(n>3)
  v = n>3
  TWAIT y+z+v+5
  m = 2^3
  TWAIT m
.END
.TRANS
home 600 0 500 0 180 0
.END
"""


@pytest.mark.parametrize("target", ["rapid", "krl", "tp", "inform", "urscript"])
def test_what_is_true_is_minus_one_in_as(target):
    """It was 1 in TP; a condition stood in the sums of RAPID and KRL, which no compiler takes."""
    waits = [1.0, 4.0, 8.0]  # 4 - 3; -1 + 1 - 1 + 5; 2 ** 3
    own, there = read(AS_TRUTHS, "as").plan(robot=ROBOT), run_elsewhere(AS_TRUTHS, "as", target)
    for plan in (own, there):
        assert [float(x) for x in plan.durations if x > 0.0] == pytest.approx(waits)
    assert not [one for one in losses(AS_TRUTHS, "as", target) if one.leaves_out]
    text = translated(AS_TRUTHS, "as", target)
    assert not re.search(r"[-+*] ?\(?-?\(\w+ ?[<>=]", text)


def test_a_signal_that_a_truth_chooses_is_refused():
    """SIGNAL (n>3) is SIGNAL -1, which switches output 1 off, or SIGNAL 0."""
    text = ".PROGRAM main()\n  n = 4\n  SIGNAL (n>3)\n  SIGNAL 5\n.END\n"
    gone = {one.line for one in losses(text, "as", "rapid") if one.leaves_out}
    assert gone == {3}


def test_hold_of_pdl2_is_a_stop():
    text = "PROGRAM p\nBEGIN\n  $DOUT[1] := TRUE\n  HOLD\n  $DOUT[1] := FALSE\nEND p\n"
    assert "Stop;" in translated(text, "pdl2", "rapid")


def test_val3_knows_xor():
    head = '<?xml version="1.0" encoding="utf-8" ?><Programs xmlns="http://www.staubli.com/robotics/VAL3/Program/2">'
    local = '<Local name="b" type="bool" size="1" /><Local name="c" type="bool" size="1" />'
    rows = "begin\n  b=true\n  if b xor c\n    delay(0.5)\n  endIf\nend"
    code = f"<Code><![CDATA[{rows}]]></Code>"
    text = f'{head}\n<Program name="start"><Locals>{local}</Locals>\n{code}</Program></Programs>\n'
    assert "IF b XOR c THEN" in translated(text, "val3", "rapid")


def test_products_and_inverses_of_constant_poses_are_poses_in_tp():
    """FANUC computes no product of poses: all that depended on one was left out."""
    rows = (
        "p1 = p[0.9, 0.1, 0.4, 0.3, 3.0, 0.2]",
        "p2 = pose_trans(p1, p[0.01, 0, -0.05, 0, 0, 0.5])",
        "p3 = pose_trans(pose_inv(p[0, 0.2, 0, 0, 0, 0.1]), p1)",
        "movej(p1, v=0.5)", "movel(p2, v=0.1)", "movel(p3, v=0.1)",
    )  # fmt: skip
    text = script(*rows)
    assert not [one for one in losses(text, "urscript", "tp") if one.leaves_out]
    own, there = read(text, "urscript").plan(robot=ROBOT), run_elsewhere(text, "urscript", "tp")
    targets = [plan.positions.position[plan.moves.target] for plan in (own, there)]
    turns = [plan.positions.quaternion[plan.moves.target] for plan in (own, there)]
    assert targets[0] == pytest.approx(targets[1], abs=2e-6)
    assert np.abs((turns[0] * turns[1]).sum(axis=1)) == pytest.approx(np.ones(3), abs=1e-9)


# --- offsets in registers that others set -------------------------------------------------------------------


@pytest.mark.parametrize("target", ["krl", "rapid", "inform", "urscript"])
@pytest.mark.parametrize("option", ["Offset", "Tool_Offset"])
def test_an_offset_turns_by_the_angles_that_somebody_else_gave_its_register(target, option):
    """The program sets one element; what an operator left in the others counts as well."""
    rows = ("UFRAME_NUM=1", "UTOOL_NUM=1", "PR[3,1]=5", f"L P[1] 300mm/sec FINE {option},PR[3]")
    text = tp(*rows, positions=((1, 1, 1, 900, 100, 400, 180, 0, 30),))
    source = read(text, "tp")
    made = converted(text, "tp", target)
    runs = runs_of(source, made, target, (ROBOT, ROBOT))
    receipt = receipt_of(link(source), made.translated, target, tuple(made.files), runs, (ROBOT, ROBOT))
    assert receipt.made_up
    for one in receipt.made_up:
        assert not one.found
    asked = {thing.partition(" (")[0] for things in made.translated.asks.values() for thing in things}
    assert "PV3" in asked or target == "inform"


# --- loops with fractions -----------------------------------------------------------------------------------


@pytest.mark.parametrize("target", ["inform", "krl", "tp", "urscript"])
@pytest.mark.parametrize(
    ("head", "rounds"),
    [
        ("FOR k FROM 1 TO x/2 DO", 3),  # 1, 2, 3: up to 3.5
        ("FOR k FROM 1 TO x/2 STEP 0.5 DO", 6),
        ("FOR k FROM x/2 TO 1 STEP -1 DO", 3),  # 3.5, 2.5, 1.5
        ("FOR k FROM 0.5 TO 2 DO", 2),
    ],
)
def test_loops_of_fractions_make_as_many_rounds_as_the_source(target, head, rounds):
    """Counters and bounds of KRL and INFORM are integers: a counter was one that never came to its end."""
    rows = ("x:=7;", "FOR k FROM 1 TO 2 DO", "SetDO do1,1;", "ENDFOR", head, "PulseDO do2;", "ENDFOR")
    plan = run_elsewhere(module("VAR num x;", *rows), "rapid", target)
    assert plan.kind.tolist() == [StepKind.SIGNAL] * (2 + rounds)


def test_informs_loops_count_with_integers_alone():
    rows = ("x:=7;", "FOR k FROM 1 TO x/2 DO", "PulseDO do1;", "ENDFOR")
    rows += ("FOR k FROM x/2 TO 1 STEP -1 DO", "PulseDO do2;", "ENDFOR")
    text = translated(module("VAR num x;", *rows), "rapid", "inform")
    loops = re.findall(r"^FOR .*", text, re.MULTILINE)
    assert [re.sub(r"\d+", "n", row.strip()) for row in loops] == ["FOR Dn START= n TO Dn"]
    assert re.search(r"^WHILE R\d+>=1", text, re.MULTILINE)


# --- whole numbers that are written out ---------------------------------------------------------------------


def test_a_fraction_that_is_rounded_is_no_number_of_an_integer():
    text = translated(module("VAR num x;", "x:=Round(2.5);", "x:=Trunc(-2.7);"), "rapid", "inform")
    assert not re.search(r"^SET [DBI]\d+ -?\d*\.", text, re.MULTILINE)


# --- CONTINUE before what takes several lines ---------------------------------------------------------------


def test_krls_continue_stands_before_each_line_that_reads_the_controller():
    """It holds for the next line alone: the corner before became a stop at the next reading."""
    moves = ("MoveL p1,v100,z10,tool0;", "v:=CPos(\\Tool:=tool0\\WObj:=wobj0);", "MoveL p2,v100,fine,tool0;")
    text = translated(module("VAR pos v;", *moves, data=TARGETS), "rapid", "krl")
    rows = [row.strip() for row in text.splitlines()]
    reading = [n for n, row in enumerate(rows) if "$POS_ACT" in row]
    assert len(reading) == 3
    assert all(rows[n - 1] == "CONTINUE" for n in reading)


# --- data that keep their values ----------------------------------------------------------------------------


def test_texts_and_positions_that_a_run_changes_are_to_be_set_back_in_krl():
    """RAPID's VAR begins anew with each start, KRL's lists keep what the last run left."""
    data = (TARGETS[0].replace("CONST", "VAR"), *TARGETS[1:], 'VAR string s:="a";', 'VAR string t:="b";')
    rows = ("p1.trans.z:=p1.trans.z+10;", "MoveL p1,v100,fine,tool0;", 's:=s+"x";', "TPWrite t;")
    made = converted(module(*rows, data=data), "rapid", "krl")
    asked = [list(things) for says, things in made.translated.asks.items() if "set these back" in says]
    assert asked == [["p1", "s"]]


# --- remainders of numbers below zero -----------------------------------------------------------------------


@pytest.mark.parametrize("target", ["tp", "urscript", "krl", "inform"])
def test_a_remainder_is_told_where_what_is_divided_may_be_below_zero(target):
    rows = (
        "FOR i FROM 0 TO 9 DO",
        "x:=i MOD 3;",
        "ENDFOR",
        "n:=n+1;",
        "x:=n MOD 4;",
        "z:=n-5;",
        "x:=z MOD 4;",
    )
    found = converted(module("VAR num n;", "VAR num z;", *rows, data=TARGETS), "rapid", target)
    told = [one.line for one in found.translated.remarks if "which sign MOD" in one.says]
    assert told == [6 + 8]


def test_a_tool_by_a_computed_number_that_is_0_is_no_element_of_an_array():
    """Public bas.src: below 1 it is the flange; RAPID's arrays begin at 1, and the program stopped there."""
    rows = ("DECL INT N", "N=0", "BAS(#TOOL,N)", "BAS(#BASE,N)", *poses((900, 0, 500)))
    text = translated(krl(*HOME, *rows), "krl", "rapid")
    code_rows = code(text, "!")
    for array, none in (
        ("tool:=numbered_tools{N};", "tool:=tool0;"),
        ("frame:=numbered_frames{N};", "frame:=wobj0;"),
    ):
        at = code_rows.index(array)
        assert code_rows[at - 3 : at + 2] == ["IF N<=0 THEN", none, "ELSE", array, "ENDIF"]


POLLS = {
    "to the end": ("LBL[1]", "IF DI[1]=ON,JMP LBL[2]", "JMP LBL[1]", "LBL[2]"),
    "back": ("LBL[1]", "IF DI[1]=OFF,JMP LBL[1]"),
    "back, with a pause": ("LBL[1]", "WAIT .05(sec)", "IF DI[1]=OFF,JMP LBL[1]"),
    "either": ("LBL[1]", "IF DI[1]=OFF OR DI[2]=OFF,JMP LBL[1]"),
    "both, with an output": (
        *("LBL[1]", "DO[5]=ON", "WAIT .05(sec)", "IF DI[1]=ON AND DI[2]=ON,JMP LBL[2]", "DO[5]=OFF"),
        *("JMP LBL[1]", "LBL[2]"),
    ),
    "several": (
        *("WAIT DI[2]=ON", "LBL[1]", "IF DI[1]=OFF,JMP LBL[1]", "LBL[2]", "IF DI[3]=OFF,JMP LBL[2]"),
        "WAIT DI[4]=ON",
    ),
    "two ways out": (
        *("LBL[1]", "IF DI[1]=ON,JMP LBL[2]", "IF DI[2]=ON,JMP LBL[3]", "JMP LBL[1]", "LBL[2]", "DO[1]=ON"),
        *("JMP LBL[4]", "LBL[3]", "DO[2]=ON", "LBL[4]"),
    ),
    "two ways out, slowly": (
        *("LBL[40]", "IF DI[7]=ON AND DI[6]=ON,JMP LBL[10]", "IF DI[4]=ON AND DI[3]=ON,JMP LBL[20]"),
        *(
            "MESSAGE[WAITING]",
            "WAIT 1.00(sec)",
            "JMP LBL[40]",
            "LBL[10]",
            "DO[1]=ON",
            "JMP LBL[50]",
            "LBL[20]",
        ),
        *("DO[2]=ON", "LBL[50]"),
    ),
    "a register": ("LBL[1]", "IF R[1]=0,JMP LBL[1]"),
}


@pytest.mark.parametrize("target", ["krl", "rapid", "inform", "urscript"])
@pytest.mark.parametrize("rows", POLLS.values(), ids=POLLS)
def test_jumps_that_ask_an_input_again_and_again_are_a_wait_for_it(rows, target):
    """In URScript they are a loop that pauses, or steps with numbers; a loop that only pauses is read as a wait."""
    assert not objections(tp(*rows, "DO[3]=ON"), "tp", target)


def test_jumps_of_inform_that_ask_an_input_are_a_wait_for_it():
    rows = ("*L", "JUMP *L IF IN#(1)=OFF", "*M", "TIMER T=0.10", "JUMP *M IF IN#(2)=OFF", "DOUT OT#(1) ON")
    assert not objections(inform(*rows), "inform", "urscript")


def test_no_loop_of_tp_counts_to_a_fraction_that_is_written_out():
    """Constants of FOR are whole there; ENDFOR would go on while 3 is less than 3.5, as no other language does."""
    program = read_source(decode(tp("FOR R[1]=1 TO 3.5", "DO[1]=ON", "ENDFOR").encode(), "PART.LS"))
    assert [d.line for d in program.diagnostics if d.is_error] == [6]
    text = ".PROGRAM part()\nFOR k = 1 TO 3.5\nSIGNAL 1\nEND\nFOR k = 1 TO 3\nSIGNAL 2\nEND\n.END\n"
    made = translated(text, "as", "tp")
    assert "3.5" in made
    assert re.search(r"FOR R.*=1 TO 3 ;", made)
    assert not re.search(r"FOR .*3\.5", made)
    assert not objections(text, "as", "tp")


@pytest.mark.parametrize(("angle", "told"), [(0, False), (15, True)])
@pytest.mark.parametrize("target", ["krl", "inform"])
def test_an_incremental_move_that_turns_the_tool_is_told(target, angle, told):
    """How its angles add to those of the arm is in no manual at hand; LIN_REL was "exact"."""
    positions = ((1, 0, 1, 900, 0, 500, 180, 0, 0), (3, 0, 1, 10, 20, 30, 0, 0, angle))
    text = tp("J P[1] 50% FINE", "L P[3] 100mm/sec FINE INC", positions=positions)
    found = [x for x in converted(text, "tp", target).translated.losses if "turns the tool" in x.says]
    assert bool(found) is told


# Values and operators that FANUC takes within one pair of parentheses: "approximately 20" (R-30iB, mixed logic).
_ITEM = re.compile(
    r"\w+\[[^\]]*\](?:\[[^\]]*\])?|\b\d+(?:\.\d+)?\b|\bON\b|\bOFF\b|AND|OR|DIV|MOD|<>|<=|>=|[-!+*/<>=]"
)
_LONG = {
    "a sum": "a:=(a+2)*(a-3)+(a*4)/(a+5)-a*a*a+a/7+(a-8)*(a+9)*2-a+11*a-12/(a+13);",
    "a condition": "IF a>1 AND a<20 AND (di1=1 OR di2=1) AND (di3=1 OR di4=0) AND NOT (di5=1 AND di6=1) AND a<>7 "
    "AND a<>8 AND a<>9 SetDO do1,1;",
    "a value": "b:=(di1=1 AND di2=1) XOR (a>1 AND a<20) OR (di3=1 AND di4=1 AND a=1) OR (di5=1 AND a<0 AND a>-3);",
    "a loop": "WHILE a<3 AND (di1=0 OR di2=0) AND (di3=0 OR di4=0) AND (di5=0 OR di6=0) AND (di7=0 OR di8=0 OR a<9) "
    "DO Incr a; ENDWHILE",
    "a wait": "WaitUntil (di1=1 AND di2=1 AND di3=1) OR (di4=1 AND di5=1 AND di6=1) OR (di7=1 AND di8=1 AND a<9) "
    "OR (a>0 AND a<7 AND a<>3);",
    "a wait with a limit": "WaitUntil (di1=1 AND di2=1 AND di3=1) OR (di4=1 AND di5=1 AND di6=1) OR (di7=1 AND di8=1 "
    "AND a<0) OR (a>90 AND a<95 AND a<>93)\\MaxTime:=2\\TimeFlag:=b;",
    "an offset": "MoveL Offs(p,a*2+a*3-a*4+a*5-a*6+a*7-a*8+a*9,0,a+a+a+a+a+a+a+a+a+a+a+a+a),v100,fine,tool0;",
}  # fmt: skip


@pytest.mark.parametrize("row", _LONG.values(), ids=_LONG)
def test_no_instruction_of_tp_has_more_values_and_operators_than_the_controller_takes(row):
    """One of 47 was written, "all exact", which no pendant takes: parts of it stand in registers before."""
    point = "CONST robtarget p:=[[900,0,500],[0,1,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];"
    text = module(*row.replace(" DO Incr a; ", " DO\r\nIncr a;\r\n").split("\r\n"), "SetAO ao1,a;", "IF b SetDO do9,1;",
                  data=("VAR num a:=1;", "VAR bool b;", point))  # fmt: skip
    for line in code(translated(text, "rapid", "tp"), "!"):
        for inside in re.findall(r"\(.*\)", re.sub(r"\(sec\)", "", line)):
            assert len(_ITEM.findall(inside)) <= 20, line
    assert not [one for one in objections(text, "rapid", "tp") if "waits of" not in one]


@pytest.mark.parametrize("target", ["inform", "tp"])
@pytest.mark.parametrize("way", ["flag", "handler"])
def test_a_wait_that_a_loop_asks_for_ends_at_its_limit(target, way):
    """What INFORM cannot ask for in a WAIT became a loop without the limit: the job never went on."""
    asked = "WaitUntil double(a)>3 AND di1=1\\MaxTime:=3"
    rows = (
        (f"{asked}\\TimeFlag:=b;", "IF b SetDO do1,1;")
        if way == "flag"
        else (f"{asked};", "SetDO do2,1;", "ERROR", "SetDO do1,1;", "TRYNEXT;")
    )
    function = ("ENDPROC", "FUNC num double(num x)", "RETURN 2*x;", "ENDFUNC", "PROC other()")
    text = module(*rows, *function, data=("VAR num a:=1;", "VAR bool b;"))
    plan = run_elsewhere(text, "rapid", target)
    assert sum(plan.durations[plan.row[plan.kind == StepKind.WAIT]].tolist()) == pytest.approx(3.0, abs=0.02)
    assert (plan.kind == StepKind.SIGNAL).sum() == (1 if way == "flag" else 2)
    told = [x for x in converted(text, "rapid", target).translated.losses if "until its limit" in x.says]
    assert [x.fate for x in told] == [Fate.APPROXIMATED]


_HALF_SPEED = {
    "rapid": module("MoveL p,v500,fine,tool0;", "VelSet 50,5000;", "MoveL q,v500,{},tool0;", "VelSet 90,5000;",
                    "MoveL p,v500,fine,tool0;", "WaitTime 1;", "VelSet 80,5000;", "MoveL q,v500,fine,tool0;",
                    data=tuple(f"CONST robtarget {name}:=[[{x},0,500],[0,1,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];"
                               for name, x in (("p", 900), ("q", 950)))),
    "tp": tp("L P[1] 500mm/sec FINE", "OVERRIDE=50%", "L P[2] 500mm/sec {}", "OVERRIDE=90%", "L P[1] 500mm/sec FINE",
             "WAIT 1.00(sec)", "OVERRIDE=80%", "L P[2] 500mm/sec FINE",
             positions=((1, 0, 0, 900, 0, 500, 180, 0, 0), (2, 0, 0, 950, 0, 500, 180, 0, 0))).replace("{{}}", "{}"),
}  # fmt: skip


@pytest.mark.parametrize(("vendor", "stop", "corner"), [("rapid", "fine", "z10"), ("tp", "FINE", "CNT50")])
def test_an_override_of_krl_waits_for_the_moves_before_it_or_is_told(vendor, stop, corner):
    """The advance run sets `$OV_PRO` while moves before it are under way; it was "exact"."""
    for blend, waits in ((stop, 2), (corner, 1)):
        text = _HALF_SPEED[vendor].replace("{}", blend)
        rows = code(translated(text, vendor, "krl"), ";")
        before = [rows[at - 1] for at, row in enumerate(rows) if row.startswith("$OV_PRO")]
        assert before.count("WAIT SEC 0") == waits
        assert before[-1] in ("WAIT SEC 1", "WAIT SEC 1.0")
        told = [x for x in losses(text, vendor, "krl") if x.part == "order"]
        assert len(told) == 2 - waits


def test_an_override_of_krl_behind_a_move_is_told_elsewhere():
    rows = ("$OV_PRO=100", "LIN {X 900,Y 0,Z 500,A 0,B 90,C 0}", "$OV_PRO=50", "LIN {X 950,Y 0,Z 500,A 0,B 90,C 0}",
            "WAIT SEC 1", "$OV_PRO=80", "LIN {X 900,Y 0,Z 500,A 0,B 90,C 0}")  # fmt: skip
    for target in ("rapid", "tp", "inform", "urscript"):
        told = [x.line for x in losses(krl(*HOME, *rows), "krl", target) if "advance run sets it" in x.says]
        assert told == [2 + len(HOME), 4 + len(HOME)]  # and not behind the wait


@pytest.mark.parametrize(
    ("rows", "counts"),
    [
        (("n:=6;", "FOR i FROM 1 TO n DO"), True),
        (("n:=Round(7.6/2);", "FOR i FROM n TO 1 STEP -1 DO"), True),
        (("n:=8 DIV 2;", "FOR i FROM n-3 TO n*2-1 DO"), True),
        (("n:=GInput(gi1)+3;", "FOR i FROM 1 TO n DO"), True),
        (("n:=6/2;", "FOR i FROM 1 TO n DO"), False),  # 3, of a type that FOR refuses
        (("n:=7;", "FOR i FROM 1 TO n/2 DO"), False),
        (("n:=2.0*2;", "FOR i FROM n TO 1 STEP -1 DO"), False),
        (("n:=ai1+3;", "FOR i FROM 1 TO n DO"), False),
        (("n:=half(7);", "FOR i FROM 1 TO n DO"), False),
    ],
)
def test_for_of_tp_counts_between_whole_numbers_alone(rows, counts):
    """INTP-672, "Value type is not integer": a division, also one without a rest, stops the program at its FOR."""
    function = ("ENDPROC", "FUNC num half(num x)", "RETURN x/2;", "ENDFUNC", "PROC other()")
    text = module(*rows, "PulseDO do1;", "ENDFOR", *function, data=("VAR num n:=1;",))
    assert bool([row for row in code(translated(text, "rapid", "tp"), "!") if "FOR R[" in row]) is counts
    assert not objections(text, "rapid", "tp")


@pytest.mark.parametrize("target", ["inform", "tp"])
def test_no_text_stands_left_of_what_it_is_compared_with(target):
    """`IFTHENEXP "z"=S000`, `IF ('abc'='abc')`: jobs and listings have variables there, and SWITCH chooses by one."""
    rows = ('t:="q";', 'IF di1=1 t:="z";', 'IF "z"=t SetDO do1,1;', 'IF s="abc" SetDO do2,1;', "TEST 3", "CASE 3:",
            'WHILE "q"<>t AND 2<n DO', "n:=n-1;", "ENDWHILE", 'b:="z"=t;', "SetDO do6,1;", "ENDTEST", "TEST k",
            'CASE "x":', "SetDO do5,1;", "ENDTEST", 'IF s<>"abc" SetDO do3,1;', "IF b SetDO do4,1;",
            'WaitUntil "z"=t OR di3=1;')  # fmt: skip
    data = ('VAR string s:="abc";', "VAR string t;", "VAR num n:=3;", "VAR bool b;", 'CONST string k:="x";')
    text = module(*rows, data=data)
    made = "\n".join(code(translated(text, "rapid", target), "!"))
    assert not re.search(r"""['"]\s*(=|<>)""", made)
    assert not re.search(r"SWITCH\s+[\"'\d]", made)
    assert not objections(text, "rapid", target)


@pytest.mark.parametrize(("target", "shortest", "longest"), [("tp", 0.1, 25.5), ("krl", 0.1, 3.0)])
def test_pulses_are_as_long_as_the_target_takes_them(target, shortest, longest):
    """`DO[1]=PULSE,60sec` and `PULSE ($OUT[1],TRUE,0.05)` were "exact"; the controllers stop there."""
    for seconds in (shortest, longest):
        made = converted(module(f"PulseDO\\High\\PLength:={seconds},do1;"), "rapid", target).translated
        assert not [x for x in made.losses if x.fate is not Fate.EXACT]
    text = module("PulseDO\\High\\PLength:=0.05,do1;")
    assert [(x.part, x.size) for x in losses(text, "rapid", target)] == [("duration", pytest.approx(0.05))]
    assert re.search(r"PULSE.*,0\.1", translated(text, "rapid", target))
    assert "longest" in refused(module(f"PulseDO\\High\\PLength:={longest + 1},do1;"), "rapid", target)[3]


def test_texts_have_room_in_the_variables_of_the_target():
    """95 characters went into `DECL CHAR name[80]`, where KRL stops, and into INFORM's S000, of 32."""
    long = "a text of more than eighty characters, which a variable of the program holds until its very end"
    rows = (f'name = "{long}"', "if get_digital_in(1):", '  name = "short"', "end", f'if name == "{long}":',
            "  set_digital_out(1, True)", "end", f'textmsg("{long}")',
            f'textmsg("{long} ", get_digital_in(2))')  # fmt: skip
    made = translated(script(*rows), "urscript", "krl")
    assert all(int(size) >= len(long) for size in re.findall(r"DECL CHAR name\[(\d+)\]", made))
    assert all(len(said) <= 80 for said in re.findall(r'MsgNotify\("(.*)"\)', made))
    assert not objections(script(*rows), "urscript", "krl")
    assert set(refused(script(*rows), "urscript", "inform")) == {2, 6}
    short = translated(script(f'textmsg("{long} ", 5)'), "urscript", "inform")
    assert all(len(said) <= 32 for said in re.findall(r'"(.*?)"', short))


def test_a_fraction_switches_an_output_of_tp_on_as_elsewhere():
    """`DO[1]=R[1]` switches off what is less than 1 and greater than -1 (R-30iB, mixed logic instructions)."""
    text = module("x:=ai1;", "SetDO do1,x;", "SetDO do2,DOutput(do1);", data=("VAR num x;",))
    rows = code(translated(text, "rapid", "tp"), "!")
    assert any(re.search(r"DO\[1\]=\(R\[1:x\]<>0\)", row) for row in rows)
    assert any(re.search(r"DO\[2\]=\(DO\[1\]\)", row) for row in rows)
    assert not objections(text, "rapid", "tp")


@pytest.mark.parametrize(
    ("target", "told"), [("krl", True), ("inform", True), ("rapid", False), ("tp", False)]
)
def test_a_time_for_a_move_that_becomes_a_speed_is_told(target, told):
    """200 mm in 3 s are 66.7 mm/s without ramps; RAPID and TP have a time, which there stands for a speed."""
    rows = (
        "movel(p[0.4, 0.1, 0.3, 0, 3.14159, 0], a=1.2, v=0.25)",
        "movel(p[0.6, 0.1, 0.3, 0, 3.14159, 0], a=1.2, t=3)",
    )
    says = [loss.says for loss in losses(script(*rows), "urscript", target) if "whole move" in loss.says]
    assert bool(says) is told


def test_signals_of_a_ur_have_one_name():
    """`get_digital_in(n)`: "n: 8-9 go to the tool digital inputs" (script manual of e-Series); a box has eight more."""
    rows = ("set_digital_out(9, True)", "set_digital_out(8, get_digital_in(8))", "set_digital_out(3, True)")
    made = code(translated(script(*rows), "urscript", "rapid"), "!")
    assert {"SetDO to1,1;", "SetDO to0,DInput(ti0);", "SetDO do3,1;"} <= set(made)
    assert any(
        found.code == "P569" for found in read(script("set_digital_out(12, True)"), "urscript").diagnostics
    )
    outputs = ("SetDO do7,1;", "SetDO do8,1;", "WaitDI di12,1;", "SetDO do17,1;")
    made = code(translated(module(*outputs), "rapid", "urscript"), "#")
    wanted = (
        "standard_digital_out(7",
        "configurable_digital_out(0",
        "configurable_digital_in(4",
        "tool_digital_out(1",
    )
    assert all(any(word in row for row in made) for word in wanted)
    assert not objections(module(*outputs), "rapid", "urscript")
    text = krl("DECL INT i", "$OUT[9]=FALSE", "i=9", "$OUT[i]=$IN[i]")
    made = code(translated(text, "krl", "urscript"), "#")
    assert any("olp_set_digital_out(i, olp_digital_in(i))" in row for row in made)
    assert not objections(text, "krl", "urscript")


def test_a_fraction_that_leaves_an_output_of_fanuc_off_is_told():
    """Elsewhere what is not 0 switches it on."""
    text = tp("R[1]=1", "DO[1]=R[1]", "R[2]=R[1]/2", "DO[2]=R[2]")
    for target in ("rapid", "krl", "urscript", "inform"):
        lines = [loss.line for loss in losses(text, "tp", target) if "below 1" in loss.says]
        assert len(lines) == 1


def test_the_limit_of_waits_of_fanuc_is_one_for_all_programs():
    text = module("WaitDI di1,1\\MaxTime:=3\\TimeFlag:=b;", data=("VAR bool b;",))
    made = converted(text, "rapid", "tp").translated
    assert any(
        "$WAITTMOUT" in row for row in before_it_runs(link(read(text, "rapid")), made, "tp", None, True)
    )


def test_a_joined_text_that_outgrows_the_targets_variables_is_told():
    """RAPID's strings hold 80 characters, INFORM's 32; KRL's arrays are as long as what is joined."""
    start = "a text that grows with each step of the program until it has 80, "
    rows = (
        "x = 3",
        f's = str_cat("{start}", to_str(x))',
        's = str_cat(s, " and then some more of it")',
        "textmsg(s)",
    )
    told = {
        loss.line: loss.says for loss in losses(script(*rows), "urscript", "rapid") if loss.part == "text"
    }
    assert list(told) == [4]
    assert "up to 102 characters" in told[4]
    assert "CHAR s_1[102]" in translated(script(*rows), "urscript", "krl")
    assert not [loss for loss in losses(script(*rows), "urscript", "tp") if loss.part == "text"]
    loop = (
        's = ""',
        "i = 0",
        "while (i < 10):",
        '  s = str_cat(s, "ab")',
        "  i = i + 1",
        "end",
        "textmsg(s)",
    )
    for target in ("rapid", "krl", "inform", "tp"):
        assert any(
            "each pass" in loss.says for loss in losses(script(*loop), "urscript", target) if loss.line == 5
        )
    again = (
        "i = 0",
        "while (True):",
        '  s = "number "',
        "  s = str_cat(s, to_str(i))",
        "  textmsg(s)",
        "end",
    )
    for target in ("rapid", "krl", "inform", "tp"):
        assert not any("variables hold" in loss.says for loss in losses(script(*again), "urscript", target))


def test_what_a_script_takes_that_nothing_calls_is_asked_for():
    text = "MODULE M\nPROC pick(num h,bool fast)\nIF fast SetDO do1,1;\nWaitTime h;\nENDPROC\nENDMODULE\n"
    source = read(text, "rapid")
    for target, wanted in (("urscript", True), ("krl", False)):
        made = converted(text, "rapid", target).translated
        rows = before_it_runs(link(source), made, target, None, True)
        assert any(row.startswith("call pick with values") for row in rows) is wanted


def test_a_clock_that_nothing_starts_is_told():
    """KRL's `$TIMER[]` is one for all programs; RAPID's clock of the translation stands."""
    text = krl("WAIT FOR $IN[5] OR ($TIMER[1]>1000)")
    for target in ("rapid", "tp"):
        assert any("no statement here starts" in loss.says for loss in losses(text, "krl", target))
    started = krl("$TIMER[1]=0", "$TIMER_STOP[1]=FALSE", "WAIT FOR $IN[5] OR ($TIMER[1]>1000)")
    assert not any("no statement here starts" in loss.says for loss in losses(started, "krl", "rapid"))


def test_three_numbers_in_a_product_are_a_pos():
    """`pos * pos` is the vector product (RAPID overview); three numbers in brackets ended in a KeyError."""
    rows = ("a:=[1,2,3];", "b:=a*[1,0,0];", "WaitTime b.y;", "b:=[1,2,3]*2;", "WaitTime b.z;")
    text = module(*rows, data=("VAR pos a;", "VAR pos b;"))
    assert run_elsewhere(text, "rapid", "krl").durations.tolist() == [3.0, 6.0]
    assert not objections(text, "rapid", "krl")


def test_a_routine_that_a_move_calls_at_its_end_is_no_start():
    """`MoveLSync …,"done"` calls done, which as a start set its caller's variables to first values."""
    rows = ("n:=3;", 'MoveLSync p1,v100,fine,tool0,"done";', "total:=total+n;", "WaitTime total;")
    text = module(*rows, data=(*TARGETS, "VAR num n;", "VAR num total:=1;"))
    text = text.replace("ENDMODULE", "PROC done()\n n:=n+1;\n total:=total+1;\n Set do9;\nENDPROC\nENDMODULE")
    for target in ("krl", "tp", "inform"):
        made = with_starts(link(read(text, "rapid")).program)
        assert not any(r.starts for r in made.routines if r.name == "done")
        translation = converted(text, "rapid", target).translated
        assert not any("started and not called" in says for says in translation.asks)


def test_whole_numbers_beyond_32_bits_are_written_as_others():
    """An INT of KRL, a D of INFORM and an int of URScript have 32 bits; RAPID's num is none."""
    text = module("x:=2147483648;", "x:=-9999999999;", "x:=2147483647;", data=("VAR num x;",))
    for target in ("krl", "tp", "inform", "urscript"):
        made = translated(text, "rapid", target)
        assert "2147483648.0" in made
        assert "-9999999999.0" in made
        assert "2147483647.0" not in made


def test_waits_of_a_pendant_count_in_hundredths_of_a_second():
    text = module("WaitTime 0.128;", "WaitTime 0.25;")
    assert [loss.line for loss in losses(text, "rapid", "tp") if loss.part == "duration"] == [3]
    made = code(translated(text, "rapid", "tp"), "!")
    assert any("WAIT 0.13(sec)" in row for row in made)


def test_a_shift_with_angles_that_a_job_changes_in_part_is_refused():
    """The angles that its data begin with turn the tool; SETE of its height hid them."""
    points = (
        "C00000=400.000,100.000,300.000,180.0000,0.0000,20.0000",
        "P00010=10.000,20.000,-30.000,0.0000,0.0000,10.0000",
    )
    for angles, wanted in (("10.0000", True), ("0.0000", False)):
        shift = points[1].replace("10.0000", angles)
        text = inform(
            "SETE P010 (3) -20000", "SFTON P010", "MOVL C00000 V=100.0", "SFTOF", points=(points[0], shift)
        )
        told = losses(text, "inform", "rapid")
        assert any("may turn the tool" in loss.says for loss in told) is wanted


@pytest.mark.parametrize(
    "use",
    [
        "p4 = up(p1, 0.1)",
        "movel(up(p1, 0.1), v=0.1)",
        "sleep(point_dist(up(p1, 0.1), p1))",
        "sub(up(p1, 0.1))",
    ],
)
def test_a_function_that_moves_has_the_tool_of_the_statement_that_computes_with_it(use):
    """The first assignment of a name is its declaration, of which nothing thought that it calls."""
    rows = ("set_tcp(p[0,0,0.12,0,0,0])", "def up(pos, dz):", "  above = pose_add(pos, p[0,0,dz,0,0,0])")
    rows += ("  movel(above, v=0.2)", "  return above", "end", "def sub(pos):", "  movel(pos, v=0.1)", "end")
    text = script(*rows, "p1 = p[0.4, 0.1, 0.3, 0, 3.14159, 0]", use, "movel(p1, v=0.1)")
    function = re.search(r"FUNC robtarget up.*?ENDFUNC", translated(text, "urscript", "rapid"), re.DOTALL)
    assert function is not None
    assert "tool0" not in function[0]


def test_a_path_of_val3_that_only_its_axes_bound_has_no_speed_of_a_hundred_metres_a_second(tmp_path):
    """tmax 99999 is what a new motion descriptor has: its vel bounds the path."""
    folder = Path(__file__).parent.parent / "samples" / "val3"
    for name in ("handling.dtx", "handling.pjx", "drop.pgx", "start.pgx"):
        text = (folder / name).read_text(encoding="utf-8-sig")
        text = text.replace('tmax="120.5"', 'tmax="99999"').replace('vel="100"', 'vel="30"')
        (tmp_path / name).write_text(text, encoding="utf-8")
    program = olp.read(tmp_path / "start.pgx")
    assert any(found.code == "P578" for found in program.diagnostics)
    made = convert(
        link(program, "urscript").program,
        "urscript",
        Context(load_robot("staubli/tx2-90"), on_loss="comment"),
    )
    text = made.files[made.main].decode()
    assert "v=0.3" in text
    assert "v=99.999" not in text


AS_TABLES = """.TRANS
grip 12.5 -8.25 187.4 30 15 0
table 850.5 -210.25 305.75 -113 2.7 146.3
pick 110.5 45.25 20.125 -176 176 24
.END
.JOINTS
#start 5.5 -12.25 18.75 3.5 -47.25 21
.END
"""


def kawasaki(*lines, more=""):
    return ".PROGRAM main()\n" + "".join(f"{line}\n" for line in lines) + f".END\n{more}{AS_TABLES}"


@pytest.mark.parametrize(
    ("line", "move"),
    [("POINT #j = pick", "JMOVE #j"), ("POINT q = #start", "LMOVE q"), ("POINT #j = #start", "JMOVE #j")],
)
def test_axis_values_of_a_place_are_computed_with_the_tool_and_base_of_now(line, move):
    """A place in a variable of axis values, or the other way round: the base that holds for the move is another one."""
    text = kawasaki("TOOL grip", "BASE table", line, "BASE NULL", "TOOL NULL", move)
    for target in ("krl", "rapid", "tp", "urscript", "inform"):
        left = [loss for loss in losses(text, "as", target) if loss.leaves_out]
        assert bool(left) is ("#j = #" not in line), target


def test_where_the_arm_stands_needs_no_kinematics():
    text = translated(kawasaki("POINT #n = HERE", "d = DX(HERE)", "JMOVE #n"), "as", "krl")
    assert "_n=$AXIS_ACT" in text
    assert "d=$POS_ACT.X" in text


def test_an_approach_to_axis_values_is_none_to_a_pose():
    """`LIN _start:{Z -20}` of an E6AXIS, `RelTool` of a jointtarget: no compiler takes them."""
    text = kawasaki("LAPPRO #start,20")
    assert "RelTool(CalcRobT(" in translated(text, "as", "rapid")
    assert "get_forward_kin(" in translated(text, "as", "urscript")
    assert any(loss.leaves_out for loss in losses(text, "as", "krl"))


def test_a_distance_is_a_number():
    text = translated(kawasaki("d = DISTANCE(pick,table)", "d = d+1"), "as", "krl")
    assert "DECL REAL d" in text


def test_a_signal_by_a_variable_that_a_called_program_changes_has_no_fixed_number():
    more = ".PROGRAM sub(.a)\n.a = .a+3\n.END\n.PROGRAM show(.a)\nPRINT .a\n.END\n"
    text = kawasaki(".x = 5", ".y = 6", "CALL sub(.x)", "CALL show(.y)", "SIGNAL .x", "SIGNAL .y", more=more)
    written = translated(text, "as", "krl")
    assert "$OUT[5]" not in written
    assert "$OUT[6]=TRUE" in written


def test_a_variable_in_brackets_is_handed_over_as_a_copy():
    more = ".PROGRAM sub(.a)\n.a = .a+3\n.END\n"
    left = [loss.line for loss in losses(kawasaki(".x = 5", "CALL sub((.x))", more=more), "as", "krl")]
    assert 3 in left


def test_functions_in_conditions_take_registers_and_numbers():
    """Into TP, as in assignments; a loop computes them each time."""
    lines = (
        "n = BITS(1001,4)",
        "IF SQRT(n*n+1)>4 THEN",
        "SIGNAL 1",
        "END",
        "WHILE ABS(n-8)>3 DO",
        "n = n+1",
        "END",
    )
    text = translated(kawasaki(*lines), "as", "tp")
    assert re.findall(r"(?:SQRT|ABS)\[([^\]]*)", text) == ["R[2:temp_real", "R[2:temp_real"]


def test_jobs_name_signals_by_whole_numbers():
    text = translated(kawasaki("n = BITS(1001,4)", "x = n/2", "SIGNAL x", "SIGNAL x+3"), "as", "inform")
    assert re.findall(r"OT#\((.)", text) == ["D", "D"]


@pytest.mark.parametrize(("changed", "zone"), [("y = 0.02", "fine"), ("r = 0.02", r"z10\Z:=r * 1000.0")])
def test_a_corner_in_a_variable_that_is_zero_is_a_stop(changed, zone):
    """`movel(p1, r=r)` with r = 0 stops; `z10\\Z:=0` is passed, and the output behind it switches before."""
    rows = ("r = 0.0", "p1 = p[0.4,0.1,0.3,0,3.14,0]", "movel(p1, v=0.1, r=r)", "set_digital_out(1, True)")
    text = script(*rows, "if get_digital_in(2):", f"  {changed}", "end", "movel(p1, v=0.1, r=r)")
    assert f",{zone},tool0;" in translated(text, "urscript", "rapid")
    told = [
        loss for loss in losses(text, "urscript", "rapid") if "what follows may be done before" in loss.says
    ]
    assert bool(told) is (zone != "fine")
    assert ("CONTINUE" in translated(text, "urscript", "krl")) is (zone != "fine")


def test_a_whole_number_of_a_job_gets_no_fraction():
    text = krl("DECL INT i", "i=2.5", "i=-2.4", "$OUT[1]=TRUE")
    assert re.findall(r"SET D\d+ (\S+)", translated(text, "krl", "inform")) == ["3", "-2"]


@pytest.mark.parametrize("target", ["krl", "rapid"])
@pytest.mark.parametrize(("on", "speeds"), [(0, [250, 40, 250, 30, 250]), (1, [250, 20, 250, 30, 250])])
def test_a_speed_of_the_next_move_is_that_of_the_way_to_it(target, on, speeds):
    """SPEED without ALWAYS holds for one move: that of the last branch in the text was taken."""
    rows = ("SPEED 250 MM/S ALWAYS", "LMOVE a", "IF SIG(1001) THEN", "SPEED 20 MM/S", "ELSE", "SPEED 40 MM/S")
    rows += ("END", "LMOVE b", "LMOVE a", "SPEED 30 MM/S", "IF SIG(1001) THEN", "LMOVE b", "ELSE", "LMOVE c")
    points = ".TRANS\na 900 0 400 0 180 0\nb 900 100 400 0 180 0\nc 900 200 400 0 180 0\n.END\n"
    text = kawasaki(*rows, "END", "LMOVE a").replace(".TRANS\n", points.removesuffix(".END\n"), 1)
    given = {SignalKey("in", 1): (on,)}
    source = read(text, "as")
    made = converted(text, "as", target)
    given |= {SignalKey(NAMED_SIGNAL, "di1"): (on,)}
    for plan in (
        run(source, ROBOT, assumptions=Assumptions(inputs=given)),
        run_converted(made, target, ROBOT, source, given),
    ):
        assert [round(v * 1000) for v in plan.moves.travel] == speeds


@pytest.mark.parametrize(
    "rows",
    [
        ("SPEED 30 MM/S", "CALL sub"),
        ("SPEED 30 MM/S", "FOR i = 1 TO 2", "LMOVE pick", "END"),
        ("FOR i = 1 TO 2", "LMOVE pick", "SPEED 30 MM/S", "END"),
        ("IF SIG(1001) GOTO 10", "SPEED 30 MM/S", "10 LMOVE pick"),
        ("IF SIG(1001) THEN", "SPEED 30 MM/S", "END", "LMOVE pick"),
    ],
)
def test_a_speed_of_the_next_move_that_several_ways_may_take_is_told(rows):
    more = ".PROGRAM sub()\nLMOVE pick\n.END\n"
    told = [d for d in read(kawasaki(*rows, "LMOVE table", more=more), "as").diagnostics if d.code == "P589"]
    assert "next move" in told[0].message
    assert any(
        "next move" in loss.says for loss in losses(kawasaki(*rows, "LMOVE table", more=more), "as", "krl")
    )


def test_a_variable_that_a_called_program_gives_its_value_is_declared():
    more = ".PROGRAM sum(.n,.t)\n.t = .n*2\n.END\n.PROGRAM put(.&p)\nPOINT .&p = pick\n.END\n"
    text = kawasaki("CALL sum(3,total)", "CALL put(here1)", "LMOVE here1", "SIGNAL total", more=more)
    written = translated(text, "as", "krl")
    assert re.search(r"DECL REAL total", written)
    assert re.search(r"DECL E6POS here1", written)
    assert "not declared in the source" not in written


@pytest.mark.parametrize("target", ["tp", "inform", "krl", "rapid"])
@pytest.mark.parametrize("change", ["chg(k, a[k])", "step(a[k])"])
def test_the_element_that_a_call_hands_over_comes_back_though_its_index_changes(target, change):
    text = (
        "PROGRAM p\nVAR k : INTEGER\n a : ARRAY[5] OF INTEGER\n"
        "ROUTINE chg(n : INTEGER; z : INTEGER)\nBEGIN\n n := n + 1\n z := z + 7\nEND chg\n"
        "ROUTINE step(z : INTEGER)\nBEGIN\n k := k + 1\n z := z + 7\nEND step\n"
        f"BEGIN\n k := 2\n a[2] := 0\n a[3] := 0\n {change}\n"
        " IF a[2] = 7 THEN\n  DELAY 100\n ENDIF\n IF a[3] = 7 THEN\n  DELAY 300\n ENDIF\nEND p\n"
    )
    source = read(text, "pdl2")
    made = converted(text, "pdl2", target)
    for plan in (run(source, ROBOT), run_converted(made, target, ROBOT, source, {})):
        assert [step.duration for step in plan.steps()] == pytest.approx([0.1])


_LEFT_FOR_OTHERS = {
    "tp": (tp("UFRAME_NUM=2", "UTOOL_NUM=3"), {6, 7}),
    "krl": (
        krl("$TOOL=TOOL_DATA[2]", "$BASE=BASE_DATA[3]", "$VEL.CP=0.2", "$ACC.CP=1.0", "BAS(#VEL_PTP,30)"),
        {2, 3, 4, 5, 6},
    ),
    "rapid": (module("AccSet 50,100;"), {3}),
    "urscript": (script("set_tcp(p[0, 0, 0.1, 0, 0, 0])"), {2}),
}


@pytest.mark.parametrize("vendor", _LEFT_FOR_OTHERS)
@pytest.mark.parametrize("target", ["inform", "krl", "rapid", "tp", "urscript"])
def test_what_is_set_for_moves_of_other_programs_is_told(vendor, target):
    """Which are moved with it there, as it holds until it is changed: the translation writes it into moves alone."""
    text, lines = _LEFT_FOR_OTHERS[vendor]
    losses = converted(text, vendor, target).translated.losses
    told = {x.line for x in losses if x.part == "scope" and x.fate is Fate.APPROXIMATED}
    assert told == (set() if vendor == target else lines)  # its own settings stay as they are


@pytest.mark.parametrize("ways", [[], ["IF R[1]=1,JMP LBL[1]", "LBL[1]"]])
def test_what_a_move_takes_or_another_setting_ends_is_not_told(ways):
    """On one way or several."""
    rows = ["UFRAME_NUM=1", "UFRAME_NUM=2", "UTOOL_NUM=3", *ways, "J P[1] 50% FINE"]
    points = [(1, 2, 3, 900, 100, 400, 180, 0, 30)]
    made = converted(tp(*rows, "UFRAME_NUM=4", positions=points), "tp", "rapid").translated
    assert [x.line for x in made.losses if x.part == "scope"] == [6 + len(rows)]


@pytest.mark.parametrize("ways", [[], ["IF R[1]=1,JMP LBL[1]", "LBL[1]"]])
def test_what_a_routine_of_no_file_moves_with_is_asked_for(ways):
    rows = ["UFRAME_NUM=2", "UTOOL_NUM=3", *ways, "J P[1] 50% FINE", "CALL ELSEWHERE", "UFRAME_NUM=4"]
    points = [(1, 2, 3, 900, 100, 400, 180, 0, 30)]
    made = converted(tp(*rows, "L P[1] 100mm/sec FINE", positions=points), "tp", "krl").translated
    assert list(
        made.asks[
            "see that these set themselves what holds for them here in the source, and change none of it"
        ]
    ) == ["ELSEWHERE (frame, tool)"]
    assert not [x for x in made.losses if x.part == "scope"]


def test_how_a_program_begins_in_krl_is_nothing_that_others_move_with():
    made = converted(krl("BAS(#INITMOV,0)", "PTP {A1 0,A2 -90,A3 90,A4 0,A5 0,A6 0}"), "krl", "rapid")
    assert not [x for x in made.translated.losses if x.part == "scope"]


@pytest.mark.parametrize(
    ("target", "rows"),
    [
        ("rapid", ["tool_1.tframe:=[[0,0,100],[1,0,0,0]];", "frame_3.uframe:=[[1,2,3],[1,0,0,0]];"]),
        ("tp", ["PR[100,3]=100", "UTOOL[1]=PR[100]", "PR[100,1]=1", "UFRAME[3]=PR[100]"]),
        ("inform", ["SETTOOL TL#(1) P000", "MFRAME UF#(3) P001 P002 P003"]),
        ("urscript", ["tool_1 = p[0.0, 0.0, 0.1,", "frame_3 = p[0.001, 0.002, 0.003,"]),
    ],
)
@pytest.mark.parametrize("moves", [[], ["$TOOL=TOOL_DATA[2]", "LIN {X 900,Y 0,Z 500,A 0,B 0,C 180}"]])
def test_a_tool_or_frame_that_no_move_here_takes_is_set_for_those_that_do(moves, target, rows):
    sets = ["TOOL_DATA[1]={X 0,Y 0,Z 100,A 0,B 0,C 0}", "BASE_DATA[3]={X 1,Y 2,Z 3,A 0,B 0,C 0}"]
    text = translated(krl(*sets, *moves), "krl", target)
    places = [text.find(row) for row in rows]
    assert -1 not in places
    assert places == sorted(places)


@pytest.mark.parametrize(
    ("target", "row"),
    [
        ("krl", "BASE_DATA[1]={X 900,Y 100,Z 400,A 0,B 0,C 0}"),
        ("rapid", "frame_1.uframe:=[[900,100,400],[1,0,0,0]];"),
        ("tp", "UFRAME[1]=PR[100]"),
    ],
)
def test_a_frame_of_three_points_that_no_move_here_takes_is_set_for_those_that_do(target, row):
    points = ["///POSTYPE BASE", "///RECTAN", "///RCONF 1,0,0,0,0,0,0,0"]
    for number, place in enumerate(("900.000,100.000", "1000.000,100.000", "900.000,200.000")):
        points.append(f"C{number:05d}={place},400.000,180.0000,0.0000,30.0000")
    assert row in translated(inform("MFRAME UF#(1) C00000 C00001 C00002", points=points), "inform", target)


def test_what_a_called_routine_leaves_set_at_the_end_is_told():
    """The call is the last of all."""
    rows = [
        "DEF MAINLY ( )",
        "SETS ()",
        "END",
        "DEF SETS ( )",
        "WAIT SEC 0.1",
        "$BASE=BASE_DATA[3]",
        "END",
        "",
    ]
    losses = converted("\r\n".join(rows), "krl", "rapid").translated.losses
    assert [x.line for x in losses if x.part == "scope"] == [6]


@pytest.mark.parametrize("target", ["krl", "rapid"])
def test_a_register_that_a_loop_counts_is_counted_for_routines_of_no_file_too(target):
    """RAPID's FOR counts a variable of its own, KRL's ends one step beyond."""
    made = translated(tp("FOR R[1]=1 TO 3", "CALL PICK", "ENDFOR"), "tp", target)
    assert "FOR" not in made
    assert re.search(r"R1:?=R1 ?\+ ?1", made)
    assert re.search(r"R1:?=R1 ?- ?1", made)


@pytest.mark.parametrize("line", ["JMOVE #a+#b", "POINT #c = #a-#b", "LMOVE p+#b"])
def test_axis_values_are_no_transformation(line):
    """A KRL or RAPID with a product of axis values is refused when it is loaded."""
    tables = ".JOINTS\n#a 10 20 30 40 50 60\n#b 1 2 3 4 5 6\n.END\n.TRANS\np 500 100 400 90 180 0\n.END\n"
    text = f".PROGRAM main()\n{line}\n.END\n{tables}"
    program = read_source(decode(text.encode(), "made.as"))
    assert any("axis values are no transformation" in d.message for d in program.diagnostics)
    made = convert(
        link(program).program, "krl", Context(robot=ROBOT, on_loss="comment"), date="2026/01/01 00:00"
    )
    assert [x.line for x in made.translated.losses if x.leaves_out] == [2]


@pytest.mark.parametrize("before", [[], ["LIN {X 900,Y 0,Z 500,A 0,B 0,C 180}"]])
def test_a_point_of_the_list_that_is_a_frame_too_is_two_data_in_rapid(before, tmp_path):
    lines = ["DEF PART ( )", *before, "$BASE=XP1", "LIN XP1", "END", ""]
    (tmp_path / "PART.src").write_text("\r\n".join(lines))
    data = ["DEFDAT PART", "DECL E6POS XP1={X 500,Y 0,Z 400,A 0,B 90,C 0}", "ENDDAT", ""]
    (tmp_path / "PART.dat").write_text("\r\n".join(data))
    program = link(read_source(load(tmp_path / "PART.src"))).program
    made = convert(program, "rapid", Context(robot=ROBOT, on_loss="error"), date="2026/01/01 00:00")
    text = b"".join(made.files.values()).decode()
    (frame,) = re.findall(r"MoveL XP1,.*WObj:=(\w+)", text)
    assert f'PERS wobjdata {frame}:=[FALSE,TRUE,"",[[500,0,400]' in text
    assert re.search(r"robtarget XP1:=\[\[500,0,400\]", text)


def test_a_routine_whose_triggers_are_spelled_out_is_no_second_one_with_data_of_its_own(tmp_path):
    """The other file makes it a program of several files; COUNTED is one variable and not two."""
    rows = [
        "DEF PART ( )", "SENT ()", "COUNTED=COUNTED+1", "OTHER ()", "END", "", "DEF SENT ( )",
        "TRIGGER WHEN PATH=-35 DELAY=0 DO $OUT[2]=FALSE", "LIN XP1", "COUNTED=COUNTED+1", "LIN XP1",
        "TRIGGER WHEN PATH=-5 DELAY=0 DO DROP() PRIO=84", "LIN_REL {Z -30}", "END", "", "DEF DROP ( )",
        "COUNTED=COUNTED+1", "END", "",
    ]  # fmt: skip
    (tmp_path / "PART.src").write_text("\r\n".join(rows))
    point = "DECL E6POS XP1={X 500,Y 0,Z 400,A 0,B 90,C 0}"
    data = ["DEFDAT PART", "DECL INT COUNTED=0", point, "ENDDAT", ""]
    (tmp_path / "PART.dat").write_text("\r\n".join(data))
    (tmp_path / "OTHER.src").write_text("DEF OTHER ( )\r\n$OUT[1]=TRUE\r\nEND\r\n")
    program = link(read_source(load(tmp_path / "PART.src")), "rapid").program
    assert [r.name for r in program.routines] == ["PART", "SENT", "DROP", "OTHER"]
    assert [d.name for d in program.data] == ["COUNTED", "XP1"]


def test_the_home_position_that_a_controller_watches_is_told():
    text = krl("DECL E6AXIS XH", "XH={A1 0,A2 -90,A3 90,A4 0,A5 40,A6 0}", "$H_POS=XH", "PTP XH")
    remarks = converted(text, "krl", "rapid").translated.remarks
    assert [x.line for x in remarks if "$H_POS" in x.says] == [4]


@pytest.mark.parametrize("target", ["rapid", "urscript", "inform"])
def test_a_share_of_the_speed_at_a_corner_is_no_length_without_a_word(target):
    """How far from its corner CNT begins is the controller's own: a length stands for it in one run alone."""
    places = [
        (1, 0, 1, 900, 0, 400, 180, 0, 0),
        (2, 0, 1, 900, 300, 400, 180, 0, 0),
        (3, 0, 1, 900, 300, 200, 180, 0, 0),
    ]
    rows = (
        "UFRAME_NUM=0",
        "UTOOL_NUM=1",
        "L P[1] 500mm/sec FINE",
        "L P[2] 500mm/sec CNT60",
        "L P[3] 500mm/sec FINE",
    )
    found = [x for x in losses(tp(*rows, positions=places), "tp", target) if x.part == "blend"]
    assert found
    assert all("share of the speed" in x.says for x in found)
    assert {x.line for x in found} == {9}


def test_a_zone_is_no_share_of_the_speed_without_a_word():
    """A radius of 10 mm at 200 mm/s is just what braking for 0.1 s takes, which is assumed."""
    rows = ("MoveJ p1,v200,fine,tool0;", "MoveJ p2,v200,z10,tool0;", "MoveJ p1,v200,fine,tool0;")
    found = [x for x in losses(module(*rows, data=TARGETS), "rapid", "tp") if x.part == "blend"]
    assert len(found) == 1
    assert "share of the speed" in found[0].says


def test_a_frame_that_nothing_tells_is_no_zero_where_its_components_are_set():
    """What is taught would be lost at each start, and the robot would go on from the base."""
    move = "SLIN {X 10,Y 20,Z 30,A 0,B 90,C 0} WITH $TOOL=TOOL_DATA[1], $BASE=BASE_DATA[2]"
    rows = ["DEF MAINLY ( )", "SEG ()", "BASE_DATA[2].z=BASE_DATA[2].z+155", "SEG ()", "END"]
    text = translated("\r\n".join([*rows, "DEF SEG ( )", move, "END", ""]), "krl", "tp")
    (register,) = re.findall(r"PR\[(\d+),3:frame_2_value\]=PR\[\d+,3:frame_2_value\]\+155", text)
    assert f"PR[{register},3]=0" not in text
    assert text.count(f"UFRAME[2]=PR[{register}:frame_2_value]") == 2


@pytest.mark.parametrize(
    ("target", "shown"), [("inform", "tool 1 in frame 2"), ("rapid", "tool_1 in frame_2")]
)
def test_where_a_point_of_no_file_is_to_be_taught_says_with_which_tool_and_in_which_frame(target, shown):
    text = krl("$TOOL=TOOL_DATA[1]", "$BASE=BASE_DATA[2]", "PTP XP1", "LIN XP2")
    asks = converted(text, "krl", target).translated.asks[
        "teach what no file here declares, or copy its values"
    ]
    assert list(asks) == [f"XP1 ({shown})", f"XP2 ({shown})"]


@pytest.mark.parametrize(
    ("text", "vendor", "asks"),
    [
        (tp("L PR[1] 200mm/sec FINE"), "tp", True),
        (tp("UFRAME_NUM=1", "UTOOL_NUM=1", "L PR[1] 200mm/sec FINE"), "tp", False),
        (krl(*HOME[1:], *poses((900, 0, 400))), "krl", True),
        (krl(*HOME, *poses((900, 0, 400))), "krl", False),
        (krl("PTP {A1 0,A2 -90,A3 90,A4 0,A5 40,A6 0}"), "krl", False),
        (script("movel(p[0.4,0.1,0.3,0,3.14,0], a=1, v=1)"), "urscript", False),
        (module("MoveL p1,v100,fine,tool0;", data=TARGETS), "rapid", False),
    ],
)
def test_the_receipt_asks_for_a_frame_that_the_program_leaves_to_its_caller(text, vendor, asks):
    """A listing that is called moves in the frame of its caller, and not in the base."""
    made = converted(text, vendor, "inform" if vendor == "tp" else "tp")
    assert any("which frame was active" in says for says in made.translated.asks) is asks


# --- what the routines of the next reading held -----------------------------------------------------------------

_UR = load_robot("universal-robots/ur5e")


def _made_from_script(*rows, target="rapid"):
    program = link(read_source(decode(script(*rows).encode(), "made.script"))).program
    work = Context(robot=_UR, target_robot=_UR, on_loss="comment")
    return convert(program, target, work, date="2026/01/01 00:00")


def _text_of(made):
    return b"".join(made.files.values()).decode()


@pytest.mark.parametrize(
    ("target", "wanted"),
    [("rapid", "MoveJ goal,"), ("krl", "PTP goal"), ("inform", "MOVJ P0"), ("tp", "J PR[")],
)
def test_a_pose_that_changes_is_the_goal_and_not_the_joints_near_it(target, wanted):
    """`get_inverse_kin(pose, qnear=q)` went to q, or to where the pose was in one round of the loop."""
    rows = (
        "global near=[0.1, -1.5, 1.5, -1.5, -1.5, 0.2]",
        "global goal=p[-0.4, -0.1, 0.4, 0.0, 3.14, 0.0]",
        "i = 0",
        "while i<3:",
        "  goal[2]=goal[2]+0.02",
        "  movej(get_inverse_kin(goal, qnear=near), a=1.4, v=1.05)",
        "  i=i+1",
        "end",
    )
    made = _made_from_script(*rows, target=target)
    assert wanted in _text_of(made)
    found = [x for x in made.translated.losses if x.part == "joints"]
    assert [x.fate for x in found] == [Fate.APPROXIMATED]
    assert "its controller chooses them" in found[0].says


def test_joints_beside_a_pose_that_no_run_reaches_are_told():
    row = "movej(get_inverse_kin(p[-0.4,-0.1,0.3,0,3.14,0], qnear=[0.1,-1.5,1.5,-1.5,-1.5,0.2]))"
    made = _made_from_script("global n=1", "if n>2:", f"  {row}", "end", target="krl")
    assert [x.line for x in made.translated.losses if "nobody checked" in x.says] == [4]


def test_a_function_of_the_joints_of_a_pose_says_that_it_starts_elsewhere():
    rows = (
        "q=[0.1, -1.5, 1.5, -1.5, -1.5, 0.2]",
        "j=get_inverse_kin(p[-0.4,-0.1,0.3,0,3.14,0], q)",
        "movej(j)",
    )
    made = _made_from_script(*rows)
    assert "CalcJointT(" in _text_of(made)
    assert [x.line for x in made.translated.losses if x.part == "joints"] == [3]


_FILLED = {
    "sioGet(sPort, l_nData)": "l_nData",
    'toNum("12,5", l_nData, l_bOk)': "l_nData",
    "toNum(mid(l_sText, 2, 0), l_nData, l_bOk)": "l_bOk",
    "getJointForce(l_nForces)": "l_nForces",
    'toBinary(l_nForces[0], 6, "-4l", l_nData[2])': "l_nData",
}


@pytest.mark.parametrize("line", _FILLED)
def test_what_an_instruction_that_goes_writes_into_its_argument_is_told(line):
    names = {"l_nData": "num", "l_nForces": "num", "l_bOk": "bool", "l_sText": "string"}
    local = "".join(
        f'<Local name="{name}" type="{kind}" xsi:type="array" size="1" />\n' for name, kind in names.items()
    )
    read_name = _FILLED[line]
    use = f"if {read_name}" if read_name == "l_bOk" else f"if {read_name}>3"
    rows = f'begin\n{line}\n{use}\ndelay(1)\nendIf\nif l_sText=="a"\ndelay(1)\nendIf\nend'
    text = (
        '<?xml version="1.0" encoding="utf-8" ?>\n<Programs xmlns="ProgramNameSpace">\n<Program name="start" >\n'
        f"<Locals>\n{local}</Locals>\n<Code><![CDATA[\n{rows}\n]]></Code>\n</Program>\n</Programs>\n"
    )
    program = link(read_source(decode(text.encode(), "made.pgx"))).program
    made = convert(program, "rapid", Context(robot=ROBOT, on_loss="comment"), date="2026/01/01 00:00")
    found = [x for x in made.translated.losses if x.part == "value" and f"it needs {read_name}" in x.says]
    number = 1 + text.splitlines().index(use)
    assert [x.line for x in found] == [number]
    assert "sets in a way that the target cannot" in found[0].says
    assert not any("it needs l_sText" in x.says for x in made.translated.losses)


@pytest.mark.parametrize(("zone", "wanted"), [("12.5", "CR12 "), ("0.3", "CR1 "), ("7", "CR7 ")])
def test_a_corner_of_tp_is_whole_millimetres(zone, wanted):
    row = f"MoveL p1,v100,[FALSE,{zone},{zone},{zone},0,0,0],tool0;"
    text = module("MoveL p2,v100,fine,tool0;", row, "MoveL p2,v100,fine,tool0;", data=TARGETS)
    made = converted(text, "rapid", "tp")
    assert wanted in _text_of(made)
    told = [x.says for x in made.translated.losses if x.part == "blend" and "share" not in x.says]
    assert told == ([] if zone == "7" else ["rounded to 1 mm"])


def test_a_frame_of_the_controller_that_no_point_names_is_not_asked_for():
    """A point of a computed frame has the number -1 in olp."""
    rows = ("N=3", "IF $IN[4] THEN", "N=4", "ENDIF", "$TOOL=TOOL_DATA[N]", "$BASE=BASE_DATA[N]")
    text = krl("DECL INT N", *HOME, *rows, *poses((900, 0, 400), (900, 50, 400)))
    linked = link(read(text, "krl"))
    made = convert(linked.program, "tp", Context(robot=ROBOT, on_loss="comment"), date="2026/01/01 00:00")
    told = before_it_runs(linked, made.translated, "tp", None, True)
    assert any("set tool" in x for x in told)
    assert not any("frame -1" in x for x in told)


def test_a_tool_that_the_program_sets_itself_is_not_asked_for():
    rows = ("PR[6]=LPOS", "UTOOL[2]=PR[6]", "UTOOL_NUM=2", "L P[1] 100mm/sec FINE")
    asks = converted(tp(*rows, positions=((1, 1, 2, 900, 0, 400, 180, 0, 0),)), "tp", "rapid").translated.asks
    assert asks["set these values, which are zeros now"] == ("frame 1",)
    (begins,) = [things for says, things in asks.items() if "before the program sets them" in says]
    assert begins == ("tool 2",)


@pytest.mark.parametrize("calls", [True, False])
def test_registers_are_global_in_krl(calls):
    """All programs of the source's controller set and read them, also those that call this one."""
    rows = ("R[1]=R[1]+1", "PR[5,3]=10", *(("CALL ELSEWHERE",) if calls else ()), "L P[1] 100mm/sec FINE")
    text = _text_of(converted(tp(*rows, positions=(P1,)), "tp", "krl"))
    assert "PUBLIC" in text
    found = {name: word for word, name in re.findall(r"DECL (GLOBAL )?\w+ (\w+)=", text)}
    assert (found["P1"], found["PV5"], found["R1"]) == ("", "GLOBAL ", "GLOBAL ")


@pytest.mark.parametrize(
    ("target", "takes"),
    [("tp", r"R\[\d+:total_share\]=AR\[1\]|=AR\[1\]"), ("inform", r"GETARG R\d+ IARG#\(1\)")],
)
def test_a_function_for_other_programs_takes_its_arguments_and_says_where_its_result_is(target, takes):
    """RAPID's other modules call it; it read registers that nobody sets."""
    rows = [
        "MODULE m",
        "PROC main()",
        "WaitTime 1;",
        "ENDPROC",
        "FUNC num third(num a)",
        "RETURN a*2;",
        "ENDFUNC",
    ]
    made = converted("\n".join([*rows, "ENDMODULE", ""]), "rapid", target)
    assert re.search(takes, _text_of(made))
    told = [x for x in made.translated.losses if "nothing here calls third" in x.says]
    assert [(x.line, x.fate) for x in told] == [(5, Fate.APPROXIMATED)]


def test_a_function_that_the_program_calls_takes_what_it_is_given():
    rows = [
        "MODULE m",
        "PROC main()",
        "WaitTime third(1);",
        "ENDPROC",
        "FUNC num third(num a)",
        "RETURN a*2;",
        "ENDFUNC",
    ]
    made = converted("\n".join([*rows, "ENDMODULE", ""]), "rapid", "tp")
    assert "AR[" not in _text_of(made)
    assert not [x for x in made.translated.losses if x.part == "argument"]


def test_a_cyclic_flag_of_a_computed_number_is_not_set_once():
    """`$CYCFLAG[N]=$IN[600]` follows the input all the time; an output was set to what it was in that moment."""
    text = krl("DECL INT N", "N=22", "$CYCFLAG[N]=$IN[600]", "WAIT FOR $CYCFLAG[N]")
    made = converted(text, "krl", "rapid")
    assert [x.line for x in made.translated.losses if x.leaves_out] == [4]
    assert "! not translated: $CYCFLAG[N]=$IN[600]" in _text_of(made)


@pytest.mark.parametrize("sets", [True, False])
def test_data_that_programs_beside_this_one_set_are_asked_for(sets, tmp_path):
    """VAL3: the tool of a project is chosen by one of its programs, and the one that moves never sets it."""
    rows = [
        "MODULE moves",
        *TARGETS,
        "PERS tooldata tNow:=[TRUE,[[0,0,100],[1,0,0,0]],[1,[0,0,1],[1,0,0,0],0,0,0]];",
    ]
    rows += [
        "VAR num own:=1;",
        "PROC main()",
        "own:=2;",
        "MoveL p1,v100,fine,tNow;",
        "WaitTime x;",
        "ENDPROC",
        "ENDMODULE",
    ]
    (tmp_path / "moves.mod").write_text("\n".join(rows))
    body = ["tNow.tframe.trans.z:=120;", "own:=3;", "p1.trans.x:=0;"] if sets else ["IF x=3 Stop;"]
    other = ["MODULE chooses", "PROC choose()", *body, "ENDPROC", "ENDMODULE"]
    (tmp_path / "chooses.mod").write_text("\n".join(other))
    linked = link(read_source(load(tmp_path / "moves.mod")), "krl")
    made = convert(linked.program, "krl", Context(robot=ROBOT, on_loss="comment"), date="2026/01/01 00:00")
    asked = [x for x in before_it_runs(linked, made.translated, "krl", None, True) if "no part of this" in x]
    assert [x.rpartition(": ")[2] for x in asked] == (["tNow (chooses.mod)"] if sets else [])
    (tmp_path / "logs.mod").write_text(" " * 4_000_001)
    told = [x for x in before_it_runs(linked, made.translated, "krl", None, True) if "too large" in x]
    assert [x.rpartition(": ")[2] for x in told] == ["logs.mod"]


def test_an_argument_that_goes_into_whole_numbers_is_tried_with_whole_numbers():
    """6.5 for `GETARG LB000 IARG#(1)` made each job that takes one differ."""
    text = inform("GETARG LB000 IARG#(1)", "SET B009 LB000", "DOUT OG#(26) B009")
    text = text.replace("NOP\r\n", "///LVARS 1,0,0,0,0,0,0,0\r\nNOP\r\n", 1)
    program = link(read(text, "inform"))
    made = convert(program.program, "rapid", Context(robot=ROBOT, forms=True), date="2026/01/01 00:00")
    runs = runs_of(program.program, made, "rapid", (ROBOT, None))
    receipt = receipt_of(program, made.translated, "rapid", tuple(made.files), runs, (ROBOT, None))
    assert not receipt.verdict.objections


@pytest.mark.parametrize(
    ("rows", "taken"),
    [(["R[1]=AR[1]"], "1.0"), (["R[1]=R[2]+AR[1]"], "1.0"), (["IF R[2]>AR[1],JMP LBL[1]", "LBL[1]"], "1.0")],
)
def test_an_argument_that_is_computed_with_may_be_a_fraction(rows, taken):
    """Where no variable takes it as it is, none of whole numbers does: what is rounded would not be seen."""
    program = read(tp("R[2]=2", *rows), "tp")
    says = "argument 1 of the main routine, which nothing here calls, is taken as "
    assert {a.says.removeprefix(says) for a in run(program).assumptions if says in a.says} == {taken}


def test_a_place_that_an_instruction_which_goes_computes_is_not_to_be_taught():
    """AS: `POINT .f = FRAME(o,x,y,o)` became a comment, and what is computed from `.f` said that nobody declares it."""
    tables = ".TRANS\no 500 100 400 90 180 0\nx 600 100 400 90 180 0\ny 500 200 400 90 180 0\n.END\n"
    rows = ["POINT .f = FRAME(o,x,y,o)", "POINT .p = .f+o", "SPEED 100 MM/S ALWAYS", "LMOVE .p", "LMOVE o"]
    text = "\n".join([".PROGRAM main()", *rows, ".END", tables])
    program = link(read_source(decode(text.encode(), "made.as"))).program
    made = convert(program, "rapid", Context(robot=ROBOT, on_loss="comment"), date="2026/01/01 00:00")
    told = {x.line: x.says for x in made.translated.losses if "it needs" in x.says}
    assert told.keys() == {3, 5}
    assert "FRAME(o,x,y,o)' sets in a way that the target cannot" in told[3]
    assert [x.line for x in made.translated.losses if x.leaves_out] == [2, 5]


@pytest.mark.parametrize(
    ("target", "told"), [("rapid", True), ("krl", True), ("urscript", False), ("tp", False)]
)
def test_elements_that_a_person_copies_have_other_numbers_where_arrays_begin_with_another(target, told):
    """AS: letter[1,0] is letter{2,1} of RAPID."""
    text = "\n".join(
        [".PROGRAM main()", "SPEED 100 MM/S ALWAYS", "LMOVE letter[1,0]", "LMOVE letter[1,2]", ".END", ""]
    )
    program = link(read_source(decode(text.encode(), "made.as"))).program
    made = convert(program, target, Context(robot=ROBOT, on_loss="comment"), date="2026/01/01 00:00")
    asked = [things for says, things in made.translated.asks.items() if "one higher in each index" in says]
    assert asked == ([("letter",)] if told else [])


# --- What other programs see of one -------------------------------------------------------------------------


def test_data_that_last_and_that_other_modules_see_are_global_in_krl():
    data = ("PERS num seen:=3;", "LOCAL PERS num own:=4;", "CONST num two:=2;", "VAR num y;")
    data += (*TARGETS[:1], "PERS tooldata hand:=[TRUE,[[0,0,90],[1,0,0,0]],[1,[0,0,1],[1,0,0,0],0,0,0]];")
    rows = ("y:=seen*own+two;", "seen:=y;", "own:=y;", "MoveL p1,v100,fine,hand;")
    text = translated(module(*rows, data=data), "rapid", "krl")
    found = {name: word for word, name in re.findall(r"DECL (GLOBAL )?\w+ (\w+)=", text)}
    assert (found["seen"], found["own"], found["hand"]) == (
        "GLOBAL ",
        "",
        "",
    )  # programs share tools as they are


def test_a_script_shows_no_other_program_its_registers():
    """A recipe sets registers that others read: "all exact", and nobody could read them."""
    made = converted(tp("R[100]=30", "R[101:speed]=1"), "tp", "urscript")
    (names,) = [names for says, names in made.translated.asks.items() if "sees no variable of it" in says]
    assert names == ("R100", "speed")


@pytest.mark.parametrize("target", ["tp", "inform"])
def test_data_that_last_and_that_a_start_sets_are_named(target):
    """KRL's `gnActSt`, which a program only sets, had its first value again at each start, without a word."""
    text = module(
        "y:=station*2;",
        "station:=2;",
        "done:=1;",
        data=("PERS num station:=20;", "PERS num done:=0;", "VAR num y;"),
    )
    made = converted(text, "rapid", target)
    (names,) = [names for says, names in made.translated.asks.items() if "it sets their first values" in says]
    assert names == ("done",)  # of the other one a loss tells
    assert any("station keeps its last value" in loss.says for loss in made.translated.losses)


def test_a_routine_that_nothing_calls_is_global_in_krl():
    """Event routines of RAPID, which the controller calls: those that neither move nor wait were hidden."""
    more = ("ENDPROC", "PROC reset()", "x:=0;", "ENDPROC", "LOCAL PROC own()", "x:=1;")
    text = translated(module("x:=2;", *more, data=("VAR num x;",)), "rapid", "krl")
    assert "GLOBAL DEF reset" in text
    assert re.search(r"^DEF own", text, re.MULTILINE)


@pytest.mark.parametrize(("more", "does"), [("", "read x as what it returns"), (",y :OUT", "PART_x, PART_y")])
def test_who_calls_a_script_s_function_that_hands_back_is_told_how(more, does):
    rows = ("DECL INT x,y", "x=2", *(("y=3",) if more else ()), "WAIT SEC 1")
    text = "\n".join([f"DEF PART(x :OUT{more})", *rows, "END", ""])
    (told,) = [loss for loss in losses(text, "krl", "urscript") if "nothing here calls PART" in loss.says]
    assert told.fate is Fate.APPROXIMATED
    assert does in told.says
    caller = f"DEF PART()\nDECL INT a,b\nSUB(a{',b' if more else ''})\nEND\n"
    inside = caller + text.replace("DEF PART", "DEF SUB")
    assert not [loss for loss in losses(inside, "krl", "urscript") if "nothing here calls" in loss.says]


def test_a_thread_and_a_variable_have_no_name_in_common():
    text = translated(tp("RUN OTHER", "L P[1] 100mm/sec FINE", positions=(P1,)), "tp", "urscript")
    assert re.search(r"^ +run OTHER\(\)", text, re.MULTILINE)
    assert "OTHER =" not in text


def test_comments_before_the_first_case_and_behind_a_break_of_val3_stay():
    rows = (
        "switch n",
        "// one",
        "case 1",
        "n=2",
        "break // so far",
        "// two",
        "case 2",
        "n=3",
        "break",
        "endSwitch",
    )
    head = '<?xml version="1.0" encoding="utf-8"?>\n<Programs xmlns="http://www.staubli.com/robotics/VAL3/Program/2">'
    local = '<Locals><Local name="n" type="num" xsi:type="array" size="1"/></Locals>'
    code = "\n".join(["begin", *rows, "end"])
    text = f'{head}\n<Program name="part">{local}\n<Code><![CDATA[{code}]]></Code>\n</Program>\n</Programs>\n'
    written = translated(text, "val3", "rapid")
    assert [found for found in ("! one", "! so far", "! two") if found not in written] == []


# --- Values that are taken once -----------------------------------------------------------------------------


@pytest.mark.parametrize("target", ["krl", "tp", "inform"])
def test_a_power_of_what_others_may_change_is_told(target):
    text = module("y:=Pow(2,rings);", data=("PERS num rings:=3;", "VAR num y;"))
    assert [loss.says for loss in losses(text, "rapid", target) if "rings is a variable" in loss.says]


@pytest.mark.parametrize("target", ["tp", "inform"])
def test_what_lasts_and_others_see_is_told_where_its_value_is_written(target):
    text = module("y:=y+seen*own;", data=("PERS num seen:=3;", "LOCAL PERS num own:=3;", "VAR num y;"))
    told = [loss.says for loss in losses(text, "rapid", target) if "its value there is written" in loss.says]
    assert [says.split()[0] for says in told] == ["seen"]


def test_the_robot_s_largest_speed_is_told():
    program = read(module("x:=MaxRobSpeed();", "! MaxRobSpeed", data=("VAR num x;",)), "rapid")
    assert [d.message for d in program.diagnostics if d.code == "P464"] == [
        "MaxRobSpeed() is read as 5000 mm/s: the robot decides"
    ]
    assert not [d for d in read(module("! MaxRobSpeed()"), "rapid").diagnostics if d.code == "P464"]


@pytest.mark.parametrize(
    ("asked", "written"), [("=TRUE", "IF (R[1:x]>=2) THEN"), ("=FALSE", "IF (!(R[1:x]>=2)) THEN")]
)
def test_no_condition_of_tp_is_compared_with_a_state(asked, written):
    text = module(f"IF (x>=2){asked} x:=x+1;", data=("VAR num x:=0;",))
    assert written in translated(text, "rapid", "tp")


@pytest.mark.parametrize("target", ["krl", "inform"])
def test_the_end_of_all_programs_in_one_that_others_may_call_is_told(target):
    """FANUC's ABORT stops whoever called this; RET goes back to it. Nobody calls RAPID's main."""
    says = "where another program calls PART"
    assert [loss.line for loss in losses(tp("ABORT"), "tp", target) if loss.says.startswith(says)] == [6]
    assert not [loss for loss in losses(module("EXIT;"), "rapid", target) if "another program" in loss.says]


def test_a_value_of_the_controller_s_own_list_is_told_where_it_is_written(tmp_path):
    """The number of the pallet: its first value chose the pallet for ever."""
    (tmp_path / "$config.dat").write_text("DEFDAT $CONFIG\nINT PALLET=1\nENDDAT\n")
    rows = ("DEF PART()", "DECL INT N", "N=PALLET*2", "WAIT SEC N", "END", "")
    (tmp_path / "part.src").write_text("\n".join(rows))
    program = link(read_source(load(tmp_path / "part.src"))).program
    made = convert(program, "tp", Context(robot=ROBOT, on_loss="comment"), date="2026/01/01 00:00")
    told = [
        loss.line for loss in made.translated.losses if "PALLET is a variable of another file" in loss.says
    ]
    assert told == [3]


# --- Texts and numbers, copies of frames --------------------------------------------


def as_program(*rows):
    return "\n".join([".PROGRAM part()", *(f"  {row}" for row in rows), ".END", ""])


def val3_program(*rows):
    head = '<?xml version="1.0"?><Programs><Program name="start"><Locals><Local name="n" type="num"/></Locals><Code>'
    return "\n".join([f"{head}<![CDATA[begin", *rows, "end]]></Code></Program></Programs>"])


def test_a_message_that_names_its_values_keeps_its_words():
    text = val3_program('popUpMsg("at "+chr(n))', 'popUpMsg("of "+toString("5.2",n))')
    assert {"MESSAGE[at <n>]", "MESSAGE[of <n>]"} <= {
        row.partition(":")[2].strip(" ;") for row in translated(text, "val3", "tp").splitlines()
    }


@pytest.mark.parametrize("target", ["inform", "tp"])
def test_no_number_goes_into_a_text_and_no_text_into_a_number(target):
    """A CHAR of KRL is both: `SET S000 0` loads nowhere, and `R[1]=SR[1]` reads the text as a number."""
    rows = (
        "DECL CHAR c[3]",
        "DECL INT n",
        "c[1]=0",
        'c[2]="a"',
        "n=c[2]",
        "IF c[2]==97 THEN",
        "HALT",
        "ENDIF",
    )
    said = refused(krl(*rows), "krl", target)
    assert {line: says.partition(": ")[2] for line, says in said.items()} == {
        4: "numbers in a variable of texts: the target has a type for each",
        6: "texts in a variable of numbers: the target has a type for each",
        7: "texts compared with numbers",
    }


@pytest.mark.parametrize("target", ["inform", "tp"])
def test_a_frame_that_becomes_a_copy_of_the_controller_s_is_told(target):
    rows = ("DECL FRAME f", "BASE_DATA[3]={X 100,Y 0,Z 0,A 0,B 0,C 0}", "f=BASE_DATA[3]", "f.X=f.X+1")
    told = [
        x for x in losses(krl(*rows), "krl", target) if "keeps its value: what is set is a copy" in x.says
    ]
    assert [(x.line, x.fate, x.says.partition(" of")[0]) for x in told] == [(3, Fate.APPROXIMATED, "frame 3")]


def test_a_number_as_a_text_of_val3_is_one():
    text = val3_program('popUpMsg("a "+toString("",n))', 'popUpMsg(toString(".3",n)+" mm")')
    assert 'NumToStr(n,3) + " mm"' in translated(text, "val3", "rapid")
    assert 'TPWrite "a "\\Num:=n' in translated(text, "val3", "rapid")


@pytest.mark.parametrize(
    ("text", "vendor"),
    [
        (val3_program('popUpMsg("of "+toString("5.2",n))'), "val3"),
        (as_program('$a="of "+$SPACE(2)'), "as"),
    ],
)
def test_the_text_of_a_function_that_is_called_goes_into_a_text(text, vendor):
    """Its value came back in a number, which CAT$ does not take."""
    text = translated(text, vendor, "inform")
    assert re.search(r'CAT\$ S\d{3} "of " S\d{3}', text)


@pytest.mark.parametrize("target", ["tp", "inform", "krl", "rapid"])
def test_routines_whose_names_differ_in_case_alone_are_two(target):
    """`foo(2)` handed its argument to `Foo`, "all exact"; a folder of jobs holds one of both files on many disks."""
    rows = ("def Foo(q):", "  return q+1", "end", "def foo(q):", "  return q+2", "end", "x=Foo(1)+foo(2)")
    rows += ("if (x == 6):", "  set_standard_digital_out(1, True)", "end")
    plan = run_elsewhere(script(*rows), "urscript", target)
    assert StepKind.SIGNAL in plan.kind
    names = [file.casefold() for file in converted(script(*rows), "urscript", target).files]
    assert len(set(names)) == len(names)


def test_a_clock_is_compared_in_parentheses_in_tp():
    """WAIT and IF without them take registers, signals and parameters (Lincoln's TP manual, figures 119 to 122)."""
    rows = (
        "$TIMER[1]=0",
        "$TIMER_STOP[1]=FALSE",
        "WAIT FOR $TIMER[1]>500",
        "WHILE $TIMER[1]<1000",
        "WAIT SEC 0.1",
    )
    text = translated(krl(*rows, "ENDWHILE"), "krl", "tp")
    assert {"WAIT (TIMER[1]>0.5)", "IF (TIMER[1]>=1),JMP LBL[2]"} <= {
        row.partition(":")[2].strip(" ;") for row in text.splitlines()
    }


@pytest.mark.parametrize("name", ["Foo", "foo"])
def test_a_run_tells_routines_apart_whose_names_differ_in_case_alone(name):
    rows = ("def Foo():", "  sleep(1.0)", "end", "def foo():", "  sleep(2.0)", "end", f"{name}()")
    source = decode(
        script(*rows).encode(), "part.script"
    )  # as it is timed, not as `read` links it for a translation
    plan = run(read_source(source, vendor="urscript"), ROBOT)
    assert plan.durations.tolist() == [{"Foo": 1.0, "foo": 2.0}[name]]


def test_the_routine_that_is_asked_for_is_the_one_that_is_spelled_so():
    rows = ("def Foo():", "  sleep(1.0)", "end", "def foo():", "  sleep(2.0)", "end")
    program = read_source(decode("\n".join(rows).encode(), "part.script"), vendor="urscript")
    for name, seconds in (("Foo", 1.0), ("foo", 2.0)):
        assert run(begun_at(program, name), ROBOT).durations.tolist() == [seconds]


@pytest.mark.parametrize("started", [False, True])
def test_a_clock_that_is_set_to_0_and_started_by_nothing_here_is_told(started):
    """On the source's controller it may run since another program started it; the new program's clock stands."""
    rows = ["$TIMER[3]=0", *["$TIMER_STOP[3]=FALSE"] * started, "WAIT SEC 1", "IF $TIMER[3]>500 THEN", "HALT"]
    told = [x for x in losses(krl(*rows, "ENDIF"), "krl", "tp") if "no statement here starts" in x.says]
    assert len(told) == (not started)


def test_a_signal_is_compared_with_its_other_state_in_inform():
    """No job seen waits for what a signal is not."""
    text = translated(krl("WAIT FOR $IN[5]<>FALSE", "WAIT FOR $IN[6]<>TRUE"), "krl", "inform")
    assert {"WAIT IN#(5)=ON", "WAIT IN#(6)=OFF"} <= set(text.splitlines())


@pytest.mark.parametrize("target", ["tp", "inform", "krl", "rapid"])
@pytest.mark.parametrize("first", ["False", "0"])
def test_a_function_that_returns_numbers_beside_something_narrower_is_one_of_numbers(first, target):
    """The first value's type was taken: 250.4 became TRUE beside False and 250 beside 0, "all exact"."""
    rows = ("def size(q):", "  if (q == 1):", f"    return {first}", "  end", "  return 250.4", "end")
    rows += ("if (size(2) > 250.2):", "  set_standard_digital_out(1, True)", "end")
    rows += ("if (size(1) == False):", "  set_standard_digital_out(2, True)", "end")
    plan = run_elsewhere(script(*rows), "urscript", target)
    assert list(plan.kind).count(StepKind.SIGNAL) == 2
