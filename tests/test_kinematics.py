"""Promises of the kinematics that need no other library: there and back, along paths, at singularities."""

import subprocess
import sys
from dataclasses import replace
from importlib import import_module

import numpy as np
import pytest

from olp.core.diagnostic import OlpError
from olp.core.units import deg, mm
from olp.robots.geometry import Pose, rotation_angle
from olp.robots.kinematics import (
    branches,
    configuration_of,
    forward,
    inverse,
    jacobian,
    joints_to_pulses,
    pulses_to_joints,
    singularities,
    track,
    track_branches,
    track_paths,
    tracking,
    with_tool,
    within_limits,
    without_tool,
)
from olp.robots.kinematics.configuration import from_standard
from olp.robots.robot import Axis, Geometry, Joint, Robot, load_robot, robot_names

ROBOTS = [load_robot(name) for name in robot_names()]
MOVING = [robot for robot in ROBOTS if robot.geometry]
WRIST_ARMS = [robot for robot in MOVING if robot.geometry.links]
AR2010 = load_robot("yaskawa/ar2010")
HC20 = load_robot("yaskawa/hc20")
SIA20D = load_robot("yaskawa/sia20d")
HC10 = load_robot("yaskawa/hc10")


def named(robots):
    return {"argvalues": robots, "ids": [robot.model for robot in robots]}


def random_joints(robot, count, seed=7):
    """Inside the limits, at most one turn of S, R, T and one round of L, U, B: what RCONF can tell apart."""
    low, high = np.maximum(robot.lower, -360 * deg), np.minimum(robot.upper, 360 * deg)
    if robot.geometry.links:
        middle, within = (robot.lower + robot.upper) / 2.0, [1, 2, 4]
        low[within] = np.maximum(low, middle - np.pi)[within]
        high[within] = np.minimum(high, middle + np.pi)[within]
    return np.random.default_rng(seed).uniform(low, high, (count, len(robot.axes)))


def swinging(robot, count, amplitude=0.45, turns=5.0, middle=None):
    """A smooth path through the middle of the limits, or another, that bends every axis differently."""
    u = np.linspace(0.0, 1.0, count)[:, None]
    phase = np.arange(len(robot.axes))
    half = np.minimum((robot.upper - robot.lower) / 2.0, np.pi)
    middle = (robot.lower + robot.upper) / 2.0 if middle is None else middle
    return middle + amplitude * half * np.sin(turns * u * (1.0 + 0.17 * phase) + phase)


def assert_reaches(robot, joints, positions, rotations):
    found_positions, found_rotations = forward(robot, joints)
    np.testing.assert_allclose(found_positions, positions, atol=1e-9)
    assert rotation_angle(found_rotations, rotations).max() < 1e-9


@pytest.mark.parametrize("robot", **named(WRIST_ARMS))
def test_inverse_with_the_joints_own_configuration_gives_the_joints(robot):
    joints = random_joints(robot, 500)
    near = singularities(robot, joints)
    joints = joints[~(near.wrist | near.elbow | near.shoulder)]
    found, reachable = inverse(robot, *forward(robot, joints), configuration_of(robot, joints))
    assert reachable.all()
    np.testing.assert_allclose(found, joints, atol=1e-9)


@pytest.mark.parametrize("robot", **named(WRIST_ARMS))
def test_every_branch_reaches_the_pose_and_has_its_flags(robot):
    positions, rotations = forward(robot, random_joints(robot, 200))
    found = branches(robot, positions, rotations)
    for number in range(8):
        exists = ~np.isnan(found[:, number, 0])
        assert_reaches(robot, found[exists, number], positions[exists], rotations[exists])
        flags = configuration_of(robot, found[exists, number])
        assert (flags[:, :3] == [number & 1, number >> 1 & 1, number >> 2]).all()


