"""Rotations against scipy, identities on random data, and the frames that controllers define."""

import pickle

import numpy as np
import pytest
from scipy.spatial.transform import Rotation, Slerp

from olp.core.diagnostic import OlpError
from olp.core.units import deg, mm
from olp.robots.geometry import (
    Pose,
    angles_from_rotation,
    compose,
    frame_from_points,
    invert,
    quaternion_from_rotation,
    rotation_angle,
    rotation_from_angles,
    rotation_from_quaternion,
    slerp,
)

RANDOM = Rotation.random(500, random_state=5)
MATRICES = RANDOM.as_matrix()
POSITIONS = np.random.default_rng(5).uniform(-2.0, 2.0, (500, 3))


def test_angles_turn_about_fixed_x_then_y_then_z():
    angles = np.random.default_rng(1).uniform(-np.pi, np.pi, (200, 3))
    expected = Rotation.from_euler("xyz", angles).as_matrix()
    np.testing.assert_allclose(rotation_from_angles(angles), expected, atol=1e-14)


def test_angles_come_back_as_the_same_rotation_and_within_their_ranges():
    angles = angles_from_rotation(MATRICES)
    np.testing.assert_allclose(rotation_from_angles(angles), MATRICES, atol=1e-14)
    assert np.abs(angles[:, 1]).max() <= np.pi / 2


@pytest.mark.parametrize("ry", [90.0, -90.0, 89.99999999, -89.9999])
def test_angles_survive_gimbal_lock(ry):
    rotation = rotation_from_angles(np.array([37.0, ry, -112.0]) * deg)
    angles = angles_from_rotation(rotation)
    assert np.isfinite(angles).all()
    np.testing.assert_allclose(rotation_from_angles(angles), rotation, atol=1e-9)


def test_quaternions_agree_with_scipy_and_have_a_positive_real_part():
    quaternions = quaternion_from_rotation(MATRICES)
    expected = RANDOM.as_quat(canonical=True)[:, [3, 0, 1, 2]]
    np.testing.assert_allclose(quaternions, expected, atol=1e-14)
    assert (quaternions[:, 0] >= 0.0).all()
    np.testing.assert_allclose(rotation_from_quaternion(3.0 * quaternions), MATRICES, atol=1e-14)


@pytest.mark.parametrize("axis", [(1, 0, 0), (0, 1, 0), (0, 0, 1), (0.6, 0, 0.8), (2, -3, 6)])
def test_half_turns_have_quaternions_too(axis):
    unit = np.array(axis) / np.linalg.norm(axis)
    half_turn = 2.0 * np.outer(unit, unit) - np.eye(3)
    quaternion = quaternion_from_rotation(half_turn)
    assert abs(quaternion[0]) < 1e-15
    np.testing.assert_allclose(rotation_from_quaternion(quaternion), half_turn, atol=1e-15)


def test_slerp_agrees_with_scipy_on_the_short_way():
    fractions = np.linspace(0.0, 1.0, 21)
    for i in range(0, 100, 2):
        ends = quaternion_from_rotation(MATRICES[i : i + 2])
        expected = Slerp([0.0, 1.0], RANDOM[i : i + 2])(fractions).as_matrix()
        found = rotation_from_quaternion(slerp(ends[0], ends[1], fractions))
        np.testing.assert_allclose(found, expected, atol=1e-12)


def test_slerp_between_equal_and_nearly_equal_orientations_stays_a_rotation():
    start = quaternion_from_rotation(MATRICES[0])
    end = start + np.array([0.0, 1e-12, 0.0, 0.0])
    for other in (start, -start, end):
        found = slerp(start, other, np.array([0.0, 0.3, 1.0]))
        np.testing.assert_allclose(np.abs(found @ start), 1.0, atol=1e-12)


def test_rotation_angle_is_exact_for_tiny_and_half_turns():
    axis = np.array([2.0, -3.0, 6.0]) / 7.0
    for angle in (1e-9, 1e-4, 0.5, 3.0, np.pi - 1e-9, np.pi):
        turned = MATRICES[0] @ Rotation.from_rotvec(angle * axis).as_matrix()
        assert rotation_angle(MATRICES[0], turned) == pytest.approx(angle, rel=1e-6, abs=1e-15)


def test_composing_with_the_inverse_gives_nothing():
    position, rotation = compose(POSITIONS, MATRICES, *invert(POSITIONS, MATRICES))
    np.testing.assert_allclose(position, 0.0, atol=1e-14)
    np.testing.assert_allclose(rotation, np.tile(np.eye(3), (500, 1, 1)), atol=1e-14)


def test_one_frame_is_applied_to_many_poses():
    frame = Pose(POSITIONS[0], MATRICES[0])
    position, rotation = compose(frame.position, frame.rotation, POSITIONS, MATRICES)
    np.testing.assert_allclose(position, frame.apply(POSITIONS), atol=1e-14)
    one = frame @ Pose(POSITIONS[7], MATRICES[7])
    np.testing.assert_allclose(one.position, position[7], atol=1e-14)
    np.testing.assert_allclose(one.rotation, rotation[7], atol=1e-14)


def test_a_pose_is_equal_to_itself_printed_hashed_and_pickled():
    pose = Pose.from_xyz_angles([0.1, -0.2, 0.3, 0.4, -0.5, 0.6])
    again = Pose.from_xyz_angles(pose.xyz_angles())
    np.testing.assert_allclose(again.xyz_angles(), pose.xyz_angles(), atol=1e-15)
    copied = pickle.loads(pickle.dumps(pose))
    assert copied == pose
    assert hash(copied) == hash(pose)
    assert pose != Pose.identity()
    assert pose != "pose"


def test_a_frame_has_its_x_point_on_x_and_its_third_point_at_positive_y():
    frame = Pose.from_xyz_angles([0.4, -0.3, 0.9, 20 * deg, -35 * deg, 110 * deg])
    points = frame.apply(np.array([[0, 0, 0], [137 * mm, 0, 0], [-42 * mm, 218 * mm, 0]]))
    found = frame_from_points(*points)
    np.testing.assert_allclose(found.position, frame.position, atol=1e-14)
    np.testing.assert_allclose(found.rotation, frame.rotation, atol=1e-12)


@pytest.mark.parametrize("third", [[0.3, 0.0, 0.0], [0.0, 0.0, 0.0], [-0.2, 0.00001, 0.0]])
def test_a_frame_needs_three_points_that_are_not_in_line(third):
    with pytest.raises(OlpError, match="one line"):
        frame_from_points([0, 0, 0], [0.1, 0, 0], third)


def test_a_frame_needs_an_x_point_away_from_the_origin():
    with pytest.raises(OlpError, match="one line"):
        frame_from_points([0.1, 0.2, 0.3], [0.1, 0.2, 0.3], [0.4, 0.5, 0.7])
