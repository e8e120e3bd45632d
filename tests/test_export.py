"""What is exported and read again is the same program with the same plan; what cannot be said is refused first."""

import dataclasses
import math
import re
from pathlib import Path

import numpy as np
import pytest
from cpu_time import cpu_time_below
from hypothesis import given, settings
from hypothesis import strategies as st

import olp
from olp.core.diagnostic import OlpError
from olp.core.source import decode
from olp.fluent import Program, read, read_source
from olp.ir.expressions import (
    Argument,
    Binary,
    Compare,
    Element,
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
    Variable,
)
from olp.ir.points import PointBlock, PointKind, PointState, PointTable
from olp.ir.program import (
    Assign,
    Begin,
    Blend,
    BlendKind,
    Call,
    Case,
    Clear,
    Comment,
    ControlGroup,
    Default,
    DefineFrame,
    Disabled,
    Dwell,
    Else,
    ElseIf,
    End,
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
    Pause,
    Process,
    PulseOutput,
    ReadInput,
    Reference,
    Return,
    Routine,
    Search,
    SetOutput,
    SetSpeed,
    ShiftOff,
    ShiftOn,
    Speed,
    SpeedUnit,
    StartTask,
    Switch,
    Synchronise,
    Update,
    Wait,
    WaitTask,
    While,
)
from olp.ir.program import (
    Path as Shape,
)
from olp.languages.limits import writable
from olp.runtime.interpreter import run
from olp.transpile.convert import export

SAMPLES = Path(__file__).parent.parent / "samples"
JOBS = sorted(path for path in SAMPLES.rglob("*") if path.suffix.lower() == ".jbi")
MM, DEG = 0.001, math.pi / 180.0


def is_sound(path):
    return not any(found.is_error for found in read(path).diagnostics)


SOUND = [path for path in JOBS if path.parent.name != "broken" and is_sound(path)]


def label(path):
    return str(path.relative_to(SAMPLES))


# --- comparing ------------------------------------------------------------------------------------------


def trimmed(values):
    """The values without empty fields at the end; nan equal to itself."""
    kept = list(values)
    while kept and math.isnan(kept[-1]):
        kept.pop()
    return tuple("empty" if math.isnan(value) else value for value in kept)


def points_of(routine):
    return sorted(
        (str(s), taught, p.number, trimmed(p.values), str(p.state)) for s, taught, p in routine.points
    )


def body_of(routine):
    return [dataclasses.replace(statement, line=0) for statement in routine.body]


def braked(move):
    """A move as INFORM says it: a share that other languages give for both is written for both."""
    return dataclasses.replace(move, deceleration=move.deceleration or move.acceleration)


def assert_same_program(first, second):
    assert len(first.routines) == len(second.routines)
    for one, other in zip(first.routines, second.routines, strict=True):
        assert body_of(one) == body_of(other)
        assert points_of(one) == points_of(other)
        for name in ("name", "groups", "comment", "relative_to", "locals", "arguments", "aliases"):
            assert getattr(one, name) == getattr(other, name), name


def again(program):
    return read_source(decode(export(program, "inform"), program.path))


# --- samples --------------------------------------------------------------------------------------------


def test_there_are_samples_to_try():
    assert len(SOUND) > 60


@pytest.mark.parametrize("path", SOUND, ids=label)
def test_a_sample_exported_and_read_again_is_the_same_program(path):
    program = read(path)
    other = again(program)
    assert not [found.render() for found in other.diagnostics if found.is_error]
    assert_same_program(program, other)
    for one, two in zip(program.routines, other.routines, strict=True):
        assert dict(one.details) == dict(two.details)


@pytest.mark.parametrize("path", SOUND, ids=label)
def test_a_sample_exported_and_read_again_gives_the_same_plan(path):
    program = read(path)
    first, second = run(program, max_steps=5_000), run(again(program), max_steps=5_000)
    assert len(first) == len(second)
    for name in ("kind", "row", "durations"):
        np.testing.assert_array_equal(getattr(first, name), getattr(second, name))
    for one, two in ((first.moves, second.moves), (first.positions, second.positions)):
        for field in dataclasses.fields(one):
            np.testing.assert_array_equal(getattr(one, field.name), getattr(two, field.name), field.name)


