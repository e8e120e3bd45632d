"""The fast path for plain moves gives exactly what the grammar gives; what is cached is what would be read again."""

from __future__ import annotations

from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from inform_jobs import job, read_lines
from lark.exceptions import UnexpectedInput

from olp.core.source import load
from olp.languages.vendors.inform import instructions
from olp.languages.vendors.inform.instructions import InformMoveLines
from olp.languages.vendors.inform.statements import instruction_parser

SAMPLES = sorted(
    path
    for path in (Path(__file__).resolve().parent.parent / "samples" / "inform").rglob("*")
    if path.suffix.lower() == ".jbi"
)

digits = st.integers(0, 99_999).map(lambda n: f"{n:05}") | st.integers(0, 999).map(lambda n: f"{n:03}")
position = st.builds(
    "{}{}".format, st.sampled_from(["C", "P", "LP", "EX", "BC", "EC", "BP", "LEX", "LBP"]), digits
)
number = st.integers(0, 2000).map(str) | st.decimals(0, 2000, places=2).map(str) | st.just("5.")
speed = st.builds("{}={}".format, st.sampled_from(["V", "VJ", "VR"]), number)
comment = st.text(st.characters(codec="utf-8", exclude_categories=("Cs", "Cc", "Zl", "Zp")), max_size=20)


@st.composite
def move_lines(draw: st.DrawFn) -> str:
    """Plain moves and their neighbours: some belong to the fast path, some to the grammar, some to neither."""
    words = [
        draw(st.sampled_from(["MOVJ", "MOVL", "MOVC", "SMOVL", "SMOVC", "IMOV", "MOVS"])),
        draw(position),
    ]
    words += draw(st.lists(position, max_size=2))
    words += draw(st.lists(speed, max_size=1))
    words += draw(
        st.lists(
            st.sampled_from(["PL=0", "PL=8", "PL=12", "CR=2.5", "CR=30", "ACC=20", "FPT", "CONT"]), max_size=2
        )
    )
    blank = draw(st.sampled_from([" ", " ", " ", "  "]))
    line = blank.join(words)
    for part in draw(st.lists(position, max_size=2)):
        line += (
            draw(st.sampled_from([" +", "  +", "+"]))
            + f"MOVJ {part}"
            + draw(st.sampled_from(["", " VJ=2.5"]))
        )
    if draw(st.booleans()):
        line += draw(st.sampled_from(["", " ", "  "])) + "//" + draw(comment)
    return line + draw(st.sampled_from(["", "", " ", " \t"]))


def assert_both_agree(line: str) -> bool:
    """Whether the fast path took the line; if so, the grammar must say the same."""
    fast = InformMoveLines().read(line, 0)
    if fast is None:
        return False
    parsed = instruction_parser().instruction(line, {})
    assert parsed.statements == (fast,)
    assert not parsed.remarks
    assert type(fast.line) is int
    return True


@settings(max_examples=400, deadline=None)
@given(move_lines())
def test_fast_path_and_grammar_agree_on_any_move(line: str) -> None:
    assert_both_agree(line)


def test_fast_path_and_grammar_agree_on_every_line_of_every_sample() -> None:
    lines = {line for path in SAMPLES for line in load(path).lines if "MOV" in line}
    taken = [line for line in sorted(lines) if assert_both_agree(line)]
    assert len(taken) > 300


@pytest.mark.parametrize(
    "line",
    [
        "MOVL C00001 V=187.0",
        "MOVL C00001 V=187.0 CR=1.5",
        "MOVJ C00001 VJ=25.00 PL=0  +MOVJ EC00001 VJ=25.00",
        "SMOVL C00005 BC00005 V=8.3  +MOVJ EC00005",
        "MOVL P040 BP040 V=250.0 PL=0  +MOVJ EX000 //x",
        "MOVC C00001 V=187.0  //seam start",
    ],
)
def test_common_moves_take_the_fast_path(line: str) -> None:
    assert assert_both_agree(line)


@pytest.mark.parametrize(
    "line", ["MOVL C00001 V=187.0 'x", "MOVX C1", "MOVL C00001 V=", "MOVL C00001 V=1 V=2"]
)
def test_what_is_not_plain_is_left_to_the_grammar(line: str) -> None:
    assert InformMoveLines().read(line, 1) is None


def test_words_that_stand_often_are_one_object() -> None:
    body = read_lines(job(["MOVL P001 V=11.5 PL=1", "MOVL P002 V=11.5 PL=1"])).routines[0].body
    assert body[1].speed is body[2].speed  # type: ignore[union-attr]
    assert body[1].blend is body[2].blend  # type: ignore[union-attr]


def test_a_line_seen_before_is_read_as_at_first() -> None:
    lines = {line for path in SAMPLES if path.parent.name != "broken" for line in load(path).lines}
    instructions._seen.clear()
    instructions._seen.update(instructions._PRESET)
    for line in sorted(lines):
        first = read_lines(job([line]))
        again = read_lines(job([line]))
        assert first.routines == again.routines or "nan" in repr(first.routines)
        assert first.diagnostics == again.diagnostics
        assert first.line_kinds == again.line_kinds


def test_the_lines_known_beforehand_are_what_the_grammar_says() -> None:
    for line, (kind, values) in instructions._PRESET.items():
        assert instruction_parser().instruction(line, {}).statements == (kind(0, *values),)


def test_the_grammar_refuses_what_no_statement_means() -> None:
    for line in ("MOVL", "MOVL C00001 V=", "CALL", "SET B000", "WAIT IN#(3", "ELSEIFEXP B"):
        with pytest.raises(UnexpectedInput):
            instruction_parser().instruction(line, {})
