"""Arcs that one statement describes: from where the arm stands, through a via point, to a target.

The plan tells an arc by a third point beyond its target, as jobs do that chain circular moves. Here that point is made:
on the same circle, as far beyond the target as the way back to the start leaves.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from olp.runtime.paths import circle, swept_angle
from olp.runtime.plan import Moves, Positions

if TYPE_CHECKING:
    from olp.runtime.columns import Extra

Floats = NDArray[np.float64]


def beyond_targets(
    positions: Positions, moves: Moves, extras: Mapping[int, Extra]
) -> tuple[Positions, Moves, dict[int, int]]:
    """Positions with the added points, moves whose target an angle replaces, and row -> added point.

    `extras`: rows with a via point. Rows on no circle (three points on a line) get none: they run straight.
    """
    added: list[Floats] = []
    turns: list[Floats] = []
    axes: list[Floats] = []
    third: dict[int, int] = {}
    start, target = moves.start.copy(), moves.target.copy()
    count = len(positions)

    def add(point: Floats, like: int) -> int:
        added.append(point)
        turns.append(positions.quaternion[like])
        axes.append(np.full(positions.axes.shape[1], np.nan))
        return count + len(added) - 1

    def point(index: int) -> Floats:
        return positions.position[index][None] if index < count else added[index - count][None]

    for row, extra in extras.items():
        a, b = point(start[row]), point(extra.via)  # after an arc with an angle the start is an added point
        end = int(target[row])
        c = positions.position[end][None]
        centre, radius, axis = circle(a, b, c)
        if not np.isfinite(radius[0]):
            continue
        swept = float(swept_angle(a - centre, c - centre, axis)[0])
        if not np.isnan(extra.arc):
            swept = extra.arc
            target[row] = add(_turned(a, centre, axis, swept), end)
            following = np.flatnonzero((moves.mechanism == moves.mechanism[row]) & (moves.start == end))
            following = following[following > row][:1]
            start[following] = target[row]
        third[row] = add(_turned(a, centre, axis, swept + (2 * np.pi - swept % (2 * np.pi)) / 2), end)
    if not added:
        return positions, moves, third
    grown = Positions(
        np.concatenate([positions.position, np.array(added)]),
        np.concatenate([positions.quaternion, np.array(turns)]),
        np.concatenate([positions.axes, np.array(axes)]),
    )
    return grown, replace(moves, start=start, target=target), third


def _turned(point: Floats, centre: Floats, axis: Floats, angle: float) -> Floats:
    """(3,) [m]: a point (1, 3) turned about the circle's axis."""
    spoke = point - centre
    turned = spoke * np.cos(angle) + np.cross(axis, spoke) * np.sin(angle)
    result: Floats = (centre + turned)[0]
    return result
