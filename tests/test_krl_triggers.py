"""What a TRIGGER of KUKA does, told by its manual: at the start or the end of the next move, before or behind it."""

from __future__ import annotations

import re

import pytest
from translated_texts import ROBOT, converted, krl, read, run_elsewhere, translated

from olp.core.source import decode
from olp.fluent import read_source
from olp.runtime.interpreter import run
from olp.transpile import Context
from olp.transpile.compare import compare_plans
from olp.transpile.convert import convert
from olp.transpile.link import link
from olp.transpile.receipt import counts_of

START = "PTP {A1 0,A2 -10,A3 20,A4 0,A5 10,A6 0}"
FIRST = "LIN {X 800,Y 0,Z 400,A 0,B 90,C 0}"
SECOND = "LIN {X 900,Y 0,Z 400,A 0,B 90,C 0}"
WORDS = {
    "rapid": (
        r"(?:Move\w+|SetDO|PulseDO|DEED|FLAG:=)[^;]*;",
        "SetDO do3,1;",
        "PulseDO \\High\\PLength:=0.5,do3;",
    ),
    "tp": (
        r"(?:[JL] P\[\d+\]|DO\[\d+\]=[^;]*|CALL DEED|R\[\d+:FLAG\]=\d)",
        "DO[3]=ON ",
        "DO[3]=PULSE,0.5sec ",
    ),
}


def order(text, target):
    """What the translation does, in its order: "move", or the text of anything else."""
    found = re.findall(WORDS[target][0], translated(text, "krl", target))
    return ["move" if re.match(r"Move|[JL] P", one) else one for one in found]


def fates(text, target):
    return {
        (loss.line, str(loss.fate))
        for loss in converted(text, "krl", target).translated.losses
        if loss.part == "order" or loss.leaves_out
    }


@pytest.mark.parametrize("target", WORDS)
@pytest.mark.parametrize(("at", "place"), [(0, 1), (1, 2)])
def test_an_output_switches_at_the_start_or_the_end_of_the_next_move(target, at, place):
    text = krl(START, f"TRIGGER WHEN DISTANCE={at} DELAY=0 DO $OUT[3]=TRUE", FIRST, SECOND)
    assert order(text, target).index(WORDS[target][1]) == place
    assert fates(text, target) == set()  # the arm stands there: nothing is only nearly the same
    here, there = run(read(text, "krl"), robot=ROBOT), run_elsewhere(text, "krl", target)
    assert here.kind.tolist() == there.kind.tolist()


@pytest.mark.parametrize("target", WORDS)
def test_a_pulse_is_one_of_the_same_time(target):
    text = krl(START, "TRIGGER WHEN DISTANCE=1 DELAY=0 DO PULSE($OUT[3],TRUE,0.5)", FIRST)
    assert order(text, target)[-1] == WORDS[target][2]


def test_several_triggers_of_a_move_keep_their_order():
    rows = (
        f"TRIGGER WHEN DISTANCE={at} DELAY=0 DO $OUT[{n}]=TRUE" for at, n in ((1, 1), (0, 2), (1, 3), (0, 4))
    )
    done = order(krl(START, *rows, FIRST), "rapid")
    assert done == ["move", "SetDO do2,1;", "SetDO do4,1;", "move", "SetDO do1,1;", "SetDO do3,1;"]


@pytest.mark.parametrize(("at", "blends"), [(0, (" C_DIS", "")), (1, ("", " C_DIS"))])
def test_at_a_corner_it_is_told_that_the_program_decides(at, blends):
    text = krl(
        START,
        FIRST + blends[0],
        f"TRIGGER WHEN DISTANCE={at} DELAY=0 DO $OUT[3]=TRUE",
        SECOND + blends[1],
        FIRST,
    )
    assert fates(text, "tp") == {(4, "approximated")}
    assert "CR3" in translated(text, "krl", "tp")  # the corner stays
    if at:
        assert re.search(r"MoveLDO [^;]*,z3,tool0,do3,1;", translated(text, "krl", "rapid"))


