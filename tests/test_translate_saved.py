"""Values that a program does not set itself come from what the controller keeps: VAR.DAT, and olp.toml, which wins."""

from __future__ import annotations

import shutil
from pathlib import Path

import numpy as np
import pytest
from translated_texts import converted, module

import olp
from olp.ir.expressions import PositionLiteral
from olp.robots.robot import load_robot
from olp.transpile.context import Context, Fate
from olp.transpile.convert import convert
from olp.transpile.link import link
from olp.transpile.pipeline import canonical

SAMPLE = Path(__file__).parent.parent / "samples" / "inform" / "palletising"
ROBOT = load_robot("yaskawa/ar2010")


def translated(path: Path, target: str = "krl"):
    return canonical(olp.read(path), target, Context(robot=ROBOT, on_loss="comment"))


def declared(program, name: str):
    found = {d.name: d.value for r in program.routines for d in r.data} | {
        d.name: d.value for d in program.data
    }
    return found[name]


def test_a_position_of_the_controller_is_where_the_plan_goes() -> None:
    path = SAMPLE / "PICK.JBI"
    literal = declared(translated(path).program, "PV20")
    assert isinstance(literal, PositionLiteral)
    assert literal.kind == "joint"
    plan = olp.read(path).plan(robot=ROBOT.name)
    first = plan.positions.axes[plan.moves.target[0]]
    assert np.abs(np.array(literal.values) - first).max() < 1e-12


def test_without_the_controllers_file_zeros_are_told(tmp_path: Path) -> None:
    shutil.copy(SAMPLE / "PICK.JBI", tmp_path)
    found = translated(tmp_path / "PICK.JBI")
    assert declared(found.program, "PV20").values == (0.0,) * 6
    told = [loss for loss in found.losses if loss.part == "position"]
    assert [loss.line for loss in told] == [21]
    assert "no VAR.DAT or olp.toml holds it" in told[0].says


def test_olp_toml_wins_over_var_dat(tmp_path: Path) -> None:
    for name in ("PICK.JBI", "VAR.DAT"):
        shutil.copy(SAMPLE / name, tmp_path)
    pulses = [-23252, -25038, -66049, -4838, -35806, 11014]
    (tmp_path / "olp.toml").write_text(f"[variables]\nP020 = {{ pulse = {pulses} }}\n")
    literal = declared(translated(tmp_path / "PICK.JBI").program, "PV20")
    per_radian = [axis.pulses_per_unit for axis in ROBOT.axes]
    assert literal.values == pytest.approx([n / ratio for n, ratio in zip(pulses, per_radian, strict=True)])


def test_a_header_wins_over_both(tmp_path: Path) -> None:
    for name in ("PICK.JBI", "VAR.DAT"):
        shutil.copy(SAMPLE / name, tmp_path)
    (tmp_path / "olp.toml").write_text(
        '[variables]\nP030 = { pose_mm_deg = [9, 9, 9, 0, 0, 0], frame = "base" }\n'
    )
    literal = declared(translated(tmp_path / "PICK.JBI").program, "PV30")
    assert literal.values[2] == pytest.approx(0.1825)


def test_numbers_keep_their_values_where_data_stand_beside_the_program() -> None:
    found = translated(SAMPLE / "MAIN.JBI").program
    held = {d.name: getattr(d.value, "value", None) for d in found.data}
    assert held["B10"] == 3  # olp.toml; VAR.DAT has another recipe


@pytest.mark.parametrize("target", ["krl", "rapid", "tp", "urscript"])
def test_nothing_of_the_first_move_is_lost(target: str) -> None:
    found = translated(SAMPLE / "PICK.JBI", target)
    assert not [loss for loss in found.losses if loss.line == 21 and loss.part in ("position", "frame")]


# --- Data that live on ---------------------------------------------------------------------------------------

