"""KUKA's message library and settings of its advance run, translated as what they do."""

from __future__ import annotations

import re

import numpy as np
import pytest
from translated_texts import ROBOT, converted, krl, read, run_elsewhere, translated

from olp.fluent import read as read_file
from olp.ir.expressions import Compare, SignalState
from olp.ir.program import If
from olp.runtime.interpreter import run
from olp.runtime.plan import StepKind
from olp.transpile import Context
from olp.transpile.compare import compare_plans
from olp.transpile.convert import convert, run_converted
from olp.transpile.link import link

SHOWS = {"rapid": 'TPWrite "{}"', "tp": "MESSAGE[{}]", "urscript": '"{}"'}
STOPS = {"rapid": "Stop;", "tp": "  PAUSE ;", "urscript": ", blocking=True)"}


def left_out(text, target):
    return [loss.says for loss in converted(text, "krl", target).translated.losses if loss.leaves_out]


@pytest.mark.parametrize("target", SHOWS)
def test_a_message_is_shown_whatever_else_is_handed_over_with_it(target):
    text = krl('MsgNotify("door open","Cell",,,3)')
    assert SHOWS[target].format("door open") in translated(text, "krl", target)
    assert left_out(text, target) == []


@pytest.mark.parametrize("target", SHOWS)
def test_a_message_that_waits_for_the_operator_stops_the_program_there(target):
    text = krl('MsgQuit("load parts","Cell")')
    written = translated(text, "krl", target)
    assert written.index(SHOWS[target].format("load parts")) < written.index(STOPS[target])
    (loss,) = converted(text, "krl", target).translated.losses
    assert loss.fate == "approximated"
    assert "acknowledge" in loss.says


def test_a_number_stands_where_the_text_names_it():
    text = krl("DECL INT N", "N=4", 'MsgNotify("parts: %1","Cell",N)')
    assert 'TPWrite "parts: "\\Num:=N;' in translated(text, "krl", "rapid")


@pytest.mark.parametrize("target", SHOWS)
def test_a_state_is_shown_until_its_handle_is_cleared(target):
    rows = (
        "DECL INT H",
        "DECL BOOL B",
        "H=0",
        'MsgState(H,"busy","Cell")',
        "IF H>0 THEN",
        "B=Clear_KrlMsg(H)",
        "ENDIF",
    )
    text = krl(*rows, "WAIT FOR Clear_KrlMsg(H)", "IF B THEN", "$OUT[3]=TRUE", "ENDIF")
    assert SHOWS[target].format("busy") in translated(text, "krl", target)
    assert left_out(text, target) == []
    here, there = run(read(text, "krl"), robot=ROBOT), run_elsewhere(text, "krl", target)
    assert here.kind.tolist() == there.kind.tolist() == [StepKind.SIGNAL] * 4


def test_a_routine_of_the_programs_own_is_called_whatever_its_name(tmp_path):
    (tmp_path / "part.src").write_text(
        'DEF PART ( )\nMsgQuit("x")\nEND\nDEF MsgQuit(T[]:IN)\nDECL CHAR T[]\nEND\n'
    )
    assert "Call" in {type(s).__name__ for s in link(read_file(tmp_path / "part.src")).program.statements()}


def test_the_library_itself_is_not_translated(tmp_path):
    (tmp_path / "part.src").write_text('DEF PART ( )\nMsgQuit("x")\nEND\n')
    (tmp_path / "MsgLib.src").write_text(
        "DEF MsgLib ( )\nEND\nGLOBAL DEF MsgQuit(T[]:IN)\nDECL CHAR T[]\nEND\n"
    )
    program = link(read_file(tmp_path / "part.src")).program
    assert [routine.name for routine in program.routines] == ["PART"]
    assert [type(s).__name__ for s in program.statements() if s.line == 2] == ["Message", "Pause"]


