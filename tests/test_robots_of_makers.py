"""Library arms of four makers against their makers' conventions, computed a second way.

FANUC, Stäubli: the joints of ros-industrial's packages (BSD, Apache 2.0), chained as URDF says; Kawasaki: those of the
maker's own package (BSD). Universal Robots: the maker's Denavit-Hartenberg table, multiplied out. None of them uses
olp's own kinematics.
"""

import math

import numpy as np
import pytest

from olp.core.units import deg, mm
from olp.robots.geometry import rotation_from_angles
from olp.robots.kinematics import forward, inverse, jacobian, within_limits
from olp.robots.kinematics.configuration import joints_of_readings, readings_of_joints
from olp.robots.robot import load_robot, robot_names

FANUC = [name for name in robot_names() if name.startswith("fanuc/")]
KAWASAKIS = [name for name in robot_names() if name.startswith("kawasaki/") and load_robot(name).geometry]
STAUBLIS = [name for name in robot_names() if name.startswith("staubli/")]
UNIVERSAL = [name for name in robot_names() if name.startswith("universal-robots/")]

# x of joint 2, z of joints 3 and 4, x of joints 5 and 6 [m] in the xacro files of ros-industrial/fanuc and
# fanuc_experimental; the others are 0, but for the height of joint 1, above which the world frame "base" lies.
URDF = {
    "cr-7ia": (0.05, 0.33, 0.035, 0.335, 0.08),
    "cr-7ia-l": (0.05, 0.44, 0.035, 0.42, 0.08),
    "lr-mate-200ib": (0.15, 0.25, 0.075, 0.29, 0.08),
    "lr-mate-200ib-3l": (0.15, 0.25, 0.075, 0.45, 0.08),
    "lr-mate-200ic": (0.075, 0.3, 0.075, 0.32, 0.08),
    "lr-mate-200ic-5l": (0.075, 0.4, 0.075, 0.41, 0.08),
    "lr-mate-200id": (0.05, 0.33, 0.035, 0.335, 0.08),
    "lr-mate-200id-4s": (0, 0.26, 0.02, 0.29, 0.07),
    "lr-mate-200id-7l": (0.05, 0.44, 0.035, 0.42, 0.08),
    "m-10ia": (0.15, 0.6, 0.2, 0.64, 0.1),
    "m-10ia-7l": (0.15, 0.6, 0.2, 0.86, 0.1),
    "m-16ib-20": (0.15, 0.77, 0.1, 0.74, 0.1),
    "m-20ia": (0.15, 0.79, 0.25, 0.835, 0.1),
    "m-20ia-10l": (0.15, 0.79, 0.25, 1.04, 0.1),
    "m-20ib-25": (0.075, 0.905, 0.12, 0.865, 0.1),
    "m-6ib": (0.15, 0.6, 0.1, 0.615, 0.1),
    "m-6ib-6s": (0.15, 0.36, 0.1, 0.43, 0.1),
    "m-710ic-45m": (0.15, 1.15, 0.17, 1.295, 0.175),
    "m-710ic-50": (0.15, 0.87, 0.17, 1.016, 0.175),
    "r-1000ia-80f": (0.32, 0.87, 0.225, 1.015, 0.175),
    "r-2000ib-210f": (0.312, 1.075, 0.225, 1.28, 0.235),
    "r-2000ic-125l": (0.312, 1.075, 0.225, 1.73, 0.215),
    "r-2000ic-165f": (0.312, 1.075, 0.225, 1.28, 0.215),
    "r-2000ic-210f": (0.312, 1.075, 0.225, 1.28, 0.215),
    "r-2000ic-210l": (0.312, 1.075, 0.225, 1.73, 0.24),
    "r-2000ic-270f": (0.312, 1.075, 0.225, 1.28, 0.24),
}

