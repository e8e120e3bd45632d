"""Files that hold data and nothing that runs: a list for KRL, a module for RAPID, elsewhere an error that says why."""

import math
from pathlib import Path

import pytest

import olp
from olp.__main__ import main
from olp.core.diagnostic import OlpError
from olp.ir.expressions import PositionLiteral
from olp.robots.geometry import Pose
from olp.transpile import Context
from olp.transpile.convert import convert

MODULE = """MODULE Points
  PERS tooldata tGun:=[TRUE,[[12,-7,150],[0.96592583,0,0.25881905,0]],[1,[0,0,1],[1,0,0,0],0,0,0]];
  CONST robtarget pHome:=[[612,-85,734],[0.0123,0.7,0.714,0.0056],[0,-1,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
  CONST jointtarget jPark:=[[11,-20,30,5,60,10],[9E9,9E9,9E9,9E9,9E9,9E9]];
  PERS num nCount:=12;
  LOCAL VAR num nOwn:=3;
  VAR num nRow{3}:=[4,6,9];
  CONST speeddata vSlow:=[120,50,500,100];
ENDMODULE
"""
LIST = """DEFDAT CELL PUBLIC
DECL GLOBAL E6POS XHOME={X 612,Y -85,Z 734,A 12,B 3,C -145,S 2,T 2,E1 0,E2 0,E3 0,E4 0,E5 0,E6 0}
DECL GLOBAL INT COUNT=12
DECL CHAR NAME[20]
NAME[]="some text"
ENDDAT
"""
FILES = {"rapid": ("Points.mod", MODULE), "krl": ("CELL.DAT", LIST)}


def source(folder, vendor):
    name, text = FILES[vendor]
    path = folder / name
    path.write_text(text.replace("\n", "\r\n"))
    return path


def again(made, folder):
    """The only file that was written, read as a user would."""
    ((name, data),) = made.files.items()
    assert name == made.main
    (folder / name).write_bytes(data)
    program = olp.read(folder / name)
    assert not [d.render() for d in program.diagnostics if d.is_error]
    return program


def values(program):
    return {d.name: d for d in program.data}


def test_a_module_of_data_is_a_list_that_other_programs_of_krl_use(tmp_path):
    program = olp.read(source(tmp_path, "rapid"))
    made = convert(program, "krl")
    assert list(made.files) == ["Points.dat"]
    found = values(again(made, tmp_path))
    before = values(program)
    assert set(found) == set(before) - {"vSlow"}
    for name in ("pHome", "jPark"):
        one, other = before[name].value, found[name].value
        assert isinstance(one, PositionLiteral)
        assert one.kind == other.kind
        if one.kind == "joint":
            assert other.values[:6] == pytest.approx(one.values[:6])
        else:
            apart = Pose.from_xyz_angles(one.values[:6]).inverse() @ Pose.from_xyz_angles(other.values[:6])
            assert apart.xyz_angles() == pytest.approx((0.0,) * 6, abs=1e-7)
    tool = found["tGun"].value.values
    assert tool[:3] == pytest.approx((0.012, -0.007, 0.150))
    assert math.degrees(tool[4]) == pytest.approx(30.0, abs=1e-5)
    assert {name: one.shared for name, one in found.items()} == {name: name != "nOwn" for name in found}
    assert [e.value for _, e in found["nRow"].value.members] == [4, 6, 9]
    told = [x.says for x in made.translated.losses]
    assert told == ["vSlow is left out: KRL has no data of the type speeddata"]


def test_a_program_of_krl_finds_the_data_of_such_a_list(tmp_path):
    again(convert(olp.read(source(tmp_path, "rapid")), "krl"), tmp_path)
    (tmp_path / "part.src").write_text("DEF PART()\nPTP jPark\nLIN pHome\nWAIT SEC nCount\nEND\n")
    plan = olp.read(tmp_path / "part.src").plan()
    assert not [d.render() for d in plan.diagnostics if d.is_error and d.code != "I001"]
    assert plan.positions.position[plan.moves.target[-1]] == pytest.approx((0.612, -0.085, 0.734))
    assert plan.durations.tolist() == pytest.approx([12.0])


