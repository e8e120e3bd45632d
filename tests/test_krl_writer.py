"""KRL written from the neutral program: its own comes back the same, others' in KRL's idioms."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from krl_programs import again, meaning, read, source, written
from translated_texts import translated

import olp
from olp.core.source import decode
from olp.ir.expressions import (
    Binary,
    Compare,
    Expression,
    FrameRef,
    Function,
    Logic,
    Member,
    Named,
    Number,
    PositionLiteral,
    Quantity,
    Signal,
    SignalState,
    Text,
    Unary,
)
from olp.ir.points import PointTable
from olp.ir.program import (
    Assign,
    Blend,
    BlendKind,
    Call,
    Declare,
    Dwell,
    Else,
    EndIf,
    EndWhile,
    If,
    Label,
    Move,
    Opaque,
    Program,
    Routine,
    SetOutput,
    Speed,
    SpeedUnit,
    Statement,
    Wait,
    While,
)
from olp.ir.program import Path as Shape
from olp.languages.templating import shipped
from olp.languages.vendors.krl.reader import read_program
from olp.languages.vendors.krl.writer import BasCalls, KrlWriter, write

SAMPLES = Path(__file__).resolve().parent.parent / "samples" / "krl"

LINES = [
    "BAS (#INITMOV,0)",
    "PDAT_ACT=PPDAT1",
    "FDAT_ACT=FP1",
    "BAS (#PTP_PARAMS,50)",
    "PTP XP1 C_PTP",
    "LDAT_ACT=LCPDAT1",
    "BAS (#CP_PARAMS,0.25)",
    "LIN XP1 C_DIS",
    "CIRC XP1,XP2 C_VEL",
    "CIRC XP1,{X 1.5,Y 2,Z 3,A 4,B 5,C 6},CA -120",
    "PTP {A1 10.25,A2 -90,A3 90,A4 0,A5 15,A6 -20.125,E1 5.5}",
    "LIN {Z 12.375}:XP1:frm C_DIS",
    "LIN_REL {X 10,A 5} #TOOL",
    "LIN_REL {X 10,A 5} C_DIS #TOOL",
    "SLIN_REL {X 10} WITH $VEL.CP=0.2 C_SPL #TOOL",
    "PTP_REL {A1 5}",
    "SLIN XP1 WITH $VEL.CP=0.2, $TOOL=TOOL_DATA[1], $APO.CDIS=4, $LOAD=SLOAD(1) C_SPL",
    "SPTP XP2 C_DIS",
    "SPTP XP1 WITH $VEL_AXIS[1]=SVEL_JOINT(70), $ACC_AXIS[1]=50",
    "$VEL.CP=v*0.5",
    "$VEL.ORI1=150",
    "$ACC.CP=1.25",
    "$ACC_AXIS[1]=40",
    "$APO.CDIS=12.5",
    "$APO.CPTP=75",
    "$TOOL={X 1,Y 2,Z 3,A 4,B 5,C 6}",
    "$BASE=frm:frm",
    "$BASE.Z=5.5",
    "$TOOL=TOOL_DATA[n]",
    "TOOL_DATA[2]={X 1,Y 2,Z 3,A 4,B 5,C 6}",
    "TOOL_DATA[n]=frm",
    "BASE_DATA[3]=frm:frm",
    "BASE_DATA[1].Z=12.5",
    "$BASE=$NULLFRAME",
    "$OV_PRO=80",
    "$IPO_MODE=#TCP",
    "BAS(#FRAMES)",
    "BAS(#TOOL,3)",
    "BAS(#BASE,2)",
    "$OUT[n+1]=NOT $IN[3]",
    "$OUT[4]=b AND ($IN[2] OR NOT b)",
    "n=n+1",
    "v=-3*(v-2)/7.5",
    "n=n/2",
    "n=7/2",
    "v=SQRT(ABS(v))",
    "b=(n>1) AND (v<=2.5) OR b",
    "b=b EXOR $IN[1]",
    "n=n B_AND 'H0F'",
    "n=B_NOT n",
    "XP1.X=XP2.A-v",
    "ax.A3=ax.A4+1",
    "arr[2,n]=5",
    "col=#RED",
    "b=col==#BLUE",
    'txt[]="a;b"',
    "st.m.Y=3",
    "XP1=XP2",
    "WAIT SEC 0.35",
    "WAIT FOR $IN[7] AND b",
    "PULSE ($OUT[2],TRUE,0.5)",
    "HALT",
    "CONTINUE",
    "TRIGGER WHEN DISTANCE=0 DELAY=20 DO $OUT[1]=TRUE",
    "grip (1,n)",
    "r (n,,b)",
    "n=half(n)",
    'MsgNotify("hi")',
    "INTERRUPT DECL 4 WHEN $IN[2] DO grip (1,n)",
    "; said",
    "PTP XP1 ; home",
    "FDAT_ACT=FP2",
    "v=1E-3",
    "n=-4",
    "b=TRUE",
    "b=FALSE==b",
    "$TIMER[2]=0",
    "$ADVANCE=1",
    "v=$POS_ACT.Z+$AXIS_ACT.A2",
]
BLOCKS = [
    ("IF b THEN", "ENDIF"),
    ("IF (n>2) THEN", "ELSE", "ENDIF"),
    ("FOR n=1 TO 5", "ENDFOR"),
    ("FOR n=9 TO 1 STEP -2", "ENDFOR"),
    ("WHILE n<3", "ENDWHILE"),
    ("LOOP", "EXIT", "ENDLOOP"),
    ("REPEAT", "UNTIL b"),
    ("SWITCH n", "CASE 1,2", "DEFAULT", "ENDSWITCH"),
    ("SPLINE", "SPL XP1", "SLIN XP2 WITH $VEL.CP=0.1", "ENDSPLINE C_SPL"),
]
DECLARED = [
    "DECL INT n,arr[4,4]",
    "REAL v",
    "BOOL b",
    "ENUM CLR RED,BLUE",
    "DECL CLR col",
    "STRUC STT FRAME m, INT k",
    "DECL STT st",
    "CHAR txt[20]",
    "E6AXIS ax",
    "FRAME frm",
]
DAT = [
    "DECL E6POS XP1={X 1.5,Y -2.25,Z 3.125,A 4.1,B 5.2,C 6.3,S 6,T 27,E1 0.0,E2 1.5}",
    "DECL POS XP2={X 10.0,Y 20.0,Z 30.0,A -21.5,B 3.25,C 178.5}",
    'DECL FDAT FP1={TOOL_NO 3,BASE_NO 2,IPO_FRAME #BASE,POINT2[] " "}',
    'DECL FDAT FP2={TOOL_NO 0,BASE_NO 0,IPO_FRAME #TCP,POINT2[] " "}',
    "DECL PDAT PPDAT1={VEL 100.0,ACC 80.0,APO_DIST 25.0,APO_MODE #CDIS}",
    "DECL LDAT LCPDAT1={VEL 2.0,ACC 60.0,APO_DIST 12.5} ; slow",
    "DECL INT COUNTS[3]",
    "COUNTS[1]=5",
    "COUNTS[3]=7",
    "DECL CHAR NAME[8]",
    'NAME[]="abc"',
]


@st.composite
def bodies(draw: st.DrawFn) -> list[str]:
    lines = [
        f"LIN {{X {draw(st.integers(-9999, 9999)) / 8},Y 1,Z 2,A {draw(st.floats(-180, 180)):.6f},B 0,C 0}} C_DIS"
    ]
    for _ in range(draw(st.integers(1, 4))):
        inside = draw(st.lists(st.sampled_from(LINES), min_size=1, max_size=6))
        block = draw(st.sampled_from([("", ""), *BLOCKS]))
        if block[0] in ("", "SPLINE"):
            lines += [line for line in block if line] + inside
        elif block[0][:6] == "SWITCH":
            lines += [*block[:2], *inside, *block[2:]]
        else:
            lines += [*block[:-1], *inside, block[-1]]
    return lines


@settings(max_examples=150, deadline=None)
@given(bodies())
def test_a_program_of_its_own_comes_back_the_same(lines: list[str]) -> None:
    program = read(*DECLARED, *lines, dat=DAT)
    assert not [d.render() for d in program.diagnostics if d.is_error]
    assert meaning(again(program)) == meaning(program)


@pytest.mark.parametrize("line", LINES)
def test_every_line_comes_back_the_same(line: str) -> None:
    program = read(*DECLARED, line, dat=DAT)
    assert not [d.render() for d in program.diagnostics if d.is_error]
    assert meaning(again(program)) == meaning(program)


class CountedBody(Sequence[Statement]):
    """A routine's statements that counts how often one is read."""

    def __init__(self, rows: Sequence[Statement]) -> None:
        self.rows, self.reads = rows, 0

    def __len__(self) -> int:
        return len(self.rows)

    def __getitem__(self, at: Any) -> Any:
        self.reads += 1
        return self.rows[at]