LIST = (
    "DEFDAT PART\nINT N=0\nINT M=0\nE6POS P={X 1,Y 2,Z 3,A 0,B 0,C 0}\n"
    "E6AXIS Q={A1 0,A2 0,A3 0,A4 0,A5 0,A6 0}\nENDDAT\n"
)
LASTS = ("N=N+1", "WAIT SEC N")  # a counter
ENDS = ("M=1", "WAIT SEC M", "P.X=5", "LIN P", "Q.A5=2", "PTP Q")  # what is read of them was set before


def lists(tmp_path: Path, target: str, *rows: str):
    (tmp_path / "part.src").write_text("\n".join(["DEF PART ( )", *rows, "END", ""]))
    (tmp_path / "part.dat").write_text(LIST)
    program = link(olp.read(tmp_path / "part.src")).program
    return convert(program, target, Context(load_robot("kuka/kr16-2"), on_loss="comment"))


@pytest.mark.parametrize("target", ["tp", "inform", "urscript"])
def test_a_counter_of_a_list_that_begins_anew_is_told(tmp_path: Path, target: str) -> None:
    told = [
        loss
        for loss in lists(tmp_path, target, *LASTS, *ENDS).translated.losses
        if "keeps its last" in loss.says
    ]
    assert [(loss.line, loss.says.split()[0], loss.fate) for loss in told] == [(2, "N", Fate.APPROXIMATED)]


def test_a_counter_of_a_list_is_persistent_in_rapid(tmp_path: Path) -> None:
    made = lists(tmp_path, "rapid", *LASTS, *ENDS)
    text = made.files[made.main].decode()
    assert "PERS num N:=0;" in text
    assert "VAR num M:=0;" in text
    assert not [loss for loss in made.translated.losses if "keeps its last" in loss.says]


def test_a_persistent_variable_of_rapid_begins_anew_in_tp_and_is_told() -> None:
    text = module("n:=n+1;", "WaitTime n;", data=("PERS num n:=0;", "VAR num m:=0;"))
    told = [
        loss.says
        for loss in converted(text, "rapid", "tp").translated.losses
        if "keeps its last" in loss.says
    ]
    assert [says.split()[0] for says in told] == ["n"]


SHIFTED = (
    'PERS wobjdata w1:=[FALSE,TRUE,"",[[100,0,0],[1,0,0,0]],[[0,0,0],[1,0,0,0]]];',
    "PERS robtarget q{2}:=[[[400,0,300],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]],"
    "[[400,0,320],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]]];",
    "PERS robtarget p:=[[400,0,300],[0,0,1,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];",
)


@pytest.mark.parametrize(
    ("target", "rows", "names"),
    [
        ("tp", ("MoveL p,v100,fine,tool0\\WObj:=w1;", "w1.uframe.trans.z:=w1.uframe.trans.z+25;"), ["w1"]),
        ("urscript", ("MoveL p,v100,fine,tool0\\WObj:=w1;", "w1.uframe.trans.z:=w1.uframe.trans.z+25;"), ["w1"]),
        ("krl", ("MoveL p,v100,fine,tool0\\WObj:=w1;", "w1.uframe.trans.z:=w1.uframe.trans.z+25;"), []),
        ("tp", ("MoveL p,v100,fine,tool0;", "p.trans.z:=p.trans.z-10;"), ["p"]),
        ("inform", ("MoveL p,v100,fine,tool0;", "p.trans.z:=p.trans.z-10;"), []),
        ("inform", ("MoveL q{1},v100,fine,tool0;", "q{1}:=Offs(q{1},0,0,-10);"), []),
    ],
)  # fmt: skip
def test_what_begins_anew_elsewhere_is_told_of_tools_frames_and_positions_too(target, rows, names) -> None:
    """P variables of INFORM hold what the last run left in them; a register is set at each start."""
    text = module(*rows, data=SHIFTED)
    told = [
        loss.says
        for loss in converted(text, "rapid", target).translated.losses
        if "keeps its last" in loss.says
    ]
    assert [says.split()[0] for says in told] == names
