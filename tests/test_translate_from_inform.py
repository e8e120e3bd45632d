"""What translations from and into INFORM, and from AS, VAL3 and PDL2, once did otherwise than their sources."""

from __future__ import annotations

import re

import pytest
from scipy.spatial.transform import Rotation
from translated_texts import ROBOT, converted, inform, module, read, script, translated

from olp.core.source import decode
from olp.fluent import read as read_path
from olp.fluent import read_source
from olp.ir.expressions import FrameRef, Logic, Number, Signal, SignalState, Text, Unary
from olp.ir.program import Move, Path, Process, SpeedUnit
from olp.robots.robot import load_robot
from olp.runtime.interpreter import run
from olp.runtime.plan import StepKind
from olp.transpile import Context
from olp.transpile.compare import WRITTEN, compare_plans
from olp.transpile.context import Fate
from olp.transpile.convert import convert, run_converted, runs_of
from olp.transpile.link import link
from olp.transpile.receipt import receipt_of

POINTS = (
    "///TOOL 0",
    "///POSTYPE ROBOT",
    "///RECTAN",
    "///RCONF 1,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0",
    "P001=900.000,0.000,400.000,180.0000,0.0000,0.0000",
    "P002=900.000,100.000,400.000,180.0000,0.0000,0.0000",
)


def objections(text, vendor, target):
    """What stands against the proof, by kind; the translation is as `olp convert` makes it."""
    program = read(text, vendor)
    made = convert(program, target, Context(robot=ROBOT, on_loss="comment", forms=True))
    runs = runs_of(program, made, target, (ROBOT, None))
    receipt = receipt_of(link(program), made.translated, target, tuple(made.files), runs, (ROBOT, None))
    return {(one.kind, one.says) for one in receipt.verdict.objections}


def test_the_stop_handlers_of_inline_forms_take_no_place_in_the_pairs_of_statements():
    rows = ("MOVJ C001 VJ=20.00", "WAIT B001=1", "MOVJ C002 VJ=40.00", "DOUT OT#(1) ON")
    taught = [row.replace("P00", "C00") for row in POINTS]
    text = inform(*rows, points=taught)
    assert not objections(text, "inform", "krl")


@pytest.mark.parametrize(
    ("target", "taken"),
    [("tp", ("R[1:n]=AR[1]", "=AR[2]")), ("inform", ("GETARG R000 IARG#(1)", "GETARG S000 IARG#(2)"))],
)
def test_what_the_first_routine_takes_comes_from_its_caller(target, taken):
    text = module().replace("PROC main()", "PROC part(num n,string t)\r\nIF n=2 SetDO do1,1;\r\nTPWrite t;")
    made = translated(text, "rapid", target)
    assert all(one in made for one in taken), made
    assert not objections(text, "rapid", target)


def test_what_the_caller_does_not_get_back_is_told():
    losses = converted("DEF PART(N:OUT)\r\nINT N\r\nN=N+1\r\nEND\r\n", "krl", "tp").translated.losses
    assert [one.says for one in losses] == ["the argument N of PART: its caller does not get it back"]
    text = module().replace("PROC main()", "PROC part(robtarget p)\r\nMoveJ p,v100,fine,tool0;")
    says = [one.says for one in converted(text, "rapid", "tp").translated.losses]
    assert "the argument p of part: its caller has to set the variable" in says


# --- AS -----------------------------------------------------------------------------------------------------

AS_DATA = (
    ".JOINTS\n#p1 0 -20 -100 0 -60 0\n.END\n.TRANS\np2 0 600 300 90 180 0\np3 100 600 300 90 180 0\n.END\n"
)


def as_program(*rows, data=AS_DATA):
    return "\n".join([".PROGRAM main()", *rows, ".END", data])


def as_lines(*rows, target="krl", data=AS_DATA):
    """The lines of a translation, and what it loses."""
    program = read_source(decode(as_program(*rows, data=data).encode(), "main.as"))
    made = convert(program, target, Context(robot=load_robot("kawasaki/rs020n"), on_loss="comment"))
    text = b"\n".join(made.files.values()).decode("cp1252")
    return [line.strip() for line in text.splitlines()], made.translated.losses


def test_the_number_in_a_variable_says_whether_a_signal_is_an_input():
    lines, losses = as_lines(
        "part = 1005",
        "SWAIT part",
        "IF SIG(door[1]) THEN",
        "SIGNAL 3",
        "END",
        data=".REALS\ndoor[0] 1007\ndoor[1] 1008\n.END\n",
    )
    assert "WAIT FOR $IN[5]" in lines
    assert "$OUT[part]" not in " ".join(lines)
    assert any(line.startswith("IF $IN[door") for line in lines)
    assert not losses


def test_a_signal_of_which_nobody_knows_what_it_is_is_left_out():
    lines, losses = as_lines("CALL ask(which)", "IF SIG(which) THEN", "SIGNAL 3", "END")
    assert not any(
        "$OUT[which]" in line or "$IN[which]" in line for line in lines if not line.startswith(";")
    )
    assert any(one.says.startswith("SIG is in no file here") for one in losses)


def test_bits_are_a_group_of_signals():
    lines, losses = as_lines("x = BITS(1001,8)", "BITS 17,4 = x")
    assert "SIGNAL BITS_IN_1_8 $IN[1] TO $IN[8]" in lines
    assert "SIGNAL BITS_OUT_17_20 $OUT[17] TO $OUT[20]" in lines
    assert "x_1=BITS_IN_1_8" in lines
    assert "BITS_OUT_17_20=x_1" in lines
    assert not losses


@pytest.mark.parametrize("word", ["HALT", "STOP"])
def test_halt_and_stop_end_the_program(word):
    lines, _ = as_lines("SIGNAL 1", "IF SIG(1002) THEN", word, "END", "SIGNAL 2")
    assert "RETURN" in lines
    assert "HALT" not in lines