def test_a_call_of_bas_is_looked_for_where_it_stands_and_not_from_the_first_statement_on() -> None:
    program = read(*["$VEL.CP=0.2", "$APO.CDIS=5.0"] * 50)
    words = KrlWriter(program, pair=True)
    body = CountedBody(program.routines[0].body)
    calls = BasCalls(words.scope, words)
    assert [calls.call(body, at) for at in range(len(body))] == [None] * len(body)
    assert body.reads <= 3 * len(body)


def test_the_sample_comes_back_the_same_with_its_inline_forms() -> None:
    program = olp.read(SAMPLES / "handling.src")
    assert meaning(again(program)) == meaning(program)
    text, rows = written(program)
    assert text.count("BAS (#PTP_PARAMS,") == 3
    assert "BAS (#INITMOV,0)" in text
    assert "EXT BAS (BAS_COMMAND :IN,REAL :IN )" in rows
    assert rows.startswith("&ACCESS RVP\n&REL 4\n")


def test_export_writes_crlf_in_cp1252_and_keeps_what_is_shared_readable() -> None:
    data = read("n=1 ; ölig", dat=["INT n"]).export("krl")
    assert data.count(b"\r\n") == data.count(b"\n") > 3
    assert "ölig".encode("cp1252") in data
    assert [d.name for d in read_program(decode(data, "part.src"), ()).data] == ["n"]


