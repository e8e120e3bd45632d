"""Closed-form inverse kinematics of six-axis arms with a spherical wrist, for all branches or chosen ones.

After M. Brandstötter, A. Angerer, M. Hofbaur, "An analytical solution of the inverse kinematics problem of
industrial serial manipulators with an ortho-parallel basis and a spherical wrist" (2014), arranged so that
sines and cosines come from lengths: per pose one arc tangent for the base, three per shoulder, three per
elbow, and no sine or cosine at all. Angles here are standard angles (`olp.robots.model.Links`).

A branch is three signs: `front` +1 wrist centre before axis S, -1 behind it; `elbow` -1 upper, +1 lower;
`flip` +1 B positive, -1 B negative. Each may be a number or an array over the poses.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from olp.robots.model import Links

Array = NDArray[np.float64]
Signs = float | Array

# A wrist centre this much beyond the stretched arm (in the cosine of the elbow) is still rounding.
_STRETCH_ROUNDING = 1e-12
# [rad] Below it R and T turn about one line: only their sum is known, and it is what must be exact.
STRAIGHT_WRIST = 1e-7


class Plane(NamedTuple):
    """Pose data that all branches share; `*_along`, `*_side` in the vertical plane through the wrist centre."""

    radius: Array  # [m] of the wrist centre from axis S
    height: Array  # [m] of the wrist centre above the base frame
    base: Array  # [rad] angle of S with the wrist centre in front
    n_along: Array
    o_along: Array
    a_along: Array
    n_side: Array
    o_side: Array
    a_side: Array
    n_up: Array
    o_up: Array
    a_up: Array


class Shoulder(NamedTuple):
    """What both elbows of one front/rear choice share."""

    along: Array  # [m] of the wrist centre from axis L, forward
    reach: Array  # [m²] squared distance from axis L to the wrist centre
    cosine: Array  # of the elbow's bend
    sine: Array  # of the elbow's bend, >= 0; nan where the pose is out of reach
    bend: Array  # [rad] 0 stretched
    elevation: Array  # [rad] of the wrist centre seen from axis L
    spread: Array  # [rad] between upper arm and that direction


class ElbowSolution(NamedTuple):
    """Angles L and U [rad] and the forearm's pitch, for one shoulder and elbow choice."""

    lower_arm: Array
    upper_arm: Array
    cosine: Array  # of the forearm's pitch about y
    sine: Array


def plane(links: Links, position: Array, rotation: Array) -> Plane:
    """From flange poses: `position` (3, m) [m], `rotation` (3, 3, m)."""
    (nx, ox, ax), (ny, oy, ay), (nz, oz, az) = rotation
    x, y = position[0] - links.d6 * ax, position[1] - links.d6 * ay
    radius = np.sqrt(x * x + y * y)
    on_axis = radius < 1e-12
    safe = np.where(on_axis, 1.0, radius) if on_axis.any() else radius
    c, s = x / safe, y / safe
    if on_axis.any():
        c = np.where(on_axis, 1.0, c)
    return Plane(
        radius,
        position[2] - links.d6 * az - links.height,
        np.arctan2(s, c),
        *(c * nx + s * ny, c * ox + s * oy, c * ax + s * ay),
        *(c * ny - s * nx, c * oy - s * ox, c * ay - s * ax),
        *(nz, oz, az),
    )


def shoulder(links: Links, p: Plane, front: Signs) -> Shoulder:
    """The triangle of upper arm, forearm and wrist centre."""
    a2, forearm = links.a2, math.hypot(links.a3, links.d4)
    along = front * p.radius - links.a1
    reach = along * along + p.height * p.height
    cosine = (reach - (a2 * a2 + forearm * forearm)) * (0.5 / (a2 * forearm))
    square = 1.0 - cosine * cosine
    outside = square < 0.0
    if outside.any():
        square = np.where(outside, np.where(square > -_STRETCH_ROUNDING, 0.0, np.nan), square)
    sine = np.sqrt(square)
    bend = np.arctan2(sine, cosine)
    elevation = np.arctan2(p.height, along)
    spread = np.arctan2(forearm * sine, a2 + forearm * cosine)
    return Shoulder(along, reach, cosine, sine, bend, elevation, spread)