@pytest.mark.parametrize("target", ["rapid", "tp"])
def test_functions_of_inline_forms_come_from_the_controllers_files_and_are_not_translated(tmp_path, target):
    (tmp_path / "part.src").write_text(
        "DEF PART ( )\n"
        "PTP {A1 0,A2 -90,A3 90,A4 0,A5 20,A6 0}\n"
        "SPTP {A1 9,A2 -90,A3 90,A4 0,A5 20,A6 0} WITH $VEL_AXIS[1]=SVEL_JOINT(50.0), $LOAD=SLOAD(1), "
        "$GEAR_JERK[1]=SGEAR_JERK(PDEFAULT), $COLLMON_TOL_PRO[1]=USE_CM_PRO_VALUES(0)\n"
        "MasRef_Main( )\nEND\n"
    )
    (tmp_path / "bas.src").write_text(
        "DEF BAS ( )\nEND\n"
        "GLOBAL DEFFCT LOAD SLOAD(N :IN)\nDECL INT N\nRETURN LOAD_DATA[N]\nENDFCT\n"
        "GLOBAL DEFFCT REAL SGEAR_JERK(P :OUT)\nDECL PDAT P\nRETURN P.GEAR_JERK\nENDFCT\n"
    )
    (tmp_path / "CollMonLib.src").write_text(
        "DEF COLLMONLIB ( )\nEND\n"
        "GLOBAL DEFFCT INT USE_CM_PRO_VALUES(N :IN)\nDECL INT N\n$COLLMON_TOL_PRO[1]=CM_AX1\nRETURN 1\nENDFCT\n"
    )
    (tmp_path / "masref_main.src").write_text("DEF MasRef_Main ( )\n$MasteringTest_Active=TRUE\nEND\n")
    program = link(read_file(tmp_path / "part.src")).program
    assert [routine.name for routine in program.routines] == ["PART"]
    losses = convert(program, target, Context(ROBOT, on_loss="comment")).translated.losses
    assert [loss.line for loss in losses if loss.leaves_out] == [4]


def test_the_message_window_is_written_and_cleared():
    text = krl('$LOOP_MSG[]="busy"', "WAIT FOR StrClear($LOOP_MSG[])", "$LOOP_CONT=TRUE")
    written = translated(text, "krl", "rapid")
    assert written.index('TPWrite "busy"') < written.index('TPWrite " "')
    assert left_out(text, "rapid") == [
        "whether the operator may skip what is waited for moves nothing: it is a comment there"
    ]


def test_a_window_of_many_blanks_is_an_empty_message():
    assert "MESSAGE[ " in translated(krl(f'$LOOP_MSG[]="{" " * 60}"'), "krl", "tp")


ASKED = (
    # calls of DEED(A, B), what VARSTATE of B is
    (("DEED(1,2)", "DEED(3,4)"), True),
    (("DEED(1)", "DEED(3,)"), False),
    (("DEED(1,2)", "DEED(3)"), None),  # each call as it is: no translation of the routine says that
    ((), True),  # the routine that is started is handed all that it takes
)


@pytest.mark.parametrize(("calls", "given"), ASKED)
def test_whether_a_parameter_is_handed_over_is_told_by_the_calls(calls, given):
    text = (
        krl(*calls)
        + 'DEF DEED(A:IN,B:IN)\r\nINT A,B\r\nIF VARSTATE("B")==#INITIALIZED THEN\r\nHALT\r\nENDIF\r\nEND\r\n'
    )
    (asked,) = [s.condition for s in read(text, "krl").statements() if isinstance(s, If)]
    assert asked == SignalState(given) if given is not None else isinstance(asked, Compare)


def test_a_parameter_that_the_routine_sets_itself_is_not_told_by_the_calls():
    text = (
        krl("DEED(1)")
        + 'DEF DEED(A:IN,B:IN)\r\nINT A,B\r\nB=2\r\nIF VARSTATE("B")==#INITIALIZED THEN\r\nHALT\r\nENDIF\r\nEND\r\n'
    )
    (asked,) = [s.condition for s in read(text, "krl").statements() if isinstance(s, If)]
    assert isinstance(asked, Compare)