# --- programs of other languages -------------------------------------------------------------------------


def pose(*values: float) -> PositionLiteral:
    scales = (0.001,) * 3 + (math.pi / 180,) * 3
    return PositionLiteral("pose", tuple(v * s for v, s in zip(values, scales, strict=True)))


P1 = Declare(0, "P1", "position", pose(1.5, 2, 3, 10, 20, 30), storage="constant")
GRIP = Declare(0, "grip", "tool", pose(12.5, -8.25, 187.4, 0, 15, 30), storage="constant")
FAST, SLOW = (Speed(SpeedUnit.TRAVEL, Quantity(Number(v), 0.001)) for v in (250, 80.5))
HALF = Speed(SpeedUnit.FRACTION, Quantity(Number(0.5), 1.0))
STOP = Blend(BlendKind.RADIUS, Quantity(Number(0), 1.0), "fine")
NEAR = Blend(BlendKind.RADIUS, Quantity(Number(0.025), 1.0), "r25")


def foreign(
    *statements: Statement, data: tuple[Declare, ...] = (P1, GRIP), more: tuple[Routine, ...] = ()
) -> Program:
    main = Routine("main", 1, statements, PointTable())
    return Program("rapid", decode(b"", "main.mod"), (main, *more), data=data, main="main")


def move(speed: Speed = FAST, blend: Blend = STOP, shape: Shape = Shape.LINEAR, **more: object) -> Move:
    values: dict[str, object] = {"tool": Named("grip"), "frame": FrameRef("base"), **more}
    targets = values.pop("targets", (Named("P1"),))
    return Move(1, shape, targets, speed, blend, **values)  # type: ignore[arg-type]


def lines_of(program: Program, pair: bool = False) -> list[str]:
    values, problems = write(program, "", pair=pair)
    assert not problems, [d.render() for d in problems]
    return [line.strip() for line in shipped("krl").render(values).split("\n") if line.strip()]


def refused(*statements: Statement) -> list[str]:
    return [d.code for d in write(foreign(*statements), "")[1]]


def test_speed_tool_frame_and_blend_are_assigned_where_they_change() -> None:
    program = foreign(move(), move(SLOW, NEAR), move(SLOW, NEAR), move(HALF, STOP, Shape.JOINT))
    found = lines_of(program)
    at = found.index("$TOOL=grip")
    assert found[at:] == [
        "$TOOL=grip",
        "$BASE=$NULLFRAME",
        "$VEL.CP=0.25",
        "LIN P1",
        "$VEL.CP=0.0805",
        "$APO.CDIS=25",
        "LIN P1 C_DIS",
        "LIN P1 C_DIS",
        "BAS (#VEL_PTP,50)",
        "PTP P1",
        "END",
    ]