def arm(links: Links, p: Plane, s: Shoulder, elbow: Signs) -> ElbowSolution:
    """L, U and the forearm's pitch."""
    a2, forearm = links.a2, math.hypot(links.a3, links.d4)
    rise = math.atan2(links.a3, links.d4)
    across, ahead = elbow * forearm * s.sine, a2 + forearm * s.cosine
    scale = a2 / s.reach
    # Direction of the forearm: wrist centre minus elbow.
    x = s.along - (s.along * ahead + p.height * across) * scale
    z = p.height - (p.height * ahead - s.along * across) * scale
    c, d = links.d4 / forearm**2, links.a3 / forearm**2
    return ElbowSolution(
        (0.5 * math.pi - s.elevation) + elbow * s.spread,
        (0.5 * math.pi - rise) + elbow * s.bend,
        x * c + z * d,
        x * d - z * c,
    )


def wrist(p: Plane, front: Signs, a: ElbowSolution) -> tuple[Array, Array, Array]:
    """R, B, T [rad] with B >= 0; the other solution is R ± pi, -B, T ± pi."""
    c, s = a.cosine, a.sine
    ahead = front * p.a_along
    side, up = front * p.a_side, s * ahead + c * p.a_up
    r = np.arctan2(side, up)
    b = np.arctan2(np.sqrt(side * side + up * up), c * ahead - s * p.a_up)
    o, n = front * p.o_along, front * p.n_along
    t = np.arctan2(s * p.o_up - c * o, s * p.n_up - c * n)
    if (b < STRAIGHT_WRIST).any() or (b > math.pi - STRAIGHT_WRIST).any():
        _straighten(p, front, a, r, b, t)
    return r, b, t


def flipped(angle: Array) -> Array:
    """The angle half a turn away, in [-pi, pi]."""
    half_turned: Array = angle - np.copysign(math.pi, angle)
    return half_turned


def solve(
    links: Links, position: Array, rotation: Array, front: Signs, elbow: Signs, flip: Signs
) -> tuple[Array, ...]:
    """The six standard angles [rad] of one branch, each (m,), nan out of reach."""
    p = plane(links, position, rotation)
    a = arm(links, p, shoulder(links, p, front), elbow)
    r, b, t = wrist(p, front, a)
    turned = np.less(flip, 0.0)
    base = np.where(np.less(front, 0.0), flipped(p.base), p.base)
    base = np.where(np.isnan(a.upper_arm), np.nan, base)
    return (
        base,
        a.lower_arm,
        a.upper_arm,
        np.where(turned, flipped(r), r),
        np.where(turned, -b, b),
        np.where(turned, flipped(t), t),
    )


def solve_arms(links: Links, position: Array, rotation: Array) -> Array:
    """(2, 2, 6, m) standard angles [rad] with B >= 0: front/rear, upper/lower elbow; nan out of reach."""
    result = np.empty((2, 2, 6, position.shape[1]))
    p = plane(links, position, rotation)
    for i, front in enumerate((1.0, -1.0)):
        s = shoulder(links, p, front)
        base = p.base if front > 0.0 else flipped(p.base)
        for j, elbow in enumerate((-1.0, 1.0)):
            out = result[i, j]
            a = arm(links, p, s, elbow)
            # 0 * sine is 0 in reach and nan beyond it: one multiplication instead of a test and a copy.
            np.add(base, 0.0 * s.sine, out=out[0])
            out[1], out[2] = a.lower_arm, a.upper_arm
            out[3], out[4], out[5] = wrist(p, front, a)
    return result


def _straighten(p: Plane, front: Signs, a: ElbowSolution, r: Array, b: Array, t: Array) -> None:
    """Where the wrist is straight (or folded back), sets T so that R and T together give the orientation."""
    i = np.flatnonzero((b < STRAIGHT_WRIST) | (b > math.pi - STRAIGHT_WRIST))
    f = np.broadcast_to(np.asarray(front), b.shape)[i]
    c, s = a.cosine[i], a.sine[i]
    # Lower right block of Rx(-R) Ry(-B) Rx(-T), whose sum and difference with B give R + T or R - T.
    m11, m12 = -f * p.o_side[i], f * p.n_side[i]
    m21 = -(s * f * p.o_along[i] + c * p.o_up[i])
    m22 = s * f * p.n_along[i] + c * p.n_up[i]
    total = -np.arctan2(m21 - m12, m11 + m22)
    folded = np.arctan2(m21 + m12, m11 - m22)
    t[i] = np.where(b[i] < 1.0, total - r[i], r[i] + folded)
    t[i] -= 2.0 * math.pi * np.rint(t[i] / (2.0 * math.pi))
