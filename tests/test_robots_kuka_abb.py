"""KUKA's and ABB's arms against the chains of their URDF packages, a controller's machine data, and known poses."""

from __future__ import annotations

import csv
import re
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import RigidTransform, Rotation

import olp
from olp.core.units import deg, mm
from olp.robots.geometry import quaternion_from_rotation
from olp.robots.kinematics import forward, within_limits
from olp.robots.kinematics.configuration import joints_of_readings, same_posture, turned_back
from olp.robots.robot import load_robot, robot_names
from olp.transpile import Context
from olp.transpile.convert import convert

ARMS = [name for name in robot_names() if name.split("/")[0] in ("kuka", "abb")]
WRIST_ARMS = [name for name in ARMS if load_robot(name).geometry.links]
FIRST = {"kuka": "kuka/kr6-r900-sixx", "abb": "abb/irb120-3-0.58"}
CANNON = [0, -90, 90, 0, 0, 0]  # KUKA's arm with its upper arm up and its forearm forward

# Four of the packages write their angles to five digits: 0.03 mm at the end of the longest.
NEAR, TURNED = 4e-5, 5e-5  # [m], [1]
ROUNDED = 0.12 * deg  # the packages' radians have three digits, the files the data sheets' whole degrees


def chains():
    with (Path(__file__).parent / "data" / "kuka_abb_chains.csv").open(encoding="utf-8") as file:
        rows = list(csv.DictReader(line for line in file if not line.startswith("#")))
    found: dict[str, list[dict[str, str]]] = {}
    for row in rows:
        found.setdefault(row["robot"], []).append(row)
    return found


CHAINS = chains()


def numbers(row, *keys):
    return np.array([float(row[key]) for key in keys])


def turning(rows):
    return [row for row in rows if row["joint"] == "axis"]


def end_of(rows, joints):
    """The frame tool0 of a URDF chain: each joint is shifted, turned, and turns about its axis."""
    pose, values = RigidTransform.identity(), iter(joints)
    for row in rows:
        turn = Rotation.from_euler("xyz", numbers(row, "roll", "pitch", "yaw"))
        pose = pose * RigidTransform.from_components(numbers(row, "x", "y", "z"), turn)
        if row["joint"] == "axis":
            axis = numbers(row, "axis_x", "axis_y", "axis_z")
            pose = pose * RigidTransform.from_rotation(Rotation.from_rotvec(axis * next(values)))
    return pose


def assert_same(pose, position, rotation, near=NEAR, turned=TURNED):
    np.testing.assert_allclose(position, pose.translation, atol=near)
    np.testing.assert_allclose(rotation, pose.rotation.as_matrix(), atol=turned)


# What another publication, the libraries of the Robots plug-in by visose (MIT), says of arms: height of axis 2 above
# the floor, a1, a2, a3, d4, d6 [mm]; a second source of those that have a chain, the only one of those behind them.
LENGTHS = {
    "abb/irb120-3-0.58": (290, 0, 270, 70, 302, 72),
    "abb/irb1200-5-0.9": (399.1, 0, 448, 42, 451, 82),
    "abb/irb1600-8-1.45": (486.5, 150, 700, 0, 600, 65),
    "abb/irb2600-12-1.65": (445, 150, 700, 115, 795, 85),
    "abb/irb4600-40-2.55": (495, 175, 1095, 175, 1270, 135),
    "abb/irb4600-60-2.05": (495, 175, 900, 175, 960, 135),
    "abb/irb6650s-125-3.50": (630, 600, 1280, 200, 1592, 200),
    "kuka/kr6-r700-sixx": (400, 25, 315, 35, 365, 80),
    "kuka/kr6-r900-sixx": (400, 25, 455, 35, 420, 80),
    "kuka/kr10-r1100-sixx": (400, 25, 560, 35, 515, 80),
    "kuka/kr210-r3300-2-k": (550, 730, 1350, 115, 1220, 240),
    "kuka/kr240-r3330": (1045, 500, 1300, -55, 1525, 290),
    "abb/irb1300-10-1.15": (544, 150, 575, 40, 425, 90),
    "abb/irb140-6-0.81": (352, 70, 360, 0, 380, 65),
    "abb/irb6620-150-2.20": (680, 320, 975, 200, 887, 200),
    "abb/irb6640-235-2.55": (780, 320, 1075, 200, 1142.5, 200),
    "abb/irb6700-150-3.20": (780, 320, 1280, 200, 1592.5, 200),
    "kuka/kr150-l110-2": (750, 350, 1250, -55, 1500, 230),
    "kuka/kr20-3": (675, 260, 680, -35, 670, 158),
    "kuka/kr210-2": (750, 350, 1250, -55, 1100, 230),
    "kuka/kr30-3": (815, 350, 850, 145, 820, 170),
    "kuka/kr60-3": (815, 350, 850, 145, 820, 170),
    "kuka/kr60-l30-3": (815, 350, 850, 145, 1220, 170),
}
# Reach [mm] by the data sheets of arms whose names do not say it.
REACHES = {
    "kuka/kr5-arc": 1412, "kuka/kr16-2": 1611, "kuka/kr20-3": 1611, "kuka/kr30-3": 2033, "kuka/kr60-3": 2033,
    "kuka/kr60-l30-3": 2429, "kuka/kr150-2": 2700, "kuka/kr210-2": 2700, "kuka/kr150-l110-2": 3100,
}  # fmt: skip
# Where the files differ from the packages, and say why: axis, lower and upper limit [deg].
OTHERWISE = {
    "abb/irb2600-12-1.65": ((1, -95, 155), (2, -180, 75)),
    "abb/irb2400-12-1.55": ((2, -170, 165),),
}


