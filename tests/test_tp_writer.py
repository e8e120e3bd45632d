"""Writing TP: own programs come back as they were, programs of other languages in the forms that controllers take."""

from __future__ import annotations

import random
from dataclasses import replace
from math import radians
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from tp_listings import HEAD, POSITION, listing, read

from olp.core.diagnostic import OlpError
from olp.core.source import decode
from olp.fluent import read as read_file
from olp.fluent import read_source
from olp.ir.expressions import (
    Binary,
    Compare,
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
    Store,
    SystemValue,
    Taught,
    Text,
    Unary,
    Variable,
)
from olp.ir.points import PointBlock, PointKind, PointState, PointTable
from olp.ir.program import (
    Acceleration,
    AccelerationUnit,
    Assign,
    Begin,
    Blend,
    BlendKind,
    Call,
    Comment,
    Disabled,
    End,
    Jump,
    Label,
    Move,
    Opaque,
    Process,
    Program,
    Return,
    Routine,
    SetOutput,
    Speed,
    SpeedUnit,
    Wait,
    While,
)
from olp.ir.program import (
    Path as Shape,
)
from olp.languages.templating import RenderingLimits, shipped
from olp.languages.vendors.tp.writer import write
from olp.transpile.convert import export

SAMPLES = sorted((Path(__file__).parent.parent / "samples" / "tp").glob("*.ls"))
DATE = "2025/03/04 10:11"


def again(program: Program) -> Program:
    return read_source(decode(export(program, "tp", date=DATE), "again.ls"))


def said(program: Program) -> list[object]:
    """The statements without their lines; labels of blocks without the line of their block."""
    found: list[object] = []
    for routine in program.routines:
        for one in routine.body:
            one = replace(one, line=0)
            if isinstance(one, Label):
                one = replace(one, name=one.name.split("/")[0])
            elif isinstance(one, Jump) and isinstance(one.target, str):
                one = replace(one, target=one.target.split("/")[0])
            found.append(one)
    return found


def assert_same(first: Program, second: Program) -> None:
    assert said(second) == said(first)
    assert not [one.render() for one in second.diagnostics if one.is_error]
    for a, b in zip(first.routines, second.routines, strict=True):
        assert (b.name, b.comment, b.groups) == (a.name, a.comment, a.groups)
        for key, block in a.points.blocks.items():
            other = b.points.blocks[key]
            np.testing.assert_array_equal(other.numbers, block.numbers)
            np.testing.assert_array_equal(other.values, block.values)
            assert [b.points.states[s] for s in other.state] == [a.points.states[s] for s in block.state]
        for name, value in a.details.items():
            if name not in ("/ATTR PROG_SIZE", "/ATTR MEMORY_SIZE", "/ATTR LINE_COUNT"):
                assert b.details[name] == value, name


@pytest.mark.parametrize("path", SAMPLES, ids=lambda path: path.name)
def test_a_sample_is_written_as_it_was(path: Path) -> None:
    first = read_file(path)
    assert_same(first, again(first))
    lines = [line.split() for line in export(first, "tp", date=DATE).decode("latin-1").split("\r\n")]
    kept = [line.split() for line in path.read_text("latin-1").split("\n")]
    body = slice(kept.index(["/MN"]), kept.index(["/POS"]))
    assert [" ".join(line).replace(" ;", ";") for line in lines[body]][1:4] == [
        " ".join(line).replace(" ;", ";") for line in kept[body]
    ][1:4]


# --- random programs ------------------------------------------------------------------------------------


def _value(rng: random.Random) -> str:
    number = rng.choice(["5", "12.25", "(-3.5)", "100"])
    return rng.choice(
        [number, f"R[{rng.randint(1, 9)}:n{rng.randint(1, 3)}]", "AR[2]", "GI[3]", "R[R[4]]", "PR[3,2:up]"]
    )


