"""Inverse kinematics by configuration: one branch for a job's RCONF, or all eight."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray

from olp.core.diagnostic import OlpError, error
from olp.robots.kinematics.chain import BLOCK, as_joints, geometry_of
from olp.robots.kinematics.configuration import (
    apply_turns,
    from_standard,
    links_of,
    to_standard,
    turn_centres,
    wrap,
)
from olp.robots.kinematics.numeric import solve_from
from olp.robots.kinematics.offset_wrist import offset_wrist_of, solutions
from olp.robots.kinematics.spherical import STRAIGHT_WRIST, flipped, solve, solve_arms
from olp.robots.model import Links, Robot

Array = NDArray[np.float64]


def inverse(
    robot: Robot,
    positions: ArrayLike,
    rotations: ArrayLike,
    configuration: ArrayLike = (0, 0, 0, 0, 0, 0),
    seed: ArrayLike | None = None,
) -> tuple[Array, NDArray[np.bool_]]:
    """Joints (n, k) [rad] of flange poses (n, 3) [m], (n, 3, 3), and which poses (n,) can be reached at all.

    Spherical wrists: the branch and turns of `configuration`, RCONF's first six flags, (n, 6) or (6,); later
    ones are not looked at, turn flags that an old controller does not write (ERC has five in all) are 0.
    Other chains have no such flags: the solution near `seed` (k,) or (n, k) [rad], by default near mid-range; the
    nearest of all where the arm has a closed form.
    Joints out of reach are nan; soft limits are not looked at (`within_limits` does).
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
    """(n, 8, 6) [rad]: all solutions of flange poses (n, 3) [m], (n, 3, 3), nan where there is none.

    Branch number = 4 rear + 2 lower + no-flip, the first three flags of RCONF read backwards.
    S, R, T lie in [-180, 180] deg; L, U, B within half a turn of the middle of their limits.
    Raises OlpError: K001 no geometry, K004 no spherical wrist, K005 poses of wrong shape.
    """
    links = links_of(robot)
    position, rotation = as_poses(positions, rotations)
    count = len(position)
    result = np.empty((8, 6, count))
    centres = turn_centres(robot)
    for start in range(0, count, BLOCK):
        part = slice(start, start + BLOCK)
        arms = solve_arms(links, *columns(position[part], rotation[part]))
        for number, arm in enumerate(arms.reshape(4, 6, -1)):
            result[2 * number, :, part] = _readings(links, arm, centres)
            arm[3], arm[4], arm[5] = flipped(arm[3]), -arm[4], flipped(arm[5])
            result[2 * number + 1, :, part] = _readings(links, arm, centres)
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
    """Poses (m, 3), (m, 3, 3) as (3, m), (3, 3, m), laid out so that every component is one run of memory."""
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
    """(6, m) readings wrapped about `centres`, from standard angles (6, m)."""
    return wrap(from_standard(links, standard.T), centres).T


# --- Choosing ---
# Of several solutions of one pose, the one nearest to where the arm stands.

_TURN = 2.0 * math.pi


def closest(robot: Robot, found: Array, start: Array) -> Array:
    """The row (n, k) of `found` (n, m, k) [rad] nearest to `start` (n, k), by whole turns, too; nan where all are.

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
    """`joints` by whole turns to inside the limits, where that can be."""
    up = _TURN * np.ceil((lower - 1e-9 - joints) / _TURN)
    raised = np.where(up > 0, joints + up, joints)
    down = _TURN * np.ceil((raised - upper - 1e-9) / _TURN)
    lowered = np.where(down > 0, raised - down, raised)
    inside: Array = np.where(lowered >= lower - 1e-9, lowered, joints)
    return inside


# --- Nearest ---
# The solution nearest to where the arm stands, over all branches and turns: what controllers take without flags.


def nearest(robot: Robot, positions: ArrayLike, rotations: ArrayLike, seed: ArrayLike) -> Array:
    """Joints (n, k) [rad | m] of flange poses (n, 3) [m], (n, 3, 3) nearest to `seed`, (k,) or (n, k).

    Nearest is the smallest sum of squared angles; solutions inside the soft limits come first. nan out of reach.
    Arms without a closed form: where Newton's steps from the seed lead.
    Raises OlpError: K001 no geometry, K002 number of axes, K005 poses of wrong shape.
    """
    position, rotation = as_poses(positions, rotations)
    links = geometry_of(robot).links
    if links is None:
        return inverse(robot, position, rotation, seed=seed)[0]
    start = np.broadcast_to(as_joints(robot, seed), (len(position), len(robot.axes)))
    return closest(robot, _held(links, branches(robot, position, rotation), start[:, None, :]), start)


def _held(links: Links, joints: Array, start: Array) -> Array:
    """Where the wrist is straight, R stays as it is in `start` and T makes up for it. `joints` (n, 8, 6)."""
    standard = to_standard(links, joints)
    straight = np.abs(np.sin(standard[..., 4])) < STRAIGHT_WRIST
    if not straight.any():
        return joints
    kept = to_standard(links, start)[..., 3]
    standard[..., 5] = np.where(straight, standard[..., 5] + standard[..., 3] - kept, standard[..., 5])
    standard[..., 3] = np.where(straight, kept, standard[..., 3])
    return from_standard(links, standard)
