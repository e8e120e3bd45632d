"""Closed-form inverse kinematics of six-axis arms, for all branches or chosen ones: spherical and offset wrists.

After M. Brandstötter, A. Angerer, M. Hofbaur, "An analytical solution of the inverse kinematics problem of
industrial serial manipulators with an ortho-parallel basis and a spherical wrist" (2014), arranged so that sines
and cosines come from lengths: per pose one arc tangent for the base, three per shoulder, three per elbow, and no
sine or cosine at all. Angles here are standard angles (`olp.robots.model.Links`).

A branch is three signs: `front` +1 wrist centre before axis S, -1 behind it; `elbow` -1 upper, +1 lower; `flip` +1
B positive, -1 B negative. Each may be a number or an array over the poses.

An offset wrist has axes 2, 3 and 4 parallel (Universal Robots).

Axis 1 is vertical; axes 2, 3, 4 and, at zero, 6 lie along one direction h; axis 5 is perpendicular to h and meets
axis 6. Then

- the intersection of axes 5 and 6 has a position along h that axes 2 to 6 do not change: two solutions of axis 1;
- the angle between axis 6 and h gives two solutions of axis 5, and the direction of h in the flange frame gives axis 6;
- a turn about h remains, the sum of axes 2, 3 and 4, and two links in a plane: two solutions of axis 3.

(K. Hawkins, "Analytic inverse kinematics for the Universal Robots UR-5/UR-10 arms", 2013, has the same steps.)
"""

from __future__ import annotations

import itertools
import math
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from olp.robots.model import Geometry, Links

Array = NDArray[np.float64]
Signs = float | Array

# A wrist centre this much beyond the stretched arm (in the cosine of the elbow) is still rounding.
_STRETCH_ROUNDING = 1e-12
# [rad] Below it R and T turn about one line: only their sum is known, and it is what must be exact.
STRAIGHT_WRIST = 1e-7
_BOTH = np.array([[1.0], [-1.0]])


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
    """Values that both elbows of one front/rear choice share."""

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
    """Values of flange poses that all branches share: `position` (3, m) [m], `rotation` (3, 3, m)."""
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
    """L, U and the forearm's pitch of one shoulder and elbow choice."""
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
    p = plane(links, position, rotation)
    front, elbow = _BOTH[:, None], -_BOTH
    s = shoulder(links, p, front)
    a = arm(links, p, s, elbow)
    result = np.empty((2, 2, 6, position.shape[1]))
    result[:, :, 0] = np.stack((p.base, flipped(p.base)))[:, None]
    # 0 * sine is 0 in reach and nan beyond it: one multiplication instead of a test and a copy.
    result[:, :, 0] += 0.0 * s.sine
    result[:, :, 1], result[:, :, 2] = a.lower_arm, a.upper_arm
    result[:, :, 3], result[:, :, 4], result[:, :, 5] = wrist(p, front, a)
    return result


def _straighten(p: Plane, front: Signs, a: ElbowSolution, r: Array, b: Array, t: Array) -> None:
    """Where the wrist is straight (or folded back), sets T so that R and T together give the orientation."""
    i = (b < STRAIGHT_WRIST) | (b > math.pi - STRAIGHT_WRIST)
    f, *seen = (
        np.broadcast_to(one, b.shape)[i]
        for one in (front, p.o_side, p.n_side, p.o_along, p.n_along, p.o_up, p.n_up)
    )
    o_side, n_side, o_along, n_along, o_up, n_up = seen
    c, s = a.cosine[i], a.sine[i]
    # Lower right block of Rx(-R) Ry(-B) Rx(-T), whose sum and difference with B give R + T or R - T.
    m11, m12 = -f * o_side, f * n_side
    m21 = -(s * f * o_along + c * o_up)
    m22 = s * f * n_along + c * n_up
    total = -np.arctan2(m21 - m12, m11 + m22)
    folded = np.arctan2(m21 + m12, m11 - m22)
    t[i] = np.where(b[i] < 1.0, total - r[i], r[i] + folded)
    t[i] -= 2.0 * math.pi * np.rint(t[i] / (2.0 * math.pi))


_EXACT = 1e-12  # [m, 1] rounding of the robot file's numbers
_STRETCHED = 1e-9  # [1] by which the cosine of a stretched elbow may leave [-1, 1]
_UP = np.array([0.0, 0.0, 1.0])


class OffsetWrist(NamedTuple):
    """Dimensions [m] of an arm with an offset wrist, along e, f, h: f is the direction of axis 5, e = f x h."""

    frame: Array  # (3, 3) rows e, f, h in the base frame, at zero
    foot: Array  # (3,) of axis 1
    shoulder: Array  # (3,) from there to axis 2, in e, f, h
    arms: tuple[Array, Array]  # (2,) upper arm and forearm in e, f
    wrist: Array  # (3,) from axis 4 to the crossing of axes 5 and 6, in e, f, h
    flange: float  # from that crossing to the flange, along h
    turned: Array  # (3, 3) of the flange at zero, transposed


