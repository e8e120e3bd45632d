"""Inverse dynamics against closed forms and against the energy of the same bodies, which knows no recursion."""

import numpy as np
import pytest
from dynamics_robots import height_energy, lagrange_torques, mass_and_weight, random_robot, robot_of

from olp.core.diagnostic import OlpError
from olp.robots.dynamics import (
    STANDARD_GRAVITY,
    Body,
    bias_forces,
    dynamic_model,
    gravity_of,
    gravity_torques,
    inertia_forces,
    inverse_dynamics,
    mass_matrix,
    payload_of,
)
from olp.robots.dynamics.torques import BLOCK
from olp.robots.geometry import Pose
from olp.robots.kinematics import forward
from olp.robots.kinematics.configuration import Tool
from olp.robots.robot import Drive, load_robot

GRAVITY = (1.3, -4.1, -8.2)
LOAD = Body(4.2, (0.03, -0.05, 0.11), (0.04, 0.05, 0.03, 0.004, -0.003, 0.002))
CHAINS = {
    "turning": random_robot(1),
    "coordinate axes": random_robot(2, coordinate_axes=True),
    "sliding first": random_robot(3, slides=(0, 1), coordinate_axes=True),
    "sliding between": random_robot(4, slides=(2,)),
    "sliding only": random_robot(5, count=3, slides=(0, 1, 2)),
    "one axis": random_robot(6, count=1),
    "UR10e": load_robot("ur10e"),
}


@pytest.fixture(params=CHAINS, ids=lambda name: name.replace(" ", "-"))
def robot(request):
    return CHAINS[request.param]


def motion(robot, count, seed=0):
    rng = np.random.default_rng(seed)
    return tuple(rng.normal(size=(count, len(robot.axes))) * 1.5 for _ in range(3))


def two_links(m1=3.1, m2=2.3, l1=0.71, lg1=0.33, lg2=0.27, i1=0.05, i2=0.04):
    """Figure 5.4 of Apostolovic's thesis: both axes along z, weight along -y."""
    z = (0.0, 0.0, 1.0)
    bodies = [
        Body(m, (lg, 0.0, 0.0), (9.0, 9.0, i, 0.0, 0.0, 0.0)) for m, lg, i in ((m1, lg1, i1), (m2, lg2, i2))
    ]
    return robot_of([(0, z, (0.0, 0.0, 0.0)), (1, z, (l1, 0.0, 0.0))], bodies)


def two_link_torques(q, qd, qdd, second_lever):
    """Section 5.2.1, with the lever of the second link's weight on joint 1 as given (erratum 23: l_g2, not l_g1)."""
    m1, m2, l1, lg1, lg2, i1, i2, g = 3.1, 2.3, 0.71, 0.33, 0.27, 0.05, 0.04, 9.81
    c, s = np.cos(q[:, 1]), np.sin(q[:, 1])
    level, both = np.cos(q[:, 0]), np.cos(q[:, 0] + q[:, 1])
    m12 = m2 * (lg2**2 + l1 * lg2 * c) + i2
    m11 = m1 * lg1**2 + i1 + m2 * (l1**2 + lg2**2 + 2 * l1 * lg2 * c) + i2
    coriolis = m2 * l1 * lg2 * s
    first = m11 * qdd[:, 0] + m12 * qdd[:, 1] - coriolis * (2 * qd[:, 0] * qd[:, 1] + qd[:, 1] ** 2)
    first += m1 * g * lg1 * level + m2 * g * (l1 * level + second_lever * both)
    second = m12 * qdd[:, 0] + (m2 * lg2**2 + i2) * qdd[:, 1] + coriolis * qd[:, 0] ** 2 + m2 * g * lg2 * both
    return np.stack([first, second], axis=1)


def test_the_two_link_arm_of_the_thesis_has_the_torques_of_its_lagrange_equations():
    q, qd, qdd = motion(two_links(), 50)
    ours = inverse_dynamics(dynamic_model(two_links(), (0.0, -9.81, 0.0)), q, qd, qdd)
    np.testing.assert_allclose(ours, two_link_torques(q, qd, qdd, second_lever=0.27), rtol=1e-12, atol=1e-12)
    assert np.abs(ours - two_link_torques(q, qd, qdd, second_lever=0.33)).max() > 1.0