def test_both_runs_show_the_same():
    text = krl('MsgNotify("a")', "$OUT[1]=TRUE", 'MsgQuit("b","Cell")', "$OUT[1]=FALSE")
    here, there = run(read(text, "krl"), robot=ROBOT), run_elsewhere(text, "krl", "rapid")
    assert here.kind.tolist() == there.kind.tolist()
    assert here.kind.tolist().count(StepKind.SIGNAL) >= 4


ADVANCE = (
    (("$ADVANCE=3",), "C_DIS", True),
    (("$ADVANCE=0",), "", True),
    (("$ADVANCE=0",), "C_DIS", False),  # no move is blended then: not what the corner says
    (("$ADVANCE=N",), "", False),
    (("$ADVANCE=3", "N=$ADVANCE"), "", True),
)


@pytest.mark.parametrize(("rows", "blend", "idle"), ADVANCE)
def test_the_length_of_the_advance_run_matters_to_corners_alone(rows, blend, idle):
    moves = (f"LIN {{X {x},Y 0,Z 400,A 0,B 90,C 0}} {blend}" for x in (800, 850, 900))
    said = left_out(krl("DECL INT N", *rows, *moves), "rapid")
    assert any("moves nothing" in one for one in said) is idle
    assert any("belongs to KRL" in one for one in said) is not idle


def test_a_declaration_of_a_routine_elsewhere_is_no_statement():
    assert left_out(krl("EXT SUBP(REAL:IN)"), "tp") == [
        "a declaration of what is elsewhere does nothing: it is a comment there"
    ]


def test_what_another_routine_reads_of_a_forms_data_changes_nothing_here():
    text = krl(
        "PDAT_ACT=PDEFAULT",
        "FDAT_ACT=FHOME",
        "BAS(#PTP_PARAMS,50)",
        "PTP {A1 0,A2 -90,A3 90,A4 0,A5 10,A6 0}",
    )
    text += "DEF OTHER(V:IN)\r\nREAL V\r\nIF V>0 THEN\r\nPDAT_ACT.VEL=V\r\nENDIF\r\nBAS(#PTP_DAT)\r\nEND\r\n"
    lost = [loss.line for loss in converted(text, "krl", "rapid").translated.losses if loss.leaves_out]
    assert min(lost, default=99) > 6


def test_members_of_a_forms_data_count_for_the_move_behind_them():
    rows = (
        "FDAT_ACT=FHOME",
        "FDAT_ACT.TOOL_NO=3",
        "FDAT_ACT.BASE_NO=4",
        "LDAT_ACT=LDEFAULT",
        "LDAT_ACT.VEL=0.3",
        "LDAT_ACT.APO_DIST=7",
        "BAS(#CP_DAT)",
        "BAS(#FRAMES)",
        "LIN {X 800,Y 0,Z 400,A 0,B 90,C 0} C_DIS",
        "LIN {X 900,Y 0,Z 400,A 0,B 90,C 0}",
    )
    text = krl(*rows)
    assert left_out(text, "rapid") == []
    written = translated(text, "krl", "rapid")
    assert "v300" in written
    assert "tool_3\\WObj:=frame_4" in written


RECORDS = (
    "DECL KRLMSG_T M",
    "DECL KRLMSGPAR_T P[3]",
    "DECL KRLMSGOPT_T O",
    "DECL INT H",
    'M={MODUL[] "CELL",NR 1,MSG_TXT[] "part %1 is missing"}',
    "P[1]={PAR_TYPE #VALUE,PAR_INT H}",
    "H=Set_KrlMsg(#NOTIFY,M,P[],O)",
)


