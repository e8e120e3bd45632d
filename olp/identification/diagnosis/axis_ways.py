"""The axes along the tool's ways: lines and arcs as flange poses, posture continued, rates that places ask.

Orientation turns the short way at a constant rate over the way, as `olp track` plays a program.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from olp.robots.geometry import quaternion_from_rotation, rotation_from_quaternion, slerp
from olp.robots.kinematics import branches, inverse, joint_speeds
from olp.robots.kinematics.configuration import wrap
from olp.robots.kinematics.inverse import newton
from olp.robots.robot import Robot
from olp.runtime.paths import circle, swept_angle

Floats = NDArray[np.float64]
Flags = NDArray[np.int64]

# [m/s per rad/s] Damping of the inverse Jacobian: exact to 1e-4 where the weakest direction moves 1 cm per radian,
# and finite at a singularity.
_DAMPING = 1e-4
# [rad] A larger step between two places may be another posture, or a singularity between them: looked at more finely.
_SUDDEN = 0.35
_FINER = 16


@dataclass(frozen=True, slots=True, eq=False)
class ToolPaths:
    """n ways of the tool's point, and the flange that carries it. `via` is nan for lines."""

    start: Floats  # (n, 3) [m]
    end: Floats  # (n, 3) [m]
    via: Floats  # (n, 3) [m]
    first: Floats  # (n, 3, 3) rotation of the flange at the start
    last: Floats  # (n, 3, 3) at the end
    tool: Floats  # (n, 3) [m] the tool's point seen from the flange

    def take(self, rows: NDArray[np.intp]) -> ToolPaths:
        return replace(self, **{name: getattr(self, name)[rows] for name in self.__slots__})

    def at(self, share: Floats) -> tuple[Floats, Floats, Floats, Floats]:
        """At m shares 0..1 of the way: the flange (n, m, 3) [m], (n, m, 3, 3), its speed (n, m, 3) [m], and its spin
        (n, 3) [rad], both per whole way."""
        place, speed = self._points(share)
        turn = quaternion_from_rotation(self.first.transpose(0, 2, 1) @ self.last)
        so_far = slerp(np.array([1.0, 0.0, 0.0, 0.0]), turn[:, None, :], share[None, :])
        rotation = self.first[:, None] @ rotation_from_quaternion(so_far)
        spin = np.einsum("nij,nj->ni", self.first, _vector(turn))
        arm = np.einsum("nmij,nj->nmi", rotation, self.tool)
        return place - arm, rotation, speed - np.cross(spin[:, None, :], arm), spin

    def _points(self, share: Floats) -> tuple[Floats, Floats]:
        """(n, m, 3) [m] places of the tool's point and its speed per whole way."""
        chord = self.end - self.start
        place = self.start[:, None] + share[None, :, None] * chord[:, None]
        speed = np.broadcast_to(chord[:, None], place.shape).copy()
        bent = np.isfinite(self.via).all(axis=1)
        if bent.any():
            place[bent], speed[bent] = _arc(self.start[bent], self.via[bent], self.end[bent], share)
        return place, speed


def _arc(start: Floats, via: Floats, end: Floats, share: Floats) -> tuple[Floats, Floats]:
    """(n, m, 3) [m] places and speed per whole way on the circle through three points; a line where they are on one."""
    centre, radius, axis = circle(start, via, end)
    spoke = start - centre
    with np.errstate(invalid="ignore"):
        swept = swept_angle(spoke, end - centre, axis)
        angle = (swept[:, None] * share[None, :])[:, :, None]
        across = np.cross(axis, spoke)[:, None]
        out = spoke[:, None] * np.cos(angle) + across * np.sin(angle)
        speed = swept[:, None, None] * (across * np.cos(angle) - spoke[:, None] * np.sin(angle))
    round_ = np.isfinite(radius)[:, None, None]
    chord = (end - start)[:, None]
    place = np.where(round_, centre[:, None] + out, start[:, None] + share[None, :, None] * chord)
    return place, np.where(round_, speed, chord)


def _vector(quaternion: Floats) -> Floats:
    """(n, 3) [rad] rotation vectors of quaternions (n, 4) with w >= 0."""
    sine = np.linalg.norm(quaternion[:, 1:], axis=1)
    angle = 2.0 * np.arctan2(sine, quaternion[:, 0])
    scale = np.where(sine > 1e-12, angle / np.where(sine > 1e-12, sine, 1.0), 2.0)
    return np.asarray(quaternion[:, 1:] * scale[:, None])


