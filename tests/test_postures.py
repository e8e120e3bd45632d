"""Joint values as each maker reads them, and programs that go from one maker's arm to another's."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from test_kinematics_oracles import assert_same_solutions, eaik_robot, matrices, random_joints

import olp
from olp.core.diagnostic import OlpError
from olp.robots.kinematics import branches, forward, inverse
from olp.robots.kinematics.configuration import joints_of_readings, readings_of_joints, same_posture
from olp.robots.kinematics.inverse import same_flange
from olp.robots.robot import load_robot, read_robot
from olp.transpile import Context
from olp.transpile.compare import compare_plans
from olp.transpile.convert import convert, run_converted

AXES = "\n".join(
    f'  {{ name = "J{n}", lower_deg = {low}, upper_deg = {high}, speed_deg_s = {speed} }},'
    for n, low, high, speed in [
        (1, -180, 180, 210), (2, -200, 200, 210), (3, -250, 250, 265), (4, -200, 200, 420),
        (5, -150, 150, 420), (6, -455, 455, 885),
    ]
)  # fmt: skip
LINKS = "a1_mm = 150\na2_mm = 760\na3_mm = 200\nd4_mm = 795\nd6_mm = 100"
# One arm, as three makers would read it.
STANCES = {
    "yaskawa": "",
    "fanuc": "third_to_horizontal = true",
    "kuka": "signs = [-1, 1, -1, 1, -1, 1]\nzero_deg = [0, 90, 90, 0, 0, 0]\norigin_below_mm = 505",
}


def robot_of(tmp_path, maker):
    path = tmp_path / f"{maker}.toml"
    path.write_text(
        f'maker = "{maker}"\nmodel = "arm"\naxes = [\n{AXES}\n]\n[links]\n{LINKS}\n{STANCES[maker]}\n'
        '[sources]\nlimits = "x"\nspeed = "x"\nlinks = "x"\n'
    )
    return read_robot(path)


LISTING = """/PROG  WAY
/ATTR
COMMENT		= "";
DEFAULT_GROUP	= 1,*,*,*,*;
/APPL
/MN
   1:  UFRAME_NUM=0 ;
   2:  UTOOL_NUM=0 ;
   3:J P[1] 40% FINE    ;
   4:J P[2] 40% FINE    ;
   5:J P[3] 40% FINE    ;
