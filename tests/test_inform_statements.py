"""Every instruction of INFORM becomes the statement that it means."""

from __future__ import annotations

from math import radians

import pytest
from inform_jobs import job, read_lines, read_statement, read_statements

from olp.core.diagnostic import Severity
from olp.ir.expressions import (
    Argument,
    Binary,
    Compare,
    Element,
    Expression,
    FrameRef,
    Function,
    Logic,
    Number,
    Quantity,
    Signal,
    SignalState,
    Store,
    SystemValue,
    Taught,
    Text,
    Unary,
    Unknown,
    Variable,
)
from olp.ir.program import (
    Assign,
    Blend,
    BlendKind,
    Call,
    Case,
    Clear,
    Comment,
    Default,
    DefineFrame,
    Disabled,
    Dwell,
    Else,
    ElseIf,
    EndIf,
    EndSwitch,
    EndWhile,
    ExternalTool,
    For,
    If,
    Jump,
    Label,
    Message,
    Move,
    MovePart,
    Next,
    Opaque,
    Path,
    Pause,
    Process,
    PulseOutput,
    ReadInput,
    Reference,
    Return,
    Search,
    SetOutput,
    SetSpeed,
    ShiftOff,
    ShiftOn,
    Speed,
    SpeedUnit,
    StartTask,
    Statement,
    Switch,
    Synchronise,
    Update,
    Wait,
    WaitTask,
    While,
)
from olp.languages.vendors.inform.statements import instruction_parser

LINE = 9  # of the first instruction behind NOP and six aliases: see `at`


def n(value: float) -> Number:
    return Number(value)


def v(store: Store, index: int, local: bool = False) -> Variable:
    return Variable(store, Number(index), local)


def taught(number: int, store: Store = Store.ROBOT) -> Taught:
    return Taught(store, number)


def travel(mm_s: float) -> Speed:
    return Speed(SpeedUnit.TRAVEL, Quantity(Number(mm_s), 1e-3))


def percent(value: float) -> Speed:
    return Speed(SpeedUnit.FRACTION, Quantity(Number(value), 1e-2))


def level(value: int) -> Blend:
    return Blend(BlendKind.LEVEL, Quantity(Number(value), 1.0))


def seconds(value: float) -> Quantity:
    return Quantity(Number(value), 1.0)


def equal(left: Expression, right: Expression) -> Compare:
    return Compare("=", left, right)


B, I, D, R, S = Store.BYTE, Store.INTEGER, Store.DOUBLE, Store.REAL, Store.STRING  # noqa: E741
P, BP, EX, PX = Store.ROBOT, Store.BASE, Store.STATION, Store.SYSTEM
IN12 = Signal("in", Number(12))
OT3 = Signal("out", Number(3))
ON, OFF = SignalState(True), SignalState(False)

LINEAR, JOINT, CIRCULAR, SPLINE = Path.LINEAR, Path.JOINT, Path.CIRCULAR, Path.SPLINE