def test_a_message_that_is_a_record_shows_its_text_with_its_parameters():
    text = krl(*RECORDS)
    assert 'TPWrite "part " + ValToStr(H) + " is missing";' in translated(text, "krl", "rapid")
    assert "MESSAGE[part <H> is missing]" in translated(text, "krl", "tp")
    fates = {loss.line: loss.fate for loss in converted(text, "krl", "rapid").translated.losses}
    assert fates == {7: "approximated"}  # what tells how the parameter is shown


def test_a_loop_until_a_message_is_acknowledged_is_a_stop():
    loop = ("WHILE Exists_KrlMsg(H)", "WAIT SEC 0.1", "ENDWHILE", "$OUT[3]=TRUE")
    text = krl(*RECORDS, *loop)
    assert "Stop;" in translated(text, "krl", "rapid")
    assert "WHILE" not in translated(text, "krl", "rapid")
    assert left_out(text, "rapid") == left_out(text, "tp") == []


HANDED = """DEF shown()
DECL KRLMSG_T M
DECL KRLMSGDLGSK_T KEYS[7]
DECL KRLMSGPAR_T P[3]
DECL KRLMSGOPT_T O
DECL INT H
M={MODUL[] "CELL",NR 1,MSG_TXT[] "unknown"}
TEXTS($IN[3],%s,KEYS[])
H=Set_KrlMsg(#NOTIFY,M,P[],O)
END
DEF TEXTS(FAULT:IN,MSG:OUT,SK[]:OUT)
DECL BOOL FAULT
DECL KRLMSG_T MSG
DECL KRLMSGDLGSK_T SK[]
SK[1]={SK_TYPE #VALUE,SK_TXT[] "quit"}
IF FAULT THEN
MSG={MODUL[] "CELL",NR 2,MSG_TXT[] "gripper is open"}
ENDIF
END
"""


def test_a_message_that_a_routine_fills_is_handed_over_as_its_text():
    rapid = translated(HANDED % "M", "krl", "rapid")
    assert "PROC TEXTS(bool FAULT,INOUT string MSG_TEXT)" in rapid
    assert 'MSG_TEXT:="gripper is open";' in rapid
    assert "TEXTS di3=1,M_TEXT;" in rapid
    assert "TPWrite M_TEXT;" in rapid  # a text, and not a value that becomes one
    tp = translated(HANDED % "M", "krl", "tp")
    assert "SR[2:MSG_TEXT]='gripper is open'" in tp
    assert "SR[1:M_TEXT]=SR[2:MSG_TEXT]" in tp
    fates = {loss.line: loss.fate for loss in converted(HANDED % "M", "krl", "rapid").translated.losses}
    assert fates == {15: "approximated"}  # the key's label


def test_a_message_out_of_many_is_not_handed_over_as_a_text():
    """What no name says is left as it is, in the routine and in its calls."""
    other = HANDED.replace("DECL KRLMSG_T M\n", "DECL KRLMSG_T M\nDECL KRLMSG_T MANY[3]\n") % "MANY[2]"
    assert "MSG_TEXT" not in translated(other, "krl", "rapid")


@pytest.mark.parametrize("row", ["USER_GRP(0,DUMMY,DUMMY,GDEFAULT)", "USERSPOT(#INIT)", "A20_INI()"])
def test_the_start_of_an_option_package_does_nothing(row):
    losses = converted(krl(row), "krl", "rapid").translated.losses
    assert {loss.fate for loss in losses} == {"exact"}


def test_a_gripper_is_no_start_of_its_package_but_a_call():
    made = converted(krl("USER_GRP(2,DUMMY,DUMMY,GDEFAULT)"), "krl", "rapid")
    assert {loss.fate for loss in made.translated.losses} == {"approximated"}
    assert b"USER_GRP 2,DUMMY,DUMMY,GDEFAULT;" in b"".join(made.files.values())


def test_a_cyclic_flag_is_its_condition_wherever_it_is_read():
    text = krl("$CYCFLAG[1]=$IN[1] AND NOT $IN[2]", "WAIT FOR $CYCFLAG[1]")
    assert "WaitUntil di1=1 AND di2=0;" in translated(text, "krl", "rapid")
    assert "WAIT (DI[1] AND !DI[2])" in translated(text, "krl", "tp")


