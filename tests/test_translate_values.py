"""Texts, arrays, computed values and tasks, which each language holds in its own way."""

import math
import re

import pytest
from translated_texts import (
    ROBOT,
    VENDORS,
    assert_proven,
    converted,
    krl,
    module,
    read,
    run_elsewhere,
    script,
    tp,
    translated,
)

import olp
from olp.ir.expressions import Text
from olp.ir.transformer import expressions_of
from olp.runtime.assumptions import SignalKey
from olp.transpile.compare import compare_plans
from olp.transpile.context import Fate
from olp.transpile.convert import run_converted, runs_of
from olp.transpile.link import link
from olp.transpile.receipt import receipt_of

TEXTS = """DEF a()
DECL CHAR s[10]
DECL CHAR t[10]
DECL INT n
s[]="abc"
t[]=s[]
n=STRLEN(t[])
WAIT SEC n*0.1
b(s[])
END
DEF b(x[]:IN)
DECL CHAR x[]
WAIT SEC 0.2
END
"""
POSES = [f"[[900,{y},500],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]]" for y in (0, 50)]


@pytest.mark.parametrize("target", [v for v in VENDORS if v != "krl"])
def test_krl_texts_are_one_value(target):
    plan = run_elsewhere(TEXTS, "krl", target)
    assert plan.durations.tolist() == pytest.approx([0.3, 0.2])


def test_a_single_character_of_a_text_is_refused():
    text = TEXTS.replace("t[]=s[]", "t[1]=s[2]")
    losses = converted(text, "krl", "rapid").translated.losses
    assert any(loss.line == 6 and loss.fate is not Fate.EXACT for loss in losses)


@pytest.mark.parametrize("target", [v for v in VENDORS if v != "rapid"])
def test_arrays_that_are_assigned_as_a_whole(target):
    text = module(
        f"ps := [{POSES[0]},{POSES[1]}];",
        "w := [0.1,0.2,0.3];",
        "FOR i FROM 1 TO 2 DO",
        "MoveL ps{i}, v100, fine, tool0;",
        "ENDFOR",
        "WaitTime w{3};",
        data=("VAR robtarget ps{2};", "VAR num w{3};"),
    )
    plan = run_elsewhere(text, "rapid", target)
    assert plan.positions.position[plan.moves.target][:, 1].tolist() == pytest.approx([0.0, 0.05], abs=1e-6)
    assert plan.durations.tolist() == pytest.approx([0.3])


@pytest.mark.parametrize("target", ["inform", "tp"])
@pytest.mark.parametrize(
    ("statement", "computed"),
    [
        ("SetGO go1, n * 2 + 1;", r"\bOG#\(1\) B|GO\[1\]=R\["),
        ("SetAO ao1, n * 2 + 1;", r"AO#\(1\) [RD]|AO\[1\]=R\["),
    ],
)
def test_what_a_signal_is_set_to_is_computed_before(target, statement, computed):
    import re

    text = module(
        "k := 2;", "n := n + k;", statement, "WaitTime 0.1;", data=("VAR num n := 3;", "VAR num k;")
    )
    made = converted(text, "rapid", target)
    written = made.files[made.main].decode("latin-1").splitlines()
    at = next(n for n, row in enumerate(written) if re.search(computed, row))
    assert "* 2 + 1" in written[at - 1] or "*2+1" in written[at - 1]


def test_a_text_that_is_put_together_is_computed_before_it_is_shown():
    text = module('TPWrite "x" + s;', "WaitTime 0.1;", data=('VAR string s := "abc";',))
    made = converted(text, "rapid", "inform")
    rows = made.files[made.main].decode("latin-1").splitlines()
    at = next(n for n, row in enumerate(rows) if row.startswith("MSG S"))
    assert rows[at - 1].startswith(f"CAT$ {rows[at].split()[1]} ")


