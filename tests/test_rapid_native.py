"""RAPID as people write it: main, points that ModPos keeps, outputs that are set in the corner."""

import re

import pytest

import olp
from olp.__main__ import main
from olp.robots.robot import load_robot
from olp.transpile import Context
from olp.transpile.compare import compare_plans
from olp.transpile.convert import convert, run_converted, runs_of
from olp.transpile.link import link

ROBOT = load_robot("yaskawa/gp25")
KRL = """DEF CELL ( )
$TOOL=TOOL_DATA[1]
$BASE=$NULLFRAME
$VEL.CP=0.2
$APO.CDIS=20
LIN XA C_DIS
CONTINUE
$OUT[3]=TRUE ; grip
LIN XB
$OUT[4]=FALSE
MOVED.Z=MOVED.Z+10
LIN MOVED C_DIS
END
DEFDAT CELL
DECL E6POS XA={X 900,Y 100,Z 600,A 0,B 90,C 0}
DECL E6POS XB={X 950,Y 200,Z 650,A 0,B 90,C 0}
DECL E6POS MOVED={X 950,Y 200,Z 700,A 0,B 90,C 0}
ENDDAT
"""
TP = """/PROG  CELL
/ATTR
/MN
   1:  UFRAME_NUM=0 ;
   2:  UTOOL_NUM=1 ;
   3:J P[1] 30% CNT40 ;
   4:  DO[5]=ON ;
   5:L P[2] 200mm/sec FINE ;
   6:  DO[5]=OFF ;
/POS
P[1:"above"]{
   GP1:
    UF : 0, UT : 1,     CONFIG : 'N U T, 0, 0, 0',
    X =  900.000  mm,   Y =   100.000  mm,  Z =   600.000  mm,
    W =     180.000 deg,    P =     10.000 deg, R =     5.000 deg
};
P[2:"grip the left part"]{
   GP1:
    UF : 0, UT : 1,     CONFIG : 'N U T, 0, 0, 0',
    X =  950.000  mm,   Y =   200.000  mm,  Z =   650.000  mm,
    W =     180.000 deg,    P =     10.000 deg, R =     5.000 deg
};
/END
"""


def program(tmp_path, text, suffix):
    (tmp_path / f"CELL{suffix}").write_text(text)
    return link(olp.read(tmp_path / f"CELL{suffix}")).program


def rapid(source, **more):
    made = convert(source, "rapid", Context(ROBOT, **more))
    return made.files["CELL.mod"].decode(), made


@pytest.mark.parametrize(
    ("text", "suffix", "line"),
    [
        (
            KRL,
            ".src",
            r"MoveLDO XA,v200\w*,z20,\w+,do3,1; ! grip\s+MoveL XB,v200\w*,fine,\w+;\s+SetDO do4,0;",
        ),
        (
            TP,
            ".ls",
            r"MoveJDO above,v\w+,z\w+,\w+,do5,1;\s+MoveL grip_the_left_part,v200,fine,\w+;\s+SetDO do5,0;",
        ),
    ],
    ids=["krl", "tp"],
)
def test_an_output_at_a_corner_is_set_there_and_the_runs_agree(tmp_path, text, suffix, line):
    source = program(tmp_path, text, suffix)
    written, made = rapid(source)
    assert re.search(line, written)
    runs = runs_of(source, made, "rapid", (ROBOT, None))
    found = compare_plans(runs.source[0], runs.target[0], origins=runs.origins, blends=False, speeds=False)
    assert not [one for one in found.differences if "only" in one], found.differences


def test_points_that_nothing_changes_are_constants(tmp_path):
    written, _ = rapid(program(tmp_path, KRL, ".src"))
    assert re.findall(r"(CONST|VAR|PERS) robtarget (\w+)", written) == [
        ("CONST", "XA"),
        ("CONST", "XB"),
        ("PERS", "MOVED"),
    ]


def test_the_program_that_is_started_has_main(tmp_path):
    source = program(tmp_path, TP, ".ls")
    written, made = rapid(source, entry=True)
    assert re.search(r"PROC main\(\)\s+CELL;\s+ENDPROC", written)
    plain = run_converted(rapid(source)[1], "rapid", ROBOT, source)
    assert not compare_plans(run_converted(made, "rapid", ROBOT, source), plain).differences


def test_several_programs_have_no_second_main(tmp_path):
    for name in ("A", "B"):
        (tmp_path / f"{name}.ls").write_text(TP.replace("CELL", name))
    assert main(["convert", str(tmp_path), "--to", "rapid", "--robot", "yaskawa/gp25", "-o", str(tmp_path / "out"),
                 "--accept", "named"]) in (0, 1)  # fmt: skip
    texts = [path.read_text() for path in (tmp_path / "out").iterdir()]
    assert len(texts) == 2
    assert not any("main" in text for text in texts)