def test_a_cyclic_flag_with_two_conditions_is_none_of_them():
    text = krl("$CYCFLAG[1]=$IN[1]", "$CYCFLAG[1]=$IN[2]", "WAIT FOR $CYCFLAG[1]")
    losses = converted(text, "krl", "rapid").translated.losses
    assert [loss.line for loss in losses if loss.fate == "commented"] == [2, 3]


def test_a_flag_of_a_clock_tells_that_its_time_is_over():
    text = krl("$TIMER[1]=-2000", "$TIMER_STOP[1]=FALSE", "WAIT FOR $TIMER_FLAG[1] OR $IN[4]")
    assert "WaitUntil ClkRead(clock1)>=2 OR di4=1;" in translated(text, "krl", "rapid")
    assert "WAIT (TIMER[1]>=2 OR DI[4])" in translated(text, "krl", "tp")


def test_a_clock_that_is_set_to_several_times_is_compared_with_the_last_one():
    rows = ("DECL INT N", "N=500", "$TIMER[1]=-N", "$TIMER_STOP[1]=FALSE", "WAIT FOR $TIMER_FLAG[1]")
    written = translated(krl(*rows, "$TIMER[1]=0", "WAIT FOR $TIMER[1]>300"), "krl", "rapid")
    assert "WaitUntil ClkRead(clock1)>=clock_passes_0;" in written
    assert "clock_passes_0:=0.0;" in written
    assert "WaitUntil ClkRead(clock1)>clock_passes_0 + 0.3;" in written


STATES = (
    # what the program asks, in RAPID, in TP
    ("$MODE_OP==#T1", "OpMode()=OP_MAN_PROG", "UO[8]"),
    ("$MODE_OP<>#T1", "NOT OpMode()=OP_MAN_PROG", "!UO[8]"),
    ("$EXT", "NOT (OpMode()=OP_MAN_PROG OR OpMode()=OP_MAN_TEST)", "!UO[8]"),
    ("$PERI_RDY", "doMotorsOn=1", "UO[2]"),
    ("$MOVE_ENABLE", "doRunChainOk=1", "UI[8]"),
)


@pytest.mark.parametrize(("asked", "rapid", "tp"), STATES)
def test_what_the_controller_knows_of_itself_is_asked_of_its_own_signals(asked, rapid, tp):
    text = krl(f"IF {asked} THEN", "$OUT[3]=TRUE", "ENDIF")
    assert f"IF {rapid} THEN" in translated(text, "krl", "rapid")
    assert f"IF ({tp}) THEN" in translated(text, "krl", "tp")
    assert {x.fate for x in converted(text, "krl", "rapid").translated.losses if x.line == 2} <= {
        "approximated"
    }


def test_what_says_how_moves_are_made_is_told_and_does_not_stop_a_translation():
    text = krl("$LOAD.M=5", "$ACC.ORI1=200", "$GEAR_JERK[1]=50", "$ORI_TYPE=#JOINT", "$ORI_TYPE=#CONSTANT")
    fates = {loss.line: loss.fate for loss in converted(text, "krl", "rapid").translated.losses}
    assert fates == {**dict.fromkeys((2, 3, 4, 5), "approximated"), 6: "commented"}


CHARACTERS = krl(
    "DECL CHAR DIGIT[3]",
    "DECL CHAR TEXT[9]",
    "DECL CHAR ONE",
    'DIGIT[2]="2"',
    "ONE=DIGIT[2]",
    'TEXT[]="abcd"',
    "ONE=TEXT[3]",
)