def _condition(rng: random.Random) -> str:
    simple = rng.choice(
        ["DI[{0}]=ON", "!RI[{0}]", "R[{0}]>=2.5", "F[{0}]", "R[{0}]<>AR[1]", "(DI[{0}] OR F[2])"]
    )
    text = simple.format(rng.randint(1, 8))
    for _ in range(rng.randint(0, 2)):
        text += f" {rng.choice(['AND', 'OR'])} {rng.choice(['DO[4]=OFF', '!DI[5]', 'R[1]=(R[2]+1)*2'])}"
    return f"({text})"


def _speed(rng: random.Random, letter: str) -> str:
    units = ["%"] if letter == "J" else ["mm/sec", "cm/min", "inch/min", "deg/sec"]
    number = rng.choice(["5", "12.5", "100", "R[3:fast]", "99.9"])
    return f"{number}{rng.choice([*units, 'sec', 'msec'])}"


def _move(rng: random.Random) -> str:
    letter = rng.choice("JLLLCA")
    where = [
        rng.choice(["P[{0}]", "PR[{0}:a]", "PR[R[5]]", "P[{0}]"]).format(rng.randint(1, 4)) for _ in (1, 2)
    ]
    corners = ["FINE", "CNT0", "CNT55", "CNT R[6]"] + ([] if letter == "J" else ["CR12.5", "CD30", "CR5,10"])
    options = [
        "ACC80",
        "ACC R[7]",
        "INC",
        "Offset,PR[2]",
        "Tool_Offset,PR[3:t]",
        "COORD",
        "PTH",
        "Skip,LBL[1]",
        "BREAK",
    ]
    some = " ".join(rng.sample(options, rng.randint(0, 3)))
    tail = rng.choice(["", "", " TB .15sec,CALL OPEN(1)", " DB 10.0mm,DO[1]=ON"])
    target = " ".join(where) if letter == "C" else where[0]
    return f"{letter} {target} {_speed(rng, letter)} {rng.choice(corners)} {some}{tail}".rstrip()


def _plain(rng: random.Random) -> str:
    n = rng.randint(1, 9)
    return rng.choice(
        [
            f"R[{n}:k]={_value(rng)}",
            f"R[{n}]={_value(rng)}{rng.choice(['+', '-', '*', '/', ' DIV ', ' MOD '])}{_value(rng)}",
            f"R[{n}]=({_value(rng)}+SQRT[R[3]]*(R[1]-R[2]))",
            f"PR[{n},3:lift]={_value(rng)}",
            f"PR[{n}]=P[1]",
            "PR[4]=LPOS",
            f"DO[{n}:grip]=ON",
            f"DO[{n}:grip]=PULSE,0.{n}sec",
            f"GO[{n}]=R[2]",
            f"F[{n}]={_condition(rng)}",
            f"WAIT .{n}5(sec)",
            f"WAIT {_condition(rng)}",
            f"CALL PART{n}({_value(rng)},'text',R[2:b])",
            f"WEIGH PART({n})",
            f"IF {_condition(rng)},CALL PART{n}",
            "JMP LBL[1]",
            f"IF {_condition(rng)},JMP LBL[1]",
            f"IF {_condition(rng)},DO[{n}:grip]=OFF",
            f"WAIT {_condition(rng)} TIMEOUT,LBL[1]",
            f"!note {n}, of all; things",
            "//DO[1]=ON",
            "UTOOL_NUM=2",
            "UFRAME_NUM=R[3]",
            "UFRAME[3]=PR[7]",
            "OVERRIDE=40%",
            "PAYLOAD[1:part]",
            "TIMER[3:cycle]=START",
            "MESSAGE[ready, R:1]",
            "Arc Start[2]",
            "PAUSE",
            "ABORT",
            "WAIT DI[3]=OFF-",
            _move(rng),
            _move(rng),
            _move(rng),
        ]
    )


