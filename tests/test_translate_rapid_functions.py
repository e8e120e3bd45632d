"""RAPID's functions and instructions that other languages have otherwise, or not at all: the oracle is ABB's manual."""

import numpy as np
import pytest
from translated_texts import converted, module, read, run_elsewhere

from olp.runtime.plan import StepKind
from olp.transpile.context import Fate

TARGETS = ["krl", "tp", "inform", "urscript"]
DATA = (
    "VAR num n:=3;",
    "VAR num m;",
    "VAR byte b:=6;",
    "VAR pos place:=[10,20,-20];",
    "VAR robtarget p:=[[900,0,500],[0,1,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];",
)


def waits(plan):
    return [round(float(plan.durations[row]), 6) for row in plan.row[plan.kind == StepKind.WAIT]]


NUMBERS = [
    ("m:=Pow(2,n)-1; Incr n; WaitTime m;", [7]),
    ("Incr n; m:=Pow(2,n); WaitTime m; WaitTime Pow(0.5,n-3);", [16, 0.5]),
    ("Incr n; WaitTime Max(n,2)+Min(n,1.5);", [5.5]),
    ("WaitTime BitAnd(b,12); WaitTime BitOr(b,1); WaitTime BitXOr(b,255)/100;", [4, 7, 2.49]),
    ("BitSet b,1; WaitTime b; BitSet b,1; BitClear b,3; WaitTime b; BitClear b,3; WaitTime b;", [7, 3, 3]),
    ("IF BitCheck(b,2) AND NOT BitCheck(b,1) THEN WaitTime 5; ENDIF Incr b;", [5]),
    ("WaitTime BitLSh(b,2); WaitTime BitRSh(b,1); WaitTime BitNeg(b)/100;", [24, 3, 2.49]),
    ("WaitTime VectMagn(place); place:=place+[0,0,20]; WaitTime VectMagn(place*2-[20,20,0]);", [30, 20]),
    ("WaitTime DotProd(place,place)/100; m:=DnumToNum(NumToDnum(n)); Incr m; WaitTime m;", [9, 4]),
    ("p.trans:=p.trans+place; p.trans.x:=p.trans.x+0; WaitTime Distance(p.trans,[900,0,500]);", [30]),
]  # fmt: skip


@pytest.mark.parametrize("target", TARGETS)
@pytest.mark.parametrize(("body", "seconds"), NUMBERS)
def test_functions_of_numbers_and_places_have_their_value_elsewhere(body, seconds, target):
    text = module(*(f"{row.strip()}" for row in [body]), data=DATA)
    assert waits(read(text, "rapid").plan()) == pytest.approx(seconds, abs=1e-6)
    losses = converted(text, "rapid", target).translated.losses
    if target == "inform" and ".trans" in body:
        return  # positions are set element by element there, and not all are
    assert not [loss for loss in losses if loss.leaves_out]
    assert waits(run_elsewhere(text, "rapid", target)) == pytest.approx(seconds, abs=0.01)


@pytest.mark.parametrize("target", ["krl", "tp", "inform"])
def test_a_computed_power_is_told(target):
    losses = converted(module("Incr n;", "m:=Pow(2,n);", data=DATA), "rapid", target).translated.losses
    assert [loss.line for loss in losses if "whole exponents" in loss.says]


def test_groups_of_signals_are_declared_in_krl_with_free_signals():
    rows = ("SetGO goCode,5;", "m:=GInput(giPart);", "WaitGI giPart,0;", "SetGO goOther,m;", "SetDO do1,1;")
    made = converted(module(*rows, data=DATA), "rapid", "krl")
    text = b"".join(made.files.values()).decode()
    for row in (
        "goCode $OUT[1041] TO $OUT[1056]",
        "goOther $OUT[1057] TO $OUT[1072]",
        "giPart $IN[1041] TO $IN[1056]",
    ):
        assert f"SIGNAL {row}" in text
    assert "goCode=5" in text
    assert not [loss for loss in made.translated.losses if loss.leaves_out]
    assert any("out-group goCode from 1041 on" in things for things in made.translated.asks.values())


@pytest.mark.parametrize(
    ("target", "word"), [("tp", "ABORT"), ("urscript", "halt"), ("krl", "HALT"), ("inform", "PAUSE")]
)
def test_a_cycle_that_ends_within_a_routine_ends_the_program(target, word):
    text = module("Leave;", "WaitTime 3;").replace(
        "ENDMODULE", "PROC Leave()\r\nExitCycle;\r\nENDPROC\r\nENDMODULE"
    )
    losses = converted(text, "rapid", target).translated.losses
    assert {loss.fate for loss in losses if loss.line == 7} == {Fate.APPROXIMATED}
    made = converted(text, "rapid", target)
    assert word in b"".join(made.files.values()).decode()
    assert not waits(read(text, "rapid").plan())


def test_a_cycle_that_ends_in_main_is_a_return():
    losses = converted(module("ExitCycle;"), "rapid", "krl").translated.losses
    assert not [loss for loss in losses if loss.fate is not Fate.EXACT]


@pytest.mark.parametrize("target", TARGETS)
def test_what_holds_axes_beside_the_arm_is_left_out_where_none_moves(target):
    data = (*DATA, "VAR extjoint axes:=[9E9,9E9,9E9,9E9,9E9,9E9];")
    rows = ("axes:=p.extax;", "p:=[[900,n,500],[0,1,0,0],[0,0,0,0],axes];", "MoveL p,v100,fine,tool0;")
    losses = converted(module(*rows, data=data), "rapid", target).translated.losses
    assert not [loss for loss in losses if loss.fate is Fate.COMMENTED and "computed" not in loss.says]
    rows = ("axes.eax_a:=n;", *rows[1:])
    losses = converted(module(*rows, data=data), "rapid", target).translated.losses
    assert [loss for loss in losses if loss.fate is Fate.COMMENTED]


def test_a_delayed_output_switches_at_once_and_is_told():
    text = module("SetDO\\SDelay:=0.2,do1,1;", "WaitTime 1;")
    losses = converted(text, "rapid", "krl").translated.losses
    assert [loss.fate for loss in losses if "delay of the output" in loss.says] == [Fate.APPROXIMATED]
    assert len(read(text, "rapid").plan().events) == 1


def test_functions_return_computed_positions_in_krl():
    text = module("MoveL above(p,20),v100,fine,tool0;", data=DATA).replace(
        "ENDMODULE",
        "FUNC robtarget above(robtarget q,num h)\r\nRETURN Offs(q,0,0,h);\r\nENDFUNC\r\nENDMODULE",
    )
    there, here = run_elsewhere(text, "rapid", "krl"), read(text, "rapid").plan()
    ends = [plan.positions.position[-1] for plan in (there, here)]
    assert not [loss for loss in converted(text, "rapid", "krl").translated.losses if loss.leaves_out]
    assert np.allclose(*ends, atol=1e-6)


@pytest.mark.parametrize("target", TARGETS)
def test_components_that_change_places_keep_their_values(target):
    """TP and INFORM set a position component by component: the first ones were asked for after they had changed."""
    rows = ("p.trans:=[p.trans.y,p.trans.x,p.trans.z];", "WaitTime p.trans.y/100;", "place:=place+place;")
    text = module(*rows, "WaitTime place.x;", data=DATA)
    assert waits(read(text, "rapid").plan()) == [9, 20]
    if target != "inform":
        assert waits(run_elsewhere(text, "rapid", target)) == [9, 20]