@pytest.mark.parametrize("path", SOUND, ids=label)
def test_an_export_is_text_that_a_controller_takes(path):
    data = read(path).export("inform")
    assert data.count(b"\r\n") == data.count(b"\n") == data.count(b"\r")
    assert data.startswith(b"/JOB\r\n")
    assert data.endswith(b"END\r\n")
    assert b"\r\n\r\n" not in data.partition(b"//INST")[2].partition(b"/JOB")[0]
    assert not re.search(rb"[=,]-0(?:\.0*)?[,\r]", data)


@pytest.mark.parametrize("path", SOUND, ids=label)
def test_exporting_an_export_changes_nothing(path):
    data = read(path).export("inform")
    encoding = read(path).source.encoding
    other = read_source(decode(data, "again.jbi", None if encoding == "utf-8-sig" else encoding))
    assert other.export("inform", encoding="cp1252" if encoding == "ascii" else None) == data


@pytest.mark.parametrize(
    "name",
    [
        "welding/SEAM-LH.JBI",
        "welding/SEAM-ST.JBI",
        "palletising/PLACE.JBI",
        "palletising/INIT.JBI",
        "cam/FINISH.JBI",
        "generations/erc.jbi",
        "generations/xrc.jbi",
        "generations/dx100.jbi",
        "generations/fs100.jbi",
        "generations/yrc1000micro.jbi",
        "pitfalls/shift-jis.jbi",
        "pitfalls/cp1252.jbi",
    ],
)
def test_a_job_in_the_usual_form_is_written_byte_for_byte_as_it_was(name):
    program = read(SAMPLES / "inform" / name)
    assert program.export("inform") == program.to_bytes()


# --- one job by hand ------------------------------------------------------------------------------------


def block(store, taught, rows, states):
    """A block of points: {number: values}, all short ones filled with nan."""
    width = max(map(len, rows.values()))
    values = np.array([[*row, *[math.nan] * (width - len(row))] for row in rows.values()], dtype=float)
    numbers = np.array(list(rows), dtype=np.int64)
    lines = np.zeros(len(rows), dtype=np.int32)
    index = {number: row for row, number in enumerate(rows)}
    return PointBlock(store, taught, numbers, values, np.array(states, dtype=np.int32), lines, index)


def program_of(body, vendor="inform", path="made.jbi", **more):
    points = more.pop("points", PointTable())
    details = more.pop("details", {"DATE": "2026/05/06 07:08", "ATTR": "SC,RW"})
    statements = tuple(dataclasses.replace(s, line=n) for n, s in enumerate((Begin(0), *body, End(0)), 1))
    routine = Routine("MADE", 1, statements, points, details=details, **more)
    return Program(vendor, decode(b"", path, "cp1252"), (routine,))


def foreign_text(program):
    """What the writer alone makes of a program of another language: the passes of a translation come before it."""
    from olp.core.diagnostic import raise_errors
    from olp.languages.vendors.inform import writer
    from olp.transpile.convert import rendered

    values, problems = writer.write(program, "2026/05/06 07:08")
    raise_errors(problems)
    return rendered(values, "inform", program).replace("\n", "\r\n")


def lines_of(program, **options):
    text = program.export("inform", **options).decode("cp1252")
    return text.partition("NOP\r\n")[2].split("\r\n")[:-2]


def metres(value, scale=MM):
    return Quantity(Number(value), scale)