/POS
P[1]{
   GP1:
	UF : 0, UT : 0,
	J1=    10.000 deg,	J2=   -20.000 deg,	J3=    15.000 deg,
	J4=    30.000 deg,	J5=   -50.000 deg,	J6=    40.000 deg
};
P[2]{
   GP1:
	UF : 0, UT : 0,
	J1=    10.000 deg,	J2=    25.000 deg,	J3=    15.000 deg,
	J4=    30.000 deg,	J5=   -50.000 deg,	J6=    40.000 deg
};
P[3]{
   GP1:
	UF : 0, UT : 0,
	J1=   -30.000 deg,	J2=     5.000 deg,	J3=   -10.000 deg,
	J4=   -20.000 deg,	J5=   -60.000 deg,	J6=   100.000 deg
};
/END
"""


@pytest.fixture
def listing(tmp_path):
    path = tmp_path / "way.ls"
    path.write_text(LISTING)
    return olp.read(path)


def test_fanucs_second_axis_does_not_tilt_the_forearm(tmp_path, listing):
    plan = listing.plan(robot=robot_of(tmp_path, "fanuc"))
    first, second = plan.moves.target[:2]
    quaternion, position = plan.positions.quaternion, plan.positions.position
    np.testing.assert_allclose(quaternion[first], quaternion[second], atol=1e-12)
    # What is left is the upper arm, 760 mm, swung by 45 deg.
    swung = np.linalg.norm(position[second] - position[first])
    assert swung == pytest.approx(2 * 0.76 * np.sin(np.radians(22.5)), abs=1e-12)


def test_a_robot_that_says_nothing_is_read_joint_by_joint(tmp_path, listing):
    robot = robot_of(tmp_path, "yaskawa")
    plan = listing.plan(robot=robot)
    position, _ = forward(robot, np.radians([[10, -20, 15, 30, -50, 40]]))
    np.testing.assert_allclose(plan.positions.position[plan.moves.target[0]], position[0], atol=1e-12)


def test_readings_and_joints_are_each_others_way_back(tmp_path):
    robot = robot_of(tmp_path, "fanuc")
    joints = random_joints(robot, 50, seed=3)
    np.testing.assert_allclose(
        joints_of_readings(robot, readings_of_joints(robot, joints)), joints, atol=1e-14
    )
    plain = load_robot("yaskawa/gp25")
    assert readings_of_joints(plain, joints) is joints


def test_a_program_reads_and_drives_the_same_numbers(tmp_path):
    robot = robot_of(tmp_path, "fanuc")
    path = tmp_path / "asks.script"
    path.write_text(
        "def asks():\n  movej([0.1, 0.4, -0.2, 0.3, -0.9, 0.2])\n  p = get_actual_tcp_pose()\n"
        "  movej([0.3, 0.2, -0.1, 0.2, -0.8, 0.1])\n  movel(p)\n  q = get_actual_joint_positions()\n"
        "  movej([0.3, 0.2, -0.1, 0.2, -0.8, 0.1])\n  movej(q)\n"
        "  movej(get_inverse_kin(p, qnear=[0.1, 0.4, -0.2, 0.3, -0.9, 0.2]))\nend\nasks()\n"
    )
    plan = olp.read(path).plan(robot=robot)
    axes = plan.positions.axes[plan.moves.target][:, :6]
    for again in (2, 4, 5):
        np.testing.assert_allclose(axes[again], axes[0], atol=1e-8)
    np.testing.assert_allclose(axes[0], [0.1, 0.4, 0.2, 0.3, -0.9, 0.2], atol=1e-12)


@pytest.mark.parametrize("maker", ["fanuc", "kuka"])
def test_branches_agree_with_eaik_wherever_the_origin_is(tmp_path, maker):
    robot = robot_of(tmp_path, maker)
    other, flange = eaik_robot(robot)
    joints = random_joints(robot, 20, seed=12)
    positions, rotations = forward(robot, joints)
    for pose, ours in zip(
        matrices(positions, rotations @ flange.T), branches(robot, positions, rotations), strict=True
    ):
        solution = other.IK(pose)
        assert_same_solutions(ours, np.asarray(solution.Q)[~np.asarray(solution.is_LS, dtype=bool)])
    assert inverse(robot, positions, rotations)[1].all()


def test_one_posture_in_three_makers_readings(tmp_path):
    yaskawa, kuka = robot_of(tmp_path, "yaskawa"), robot_of(tmp_path, "kuka")
    joints = random_joints(yaskawa, 40, seed=5) * 0.4
    there = same_posture(yaskawa, kuka, joints)
    np.testing.assert_allclose(same_posture(kuka, yaskawa, there), joints, atol=1e-12)
    (one, turned), (two, also) = forward(yaskawa, joints), forward(kuka, there)
    np.testing.assert_allclose(two - one, np.broadcast_to([0, 0, 0.505], one.shape), atol=1e-12)
    np.testing.assert_allclose(turned, also, atol=1e-12)
    # KUKA's cannon: A2 = -90 and A3 = 90 are the upper arm up and the forearm forward.
    np.testing.assert_allclose(
        np.degrees(same_posture(yaskawa, kuka, np.zeros((1, 6)))), [[0, -90, 90, 0, 0, 0]], atol=1e-12
    )


def test_a_listing_becomes_a_krl_program_for_kukas_arm(tmp_path, listing):
    fanuc, kuka = robot_of(tmp_path, "fanuc"), robot_of(tmp_path, "kuka")
    made = convert(listing, "krl", Context(robot=fanuc, target_robot=kuka))
    text = made.files[made.main].decode() + made.files.get("WAY.dat", b"").decode()
    # J2 = -20, J3 = 15: U is -5 against the upper arm. A2 = L - 90, A3 = 90 - U.
    assert "A1 -10,A2 -110,A3 95,A4 30,A5 50,A6 40" in text
    one, two = listing.plan(robot=fanuc), run_converted(made, "krl", kuka, listing)
    places = [p.positions.position[p.moves.target] for p in (one, two)]
    np.testing.assert_allclose(
        places[1] - places[0], np.broadcast_to([0, 0, 0.505], places[0].shape), atol=1e-9
    )
    turned = [p.positions.quaternion[p.moves.target] for p in (one, two)]
    np.testing.assert_allclose(turned[0], turned[1], atol=1e-9)
    assert not [loss for loss in made.translated.losses if loss.part == "joints"]


def test_with_one_robot_joint_values_stay_as_they_are_written(tmp_path, listing):
    fanuc = robot_of(tmp_path, "fanuc")
    made = convert(listing, "krl", Context(robot=fanuc))
    assert "A2 -20,A3 15" in made.files[made.main].decode() + made.files.get("WAY.dat", b"").decode()
    assert compare_plans(listing.plan(robot=fanuc), run_converted(made, "krl", fanuc, listing)).is_equal


def test_an_arm_of_other_lengths_stands_alike_and_the_receipt_says_how_far_off(tmp_path, listing):
    fanuc, longer = robot_of(tmp_path, "fanuc"), load_robot("yaskawa/ma2010")
    made = convert(listing, "rapid", Context(robot=fanuc, target_robot=longer))
    found = [loss for loss in made.translated.losses if loss.part == "joints"]
    assert [loss.line for loss in found] == [9, 10, 11]
    joints = np.radians([[10, -20, -5, 30, -50, 40]])
    apart = np.linalg.norm(forward(longer, joints)[0] - forward(fanuc, joints)[0])
    assert found[0].size == pytest.approx(apart * 1000, abs=1e-6)


def universal(tmp_path, name, motion):
    path = tmp_path / f"{name}.script"
    path.write_text(f"def {name}():\n{motion}end\n{name}()\n")
    return olp.read(path)


@pytest.mark.parametrize(
    ("one", "two"),
    [("fanuc/m-20ia", "universal-robots/ur20"), ("universal-robots/ur20", "fanuc/m-20ia"),
     ("yaskawa/gp25", "yaskawa/hc10"), ("universal-robots/ur10e", "yaskawa/gp180")],
)  # fmt: skip
def test_an_arm_that_is_built_otherwise_holds_its_flange_where_the_first_did(one, two):
    one, two = load_robot(one), load_robot(two)
    joints = random_joints(one, 40, seed=9)
    there = same_flange(one, two, joints, np.zeros(6))
    reached = ~np.isnan(there).any(axis=1)
    assert reached.sum() > 5
    for ours, theirs in zip(forward(one, joints[reached]), forward(two, there[reached]), strict=True):
        np.testing.assert_allclose(theirs, ours, atol=1e-9)


def test_of_several_ways_to_hold_the_flange_the_one_with_like_links_is_taken():
    """A FANUC with its upper arm up and its forearm forward and down: so stands the Universal Robot, elbow up."""
    fanuc, universal = load_robot("fanuc/m-20ia"), load_robot("universal-robots/ur20")
    joints = np.radians([[10.0, 5.0, -25.0, 0.0, -60.0, 0.0]])
    there = same_flange(fanuc, universal, joints, np.zeros(6))
    assert np.sin(there[0, 1]) < -0.7  # -1: the upper arm points up
    back = same_flange(universal, fanuc, there, np.zeros(6))
    np.testing.assert_allclose(back, joints, atol=1e-9)


def test_points_that_lie_close_stay_on_one_side_and_turn():
    fanuc, universal = load_robot("fanuc/m-20ia"), load_robot("universal-robots/ur20")
    way = np.linspace(0.0, 1.0, 30)[:, None] * np.radians([[60.0, 30.0, 20.0, 40.0, -50.0, 170.0]])
    joints = np.radians([[-20.0, 5.0, -25.0, 10.0, -60.0, 10.0]]) + way
    rows = [np.zeros(6)]
    for row in joints:
        rows.append(same_flange(fanuc, universal, row[None], rows[-1])[0])
    steps = np.abs(np.diff(np.array(rows[1:]), axis=0))
    assert steps.max() < 0.35


def test_a_listing_for_a_universal_robot_goes_to_the_same_places(listing):
    fanuc, universal = load_robot("fanuc/m-20ia"), load_robot("universal-robots/ur20")
    made = convert(listing, "urscript", Context(robot=fanuc, target_robot=universal))
    one, two = listing.plan(robot=fanuc), run_converted(made, "urscript", universal, listing)
    places = [p.positions.position[p.moves.target] for p in (one, two)]
    np.testing.assert_allclose(places[0], places[1], atol=1e-6)
    (base,) = [loss for loss in made.translated.losses if loss.part == "base"]
    assert (base.size, base.unit) == (pytest.approx(525.0), "mm")
    assert any("another path" in note for note in made.translated.notes)


def test_a_universal_robots_joints_become_what_fanucs_pendant_shows(tmp_path):
    arm, fanuc = load_robot("universal-robots/ur10e"), load_robot("fanuc/m-20ia")
    program = universal(
        tmp_path,
        "way",
        "  movej([0.5, -1.4, 1.6, -1.7, -1.5, 0.3], a=1.4, v=1.05)\n"
        "  movej([0.2, -1.2, 1.5, -1.8, -1.5, 0.6], a=1.4, v=1.05)\n",
    )
    made = convert(program, "tp", Context(robot=arm, target_robot=fanuc))
    one, two = program.plan(robot=arm), run_converted(made, "tp", fanuc, program)
    places = [p.positions.position[p.moves.target] for p in (one, two)]
    np.testing.assert_allclose(places[0], places[1], atol=1e-6)


def test_what_the_other_arm_does_not_reach_is_refused_at_its_line(listing):
    fanuc, universal = load_robot("fanuc/m-20ia"), load_robot("universal-robots/ur3e")
    with pytest.raises(OlpError) as caught:
        convert(listing, "urscript", Context(robot=fanuc, target_robot=universal))
    told = caught.value.diagnostics
    assert [(d.code, d.line) for d in told] == [("X011", 9), ("X011", 10), ("X011", 11)]
    assert "universal-robots/ur3e does not reach where fanuc/m-20ia stands" in told[0].message


def test_joints_that_are_computed_or_relative_mean_nothing_to_another_kind_of_arm(tmp_path):
    arm, fanuc = load_robot("universal-robots/ur10e"), load_robot("fanuc/m-20ia")
    program = universal(
        tmp_path,
        "asks",
        "  movej([0.5, -1.4, 1.6, -1.7, -1.5, 0.3])\n  q = get_actual_joint_positions()\n"
        "  movej([q[0] + 0.1, q[1], q[2], q[3], q[4], q[5]])\n",
    )
    with pytest.raises(OlpError) as caught:
        convert(program, "tp", Context(robot=arm, target_robot=fanuc))
    assert any("mean nothing to fanuc/m-20ia" in d.message for d in caught.value.diagnostics)


def test_joint_values_of_which_one_is_set_mean_nothing_to_another_kind_of_arm(tmp_path):
    arm, fanuc = load_robot("universal-robots/ur10e"), load_robot("fanuc/m-20ia")
    rows = "  movej([0.5, -1.4, 1.6, -1.7, -1.5, 0.3])\n  q = get_actual_joint_positions()\n  q[3] = q[3] + 0.1\n"
    program = universal(tmp_path, "sets", f"{rows}  movej(q)\n")
    with pytest.raises(OlpError) as caught:
        convert(program, "tp", Context(robot=arm, target_robot=fanuc))
    assert any("mean nothing to fanuc/m-20ia" in d.message for d in caught.value.diagnostics)


def test_poses_get_the_flags_with_which_the_other_arm_stands(tmp_path):
    """A joint move to a pose: FANUC's arm must not flip its wrist on the way, as it would with F."""
    arm, fanuc = load_robot("universal-robots/ur10e"), load_robot("fanuc/m-20ia")
    program = universal(
        tmp_path,
        "way",
        "  movej([0.5, -1.4, 1.6, -1.7, -1.5, 0.3], a=1.4, v=1.05)\n"
        "  movej(p[-0.4, -0.3, 0.45, 2.2, 2.2, 0.1], a=1.4, v=1.05)\n"
        "  movel(p[-0.45, -0.3, 0.45, 2.2, 2.2, 0.1], a=1.2, v=0.25)\n",
    )
    made = convert(program, "tp", Context(robot=arm, target_robot=fanuc))
    two = run_converted(made, "tp", fanuc, program)
    axes = two.positions.axes[two.moves.target][:, :6]
    assert np.abs(np.diff(axes, axis=0)).max() < 0.8
    assert made.files[made.main].decode().count("'N U T, 0, 0, 0'") == 2