def _random_listing(seed: int) -> str:
    rng = random.Random(seed)
    lines = ["LBL[1:begin]"]
    for _ in range(rng.randint(2, 6)):
        kind = rng.randint(0, 5)
        some = [_plain(rng) for _ in range(rng.randint(1, 4))]
        if kind == 0:
            lines += [f"IF {_condition(rng)} THEN", *some, "ELSE", _plain(rng), "ENDIF"]
        elif kind == 1:
            begin = {"12.25": "12", "(-3.5)": "(-3)"}  # a FOR takes whole numbers where they are written out
            value = _value(rng)
            lines += [
                f"FOR R[8:i]={begin.get(value, value)} {rng.choice(['TO', 'DOWNTO'])} R[2]",
                *some,
                "ENDFOR",
            ]
        elif kind == 2:
            lines += [
                "SELECT R[1:k]=1,JMP LBL[1]",
                "       =R[2],CALL PART1(2)",
                "       ELSE,CALL PART2",
                *some,
            ]
        else:
            lines += some
    points = "".join(
        POSITION.format(n, rng.uniform(-900, 900)).replace(
            "12.500", f"{rng.uniform(-99, 99):.{rng.randint(0, 6)}f}"
        )
        for n in range(1, 5)
    )
    return listing(*lines, positions=points.replace("P[1]", 'P[1:"first, best"]'))


@pytest.mark.parametrize("seed", range(150))
def test_a_random_program_comes_back(seed: int) -> None:
    first = read(_random_listing(seed))
    assert not [one.render() for one in first.diagnostics if one.is_error]
    second = again(first)
    assert_same(first, second)
    assert export(second, "tp", date=DATE) == export(first, "tp", date=DATE)


def test_a_block_beside_a_move_comes_back() -> None:
    text = (
        HEAD
        + """   1:J P[1] 100% CNT0 TB .10sec,P-SPS    ;
      1:  LBL[1] ;
      2:  WAIT (DI[23])    ;
      3:  IF (DI[24]),JMP LBL[1] ;
       ------ ;
   2:C P[1]
    :  P[1] 100mm/sec FINE    ;
/POS
"""
    )
    first = read(text + POSITION.format(1, 10.0) + "/END\n")
    written = export(first, "tp", date=DATE).decode("latin-1").replace("\r\n", "\n")
    assert "      2:  WAIT (DI[23])" in written
    assert "       ------ ;\n   2:C P[1]    \n    :  P[1] 100mm/sec FINE    ;" in written
    assert_same(first, again(first))


# --- programs of other languages ------------------------------------------------------------------------


def made(*statements: object, points: PointTable | None = None, name: str = "MADE") -> Program:
    routine = Routine(name, 1, tuple(statements), points or PointTable())  # type: ignore[arg-type]
    return Program("krl", decode(b"", "made.src"), (routine,))


def written(program: Program) -> str:
    """What the writer itself makes of a program, which is already in the form that it takes. Raises OlpError."""
    values, problems = write(program, DATE)
    if problems:
        raise OlpError(*problems)
    return shipped("tp").render(values, RenderingLimits(steps=1_000_000, characters=1_000_000, seconds=10.0))


def instructions(program: Program) -> list[str]:
    """The instructions as written, without numbers and the blanks before semicolons."""
    text = written(program).replace("\n    :", "")
    lines = text[text.index("/MN") : text.index("/POS")].split("\n")[1:-1]
    return [" ".join(line.split(":", 1)[1].rstrip(" ;").split()) for line in lines]


def positions(program: Program) -> str:
    text = written(program)
    return text[text.index("/POS") : text.index("/END")]


def r(number: int, name: str = "") -> Variable:
    return Variable(Store.REAL, Number(number), name=name)


FINE = Blend(BlendKind.RADIUS, Quantity(Number(0), 1.0))
HALF = Speed(SpeedUnit.FRACTION, Quantity(Number(0.5), 1.0))
SLOW = Speed(SpeedUnit.TRAVEL, Quantity(Number(0.25), 1.0))
TABLE, TOOL = FrameRef("user", Number(1)), FrameRef("tool", Number(2))
POSE = PositionLiteral(
    "pose", (0.1, -0.2, 0.3, radians(10), radians(-20), radians(30)), configuration=(0, 1, 1, 0, 0, 0)
)
HOME = PositionLiteral("joint", tuple(map(radians, (5.5, -12.25, 18.75, 3.5, -47.25, 21.0))))


