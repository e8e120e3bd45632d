"""What stands beside the statement that a program is read as, and what only compilers and operators notice."""

from __future__ import annotations

import pytest
from translated_texts import ROBOT, converted, krl, module, read, run_elsewhere, translated

from olp.transpile.context import Fate


def fates(text, vendor, target):
    """Line -> fates of what is said of it."""
    found: dict[int, set[Fate]] = {}
    for loss in converted(text, vendor, target).translated.losses:
        found.setdefault(loss.line, set()).add(loss.fate)
    return found


@pytest.mark.parametrize("target", ["inform", "krl", "tp", "urscript"])
def test_what_accset_says_besides_is_told(target):
    losses = converted(module("AccSet 40,60;", "AccSet 40,100;"), "rapid", target).translated.losses
    assert {loss.line for loss in losses if loss.says.startswith("left out: ")} == {3}


_POINTS = tuple(
    f"CONST robtarget p{n}:=[[900,{y},400],[0,1,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];"
    for n, y in ((1, 0), (2, 200))
)
_BOUNDED = (
    # what is said before the moves of 1000 and 300 mm/s, and how fast both are then
    (("VelSet 50,200;",), (200.0, 150.0)),
    (("VelSet 100,250;",), (250.0, 250.0)),
    (("VelSet 50,200;", "VelSet 80,5000;"), (800.0, 240.0)),
    (("VelSet 80,600;", "IF di1=1 THEN", "WaitTime 1;", "ENDIF"), (600.0, 240.0)),
)


@pytest.mark.parametrize("target", ["rapid", "inform", "krl", "tp", "urscript"])
@pytest.mark.parametrize(("rows", "speeds"), _BOUNDED)
def test_the_largest_speed_that_velset_says_holds_behind_its_override(rows, speeds, target):
    moves = ("MoveJ p1,v100,fine,tool0;", *rows, "MoveL p2,v1000,fine,tool0;", "MoveL p1,v300,fine,tool0;")
    text = module(*moves, r"MoveL p2,v1000\T:=4,fine,tool0;", data=_POINTS)
    here = read(text, "rapid").plan(robot=ROBOT)
    there = run_elsewhere(text, "rapid", target)
    for plan in (here, there):
        assert plan.moves.travel[1:3] * 1000.0 == pytest.approx(speeds, rel=1e-6)
    assert not [
        x for x in converted(text, "rapid", target).translated.losses if x.part == "speed" and x.line > 6
    ]


def test_a_largest_speed_that_depends_on_the_way_is_told():
    rows = ("IF di1=1 THEN", "VelSet 50,200;", "ENDIF", "MoveL p2,v1000,fine,tool0;")
    losses = converted(module(*rows, data=_POINTS), "rapid", "krl").translated.losses
    assert [loss.line for loss in losses if "a largest speed is left out" in loss.says] == [8]


@pytest.mark.parametrize("target", ["krl", "tp", "urscript"])
def test_rapids_own_variables_are_none_of_the_program(target):
    found = fates(module("IF ERRNO=ERR_OK THEN", "WaitTime 1;", "ENDIF", "WaitTime 2;"), "rapid", target)
    assert {Fate.COMMENTED} == found[3] == found[4] == found[5]
    assert 6 not in found


def test_entries_of_the_log_are_messages():
    text = module('ErrWrite \\W,"head","why"\\RL2:="more";', "TPErase;")
    assert fates(text, "rapid", "urscript")[3] == {Fate.APPROXIMATED}
    written = translated(text, "rapid", "urscript")
    assert 'textmsg("head: why: more")' in written


@pytest.mark.parametrize("target", ["krl", "tp", "urscript"])
def test_how_a_controller_passes_singularities_is_its_own_and_proven_beside(target):
    text = module("SingArea \\Wrist;", "WaitTime 1;", "SingArea \\Off;")
    assert fates(text, "rapid", target) == {3: {Fate.APPROXIMATED}, 5: {Fate.APPROXIMATED}}
    assert "SingArea \\Wrist" in translated(text, "rapid", target)


def test_an_output_that_is_waited_for_switches_and_is_waited_for():
    """SetDO \\Sync was kept as text, and switched nothing."""
    written = translated(module("SetDO \\Sync,do1,1;"), "rapid", "krl")
    assert [row for row in written.splitlines() if "$OUT[" in row] == [
        "$OUT[1]=TRUE",
        "WAIT FOR $OUT[1]==TRUE",
    ]


def test_krl_chooses_by_integers_alone():
    """SWITCH takes INT, CHAR and enumerations."""
    rows = ("TEST {0}", "CASE 1:", "WaitTime 1;", "ENDTEST", "{0}:={1};")
    data = ("VAR num n:=1;",)
    whole = translated(module(*(row.format("n", "n+1") for row in rows), data=data), "rapid", "krl")
    assert "DECL INT n" in whole
    assert "SWITCH n\r\n" in whole
    text = module(*(row.format("n", "n/2") for row in rows), data=data)
    assert "whole_index=n\r\nSWITCH whole_index\r\n" in translated(text, "rapid", "krl")
    (loss,) = [one for one in converted(text, "rapid", "krl").translated.losses if "chooses" in one.says]
    assert loss.fate is Fate.APPROXIMATED


def test_what_a_routine_no_longer_returns_is_told_where_it_is_used():
    text = module("WaitTime value();", "ENDPROC", "FUNC num value()", "RETURN ReadMotor(1);", "ENDFUNC",
                  "PROC other()")  # fmt: skip
    losses = converted(text, "rapid", "krl").translated.losses
    assert any(loss.line == 3 and "what value returns" in loss.says for loss in losses)


def test_a_function_of_texts_returns_an_array_in_krl():
    text = module("s:=word();", "ENDPROC", "FUNC string word()", 'RETURN "a";', "ENDFUNC", "PROC other()",
                  data=("VAR string s;",))  # fmt: skip
    assert "DEFFCT CHAR[80] word" in translated(text, "rapid", "krl")
    own = krl("END", "DEFFCT CHAR[20] word(a:IN)", "INT a", 'RETURN ("a")', "ENDFCT", "DEF other()")
    assert "DEFFCT CHAR[20] word" in translated(own, "krl", "krl")
    assert read(own, "krl").routines[1].returns == "string"


def test_arguments_that_krl_leaves_out_are_given():
    """RAPID's and URScript's calls have one for each parameter."""
    text = krl("DECL INT i", "f(1)", "f(1,,i)", "i=g()", "END", "DEF f(a:IN,b:IN,c:OUT)", "INT a,b,c", "c=a+b",
               "END", "DEFFCT INT g(x:IN)", "REAL x", "RETURN (4)", "ENDFCT", "DEF other()")  # fmt: skip
    losses = converted(text, "krl", "rapid").translated.losses
    assert {loss.line for loss in losses if loss.part == "argument"} == {3, 4, 5}
    written = translated(text, "krl", "rapid")
    assert [row for row in ("f 1,0,left_out;", "f 1,0,i;", "i:=g(0.0);") if row not in written] == []
    assert "f(1, 0, " in translated(text, "krl", "urscript")


def test_what_a_controller_is_told_of_its_manner_is_named_as_not_modelled():
    plan = read(module("WorldAccLim\\On:=1;", "WaitTime 1;"), "rapid").plan()
    assert [one.says for one in plan.assumptions] == [
        "WorldAccLim, how fast the tool may accelerate, is not modelled"
    ]