def test_conditions_of_inform_compare_one_value_with_another():
    text = module(
        "k := 2;", "WHILE n * 2 < 20 AND k + 1 > 0 DO", "n := n + k;", "ENDWHILE", "WaitTime n / 10;",
        data=("VAR num n := 3;", "VAR num k;"),
    )  # fmt: skip
    made = converted(text, "rapid", "inform")
    rows = made.files[made.main].decode("latin-1").splitlines()
    conditions = [row for row in rows if "IF" in row.split()[0] or row.startswith(("WHILE", "JUMP"))]
    assert conditions
    assert not any(sign in row for row in conditions for sign in (" + ", " * ", " - ", " / "))
    assert run_elsewhere(text, "rapid", "inform").durations.tolist() == pytest.approx([1.1])


def test_tasks_have_numbers_in_inform():
    text = """def f():
  thread blink():
    sleep(0.5)
  end
  h = run blink()
  movej([0,-1.5,1.5,0,1.5,0])
  join h
end
"""
    made = converted(text, "urscript", "inform")
    written = b"".join(made.files.values()).decode("latin-1")
    assert "PSTART JOB:blink SUB1" in written
    assert "PWAIT SUB1" in written
    assert made.translated.mapping["task", "h"] == "SUB1"


def test_a_task_gets_no_number_that_another_has():
    text = script("thread blink():", "  sleep(0.5)", "end", "thread look():", "  sleep(0.2)", "end",
                  "h = run blink()", "SUB1 = run look()", "join h", "join SUB1")  # fmt: skip
    made = converted(text, "urscript", "inform")
    written = b"".join(made.files.values()).decode("latin-1")
    assert "PSTART JOB:blink SUB2" in written
    assert "PSTART JOB:look SUB1" in written


@pytest.mark.parametrize(("quoted", "plain"), [('"a""b"', "a'b"), ('"a\\0Ab\\0D\\0A"', "ab")])
@pytest.mark.parametrize("target", ["krl", "urscript", "inform"])
def test_texts_are_written_without_what_the_target_has_none_for(quoted, plain, target):
    made = converted(module(f"s := {quoted};", "TPWrite s;", data=("VAR string s;",)), "rapid", target)
    told = [loss.line for loss in made.translated.losses if loss.part == "text"]
    assert told
    assert not [loss for loss in made.translated.losses if loss.leaves_out]
    assert f'"{plain}"' in b"".join(made.files.values()).decode()


def test_a_text_that_a_condition_asks_for_keeps_its_line_end_or_goes():
    text = module('s := "a\\0A";', 'IF s = "b\\0A" WaitTime 1;', data=("VAR string s;",))
    made = converted(text, "rapid", "krl")
    assert len({loss.line for loss in made.translated.losses if loss.leaves_out}) == 2


def test_rapid_takes_arrays_of_points_in_an_assignment(tmp_path):
    path = tmp_path / "m.mod"
    path.write_text(module(f"ps := [{POSES[0]},{POSES[1]}];", data=("VAR robtarget ps{2};",)))
    assert not [d for d in olp.read(path).diagnostics if d.is_error]


@pytest.mark.parametrize("target", [v for v in VENDORS if v != "krl"])
def test_components_that_krl_leaves_out_are_those_of_the_move_before(target):
    text = krl(
        "BAS (#INITMOV,0)",
        "PTP {A1 0,A2 -90,A3 90,A4 0,A5 10,A6 0}",
        "PTP {A1 5,A2 -80}",
        "LIN {X 900,Y 0,Z 500,A 0,B 90,C 0}",
        "LIN {Z 450}",
    )
    made = converted(text, "krl", target, on_loss="error")
    plan, other = read(text, "krl").plan(robot=ROBOT), run_converted(made, target, ROBOT)
    assert compare_plans(plan, other, speeds=False, blends=False).is_equal


@pytest.mark.parametrize("between", ["OTHER()", "LABEL:", "PTP XHOME"])
def test_components_of_a_move_that_may_not_be_the_one_before_are_those_of_the_arm_then(between):
    text = krl("BAS (#INITMOV,0)", "LIN {X 900,Y 0,Z 500,A 0,B 90,C 0}", between, "LIN {Z 450}")
    made = converted(text, "krl", "rapid")
    assert not [loss for loss in made.translated.losses if loss.leaves_out]
    written = b"".join(made.files.values()).decode()
    assert re.search(r"(target):=CRobT\(.*\);\s+\1\.trans\.z:=450;\s+(AccSet.*\s+)?MoveL \1,", written)


