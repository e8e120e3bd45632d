"""What a translation once changed without a word: a program for each cause, and what has to be said of it."""

from __future__ import annotations

import math

import pytest
from translated_texts import converted, inform, krl, module, read, run_elsewhere, script, tp, translated

from olp.core.diagnostic import OlpError
from olp.robots.robot import load_robot
from olp.runtime.plan import BlendCode, StepKind
from olp.transpile.compare import compare_plans
from olp.transpile.context import Fate

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
    asked = {thing for says, things in made.translated.asks.items() if "zeros" in says for thing in things}
    assert {"R4", "PV5", "R6"} <= asked
    assert "R3" not in asked
    lines = {loss.line for loss in made.translated.losses if "begins with zero" in loss.says}
    assert lines >= {7, 10}


# --- 2: options of moves ------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    "option", ["Skip,LBL[2]", "TB .50sec,DO[4]=ON", "TA .20sec,CALL OPEN", "DB 10mm,DO[1]=ON"]
)
@pytest.mark.parametrize("target", ["rapid", "krl", "inform", "urscript"])
def test_what_happens_on_the_way_of_a_move_is_refused_with_it(option, target):
    rows = ("J P[1] 100% FINE", f"L P[2] 100mm/sec FINE {option}", "LBL[2]")
    assert option.split()[0].split(",")[0] in refused(tp(*rows, positions=(P1, P2)), "tp", target)[7]


def test_an_option_that_moves_the_wrist_otherwise_is_told():
    rows = ("J P[1] 100% FINE", "L P[2] 100mm/sec FINE Wjnt")
    found = losses(tp(*rows, positions=(P1, P2)), "tp", "rapid")
    assert [(loss.line, loss.fate) for loss in found if loss.part == "option"] == [(7, Fate.APPROXIMATED)]


# --- 3: handlers --------------------------------------------------------------------------------------------


@pytest.mark.parametrize("target", ["krl", "tp", "inform", "urscript"])
def test_a_handler_is_refused_and_never_an_exact_comment(target):
    rows = (
        "MoveL p2,v100,fine,tool0;",
        "x:=1/x;",
        "ERROR",
        "SetDO do1,1;",
        "MoveL p1,v100,fine,tool0;",
        "TRYNEXT;",
    )
    text = module(*rows, data=TARGETS)
    assert "handler" in refused(text, "rapid", target)[8]
    made = [loss for loss in losses(text, "rapid", target) if "handler" in loss.says]
    assert [(loss.line, loss.fate) for loss in made] == [(n, Fate.COMMENTED) for n in (8, 9, 10, 11)]


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
    assert 9 in refused(text, "rapid", "krl")
    assert "$TIMER" not in "".join(code(translated(text, "rapid", "krl"), ";"))
    text = krl("DECL REAL X", "$TIMER[1]=0", "X=$TIMER[1]/1000")
    for target in ("rapid", "tp"):
        assert set(refused(text, "krl", target)) >= {3, 4}


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
