"""`olp merge`: points from the robot and logic from the office in one program, and git with it."""

from __future__ import annotations

import gzip
import json
import os
import random
import subprocess
import sys
from pathlib import Path
from xml.etree import ElementTree

import pytest

from bench import merge as made
from bench.merge_oracle import on_its_own
from olp.__main__ import main
from olp.checks.merge.merge import merge_bytes
from olp.core.diagnostic import OlpError
from olp.core.source import decode
from olp.ir.program import Move
from olp.languages.vendor import find_vendor, read

ROOT = Path(__file__).parent.parent
BEFORE = ROOT / "samples/inform/touch-up/before/TOUCH-UP.JBI"
AFTER = ROOT / "samples/inform/touch-up/after/TOUCH-UP.JBI"


def merged(base: bytes, ours: bytes, theirs: bytes, vendor: str = "inform") -> tuple[int, str]:
    found = merge_bytes(vendor, base, ours, theirs)
    return len(found.hunks), found.to_bytes().decode("latin-1")


def test_the_sides_swapped_say_the_same_and_conflicts_have_theirs_first():
    """Made programs changed by two offices: some merges have conflicts, some have none, all have no first side."""
    found = {True: 0, False: 0}
    for language in made.LANGUAGES:
        for seed in range(8):
            choose = random.Random(f"{language} sides {seed}")
            base = made.program(choose)
            made._HIGHEST[0] = len(base.steps)
            sides = [made.office(made.night(base, choose)[0], choose)[0] for _ in range(2)]
            texts = [made.spell(language, one).encode() for one in (base, *sides)]
            one = merge_bytes(language, *texts)
            other = merge_bytes(language, texts[0], texts[2], texts[1])
            assert other.swapped() == one
            assert bool(one.hunks) or one.to_bytes() == other.to_bytes()
            assert [hunk.ours for hunk in one.hunks] == [hunk.theirs for hunk in other.hunks]
            found[bool(one.hunks)] += 1
    assert min(found.values()) > 5


@pytest.mark.parametrize("language", made.LANGUAGES)
def test_a_night_at_the_robot_and_a_day_in_the_office_become_what_both_meant(language):
    for seed in range(6):
        choose = random.Random(f"{language} {seed}")
        base = made.program(choose)
        made._HIGHEST[0] = len(base.steps)
        robot, touched = made.night(base, choose)
        office, gone = made.office(base, choose)
        if touched & gone:
            continue
        want = made.both(base, robot, office, touched)
        texts = [made.spell(language, one).encode() for one in (base, robot, office, want)]
        assert merged(*texts[:3], language) == (0, texts[3].decode())
        assert merged(texts[0], texts[2], texts[1], language) == (0, texts[3].decode())