def test_si_values_become_the_units_of_tp() -> None:
    turn = Speed(SpeedUnit.TURN, Quantity(Number(radians(45)), 1.0))
    time = Speed(SpeedUnit.TIME, Quantity(Number(2.5), 1.0))
    zone = Blend(BlendKind.RADIUS, Quantity(Number(0.025), 1.0))
    kept = Blend(BlendKind.SPEED, Quantity(Number(0.5), 1.0))
    move = Move(1, Shape.LINEAR, (POSE,), SLOW, zone, frame=TABLE, tool=TOOL)
    assert instructions(
        made(
            move,
            replace(move, speed=turn, blend=kept),
            replace(move, speed=time, blend=FINE, acceleration=Quantity(Number(0.8), 1.0)),
            replace(move, path=Shape.JOINT, speed=HALF, blend=FINE, targets=(HOME,)),
            replace(move, path=Shape.CIRCULAR, via=POSE),
        )
    ) == [
        "UFRAME_NUM=1",
        "UTOOL_NUM=2",
        "L P[1] 250mm/sec CR25",
        "L P[1] 45deg/sec CNT50",
        "L P[1] 2.5sec FINE ACC80",
        "J P[2] 50% FINE",
        "C P[1] P[1] 250mm/sec CR25",
    ]


def test_positions_are_written_in_millimetres_degrees_and_the_flags_of_the_arm() -> None:
    move = Move(1, Shape.LINEAR, (POSE,), SLOW, FINE, frame=TABLE, tool=TOOL)
    text = positions(made(move, replace(move, targets=(HOME,))))
    assert "UF : 1, UT : 2,\t\tCONFIG : 'F D B, 0, 0, 0'," in text
    assert "X =  100.0000  mm,\tY = -200.0000  mm,\tZ =  300.0000  mm," in text
    assert "W =  10.00000 deg,\tP = -20.00000 deg,\tR =  30.00000 deg" in text
    assert "J1=   5.50000 deg,\tJ2= -12.25000 deg,\tJ3=  18.75000 deg," in text


def test_frames_are_selected_where_they_change_and_where_they_are_not_known() -> None:
    move = Move(1, Shape.LINEAR, (POSE,), SLOW, FINE, frame=TABLE, tool=TOOL)
    other = replace(move, frame=FrameRef("base"))
    lines = instructions(made(move, move, other, Label(1, "again"), other, Call(1, "PART"), other))
    assert [line for line in lines if line[0] != "L" or line[1] == "B"] == [
        "UFRAME_NUM=1",
        "UTOOL_NUM=2",
        "UFRAME_NUM=0",
        "LBL[1:again]",
        "UFRAME_NUM=0",
        "UTOOL_NUM=2",
        "CALL PART",
        "UFRAME_NUM=0",
        "UTOOL_NUM=2",
    ]


def test_a_taught_position_in_two_frames_is_written_twice() -> None:
    block = PointBlock(
        Store.ROBOT,
        True,
        np.array([4]),
        np.array([POSE.values]),
        np.array([0], dtype=np.int32),
        np.array([1], dtype=np.int32),
        {4: 0},
    )
    table = PointTable((PointState(PointKind.POSE, "user", 1, 2),), {(Store.ROBOT, True): block})
    move = Move(1, Shape.LINEAR, (Taught(Store.ROBOT, 4),), SLOW, FINE, frame=TABLE, tool=TOOL)
    program = made(move, replace(move, frame=FrameRef("base")), move, points=table)
    assert [line for line in instructions(program) if line.startswith("L P")] == [
        "L P[4] 250mm/sec FINE",
        "L P[5] 250mm/sec FINE",
        "L P[4] 250mm/sec FINE",
    ]
    text = positions(program)
    assert text.count("X =  100.0000") == 2
    assert "UF : 1, UT : 2" in text
    assert "UF : 0, UT : 2" in text


