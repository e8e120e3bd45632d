"""What the target cannot say becomes a comment by the user's choice: values, data, routines, and whoever needs them."""

import re

import pytest
from tp_listings import HEAD, listing
from tp_listings import read as read_tp
from translated_texts import VENDORS, krl
from translated_texts import converted as converted_text
from translated_texts import read as read_any

import olp
from olp.__main__ import main
from olp.core.diagnostic import OlpError
from olp.robots.robot import load_robot
from olp.runtime.interpreter import run
from olp.transpile import Context
from olp.transpile.context import Fate
from olp.transpile.convert import convert, run_converted
from olp.transpile.link import link

ROBOT = load_robot("yaskawa/gp25")
POSE = "[[900,0,500],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]]"
MODULE = f"""MODULE m
  CONST robtarget pHome := {POSE};
  VAR loadsession link;
  VAR num count := 3;
  PROC main()
    talk link, count;
    MoveL pHome, v100, fine, tool0;
    count := count + 1;
  ENDPROC
  PROC talk(VAR loadsession s, num n)
    WaitLoad s;
    count := n;
  ENDPROC
ENDMODULE
"""
SCRIPT = """def f():
  steady = is_steady()
  height = tool_contact()
  movel(p[0.9, 0.0, 0.5, 0, 3.14, 0], v=0.1)
  if height > 2:
    sleep(1)
  end
end
"""


def converted(text, name, target, folder):
    path = folder / name
    path.write_text(text)
    program = link(olp.read(path)).program
    made = convert(program, target, Context(robot=ROBOT, on_loss="comment"))
    plan = run_converted(made, target, ROBOT, program)  # it reads back, or this raises
    return made.translated.losses, b"".join(made.files.values()).decode("latin-1"), plan


@pytest.mark.parametrize("target", [v for v in VENDORS if v != "rapid"])
def test_a_routine_whose_head_cannot_be_said_goes_with_its_calls(tmp_path, target):
    losses, text, plan = converted(MODULE, "m.mod", target, tmp_path)
    gone = {loss.line for loss in losses if loss.leaves_out}
    assert {6, 11} <= gone
    assert gone.isdisjoint({7, 8})
    assert text.count("not translated:") >= 2
    assert len(plan.moves) == 1


@pytest.mark.parametrize("target", [v for v in VENDORS if v != "urscript"])
def test_a_value_that_cannot_be_said_is_told_and_its_variable_stays(tmp_path, target):
    losses, text, plan = converted(SCRIPT, "f.script", target, tmp_path)
    told = {loss.line for loss in losses if loss.fate is not Fate.EXACT}
    assert {2, 3} <= told
    assert len(plan.moves) == 1
    assert "is_steady(" not in text.replace("not translated: steady = is_steady(", "")


def _with_many(data, rows):
    routines = [
        row
        for name in ("one", "two", "three")
        for row in (f"PROC {name}(num given)", *rows, "WaitTime a0;", "ENDPROC")
    ]
    calls = [f"{name} 3;" for name in ("one", "two", "three")]
    return "\n".join(("MODULE m", *data, "PROC main()", *calls, "ENDPROC", *routines, "ENDMODULE", ""))


def test_variables_beyond_those_of_the_target_go_and_nothing_else(tmp_path):
    """INFORM has 2000 reals at most. One too many took its namesakes in other routines along, or everything."""
    held = [f"VAR num b{n}:=0.5;" for n in range(2010)]
    used = [f"b{n}:=b{n}+given/3;" for n in range(2010)]
    text = _with_many(held, ("VAR num a0:=1;", *used))
    losses, written, _ = converted(text, "m.mod", "inform", tmp_path)
    lines = text.splitlines()
    gone = {lines[loss.line - 1] for loss in losses if loss.leaves_out}
    assert (
        len(gone & {*held}) == len(gone & {*used}) == 2010 + 3 - 2000
    )  # with the three that are handed over
    assert not [row for row in gone if "a0" in row]
    assert written.count("TIMER ") == 3


