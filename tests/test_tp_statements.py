"""FANUC TP instructions: every shape that manuals and published listings show, and what it means."""

from __future__ import annotations

from dataclasses import replace

import pytest
from tp_listings import HEAD, body, listing, one, read

from olp.core.diagnostic import OlpError
from olp.ir.expressions import (
    Argument,
    Binary,
    Compare,
    FrameRef,
    Function,
    Item,
    Logic,
    Member,
    Named,
    Number,
    Quantity,
    Signal,
    SignalState,
    Store,
    SystemValue,
    Taught,
    Text,
    Unary,
    Variable,
)
from olp.ir.program import (
    Assign,
    Blend,
    BlendKind,
    Call,
    Case,
    Comment,
    Default,
    Disabled,
    Dwell,
    Else,
    EndIf,
    EndSwitch,
    For,
    If,
    Jump,
    Label,
    LineKind,
    Message,
    Move,
    Next,
    Opaque,
    Path,
    Pause,
    Process,
    PulseOutput,
    Return,
    SetFrame,
    SetOutput,
    SetOverride,
    SetTool,
    Speed,
    SpeedUnit,
    StartTask,
    Switch,
    Wait,
)
from olp.languages.lark_host import values_of
from olp.languages.vendors.tp import instructions
from olp.languages.vendors.tp.grammar import instruction_parser
from olp.runtime.assumptions import Assumptions, SignalKey
from olp.runtime.interpreter import run
from olp.transpile.convert import export

FINE = Blend(BlendKind.RADIUS, Quantity(Number(0), 0.001), "FINE")
P1, P2 = Taught(Store.ROBOT, 1), Taught(Store.ROBOT, 2)


def r(number, name=""):
    return Variable(Store.REAL, Number(number), name=name)


def pr(number):
    return Variable(Store.ROBOT, Number(number))


def signal(bus, number):
    return Signal(bus, Number(number))


def is_on(bus, number):
    return Compare("=", signal(bus, number), SignalState(True))


def speed(unit, value, scale):
    return Speed(unit, Quantity(Number(value), scale))


LINE = speed(SpeedUnit.TRAVEL, 100, 0.001)


# --- motion ---------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("text", "unit", "value", "si"),
    [
        ("50%", SpeedUnit.FRACTION, 50, 0.5),
        ("250mm/sec", SpeedUnit.TRAVEL, 250, 0.25),
        ("120.5mm/sec", SpeedUnit.TRAVEL, 120.5, 0.1205),
        ("90cm/min", SpeedUnit.TRAVEL, 90, 0.015),
        ("30inch/min", SpeedUnit.TRAVEL, 30, 0.0127),
        ("45deg/sec", SpeedUnit.TURN, 45, 0.7853981633974483),
        ("2.5sec", SpeedUnit.TIME, 2.5, 2.5),
        ("800msec", SpeedUnit.TIME, 800, 0.8),
    ],
)
def test_a_speed_has_its_unit(text, unit, value, si):
    move = one(f"L P[1] {text} FINE")
    assert move.speed.unit is unit
    assert move.speed.value.written == Number(value)
    assert move.speed.value.literal == pytest.approx(si, rel=1e-12)


def test_a_speed_in_a_register_keeps_its_unit():
    assert one("J P[1] R[3:quick]% FINE").speed == Speed(SpeedUnit.FRACTION, Quantity(r(3), 0.01))
    assert one("L P[1] R[3]mm/sec FINE").speed == Speed(SpeedUnit.TRAVEL, Quantity(r(3), 0.001))
    assert one("L P[1] R[3]sec CNT0").speed == Speed(SpeedUnit.TIME, Quantity(r(3), 1.0))
    assert one("L P[1] AR[2]mm/sec FINE").speed.value.written == Argument(2)


def test_speeds_that_are_no_numbers_have_a_name():
    assert one("L P[1] WELD_SPEED CNT100").speed.native == "WELD_SPEED"
    assert one("L P[1] max_speed CNT100").speed == Speed(
        SpeedUnit.TRAVEL, Quantity(Number(2000.0), 0.001), "max_speed"
    )


