# ruff: noqa: E501
"""What the INFORM reader says about bad text, to the letter."""

from __future__ import annotations

from pathlib import Path

import pytest
from cpu_time import cpu_time_below
from inform_jobs import job, read_lines, told

from olp.core.diagnostic import Severity
from olp.ir.expressions import Store
from olp.languages.vendors.inform.instructions import WORDS
from olp.languages.vendors.inform.statements import instruction_parser

POINTS = ("C00000=11,2,3,4,5,6", "C00001=12,2,3,4,5,6")
DOCS = Path(__file__).resolve().parent.parent / "docs"


def broken(instruction: str) -> str:
    """What is said about one instruction, without its place in the file."""
    (text,) = told(job([instruction], POINTS))
    return "\n".join(line for line in text.splitlines() if not line.startswith("  -->"))


def test_all_broken_lines_of_a_file_are_told_at_once_each_with_its_place() -> None:
    assert told(
        job(["MOVL C00001 V=", "TIMER T=0.35", "CALL JOB:", "DOUT OT#(3 ON", "JUMP *DONE", "ENDIF"], POINTS)
    ) == [
        """error[P020]: the line ends too early
  --> test.jbi:12:15
12 | MOVL C00001 V=
   |               ^
help: expected a number, a variable such as B000, LD012 or P040 or a name from //ALIAS""",
        """error[P020]: 'JOB:' is not expected here
  --> test.jbi:14:6
14 | CALL JOB:
   |      ^^^^
help: expected a job such as JOB:MAIN""",
        """error[P020]: 'ON' is not expected here
  --> test.jbi:15:12
15 | DOUT OT#(3 ON
   |            ^^
help: expected ')'""",
        """error[P113]: label *DONE does not exist
  --> test.jbi:16:1
16 | JUMP *DONE
   | ^^^^^^^^^^
help: labels of this job: none""",
        """error[P111]: ENDIF without IFTHEN
  --> test.jbi:17:1
17 | ENDIF
   | ^^^^^
help: remove it, or open the block""",
    ]


