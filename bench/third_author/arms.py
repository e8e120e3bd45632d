"""Arms of this author: kinematics both ways, masses, and what each axis can do."""

from dataclasses import dataclass

import numpy as np
from numpy import cos, sin

GRAVITY = 9.81


def turn(axis: str, angle) -> np.ndarray:
    """Rotation matrices about x, y or z by angles [rad], stacked on the angles' shape."""
    angle = np.asarray(angle, float)
    i, j = {"x": (1, 2), "y": (2, 0), "z": (0, 1)}[axis]
    k = 3 - i - j
    matrix = np.zeros((*angle.shape, 3, 3))
    matrix[..., k, k] = 1
    matrix[..., i, i] = matrix[..., j, j] = cos(angle)
    matrix[..., j, i] = sin(angle)
    matrix[..., i, j] = -sin(angle)
    return matrix


def euler(matrix: np.ndarray) -> np.ndarray:
    """Angles rx, ry, rz [rad] with R = Rz Ry Rx."""
    ry = np.arcsin(np.clip(-matrix[..., 2, 0], -1, 1))
    rx = np.arctan2(matrix[..., 2, 1], matrix[..., 2, 2])
    rz = np.arctan2(matrix[..., 1, 0], matrix[..., 0, 0])
    return np.stack([rx, ry, rz], -1)


@dataclass(frozen=True)
class Arm:
    """A serial arm with a column, an upper arm, a forearm and a wrist of three axes or one (a palletiser).

    Lengths in metres, masses in kilograms, rates in rad/s and rad/s^2 of each axis.
    """

    name: str
    shoulder: tuple[float, float]  # forward of the column, above the floor
    upper: float
    fore: float
    hand: float
    masses: tuple[float, float, float]  # upper arm, forearm, wrist
    column: float  # inertia about the first axis that no pose changes [kg m^2]
    speeds: np.ndarray
    accelerations: np.ndarray

    @property
    def axes(self) -> int:
        return len(self.speeds)

    def bodies(self, q: np.ndarray) -> np.ndarray:
        """Centres of the upper arm, the forearm and the wrist: radius and height [m], shape (..., 3, 2)."""
        lean, rise = q[..., 1], q[..., 2] - q[..., 1]
        elbow = np.stack([sin(lean), cos(lean)], -1) * self.upper
        along = np.stack([cos(rise), sin(rise)], -1) * self.fore
        base = np.asarray(self.shoulder)
        return np.stack([base + elbow / 2, base + elbow + along / 3, base + elbow + along], -2)

    def inertia(self, q: np.ndarray, load=0.0) -> np.ndarray:
        """Inertia about the first axis [kg m^2], with a load [kg] at the wrist."""
        radius = self.bodies(q)[..., 0]
        masses = [*self.masses[:2], self.masses[2] + np.asarray(load)]
        return self.column + sum(m * radius[..., i] ** 2 for i, m in enumerate(masses))

    def potential(self, q: np.ndarray, load=0.0) -> np.ndarray:
        """Energy of the weights [J]."""
        height = self.bodies(q)[..., 1]
        masses = [*self.masses[:2], self.masses[2] + np.asarray(load)]
        return GRAVITY * sum(m * height[..., i] for i, m in enumerate(masses))

    def pose(self, q: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Position [m] and rotation of the tool."""
        wrist = self.bodies(q)[..., 2, :]
        centre = np.stack([wrist[..., 0] * cos(q[..., 0]), wrist[..., 0] * sin(q[..., 0]), wrist[..., 1]], -1)
        if self.axes == 4:
            rotation = turn("z", q[..., 0] + q[..., 3]) @ turn("y", np.full(q.shape[:-1], np.pi))
        else:
            rotation = turn("z", q[..., 0]) @ turn("y", q[..., 1] - q[..., 2]) @ turn("x", q[..., 3])
            rotation = rotation @ turn("y", q[..., 4]) @ turn("x", q[..., 5])
            rotation = rotation @ turn("y", np.full(q.shape[:-1], np.pi / 2))
        return centre + self.hand * rotation[..., :, 2], rotation

    def joints(self, position: np.ndarray, rotation: np.ndarray) -> np.ndarray:
        """Angles [rad] that reach a pose with the elbow up; NaN where nothing does."""
        centre = position - self.hand * rotation[..., :, 2]
        first = np.arctan2(centre[..., 1], centre[..., 0])
        r = np.hypot(centre[..., 0], centre[..., 1]) - self.shoulder[0]
        h = centre[..., 2] - self.shoulder[1]
        span = np.hypot(r, h)
        with np.errstate(invalid="ignore"):
            inner = np.arccos((self.upper**2 + span**2 - self.fore**2) / (2 * self.upper * span))
            knee = np.arccos((self.upper**2 + self.fore**2 - span**2) / (2 * self.upper * self.fore))
        lean = np.pi / 2 - (np.arctan2(h, r) + inner)
        rise = np.pi / 2 - lean + knee - np.pi
        third = rise + lean
        if self.axes == 4:
            yaw = np.arctan2(rotation[..., 1, 1], rotation[..., 0, 1]) - np.pi / 2 - first
            return np.stack([first, lean, third, np.arctan2(sin(yaw), cos(yaw))], -1)
        fore = turn("z", first) @ turn("y", -rise)
        wrist = np.swapaxes(fore, -1, -2) @ rotation @ turn("y", np.full(first.shape, -np.pi / 2))
        fifth = np.arccos(np.clip(wrist[..., 0, 0], -1, 1))
        fourth = np.arctan2(wrist[..., 1, 0], -wrist[..., 2, 0])
        sixth = np.arctan2(wrist[..., 0, 1], wrist[..., 0, 2])
        other = np.abs(fourth) > np.pi / 2
        fourth = np.where(other, fourth - np.pi * np.sign(fourth), fourth)
        sixth = np.where(other, sixth - np.pi * np.sign(sixth), sixth)
        return np.stack([first, lean, third, fourth, np.where(other, -fifth, fifth), sixth], -1)


ARMS = (
    Arm("small", (0.05, 0.34), 0.36, 0.38, 0.09, (9, 6, 3), 0.9,
        np.radians([370, 310, 410, 410, 400, 620]), np.radians([1900, 1500, 2300, 3100, 3000, 5200])),
    Arm("large", (0.31, 0.68), 1.08, 1.28, 0.24, (240, 160, 75), 190.0,
        np.radians([112, 96, 104, 174, 168, 240]), np.radians([190, 160, 215, 430, 420, 700])),
    Arm("palletiser", (0.26, 0.81), 1.15, 1.35, 0.31, (210, 130, 60), 150.0,
        np.radians([132, 118, 124, 360]), np.radians([230, 205, 240, 900])),
)  # fmt: skip
