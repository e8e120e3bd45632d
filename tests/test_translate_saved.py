"""Values that a program does not set itself come from what the controller keeps: VAR.DAT, and olp.toml, which wins."""

from __future__ import annotations

import shutil
from pathlib import Path

import numpy as np
import pytest

import olp
from olp.ir.expressions import PositionLiteral
from olp.robots.robot import load_robot
from olp.transpile.context import Context
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