MOVES: list[tuple[str, Statement]] = [
    ("MOVJ C00007 VJ=31.25", Move(0, JOINT, (taught(7),), percent(31.25))),
    ("MOVL C013 V=17.5 CONT", Move(0, LINEAR, (taught(13),), travel(17.5), Blend(BlendKind.CONTINUOUS))),
    ("MOVC C00002 V=46.0 PL=3 FPT", Move(0, CIRCULAR, (taught(2),), travel(46.0), level(3), end_of_arc=True)),
    ("MOVS C00004 V=23.5", Move(0, SPLINE, (taught(4),), travel(23.5))),
    ("MOVJ P0048", Move(0, JOINT, (v(P, 48),))),
    ("MOVL P[LB007] PL=0", Move(0, LINEAR, (Variable(P, v(B, 7, True)),), None, level(0))),
    (
        "MOVL LP011 V=LI004",
        Move(0, LINEAR, (v(P, 11, True),), Speed(SpeedUnit.TRAVEL, Quantity(v(I, 4, True), 1e-4))),
    ),
    ("MOVJ P021 VJ=I006", Move(0, JOINT, (v(P, 21),), Speed(SpeedUnit.FRACTION, Quantity(v(I, 6), 1e-4)))),
    ("MOVL P021 V=R006", Move(0, LINEAR, (v(P, 21),), Speed(SpeedUnit.TRAVEL, Quantity(v(R, 6), 1e-3)))),
    (
        "MOVL P003 VR=14.5 PL=2",
        Move(0, LINEAR, (v(P, 3),), Speed(SpeedUnit.TURN, Quantity(Number(14.5), radians(1))), level(2)),
    ),
    (
        "MOVL C00003 BC00003 V=250.0 ACC=35 DEC=45  +MOVJ EC00003 VJ=0.78  //ab c",
        Move(
            0,
            LINEAR,
            (taught(3), taught(3, BP)),
            travel(250.0),
            parts=(MovePart(JOINT, (taught(3, EX),), percent(0.78)),),
            comment="ab c",
            acceleration=Quantity(Number(35), 0.01),
            deceleration=Quantity(Number(45), 0.01),
        ),
    ),
    (
        "MOVL C00003 V=12.0 CR=7.5 CV=60.5 NWAIT",
        Move(
            0,
            LINEAR,
            (taught(3),),
            travel(12.0),
            Blend(BlendKind.RADIUS, Quantity(Number(7.5), 1e-3)),
            no_wait=True,
            other=(("CV", Number(60.5)),),
        ),
    ),
    (
        "MOVJ EX050 VJ=50.00 PL=1  +MOVJ EX051  +MOVJ EX052",
        Move(
            0,
            JOINT,
            (v(EX, 50),),
            percent(50.0),
            level(1),
            parts=(MovePart(JOINT, (v(EX, 51),)), MovePart(JOINT, (v(EX, 52),))),
        ),
    ),
    (
        "MOVL C00004 EC00002 V=11.0  +MOVL C00005 V=12.0 PL=1",
        Move(
            0,
            LINEAR,
            (taught(4), taught(2, EX)),
            travel(11.0),
            parts=(MovePart(LINEAR, (taught(5),), travel(12.0), level(1)),),
        ),
    ),
    (
        "SMOVL C00005 BC00005 T00012 V=8.3  +MOVJ EC00005",
        Move(
            0,
            LINEAR,
            (taught(5), taught(5, BP)),
            travel(8.3),
            parts=(MovePart(JOINT, (taught(5, EX),)),),
            coordinated=True,
            passes="T00012",
        ),
    ),
    (
        "SMOVC C00006 V=I011  +MOVJ EC00006",
        Move(
            0,
            CIRCULAR,
            (taught(6),),
            Speed(SpeedUnit.TRAVEL, Quantity(v(I, 11), 1e-4)),
            parts=(MovePart(JOINT, (taught(6, EX),)),),
            coordinated=True,
        ),
    ),
    (
        "MOVL LP002 V=33.0 SRCH RIN#(LI004)=ON T=1.25 DIS=LD005  +MOVJ LEX002",
        Move(
            0,
            LINEAR,
            (v(P, 2, True),),
            travel(33.0),
            parts=(MovePart(JOINT, (v(EX, 2, True),)),),
            search=Search(
                Signal("direct-in", v(I, 4, True)), True, seconds(1.25), Quantity(v(D, 5, True), 1e-6)
            ),
        ),
    ),
    (
        "MOVL C00002 V=33.0 SRCH RIN#(2)=OFF DIS=17.5",
        Move(
            0,
            LINEAR,
            (taught(2),),
            travel(33.0),
            search=Search(Signal("direct-in", Number(2)), False, None, Quantity(Number(17.5), 1e-3)),
        ),
    ),
    (
        "MOVL C00002 V=33.0 UNTIL IN#(12)=ON",
        Move(0, LINEAR, (taught(2),), travel(33.0), until=equal(IN12, ON)),
    ),
    ("IMOV P063 V=75.0 TF", Move(0, LINEAR, (v(P, 63),), travel(75.0), relative=FrameRef("tool"))),
    (
        "IMOV P063 V=75.0 BF PL=1",
        Move(0, LINEAR, (v(P, 63),), travel(75.0), level(1), relative=FrameRef("base")),
    ),
    ("IMOV P063 V=75.0 RF", Move(0, LINEAR, (v(P, 63),), travel(75.0), relative=FrameRef("robot"))),
    (
        "IMOV LP063 V=75.0 UF#(LB007)",
        Move(0, LINEAR, (v(P, 63, True),), travel(75.0), relative=FrameRef("user", v(B, 7, True))),
    ),
    ("IMOV EX002 VJ=12.5", Move(0, JOINT, (v(EX, 2),), percent(12.5), relative=FrameRef("own"))),
    ("REFP 2 C00013 BC00013", Reference(0, Number(2), (taught(13), taught(13, BP)))),
    (
        "SREFP 1 C00013  +REFP EC00014",
        Reference(0, Number(1), (taught(13),), (MovePart(None, (taught(14, EX),)),), coordinated=True),
    ),
    (
        "SPEED VJ=40.00 V=310.0 VR=25.0",
        SetSpeed(0, (percent(40.0), travel(310.0), Speed(SpeedUnit.TURN, Quantity(n(25.0), radians(1))))),
    ),
    ("TIMER T=0.35", Dwell(0, seconds(0.35))),
    ("TIMER T=LI007", Dwell(0, Quantity(v(I, 7, True), 0.01))),
    ("WAIT T=1.75", Dwell(0, seconds(1.75))),
]

