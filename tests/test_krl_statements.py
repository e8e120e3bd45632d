"""KRL line by line: what each form of the manuals becomes."""

from __future__ import annotations

import math

import pytest
from krl_programs import body, codes, one, read

from olp.ir.expressions import (
    Binary,
    CallValue,
    Compare,
    FrameRef,
    Function,
    Item,
    Logic,
    Member,
    Named,
    Number,
    PositionLiteral,
    Quantity,
    RecordLiteral,
    Signal,
    SignalState,
    SystemValue,
    Text,
    Unary,
    Unknown,
)
from olp.ir.program import (
    Acceleration,
    AccelerationUnit,
    Assign,
    Blend,
    BlendKind,
    Break,
    Call,
    Case,
    Comment,
    Declare,
    Dwell,
    EndWhile,
    ExternalTool,
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
    Repeat,
    Return,
    SetAcceleration,
    SetBlend,
    SetFrame,
    SetOutput,
    SetOverride,
    SetSpeed,
    SetTool,
    Speed,
    SpeedUnit,
    Switch,
    Until,
    Wait,
    While,
)

MM, DEG = 0.001, math.pi / 180
X = Named("X1")
STOP = Blend(BlendKind.RADIUS, Quantity(Number(0), MM))


def pose(x: float, y: float, z: float, a: float, b: float, c: float, **more: object) -> PositionLiteral:
    """Components as they stand in KRL."""
    values = (x * MM, y * MM, z * MM, c * DEG, b * DEG, a * DEG)
    return PositionLiteral("pose", values, **more)  # type: ignore[arg-type]


# --- targets ---------------------------------------------------------------------------------------------


def test_a_pose_is_in_mm_and_deg_and_a_b_c_turn_about_z_y_x() -> None:
    move = one("LIN {X 100.5,Y -20,Z 3,A 10,B 20,C 30}")
    assert move == Move(0, Path.LINEAR, (pose(100.5, -20, 3, 10, 20, 30),), blend=STOP)
    assert move.targets[0].values[3:] == (30 * DEG, 20 * DEG, 10 * DEG)


def test_components_that_are_not_written_stay_as_they_are() -> None:
    (target,) = one("LIN {Z 12.5}").targets
    assert [math.isnan(value) for value in target.values] == [True, True, False, True, True, True]


def test_axes_are_in_degrees() -> None:
    (target,) = one("PTP {A1 10,A2 -90,A3 90.5,A4 0,A5 1,A6 2,E1 350.25}").targets
    assert target.kind == "joint"
    assert target.values == tuple(v * DEG for v in (10, -90, 90.5, 0, 1, 2))
    assert target.external == (350.25,)


def test_status_and_turn_are_kept_and_the_status_becomes_arm_flags() -> None:
    (target,) = one("PTP {X 1,Y 2,Z 3,A 4,B 5,C 6,S 'B110',T 27,E1 0.0}").targets
    assert target.native == (("S", "6"), ("T", "27"))
    # Bit 2: A5 negative, so flip; bit 1: elbow as usual; bit 0: not overhead.
    assert target.configuration == (0, 0, 0, 0, 0, 0)
    assert one("PTP {X 1,Y 2,Z 3,A 4,B 5,C 6,S 3,T 0}").targets[0].configuration == (1, 0, 1, 0, 0, 0)
    assert one("PTP {X 1,Y 2,Z 3,A 4,B 5,C 6,S 0,T 0}").targets[0].configuration == (1, 1, 0, 0, 0, 0)


def test_targets_may_be_names_elements_and_products() -> None:
    assert one("PTP X1").targets == (X,)
    assert one("PTP X1[3]").targets == (Item(X, (Number(3),)),)
    assert one("LIN X1:{Z -100}").targets[0].name == "pose-product"
    chain = one("LIN a:b:c").targets[0]
    assert chain == Function("pose-product", (Function("pose-product", (Named("a"), Named("b"))), Named("c")))
    assert one("PTP calc(1,$POS_ACT)").targets == (
        CallValue("calc", (Number(1), SystemValue("current-pose"))),
    )