@pytest.mark.parametrize(
    "path",
    [
        "inform/palletising/PICK.JBI", "tp/handling.ls", "krl/handling.src", "krl/handling.dat", "rapid/handling.mod",
        "val3/handling.dtx", "val3/start.pgx", "as/handling.as", "pdl2/handling.pdl", "urscript/handling.script",
    ],
)  # fmt: skip
def test_whatever_stands_in_a_program_comes_out_as_it_was(path):
    """Taken to pieces and put together: each side changed one line, so that nothing is settled before."""
    data = (ROOT / "samples" / path).read_bytes()
    vendor = path.partition("/")[0]
    end = b"\r\n" if b"\r\n" in data else b"\n"
    lines = data.split(end)
    middle = [
        n for n in range(len(lines) - 1) if b"350" in lines[n] or b"0.35" in lines[n] or b"110.5" in lines[n]
    ]
    places = (middle[0], middle[-1]) if len(middle) > 1 else (len(lines) // 2, len(lines) - 3)
    sides = []
    for place in places:
        side = list(lines)
        side[place] = side[place].replace(b"5", b"6").replace(b"1", b"2") or b" "
        sides.append(side)
    both = list(sides[0])
    both[places[1]] = sides[1][places[1]]
    found = merge_bytes(vendor, data, end.join(sides[0]), end.join(sides[1]))
    assert not found.hunks
    assert found.to_bytes() == end.join(both)


def job(points: list[str], body: list[str], date: str = "2026/01/01 08:00", counts: bool = True) -> bytes:
    rows = [f"C{n:05d}={row}" for n, row in enumerate(points)]
    head = ["/JOB", "//NAME A", "//POS", f"///NPOS {len(rows)},0,0,0,0,0", "///TOOL 0", "///PULSE", *rows]
    return "\r\n".join(
        [*head, "//INST", f"///DATE {date}", "///ATTR SC,RW", "NOP", *body, "END", ""]
    ).encode()


ONE, TWO, THREE, NEW = "1,2,3,4,5,6", "11,12,13,14,15,16", "21,22,23,24,25,26", "91,92,93,94,95,96"
BODY = ["MOVJ C00000 VJ=50.00", "MOVL C00001 V=100.0", "MOVL C00002 V=100.0"]


def test_numbers_are_followed_through_renumbering():
    """Theirs puts a step in front: every number after it is another one; ours moved the last position."""
    ours = job([ONE, TWO, "21,22,23,24,25,29"], BODY, "2026/01/02 03:00")
    theirs = job(
        [NEW, ONE, TWO, THREE],
        ["MOVJ C00000 VJ=10.00", "MOVJ C00001 VJ=50.00", "MOVL C00002 V=100.0", "MOVL C00003 V=300.0"],
    )
    conflicts, text = merged(job([ONE, TWO, THREE], BODY), ours, theirs)
    assert conflicts == 0
    assert "///NPOS 4," in text
    assert f"C00000={NEW}" in text
    assert "C00003=21,22,23,24,25,29" in text
    assert "MOVL C00003 V=300.0" in text
    assert "///DATE 2026/01/02 03:00" in text


def test_both_sides_new_positions_of_one_number_are_two():
    ours = job(
        [ONE, NEW, TWO, THREE], [BODY[0], "MOVL C00001 V=70.0", "MOVL C00002 V=100.0", "MOVL C00003 V=100.0"]
    )
    theirs = job([ONE, TWO, THREE, "7,7,7,7,7,7"], [*BODY, "MOVL C00003 V=80.0"])
    conflicts, text = merged(job([ONE, TWO, THREE], BODY), ours, theirs)
    assert conflicts == 0
    assert f"C00001={NEW}" in text
    assert "MOVL C00001 V=70.0" in text
    assert "C00004=7,7,7,7,7,7" in text
    assert "MOVL C00004 V=80.0" in text


@pytest.mark.parametrize(
    ("ours", "theirs", "what"),
    [
        (job([ONE, "1,1,1,1,1,1", THREE], BODY), job([ONE, "2,2,2,2,2,2", THREE], BODY), "point C00001"),
        (
            job([ONE, "1,1,1,1,1,1", THREE], BODY),
            job([ONE, THREE], [BODY[0], "MOVL C00001 V=100.0"]),
            "point C0000",
        ),
        (
            job([ONE, TWO, THREE], [*BODY[:2], "MOVL C00002 V=1.0"]),
            job([ONE, TWO, THREE], [*BODY[:2], "MOVL C00002 V=2.0"]),
            "statement",
        ),
        (
            job([ONE, TWO, THREE], [*BODY, "TIMER T=1.00"]),
            job([ONE, TWO, THREE], [*BODY, "DOUT OT#(1) ON"]),
            "statement",
        ),
    ],
)
def test_the_same_thing_changed_twice_is_a_conflict_with_both_in_it(ours, theirs, what):
    found = merge_bytes("inform", job([ONE, TWO, THREE], BODY), ours, theirs)
    assert [f"{hunk.what} {hunk.name}".startswith(what) for hunk in found.hunks] == [True]
    shown, old = said(found.to_bytes()), said(job([ONE, TWO, THREE], BODY))
    assert (said(ours) | said(theirs)) - old <= shown


def said(data: bytes) -> set[bytes]:
    """Instructions, and positions without their numbers."""
    lines = data.split(b"\r\n")
    return {
        line.partition(b"=")[2] if line.startswith(b"C0") else line for line in lines if line[:2] != b"//"
    }


def test_a_statement_that_one_side_took_out_and_the_other_put_elsewhere_is_no_silent_choice():
    lines = [
        "DOUT OT#(1) ON",
        "TIMER T=1.00",
        "DOUT OT#(2) ON",
        "DOUT OT#(3) ON",
        "TIMER T=2.00",
        "DOUT OT#(4) ON",
    ]
    ours = [line for line in lines if line != "TIMER T=2.00"]
    theirs = ["TIMER T=2.00", *ours]
    found = merge_bytes("inform", job([], lines), job([], ours), job([], theirs))
    assert len(found.hunks) == 1
    assert found.hunks[0].why == "ours takes it out, theirs has it elsewhere"


_LISTING = """/PROG A
/ATTR
LINE_COUNT = 2;
/MN
{}/POS
P[1]{{
 GP1:
 UF : 0, UT : 1, CONFIG : 'N U T, 0, 0, 0',
 X = 1 mm, Y = 1 mm, Z = 1 mm,
 W = 0 deg, P = 0 deg, R = 0 deg
}};
/END
"""
_JOB = """/JOB
//NAME A
//POS
///NPOS 1,0,0,0,0,0
///TOOL 0
///PULSE
C00000=1,2,3,4,5,6
//INST
///DATE 2026/01/01 01:01
///ATTR SC,RW
///GROUP1 RB1
NOP
{}
END
"""
_MODULE = "MODULE M\nPROC main()\n{}\nENDPROC\nENDMODULE\n"
_FORM = (
    ";FOLD LIN P2{0}Vel={1} m/s CPDAT1 Tool[1] Base[1];%{{PE}}%R 8.3,%MKUKATPBASIS,%CMOVE,%VLIN,%P 1:LIN, "
    "2:P2, 3:{2}, 5:{1}, 7:CPDAT1"
)
_SPEED_AND_ZONE = [
    ("rapid", _MODULE, "MoveL pA, v100, fine, tool0;", "MoveL pA, v200, fine, tool0;", "MoveL pA, v100, z10, tool0;"),
    ("rapid", _MODULE, "MoveC p, q, v9, z5, t;", "MoveC p, q, v5\\T:=3, z5, t;", "MoveC p, q, v9, z1\\Inpos:=x, t;"),
    ("urscript", "def a():\n  {}\nend\n", "movel(p1, v=0.2)", "movel(p1, v=0.5)", "movel(p1, v=0.2, r=0.01)"),
    ("urscript", "def a():\n  {}\nend\n", "movej(q, 1, 2, 0, 0)", "movej(q, 1, 3, 0, 0)", "movej(q, 1, 2, 0, 0.1)"),
    ("inform", _JOB, "MOVL C00000 V=235.0 PL=4", "MOVL C00000 V=100.0 PL=4", "MOVL C00000 V=235.0 PL=2"),
    ("tp", _LISTING, "   1:J P[1] 9% FINE ;\n", "   1:J P[1] 8% FINE ;\n", "   1:J P[1] 9% CNT50 ;\n"),
    ("pdl2", "PROGRAM a\nBEGIN\n{} TO p WITH $LIN_SPD = {}\nEND a\n", "MOVE 2", "MOVE 4", "MOVEFLY 2"),
]  # fmt: skip


@pytest.mark.parametrize(("language", "frame", "base", "ours", "theirs"), _SPEED_AND_ZONE)
def test_one_side_slows_a_move_and_the_other_rounds_it(language, frame, base, ours, theirs):
    """The reader, which knows nothing of merges, finds the speed of the one and the zone of the other."""
    texts = [
        frame.format(*(one.split() if frame.count("{}") > 1 else [one])).encode()
        for one in (base, ours, theirs)
    ]
    merged = merge_bytes(language, *texts)
    assert not merged.hunks
    line, by_ours, by_theirs = merged.shared[0]
    assert (by_ours, by_theirs) == (("speed",), ("zone",))
    suffix = made._SUFFIX[language]
    moves = []
    for data in (*texts, merged.to_bytes()):
        program = find_vendor(language).read(decode(data, f"a{suffix}"))
        moves.append(next(one for one in program.statements() if isinstance(one, Move)))
    assert moves[3].line == line == moves[0].line
    assert moves[3].speed == moves[1].speed
    assert (moves[3].blend, moves[3].targets) == (moves[2].blend, moves[0].targets)
    assert (moves[0].speed, moves[0].blend) != (moves[3].speed, moves[3].blend)


@pytest.mark.parametrize(
    ("language", "base", "ours", "theirs", "expected"),
    [
        ("krl", "DEF a()\nLIN XP1\nEND\n", "LIN XP2", "LIN XP1 C_DIS", "LIN XP2 C_DIS"),
        ("val3", "begin\nmovel(p,t,m)\nend\n", "movel(p,t,slow)", "movel(q,t,m)", "movel(q,t,slow)"),
        ("krl", "DEFDAT a\nDECL PDAT PPDAT1={VEL 100.0,ACC 100.0,APO_DIST 100.0}\nENDDAT\n",
         "DECL PDAT PPDAT1={VEL 100.0,ACC 50.0,APO_DIST 100.0}", "DECL PDAT PPDAT1={VEL 100.0,ACC 100.0,APO_DIST 10.0}",
         "DECL PDAT PPDAT1={VEL 100.0,ACC 50.0,APO_DIST 10.0}"),
        ("krl", f"DEF a()\n{_FORM.format(' ', '0.2', '')}\nEND\n", _FORM.format(" CONT ", "0.2", "C_DIS"),
         _FORM.format(" ", "0.5", ""), _FORM.format(" CONT ", "0.5", "C_DIS")),
        ("rapid", _MODULE.format('Open "A:" , dev;'), 'Open "B:" , dev;', 'Open "A:",dev;', 'Open "B:" , dev;'),
        ("rapid", _MODULE.format("Grip 1, 2, off;"), "Grip 3, 2, off;", "Grip 3, 2, on;", "Grip 3, 2, on;"),
    ],
)  # fmt: skip
def test_both_changes_of_one_statement_stand_where_they_are_apart(language, base, ours, theirs, expected):
    old = base.splitlines()[-2 if base.count("\n") == 3 else 2]
    texts = [base.replace(old, one).encode() for one in (old, ours, theirs, expected)]
    for sides in (texts[1:3], texts[2:0:-1]):
        found = merge_bytes(language, texts[0], *sides)
        assert not found.hunks
        assert found.to_bytes() == texts[3]
        assert len(found.shared) == ('"' not in old)  # what one side only spells otherwise is no change


@pytest.mark.parametrize(
    ("ours", "theirs"),
    [
        ("MoveL pB, v100, fine, tool0;", "MoveL pA, v100, fine, tool1;"),  # a place that neither means
        ("MoveJ pA, v100, fine, tool0;", "MoveL pA, v200, fine, tool0;"),
        ("MoveL pA, v300, fine, tool0;", "MoveL pA, v200, z10, tool0;"),
        ("MoveL pA, v100, fine, tool0; x := 1;", "MoveL pA, v100, z10, tool0;"),
    ],
)
def test_changes_of_a_move_that_are_not_apart_stay_a_conflict(ours, theirs):
    base = _MODULE.format("MoveL pA, v100, fine, tool0;")
    texts = [base, *(_MODULE.format(one) for one in (ours, theirs))]
    assert merged(*(one.encode() for one in texts), "rapid")[0] == 1


def test_a_number_that_both_changed_is_no_part_of_another():
    texts = [_MODULE.format(f"WaitTime {one};").encode() for one in ("10.0", "12.0", "12.5")]
    assert merged(*texts, "rapid")[0] == 1


def test_a_number_beyond_all_lines_that_one_side_writes_stays():
    base = _LISTING.format("   1:L P[1] 100mm/sec FINE ;\n   2:  DO[1]=ON ;\n")
    theirs = base.replace("   2:  DO[1]=ON ;\n", "   2:  DO[1]=ON ;\n  100:\n  9999:\n")
    ours = base.replace("   1:L", "   1:  WAIT .5(sec) ;\n   1:L")  # put in by hand
    expected = theirs.replace("   1:L", "   1:  WAIT .5(sec) ;\n   2:L").replace("   2:  DO", "   3:  DO")
    expected = expected.replace("LINE_COUNT = 2", "LINE_COUNT = 3")
    assert merged(*(one.encode() for one in (base, ours, theirs)), "tp") == (0, expected)


def test_numbers_of_lines_that_nobody_counts_stay():
    base = _LISTING.format("   1:L P[1] 100mm/sec FINE ;\n   2:  DO[1]=ON ;\n  100:\n  9999:\n")
    ours = base.replace("X = 1 mm", "X = 2 mm")
    theirs = base.replace("   2:  DO[1]", "   2:  WAIT .5(sec) ;\n   3:  DO[1]")
    expected = theirs.replace("X = 1 mm", "X = 2 mm").replace("LINE_COUNT = 2", "LINE_COUNT = 3")
    assert merged(*(one.encode() for one in (base, ours, theirs)), "tp") == (0, expected)


@pytest.mark.parametrize(
    ("language", "text"),
    [
        ("rapid", "MODULE M\nPERS num nOld:=[5,6];\nCONST num n:=1;\nENDMODULE\n"),
        (
            "val3",
            '<Database>\n<Datas>\n<Data name="nOld" type="num">\n<Value key="0" value="5" />\n</Data>\n</Datas>\n',
        ),
        ("krl", "DEFDAT a\nDECL INT nOld=5\nDECL INT other=6\nENDDAT\n"),
    ],
)
def test_data_that_both_sides_call_otherwise_are_a_conflict(language, text):
    sides = [text.replace("nOld", one).encode() for one in ("nOld", "nMine", "nYours")]
    found = merge_bytes(language, *sides)
    assert [hunk.why for hunk in found.hunks] == ["both give it another name"]
    assert merged(sides[0], sides[1], sides[1], language) == (0, sides[1].decode())


def test_a_comment_and_the_words_beside_it_are_two_things():
    base = b"MODULE M\n  PROC main()\n    MoveL p1,v100,fine,tool0; ! near\n  ENDPROC\nENDMODULE\n"
    ours = base.replace(b"! near", b"! above the part")
    theirs = base.replace(b"v100", b"v200").replace(b"    Move", b"      Move")
    conflicts, text = merged(base, ours, theirs, "rapid")
    assert (conflicts, text.splitlines()[2]) == (0, "      MoveL p1,v200,fine,tool0; ! above the part")


def test_how_a_definition_is_written_and_what_it_says_are_two_things():
    base = b"DEFDAT D\r\nGLOBAL E6POS P={X 1,Y 2}\r\nINT N = 3\r\nENDDAT\r\n"
    ours = base.replace(b"GLOBAL E6POS", b"E6POS").replace(b"INT N = 3\r\n", b"")
    theirs = (
        base.replace(b"GLOBAL E6POS", b"DECL GLOBAL E6POS").replace(b"X 1", b"X 7").replace(b"N = 3", b"N=3")
    )
    assert merged(base, ours, theirs, "krl") == (0, "DEFDAT D\r\nE6POS P={X 7,Y 2}\r\nENDDAT\r\n")


_NAMED = b"DEF A()\r\nrows[active].n = 1\r\nrows[active].m = 2\r\nrows[active].k = 3\r\nLIN XP1\r\nLIN XP1\r\nEND\r\n"


def test_another_name_for_a_variable_is_one_change_and_is_told():
    ours = _NAMED.replace(b"active", b"Current")
    theirs = _NAMED.replace(b"= 2", b"= 7").replace(b"rows", b"Lines").replace(b"LIN XP1\r\nEND", b"END")
    found = merge_bytes("krl", _NAMED, ours, theirs)
    assert (found.hunks, found.to_bytes()) == ((), theirs.replace(b"active", b"Current"))
    assert found.renamed == {"ours": (("active", "Current"),), "theirs": (("rows", "Lines"),)}
    assert found.swapped() == merge_bytes("krl", _NAMED, theirs, ours)


_KRL = b"DEF A()\r\n{}\r\nWAIT SEC 1\r\n{}\r\nEND\r\n"
_RAPID = b"MODULE M\r\nPROC main()\r\n{}\r\nstop;\r\n{}\r\nENDPROC\r\nENDMODULE\r\n"
_UR = b"def p():\r\n  {}\r\n  sync()\r\n  {}\r\nend\r\n"


@pytest.mark.parametrize(
    ("frame", "one", "other", "old", "new"),
    [
        (_KRL, b"LIN XP1", b"LIN XP1 C_DIS", b"XP1", b"XP7"),  # goes elsewhere
        (_KRL, b"LIN there", b"LIN there C_DIS", b"there", b"home"),
        (_KRL, b"LIN far", b"LIN far C_DIS", b"LIN", b"PTP"),
        (_KRL, b"$VEL.CP=0.1", b"$VEL.CP=0.2", b"$VEL", b"$ACC"),
        (_KRL, b"here.X=1", b"here.X=2", b".X", b".Y"),
        (_KRL, b"flag=TRUE", b"$OUT[1]=TRUE", b"TRUE", b"FALSE"),
        (_RAPID, b"MoveL [[1,2,3]],v10,fine,tool0;", b"MoveL [[4,5,6]],v10,fine,tool0;", b"MoveL", b"MoveJ"),
        (_RAPID, b"MoveL p,v10\\Vmax:=1,fine,tool0;", b"MoveL q,v10\\Vmax:=1,fine,tool0;", b"Vmax", b"Time"),
        (_RAPID, b"data:=[TRUE,[1,2]];", b"more:=[TRUE,[3,4]];", b"TRUE", b"FALSE"),
        (_UR, b"movel(here, aaaa=1.2)", b"movel(there, aaaa=1.2)", b"aaaa", b"tttt"),
    ],
)
def test_words_of_a_language_targets_and_arguments_have_no_other_name(frame, one, other, old, new):
    """Both sides changed the second statement."""
    vendor = {_KRL: "krl", _RAPID: "rapid", _UR: "urscript"}[frame]
    base = frame.replace(b"{}", one, 1).replace(b"{}", other)
    last = other.replace(b"1", b"9").replace(b"2", b"8").replace(b"C_DIS", b"C_VEL").replace(b"q,", b"r,")
    last = last.replace(b"[4", b"[7").replace(b"3,4", b"5,6").replace(b"there", b"gate")
    theirs = frame.replace(b"{}", one, 1).replace(b"{}", last)
    assert base != theirs
    found = merge_bytes(vendor, base, base.replace(old, new), theirs)
    assert (len(found.hunks), dict(found.renamed)) == (1, {})


@pytest.mark.parametrize(
    ("ours", "theirs"),
    [
        (_NAMED.replace(b"active", b"latest"), _NAMED.replace(b"active", b"others")),  # who is right?
        # The other side says the name in a statement of its own, and may mean it.
        (_NAMED.replace(b"active", b"latest"), _NAMED.replace(b"= 2", b"= 7\r\nrows[active].l = 4")),
        (
            _NAMED.replace(b"active", b"latest"),
            _NAMED.replace(b"= 2", b"= latest"),
        ),  # it has one of that name
        # It takes out a statement that the first side changed.
        (_NAMED.replace(b"active", b"latest"), _NAMED.replace(b"rows[active].m = 2\r\n", b"")),
    ],
)
def test_what_the_other_side_may_mean_otherwise_keeps_its_name(ours, theirs):
    found = merge_bytes("krl", _NAMED, ours, theirs)
    assert found.hunks
    assert not found.renamed


def test_numbers_and_letters_that_mean_the_same_are_no_change():
    base = b"DEF A()\r\nPTP {X 1,Y 0,Z 0.50} C_DIS\r\nEND\r\n"
    ours = base.replace(b"PTP {X 1,Y 0,Z 0.50} C_DIS", b"ptp {X 1.0, Y -0.0, Z 0.5} C_Dis")
    assert merged(base, ours, base.replace(b"0.50", b"0.75"), "krl") == (
        0,
        base.replace(b"0.50", b"0.75").decode(),
    )
    conflicts, _ = merged(base, ours.replace(b"1.0", b"1.1"), base.replace(b"0.50", b"0.75"), "krl")
    assert conflicts == 1
    base = b"DEF A()\r\ni = 5 / 2\r\nEND\r\n"  # divides whole numbers
    assert merged(base, base.replace(b"5 / 2", b"5 / 2.0"), base.replace(b"5 / 2", b"5 / 3"), "krl")[0] == 1


def test_what_one_side_put_in_may_be_part_of_what_the_other_did():
    base = b"DEF A()\r\nPTP XA\r\nPTP XB\r\nEND\r\n"
    more = base.replace(b"PTP XB", b"$OUT[1]=TRUE\r\nWAIT SEC 1\r\n$OUT[1]=FALSE\r\nPTP XB")
    less = more.replace(b"WAIT SEC 1\r\n", b"")
    assert merged(base, less, more, "krl") == merged(base, more, less, "krl") == (0, more.decode())
    assert merged(base, less, more.replace(b"1]=FALSE", b"2]=TRUE"), "krl")[0] == 1


def test_what_is_declared_in_one_row_and_has_its_value_in_another_is_two_things():
    base = b"DEFDAT D\r\nE6POS XA\r\nXA={X 1,Y 2}\r\nINT N[2]\r\nENDDAT\r\n"
    ours = base.replace(b"XA\r\n", b"XA\r\nE6POS XB\r\n").replace(b"X 1", b"X 4")
    theirs = base.replace(b"XA\r\n", b"XA\r\nFRAME F\r\n").replace(b"N[2]", b"N[3]")
    conflicts, text = merged(base, ours, theirs, "krl")
    assert conflicts == 0
    assert sorted(text.split("\r\n")[1:-2]) == ["E6POS XA", "E6POS XB", "FRAME F", "INT N[3]", "XA={X 4,Y 2}"]


def test_remarks_of_both_sides_are_kept_and_folds_are_no_remarks():
    base = b"DEF A()\r\n; here\r\nPTP HOME\r\nEND\r\n"
    ours, theirs = base.replace(b"; here", b"; above the part"), base.replace(b"; here", b"; 20 mm above")
    conflicts, text = merged(base, ours, theirs, "krl")
    assert conflicts == 0
    assert sorted(text.splitlines()[1:3]) == ["; 20 mm above", "; above the part"]
    sides = [side.replace(b"; ", b";FOLD ") for side in (base, ours, theirs)]
    assert merged(*sides, "krl")[0] == 1


def test_a_byte_order_mark_and_records_of_the_header_are_no_change_of_the_program():
    base = b"DEF A()\r\nPTP HOME\r\nEND\r\n"
    ours = b"\xef\xbb\xbf&ACCESS RVP\r\n&REL 3\r\n" + base
    theirs = b"&ACCESS RVP\r\n&REL 12\r\n" + base.replace(b"HOME", b"P1")
    conflicts, text = merged(base, ours, theirs, "krl")
    assert (conflicts, text.encode("latin-1")) == (
        0, b"\xef\xbb\xbf&ACCESS RVP\r\n&REL 12\r\nDEF A()\r\nPTP P1\r\nEND\r\n",
    )  # fmt: skip


def test_what_the_controller_writes_into_the_header_is_that_of_the_side_saved_last():
    base = b"&ACCESS RVP\r\n&REL 3\r\n&PARAM DISKPATH = KRC:\\R1\r\nDEF A()\r\nPTP HOME\r\nEND\r\n"
    ours = base.replace(b"RVP", b"RVO1").replace(b"REL 3", b"REL 12").replace(b"R1\r", b"R1\\A\r")
    theirs = base.replace(b"RVP", b"RV").replace(b"REL 3", b"REL 7").replace(b"R1\r", b"R1\\Z\r")
    theirs = theirs.replace(b"HOME", b"P1")
    assert merged(base, ours, theirs, "krl") == (0, ours.replace(b"HOME", b"P1").decode())
    assert merged(base, theirs, ours, "krl") == (0, ours.replace(b"HOME", b"P1").decode())


def test_what_polyscope_counts_and_names_anew_is_no_change():
    def program(tail: str, first: int, value: str, speed: str) -> bytes:
        name = f"Step_Counter_Thread_{tail}_5fc2_42c0_9e0d_ac41aa524d58"
        lines = [
            "def p():", f"  thread {name}():", "    while (True):", "      sync()", "    end", "  end",
            f"  run {name}()",
            f"  global a=p[{value}, 0, 0, 0, 0, 0]", f'  $ {first} "MoveJ"', f"  movej(a, v={speed})",
            f'  $ {first + 1} "Wait"', "  sleep(1)", "  def f():", "    global a=p[0, 0, 0, 0, 0, 0]",
            "  end", "end", "",
        ]  # fmt: skip
        return "\n".join(lines).encode()

    base, ours, theirs = (
        program("cf7c1445", 3, "0.1", "1"),
        program("0badcafe", 5, "0.2", "1"),
        program("89b7778c", 8, "0.1", "2"),
    )
    conflicts, text = merged(base, ours, theirs, "urscript")
    assert conflicts == 0
    assert text.encode() in [program("0badcafe", 8, "0.2", "2"), program("0badcafe", 5, "0.2", "2")]


def test_data_that_one_side_took_out_stay_where_the_other_begins_to_use_them():
    base = b"MODULE M\n  CONST num a:=1;\n  CONST num b:=2;\n  PROC main()\n    x:=1;\n  ENDPROC\nENDMODULE\n"
    ours = base.replace(b"  CONST num b:=2;\n", b"")
    theirs = base.replace(b"    x:=1;\n", b"    x:=1;\n    y:=b;\n")
    conflicts, text = merged(base, ours, theirs, "rapid")
    assert conflicts == 0
    assert "CONST num b:=2;" in text
    assert "y:=b;" in text


def test_data_go_that_the_other_side_only_says_in_another_way_than_before():
    """Ours takes b from another module, also in a value; theirs said b before, and says it once more."""
    base = b"MODULE M\n  VAR num b:=2;\n  PROC main()\n    x:=b;\n    z:=1;\n  ENDPROC\nENDMODULE\n"
    ours = base.replace(b"  VAR num b:=2;\n", b"  VAR num c:=b;\n").replace(b"    x:=b;\n", b"    x:=c;\n")
    theirs = base.replace(b"    z:=1;\n", b"    z:=1;\n    y:=b+1;\n")
    conflicts, text = merged(base, ours, theirs, "rapid")
    assert conflicts == 0
    assert "VAR num b:=2;" not in text
    assert "VAR num c:=b;" in text
    assert "y:=b+1;" in text


@pytest.mark.parametrize(
    ("kind", "ours", "theirs", "expected"),
    [
        ("///PULSE", ("1,2,", "1,9,"), ("TOOL 0", "TOOL 3"), ["///TOOL 3", "C00000=1,9,3,4,5,6"]),
        ("///PULSE", ("TOOL 0", "TOOL 5"), ("TOOL 0", "TOOL 3"), None),
        ("///POSTYPE BASE\r\n///RECTAN", ("1,2,", "1,9,"), ("TOOL 0", "TOOL 3"), None),
    ],
)
def test_pulses_say_where_the_arm_goes_whatever_tool_it_holds(kind, ours, theirs, expected):
    base = job([ONE, TWO], BODY[:2]).replace(b"///PULSE", kind.encode())
    sides = [base.replace(old.encode(), new.encode(), 1) for old, new in (ours, theirs)]
    conflicts, text = merged(base, *sides)
    assert (conflicts > 0) is (expected is None)
    assert all(one in text.split("\r\n") for one in expected or ())
    told = merge_bytes("inform", base, *sides).taken
    assert expected is None or ("C00000" in told["ours"].points and "C00000" in told["theirs"].points)


def listing(numbers: list[int], moves: list[str], places: dict[int, str], kind: str = "J") -> bytes:
    """A program of TP: the moves take the numbers in order; `places`: angles of joints, and a tool behind a bar."""
    lines = [
        f"{n:4d}:{move.replace('#', str(number))}    ;"
        for n, (number, move) in enumerate(zip(numbers, moves, strict=True), 1)
    ]
    names = ("J1", "J2") if kind == "J" else ("X ", "Y ")
    held = []
    for number, text in places.items():
        place, _, tool = text.partition("|")
        values = ",\t".join(
            f"{name}= {value} deg" for name, value in zip(names, place.split(","), strict=True)
        )
        held += [f"P[{number}]{{", "   GP1:", f"\tUF : 0, UT : {tool or 1},\t", f"\t{values}", "};"]
    head = ["/PROG  A", "/ATTR", f"LINE_COUNT\t= {len(lines)};", "/MN"]
    return "\r\n".join([*head, *lines, "/POS", *held, "/END", ""]).encode()


@pytest.mark.parametrize(("kind", "clean"), [("J", True), ("X", False)])
def test_angles_of_joints_say_where_the_arm_goes_whatever_tool_it_holds(kind, clean):
    places = {1: "10,20", 2: "30,40"}
    moves = ["L P[#] 100mm/sec FINE", "L P[#] 200mm/sec FINE"]
    base = listing([1, 2], moves, places, kind)
    ours = listing([1, 2], moves, {**places, 2: "30,45"}, kind)
    theirs = listing([1, 2], moves, {1: "10,20|3", 2: "30,40|3"}, kind)
    conflicts, text = merged(base, ours, theirs, "tp")
    assert (conflicts == 0) is clean
    if clean:
        assert text.encode() == listing([1, 2], moves, {1: "10,20|3", 2: "30,45|3"}, kind)


def test_a_point_is_found_again_by_its_place_where_its_move_is_another_one():
    """Theirs puts a step in front of a straight move and makes it a joint move; ours touched its point up."""
    ours = job([ONE, "11,12,13,14,15,19"], BODY[:2], "2026/01/02 03:00")
    theirs = job([ONE, NEW, TWO], [BODY[0], "MOVL C00001 V=100.0", "MOVJ C00002 VJ=0.50 PL=2"])
    conflicts, text = merged(job([ONE, TWO], BODY[:2]), ours, theirs)
    assert conflicts == 0
    assert text.encode() == job(
        [ONE, NEW, "11,12,13,14,15,19"],
        [BODY[0], "MOVL C00001 V=100.0", "MOVJ C00002 VJ=0.50 PL=2"],
        "2026/01/02 03:00",
    )


def test_numbers_stay_where_one_side_does_not_count_from_the_first_any_more():
    places = {1: "10,20", 2: "30,40", 3: "50,60"}
    moves = ["L P[#] 100mm/sec FINE", "L P[#] 200mm/sec FINE", "L P[#] 300mm/sec FINE"]
    base = listing([1, 2, 3], moves, places)
    ours = listing([1, 2, 3], moves, {**places, 3: "50,66"})
    theirs = listing([2, 3], moves[1:], {2: "30,40", 3: "50,60"})
    conflicts, text = merged(base, ours, theirs, "tp")
    assert conflicts == 0
    assert text.encode() == listing([2, 3], moves[1:], {2: "30,40", 3: "50,66"})


def collection(name: str, values: dict[str, int]) -> bytes:
    rows = "".join(f'      <Value key="{key}" value="{value}" />\n' for key, value in values.items())
    data = f'    <Data name="{name}" type="num">\n{rows}    </Data>\n' if values else ""
    return (
        f'<Database>\n  <Datas>\n    <Data name="a" type="num" />\n{data}  </Datas>\n</Database>\n'.encode()
    )


@pytest.mark.parametrize(
    ("ours", "theirs", "clean"),
    [
        (("g", {"A": 1, "B": 2}), ("n", {"A": 1, "B": 2, "C": 3}), False),
        (("g", {"A": 1, "B": 2, "C": 3, "D": 4}), ("n", {"A": 1, "B": 2, "C": 3}), False),
        (("g", {"A": 1, "B": 2, "C": 3, "D": 4}), ("g", {}), False),
        (("g", {"A": 1, "B": 2}), ("g", {}), True),
        (("g", {"A": 1, "B": 2, "C": 3}), ("n", {"A": 1, "B": 2, "C": 3}), True),
    ],
)
def test_data_that_one_side_calls_otherwise_and_the_other_changes_are_chosen_whole(ours, theirs, clean):
    """A value alone, outside of its data, would be no program; one that the other name still has would come back."""
    base, *sides = (collection(*one) for one in (("g", {"A": 1, "B": 2, "C": 3}), ours, theirs))
    conflicts, text = merged(base, *sides, "val3")
    assert conflicts == (0 if clean else 1)
    if clean:
        assert text.encode() == sides[1]
    else:
        assert text.index("<<<<<<<") < text.index('<Data name="g"') < text.index("=======")


def test_line_ends_of_one_side_are_no_change_of_every_line():
    base = job([ONE, TWO, THREE], BODY)
    ours = base.replace(b"\r\n", b"\n")
    theirs = base.replace(b"V=100.0", b"V=200.0", 1)
    conflicts, text = merged(base, ours, theirs)
    assert conflicts == 0
    assert "\r" not in text
    assert "MOVL C00001 V=200.0\n" in text


def run(folder: Path, *words: object) -> tuple[int, str]:
    environment = os.environ | {
        "PYTHONPATH": str(ROOT),
        "GIT_CONFIG_GLOBAL": os.devnull,
        "GIT_EDITOR": "true",
    }
    done = subprocess.run(
        [*map(str, words)], cwd=folder, capture_output=True, text=True, check=False, env=environment
    )
    return done.returncode, done.stdout + done.stderr


def test_a_merge_loads_nothing_that_only_reports_need(tmp_path):
    """Each of these costs a hundredth of a second or more."""
    text = job([ONE, TWO, THREE], BODY)
    sides = text, text.replace(b"31", b"32"), text.replace(b"V=100.0", b"V=90.0")
    paths = [tmp_path / f"{name}.jbi" for name in ("base", "ours", "theirs")]
    for path, data in zip(paths, sides, strict=True):
        path.write_bytes(data)
    words = ["merge", *map(str, paths), "-o", str(tmp_path / "out.jbi")]
    heavy = [
        "numpy.ma",
        "secrets",
        "tempfile",
        "olp.reports.batch",
        "olp.reports.formats",
        "olp.robots.backup",
    ]
    code = f"import sys; from olp.__main__ import main; main({words!r}); print(set({heavy!r}) & set(sys.modules))"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert "time" in done.stdout
    assert done.stdout.splitlines()[-1] == "set()"


def test_times_conflicts_and_statuses_are_told(tmp_path, capsys):
    ours, theirs = tmp_path / "ours.jbi", tmp_path / "theirs.jbi"
    ours.write_bytes(BEFORE.read_bytes().replace(b"V=235.0 PL=0", b"V=300.0 PL=0", 1))
    theirs.write_bytes(BEFORE.read_bytes().replace(b"V=187.0", b"V=150.0"))
    (tmp_path / "olp.toml").write_text('robot = "yaskawa/ma2010"\n[[budget]]\nname = "cell"\nlimit_s = 1.0\n')
    out = tmp_path / "out.jbi"
    words = ["merge", str(BEFORE), str(ours), str(theirs), "-o", str(out), "--json"]
    assert main(words) == 0
    told = json.loads(capsys.readouterr().out)
    assert told["clean"]
    assert [one["name"] for one in told["budgets"]] == ["cell"]
    assert told["seconds"]["merged"] == pytest.approx(read_total(out), abs=1e-9)
    theirs.write_bytes(BEFORE.read_bytes().replace(b"V=235.0 PL=0", b"V=100.0 PL=0", 1))
    assert main(words) == 1
    hunk = json.loads(capsys.readouterr().out)["conflicts"][0]
    assert hunk["ours_s"] < hunk["theirs_s"]
    assert b"<<<<<<< ours (" in out.read_bytes()
    assert main(["merge", str(out), str(ours), str(theirs), "-o", str(tmp_path / "again")]) == 2
    assert "error[U021]" in capsys.readouterr().err
    assert main(["merge", str(BEFORE), str(ours), str(theirs), "-o", str(ours)]) == 2
    assert "error[C006]" in capsys.readouterr().err


def read_total(path: Path) -> float:
    from olp.reports.batch import Job, time_program

    return time_program(read(path), Job()).total_s


def test_git_merges_rebases_and_picks_with_it(tmp_path, monkeypatch):
    def git(*words: str) -> tuple[int, str]:
        return run(tmp_path, "git", "-c", "user.name=a", "-c", "user.email=a@b", *words)

    def commit(data: bytes, branch: str) -> None:
        program.write_bytes(data)
        assert git("commit", "-qam", branch)[0] == 0

    program = tmp_path / "A.JBI"
    other = tmp_path / "notes.ls"  # of no language: git's own merge
    program.write_bytes(job([ONE, TWO, THREE], BODY))
    other.write_text("one\ntwo\nthree\nfour\nfive\n")
    assert git("init", "-qb", "main")[0] == 0
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("shutil.which", lambda name: None)
    assert main(["git", "install"]) == 0
    driver = git("config", "merge.olp.driver")[1].strip()
    assert git("config", "merge.olp.driver", driver.replace("--driver", "--no-time --driver"))[0] == 0
    git("add", ".")
    commit(program.read_bytes(), "start")
    git("checkout", "-qb", "robot")
    other.write_text("ONE\ntwo\nthree\nfour\nfive\n")
    commit(job([ONE, "12,12,13,14,15,16", THREE], BODY, "2026/01/03 01:00"), "night")
    for branch in ("office", "again", "picked"):
        git("checkout", "-qb", branch, "main")
        if branch == "office":
            other.write_text("one\ntwo\nthree\nfour\nFIVE\n")
        commit(
            job([ONE, TWO, THREE], [BODY[0], "MOVL C00001 V=900.0", *BODY[2:]], "2026/01/02 01:00"), "logic"
        )
    want = job(
        [ONE, "12,12,13,14,15,16", THREE], [BODY[0], "MOVL C00001 V=900.0", *BODY[2:]], "2026/01/03 01:00"
    )
    for branch, words in (
        ("office", ["merge", "robot"]),
        ("again", ["rebase", "robot"]),
        ("picked", ["cherry-pick", "robot"]),
    ):
        git("checkout", "-q", branch)
        assert git(*words)[0] == 0
        assert program.read_bytes() == want
        assert other.read_text().endswith("FIVE\n") == (branch == "office")
    git("checkout", "-qb", "else", "main")
    commit(job([ONE, "99,12,13,14,15,16", THREE], BODY), "another night")
    assert git("merge", "robot")[0] == 1
    assert git("ls-files", "-u")[1].count("A.JBI") == 3
    assert b"point C00001: both change it" in program.read_bytes()
    shown = git("diff", "main", "office", "--", "A.JBI")[1]
    assert "+MOVL C<12,12,13,14,15,16> V=900.0" in shown
    assert "DATE" not in shown
    assert main(["git", "install", "--remove"]) == 0
    assert not (tmp_path / ".gitattributes").exists()


def test_git_merges_in_folders_with_blanks_and_letters_of_all_kinds_and_what_olp_cannot_merge(
    tmp_path, monkeypatch
):
    def git(*words: str) -> tuple[int, str]:
        return run(tmp_path, "git", "-c", "user.name=a", "-c", "user.email=a@b", *words)

    def commit(branch: str, start: str, **files: bytes) -> None:
        assert git("checkout", "-qb", branch, start)[0] == 0
        for name, data in files.items():
            (folder / f"{name} größer $1'.JBI").write_bytes(data)
        git("add", ".")
        assert git("commit", "-qm", branch)[0] == 0

    folder = tmp_path / "Zelle 1; ü"
    folder.mkdir()
    assert git("init", "-qb", "main")[0] == 0
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("shutil.which", lambda name: None)
    assert main(["git", "install"]) == 0
    driver = git("config", "merge.olp.driver")[1].strip()
    assert git("config", "merge.olp.driver", driver.replace("--driver", "--no-time --driver"))[0] == 0
    git("add", ".")
    assert git("commit", "-qm", "start")[0] == 0
    old = job([ONE, TWO, THREE], BODY)
    night = job([ONE, "12,12,13,14,15,16", THREE], BODY, "2026/01/03 01:00")
    marked = old.replace(b"END", b"<<<<<<< ours\r\n=======\r\n>>>>>>> theirs\r\nEND")
    commit("base", "main", A=old, B=old)
    commit("robot", "base", A=night, B=night, C=old)
    commit("office", "base", A=job([ONE, TWO, THREE], [*BODY, "TIMER T=1.00"]), B=marked, C=night)
    status, told = git("merge", "robot")
    assert status == 1
    assert (folder / "A größer $1'.JBI").read_bytes() == job(
        [ONE, "12,12,13,14,15,16", THREE], [*BODY, "TIMER T=1.00"], "2026/01/03 01:00"
    )
    assert "error[U021]" in told
    assert b"12,12,13" in (folder / "B größer $1'.JBI").read_bytes()  # git's own merge
    shown = (folder / "C größer $1'.JBI").read_bytes()  # new on both sides
    assert shown.count(b"<<<<<<< ") == shown.count(b">>>>>>> ") > 0
    waiting = git("-c", "core.quotePath=false", "status", "--porcelain")[1].splitlines()
    assert sorted(row[:2] for row in waiting) == ["AA", "M ", "M "]
    assert not list(folder.glob(".merge_file*"))


def test_without_olp_git_merges_as_text_and_marks_what_conflicts(tmp_path, monkeypatch):
    """A desktop may start git with another PATH, and olp may be gone: ours must not stay as if it were the merge."""

    def git(*words: str) -> tuple[int, str]:
        return run(tmp_path, "git", "-c", "user.name=a", "-c", "user.email=a@b", *words)

    tool = tmp_path / "my tools" / "olp"
    tool.parent.mkdir()
    tool.write_text("#!/no/such/interpreter\n")
    tool.chmod(0o755)
    assert git("init", "-qb", "main")[0] == 0
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("shutil.which", lambda name: str(tool))
    assert main(["git", "install"]) == 0
    assert f"'{tool}' git text" in git("config", "diff.olp.textconv")[1]
    program = tmp_path / "A.JBI"
    for branch, start, body in (
        ("base", "main", BODY),
        ("ours", "base", [BODY[0], "MOVL C00001 V=200.0", BODY[2]]),
        ("theirs", "base", [BODY[0], "MOVL C00001 V=300.0", BODY[2]]),
        ("other", "base", [*BODY, "TIMER T=1.00"]),
    ):
        git("checkout", "-qb", branch, *([start] if start != "main" else []))
        program.write_bytes(job([ONE, TWO, THREE], body))
        git("add", "A.JBI", ".gitattributes")
        assert git("commit", "-qm", branch)[0] == 0
    assert git("merge", "theirs")[0] == 0  # nothing to merge but one line and a new one
    git("reset", "-q", "--hard", "HEAD~1")
    git("checkout", "-q", "ours")
    assert git("merge", "theirs")[0] == 1
    assert program.read_bytes().count(b"<<<<<<< ours") == 1
    assert "+MOVL C00001 V=200.0" in git("diff", "base", "ours", "--", "A.JBI")[1]
    assert git("ls-files", "-u")[1].count("A.JBI") == 3


def test_what_cannot_be_read_is_told(tmp_path, capsys):
    program = tmp_path / "a.jbi"
    program.write_bytes(job([], ["TIMER T=1.00"]))
    for path, code in ((tmp_path / "none.jbi", "C003"), (tmp_path, "C005")):
        assert main(["merge", str(program), str(program), str(path), "-o", "-"]) == 2
        assert f"error[{code}]" in capsys.readouterr().err


_TWO_MORE = [
    ("krl", "DEF a()\nLIN P1\nEND\n{}", "\nDEF b()\nLIN P4\nEND\n", "\nDEF c()\nLIN P3\nEND\n"),
    (
        "krl",
        "DEF a()\nSWITCH i\nCASE 1\nb()\n{}ENDSWITCH\nEND\n",
        "CASE 2\nc()\n",
        "; rarely\nCASE 3,4\nd()\n",
    ),
    ("krl", "DEF a()\nINT i\n{}\nLIN P1\nEND\n", "INT k\n", "; of the box\nDECL REAL m, n\n"),
    (
        "rapid",
        "MODULE M\n  PROC a()\n    Stop;\n  ENDPROC\n{}ENDMODULE\n",
        "  PROC b()\n    SetDO d1,1;\n  ENDPROC\n",
        "  FUNC num c()\n    RETURN 1;\n  ENDFUNC\n",
    ),
    (
        "rapid",
        "MODULE M\nPROC a()\n    TEST n\n    CASE 1:\n      Stop;\n{}    DEFAULT:\n    ENDTEST\nENDPROC\nENDMODULE\n",
        "    CASE 2:\n      b;\n",
        "    CASE 3:\n      c;\n",
    ),
    (
        "urscript",
        "def a():\n{}  movej([0, 1, 0, 1, 0, 1])\nend\n",
        "  def b():\n    if True:\n      sleep(1)\n    end\n  end\n",
        "  thread c():\n    sleep(2)\n  end\n",
    ),
    ("as", "{}.PROGRAM a()\n  SIGNAL 1\n.END\n", ".PROGRAM b()\n  SIGNAL 3\n.END\n", ".PROGRAM c()\n.END\n"),
    (
        "pdl2",
        "PROGRAM a\nVAR\n  i : INTEGER\n{}BEGIN\n  i := 1\nEND a\n",
        "  k : REAL\n",
        "  p, q : POSITION\n",
    ),
    (
        "val3",
        "begin\n  switch n\n    case 1\n      a()\n    break\n{}  endSwitch\nend\n",
        "    case 2\n      b()\n    break\n",
        "    case 3\n      c()\n    break\n",
    ),
]


@pytest.mark.parametrize(("language", "frame", "one", "other"), _TWO_MORE)
def test_routines_branches_and_declarations_that_both_put_at_one_place_all_stand(language, frame, one, other):
    base, ours, theirs = (frame.format(text).encode() for text in ("", one, other))
    conflicts, text = merged(base, ours, theirs, language)
    assert conflicts == 0
    assert text in (frame.format(one + other), frame.format(other + one))
    assert merged(base, theirs, ours, language) == (0, text)


@pytest.mark.parametrize(
    ("base", "ours", "theirs"),
    [
        # One routine, one label, one name twice; labels that may be equal; a branch in the middle of another.
        ("END\n", "END\nDEF b()\nLIN P4\nEND\n", "END\nDEF b()\nLIN P3\nEND\n"),
        ("b()\nENDSWITCH\n", "b()\nCASE 2\nc()\nENDSWITCH\n", "b()\nCASE 1,2\nd()\nENDSWITCH\n"),
        ("b()\nENDSWITCH\n", "b()\nCASE n\nc()\nENDSWITCH\n", "b()\nCASE m\nd()\nENDSWITCH\n"),
        ("b()\ne()\n", "b()\nCASE 2\nc()\ne()\n", "b()\nCASE 3\nd()\ne()\n"),
        ("b()\nENDSWITCH\n", "b()\nCASE 2\nc()\nENDSWITCH\n", "b()\nDEFAULT\nd()\nENDSWITCH\n"),
        ("INT i\n", "INT i\nINT k\n", "INT i\nREAL k\n"),
        ("INT i\n", "INT i\nINT k\n", "INT i\nk=3\n"),
    ],
)
def test_what_depends_on_the_other_sides_additions_stays_a_conflict(base, ours, theirs):
    texts = (f"DEF a()\nSWITCH i\nCASE 0\n{text}LIN P1\n".encode() for text in (base, ours, theirs))
    assert merged(*texts, "krl")[0] == 1


@pytest.mark.parametrize(
    ("language", "base", "ours", "theirs", "expected"),
    [
        ("krl", "INT i", "INT i, k", "INT i, m", "INT i, k, m"),
        ("krl", "DECL REAL a[2,3],b ; of a", "DECL REAL a[2,3],b,c ; of a", "DECL REAL a[2,3],b,d ; of b",
         "DECL REAL a[2,3],b,c,d ; of b"),
        ("pdl2", "  p1 : POSITION", "  p1, p2 : POSITION", "  p1, p3 : POSITION", "  p1, p2, p3 : POSITION"),
    ],
)  # fmt: skip
def test_names_that_both_add_to_a_declaration_are_all_declared(language, base, ours, theirs, expected):
    texts = (f"DEF first()\n{line}\nEND\n".encode() for line in (base, ours, theirs))
    assert merged(*texts, language) == (0, f"DEF first()\n{expected}\nEND\n")


@pytest.mark.parametrize(
    ("ours", "theirs"),
    [
        ("INT i[3], k", "INT i[4], m"),
        ("INT k", "INT i, m"),
        ("REAL i, k", "INT i, m"),
        ("INT i, k", "INT i, k[2]"),
    ],
)
def test_a_declaration_that_both_change_otherwise_stays_a_conflict(ours, theirs):
    texts = (f"DEF a()\n{line}\nLIN P1\nEND\n".encode() for line in ("INT i", ours, theirs))
    assert merged(*texts, "krl")[0] == 1


_TWO = "MODULE M\nPROC a()\nMoveL p1,v100,fine,tool0;\n{}ENDPROC\n{}ENDMODULE\n"


@pytest.mark.parametrize(
    ("ours", "theirs", "shown"),
    [
        ("", "PROC b()\nSetDO d1,0;\nENDPROC\n", "PROC b()\nSetDO d1,0;\nENDPROC\n"),
        (
            "",
            "PROC b()\nSetDO d1,1;\nSetDO d2,1;\nENDPROC\n",
            "PROC b()\nSetDO d1,1;\nSetDO d2,1;\nENDPROC\n",
        ),
    ],
)
def test_what_one_side_took_out_in_one_go_is_chosen_whole(ours, theirs, shown):
    """Half a routine is none: choosing theirs has to give back all of it."""
    base = _TWO.format("", "PROC b()\nSetDO d1,1;\nENDPROC\n").encode()
    conflicts, text = merged(base, _TWO.format("", ours).encode(), _TWO.format("", theirs).encode(), "rapid")
    assert conflicts == 1
    assert f"<<<<<<< ours\n=======\n{shown}>>>>>>> theirs\n" in text


def test_a_routine_that_one_side_took_out_and_the_other_calls_is_no_silent_choice(tmp_path, capsys):
    whole = "PROC b()\nSetDO d1,1;\nENDPROC\n"
    base, gone, other, calls = (
        _TWO.format(*one).encode()
        for one in (("", whole), ("", ""), ("", whole.replace("b()", "bee()")), ("b;\n", whole))
    )
    found = merge_bytes("rapid", base, gone, calls)
    assert [hunk.why for hunk in found.hunks] == ["ours takes it out, theirs calls it"]
    paths = [tmp_path / f"{name}.mod" for name in ("base", "ours", "theirs", "merged")]
    for path, data in zip(paths, (base, other, calls), strict=False):
        path.write_bytes(data)
    words = ["merge", *map(str, paths[:3]), "-o", str(paths[3]), "--no-time"]
    assert main(words) == 1
    assert "error[U022]" in capsys.readouterr().err
    paths[2].write_bytes(_TWO.format("c;\n", whole).encode())  # of another file
    assert main(words) == 0


_ROUTINES = {
    "krl": ("DEF a()\nb()\nEND\n", "DEF b()\nLIN P1{}\nEND\n", "; of the box\nDEF c()\nLIN P2\nEND\n", "", " C_DIS"),
    "rapid": (
        "MODULE M\nVAR num n:=1;\n", "PROC b()\nWaitTime {}1;\nENDPROC\n", "! of the box\nPROC c()\nStop;\nENDPROC\n",
        "ENDMODULE\n", "1",
    ),
    "pdl2": (
        "PROGRAM a\n", "ROUTINE b\nBEGIN\n  DELAY {}1\nEND b\n", "ROUTINE c\nBEGIN\n  PAUSE\nEND c\n",
        "BEGIN\n  b\nEND a\n", "1",
    ),
    "as": ("", ".PROGRAM b()\n  TWAIT {}1\n.END\n", ".PROGRAM c()\n  PAUSE\n.END\n", ".REALS\nn = 1\n.END\n", "1"),
}  # fmt: skip


@pytest.mark.parametrize("language", _ROUTINES)
def test_a_routine_that_one_side_moves_has_what_the_other_changes_in_it(language):
    front, one, other, behind, new = _ROUTINES[language]
    base = f"{front}{one.format('')}{other}{behind}".encode()
    ours = f"{front}{other}{one.format('')}{behind}".encode()
    theirs = f"{front}{one.format(new)}{other}{behind}".encode()
    want = f"{front}{other}{one.format(new)}{behind}"
    assert merged(base, ours, theirs, language) == (0, want)
    assert merged(base, theirs, ours, language) == (0, want)
    # Theirs takes it out: somebody has to say whether it stays.
    gone = f"{front}{other}{behind}".encode()
    assert merged(base, theirs, gone, language)[0] == 1


def test_what_both_declare_at_other_places_is_declared_once_or_told(tmp_path, capsys):
    frame = "DEF a()\n{}\nLIN P1\nEND\n"
    base, ours, theirs = (
        frame.format(one).encode() for one in ("INT i\n", "INT i\nINT k\n", "INT k\nINT i\n")
    )
    conflicts, text = merged(base, ours, theirs, "krl")
    assert conflicts == 0
    assert text.count("INT k") == text.count("INT i") == 1
    rows = (["i", "j"], ["i", "k", "j"], ["i", "j", "k"])
    paths = [tmp_path / f"{name}.pdl" for name in ("base", "ours", "theirs", "merged")]
    for path, names in zip(paths, rows, strict=False):
        said = "".join(f"  {name} : INTEGER\n" for name in names)
        path.write_text(f"PROGRAM a\nVAR\n{said}BEGIN\n  i := 1\nEND a\n")
    assert main(["merge", *map(str, paths[:3]), "-o", str(paths[3]), "--no-time"]) == 1
    assert "the name k stands twice" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("suffix", "frame", "one", "other"),
    [
        ("jbi", "/JOB\n//NAME A\n//POS\n///NPOS 0,0,0,0,0,0\n//INST\n///DATE 2026/01/01 08:00\nNOP\n{}TIMER T=1.00\n"
         "{}END\n", "*A\n", "*A\n"),
        ("ls", "/PROG  A\n/MN\n   1:  {}DO[1]=ON ;\n   2:  {}DO[2]=ON ;\n/POS\n/END\n", "LBL[1] ;\n   2:  ",
         "LBL[1] ;\n   3:  "),
        ("mod", "MODULE M\n{}PROC a()\nStop;\nENDPROC\n{}ENDMODULE\n", "PROC b()\nStop;\nENDPROC\n",
         "PROC b()\nSetDO d1,1;\nENDPROC\n"),
    ],
)  # fmt: skip
def test_labels_and_routines_that_both_put_in_under_one_name_are_told(
    suffix, frame, one, other, tmp_path, capsys
):
    paths = [tmp_path / f"{name}.{suffix}" for name in ("base", "ours", "theirs", "merged")]
    for path, parts in zip(paths, (("", ""), (one, ""), ("", other)), strict=False):
        path.write_text(frame.format(*parts))
    assert main(["merge", *map(str, paths[:3]), "-o", str(paths[3]), "--no-time"]) == 1
    assert "stands twice" in capsys.readouterr().err


