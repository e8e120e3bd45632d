"""The proof of a translation is a gate: it holds where both programs do the same, and says where they do not."""

from __future__ import annotations

from dataclasses import replace

import pytest
from translated_texts import assert_proven, converted, inform, krl, module, read, run_elsewhere, tp

from olp.__main__ import main
from olp.cli.convert import ACCEPTABLE as OPTIONS
from olp.robots.robot import load_robot
from olp.runtime.interpreter import run
from olp.runtime.plan import BlendCode
from olp.transpile.context import Context
from olp.transpile.convert import convert as translate
from olp.transpile.convert import runs_of
from olp.transpile.link import link, with_starts
from olp.transpile.receipt import _EXPLAINS, ACCEPTABLE, receipt_of
from olp.transpile.receipt_text import as_text

ROBOT = load_robot("yaskawa/gp25")
PLACES = [
    f"CONST robtarget p{n}:=[[{x},{y},{z}],[0,1,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];"
    for n, (x, y, z) in enumerate([(900, 0, 400), (900, 100, 400), (900, 200, 400), (850, 200, 450)], 1)
]
ROWS = [
    "MoveJ p1,v100,fine,tool0;",  # line 7
    "MoveL p2,v100,z10,tool0;",
    "SetDO do3,1;",
    "MoveL p3,v300,fine,tool0;",
    "WaitTime 0.5;",
    "IF di5=1 THEN",
    "MoveL p4,v100,fine,tool0;",
    "SetDO do4,1;",
    "ENDIF",
    "MoveC p4,p1,v100,fine,tool0;",
    "WaitDI di6,1;",
    "PulseDO\\High\\PLength:=1,do2;",
    "SetDO do3,0;",
]
SOURCE = module(*ROWS, data=PLACES)


def proof(source, target, *swaps, vendor="rapid"):
    """The receipt of a translation in which some texts are others, as a writer with a fault would write them."""
    made = converted(source, vendor, target)
    files = {}
    for name, data in made.files.items():
        text = data.decode("cp1252")
        for old, new in swaps:
            assert name.endswith(".dat") or old in text
            text = text.replace(old, new, 1)
        files[name] = text.encode("cp1252")
    made = replace(made, files=files)
    program = read(source, vendor)
    runs = runs_of(program, made, target, (ROBOT, None))
    return receipt_of(link(program), made.translated, target, tuple(files), runs, (ROBOT, None))


def first(receipt):
    one = receipt.verdict.objections[0]
    return one.kind, one.line, one.says


@pytest.mark.parametrize("target", ["krl", "tp", "inform", "urscript"])
def test_a_translation_that_does_the_same_is_proven(target):
    receipt = proof(SOURCE, target)
    assert [one for one in receipt.verdict.objections if one.kind not in ("named", "left-out")] == []
    assert receipt.comparison.steps >= 8
    assert receipt.again[0].steps >= receipt.comparison.steps + 2


# What is swapped in the URScript text, at which line of the source it shows, and what of the step it is.
FAULTS = [
    ([("0.9, 0.1, 0.4", "0.9, 0.101, 0.4")], 8, "mm apart"),
    ([("v=0.3)", "v=0.2)")], 10, "speed"),
    ([("r=0.01", "r=0.012")], 8, "blends"),
    ([("r=0.01", "r=0")], 8, "blends"),
    ([("set_standard_digital_out(3, True)", "set_standard_digital_out(3, False)")], 9, "do3"),
    ([("set_standard_digital_out(3, True)", "set_standard_digital_out(4, True)")], 9, "OT#(4)"),
    ([("sleep(0.5)", "sleep(0.6)")], 11, "waits"),
    ([("sleep(0.5)", "set_standard_digital_out(9, True)")], 11, "only the source"),
    ([("set_standard_digital_out(4, True)", "set_standard_digital_out(4, False)")], 14, "do4"),
    ([("set_standard_digital_out(4, True)", "sleep(0)")], 14, "only the source"),
]


@pytest.mark.parametrize(("swaps", "line", "says"), FAULTS)
def test_a_fault_is_found_at_the_line_where_it_shows_first(swaps, line, says):
    receipt = proof(SOURCE, "urscript", *swaps)
    kind, at, told = first(receipt)
    assert (kind, at) == ("difference", line), told
    assert says in told
    assert not receipt.verdict.holds(OPTIONS)
    assert "all exact" not in as_text(receipt)
    assert "the runs differ" in as_text(receipt)


