"""RAPID: what is written, of programs read from it and from other languages."""

from __future__ import annotations

import math
import random
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from rapid_modules import NO_AXES, again, errors, module, read, without_lines

import olp
from olp.core.diagnostic import OlpError, raise_errors
from olp.core.source import decode
from olp.core.units import deg, mm
from olp.ir.expressions import (
    Binary,
    Compare,
    Expression,
    FrameRef,
    Function,
    Item,
    Logic,
    Member,
    Named,
    Number,
    PositionLiteral,
    Quantity,
    Signal,
    SignalState,
    SystemValue,
    Text,
    Unary,
)
from olp.ir.points import PointTable
from olp.ir.program import (
    Assign,
    Blend,
    BlendKind,
    Break,
    Call,
    Comment,
    Declare,
    Disabled,
    Move,
    Process,
    Program,
    Return,
    Routine,
    SetOutput,
    Speed,
    SpeedUnit,
    Statement,
    Wait,
)
from olp.ir.program import (
    Path as Way,
)
from olp.languages.templating import shipped
from olp.languages.vendors.rapid.writer import write

SAMPLES = Path(__file__).resolve().parent.parent / "samples" / "rapid"


# --- its own programs -----------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["handling.mod", "pallet.prg"])
def test_a_sample_written_and_read_means_the_same(name: str) -> None:
    program = olp.read(SAMPLES / name)
    assert not errors(program)
    second = again(program)
    assert not errors(second)
    assert without_lines(second) == without_lines(program)
    assert again(second).to_bytes() == second.to_bytes()


def test_lines_end_with_crlf_and_the_encoding_is_the_files() -> None:
    raw = module('TPWrite "Größe";').encode("cp1252")
    out = olp.fluent.read_source(decode(raw, "a.mod"), vendor="rapid").export("rapid")
    assert out.count(b"\r\n") == out.count(b"\n") > 3
    assert "Größe".encode("cp1252") in out


def test_names_comments_and_order_survive() -> None:
    text = olp.read(SAMPLES / "pallet.prg").export("rapid").decode("cp1252")
    for words in (
        "MODULE PalletData(SYSMODULE,NOSTEPIN)",
        "pos pitch; ! between two cartons",
        "TASK PERS wobjdata wPallet:=",
        "VAR layers nLayer:=1;",
        "! Fills one pallet.\r\n  PROC main()",
        "AccSet 80,60; ! cartons are not fixed",
        "IF nLayer>2 bFull:=TRUE;",
        "TriggL Offs(pHere,0,0,60),vCarry,tgBlow\\T2:=tgLight,zCarry,tSucker\\WObj:=wPallet;",
        'TPWrite "no carton"; ! the belt is empty',
        "LOCAL TRAP tLost",
    ):
        assert words in text


