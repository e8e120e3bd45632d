"""Whole INFORM files: headers, groups, several jobs, generations, line ends; nothing of the text is ever lost."""

from __future__ import annotations

import random
import re
import threading
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from inform_jobs import job, read_lines
from lark import Lark

from olp.core.resources import read_text
from olp.core.source import decode, load
from olp.fluent import read_source
from olp.ir.expressions import FrameRef, Number, Store, Variable
from olp.ir.program import Begin, Comment, ControlGroup, End, LineKind, Move, Program
from olp.languages.vendors.inform.statements import instruction_parser

SAMPLES = sorted(
    path
    for path in (Path(__file__).resolve().parent.parent / "samples" / "inform").rglob("*")
    if path.suffix.lower() == ".jbi"
)
WHOLE = [path for path in SAMPLES if path.parent.name != "broken"]
DOCS = Path(__file__).resolve().parent.parent / "docs"

FULL = """/JOB
//NAME SEAM-12
///FOLDERNAME DEMO
//POS
///NPOS 1,0,1,0,0,0
///TOOL 2
///POSTYPE PULSE
///PULSE
C00000=-1203,20417,-33120,512,-41877,902
///TOOL 0
EC00000=-1746,0
//ALIAS
///GVARS 0,0,0,0,0,1,0,0
P00012 Ablage oben
///LVARS 0,0,1,0,0,0,0,0
LD000 V_Seam
//ARGINFO
///ARGTYPE D,,B,,,,,
///COMMENT
C00009=1,2,3
END

'quoted
//INST
///DATE 2026/03/02 14:07
///COMM seam of the left door
///ATTR SC,RW,RJ
////FRAME USER 3
///GROUP1 RB1,ST1
///GROUP2 RB2
///LVARS 0,0,4,0,0,2,0,0
NOP
'start
MOVJ C00000 VJ=25.00  +MOVJ EC00000
END
""".splitlines()


def read_bytes(raw: bytes) -> Program:
    return read_source(decode(raw, "test.jbi"), vendor="inform")


def test_a_full_header_is_read_record_by_record() -> None:
    program = read_lines(FULL)
    assert not program.diagnostics
    (routine,) = program.routines
    assert routine.name == "SEAM-12"
    assert routine.comment == "seam of the left door"
    assert routine.groups == (ControlGroup(("RB1", "ST1")), ControlGroup(("RB2",)))
    assert routine.relative_to == FrameRef("user", Number(3))
    assert routine.locals == {Store.DOUBLE: 4, Store.ROBOT: 2}
    assert routine.arguments == (Store.DOUBLE, None, Store.BYTE)
    assert routine.aliases == {
        "Ablage oben": Variable(Store.ROBOT, Number(12)),
        "V_Seam": Variable(Store.DOUBLE, Number(0), local=True),
    }
    assert routine.details == {
        "FOLDERNAME": "DEMO",
        "NPOS": "1,0,1,0,0,0",
        "ARGTYPE": "D,,B,,,,,",
        "COMMENT": "C00009=1,2,3\nEND\n\n'quoted",
        "DATE": "2026/03/02 14:07",
        "ATTR": "SC,RW,RJ",
        "FRAME": "USER 3",
        "GROUP1": "RB1,ST1",
        "GROUP2": "RB2",
    }
    assert [type(one) for one in routine.body] == [Begin, Comment, Move, End]
    assert (routine.line, routine.last_line) == (1, len(FULL))


def test_every_line_is_accounted_for_by_its_kind() -> None:
    kinds = read_lines(FULL).line_kinds
    by_text = {line: kind for line, kind in zip(FULL, kinds, strict=True) if line}
    assert by_text["C00000=-1203,20417,-33120,512,-41877,902"] == LineKind.POINT
    assert by_text["C00009=1,2,3"] == LineKind.FREE_TEXT
    assert by_text["'quoted"] == LineKind.FREE_TEXT
    assert by_text["'start"] == LineKind.COMMENT
    assert by_text["LD000 V_Seam"] == LineKind.RECORD
    assert by_text["NOP"] == LineKind.STATEMENT
    assert LineKind.BLANK not in by_text.values()


