"""The table [dynamics] of robot files: published numbers are the published ones, mistakes are shown at their word."""

import math
import tomllib
from pathlib import Path

import numpy as np
import pytest

import olp.robots
from olp.core.diagnostic import OlpError
from olp.robots.dynamics import dynamic_model, gravity_torques
from olp.robots.model import tensor
from olp.robots.robot import Body, Drive, load_robot

FILES = sorted(Path(olp.robots.__file__).parent.glob("*/*.toml"))
DOCS = Path(__file__).parent.parent / "docs" / "dynamics.md"

OWN = """
maker = "Own"
model = "Lift"
axes = [
  { name = "Z", lower_mm = 0, upper_mm = 900, speed_mm_s = 500 },
  { name = "C", lower_deg = -90, upper_deg = 90, speed_deg_s = 100 },
]
[chain]
joints = [ { axis = "Z", direction = "+z" }, { axis = "C", direction = "+y", offset_mm = [100, 0, 0] } ]
[dynamics]
bodies = [
  { axis = "C", mass_kg = 12.5, centre_mm = [200, 30, 40], inertia_kg_m2 = [0.11, 0.12, 0.13, 0.01, 0.02, 0.03] },
  { axis = "Z", mass_kg = 40 },
]
drives = [
  { axis = "Z", force_n = 900, rotor_mass_kg = 8, viscous_n_s_m = 55, coulomb_n = 21 },
  { axis = "C", torque_nm = 70, rotor_inertia_kg_m2 = 0.4, viscous_nm_s_rad = 3, coulomb_nm = 5 },
]
[sources]
limits = "drawing"
speed = "drawing"
chain = "drawing"
masses = "scales"
inertias = "drawing"
torque_limits = "catalogue"
rotors = "catalogue"
friction = "measured"
"""

# Universal Robots, DH Parameters for calculations of kinematics and dynamics, UR10e: a, d [m], alpha [quarter turns],
# mass [kg], centre [m] and inertia [kg m²] in the Denavit-Hartenberg frame of the link (which is at its far end).
UR10E = [
    (0.0, 0.1807, 1, 7.369, (0.021, 0.0, 0.027), (0.0341, 0.0, -0.0043, 0.0353, 0.0001, 0.0216)),
    (-0.6127, 0.0, 0, 13.051, (0.38, 0.0, 0.158), (0.0281, 0.0001, -0.0156, 0.7707, 0.0, 0.7694)),
    (-0.57155, 0.0, 0, 3.989, (0.24, 0.0, 0.068), (0.0101, 0.0001, 0.0092, 0.3093, 0.0, 0.3065)),
    (0.0, 0.17415, 1, 2.1, (0.0, 0.007, 0.018), (0.0030, 0.0, 0.0, 0.0022, -0.0002, 0.0026)),
    (0.0, 0.11985, -1, 1.98, (0.0, 0.007, 0.018), (0.0030, 0.0, 0.0, 0.0022, -0.0002, 0.0026)),
    (0.0, 0.11655, 0, 0.615, (0.0, 0.0, -0.026), (0.0, 0.0, 0.0, 0.0004, 0.0, 0.0003)),
]


def written(folder, text):
    path = folder / "own.toml"
    path.write_text(text, encoding="utf-8")
    return path


def quarter(turns):
    c, s = round(math.cos(turns * math.pi / 2)), round(math.sin(turns * math.pi / 2))
    return np.array([[1, 0, 0], [0, c, -s], [0, s, c]])


def test_the_ur10e_holds_its_makers_table():
    robot = load_robot("ur10e")
    frame, place = np.eye(3), np.zeros(3)
    joint_place = np.zeros(3)
    for joint, body, (a, d, turns, mass, centre, inertia) in zip(
        robot.geometry.joints, robot.dynamics.bodies, UR10E, strict=True
    ):
        joint_place = joint_place + joint.offset
        np.testing.assert_allclose(frame[:, 2], joint.direction, atol=1e-12)
        place = place + frame @ [a, 0.0, d]
        frame = frame @ quarter(turns)
        xx, xy, xz, yy, yz, zz = inertia
        theirs = frame @ np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]) @ frame.T
        np.testing.assert_allclose(joint_place + body.centre, place + frame @ centre, atol=1e-12)
        np.testing.assert_allclose(tensor(body.inertia), theirs, atol=1e-12)
        assert body.mass == mass
    np.testing.assert_allclose(joint_place + robot.geometry.flange_offset, place, atol=1e-12)
    assert [drive.limit for drive in robot.dynamics.drives] == [330, 330, 150, 56, 56, 56]