def test_a_job_made_by_hand_has_the_form_that_controllers_write():
    pose = PointState(PointKind.POSE, "user", 4, 2, (1, 0, 1) + (0,) * 21)
    pulse = PointState(PointKind.PULSE, tool=2)
    wide = PointState(PointKind.PULSE, tool=0, outside_limits=True)
    speed = Variable(Store.DOUBLE, Number(0), True, "V_Seam")
    table = PointTable(
        (pulse, pose, wide),
        {
            (Store.ROBOT, True): block(
                Store.ROBOT,
                True,
                {
                    0: (-1203, 20417, -33120, 512, -41877, 902),
                    1: (0.41231, -0.0870451, -1e-9, 3.1 * DEG, -12.0071 * DEG, 91.33 * DEG),
                },
                [0, 1],
            ),
            (Store.STATION, True): block(Store.STATION, True, {7: (-1746, 0)}, [2]),
            (Store.BASE, False): block(Store.BASE, False, {40: (0.75,)}, [1]),
        },
    )
    body = [
        Comment(0, "start of the seam"),
        Assign(0, speed, Argument(1)),
        Move(
            0,
            Shape.JOINT,
            (Taught(Store.ROBOT, 0),),
            Speed(SpeedUnit.FRACTION, Quantity(Number(25), 0.01)),
            Blend(BlendKind.LEVEL, Quantity(Number(2), 1.0)),
            (
                MovePart(
                    Shape.JOINT, (Taught(Store.STATION, 7),), Speed(SpeedUnit.FRACTION, metres(0.78, 0.01))
                ),
            ),
        ),
        Move(
            0,
            Shape.LINEAR,
            (Taught(Store.ROBOT, 1),),
            Speed(SpeedUnit.TRAVEL, Quantity(speed, 0.1 * MM)),
            comment="to the wall",
        ),
        Dwell(0, Quantity(Number(0.5), 1.0)),
        Dwell(0, Quantity(Number(0.125), 1.0)),
    ]
    made = program_of(
        body,
        points=table,
        comment="two points",
        groups=(ControlGroup(("RB1", "BS1")), ControlGroup(("ST1",))),
        relative_to=FrameRef("user", Number(4)),
        locals={Store.DOUBLE: 3, Store.BASE: 1},
        arguments=(Store.DOUBLE,),
        aliases={"V_Seam": speed, "Zahl": Variable(Store.INTEGER, Number(12), False, "Zahl")},
        details={
            "DATE": "2026/03/02 14:07",
            "ATTR": "SC,RW,RJ",
            "FOLDERNAME": "DEMO",
            "ARGTYPE": "D,,,,,,,",
            "COMMENT": "seam speed" + "\n" * 7,
        },
    )
    assert made.export("inform").decode("ascii").split("\r\n") == [
        "/JOB",
        "//NAME MADE",
        "///FOLDERNAME DEMO",
        "//POS",
        "///NPOS 2,0,1,0,1,0",
        "///TOOL 2",
        "///POSTYPE PULSE",
        "///PULSE",
        "C00000=-1203,20417,-33120,512,-41877,902",
        "///USER 4",
        "///POSTYPE USER",
        "///RECTAN",
        "///RCONF 1,0,1,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0",
        "C00001=412.310,-87.0451,-0.000001,3.1000,-12.0071,91.3300",
        "///TOOL 0",
        "///POSTYPE PULSE",
        "///PULSE",
        "///LIMIT ON",
        "EC00007=-1746,0",
        "///TOOL 2",
        "///POSTYPE USER",
        "///RECTAN",
        "///LIMIT OFF",
        "BP00040=750.000",
        "//ALIAS",
        "///GVARS 0,1,0,0,0,0,0,0",
        "I012 Zahl",
        "///LVARS 0,0,1,0,0,0,0,0",
        "LD000 V_Seam",
        "//ARGINFO",
        "///ARGTYPE D,,,,,,,",
        "///COMMENT",
        "seam speed",
        *[""] * 7,
        "//INST",
        "///DATE 2026/03/02 14:07",
        "///COMM two points",
        "///ATTR SC,RW,RJ",
        "////FRAME USER 4",
        "///GROUP1 RB1,BS1",
        "///GROUP2 ST1",
        "///LVARS 0,0,3,0,0,0,1,0",
        "NOP",
        "'start of the seam",
        "GETARG V_Seam IARG#(1)",
        "MOVJ C00000 VJ=25.00 PL=2  +MOVJ EC00007 VJ=0.78",
        "MOVL C00001 V=V_Seam  //to the wall",
        "TIMER T=0.50",
        "TIMER T=0.125",
        "END",
        "",
    ]


def test_numbers_keep_what_they_are_whole_or_real():
    target = Variable(Store.REAL, Number(3))
    body = [Assign(0, target, Number(value)) for value in (12, 12.0, -7, 0.0625, 1e-9, 2e10, -0.0)]
    assert lines_of(program_of(body)) == [
        f"SET R003 {text}" for text in ("12", "12.0", "-7", "0.0625", "0.000000001", "20000000000.0", "0.0")
    ]


def test_arithmetic_gets_the_parentheses_it_needs_and_no_others():
    a, b, c = (Variable(Store.DOUBLE, Number(n)) for n in (1, 2, 3))
    cases = {
        "D001 - D002 - D003": Binary("-", Binary("-", a, b), c),
        "D001 - ( D002 - D003 )": Binary("-", a, Binary("-", b, c)),
        "D001 * ( D002 + D003 )": Binary("*", a, Binary("+", b, c)),
        "D001 * D002 + D003": Binary("+", Binary("*", a, b), c),
        "D001 / ( D002 * D003 )": Binary("/", a, Binary("*", b, c)),
        "D001 / -D002 * D003": Binary("*", Binary("/", a, Unary("-", b)), c),
        "-( D001 + D002 ) * D003": Binary("*", Unary("-", Binary("+", a, b)), c),
    }
    written = lines_of(program_of([Assign(0, a, value) for value in cases.values()]))
    assert written == [f"SET D001  EXPRESS {text}" for text in cases]