def test_an_aggregate_of_computed_components_is_a_computed_pose() -> None:
    (target,) = one("LIN {X 1,Y n,Z 3,A 0,B 0,C 0}").targets
    assert target.name == "pose-angles"
    assert target.arguments[:3] == (Number(1), Named("n"), Number(3))


# --- moves -----------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("words", "blend"),
    [
        ("", STOP),
        (" C_DIS", Blend(BlendKind.RADIUS)),
        (" C_PTP", Blend(BlendKind.SHARE)),
        (" C_VEL", Blend(BlendKind.SPEED)),
        (" C_ORI", Blend(BlendKind.TURN)),
        (" C_PTP C_DIS", Blend(BlendKind.SHARE, None, "C_PTP C_DIS")),
        (" C_SPL", Blend(BlendKind.RADIUS, None, "C_SPL")),
    ],
)
def test_blend_words_are_kinds_with_modal_sizes(words: str, blend: Blend) -> None:
    assert one(f"PTP X1{words}").blend == blend


def test_an_arc_has_its_auxiliary_point_and_may_turn_by_an_angle() -> None:
    arc = one("CIRC X1, X2, CA 235 C_DIS")
    assert (arc.path, arc.via, arc.targets) == (Path.CIRCULAR, X, (Named("X2"),))
    assert arc.arc == Quantity(Number(235), DEG)
    assert one("CIRC X1,X2").arc is None


def test_relative_moves_are_zero_where_nothing_is_written() -> None:
    move = one("LIN_REL {Z 100} #TOOL C_DIS")
    assert move.relative == FrameRef("tool")
    assert one("LIN_REL {Z 100} C_DIS #TOOL") == move
    assert move.targets == (pose(0, 0, 100, 0, 0, 0),)
    assert one("PTP_REL {A1 5}").targets[0].values == (5 * DEG, 0.0, 0.0, 0.0, 0.0, 0.0)
    assert one("LIN_REL{X 1} #BASE").relative == one("LIN_REL {X 1}").relative == FrameRef("own")


def test_a_with_list_belongs_to_its_move() -> None:
    move = one(
        "SLIN X1 WITH $VEL.CP=0.2, $TOOL=t, $BASE=BASE_DATA[3], $ACC.CP=1.5, $APO.CDIS=7.5, $ORI_TYPE=#CONSTANT C_SPL"
    )
    assert move.speed == Speed(SpeedUnit.TRAVEL, Quantity(Number(0.2), 1.0))
    assert (move.tool, move.frame) == (Named("t"), FrameRef("user", Number(3)))
    assert move.rate == Acceleration(AccelerationUnit.TRAVEL, Quantity(Number(1.5), 1.0))
    assert move.blend == Blend(BlendKind.RADIUS, Quantity(Number(7.5), MM), "C_SPL")
    assert move.other == (("$ORI_TYPE", Text("#CONSTANT")),)


def test_a_record_in_a_with_list_is_what_its_members_set() -> None:
    """$VEL={CP …} was kept and not obeyed: the line ran at the speed of the one before."""
    members = one("SLIN X1 WITH $VEL.CP=0.3, $VEL.ORI1=100, $ACC.CP=2, $ACC.ORI1=80, $APO.CDIS=5 C_SPL")
    assert one("SLIN X1 WITH $VEL={CP 0.3,ORI1 100}, $ACC={CP 2,ORI1 80}, $APO={CDIS 5} C_SPL") == members
    assert members.speed == Speed(SpeedUnit.TRAVEL, Quantity(Number(0.3), 1.0))
    assert members.turn == Quantity(Number(100), DEG)
    assert one("SLIN X1 WITH $VEL={CP 0.3,ORI1 100,ORI2 100}").other == ()
    assert one("SLIN X1 WITH $VEL={CP 0.3,ORI1 100,ORI2 90}").other == (("$VEL.ORI2", Number(90)),)


