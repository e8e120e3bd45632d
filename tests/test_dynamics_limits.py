"""What the torques allow: every interval and every ramp is driven again and its torques are looked at."""

import math

import numpy as np
import pytest
from dynamics_robots import random_robot, robot_of

from olp.core.diagnostic import OlpError
from olp.robots.dynamics import (
    Body,
    acceleration_interval,
    dynamic_model,
    inverse_dynamics,
    move_acceleration,
    path_acceleration,
    path_torque,
)
from olp.robots.robot import Drive, load_robot

DRIVES = [Drive(90.0 + 9 * i, rotor=0.2, viscous=3.0, coulomb=2.0 + i) for i in range(5)]
ARM = dynamic_model(random_robot(11, drives=DRIVES), (0.4, -0.2, -0.9))
UR10E = dynamic_model(load_robot("ur10e"))
LOAD = Body(6.0, (0.02, -0.03, 0.1), (0.03, 0.02, 0.01, 0.0, 0.0, 0.0))


def path(count, seed=0):
    rng = np.random.default_rng(seed)
    return tuple(rng.normal(size=(count, 5)) for _ in range(3))


def test_torques_along_a_path_are_those_of_its_motion_in_time():
    q, slope, curvature = path(40)
    speed, acceleration = np.linspace(0.1, 2.0, 40), np.linspace(-3.0, 3.0, 40)
    ours = path_torque(ARM, q, slope, curvature, LOAD).at(speed, acceleration)
    v, a = speed[:, None], acceleration[:, None]
    theirs = inverse_dynamics(ARM, q, slope * v, slope * a + curvature * v**2, LOAD)
    np.testing.assert_allclose(ours, theirs, rtol=1e-10, atol=1e-10)


def test_who_starts_has_to_overcome_friction_though_he_stands():
    q, slope, curvature = path(5)
    torque = path_torque(ARM, q, slope, curvature)
    without = path_torque(dynamic_model(random_robot(11), ARM.gravity), q, slope, curvature)
    more = torque.at(0.0, 0.0) - without.at(0.0, 0.0)
    np.testing.assert_allclose(more, np.sign(slope) * (2.0 + np.arange(5)), rtol=1e-10)


def test_an_interval_ends_where_the_named_axis_has_no_more_torque():
    q, slope, curvature = path(300)
    speed = np.linspace(0.0, 8.0, 300)
    torque, limits = path_torque(ARM, q, slope, curvature, LOAD), ARM.torque_limits
    found = path_acceleration(ARM, q, slope, curvature, speed, LOAD)
    ok = found.feasible
    assert 50 < ok.sum() < 300
    for end, axis in ((found.lower, found.lower_axis), (found.upper, found.upper_axis)):
        shares = np.abs(torque.at(speed, end)) / limits
        assert (shares[ok] <= 1.0 + 1e-9).all()
        np.testing.assert_allclose(shares[ok, axis[ok]], 1.0, rtol=1e-9)
        outside = end + (end - (found.lower + found.upper) / 2) * 1e-3
        assert ((np.abs(torque.at(speed, outside)) / limits)[ok].max(axis=1) > 1.0).all()


def test_where_the_interval_is_empty_no_acceleration_holds_the_limits():
    q, slope, curvature = path(300)
    torque = path_torque(ARM, q, slope, curvature, LOAD)
    found = acceleration_interval(torque, 6.0, ARM.torque_limits)
    assert (~found.feasible).any()
    for rate in np.linspace(-60, 60, 121):
        over = (np.abs(torque.at(6.0, rate)) > ARM.torque_limits).any(axis=1)
        assert over[~found.feasible].all()


def pendulum(limit, gravity, drive=None, mass=5.0, length=0.8):
    """One arm that turns about y, its mass at the end of a rod, level at zero."""
    robot = robot_of(
        [(0, (0.0, -1.0, 0.0), (0.0, 0.0, 0.0))],
        [Body(mass, (length, 0.0, 0.0))],
        [drive or Drive(limit)],
    )
    return dynamic_model(robot, (0.0, 0.0, -gravity))


def test_an_axis_that_carries_nothing_along_the_path_limits_nothing_until_it_is_overloaded():
    z = (0.0, 0.0, 1.0)
    robot = robot_of(
        [(0, z, (0.0, 0.0, 0.0)), (1, (0.0, -1.0, 0.0), (0.0, 0.0, 0.0))],
        [Body(1.0, (0.5, 0.0, 0.0)), Body(2.0, (0.5, 0.0, 0.0))],
        [Drive(10.0), Drive(11.0)],
    )
    slow = path_acceleration(dynamic_model(robot), [[0.0, 0.0]], [[1.0, 0.0]], [[0.0, 0.0]], 0.0)
    assert slow.feasible.all()
    assert slow.upper[0] == pytest.approx(10.0 / (0.25 + 0.5))
    weak = robot_of(
        [(j.axis, j.direction, j.offset) for j in robot.geometry.joints],
        robot.dynamics.bodies,
        [Drive(10.0), Drive(9.0)],
    )
    assert not path_acceleration(
        dynamic_model(weak), [[0.0, 0.0]], [[1.0, 0.0]], [[0.0, 0.0]], 0.0
    ).feasible.any()