# Instructions that come back as they were, to the letter.
KEPT = [
    "MoveL p,v100,z10,t\\WObj:=w;",
    "MoveL \\Conc,p\\ID:=3,v100\\V:=20,z1\\Z:=7\\Inpos:=inpos5,t\\WObj:=w\\Corr;",
    "MoveC p,q,v100\\T:=2.5,fine,tool0;",
    f"MoveAbsJ [[10,-20,30,0,45,-90],{NO_AXES}]\\NoEOffs,v100,fine,tool0;",
    "MoveJ [[1.5,-2,3],[0.7071,0,0.7071,0],[1,-1,0,4],[120.5,9E9,9E9,9E9,9E9,9E9]],v5,z0,t;",
    "MoveL Offs(p,0,0,-2.5),[70,30,5000,1000],[FALSE,3,4,5,0.5,5,0.5],t;",
    "MoveL RelTool(p,1,2,3\\Rx:=10\\Rz:=-90),vmax,z200,t;",
    "MoveL p,vOwn,zOwn,t;",
    "ArcC p,q,v100,sm1,wd5\\Weave:=wv1,z10,t\\WObj:=w;",
    "MoveLDO p,v100,z10,t\\WObj:=w,doGlue,1;",
    "SearchL \\Stop,di1,sp,p,v10,t;",
    "SpotL p,vmax,gun1,sp10,t;",
    "MoveExtJ j\\ID:=2,v100,fine;",
    "q:=p;",
    "p.trans:=[1,2,n];",
    "p.trans:=q.trans;",
    "p.rot:=OrientZYX(n,0,10);",
    "p.rot:=q.rot;",
    "p.trans.x:=q.trans.y + 1;",
    "p.extax.eax_b:=3;",
    "j.robax.rax_3:=-n;",
    "j.robax:=[1,2,3,n,5,6];",
    f"p:=[[n,2,3],[1,0,0,n],[0,0,0,0],{NO_AXES}];",
    f"p:=[q.trans,OrientZYX(n,0,0),[1,0,0,0],{NO_AXES}];",
    "pp:=PoseMult(PoseInv(pp),[[1,2,3],[1,0,0,0]]);",
    "n:=Distance(p.trans,[0,0,n]) + EulerZYX(\\Y,p.rot);",
    "p:=CRobT(\\Tool:=t\\WObj:=w);",
    "j:=CalcJointT(p,t\\WObj:=w);",
    "p:=CalcRobT(j,t);",
    "n:=-(a + b) * c - a / 2 DIV (-b);",
    "n:=Pow(2,a) + Sqrt(Abs(b)) - ATan2(a,b) + Round(c\\Dec:=2);",
    "flag:=(NOT (flag OR a>1)) AND b<>2 XOR flag;",
    "flag:=flag AND di1=0;",
    's:="a ""b"" \\\\" + ValToStr(n) + NumToStr(n,2);',
    "SetDO doGrip,1;",
    "SetGO goCode,n + 1;",
    "InvertDO doLamp;",
    "PulseDO \\High\\PLength:=0.4,doBlow;",
    "WaitDI di1,0\\MaxTime:=2;",
    "WaitUntil flag AND di1=1\\MaxTime:=n\\TimeFlag:=flag;",
    "WaitAI aiFlow,\\GT,2.5;",
    "WaitTime 0.25;",
    "IF a=1 GOTO done;",
    "IF a=1 AND flag n:=2;",
    "IF flag RETURN;",
    "weld p,3\\Speed:=v5\\Fast;",
    '%"weld"% 3;',
    "%s% 3,p;",
    "Incr n;",
    "Decr n;",
    "Add n,-3;",
    'TPWrite "n "\\Num:=n;',
    "Stop;",
    "EXIT;",
    "AccSet 45,100;",
    "AccSet 45,70\\FinePointRamp:=50;",
    "VelSet 60,2000;",
    "PDispSet [[1,2,3],[1,0,0,0]];",
    "PDispOn \\Rot\\ExeP:=q,p,t;",
    "PDispOff;",
    "CONNECT iVac WITH tVac;",
    "ISignalDI diVac,0,iVac;",
    'SocketSend sock\\Str:="a;b";',
    "ConfL \\Off;",
    "TPErase;",
    "RAISE 5;",
]
DATA = [
    f"VAR robtarget p:=[[9,8,7],[1,0,0,0],[0,0,0,0],{NO_AXES}];",
    "VAR robtarget q;",
    "VAR pose pp;",
    "VAR jointtarget j;",
    "VAR num n;",
    "VAR num a;",
    "VAR num b;",
    "VAR num c;",
    "VAR bool flag;",
    "VAR string s;",
    "CONST speeddata vOwn:=[12.5,40,5000,1000];",
    "CONST zonedata zOwn:=[FALSE,7.5,9,9,0.9,9,0.9];",
]


@pytest.mark.parametrize("line", KEPT)
def test_an_instruction_comes_back_to_the_letter(line: str) -> None:
    program = read(module([line, "done:"], DATA))
    assert not errors(program)
    written = program.export("rapid").decode("cp1252").split("\r\n")
    assert f"    {line}" in written
    assert without_lines(again(program)) == without_lines(program)


# --- random programs ------------------------------------------------------------------------------------------------

numbers = st.one_of(
    st.integers(-999, 999), st.floats(-1000, 1000, allow_nan=False).map(lambda v: round(v, 4)), st.just(0.5)
)
names = st.sampled_from(
    ["n", "a", "b", "arr{2}", "p.trans.x", "q.rot.q3", "j.robax.rax_2", "pi", "f(a)", "f(1,n)"]
)


def arithmetic() -> st.SearchStrategy[str]:
    leaf = st.one_of(numbers.map(str), names)
    return st.recursive(
        leaf,
        lambda inner: st.one_of(
            st.tuples(inner, st.sampled_from(["+", "-", "*", "/", " DIV ", " MOD "]), inner).map("".join),
            inner.map(lambda text: f"({text})"),
            inner.map(lambda text: f"-({text})"),
            inner.map(lambda text: f"Abs({text})"),
        ),
        max_leaves=6,
    ).filter(lambda text: "--" not in text and "+-" not in text)