@lru_cache(maxsize=64)
def offset_wrist_of(geometry: Geometry) -> OffsetWrist | None:
    """The dimensions of an arm with an offset wrist, None for all others."""
    joints = geometry.joints
    if len(joints) != 6 or [joint.axis for joint in joints] != list(range(6)):
        return None
    directions = np.array([joint.direction for joint in joints])
    offsets = np.array([*(joint.offset for joint in joints), geometry.flange_offset])
    h, fifth = directions[1], directions[4]
    frame = np.stack((np.cross(fifth, h), fifth, h))
    parallel = np.abs(directions[[2, 3, 5]] - h).max() < _EXACT
    square = abs(h @ _UP) < _EXACT and abs(fifth @ h) < _EXACT
    upright = np.abs(directions[0] - _UP).max() < _EXACT
    # Axes 5 and 6 cross, and the flange is on axis 6.
    crossing = np.abs(np.cross(offsets[5], fifth)).max() < _EXACT
    ahead = np.abs(np.cross(offsets[6], h)).max() < _EXACT
    if not (parallel and square and upright and crossing and ahead):
        return None
    seen = offsets @ frame.T
    return OffsetWrist(
        frame,
        offsets[0],
        seen[1] + np.array([0.0, 0.0, seen[2, 2] + seen[3, 2]]),
        (seen[2, :2], seen[3, :2]),
        seen[4] + seen[5],
        float(seen[6, 2]),
        np.array(geometry.flange_rotation).T,
    )


def solutions(arm: OffsetWrist, position: Array, rotation: Array, sixth: Array) -> Array:
    """All solutions (n, 8, 6) [rad] of flange poses (n, 3) [m], (n, 3, 3), each angle in [-180, 180] deg; nan for
    none.

    Index = 4 (side on which the arm passes axis 1) + 2 (sign of axis 5) + 1 (sign of the elbow). Where axes 4 and 6
    are parallel, axis 6 is `sixth` (n,).
    """
    turned = rotation @ arm.turned
    crossing = position - arm.flange * (turned @ arm.frame[2]) - arm.foot
    found = np.empty((len(position), 8, 6))
    with np.errstate(invalid="ignore"):
        for number, (side, flip, elbow) in enumerate(itertools.product((1.0, -1.0), repeat=3)):
            found[:, number] = _solution(arm, crossing, turned, sixth, (side, flip, elbow))
    found[np.isnan(found).any(axis=2)] = np.nan
    return np.remainder(found + np.pi, 2.0 * np.pi) - np.pi


def _solution(
    arm: OffsetWrist, crossing: Array, turned: Array, sixth: Array, signs: tuple[float, float, float]
) -> Array:
    """The solution (n, 6) of one branch."""
    side, flip, elbow = signs
    first = _first(arm, crossing, side)
    cosine, sine = np.cos(first), np.sin(first)
    # Rows are e, f, h as they stand after axis 1 has turned, in the base frame.
    rows = _about_up(arm.frame, cosine, sine)
    point = np.einsum("nij,nj->ni", rows, crossing) - arm.shoulder
    within = np.einsum("nij,njk,lk->nil", rows, turned, arm.frame)  # the flange, from e, f, h to e, f, h
    fifth = flip * np.arctan2(np.hypot(within[:, 0, 2], within[:, 1, 2]), within[:, 2, 2])
    last = np.arctan2(flip * within[:, 2, 1], -flip * within[:, 2, 0])
    last = np.where(np.abs(np.sin(fifth)) < STRAIGHT_WRIST, sixth, last)
    total = _sum_of_middle(within, last)
    reach = np.stack((np.cos(total), -np.sin(total), np.sin(total), np.cos(total)), axis=-1).reshape(-1, 2, 2)
    goal = point[:, :2] - reach @ arm.wrist[:2]
    second, third = _two_links(arm.arms, goal, elbow)
    return np.stack((first, second, third, total - second - third, fifth, last), axis=1)


def _first(arm: OffsetWrist, crossing: Array, side: float) -> Array:
    """Axis 1: turning about it, the crossing of axes 5 and 6 keeps its distance from the arm's plane."""
    across = arm.shoulder[2] + arm.wrist[2]
    x, y, _ = arm.frame[2]
    away = np.hypot(crossing[:, 0], crossing[:, 1])
    lean = np.arccos(across / np.where(away > 0.0, away, np.nan))
    first: Array = np.arctan2(crossing[:, 1], crossing[:, 0]) - np.arctan2(y, x) + side * lean
    return first


def _about_up(frame: Array, cosine: Array, sine: Array) -> Array:
    """Rows of `frame`, each turned about the vertical (n, 3, 3)."""
    x, y, z = (np.broadcast_to(frame[:, i], (len(cosine), 3)) for i in range(3))
    c, s = cosine[:, None], sine[:, None]
    return np.stack((c * x - s * y, s * x + c * y, z), axis=2)


def _sum_of_middle(within: Array, last: Array) -> Array:
    """Axes 2 + 3 + 4: the angle about h by which the direction f of axis 5 has turned."""
    fifth = within[:, :, 0] * np.sin(last)[:, None] + within[:, :, 1] * np.cos(last)[:, None]
    total: Array = np.arctan2(-fifth[:, 0], fifth[:, 1])
    return total


def _two_links(arms: tuple[Array, Array], goal: Array, elbow: float) -> tuple[Array, Array]:
    """Axes 2 and 3 [rad] with which the two links end at `goal` (n, 2)."""
    upper, fore = arms
    one, two = float(np.hypot(*upper)), float(np.hypot(*fore))
    bend = (np.sum(goal * goal, axis=1) - one * one - two * two) / (2.0 * one * two)
    bend = np.where(np.abs(bend) > 1.0 + _STRETCHED, np.nan, np.clip(bend, -1.0, 1.0))
    third = elbow * np.arccos(bend) + np.arctan2(upper[1], upper[0]) - np.arctan2(fore[1], fore[0])
    c, s = np.cos(third), np.sin(third)
    tip_x, tip_y = upper[0] + c * fore[0] - s * fore[1], upper[1] + s * fore[0] + c * fore[1]
    return np.arctan2(goal[:, 1], goal[:, 0]) - np.arctan2(tip_y, tip_x), third