def test_continuous_path_comes_back_with_the_accuracy_that_holds():
    rows = (
        "SPEED 100 MM/S ALWAYS",
        "ACCURACY 20 ALWAYS",
        "JMOVE #p1",
        "CP OFF",
        "ACCURACY 30 ALWAYS",
        "LMOVE p2",
        "CP ON",
        "LMOVE p3",
        "LMOVE p2",
    )
    lines, _ = as_lines(*rows, target="rapid")
    moves = [line for line in lines if line.startswith("Move")]
    assert [line.split(",")[2] for line in moves] == ["z20", "fine", "z30", "z30"]


def test_a_deceleration_holds_for_all_moves_that_follow():
    program = read_source(decode(as_program("DECEL 50 ALWAYS", "LMOVE p2", "LMOVE p3").encode(), "main.as"))
    moves = [s for s in program.routines[0].body if isinstance(s, Move)]
    assert all(move.deceleration is not None for move in moves)


def test_a_loop_that_counts_fractions_is_no_loop_of_integers():
    lines, losses = as_lines("FOR i = 0 TO 1 STEP 0.25", "TWAIT i", "END")
    assert "DECL REAL i=0" in lines
    assert "WHILE i<=1" in lines
    assert not losses
    lines, losses = as_lines("FOR i = 0 TO 3", "x[i] = i/2", "END")
    assert "DECL INT i=0" in lines
    assert "DECL REAL x_1[4]" in lines  # the end of the loop tells its size
    assert not losses
    lines, losses = as_lines("FOR i = 0 TO n", "x[i] = i/2", "END")
    assert "DECL INT i=0" in lines
    assert ["are taken" in loss.says for loss in losses].count(True) == 1  # of x nothing tells the size


def test_numbers_of_signals_are_integers_where_the_target_counts_with_them():
    text = script("i = 1", "while i < 4:", "  set_standard_digital_out(i, True)", "  i = i + 1", "end")
    assert "DECL INT i" in translated(text, "urscript", "krl")


def test_an_array_is_as_large_as_the_indices_that_are_written():
    lines, _ = as_lines("x[0] = 3", "x[4] = 5", "y = x[4]")
    assert "DECL REAL x_1[5]" in lines or "DECL INT x_1[5]" in lines


@pytest.mark.parametrize(
    ("vendor", "text"),
    [
        ("krl", "DEF PART ( )\nINT i\nFOR i=1 TO 3\nWAIT SEC 1\nENDFOR\nEND\n"),
        ("rapid", module("FOR i FROM 1 TO 3 DO", "WaitTime 1;", "ENDFOR")),
    ],
)
def test_next_names_what_the_loop_counts(vendor, text):
    assert "\r\nNEXT D000\r\n" in translated(text, vendor, "inform")


@pytest.mark.parametrize("target", ["krl", "inform"])
def test_a_loop_that_counts_fractions_is_a_while(target):
    text = module("FOR i FROM 0 TO 1 STEP 0.25 DO", "WaitTime i;", "ENDFOR")
    made = translated(text, "rapid", target)
    assert "WHILE" in made
    assert "FOR i" not in made
    assert "FOR R" not in made
    assert not objections(text, "rapid", target)


# --- steps that Kawasaki's pendant teaches -----------------------------------------------------------------------

TABLES = (
    ".AUXDATA\nACCUR 2.0 10.0 50.0 100.0 1.0\nSPEED 5.0 20.0 30.0 40.0 50.0 60.0 70.0 80.0 90.0 100.0\n"
    "TIMER 0.0 0.1 0.2 0.3 0.4 0.7 0.6 0.7 0.8 0.9\n.END\n"
)
POSTURE = "#[0,-20,-100,0,-60,0]"


def steps(*rows, tables=TABLES):
    """The statements of a program of taught steps, and what its reader tells."""
    text = tables + as_program(*rows, data="")
    program = read_source(decode(text.encode(), "main.as"))
    assert not [d for d in program.diagnostics if d.is_error]
    return program.routines[0].body[1:], [d.message for d in program.diagnostics]


def test_a_taught_step_has_the_levels_of_its_controller():
    body, told = steps(
        f"JOINT SPEED0 ACCU1 TIMER0 TOOL2 WORK0 CLAMP OX= WX= {POSTURE} ;",
        f"LINEAR 250. ACCU3 TIMER5 TOOL1 WORK0 CLAMP OX=3,-4 WX=1007,-2 {POSTURE} ;",
    )
    joint, line, on, off, pause, wait = body
    assert (joint.path, line.path) == (Path.JOINT, Path.LINEAR)
    assert (joint.speed.unit, joint.speed.value.literal) == (SpeedUnit.FRACTION, 0.05)
    assert (line.speed.unit, line.speed.value.literal) == (SpeedUnit.TRAVEL, 0.25)
    assert (joint.blend.value.literal, line.blend.value.literal) == (0.002, 0.05)
    assert (joint.tool, line.tool) == (FrameRef("tool", Number(2)), FrameRef("tool", Number(1)))
    assert (on.signal.index, on.value, off.signal.index, off.value) == (
        Number(3),
        SignalState(True),
        Number(4),
        SignalState(False),
    )
    assert pause.duration.literal == 0.7
    assert wait.condition == Logic(Signal("in", Number(7)), (("and", Unary("not", Signal("in", Number(2)))),))
    assert not joint.other
    assert not line.other
    assert any("at the end of a step" in one for one in told)
    assert not any("as delivered" in one for one in told)


