"""Inverse kinematics of any serial chain near a start position, by damped Newton steps on many poses at once."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from olp.kinematics.chain import as_joints, forward, jacobian
from olp.kinematics.configuration import wrap
from olp.robots.model import Robot

Array = NDArray[np.float64]

_STEPS = 60
_SOLVED = 1e-11  # [m and rad] largest error of a solved pose
_LONGEST_STEP = 0.4  # [rad] per axis: a longer one leaves the region where the Jacobian means something
# Offsets from the start that are tried where the start itself does not lead to a solution.
_ATTEMPTS = 24


def solve_from(
    robot: Robot, position: Array, rotation: Array, start: ArrayLike
) -> tuple[Array, NDArray[np.bool_]]:
    """Joints (n, k) [rad | m] near `start` (k,) or (n, k) for poses (n, 3) [m], (n, 3, 3), and (n,) solved.

    Where the start leads nowhere, fixed pseudo-random starts inside the limits follow; nan if all fail.
    Turning axes end within half a turn of the start.
    Raises OlpError: K001 no geometry, K002 number of axes.
    """
    seeds = np.broadcast_to(as_joints(robot, start), (len(position), len(robot.axes)))
    joints, solved = newton(robot, position, rotation, seeds)
    random = np.random.default_rng(20)
    for _ in range(_ATTEMPTS):
        open_poses = np.flatnonzero(~solved)
        if not len(open_poses):
            break
        tries = random.uniform(robot.lower, robot.upper, (len(open_poses), len(robot.axes)))
        found, good = newton(robot, position[open_poses], rotation[open_poses], tries)
        joints[open_poses[good]], solved[open_poses] = found[good], good
    turning = np.array([not axis.linear for axis in robot.axes])
    joints = np.where(turning, wrap(joints, seeds), joints)
    joints[~solved] = np.nan
    return joints, solved


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