DATA: list[tuple[str, Statement]] = [
    ("SET B012 201", Assign(0, v(B, 12), n(201))),
    ("SET LR003 -1.5", Assign(0, v(R, 3, True), n(-1.5))),
    ('SET LS002 "a // b \' c"', Assign(0, v(S, 2, True), Text("a // b ' c"))),
    ("SET P[LI001] LP002", Assign(0, Variable(P, v(I, 1, True)), v(P, 2, True))),
    ("SET P017 C00004", Assign(0, v(P, 17), taught(4))),
    ("SET P001 PX003", Assign(0, v(P, 1), v(PX, 3))),
    (
        "SET LR002  EXPRESS LR000 - 2 * ( LR001 + 1.5 ) / -I004",
        Assign(
            0,
            v(R, 2, True),
            Binary(
                "-",
                v(R, 0, True),
                Binary("/", Binary("*", n(2), Binary("+", v(R, 1, True), n(1.5))), Unary("-", v(I, 4))),
            ),
        ),
    ),
    ("SET D005  EXPRESS -7 + D[LI123]", Assign(0, v(D, 5), Binary("+", n(-7), Variable(D, v(I, 123, True))))),
    ("SET D005  EXPRESS D006 -7", Assign(0, v(D, 5), Binary("-", v(D, 6), n(7)))),
    (
        "SET D005  EXPRESS (( D006 + 1 ) / 2 )",
        Assign(0, v(D, 5), Binary("/", Binary("+", v(D, 6), n(1)), n(2))),
    ),
    ("SETE P041 (5) 150000", Assign(0, Element(v(P, 41), n(5)), n(150000))),
    ("SETE P[LB001] (2) LD007", Assign(0, Element(Variable(P, v(B, 1, True)), n(2)), v(D, 7, True))),
    ("GETE LD008 C00003 (6)", Assign(0, v(D, 8, True), Element(taught(3), n(6)))),
    ("GETS PX004 $PX000", Assign(0, v(PX, 4), SystemValue("position-pulse"))),
    ("GETS LPX[LD001] $PX001", Assign(0, Variable(PX, v(D, 1, True), True), SystemValue("position-pose"))),
    ("GETS LB004 $B012", Assign(0, v(B, 4, True), SystemValue("byte", 12))),
    ("GETS LD004 $RV", Assign(0, v(D, 4, True), SystemValue("returned"))),
    ("GETARG LEX002 IARG#(3)", Assign(0, v(EX, 2, True), Argument(3))),
    ("GETREG I007 MREG#(560) LOW", Assign(0, v(I, 7), Signal("register", n(560), "low"))),
    ("GETREG I007 MREG#(561)", Assign(0, v(I, 7), Signal("register", n(561)))),
    ("SETREG MREG#(562) HIGH 17", SetOutput(0, Signal("register", n(562), "high"), n(17))),
    ("SETREG MREG#(563) LI007", SetOutput(0, Signal("register", n(563)), v(I, 7, True))),
    ("GETTOOL LP003 TL#(14)", Assign(0, v(P, 3, True), Function("tool-data", (n(14),)))),
    ("SETTOOL TL#(15) P00095", Assign(0, Function("tool-data", (n(15),)), v(P, 95))),
    ("GETPOS PX006 STEP#(12)", Assign(0, v(PX, 6), Function("step-position", (n(12),)))),
    ("GETPRM LD003 KIND=4 PRMNO=230", Assign(0, v(D, 3, True), Function("parameter", (n(4), n(230))))),
    ("SQRT LR004 LR005", Assign(0, v(R, 4, True), Function("sqrt", (v(R, 5, True),)))),
    ("SIN R004 30.5", Assign(0, v(R, 4), Function("sin", (n(30.5),)))),
    ("COS R004 R005", Assign(0, v(R, 4), Function("cos", (v(R, 5),)))),
    ("ATAN R004 R005", Assign(0, v(R, 4), Function("atan", (v(R, 5),)))),
    ("MULMAT P003 P004 P005", Assign(0, v(P, 3), Function("pose-product", (v(P, 4), v(P, 5))))),
    ("INVMAT P003 P004", Assign(0, v(P, 3), Function("pose-inverse", (v(P, 4),)))),
    (
        "CNVRT PX003 PX004 UF#(2) TL#(5)",
        Assign(0, v(PX, 3), Function("convert", (v(PX, 4), FrameRef("user", n(2)), FrameRef("tool", n(5))))),
    ),
    (
        "CNVRT LPX003 LPX004 BF",
        Assign(0, v(PX, 3, True), Function("convert", (v(PX, 4, True), FrameRef("base")))),
    ),
    (
        "CONVSFT LP003 LP004 LPX005 MTF",
        Assign(
            0,
            v(P, 3, True),
            Function("convert-shift", (v(P, 4, True), v(PX, 5, True), FrameRef("master-tool"))),
        ),
    ),
    (
        "MSHIFT PX003 TF PX004 PX005",
        Assign(0, v(PX, 3), Function("shift-between", (FrameRef("tool"), v(PX, 4), v(PX, 5)))),
    ),
    ('VAL LI003 "12"', Assign(0, v(I, 3, True), Function("value-of-text", (Text("12"),)))),
    ("VAL2STR S003 D004", Assign(0, v(S, 3), Function("text-of-value", (v(D, 4),)))),
    ("ASC B003 S004", Assign(0, v(B, 3), Function("code-of-character", (v(S, 4),)))),
    ("CHR$ S003 B004", Assign(0, v(S, 3), Function("character-of-code", (v(B, 4),)))),
    ("MID$ S003 S004 2 5", Assign(0, v(S, 3), Function("part-of-text", (v(S, 4), n(2), n(5))))),
    ("LEN B003 S004", Assign(0, v(B, 3), Function("length-of-text", (v(S, 4),)))),
    ("CAT$ S003 S004 S005", Assign(0, v(S, 3), Function("joined-text", (v(S, 4), v(S, 5))))),
    ('STRSTR B003 S004 "x"', Assign(0, v(B, 3), Function("position-in-text", (v(S, 4), Text("x"))))),
    ("ADD LP003 LP004", Update(0, "+", v(P, 3, True), v(P, 4, True))),
    ("SUB D003 250", Update(0, "-", v(D, 3), n(250))),
    ("MUL LD[LB003] 10", Update(0, "*", Variable(D, v(B, 3, True), True), n(10))),
    ("DIV LP003 4", Update(0, "/", v(P, 3, True), n(4))),
    ("AND B003 15", Update(0, "and", v(B, 3), n(15))),
    ("OR B003 16", Update(0, "or", v(B, 3), n(16))),
    ("XOR B003 17", Update(0, "xor", v(B, 3), n(17))),
    ("NOT B003 B004", Update(0, "not", v(B, 3), v(B, 4))),
    ("INC LB003", Update(0, "+", v(B, 3, True), n(1))),
    ("DEC I003", Update(0, "-", v(I, 3), n(1))),
    ("CLEAR B010 12", Clear(0, v(B, 10), n(12))),
    ("CLEAR D003 ALL", Clear(0, v(D, 3), None)),
    ("CLEAR STACK", Clear(0, None)),
    ("CLEAR MPF", Process(0, "CLEAR", (("", Unknown("MPF")),))),
]