# --- random programs ------------------------------------------------------------------------------------

thousandths = st.integers(-999_999, 999_999).map(lambda n: n / 1000)
numbers = st.one_of(st.integers(-99_999, 99_999), thousandths).map(Number)
indices = st.integers(0, 999).map(Number)
counted = st.builds(
    Variable, st.sampled_from([Store.BYTE, Store.INTEGER, Store.DOUBLE]), indices, st.booleans()
)
NAMED = {
    "V_Seam": Variable(Store.DOUBLE, Number(4), True, "V_Seam"),
    "Höhe links": Variable(Store.REAL, Number(11), False, "Höhe links"),
    "MOVL": Variable(Store.BYTE, Number(12), False, "MOVL"),
}
scalars = st.one_of(
    counted,
    st.builds(Variable, st.just(Store.REAL), indices, st.booleans()),
    st.builds(Variable, st.sampled_from([Store.DOUBLE, Store.REAL]), counted, st.booleans()),
    st.sampled_from(list(NAMED.values())),
)
robots = st.builds(Variable, st.just(Store.ROBOT), st.one_of(indices, counted), st.booleans())
stations = st.builds(Variable, st.just(Store.STATION), indices, st.booleans())
systems = st.builds(Variable, st.just(Store.SYSTEM), st.one_of(indices, counted), st.booleans())
taught = st.builds(Taught, st.sampled_from([Store.ROBOT, Store.BASE, Store.STATION]), st.integers(0, 99_999))
letters = st.characters(codec="cp1252", exclude_categories=("C", "Z"), exclude_characters="\"'")
texts = st.text(st.one_of(letters, st.sampled_from(" /'")), max_size=30).map(Text)
values = st.one_of(numbers, scalars)
signals = st.builds(
    Signal, st.sampled_from(["in", "out", "in-group", "out-group", "system-out"]), st.one_of(indices, scalars)
)
registers = st.builds(
    Signal, st.just("register"), st.one_of(indices, scalars), st.sampled_from(["", "low", "high"])
)
arithmetic = st.recursive(
    st.one_of(st.integers(0, 9_999).map(Number), scalars),
    lambda inner: st.one_of(
        st.builds(Binary, st.sampled_from("+-*/"), inner, inner),
        st.builds(Unary, st.just("-"), inner.filter(lambda e: not isinstance(e, Number))),
    ),
    max_leaves=8,
)
comparisons = st.one_of(
    st.builds(Compare, st.sampled_from(["=", "<>", "<", ">", "<=", ">="]), scalars, values),
    st.builds(Compare, st.sampled_from(["=", "<>"]), signals, st.builds(SignalState, st.booleans())),
    st.builds(Compare, st.just("="), st.builds(Variable, st.just(Store.STRING), indices), texts),
)
conditions = st.one_of(
    comparisons,
    st.builds(
        Logic,
        comparisons,
        st.lists(st.tuples(st.sampled_from(["and", "or"]), comparisons), min_size=1, max_size=3).map(tuple),
    ),
)
maybe_condition = st.one_of(st.none(), conditions)
positive = st.integers(1, 999_999)


def quantities(scale, variable_scale):
    literal = positive.map(lambda n: Quantity(Number(n / 100), scale))
    return st.one_of(literal, counted.map(lambda v: Quantity(v, variable_scale)))