@pytest.mark.parametrize("target", WORDS)
def test_a_routine_that_takes_no_time_is_called_there(target):
    text = krl("DECL INT FLAG", START, "TRIGGER WHEN DISTANCE=1 DELAY=0 DO DEED() PRIO=-1", FIRST)
    text += "DEF DEED()\r\nDECL INT N\r\nN=4\r\nEND\r\n"
    done = order(text, target)
    assert "DEED" in done[2]
    assert fates(text, target) == {(4, "approximated")}


ON_THE_WAY = (
    # trigger, target, how the target says it
    (
        "DISTANCE=1 DELAY=-50",
        "rapid",
        r"TriggIO (\w+),0\.05\\Time\\DOp:=do3,1;\s+TriggL .*,v250,\1,fine,tool0;",
    ),
    ("PATH=-20.5 DELAY=0", "rapid", r"TriggIO (\w+),20\.5\\DOp:=do3,1;\s+TriggL .*,\1,fine,tool0;"),
    ("PATH=20 ONSTART DELAY=-5", "rapid", r"TriggEquip (\w+),20\\Start,0\.005\\DOp:=do3,1;\s+TriggL .*,\1,"),
    ("DISTANCE=1 DELAY=-50", "tp", r"L P\[2\] 250mm/sec FINE TB \.05sec,DO\[3\]=ON "),
    ("PATH=-20.5 DELAY=0", "tp", r"L P\[2\] 250mm/sec FINE DB 20\.5mm,DO\[3\]=ON "),
    ("PATH=20 ONSTART DELAY=-5", "krl", r"TRIGGER WHEN PATH=20 ONSTART DELAY=-5 DO \$OUT\[3\]=TRUE"),
)


@pytest.mark.parametrize(("when", "target", "says"), ON_THE_WAY)
def test_one_that_acts_on_the_way_does_so_where_the_target_can_say_it(when, target, says):
    text = krl(START, f"TRIGGER WHEN {when} DO $OUT[3]=TRUE", FIRST, SECOND)
    assert re.search(says, translated(text, "krl", target))
    assert not [loss for loss in converted(text, "krl", target).translated.losses if loss.line == 3]
    here, there = run(read(text, "krl"), robot=ROBOT), run_elsewhere(text, "krl", target)
    found = compare_plans(here, there, speeds=False)
    assert found.differences == []
    assert found.steps == 4


SHIFTED = (
    # trigger, target, whether it stands behind the move, what is told
    ("DISTANCE=0 DELAY=20", "rapid", False, "at the start of the move, not 20 ms behind it"),
    ("DISTANCE=0 DELAY=20", "tp", False, "at the start of the move, not 20 ms behind it"),
    (
        "PATH=20 ONSTART DELAY=-5",
        "tp",
        False,
        "at the start of the move, not 20 mm behind and 5 ms before it",
    ),
    ("PATH=-20 DELAY=-5", "tp", True, "at the end of the move, not 20 mm before and 5 ms before it"),
)


@pytest.mark.parametrize(("when", "target", "behind", "says"), SHIFTED)
def test_any_other_one_acts_at_the_nearer_end_which_is_told(when, target, behind, says):
    text = krl(START, f"TRIGGER WHEN {when} DO $OUT[3]=TRUE", FIRST, SECOND)
    assert order(text, target).index(WORDS[target][1]) == (2 if behind else 1)
    losses = converted(text, "krl", target).translated.losses
    assert [(x.line, str(x.fate)) for x in losses if says in x.says] == [(3, "approximated")]


def test_the_proof_sees_an_output_that_switches_elsewhere():
    one, other = (
        run(
            read(krl(START, f"TRIGGER WHEN DISTANCE=1 DELAY={ms} DO $OUT[3]=TRUE", FIRST), "krl"), robot=ROBOT
        )
        for ms in (-50, -60)
    )
    assert [found.part for found in compare_plans(one, other).found] == ["order"]
    assert compare_plans(one, one).found == []


