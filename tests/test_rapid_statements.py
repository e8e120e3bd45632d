"""RAPID: what instructions mean."""

from __future__ import annotations

import math

import numpy as np
import pytest
from rapid_modules import NO_AXES, codes, errors, module, move, read, statement, statements

from olp.core.diagnostic import OlpError
from olp.core.units import deg, mm
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
    NamedArgument,
    Number,
    Quantity,
    Signal,
    SignalState,
    SystemValue,
    Text,
    Unary,
    Unknown,
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
    EndIf,
    EndSwitch,
    EndWhile,
    For,
    If,
    Jump,
    Label,
    LineKind,
    Message,
    Next,
    Opaque,
    Path,
    Pause,
    Process,
    PulseOutput,
    Return,
    SetAcceleration,
    SetOutput,
    SetOverride,
    ShiftOff,
    ShiftOn,
    Speed,
    SpeedUnit,
    Switch,
    Update,
    Wait,
    While,
)
from olp.runtime.plan import BlendCode
from olp.timing.timing import time_plan
from olp.transpile.convert import convert, export

TRAVEL = SpeedUnit.TRAVEL


def speed(value: float, native: str) -> Speed:
    return Speed(TRAVEL, Quantity(Number(value), mm), native)


def zone(value: float, native: str) -> Blend:
    return Blend(BlendKind.RADIUS, Quantity(Number(value), mm), native)


# --- moves ----------------------------------------------------------------------------------------------------


def test_a_linear_move_names_its_speed_zone_tool_and_work_object() -> None:
    found = move("MoveL p10,v200,z15,tGrip\\WObj:=wTable;")
    assert (found.path, found.targets) == (Path.LINEAR, (Named("p10"),))
    assert found.speed == speed(200, "v200")
    assert found.turn == Quantity(Number(500), deg)
    assert found.blend == zone(15, "z15")
    assert (found.tool, found.frame) == (Named("tGrip"), Named("wTable"))


def test_tool0_and_wobj0_are_the_flange_and_the_base() -> None:
    for text in ("MoveJ p,v5,fine,tool0;", "MOVEJ p , V5 , FINE , TOOL0 \\Wobj:=WOBJ0 ;"):
        found = move(text)
        assert (found.path, found.tool, found.frame) == (
            Path.JOINT,
            FrameRef("tool", Number(0)),
            FrameRef("base"),
        )
        assert found.blend == zone(0, "fine")


@pytest.mark.parametrize(
    ("name", "radius"),
    [("z0", 0.3), ("z1", 1), ("z5", 5), ("z10", 10), ("z60", 60), ("z100", 100), ("z200", 200), ("fine", 0)],
)
def test_the_predefined_zones_have_the_radii_of_the_manual(name: str, radius: float) -> None:
    assert move(f"MoveL p,v100,{name},t;").blend == zone(radius, name)


@pytest.mark.parametrize(
    ("name", "value"), [("v5", 5), ("v80", 80), ("v1500", 1500), ("v7000", 7000), ("vmax", 5000)]
)
def test_the_predefined_speeds_are_mm_per_second(name: str, value: float) -> None:
    found = move(f"MoveL p,{name},fine,t;")
    assert found.speed == speed(value, name)
    assert found.speed.value.literal == pytest.approx(value / 1000)


def test_a_circular_move_has_its_via_point() -> None:
    found = move("MoveC p1,p2,v150,z10,t\\WObj:=w;")
    assert (found.path, found.via, found.targets) == (Path.CIRCULAR, Named("p1"), (Named("p2"),))


def test_a_time_overrides_the_speed_and_a_velocity_replaces_it() -> None:
    timed = move("MoveL p,v100\\T:=2.5,z1,t;")
    assert timed.speed == Speed(SpeedUnit.TIME, Quantity(Number(2.5), 1.0), "v100")
    assert move("MoveL p,v100\\V:=37,z1,t;").speed == Speed(TRAVEL, Quantity(Number(37), mm), "v100\\V")
    assert move("MoveL p,v100\\V:=x,z1,t;").speed == Speed(TRAVEL, Quantity(Named("x"), mm), "v100\\V")


def test_a_radius_replaces_that_of_the_zone() -> None:
    assert move("MoveL p,v100,z1\\Z:=7,t;").blend == Blend(BlendKind.RADIUS, Quantity(Number(7), mm), "z1\\Z")


