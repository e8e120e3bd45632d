"""What programs ask of KUKA's controllers: settings, records, channels, forms without lists, interrupts."""

from __future__ import annotations

import pytest
from translated_texts import ROBOT, converted, krl, read, run_elsewhere, translated

from olp.transpile.compare import compare_plans
from olp.transpile.context import Fate

TARGETS = ("inform", "rapid", "tp", "urscript")
HOME = "PTP {A1 0,A2 -90,A3 90,A4 0,A5 20,A6 0}"
LINES = tuple(f"LIN {{X {x},Y 0,Z 900,A 0,B 90,C 0}}" for x in (900, 950, 1000))
FORMS = (
    "BAS(#INITMOV,0)", HOME, ";FOLD LIN P1 Vel=0.5 m/s CPDAT1 Tool[2] Base[3];%{PE}", "LDAT_ACT=LCPDAT1",
    "FDAT_ACT=FP1", "BAS(#CP_PARAMS,0.5)", "LIN XP1", ";ENDFOLD", ";FOLD PTP P2 CONT Vel=40 % PDAT1 Tool[2] Base[3]",
    "PDAT_ACT=PPDAT1", "FDAT_ACT=FP2", "BAS(#PTP_PARAMS,40)", "PTP XP2 C_PTP", ";ENDFOLD",
)  # fmt: skip


def left_out(text, target):
    losses = converted(text, "krl", target).translated.losses
    return {loss.line for loss in losses if loss.leaves_out and loss.fate is not Fate.EXACT}


# --- Forms without their lists ---


@pytest.mark.parametrize("target", TARGETS)
def test_forms_without_their_list_move_as_forms_begin_and_are_told(target):
    made = converted(krl(*FORMS), "krl", target)
    assert left_out(krl(*FORMS), target) == set()
    told = {loss.line: loss.says for loss in made.translated.losses if "form begins with" in loss.says}
    assert set(told) == {7, 13}
    assert "LCPDAT1" in told[7]
    assert "PPDAT1" in told[13]


def test_forms_without_their_list_are_those_with_the_values_that_forms_begin_with():
    data = (
        "DECL LDAT LCPDAT1={VEL 2.0,ACC 100.0,APO_DIST 100.0}", "DECL PDAT PPDAT1={VEL 100.0,ACC 100.0,APO_DIST 100.0}"
    )  # fmt: skip
    points = (
        "DECL E6POS XP1={X 900,Y 0,Z 900,A 0,B 90,C 0}",
        "DECL E6POS XP2={X 900,Y 200,Z 900,A 0,B 90,C 0}",
    )
    own = [row for row in FORMS if "FDAT" not in row]
    one, other = (read(krl(*points, *rows, *own), "krl").plan(robot=ROBOT) for rows in (data, ()))
    assert compare_plans(one, other).differences == []


@pytest.mark.parametrize("target", ["rapid", "tp"])
def test_a_form_whose_tool_nothing_tells_asks_for_its_number(target):
    made = converted(krl("FDAT_ACT=FP9", "BAS(#FRAMES)", "LIN XP9"), "krl", target)
    assert not [loss for loss in made.translated.losses if loss.leaves_out]
    assert "FP9_TOOL_NO" in str(made.translated.asks)


def test_an_acceleration_that_is_computed_is_set_before_its_move():
    rows = (
        "N=40",
        "$ACC_AXIS[1]=N",
        HOME,
        "N=70",
        "$ACC_AXIS[1]=N",
        "PTP {A1 30,A2 -90,A3 90,A4 0,A5 20,A6 0}",
    )
    text = krl("DECL INT N", *rows)
    assert translated(text, "krl", "rapid").count("AccSet joint_acceleration,100;") == 2
    one, other = read(text, "krl").plan(robot=ROBOT), run_elsewhere(text, "krl", "rapid")
    assert one.moves.acceleration.tolist() == pytest.approx(other.moves.acceleration.tolist())


# --- Settings that are read back ---

KEPT = (
    ("$VEL.CP=0.2", "OLD=$VEL.CP", "$VEL.CP=0.05", "$VEL.CP=OLD", (0.2, 0.05, 0.2)),
    ("BAS(#VEL_CP,0.3)", "OLD=$VEL.CP", "$VEL.CP=OLD/3", "$VEL.CP=OLD*2", (0.3, 0.1, 0.6)),
)