@pytest.mark.parametrize(
    ("when", "fates"), [("DISTANCE=1 DELAY=-50", {}), ("DISTANCE=0 DELAY=20", {"approximated": 1})]
)
def test_the_receipt_counts_an_output_that_switches_elsewhere_as_approximated(when, fates):
    made = converted(krl(START, f"TRIGGER WHEN {when} DO $OUT[3]=TRUE", FIRST), "krl", "rapid")
    program, losses = (
        read(krl(START, f"TRIGGER WHEN {when} DO $OUT[3]=TRUE", FIRST), "krl"),
        made.translated.losses,
    )
    assert counts_of(program, losses).get("SetOutput", {}) == fates


def test_at_a_corner_each_controller_counts_from_its_own_end():
    text = krl(START, "TRIGGER WHEN DISTANCE=1 DELAY=-50 DO $OUT[3]=TRUE", FIRST + " C_DIS", SECOND)
    assert "TriggL" in translated(text, "krl", "rapid")
    assert fates(text, "rapid") == {(3, "approximated")}


@pytest.mark.parametrize(("corner", "fate"), [("", "approximated"), (" C_DIS", "commented")])
def test_a_routine_that_sets_outputs_is_called_where_the_arm_stands(corner, fate):
    text = krl(START, "TRIGGER WHEN DISTANCE=1 DELAY=0 DO DEED() PRIO=-1", FIRST + corner, SECOND)
    text += "DEF DEED()\r\n$OUT[3]=TRUE\r\nEND\r\n"
    assert (3, fate) in fates(text, "rapid")


KEPT = (
    "TRIGGER WHEN DISTANCE=1 DELAY=0 DO WAITS() PRIO=-1",  # the arm goes on meanwhile
    "TRIGGER WHEN DISTANCE=N DELAY=0 DO $OUT[3]=TRUE",
)


@pytest.mark.parametrize("trigger", KEPT)
def test_one_that_would_do_something_else_is_left_out_and_told(trigger):
    text = krl(START, trigger, FIRST) + "DEF WAITS()\r\nWAIT SEC 1\r\nEND\r\n"
    assert (3, "commented") in fates(text, "rapid")
    assert f"! not translated: {trigger}" in translated(text, "krl", "rapid")


def test_a_trigger_without_a_move_behind_it_in_the_same_branch_acts_in_its_order():
    text = krl(START, "TRIGGER WHEN DISTANCE=0 DELAY=0 DO $OUT[3]=TRUE", "IF $IN[1] THEN", FIRST, "ENDIF")
    assert (3, "approximated") in fates(text, "rapid")
    assert order(text, "rapid").index("SetDO do3,1;") == 1


def test_a_trigger_at_the_end_of_no_known_move_is_left_out():
    text = krl(START, "TRIGGER WHEN DISTANCE=1 DELAY=0 DO $OUT[3]=TRUE", "IF $IN[1] THEN", FIRST, "ENDIF")
    assert (3, "commented") in fates(text, "rapid")


@pytest.mark.parametrize(
    "shift", ["DISTANCE=1 DELAY=0", "PATH=ARCPATH(2) DELAY=ARCTIME(#GAS)", "PATH=N DELAY=N"]
)
def test_a_routine_that_no_file_has_is_called_at_the_nearer_end(shift):
    text = krl(START, f"TRIGGER WHEN {shift} DO NOWHERE(#ON) PRIO=-1", FIRST)
    assert (3, "approximated") in fates(text, "rapid")
    written = translated(text, "krl", "rapid")
    assert written.index("MoveL") < written.index('NOWHERE "#ON";')


def test_in_its_own_language_it_stays_what_it_is():
    trigger = "TRIGGER WHEN DISTANCE=1 DELAY=0 DO $OUT[3]=TRUE"
    rows = (START, 'MsgQuit("x","Cell")', trigger, FIRST)
    program = read_source(decode(krl(*rows).encode(), "part.src"), vendor="krl")
    made = convert(link(program, "krl").program, "krl", Context(robot=ROBOT), date="2026/01/01 00:00")
    written = b"".join(made.files.values()).decode()
    assert trigger in written
    assert 'MsgQuit ("x","Cell")' in written
