"""PolyScope's own files: what their nodes mean, and what is no such file."""

from __future__ import annotations

import gzip
import zlib

import pytest

from olp.core.diagnostic import OlpError
from olp.core.source import decode
from olp.fluent import read_source
from olp.ir.expressions import Function, Named, Number, PositionLiteral, Signal, SignalState, Text
from olp.ir.program import (
    Call,
    Comment,
    Dwell,
    If,
    Message,
    Move,
    Path,
    Pause,
    Program,
    Return,
    SetOutput,
    StartTask,
    Wait,
    While,
)

JOINTS = "-0.31, -1.25, 1.42, -1.73, -1.56, 0.37"


def waypoint(name: str = "Above", more: str = "<motionParameters/>") -> str:
    place = f'<position><JointAngles angles="{JOINTS}"/></position>'
    return f'<Waypoint type="Fixed" name="{name}">{more}{place}</Waypoint>'


def move(children: str, kind: str = "MoveJ", more: str = "") -> str:
    return f'<Move motionType="{kind}" speed="1.05" acceleration="1.4" {more}><children>{children}</children></Move>'


def raw(main: str, before: str = "", once: str = "true") -> bytes:
    text = (
        f'<URProgram name="cell 3"><children>{before}<MainProgram runOnlyOnce="{once}"><children>{main}'
        "</children></MainProgram></children></URProgram>"
    )
    return gzip.compress(text.encode())


def read(data: bytes) -> Program:
    program = read_source(decode(data, "a.urp"))
    assert program.to_bytes() == data
    assert len(program.line_kinds) == len(program.source.lines)
    return program


def body(main: str, before: str = "") -> tuple[object, ...]:
    program = read(raw(main, before))
    assert not program.diagnostics
    return program.routines[0].body


def test_waypoints_are_joint_positions_with_the_manner_of_their_move() -> None:
    (found,) = body(move(waypoint()))
    assert isinstance(found, Move)
    assert found.path is Path.JOINT
    assert found.targets == (PositionLiteral("joint", (-0.31, -1.25, 1.42, -1.73, -1.56, 0.37)),)
    assert found.speed is not None
    assert found.rate is not None
    assert (found.speed.value.literal, found.rate.value.literal) == (1.05, 1.4)
    assert found.comment == "Above"


def test_the_old_form_of_a_waypoint_and_blends() -> None:
    rounded = '<motionParameters blendRadius="0.02"/>'
    old = f'<Waypoint type="Fixed" name="A">{rounded}<position joints="{JOINTS}"/></Waypoint>'
    joint, line, process = body(
        move(old) + move(waypoint(), "MoveL") + move(waypoint(), "MoveP", 'blendRadius="0.01"')
    )
    for found, radius in ((joint, 0.02), (line, 0), (process, 0.01)):
        assert isinstance(found, Move)
        assert found.blend is not None
        assert found.blend.value is not None
        assert found.blend.value.literal == radius
    assert isinstance(line, Move)
    assert line.path is Path.LINEAR


def test_variable_and_relative_waypoints_and_references() -> None:
    variable = '<Waypoint type="Variable" name="W"><variable name="grip at"/></Waypoint>'
    again = '<Waypoint type="Fixed" name="B"><position reference="../../Waypoint[2]/position"/></Waypoint>'
    relative = (
        f'<Waypoint type="Relative" name="R"><relativeFromPosition><JointAngles angles="{JOINTS}"/>'
        f'</relativeFromPosition><position><JointAngles angles="{JOINTS}"/></position></Waypoint>'
    )
    first, _, third, fourth = body(move(variable + waypoint() + again + relative, "MoveL"))
    assert isinstance(first, Move)
    assert isinstance(third, Move)
    assert isinstance(fourth, Move)
    assert first.targets == (Named("grip_at"),)
    assert third.targets[0] == PositionLiteral("joint", (-0.31, -1.25, 1.42, -1.73, -1.56, 0.37))
    assert isinstance(fourth.targets[0], Function)
    assert fourth.targets[0].name == "pose-add"


def test_waits_outputs_and_messages() -> None:
    pin = '<pin referencedName="digital_in[2]"/>'
    found = body(
        '<Wait type="Sleep"><waitTime>0.75</waitTime></Wait>'
        f'<Wait type="DigitalInput">{pin}<digitalValue>1</digitalValue></Wait>'
        '<Set type="DigitalOutput"><pin referencedName="config_out[3]"/><digitalValue>0</digitalValue></Set>'
        '<Set type="DigitalOutput"><pin referencedName="Lamp"/><digitalValue>1</digitalValue></Set>'
        '<Popup type="Message" message="go?"/><Halt/>'
    )
    dwell, wait, output, named, message, pause, halt = found
    assert isinstance(dwell, Dwell)
    assert dwell.duration.literal == 0.75
    assert isinstance(wait, Wait)
    assert wait.condition.right == SignalState(True)  # type: ignore[union-attr]
    assert isinstance(output, SetOutput)
    assert isinstance(named, SetOutput)
    assert output.signal == Signal("configurable-out", Number(3))
    assert named.signal == Signal("out", Text("Lamp"))
    assert [type(s) for s in (message, pause, halt)] == [Message, Pause, Return]