def test_a_frame_is_built_component_by_component() -> None:
    assert instructions(made(Assign(1, TABLE, POSE), Assign(1, r(100), Number(1)))) == [
        "PR[100,1]=100",
        "PR[100,2]=(-200)",
        "PR[100,3]=300",
        "PR[100,4]=10",
        "PR[100,5]=(-20)",
        "PR[100,6]=30",
        "UFRAME[1]=PR[100]",
        "R[100]=1",
    ]


def test_an_offset_of_the_frame_or_the_tool_is_built_in_a_register() -> None:
    built = Function("pose-angles", (Number(0), r(1), Number(-12.5), Number(0), Number(0), Number(90)))
    point = Taught(Store.ROBOT, 3)
    move = Move(1, Shape.LINEAR, (Function("pose-product", (built, point)),), SLOW, FINE)
    by_tool = replace(move, targets=(Function("pose-product", (point, built)),))
    lines = ["PR[99,1]=0", "PR[99,2]=R[1]", "PR[99,3]=(-12.5)", "PR[99,4]=0", "PR[99,5]=0", "PR[99,6]=90"]
    assert instructions(made(move, by_tool)) == [
        *lines,
        "L P[3] 250mm/sec FINE Offset,PR[99]",
        *lines,
        "L P[3] 250mm/sec FINE Tool_Offset,PR[99]",
    ]


def test_a_turn_about_the_tool_is_an_offset_and_two_are_refused() -> None:
    def move(*turns: int) -> Move:
        by = tuple(Number(value) for value in (1, 2, 3, *turns))
        return Move(
            1, Shape.LINEAR, (Function("pose-relative-tool", (Taught(Store.ROBOT, 3), *by)),), SLOW, FINE
        )

    assert instructions(made(move(0, 0, 45)))[5:] == [
        "PR[99,6]=45",
        "L P[3] 250mm/sec FINE Tool_Offset,PR[99]",
    ]
    with pytest.raises(OlpError, match="computed position"):
        written(made(move(10, 0, 45)))


def test_a_pose_in_metres_and_a_rotation_vector_becomes_millimetres_and_w_p_r() -> None:
    vector = Rotation.from_euler("xyz", [10, -20, 30], degrees=True).as_rotvec()
    lengths = (Binary("*", Number(0.04), r(1)), Number(0.25), r(2))
    pose = Function("pose-vector", (*lengths, *(Number(float(value)) for value in vector)))
    assert instructions(made(Assign(1, Variable(Store.ROBOT, Number(7)), pose))) == [
        "PR[7,1]=40*R[1]",
        "PR[7,2]=250",
        "PR[7,3]=R[2]*1000",
        "PR[7,4]=10",
        "PR[7,5]=(-20)",
        "PR[7,6]=30",
    ]


def test_a_component_of_a_taught_position_is_its_number() -> None:
    block = PointBlock(
        Store.ROBOT,
        True,
        np.array([4]),
        np.array([POSE.values]),
        np.zeros(1, np.int32),
        np.ones(1, np.int32),
        {4: 0},
    )
    table = PointTable((PointState(PointKind.POSE, "user", 1, 2),), {(Store.ROBOT, True): block})
    taught = Taught(Store.ROBOT, 4)
    program = made(
        Assign(1, r(1), Member(taught, "z")),
        Assign(1, r(2), Binary("+", Member(taught, "ry"), r(3))),
        points=table,
    )
    assert instructions(program) == ["R[1]=300", "R[2]=(-20)+R[3]"]


def test_a_frame_keeps_its_decimals() -> None:
    odd = PositionLiteral("pose", (0.01234567, 0.0, -0.0000012, radians(10.12345), 0.0, radians(-0.00002)))
    lines = instructions(made(Assign(1, TOOL, odd)))
    assert lines[0] == "PR[100,1]=12.34567"
    assert lines[2:4] == ["PR[100,3]=(-0.0012)", "PR[100,4]=10.12345"]
    assert lines[5] == "PR[100,6]=(-0.00002)"