def test_the_same_line_that_both_put_in_keeps_the_comment_of_one():
    base, ours, theirs = (
        f"DEF a()\nLIN P1\n{line}END\n".encode() for line in ("", "LIN P2 ; x\n", "LIN P2\n")
    )
    assert merged(base, ours, theirs, "krl") == (0, ours.decode())
    assert merged(base, ours, ours.replace(b"; x", b"; y"), "krl")[0] == 1


def test_a_listing_that_lost_its_positions_is_no_listing_without_them():
    """As a file that was cut off: its moves still use them."""
    moves = "/PROG  A\n/MN\n   1:L P[1] 100mm/sec FINE    ;\n   2:L P[1] {}mm/sec FINE    ;\n"
    places = "/POS\nP[1]{\n   GP1:\n\tX = 1.000  mm\n};\n"
    base, ours = (f"{moves.format(one)}{places}/END\n".encode() for one in (100, 200))
    conflicts, text = merged(base, ours, f"{moves.format(100)}/END\n".encode(), "tp")
    assert conflicts == 1
    assert places in text


def test_how_a_controller_writes_numbers_is_no_change():
    """ModPos and a saved list write all digits and exponents of values that nobody touched."""
    row = "CONST robtarget p1:=[[600,{},800],[1,0,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];"
    saved = (
        "CONST robtarget p1:=[[600.00,100.0,800.00],[1.000,0.000,0.0,0.0],[0,0,0,0],"
        "[9E+09,9E+09,9E+09,9E+09,9E+09,9E+09]];"
    )
    base, ours, theirs = (
        f"MODULE M\n{text}\nENDMODULE\n".encode() for text in (row.format(100), saved, row.format(111))
    )
    assert merged(base, ours, theirs, "rapid") == (0, theirs.decode())
    base, ours, theirs = (f"DEFDAT A\nREAL H={text}\nENDDAT\n".encode() for text in ("850", "360", "360.0"))
    assert merged(base, ours, theirs, "krl")[0] == 0