FRAMES_AND_SIGNALS: list[tuple[str, Statement]] = [
    (
        "MFRAME UF#(7) PX001 PX002 PX003",
        DefineFrame(0, FrameRef("user", n(7)), (v(PX, 1), v(PX, 2), v(PX, 3))),
    ),
    (
        "MFRAME UF#(LB004) LPX001 LPX002 LPX003 MTOOL",
        DefineFrame(
            0, FrameRef("user", v(B, 4, True)), (v(PX, 1, True), v(PX, 2, True), v(PX, 3, True)), True
        ),
    ),
    ("SFTON P004 UF#(3)", ShiftOn(0, v(P, 4), FrameRef("user", n(3)))),
    ("SFTON EX004", ShiftOn(0, v(EX, 4))),
    ("SSFTON P004 RF", ShiftOn(0, v(P, 4), FrameRef("robot"), coordinated=True)),
    ("SFTOF", ShiftOff(0)),
    ("SSFTOF", ShiftOff(0, coordinated=True)),
    ("TCPON TL#(11)", ExternalTool(0, n(11))),
    ("TCPOF", ExternalTool(0, None)),
    ("DOUT OT#(3) ON", SetOutput(0, OT3, ON)),
    ("DOUT OT#(LI007) OFF", SetOutput(0, Signal("out", v(I, 7, True)), OFF)),
    ("DOUT OG#(26) 0", SetOutput(0, Signal("out-group", n(26)), n(0))),
    ("DOUT OG#(2) LB[1]", SetOutput(0, Signal("out-group", n(2)), Variable(B, n(1), True))),
    ("AOUT AO#(2) 3.5", SetOutput(0, Signal("analog-out", n(2)), n(3.5))),
    ("PULSE OT#(3) T=0.25", PulseOutput(0, OT3, seconds(0.25))),
    ("PULSE OT#(3)", PulseOutput(0, OT3)),
    (
        "PULSE OT#(3) T=LI002 IFEXPRESS IN#(12)=ON OREXP B003=2",
        PulseOutput(
            0,
            OT3,
            Quantity(v(I, 2, True), 0.01),
            Logic(equal(IN12, ON), (("or", equal(v(B, 3), n(2))),)),
        ),
    ),
    ("DIN B003 IG#(4)", ReadInput(0, v(B, 3), Signal("in-group", n(4)))),
    ("DIN LB003 SOUT#(120)", ReadInput(0, v(B, 3, True), Signal("system-out", n(120)))),
    ("DIN B003 IGH#(4)", ReadInput(0, v(B, 3), Signal("in-half-group", n(4)))),
    ("WAIT IN#(12)=ON", Wait(0, equal(IN12, ON))),
    ("WAIT IN#(12)=ON T=2.50", Wait(0, equal(IN12, ON), seconds(2.5))),
    ("WAIT IG#(3)=LB004", Wait(0, equal(Signal("in-group", n(3)), v(B, 4, True)))),
    (
        "WAIT FOREXPRESS IN#(12)=OFF ANDEXP OT#(3)=ON T=4.50",
        Wait(
            0,
            Logic(equal(IN12, OFF), (("and", equal(OT3, ON)),)),
            seconds(4.5),
        ),
    ),
]