def test_options_may_stand_behind_a_comma() -> None:
    data = 'PERS wobjdata w:=[FALSE,TRUE,"",[[0,0,0],[1,0,0,0]],[[0,0,0],[1,0,0,0]]];'
    one = move("MoveL p1,v100,\\V:=250,z10,\\Z:=3,tGun,\\WObj:=w;", data)
    assert one == move("MoveL p1,v100\\V:=250,z10\\Z:=3,tGun\\WObj:=w;", data)
    assert one.frame == Named("w")


def test_speeds_and_zones_may_be_computed() -> None:
    one = move("MoveL p1,[a,b,500,500],[FALSE,c,1,1,1,1,1],tGun;", ["VAR num a;", "VAR num b;", "VAR num c;"])
    assert one.speed == Speed(TRAVEL, Quantity(Named("a"), mm), "")
    assert one.turn == Quantity(Named("b"), deg)
    assert one.blend == Blend(BlendKind.RADIUS, Quantity(Named("c"), mm), "")


def test_functions_with_options_that_mean_something_else_stay_calls() -> None:
    data = ("VAR robtarget p;", "VAR jointtarget j;", "VAR string s;", "VAR num n;", "VAR errnum e;")
    for text in (
        'p:=CRobT(\\TaskName:="T_ROB2");',
        "j:=CJointT(\\TaskRef:=T_ROB2Id);",
        "j:=CalcJointT(p,tGun\\ErrorNumber:=e);",
        "s:=NumToStr(n,2\\Exp);",
    ):
        one = statement(text, data)
        assert isinstance(one, Assign)
        assert isinstance(one.value, CallValue)


def test_options_of_triggers_and_waits_that_change_what_they_do_leave_them_unknown() -> None:
    for text in (
        "TriggIO t1,5\\DOp:=do1\\DODelay:=0.2,1;",
        "WaitAI ai1,\\GT,5\\MaxTime:=2\\ValueAtTimeout:=n;",
    ):
        one = statement(text, ("VAR triggdata t1;", "VAR num n;"))
        assert isinstance(one, Process)
        assert [name for name, _ in one.arguments] == [""]


def test_the_configuration_of_a_position_is_no_number() -> None:
    data = ("VAR robtarget p;", "VAR robtarget q;")
    for text in ("p.robconf:=q.robconf", "p.robconf.cf6:=1"):
        assert statement(f"{text};", data) == Process(0, "robconf", (("", Text(text)),))


def test_a_weld_moves_as_its_weld_data_say() -> None:
    data = (
        "PERS seamdata s:=[0,0];",
        "PERS welddata w:=[12.5,0,[5,0,24,120,0,0,0,0,0],[0,0,0,0,0,0,0,0,0]];",
    )
    for word, value in (("ArcL", 12.5), ("ArcLEnd", 12.5), ("ArcLStart", 1000)):
        found = move(f"{word} p1,v1000,s,w,z1,tGun;", data).speed
        assert found is not None
        assert found.value == Quantity(Number(value), mm)
    found = move("ArcC p1,p2,v1000,s,elsewhere,z1,tGun;", data).speed
    assert found is not None
    assert found.value == Quantity(Member(Named("elsewhere"), "weld_speed"), mm)


def test_answers_of_dialogs_are_numbers() -> None:
    found = statement("ok:=answer=resYes;", ("VAR btnres answer;", "VAR bool ok;"))
    assert isinstance(found, Assign)
    assert found.value == Compare("=", Named("answer"), Number(6))
    assert read(module((), "VAR btnres answer;")).data[0].type == "real"


def test_options_that_are_not_modelled_are_kept() -> None:
    found = move("MoveL \\Conc,p\\ID:=3,v100,z1\\Inpos:=inpos5,t\\WObj:=w\\Corr\\TLoad:=l;")
    assert found.no_wait
    assert found.other == (
        ("t\\ID", Number(3)),
        ("z\\Inpos", Named("inpos5")),
        ("o\\Corr", NamedArgument("Corr")),
        ("o\\TLoad", Named("l")),
    )


def test_speeds_and_zones_of_ones_own_are_their_numbers_when_nobody_assigns_them() -> None:
    data = ["CONST speeddata vMine:=[12.5,40,5000,1000];", "PERS zonedata zMine:=[FALSE,7.5,9,9,.9,9,.9];"]
    found = move("MoveL p,VMINE,zmine,t;", data)
    assert found.speed == speed(12.5, "vMine")
    assert found.turn == Quantity(Number(40), deg)
    assert found.blend == zone(7.5, "zMine")


