"""What no file tells has made-up values in further runs: programs that agree only because it is zero are told apart."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from cpu_time import cpu_time_below
from translated_texts import (
    assert_proven,
    converted,
    inform,
    krl,
    module,
    read,
    run_elsewhere,
    tp,
    translated,
)

from olp.ir.expressions import Store
from olp.robots.robot import load_robot
from olp.runtime.interpreter import run
from olp.runtime.made_up import MadeUp, UnknownThing
from olp.runtime.plan import BlendCode
from olp.runtime.poses import FRACTION, TRAVEL, UNTOLD_SPEED
from olp.transpile.compare import steps_of
from olp.transpile.context import Fate
from olp.transpile.convert import runs_of
from olp.transpile.link import link
from olp.transpile.receipt import receipt_of
from olp.transpile.receipt_text import as_text

ROBOT = load_robot("yaskawa/gp25")
TARGETS = ("krl", "rapid", "inform", "urscript")
ROWS = [
    "UFRAME_NUM=2",  # line 6
    "UTOOL_NUM=3",
    "J P[1] 50% FINE",
    "L PR[5] 200mm/sec FINE",
    "R[1]=R[2]*3",
    "IF DI[3]=ON AND R[4]>2,JMP LBL[2]",
    "L P[2] R[6]mm/sec FINE Offset,PR[7]",
    "LBL[2]",
    "WAIT DI[5]=ON TIMEOUT,LBL[3]",
    "DO[1]=ON",
    "LBL[3]",
    "L P[1] R[1]mm/sec FINE",
]
POINTS = [(1, 2, 3, 900, 100, 400, 180, 0, 30), (2, 2, 3, 950, 200, 350, 170, 5, 20)]


def receipt(source, target, *swaps, vendor="tp"):
    """Of a translation in which some texts are others, as a writer with a fault would write them."""
    made = converted(source, vendor, target)
    files = {}
    for name, data in made.files.items():
        text = data.decode("cp1252")
        for old, new in swaps:
            text = text.replace(old, new)
        files[name] = text.encode("cp1252")
    assert not swaps or files != made.files
    made = replace(made, files=files)
    program = read(source, vendor)
    runs = runs_of(program, made, target, (ROBOT, None))
    return receipt_of(link(program), made.translated, target, tuple(files), runs, (ROBOT, None))


def differences(found):
    return [one for one in found.verdict.objections if one.kind == "difference"]


@pytest.fixture(scope="module")
def source():
    return tp(*ROWS, positions=POINTS)


@pytest.mark.parametrize("target", TARGETS)
def test_a_translation_that_does_the_same_with_whatever_values_has_no_difference(source, target):
    found = receipt(source, target)
    # The plain run has no value for PR[5]; a JOB cannot ask whether a wait has timed out.
    assert_proven(found, "uncompared", *(["left-out"] if target == "inform" else []))
    assert len(found.made_up) >= 4
    assert sum(one.steps for one in found.made_up) >= 12
    assert "with other values for what no file tells" in as_text(found)


# What a plain run cannot see, because both programs take zeros: the swap, the line where it shows, what made it.
FAULTS = [
    ("rapid", ("R1:=R2 * 3", "R1:=R2 * 2"), "speed", "R002"),
    ("rapid", ("\\WObj:=frame_2", ""), "mm apart", "frame 2"),
    ("rapid", ("R4>2", "R4<=2"), "", "IN#(3)"),  # with it on, zero is enough
    ("rapid", ("PV7.trans,PV7.rot", "PV5.trans,PV5.rot"), "mm apart", "P00"),
    ("rapid", ("di3=1", "di3=0"), "", ""),
    ("urscript", ("set_tcp(tool_3)", "set_tcp(frame_2)"), "tools", "frame 2"),
    ("krl", ("BASE_DATA[2]", "BASE_DATA[3]"), "mm apart", "frame 2"),
    ("krl", ("TIMED_OUT=NOT ($IN[5]==TRUE)", "TIMED_OUT=FALSE"), "signal", ""),
]


@pytest.mark.parametrize(("target", "swap", "says", "thing"), FAULTS)
def test_a_fault_that_zeros_hide_is_found_with_what_shows_it(source, target, swap, says, thing):
    found = differences(receipt(source, target, swap))
    assert found, "the runs agree"
    assert says in " ".join(one.says for one in found)
    assert thing in found[0].says, found[0].says


# What it takes before it asks for two more things, and what the receipt tells of these.
TOGETHER = [
    (0, "with other values of R001, R002 together (no single one of them makes it differ)"),
    (
        8,
        "with other values of R011, R012, R013, R014 and 6 more together (which of them makes it differ is not known)",
    ),
]


@pytest.mark.parametrize(("others", "says"), TOGETHER)
def test_values_that_differ_together_are_not_named_as_the_cause_one_by_one(others, says):
    rows = [f"R[{n + 30}]=R[{n + 10}]" for n in range(1, others + 1)]
    rows += ["IF R[1]>2 AND R[2]>2,DO[1]=ON", "WAIT 1(sec)"]
    found = differences(receipt(tp(*rows), "rapid", ("R1>2 AND R2>2", "R1>2 AND R2>2 AND FALSE")))
    assert found, "the runs agree"
    assert found[0].says.partition(": ")[2].startswith(says), found[0].says


def test_each_thing_has_a_value_of_its_own_which_is_the_same_in_both_programs():
    one = MadeUp(1)
    other = MadeUp(1, {UnknownThing("variable", "count"): UnknownThing("variable", (Store.REAL, 5))})
    poses = [one.pose("tool", n) for n in (1, 2)] + [one.pose("frame", 1)]
    assert len({tuple(pose.position) for pose in poses}) == 3
    assert one.variable(Store.REAL, 5, False) == other.named("count", "real")
    assert one.pose("tool", 0) is None
    assert {MadeUp(seed).signal(("in", 1), False) for seed in (1, 2)} == {0, 1}


def test_nothing_is_made_up_in_a_plain_run_but_what_could_be_is_noted():
    plain = MadeUp()
    assert plain.variable(Store.ROBOT, 3, False) is None
    assert plain.pose("frame", 4) is None
    assert list(plain.asked) == [
        UnknownThing("variable", (Store.ROBOT, 3)),
        UnknownThing("frame", 4),
    ]


def test_registers_with_a_computed_number_are_as_many_as_the_source_has():
    """R[150] and more is there on a controller with 200: an array of 100 stops the program."""
    rows = ["R[1]=R[150]", "R[2]=R[R[1]]", "L P[1] R[2]mm/sec FINE"]
    made = converted(tp(*rows, positions=POINTS), "tp", "rapid")
    text = next(iter(made.files.values())).decode()
    assert "PERS num R{200}" in text


# --- what waits until the arm stands ------------------------------------------------------------------------------

PLACES = [
    f"CONST robtarget p{n}:=[[900,{y},400],[0,1,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];"
    for n, y in ((1, 0), (2, 100), (3, 200))
]


@pytest.mark.parametrize("word", ["WaitRob \\InPos;", "WaitRob \\ZeroSpeed;", "WaitTime\\InPos,0;"])
@pytest.mark.parametrize("target", ["krl", "tp", "inform", "urscript"])
def test_a_move_stops_exactly_before_what_waits_until_the_arm_stands(word, target):
    rows = ["MoveL p1,v100,fine,tool0;", "MoveL p2,v100,z10,tool0;", word, "SetDO do3,1;"]
    text = module(*rows, "MoveL p3,v100,z10,tool0;", "MoveL p1,v100,fine,tool0;", data=PLACES)
    exact = [BlendCode.EXACT, BlendCode.EXACT, None, BlendCode.EXACT]
    for plan in (read(text, "rapid").plan(robot=ROBOT), run_elsewhere(text, "rapid", target)):
        found = [int(code) for code in plan.moves.blend_code]
        assert [code == BlendCode.EXACT for code in found] == [code is not None for code in exact]
    made = converted(text, "rapid", target).translated
    assert [loss for loss in made.losses if loss.fate is not Fate.EXACT] == []


def test_steps_of_thousands_of_waits_behind_one_move_are_found_in_a_moment():
    text = "def f():\n movej([0,-1.5,1.5,0,1,0], r=0.01)\n n=0\n while n<5000:\n  n=n+1\n  sleep(0.01)\n end\nend\n"
    plan = run(read(text, "urscript"), max_steps=20_000)
    with cpu_time_below(0.5):  # more than a second with a search for the move from each wait
        steps = steps_of(plan)
    assert len(steps) == 5001
    assert steps[0].exact


def test_poses_that_are_made_up_are_not_turned_into_axes():
    """They are compared as poses; the axes of 900 of them took 4 ms each, three quarters of a long translation."""
    rows = [
        "FOR R[1]=1 TO 300",
        "J PR[R[1]] 50% FINE",
        "L PR[R[1]] 90mm/sec FINE",
        "J P[1] 50% FINE",
        "ENDFOR",
    ]
    program = read(tp(*rows, positions=POINTS), "tp")
    with cpu_time_below(1.5):
        plan = run(program, ROBOT, max_steps=10_000, made_up=MadeUp(1))
    assert len(plan.moves) == 900
    asked = run(program, ROBOT, max_steps=20, made_up=MadeUp(0))
    assert not np.isnan(asked.positions.axes[asked.moves.target[2]]).any()  # a plain run has them


def test_a_move_without_any_speed_is_as_fast_in_its_translation_as_in_its_run():
    text = krl("PTP {A1 0,A2 -90,A3 90,A4 0,A5 40,A6 0}", "LIN {X 900,Y 0,Z 400,A 0,B 90,C 0}")
    plans = read(text, "krl").plan(robot=ROBOT), run_elsewhere(text, "krl", "tp")
    assert [plan.moves.fraction[0] for plan in plans] == pytest.approx([UNTOLD_SPEED[FRACTION]] * 2)
    assert [plan.moves.travel[1] for plan in plans] == pytest.approx([UNTOLD_SPEED[TRAVEL]] * 2)


def test_a_whole_number_of_the_source_is_whole_in_a_register_that_could_hold_fractions():
    rows = ("DOUT OG#(26) B009", "SET I001 B009", "DOUT OG#(27) I001")
    found = receipt(inform(*rows), "tp", vendor="inform")
    assert_proven(found)
    assert sum(one.steps for one in found.made_up) >= 8


# --- What the main routine takes, which nothing here calls ---

_TAKES = ("UTOOL_NUM=1", "IF AR[1]>3,DO[7]=(ON)", "IF AR[2]=4,JMP LBL[1]", "WAIT AR[2]", "LBL[1]")


@pytest.mark.parametrize("target", ["krl", "rapid", "urscript"])
def test_arguments_that_nobody_passes_are_made_up_in_both_programs(target):
    found = receipt(tp(*_TAKES), target)
    assert_proven(found)
    assert sum(one.steps for one in found.made_up) >= 3
    assert "there was nothing to compare" not in as_text(found)


def test_a_parameter_that_is_used_otherwise_is_found():
    found = receipt(tp(*_TAKES), "rapid", ("arg1>3", "arg2>3"))
    assert differences(found)


def test_a_main_routine_runs_with_ones_for_what_it_takes_and_says_so():
    text = "MODULE M\nPROC main(num seconds \\num more)\nWaitTime seconds;\nWaitTime 2;\nENDPROC\nENDMODULE\n"
    plan = run(read(text, "rapid"))
    assert plan.durations.tolist() == [1.0, 2.0]
    assert any("argument 1 of the main routine" in one.says for one in plan.assumptions)


def test_steps_of_further_runs_are_paired_by_their_lines(tmp_path):
    """Each run reads the translation from a folder of its own: messages that follow one another slipped there."""
    rows = ["WAIT DI[5]=ON TIMEOUT,LBL[1]", "END", "LBL[1]", "MESSAGE[A]", "MESSAGE[B]", "MESSAGE[C]"]
    found = receipt(tp(*rows), "rapid")
    assert_proven(found)
    assert sum(one.steps for one in found.made_up) >= 10


@pytest.mark.parametrize("target", ["rapid", "tp", "urscript"])
def test_names_that_nothing_declares_are_made_up_however_they_are_spelt(target):
    """Languages that read capitals as small letters look names up folded: nothing was made up for these."""
    rows = [
        "SWITCH iStep",
        "CASE 1",
        "WAIT SEC 1",
        "CASE 2",
        "WAIT SEC rPause",
        "ENDSWITCH",
        "LIN XP1",
        "LIN XHOME",
    ]
    found = receipt(krl("$VEL.CP=0.3", "$BASE=$NULLFRAME", "$TOOL=$NULLFRAME", *rows), target, vendor="krl")
    assert_proven(found, "uncompared")
    assert sum(one.steps for one in found.made_up) >= 8


def test_names_that_became_registers_by_way_of_a_shorter_name_have_the_same_values():
    rows = [
        "IF bThisNameIsMuchTooLongForTP THEN",
        "WAIT SEC 1",
        "ENDIF",
        "IF rThisNumberHasALongNameToo>3 THEN",
        "WAIT SEC 2",
        "ENDIF",
    ]
    found = receipt(krl(*rows), "tp", vendor="krl")
    assert_proven(found, "uncompared")
    assert sum(one.steps for one in found.made_up) >= 3


def test_registers_whose_comments_became_legal_names_and_registers_again_have_the_same_values():
    rows = ["J P[1] 50% FINE", "L P[2] R[6:feed rate]mm/sec FINE Offset,PR[7:above it]"]
    found = receipt(tp(*rows, positions=POINTS), "inform")
    assert_proven(found, "uncompared")
    assert sum(one.steps for one in found.made_up) >= 6


@pytest.mark.parametrize("target", TARGETS)
def test_the_speed_that_the_welding_equipment_sets_is_the_same_in_both_runs(target):
    rows = ["J P[1] 50% FINE", "L P[2] WELD_SPEED CNT100", "L P[1] WELD_SPEED FINE"]
    found = receipt(tp(*rows, positions=POINTS), target)
    assert_proven(found)
    assert sum(one.steps for one in found.made_up) >= 6


def test_a_tool_whose_name_is_no_word_of_the_target_is_the_same_thing_in_both_runs():
    """Scripts have a function popup, so the tool that another file declares is popup_1 there."""
    text = module("MoveL [[600,0,600],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]],v500,fine,popup;")
    assert "set_tcp(popup_1)" in translated(text, "rapid", "urscript")
    found = receipt(text, "urscript", vendor="rapid")
    assert_proven(found)
    assert sum(one.steps for one in found.made_up) >= 4


def test_both_programs_start_at_the_same_routine():
    """Of a module without main the reader takes a procedure without parameters."""
    text = "DEF PART (n :IN)\nDECL INT n\nWAIT SEC n+1\nREST ( )\nEND\nDEF REST ( )\nWAIT SEC 9\nEND\n"
    found = receipt(text, "rapid", vendor="krl")
    assert_proven(found)
    assert found.comparison.steps == 2


def test_a_first_move_to_where_the_arm_stands_and_long_messages_are_no_difference():
    rows = ["PTP $AXIS_ACT", "PTP {A1 0,A2 -90,A3 90,A4 0,A5 20,A6 0}"]
    rows += ['$LOOP_MSG[]="a text that needs two lines on the pendant"', '$LOOP_MSG[]="b"', "WAIT SEC 1"]
    found = receipt(krl("$BASE=$NULLFRAME", "$TOOL=$NULLFRAME", *rows), "tp", vendor="krl")
    assert_proven(found)


def test_what_goes_wrong_for_an_argument_that_nobody_passes_is_a_warning():
    text = (
        "MODULE M\nVAR num list{3}:=[1,2,3];\nPROC main(num at)\nWaitTime list{at+5};\nENDPROC\nENDMODULE\n"
    )
    assert [d.severity.value for d in run(read(text, "rapid")).diagnostics if d.code == "I223"] == ["warning"]


STATES = ["IF $T1 OR NOT $IN_HOME THEN", "WAIT SEC 1", "ELSE", "WAIT SEC 3", "ENDIF", "IF $AUT THEN",
          "WAIT SEC 2", "ENDIF"]  # fmt: skip


@pytest.mark.parametrize("target", ["inform", "urscript"])
def test_variables_that_tell_of_the_controller_are_what_the_source_asked_of_it(target):
    found = receipt(krl(*STATES), target, vendor="krl")
    assert_proven(found)
    assert len(found.made_up) >= 4


def test_a_state_that_is_not_asked_is_a_difference_though_no_plain_run_shows_it():
    rows = ("IF $T1 THEN", "WAIT SEC 1", "ENDIF")
    found = receipt(krl(*rows), "urscript", ("if (manual_reduced)", "if (False)"), vendor="krl")
    assert differences(found)


@pytest.mark.parametrize("target", ["rapid", "tp"])
def test_a_wait_for_what_the_controller_tells_by_a_signal_is_the_same(target):
    """KUKA's waits for its own state name no signal, and their translations do: that is no difference."""
    text = krl("WAIT FOR $IN_HOME", "$OUT[5]=TRUE", "WAIT FOR $IN[4] AND $IN_HOME", "$OUT[6]=TRUE")
    made, linked = converted(text, "krl", target), link(read(text, "krl"))
    runs = runs_of(linked.program, made, target, (ROBOT, None))
    found = receipt_of(linked, made.translated, target, tuple(made.files), runs, (ROBOT, None))
    assert_proven(found)


def test_a_loop_over_two_groups_takes_as_many_passes_where_one_of_them_is_copied_first():
    """INFORM compares a group with a byte alone, which DIN sets; the run took the new byte for a change of its own."""
    text = module("WHILE gi1<>gi2 DO", "WaitTime 0.1;", "ENDWHILE", "SetDO do3,1;")
    made, linked = converted(text, "rapid", "inform"), link(read(text, "rapid"))
    runs = runs_of(linked.program, made, "inform", (ROBOT, None))
    assert [len(steps_of(both.source)) for both in runs.made_up if both.source is not None]
    for both in runs.made_up:
        assert both.source is not None
        assert both.target is not None
        assert len(steps_of(both.source)) == len(steps_of(both.target))


def test_a_name_of_an_inline_form_has_the_values_that_are_made_up_for_its_point():
    """XHOME_POS is HOME_POS: both runs were told to differ wherever no file has the position."""
    rows = ("UFRAME_NUM=1", "UTOOL_NUM=1", "J PR[3:HOME POS] 30% FINE", "L PR[4] 100mm/sec FINE")
    made_up = receipt(tp(*rows), "krl").made_up
    assert made_up
    assert all(not one.found for one in made_up)