def test_what_only_the_inputs_let_happen_is_compared_too():
    """Line 14 runs with di5 on: the assumed input is off."""
    receipt = proof(
        SOURCE, "urscript", ("set_standard_digital_out(4, True)", "set_standard_digital_out(4, False)")
    )
    assert receipt.comparison.is_equal
    assert [one.line for one in receipt.again[0].found] == [14]


def test_what_comes_behind_a_wait_that_is_not_timed_out_is_compared():
    rows = [*ROWS[:2], "WaitDI di6,1\\MaxTime:=5\\TimeFlag:=late;", "IF late RETURN;", *ROWS[2:4]]
    source = module(*rows, data=[*PLACES, "VAR bool late;"])
    receipt = proof(source, "krl", ("$OUT[3]=TRUE", "$OUT[3]=FALSE"))
    assert receipt.comparison.is_equal
    assert [one.line for one in receipt.again[0].found] == [12]


def test_the_proof_takes_no_notice_of_what_lies_in_the_folder_for_temporary_files(tmp_path, monkeypatch):
    left = "GLOBAL DEF DROP()\nPTP {A1 10}\nEND\n"
    (tmp_path / "left.src").write_text(left, encoding="ascii", newline="\r\n")
    (tmp_path / "olp.toml").write_text("[inputs]\nIN5 = 1\n", encoding="ascii")
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    receipt = proof(module("drop;", *ROWS, data=PLACES), "krl")
    assert_proven(receipt, "uncompared")  # the routine that it calls was not found


def test_what_the_reader_can_accept_is_what_a_verdict_knows():
    assert OPTIONS == ACCEPTABLE


# --- the command ----------------------------------------------------------------------------------------------------


def convert(tmp_path, capsys, name, text, target, *more):
    (tmp_path / name).write_bytes(text.encode("cp1252"))
    where = ("-o", str(tmp_path / "out"), "--force", "--robot", "yaskawa/gp25")
    status = main(["convert", str(tmp_path / name), "--to", target, *where, *more])
    return status, capsys.readouterr().out


def test_the_exit_status_is_0_for_a_proven_translation(tmp_path, capsys):
    status, told = convert(tmp_path, capsys, "M.mod", module(*ROWS[:5], data=PLACES), "krl")
    assert (status, "proven: every step of both runs agrees within 0.01 mm" in told) == (0, True)


def test_what_is_left_out_ends_with_1_unless_the_reader_accepts_it(tmp_path, capsys):
    text = module(*ROWS[:3], "ERROR", "SetDO do9,1;", data=PLACES)
    status, told = convert(tmp_path, capsys, "M.mod", text, "krl", "--on-loss", "comment")
    assert status == 1
    assert "not proven: left out of the translation, first at" in told
    assert "M.mod:10" in told
    assert (
        convert(tmp_path, capsys, "M.mod", text, "krl", "--on-loss", "comment", "--accept", "left-out")[0]
        == 0
    )


def test_a_run_that_needs_unknown_values_ends_with_1_unless_the_reader_accepts_it(tmp_path, capsys):
    text = tp("J P[1] 100% FINE", "L PR[5] 100mm/sec FINE", positions=[(1, 0, 0, 900, 0, 400, 180, 0, 0)])
    status, told = convert(tmp_path, capsys, "part.ls", text, "rapid")
    assert (status, "could not be compared to their end" in told) == (1, True)
    assert convert(tmp_path, capsys, "part.ls", text, "rapid", "--accept", "uncompared")[0] == 0


def test_a_difference_that_the_receipt_names_is_accepted_or_within_a_tolerance(tmp_path, capsys):
    text = module("MoveJ p1,v100,fine,tool0;", "MoveJ p2,v300,fine,tool0;", data=PLACES)
    status, told = convert(tmp_path, capsys, "M.mod", text, "krl")
    assert (status, "the runs differ as is named below" in told) == (1, True)
    assert convert(tmp_path, capsys, "M.mod", text, "krl", "--accept", "named")[0] == 0
    assert convert(tmp_path, capsys, "M.mod", text, "krl", "--tolerance", "speed=10")[0] == 0
    assert convert(tmp_path, capsys, "M.mod", text, "krl", "--tolerance", "blur=10")[0] == 2