def test_a_zone_of_ones_own_that_is_fine_is_a_stop_whatever_its_radius() -> None:
    assert move("MoveL p,v5,zStop,t;", "CONST zonedata zStop:=[TRUE,5,5,5,5,5,5];").blend == zone(0, "zStop")


def test_speeds_that_somebody_assigns_are_members_while_the_program_runs() -> None:
    data = ["VAR speeddata vMine:=[12.5,40,5000,1000];", "VAR zonedata zMine:=[FALSE,7.5,9,9,.9,9,.9];"]
    assignments = ["vMine.v_tcp:=50;", "zMine:=z10;", "MoveL p,vMine,zMine,t;"]
    found = statements(assignments, data)[2]
    assert found.speed == Speed(TRAVEL, Quantity(Member(Named("vMine"), "v_tcp"), mm), "vMine")
    assert found.turn == Quantity(Member(Named("vMine"), "v_ori"), deg)
    assert found.blend == Blend(BlendKind.RADIUS, Quantity(Member(Named("zMine"), "pzone_tcp"), mm), "zMine")


def test_a_parameter_hides_the_predefined_data_of_its_name() -> None:
    text = "MODULE M\nPROC go(speeddata v100)\nMoveL p,v100,fine,t;\nENDPROC\nENDMODULE\n"
    found = read(text).routines[0].body[0]
    assert found.speed.value == Quantity(Member(Named("v100"), "v_tcp"), mm)


def test_speeds_and_zones_may_be_written_out() -> None:
    found = move("MoveL p,[70,30,5000,1000],[FALSE,3,4,5,.5,5,.5],t;")
    assert found.speed == speed(70, "[70,30,5000,1000]")
    assert found.blend == zone(3, "[FALSE,3,4,5,0.5,5,0.5]")


def test_process_moves_are_moves_with_what_belongs_to_the_process_beside_them() -> None:
    arc = move("ArcL p1,v100,sm1,wd5\\Weave:=wv1,z10,tWeld\\WObj:=w;")
    assert (arc.path, arc.targets, arc.blend) == (Path.LINEAR, (Named("p1"),), zone(10, "z10"))
    assert arc.other == (
        ("ArcL", SignalState(True)),
        ("", Named("sm1")),
        ("", Named("wd5")),
        ("\\Weave", Named("wv1")),
    )
    assert move("ArcC p1,p2,v100,sm1,wd5,wv1,z10,tWeld;").via == Named("p1")
    assert move("TriggJ p1,v100,tg1\\T2:=tg2,fine,t;").path is Path.JOINT
    assert move("PaintL p1,v500,ed1,z50,t;").blend == zone(50, "z50")
    spot = move("SpotL p1,vmax,gun1,sp10,tGun;")
    assert (spot.tool, spot.blend, len(spot.other)) == (Named("tGun"), zone(0, ""), 3)
    output = move("MoveLDO p1,v100,z10,t\\WObj:=w,doGlue,1;")
    assert output.tool == Named("t")
    assert output.other[0] == ("MoveLDO", SignalState(True))


def test_a_move_of_external_axes_alone_leaves_the_arm_where_it_is() -> None:
    """Its axis values of the arm are 9E9, which nobody may take for degrees."""
    moved = "MoveExtJ [[9E9,9E9,9E9,9E9,9E9,9E9],[10,9E9,9E9,9E9,9E9,9E9]],vrot10,fine;"
    assert statement(moved) == Process(0, "MoveExtJ", (("", Text(moved[9:-1])),))


def test_a_speed_that_lets_the_tool_not_turn_is_told_and_times_the_move() -> None:
    far = "[[{},0,900],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]]"
    moves = f"MoveJ {far.format(700)},v100,z10,tool0;\nMoveJ {far.format(900)},[100,0,100,100],z10,tool0;"
    moves += f"\nMoveJ {far.format(700)},v100,z10,tool0;"
    timing = time_plan(read(module(moves)).plan("yaskawa/gp25"))
    assert "I301" in [found.code for found in timing.diagnostics]
    assert np.isfinite(timing.duration_s).all()


def test_a_search_watches_its_signal() -> None:
    found = move("SearchL\\Stop,diPart,pFound,p1,v10,t;")
    assert found.search is not None
    assert found.search.signal == Signal("in", Text("diPart"))
    assert found.targets == (Named("p1"),)


