"""KRL's inline forms: the pendant's own text, touched up there, and the same plan as the plain statements."""

import re
from pathlib import Path

import pytest

import olp
from olp.__main__ import main
from olp.robots.robot import load_robot
from olp.transpile import Context
from olp.transpile.compare import compare_plans
from olp.transpile.context import Mapping
from olp.transpile.convert import convert, run_converted
from olp.transpile.link import link
from tests.translate_programs import Maker

SAMPLES = Path(__file__).parent.parent / "samples"
HANDLING = {
    "rapid/handling.mod": "kuka/kr16-2",
    "tp/handling.ls": "yaskawa/gp25",
    "inform/handling/HANDLING.JBI": "yaskawa/gp25",
    "urscript/handling.script": "universal-robots/ur10e",
}
CELL = """MODULE Cell
  PERS tooldata tGrip:=[TRUE,[[0,0,120],[1,0,0,0]],[1,[0,0,1],[1,0,0,0],0,0,0]];
  PERS wobjdata wFix:=[FALSE,TRUE,"",[[600,100,300],[1,0,0,0]],[[0,0,0],[1,0,0,0]]];
  CONST jointtarget home:=[[5,-10,20,3,40,15],[9E9,9E9,9E9,9E9,9E9,9E9]];
  CONST robtarget pick:=[[110.5,45.25,60],[0,1,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
  CONST robtarget mid:=[[150,80,90],[0,1,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
  CONST robtarget place:=[[210,45,60],[0,1,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
  VAR robtarget computed:=[[210,45,60],[0,1,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
  PROC main()
%s
  ENDPROC
ENDMODULE
"""
ON = "tGrip\\WObj:=wFix"
BODY = f"""    MoveAbsJ home\\NoEOffs,v1000,fine,tGrip;
    MoveL pick,v200,z10,{ON}; ! down
    MoveC mid,place,v100,fine,{ON};"""


def forms(tmp_path, body, robot="kuka/kr16-2", **more):
    """(.src, .dat, the translation) of a RAPID routine."""
    (tmp_path / "cell.mod").write_text(CELL % body)
    program = link(olp.read(tmp_path / "cell.mod")).program
    made = convert(program, "krl", Context(load_robot(robot), forms=True, **more))
    return made.files["main.src"].decode(), made.files["main.dat"].decode(), made


def test_a_line_is_the_fold_that_the_pendant_writes(tmp_path):
    src, dat, _ = forms(tmp_path, BODY)
    assert (
        "; down\n"
        ";FOLD LIN pick CONT Vel=0.2 m/s CPDAT1 Tool[1]:tGrip Base[1]:wFix;%{PE}%R 8.3.38,%MKUKATPBASIS,%CMOVE,%VLIN,"
        "%P 1:LIN, 2:pick, 3:C_DIS C_DIS, 5:0.2, 7:CPDAT1\n"
        "$BWDSTART=FALSE\nLDAT_ACT=LCPDAT1\nFDAT_ACT=Fpick\nBAS (#CP_PARAMS,0.2 )\nLIN Xpick C_DIS C_DIS\n;ENDFOLD\n"
    ) in src.replace("\r\n", "\n")
    assert 'DECL FDAT Fpick={TOOL_NO 1,BASE_NO 1,IPO_FRAME #BASE,POINT2[] " ",TQ_STATE FALSE}' in dat
    assert re.search(r"DECL E6POS Xpick=\{X 110.5,Y 45.25,Z 60,", dat)
    assert re.search(r"DECL LDAT LCPDAT1=\{VEL 2,ACC 100,APO_DIST 10,.*ORI_TYP #VAR,CIRC_TYP #BASE", dat)


def test_a_joint_move_that_stops_and_an_arc_have_their_forms(tmp_path):
    src, dat, _ = forms(tmp_path, BODY)
    assert re.search(
        r";FOLD PTP home Vel=(\d+) % PDAT1 Tool\[1\]:tGrip Base\[0\];.*%VPTP,%P 1:PTP, 2:home, 3:, 5:\1, 7:PDAT1",
        src,
    )
    assert re.search(
        r"PDAT_ACT=PPDAT1\s+FDAT_ACT=Fhome\s+BAS \(#PTP_PARAMS,\d+ \)\s+PTP Xhome\s+;ENDFOLD", src
    )
    assert "DECL E6AXIS Xhome={A1 5,A2 -10,A3 20,A4 3,A5 40,A6 15}" in dat
    assert ";FOLD CIRC mid place Vel=0.1 m/s CPDAT2 " in src
    assert "%VCIRC,%P 1:CIRC, 2:mid, 3:place, 4:, 6:0.1, 8:CPDAT2" in src
    assert re.search(r"FDAT_ACT=Fplace\s+BAS \(#CP_PARAMS,0.1 \)\s+CIRC Xmid,Xplace\s+;ENDFOLD", src)


