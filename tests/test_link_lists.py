"""Data of other files are found whether or not every routine is, and files that share no names stay apart."""

from __future__ import annotations

import pytest

import olp
from olp.robots.robot import load_robot
from olp.runtime.interpreter import run
from olp.timing.timing import time_plan
from olp.transpile import Context
from olp.transpile.convert import convert, run_converted
from olp.transpile.link import link

ROBOT = load_robot("yaskawa/gp25")


@pytest.mark.parametrize("call", ["", "NOWHERE ( )\n"])
def test_a_global_list_is_found_beside_a_routine_that_is_nowhere(tmp_path, call):
    (tmp_path / "p.src").write_text(f"DEF p ( )\n{call}LIN XPICK\nEND\n")
    (tmp_path / "lists.src").write_text("DEF lists ( )\nEND\n")
    (tmp_path / "lists.dat").write_text(
        "DEFDAT lists PUBLIC\nDECL GLOBAL E6POS XPICK={X 900,Y 0,Z 900,A 0,B 90,C 0}\nENDDAT\n"
    )
    assert [d.name for d in link(olp.read(tmp_path / "p.src")).program.data] == ["XPICK"]


def _cell(tmp_path, *rows, shared):
    """A program whose list lies elsewhere in the robot's tree."""
    (tmp_path / "KRC" / "R1" / "Lists").mkdir(parents=True)
    (tmp_path / "KRC" / "R1" / "Jobs").mkdir()
    head = ["DEFDAT SHARED PUBLIC", *shared, "ENDDAT", ""]
    (tmp_path / "KRC" / "R1" / "Lists" / "shared.dat").write_text("\n".join(head))
    path = tmp_path / "KRC" / "R1" / "Jobs" / "p.src"
    path.write_text("\n".join(["DEF p ( )", *rows, "END", ""]))
    return path


def test_whole_numbers_of_a_list_elsewhere_are_divided_as_whole_numbers(tmp_path):
    shared = ["DECL GLOBAL INT ALL=7", "GLOBAL INT HALF=2", "DECL GLOBAL REAL SHARE=7.0"]
    path = _cell(tmp_path, "WAIT SEC ALL/HALF", "WAIT SEC SHARE/HALF", shared=shared)
    timing = time_plan(run(olp.read(path), "kuka/kr16-2"))
    assert timing.duration_s.tolist() == [3.0, 3.5]
    text = b"".join(convert(link(olp.read(path)).program, "rapid").files.values()).decode()
    assert "WaitTime ALL DIV HALF;" in text
    assert "WaitTime SHARE / HALF;" in text


def test_signals_of_a_list_elsewhere_are_signals(tmp_path):
    shared = [
        "GLOBAL SIGNAL doGrip $OUT[12]",
        "DECL GLOBAL SIGNAL diReady $IN[168]",
        "SIGNAL diPrivate $IN[3]",
        "GLOBAL SIGNAL goKind $OUT[20] TO $OUT[23]",
    ]
    rows = ["doGrip=TRUE", "WAIT FOR diReady", "PULSE(doGrip,TRUE,0.5)", "goKind=5", "diPrivate=TRUE"]
    path = _cell(tmp_path, *rows, shared=shared)
    program = olp.read(path)
    kinds = [type(s).__name__ for s in program.statements()]
    assert kinds == ["SetOutput", "Wait", "PulseOutput", "SetOutput", "Assign"]
    assert [d.name for d in program.data] == ["doGrip", "diReady", "goKind"]
    text = b"".join(convert(link(program).program, "tp").files.values()).decode()
    assert "DO[12]=ON" in text
    assert "WAIT (DI[168])" in text
    assert "DO[12]=PULSE,0.5sec" in text


@pytest.mark.parametrize(
    ("target", "set_", "asked"), [("rapid", "k:=2;", "IF at<>3 THEN"), ("tp", "]=2 ;", "]<>3) THEN")]
)
def test_enumerations_are_whole_numbers_elsewhere(tmp_path, target, set_, asked):
    """KRL counts the constants of an ENUM from 1."""
    shared = ["GLOBAL ENUM station HOME,INFEED,OUTFEED", "DECL GLOBAL station at=#HOME"]
    rows = ["ENUM kind RED,GREEN", "DECL kind k", "k=#GREEN", "IF at<>#OUTFEED THEN", "at=#INFEED", "ENDIF"]
    made = convert(link(olp.read(_cell(tmp_path, *rows, shared=shared))).program, target)
    text = b"".join(made.files.values()).decode()
    assert set_ in text
    assert asked in text
    assert {loss.part for loss in made.translated.losses} <= {"value"}  # what keeps its value from run to run
    assert "kind is a whole number there: RED 1, GREEN 2" in made.translated.notes


def test_what_other_programs_may_change_is_no_constant_without_a_word(tmp_path):
    """A program that chooses by a variable of a shared list is one for the value that the list has today."""
    shared = ["DECL GLOBAL INT SIDE=2", "DECL GLOBAL CONST INT LEFT=1"]
    path = _cell(tmp_path, "IF SIDE==LEFT THEN", "$OUT[1]=TRUE", "ENDIF", shared=shared)
    losses = convert(link(olp.read(path)).program, "tp").translated.losses
    assert [(loss.line, loss.says.split()[0]) for loss in losses] == [(2, "SIDE")]


# --- names that two files have, each for itself ------------------------------------------------------------------

