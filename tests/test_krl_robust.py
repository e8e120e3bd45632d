"""The fast path against the grammar, and texts that nobody meant to write: no exception, no runaway time."""

from __future__ import annotations

import random
from pathlib import Path

import pytest
from cpu_time import cpu_time_below
from hypothesis import given, settings
from hypothesis import strategies as st
from krl_programs import meaning, read, source

from olp.core.source import decode
from olp.languages.vendors.krl import body, lists
from olp.languages.vendors.krl.reader import read_program
from olp.languages.vendors.krl.writer import write

SAMPLES = Path(__file__).resolve().parent.parent / "samples" / "krl"
FILES = sorted(SAMPLES.glob("*.*"))


class Declines:
    """Stands for a regular expression that no line matches."""

    def fullmatch(self, _: str) -> None:
        return None


NUMBERS = st.one_of(
    st.integers(-99999, 99999).map(str),
    st.floats(-9999, 9999, allow_nan=False).map(lambda v: f"{v:.4f}"),
    st.sampled_from(["0", "-0.0", "+5", "12.", "1E3", ".5", "-7.25"]),
)
COMPONENTS = st.sampled_from(
    ["X", "Y", "Z", "A", "B", "C", "x", "E1", "E3", "S", "T", "A1", "A3", "A6", "Q", "E9"]
)


@st.composite
def aggregates(draw: st.DrawFn) -> str:
    names = draw(st.lists(COMPONENTS, min_size=1, max_size=8, unique_by=str.upper))
    blank = draw(st.sampled_from(["", " "]))
    tag = draw(st.sampled_from(["", "", "E6POS: ", "e6axis:", "AXIS :", "Q: "]))
    return "{" + tag + f",{blank}".join(f"{name} {draw(NUMBERS)}" for name in names) + "}"


@st.composite
def lines(draw: st.DrawFn) -> str:
    word = draw(st.sampled_from(["PTP", "LIN", "lin", "Ptp"]))
    target = draw(st.one_of(aggregates(), st.sampled_from(["XP1", "xp1", "grip", "C_DIS", "TRUE", "$H_POS"])))
    blend = draw(st.sampled_from(["", " C_DIS", " c_ptp", " C_VEL", " C_PTP C_DIS", " C_DES"]))
    return f"{word} {target}{blend}"


def both(monkeypatch: pytest.MonkeyPatch, *texts: str, dat: list[str] | None = None) -> None:
    fast = read(*texts, dat=dat)
    with monkeypatch.context() as patch:
        patch.setattr(body.KrlMoveLines, "read", lambda *_: None)
        patch.setattr(body, "ACTUAL", Declines())
        patch.setattr(body, "NUMBER_ROW", Declines())
        patch.setattr(body, "declared", lambda *_: None)
        patch.setattr(lists.fast, "ROW", Declines())
        patch.setattr(lists.fast, "RECORD_ROW", Declines())
        slow = read(*texts, dat=dat)
    assert meaning(fast) == meaning(slow)
    assert [d.render() for d in fast.diagnostics] == [d.render() for d in slow.diagnostics]
    assert fast.line_kinds == slow.line_kinds


@settings(max_examples=150, deadline=None)
@given(lines())
def test_the_fast_path_reads_moves_as_the_grammar_does(line: str) -> None:
    with pytest.MonkeyPatch.context() as monkeypatch:
        both(monkeypatch, "SIGNAL grip $OUT[1]", line, f"{line} ; said")


NAMES = st.sampled_from(
    ["$VEL.CP", "$vel_axis[1]", "$OUT[3]", "grip", "$TIMER[2]", "COUNT", "if", "I[2].X", "TRUE", "$OV_PRO"]
)