def test_one_configuration_serves_all_poses_and_each_pose_may_have_its_own():
    positions, rotations = forward(AR2010, random_joints(AR2010, 50))
    once, _ = inverse(AR2010, positions, rotations, (1, 0, 0, 0, 1, 0))
    each, _ = inverse(AR2010, positions, rotations, np.tile((1, 0, 0, 0, 1, 0), (50, 1)))
    np.testing.assert_array_equal(once, each)
    reachable = ~np.isnan(once[:, 0])
    assert (configuration_of(AR2010, once[reachable]) == (1, 0, 0, 0, 1, 0)).all()


def test_the_five_flags_of_an_old_controller_and_the_24_of_a_new_one_say_the_same():
    poses = forward(AR2010, random_joints(AR2010, 20))
    six, _ = inverse(AR2010, *poses, (1, 0, 0, 0, 1, 0))
    for flags in ((1, 0, 0, 0, 1), (1, 0, 0, 0, 1, 0) + 18 * (0,)):
        np.testing.assert_array_equal(inverse(AR2010, *poses, flags)[0], six)


def test_poses_out_of_reach_are_nan_and_marked():
    positions, rotations = forward(AR2010, random_joints(AR2010, 5))
    positions[2] = (3.0, 0.4, 1.2)
    joints, reachable = inverse(AR2010, positions, rotations)
    assert np.isnan(joints[2]).all()
    assert not reachable[2]
    assert np.isnan(branches(AR2010, positions, rotations)[2]).all()
    assert np.isnan(track(AR2010, positions, rotations, np.zeros(6))[2]).all()


def test_a_fully_stretched_arm_is_still_in_reach():
    links = AR2010.geometry.links
    stretched = np.pi / 2 - np.arctan2(links.a3, links.d4)
    joints = np.array([[0.3, 0.4, stretched, 0.5, 0.6, 0.7], [-1.0, 0.9, stretched, 0.2, -0.6, 1.7]])
    positions, rotations = forward(AR2010, joints)
    found, reachable = inverse(AR2010, positions, rotations, configuration_of(AR2010, joints))
    assert reachable.all()
    assert_reaches(AR2010, found, positions, rotations)


@pytest.mark.parametrize("robot", **named(WRIST_ARMS))
def test_all_eight_tracked_branches_reach_the_path_without_a_jump(robot):
    positions, rotations = forward(robot, swinging(robot, 6000, amplitude=0.3))
    found = track_branches(robot, positions, rotations)
    at_start = branches(robot, positions[:1], rotations[:1])[0]
    np.testing.assert_allclose(found[0], at_start, atol=1e-12)
    for number in range(8):
        joints = found[:, number]
        if np.isnan(joints).any():
            continue
        assert_reaches(robot, joints, positions, rotations)
        near = singularities(robot, joints, angle=0.02, length=0.02)
        calm = ~(near.wrist | near.elbow | near.shoulder)
        assert np.abs(np.diff(joints, axis=0))[calm[1:] & calm[:-1]].max() < 0.3


def test_track_follows_the_joints_that_made_the_path_over_many_turns_and_wrist_flips():
    joints = swinging(AR2010, 20000, amplitude=0.3)
    joints[:, 3] = np.linspace(-2.5, 2.5, 20000) * np.pi
    joints[:, 4] = 0.9 * np.cos(np.linspace(0.0, 25.0, 20000))
    joints[:, 5] = np.linspace(3.5, -3.5, 20000) * np.pi
    found = track(AR2010, *forward(AR2010, joints), joints[0])
    np.testing.assert_allclose(found, joints, atol=1e-7)


def test_track_does_not_depend_on_how_the_path_is_cut_into_blocks(monkeypatch):
    joints = swinging(AR2010, 3000, amplitude=0.4)
    joints[:, 4] = 0.9 * np.cos(np.linspace(0.0, 25.0, 3000))
    poses = forward(AR2010, joints)
    whole = track_branches(AR2010, *poses)
    monkeypatch.setattr("olp.robots.kinematics.tracking.BLOCK", 37)
    np.testing.assert_allclose(track_branches(AR2010, *poses), whole, atol=1e-12)