def test_a_star_is_a_position_that_only_the_controller_has() -> None:
    program = read(module("MoveL *,v100,z10,t;"))
    assert program.routines[0].body[0].targets == (Unknown("*"),)
    assert codes(program)["P462"] == [3]


def test_places_that_the_editor_keeps_free_are_kept_and_told_where_a_move_needs_them() -> None:
    lines = [
        "MoveL <EXP>,v100,z10,t;",
        "IF <EXP> AND n<2 THEN",
        "n:=<EXP>;",
        "ENDIF",
        "SetDO <ID>,1;",
        "IF n<EXP Stop;",
    ]
    program = read(module(lines, ["VAR num n;", "VAR num EXP;"]))
    assert not errors(program)
    assert codes(program)["P462"] == [5]
    assert all(line in export(program, "rapid").decode() for line in lines)
    assert "I209" in [found.code for found in program.plan().diagnostics]


def test_a_move_of_the_axes_takes_joint_values() -> None:
    found = move(f"MoveAbsJ [[10,-20,30,0,45,-90],{NO_AXES}]\\NoEOffs,v100,fine,tool0;")
    assert found.path is Path.JOINT
    (target,) = found.targets
    assert target.kind == "joint"
    assert target.values == pytest.approx([math.radians(v) for v in (10, -20, 30, 0, 45, -90)])
    assert found.other == (("j\\NoEOffs", NamedArgument("NoEOffs")),)


# --- signals and waits -------------------------------------------------------------------------------------------


def test_outputs_are_switched_by_name() -> None:
    assert statement("SetDO doGrip,1;") == SetOutput(0, Signal("out", Text("doGrip")), SignalState(True))
    assert statement("SetDO doGrip,high;") == SetOutput(0, Signal("out", Text("doGrip")), SignalState(True))
    assert statement("Set Lamp;") == SetOutput(0, Signal("out", Text("Lamp")), SignalState(True))
    assert statement("Reset Lamp;") == SetOutput(0, Signal("out", Text("Lamp")), SignalState(False))
    assert statement("SetGO goCode,12;") == SetOutput(0, Signal("out-group", Text("goCode")), Number(12))
    assert statement("SetAO aoFlow,x/2;").signal == Signal("analog-out", Text("aoFlow"))
    inverted = statement("InvertDO Lamp;")
    assert inverted.value == Unary("not", inverted.signal)


def test_a_pulse_has_its_length() -> None:
    found = statement("PulseDO\\High\\PLength:=0.4,doBlow;")
    assert found == PulseOutput(0, Signal("out", Text("doBlow")), Quantity(Number(0.4), 1.0))
    assert statement("PulseDO doBlow;").duration is None


def test_a_delayed_output_switches_at_once_which_is_told() -> None:
    output, told = statements("SetDO\\SDelay:=0.2,do1,1;")
    assert output == SetOutput(0, Signal("out", Text("do1")), SignalState(True))
    assert told == Disabled(
        0, "SetDO \\SDelay:=0.2,do1,1;", beside="the delay of the output, which switches at once", acts=True
    )


def test_waits_for_signals_have_a_longest_time() -> None:
    on = Compare("=", Signal("in", Text("diReady")), SignalState(True))
    assert statement("WaitDI diReady,1;") == Wait(0, on)
    assert statement("WaitDI diReady,1\\MaxTime:=3;") == Wait(0, on, Quantity(Number(3), 1.0))
    waited, told = statements("WaitUntil diReady=1\\MaxTime:=3\\TimeFlag:=bLate;")
    assert waited == Wait(0, on, Quantity(Number(3), 1.0))
    assert told == Assign(0, Named("bLate"), SystemValue("timed-out"))
    assert statement("WaitAI aiFlow,\\GT,2.5;").condition.operator == ">"


def test_waiting_some_time() -> None:
    assert statement("WaitTime 0.25;") == Dwell(0, Quantity(Number(0.25), 1.0))
    standing, dwell = statements("WaitTime\\InPos,0.5;")
    assert standing == Process(0, "WaitRob", (("", Text("\\InPos")),))
    assert dwell == Dwell(0, Quantity(Number(0.5), 1.0))