@pytest.mark.parametrize("target", TARGETS)
@pytest.mark.parametrize(("first", "read_back", "slower", "again", "speeds"), KEPT)
def test_a_speed_that_is_read_is_the_one_that_was_set(first, read_back, slower, again, speeds, target):
    text = krl("DECL REAL OLD", first, read_back, HOME, LINES[0], slower, LINES[1], again, LINES[2])
    assert left_out(text, target) == set()
    there = run_elsewhere(text, "krl", target)
    assert there.moves.travel[1:].tolist() == pytest.approx(speeds, rel=1e-3)


@pytest.mark.parametrize("target", ["rapid", "tp"])
def test_the_override_that_is_read_is_the_one_that_was_set(target):
    text = krl(
        "DECL INT OLD",
        "$OV_PRO=80",
        "OLD=$OV_PRO",
        "$OV_PRO=30",
        "WAIT SEC $OV_PRO",
        "$OV_PRO=OLD",
        "WAIT SEC OLD",
    )
    assert left_out(text, target) == set()
    assert run_elsewhere(text, "krl", target).durations.tolist() == [30.0, 80.0]


def test_the_speed_of_one_axis_is_not_read_as_that_of_all():
    text = krl("DECL REAL R", "$VEL_AXIS[1]=60", "$VEL_AXIS[3]=20", "R=$VEL_AXIS[3]", "WAIT SEC R")
    asked = converted(text, "krl", "rapid").translated.asks
    assert asked["set, all the time, what the source's controller tells of itself"] == ("$VEL_AXIS",)
    text = krl("DECL REAL R", "$VEL_AXIS[1]=60", "$VEL_AXIS[3]=60", "R=$VEL_AXIS[3]", "WAIT SEC R")
    assert run_elsewhere(text, "krl", "rapid").durations.tolist() == [60.0]


def test_an_override_that_the_program_never_sets_has_to_be_told():
    translated_ = converted(krl("DECL INT N", "N=$OV_PRO", "WAIT SEC N"), "krl", "rapid").translated
    told = {loss.fate for loss in translated_.losses if "taken for 100 %" in loss.says}
    assert told == {Fate.APPROXIMATED}


def test_blends_and_accelerations_that_are_read_are_in_krls_units():
    rows = ("$APO.CDIS=25", "R=$APO.CDIS", "WAIT SEC R", "$ACC.CP=1.5", "R=$ACC.CP", "WAIT SEC R", "BAS(#ACC_CP,50)",
            "WAIT SEC $ACC.CP", "$VEL.ORI1=120", "WAIT SEC $VEL.ORI1")  # fmt: skip
    durations = run_elsewhere(krl("DECL REAL R", *rows), "krl", "rapid").durations.tolist()
    assert durations == pytest.approx([25.0, 1.5, 1.15, 120.0])


@pytest.mark.parametrize("target", ["rapid", "tp"])
def test_the_home_position_of_the_controller_is_the_one_that_was_set(target):
    text = krl("DECL E6AXIS XH", "XH={A1 10,A2 -80,A3 90,A4 0,A5 20,A6 0}", HOME, "$H_POS=XH", "PTP $H_POS")
    assert left_out(text, target) == set()
    one, other = read(text, "krl").plan(robot=ROBOT), run_elsewhere(text, "krl", target)
    assert other.positions.axes[other.moves.target[-1]][:2] == pytest.approx(
        [0.17453292, -1.3962634], abs=1e-6
    )
    assert len(one) == len(other)


@pytest.mark.parametrize("target", TARGETS)
@pytest.mark.parametrize("row", ["$VEL_AXIS[3]=20", "$ACC_AXIS[2]=40", "$VEL.ORI2=100"])
def test_speeds_of_single_axes_are_comments_that_are_told(row, target):
    made = converted(krl("BAS(#INITMOV,0)", row, HOME), "krl", target)
    assert {loss.fate for loss in made.translated.losses if loss.line == 3} == {Fate.APPROXIMATED}
    assert f"not translated: {row}".encode() in b"".join(made.files.values()).replace(b" ;", b"")


# --- Records of the controller's own types ---


@pytest.mark.parametrize("target", TARGETS)
def test_motion_data_of_a_program_are_records(target):
    rows = (
        "DECL LDAT L1", "DECL FDAT F1", "L1={VEL 0.5,ACC 80.0,APO_DIST 20.0}", "L1.VEL=0.25", "LDAT_ACT=L1",
        "WAIT SEC L1.VEL", "WAIT SEC LDAT_ACT.ACC/100",
    )  # fmt: skip
    text = krl(*rows)
    assert left_out(text, target) == set()
    assert run_elsewhere(text, "krl", target).durations.tolist() == pytest.approx([0.25, 0.8])