def conditions() -> st.SearchStrategy[str]:
    compared = st.tuples(arithmetic(), st.sampled_from(["=", "<>", "<", ">=", ">"]), arithmetic()).map(
        "".join
    )
    leaf = st.one_of(compared, st.just("flag"), st.sampled_from(["di1=1", "do2=0", "TRUE"]))
    return st.recursive(
        leaf,
        lambda inner: st.one_of(
            st.tuples(inner, st.sampled_from([" AND ", " OR ", " XOR "]), inner).map("".join),
            inner.map(lambda text: f"NOT ({text})"),
            inner.map(lambda text: f"({text})"),
        ),
        max_leaves=5,
    )


def quaternions() -> st.SearchStrategy[str]:
    def text(seed: int) -> str:
        chance = random.Random(seed)
        q = [chance.gauss(0, 1) for _ in range(4)]
        size = math.sqrt(sum(v * v for v in q))
        return "[" + ",".join(f"{v / size:.{chance.choice((4, 6, 9))}f}" for v in q) + "]"

    return st.integers(0, 10**6).map(text)


def targets() -> st.SearchStrategy[str]:
    written = st.tuples(numbers, numbers, numbers, quaternions()).map(
        lambda v: f"[[{v[0]},{v[1]},{v[2]}],{v[3]},[0,-1,0,1],{NO_AXES}]"
    )
    moved = st.tuples(st.sampled_from(["Offs", "RelTool"]), st.sampled_from(["p", "q"]), arithmetic()).map(
        lambda v: f"{v[0]}({v[1]},{v[2]},0,1)"
    )
    return st.one_of(st.sampled_from(["p", "q"]), written, moved)


def simple() -> st.SearchStrategy[str]:
    tail = st.tuples(
        st.sampled_from(["v100", "v5\\V:=33", "v80\\T:=2", "vOwn", "vMoved"]),
        st.sampled_from(["fine", "z5", "z5\\Z:=3", "zOwn", "zMoved"]),
        st.sampled_from(["tool0", "t\\WObj:=w", "t"]),
    ).map(",".join)
    return st.one_of(
        st.tuples(st.sampled_from(["MoveL ", "MoveJ "]), targets(), st.just(","), tail).map("".join),
        st.tuples(st.just("MoveC "), targets(), st.just(","), targets(), st.just(","), tail).map("".join),
        arithmetic().map(lambda text: f"n:={text}"),
        conditions().map(lambda text: f"flag:={text}"),
        conditions().map(lambda text: f"WaitUntil {text}"),
        targets().map(lambda text: f"p:={text}"),
        arithmetic().map(lambda text: f"p.rot:=OrientZYX({text},0,n)"),
        arithmetic().map(lambda text: f"vMoved.v_tcp:={text}"),
        arithmetic().map(lambda text: f"zMoved.pzone_tcp:={text}"),
        arithmetic().map(lambda text: f"arr{{1}}:={text}"),
        st.sampled_from(
            ["SetDO do1,1", "WaitTime 0.5", "RETURN", "Stop", "go n,a\\Fast", "PDispOff", "Incr n"]
        ),
    ).map(lambda text: f"{text};")


def blocks() -> st.SearchStrategy[list[str]]:
    def around(inner: st.SearchStrategy[list[str]]) -> st.SearchStrategy[list[str]]:
        return st.one_of(
            st.tuples(conditions(), inner, inner).map(
                lambda v: [f"IF {v[0]} THEN", *v[1], f"ELSEIF NOT ({v[0]}) THEN", *v[2], "ELSE", "ENDIF"]
            ),
            st.tuples(conditions(), inner).map(lambda v: [f"WHILE {v[0]} DO ! again", *v[1], "ENDWHILE"]),
            st.tuples(arithmetic(), inner).map(
                lambda v: [f"FOR i FROM 1 TO {v[0]} STEP 2 DO", *v[1], "ENDFOR"]
            ),
            st.tuples(inner, inner).map(
                lambda v: ["TEST n", "CASE 1,-2:", *v[0], "DEFAULT:", *v[1], "ENDTEST ! done"]
            ),
            st.tuples(conditions(), simple()).map(lambda v: [f"IF {v[0]} {v[1]}"]),
            st.tuples(inner, inner).map(lambda v: [*v[0], "! a word", *v[1]]),
        )

    return st.recursive(simple().map(lambda text: [text]), around, max_leaves=6)