SAID = [
    (
        "MOVL C00001 VV=165.0",
        """error[P020]: 'VV=' is not known here
12 | MOVL C00001 VV=165.0
   |             ^^^
help: expected a speed such as V=300.0 or VJ=25.00, a position level such as PL=1, ACC= or DEC=, CR=, CV=, VE= or SPDL=, '+', …""",
    ),
    (
        "MOVL V=92.5",
        """error[P020]: 'V=' is not expected here
12 | MOVL V=92.5
   |      ^^
help: expected a position such as C00001""",
    ),
    (
        "MOVL C00001 V= PL=1",
        """error[P020]: V= has no value
12 | MOVL C00001 V= PL=1
   |             ^^
help: expected a number or a variable""",
    ),
    (
        "MOVJ C00001 VJ=12..5",
        """error[P020]: '12..5' is no number
12 | MOVJ C00001 VJ=12..5
   |                ^^^^^
help: expected a number""",
    ),
    (
        'MSG "no part',
        """error[P020]: a text that is never closed
12 | MSG "no part
   |     ^^^^^^^^
help: expected a " at its end""",
    ),
    (
        "SET B004  EXPRESS ( 3 + B003 * 2",
        """error[P020]: the line ends too early
12 | SET B004  EXPRESS ( 3 + B003 * 2
   |                                 ^
help: expected ')', '+' or '-'""",
    ),
    (
        "MOVL C00001 V=12.5 PL=1 UF#(3)",
        """error[P020]: a coordinate system belongs to IMOV only
12 | MOVL C00001 V=12.5 PL=1 UF#(3)
   |                         ^^^
help: expected no coordinate system""",
    ),
    (
        "MOVL C00001 V=12.5 PL=1 V=13.5",
        """error[P020]: a second speed in one line
12 | MOVL C00001 V=12.5 PL=1 V=13.5
   |                         ^^
help: expected one speed""",
    ),
    (
        "INC B003 4",
        """error[P020]: INC takes one variable
12 | INC B003 4
   | ^^^
help: expected INC B000""",
    ),
    (
        "SET D003  EXPRESS D004 7",
        """error[P020]: two values without an operator between them
12 | SET D003  EXPRESS D004 7
   |                        ^
help: expected +, -, * or /""",
    ),
    (
        "MOVL C00001 V=0.0 PL=1",
        """error[P020]: a speed of 0.0
12 | MOVL C00001 V=0.0 PL=1
   |             ^^
help: expected one above 0""",
    ),
    (
        "MOVL C00001 V=12.5 PL=9",
        """error[P020]: a position level of 9
12 | MOVL C00001 V=12.5 PL=9
   |                    ^^^
help: expected 0 to 8""",
    ),
    (
        "TIMER T=-0.5",
        """error[P020]: a time of -0.5
12 | TIMER T=-0.5
   |       ^^
help: expected one of 0 or more""",
    ),
    (
        "WAIT",
        """error[P020]: WAIT names no condition
12 | WAIT
   | ^^^^
help: expected WAIT IN#(1)=ON or WAIT T=1.00""",
    ),
    (
        "GETARG B003 IARG#(1.5)",
        """error[P020]: '1.5' is no argument number
12 | GETARG B003 IARG#(1.5)
   |                   ^^^
help: expected 1 to 8""",
    ),
    (
        "MOVEL C00001",
        """warning[P021]: MOVEL is kept but not modelled
12 | MOVEL C00001
   | ^^^^^
help: did you mean MOVL?""",
    ),
    (
        "LASERTRK ON",
        """info[P021]: LASERTRK is kept but not modelled
12 | LASERTRK ON
   | ^^^^^^^^
help: its effect on the time is unknown""",
    ),
    (
        "MOVL C00001 V=1.5  +MOVJ EC00007",
        """error[P030]: there is no position EC00007
12 | MOVL C00001 V=1.5  +MOVJ EC00007
   |                          ^^^^^^^
help: the job has none""",
    ),
    (
        "GETE D003 C00008 (3)",
        """error[P030]: there is no position C00008
12 | GETE D003 C00008 (3)
   |           ^^^^^^
help: the nearest one is C00001""",
    ),
    (
        "MOVL C007",
        """error[P030]: there is no position C00007
12 | MOVL C007
   |      ^^^^
help: the nearest one is C00001""",
    ),
    (
        "SET Nest_1 4",
        """warning[P041]: the name Nest_1 is not in //ALIAS
12 | SET Nest_1 4
   |     ^^^^^^
help: add its variable to //ALIAS, or write the variable itself""",
    ),
    (
        "TIMER T=0.35 'x",
        """warning[P033]: a ' comment behind an instruction, which the controller refuses
12 | TIMER T=0.35 'x
   |              ^^
help: write it on a line of its own, or with // behind a move""",
    ),
    (
        "C00002=1,2,3",
        """error[P014]: a position row among the instructions
12 | C00002=1,2,3
   | ^^^^^^^^^^^^
help: move it above NOP; is the line /JOB of another job missing?""",
    ),
    (
        "//NAME NEXT",
        """error[P015]: a header record among the instructions
12 | //NAME NEXT
   | ^^^^^^^^^^^
help: move it above NOP; is the line /JOB of another job missing?""",
    ),
    (
        "*LOAD_ONLY",
        """info[P032]: a label of more than 8 characters
12 | *LOAD_ONLY
   | ^^^^^^^^^^
help: older controllers refuse it""",
    ),
    (
        "'a comment that is longer than what fits",
        """info[P037]: a comment of more than 32 characters
12 | 'a comment that is longer than what fits
   | ^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^
help: the pendant cuts it off""",
    ),
    (
        "SET D000 1234567890123456789",
        """error[P023]: a number of 19 digits
12 | SET D000 1234567890123456789
   | ^^^^^^^^^^^^^^^^^^^^^^^^^^^^
help: at most 18""",
    ),
]