def test_torques_are_those_of_the_lagrangian_of_the_same_bodies(robot):
    q, qd, qdd = motion(robot, 6)
    ours = inverse_dynamics(dynamic_model(robot, GRAVITY), q, qd, qdd, LOAD)
    theirs = [lagrange_torques(robot, *row, GRAVITY, LOAD) for row in zip(q, qd, qdd, strict=True)]
    np.testing.assert_allclose(ours, theirs, rtol=1e-7, atol=1e-7)


def test_the_mass_matrix_is_that_of_the_kinetic_energy_symmetric_and_positive(robot):
    q = motion(robot, 20)[0]
    matrix = mass_matrix(dynamic_model(robot), q, LOAD)
    expected = [mass_and_weight(robot, row, GRAVITY, LOAD)[0] for row in q]
    np.testing.assert_allclose(matrix, expected, rtol=1e-11, atol=1e-12)
    np.testing.assert_array_equal(matrix, matrix.transpose(0, 2, 1))
    assert np.linalg.eigvalsh(matrix).min() > 0.0


def test_gravity_torques_are_the_slope_of_the_height_energy(robot):
    model, q, h = dynamic_model(robot, GRAVITY), motion(robot, 4)[0], 1e-6
    for row, torques in zip(q, gravity_torques(model, q, LOAD), strict=True):
        for axis, torque in enumerate(torques):
            up, down = (
                height_energy(robot, row + s * h * np.eye(len(row))[axis], GRAVITY, LOAD) for s in (1, -1)
            )
            assert torque == pytest.approx((up - down) / (2 * h), rel=1e-6, abs=1e-6)


def test_the_parts_of_equation_5_1_add_up():
    drives = [Drive(rotor=0.3 + i, viscous=2.0 - i / 4, coulomb=1.5 * i) for i in range(5)]
    robot = random_robot(7, drives=drives)
    q, qd, qdd = motion(robot, 30)
    model = dynamic_model(robot, GRAVITY)
    accelerating = np.einsum("nij,nj->ni", mass_matrix(model, q, LOAD), qdd)
    torques = inverse_dynamics(model, q, qd, qdd, LOAD)
    np.testing.assert_allclose(
        torques, accelerating + bias_forces(model, q, qd, LOAD), rtol=1e-11, atol=1e-11
    )
    np.testing.assert_allclose(
        inertia_forces(model, q, None, qdd, LOAD), accelerating, rtol=1e-11, atol=1e-11
    )


def test_friction_and_rotors_act_on_their_own_joint_only():
    drives = [Drive(rotor=0.5 * i, viscous=2.0 * i, coulomb=3.0 * i) for i in range(5)]
    bare, driven = random_robot(8), random_robot(8, drives=drives)
    q, qd, qdd = motion(bare, 10)
    more = inverse_dynamics(dynamic_model(driven), q, qd, qdd) - inverse_dynamics(
        dynamic_model(bare), q, qd, qdd
    )
    index = np.arange(5)
    np.testing.assert_allclose(more, index * (0.5 * qdd + 2.0 * qd + 3.0 * np.sign(qd)), rtol=1e-9, atol=1e-9)


def test_a_free_swing_keeps_its_energy(robot):
    """Runge-Kutta steps of the motion that no torque makes: a wrong sign anywhere and energy drifts away."""
    model = dynamic_model(robot, GRAVITY)
    q, qd = (row[:1] * 0.5 for row in motion(robot, 1)[:2])

    def change(q, qd):
        return qd, -np.linalg.solve(mass_matrix(model, q), bias_forces(model, q, qd)[..., None])[..., 0]

    def energy(q, qd):
        moving = 0.5 * qd[0] @ mass_matrix(model, q)[0] @ qd[0]
        return moving, moving + height_energy(robot, q[0], GRAVITY)

    start, h = energy(q, qd), 1e-3
    for _ in range(60):
        k1 = change(q, qd)
        k2 = change(q + h / 2 * k1[0], qd + h / 2 * k1[1])
        k3 = change(q + h / 2 * k2[0], qd + h / 2 * k2[1])
        k4 = change(q + h * k3[0], qd + h * k3[1])
        q = q + h / 6 * (k1[0] + 2 * k2[0] + 2 * k3[0] + k4[0])
        qd = qd + h / 6 * (k1[1] + 2 * k2[1] + 2 * k3[1] + k4[1])
    end = energy(q, qd)
    assert abs(end[0] - start[0]) > 0.01
    assert end[1] == pytest.approx(start[1], rel=1e-7, abs=1e-7)