def test_characters_that_are_never_taken_together_are_texts_of_one():
    written = translated(CHARACTERS, "krl", "rapid")
    assert "VAR string DIGIT{3};" in written
    assert 'DIGIT{2}:="2";' in written
    assert "ONE:=StrPart(TEXT_1,3,1);" in written or "ONE:=StrPart(TEXT,3,1);" in written
    assert left_out(CHARACTERS, "rapid") == left_out(CHARACTERS, "tp") == []


def test_setting_one_character_of_a_text_is_refused():
    text = krl("DECL CHAR TEXT[9]", 'TEXT[]="abcd"', 'TEXT[2]="x"')
    assert left_out(text, "rapid") == ["setting a single character of the text TEXT"]


FUNCTION = """DEFFCT FRAME UP(B:IN,H:IN)
FRAME B,T
INT H
T=B
T.Z=B.Z+H*10
RETURN (T)
ENDFCT
"""


@pytest.mark.parametrize("kind", ["FRAME", "E6POS"])
def test_a_position_stays_one_as_a_parameter_and_as_a_result(kind):
    rows = (
        f"{kind} F",
        "F={X 1000,Y 100,Z 1200,A 0,B 90,C 0}",
        "BAS(#TOOL,1)",
        "BAS(#BASE,1)",
        "LIN UP(F,2)",
    )
    text = krl(*rows) + FUNCTION.replace("FRAME", kind)
    tp = translated(text, "krl", "tp")
    assert not re.search(r"(?<!P)R\[\d+(:\w+)?\]=PR", tp)
    assert re.search(r"L PR\[\d+:temp_position\]", tp)
    assert "LOCAL FUNC robtarget UP(robtarget B,num H)" in translated(text, "krl", "rapid")


@pytest.mark.parametrize(
    ("target", "says"),
    [
        ("rapid", "B:=B XOR di4=1;"),
        ("tp", "IF ((R[1:B]<>0)<>DI[4]) THEN"),
        ("inform", "IFTHEN B000=0 ANDIF IN#(4)=ON"),
    ],
)
def test_just_one_of_two_conditions_is_no_exclusive_or_of_bits(target, says):
    text = krl("DECL BOOL B", "B=FALSE", "B=B EXOR $IN[4]", "$OUT[3]=B")
    assert says in translated(text, "krl", target)
    assert left_out(text, target) == []


def test_a_signal_by_a_computed_number_is_found_by_a_register_in_tp():
    text = krl(
        "DECL INT N",
        "N=2",
        "$OUT[N+8]=TRUE",
        "WAIT FOR $IN[N+10] AND NOT $IN[N]",
        "IF $IN[N+1] THEN",
        "HALT",
        "ENDIF",
    )
    written = translated(text, "krl", "tp")
    for row in (
        "R[2:temp_integer]=R[1:N]+8",
        "DO[R[2:temp_integer]]=ON",
        "WAIT (DI[R[2:temp_integer]] AND !DI[R[1:N]])",
    ):
        assert row in written
    for target in ("tp", "inform"):
        assert left_out(text, target) == []


def test_an_offset_along_the_tool_is_one_in_tp():
    text = krl(
        "BAS(#TOOL,1)",
        "BAS(#BASE,1)",
        "$VEL.CP=0.5",
        "LIN {X 1000,Y 0,Z 1200,A 0,B 90,C 0}",
        "LIN_REL {Z 50} #TOOL",
    )
    assert left_out(text, "tp") == []
    here, there = run(read(text, "krl"), robot=ROBOT), run_elsewhere(text, "krl", "tp")
    for plan in (here, there):
        x, y, z = plan.positions.position[int(plan.moves.target[-1])]
        assert (round(x, 6), round(y, 6), round(z, 6)) == (1.05, 0.0, 1.2)