@pytest.mark.parametrize("name", HANDLING)
def test_forms_and_plain_statements_make_one_plan(name):
    robot = load_robot(HANDLING[name])
    program = link(olp.read(SAMPLES / name)).program
    made = [convert(program, "krl", Context(robot, forms=on)) for on in (True, False)]
    text = made[0].files[made[0].main].decode()
    assert text.count("$BWDSTART") >= 5
    plans = [run_converted(one, "krl", robot, program) for one in made]
    assert not compare_plans(*plans).differences


@pytest.mark.parametrize("seed", range(8))
def test_random_programs_with_forms_run_as_the_plain_ones(seed):
    robot = load_robot("yaskawa/gp25")
    program = Maker(seed).program()
    made = [convert(program, "krl", Context(robot, forms=on)) for on in (True, False)]
    assert not compare_plans(*[run_converted(one, "krl", robot) for one in made]).differences


@pytest.mark.parametrize(
    "move",
    [
        "MoveL Offs(pick,0,0,50),v200,fine," + ON,
        "MoveL computed,v200,fine," + ON,
        "MoveL pick,v4000,fine," + ON,
        "MoveL pick,v200,fine,tGrip",
    ],
    ids=["offset", "computed", "faster than the field takes", "another frame than the point has"],
)
def test_what_no_form_says_stays_plain(tmp_path, move):
    body = f"    computed:=pick;\n    computed.trans.z:=75;\n    MoveJ pick,v1000,fine,{ON};\n    {move};"
    src, _, _ = forms(tmp_path, body)
    assert src.count("$BWDSTART") == 1
    assert re.search(r"^LIN ", src, re.MULTILINE)


def test_numbers_of_the_mapping_file_are_the_fields_and_names_stay_plain(tmp_path):
    given = Mapping(tools={"tGrip": "7"}, frames={"wFix": "3"}, set_values=False)
    src, dat, _ = forms(tmp_path, BODY, mapping=given)
    assert "Fpick={TOOL_NO 7,BASE_NO 3" in dat
    assert "TOOL_DATA[7]=" not in src
    src, dat, _ = forms(tmp_path, BODY, mapping=Mapping(tools={"tGrip": "MY_TOOL"}))
    assert "$TOOL=TOOL_DATA" not in src
    assert "BWDSTART" not in src


def test_names_that_are_taken_or_too_long_make_no_form(tmp_path):
    long = "a_point_of_24_letters_xy"
    body = f"    VAR num Xmid;\n    Xmid:=1;\n    MoveL mid,v100,fine,{ON};\n    MoveL {long},v100,fine,{ON};"
    cell = CELL.replace("CONST robtarget place", f"CONST robtarget {long}")
    (tmp_path / "cell.mod").write_text(cell % body)
    program = link(olp.read(tmp_path / "cell.mod")).program
    made = convert(program, "krl", Context(load_robot("kuka/kr16-2"), forms=True))
    assert b"BWDSTART" not in made.files["main.src"]


def test_programs_of_cam_have_no_forms(tmp_path):
    rows = "\n".join(
        f"    MoveL [[{n / 10},45,60],[0,1,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]],v100,z1,{ON};"
        for n in range(1001)
    )
    src, dat, _ = forms(tmp_path, rows)
    assert "BWDSTART" not in src
    assert "DECL FDAT" not in dat
    few, listed, _ = forms(tmp_path, "\n".join(rows.splitlines()[:3]))
    assert re.findall(r"^LIN (\S+)", few, re.MULTILINE) == ["XP1", "XP2", "XP3"]
    assert re.search(r"DECL E6POS XP3=\{X 0.2,", listed)


def test_plain_is_an_option_of_the_command(tmp_path, capsys):
    where = [str(SAMPLES / "tp" / "handling.ls"), "--to", "krl", "--robot", "yaskawa/gp25"]
    assert main(["convert", *where, "-o", str(tmp_path / "forms")]) == 0
    assert main(["convert", *where, "-o", str(tmp_path / "plain"), "--plain"]) == 0
    texts = [(tmp_path / name / "HANDLING.src").read_text() for name in ("forms", "plain")]
    assert [";FOLD PTP" in text for text in texts] == [True, False]
    assert ["$ACC_AXIS[1]=100" in text for text in texts] == [False, True]
    assert "--plain writes 100 %" in capsys.readouterr().out