speeds = st.one_of(
    quantities(MM, 0.1 * MM).map(lambda q: Speed(SpeedUnit.TRAVEL, q)),
    quantities(0.01, 0.0001).map(lambda q: Speed(SpeedUnit.FRACTION, q)),
    quantities(DEG, 0.1 * DEG).map(lambda q: Speed(SpeedUnit.TURN, q)),
)
times = quantities(1.0, 0.01)
blends = st.integers(0, 8).map(lambda n: Blend(BlendKind.LEVEL, Quantity(Number(n), 1.0)))
comments = st.text(letters, max_size=20)
frames = st.one_of(
    st.sampled_from(["base", "robot", "tool", "master-tool"]).map(FrameRef),
    st.builds(FrameRef, st.just("user"), st.one_of(indices, scalars)),
)
searches = st.builds(
    Search,
    st.builds(Signal, st.just("direct-in"), indices),
    st.booleans(),
    st.one_of(st.none(), times),
    quantities(MM, 0.001 * MM),
)
parts = st.lists(
    st.one_of(
        st.builds(
            MovePart,
            st.sampled_from([Shape.JOINT, Shape.LINEAR]),
            st.tuples(st.one_of(taught, stations)),
            st.one_of(st.none(), speeds),
            st.one_of(st.none(), blends),
        ),
        st.builds(MovePart, st.none(), st.tuples(taught), st.none(), st.none()),
    ),
    max_size=2,
).map(tuple)
shapes = st.sampled_from(list(Shape))
targets = st.one_of(
    st.tuples(st.one_of(taught, robots)), st.tuples(robots, stations), st.tuples(taught, taught)
)
percents = st.integers(1, 100).map(lambda n: Quantity(Number(n), 0.01))
moves = st.builds(
    Move,
    st.just(0),
    shapes,
    targets,
    st.one_of(st.none(), speeds),
    st.one_of(st.none(), blends),
    parts,
    comments,
    st.one_of(st.none(), percents),
    st.one_of(st.none(), percents),
    coordinated=st.booleans(),
    end_of_arc=st.booleans(),
    search=st.one_of(st.none(), searches),
    no_wait=st.booleans(),
    passes=st.sampled_from(["", "T00001", "T00012"]),
).map(braked)


@st.composite
def relative_moves(draw):
    speed = draw(speeds)
    shape = Shape.JOINT if speed.unit is SpeedUnit.FRACTION else Shape.LINEAR
    frame = draw(st.one_of(frames, st.just(FrameRef("own"))))
    return Move(0, shape, (draw(robots),), speed, draw(st.one_of(st.none(), blends)), relative=frame)


