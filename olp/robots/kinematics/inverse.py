"""Inverse kinematics by configuration: one branch for a job's RCONF, or all eight.

Arms without a closed form are solved near a start position by damped Newton steps, many poses at once. Configurations
convert between an arm with a spherical wrist and one without: the same place of the flange.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray

from olp.core.diagnostic import OlpError, error
from olp.robots.kinematics.configuration import (
    BLOCK,
    apply_turns,
    as_joints,
    forward,
    from_standard,
    geometry_of,
    links_of,
    slopes,
    sweep,
    to_standard,
    turn_centres,
    within_limits,
    wrap,
)
from olp.robots.kinematics.spherical import (
    STRAIGHT_WRIST,
    flipped,
    offset_wrist_of,
    solutions,
    solve,
    solve_arms,
)
from olp.robots.model import Links, Robot

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
    """Joints (n, k) [rad | m] near `start` (k,) or (n, k) for poses (n, 3) [m], (n, 3, 3), and which (n,) were
    solved.

    If the start does not converge, fixed pseudo-random starts inside the limits follow; nan if all fail. Turning
    axes end within half a turn of the start. Raises OlpError: K001 no geometry, K002 number of axes.
    """
    seeds = np.broadcast_to(as_joints(robot, start), (len(position), len(robot.axes)))
    joints, solved = np.array(seeds, dtype=np.float64), np.zeros(len(position), dtype=bool)
    near = np.flatnonzero(np.linalg.norm(position, axis=1) <= farthest_flange(robot))
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
    """Solves every pose (n) from every start (s, k): the joints (n, k) of the first start that converges, and which
    (n,) were solved.
    """
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


def farthest_flange(robot: Robot) -> float:
    """Upper bound [m] of a pose's distance from the base: the stretched chain with its slides extended."""
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
    geometry = geometry_of(robot)
    joints = np.array(seeds, dtype=np.float64)
    solved = np.zeros(len(joints), dtype=bool)
    for _ in range(_STEPS):
        todo = np.flatnonzero(~solved)
        if not len(todo):
            break
        swept = sweep(robot, geometry, as_joints(robot, joints[todo]).T)
        turned = np.stack(swept.columns, axis=1).transpose(2, 0, 1)
        twist = _twist(swept.position.T, turned, position[todo], rotation[todo])
        size = np.max(np.abs(twist), axis=1)
        solved[todo] = size < _SOLVED
        wrong = size >= _SOLVED
        todo, twist, size = todo[wrong], twist[wrong], size[wrong]
        if not len(todo):
            break
        slope = slopes(robot, geometry, swept.at(wrong))
        damping = np.minimum(size * size, 1e-2)[:, None, None] * np.eye(6)
        weights = np.linalg.solve(
            slope @ slope.transpose(0, 2, 1) + damping + 1e-18 * np.eye(6), twist[:, :, None]
        )
        step = (slope.transpose(0, 2, 1) @ weights)[:, :, 0]
        longest = np.max(np.abs(step), axis=1, keepdims=True)
        joints[todo] += step * np.minimum(1.0, _LONGEST_STEP / np.maximum(longest, _LONGEST_STEP))
    return joints, solved


def _twist(position: Array, rotation: Array, goal_position: Array, goal_rotation: Array) -> Array:
    """Displacement [m] and rotation vector [rad] from the poses to the goals (n, 6), in the base frame."""
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


def inverse(
    robot: Robot,
    positions: ArrayLike,
    rotations: ArrayLike,
    configuration: ArrayLike = (0, 0, 0, 0, 0, 0),
    seed: ArrayLike | None = None,
) -> tuple[Array, NDArray[np.bool_]]:
    """Joints (n, k) [rad] of flange poses (n, 3) [m], (n, 3, 3), and which poses (n,) can be reached.

    Spherical wrists: the branch and turns of `configuration`, RCONF's first six flags, (n, 6) or (6,); later flags
    are ignored, and turn flags that an old controller does not write (ERC has five in all) are 0. Other chains have
    no such flags: the solution near `seed` (k,) or (n, k) [rad], by default near mid-range; the nearest of all
    where the arm has a closed form. Joints out of reach are nan; soft limits are not checked (use `within_limits`).
    Raises OlpError: K001 no geometry, K005 poses of wrong shape.
    """
    geometry = geometry_of(robot)
    position, rotation = as_poses(positions, rotations)
    if geometry.links is None:
        start = (robot.lower + robot.upper) / 2.0 if seed is None else seed
        arm = offset_wrist_of(geometry)
        if arm is None:
            return solve_from(robot, position, rotation, start)
        seeds = np.broadcast_to(as_joints(robot, start), (len(position), len(robot.axes)))
        found = closest(robot, solutions(arm, position, rotation, seeds[:, 5]), seeds)
        return found, ~np.isnan(found[:, 0])
    return _by_flags(robot, geometry.links, position, rotation, as_flags(configuration, len(position)))