FLOW: list[tuple[str, Statement]] = [
    ("*FAULT-1", Label(0, "FAULT-1")),
    ("*7", Label(0, "7")),
    ("*Ablage_öffnen", Label(0, "Ablage_öffnen")),
    ("JUMP *_TOP", Jump(0, "_TOP")),
    ("JUMP *4 IF D003<>12", Jump(0, "4", Compare("<>", v(D, 3), n(12)))),
    (
        "JUMP *4 IFEXPRESS IN#(12)=ON ANDEXP B010=0",
        Jump(0, "4", Logic(equal(IN12, ON), (("and", equal(v(B, 10), n(0))),))),
    ),
    ("JUMP LABEL: B098 IF B098<B096", Jump(0, v(B, 98), Compare("<", v(B, 98), v(B, 96)))),
    ("JUMP JOB:NEXT-1 IF IN#(12)=ON", Call(0, "NEXT-1", (), equal(IN12, ON), jump=True)),
    ("CALL JOB:PICK & PLACE", Call(0, "PICK & PLACE")),
    (
        'CALL JOB:A B ARGF0.5 ARGF-3 ARGF"mm/s" ARGFLD007 IF B003=2',
        Call(0, "A B", (n(0.5), n(-3), Text("mm/s"), v(D, 7, True)), equal(v(B, 3), n(2))),
    ),
    ("MACRO1 MJ#(5) ARGF12 ARGFB004", Call(0, "", (n(12), v(B, 4)), macro=n(5))),
    ("RET", Return(0)),
    ("RET LD003", Return(0, v(D, 3, True))),
    ("RET IF LI003<>LI004", Return(0, None, Compare("<>", v(I, 3, True), v(I, 4, True)))),
    (
        "IFTHEN B003=1 ANDIF B004>=2 ORIF IN#(12)=OFF",
        If(
            0,
            Logic(
                equal(v(B, 3), n(1)),
                (("and", Compare(">=", v(B, 4), n(2))), ("or", equal(IN12, OFF))),
            ),
        ),
    ),
    (
        'IFTHENEXP LS000="OUT" OREXP LD003<LD[LB004]',
        If(
            0,
            Logic(
                equal(v(S, 0, True), Text("OUT")),
                (("or", Compare("<", v(D, 3, True), Variable(D, v(B, 4, True), True))),),
            ),
        ),
    ),
    ("ELSEIF LI003=4", ElseIf(0, equal(v(I, 3, True), n(4)))),
    ("ELSEIFEXP B003<=4", ElseIf(0, Compare("<=", v(B, 3), n(4)))),
    ("ELSE", Else(0)),
    ("ENDIF", EndIf(0)),
    ("WHILE I003<=I004", While(0, Compare("<=", v(I, 3), v(I, 4)))),
    ("WHILEEXP B003=-4", While(0, equal(v(B, 3), n(-4)))),
    ("ENDWHILE", EndWhile(0)),
    ("FOR LI003 START= 120 TO 123", For(0, v(I, 3, True), n(120), n(123))),
    ("FOR I003 = 9 TO I004 STEP 3", For(0, v(I, 3), n(9), v(I, 4), n(3))),
    ("NEXT LI003", Next(0, v(I, 3, True))),
    ("NEXT", Next(0, None)),
    ("SWITCH LI003", Switch(0, v(I, 3, True))),
    ("CASE 3,4", Case(0, (n(3), n(4)))),
    ("DEFAULT", Default(0)),
    ("ENDSWITCH", EndSwitch(0)),
    ("PAUSE", Pause(0)),
    ("PAUSE IF B003=1", Pause(0, equal(v(B, 3), n(1)))),
    ("PSTART JOB:SUB-A SUB4 IF IN#(12)=OFF", StartTask(0, "SUB-A", "SUB4", equal(IN12, OFF))),
    ("PSTART JOB:SUB-A SUB2 SYNC", StartTask(0, "SUB-A", "SUB2", synchronised=True)),
    ("PWAIT SUB2", WaitTask(0, "SUB2")),
    ("TSYNC 3", Synchronise(0, n(3))),
    ("TSYNC 3 SNUM=4", Synchronise(0, n(3), n(4))),
    ('MSG "door // open"', Message(0, Text("door // open"))),
    ("MSG S015", Message(0, v(S, 15))),
    ("'a comment ", Comment(0, "a comment")),
    ("COMM MOVL C00001 V=11.0 //x", Disabled(0, "MOVL C00001 V=11.0 //x")),
]