def test_a_name_is_a_signal_by_its_use_or_by_its_beginning() -> None:
    program = read(
        module(["WaitDI Part,1;", "IF Part=1 OR di7=0 OR doLamp=1 Stop;", "x:=done;"], "VAR num x;")
    )
    condition = program.routines[0].body[1].condition
    assert condition.first == Compare("=", Signal("in", Text("Part")), SignalState(True))
    assert condition.rest[0][1] == Compare("=", Signal("in", Text("di7")), SignalState(False))
    assert condition.rest[1][1].left == Signal("out", Text("doLamp"))
    assert statement("IF DI_Part=1 Stop;").condition.left == Signal("in", Text("DI_Part"))
    assert statement("IF DONE=1 Stop;").condition.left == Named("DONE")
    assert program.routines[0].body[2].value == Named("done")


def test_functions_read_signals() -> None:
    assert statement("x:=DOutput(Lamp);").value == Signal("out", Text("Lamp"))
    assert statement("x:=GInput(Code);").value == Signal("in-group", Text("Code"))
    tested = statement("IF TestDI(Part) Stop;").condition
    assert tested == Compare("=", Signal("in", Text("Part")), SignalState(True))


# --- values ------------------------------------------------------------------------------------------------------


def value(text: str, data: str = "VAR num a;") -> object:
    return statement(
        f"x:={text};", [data, "VAR num b;", "VAR num c;", "VAR bool p;", "VAR bool q;", "VAR bool r;"]
    ).value


def test_operators_bind_as_in_the_manual() -> None:
    a, b, c = Named("a"), Named("b"), Named("c")
    assert value("a+b*c") == Binary("+", a, Binary("*", b, c))
    assert value("a-b-c") == Binary("-", Binary("-", a, b), c)
    assert value("(a+b)*c") == Binary("*", Binary("+", a, b), c)
    assert value("a DIV b MOD c") == Binary("mod", Binary("div", a, b), c)
    assert value("-a*b") == Binary("*", Unary("-", a), b)
    assert value("a=b") == Compare("=", a, b)


def test_logic_binds_and_before_or_and_not_weakest_in_front() -> None:
    p, q, r = Named("p"), Named("q"), Named("r")
    assert value("p OR q AND r") == Logic(p, (("or", Logic(q, (("and", r),))),))
    assert value("p AND q AND r") == Logic(p, (("and", q), ("and", r)))
    assert value("NOT p AND q") == Unary("not", Logic(p, (("and", q),)))
    assert value("p AND NOT q") == Logic(p, (("and", Unary("not", q)),))
    assert value("p XOR q") == Logic(p, (("xor", q),))


def test_a_quotient_of_whole_numbers_is_a_fraction() -> None:
    found = value("1/2")
    assert found == Binary("/", Number(1.0), Number(2.0))
    assert isinstance(found.left.value, float)
    assert isinstance(found.right.value, float)


def test_numbers_in_all_their_spellings() -> None:
    for text, number in (("0x1F", 31), ("0b101", 5), ("1.5E2", 150.0), (".5", 0.5), ("7.", 7.0), ("12", 12)):
        assert value(text) == Number(number)
    assert value("-2.5") == Number(-2.5)


def test_texts_have_escapes() -> None:
    assert value('"a ""b"" c\\\\d\\0A"') == Text('a "b" c\\d\n')


def test_texts_are_joined_with_plus() -> None:
    assert value('"n="+NumToStr(a,2)') == Function(
        "joined-text", (Text("n="), Function("text-of-value", (Named("a"), Number(2))))
    )


def test_components_of_positions_have_neutral_names() -> None:
    data = "VAR robtarget a;"
    assert value("a.trans.x", data) == Member(Named("a"), "x")
    assert value("a.rot.q3", data) == Member(Named("a"), "q3")
    assert value("a.extax.eax_b", data) == Member(Named("a"), "e2")
    assert value("EulerZYX(\\Y,a.rot)", data) == Member(Named("a"), "ry")
    assert value("a.robax.rax_4", "VAR jointtarget a;") == Item(Named("a"), (Number(4),))
    assert value("a{2}.trans.z", "VAR robtarget a{3};") == Member(Item(Named("a"), (Number(2),)), "z")