@pytest.mark.parametrize("target", ["rapid", "tp", "urscript"])
def test_an_aggregate_sets_the_members_that_it_names(target):
    text = krl("STRUC PART_T INT N,REAL H,CHAR T[20]", "DECL PART_T P", "P={N 1,H 2.5,T[] \"a\"}", "P={H 0.5}",
               "SETS(P,4)", "WAIT SEC P.N", "WAIT SEC P.H")  # fmt: skip
    text += "DEF SETS(P:OUT,N:IN)\r\nDECL PART_T P\r\nINT N\r\nP.N=N\r\nEND\r\n"
    assert left_out(text, target) == set()
    assert run_elsewhere(text, "krl", target).durations.tolist() == pytest.approx([4.0, 0.5])


# --- Channels, options ---


@pytest.mark.parametrize("target", TARGETS)
def test_channels_are_calls_and_the_states_that_they_set_are_handed_over(target):
    rows = (
        "DECL INT H,N", "DECL STATE_T S", "DECL MODUS_T M", "DECL REAL T", "COPEN(:SER_1,H)", 'CWRITE(H,S,M,"%s","GO")',
        'CREAD(H,S,M,T,N,"%d",N)', "IF S.RET1==#DATA_OK THEN", "HALT", "ENDIF", "CCLOSE(H,S)",
    )  # fmt: skip
    made = converted(krl(*rows), "krl", target)
    assert left_out(krl(*rows), target) == set()
    assert {loss.line for loss in made.translated.losses if loss.part == "call"} == {6, 7, 8, 12}
    if target == "rapid":
        assert b'CREAD H,S_RET1,M,T,N,"%d",N;' in b"".join(made.files.values())


@pytest.mark.parametrize(
    "row",
    [
        "P00(#EXT_PGNO,#PGNO_GET,DMY[],0)",
        "H50(2)",
        'MsgDialog(N,"Go on?","CELL","","Yes","No")',
        "ArcMainNG(#ArcOnBeforeMoveStd,N,N)",
    ],
)
def test_routines_of_options_are_called_by_their_names(row):
    losses = converted(krl("DECL INT N", row), "krl", "rapid").translated.losses
    assert {loss.fate for loss in losses if loss.line == 3} == {Fate.APPROXIMATED}


def test_a_call_that_leaves_an_argument_out_is_no_text_that_rapid_loads():
    """It was written with the gap, `"CELL",,"Yes"`, and told as approximated."""
    losses = converted(
        krl("DECL INT N", 'MsgDialog(N,"Go on?","CELL",,"Yes","No")'), "krl", "rapid"
    ).translated.losses
    assert {loss.fate for loss in losses if loss.line == 3} == {Fate.COMMENTED}


def test_sensor_corrections_stay_rejected():
    assert left_out(krl("DECL INT N", "N=RSI_ON(#RELATIVE)", "RSI_MOVECORR()"), "rapid") == {3, 4}


@pytest.mark.parametrize("target", ["rapid", "tp"])
def test_texts_are_compared_with_their_capitals(target):
    rows = ('A[]="abc"', 'B[]="abd"', "IF StrComp(A[],B[],#CASE_SENS) THEN", "WAIT SEC 1", "ENDIF", 'B[]="abc"',
            "IF StrComp(A[],B[],#CASE_SENS) THEN", "WAIT SEC 2", "ENDIF")  # fmt: skip
    text = krl("DECL CHAR A[9],B[9]", *rows)
    assert left_out(text, target) == set()
    assert run_elsewhere(text, "krl", target).durations.tolist() == [2.0]


@pytest.mark.parametrize("target", TARGETS)
def test_bits_of_numbers_are_computed_and_inverted_ones_are_a_subtraction(target):
    text = krl("DECL INT A,B", "A='H5B'", "B=A B_AND 'B01101100'", "WAIT SEC B", "B=A B_OR 4", "WAIT SEC B",
               "B=A B_EXOR 255", "WAIT SEC B", "B=B_NOT A", "WAIT SEC B+100")  # fmt: skip
    assert left_out(text, target) == set()
    assert run_elsewhere(text, "krl", target).durations.tolist() == [72.0, 95.0, 164.0, 8.0]


@pytest.mark.parametrize("row", ["ASYPTP {E1 90}", "ASYCONT 2", "ASYSTOP", "ASYCANCEL 2"])
def test_asynchronous_axes_are_kept_and_left_out_where_they_would_have_to_move(row):
    assert left_out(krl(row, "WAIT SEC 1"), "rapid") == {2}


# --- Interrupts ---