def test_nothing_is_known_after_a_label_or_a_block() -> None:
    found = lines_of(
        foreign(move(), Label(2, "again"), move(), While(3, SignalState(True)), EndWhile(4), move())
    )
    assert found.count("$VEL.CP=0.25") == 3


def test_what_is_shared_stands_in_the_list_and_the_rest_in_its_routine() -> None:
    count = Declare(0, "n", "integer", Number(2), shared=True)
    drop = Routine("drop", 5, (Assign(5, Named("n"), Number(0)),), PointTable())
    program = foreign(
        move(), Assign(2, Named("n"), Number(1)), Call(3, "drop"), data=(P1, GRIP, count), more=(drop,)
    )
    found = lines_of(program)
    assert found[:5] == ["&ACCESS RVP", "&REL 1", "DEF main ( )", "DECL E6POS P1", "DECL FRAME grip"]
    assert found[-3:] == ["DEFDAT main", "DECL INT n=2", "ENDDAT"]
    values, _ = write(program, "", pair=True)
    assert values["companions"][".dat"].count("DECL") == 3  # type: ignore[index]


def test_positions_have_enough_digits_and_a_b_c_in_their_order() -> None:
    target = PositionLiteral("pose", (0.1234567891, -1.5, 2.0, 0.1, 0.2, 0.3), (5.5,), (1, 0, 0, 0, 0, 0))
    (line,) = [line for line in lines_of(foreign(move(targets=(target,)))) if line.startswith("LIN")]
    again_ = read(line).routines[0].body[0]
    assert isinstance(again_, Move)
    (found,) = again_.targets
    assert isinstance(found, PositionLiteral)
    assert found.values == pytest.approx(target.values, abs=1e-11)
    assert (found.external, found.configuration) == ((5.5,), (1, 0, 0, 0, 0, 0))
    assert line.index("A 17.18") < line.index("B 11.45") < line.index("C 5.72")


def test_a_computed_pose_is_put_into_a_variable_first() -> None:
    shifted = Function(
        "pose-offset", (Named("P1"), Number(0), Number(0), Binary("*", Number(40), Named("n")))
    )
    found = lines_of(
        foreign(move(targets=(shifted,)), data=(P1, GRIP, Declare(0, "n", "integer", Number(1))))
    )
    at = found.index("COMPUTED_POSE_1.Z=40*n")
    assert "DECL FRAME COMPUTED_POSE_1" in found
    assert found[at - 1] == "COMPUTED_POSE_1={X 0,Y 0,Z 0,A 0,B 0,C 0}"
    assert "LIN COMPUTED_POSE_1:P1" in found


def test_an_offset_along_the_tool_is_a_product_from_the_right() -> None:
    turned = Function(
        "pose-relative-tool", (Named("P1"), Number(1), Number(2), Number(3), Number(0), Number(0), Number(90))
    )
    found = lines_of(foreign(move(targets=(turned,))))
    assert "LIN P1:{X 1,Y 2,Z 3,A 0,B 0,C 0}:{X 0,Y 0,Z 0,A 90,B 0,C 0}" in found


def test_other_statements_of_other_languages() -> None:
    found = lines_of(
        foreign(
            If(1, Compare("=", Named("n"), Number(1))), Else(3), EndIf(4),
            Wait(5, Signal("in", Number(3)), Quantity(Number(2.5), 1.0)),
            SetOutput(6, Signal("out", Text("doGrip")), SignalState(True)), Dwell(7, Quantity(Number(350), 0.001)),
            Assign(8, Member(Named("P1"), "rz"), Binary("/", Named("n"), Number(2))),
            data=(P1, GRIP, Declare(0, "n", "integer", Number(1))),
        )
    )  # fmt: skip
    at = found.index("IF n==1 THEN")
    assert found[at : at + 3] == ["IF n==1 THEN", "ELSE", "ENDIF"]
    assert "WHILE NOT $IN[3] AND (WAITED<2.5)" in found
    assert {"doGrip=TRUE", "WAIT SEC 0.35", "P1.A=n/2.0", "DECL REAL WAITED"} <= set(found)


