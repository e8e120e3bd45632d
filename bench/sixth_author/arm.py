"""This author's arm: an elbow with a spherical wrist, its poses and its joints in closed form. Lengths in mm."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

_TOOL = np.array([[0.0, 0, 1], [0, 1, 0], [-1, 0, 0]])  # maps the tool's z to the axis of the last roll, x


class RedrawError(Exception):
    """A draw that this arm, program or recorder cannot have."""


@dataclass(frozen=True)
class Arm:
    """Six axes; joints are (m, 6) [rad], poses positions (m, 3) [mm] and rotations (m, 3, 3)."""

    height: float  # of the second axis [mm]
    shoulder: float  # distance of the second axis from the first [mm]
    upper: float  # [mm]
    forearm: float  # [mm]
    hand: float  # from the wrist to the tool [mm]
    speeds: np.ndarray  # (6,) rated [rad/s]
    accelerations: np.ndarray  # (6,) [rad/s^2]

    def forward(self, joints: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Positions and rotations of the tool."""
        joints = np.atleast_2d(joints)
        base, lift, elbow = joints[:, 0], joints[:, 1], joints[:, 2]
        incline = lift + elbow
        reach = self.shoulder + self.upper * np.cos(lift) + self.forearm * np.cos(incline)
        height = self.height + self.upper * np.sin(lift) + self.forearm * np.sin(incline)
        wrist = Rotation.from_euler("XYX", joints[:, 3:6]).as_matrix()
        rotation = _forearm(base, incline) @ wrist @ _TOOL
        centre = np.stack([reach * np.cos(base), reach * np.sin(base), height], 1)
        return centre + self.hand * rotation[:, :, 2], rotation

    def inverse(self, position: np.ndarray, rotation: np.ndarray) -> np.ndarray:
        """Joints of poses along a path, elbow up; a pose at the border of what it reaches is none."""
        wrist = position - self.hand * rotation[:, :, 2]
        base = np.arctan2(wrist[:, 1], wrist[:, 0])
        reach = np.hypot(wrist[:, 0], wrist[:, 1]) - self.shoulder
        height = wrist[:, 2] - self.height
        cosine = (reach * reach + height * height - self.upper**2 - self.forearm**2) / (
            2 * self.upper * self.forearm
        )
        if np.any(np.abs(cosine) > 0.985):
            raise RedrawError("reach")
        elbow = -np.arccos(cosine)
        lift = np.arctan2(height, reach) - np.arctan2(
            self.forearm * np.sin(elbow), self.upper + self.forearm * np.cos(elbow)
        )
        left = np.transpose(_forearm(base, lift + elbow), (0, 2, 1)) @ rotation @ _TOOL.T
        bend = np.arccos(np.clip(left[:, 0, 0], -1, 1))
        if np.any(np.sin(bend) < 0.12):
            raise RedrawError("singular")
        roll = np.arctan2(left[:, 1, 0], -left[:, 2, 0])
        twist = np.arctan2(left[:, 0, 1], left[:, 0, 2])
        return np.stack([np.unwrap(base), lift, elbow, np.unwrap(roll), bend, np.unwrap(twist)], 1)


def draw_arm(rng: np.random.Generator) -> Arm:
    """An arm of middle size."""
    ends = ((420, 700), (100, 300), (700, 1000), (800, 1100), (180, 320))
    height, shoulder, upper, forearm, hand = (float(rng.uniform(low, high)) for low, high in ends)
    speeds = np.radians(rng.uniform(1, 1.3) * np.array([150, 130, 150, 280, 280, 400]))
    return Arm(height, shoulder, upper, forearm, hand, speeds, speeds / rng.uniform(0.25, 0.5))


def _forearm(base: np.ndarray, incline: np.ndarray) -> np.ndarray:
    """Rotations (m, 3, 3) of the forearm, whose x points to the wrist."""
    x = np.stack([np.cos(incline) * np.cos(base), np.cos(incline) * np.sin(base), np.sin(incline)], 1)
    y = np.stack([-np.sin(base), np.cos(base), np.zeros_like(base)], 1)
    return np.stack([x, y, np.cross(x, y)], 2)


def orientation(angles: Sequence[float] | np.ndarray) -> Rotation:
    """The rotation of rx, ry, rz [deg]: R = Rz Ry Rx."""
    rotation: Rotation = Rotation.from_euler("ZYX", [angles[2], angles[1], angles[0]], degrees=True)
    return rotation


def angles_of(rotation: np.ndarray) -> np.ndarray:
    """rx, ry, rz (3,) [deg] of a rotation (3, 3)."""
    return np.asarray(Rotation.from_matrix(rotation).as_euler("ZYX", degrees=True))[::-1].copy()