@pytest.mark.parametrize(
    ("text", "blend"),
    [
        ("FINE", FINE),
        ("CNT100", Blend(BlendKind.SPEED, Quantity(Number(100), 0.01))),
        ("CNT0", Blend(BlendKind.SPEED, Quantity(Number(0), 0.01))),
        ("CNT R[4]", Blend(BlendKind.SPEED, Quantity(r(4), 0.01))),
        ("CR25", Blend(BlendKind.RADIUS, Quantity(Number(25), 0.001), "CR")),
        ("CR5,10", Blend(BlendKind.RADIUS, Quantity(Number(5), 0.001), "CR,10")),
        ("CD40", Blend(BlendKind.RADIUS, Quantity(Number(40), 0.001), "CD")),
    ],
)
def test_a_corner_is_what_its_word_says(text, blend):
    assert one(f"L P[1] 100mm/sec {text}") == Move(0, Path.LINEAR, (P1,), LINE, blend)


def test_every_letter_is_a_path():
    assert one("J P[1] 100% FINE").path is Path.JOINT
    assert one("A P[1] 100mm/sec FINE") == Move(0, Path.CIRCULAR, (P1,), LINE, FINE)
    assert one("S P[1] 100mm/sec FINE").path is Path.SPLINE
    assert one("C P[1] P[2] 100mm/sec FINE") == Move(0, Path.CIRCULAR, (P2,), LINE, FINE, via=P1)


def test_an_arc_goes_on_in_its_second_line():
    text = HEAD + "   1:C P[1]    \n    :  P[2] 100mm/sec FINE    ;\n/POS\n/END\n"
    program = read(text)
    (move,) = program.routines[0].body
    assert (move.via, move.targets, move.line) == (P1, (P2,), 8)
    assert program.line_kinds[8] == LineKind.STATEMENT


def test_options_of_a_move():
    move = one("L P[1:a b,c] 100mm/sec FINE ACC80 Offset,PR[3] Tool_Offset,PR[4:x]")
    assert move == Move(
        0,
        Path.LINEAR,
        (P1,),
        LINE,
        FINE,
        acceleration=Quantity(Number(80), 0.01),
        offset=pr(3),
        tool_offset=pr(4),
    )
    assert one("L PR[7] 100mm/sec FINE INC").relative == FrameRef("own")
    assert one("L P[1] 100mm/sec FINE ACC R[2]").acceleration == Quantity(r(2), 0.01)


@pytest.mark.parametrize(
    ("text", "other"),
    [
        ("COORD PTH", (("COORD", Text("")), ("PTH", Text("")))),
        ("TB   .10sec,CALL OPEN", (("TB", Text(" .10sec,CALL OPEN")),)),
        ("TA .5sec,DO[1]=PULSE,0.5sec", (("TA", Text(" .5sec,DO[1]=PULSE,0.5sec")),)),
        ("Skip,LBL[7] BREAK", (("Skip", Text(",LBL[7]")), ("BREAK", Text("")))),
        ("DB   10.0mm,CALL X(1,2)", (("DB", Text(" 10.0mm,CALL X(1,2)")),)),
        ("EV50% Wjnt", (("EV", Text("50%")), ("Wjnt", Text("")))),
        ("RTCP Offset", (("RTCP", Text("")), ("Offset", Text("")))),
        ("Arc Start[3]", (("Arc", Text(" Start[3]")),)),
    ],
)
def test_options_that_are_not_modelled_stay_on_the_move(text, other):
    assert one(f"L P[1] 100mm/sec CNT50 {text}").other == other


def test_an_option_behind_a_kept_one_still_counts():
    move = one("L P[1] 100mm/sec CNT50 TB .10sec,P-SPS Offset,PR[11]")
    assert (move.offset, move.other) == (pr(11), (("TB", Text(" .10sec,P-SPS")),))


