"""Bad input: no traceback, no hang, no line lost; the fast ways give what the grammar gives."""

from __future__ import annotations

import random
import re
import time
from dataclasses import replace
from pathlib import Path

import pytest
from cpu_time import cpu_time_below
from tp_listings import HEAD, POSITION, listing, read

from olp.core.source import decode
from olp.fluent import read_source
from olp.languages.vendors.tp import instructions
from olp.languages.vendors.tp.grammar import instruction_parser
from olp.languages.vendors.tp.instructions import TpMoveLines
from olp.languages.vendors.tp.limits import LIMITS

SAMPLES = sorted((Path(__file__).parent.parent / "samples" / "tp").glob("*.ls"))
WORDS = (
    "L P[",
    "]",
    "[",
    "100mm/sec",
    "FINE",
    ";",
    ":",
    "{",
    "};",
    "GP1:",
    "THEN",
    "ENDIF",
    "-",
    "********",
    "\r\n",
    "'",
)


def check(raw: bytes) -> None:
    program = read_source(decode(raw, "bad.ls"), vendor="tp")
    assert program.to_bytes() == raw
    assert len(program.line_kinds) == len(program.source.lines)
    for found in program.diagnostics:
        assert found.render()
        assert 0 <= found.line <= len(program.source.lines)
        assert found.column >= 1


@pytest.mark.parametrize("path", SAMPLES, ids=lambda path: path.name)
@pytest.mark.parametrize("seed", range(60))
def test_a_damaged_listing_is_read_without_a_traceback(path: Path, seed: int) -> None:
    rng = random.Random(seed)
    raw = bytearray(path.read_bytes())
    for _ in range(rng.choice([1, 1, 3, 30])):
        kind = rng.randrange(6)
        at = rng.randrange(len(raw))
        stop = min(len(raw), at + rng.randrange(1, 80))
        if kind == 0:
            raw[at] = rng.randrange(256)
        elif kind == 1:
            del raw[at:stop]
        elif kind == 2:
            raw[at:at] = raw[at:stop]
        elif kind == 3:
            raw[at:at] = rng.choice(WORDS).encode()
        elif kind == 4:
            lines = bytes(raw).split(b"\r\n")
            a, b = rng.randrange(len(lines)), rng.randrange(len(lines))
            lines[a], lines[b] = lines[b], lines[a]
            raw = bytearray(b"\r\n".join(lines))
        elif rng.random() < 0.2 and at > 200:
            del raw[at:]
    check(bytes(raw))


@pytest.mark.parametrize("path", SAMPLES, ids=lambda path: path.name)
def test_a_listing_cut_off_anywhere_is_read(path: Path) -> None:
    raw = path.read_bytes()
    for at in range(0, len(raw), 37):
        check(raw[:at])


@pytest.mark.parametrize(
    "text",
    [
        "/PROG  A\n/MN\n" + "   1:  R[1]=(" * 3000,
        "/PROG  A\n/MN\n" + "L P[1\n" * 3000,
        "/PROG  A\n/MN\n" + ": \n" * 5000,
        "/PROG  A\n/MN\n/POS\n" + "P[1]{\n" * 4000,
        "/PROG  A\n/MN\n/POS\n" + "P[1]{ GP1: " + "X = " * 9000,
        "/PROG  A\n/MN\n/POS\nP[1]{\n   GP1:\n\tUF : 0" + " " * 200_000,
        HEAD + "   1:L P[1] 100mm/sec FINE " + "TB " * 1200 + ";\n/POS\n/END\n",
        HEAD + "   1:" + " " * 100_000 + "L P[1] 100mm/sec FINE ;\n/POS\n/END\n",
        HEAD + "   1:  IF (" + "(" * 150 + "DI[1]" + ")" * 150 + ") THEN ;\n/POS\n/END\n",
        "/PROG  A\n" * 2000,
        HEAD + "   1:  R[1:" + "a" * 50_000 + "]=1 ;\n/POS\n/END\n",
        HEAD + "   1:  SELECT R[1]=1,CALL A ;\n" + "       =2,CALL B ;\n" * 3000 + "/POS\n/END\n",
    ],
    ids=range(12),
)
def test_hostile_texts_take_no_time(text: str) -> None:
    with cpu_time_below(5.0):
        check(text.encode())


def test_time_grows_with_the_text_and_not_faster() -> None:
    def seconds(count: int) -> float:
        moves = [f"L P[{n}] {n % 7 + 1}mm/sec CNT{n % 100}" for n in range(1, count + 1)]
        text = listing(*moves, positions="".join(POSITION.format(n, n / 8) for n in range(1, count + 1)))
        begun = time.process_time()
        read(text)
        return time.process_time() - begun

    seconds(200)
    small, large = min(seconds(1000) for _ in range(3)), min(seconds(8000) for _ in range(2))
    assert large < 8 * small * 3 + 0.1


# --- one meaning, three ways ----------------------------------------------------------------------------

NUMBERS = ["1", "100", "99.5", "0", "0.0", "000.5", "12.", "1000000000000"]


def test_the_fast_path_gives_what_the_grammar_gives() -> None:
    rng = random.Random(4)
    moves, taken = TpMoveLines(), 0
    for _ in range(3000):
        words = [
            rng.choice("JLA"),
            rng.choice(["P[3]", "P[12:up, left]", "P[0003]"]),
            rng.choice(NUMBERS) + rng.choice(["%", "mm/sec", "cm/min", "inch/min", "deg/sec", "sec", "msec"]),
            rng.choice(["FINE", "CNT0", "CNT55", "CNT100", "CR12.5", "CR0", "CD25", "CR3.50"]),
            *rng.choice([[], ["ACC80"], ["ACC100", "COORD"], ["COORD", "PTH"], ["BREAK"]]),
        ]
        text = rng.choice([" ", "  "]).join(words)
        quick = moves.read(text, 7)
        if quick is None:
            continue
        taken += 1
        (slow,) = instruction_parser().statements(text)
        assert quick == replace(slow, line=7), text
        assert quick.speed.native == slow.speed.native
        assert quick.blend.native == slow.blend.native
    assert taken > 1000


def test_plain_moves_do_not_need_the_grammar() -> None:
    for text in (
        "L P[1] 100mm/sec FINE",
        'J P[2:"home"] 50% CNT100 ACC80',
        "L P[3] WELD_SPEED CNT100 COORD PTH",
        "L P[4] 250mm/sec CR12.5",
    ):
        assert instructions.MOVE_LINE.fullmatch(text)


def test_lines_that_were_seen_before_have_the_same_meaning() -> None:
    text = listing(
        "R[1:a]=R[2]+1", "WAIT DI[1]=ON TIMEOUT,LBL[1]", "LBL[1:x]", "OPEN HAND(1)", "NEW THING[1]"
    )
    first, second = read(text), read(text)
    assert first.routines[0].body == second.routines[0].body
    assert [d.code for d in first.diagnostics] == [d.code for d in second.diagnostics]


def test_the_limits_are_those_that_the_names_obey() -> None:
    assert LIMITS.routine_name == 36
    assert re.fullmatch(LIMITS.names, "PART_7")
    assert not re.fullmatch(LIMITS.names, "7PART")
