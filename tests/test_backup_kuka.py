"""`olp robot import` of a KUKA archive: its machine data become a robot file, or are refused with their line."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import RigidTransform, Rotation

from olp.__main__ import main
from olp.core.diagnostic import OlpError
from olp.core.units import mm
from olp.robots.backup.machine_dat import find_machine_data, machine_data_toml, read_machine_data
from olp.robots.kinematics import forward
from olp.robots.robot import Robot, load_robot

# An arm that does not exist, in the layout of real files; two of its axes turn otherwise than KUKA's usually do.
LIMITS = ((-171, 172), (-143, 21), (-113, 151), (-331, 332), (-121, 122), (-345, 346))
MOTORS = (4200, 4100.5, 4300, 5100, 5200, 5300)
RATIOS = ((-1601, 7), (-2203, 9), (1903, 8), (-1101, 11), (-1207, 13), (607, 10))
DIRECTIONS = (-1, 1, -1, -1, -1, 1)


def machine_data() -> list[str]:
    rows = [
        "&ACCESS RV$",
        "DEFDAT  $MACHINE PUBLIC",
        "CHAR $V_R1MADA[32]",
        '$V_R1MADA[]="V8.5.7/KUKA8.5" ;VERSION; OF THIS FILE',
        "INT $NUM_AX=6 ;AXES",
        "CHAR $TRAFONAME[32] ;NAME",
        '$TRAFONAME[]="#KR45R2345_2 C4 FLR" ;NAME',
        "DECL KINCLASS $KINCLASS=#STANDARD ;CLASS",
        "DECL MAIN_AXIS $MAIN_AXIS=#NR ;AXES 1 TO 3",
        "DECL WRIST_AXIS $WRIST_AXIS=#ZEH ;WRIST",
        "INT $A4PAR=0 ;AXIS 4",
        "FRAME $TIRORO={X 0.0,Y 0.0,Z 487.500,A 0.0,B 0.0,C 0.0} ;TO AXIS 2",
        "FRAME $TFLWP={X 0.0,Y 0.0,Z 141.000,A 0.0,B 0.0,C 0.0} ;FLANGE",
        "FRAME $TX3P3={X 911.000,Y 0.0,Z -47.5000,A 0.0,B 90.0000,C 0.0} ;WRIST",
        "REAL $LENGTH_A=251.000 ;A",
        "REAL $LENGTH_B=1.033E+3 ;B",
        "DECL DHART $DH_4={DHART_A 0.0,DHART_D 0.0,DHART_ALPHA 90.0000} ;A4",
        "DECL DHART $DH_5={DHART_A 0.0,DHART_D 0.0,DHART_ALPHA -90.0000} ;A5",
        "DECL TRPSPIN $TRP_A={TRPSP_AXIS 0,TRPSP_COP_AX 0,TRPSP_A 0.0} ;ROD",
    ]
    for n in range(6):
        rows += [
            f"$AXIS_DIR[{n + 1}]={DIRECTIONS[n]}",
            f"$SOFTN_END[{n + 1}]={LIMITS[n][0]:.3f}",
            f"$SOFTP_END[{n + 1}]={LIMITS[n][1]:.3f}",
            f"$VEL_AXIS_MA[{n + 1}]={MOTORS[n]}",
            f"$RAT_MOT_AX[{n + 1}]={{N {RATIOS[n][0]},D {RATIOS[n][1]}}}",
        ]
    return [*rows, "ENDDAT"]


ROWS = machine_data()


def archive(folder: Path, rows: list[str] = ROWS) -> Path:
    mada = folder / "KRC" / "R1" / "Mada"
    mada.mkdir(parents=True, exist_ok=True)
    (mada / "$machine.dat").write_text("\r\n".join(rows), encoding="cp1252", newline="")
    return folder


def imported(folder: Path, rows: list[str] = ROWS) -> Robot:
    machine = find_machine_data(archive(folder, rows))
    assert machine is not None
    file = folder / "robot.toml"
    file.write_text(machine_data_toml(read_machine_data(machine)), encoding="utf-8")
    return load_robot(file)


def test_the_arm_is_that_of_the_machine_data(tmp_path: Path) -> None:
    robot = imported(tmp_path)
    assert (robot.name, robot.controllers, robot.axis_names) == (
        "kuka/kr45-r2345-2", ("KSS 8.5",), ("A1", "A2", "A3", "A4", "A5", "A6"),
    )  # fmt: skip
    np.testing.assert_allclose(np.degrees([robot.lower, robot.upper]).T, LIMITS, atol=1e-9)
    speeds = [motor * 360 / 60 / abs(n / d) for motor, (n, d) in zip(MOTORS, RATIOS, strict=True)]
    np.testing.assert_allclose(np.degrees(robot.speeds), speeds, atol=0.006)
    assert not robot.pose_verified


def test_its_flange_is_where_the_controllers_own_chain_ends(tmp_path: Path) -> None:
    robot = imported(tmp_path)
    joints = np.random.default_rng(4).uniform(robot.lower, robot.upper, (20, 6))

    def shift(x: float, y: float, z: float) -> RigidTransform:
        return RigidTransform.from_translation(np.array([x, y, z]) * mm)

    def turn(axis: str, angle: float) -> RigidTransform:
        return RigidTransform.from_rotation(Rotation.from_euler(axis, angle, degrees=True))

    for row, position, rotation in zip(joints, *forward(robot, joints), strict=True):
        a1, a2, a3, a4, a5, a6 = np.degrees(row) * DIRECTIONS
        arm = shift(0, 0, 487.5) * turn("z", a1) * shift(251, 0, 0) * turn("y", a2) * shift(1033, 0, 0)
        wrist = turn("y", a3) * shift(911, 0, -47.5) * turn("y", 90) * turn("z", a4) * turn("x", 90)
        end = arm * wrist * turn("z", a5) * turn("x", -90) * turn("z", a6) * shift(0, 0, 141)
        np.testing.assert_allclose(position, end.translation, atol=1e-12)
        np.testing.assert_allclose(rotation, end.rotation.as_matrix(), atol=1e-12)


@pytest.mark.parametrize("below", ["", "KRC", "KRC/R1", "KRC/R1/Mada", "KRC/R1/Mada/$machine.dat"])
def test_the_archive_or_any_folder_within_it_may_be_named(tmp_path: Path, below: str) -> None:
    archive(tmp_path)
    found = find_machine_data(tmp_path / below)
    assert found is not None
    assert found.name == "$machine.dat"


def test_a_folder_without_machine_data_has_none(tmp_path: Path) -> None:
    (tmp_path / "KRC" / "STEU" / "Mada").mkdir(parents=True)
    (tmp_path / "KRC" / "R1" / "Mada" / "$machine.dat").mkdir(parents=True)  # not a file
    assert find_machine_data(tmp_path) is None
    assert find_machine_data(tmp_path / "gone") is None


def test_the_command_writes_the_file(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out = tmp_path / "mine.toml"
    assert main(["robot", "import", str(archive(tmp_path)), "-o", str(out), "--name", "kuka/cell-4"]) == 0
    assert load_robot(out).name == "kuka/cell-4"
    assert not capsys.readouterr().err
    assert main(["robot", "import", str(tmp_path), "-o", str(out)]) == 2
    assert "C009" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("old", "new", "code"),
    [
        ("$WRIST_AXIS=#ZEH", "$WRIST_AXIS=#SRH", "B006"),
        ("$KINCLASS=#STANDARD", "$KINCLASS=#SPECIAL", "B006"),
        ("$NUM_AX=6", "$NUM_AX=4", "B006"),
        ("$A4PAR=0", "$A4PAR=1", "B006"),
        ("TRPSP_AXIS 0", "TRPSP_AXIS 3", "B006"),
        ("X 911.000,Y 0.0", "X 911.000,Y 2.5", "B006"),
        ("DHART_ALPHA -90.0000", "DHART_ALPHA -60.0000", "B006"),
        ("X 0.0,Y 0.0,Z 487.500", "X 25.0,Y 0.0,Z 487.500", "B006"),
        ("$LENGTH_A=251.000", "$LENGTH_A=long", "B003"),
        ("$LENGTH_B=1.033E+3", "$LENGTH_B=-1033", "B007"),
        ("$AXIS_DIR[1]=-1", "$AXIS_DIR[1]=2", "B007"),
        ("{N -1601,D 7}", "{N -1601,D 0}", "B007"),
        ("{N -1601,D 7}", "{N -1601}", "B009"),
        ("$SOFTN_END[1]=-171.000", "$SOFTN_END[1]=271.000", "B007"),
        ("#KR45R2345_2 C4 FLR", "#SPECIAL", "B009"),
    ],
)
def test_another_kind_of_arm_is_refused_at_its_row(tmp_path: Path, old: str, new: str, code: str) -> None:
    assert sum(old in row for row in ROWS) == 1
    with pytest.raises(OlpError) as caught:
        imported(tmp_path, [row.replace(old, new) for row in ROWS])
    (only,) = caught.value.diagnostics
    assert only.code == code
    at = next(n for n, row in enumerate(ROWS, start=1) if old in row)
    assert only.line == (at if code != "B009" or "{" in old else 0)


@pytest.mark.parametrize("left_out", [n for n, row in enumerate(ROWS) if "=" in row])
def test_a_row_that_is_missing_is_told_or_not_needed(tmp_path: Path, left_out: int) -> None:
    rows = [row for n, row in enumerate(ROWS) if n != left_out]
    name = ROWS[left_out].split("=")[0].split()[-1]
    if name in ("$V_R1MADA[]", "$A4PAR", "$TRP_A"):
        assert imported(tmp_path, rows).geometry == imported(tmp_path).geometry
        return
    with pytest.raises(OlpError) as caught:
        imported(tmp_path, rows)
    assert any(d.code == "B009" and name.removesuffix("[]") in d.message for d in caught.value.diagnostics)


@pytest.mark.parametrize("content", [b"", b"\x00\xff\xfe", b"DEFDAT $MACHINE\nENDDAT", b"$LENGTH_A=" * 400])
def test_what_is_no_machine_data_is_refused(tmp_path: Path, content: bytes) -> None:
    file = tmp_path / "$MACHINE.DAT"
    file.write_bytes(content)
    with pytest.raises(OlpError):
        machine_data_toml(read_machine_data(file))


def test_an_arm_that_does_not_stand_at_the_worlds_origin_is_told(tmp_path: Path) -> None:
    for root, told in (("Z 0.0", []), ("Z 350.000", ["B008"])):
        machine = find_machine_data(archive(tmp_path, [f"FRAME $ROBROOT={{X 0.0,{root},A 0.0}}", *ROWS]))
        assert machine is not None
        data = read_machine_data(machine)
        assert machine_data_toml(data)
        assert [d.code for d in data.findings.all()] == told


def test_a_name_that_is_none_is_refused(tmp_path: Path) -> None:
    machine = find_machine_data(archive(tmp_path))
    assert machine is not None
    with pytest.raises(OlpError) as caught:
        machine_data_toml(read_machine_data(machine), "cell 4")
    assert [d.code for d in caught.value.diagnostics] == ["B010"]