def test_without_tables_the_levels_are_those_of_a_controller_as_delivered():
    (move,), told = steps(
        f"JOINT SPEED9 ACCU4 TIMER0 TOOL1 WORK0 CLAMP1 (OFF,0,0,O) 2 (OFF,0,0,O) OX= WX= {POSTURE} ;",
        tables="",
    )
    assert (move.speed.value.literal, move.blend.value.literal) == (1.0, 0.1)
    assert any("as delivered" in one for one in told)


def test_clamps_are_instructions_of_their_own_where_they_change():
    off, on = "CLAMP1 (OFF,0,0,O)", "CLAMP1 (ON,0,0,C)"
    rows = [
        f"LINEAR SPEED4 ACCU1 TIMER0 TOOL0 WORK0 {clamp} OX= WX= {POSTURE} ;" for clamp in (off, on, on, off)
    ]
    body, _ = steps(*rows)
    assert [s.arguments for s in body if isinstance(s, Process)] == [
        (("1", Text("ON")),),
        (("1", Text("OFF")),),
    ]


def test_arcs_of_two_steps_and_work_offsets():
    tail = f"SPEED4 ACCU1 TIMER0 TOOL0 WORK0 CLAMP OX= WX= {POSTURE} ;"
    (arc,), _ = steps(f"CIR1 {tail}", f"CIR2 {tail}")
    assert arc.path is Path.CIRCULAR
    assert arc.via is not None
    (move,), _ = steps(f"JOINT SPEED4 ACCU1 TIMER0 TOOL0 WORK3 CLAMP OX= WX= {POSTURE} ;")
    assert move.other == (("WORK3", Text("")),)


def test_a_level_that_no_controller_has_is_an_error():
    text = as_program(f"JOINT SPEED4 ACCU7 TIMER0 TOOL0 WORK0 CLAMP OX= WX= {POSTURE} ;", data="")
    told = [d for d in read_source(decode(text.encode(), "main.as")).diagnostics if d.is_error]
    assert [(d.code, d.message, d.help) for d in told] == [("P580", "there is no ACCU7", "ACCU1 to ACCU4")]


@pytest.mark.parametrize("target", ["krl", "rapid"])
def test_lines_to_joint_values_lead_to_the_pose_of_the_tool(target):
    text = script(
        "set_tcp(p[0,0,0.1,0,0,0])",
        "movej([0,-1.57,1.57,-1.57,-1.57,0])",
        "movel([0.2,-1.5,1.5,-1.57,-1.57,0],v=0.1)",
    )
    program = read(text, "urscript")
    robot = load_robot("universal-robots/ur10e")
    made = convert(program, target, Context(robot=robot, on_loss="comment"))
    assert not [one for one in made.translated.losses if one.leaves_out]
    plans = program.plan(robot=robot), run_converted(made, target, robot, program)
    assert compare_plans(*plans, tolerances=WRITTEN).is_equal


def test_a_line_to_joint_values_with_a_tool_that_nobody_knows_is_told():
    taught = (
        "///TOOL 1",
        "///POSTYPE PULSE",
        "///PULSE",
        "C000=0,0,0,0,-40000,0",
        "C001=10000,5000,1000,0,-42000,0",
    )
    text = inform("MOVJ C000 VJ=20.00 PL=0", "MOVL C001 V=100.0 PL=0", points=taught)
    told = converted(text, "inform", "krl").translated
    assert any("computed as if its tool were zeros" in one.says for one in told.losses)
    assert {kind for kind, _ in objections(text, "inform", "krl")} == {"named"}


def test_what_stands_beside_a_word_that_is_left_out_is_in_both_runs():
    on = f"JOINT SPEED4 ACCU1 TIMER0 TOOL0 WORK0 CLAMP1 (ON,0,0,C) OX=3 WX= {POSTURE} ;"
    text = as_program(on, data="")
    program = link(read_source(decode(text.encode(), "main.as"))).program
    robot = load_robot("kawasaki/rs020n")
    made = convert(program, "rapid", Context(robot=robot, on_loss="comment"))
    runs = runs_of(program, made, "rapid", (robot, None))
    receipt = receipt_of(link(program), made.translated, "rapid", tuple(made.files), runs, (robot, None))
    assert {one.kind for one in receipt.verdict.objections} == {"left-out"}
    assert receipt.comparison.steps == 2


# --- what AS programs take, and names that nothing declares -----------------------------------------------------


GO = ".PROGRAM go(.&p, .spd, .#j)\n  SPEED .spd MM/S ALWAYS\n  JMOVE .#j\n  LMOVE .p\n.END\n"


@pytest.mark.parametrize(
    ("target", "head"),
    [
        ("rapid", "PROC go(robtarget n__p,num n__spd,jointtarget n___j)"),
        ("krl", "DEF go (_p :IN,_spd :IN,__j :IN)"),
    ],
)
def test_signs_tell_the_types_of_parameters_which_are_values_where_a_number_is_given(target, head):
    lines, _ = as_lines("CALL go(p2, 30, #p1)", target=target, data=GO + AS_DATA)
    assert head in lines


def test_names_that_nothing_declares_are_what_their_sign_says():
    lines, _losses = as_lines("HOME", "JMOVE #q", target="rapid")
    assert "PERS jointtarget n__HOME; !not declared in the source" in lines
    assert "PERS jointtarget n__q; !not declared in the source" in lines
    assert sum(line.startswith("MoveAbsJ n__") for line in lines) == 2


@pytest.mark.parametrize("target", ["krl", "rapid"])
def test_elements_of_an_array_that_no_row_teaches_are_zeros_and_told(target):
    data = ".TRANS\nq[0] 0 600 300 90 180 0\nq[2] 100 600 300 90 180 0\n.END\n"
    _lines, losses = as_lines("FOR i = 0 TO 2 STEP 2", "LMOVE q[i]", "END", target=target, data=data)
    assert [one.says for one in losses if "elements" in one.says] == [
        "elements of q have no values: zeros are written in their places"
    ]