def test_a_merge_that_neither_side_would_have_written_is_told(tmp_path, capsys):
    """Ours takes a label out that theirs begins to jump to."""
    base, ours, theirs = (tmp_path / f"{name}.jbi" for name in ("base", "ours", "theirs"))
    lines = ["TIMER T=1.00", "*A", "TIMER T=2.00", "DOUT OT#(1) ON", "DOUT OT#(2) ON", "TIMER T=3.00"]
    base.write_bytes(job([], lines))
    ours.write_bytes(job([], [line for line in lines if line != "*A"]))
    theirs.write_bytes(job([], [*lines[:5], "JUMP *A IF IN#(1)=ON", lines[5]]))
    assert main(["merge", str(base), str(ours), str(theirs), "-o", str(tmp_path / "out.jbi")]) == 1
    assert "error[U022]" in capsys.readouterr().err


def test_saved_variables_and_tools_are_merged_by_value(tmp_path, capsys):
    """One side counts on, the other teaches a position and another value of the same row; a tool is one thing."""
    saved = ROOT / "samples/inform/palletising"
    base = (saved / "VAR.DAT").read_bytes()
    ours = base.replace(b"2,0,1,0,0,0,0,0,0,0", b"3,0,1,0,0,0,0,0,0,0").replace(b"2500,-40", b"2501,-40")
    theirs = base.replace(b"2,0,1,0,0,0,0,0,0,0", b"2,0,1,0,0,0,0,0,9,0").replace(b"-23291", b"-23300")
    expected = theirs.replace(b"2,0,1,0,0,0,0,0,9,0", b"3,0,1,0,0,0,0,0,9,0").replace(
        b"2500,-40", b"2501,-40"
    )
    paths = [tmp_path / name for name in ("base.dat", "ours.dat", "theirs.dat")]
    for path, data in zip(paths, (base, ours, theirs), strict=True):
        path.write_bytes(data)
    assert main(["merge", *map(str, paths), "-o", str(tmp_path / "VAR.DAT")]) == 0
    assert (tmp_path / "VAR.DAT").read_bytes() == expected
    assert "line 6: value 1 by ours, value 9 by theirs" in capsys.readouterr().out
    assert merged(base, base.replace(b"-23291", b"-23292"), theirs)[0] == 1  # one position
    tools = (saved / "TOOL.CND").read_bytes()
    row = next(line for line in tools.split(b"\n") if line.count(b",") == 5)
    sides = [tools.replace(row, row.replace(b"0.000", number, 1), 1) for number in (b"5.000", b"6.000")]
    assert merged(tools, *sides)[0] == 1