# What data sheets call the reach: from axis J1 to the wrist centre [mm].
REACH = {
    "cr-7ia": 717,
    "cr-7ia-l": 911,
    "lr-mate-200ib": 700,
    "lr-mate-200ib-3l": 856,
    "lr-mate-200ic": 704,
    "lr-mate-200ic-5l": 892,
    "lr-mate-200id": 717,
    "lr-mate-200id-4s": 550,
    "lr-mate-200id-7l": 911,
    "m-10ia": 1420,
    "m-10ia-7l": 1632,
    "m-16ib-20": 1667,
    "m-20ia": 1811,
    "m-20ia-10l": 2009,
    "m-20ib-25": 1853,
    "m-6ib": 1373,
    "m-6ib-6s": 951,
    "m-710ic-45m": 2606,
    "m-710ic-50": 2050,
    "r-1000ia-80f": 2230,
    "r-2000ib-210f": 2655,
    "r-2000ic-125l": 3100,
    "r-2000ic-165f": 2655,
    "r-2000ic-210f": 2655,
    "r-2000ic-210l": 3100,
    "r-2000ic-270f": 2655,
}

# a of joints 2 and 3, d of joints 1, 4, 5, 6 [m]: Universal Robots' article "DH Parameters for calculations of
# kinematics and dynamics", and its ROS description (BSD).
DENAVIT_HARTENBERG = {
    "ur3": (-0.24365, -0.21325, 0.1519, 0.11235, 0.08535, 0.0819),
    "ur5": (-0.425, -0.39225, 0.089159, 0.10915, 0.09465, 0.0823),
    "ur10": (-0.612, -0.5723, 0.1273, 0.163941, 0.1157, 0.0922),
    "ur3e": (-0.24355, -0.2132, 0.15185, 0.13105, 0.08535, 0.0921),
    "ur5e": (-0.425, -0.3922, 0.1625, 0.1333, 0.0997, 0.0996),
    "ur10e": (-0.6127, -0.57155, 0.1807, 0.17415, 0.11985, 0.11655),
    "ur16e": (-0.4784, -0.36, 0.1807, 0.17415, 0.11985, 0.11655),
    "ur20": (-0.862, -0.7287, 0.2363, 0.201, 0.1593, 0.1543),
    "ur30": (-0.637, -0.5037, 0.2363, 0.201, 0.1593, 0.1543),
}


# z of joint 1, y of joint 2, x of joints 3 and 4, z of joint 5, x of joint 6 [m] in the xacro files of
# Kawasaki-Robotics/khi_robot; the others are 0.
KAWASAKI = {
    "rs007l": (0.36, 0.0, 0.455, 0.0925, 0.3825, 0.078),
    "rs007n": (0.36, 0.0, 0.355, 0.0925, 0.2825, 0.078),
    "rs013n": (0.505, 0.0, 0.7, 0.11, 0.65, 0.078),
    "rs020n": (0.465, 0.15, 0.77, 0.161, 0.644, 0.095),
    "rs025n": (0.58, 0.0, 0.885, 0.15, 0.85, 0.1),
    "rs080n": (0.68, 0.15, 0.87, 0.267, 0.813, 0.165),
}


# x of joint 2, y and z of joint 3, z of joints 5 and 6 [m] in the xacro files of ros-industrial/staubli and
# staubli_experimental; the others are 0, but for the height of joint 1, above which the world frame "base" lies.
STAUBLI = {
    "rx160": (0.15, 0, 0.825, 0.625, 0.11),
    "rx160l": (0.15, 0, 0.825, 0.925, 0.11),
    "tx60": (0, 0.02, 0.29, 0.31, 0.07),
    "tx60l": (0, 0.02, 0.4, 0.45, 0.07),
    "tx2-60": (0, 0.02, 0.29, 0.31, 0.07),
    "tx2-60l": (0, 0.02, 0.4, 0.45, 0.07),
    "tx90": (0.05, 0.05, 0.425, 0.425, 0.1),
    "tx90l": (0.05, 0.05, 0.5, 0.55, 0.1),
    "tx90xl": (0.05, 0.05, 0.65, 0.65, 0.1),
    "tx2-90": (0.05, 0.05, 0.425, 0.425, 0.1),
    "tx2-90l": (0.05, 0.05, 0.5, 0.55, 0.1),
    "tx2-90xl": (0.05, 0.05, 0.65, 0.65, 0.1),
}


def turn(axis, angle):
    """(4, 4): by `angle` [rad] about a unit vector."""
    x, y, z = axis
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    result = np.eye(4)
    result[:3, :3] += math.sin(angle) * cross + (1 - math.cos(angle)) * cross @ cross
    return result


def shift(x, y, z):
    result = np.eye(4)
    result[:3, 3] = x, y, z
    return result