def test_a_point_that_no_row_teaches_has_no_values_in_fanuc_where_the_program_stops():
    data = ".TRANS\nq[0] 0 600 300 90 180 0\n.END\n"
    lines, losses = as_lines("LMOVE q[0]", "LMOVE q[1]", target="tp", data=data)
    assert sum("********" in line for line in lines) == 2
    assert not [one for one in losses if "elements" in one.says]


def test_points_that_no_row_teaches_are_taught_one_by_one_in_fanuc():
    data = ".TRANS\nq[0] 0 600 300 90 180 0\n.END\n"
    lines, _ = as_lines("LMOVE q[1]", "LMOVE q[2]", "LMOVE q[1]", target="tp", data=data)
    points = [re.search(r"P\[(\d+)\]", line).group(1) for line in lines if re.match(r"\d+:L ", line)]
    assert points[0] == points[2] != points[1]


def test_an_element_that_a_loop_reaches_and_no_row_teaches_is_zeros_in_fanuc_and_told():
    """A register without values would stop the program before it comes to another element, or keep an old place."""
    data = ".TRANS\nq[0] 0 600 300 90 180 0\nq[2] 100 600 300 90 180 0\n.END\n"
    lines, losses = as_lines("FOR i = 0 TO 2 STEP 2", "LMOVE q[i]", "END", target="tp", data=data)
    assert not any("********" in line for line in lines)
    assert any("elements of q have no values: zeros" in one.says for one in losses)


STARS = """/PROG  T
/MN
   1:L P[1] 250mm/sec FINE ;
/POS
P[1]{
   GP1:
\tUF : 0, UT : 1,\t\tCONFIG : 'N U T, 0, 0, 0',
\tX = ********  mm,\tY = ********  mm,\tZ = ********  mm,
\tW = ******** deg,\tP = ******** deg,\tR = ******** deg
};
/END
"""


def test_a_point_of_a_listing_that_was_never_taught_is_zeros_in_inform_and_told():
    made = convert(read_source(decode(STARS.encode(), "t.ls")), "inform", Context(on_loss="comment"))
    assert b"C00000=0.000,0.000,0.000" in b"".join(made.files.values())
    assert any("never taught" in one.says for one in made.translated.losses)


# --- where the arm stands ------------------------------------------------------------------------------------------


def val3(*rows):
    code = "".join(f"{row}\n" for row in rows)
    text = f'<Programs>\n<Program name="start">\n<Code><![CDATA[begin\n{code}end]]></Code>\n</Program>\n</Programs>\n'
    return read_source(decode(text.encode(), "start.pgx"), vendor="val3")


def test_val3_reads_the_position_with_the_tool_and_in_the_frame_that_it_names():
    program = val3("p=here(tGrip,fTable)", "q=here(flange,world)")
    made = convert(program, "rapid", Context(robot=ROBOT, on_loss="comment"))
    text = b"\n".join(made.files.values()).decode("cp1252")
    assert "p:=CRobT(\\Tool:=tGrip\\WObj:=fTable);" in text
    assert "q:=CRobT(\\Tool:=tool0\\WObj:=wobj0);" in text
    assert "PERS wobjdata fTable;" in text


def test_val3_says_in_the_receipt_that_moves_are_queued():
    program = val3("movej(j,tGrip,m)", "out=true")
    losses = convert(program, "rapid", Context(robot=ROBOT, on_loss="comment")).translated.losses
    assert any("moves are queued" in one.says for one in losses)


@pytest.mark.parametrize("wait", ["BREAK", "TWAIT 0.5"])
def test_the_arm_stands_while_a_program_waits_for_a_time(wait):
    head = ("SPEED 100 MM/S ALWAYS", "ACCURACY 20 ALWAYS", "JMOVE #p1")
    lines, _ = as_lines(*head, "LMOVE p2", wait, "LMOVE p3", target="rapid")
    moves = [line for line in lines if line.startswith("MoveL")]
    assert [line.split(",")[2] for line in moves] == ["fine", "z20"]
    lines, _ = as_lines(*head, "WHILE SIG(1001) DO", wait, "LMOVE p3", "END", target="rapid")
    at = next(n for n, line in enumerate(lines) if line.startswith("WHILE"))
    assert lines[at + 1] == "WaitRob\\InPos;"
    assert lines[at + 2].startswith("WaitTime" if wait.startswith("TWAIT") else "MoveL")


READING = ("MOVJ P001 VJ=20.00", "GETS PX003 $PX001", "MOVL P002 V=100.0")


def test_the_arm_stands_where_a_job_reads_its_position():
    text = inform(*READING, points=POINTS)
    assert "CONTINUE" not in translated(text, "inform", "krl")
    assert any(
        "its position is read" in one.says for one in converted(text, "inform", "krl").translated.losses
    )
    moves = [line.strip() for line in translated(text, "inform", "rapid").splitlines() if "MoveJ" in line]
    assert [line.split(",")[2] for line in moves] == ["fine"]


def test_tool_0_of_a_job_may_be_another_than_the_flange():
    text = inform("MOVJ P001 VJ=20.00 PL=0", points=POINTS)
    program = read(text, "inform")
    made = convert(program, "rapid", Context(robot=ROBOT))
    runs = runs_of(program, made, "rapid", (ROBOT, None))
    receipt = receipt_of(link(program), made.translated, "rapid", tuple(made.files), runs, (ROBOT, None))
    assert any("tool 0 of the source's controller" in one for one in receipt.before_run)