def test_positions_of_a_list_are_found_by_a_computed_number_in_tp(tmp_path):
    rows = "\n".join(f"P[{n}]={{X 9{n}0,Y {n},Z 1200,A 0,B 90,C 0}}" for n in (1, 2, 3))
    (tmp_path / "part.dat").write_text(f"DEFDAT PART\nDECL E6POS P[3]\n{rows}\nENDDAT\n")
    (tmp_path / "part.src").write_text(
        "DEF PART( )\nINT N\nBAS(#TOOL,1)\nBAS(#BASE,1)\n$VEL.CP=0.5\nFOR N=1 TO 3\nLIN P[N]\nENDFOR\nEND\n"
    )
    program = link(read_file(tmp_path / "part.src")).program
    made = convert(program, "tp", Context(robot=ROBOT), date="2026/01/01 00:00")
    plan = run_converted(made, "tp", ROBOT, program)
    assert [round(plan.positions.position[int(at)][0], 6) for at in plan.moves.target] == [0.91, 0.92, 0.93]


# --- the mode as a choice, the frame that holds ---


MODES = ("SWITCH $MODE_OP ;which", "CASE #AUT,#EX", "$OUT[1]=TRUE", "CASE #T1", "SWITCH N", "CASE 1", "$OUT[2]=TRUE",
         "ENDSWITCH", "DEFAULT", "$OUT[3]=TRUE", "ENDSWITCH")  # fmt: skip


def test_a_choice_by_the_mode_is_a_chain_of_conditions():
    text = krl("DECL INT N", "N=1", *MODES)
    assert not [loss for loss in converted(text, "krl", "rapid").translated.losses if loss.leaves_out]
    written = translated(text, "krl", "rapid")
    assert "ELSEIF OpMode()=OP_MAN_PROG THEN" in written
    assert written.count("TEST N") == 1
    assert "which" in written


def test_a_choice_by_a_mode_that_no_other_controller_has_asks_for_it():
    rows = ("SWITCH $MODE_OP", "CASE #KRF", "$OUT[1]=TRUE", "ENDSWITCH")
    translated = converted(krl(*rows), "krl", "rapid").translated
    assert not [loss for loss in translated.losses if loss.leaves_out]
    assert translated.asks["set, all the time, what the source's controller tells of itself"] == ("$MODE_OP",)


HELD = (
    "DECL FRAME F", "DECL FRAME G", "BAS(#INITMOV,0)", "$TOOL={X 0,Y 0,Z 100,A 0,B 0,C 0}",
    "$BASE={X 100,Y 50,Z 0,A 10,B 0,C 0}", "PTP {A1 10,A2 -10,A3 20,A4 0,A5 40,A6 0}", "F=$BASE",
    "$BASE=F:{X 20,Y 0,Z 0,A 0,B 0,C 30}", "LIN {X 700,Y 0,Z 500,A 0,B 90,C 0}", "G=$TOOL", "$BASE=F",
    "$TOOL=G:{X 0,Y 0,Z 30,A 0,B 0,C 0}", "LIN {X 700,Y 20,Z 500,A 0,B 90,C 0}",
)  # fmt: skip


@pytest.mark.parametrize("target", ["rapid", "urscript"])
def test_the_frame_and_the_tool_that_hold_are_kept_and_set_again(target):
    text = krl(*HELD)
    assert not [loss for loss in converted(text, "krl", target).translated.losses if loss.leaves_out]
    here, there = read(text, "krl").plan(robot=ROBOT), run_elsewhere(text, "krl", target)
    found = compare_plans(here, there)
    assert found.steps == 3
    assert not [row for row in found.found if row.part in ("position", "orientation")]
    ends = here.positions.position[here.moves.target]
    assert np.linalg.norm(ends[2] - ends[1]) > 0.01


@pytest.mark.parametrize("row", ["again:", "IF $IN[1] THEN", "sub()"])
def test_a_frame_that_several_ways_may_have_set_stays_rejected(row):
    rows = [*HELD[:6], row, *(["$BASE=$NULLFRAME", "ENDIF"] if row[:2] == "IF" else []), "F=$BASE", "LIN F"]
    lost = [
        loss
        for loss in converted(krl(*rows), "krl", "rapid").translated.losses
        if "frame in use" in loss.says
    ]
    assert len(lost) == 1