def test_blocks_expressions_and_subprograms() -> None:
    chars = "".join(f'<ExpressionChar character="{c}"/>' for c in "n>1")
    test = f"<expression>{chars}</expression>"
    call = '<CallSubProgram><subprogram reference="../../../../../../SubProgram"/></CallSubProgram>'
    before = (
        '<SubProgram name="Drop part"><children><Comment comment="down"/></children></SubProgram>'
        '<Thread name="Watch"><children><Wait type="Sleep"><waitTime>1</waitTime></Wait></children></Thread>'
        '<SpecialSequence type="BeforeStart"><children><Assignment valueSource="Expression">'
        '<variable name="n"/><expression><ExpressionChar character="2"/></expression></Assignment></children>'
        "</SpecialSequence>"
    )
    program = read(
        raw(
            f'<If type="If">{test}<children>{call}</children></If><If type="Else"><children/></If>'
            f'<Loop type="Counting" count="3"><loopVariable name="k"/><children>{call}</children></Loop>'
            '<Folder name="Place"><children/></Folder>',
            before,
            once="false",
        )
    )
    assert not program.diagnostics
    main = program.routines[0]
    assert [r.name for r in program.routines] == ["cell_3", "Drop_part", "Watch"]
    assert [d.value for d in program.data if d.name == "n"] == [Number(2)]
    kinds = [type(s) for s in main.body]
    assert kinds.count(While) == 2
    assert kinds.count(If) == 1
    assert [s.routine for s in main.body if isinstance(s, Call)] == ["Drop_part"] * 2
    assert [s.routine for s in main.body if isinstance(s, StartTask)] == ["Watch"]
    assert any(isinstance(s, Comment) and s.text == " Place" for s in main.body)


def test_nodes_that_are_not_modelled_are_told_with_their_number() -> None:
    program = read(raw("<Contributed/><Contributed/><Timer/>"))
    assert [d.code for d in program.diagnostics] == ["P563", "P563"]
    assert "Contributed is kept by its name only (2 of them)" in program.diagnostics[0].message


def test_uncompressed_programs_are_read() -> None:
    assert read(gzip.decompress(raw(move(waypoint())))).routines[0].name == "cell_3"


@pytest.mark.parametrize(
    "data",
    [
        gzip.compress(b"<URProgram><children>"),
        gzip.compress(b"<Other/>"),
        gzip.compress(b"no xml"),
        gzip.compress(b'<!DOCTYPE a [<!ENTITY b "c">]><URProgram/>'),
        b"\x1f\x8bgarbage",
        raw(move(waypoint()))[:60],
        gzip.compress(b"<URProgram>" + b" " * 60_000_000),
    ],
    ids=["cut", "other", "text", "entities", "garbage", "short", "large"],
)
def test_what_cannot_be_read_is_one_error(data: bytes) -> None:
    program = read_source(decode(data, "a.urp"))
    assert [d.code for d in program.diagnostics] == ["P562"]
    assert program.to_bytes() == data


def test_nodes_deep_in_one_another_and_circles_of_references_end() -> None:
    deep = "<Folder name='f'><children>" * 500 + "</children></Folder>" * 500
    assert [d.code for d in read(raw(deep)).diagnostics] == ["P563"]
    loops = '<Set type="DigitalOutput"><pin reference="../pin"/><digitalValue>1</digitalValue></Set>'
    assert read(raw(loops)).routines[0].body


def test_a_compressed_file_is_not_annotated() -> None:
    from olp.reports.annotate import annotate
    from olp.timing.timing import time_plan

    program = read(raw('<Wait type="Sleep"><waitTime>1</waitTime></Wait>'))
    with pytest.raises(OlpError) as raised:
        annotate(program, time_plan(program.plan(robot="universal-robots/ur10e")))
    assert "compressed" in raised.value.diagnostics[0].message


def test_damaged_files_do_not_crash() -> None:
    import random

    rng = random.Random(4)
    text = gzip.decompress(raw(move(waypoint()) + '<Popup type="Message" message="go?"/>'))
    for _ in range(200):
        damaged = bytearray(text)
        for _ in range(3):
            damaged[rng.randrange(len(damaged))] = rng.randrange(256)
        read_source(decode(gzip.compress(bytes(damaged), 1), "a.urp"))
        packed = bytearray(zlib.compress(bytes(text), wbits=31))
        packed[rng.randrange(2, len(packed))] = rng.randrange(256)
        read_source(decode(bytes(packed), "a.urp"))


@pytest.mark.parametrize(
    ("node", "told"),
    [
        ('<Wait type="Sleep"><waitTime>soon</waitTime></Wait>', "Wait without a time"),
        ('<Wait type="Sleep"/>', "Wait without a time"),
        ('<Loop type="Counting" count="n"><children/></Loop>', "Loop without a count"),
        ('<Set type="AnalogOutput"><analogValue>half</analogValue></Set>', "Set without a value"),
        ('<If type="If"><children/></If><If type="Else"><children/></If><If type="Else"><children/></If>',
         "Else without If"),
        ('<If type="ElseIf"><children/></If>', "ElseIf without If"),
        ('<Switch><children><Case caseValue="1"/><Default/><Default/></children></Switch>',
         "Default that no value leads to"),
    ],
)  # fmt: skip
def test_what_a_node_does_not_say_is_told_and_not_guessed(node: str, told: str) -> None:
    found = read(raw(node))
    assert [d.code for d in found.diagnostics] == ["P563"]
    assert told in found.diagnostics[0].message
    assert not any(isinstance(s, (Dwell, While)) for s in found.routines[0].body)


@pytest.mark.parametrize("data", [b"<?xml version='1.0'?><Installation/>", b"\xef\xbb\xbf<Installation/>"])
def test_xml_that_is_no_program_is_one_error(data: bytes) -> None:
    assert [d.code for d in read_source(decode(data, "a.urp")).diagnostics] == ["P562"]