def test_a_move_behind_a_call_has_its_own_acceleration():
    rows = ("MOVJ P001 VJ=20.00 ACC=60 DEC=60", "CALL JOB:PART IF B001=1", "MOVJ P002 VJ=20.00")
    made = translated(inform(*rows, points=POINTS), "inform", "krl")
    shares = [line.strip() for line in made.splitlines() if line.strip().startswith("$ACC_AXIS[1]")]
    assert shares == ["$ACC_AXIS[1]=100", "$ACC_AXIS[1]=60", "$ACC_AXIS[1]=100"]


@pytest.mark.parametrize("forms", [False, True])
def test_how_fast_the_tool_turns_holds_for_the_moves_alone_that_say_it(forms):
    rows = ("MOVJ P001 VJ=20.00", "MOVL P002 VR=10.0", "MOVL P001 V=100.0", "MOVL P002 V=100.0")
    program = read(inform(*rows, points=POINTS), "inform")
    made = convert(program, "krl", Context(robot=ROBOT, forms=forms))
    text = b"\n".join(it for name, it in made.files.items() if name.endswith(".src")).decode()
    lines = [line.strip() for line in text.splitlines()]
    words = [line for line in lines if line.startswith(("$VEL.ORI1", "LIN "))]
    assert [word.split("=")[0].split(" ")[0] for word in words] == [
        "$VEL.ORI1",
        "LIN",
        "$VEL.ORI1",
        "LIN",
        "LIN",
    ]
    assert float(words[2].split("=")[1]) == 200


@pytest.mark.parametrize("tag", ["ACC=40", "DEC=40"])
def test_speeding_up_alone_is_not_braking(tag):
    text = inform("MOVJ P001 VJ=20.00", f"MOVL P002 V=100.0 PL=0 {tag}", points=POINTS)
    losses = converted(text, "inform", "rapid").translated.losses
    assert any("one share for speeding up and braking" in one.says for one in losses)
    moves = read(text, "inform").plan(robot=ROBOT).moves
    assert (moves.acceleration[1], moves.deceleration[1]) == ((0.4, 1.0) if "ACC" in tag else (1.0, 0.4))


def test_one_share_for_both_is_written_for_both():
    data = ("CONST robtarget p1:=[[900,0,400],[0,1,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];",)
    text = module("AccSet 40,100;", "MoveL p1,v100,fine,tool0;", data=data)
    assert "ACC=40 DEC=40" in translated(text, "rapid", "inform")


def test_a_share_of_speeding_up_in_as_is_not_one_of_braking():
    program = read_source(
        decode(as_program("ACCEL 50 ALWAYS", "LMOVE p2", "ACCEL 30", "LMOVE p3").encode(), "main.as")
    )
    moves = program.plan(robot=ROBOT).moves
    assert list(moves.acceleration) == [0.5, 0.3]
    assert list(moves.deceleration) == [1.0, 1.0]


SYSTEMS = (
    *("///TOOL 1", "///POSTYPE BASE", "///RECTAN", "///RCONF 1,0,0,0,0,0,0,0"),
    "C001=900.000,0.000,400.000,180.0000,0.0000,0.0000",
    *("///TOOL 2", "///USER 3", "///POSTYPE USER"),
    "C002=100.000,50.000,40.000,180.0000,0.0000,0.0000",
)


def moves_of(text, target):
    lines = translated(text, "inform", target).splitlines()
    return [line.strip() for line in lines if line.strip().startswith("Move")]


def test_a_position_that_is_read_has_the_tool_that_reads_it():
    rows = ("MOVJ C001 VJ=20.00 PL=0", "GETS P005 $PX001", "MOVL C002 V=100.0 PL=0", "MOVL P005 V=50.0 PL=0")
    text = inform(*rows, points=SYSTEMS)
    assert moves_of(text, "rapid")[-1].endswith("fine,tool_1;")
    assert not objections(text, "inform", "rapid")


def test_a_position_is_read_in_the_base_whatever_frame_holds():
    rows = ("MOVL C002 V=100.0 PL=0", "GETS P005 $PX001", "MOVL C001 V=100.0 PL=0", "MOVL P005 V=50.0 PL=0")
    text = inform(*rows, points=SYSTEMS)
    for target in ("krl", "rapid", "tp", "urscript"):
        assert not objections(text, "inform", target), target


def test_a_variable_has_the_tool_and_the_frame_of_what_it_was_set_to_last():
    rows = (
        "SET P005 C001",
        "MOVL P005 V=50.0 PL=0",
        "SET P005 C002",
        "SET P006 P005",
        "MOVL P006 V=50.0 PL=0",
    )
    text = inform(*rows, points=SYSTEMS)
    assert [move.split("fine,")[1] for move in moves_of(text, "rapid")] == [
        "tool_1;",
        "tool_2\\WObj:=frame_3;",
    ]


def test_a_variable_of_one_tool_or_the_other_is_no_target():
    rows = ("SET P005 C001", "IFTHENEXP B001=1", "SET P005 C002", "ENDIF", "MOVL P005 V=50.0 PL=0")
    losses = converted(inform(*rows, points=SYSTEMS), "inform", "rapid").translated.losses
    assert any("set with several tools or frames" in one.says for one in losses)


@pytest.mark.parametrize("target", ["krl", "rapid", "tp"])
def test_bits_of_bytes_are_inverted_and_combined_in_every_language(target):
    rows = ("DIN B001 IG#(2)", "NOT B002 B001", "AND B002 15", "DOUT OG#(1) B002")
    text = inform(*rows)
    losses = converted(text, "inform", target).translated.losses
    assert all("a loop computes them" in one.says for one in losses), losses
    assert not objections(text, "inform", target)


def test_the_bits_of_more_than_a_byte_are_not_inverted():
    losses = converted(inform("NOT I001 I002"), "inform", "krl").translated.losses
    assert any("beyond a byte" in one.says for one in losses)


