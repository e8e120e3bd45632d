"""Inverse kinematics of any serial chain near a start position, by damped Newton steps on many poses at once."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from olp.robots.kinematics.chain import as_joints, forward, geometry_of, jacobian
from olp.robots.kinematics.configuration import wrap
from olp.robots.model import Robot

Array = NDArray[np.float64]

_STEPS = 60
_SOLVED = 1e-11  # [m and rad] largest error of a solved pose
_LONGEST_STEP = 0.4  # [rad] per axis: a longer one leaves the region where the Jacobian means something
# Further starts, tried where the given one does not lead to a solution, and poses that try them at the same time:
# the steps of a thousand starts cost hardly more than those of one.
_ATTEMPTS = 24
_TOGETHER = 64


def solve_from(
    robot: Robot, position: Array, rotation: Array, start: ArrayLike
) -> tuple[Array, NDArray[np.bool_]]:
    """Joints (n, k) [rad | m] near `start` (k,) or (n, k) for poses (n, 3) [m], (n, 3, 3), and (n,) solved.

    Where the start leads nowhere, fixed pseudo-random starts inside the limits follow; nan if all fail.
    Turning axes end within half a turn of the start.
    Raises OlpError: K001 no geometry, K002 number of axes.
    """
    seeds = np.broadcast_to(as_joints(robot, start), (len(position), len(robot.axes)))
    joints, solved = np.array(seeds, dtype=np.float64), np.zeros(len(position), dtype=bool)
    near = np.flatnonzero(np.linalg.norm(position, axis=1) <= _reach(robot))
    joints[near], solved[near] = newton(robot, position[near], rotation[near], seeds[near])
    # One start more helps most poses; what is still open then is mostly out of reach and gets all others at once.
    for first, last in ((0, 1), (1, _ATTEMPTS)):
        open_poses = near[~solved[near]]
        for begin in range(0, len(open_poses), _TOGETHER):
            some = open_poses[begin : begin + _TOGETHER]
            starts = np.random.default_rng(20 + first).uniform(
                robot.lower, robot.upper, (last - first, len(robot.axes))
            )
            found, good = _from_all(robot, position[some], rotation[some], starts)
            joints[some[good]], solved[some] = found[good], good
    turning = np.array([not axis.linear for axis in robot.axes])
    joints = np.where(turning, wrap(joints, seeds), joints)
    joints[~solved] = np.nan
    return joints, solved


def _from_all(
    robot: Robot, position: Array, rotation: Array, starts: Array
) -> tuple[Array, NDArray[np.bool_]]:
    """Every pose (n) from every start (s, k): the joints (n, k) that the first good start leads to, (n,) solved."""
    count, tries = len(position), len(starts)
    found, good = newton(
        robot,
        np.repeat(position, tries, axis=0),
        np.repeat(rotation, tries, axis=0),
        np.tile(starts, (count, 1)),
    )
    table = good.reshape(count, tries)
    solved: NDArray[np.bool_] = np.any(table, axis=1)
    return found.reshape(count, tries, -1)[np.arange(count), table.argmax(axis=1)], solved


def _reach(robot: Robot) -> float:
    """[m] No pose stands further from the base: the stretched chain, its slides drawn out."""
    geometry = geometry_of(robot)
    offsets = [joint.offset for joint in geometry.joints] + [geometry.flange_offset]
    slides = sum(max(abs(axis.lower), abs(axis.upper)) for axis in robot.axes if axis.linear)
    return float(sum(np.linalg.norm(offset) for offset in offsets)) + slides


def newton(robot: Robot, position: Array, rotation: Array, seeds: Array) -> tuple[Array, NDArray[np.bool_]]:
    """Levenberg-Marquardt from `seeds` (n, k): joints (n, k) and which of them (n,) reach their pose.

    The damping is the error itself, so steps are safe far away and quadratic near the solution; with more
    than six axes the step is the shortest one. (S. Buss, "Introduction to inverse kinematics with Jacobian
    transpose, pseudoinverse and damped least squares methods", 2004.)
    """
    joints = np.array(seeds, dtype=np.float64)
    solved = np.zeros(len(joints), dtype=bool)
    for _ in range(_STEPS):
        todo = np.flatnonzero(~solved)
        if not len(todo):
            break
        twist = _twist(*forward(robot, joints[todo]), position[todo], rotation[todo])
        size = np.max(np.abs(twist), axis=1)
        solved[todo] = size < _SOLVED
        todo, twist, size = todo[size >= _SOLVED], twist[size >= _SOLVED], size[size >= _SOLVED]
        if not len(todo):
            break
        slope = jacobian(robot, joints[todo])
        damping = np.minimum(size * size, 1e-2)[:, None, None] * np.eye(6)
        weights = np.linalg.solve(
            slope @ slope.transpose(0, 2, 1) + damping + 1e-18 * np.eye(6), twist[:, :, None]
        )
        step = (slope.transpose(0, 2, 1) @ weights)[:, :, 0]
        longest = np.max(np.abs(step), axis=1, keepdims=True)
        joints[todo] += step * np.minimum(1.0, _LONGEST_STEP / np.maximum(longest, _LONGEST_STEP))
    return joints, solved


def _twist(position: Array, rotation: Array, goal_position: Array, goal_rotation: Array) -> Array:
    """(n, 6): displacement [m] and rotation vector [rad] from the poses to the goals, in the base frame."""
    relative = goal_rotation @ rotation.transpose(0, 2, 1)
    vector = 0.5 * np.stack(
        (
            relative[:, 2, 1] - relative[:, 1, 2],
            relative[:, 0, 2] - relative[:, 2, 0],
            relative[:, 1, 0] - relative[:, 0, 1],
        ),
        axis=1,
    )
    sine = np.linalg.norm(vector, axis=1)
    cosine = 0.5 * (np.trace(relative, axis1=1, axis2=2) - 1.0)
    angle = np.arctan2(sine, cosine)
    scale = np.where(sine > 1e-8, angle / np.where(sine > 1e-8, sine, 1.0), 1.0)
    return np.concatenate((goal_position - position, vector * scale[:, None]), axis=1)