def test_a_register_that_the_program_uses_is_not_taken_for_a_frame() -> None:
    used = Assign(1, Variable(Store.ROBOT, Number(100)), SystemValue("current-pose"))
    assert "UTOOL[2]=PR[99]" in instructions(made(used, Assign(1, TOOL, POSE)))


def test_a_shifted_target_is_computed_in_a_register() -> None:
    shifted = Function(
        "pose-offset", (Taught(Store.ROBOT, 3), Number(0), r(1), Binary("*", Number(40), r(2)))
    )
    assert instructions(made(Move(1, Shape.LINEAR, (shifted,), SLOW, FINE))) == [
        "PR[100]=P[3]",
        "PR[100,2]=(PR[100,2]+R[1])",
        "PR[100,3]=(PR[100,3]+40*R[2])",
        "L PR[100] 250mm/sec FINE",
    ]


@pytest.mark.parametrize(
    ("value", "text"),
    [
        (Number(-5), "(-5)"),
        (Binary("+", r(1), Number(2)), "R[1]+2"),
        (Binary("-", r(1), Binary("-", r(2), r(3))), "(R[1]-(R[2]-R[3]))"),
        (Binary("*", Binary("+", r(1), r(2)), r(3)), "((R[1]+R[2])*R[3])"),
        (Unary("-", r(1)), "((-R[1]))"),
        (Function("atan2", (r(1), r(2))), "ATAN2[R[1],R[2]]"),
        (SignalState(True), "1"),
    ],
)
def test_arithmetic(value: object, text: str) -> None:
    program = made(Assign(1, r(9), value))  # type: ignore[arg-type]
    assert instructions(program) == [f"R[9]={text}"]


def test_a_truth_value_is_one_or_zero_in_a_register() -> None:
    assert instructions(made(Assign(1, r(9), Compare(">", r(1), Number(2))))) == [
        "IF (R[1]>2) THEN",
        "R[9]=1",
        "ELSE",
        "R[9]=0",
        "ENDIF",
    ]


@pytest.mark.parametrize(
    ("condition", "text"),
    [
        (Compare("=", Signal("in", Number(3)), SignalState(True)), "DI[3]=ON"),
        (Signal("in", Number(3)), "(DI[3])"),
        (Unary("not", Signal("in", Number(3))), "(!DI[3])"),
        (r(4), "(R[4]<>0)"),
        (Compare("=", r(4), SignalState(False)), "R[4]=0"),
        (Logic(r(1), (("or", r(2)), ("and", r(3)))), "((R[1]<>0 OR R[2]<>0) AND R[3]<>0)"),
        (Logic(r(1), (("and", r(2)), ("or", r(3)))), "(R[1]<>0 AND R[2]<>0 OR R[3]<>0)"),
        (Unary("not", Logic(r(1), (("or", r(2)),))), "(!(R[1]<>0 OR R[2]<>0))"),
    ],
)
def test_conditions(condition: object, text: str) -> None:
    assert instructions(made(Wait(1, condition))) == [f"WAIT {text}"]  # type: ignore[arg-type]


def test_names_of_labels_become_numbers_with_names() -> None:
    lines = instructions(
        made(Label(1, "7"), Label(1, "loop start of all"), Jump(1, "loop start of all"), Jump(1, "7"))
    )
    assert lines == ["LBL[7]", "LBL[1:loop start of al]", "JMP LBL[1]", "JMP LBL[7]"]


def test_a_bounded_wait_sets_the_controllers_timeout() -> None:
    wait = Wait(1, r(1), Quantity(Number(2.5), 1.0))
    assert instructions(made(Label(1, "1"), wait, Jump(1, "1", SystemValue("timed-out")), wait)) == [
        "LBL[1]",
        "$WAITTMOUT=250",
        "WAIT (R[1]<>0) TIMEOUT,LBL[1]",
        "$WAITTMOUT=250",
        "WAIT (R[1]<>0) TIMEOUT,LBL[901]",
        "LBL[901]",
    ]