def test_where_variables_are_too_many_jobs_have_theirs_for_themselves(tmp_path):
    """Those that have a value before they are read: LR of INFORM, which ///LVARS counts."""
    held = [f"VAR num a{n}:={n}.5;" for n in range(45)]
    kept = (
        "VAR num sum;",
        "sum:=sum+given;",
        "IF given>2 THEN",
        "count:=given;",
        "ENDIF",
    )  # sum begins with 0
    rows = (*held, *kept, *(f"a{n}:=a{n}+count/3;" for n in range(45)))
    path = tmp_path / "m.mod"
    path.write_text(_with_many(("VAR num count:=0;",), rows))
    assert main(["convert", str(path), "--to", "inform", "-o", str(tmp_path / "jobs")]) == 0
    job = (tmp_path / "jobs" / "two.JBI").read_text()
    assert "///LVARS 0,0,0,46,0,0,0,0" in job
    assert re.search(r"^SET LR044 44\.5$", job, re.MULTILINE)
    assert re.search(r"^SET LR001  EXPRESS LR001 \+ R\d+ / 3", job, re.MULTILINE)


def test_without_a_comment_everything_is_refused_at_once(tmp_path):
    path = tmp_path / "m.mod"
    path.write_text(MODULE)
    with pytest.raises(OlpError) as caught:
        convert(olp.read(path), "krl", Context(robot=ROBOT))
    assert {d.line for d in caught.value.diagnostics} >= {3, 10}


@pytest.mark.parametrize("target", [v for v in VENDORS if v != "tp"])
def test_a_speed_of_the_weld_schedule_is_a_variable_that_has_to_be_set(tmp_path, target):
    path = tmp_path / "WELD.LS"
    path.write_text(listing("L P[1] 100mm/sec FINE", "L P[2] WELD_SPEED CNT100", "L P[3] WELD_SPEED FINE"))
    losses, text, _ = converted(path.read_text(), "WELD.LS", target, tmp_path)
    told = [loss for loss in losses if "weld_speed has to be set" in loss.says]
    assert len(told) == 2
    assert {loss.fate for loss in told} == {Fate.APPROXIMATED}
    assert "weld_speed" in text


def test_lines_of_data_in_a_linked_file_are_those_of_the_joined_text(tmp_path):
    (tmp_path / "m.mod").write_text("MODULE m\n  PROC main()\n    Other;\n  ENDPROC\nENDMODULE\n")
    (tmp_path / "Other.mod").write_text(
        "MODULE Other\n  VAR num depth := 4;\n  PROC Other()\n    depth := depth + 1;\n  ENDPROC\nENDMODULE\n"
    )
    program = link(olp.read(tmp_path / "m.mod")).program
    declared = next(d for d in program.data if d.name == "depth")
    assert "VAR num depth" in program.source.line(declared.line)


def test_a_call_goes_with_the_routine_that_cannot_take_what_it_is_handed(tmp_path):
    text = MODULE.replace("talk link, count;", "talk 5;").replace(
        "talk(VAR loadsession s, num n)", "talk(num n \\VAR loadsession s)"
    )
    losses, _, _ = converted(text, "m.mod", "krl", tmp_path)
    assert {loss.line for loss in losses if loss.leaves_out} == {6, 11, 12}


GROUPS = """P[{0}]{{
   GP1:
\tUF : 1, UT : 2,\t\tCONFIG : 'N U T, 0, 0, 0',
\tX = {1}  mm,\tY =    12.500  mm,\tZ =   -50.384  mm,
\tW =   178.500 deg,\tP =     3.250 deg,\tR =   -21.500 deg
   GP2:
\tUF : 1, UT : 2,
\tJ1 = {2} deg,\tJ2 = 0.000 deg
}};
"""


@pytest.mark.parametrize(("angle", "fate"), [(0.0, "approximated"), (30.0, "commented")])
def test_a_move_together_with_a_table_is_a_plain_one_while_every_table_stands(angle, fate):
    positions = "".join(GROUPS.format(n, 800.0 + 50.0 * n, angle) for n in (1, 2))
    text = listing(
        "L P[1] 200mm/sec FINE",
        "L P[2] 200mm/sec CNT100 COORD PTH",
        positions=positions,
        head=HEAD.replace("1,*,*,*,*", "1,1,*,*,*"),
    )
    made = convert(read_tp(text), "rapid", Context(load_robot("fanuc/m-20ia"), on_loss="comment"))
    fates = {loss.fate.value for loss in made.translated.losses if "COORD" in loss.says}
    assert fates == {fate}