def _polyscope(nodes: str, more: str = "") -> bytes:
    head = (
        f'<URProgram name="a" installation="i" lastSavedIn="5.11"{more}>\n  <children>\n    <MainProgram>\n'
    )
    nodes = f"      <children>\n{nodes}"
    return gzip.compress(
        f"{head}{nodes}      </children>\n    </MainProgram>\n  </children>\n</URProgram>".encode()
    )


def _taught(tcp: str, name: str, first: float, speed: str = "1.0") -> str:
    return f"""        <Move motionType="MoveJ" speed="{speed}" acceleration="1.4">
          {tcp}
          <children>
            <Waypoint type="Fixed" name="{name}">
              <position>
                <JointAngles angles="{first}, -1.5, 1.5, 0.5, 0.4, 0.3"/>
                <TCPOffset pose="0.0, 0.0, 0.1, 0.0, 0.0, 0.0"/>
              </position>
              <BaseToFeature pose="{first}, 0.2, 0.3, 0.0, 0.0, 0.0"/>
            </Waypoint>
          </children>
        </Move>
"""


_TCP, _AGAIN = '<tcp referencedName="Gripper"/>', '<tcp reference="../../Move/tcp"/>'


def _tools(data: bytes) -> list[tuple[str, str, str]]:
    """Of each move its waypoint, speed and tool, references followed by ElementTree."""
    root = ElementTree.fromstring(gzip.decompress(data))
    parents = {child: node for node in root.iter() for child in node}
    found = []
    for move in root.iter("Move"):
        tcp = move.find("tcp")
        for step in tcp.get("reference", "").split("/") if tcp.get("reference") else ():
            tcp = parents[tcp] if step == ".." else tcp.find(step)
        found.append(
            (move.find(".//JointAngles").get("angles")[:3], move.get("speed"), tcp.get("referencedName"))
        )
    return found