def test_a_load_is_held_by_weight_times_distance():
    robot = load_robot("ur10e")
    q = motion(robot, 8)[0]
    load = Body(7.0, (0.02, 0.04, 0.09))
    model = dynamic_model(robot)
    more = gravity_torques(model, q, load) - gravity_torques(model, q)
    positions, rotations = forward(robot, q)
    centres = positions + rotations @ np.array(load.centre)
    # The shoulder turns about a level line through the base's axis, so its lever is the distance along the arm's plane.
    level = np.stack([np.cos(q[:, 0]), np.sin(q[:, 0])], axis=1)
    levers = np.einsum("ni,ni->n", centres[:, :2], level)
    np.testing.assert_allclose(more[:, 1], 7.0 * STANDARD_GRAVITY * levers, rtol=1e-10, atol=1e-10)
    np.testing.assert_allclose(more[:, 0], 0.0, atol=1e-10)


def test_many_samples_are_many_single_samples():
    robot = CHAINS["sliding first"]
    q, qd, qdd = motion(robot, 2 * BLOCK + 3)
    model = dynamic_model(robot)
    together = inverse_dynamics(model, q, qd, qdd)
    for i in (0, BLOCK - 1, BLOCK, 2 * BLOCK - 1, 2 * BLOCK + 2):
        np.testing.assert_allclose(
            together[i], inverse_dynamics(model, q[i], qd[i], qdd[i])[0], rtol=1e-12, atol=1e-12
        )
    assert inverse_dynamics(model, q[:0], qd[:0], qdd[:0]).shape == (0, 5)


def test_torques_without_weight_or_motion_are_zero(robot):
    still = np.zeros((3, len(robot.axes)))
    np.testing.assert_array_equal(
        inverse_dynamics(dynamic_model(robot, (0.0, 0.0, 0.0)), still + 0.4, still, still), still
    )


def test_under_a_ceiling_weight_turns_round_and_on_a_wall_it_pulls_along_x():
    robot = load_robot("ur10e")
    q = motion(robot, 5)[0]
    floor, wall, ceiling = (gravity_torques(dynamic_model(robot, m), q) for m in ("floor", "wall", "ceiling"))
    np.testing.assert_array_equal(floor, -ceiling)
    np.testing.assert_allclose(
        wall, gravity_torques(dynamic_model(robot, (STANDARD_GRAVITY, 0, 0)), q), atol=1e-12
    )
    assert np.abs(wall[:, 0]).max() > 1.0
    assert gravity_of(0.3) == pytest.approx(
        (STANDARD_GRAVITY * np.sin(0.3), 0.0, -STANDARD_GRAVITY * np.cos(0.3))
    )


@pytest.mark.parametrize(
    ("name", "call", "code"),
    [
        ("gp25", lambda m, q: m, "K006"),
        ("ur10e", lambda m, q: inverse_dynamics(m, q[:, :5], q, q), "K002"),
        ("ur10e", lambda m, q: inverse_dynamics(m, q, q[:1], q), "K007"),
        ("ur10e", lambda m, q: bias_forces(m, q, q[:1]), "K007"),
    ],
)
def test_what_cannot_be_computed_is_said(name, call, code):
    with pytest.raises(OlpError) as caught:
        call(dynamic_model(load_robot(name)), np.zeros((2, 6)))
    assert [d.code for d in caught.value.diagnostics] == [code]


def test_a_model_says_what_it_does_not_know():
    says = dynamic_model(load_robot("ur10e")).assumptions
    assert len(says) == 2
    assert "inertia of the rotors is not known" in says[0]
    assert "friction is not known" in says[1]


def test_a_tool_is_a_load_and_says_what_of_it_is_assumed():
    flange = Pose.identity()
    assert payload_of(Tool(flange, "GUN"))[0] is None
    assert "mass of tool GUN is not known" in payload_of(Tool(flange, "GUN"))[1][0]
    load, says = payload_of(Tool(flange, mass=3.0))
    assert load == Body(3.0)
    assert len(says) == 2
    load, says = payload_of(Tool(flange, mass=3.0, centre=(0.1, 0.2, 0.3), inertia=(1.0, 2.0, 3.0)))
    assert load == Body(3.0, (0.1, 0.2, 0.3), (1.0, 2.0, 3.0, 0.0, 0.0, 0.0))
    assert says == ()