RANDOM = [
    *DATA,
    "VAR num arr{3}:=[1,2.5,-3];",
    "VAR speeddata vMoved:=[10,20,5000,1000];",
    "VAR zonedata zMoved:=[FALSE,1,2,2,0.2,2,0.2];",
]
FUNCTION = "FUNC num f(num x\\num y)\r\nRETURN x;\r\nENDFUNC\r\nENDMODULE"


@settings(max_examples=120, deadline=None)
@given(blocks())
def test_any_program_written_and_read_means_the_same(body: list[str]) -> None:
    program = read(module(body, RANDOM).replace("ENDMODULE", FUNCTION))
    assert not errors(program), [d.render() for d in program.diagnostics]
    second = again(program)
    assert not errors(second), second.to_bytes().decode()
    assert without_lines(second) == without_lines(program)


# --- programs of other languages ------------------------------------------------------------------------------------

POINT = PositionLiteral("pose", (0.1, -0.2, 0.3, 10 * deg, -20 * deg, 30 * deg))
TOOL = PositionLiteral("pose", (0.01, 0.0, 0.15, 0.0, 0.0, 45 * deg))
FRAME = PositionLiteral("pose", (0.8, 0.1, 0.2, 0.0, 5 * deg, 0.0))
FOREIGN = (
    Declare(1, "p1", "position", POINT, (), "constant"),
    Declare(1, "home", "joints", PositionLiteral("joint", (0.1, 0.2, 0.3, 0.4, 0.5, 0.6)), (), "constant"),
    Declare(1, "grip", "tool", TOOL),
    Declare(1, "table", "frame", FRAME),
    Declare(1, "count", "integer", Number(0)),
    Declare(1, "ready", "boolean", SignalState(False)),
    Declare(1, "speed", "real", Number(0.25)),
)


def foreign(
    *body: Statement, data: tuple[Declare, ...] = FOREIGN, others: tuple[Routine, ...] = ()
) -> Program:
    """A program as translations hand it on."""
    main = Routine("work", 1, body, PointTable())
    return Program("krl", decode(b"\n" * 20, "job.src"), (main, *others), data=data, main="work")


def to(target: Expression, way: Way = Way.LINEAR, **more: object) -> Move:
    values: dict[str, object] = {
        "speed": Speed(SpeedUnit.TRAVEL, Quantity(Number(0.25), 1.0)),
        "blend": Blend(BlendKind.RADIUS, Quantity(Number(0), 1.0)),
        "tool": Named("grip"),
        "frame": Named("table"),
    }
    return Move(1, way, (target,), **{**values, **more})  # type: ignore[arg-type]


def written_by(program: Program) -> str:
    """What the writer itself makes of a program, which a translation has prepared. Raises OlpError."""
    values, problems = write(program, "")
    raise_errors(problems)
    return shipped("rapid").render(values)


def text(*body: Statement) -> str:
    written = written_by(foreign(*body))
    assert not errors(read(written)), written
    return written


def rows(*body: Statement) -> list[str]:
    """The instructions of main, without what stands there for every other language."""
    inside = text(*body).partition("PROC work()\n")[2].partition("  ENDPROC")[0]
    return [row.strip() for row in inside.split("\n") if row.strip() and "Conf" not in row]


def test_points_tools_and_work_objects_are_declared() -> None:
    written = text(to(Named("p1")))
    assert "MODULE job\n" in written
    assert "CONST robtarget p1:=[[100,-200,300]," in written
    assert "CONST jointtarget home:=[[5.729577951," in written
    assert "PERS tooldata grip:=[TRUE,[[10,0,150],[0.923879533,0,0,0.382683432]]," in written
    assert 'PERS wobjdata table:=[FALSE,TRUE,"",[[800,100,200],' in written
    assert "VAR num count:=0;" in written
    assert "VAR bool ready:=FALSE;" in written


def test_poses_of_another_language_let_the_arm_choose() -> None:
    assert "    ConfL \\Off;\n    MoveL" in text(to(Named("p1")))
    assert "ConfJ" not in text(Comment(1, " nothing"))


def test_speeds_and_zones_without_a_name_get_one() -> None:
    blend = Blend(BlendKind.RADIUS, Quantity(Number(0.0125), 1.0))
    slow = Speed(SpeedUnit.TRAVEL, Quantity(Number(0.1205), 1.0))
    turn = Quantity(Number(1.0), 1.0)
    written = text(to(Named("p1"), speed=slow, blend=blend), to(Named("p1"), speed=slow, turn=turn))
    assert "MoveL p1,v120_5,z12_5,grip\\WObj:=table;" in written
    assert "CONST speeddata v120_5:=[120.5,500,5000,1000];" in written
    assert "CONST speeddata v120_5_57_29578:=[120.5,57.29578,5000,1000];" in written
    assert "CONST zonedata z12_5:=[FALSE,12.5,18.75,18.75,1.875,18.75,1.875];" in written