@pytest.mark.parametrize("target", [v for v in VENDORS if v != "krl"])
def test_components_that_nothing_tells_are_refused(target):
    text = krl("DECL E6POS q", "BAS (#INITMOV,0)", "q={X 900,Y 0,Z 500,A 0,B 90,C 0}", "q={Y 20}", "LIN q")
    made = converted(text, "krl", target)
    refused = {loss.line for loss in made.translated.losses if loss.leaves_out}
    assert refused == {5, 6}  # the position, and the move that would go there
    assert [loss.line for loss in made.translated.losses if "it needs q" in loss.says] == [6]


AXES = krl(
    "DECL E6AXIS q",
    "DECL REAL x",
    "BAS (#INITMOV,0)",
    "x=5",
    "q={A1 0,A2 -90,A3 90,A4 0,A5 10,A6 0}",
    "q.A1=x*2",
    "q.A2=-80",
    "PTP q",
    "x=q.A2+85",
    "IF x>3 THEN",
    "q.A3=80+x",
    "ENDIF",
    "PTP q",
)


@pytest.mark.parametrize("target", ["rapid", "tp", "urscript"])
def test_single_axes_of_joint_values(target):
    plan, other = read(AXES, "krl").plan(robot=ROBOT), run_elsewhere(AXES, "krl", target)
    assert len(plan.moves) == 2
    assert compare_plans(plan, other, speeds=False, blends=False).is_equal


def test_single_axes_of_joint_values_are_refused_for_inform_and_who_needs_them_is_named():
    losses = converted(AXES, "krl", "inform").translated.losses
    assert {loss.line for loss in losses if loss.leaves_out} == {7, 8, 9, 10, 12, 14}
    assert {loss.line for loss in losses if "it needs" in loss.says} == {9, 11, 14}


@pytest.mark.parametrize("target", [v for v in VENDORS if v != "inform"])
def test_a_tool_that_a_job_sets_by_counts_is_a_constant(target):
    from translated_texts import inform

    text = inform(
        "SETE P00095 (1) -30000", "SETE P00095 (3) 40000", "SETE P00095 (5) -6000", "SETTOOL TL#(9) P00095",
        "MOVL P00001 V=200.0 PL=0",
        points=(
            "///TOOL 9", "///POSTYPE BASE", "///RECTAN", "///RCONF 1,0,0,0,0,0,0,0",
            "P00001=900.000,0.000,500.000,180.0000,0.0000,0.0000",
            "P00095=0.000,0.000,0.000,0.0000,0.0000,0.0000",
        ),
    )  # fmt: skip
    made = converted(text, "inform", target, on_loss="error")
    plan, other = read(text, "inform").plan(robot=ROBOT), run_converted(made, target, ROBOT)
    assert compare_plans(plan, other, speeds=False, blends=False).is_equal


REFERENCES = module(
    f"walk {POSES[0]}, n;",
    "count n;",
    "WaitTime n / 10;",
    "ENDPROC",
    "PROC walk(VAR robtarget p, VAR num k)",
    "inner p, k;",
    "ENDPROC",
    "PROC inner(VAR robtarget p, VAR num k)",
    "FOR i FROM 1 TO k DO",
    "MoveL Offs(p,0,10*i,0), v100, fine, tGrip;",
    "ENDFOR",
    "ENDPROC",
    "PROC count(VAR num k)",
    "IF k > 5 RETURN;",
    "k := k + 1;",
    data=(
        "PERS tooldata tGrip := [TRUE,[[0,0,100],[1,0,0,0]],[1,[0,0,1],[1,0,0,0],0,0,0]];",
        "VAR num n := 2;",
    ),
)