def test_a_computed_point_and_a_computed_register():
    assert one("J PR[R[1]] 50% FINE").targets == (Variable(Store.ROBOT, r(1)),)
    assert one("J P[R[1:which]] 50% FINE").targets == (Function("taught", (r(1),)),)


# --- values ---------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("text", "target", "value"),
    [
        ("R[1:a, b/c]=5", r(1), Number(5)),
        ("R[1]=(-2.5)", r(1), Number(-2.5)),
        ("R[1]=-.384", r(1), Number(-0.384)),
        ("R[1]=R[2]+R[3]", r(1), Binary("+", r(2), r(3))),
        ("R[1]=R[2] DIV 3", r(1), Binary("div", r(2), Number(3))),
        ("R[1]=R[2] MOD 3", r(1), Binary("mod", r(2), Number(3))),
        ("R[1]=(R[2]+R[3]*4)", r(1), Binary("+", r(2), Binary("*", r(3), Number(4)))),
        ("R[1]=GI[4]", r(1), signal("in-group", 4)),
        ("R[R[5]]=AR[2]", Variable(Store.REAL, r(5)), Argument(2)),
        ("R[1]=TIMER[3]", r(1), SystemValue("timer", 3)),
        ("R[1]=ATAN2[R[2],R[3]]", r(1), Function("atan2", (r(2), r(3)))),
        ("R[1]=STRLEN SR[4]", r(1), Function("length-of-text", (Variable(Store.STRING, Number(4)),))),
        ("PR[1]=LPOS", pr(1), SystemValue("current-pose")),
        ("PR[1]=JPOS", pr(1), SystemValue("current-joints")),
        ("PR[1]=P[2]", pr(1), P2),
        ("PR[1]=PR[2]+PR[3]", pr(1), Binary("+", pr(2), pr(3))),
        ("PR[4,1:lift]=10", Member(pr(4), "x"), Number(10)),
        ("PR[4,6]=PR[5,4]", Member(pr(4), "rz"), Member(pr(5), "rx")),
        ("PR[4,7]=1", Member(pr(4), "e1"), Number(1)),
        ("PR[4,R[1]]=1", Item(pr(4), (r(1),)), Number(1)),
        ("PR[GP1:1,3:x]=1", Member(pr(1), "z"), Number(1)),
        ("PR[GP2:1,1]=1", Member(Variable(Store.STATION, Number(1)), "x"), Number(1)),
        ("UFRAME[2]=PR[3]", FrameRef("user", Number(2)), pr(3)),
        ("UTOOL[R[1]]=PR[3]", FrameRef("tool", r(1)), pr(3)),
        ("$WAITTMOUT=200", Named("$WAITTMOUT"), Number(200)),
        ("$SCR_GRP[1].$MCH_POS_X=R[1]", Named("$SCR_GRP[1].$MCH_POS_X"), r(1)),
    ],
)
def test_an_assignment(text, target, value):
    assert one(text) == Assign(0, target, value)


def test_names_in_brackets_stay_with_their_registers():
    statement = one("R[1:count]=R[2:left, right]")
    assert (statement.target.name, statement.value.name) == ("count", "left, right")


@pytest.mark.parametrize(
    ("word", "bus"),
    [
        ("DO", "out"),
        ("RO", "robot-out"),
        ("GO", "out-group"),
        ("AO", "analog-out"),
        ("SO", "panel-out"),
        ("UO", "system-out"),
        ("F", "flag"),
        ("M", "marker"),
    ],
)
def test_outputs(word, bus):
    assert one(f"{word}[3:grip]=(ON)") == SetOutput(0, signal(bus, 3), SignalState(True))