@pytest.mark.parametrize("robot", **named(WRIST_ARMS))
def test_the_short_way_of_tracking_gives_what_following_all_branches_gives(robot, monkeypatch):
    joints = swinging(robot, 700, amplitude=0.25, middle=np.array([0.3, 0.2, 0.1, 2.9, 0.0, -6.0]))
    joints[:, 4] = 1.1 + 0.4 * np.sin(np.linspace(0.0, 9.0, 700))
    joints = from_standard(robot.geometry.links, joints)
    poses, start = forward(robot, joints), joints[0] + 0.01
    begins, links = np.zeros(1, np.intp), robot.geometry.links
    found, calm = tracking._track_without_events(robot, links, *poses, start[None], begins)
    assert calm.all()
    monkeypatch.setattr(tracking, "_track_without_events", lambda *_: (found, ~calm))
    np.testing.assert_allclose(found, track(robot, *poses, start), atol=1e-12)


def test_many_paths_at_once_are_tracked_as_one_after_the_other():
    calm, flips, far = (swinging(AR2010, n, amplitude=0.2) for n in (40, 300, 20))
    flips[:, 4] = 0.9 * np.cos(np.linspace(0.0, 25.0, 300))
    calm[:, 5] += 2 * np.pi
    poses = [forward(AR2010, joints) for joints in (calm, flips, far, calm)]
    poses[2][0][10:] *= 3.0  # out of reach from here on
    starts = np.array([joints[0] for joints in (calm, flips, far, calm)])
    both = [np.concatenate([pose[i] for pose in poses]) for i in range(2)]
    found = track_paths(AR2010, *both, starts, np.array([0, 40, 340, 360]))
    single = [track(AR2010, *pose, start) for pose, start in zip(poses, starts, strict=True)]
    np.testing.assert_allclose(found, np.concatenate(single), atol=1e-12)
    assert np.isnan(found[350:360]).any()
    np.testing.assert_allclose(found[360:], calm, atol=1e-7)


def test_track_passes_over_the_shoulder_with_the_arm_leaning_back():
    joints = np.tile([0.4, 0.0, 1.0, 0.3, 0.8, 0.2], (4001, 1))
    joints[:, 1] = np.linspace(-0.2, -1.5, 4001)
    found = track(AR2010, *forward(AR2010, joints), joints[0])
    flags = configuration_of(AR2010, joints)
    assert flags[0, 2] == 0
    assert flags[-1, 2] == 1
    np.testing.assert_allclose(found, joints, atol=1e-7)


def test_a_straight_wrist_keeps_its_r_axis_where_the_start_has_it():
    joints = np.zeros((300, 6)) + np.array([0.1, 0.2, 0.3, 0.7, 0.0, -0.4])
    joints[:, 1] += np.linspace(0.0, 0.3, 300)
    found = track(AR2010, *forward(AR2010, joints), joints[0])
    np.testing.assert_allclose(found, joints, atol=1e-9)


def test_a_straight_wrist_inside_a_path_does_not_turn():
    joints = np.tile([0.1, 0.2, 0.3, 0.7, 0.5, -0.4], (301, 1))
    joints[:, 4] = np.maximum(np.abs(np.linspace(-0.5, 0.5, 301)) - 0.2, 0.0)
    found = track(AR2010, *forward(AR2010, joints), joints[0])
    np.testing.assert_allclose(found, joints, atol=1e-6)


@pytest.mark.parametrize("b", [0.0, 1e-9, 1e-8, 1e-6, -1e-9, np.pi])
def test_straight_and_folded_wrists_keep_their_orientation(b):
    joints = np.array([[0.1, 0.2, 0.3, 0.7, b, -0.4]])
    positions, rotations = forward(HC20, joints)
    found, _ = inverse(HC20, positions, rotations, configuration_of(HC20, joints))
    assert rotation_angle(forward(HC20, found)[1], rotations).max() < 3e-7