def test_assigning_a_part_of_a_position_keeps_the_other() -> None:
    p = Named("p")
    data = "VAR robtarget p;"
    assert statement("p.trans.y:=5;", data) == Assign(0, Member(p, "y"), Number(5))
    moved = statement("p.trans:=[1,2,3];", data)
    assert moved.target == p
    assert moved.value == Function(
        "pose-angles", (Number(1), Number(2), Number(3), *(Member(p, name) for name in ("rx", "ry", "rz")))
    )
    turned = statement("p.rot:=OrientZYX(30,20,10);", data)
    assert turned.value.arguments[3:] == (Number(10), Number(20), Number(30))
    assert turned.value.arguments[:3] == tuple(Member(p, name) for name in "xyz")


def test_functions_of_positions() -> None:
    data = ["VAR robtarget p;"]
    assert statement("q:=Offs(p,1,0,-2);", data).value == Function(
        "pose-offset", (Named("p"), Number(1), Number(0), Number(-2))
    )
    assert statement("q:=RelTool(p,1,2,3\\Rz:=90);", data).value == Function(
        "pose-relative-tool",
        (Named("p"), Number(1), Number(2), Number(3), Number(0), Number(0), Number(90)),
    )
    assert statement("q:=CRobT();", data).value == SystemValue("current-pose")
    assert statement("q:=CJointT();", data).value == SystemValue("current-joints")
    assert statement("q:=Distance(p.trans,[0,0,0]);", data).value.name == "pose-distance"
    assert statement("q:=CalcJointT(p,t\\WObj:=w);", data).value == Function(
        "inverse", (Named("p"), NamedArgument("Tool", Named("t")), NamedArgument("WObj", Named("w")))
    )


def test_clocks_have_names() -> None:
    assert value("ClkRead(a)", "VAR clock a;") == Function("timer", (Named("a"),))
    runs = Function("timer-running", (Named("a"),))
    assert statement("ClkStart a;", "VAR clock a;") == Assign(0, runs, SignalState(True))
    assert statement("ClkStop a;", "VAR clock a;") == Assign(0, runs, SignalState(False))


# --- flow ---------------------------------------------------------------------------------------------------------


def test_an_if_without_then_holds_one_instruction() -> None:
    found = statements(["IF a=1 b:=2;", "IF a=1 GOTO done;", "IF a=1 go 3;", "done:"])
    assert [type(one) for one in found] == [If, Assign, EndIf, Jump, Call, Label]
    assert found[3].condition == found[0].condition == Compare("=", Named("a"), Number(1))


def test_loops_and_branches() -> None:
    found = statements(
        [
            "FOR i FROM 3 TO 1 STEP -1 DO",
            "WHILE a DO",
            "ENDWHILE",
            "ENDFOR",
            "TEST n",
            "CASE 1,2:",
            "DEFAULT:",
            "ENDTEST",
        ]
    )
    assert [type(one) for one in found] == [For, While, EndWhile, Next, Switch, Case, Default, EndSwitch]
    assert found[0] == For(0, Named("i"), Number(3), Number(1), Number(-1))
    assert found[5] == Case(0, (Number(1), Number(2)))


def test_calls_with_options_and_switches() -> None:
    assert statement("weld p1,3\\Speed:=v5\\Fast;") == Call(
        0,
        "weld",
        (
            Named("p1"),
            Number(3),
            NamedArgument("Speed", statement("x:=v5;").value),
            NamedArgument("Fast"),
        ),
    )
    assert statement('%"weld"% 3;') == Call(0, "weld", (Number(3),))
    assert isinstance(statement('%"job"+NumToStr(n,0)%;'), Process)
    assert statement("x:=twice(3\\Up);").value == CallValue("twice", (Number(3), NamedArgument("Up")))


def test_counters_messages_and_stops() -> None:
    assert statement("Incr n;") == Update(0, "+", Named("n"), Number(1))
    assert statement("Decr n;") == Update(0, "-", Named("n"), Number(1))
    assert statement("Add n,-3;") == Update(0, "+", Named("n"), Number(-3))
    assert statement("Clear n;") == Assign(0, Named("n"), Number(0))
    assert statement('TPWrite "hi";') == Message(0, Text("hi"))
    assert statement('TPWrite "n "\\Num:=n;').text.name == "joined-text"
    assert statement("Stop;") == Pause(0)
    assert statement("EXIT;") == Return(0)
    assert statement("RETURN;") == Return(0)