def test_every_arm_is_held_against_what_is_published():
    assert set(CHAINS) | set(LENGTHS) == set(ARMS)


@pytest.mark.parametrize("name", LENGTHS)
def test_lengths_are_those_of_the_other_publication(name):
    links = load_robot(name).geometry.links
    found = (links.height, links.a1, links.a2, links.a3, links.d4, links.d6)
    np.testing.assert_allclose(np.array(found) / mm, LENGTHS[name], atol=1e-9)


def test_arms_without_a_chain_read_their_axes_as_the_others_of_their_maker():
    for name in set(ARMS) - set(CHAINS):
        links, other = load_robot(name).geometry.links, load_robot(FIRST[name.split("/")[0]]).geometry.links
        assert (links.signs, links.zeros) == (other.signs, other.zeros)
        assert "links" in load_robot(name).inferred


@pytest.mark.parametrize("name", CHAINS)
def test_the_flange_is_where_the_chain_of_the_package_ends(name):
    robot = load_robot(name)
    joints = np.random.default_rng(21).uniform(robot.lower, robot.upper, (6, 6))
    for row, position, rotation in zip(joints, *forward(robot, joints), strict=True):
        assert_same(end_of(CHAINS[name], row), position, rotation)


@pytest.mark.parametrize("name", CHAINS)
def test_limits_and_speeds_are_those_of_the_package(name):
    robot = load_robot(name)
    stated = np.array([numbers(row, "lower", "upper", "speed") for row in turning(CHAINS[name])]).T
    for axis, *limits in OTHERWISE.get(name, ()):
        assert not np.allclose(stated[:2, axis], np.array(limits) * deg, atol=ROUNDED)
        stated[:2, axis] = np.array(limits) * deg
    np.testing.assert_allclose([robot.lower, robot.upper, robot.speeds], stated, atol=ROUNDED)


@pytest.mark.parametrize("name", WRIST_ARMS)
def test_the_wrist_reaches_as_far_as_the_maker_says(name):
    """KUKA writes R900 or R2700, ABB 0.58 or 2.65: the wrist centre from axis 1 with the arm stretched."""
    links = load_robot(name).geometry.links
    reach = links.a1 + links.a2 + np.hypot(links.a3, links.d4)
    kuka = re.search(r"-r(\d{3,4})", name)
    said = (
        (REACHES.get(name) or int(kuka[1])) * mm
        if name.startswith("kuka/")
        else float(name.rsplit("-", 1)[1])
    )
    assert reach == pytest.approx(said, abs=0.035)


# What the machine data ($MACHINE.DAT) of two KR C4 controllers say, as published with their programs: frames
# ($TIRORO, $TX3P3, $TFLWP), lengths A and B, soft limits, motor speed [1/min] and gear ratio of each axis.
MACHINE_DATA = {
    "kuka/kr6-r900-sixx": (
        (400, 25, 455, (420, 0, 35), 80),
        ((-170, 170), (-190, 45), (-120, 156), (-185, 185), (-120, 120), (-350, 350)),
        (6000, 6000, 6000, 6000, 6000, 6000),
        (100, 120, 100, 850 / 9, 66096 / 713, 520960 / 8901),
    ),
    "kuka/kr210-r2700-2": (
        (645, 330, 1150, (1220, 0, 115), 215),
        ((-185, 185), (-140, -5), (-120, 168), (-350, 350), (-125, 125), (-350, 350)),
        (5000, 4999.99805, 4691.55566, 5634.16064, 5450.46533, 4813.50439),
        (1798 / 7, 4576 / 17, 754 / 3, 10387 / 55, 91834 / 483, 6485103 / 49400),
    ),
}
DIRECTIONS = (-1, 1, 1, -1, -1, -1)  # $AXIS_DIR of both


