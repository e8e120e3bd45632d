"""All solutions of an arm whose axes 2, 3 and 4 are parallel, its wrist offset (Universal Robots), in closed form.

Axis 1 stands upright; axes 2, 3, 4 and, at zero, 6 lie along one direction h; axis 5 is square to it and meets 6. Then

- the way of axes 5 and 6's crossing along h does not depend on axes 2 to 6: it gives axis 1, in two ways;
- the angle between axis 6 and h gives axis 5, in two ways, and h as the flange sees it axis 6;
- what is left is a turn about h, the sum of axes 2, 3 and 4, and two links in a plane: axis 3 in two ways.

(K. Hawkins, "Analytic inverse kinematics for the Universal Robots UR-5/UR-10 arms", 2013, has the same steps.)
"""

from __future__ import annotations

import itertools
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from olp.robots.kinematics.spherical import STRAIGHT_WRIST
from olp.robots.model import Geometry

Array = NDArray[np.float64]

_EXACT = 1e-12  # [m, 1] rounding of the robot file's numbers
_STRETCHED = 1e-9  # [1] by which the cosine of a stretched elbow may leave [-1, 1]
_UP = np.array([0.0, 0.0, 1.0])


class OffsetWrist(NamedTuple):
    """The numbers of such an arm [m], seen along e, f, h: f is the direction of axis 5, e = f x h."""

    frame: Array  # (3, 3) rows e, f, h in the base frame, at zero
    foot: Array  # (3,) of axis 1
    shoulder: Array  # (3,) from there to axis 2, in e, f, h
    arms: tuple[Array, Array]  # (2,) upper arm and forearm in e, f
    wrist: Array  # (3,) from axis 4 to the crossing of axes 5 and 6, in e, f, h
    flange: float  # from that crossing to the flange, along h
    turned: Array  # (3, 3) of the flange at zero, transposed


@lru_cache(maxsize=64)
def offset_wrist_of(geometry: Geometry) -> OffsetWrist | None:
    """The numbers of an arm of this kind, None for all others."""
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
    """(n, 8, 6) [rad] of flange poses (n, 3) [m], (n, 3, 3), each angle in [-180, 180] deg; nan where there is none.

    Numbered 4 by the side on which the arm passes axis 1, 2 by the sign of axis 5, 1 by that of the elbow. Where
    axes 4 and 6 are parallel, axis 6 is `sixth` (n,).
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
    """(n, 6) of one branch."""
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
    """Axis 1: about it the crossing keeps its distance from the plane through it across h."""
    across = arm.shoulder[2] + arm.wrist[2]
    x, y, _ = arm.frame[2]
    away = np.hypot(crossing[:, 0], crossing[:, 1])
    lean = np.arccos(across / np.where(away > 0.0, away, np.nan))
    first: Array = np.arctan2(crossing[:, 1], crossing[:, 0]) - np.arctan2(y, x) + side * lean
    return first


def _about_up(frame: Array, cosine: Array, sine: Array) -> Array:
    """(n, 3, 3) rows of `frame`, each turned about the upright."""
    x, y, z = (np.broadcast_to(frame[:, i], (len(cosine), 3)) for i in range(3))
    c, s = cosine[:, None], sine[:, None]
    return np.stack((c * x - s * y, s * x + c * y, z), axis=2)


def _sum_of_middle(within: Array, last: Array) -> Array:
    """Axes 2 + 3 + 4: where the direction of axis 5, f, has been turned to about h."""
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