def test_conditions_without_precedence_get_parentheses() -> None:
    mixed = Logic(Named("a"), (("or", Named("b")), ("and", Compare("<", Named("n"), Number(2)))))
    assert "WAIT FOR (a OR b) AND (n<2)" in lines_of(foreign(Wait(1, mixed), data=()))
    assert "WAIT FOR NOT (n==2)" in lines_of(
        foreign(Wait(1, Unary("not", Compare("=", Named("n"), Number(2)))), data=())
    )


@pytest.mark.parametrize(
    "statement",
    [
        Opaque(1, "SpotL p1"),
        SetOutput(1, Signal("register", Number(1)), Number(2)),
        Assign(1, Named("n"), Function("tool-data", (Number(1),))),
        move(Speed(SpeedUnit.TIME, Quantity(Number(2), 1.0))),
        move(blend=Blend(BlendKind.LEVEL, Quantity(Number(2), 1.0))),
        move(shape=Shape.CIRCULAR),
        move(shape=Shape.SPLINE),
    ],
)
def test_what_krl_cannot_say_is_refused(statement: Statement) -> None:
    assert refused(statement) == ["X002"]


def test_each_move_that_cannot_be_said_is_told_although_they_share_their_speed() -> None:
    slow = move(Speed(SpeedUnit.TIME, Quantity(Number(2), 1.0)))
    assert refused(slow, replace(slow, line=2), replace(slow, line=3)) == ["X002"] * 3


def test_expressions_keep_their_meaning() -> None:
    a, b, c = Named("a"), Named("b"), Named("c")
    trees: list[Expression] = [
        Binary("*", Binary("+", a, b), c),
        Binary("-", a, Binary("-", b, c)),
        Unary("-", Binary("+", a, b)),
        Binary("/", a, Binary("*", b, c)),
        Unary("not", Logic(a, (("and", b),))),
        Logic(a, (("or", Logic(b, (("and", c),))),)),
        Logic(Logic(a, (("or", b),)), (("and", c),)),
        Compare("=", Compare("<", a, Number(2)), SignalState(True)),
        Function("pose-product", (a, Function("pose-product", (b, c)))),
        Function("pose-inverse", (Function("pose-product", (a, b)),)),
        Binary("and", a, Binary("or", b, c)),
    ]
    for tree in trees:
        program = read("r=0")
        body = (Assign(2, Named("r"), tree),)
        routine = program.routines[0]
        changed = Program("krl", source(""), (Routine(routine.name, 1, body, PointTable()),), main="PART")
        found = again(changed).routines[0].body
        assert found == body, tree


def test_a_program_that_moves_begins_with_the_settings_of_its_controller_and_the_rated_acceleration() -> None:
    drop = Routine("drop", 5, (move(),), PointTable())
    found = lines_of(foreign(move(), Call(3, "drop"), more=(drop,)))
    at = found.index("BAS (#INITMOV,0)")
    assert found[at - 1] == ";FOLD INI"
    assert found[at + 1 : at + 8] == [f"$ACC_AXIS[{n}]=100" for n in range(1, 7)] + [";ENDFOLD (INI)"]
    assert at < found.index("$TOOL=grip")
    assert found.count("BAS (#INITMOV,0)") == 1
    assert "BAS (#INITMOV,0)" not in lines_of(foreign(Assign(2, Named("n"), Number(1))))


def test_functions_that_nothing_calls_are_there_for_other_files():
    """Of a file with several routines only those that are GLOBAL are seen elsewhere."""
    rows = ("PROC main()", "x:=twice(x);", "ENDPROC", "FUNC num twice(num n)", "RETURN 2*n;", "ENDFUNC")
    text = "\n".join(
        [
            "MODULE M",
            "VAR num x;",
            *rows,
            *(r.replace("twice", "half") for r in rows[3:]),
            "LOCAL FUNC num own(num n)",
            *rows[4:],
            "ENDMODULE",
        ]
    )
    heads = [row for row in translated(text, "rapid", "krl").splitlines() if "DEFFCT" in row]
    assert heads == [
        "DEFFCT REAL twice (n :IN)",
        "GLOBAL DEFFCT REAL half (n :IN)",
        "DEFFCT REAL own (n :IN)",
    ]