PROCESSES: list[tuple[str, tuple[tuple[str, Expression], ...]]] = [
    ("ARCON", ()),
    ("ARCON ASF#(951)", (("ASF#", n(951)),)),
    (
        "ARCON AC=220 AVP=95 V=300 T=0.30 RETRY SHIFT",
        (
            ("AC", n(220)),
            ("AVP", n(95)),
            ("V", n(300)),
            ("T", n(0.30)),
            ("", Unknown("RETRY")),
            ("", Unknown("SHIFT")),
        ),
    ),
    ("ARCOF AEF#(4)", (("AEF#", n(4)),)),
    ("ARCSET AC=180 AVP=90", (("AC", n(180)), ("AVP", n(90)))),
    ("WVON WEV#(D003)", (("WEV#", v(D, 3)),)),
    ("WVON AMP=D080 FREQ=2.5 ANGL=30", (("AMP", v(D, 80)), ("FREQ", n(2.5)), ("ANGL", n(30)))),
    ("WVOF", ()),
    (
        "WVADJ STD=1 ST=2 END=3 LEN=4.5 ADJMD=5",
        (("STD", n(1)), ("ST", n(2)), ("END", n(3)), ("LEN", n(4.5)), ("ADJMD", n(5))),
    ),
    ("SWVON WEV#(3)", (("WEV#", n(3)),)),
    ("SWVOF", ()),
    ("FORMCUT RB1 FCF#(3)", (("", Unknown("RB1")), ("FCF#", n(3)))),
    ("FORMAPR P018 FCF#(1) R=D000 V=50.0", (("", v(P, 18)), ("FCF#", n(1)), ("R", v(D, 0)), ("V", n(50.0)))),
    ("SACORON TF TCH#(2) TV=I003", (("", Unknown("TF")), ("TCH#", n(2)), ("TV", v(I, 3)))),
    ("SACOROF", ()),
    ("ACORON TF TCH#(2) TV=3.5", (("", Unknown("TF")), ("TCH#", n(2)), ("TV", n(3.5)))),
    ("ACOROF", ()),
    ("AOVRON TCH#(2) TV=I003", (("TCH#", n(2)), ("TV", v(I, 3)))),
    (
        "COMARCON AMP=D080 FREQ=2.5 ANGL=D082 U/D=I003 L/R=4",
        (("AMP", v(D, 80)), ("FREQ", n(2.5)), ("ANGL", v(D, 82)), ("U/D", v(I, 3)), ("L/R", n(4))),
    ),
    ("COMARCOF", ()),
    ("SHCKSET SSL#(3)", (("SSL#", n(3)),)),
    ("SHCKRST", ()),
    ("CLRSENS", ()),
    ("MEMON REC MPF#(1)", (("", Unknown("REC")), ("MPF#", n(1)))),
    ("MEMON BACKPLY MPF#(1)", (("", Unknown("BACKPLY")), ("MPF#", n(1)))),
    ("MEMOF", ()),
    ("MRESET ST", (("", Unknown("ST")),)),
    ('SETUALM 8005 "no part" 1 SMODE=2', (("", n(8005)), ("", Text("no part")), ("", n(1)), ("SMODE", n(2)))),
    ("SETUALM 8005 S004 LB005", (("", n(8005)), ("", v(S, 4)), ("", v(B, 5, True)))),
    ("INPUT I003", (("", v(I, 3)),)),
    ('SKILLSND SL5 "go"', (("", Unknown("SL5")), ("", Text("go")))),
    ("DELAY 0.5", (("", n(0.5)),)),
    ("HSEN 1 SEN#(2) FOREVER", (("", n(1)), ("SEN#", n(2)), ("", Unknown("FOREVER")))),
]