SEED = [0.5, -1.4, 1.6, -1.7, -1.5, 0.3]


@pytest.mark.parametrize("target", ["inform", "krl", "rapid", "tp"])
def test_a_seed_beside_a_pose_is_no_target(tmp_path, target):
    arm = load_robot("universal-robots/ur10e")
    program = universal(
        tmp_path,
        "way",
        f"  movej({SEED}, a=1.4, v=1.05)\n"
        f"  movej(get_inverse_kin(p[-0.4, -0.3, 0.45, 2.2, 2.2, 0.1], qnear={SEED}), a=1.4, v=1.05)\n",
    )
    made = convert(program, target, Context(robot=arm))
    one, two = program.plan(robot=arm), run_converted(made, target, arm, program)
    axes = [p.positions.axes[p.moves.target][:, :6] for p in (one, two)]
    assert np.abs(axes[0][1] - SEED).max() > 0.05
    np.testing.assert_allclose(axes[0], axes[1], atol=1e-5)


def test_joint_values_beside_a_pose_that_reach_it_stay_as_they_are_written(tmp_path):
    """Every arm is calibrated a little otherwise, and its own joint values are the better ones."""
    arm = load_robot("universal-robots/ur10e")
    x, y, z = forward(arm, np.array([SEED]))[0][0] + [0.0005, 0.0, -0.0005]
    rotation = Rotation.from_matrix(forward(arm, np.array([SEED]))[1][0]).as_rotvec()
    pose = ", ".join(f"{v:.9f}" for v in (x, y, z, *rotation))
    program = universal(
        tmp_path, "way", f"  movej(get_inverse_kin(p[{pose}], qnear={SEED}), a=1.4, v=1.05)\n"
    )
    made = convert(program, "krl", Context(robot=arm))
    text = made.files[made.main].decode() + made.files.get("way.dat", b"").decode()
    assert "A1 28.647889757,A2 -80.214091318,A3 91.673247221" in text