names = st.from_regex(r"[A-Z][A-Z0-9_-]{0,12}", fullmatch=True)
labels = st.from_regex(r"[A-Z0-9][A-Z0-9_-]{0,7}", fullmatch=True)
zero = st.just(0)
statements = st.one_of(
    moves,
    relative_moves(),
    st.builds(Reference, zero, indices, st.tuples(taught), st.just(()), st.booleans(), comments),
    st.builds(SetSpeed, zero, st.lists(speeds, min_size=1, max_size=3).map(tuple), comments),
    st.builds(Assign, zero, scalars, st.one_of(values, arithmetic, registers), comments),
    st.builds(Assign, zero, robots, st.one_of(robots, stations)),
    st.builds(Assign, zero, st.builds(Element, robots, st.integers(1, 7).map(Number)), values),
    st.builds(Assign, zero, scalars, st.builds(Element, robots, st.integers(1, 7).map(Number))),
    st.builds(Assign, zero, scalars, st.just(SystemValue("returned"))),
    st.builds(
        Assign, zero, systems, st.sampled_from([SystemValue("position-pulse"), SystemValue("position-pose")])
    ),
    st.builds(Assign, zero, scalars, st.integers(1, 8).map(Argument)),
    st.builds(
        Assign,
        zero,
        robots,
        st.builds(Function, st.sampled_from(["tool-data", "step-position"]), st.tuples(indices)),
    ),
    st.builds(Assign, zero, st.builds(Function, st.just("tool-data"), st.tuples(indices)), robots),
    st.builds(Assign, zero, systems, st.builds(Function, st.just("convert"), st.tuples(systems, frames))),
    st.builds(Assign, zero, scalars, st.builds(Function, st.just("sqrt"), st.tuples(scalars))),
    st.builds(Assign, zero, robots, st.builds(Function, st.just("pose-product"), st.tuples(robots, robots))),
    st.builds(
        Update, zero, st.sampled_from(["+", "-", "*", "/", "and", "or", "xor"]), scalars, values, comments
    ),
    st.builds(Clear, zero, counted, st.one_of(st.none(), st.integers(1, 99).map(Number))),
    st.just(Clear(0, None)),
    st.builds(SetOutput, zero, signals, st.one_of(st.builds(SignalState, st.booleans()), scalars), comments),
    st.builds(SetOutput, zero, registers, values),
    st.builds(PulseOutput, zero, signals, st.one_of(st.none(), times), maybe_condition),
    st.builds(ReadInput, zero, counted, signals),
    st.builds(Dwell, zero, times, comments),
    st.builds(Wait, zero, conditions, st.one_of(st.none(), times)),
    st.builds(Label, zero, labels),
    st.builds(Jump, zero, st.one_of(labels, counted), maybe_condition),
    st.builds(
        Call,
        zero,
        names,
        st.lists(st.one_of(numbers, counted, texts, st.sampled_from(list(NAMED.values()))), max_size=3).map(
            tuple
        ),
    ),
    st.builds(Call, zero, names, st.just(()), conditions),
    st.builds(Call, zero, st.just(""), st.lists(numbers, max_size=3).map(tuple), macro=indices),
    st.builds(Return, zero, st.one_of(st.none(), scalars), maybe_condition),
    st.builds(If, zero, conditions, comments),
    st.builds(ElseIf, zero, conditions),
    st.sampled_from(
        [Else(0), EndIf(0), EndWhile(0), Default(0), EndSwitch(0), ShiftOff(0), ShiftOff(0, coordinated=True)]
    ),
    st.builds(While, zero, conditions),
    st.builds(For, zero, counted, values, values, st.one_of(st.none(), values)),
    st.builds(Next, zero, st.one_of(st.none(), counted)),
    st.builds(Switch, zero, scalars),
    st.builds(Case, zero, st.lists(st.integers(0, 99).map(Number), min_size=1, max_size=3).map(tuple)),
    st.builds(Pause, zero, maybe_condition),
    st.builds(
        StartTask,
        zero,
        names,
        st.sampled_from(["SUB1", "SUB12"]),
        maybe_condition,
        synchronised=st.booleans(),
    ),
    st.builds(WaitTask, zero, st.just("SUB3")),
    st.builds(Synchronise, zero, indices, st.one_of(st.none(), st.integers(2, 9).map(Number))),
    st.builds(ShiftOn, zero, robots, st.one_of(st.none(), frames), st.text(max_size=0), st.booleans()),
    st.builds(
        DefineFrame,
        zero,
        st.builds(FrameRef, st.just("user"), indices),
        st.tuples(systems, systems, systems),
        st.booleans(),
    ),
    st.builds(ExternalTool, zero, st.one_of(st.none(), indices)),
    st.builds(Message, zero, texts),
    st.builds(
        Process,
        zero,
        st.sampled_from(["ARCON", "WVON"]),
        st.lists(
            st.one_of(
                st.tuples(st.sampled_from(["ASF#", "WEV#"]), st.one_of(indices, scalars)),
                st.tuples(st.sampled_from(["AMP", "T", "U/D"]), values),
                st.tuples(st.just(""), texts),
            ),
            max_size=3,
        ).map(tuple),
    ),
    st.builds(
        Comment, zero, st.text(st.one_of(letters, st.sampled_from(" '\"/")), max_size=32).map(str.rstrip)
    ),
    st.builds(Disabled, zero, st.just("MOVL C00003 V=93.0")),
    st.just(Opaque(0, "GRIPPERX 7 FAST")),
)


def exported_and_read(body, encoding="cp1252"):
    made = program_of(body, aliases=NAMED)
    return made, read_source(decode(export(made, "inform"), "made.jbi", encoding))


@pytest.mark.slow
@settings(max_examples=150, deadline=None)
@given(st.lists(statements, min_size=1, max_size=12))
def test_whatever_a_program_says_is_read_again_as_it_was(body):
    made, other = exported_and_read(body)
    assert body_of(made.routines[0]) == body_of(other.routines[0])
    assert other.routines[0].aliases == NAMED


@st.composite
def point_tables(draw):
    kinds = st.one_of(
        st.builds(
            PointState, st.just(PointKind.PULSE), tool=st.integers(0, 63), outside_limits=st.booleans()
        ),
        st.builds(PointState, st.just(PointKind.JOINT), st.just("joint"), tool=st.integers(0, 63)),
        st.builds(
            PointState,
            st.just(PointKind.POSE),
            st.sampled_from(["base", "robot", "tool", "master-tool"]),
            tool=st.integers(0, 63),
            configuration=st.sampled_from([(1,) + (0,) * 23, (0, 1, 0, 0, 1) + (0,) * 19]),
        ),
        st.builds(
            PointState,
            st.just(PointKind.POSE),
            st.just("user"),
            st.integers(0, 63),
            st.integers(0, 9),
            st.just((0,) * 24),
        ),
    )
    states = tuple(draw(st.lists(kinds, min_size=1, max_size=4, unique=True)))
    blocks = {}
    for store, is_taught in draw(
        st.lists(
            st.sampled_from(
                [(s, t) for s in (Store.ROBOT, Store.BASE, Store.STATION) for t in (True, False)]
            ),
            unique=True,
            max_size=4,
        )
    ):
        width = draw(st.integers(6, 7)) if store is Store.ROBOT else draw(st.integers(1, 2))
        count = draw(st.integers(1, 7))
        which = draw(st.lists(st.integers(0, len(states) - 1), min_size=count, max_size=count))
        rows = {}
        for number, index in enumerate(which):
            state = states[index]
            written = draw(st.lists(st.integers(-9_999_999, 9_999_999), min_size=width, max_size=width))
            rows[number * 3 + 1] = tuple(si(value, at, store, state) for at, value in enumerate(written))
        blocks[store, is_taught] = block(store, is_taught, rows, which)
    return PointTable(states, blocks)