BROKEN = f"""MODULE m
  CONST robtarget pHome := {POSE};
  VAR num count := 3;
  PROC main()
    MoveL pHome, v100, fine, tool0;
    grip 2;
    IF ready(2) > 1 THEN
      SetDO do4, 1;
    ENDIF
    SetDO do5, 1;
  ENDPROC
  PROC grip(num n)
    ! closes the jaws
    IF n > 1 THEN
      SetDO do1, 1; ! on
      WaitTime 0.5);
    ENDIF
    count := ;
  ENDPROC
  FUNC num ready(num n)
    RETURN n * ;
  ENDFUNC
ENDMODULE
"""


@pytest.mark.parametrize("target", [v for v in VENDORS if v != "rapid"])
def test_a_routine_with_an_error_is_its_text_as_comments_and_the_rest_is_converted(tmp_path, target):
    losses, text, plan = converted(BROKEN, "m.mod", target, tmp_path)
    gone = {loss.line for loss in losses if loss.leaves_out}
    # The function has no value, so the block that asks for it goes, too.
    assert gone == {7, 8, 9, 14, 15, 16, 17, 18, 21}
    (call,) = [loss for loss in losses if loss.line == 6]
    assert call.fate is Fate.APPROXIMATED
    assert call.says == "grip is not converted: unexpected ')'"
    assert "closes the jaws" in text
    assert len(plan.moves) == 1


def test_a_translation_without_a_routine_is_no_success_and_tells_its_errors(tmp_path, capsys):
    (tmp_path / "m.mod").write_text(BROKEN)
    asked = ["convert", str(tmp_path / "m.mod"), "--to", "krl", "-o", str(tmp_path / "out")]
    robot = ["--robot", "yaskawa/gp25"]
    assert main([*asked, *robot]) == 2
    assert "error[P451]" in capsys.readouterr().err
    assert main([*asked, *robot, "--on-loss", "comment"]) == 1
    told = capsys.readouterr().err
    assert all(f"m.mod:{line}:" in told for line in (16, 18, 21))
    assert "warning[X015]: ready is not converted: unexpected ';'" in told


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("SetDO do5, 1;", "SetDO do5, 1);"),  # in the main routine
        ("PROC grip(num n)", "PROC grip(num n,)"),  # in the head of another
        ("VAR num count := 3;", "VAR num count := ;"),  # in no routine
    ],
)
def test_an_error_elsewhere_than_in_a_called_routine_stops_a_translation(tmp_path, old, new):
    with pytest.raises(OlpError) as refused:
        converted(BROKEN.replace(old, new), "m.mod", "krl", tmp_path)
    assert {d.code for d in refused.value.diagnostics} == {"P451"}


CALLER = "DEF caller()\nPTP {A1 10,A2 -80,A3 90,A4 0,A5 20,A6 0}\ncallee()\nEND\n"
CALLEE = "DEF callee()\n$OUT[1]=TRUE\na=0,b=0\nEND\n"


def test_an_error_in_a_called_file_is_one_of_the_translation(tmp_path):
    (tmp_path / "callee.src").write_text(CALLEE)
    (tmp_path / "caller.src").write_text(CALLER)
    linked = link(olp.read(tmp_path / "caller.src"), "rapid")
    with pytest.raises(OlpError) as refused:
        convert(linked.program, "rapid", Context(robot=ROBOT))
    (found,) = map(linked.located, refused.value.diagnostics)
    assert (found.code, found.file, found.line) == ("P404", str(tmp_path / "callee.src"), 3)
    made = convert(linked.program, "rapid", Context(robot=ROBOT, on_loss="comment"))
    lost = [linked.place(loss.line) for loss in made.translated.losses if loss.leaves_out]
    assert lost == [(str(tmp_path / "callee.src"), 2), (str(tmp_path / "callee.src"), 3)]


def test_of_a_listing_with_an_error_among_its_positions_the_instructions_are_comments(tmp_path):
    called = listing("J P[1] 100% FINE", "DO[1]=ON", head=HEAD.replace("PART", "CALLED"))
    (tmp_path / "called.ls").write_text(called.replace("12.500", "12.5o0", 1))
    (tmp_path / "part.ls").write_text(listing("J P[1] 100% FINE", "CALL CALLED"))
    linked = link(olp.read(tmp_path / "part.ls"), "krl")
    made = convert(linked.program, "krl", Context(robot=ROBOT, on_loss="comment"))
    gone = [linked.place(loss.line)[1] for loss in made.translated.losses if loss.leaves_out]
    lines = [called.splitlines()[n - 1].strip() for n in gone]
    assert lines[:2] == ["1:  J P[1] 100% FINE ;", "2:  DO[1]=ON ;"]
    assert "/POS" not in lines