def test_moves_of_a_spline_block_pass_their_points_and_its_end_stops() -> None:
    found = body("SPLINE WITH $VEL.CP=0.3", "SPL X1", "SLIN X2", "SPL X3", "ENDSPLINE")
    moves = [s for s in found if isinstance(s, Move)]
    assert [m.path for m in moves] == [Path.SPLINE, Path.LINEAR, Path.SPLINE]
    assert all(m.speed == Speed(SpeedUnit.TRAVEL, Quantity(Number(0.3), 1.0)) for m in moves)
    assert [m.blend.kind for m in moves if m.blend] == [
        BlendKind.CONTINUOUS,
        BlendKind.CONTINUOUS,
        BlendKind.RADIUS,
    ]
    assert moves[-1].blend == Blend(BlendKind.RADIUS, Quantity(Number(0), MM), "S")
    blended = body("SPLINE", "SPL X1", "ENDSPLINE C_SPL")
    assert blended[1].blend == Blend(BlendKind.RADIUS, None, "C_SPL")  # type: ignore[union-attr]


# --- the controller's variables --------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("line", "statement"),
    [
        ("$VEL.CP=0.25", SetSpeed(0, (Speed(SpeedUnit.TRAVEL, Quantity(Number(0.25), 1.0)),))),
        ("$vel.cp = v", SetSpeed(0, (Speed(SpeedUnit.TRAVEL, Quantity(Named("v"), 1.0)),))),
        ("$VEL.ORI1=200", SetSpeed(0, (), turn=Quantity(Number(200), DEG))),
        ("$VEL_AXIS[1]=40", SetSpeed(0, (Speed(SpeedUnit.FRACTION, Quantity(Number(40), 0.01)),))),
        (
            "$ACC.CP=2.3",
            SetAcceleration(0, (Acceleration(AccelerationUnit.TRAVEL, Quantity(Number(2.3), 1.0)),)),
        ),
        ("$APO.CDIS=25", SetBlend(0, (Blend(BlendKind.RADIUS, Quantity(Number(25), MM)),))),
        ("$APO.CPTP=50", SetBlend(0, (Blend(BlendKind.SHARE, Quantity(Number(50), 0.01)),))),
        ("$APO.CVEL=80", SetBlend(0, (Blend(BlendKind.SPEED, Quantity(Number(80), 0.01)),))),
        ("$APO.CORI=5", SetBlend(0, (Blend(BlendKind.TURN, Quantity(Number(5), DEG)),))),
        ("$OV_PRO=75", SetOverride(0, Quantity(Number(75), 0.01))),
        ("$TOOL=TOOL_DATA[2]", SetTool(0, FrameRef("tool", Number(2)))),
        ("$TOOL=$NULLFRAME", SetTool(0, FrameRef("tool", Number(0)))),
        ("$TOOL={X 1,Y 2,Z 3,A 4,B 5,C 6}", SetTool(0, pose(1, 2, 3, 4, 5, 6))),
        ("$BASE=BASE_DATA[n]", SetFrame(0, FrameRef("user", Named("n")))),
        ("$BASE=$WORLD", SetFrame(0, FrameRef("base"))),
        ("$BASE=$ROBROOT", SetFrame(0, FrameRef("robot"))),
        ("$BASE=f", SetFrame(0, Named("f"))),
        ("$IPO_MODE=#TCP", ExternalTool(0, SystemValue("current-frame"))),
    ],
)
def test_assignments_to_the_controller_are_statements_of_motion(line: str, statement: object) -> None:
    assert one(line) == statement


def test_one_value_for_all_axes_is_one_speed() -> None:
    found = body(*(f"$VEL_AXIS[{axis}]=30" for axis in range(1, 7)))
    assert found == (SetSpeed(0, (Speed(SpeedUnit.FRACTION, Quantity(Number(30), 0.01)),)),)
    loop = body("FOR I=1 TO 6", "$ACC_AXIS[I]=60", "ENDFOR")
    rate = Acceleration(AccelerationUnit.FRACTION, Quantity(Number(60), 0.01))
    assert loop[1] == SetAcceleration(0, (rate,), Path.JOINT)