def joints_along(robot: Robot, ways: ToolPaths, share: Floats, posture: Flags, seed: Floats) -> Floats:
    """(n, m, k) [rad | m] continuous along each way, nan from where a place is out of reach.

    `posture` (n, 6): RCONF's first flags at the start, for spherical wrists; other arms begin near `seed` (n, k)
    [rad | m], or in mid-range where it is nan. Raises OlpError (K…).
    """
    place, rotation, _, _ = ways.at(share)
    if robot.geometry is None or robot.geometry.links is None:
        return _numerically(robot, place, rotation, seed)
    joints = _flat(robot, place, rotation, np.repeat(posture, len(share), axis=0))
    steps = np.diff(joints, axis=1)
    joints[:, 1:] -= np.cumsum(2.0 * np.pi * np.rint(np.nan_to_num(steps) / (2.0 * np.pi)), axis=1)
    sudden = np.nonzero((np.abs(np.diff(joints, axis=1)) > _SUDDEN).any(axis=(1, 2)))[0]
    if len(sudden):
        fine = np.interp(
            np.arange((len(share) - 1) * _FINER + 1), np.arange(len(share)) * float(_FINER), share
        )
        joints[sudden] = _nearest(robot, ways.take(sudden), fine, joints[sudden, 0])[:, ::_FINER]
    return joints


def rates_along(robot: Robot, ways: ToolPaths, share: Floats, joints: Floats) -> Floats:
    """(n, m, k) [rad | m per whole way] that turn the axes along `joints` (n, m, k); nan where those are.

    Near a singularity the rates are large and finite; arms with more than six axes take the shortest turn.
    """
    _, _, speed, spin = ways.at(share)
    count, places, axes = joints.shape
    known = np.isfinite(joints).all(axis=2).ravel()
    both = np.concatenate([speed, np.broadcast_to(spin[:, None], speed.shape)], axis=2).reshape(-1, 6)[known]
    rates = np.full((count * places, axes), np.nan)
    rates[known] = joint_speeds(robot, joints.reshape(-1, axes)[known], both, _DAMPING)
    return rates.reshape(count, places, axes)


def _flat(robot: Robot, place: Floats, rotation: Floats, posture: Flags) -> Floats:
    count, places = place.shape[:2]
    joints, _ = inverse(robot, place.reshape(-1, 3), rotation.reshape(-1, 3, 3), posture)
    return joints.reshape(count, places, -1)


def _nearest(robot: Robot, ways: ToolPaths, share: Floats, first: Floats) -> Floats:
    """(n, m, 6) Of all eight solutions the one that is nearest to the place before, from `first` (n, 6) on."""
    place, rotation, _, _ = ways.at(share)
    every = branches(robot, place.reshape(-1, 3), rotation.reshape(-1, 3, 3))
    every = every.reshape(len(first), len(share), 8, -1)
    found = np.empty((len(first), len(share), every.shape[-1]))
    found[:, 0] = last = first
    for i in range(1, len(share)):
        apart = wrap(every[:, i] - last[:, None])
        far = np.nan_to_num(np.sum(apart * apart, axis=2), nan=np.inf)
        last = last + np.take_along_axis(apart, np.argmin(far, axis=1)[:, None, None], axis=1)[:, 0]
        found[:, i] = last
    return found


def _numerically(robot: Robot, place: Floats, rotation: Floats, seed: Floats) -> Floats:
    """(n, m, k) Each place solved from the one before, all ways at once."""
    count, places = place.shape[:2]
    found = np.empty((count, places, len(robot.axes)))
    near = np.isfinite(seed).all(axis=1)
    found[near, 0], good = newton(robot, place[near, 0], rotation[near, 0], seed[near])
    found[np.nonzero(near)[0][~good], 0] = np.nan
    found[~near, 0] = inverse(robot, place[~near, 0], rotation[~near, 0])[0]
    for i in range(1, places):
        found[:, i] = np.nan
        rows = np.nonzero(np.isfinite(found[:, i - 1]).all(axis=1))[0]
        joints, good = newton(robot, place[rows, i], rotation[rows, i], found[rows, i - 1])
        found[rows[good], i] = joints[good]
    return found