def test_comments_behind_statements_and_long_ones_stand_above() -> None:
    lines = instructions(
        made(Comment(1, "word " * 9), SetOutput(1, Signal("out", Number(2)), SignalState(False), "let go"))
    )
    assert lines == ["!word word word word word word", "!word word word", "!let go", "DO[2]=OFF"]


def test_begin_and_end_are_no_lines() -> None:
    assert instructions(made(Begin(1), Return(1), End(1))) == ["END"]


RADIUS = Blend(BlendKind.RADIUS, Quantity(Number(0.025), 1.0))


@pytest.mark.parametrize(
    ("statement", "word"),
    [
        (Move(1, Shape.JOINT, (HOME,), HALF, RADIUS), "radius"),
        (Move(1, Shape.JOINT, (HOME,), SLOW, FINE), "a speed of the tool"),
        (Move(1, Shape.LINEAR, (HOME,), HALF, FINE), "a share of full speed"),
        (Move(1, Shape.LINEAR, (HOME,), None, FINE), "without a speed"),
        (
            Move(1, Shape.LINEAR, (HOME,), SLOW, Blend(BlendKind.LEVEL, Quantity(Number(1), 1.0))),
            "a blend by",
        ),
        (Move(1, Shape.LINEAR, (HOME,), SLOW, FINE, frame=Named("table")), "frame without a number"),
        (Move(1, Shape.LINEAR, (HOME,), SLOW, FINE, tool=POSE), "tool without a number"),
        (Move(1, Shape.LINEAR, (HOME,), SLOW, FINE, no_wait=True), "more than one thing"),
        (Move(1, Shape.LINEAR, (Named("p"),), SLOW, FINE), "computed position"),
        (
            Move(
                1,
                Shape.LINEAR,
                (HOME,),
                SLOW,
                FINE,
                rate=Acceleration(AccelerationUnit.TRAVEL, Quantity(Number(1), 1)),
            ),
            "acceleration",
        ),
        (Assign(1, Named("x"), Number(1)), "by its name"),
        (Assign(1, r(1), Function("pose-product", (r(1), r(2)))), "a pose seen in another pose"),
        (While(1, SignalState(True)), "WHILE"),
        (Opaque(1, "FOO"), "another language"),
        (Disabled(1, "FOO"), "another language"),
        (Process(1, "ARCON", (("", Text("1")),)), "another language"),
        (Return(1, Number(1)), "value that a routine returns"),
        (SetOutput(1, Signal("out", Text("doGrip")), SignalState(True)), "by its name"),
        (SetOutput(1, Signal("register", Number(1)), SignalState(True)), "register"),
    ],
)
def test_what_tp_cannot_say_is_refused_with_its_line(statement: object, word: str) -> None:
    with pytest.raises(OlpError) as refusal:
        written(made(statement))
    (found,) = refusal.value.diagnostics
    assert (found.code, found.line) == ("X002", 1)
    assert word in found.message


def test_the_header_of_a_foreign_program_is_complete() -> None:
    text = written(made()).replace("\n", "\r\n")
    assert text.startswith('/PROG  MADE\r\n/ATTR\r\nOWNER\t\t= MNEDITOR;\r\nCOMMENT\t\t= "made";\r\n')
    assert "CREATE\t\t= DATE 25-03-04  TIME 10:11:00;" in text
    assert text.endswith("/APPL\r\n/MN\r\n/POS\r\n/END\r\n")


def test_a_condition_that_begins_with_a_number_is_mixed_logic() -> None:
    jump = Jump(1, "1", Compare(">", Number(2), Number(1)))
    assert "IF (2>1),JMP LBL[1]" in " ".join(instructions(made(jump, Label(2, "1"))))
