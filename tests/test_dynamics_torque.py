"""The acceleration law by torque limits, and what stands in for it where a robot's masses are not known."""

import numpy as np
import pytest
from dynamics_robots import random_robot

from olp.core.diagnostic import OlpError
from olp.robots.dynamics import STANDARD_GRAVITY, Body, dynamic_model, inverse_dynamics, move_acceleration
from olp.robots.robot import Drive, load_robot
from olp.timing.acceleration import load_law
from olp.timing.acceleration.torque import Torque, of_moves

UR10E = load_robot("ur10e")
LOAD = Body(5.0, (0.01, 0.02, 0.09), (0.03, 0.02, 0.01, 0.0, 0.0, 0.0))


def poses(count, seed=0):
    return np.random.default_rng(seed).uniform(-2.5, 2.5, (count, 6))


@pytest.mark.parametrize("sign", [1, -1])
def test_one_axis_accelerates_until_some_axis_has_no_torque_left(sign):
    law, q = Torque(LOAD), poses(30)
    limits, model = law.accelerations(UR10E, q, np.full((30, 6), sign)), dynamic_model(UR10E)
    assert (limits > 0.0).all()
    for axis in range(6):
        alone = np.zeros((30, 6))
        alone[:, axis] = sign * limits[:, axis]
        shares = np.abs(inverse_dynamics(model, q, np.zeros((30, 6)), alone, LOAD)) / model.torque_limits
        np.testing.assert_allclose(shares.max(axis=1), 1.0, rtol=1e-9)


def test_weight_helps_one_direction_as_it_hinders_the_other():
    """Stretched out level, joint 2 of the UR10e lowers its arm with what lifting it lacks."""
    q = np.zeros((1, 6))
    up, down = (Torque(LOAD).accelerations(UR10E, q, np.full((1, 6), s))[0, 1] for s in (1, -1))
    weights = inverse_dynamics(dynamic_model(UR10E), q, q, q, LOAD)[0, 1]
    assert abs(weights) > 100.0
    assert abs(up - down) > 10.0
    assert (up < down) == (weights > 0.0)


def test_a_load_and_a_ceiling_change_what_a_robot_can_do():
    q, forth = np.zeros((1, 6)), np.ones((1, 6))
    bare = Torque().accelerations(UR10E, q, forth)[0]
    loaded = Torque(LOAD).accelerations(UR10E, q, forth)[0]
    assert (loaded < bare).all()
    hanging = Torque(mounting="ceiling").accelerations(UR10E, q, -forth)[0]
    np.testing.assert_allclose(hanging, bare, rtol=1e-12)
    assert abs(Torque(mounting="ceiling").accelerations(UR10E, q, forth)[0, 1] - bare[1]) > 10.0


def test_starting_has_to_overcome_friction():
    drives = [Drive(200.0, coulomb=5.0 * i) for i in range(5)]
    robot, smooth = random_robot(21, drives=drives), random_robot(21, drives=[Drive(200.0)] * 5)
    weightless, q = Torque(mounting=(0.0, 0.0, 0.0)), np.random.default_rng(0).normal(size=(4, 5))
    with_friction, without = (weightless.accelerations(r, q, np.ones((4, 5))) for r in (robot, smooth))
    assert (with_friction <= without + 1e-9).all()
    assert (with_friction < without - 1e-3).any()


def test_an_axis_whose_limit_is_not_known_has_no_number():
    drives = [Drive(200.0), Drive(200.0), Drive(None), Drive(200.0), Drive(200.0)]
    limits = Torque().accelerations(random_robot(22, drives=drives), np.zeros((1, 5)), np.ones((1, 5)))
    assert np.isnan(limits[0]).tolist() == [False, False, True, False, False]


def test_a_robot_that_cannot_hold_its_load_has_no_acceleration():
    heavy = Body(2 * 330.0 / (STANDARD_GRAVITY * 1.18425))
    assert (Torque(heavy).accelerations(UR10E, np.zeros((1, 6)), np.ones((1, 6))) == 0.0).all()


@pytest.mark.parametrize("name", ["gp25", "gp7", "d500b"])
def test_without_masses_the_law_says_so_and_gives_no_number(name):
    robot = load_robot(name)
    law = load_law("torque")
    count = len(robot.axes)
    assert not law.knows(robot)
    assert np.isnan(law.accelerations(robot, np.zeros((2, count)), np.ones((2, count)))).all()
    assert load_law("torque").knows(UR10E)


def test_moves_of_a_robot_with_masses_are_limited_by_torque():
    start, end = poses(5), poses(5, seed=1)
    found = of_moves(UR10E, start, end, 0.5, LOAD)
    theirs = move_acceleration(dynamic_model(UR10E), start, end, 0.5, LOAD)
    np.testing.assert_array_equal(found.acceleration, theirs.acceleration)
    np.testing.assert_array_equal(found.deceleration, theirs.deceleration)
    assert all("taken as zero" in says for says in found.assumptions)


def test_moves_of_a_robot_without_masses_take_its_files_accelerations_and_say_so():
    robot = load_robot("gp25")
    start, end = np.zeros((2, 6)), np.array([[0.5, 0, 0, 0, 0, 0], [0.5, -1.0, 0, 0, 0, 0]])
    found = of_moves(robot, start, end, 1.0, LOAD)
    a = robot.accelerations
    np.testing.assert_allclose(found.acceleration, [a[0] / 0.5, min(a[0] / 0.5, a[1])])
    (says,) = found.assumptions
    assert "masses and torque limits are not known" in says
    assert "for every pose and load" in says


@pytest.mark.parametrize("robot", [UR10E, load_robot("gp25")], ids=["masses", "no-masses"])
def test_a_move_without_speed_is_an_error_with_and_without_masses(robot):
    with pytest.raises(OlpError) as caught:
        of_moves(robot, np.zeros((2, 6)), np.ones((2, 6)), [1.0, 0.0])
    assert [d.code for d in caught.value.diagnostics] == ["K008"]


def test_moves_of_a_robot_of_which_nothing_is_known_have_no_number():
    found = of_moves(load_robot("gp7"), np.zeros((2, 6)), np.ones((2, 6)), 1.0)
    assert np.isnan(found.acceleration).all()
    assert "nor are its accelerations" in found.assumptions[0]