def test_polyscope_programs_are_merged_with_what_their_nodes_share():
    """Theirs puts a move in front: what all refer to stands in it now, and each path is another one."""
    base = _polyscope(_taught(_TCP, "a", 0.1) + _taught(_AGAIN, "b", 0.2))
    ours = _polyscope(_taught(_TCP, "a", 0.1) + _taught(_AGAIN, "b", 0.9, "0.5"))
    third = '<tcp reference="../../Move/tcp"/>'
    theirs = _polyscope(_taught(_TCP, "new", 0.3) + _taught(_AGAIN, "a", 0.1) + _taught(third, "b", 0.2))
    merged = merge_bytes("urscript", base, ours, theirs)
    assert not merged.hunks
    want = [("0.3", "1.0", "Gripper"), ("0.1", "1.0", "Gripper"), ("0.9", "0.5", "Gripper")]
    assert _tools(merged.to_bytes()) == want
    assert merged.to_bytes() == merge_bytes("urscript", base, theirs, ours).to_bytes()
    program = find_vendor("urscript").read(decode(merged.to_bytes(), "a.urp"))
    assert [one.comment for one in program.statements() if isinstance(one, Move)] == ["new", "a", "b"]


def test_one_point_of_polyscope_is_one_thing_and_its_conflict_is_told_without_a_file(tmp_path, capsys):
    base, ours, theirs = (_polyscope(_taught(_TCP, "a", first)) for first in (0.1, 0.2, 0.3))
    paths = [tmp_path / f"{name}.urp" for name in ("base", "ours", "theirs")]
    for path, data in zip(paths, (base, ours, theirs), strict=True):
        path.write_bytes(data)
    out = tmp_path / "out.urp"
    assert main(["merge", *map(str, paths), "-o", str(out), "--no-time"]) == 1
    told = capsys.readouterr().out
    assert "1 conflict, nothing is written" in told
    assert 'angles="0.2' in told
    assert 'angles="0.3' in told
    assert not out.exists()
    assert main(["merge", *map(str, paths), "--driver", "a.urp", "--no-time"]) == 1
    assert paths[1].read_bytes() == ours