def test_a_speed_of_the_table_is_written_by_its_name() -> None:
    fast = Speed(SpeedUnit.TRAVEL, Quantity(Number(200), mm))
    blend = Blend(BlendKind.RADIUS, Quantity(Number(20), mm))
    assert rows(to(Named("p1"), speed=fast, blend=blend)) == ["MoveL p1,v200,z20,grip\\WObj:=table;"]


def test_computed_speeds_and_times_stand_behind_a_speed_of_the_table() -> None:
    computed = Speed(SpeedUnit.TRAVEL, Quantity(Named("speed"), 1.0))
    timed = Speed(SpeedUnit.TIME, Quantity(Number(1.5), 1.0))
    assert rows(to(Named("p1"), speed=computed), to(Named("p1"), speed=timed)) == [
        "MoveL p1,v1000\\V:=speed * 1000.0,fine,grip\\WObj:=table;",
        "MoveL p1,v1000\\T:=1.5,fine,grip\\WObj:=table;",
    ]


def test_joint_values_are_moved_to_by_axes() -> None:
    assert rows(to(Named("home"), Way.JOINT)) == ["MoveAbsJ home,v250,fine,grip\\WObj:=table;"]


def test_an_arc_has_its_via_point_first() -> None:
    assert rows(to(POINT, Way.CIRCULAR, via=Named("p1")))[0].startswith("MoveC p1,[[100,-200,300],[")


def test_the_acceleration_of_a_move_is_set_before_it_and_taken_back() -> None:
    half = Quantity(Number(0.5), 1.0)
    assert rows(to(Named("p1"), acceleration=half), to(Named("p1"), acceleration=half), to(Named("p1"))) == [
        "AccSet 50,100;",
        "MoveL p1,v250,fine,grip\\WObj:=table;",
        "MoveL p1,v250,fine,grip\\WObj:=table;",
        "AccSet 100,100;",
        "MoveL p1,v250,fine,grip\\WObj:=table;",
    ]


def test_a_routine_that_others_call_does_not_know_the_acceleration() -> None:
    half = Quantity(Number(0.5), 1.0)
    drop = Routine("drop", 5, (to(Named("p1")),), PointTable())
    written = written_by(foreign(to(Named("p1"), acceleration=half), Call(2, "drop"), others=(drop,)))
    assert "  PROC drop()\n    AccSet 100,100;\n    MoveL" in written
    assert "AccSet" not in written_by(foreign(to(Named("p1")), Call(2, "drop"), others=(drop,)))


def test_external_axes_that_a_position_does_not_say_are_not_connected() -> None:
    def declared(external: tuple[float, ...]) -> str:
        point = PositionLiteral("pose", POINT.values, external)
        return written_by(foreign(data=(Declare(1, "p", "position", point),)))

    assert NO_AXES in declared(())
    assert "[0,9E9,12.5,9E9,9E9,9E9]" in declared((0.0, math.nan, 12.5))
    assert "[0,12.5,9E9,9E9,9E9,9E9]" in declared((0.0, 12.5))


def test_conditions_without_precedence_get_parentheses() -> None:
    a, b, c = (Compare("=", Named("count"), Number(n)) for n in (1, 2, 3))
    chain = Logic(a, (("or", b), ("and", c)))
    assert rows(Wait(1, chain)) == ["WaitUntil (count=1 OR count=2) AND count=3;"]
    assert rows(Wait(1, Unary("not", Signal("in", Number(4))))) == ["WaitUntil di4=0;"]
    assert rows(Wait(1, Logic(Unary("not", Named("ready")), (("and", Unary("not", a)),)))) == [
        "WaitUntil (NOT ready) AND (NOT count=1);"
    ]  # the syntax of the kernel manual has NOT at the head alone, and it takes in all that AND joins


def test_signals_with_numbers_get_names() -> None:
    assert rows(
        SetOutput(1, Signal("out", Number(3)), SignalState(True)),
        SetOutput(1, Signal("out-group", Number(2)), Number(9)),
        SetOutput(1, Signal("tool-out", Number(0)), Named("ready")),
        Wait(1, Compare("=", Signal("in", Number(7)), SignalState(False)), Quantity(Number(2), 1.0)),
    ) == [
        "SetDO do3,1;",
        "SetGO go2,9;",
        "IF ready THEN",
        "SetDO doTool0,1;",
        "ELSE",
        "SetDO doTool0,0;",
        "ENDIF",
        "WaitDI di7,0\\MaxTime:=2\\TimeFlag:=olp_timed_out;",
    ]