@pytest.mark.parametrize("target", [v for v in VENDORS if v != "rapid"])
def test_parameters_that_are_handed_back(target):
    made = converted(REFERENCES, "rapid", target, on_loss="error")
    plan, other = read(REFERENCES, "rapid").plan(robot=ROBOT), run_converted(made, target, ROBOT)
    assert compare_plans(plan, other, speeds=False, blends=False).is_equal
    assert other.durations.tolist() == pytest.approx([0.3])


def test_a_constant_tool_may_be_handed_to_a_routine_that_could_change_it():
    text = module(
        "go tool0;", "ENDPROC", "PROC go(PERS tooldata t)", f"MoveL {POSES[0]}, v100, fine, t;"
    )  # fmt: skip
    plan = read(text, "rapid").plan(robot=ROBOT)
    assert len(plan.moves) == 1
    assert not plan.stop_reason


SIGNS = ['a""b', "a\\0Ab", "a\\0Db", "ab\\\\", "a#b", "a'b", "a;b", "a]b"]


@pytest.mark.parametrize("written", SIGNS)
@pytest.mark.parametrize("target", [v for v in VENDORS if v != "rapid"])
def test_no_sign_of_a_text_breaks_the_file_that_holds_it(target, written):
    """It comes back as it was, or a loss names its line."""
    rows = (f's := "{written}";', f'TPWrite "{written}";', "TPWrite first;", "WaitTime 0.1;")
    text = module(*rows, data=("VAR string s;", f'VAR string first := "{written}";'))
    made = converted(text, "rapid", target)
    plan = run_converted(made, target, ROBOT, read(text, "rapid"))  # it reads back, or this raises
    assert plan.durations.tolist()[-1] == pytest.approx(0.1)
    lost = {loss.line for loss in made.translated.losses}
    one = next(
        e.value for s in read(text, "rapid").statements() for e in expressions_of(s) if isinstance(e, Text)
    )
    back = read(made.files[made.main].decode("cp1252"), target)
    found = {e.value for s in back.statements() for e in expressions_of(s) if isinstance(e, Text)}
    assert one in found or {5, 6} <= lost


def registers(*rows):
    joint = "GP1:\n\tUF : 0, UT : 1,\t\n\tJ1= 5.5 deg,\tJ2= -12.25 deg,\tJ3= 18.75 deg,\n"
    joint += "\tJ4= 3.5 deg,\tJ5= -47.25 deg,\tJ6= 21.0 deg\n"
    numbered = [f"{n:4}:  {row} ;" for n, row in enumerate(rows, 1)]
    head = ["/PROG  PART", "/ATTR", "DEFAULT_GROUP\t= 1,*,*,*,*;", "/MN"]
    return "\n".join([*head, *numbered, "/POS", f"P[1]{{\n   {joint}}};", "/END", ""])


@pytest.mark.parametrize("target", [v for v in VENDORS if v != "tp"])
def test_a_register_that_nothing_sets_has_to_be_taught(target):
    made = converted(registers("UTOOL_NUM=1", "L PR[38:pick] 250mm/sec FINE"), "tp", target)
    told = [loss for loss in made.translated.losses if loss.part == "position"]
    assert [loss.line for loss in told] == [6]
    asked = [name for names in made.translated.asks.values() for name in names]
    assert "pick" in [name.partition(" (")[0] for name in asked]
    if target == "inform":
        written = made.files[made.main].decode("latin-1")
        assert "MOVL P0" in written
        assert "C00000=" not in written


@pytest.mark.parametrize("target", [v for v in VENDORS if v != "tp"])
def test_a_register_that_holds_joint_values_is_declared_as_such(target):
    text = registers("UTOOL_NUM=1", "PR[4]=P[1]", "J PR[4] 50% FINE", "WAIT 1.0(sec)")
    plan, other = read(text, "tp").plan(robot=ROBOT), run_elsewhere(text, "tp", target)
    assert compare_plans(plan, other, speeds=False, blends=False).is_equal
    declared = {
        "krl": "DECL GLOBAL E6AXIS PV4",
        "rapid": "PERS jointtarget PV4",
        "urscript": "global PV4 = [",
    }
    made = converted(text, "tp", target)
    written = b"".join(made.files.values()).decode("latin-1")
    assert declared.get(target, "") in written