def test_singularities_are_flagged_where_the_jacobian_loses_rank():
    joints = random_joints(AR2010, 3000)
    near = singularities(AR2010, joints, angle=0.02, length=0.02)
    smallest = np.linalg.svd(jacobian(AR2010, joints), compute_uv=False)[:, -1]
    flagged = near.wrist | near.elbow | near.shoulder
    assert 0 < flagged.sum() < len(joints) / 5
    assert smallest[flagged].max() < 0.03
    assert smallest[~flagged].min() > 0.001


@pytest.mark.parametrize("robot", **named(MOVING))
def test_jacobian_is_the_derivative_of_forward(robot):
    joints = random_joints(robot, 1)
    analytic, step = jacobian(robot, joints)[0], 1e-6
    for axis in range(len(robot.axes)):
        up, down = joints.copy(), joints.copy()
        up[0, axis] += step
        down[0, axis] -= step
        (p_up, r_up), (p_down, r_down) = forward(robot, up), forward(robot, down)
        np.testing.assert_allclose((p_up - p_down)[0] / (2 * step), analytic[:3, axis], atol=1e-8)
        spin = (r_up - r_down)[0] @ forward(robot, joints)[1][0].T / (2 * step)
        np.testing.assert_allclose([spin[2, 1], spin[0, 2], spin[1, 0]], analytic[3:, axis], atol=1e-8)


def test_an_arm_given_as_a_chain_is_the_same_arm():
    numeric = replace(AR2010, geometry=replace(AR2010.geometry, links=None))
    joints = random_joints(AR2010, 30)
    positions, rotations = forward(AR2010, joints)
    found, reachable = inverse(numeric, positions, rotations, seed=joints + 0.02)
    assert reachable.all()
    assert_reaches(AR2010, found, positions, rotations)


@pytest.mark.parametrize("robot", **named([SIA20D, HC10, load_robot("yaskawa/sda20d")]))
def test_numeric_arms_find_a_solution_near_the_seed_and_follow_a_path(robot):
    path = swinging(robot, 400, amplitude=0.12, middle=np.linspace(0.9, 1.5, len(robot.axes)))
    assert np.linalg.svd(jacobian(robot, path), compute_uv=False)[:, -1].min() > 0.01
    positions, rotations = forward(robot, path)
    found, reachable = inverse(robot, positions, rotations, seed=path + 0.01)
    assert reachable.all()
    assert_reaches(robot, found, positions, rotations)
    assert np.abs(found - path).max() < 0.1
    followed = track(robot, positions, rotations, path[0])
    assert_reaches(robot, followed, positions, rotations)
    assert np.abs(np.diff(followed, axis=0)).max() < 0.1


def test_numeric_arms_say_what_they_cannot_reach():
    positions, rotations = forward(SIA20D, random_joints(SIA20D, 2))
    positions[1] *= 10.0
    joints, reachable = inverse(SIA20D, positions, rotations)
    assert reachable.tolist() == [True, False]
    assert np.isnan(joints[1]).all()


def test_a_pose_that_a_numeric_arm_cannot_reach_costs_few_sweeps(monkeypatch):
    """Beyond the stretched arm none, too close to the base three: each sweep of 60 steps takes some 20 ms."""
    calls = []
    solver = import_module("olp.robots.kinematics.inverse")
    real = solver.newton
    monkeypatch.setattr(solver, "newton", lambda *given: calls.append(len(given[1])) or real(*given))
    for position, most in (([9.1, 0.3, 1.2], 0), ([0.02, 0.03, 0.05], 3)):
        calls.clear()
        _, reachable = inverse(HC10, [position], np.eye(3)[None])
        assert not reachable.any()
        assert sum(size > 0 for size in calls) <= most


@pytest.mark.parametrize("robot", **named([SIA20D, HC10, load_robot("universal-robots/ur10e")]))
def test_numeric_arms_find_every_pose_that_some_joints_make(robot):
    positions, rotations = forward(robot, random_joints(robot, 60))
    found, reachable = inverse(robot, positions, rotations)
    assert reachable.all()
    assert_reaches(robot, found, positions, rotations)