@pytest.mark.parametrize("count", [3, 4, 5, 6, 7])
@pytest.mark.parametrize("target", ["krl", "rapid", "tp", "urscript"])
def test_runs_of_arcs_of_any_length_are_paired_with_what_was_made_of_them(count, target, tmp_path, capsys):
    places = [(800, 0), (850, 50), (900, 10), (960, -50), (1000, 0), (1050, 55), (1060, 90), (1050, 120)]
    flags = ",".join("0" * 24)
    rows = ["///TOOL 0", "///POSTYPE ROBOT", "///RECTAN", f"///RCONF {flags}"]
    rows += [f"C{n:05d}={x},{y},400.000,180.0000,0.0000,0.0000" for n, (x, y) in enumerate(places)]
    moves = [f"MOVC C{n:05d} V=100.0 PL=0" for n in range(count)]
    moves = ["MOVJ C00000 VJ=50.00 PL=0", *moves, "MOVL C00007 V=100.0 PL=0"]
    text = inform(*moves, points=rows)
    status, told = convert(tmp_path, capsys, "PART.JBI", text, target)
    assert status == 0, told
    assert f"both run: {count + 2} steps" in told or f"both run: {count + 1} steps" in told


def test_what_the_run_with_the_inputs_on_leaves_out_is_not_proven(tmp_path, capsys):
    text = krl("BAS(#INITMOV,0)", "IF $IN[1] THEN", "LIN XP9", "ENDIF")
    status, told = convert(tmp_path, capsys, "part.src", text, "rapid")
    assert (status, "could not be compared to their end" in told) == (1, True)


def test_moves_that_no_run_comes_to_are_named(tmp_path, capsys):
    text = module(
        "MoveL p1,v100,fine,tool0;", "IF 1=2 THEN", "MoveL p2,v100,fine,tool0;", "ENDIF", data=PLACES
    )
    told = convert(tmp_path, capsys, "M.mod", text, "krl")[1]
    assert "no run comes to these moves, so they were not compared" in told


def test_an_acceleration_that_is_left_out_explains_no_other_speed():
    assert "acceleration" not in _EXPLAINS


@pytest.mark.parametrize("loop", [("WHILE TRUE DO", "ENDWHILE"), ("again:", "GOTO again;")])
def test_a_main_loop_that_stands_still_goes_on_with_another_input_however_it_is_spelt(loop):
    rows = (loop[0], "IF di1=1 THEN", "MoveL p1,v100,fine,tool0;", "ENDIF", loop[1])
    text = module("MoveL p2,v100,fine,tool0;", *rows, data=PLACES)
    assert len(read(text, "rapid").plan(robot="yaskawa/gp25").moves) == 2


@pytest.mark.parametrize("target", ["krl", "inform"])
def test_an_output_at_the_end_of_a_move_is_in_both_runs(target):
    receipt = proof(
        module("MoveL p1,v100,fine,tool0;", "MoveLDO p2,v100,fine,tool0,do1,1;", data=PLACES), target
    )
    assert receipt.verdict.agrees


@pytest.mark.parametrize(("vendor", "target"), [("rapid", "krl"), ("krl", "rapid")])
def test_the_move_before_a_stop_of_the_program_ends_exactly(vendor, target):
    """Where it goes on is not known then: RAPID's was timed and translated as one that passes its target."""
    rapid = ["MoveJ p1,v100,fine,tool0;", "MoveL p2,v100,z10,tool0;", "Stop;", "MoveL p1,v100,fine,tool0;"]
    data = [
        f"CONST robtarget p{n}:=[[{x},0,500],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];"
        for n, x in ((1, 900), (2, 950))
    ]
    points = ["{X 900,Y 0,Z 500,A 0,B 180,C 0}", "{X 950,Y 0,Z 500,A 0,B 180,C 0}"]
    text = {
        "rapid": module(*rapid, data=data),
        "krl": krl(
            "$VEL.CP=0.1",
            "$APO.CDIS=10",
            f"PTP {points[0]}",
            f"LIN {points[1]} C_DIS",
            "HALT",
            f"LIN {points[0]}",
        ),
    }[vendor]
    assert run(read(text, vendor), ROBOT).moves.blend_code[1] == BlendCode.EXACT
    assert run_elsewhere(text, vendor, target).moves.blend_code[1] == BlendCode.EXACT