def test_axes_with_different_speeds_are_told() -> None:
    program = read("$VEL_AXIS[1]=30", "$VEL_AXIS[2]=20")
    assert codes(program) == [("P416", 3)]
    assert isinstance(program.routines[0].body[1], Assign)


@pytest.mark.parametrize(
    "rows",
    [
        ("$VEL_AXIS[1]=30", "PTP XP1"),
        ("$ACC_AXIS[1]=30", "$ACC_AXIS[2]=30", "PTP XP1"),
        ("$VEL_AXIS[1]=30", "PTP XP1", *(f"$VEL_AXIS[{axis}]=40" for axis in range(1, 7))),
        ("SPTP XP1 WITH $VEL_AXIS[1]=30",),
    ],
)
def test_a_speed_of_the_first_axis_alone_is_told(rows: tuple[str, ...]) -> None:
    assert ("P416", 2) in codes(read(*rows))


def test_forms_and_lists_that_set_all_axes_are_not_told() -> None:
    form = "SPTP XP1 WITH $VEL_AXIS[1]=SVEL_JOINT(30), $ACC_AXIS[1]=SACC_JOINT(PDEFAULT)"
    assert "P416" not in [code for code, _ in codes(read(form))]
    assert "P416" not in [
        code for code, _ in codes(read(form.replace("=", " = ")))
    ]  # as WorkVisual writes it
    axes = ", ".join(f"$ACC_AXIS[{axis}]=40" for axis in range(1, 7))
    (move,) = body(f"SPTP XP1 WITH {axes}")
    assert isinstance(move, Move)
    assert move.acceleration == Quantity(Number(40), 0.01)
    assert not move.other


def test_initmov_chooses_the_first_tool_and_the_world() -> None:
    tools = [one for one in body("BAS(#INITMOV,0)") if isinstance(one, (SetTool, SetFrame))]
    assert [one.tool if isinstance(one, SetTool) else one.frame for one in tools] == [
        FrameRef("base"),
        FrameRef("tool", Number(1)),
    ]


def test_a_component_of_the_base_changes_that_component_only() -> None:
    frame = one("$BASE.Z=$BASE.Z+5").frame
    current = SystemValue("current-frame")
    assert frame.arguments[0] == Member(current, "x")
    assert frame.arguments[2] == Binary("+", Member(current, "z"), Number(5))


def test_the_work_on_the_flange_ends_where_the_mode_is_base_again() -> None:
    assert body("$IPO_MODE=#TCP", "$IPO_MODE=#BASE")[1] == ExternalTool(0, None)


# --- flow ------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("line", "statement"),
    [
        ("WAIT SEC 0.35", Dwell(0, Quantity(Number(0.35), 1.0))),
        ("WAIT FOR $IN[7]", Wait(0, Signal("in", Number(7)))),
        ("HALT", Pause(0)),
        ("RETURN", Return(0)),
        ("RETURN (n+1)", Return(0, Binary("+", Named("n"), Number(1)))),
        ("again:", Label(0, "again")),
        ("PULSE ($OUT[3],TRUE,0.5)", PulseOutput(0, Signal("out", Number(3)), Quantity(Number(0.5), 1.0))),
        ("$OUT[3]=FALSE", SetOutput(0, Signal("out", Number(3)), SignalState(False))),
        ("$ANOUT[1]=0.5", SetOutput(0, Signal("analog-out", Number(1)), Number(0.5))),
        ("$FLAG[2]=TRUE", SetOutput(0, Signal("flag", Number(2)), SignalState(True))),
        ("grip (1,,n)", Call(0, "grip", (Number(1), Unknown(""), Named("n")))),
        ("msg(text[])", Call(0, "msg", (Item(Named("text"), ()),))),
        ('MsgNotify("full")', Message(0, Text("full"))),
        ("$TIMER[4]=0", Assign(0, SystemValue("timer", 4), Number(0))),
        ("$TIMER[4]=-1500", Assign(0, SystemValue("timer", 4), Number(-1.5))),
        ("$TIMER_STOP[4]=FALSE", Assign(0, SystemValue("timer-running", 4), SignalState(True))),
        ("n=$TIMER[4]", Assign(0, Named("n"), Binary("*", SystemValue("timer", 4), Number(1000)))),
        ("CONTINUE", Process(0, "continue", (("", Text("CONTINUE")),))),
        (
            "INTERRUPT ON 4",
            Process(
                0, "interrupt", (("", Text("INTERRUPT ON 4")), ("watch", Text("on")), ("number", Number(4)))
            ),
        ),
        ("INTERRUPT ON 3", Process(0, "stop-handler", (("", Text("INTERRUPT ON 3")),))),
        ("EXT BAS (BAS_COMMAND :IN,REAL :IN )", Opaque(0, "EXT BAS (BAS_COMMAND :IN,REAL :IN )")),
    ],
)
def test_statements(line: str, statement: object) -> None:
    assert one(line) == statement