def end_by_machine_data(name, joints):
    """The flange as KUKA's controller computes it: two parallel arm axes, a wrist in Denavit-Hartenberg's notation."""
    base, a, b, wrist, flange = MACHINE_DATA[name][0]

    def shift(x, y, z):
        return RigidTransform.from_translation(np.array([x, y, z]) * mm)

    def turn(axis, angle):
        return RigidTransform.from_rotation(Rotation.from_euler(axis, angle, degrees=True))

    a1, a2, a3, a4, a5, a6 = np.degrees(joints) * DIRECTIONS
    arm = shift(0, 0, base) * turn("z", a1) * shift(a, 0, 0) * turn("y", a2) * shift(b, 0, 0) * turn("y", a3)
    hand = turn("z", a4) * turn("x", 90) * turn("z", a5) * turn("x", -90) * turn("z", a6)
    return arm * shift(*wrist) * turn("y", 90) * hand * shift(0, 0, flange)


@pytest.mark.parametrize("name", MACHINE_DATA)
def test_the_flange_is_where_the_controllers_machine_data_put_it(name):
    robot = load_robot(name)
    joints = np.random.default_rng(22).uniform(robot.lower, robot.upper, (20, 6))
    for row, position, rotation in zip(joints, *forward(robot, joints), strict=True):
        assert_same(end_by_machine_data(name, row), position, rotation, 1e-12, 1e-12)


@pytest.mark.parametrize("name", MACHINE_DATA)
def test_limits_and_speeds_are_the_controllers_machine_data(name):
    robot = load_robot(name)
    _, limits, motor, ratio = MACHINE_DATA[name]
    np.testing.assert_allclose(np.degrees([robot.lower, robot.upper]).T, limits, atol=1e-9)
    np.testing.assert_allclose(np.degrees(robot.speeds), np.array(motor) * 6 / ratio, atol=0.4)


def test_kukas_cannon_looks_forward_with_a_0_b_90_c_0():
    position, rotation = forward(load_robot("kuka/kr6-r900-sixx"), np.array([CANNON]) * deg)
    np.testing.assert_allclose(position / mm, [[525, 0, 890]], atol=1e-9)
    expected = Rotation.from_euler("ZYX", [0, 90, 0], degrees=True).as_matrix()
    np.testing.assert_allclose(rotation[0], expected, atol=1e-12)


def test_abbs_arm_at_zero_is_where_robotstudio_shows_it():
    position, rotation = forward(load_robot("abb/irb120-3-0.58"), np.zeros((1, 6)))
    np.testing.assert_allclose(position / mm, [[374, 0, 630]], atol=1e-9)
    np.testing.assert_allclose(quaternion_from_rotation(rotation)[0], [0.5**0.5, 0, 0.5**0.5, 0], atol=1e-12)


@pytest.mark.parametrize("name", ARMS)
def test_positive_angles_turn_as_the_maker_says(name):
    """KUKA's A1 turns clockwise seen from above, ABB's axis 1 the other way; axes 2 and 3 bend both arms forward."""
    robot, kuka = load_robot(name), name.startswith("kuka/")
    upright = np.array(CANNON if kuka else [0.0] * 6) * deg
    steps = upright + np.vstack([np.zeros(6), np.eye(6)]) * 0.1
    (home, side, forwards, down, *_), rotations = forward(robot, steps)
    assert (side[1] < home[1]) == kuka
    assert forwards[2] < home[2]
    assert down[2] < home[2]
    # Axis 4 and 6 turn clockwise (KUKA) or counterclockwise (ABB) seen by one who looks back at the arm; 5 nods.
    turned = [Rotation.from_matrix(rotations[n] @ rotations[0].T).as_rotvec() / 0.1 for n in (4, 5, 6)]
    sense = -1.0 if kuka else 1.0
    np.testing.assert_allclose(turned, [[sense, 0, 0], [0, 1, 0], [sense, 0, 0]], atol=TURNED)


@pytest.mark.parametrize("name", [name for name in ARMS if name.startswith("kuka/")])
def test_kukas_cannon_is_abbs_zero(name):
    kuka, abb = load_robot(name), load_robot("abb/irb2600-12-1.65")
    np.testing.assert_allclose(
        same_posture(kuka, abb, np.array([CANNON]) * deg), np.zeros((1, 6)), atol=1e-12
    )
    joints = np.array([[20.0, -80, 70, 30, 40, -50]]) * deg
    np.testing.assert_allclose(
        np.degrees(same_posture(kuka, abb, joints)), [[-20, 10, -20, -30, 40, 50]], atol=1e-9
    )