def si(written, at, store, state):
    """The value of a field in SI, as a reader computes it from its decimal text."""
    if state.kind is PointKind.PULSE:
        return float(written)
    slides = store is Store.BASE or (store is Store.ROBOT and state.kind is PointKind.POSE and at < 3)
    return written / 1000 * MM if slides else written / 10_000 * DEG


@settings(max_examples=80, deadline=None)
@given(point_tables())
def test_whatever_points_a_program_has_are_read_again_to_the_last_bit(table):
    made = program_of([], points=table)
    other = again(made)
    assert points_of(made.routines[0]) == points_of(other.routines[0])
    assert "P013" not in [found.code for found in other.diagnostics]
    assert not [found for found in other.diagnostics if "NPOS" in found.message]


# --- from another language ------------------------------------------------------------------------------


def test_si_values_of_another_language_become_the_units_of_inform():
    body = [
        Move(
            0,
            Shape.LINEAR,
            (Taught(Store.ROBOT, 3),),
            Speed(SpeedUnit.TRAVEL, Quantity(Number(0.1 + 0.2), 1.0)),
            acceleration=Quantity(Number(0.35), 1.0),
        ),
        Move(
            0, Shape.JOINT, (Taught(Store.ROBOT, 3),), Speed(SpeedUnit.FRACTION, Quantity(Number(0.07), 1.0))
        ),
        Move(
            0, Shape.LINEAR, (Taught(Store.ROBOT, 3),), Speed(SpeedUnit.TURN, Quantity(Number(0.5), math.pi))
        ),
        Dwell(0, Quantity(Number(350), 0.001)),
    ]
    text = foreign_text(program_of(body, vendor="krl"))
    assert text.partition("NOP\r\n")[2].split("\r\n")[:-2] == [
        "MOVL C00003 V=300.0 ACC=35 DEC=35",
        "MOVJ C00003 VJ=7.00",
        "MOVL C00003 VR=90.0",
        "TIMER T=0.35",
    ]


def test_the_noise_of_computed_poses_is_not_written():
    state = PointState(PointKind.POSE, "base", configuration=(1,) + (0,) * 23)
    values = (0.1 + 0.2, -1e-12, 1 / 3, math.pi / 7, -1e-13, 0.4)
    table = PointTable((state,), {(Store.ROBOT, True): block(Store.ROBOT, True, {0: values}, [0])})
    text = foreign_text(program_of([], vendor="krl", points=table))
    assert "C00000=300.000,0.000,333.333,25.7143,0.0000,22.9183\r\n" in text


def test_everything_that_cannot_be_said_is_refused_at_once_with_its_line():
    point = Taught(Store.ROBOT, 1)
    body = [
        Assign(0, Element(Variable(Store.ROBOT, Number(1)), Number(1)), Binary("+", Number(1), Number(2))),
        Dwell(0, Quantity(Number(1.0), 1.0)),
        If(0, Signal("in", Number(3))),
        Process(0, "BAS", (("", Text("#VEL_PTP")),)),
        Opaque(0, "$ADVANCE = 3"),
        Message(0, Text('a "quoted" word')),
        Move(0, Shape.CIRCULAR, (point,), relative=FrameRef("base")),
        Dwell(0, Quantity(Variable(Store.REAL, Number(2)), 0.001)),
    ]
    with pytest.raises(OlpError) as caught:
        foreign_text(program_of(body, vendor="krl"))
    found = caught.value.diagnostics
    assert {one.code for one in found} == {"X002"}
    assert [one.line for one in found] == [2, 4, 5, 6, 7, 8, 9]