def test_blocks() -> None:
    found = body(
        "LOOP", "IF n>1 THEN", "EXIT", "ELSE", "HALT", "ENDIF", "ENDLOOP",
        "FOR n=1 TO 9 STEP 2", "ENDFOR", "WHILE NOT b", "ENDWHILE", "REPEAT", "UNTIL n==3",
        "SWITCH n", "CASE 1,2", "DEFAULT", "ENDSWITCH", "GOTO out", "out:",
    )  # fmt: skip
    assert found[0] == While(0, SignalState(True))
    assert found[1] == If(0, Compare(">", Named("n"), Number(1)))
    assert found[2] == Break(0)
    assert found[6] == EndWhile(0)
    assert found[7:9] == (For(0, Named("n"), Number(1), Number(9), Number(2)), Next(0, None))
    assert found[9] == While(0, Unary("not", Named("b")))
    assert found[11:13] == (Repeat(0), Until(0, Compare("=", Named("n"), Number(3))))
    assert found[13:15] == (Switch(0, Named("n")), Case(0, (Number(1), Number(2))))
    assert found[17] == Jump(0, "out")


# --- expressions -----------------------------------------------------------------------------------------


def value(text: str, *declarations: str) -> object:
    return body(*declarations, f"r={text}")[-1].value  # type: ignore[union-attr]


def test_numbers() -> None:
    assert value("'H1F'") == Number(31)
    assert value("'B0110'") == Number(6)
    assert value("1.5E-3") == Number(0.0015)
    assert value("-2") == Number(-2)
    assert value(".5") == Number(0.5)


def test_multiplication_binds_before_addition_and_a_product_of_frames_before_all() -> None:
    assert value("a+b*c") == Binary("+", Named("a"), Binary("*", Named("b"), Named("c")))
    assert value("(a+b)*c") == Binary("*", Binary("+", Named("a"), Named("b")), Named("c"))
    assert value("a-b-c") == Binary("-", Binary("-", Named("a"), Named("b")), Named("c"))
    assert value("INV_POS(a):b") == Function(
        "pose-product", (Function("pose-inverse", (Named("a"),)), Named("b"))
    )


def test_a_quotient_of_two_integers_is_cut() -> None:
    assert value("i/j", "INT i,j") == Binary("div", Named("i"), Named("j"))
    assert value("i/j", "REAL i", "INT j") == Binary("/", Named("i"), Named("j"))
    assert value("7/2") == Binary("div", Number(7), Number(2))
    assert value("7/2.0") == Binary("/", Number(7), Number(2.0))


def test_and_binds_before_or_and_not_before_both() -> None:
    a, b, c = Named("a"), Named("b"), Named("c")
    assert value("a OR b AND c") == Logic(a, (("or", Logic(b, (("and", c),))),))
    assert value("NOT a AND b") == Logic(Unary("not", a), (("and", b),))
    assert value("a EXOR b") == Binary("xor", a, b)
    assert value("a B_AND b") == Binary("and", a, b)


def test_a_comparison_beside_and_binds_last_where_both_readings_make_sense() -> None:
    program = read("BOOL a,b,r", "r=a==b AND r")
    assert codes(program) == [("P414", 3)]
    a, b, r = Named("a"), Named("b"), Named("r")
    assert program.routines[0].body[-1].value == Compare("=", a, Logic(b, (("and", r),)))  # type: ignore[union-attr]