def test_axis_e_sits_between_l_and_u_although_it_is_counted_last():
    e_only = np.zeros((1, 7))
    e_only[0, SIA20D.axis_names.index("E")] = 0.6
    upright, _ = forward(SIA20D, np.zeros((1, 7)))
    turned, _ = forward(SIA20D, e_only)
    np.testing.assert_allclose(turned, upright, atol=1e-12)
    bent = np.zeros((1, 7))
    bent[0, SIA20D.axis_names.index("U")] = 0.5
    e_and_u, _ = forward(SIA20D, bent + e_only)
    assert abs(e_and_u[0, 1]) > 0.1


def test_a_track_moves_along_its_axis():
    axis = Axis("X", -1.0, 4.0, 1.5, pulses_per_unit=-20000.0, linear=True)
    geometry = Geometry((Joint(0, (0.6, 0.8, 0.0), (0.1, 0.2, 0.3)),), (0.0, 0.0, 0.5))
    rail = Robot("own/rail", "own", "rail", (axis,), kind="track", geometry=geometry)
    joints = pulses_to_joints(rail, [[-40000]])
    positions, _ = forward(rail, joints)
    np.testing.assert_allclose(joints, [[2.0]])
    np.testing.assert_allclose(positions, [[0.1 + 1.2, 0.2 + 1.6, 0.8]])
    np.testing.assert_allclose(jacobian(rail, joints)[0, :3, 0], [0.6, 0.8, 0.0])


def test_pulses_survive_the_way_to_joints_and_back():
    pulses = np.random.default_rng(3).integers(-100000, 100000, (50, 6))
    np.testing.assert_array_equal(joints_to_pulses(AR2010, pulses_to_joints(AR2010, pulses)), pulses)


def test_a_tool_is_put_on_and_taken_off():
    tool = Pose.from_xyz_angles([12 * mm, -34 * mm, 256 * mm, 10 * deg, -35 * deg, 70 * deg])
    poses = forward(AR2010, random_joints(AR2010, 9))
    back = without_tool(*with_tool(*poses, tool), tool)
    np.testing.assert_allclose(back[0], poses[0], atol=1e-12)
    np.testing.assert_allclose(back[1], poses[1], atol=1e-12)
    lengths = np.linalg.norm(with_tool(*poses, tool)[0] - poses[0], axis=1)
    np.testing.assert_allclose(lengths, np.linalg.norm(tool.position))


def test_limits_are_checked_axis_by_axis():
    joints = np.array([[0.0, 156 * deg, 0.0, -150 * deg, 0.0, np.nan]])
    assert within_limits(AR2010, joints).tolist() == [[True, False, True, True, True, False]]


@pytest.mark.parametrize(
    ("call", "code", "words"),
    [
        (lambda: forward(AR2010, np.zeros((4, 7))), "K002", "6 axes"),
        (lambda: forward(replace(AR2010, geometry=None), np.zeros((4, 6))), "K001", "not known"),
        (lambda: pulses_to_joints(SIA20D, np.zeros((1, 7))), "K003", "S, L, U, R, B, T, E"),
        (lambda: configuration_of(HC10, np.zeros((1, 6))), "K004", "spherical"),
        (lambda: inverse(AR2010, np.zeros((2, 3)), np.zeros((3, 3, 3))), "K005", "shapes"),
        (lambda: inverse(AR2010, np.zeros((1, 3)), np.eye(3), (0, 0)), "K005", "to six flags"),
    ],
)
def test_wrong_calls_are_refused_in_words(call, code, words):
    with pytest.raises(OlpError, match=words) as caught:
        call()
    assert caught.value.diagnostics[0].code == code


def test_importing_the_kinematics_needs_numpy_alone():
    code = (
        "import sys, olp.robots.kinematics; "
        "print([m for m in ('scipy', 'pandas', 'rich', 'lark') if m in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"
