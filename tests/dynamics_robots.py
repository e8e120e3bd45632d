"""Machines for the tests of dynamics, and their energy from first principles: positions of masses, nothing else."""

import numpy as np

from olp.robots.dynamics import Body
from olp.robots.robot import Axis, Drive, Dynamics, Geometry, Joint, Robot


def robot_of(joints, bodies, drives=None, linear=(), flange=(0.0, 0.0, 0.0)):
    """A robot of (axis, direction, offset) joints; bodies and drives in the order of its axes."""
    count = len(joints)
    axes = tuple(Axis(f"A{i}", -9.0, 9.0, 1.0, linear=i in linear) for i in range(count))
    geometry = Geometry(tuple(Joint(*joint) for joint in joints), flange)
    dynamics = Dynamics(tuple(bodies), tuple(drives or (Drive() for _ in range(count))))
    return Robot("test/arm", "Test", "arm", axes, geometry=geometry, dynamics=dynamics)


def random_body(rng):
    """A body whose inertia is that of a handful of points, so it is one that can exist."""
    points = rng.normal(size=(5, 3)) * 0.1
    points -= points.mean(axis=0)
    inertia = sum(np.dot(p, p) * np.eye(3) - np.outer(p, p) for p in points)
    return Body(rng.uniform(1, 9), tuple(rng.normal(size=3) * 0.2), packed(inertia))


def random_robot(seed, count=5, slides=(), coordinate_axes=False, drives=None):
    """Any chain: directions not along coordinate axes, axes counted in another order than the joints."""
    rng = np.random.default_rng(seed)
    directions = rng.normal(size=(count, 3))
    if coordinate_axes:
        directions = rng.choice([-1.0, 1.0], size=(count, 1)) * np.eye(3)[rng.integers(0, 3, count)]
    directions /= np.linalg.norm(directions, axis=1)[:, None]
    order = rng.permutation(count)
    offsets = rng.normal(size=(count, 3)) * 0.4
    joints = [
        (int(i), tuple(d.tolist()), tuple(o.tolist()))
        for i, d, o in zip(order, directions, offsets, strict=True)
    ]
    bodies = [random_body(rng) for _ in range(count)]
    return robot_of(joints, bodies, drives, slides, tuple(rng.normal(size=3) * 0.1))


def packed(inertia):
    pairs = ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))
    return tuple(float(inertia[pair]) for pair in pairs)


def rotation(direction, angle):
    x, y, z = direction
    skew = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + np.sin(angle) * skew + (1 - np.cos(angle)) * skew @ skew


def link_frames(robot, q):
    """Rotation and origin of every link, and point and direction of its axis, in chain order, in the base frame."""
    turned, place, frames = np.eye(3), np.zeros(3), []
    for joint in robot.geometry.joints:
        place = place + turned @ joint.offset
        axis = turned @ joint.direction
        if robot.axes[joint.axis].linear:
            place = place + axis * q[joint.axis]
        else:
            turned = turned @ rotation(joint.direction, q[joint.axis])
        frames.append((joint.axis, turned, place, axis))
    return frames


def bodies_of(robot, q, payload=None):
    """(mass, centre, inertia, joints that move it) of everything that has a mass, in the base frame."""
    frames = link_frames(robot, q)
    found = []
    for i, (index, turned, place, _) in enumerate(frames):
        body = robot.dynamics.bodies[index]
        found.append(
            (body.mass, place + turned @ body.centre, turned @ full(body.inertia) @ turned.T, frames[: i + 1])
        )
    if payload is not None:
        _, turned, place, _ = frames[-1]
        flange = turned @ np.array(robot.geometry.flange_rotation)
        centre = place + turned @ robot.geometry.flange_offset + flange @ payload.centre
        found.append((payload.mass, centre, flange @ full(payload.inertia) @ flange.T, frames))
    return found


def full(inertia):
    xx, yy, zz, xy, xz, yz = inertia
    return np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])


def mass_and_weight(robot, q, gravity, payload=None):
    """M (k, k) and g (k,) from the velocities of all centres of mass: kinetic energy is half q' M q'."""
    count = len(q)
    mass_matrix, weight = np.zeros((count, count)), np.zeros(count)
    for mass, centre, inertia, frames in bodies_of(robot, q, payload):
        travel, turning = np.zeros((3, count)), np.zeros((3, count))
        for index, _, place, axis in frames:
            if robot.axes[index].linear:
                travel[:, index] = axis
            else:
                travel[:, index], turning[:, index] = np.cross(axis, centre - place), axis
        mass_matrix += mass * travel.T @ travel + turning.T @ inertia @ turning
        weight -= mass * travel.T @ np.asarray(gravity)
    return mass_matrix, weight


def lagrange_torques(robot, q, qd, qdd, gravity, payload=None, step=1e-5):
    """d/dt dT/dq' - dT/dq + dV/dq, the slopes of M by central differences."""
    count = len(q)
    slopes = np.empty((count, count, count))
    for k in range(count):
        move = np.eye(count)[k] * step
        after, before = (mass_and_weight(robot, q + sign * move, gravity, payload)[0] for sign in (1, -1))
        slopes[k] = (after - before) / (2 * step)
    mass_matrix, weight = mass_and_weight(robot, q, gravity, payload)
    coriolis = np.einsum("kij,j,k->i", slopes, qd, qd) - 0.5 * np.einsum("ijk,j,k->i", slopes, qd, qd)
    return mass_matrix @ qdd + coriolis + weight


def height_energy(robot, q, gravity, payload=None):
    return -sum(mass * np.dot(gravity, centre) for mass, centre, _, _ in bodies_of(robot, q, payload))