POINT = "[[{x},50,560],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]]"
OWN_NAMES = {
    "rapid": {
        "Main.mod": f"""MODULE A
LOCAL VAR num n:=1;
LOCAL VAR num q:=3;
LOCAL CONST robtarget p1:={POINT.format(x=600)};
PROC main()
MoveL p1,v100,fine,tool0;
Other;
g:=g+1;
SetAO ao1,n;
SetAO ao2,g;
helper;
ENDPROC
LOCAL PROC helper()
SetAO ao1,1;
ENDPROC
ENDMODULE
""",
        "Other.mod": f"""MODULE B
LOCAL VAR num n:=2;
LOCAL VAR num g:=7;
LOCAL CONST robtarget p1:={POINT.format(x=700)};
PROC Other()
n:=n+10;
g:=g+10;
q:=q+1;
MoveL p1,v100,fine,tool0;
SetAO ao1,n;
SetAO ao2,g;
SetAO ao2,q;
helper;
ENDPROC
LOCAL PROC helper()
SetAO ao1,2;
ENDPROC
ENDMODULE
""",
        "Shared.mod": "MODULE C\nVAR num g:=100;\nVAR num q:=50;\nENDMODULE\n",
    },
    "krl": {
        "main.src": """DEF main ( )
LIN XP1
OTHER ()
$ANOUT[1]=N
HELPER ()
END
DEF HELPER ( )
$ANOUT[3]=1
END
""",
        "main.dat": "DEFDAT main\nDECL REAL N=1\nDECL E6POS XP1={X 600,Y 50,Z 560,A 0,B 90,C 0}\nENDDAT\n",
        "other.src": """DEF OTHER ( )
N=N+10
LIN XP1
$ANOUT[1]=N
HELPER ()
END
DEF HELPER ( )
$ANOUT[3]=2
END
""",
        "other.dat": "DEFDAT OTHER\nDECL REAL N=2\nDECL E6POS XP1={X 700,Y 50,Z 560,A 0,B 90,C 0}\nENDDAT\n",
    },
}


def outputs(plan):
    return [event.value for _, event in sorted(plan.events.items()) if event.kind == "set"]


def ends(plan):
    return [round(float(x), 3) for x in plan.positions.position[plan.moves.target][:, 0]]


@pytest.mark.parametrize(
    ("vendor", "target", "values"),
    [("rapid", target, [12, 17, 51, 2, 1, 101, 1]) for target in ("krl", "tp", "urscript")]
    + [("krl", target, [12, 2, 1, 1]) for target in ("rapid", "tp", "urscript")],
)
def test_what_two_files_call_the_same_each_for_itself_stays_apart(tmp_path, vendor, target, values):
    for name, text in OWN_NAMES[vendor].items():
        (tmp_path / name).write_text(text)
    program = olp.read(next(iter(sorted(tmp_path.glob("[Mm]ain.[ms]*")))))
    plan = run(program, ROBOT)
    assert outputs(plan) == values
    assert ends(plan) == [0.6, 0.7]
    there = run_converted(convert(link(program, target).program, target, Context(ROBOT)), target, ROBOT)
    assert outputs(there) == values
    assert ends(there) == [0.6, 0.7]


def test_data_of_one_file_may_name_data_of_another_that_is_read_later(tmp_path):
    a = "MODULE A\nPROC main()\nMoveL far{2},v100,fine,tool0;\nENDPROC\nENDMODULE\n"
    (tmp_path / "A.mod").write_text(a)
    (tmp_path / "B.mod").write_text("MODULE B\nCONST robtarget far{2}:=[q1,q2];\nENDMODULE\n")
    rows = [f"CONST robtarget q{n}:={POINT.format(x=600 + n)};" for n in (1, 2)]
    (tmp_path / "C.mod").write_text("\n".join(["MODULE C", *rows, "ENDMODULE", ""]))
    assert ends(run(olp.read(tmp_path / "A.mod"), ROBOT)) == [0.602]


def test_variables_of_the_controllers_own_list_are_one_for_all_programs(tmp_path):
    (tmp_path / "$config.dat").write_text("DEFDAT $CONFIG\nDECL REAL COUNT=1\nENDDAT\n")
    (tmp_path / "a.src").write_text("DEF a ( )\nCOUNT=5\nb ()\n$ANOUT[1]=COUNT\nEND\n")
    (tmp_path / "b.src").write_text("DEF b ( )\nCOUNT=COUNT+1\nEND\n")
    assert outputs(run(olp.read(tmp_path / "a.src"), ROBOT)) == [6]


@pytest.mark.parametrize("own", ["robtarget corner", ""])
def test_data_of_another_module_are_found_beside_a_parameter_of_the_same_name(tmp_path, own):
    """A routine's own name says nothing of the same name in the other routines."""
    rows = ["PROC main()", "MoveL corner,v100,fine,tool0;", "lift;", "ENDPROC", f"PROC lift({own})"]
    rows += ["" if own else "VAR robtarget corner;", "MoveL corner,v100,fine,tool0;", "ENDPROC"]
    (tmp_path / "A.mod").write_text("\n".join(["MODULE A", *rows, "ENDMODULE", ""]))
    place = (
        "CONST robtarget corner:=[[900,0,900],[0.707107,0,0.707107,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];"
    )
    (tmp_path / "B.mod").write_text(f"MODULE B\n{place}\nENDMODULE\n")
    assert [d.name for d in link(olp.read(tmp_path / "A.mod")).program.data] == ["corner"]