def branches(robot: Robot, positions: ArrayLike, rotations: ArrayLike) -> Array:
    """All solutions (n, 8, 6) [rad] of flange poses (n, 3) [m], (n, 3, 3), nan where a branch has none.

    Branch number = 4 rear + 2 lower + no-flip, the first three flags of RCONF read backwards. S, R, T lie in [-180,
    180] deg; L, U, B within half a turn of the middle of their limits. Raises OlpError: K001 no geometry, K004 no
    spherical wrist, K005 poses of wrong shape.
    """
    links = links_of(robot)
    position, rotation = as_poses(positions, rotations)
    count = len(position)
    result = np.empty((8, 6, count))
    centres = turn_centres(robot)
    for start in range(0, count, BLOCK):
        part = slice(start, start + BLOCK)
        arms = solve_arms(links, *columns(position[part], rotation[part])).reshape(4, 6, -1)
        result[::2, :, part] = _readings(links, arms, centres)
        arms[:, 3::2] = flipped(arms[:, 3::2])
        arms[:, 4] = -arms[:, 4]
        result[1::2, :, part] = _readings(links, arms, centres)
    return result.transpose(2, 0, 1)


def as_poses(positions: ArrayLike, rotations: ArrayLike) -> tuple[Array, Array]:
    """Positions (n, 3) and rotations (n, 3, 3); a single pose counts as n = 1. Raises OlpError (K005)."""
    position = np.atleast_2d(np.asarray(positions, dtype=np.float64))
    rotation = np.asarray(rotations, dtype=np.float64)
    rotation = rotation[None] if rotation.ndim == 2 else rotation
    if position.shape[1:] != (3,) or rotation.shape != (len(position), 3, 3):
        message = f"poses need shapes (n, 3) and (n, 3, 3), not {position.shape} and {rotation.shape}"
        raise OlpError(error("K005", message))
    return position, rotation


def as_flags(configuration: ArrayLike, count: int) -> NDArray[np.int64]:
    """Flags (6,) or (count, 6) from three or more per pose. Raises OlpError (K005)."""
    flags = np.asarray(configuration, dtype=np.int64)
    if flags.ndim not in (1, 2) or flags.shape[-1] < 3 or (flags.ndim == 2 and len(flags) != count):
        raise OlpError(error("K005", f"a configuration has three to six flags, not shape {flags.shape}"))
    missing = max(0, 6 - flags.shape[-1])
    return np.pad(flags[..., :6], [(0, 0)] * (flags.ndim - 1) + [(0, missing)])


def columns(position: Array, rotation: Array) -> tuple[Array, Array]:
    """Poses (m, 3), (m, 3, 3) as (3, m), (3, 3, m), so that every component is contiguous in memory."""
    return np.ascontiguousarray(position.T), np.ascontiguousarray(rotation.transpose(1, 2, 0))


def _by_flags(
    robot: Robot, links: Links, position: Array, rotation: Array, flags: NDArray[np.int64]
) -> tuple[Array, NDArray[np.bool_]]:
    count = len(position)
    standard = np.empty((6, count))
    signs = 1.0 - 2.0 * (flags != 0)
    for start in range(0, count, BLOCK):
        part = slice(start, start + BLOCK)
        flip, upper, front = (signs[i] if flags.ndim == 1 else signs[part, i] for i in range(3))
        solved = solve(links, *columns(position[part], rotation[part]), front, -upper, flip)
        for row, angle in zip(standard, solved, strict=True):
            row[part] = angle
    readings = wrap(from_standard(links, standard.T), turn_centres(robot))
    return apply_turns(readings, flags), ~np.isnan(readings[:, 2])


def _readings(links: Links, standard: Array, centres: Array) -> Array:
    """Readings (..., 6, m) wrapped about `centres`, from standard angles (..., 6, m)."""
    return wrap(from_standard(links, standard.swapaxes(-1, -2)), centres).swapaxes(-1, -2)


# --- The nearest of given solutions ---
# Of several solutions of one pose, the one nearest to where the arm stands.

_TURN = 2.0 * math.pi


def closest(robot: Robot, found: Array, start: Array) -> Array:
    """The row (n, k) of `found` (n, m, k) [rad] nearest to `start` (n, k), shifted by whole turns where nearer; nan
    if all are.

    Nearest is the smallest sum of squared angles; solutions inside the soft limits come first.
    """
    start = start[:, None, :]
    found = start + wrap(found - start)
    found = _towards(found, robot.lower, robot.upper)
    outside = (found < robot.lower - 1e-9) | (found > robot.upper + 1e-9)
    way = np.nan_to_num(np.sum((found - start) ** 2, axis=2), nan=np.inf)
    # Further than any two joint positions are apart.
    way += 1e6 * outside.any(axis=2)
    chosen: Array = found[np.arange(len(found)), way.argmin(axis=1)]
    return chosen


def _towards(joints: Array, lower: Array, upper: Array) -> Array:
    """`joints` shifted by whole turns into the limits, where possible."""
    up = _TURN * np.ceil((lower - 1e-9 - joints) / _TURN)
    raised = np.where(up > 0, joints + up, joints)
    down = _TURN * np.ceil((raised - upper - 1e-9) / _TURN)
    lowered = np.where(down > 0, raised - down, raised)
    inside: Array = np.where(lowered >= lower - 1e-9, lowered, joints)
    return inside