def test_modal_instructions() -> None:
    (rate,) = statement("AccSet 45,100;").rates
    assert rate.value.literal == pytest.approx(0.45)
    found = statements("AccSet 45,70;")
    assert isinstance(found[0], SetAcceleration)
    assert found[1] == Disabled(0, "AccSet 45,70;", beside="how fast the acceleration builds up")
    assert statement("VelSet 60,5000;") == SetOverride(0, Quantity(Number(60), 0.01))
    shifted = statement("PDispSet [[1,2,3],[1,0,0,0]];")
    assert isinstance(shifted, ShiftOn)
    assert shifted.offset.values == pytest.approx((0.001, 0.002, 0.003, 0, 0, 0))
    assert statement("PDispOff;") == ShiftOff(0)
    displaced = statements("PDispOn\\ExeP:=p2,p1,t;")
    assert displaced[0].offset.arguments[0] == Binary("-", Member(Named("p2"), "x"), Member(Named("p1"), "x"))


def test_interrupts_and_controller_instructions_are_kept_word_for_word() -> None:
    connected = statement("CONNECT iVac WITH tVac;")
    assert (connected.name, connected.arguments[0]) == ("interrupt", ("", Text("CONNECT iVac WITH tVac")))
    assert statement("ISignalDI diVac,0,iVac;").arguments[0] == ("", Text("ISignalDI diVac,0,iVac"))
    assert statement("ITimer 2,iVac;").arguments == (("", Text("ITimer 2,iVac")),)
    sent = CallValue("SocketSend", (Named("s"), NamedArgument("Str", Text("a;b"))))
    kept = (("", Text('s\\Str:="a;b"')), ("called", sent))
    assert statement('SocketSend s\\Str:="a;b";') == Process(0, "SocketSend", kept)
    assert statement("ConfL \\Off;") == Disabled(0, "ConfL \\Off;")
    assert statement("<SMT>") == Opaque(0, "<SMT>")


# --- the file -----------------------------------------------------------------------------------------------------


def test_several_modules_headers_attributes_and_routines_of_all_kinds() -> None:
    text = (
        "%%%\n VERSION:1\n LANGUAGE:ENGLISH\n%%%\nMODULE A(SYSMODULE,NOSTEPIN)\nLOCAL PERS num a:=3;\nENDMODULE\n"
        "Module B\nlocal func num f(num x\\num y|switch z,INOUT num w{*})\nreturn x;\nendfunc\n"
        "TRAP t\nENDTRAP\nPROC go()\nENDPROC\nEndModule\n"
    )
    program = read(text)
    assert not errors(program)
    assert [one.name for one in program.routines] == ["f", "t", "go"]
    function = program.routines[0]
    assert (function.returns, function.shared) == ("real", False)
    assert [(p.name, p.optional, p.switch, p.by_reference) for p in function.parameters] == [
        ("x", False, False, False),
        ("y", True, False, False),
        ("z", True, True, False),
        ("w", False, False, True),
    ]
    assert (program.data[0].storage, program.data[0].shared) == ("persistent", False)
    assert program.main == "go"


def test_main_is_the_routine_that_runs_wherever_it_stands() -> None:
    text = "MODULE A\nPROC first(num x)\nENDPROC\nPROC second()\nENDPROC\n{}ENDMODULE\n"
    assert read(text.format("PROC Main()\nENDPROC\n")).main == "Main"
    assert read(text.format("")).main == "second"


def test_names_keep_the_spelling_of_their_declaration() -> None:
    data = ["VAR num nCount;", f"CONST robtarget pPick:=[[0,0,0],[1,0,0,0],[0,0,0,0],{NO_AXES}];"]
    first, second = statements(["MOVEL PPICK,V100,Z10,TGRIP;", "NCOUNT:=ncount+1;"], data)
    assert first.targets == (Named("pPick"),)
    assert second == Assign(0, Named("nCount"), Binary("+", Named("nCount"), Number(1)))


def test_an_instruction_may_go_over_several_lines_with_comments_between() -> None:
    text = ["MoveL", "  p1, ! where", "  v100,", "  z10,t\\WObj:=w; ! how"]
    program = read(module(text))
    assert not errors(program)
    found = [one for one in program.routines[0].body if not isinstance(one, Comment)]
    assert found[0].targets == (Named("p1"),)
    assert (found[0].line, found[0].comment) == (3, " how")
    assert list(program.line_kinds[2:6]) == [
        LineKind.STATEMENT,
        LineKind.STATEMENT,
        LineKind.STATEMENT,
        LineKind.STATEMENT,
    ]