def test_a_pendulum_without_weight_accelerates_at_torque_over_inertia():
    found = move_acceleration(pendulum(40.0, 0.0), [[-0.7]], [[1.3]], 0.4)
    np.testing.assert_allclose(found.acceleration * 2.0, 40.0 / (5.0 * 0.8**2), rtol=1e-9)
    np.testing.assert_allclose(found.deceleration, found.acceleration)


def test_a_pendulum_that_is_lifted_brakes_better_than_it_starts():
    weight, inertia = 5.0 * 9.81 * 0.8, 5.0 * 0.8**2
    model = pendulum(60.0, 9.81)
    found = move_acceleration(model, [[-0.05]], [[0.05]], 100.0)
    # Around level the lever hardly changes: its largest value counts up, its smallest down.
    assert found.acceleration[0] * 0.1 == pytest.approx((60.0 - weight) / inertia, rel=1e-4)
    assert found.deceleration[0] * 0.1 == pytest.approx((60.0 + weight * math.cos(0.05)) / inertia, rel=1e-4)


def test_friction_makes_starting_harder_and_stopping_easier():
    model = pendulum(0.0, 0.0, Drive(40.0, viscous=5.0, coulomb=7.0))
    inertia = 5.0 * 0.8**2
    # The peak of the drive's torque is at the end of the ramp, at 0.4 of a move of 2 rad per second.
    found = move_acceleration(model, [[-0.7]], [[1.3]], 0.4)
    assert found.acceleration[0] * 2.0 == pytest.approx((40.0 - 7.0 - 5.0 * 0.8) / inertia, rel=1e-6)
    assert found.deceleration[0] * 2.0 == pytest.approx((40.0 + 7.0) / inertia, rel=1e-6)


def test_a_robot_that_cannot_hold_its_load_does_not_move():
    found = move_acceleration(pendulum(30.0, 9.81), [[-0.1]], [[0.1]], 1.0)
    assert found.acceleration[0] == 0.0
    assert found.deceleration[0] == 0.0
    assert found.acceleration_axis[0] == 0


def test_without_torque_limits_nothing_limits():
    robot = random_robot(12)
    found = move_acceleration(dynamic_model(robot), np.zeros((2, 5)), np.ones((2, 5)), [1.0, 2.0])
    assert np.isinf([*found.acceleration, *found.deceleration]).all()


def driven(model, start, end, top, acceleration, deceleration, payload):
    """Shares (m, k) of the torque limits on the way of one move, up and down, and which samples are its start."""
    peak = min(top, math.sqrt(2 * acceleration * deceleration / (acceleration + deceleration)))
    up, down = np.linspace(0.0, peak / acceleration, 60), np.linspace(peak / deceleration, 0.0, 60)
    s = np.concatenate([acceleration * up**2 / 2, 1 - deceleration * down**2 / 2])
    v = np.concatenate([acceleration * up, deceleration * down])
    a = np.repeat([acceleration, -deceleration], 60)
    q = start + (end - start) * s[:, None]
    torque = inverse_dynamics(model, q, (end - start) * v[:, None], (end - start) * a[:, None], payload)
    return np.abs(torque) / model.torque_limits


def test_moves_of_a_real_arm_hold_all_torque_limits_and_use_the_named_one():
    rng = np.random.default_rng(3)
    start, end = rng.uniform(-2.5, 2.5, (40, 6)), rng.uniform(-2.5, 2.5, (40, 6))
    end[::2] = start[::2] + (end[::2] - start[::2]) * 0.1
    top = (UR10E.robot.speeds / np.abs(end - start)).min(axis=1)
    found = move_acceleration(UR10E, start, end, top, LOAD)
    used_up, used_down = [], []
    for i in range(40):
        shares = driven(UR10E, start[i], end[i], top[i], found.acceleration[i], found.deceleration[i], LOAD)
        assert shares.max() < 1.01
        used_up.append(shares[:60, found.acceleration_axis[i]].max())
        used_down.append(shares[60:, found.deceleration_axis[i]].max())
    assert np.median(used_up) > 0.995
    assert np.median(used_down) > 0.995
    assert len(set(found.acceleration_axis.tolist())) > 2


def test_a_heavier_load_never_lets_a_move_start_faster_from_the_same_stretched_pose():
    start, end = np.zeros((1, 6)), np.array([[0.5, 0.3, 0.0, 0.0, 0.0, 0.0]])
    rates = [
        move_acceleration(UR10E, start, end, 1.0, Body(mass)).acceleration[0] for mass in (0.1, 3.0, 6.0, 9.0)
    ]
    assert rates == sorted(rates, reverse=True)
    assert rates[0] > 1.5 * rates[-1] > 0.0


@pytest.mark.parametrize("speed", [0.0, -1.0, math.nan, math.inf])
def test_a_speed_that_is_none_is_an_error(speed):
    with pytest.raises(OlpError) as caught:
        move_acceleration(UR10E, np.zeros((1, 6)), np.ones((1, 6)), speed)
    assert [d.code for d in caught.value.diagnostics] == ["K008"]