def test_words_of_inform_are_written_back_word_for_word():
    body = [
        Opaque(0, "GRIPPERX 7 FAST"),
        Disabled(0, "DOUT OT#(4) ON"),
        Process(0, "ARCON", (("ASF#", Number(3)),)),
    ]
    assert lines_of(program_of(body)) == ["GRIPPERX 7 FAST", "COMM DOUT OT#(4) ON", "ARCON ASF#(3)"]


# --- encodings and files --------------------------------------------------------------------------------


def test_a_character_that_the_encoding_lacks_is_told_with_its_line():
    made = program_of([Comment(0, "ok"), Comment(0, "溶接"), Comment(0, "Σ")])
    with pytest.raises(OlpError) as caught:
        made.export("inform")
    assert [(one.code, one.source_line) for one in caught.value.diagnostics] == [
        ("X003", "'溶接"),
        ("X003", "'Σ"),
    ]
    data = program_of([Comment(0, "溶接")]).export("inform", encoding="shift_jis")
    assert "'溶接\r\n".encode("shift_jis") in data


def test_an_unknown_encoding_is_a_diagnostic():
    with pytest.raises(OlpError, match="X003"):
        program_of([]).export("inform", encoding="klingon")


def test_bytes_that_nobody_could_decode_are_written_as_they_were():
    text = (SAMPLES / "inform/welding/HOME.JBI").read_bytes().replace(b"NOP\r\n", b"NOP\r\n'\x81 door\r\n")
    program = read_source(decode(text, "home.jbi", "cp1252"))
    assert program.export("inform") == text


def test_a_mark_of_the_byte_order_is_left_out():
    program = read(SAMPLES / "inform/pitfalls/utf8-bom.jbi")
    assert program.to_bytes().startswith(b"\xef\xbb\xbf")
    assert program.export("inform").startswith(b"/JOB\r\n")


def test_a_program_with_errors_is_not_exported():
    program = read(SAMPLES / "inform/broken/bad-tool.jbi")
    with pytest.raises(OlpError) as caught:
        program.export("inform")
    assert caught.value.diagnostics
    assert all(found.is_error and found.file for found in caught.value.diagnostics)


def test_a_language_that_cannot_be_written_is_refused_with_the_list_of_those_that_can():
    with pytest.raises(OlpError) as caught:
        program_of([]).export("basic")
    found = caught.value.diagnostics[0]
    assert found.code == "X001"
    assert "inform (Yaskawa INFORM)" in found.help
    assert "inform" in writable()


def test_an_export_to_a_file_is_whole_and_spares_the_input(tmp_path):
    job = tmp_path / "home.jbi"
    job.write_bytes((SAMPLES / "inform/welding/HOME.JBI").read_bytes())
    program = olp.read(job)
    assert program.export("inform", tmp_path / "new.jbi") == (tmp_path / "new.jbi").read_bytes()
    with pytest.raises(OlpError):
        program.export("inform", job)
    assert [path.name for path in sorted(tmp_path.iterdir())] == ["home.jbi", "new.jbi"]


def test_a_users_template_shapes_the_file(tmp_path):
    template = tmp_path / "list.j2"
    template.write_text("{% for job in jobs %}{{ job.name }}\n{{ job.instructions }}{% endfor %}")
    text = program_of([Dwell(0, Quantity(Number(2.0), 1.0))]).export("inform", template=str(template))
    assert text == b"MADE\r\nNOP\r\nTIMER T=2.00\r\nEND\r\n"


def test_a_hundred_thousand_moves_are_written_in_a_few_seconds():

    count = 100_000
    state = PointState(PointKind.POSE, "base", configuration=(1,) + (0,) * 23)
    numbers = np.arange(count, dtype=np.int64)
    poses = np.column_stack([np.round(np.sin(numbers * 0.01 + at), 3) * MM * 500 for at in range(6)])
    rows = dict(enumerate(range(count)))
    zeros = np.zeros(count, dtype=np.int32)
    table = PointTable(
        (state,), {(Store.ROBOT, True): PointBlock(Store.ROBOT, True, numbers, poses, zeros, zeros, rows)}
    )
    speed = Speed(SpeedUnit.TRAVEL, metres(187.0))
    body = tuple(Move(0, Shape.LINEAR, (Taught(Store.ROBOT, n),), speed) for n in range(count))
    routine = Routine("BIG", 1, (Begin(0), *body, End(0)), table)
    with cpu_time_below(5.0):
        data = foreign_text(Program("krl", decode(b"", "", "cp1252"), (routine,))).encode()
    assert data.count(b"\r\nMOVL C") == data.count(b"\r\nC") == count