@pytest.mark.parametrize("target", ["krl", "tp"])
def test_a_small_power_is_a_product_where_there_is_no_function_for_it(target):
    text = module("x:=Pow(x+2,3);", "WaitTime x;", "x:=Pow(9,0.5);", "WaitTime x;", "WaitTime Pow(2,n)-1;",
                  data=("VAR num x:=0;", "CONST num n:=3;"))  # fmt: skip
    assert run_elsewhere(text, "rapid", target).durations.tolist() == pytest.approx([8.0, 3.0, 7.0])


def test_the_manual_modes_of_kuka_and_abb_are_each_others():
    """$T1 is manual at reduced speed, $T2 at full speed; both runs are in automatic."""
    rows = (
        "BOOL B",
        "IF $T1 OR $T2 THEN",
        "WAIT SEC 1",
        "ENDIF",
        "B=NOT $T1",
        "IF B THEN",
        "WAIT SEC 2",
        "ENDIF",
    )
    text = krl(*rows)
    there = translated(text, "krl", "rapid")
    assert "IF OpMode()=OP_MAN_PROG OR OpMode()=OP_MAN_TEST THEN" in there
    assert run_elsewhere(text, "krl", "rapid").durations.tolist() == pytest.approx([2.0])
    back = translated(there, "rapid", "krl")
    assert "IF $T1 OR $T2 THEN" in back
    assert "=NOT $T1" in back


def test_what_may_be_a_fraction_is_rounded_before_it_is_divided_in_krl():
    rows = (
        "h:=7;",
        "other h;",
        "r:=h MOD 5;",
        "SetAO ao1,r;",
        "SetAO ao2,h DIV 5;",
        "IF h MOD 2=1 WaitTime 1;",
    )
    text = module(*rows, data=("VAR num h;", "VAR num r;"))
    losses = converted(text, "rapid", "krl").translated.losses
    assert {loss.line for loss in losses if "which is rounded" in loss.says} == {7, 9, 10}
    written = translated(text, "rapid", "krl")
    assert "r=whole_index-whole_index/5*5" in written


@pytest.mark.parametrize(("n", "by"), [(17, 6), (-17, 6), (5, 5), (0, 3)])
def test_remainders_of_whole_numbers_are_exact_in_krl(n, by):
    rows = (f"h:={n};", f"r:=h MOD {by};", "SetAO ao1,r;", f"SetAO ao2,h DIV {by};")
    text = module(*rows, data=("VAR num h;", "VAR num r;"))
    losses = [one for one in converted(text, "rapid", "krl").translated.losses if one.fate is not Fate.EXACT]
    assert not [loss for loss in losses if "analog" not in loss.says]
    plan = run_elsewhere(text, "rapid", "krl")
    assert [event.value for _, event in sorted(plan.events.items())] == [math.fmod(n, by), int(n / by)]


def test_a_remainder_of_a_fraction_in_the_head_of_a_loop_is_rejected_in_krl():
    text = module("other h;", "WHILE h MOD 2=1 DO", "h:=h+1;", "ENDWHILE", data=("VAR num h;",))
    assert 5 in {loss.line for loss in converted(text, "rapid", "krl").translated.losses if loss.leaves_out}


@pytest.mark.parametrize("target", ["tp", "krl"])
def test_rounded_and_cut_numbers_are_those_of_the_source(target):
    rows = (
        "other x;",
        "FOR i FROM -4 TO 4 DO",
        "x:=i*0.7;",
        "SetAO ao1,Round(x);",
        "SetAO ao2,Trunc(x);",
        "ENDFOR",
    )
    own = ("PROC other(INOUT num x)", "x:=x+0.4;", "ENDPROC", "ENDMODULE", "")
    text = module(*rows, data=("VAR num x;",)).replace("ENDMODULE\r\n", "\r\n".join(own))
    assert not [loss for loss in converted(text, "rapid", target).translated.losses if loss.leaves_out]
    found = [e.value for _, e in sorted(run_elsewhere(text, "rapid", target).events.items())]
    xs = [i * 0.7 for i in range(-4, 5)]
    assert found == [
        value for x in xs for value in (math.copysign(math.floor(abs(x) + 0.5), x), math.trunc(x))
    ]


