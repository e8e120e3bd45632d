"""Rotations, quaternions and poses, vectorised over any number of leading axes.

Shapes: positions (..., 3) [m], rotations (..., 3, 3), quaternions (..., 4) as (w, x, y, z) with w >= 0,
angles (..., 3) [rad] as Rx, Ry, Rz with R = Rz(Rz) Ry(Ry) Rx(Rx), the convention of INFORM's RECTAN points.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from olp.core.diagnostic import OlpError, error

Array = NDArray[np.float64]

# Below this sine the three points of a frame count as one line (0.006 deg, far finer than anyone can teach).
_COLLINEAR_SINE = 1e-4


@dataclass(frozen=True, slots=True, eq=False)
class Pose:
    """One rigid motion: `position` (3,) [m] and `rotation` (3, 3). Equal when all twelve numbers are."""

    position: Array
    rotation: Array

    @classmethod
    def identity(cls) -> Pose:
        return cls(np.zeros(3), np.eye(3))

    @classmethod
    def from_xyz_angles(cls, values: ArrayLike) -> Pose:
        """The pose of the six numbers x, y, z [m], Rx, Ry, Rz [rad]."""
        numbers = np.asarray(values, dtype=np.float64)
        return cls(numbers[:3].copy(), rotation_from_angles(numbers[3:6]))

    def xyz_angles(self) -> Array:
        """The pose as (6,): x, y, z [m], Rx, Ry, Rz [rad]."""
        return np.concatenate((self.position, angles_from_rotation(self.rotation)))

    def inverse(self) -> Pose:
        return Pose(*invert(self.position, self.rotation))

    def apply(self, points: ArrayLike) -> Array:
        """Points (..., 3) [m] of this frame, in the frame in which the pose is given."""
        moved: Array = np.asarray(points, dtype=np.float64) @ self.rotation.T + self.position
        return moved

    def __matmul__(self, other: Pose) -> Pose:
        return Pose(*compose(self.position, self.rotation, other.position, other.rotation))

    def __eq__(self, other: object) -> bool:
        if not isinstance(other, Pose):
            return NotImplemented
        return np.array_equal(self.position, other.position) and np.array_equal(self.rotation, other.rotation)

    def __hash__(self) -> int:
        # Adding zero turns -0.0 into 0.0: the two are equal, so they must hash alike.
        return hash(((self.position + 0.0).tobytes(), (self.rotation + 0.0).tobytes()))


def rotation_from_angles(angles: ArrayLike) -> Array:
    """Rotations (..., 3, 3) = Rz Ry Rx from angles (..., 3) = Rx, Ry, Rz [rad]."""
    values = np.asarray(angles, dtype=np.float64)
    cosine, sine = np.cos(values), np.sin(values)
    cx, cy, cz = (cosine[..., i] for i in range(3))
    sx, sy, sz = (sine[..., i] for i in range(3))
    result = np.empty((*values.shape[:-1], 3, 3))
    result[..., 0, 0] = cz * cy
    result[..., 0, 1] = cz * sy * sx - sz * cx
    result[..., 0, 2] = cz * sy * cx + sz * sx
    result[..., 1, 0] = sz * cy
    result[..., 1, 1] = sz * sy * sx + cz * cx
    result[..., 1, 2] = sz * sy * cx - cz * sx
    result[..., 2, 0] = -sy
    result[..., 2, 1] = cy * sx
    result[..., 2, 2] = cy * cx
    return result


def angles_from_rotation(rotation: ArrayLike) -> Array:
    """Angles (..., 3) = Rx, Ry, Rz [rad] of rotations (..., 3, 3).

    At Ry = ±90 deg only Rx ∓ Rz is defined; Rz is then 0. Rx, Rz in (-pi, pi], Ry in [-pi/2, pi/2].
    """
    r = np.asarray(rotation, dtype=np.float64)
    cosine_y = np.hypot(r[..., 0, 0], r[..., 1, 0])
    locked = cosine_y < 1e-12
    rx = np.where(locked, np.arctan2(-r[..., 1, 2], r[..., 1, 1]), np.arctan2(r[..., 2, 1], r[..., 2, 2]))
    rz = np.where(locked, 0.0, np.arctan2(r[..., 1, 0], r[..., 0, 0]))
    return np.stack((rx, np.arctan2(-r[..., 2, 0], cosine_y), rz), axis=-1)


def quaternion_from_rotation(rotation: ArrayLike) -> Array:
    """Quaternions (..., 4), w >= 0, of rotations (..., 3, 3).

    4 q qᵀ is linear in R; its row with the largest diagonal is q up to a factor and never cancels (S. W. Shepperd,
    "Quaternion from rotation matrix", J. Guidance and Control 1(3), 1978).
    """
    r = np.asarray(rotation, dtype=np.float64)
    outer = np.empty((*r.shape[:-2], 4, 4))
    r00, r11, r22 = r[..., 0, 0], r[..., 1, 1], r[..., 2, 2]
    outer[..., 0, 0] = 1.0 + r00 + r11 + r22
    outer[..., 1, 1] = 1.0 + r00 - r11 - r22
    outer[..., 2, 2] = 1.0 - r00 + r11 - r22
    outer[..., 3, 3] = 1.0 - r00 - r11 + r22
    outer[..., 0, 1] = outer[..., 1, 0] = r[..., 2, 1] - r[..., 1, 2]
    outer[..., 0, 2] = outer[..., 2, 0] = r[..., 0, 2] - r[..., 2, 0]
    outer[..., 0, 3] = outer[..., 3, 0] = r[..., 1, 0] - r[..., 0, 1]
    outer[..., 1, 2] = outer[..., 2, 1] = r[..., 1, 0] + r[..., 0, 1]
    outer[..., 1, 3] = outer[..., 3, 1] = r[..., 0, 2] + r[..., 2, 0]
    outer[..., 2, 3] = outer[..., 3, 2] = r[..., 2, 1] + r[..., 1, 2]
    best = np.argmax(np.einsum("...ii->...i", outer), axis=-1)
    row = np.take_along_axis(outer, best[..., None, None], axis=-2)[..., 0, :]
    return _upper_half(row / np.linalg.norm(row, axis=-1, keepdims=True))


def rotation_from_quaternion(quaternion: ArrayLike) -> Array:
    """Rotations (..., 3, 3) of quaternions (..., 4), which need not have unit length; nan for zero length."""
    q = np.asarray(quaternion, dtype=np.float64)
    with np.errstate(invalid="ignore"):
        q = q / np.linalg.norm(q, axis=-1, keepdims=True)
    w, x, y, z = (q[..., i] for i in range(4))
    result = np.empty((*q.shape[:-1], 3, 3))
    result[..., 0, 0] = 1.0 - 2.0 * (y * y + z * z)
    result[..., 0, 1] = 2.0 * (x * y - w * z)
    result[..., 0, 2] = 2.0 * (x * z + w * y)
    result[..., 1, 0] = 2.0 * (x * y + w * z)
    result[..., 1, 1] = 1.0 - 2.0 * (x * x + z * z)
    result[..., 1, 2] = 2.0 * (y * z - w * x)
    result[..., 2, 0] = 2.0 * (x * z - w * y)
    result[..., 2, 1] = 2.0 * (y * z + w * x)
    result[..., 2, 2] = 1.0 - 2.0 * (x * x + y * y)
    return result


def slerp(start: ArrayLike, end: ArrayLike, fraction: ArrayLike) -> Array:
    """Quaternions (..., 4) between `start` and `end` (..., 4) the short way, at constant angular rate.

    `fraction` (...) [1] is 0 at the start and 1 at the end; all three broadcast, so two quaternions and a fraction
    of shape (n,) give (n, 4). (K. Shoemake, "Animating rotation with quaternion curves", 1985.)
    """
    a, b = np.asarray(start, dtype=np.float64), np.asarray(end, dtype=np.float64)
    u = np.asarray(fraction, dtype=np.float64)[..., None]
    cosine = np.sum(a * b, axis=-1, keepdims=True)
    b = np.where(cosine < 0.0, -b, b)
    # Half chords keep the angle accurate where acos(cosine) loses half of its digits.
    angle = 2.0 * np.arctan2(
        np.linalg.norm(b - a, axis=-1, keepdims=True), np.linalg.norm(b + a, axis=-1, keepdims=True)
    )
    sine = np.sin(angle)
    near = sine < 1e-9
    safe = np.where(near, 1.0, sine)
    weight_a = np.where(near, 1.0 - u, np.sin((1.0 - u) * angle) / safe)
    weight_b = np.where(near, u, np.sin(u * angle) / safe)
    mixed = weight_a * a + weight_b * b
    return _upper_half(mixed / np.linalg.norm(mixed, axis=-1, keepdims=True))


def rotation_angle(first: ArrayLike, second: ArrayLike) -> Array:
    """Angle (...) [rad], 0..pi, of the rotation that turns `first` into `second`, both (..., 3, 3)."""
    a, b = np.asarray(first, dtype=np.float64), np.asarray(second, dtype=np.float64)
    relative = np.swapaxes(a, -1, -2) @ b
    x = relative[..., 2, 1] - relative[..., 1, 2]
    y = relative[..., 0, 2] - relative[..., 2, 0]
    z = relative[..., 1, 0] - relative[..., 0, 1]
    trace = relative[..., 0, 0] + relative[..., 1, 1] + relative[..., 2, 2]
    angle: Array = np.arctan2(np.sqrt(x * x + y * y + z * z), trace - 1.0)
    return angle


def compose(
    position: ArrayLike, rotation: ArrayLike, local_position: ArrayLike, local_rotation: ArrayLike
) -> tuple[Array, Array]:
    """Poses B, given in the frames A, transformed into the frame in which A is given: (..., 3) [m] and (..., 3, 3).

    Either side may be a single pose; leading axes broadcast.
    """
    outer = np.asarray(rotation, dtype=np.float64)
    moved = (outer @ np.asarray(local_position, dtype=np.float64)[..., None])[..., 0]
    return moved + np.asarray(position), outer @ np.asarray(local_rotation, dtype=np.float64)


def invert(position: ArrayLike, rotation: ArrayLike) -> tuple[Array, Array]:
    """The inverse poses: positions (..., 3) [m], rotations (..., 3, 3)."""
    transposed = np.swapaxes(np.asarray(rotation, dtype=np.float64), -1, -2)
    return -(transposed @ np.asarray(position, dtype=np.float64)[..., None])[..., 0], transposed


def frame_from_points(origin: ArrayLike, x_point: ArrayLike, xy_point: ArrayLike) -> Pose:
    """The frame of three taught points (3,) [m], as MFRAME and UFRAME.CND mean them (ORG, XX, XY).

    x runs from the origin to `x_point`, z is normal to the plane of all three, `xy_point` has y > 0.
    Raises OlpError (G001) when the points lie on one line or coincide.
    """
    o, xx, xy = (np.asarray(p, dtype=np.float64) for p in (origin, x_point, xy_point))
    along, across = xx - o, xy - o
    normal = np.cross(along, across)
    length, area = float(np.linalg.norm(along)), float(np.linalg.norm(normal))
    if area <= _COLLINEAR_SINE * length * float(np.linalg.norm(across)):
        raise OlpError(
            error("G001", "the three points of the frame lie on one line", help="teach XY beside the X axis")
        )
    x, z = along / length, normal / area
    return Pose(o.copy(), np.column_stack((x, np.cross(z, x), z)))


def _upper_half(quaternion: Array) -> Array:
    return np.where(quaternion[..., :1] < 0.0, -quaternion, quaternion)