def urdf_tool0(name, joints):
    """(4, 4): tool0 in the frame "base", from the joints of the xacro file and its last fixed joint, rpy pi -pi/2 0."""
    x2, z3, z4, x5, x6 = URDF[name]
    pose = turn((0, 0, 1), joints[0]) @ shift(x2, 0, 0) @ turn((0, 1, 0), joints[1])
    pose = (
        pose @ shift(0, 0, z3) @ turn((0, -1, 0), joints[2]) @ shift(0, 0, z4) @ turn((-1, 0, 0), joints[3])
    )
    pose = (
        pose @ shift(x5, 0, 0) @ turn((0, -1, 0), joints[4]) @ shift(x6, 0, 0) @ turn((-1, 0, 0), joints[5])
    )
    return pose @ turn((0, 1, 0), -math.pi / 2) @ turn((1, 0, 0), math.pi)


def staubli_tool0(name, joints):
    """(4, 4): tool0 in the frame "base"; its two fixed joints, -90 and 90 deg about y, undo each other."""
    x2, y3, z3, z5, z6 = STAUBLI[name]
    pose = turn((0, 0, 1), joints[0]) @ shift(x2, 0, 0) @ turn((0, 1, 0), joints[1]) @ shift(0, y3, z3)
    pose = pose @ turn((0, 1, 0), joints[2]) @ turn((0, 0, 1), joints[3]) @ shift(0, 0, z5)
    return pose @ turn((0, 1, 0), joints[4]) @ shift(0, 0, z6) @ turn((0, 0, 1), joints[5])


def kawasaki_link6(name, joints):
    """(4, 4): link6 in base_link. Quarter turns about y lead to joints 2, 4, 5 and 6; odd joints turn about -z."""
    z1, y2, x3, x4, z5, x6 = KAWASAKI[name]
    back, on = turn((0, 1, 0), -math.pi / 2), turn((0, 1, 0), math.pi / 2)
    pose = shift(0, 0, z1) @ turn((0, 0, -1), joints[0]) @ shift(0, y2, 0) @ back @ turn((0, 0, 1), joints[1])
    pose = pose @ shift(x3, 0, 0) @ turn((0, 0, -1), joints[2])
    pose = pose @ shift(x4, 0, 0) @ on @ turn((0, 0, 1), joints[3])
    pose = pose @ shift(0, 0, z5) @ back @ turn((0, 0, -1), joints[4])
    return pose @ shift(x6, 0, 0) @ on @ turn((0, 0, 1), joints[5])


def denavit_hartenberg(name, joints):
    a2, a3, d1, d4, d5, d6 = DENAVIT_HARTENBERG[name]
    quarter = math.pi / 2
    rows = [(0, d1, quarter), (a2, 0, 0), (a3, 0, 0), (0, d4, quarter), (0, d5, -quarter), (0, d6, 0)]
    pose = np.eye(4)
    for angle, (a, d, alpha) in zip(joints, rows, strict=True):
        pose = pose @ turn((0, 0, 1), angle) @ shift(a, 0, d) @ turn((1, 0, 0), alpha)
    return pose


def some_joints(robot, count=20, seed=31):
    return np.random.default_rng(seed).uniform(robot.lower, robot.upper, (count, 6))


def test_every_arm_of_the_makers_is_compared():
    assert set(STAUBLIS) == {f"staubli/{name}" for name in STAUBLI}
    assert set(KAWASAKIS) == {f"kawasaki/{name}" for name in KAWASAKI}
    assert set(FANUC) == {f"fanuc/{name}" for name in URDF} == {f"fanuc/{name}" for name in REACH}
    assert set(UNIVERSAL) == {f"universal-robots/{name}" for name in DENAVIT_HARTENBERG}


SECOND_WAYS = {
    "fanuc": (urdf_tool0, URDF),
    "kawasaki": (kawasaki_link6, KAWASAKI),
    "staubli": (staubli_tool0, STAUBLI),
    "universal-robots": (denavit_hartenberg, DENAVIT_HARTENBERG),
}


@pytest.mark.parametrize("maker", SECOND_WAYS)
def test_flanges_stand_where_the_makers_own_chain_puts_them(maker):
    second_way, names = SECOND_WAYS[maker]
    for name in names:
        robot = load_robot(f"{maker}/{name}")
        joints = some_joints(robot)
        positions, rotations = forward(robot, joints)
        expected = np.array([second_way(name, row) for row in joints])
        np.testing.assert_allclose(positions, expected[:, :3, 3], atol=1e-12)
        np.testing.assert_allclose(rotations, expected[:, :3, :3], atol=1e-12)


