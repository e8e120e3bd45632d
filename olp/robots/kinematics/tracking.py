"""Joints along a path: every branch continued from sample to sample, or the one nearest to a start position.

A branch keeps its flags until it passes through a singularity; there the sample that is nearer to the one
before decides, so that R and T do not jump by half a turn where B changes its sign.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np
from numpy.typing import ArrayLike, NDArray

from olp.robots.kinematics.configuration import (
    BLOCK,
    as_joints,
    configuration_of,
    geometry_of,
    links_of,
    to_standard,
    turn_centres,
    wrap,
)
from olp.robots.kinematics.inverse import as_poses, columns, inverse, solve_from
from olp.robots.kinematics.spherical import STRAIGHT_WRIST, flipped, solve_arms
from olp.robots.model import Links, Robot

Array = NDArray[np.float64]

_TURN = 2.0 * math.pi
# Numeric arms: every so many samples are solved one after the other, those between them all at once.
_KEY_SPACING = 16
# [rad] A start this near to the path's first pose is on the branch that its own flags say.
_NEAR = 0.2


def track(robot: Robot, positions: ArrayLike, rotations: ArrayLike, start_joints: ArrayLike) -> Array:
    """Joints (n, k) [rad] along flange poses (n, 3) [m], (n, 3, 3), beginning nearest to `start_joints` (k,).

    They are continuous: no turn or half turn is lost between samples. nan where a pose is out of reach. Raises
    OlpError: K001 no geometry, K002 number of axes, K005 poses of wrong shape.
    """
    position, rotation = as_poses(positions, rotations)
    start = as_joints(robot, start_joints)[0]
    links = geometry_of(robot).links
    if links is None:
        return _track_numerically(robot, position, rotation, start)
    found, calm = _track_without_events(robot, links, position, rotation, start[None], np.zeros(1, np.intp))
    if calm[0]:
        return found
    result = np.empty((6, len(position)))
    chosen, turns = -1, np.zeros(6)
    for part, block in _follow(robot, links, position, rotation, start):
        if chosen < 0:
            apart = wrap(block[:, :, 0] - start)
            chosen = int(np.argmin(np.nan_to_num(np.sum(apart * apart, axis=1), nan=np.inf)))
            turns = np.nan_to_num(start + apart[chosen] - block[chosen, :, 0])
        result[:, part] = block[chosen] + turns[:, None]
    return result.T


def track_paths(
    robot: Robot,
    positions: ArrayLike,
    rotations: ArrayLike,
    start_joints: ArrayLike,
    begins: NDArray[np.intp],
) -> Array:
    """`track` for p concatenated paths at once: (n, k) [rad].

    Path i has the poses from row `begins[i]` up to the next one's, and starts near `start_joints[i]`, (p, k).
    """
    position, rotation = as_poses(positions, rotations)
    starts = as_joints(robot, start_joints)
    links = geometry_of(robot).links
    if links is None:
        found, calm = np.empty((len(position), len(robot.axes))), np.zeros(len(begins), dtype=bool)
    else:
        found, calm = _track_without_events(robot, links, position, rotation, starts, begins)
    ends = np.append(begins[1:], len(position))
    for i in np.flatnonzero(~calm).tolist():
        part = slice(int(begins[i]), int(ends[i]))
        found[part] = track(robot, position[part], rotation[part], starts[i])
    return found


def track_branches(robot: Robot, positions: ArrayLike, rotations: ArrayLike) -> Array:
    """The eight branches (n, 8, 6) [rad], each continuous along flange poses (n, 3) [m], (n, 3, 3).

    They are numbered as in `branches` by the flags at the first sample; nan where out of reach. Raises OlpError:
    K001 no geometry, K004 no spherical wrist, K005 poses of wrong shape.
    """
    links = links_of(robot)
    position, rotation = as_poses(positions, rotations)
    result = np.empty((8, 6, len(position)))
    for part, block in _follow(robot, links, position, rotation, None):
        result[:, :, part] = block
    return result.transpose(2, 0, 1)


def _track_without_events(
    robot: Robot,
    links: Links,
    position: Array,
    rotation: Array,
    starts: Array,
    begins: NDArray[np.intp],
) -> tuple[Array, NDArray[np.bool_]]:
    """`track_paths` with each path in the branch of its start; (p,) False where another branch could be nearer
    somewhere.

    Most paths stay in their branch, and one branch costs a third of eight.
    """
    flags = configuration_of(robot, starts)
    flags[:, 3:] = 0
    of = np.repeat(np.arange(len(begins)), np.diff(np.append(begins, len(position))))
    joints, reachable = inverse(robot, position, rotation, flags[of])
    before = np.concatenate((starts[:1], joints[:-1]))
    before[begins] = starts
    steps = joints - before
    turns = np.nan_to_num(np.rint(steps / _TURN))
    rest = np.abs(steps - _TURN * turns)
    straight = np.abs(np.sin(to_standard(links, joints)[:, 4])) < 2.0 * STRAIGHT_WRIST
    eventful = ~reachable | (rest > 0.5 * math.pi).any(axis=1) | straight
    calm = ~np.logical_or.reduceat(eventful, begins) & (rest[begins].max(axis=1) <= _NEAR)
    whole = np.cumsum(turns, axis=0)
    whole -= (whole[begins] - turns[begins])[of]
    return joints - _TURN * whole, calm


def _follow(
    robot: Robot, links: Links, position: Array, rotation: Array, start: Array | None
) -> Iterator[tuple[slice, Array]]:
    """The eight continuous branches (8, 6, m) [rad] block by block; the array is reused."""
    state = _Branches(robot, links, start)
    for begin in range(0, len(position), BLOCK):
        part = slice(begin, begin + BLOCK)
        arms = solve_arms(links, *columns(position[part], rotation[part]))
        yield part, state.continued(arms)


class _Branches:
    """State that continues the branches from block to block. Arms are [front/rear, upper/lower], wrist with B >= 0."""

    def __init__(self, robot: Robot, links: Links, start: Array | None) -> None:
        self.signs = np.array(links.signs, dtype=np.float64)
        self.zeros = np.array(links.zeros)
        self.centres = turn_centres(robot)
        self.begun = False
        self.behind = False  # front and rear have changed places at the shoulder
        self.mirrored = np.zeros((2, 2), dtype=bool)  # B has changed its sign
        self.offsets = np.zeros((2, 2, 2, 6))  # [rad] per arm and wrist sign: whole and half turns so far
        self.last_raw = np.full((2, 2, 6), np.nan)
        self.last = np.full((2, 2, 6), np.nan)
        if start is not None:
            # A straight wrist leaves R free: it stays where the start has it.
            angles = to_standard(links, start[None])[0]
            turn = angles[3] if wrap(angles[4]) >= -STRAIGHT_WRIST else flipped(wrap(angles[3]))
            self.last[:, :, 3] = wrap(turn)

    def continued(self, arms: Array) -> Array:
        """The branches (8, 6, m) [rad] for the next block of flagged solutions `arms` (2, 2, 6, m)."""
        arms = self._through_the_shoulder(arms)
        _hold_straight_wrists(arms, self.last)
        if not self.begun:
            self._begin(arms[..., 0])
        steps = np.diff(arms[:, :, (0, 1, 3, 5)], axis=-1, prepend=self.last[:, :, (0, 1, 3, 5), None])
        far: NDArray[np.bool_] = (steps > 0.5 * math.pi) | (steps < -0.5 * math.pi)
        eventful = np.asarray(far.any(axis=(2, 3)))
        result = np.empty((2, 2, 2, 6, arms.shape[-1]))
        for i in range(2):
            for j in range(2):
                if eventful[i, j]:
                    self._with_events(i, j, arms[i, j], steps[i, j], result[i, j])
                else:
                    self._without_events(i, j, arms[i, j], result[i, j])
        self.last = arms[..., -1].copy()
        return result.reshape(8, 6, -1)

    def _begin(self, first: Array) -> None:
        """Set the offsets so that the first sample (2, 2, 6) equals that of `branches`."""
        self.begun = True
        for axis in (3, 5):
            self.offsets[:, :, 1, axis] = flipped(first[:, :, axis]) - first[:, :, axis]
        angles = first[:, :, None, :] * np.ones((1, 1, 2, 1))
        angles[:, :, 1, 4] *= -1.0
        readings = (angles + self.offsets - self.zeros) * self.signs
        self.offsets += (wrap(readings, self.centres) - readings) * self.signs
        self.offsets = np.nan_to_num(self.offsets)
        self.last = np.where(np.isnan(self.last), first, self.last)
        self.last[..., (0, 1, 5)] = first[..., (0, 1, 5)]

    def _without_events(self, i: int, j: int, arm: Array, out: Array) -> None:
        for flip in range(2):
            signs, shift = self._affine(i, j, flip)
            if bool(flip) != self.mirrored[i, j]:
                signs[4] = -signs[4]
            np.multiply(arm, signs[:, None], out=out[flip])
            out[flip] += shift[:, None]

    def _with_events(self, i: int, j: int, arm: Array, steps: Array, out: Array) -> None:
        """Continue one arm with offsets that change inside the block; `steps` (4, m) of S, L, R, T."""
        changes = np.zeros((6, arm.shape[-1]))
        changes[:2] = -_TURN * np.rint(np.nan_to_num(steps[:2]) / _TURN)
        wrist_changes, switches = _wrist_events(steps[2], steps[3], arm[4], self.last[i, j, 4])
        changes[3], changes[5] = wrist_changes
        np.cumsum(changes, axis=1, out=changes)
        mirrored = np.logical_xor.accumulate(np.concatenate(([self.mirrored[i, j]], switches)))[1:]
        for flip in range(2):
            signs, shift = self._affine(i, j, flip)
            np.multiply(arm + changes, signs[:, None], out=out[flip])
            out[flip, 4] *= np.where(mirrored != bool(flip), -1.0, 1.0)
            out[flip] += shift[:, None]
        self.offsets[i, j] += changes[:, -1]
        self.mirrored[i, j] = mirrored[-1]

    def _affine(self, i: int, j: int, flip: int) -> tuple[Array, Array]:
        """Factor and shift (6,) from flagged standard angles to continuous readings."""
        return self.signs.copy(), (self.offsets[i, j, flip] - self.zeros) * self.signs

    def _through_the_shoulder(self, arms: Array) -> Array:
        """`arms` with front and rear exchanged while a path over axis S has made the exchanged pair the nearer one."""
        joined = np.concatenate((self.last_raw[:, 0, :3, None], arms[:, 0, :3]), axis=-1)
        self.last_raw = arms[..., -1].copy()
        turn = wrap(np.diff(joined[0, 0]))
        suspects = np.flatnonzero(np.abs(turn) > 0.5 * math.pi)
        if not len(suspects):
            return arms[::-1].copy() if self.behind else arms
        before, front, rear = joined[0][:, suspects], joined[0][:, suspects + 1], joined[1][:, suspects + 1]
        crossed = np.sum(wrap(rear - before) ** 2, axis=0) < np.sum(wrap(front - before) ** 2, axis=0)
        exchanged = np.zeros(arms.shape[-1], dtype=bool)
        exchanged[suspects[crossed]] = True
        behind = np.logical_xor.accumulate(np.concatenate(([self.behind], exchanged)))[1:]
        self.behind = bool(behind[-1])
        return np.where(behind, arms[::-1], arms)


def _wrist_events(r_step: Array, t_step: Array, b: Array, b_before: float) -> tuple[Array, NDArray[np.bool_]]:
    """Changes (2, m) [rad] of the offsets of R and T, and where (m,) B changes its sign.

    The other sign of B is half a turn away in R and T; whichever is nearer to the sample before continues
    the branch. Steps of R and T within a quarter turn never make the other one nearer.
    """
    r_same, t_same = wrap(r_step), wrap(t_step)
    r_other, t_other = wrap(r_step + math.pi), wrap(t_step + math.pi)
    earlier = np.concatenate(([b_before], b[:-1]))
    same = r_same**2 + t_same**2 + (b - earlier) ** 2
    other = r_other**2 + t_other**2 + (b + earlier) ** 2
    switches = other < same
    changes = np.where(switches, (r_other, t_other), (r_same, t_same)) - (r_step, t_step)
    return np.nan_to_num(changes), switches


def _hold_straight_wrists(arms: Array, last: Array) -> None:
    """Where the wrist is straight, R keeps its last value and T makes up for it. `arms` (2, 2, 6, m)."""
    straight = arms[:, :, 4] < STRAIGHT_WRIST
    if not straight.any():
        return
    for i, j in np.argwhere(straight.any(axis=-1)):
        held = straight[i, j]
        r = np.concatenate(([last[i, j, 3]], arms[i, j, 3]))
        known = np.where(np.concatenate(([False], held)), 0, np.arange(len(r)))
        kept = r[np.maximum.accumulate(known)][1:]
        kept = np.where(held & ~np.isnan(kept), kept, arms[i, j, 3])
        arms[i, j, 5] = np.where(held, wrap(arms[i, j, 5] + arms[i, j, 3] - kept), arms[i, j, 5])
        arms[i, j, 3] = kept


def _track_numerically(robot: Robot, position: Array, rotation: Array, start: Array) -> Array:
    keys = np.unique(np.append(np.arange(0, len(position), _KEY_SPACING), len(position) - 1))
    corners = np.empty((len(keys), len(start)))
    seed = start
    for row, key in enumerate(keys):
        corners[row] = solve_from(robot, position[key : key + 1], rotation[key : key + 1], seed)[0][0]
        seed = seed if np.isnan(corners[row]).any() else corners[row]
    samples = np.arange(len(position))
    guesses = np.stack([np.interp(samples, keys, column) for column in corners.T], axis=1)
    guesses = np.where(np.isnan(guesses), start, guesses)
    return solve_from(robot, position, rotation, guesses)[0]