@pytest.mark.parametrize("target", ["krl", "rapid"])
def test_a_group_that_the_target_knows_by_name_has_the_number_of_the_source(target):
    text = inform("DIN B001 IG#(2)", "DOUT OG#(1) B001", "IFTHENEXP B001=7", "DOUT OT#(30) ON", "ENDIF")
    assert not objections(text, "inform", target)


def test_waits_that_ask_in_a_loop_do_not_end_the_run_of_a_translation():
    rows = ("WAIT IN#(1)=ON T=90.00", "DOUT OT#(1) ON", "WAIT IN#(2)=ON T=90.00", "DOUT OT#(2) ON")
    assert not objections(inform(*rows), "inform", "krl")


VAL3_DATA = """<?xml version="1.0" encoding="utf-8" ?>
<Database xmlns:xsi="http://www.w3.org/2001/XMLSchema-instance" xmlns="http://www.staubli.com/robotics/VAL3/Data/2">
  <Datas>
    <Data name="pA" access="private" xsi:type="array" type="pointRx" size="1">
      <Value key="0" x="700" y="100" z="400" rx="10" ry="20" rz="30" fatherId="world[0]" />
    </Data>
    <Data name="mNom" access="private" xsi:type="array" type="mdesc" size="1">
      <Value key="0" accel="100" vel="100" decel="100" tmax="250" rmax="90" blend="cartesian" leave="20" reach="20" />
    </Data>
    <Data name="mStop" access="private" xsi:type="array" type="mdesc" size="1">
      <Value key="0" accel="50" vel="40" decel="50" tmax="99999" rmax="90" blend="off" leave="50" reach="50" />
    </Data>
    <Data name="nTurn" access="private" xsi:type="array" type="num" size="1">
      <Value key="0" value="0" />
    </Data>
  </Datas>
</Database>
"""


def val3_beside(folder, *rows):
    """A program with the data of its project in the folder."""
    (folder / "cell.dtx").write_text(VAL3_DATA)
    code = "\n".join(rows)
    head = '<Programs xmlns="http://www.staubli.com/robotics/VAL3/Program/2"><Program name="start">'
    (folder / "start.pgx").write_text(
        f"{head}<Code><![CDATA[begin\n{code}\nend]]></Code></Program></Programs>"
    )
    return link(read_path(folder / "start.pgx")).program


@pytest.mark.parametrize("target", ["krl", "rapid", "tp", "urscript"])
def test_moves_of_val3_have_the_values_of_their_motion_descriptors(target, tmp_path):
    program = val3_beside(tmp_path, "movej(pA,flange,mStop)", "movel(appro(pA,{0,0,-50,0,0,0}),flange,mNom)")
    made = convert(program, target, Context(robot=load_robot("staubli/tx2-90l")))
    text = b"\n".join(made.files.values()).decode("cp1252")
    assert "mNom" not in text
    assert {"krl": "$VEL.CP=0.25", "rapid": "v250", "tp": "250mm/sec", "urscript": "v=0.25"}[target] in text


def test_a_motion_descriptor_that_a_program_changes_is_variables(tmp_path):
    program = val3_beside(tmp_path, "mNom.tmax=100", "movel(pA,flange,mNom)")
    made = convert(program, "krl", Context(robot=load_robot("staubli/tx2-90l")))
    text = b"\n".join(made.files.values()).decode("cp1252")
    assert "mNom_tmax=100" in text
    assert "$VEL.CP=mNom_tmax*0.001" in text


@pytest.mark.parametrize("target", ["krl", "rapid", "inform"])
def test_what_the_tool_of_val3_does_is_told_as_left_out(target, tmp_path):
    program = val3_beside(tmp_path, "movel(pA,flange,mNom)", "close(flange)", "delay(0.2)", "stopMove()")
    robot = load_robot("staubli/tx2-90l")
    made = convert(program, target, Context(robot=robot, on_loss="comment"))
    left_out = {loss.line for loss in made.translated.losses if loss.leaves_out}
    assert len(left_out) == 2
    found = compare_plans(
        run(program, robot=robot), run_converted(made, target, robot, program), blends=False, without=left_out
    )
    assert found.is_equal, found.differences


@pytest.mark.parametrize("target", ["krl", "rapid", "urscript"])
def test_angles_of_val3_turn_about_its_own_axes(target, tmp_path):
    rows = (
        "pA.trsf.rx=pA.trsf.rx+25",
        "movel(pA,flange,mNom)",
        "nTurn=pA.trsf.ry",
        "if nTurn>19.9 and nTurn<20.1",
    )
    program = val3_beside(tmp_path, *rows, "movel(appro(pA,{0,0,-50,0,0,0}),flange,mNom)", "endIf")
    robot = load_robot("staubli/tx2-90l")
    plan = run(program, robot=robot)
    turned = Rotation.from_euler("XYZ", (35, 20, 30), degrees=True)
    w, x, y, z = plan.positions.quaternion[plan.moves.target[0]]
    assert (Rotation.from_quat([x, y, z, w]) * turned.inv()).magnitude() < 1e-6
    assert len(plan.moves) == 2
    made = convert(program, target, Context(robot=robot))
    assert compare_plans(plan, run_converted(made, target, robot, program)).is_equal