def test_the_rods_of_the_irb2400_keep_its_forearm_level():
    """Its driver's words: the joint is axis 3 less axis 2."""
    robot = load_robot("abb/irb2400-12-1.55")
    readings = np.array([[0, 0, 20, 0, 0, 0], [0, 60, 20, 0, 0, 0], [0, -40, 20, 0, 0, 0]]) * deg
    joints = joints_of_readings(robot, readings)
    np.testing.assert_allclose(np.degrees(joints[:, 2]), [20, -40, 60], atol=1e-9)
    assert within_limits(robot, joints).all()
    positions, rotations = forward(robot, joints)
    np.testing.assert_allclose(rotations, np.broadcast_to(rotations[0], rotations.shape), atol=1e-12)
    np.testing.assert_allclose(positions[1, 0] - positions[0, 0], 0.705 * np.sin(60 * deg), atol=1e-12)


def test_the_last_axis_stays_within_its_limits_where_a_turn_lets_it():
    """Yaskawa's flange looks the other way round at zero: half a turn apart, which may be one too many."""
    yaskawa, kuka = load_robot("yaskawa/gp25"), load_robot("kuka/kr20-r1810-2")
    joints = np.array([[0, 0, 0, 0, 0, t] for t in (0.0, 170, -169, -171, 200)]) * deg
    found = same_posture(yaskawa, kuka, joints)
    np.testing.assert_allclose(np.degrees(found[:, 5]), [-180, -10, -349, 9, 20], atol=1e-9)
    assert within_limits(kuka, found).all()
    assert turned_back(yaskawa, kuka, joints, found).tolist() == [False, False, False, True, False]
    (_, one), (_, two) = forward(yaskawa, joints), forward(kuka, found)
    np.testing.assert_allclose(one, two, atol=1e-12)


SOURCE = """&ACCESS RVP
DEF way ( )
BAS (#INITMOV,0 )
$TOOL={X 0,Y 0,Z 100,A 0,B 0,C 0}
$BASE={X 0,Y 0,Z 0,A 0,B 0,C 0}
BAS (#VEL_PTP,50)
PTP {A1 0,A2 -90,A3 90,A4 0,A5 30,A6 0}
PTP {A1 20,A2 -80,A3 70,A4 0,A5 40,A6 300}
PTP {X 900,Y 100,Z 900,A 0,B 120,C 0,S 2,T 35}
$VEL.CP=0.2
LIN {X 900,Y -100,Z 900,A 0,B 120,C 0}
END
"""


@pytest.fixture
def source(tmp_path):
    path = tmp_path / "way.src"
    path.write_text(SOURCE)
    return olp.read(path)


def converted(source, one, two):
    made = convert(source, "rapid", Context(robot=load_robot(one), target_robot=load_robot(two)))
    return made, made.files[made.main].decode()


def test_a_krl_program_of_kukas_arm_becomes_one_of_abbs(source):
    made, text = converted(source, "kuka/kr16-2", "abb/irb2600-12-1.65")
    assert "[[0,0,0,0,30,0]," in text
    assert "[[-20,10,-20,0,40,-300]," in text
    assert "[[900,100,900]," in text
    assert not [loss for loss in made.translated.losses if loss.part == "base"]  # both bases are on the floor
    (first, *_) = [loss for loss in made.translated.losses if loss.part == "joints"]
    joints = np.array([[0, -90, 90, 0, 30, 0]]) * deg
    there = forward(load_robot("abb/irb2600-12-1.65"), np.array([[0, 0, 0, 0, 30, 0]]) * deg)[0]
    apart = np.linalg.norm(there - forward(load_robot("kuka/kr16-2"), joints)[0])
    assert first.size == pytest.approx(apart / mm, abs=1e-6)


def test_a_base_that_is_higher_above_the_floor_is_told(source):
    made, _ = converted(source, "kuka/kr16-2", "yaskawa/gp25")
    (base,) = [loss for loss in made.translated.losses if loss.part == "base"]
    assert "higher" in base.says
    assert base.size == pytest.approx(load_robot("yaskawa/gp25").geometry.base_height / mm)
    assert ("505 mm higher",) in made.translated.asks.values()


def test_an_axis_that_must_turn_back_is_told_with_its_line(source):
    made, text = converted(source, "kuka/kr16-2", "yaskawa/gp8")
    told = [loss for loss in made.translated.losses if "whole turns" in loss.says]
    assert [(loss.line, loss.size) for loss in told] == [(8, 360.0)]
    assert text


def test_a_robot_that_is_too_small_is_not_asked_for_again(source):
    with pytest.raises(olp.OlpError) as caught:
        converted(source, "kuka/kr4-r600", "abb/irb2600-12-1.65")
    (only,) = [d for d in caught.value.diagnostics if d.code == "X012"]
    assert "kuka/kr4-r600 does not reach every point" in only.help