@pytest.mark.parametrize(
    "data",
    [gzip.compress(b"<URProgram><a></URProgram>"), gzip.compress(b"<URProgram/>")[:20]],
    ids=["no-xml", "cut"],  # the bytes hold the time of day: two workers would call their tests differently
)
def test_a_polyscope_program_that_is_broken_is_refused(data):
    with pytest.raises(OlpError, match="cannot be merged"):
        merge_bytes("urscript", _polyscope(""), data, _polyscope(_taught(_TCP, "a", 0.1)))


def test_two_changes_that_happened_are_made_in_the_same_version_where_they_share_nothing(tmp_path):
    """The second change wrote into a line of the first one, and put another one elsewhere: both are left out."""
    first = b"&REL 4\nPTP p1\nPTP p2\nPTP p3\nPTP p4\n"
    second = b"&REL 5\nPTP p1\nLIN p8\nPTP p2\nPTP p3\nPTP p4\nHALT\n"
    third = b"&REL 6\nHALT\nPTP p1\nLIN p9\nPTP p2\nSPTP p3\nPTP p4\n"
    assert on_its_own(tmp_path, first, second, third) == (
        second,
        b"&REL 6\nPTP p1\nPTP p2\nSPTP p3\nPTP p4\n",
        b"&REL 6\nPTP p1\nLIN p8\nPTP p2\nSPTP p3\nPTP p4\nHALT\n",
    )
    assert on_its_own(tmp_path, first, second, second.replace(b"p8", b"p9")) is None