@pytest.mark.parametrize(
    ("record", "frame"),
    [
        ("////FRAME ROBOT", FrameRef("robot")),
        ("////FRAME BASE", FrameRef("base")),
        ("///FRAME BASE", FrameRef("base")),
        ("////FRAME USER 12", FrameRef("user", Number(12))),
        ("///FRAME 4", FrameRef("user", Number(4))),
    ],
)
def test_a_relative_job_names_its_frame_with_three_or_four_slashes(record: str, frame: FrameRef) -> None:
    program = read_lines(job(header=["///DATE 2026/01/01 10:00", "///ATTR SC,RW,RJ", record]))
    assert not program.diagnostics
    assert program.routines[0].relative_to == frame


def test_several_jobs_in_one_file_are_several_routines_with_their_own_names() -> None:
    first = job(["SET SPEED 1"], ["C00000=1,2,3,4,5,6"], ["B003 SPEED"], name="FIRST")
    second = job(["SET SPEED 2", "MOVL C00000"], ["C00000=9,2,3,4,5,6"], ["D004 SPEED"], name="SECOND")
    program = read_lines([*first, *second])
    assert not program.diagnostics
    one, two = program.routines
    assert (one.name, two.name) == ("FIRST", "SECOND")
    assert (one.last_line, two.line) == (len(first), len(first) + 1)
    assert one.points.find(Store.ROBOT, True, 0) != two.points.find(Store.ROBOT, True, 0)
    assert str(one.body[1]) != str(two.body[1])
    assert "DOUBLE" in str(two.body[1])


def test_a_job_of_the_erc_generation_is_read() -> None:
    lines = [
        "/JOB",
        "//NAME OLD",
        "//POS",
        "///NPOS 2,1,0,0",
        "///TOOL 0",
        "///RECTAN",
        "///RCONF 0,0,0,0,0",
        "C000=512.25,-33.50,700.75,178.25,3.50,-91.25",
        "C001=522.25,-33.50,700.75,178.25,3.50,-91.25",
        "E000=-0.37,,,,,",
        "//INST",
        "///DATE 1996/04/11 09:33",
        "///ATTR 0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,0",
        "///FRAME BASE",
        "NOP",
        "MOVJ C000 VJ=12.50 CONT",
        "MOVL C001 E000 V=46.0",
        "END",
    ]
    program = read_lines(lines)
    assert not program.diagnostics
    point = program.routines[0].points.find(Store.ROBOT, True, 1)
    assert point is not None
    assert point.state.configuration == (0, 0, 0, 0, 0)
    assert point.state.frame == "base"


def test_text_behind_the_last_line_end_and_the_old_end_mark_are_no_lines() -> None:
    text = "\r\n".join(job(["TIMER T=1.5"]))
    for tail in ("", "\r\n", "\r\n\x1a", "\x1a", "\r\n\r\n"):
        program = read_bytes((text + tail).encode())
        assert not program.diagnostics, tail
        assert isinstance(program.routines[0].body[-1], End)


@pytest.mark.parametrize("encoding", ["cp1252", "utf-8", "utf-8-sig", "shift_jis"])
def test_comments_and_names_survive_every_encoding(encoding: str) -> None:
    word = "溶接スタート" if encoding == "shift_jis" else "Öffner"
    lines = job([f"'{word}", f"SET {word} 3"], aliases=[f"B003 {word}"])
    program = read_lines(lines, encoding=encoding)
    assert not program.diagnostics
    comment = program.routines[0].body[1]
    assert isinstance(comment, Comment)
    assert comment.text == word
    assert list(program.routines[0].aliases) == [word]


@settings(max_examples=150, deadline=None)
@given(st.binary(max_size=300))
def test_any_bytes_are_read_without_an_exception_and_come_back(raw: bytes) -> None:
    program = read_bytes(raw)
    assert program.to_bytes() == raw
    assert len(program.line_kinds) == len(program.source.lines)