# --- types that no file declares ---


def test_variables_of_types_that_no_file_declares_are_what_their_uses_tell():
    choices = ("IF E==#FAST THEN", "WAIT SEC 1", "ENDIF", "IF F==#SLOW THEN", "WAIT SEC 2", "ENDIF")
    rows = ("P.N=1", "P.H=P.N+0.5", "WAIT SEC P.H", "E=#FAST", *choices)
    text = krl("DECL PART_T P", "DECL MODE_T E", "DECL MODE_T F=#SLOW", *rows)
    losses = converted(text, "krl", "rapid").translated.losses
    assert not [loss for loss in losses if loss.leaves_out]
    assert {loss.says.split()[0] for loss in losses if "not declared here" in loss.says} == {
        "P_N",
        "P_H",
        "E",
    }
    assert run_elsewhere(text, "krl", "rapid").durations.tolist() == pytest.approx([1.5, 1, 2])


def test_a_type_that_a_file_declares_is_not_taken_for_unknown():
    text = krl("STRUC PART_T INT N", "DECL PART_T P", "P.N=2", "WAIT SEC P.N")
    assert not [
        loss for loss in converted(text, "krl", "rapid").translated.losses if "not declared" in loss.says
    ]


def test_members_of_records_of_unknown_types_are_copied_one_by_one():
    text = krl(
        "DECL PART_T P[5]", "P[1].N=1", "P[1].T.X=2", "P[2]=P[1]", "WAIT SEC P[2].N", "WAIT SEC P[2].T.X"
    )
    assert not [loss for loss in converted(text, "krl", "rapid").translated.losses if loss.leaves_out]
    assert run_elsewhere(text, "krl", "rapid").durations.tolist() == [1.0, 2.0]


NAMED_CLOCK = (
    "DECL CONST INT CYCLE=2",
    "$TIMER[CYCLE]=-2000",
    "$TIMER_STOP[CYCLE]=FALSE",
    "WAIT FOR $TIMER_FLAG[CYCLE] OR $IN[4]",
    "$TIMER_STOP[CYCLE]=TRUE",
    "IF $TIMER[CYCLE]>0 THEN",
    "$OUT[3]=TRUE",
    "ENDIF",
)


@pytest.mark.parametrize("target", ["rapid", "tp"])
def test_a_clock_whose_number_is_a_constant_is_the_clock_of_that_number(target):
    """A list of another file may declare the constant, so the reader cannot know it."""
    numbered = [row.replace("[CYCLE]", "[2]") for row in NAMED_CLOCK]
    plain = translated(krl(*numbered), "krl", target)
    assert translated(krl(*NAMED_CLOCK), "krl", target) == plain
    assert left_out(krl(*NAMED_CLOCK), target) == left_out(krl(*numbered), target)


def test_a_clock_whose_number_changes_is_left_out():
    rows = [NAMED_CLOCK[0].replace("CONST INT CYCLE=2", "INT CYCLE"), "CYCLE=2", NAMED_CLOCK[1]]
    losses = converted(krl(*rows), "krl", "tp").translated.losses
    assert [(loss.line, loss.fate) for loss in losses] == [(4, "commented")]


@pytest.mark.parametrize("target", ["rapid", "tp"])
def test_a_flag_of_a_clock_that_is_set_is_left_out_and_told(target):
    """RAPID got `ClkRead(clock2)>=2:=FALSE`."""
    text = krl(NAMED_CLOCK[1].replace("CYCLE", "2"), "$TIMER_FLAG[2]=FALSE", "WAIT FOR $TIMER_FLAG[2]")
    losses = converted(text, "krl", target).translated.losses
    assert [loss.line for loss in losses if loss.fate == "commented"] == [3]
    assert "FALSE;" not in translated(text, "krl", target).replace(
        "! not translated: $TIMER_FLAG[2]=FALSE", ""
    )