# --- KRL ------------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("target", ["rapid", "inform"])
def test_points_of_forms_that_no_list_has_are_another_one_in_each_file(target, tmp_path):
    (tmp_path / "part.src").write_text("DEF part()\nPTP XP1\nPTP XHOME\nEND\n")
    (tmp_path / "main.src").write_text("DEF main()\nPTP XHOME\nPTP XP1\npart()\nEND\n")
    program = link(read_path(tmp_path / "main.src"), target).program
    taught = {
        move.targets[0].name
        for routine in program.routines
        for move in routine.body
        if isinstance(move, Move)
    }
    assert taught == {"XHOME", "XP1", "XP1_part"}
    (tmp_path / "main.dat").write_text(
        "DEFDAT main PUBLIC\nDECL GLOBAL E6POS XP1={X 900,Y 0,Z 400,A 0,B 0,C 180}\nENDDAT\n"
    )
    program = link(read_path(tmp_path / "main.src"), target).program
    taught = {
        move.targets[0].name
        for routine in program.routines
        for move in routine.body
        if isinstance(move, Move)
    }
    assert taught == {"XHOME", "XP1"}


def test_a_blend_in_a_variable_is_millimetres_in_inform():
    rows = ("$VEL.CP=0.25", "$APO.CDIS=size", "LIN {X 900,Y 0,Z 400,A 0,B 0,C 180} C_DIS")
    text = "\n".join(
        ["DEF main(size:IN)", "INT size", *rows, "LIN {X 900,Y 90,Z 400,A 0,B 0,C 180}", "END", ""]
    )
    made = translated(text, "krl", "inform")
    assert re.search(r"MOVL C\d+ V=250.0 CR=D\d+", made), made


def test_a_group_of_krl_has_the_number_of_the_target():
    head = "DEF main()\nDECL INT code\nSIGNAL INP8 $IN[17] TO $IN[24]\nSIGNAL OUT8 $OUT[17] TO $OUT[24]\n"
    text = head + "code=INP8\nOUT8=code\nEND\n"
    assert not objections(text, "krl", "inform")


def test_runs_that_were_both_stopped_are_compared_as_far_as_both_came():
    rows = ("MoveL p1,v100,z10,tool0;", "MoveL p2,v100,z10,tool0;", "SetDO do1,1;")
    data = (
        "CONST robtarget p1:=[[900,0,400],[0,1,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];",
        "CONST robtarget p2:=[[900,90,400],[0,1,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];",
    )
    program = read(module(*rows * 9, data=data), "rapid")
    longer, shorter = (run(program, robot=ROBOT, max_steps=most) for most in (20, 14))
    assert not compare_plans(longer, run(program, robot=ROBOT)).is_equal
    assert compare_plans(longer, shorter).is_equal


PLACE = (*POINTS[:4], "C001=900.000,0.000,400.000,180.0000,0.0000,0.0000")


@pytest.mark.parametrize(
    ("target", "base", "tool"),
    [
        (
            "rapid",
            "MoveL Offs(CRobT(",
            "PoseMult([olp_robtarget1.trans,olp_robtarget1.rot],[PV1.trans,PV1.rot])",
        ),
        (
            "urscript",
            "movel(pose_add(get_actual_tcp_pose(), p[PV1[0],",
            "movel(pose_trans(get_actual_tcp_pose(), PV1), v=0.1)",
        ),
    ],
)
def test_moves_by_a_computed_offset_take_its_components(target, base, tool):
    """They were refused; an offset that nothing sets was zeros, so that what its operator sets moved nothing."""
    rows = ("MOVL C001 V=50.0 PL=0", "SET D000 50000", "SETE P001 (1) D000", "SETE P001 (3) D000")
    text = inform(*rows, "IMOV P001 V=100.0 PL=0", "IMOV P001 V=100.0 PL=0 TF", points=PLACE)
    written = translated(text, "inform", target)
    assert base in written
    assert tool in written
    # What nothing sets of the offset is the operator's: in the tool's axes its angles turn the move there, too; in the
    # base they are left out, which the proof sees.
    assert not objections(inform(*rows, "IMOV P001 V=100.0 PL=0 TF", points=PLACE), "inform", target)
    found = objections(text, "inform", target)
    assert found
    assert all(kind == "difference" and "another value of P001" in says for kind, says in found)


def test_an_offset_that_nothing_here_sets_stays_a_variable_and_its_angles_are_told():
    text = inform("MOVL C001 V=50.0 PL=0", "IMOV P002 V=100.0 PL=0", points=PLACE)
    made = converted(text, "inform", "rapid")
    assert b"PV2.trans.x,PV2.trans.y,PV2.trans.z" in b"".join(made.files.values())
    assert any("angles" in loss.says and loss.fate is Fate.APPROXIMATED for loss in made.translated.losses)


def test_times_and_speeds_of_variables_are_converted_for_tp():
    """INFORM counts them in hundredths of a second and tenths of a mm/s; TP refused the whole program."""
    rows = ("MOVL C001 V=50.0 PL=0", "SET D000 250", "TIMER T=D000", "SET I002 300", "MOVL C002 V=I002 PL=0")
    text = inform(*rows, points=[row.replace("P00", "C00") for row in POINTS])
    lines = translated(text, "inform", "tp")
    assert re.search(r"R\[(\d+):\w+\]=R\[\d+:D0\]\*0.01 ;\s+\d+:\s+WAIT R\[\1:", lines)
    assert re.search(r"R\[(\d+):\w+\]=R\[\d+:I2\]\*0.1 ;\s+\d+:\s*L P\[2\] R\[\1:\w+\]mm/sec", lines)
    assert not objections(text, "inform", "tp")


def test_a_move_without_a_speed_takes_the_variable_of_the_move_before() -> None:
    points = ["///TOOL 0", "///POSTYPE BASE", "///RECTAN"]
    points += [f"C0000{n}=900.000,{n}0.000,500.000,180.0000,0.0000,0.0000" for n in range(3)]
    text = inform(
        "MOVL C00000 V=R001 PL=2", "SET R001 75", "MOVL C00001", "MOVL C00002 V=90.0", points=points
    )
    rows = [
        row.split(":", 1)[1].strip(" ;")
        for row in translated(text, "inform", "tp").split("\r\n")
        if ":" in row
    ]
    held = next(row.split("=")[0] for row in rows if "=R[1:R1]" in row)
    assert rows.index(f"{held}=R[1:R1]") < rows.index("R[1:R1]=75")
    assert any(row.startswith(f"L P[2] {held}mm/sec") for row in rows)