def test_a_list_of_krl_is_a_module_of_data(tmp_path):
    made = convert(olp.read(source(tmp_path, "krl")), "rapid")
    program = again(made, tmp_path)
    assert not program.routines
    found = values(program)
    assert found["XHOME"].value.values[:3] == pytest.approx((0.612, -0.085, 0.734))
    assert found["COUNT"].value.value == 12
    assert found["NAME"].value.value == "some text"
    assert [name for name, one in found.items() if one.shared] == ["XHOME", "COUNT"]


@pytest.mark.parametrize("vendor", FILES)
def test_data_in_their_own_language_stay_a_file_of_data(tmp_path, vendor):
    path = source(tmp_path, vendor)
    made = convert(olp.read(path), vendor)
    ((name, _),) = made.files.items()
    assert name.casefold() == path.name.casefold()


@pytest.mark.parametrize("vendor", FILES)
@pytest.mark.parametrize("target", ["inform", "tp", "urscript"])
def test_other_languages_have_no_file_for_data_alone(tmp_path, vendor, target, capsys):
    path = source(tmp_path, vendor)
    for arguments in (
        ["convert", str(path), "--to", target, "-o", str(tmp_path / "out")],
        ["export", str(path), "--to", target, "-o", str(tmp_path / "out")],
    ):
        assert main(arguments) == 2
        told = capsys.readouterr().err
        assert "error[X014]: this file holds data and nothing that runs" in told
        assert "convert the program that uses it" in told
    assert not (tmp_path / "out").exists()


def test_in_a_folder_such_a_file_becomes_a_part_of_what_uses_it(tmp_path, capsys):
    source(tmp_path, "rapid")
    (tmp_path / "part.mod").write_text(
        "MODULE Part\nPROC main()\nMoveAbsJ jPark,v100,fine,tool0;\nENDPROC\nENDMODULE\n"
    )
    arguments = ["--robot", "yaskawa/gp25", "-o", str(tmp_path / "out")]
    assert main(["convert", str(tmp_path), "--to", "tp", *arguments]) == 0
    told = capsys.readouterr()
    assert "X014" not in told.err
    assert "both run: 1 steps" in told.out
    assert [path.name for path in (tmp_path / "out").iterdir()] == ["main.ls"]


def test_in_a_folder_a_file_that_nothing_uses_is_a_warning(tmp_path, capsys):
    source(tmp_path, "rapid")
    (tmp_path / "part.mod").write_text("MODULE Part\nPROC main()\nWaitTime 1;\nENDPROC\nENDMODULE\n")
    assert main(["convert", str(tmp_path), "--to", "tp", "-o", str(tmp_path / "out")]) == 0
    assert "warning[X014]" in capsys.readouterr().err
    assert [path.name for path in (tmp_path / "out").iterdir()] == ["main.ls"]


def test_nothing_that_runs_cannot_be_run_flat(tmp_path):
    with pytest.raises(OlpError) as caught:
        convert(olp.read(source(tmp_path, "rapid")), "krl", Context(flat=True))
    assert [d.code for d in caught.value.diagnostics] == ["X014"]


def test_the_receipt_says_that_nothing_runs_and_asks_for_no_run(tmp_path, capsys):
    path = source(tmp_path, "krl")
    assert main(["convert", str(path), "--to", "rapid", "-o", str(tmp_path / "out")]) == 0
    told = capsys.readouterr().out
    assert "nothing in it runs: it holds data" in told
    assert "could not be run" not in told
    assert "step through it" not in told


def test_a_project_that_only_names_its_programs_is_no_empty_module():
    """A .pjx became an empty module, "0 statements: all exact"."""
    project = Path(__file__).parent.parent / "samples" / "val3" / "handling.pjx"
    for target in ("rapid", "krl", "tp"):
        with pytest.raises(OlpError) as told:
            convert(olp.read(project), target)
        assert told.value.diagnostics[0].code == "X014"