STOPS = "DEF HIT()\r\nBRAKE F\r\nINTERRUPT OFF 20\r\n$OUT[7]=TRUE\r\nEND\r\n"
WATCHED = ("INTERRUPT DECL 20 WHEN $IN[5]==TRUE DO HIT()", "INTERRUPT ON 20", LINES[0], "INTERRUPT OFF 20")
EDGES = (
    ("$IN[5]", "ISignalDI di5,1,watch_20;"), ("$IN[5]==TRUE", "ISignalDI di5,1,watch_20;"),
    ("NOT $IN[5]", "ISignalDI di5,0,watch_20;"), ("$IN[5]<>TRUE", "ISignalDI di5,0,watch_20;"),
    ("$OUT[3]==FALSE", "ISignalDO do3,0,watch_20;"), ("(NOT $FLAG[2])==FALSE", "ISignalDO flag2,1,watch_20;"),
)  # fmt: skip


@pytest.mark.parametrize(("condition", "row"), EDGES)
def test_an_interrupt_of_one_signal_is_a_trap_of_its_edge(condition, row):
    text = krl(WATCHED[0].replace("$IN[5]==TRUE", condition), *WATCHED[1:]) + STOPS
    written = translated(text, "krl", "rapid")
    body = [line.strip() for line in written.splitlines()]
    assert body[body.index("CONNECT watch_20 WITH trap_20;") + 1] == row
    assert [line for line in body if line.startswith(("IWatch", "ISleep"))] == [
        "ISleep watch_20;", "IWatch watch_20;", "ISleep watch_20;", "ISleep watch_20;",
    ]  # fmt: skip
    assert body[body.index("TRAP trap_20") + 1 :][:3] == ["HIT;", "StartMove;", "ENDTRAP"]
    assert body.index("StopMove;") < body.index("SetDO do7,1;")


def test_an_interrupt_is_told_for_no_run_lets_it_happen():
    made = converted(krl(*WATCHED) + STOPS, "krl", "rapid")
    assert {(loss.line, loss.fate) for loss in made.translated.losses if loss.part == "order"} == {
        (2, Fate.APPROXIMATED)
    }
    assert ("HIT",) in made.translated.asks.values()
    here, there = (
        read(krl(*WATCHED) + STOPS, "krl").plan(robot=ROBOT),
        run_elsewhere(krl(*WATCHED) + STOPS, "krl", "rapid"),
    )
    assert compare_plans(here, there).worst_position < 1e-6


def test_an_interrupt_of_several_signals_asks_its_condition_at_each_change():
    text = krl(WATCHED[0].replace("$IN[5]==TRUE", "$IN[5] AND NOT $IN[6]"), *WATCHED[1:]) + STOPS
    written = translated(text, "krl", "rapid")
    assert "ISignalDI di5,2,watch_20_1;" in written
    assert "ISignalDI di6,2,watch_20_2;" in written
    assert "IF di5=1 AND di6=0 THEN" in written.split("TRAP trap_20")[1]


def test_a_routine_that_moves_keeps_the_path_and_goes_back_to_it():
    routine = STOPS.replace("$OUT[7]=TRUE", f"{HOME}\r\nPTP $POS_RET")
    made = converted(krl(*WATCHED) + routine, "krl", "rapid")
    written = b"".join(made.files.values()).decode()
    assert (
        written.index("StopMove;")
        < written.index("StorePath;")
        < written.index("RestoPath;")
        < written.index("StartMove;")
    )
    assert not [loss for loss in made.translated.losses if loss.leaves_out]


NO_TRAPS = (
    ("$IN[5]", "RESUME"),  # the move is given up
    ("N>3", "$OUT[7]=TRUE"),  # no signal
    ("$TIMER_FLAG[2]", "$OUT[7]=TRUE"),
)


@pytest.mark.parametrize(("condition", "deed"), NO_TRAPS)
def test_what_no_trap_does_stays_left_out_and_its_neighbours_do_not(condition, deed):
    other = ("INTERRUPT DECL 21 WHEN $IN[9] DO OTHER()", "INTERRUPT ON 21")
    text = krl("DECL INT N", WATCHED[0].replace("$IN[5]==TRUE", condition), *other, *WATCHED[1:])
    text += STOPS.replace("$OUT[7]=TRUE", deed) + "DEF OTHER()\r\n$OUT[8]=TRUE\r\nEND\r\n"
    assert {3, 6, 8} <= left_out(text, "rapid")
    assert left_out(text, "rapid").isdisjoint({4, 5})