def test_an_error_in_one_program_of_a_cell_leaves_the_others(tmp_path, capsys):
    for name, wrong in (("afirst", "DO[2]=ONN"), ("bnext", "DO[3]=ON"), ("clast", "DO[4]=ON")):
        text = listing("R[7]=R[7]+1", "J P[1] 100% FINE", wrong, head=HEAD.replace("PART", name.upper()))
        (tmp_path / f"{name}.ls").write_text(text)
    asked = ["convert", str(tmp_path), "--to", "krl", "-o", str(tmp_path / "out"), "--robot", "fanuc/m-20ia"]
    assert main(asked) == 2
    assert main([*asked, "--on-loss", "comment"]) == 1
    told = capsys.readouterr()
    assert "from AFIRST: 0 steps" in told.out
    assert "from CLAST: 2 steps, no differences" in told.out
    text = "".join(path.read_text("latin-1") for path in (tmp_path / "out").glob("*.src"))
    assert ";not translated: 3:  DO[2]=ONN" in text
    assert {"$OUT[3]=TRUE", "$OUT[4]=TRUE"} <= set(text.split())


@pytest.mark.parametrize("target", ["inform", "rapid", "tp", "urscript"])
def test_what_stands_before_the_first_case_is_a_comment_that_is_told(target):
    """No value leads there, and RAPID's compiler takes no statement there; it was written, or vanished."""
    rows = (
        "DECL INT n",
        "n=2",
        "SWITCH n",
        "; about it",
        "$OUT[3]=TRUE",
        "CASE 2",
        "$OUT[4]=TRUE",
        "ENDSWITCH",
    )
    made = converted_text(krl(*rows), "krl", target)
    told = [loss for loss in made.translated.losses if "before the first CASE" in loss.says]
    assert [loss.fate for loss in told] == [Fate.COMMENTED]
    text = b"\n".join(made.files.values()).decode()
    assert "about it" in text
    assert re.search(r"^\W*(?:\d+:\s*)?(?:!|'|#)\s*not translated: \$OUT\[3\]=TRUE", text, re.MULTILINE)


INSTALLED = """def unnamed():
  def ask(text, where="1"):
    zero_ftsensor()
    return is_steady()
  end
  def state():
    return ask("STATE")
  end
  def twice(n):
    return 2 * n
  end
  movej([0, -1.57, 1.57, 0, 1.57, 0], a=1.4, v=1.05)
  sleep(twice(1))
end
"""


@pytest.mark.parametrize("target", [v for v in VENDORS if v != "urscript"])
@pytest.mark.parametrize("on_loss", ["comment", "error"])
def test_functions_that_nothing_can_call_need_not_be_said(target, on_loss):
    """A UR program holds the functions of all installed tools; each line of theirs was refused."""
    program = read_any(INSTALLED, "urscript")
    made = convert(program, target, Context(robot=ROBOT, on_loss=on_loss))
    told = [loss for loss in made.translated.losses if "nothing calls" in loss.says]
    assert {(loss.line, loss.fate) for loss in told} == {(n, Fate.EXACT) for n in (3, 4, 7)}
    assert not [loss for loss in made.translated.losses if loss.fate in (Fate.COMMENTED, Fate.REFUSED)]
    text = b"\n".join(made.files.values()).decode()
    assert "steady" not in text
    assert len(run_converted(made, target, ROBOT, program).kind) == len(run(program, ROBOT).kind)


@pytest.mark.parametrize(
    "line",
    ['state()  # "STATE"', "interpreter_mode()", "sleep(twice(1))  # state"],
    ids=["called", "open to others", "named in a comment"],
)
def test_functions_that_something_may_call_are_refused(line):
    program = read_any(INSTALLED.replace("sleep(twice(1))", line), "urscript")
    with pytest.raises(OlpError) as refused:
        convert(program, "krl", Context(robot=ROBOT))
    assert {3, 4} <= {found.line for found in refused.value.diagnostics}


def test_functions_beside_the_main_one_are_for_other_programs():
    """A file of functions, which a program takes in, is not closed."""
    inner = "\n".join(row[2:] for row in INSTALLED.splitlines()[1:5])
    program = read_any(f"def go():\n  sleep(1)\nend\n{inner}\n", "urscript")
    with pytest.raises(OlpError):
        convert(program, "krl", Context(robot=ROBOT))