def test_outputs_take_values_conditions_and_pulses():
    assert one("DO[1]=OFF") == SetOutput(0, signal("out", 1), SignalState(False))
    assert one("GO[1]=R[2]") == SetOutput(0, signal("out-group", 1), r(2))
    assert one("DO[1]=(!RI[2])") == SetOutput(0, signal("out", 1), Unary("not", signal("robot-in", 2)))
    assert one("DO[1]=PULSE,0.5sec") == PulseOutput(0, signal("out", 1), Quantity(Number(0.5), 1.0))
    assert one("DO[1]=PULSE") == PulseOutput(0, signal("out", 1))


def test_logic_binds_and_before_or_and_not_before_both():
    a, b, c = (signal("in", n) for n in (1, 2, 3))
    assert one("WAIT (DI[1] OR DI[2] AND !DI[3])") == Wait(
        0, Logic(a, (("or", Logic(b, (("and", Unary("not", c)),))),))
    )
    assert one("WAIT ((DI[1] OR DI[2]) AND DI[3])") == Wait(0, Logic(Logic(a, (("or", b),)), (("and", c),)))
    assert one("WAIT DI[1]=ON AND DI[2]=ON AND DI[3]=ON").condition == Logic(
        is_on("in", 1), (("and", is_on("in", 2)), ("and", is_on("in", 3)))
    )


# --- time and flow --------------------------------------------------------------------------------------


def test_waits():
    assert one("WAIT    .50(sec)") == Dwell(0, Quantity(Number(0.5), 1.0))
    assert one("WAIT R[3]") == Dwell(0, Quantity(r(3), 1.0))
    assert one("WAIT DI[2:part, left]=ON") == Wait(0, is_on("in", 2))
    assert one("WAIT R[1]>=3") == Wait(0, Compare(">=", r(1), Number(3)))


def test_a_wait_with_a_timeout_jumps_when_the_time_is_over():
    wait, jump, _ = body("WAIT DI[2]=ON TIMEOUT,LBL[9]", "LBL[9]")
    assert wait == Wait(0, is_on("in", 2), Quantity(Named("$WAITTMOUT"), 0.01))
    assert jump == Jump(0, "9", SystemValue("timed-out"))


def test_the_usual_timeout_is_declared_where_it_is_used():
    (declared,) = read(listing("WAIT DI[2]=ON TIMEOUT,LBL[9]", "LBL[9]")).data
    assert (declared.name, declared.value) == ("$WAITTMOUT", Number(3000))
    assert read(listing("LBL[9]")).data == ()


def test_jumps_and_labels():
    assert body("LBL[3:far away]", "JMP LBL[3]", "JMP LBL[R[1]]", "IF R[1]>2,JMP LBL[3]") == [
        Label(0, "3", "far away"),
        Jump(0, "3"),
        Jump(0, r(1)),
        Jump(0, "3", Compare(">", r(1), Number(2))),
    ]


def test_calls():
    assert one("CALL PICK") == Call(0, "PICK")
    assert one("CALL PICK(1,R[2],'left',(-3))") == Call(
        0, "PICK", (Number(1), r(2), Text("left"), Number(-3))
    )
    assert one("IF DI[1]=ON,CALL PICK(AR[1])") == Call(0, "PICK", (Argument(1),), is_on("in", 1))
    assert one("RUN LOGGER") == StartTask(0, "LOGGER", "LOGGER")
    assert one("CALL SR[3](R[1])") == Process(
        0, "CALL", (("", Variable(Store.STRING, Number(3))), ("", r(1)))
    )


def test_a_line_that_reads_like_a_macro_is_a_call():
    call = one("OPEN HAND 1")
    assert call == Call(0, "OPEN HAND 1")
    assert call.spelling == "macro"
    assert one("Vacuum on(R[2],3)") == Call(0, "Vacuum on", (r(2), Number(3)))


