"""Universal Robots' inverse in closed form: against EAIK, there and back, at the edges, and as seeds choose."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from test_kinematics_oracles import assert_same_solutions, eaik_robot, matrices

from olp.core.units import deg
from olp.robots.geometry import rotation_angle
from olp.robots.kinematics import forward, inverse, jacobian, nearest, within_limits
from olp.robots.kinematics.spherical import offset_wrist_of, solutions
from olp.robots.model import Joint
from olp.robots.robot import load_robot, robot_names

UNIVERSAL = [load_robot(name) for name in robot_names() if name.startswith("universal-robots/")]
UR5E = load_robot("universal-robots/ur5e")


def joints_of(robot, count, seed=17):
    """Clear of the places where solutions meet."""
    joints = np.random.default_rng(seed).uniform(-np.pi, np.pi, (6 * count, 6))
    joints = joints[np.linalg.svd(jacobian(robot, joints), compute_uv=False)[:, -1] > 0.03][:count]
    assert len(joints) == count
    return joints


def all_of(robot, positions, rotations, sixth=0.0):
    arm = offset_wrist_of(robot.geometry)
    return solutions(arm, positions, rotations, np.broadcast_to(sixth, len(positions)))


@pytest.mark.parametrize("robot", UNIVERSAL, ids=lambda robot: robot.model)
def test_all_solutions_are_those_of_eaik(robot):
    other, flange = eaik_robot(robot)
    positions, rotations = forward(robot, joints_of(robot, 40))
    found = all_of(robot, positions, rotations)
    for pose, ours in zip(matrices(positions, rotations @ flange.T), found, strict=True):
        solution = other.IK(pose)
        assert_same_solutions(ours, np.asarray(solution.Q)[~np.asarray(solution.is_LS, dtype=bool)])


@pytest.mark.parametrize("robot", UNIVERSAL, ids=lambda robot: robot.model)
def test_every_solution_reaches_the_pose_and_one_is_where_it_came_from(robot):
    joints = joints_of(robot, 200)
    positions, rotations = forward(robot, joints)
    found = all_of(robot, positions, rotations)
    pose, branch = np.nonzero(~np.isnan(found).any(axis=2))
    again, turned = forward(robot, found[pose, branch])
    np.testing.assert_allclose(again, positions[pose], atol=1e-12)
    assert rotation_angle(turned, rotations[pose]).max() < 1e-12
    apart = np.abs(np.exp(1j * found) - np.exp(1j * joints)[:, None]).max(axis=2)
    assert np.nanmin(apart, axis=1).max() < 1e-10


def test_the_nearest_to_a_seed_is_the_seeds_own_turn():
    joints = joints_of(UR5E, 100)
    joints[:50, 5] += 2 * np.pi * np.where(joints[:50, 5] < 0, 1, -1)
    found = nearest(UR5E, *forward(UR5E, joints), joints + 0.01)
    np.testing.assert_allclose(found, joints, atol=1e-9)


def test_beyond_a_limit_another_turn_or_branch_inside_is_taken():
    beyond = np.array([[363.0, -80.0, 70.0, -90.0, -80.0, 10.0]]) * deg
    positions, rotations = forward(UR5E, beyond)
    found = nearest(UR5E, positions, rotations, beyond)
    assert within_limits(UR5E, found).all()
    np.testing.assert_allclose(forward(UR5E, found)[0], positions, atol=1e-12)


def test_a_straight_wrist_keeps_axis_six_where_it_was():
    joints = np.array([[20.0, -80.0, 70.0, -30.0, 0.0, 25.0]]) * deg
    found = nearest(UR5E, *forward(UR5E, joints), joints)
    np.testing.assert_allclose(found, joints, atol=1e-6)
    positions, rotations = forward(UR5E, joints)
    again, turned = forward(UR5E, nearest(UR5E, positions, rotations, joints + 0.3))
    np.testing.assert_allclose(again, positions, atol=1e-9)
    assert rotation_angle(turned, rotations).max() < 1e-9


def test_a_stretched_elbow_is_reached_and_what_lies_beyond_is_not():
    joints = np.array([[20.0, -80.0, 0.0, -30.0, 70.0, 25.0]]) * deg
    positions, rotations = forward(UR5E, joints)
    found, reached = inverse(UR5E, positions, rotations, seed=joints)
    assert reached.all()
    np.testing.assert_allclose(forward(UR5E, found)[0], positions, atol=1e-8)
    beyond = positions * 1.01
    found, reached = inverse(UR5E, beyond, rotations, seed=joints)
    assert not reached.any()
    assert np.isnan(found).all()


def test_nothing_is_reached_in_the_pillar_that_the_offset_leaves_around_axis_one():
    arm = offset_wrist_of(UR5E.geometry)
    rotation = forward(UR5E, np.zeros((1, 6)))[1]
    tip = arm.flange * rotation[0][:, 2]
    inside, outside = np.array([[0.0, 0.10, 0.5]]), np.array([[0.0, 0.16, 0.5]])
    assert np.isnan(all_of(UR5E, inside + tip, rotation)).all()
    assert not np.isnan(all_of(UR5E, outside + tip, rotation)).all()


def test_an_arm_that_is_built_otherwise_has_no_such_form():
    geometry = UR5E.geometry
    assert offset_wrist_of(load_robot("yaskawa/hc10").geometry) is None
    assert offset_wrist_of(load_robot("yaskawa/gp25").geometry) is None
    for number, change in ((3, {"direction": (0.0, 0.0, 1.0)}), (5, {"offset": (0.01, 0.0, -0.1)})):
        joints = tuple(
            joint if i != number else Joint(**{**joint._asdict(), **change})
            for i, joint in enumerate(geometry.joints)
        )
        assert offset_wrist_of(replace(geometry, joints=joints)) is None