@pytest.mark.parametrize("name", FANUC)
def test_all_zeros_is_the_upper_arm_up_the_forearm_forward_and_w_180_p_minus_90(name):
    """World is where axes J1 and J2 are level; W 180, P -90, R 0 is what pendants show there."""
    robot = load_robot(name)
    assert robot.geometry.links.third_to_horizontal
    x2, z3, z4, x5, x6 = URDF[name.split("/")[1]]
    positions, rotations = forward(robot, np.zeros((1, 6)))
    np.testing.assert_allclose(positions, [[x2 + x5 + x6, 0, z3 + z4]], atol=1e-12)
    np.testing.assert_allclose(rotations[0], rotation_from_angles(np.array([180, -90, 0]) * deg), atol=1e-12)


@pytest.mark.parametrize("name", KAWASAKIS)
def test_a_flange_turns_as_an_as_program_says_joints_and_pose_of_one_point(name):
    """Joints and O, A, T of one point in Kawasaki.pg of RoboDK/Industrial-Robots-VSCode (MIT).

    Its arm is another one; turns do not depend on lengths.
    """
    joints = np.array([[5.88516, -0.22998, -93.24622, 117.04327, -6.61066, -117.19835]]) * deg
    _, rotations = forward(load_robot(name), joints)
    o, a, t = np.array([90, 90, -90]) * deg
    expected = turn((0, 0, 1), o) @ turn((0, 1, 0), a) @ turn((0, 0, 1), t)
    np.testing.assert_allclose(rotations[0], expected[:3, :3], atol=2e-6)


@pytest.mark.parametrize("name", UNIVERSAL)
def test_all_zeros_is_stretched_out_along_minus_x_of_the_controllers_base(name):
    """The URDF's base_link is turned by half a turn about z; URScript's poses are those of the frame "base"."""
    a2, a3, d1, d4, d5, d6 = DENAVIT_HARTENBERG[name.split("/")[1]]
    positions, rotations = forward(load_robot(name), np.zeros((1, 6)))
    np.testing.assert_allclose(positions, [[a2 + a3, -d4 - d6, d1 - d5]], atol=1e-12)
    np.testing.assert_allclose(rotations[0], [[1, 0, 0], [0, 0, -1], [0, 1, 0]], atol=1e-12)


def test_the_third_axis_of_a_real_r_1000ia_is_read_against_the_horizontal():
    """Pendant and URDF joints of one posture, as posted in ros-industrial/fanuc_experimental, issue 17."""
    robot = load_robot("fanuc/r-1000ia-80f")
    read = np.array([[0.2743533253669739, 0.5467115640640259, -33.342 * deg, 1.285, -1.765, -0.544]])
    joints = joints_of_readings(robot, read)
    assert joints[0, 2] == pytest.approx(-0.035214900970458984, abs=0.0005 * deg)
    np.testing.assert_allclose(readings_of_joints(robot, joints), read, atol=1e-15)


@pytest.mark.parametrize("name", FANUC)
def test_the_wrist_reaches_as_far_as_the_data_sheet_says(name):
    """The farthest that J2 within its limits lets the stretched or horizontal forearm be."""
    robot = load_robot(name)
    links, tilt = robot.geometry.links, min(robot.upper[1], math.pi / 2)
    reach = links.a1 + links.a2 * math.sin(tilt) + math.hypot(links.a3, links.d4)
    assert reach == pytest.approx(REACH[name.split("/")[1]] * mm, abs=1.0 * mm)


@pytest.mark.parametrize("name", UNIVERSAL)
def test_a_start_nearby_leads_back_to_the_joints(name):
    """Away from where two solutions meet: wrist2 at 0, the elbow straight, the wrist above the base."""
    robot = load_robot(name)
    joints = np.random.default_rng(5).uniform(-3.0, 3.0, (200, 6))
    joints = joints[np.linalg.svd(jacobian(robot, joints), compute_uv=False)[:, -1] > 0.05][:30]
    assert len(joints) == 30
    found, reached = inverse(robot, *forward(robot, joints), seed=joints + 0.02)
    assert reached.all()
    assert within_limits(robot, found).all()
    np.testing.assert_allclose(found, joints, atol=1e-8)