def test_marks_inside_texts_are_no_marks() -> None:
    assert statement('TPWrite "a; ! b ENDPROC";') == Message(0, Text("a; ! b ENDPROC"))


def test_handlers_are_kept_word_for_word_and_never_run() -> None:
    program = read(module(["x:=1;", "ERROR (1,2)", "  x:=2; ! again", "  RETRY;", "UNDO", "  x:=3;"]))
    assert not errors(program)
    assert [one.text for one in program.routines[0].body if isinstance(one, Disabled)] == [
        "ERROR (1,2)",
        "x:=2; ! again",
        "RETRY;",
        "UNDO",
        "x:=3;",
    ]
    assert codes(program)["P461"] == [4]


def test_structures_of_ones_own_have_members() -> None:
    data = ["RECORD part", "num id;", "pos where;", "ENDRECORD", "CONST part one:=[3,[10,20,30]];"]
    program = read(module("x:=one.where.y;", data))
    assert not errors(program)
    value = next(d.value for d in program.data if d.name == "one")
    assert [name for name, _ in value.members] == ["id", "where"]
    assert value.members[1][1].values[:3] == pytest.approx((0.01, 0.02, 0.03))
    assert program.routines[0].body[0].value == Member(Member(Named("one"), "where"), "y")


def test_comments_above_a_routine_belong_to_it() -> None:
    program = read("MODULE M\n! about a\nPROC a() ! short\n! inside\nENDPROC\nENDMODULE\n")
    (routine,) = program.routines
    assert [(one.line, one.text) for one in routine.body] == [(2, " about a"), (3, " short"), (4, " inside")]


def test_cp1252_letters_survive() -> None:
    text = module('TPWrite "Größe";', "VAR num nMaß;").encode("cp1252")
    from olp.core.source import decode
    from olp.fluent import read_source

    program = read_source(decode(text, "a.mod"), vendor="rapid")
    assert program.to_bytes() == text
    assert program.data[0].name == "nMaß"


def test_an_operand_behind_a_decided_condition_is_not_evaluated():
    counted = (
        "VAR num a{3}:=[4,5,6];",
        "VAR num n:=0;",
        "FUNC bool up()",
        "n:=n+1;",
        "RETURN TRUE;",
        "ENDFUNC",
    )
    body = (
        "FOR i FROM 1 TO 5 DO",
        "IF i<=3 AND a{i}>4 OR i>4 OR up() WaitTime 1;",
        "ENDFOR",
        "WaitTime 10*n;",
    )
    plan = read(module(body, counted)).plan()
    assert not plan.diagnostics
    assert sum(plan.durations) == 1 + 1 + 1 + 1 + 1 + 20


def test_a_zone_whose_finep_is_assigned_stops_where_it_is_true():
    data = ("VAR zonedata z:=[FALSE,30,30,30,3,30,3];", *(f"CONST robtarget p{n}:=[[{n}00,0,400],[0,1,0,0],"
            "[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];" for n in (4, 5, 6, 7)))  # fmt: skip
    body = ("MoveL p4,v100,z,tool0;", "z.finep:=TRUE;", "MoveL p5,v100,z,tool0;", "z.finep:=FALSE;",
            "z.pzone_tcp:=20;", "MoveL p6,v100,z,tool0;", "MoveL p7,v100,fine,tool0;")  # fmt: skip
    plan = read(module(body, data)).plan()
    assert plan.moves.blend_code.tolist() == [
        BlendCode.ZONE,
        BlendCode.EXACT,
        BlendCode.ZONE,
        BlendCode.EXACT,
    ]


def test_a_zone_whose_finep_is_assigned_is_no_corner_in_another_language():
    zone = "VAR zonedata z:=[FALSE,30,30,30,3,30,3];"
    point = "CONST robtarget p:=[[400,0,400],[0,1,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];"
    program = read(module(("z.finep:=TRUE;", "MoveL p,v100,z,tool0;"), (zone, point)))
    for target in ("inform", "krl", "tp", "urscript"):
        with pytest.raises(OlpError, match="zone-or-stop"):
            convert(program, target)
    assert convert(program, "rapid").files


@pytest.mark.parametrize("row", ["CornerPathWarning FALSE;", "UseReachableTargets TRUE;", "RecoveryMenu;"])
def test_instructions_of_options_are_known(row: str) -> None:
    found = read(module(row)).plan(robot="abb/irb2600-12-1.65").diagnostics
    assert "I102" not in {one.code for one in found}