def test_what_an_interrupt_hands_over_is_there_for_its_trap():
    text = krl(
        "DECL POS P",
        "DECL INT N",
        "INTERRUPT DECL 20 WHEN $IN[5] DO HIT(P,N)",
        "INTERRUPT ON",
        *LINES,
        "WAIT SEC N",
    )
    text += "DEF HIT(P:OUT,N:OUT)\r\nDECL POS P\r\nDECL INT N\r\nBRAKE\r\nP=$POS_INT\r\nN=1\r\nEND\r\n"
    written = translated(text, "krl", "rapid")
    assert written.index("VAR num N;") < written.index("PROC")
    assert "P2:=CRobT(" in written or "P:=CRobT(" in written
    assert left_out(text, "rapid") == set()


@pytest.mark.parametrize("target", ["inform", "tp", "urscript"])
def test_interrupts_are_left_out_where_there_are_no_traps(target):
    assert {2, 3, 5} <= left_out(krl(*WATCHED) + STOPS, target)


# --- Places of FANUC and INFORM ---


PALLET = (
    "DECL INT I,J", "DECL FRAME F", "DECL E6POS B,P", "B={X 900,Y -100,Z 700,A 20,B 80,C 10}",
    "FOR I=0 TO 1", "FOR J=0 TO 2", "F={X 0,Y 0,Z 0,A 0,B 0,C 0}", "F.X=I*100.0", "F.Y=J*80.5", "P=F:B", "LIN P",
    "F.Z=25", "P=F:P", "LIN P", "ENDFOR", "ENDFOR",
)  # fmt: skip


@pytest.mark.parametrize("target", ["inform", "tp"])
def test_a_frame_that_never_turns_moves_a_position_element_by_element(target):
    text = krl(HOME, *PALLET)
    assert left_out(text, target) == set()
    one, other = read(text, "krl").plan(robot=ROBOT), run_elsewhere(text, "krl", target)
    found = compare_plans(one, other, speeds=False)
    assert found.steps == 13
    assert found.worst_position < 1e-6
    assert found.worst_angle < 1e-6


def test_a_frame_that_only_a_list_or_the_pendant_sets_may_turn():
    data = "DECL FRAME F={X 1,Y 2,Z 3,A 0,B 0,C 0}"
    text = krl(
        data, "DECL E6POS B,P", "B={X 900,Y -100,Z 700,A 20,B 80,C 10}", "P=F:B", "F.X=5", "P=F:B", "LIN P"
    )
    assert translated(text, "krl", "tp").count("CALL POSE_PRODUCT") == 2


@pytest.mark.parametrize("turn", ["F.A=5", "F={X 1,Y 2,Z 3,A 0,B 0,C 90}", "F=$POS_ACT", "TURNS(F)"])
def test_a_frame_that_may_turn_is_no_sum_of_elements(turn):
    row = PALLET.index("P=F:B")
    text = (
        krl(HOME, *PALLET[:row], turn, *PALLET[row:]) + "DEF TURNS(F:OUT)\r\nDECL FRAME F\r\nF.A=3\r\nEND\r\n"
    )
    assert left_out(text, "tp") == set()
    assert translated(text, "krl", "tp").count("CALL POSE_PRODUCT") == 2
    found = compare_plans(read(text, "krl").plan(robot=ROBOT), run_elsewhere(text, "krl", "tp"), speeds=False)
    assert found.steps == 13
    assert found.worst_position < 1e-6
    assert found.worst_angle < 1e-6


@pytest.mark.parametrize("target", ["inform", "tp"])
def test_where_the_arm_stands_is_handed_in_a_position(target):
    written = translated(krl("OPENG($POS_ACT)"), "krl", target)
    assert ("PR[1:temp_position]=LPOS" if target == "tp" else "SET P001 P000") in written
    assert ("CALL OPENG(PR[1:temp_position])" if target == "tp" else "ARGFP001") in written


def test_axes_and_the_flange_itself_are_registers_of_fanuc():
    rows = ("R=$AXIS_ACT.A5", "WAIT SEC R", "T={X 0,Y 0,Z 100,A 0,B 0,C 0}", "$TOOL=T", LINES[0], "T.Z=50", "$TOOL=T",
            LINES[1], "$TOOL=$NULLFRAME", LINES[2])  # fmt: skip
    text = krl("DECL REAL R", "DECL FRAME T", HOME, *rows)
    assert left_out(text, "tp") == set()
    one, other = read(text, "krl").plan(robot=ROBOT), run_elsewhere(text, "krl", "tp")
    assert other.durations.tolist() == pytest.approx([20.0], abs=1e-3)
    found = compare_plans(one, other, speeds=False)
    assert found.worst_position < 1e-5
    assert not [row for row in found.found if row.part in ("position", "orientation", "tool")]