LINES = sorted({line for path in SAMPLES for line in load(path).raw.splitlines(keepends=True)})


def test_text_before_the_first_job_is_one_error_and_the_job_is_read() -> None:
    program = read_lines(["made on a PC", "", "/JOB later", *job(["TIMER T=1.5"])])
    assert [(d.code, d.line) for d in program.diagnostics] == [("P015", 1)]
    assert len(program.routines[0].body) == 3
    assert [d.code for d in read_lines(["/JOB later"]).diagnostics] == ["P015"]


@settings(max_examples=150, deadline=None)
@given(st.lists(st.sampled_from(LINES), max_size=40))
def test_any_mixture_of_lines_is_read_and_no_line_is_dropped_in_silence(lines: list[bytes]) -> None:
    program = read_bytes(b"".join(lines))
    assert program.to_bytes() == b"".join(lines)
    blank = [
        text
        for text, kind in zip(program.source.lines, program.line_kinds, strict=True)
        if kind == LineKind.BLANK and text.strip(" \t\x1a\ufeff")
    ]
    assert not blank


@pytest.mark.parametrize(
    "path", [path for path in WHOLE if "cam" not in path.parts], ids=lambda path: path.name
)
def test_a_damaged_sample_is_read_without_an_exception_and_never_half_in_silence(path: Path) -> None:
    raw = path.read_bytes()
    lines = re.split(rb"(?<=\n)", raw)
    choose = random.Random(path.name)
    whole = read_bytes(raw)
    for _ in range(12):
        flipped = bytearray(raw)
        flipped[choose.randrange(len(raw))] ^= 1 << choose.randrange(8)
        swapped = list(lines)
        a, b = choose.randrange(len(lines)), choose.randrange(len(lines))
        swapped[a], swapped[b] = swapped[b], swapped[a]
        cut = raw[: choose.randrange(len(raw))]
        for damaged in (bytes(flipped), b"".join(swapped), cut):
            program = read_bytes(damaged)
            assert program.to_bytes() == damaged
        lost = len(list(whole.statements())) - len(list(program.statements()))
        at_a_joint = cut.rstrip().endswith(b"END")  # between two jobs, or before a last blank line
        assert lost == 0 or at_a_joint or any(d.is_error for d in program.diagnostics)


@pytest.mark.parametrize("path", SAMPLES, ids=lambda path: path.name)
def test_every_sample_comes_back_byte_for_byte(path: Path) -> None:
    assert read_source(load(path), vendor="inform").to_bytes() == path.read_bytes()


@pytest.fixture(scope="module")
def whole_grammar() -> Lark:
    return Lark(read_text("grammars", "inform.lark"), parser="lalr", start="start")


@pytest.mark.parametrize("path", WHOLE, ids=lambda path: path.name)
def test_the_grammar_alone_reads_every_whole_sample(path: Path, whole_grammar: Lark) -> None:
    source = load(path)
    assert whole_grammar.parse(source.raw.decode(source.encoding, "surrogateescape")).children


def test_several_threads_read_at_once() -> None:
    jobs = [
        job([f"SET NAME {n}", f"IFTHEN B{n:03}={n}", "ENDIF"], aliases=[f"D{n:03} NAME"]) for n in range(8)
    ]
    alone = [read_lines(lines).routines for lines in jobs]
    results: dict[int, bool] = {}

    def read_many(n: int) -> None:
        results[n] = all(read_lines(jobs[n]).routines == alone[n] for _ in range(20))

    threads = [threading.Thread(target=read_many, args=(n,)) for n in range(8)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert results == dict.fromkeys(range(8), True)


def test_the_documentation_names_every_instruction_that_is_read() -> None:
    shown = set(re.findall(r"[A-Z][A-Z0-9]+\$?", (DOCS / "inform.md").read_text(encoding="utf-8")))
    assert instruction_parser().words - shown == set()