# --- The nearest of all solutions ---
# The solution nearest to where the arm stands, over all branches and turns: what controllers take without flags.


def nearest(robot: Robot, positions: ArrayLike, rotations: ArrayLike, seed: ArrayLike) -> Array:
    """Joints (n, k) [rad | m] of flange poses (n, 3) [m], (n, 3, 3) nearest to `seed`, (k,) or (n, k).

    Nearest is the smallest sum of squared angles; solutions inside the soft limits come first. nan out of reach.
    For arms without a closed form: the result of Newton's steps from the seed. Raises OlpError: K001 no geometry,
    K002 number of axes, K005 poses of wrong shape.
    """
    position, rotation = as_poses(positions, rotations)
    links = geometry_of(robot).links
    if links is None:
        return inverse(robot, position, rotation, seed=seed)[0]
    start = np.broadcast_to(as_joints(robot, seed), (len(position), len(robot.axes)))
    return closest(robot, _held(links, branches(robot, position, rotation), start[:, None, :]), start)


def _held(links: Links, joints: Array, start: Array) -> Array:
    """`joints` (n, 8, 6) with R as in `start` where the wrist is straight; T compensates for it."""
    standard = to_standard(links, joints)
    straight = np.abs(np.sin(standard[..., 4])) < STRAIGHT_WRIST
    if not straight.any():
        return joints
    kept = to_standard(links, start)[..., 3]
    standard[..., 5] = np.where(straight, standard[..., 5] + standard[..., 3] - kept, standard[..., 5])
    standard[..., 3] = np.where(straight, kept, standard[..., 3])
    return from_standard(links, standard)


# [1] Sum of both links' 1 - cos, one of them by 45 deg: what differs less is a matter of nearness.
_ALIKE = 0.3
_FRONT = 4  # solutions that pass axis 1 on one side come first, then as many on the other


def same_flange(robot: Robot, other: Robot, joints: Array, start: Array) -> Array:
    """Joints (n, k) [rad] that put the flange of `other` where `robot` has it at `joints` (n, k); nan if none is
    inside the limits.

    Both poses are relative to the robot's own base. Preferred are solutions whose upper arm and forearm point
    (almost) as those of `robot`, and among them the nearest to the row before, the first to `start` (k,). An arm
    with a spherical wrist keeps it in front of axis 1 if it can; if no such solution is inside the limits, any
    other is used. Raises OlpError: K001 no geometry, K002 number of axes.
    """
    position, rotation = forward(robot, joints)
    here = as_joints(other, start)
    found = _all_of(other, position, rotation, np.broadcast_to(here, (len(position), len(other.axes))))
    wanted = _links_of(robot, as_joints(robot, joints))
    there = np.full((len(found), len(other.axes)), np.nan)
    front = found[:, :_FRONT]
    for choice in (_most_alike(other, front, wanted), _most_alike(other, found, wanted), front, found):
        for row in np.flatnonzero(np.isnan(there).any(axis=1)).tolist():
            chosen = closest(other, choice[row : row + 1], _before(there, row, here))
            if within_limits(other, chosen).all():
                there[row] = chosen[0]
    return there


def _before(there: Array, row: int, start: Array) -> Array:
    """The last known row (1, k) of `there` (n, k) before `row`, else `start`."""
    if row and not np.isnan(there[row - 1]).any():
        return there[row - 1 : row]
    known = np.flatnonzero(~np.isnan(there[:row]).any(axis=1))
    return there[known[-1] :][:1] if len(known) else start


def _most_alike(robot: Robot, found: Array, wanted: Array) -> Array:
    """`found` (n, m, k) with nan for solutions whose links point less in the directions `wanted` (n, 6) than the
    best.
    """
    each = [np.sum(_links_of(robot, found[:, i]) * wanted, axis=1) for i in range(found.shape[1])]
    likeness = np.nan_to_num(np.stack(each, axis=1), nan=-np.inf)
    best = likeness.max(axis=1, keepdims=True)
    return np.where((likeness >= best - _ALIKE)[:, :, None], found, np.nan)


def _all_of(robot: Robot, position: Array, rotation: Array, start: Array) -> Array:
    """All solutions (n, m, k) [rad] where there is a closed form, else the one found from `start`."""
    geometry = geometry_of(robot)
    if geometry.links is not None:
        return branches(robot, position, rotation)
    arm = offset_wrist_of(geometry)
    if arm is not None:
        return solutions(arm, position, rotation, start[:, 5])
    return solve_from(robot, position, rotation, start)[0][:, None, :]


def _links_of(robot: Robot, joints: Array) -> Array:
    """Directions (n, 6) of the upper arm, from axis 2 to 3, and of the forearm, from axis 3 to 5."""
    origins = sweep(robot, geometry_of(robot), joints.T).origins
    ways = [origins[2] - origins[1], origins[4] - origins[2]]
    return np.concatenate([(way / np.linalg.norm(way, axis=0)).T for way in ways], axis=1)