@pytest.mark.parametrize(("line", "said"), SAID, ids=[line for line, _ in SAID])
def test_a_bad_instruction_is_told_in_words(line: str, said: str) -> None:
    assert broken(line) == said


HEADERS = [
    (
        job(points=["///POSTYPE WORLD"]),
        """error[P011]: no position type 'WORLD'
  --> test.jbi:5:12
5 | ///POSTYPE WORLD
  |            ^^^^^
help: expected one of PULSE, ANGLE, BASE, ROBOT, USER, TOOL, MTOOL""",
    ),
    (
        job(points=["C00000=11,2,3x,4,5,6"]),
        """error[P010]: '3x' is no number
  --> test.jbi:5:13
5 | C00000=11,2,3x,4,5,6
  |             ^^
help: expected a number""",
    ),
    (
        job(points=["C00000=11,2,3,4,5,6", "C00001=11,2,3,4"]),
        """error[P012]: 4 values, where the other rows have 6
  --> test.jbi:6:8
6 | C00001=11,2,3,4
  |        ^^^^^^^^
help: expected 6 numbers with commas""",
    ),
    (
        ["/JOB", "//NAME A", "//POS", "///NPOS 2,0,0,0,0,0", POINTS[0], "//INST", "NOP", "END"],
        """error[P017]: ///NPOS 2,0,0,0,0,0 does not fit the rows
  --> test.jbi:4:9
4 | ///NPOS 2,0,0,0,0,0
  |         ^^^^^^^^^^^
help: counted 1,0,0,0,0,0; is the file cut off?""",
    ),
    (
        job(points=["///POSTYPE USER", "///RECTAN", *POINTS]),
        """warning[P018]: no ///USER before this row: taken as 0
  --> test.jbi:7:1
7 | C00000=11,2,3,4,5,6
  | ^^^^^^^^^^^^^^^^^^^""",
    ),
    (
        job(points=["///TOOL 2", "C00000=11.125,2,3,4,5,6"]),
        """warning[P019]: pulses with decimals: is ///RECTAN missing before this row?
  --> test.jbi:6:1
6 | C00000=11.125,2,3,4,5,6
  | ^^^^^^^^^^^^^^^^^^^^^^^
help: read as pulses""",
    ),
    (
        [*job(), *job()],
        """warning[P043]: a second job called TEST
  --> test.jbi:11:1
11 | /JOB
   | ^^^^
help: the first one begins in line 1; calls go to it""",
    ),
    (
        job(header=["///DATE 2026/01/01 10:00", "///POSTYPE USER"]),
        """error[P015]: no record ///POSTYPE is known in //INST
  --> test.jbi:7:1
7 | ///POSTYPE USER
  | ^^^^^^^^^^^^^^^
help: expected ///DATE, ///COMM, ///ATTR, ////FRAME, ///GROUP1, ///LVARS or NOP""",
    ),
    (
        job()[:-1],
        """error[P009]: the job has no END
  --> test.jbi:9:1
9 | NOP
  | ^^^
help: is the file cut off? add END as the last line""",
    ),
    (
        job(["END", "TIMER T=1.5"])[:-1],
        """error[P022]: an instruction behind END is never executed
  --> test.jbi:11:1
11 | TIMER T=1.5
   | ^^^^^^^^^^^
help: END stands in line 10""",
    ),
    (
        [line for line in job() if line != "NOP"],
        """error[P008]: the instructions do not begin with NOP
  --> test.jbi:9:1
9 | END
  | ^^^
help: add NOP before this line""",
    ),
    (
        job()[:4],
        """error[P007]: the job has no //INST
  --> test.jbi:4:1
4 | ///NPOS 0,0,0,0,0,0
  | ^^^^^^^^^^^^^^^^^^^
help: is the file cut off?""",
    ),
    (
        [line for line in job(points=POINTS) if line != "//POS"],
        """error[P014]: positions begin with //POS
  --> test.jbi:3:1
3 | ///NPOS 2,0,0,0,0,0
  | ^^^^^^^^^^^^^^^^^^^
help: expected the line //POS before this one""",
    ),
    (
        job()[1:],
        """error[P015]: a job begins with /JOB
  --> test.jbi:1:1
1 | //NAME TEST
  | ^^^^^^^^^^^
help: add the line /JOB before this one""",
    ),
    (
        ["MOVE(P1, 100);", "while (true) { grip(); }"],
        """error[P006]: this is no job: it has no header
  --> test.jbi
help: a job begins with /JOB, //NAME, //POS and //INST""",
    ),
    (
        job(aliases=["D003 A", "D004 A"]),
        """warning[P042]: the name A stands twice in //ALIAS; the first one counts
  --> test.jbi:7:1
7 | D004 A
  | ^^^^^^
help: give each variable its own name""",
    ),
    (
        job(name="A" * 33),
        """warning[P038]: a job name of 33 characters; controllers take 32
  --> test.jbi:2:1
2 | //NAME AAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAAA
  | ^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^^
help: 8 on controllers before the DX100""",
    ),
]


