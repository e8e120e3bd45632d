"""Rotation vectors and the angles of olp, one pose at a time: plain floats, because an array call costs more.

A rotation vector is the axis of the turn times its angle [rad]; the angles are rx, ry, rz [rad] with
R = Rz(rz) Ry(ry) Rx(rx), as everywhere in olp.
"""

from __future__ import annotations

from math import atan2, cos, hypot, sin, sqrt

Angles = tuple[float, float, float]


def angles_from_vector(x: float, y: float, z: float) -> Angles:
    """rx, ry, rz of a rotation vector; Rodrigues' formula with sines that keep their digits near no turn."""
    angle = sqrt(x * x + y * y + z * z)
    if angle < 1e-8:
        one, half = 1.0, 0.5
    else:
        one = sin(angle) / angle
        sine = sin(0.5 * angle) / angle
        half = 2.0 * sine * sine
    r00, r11 = 1.0 - half * (y * y + z * z), 1.0 - half * (x * x + z * z)
    r22 = 1.0 - half * (x * x + y * y)
    r10, r20, r21 = half * x * y + one * z, half * x * z - one * y, half * y * z + one * x
    cosine = hypot(r00, r10)
    if cosine < 1e-12:  # rx and rz turn about one axis: rz is 0
        return atan2(one * x - half * y * z, r11), atan2(-r20, cosine), 0.0
    return atan2(r21, r22), atan2(-r20, cosine), atan2(r10, r00)


def vector_from_angles(rx: float, ry: float, rz: float) -> Angles:
    """The rotation vector, 0 to pi long, of the angles: their quaternion, then twice its half angle."""
    cx, sx, cy, sy, cz, sz = (
        cos(0.5 * rx),
        sin(0.5 * rx),
        cos(0.5 * ry),
        sin(0.5 * ry),
        cos(0.5 * rz),
        sin(0.5 * rz),
    )
    w = cz * cy * cx + sz * sy * sx
    x = cz * cy * sx - sz * sy * cx
    y = cz * sy * cx + sz * cy * sx
    z = sz * cy * cx - cz * sy * sx
    if w < 0.0:
        w, x, y, z = -w, -x, -y, -z
    sine = sqrt(x * x + y * y + z * z)
    factor = 2.0 * atan2(sine, w) / sine if sine > 1e-12 else 2.0
    return x * factor, y * factor, z * factor