def test_blocks():
    assert body("IF (DI[1]) THEN", "R[1]=1", "ELSE", "R[1]=2", "ENDIF") == [
        If(0, signal("in", 1)),
        Assign(0, r(1), Number(1)),
        Else(0),
        Assign(0, r(1), Number(2)),
        EndIf(0),
    ]
    assert body("FOR R[1]=1 TO R[2]", "ENDFOR", "FOR R[1]=9 DOWNTO 1", "ENDFOR") == [
        For(0, r(1), Number(1), r(2)),
        Next(0, None),
        For(0, r(1), Number(9), Number(1), Number(-1)),
        Next(0, None),
    ]
    assert body("IF (DI[1]),R[1]=(2)") == [If(0, signal("in", 1)), Assign(0, r(1), Number(2)), EndIf(0)]


def test_select_ends_where_its_cases_end():
    statements = body(
        "SELECT R[1:which]=1,JMP LBL[1]", "       =2,CALL PICK", "       ELSE,JMP LBL[1]", "R[2]=0", "LBL[1]"
    )
    assert statements == [
        Switch(0, r(1)),
        Case(0, (Number(1),)),
        Jump(0, "1"),
        Case(0, (Number(2),)),
        Call(0, "PICK"),
        Default(0),
        Jump(0, "1"),
        EndSwitch(0),
        Assign(0, r(2), Number(0)),
        Label(0, "1"),
    ]


def test_a_move_ends_a_select():
    kinds = [type(s) for s in body("SELECT R[1]=1,CALL A", "J P[1] 50% FINE")]
    assert kinds == [Switch, Case, Call, EndSwitch, Move]


def test_frames_tools_and_override():
    assert body("UFRAME_NUM=2", "UFRAME_NUM=0", "UTOOL_NUM=R[1]", "OVERRIDE=30%") == [
        SetFrame(0, FrameRef("user", Number(2))),
        SetFrame(0, FrameRef("base")),
        SetTool(0, FrameRef("tool", r(1))),
        SetOverride(0, Quantity(Number(30), 0.01)),
    ]


def test_the_rest():
    assert body("END", "PAUSE", "MESSAGE[a, b: ]]", "!note", "--eg:long note", "//L P[9] 1mm/sec FINE") == [
        Return(0),
        Pause(0),
        Message(0, Text("a, b: ]")),
        Comment(0, "note"),
        Comment(0, "--eg:long note"),
        Disabled(0, "L P[9] 1mm/sec FINE"),
    ]


@pytest.mark.parametrize(
    ("text", "name", "rest"),
    [
        ("Arc Start[1]", "Arc Start", "[1]"),
        ("Weave Sine[2]", "Weave Sine", "[2]"),
        ("UALM[3]", "UALM", "[3]"),
        ("PAYLOAD[1:spray]", "PAYLOAD", "[1:spray]"),
        ("COL DETECT ON", "COL DETECT", "ON"),
        ("UFRAME_NUM[GP2]=1", "UFRAME_NUM", "[GP2]=1"),
        ("LINEAR_MAX_SPEED=100", "LINEAR_MAX_SPEED", "=100"),
    ],
)
def test_process_instructions(text, name, rest):
    assert one(text) == Process(0, name, (("", Text(rest)),))


def test_clocks_and_conditions_of_moves():
    assert one("TIMER[2]=START") == Assign(0, SystemValue("timer-running", 2), SignalState(True))
    assert one("TIMER[2]=STOP") == Assign(0, SystemValue("timer-running", 2), SignalState(False))
    assert one("TIMER[2]=RESET") == Assign(0, SystemValue("timer", 2), Number(0))
    assert one("TIMER[R[1]]=STOP") == Process(0, "TIMER", (("", r(1)), ("", Text("STOP"))))
    assert one("SKIP CONDITION DI[1]=ON") == Process(0, "SKIP CONDITION", (("", is_on("in", 1)),))
    assert one("OFFSET CONDITION PR[1]") == Process(0, "OFFSET CONDITION", (("", pr(1)),))
    assert one("ABORT") == Process(0, "ABORT")


@pytest.mark.parametrize(("edge", "states"), [("ON+", (False, True)), ("OFF-", (True, False))])
def test_an_edge_is_waited_for_from_the_other_state_on(edge, states):
    assert [s.condition for s in body(f"WAIT DI[1]={edge}")] == [
        replace(is_on("in", 1), right=SignalState(on)) for on in states
    ]


