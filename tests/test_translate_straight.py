"""Ways that the text shows, held against the run of the program."""

from __future__ import annotations

import random
from pathlib import Path

import pytest
from translate_programs import own_program, written
from translated_texts import VENDORS

import olp
from olp.ir.program import Move, Program
from olp.robots.robot import load_robot
from olp.transpile import Context
from olp.transpile.context import TranslationContext, Walk, walk_through
from olp.transpile.convert import convert
from olp.transpile.line_executions import LineExecutions
from olp.transpile.link import link
from olp.transpile.pipeline import passes, work_for
from olp.transpile.speeds import speeds

ROBOT = load_robot("yaskawa/gp25")
HEAD = "MODULE m\n  PROC main()\n"


def walked(program: Program) -> tuple[Walk, TranslationContext]:
    work = work_for(program, "urscript", Context(robot=ROBOT))
    for step in passes(work, program):
        if step is speeds:
            break
        program = step(program, work)
    return walk_through(program, work), work


def compared(program: Program) -> int:
    """How many moves' rooms the text shows; each is that of the run, where that comes by."""
    walk, work = walked(program)
    rows, known = LineExecutions(work), walk.rooms()
    for s in walk.program.statements():
        if isinstance(s, Move) and s.line in known and rows.of(s):
            assert known[s.line] == pytest.approx(rows.room(s), rel=1e-9), s
    return len(known)


def rapid(tmp_path: Path, text: str) -> Program:
    point = "[[%g,%g,600],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]]"
    for number in range(9):
        text = text.replace(f"p{number}", point % (400 + 10 * number, 20 * number**2))
    (tmp_path / "m.mod").write_text(text)
    return olp.read(tmp_path / "m.mod")


def job(moves: int) -> bytes:
    """Straight and joint moves of many lengths, some of them nothing."""
    chance = random.Random(moves)
    rows = ["/JOB", "//NAME WAYS", "//POS", f"///NPOS {moves},0,0,0,0,0", "///USER 1", "///TOOL 1"]
    rows += ["///POSTYPE USER", "///RECTAN", f"///RCONF 1,{','.join('0' * 23)}"]
    for n in range(moves):
        x, y, z = (chance.randrange(3) * 40 + chance.randrange(2) for _ in range(3))
        rows.append(f"C{n:05d}={500 + x}.000,{y}.000,{400 + z}.000,178.0000,{n % 7}.2500,-21.5000")
    rows += ["//INST", "///DATE 2026/03/02 14:07", "///ATTR SC,RW", "///GROUP1 RB1", "NOP"]
    kinds = ("MOVL C{:05d} V=50.0 PL=3", "MOVJ C{:05d} VJ=5.00 PL=1")
    rows += [kinds[n % 5 == 4].format(n) for n in range(moves)]
    return "".join(f"{row}\r\n" for row in [*rows, "END"]).encode()


@pytest.mark.parametrize("vendor", VENDORS)
def test_rooms_that_the_text_shows_are_those_of_the_run(vendor: str, tmp_path: Path) -> None:
    (tmp_path / "WAYS.JBI").write_bytes(job(60))
    program = olp.read(tmp_path / "WAYS.JBI")
    if vendor != "inform":
        program = written(convert(program, vendor, Context(robot=ROBOT)), vendor, tmp_path / vendor)
    assert compared(program) >= 20
    for seed in range(3):
        compared(own_program(seed, vendor, tmp_path / str(seed), ROBOT))


def test_the_way_goes_through_a_routine_that_is_called_once(tmp_path: Path) -> None:
    rows = ["MoveL p0,v100,fine,tool0;", "part;", "MoveL p3,v100,z10,tool0;", "MoveL p4,v100,z10,tool0;"]
    part = ["MoveL p1,v100,z10,tool0;", "MoveL p2,v100,z10,tool0;"]
    text = "\n".join([HEAD, *rows, "ENDPROC", "PROC part()", *part, "ENDPROC", "ENDMODULE", ""])
    assert compared(rapid(tmp_path, text)) == 5


@pytest.mark.parametrize(
    ("rows", "count"),
    [
        (["part;", "MoveL p3,v100,z10,tool0;", "part;"], 1),  # two ways lead into the part, and two out of it
        (["IF di1=1 THEN", "part;", "ENDIF", "MoveL p3,v100,z10,tool0;"], 1),
        (["FOR i FROM 1 TO 3 DO", "MoveL p3,v100,z10,tool0;", "ENDFOR", "part;"], 1),
    ],
)
def test_where_the_way_branches_the_text_shows_no_room(tmp_path: Path, rows: list[str], count: int) -> None:
    part = ["MoveL p1,v100,z10,tool0;", "MoveL p2,v100,z10,tool0;", "MoveL p5,v100,z10,tool0;"]
    rows = ["MoveL p0,v100,fine,tool0;", *rows]
    text = "\n".join([HEAD, *rows, "ENDPROC", "PROC part()", *part, "ENDPROC", "ENDMODULE", ""])
    assert compared(rapid(tmp_path, text)) == count


def test_a_program_in_several_files_is_one_way(tmp_path: Path) -> None:
    head = "/PROG  {}\n/MN\n"
    point = (
        "P[{0}]{{\n GP1:\n UF : 0, UT : 1, CONFIG : 'N U T, 0, 0, 0',\n"
        " X = {1} mm, Y = 0 mm, Z = 600 mm, W = 180 deg, P = 0 deg, R = 0 deg\n}};\n"
    )
    moves = "".join(f"   {n}:L P[{n}] 100mm/sec CNT50    ;\n" for n in (1, 2, 3))
    for name, start in (("ONE", 400), ("TWO", 600)):
        points = "".join(point.format(n, start + 10 * n**2) for n in (1, 2, 3))
        (tmp_path / f"{name}.ls").write_text(f"{head.format(name)}{moves}/POS\n{points}/END\n")
    calls = "   1:  CALL ONE    ;\n   2:  CALL TWO    ;\n"
    (tmp_path / "ALL.ls").write_text(f"{head.format('ALL')}{calls}/POS\n/END\n")
    assert compared(link(olp.read(tmp_path / "ALL.ls")).program) == 6