TABLE = [
    *MOVES,
    *DATA,
    *FRAMES_AND_SIGNALS,
    *FLOW,
    *((line, Process(0, line.split()[0], arguments)) for line, arguments in PROCESSES),
]


def without_line(statement: Statement) -> Statement:
    from dataclasses import replace

    return replace(statement, line=0)  # type: ignore[type-var]


@pytest.mark.parametrize(("line", "expected"), TABLE, ids=[line for line, _ in TABLE])
def test_an_instruction_becomes_the_statement_that_it_means(line: str, expected: Statement) -> None:
    assert without_line(read_statement(line)) == expected


@pytest.mark.parametrize("line", [line for line, _ in TABLE])
def test_blanks_around_an_instruction_change_nothing(line: str) -> None:
    assert without_line(read_statement(f" \t {line}  ")) == without_line(read_statement(line))


def test_every_word_that_the_grammar_knows_stands_in_the_table() -> None:
    shown = {line.split()[0] for line, _ in TABLE} | {"NOP", "END", "EDTLCK", "JMP"}
    plain = {"SMOVJ", "SMOVS"}  # grammatical by symmetry, see the paths of MOVJ and MOVS
    processes = {
        w for w in instruction_parser().words if instruction_parser().terminals["PROCESS"].find(w) >= 0
    }
    assert instruction_parser().words - shown - plain - processes == set()


def test_a_name_of_the_alias_table_is_the_variable_that_it_names() -> None:
    lines = (
        "SET V_Seam 12",
        "MOVL Greifer_Öffnen V=V_Seam UF#(two words)".replace("MOVL", "IMOV"),
        "ADD two words 4th-gauge",
        "SET PL 3",
        "CALL JOB:X ARGFtwo words ARGF4th-gauge",
        "ARCON ASF#(PL)",
        "SET D007  EXPRESS two words * ( V_Seam - 4th-gauge )",
    )
    seam, grip, two = v(D, 0, True), v(P, 1, True), v(I, 2, True)
    level_, gauge = v(B, 3, True), v(R, 4)
    read = [without_line(one) for one in read_statements(*lines)]
    assert read == [
        Assign(0, seam, n(12)),
        Move(
            0, LINEAR, (grip,), Speed(SpeedUnit.TRAVEL, Quantity(seam, 1e-4)), relative=FrameRef("user", two)
        ),
        Update(0, "+", two, gauge),
        Assign(0, level_, n(3)),
        Call(0, "X", (two, gauge)),
        Process(0, "ARCON", (("ASF#", level_),)),
        Assign(0, v(D, 7), Binary("*", two, Binary("-", seam, gauge))),
    ]
    assert isinstance(read[0], Assign)
    assert isinstance(read[0].target, Variable)
    assert read[0].target.name == "V_Seam"