# --- What a TP program says once for several statements ---

PLACES = ((1, 0, 1, 900, 0, 400, 180, 0, 0), (2, 0, 1, 30, 20, 40, 0, 0, 10))
CONDITIONS = (
    "PR[1]=P[2]", "J P[1] 50% FINE", "OFFSET CONDITION PR[1]", "L P[1] 100mm/sec FINE Offset",
    "TOOL_OFFSET CONDITION PR[1]", "L P[1] 100mm/sec FINE Tool_Offset", "UFRAME[1]=PR[1]", "UFRAME_NUM=1",
    "UALM[3]", "WAIT DI[4]=OFF-", "L P[1] 100mm/sec FINE",
)  # fmt: skip


@pytest.mark.parametrize("target", ["krl", "rapid", "urscript"])
def test_conditions_of_offsets_frames_alarms_and_edges_of_tp_are_translated(target):
    text = tp(*CONDITIONS, positions=PLACES)
    losses = converted(text, "tp", target).translated.losses
    assert not [loss for loss in losses if loss.leaves_out and loss.fate is not Fate.EXACT]
    linked, made = link(read(text, "tp")), converted(text, "tp", target)
    runs = runs_of(linked.program, made, target, (ROBOT, None))
    found = receipt_of(linked, made.translated, target, tuple(made.files), runs, (ROBOT, None))
    assert_proven(found)
    assert [e.kind for _, e in sorted(runs.target[0].events.items())] == ["wait", "wait"]


def test_an_offset_without_a_condition_stays_rejected():
    rows = ("J P[1] 50% FINE", "L P[1] 100mm/sec FINE Offset", "OFFSET CONDITION PR[1]")
    losses = converted(tp(*rows, positions=PLACES), "tp", "krl").translated.losses
    assert [loss.line for loss in losses if loss.leaves_out and loss.fate is not Fate.EXACT] == [7]


@pytest.mark.parametrize(
    ("target", "axis", "sets"),
    [
        ("krl", "R1=PV5.A2", "PV5.A4=R1+5"),
        ("rapid", "R1:=PV5.robax.rax_2", "PV5.robax.rax_4:=R1 + 5"),
        ("urscript", "R1 = r2d(PV5[1])", "PV5[3] = d2r(R1 + 5)"),
    ],
)
def test_elements_of_a_register_of_axis_values_are_axes(target, axis, sets):
    """They were components of a pose, which no jointtarget, E6AXIS or list of joints has."""
    text = translated(tp("PR[5]=JPOS", "R[1]=PR[5,2]", "PR[5,4]=R[1]+5", "J PR[5] 10% FINE"), "tp", target)
    assert axis in text
    assert sets in text


@pytest.mark.parametrize(("target", "zero"), [("inform", r"^SET [RB]\d+ 0\r?$"), ("tp", r"R\[.*?\]=0 ")])
def test_registers_begin_with_the_zero_of_the_module_where_nothing_sets_them_first(target, zero):
    """RAPID's numbers and truth values begin with zero; a register holds what the last program left in it."""
    data = ("VAR num n;", "VAR num first;", "VAR bool seen;", "VAR num row{3};", "VAR num many{40};")
    rows = (
        "first:=1;",
        "IF n=0 SetDO do1,1;",
        "IF NOT seen SetDO do2,1;",
        "IF row{2}<1 SetDO do3,1;",
        "many{i}:=many{i}+first;",
        "n:=n+nobody;",
    )
    made = converted(module(*rows, data=data), "rapid", target)
    zeros = re.findall(zero, b"\n".join(made.files.values()).decode(), re.M)
    assert len(zeros) == 3  # n, seen and the element of the row that something reads
    assert any(
        "to zero before each start" in says and "many" in things
        for says, things in made.translated.asks.items()
    )