@pytest.mark.parametrize(("lines", "said"), HEADERS, ids=[said.splitlines()[0] for _, said in HEADERS])
def test_a_bad_header_is_told_once_with_its_place(lines: list[str], said: str) -> None:
    assert told(lines) == [said]


def test_a_broken_row_is_not_told_again_as_a_missing_point_or_a_wrong_count() -> None:
    lines = job(["MOVL C00001 V=3.5"], [POINTS[0], "C00001=12,2,3,4,5,6x"])
    assert [text.splitlines()[0] for text in told(lines)] == ["error[P010]: '6x' is no number"]


def test_a_broken_block_opener_is_not_told_again_as_an_unpaired_closer() -> None:
    lines = job(
        [
            "IFTHEN B003==1",
            "ELSE",
            "ENDIF",
            "WHILE",
            "ENDWHILE",
            "FOR",
            "NEXT",
            "SWITCH",
            "DEFAULT",
            "ENDSWITCH",
        ]
    )
    assert [d.code for d in read_lines(lines).diagnostics] == ["P020"] * 4


def test_coordinates_too_few_for_a_pose_are_told_and_the_move_has_no_time() -> None:
    """A single row has no neighbours to compare with, and timing it once raised IndexError."""
    points = ["///POSTYPE BASE", "///RECTAN", "C00000=11.1,2.2,3.3,4.4,5.5"]
    program = read_lines(job(["MOVL C00000 V=50.0"], points=points))
    assert [(d.code, d.severity, d.line) for d in program.diagnostics] == [("P012", Severity.ERROR, 7)]
    times = program.plan(robot="yaskawa/ma2010").time()
    assert len(times) == 1
    assert not read_lines(job(points=["C00000=11,2,3,4"])).diagnostics, "pulses of a four-axis arm"


def test_a_finding_that_repeats_is_told_once_and_counted() -> None:
    texts = told(job(["SET Nest 1", "LASERTRK 1", "SET Nest 2", "ADD Nest 3", "LASERTRK 2"]))
    assert [text.splitlines()[0] for text in texts] == [
        "warning[P041]: the name Nest is not in //ALIAS (and in 2 more lines)",
        "info[P021]: LASERTRK is kept but not modelled (and once more)",
    ]


def test_line_ends_and_tabs_are_told_once_and_are_no_errors() -> None:
    program = read_lines(job([" \tTIMER T=1.5\t", "TIMER\tT=2.5", "\tTIMER\tT=3.5"]), end="\n")
    assert [(d.code, d.severity, d.line, d.column) for d in program.diagnostics] == [
        ("P035", Severity.INFO, 0, 1),
        ("P034", Severity.INFO, 11, 6),
    ]