def test_the_ur10e_can_hold_its_rated_load_stretched_out_with_little_to_spare():
    robot = load_robot("ur10e")
    model = dynamic_model(robot)
    share = np.abs(gravity_torques(model, np.zeros((1, 6)), Body(robot.payload)))[0] / model.torque_limits
    assert 0.6 < share.max() < 1.0
    assert share.argmax() == 1


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.stem)
def test_a_robot_has_a_body_and_a_drive_for_every_axis_or_none_at_all(path):
    robot = load_robot(f"{path.parent.name}/{path.stem}")
    assert ("dynamics" in tomllib.loads(path.read_text(encoding="utf-8"))) == (robot.dynamics is not None)
    if robot.dynamics is not None:
        assert len(robot.dynamics.bodies) == len(robot.dynamics.drives) == len(robot.axes)
        assert {"masses"} <= set(robot.sources)
        assert robot.geometry is not None


def test_a_file_is_converted_to_si_in_the_order_of_the_axes(tmp_path):
    dynamics = load_robot(written(tmp_path, OWN)).dynamics
    assert dynamics.bodies[0] == Body(40.0)
    assert dynamics.bodies[1].centre == pytest.approx((0.2, 0.03, 0.04))
    assert dynamics.bodies[1].inertia == (0.11, 0.12, 0.13, 0.01, 0.02, 0.03)
    assert dynamics.drives == (Drive(900.0, 8.0, 55.0, 21.0), Drive(70.0, 0.4, 3.0, 5.0))
    assert dynamics.point_masses == ("Z",)


def test_drives_may_be_left_out_and_bodies_may_not(tmp_path):
    start, end = OWN.index("drives"), OWN.index("[sources]")
    sources = OWN[end : OWN.index("torque_limits")]
    robot = load_robot(written(tmp_path, OWN[:start] + sources))
    assert robot.dynamics.drives == (Drive(), Drive())
    assert np.isinf(dynamic_model(robot).torque_limits).all()
    says = dynamic_model(robot).assumptions
    assert len(says) == 3
    assert "inertias of Z are not known" in says[0]


@pytest.mark.parametrize(
    ("old", "new", "code", "row", "word", "message"),
    [
        ("mass_kg = 12.5", "mas_kg = 12.5", "R003", 12, "mas_kg", "a body has no key 'mas_kg'"),
        (", mass_kg = 40", "", "R004", 13, "axis", "the body of axis Z needs mass_kg"),
        ("mass_kg = 40", "mass_kg = -40", "R005", 13, "mass_kg", "mass_kg must not be negative"),
        ("0.11, 0.12, 0.13,", "0.11, 0.12, -0.13,", "R005", 12, "inertia_kg_m2", "without negative moments"),
        ("0.02, 0.03]", "0.02]", "R005", 12, "inertia_kg_m2", "must be 6 numbers"),
        ('  { axis = "Z", mass_kg = 40 },\n', "", "R004", 11, "bodies", "dynamics needs a body for Z"),
        ('{ axis = "Z", mass_kg', '{ axis = "C", mass_kg', "R005", 13, "axis", "bodies names axis C twice"),
        ('{ axis = "Z", force_n', '{ axis = "Q", force_n', "R005", 16, "axis", "axis must be one of Z, C, not 'Q'"),
        ("force_n", "torque_nm", "R003", 16, "torque_nm", "the drive of a sliding axis has no key 'torque_nm'"),
        ("torque_nm = 70", "torque_nm = '70'", "R005", 17, "torque_nm", "must be a number"),
        ("bodies = [", "masses = [", "R003", 11, "masses", "dynamics has no key 'masses'"),
        ('friction = "measured"\n', "", "R006", 19, "sources", "no source is stated for: friction"),
        ('rotors = "catalogue"\n', "", "R006", 19, "sources", "no source is stated for: rotors"),
        ('inertias = "drawing"\n', "", "R006", 19, "sources", "no source is stated for: inertias"),
        ('masses = "scales"\n', "", "R006", 19, "sources", "no source is stated for: masses"),
        ('torque_limits = "catalogue"\n', "", "R006", 19, "sources", "no source is stated for: torque_limits"),
    ],
)  # fmt: skip
def test_a_mistake_is_shown_at_its_word(tmp_path, old, new, code, row, word, message):
    assert OWN.count(old) == 1
    with pytest.raises(OlpError) as caught:
        load_robot(written(tmp_path, OWN.replace(old, new)))
    found = [d for d in caught.value.diagnostics if d.code == code and message in d.message]
    assert len(found) == 1
    assert found[0].line == row
    assert found[0].source_line[found[0].column - 1 : found[0].end_column - 1] == word


def test_the_example_in_the_docs_is_read(tmp_path):
    example = DOCS.read_text(encoding="utf-8").split("```toml\n")[1].split("```")[0]
    start, end = OWN.index("[dynamics]"), OWN.index("[sources]")
    dynamics = load_robot(written(tmp_path, OWN[:start] + example + OWN[end:])).dynamics
    assert all(body.mass > 0.0 for body in dynamics.bodies)
    assert all(drive.limit for drive in dynamics.drives)