@pytest.mark.parametrize("made_up", [False, True], ids=["plain", "made up"])
def test_a_loop_without_end_that_only_the_translation_has_is_a_difference(made_up):
    """What one run alone never comes to is not excused by the other's being stopped."""
    first = "WaitTime 1;" if not made_up else "IF count>3 SetDO do5,1;"
    source = module(first, "SetDO do3,1;", "SetDO do4,1;", "WaitTime 2;", data=["PERS num count:=1;"])
    assert proof(source, "krl").verdict.agrees
    looped = proof(source, "krl", ("$OUT[4]=TRUE", "LOOP\n$OUT[4]=TRUE\nENDLOOP"))
    assert "difference" in {one.kind for one in looped.verdict.objections}


def test_a_statement_that_fails_for_an_argument_that_nobody_passes_is_not_proven():
    """Both runs leave it out: they agree about nothing."""
    source = module("WaitTime list{at+5};", "WaitTime 1;", data=["VAR num list{3}:=[1,2,3];"])
    found = proof(source.replace("main()", "main(num at)"), "krl")
    assert {one.kind for one in found.verdict.objections} == {"uncompared"}
    assert "outside of the array" in found.verdict.objections[0].says


def test_a_trigger_above_its_move_is_the_output_of_the_move_that_names_it():
    """TRIGGER has a line of its own, TriggL switches in the line of its move: they were two different outputs."""
    points = "{X 900,Y 0,Z 500,A 0,B 180,C 0}", "{X 950,Y 0,Z 500,A 0,B 180,C 0}"
    rows = [
        f"PTP {points[0]}",
        "TRIGGER WHEN DISTANCE=1 DELAY=-50 DO $OUT[9]=TRUE",
        f"LIN {points[1]}",
        f"LIN {points[0]}",
    ]
    found = proof(krl("$VEL.CP=0.1", *rows), "rapid", vendor="krl")
    assert found.verdict.agrees
    late = proof(
        krl("$VEL.CP=0.1", *rows),
        "rapid",
        ("TriggIO olp_triggdata1,0.05", "TriggIO olp_triggdata1,0.5"),
        vendor="krl",
    )
    assert not late.comparison.is_equal


@pytest.mark.parametrize("target", ["krl", "tp", "inform", "urscript"])
def test_a_wait_beside_a_word_that_became_a_comment_is_compared(target):
    """`\\InPos` is told in the line of its wait, which was then in none of both runs' steps: a lost wait was proven."""
    source = module(
        "MoveL p1,v100,z10,tool0;", "WaitTime\\InPos,0.2;", "MoveL p2,v100,fine,tool0;", data=PLACES
    )
    assert proof(source, target).verdict.agrees
    words = {"krl": "WAIT SEC 0.2", "tp": "WAIT 0.2(sec)", "inform": "TIMER T=0.20", "urscript": "sleep(0.2)"}
    assert "difference" in {one.kind for one in proof(source, target, (words[target], "")).verdict.objections}


@pytest.mark.parametrize("target", ["rapid", "krl", "tp", "urscript"])
@pytest.mark.parametrize("word", ["TF", "BF", "UF#(3)"])
def test_a_move_by_an_offset_of_inform_has_the_tool_of_the_point_before(word, target):
    """The flange was moved by it, though the point before names tool 1."""
    points = [
        "///TOOL 1", "///POSTYPE BASE", "///RECTAN", "///RCONF 0,0,0,0,0,0,0,0",
        "C00000=900.000,0.000,400.000,180.0000,0.0000,0.0000", "P00010=0.000,0.000,50.000,0.0000,0.0000,0.0000",
    ]  # fmt: skip
    text = inform("MOVJ C00000 VJ=50.00", f"IMOV P010 V=100.0 PL=0 {word}", points=points)
    receipt = proof(text, target, vendor="inform")
    runs = (receipt.comparison, *receipt.again, *receipt.made_up)
    differs = {(x.part, x.line) for run in runs for x in run.found}
    assert differs <= {
        ("blend", 16)
    }  # told of the point before: the arm stops where the next move counts from it
    assert {one.kind for one in receipt.verdict.objections} == ({"named"} if differs else set())
    assert not [x for x in receipt.losses if x.leaves_out]