def test_tabs_that_only_indent_are_not_told() -> None:
    """DX200 controllers indent the lines of a block with blanks and a tab."""
    assert told(job(["  \tTIMER T=1.5\t", "\t'comment", "\t"])) == []


def test_a_short_row_among_robot_points_may_be_a_station_and_is_kept() -> None:
    program = read_lines(job(points=["C00000=11,2,3,4,5,6", "C00001=7,8,9,10,11,12", "C00002=-20,343"]))
    assert [(d.code, d.severity, d.line) for d in program.diagnostics] == [("P012", Severity.WARNING, 7)]
    point = program.routines[0].points.find(Store.ROBOT, True, 2)
    assert point is not None
    assert point.values[:2] == (-20, 343)


def test_binary_and_utf_16_are_one_error_each() -> None:
    from olp.core.source import decode
    from olp.fluent import read_source

    text = "\r\n".join(job())
    for raw in (text.encode("utf-16"), b"\x00\x01" + text.encode(), bytes(range(256))):
        program = read_source(decode(raw, "test.jbi"), vendor="inform")
        assert [d.code for d in program.diagnostics] == ["P001"]
        assert not program.routines


def test_every_terminal_of_the_grammar_is_told_in_words() -> None:
    opening = {
        "LOCKED",
        "FUNCTION",
        "UPDATE",
        "SHIFT_ON",
        "SHIFT_OFF",
        "JUMP",
        "CALL_JOB",
        "IF",
        "ELSEIF",
        "WHILE",
    }
    opening |= {"PROCESS", "BLANK"}  # open a line, so that nothing else can be expected in their place
    for name, pattern in instruction_parser().terminals.items():
        assert name in WORDS or name in opening or pattern in instruction_parser().words, name
    assert set(WORDS) <= set(instruction_parser().terminals) | {"$END"}


HOSTILE = {
    "nested parentheses": job(["SET D000  EXPRESS " + "( " * 1_000_000]),
    "signs": job(["SET D000  EXPRESS " + "-" * 4000 + "1"]),
    "a long name": job(["SET " + "A" * 1_000_000 + " 1"]),
    "a long number": job(
        ["MOVL C00001 V=" + "1" * 1_000_000, "TIMER T=" + "9" * 4000, "SET D" + "1" * 4000 + " 1"]
    ),
    "many quotes": job(["MSG " + '"' * 4000]),
    "broken lines": job([f"SET {n} {n}" for n in range(20_000)]),
    "unknown words": job([f"FOO{n} {n}" for n in range(5_000)]),
    "missing points": job(
        [f"MOVL C{n:05} V=1" for n in range(9_000)], [f"C{90000 + n}=1,2,3,4,5,6" for n in range(9_000)]
    ),
    "a wide row": job(points=["C00001=" + "1," * 300_000]),
    "long records": job(header=["///LVARS " + "9" * 5000 + ",0,0,0,0,0,0,0", "////FRAME USER " + "9" * 5000]),
    "long blanks": job(["MOVL" + " " * 100_000 + "C00001"] * 5),
    "open blocks": job(["IFTHEN B000=1"] * 10_000),
    "names that are broken": job(
        [f"SET N {n} 1 1" for n in range(3000)], aliases=[f"D{n:03} N {n}" for n in range(3000)]
    ),
}


@pytest.mark.parametrize("lines", HOSTILE.values(), ids=list(HOSTILE))
def test_hostile_text_is_told_and_takes_no_second(lines: list[str]) -> None:
    with cpu_time_below(1.0):
        program = read_lines(lines)
    assert any(d.severity is not Severity.INFO or d.code == "P021" for d in program.diagnostics)


def test_after_two_thousand_broken_lines_the_rest_is_not_examined_and_that_is_told() -> None:
    program = read_lines(job([f"SET {n} {n}" for n in range(3_000)]))
    codes = [d.code for d in program.diagnostics]
    assert codes.count("P020") == 2000
    assert codes.count("P024") == 1