def test_a_product_of_poses_is_computed_before_it_is_moved_to() -> None:
    product = Function("pose-product", (Named("p1"), POINT))
    first, second = rows(to(product))
    assert first.startswith("olp_pose1:=PoseMult([p1.trans,p1.rot],[[100,-200,300],[")
    assert second == f"MoveL [olp_pose1.trans,olp_pose1.rot,[0,0,0,0],{NO_AXES}],v250,fine,grip\\WObj:=table;"
    assert "LOCAL VAR pose olp_pose1;" in text(to(product))
    third = Function("pose-product", (POINT, Named("p1")))
    assert (
        text(to(product), to(third), to(product)).count("VAR pose olp_pose") == 1
    )  # statement after statement


def test_one_angle_of_a_position_is_set_with_the_others() -> None:
    turned = Assign(1, Member(Named("p1"), "rz"), Binary("+", Member(Named("p1"), "rz"), Number(5)))
    assert rows(turned) == [
        "p1.rot:=OrientZYX(EulerZYX(\\Z,p1.rot) + 5,EulerZYX(\\Y,p1.rot),EulerZYX(\\X,p1.rot));"
    ]
    assert rows(Assign(1, Item(Named("home"), (Number(2),)), Number(10))) == ["home.robax.rax_2:=10;"]


def test_declarations_come_before_the_first_instruction() -> None:
    late = Declare(1, "late", "real", Number(2.5))
    assert rows(Assign(1, Named("count"), Number(1)), late, Assign(1, Named("count"), Named("late"))) == [
        "VAR num late;",
        "count:=1;",
        "late:=2.5;",
        "count:=late;",
    ]


def test_functions_and_parameters() -> None:
    from olp.ir.program import Parameter

    twice = Routine(
        "twice",
        5,
        (Return(6, Binary("*", Named("x"), Number(2))),),
        PointTable(),
        parameters=(Parameter("x", "real", by_reference=True),),
        returns="real",
        shared=False,
    )
    call = Call(1, "twice", (Named("count"),), result=Named("count"))
    written = written_by(foreign(call, others=(twice,)))
    assert "    count:=twice(count);" in written
    assert "  LOCAL FUNC num twice(INOUT num x)\n    RETURN x * 2;\n  ENDFUNC" in written


def test_disabled_instructions_become_comments() -> None:
    assert rows(Disabled(1, "OLD WORDS")) == ["! OLD WORDS"]


@pytest.mark.parametrize(
    "statement",
    [
        Break(3),
        Process(3, "SPOT", (("", Text("x")),)),
        to(Named("p1"), speed=None),
        to(Named("p1"), tool=None),
        to(Named("p1"), tool=FrameRef("tool", Number(4))),
        to(Named("p1"), speed=Speed(SpeedUnit.FRACTION, Quantity(Number(0.5), 1.0))),
        to(Named("p1"), blend=Blend(BlendKind.SPEED, Quantity(Number(0.5), 1.0))),
        to(Named("p1"), relative=FrameRef("base")),
        to(Named("p1"), arc=Quantity(Number(1.0), 1.0)),
        to(Named("p1"), other=(("SPIN", Number(2)),)),
        to(PositionLiteral("pose", (math.nan, 0.0, 0.0, 0.0, 0.0, 0.0))),
        Assign(3, Named("count"), SystemValue("alarm")),
        Assign(3, Named("count"), Function("floor", (Number(1),))),
    ],
    ids=lambda one: type(one).__name__,
)
def test_what_rapid_cannot_say_is_told_and_nothing_is_written(statement: Statement) -> None:
    with pytest.raises(OlpError) as raised:
        written_by(foreign(statement))
    assert {d.code for d in raised.value.diagnostics} == {"X002"}


def test_a_module_has_a_name_of_its_own() -> None:
    source = decode(b"", "12 work-job.src")
    program = Program("krl", source, (Routine("work", 1, (), PointTable()),), main="work")
    assert "MODULE M_12_work_job\n" in written_by(program)
    same = Program("krl", decode(b"", "work.src"), program.routines, main="work")
    assert "MODULE M_work\n" in written_by(same)
