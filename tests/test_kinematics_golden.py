"""Pulses against the coordinates that a controller itself gave for them."""

from pathlib import Path

import numpy as np
import pytest

from olp.core.units import deg, mm
from olp.robots.geometry import Pose, rotation_angle, rotation_from_angles
from olp.robots.kinematics import (
    configuration_of,
    forward,
    inverse,
    joints_to_pulses,
    pulses_to_joints,
    with_tool,
    without_tool,
)
from olp.robots.robot import load_robot

TABLE = np.loadtxt(
    Path(__file__).parent / "data" / "ar2010_poses.csv", delimiter=",", comments="#", skiprows=5
)
PULSES, FLAGS = TABLE[:, :6], TABLE[:, 12:].astype(int)
POSITIONS, ROTATIONS = TABLE[:, 6:9] * mm, rotation_from_angles(TABLE[:, 9:12] * deg)
TOOL = Pose.from_xyz_angles(np.array([-88.687 * mm, 0.981 * mm, 463.147 * mm, 0.0, -45.0 * deg, 0.0]))


@pytest.fixture(params=["yaskawa/ar2010", "yaskawa/ma2010"])
def robot(request):
    return load_robot(request.param)


def test_all_twenty_points_are_there():
    assert TABLE.shape == (20, 18)
    assert FLAGS.sum() == 19 + 2 + 2


def test_forward_gives_the_controllers_coordinates(robot):
    positions, rotations = with_tool(*forward(robot, pulses_to_joints(robot, PULSES)), TOOL)
    assert np.abs(positions - POSITIONS).max() < 0.001 * mm
    assert rotation_angle(rotations, ROTATIONS).max() < 0.0005 * deg


def test_inverse_with_the_files_configuration_gives_the_pulses(robot):
    joints, reachable = inverse(robot, *without_tool(POSITIONS, ROTATIONS, TOOL), FLAGS)
    assert reachable.all()
    apart = np.abs(joints_to_pulses(robot, joints) - PULSES).max(axis=1)
    # Coordinates are printed to 0.001 mm: with the arm 2 deg from stretched (point 12) and B near 6 deg
    # (point 16) that is worth more than half a pulse.
    assert apart[[11, 15]].max() <= 2
    assert np.delete(apart, [11, 15]).max() == 0


def test_configuration_of_the_pulses_is_what_the_file_states(robot):
    np.testing.assert_array_equal(configuration_of(robot, pulses_to_joints(robot, PULSES)), FLAGS)


def test_a_pose_without_round_numbers_agrees_with_hand_calculation(robot):
    positions, rotations = forward(robot, np.array([[10, 20, 30, 40, 50, 60]]) * deg)
    np.testing.assert_allclose(positions[0] / mm, [1462.6339, 307.9018, 1167.9681], atol=5e-5)
    expected = rotation_from_angles(np.array([42.0189, 21.8552, 120.3850]) * deg)
    assert rotation_angle(rotations[0], expected) < 1e-4 * deg


def test_at_zero_the_flange_looks_forward_with_its_x_axis_up(robot):
    positions, rotations = forward(robot, np.zeros((1, 6)))
    np.testing.assert_allclose(positions[0] / mm, [150 + 1082 + 100, 0, 760 + 200], atol=1e-9)
    np.testing.assert_allclose(rotations[0], [[0, 0, 1], [0, -1, 0], [1, 0, 0]], atol=1e-15)