# --- Loops that a clock ends, where the target has no clocks ---

TIMED = {
    "pdl2": "\n".join(
        (
            *("PROGRAM part", "BEGIN", "$TIMER[1] := 0", "REPEAT", "DELAY 1"),
            *(
                "UNTIL ($DIN[5] = ON) OR ($TIMER[1] > 5000)",
                "IF $TIMER[1] > 5000 THEN",
                "$DOUT[6] := ON",
                "DELAY 2000",
            ),
            *("ELSE", "$DOUT[7] := ON", "ENDIF", "END part", ""),
        )
    ),
    "krl": krl(
        *("$TIMER[1]=0", "$TIMER_STOP[1]=FALSE", "WHILE NOT $IN[5] AND ($TIMER[1]<=5000)", "WAIT SEC 0.005"),
        *(
            "ENDWHILE",
            "IF $TIMER[1]<=5000 THEN",
            "$OUT[7]=TRUE",
            "ELSE",
            "$OUT[6]=TRUE",
            "WAIT SEC 2",
            "ENDIF",
        ),
    ),
}
IN_5 = SignalKey("in", 5)


@pytest.mark.parametrize("target", ["inform", "urscript"])
@pytest.mark.parametrize("vendor", ["pdl2", "krl"])
def test_a_loop_that_a_clock_ends_is_a_wait_with_a_limit(vendor, target):
    text = TIMED[vendor]
    linked, made = link(read(text, vendor)), converted(text, vendor, target)
    runs = runs_of(linked.program, made, target, (ROBOT, None))
    found = receipt_of(linked, made.translated, target, tuple(made.files), runs, (ROBOT, None))
    assert_proven(found)
    assert found.totals["commented"] == 0
    # Head and pause of the loop, REPEAT's end, too, and what asks behind it.
    assert found.totals["approximated"] == {"pdl2": 4, "krl": 3}[vendor]
    # What the manuals say: on is seen at once; off for 5 s, after which the other branch waits 2 s.
    for state, seconds, output in ((1, 0.0, "7"), (0, 7.0, "6")):
        plan = run_converted(made, target, ROBOT, linked.program, {IN_5: (state,)})
        assert plan.durations.sum() == pytest.approx(seconds, abs=0.01)
        switched = [
            signal for event in plan.events.values() if event.kind != "wait" for signal in event.signals
        ]
        assert ["".join(filter(str.isdigit, signal)) for signal in switched] == [output]


@pytest.mark.parametrize(
    ("before", "after"),
    [
        ("IF $TIMER[1]<=5000 THEN", "IF $TIMER[1]<=4000 THEN"),  # another time than that of the loop
        ("WAIT SEC 0.005", "WAIT SEC 0.5"),  # no loop that asks all the time
        ("WAIT SEC 0.005", "$OUT[3]=TRUE"),
        ("$TIMER[1]=0", "$TIMER[1]=-100"),
        ("WAIT SEC 2", "WAIT SEC $TIMER[1]*0.001"),  # the time is of use elsewhere
        ("NOT $IN[5] AND", "NOT $IN[5] OR"),
    ],
)
def test_other_loops_with_clocks_stay_rejected_where_there_are_none(before, after):
    text = TIMED["krl"].replace(before, after)
    assert text != TIMED["krl"]
    losses = converted(text, "krl", "inform").translated.losses
    assert any("clock" in loss.says for loss in losses if loss.leaves_out)


def test_several_values_that_last_are_told_in_the_order_of_their_names():
    """It was that of a set, another one in each process."""
    names = [f"count_{letter}" for letter in "gbfcead"]
    data = ("VAR num total;", *(f"PERS num {name}:=1;" for name in names))
    rows = (f"total:={'+'.join(names)};", *(f"{name}:={name}+1;" for name in names))
    losses = converted(module(*rows, data=data), "rapid", "urscript").translated.losses
    told = [loss.says.split()[0] for loss in losses if "keeps its last value" in loss.says]
    assert told == sorted(names)
