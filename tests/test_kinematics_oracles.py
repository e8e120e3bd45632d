"""Against two independent libraries (EAIK, py-opw-kinematics), for every spherical-wrist arm of the library."""

import math

import numpy as np
import pytest
from eaik.IK_HP import HPRobot
from py_opw_kinematics import KinematicModel
from py_opw_kinematics import Robot as OpwRobot
from scipy.spatial.transform import RigidTransform

from olp.robots.kinematics import branches, forward, inverse, singularities
from olp.robots.kinematics.configuration import to_standard, wrap
from olp.robots.robot import load_robot, robot_names

ROBOTS = [load_robot(name) for name in robot_names()]
WRIST_ARMS = [robot for robot in ROBOTS if robot.geometry and robot.geometry.links]
SIX_AXES = [robot for robot in ROBOTS if robot.geometry and len(robot.axes) == 6]


def named(robots):
    return {"argvalues": robots, "ids": [robot.model for robot in robots]}


def random_joints(robot, count, seed):
    """Inside the limits, away from the places where joints are ill-conditioned and nobody's digits agree."""
    joints = np.random.default_rng(seed).uniform(robot.lower, robot.upper, (4 * count, 6))
    if robot.geometry.links:
        near = singularities(robot, joints, angle=0.03, length=0.03)
        joints = joints[~(near.wrist | near.elbow | near.shoulder)]
    return joints[:count]


def matrices(positions, rotations):
    poses = np.tile(np.eye(4), (len(positions), 1, 1))
    poses[:, :3, 3], poses[:, :3, :3] = positions, rotations
    return poses


def eaik_robot(robot):
    geometry = robot.geometry
    directions = np.array([joint.direction for joint in geometry.joints])
    offsets = np.array([joint.offset for joint in geometry.joints] + [geometry.flange_offset])
    return HPRobot(directions, offsets), np.array(geometry.flange_rotation)


def opw_robot(robot):
    links = robot.geometry.links
    model = KinematicModel(
        a1=links.a1, a2=-links.a3, c1=links.height, c2=links.a2, c3=links.d4, c4=links.d6,
        offsets=(0.0, 0.0, -math.pi / 2, 0.0, 0.0, math.pi), flip_axes=(False, False, True, True, True, True),
    )  # fmt: skip
    return OpwRobot(model, degrees=False)


def assert_same_solutions(ours, theirs):
    """Every row of `theirs` is among `ours` and the other way round, up to whole turns."""
    ours = ours[~np.isnan(ours).any(axis=1)]
    apart = np.abs(wrap(ours[:, None, :] - theirs[None, :, :])).max(axis=2)
    assert apart.min(axis=0).max() < 1e-9
    assert apart.min(axis=1).max() < 1e-9


@pytest.mark.parametrize("robot", **named(SIX_AXES))
def test_forward_agrees_with_eaik(robot):
    other, flange = eaik_robot(robot)
    joints = random_joints(robot, 20, seed=11)
    poses = matrices(*forward(robot, joints))
    for row, pose in zip(joints, poses, strict=True):
        expected = other.fwdKin(row)
        np.testing.assert_allclose(pose[:3, 3], expected[:3, 3], atol=1e-12)
        np.testing.assert_allclose(pose[:3, :3], expected[:3, :3] @ flange, atol=1e-12)


@pytest.mark.parametrize("robot", **named(WRIST_ARMS))
def test_all_branches_agree_with_eaik(robot):
    other, flange = eaik_robot(robot)
    positions, rotations = forward(robot, random_joints(robot, 25, seed=12))
    found = branches(robot, positions, rotations)
    for pose, ours in zip(matrices(positions, rotations @ flange.T), found, strict=True):
        solution = other.IK(pose)
        exact = ~np.asarray(solution.is_LS, dtype=bool)
        assert_same_solutions(ours, np.asarray(solution.Q)[exact])


@pytest.mark.parametrize("robot", **named(WRIST_ARMS))
def test_all_branches_agree_with_opw(robot):
    other, links = opw_robot(robot), robot.geometry.links
    positions, rotations = forward(robot, random_joints(robot, 50, seed=13))
    found = to_standard(links, branches(robot, positions, rotations).reshape(-1, 6)).reshape(-1, 8, 6)
    theirs = np.asarray(other.reach(RigidTransform.from_matrix(matrices(positions, rotations))).joints)
    for ours, expected in zip(found, theirs, strict=True):
        assert_same_solutions(ours, expected[~np.isnan(expected).any(axis=1)])


@pytest.mark.parametrize("robot", **named([robot for robot in SIX_AXES if not robot.geometry.links]))
def test_numeric_solutions_reach_their_poses_by_eaiks_account(robot):
    """EAIK has no decomposition for an offset wrist: its forward kinematics judges instead."""
    other, flange = eaik_robot(robot)
    joints = random_joints(robot, 40, seed=14)
    positions, rotations = forward(robot, joints)
    found, reachable = inverse(robot, positions, rotations)
    assert reachable.all()
    for pose, ours in zip(matrices(positions, rotations @ flange.T), found, strict=True):
        np.testing.assert_allclose(other.fwdKin(ours), pose, atol=1e-9)