_MOVES_AND_JUMPS = [
    "MOVL C00000 V=100.0 PL=0",
    "INC B001",
    "JUMP JOB:PART IF B001<1",
    "MOVL C00001 V=100.0 PL=0",
]
_CORNERS = [
    "///TOOL 1", "///POSTYPE BASE", "///RECTAN", "///RCONF 1,0,0,0,0,0,0,0",
    "C00000=900.000,0.000,400.000,180.0000,0.0000,0.0000", "C00001=900.000,90.000,400.000,180.0000,0.0000,0.0000",
]  # fmt: skip


@pytest.mark.parametrize("target", ["krl", "rapid", "tp", "urscript"])
def test_a_job_that_takes_over_is_called_and_a_job_that_begins_again_jumps(target, tmp_path):
    """JUMP JOB does not come back: a call and a return mean the same, and in a loop of jobs calls would go deeper."""
    jobs = {"PART": [*_MOVES_AND_JUMPS, "JUMP JOB:NEXT", "TIMER T=9.00"], "NEXT": ["TIMER T=1.00"]}
    for name, rows in jobs.items():
        text = inform(*rows, points=_CORNERS if name == "PART" else ()).replace(
            "//NAME PART", f"//NAME {name}"
        )
        (tmp_path / f"{name}.JBI").write_bytes(text.encode())
    program = link(read_path(tmp_path / "PART.JBI")).program
    made = convert(program, target, Context(robot=ROBOT, on_loss="comment"))
    assert not [loss for loss in made.translated.losses if loss.leaves_out]
    here = run(program, robot=ROBOT)
    assert compare_plans(here, run_converted(made, target, ROBOT)).differences == []
    assert [float(here.durations[row]) for row in here.row[here.kind == StepKind.WAIT]] == [1.0]
    text = b"".join(made.files.values()).decode()
    assert len(re.findall(r"\bPART *\(|CALL PART|^ *PART;", text, re.MULTILINE)) <= 1  # its own head
    (tmp_path / "NEXT.JBI").write_bytes(
        inform("JUMP JOB:PART").replace("//NAME PART", "//NAME NEXT").encode()
    )
    made = convert(
        link(read_path(tmp_path / "PART.JBI")).program, target, Context(robot=ROBOT, on_loss="comment")
    )
    assert any("ever deeper" in loss.says for loss in made.translated.losses)


_ROUND = [
    "///TOOL 0", "///POSTYPE BASE", "///RECTAN", "///RCONF 1,0,0,0,0,0,0,0",
    "C00000=900.000,0.000,400.000,180.0000,0.0000,0.0000", "C00001=950.000,50.000,400.000,180.0000,0.0000,0.0000",
    "C00002=1000.000,0.000,400.000,180.0000,0.0000,0.0000",
]  # fmt: skip


@pytest.mark.parametrize("target", ["krl", "rapid", "tp", "urscript"])
@pytest.mark.parametrize("lost", [0, 1, 2])
def test_a_chain_of_arcs_of_which_a_point_is_left_out_is_left_out(target, lost):
    """The other two were written as lines, without a word."""
    rows = [f"MOVC C0000{n} V=50.0{' UNTIL IN#(3)=ON' if n == lost else ''}" for n in range(3)]
    text = inform("MOVL C00000 V=50.0 PL=0", *rows, "MOVL C00000 V=60.0 PL=0", points=_ROUND)
    made = converted(text, "inform", target)
    lines = {loss.line for loss in made.translated.losses if loss.leaves_out}
    first = text.split("\r\n").index("MOVL C00000 V=50.0 PL=0") + 1
    assert lines == {first + 1, first + 2, first + 3}


@pytest.mark.parametrize("target", ["krl", "rapid", "tp", "urscript"])
def test_no_point_of_an_arc_is_computed_from_a_position_that_is_taught_later(target):
    """P050 has no value: the middles of the arcs beside it were computed from its zeros."""
    chain = [
        "MOVC C00000 V=50.0",
        "MOVC C00001 V=50.0",
        "MOVC P050 V=50.0",
        "MOVC C00002 V=50.0",
        "MOVC C00000 V=50.0",
    ]
    made = converted(inform("MOVL C00000 V=50.0 PL=0", *chain, points=_ROUND), "inform", target)
    assert [loss.says for loss in made.translated.losses if "taught on the controller" in loss.says]
    assert b"arc_point" not in b"".join(made.files.values())


@pytest.mark.parametrize("target", ["rapid", "urscript"])
def test_a_turning_speed_says_nothing_of_a_move_that_does_not_turn(target):
    """The way by a turn of a millionth of a degree was the fastest move of all."""
    points = ["///TOOL 0", "///POSTYPE BASE", "///RECTAN"]
    points += [
        f"C{n:05d}={900 + 50 * n}.000,0.000,500.000,178.5000,3.2500,{-21.5 + 3e-6 * n:.6f}" for n in range(2)
    ]
    text = inform("MOVL C00000 V=100.0 PL=0", "MOVL C00001 VR=30.0 PL=0", points=points)
    told = [one for one in converted(text, "inform", target).translated.losses if "does not turn" in one.says]
    assert len(told) == 1
    made = translated(text, "inform", target)
    numbers = [float(number) for number in re.findall(r"(?:v=|v)([\d.]+)", made)]
    assert max(numbers, default=0) < 5000