def test_a_comparison_of_numbers_beside_and_binds_first() -> None:
    program = read("WAIT FOR n==1 AND b")
    assert codes(program) == [("P414", 2)]
    left = Compare("=", Named("n"), Number(1))
    assert program.routines[0].body[0].condition == Logic(left, (("and", Named("b")),))  # type: ignore[union-attr]


def test_members_and_elements() -> None:
    assert value("p.X") == Member(Named("p"), "x")
    assert value("p.A") == Member(Named("p"), "rz")
    assert value("q.A3", "E6AXIS q") == Item(Named("q"), (Number(3),))
    assert value("q[2].A3", "E6AXIS q[5]") == Item(Item(Named("q"), (Number(2),)), (Number(3),))
    assert value("s.b[3].x", "STRUC T INT a, FRAME b[4]", "DECL T s") == Member(
        Item(Member(Named("s"), "b"), (Number(3),)), "x"
    )
    assert value("$AXIS_ACT.A2") == Item(SystemValue("current-joints"), (Number(2),))
    assert value("$POS_ACT.Z") == Member(SystemValue("current-pose"), "z")
    assert value("#READY") == Text("#READY")


# --- declarations and files ------------------------------------------------------------------------------


def test_declarations_with_and_without_decl() -> None:
    found = body("DECL INT i,j", "REAL r[3,4]", "GLOBAL DECL E6POS p", "CONST BOOL b=TRUE", "CHAR c[80]")
    assert found[0] == Declare(0, "i", "integer", native="INT")
    assert found[2] == Declare(0, "r", "real", None, (Number(3), Number(4)), native="REAL")
    assert (found[3].type, found[3].shared) == ("position", True)  # type: ignore[union-attr]
    assert (found[4].storage, found[4].value) == ("constant", SignalState(True))  # type: ignore[union-attr]
    assert found[5].type == "string"  # type: ignore[union-attr]


def test_structures_enumerations_and_signals() -> None:
    found = body("ENUM CLR RED,BLUE", "STRUC PT INT n, REAL x,y[2]", "SIGNAL grip $OUT[5]", "grip=TRUE")
    assert found[0].value == RecordLiteral("ENUM", (("", Text("#RED")), ("", Text("#BLUE"))))  # type: ignore[union-attr]
    assert [name for name, _ in found[1].value.members] == ["n", "x", "y"]  # type: ignore[union-attr]
    assert found[2].value == Signal("out", Number(5))  # type: ignore[union-attr]
    assert found[3] == SetOutput(0, Signal("out", Number(5)), SignalState(True))
    group = body("SIGNAL code $IN[1] TO $IN[8]", "r=code")
    assert group[1] == Assign(0, Named("r"), Signal("in-group", Text("code")))


def test_capitals_do_not_matter_and_names_keep_their_first_spelling() -> None:
    found = body("decl int Count", "COUNT=count+1", "ptp xp1", "Lin XP1 c_dis")
    assert found[1] == Assign(0, Named("Count"), Binary("+", Named("Count"), Number(1)))
    assert found[2].targets == found[3].targets == (Named("xp1"),)  # type: ignore[union-attr]
    assert found[3].blend == Blend(BlendKind.RADIUS)  # type: ignore[union-attr]


def test_a_semicolon_in_a_text_begins_no_comment() -> None:
    found = body('t[]="a;b" ; said', "; alone")
    assert found == (Assign(0, Item(Named("t"), ()), Text("a;b"), " said"), Comment(0, " alone"))


def test_every_line_has_a_kind() -> None:
    program = read("", "; c", "PTP X1", "PTP (", "EXT A ( )", dat=["DECL POS X1={X 1,Y 2,Z 3,A 4,B 5,C 6}"])
    kinds = [LineKind.STATEMENT, LineKind.BLANK, LineKind.COMMENT, LineKind.STATEMENT, LineKind.ERROR,
             LineKind.OPAQUE, LineKind.STATEMENT]  # fmt: skip
    assert list(program.line_kinds) == kinds