def test_a_second_part_may_have_the_speed_0_because_it_follows_the_first() -> None:
    move = read_statement("MOVL C00001 V=12.5 +MOVJ EC00001 VJ=0.0")
    assert isinstance(move, Move)
    assert move.parts[0].speed == percent(0.0)


def test_an_odd_name_is_a_name_only_where_a_value_stands() -> None:
    lines = ("CALL JOB:MY two words", "*two_words", "COMM SET two words 1", 'MSG "two words"', "'two words")
    assert [without_line(one) for one in read_statements(*lines)] == [
        Call(0, "MY two words"),
        Label(0, "two_words"),
        Disabled(0, "SET two words 1"),
        Message(0, Text("two words")),
        Comment(0, "two words"),
    ]


def test_a_line_read_for_one_job_is_not_taken_for_another_with_other_names() -> None:
    first = read_lines(job(["SET SPEED_1 4"], aliases=["LD003 SPEED_1"])).routines[0].body[1]
    second = read_lines(job(["SET SPEED_1 4"], aliases=["B007 SPEED_1"])).routines[0].body[1]
    assert isinstance(first, Assign)
    assert isinstance(second, Assign)
    assert (first.target, second.target) == (v(D, 3, True), v(B, 7))


def test_a_condition_keeps_the_word_it_was_written_with_and_means_the_same() -> None:
    short, full = read_statements("IFTHEN B003=1", "IFTHENEXP B003=1")
    assert isinstance(short, If)
    assert isinstance(full, If)
    assert (short.spelling, full.spelling) == ("IFTHEN", "IFTHENEXP")
    assert without_line(short) == without_line(full)


def test_switch_and_its_first_case_on_one_line_are_two_statements() -> None:
    body = read_statements("SWITCH B003 CASE 1,2", "CASE 3", "ENDSWITCH")
    assert [without_line(one) for one in body] == [
        Switch(0, v(B, 3)),
        Case(0, (n(1), n(2))),
        Case(0, (n(3),)),
        EndSwitch(0),
    ]
    assert body[0].line == body[1].line


def test_a_statement_knows_its_line() -> None:
    program = read_lines(job(["TIMER T=0.35", "", "'x", "TIMER T=0.35"]))
    lines = [statement.line for statement in program.routines[0].body]
    assert [program.source.line(line) for line in lines] == [
        "NOP",
        "TIMER T=0.35",
        "'x",
        "TIMER T=0.35",
        "END",
    ]


@pytest.mark.parametrize(
    "text",
    [
        "CALL IG#(2)",
        "CALL B003 IF IN#(4)=ON",
        "JUMP IG#(1)",
        "JUMP LI000 IF B000=1",
        "MUL P004 (3) 2",
        "DIV LP001 (1) D000",
        "SPEED V=138.0 VE=20.0",
        "PULSE OG#(1) B000 T=0.30",
        "PULSE OT#(1) OT#(2)",
    ],
)
def test_legal_forms_that_are_not_modelled_are_kept_and_told(text: str) -> None:
    """Jobs and labels by a number, one element of a position, speeds of external axes."""
    program = read_lines(job([text, "TIMER T=1.00"]))
    assert [one.text for one in program.routines[0].body if isinstance(one, Opaque)] == [text]
    (found,) = program.diagnostics
    assert (found.code, found.severity) == ("P021", Severity.WARNING)


def test_an_unknown_instruction_is_kept_word_for_word() -> None:
    program = read_lines(job(["  LASERTRK ON CH#(3) GAIN=1.75 'x ", "LASERTRK OFF"]))
    body = program.routines[0].body
    assert [one.text for one in body if isinstance(one, Opaque)] == [
        "LASERTRK ON CH#(3) GAIN=1.75 'x",
        "LASERTRK OFF",
    ]
    assert [d.code for d in program.diagnostics] == ["P021"]