@settings(max_examples=100, deadline=None)
@given(st.lists(st.tuples(NAMES, NUMBERS), min_size=2, max_size=5))
def test_numbers_are_given_as_the_grammar_reads_it(rows: list[tuple[str, str]]) -> None:
    texts = [f"{name}={number}" for name, _ in rows for _, number in rows]
    with pytest.MonkeyPatch.context() as monkeypatch:
        both(monkeypatch, "SIGNAL grip $OUT[1]", *texts, "PTP XP1", "LIN XP1 C_DIS")


@settings(max_examples=100, deadline=None)
@given(st.sampled_from(["E6POS", "POS", "FRAME", "E6AXIS", "axis", "FDAT"]), aggregates(), st.booleans())
def test_the_fast_path_reads_rows_as_the_grammar_does(kind: str, aggregate: str, shared: bool) -> None:
    with pytest.MonkeyPatch.context() as monkeypatch:
        row = f"DECL {'GLOBAL ' if shared else ''}{kind} XP1={aggregate}"
        both(monkeypatch, "FDAT_ACT=XP1", dat=[row, row.replace("XP1", "XP2"), "XP2={X 5}"])
        both(monkeypatch, row, f"{row} ; said", "PTP xp1", "LIN XP1")


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.name)
def test_damaged_bytes_are_told_and_nothing_else_happens(path: Path) -> None:
    raw = path.read_bytes()
    chance = random.Random(path.name)
    for _ in range(60):
        damaged = bytearray(raw)
        for _ in range(chance.randint(1, 12)):
            damaged[chance.randrange(len(damaged))] = chance.randrange(256)
        check(bytes(damaged))


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.name)
def test_cut_and_shuffled_texts_are_told_and_nothing_else_happens(path: Path) -> None:
    raw = path.read_bytes()
    chance = random.Random(path.name)
    rows = raw.split(b"\r\n")
    for _ in range(30):
        check(raw[: chance.randrange(len(raw))])
        mixed = list(rows)
        for _ in range(5):
            one, other = chance.randrange(len(mixed)), chance.randrange(len(mixed))
            mixed[one], mixed[other] = mixed[other], mixed[one]
        check(b"\r\n".join(mixed))
        words = raw.split(b" ")
        del words[chance.randrange(len(words))]
        check(b" ".join(words))


def check(raw: bytes) -> None:
    """Reads, keeps the bytes and gives every line a kind; whatever was understood can be written or is refused."""
    text = decode(raw, "a.src")
    with cpu_time_below(5.0):
        program = read_program(text, (decode(raw, "a.dat"),))
        assert program.to_bytes() == raw
        assert len(program.line_kinds) == len(text.lines)
        write(program, "")


@pytest.mark.parametrize(
    "text",
    [
        "n=" + "(" * 100_000,
        "n=" + "-" * 5_000 + "1",
        "n=" + "NOT " * 5_000 + "b",
        "LIN " + "{X 1," * 2_000,
        "n=" + "a." * 20_000 + "b",
        "n=" + "a[" * 3_000,
        "x" * 1_000_000,
        '"' * 50_000,
        ";" * 100_000,
        "n=1E999",
        "n=" + ":".join("a" * 1000),
        "LIN {X 1E400,Y 1,Z 1}",
        "IF b THEN\n" * 4_000,
        "PTP " + "{X 1,Y 2,Z 3,A 4,B 5,C 6}:" * 90 + "XP1",
    ],
    ids=range(14),
)
def test_hostile_texts_take_no_time(text: str) -> None:
    with cpu_time_below(4.0):
        program = read_program(
            source(["DEF PART ( )", text, "END"]), (source(["DEFDAT PART", text, "ENDDAT"], "part.dat"),)
        )
        assert program.diagnostics or text[0] == ";"
        write(program, "")


def test_elements_beyond_all_bounds_are_refused() -> None:
    program = read(dat=["INT N[3]", "N[999999999]=1", "N[0]=1", "N[2,2,2]=1"])
    assert [d.code for d in program.diagnostics if d.is_error] == ["P403", "P403", "P403"]