@pytest.mark.parametrize("target", ["inform", "krl", "tp"])
def test_routines_that_nobody_calls_are_started_each_with_what_they_use(target):
    rows = [
        "PROC first()", "MoveL p1,v100,fine,t1;", "WaitTime n;", "n:=n+1;", "ENDPROC",
        "PROC second()", "MoveL p2,v100,fine,t1;", "WaitTime n+m;", "third;", "ENDPROC",
        "PROC third()", "m:=m+1;", "MoveL p3,v100,fine,t1;", "ENDPROC",
    ]  # fmt: skip
    data = [*PLACES, "PERS tooldata t1:=[TRUE,[[0,0,100],[1,0,0,0]],[1,[0,0,1],[1,0,0,0],0,0,0]];"]
    data += ["VAR num n:=2;", "VAR num m:=3;"]
    source = with_starts(read("\r\n".join(["MODULE M", *data, *rows, "ENDMODULE"]), "rapid"))
    assert [r.name for r in source.routines if r.starts] == ["second"]
    made = translate(source, target, Context(robot=ROBOT, on_loss="comment"))
    runs = runs_of(source, made, target, (ROBOT, None))
    found = receipt_of(link(source), made.translated, target, tuple(made.files), runs, (ROBOT, None))
    assert found.verdict.holds()
    assert not found.unreached
    assert [(name, one.steps, one.differences) for name, one in found.starts.items()] == [("second", 3, [])]


def test_a_routine_is_a_start_whatever_words_of_ours_its_name_is():
    """A routine called Message was taken for one that a statement names, and never run."""
    ours = ["Message", "signal", "tool", "value"]
    rows = [
        "PROC first()",
        'TPWrite "go"+NumToStr(2,0);',
        "MoveL p1,v100,fine,tool0;",
        "SetDO do1,1;",
        "ENDPROC",
    ]
    for name in ours:
        rows += [f"PROC {name}()", "WaitTime 1;", "ENDPROC"]
    source = with_starts(read("\r\n".join(["MODULE M", *PLACES, *rows, "ENDMODULE"]), "rapid"))
    assert [r.name for r in source.routines if r.starts] == ours


@pytest.mark.parametrize("target", ["rapid", "krl", "inform"])
def test_inputs_with_computed_numbers_end_the_same_loops_in_both_runs(target):
    """RAPID leaves out what stands behind an AND that is decided, so that the last input read is another there."""
    asks = [
        "DO[3]=PULSE,0.1sec", "R[1]=5", "R[2]=6", "IF (RI[R[1]]=ON AND RI[R[2]]=ON),R[3]=(1)",
        "IF (RI[R[1]]=ON AND RI[R[2]]=OFF),R[3]=(0)", "IF (RI[R[1]]=OFF AND RI[R[2]]=OFF),R[4]=(1)",
    ]  # fmt: skip
    rows = ["L P[1] 100mm/sec FINE", "LBL[1]", *asks, "IF R[3]<>1,JMP LBL[1]", "DO[1]=ON"]
    rows += ["LBL[2]", *asks, "IF R[3]<>0,JMP LBL[2]", "DO[2]=ON", "L P[2] 100mm/sec FINE"]
    points = [(1, 0, 0, 900, 0, 400, 180, 0, 0), (2, 0, 0, 900, 100, 400, 180, 0, 0)]
    found = proof(tp(*rows, positions=points), target, vendor="tp")
    assert not found.comparison.differences
    assert not [x for x in found.verdict.objections if "differ" in x.says]


def test_a_difference_that_comes_back_in_a_loop_is_told_once_with_the_number_of_its_steps():
    moves = ["MoveL p1,v100,z20,tool0;", "MoveJ p2,v100,fine,tool0;"]
    receipt = proof(module("FOR i FROM 1 TO 3 DO", *moves, "ENDFOR", data=PLACES), "krl")
    (told,) = (line for line in as_text(receipt).splitlines() if line.startswith("  lines "))
    assert told.startswith("  lines 9 and ")
    assert ", step 2 and 2 later: time at speed 1 and " in told
    assert sum("time at speed" in one for one in receipt.comparison.differences) == 3


def test_names_that_nobody_declares_are_told_together():
    rows = ["PTP XP1", "PTP XP2", "PTP XP3"]
    receipt = proof(krl(*rows), "rapid", vendor="krl")
    told = [line for line in as_text(receipt).splitlines() if "is not declared here" in line]
    assert len(told) == 1
    assert "each of 3 names is not declared here: taken for a Cartesian position" in told[0]
    assert told[0].endswith(": XP1, XP2, XP3")