def test_the_time_of_a_wait_for_an_edge_counts_once():
    cell = Assumptions(waits={SignalKey("in", 1): 1.5})
    plan = run(read(listing("WAIT DI[1]=ON+", "WAIT DI[1]=ON")), assumptions=cell)
    assert plan.durations.tolist() == [0.0, 1.5, 1.5]


def test_an_edge_in_a_longer_condition_is_kept_word_for_word():
    assert one("WAIT DI[1]=ON+ AND DI[2]=ON") == Opaque(0, "WAIT DI[1]=ON+ AND DI[2]=ON")


# --- blocks beside a move -------------------------------------------------------------------------------

BLOCK = (
    HEAD
    + """   1:J P[1] 100% CNT0 TB    .10sec,P-SPS    ;
      1:  LBL[1] ;
      2:  WAIT (DI[23])    ;
      3:  IF (DI[24]),JMP LBL[1] ;
       ------ ;
   2:  LBL[1] ;
/POS
/END
"""
)


def test_a_block_beside_a_move_has_labels_of_its_own():
    program = read(BLOCK)
    first, jump, _, last = (s for s in program.routines[0].body if type(s) in (Label, Jump, Process))
    assert first.name == jump.target == "1/8"
    assert last.name == "1"
    assert not [d for d in program.diagnostics if d.is_error]


def test_the_fields_that_only_tp_needs_survive():
    details = read(listing("DO[3:grip, left]=ON")).routines[0].details
    assert details["DO[3]"] == "grip, left"
    assert details["/ATTR OWNER"] == "MNEDITOR"


UNMODELLED = [
    "R[2]=VR[1].MODELID",
    "R[2]=VR[R[1]].MES[3]",
    "R[3]=TIMER_OVERFLOW[1]",
    "IF PL[1]=[*,2,R[4]],JMP LBL[1]",
    "WAIT PL[1]=[1,1,*]",
    "WAIT ERR_NUM=11006",
    "IF (VR[1].ENC[1]>3) THEN",
]


@pytest.mark.parametrize("text", UNMODELLED)
def test_what_is_read_and_not_modelled_stays_as_written(text):
    """Vision and pallet registers and the last alarm: no mistake, but nothing that another language has."""
    block = [text, "ENDIF"] if text.endswith("THEN") else [text]
    program = read(listing("LBL[1]", *block))
    assert not [one for one in program.diagnostics if one.is_error]
    assert f"2:  {text} " in export(program, "tp").decode()
    with pytest.raises(OlpError, match="cannot express"):
        export(program, "krl")


@pytest.mark.parametrize("text", ["OVERRIDE=R[1]%", "OVERRIDE=AR[2]%", "OVERRIDE=R[1]"])
def test_an_override_may_be_a_register_with_or_without_its_sign(text):
    program = read(listing(text))
    assert not [found for found in program.diagnostics if found.is_error]
    assert isinstance(program.routines[0].body[0], SetOverride)


def test_an_override_has_no_other_unit():
    assert [found.code for found in read(listing("OVERRIDE=50mm/sec")).diagnostics if found.is_error] == [
        "P520"
    ]


@pytest.mark.parametrize("value", ["0", "7", "516.6349", "012", "0.0", "(-3)", "(-012.50)", "(-0)", "(-0.0)"])
@pytest.mark.parametrize("register", ["1", "37", "007"])
def test_components_that_are_read_without_the_grammar_are_what_the_grammar_makes_of_them(register, value):
    for place in range(1, 7):
        text = f"PR[{register},{place}]={value}"
        found = instructions._COMPONENT.fullmatch(text)
        assert found is not None
        made = instructions._set_component(found[1], found[2], found[3] or found[4])
        assert made == tuple((type(s), values_of(s)) for s in instruction_parser().statements(text))
