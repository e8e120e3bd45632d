"""Arms with a spherical wrist: forward and inverse kinematics on arrays of poses.

Convention (docs/robots.md): S about +z, L about +y, U about -y, R about -x, B about -y, T about -x;
at zero the upper arm points up and the forearm forward. Lengths in mm, angles in rad.
"""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
_FLANGE = np.array([[0.0, 0, 1], [0, -1, 0], [1, 0, 0]])


@dataclass(frozen=True)
class WristedArm:
    """Links [mm], axis speeds [rad/s], axis accelerations [rad/s^2] and the tool's length [mm]."""

    name: str
    links: tuple[float, float, float, float, float]
    speeds: tuple[float, ...]
    accelerations: tuple[float, ...]
    tool: float

    @property
    def reach(self) -> float:
        """Wrist's largest distance from axis S [mm]."""
        a1, a2, a3, d4, _ = self.links
        return a1 + a2 + float(np.hypot(a3, d4))


def rotation(axis: str, angle: Floats) -> Floats:
    """Rotation matrices (n, 3, 3) about a main axis."""
    c, s = np.cos(angle), np.sin(angle)
    result = np.zeros((len(angle), 3, 3))
    i, j, k = {"x": (0, 1, 2), "y": (1, 2, 0), "z": (2, 0, 1)}[axis]
    result[:, i, i] = 1
    result[:, j, j] = result[:, k, k] = c
    result[:, j, k], result[:, k, j] = -s, s
    return result


def orientation(angles: Floats) -> Floats:
    """Matrices of rx, ry, rz [rad], shape (n, 3): R = Rz Ry Rx."""
    return rotation("z", angles[:, 2]) @ rotation("y", angles[:, 1]) @ rotation("x", angles[:, 0])


def forward(arm: WristedArm, q: Floats) -> tuple[Floats, Floats, Floats]:
    """Positions of tool, wrist and elbow [mm], each (n, 3)."""
    a1, a2, a3, d4, d6 = arm.links
    e = q[:, 2] - q[:, 1]
    elbow_r, elbow_z = a1 + a2 * np.sin(q[:, 1]), a2 * np.cos(q[:, 1])
    wrist_r = elbow_r - a3 * np.sin(e) + d4 * np.cos(e)
    wrist_z = elbow_z + a3 * np.cos(e) + d4 * np.sin(e)
    c, s = np.cos(q[:, 0]), np.sin(q[:, 0])
    wrist = np.stack([wrist_r * c, wrist_r * s, wrist_z], axis=1)
    elbow = np.stack([elbow_r * c, elbow_r * s, elbow_z], axis=1)
    turn = rotation("z", q[:, 0]) @ rotation("y", -e) @ rotation("x", -q[:, 3])
    turn = turn @ rotation("y", -q[:, 4]) @ rotation("x", -q[:, 5]) @ _FLANGE
    return wrist + (d6 + arm.tool) * turn[:, :, 2], wrist, elbow


def along(start: Floats, end: Floats, nodes: Floats) -> tuple[Floats, Floats]:
    """Points (n, 3) [mm] and orientations (n, 3, 3) on a line between two poses that turns about one axis."""
    one, two = orientation(np.stack([start[3:], end[3:]]))
    turn = one.T @ two
    angle = np.arccos(np.clip((np.trace(turn) - 1) / 2, -1, 1))
    about = (turn - turn.T) / (2 * max(np.sin(angle), 1e-9))
    part = (nodes * angle)[:, None, None]
    turned = np.eye(3) + np.sin(part) * about + (1 - np.cos(part)) * (about @ about)
    return start[:3] + nodes[:, None] * (end[:3] - start[:3]), one @ turned


def inverse(arm: WristedArm, points: Floats, turn: Floats) -> Floats:
    """Joints (n, 6) [rad] of points [mm] and orientations, elbow up; nan out of reach; continuous in the wrist."""
    a1, a2, a3, d4, d6 = arm.links
    wrist = points - (d6 + arm.tool) * turn[:, :, 2]
    s = np.arctan2(wrist[:, 1], wrist[:, 0])
    r, z = np.hypot(wrist[:, 0], wrist[:, 1]) - a1, wrist[:, 2]
    l2, bend = np.hypot(a3, d4), np.arctan2(a3, d4)
    cosine = (r**2 + z**2 - a2**2 - l2**2) / (2 * a2 * l2)
    with np.errstate(invalid="ignore"):
        fold = -np.arccos(np.where(np.abs(cosine) > 0.995, np.nan, cosine))
    upper = np.arctan2(z, r) - np.arctan2(l2 * np.sin(fold), a2 + l2 * np.cos(fold))
    elevation = upper + fold - bend
    lean = np.pi / 2 - upper
    m = rotation("y", elevation) @ rotation("z", -s) @ turn @ _FLANGE.T
    b = np.arccos(np.clip(m[:, 0, 0], -1, 1))
    q = np.stack(
        [
            s,
            lean,
            elevation + lean,
            -np.arctan2(m[:, 1, 0], -m[:, 2, 0]),
            -b,
            -np.arctan2(m[:, 0, 1], m[:, 0, 2]),
        ],
        1,
    )
    return np.unwrap(q, axis=0)


def write_robot(arm: WristedArm, path: Path, *, accelerations: bool) -> None:
    """Write the arm as a robot file, its accelerations only where asked."""
    lines = [
        'maker = "Fifth"',
        f'model = "{arm.name}"',
        'kind = "arm"',
        'controllers = ["X"]',
        "pose_verified = false",
    ]
    lines.append("axes = [")
    for name, v, a in zip("SLURBT", arm.speeds, arm.accelerations, strict=True):
        more = f", acceleration_deg_s2 = {np.degrees(a):.6g}" if accelerations else ""
        lines.append(
            f'  {{ name = "{name}", lower_deg = -360, upper_deg = 360, speed_deg_s = {np.degrees(v):.6g}{more} }},'
        )
    lines.append("]\n[links]")
    lines += [
        f"{key}_mm = {value}" for key, value in zip(("a1", "a2", "a3", "d4", "d6"), arm.links, strict=True)
    ]
    lines += ["[sources]", *(f'{key} = "own"' for key in ("limits", "speed", "links"))]
    lines += ['acceleration = "own"'] if accelerations else []
    path.write_text("\n".join(lines) + "\n")
